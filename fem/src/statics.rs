//! Statics: displacements and reactions under loads, the gravity stage.

use crate::{
    FemError,
    assembly::{Assembly, Operator},
    constraint::{Freedom, fits},
    sparse::SymmetricMatrix,
};

/// A structure at rest.
#[derive(Debug, Clone, PartialEq)]
pub struct StaticState {
    /// Free freedoms $q$.
    pub free: Vec<f64>,
    /// Every freedom, m and rad.
    pub displacement: Vec<f64>,
    /// Force or moment of each support on the structure, N or N·m.
    pub reactions: Vec<(Freedom, f64)>,
}

/// Solves $T^TKT\,q = T^T f - T^TKS\,s - T^TKg$ and recovers displacements and reactions.
///
/// - `stiffness`: $K$, with its geometric part where that is wanted;
/// - `load`: $f$ on all freedoms; `support`: prescribed $s$ in the order of the reduction's supports;
/// - `solve`: gives $A^{-1}b$ of a symmetric positive definite matrix.
///
/// Reactions are $S^T(K u - f)$: those of the supports, positive along the freedom. Errors: lengths
/// that do not fit; those of `solve`.
pub fn solve(
    assembly: &Assembly<'_>,
    stiffness: &Operator,
    load: &[f64],
    support: &[f64],
    solve: impl FnOnce(&SymmetricMatrix, &[f64]) -> Result<Vec<f64>, FemError>,
) -> Result<StaticState, FemError> {
    let reduction = assembly.reduction();
    let (mut right, on_supports) = reduction.reduce(load)?;
    for ((value, coupled), constant) in
        right.iter_mut().zip(stiffness.couple(support)?).zip(&stiffness.constant.0)
    {
        *value -= coupled + constant;
    }
    let free = solve(&stiffness.free, &right)?;
    fits("solution", free.len(), reduction.free())?;
    let held = stiffness.support_force(&free, support)?;
    let reactions = held.iter().zip(&on_supports).map(|(k, f)| k - f);
    Ok(StaticState {
        displacement: reduction.expand(&free, support)?,
        reactions: reduction.supports().iter().copied().zip(reactions).collect(),
        free,
    })
}
