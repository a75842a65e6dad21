//! `[discretisation]`, and of `[output]` the stations and what a column writes.

use std::collections::HashMap;
use std::collections::hash_map::Entry;

use super::super::diagnostic::{plain, rounded};
use super::super::document::{Node, Value};
use super::super::types::{
    Auto, DT_FROM, Discretisation, ELEMENTS_TO, FIELD_INTERVALS_TO, FieldSpacing, Output, StationEntry,
    TAIL_TO,
};
use super::super::values::Words;
use super::super::volume::{MemoryVariables, POINTS_TO, Precision, SIZE_FROM};
use super::domain;
use super::domain::coordinates;
use super::motion::MAX_SAMPLES;
use super::reader::{Bounds, Checker, Place, Section};
use super::volume_output;

pub(super) fn discretisation(
    cx: &mut Checker<'_>,
    top: &mut Section<'_>,
    layer_count: Option<usize>,
    synthetic: Option<(f64, f64)>,
    domain: &domain::Read,
) -> Option<Discretisation> {
    if top.get("discretisation").is_none() {
        return Some(Discretisation::default());
    }
    let mut section = cx.table(top, "discretisation")?;
    let s = &mut section;
    let order = cx.auto_whole(s, "order", 1, 10);
    let blocks = layer_count.map(|layers| layers + usize::from(domain.continued));
    let elements = elements(cx, s, blocks, domain.continued);
    let element_size = cx.auto_number(s, "element_size", &Bounds::at_least(SIZE_FROM, "m"));
    let bounds = Bounds::between(2.0, POINTS_TO, "");
    let points_per_wavelength = cx.auto_number(s, "points_per_wavelength", &bounds);
    let f_max = cx.auto_number(s, "f_max", &Bounds::positive("Hz"));
    let precision = auto_word::<Precision>(cx, s, "precision", ["auto", "f32", "f64"]);
    let dt = cx.auto_number(s, "dt", &Bounds::at_least(DT_FROM, "s"));
    let mechanisms = cx.auto_whole(s, "mechanisms", 1, 12);
    let memory_variables =
        auto_word::<MemoryVariables>(cx, s, "memory_variables", ["auto", "full", "coarse"]);
    let tail = cx.auto_number(s, "tail", &Bounds::between(0.0, TAIL_TO, "s"));
    if let (Some(Auto::Value(tail)), Some((dt, duration))) = (tail, synthetic)
        && (duration + tail) / dt > MAX_SAMPLES
    {
        let samples = rounded((duration + tail) / dt);
        let message = format!("motion and tail are {samples} samples, too many (limit {MAX_SAMPLES:e})");
        cx.error(s.at("tail"), message, "shorten the tail, or raise the wavelet's dt");
    }
    if domain.column() {
        let keys = ["element_size", "points_per_wavelength", "f_max", "precision", "memory_variables"];
        cx.misplaced(
            s,
            &keys,
            "belongs to a scene with [domain]",
            "take it out: a column has no such choice",
        );
    } else {
        let help = "take it out; [run] has the duration";
        cx.misplaced(s, &["tail"], "belongs to a column and its motion", help);
    }
    if domain.mesh {
        let help = "take it out, or take `domain.mesh` out";
        cx.misplaced(s, &["elements", "element_size"], "belongs to a box; a mesh has its own elements", help);
    }
    cx.finish(s);
    Some(Discretisation {
        order: order?,
        elements: elements?,
        element_size: element_size?,
        points_per_wavelength: points_per_wavelength?,
        f_max: f_max?,
        precision: precision?,
        dt: dt?,
        mechanisms: mechanisms?,
        memory_variables: memory_variables?,
        tail: tail?,
    })
}

/// One of two words, or `"auto"`, the first of `words`.
fn auto_word<T: Words>(
    cx: &mut Checker<'_>,
    s: &mut Section<'_>,
    key: &'static str,
    words: [&str; 3],
) -> Option<Auto<T>> {
    let Some(node) = s.get(key) else { return Some(Auto::Auto) };
    match &node.value {
        Value::String(word) if word == "auto" => Some(Auto::Auto),
        Value::String(word) if !words.contains(&word.as_str()) => {
            cx.unknown_word(s.at(key), word, &words, "");
            None
        }
        Value::String(_) => cx.word::<T>(s, key).map(Auto::Value),
        other => {
            let [auto, first, second] = words;
            cx.wrong_type(s.at(key), other, &format!("\"{auto}\", \"{first}\" or \"{second}\""), "");
            None
        }
    }
}

