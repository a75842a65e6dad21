//! Matching a record to a design spectrum in the time domain.
//!
//! The record is changed as little as its response spectrum allows. The oscillator of period T_i, damping ζ,
//! from rest, has its extremes ("half-cycles") at times t_r; to first order they follow a change δ(t) of
//! the acceleration as
//!
//! ```text
//! u_i(t_r) ← u_i(t_r) + ⟨g_r, δ⟩ ,      g_r(τ) = −e^{−ζω(t_r−τ)} sin ω_d(t_r−τ)/ω_d ,  τ ≤ t_r .
//! ```
//!
//! Each iteration solves a quadratic programme: the smallest δ, measured by `⟨δ, W⁻¹δ⟩` (see [`metric`]),
//! for which at every period the largest half-cycle reaches the lower bound and all others stay below the
//! upper one, and `∫δ` and `∫(t_end − t)δ` bring velocity and displacement at the end to zero. Its solution
//! is δ = W Σ λ_r g_r with λ_r ≥ 0: reversed impulse responses under the seed's envelope, the wavelets of
//! this method, each ending at the half-cycle that it moves. Then the half-cycles are looked for afresh.

mod adjust;
mod metric;
mod oscillator;

use std::f64::consts::{PI, TAU};

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value, json};

use self::adjust::Target;
use self::metric::Metric;
use super::process::{refuse, refuse_quantity, unfit};
use super::{AXES, BandWindow, Motion, PAD_SECONDS, Quantity, Spectrum, Step, resample_as};
use crate::error::InputError;
use crate::measures::{DesignSpectrum, log_periods, psa};
use crate::number::nine;

const STEP: &str = "match";

/// Fewest periods at which a result is checked.
const CHECK_PERIODS: usize = 400;

/// Periods at which the seed's own spectrum is taken.
const SEED_PERIODS: usize = 100;

/// Share of the tolerance that the constraints use, and the one below which no more is done.
const MARGIN: f64 = 0.6;
const GOOD: f64 = 0.92;

/// Periods up to this multiple of the longest one have an upper bound.
const BEYOND: f64 = 2.5;

/// Most effort of one iteration and of all those of a component, in multiplications of the constraints' entries by
/// their number: about ten seconds and a minute on two cores of today.
const EFFORT_TO: f64 = 4e11;
const EFFORT_IN_ALL_TO: f64 = 2e12;

/// Most samples of a component after padding and interpolation.
const SAMPLES_UP_TO: usize = 1 << 17;

/// Adjustment of a record until its response spectrum lies about a design spectrum.
///
/// Acceptance: `|PSA(T)/target(T) − 1| ≤ tolerance` at 400 periods or more, equally spaced on a logarithmic
/// axis and finer than a third of the damping ratio, PSA as [`response_spectrum`](crate::measures::response_spectrum)
/// gives it. Most of them lie between the periods that were fitted.
///
/// - **Each component by itself**, x and y to the horizontal spectrum, z to the vertical one, unless the
///   spectrum states its direction or is given by points.
/// - **Step.** A record whose step is above a quarter of the shortest period is interpolated, by a power of
///   two, in the frequency domain; the motion keeps the finer step.
/// - **Length.** Zeros are added so that one longest period lies before 5 % and two after 95 % of the
///   record's energy; the start moves back with them.
/// - **Beyond the longest period** T: what the seed has below 0.35/T (full again from 0.7/T; T no less than
///   10 s here) is taken off, and up to 2.5 T the spectrum is held below the target's continuation.
/// - **Rest.** Velocity and displacement at the last sample are zero to round-off, by [`resample_as`].
///
/// Cost: one iteration is about `rows² · memory + rows · N log N`, rows the bounded half-cycles (500 to
/// 1500 at 5 % damping), memory the samples over which an oscillator forgets; a 60 s record takes a second
/// or two in all at 5 % damping, ten at 2 %, a minute at 1 %. A match that would take minutes, as most do at
/// 0.5 %, is refused. Limits: 131072 samples after padding and interpolation; a seed without motion at some
/// period is given motion there that it never had.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Matching {
    /// The target; each component is matched by itself, z to the vertical spectrum of a code.
    pub spectrum: DesignSpectrum,
    /// Shortest and longest period of the match, 0.01 to 20 s.
    #[serde(default = "default_periods")]
    #[schemars(extend("x-unit" = "s"))]
    pub periods: [f64; 2],
    /// Largest relative difference from the target at any period between them, 0.02 or more.
    #[serde(default = "default_tolerance")]
    #[schemars(extend("minimum" = 0.02, "exclusiveMaximum" = 1.0, "x-unit" = "1"))]
    pub tolerance: f64,
    /// Largest number of iterations; a match that takes more is refused.
    #[serde(default = "default_iterations")]
    #[schemars(extend("minimum" = 1))]
    pub iterations: usize,
}

