//! Records: accelerograms of observatories and networks, read by ObsPy in a child process.
//!
//! The way of a file, in [`read_many`]:
//! 1. it must be one existing regular file of bounded size ([`Limits`]), or `obspy:PATH`, a file that
//!    comes with the installed ObsPy package (for instance `obspy:io/nied/tests/data/test.knet`);
//! 2. its format is told from its content, never from its name, by the table in `formats`: miniSEED,
//!    SAC, K-NET and KiK-net, GSE1 and GSE2. What is not in the table, a Python pickle above all, is
//!    refused here and reaches no reader;
//! 3. a Python process takes the content through a pipe and hands back the samples as stored;
//! 4. each channel must be sound: one unbroken stretch, one step, finite, neither dead nor clipped;
//! 5. its unit must be sure: from the file where the format states one, else from the user
//!    ([`Unit`]); a peak that no ground motion has under the file's own unit is refused.
//!
//! The Python is HATI_PYTHON, else a `.venv/bin/python` in the current folder, beside the program, or
//! above either, else `python3`. A process start costs about half a second: read the components of a
//! motion together with [`read_many`].

mod checks;
mod formats;
mod location;
mod reader;
mod unit;

pub use crate::motion::Step;
pub use unit::Unit;

use std::path::{Path, PathBuf};
use std::time::Duration;

use serde::Serialize;
use serde_json::json;
use sha2::{Digest, Sha256};

use crate::error::InputError;
use crate::motion::Quantity;
use formats::{FORMATS, Recognition, RecordFormat, StoredUnit};
use reader::{Answer, Reader, Segment};

/// Bounds on what is read, so that a damaged or crafted file costs an error and not the machine.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// Time for one call, process start included; default 60 s.
    pub time: Duration,
    /// Largest file, bytes; default 512 MiB.
    pub file_bytes: u64,
    /// Largest number of samples in one file, all channels together; default 50 million.
    pub samples: u64,
    /// Address space of the reader process, bytes; default 8 GiB.
    pub memory_bytes: u64,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            time: Duration::from_secs(60),
            file_bytes: 512 << 20,
            samples: 50_000_000,
            memory_bytes: 8 << 30,
        }
    }
}

/// How records are read.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ReadOptions {
    /// What one stored sample value means. Given, it overrides the file's own statement, and the
    /// file's calibration factor is **not** applied: with counts, one count is one such unit. Absent,
    /// the file must say.
    pub unit: Option<Unit>,
    /// The quantity that is asked for; a channel of another one is refused. Absent: any.
    pub quantity: Option<Quantity>,
    /// Lets a channel pass that looks clipped (a plateau that is meant, in an artificial motion).
    pub accept_clipped: bool,
    /// The Python to start, instead of looking for one.
    pub python: Option<PathBuf>,
    /// Bounds.
    pub limits: Limits,
}

/// One file to read, with what holds for it alone.
#[derive(Debug, Clone, PartialEq)]
pub struct Source {
    /// Path of a local file, or `obspy:PATH`.
    pub location: PathBuf,
    /// Unit of this file; absent: that of the options.
    pub unit: Option<Unit>,
    /// Read only this channel: its full id (`BO.AKT013..EW`) or the last part of it (`EW`).
    pub channel: Option<String>,
}

impl Source {
    /// A file of which all channels are read, with the unit of the options.
    #[must_use]
    pub fn new(location: impl Into<PathBuf>) -> Self {
        Self { location: location.into(), unit: None, channel: None }
    }
}

/// One channel of a record, in SI.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Channel {
    /// Network, station, location and channel code, `NET.STA.LOC.CHA` (parts may be empty).
    pub id: String,
    /// The file as it was named.
    pub file: PathBuf,
    /// Its format: `miniSEED`, `K-NET`, `GSE2`, `GSE1` or `SAC`.
    pub format: &'static str,
    /// Time of the first sample, s since 1970-01-01 UTC; absent when the file does not tell (or
    /// says exactly that instant, which the formats use for unknown).
    pub start: Option<f64>,
    /// Time step, s.
    pub dt: f64,
    /// Samples, SI. Nothing is removed: an offset stays.
    #[serde(skip)]
    pub samples: Vec<f64>,
    /// What the samples are.
    pub quantity: Quantity,
    /// What the file stores, in its words or by the user's unit.
    pub unit_stored: String,
    /// Axis by the channel's name: 0 for E, EW, X; 1 for N, NS, Y; 2 for Z, UD; absent otherwise.
    pub axis_hint: Option<usize>,
    /// How the samples came about.
    pub steps: Vec<Step>,
    /// SHA-256 of the file, hexadecimal.
    pub sha256: String,
}

/// Reads all channels of one file; see [`read_many`].
pub fn read(location: &Path, options: &ReadOptions) -> Result<Vec<Channel>, InputError> {
    let mut files = read_many(&[Source::new(location)], options)?;
    Ok(files.pop().unwrap_or_default())
}

