//! `[[source]]` and `[run]`: what acts on a domain, and how long.

use super::super::diagnostic::{listed, plain, rounded};
use super::super::document::{Node, Value};
use super::super::pulse::{Pulse, PulseKind, one};
use super::super::volume::{DURATION_TO, ENTRIES_TO, Run, SourceEntry, SourceKind};
use super::domain::{self, coordinates};
use super::motion::file_name;
use super::reader::{Bounds, Checker, Entries, Place, Section};

/// What the sources are checked against.
pub(super) struct Around<'a> {
    pub(super) domain: &'a domain::Read,
    /// Length of the run, s.
    pub(super) duration: Option<f64>,
    /// Highest frequency that the sizes are chosen for, where the scene gives it, Hz.
    pub(super) f_max: Option<f64>,
}

/// `[run]`; the inner `None` is a column's.
pub(super) fn run(cx: &mut Checker<'_>, top: &mut Section<'_>, column: bool) -> Option<Option<Run>> {
    let given = top.get("run").is_some();
    if column {
        let help = "a column runs for its motion's length and [discretisation].tail";
        cx.misplaced(top, &["run"], "belongs to a scene with [domain]", help);
        return (!given).then_some(None);
    }
    if !given {
        cx.missing(top, "run", "write [run] with duration, the time to simulate in seconds");
        return None;
    }
    let mut section = cx.table(top, "run")?;
    let bounds = Bounds { to: Some(DURATION_TO), ..Bounds::positive("s") };
    let duration = cx.required_number(&mut section, "duration", &bounds);
    cx.finish(&section);
    Some(Some(Run { duration: duration? }))
}

pub(super) fn read(
    cx: &mut Checker<'_>,
    top: &mut Section<'_>,
    around: &Around<'_>,
) -> Option<Vec<SourceEntry>> {
    let given = top.get("source").is_some();
    if around.domain.column() {
        let help = "give [domain], or drive the column by [motion]";
        cx.misplaced(top, &["source"], "belongs to a scene with [domain]", help);
        return (!given).then(Vec::new);
    }
    let what = Entries {
        one: "source",
        header: "[[source]]",
        to: ENTRIES_TO,
        help: "write [[source]] with kind, its place, its size, and wavelet or file, for each source",
        fewer: "give a traction over a boundary in place of many forces",
    };
    let nodes = cx.entries(top, "source", &what)?;
    let all: Vec<Option<SourceEntry>> = (nodes.iter().enumerate())
        .map(|(i, node)| {
            let place = Place { path: format!("source[{}]", i + 1), at: node.at };
            let Value::Table(table) = &node.value else {
                cx.wrong_type(place, &node.value, "a table", "write [[source]] above its keys");
                return None;
            };
            source(cx, Section::new(table, place), around)
        })
        .collect();
    all.into_iter().collect()
}

fn source(cx: &mut Checker<'_>, mut section: Section<'_>, around: &Around<'_>) -> Option<SourceEntry> {
    let s = &mut section;
    let before = errors(cx);
    let name = cx.text(s, "name");
    let kind = cx.required_word::<SourceKind>(s, "kind");
    let mut entry = match kind {
        Some(SourceKind::Traction) => traction(cx, s, around),
        Some(kind) => point(cx, s, around, kind),
        None => {
            known(s);
            empty(SourceKind::Force)
        }
    };
    entry.name = name;
    time_function(cx, s, around, &mut entry);
    cx.finish(s);
    (kind.is_some() && errors(cx) == before).then_some(entry)
}

/// Number of errors so far.
fn errors(cx: &Checker<'_>) -> usize {
    cx.found.iter().filter(|d| d.severity == super::super::diagnostic::Severity::Error).count()
}

fn empty(kind: SourceKind) -> SourceEntry {
    SourceEntry {
        name: None,
        kind,
        position: None,
        depth: None,
        force: None,
        moment: None,
        rate: false,
        traction: None,
        boundary: None,
        centre: None,
        sigma: None,
        wavelet: None,
        file: None,
        channel: None,
        dt: None,
        amplitude: None,
    }
}

/// Makes all keys of places and sizes known.
fn known(s: &mut Section<'_>) {
    for key in ["position", "depth", "force", "moment", "rate", "traction", "boundary", "centre", "sigma"] {
        s.get(key);
    }
}

