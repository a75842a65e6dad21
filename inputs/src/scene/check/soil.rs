//! `[soil]` and `[[material]]`: layers, base, a mesh's materials, and their constants.

use super::super::diagnostic::{listed, plain, rounded};
use super::super::document::{Node, Value};
use super::super::types::{
    Base, DAMPING_TO, DEFAULT_NU, LAYERS_TO, Layer, Q_FROM, Soil, THICKNESS_TO, VP_TO, VS_TO,
};
use super::super::values::{nu_from_speeds, vp_from_nu};
use super::super::volume::{ENTRIES_TO, Material, RHO_FROM, RHO_TO, SIZE_FROM};
use super::super::volume_values::BASE;
use super::domain;
use super::reader::{Bounds, Checker, Entries, Place, Section};

/// The section, and what other sections are checked against; `None` where it could not be read.
#[derive(Default)]
pub(super) struct Read {
    pub(super) soil: Option<Soil>,
    /// Number of layers that are written, rightly or wrongly.
    pub(super) layer_count: Option<usize>,
    /// Depth of the column, m.
    pub(super) depth: Option<f64>,
    /// Whether the base is rigid.
    pub(super) rigid: Option<bool>,
    /// Whether no layer has damping of shear waves, and whether none has damping of P waves.
    pub(super) undamped: [Option<bool>; 2],
}

const NU: Bounds = Bounds { below: Some(0.5), ..Bounds::at_least(0.0, "") };
const DAMPING: Bounds = Bounds::between(0.0, DAMPING_TO, "");
const Q: Bounds = Bounds::at_least(Q_FROM, "");
const VS: Bounds = Bounds { to: Some(VS_TO), ..Bounds::positive("m/s") };
const VP: Bounds = Bounds { to: Some(VP_TO), ..Bounds::positive("m/s") };
const THICKNESS: Bounds = Bounds::between(SIZE_FROM, THICKNESS_TO, "m");
const RHO: Bounds = Bounds::between(RHO_FROM, RHO_TO, "kg/m³");

pub(super) fn read(cx: &mut Checker<'_>, top: &mut Section<'_>, domain: &domain::Read) -> Read {
    if top.get("soil").is_none() {
        let help = "write [[soil.layer]] for each layer and [soil.base] for what they stand on";
        if domain.mesh {
            return Read { soil: Some(Soil::default()), ..Read::default() };
        }
        cx.missing(top, "soil", help);
        return Read::default();
    }
    let Some(mut section) = cx.table(top, "soil") else {
        return Read::default();
    };
    let s = &mut section;
    let reference_frequency = cx.auto_number(s, "reference_frequency", &Bounds::positive("Hz"));
    let mut read = Read::default();
    if domain.mesh {
        let message = "belongs to a column or a box; a mesh has its materials in [[material]]";
        cx.misplaced(s, &["layer", "base"], message, "take it out, or take `domain.mesh` out");
        let whole = !s.has("layer") && !s.has("base");
        cx.finish(s);
        let soil = |reference_frequency| Soil { reference_frequency, ..Soil::default() };
        read.soil = reference_frequency.filter(|_| whole).map(soil);
        return read;
    }
    let layers = layers(cx, s, domain, &mut read);
    let base = base(cx, s, &mut read);
    if !domain.column() {
        box_below(cx, domain, &read);
        names(cx, s, domain, layers.as_deref().unwrap_or_default());
    }
    cx.finish(s);
    read.soil = match (reference_frequency, layers, base) {
        (Some(reference_frequency), Some(layer), Some(base)) => {
            Some(Soil { reference_frequency, layer, base: Some(base) })
        }
        _ => None,
    };
    read
}

