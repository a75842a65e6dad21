//! What a mesh must be before anything is computed on it.

use super::sides::{KeyedSide, NO_NODE};
use super::{Locator, Mesh, Side, axes, determinant};
use crate::SemError;
use crate::gll::Gll;

/// Least scaled Jacobian of a valid element. A box has 1; an element that has collapsed to a wedge has 0,
/// but for round-off.
pub const LEAST_SCALED_JACOBIAN: f64 = 1e-6;

/// How far outside a side, in local coordinates, no other element may lie.
const STEP_OUTSIDE: f64 = 1e-6;

/// An element and a value of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Extreme {
    /// Element, the lowest of several.
    pub element: usize,
    /// Mean of its corners, m.
    pub centre: [f64; 3],
    /// Value.
    pub value: f64,
}

/// Facts about a mesh that passed its [`check`].
#[derive(Debug, Clone, PartialEq)]
pub struct MeshReport {
    /// Least coordinates of the nodes, m.
    pub min: [f64; 3],
    /// Greatest coordinates of the nodes, m.
    pub max: [f64; 3],
    /// Shortest straight line between neighbouring corners of an element, m.
    pub edge_min: Extreme,
    /// Longest such line, m.
    pub edge_max: Extreme,
    /// Greatest ratio of the longest to the shortest of them in one element.
    pub aspect_max: Extreme,
    /// Least scaled Jacobian at the points checked, $\det J/\prod_a |\partial x/\partial\xi_a|$: 1 for a
    /// box, the sine of the angle for a parallelogram.
    pub scaled_jacobian_min: Extreme,
    /// Elements whose map is affine ([`Mesh::is_affine`]).
    pub affine: usize,
    /// Sides that belong to one element alone.
    pub outer_sides: usize,
    /// Of these, the ones that are in no named boundary.
    pub unnamed_sides: usize,
}

/// Checks a mesh for elements of a polynomial order, and reports its sizes.
///
/// - every list has the length that the others ask for; nodes, materials and sides exist; coordinates are
///   finite (and y = 0 at D = 2);
/// - the Jacobian is positive at the GLL points of `order` in every element: scaled, it must be above
///   [`LEAST_SCALED_JACOBIAN`];
/// - a side belongs to one element, or to two that share all of its nodes and lie on either side of it;
/// - no other element lies immediately outside a side that belongs to one element: that would be a hanging
///   node, or two blocks that touch without sharing nodes;
/// - a named boundary consists of outer sides.
///
/// Errors: the first fault, with element and place. Cost: $O(n\log n)$ for the sides, and for deformed
/// elements the Jacobian at $(N+1)^D$ points.
pub fn check(mesh: &Mesh, order: usize) -> Result<MeshReport, SemError> {
    let gll = Gll::new(order)?;
    check_lists(mesh)?;
    check_numbers(mesh)?;
    let jacobians = Jacobians::new(mesh, &gll);
    let start = |value| Extreme { element: 0, centre: [0.0; 3], value };
    let (min, max) = mesh.extent();
    let mut report = MeshReport {
        min,
        max,
        edge_min: start(f64::INFINITY),
        edge_max: start(0.0),
        aspect_max: start(0.0),
        scaled_jacobian_min: start(f64::INFINITY),
        affine: 0,
        outer_sides: 0,
        unnamed_sides: 0,
    };
    for element in 0..mesh.len() {
        let affine = mesh.is_affine(element);
        let scaled = jacobians.least_scaled(mesh, element, affine);
        let centre = mesh.centre(element);
        if scaled.is_nan() || scaled <= LEAST_SCALED_JACOBIAN {
            return Err(SemError::Jacobian { element, centre, value: scaled });
        }
        let (short, long) = edges(mesh, element);
        report.affine += usize::from(affine);
        let at = |value| Extreme { element, centre, value };
        keep_least(&mut report.edge_min, at(short));
        keep_greatest(&mut report.edge_max, at(long));
        keep_greatest(&mut report.aspect_max, at(long / short));
        keep_least(&mut report.scaled_jacobian_min, at(scaled));
    }
    let outer = check_sides(mesh)?;
    report.unnamed_sides = check_boundaries(mesh, &outer)?;
    report.outer_sides = outer.len();
    check_outside(mesh, &outer)?;
    Ok(report)
}

fn keep_least(extreme: &mut Extreme, candidate: Extreme) {
    if candidate.value < extreme.value {
        *extreme = candidate;
    }
}

fn keep_greatest(extreme: &mut Extreme, candidate: Extreme) {
    if candidate.value > extreme.value {
        *extreme = candidate;
    }
}

