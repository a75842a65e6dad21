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
mod choice;
mod conversion;
mod formats;
mod location;
mod naming;
mod reader;
mod response;
mod unit;
mod write;

pub use crate::motion::Step;
pub use choice::choose;
pub use response::{Response, ResponseMode};
pub use unit::Unit;
pub use write::{FileFormat, Trace, encode};

use std::path::{Path, PathBuf};
use std::time::Duration;

use serde::Serialize;
use sha2::{Digest, Sha256};

use crate::error::InputError;
use crate::motion::Quantity;
use conversion::Origin;
use formats::{FORMATS, Recognition, RecordFormat};
use reader::{Answer, Reader, Segment};

/// Bounds on what is read, so that a damaged or crafted file costs an error and not the machine.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// Time for one call, process start included; default 60 s. A call for several files has a second more
    /// for each.
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
    /// Time step, s, for a file that states none; a file that states another one is refused.
    pub dt: Option<f64>,
    /// Takes the instrument's response off, in place of a unit.
    pub response: Option<Response>,
}

impl Source {
    /// A file of which all channels are read, with the unit of the options.
    #[must_use]
    pub fn new(location: impl Into<PathBuf>) -> Self {
        Self { location: location.into(), unit: None, channel: None, dt: None, response: None }
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

impl Channel {
    /// Direction of a horizontal channel, degrees clockwise from north, where the file states it.
    #[must_use]
    pub fn azimuth(&self) -> Option<f64> {
        self.steps.first()?.found.get("azimuth_deg")?.as_f64()
    }
}

/// Reads all channels of one file; see [`read_many`].
pub fn read(location: &Path, options: &ReadOptions) -> Result<Vec<Channel>, InputError> {
    let mut files = read_many(&[Source::new(location)], options)?;
    Ok(files.pop().unwrap_or_default())
}

/// Reads several files in one process; one list of channels per source, in order.
///
/// Each channel is converted to SI: stored value × factor, the factor from the user's unit or from the
/// file (see [`ReadOptions::unit`]), or by its response ([`Source::response`]). Under the file's own unit
/// the peak about the mean must be one that a ground motion can have ([`Quantity::plausible_peak`]).
///
/// Errors: the first refusal in the order of the sources, each naming file, channel and remedy.
pub fn read_many(sources: &[Source], options: &ReadOptions) -> Result<Vec<Vec<Channel>>, InputError> {
    read_each(sources, options)?.into_iter().collect()
}

/// As [`read_many`], but a file that is refused does not stop the others: one result per source.
///
/// Errors: only what stops all, such as a Python that is missing or a reader that took too long.
pub fn read_each(
    sources: &[Source],
    options: &ReadOptions,
) -> Result<Vec<Result<Vec<Channel>, InputError>>, InputError> {
    let mut options = options.clone();
    options.limits.time += Duration::from_secs(sources.len().saturating_sub(1) as u64);
    let options = &options;
    let mut process = None;
    let mut recognised = Vec::with_capacity(sources.len());
    for source in sources {
        recognised.push(Recognised::of(source, &mut process, options));
    }
    // A Python that cannot be started stops the files that need it, and they say so themselves.
    if recognised.iter().all(Result::is_err) {
        return Ok(recognised.into_iter().map(|file| file.map(|_| Vec::new())).collect());
    }
    let requests: Vec<reader::Request<'_>> = recognised.iter().flatten().map(Recognised::request).collect();
    let answers = match running(&mut process, options)?.read(&requests, &options.limits) {
        Ok((version, answers)) => answers.into_iter().map(|answer| Ok((version.clone(), answer))).collect(),
        // A file that brings the reader down must not take the others with it: each has a process of its own.
        Err(InputError::ReaderFailed { .. } | InputError::ReaderTimeout { .. }) => {
            recognised.iter().flatten().map(|file| file.alone(options)).collect::<Vec<_>>()
        }
        Err(error) => return Err(error),
    };
    let mut answers = answers.into_iter();
    let finish = |file: Result<Recognised<'_>, InputError>| {
        let file = file?;
        let (version, answer) = answers.next().expect("one answer per request, checked by the reader")?;
        channels(&file, answer, &version, options)
    };
    Ok(recognised.into_iter().map(finish).collect())
}

/// A file whose bytes are in memory; its format where its first bytes tell.
struct Recognised<'a> {
    source: &'a Source,
    /// `None`: perhaps one of the text formats, whose plug-ins look for themselves.
    format: Option<&'static RecordFormat>,
    content: Vec<u8>,
    /// Metadata and ObsPy's word for their format.
    metadata: Option<(Vec<u8>, &'static str)>,
}

impl<'a> Recognised<'a> {
    fn of(
        source: &'a Source,
        process: &mut Option<Reader>,
        options: &ReadOptions,
    ) -> Result<Self, InputError> {
        let mut content_of = |location: &Path, limit| match location::packaged(location)? {
            None => location::content(location, limit),
            Some(inner) => {
                let root = running(process, options)?.package_root()?;
                location::content_packaged(location, &root, &inner, limit)
            }
        };
        let content = content_of(&source.location, options.limits.file_bytes)?;
        let format = recognise(&source.location, &content)?;
        let unit = source.unit.or(options.unit);
        if let (Some(response), Some(unit)) = (&source.response, unit) {
            return Err(InputError::UnitAndResponse {
                path: source.location.clone(),
                unit: unit.to_string(),
                metadata: response.metadata.clone(),
            });
        }
        let mut metadata = None;
        if let Some(response) = &source.response {
            let content = content_of(&response.metadata, response::METADATA_BYTES)?;
            let format = response::metadata_format(&response.metadata, &content)?;
            metadata = Some((content, format));
        }
        Ok(Self { source, format, content, metadata })
    }