/// The layers; a box that its base fills needs none.
fn layers(
    cx: &mut Checker<'_>,
    s: &mut Section<'_>,
    domain: &domain::Read,
    read: &mut Read,
) -> Option<Vec<Layer>> {
    if domain.continued && s.get("layer").is_none() {
        (read.layer_count, read.depth) = (Some(0), Some(0.0));
        return Some(Vec::new());
    }
    let help = "write [[soil.layer]] with thickness, vs and rho for each layer, from the surface down";
    let fewer = "join thin layers of one kind";
    let what = Entries { one: "layer", header: "[[soil.layer]]", to: LAYERS_TO, help, fewer };
    let nodes = cx.entries(s, "layer", &what)?;
    let all: Vec<LayerRead> = nodes
        .iter()
        .enumerate()
        .map(|(i, node)| {
            let place = Place { path: format!("soil.layer[{}]", i + 1), at: node.at };
            layer(cx, node, place, domain.column())
        })
        .collect();
    read.layer_count = Some(all.len());
    read.depth = all.iter().map(|l| l.thickness).sum();
    read.undamped = [0, 1].map(|wave| undamped(&all, wave));
    all.into_iter().map(|l| l.layer).collect()
}

/// A box's depth against its layers and base.
fn box_below(cx: &mut Checker<'_>, domain: &domain::Read, read: &Read) {
    let Some((depth, place)) = &domain.depth else { return };
    if read.rigid == Some(true) {
        let message = "a rigid base ends the box under its layers: it does not continue to a depth";
        cx.error(place.clone(), message, "take `depth` out, or give the base as elastic with vs and rho");
    } else if let Some(layers) = read.depth.filter(|layers| *depth <= layers * (1.0 + 1e-9)) {
        let message =
            format!("{} m is not below the layers, which end at {} m", plain(*depth), rounded(layers));
        let help =
            "leave it out to end the box with the layers, or go deeper to continue the base's material";
        cx.error(place.clone(), message, help);
    }
}

/// Layers are materials of a box, which outputs name.
fn names(cx: &mut Checker<'_>, s: &Section<'_>, domain: &domain::Read, layers: &[Layer]) {
    for (i, layer) in layers.iter().enumerate() {
        let Some(name) = &layer.name else { continue };
        let place = s.in_list("layer", i + 1, "name");
        if domain.continued && name == BASE {
            cx.error(place, "`base` names the material under the layers", "choose another name");
        } else if let Some(first) = layers[..i].iter().position(|l| l.name.as_ref() == Some(name)) {
            let message = format!("{name:?} is the name of layer {} already", first + 1);
            cx.error(place, message, "give each layer of a domain a name of its own");
        }
    }
}

/// `[[material]]`: of a mesh one at least, elsewhere none. The names that could be read come with it.
pub(super) fn materials(
    cx: &mut Checker<'_>,
    top: &mut Section<'_>,
    domain: &domain::Read,
) -> Option<Vec<Material>> {
    let given = top.get("material").is_some();
    if !domain.mesh {
        let help = "give `domain.mesh`, or write the ground as [[soil.layer]]";
        cx.misplaced(top, &["material"], "belongs to a mesh's physical group", help);
        return (!given).then(Vec::new);
    }
    let help = "write [[material]] with name, vs and rho for each physical group of the mesh";
    let what =
        Entries { one: "material", header: "[[material]]", to: ENTRIES_TO, help, fewer: "join groups" };
    let nodes = cx.entries(top, "material", &what)?;
    let mut names: Vec<&str> = Vec::new();
    let mut all = Vec::with_capacity(nodes.len());
    for (i, node) in nodes.iter().enumerate() {
        let place = Place { path: format!("material[{}]", i + 1), at: node.at };
        let Value::Table(table) = &node.value else {
            cx.wrong_type(place, &node.value, "a table", "write [[material]] above its keys");
            all.push(None);
            continue;
        };
        let mut section = Section::new(table, place);
        let mut read = material(cx, &mut section);
        if let Some(Value::String(name)) = table.get("name").map(|n| &n.value) {
            if let Some(first) = names.iter().position(|n| n == name) {
                let message = format!("{name:?} is the name of material {} already", first + 1);
                cx.error(section.at("name"), message, "give each physical group once");
                read = None;
            }
            names.push(name);
        } else {
            names.push("");
        }
        all.push(read);
    }
    all.into_iter().collect()
}

