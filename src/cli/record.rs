//! The verb `record`, in its first form: what was found in the files, and its measures.

use super::arguments::RecordArguments;
use super::{Exit, Failure, print, print_json, show};
use crate::motion_input::measures_json;
use hati_inputs::measures::Measures;
use hati_inputs::motion::{Motion, Offset, Quantity, usable_band};
use hati_inputs::records::{Channel, ReadOptions, Source, Unit, read_many};
use serde_json::{Value, json};

/// Accuracy for which a record's band is shown: the default of scenes.
const BAND_ACCURACY: f64 = 1e-2;

pub(super) fn record(a: &RecordArguments, json: bool) -> Result<Exit, Failure> {
    let unit = match &a.unit {
        Some(text) => Some(text.parse::<Unit>().map_err(Failure::input)?),
        None => None,
    };
    let sources: Vec<Source> = a.files.iter().map(|f| Source { unit, ..Source::new(f) }).collect();
    let files = read_many(&sources, &ReadOptions::default()).map_err(Failure::input)?;
    let mut channels = vec![];
    for channel in files.iter().flatten() {
        channels.push(measure(channel, a.keep_offset)?);
    }
    if json {
        print_json(&json!({ "channels": channels }))?;
    } else {
        print(&show::channels(&channels))?;
    }
    Ok(Exit::Fine)
}

fn measure(channel: &Channel, keep_offset: bool) -> Result<Value, Failure> {
    let mut motion = Motion::from_channels([Some(channel), None, None]).map_err(Failure::input)?;
    if !keep_offset {
        motion.remove_offset(Offset::Mean).map_err(Failure::input)?;
    }
    let a = motion.component_as(0, Quantity::Acceleration, 1).unwrap_or_default();
    let f_min = 1.0 / (motion.len() as f64 * motion.dt);
    let mut value = measures_json(&Measures::of(&a, motion.dt, f_min));
    let band = usable_band(&a, motion.dt, BAND_ACCURACY);
    let about = json!({
        "id": channel.id, "file": channel.file.display().to_string(), "format": channel.format,
        "start": channel.start.map(crate::calendar::iso8601), "dt": channel.dt, "npts": channel.samples.len(),
        "quantity": channel.quantity.to_string(), "unit": channel.quantity.si_unit(), "unit_stored": channel.unit_stored,
        "sha256": channel.sha256, "steps": motion.steps, "band": [band.0, band.1],
    });
    if let (Some(value), Some(about)) = (value.as_object_mut(), about.as_object()) {
        let measures = std::mem::take(value);
        value.extend(about.clone());
        value.extend(measures);
    }
    Ok(value)
}