fn default_periods() -> [f64; 2] {
    [0.02, 10.0]
}

fn default_tolerance() -> f64 {
    0.1
}

fn default_iterations() -> usize {
    30
}

/// One component on the step and length of the match, scaled to the target's level, m/s².
struct Seed {
    /// The record itself.
    whole: Vec<f64>,
    /// The record without what lies below the target's frequencies: where the match begins.
    start: Vec<f64>,
    /// Factor from the record.
    scale: f64,
}

/// A result that was checked.
struct Match {
    record: Vec<f64>,
    /// Smallest and largest ratio to the target, each with its period (s).
    extremes: [(f64, f64); 2],
    iterations: usize,
}

impl Match {
    fn worst(&self) -> (f64, f64) {
        let [low, high] = self.extremes;
        if 1.0 - low.0 > high.0 - 1.0 { low } else { high }
    }

    fn off(&self) -> f64 {
        (self.worst().0 - 1.0).abs()
    }
}

impl Matching {
    /// A match with the customary periods (0.02 to 10 s), tolerance (10 %) and limit of iterations (30).
    #[must_use]
    pub fn to(spectrum: DesignSpectrum) -> Self {
        let (periods, tolerance, iterations) = (default_periods(), default_tolerance(), default_iterations());
        Self { spectrum, periods, tolerance, iterations }
    }

    /// Matches every component of an acceleration and records the step.
    ///
    /// Errors: a spectrum, periods or tolerance out of their ranges; a motion that is no acceleration, that
    /// does not move or is too long; a match that is not reached ([`InputError::NotMatched`]), which leaves
    /// the motion as it was.
    pub fn apply(&self, motion: &mut Motion) -> Result<(), InputError> {
        self.check()?;
        refuse_quantity(STEP, motion.quantity, Quantity::Acceleration)?;
        let pads = self.pads(motion);
        let mut k = 1;
        while motion.dt / k as f64 > self.periods[0] / 4.0 * (1.0 + 1e-9) {
            k *= 2;
        }
        let count = (motion.len() + pads[0] + pads[1]).saturating_mul(k);
        if count > SAMPLES_UP_TO {
            let problem = format!("{count} samples after padding and interpolation, above {SAMPLES_UP_TO}");
            return unfit(STEP, problem, "trim the record to its strong part, or raise the shortest period");
        }
        let dt = motion.dt / k as f64;
        let mut found = Map::new();
        let mut components = [None, None, None];
        for axis in 0..3 {
            let Some(samples) = &motion.components[axis] else { continue };
            let target = self.spectrum.for_axis(axis);
            let seed = self.seed(axis, samples, motion.dt, pads, k, &target)?;
            let matched = self.match_one(axis, &seed, dt, &target)?;
            found.insert(AXES[axis].to_string(), described(&seed, &matched, dt));
            components[axis] = Some(matched.record);
        }
        let before = pads[0] as f64 * motion.dt;
        found.insert("pad_before_s".into(), json!(before));
        found.insert("pad_after_s".into(), json!(pads[1] as f64 * motion.dt));
        found.insert("dt_s".into(), json!(dt));
        motion.start = motion.start.map(|start| start - before);
        motion.dt = dt;
        motion.components = components;
        let parameters = serde_json::to_value(self).unwrap_or_default();
        motion.steps.push(Step::new(STEP, parameters).with_found(Value::Object(found)));
        Ok(())
    }