impl Mesh {
    /// Whether an element's map is affine, so that one Jacobian matrix serves all of its points: no node
    /// is off the affine map through the corners by more than 1e-12 of the element's size, or twice the
    /// round-off of its coordinates.
    pub fn is_affine(&self, element: usize) -> bool {
        let (d, g) = (self.dimension, self.order);
        let nodes = self.element(element);
        let origin = self.nodes[nodes[0] as usize];
        let half = 0.5f64.powi(d as i32);
        let mut mean = [0.0; 3];
        let mut slope = [[0.0; 3]; 3];
        for (corner, node) in self.corners(element).enumerate() {
            for i in 0..3 {
                let dx = half * (self.nodes[node as usize][i] - origin[i]);
                mean[i] += dx;
                (0..d).for_each(|a| slope[a][i] += if corner >> a & 1 == 1 { dx } else { -dx });
            }
        }
        let tolerance = 1e-12 * self.size(element) + 2.0 * self.resolution(element);
        nodes.iter().enumerate().all(|(k, &node)| {
            let local = |a: usize| 2.0 * ((k / (g + 1).pow(a as u32) % (g + 1)) as f64) / g as f64 - 1.0;
            (0..3).all(|i| {
                let affine = mean[i] + (0..d).map(|a| slope[a][i] * local(a)).sum::<f64>();
                (self.nodes[node as usize][i] - origin[i] - affine).abs() <= tolerance
            })
        })
    }
}

/// Lengths of the lists, dimension and order.
fn check_lists(mesh: &Mesh) -> Result<(), SemError> {
    if !(2..=3).contains(&mesh.dimension) {
        return Err(SemError::Dimension(mesh.dimension));
    }
    if !(1..=2).contains(&mesh.order) {
        return Err(SemError::GeometryOrder(mesh.order));
    }
    let expected = mesh.len().saturating_mul(mesh.nodes_per_element());
    if mesh.is_empty() || mesh.elements.len() != expected || mesh.nodes.len() >= u32::MAX as usize {
        let (elements, found) = (mesh.len(), mesh.elements.len());
        return Err(SemError::MeshLists { elements, expected, found, nodes: mesh.nodes.len() });
    }
    Ok(())
}

/// Indices and coordinates.
fn check_numbers(mesh: &Mesh) -> Result<(), SemError> {
    let nodes = mesh.nodes.len();
    for (node, &position) in mesh.nodes.iter().enumerate() {
        let section = mesh.dimension == 3 || position[1] == 0.0;
        if !position.iter().all(|v| v.is_finite()) || !section {
            return Err(SemError::NodePosition { node, position });
        }
    }
    for element in 0..mesh.len() {
        if let Some(&node) = mesh.element(element).iter().find(|&&n| n as usize >= nodes) {
            return Err(SemError::NodeIndex { element, node, nodes });
        }
    }
    let materials = mesh.materials.len();
    let bad = mesh.material.iter().position(|&m| m as usize >= materials);
    if let Some(element) = bad {
        let (centre, material) = (mesh.centre(element), mesh.material[element]);
        return Err(SemError::MaterialIndex { element, centre, material, materials });
    }
    for boundary in &mesh.boundaries {
        let sides = mesh.sides_per_element();
        let exists = |s: &Side| (s.element as usize) < mesh.len() && usize::from(s.side) < sides;
        if let Some(bad) = boundary.sides.iter().find(|s| !exists(s)) {
            let (name, element, side) = (boundary.name.clone(), bad.element, bad.side);
            return Err(SemError::SideIndex { name, element, side, elements: mesh.len(), sides });
        }
    }
    Ok(())
}

/// Gradients of the shape functions at the points where Jacobians are asked for.
struct Jacobians {
    /// `[point][node]`, each in the columns of [`Mesh::jacobian`].
    gradients: Vec<[f64; 3]>,
    per_point: usize,
}

impl Jacobians {
    fn new(mesh: &Mesh, gll: &Gll) -> Self {
        let (n, d) = (gll.len(), mesh.dimension);
        let mut gradients = vec![];
        for k in 0..n.pow(d as u32) {
            let mut local = [0.0; 3];
            (0..d).for_each(|a| local[a] = gll.points[k / n.pow(a as u32) % n]);
            mesh.for_each_node(0, local, |_, _, gradient| {
                let mut columns = [0.0; 3];
                axes(d).iter().zip(gradient).for_each(|(&c, g)| columns[c] = g);
                gradients.push(columns);
            });
        }
        Self { gradients, per_point: mesh.nodes_per_element() }
    }

    /// Least scaled Jacobian of an element; one point is enough where the map is affine. Not a number
    /// counts as least.
    fn least_scaled(&self, mesh: &Mesh, element: usize, affine: bool) -> f64 {
        let mut x = [[0.0; 3]; 27];
        let nodes = mesh.element(element);
        let origin = mesh.nodes[nodes[0] as usize];
        for (x, &node) in x.iter_mut().zip(nodes) {
            (0..3).for_each(|i| x[i] = mesh.nodes[node as usize][i] - origin[i]);
        }
        let mut least = f64::INFINITY;
        for gradients in self.gradients.chunks_exact(self.per_point) {
            let mut jacobian = [[0.0; 3]; 3];
            for (x, gradient) in x.iter().zip(gradients) {
                for i in 0..3 {
                    (0..3).for_each(|c| jacobian[i][c] += gradient[c] * x[i]);
                }
            }
            if mesh.dimension == 2 {
                jacobian[1][1] = 1.0;
            }
            let squared = |c: usize| jacobian[0][c].powi(2) + jacobian[1][c].powi(2) + jacobian[2][c].powi(2);
            let scaled = determinant(&jacobian) / (squared(0).sqrt() * squared(1).sqrt() * squared(2).sqrt());
            if scaled.is_nan() || scaled < least {
                least = scaled;
            }
            if affine || least.is_nan() {
                break;
            }
        }
        least
    }
}

