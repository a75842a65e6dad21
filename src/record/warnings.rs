//! What an engineer must not miss about a recording, in words.

use hati_inputs::motion::{Quantity, Step, gravity};
use hati_inputs::records::{Channel, Unit};
use serde_json::Value;

use super::measured::Component;
use super::number::figures;
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
    warnings.extend(recording.channels.iter().flatten().filter_map(other_quantity));
    warnings.extend(recording.notes.iter().cloned());
    warnings.extend(cut(recording));
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
        warnings.extend(direction(recording, channel));
        if channel.axis_hint.is_none() {
            warnings.push(format!("channel {} tells no direction: it stands here as x", channel.id));
        }
        warnings.extend(channel.steps.iter().flat_map(|step| of_reading(&channel.id, step)));
    }
    warnings
}

/// Components that were cut to the time that all of them cover.
fn cut(recording: &Recording) -> Option<String> {
    let record = recording.motion.steps.iter().find(|step| step.name == "record")?;
    let parts: Vec<String> = AXES
        .iter()
        .filter_map(|axis| {
            let entry = record.parameters.get(axis.to_string().as_str())?;
            let samples = |key: &str| entry.get(key).and_then(Value::as_u64).filter(|n| *n > 0);
            let before = samples("samples_cut_before").map(|n| format!("{n} samples at the start"));
            let after = samples("samples_cut_after").map(|n| format!("{n} at the end"));
            let lost: Vec<String> = before.into_iter().chain(after).collect();
            (!lost.is_empty()).then(|| format!("{axis} loses {}", lost.join(" and ")))
        })
        .collect();
    (!parts.is_empty()).then(|| format!("cut to the time common to all components: {}", parts.join(", ")))
}

/// A horizontal that points neither east nor north, or no longer does.
fn direction(recording: &Recording, channel: &Channel) -> Option<String> {
    let axis = channel.axis_hint.filter(|axis| *axis < 2)?;
    let turned = recording.turned();
    let azimuth = channel.azimuth().unwrap_or([90.0, 0.0][axis]);
    let away = |azimuth: f64| (azimuth - [90.0, 0.0][axis] + 180.0).rem_euclid(360.0) - 180.0 != 0.0;
    let (axis, now) = (AXES[axis], (azimuth - turned).rem_euclid(360.0));
    let id = &channel.id;
    match turned {
        0.0 => away(azimuth)
            .then(|| format!("{axis} stands for the direction {azimuth}° from north (channel {id})")),
        _ => Some(format!(
            "{axis} stands for the direction {now}° from north: channel {id}, {azimuth}°, rotated by {turned}°"
        )),
    }
}

/// A unit that was given and measures another thing than the file or the instrument says.
fn other_quantity(channel: &Channel) -> Option<String> {
    let unit = channel.steps.iter().find(|step| step.name == "unit")?;
    let word = |map: &serde_json::Map<String, Value>, key: &str| map.get(key)?.as_str().map(str::to_owned);
    if word(&unit.parameters, "given_by")? != "user" {
        return None;
    }
    let (id, given) = (&channel.id, &channel.unit_stored);
    let head = format!("channel {id} read in {given}, {}", article(channel.quantity));
    if let Some(states) = word(&unit.found, "file_states")
        && let Some(stated) = quantity_in(&states)
        && stated != channel.quantity
    {
        return Some(format!("{head}, where its file states {states}, {}", article(stated)));
    }
    let instrument = word(&unit.parameters, "instrument_by_code")?;
    let measured = if instrument.contains("velocity") { Quantity::Velocity } else { Quantity::Acceleration };
    (measured != channel.quantity).then(|| {
        format!(
            "{head}, where its code names {instrument}: its counts are {} unless that was taken off",
            article(measured)
        )
    })
}

fn article(quantity: Quantity) -> String {
    match quantity {
        Quantity::Acceleration => format!("an {quantity}"),
        _ => format!("a {quantity}"),
    }
}

/// What the first unit in some words measures.
fn quantity_in(words: &str) -> Option<Quantity> {
    let parts = words.split(|c: char| c.is_whitespace() || "()[]×,".contains(c));
    parts
        .filter_map(|part| part.split_once("/count").map_or(part, |(unit, _)| unit).parse::<Unit>().ok())
        .map(Unit::quantity)
        .next()
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
        return Some(format!(
            "{axis} carries gravity: its mean is {} m/s²; take it off with demean",
            figures(mean, 4)
        ));
    }
    (mean.abs() > MEAN_LEFT * pga).then(|| {
        let share = 100.0 * mean.abs() / pga;
        format!(
            "{axis} has a mean of {} m/s², {share:.0} % of its PGA: velocity and displacement drift",
            figures(mean, 3)
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
            "{axis} does not come to rest: integrated from rest it ends at {} m/s, {:.0} % of its PGV, and \
             {} m; filter, baseline or rest mend that",
            figures(end, 3),
            100.0 * end.abs() / pgv,
            figures(displacement, 3)
        )
    })
}

/// A displacement that runs away although the ground is at rest in the end.
fn drift(component: &Component) -> Option<String> {
    let (axis, pgd) = (AXES[component.trace.axis], component.measures.pgd);
    let peak = component.displacement_from_rest.iter().fold(0.0_f64, |peak, d| peak.max(d.abs()));
    (pgd > 0.0 && peak > DRIFT * pgd).then(|| {
        format!(
            "{axis} drifts: integrated from rest its displacement reaches {} m, {} times its PGD; a \
             high-pass filter, baseline or rest mends that",
            figures(peak, 3),
            figures(peak / pgd, 3)
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
            "implausible: channel {} read in {} peaks at {} {si} about its mean, ground motions between \
             {} and {} {si}; the unit is likely wrong",
            channel.id,
            channel.unit_stored,
            figures(peak, 4),
            figures(low, 1),
            figures(high, 3)
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