fn elements(
    cx: &mut Checker<'_>,
    s: &mut Section<'_>,
    layer_count: Option<usize>,
    continued: bool,
) -> Option<Auto<Vec<usize>>> {
    const EXPECTED: &str = "a list with one count per layer";
    cx.auto(s, "elements", EXPECTED, |cx, node, place| {
        let Value::List(list) = &node.value else {
            cx.wrong_type(place, &node.value, &format!("\"auto\" or {EXPECTED}"), "");
            return None;
        };
        let counts: Vec<Option<usize>> = list
            .iter()
            .enumerate()
            .map(|(i, n)| {
                let place = Place { path: format!("{}[{}]", place.path, i + 1), at: n.at };
                cx.whole_of(n, place, 1, ELEMENTS_TO)
            })
            .collect();
        if let Some(layers) = layer_count.filter(|n| *n != list.len()) {
            let message = format!("{} counts for {layers} layers; expected one per layer", list.len());
            let help = if continued {
                "count the layers from the surface down, and the base's material down to `domain.depth` as the last"
            } else {
                "count the layers from the surface down; the base has no elements"
            };
            cx.error(place, message, help);
            return None;
        }
        let counts: Vec<usize> = counts.into_iter().collect::<Option<_>>()?;
        // Each count is below the limit and there are not too many of them: the sum cannot overflow.
        let sum: usize = counts.iter().sum();
        if sum > ELEMENTS_TO {
            let message = format!("{sum} elements in all are too many (limit {ELEMENTS_TO})");
            cx.error(place, message, "give fewer per layer, or a higher order with fewer elements");
            return None;
        }
        Some(counts)
    })
}

pub(super) fn output(
    cx: &mut Checker<'_>,
    top: &mut Section<'_>,
    depth: Option<f64>,
    domain: &domain::Read,
    materials: Option<&[String]>,
) -> Option<Output> {
    if top.get("output").is_none() {
        if !domain.column() {
            nothing(cx, top.at("output"));
        }
        return Some(Output::default());
    }
    let mut section = cx.table(top, "output")?;
    let s = &mut section;
    let column = domain.column();
    let stations = match s.get("stations") {
        None => Some(None),
        Some(node) => stations(cx, node, s.at("stations"), depth, domain).map(Some),
    };
    let field_spacing = match s.get("field_spacing") {
        None => Some(FieldSpacing::default()),
        Some(node) => field_spacing(cx, node, s.at("field_spacing"), depth.filter(|_| column)),
    };
    let rest = volume_output::read(cx, s, domain, materials);
    if column {
        let keys = ["quantities", "surface", "volume", "field", "checkpoint", "vtkhdf"];
        cx.misplaced(
            s,
            &keys,
            "belongs to a scene with [domain]",
            "take it out: a column has no such output",
        );
    } else {
        let help = "write [output.field] with spacing";
        cx.misplaced(s, &["field_spacing"], "belongs to a column", help);
        let given = ["stations", "surface", "volume", "field"];
        if !given.into_iter().any(|key| s.has(key)) {
            nothing(cx, s.place.clone());
        }
    }
    cx.finish(s);
    Some(Output { stations: stations?, field_spacing: field_spacing?, ..rest? })
}

/// Warns of a run that would leave nothing to look at.
fn nothing(cx: &mut Checker<'_>, place: Place) {
    let help = "give output.stations, [output.surface], [output.volume] or [output.field]";
    cx.warn(place, "nothing of the motion is written", help);
}

fn field_spacing(
    cx: &mut Checker<'_>,
    node: &Node,
    place: Place,
    depth: Option<f64>,
) -> Option<FieldSpacing> {
    match &node.value {
        Value::String(s) if s == "auto" => Some(FieldSpacing::Auto),
        Value::String(s) if s == "none" => Some(FieldSpacing::None),
        Value::String(s) => {
            cx.unknown_word(place, s, &["auto", "none"], "a number of metres");
            None
        }
        _ => {
            let spacing = cx.number_of(node, place.clone(), &Bounds::positive("m"))?;
            let least = depth.map_or(0.0, |d| d / FIELD_INTERVALS_TO);
            // The sum of the thicknesses carries round-off that its author does not see.
            if spacing < least * (1.0 - 1e-9) {
                let message = format!(
                    "{} m is below {} m, the column's depth over {}",
                    plain(spacing),
                    rounded(least),
                    plain(FIELD_INTERVALS_TO)
                );
                cx.error(
                    place,
                    message,
                    "raise it, or leave it to \"auto\"; stations give the motion at single depths",
                );
                return None;
            }
            Some(FieldSpacing::Metres(spacing))
        }
    }
}

