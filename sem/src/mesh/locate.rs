//! Finding the element that holds a point, and the height of the surface.

use super::closest::Search;
use super::tree::Tree;
use super::{Boundary, Mesh, Side, axes};
use crate::SemError;

/// Distance from the mesh, as a share of the nearest element's size, within which a point still counts as
/// on its surface: a sensor asked for 1e-9 m above the ground is on the ground.
pub const OUTSIDE_TOLERANCE: f64 = 1e-6;

/// How far beyond ±1 a local coordinate is still the side itself.
const SIDE_TOLERANCE: f64 = 1e-9;

/// A point of the mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Located {
    /// Element that holds it, the lowest where several share it.
    pub element: usize,
    /// Its local coordinates, each in [−1, 1]; the third is 0 at D = 2.
    pub local: [f64; 3],
    /// Its position, m: the one asked for, or the nearest one of the mesh.
    pub position: [f64; 3],
}

/// Finds points in a mesh: a tree of bounding boxes, then Newton's method in the elements that remain.
///
/// Building costs $O(n\log n)$, a point $O(\log n)$. At D = 2 the y of a point does not count.
pub struct Locator<'a> {
    mesh: &'a Mesh,
    tree: Tree,
    top: Option<Surface<'a>>,
}

impl<'a> Locator<'a> {
    /// Prepares a mesh that [`check`](super::check) accepts.
    pub fn new(mesh: &'a Mesh) -> Self {
        let boxes: Vec<_> = (0..mesh.len()).map(|e| mesh.bounds(e, OUTSIDE_TOLERANCE)).collect();
        let top = mesh.boundary("top").map(|b| Surface::of(mesh, b));
        Self { mesh, tree: Tree::new(&boxes), top }
    }

    /// The element that holds a point. On a shared side, edge or corner it is the lowest of those that
    /// share it; within [`OUTSIDE_TOLERANCE`] of the mesh it is the nearest point of the surface.
    ///
    /// Error: farther outside; the text gives the distance, the nearest point and the mesh's extent.
    pub fn find(&self, point: [f64; 3]) -> Result<Located, SemError> {
        let outside = |distance, nearest| {
            let (min, max) = self.mesh.extent();
            SemError::OutsideMesh { point, distance, nearest, min, max }
        };
        if let Some(located) = self.inside(point) {
            return Ok(located);
        }
        let Some((located, distance)) = self.nearest(point) else {
            return Err(outside(f64::NAN, [f64::NAN; 3]));
        };
        if distance <= OUTSIDE_TOLERANCE * self.mesh.size(located.element) {
            return Ok(located);
        }
        Err(outside(distance, located.position))
    }

    /// The lowest element that holds a point, sides included; `None` outside.
    pub fn inside(&self, point: [f64; 3]) -> Option<Located> {
        let mesh = self.mesh;
        let asked = if mesh.dimension == 2 { [point[0], 0.0, point[2]] } else { point };
        let mut found: Option<(usize, [f64; 3])> = None;
        self.tree.at(asked, &mut |item| {
            let element = item as usize;
            if found.is_some_and(|f| f.0 <= element) {
                return;
            }
            let (min, max) = mesh.bounds(element, OUTSIDE_TOLERANCE);
            if (0..3).any(|i| asked[i] < min[i] || asked[i] > max[i]) {
                return;
            }
            let Some(local) = mesh.inverse_map(element, asked) else { return };
            // far from the origin the coordinates' own round-off is what ±1 can be told to
            let reach = 1.0 + SIDE_TOLERANCE.max(4.0 * mesh.resolution(element) / mesh.size(element));
            if local[..mesh.dimension].iter().all(|v| v.abs() <= reach) {
                found = Some((element, local.map(|v| v.clamp(-1.0, 1.0))));
            }
        });
        found.map(|(element, local)| Located { element, local, position: mesh.position(element, local) })
    }

    /// The nearest point of the mesh and its distance, m; `None` if the mesh is empty or the point not
    /// finite. At equal distance the lowest element.
    pub fn nearest(&self, point: [f64; 3]) -> Option<(Located, f64)> {
        let mesh = self.mesh;
        let asked = if mesh.dimension == 2 { [point[0], 0.0, point[2]] } else { point };
        if !asked.iter().all(|v| v.is_finite()) {
            return None;
        }
        let mut best: Option<(usize, [f64; 3], f64)> = None;
        self.tree.nearest(asked, &mut |item| {
            let element = item as usize;
            let (local, distance) = mesh.closest(element, asked, Search { held: None, vertical: true });
            if best.is_none_or(|b| distance < b.2 || distance <= b.2 && element < b.0) {
                best = Some((element, local, distance));
            }
            // boxes are a little larger than their elements
            distance + 2.0 * OUTSIDE_TOLERANCE * mesh.size(element)
        });
        let (element, local, distance) = best?;
        Some((Located { element, local, position: mesh.position(element, local) }, distance))
    }

    /// The point of the boundary `top` at x, y (x alone at D = 2): see [`Surface::find`].
    ///
    /// Errors: no boundary `top`; x, y outside it.
    pub fn find_on_surface(&self, x: f64, y: f64) -> Result<Located, SemError> {
        match &self.top {
            Some(top) => top.find(x, y),
            None => Err(SemError::NoBoundary { name: "top".into(), known: boundary_names(self.mesh) }),
        }
    }
}

