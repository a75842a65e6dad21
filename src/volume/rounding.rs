//! What the rounding of numbers leaves of accelerations, and the precision that follows from it.

use super::sampling::Sampling;
use super::sizes::SHARE;
use super::sources::Signal;
use hati_inputs::scene::{Auto, Precision};

/// Factor of the noise, an upper bound of what was measured; see [`noise`].
const FACTOR: f64 = 2.0;

/// Round-off of a precision, $2^{-24}$ or $2^{-53}$.
fn epsilon(precision: Precision) -> f64 {
    match precision {
        Precision::F32 => 0.5 * f64::from(f32::EPSILON),
        Precision::F64 => 0.5 * f64::EPSILON,
    }
}

/// Ratio of the largest acceleration to the largest displacement that the sources ask for, s⁻²:
/// $\min_s \max_t|\ddot g_s| / \max_t|g_s|$ over the time functions $g_s$ of sources that act within the run.
///
/// A Gaussian pulse of frequency f has $2\pi^2f^2$, a Ricker pulse $6\pi^2f^2$. `None` where nothing acts.
pub fn curvature(signals: &[Signal], sampling: &Sampling) -> Option<f64> {
    let (h, count) = (sampling.sample_dt(), sampling.samples);
    let of = |signal: &Signal| {
        let g = signal.amplitude(h, count);
        let largest = g.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        let second = g.windows(3).map(|w| (w[0] - 2.0 * w[1] + w[2]).abs()).fold(0.0, f64::max) / (h * h);
        (largest > 0.0 && second > 0.0).then_some(second / largest)
    };
    signals.iter().filter_map(of).min_by(f64::total_cmp)
}

/// Largest error that rounding leaves in accelerations, as a share of their peak at the same place:
/// $$ \eta = c\,\varepsilon\,\sqrt{n}\;\frac{4}{\Delta t_c^2\,\omega_e^2} . $$
///
/// A position is stored to $\varepsilon|u|$ after every drift. The operator makes $\varepsilon|u|\,\omega_{max}^2$ of
/// it, $\omega_{max} = 2/\Delta t_c$, white in space and so of the grid's highest frequencies; the sources' motion has
/// $\omega_e^2|u|$ ([`curvature`]). The $n$ roundings of as many steps add up like a random walk: at a fixed mesh the
/// noise goes with $\Delta t^{-1/2}$ and not with $\Delta t^{-2}$.
///
/// - `steps`: n of the run, for displacement is rounded as long as it lasts.
/// - Measured, f32 against f64 at the same step, c for the largest difference at a station over the peak there:
///   0.06 and 0.66 for a force in an elastic box at steps of 0.26, 0.13, 0.07 and 0.03 of the critical one (0.07 and
///   0.67 at the last), 0.01 to 0.3 for explosions there, 0.006, 0.02 and 0.43 in `scenes/basin-2d`, and 0.8 in a
///   section of six elements. c = 2 bounds all of them, and most stations have a tenth of it or less: how much larger
///   displacement is near the source than at the station, and how long waves stay, is not in the formula.
pub fn noise(precision: Precision, curvature: f64, steps: u64, dt_critical: f64) -> f64 {
    FACTOR * epsilon(precision) * (steps as f64).sqrt() * 4.0 / (dt_critical * dt_critical * curvature)
}

/// A precision and why.
#[derive(Debug, Clone, PartialEq)]
pub struct Rounding {
    /// The precision of the run.
    pub precision: Precision,
    /// What f32 leaves in the worst motion that is written, as a share of its peak, at most about ([`noise`]).
    pub single: f64,
    /// What is allowed, [`SHARE`] of the accuracy.
    pub allowed: f64,
    /// The motion in words.
    pub motion: &'static str,
}

