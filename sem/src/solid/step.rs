//! Passes over all blocks and shared points, on one thread or several with the same bits.

use super::block::{Books, Leaf, Own, Pass, Scratch};
use super::model::{HeldKick, Model, SpecialKick};
use super::portable;
use super::real::Real;
use hati_coupling::central_difference::{drift, kick};
use pulp::{Arch, Simd, WithSimd};
use std::ops::Range;

/// Shared points that one task takes.
const SHARED_RUN: usize = 2048;

/// What special points exchanged with the outside during a pass, J.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Exchange {
    pub input: f64,
    pub outflow: f64,
}

/// Numbers that change while a solid steps.
pub(super) struct Arrays<'a, T> {
    pub x: &'a mut [T],
    pub v: &'a mut [T],
    pub partial: &'a mut [T],
    pub dashpots: &'a mut [T],
    pub books: &'a mut [Books],
    pub exchange: &'a mut [Exchange],
    pub scratch: &'a mut [Scratch<T>],
}

/// Tasks into which the shared points are cut.
pub(super) fn shared_runs<T: Real>(model: &Model<T>) -> usize {
    (model.layout.nodes - model.layout.shared).div_ceil(SHARED_RUN)
}

/// Runs a pass over blocks and shared points. `external` holds the forces at special points, N.
pub(super) fn run<T: Real>(
    model: &Model<T>,
    pass: Pass,
    parallel: bool,
    arrays: Arrays<'_, T>,
    external: &[[f64; 3]],
) {
    let inner = 3 * model.layout.shared;
    let (x, shared_x) = arrays.x.split_at_mut(inner);
    let (v, shared_v) = arrays.v.split_at_mut(inner);
    let own = Own { x, v, partial: &mut *arrays.partial, dashpots: arrays.dashpots, books: arrays.books };
    let blocks = Blocks { model, pass, parallel, shared_x, shared_v };
    blocks.run(0..model.layout.leaves.len(), own, arrays.scratch);
    if pass == Pass::Energies {
        return;
    }
    let shared = Shared { model, pass, parallel, partial: arrays.partial, external };
    shared.run(0, shared_x, shared_v, arrays.exchange);
}

/// Orders that a kernel is compiled for.
pub(super) const FAST_ORDERS: std::ops::RangeInclusive<usize> = 3..=8;

/// Lanes of the widest vectors that the machine has and a kernel is compiled for; 1 where it has none.
pub(super) fn lanes<T: Real>() -> usize {
    #[cfg(target_arch = "x86_64")]
    match Arch::new() {
        Arch::V4(_) => T::lanes::<pulp::x86::V4>(),
        Arch::V3(_) => T::lanes::<pulp::x86::V3>(),
        _ => 1,
    }
    #[cfg(target_arch = "aarch64")]
    match Arch::new() {
        Arch::Neon(_) => T::lanes::<pulp::aarch64::Neon>(),
        _ => 1,
    }
    #[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
    1
}

/// Runs a leaf on these vectors. Not by `Arch::dispatch`, which would compile a scalar kernel of each
/// size as well.
fn dispatch<W: WithSimd<Output = ()>>(leaf: W) {
    #[cfg(target_arch = "x86_64")]
    match Arch::new() {
        Arch::V4(simd) => Simd::vectorize(simd, leaf),
        Arch::V3(simd) => Simd::vectorize(simd, leaf),
        _ => unreachable!("the portable path has one lane"),
    }
    #[cfg(target_arch = "aarch64")]
    match Arch::new() {
        Arch::Neon(simd) => Simd::vectorize(simd, leaf),
        _ => unreachable!("the portable path has one lane"),
    }
    #[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
    let _ = leaf;
}

#[allow(unreachable_pub)]
pub struct Blocks<'a, T: Real> {
    model: &'a Model<T>,
    pass: Pass,
    parallel: bool,
    shared_x: &'a [T],
    shared_v: &'a [T],
}

