//! `motion.process`: an ordered list of steps, each with its own keys.

use crate::measures::DesignSpectrum;
use crate::motion::{
    FILTER_ORDER, FILTER_ORDER_TO, Filter, Matching, Process, SCALING_DAMPING, Scaling, TREND_ORDER_TO,
};

use super::super::diagnostic::{listed, plain};
use super::super::document::{Node, Table, Value};
use super::super::types::default_process;
use super::reader::{Bounds, Checker, Place, Section};

/// The list of a scene; the default one where the key is missing.
pub(super) fn list(cx: &mut Checker<'_>, motion: &mut Section<'_>) -> Option<Vec<Process>> {
    let Some(node) = motion.get("process") else {
        return Some(default_process());
    };
    let place = motion.at("process");
    let Value::List(nodes) = &node.value else {
        let help = "write it as process = [{ step = \"demean\" }, { step = \"filter\", f_min = 0.1 }]";
        cx.wrong_type(place, &node.value, "a list of steps", help);
        return None;
    };
    let steps: Vec<Option<Process>> = nodes
        .iter()
        .enumerate()
        .map(|(i, node)| {
            let place = Place { path: format!("{}[{}]", place.path, i + 1), at: node.at };
            let Value::Table(table) = &node.value else {
                let help = "write a step as { step = \"demean\" }, with its keys behind";
                cx.wrong_type(place, &node.value, "a table with a step", help);
                return None;
            };
            step(cx, table, place)
        })
        .collect();
    steps.into_iter().collect()
}

/// One step; every key of it is looked at, so that one mistake hides no other, and each is told with what to do.
pub(in super::super) fn step(cx: &mut Checker<'_>, table: &Table, place: Place) -> Option<Process> {
    let in_scene = !place.path.is_empty();
    let before = cx.found.len();
    let process = read(cx, table, place);
    let word = match table.get("step").map(|node| &node.value) {
        Some(Value::String(word)) => word.as_str(),
        _ => "",
    };
    for found in cx.found[before..].iter_mut().filter(|found| found.help.is_none()) {
        found.help = Some(example(word, in_scene));
    }
    process
}

/// A step as it can be written, in a scene or on a command line.
fn example(word: &str, in_scene: bool) -> String {
    let keys: &[&str] = match word {
        "demean" => &["first_seconds = 5.0"],
        "detrend" | "baseline" => &["order = 1"],
        "taper" => &["start = 1.0", "end = 2.0"],
        "rotate" => &["angle = 30.0"],
        "trim" => &["from = 5.0", "to = 40.0"],
        "pad" => &["before = 5.0", "after = 10.0"],
        "resample" => &["dt = 0.005"],
        "scale" => &["pga = 2.0"],
        "match" if in_scene => &["spectrum = { kind = \"rg160\", pga = 2.0, damping = 0.05 }"],
        "match" => &["spectrum.kind = rg160", "spectrum.pga = 2.0", "spectrum.damping = 0.05"],
        "rest" => &[],
        "convert" if in_scene => &["to = \"acceleration\""],
        "convert" => &["to = acceleration"],
        _ => &["f_min = 0.1", "f_max = 25.0"],
    };
    let word = if Process::WORDS.contains(&word) { word } else { "filter" };
    let parts: Vec<String> = match in_scene {
        true => keys.iter().map(|key| format!(", {key}")).collect(),
        false => keys.iter().map(|key| format!(" {}", key.replace(' ', ""))).collect(),
    };
    match in_scene {
        true => format!("for instance {{ step = \"{word}\"{} }}", parts.concat()),
        false => format!("for instance {word}{}", parts.concat()),
    }
}

fn read(cx: &mut Checker<'_>, table: &Table, place: Place) -> Option<Process> {
    let mut section = Section::new(table, place);
    let s = &mut section;
    let Some(node) = s.get("step") else {
        let help = format!("give `step` as {}", listed(&Process::WORDS, "\""));
        cx.error(s.place.clone(), "the step's name is missing", &help);
        return None;
    };
    let place = s.at("step");
    let word = match &node.value {
        Value::String(word) => Process::WORDS.into_iter().find(|known| known == word).or_else(|| {
            cx.unknown_word(place, word, &Process::WORDS, "");
            None
        }),
        other => {
            cx.wrong_type(place, other, "the name of a step in quotes", "");
            None
        }
    }?;
    let process = keys(cx, s, word);
    cx.finish(s);
    process
}

