//! Finite elements of structures: beams, solids, springs, masses and exact constraints.
//!
//! A [`model::Model`] holds nodes, [`element`]s in named groups, supports and constraints. An
//! [`assembly::Assembly`] numbers its freedoms, resolves the constraints ($u = Tq + Ss + g$, no
//! penalties) and gives stiffness, mass, damping and loads over the free freedoms.
//!
//! - [`material`], [`section`]: what members and solids are made of;
//! - [`element`]: beams, bars, hexahedra, tetrahedra, springs, dashpots, point masses;
//! - [`mesh`]: nodes and elements of a block and of a member;
//! - [`model`], [`constraint`], [`assembly`]: the structure and its equations;
//! - [`check`], [`mechanism`]: what is wrong with it, with names;
//! - [`statics`]: displacements and reactions at rest;
//! - [`sparse`]: symmetric sparse matrices, their factors and solves.

pub mod assembly;
pub mod check;
pub mod constraint;
pub mod element;
mod error;
pub mod material;
pub mod mechanism;
pub mod mesh;
pub mod model;
pub mod section;
pub mod sparse;
pub mod statics;

pub use error::FemError;
