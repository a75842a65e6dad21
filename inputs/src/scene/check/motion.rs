//! `[motion]`: where it was recorded, its components, its processing.

use crate::motion::{Process, Quantity, Scaling};
use crate::records::{ResponseMode, Unit};

use super::super::diagnostic::{plain, rounded};
use super::super::document::{Node, Value};
use super::super::files;
use super::super::types::{Band, Component, Motion, MotionKind, RecordFile, Synthetic, default_quantity};
use super::super::wavelet::{Wavelet, WaveletKind};
use super::process;
use super::process_fit::{self, Known};
use super::reader::{Bounds, Checker, Place, Section};
use super::source::cycles_of;

/// Most samples of a wavelet: a day at 100 Hz.
pub(super) const MAX_SAMPLES: f64 = 1e7;

/// The section, and what other sections are checked against.
#[derive(Default)]
pub(super) struct Read {
    pub(super) motion: Option<Motion>,
    pub(super) kind: Option<(MotionKind, Place)>,
    /// Components x, y, z that are written, rightly or wrongly.
    pub(super) given: [bool; 3],
    /// Step and length of the synthetic motions, s.
    pub(super) synthetic: Option<(f64, f64)>,
}

/// A component that could be read, with its place.
type Placed = Option<(Component, Place)>;

pub(super) fn read(cx: &mut Checker<'_>, top: &mut Section<'_>) -> Read {
    if top.get("motion").is_none() {
        cx.missing(top, "motion", "write a section [motion] with kind and a component [motion.x]");
        return Read::default();
    }
    let Some(mut section) = cx.table(top, "motion") else {
        return Read::default();
    };
    let s = &mut section;
    let kind = cx.required_word::<MotionKind>(s, "kind");
    let quantity = match s.get("quantity") {
        None => Some(default_quantity()),
        Some(_) => cx.word::<Quantity>(s, "quantity"),
    };
    let band = match s.get("band") {
        None => Some(Band::default()),
        Some(node) => band(cx, node, s.at("band")),
    };
    let process = process::list(cx, s);
    let accept_clipped = cx.flag(s, "accept_clipped");
    former_keys(cx, s);
    let given = ["x", "y", "z"].map(|axis| s.get(axis).is_some());
    if given == [false; 3] {
        cx.missing(
            s,
            "x",
            "give at least one component: [motion.x], [motion.y] or [motion.z] with file or wavelet",
        );
    }
    let [x, y, z] = ["x", "y", "z"].map(|axis| component(cx, s, axis, quantity));
    same_time_axis(cx, [&x, &y, &z]);
    if let Some(process) = &process {
        steps_without_record(cx, s, process, [&x, &y, &z]);
        let components = [&x, &y, &z].map(|placed| placed.as_ref().map(|(component, _)| component));
        process_fit::check(cx, s, process, &Known::new(quantity, given, components));
    }
    if let Some(band) = band {
        band_of_wavelets(cx, band, [&x, &y, &z], s.at("band"));
    }
    cx.finish(s);
    let synthetic = [&x, &y, &z].into_iter().flatten().find_map(|(component, _)| match component {
        Component::Synthetic(Synthetic { wavelet }) => Some((wavelet.dt, wavelet.duration)),
        Component::Record(_) => None,
    });
    let complete = [&x, &y, &z].iter().zip(given).all(|(c, given)| c.is_some() == given);
    let place = s.at("kind");
    let motion = match (kind, quantity, band, process, accept_clipped) {
        (Some(kind), Some(quantity), Some(band), Some(process), Some(accept_clipped)) if complete => {
            Some(Motion {
                kind,
                quantity,
                band,
                process,
                accept_clipped,
                x: x.map(|c| c.0),
                y: y.map(|c| c.0),
                z: z.map(|c| c.0),
            })
        }
        _ => None,
    };
    Read { motion, kind: kind.map(|k| (k, place)), given, synthetic }
}

