//! One block's part of a step: gather, internal force, scatter, and the step of its inner points.

use super::geometry::MetricLanes;
use super::kernel::{Basis, BatchBooks, Cube, Work, internal_force, splat_matrix};
use super::laws::laws;
use super::layout::Block;
use super::model::Model;
use super::portable::Element;
use super::real::Real;
use crate::aligned::Aligned;
use bytemuck::{cast_slice, cast_slice_mut};
use hati_coupling::central_difference::{drift, kick};
use pulp::{Simd, WithSimd};
use std::ops::Range;

/// What a pass over the blocks does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Pass {
    /// Kick and drift; memory variables advance.
    Step,
    /// Internal force of the unrelaxed elastic solid at `x`, written over `v`.
    UnrelaxedForce,
    /// Energies at the end of the last step, into the books; nothing else changes.
    Energies,
}

/// Energies of one block, J.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Books {
    /// Taken up by the arms' dashpots up to the latest kick.
    pub viscous: f64,
    /// Taken up from there to the end of the step.
    pub pending: f64,
    /// Strain energy at the end of the step.
    pub strain: f64,
}

/// Numbers that belong to a run of blocks alone.
pub(super) struct Own<'a, T> {
    /// Positions at the next kick of inner points.
    pub x: &'a mut [T],
    /// Velocities of inner points.
    pub v: &'a mut [T],
    /// Partial sums at shared points.
    pub partial: &'a mut [T],
    /// Strains of the arms' dashpots.
    pub dashpots: &'a mut [T],
    /// Energies of each block.
    pub books: &'a mut [Books],
}

impl<'a, T> Own<'a, T> {
    /// The first numbers of every kind and the rest.
    pub(super) fn split(self, inner: usize, halo: usize, dashpots: usize, blocks: usize) -> (Self, Self) {
        let (x, x_rest) = self.x.split_at_mut(3 * inner);
        let (v, v_rest) = self.v.split_at_mut(3 * inner);
        let (partial, partial_rest) = self.partial.split_at_mut(3 * halo);
        let (dashpot, dashpots_rest) = self.dashpots.split_at_mut(dashpots);
        let (books, books_rest) = self.books.split_at_mut(blocks);
        (
            Self { x, v, partial, dashpots: dashpot, books },
            Self { x: x_rest, v: v_rest, partial: partial_rest, dashpots: dashpots_rest, books: books_rest },
        )
    }
}

/// Numbers of one component of a block, addressed by 16 bits: no index is out of range.
type Addressed<T> = [T; 1 << 16];

/// Positions, velocities and forces of one block, one array a component.
pub(super) struct Scratch<T> {
    pub x: [Aligned<T>; 3],
    pub v: [Aligned<T>; 3],
    pub f: [Aligned<T>; 3],
    /// Of one element, for the portable path.
    pub element: Element<T>,
}

impl<T: Real> Scratch<T> {
    /// `points` of an element where the portable path runs, else 0.
    pub(super) fn new(points: usize) -> Self {
        let all = || std::array::from_fn(|_| Aligned::zeros(1 << 16));
        Self { x: all(), v: all(), f: all(), element: Element::new(points) }
    }
}

fn addressed<T: Real>(a: &[Aligned<T>; 3]) -> [&Addressed<T>; 3] {
    a.each_ref().map(|a| a.first_chunk().unwrap_or_else(|| unreachable!("made with 2^16 numbers")))
}

fn addressed_mut<T: Real>(a: &mut [Aligned<T>; 3]) -> [&mut Addressed<T>; 3] {
    a.each_mut().map(|a| a.first_chunk_mut().unwrap_or_else(|| unreachable!("made with 2^16 numbers")))
}

/// A run of blocks at compiled sizes.
pub(super) struct Leaf<'a, T: Real, const P: usize, const K: usize, const MEMORY: bool> {
    pub model: &'a Model<T>,
    pub pass: Pass,
    pub blocks: Range<usize>,
    pub own: Own<'a, T>,
    pub shared_x: &'a [T],
    pub shared_v: &'a [T],
    pub scratch: &'a mut Scratch<T>,
}

