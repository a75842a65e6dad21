//! The same pass with sizes at run time and no vectors: for orders that no fast kernel is compiled for,
//! and for machines without its instructions. One element at a time.

use super::block::{Own, Pass, Scratch, finish, gather_block};
use super::geometry::{Metric, point};
use super::kernel::{axis_count, global_axis, strain_components};
use super::laws::ARM_NUMBERS;
use super::layout::Block;
use super::model::Model;
use super::real::Real;
use std::ops::Range;

/// Working memory of one element: positions, velocities, forces `[component][point]`, fluxes
/// `[axis][component][point]`.
#[derive(Debug, Clone)]
pub(super) struct Element<T> {
    u: [Vec<T>; 3],
    v: [Vec<T>; 3],
    f: [Vec<T>; 3],
    flux: [[Vec<T>; 3]; 3],
}

impl<T: Real> Element<T> {
    /// For elements of `points` points; none for compiled sizes.
    pub(super) fn new(points: usize) -> Self {
        let zeros = || std::array::from_fn(|_| vec![T::default(); points]);
        Self { u: zeros(), v: zeros(), f: zeros(), flux: std::array::from_fn(|_| zeros()) }
    }
}

/// Runs a pass over a run of blocks.
pub(super) fn run<T: Real>(
    model: &Model<T>,
    pass: Pass,
    blocks: Range<usize>,
    mut own: Own<'_, T>,
    shared_x: &[T],
    shared_v: &[T],
    scratch: &mut Scratch<T>,
) {
    let basis = Basis::of(model);
    for block in &model.layout.blocks[blocks] {
        let dashpots = block.batches.len() * model.dashpots_per_batch();
        let (mut mine, rest) = own.split(block.inner.len(), block.halo.len(), dashpots, 1);
        own = rest;
        gather_block(model, block, mine.x, shared_x, &mut scratch.x);
        gather_block(model, block, mine.v, shared_v, &mut scratch.v);
        for f in &mut scratch.f {
            f[..block.points()].fill(T::default());
        }
        let (mut loss, mut strain) = (0.0, 0.0);
        for (index, batch) in block.batches.clone().enumerate() {
            let local = &model.layout.local[batch * basis.points..(batch + 1) * basis.points];
            for (p, &i) in local.iter().enumerate() {
                for c in 0..3 {
                    scratch.element.u[c][p] = scratch.x[c][usize::from(i)];
                    scratch.element.v[c][p] = scratch.v[c][usize::from(i)];
                    scratch.element.f[c][p] = T::default();
                }
            }
            let (l, s) =
                element(model, pass, block, &basis, index, batch, mine.dashpots, &mut scratch.element);
            loss += l;
            strain += s;
            for (p, &i) in local.iter().enumerate() {
                for c in 0..3 {
                    scratch.f[c][usize::from(i)] += scratch.element.f[c][p];
                }
            }
        }
        if pass == Pass::Energies {
            mine.books[0].pending = 0.5 * loss;
            mine.books[0].strain = 0.5 * strain;
        } else {
            mine.books[0].viscous += loss;
            finish(model, pass, block, &mut mine, &scratch.f);
        }
    }
}

/// Derivative matrix and weights at run-time size.
struct Basis<T> {
    n: usize,
    points: usize,
    axes: usize,
    planes: usize,
    derivative: Vec<T>,
    weight: Vec<f64>,
    local: Vec<[f64; 3]>,
}

impl<T: Real> Basis<T> {
    fn of<M: Real>(model: &Model<M>) -> Self {
        let (points, planes) = (model.layout.points, model.planes());
        let (local, weight) = (0..points).map(|p| point(&model.gll, model.dimension, p)).unzip();
        Self {
            n: model.gll.len(),
            points,
            axes: axis_count(planes),
            planes,
            derivative: model.gll.derivative.iter().map(|d| T::of(*d)).collect(),
            weight,
            local,
        }
    }

