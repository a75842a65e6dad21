//! Pulses with a closed form: the shapes of synthetic motions and the time functions of sources.

use std::f64::consts::PI;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Shape of a source's time function.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum PulseKind {
    /// A (1 − 2τ²) exp(−τ²) with τ = π f (t − time): zero mean, spectrum with its peak at f.
    Ricker,
    /// A exp(−τ²) with τ = π f (t − time).
    Gaussian,
    /// A sin(2π f (t − time)) under a Hann window of `cycles` periods centred at `time`: zero mean.
    SineBurst,
    /// A (1 + erf τ)/2 with τ = π f (t − time): a smooth step from 0 to A, whose rate is the Gaussian pulse of the same
    /// f; nine tenths of it happen within 0.74/f.
    Ramp,
}

/// A source's time function with a closed form.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Pulse {
    /// Shape of the pulse.
    pub kind: PulseKind,
    /// Frequency f of the pulse.
    #[schemars(extend("exclusiveMinimum" = 0.0, "x-unit" = "Hz"))]
    pub frequency: f64,
    /// Factor A on the source's `force`, `moment` or `traction`; negative turns the pulse over.
    #[serde(default = "one")]
    #[schemars(extend("x-unit" = "1"))]
    pub amplitude: f64,
    /// Time of the pulse's centre, between 0 and the run's `duration`.
    #[schemars(extend("minimum" = 0.0, "x-unit" = "s"))]
    pub time: f64,
    /// Number of periods under the window of a `sine_burst`; required there, refused elsewhere.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0.0, "x-unit" = "1", "x-default" = "required for `sine_burst`"))]
    pub cycles: Option<f64>,
}

pub(super) fn one() -> f64 {
    1.0
}

/// Error function to round-off: erf x = 2/√π exp(−x²) Σ 2ⁿ x²ⁿ⁺¹/(2n + 1)!!, whose terms all have one sign.
///
/// Abramowitz & Stegun (1964), 7.1.6. Beyond 6 the rest, 2e−17, is below the last digit.
pub fn erf(x: f64) -> f64 {
    if x.abs() >= 6.0 || x.is_nan() {
        return if x.is_nan() { x } else { x.signum() };
    }
    let (mut term, mut sum, mut n) = (x, x, 1.0);
    while term.abs() > f64::EPSILON * sum.abs() {
        term *= 2.0 * x * x / (2.0 * n + 1.0);
        sum += term;
        n += 1.0;
    }
    2.0 / PI.sqrt() * (-x * x).exp() * sum
}

impl Pulse {
    /// Value at time `t` (s), in the unit of the amplitude.
    pub fn value(&self, t: f64) -> f64 {
        let tau = PI * self.frequency * (t - self.time);
        match self.kind {
            PulseKind::Ricker => self.amplitude * (1.0 - 2.0 * tau * tau) * (-tau * tau).exp(),
            PulseKind::Gaussian => self.amplitude * (-tau * tau).exp(),
            PulseKind::SineBurst => {
                // Window phase: ±π at the ends of the burst, `cycles` periods apart.
                let window = 2.0 * tau / self.cycles.unwrap_or(1.0);
                if window.abs() >= PI {
                    0.0
                } else {
                    self.amplitude * 0.5 * (1.0 + window.cos()) * (2.0 * tau).sin()
                }
            }
            PulseKind::Ramp => self.amplitude * 0.5 * (1.0 + erf(tau)),
        }
    }

    /// Half of the time in which the pulse, or a ramp's distance from its ends, exceeds a thousandth of its amplitude, s.
    ///
    /// Ricker: |1 − 2τ²| exp(−τ²) = 10⁻³ at τ = 3.19; Gaussian: τ = √(ln 1000) = 2.63; burst: half its window; ramp:
    /// (1 − erf τ)/2 = 10⁻³ at τ = 2.185.
    pub fn half_width(&self) -> f64 {
        match self.kind {
            PulseKind::Ricker => 3.19 / (PI * self.frequency),
            PulseKind::Gaussian => 2.63 / (PI * self.frequency),
            PulseKind::SineBurst => 0.5 * self.cycles.unwrap_or(1.0) / self.frequency,
            PulseKind::Ramp => 2.185 / (PI * self.frequency),
        }
    }

