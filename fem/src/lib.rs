//! Finite elements of structures: beams, solids, springs, masses and exact constraints.
//!
//! - [`sparse`]: symmetric sparse matrices, their factors and solves.

mod error;
pub mod sparse;

pub use error::FemError;
