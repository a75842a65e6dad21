//! Bringing the ground to rest at the end of a record.

use std::f64::consts::PI;

use serde_json::{Map, Value, json};

use super::process::{per_component, refuse, refuse_quantity};
use super::{Motion, Quantity, resample_as};
use crate::error::InputError;

/// Fewest samples of a record that can be brought to rest.
const SAMPLES_FROM: usize = 8;

/// Rounds of the solution; each takes off what round-off left, the last ones next to nothing.
const ROUNDS: usize = 4;

/// Velocity (m/s) and displacement (m) at the last sample, from rest at the first.
fn at_end(a: &[f64], dt: f64) -> [f64; 2] {
    [Quantity::Velocity, Quantity::Displacement].map(|to| {
        let history = resample_as(a, dt, Quantity::Acceleration, to, 1);
        history.last().copied().unwrap_or(0.0)
    })
}

/// The two shapes of the correction: sin²(πτ) and (2τ − 1) sin²(πτ), τ = t/T.
fn shapes(n: usize) -> [Vec<f64>; 2] {
    let tau = |i: usize| i as f64 / (n - 1) as f64;
    // The ends are zero exactly, not by the sine of a rounded π.
    let window = |i: usize| if i == 0 || i + 1 == n { 0.0 } else { (PI * tau(i)).sin().powi(2) };
    [(0..n).map(window).collect(), (0..n).map(|i| (2.0 * tau(i) - 1.0) * window(i)).collect()]
}

/// See [`Process::Rest`](super::Process::Rest).
pub(super) fn rest(motion: &mut Motion) -> Result<Map<String, Value>, InputError> {
    refuse_quantity("rest", motion.quantity, Quantity::Acceleration)?;
    let (n, dt) = (motion.len(), motion.dt);
    if n < SAMPLES_FROM {
        let expected = format!("at least {SAMPLES_FROM}");
        let remedy = "give a longer record, or pad it before";
        return refuse("rest", "number of samples", n as f64, expected, remedy);
    }
    let shapes = shapes(n);
    let [first, second] = [at_end(&shapes[0], dt), at_end(&shapes[1], dt)];
    let determinant = first[0] * second[1] - second[0] * first[1];
    Ok(per_component(motion, |_, a| {
        let peak = a.iter().fold(0.0, |peak: f64, value| peak.max(value.abs()));
        let before = at_end(a, dt);
        let mut left = before;
        let mut correction = vec![0.0; n];
        for _ in 0..ROUNDS {
            let alpha = (left[1] * second[0] - left[0] * second[1]) / determinant;
            let beta = (left[0] * first[1] - left[1] * first[0]) / determinant;
            for i in 0..n {
                let c = alpha * shapes[0][i] + beta * shapes[1][i];
                correction[i] += c;
                a[i] += c;
            }
            left = at_end(a, dt);
        }
        let largest = correction.iter().fold(0.0, |peak: f64, value| peak.max(value.abs()));
        json!({
            "velocity_end_before_m_s": before[0], "displacement_end_before_m": before[1],
            "correction_peak_m_s2": largest,
            "correction_over_peak": if peak > 0.0 { largest / peak } else { 0.0 },
            "velocity_end_m_s": left[0], "displacement_end_m": left[1],
        })
    }))
}
