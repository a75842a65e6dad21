//! What `[output]` holds for a domain: quantities, surface, volume, field, checkpoints.

use super::super::diagnostic::{listed, nearest};
use super::super::document::Value;
use super::super::types::{Auto, Output};
use super::super::volume::{
    CHECKPOINT_TO, Checkpoint, FieldOutput, OutputQuantity, SurfaceOutput, VolumeOutput, top, velocity,
};
use super::domain;
use super::reader::{Bounds, Checker, Place, Section};

/// The keys of a domain's output; the others are left at their defaults.
///
/// `materials`: the names that a volume may be limited to, where all could be read.
pub(super) fn read(
    cx: &mut Checker<'_>,
    s: &mut Section<'_>,
    domain: &domain::Read,
    materials: Option<&[String]>,
) -> Option<Output> {
    let quantities = quantities(cx, s);
    let surface = part(cx, s, "surface", |cx, s| surface(cx, s, domain));
    let volume = part(cx, s, "volume", |cx, s| volume(cx, s, materials));
    let field = part(cx, s, "field", |cx, s| field(cx, s, domain));
    let checkpoint = part(cx, s, "checkpoint", |cx, s| {
        Some(Checkpoint { every: cx.auto_number(s, "every", &Bounds::between(1.0, CHECKPOINT_TO, "s"))? })
    });
    let vtkhdf = cx.flag(s, "vtkhdf");
    Some(Output {
        quantities: quantities?,
        surface: surface?,
        volume: volume?,
        field: field?,
        checkpoint: checkpoint?,
        vtkhdf: vtkhdf?,
        ..Output::default()
    })
}

/// A table that may be left out; the outer `None` is a mistake.
fn part<'c, T>(
    cx: &mut Checker<'c>,
    s: &mut Section<'_>,
    key: &'static str,
    read: impl FnOnce(&mut Checker<'c>, &mut Section<'_>) -> Option<T>,
) -> Option<Option<T>> {
    if s.get(key).is_none() {
        return Some(None);
    }
    let mut section = cx.table(s, key)?;
    let part = read(cx, &mut section);
    cx.finish(&section);
    part.map(Some)
}

/// The key `quantities`: words, at least one, each once; the inner `None` is a key that is not there.
pub(super) fn quantities(cx: &mut Checker<'_>, s: &mut Section<'_>) -> Option<Option<Vec<OutputQuantity>>> {
    let Some(node) = s.get("quantities") else { return Some(None) };
    let place = s.at("quantities");
    let Value::List(list) = &node.value else {
        let help = "for instance quantities = [\"velocity\", \"stress\"]";
        cx.wrong_type(place, &node.value, "a list of quantities", help);
        return None;
    };
    if list.is_empty() {
        cx.error(
            place,
            "there is no quantity",
            "name at least one, or leave `quantities` out for the default",
        );
        return None;
    }
    let mut all: Vec<Option<OutputQuantity>> = Vec::with_capacity(list.len());
    for (i, node) in list.iter().enumerate() {
        let place = Place { path: format!("{}[{}]", place.path, i + 1), at: node.at };
        let quantity = cx.word_of::<OutputQuantity>(node, place.clone());
        if let Some(twice) = quantity.filter(|q| all.contains(&Some(*q))) {
            cx.error(place, format!("\"{}\" stands there twice", twice.as_str()), "take one of them out");
            all.push(None);
        } else {
            all.push(quantity);
        }
    }
    all.into_iter().collect::<Option<Vec<_>>>().map(Some)
}

/// `dt` and `quantities` of a surface, a volume or a field.
fn states(cx: &mut Checker<'_>, s: &mut Section<'_>) -> (Option<Auto<f64>>, Option<Vec<OutputQuantity>>) {
    let dt = cx.auto_number(s, "dt", &Bounds::positive("s"));
    let given = quantities(cx, s);
    let tensor = |q: &&OutputQuantity| **q >= OutputQuantity::Strain;
    if let Some(tensor) = given.iter().flatten().flatten().find(tensor) {
        let message = format!("\"{}\" is written at stations only", tensor.as_str());
        let help =
            "take it out; for strain or stress give [[output.stations]] with quantities = [\"strain\"]";
        cx.error(s.at("quantities"), message, help);
        return (dt, None);
    }
    (dt, given.map(|given| given.unwrap_or_else(velocity)))
}

fn surface(cx: &mut Checker<'_>, s: &mut Section<'_>, domain: &domain::Read) -> Option<SurfaceOutput> {
    let boundary = match s.get("boundary") {
        None => Some(top()),
        Some(_) => cx.text(s, "boundary"),
    };
    if let Some(name) = &boundary {
        domain.boundary(cx, s.at("boundary"), name);
    }
    let (dt, quantities) = states(cx, s);
    Some(SurfaceOutput { boundary: boundary?, dt: dt?, quantities: quantities? })
}

fn volume(cx: &mut Checker<'_>, s: &mut Section<'_>, materials: Option<&[String]>) -> Option<VolumeOutput> {
    let material = match s.get("material") {
        None => Some(None),
        Some(_) => cx.text(s, "material").map(Some),
    };
    if let (Some(Some(name)), Some(known)) = (&material, materials)
        && !known.contains(name)
    {
        let known: Vec<&str> = known.iter().map(String::as_str).collect();
        let help = match nearest(name, &known) {
            Some(near) => format!("did you mean \"{near}\"?"),
            None => format!(
                "the materials are {}",
                listed(&known[..known.len().min(20)], "\"").replace(" or ", " and ")
            ),
        };
        cx.error(s.at("material"), format!("there is no material {name:?}"), &help);
    }
    let (dt, quantities) = states(cx, s);
    Some(VolumeOutput { material: material?, dt: dt?, quantities: quantities? })
}

fn field(cx: &mut Checker<'_>, s: &mut Section<'_>, domain: &domain::Read) -> Option<FieldOutput> {
    let spacing = cx.auto_number(s, "spacing", &Bounds::positive("m"));
    let (dt, quantities) = states(cx, s);
    let [x, y, z] = ["x", "y", "z"].map(|axis| domain::range(cx, s, axis, true));
    if domain.dimension == Some(2) {
        let help = "take it out, or set dimension = 3";
        cx.misplaced(s, &["y"], "nothing varies along y at dimension 2", help);
    }
    for (axis, (key, range)) in [("x", x), ("y", y), ("z", z)].into_iter().enumerate() {
        if let Some(range) = range.flatten() {
            domain.holds(cx, s.at(key), axis, range);
        }
    }
    Some(FieldOutput { spacing: spacing?, dt: dt?, quantities: quantities?, x: x?, y: y?, z: z? })
}
