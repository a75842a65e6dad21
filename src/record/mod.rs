//! Records looked at one by one or in batches: what was found in the files, what was done to it, what it
//! measures, and the motion that comes out, with an account from which it can be made again.
//!
//! [`look`] reads files, sorts their channels into [`Recording`]s of one to three components and applies
//! the steps asked; [`replay`] does the same from the account ([`Origin`]) in a file written earlier.
//! [`write`](write()) leaves a folder: `report.html` with figures, the motion as CSV, miniSEED or SAC, and
//! `record.json`.

mod apart;
mod group;
mod measured;
mod number;
mod origin;
mod place;
mod summary;
mod warnings;
mod write;

use std::fmt;
use std::path::PathBuf;

use hati_inputs::InputError;
use hati_inputs::motion::{Matching, Motion, Process, Quantity};
use hati_inputs::records::{self, Channel, ReadOptions, Source};

use crate::outputs::OutputError;
use crate::results::AXES;

pub use group::{Components, group};
pub use measured::{Component, Measured};
pub(crate) use number::{figures, shortest};
pub use origin::{Origin, OriginFile, Sources};
pub(crate) use place::abandon;
pub(crate) use write::NOT_OURS;
pub use write::{Formats, Written, write};

/// What can go wrong with a recording besides its files.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RecordError {
    /// The record, its components or a step.
    #[error(transparent)]
    Input(#[from] InputError),
    /// The folder, the disk.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// A file of the output's name that this program did not write, or one of the sources.
    #[error("{}: {what}; it is not replaced\n  help: choose another folder with --out, or move the file away", path.display())]
    NotOurs {
        /// The file.
        path: PathBuf,
        /// What it is.
        what: &'static str,
    },
    /// A file that should tell where a motion comes from cannot be read.
    #[error("{}: cannot be read: {cause}\n  help: give a CSV file or a record.json that `hati record --out` wrote", path.display())]
    OriginUnreadable {
        /// The file.
        path: PathBuf,
        /// What the system said.
        cause: std::io::Error,
    },
    /// A file does not tell where its motion comes from.
    #[error("{}: does not say how its motion was made: {problem}\n  help: give a CSV file or a record.json that `hati record --out` wrote", path.display())]
    OriginMissing {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        problem: String,
    },
    /// A source of a motion is not where it was.
    #[error("{}: the record that {} was made from is not there; looked for {looked}\n  help: put the record beside that file, or work in the folder that its path counts from", path.display(), from.display())]
    SourceMissing {
        /// The record.
        path: PathBuf,
        /// The file that names it.
        from: PathBuf,
        /// Where it was looked for.
        looked: String,
    },
    /// A source of a motion holds other bytes than it did.
    #[error("{}: is not the file that the motion was made from: its SHA-256 is {found}, expected {expected}\n  help: find the file of that content; to use this one, name it to `hati record` itself", path.display())]
    SourceChanged {
        /// The file.
        path: PathBuf,
        /// The hash in the account.
        expected: String,
        /// The hash of the file.
        found: String,
    },
}

/// One recording: its channels as they were read, and the motion after the steps.
#[derive(Debug, Clone)]
pub struct Recording {
    /// Station and instrument, fit for a file's name: `CI.CLC.HN`; the file's own name where no station is known.
    pub name: String,
    /// The channels along x, y and z.
    pub channels: [Option<Channel>; 3],
    /// The motion after the steps.
    pub motion: Motion,
    /// From which it can be made again.
    pub origin: Origin,
    /// What is to be said of its grouping: channels that stayed apart, times that are taken for common.
    pub notes: Vec<String>,
}

/// The last match to a design spectrum among the steps of a recording, and what it started from.
#[derive(Debug, Clone)]
pub(crate) struct Matched {
    /// Target, periods and tolerance.
    pub(crate) matching: Matching,
    /// Accelerations that came into the match, m/s².
    pub(crate) seed: [Option<Vec<f64>>; 3],
    /// Their step, s.
    pub(crate) seed_dt: f64,
    /// Factors by which the match first scaled them.
    pub(crate) scale: [f64; 3],
}

