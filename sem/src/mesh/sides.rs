//! Sides of elements: their nodes, their local points, their normals and which elements share them.

use super::{Mesh, Side, axes, inverse};

/// Stands in a side's corners at D = 2, where there are two.
pub(crate) const NO_NODE: u32 = u32::MAX;

/// A side of an element with the key that neighbours share.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct KeyedSide {
    /// Corner nodes in rising order; [`NO_NODE`] behind the two of D = 2.
    pub(crate) key: [u32; 4],
    /// The side.
    pub(crate) side: Side,
}

impl Side {
    /// Local axis that the side is normal to, 0 to D − 1.
    pub fn axis(self) -> usize {
        usize::from(self.side / 2)
    }

    /// Local coordinate of the side on that axis, −1 or +1.
    pub fn end(self) -> f64 {
        if self.side & 1 == 0 { -1.0 } else { 1.0 }
    }
}

impl Mesh {
    /// Sides of an element, $2D$.
    pub fn sides_per_element(&self) -> usize {
        2 * self.dimension
    }

    /// Geometric nodes of a side, $(g+1)^{D-1}$, the lower of its local axes running fastest.
    pub fn side_nodes(&self, side: Side) -> impl Iterator<Item = u32> + '_ {
        let (n, d) = (self.order + 1, self.dimension);
        let (axis, end) = (side.axis(), usize::from(side.side % 2));
        let nodes = self.element(side.element as usize);
        let stride = n.pow(axis as u32);
        (0..n.pow(d as u32 - 1)).map(move |k| {
            // the digits below the side's axis stay, the others move up by one place
            nodes[k % stride + end * (n - 1) * stride + k / stride * stride * n]
        })
    }

    /// Corner nodes of a side in the order of [`Self::side_nodes`]; at D = 2 the last two are `u32::MAX`.
    pub fn side_corners(&self, side: Side) -> [u32; 4] {
        let g = self.order;
        let mut corners = [NO_NODE; 4];
        let wanted = [0, g, g * (g + 1), g * (g + 2)];
        for (k, node) in self.side_nodes(side).enumerate() {
            if let Some(c) = wanted.iter().take(1 << (self.dimension - 1)).position(|&w| w == k) {
                corners[c] = node;
            }
        }
        corners
    }

    /// Local point of an element on one of its sides, from the coordinates in the side, the lower local
    /// axis first; the second is not used at D = 2.
    pub fn side_local(&self, side: Side, in_side: [f64; 2]) -> [f64; 3] {
        let mut local = [0.0; 3];
        let mut rest = in_side.into_iter();
        for a in 0..self.dimension {
            local[a] = if a == side.axis() { side.end() } else { rest.next().unwrap_or(0.0) };
        }
        local
    }

    /// Outward normal of a side at a local point on it, times the ratio of the side's area to that of
    /// [−1, 1]² (m²), of its length to that of [−1, 1] at D = 2 (m):
    /// $n\,\mathrm{d}A = \pm\det J\;\nabla\xi_a\;\mathrm{d}\xi_b\,\mathrm{d}\xi_c$.
    pub fn side_normal(&self, side: Side, local: [f64; 3]) -> [f64; 3] {
        let (inverse, det) = inverse(&self.jacobian(side.element as usize, local));
        let row = axes(self.dimension)[side.axis()];
        inverse[row].map(|g| side.end() * det * g)
    }

    /// Every side of every element, sorted so that sides with the same corners stand together.
    pub(crate) fn keyed_sides(&self) -> Vec<KeyedSide> {
        let mut sides = Vec::with_capacity(self.len() * self.sides_per_element());
        for element in 0..self.len() as u32 {
            for side in 0..self.sides_per_element() as u8 {
                let side = Side { element, side };
                let mut key = self.side_corners(side);
                key.sort_unstable();
                sides.push(KeyedSide { key, side });
            }
        }
        sides.sort_unstable();
        sides
    }

    /// Sides that belong to one element alone, in the order of the elements: the surface of the mesh.
    ///
    /// Cost: sorts all sides, $O(n\log n)$.
    pub fn outer_sides(&self) -> Vec<Side> {
        let sides = self.keyed_sides();
        let groups = sides.chunk_by(|a, b| a.key == b.key);
        let mut outer: Vec<Side> = groups.filter(|g| g.len() == 1).map(|g| g[0].side).collect();
        outer.sort_unstable();
        outer
    }
}