/// A station as a scene shows it.
fn example(column: bool) -> &'static str {
    if column { "{ name = …, depth = … }" } else { "{ name = …, position = … }" }
}

fn stations(
    cx: &mut Checker<'_>,
    node: &Node,
    place: Place,
    depth: Option<f64>,
    domain: &domain::Read,
) -> Option<Vec<StationEntry>> {
    let Value::List(list) = &node.value else {
        let expected = format!("a list of tables {}", example(domain.column()));
        cx.wrong_type(place, &node.value, &expected, "");
        return None;
    };
    if list.is_empty() {
        cx.error(place, "there is no station", "name at least one, or leave `stations` out for the default");
        return None;
    }
    let mut all = Vec::with_capacity(list.len());
    let mut names: HashMap<String, usize> = HashMap::new();
    for (i, node) in list.iter().enumerate() {
        let place = Place { path: format!("{}[{}]", place.path, i + 1), at: node.at };
        let (name, entry) = station(cx, node, place.clone(), depth, domain);
        match name.map(|name| names.entry(name)) {
            Some(Entry::Occupied(first)) => {
                let mut place = place;
                place.path.push_str(".name");
                let message = format!("{:?} is the name of station {} already", first.key(), first.get());
                cx.error(place, message, "give each station a name of its own");
            }
            Some(Entry::Vacant(free)) => {
                free.insert(i + 1);
            }
            None => {}
        }
        all.push(entry);
    }
    all.into_iter().collect()
}

/// A station, and its name even where the rest is wrong.
fn station(
    cx: &mut Checker<'_>,
    node: &Node,
    place: Place,
    column: Option<f64>,
    domain: &domain::Read,
) -> (Option<String>, Option<StationEntry>) {
    let Value::Table(table) = &node.value else {
        cx.wrong_type(place, &node.value, &format!("a table {}", example(domain.column())), "");
        return (None, None);
    };
    let mut section = Section::new(table, place);
    let s = &mut section;
    let name = match s.get("name") {
        None => {
            cx.missing(s, "name", "give `name`, a text");
            None
        }
        Some(_) => cx.text(s, "name"),
    };
    let quantities = volume_output::quantities(cx, s);
    let at = if domain.column() {
        if let Some(node) = s.get("position") {
            coordinates(cx, node, s.at("position"));
        }
        let help = "take it out: a column's stations have a depth alone";
        cx.misplaced(s, &["position", "quantities"], "belongs to a scene with [domain]", help);
        depth_in_column(cx, s, name.as_deref(), column).map(|depth| (None, Some(depth)))
    } else {
        domain.place(cx, s, "position").map(|(position, depth)| (Some(position), depth))
    };
    cx.finish(s);
    let entry = match (&name, at, quantities) {
        (Some(name), Some((position, depth)), Some(quantities)) => {
            Some(StationEntry { name: name.clone(), position, depth, quantities })
        }
        _ => None,
    };
    (name, entry)
}

/// The depth of a column's station.
fn depth_in_column(
    cx: &mut Checker<'_>,
    s: &mut Section<'_>,
    name: Option<&str>,
    column: Option<f64>,
) -> Option<f64> {
    let depth = cx.required_number(s, "depth", &Bounds::at_least(0.0, "m"))?;
    let Some(column) = column else { return Some(depth) };
    // The sum of the thicknesses carries round-off that its author does not see.
    let slack = 1e-9 * column;
    if depth > column + slack {
        let message = format!("{} m is below the column, which ends at {} m", plain(depth), rounded(column));
        cx.error(s.at("depth"), message, "depth counts down from the surface and ends at the base's top");
    }
    reserved(cx, s, name, depth, column, slack);
    Some(depth.min(column))
}

/// Names that outputs give to places of their own.
fn reserved(cx: &mut Checker<'_>, s: &Section<'_>, name: Option<&str>, depth: f64, column: f64, slack: f64) {
    let message = match name {
        Some("outcrop") => "`outcrop` names the input motion, which is no point of the column".to_owned(),
        Some("surface") if depth > slack => {
            format!("`surface` names the depth 0 m, found {} m", plain(depth))
        }
        Some("within") if (depth - column).abs() > slack => {
            format!("`within` names the base's top at {} m, found {} m", rounded(column), plain(depth))
        }
        _ => return,
    };
    cx.error(s.at("name"), message, "choose another name");
}