    /// Refuses numbers out of their ranges.
    ///
    /// Errors: those of [`DesignSpectrum::check`]; periods, tolerance or iterations that cannot be.
    pub fn check(&self) -> Result<(), InputError> {
        self.spectrum.check()?;
        let [shortest, longest] = self.periods;
        if !(shortest >= 0.01 && shortest.is_finite()) {
            let remedy = "give periods = [shortest, longest] in s, for instance [0.02, 10.0]";
            return refuse(STEP, "periods", shortest, "a shortest period of 0.01 s or more", remedy);
        }
        if !(longest >= 1.5 * shortest && longest <= 20.0) {
            let expected = format!("a longest period of {} s to 20 s", nine(1.5 * shortest));
            let remedy = "give periods = [shortest, longest] in s, for instance [0.02, 10.0]";
            return refuse(STEP, "periods", longest, expected, remedy);
        }
        if !(self.tolerance >= 0.02 && self.tolerance < 1.0) {
            let remedy = "give a ratio, not per cent: 10 % is 0.1";
            return refuse(STEP, "tolerance", self.tolerance, "0.02 or more, below 1", remedy);
        }
        if self.iterations == 0 {
            return refuse(STEP, "iterations", 0.0, "at least 1", "30 are customary");
        }
        Ok(())
    }

    /// Samples of silence before and after, so that the longest period finds time to swing.
    fn pads(&self, motion: &Motion) -> [usize; 2] {
        let n = motion.len();
        let mut energy = vec![0.0; n];
        for samples in motion.components.iter().flatten() {
            energy.iter_mut().zip(samples).for_each(|(e, a)| *e += a * a);
        }
        let total: f64 = energy.iter().sum();
        let crossing = |share: f64| {
            let mut sum = 0.0;
            energy.iter().position(|e| {
                sum += e;
                sum > share * total
            })
        };
        let samples = |seconds: f64| (seconds / motion.dt).ceil().min(1e9) as usize;
        let first = crossing(0.05).unwrap_or(0);
        let last = crossing(0.95).unwrap_or(n - 1);
        let longest = self.periods[1];
        [samples(longest).saturating_sub(first), samples(2.0 * longest).saturating_sub(n - 1 - last)]
    }

    /// Time over which the silence at both ends fades into the record, s.
    fn ramp(&self) -> f64 {
        0.2 * self.periods[1]
    }

    /// Pads, interpolates, scales to the target's mean level, takes off what lies far below the target.
    fn seed(
        &self,
        axis: usize,
        samples: &[f64],
        dt: f64,
        pads: [usize; 2],
        k: usize,
        target: &DesignSpectrum,
    ) -> Result<Seed, InputError> {
        let periods = log_periods(self.periods[0], self.periods[1], SEED_PERIODS);
        let found = psa(samples, dt, &periods, target.damping());
        let logarithms = periods.iter().zip(&found).map(|(t, found)| (target.psa(*t) / found).ln());
        let scale = (logarithms.sum::<f64>() / periods.len() as f64).exp();
        if !(scale.is_finite() && scale > 0.0) {
            let problem = format!("component {} does not move", AXES[axis]);
            return unfit(STEP, problem, "leave the component out, or choose another seed");
        }
        let mut padded = vec![0.0; pads[0] + samples.len() + pads[1]];
        for (padded, sample) in padded[pads[0]..].iter_mut().zip(samples) {
            *padded = scale * sample;
        }
        let count = (padded.len() - 1) * k + 1;
        let mut spectrum = Spectrum::of(&padded, dt, PAD_SECONDS);
        let whole = spectrum.periodic(0, k, count);
        let window = BandWindow::new(0.7 / self.periods[1].max(10.0), 0.5 / dt, dt);
        spectrum.apply(|f| window.gain(f));
        let mut start = spectrum.periodic(0, k, count);
        for (i, value) in start.iter_mut().enumerate() {
            let from_end = i.min(count - 1 - i) as f64 * dt / k as f64;
            if from_end < self.ramp() {
                *value *= 0.5 * (1.0 - (PI * from_end / self.ramp()).cos());
            }
        }
        Ok(Seed { whole, start, scale })
    }

