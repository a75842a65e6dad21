//! The point of an element, or of one of its sides, that is nearest to a given point.

use super::geometry::{norm, solve};
use super::tree::Bounds;
use super::{Mesh, axes};

/// Steps of the search; a point outside a straight element needs about five.
const STEPS: usize = 60;

/// What the search may vary and what it counts.
#[derive(Clone, Copy)]
pub(crate) struct Search {
    /// Local axis that is held at an end, and that end (−1 or +1).
    pub(crate) held: Option<(usize, f64)>,
    /// Whether z counts in the distance; not for plan distances.
    pub(crate) vertical: bool,
}

impl Mesh {
    /// Local point of an element nearest to `x`, and its distance, m. Gauss–Newton steps on the local
    /// coordinates that are not held at ±1 by the element's side; a local minimum where the element is
    /// strongly curved. At D = 2 y does not count.
    pub(crate) fn closest(&self, element: usize, x: [f64; 3], search: Search) -> ([f64; 3], f64) {
        let axes = axes(self.dimension);
        let (origin, small) = (self.nodes[self.element(element)[0] as usize], self.resolution(element));
        let evaluate = |local: [f64; 3]| {
            let (offset, mut jacobian) = self.offset_and_jacobian(element, local);
            let mut residual = [0.0; 3];
            axes.iter().for_each(|&i| residual[i] = x[i] - origin[i] - offset[i]);
            if !search.vertical {
                residual[2] = 0.0;
                jacobian[2] = [0.0; 3];
            }
            (residual, norm(residual), jacobian)
        };
        let mut local = [0.0; 3];
        if let Some((axis, end)) = search.held {
            local[axis] = end;
        }
        let (mut residual, mut distance, mut jacobian) = evaluate(local);
        for _ in 0..STEPS {
            let step = self.step(&jacobian, residual, local, search.held.map(|h| h.0));
            let mut fraction = 1.0;
            let mut moved = false;
            while fraction > 1e-3 {
                let mut next = local;
                for (a, &i) in axes.iter().enumerate() {
                    next[a] = (local[a] + fraction * step[i]).clamp(-1.0, 1.0);
                }
                let trial = evaluate(next);
                if trial.1 < distance {
                    moved = distance - trial.1 > 0.1 * small;
                    local = next;
                    (residual, distance, jacobian) = trial;
                    break;
                }
                fraction *= 0.5;
            }
            if !moved {
                break;
            }
        }
        (local, distance)
    }

    /// Gauss–Newton step; a coordinate at ±1 that the residual pushes outwards stays.
    fn step(
        &self,
        jacobian: &[[f64; 3]; 3],
        residual: [f64; 3],
        local: [f64; 3],
        held: Option<usize>,
    ) -> [f64; 3] {
        let axes = axes(self.dimension);
        let column = |c: usize| [jacobian[0][c], jacobian[1][c], jacobian[2][c]];
        let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let mut free = [false; 3];
        for (a, &c) in axes.iter().enumerate() {
            let push = dot(column(c), residual);
            free[c] = held != Some(a) && !(local[a].abs() >= 1.0 && push * local[a] > 0.0);
        }
        let mut normal = [[0.0; 3]; 3];
        let mut right = [0.0; 3];
        for c in 0..3 {
            normal[c][c] = 1.0;
            if free[c] {
                right[c] = dot(column(c), residual);
                (0..3).filter(|&b| free[b]).for_each(|b| normal[c][b] = dot(column(c), column(b)));
                // a direction that the distance does not see (a steep side in plan) must not blow up
                normal[c][c] *= 1.0 + 1e-12;
            }
        }
        solve(&normal, right).unwrap_or([0.0; 3])
    }

    /// Box that holds an element for certain, widened by `share` of its size. A polynomial lies within its
    /// Bernstein coefficients, which for a curved element reach beyond the nodes.
    pub(crate) fn bounds(&self, element: usize, share: f64) -> Bounds {
        let mut control = [[0.0; 3]; 27];
        let nodes = self.element(element);
        for (c, &node) in control.iter_mut().zip(nodes) {
            *c = self.nodes[node as usize];
        }
        if self.order == 2 {
            for axis in 0..self.dimension {
                let stride = 3usize.pow(axis as u32);
                for k in (0..nodes.len()).filter(|k| k / stride % 3 == 1) {
                    let ends = [control[k - stride], control[k + stride]];
                    (0..3)
                        .for_each(|i| control[k][i] = 2.0 * control[k][i] - 0.5 * (ends[0][i] + ends[1][i]));
                }
            }
        }
        let margin = share * self.size(element) + self.resolution(element);
        let mut bounds = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for c in &control[..nodes.len()] {
            for i in 0..3 {
                bounds.0[i] = bounds.0[i].min(c[i] - margin);
                bounds.1[i] = bounds.1[i].max(c[i] + margin);
            }
        }
        bounds
    }
}
