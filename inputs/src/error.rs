//! The one error type of this crate: what was wrong, where, what was expected, what to do. One list, longer than other files.

use std::path::PathBuf;

use crate::gmsh::{MeshFault, point};
use crate::motion::Quantity;
use crate::number::{brief, nine, plain};
use words::{and_others, no_step, step_options};

/// Everything that can be wrong with a record, a motion or the reader behind them.
///
/// Each text is complete by itself: it names the file, the channel or the step, the number that was
/// found, the one that was expected, and the remedy: its last line begins with `help:`. A remedy that is an option of
/// the command line is also a key of a scene, and both are named.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum InputError {
    // ---- where the record is ------------------------------------------------------------------
    /// A record was named by a network address.
    #[error(
        "{location}: is a network address; records are read from local files only
  help: download the file and give its path"
    )]
    LocationIsUrl {
        /// What was given.
        location: String,
    },
    /// A pattern was given where one file is meant.
    #[error(
        "{location}: no such file; wildcards are not expanded, one record is one file
  help: name the file itself, one per component"
    )]
    LocationIsPattern {
        /// What was given.
        location: String,
    },
    /// No file of that name.
    #[error("{}: no such file\n  help: check the spelling; relative paths count from the current folder", path.display())]
    RecordMissing {
        /// The file.
        path: PathBuf,
    },
    /// A folder where a file was meant.
    #[error("{}: is a folder; a record is one file\n  help: name the file inside it", path.display())]
    RecordIsFolder {
        /// The folder.
        path: PathBuf,
    },
    /// A pipe, socket or device.
    #[error("{}: is not a regular file (a pipe, socket or device)\n  help: save the record to a file first", path.display())]
    RecordNotRegular {
        /// The path.
        path: PathBuf,
    },
    /// The system refused to open or read the file.
    #[error("{}: cannot be read: {source}\n  help: make sure that the file may be read and its disk is there", path.display())]
    RecordUnreadable {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// More bytes than the limit.
    #[error("{}: {bytes} bytes, above the limit of {limit} bytes for one record
  help: cut the part of interest out of the file, or take one of its channels into a file of its own", path.display())]
    RecordTooLarge {
        /// The file.
        path: PathBuf,
        /// Its size.
        bytes: u64,
        /// The limit.
        limit: u64,
    },
    /// No bytes at all.
    #[error("{}: the file is empty\n  help: fetch it again from its source", path.display())]
    RecordEmpty {
        /// The file.
        path: PathBuf,
    },
    /// `obspy:` names something outside the installed package.
    #[error("{location}: must be a relative path inside the installed ObsPy package, without `..` or links that leave it
  help: for instance obspy:io/nied/tests/data/test.knet")]
    PackagedOutside {
        /// What was given.
        location: String,
    },

    // ---- what the record is -------------------------------------------------------------------
    /// The content matches no format of the table.
    #[error("{}: no known record format; it begins with {beginning}
  help: formats read here: {known}", path.display())]
    FormatUnknown {
        /// The file.
        path: PathBuf,
        /// Its first bytes, printable.
        beginning: String,
        /// The names of the formats that can be read.
        known: String,
    },
    /// The content is recognised and is never read as a record.
    #[error("{}: is {what}\n  help: {remedy}", path.display())]
    FormatRefused {
        /// The file.
        path: PathBuf,
        /// What the file is.
        what: &'static str,
        /// What to do.
        remedy: &'static str,
    },
    /// The header or the data contradict the format.
    #[error("{}: broken {format} file: {problem}\n  help: fetch the file again from its source; a damaged record is not repaired here", path.display())]
    RecordBroken {
        /// The file.
        path: PathBuf,
        /// The format.
        format: &'static str,
        /// What is wrong.
        problem: String,
    },
    /// A reader of a text format refuses the content and knows what to do about it.
    #[error("{}: {format} file: {problem}\n  help: {remedy}", path.display())]
    RecordRefused {
        /// The file.
        path: PathBuf,
        /// The format.
        format: &'static str,
        /// What is wrong, with the line.
        problem: String,
        /// What to do.
        remedy: String,
    },
    /// More samples than the limit.
    #[error("{}: {samples} samples, above the limit of {limit}\n  help: cut the part of interest out of the file, or take one of its channels into a file of its own", path.display())]
    TooManySamples {
        /// The file.
        path: PathBuf,
        /// Samples in the file.
        samples: u64,
        /// The limit.
        limit: u64,
    },

    /// The file has no channel of the name asked for.
    #[error("{}: no channel {wanted}; the file holds {present}\n  help: give --channel or `channel` as one of those", path.display())]
    ChannelMissing {
        /// The file.
        path: PathBuf,
        /// What was asked for.
        wanted: String,
        /// The ids that it holds.
        present: String,
    },

    // ---- whether its samples are sound ----------------------------------------------------------
    /// Samples missing between two segments of one channel.
    #[error("{} {channel}: gap of {seconds:.6} s: a segment ends at {end}, the next begins at {begin}
  help: use an unbroken stretch of the record; gaps are not filled", path.display())]
    Gap {
        /// The file.
        path: PathBuf,
        /// The channel.
        channel: String,
        /// Last sample before the gap, UTC.
        end: String,
        /// First sample after the gap, UTC.
        begin: String,
        /// Missing time, s.
        seconds: f64,
    },
    /// Two segments of one channel cover the same time.
    #[error("{} {channel}: overlap of {seconds:.6} s: a segment ends at {end}, the next begins at {begin}
  help: remove the doubled segment; overlaps are not merged", path.display())]
    Overlap {
        /// The file.
        path: PathBuf,
        /// The channel.
        channel: String,
        /// Last sample of the earlier segment, UTC.
        end: String,
        /// First sample of the later segment, UTC.
        begin: String,
        /// Doubled time, s.
        seconds: f64,
    },
    /// Two segments of one channel have different steps.
    #[error("{} {channel}: mixed sampling: step {} s from {first_begin}, step {} s from {second_begin}
  help: split the file at the change and choose one part", path.display(), nine(*first), nine(*second))]
    MixedRates {
        /// The file.
        path: PathBuf,
        /// The channel.
        channel: String,
        /// First step, s.
        first: f64,
        /// Where it begins, UTC.
        first_begin: String,
        /// Second step, s.
        second: f64,
        /// Where it begins, UTC.
        second_begin: String,
    },
    /// Too few samples to be a motion.
    #[error("{} {channel}: {samples} sample(s); a motion needs at least 2\n  help: choose a longer record", path.display())]
    TooShort {
        /// The file.
        path: PathBuf,
        /// The channel.
        channel: String,
        /// Samples found.
        samples: usize,
    },
    /// A step that is not a positive number.
    #[error("{} {channel}: time step {} s; it must be a positive number\n  help: the file's header lacks a valid sampling rate: fetch the file again, or save the samples as text and give --dt or `dt`", path.display(), plain(*dt))]
    BadStep {
        /// The file.
        path: PathBuf,
        /// The channel.
        channel: String,
        /// The step, s.
        dt: f64,
    },
    /// A sample that is not a number.
    #[error("{} {channel}: sample {index} (at {time:.6} s) is {value}; {count} sample(s) of the channel are not finite
  help: repair the record at its source; such samples are not replaced", path.display())]
    NotFinite {
        /// The file.
        path: PathBuf,
        /// The channel.
        channel: String,
        /// Index of the first such sample, from 0.
        index: usize,
        /// Its time after the first sample, s.
        time: f64,
        /// Its value.
        value: f64,
        /// How many there are.
        count: usize,
    },
    /// Every sample has the same value.
    #[error("{} {channel}: dead channel: all {samples} samples are {}\n  help: choose another component or record", path.display(), nine(*value))]
    DeadChannel {
        /// The file.
        path: PathBuf,
        /// The channel.
        channel: String,
        /// How many samples.
        samples: usize,
        /// Their common value, as stored.
        value: f64,
    },
    /// The instrument ran into its limit.
    #[error("{} {channel}: clipped: {count} samples at the extreme value {} (as stored), {run} of them in a row from {time:.3} s, entered and left at full slope
  help: choose an unclipped record; if the plateau is meant, give --accept-clipped or accept_clipped = true in [motion]", path.display(), nine(*value))]
    Clipped {
        /// The file.
        path: PathBuf,
        /// The channel.
        channel: String,
        /// Samples in a row where it was first noticed.
        run: usize,
        /// Samples at that value in the whole channel.
        count: usize,
        /// The value, as stored.
        value: f64,
        /// Where the run begins, s after the first sample.
        time: f64,
    },

    // ---- what its numbers mean ------------------------------------------------------------------
    /// The file does not say what its numbers mean.
    #[error("{} {channel}: no unit: {reason}\n  help: counts become a motion by the instrument's metadata (--metadata FILE or metadata = \"FILE\"), which take it off; \
        else say what one sample means (--unit or `unit`), one of {choices}", path.display())]
    UnitMissing {
        /// The file.
        path: PathBuf,
        /// The channel.
        channel: String,
        /// Why the file does not tell.
        reason: String,
        /// The units that can be given.
        choices: String,
    },
    /// A unit that is not in the list.
    #[error("unknown unit \"{found}\"\n  help: one of {choices}")]
    UnitUnknown {
        /// What was given.
        found: String,
        /// The units that can be given.
        choices: String,
    },
    /// Under the file's own unit the peak cannot be a ground motion.
    #[error("{} {channel}: under the file's own unit ({unit}) the {quantity} peak about the mean is {peak:.3e} {si}, outside {low:e} to {high} {si}
  help: the header is likely wrong; say what one sample means with --unit or `unit` (for instance unit = \"g\")", path.display())]
    PeakImplausible {
        /// The file.
        path: PathBuf,
        /// The channel.
        channel: String,
        /// The unit that the file states.
        unit: String,
        /// The quantity that the file states.
        quantity: Quantity,
        /// Peak about the mean, SI.
        peak: f64,
        /// SI unit of the quantity.
        si: &'static str,
        /// Smallest plausible peak.
        low: f64,
        /// Largest plausible peak.
        high: f64,
    },
    /// The file holds another quantity than the one asked for.
    #[error("{} {channel}: holds {found}, but {expected} was asked for\n  help: say quantity = \"{found}\" (it is then converted in the frequency domain), choose the {expected} channel, or correct the unit if the header is wrong", path.display())]
    QuantityMismatch {
        /// The file.
        path: PathBuf,
        /// The channel.
        channel: String,
        /// What the file holds.
        found: Quantity,
        /// What was asked for.
        expected: Quantity,
    },

    /// The file does not say its time step, or not for sure.
    #[error("{} {channel}: {}\n  help: give the step in s with {}", path.display(), no_step(doubt.as_deref()), step_options(*fits))]
    StepMissing {
        /// The file.
        path: PathBuf,
        /// The channel.
        channel: String,
        /// The step that was found and why it is doubted; none where there is no word of one.
        doubt: Option<String>,
        /// The step that the file's times fit, s, where they are too coarse to show it.
        fits: Option<f64>,
    },
    /// A time step that no accelerograph has.
    #[error("{} {channel}: the file's time step is read as {} s, which no accelerograph has ({low:e} to {high} s)\n  help: see whether the header is in ms or kHz; if the step is meant, confirm it with {}", path.display(), brief(*dt), step_options(Some(*dt)))]
    StepImplausible {
        /// The file.
        path: PathBuf,
        /// The channel.
        channel: String,
        /// The step, s.
        dt: f64,
        /// Smallest step that needs no word.
        low: f64,
        /// Largest step that needs no word.
        high: f64,
    },
    /// The file says one time step and the user another.
    #[error("{} {channel}: dt = {} s was given, but the file states {} s\n  help: take --dt or `dt` out; it is for files that state no step", path.display(), plain(*given), brief(*stated))]
    StepContradicts {
        /// The file.
        path: PathBuf,
        /// The channel.
        channel: String,
        /// The file's step, s.
        stated: f64,
        /// The step that was given, s.
        given: f64,
    },
    /// A file of metadata that is none of those that can be read.
    #[error("{}: no station metadata: {problem}\n  help: give FDSN StationXML, a RESP file, or SAC poles and zeros", path.display())]
    MetadataUnknown {
        /// The file.
        path: PathBuf,
        /// What it is instead.
        problem: String,
    },
    /// A response that cannot be taken off, contradicts itself or belongs to another channel.
    #[error("{}: response by {}: {problem}\n  help: {remedy}", path.display(), metadata.display())]
    ResponseRefused {
        /// The record.
        path: PathBuf,
        /// The file of metadata.
        metadata: PathBuf,
        /// What is wrong, with the channel.
        problem: String,
        /// What to do.
        remedy: String,
    },
    /// A unit and a response at once.
    #[error("{}: both a unit ({unit}) and a response ({}) are given; they contradict each other\n  help: the response turns counts into SI: take --unit or `unit` out, or --metadata or `metadata`", path.display(), metadata.display())]
    UnitAndResponse {
        /// The record.
        path: PathBuf,
        /// The unit.
        unit: String,
        /// The file of metadata.
        metadata: PathBuf,
    },

    // ---- the reader process ---------------------------------------------------------------------
    /// No Python interpreter could be started.
    #[error("no Python to read records with; tried {tried}
  help: run `make setup` in hati's folder, or `python3 -m venv .venv && .venv/bin/pip install obspy==1.5.0`, or set HATI_PYTHON to a Python that has ObsPy")]
    PythonMissing {
        /// What was tried.
        tried: String,
    },
    /// Python runs but has no ObsPy.
    #[error("{}: this Python has no usable ObsPy: {reason}
  help: run `make setup` in hati's folder, or `python3 -m venv .venv && .venv/bin/pip install obspy==1.5.0`, or set HATI_PYTHON to a Python that has ObsPy", python.display())]
    ObspyMissing {
        /// The interpreter.
        python: PathBuf,
        /// What its import said.
        reason: String,
    },
    /// Python has ObsPy, but not the plug-ins for text formats.
    #[error("{}: may be a text record, but this Python has not the readers of such files: {reason}
  help: run `make setup` in hati's folder, or install the folder inputs/python into that Python with pip", path.display())]
    PlugInsMissing {
        /// The record.
        path: PathBuf,
        /// What the import said.
        reason: String,
    },
    /// The reader crashed on one file.
    #[error("{}: the library that reads such files crashes on it: {problem}{stderr}
  help: the file is most likely damaged; fetch it again from its source", path.display())]
    ReaderCrashed {
        /// The record.
        path: PathBuf,
        /// How the reader ended.
        problem: String,
        /// The end of what it wrote on stderr, on lines of its own, or nothing.
        stderr: String,
    },
    /// The reader took longer than allowed and was stopped.
    #[error("{}: reading took more than {seconds} s and was stopped{stderr}\n  help: read fewer files at once, or cut the part of interest out of the file", python.display())]
    ReaderTimeout {
        /// The interpreter.
        python: PathBuf,
        /// The limit, s.
        seconds: f64,
        /// The end of what it wrote on stderr, on lines of its own, or nothing.
        stderr: String,
    },
    /// The reader ended or answered in a way it should not.
    #[error("{}: the record reader failed: {problem}{stderr}\n  help: run `make setup` in hati's folder and try again; if one file does it each time, that file is most likely damaged", python.display())]
    ReaderFailed {
        /// The interpreter.
        python: PathBuf,
        /// What happened.
        problem: String,
        /// The end of what it wrote on stderr, on lines of its own, or nothing.
        stderr: String,
        /// Whether a signal ended it: a crash, not a word of its own.
        crashed: bool,
    },

    // ---- meshes -----------------------------------------------------------------------------------
    /// A damaged mesh file.
    #[error("{}: {place}: {problem}\n  help: write the mesh again; a damaged file is not repaired here", path.display())]
    MeshBroken {
        /// The file.
        path: PathBuf,
        /// Line, byte, node or element.
        place: String,
        /// What is wrong there.
        problem: String,
    },
    /// A sound file that is no mesh for this program.
    #[error("{}: {problem}\n  help: {remedy}", path.display())]
    MeshRefused {
        /// The file.
        path: PathBuf,
        /// What it is.
        problem: String,
        /// What to do.
        remedy: String,
    },
    /// An element that cannot be computed with.
    #[error("{}: element {tag} at {}{}: {fault}\n  help: {}", path.display(), point(*centre), and_others(*others), fault.remedy())]
    MeshElement {
        /// The file.
        path: PathBuf,
        /// Gmsh's tag of the element.
        tag: u64,
        /// Mean of its corners in the coordinates of the file.
        centre: [f64; 3],
        /// What is wrong with it.
        fault: Box<MeshFault>,
        /// How many other elements are known to have the same fault.
        others: usize,
    },
    /// A geometry that is not run.
    #[error("{}: {problem}\n  help: {remedy}", path.display())]
    GeoRefused {
        /// The `.geo` file.
        path: PathBuf,
        /// Why.
        problem: String,
        /// What to do.
        remedy: &'static str,
    },
    /// No Gmsh could be started.
    #[error("{}: this Python has no usable Gmsh: {reason}
  help: run `make setup` in hati's folder and read what it says of Gmsh; or mesh by any Gmsh 4 (gmsh -3 -format msh41) and name the .msh file", python.display())]
    GmshMissing {
        /// The interpreter.
        python: PathBuf,
        /// What it said.
        reason: String,
    },
    /// Gmsh did not mesh a geometry.
    #[error("{}: {problem}{messages}\n  help: open the file in Gmsh and mesh it there; its own messages name the line", path.display())]
    GmshFailed {
        /// The `.geo` file.
        path: PathBuf,
        /// What happened.
        problem: String,
        /// The end of Gmsh's messages, on lines of their own, or nothing.
        messages: String,
    },
    /// Gmsh took longer than allowed and was stopped.
    #[error("{}: meshing took more than {seconds} s and was stopped{messages}\n  help: mesh it coarser, or by itself (gmsh -3 -format msh41) and name the .msh file", path.display())]
    GmshTimeout {
        /// The `.geo` file.
        path: PathBuf,
        /// The limit, s.
        seconds: f64,
        /// The end of Gmsh's messages, on lines of their own, or nothing.
        messages: String,
    },

    // ---- motions --------------------------------------------------------------------------------
    /// A motion without any component.
    #[error("a motion has no component\n  help: give x, y or z, at least one of them")]
    NoComponent,
    /// One channel for two components.
    #[error(
        "components {first} and {second} are the same channel: {channel} of {}
  help: name another file or channel for one of them",
        path.display()
    )]
    ComponentTwice {
        /// Name of the first component.
        first: &'static str,
        /// Name of the second.
        second: &'static str,
        /// The channel.
        channel: String,
        /// Its file.
        path: PathBuf,
    },
    /// Components that do not fit together.
    #[error(
        "components {first} and {second} differ in {what}: {first_value} and {second_value}
  help: use the components of one recording, cut to the same time and step"
    )]
    ComponentsDiffer {
        /// Name of the first component.
        first: &'static str,
        /// Name of the second.
        second: &'static str,
        /// What differs.
        what: &'static str,
        /// Value in the first.
        first_value: String,
        /// Value in the second.
        second_value: String,
    },
    /// A motion that a processing step cannot act on, or a step that lacks something.
    #[error("{step}: {problem}\n  help: {remedy}")]
    StepUnfit {
        /// The processing step.
        step: &'static str,
        /// What is wrong.
        problem: String,
        /// What to do.
        remedy: &'static str,
    },
    /// A processing step that is not written as it should be.
    #[error("process \"{text}\": {problems}")]
    ProcessText {
        /// What was given.
        text: String,
        /// Each mistake with its key and what to do, on lines of their own.
        problems: String,
    },
    /// A record that could not be brought to a design spectrum.
    #[error("match: component {component} does not reach the spectrum: PSA is {ratio:.3} of the target at T = {period:.4} s after {iterations} iterations; expected {low:.3} to {high:.3}
  help: take a seed whose spectrum is nearer to the target or a longer one, raise iterations, narrow periods, or widen tolerance")]
    NotMatched {
        /// Name of the component.
        component: &'static str,
        /// Ratio to the target where it is worst, in the best iteration.
        ratio: f64,
        /// Period of that ratio, s.
        period: f64,
        /// Smallest ratio allowed.
        low: f64,
        /// Largest ratio allowed.
        high: f64,
        /// Iterations made.
        iterations: usize,
    },
    /// A step of a scene's `motion.process` that was refused when it met the motion.
    #[error("{place}: {source}")]
    InProcess {
        /// File, line and key, as [`Source::place_of`](crate::scene::Source::place_of) gives them.
        place: String,
        /// Why.
        source: Box<InputError>,
    },
    /// A number of a processing step that cannot be used.
    #[error("{step}: {parameter} = {}; expected {expected}\n  help: {remedy}", nine(*found))]
    StepParameter {
        /// The processing step.
        step: &'static str,
        /// Its parameter.
        parameter: &'static str,
        /// The value given.
        found: f64,
        /// What would do.
        expected: String,
        /// What to do.
        remedy: String,
    },
}

mod words;

#[cfg(test)]
mod tests;
