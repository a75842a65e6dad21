//! Butterworth filters as cascades of second-order sections.

use std::f64::consts::PI;

use num_complex::Complex64;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value, json};

use super::Motion;
use super::process::{per_component, refuse, unfit};
use crate::error::InputError;
use crate::number::{nine, rounded};

/// Highest order of a filter.
pub(crate) const FILTER_ORDER_TO: usize = 10;

/// Order of a filter that does not give one.
pub(crate) const FILTER_ORDER: usize = 4;

/// Most zeros on either side of a record.
const PAD_SAMPLES: f64 = (1 << 24) as f64;

const STEP: &str = "filter";

fn default_order() -> usize {
    FILTER_ORDER
}

/// A Butterworth filter: high-pass with `f_min`, low-pass with `f_max`, band-pass with both.
///
/// One pass has the gain $|H|^2 = 1/(1 + x^{2n})$ with n = `order` and, with $w = \tan(\pi f\,dt)$ and
/// $w_1$, $w_2$ the same of `f_min`, `f_max`: $x = w_1/w$ (high-pass), $x = w/w_2$ (low-pass),
/// $x = (w^2 - w_1 w_2)/(w\,(w_2 - w_1))$ (band-pass, whose fall-off on either side is that of order n).
/// The gain is −3.01 dB at each corner; below Nyquist/10 w is π f dt to 1 %. The tangent comes from the
/// bilinear transform, corners prewarped (Oppenheim and Schafer, 2010), run as second-order sections
/// in the transposed direct form II.
///
/// - `causal = true`: one pass from rest. Nothing comes before its cause; phases are delayed, and
///   differently at each frequency.
/// - `causal = false`: the same sections forth and back. No phase shift, twice the fall-off in dB:
///   the gain is |H|², −6.02 dB at the corners. The response begins before the first arrival. The
///   record is continued with zeros on both sides over $1.5\,n/\min(f_{min}, f_{max} - f_{min})$ s
///   ($1.5\,n/f$ after Boore, 2005; `f_max` counts alone in a low-pass), into which the response runs out.
/// - `keep_pads`: what the response does outside the record's time is kept and the record grows by the
///   zeros' length (behind it only for a causal filter); its start moves along. Without it the record keeps its
///   length, which is what most users expect, and the ends that are cut off are named in the step by
///   their peak: after a high-pass the ground is then not at rest at the end, and
///   [`Process::Rest`](super::Process::Rest) brings it there.
///
/// The record's own ends count as jumps: remove an offset, and taper, before. Limits: corners above 0
/// and below Nyquist, `f_min` below `f_max`; `order` from 1 to 10; zeros of at most 2²⁴ samples a side.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Filter {
    /// Lower corner; give `f_min`, `f_max` or both.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0.0, "x-unit" = "Hz", "x-default" = "low frequencies pass"))]
    pub f_min: Option<f64>,
    /// Upper corner, below the Nyquist frequency.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0.0, "x-unit" = "Hz", "x-default" = "high frequencies pass"))]
    pub f_max: Option<f64>,
    /// Order of one pass.
    #[serde(default = "default_order")]
    #[schemars(extend("minimum" = 1, "maximum" = FILTER_ORDER_TO, "x-unit" = "1"))]
    pub order: usize,
    /// One pass forth, with its delays, instead of forth and back.
    #[serde(default)]
    pub causal: bool,
    /// Keep the response outside the record's time; the record grows.
    #[serde(default)]
    pub keep_pads: bool,
}

impl Default for Filter {
    /// No corner yet, order 4, forth and back, length kept.
    fn default() -> Self {
        Self { f_min: None, f_max: None, order: FILTER_ORDER, causal: false, keep_pads: false }
    }
}