impl<T: Real, const P: usize, const K: usize, const MEMORY: bool> WithSimd for Leaf<'_, T, P, K, MEMORY> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Leaf { model, pass, blocks, mut own, shared_x, shared_v, scratch } = self;
        let basis = Basis::<T, P>::of(&model.gll);
        let d = splat_matrix(simd, &basis.derivative);
        let mut work = Work::<T::Vector<S>, P, K>::new(T::splat(simd, T::default()));
        for block in &model.layout.blocks[blocks] {
            let dashpots = block.batches.len() * model.dashpots_per_batch();
            let (mut mine, rest) = own.split(block.inner.len(), block.halo.len(), dashpots, 1);
            own = rest;
            gather_block(model, block, mine.x, shared_x, &mut scratch.x);
            if MEMORY || pass == Pass::Energies {
                gather_block(model, block, mine.v, shared_v, &mut scratch.v);
            }
            for f in &mut scratch.f {
                f[..block.points()].fill(T::default());
            }
            forces::<T, S, P, K, MEMORY>(simd, model, pass, block, &basis, &d, &mut work, &mut mine, scratch);
            if pass != Pass::Energies {
                finish(model, pass, block, &mut mine, &scratch.f);
            }
        }
    }
}

impl<T: Real, const P: usize> Basis<T, P> {
    fn of(gll: &crate::gll::Gll) -> Self {
        Self {
            derivative: std::array::from_fn(|i| std::array::from_fn(|m| T::of(gll.derivative[i * P + m]))),
            points: std::array::from_fn(|i| T::of(gll.points[i])),
            weights: std::array::from_fn(|i| T::of(gll.weights[i])),
        }
    }
}

/// Brings the points of a block side by side: inner ones first, then shared ones.
#[inline(always)]
pub(super) fn gather_block<T: Real>(
    model: &Model<T>,
    block: &Block,
    own: &[T],
    shared: &[T],
    to: &mut [Aligned<T>; 3],
) {
    let inner = block.inner.len();
    let halo = &model.layout.halo[block.halo.clone()];
    for (c, to) in to.iter_mut().enumerate() {
        to[..inner].copy_from_slice(&own[c * inner..(c + 1) * inner]);
        for (to, &s) in to[inner..].iter_mut().zip(halo) {
            *to = shared[3 * s as usize + c];
        }
    }
}

#[inline(always)]
fn forces<T: Real, S: Simd, const P: usize, const K: usize, const MEMORY: bool>(
    simd: S,
    model: &Model<T>,
    pass: Pass,
    block: &Block,
    basis: &Basis<T, P>,
    d: &[[T::Vector<S>; P]; P],
    work: &mut Work<T::Vector<S>, P, K>,
    own: &mut Own<'_, T>,
    scratch: &mut Scratch<T>,
) {
    let lanes = T::lanes::<S>();
    let points = P * P * K;
    let per_batch = block.metric.values(K, points) * lanes;
    let zero = T::splat(simd, T::default());
    let mut books = BatchBooks { loss: zero, strain: zero };
    for (index, batch) in block.batches.clone().enumerate() {
        let local = &model.layout.local[batch * points * lanes..(batch + 1) * points * lanes];
        gather_batch(local, addressed(&scratch.x), work.u.each_mut().map(flat_mut::<T, _, P, K>));
        if MEMORY || pass == Pass::Energies {
            gather_batch(local, addressed(&scratch.v), work.v.each_mut().map(flat_mut::<T, _, P, K>));
        }
        let first = block.metric_start + index * per_batch;
        let values = cast_slice(&model.metric[first..first + per_batch]);
        let metric = MetricLanes { kind: block.metric, values };
        let laws = laws::<T, S>(model, pass, batch);
        let size = if laws.arms.is_empty() { 0 } else { model.dashpots_per_batch() };
        let dashpots = cast_slice_mut(&mut own.dashpots[index * size..(index + 1) * size]);
        internal_force::<T, S, P, K, MEMORY>(
            simd,
            basis,
            d,
            work,
            &metric,
            &laws,
            dashpots,
            pass != Pass::Energies,
            model.dt,
            &mut books,
        );
        if pass == Pass::Energies {
            continue;
        }
        let f = work.f.each_ref().map(|f| cast_slice(f.as_flattened().as_flattened()));
        scatter_batch(local, f, addressed_mut(&mut scratch.f));
    }
    let loss = 0.25 * sum_of_lanes::<T, S>(books.loss);
    if pass == Pass::Energies {
        // half of what goes from kick to kick belongs to this half of the step
        own.books[0].pending = 0.5 * loss;
        own.books[0].strain = 0.5 * sum_of_lanes::<T, S>(books.strain);
    } else {
        own.books[0].viscous += loss;
    }
}