fn material(cx: &mut Checker<'_>, s: &mut Section<'_>) -> Option<Material> {
    if s.get("name").is_none() {
        cx.missing(s, "name", "give `name`, the mesh's physical group");
    }
    let name = cx.text(s, "name");
    let medium = medium(cx, s);
    let losses = losses(cx, s, medium.as_ref(), false);
    cx.finish(s);
    let (name, m) = (name?, medium?);
    let Losses { damping: [damping, damping_p], q: [q, q_p], readable } = losses;
    (readable == [true; 2]).then_some(())?;
    Some(Material { name, vs: m.vs, vp: m.vp, nu: m.nu, rho: m.rho, damping, q, damping_p, q_p })
}

/// Whether no layer damps shear waves (`wave` 0) or P waves (1); `None` where a layer's damping could not be read and
/// none of the others has any.
fn undamped(layers: &[LayerRead], wave: usize) -> Option<bool> {
    if layers.iter().any(|l| l.damped[wave] == Some(true)) {
        return Some(false);
    }
    layers.iter().all(|l| l.damped[wave].is_some()).then_some(true)
}

/// A layer as far as it could be read.
#[derive(Default)]
struct LayerRead {
    layer: Option<Layer>,
    thickness: Option<f64>,
    /// Whether it damps shear waves and P waves; `None` where that could not be read.
    damped: [Option<bool>; 2],
}

fn layer(cx: &mut Checker<'_>, node: &Node, place: Place, column: bool) -> LayerRead {
    let Value::Table(table) = &node.value else {
        let help = "a layer looks like { thickness = 5.0, vs = 150.0, rho = 1800.0 }";
        cx.wrong_type(place, &node.value, "a table", help);
        return LayerRead::default();
    };
    let mut section = Section::new(table, place);
    let s = &mut section;
    let name = match s.get("name") {
        None => Some(None),
        Some(_) => cx.text(s, "name").map(Some),
    };
    let thickness = cx.required_number(s, "thickness", &THICKNESS);
    let medium = medium(cx, s);
    let losses = losses(cx, s, medium.as_ref(), column);
    let (ratios, [readable, readable_p]) = (losses.ratios(), losses.readable);
    let Losses { damping: [damping, damping_p], q: [q, q_p], .. } = losses;
    let before = cx.found.len();
    cx.finish(s);
    // A key that nobody knows may be a misspelt damping.
    let spelt = cx.found.len() == before;
    let some = |known: bool, d: Option<f64>| match d {
        Some(d) if d > 0.0 => Some(true),
        _ => (known && spelt).then_some(false),
    };
    let shear = some(readable, ratios[0]);
    let own = ratios[1];
    let damped = [shear, if own.is_none() && readable_p { shear } else { some(readable_p, own) }];
    let layer = match (name, thickness, medium) {
        (Some(name), Some(thickness), Some(m)) if readable && readable_p => Some(Layer {
            name,
            thickness,
            vs: m.vs,
            vp: m.vp,
            nu: m.nu,
            rho: m.rho,
            damping,
            q,
            damping_p,
            q_p,
        }),
        _ => None,
    };
    LayerRead { layer, thickness, damped }
}

/// The damping of a layer or a material: of shear waves, of P waves.
struct Losses {
    damping: [Option<f64>; 2],
    q: [Option<f64>; 2],
    /// Whether what is written could be read.
    readable: [bool; 2],
}

impl Losses {
    /// Damping ratios, where they are given one way or the other.
    fn ratios(&self) -> [Option<f64>; 2] {
        [0, 1].map(|wave| self.damping[wave].or(self.q[wave].map(|q| 0.5 / q)))
    }
}

