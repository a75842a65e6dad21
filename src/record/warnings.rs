//! What an engineer must not miss about a recording, in words.

use hati_inputs::motion::{Quantity, Step, gravity};
use hati_inputs::records::Channel;
use serde_json::Value;

use super::measured::Component;
use super::{Measured, Recording};
use crate::results::AXES;

/// Share of the PGV above which a velocity that remains at the end is told.
const VELOCITY_LEFT: f64 = 0.05;
/// Multiple of the PGD from which on a displacement integrated from rest is told.
const DRIFT: f64 = 2.0;
/// Share of the PGA above which a mean is told.
const MEAN_LEFT: f64 = 0.02;

/// All warnings of a recording, the gravest first.
pub(super) fn warnings(recording: &Recording, measured: &Measured) -> Vec<String> {
    let mut warnings: Vec<String> = recording.channels.iter().flatten().filter_map(implausible).collect();
    warnings.extend(recording.motion.steps.iter().filter_map(of_step));
    for component in &measured.components {
        warnings.extend(mean(component));
        warnings.extend(residual(component).or_else(|| drift(component)));
    }
    if recording.motion.quantity != Quantity::Acceleration {
        let quantity = recording.motion.quantity;
        warnings.push(format!("the motion is a {quantity}: accelerations here are its spectral derivative"));
    }
    for channel in recording.channels.iter().flatten() {
        if let (Some(axis), Some(azimuth)) = (channel.axis_hint, channel.azimuth())
            && axis < 2
            && (azimuth - [90.0, 0.0][axis] + 180.0).rem_euclid(360.0) - 180.0 != 0.0
        {
            warnings.push(format!(
                "{} stands for the direction {azimuth}° from north (channel {})",
                AXES[axis], channel.id
            ));
        }
        if channel.axis_hint.is_none() {
            warnings.push(format!("channel {} tells no direction: it stands here as x", channel.id));
        }
        warnings.extend(channel.steps.iter().flat_map(|step| of_reading(&channel.id, step)));
    }
    warnings
}

/// What a step says of itself; a factor is told whatever its size.
fn of_step(step: &Step) -> Option<String> {
    let scaled = || {
        let factor = number(&step.found, "factor").filter(|_| step.name == "scale")?;
        Some(format!("the motion is scaled by {factor:.4}"))
    };
    step.warning().or_else(scaled)
}

fn number(map: &serde_json::Map<String, Value>, key: &str) -> Option<f64> {
    map.get(key).and_then(Value::as_f64)
}

/// A mean that stays: gravity, or an offset that becomes a drift.
fn mean(component: &Component) -> Option<String> {
    let (mean, pga) = (component.mean, component.measures.pga);
    let axis = AXES[component.trace.axis];
    if gravity(Quantity::Acceleration, mean).is_some() {
        return Some(format!("{axis} carries gravity: its mean is {mean:.4} m/s²; take it off with demean"));
    }
    (mean.abs() > MEAN_LEFT * pga).then(|| {
        let share = 100.0 * mean.abs() / pga;
        format!(
            "{axis} has a mean of {mean:.3e} m/s², {share:.0} % of its PGA: velocity and displacement drift"
        )
    })
}

/// A velocity that remains at the end of the record.
fn residual(component: &Component) -> Option<String> {
    let (axis, pgv) = (AXES[component.trace.axis], component.measures.pgv);
    let end = *component.velocity_from_rest.last()?;
    let displacement = *component.displacement_from_rest.last()?;
    (pgv > 0.0 && end.abs() > VELOCITY_LEFT * pgv).then(|| {
        format!(
            "{axis} does not come to rest: integrated from rest it ends at {end:.3e} m/s, {:.0} % of its PGV, and \
             {displacement:.3e} m; filter, baseline or rest mend that",
            100.0 * end.abs() / pgv
        )
    })
}

/// A displacement that runs away although the ground is at rest in the end.
fn drift(component: &Component) -> Option<String> {
    let (axis, pgd) = (AXES[component.trace.axis], component.measures.pgd);
    let peak = component.displacement_from_rest.iter().fold(0.0_f64, |peak, d| peak.max(d.abs()));
    (pgd > 0.0 && peak > DRIFT * pgd).then(|| {
        format!(
            "{axis} drifts: integrated from rest its displacement reaches {peak:.3e} m, {:.1} times its PGD; a \
             high-pass filter, baseline or rest mends that",
            peak / pgd
        )
    })
}

/// A peak that no ground motion has, under a unit that was given.
fn implausible(channel: &Channel) -> Option<String> {
    let mean = channel.samples.iter().sum::<f64>() / channel.samples.len().max(1) as f64;
    let peak = channel.samples.iter().fold(0.0_f64, |peak, value| peak.max((value - mean).abs()));
    let (low, high) = channel.quantity.plausible_peak();
    (!(low..=high).contains(&peak)).then(|| {
        let si = channel.quantity.si_unit();
        format!(
            "implausible: channel {} read in {} peaks at {peak:.3e} {si} about its mean, ground motions between \
             {low:e} and {high} {si}; the unit is likely wrong",
            channel.id, channel.unit_stored
        )
    })
}

/// What reading a channel gave rise to.
fn of_reading(id: &str, step: &Step) -> Vec<String> {
    let mut warnings = vec![];
    let texts = step.parameters.get("warnings").and_then(Value::as_array);
    for text in texts.into_iter().flatten().filter_map(Value::as_str) {
        warnings.push(format!("channel {id}: the reader says: {text}"));
    }
    if let Some(factor) = number(&step.parameters, "calibration_not_applied") {
        warnings.push(format!(
            "channel {id}: the file's calibration factor {factor} was not applied, since a unit was given"
        ));
    }
    warnings
}
