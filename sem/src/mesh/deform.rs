//! Deforming a mesh by a map or at random: for tests and benchmarks.

use super::{Mesh, determinant};

impl Mesh {
    /// Moves every node to where a map takes it, x → `map(x)`, m. For tests, benchmarks and geometries
    /// that are easier to bend than to mesh.
    ///
    /// Nothing is checked: [`check`](super::check) tells whether the elements are still valid. At D = 2 the
    /// map must leave y at 0.
    pub fn deform(&mut self, map: impl Fn([f64; 3]) -> [f64; 3]) {
        self.nodes.iter_mut().for_each(|x| *x = map(*x));
    }

    /// Moves the interior corner nodes at random, for benchmarks and tests: along each edge of the
    /// smallest element that meets there by up to ± `fraction` of that edge, uniformly. The surface stays.
    ///
    /// This is no shear: nearly every element loses its affine map. Edges stay straight (at order 2 the
    /// nodes between the corners follow them). Elements of a box stay valid up to a fraction of about 0.2.
    /// The same seed gives the same mesh on every machine.
    pub fn move_interior_nodes(&mut self, fraction: f64, seed: u64) {
        let fixed = self.surface_nodes();
        let smallest = self.smallest_element_at_corners();
        let mut random = SplitMix(seed);
        let mut shift = vec![[0.0; 3]; self.nodes.len()];
        for (node, &(element, corner)) in smallest.iter().enumerate() {
            if fixed[node] || element == u32::MAX {
                continue;
            }
            let element = element as usize;
            for axis in 0..self.dimension {
                let other = self.corner_node(element, corner as usize ^ (1 << axis));
                let part = fraction * random.symmetric();
                for i in 0..3 {
                    shift[node][i] += part * (self.nodes[other as usize][i] - self.nodes[node][i]);
                }
            }
        }
        if self.order == 2 {
            self.spread_to_middle_nodes(&mut shift);
        }
        for (x, s) in self.nodes.iter_mut().zip(&shift) {
            (0..3).for_each(|i| x[i] += s[i]);
        }
    }

    /// Whether each node lies on the surface of the mesh.
    fn surface_nodes(&self) -> Vec<bool> {
        let mut on_surface = vec![false; self.nodes.len()];
        for side in self.outer_sides() {
            self.side_nodes(side).for_each(|node| on_surface[node as usize] = true);
        }
        on_surface
    }

    /// Element of least volume at each corner node, the lowest where several are equal, and which of its
    /// corners that is; `u32::MAX` for a node that is no corner.
    fn smallest_element_at_corners(&self) -> Vec<(u32, u8)> {
        let mut volume = vec![f64::INFINITY; self.nodes.len()];
        let mut found = vec![(u32::MAX, 0); self.nodes.len()];
        for element in 0..self.len() {
            let det = determinant(&self.jacobian(element, [0.0; 3]));
            for (corner, node) in self.corners(element).enumerate() {
                // equal but for round-off is equal: the choice must not depend on the machine's
                if det < volume[node as usize] * (1.0 - 1e-9) {
                    volume[node as usize] = det;
                    found[node as usize] = (element as u32, corner as u8);
                }
            }
        }
        found
    }

    fn corner_node(&self, element: usize, corner: usize) -> u32 {
        let (g, d) = (self.order, self.dimension);
        self.element(element)[(0..d).rev().fold(0, |i, a| i * (g + 1) + g * (corner >> a & 1))]
    }

    /// Gives nodes between the corners the mean of the shifts of the corners that they lie between.
    fn spread_to_middle_nodes(&self, shift: &mut [[f64; 3]]) {
        let d = self.dimension;
        for element in 0..self.len() {
            for (k, &node) in self.element(element).iter().enumerate() {
                let digit = |a: usize| k / 3usize.pow(a as u32) % 3;
                if (0..d).all(|a| digit(a) != 1) {
                    continue;
                }
                let between = |c: &usize| (0..d).all(|a| digit(a) == 1 || digit(a) / 2 == c >> a & 1);
                let corners = (0..1usize << d).filter(between);
                let (mut sum, mut count) = ([0.0; 3], 0.0);
                for corner in corners {
                    let s = shift[self.corner_node(element, corner) as usize];
                    (0..3).for_each(|i| sum[i] += s[i]);
                    count += 1.0;
                }
                shift[node as usize] = sum.map(|s| s / count);
            }
        }
    }
}

/// Steele, Lea and Flood's SplitMix64 generator (2014): one multiply-and-shift chain per number.
struct SplitMix(u64);

impl SplitMix {
    /// Uniform in [−1, 1).
    fn symmetric(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^= z >> 31;
        (z >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
}