    /// $\partial u/\partial\xi_a$ at a point.
    fn slope(&self, u: &[T], p: usize, a: usize) -> T {
        let stride = self.n.pow(a as u32);
        let (i, first) = (p / stride % self.n, p - p / stride % self.n * stride);
        let mut sum = T::default();
        for m in 0..self.n {
            sum += self.derivative[i * self.n + m] * u[first + m * stride];
        }
        sum
    }

    /// Metric B, `[local axis][column]`, and weight s of a point.
    fn metric(&self, kind: Metric, values: &[T], p: usize) -> ([[T; 3]; 3], T) {
        let mut b = [[T::default(); 3]; 3];
        let n = self.axes;
        let copy = |b: &mut [[T; 3]; 3], from: &[T]| {
            (0..n * n).for_each(|i| b[i / n][i % n] = from[i]);
        };
        match kind {
            Metric::Affine => copy(&mut b, values),
            Metric::Stored => copy(&mut b, &values[p * n * n..]),
            Metric::Corners => return self.corners(values, p),
        }
        (b, T::of(if kind == Metric::Affine { self.weight[p] } else { 1.0 }))
    }

    fn corners(&self, a: &[T], p: usize) -> ([[T; 3]; 3], T) {
        let mut b = [[T::default(); 3]; 3];
        let [x, y, z] = self.local[p].map(T::of);
        if self.axes == 2 {
            let (xi, eta) = ([a[0] + y * a[4], a[1] + y * a[5]], [a[2] + x * a[4], a[3] + x * a[5]]);
            (b[0][0], b[0][1]) = (eta[1], T::default() - eta[0]);
            (b[1][0], b[1][1]) = (T::default() - xi[1], xi[0]);
            return (b, T::of(self.weight[p] / (xi[0] * eta[1] - xi[1] * eta[0]).f64()));
        }
        let row = |m: usize, c: usize| a[3 * m + c];
        let of = |f: &dyn Fn(usize) -> T| [f(0), f(1), f(2)];
        let xi = of(&|c| row(0, c) + y * row(3, c) + z * row(5, c) + y * z * row(6, c));
        let eta = of(&|c| row(1, c) + x * row(3, c) + z * row(4, c) + x * z * row(6, c));
        let zeta = of(&|c| row(2, c) + y * row(4, c) + x * row(5, c) + x * y * row(6, c));
        let cross = |p: &[T; 3], q: &[T; 3]| {
            of(&|c| p[(c + 1) % 3] * q[(c + 2) % 3] - p[(c + 2) % 3] * q[(c + 1) % 3])
        };
        b = [cross(&eta, &zeta), cross(&zeta, &xi), cross(&xi, &eta)];
        let det = xi[0] * b[0][0] + xi[1] * b[0][1] + xi[2] * b[0][2];
        (b, T::of(self.weight[p] / det.f64()))
    }

    /// Strains xx, yy, zz, yz, xz, xy (shear: twice the tensor's) of a field at a point.
    fn strain(&self, b: &[[T; 3]; 3], field: &[Vec<T>; 3], p: usize) -> [T; 6] {
        let mut h = [[T::default(); 3]; 3];
        for c in 0..3 {
            for a in 0..self.axes {
                let slope = self.slope(&field[c], p, a);
                for x in 0..self.axes {
                    h[c][global_axis(self.planes, x)] += b[a][x] * slope;
                }
            }
        }
        [h[0][0], h[1][1], h[2][2], h[1][2] + h[2][1], h[0][2] + h[2][0], h[0][1] + h[1][0]]
    }
}

fn stress<T: Real>(lambda: T, mu: T, e: &[T; 6]) -> [T; 6] {
    let pressure = lambda * (e[0] + e[1] + e[2]);
    let twice = mu + mu;
    [
        pressure + twice * e[0],
        pressure + twice * e[1],
        pressure + twice * e[2],
        mu * e[3],
        mu * e[4],
        mu * e[5],
    ]
}

fn work_of<T: Real>(s: &[T; 6], e: &[T; 6]) -> f64 {
    (0..6).map(|c| s[c].f64() * e[c].f64()).sum()
}

