//! Motions as files that seismologists' programs read: miniSEED and SAC, written by ObsPy.

use serde_json::{Value, json};

use super::reader::Reader;
use super::{Limits, ReadOptions};
use crate::error::InputError;
use crate::motion::Quantity;

/// The file formats that [`encode`] writes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FileFormat {
    /// miniSEED 2, 8-byte floats, SI; the format holds no unit.
    MiniSeed,
    /// SAC, one file per trace, 4-byte floats in nm, nm/s or nm/s² as IDEP 6, 7 and 8 mean.
    Sac,
}

/// One channel to be written.
#[derive(Debug, Clone, PartialEq)]
pub struct Trace<'a> {
    /// Network, station, location and channel code; at most 2, 5, 2 and 3 characters are kept.
    pub id: [String; 4],
    /// Time of the first sample, s since 1970-01-01 UTC; unknown is written as that instant.
    pub start: Option<f64>,
    /// Time step, s.
    pub dt: f64,
    /// What the samples are.
    pub quantity: Quantity,
    /// Samples, SI.
    pub samples: &'a [f64],
}

impl Trace<'_> {
    fn header(&self, format: FileFormat) -> Value {
        let [network, station, location, channel] = &self.id;
        let cut = |text: &str, length: usize| {
            text.chars().filter(char::is_ascii_alphanumeric).take(length).collect::<String>()
        };
        // SAC counts its reference time in ms; ObsPy does the rounding.
        let start_ns = (self.start.unwrap_or(0.0) * 1e9).round() as i64;
        let mut header = json!({
            "network": cut(network, 2), "station": cut(station, 5), "location": cut(location, 2),
            "channel": cut(channel, 3), "start_ns": start_ns, "dt": self.dt, "npts": self.samples.len(),
        });
        if format == FileFormat::Sac {
            let idep = match self.quantity {
                Quantity::Displacement => "idisp",
                Quantity::Velocity => "ivel",
                Quantity::Acceleration => "iacc",
            };
            header["sac"] = json!({ "idep": idep });
        }
        header
    }

    /// Samples as the format wants them: SI for miniSEED, nm for SAC.
    fn bytes(&self, format: FileFormat) -> Vec<u8> {
        let factor = if format == FileFormat::Sac { 1e9 } else { 1.0 };
        self.samples.iter().flat_map(|value| (value * factor).to_le_bytes()).collect()
    }
}

/// The bytes of one miniSEED file with all traces, or of one SAC file per trace.
///
/// SAC samples are stored in nm, nm/s or nm/s² (m·1e9), never in SI under a code that means nanometres;
/// 4-byte floats keep seven digits. miniSEED stores SI as 8-byte floats and cannot say so: keep the
/// sidecar that says it.
///
/// Errors: no Python with ObsPy; what ObsPy says of a trace that the format cannot hold.
pub fn encode(
    format: FileFormat,
    traces: &[Trace<'_>],
    options: &ReadOptions,
) -> Result<Vec<Vec<u8>>, InputError> {
    let word = match format {
        FileFormat::MiniSeed => "MSEED",
        FileFormat::Sac => "SAC",
    };
    let headers: Vec<Value> = traces.iter().map(|trace| trace.header(format)).collect();
    let blocks: Vec<Vec<u8>> = traces.iter().map(|trace| trace.bytes(format)).collect();
    let limits: &Limits = &options.limits;
    let mut reader = Reader::start(options.python.as_deref(), limits)?;
    reader.write(word, &headers, &blocks, limits.file_bytes)
}
