//! A new time step by band-limited interpolation.

use std::f64::consts::PI;

use serde_json::{Map, Value, json};

use super::process::{per_component, refuse};
use super::spectrum::{Spectrum, even_5_smooth, padded_length};
use super::{Motion, PAD_SECONDS};
use crate::error::InputError;
use crate::number::{nine, rounded};

/// Largest p and q of a ratio p/q of steps.
const RATIO_TO: u64 = 10_000;

/// Largest p and q of the steps that a refusal names.
const NEAR_RATIO_TO: u64 = 100;

/// Relative distance within which a ratio of steps counts as p/q.
const RATIO_TOLERANCE: f64 = 1e-9;

/// Most samples of a transform.
const SAMPLES_TO: f64 = (1 << 27) as f64;

/// Where the anti-alias roll-off begins, as a share of the new Nyquist frequency.
const FLAT_TO: f64 = 0.8;

const STEP: &str = "resample";

/// Best p/q to `x` with p, q ≤ `limit` by continued fractions, stopping where it is within the tolerance.
fn fraction(x: f64, limit: u64) -> (u64, u64) {
    let (mut p, mut q) = ([0_u64, 1], [1_u64, 0]);
    let mut rest = x;
    for _ in 0..64 {
        let whole = rest.floor();
        if whole > limit as f64 {
            break;
        }
        let next = |v: [u64; 2]| whole as u64 * v[1] + v[0];
        let (p_next, q_next) = (next(p), next(q));
        if p_next > limit || q_next > limit {
            break;
        }
        (p, q) = ([p[1], p_next], [q[1], q_next]);
        if (p_next as f64 / q_next as f64 - x).abs() <= RATIO_TOLERANCE * x || rest == whole {
            break;
        }
        rest = (rest - whole).recip();
    }
    (p[1], q[1])
}

/// The ratio old step/new step as p/q, or a refusal that names the nearest steps that would do.
fn ratio(old: f64, new: f64) -> Result<(usize, usize), InputError> {
    let asked = old / new;
    let in_range = asked >= 1.0 / RATIO_TO as f64 && asked <= RATIO_TO as f64;
    if !in_range {
        let (low, high) = (old / RATIO_TO as f64, old * RATIO_TO as f64);
        let expected = format!("a step from {} to {} s", rounded(low), rounded(high));
        return refuse(STEP, "dt", new, expected, "give a step in s, for instance dt = 0.005");
    }
    let (p, q) = fraction(asked, RATIO_TO);
    if (p as f64 / q as f64 - asked).abs() <= RATIO_TOLERANCE * asked {
        return Ok((p as usize, q as usize));
    }
    // Neighbours with small numbers: the best fraction and one on its other side.
    let (p, q) = fraction(asked, NEAR_RATIO_TO);
    let mut near = vec![old * q as f64 / p.max(1) as f64];
    let other = (1..=NEAR_RATIO_TO)
        .map(|q| {
            let p = if near[0] < new { (asked * q as f64).floor() } else { (asked * q as f64).ceil() };
            old * q as f64 / p.max(1.0)
        })
        .filter(|dt| (*dt < new) != (near[0] < new))
        .min_by(|a, b| (a - new).abs().total_cmp(&(b - new).abs()));
    near.extend(other);
    near.sort_by(f64::total_cmp);
    let near: Vec<String> = near.iter().map(|dt| format!("{dt} s")).collect();
    let expected = format!(
        "a whole-number ratio p/q to the step {} s with p and q up to {RATIO_TO}; near are {}",
        nine(old),
        near.join(" and ")
    );
    refuse(STEP, "dt", new, expected, "give one of the near steps, digit by digit")
}

/// See [`Process::Resample`](super::Process::Resample).
pub(super) fn resample(motion: &mut Motion, dt: f64) -> Result<Map<String, Value>, InputError> {
    if !(dt.is_finite() && dt > 0.0) {
        let remedy = "give a step in s, for instance dt = 0.005";
        return refuse(STEP, "dt", dt, "a positive time step in s", remedy);
    }
    let (n, old) = (motion.len(), motion.dt);
    let (p, q) = ratio(old, dt)?;
    let count = (n - 1) * p / q + 1;
    if count < 2 {
        let expected = format!("at most the motion's length of {} s", nine(motion.duration()));
        return refuse(STEP, "dt", dt, expected, "give a finer step");
    }
    let unit = even_5_smooth(padded_length(n, old, PAD_SECONDS).div_ceil(q));
    let (length, new_length) = (unit * q, unit * p);
    if length.max(new_length) as f64 > SAMPLES_TO {
        let finest = dt * new_length as f64 / SAMPLES_TO;
        let expected = format!("about {} s or more: the motion would be too long", rounded(finest));
        return refuse(STEP, "dt", dt, expected, "give a coarser step, or trim the record before");
    }
    let nyquist = 0.5 / dt;
    let gain = |f: f64| {
        let into = (f / nyquist - FLAT_TO) / (1.0 - FLAT_TO);
        0.5 * (1.0 + (PI * into.clamp(0.0, 1.0)).cos())
    };
    let mut found = Map::new();
    if p != q {
        let _: Map<String, Value> = per_component(motion, |_, samples| {
            let mut spectrum = Spectrum::of_length(samples, old, length);
            if p < q {
                spectrum.apply(gain);
            }
            *samples = spectrum.at_length(new_length, count);
            json!({})
        });
    }
    if p < q {
        found.insert("flat_to_hz".into(), json!(FLAT_TO * nyquist));
        found.insert("zero_from_hz".into(), json!(nyquist));
    }
    motion.dt = dt;
    found.insert("dt_before_s".into(), json!(old));
    found.insert("ratio".into(), json!([p, q]));
    found.insert("samples".into(), json!(count));
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fractions_are_the_shortest_ones() {
        for (x, expected) in [
            (0.5, (1, 2)),
            (625.0 / 512.0, (625, 512)),
            (0.005 / 0.01, (1, 2)),
            (0.01 / 0.005, (2, 1)),
            (0.01 / 0.0078125, (32, 25)),
            (1.0 / 3.0, (1, 3)),
            (0.0024 / 0.02, (3, 25)),
            (7.0, (7, 1)),
        ] {
            assert_eq!(fraction(x, RATIO_TO), expected, "{x}");
        }
        assert_eq!(ratio(0.01, 0.0073).unwrap(), (100, 73));
        let error = ratio(0.01, 0.01 / PI).unwrap_err().to_string();
        assert!(error.contains("near are 0.0031818"), "{error}");
        for dt in [1e-9, 1e9] {
            assert!(ratio(0.01, dt).unwrap_err().to_string().contains("a step from"), "{dt}");
        }
    }
}
