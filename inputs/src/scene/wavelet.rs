//! Synthetic motions: pulses with a closed form, for scenes without a record.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::pulse::{Pulse, PulseKind};

/// Shape of a synthetic motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum WaveletKind {
    /// A (1 − 2τ²) exp(−τ²) with τ = π f (t − time): zero mean, spectrum with its peak at f.
    Ricker,
    /// A exp(−τ²) with τ = π f (t − time). Its mean is not zero: as an acceleration it leaves a lasting velocity.
    Gaussian,
    /// A sin(2π f (t − time)) under a Hann window of `cycles` periods centred at `time`: zero mean.
    SineBurst,
}

impl From<WaveletKind> for PulseKind {
    fn from(kind: WaveletKind) -> Self {
        match kind {
            WaveletKind::Ricker => Self::Ricker,
            WaveletKind::Gaussian => Self::Gaussian,
            WaveletKind::SineBurst => Self::SineBurst,
        }
    }
}

/// A pulse with a closed form, in place of a record.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Wavelet {
    /// Shape of the pulse.
    pub kind: WaveletKind,
    /// Frequency f of the pulse; below 0.4/dt, and better below 0.16/dt for a Ricker pulse, whose spectrum reaches to 3 f.
    #[schemars(extend("exclusiveMinimum" = 0.0, "x-unit" = "Hz"))]
    pub frequency: f64,
    /// Amplitude A, in the SI unit of `motion.quantity` (m/s², m/s or m); negative turns the pulse over.
    #[schemars(extend("x-unit" = "m/s², m/s or m"))]
    pub amplitude: f64,
    /// Time of the pulse's centre, between 0 and `duration`; a Ricker pulse wants 1.1/f or more on either side.
    #[schemars(extend("minimum" = 0.0, "x-unit" = "s"))]
    pub time: f64,
    /// Sampling step.
    #[schemars(extend("exclusiveMinimum" = 0.0, "x-unit" = "s"))]
    pub dt: f64,
    /// Length of the motion: it has round(duration/dt) + 1 samples, the first at t = 0.
    #[schemars(extend("exclusiveMinimum" = 0.0, "x-unit" = "s"))]
    pub duration: f64,
    /// Number of periods under the window of a `sine_burst`; required there, refused elsewhere.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0.0, "x-unit" = "1", "x-default" = "required for `sine_burst`"))]
    pub cycles: Option<f64>,
}

impl Wavelet {
    /// The pulse without its sampling.
    pub fn pulse(&self) -> Pulse {
        let Self { frequency, amplitude, time, cycles, .. } = *self;
        Pulse { kind: self.kind.into(), frequency, amplitude, time, cycles }
    }

    /// Value at time `t` (s), in the unit of the amplitude.
    pub fn value(&self, t: f64) -> f64 {
        self.pulse().value(t)
    }

    /// Number of samples, round(duration/dt) + 1.
    pub fn sample_count(&self) -> usize {
        // A saturating cast: the scene's checks keep the quotient below 10⁷.
        (self.duration / self.dt).round() as usize + 1
    }

    /// Samples at t = i·dt, shape `[sample_count]`, in the unit of the amplitude.
    pub fn samples(&self) -> Vec<f64> {
        (0..self.sample_count()).map(|i| self.value(i as f64 * self.dt)).collect()
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use approx::assert_abs_diff_eq;

    fn wavelet(kind: WaveletKind, cycles: Option<f64>) -> Wavelet {
        Wavelet { kind, frequency: 5.0, amplitude: -2.0, time: 1.0, dt: 0.001, duration: 2.0, cycles }
    }

    #[test]
    fn ricker_has_its_peak_at_its_time_and_no_mean() {
        let w = wavelet(WaveletKind::Ricker, None);
        let a = w.samples();
        assert_eq!(a.len(), 2001);
        assert_abs_diff_eq!(a[1000], -2.0, epsilon = 1e-12);
        // Zero of the pulse at τ = 1/√2.
        let zero = 1.0 + 1.0 / (2f64.sqrt() * PI * 5.0);
        assert_abs_diff_eq!(w.value(zero), 0.0, epsilon = 1e-12);
        assert_abs_diff_eq!(a.iter().sum::<f64>() * w.dt, 0.0, epsilon = 1e-12);
    }

    #[test]
    fn gaussian_has_the_integral_of_its_closed_form() {
        let w = wavelet(WaveletKind::Gaussian, None);
        let sum = w.samples().iter().sum::<f64>() * w.dt;
        assert_abs_diff_eq!(sum, -2.0 / (5.0 * PI.sqrt()), epsilon = 1e-10);
    }

    #[test]
    fn burst_is_odd_about_its_time_and_ends_with_its_window() {
        let w = wavelet(WaveletKind::SineBurst, Some(4.0));
        let a = w.samples();
        for i in 0..1000 {
            assert_abs_diff_eq!(a[1000 - i], -a[1000 + i], epsilon = 1e-9);
        }
        assert_abs_diff_eq!(w.value(1.0 - 0.4), 0.0);
        assert_abs_diff_eq!(w.value(1.0 + 0.41), 0.0);
        // A twentieth of a second after the centre: phase π/2, window phase π/8.
        assert_abs_diff_eq!(w.value(1.05), -(1.0 + (PI / 8.0).cos()), epsilon = 1e-12);
    }
}