fn losses(cx: &mut Checker<'_>, s: &mut Section<'_>, medium: Option<&Medium>, column: bool) -> Losses {
    let (damping, q) = loss(cx, s, "damping", "q");
    let (damping_p, q_p) = loss(cx, s, "damping_p", "q_p");
    let readable = (!s.has("damping") || damping.is_some()) && (!s.has("q") || q.is_some());
    let readable_p = (!s.has("damping_p") || damping_p.is_some()) && (!s.has("q_p") || q_p.is_some());
    let losses = Losses { damping: [damping, damping_p], q: [q, q_p], readable: [readable, readable_p] };
    if let (Some(m), [Some(d), Some(d_p)]) = (medium, losses.ratios()) {
        volume_damping(cx, s, m, d, d_p, column);
    }
    losses
}

/// What layers and half-space have in common.
struct Medium {
    vs: f64,
    rho: f64,
    vp: Option<f64>,
    nu: Option<f64>,
}

fn medium(cx: &mut Checker<'_>, s: &mut Section<'_>) -> Option<Medium> {
    let vs = cx.required_number(s, "vs", &VS);
    let rho = cx.required_number(s, "rho", &RHO);
    let vp = cx.number(s, "vp", &VP);
    let nu = cx.number(s, "nu", &NU);
    let one = cx.only_one(s, "vp", "nu", "the other follows from vs");
    let mut consistent = true;
    if let (Some(vs), Some(vp)) = (vs, vp) {
        consistent = speeds(cx, s, vs, vp);
    } else if let (Some(vs), false) = (vs, s.has("vp")) {
        consistent = speed_from_nu(cx, s, vs, nu.unwrap_or(DEFAULT_NU));
    }
    if let Some(vs) = vs.filter(|v| !(10.0..=6000.0).contains(v)) {
        let message = format!("{} m/s is unusual for shear waves in the ground", plain(vs));
        cx.warn(s.at("vs"), message, "vs is in m/s");
    }
    if let Some(rho) = rho.filter(|r| !(500.0..=5000.0).contains(r)) {
        let message = format!("{} kg/m³ is unusual for the ground", plain(rho));
        let help = if rho < 5.0 {
            format!("rho is in kg/m³: {} t/m³ is rho = {}", plain(rho), rounded(rho * 1000.0))
        } else {
            "rho is in kg/m³".to_owned()
        };
        cx.warn(s.at("rho"), message, &help);
    }
    let wrong = (s.has("vp") && vp.is_none()) || (s.has("nu") && nu.is_none());
    (one && consistent && !wrong).then_some(())?;
    Some(Medium { vs: vs?, rho: rho?, vp, nu })
}

/// Whether vs ≤ vp/√2, that is ν ≥ 0.
fn speeds(cx: &mut Checker<'_>, s: &Section<'_>, vs: f64, vp: f64) -> bool {
    if vs < vp && nu_from_speeds(vs, vp) >= 0.0 {
        return true;
    }
    let limit = vp / 2f64.sqrt();
    let message =
        format!("{} m/s is above vp/√2 = {limit:.0} m/s (Poisson's ratio would be negative)", plain(vs));
    let help = if nu_from_speeds(vp, vs) >= 0.0 && vp < vs {
        "swap vp and vs, or give nu instead of vp"
    } else {
        "raise vp or lower vs, or give nu instead of vp"
    };
    cx.error(s.at("vs"), message, help);
    false
}

/// Whether the speed of P waves that follows from Poisson's ratio is one that may be given.
fn speed_from_nu(cx: &mut Checker<'_>, s: &Section<'_>, vs: f64, nu: f64) -> bool {
    let vp = vp_from_nu(vs, nu);
    if vp <= VP_TO {
        return true;
    }
    let key = if s.has("nu") { "nu" } else { "vs" };
    let message = format!(
        "vs = {} m/s and nu = {} make vp = {} m/s, which is above {} m/s",
        plain(vs),
        plain(nu),
        rounded(vp),
        plain(VP_TO)
    );
    cx.error(s.at(key), message, "lower nu, or give vp instead of it");
    false
}