/// The keys `offset` and `scale` of earlier versions, with what to write in their place.
fn former_keys(cx: &mut Checker<'_>, s: &mut Section<'_>) {
    let number = |node: &Node, key: &str| {
        let Value::Table(table) = &node.value else { return None };
        match table.get(key)?.value {
            Value::Integer(i) => Some(i as f64),
            Value::Float(x) => Some(x),
            _ => None,
        }
    };
    let former = [s.get("offset"), s.get("scale")];
    let mut steps: Vec<String> = vec![];
    match former[0] {
        Some(Node { value: Value::String(word), .. }) if word == "none" => {}
        offset => {
            let first_seconds = offset.and_then(|node| number(node, "first_seconds"));
            steps.push(Process::Demean { first_seconds }.to_toml());
        }
    }
    let scaling = former[1].and_then(|node| {
        let factor = number(node, "factor").map(Scaling::Factor);
        factor.or(number(node, "pga").map(Scaling::Pga))
    });
    match scaling {
        Some(scaling) => steps.push(Process::Scale(scaling).to_toml()),
        None if former[1].is_some() => steps.push("{ step = \"scale\", … }".to_owned()),
        None => {}
    }
    let help = format!("write process = [{}]", steps.join(", "));
    for key in ["offset", "scale"].into_iter().filter(|key| s.has(key)).collect::<Vec<_>>() {
        cx.error(s.at(key), "is a step of `process` now", &help);
    }
}

/// Warns of steps for records in a scene without one.
fn steps_without_record(
    cx: &mut Checker<'_>,
    s: &Section<'_>,
    process: &[Process],
    components: [&Placed; 3],
) {
    let record = |c: &&Placed| matches!(c, Some((Component::Record(_), _)));
    if !s.has("process") || components.iter().any(record) || components.iter().all(|c| c.is_none()) {
        return;
    }
    for (i, step) in process.iter().enumerate().filter(|(_, step)| step.mends_an_instrument()) {
        let message = format!("`{}` acts on records, and this motion has wavelets only", step.word());
        cx.warn(s.in_list("process", i + 1, ""), message, "take it out");
    }
}

fn band(cx: &mut Checker<'_>, node: &Node, place: Place) -> Option<Band> {
    const OR: &str = "two frequencies [f_min, f_max] in Hz";
    match &node.value {
        Value::String(s) if s == "auto" => Some(Band::Auto),
        Value::String(s) if s == "full" => Some(Band::Full),
        Value::String(s) => {
            cx.unknown_word(place, s, &["auto", "full"], OR);
            None
        }
        Value::List(list) => {
            let mut f = list.iter().enumerate().map(|(i, n)| {
                let place = Place { path: format!("{}[{}]", place.path, i + 1), at: n.at };
                cx.number_of(n, place, &Bounds::positive("Hz"))
            });
            let ends = (f.next(), f.next(), f.count());
            match ends {
                (Some(Some(low)), Some(Some(high)), 0) if low < high => Some(Band::Range([low, high])),
                (Some(Some(low)), Some(Some(high)), 0) => {
                    let message =
                        format!("f_min = {} Hz is not below f_max = {} Hz", plain(low), plain(high));
                    cx.error(place, message, "write the lower frequency first");
                    None
                }
                (Some(_), Some(_), 0) => None,
                _ => {
                    cx.error(place, format!("expected {OR}, found a list of {}", list.len()), "");
                    None
                }
            }
        }
        other => {
            cx.wrong_type(place, other, &format!("\"auto\", \"full\" or {OR}"), "");
            None
        }
    }
}

fn component(
    cx: &mut Checker<'_>,
    motion: &mut Section<'_>,
    axis: &'static str,
    quantity: Option<Quantity>,
) -> Placed {
    let mut section = cx.table(motion, axis)?;
    let s = &mut section;
    let file = s.get("file");
    let wavelet = s.get("wavelet");
    let record = record_keys(cx, s);
    let one = cx.only_one(s, "file", "wavelet", "a component is either a record or a synthetic pulse");
    if file.is_none() && wavelet.is_none() {
        cx.missing(s, "file", "give `file` with a record, or `wavelet` with a synthetic pulse");
    }
    if let (Some(unit), Some(quantity)) = (record.as_ref().and_then(|r| r.unit), quantity)
        && unit.quantity() != quantity
    {
        let message = format!("{unit} is a unit of {}, but motion.quantity is {quantity}", unit.quantity());
        let help = format!("set motion.quantity = \"{}\", or correct the unit", unit.quantity());
        cx.error(s.at("unit"), message, &help);
    }
    let place =
        Place { path: s.place.path.clone(), at: s.at(if wavelet.is_some() { "wavelet" } else { "file" }).at };
    let read = match (file, wavelet) {
        (Some(node), None) => file_name(cx, node, s.at("file"))
            .and_then(|file| Some(Component::Record(RecordFile { file, ..record? }))),
        (None, Some(node)) => {
            for key in ["unit", "channel", "dt", "metadata", "response", "pre_filter"] {
                if s.has(key) {
                    let message = "belongs to a file; a wavelet is in SI units and has no channels";
                    cx.error(s.at(key), message, "take it out");
                }
            }
            wavelet_of(cx, node, s.at("wavelet")).map(|wavelet| Component::Synthetic(Synthetic { wavelet }))
        }
        _ => None,
    };
    cx.finish(s);
    read.filter(|_| one).map(|c| (c, place))
}