/// A file or a recording that was refused.
#[derive(Debug)]
pub struct Refused {
    /// The file, or the recording's name.
    pub what: String,
    /// Why.
    pub error: RecordError,
}

impl fmt::Display for Refused {
    /// The reason, which begins with what was refused.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let reason = self.error.to_string();
        if reason.contains(&self.what) { f.write_str(&reason) } else { write!(f, "{}: {reason}", self.what) }
    }
}

/// What became of some files.
#[derive(Debug, Default)]
pub struct Looked {
    /// The recordings in the order of their first channel.
    pub recordings: Vec<Recording>,
    /// What was refused, in the order of the files.
    pub refused: Vec<Refused>,
}

/// Reads files, sorts their channels into recordings ([`group`]) and applies the steps to each.
///
/// A file, a set of components that contradict each other, or a step that cannot be done is refused by
/// itself and does not stop the others.
///
/// Errors: only what stops all of them, such as a Python that is missing.
pub fn look(sources: &[Source], process: &[Process], options: &ReadOptions) -> Result<Looked, RecordError> {
    let mut looked = Looked::default();
    let mut channels = vec![];
    for (number, file) in records::read_each(sources, options)?.into_iter().enumerate() {
        match file {
            Ok(found) => channels.extend(found.into_iter().map(|channel| (number, channel))),
            Err(error) => {
                let what = sources[number].location.display().to_string();
                looked.refused.push(Refused { what, error: error.into() });
            }
        }
    }
    let mut names = vec![];
    let groups = group(channels);
    let notes = apart::notes(&groups);
    for (components, notes) in groups.into_iter().zip(notes) {
        let name = distinct(name(&components), &mut names);
        let origin = Origin::new(&components, sources, process);
        match Recording::new(name.clone(), components, origin) {
            Ok(recording) => looked.recordings.push(Recording { notes, ..recording }),
            Err(error) => looked.refused.push(Refused { what: name, error }),
        }
    }
    Ok(looked)
}

/// Makes the motion again that the file `from` (CSV or `record.json` of [`write`](write())) tells of: the
/// same files by their hashes, the same steps, the same samples to the last bit.
///
/// Errors: no account in the file; a source that is missing or has changed; whatever reading and
/// processing refuse.
pub fn replay(from: &std::path::Path, options: &ReadOptions) -> Result<Recording, RecordError> {
    let origin = Origin::read(from)?;
    let named = origin.sources(from)?;
    let sources: Vec<Source> = named.iter().map(|(_, source)| source.clone()).collect();
    let mut components: Components = [None, None, None];
    for ((number, (axis, _)), found) in named.iter().enumerate().zip(records::read_many(&sources, options)?) {
        components[*axis] = found.into_iter().next().map(|channel| (number, channel));
    }
    origin.expect_same(&components)?;
    let notes = apart::notes(std::slice::from_ref(&components)).remove(0);
    let recording = Recording::new(name(&components), components, origin)?;
    Ok(Recording { notes, ..recording })
}

impl Recording {
    fn new(name: String, components: Components, origin: Origin) -> Result<Self, RecordError> {
        let channels = components.map(|c| c.map(|(_, channel)| channel));
        let mut motion =
            Motion::from_channels([channels[0].as_ref(), channels[1].as_ref(), channels[2].as_ref()])?;
        for step in &origin.process {
            step.apply(&mut motion)?;
        }
        Ok(Self { name, channels, motion, origin, notes: vec![] })
    }

