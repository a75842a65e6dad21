//! What engineers ask of an accelerogram: peaks, intensity, duration, response and Fourier spectra.
//!
//! Accelerations in m/s², times in s. None of these functions fails: see each for what it gives for an
//! empty or motionless record.

mod design;
mod fourier;
mod ground;
mod oscillator;
pub(crate) mod parallel;
mod response;
mod rotated;

pub use design::{DesignSpectrum, Direction, Eurocode8, Ground, Rg160, SpectrumPoints, SpectrumType};
pub use fourier::{
    fourier_amplitude, horizontal_to_vertical, konno_ohmachi, konno_ohmachi_each, mean_period,
    ratio_of_smoothed,
};
pub use response::{ResponseSpectrum, log_periods, psa, response_spectrum};
pub use rotated::{RotatedSpectrum, rotated_spectrum};

use std::f64::consts::PI;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::motion::{BandWindow, PAD_SECONDS, Quantity, STANDARD_GRAVITY, Spectrum, resample_as};
use oscillator::{State, step_peak, turning_point};

/// Measures of one component of ground acceleration.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Measures {
    /// Peak ground acceleration, max |a| at the samples, m/s².
    pub pga: f64,
    /// Peak ground velocity, m/s; see [`Measures::of`] for the integration.
    pub pgv: f64,
    /// Peak ground displacement, m; see [`Measures::of`] for the integration.
    pub pgd: f64,
    /// Arias intensity, π/(2g) ∫a² dt, m/s.
    pub arias_intensity: f64,
    /// Cumulative absolute velocity, ∫|a| dt, m/s.
    pub cav: f64,
    /// Time of the first 5 % of the Arias intensity, from the first sample, s: where d5_75 and d5_95 begin.
    pub t5: f64,
    /// Time between 5 % and 75 % of the Arias intensity, s.
    pub d5_75: f64,
    /// Time between 5 % and 95 % of the Arias intensity, s.
    pub d5_95: f64,
    /// Mean period of the Fourier amplitudes from 0.25 to 20 Hz, s; see [`mean_period`].
    pub mean_period: f64,
}

impl Measures {
    /// All measures of one component.
    ///
    /// - `acceleration`: m/s², step `dt` (s).
    /// - `f_min`: lowest frequency (Hz) that the record carries. PGV and PGD come from the spectral
    ///   antiderivatives after the window of [`BandWindow`] with this lower edge, without added
    ///   constants, so that they do not see the drift of an offset. With 0 they are the antiderivatives
    ///   from rest ([`resample_as`]), drift included. A `f_min` that is not positive counts as 0.
    ///
    /// Between its samples the record is band-limited, and the measures are those of that curve:
    /// - the Arias intensity is the sum of a² dt (trapezoidal rule), exact for a record that ends at zero;
    /// - the times of 5, 75 and 95 % come from the record at a quarter of its step, with ∫a² dt to fourth
    ///   order;
    /// - CAV is the way that the velocity goes up and down: its difference over each step of one sign,
    ///   and by way of its extreme (cubic through velocity and acceleration) over a step with a change of
    ///   sign. Two changes of sign within one step are not seen;
    /// - PGV and PGD are the largest of those cubics too. PGA alone is taken at the samples, as the custom is.
    ///
    /// Each is within 0.1 % of the curve's own for records with ten samples or more in a cycle. Programs
    /// that join the samples by straight lines find a smaller CAV: by 3 % for a sine of ten samples per
    /// cycle, 0.1 % for one of sixty. A record without energy gives zeros; an empty one, too.
    ///
    /// Cost: six transforms of the record's length; about 40 ms for 240 000 samples.
    #[must_use]
    pub fn of(acceleration: &[f64], dt: f64, f_min: f64) -> Self {
        if acceleration.is_empty() {
            return Self::default();
        }
        let raw = Spectrum::of(acceleration, dt, PAD_SECONDS);
        let fine = raw.periodic(0, REFINED, (acceleration.len() - 1) * REFINED + 1);
        let [t5, t75, t95] = times_of_shares(&fine, dt / REFINED as f64, [0.05, 0.75, 0.95]);
        let from_rest = resample_as(acceleration, dt, Quantity::Acceleration, Quantity::Velocity, 1);
        let (pgv, pgd) = peaks_of_integrals(acceleration, &from_rest, dt, f_min);
        let energy = cumulative_energy(acceleration, dt).last().copied().unwrap_or(0.0);
        Self {
            pga: peak(acceleration),
            pgv,
            pgd,
            arias_intensity: PI / (2.0 * STANDARD_GRAVITY) * energy,
            cav: way(&from_rest, acceleration, dt),
            t5,
            d5_75: t75 - t5,
            d5_95: t95 - t5,
            mean_period: fourier::mean_period_of(&raw),
        }
    }
}

