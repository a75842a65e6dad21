//! An order of elements in which neighbours in space are neighbours in memory.

use super::Mesh;

/// Bits per axis of the curve's grid.
const BITS: u32 = 16;

impl Mesh {
    /// Elements along a Hilbert curve through their centres; the curve fills the mesh's own extents, so
    /// that a box of 2^k elements per axis is cut into cubes of elements by cutting the order evenly.
    pub fn curve_order(&self) -> Vec<u32> {
        let axes = super::axes(self.dimension);
        let centres: Vec<[f64; 3]> = (0..self.len()).map(|e| self.centre(e)).collect();
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for node in &self.nodes {
            for a in 0..3 {
                low[a] = low[a].min(node[a]);
                high[a] = high[a].max(node[a]);
            }
        }
        let cell = |x: &[f64; 3], a: usize| {
            let span = (high[a] - low[a]).max(f64::MIN_POSITIVE);
            let scaled = (x[a] - low[a]) / span * f64::from(1u32 << BITS);
            scaled.clamp(0.0, f64::from((1u32 << BITS) - 1)) as u32
        };
        let mut keyed: Vec<(u64, u32)> = (centres.iter().zip(0u32..))
            .map(|(x, e)| match axes {
                [a, b] => (hilbert([cell(x, *a), cell(x, *b)]), e),
                _ => (hilbert([cell(x, 0), cell(x, 1), cell(x, 2)]), e),
            })
            .collect();
        keyed.sort_unstable();
        keyed.into_iter().map(|(_, e)| e).collect()
    }
}

/// Distance along the Hilbert curve of order [`BITS`] in D dimensions (Skilling 2004: transpose form by
/// undoing the rotations from the highest bit down, then Gray decoding).
fn hilbert<const D: usize>(mut x: [u32; D]) -> u64 {
    let top = 1u32 << (BITS - 1);
    let mut q = top;
    while q > 1 {
        let p = q - 1;
        for i in 0..D {
            if x[i] & q != 0 {
                x[0] ^= p;
            } else {
                let t = (x[0] ^ x[i]) & p;
                x[0] ^= t;
                x[i] ^= t;
            }
        }
        q >>= 1;
    }
    for i in 1..D {
        x[i] ^= x[i - 1];
    }
    let mut t = 0;
    q = top;
    while q > 1 {
        if x[D - 1] & q != 0 {
            t ^= q - 1;
        }
        q >>= 1;
    }
    x.iter_mut().for_each(|x| *x ^= t);
    let mut key = 0u64;
    for bit in (0..BITS).rev() {
        for value in x {
            key = key << 1 | u64::from(value >> bit & 1);
        }
    }
    key
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_curve_steps_from_neighbour_to_neighbour_and_visits_all() {
        // top three bits span an 8³ grid; scaled to the curve's own resolution
        let scale = 1u32 << (BITS - 3);
        let mut cells: Vec<(u64, [u32; 3])> = vec![];
        for x in 0..8 {
            for y in 0..8 {
                for z in 0..8 {
                    cells.push((hilbert([x * scale, y * scale, z * scale]), [x, y, z]));
                }
            }
        }
        cells.sort_unstable();
        for pair in cells.windows(2) {
            let distance: u32 = (0..3).map(|a| pair[0].1[a].abs_diff(pair[1].1[a])).sum();
            assert_eq!(distance, 1, "{pair:?}");
        }
        for cube in cells.chunks(64) {
            for a in 0..3 {
                let (low, high) = cube.iter().fold((9, 0), |(l, h), c| (c.1[a].min(l), c.1[a].max(h)));
                assert_eq!(high - low, 3, "64 cells in a row are a 4³ cube");
            }
        }
    }
}