impl Rounding {
    /// Chooses: f64 where f32 would leave more than [`SHARE`] of the accuracy in a motion that is written.
    ///
    /// - `noise`: of accelerations in f32; `ratio`: $\omega_e\Delta t_c/2$, by which the noise of velocities is smaller,
    ///   since it has the grid's frequencies; `accelerations`: whether any is written.
    pub fn choose(
        asked: Auto<Precision>,
        noise: f64,
        ratio: f64,
        accelerations: bool,
        accuracy: f64,
    ) -> Self {
        let (single, motion) =
            if accelerations { (noise, "accelerations") } else { (noise * ratio.min(1.0), "velocities") };
        let allowed = SHARE * accuracy;
        let auto = if single > allowed { Precision::F64 } else { Precision::F32 };
        let precision = asked.value().copied().unwrap_or(auto);
        Self { precision, single, allowed, motion }
    }

    /// Why an automatic precision was taken.
    pub fn why(&self) -> String {
        let Self { single, allowed, motion, .. } = self;
        match self.precision {
            Precision::F32 => format!(
                "half the memory and up to twice the speed; its rounding leaves noise of at most some {single:.1e} of \
                 the peak in {motion}"
            ),
            Precision::F64 => format!(
                "single precision may leave noise of up to {single:.1e} of the peak in {motion}, where {allowed:.1e} \
                 is allowed: the motion is slow for so small a step"
            ),
        }
    }

    /// What to say of single precision that was asked for and leaves too much.
    pub fn warning(&self) -> Option<String> {
        let Self { single, allowed, motion, precision } = self;
        (*precision == Precision::F32 && single > allowed).then(|| {
            format!(
                "rounding in single precision may leave noise of up to {single:.1e} of the peak in {motion} (white, above \
                 the sources' frequencies; {allowed:.1e} is allowed): leave discretisation.precision to \"auto\", or set \
                 \"f64\""
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hati_inputs::scene::{Action, Place, Pulse, PulseKind, TimeFunction};
    use std::f64::consts::PI;

    fn signal(kind: PulseKind, frequency: f64) -> Signal {
        Signal {
            name: "a".into(),
            action: Action::Force { at: Place::Point([0.0; 3]), force: [1.0; 3] },
            time: TimeFunction::Pulse(Pulse { kind, frequency, amplitude: -3.0, time: 1.0, cycles: None }),
            record: None,
        }
    }

    #[test]
    fn curvature_is_that_of_the_closed_form_and_of_the_slowest_source() {
        let sampling = Sampling::new(1e-3, 50.0, None, 2.0);
        let of = |kind, f| curvature(&[signal(kind, f)], &sampling).expect("a source");
        let f2 = (PI * 4.0).powi(2);
        for (kind, expected) in [
            (PulseKind::Gaussian, 2.0 * f2),
            (PulseKind::Ricker, 6.0 * f2),
            (PulseKind::Ramp, (2.0 / PI).sqrt() * (-0.5_f64).exp() * f2),
        ] {
            let found = of(kind, 4.0);
            assert!((found / expected - 1.0).abs() < 5e-3, "{kind:?}: {found} for {expected}");
        }
        let both = [signal(PulseKind::Ricker, 4.0), signal(PulseKind::Gaussian, 1.0)];
        assert_eq!(curvature(&both, &sampling), Some(of(PulseKind::Gaussian, 1.0)));
        assert_eq!(curvature(&[], &sampling), None);
    }

    #[test]
    fn precision_switches_at_the_allowed_noise() {
        let choose = |noise, asked| Rounding::choose(asked, noise, 1e-2, true, 1e-2);
        let (below, above) = (choose(4.9e-3, Auto::Auto), choose(5.1e-3, Auto::Auto));
        assert_eq!((below.precision, above.precision), (Precision::F32, Precision::F64));
        assert!(below.warning().is_none() && above.warning().is_none());
        assert!(above.why().contains("5.1e-3") && above.why().contains("5.0e-3"));
        let given = choose(0.5, Auto::Value(Precision::F32));
        assert_eq!(given.precision, Precision::F32);
        assert!(given.warning().is_some_and(|w| w.contains("5.0e-1")));
        assert!(choose(1e-4, Auto::Value(Precision::F32)).warning().is_none());
        // velocities alone bear more
        assert_eq!(Rounding::choose(Auto::Auto, 0.4, 1e-2, false, 1e-2).precision, Precision::F32);
    }
}