impl Filter {
    fn check(&self, dt: f64) -> Result<(), InputError> {
        let nyquist = 0.5 / dt;
        if self.f_min.is_none() && self.f_max.is_none() {
            return unfit(STEP, "no corner is given", "give f_min, f_max or both, in Hz");
        }
        for (parameter, corner) in [("f_min", self.f_min), ("f_max", self.f_max)] {
            if let Some(f) = corner
                && !(f > 0.0 && f < nyquist)
            {
                let expected = format!("above 0 and below the Nyquist frequency {} Hz", nine(nyquist));
                let remedy = match parameter {
                    "f_max" if f >= nyquist => {
                        "lower f_max, or leave it out: above Nyquist the record holds nothing"
                    }
                    _ => "give a corner inside the record's band, in Hz",
                };
                return refuse(STEP, parameter, f, expected, remedy);
            }
        }
        if let (Some(low), Some(high)) = (self.f_min, self.f_max)
            && low >= high
        {
            let remedy = "give the lower corner as f_min, the upper one as f_max";
            return refuse(STEP, "f_min", low, format!("below f_max = {} Hz", nine(high)), remedy);
        }
        if !(1..=FILTER_ORDER_TO).contains(&self.order) {
            let expected = format!("a whole number from 1 to {FILTER_ORDER_TO}");
            return refuse(STEP, "order", self.order as f64, expected, "2 to 4 are customary");
        }
        let pad = self.pad_samples(dt);
        if pad > PAD_SAMPLES {
            let (parameter, f) = self.slowest();
            let least = rounded(f * pad / PAD_SAMPLES);
            let expected = format!("at least {least} Hz: {} zeros would be too many", rounded(pad));
            let remedy = "raise the corner, widen the band or lower the order; `demean` and `detrend` take off \
                          what is slower";
            return refuse(STEP, parameter, f, expected, remedy);
        }
        Ok(())
    }

    /// The frequency (Hz) whose period the response lasts by, and its name.
    fn slowest(&self) -> (&'static str, f64) {
        match (self.f_min, self.f_max) {
            (Some(low), Some(high)) if high - low < low => ("f_max - f_min", high - low),
            (Some(low), _) => ("f_min", low),
            (None, high) => ("f_max", high.unwrap_or(f64::NAN)),
        }
    }

    /// Zeros on one side; the round-off of a quotient makes no further one.
    fn pad_samples(&self, dt: f64) -> f64 {
        (1.5 * self.order as f64 / (self.slowest().1 * dt) - 1e-9).ceil()
    }
}

/// `y = b₀ x + b₁ x₋₁ + b₂ x₋₂ − a₁ y₋₁ − a₂ y₋₂`.
#[derive(Debug, Clone, Copy)]
struct Section {
    b: [f64; 3],
    a: [f64; 2],
}

impl Section {
    /// From `(n₀ + n₁ s + n₂ s²)/(d₀ + d₁ s + d₂ s²)` with s = (1 − z⁻¹)/(1 + z⁻¹).
    fn bilinear(n: [f64; 3], d: [f64; 3]) -> Self {
        let digital = |c: [f64; 3]| [c[0] + c[1] + c[2], 2.0 * (c[0] - c[2]), c[0] - c[1] + c[2]];
        let (b, a) = (digital(n), digital(d));
        Self { b: b.map(|b| b / a[0]), a: [a[1] / a[0], a[2] / a[0]] }
    }

    /// Transposed direct form II from rest, in place.
    fn run<'x>(&self, x: impl Iterator<Item = &'x mut f64>) {
        let (mut s1, mut s2) = (0.0, 0.0);
        for value in x {
            let y = self.b[0] * *value + s1;
            s1 = self.b[1] * *value - self.a[0] * y + s2;
            s2 = self.b[2] * *value - self.a[1] * y;
            *value = y;
        }
    }
}

/// Left-half-plane poles of the Butterworth low-pass of unit corner, those with Im ≥ 0.
fn poles(order: usize) -> impl Iterator<Item = Complex64> {
    (0..order.div_ceil(2)).map(move |k| {
        if 2 * k + 1 == order {
            return Complex64::new(-1.0, 0.0);
        }
        let angle = PI * (2 * k + 1) as f64 / (2 * order) as f64;
        Complex64::new(-angle.sin(), angle.cos())
    })
}

