//! `[domain]`: a box or a mesh, its boundaries, and whether a place lies in it.

use std::collections::BTreeMap;

use super::super::diagnostic::{listed, nearest, plain, rounded};
use super::super::document::{Node, Value, join};
use super::super::files;
use super::super::topography::Topography;
use super::super::volume::{BoundaryKind, COORDINATE_TO, Domain, SIZE_FROM};
use super::reader::{Bounds, Checker, Place, Section};

/// The section, and what other sections are checked against; `None` where it could not be read.
#[derive(Default)]
pub(super) struct Read {
    pub(super) domain: Option<Domain>,
    /// Whether the scene has the table: without it the scene is a column.
    pub(super) given: bool,
    pub(super) dimension: Option<usize>,
    /// Whether a mesh takes the place of the box.
    pub(super) mesh: bool,
    /// Whether the box has a depth of its own, so that the base's material continues under the layers.
    pub(super) continued: bool,
    /// That depth, with its place.
    pub(super) depth: Option<(f64, Place)>,
    /// Extent of the box along x and y.
    sides: [Option<[f64; 2]>; 2],
    /// Depth of the box, given or the layers' sum; known once the soil is read.
    pub(super) bottom: Option<f64>,
    heights: Option<Topography>,
}

pub(super) const COORDINATE: Bounds = Bounds::between(-COORDINATE_TO, COORDINATE_TO, "m");
const DEPTH: Bounds = Bounds::between(SIZE_FROM, COORDINATE_TO, "m");

pub(super) fn read(cx: &mut Checker<'_>, top: &mut Section<'_>) -> Read {
    let mut read = Read { given: top.get("domain").is_some(), ..Read::default() };
    let Some(mut section) = cx.table(top, "domain") else { return read };
    let s = &mut section;
    let dimension = dimension(cx, s);
    read.dimension = dimension;
    read.mesh = s.has("mesh");
    read.continued = s.has("depth") && !read.mesh;
    let mesh = mesh(cx, s);
    let x = range(cx, s, "x", false);
    let y = range(cx, s, "y", false);
    let depth = cx.optional(s, "depth", &DEPTH);
    let heights = topography(cx, s, dimension);
    extent(cx, s, &read);
    if !read.mesh {
        read.sides = [x.flatten(), y.flatten()];
    }
    read.depth = depth.flatten().map(|d| (d, s.at("depth")));
    let boundary = boundaries(cx, s, dimension, read.mesh);
    if let Some((_, Some(t))) = &heights {
        covered(cx, s, t, read.sides);
    }
    cx.finish(s);
    read.heights = heights.as_ref().and_then(|(_, t)| t.clone());
    let whole = read.mesh || (s.has("x") && (dimension == Some(2) || s.has("y")));
    read.domain = match (dimension, mesh, x, y, depth, heights, boundary) {
        (
            Some(dimension),
            Some(mesh),
            Some(x),
            Some(y),
            Some(depth),
            Some((topography, heights)),
            Some(boundary),
        ) if whole => Some(Domain { dimension, x, y, depth, topography, mesh, boundary, heights }),
        _ => None,
    };
    read
}

/// What a mesh has in place of the box's extent, and what a box cannot do without.
fn extent(cx: &mut Checker<'_>, s: &mut Section<'_>, read: &Read) {
    if read.mesh {
        let keys = ["x", "y", "depth", "topography"];
        let help = "take it out, or take `mesh` out";
        cx.misplaced(s, &keys, "belongs to a box; a mesh has its own extent", help);
        return;
    }
    let help = "give the least and the greatest coordinate in metres, for instance x = [-50.0, 50.0]";
    if s.get("x").is_none() {
        cx.missing(s, "x", help);
    }
    if read.dimension == Some(3) && s.get("y").is_none() {
        cx.missing(s, "y", &help.replace("x =", "y ="));
    }
    if read.dimension == Some(2) {
        let message = "nothing varies along y at dimension 2";
        cx.misplaced(s, &["y"], message, "take it out, or set dimension = 3");
    }
}

fn dimension(cx: &mut Checker<'_>, s: &mut Section<'_>) -> Option<usize> {
    let Some(node) = s.get("dimension") else {
        let help = "write dimension = 2 for a section in x and z, dimension = 3 for a volume";
        cx.missing(s, "dimension", help);
        return None;
    };
    let before = cx.found.len();
    let dimension = cx.whole_of(node, s.at("dimension"), 2, 3);
    if let (Value::Integer(1), Some(found)) = (&node.value, cx.found.get_mut(before)) {
        found.help = Some("a column is a scene without [domain]".to_owned());
    }
    dimension
}