/// A file whose bytes are in memory and whose format is known.
struct Recognised<'a> {
    source: &'a Source,
    format: &'static RecordFormat,
    content: Vec<u8>,
}

/// Reads several files in one process; one list of channels per source, in order.
///
/// Each channel is converted to SI: stored value × factor, the factor from the user's unit or from the
/// file (see [`ReadOptions::unit`]). Under the file's own unit the peak about the mean must be one that
/// a ground motion can have ([`Quantity::plausible_peak`]).
///
/// Errors: the first refusal in the order of the sources, each naming file, channel and remedy.
pub fn read_many(sources: &[Source], options: &ReadOptions) -> Result<Vec<Vec<Channel>>, InputError> {
    let limits = &options.limits;
    let mut process = None;
    let mut recognised = Vec::with_capacity(sources.len());
    for source in sources {
        let content = match location::packaged(&source.location)? {
            None => location::content(&source.location, limits.file_bytes)?,
            Some(inner) => {
                let root = running(&mut process, options)?.package_root()?;
                location::content_packaged(&source.location, &root, &inner, limits.file_bytes)?
            }
        };
        let format = recognise(&source.location, &content)?;
        recognised.push(Recognised { source, format, content });
    }
    if recognised.is_empty() {
        return Ok(Vec::new());
    }
    let files: Vec<(&str, &[u8])> =
        recognised.iter().map(|file| (file.format.obspy, file.content.as_slice())).collect();
    let (version, answers) = running(&mut process, options)?.read(&files, limits)?;
    recognised.iter().zip(answers).map(|(file, answer)| channels(file, answer, &version, options)).collect()
}

fn running<'a>(process: &'a mut Option<Reader>, options: &ReadOptions) -> Result<&'a mut Reader, InputError> {
    if process.is_none() {
        *process = Some(Reader::start(options.python.as_deref(), &options.limits)?);
    }
    Ok(process.as_mut().expect("just started"))
}

/// The row of the format table that takes this content.
fn recognise(path: &Path, content: &[u8]) -> Result<&'static RecordFormat, InputError> {
    if let Some((what, remedy)) = formats::refused(content) {
        return Err(InputError::FormatRefused { path: path.into(), what, remedy });
    }
    for format in &FORMATS {
        match (format.recognise)(content) {
            Recognition::No => {}
            Recognition::Yes => return Ok(format),
            Recognition::Broken(problem) => return Err(broken(path, format, problem)),
        }
    }
    Err(InputError::FormatUnknown {
        path: path.into(),
        beginning: formats::beginning(content),
        known: formats::known(),
    })
}

fn broken(path: &Path, format: &RecordFormat, problem: String) -> InputError {
    InputError::RecordBroken { path: path.into(), format: format.name, problem }
}

/// The channels of one file, checked and converted.
fn channels(
    file: &Recognised<'_>,
    answer: Answer,
    obspy: &str,
    options: &ReadOptions,
) -> Result<Vec<Channel>, InputError> {
    let (path, format) = (file.source.location.as_path(), file.format);
    let (segments, warnings) = match answer {
        Answer::Segments { segments, warnings } => (segments, warnings),
        Answer::Refused(problem) => return Err(broken(path, format, problem)),
        Answer::TooMany(samples) => {
            let (path, limit) = (path.into(), options.limits.samples);
            return Err(InputError::TooManySamples { path, samples, limit });
        }
    };
    let damaged = |text: &&String| format.damage.iter().any(|category| text.starts_with(category));
    if let Some(warning) = warnings.iter().find(damaged) {
        return Err(broken(path, format, warning.clone()));
    }
    let mut groups: Vec<(String, Vec<Segment>)> = Vec::new();
    for segment in segments {
        match groups.iter_mut().find(|(id, _)| *id == segment.id) {
            Some((_, members)) => members.push(segment),
            None => groups.push((segment.id.clone(), vec![segment])),
        }
    }
    if let Some(wanted) = &file.source.channel {
        let present = groups.iter().map(|(id, _)| id.as_str()).collect::<Vec<_>>().join(", ");
        let last = |id: &str| id.rsplit('.').next() == Some(wanted.as_str());
        groups.retain(|(id, _)| id == wanted || last(id));
        if groups.is_empty() {
            let (path, wanted) = (path.into(), wanted.clone());
            return Err(InputError::ChannelMissing { path, wanted, present });
        }
    }
    if groups.is_empty() {
        return Err(broken(path, format, "it holds no samples".into()));
    }
    let sha256 = Sha256::digest(&file.content).iter().map(|byte| format!("{byte:02x}")).collect();
    let origin = Origin { file, sha256, obspy, warnings, options };
    groups.into_iter().map(|(_, members)| origin.channel(members)).collect()
}

