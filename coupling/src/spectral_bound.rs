//! Largest eigenfrequency of $K u = \omega^2 M u$ from products with $K$ alone.

use crate::CouplingError;
use nalgebra::{DMatrix, SymmetricEigen};

/// Largest eigenfrequency $\omega_{\max}$, rad/s, of a symmetric positive semi-definite stiffness with
/// a diagonal mass, by Lanczos with full reorthogonalisation.
///
/// - `mass`: lumped masses, kg, all positive;
/// - `internal_force(u, f)`: writes $f = K u$;
/// - `tolerance`: relative, on $\omega_{\max}$; the value returned is the Ritz value plus its residual,
///   so it errs to the safe side (a smaller step) by no more than the tolerance.
///
/// Cost: a few tens of products for a mesh of any size, since the largest eigenvalue of a spectral
/// element operator is well separated. Errors: a mass that is not positive; no convergence.
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
    let steps_max = n.min(400);
    let mut basis: Vec<Vec<f64>> = vec![start_vector(n)];
    let (mut alpha, mut beta): (Vec<f64>, Vec<f64>) = (vec![], vec![]);
    let (mut u, mut f) = (vec![0.0; n], vec![0.0; n]);
    let mut residual = f64::INFINITY;
    for step in 0..steps_max {
        let q = &basis[step];
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
        if step % 4 == 3 || last || norm == 0.0 {
            let (ritz, tail) = largest_ritz(&alpha, &beta);
            residual = if last && steps_max == n { 0.0 } else { norm * tail / ritz.max(f64::MIN_POSITIVE) };
            // a residual r of the eigenvalue is r/2 on the frequency
            if residual <= 2.0 * tolerance {
                return Ok((ritz * (1.0 + residual)).sqrt());
            }
        }
        if norm <= f64::EPSILON * alpha[0].abs() {
            let (ritz, _) = largest_ritz(&alpha, &beta);
            return Ok(ritz.sqrt());
        }
        beta.push(norm);
        w.iter_mut().for_each(|w| *w /= norm);
        basis.push(w);
    }
    Err(CouplingError::SpectralBound { tolerance, iterations: steps_max, residual })
}

/// Rough and non-symmetric, so that no eigenvector of a symmetric mesh is missed; unit length.
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

/// Largest eigenvalue of the tridiagonal matrix and the modulus of its eigenvector's last entry.
fn largest_ritz(alpha: &[f64], beta: &[f64]) -> (f64, f64) {
    let m = alpha.len();
    let t = DMatrix::from_fn(m, m, |i, j| match i.abs_diff(j) {
        0 => alpha[i],
        1 => beta[i.min(j)],
        _ => 0.0,
    });
    let eigen = SymmetricEigen::new(t);
    let best = eigen.eigenvalues.imax();
    (eigen.eigenvalues[best], eigen.eigenvectors[(m - 1, best)].abs())
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

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