fn keys(cx: &mut Checker<'_>, s: &mut Section<'_>, word: &str) -> Option<Process> {
    let seconds = Bounds::at_least(0.0, "s");
    let order = |cx: &mut Checker<'_>, s: &mut Section<'_>| {
        if !s.has("order") {
            cx.missing(s, "order", &format!("give `order`, a whole number from 1 to {TREND_ORDER_TO}"));
        }
        let node = s.get("order")?;
        cx.whole_of(node, s.at("order"), 1, TREND_ORDER_TO)
    };
    let or_zero = |cx: &mut Checker<'_>, s: &mut Section<'_>, key| {
        cx.optional(s, key, &seconds).map(Option::unwrap_or_default)
    };
    match word {
        "demean" => {
            let first_seconds = cx.optional(s, "first_seconds", &Bounds::positive("s"))?;
            Some(Process::Demean { first_seconds })
        }
        "detrend" => order(cx, s).map(|order| Process::Detrend { order }),
        "baseline" => order(cx, s).map(|order| Process::Baseline { order }),
        "taper" => {
            let (start, end) = (or_zero(cx, s, "start"), or_zero(cx, s, "end"));
            given(cx, s, ["start", "end"])?;
            Some(Process::Taper { start: start?, end: end? })
        }
        "filter" => filter(cx, s).map(Process::Filter),
        "rotate" => {
            let angle = cx.required_number(s, "angle", &Bounds::any("degrees"))?;
            Some(Process::Rotate { angle })
        }
        "trim" => {
            let from = or_zero(cx, s, "from");
            let to = cx.optional(s, "to", &Bounds::positive("s"));
            given(cx, s, ["from", "to"])?;
            let (from, to) = (from?, to?);
            in_order(cx, s, ("from", Some(from)), ("to", to), "s")?;
            Some(Process::Trim { from, to })
        }
        "pad" => {
            let (before, after) = (or_zero(cx, s, "before"), or_zero(cx, s, "after"));
            given(cx, s, ["before", "after"])?;
            Some(Process::Pad { before: before?, after: after? })
        }
        "resample" => {
            let dt = cx.required_number(s, "dt", &Bounds::positive("s"))?;
            Some(Process::Resample { dt })
        }
        "scale" => scale(cx, s).map(Process::Scale),
        "match" => matching(cx, s).map(Process::Match),
        "rest" => Some(Process::Rest {}),
        "convert" => cx.required_word(s, "to").map(|to| Process::Convert { to }),
        _ => None,
    }
}

/// Asks for one of two keys at least.
fn given(cx: &mut Checker<'_>, s: &Section<'_>, keys: [&str; 2]) -> Option<()> {
    if keys.iter().any(|key| s.has(key)) {
        return Some(());
    }
    let [a, b] = keys;
    cx.error(s.place.clone(), format!("expected `{a}`, `{b}` or both"), "");
    None
}

/// Asks for a first value below the second, where both are there.
fn in_order(
    cx: &mut Checker<'_>,
    s: &Section<'_>,
    low: (&str, Option<f64>),
    high: (&str, Option<f64>),
    unit: &str,
) -> Option<()> {
    let (Some(a), Some(b)) = (low.1, high.1) else { return Some(()) };
    if a < b {
        return Some(());
    }
    let later = s.later(low.0, high.0);
    let message = if later == low.0 {
        format!("{} {unit} is not below {} = {} {unit}", plain(a), high.0, plain(b))
    } else {
        format!("{} {unit} is not above {} = {} {unit}", plain(b), low.0, plain(a))
    };
    cx.error(s.at(later), message, "");
    None
}