/// A force or a moment at a point.
fn point(cx: &mut Checker<'_>, s: &mut Section<'_>, around: &Around<'_>, kind: SourceKind) -> SourceEntry {
    let mut entry = empty(kind);
    if let Some((position, depth)) = around.domain.place(cx, s, "position") {
        (entry.position, entry.depth) = (Some(position), depth);
    }
    let other = if kind == SourceKind::Force {
        entry.force = vector(cx, s, "force", "force = [fx, fy, fz] in N", "N");
        "moment"
    } else {
        let help = "moment = [mxx, myy, mzz, mxy, mxz, myz] in N·m";
        entry.moment = vector(cx, s, "moment", help, "N·m");
        if let (Some(moment), Some(2)) = (entry.moment, around.domain.dimension)
            && moment[1] != 0.0
        {
            let message = format!("myy = {} acts on nothing at dimension 2", plain(moment[1]));
            cx.error(s.at("moment"), message, "nothing varies along y there: write 0 as the second number");
        }
        entry.rate = cx.flag(s, "rate").unwrap_or_default();
        "force"
    };
    known(s);
    let message = format!("a {} has no such key", kind.as_str());
    let keys = [other, "traction", "boundary", "centre", "sigma"];
    cx.misplaced(s, &keys, &message, "take it out, or correct `kind`");
    if kind == SourceKind::Force {
        cx.misplaced(s, &["rate"], &message, "take it out, or correct `kind`");
    }
    entry
}

/// A traction, uniform or around a centre.
fn traction(cx: &mut Checker<'_>, s: &mut Section<'_>, around: &Around<'_>) -> SourceEntry {
    let mut entry = empty(SourceKind::Traction);
    entry.boundary = cx.text(s, "boundary");
    if let Some(name) = &entry.boundary {
        around.domain.boundary(cx, s.at("boundary"), name);
    }
    known(s);
    let keys = ["position", "depth", "moment", "rate"];
    cx.misplaced(s, &keys, "a traction has no such key", "take it out, or correct `kind`");
    let patch = ["centre", "sigma", "force"].into_iter().any(|key| s.has(key));
    if s.has("traction") || !patch {
        let help = "traction = [tx, ty, tz] in Pa, or `centre`, `sigma` and `force` for one around a point";
        entry.traction = vector(cx, s, "traction", help, "Pa");
        let message = "`traction` is given too, for the whole boundary";
        cx.misplaced(s, &["centre", "sigma", "force"], message, "give `traction` or these");
        return entry;
    }
    entry.force = vector(cx, s, "force", "force = [fx, fy, fz] in N, the sum of the traction", "N");
    entry.sigma = cx.required_number(s, "sigma", &Bounds::positive("m"));
    entry.centre = match s.get("centre") {
        None => {
            cx.missing(s, "centre", "give `centre`, where the traction is largest");
            None
        }
        Some(node) => coordinates(cx, node, s.at("centre")),
    };
    if let (Some(centre), Some(dimension)) = (&entry.centre, around.domain.dimension)
        && !(dimension - 1..=dimension).contains(&centre.len())
    {
        let form = if dimension == 2 { "[x, z] or [x]" } else { "[x, y, z] or [x, y]" };
        let message = format!("expected {form} at dimension {dimension}, found {} numbers", centre.len());
        cx.error(s.at("centre"), message, "");
    }
    entry
}

/// A vector or tensor that has to be there and is not zero.
fn vector<const N: usize>(
    cx: &mut Checker<'_>,
    s: &mut Section<'_>,
    key: &'static str,
    help: &str,
    unit: &'static str,
) -> Option<[f64; N]> {
    let Some(node) = s.get(key) else {
        cx.missing(s, key, &format!("give {help}"));
        return None;
    };
    let numbers = cx.numbers::<N>(node, s.at(key), &Bounds::any(unit))?;
    if numbers == [0.0; N] {
        cx.error(
            s.at(key),
            format!("the {key} is 0: nothing would act"),
            "take the source out, or give its size",
        );
        return None;
    }
    Some(numbers)
}

