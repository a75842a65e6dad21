//! Tetrahedron of 10 nodes.

use super::{Point, SolidShape, quadrature};

/// Quadratic tetrahedron of 10 nodes, 14 quadrature points, pure displacement.
///
/// Does not lock in bending. As $\nu \to ½$ it keeps converging in displacement, but it is stiffer than
/// at moderate $\nu$ (at 0.4999 a thin cantilever of flat cells, ten times longer than thick, loses 7 %;
/// five times, 0.6 %), and its pressures oscillate: prefer hex20 there.
/// Nodes in Gmsh's order. Order 3 in displacement, 4 in frequency.
#[derive(Debug, Clone, Copy)]
pub struct Tet10Shape;

const NODES: [[f64; 3]; 10] = [
    [0.0, 0.0, 0.0],
    [1.0, 0.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, 0.0, 1.0],
    [0.5, 0.0, 0.0],
    [0.5, 0.5, 0.0],
    [0.0, 0.5, 0.0],
    [0.0, 0.0, 0.5],
    [0.0, 0.5, 0.5],
    [0.5, 0.0, 0.5],
];

/// Ends of the edges, in Gmsh's order.
pub(crate) const EDGES: [[usize; 2]; 6] = [[0, 1], [1, 2], [2, 0], [3, 0], [3, 2], [3, 1]];

/// Gradients of the four barycentric coordinates.
const SLOPES: [[f64; 3]; 4] = [[-1.0, -1.0, -1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

fn barycentric(xi: [f64; 3]) -> [f64; 4] {
    [1.0 - xi[0] - xi[1] - xi[2], xi[0], xi[1], xi[2]]
}

impl SolidShape for Tet10Shape {
    const NAME: &'static str = "tet10";
    const NODES: usize = 10;
    const LUMPED_BY_ROWS: bool = false;

    fn reference() -> &'static [[f64; 3]] {
        &NODES
    }

    fn centre() -> [f64; 3] {
        [0.25; 3]
    }

    fn values(xi: [f64; 3]) -> Vec<f64> {
        let l = barycentric(xi);
        let corners = l.iter().map(|&v| v * (2.0 * v - 1.0));
        corners.chain(EDGES.iter().map(|&[a, b]| 4.0 * l[a] * l[b])).collect()
    }

    fn gradients(xi: [f64; 3]) -> Vec<[f64; 3]> {
        let l = barycentric(xi);
        let corner = |a: usize| SLOPES[a].map(|s| s * (4.0 * l[a] - 1.0));
        let edge =
            |&[a, b]: &[usize; 2]| [0, 1, 2].map(|i| 4.0 * (l[a] * SLOPES[b][i] + l[b] * SLOPES[a][i]));
        (0..4).map(corner).chain(EDGES.iter().map(edge)).collect()
    }

    fn rule() -> &'static [Point] {
        &quadrature::TETRAHEDRON_14
    }

    fn mass_rule() -> &'static [Point] {
        &quadrature::TETRAHEDRON_14
    }
}
