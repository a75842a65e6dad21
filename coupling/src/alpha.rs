//! The α family of implicit schemes, one freedom at a time: Chung and Hulbert's scheme and its relatives.
//!
//! With $u_p = u + \Delta t\,v + \Delta t^2(\tfrac12-\beta)a$ and $v_p = v + \Delta t(1-\gamma)a$ one step is
//!
//! $$u^+ = u_p + \beta\Delta t^2 a^+,\qquad v^+ = v_p + \gamma\Delta t\,a^+,$$
//! $$M\big[(1-\alpha_m)a^+ + \alpha_m a\big] + C\,v_\alpha + K u_\alpha = f_\alpha ,\qquad
//!   x_\alpha = (1-\alpha_f)x^+ + \alpha_f x ,$$
//!
//! loads and multipliers weighted like $f_\alpha$. Solved for the acceleration,
//! $\tilde M a^+ = f_\alpha - \alpha_m M a - C\,[(1-\alpha_f)v_p + \alpha_f v] - K[(1-\alpha_f)u_p + \alpha_f u]$ with
//! $\tilde M = (1-\alpha_m)M + (1-\alpha_f)(\gamma\Delta t\,C + \beta\Delta t^2K)$: [`AlphaScheme::operator`],
//! [`AlphaScheme::predict`] and [`Predicted::correct`] are these three lines. All second order in $u$ and $v$
//! but Newmark with $\gamma \ne \tfrac12$.
//!
//! Sources: Newmark (1959); Hilber, Hughes and Taylor (1977); Wood, Bossak and Zienkiewicz (1980); Chung and
//! Hulbert (1993).

use crate::CouplingError;
use nalgebra::Matrix3;

/// Parameters of a scheme of the family.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AlphaScheme {
    alpha_m: f64,
    alpha_f: f64,
    gamma: f64,
    beta: f64,
}

/// Factors on M, C and K in the operator $\tilde M$ of a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OperatorWeights {
    /// $1-\alpha_m$.
    pub mass: f64,
    /// $(1-\alpha_f)\gamma\Delta t$, s.
    pub damping: f64,
    /// $(1-\alpha_f)\beta\Delta t^2$, s².
    pub stiffness: f64,
}

/// A freedom predicted over a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Predicted {
    /// $u_p$, m.
    pub position: f64,
    /// $v_p$, m/s.
    pub velocity: f64,
    /// $(1-\alpha_f)u_p + \alpha_f u$, where the internal force is taken, m.
    pub position_alpha: f64,
    /// $(1-\alpha_f)v_p + \alpha_f v$, where the viscous force is taken, m/s.
    pub velocity_alpha: f64,
}

impl AlphaScheme {
    /// The scheme of least loss at low frequency for a spectral radius $\rho_\infty$ at infinite frequency:
    /// $\alpha_m = (2\rho_\infty-1)/(\rho_\infty+1)$, $\alpha_f = \rho_\infty/(\rho_\infty+1)$.
    /// 1 is the trapezoidal rule's accuracy without loss, 0 removes a high mode in one step.
    /// Errors: outside [0, 1].
    pub fn chung_hulbert(rho: f64) -> Result<Self, CouplingError> {
        within("rho_inf", rho, 0.0, 1.0)?;
        Ok(Self::second_order((2.0 * rho - 1.0) / (rho + 1.0), rho / (rho + 1.0)))
    }

    /// Hilber, Hughes and Taylor: $\alpha_m = 0$, $\alpha_f = (1-\rho_\infty)/(1+\rho_\infty)$.
    /// Errors: outside [½, 1].
    pub fn hilber_hughes_taylor(rho: f64) -> Result<Self, CouplingError> {
        within("rho_inf", rho, 0.5, 1.0)?;
        Ok(Self::second_order(0.0, (1.0 - rho) / (1.0 + rho)))
    }

    /// Wood, Bossak and Zienkiewicz: $\alpha_f = 0$, $\alpha_m = (\rho_\infty-1)/(\rho_\infty+1)$.
    /// Errors: outside [0, 1].
    pub fn wood_bossak_zienkiewicz(rho: f64) -> Result<Self, CouplingError> {
        within("rho_inf", rho, 0.0, 1.0)?;
        Ok(Self::second_order((rho - 1.0) / (rho + 1.0), 0.0))
    }

