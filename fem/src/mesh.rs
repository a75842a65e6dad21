//! Meshes of simple bodies: a block of solids, a member cut into beams.

use crate::element::{HEX_EDGES, TET_EDGES};
use std::collections::HashMap;

/// Nodes and elements of one kind, in Gmsh's node order.
#[derive(Debug, Clone, PartialEq)]
pub struct SolidMesh {
    /// Positions, m.
    pub nodes: Vec<[f64; 3]>,
    /// Nodes of each element.
    pub elements: Vec<Vec<usize>>,
}

/// Kind of solid to fill a block with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SolidKind {
    /// Hexahedra of 8 nodes.
    Hex8,
    /// Hexahedra of 20 nodes.
    Hex20,
    /// Tetrahedra of 10 nodes, six to a cell.
    Tet10,
}

/// Corners of a cell as steps along x, y, z, in Gmsh's order.
const CORNERS: [[usize; 3]; 8] =
    [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]];

/// Six tetrahedra about the diagonal from corner 0 to corner 6; neighbouring cells match.
const TETRAHEDRA: [[usize; 4]; 6] =
    [[0, 1, 2, 6], [0, 2, 3, 6], [0, 3, 7, 6], [0, 7, 4, 6], [0, 4, 5, 6], [0, 5, 1, 6]];

/// The unit cube cut into `counts` cells along x, y, z, its nodes then moved by `map` (m).
///
/// Nodes on edges are those of the map itself, so that a curved map gives curved elements; numbered in
/// order of z, y, x of the reference cube.
pub fn block(kind: SolidKind, counts: [usize; 3], map: impl Fn([f64; 3]) -> [f64; 3]) -> SolidMesh {
    // places on a grid of half steps: corners are even, middles of edges odd
    let mut elements: Vec<Vec<[usize; 3]>> = vec![];
    for k in 0..counts[2] {
        for j in 0..counts[1] {
            for i in 0..counts[0] {
                let corners = CORNERS.map(|c| [2 * (i + c[0]), 2 * (j + c[1]), 2 * (k + c[2])]);
                elements.extend(cell(kind, &corners));
            }
        }
    }
    let mut places: Vec<[usize; 3]> = elements.iter().flatten().copied().collect();
    places.sort_by_key(|p| [p[2], p[1], p[0]]);
    places.dedup();
    let number: HashMap<[usize; 3], usize> = places.iter().enumerate().map(|(n, p)| (*p, n)).collect();
    let position = |p: &[usize; 3]| map([0, 1, 2].map(|i| p[i] as f64 / (2 * counts[i]) as f64));
    SolidMesh {
        nodes: places.iter().map(position).collect(),
        elements: elements.iter().map(|e| e.iter().map(|p| number[p]).collect()).collect(),
    }
}

fn cell(kind: SolidKind, corners: &[[usize; 3]; 8]) -> Vec<Vec<[usize; 3]>> {
    let middle = |a: [usize; 3], b: [usize; 3]| [0, 1, 2].map(|i| (a[i] + b[i]) / 2);
    match kind {
        SolidKind::Hex8 => vec![corners.to_vec()],
        SolidKind::Hex20 => {
            let edges = HEX_EDGES.iter().map(|e| middle(corners[e[0]], corners[e[1]]));
            vec![corners.iter().copied().chain(edges).collect()]
        }
        SolidKind::Tet10 => {
            let tetrahedron = |t: &[usize; 4]| {
                let c = t.map(|a| corners[a]);
                c.into_iter().chain(TET_EDGES.iter().map(|e| middle(c[e[0]], c[e[1]]))).collect()
            };
            TETRAHEDRA.iter().map(tetrahedron).collect()
        }
    }
}

/// Points that cut the straight line from `start` to `end` into `count` equal parts, ends included.
pub fn subdivide(start: [f64; 3], end: [f64; 3], count: usize) -> Vec<[f64; 3]> {
    let share = |k: usize| k as f64 / count.max(1) as f64;
    (0..=count.max(1)).map(|k| [0, 1, 2].map(|i| start[i] * (1.0 - share(k)) + end[i] * share(k))).collect()
}
