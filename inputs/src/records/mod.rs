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
mod formats;
mod location;
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
use serde_json::json;
use sha2::{Digest, Sha256};

use crate::error::InputError;
use crate::motion::{Quantity, gravity};
use formats::{FORMATS, Recognition, RecordFormat, StoredUnit};
use reader::{Answer, Ground, Reader, Segment};

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

/// What a header may say of its samples that a user should see beside them.
const FACTS: [&str; 8] =
    ["title", "corrected", "filter", "left_out", "sense", "azimuth_deg", "peak_stated", "npts_stated"];

/// The unit of a vertical channel that counts downwards, turned so that z is up.
fn upward(mut unit: StoredUnit, whole: &Segment) -> StoredUnit {
    if whole.text("sense") == Some("down") {
        unit.factor = -unit.factor;
        unit.text.push_str(", positive down");
    }
    unit
}

/// What the channels of one file have in common.
struct Origin<'a> {
    file: &'a Recognised<'a>,
    format: &'static RecordFormat,
    sha256: String,
    obspy: &'a str,
    warnings: Vec<String>,
    options: &'a ReadOptions,
}

impl Origin<'_> {
    fn channel(&self, members: Vec<Segment>) -> Result<Channel, InputError> {
        let (path, format) = (self.file.source.location.as_path(), self.format);
        let mut whole = checks::join(path, members)?;
        self.time_step(&mut whole)?;
        checks::sound(path, &whole, self.options.accept_clipped)?;
        (format.consistent)(&whole).map_err(|problem| broken(path, format.name, problem))?;

        let removed = self.removed_response(&mut whole)?;
        let given = self.file.source.unit.or(self.options.unit);
        let unit = match &removed {
            Some((_, about)) => response::unit(about).ok_or_else(|| self.response_refused(&whole, "", ""))?,
            None => upward(self.unit(&whole, given)?, &whole),
        };
        let samples: Vec<f64> = match &removed {
            Some((ground, _)) => ground.clone(),
            None => whole.samples.iter().map(|value| value * unit.factor).collect(),
        };
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
        let mut unit_step = self.unit_step(&whole, &unit, given, removed.as_ref());
        let mean = samples.iter().sum::<f64>() / samples.len() as f64;
        if let Some(sign) = gravity(unit.quantity, mean) {
            unit_step.found.insert("gravity_g".into(), json!(sign));
        }
        let steps = vec![self.read_step(&whole), unit_step];
        Ok(Channel {
            file: path.into(),
            format: format.name,
            start: (whole.start_ns != 0).then_some(whole.start_ns as f64 * 1e-9),
            dt: whole.dt,
            samples,
            quantity: unit.quantity,
            unit_stored: unit.text,
            axis_hint: axis_hint(&whole),
            steps,
            sha256: self.sha256.clone(),
            id: whole.id,
        })
    }

    /// The step that was given, for a file that states none.
    fn time_step(&self, whole: &mut Segment) -> Result<(), InputError> {
        let (path, channel) = (self.file.source.location.clone(), whole.id.clone());
        let stated = whole.flag("dt_stated") != Some(false);
        match self.file.source.dt {
            None if stated => {}
            None => return Err(InputError::StepMissing { path, channel }),
            Some(given) if !(given.is_finite() && given > 0.0) => {
                return Err(InputError::BadStep { path, channel, dt: given });
            }
            Some(given) if stated && (given - whole.dt).abs() > 1e-6 * whole.dt => {
                return Err(InputError::StepContradicts { path, channel, stated: whole.dt, given });
            }
            Some(given) => whole.dt = given,
        }
        Ok(())
    }

    /// Ground motion in SI and the account of how it came about, where a response was to be removed.
    fn removed_response(
        &self,
        whole: &mut Segment,
    ) -> Result<Option<(Vec<f64>, serde_json::Value)>, InputError> {
        if self.file.source.response.is_none() {
            return Ok(None);
        }
        match whole.ground.take() {
            Some(Ground::Removed { samples, about }) => {
                let finite = samples.iter().all(|value| value.is_finite());
                if !finite {
                    let problem = "the division by the response gave values that are not finite";
                    return Err(self.response_refused(whole, problem, "give a narrower pre_filter"));
                }
                // Poles and zeros often do not say whose they are: the channel's code then tells.
                let quantity = response::unit(&about).map(|unit| unit.quantity);
                if let (Some(instrument), Some(Quantity::Velocity)) = (instrument(&whole.channel), quantity)
                    && instrument == ACCELEROMETER
                {
                    let code = &whole.channel;
                    let problem = format!("it is of velocity, but its code {code} is that of {instrument}");
                    return Err(self.response_refused(whole, &problem, "give the metadata of this channel"));
                }
                Ok(Some((samples, about)))
            }
            Some(Ground::Refused { problem, remedy }) => Err(self.response_refused(whole, &problem, &remedy)),
            None => {
                let problem = "the channel comes in several pieces";
                Err(self.response_refused(whole, problem, "join the pieces, or cut one out"))
            }
        }
    }

    fn response_refused(&self, whole: &Segment, problem: &str, remedy: &str) -> InputError {
        let metadata = self.file.source.response.as_ref().map(|response| response.metadata.clone());
        InputError::ResponseRefused {
            path: self.file.source.location.clone(),
            metadata: metadata.unwrap_or_default(),
            problem: if problem.contains(&whole.id) {
                problem.into()
            } else {
                format!("{}: {problem}", whole.id)
            },
            remedy: remedy.into(),
        }
    }

    fn read_step(&self, whole: &Segment) -> Step {
        let mut read = json!({
            "format": self.format.name, "obspy": self.obspy, "samples": whole.samples.len(), "dt_s": whole.dt,
        });
        if self.file.source.dt.is_some() {
            read["dt_given_by"] = json!("user");
        }
        if !self.warnings.is_empty() {
            read["warnings"] = json!(self.warnings);
        }
        let facts = FACTS.iter().filter_map(|key| Some((key.to_string(), whole.header.get(*key)?.clone())));
        Step::new("read", read).with_found(serde_json::Value::Object(facts.collect()))
    }

    fn unit_step(
        &self,
        whole: &Segment,
        unit: &StoredUnit,
        given: Option<Unit>,
        removed: Option<&(Vec<f64>, serde_json::Value)>,
    ) -> Step {
        let by = match (removed, given) {
            (Some(_), _) => "metadata",
            (None, Some(_)) => "user",
            (None, None) => "file",
        };
        let stored = if given.is_some() { self.format.stored } else { unit.text.as_str() };
        let mut convert = json!({
            "stored": stored, "given_by": by, "unit": unit.text, "quantity": unit.quantity,
            "factor_to_si": unit.factor, "si": unit.quantity.si_unit(),
        });
        if let (Some((_, about)), Some(response)) = (removed, &self.file.source.response) {
            convert["factor_to_si"] = serde_json::Value::Null;
            convert["metadata_file"] = json!(response.metadata);
            if let Some((content, _)) = &self.file.metadata {
                convert["metadata_sha256"] = json!(sha256(content));
            }
            convert["response"] = about.clone();
        }
        if given.is_some()
            && let Some(calib) = whole.calib.filter(|calib| *calib != 1.0)
        {
            convert["calibration_not_applied"] = json!(calib);
        }
        if let Some(instrument) = instrument(&whole.channel) {
            convert["instrument_by_code"] = json!(instrument);
        }
        Step::new("unit", convert)
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
        (self.format.unit)(whole).map_err(|reason| InputError::UnitMissing {
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

fn sha256(content: &[u8]) -> String {
    Sha256::digest(content).iter().map(|byte| format!("{byte:02x}")).collect()
}

/// Axis by the file's own direction (vertical, or an azimuth within 1° of east or north), else by the
/// channel's name: `EW`, `EW1`, `HNE`, `x` → 0; north → 1; `UD2`, `HNZ` → 2.
fn axis_hint(whole: &Segment) -> Option<usize> {
    if whole.flag("vertical") == Some(true) {
        return Some(2);
    }
    if let Some(azimuth) = whole.number("azimuth_deg") {
        let away = |direction: f64| ((azimuth - direction + 180.0).rem_euclid(360.0) - 180.0).abs();
        return [90.0, 0.0].into_iter().position(|direction| away(direction) <= 1.0);
    }
    axis_by_name(&whole.channel)
}

fn axis_by_name(channel: &str) -> Option<usize> {
    let name = channel.trim().to_ascii_uppercase();
    // KiK-net numbers its sensors: EW1 in the borehole, EW2 at the surface.
    match name.trim_end_matches(['1', '2']) {
        "EW" => return Some(0),
        "NS" => return Some(1),
        "UD" | "UP" => return Some(2),
        _ => {}
    }
    match name.chars().last()? {
        'E' | 'X' => Some(0),
        'N' | 'Y' => Some(1),
        'Z' => Some(2),
        _ => None,
    }
}

/// What [`instrument`] says of the code letter N.
const ACCELEROMETER: &str = "an accelerometer";

/// The instrument that a three-letter SEED channel code names, by its second letter.
fn instrument(channel: &str) -> Option<&'static str> {
    let mut letters = channel.trim().chars();
    let (_, second, _) = (letters.next()?, letters.next()?, letters.next()?);
    match second {
        _ if letters.next().is_some() => None,
        'H' | 'L' => Some("a velocity seismometer"),
        'N' => Some(ACCELEROMETER),
        _ => None,
    }
}

#[cfg(test)]
mod tests;