/// Points per sample of the energy whose 5, 75 and 95 % are looked for.
const REFINED: usize = 4;

/// Largest velocity and displacement; see [`Measures::of`].
fn peaks_of_integrals(acceleration: &[f64], from_rest: &[f64], dt: f64, f_min: f64) -> (f64, f64) {
    let n = acceleration.len();
    let nyquist = 0.5 / dt;
    if !(f_min > 0.0 && f_min < nyquist) {
        let displacement = resample_as(acceleration, dt, Quantity::Acceleration, Quantity::Displacement, 1);
        return (peak_between(from_rest, acceleration, dt), peak_between(&displacement, from_rest, dt));
    }
    let window = BandWindow::new(f_min, nyquist, dt);
    let mut spectrum = Spectrum::of(acceleration, dt, window.pad_seconds());
    spectrum.apply(|f| window.gain(f));
    let [a, v, d] = [0, -1, -2].map(|power| spectrum.periodic(power, 1, n));
    (peak_between(&v, &a, dt), peak_between(&d, &v, dt))
}

/// Values and rates at both ends of each step.
fn steps<'a>(x: &'a [f64], rate: &'a [f64]) -> impl Iterator<Item = (State, State)> + 'a {
    let state = |i: usize| State { u: x[i], v: rate[i] };
    (1..x.len().min(rate.len())).map(move |i| (state(i - 1), state(i)))
}

/// max |x| between samples too, from the cubic through values and rates of change.
fn peak_between(x: &[f64], rate: &[f64], dt: f64) -> f64 {
    let first = x.first().map_or(0.0, |x| x.abs());
    steps(x, rate).fold(first, |peak: f64, (from, to)| peak.max(step_peak(from, to, dt)))
}

/// Build-up of the cumulative absolute velocity, ∫₀ᵗ |a| dτ at the samples, m/s; its end is [`Measures::cav`].
///
/// `acceleration` in m/s², step `dt` (s). As long as the record; zeros for one without motion.
#[must_use]
pub fn cumulative_absolute_velocity(acceleration: &[f64], dt: f64) -> Vec<f64> {
    let velocity = resample_as(acceleration, dt, Quantity::Acceleration, Quantity::Velocity, 1);
    let start = acceleration.first().map(|_| 0.0);
    let sums = ways(&velocity, acceleration, dt).scan(0.0, |sum, way| {
        *sum += way;
        Some(*sum)
    });
    start.into_iter().chain(sums).collect()
}

/// The way that `x` goes up and down, ∫|rate| dt; see [`Measures::of`].
fn way(x: &[f64], rate: &[f64], dt: f64) -> f64 {
    ways(x, rate, dt).sum()
}

/// The same step by step.
fn ways<'a>(x: &'a [f64], rate: &'a [f64], dt: f64) -> impl Iterator<Item = f64> + 'a {
    let step = move |(from, to): (State, State)| {
        if from.v * to.v < 0.0 {
            let turn = turning_point(from, to, dt);
            (turn - from.u).abs() + (to.u - turn).abs()
        } else {
            (to.u - from.u).abs()
        }
    };
    steps(x, rate).map(step)
}

