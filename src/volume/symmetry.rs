//! Planes of symmetry: where they lie, what part of a source the model carries, and what cannot stand on them.
//!
//! The ground on the other side of a plane with the unit normal n is the mirror image of the model: a vector a there is
//! (I − 2 n nᵀ) a, a tensor M is (I − 2 n nᵀ) M (I − 2 n nᵀ). A source on the plane is its own mirror image, so that its
//! force across the plane, n·f, and its moments between the normal and the plane, n·M·t, are the opposite of themselves: 0.

use crate::plan::PlanError;
use hati_inputs::scene::{BoundaryKind, Scene};
use hati_sem::solid::{FLAT, Ground, Probe};
use std::collections::HashSet;

/// A plane of symmetry: its boundary, a point of it, its normal, and the points of the ground on it.
#[derive(Debug, Clone, PartialEq)]
pub struct Plane {
    boundary: String,
    point: [f64; 3],
    normal: [f64; 3],
    pub(super) points: HashSet<u32>,
}

/// Weights of points beyond a plane below which a place is on it.
const ON_PLANE: f64 = 1e-4;
/// What may cross a plane, as a share of the source: round-off of a direction that the user computed.
const ACROSS: f64 = 1e-6;

/// The planes of symmetry of a ground, each once. Error: a boundary that is bent.
pub fn planes(scene: &Scene, ground: &Ground) -> Result<Vec<Plane>, PlanError> {
    let mut planes: Vec<Plane> = vec![];
    let mesh = ground.mesh();
    let length = length(ground);
    for boundary in mesh.boundaries.iter().filter(|b| !b.sides.is_empty()) {
        if scene.boundary_kind(&boundary.name) != BoundaryKind::Symmetry {
            continue;
        }
        let mean = ground.boundary_plane(&boundary.name)?;
        if !mean.is_flat() || mean.distance > 1e-6 * length {
            let (angle, distance) = (mean.angle.to_degrees(), mean.distance);
            return Err(PlanError::BentSymmetry { boundary: boundary.name.clone(), angle, distance });
        }
        let points: HashSet<u32> = ground.boundary_points(&boundary.name)?.into_iter().collect();
        // two boundaries may lie in one plane, which then halves a source once
        let same = |p: &&mut Plane| {
            norm(cross(p.normal, mean.normal)) <= 2.0 * FLAT && p.outside(mean.point).abs() <= 1e-6 * length
        };
        match planes.iter_mut().find(same) {
            Some(plane) => plane.points.extend(points),
            None => planes.push(Plane {
                boundary: boundary.name.clone(),
                point: mean.point,
                normal: mean.normal,
                points,
            }),
        }
    }
    Ok(planes)
}

/// Longest extent of a ground, m.
pub(super) fn length(ground: &Ground) -> f64 {
    let (min, max) = ground.mesh().extent();
    (0..3).map(|i| max[i] - min[i]).fold(0.0, f64::max)
}

impl Plane {
    /// Distance of a place beyond the plane, m; negative on the ground's side.
    pub(super) fn outside(&self, x: [f64; 3]) -> f64 {
        (0..3).map(|i| self.normal[i] * (x[i] - self.point[i])).sum()
    }

    /// Whether a place stands on the boundary itself, and not on its mere extension through the ground.
    pub(super) fn carries(&self, ground: &Ground, probe: &Probe) -> bool {
        let beyond: f64 =
            probe.weights.iter().filter(|w| !self.points.contains(&w.0)).map(|w| w.1.abs()).sum();
        self.outside(probe.position).abs() <= 1e-6 * ground.mesh().size(probe.element) && beyond <= ON_PLANE
    }

    /// A vector without its part across the plane.
    pub(super) fn along(&self, f: [f64; 3]) -> [f64; 3] {
        let across = dot(self.normal, f);
        std::array::from_fn(|i| f[i] - across * self.normal[i])
    }

    /// The part of a moment that its mirror image equals: $M - NM - MN + 2NMN$, $N = nn^T$.
    pub(super) fn mirrored(&self, m: [[f64; 3]; 3]) -> [[f64; 3]; 3] {
        let n = self.normal;
        let row = m.map(|row| dot(row, n));
        let both = dot(row, n);
        std::array::from_fn(|i| {
            std::array::from_fn(|j| m[i][j] - n[i] * row[j] - row[i] * n[j] + 2.0 * both * n[i] * n[j])
        })
    }

    /// Number of the axis that it is normal to, if it is to one.
    fn axis(&self) -> Option<usize> {
        self.normal.iter().position(|n| n.abs() > 1.0 - FLAT)
    }

