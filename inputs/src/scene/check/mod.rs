//! The checks: each section is read on its own, and whatever could be read is checked against the rest.

mod domain;
mod motion;
mod output;
mod process;
mod process_fit;
mod reader;
mod soil;
mod source;
mod volume_output;

pub(super) use process::step;
pub(super) use reader::{Checker, Place};

use super::diagnostic::listed;
use super::document::{Table, Value};
use super::load::Source;
use super::types::{ACCURACY_ABOVE, ACCURACY_TO, Layer, MotionKind, Scene, default_accuracy, default_title};
use super::volume::Material;
use super::volume_values::BASE;
use reader::{Bounds, Section};

/// The only version of the format so far.
const VERSION: i64 = 1;

/// Reads a whole scene; `None` where something that it cannot do without is missing or wrong (and has been reported).
pub(super) fn scene(cx: &mut Checker<'_>, root: &Table) -> Option<Scene> {
    let mut top = Section::root(root);
    version(cx, &mut top);
    let title = match top.get("title") {
        None => Some(default_title()),
        Some(_) => cx.text(&mut top, "title"),
    };
    let accuracy = accuracy(cx, &mut top);
    let mut domain = domain::read(cx, &mut top);
    let motion = motion(cx, &mut top, &domain);
    let soil = soil::read(cx, &mut top, &domain);
    if !domain.mesh {
        domain.bottom = domain.depth.as_ref().map(|d| d.0).or(soil.depth);
    }
    let material = soil::materials(cx, &mut top, &domain);
    let (layers, synthetic) = (soil.layer_count, motion.synthetic);
    let discretisation = output::discretisation(cx, &mut top, layers, synthetic, &domain);
    let run = source::run(cx, &mut top, domain.column());
    let around = source::Around {
        domain: &domain,
        duration: run.flatten().map(|run| run.duration),
        f_max: discretisation.as_ref().and_then(|d| d.f_max.value().copied()),
    };
    let source_entries = source::read(cx, &mut top, &around);
    let names = names(&domain, &soil, material.as_deref());
    let output = output::output(cx, &mut top, soil.depth, &domain, names.as_deref());
    kind_against_base(cx, &motion, &soil);
    cx.finish(&top);
    let driven = motion.motion.is_some() || domain.given;
    Some(Scene {
        version: VERSION as u32,
        title: title?,
        accuracy: accuracy?,
        domain: if domain.given { Some(domain.domain?) } else { None },
        motion: if driven { motion.motion } else { return None },
        soil: soil.soil?,
        material: material?,
        source_entries: source_entries?,
        run: run?,
        discretisation: discretisation?,
        output: output?,
        source: Source::default(),
    })
}

/// `[motion]`: of a column required, of a domain refused.
fn motion(cx: &mut Checker<'_>, top: &mut Section<'_>, domain: &domain::Read) -> motion::Read {
    if domain.column() {
        return motion::read(cx, top);
    }
    let message = "a motion drives a column; plane waves do not enter a domain yet";
    cx.misplaced(top, &["motion"], message, "take it out and give [[source]], or take [domain] out");
    motion::Read::default()
}

/// Names of the ground's materials, where all could be read.
fn names(domain: &domain::Read, soil: &soil::Read, material: Option<&[Material]>) -> Option<Vec<String>> {
    if domain.mesh {
        return Some(material?.iter().map(|m| m.name.clone()).collect());
    }
    let layers = &soil.soil.as_ref()?.layer;
    let named = |(i, l): (usize, &Layer)| l.name.clone().unwrap_or_else(|| format!("layer {}", i + 1));
    let base = domain.continued.then(|| BASE.to_owned());
    Some(layers.iter().enumerate().map(named).chain(base).collect())
}

fn version(cx: &mut Checker<'_>, top: &mut Section<'_>) {
    let help = "write version = 1";
    match top.get("version").map(|n| &n.value) {
        None => cx.missing(top, "version", help),
        Some(Value::Integer(VERSION)) => {}
        Some(Value::Integer(other)) => {
            cx.error(top.at("version"), format!("this program reads version {VERSION}, found {other}"), help)
        }
        Some(other) => cx.wrong_type(top.at("version"), other, "the whole number 1", help),
    }
}

fn accuracy(cx: &mut Checker<'_>, top: &mut Section<'_>) -> Option<f64> {
    let bounds = Bounds { above: Some(ACCURACY_ABOVE), to: Some(ACCURACY_TO), ..Bounds::any("") };
    match top.get("accuracy") {
        None => Some(default_accuracy()),
        Some(_) => cx.number(top, "accuracy", &bounds),
    }
}

/// What the place of the motion demands of the base and of the layers' damping.
///
/// A `within` motion is the motion of the column's base, whatever lies below, and over a rigid base every motion is: such
/// a column loses energy in its layers only. Along x and y shear waves run, along z P waves.
fn kind_against_base(cx: &mut Checker<'_>, motion: &motion::Read, soil: &soil::Read) {
    let Some((kind, place)) = &motion.kind else { return };
    let rigid = soil.rigid == Some(true);
    let lossless: Vec<&str> = (["x", "y", "z"].into_iter().zip(motion.given).zip([0, 0, 1]))
        .filter(|((_, given), wave)| *given && soil.undamped[*wave] == Some(true))
        .map(|((axis, _), _)| axis)
        .collect();
    let axes = listed(&lossless, "").replace(" or ", " and ");
    match kind {
        MotionKind::Outcrop if rigid => cx.error(
            place.clone(),
            "an outcrop motion has no meaning over a rigid base: nothing radiates into it",
            "use kind = \"within\", or give the base as elastic with vs and rho",
        ),
        MotionKind::Surface if rigid && !lossless.is_empty() => cx.error(
            place.clone(),
            format!(
                "a surface motion over a rigid base cannot be carried down along {axes}, where no layer is damped: at \
                 each resonance of the column the surface moves without its base"
            ),
            "give the layers damping, or the base as elastic with vs and rho",
        ),
        MotionKind::Within if !lossless.is_empty() => {
            let why = if rigid {
                "the base is rigid"
            } else {
                "a within motion is imposed on the base, through which then nothing is lost"
            };
            cx.warn(
                place.clone(),
                format!(
                    "no layer is damped along {axes} and {why}: resonances grow without bound as long as the motion \
                     lasts"
                ),
                "give the layers damping, or use kind = \"outcrop\" over an elastic base",
            );
        }
        _ => {}
    }
}
