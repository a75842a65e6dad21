//! What a change of the record costs: little where and at frequencies at which the motion is strong.

use std::f64::consts::PI;
use std::sync::Arc;

use num_complex::Complex64;
use realfft::{ComplexToReal, RealFftPlanner, RealToComplex};

use super::super::padded_length;

/// Frequencies between the bands, Hz; each passes into the next over one octave.
const CROSSOVERS: [f64; 1] = [0.6];

/// Width over which the envelope of each band is smoothed, s; its floor as a share of its peak.
const BANDS: [(f64, f64); 2] = [(4.0, 0.12), (1.2, 0.03)];

/// The operator `W = Σ_b E_b F_b² E_b`: covariance of the changes that are thought likely.
///
/// `E_b(t)` is the seed's envelope, smoothed as suits the band, zero at both ends of the record; `F_b²(f)` a
/// gain over frequency times the band's weight, the weights adding up to 1. The gain is the square of the
/// larger of both pseudo-velocities at 1/f, target's and seed's (an estimate of the Fourier amplitudes of
/// motions that have those spectra). W is symmetric and never negative: `⟨δ, W⁻¹δ⟩` is the cost of a
/// change δ, and no change reaches beyond the record or far below the frequencies of the target.
pub(super) struct Metric {
    envelopes: Vec<Vec<f64>>,
    gains: Vec<Vec<f64>>,
    forward: Arc<dyn RealToComplex<f64>>,
    inverse: Arc<dyn ComplexToReal<f64>>,
}

impl Metric {
    /// - `seed`: m/s², step `dt` (s); `gain`: F² over frequency (Hz).
    /// - `ramp`: over which every envelope rises from zero at both ends of the record, s.
    pub(super) fn new(seed: &[f64], dt: f64, ramp: f64, gain: impl Fn(f64) -> f64) -> Self {
        let length = padded_length(seed.len(), dt, 10.0);
        let mut planner = RealFftPlanner::<f64>::new();
        let (forward, inverse) = (planner.plan_fft_forward(length), planner.plan_fft_inverse(length));
        let n = seed.len();
        let ends: Vec<f64> = (0..n)
            .map(|i| {
                let from_end = i.min(n - 1 - i) as f64 * dt;
                if from_end < ramp { 0.5 * (1.0 - (PI * from_end / ramp).cos()) } else { 1.0 }
            })
            .collect();
        let energy: Vec<f64> = seed.iter().map(|a| a * a).collect();
        let envelopes = BANDS.map(|(width, floor)| {
            let smooth = smoothed(&energy, width / dt);
            let peak = smooth.iter().fold(0.0, |peak: f64, value| peak.max(*value));
            let value = |(e, end): (&f64, &f64)| (e / peak).sqrt().max(floor) * end;
            smooth.iter().zip(&ends).map(value).collect()
        });
        let frequency = |bin: usize| bin as f64 / (length as f64 * dt);
        let largest = (1..=length / 2).map(|bin| gain(frequency(bin))).fold(0.0, f64::max);
        let gains = (0..BANDS.len()).map(|band| {
            let value = |bin: usize| {
                let f = frequency(bin);
                if f > 0.0 { band_weight(band, f) * gain(f) / largest / length as f64 } else { 0.0 }
            };
            (0..=length / 2).map(value).collect()
        });
        Self { envelopes: envelopes.into(), gains: gains.collect(), forward, inverse }
    }

    /// W times the samples `values` that begin at index `first` (zero elsewhere).
    pub(super) fn apply(&self, first: usize, values: &[f64]) -> Vec<f64> {
        let n = self.envelopes[0].len();
        let mut out = vec![0.0; n];
        let mut bins = self.forward.make_output_vec();
        let mut buffer = self.forward.make_input_vec();
        for (envelope, gain) in self.envelopes.iter().zip(&self.gains) {
            buffer.fill(0.0);
            for (i, value) in values.iter().enumerate() {
                buffer[first + i] = value * envelope[first + i];
            }
            self.forward.process(&mut buffer, &mut bins).expect("buffers come from the plan");
            bins.iter_mut().zip(gain).for_each(|(bin, gain)| *bin *= gain);
            let last = bins.len() - 1;
            bins[last] = Complex64::new(bins[last].re, 0.0);
            self.inverse.process(&mut bins, &mut buffer).expect("ends are real");
            for ((out, value), envelope) in out.iter_mut().zip(&buffer).zip(envelope) {
                *out += value * envelope;
            }
        }
        out
    }
}

/// Share of a band at a frequency: sin² and cos² of the octave around each crossover.
fn band_weight(band: usize, f: f64) -> f64 {
    let above = |crossover: f64| {
        let octave = ((f / crossover).log2() + 0.5).clamp(0.0, 1.0);
        (0.5 * PI * octave).sin().powi(2)
    };
    let enters = if band == 0 { 1.0 } else { above(CROSSOVERS[band - 1]) };
    let leaves = CROSSOVERS.get(band).map_or(0.0, |crossover| above(*crossover));
    enters - leaves
}

/// Three passes of a running mean: close to a Gaussian of standard deviation `width`/2 samples.
fn smoothed(x: &[f64], width: f64) -> Vec<f64> {
    let half = ((width / 2.0).round() as usize).max(1);
    let mut values = x.to_vec();
    for _ in 0..3 {
        let mut sums = vec![0.0];
        for value in &values {
            sums.push(sums[sums.len() - 1] + value);
        }
        let n = values.len();
        for i in 0..n {
            let (from, to) = (i.saturating_sub(half), (i + half + 1).min(n));
            values[i] = (sums[to] - sums[from]) / (2 * half + 1) as f64;
        }
    }
    values
}
