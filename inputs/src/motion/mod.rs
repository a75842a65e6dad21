//! A ground motion of one to three components, and what is done to it before it drives a model.
//!
//! Every operation is deterministic and leaves a [`Step`] with its numbers. Frequencies in Hz, times
//! in s, samples in SI. Between its samples a motion is band-limited: see [`resample_as`].

mod assembly;
mod filter;
mod matching;
mod process;
mod processing;
mod quantity;
mod resampling;
mod rest;
mod scaling;
mod spectrum;
mod step;
mod trend;

pub(crate) use filter::{FILTER_ORDER, FILTER_ORDER_TO};
pub(crate) use scaling::SCALING_DAMPING;
pub(crate) use spectrum::Spectrum;
pub(crate) use trend::TREND_ORDER_TO;

pub use filter::Filter;
pub use matching::Matching;
pub use process::Process;
pub(crate) use processing::SAMPLES_TO as PAD_SAMPLES_TO;
pub use quantity::Quantity;
pub use scaling::Scaling;
pub use spectrum::{
    BandWindow, PAD_SECONDS, differentiate, integrate, padded_length, resample_as, upsample, usable_band,
};
pub use step::Step;

use crate::error::InputError;

/// Standard gravity, m/s² (exact by definition).
pub const STANDARD_GRAVITY: f64 = 9.80665;

/// Relative distance from 1 g within which the mean of an accelerogram is called gravity.
const GRAVITY_TOLERANCE: f64 = 0.05;

/// The sign of the gravity that a channel with this mean (SI) carries: an acceleration within 5 % of ±1 g.
#[must_use]
pub fn gravity(quantity: Quantity, mean: f64) -> Option<f64> {
    let off = (mean.abs() - STANDARD_GRAVITY).abs() / STANDARD_GRAVITY;
    (quantity == Quantity::Acceleration && off <= GRAVITY_TOLERANCE).then_some(mean.signum())
}

/// Names of the axes by index: x, y horizontal, z up.
pub const AXES: [&str; 3] = ["x", "y", "z"];

/// One to three components of ground motion with a common step and start.
#[derive(Debug, Clone, PartialEq)]
pub struct Motion {
    /// Time step, s.
    pub dt: f64,
    /// Time of the first sample, s since 1970-01-01 UTC; absent when unknown.
    pub start: Option<f64>,
    /// What the samples are.
    pub quantity: Quantity,
    /// Samples along x, y (horizontal) and z (up), SI; all present ones of one length.
    pub components: [Option<Vec<f64>>; 3],
    /// What was done so far, in order.
    pub steps: Vec<Step>,
}

impl Motion {
    /// A motion from its samples.
    ///
    /// Errors: no component; lengths that differ; fewer than 2 samples; a step that is not positive;
    /// a sample that is not finite.
    pub fn new(
        dt: f64,
        start: Option<f64>,
        quantity: Quantity,
        components: [Option<Vec<f64>>; 3],
    ) -> Result<Self, InputError> {
        const STEP: &str = "motion";
        if !(dt.is_finite() && dt > 0.0) {
            return Err(InputError::StepParameter {
                step: STEP,
                parameter: "dt",
                found: dt,
                expected: "a positive time step in s".into(),
                remedy: "give the step between two samples".into(),
            });
        }
        let mut first: Option<(usize, usize)> = None;
        for (axis, samples) in components.iter().enumerate() {
            let Some(samples) = samples else { continue };
            if samples.len() < 2 {
                return Err(InputError::StepParameter {
                    step: STEP,
                    parameter: "number of samples",
                    found: samples.len() as f64,
                    expected: "at least 2".into(),
                    remedy: "give a longer record".into(),
                });
            }
            if let Some(value) = samples.iter().find(|value| !value.is_finite()) {
                return Err(InputError::StepParameter {
                    step: STEP,
                    parameter: "sample",
                    found: *value,
                    expected: format!("finite samples in component {}", AXES[axis]),
                    remedy: "repair the record at its source".into(),
                });
            }
            match first {
                None => first = Some((axis, samples.len())),
                Some((other, length)) if length != samples.len() => {
                    return Err(InputError::ComponentsDiffer {
                        first: AXES[other],
                        second: AXES[axis],
                        what: "number of samples",
                        first_value: length.to_string(),
                        second_value: samples.len().to_string(),
                    });
                }
                Some(_) => {}
            }
        }
        if first.is_none() {
            return Err(InputError::NoComponent);
        }
        Ok(Self { dt, start, quantity, components, steps: Vec::new() })
    }

    /// Number of samples of each component.
    #[must_use]
    pub fn len(&self) -> usize {
        self.components.iter().flatten().map(Vec::len).next().unwrap_or(0)
    }

    /// Whether there is no sample at all (never so for a motion from [`Motion::new`]).
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Time from the first to the last sample, s.
    #[must_use]
    pub fn duration(&self) -> f64 {
        self.len().saturating_sub(1) as f64 * self.dt
    }

    /// Largest absolute sample over all components, SI (at the samples, not between them).
    #[must_use]
    pub fn peak(&self) -> f64 {
        let samples = self.components.iter().flatten().flatten();
        samples.fold(0.0, |peak: f64, value| peak.max(value.abs()))
    }

    /// One component (0 = x, 1 = y, 2 = z) as another quantity at the step `dt/k`; see [`resample_as`].
    ///
    /// `None` where the motion has no such component.
    #[must_use]
    pub fn component_as(&self, axis: usize, to: Quantity, k: usize) -> Option<Vec<f64>> {
        let samples = self.components.get(axis)?.as_ref()?;
        Some(resample_as(samples, self.dt, self.quantity, to, k))
    }
}