    fn refuse(&self, source: &str, component: String) -> PlanError {
        let (source, boundary) = (source.to_owned(), self.boundary.clone());
        PlanError::AcrossSymmetry { source_name: source, boundary, normal: self.normal.map(tidy), component }
    }

    /// Refuses a force that crosses it.
    pub fn expect_along(&self, source: &str, force: [f64; 3]) -> Result<(), PlanError> {
        let across: f64 = (0..3).map(|i| self.normal[i] * force[i]).sum();
        if across.abs() <= ACROSS * norm(force) {
            return Ok(());
        }
        let component = match self.axis() {
            Some(axis) => format!("force along {} = {:.4e}", LETTERS[axis], force[axis]),
            None => format!("force along the normal = {across:.4e}"),
        };
        Err(self.refuse(source, component))
    }

    /// Refuses a moment mxx, myy, mzz, mxy, mxz, myz between the normal and the plane.
    pub fn expect_mirrored(&self, source: &str, moment: [f64; 6]) -> Result<(), PlanError> {
        let [xx, yy, zz, xy, xz, yz] = moment;
        let m = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]];
        let mn: [f64; 3] = [0, 1, 2].map(|i| (0..3).map(|j| m[i][j] * self.normal[j]).sum());
        let along: f64 = (0..3).map(|i| self.normal[i] * mn[i]).sum();
        let shear = norm([0, 1, 2].map(|i| mn[i] - along * self.normal[i]));
        let largest = moment.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        if shear <= ACROSS * largest {
            return Ok(());
        }
        let named = [("mxy", 0, 1, xy), ("mxz", 0, 2, xz), ("myz", 1, 2, yz)];
        let component = match self.axis() {
            Some(axis) => {
                let crosses = |i: usize, j: usize| (i == axis) != (j == axis);
                let worst = named.iter().filter(|(_, i, j, m)| crosses(*i, *j) && m.abs() > ACROSS * largest);
                let words: Vec<String> = worst.map(|(name, .., m)| format!("{name} = {m:.4e}")).collect();
                words.join(", ")
            }
            None => format!("moment between the normal and the plane = {shear:.4e}"),
        };
        Err(self.refuse(source, component))
    }
}

const LETTERS: [&str; 3] = ["x", "y", "z"];

/// A number for words: what round-off left of 0 or 1 is taken away.
fn tidy(x: f64) -> f64 {
    (x * 1e4).round() / 1e4 + 0.0
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|i| a[i] * b[i]).sum()
}

fn norm(a: [f64; 3]) -> f64 {
    a.iter().map(|x| x * x).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn unit(a: [f64; 3]) -> [f64; 3] {
        let length = norm(a);
        a.map(|x| x / length)
    }

    fn plane(normal: [f64; 3]) -> Plane {
        Plane { boundary: "mirror".into(), point: [0.0; 3], normal: unit(normal), points: HashSet::new() }
    }

    /// What mirroring leaves as it is passes; what it turns round does not, whatever way the plane stands.
    #[test]
    fn a_source_passes_where_it_is_its_own_mirror_image() {
        for normal in [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.3, -0.7, 0.2]] {
            let p = plane(normal);
            let n = p.normal;
            let mirror = |i: usize, j: usize| f64::from(u8::from(i == j)) - 2.0 * n[i] * n[j];
            for number in 0..9 {
                // unit vectors and tensors, and one of each that is symmetric to the plane
                let f = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], cross(n, [0.1, 0.5, 1.0])]
                    [number % 4];
                let image: Vec<f64> = (0..3).map(|i| (0..3).map(|j| mirror(i, j) * f[j]).sum()).collect();
                let same = (0..3).all(|i| (image[i] - f[i]).abs() < 1e-9);
                assert_eq!(p.expect_along("s", f).is_ok(), same, "{normal:?} {f:?}");
                let mut m = [0.0; 6];
                if number < 6 {
                    m[number] = 1.0
                } else {
                    m = [n[0] * n[0], n[1] * n[1], n[2] * n[2], n[0] * n[1], n[0] * n[2], n[1] * n[2]]
                }
                let full = [[m[0], m[3], m[4]], [m[3], m[1], m[5]], [m[4], m[5], m[2]]];
                let turned = |i: usize, j: usize| -> f64 {
                    (0..9).map(|k| mirror(i, k / 3) * full[k / 3][k % 3] * mirror(k % 3, j)).sum()
                };
                let same = (0..9).all(|k| (turned(k / 3, k % 3) - full[k / 3][k % 3]).abs() < 1e-9);
                assert_eq!(p.expect_mirrored("s", m).is_ok(), same, "{normal:?} {m:?}");
            }
        }
    }
}
