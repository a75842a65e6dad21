//! The map from an element's local coordinates to the ground, its Jacobian and its inverse.
//!
//! $x(\xi) = \sum_k N_k(\xi)\,x_k$ with tensor products of Lagrange polynomials on −1, +1 (order 1) or
//! −1, 0, +1 (order 2). A local point is `[ξ, η, ζ]`; at D = 2 it is `[ξ, η, _]`, the third number is ignored.

use super::{Mesh, axes};

/// Newton steps from one starting point; a valid element needs four to eight.
const NEWTON_STEPS: usize = 25;

/// A local coordinate beyond this is no longer followed: the map is not meant to be used there.
const LOCAL_LIMIT: f64 = 1.25;

impl Mesh {
    /// Position of a local point of an element, m. At a geometric node it is the node, to the last bit.
    pub fn position(&self, element: usize, local: [f64; 3]) -> [f64; 3] {
        // offsets from the nearest node are summed, so that a mesh far from the origin loses no digits
        let (g, n) = (self.order as f64, self.order + 1);
        let nearest = (0..self.dimension)
            .rev()
            .fold(0, |index, a| index * n + ((0.5 * (local[a] + 1.0) * g).round().clamp(0.0, g) as usize));
        let origin = self.nodes[self.element(element)[nearest] as usize];
        let mut x = [0.0; 3];
        self.for_each_node(element, local, |node, value, _| {
            (0..3).for_each(|i| x[i] += value * (node[i] - origin[i]));
        });
        [origin[0] + x[0], origin[1] + x[1], origin[2] + x[2]]
    }

    /// Jacobian matrix $J_{ia} = \partial x_i/\partial\xi_a$ of an element's map, `[row i][column]`, m.
    ///
    /// The column of local axis `a` is [`axes`]`(D)[a]`. At D = 2 that leaves row and column y to the
    /// identity, $J = \begin{pmatrix} x_\xi & 0 & x_\eta\\ 0 & 1 & 0\\ z_\xi & 0 & z_\eta\end{pmatrix}$,
    /// so that [`determinant`] is the ratio of areas (m²) at D = 2 as it is that of volumes (m³) at D = 3,
    /// and an inverse needs no case. Positive in a valid element.
    pub fn jacobian(&self, element: usize, local: [f64; 3]) -> [[f64; 3]; 3] {
        self.offset_and_jacobian(element, local).1
    }

    /// Edge length scale of an element: the longest side of its nodes' bounding box, m.
    pub fn size(&self, element: usize) -> f64 {
        let (min, max) = self.node_box(element);
        (0..3).map(|i| max[i] - min[i]).fold(0.0, f64::max)
    }

    /// Bounding box of an element's nodes, m. A curved element (order 2) may bulge out of it.
    pub fn node_box(&self, element: usize) -> ([f64; 3], [f64; 3]) {
        let mut min = [f64::INFINITY; 3];
        let mut max = [f64::NEG_INFINITY; 3];
        for &node in self.element(element) {
            let x = &self.nodes[node as usize];
            for i in 0..3 {
                min[i] = min[i].min(x[i]);
                max[i] = max[i].max(x[i]);
            }
        }
        (min, max)
    }

    /// Smallest distance that coordinates can tell apart at an element, m: the round-off of its nodes'
    /// coordinates, or 1e-15 of its size where the origin is near.
    pub fn resolution(&self, element: usize) -> f64 {
        let (min, max) = self.node_box(element);
        let far = (0..3).map(|i| min[i].abs().max(max[i].abs())).fold(0.0, f64::max);
        (4.0 * f64::EPSILON * far).max(1e-15 * self.size(element))
    }

    /// Local coordinates of a point, by Newton's method; the point may lie somewhat outside the element
    /// (each |ξ| up to 1.25).
    ///
    /// - `None`: no such local point was found, that is, the point is farther away, or the element is not
    ///   valid. A D = 2 mesh ignores y.
    /// - accuracy: the position of the answer agrees with `x` to 1e-12 of the element's size, or to the
    ///   coordinates' own round-off far from the origin.
    /// - cost: 4–8 evaluations of map and Jacobian, no allocation; at most 25 from each of $1 + 2^D$
    ///   starting points (the centre, and halfway to each corner where the element is strongly curved).
    pub fn inverse_map(&self, element: usize, x: [f64; 3]) -> Option<[f64; 3]> {
        if !x.iter().all(|v| v.is_finite()) {
            return None;
        }
        let d = self.dimension;
        let (min, max) = self.node_box(element);
        let size = self.size(element);
        if axes(d).iter().any(|&i| x[i] < min[i] - size || x[i] > max[i] + size) {
            return None;
        }
        let tolerance = (1e-12 * size).max(2.0 * self.resolution(element));
        if let Some(local) = self.newton(element, x, [0.0; 3], tolerance) {
            return Some(local);
        }
        // a point that the element holds is worth further starts; for most of those that come here it is not
        let (min, max) = self.bounds(element, 0.0);
        if axes(d).iter().any(|&i| x[i] < min[i] || x[i] > max[i]) {
            return None;
        }
        (0..1usize << d).find_map(|corner| {
            let mut start = [0.0; 3];
            (0..d).for_each(|a| start[a] = if corner >> a & 1 == 1 { 0.5 } else { -0.5 });
            self.newton(element, x, start, tolerance)
        })
    }