/// Two numbers, the first below the second, or not above it where `flat` is allowed; the outer `None` is a mistake.
pub(super) fn range(
    cx: &mut Checker<'_>,
    s: &mut Section<'_>,
    key: &'static str,
    flat: bool,
) -> Option<Option<[f64; 2]>> {
    let Some(node) = s.get(key) else { return Some(None) };
    let [from, to] = cx.numbers::<2>(node, s.at(key), &COORDINATE)?;
    if from < to && to - from < SIZE_FROM && !flat {
        let message = format!("{key} spans less than {} m", plain(SIZE_FROM));
        cx.error(s.at(key), message, "give the least and the greatest coordinate in metres");
        return None;
    }
    if from < to || (flat && from <= to) {
        return Some(Some([from, to]));
    }
    let message = format!("{} m is not below {} m", plain(from), plain(to));
    cx.error(s.at(key), message, "write the smaller coordinate first");
    None
}

/// The mesh's path; the inner `None` is a box.
fn mesh(cx: &mut Checker<'_>, s: &mut Section<'_>) -> Option<Option<String>> {
    let Some(node) = s.get("mesh") else { return Some(None) };
    let file = cx.text_of(node, s.at("mesh"))?;
    if !file.ends_with(".msh") && !file.ends_with(".geo") {
        let message = format!("expected a Gmsh mesh (.msh) or script (.geo), found {file:?}");
        cx.error(s.at("mesh"), message, "write the mesh with Gmsh as MSH 4.1");
        return None;
    }
    local_file(cx, file, s.at("mesh")).map(Some)
}

/// A path relative to the scene's folder, of a file that is there.
fn local_file(cx: &mut Checker<'_>, file: &str, place: Place) -> Option<String> {
    match files::local(&cx.folder, file, "name the file") {
        Ok(()) => Some(file.to_owned()),
        Err(problem) => {
            cx.error(place, problem.message, problem.help.as_deref().unwrap_or_default());
            None
        }
    }
}

/// The path of the heights and the heights, read where the dimension is known.
fn topography(
    cx: &mut Checker<'_>,
    s: &mut Section<'_>,
    dimension: Option<usize>,
) -> Option<(Option<String>, Option<Topography>)> {
    let Some(node) = s.get("topography") else { return Some((None, None)) };
    let file = cx.text_of(node, s.at("topography"))?;
    let file = local_file(cx, file, s.at("topography"))?;
    let Some(dimension) = dimension else { return Some((Some(file), None)) };
    match Topography::read(&cx.folder.join(&file), dimension) {
        Ok(heights) => Some((Some(file), Some(heights))),
        Err((message, help)) => {
            cx.error(s.at("topography"), message, &help);
            None
        }
    }
}

/// Heights that leave a part of the box out.
fn covered(cx: &mut Checker<'_>, s: &Section<'_>, heights: &Topography, sides: [Option<[f64; 2]>; 2]) {
    for (axis, side) in sides.into_iter().enumerate() {
        if let Some(message) = side.and_then(|side| heights.uncovered(axis, side)) {
            cx.error(s.at("topography"), message, "give heights for all of the box, or make it smaller");
        }
    }
}

fn boundaries(
    cx: &mut Checker<'_>,
    s: &mut Section<'_>,
    dimension: Option<usize>,
    mesh: bool,
) -> Option<BTreeMap<String, BoundaryKind>> {
    if s.get("boundary").is_none() {
        return Some(BTreeMap::new());
    }
    let inner = cx.table(s, "boundary")?;
    let known = Domain::box_boundaries(dimension.unwrap_or(3));
    let read: Vec<Option<(String, BoundaryKind)>> = inner
        .entries()
        .map(|(name, node)| {
            let place = Place { path: join(&inner.place.path, name), at: node.at };
            if !mesh && !known.contains(&name) {
                let flat = ["y_min", "y_max"].contains(&name);
                let help = match nearest(name, known) {
                    _ if flat => "nothing varies along y at dimension 2".to_owned(),
                    Some(near) => format!("did you mean `{near}`?"),
                    None => format!("a box has {}", listed(known, "`").replace(" or ", " and ")),
                };
                cx.error(place, "unknown boundary", &help);
                return None;
            }
            cx.word_of::<BoundaryKind>(node, place).map(|kind| (name.to_owned(), kind))
        })
        .collect();
    read.into_iter().collect()
}

impl Read {
    /// Whether the scene is a column.
    pub(super) fn column(&self) -> bool {
        !self.given
    }

    /// Reports a range of the grid along an axis (0 = x, 1 = y, 2 = z) that reaches out of the box.
    pub(super) fn holds(&self, cx: &mut Checker<'_>, place: Place, axis: usize, range: [f64; 2]) {
        let height = self.heights.as_ref().map_or(0.0, |t| t.range().1);
        let side = match axis {
            2 => self.bottom.map(|bottom| [-bottom, height]),
            _ => self.sides[axis],
        };
        let Some([from, to]) = side else { return };
        let slack = 1e-9 * (to - from);
        if range[0] < from - slack || range[1] > to + slack {
            let [a, b, from, to] = [range[0], range[1], from, to].map(rounded);
            let message = format!("{a} m to {b} m reaches out of the domain, {from} m to {to} m");
            cx.error(place, message, "leave it out for the whole domain");
        }
    }

