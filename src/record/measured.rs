//! What a motion measures, component by component.

use hati_inputs::measures::{Measures, integrated};
use hati_inputs::motion::{Quantity, usable_band};

use super::Recording;
use crate::results::{AXES, Trace};

/// Accuracy for which a record's band is shown: the default of scenes.
pub(super) const BAND_ACCURACY: f64 = 1e-2;

/// One component's histories and measures.
#[derive(Debug, Clone)]
pub struct Component {
    /// Acceleration as processed; velocity and displacement as PGV and PGD see them (see [`Measures::of`] and
    /// [`Measured::from_rest`]).
    pub trace: Trace,
    /// Velocity integrated from rest, as a model would follow it, m/s.
    pub velocity_from_rest: Vec<f64>,
    /// Displacement integrated from rest, m.
    pub displacement_from_rest: Vec<f64>,
    /// Mean of the acceleration, m/s².
    pub mean: f64,
    /// Peaks, intensity, durations.
    pub measures: Measures,
    /// Frequencies (Hz) outside which the energy of the acceleration is below (1e-2/2)² of all.
    pub band: (f64, f64),
}

/// The measures of all components of a recording's processed motion.
#[derive(Debug, Clone)]
pub struct Measured {
    /// Step of the processed motion, s.
    pub dt: f64,
    /// The components that there are, in the order x, y, z.
    pub components: Vec<Component>,
    /// Whether velocities, displacements and their peaks are the integrals from rest ([`Recording::at_rest`]); else
    /// what lies below one period in the record is left out of them.
    pub from_rest: bool,
}

impl Measured {
    /// Measures a recording, its components side by side.
    #[must_use]
    pub fn of(recording: &Recording) -> Self {
        let axes = recording.axes();
        let components = std::thread::scope(|scope| {
            let started: Vec<_> =
                axes.iter().map(|&axis| scope.spawn(move || Component::of(recording, axis))).collect();
            started.into_iter().filter_map(|thread| thread.join().ok()).collect()
        });
        Self { dt: recording.motion.dt, components, from_rest: recording.at_rest() }
    }
}

impl Component {
    fn of(recording: &Recording, axis: usize) -> Self {
        let motion = &recording.motion;
        let from_rest = |to| motion.component_as(axis, to, 1).unwrap_or_default();
        let acceleration = from_rest(Quantity::Acceleration);
        // A ground that was brought to rest has no drift to leave out.
        let f_min = if recording.at_rest() { 0.0 } else { 1.0 / (motion.len() as f64 * motion.dt) };
        let without_drift = |to| integrated(&acceleration, motion.dt, f_min, to);
        Self {
            velocity_from_rest: from_rest(Quantity::Velocity),
            displacement_from_rest: from_rest(Quantity::Displacement),
            mean: acceleration.iter().sum::<f64>() / acceleration.len().max(1) as f64,
            measures: Measures::of(&acceleration, motion.dt, f_min),
            band: usable_band(&acceleration, motion.dt, BAND_ACCURACY),
            trace: Trace {
                place: AXES[axis].to_string(),
                depth: None,
                axis,
                velocity: without_drift(Quantity::Velocity),
                displacement: without_drift(Quantity::Displacement),
                acceleration,
            },
        }
    }
}