    /// Newton with halved steps where the full one does not come nearer.
    fn newton(&self, element: usize, x: [f64; 3], start: [f64; 3], tolerance: f64) -> Option<[f64; 3]> {
        let axes = axes(self.dimension);
        let origin = self.nodes[self.element(element)[0] as usize];
        let mut target = [0.0; 3];
        axes.iter().for_each(|&i| target[i] = x[i] - origin[i]);
        let evaluate = |local| {
            let (offset, jacobian) = self.offset_and_jacobian(element, local);
            let mut residual = [0.0; 3];
            axes.iter().for_each(|&i| residual[i] = target[i] - offset[i]);
            (residual, norm(residual), jacobian)
        };
        let mut local = start;
        let (mut residual, mut error, mut jacobian) = evaluate(local);
        for _ in 0..NEWTON_STEPS {
            let step = solve(&jacobian, residual)?;
            let mut fraction = 1.0;
            let mut best = None;
            while fraction > 0.01 {
                let mut next = local;
                for (a, &i) in axes.iter().enumerate() {
                    next[a] = (local[a] + fraction * step[i]).clamp(-LOCAL_LIMIT, LOCAL_LIMIT);
                }
                let trial = evaluate(next);
                if trial.1 < error && determinant(&trial.2) > 0.0 {
                    best = Some((next, trial));
                    break;
                }
                // within the tolerance a step that gains nothing is round-off, not a bad direction
                if error <= tolerance {
                    break;
                }
                fraction *= 0.5;
            }
            let Some((next, trial)) = best else { break };
            local = next;
            (residual, error, jacobian) = trial;
        }
        (error <= tolerance).then_some(local)
    }

    /// Position less that of the element's first node, and the Jacobian matrix. Differences are taken
    /// before they are summed, so that a mesh far from the origin loses no digits.
    pub(super) fn offset_and_jacobian(&self, element: usize, local: [f64; 3]) -> ([f64; 3], [[f64; 3]; 3]) {
        let origin = self.nodes[self.element(element)[0] as usize];
        let axes = axes(self.dimension);
        let mut offset = [0.0; 3];
        let mut jacobian = [[0.0; 3]; 3];
        if self.dimension == 2 {
            jacobian[1][1] = 1.0;
        }
        self.for_each_node(element, local, |node, value, gradient| {
            for &i in axes {
                let dx = node[i] - origin[i];
                offset[i] += value * dx;
                axes.iter().zip(gradient).for_each(|(&c, g)| jacobian[i][c] += g * dx);
            }
        });
        (offset, jacobian)
    }

    /// Calls `each` with the coordinates of every node of an element, the value of its shape function at a
    /// local point, and the gradient with respect to the local axes.
    #[inline(always)]
    pub(super) fn for_each_node(
        &self,
        element: usize,
        local: [f64; 3],
        mut each: impl FnMut(&[f64; 3], f64, [f64; 3]),
    ) {
        let n = self.order + 1;
        let deep = if self.dimension == 2 { 1 } else { n };
        let (u, du) = lagrange(self.order, local[0]);
        let (v, dv) = lagrange(self.order, local[1]);
        let (w, dw) = if self.dimension == 2 { ([1.0; 3], [0.0; 3]) } else { lagrange(self.order, local[2]) };
        let mut nodes = self.element(element).iter();
        for k in 0..deep {
            for j in 0..n {
                for i in 0..n {
                    let Some(&node) = nodes.next() else { return };
                    let gradient = [du[i] * v[j] * w[k], u[i] * dv[j] * w[k], u[i] * v[j] * dw[k]];
                    each(&self.nodes[node as usize], u[i] * v[j] * w[k], gradient);
                }
            }
        }
    }
}

/// Lagrange polynomials on −1, +1 or −1, 0, +1 and their derivatives.
#[inline(always)]
fn lagrange(order: usize, t: f64) -> ([f64; 3], [f64; 3]) {
    if order == 1 {
        ([0.5 * (1.0 - t), 0.5 * (1.0 + t), 0.0], [-0.5, 0.5, 0.0])
    } else {
        ([0.5 * t * (t - 1.0), (1.0 - t) * (1.0 + t), 0.5 * t * (t + 1.0)], [t - 0.5, -2.0 * t, t + 0.5])
    }
}

pub(super) fn norm(v: [f64; 3]) -> f64 {
    v.iter().map(|v| v * v).sum::<f64>().sqrt()
}

/// Determinant of a 3 × 3 matrix `[row][column]`.
pub fn determinant(m: &[[f64; 3]; 3]) -> f64 {
    m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0])
        + m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0])
}

/// Inverse of a 3 × 3 matrix `[row][column]` and its determinant; not finite where it is singular.
///
/// Of a Jacobian matrix it is $\partial\xi_a/\partial x_i$, `[column of a][i]`, 1/m.
pub fn inverse(m: &[[f64; 3]; 3]) -> ([[f64; 3]; 3], f64) {
    let det = determinant(m);
    let cofactor = |r: usize, c: usize| {
        let (r1, r2, c1, c2) = ((r + 1) % 3, (r + 2) % 3, (c + 1) % 3, (c + 2) % 3);
        m[r1][c1] * m[r2][c2] - m[r1][c2] * m[r2][c1]
    };
    let mut result = [[0.0; 3]; 3];
    for (r, row) in result.iter_mut().enumerate() {
        // the transposed cofactors over the determinant
        row.iter_mut().enumerate().for_each(|(c, value)| *value = cofactor(c, r) / det);
    }
    (result, det)
}

/// Solution of a 3 × 3 system, `None` where it is singular.
pub(super) fn solve(m: &[[f64; 3]; 3], b: [f64; 3]) -> Option<[f64; 3]> {
    let (inverse, _) = inverse(m);
    let x = inverse.map(|row| row[0] * b[0] + row[1] * b[1] + row[2] * b[2]);
    x.iter().all(|v| v.is_finite()).then_some(x)
}
