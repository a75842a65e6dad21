//! From the channels of one recording to a motion with one time axis.

use serde_json::{Map, Value, json};

use super::{AXES, Motion, Step};
use crate::error::InputError;
use crate::records::Channel;

/// A channel and the axis that it is meant for.
type Placed<'a> = (usize, &'a Channel);

impl Motion {
    /// A motion from channels of one recording, given for x, y and z.
    ///
    /// Stations (where the ids name them), sensors, quantities and steps (to 1e-6 relative) must agree, and no
    /// channel may stand on two axes. Start times, where all are known, must lie on one grid (to 1 % of a
    /// step); the components are cut to the time that all of them cover, and the cut is recorded. With an
    /// unknown start the channels begin together, and the longer ones lose their end.
    pub fn from_channels(channels: [Option<&Channel>; 3]) -> Result<Self, InputError> {
        let present: Vec<Placed<'_>> =
            (0..3).filter_map(|axis| channels[axis].map(|channel| (axis, channel))).collect();
        let Some(&reference) = present.first() else {
            return Err(InputError::NoComponent);
        };
        let known = present.iter().all(|(_, channel)| channel.start.is_some());
        let mut shifts = Vec::with_capacity(present.len());
        for &placed in &present {
            agree(reference, placed)?;
            shifts.push(if known { shift(reference, placed)? } else { 0.0 });
        }
        no_channel_twice(&present)?;
        let begin = shifts.iter().fold(f64::NEG_INFINITY, |a, b| a.max(*b));
        let ends =
            present.iter().zip(&shifts).map(|((_, channel), shift)| shift + channel.samples.len() as f64);
        let end = ends.fold(f64::INFINITY, f64::min);
        if end - begin < 2.0 {
            let last = present[present.len() - 1];
            let show = |channel: &Channel| {
                let start = channel.start.unwrap_or(0.0);
                let length = channel.samples.len() as f64 * channel.dt;
                format!("{start:.3} s + {length:.3} s")
            };
            return differ(reference, last, "time covered", show(reference.1), show(last.1));
        }
        let length = (end - begin) as usize;
        let mut components = [None, None, None];
        let mut sources = Map::new();
        for ((axis, channel), shift) in present.iter().zip(&shifts) {
            let skip = (begin - shift) as usize;
            components[*axis] = Some(channel.samples[skip..skip + length].to_vec());
            let entry = json!({
                "channel": channel.id, "file": channel.file, "sha256": channel.sha256,
                "format": channel.format, "unit_stored": channel.unit_stored,
                "samples_cut_before": skip,
                "samples_cut_after": channel.samples.len() - skip - length,
                "steps": channel.steps,
            });
            sources.insert(AXES[*axis].to_string(), entry);
        }
        let (dt, quantity) = (reference.1.dt, reference.1.quantity);
        let start = reference.1.start.filter(|_| known).map(|start| start + begin * dt);
        let mut motion = Self::new(dt, start, quantity, components)?;
        motion.steps.push(Step::new("record", Value::Object(sources)));
        Ok(motion)
    }
}

fn differ<T>(
    first: Placed<'_>,
    second: Placed<'_>,
    what: &'static str,
    first_value: String,
    second_value: String,
) -> Result<T, InputError> {
    let (first, second) = (AXES[first.0], AXES[second.0]);
    Err(InputError::ComponentsDiffer { first, second, what, first_value, second_value })
}

/// Whether two channels can be components of one recording, their times aside.
fn agree(first: Placed<'_>, second: Placed<'_>) -> Result<(), InputError> {
    let (a, b) = (first.1, second.1);
    let (station_a, station_b) = (station(a), station(b));
    if !station_a.is_empty() && !station_b.is_empty() && station_a != station_b {
        return differ(first, second, "station", station_a.into(), station_b.into());
    }
    if let (Some(sensor_a), Some(sensor_b)) = (sensor(a), sensor(b))
        && sensor_a != sensor_b
    {
        return differ(first, second, "sensor", sensor_a.into(), sensor_b.into());
    }
    if a.quantity != b.quantity {
        return differ(first, second, "quantity", a.quantity.to_string(), b.quantity.to_string());
    }
    if (b.dt - a.dt).abs() > 1e-6 * a.dt {
        return differ(first, second, "time step", format!("{} s", a.dt), format!("{} s", b.dt));
    }
    Ok(())
}

/// Whole samples by which a channel begins after the first one; both starts are known.
fn shift(first: Placed<'_>, second: Placed<'_>) -> Result<f64, InputError> {
    let (a, b) = (first.1, second.1);
    let shift = (b.start.unwrap_or(0.0) - a.start.unwrap_or(0.0)) / a.dt;
    // Times in s since 1970 carry about 1e-7 s of round-off.
    let tolerance = 0.01_f64.max(5e-7 / a.dt);
    if !shift.is_finite() || (shift - shift.round()).abs() > tolerance {
        let offset = (shift - shift.round()) * a.dt;
        let text = format!("{offset:.6} s off the first one's samples");
        return differ(first, second, "sampling times", "0 s".into(), text);
    }
    Ok(shift.round())
}

/// The station code of a channel's id, empty where there is none.
fn station(channel: &Channel) -> &str {
    channel.id.split('.').nth(1).unwrap_or_default()
}

/// The sensor of KiK-net's channels: 1 in the borehole, 2 at the surface.
fn sensor(channel: &Channel) -> Option<&'static str> {
    let code = channel.id.rsplit('.').next()?;
    let number = ["EW", "NS", "UD"].iter().find_map(|direction| code.strip_prefix(direction))?;
    match number {
        "1" => Some("1, in the borehole"),
        "2" => Some("2, at the surface"),
        _ => None,
    }
}

/// The same channel of the same file on two axes is a slip of the pen.
fn no_channel_twice(present: &[Placed<'_>]) -> Result<(), InputError> {
    for (i, first) in present.iter().enumerate() {
        for second in &present[i + 1..] {
            let (a, b) = (first.1, second.1);
            if !a.sha256.is_empty() && a.sha256 == b.sha256 && a.id == b.id {
                return Err(InputError::ComponentTwice {
                    first: AXES[first.0],
                    second: AXES[second.0],
                    channel: a.id.clone(),
                    path: a.file.clone(),
                });
            }
        }
    }
    Ok(())
}
