//! Where the numbers in a file come from: the global attributes of every NetCDF file.

use super::OutputError;
use super::classic::Attribute;
use super::file::OutputFile;

/// Version of the layout of hati's NetCDF files.
const FORMAT_VERSION: i32 = 1;

/// Origin of a run's results, written as global attributes into each of its files.
#[derive(Debug, Clone, Default)]
pub struct Provenance {
    /// The scene's title.
    pub title: String,
    /// Version of the program, for instance `0.1.0`.
    pub hati_version: String,
    /// What was done and when, one line per step, for instance `2026-01-01T00:00:00Z hati run scene.toml`.
    pub history: String,
    /// Start of the record, ISO 8601 in UTC; `None` when unknown (times then count from 1970-01-01).
    pub start: Option<String>,
    /// SHA-256 of the scene file, hexadecimal.
    pub scene_sha256: String,
    /// SHA-256 of each record file, hexadecimal.
    pub record_sha256: Vec<String>,
    /// Accuracy that the scene asked for (relative error, 1).
    pub accuracy: Option<f64>,
    /// Processing steps of the record with their parameters.
    pub record_steps: serde_json::Value,
}

impl Provenance {
    /// CF unit of the `time` coordinate, `seconds since …`.
    ///
    /// A start without a zone, with `Z` or with an offset is passed on; an empty one counts as unknown.
    #[must_use]
    pub fn time_units(&self) -> String {
        match self.start.as_deref().map(str::trim) {
            Some(start) if !start.is_empty() => format!("seconds since {start}"),
            _ => "seconds since 1970-01-01T00:00:00Z".to_owned(),
        }
    }

    /// Writes the global attributes; `content` says what the file holds.
    pub(super) fn write(&self, file: &mut OutputFile, content: &str) -> Result<(), OutputError> {
        for (name, value) in self.attributes(content) {
            match value {
                Attribute::Text(text) => file.attribute(&name, text)?,
                Attribute::Int(value) => file.attribute(&name, value)?,
                Attribute::Double(value) => file.attribute(&name, value)?,
                Attribute::Float(value) => file.attribute(&name, value)?,
                Attribute::Bytes(values) => file.attribute(&name, values)?,
            }
        }
        Ok(())
    }

    /// The global attributes; `content` says what the file holds.
    pub(super) fn attributes(&self, content: &str) -> Vec<(String, Attribute)> {
        let start = self.start.as_deref().filter(|start| !start.trim().is_empty());
        let text = |name: &str, value: String| (name.to_owned(), Attribute::Text(value));
        let mut attributes = vec![
            text("Conventions", "CF-1.11".into()),
            text("title", format!("{}: {content}", self.title)),
            text("history", self.history.clone()),
            text("source", format!("hati {}", self.hati_version)),
            text("hati_version", self.hati_version.clone()),
            ("format_version".into(), Attribute::Int(FORMAT_VERSION)),
            text("scene_sha256", self.scene_sha256.clone()),
            text("record_sha256", self.record_sha256.join(" ")),
            text("record_steps", self.record_steps.to_string()),
            text("record_start", start.unwrap_or("unknown").to_owned()),
        ];
        attributes.extend(self.accuracy.map(|accuracy| ("accuracy".into(), Attribute::Double(accuracy))));
        attributes
    }
}
