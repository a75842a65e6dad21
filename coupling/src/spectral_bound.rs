//! Largest eigenfrequency of $K u = \omega^2 M u$ from products with $K$ alone.

use crate::CouplingError;

/// Largest eigenfrequency $\omega_{\max}$, rad/s, of a symmetric positive semi-definite stiffness with
/// a diagonal mass, by Lanczos with full reorthogonalisation.
///
/// - `mass`: lumped masses, kg, all positive;
/// - `internal_force(u, f)`: writes $f = K u$;
/// - `tolerance`: relative, on $\omega_{\max}$; the value returned is the Ritz value plus its residual.
///
/// A small residual alone tells that *an* eigenvalue is near, and where the largest ones lie close together the
/// iteration rests at the second largest before it finds the largest. It therefore takes at least
/// $$ m \ge \frac{\ln(1.648\sqrt{n}/\delta)}{2\sqrt{\varepsilon}} + \tfrac12 $$
/// steps, after which a start by chance leaves an error of the eigenvalue above $\varepsilon$ with a probability below
/// $\delta$ = 1e-3, whatever the spectrum (Kuczyński & Woźniakowski 1992); $\varepsilon$ is twice the tolerance, but no less
/// than what [`STEPS_MAX`]/2 steps give.
///
/// Cost: m products with K for m steps, m at most [`STEPS_MAX`]. Up to [`REORTHOGONAL_MAX`] freedoms all
/// vectors are kept and made orthogonal again (m²n operations, memory m n); beyond, only the last two are,
/// the others lose their orthogonality, and copies of converged Ritz values appear: the largest one and
/// its residual stay right (Paige 1980), at the price of some more steps. Where one element sets the limit
/// alone, its eigenvalue is separated and a few tens of steps do; the upper spectrum of a uniform mesh is
/// dense, and m grows towards the limit. Errors: a mass that is not positive; no convergence within the
/// steps.
pub fn omega_max(
    mass: &[f64],
    mut internal_force: impl FnMut(&[f64], &mut [f64]),
    tolerance: f64,
) -> Result<f64, CouplingError> {
    let n = mass.len();
    if let Some((index, &mass)) = mass.iter().enumerate().find(|&(_, &m)| !(m > 0.0 && m.is_finite())) {
        return Err(CouplingError::Massless { index, mass });
    }
    let root: Vec<f64> = mass.iter().map(|m| m.sqrt()).collect();
    let steps_max = n.min(STEPS_MAX);
    let steps_min = steps_to_trust(n, 2.0 * tolerance).min(STEPS_MAX / 2);
    let mut basis: Vec<Vec<f64>> = vec![start_vector(n)];
    let (mut alpha, mut beta): (Vec<f64>, Vec<f64>) = (vec![], vec![]);
    let (mut u, mut f) = (vec![0.0; n], vec![0.0; n]);
    let mut residual = f64::INFINITY;
    // tests at growing intervals: each costs m² at most, far less than the steps between two of them
    let mut due = 4;
    for step in 0..steps_max {
        let q = &basis[basis.len() - 1];
        for i in 0..n {
            u[i] = q[i] / root[i];
        }
        internal_force(&u, &mut f);
        let mut w: Vec<f64> = (0..n).map(|i| f[i] / root[i]).collect();
        alpha.push(dot(&w, q));
        // twice is enough (Kahan, Parlett)
        for _ in 0..2 {
            for q in &basis {
                let c = dot(&w, q);
                w.iter_mut().zip(q).for_each(|(w, q)| *w -= c * q);
            }
        }
        let norm = dot(&w, &w).sqrt();
        let last = step + 1 == steps_max;
        if step + 1 == due || last || norm == 0.0 {
            due += due.div_ceil(8);
            let (ritz, tail) = largest_ritz(&alpha, &beta);
            residual = if last && steps_max == n { 0.0 } else { norm * tail / ritz.max(f64::MIN_POSITIVE) };
            // a residual r of the eigenvalue is r/2 on the frequency
            if residual <= 2.0 * tolerance && (step >= steps_min || last) {
                return Ok((ritz * (1.0 + residual)).sqrt());
            }
        }
        if norm <= f64::EPSILON * alpha[0].abs() {
            let (ritz, _) = largest_ritz(&alpha, &beta);
            return Ok(ritz.sqrt());
        }
        beta.push(norm);
        w.iter_mut().for_each(|w| *w /= norm);
        if n > REORTHOGONAL_MAX && basis.len() == 2 {
            basis.remove(0);
        }
        basis.push(w);
    }
    Err(CouplingError::SpectralBound { tolerance, iterations: steps_max, residual })
}

