//! Laws of the elements of one batch, a lane an element.

use super::block::Pass;
use super::model::Model;
use super::real::Real;
use bytemuck::cast_slice;
use pulp::Simd;

/// Laws of a batch's materials, one for each class of points ([`super::Memory`]), a lane an element.
pub(super) struct Laws<'a, V> {
    /// Class of each point.
    pub class: &'a [u8],
    /// Moduli beside the arms, `[class]`, Pa.
    pub lambda: &'a [V],
    /// The same of μ.
    pub mu: &'a [V],
    /// Arms of a point.
    pub arms_per_point: usize,
    /// `[class][arm]`.
    pub arms: &'a [ArmLanes<V>],
}

/// One arm of a batch's materials, a lane an element: $g = 1/(1+x)$; $2x$; $\lambda_l$ and $\mu_l$, Pa; and
/// $1 + 1/d$ and $g/d$ with $d = (1-x)/(1+x)$, which take the arm's strain back to the kick before:
/// $e + e^- = (1 + 1/d)\,e - (g/d)\,\Delta\varepsilon$.
pub(super) type ArmLanes<V> = [V; ARM_NUMBERS];

/// Numbers of an arm.
pub(super) const ARM_NUMBERS: usize = 6;

/// Laws of a batch's classes: relaxed with their arms, or unrelaxed and without.
#[inline(always)]
pub(super) fn laws<T: Real, S: Simd>(model: &Model<T>, pass: Pass, batch: usize) -> Laws<'_, T::Vector<S>> {
    let size = model.classes * T::lanes::<S>();
    let moduli = if pass == Pass::UnrelaxedForce { &model.unrelaxed } else { &model.moduli };
    let arms = if pass == Pass::UnrelaxedForce { 0 } else { model.arms };
    let numbers = size * arms * ARM_NUMBERS;
    Laws {
        class: &model.class,
        lambda: cast_slice(&moduli.lambda[batch * size..(batch + 1) * size]),
        mu: cast_slice(&moduli.mu[batch * size..(batch + 1) * size]),
        arms_per_point: arms,
        arms: cast_slice::<T, ArmLanes<T::Vector<S>>>(
            &model.arm_lanes[batch * numbers..(batch + 1) * numbers],
        ),
    }
}