/// Numbers of one component of a batch, `[point][lane]`.
#[inline(always)]
fn flat_mut<T: Real, V: bytemuck::Pod, const P: usize, const K: usize>(cube: &mut Cube<V, P, K>) -> &mut [T] {
    cast_slice_mut(cube.as_flattened_mut().as_flattened_mut())
}

/// Takes a batch's numbers from the block, the three components of a point at a time.
#[inline(always)]
fn gather_batch<T: Real>(local: &[u16], from: [&Addressed<T>; 3], to: [&mut [T]; 3]) {
    let [a, b, c] = to;
    let (a, b, c) = (&mut a[..local.len()], &mut b[..local.len()], &mut c[..local.len()]);
    for (q, &i) in local.iter().enumerate() {
        let i = usize::from(i);
        a[q] = from[0][i];
        b[q] = from[1][i];
        c[q] = from[2][i];
    }
}

/// Adds a batch's forces to the block.
#[inline(always)]
fn scatter_batch<T: Real>(local: &[u16], from: [&[T]; 3], to: [&mut Addressed<T>; 3]) {
    let [a, b, c] = from.map(|f| &f[..local.len()]);
    let [x, y, z] = to;
    for (q, &i) in local.iter().enumerate() {
        let i = usize::from(i);
        x[i] += a[q];
        y[i] += b[q];
        z[i] += c[q];
    }
}

#[inline(always)]
fn sum_of_lanes<T: Real, S: Simd>(vector: T::Vector<S>) -> f64 {
    let lanes: &[T] = cast_slice(std::slice::from_ref(&vector));
    lanes.iter().map(|x| x.f64()).sum()
}

/// Ends the pass for inner points and leaves the sums of shared ones.
#[inline(always)]
pub(super) fn finish<T: Real>(
    model: &Model<T>,
    pass: Pass,
    block: &Block,
    own: &mut Own<'_, T>,
    f: &[Aligned<T>; 3],
) {
    let inner = block.inner.len();
    let dt_over_mass = &model.dt_over_mass[block.inner.clone()];
    for (c, f) in f.iter().enumerate() {
        let f = &f[..block.points()];
        let (x, v) = (&mut own.x[c * inner..(c + 1) * inner], &mut own.v[c * inner..(c + 1) * inner]);
        match pass {
            Pass::Step => {
                for (((x, v), f), m) in x.iter_mut().zip(v).zip(f).zip(dt_over_mass) {
                    *v = kick(*v, T::default() - *f, *m);
                    *x = drift(*x, *v, model.dt).settle();
                }
            }
            Pass::UnrelaxedForce => v.copy_from_slice(&f[..inner]),
            Pass::Energies => {}
        }
        for (partial, f) in own.partial.iter_mut().skip(c).step_by(3).zip(&f[inner..]) {
            *partial = *f;
        }
    }
}