fn peak(x: &[f64]) -> f64 {
    x.iter().fold(0.0, |peak: f64, value| peak.max(value.abs()))
}

/// The velocity or displacement that PGV and PGD are the peaks of, at the samples; see [`Measures::of`].
#[must_use]
pub fn integrated(acceleration: &[f64], dt: f64, f_min: f64, to: Quantity) -> Vec<f64> {
    let nyquist = 0.5 / dt;
    let low_cut = f_min > 0.0 && f_min < nyquist && !acceleration.is_empty();
    if !low_cut {
        return resample_as(acceleration, dt, Quantity::Acceleration, to, 1);
    }
    let window = BandWindow::new(f_min, nyquist, dt);
    let mut spectrum = Spectrum::of(acceleration, dt, window.pad_seconds());
    spectrum.apply(|f| window.gain(f));
    let power = to.derivative_order() - Quantity::Acceleration.derivative_order();
    spectrum.periodic(power, 1, acceleration.len())
}

/// ∫₀ᵗ a² dτ at the samples by the trapezoidal rule.
fn cumulative_energy(a: &[f64], dt: f64) -> Vec<f64> {
    let mut sum = 0.0;
    let mut energy = Vec::with_capacity(a.len());
    for (i, value) in a.iter().enumerate() {
        if i > 0 {
            sum += 0.5 * dt * (a[i - 1] * a[i - 1] + value * value);
        }
        energy.push(sum);
    }
    energy
}

/// First times at which ∫a² dt reaches these shares of its end, s; `a` well resolved by its step `dt` (s).
///
/// Each step takes `h/24 (−f₋₁ + 13 f₀ + 13 f₁ − f₂)` of f = a², exact for cubics, and inside a step f is a
/// straight line.
fn times_of_shares<const N: usize>(a: &[f64], dt: f64, shares: [f64; N]) -> [f64; N] {
    let f = |i: usize| a[i] * a[i];
    let mut energy = Vec::with_capacity(a.len());
    let mut sum = 0.0;
    for i in 0..a.len() {
        if i > 0 {
            let (before, after) = (f(i.saturating_sub(2)), f((i + 1).min(a.len() - 1)));
            // Never down, whatever round-off says where there is no motion.
            sum += (dt / 24.0 * (13.0 * (f(i - 1) + f(i)) - before - after)).max(0.0);
        }
        energy.push(sum);
    }
    shares.map(|share| {
        let level = share * sum;
        let next = energy.partition_point(|value| *value < level);
        if next == 0 || next >= energy.len() {
            return next.min(energy.len().saturating_sub(1)) as f64 * dt;
        }
        let part = (level - energy[next - 1]) / (energy[next] - energy[next - 1]);
        let (f0, f1) = (f(next - 1), f(next));
        let root = (f0 * f0 + part * (f1 * f1 - f0 * f0)).max(0.0).sqrt();
        let inside = if f0 + root > 0.0 { part * (f0 + f1) / (f0 + root) } else { part };
        (next as f64 - 1.0 + inside) * dt
    })
}

/// Husid curve: share of the Arias intensity reached at each sample, from 0 to 1.
///
/// `H(t) = ∫₀ᵗ a² dτ / ∫ a² dt`, trapezoidal rule, same length as `a`; zeros for a record without
/// energy. `dt` (s) cancels; it stands here so that all measures are called alike.
#[must_use]
pub fn husid(a: &[f64], dt: f64) -> Vec<f64> {
    let mut energy = cumulative_energy(a, dt);
    let total = energy.last().copied().unwrap_or(0.0);
    if total > 0.0 {
        energy.iter_mut().for_each(|value| *value /= total);
    }
    energy
}
