//! Slow trends of a record: a polynomial of the samples, or one of the velocity.

use serde_json::{Map, Value, json};

use super::process::{per_component, refuse, refuse_quantity};
use super::{Motion, Quantity, integrate};
use crate::error::InputError;

/// Highest order of a trend: beyond it a polynomial begins to follow the motion itself.
pub(crate) const TREND_ORDER_TO: usize = 5;

/// A fitted polynomial at the samples and its derivative by s = i/(n − 1).
struct Fit {
    value: Vec<f64>,
    slope: Vec<f64>,
}

/// Least-squares polynomial of `degree` through equally spaced samples, s = i/(n − 1) from 0 to 1.
///
/// `from_zero`: the polynomial has no constant term, so that it vanishes at the first sample. It is
/// then s q(s), and q is fitted with the weight s². Orthogonal polynomials are built by their
/// three-term recurrence (Forsythe, 1957), which stays accurate where powers of s would not, and each
/// coefficient is taken from what the lower ones left.
fn fit(y: &[f64], degree: usize, from_zero: bool) -> Fit {
    let n = y.len();
    let s = |i: usize| i as f64 / (n - 1) as f64;
    let root_weight = |i: usize| if from_zero { s(i) } else { 1.0 };
    let mut rest = y.to_vec();
    let (mut q, mut dq) = (vec![0.0; n], vec![0.0; n]);
    let (mut p, mut dp) = (vec![1.0; n], vec![0.0; n]);
    let (mut p_before, mut dp_before) = (vec![0.0; n], vec![0.0; n]);
    let mut norm_before = 0.0;
    for k in 0..=degree - usize::from(from_zero) {
        let (mut norm, mut moment, mut projection) = (0.0, 0.0, 0.0);
        for i in 0..n {
            let m = root_weight(i);
            let weighted = (m * p[i]).powi(2);
            norm += weighted;
            moment += s(i) * weighted;
            projection += m * rest[i] * p[i];
        }
        let c = projection / norm;
        let alpha = moment / norm;
        let beta = if k == 0 { 0.0 } else { norm / norm_before };
        norm_before = norm;
        for i in 0..n {
            rest[i] -= c * root_weight(i) * p[i];
            q[i] += c * p[i];
            dq[i] += c * dp[i];
            let next = (s(i) - alpha) * p[i] - beta * p_before[i];
            let dnext = p[i] + (s(i) - alpha) * dp[i] - beta * dp_before[i];
            (p_before[i], dp_before[i]) = (p[i], dp[i]);
            (p[i], dp[i]) = (next, dnext);
        }
    }
    if !from_zero {
        return Fit { value: q, slope: dq };
    }
    let slope = (0..n).map(|i| q[i] + s(i) * dq[i]).collect();
    Fit { value: (0..n).map(|i| s(i) * q[i]).collect(), slope }
}

fn check_order(step: &'static str, order: usize, samples: usize) -> Result<(), InputError> {
    if !(1..=TREND_ORDER_TO).contains(&order) {
        let expected = format!("a whole number from 1 to {TREND_ORDER_TO}");
        return refuse(step, "order", order as f64, expected, "1 takes off a straight line");
    }
    if samples < order + 2 {
        let expected = format!("below the {samples} samples of the motion by 2 or more");
        return refuse(step, "order", order as f64, expected, "lower the order, or give a longer record");
    }
    Ok(())
}

fn largest(x: &[f64]) -> f64 {
    x.iter().fold(0.0, |peak: f64, value| peak.max(value.abs()))
}

/// See [`Process::Detrend`](super::Process::Detrend).
pub(super) fn detrend(motion: &mut Motion, order: usize) -> Result<Map<String, Value>, InputError> {
    check_order("detrend", order, motion.len())?;
    let unit = motion.quantity.key_suffix();
    Ok(per_component(motion, |_, samples| {
        let trend = fit(samples, order, false).value;
        samples.iter_mut().zip(&trend).for_each(|(x, trend)| *x -= trend);
        json!({
            format!("removed_peak_{unit}"): largest(&trend),
            format!("removed_first_{unit}"): trend[0],
            format!("removed_last_{unit}"): trend[trend.len() - 1],
        })
    }))
}

/// See [`Process::Baseline`](super::Process::Baseline).
pub(super) fn baseline(motion: &mut Motion, order: usize) -> Result<Map<String, Value>, InputError> {
    check_order("baseline", order, motion.len())?;
    refuse_quantity("baseline", motion.quantity, Quantity::Acceleration)?;
    let (dt, duration) = (motion.dt, motion.duration());
    Ok(per_component(motion, |_, samples| {
        let velocity = integrate(samples, dt);
        let mut removed = fit(&velocity, order, true).slope;
        removed.iter_mut().for_each(|slope| *slope /= duration);
        samples.iter_mut().zip(&removed).for_each(|(a, removed)| *a -= removed);
        let after = integrate(samples, dt);
        json!({
            "removed_peak_m_s2": largest(&removed),
            "velocity_end_before_m_s": velocity[velocity.len() - 1],
            "velocity_end_m_s": after[after.len() - 1],
        })
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Polynomials of the order come back, with their slopes; with the constant term where it is allowed.
    #[test]
    fn polynomials_are_their_own_fit() {
        let n = 400;
        let s = |i: usize| i as f64 / (n - 1) as f64;
        for order in 1..=TREND_ORDER_TO {
            for from_zero in [false, true] {
                let first = usize::from(from_zero);
                let c = |k: usize| [0.7, -2.0, 3.0, 1.5, -4.0, 2.5][k];
                let value = |s: f64| (first..=order).map(|k| c(k) * s.powi(k as i32)).sum::<f64>();
                let slope = |s: f64| (1..=order).map(|k| k as f64 * c(k) * s.powi(k as i32 - 1)).sum::<f64>();
                let y: Vec<f64> = (0..n).map(|i| value(s(i))).collect();
                let found = fit(&y, order, from_zero);
                for i in 0..n {
                    assert!((found.value[i] - y[i]).abs() < 1e-12, "{order} {from_zero} {i}");
                    assert!((found.slope[i] - slope(s(i))).abs() < 1e-10, "{order} {from_zero} {i}");
                }
            }
        }
    }

    /// What is left has no projection on any power of the order: the fit is the least-squares one.
    #[test]
    fn the_rest_is_orthogonal_to_the_powers() {
        let n = 301;
        let y: Vec<f64> = (0..n).map(|i| (0.05 * i as f64).sin() + (i as f64 / 50.0).exp() * 0.01).collect();
        for (order, from_zero) in [(1, false), (5, false), (1, true), (4, true)] {
            let found = fit(&y, order, from_zero).value;
            for k in usize::from(from_zero)..=order {
                let power = |i: usize| (i as f64 / (n - 1) as f64).powi(k as i32);
                let dot: f64 = (0..n).map(|i| (y[i] - found[i]) * power(i)).sum();
                assert!(dot.abs() < 1e-11, "{order} {from_zero} {k}: {dot}");
            }
        }
    }
}
