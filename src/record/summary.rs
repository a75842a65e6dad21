//! A recording as JSON: what `--json` prints and `record.json` holds.

use hati_inputs::records::Channel;
use serde_json::{Value, json};

use super::measured::Component;
use super::warnings::warnings;
use super::{Measured, Recording};
use crate::calendar::iso8601;
use crate::motion_input::measures_json;
use crate::results::AXES;

impl Recording {
    /// What was found, done and measured, as one JSON object.
    #[must_use]
    pub fn summary(&self, measured: &Measured) -> Value {
        let motion = &self.motion;
        let components: serde_json::Map<String, Value> =
            (measured.components.iter()).map(|c| (AXES[c.trace.axis].to_string(), component(c))).collect();
        let channels: Vec<Value> = (self.channels.iter().enumerate())
            .filter_map(|(axis, c)| c.as_ref().map(|c| channel(axis, c)))
            .collect();
        json!({
            "name": self.name,
            "hati_version": env!("CARGO_PKG_VERSION"),
            "quantity": motion.quantity, "unit": motion.quantity.si_unit(),
            "dt": motion.dt, "npts": motion.len(), "duration": motion.duration(),
            "start": motion.start.map(iso8601),
            "motion": self.origin,
            "channels": channels,
            "steps": motion.steps,
            "measures": components,
            "velocity_and_displacement":
                if measured.from_rest { "from rest" } else { "without what lies below one period in the record" },
            "warnings": warnings(self, measured),
        })
    }

    /// One JSON object per channel: what the file holds and what the processed component measures.
    #[must_use]
    pub fn channel_summaries(&self, measured: &Measured) -> Vec<Value> {
        let of = |c: &Component| {
            let axis = c.trace.axis;
            let mut value =
                self.channels[axis].as_ref().map(|found| channel(axis, found)).unwrap_or_default();
            value["recording"] = json!(self.name);
            value["steps"] = json!(self.motion.steps);
            if let (Some(value), Value::Object(measures)) = (value.as_object_mut(), component(c)) {
                value.extend(measures);
            }
            value
        };
        measured.components.iter().map(of).collect()
    }
}

/// What a file holds.
fn channel(axis: usize, c: &Channel) -> Value {
    let peak = c.samples.iter().fold(0.0_f64, |peak, value| peak.max(value.abs()));
    let mean = c.samples.iter().sum::<f64>() / c.samples.len().max(1) as f64;
    let unit = c.steps.iter().find(|step| step.name == "unit");
    let unit = |key: &str| unit.and_then(|step| step.parameters.get(key)).cloned().unwrap_or_default();
    json!({
        "axis": AXES[axis].to_string(), "id": c.id, "file": c.file.display().to_string(), "format": c.format,
        "start": c.start.map(iso8601), "dt": c.dt, "npts": c.samples.len(),
        "quantity": c.quantity.to_string(), "unit": c.quantity.si_unit(), "unit_stored": c.unit_stored,
        "azimuth_deg": c.azimuth(), "mean_as_read": mean,
        "unit_given_by": unit("given_by"), "factor_to_si": unit("factor_to_si"), "peak_as_read": peak,
        "sha256": c.sha256, "reading": c.steps,
    })
}

fn component(c: &Component) -> Value {
    let mut value = measures_json(&c.measures);
    value["band"] = json!([c.band.0, c.band.1]);
    value["velocity_end"] = json!(c.velocity_from_rest.last());
    value["displacement_end"] = json!(c.displacement_from_rest.last());
    value
}
