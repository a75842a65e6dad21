//! Instrument responses: from counts to ground motion with the metadata of the station.

use std::path::{Path, PathBuf};

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::formats::StoredUnit;
use crate::error::InputError;
use crate::motion::Quantity;

/// Largest metadata file, bytes: a whole network's StationXML stays below.
pub(super) const METADATA_BYTES: u64 = 64 << 20;

/// How counts become ground motion.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ResponseMode {
    /// divide the spectrum by the full response; refused where the stated sensitivity and the stages disagree by more than 5 %
    #[default]
    Full,
    /// divide the samples by the stated sensitivity, one number
    Sensitivity,
    /// as `full`, by the stages, whatever the stated sensitivity says
    Stages,
}

impl ResponseMode {
    /// The word in scene files.
    #[must_use]
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Full => "full",
            Self::Sensitivity => "sensitivity",
            Self::Stages => "stages",
        }
    }
}

/// The response of the instrument that made a record, and how it is taken off.
///
/// The full response is removed in the frequency domain by ObsPy: mean off, cosine taper over 2.5 % at either end
/// (its `taper_fraction` of 0.05 counts both), spectrum times the cosine window `pre_filter`, divided by the response from ground motion to counts.
/// Stages of StationXML include the delays of the digitiser's FIR filters as the metadata state them; poles and
/// zeros hold none, so that the same record by the two may differ by a sample or so in time: take one kind
/// for all components.
///
/// The result is the instrument's own quantity (m/s² for an accelerometer, m/s for a velocity
/// seismometer); no quantity is turned into another one here.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Response {
    /// A local file, or `obspy:PATH`: FDSN StationXML, RESP, or SAC poles and zeros. Told from its content.
    pub metadata: PathBuf,
    /// How.
    #[serde(default)]
    pub mode: ResponseMode,
    /// Four rising corners, Hz: nothing is kept below the first and above the last, all between the second
    /// and the third. Absent: 0.02, 0.05, 0.8 and 0.96 of the Nyquist frequency; of records shorter than
    /// 40 s the second corner is two periods in the record.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pre_filter: Option<[f64; 4]>,
    /// Floor under the response, dB below its maximum. Absent: none, the window guards the division.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub water_level: Option<f64>,
}

impl Response {
    /// The full response by the metadata in a file, with the settings' defaults.
    #[must_use]
    pub fn new(metadata: impl Into<PathBuf>) -> Self {
        Self { metadata: metadata.into(), mode: ResponseMode::Full, pre_filter: None, water_level: None }
    }

    /// The request to the reader process for metadata of so many bytes.
    pub(super) fn request(&self, format: &str, bytes: usize) -> Value {
        json!({
            "metadata": format, "bytes": bytes, "mode": self.mode.as_str(),
            "pre_filter": self.pre_filter, "water_level": self.water_level,
        })
    }
}

/// Tells StationXML, RESP and SAC pole-zero files apart by their content.
pub(super) fn metadata_format(path: &Path, content: &[u8]) -> Result<&'static str, InputError> {
    let refused = |problem: String| InputError::MetadataUnknown { path: path.into(), problem };
    let text = String::from_utf8_lossy(content);
    let text = text.trim_start_matches('\u{feff}').trim_start();
    if text.starts_with("<?xml") || text.starts_with("<FDSNStationXML") {
        // Entities could name other files or grow without bound; StationXML has no use for them.
        if text.contains("<!DOCTYPE") || text.contains("<!ENTITY") {
            return Err(refused("an XML file with a document type or entities, which is not opened".into()));
        }
        let head: String = text.chars().take(4000).collect();
        return match head.contains("FDSNStationXML") {
            true => Ok("STATIONXML"),
            false => Err(refused("an XML file, but no FDSN StationXML".into())),
        };
    }
    let mut lines = text.lines().map(str::trim).filter(|line| !line.is_empty()).take(2000);
    let first = |line: &str| line.split_whitespace().next().unwrap_or_default().to_ascii_uppercase();
    let kind = lines.find_map(|line| match first(line).as_str() {
        "ZEROS" | "POLES" | "CONSTANT" => Some("SACPZ"),
        word if word.starts_with("B05") => Some("RESP"),
        _ => None,
    });
    kind.ok_or_else(|| refused(format!("it begins with {}", super::formats::beginning(content))))
}

/// The quantity that a removed response left, from the reader's own account of it.
pub(super) fn unit(about: &Value) -> Option<StoredUnit> {
    let quantity = match about.get("output").and_then(Value::as_str)? {
        "ACC" => Quantity::Acceleration,
        "VEL" => Quantity::Velocity,
        "DISP" => Quantity::Displacement,
        _ => return None,
    };
    let by = match about.get("mode").and_then(Value::as_str) {
        Some("sensitivity") => "stated sensitivity",
        _ => "full response",
    };
    Some(StoredUnit { text: format!("counts, {by}"), quantity, factor: 1.0 })
}