/// `wavelet` or `file`, and what belongs to a file.
fn time_function(cx: &mut Checker<'_>, s: &mut Section<'_>, around: &Around<'_>, entry: &mut SourceEntry) {
    let (wavelet, file) = (s.get("wavelet"), s.get("file"));
    entry.channel = cx.text(s, "channel");
    entry.dt = cx.number(s, "dt", &Bounds::positive("s"));
    entry.amplitude = cx.number(s, "amplitude", &Bounds::any(""));
    if entry.amplitude == Some(0.0) {
        cx.error(s.at("amplitude"), "the amplitude is 0: nothing would act", "take the source out");
    }
    let one = cx.only_one(s, "file", "wavelet", "a time function is either a record or a closed form");
    match (file, wavelet) {
        (None, None) => {
            cx.missing(
                s,
                "wavelet",
                "give the time function: `wavelet` with a pulse, or `file` with a record",
            );
        }
        (Some(node), None) => entry.file = file_name(cx, node, s.at("file")),
        (None, Some(node)) => {
            let help = "take it out; a wavelet has an amplitude of its own";
            cx.misplaced(s, &["channel", "dt", "amplitude"], "belongs to a file", help);
            entry.wavelet = pulse(cx, node, s.at("wavelet"), around);
        }
        // said by `only_one`
        _ => debug_assert!(!one),
    }
}

fn pulse(cx: &mut Checker<'_>, node: &Node, place: Place, around: &Around<'_>) -> Option<Pulse> {
    let Value::Table(table) = &node.value else {
        cx.wrong_type(place, &node.value, "a table { kind = …, frequency = …, time = … }", "");
        return None;
    };
    let before = cx.found.len();
    let mut section = Section::new(table, place);
    let s = &mut section;
    let kind = cx.required_word::<PulseKind>(s, "kind");
    let frequency = cx.required_number(s, "frequency", &Bounds::positive("Hz"));
    let time = cx.required_number(s, "time", &Bounds::at_least(0.0, "s"));
    let amplitude = cx.optional(s, "amplitude", &Bounds::any(""));
    let cycles = cx.number(s, "cycles", &Bounds::positive(""));
    cycles_of(cx, s, kind.map(|k| (k == PulseKind::SineBurst, k.as_str())));
    if amplitude == Some(Some(0.0)) {
        cx.error(s.at("amplitude"), "the amplitude is 0: nothing would act", "take the source out");
    }
    for key in ["dt", "duration"] {
        if s.get(key).is_some() {
            let help = "take it out; [run] has the duration, and the run its own step";
            cx.error(s.at(key), "a source's pulse is not sampled", help);
        }
    }
    cx.finish(s);
    if cx.found.len() > before {
        return None;
    }
    let amplitude = amplitude?.unwrap_or_else(one);
    let pulse = Pulse { kind: kind?, frequency: frequency?, amplitude, time: time?, cycles };
    in_time(cx, s, &pulse, around);
    Some(pulse)
}

/// `cycles` belongs to a burst and to nothing else; `kind`: whether it is one, and its word.
pub(super) fn cycles_of(cx: &mut Checker<'_>, s: &mut Section<'_>, kind: Option<(bool, &str)>) {
    match kind {
        Some((true, _)) if !s.has("cycles") => {
            cx.missing(s, "cycles", "a sine_burst needs its number of periods, for instance cycles = 5");
        }
        Some((false, word)) if s.has("cycles") => {
            cx.error(s.at("cycles"), format!("a {word} pulse has no cycles"), "take it out");
        }
        _ => {}
    }
}

/// The pulse against the run's time and frequencies.
fn in_time(cx: &mut Checker<'_>, s: &Section<'_>, pulse: &Pulse, around: &Around<'_>) {
    if let Some(f_max) = around.f_max.filter(|f| *f < pulse.frequency) {
        let message = format!(
            "{} Hz is above discretisation.f_max = {} Hz, for which the elements are made",
            plain(pulse.frequency),
            plain(f_max)
        );
        cx.error(s.at("frequency"), message, "raise f_max, or leave it to \"auto\"");
    }
    let half = pulse.half_width();
    let Some(duration) = around.duration else { return };
    if pulse.time > duration {
        let message = format!(
            "the pulse at {} s comes after the run's end at {} s",
            plain(pulse.time),
            plain(duration)
        );
        cx.error(s.at("time"), message, "");
    } else if pulse.time < half {
        let message = format!(
            "the run cuts the pulse, which begins at {} s, and starts with a jump",
            rounded(pulse.time - half)
        );
        cx.warn(s.at("time"), message, &format!("time = {} s or later", rounded(half)));
    }
}

impl domain::Read {
    /// Reports the name of a boundary that a box does not have.
    pub(super) fn boundary(&self, cx: &mut Checker<'_>, place: Place, name: &str) {
        let (false, Some(dimension)) = (self.mesh, self.dimension) else { return };
        let known = super::super::volume::Domain::box_boundaries(dimension);
        if !known.contains(&name) {
            cx.error(place, format!("expected {}, found {name:?}", listed(known, "\"")), "");
        }
    }
}