/// Finds points of a boundary by a vertical ray: the height of the topography, the seat of a surface sensor.
pub struct Surface<'a> {
    mesh: &'a Mesh,
    name: &'a str,
    sides: Vec<Side>,
    tree: Tree,
}

impl<'a> Surface<'a> {
    /// Prepares a boundary. Error: the mesh has none of that name.
    pub fn new(mesh: &'a Mesh, name: &str) -> Result<Self, SemError> {
        let none = || SemError::NoBoundary { name: name.into(), known: boundary_names(mesh) };
        Ok(Self::of(mesh, mesh.boundary(name).ok_or_else(none)?))
    }

    fn of(mesh: &'a Mesh, boundary: &'a Boundary) -> Self {
        let centre = |s: &Side| mesh.side_normal(*s, mesh.side_local(*s, [0.0; 2]));
        // upright sides (a quay wall) have no height at a point of the plan
        let upright = |s: &Side| {
            let n = centre(s);
            n[2].abs() <= 1e-9 * (n[0] * n[0] + n[1] * n[1] + n[2] * n[2]).sqrt()
        };
        let mut sides: Vec<Side> = boundary.sides.iter().copied().filter(|s| !upright(s)).collect();
        sides.sort_unstable();
        let boxes: Vec<_> = sides.iter().map(|s| mesh.side_bounds_in_plan(*s)).collect();
        Self { mesh, name: &boundary.name, sides, tree: Tree::new(&boxes) }
    }

    /// The point of the boundary at x, y (x alone at D = 2), the highest where several lie above each
    /// other, the lowest element where several share it. Upright sides are passed over. Within
    /// [`OUTSIDE_TOLERANCE`] beside the boundary it is the nearest point of its rim.
    ///
    /// Error: x, y farther outside.
    pub fn find(&self, x: f64, y: f64) -> Result<Located, SemError> {
        let mesh = self.mesh;
        let asked = [x, if mesh.dimension == 2 { 0.0 } else { y }, 0.0];
        let mut hit: Option<Located> = None;
        let mut least = (f64::INFINITY, [f64::NAN; 3]);
        let mut visit = |item: u32| {
            let side = self.sides[item as usize];
            let element = side.element as usize;
            let (local, distance) = self.closest(side, asked);
            let position = mesh.position(element, local);
            if distance < least.0 {
                least = (distance, position);
            }
            let size = mesh.size(element);
            if distance <= OUTSIDE_TOLERANCE * size {
                let higher = |h: &Located| {
                    let rise = position[2] - h.position[2];
                    rise > SIDE_TOLERANCE * size || rise.abs() <= SIDE_TOLERANCE * size && element < h.element
                };
                if hit.as_ref().is_none_or(higher) {
                    hit = Some(Located { element, local, position });
                }
            }
            distance + 2.0 * OUTSIDE_TOLERANCE * size
        };
        self.tree.at(asked, &mut |item| {
            visit(item);
        });
        if let Some(located) = hit {
            return Ok(located);
        }
        if asked.iter().all(|v| v.is_finite()) {
            self.tree.nearest(asked, &mut |item| {
                let side = self.sides[item as usize];
                let (local, distance) = self.closest(side, asked);
                if distance < least.0 {
                    least = (distance, mesh.position(side.element as usize, local));
                }
                distance
            });
        }
        Err(SemError::OutsideBoundary { name: self.name.into(), x, y, distance: least.0, nearest: least.1 })
    }

    fn closest(&self, side: Side, point: [f64; 3]) -> ([f64; 3], f64) {
        let search = Search { held: Some((side.axis(), side.end())), vertical: false };
        self.mesh.closest(side.element as usize, point, search)
    }
}

fn boundary_names(mesh: &Mesh) -> Vec<String> {
    mesh.boundaries.iter().map(|b| b.name.clone()).collect()
}

impl Mesh {
    /// Least and greatest coordinates of all nodes, m.
    pub fn extent(&self) -> ([f64; 3], [f64; 3]) {
        let mut extent = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for x in &self.nodes {
            for i in 0..3 {
                extent.0[i] = extent.0[i].min(x[i]);
                extent.1[i] = extent.1[i].max(x[i]);
            }
        }
        extent
    }

    /// Box around a side's plan; z is 0.
    fn side_bounds_in_plan(&self, side: Side) -> ([f64; 3], [f64; 3]) {
        let element = side.element as usize;
        let whole = self.bounds(element, OUTSIDE_TOLERANCE);
        if self.order == 2 {
            return ([whole.0[0], whole.0[1], 0.0], [whole.1[0], whole.1[1], 0.0]);
        }
        let margin = OUTSIDE_TOLERANCE * self.size(element) + self.resolution(element);
        let mut bounds = ([f64::INFINITY, f64::INFINITY, 0.0], [f64::NEG_INFINITY, f64::NEG_INFINITY, 0.0]);
        for node in self.side_nodes(side) {
            let x = self.nodes[node as usize];
            for &i in axes(self.dimension).iter().filter(|&&i| i < 2) {
                bounds.0[i] = bounds.0[i].min(x[i] - margin);
                bounds.1[i] = bounds.1[i].max(x[i] + margin);
            }
        }
        if self.dimension == 2 {
            (bounds.0[1], bounds.1[1]) = (0.0, 0.0);
        }
        bounds
    }
}