impl<T: Real> Blocks<'_, T> {
    /// Halves the leaves until one is left; the halves may run at the same time.
    fn run(&self, leaves: Range<usize>, own: Own<'_, T>, scratch: &mut [Scratch<T>]) {
        if leaves.len() <= 1 {
            if let (Some(leaf), Some(scratch)) = (leaves.clone().next(), scratch.first_mut()) {
                T::leaf(self, self.model.layout.leaves[leaf].clone(), own, scratch);
            }
            return;
        }
        let middle = leaves.start + leaves.len() / 2;
        let layout = &self.model.layout;
        let blocks = layout.leaves[leaves.start].start..layout.leaves[middle].start;
        let (first, last) = (&layout.blocks[blocks.start], &layout.blocks[blocks.end - 1]);
        let batches = last.batches.end - first.batches.start;
        let (left, right) = own.split(
            last.inner.end - first.inner.start,
            last.halo.end - first.halo.start,
            batches * self.model.dashpots_per_batch(),
            blocks.len(),
        );
        let (scratch_left, scratch_right) = scratch.split_at_mut(middle - leaves.start);
        let run_left = || self.run(leaves.start..middle, left, scratch_left);
        let run_right = || self.run(middle..leaves.end, right, scratch_right);
        if self.parallel {
            rayon::join(run_left, run_right);
        } else {
            run_left();
            run_right();
        }
    }

    fn sized<const P: usize, const K: usize>(
        &self,
        blocks: Range<usize>,
        own: Own<'_, T>,
        scratch: &mut Scratch<T>,
    ) {
        let (model, pass) = (self.model, self.pass);
        let (shared_x, shared_v) = (self.shared_x, self.shared_v);
        // moduli that differ from point to point are read where memory is
        if model.arms > 0 && (pass != Pass::UnrelaxedForce || model.classes > 1) {
            let leaf = Leaf::<T, P, K, true> { model, pass, blocks, own, shared_x, shared_v, scratch };
            dispatch(leaf);
        } else {
            let leaf = Leaf::<T, P, K, false> { model, pass, blocks, own, shared_x, shared_v, scratch };
            dispatch(leaf);
        }
    }
}

/// The kernels of a precision. Its functions are not generic, so they are compiled here once and not again
/// in every crate that names a [`super::Solid`].
pub trait Kernels: Sized {
    /// Runs a pass over a run of blocks.
    #[allow(private_interfaces)]
    fn leaf(of: &Blocks<'_, Self>, blocks: Range<usize>, own: Own<'_, Self>, scratch: &mut Scratch<Self>)
    where
        Self: Real;
}

macro_rules! kernels {
    ($($t:ty)*) => { $(
        impl Kernels for $t {
            #[allow(private_interfaces)]
            fn leaf(of: &Blocks<'_, $t>, blocks: Range<usize>, own: Own<'_, $t>, scratch: &mut Scratch<$t>) {
                if of.model.layout.lanes == 1 {
                    let (x, v) = (of.shared_x, of.shared_v);
                    return portable::run(of.model, of.pass, blocks, own, x, v, scratch);
                }
                match (of.model.gll.len() - 1, of.model.dimension) {
                    (3, 2) => of.sized::<4, 1>(blocks, own, scratch),
                    (3, _) => of.sized::<4, 4>(blocks, own, scratch),
                    (4, 2) => of.sized::<5, 1>(blocks, own, scratch),
                    (4, _) => of.sized::<5, 5>(blocks, own, scratch),
                    (5, 2) => of.sized::<6, 1>(blocks, own, scratch),
                    (5, _) => of.sized::<6, 6>(blocks, own, scratch),
                    (6, 2) => of.sized::<7, 1>(blocks, own, scratch),
                    (6, _) => of.sized::<7, 7>(blocks, own, scratch),
                    (7, 2) => of.sized::<8, 1>(blocks, own, scratch),
                    (7, _) => of.sized::<8, 8>(blocks, own, scratch),
                    (8, 2) => of.sized::<9, 1>(blocks, own, scratch),
                    (8, _) => of.sized::<9, 9>(blocks, own, scratch),
                    _ => unreachable!("the portable path takes the others"),
                }
            }
        }
    )* };
}

kernels!(f32 f64);

struct Shared<'a, T: Real> {
    model: &'a Model<T>,
    pass: Pass,
    parallel: bool,
    partial: &'a [T],
    external: &'a [[f64; 3]],
}