    /// The last match to a design spectrum, with its seed made again from the channels.
    pub(crate) fn matched(&self) -> Option<Matched> {
        let is_match = |step: &Process| matches!(step, Process::Match(_));
        let last = self.origin.process.iter().rposition(is_match)?;
        let Process::Match(matching) = &self.origin.process[last] else { return None };
        let mut seed = Motion::from_channels(self.channels.each_ref().map(Option::as_ref)).ok()?;
        for step in &self.origin.process[..last] {
            step.apply(&mut seed).ok()?;
        }
        let found = self.motion.steps.iter().rev().find(|step| step.name == "match").map(|step| &step.found);
        let scale = |axis: usize| {
            let entry = found.and_then(|found| found.get(AXES[axis].to_string().as_str()));
            entry.and_then(|entry| entry.get("scale")?.as_f64()).unwrap_or(1.0)
        };
        let samples = |axis: usize| seed.component_as(axis, Quantity::Acceleration, 1);
        Some(Matched {
            matching: matching.clone(),
            seed: [0, 1, 2].map(samples),
            seed_dt: seed.dt,
            scale: [0, 1, 2].map(scale),
        })
    }

    /// Whether the ground was brought to rest by a `rest` or a `match` and no later step can have moved it again:
    /// velocity and displacement then are the integrals from rest.
    #[must_use]
    pub fn at_rest(&self) -> bool {
        let rests = |step: &Process| matches!(step, Process::Rest {} | Process::Match(_));
        let keeps =
            |step: &Process| matches!(step, Process::Rotate { .. } | Process::Scale(_) | Process::Pad { .. });
        self.origin
            .process
            .iter()
            .rposition(rests)
            .is_some_and(|last| self.origin.process[last + 1..].iter().all(keeps))
    }

    /// By how much all rotations together turned x and y, degrees counter-clockwise seen from above.
    #[must_use]
    pub fn turned(&self) -> f64 {
        let turn = |step: &Process| if let Process::Rotate { angle } = step { *angle } else { 0.0 };
        self.origin.process.iter().map(turn).sum()
    }

    /// Components that are there, 0 = x, 1 = y, 2 = z.
    #[must_use]
    pub fn axes(&self) -> Vec<usize> {
        (0..3).filter(|&axis| self.motion.components[axis].is_some()).collect()
    }
}

/// Station and instrument of some channels, the whole id of a single one; the file's name without a station.
fn name(components: &Components) -> String {
    let channels: Vec<&Channel> = components.iter().flatten().map(|(_, channel)| channel).collect();
    let Some(first) = channels.first() else { return String::new() };
    let mut parts: Vec<&str> = first.id.split('.').collect();
    let code = parts.pop().unwrap_or_default();
    let station = parts.get(1).is_some_and(|station| !station.is_empty());
    // Formats that number their channels put the number where others have the location.
    let location = |channel: &Channel| channel.id.split('.').nth(2).map(str::to_owned);
    if channels.iter().any(|c| location(c) != location(first)) {
        parts.truncate(2);
    }
    parts.push(if channels.len() > 1 { group::without_direction(code) } else { code });
    let file = first.file.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
    let text = match station {
        true => parts.into_iter().filter(|part| !part.is_empty()).collect::<Vec<_>>().join("."),
        // CH is no name but a place-holder.
        false if channels.len() == 1 && !code.is_empty() && code != "CH" => format!("{file}.{code}"),
        false => file,
    };
    let plain = |c: char| if c.is_alphanumeric() || ".-_".contains(c) { c } else { '_' };
    let text: String = text.chars().map(plain).collect();
    let text = text.trim_matches('.');
    if text.is_empty() { "record".into() } else { text.into() }
}

/// The name itself, or with a number behind it where it was given before.
fn distinct(name: String, given: &mut Vec<String>) -> String {
    let numbered = |n: usize| if n == 1 { name.clone() } else { format!("{name}-{n}") };
    // Two names that differ in case only are one folder on some systems.
    let taken = |candidate: &str| given.iter().any(|other| other.to_lowercase() == candidate.to_lowercase());
    let free = (1..).map(numbered).find(|candidate| !taken(candidate)).unwrap_or(name);
    given.push(free.clone());
    free
}

#[cfg(test)]
mod tests {
    use super::distinct;

    #[test]
    fn names_that_come_again_are_numbered() {
        let mut given = vec![];
        let names = ["A.B", "a.b", "A.B", "C"].map(|name| distinct(name.into(), &mut given));
        assert_eq!(names, ["A.B", "a.b-2", "A.B-3", "C"]);
    }
}