/// What the channels of one file have in common.
struct Origin<'a> {
    file: &'a Recognised<'a>,
    sha256: String,
    obspy: &'a str,
    warnings: Vec<String>,
    options: &'a ReadOptions,
}

impl Origin<'_> {
    fn channel(&self, members: Vec<Segment>) -> Result<Channel, InputError> {
        let (path, format) = (self.file.source.location.as_path(), self.file.format);
        let whole = checks::join(path, members)?;
        checks::sound(path, &whole, self.options.accept_clipped)?;
        (format.consistent)(&whole).map_err(|problem| broken(path, format, problem))?;

        let given = self.file.source.unit.or(self.options.unit);
        let unit = self.unit(&whole, given)?;
        let samples: Vec<f64> = whole.samples.iter().map(|value| value * unit.factor).collect();
        if given.is_none() {
            self.plausible(&whole, &unit, &samples)?;
        }
        if let Some(expected) = self.options.quantity.filter(|wanted| *wanted != unit.quantity) {
            return Err(InputError::QuantityMismatch {
                path: path.into(),
                channel: whole.id,
                found: unit.quantity,
                expected,
            });
        }
        let mut read = json!({
            "format": format.name, "obspy": self.obspy, "samples": samples.len(), "dt_s": whole.dt,
        });
        if !self.warnings.is_empty() {
            read["warnings"] = json!(self.warnings);
        }
        let by = if given.is_some() { "user" } else { "file" };
        let mut convert = json!({
            "stored": if given.is_some() { format.stored } else { unit.text.as_str() },
            "given_by": by, "unit": unit.text, "quantity": unit.quantity,
            "factor_to_si": unit.factor, "si": unit.quantity.si_unit(),
        });
        if given.is_some()
            && let Some(calib) = whole.calib.filter(|calib| *calib != 1.0)
        {
            convert["calibration_not_applied"] = json!(calib);
        }
        if let Some(instrument) = instrument(&whole.channel) {
            convert["instrument_by_code"] = json!(instrument);
        }
        Ok(Channel {
            id: whole.id,
            file: path.into(),
            format: format.name,
            start: (whole.start_ns != 0).then_some(whole.start_ns as f64 * 1e-9),
            dt: whole.dt,
            samples,
            quantity: unit.quantity,
            unit_stored: unit.text,
            axis_hint: axis_hint(&whole.channel),
            steps: vec![Step::new("read", read), Step::new("unit", convert)],
            sha256: self.sha256.clone(),
        })
    }

    /// The user's unit, else the file's.
    fn unit(&self, whole: &Segment, given: Option<Unit>) -> Result<StoredUnit, InputError> {
        if let Some(unit) = given {
            return Ok(StoredUnit {
                text: unit.symbol().into(),
                quantity: unit.quantity(),
                factor: unit.factor(),
            });
        }
        (self.file.format.unit)(whole).map_err(|reason| InputError::UnitMissing {
            path: self.file.source.location.clone(),
            channel: whole.id.clone(),
            reason,
            choices: Unit::choices(),
        })
    }

    /// Whether a ground motion can have this peak about its mean.
    fn plausible(&self, whole: &Segment, unit: &StoredUnit, samples: &[f64]) -> Result<(), InputError> {
        let mean = samples.iter().sum::<f64>() / samples.len() as f64;
        let peak = samples.iter().fold(0.0, |peak: f64, value| peak.max((value - mean).abs()));
        let (low, high) = unit.quantity.plausible_peak();
        if (low..=high).contains(&peak) {
            return Ok(());
        }
        Err(InputError::PeakImplausible {
            path: self.file.source.location.clone(),
            channel: whole.id.clone(),
            unit: unit.text.clone(),
            quantity: unit.quantity,
            peak,
            si: unit.quantity.si_unit(),
            low,
            high,
        })
    }
}

/// Axis by a channel's name: `EW`, `EW1`, `HNE`, `x` → 0; north → 1; `UD2`, `HNZ` → 2.
fn axis_hint(channel: &str) -> Option<usize> {
    let name = channel.trim().to_ascii_uppercase();
    // KiK-net numbers its sensors: EW1 in the borehole, EW2 at the surface.
    match name.trim_end_matches(['1', '2']) {
        "EW" => return Some(0),
        "NS" => return Some(1),
        "UD" => return Some(2),
        _ => {}
    }
    match name.chars().last()? {
        'E' | 'X' => Some(0),
        'N' | 'Y' => Some(1),
        'Z' => Some(2),
        _ => None,
    }
}

/// The instrument that a three-letter SEED channel code names, by its second letter.
fn instrument(channel: &str) -> Option<&'static str> {
    let mut letters = channel.trim().chars();
    let (_, second, _) = (letters.next()?, letters.next()?, letters.next()?);
    match second {
        _ if letters.next().is_some() => None,
        'H' | 'L' => Some("a velocity seismometer"),
        'N' => Some("an accelerometer"),
        _ => None,
    }
}

#[cfg(test)]
mod tests;