    /// What a process of its own says of this file.
    fn alone(&self, options: &ReadOptions) -> Result<(String, Answer), InputError> {
        let mut process = Reader::start(options.python.as_deref(), &options.limits)?;
        match process.read(&[self.request()], &options.limits) {
            Ok((version, mut answers)) => Ok((version, answers.remove(0))),
            Err(InputError::ReaderFailed { problem, stderr, crashed: true, .. }) => {
                Err(InputError::ReaderCrashed { path: self.source.location.clone(), problem, stderr })
            }
            Err(error) => Err(error),
        }
    }

    fn request(&self) -> reader::Request<'_> {
        let response = match (&self.source.response, &self.metadata) {
            (Some(response), Some((content, format))) => {
                Some((response.request(format, content.len()), content.as_slice()))
            }
            _ => None,
        };
        let format = self.format.map_or("", |format| format.obspy);
        reader::Request { format, content: &self.content, response }
    }
}

fn running<'a>(process: &'a mut Option<Reader>, options: &ReadOptions) -> Result<&'a mut Reader, InputError> {
    if process.is_none() {
        *process = Some(Reader::start(options.python.as_deref(), &options.limits)?);
    }
    Ok(process.as_mut().expect("just started"))
}

/// The row of the format table that takes this content by its first bytes.
fn recognise(path: &Path, content: &[u8]) -> Result<Option<&'static RecordFormat>, InputError> {
    if let Some((what, remedy)) = formats::refused(content) {
        return Err(InputError::FormatRefused { path: path.into(), what, remedy });
    }
    for format in &FORMATS {
        match (format.recognise)(content) {
            Recognition::No => {}
            Recognition::Yes => return Ok(Some(format)),
            Recognition::Broken(problem) => return Err(broken(path, format.name, problem)),
        }
    }
    match formats::is_text(content) {
        true => Ok(None),
        false => Err(unknown(path, content)),
    }
}

fn unknown(path: &Path, content: &[u8]) -> InputError {
    let beginning = formats::beginning(content);
    InputError::FormatUnknown { path: path.into(), beginning, known: formats::known() }
}

fn broken(path: &Path, format: &'static str, problem: String) -> InputError {
    InputError::RecordBroken { path: path.into(), format, problem }
}

/// The channels of one file, checked and converted.
fn channels(
    file: &Recognised<'_>,
    answer: Answer,
    obspy: &str,
    options: &ReadOptions,
) -> Result<Vec<Channel>, InputError> {
    let path = file.source.location.as_path();
    let by_word = |word: &str| FORMATS.iter().find(|format| format.obspy == word);
    let (format, segments, warnings) = match answer {
        Answer::Segments { format, segments, warnings } => (by_word(&format), segments, warnings),
        Answer::Refused { format, problem, remedy } => {
            let (path, format) = (path.into(), by_word(&format).map_or("text", |format| format.name));
            return Err(match remedy {
                Some(remedy) => InputError::RecordRefused { path, format, problem, remedy },
                None => InputError::RecordBroken { path, format, problem },
            });
        }
        Answer::TooMany(samples) => {
            let (path, limit) = (path.into(), options.limits.samples);
            return Err(InputError::TooManySamples { path, samples, limit });
        }
        Answer::Unknown => return Err(unknown(path, &file.content)),
        Answer::NoPlugIns(reason) => {
            return Err(InputError::PlugInsMissing { path: path.into(), reason });
        }
    };
    // A word that the table lacks is a reader of another version.
    let Some(format) = format else {
        let reason = "they name a format that this program does not know".into();
        return Err(InputError::PlugInsMissing { path: path.into(), reason });
    };
    let damaged = |text: &&String| format.damage.iter().any(|category| text.starts_with(category));
    if let Some(warning) = warnings.iter().find(damaged) {
        return Err(broken(path, format.name, warning.clone()));
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
        return Err(broken(path, format.name, "it holds no samples".into()));
    }
    let sha256 = sha256(&file.content);
    let origin = Origin { file, format, sha256, obspy, warnings, options };
    groups.into_iter().map(|(_, members)| origin.channel(members)).collect()
}

fn sha256(content: &[u8]) -> String {
    Sha256::digest(content).iter().map(|byte| format!("{byte:02x}")).collect()
}

#[cfg(test)]
mod tests;
