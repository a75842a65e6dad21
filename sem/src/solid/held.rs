//! What supports hold: directions of points, planes of boundaries, and what of a force they take away.

use super::ground::Ground;
use crate::SemError;
use nalgebra::{Matrix3, SymmetricEigen, Vector3};

/// Largest angle between the normals of one plane and their mean, rad: meshers leave some 1e-9 in the coordinates, text
/// files of seven digits some 1e-6.
pub const FLAT: f64 = 1e-5;

/// Squared share of a unit displacement below which a direction counts as held.
const HELD: f64 = 1e-8;

/// Supports of one point.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Held {
    /// Directions along which it does not move, orthonormal.
    pub directions: Vec<[f64; 3]>,
    /// Dashpot to the ground, N·s/m.
    pub dashpot: [[f64; 3]; 3],
}

/// The mean plane of a boundary.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BoundaryPlane {
    /// Mean of the boundary's points by their areas, m.
    pub point: [f64; 3],
    /// Mean of the outward normals by their areas, length 1.
    pub normal: [f64; 3],
    /// Largest angle between it and the normal at a point, rad.
    pub angle: f64,
    /// Largest distance of a point from the plane, m.
    pub distance: f64,
}

impl BoundaryPlane {
    /// Whether the sides face one way, up to round-off in their coordinates ([`FLAT`]).
    pub fn is_flat(&self) -> bool {
        self.angle <= FLAT
    }
}

impl Held {
    /// Adds a direction unless it is held already; two planes whose normals differ by 2 [`FLAT`] or less are one.
    pub(super) fn hold(&mut self, direction: [f64; 3]) {
        let mut rest = direction;
        for held in &self.directions {
            let along = dot(rest, *held);
            (0..3).for_each(|i| rest[i] -= along * held[i]);
        }
        let length = norm(rest);
        if length > 2.0 * FLAT {
            self.directions.push(rest.map(|x| x / length));
        }
    }

    /// Adds the directions across a unit vector.
    pub(super) fn hold_across(&mut self, n: [f64; 3]) {
        let least = (0..3).min_by(|&a, &b| n[a].abs().total_cmp(&n[b].abs())).unwrap_or(0);
        let first = cross(n, std::array::from_fn(|x| f64::from(x == least)));
        let first = first.map(|x| x / norm(first));
        self.hold(first);
        self.hold(cross(n, first));
    }

    /// Projection onto the directions that are not held.
    pub(super) fn free(&self) -> Matrix3<f64> {
        let mut free = Matrix3::identity();
        for n in &self.directions {
            let n = Vector3::from(*n);
            free -= n * n.transpose();
        }
        free
    }
}

impl Ground {
    /// Mean plane of a boundary. Error: no boundary of that name.
    pub fn boundary_plane(&self, boundary: &str) -> Result<BoundaryPlane, SemError> {
        let mut points = vec![];
        for side in self.sides(boundary)? {
            let locals = self.side_locals(side);
            let at = locals.into_iter().map(|local| self.mesh().position(side.element as usize, local));
            points.extend(at.zip(self.side_areas(side).into_iter().map(|(_, area)| area)));
        }
        let (mut sum, mut mean, mut total) = ([0.0; 3], [0.0; 3], 0.0);
        let origin = points.first().map_or([0.0; 3], |p| p.0);
        for (x, area) in &points {
            let size = norm(*area);
            total += size;
            (0..3).for_each(|i| sum[i] += area[i]);
            (0..3).for_each(|i| mean[i] += size * (x[i] - origin[i]));
        }
        // opposite sides in one boundary have no mean normal: the first one then shows how far apart they are
        if norm(sum) <= 1e-9 * total {
            sum = points.first().map_or([0.0, 0.0, 1.0], |p| p.1);
        }
        let normal = sum.map(|x| x / norm(sum));
        let point = std::array::from_fn(|i| origin[i] + mean[i] / total);
        let (mut angle, mut distance) = (0.0_f64, 0.0_f64);
        for (x, area) in &points {
            angle = angle.max(norm(cross(normal, *area)).atan2(dot(normal, *area)));
            let offset: [f64; 3] = std::array::from_fn(|i| x[i] - point[i]);
            distance = distance.max(dot(normal, offset).abs());
        }
        Ok(BoundaryPlane { point, normal, angle, distance })
    }

    /// Part of a force spread over points that supports take up, whatever the points do: with $P_i$ the projection onto
    /// the free directions of point i, its component in the null space of $\sum w_i^2P_i$.
    ///
    /// `weights` are those of a [`super::Probe`], or of one side under a traction. Beside a held point nothing is lost:
    /// the place can move.
    pub fn lost(&self, weights: &[(u32, f64)], force: [f64; 3]) -> [f64; 3] {
        let (mut sum, mut total) = (Matrix3::zeros(), 0.0);
        for (point, w) in weights {
            total += w * w;
            sum += w * w * self.held.get(point).map_or_else(Matrix3::identity, Held::free);
        }
        let mut lost = Vector3::zeros();
        if total > 0.0 {
            let modes = SymmetricEigen::new(sum / total);
            for (value, mode) in modes.eigenvalues.iter().zip(modes.eigenvectors.column_iter()) {
                if *value <= HELD {
                    lost += mode * mode.dot(&Vector3::from(force));
                }
            }
        }
        lost.into()
    }

    /// Force at a point without what its support takes up.
    pub fn released(&self, point: u32, force: [f64; 3]) -> [f64; 3] {
        self.held.get(&point).map_or(force, |held| (held.free() * Vector3::from(force)).into())
    }
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|i| a[i] * b[i]).sum()
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn norm(x: [f64; 3]) -> f64 {
    dot(x, x).sqrt()
}