/// Most freedoms whose Lanczos vectors are all kept: 64 MB of them at most.
const REORTHOGONAL_MAX: usize = 20_000;

/// Most Lanczos steps.
const STEPS_MAX: usize = 400;

/// Steps after which the largest eigenvalue of n is within `epsilon`, relative, but for one start in a thousand.
fn steps_to_trust(n: usize, epsilon: f64) -> usize {
    const DOUBT: f64 = 1e-3;
    let steps = (1.648 * (n as f64).sqrt() / DOUBT).ln() / (2.0 * epsilon.sqrt()) + 0.5;
    steps.ceil().min(STEPS_MAX as f64) as usize
}

/// Unit length; by chance, but with alternating signs: rougher than chance alone would have it, which favours the
/// largest eigenvalues of a mesh, and not symmetric, so that no eigenvector of a symmetric mesh is missed.
fn start_vector(n: usize) -> Vec<f64> {
    let mut seed = 0x9e37_79b9_7f4a_7c15_u64;
    let mut q: Vec<f64> = (0..n)
        .map(|i| {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            let noise = (seed >> 11) as f64 / (1u64 << 53) as f64;
            (if i % 2 == 0 { 1.0 } else { -1.0 }) * (0.5 + noise)
        })
        .collect();
    let norm = dot(&q, &q).sqrt();
    q.iter_mut().for_each(|q| *q /= norm);
    q
}

/// Largest eigenvalue of the tridiagonal matrix T, and the modulus of the last entry of its eigenvector
/// of unit length; some fifty times m operations.
///
/// λ by bisection between the largest diagonal entry and Gershgorin's bound: it lies above all
/// eigenvalues where every pivot of T − λ is negative. The eigenvector by a twisted factorisation: pivots
/// from both ends meet where the eigenvector is large, and from there it is followed to its ends.
fn largest_ritz(alpha: &[f64], beta: &[f64]) -> (f64, f64) {
    let m = alpha.len();
    let is_above = |lambda: f64| {
        let mut above = f64::INFINITY;
        (0..m).all(|i| {
            let coupled = if i > 0 { beta[i - 1] * beta[i - 1] / above } else { 0.0 };
            above = alpha[i] - lambda - coupled;
            above < 0.0
        })
    };
    let mut low = alpha.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let mut high = (0..m)
        .map(|i| alpha[i] + beta.get(i).unwrap_or(&0.0) + if i > 0 { beta[i - 1] } else { 0.0 })
        .fold(f64::NEG_INFINITY, f64::max);
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            break;
        }
        if is_above(middle) { high = middle } else { low = middle }
    }
    let (from_top, from_bottom) = pivots(alpha, beta, high);
    let meet = |i: usize| (from_top[i] + from_bottom[i] - (alpha[i] - high)).abs();
    let twist = (0..m).min_by(|&a, &b| meet(a).total_cmp(&meet(b))).unwrap_or(0);
    let (mut entry, mut square) = (1.0, 1.0);
    for i in (0..twist).rev() {
        entry *= beta[i] / from_top[i];
        square += entry * entry;
    }
    entry = 1.0;
    for i in twist + 1..m {
        entry *= beta[i - 1] / from_bottom[i];
        square += entry * entry;
    }
    (high, entry.abs() / square.sqrt())
}