/// What a component says about its file, without the file itself.
fn record_keys(cx: &mut Checker<'_>, s: &mut Section<'_>) -> Option<RecordFile> {
    // The outer `Option` is "could be read", the inner one the format's own.
    let unit = match s.get("unit") {
        None => Some(None),
        Some(_) => cx.word::<Unit>(s, "unit").map(Some),
    };
    let channel = match s.get("channel") {
        None => Some(None),
        Some(_) => cx.text(s, "channel").map(Some),
    };
    let dt = cx.optional(s, "dt", &Bounds::positive("s"));
    let metadata = match s.get("metadata") {
        None => Some(None),
        Some(node) => file_name(cx, node, s.at("metadata")).map(Some),
    };
    let response = match s.get("response") {
        None => Some(None),
        Some(_) => cx.word::<ResponseMode>(s, "response").map(Some),
    };
    let pre_filter = match s.get("pre_filter") {
        None => Some(None),
        Some(node) => pre_filter(cx, node, s.at("pre_filter")).map(Some),
    };
    let mut good = cx.only_one(s, "unit", "metadata", "with metadata the unit follows from the instrument");
    for key in ["response", "pre_filter"] {
        if s.has(key) && !s.has("metadata") && s.has("file") {
            cx.error(
                s.at(key),
                "needs `metadata`",
                "name the instrument's StationXML, RESP or pole-zero file",
            );
            good = false;
        }
    }
    if s.has("pre_filter") && response == Some(Some(ResponseMode::Sensitivity)) {
        let message = "has no use with response = \"sensitivity\", which divides by one number";
        cx.error(s.at("pre_filter"), message, "take it out, or write response = \"full\"");
        good = false;
    }
    let record = RecordFile {
        file: String::new(),
        unit: unit?,
        channel: channel?,
        dt: dt?,
        metadata: metadata?,
        response: response?,
        pre_filter: pre_filter?,
    };
    good.then_some(record)
}

fn pre_filter(cx: &mut Checker<'_>, node: &Node, place: Place) -> Option<[f64; 4]> {
    let corners = cx.numbers::<4>(node, place.clone(), &Bounds::at_least(0.0, "Hz"))?;
    if corners.is_sorted_by(|a, b| a < b) {
        return Some(corners);
    }
    let found: Vec<String> = corners.iter().map(|f| plain(*f)).collect();
    let message = format!("expected four rising frequencies, found {} Hz", found.join(", "));
    cx.error(
        place,
        message,
        "zero below the first, whole between the second and the third, zero above the fourth",
    );
    None
}

pub(super) fn file_name(cx: &mut Checker<'_>, node: &Node, place: Place) -> Option<String> {
    let file = cx.text_of(node, place.clone())?;
    match files::record(&cx.folder, file) {
        Ok(()) => Some(file.to_owned()),
        Err(problem) => {
            cx.error(place, problem.message, problem.help.as_deref().unwrap_or_default());
            None
        }
    }
}

fn wavelet_of(cx: &mut Checker<'_>, node: &Node, place: Place) -> Option<Wavelet> {
    let Value::Table(table) = &node.value else {
        cx.wrong_type(place, &node.value, "a table { kind = …, frequency = …, … }", "");
        return None;
    };
    let before = cx.found.len();
    let mut section = Section::new(table, place);
    let s = &mut section;
    let kind = cx.required_word::<WaveletKind>(s, "kind");
    let frequency = cx.required_number(s, "frequency", &Bounds::positive("Hz"));
    let amplitude = cx.required_number(s, "amplitude", &Bounds::any(""));
    let time = cx.required_number(s, "time", &Bounds::at_least(0.0, "s"));
    let dt = cx.required_number(s, "dt", &Bounds::positive("s"));
    let duration = cx.required_number(s, "duration", &Bounds::positive("s"));
    let cycles = cx.number(s, "cycles", &Bounds::positive(""));
    cycles_of(cx, s, kind.map(|k| (k == WaveletKind::SineBurst, k.as_str())));
    if amplitude == Some(0.0) {
        cx.error(
            s.at("amplitude"),
            "the amplitude is 0, which leaves no motion",
            "leave the component out instead",
        );
    }
    sampling(cx, s, frequency, dt, duration);
    if let (Some(time), Some(duration)) = (time, duration)
        && time > duration
    {
        let message =
            format!("the pulse at {} s comes after the motion's end at {} s", plain(time), plain(duration));
        cx.error(s.at("time"), message, "");
    }
    cx.finish(s);
    // Nothing more can be said about a pulse that is wrong in itself.
    if cx.found.len() > before {
        return None;
    }
    let wavelet = Wavelet {
        kind: kind?,
        frequency: frequency?,
        amplitude: amplitude?,
        time: time?,
        dt: dt?,
        duration: duration?,
        cycles,
    };
    shape(cx, s, &wavelet);
    Some(wavelet)
}

