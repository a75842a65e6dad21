//! Finite elements of structures: beams, solids, springs, masses and exact constraints.
//!
//! - [`modes`]: natural modes, effective masses, and the count that none is missed.
//! - [`reduction`]: a structure by its interface and a few of its modes.
//! - [`sparse`]: symmetric sparse matrices, their factors and solves.

mod error;
pub mod modes;
pub mod reduction;
pub mod sparse;

pub use error::FemError;

/// A number in $[-1, 1)$ of a fixed sequence (splitmix64): start vectors and probes are the same in every run.
fn random(state: &mut u64) -> f64 {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mut z = *state;
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((z ^ (z >> 31)) >> 11) as f64 * f64::powi(2.0, -52) - 1.0
}
