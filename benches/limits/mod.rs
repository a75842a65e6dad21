//! What the machine allows: bandwidth and arithmetic on one core, measured with the kernel's own vectors.

use hati_sem::solid::Real;
use pulp::{Arch, Simd, WithSimd};
use std::time::Instant;

/// Bandwidth of the triad $a_i = b_i + s\,c_i$ on arrays of `numbers` numbers, B/s: best of `repeats`.
///
/// Three transfers per number are counted, as STREAM does; the write's own fetch is not.
pub(crate) fn triad_bandwidth<T: Real>(numbers: usize, repeats: usize) -> f64 {
    struct Triad<'a, T>(&'a mut [T], &'a [T], &'a [T]);
    impl<T: Real> WithSimd for Triad<'_, T> {
        type Output = ();
        #[inline(always)]
        fn with_simd<S: Simd>(self, _: S) {
            let scale = T::of(1.5);
            for ((a, b), c) in self.0.iter_mut().zip(self.1).zip(self.2) {
                *a = *b + scale * *c;
            }
        }
    }
    let mut a = vec![T::default(); numbers];
    let b: Vec<T> = (0..numbers).map(|i| T::of(i as f64)).collect();
    let c: Vec<T> = (0..numbers).map(|i| T::of(0.5 * i as f64)).collect();
    let bytes = (3 * numbers * size_of::<T>()) as f64;
    let best = (0..repeats)
        .map(|_| {
            let start = Instant::now();
            Arch::new().dispatch(Triad(&mut a, &b, &c));
            start.elapsed().as_secs_f64()
        })
        .fold(f64::INFINITY, f64::min);
    std::hint::black_box(&a[numbers / 2]);
    bytes / best
}

/// Fused multiply–adds that one core finishes, flop/s (two a lane): ten independent chains, best of `repeats`.
pub(crate) fn fma_peak<T: Real>(repeats: usize) -> f64 {
    const CHAINS: usize = 10;
    const ROUNDS: usize = 200_000;
    struct Chains<T>(std::marker::PhantomData<T>);
    impl<T: Real> WithSimd for Chains<T> {
        type Output = (usize, f64);
        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) -> (usize, f64) {
            // hidden from the compiler, which would otherwise work the chains out itself
            let [factor, term, start] = std::hint::black_box([0.999, 1e-3, 1.0]);
            let (factor, term) = (T::splat(simd, T::of(factor)), T::splat(simd, T::of(term)));
            let mut sums = [T::splat(simd, T::of(start)); CHAINS];
            for (i, sum) in sums.iter_mut().enumerate() {
                *sum = T::plus(simd, *sum, T::splat(simd, T::of(i as f64)));
            }
            for _ in 0..ROUNDS {
                for sum in &mut sums {
                    *sum = T::fma(simd, *sum, factor, term);
                }
            }
            let lanes: &[T] = bytemuck::cast_slice(&sums);
            (T::lanes::<S>(), lanes.iter().map(|x| x.f64()).sum())
        }
    }
    (0..repeats)
        .map(|_| {
            let start = Instant::now();
            let (lanes, sum) = Arch::new().dispatch(Chains::<T>(std::marker::PhantomData));
            std::hint::black_box(sum);
            (2 * CHAINS * ROUNDS * lanes) as f64 / start.elapsed().as_secs_f64()
        })
        .fold(0.0, f64::max)
}