    /// The iteration for one component; keeps the best result.
    fn match_one(
        &self,
        axis: usize,
        seed: &Seed,
        dt: f64,
        spectrum: &DesignSpectrum,
    ) -> Result<Match, InputError> {
        let metric = self.metric(seed, dt, spectrum);
        let mut target = self.target(spectrum);
        let spacing = (spectrum.damping() / 3.0).min(1.0);
        let octaves = (self.periods[1] / self.periods[0]).ln();
        let checks = ((octaves / spacing).ceil() as usize + 1).max(CHECK_PERIODS);
        let checks = log_periods(self.periods[0], self.periods[1], checks);
        let mut current = seed.start.clone();
        let shapes = adjust::rest(current.len()).map(|shares| metric.apply(0, &shares));
        let mut best: Option<Match> = None;
        let mut left = EFFORT_IN_ALL_TO;
        for iterations in 1..=self.iterations {
            // Half-cycles grow in number while the spectrum is approached: the first iteration is the smallest one.
            let share = if iterations == 1 { 0.25 } else { 1.0 };
            let most = (share * EFFORT_TO).min(left);
            let Some(effort) = adjust::iterate(&mut current, dt, &target, &metric, most) else {
                return self.too_long(axis, iterations, spectrum);
            };
            left -= effort;
            let mut record = current.clone();
            bring_to_rest(&mut record, dt, &shapes);
            let found = psa(&record, dt, &checks, spectrum.damping());
            let mut extremes = [(f64::INFINITY, 0.0), (0.0, 0.0)];
            for (period, psa) in checks.iter().zip(&found) {
                let ratio = psa / spectrum.psa(*period);
                let off = (ratio - 1.0).abs();
                // A dip between two fitted periods is fitted from now on.
                if off > 0.85 * self.tolerance && off < 2.0 * self.tolerance {
                    target.add(*period, displacement(spectrum, *period));
                }
                if ratio < extremes[0].0 {
                    extremes[0] = (ratio, *period);
                }
                if ratio > extremes[1].0 {
                    extremes[1] = (ratio, *period);
                }
            }
            let now = Match { record, extremes, iterations };
            if best.as_ref().is_none_or(|best| now.off() < best.off()) {
                best = Some(now);
            }
            if best.as_ref().is_some_and(|best| best.off() <= GOOD * self.tolerance) {
                break;
            }
        }
        match best {
            Some(best) if best.off() <= self.tolerance => Ok(best),
            other => Err(self.not_matched(axis, other.map_or((f64::NAN, f64::NAN), |best| best.worst()))),
        }
    }

    fn too_long<T>(&self, axis: usize, iteration: usize, spectrum: &DesignSpectrum) -> Result<T, InputError> {
        let problem = format!(
            "component {}: at a damping of {} and from {} s to {} s the match would take minutes or more (stopped in \
             iteration {iteration})",
            AXES[axis],
            nine(spectrum.damping()),
            nine(self.periods[0]),
            nine(self.periods[1])
        );
        let remedy = "take the spectrum at a higher damping, trim the record to its strong part, raise the shortest \
                      period, or choose a seed nearer to the spectrum";
        unfit(STEP, problem, remedy)
    }

    fn not_matched(&self, axis: usize, (ratio, period): (f64, f64)) -> InputError {
        let [low, high] = [1.0 - self.tolerance, 1.0 + self.tolerance];
        let (component, iterations) = (AXES[axis], self.iterations);
        InputError::NotMatched { component, ratio, period, low, high, iterations }
    }

    /// Periods of the constraints: as close as the damping asks, and some beyond the longest one.
    fn target(&self, spectrum: &DesignSpectrum) -> Target {
        let [shortest, longest] = self.periods;
        let damping = spectrum.damping();
        let spacing = (0.7 * damping).clamp(0.008, 0.035);
        let count = |ratio: f64| (ratio.ln() / spacing).ceil() as usize + 1;
        let mut periods = log_periods(shortest, longest, count(longest / shortest));
        periods.extend(log_periods(longest, BEYOND * longest, count(BEYOND)).into_iter().skip(1));
        let displacements = periods.iter().map(|period| displacement(spectrum, *period)).collect();
        Target { periods, displacements, longest, damping, margin: MARGIN * self.tolerance }
    }