    /// Newmark's scheme. Stable at every step where $2\beta \ge \gamma \ge \tfrac12$; others are refused, since an
    /// explicit step belongs to [`crate::central_difference`]. First order where $\gamma > \tfrac12$.
    pub fn newmark(beta: f64, gamma: f64) -> Result<Self, CouplingError> {
        within("gamma", gamma, 0.5, 1.5)?;
        within("beta", beta, 0.5 * gamma, 2.0)?;
        Ok(Self { alpha_m: 0.0, alpha_f: 0.0, gamma, beta })
    }

    /// Newmark with β = ¼, γ = ½: no loss, second order, positions and velocities exact in energy.
    pub fn trapezoidal() -> Self {
        Self::second_order(0.0, 0.0)
    }

    /// γ of second order, β of the largest loss at high frequency.
    fn second_order(alpha_m: f64, alpha_f: f64) -> Self {
        let shift = alpha_f - alpha_m;
        Self { alpha_m, alpha_f, gamma: 0.5 + shift, beta: 0.25 * (1.0 + shift) * (1.0 + shift) }
    }

    /// $\alpha_m$.
    pub fn alpha_m(&self) -> f64 {
        self.alpha_m
    }

    /// $\alpha_f$.
    pub fn alpha_f(&self) -> f64 {
        self.alpha_f
    }

    /// $\gamma$.
    pub fn gamma(&self) -> f64 {
        self.gamma
    }

    /// $\beta$.
    pub fn beta(&self) -> f64 {
        self.beta
    }

    /// Factors that make the operator of a step of `dt` seconds.
    pub fn operator(&self, dt: f64) -> OperatorWeights {
        let share = 1.0 - self.alpha_f;
        OperatorWeights {
            mass: 1.0 - self.alpha_m,
            damping: share * self.gamma * dt,
            stiffness: share * self.beta * dt * dt,
        }
    }

    /// Predicts a freedom from its state at the step's start.
    #[inline(always)]
    pub fn predict(&self, dt: f64, u: f64, v: f64, a: f64) -> Predicted {
        let position = u + dt * (v + dt * (0.5 - self.beta) * a);
        let velocity = v + dt * (1.0 - self.gamma) * a;
        Predicted {
            position,
            velocity,
            position_alpha: self.weighted(u, position),
            velocity_alpha: self.weighted(v, velocity),
        }
    }

    /// Position and velocity at the step's end, of a freedom predicted as ($u_p$, $v_p$), from the new acceleration.
    #[inline(always)]
    pub fn correct(&self, dt: f64, position: f64, velocity: f64, a: f64) -> (f64, f64) {
        (position + dt * dt * self.beta * a, velocity + dt * self.gamma * a)
    }

    /// $(1-\alpha_f)x^+ + \alpha_f x$: a load, multiplier, position or velocity at the instant of balance.
    #[inline(always)]
    pub fn weighted(&self, before: f64, after: f64) -> f64 {
        (1.0 - self.alpha_f) * after + self.alpha_f * before
    }

    /// What one step makes of $(u, \Delta t\,v, \Delta t^2 a)$ of an oscillator of damping ratio `xi` with
    /// $\Omega = \omega\Delta t$: the scheme's own update, on the three unit states.
    pub fn amplification(&self, big_omega: f64, xi: f64) -> Matrix3<f64> {
        let (stiffness, damping) = (big_omega * big_omega, 2.0 * xi * big_omega);
        let w = self.operator(1.0);
        let operator = w.mass + w.damping * damping + w.stiffness * stiffness;
        let column = |j: usize| {
            let [u, v, a] = std::array::from_fn(|i| f64::from(u8::from(i == j)));
            let p = self.predict(1.0, u, v, a);
            let force = -self.alpha_m * a - damping * p.velocity_alpha - stiffness * p.position_alpha;
            let after = force / operator;
            let (u, v) = self.correct(1.0, p.position, p.velocity, after);
            [u, v, after]
        };
        let columns = [column(0), column(1), column(2)];
        Matrix3::from_fn(|i, j| columns[j][i])
    }

    /// Largest modulus of the eigenvalues of [`Self::amplification`]: at most 1 for every Ω.
    pub fn spectral_radius(&self, big_omega: f64, xi: f64) -> f64 {
        self.amplification(big_omega, xi).complex_eigenvalues().iter().map(|z| z.norm()).fold(0.0, f64::max)
    }
}