/// One element; returns what its dashpots took up since the kick before and twice its strain energy.
fn element<T: Real>(
    model: &Model<T>,
    pass: Pass,
    block: &Block,
    basis: &Basis<T>,
    index: usize,
    batch: usize,
    dashpots: &mut [T],
    element: &mut Element<T>,
) -> (f64, f64) {
    let per = block.metric.values(basis.planes, basis.points);
    let values = &model.metric[block.metric_start + index * per..block.metric_start + (index + 1) * per];
    let relaxed = pass != Pass::UnrelaxedForce;
    let moduli = if relaxed { &model.moduli } else { &model.unrelaxed };
    let arms = if relaxed { model.arms } else { 0 };
    let size = model.dashpots_per_batch();
    let dashpots = &mut dashpots[index * size..(index + 1) * size];
    let components = strain_components(basis.planes);
    let (mut loss, mut energy) = (0.0, 0.0);
    for p in 0..basis.points {
        let (b, weight) = basis.metric(block.metric, values, p);
        let e = basis.strain(&b, &element.u, p);
        let rate = basis.strain(&b, &element.v, p);
        let increment = rate.map(|r| model.dt * r);
        let class = batch * model.classes + usize::from(model.class[p]);
        let mut s = stress(moduli.lambda[class], moduli.mu[class], &e);
        if pass == Pass::Energies {
            let last = std::array::from_fn(|c| e[c] - increment[c]);
            energy += weight.f64() * work_of(&s, &last);
        }
        for arm in 0..arms {
            let numbers: [T; ARM_NUMBERS] =
                std::array::from_fn(|i| model.arm_lanes[(class * model.arms + arm) * ARM_NUMBERS + i]);
            let own = &mut dashpots[(p * model.arms + arm) * components..][..components];
            let (l, w) = step_arm(&numbers, pass != Pass::Energies, &e, &increment, own, &mut s);
            loss += weight.f64() * l;
            energy += weight.f64() * w;
        }
        let s = s.map(|s| s * weight);
        let rows = [[s[0], s[5], s[4]], [s[5], s[1], s[3]], [s[4], s[3], s[2]]];
        for c in 0..3 {
            for a in 0..basis.axes {
                element.flux[a][c][p] = T::default();
                for x in 0..basis.axes {
                    element.flux[a][c][p] += b[a][x] * rows[c][global_axis(basis.planes, x)];
                }
            }
        }
    }
    for a in 0..basis.axes {
        let stride = basis.n.pow(a as u32);
        for p in 0..basis.points {
            let i = p / stride % basis.n;
            for m in 0..basis.n {
                let d = basis.derivative[m * basis.n + i];
                for c in 0..3 {
                    let flux = element.flux[a][c][p + m * stride - i * stride];
                    element.f[c][p] += d * flux;
                }
            }
        }
    }
    (loss, energy)
}

/// One arm at one point: what its dashpot took up, and twice its energy where it does not advance.
fn step_arm<T: Real>(
    [gain, rate, lambda, mu, twice, back]: &[T; ARM_NUMBERS],
    advance: bool,
    e: &[T; 6],
    increment: &[T; 6],
    dashpot: &mut [T],
    s: &mut [T; 6],
) -> (f64, f64) {
    let section = dashpot.len() == 5;
    let (mut own, mut before) = ([T::default(); 6], [T::default(); 6]);
    for (slot, c) in (0..6).filter(|c| !(section && *c == 1)).enumerate() {
        own[c] = *gain * (e[c] - dashpot[slot]);
        before[c] = (*twice * own[c] - *back * increment[c]) - own[c];
        if advance {
            dashpot[slot] += *rate * own[c];
        }
    }
    let part = stress(*lambda, *mu, &own);
    let old = stress(*lambda, *mu, &before);
    (0..6).for_each(|c| s[c] += part[c]);
    let (square, product, old_square) =
        (work_of(&part, &own), work_of(&part, &before), work_of(&old, &before));
    // the mean's square is a quarter of the sum's; see the fast kernel for the stored energy
    let loss = 0.25 * rate.f64() * (square + 2.0 * product + old_square);
    let energy = if advance { 0.0 } else { product - 0.25 * rate.f64() * (square - old_square) };
    (loss, energy)
}