/// The sections of one pass for a step `dt` (s); corners have been checked.
fn sections(filter: &Filter, dt: f64) -> Vec<Section> {
    let w = |f: f64| (PI * f * dt).tan();
    let pairs = poles(filter.order);
    match (filter.f_min.map(w), filter.f_max.map(w)) {
        (Some(low), Some(high)) => pairs.flat_map(|p| band_pass(p, low, high)).collect(),
        (Some(low), None) => pairs
            .map(|p| match p.im == 0.0 {
                true => Section::bilinear([0.0, 1.0, 0.0], [low, 1.0, 0.0]),
                false => Section::bilinear([0.0, 0.0, 1.0], [low * low, -2.0 * p.re * low, 1.0]),
            })
            .collect(),
        (None, high) => {
            let high = high.unwrap_or(f64::INFINITY);
            pairs
                .map(|p| match p.im == 0.0 {
                    true => Section::bilinear([high, 0.0, 0.0], [high, 1.0, 0.0]),
                    false => {
                        Section::bilinear([high * high, 0.0, 0.0], [high * high, -2.0 * p.re * high, 1.0])
                    }
                })
                .collect()
        }
    }
}

/// Sections of the band-pass for a pole p of the low-pass: s² − p B s + w₀² = 0, B = w₂ − w₁, w₀² = w₁ w₂.
///
/// Each section has the zero s = 0 and unit gain at w₀, where the whole band-pass has it.
fn band_pass(p: Complex64, low: f64, high: f64) -> Vec<Section> {
    let (width, centre2) = (high - low, low * high);
    let unit = |d: [f64; 3]| {
        let at = Complex64::new(d[0] - d[2] * centre2, d[1] * centre2.sqrt());
        Section::bilinear([0.0, at.norm() / centre2.sqrt(), 0.0], d)
    };
    if p.im == 0.0 {
        return vec![unit([centre2, width, 1.0])];
    }
    let half = p * (0.5 * width);
    let root = (half * half - centre2).sqrt();
    // Of the two roots one loses digits to the difference; their product w₀² gives it back.
    let sum = half + root;
    let first = if sum.norm_sqr() >= (half - root).norm_sqr() { sum } else { half - root };
    [first, Complex64::new(centre2, 0.0) / first].map(|s| unit([s.norm_sqr(), -2.0 * s.re, 1.0])).to_vec()
}

/// See [`Filter`].
pub(super) fn filter(motion: &mut Motion, asked: &Filter) -> Result<Map<String, Value>, InputError> {
    let (n, dt) = (motion.len(), motion.dt);
    asked.check(dt)?;
    let sections = sections(asked, dt);
    let pad = asked.pad_samples(dt) as usize;
    let before = if asked.causal { 0 } else { pad };
    let after = if asked.causal && !asked.keep_pads { 0 } else { pad };
    let unit = motion.quantity.key_suffix();
    let mut found = per_component(motion, |_, samples| {
        let mut long = vec![0.0; before + n + after];
        long[before..before + n].copy_from_slice(samples);
        sections.iter().for_each(|section| section.run(long.iter_mut()));
        if !asked.causal {
            sections.iter().for_each(|section| section.run(long.iter_mut().rev()));
        }
        if asked.keep_pads {
            *samples = long;
            return json!({});
        }
        samples.copy_from_slice(&long[before..before + n]);
        if asked.causal {
            return json!({});
        }
        let outside = long[..before].iter().chain(&long[before + n..]);
        let cut = outside.fold(0.0, |peak: f64, value| peak.max(value.abs()));
        let peak = samples.iter().fold(0.0, |peak: f64, value| peak.max(value.abs()));
        let share = if peak > 0.0 { cut / peak } else { 0.0 };
        json!({ format!("cut_peak_{unit}"): cut, "cut_over_peak": share })
    });
    if asked.keep_pads {
        motion.start = motion.start.map(|start| start - before as f64 * dt);
    }
    found.retain(|_, entry| entry.as_object().is_none_or(|entry| !entry.is_empty()));
    found.insert("passes".into(), json!(if asked.causal { 1 } else { 2 }));
    found.insert("corner_db".into(), json!(if asked.causal { -3.01 } else { -6.02 }));
    found.insert("zeros_before_s".into(), json!(before as f64 * dt));
    found.insert("zeros_after_s".into(), json!(after as f64 * dt));
    Ok(found)
}