    /// The cost of changes: cheap where and at frequencies at which the target or the seed is strong.
    fn metric(&self, seed: &Seed, dt: f64, spectrum: &DesignSpectrum) -> Metric {
        let [shortest, longest] = self.periods;
        let periods = log_periods(shortest, longest, SEED_PERIODS);
        let own = psa(&seed.start, dt, &periods, spectrum.damping());
        let last = (SEED_PERIODS - 1) as f64;
        let nearest = |period: f64| {
            let place = (period / shortest).ln() / (longest / shortest).ln() * last;
            own[place.round().clamp(0.0, last) as usize]
        };
        Metric::new(&seed.start, dt, self.ramp(), |f| {
            let edge = ((f * longest - 0.25) / 0.4).clamp(0.0, 1.0);
            let psa = spectrum.psa(1.0 / f).max(nearest(1.0 / f));
            (psa / (TAU * f) * (0.5 * PI * edge).sin()).powi(2)
        })
    }
}

/// What one component's match came to, for the step.
fn described(seed: &Seed, matched: &Match, dt: f64) -> Value {
    let peaks = |a: &[f64]| {
        let of = |to| history(a, dt, to).iter().fold(0.0, |peak: f64, value| peak.max(value.abs()));
        [of(Quantity::Acceleration), of(Quantity::Velocity), of(Quantity::Displacement)]
    };
    let (before, after) = (peaks(&seed.whole), peaks(&matched.record));
    let [velocity, displacement] = at_end(&matched.record, dt);
    let [low, high] = matched.extremes;
    json!({
        "scale": seed.scale, "iterations": matched.iterations,
        "ratio_min": low.0, "ratio_min_period_s": low.1,
        "ratio_max": high.0, "ratio_max_period_s": high.1,
        "correlation": correlation(&seed.whole, &matched.record),
        "pga_scaled_m_s2": before[0], "pga_m_s2": after[0],
        "pgv_scaled_m_s": before[1], "pgv_m_s": after[1],
        "pgd_scaled_m": before[2], "pgd_m": after[2],
        "velocity_end_m_s": velocity, "displacement_end_m": displacement,
    })
}

/// Largest relative displacement (m) that goes with the spectrum at a period (s).
fn displacement(spectrum: &DesignSpectrum, period: f64) -> f64 {
    spectrum.psa(period) * (period / TAU).powi(2)
}

fn history(a: &[f64], dt: f64, to: Quantity) -> Vec<f64> {
    resample_as(a, dt, Quantity::Acceleration, to, 1)
}

/// Velocity (m/s) and displacement (m) at the last sample, from rest at the first.
fn at_end(a: &[f64], dt: f64) -> [f64; 2] {
    [Quantity::Velocity, Quantity::Displacement].map(|to| *history(a, dt, to).last().unwrap_or(&0.0))
}

/// Takes velocity and displacement at the last sample to zero, to round-off.
///
/// The iteration has already brought them near it by sums over the samples; the rest is the difference
/// between such sums and the integrals of the band-limited record.
fn bring_to_rest(a: &mut [f64], dt: f64, shapes: &[Vec<f64>; 2]) {
    let [first, second] = [at_end(&shapes[0], dt), at_end(&shapes[1], dt)];
    let determinant = first[0] * second[1] - second[0] * first[1];
    if !(determinant.is_finite() && determinant != 0.0) {
        return;
    }
    for _ in 0..3 {
        let left = at_end(a, dt);
        let alpha = (left[1] * second[0] - left[0] * second[1]) / determinant;
        let beta = (left[0] * first[1] - left[1] * first[0]) / determinant;
        for ((a, x), y) in a.iter_mut().zip(&shapes[0]).zip(&shapes[1]) {
            *a += alpha * x + beta * y;
        }
    }
}

/// Coefficient of correlation of two records about zero.
fn correlation(x: &[f64], y: &[f64]) -> f64 {
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    dot(x, y) / (dot(x, x) * dot(y, y)).sqrt()
}