impl<T: Real> Shared<'_, T> {
    /// Ends the pass at shared points from number `first` (counted from the first shared one).
    fn run(&self, first: usize, x: &mut [T], v: &mut [T], exchange: &mut [Exchange]) {
        let runs = exchange.len();
        if runs <= 1 {
            if let Some(exchange) = exchange.first_mut() {
                *exchange = self.points(first, x, v);
            }
            return;
        }
        let middle = runs / 2;
        let (x0, x1) = x.split_at_mut(3 * middle * SHARED_RUN);
        let (v0, v1) = v.split_at_mut(3 * middle * SHARED_RUN);
        let (e0, e1) = exchange.split_at_mut(middle);
        let mut left = || self.run(first, x0, v0, e0);
        let mut right = || self.run(first + middle * SHARED_RUN, x1, v1, e1);
        if self.parallel {
            rayon::join(left, right);
        } else {
            left();
            right();
        }
    }

    fn points(&self, first: usize, x: &mut [T], v: &mut [T]) -> Exchange {
        let layout = &self.model.layout;
        let count = x.len() / 3;
        let plain = (layout.special - layout.shared).saturating_sub(first).min(count);
        let starts = &layout.sums_start[first..=first + count];
        let (x, v) = (x.as_chunks_mut::<3>().0, v.as_chunks_mut::<3>().0);
        if self.pass == Pass::UnrelaxedForce {
            for (v, range) in v.iter_mut().zip(starts.windows(2)) {
                *v = self.sum(range);
            }
            return Exchange::default();
        }
        let dt_over_mass = &self.model.dt_over_mass[layout.shared + first..];
        let (dt, zero) = (self.model.dt, T::default());
        for (((x, v), range), m) in
            x[..plain].iter_mut().zip(&mut v[..plain]).zip(starts.windows(2)).zip(dt_over_mass)
        {
            let f = self.sum(range);
            for c in 0..3 {
                v[c] = kick(v[c], zero - f[c], *m);
                x[c] = drift(x[c], v[c], dt).settle();
            }
        }
        let mut exchange = Exchange::default();
        for (i, (x, v)) in x.iter_mut().zip(v).enumerate().skip(plain) {
            let f = self.sum(&starts[i..i + 2]);
            self.special(layout.shared + first + i - layout.special, f, x, v, &mut exchange);
        }
        exchange
    }

    /// What the blocks left for a shared point; `range` is the first of its entries and the one behind.
    #[inline(always)]
    fn sum(&self, range: &[u32]) -> [T; 3] {
        let partial = self.partial.as_chunks::<3>().0;
        let mut f = [T::default(); 3];
        for &entry in &self.model.layout.sums[range[0] as usize..range[1] as usize] {
            let part = &partial[entry as usize];
            for c in 0..3 {
                f[c] += part[c];
            }
        }
        f
    }

    fn special(&self, i: usize, f: [T; 3], x: &mut [T; 3], v: &mut [T; 3], exchange: &mut Exchange) {
        let external = self.external[i];
        let force: [f64; 3] = std::array::from_fn(|c| external[c] - f[c].f64());
        let before = v.map(T::f64);
        let after = match &self.model.specials[i] {
            SpecialKick::Free(m) => std::array::from_fn(|c| kick(before[c], force[c], m.f64())),
            SpecialKick::Held(held) => held.kick(before, force),
        };
        let dt = self.model.dt.f64();
        let mean: [f64; 3] = std::array::from_fn(|c| 0.5 * (before[c] + after[c]));
        exchange.input += dt * (0..3).map(|c| external[c] * mean[c]).sum::<f64>();
        if let SpecialKick::Held(held) = &self.model.specials[i] {
            exchange.outflow += dt * held.power(mean);
        }
        for c in 0..3 {
            v[c] = T::of(after[c]);
            x[c] = drift(x[c], v[c], self.model.dt).settle();
        }
    }
}

impl HeldKick {
    fn kick(&self, v: [f64; 3], f: [f64; 3]) -> [f64; 3] {
        std::array::from_fn(|i| (0..3).map(|j| self.keep[i][j] * v[j] + self.force[i][j] * f[j]).sum())
    }

    /// Power that the dashpot takes up, W.
    fn power(&self, v: [f64; 3]) -> f64 {
        (0..3).map(|i| v[i] * (0..3).map(|j| self.dashpot[i][j] * v[j]).sum::<f64>()).sum()
    }
}
