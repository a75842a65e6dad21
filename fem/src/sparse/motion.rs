//! The free motion of a structure without a factor.

use super::{Factor, Ordering, Symbolic, SymmetricMatrix};
use crate::FemError;
use std::sync::Arc;

/// Share of the diagonal that is added so that a singular matrix has a factor.
const SUPPORT: f64 = 1e-9;

/// Rounds of inverse iteration: each takes the stiff part down by many digits.
const ROUNDS: usize = 5;

/// The motion of a mechanism: $x$ with $K x \approx 0$ that a force at freedom `freedom` sets off; its largest
/// entry is 1.
///
/// Inverse iteration with $K + 10^{-9} W$, $W = \mathrm{diag} K$, from a unit force at `freedom`, the one named
/// by [`FemError::Pivot`]; `groups` as in [`Symbolic::new`]. Returns the motion and its stiffness
/// $x^T K x / x^T W x$: round-off for a mechanism, and not small for a structure that was only said to be one.
///
/// Errors: those of [`Factor::definite`] (a negative eigenvalue: the structure has buckled).
pub fn free_motion(
    stiffness: &SymmetricMatrix,
    groups: &[u32],
    freedom: usize,
    threads: usize,
) -> Result<(Vec<f64>, f64), FemError> {
    let size = stiffness.size();
    if freedom >= size {
        return Err(FemError::Entry { row: freedom, column: freedom, size });
    }
    let diagonal = stiffness.diagonal();
    let largest = diagonal.iter().fold(0.0f64, |m, d| m.max(d.abs()));
    // a freedom without any stiffness is given some too
    let weight: Vec<f64> = diagonal
        .iter()
        .map(|d| if *d != 0.0 { d.abs() } else { largest })
        .map(|w| if w > 0.0 { w } else { 1.0 })
        .collect();
    let support = SymmetricMatrix::assemble(size, weight.iter().enumerate().map(|(i, w)| (i, i, *w)))?;
    let supported = SymmetricMatrix::combine(1.0, stiffness, SUPPORT, &support)?;
    let symbolic = Arc::new(Symbolic::new(&supported, groups, Ordering::default())?);
    let mut factor = Factor::definite(&symbolic, &supported, threads)?;
    let mut x = vec![0.0; size];
    x[freedom] = 1.0;
    for round in 0..ROUNDS {
        if round > 0 {
            x.iter_mut().zip(&weight).for_each(|(v, w)| *v *= w);
        }
        factor.solve(&mut x);
        let top = x.iter().fold(0.0f64, |m, v| if v.abs() > m.abs() { *v } else { m });
        x.iter_mut().for_each(|v| *v /= top);
    }
    let reference: f64 = x.iter().zip(&weight).map(|(v, w)| w * v * v).sum();
    let energy = stiffness.quadratic(&x) / reference;
    Ok((x, energy))
}