/// Shortest and longest straight line between neighbouring corners.
fn edges(mesh: &Mesh, element: usize) -> (f64, f64) {
    let mut corners = [[0.0; 3]; 8];
    for (c, node) in corners.iter_mut().zip(mesh.corners(element)) {
        *c = mesh.nodes[node as usize];
    }
    let (mut short, mut long) = (f64::INFINITY, 0.0f64);
    for c in 0..1usize << mesh.dimension {
        for other in (0..mesh.dimension).map(|a| c | 1 << a).filter(|&o| o != c) {
            let length = (0..3).map(|i| (corners[c][i] - corners[other][i]).powi(2)).sum::<f64>().sqrt();
            short = short.min(length);
            long = long.max(length);
        }
    }
    (short, long)
}

/// Every side has one element, or two that fit; returns those with one, in the order of the elements.
fn check_sides(mesh: &Mesh) -> Result<Vec<Side>, SemError> {
    let sides = mesh.keyed_sides();
    let mut outer = vec![];
    for group in sides.chunk_by(|a, b| a.key == b.key) {
        match group {
            [one] => outer.push(one.side),
            [one, two] => check_pair(mesh, one, two)?,
            _ => {
                let elements = group.iter().map(|s| s.side.element).collect();
                return Err(SemError::SideShared { elements, centre: side_centre(mesh, group[0].side) });
            }
        }
    }
    outer.sort_unstable();
    Ok(outer)
}

/// Two elements at one side: the same nodes in the same places, and one on either side of it.
fn check_pair(mesh: &Mesh, one: &KeyedSide, two: &KeyedSide) -> Result<(), SemError> {
    let (a, b) = (mesh.side_corners(one.side), mesh.side_corners(two.side));
    // in a quadrilateral the corner opposite to the first must be the same for both
    let opposite = |c: [u32; 4]| {
        let first = c.iter().position(|&node| node == one.key[0]).unwrap_or(0);
        c[3 - first]
    };
    let mut fits = a[2] == NO_NODE || opposite(a) == opposite(b);
    if fits && mesh.order == 2 {
        let sorted = |side| {
            let mut nodes: Vec<u32> = mesh.side_nodes(side).collect();
            nodes.sort_unstable();
            nodes
        };
        fits = sorted(one.side) == sorted(two.side);
    }
    let normal = |s: Side| mesh.side_normal(s, mesh.side_local(s, [0.0; 2]));
    let (m, n) = (normal(one.side), normal(two.side));
    let facing = m[0] * n[0] + m[1] * n[1] + m[2] * n[2] < 0.0;
    let elements = [one.side.element, two.side.element];
    match (fits, facing) {
        (false, _) => Err(SemError::SideTwisted { elements, centre: side_centre(mesh, one.side) }),
        (true, false) => Err(SemError::ElementsOverlap { elements, centre: side_centre(mesh, one.side) }),
        (true, true) => Ok(()),
    }
}

fn side_centre(mesh: &Mesh, side: Side) -> [f64; 3] {
    mesh.position(side.element as usize, mesh.side_local(side, [0.0; 2]))
}

/// Named sides are outer ones; returns how many outer ones no name has.
fn check_boundaries(mesh: &Mesh, outer: &[Side]) -> Result<usize, SemError> {
    let mut named = vec![false; outer.len()];
    for boundary in &mesh.boundaries {
        for side in &boundary.sides {
            match outer.binary_search(side) {
                Ok(k) => named[k] = true,
                Err(_) => {
                    let (name, element) = (boundary.name.clone(), side.element);
                    return Err(SemError::BoundaryInside { name, element, centre: side_centre(mesh, *side) });
                }
            }
        }
    }
    Ok(named.iter().filter(|named| !**named).count())
}

/// Nothing lies immediately outside the outer sides.
fn check_outside(mesh: &Mesh, outer: &[Side]) -> Result<(), SemError> {
    let locator = Locator::new(mesh);
    // places in the side that are unlikely to be an edge of whatever touches it
    let places = [[0.317, -0.229], [-0.671, 0.587], [0.731, 0.673], [-0.419, -0.743]];
    for &side in outer {
        let element = side.element as usize;
        for place in &places[..if mesh.dimension == 2 { 2 } else { 4 }] {
            let mut local = mesh.side_local(side, *place);
            // far from the origin a smaller step would be lost in the coordinates' round-off
            let coarse = 64.0 * mesh.resolution(element) / edges(mesh, element).0;
            local[side.axis()] *= 1.0 + STEP_OUTSIDE.max(coarse);
            let point = mesh.position(element, local);
            if let Some(other) = locator.inside(point).filter(|l| l.element != element) {
                return Err(SemError::SidesUnmatched {
                    elements: [side.element, other.element as u32],
                    centre: side_centre(mesh, side),
                });
            }
        }
    }
    Ok(())
}