fn filter(cx: &mut Checker<'_>, s: &mut Section<'_>) -> Option<Filter> {
    let corner = Bounds::positive("Hz");
    let (f_min, f_max) = (cx.optional(s, "f_min", &corner), cx.optional(s, "f_max", &corner));
    let order = match s.get("order") {
        None => Some(FILTER_ORDER),
        Some(node) => cx.whole_of(node, s.at("order"), 1, FILTER_ORDER_TO),
    };
    let (causal, keep_pads) = (cx.flag(s, "causal"), cx.flag(s, "keep_pads"));
    given(cx, s, ["f_min", "f_max"])?;
    let (f_min, f_max) = (f_min?, f_max?);
    in_order(cx, s, ("f_min", f_min), ("f_max", f_max), "Hz")?;
    Some(Filter { f_min, f_max, order: order?, causal: causal?, keep_pads: keep_pads? })
}

fn scale(cx: &mut Checker<'_>, s: &mut Section<'_>) -> Option<Scaling> {
    const WAYS: [&str; 4] = ["factor", "pga", "pgv", "sa"];
    let factor = cx.optional(s, "factor", &Bounds::any(""));
    let pga = cx.optional(s, "pga", &Bounds::positive("m/s²"));
    let pgv = cx.optional(s, "pgv", &Bounds::positive("m/s"));
    let sa = cx.optional(s, "sa", &Bounds::positive("m/s²"));
    let period = cx.optional(s, "period", &Bounds::positive("s"));
    let unit_interval = Bounds { below: Some(1.0), ..Bounds::at_least(0.0, "") };
    let damping = cx.optional(s, "damping", &unit_interval);
    let ways: Vec<&str> = WAYS.into_iter().filter(|way| s.has(way)).collect();
    match ways[..] {
        [] => {
            cx.error(s.place.clone(), format!("expected {} in the step", listed(&WAYS, "`")), "");
            return None;
        }
        [_] => {}
        _ => {
            let last = ways.iter().copied().reduce(|a, b| s.later(a, b)).unwrap_or_default();
            let others: Vec<&str> = ways.iter().copied().filter(|way| *way != last).collect();
            let others = listed(&others, "`").replace(" or ", " and ");
            let message = format!("{others} given too; give one of {}", listed(&WAYS, "`"));
            cx.error(s.at(last), message, "");
            return None;
        }
    }
    if !s.has("sa") {
        let alone: Vec<&str> = ["period", "damping"].into_iter().filter(|key| s.has(key)).collect();
        for key in &alone {
            cx.error(s.at(key), "belongs to `sa`", "take it out");
        }
        if !alone.is_empty() {
            return None;
        }
    } else if !s.has("period") {
        cx.missing(s, "period", "give the oscillator's natural period in s, with `sa`");
        return None;
    }
    let (factor, pga, pgv, sa, period, damping) = (factor?, pga?, pgv?, sa?, period?, damping?);
    if factor == Some(0.0) {
        let help = "leave the component out instead";
        cx.error(s.at("factor"), "the factor is 0, which leaves no motion", help);
        return None;
    }
    for (key, value) in [("pga", pga), ("sa", sa)] {
        if let Some(value) = value
            && value > 50.0
        {
            let message = format!("{} m/s² is more than five times gravity", plain(value));
            cx.warn(s.at(key), message, &format!("{key} is in m/s²"));
        }
    }
    let sa = sa.zip(period).map(|(sa, period)| Scaling::Sa {
        sa,
        period,
        damping: damping.unwrap_or(SCALING_DAMPING),
    });
    factor.map(Scaling::Factor).or(pga.map(Scaling::Pga)).or(pgv.map(Scaling::Pgv)).or(sa)
}

