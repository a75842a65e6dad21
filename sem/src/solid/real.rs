//! Precision and vector width of a kernel, without unsafe code of our own: `pulp` hides the intrinsics.

use bytemuck::Pod;
use pulp::Simd;
use std::ops::{Add, AddAssign, Mul, Sub};

/// Precision in which a solid computes: `f32` or `f64`.
///
/// A vector holds the same quantity of several elements, one element a lane; its width is that of the
/// machine's registers, told at run time by [`Real::lanes`] of the chosen instruction set.
pub trait Real:
    Copy
    + Default
    + PartialOrd
    + Send
    + Sync
    + Pod
    + std::fmt::Debug
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + AddAssign
    + super::step::Kernels
    + 'static
{
    /// Name for tables: `f32` or `f64`.
    const NAME: &'static str;
    /// Unit round-off.
    const EPSILON: f64;
    /// A vector of the instruction set `S`.
    type Vector<S: Simd>: Copy + Pod + Send + Sync + std::fmt::Debug;

    /// Rounds to this precision.
    fn of(x: f64) -> Self;
    /// Widens to f64.
    fn f64(self) -> f64;
    /// A position, m, rounded to multiples of $2^{-90}$ m where it is below $10^{-20}$ m; f64 as it is.
    ///
    /// Ahead of a wave front a discrete motion falls off faster than any exponential and comes to the numbers
    /// below f32's smallest normal one, with which processors compute ten times slower: a ground at rest would cost
    /// seven times the step of one that moves. Adding and taking off $2^{-66}$ m rounds them away.
    fn settle(self) -> Self;

    /// Elements side by side in a vector of `S`.
    fn lanes<S: Simd>() -> usize {
        size_of::<Self::Vector<S>>() / size_of::<Self>()
    }
    /// The same value in every lane.
    fn splat<S: Simd>(simd: S, x: Self) -> Self::Vector<S>;
    /// a + b
    fn plus<S: Simd>(simd: S, a: Self::Vector<S>, b: Self::Vector<S>) -> Self::Vector<S>;
    /// a − b
    fn minus<S: Simd>(simd: S, a: Self::Vector<S>, b: Self::Vector<S>) -> Self::Vector<S>;
    /// a b
    fn times<S: Simd>(simd: S, a: Self::Vector<S>, b: Self::Vector<S>) -> Self::Vector<S>;
    /// a / b
    fn over<S: Simd>(simd: S, a: Self::Vector<S>, b: Self::Vector<S>) -> Self::Vector<S>;
    /// a b + c, fused where the machine can
    fn fma<S: Simd>(simd: S, a: Self::Vector<S>, b: Self::Vector<S>, c: Self::Vector<S>) -> Self::Vector<S>;
}

macro_rules! real {
    ($t:ident, $vector:ident, $splat:ident, $add:ident, $sub:ident, $mul:ident, $div:ident, $fma:ident, $settle:expr) => {
        impl Real for $t {
            const NAME: &'static str = stringify!($t);
            const EPSILON: f64 = $t::EPSILON as f64;
            type Vector<S: Simd> = S::$vector;

            #[inline(always)]
            fn of(x: f64) -> Self {
                x as $t
            }
            #[inline(always)]
            fn f64(self) -> f64 {
                f64::from(self)
            }
            #[inline(always)]
            fn settle(self) -> Self {
                const { $settle }.map_or(self, |offset: Self| (self + offset) - offset)
            }
            #[inline(always)]
            fn splat<S: Simd>(simd: S, x: Self) -> S::$vector {
                simd.$splat(x)
            }
            #[inline(always)]
            fn plus<S: Simd>(simd: S, a: S::$vector, b: S::$vector) -> S::$vector {
                simd.$add(a, b)
            }
            #[inline(always)]
            fn minus<S: Simd>(simd: S, a: S::$vector, b: S::$vector) -> S::$vector {
                simd.$sub(a, b)
            }
            #[inline(always)]
            fn times<S: Simd>(simd: S, a: S::$vector, b: S::$vector) -> S::$vector {
                simd.$mul(a, b)
            }
            #[inline(always)]
            fn over<S: Simd>(simd: S, a: S::$vector, b: S::$vector) -> S::$vector {
                simd.$div(a, b)
            }
            #[inline(always)]
            fn fma<S: Simd>(simd: S, a: S::$vector, b: S::$vector, c: S::$vector) -> S::$vector {
                simd.$fma(a, b, c)
            }
        }
    };
}
real!(
    f32,
    f32s,
    splat_f32s,
    add_f32s,
    sub_f32s,
    mul_f32s,
    div_f32s,
    mul_add_e_f32s,
    Some(1.0 / (1_u128 << 66) as f32)
);
real!(f64, f64s, splat_f64s, add_f64s, sub_f64s, mul_f64s, div_f64s, mul_add_e_f64s, None);
