//! Spectral calculus on records: between its samples a record is band-limited.
//!
//! A record of `n` samples is continued with zeros to the length [`padded_length`] and expanded in
//! the harmonics of that longer period. Integration, differentiation and interpolation then act on
//! each harmonic exactly; no rule of the time domain is involved.

use std::f64::consts::{PI, TAU};

use num_complex::Complex64;
use realfft::RealFftPlanner;

use super::Quantity;

/// Zeros that follow a record in every transform, s.
pub const PAD_SECONDS: f64 = 20.0;

/// Largest number of zeros when the record itself is shorter than that.
const PAD_SAMPLES: usize = 1 << 20;

/// Length of the transform of `n` samples at `dt` (s) followed by at least `pad_seconds` of zeros.
///
/// The smallest even number `2^a 3^b 5^c` not below `n + ceil(pad_seconds/dt)`. Even, so that there
/// is a Nyquist bin; only the factors 2, 3 and 5, so that the transform is fast. For very small steps
/// the zeros are limited to the larger of 2²⁰ and `n` samples, so that memory stays in proportion.
#[must_use]
pub fn padded_length(n: usize, dt: f64, pad_seconds: f64) -> usize {
    let wanted = (pad_seconds / dt).ceil();
    let most = PAD_SAMPLES.max(n);
    // A step that is zero or not a number falls to the limit too.
    let zeros = if wanted < most as f64 { wanted.max(0.0) as usize } else { most };
    even_5_smooth(n + zeros)
}

/// Smallest even `2^a 3^b 5^c` (a ≥ 1) not below `least`.
pub(super) fn even_5_smooth(least: usize) -> usize {
    let mut best = least.max(2).next_power_of_two();
    let mut fives = 1;
    while fives < best {
        let mut odd = fives;
        while odd < best {
            let mut candidate = odd * 2;
            while candidate < least {
                candidate *= 2;
            }
            best = best.min(candidate);
            odd *= 3;
        }
        fives *= 5;
    }
    best
}

/// Harmonics of a zero-padded record, `x(t) = (1/M) Σ X_m exp(i 2π f_m t)`, `f_m = m/(M dt)`.
#[derive(Debug, Clone)]
pub(crate) struct Spectrum {
    /// Bins 0 to M/2 of the forward transform (not scaled).
    pub(crate) bins: Vec<Complex64>,
    length: usize,
    dt: f64,
}

impl Spectrum {
    /// Transform of `x` (step `dt`, s) followed by `pad_seconds` of zeros; `O(M log M)`.
    pub(crate) fn of(x: &[f64], dt: f64, pad_seconds: f64) -> Self {
        Self::of_length(x, dt, padded_length(x.len(), dt, pad_seconds))
    }

    /// Transform of `x` (step `dt`, s) followed by zeros up to `length`, which is even.
    pub(super) fn of_length(x: &[f64], dt: f64, length: usize) -> Self {
        let mut padded = vec![0.0; length];
        padded[..x.len()].copy_from_slice(x);
        let plan = RealFftPlanner::<f64>::new().plan_fft_forward(length);
        let mut bins = plan.make_output_vec();
        plan.process(&mut padded, &mut bins).expect("buffers come from the plan");
        Self { bins, length, dt }
    }

    /// Frequency of a bin, Hz.
    pub(crate) fn frequency(&self, bin: usize) -> f64 {
        bin as f64 / (self.length as f64 * self.dt)
    }

    /// Multiplies each harmonic by a real gain of its frequency (Hz): no change of phase.
    pub(crate) fn apply(&mut self, gain: impl Fn(f64) -> f64) {
        for bin in 0..self.bins.len() {
            let f = self.frequency(bin);
            self.bins[bin] *= gain(f);
        }
    }

    /// Mean over the padded period, which is the amplitude of the bin at 0 Hz.
    fn mean(&self) -> f64 {
        self.bins[0].re / self.length as f64
    }

    /// `(iω)^power` of a bin; 0 at 0 Hz unless `power` is 0.
    fn factor(&self, bin: usize, power: i32) -> Complex64 {
        if power == 0 {
            Complex64::new(1.0, 0.0)
        } else if bin == 0 {
            Complex64::new(0.0, 0.0)
        } else {
            let omega = TAU * self.frequency(bin);
            let magnitude = omega.powi(power);
            match power.rem_euclid(4) {
                0 => Complex64::new(magnitude, 0.0),
                1 => Complex64::new(0.0, magnitude),
                2 => Complex64::new(-magnitude, 0.0),
                _ => Complex64::new(0.0, -magnitude),
            }
        }
    }

