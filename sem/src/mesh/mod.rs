//! Meshes of quadrilaterals (D = 2, a section in x–z) and hexahedra (D = 3).
//!
//! A [`Mesh`] is geometry alone: corner or second-order nodes, elements, the material of each, named
//! boundaries. The spectral elements' own points are numbered on top of it by [`crate::numbering`].
//!
//! Node order of an element is that of a tensor product, the first local axis ξ running fastest: a
//! hexahedron of 8 nodes has them at (ξ, η, ζ) = (−,−,−), (+,−,−), (−,+,−), (+,+,−), (−,−,+), …; one of
//! 27 nodes has ξ = −1, 0, +1 in turn. Side `2 a` of an element lies at −1 of its local axis `a`, side
//! `2 a + 1` at +1. The local axes of a valid element are right-handed (positive Jacobian); at D = 2 they
//! turn from x to z.

mod check;
mod closest;
mod deform;
mod geometry;
mod layered_box;
mod locate;
mod order;
mod sides;
mod size;
mod tree;

pub use check::{Extreme, LEAST_SCALED_JACOBIAN, MeshReport, check};
pub use geometry::{determinant, inverse};
pub use layered_box::{BoxLayer, HeightGrid, LEAST_REMAINING, LayeredBox};
pub use locate::{Located, Locator, OUTSIDE_TOLERANCE, Surface};
pub use size::{Resolution, element_width, layer_heights};

/// Global axes along which a field of dimension D varies: x and z at D = 2, all three at D = 3.
pub fn axes(dimension: usize) -> &'static [usize] {
    if dimension == 2 { &[0, 2] } else { &[0, 1, 2] }
}

/// A side of an element.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Side {
    /// Element.
    pub element: u32,
    /// `2 a` at −1 of local axis `a`, `2 a + 1` at +1.
    pub side: u8,
}

/// A named part of the surface.
#[derive(Debug, Clone, PartialEq)]
pub struct Boundary {
    /// Name, for instance `top` or a Gmsh physical group's.
    pub name: String,
    /// Its sides.
    pub sides: Vec<Side>,
}

/// Quadrilaterals or hexahedra of geometric order 1 (straight edges) or 2 (curved).
#[derive(Debug, Clone, PartialEq)]
pub struct Mesh {
    /// D: 2 or 3.
    pub dimension: usize,
    /// Order of the geometry: 1 (quad4, hex8) or 2 (quad9, hex27).
    pub order: usize,
    /// Coordinates x, y, z of the geometric nodes, m; y = 0 at D = 2.
    pub nodes: Vec<[f64; 3]>,
    /// Geometric nodes of every element, [`Self::nodes_per_element`] each, ξ fastest.
    pub elements: Vec<u32>,
    /// Material of every element, an index into [`Self::materials`].
    pub material: Vec<u32>,
    /// Names of the materials.
    pub materials: Vec<String>,
    /// Named boundaries.
    pub boundaries: Vec<Boundary>,
}

impl Mesh {
    /// Number of elements.
    pub fn len(&self) -> usize {
        self.material.len()
    }

    /// Whether there is no element.
    pub fn is_empty(&self) -> bool {
        self.material.is_empty()
    }

    /// $(g+1)^D$ for a geometry of order $g$.
    pub fn nodes_per_element(&self) -> usize {
        (self.order + 1).pow(self.dimension as u32)
    }

    /// Geometric nodes of an element.
    pub fn element(&self, element: usize) -> &[u32] {
        let n = self.nodes_per_element();
        &self.elements[element * n..(element + 1) * n]
    }

    /// Corners of an element, $2^D$, ξ fastest.
    pub fn corners(&self, element: usize) -> impl Iterator<Item = u32> + '_ {
        let (g, d) = (self.order, self.dimension);
        let nodes = self.element(element);
        (0..1usize << d).map(move |corner| {
            let index = (0..d).rev().fold(0, |i, a| i * (g + 1) + g * (corner >> a & 1));
            nodes[index]
        })
    }

    /// Mean of the corners, m.
    pub fn centre(&self, element: usize) -> [f64; 3] {
        let mut sum = [0.0; 3];
        let count = (1usize << self.dimension) as f64;
        for node in self.corners(element) {
            (0..3).for_each(|a| sum[a] += self.nodes[node as usize][a] / count);
        }
        sum
    }

    /// The boundary of a name.
    pub fn boundary(&self, name: &str) -> Option<&Boundary> {
        self.boundaries.iter().find(|b| b.name == name)
    }
}