fn within(name: &'static str, value: f64, low: f64, high: f64) -> Result<(), CouplingError> {
    if (low..=high).contains(&value) {
        return Ok(());
    }
    Err(CouplingError::SchemeParameter { name, value, low, high })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    /// All presets, with ρ∞.
    fn schemes() -> Vec<(AlphaScheme, f64)> {
        let mut all =
            vec![(AlphaScheme::trapezoidal(), 1.0), (AlphaScheme::newmark(0.3025, 0.6).unwrap(), 0.0)];
        for i in 0..=10 {
            let rho = 0.1 * i as f64;
            all.push((AlphaScheme::chung_hulbert(rho).unwrap(), rho));
            all.push((AlphaScheme::wood_bossak_zienkiewicz(rho).unwrap(), rho));
            if i >= 5 {
                all.push((AlphaScheme::hilber_hughes_taylor(rho).unwrap(), rho));
            }
        }
        all
    }

    /// Coefficients of the characteristic cubic, highest first, from the scheme's multistep form:
    /// $(z-1)u = v + (\tfrac12-\beta+\beta z)a$, $(z-1)v = (1-\gamma+\gamma z)a$ and the weighted balance.
    fn multistep(s: &AlphaScheme, big_omega: f64, xi: f64) -> [f64; 4] {
        let product = |p: [f64; 2], q: [f64; 3]| {
            [p[0] * q[0], p[0] * q[1] + p[1] * q[0], p[0] * q[2] + p[1] * q[1], p[1] * q[2]]
        };
        let mass = product([1.0 - s.alpha_m, s.alpha_m], [1.0, -2.0, 1.0]);
        let weights = [1.0 - s.alpha_f, s.alpha_f];
        // (z − 1)² u over a, and (z − 1)² v over a
        let half = 0.5 - s.beta;
        let position = [s.beta, s.gamma + half - s.beta, 1.0 - s.gamma - half];
        let velocity = [s.gamma, 1.0 - 2.0 * s.gamma, s.gamma - 1.0];
        let (stiffness, damping) = (product(weights, position), product(weights, velocity));
        std::array::from_fn(|i| {
            mass[i] + big_omega * big_omega * stiffness[i] + 2.0 * xi * big_omega * damping[i]
        })
    }

    /// Largest root of a cubic by the companion matrix.
    fn largest_root(p: [f64; 4]) -> f64 {
        let m = Matrix3::new(-p[1] / p[0], -p[2] / p[0], -p[3] / p[0], 1.0, 0.0, 0.0, 0.0, 1.0, 0.0);
        m.complex_eigenvalues().iter().map(|z| z.norm()).fold(0.0, f64::max)
    }

    #[test]
    fn characteristic_polynomial_is_that_of_the_multistep_form() {
        for (s, rho) in schemes() {
            for k in -24..=24 {
                let big_omega = 10.0_f64.powf(k as f64 / 8.0);
                for xi in [0.0, 0.05, 0.9] {
                    let a = s.amplification(big_omega, xi);
                    let minors = 0.5 * (a.trace().powi(2) - (a * a).trace());
                    let found = [-a.trace(), minors, -a.determinant()];
                    let p = multistep(&s, big_omega, xi);
                    for i in 0..3 {
                        let gap = (found[i] - p[i + 1] / p[0]).abs();
                        assert!(gap <= 1e-12, "rho {rho}, Omega {big_omega}, coefficient {i}: {gap:e}");
                    }
                }
            }
        }
    }

    #[test]
    fn spectral_radius_is_the_theorys_and_never_above_one() {
        for (s, rho) in schemes() {
            for k in -16..=16 {
                let big_omega = 10.0_f64.powf(k as f64 / 8.0);
                let found = s.spectral_radius(big_omega, 0.0);
                let theory = largest_root(multistep(&s, big_omega, 0.0));
                // roots draw together towards infinite frequency, and round-off parts them
                let tolerance = if big_omega < 10.0 { 1e-12 } else { 1e-10 };
                assert!((found - theory).abs() <= tolerance, "{rho} {big_omega}: {found} {theory}");
                assert!(found <= 1.0 + tolerance, "{rho} {big_omega}: {found}");
            }
        }
    }

    #[test]
    fn at_infinite_frequency_all_roots_have_the_modulus_asked_for() {
        for i in 0..=10 {
            let rho = 0.1 * i as f64;
            let s = AlphaScheme::chung_hulbert(rho).unwrap();
            // (z + ρ)³
            let p = multistep(&s, 1e9, 0.0);
            for (k, expected) in [3.0 * rho, 3.0 * rho * rho, rho.powi(3)].into_iter().enumerate() {
                assert!((p[k + 1] / p[0] - expected).abs() < 1e-12, "{rho} {k}");
            }
        }
    }

    /// Error at t = 4 of a damped oscillator from rest under a ramp in force, root of its energy.
    fn error(s: &AlphaScheme, steps: usize) -> f64 {
        let (omega, xi, end) = (2.0 * PI, 0.03, 4.0_f64);
        let dt = end / steps as f64;
        let (k, c) = (omega * omega, 2.0 * xi * omega);
        let exact = |t: f64| {
            let wd = omega * (1.0 - xi * xi).sqrt();
            // u'' + c u' + k u = t: particular solution t/k - c/k²
            let (a, b) = (c / (k * k), (xi * omega * c / (k * k) - 1.0 / k) / wd);
            let decay = (-xi * omega * t).exp();
            let (sin, cos) = (wd * t).sin_cos();
            let u = t / k - c / (k * k) + decay * (a * cos + b * sin);
            let v = 1.0 / k + decay * ((b * wd - xi * omega * a) * cos - (a * wd + xi * omega * b) * sin);
            [u, v]
        };
        let w = s.operator(dt);
        let operator = w.mass + w.damping * c + w.stiffness * k;
        let (mut u, mut v, mut a) = (0.0, 0.0, 0.0);
        for n in 0..steps {
            let p = s.predict(dt, u, v, a);
            let load = s.weighted(n as f64 * dt, (n + 1) as f64 * dt);
            a = (load - s.alpha_m() * a - c * p.velocity_alpha - k * p.position_alpha) / operator;
            (u, v) = s.correct(dt, p.position, p.velocity, a);
        }
        let [ue, ve] = exact(end);
        (omega * (u - ue)).hypot(v - ve)
    }

    #[test]
    fn second_order_in_the_step_and_first_where_gamma_says_so() {
        for (s, rho) in schemes() {
            let order = if s == AlphaScheme::newmark(0.3025, 0.6).unwrap() { 1.0 } else { 2.0 };
            let found = (error(&s, 1600) / error(&s, 3200)).log2();
            assert!((found - order).abs() < 0.02, "rho {rho}, {s:?}: order {found}");
        }
    }

    #[test]
    fn presets_meet_where_they_should() {
        let trapezoidal = AlphaScheme::newmark(0.25, 0.5).unwrap();
        assert_eq!(AlphaScheme::trapezoidal(), trapezoidal);
        assert_eq!(AlphaScheme::hilber_hughes_taylor(1.0).unwrap(), trapezoidal);
        assert_eq!(AlphaScheme::wood_bossak_zienkiewicz(1.0).unwrap(), trapezoidal);
        let midpoint = AlphaScheme::chung_hulbert(1.0).unwrap();
        assert_eq!(
            (midpoint.alpha_m(), midpoint.alpha_f(), midpoint.gamma(), midpoint.beta()),
            (0.5, 0.5, 0.5, 0.25)
        );
    }

    #[test]
    fn parameters_without_a_stable_scheme_are_refused_by_name() {
        for error in [
            AlphaScheme::chung_hulbert(1.01).unwrap_err(),
            AlphaScheme::chung_hulbert(f64::NAN).unwrap_err(),
            AlphaScheme::hilber_hughes_taylor(0.49).unwrap_err(),
            AlphaScheme::wood_bossak_zienkiewicz(-0.1).unwrap_err(),
            AlphaScheme::newmark(0.25, 0.49).unwrap_err(),
            AlphaScheme::newmark(0.24, 0.5).unwrap_err(),
        ] {
            assert!(error.to_string().contains(" lies outside "), "{error}");
        }
        // beyond the bound the scheme does blow up
        let beyond = AlphaScheme { alpha_m: 0.0, alpha_f: 0.0, gamma: 0.5, beta: 0.2 };
        assert!(beyond.spectral_radius(10.0, 0.0) > 1.1 && beyond.spectral_radius(3.0, 0.0) <= 1.0 + 1e-12);
    }
}