    /// First `count` samples at step `dt/k` of the periodic part of the `power`-th derivative
    /// (negative: antiderivative without its mean).
    ///
    /// The Nyquist harmonic is a cosine, `X_N cos(π t/dt)/M`: half of it stands on either side when
    /// k > 1; at the original samples its odd derivatives vanish.
    pub(crate) fn periodic(&self, power: i32, k: usize, count: usize) -> Vec<f64> {
        let half = self.length / 2;
        let long = self.length * k;
        let mut bins = vec![Complex64::new(0.0, 0.0); long / 2 + 1];
        for (bin, value) in self.bins.iter().enumerate() {
            bins[bin] = value * self.factor(bin, power) / self.length as f64;
        }
        if k > 1 {
            bins[half] *= 0.5;
        } else {
            bins[half].im = 0.0;
        }
        bins[0].im = 0.0;
        let plan = RealFftPlanner::<f64>::new().plan_fft_inverse(long);
        let mut out = plan.make_output_vec();
        plan.process(&mut bins, &mut out).expect("buffers come from the plan, ends are real");
        out.truncate(count);
        out
    }

    /// First `count` samples at the step with which `length` (even) samples fill the padded period.
    ///
    /// What lies above the new Nyquist frequency is dropped; the gain has to be zero there, or it is missed.
    pub(super) fn at_length(&self, length: usize, count: usize) -> Vec<f64> {
        let (half, new_half) = (self.length / 2, length / 2);
        let mut bins = vec![Complex64::new(0.0, 0.0); new_half + 1];
        for bin in 0..=half.min(new_half) {
            bins[bin] = self.bins[bin] / self.length as f64;
        }
        if new_half > half {
            // The Nyquist cosine: half of it stands on either side, as in `periodic`.
            bins[half] *= 0.5;
        }
        bins[0].im = 0.0;
        bins[new_half].im = 0.0;
        let plan = RealFftPlanner::<f64>::new().plan_fft_inverse(length);
        let mut out = plan.make_output_vec();
        plan.process(&mut bins, &mut out).expect("buffers come from the plan, ends are real");
        out.truncate(count);
        out
    }

    /// Value at t = 0 of the first antiderivative's periodic part (its mean is zero).
    fn antiderivative_at_start(&self) -> f64 {
        // The Nyquist cosine integrates to a sine, which is zero at t = 0.
        let sum: f64 = (1..self.length / 2).map(|bin| 2.0 * (self.bins[bin] * self.factor(bin, -1)).re).sum();
        sum / self.length as f64
    }
}

/// Samples at step `dt/k` over the record's own time, `(n - 1) k + 1` of them (0 for an empty record).
fn count_upsampled(n: usize, k: usize) -> usize {
    if n == 0 { 0 } else { (n - 1) * k + 1 }
}

/// Turns `from` into `to` and interpolates to the step `dt/k`, in one pass through the frequencies.
///
/// - `x`: one component of the quantity `from`, SI, step `dt` (s); `k ≥ 1` (0 counts as 1).
/// - returns `(n - 1) k + 1` samples of `to`, SI, at t = 0, dt/k, …, (n - 1) dt.
///
/// Each harmonic of the zero-padded record is multiplied by `(iω)^p`, p = derivatives of `to` less
/// those of `from`. With p = 0 the result passes through the original samples.
///
/// **Integration** (p < 0). The harmonic at 0 Hz has no periodic antiderivative: the mean ā over the
/// padded period integrates to the line ā t (p = −1) or the parabola ā t²/2 (p = −2), which is added
/// in the time domain. The constants are chosen so that the motion starts from rest: with the
/// periodic parts p₁ (velocity) and p₂ (displacement) of an acceleration,
/// `v = ā t + p₁(t) − p₁(0)`, `d = ā t²/2 − p₁(0) t + p₂(t) − p₂(0)`, so v(0) = d(0) = 0 exactly and
/// v is the exact integral of the band-limited record from 0. Nothing is removed in secret: an
/// offset of the acceleration appears as a drift of the velocity, as it does in the record. Remove it
/// before ([`Process`](super::Process)) where the drift has no physical meaning.
///
/// **Differentiation** (p > 0). The straight line from the first to the last sample is taken off
/// before and its slope (p = 1) or nothing (p = 2) added after, so that a record that ends away from zero
/// does not jump to the zeros behind it. A record whose slope at an end is not the line's still rings
/// over the samples there.
///
/// Cost `O(k M log(k M))` with M from [`padded_length`].
#[must_use]
pub fn resample_as(x: &[f64], dt: f64, from: Quantity, to: Quantity, k: usize) -> Vec<f64> {
    let k = k.max(1);
    let power = to.derivative_order() - from.derivative_order();
    let count = count_upsampled(x.len(), k);
    if count == 0 {
        return Vec::new();
    }
    if power == 0 && k == 1 {
        return x.to_vec();
    }
    if power > 0 {
        return differentiated(x, dt, power, k, count);
    }
    let spectrum = Spectrum::of(x, dt, PAD_SECONDS);
    let mut out = spectrum.periodic(power, k, count);
    if power < 0 {
        let mean = spectrum.mean();
        let slope = if power == -2 { -spectrum.antiderivative_at_start() } else { mean };
        let curvature = if power == -2 { mean } else { 0.0 };
        let start = out[0];
        for (i, value) in out.iter_mut().enumerate() {
            let t = i as f64 * dt / k as f64;
            *value += (0.5 * curvature * t + slope) * t - start;
        }
    }
    out
}

