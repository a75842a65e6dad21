//! Numbers of the GLL points of a mesh: elements that share a corner, an edge or a face share its points.
//!
//! Points are told apart by the corners of the edge or face they lie on, never by coordinates, so no
//! tolerance is needed. A point inside an edge is counted from the corner of the lower number; one inside
//! a face from its lowest corner, first towards the lower of that corner's two neighbours.

use crate::mesh::Mesh;
use std::collections::HashMap;

/// GLL points of every element.
#[derive(Debug, Clone)]
pub struct Numbering {
    /// Polynomial order N.
    pub order: usize,
    /// Points per element, $(N+1)^D$.
    pub points: usize,
    /// Points in all.
    pub nodes: usize,
    /// Point of each element's local points, `[element][ζ][η][ξ]`, ξ fastest.
    pub connectivity: Vec<u32>,
}

impl Numbering {
    /// Numbers the points of order `order`; points are met in the order of the elements.
    pub fn new(mesh: &Mesh, order: usize) -> Self {
        let (n, d) = (order + 1, mesh.dimension);
        let points = n.pow(d as u32);
        let mut connectivity = Vec::with_capacity(points * mesh.len());
        let mut corners: HashMap<u32, u32> = HashMap::with_capacity(mesh.nodes.len());
        let mut edges: HashMap<[u32; 2], u32> = HashMap::with_capacity(3 * mesh.len());
        let mut faces: HashMap<[u32; 4], u32> = HashMap::with_capacity(3 * mesh.len());
        let mut next = 0u32;
        let mut take = |count: usize| {
            let first = next;
            next += count as u32;
            first
        };
        let mut corner = vec![0u32; 1 << d];
        let inner = order.saturating_sub(1);
        for element in 0..mesh.len() {
            corner.iter_mut().zip(mesh.corners(element)).for_each(|(slot, id)| *slot = id);
            let own = take(inner.pow(d as u32));
            for point in 0..points {
                let index = [point % n, point / n % n, point / (n * n)];
                let free: Vec<usize> = (0..d).filter(|&a| index[a] % order != 0).collect();
                let fixed = (0..d).filter(|&a| index[a] == order).fold(0, |bits, a| bits | 1 << a);
                let id = match free[..] {
                    [] => *corners.entry(corner[fixed]).or_insert_with(|| take(1)),
                    [a] if d > 1 => {
                        let (from, to) = (corner[fixed], corner[fixed | 1 << a]);
                        let base = *edges.entry([from.min(to), from.max(to)]).or_insert_with(|| take(inner));
                        let along = if from < to { index[a] } else { order - index[a] };
                        base + along as u32 - 1
                    }
                    [a, b] if d == 3 => {
                        let ids = [0, 1 << a, 1 << b, 1 << a | 1 << b].map(|bits| corner[fixed | bits]);
                        let mut key = ids;
                        key.sort_unstable();
                        let base = *faces.entry(key).or_insert_with(|| take(inner * inner));
                        base + within_face(ids, order, [index[a], index[b]]) as u32
                    }
                    _ => own + free.iter().rev().fold(0, |i, &a| i * inner + index[a] - 1) as u32,
                };
                connectivity.push(id);
            }
        }
        Self { order, points, nodes: next as usize, connectivity }
    }

    /// Points of an element.
    pub fn element(&self, element: usize) -> &[u32] {
        &self.connectivity[element * self.points..(element + 1) * self.points]
    }

    /// Local points of a side (see [`crate::mesh::Side`]), the lower free axis fastest.
    pub fn side_points(&self, side: u8) -> Vec<usize> {
        let n = self.order + 1;
        let d = if self.points == n * n { 2 } else { 3 };
        let (axis, at) = (usize::from(side / 2), usize::from(side % 2) * self.order);
        (0..self.points).filter(|&p| p / n.pow(axis as u32) % n == at).take(n.pow(d - 1)).collect()
    }
}

/// Place of a face's inner point in the frame that both neighbours agree on; `corners` at (0,0), (1,0),
/// (0,1), (1,1) of the face's two axes.
fn within_face(corners: [u32; 4], order: usize, index: [usize; 2]) -> usize {
    let lowest = (0..4).min_by_key(|&i| corners[i]).unwrap_or(0);
    let turned = |axis: usize| if lowest >> axis & 1 == 1 { order - index[axis] } else { index[axis] };
    let (s, t) = (turned(0), turned(1));
    let (s, t) = if corners[lowest ^ 1] < corners[lowest ^ 2] { (s, t) } else { (t, s) };
    (t - 1) * (order - 1) + s - 1
}
