//! Extremes of linear oscillators, and the record's share in a displacement.

use std::f64::consts::{PI, TAU};

use num_complex::Complex64;

use super::super::Spectrum;

/// Steps per period of an oscillator at least.
const STEPS_PER_PERIOD: f64 = 20.0;

/// Largest factor of interpolation.
const UPSAMPLING_LIMIT: usize = 64;

/// Periods of the impulse response are followed until it has fallen to this share.
const FADED: f64 = 2e-3;

/// One displacement extreme: time (s from the first sample) and relative displacement (m), signed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Extreme {
    pub(super) time: f64,
    pub(super) displacement: f64,
}

/// A linear oscillator of one period and damping, from rest.
///
/// With λ = −ζω + iω_d, `z(t) = −∫₀ᵗ e^{λ(t−τ)} a(τ) dτ`, the displacement is Im z/ω_d and the velocity
/// Im(λz)/ω_d: one complex recursion carries both.
#[derive(Debug, Clone, Copy)]
pub(super) struct Oscillator {
    lambda: Complex64,
}

impl Oscillator {
    pub(super) fn new(period: f64, damping: f64) -> Self {
        let omega = TAU / period;
        Self { lambda: Complex64::new(-damping * omega, omega * (1.0 - damping * damping).sqrt()) }
    }

    /// All extremes of the displacement above `floor` (m) in absolute value, in time order.
    ///
    /// `ground` holds the corners of a polygon at `step` (s); the recursion is exact for it. After its
    /// end the first extreme of the free vibration counts too.
    pub(super) fn extremes(&self, ground: &[f64], step: f64, floor: f64) -> Vec<Extreme> {
        let lambda = self.lambda;
        let turn = (lambda * step).exp();
        // Weights of both corners of a straight stretch: ∫ e^{λs} s/h ds and ∫ e^{λs} (1 − s/h) ds.
        let to = -(turn - 1.0 - lambda * step) / (lambda * lambda * step);
        let from = -(turn - 1.0) / lambda - to;
        let mut found = Vec::new();
        let mut z = Complex64::new(0.0, 0.0);
        let (mut u, mut v) = (0.0, 0.0);
        for (n, pair) in ground.windows(2).enumerate() {
            z = turn * z + from * pair[0] + to * pair[1];
            let (next_u, next_v) = self.displacement_and_velocity(z);
            if v * next_v < 0.0 {
                let t = v / (v - next_v);
                let peak = hermite(u, v, next_u, next_v, step, t);
                if peak.abs() > floor {
                    found.push(Extreme { time: (n as f64 + t) * step, displacement: peak });
                }
            }
            (u, v) = (next_u, next_v);
        }
        // In free vibration z turns by λ; the velocity Im(λz) vanishes where λz is real.
        let later = (-(lambda * z).arg()).rem_euclid(PI) / lambda.im;
        let (peak, _) = self.displacement_and_velocity(z * (lambda * later).exp());
        if peak.abs() > floor {
            let end = ground.len().saturating_sub(1) as f64 * step;
            found.push(Extreme { time: end + later, displacement: peak });
        }
        found
    }

    fn displacement_and_velocity(&self, z: Complex64) -> (f64, f64) {
        (z.im / self.lambda.im, (self.lambda * z).im / self.lambda.im)
    }

    /// Derivative of the displacement at `time` by each sample of a record with step `dt` (s).
    ///
    /// `−dt/ω_d · Im e^{λ(t − t_n)}` for t_n ≤ t. Returns the index of its first sample and the values;
    /// older samples have less than [`FADED`] of the share of the last ones.
    pub(super) fn shares(&self, time: f64, dt: f64, samples: usize) -> (usize, Vec<f64>) {
        let last = ((time / dt).floor() as usize).min(samples - 1);
        let memory = (FADED.ln() / self.lambda.re / dt).ceil() as usize;
        let first = last.saturating_sub(memory);
        let turn = (-self.lambda * dt).exp();
        let mut z = (self.lambda * (time - first as f64 * dt)).exp() * (-dt / self.lambda.im);
        let values = (first..=last)
            .map(|_| {
                let share = z.im;
                z *= turn;
                share
            })
            .collect();
        (first, values)
    }
}

/// Cubic through displacement and velocity at both ends of a step, at the share `t` of it.
fn hermite(u: f64, v: f64, next_u: f64, next_v: f64, step: f64, t: f64) -> f64 {
    let s = 1.0 - t;
    u * s * s * (1.0 + 2.0 * t) + next_u * t * t * (1.0 + 2.0 * s) + step * s * t * (v * s - next_v * t)
}

/// Extremes of several oscillators on one record (m/s², step `dt`), those above `floors` (m).
///
/// The record is interpolated in the frequency domain to T/20, as for
/// [`response_spectrum`](crate::measures::response_spectrum), with the harmonics divided by what straight
/// lines take from them.
pub(super) fn extremes(
    acceleration: &[f64],
    dt: f64,
    periods: &[f64],
    damping: f64,
    floors: &[f64],
) -> Vec<Vec<Extreme>> {
    let spectrum = Spectrum::of(acceleration, dt, 1.0);
    let mut found = vec![Vec::new(); periods.len()];
    let mut k = 1;
    while k <= UPSAMPLING_LIMIT {
        let members: Vec<usize> = (0..periods.len()).filter(|i| upsampling(dt, periods[*i]) == k).collect();
        if !members.is_empty() {
            let step = dt / k as f64;
            let mut corners = spectrum.clone();
            corners.apply(|f| {
                let x = PI * f * step;
                if x < 1e-9 { 1.0 } else { (x / x.sin()).powi(2) }
            });
            let ground = corners.periodic(0, k, (acceleration.len() - 1) * k + 1);
            for i in members {
                found[i] = Oscillator::new(periods[i], damping).extremes(&ground, step, floors[i]);
            }
        }
        k *= 2;
    }
    found
}

/// Smallest power of two that brings the step to T/20 or below, within the limit.
fn upsampling(dt: f64, period: f64) -> usize {
    let mut k = 1;
    while (k as f64) < STEPS_PER_PERIOD * dt / period * (1.0 - 1e-9) && k < UPSAMPLING_LIMIT {
        k *= 2;
    }
    k
}