/// One of a damping ratio and a quality factor.
fn loss(
    cx: &mut Checker<'_>,
    s: &mut Section<'_>,
    ratio: &'static str,
    quality: &'static str,
) -> (Option<f64>, Option<f64>) {
    let before = cx.found.len();
    let d = cx.number(s, ratio, &DAMPING);
    // A number that is too large is most likely a percentage.
    if let Some(Value::Integer(_) | Value::Float(_)) = s.get(ratio).map(|n| &n.value)
        && let Some(found) = cx.found.get_mut(before)
    {
        found.help = Some("damping is a ratio: 2 % is 0.02".to_owned());
    }
    let q = cx.number(s, quality, &Q);
    let one = cx.only_one(s, ratio, quality, "D = 1/(2Q)");
    if one { (d, q) } else { (None, None) }
}

/// A P-wave damping so small that changes of volume would gain energy: harmless in a column, unstable elsewhere.
///
/// With M = K + 4G/3, the loss of the bulk modulus is Im K = 2 M D_p − (4/3)·2 G D_s, negative below
/// D_p = (4/3)(vs/vp)² D_s.
fn volume_damping(cx: &mut Checker<'_>, s: &Section<'_>, m: &Medium, d: f64, d_p: f64, column: bool) {
    let vp = m.vp.unwrap_or_else(|| vp_from_nu(m.vs, m.nu.unwrap_or(DEFAULT_NU)));
    let least = 4.0 / 3.0 * (m.vs / vp).powi(2) * d;
    if d_p < least * (1.0 - 1e-9) {
        let key = if s.has("q_p") { "q_p" } else { "damping_p" };
        let message = format!(
            "a P-wave damping of {} is below (4/3)(vs/vp)²·damping = {}: changes of volume alone would gain energy",
            rounded(d_p),
            rounded(least)
        );
        if column {
            let help =
                "harmless for waves straight up and down; leave damping_p out to take that of shear waves";
            cx.warn(s.at(key), message, help);
        } else {
            cx.error(s.at(key), message, "raise it, or leave it out to take the damping of shear waves");
        }
    }
}

fn base(cx: &mut Checker<'_>, soil: &mut Section<'_>, read: &mut Read) -> Option<Base> {
    const KINDS: [&str; 2] = ["elastic", "rigid"];
    if soil.get("base").is_none() {
        cx.missing(
            soil,
            "base",
            "write [soil.base] with kind = \"elastic\", vs and rho, or with kind = \"rigid\"",
        );
        return None;
    }
    let mut section = cx.table(soil, "base")?;
    let s = &mut section;
    let kind = match s.get("kind").map(|n| &n.value) {
        None => {
            let help = format!("give `kind` as {}", listed(&KINDS, "\""));
            cx.missing(s, "kind", &help);
            None
        }
        Some(Value::String(word)) => {
            let known = KINDS.into_iter().find(|k| k == word);
            if known.is_none() {
                cx.unknown_word(s.at("kind"), word, &KINDS, "");
            }
            known
        }
        Some(other) => {
            cx.wrong_type(s.at("kind"), other, &listed(&KINDS, "\""), "");
            None
        }
    };
    read.rigid = kind.map(|k| k == "rigid");
    if kind == Some("rigid") {
        for key in ["vs", "rho", "nu", "vp"] {
            if s.get(key).is_some() {
                cx.error(s.at(key), "a rigid base has no such key", "take it out, or set kind = \"elastic\"");
            }
        }
        cx.finish(s);
        return Some(Base::Rigid);
    }
    // Without a known kind the numbers are read as an elastic base's, unless there are none.
    let any = ["vs", "rho", "nu", "vp"].into_iter().any(|k| s.has(k));
    let m = if kind.is_some() || any { medium(cx, s) } else { None };
    for key in ["damping", "q", "thickness"] {
        if s.has(key) {
            s.get(key);
            cx.error(
                s.at(key),
                "an elastic base has no such key: it is a half-space without damping",
                "take it out",
            );
        }
    }
    cx.finish(s);
    kind?;
    m.map(|m| Base::Elastic { vs: m.vs, rho: m.rho, nu: m.nu, vp: m.vp })
}