/// The derivative of the record less the line through its ends, plus that of the line.
fn differentiated(x: &[f64], dt: f64, power: i32, k: usize, count: usize) -> Vec<f64> {
    let last = x.len() - 1;
    let rise = if last == 0 { 0.0 } else { (x[last] - x[0]) / last as f64 };
    let level: Vec<f64> = x.iter().enumerate().map(|(i, x_i)| x_i - x[0] - rise * i as f64).collect();
    let mut out = Spectrum::of(&level, dt, PAD_SECONDS).periodic(power, k, count);
    if power == 1 {
        out.iter_mut().for_each(|value| *value += rise / dt);
    }
    out
}

/// `∫₀ᵗ x dτ` of the band-limited record at its own samples, 0 at the first; see [`resample_as`].
///
/// An offset of `x` gives a drift of the result; steps and lengths as in [`resample_as`].
#[must_use]
pub fn integrate(x: &[f64], dt: f64) -> Vec<f64> {
    resample_as(x, dt, Quantity::Acceleration, Quantity::Velocity, 1)
}

/// `dx/dt` of the band-limited record at its own samples; see [`resample_as`].
///
/// At the samples the Nyquist harmonic contributes nothing (it is a cosine with its extremes there).
#[must_use]
pub fn differentiate(x: &[f64], dt: f64) -> Vec<f64> {
    resample_as(x, dt, Quantity::Velocity, Quantity::Acceleration, 1)
}

/// Band-limited interpolation of `x` (step `dt`, s) to the step `dt/k`.
///
/// Returns `(n - 1) k + 1` samples; every k-th is the original one to round-off.
#[must_use]
pub fn upsample(x: &[f64], dt: f64, k: usize) -> Vec<f64> {
    resample_as(x, dt, Quantity::Acceleration, Quantity::Acceleration, k)
}

/// Frequencies (Hz) inside which a record must be carried to be right to `accuracy` (relative L2).
///
/// With A(f) the transform of the zero-padded acceleration,
/// `f_max` is the lowest frequency with `∫_{f > f_max} |A|² df ≤ (accuracy/2)²/2 · ∫|A|² df`, and
/// `f_min` the highest with the same share below it, but not less than 1/duration: dropping both ends
/// costs a relative L2 error of accuracy/2, which leaves the other half to the computation.
///
/// - `acceleration`: any unit; `dt` in s. Several components: take the smallest `f_min` and the
///   largest `f_max`.
/// - a record without energy gives (1/duration, Nyquist). An offset counts as energy at 0 Hz: remove
///   it before.
#[must_use]
pub fn usable_band(acceleration: &[f64], dt: f64, accuracy: f64) -> (f64, f64) {
    let nyquist = 0.5 / dt;
    let lowest = 1.0 / (acceleration.len().max(1) as f64 * dt);
    if acceleration.is_empty() {
        return (lowest, nyquist);
    }
    let spectrum = Spectrum::of(acceleration, dt, PAD_SECONDS);
    let last = spectrum.bins.len() - 1;
    let energy: Vec<f64> = (0..=last)
        .map(|bin| {
            let both_sides = if bin == 0 || bin == last { 1.0 } else { 2.0 };
            both_sides * spectrum.bins[bin].norm_sqr()
        })
        .collect();
    let share = 0.5 * (0.5 * accuracy).powi(2) * energy.iter().sum::<f64>();
    if share.is_nan() || share <= 0.0 {
        return (lowest, nyquist);
    }
    let mut top = last;
    let mut dropped = 0.0;
    while top > 0 && dropped + energy[top] <= share {
        dropped += energy[top];
        top -= 1;
    }
    let mut bottom = 0;
    dropped = 0.0;
    while bottom < top && dropped + energy[bottom] <= share {
        dropped += energy[bottom];
        bottom += 1;
    }
    let f_max = spectrum.frequency(top).min(nyquist);
    let f_min = spectrum.frequency(bottom).max(lowest);
    (f_min.min(nyquist), f_max.max(f_min).min(nyquist))
}