    /// Frequency above which the amplitude spectrum stays below `share` of its peak, Hz; `share` in (0, 1).
    ///
    /// With x the frequency over f: Ricker x² exp(1 − x²); Gaussian exp(−x²); burst of c cycles, with y = c |x − 1|, at
    /// most 1/(π y (y² − 1)) beyond its main lobe y < 2. A ramp's spectrum has no peak: its rate's, a Gaussian's, counts.
    pub fn highest_frequency(&self, share: f64) -> f64 {
        // All three fall without end beyond `from`: bisection cannot miss.
        let solve = |from: f64, spectrum: &dyn Fn(f64) -> f64| {
            let (mut low, mut high) = (from, 2.0 * from);
            while spectrum(high) > share && high < 1e6 {
                (low, high) = (high, 2.0 * high);
            }
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                if spectrum(middle) > share { low = middle } else { high = middle }
            }
            high
        };
        self.frequency
            * match self.kind {
                PulseKind::Ricker => solve(1.0, &|x| x * x * (1.0 - x * x).exp()),
                PulseKind::Gaussian | PulseKind::Ramp => (-share.ln()).max(0.0).sqrt(),
                PulseKind::SineBurst => {
                    let y = solve(2.0, &|y| 1.0 / (PI * y * (y * y - 1.0)));
                    1.0 + y / self.cycles.unwrap_or(1.0)
                }
            }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::{assert_abs_diff_eq, assert_relative_eq};

    fn pulse(kind: PulseKind) -> Pulse {
        let cycles = (kind == PulseKind::SineBurst).then_some(4.0);
        Pulse { kind, frequency: 5.0, amplitude: -2.0, time: 1.0, cycles }
    }

    #[test]
    fn error_function_has_the_tables_values() {
        // Abramowitz & Stegun, table 7.1.
        for (x, value) in [(0.5, 0.5204998778), (1.0, 0.8427007929), (2.0, 0.9953222650)] {
            assert_abs_diff_eq!(erf(x), value, epsilon = 1e-10);
            assert_eq!(erf(-x), -erf(x));
        }
        assert_eq!((erf(0.0), erf(7.0), erf(f64::NEG_INFINITY)), (0.0, 1.0, -1.0));
        assert_abs_diff_eq!(erf(5.9999999), 1.0, epsilon = 1e-15);
    }

    #[test]
    fn a_ramp_is_the_gaussians_integral() {
        let (ramp, rate) = (pulse(PulseKind::Ramp), pulse(PulseKind::Gaussian));
        let (t, h) = (1.03, 1e-5);
        let slope = (ramp.value(t + h) - ramp.value(t - h)) / (2.0 * h);
        // The Gaussian's integral over all times is A/(f √π).
        assert_relative_eq!(slope, rate.value(t) * 5.0 * PI.sqrt(), max_relative = 1e-8);
        assert_eq!((ramp.value(1.0), ramp.value(9.0), ramp.value(-9.0)), (-1.0, -2.0, 0.0));
        let from_to = |t: f64| ramp.value(1.0 + t) - ramp.value(1.0 - t);
        assert_abs_diff_eq!(from_to(0.37 / 5.0), 0.9 * -2.0, epsilon = 2e-3);
    }

    #[test]
    fn a_thousandth_is_left_at_the_half_width() {
        for kind in [PulseKind::Ricker, PulseKind::Gaussian, PulseKind::Ramp] {
            let w = pulse(kind);
            let rest = w.value(w.time - w.half_width()).abs() / 2.0;
            assert!((0.5e-3..1.1e-3).contains(&rest), "{kind:?}: {rest}");
        }
    }

    /// Amplitude spectrum by quadrature of the pulse, or of a ramp's rate.
    fn spectrum(p: &Pulse, f: f64) -> f64 {
        let dt = 1e-3;
        let value = |t: f64| match p.kind {
            PulseKind::Ramp => Pulse { kind: PulseKind::Gaussian, ..*p }.value(t),
            _ => p.value(t),
        };
        let sum = |wave: fn(f64) -> f64| -> f64 {
            (0..2000).map(|i| i as f64 * dt).map(|t| value(t) * wave(2.0 * PI * f * t) * dt).sum()
        };
        sum(f64::cos).hypot(sum(f64::sin))
    }

    #[test]
    fn the_spectrum_ends_at_the_highest_frequency() {
        for kind in [PulseKind::Ricker, PulseKind::Gaussian, PulseKind::SineBurst, PulseKind::Ramp] {
            let p = pulse(kind);
            let grid = |from: f64, to: f64| (0..200).map(move |i| from + (to - from) * i as f64 / 200.0);
            let peak = grid(0.0, 20.0).map(|f| spectrum(&p, f)).fold(0.0, f64::max);
            for share in [0.1, 1e-2, 1e-3] {
                let top = p.highest_frequency(share);
                let beyond = grid(top, 5.0 * top.min(80.0)).map(|f| spectrum(&p, f)).fold(0.0, f64::max);
                assert!(beyond <= 1.001 * share * peak, "{kind:?} {share}: {}", beyond / peak);
                let before = grid(0.6 * top, top).map(|f| spectrum(&p, f)).fold(0.0, f64::max);
                assert!(before >= share * peak, "{kind:?} {share}: {top} Hz is too high");
            }
        }
    }
}