    /// The place of a source or a station: numbers under `key`, and a `depth` in place of the last of them.
    ///
    /// Returns `None` where there is a mistake, which has been reported.
    pub(super) fn place(
        &self,
        cx: &mut Checker<'_>,
        s: &mut Section<'_>,
        key: &'static str,
    ) -> Option<(Vec<f64>, Option<f64>)> {
        let depth = cx.optional(s, "depth", &Bounds::at_least(0.0, "m"));
        let Some(node) = s.get(key) else {
            let help = match self.dimension {
                Some(2) => format!("give `{key}` as [x, z], or as [x] with `depth`"),
                _ => format!("give `{key}` as [x, y, z], or as [x, y] with `depth`"),
            };
            cx.missing(s, key, &help);
            return None;
        };
        let numbers = coordinates(cx, node, s.at(key))?;
        let below = s.has("depth");
        if let Some(dimension) = self.dimension {
            counted(cx, s, key, numbers.len(), below, dimension)?;
        }
        let depth = depth?;
        self.inside(cx, s, key, &numbers, depth)?;
        Some((numbers, depth))
    }

    /// Reports a place outside of the box.
    fn inside(
        &self,
        cx: &mut Checker<'_>,
        s: &Section<'_>,
        key: &str,
        numbers: &[f64],
        depth: Option<f64>,
    ) -> Option<()> {
        let Some(dimension) = self.dimension.filter(|_| !self.mesh) else { return Some(()) };
        let mut good = true;
        for (axis, name) in ["x", "y"].into_iter().enumerate().take(dimension - 1) {
            let Some([from, to]) = self.sides[axis] else { continue };
            let (at, slack) = (numbers[axis], 1e-9 * (to - from));
            if at < from - slack || at > to + slack {
                let range = format!("{} m to {} m", plain(from), plain(to));
                let message = format!("{name} = {} m is outside of the domain, {range}", plain(at));
                cx.error(s.at(key), message, "");
                good = false;
            }
        }
        let Some(bottom) = self.bottom.filter(|_| good) else { return good.then_some(()) };
        let y = if dimension == 3 { numbers[1] } else { 0.0 };
        let height = self.heights.as_ref().map_or(0.0, |t| t.height(numbers[0], y));
        let slack = 1e-9 * bottom;
        let (z, key) = match depth {
            Some(depth) => (height - depth, "depth"),
            None => (numbers[dimension - 1], key),
        };
        if z < -bottom - slack {
            let message = match depth {
                Some(depth) => format!(
                    "{} m is below the domain's bottom at {} m",
                    plain(depth),
                    rounded(bottom + height)
                ),
                None => {
                    format!("z = {} m is below the domain's bottom at z = {} m", plain(z), rounded(-bottom))
                }
            };
            cx.error(s.at(key), message, "");
            return None;
        }
        if z > height + slack {
            let message = format!("z = {} m is above the surface at z = {} m", plain(z), rounded(height));
            cx.error(s.at(key), message, "z points up: a depth of 10 m is z = -10; or give `depth`");
            return None;
        }
        Some(())
    }
}

/// A list of coordinates.
pub(super) fn coordinates(cx: &mut Checker<'_>, node: &Node, place: Place) -> Option<Vec<f64>> {
    let Value::List(list) = &node.value else {
        cx.wrong_type(place, &node.value, "a list of coordinates", "");
        return None;
    };
    let numbers: Vec<Option<f64>> = (list.iter().enumerate())
        .map(|(i, n)| {
            let place = Place { path: format!("{}[{}]", place.path, i + 1), at: n.at };
            cx.number_of(n, place, &COORDINATE)
        })
        .collect();
    numbers.into_iter().collect()
}

/// Whether there are as many coordinates as there have to be; the last one gives way to a depth.
fn counted(
    cx: &mut Checker<'_>,
    s: &Section<'_>,
    key: &str,
    found: usize,
    below: bool,
    dimension: usize,
) -> Option<()> {
    let expected = dimension - usize::from(below);
    if found == expected {
        return Some(());
    }
    let (all, names) = if dimension == 2 { ("[x, z]", "[x]") } else { ("[x, y, z]", "[x, y]") };
    if below && found == dimension {
        let message = format!("{all} says where it is already; give z or `depth`");
        cx.error(s.at("depth"), message, "take one of the two out");
        return None;
    }
    let form = if below { format!("{names} beside `depth`") } else { all.to_owned() };
    let message = format!("expected {form} at dimension {dimension}, found {found} numbers");
    let help = if !below && found + 1 == dimension { "add z, or give `depth` below the surface" } else { "" };
    cx.error(s.at(key), message, help);
    None
}