/// A real, zero-phase gain over frequency: flat inside a band, half-cosine roll-offs outside.
///
/// `gain = 0` below f_min/2, `½(1 − cos(π (f − f_min/2)/(f_min/2)))` up to f_min, 1 up to f_max,
/// `½(1 + cos(π (f − f_max)/(f_stop − f_max)))` up to f_stop = min(1.25 f_max, Nyquist), then 0.
/// f_min = 0 leaves the low end (and the offset) alone; f_max = Nyquist leaves the high end alone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BandWindow {
    /// Lower edge of the flat part, Hz.
    pub f_min: f64,
    /// Upper edge of the flat part, Hz.
    pub f_max: f64,
    /// Frequency from which the gain is zero, Hz.
    pub f_stop: f64,
}

impl BandWindow {
    /// The window of a band (Hz) for a step `dt` (s).
    #[must_use]
    pub fn new(f_min: f64, f_max: f64, dt: f64) -> Self {
        Self { f_min, f_max, f_stop: (1.25 * f_max).min(0.5 / dt) }
    }

    /// Gain at a frequency (Hz), between 0 and 1.
    #[must_use]
    pub fn gain(&self, f: f64) -> f64 {
        let start = 0.5 * self.f_min;
        if f < self.f_min {
            if f <= start {
                return 0.0;
            }
            return 0.5 * (1.0 - (PI * (f - start) / (self.f_min - start)).cos());
        }
        // Round-off of a bin's frequency must not cut the edge itself.
        if f <= self.f_max * (1.0 + 1e-12) {
            return 1.0;
        }
        if f >= self.f_stop {
            return 0.0;
        }
        0.5 * (1.0 + (PI * (f - self.f_max) / (self.f_stop - self.f_max)).cos())
    }

    /// Zeros to put behind a record before this window is applied, s: its response in time lasts a
    /// few periods of `f_min`.
    #[must_use]
    pub fn pad_seconds(&self) -> f64 {
        if self.f_min > 0.0 { PAD_SECONDS.max(4.0 / self.f_min) } else { PAD_SECONDS }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// +1, −1, … over a whole period: all energy in the last bin, which is a cosine between samples.
    #[test]
    fn the_last_bin_is_a_cosine_and_its_derivatives_follow() {
        let (n, dt, k) = (12, 0.1, 4);
        let x: Vec<f64> = (0..n).map(|i| if i % 2 == 0 { 1.0 } else { -1.0 }).collect();
        let spectrum = Spectrum::of(&x, dt, 0.0);
        assert_eq!(spectrum.bins.len(), n / 2 + 1);
        let rate = PI / dt;
        type Shape = fn(f64) -> f64;
        let expected: [(i32, Shape, f64); 5] = [
            (0, f64::cos, 1.0),
            (1, f64::sin, -rate),
            (2, f64::cos, -rate * rate),
            (-1, f64::sin, 1.0 / rate),
            (-2, f64::cos, -1.0 / (rate * rate)),
        ];
        for (power, shape, scale) in expected {
            for k in [1, k] {
                let found = spectrum.periodic(power, k, n * k);
                for (i, value) in found.iter().enumerate() {
                    let wanted = scale * shape(PI * i as f64 / k as f64);
                    assert!((value - wanted).abs() < 1e-12 * scale.abs(), "{power} {k} {i}");
                }
            }
        }
    }

    /// A harmonic of the period, with the mean: derivatives exact, antiderivatives with zero mean.
    #[test]
    fn harmonics_are_exact_for_even_factors_and_odd_ones() {
        let (n, dt) = (20, 0.05);
        let omega = TAU * 3.0 / (n as f64 * dt);
        let x: Vec<f64> = (0..n).map(|i| 2.0 + (omega * i as f64 * dt).cos()).collect();
        let spectrum = Spectrum::of(&x, dt, 0.0);
        assert!((spectrum.mean() - 2.0).abs() < 1e-14);
        assert!(spectrum.antiderivative_at_start().abs() < 1e-14);
        for k in [1, 2, 3] {
            let velocity = spectrum.periodic(-1, k, n * k);
            for (i, value) in velocity.iter().enumerate() {
                let t = i as f64 * dt / k as f64;
                assert!((value - (omega * t).sin() / omega).abs() < 1e-13);
            }
        }
    }
}
