//! The polygon that drives the oscillators: a record at finer steps, the same for all periods of a step.

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use num_complex::Complex64;
use realfft::{ComplexToReal, RealFftPlanner};

use super::parallel;
use crate::motion::{PAD_SECONDS, Spectrum};

/// Steps per period of the oscillator at least, after interpolation.
pub(super) const STEPS_PER_PERIOD: f64 = 20.0;

/// Largest factor of interpolation; shorter periods (T < 0.31 dt) follow the ground anyway.
pub(super) const UPSAMPLING_LIMIT: usize = 64;

/// Smallest power of two that brings the step to T/20 or below, within the limit.
pub(super) fn upsampling(dt: f64, period: f64) -> usize {
    let wanted = STEPS_PER_PERIOD * dt / period;
    let mut k = 1;
    // Round-off of a period such as 20 dt must not double the work.
    while (k as f64) < wanted * (1.0 - 1e-9) && k < UPSAMPLING_LIMIT {
        k *= 2;
    }
    k
}

/// Records of one length and step as the corners of polygons.
pub(super) struct Grounds {
    spectra: Vec<Spectrum>,
    plan: Arc<dyn ComplexToReal<f64>>,
    samples: usize,
}

impl Grounds {
    /// Records (m/s², step `dt` in s) of the same length, two samples or more.
    pub(super) fn new(records: &[&[f64]], dt: f64) -> Self {
        let samples = records.first().map_or(0, |record| record.len());
        let worth = samples * records.len() > 1 << 15;
        let spectra = parallel::each(records, worth, |record| Spectrum::of(record, dt, PAD_SECONDS));
        let length = spectra.first().map_or(2, |spectrum| 2 * (spectrum.bins.len() - 1));
        Self { spectra, plan: RealFftPlanner::new().plan_fft_inverse(length), samples }
    }

    /// Corners at step `dt/k` of every record; inside the record's band the polygon has its spectrum.
    ///
    /// Straight lines between corners damp a harmonic f by `sinc²(f dt/k)`: the harmonics are divided by
    /// it beforehand. Each of the k interleaved phases is a transform of the record's own length, which
    /// stays in the processor's cache where one long transform would not.
    pub(super) fn corners(&self, k: usize) -> Vec<Vec<f64>> {
        let tasks: Vec<(usize, usize)> =
            (0..self.spectra.len()).flat_map(|r| (0..k).map(move |phase| (r, phase))).collect();
        let worth = self.samples * tasks.len() > 1 << 15;
        let gain = self.gains(k);
        let phases =
            parallel::each(&tasks, worth, |&(r, phase)| self.phase(&self.spectra[r], &gain, phase, k));
        let records: Vec<&[Vec<f64>]> = phases.chunks(k).collect();
        parallel::each(&records, worth, |phases| interleaved(phases, self.samples))
    }

    /// What each harmonic is multiplied by, the transform's own scale included.
    fn gains(&self, k: usize) -> Vec<f64> {
        let length = self.plan.len();
        let step = PI / (length * k) as f64;
        (0..=length / 2)
            .map(|bin| {
                let x = bin as f64 * step;
                let lines = if bin == 0 { 1.0 } else { (x / x.sin()).powi(2) };
                lines / length as f64
            })
            .collect()
    }

    /// Samples at the times `(n + phase/k) dt`.
    fn phase(&self, spectrum: &Spectrum, gain: &[f64], phase: usize, k: usize) -> Vec<f64> {
        let length = self.plan.len();
        let half = length / 2;
        let mut bins: Vec<Complex64> = Vec::with_capacity(half + 1);
        let turn = TAU * phase as f64 / (length * k) as f64;
        // Two short tables of rotations replace a sine and a cosine per bin.
        const FINE: usize = 512;
        let fine: Vec<Complex64> = (0..FINE).map(|m| Complex64::cis(turn * m as f64)).collect();
        for (block, values) in spectrum.bins.chunks(FINE).enumerate() {
            let coarse = Complex64::cis(turn * (block * FINE) as f64);
            let gains = &gain[block * FINE..];
            bins.extend(values.iter().zip(gains).zip(&fine).map(|((x, g), f)| x * (coarse * f) * g));
        }
        bins[0].im = 0.0;
        // The Nyquist harmonic is a cosine: between the samples it is smaller, not turned.
        let nyquist = spectrum.bins[half].re * (PI * phase as f64 / k as f64).cos() * gain[half];
        bins[half] = Complex64::new(nyquist, 0.0);
        let mut out = self.plan.make_output_vec();
        self.plan.process(&mut bins, &mut out).expect("buffers come from the plan, ends are real");
        out.truncate(self.samples);
        out
    }
}

/// One series from k series that take turns; ends with the last sample of the first.
fn interleaved(phases: &[Vec<f64>], samples: usize) -> Vec<f64> {
    let k = phases.len();
    let mut out = Vec::with_capacity(samples * k);
    for n in 0..samples {
        out.extend(phases.iter().map(|phase| phase[n]));
    }
    out.truncate((samples - 1) * k + 1);
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One long transform of the padded spectrum: the definition, for comparison.
    fn long_transform(record: &[f64], dt: f64, k: usize) -> Vec<f64> {
        let step = dt / k as f64;
        let mut corners = Spectrum::of(record, dt, PAD_SECONDS);
        corners.apply(|f| {
            let x = PI * f * step;
            if x < 1e-9 { 1.0 } else { (x / x.sin()).powi(2) }
        });
        corners.periodic(0, k, (record.len() - 1) * k + 1)
    }

    #[test]
    fn interleaved_phases_are_the_long_transform() {
        let dt = 0.02;
        // A record with energy at Nyquist and an end that is not zero.
        let record: Vec<f64> =
            (0..501).map(|i| (i as f64 * 0.7).sin() + if i % 2 == 0 { 0.5 } else { -0.5 }).collect();
        let grounds = Grounds::new(&[&record, &record[..]], dt);
        for k in [1, 2, 8, 64] {
            let wanted = long_transform(&record, dt, k);
            let found = grounds.corners(k);
            assert_eq!(found[1].len(), 500 * k + 1);
            for (a, b) in found[1].iter().zip(&wanted) {
                assert!((a - b).abs() < 1e-12, "{k}: {a} {b}");
            }
        }
    }
}