/// The step against the pulse's frequency and the motion's length.
fn sampling(
    cx: &mut Checker<'_>,
    s: &Section<'_>,
    frequency: Option<f64>,
    dt: Option<f64>,
    duration: Option<f64>,
) {
    let Some(dt) = dt else { return };
    if let Some(f) = frequency
        && f >= 0.4 / dt
    {
        let message = format!(
            "{} Hz is not below 0.4/dt = {} Hz (the Nyquist frequency is {} Hz)",
            plain(f),
            rounded(0.4 / dt),
            rounded(0.5 / dt)
        );
        cx.error(s.at("frequency"), message, "lower the frequency or dt");
    }
    let Some(duration) = duration else { return };
    if duration < dt {
        let message =
            format!("the motion of {} s is shorter than its step of {} s", plain(duration), plain(dt));
        cx.error(s.at("duration"), message, "");
    } else if duration / dt > MAX_SAMPLES {
        let message =
            format!("duration/dt = {} samples are too many (limit {MAX_SAMPLES:e})", rounded(duration / dt));
        cx.error(s.at("duration"), message, "raise dt or shorten the motion");
    }
}

/// Warnings about a pulse that its sampling or its time cuts.
fn shape(cx: &mut Checker<'_>, s: &Section<'_>, w: &Wavelet) {
    let reach = match w.kind {
        WaveletKind::Ricker => 3.0 * w.frequency,
        WaveletKind::Gaussian | WaveletKind::SineBurst => w.frequency,
    };
    if reach > 0.5 / w.dt {
        let message = format!(
            "the spectrum of a Ricker pulse of {} Hz reaches to {} Hz, above the Nyquist frequency {} Hz",
            plain(w.frequency),
            rounded(reach),
            rounded(0.5 / w.dt)
        );
        cx.warn(s.at("dt"), message, &format!("dt = {} s holds it", rounded(0.5 / reach)));
    }
    let half = w.pulse().half_width();
    if w.time < half || w.duration - w.time < half {
        let message = format!(
            "the motion cuts the pulse, which lasts from {} s to {} s",
            rounded(w.time - half),
            rounded(w.time + half)
        );
        let help = format!(
            "time = {} s or later, and duration at least {} s beyond it",
            rounded(half),
            rounded(half)
        );
        cx.warn(s.at("time"), message, &help);
    }
}

/// All wavelets of a scene have one time axis.
fn same_time_axis(cx: &mut Checker<'_>, components: [&Placed; 3]) {
    let mut first: Option<(&Wavelet, &Place)> = None;
    for (component, place) in components.into_iter().flatten() {
        let Component::Synthetic(Synthetic { wavelet }) = component else {
            continue;
        };
        let Some((other, other_place)) = first else {
            first = Some((wavelet, place));
            continue;
        };
        let pairs = [("dt", wavelet.dt, other.dt), ("duration", wavelet.duration, other.duration)];
        for (key, mine, theirs) in pairs.into_iter().filter(|p| p.1 != p.2) {
            let place = Place { path: format!("{}.wavelet.{key}", place.path), at: place.at };
            let message = format!(
                "{} s differs from {}.wavelet.{key} = {} s; the components share one time axis",
                plain(mine),
                other_place.path,
                plain(theirs)
            );
            cx.error(place, message, "give both the same value");
        }
    }
}

/// A band that a wavelet's sampling cannot hold.
fn band_of_wavelets(cx: &mut Checker<'_>, band: Band, components: [&Placed; 3], place: Place) {
    let Band::Range([_, f_max]) = band else { return };
    for (component, _) in components.into_iter().flatten() {
        let Component::Synthetic(Synthetic { wavelet }) = component else {
            continue;
        };
        let nyquist = 0.5 / wavelet.dt;
        if f_max > nyquist {
            let message = format!(
                "f_max = {} Hz is above the Nyquist frequency {} Hz of a wavelet with dt = {} s",
                plain(f_max),
                rounded(nyquist),
                plain(wavelet.dt)
            );
            cx.error(place, message, "lower f_max or the wavelet's dt");
            return;
        }
    }
}
