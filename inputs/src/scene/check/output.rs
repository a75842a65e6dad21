//! `[discretisation]` and `[output]`.

use super::super::diagnostic::{plain, rounded};
use super::super::document::{Node, Value};
use super::super::types::{
    Auto, DT_FROM, Discretisation, ELEMENTS_TO, FIELD_INTERVALS_TO, FieldSpacing, Output, Station, TAIL_TO,
};
use super::motion::MAX_SAMPLES;
use super::reader::{Bounds, Checker, Place, Section};

pub(super) fn discretisation(
    cx: &mut Checker<'_>,
    top: &mut Section<'_>,
    layer_count: Option<usize>,
    synthetic: Option<(f64, f64)>,
) -> Option<Discretisation> {
    if top.get("discretisation").is_none() {
        return Some(Discretisation::default());
    }
    let mut section = cx.table(top, "discretisation")?;
    let s = &mut section;
    let order = cx.auto_whole(s, "order", 1, 10);
    let elements = elements(cx, s, layer_count);
    let dt = cx.auto_number(s, "dt", &Bounds::at_least(DT_FROM, "s"));
    let mechanisms = cx.auto_whole(s, "mechanisms", 1, 12);
    let tail = cx.auto_number(s, "tail", &Bounds::between(0.0, TAIL_TO, "s"));
    if let (Some(Auto::Value(tail)), Some((dt, duration))) = (tail, synthetic)
        && (duration + tail) / dt > MAX_SAMPLES
    {
        let samples = rounded((duration + tail) / dt);
        let message = format!("motion and tail are {samples} samples, too many (limit {MAX_SAMPLES:e})");
        cx.error(s.at("tail"), message, "shorten the tail, or raise the wavelet's dt");
    }
    cx.finish(s);
    Some(Discretisation { order: order?, elements: elements?, dt: dt?, mechanisms: mechanisms?, tail: tail? })
}

fn elements(
    cx: &mut Checker<'_>,
    s: &mut Section<'_>,
    layer_count: Option<usize>,
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
            cx.error(place, message, "count the layers from the surface down; the base has no elements");
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

pub(super) fn output(cx: &mut Checker<'_>, top: &mut Section<'_>, depth: Option<f64>) -> Option<Output> {
    if top.get("output").is_none() {
        return Some(Output::default());
    }
    let mut section = cx.table(top, "output")?;
    let s = &mut section;
    let stations = match s.get("stations") {
        None => Some(None),
        Some(node) => stations(cx, node, s.at("stations"), depth).map(Some),
    };
    let field_spacing = match s.get("field_spacing") {
        None => Some(FieldSpacing::default()),
        Some(node) => field_spacing(cx, node, s.at("field_spacing"), depth),
    };
    cx.finish(s);
    Some(Output { stations: stations?, field_spacing: field_spacing? })
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

fn stations(cx: &mut Checker<'_>, node: &Node, place: Place, depth: Option<f64>) -> Option<Vec<Station>> {
    let Value::List(list) = &node.value else {
        let expected = "a list of tables { name = …, depth = … }";
        cx.wrong_type(place, &node.value, expected, "");
        return None;
    };
    if list.is_empty() {
        cx.error(place, "there is no station", "name at least one, or leave `stations` out for the default");
        return None;
    }
    let mut all = Vec::with_capacity(list.len());
    let mut names: Vec<(String, usize)> = Vec::new();
    for (i, node) in list.iter().enumerate() {
        let place = Place { path: format!("{}[{}]", place.path, i + 1), at: node.at };
        let read = station(cx, node, place.clone(), depth);
        if let Some(name) = &read.0 {
            if let Some((_, first)) = names.iter().find(|(n, _)| n == name) {
                let mut place = place;
                place.path.push_str(".name");
                let message = format!("{name:?} is the name of station {first} already");
                cx.error(place, message, "give each station a name of its own");
            } else {
                names.push((name.clone(), i + 1));
            }
        }
        all.push(read);
    }
    all.into_iter().map(|(name, depth)| Some(Station { name: name?, depth: depth? })).collect()
}

fn station(
    cx: &mut Checker<'_>,
    node: &Node,
    place: Place,
    column: Option<f64>,
) -> (Option<String>, Option<f64>) {
    let Value::Table(table) = &node.value else {
        cx.wrong_type(place, &node.value, "a table { name = …, depth = … }", "");
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
    let depth = cx.required_number(s, "depth", &Bounds::at_least(0.0, "m"));
    if let (Some(depth), Some(column)) = (depth, column) {
        // The sum of the thicknesses carries round-off that its author does not see.
        let slack = 1e-9 * column;
        if depth > column + slack {
            let message =
                format!("{} m is below the column, which ends at {} m", plain(depth), rounded(column));
            cx.error(s.at("depth"), message, "depth counts down from the surface and ends at the base's top");
        }
        reserved(cx, s, name.as_deref(), depth, column, slack);
    }
    cx.finish(s);
    let inside = depth.map(|d| column.map_or(d, |c| d.min(c)));
    (name, inside)
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
