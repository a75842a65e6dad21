//! What engineers ask of an accelerogram: peaks, intensity, duration, response and Fourier spectra.
//!
//! Accelerations in m/s², times in s. None of these functions fails: see each for what it gives for an
//! empty or motionless record.

mod fourier;
mod response;

pub use fourier::{fourier_amplitude, konno_ohmachi, mean_period};
pub use response::{ResponseSpectrum, log_periods, psa, response_spectrum};

use std::f64::consts::PI;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::motion::{BandWindow, Quantity, STANDARD_GRAVITY, Spectrum, resample_as};

/// Measures of one component of ground acceleration.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
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
    /// ∫a² dt and the Husid curve use the trapezoidal rule (exact for a band-limited record that ends
    /// at zero); ∫|a| dt is exact for straight lines between samples, changes of sign included. A
    /// record without energy gives zeros.
    #[must_use]
    pub fn of(acceleration: &[f64], dt: f64, f_min: f64) -> Self {
        let energy = cumulative_energy(acceleration, dt);
        let total = energy.last().copied().unwrap_or(0.0);
        let [t5, t75, t95] = [0.05, 0.75, 0.95].map(|share| crossing(&energy, dt, share * total));
        Self {
            pga: peak(acceleration),
            pgv: peak(&integrated(acceleration, dt, f_min, Quantity::Velocity)),
            pgd: peak(&integrated(acceleration, dt, f_min, Quantity::Displacement)),
            arias_intensity: PI / (2.0 * STANDARD_GRAVITY) * total,
            cav: absolute_integral(acceleration, dt),
            d5_75: t75 - t5,
            d5_95: t95 - t5,
            mean_period: mean_period(acceleration, dt),
        }
    }
}

fn peak(x: &[f64]) -> f64 {
    x.iter().fold(0.0, |peak: f64, value| peak.max(value.abs()))
}

fn integrated(acceleration: &[f64], dt: f64, f_min: f64, to: Quantity) -> Vec<f64> {
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

/// First time at which a non-decreasing curve reaches `level`, straight lines between samples.
fn crossing(curve: &[f64], dt: f64, level: f64) -> f64 {
    let next = curve.partition_point(|value| *value < level);
    if next == 0 || next >= curve.len() {
        return next.min(curve.len().saturating_sub(1)) as f64 * dt;
    }
    let (low, high) = (curve[next - 1], curve[next]);
    (next as f64 - 1.0 + (level - low) / (high - low)) * dt
}

/// ∫|a| dt of straight lines between samples.
fn absolute_integral(a: &[f64], dt: f64) -> f64 {
    a.windows(2)
        .map(|pair| {
            let (from, to) = (pair[0].abs(), pair[1].abs());
            if pair[0] * pair[1] < 0.0 {
                // Two triangles that meet where the line crosses zero.
                0.5 * dt * (from * from + to * to) / (from + to)
            } else {
                0.5 * dt * (from + to)
            }
        })
        .sum()
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
