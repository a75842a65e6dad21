//! Central difference as drift–kick–drift, one freedom at a time.
//!
//! One step of length $\Delta t$ from the state $(u, v)$ at a step's end:
//!
//! $$x = u + \tfrac{\Delta t}{2} v,\qquad
//!   m\,\frac{v^+ - v}{\Delta t} + c\,\frac{v^+ + v}{2} = f(x),\qquad
//!   u^+ = x + \tfrac{\Delta t}{2} v^+ .$$
//!
//! The kicks are the integer instants of the textbooks' central difference (Verlet, leap-frog,
//! Newmark β = 0, γ = ½); a step's ends lie half a step to either side. Second order; with
//! $c = 0$ and $f = -Ku$ it keeps
//! $E = \tfrac12 v^T(M - \tfrac{\Delta t^2}{4}K)v + \tfrac12 u^T K u$ exactly. Limit:
//! $\omega\,\Delta t \le 2$, whatever $c \ge 0$ (the mean velocity of an alternating motion vanishes,
//! so the dashpot does not act at the limit).

use num_complex::Complex64;
use std::ops::{Add, Mul};

/// Position after half a step: $u + \tfrac{\Delta t}{2} v$.
///
/// With the whole step in place of the half it takes a position from kick to kick: two drifts at one
/// velocity are one.
#[inline(always)]
pub fn drift<T: Copy + Add<Output = T> + Mul<Output = T>>(u: T, v: T, half_dt: T) -> T {
    u + half_dt * v
}

/// Velocity after the kick of a freedom without dashpot: $v + \Delta t\, f / m$.
///
/// `dt_over_mass` is $\Delta t/m$; `force` is external minus internal, at the drifted position.
#[inline(always)]
pub fn kick<T: Copy + Add<Output = T> + Mul<Output = T>>(v: T, force: T, dt_over_mass: T) -> T {
    v + dt_over_mass * force
}

/// Velocity after the kick of a freedom with a dashpot $c$ to the ground, taken half implicitly:
/// $v^+ = \dfrac{(m - \tfrac{\Delta t}{2}c)\,v + \Delta t\, f}{m + \tfrac{\Delta t}{2}c}$.
#[inline(always)]
pub fn kick_damped(v: f64, force: f64, mass: f64, dashpot: f64, dt: f64) -> f64 {
    let half = 0.5 * dt * dashpot;
    ((mass - half) * v + dt * force) / (mass + half)
}

/// Critical step $2/\omega_{\max}$, s, for the largest eigenfrequency in rad/s.
pub fn dt_critical(omega_max: f64) -> f64 {
    2.0 / omega_max
}

/// Symbol of the second difference at the kicks for a motion $e^{st}$:
/// $\tfrac{4}{\Delta t^2}\sinh^2\tfrac{s\Delta t}{2}$ stands where the continuum has $s^2$; with
/// $s = i\omega$ it is $-\tfrac{4}{\Delta t^2}\sin^2\tfrac{\omega\Delta t}{2}$.
pub fn acceleration_symbol(s: Complex64, dt: f64) -> Complex64 {
    let half = (0.5 * dt * s).sinh() * (2.0 / dt);
    half * half
}

/// Symbol of the mean velocity at the kicks, $\sinh(s\Delta t)/\Delta t$ in place of $s$.
pub fn velocity_symbol(s: Complex64, dt: f64) -> Complex64 {
    (s * dt).sinh() / dt
}

/// Symbol of a rate under the trapezoidal rule from kick to kick,
/// $\tfrac{2}{\Delta t}\tanh\tfrac{s\Delta t}{2}$ in place of $s$.
pub fn trapezoidal_symbol(s: Complex64, dt: f64) -> Complex64 {
    (0.5 * dt * s).tanh() * (2.0 / dt)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(omega: f64, c: f64, dt: f64, steps: usize) -> (f64, f64) {
        let (mut u, mut v) = (1.0, 0.0);
        for _ in 0..steps {
            let x = drift(u, v, 0.5 * dt);
            v = kick_damped(v, -omega * omega * x, 1.0, c, dt);
            u = drift(x, v, 0.5 * dt);
        }
        (u, v)
    }

    #[test]
    fn second_order_in_the_step() {
        let exact = (2.0_f64 * 4.0).cos();
        let e: Vec<f64> =
            [400, 800, 1600].iter().map(|&n| (run(2.0, 0.0, 4.0 / n as f64, n).0 - exact).abs()).collect();
        for w in e.windows(2) {
            assert!(((w[0] / w[1]).log2() - 2.0).abs() < 0.02, "{e:?}");
        }
    }

    #[test]
    fn both_sides_of_the_limit_with_and_without_dashpot() {
        for c in [0.0, 0.1, 1.0, 10.0] {
            assert!(run(1.0, c, 2.0 * 0.999, 20_000).0.abs() < 1e3, "c = {c}: stable below");
            let beyond = run(1.0, c, 2.0 * 1.01, 20_000).0;
            assert!(beyond.is_nan() || beyond.abs() > 1e6, "c = {c}: unstable above, got {beyond}");
        }
    }

    #[test]
    fn energy_is_kept_exactly() {
        let (omega, dt) = (3.0, 0.3);
        let energy = |u: f64, v: f64| {
            0.5 * v * v * (1.0 - 0.25 * dt * dt * omega * omega) + 0.5 * omega * omega * u * u
        };
        let (u, v) = run(omega, 0.0, dt, 10_000);
        assert!((energy(u, v) / energy(1.0, 0.0) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn damped_kick_without_dashpot_is_the_plain_kick() {
        assert_eq!(kick_damped(1.5, 2.0, 4.0, 0.0, 0.1), (4.0 * 1.5 + 0.1 * 2.0) / 4.0);
        assert!((kick(1.5, 2.0, 0.1 / 4.0) - kick_damped(1.5, 2.0, 4.0, 0.0, 0.1)).abs() < 1e-15);
    }
}
