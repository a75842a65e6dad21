//! Linear cells between the points of spectral elements.

use std::collections::HashMap;

/// Coordinates that a variable over time and nodes names.
pub(super) const COORDINATES: &str = "elapsed_time mesh_node_x mesh_node_y mesh_node_z";
/// Those of a variable over nodes.
pub(super) const STATIC_COORDINATES: &str = "mesh_node_x mesh_node_y mesh_node_z";

/// Points, and the edges, quadrilaterals or hexahedra between them.
#[derive(Debug, Clone, PartialEq)]
pub struct Cells {
    /// 1 edges, 2 quadrilaterals, 3 hexahedra.
    pub dimension: usize,
    /// Coordinates x, y, z, m.
    pub points: Vec<[f64; 3]>,
    /// Corners of every cell, $2^\text{dimension}$ each, indices into `points`: of a quadrilateral around
    /// it, of a hexahedron around its lower face and then around its upper one.
    pub corners: Vec<u32>,
}

/// Corners of a quadrilateral or hexahedron in the order of [`Cells::corners`]; bit `a` is the step along axis `a`.
const AROUND: [usize; 8] = [0, 1, 3, 2, 4, 5, 7, 6];

impl Cells {
    /// Cuts every spectral element, or side of one, into linear cells at its GLL points.
    ///
    /// - `dimension`: that of the elements (sides): 1, 2 or 3;
    /// - `n`: points along an edge, at least 2;
    /// - `points`: numbers of the points of every element, $n^\text{dimension}$ each, the first local axis
    ///   fastest; a number may be any;
    /// - `position`: coordinates of a numbered point, m.
    ///
    /// Returns the cells, whose points are numbered from 0 in the order in which they first appear, and
    /// the caller's number of each of them: the order of the values in a row.
    ///
    /// # Panics
    /// If `points` is no multiple of $n^\text{dimension}$, or a dimension or `n` is out of range.
    #[must_use]
    pub fn of_elements(
        dimension: usize,
        n: usize,
        points: &[u32],
        mut position: impl FnMut(u32) -> [f64; 3],
    ) -> (Self, Vec<u32>) {
        assert!((1..=3).contains(&dimension) && n >= 2, "elements of dimension {dimension} with {n} points");
        let per_element = n.pow(dimension as u32);
        assert_eq!(points.len() % per_element, 0, "points of whole elements");
        let mut numbers = HashMap::with_capacity(points.len());
        let mut originals = vec![];
        let local: Vec<u32> = (points.iter())
            .map(|&point| {
                *numbers.entry(point).or_insert_with(|| {
                    originals.push(point);
                    originals.len() as u32 - 1
                })
            })
            .collect();
        let places = originals.iter().map(|&point| position(point)).collect();
        let template = template(dimension, n);
        let corners = local
            .chunks(per_element)
            .flat_map(|element| template.iter().map(|&corner| element[corner]))
            .collect();
        (Self { dimension, points: places, corners }, originals)
    }

    /// Number of cells.
    #[must_use]
    pub fn len(&self) -> usize {
        self.corners.len() >> self.dimension
    }

    /// Whether there is no cell.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.corners.is_empty()
    }
}

/// Corners of the cells of one element, as places among its points.
fn template(dimension: usize, n: usize) -> Vec<usize> {
    let cells = (n - 1).pow(dimension as u32);
    let stride = |axis: usize| n.pow(axis as u32);
    let mut corners = Vec::with_capacity(cells << dimension);
    for cell in 0..cells {
        let first: usize = (0..dimension).map(|a| cell / (n - 1).pow(a as u32) % (n - 1) * stride(a)).sum();
        for step in &AROUND[..1 << dimension] {
            corners.push(first + (0..dimension).map(|a| (step >> a & 1) * stride(a)).sum::<usize>());
        }
    }
    corners
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Volume of a hexahedron with plane faces, from the corners' order.
    fn volume(p: &[[f64; 3]]) -> f64 {
        let edge = |to: usize| -> [f64; 3] { std::array::from_fn(|a| p[to][a] - p[0][a]) };
        let (u, v, w) = (edge(1), edge(3), edge(4));
        let cross = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
        cross.iter().zip(w).map(|(a, b)| a * b).sum()
    }

    #[test]
    fn hexahedra_fill_two_elements() {
        let n = 4;
        // Two unit cubes side by side along x; the second one shares a face.
        let at = |i: usize, j: usize, k: usize| (1000 + i + 7 * j + 28 * k) as u32;
        let mut points = vec![];
        for element in 0..2 {
            for (k, j, i) in (0..64).map(|p| (p / 16, p / 4 % 4, p % 4)) {
                points.push(at(element * 3 + i, j, k));
            }
        }
        let position = |p: u32| {
            let p = (p - 1000) as usize;
            [(p % 7) as f64 / 3.0, (p / 7 % 4) as f64 / 3.0, (p / 28) as f64 / 3.0]
        };
        let (cells, originals) = Cells::of_elements(3, n, &points, position);
        assert_eq!(cells.len(), 54);
        assert_eq!(cells.points.len(), 7 * 16, "shared points stand once");
        assert!(originals.iter().zip(&cells.points).all(|(&o, p)| position(o) == *p));
        let volumes: Vec<f64> = (cells.corners.chunks(8))
            .map(|cell| volume(&cell.iter().map(|&c| cells.points[c as usize]).collect::<Vec<_>>()))
            .collect();
        assert!(volumes.iter().all(|v| (v * 27.0 - 1.0).abs() < 1e-12), "{volumes:?}");
    }

    #[test]
    fn quadrilaterals_turn_one_way() {
        let points: Vec<u32> = (0..9).collect();
        let (cells, _) = Cells::of_elements(2, 3, &points, |p| [f64::from(p % 3), 0.0, f64::from(p / 3)]);
        assert_eq!(cells.corners[..4], [0, 1, 4, 3]);
        assert_eq!(cells.len(), 4);
        let (edges, _) = Cells::of_elements(1, 3, &points, |p| [f64::from(p), 0.0, 0.0]);
        assert_eq!(edges.corners, [0, 1, 1, 2, 3, 4, 4, 5, 6, 7, 7, 8]);
    }
}