fn matching(cx: &mut Checker<'_>, s: &mut Section<'_>) -> Option<Matching> {
    if !s.has("spectrum") {
        let help = "give `spectrum`, for instance { kind = \"rg160\", pga = 1.0, damping = 0.05 }";
        cx.missing(s, "spectrum", help);
    }
    let spectrum = s.get("spectrum").map(|node| (node, s.at("spectrum")));
    let spectrum = spectrum.and_then(|(node, place)| design_spectrum(cx, node, place));
    let periods = s.get("periods").map(|node| (node, s.at("periods")));
    let periods =
        periods.map(|(node, place)| cx.numbers::<2>(node, place, &Bounds::between(0.01, 20.0, "s")));
    let tolerance = cx.optional(s, "tolerance", &Bounds { below: Some(1.0), ..Bounds::at_least(0.02, "") });
    let iterations = s.get("iterations").map(|node| (node, s.at("iterations")));
    let iterations = iterations.map(|(node, place)| cx.whole_of(node, place, 1, 10_000));
    let mut matching = Matching::to(spectrum?);
    if let Some(periods) = periods {
        matching.periods = periods?;
        let [shortest, longest] = matching.periods;
        if shortest >= longest {
            let message = format!("{} s is not below {} s", plain(shortest), plain(longest));
            cx.error(s.at("periods"), message, "write the shorter period first");
            return None;
        }
    }
    if let Some(iterations) = iterations {
        matching.iterations = iterations?;
    }
    if let Some(tolerance) = tolerance? {
        matching.tolerance = tolerance;
    }
    Some(matching)
}

fn design_spectrum(cx: &mut Checker<'_>, node: &Node, place: Place) -> Option<DesignSpectrum> {
    const KINDS: [&str; 3] = ["rg160", "eurocode8", "points"];
    let Value::Table(table) = &node.value else {
        cx.wrong_type(place, &node.value, "a table { kind = \"rg160\", … }", "");
        return None;
    };
    let mut section = Section::new(table, place.clone());
    match section.get("kind").map(|kind| &kind.value) {
        Some(Value::String(kind)) if !KINDS.contains(&kind.as_str()) => {
            cx.unknown_word(section.at("kind"), kind, &KINDS, "");
            return None;
        }
        Some(Value::String(_)) => {}
        Some(other) => {
            cx.wrong_type(section.at("kind"), other, &listed(&KINDS, "\""), "");
            return None;
        }
        None => {
            cx.missing(&mut section, "kind", &format!("give `kind` as {}", listed(&KINDS, "\"")));
            cx.finish(&section);
            return None;
        }
    }
    let before = cx.found.len();
    spectrum_keys(cx, &mut section);
    if cx.found.len() > before {
        return None;
    }
    // The codes' tables and their limits belong to the spectrum itself.
    let read = serde_json::from_value::<DesignSpectrum>(node.value.to_json())
        .map_err(|problem| problem.to_string())
        .and_then(|spectrum| match spectrum.check() {
            Ok(()) => Ok(spectrum),
            Err(problem) => Err(problem.to_string()),
        });
    match read {
        Ok(spectrum) => Some(spectrum),
        Err(problem) => {
            let (problem, help) = problem.split_once("\n  help: ").unwrap_or((&problem, ""));
            cx.error(place, problem, help);
            None
        }
    }
}

/// The keys of a spectrum's kind: those that are missing, unknown ones, and numbers that cannot be.
fn spectrum_keys(cx: &mut Checker<'_>, section: &mut Section<'_>) {
    let acceleration = Bounds::positive("m/s²");
    let damping = Bounds { below: Some(1.0), ..Bounds::positive("") };
    let kind = match section.get("kind").map(|kind| &kind.value) {
        Some(Value::String(kind)) => kind.as_str(),
        _ => "",
    };
    let required: &[(&'static str, &str)] = match kind {
        "rg160" => &[("pga", "give the peak horizontal ground acceleration in m/s², for instance pga = 2.0")],
        "eurocode8" => &[
            ("ag", "give the design ground acceleration in m/s², for instance ag = 1.5"),
            ("type", "give the spectrum's type, 1 or 2"),
            ("ground", "give the ground type, \"A\" to \"E\""),
        ],
        _ => &[
            ("periods", "give the periods in s, for instance periods = [0.1, 0.5, 2.0]"),
            ("psa", "give a pseudo-acceleration in m/s² for each period, for instance psa = [3.0, 2.5, 0.6]"),
        ],
    };
    for (key, help) in required {
        if section.get(key).is_none() {
            cx.missing(section, key, help);
        }
    }
    for key in ["pga", "ag"].into_iter().filter(|key| required.iter().any(|(known, _)| known == key)) {
        cx.number(section, key, &acceleration);
    }
    cx.number(section, "damping", &damping);
    if kind != "points" {
        section.get("direction");
    }
    cx.finish(section);
}