/// Pivots of T − λ eliminated from the top and from the bottom; none is zero.
fn pivots(alpha: &[f64], beta: &[f64], lambda: f64) -> (Vec<f64>, Vec<f64>) {
    let m = alpha.len();
    let not_zero = |x: f64| if x == 0.0 { -f64::MIN_POSITIVE } else { x };
    let (mut top, mut bottom) = (vec![0.0; m], vec![0.0; m]);
    for i in 0..m {
        let coupled = if i > 0 { beta[i - 1] * beta[i - 1] / top[i - 1] } else { 0.0 };
        top[i] = not_zero(alpha[i] - lambda - coupled);
    }
    for i in (0..m).rev() {
        let coupled = if i + 1 < m { beta[i] * beta[i] / bottom[i + 1] } else { 0.0 };
        bottom[i] = not_zero(alpha[i] - lambda - coupled);
    }
    (top, bottom)
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{DMatrix, SymmetricEigen};

    #[test]
    fn chain_of_equal_masses_against_its_closed_form() {
        // free–free chain, k = m = 1: ω² = 4 sin²(π k / 2n)
        for n in [2_usize, 3, 10, 57, 300] {
            let omega = omega_max(
                &vec![1.0; n],
                |u, f| {
                    f.fill(0.0);
                    for i in 0..n - 1 {
                        let s = u[i + 1] - u[i];
                        f[i] -= s;
                        f[i + 1] += s;
                    }
                },
                1e-6,
            )
            .unwrap();
            let exact = 2.0 * (std::f64::consts::PI * (n - 1) as f64 / (2 * n) as f64).sin();
            assert!((omega / exact - 1.0).abs() < 1e-6, "n = {n}: {omega} against {exact}");
        }
    }

    #[test]
    fn the_largest_ritz_pair_is_that_of_the_dense_solver() {
        for m in [1_usize, 2, 3, 8, 40, 120] {
            let wave = |i: usize, f: f64| (f * (i + 1) as f64).sin();
            let alpha: Vec<f64> = (0..m).map(|i| 3.0 + wave(i, 1.7)).collect();
            let beta: Vec<f64> = (0..m - 1).map(|i| 0.8 + 0.5 * wave(i, 2.9)).collect();
            let dense = SymmetricEigen::new(DMatrix::from_fn(m, m, |i, j| match i.abs_diff(j) {
                0 => alpha[i],
                1 => beta[i.min(j)],
                _ => 0.0,
            }));
            let best = dense.eigenvalues.imax();
            let (ritz, tail) = largest_ritz(&alpha, &beta);
            assert!((ritz / dense.eigenvalues[best] - 1.0).abs() < 1e-13, "m = {m}: {ritz}");
            let exact = dense.eigenvectors[(m - 1, best)].abs();
            assert!((tail - exact).abs() < 1e-10, "m = {m}: {tail} against {exact}");
        }
    }

    #[test]
    fn two_vectors_do_for_many_freedoms() {
        // one stiff spring among soft ones sets the limit; the rest is dense
        let (n, stiff) = (REORTHOGONAL_MAX + 1000, 777);
        let spring = |i: usize| if i == stiff { 9.0 } else { 1.0 + 0.3 * ((i % 17) as f64 / 17.0) };
        let omega = omega_max(
            &vec![1.0; n],
            |u, f| {
                f.fill(0.0);
                for i in 0..n - 1 {
                    let s = spring(i) * (u[i + 1] - u[i]);
                    f[i] -= s;
                    f[i + 1] += s;
                }
            },
            1e-4,
        )
        .unwrap();
        // two masses joined by k, each held by springs of about 1.2: a little above 2k
        let few = omega_max(
            &vec![1.0; 400],
            |u, f| {
                f.fill(0.0);
                for i in 0..399 {
                    let s = spring(i + stiff - 200) * (u[i + 1] - u[i]);
                    f[i] -= s;
                    f[i + 1] += s;
                }
            },
            1e-6,
        )
        .unwrap();
        assert!((omega / few - 1.0).abs() < 2e-4, "{omega} against {few}");
    }

    #[test]
    fn the_second_largest_eigenvalue_does_not_pass_for_the_largest() {
        // the two lie 1.5 % apart above a dense rest; where the largest stands decides how the start meets it
        let (n, tolerance) = (600_usize, 3e-3);
        for place in 0..200_usize {
            let value = |i: usize| match (i + n - 3 * place) % n {
                0 => 1.0,
                1 => 0.985,
                j => 0.97 * (j as f64 / n as f64).sqrt(),
            };
            let omega =
                omega_max(&vec![1.0; n], |u, f| (0..n).for_each(|i| f[i] = value(i) * u[i]), tolerance)
                    .unwrap();
            assert!((omega - 1.0).abs() <= tolerance, "place {place}: {omega}");
        }
    }

    #[test]
    fn no_convergence_is_told_as_that() {
        // a long uniform chain has a dense upper spectrum: 400 steps do not separate it to 1e-12
        let n = 5000;
        let error = omega_max(
            &vec![1.0; n],
            |u, f| {
                for i in 0..n {
                    let (left, right) = (if i > 0 { u[i - 1] } else { 0.0 }, u.get(i + 1).unwrap_or(&0.0));
                    f[i] = 2.0 * u[i] - left - right;
                }
            },
            1e-12,
        )
        .unwrap_err();
        assert!(matches!(error, CouplingError::SpectralBound { iterations: 400, .. }), "{error}");
        assert!(error.to_string().contains("close together"), "{error}");
    }

    #[test]
    fn a_single_freedom() {
        let omega = omega_max(&[2.0], |u, f| f[0] = 8.0 * u[0], 1e-9).unwrap();
        assert!((omega - 2.0).abs() < 1e-12);
    }

    #[test]
    fn a_massless_freedom_is_named() {
        let error = omega_max(&[1.0, 0.0], |_, _| (), 1e-6).unwrap_err();
        assert!(error.to_string().contains("freedom 1"), "{error}");
    }
}
