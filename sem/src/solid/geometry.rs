//! Geometry factors of elements: as few numbers as the shape allows.
//!
//! | shape | kept per element (D = 3) | metric $B$ | weight $s$ |
//! |---|---|---|---|
//! | affine | 9 | $\sqrt{\lvert J\rvert}\,J^{-1}$ | $w$ |
//! | straight edges (quad4, hex8) | 21 coefficients of the map | $\lvert J\rvert J^{-1}$, from cross products | $w/\lvert J\rvert$ |
//! | curved (quad9, hex27) | 9 per point | $\sqrt{w\lvert J\rvert}\,J^{-1}$ | 1 |

use super::kernel::axis_count;
use crate::gll::Gll;
use crate::mesh::{Mesh, determinant, inverse};

/// How the metric of an element is found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Metric {
    /// The same at every point.
    Affine,
    /// From the map of straight edges, at every step anew.
    Corners,
    /// Kept at every point.
    Stored,
}

/// Metric of a batch, lanes side by side.
#[derive(Debug, Clone, Copy)]
pub(super) struct MetricLanes<'a, V> {
    pub kind: Metric,
    pub values: &'a [V],
}

impl Metric {
    /// The leanest shape that holds for an element: its map is compared with the affine and the straight
    /// one at its geometric nodes; differences up to 1e-9 of the element's size (meshers leave
    /// some 1e-12 of the whole mesh's), or up to the round-off of its coordinates, are none.
    pub fn of(mesh: &Mesh, element: usize) -> Self {
        let a = coefficients(mesh, element);
        let tolerance = (1e-9 * mesh.size(element)).max(8.0 * mesh.resolution(element));
        let straight = mesh.order == 1 || is_straight(mesh, element, &a, tolerance);
        let linear = mesh.dimension;
        let bent = a[linear..].iter().flatten().fold(0.0_f64, |m, x| m.max(x.abs()));
        match (straight, bent <= tolerance) {
            (true, true) => Self::Affine,
            (true, false) => Self::Corners,
            _ => Self::Stored,
        }
    }

    /// Numbers kept per element.
    pub(super) fn values(self, planes: usize, points: usize) -> usize {
        let axes = axis_count(planes);
        match self {
            // nine at D = 2 too, so that the kernel sees one shape
            Self::Affine => 9,
            Self::Corners if planes == 1 => 6,
            Self::Corners => 21,
            Self::Stored => axes * axes * points,
        }
    }

    /// Writes the numbers of an element.
    pub(super) fn fill(self, mesh: &Mesh, element: usize, gll: &Gll, values: &mut Vec<f64>) {
        let axes = crate::mesh::axes(mesh.dimension);
        let (n, d) = (gll.len(), mesh.dimension);
        let mut put = |j: &[[f64; 3]; 3], scale: f64| {
            let (inverse, _) = inverse(j);
            for a in axes {
                values.extend(axes.iter().map(|x| scale * inverse[*a][*x]));
            }
        };
        match self {
            Self::Affine => {
                let j = mesh.jacobian(element, [0.0; 3]);
                put(&j, determinant(&j).sqrt());
                values.resize(values.len() + 9 - d * d, 0.0);
            }
            Self::Corners => {
                let a = coefficients(mesh, element);
                for row in &a[..(1 << d) - 1] {
                    values.extend(axes.iter().map(|x| row[*x]));
                }
            }
            Self::Stored => {
                for p in 0..n.pow(d as u32) {
                    let (local, w) = point(gll, d, p);
                    let j = mesh.jacobian(element, local);
                    put(&j, (w * determinant(&j)).sqrt());
                }
            }
        }
    }
}

/// Local coordinates and weight of point p of an element.
pub(super) fn point(gll: &Gll, dimension: usize, p: usize) -> ([f64; 3], f64) {
    let n = gll.len();
    let (mut local, mut weight) = ([0.0; 3], 1.0);
    for (a, x) in local.iter_mut().enumerate().take(dimension) {
        let i = p / n.pow(a as u32) % n;
        *x = gll.points[i];
        weight *= gll.weights[i];
    }
    (local, weight)
}

/// Coefficients of the bi- or trilinear map of the corners, without the constant: ξ, η, ξη at D = 2;
/// ξ, η, ζ, ξη, ηζ, ζξ, ξηζ at D = 3.
fn coefficients(mesh: &Mesh, element: usize) -> [[f64; 3]; 7] {
    let d = mesh.dimension;
    let terms: &[usize] = if d == 2 { &[1, 2, 3] } else { &[1, 2, 4, 3, 6, 5, 7] };
    let mut a = [[0.0; 3]; 7];
    let centre = mesh.centre(element);
    for (corner, node) in mesh.corners(element).enumerate() {
        // from the centre, so that large coordinates lose no digits
        let x: [f64; 3] = std::array::from_fn(|i| mesh.nodes[node as usize][i] - centre[i]);
        for (row, bits) in a.iter_mut().zip(terms) {
            let minus = (!corner & bits).count_ones() % 2 == 1;
            let sign = if minus { -1.0 } else { 1.0 } / f64::from(1u32 << d);
            (0..3).for_each(|i| row[i] += sign * x[i]);
        }
    }
    a
}

fn is_straight(mesh: &Mesh, element: usize, a: &[[f64; 3]; 7], tolerance: f64) -> bool {
    let d = mesh.dimension;
    let centre = mesh.centre(element);
    (0..3_usize.pow(d as u32)).all(|p| {
        let [x, y, z] = [p % 3, p / 3 % 3, p / 9].map(|i| i as f64 - 1.0);
        let terms = if d == 2 {
            [x, y, x * y, 0.0, 0.0, 0.0, 0.0]
        } else {
            [x, y, z, x * y, y * z, z * x, x * y * z]
        };
        let exact = mesh.position(element, [x, y, if d == 3 { z } else { 0.0 }]);
        (0..3).all(|i| {
            let straight: f64 = centre[i] + a.iter().zip(terms).map(|(a, t)| a[i] * t).sum::<f64>();
            (straight - exact[i]).abs() <= tolerance
        })
    })
}
