//! Meshes of simple bodies: a block of solids, a member cut into beams.

use crate::{
    FemError,
    element::{Beam, EndReleases, HEX_EDGES, Hex8, Hex20, TET_EDGES, Tet10},
    material::Material,
    model::{GroupId, Model},
    section::Section,
};
use std::collections::HashMap;

/// Nodes and elements of one kind, in Gmsh's node order.
#[derive(Debug, Clone, PartialEq)]
pub struct SolidMesh {
    /// Kind of the elements.
    pub kind: SolidKind,
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

impl SolidMesh {
    /// Adds nodes and elements to a group of `model`; returns the model's number of each node.
    ///
    /// Errors: elements that are inside out or folded (their nodes by the model's numbers), a node
    /// that the mesh does not have.
    pub fn add_to(
        &self,
        model: &mut Model,
        group: GroupId,
        material: Material,
    ) -> Result<Vec<usize>, FemError> {
        let number = model.add_nodes(&self.nodes);
        for local in &self.elements {
            if let Some(&node) = local.iter().find(|&&n| n >= number.len()) {
                let item = "an element of a mesh".into();
                return Err(FemError::UnknownNode { item, node, count: number.len() });
            }
            let nodes: Vec<usize> = local.iter().map(|&n| number[n]).collect();
            let at: Vec<[f64; 3]> = local.iter().map(|&n| self.nodes[n]).collect();
            match self.kind {
                SolidKind::Hex8 => model.add(group, Hex8::new(&nodes, &at, material)?),
                SolidKind::Hex20 => model.add(group, Hex20::new(&nodes, &at, material)?),
                SolidKind::Tet10 => model.add(group, Tet10::new(&nodes, &at, material)?),
            };
        }
        Ok(number)
    }
}

/// What a straight member of beams is made of.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Member {
    /// Section.
    pub section: Section,
    /// Material.
    pub material: Material,
    /// Direction that is up in the section, see [`Beam`].
    pub orientation: [f64; 3],
    /// Freedoms let go at the member's ends.
    pub releases: EndReleases,
}

impl Member {
    /// Adds a member from node to node of `model`, cut into `count` equal beams; returns its nodes in
    /// order, ends included.
    ///
    /// Errors: a node that is not there; those of [`Beam::new`] and [`Beam::with_releases`].
    pub fn add_to(
        &self,
        model: &mut Model,
        group: GroupId,
        ends: [usize; 2],
        count: usize,
    ) -> Result<Vec<usize>, FemError> {
        let known = model.nodes().len();
        if let Some(&node) = ends.iter().find(|&&n| n >= known) {
            return Err(FemError::UnknownNode { item: "a member".into(), node, count: known });
        }
        let points = subdivide(model.nodes()[ends[0]], model.nodes()[ends[1]], count);
        let last = points.len() - 1;
        let mut nodes = vec![ends[0]];
        nodes.extend(model.add_nodes(&points[1..last]));
        nodes.push(ends[1]);
        for (k, pair) in nodes.windows(2).enumerate() {
            let held = [false; 6];
            let releases = EndReleases {
                start: if k == 0 { self.releases.start } else { held },
                end: if k + 1 == last { self.releases.end } else { held },
            };
            let (pair, at) = ([pair[0], pair[1]], [points[k], points[k + 1]]);
            let beam = Beam::new(pair, at, self.orientation, self.section, self.material)?;
            model.add(group, beam.with_releases(releases)?);
        }
        Ok(nodes)
    }
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
        kind,
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
