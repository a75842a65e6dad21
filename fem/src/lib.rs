//! Finite elements of structures: beams, solids, springs, masses and exact constraints.
//!
//! A [`model::Model`] holds nodes, [`element`]s in named groups, supports and constraints. An
//! [`assembly::Assembly`] numbers its freedoms, resolves the constraints ($u = Tq + Ss + g$, no
//! penalties) and gives stiffness, mass, damping and loads over the free freedoms.
//!
//! ```
//! use hati_fem::{assembly::Assembly, check::check, element::EndReleases, material::Material,
//!     mesh::Member, model::Model, section::Section};
//!
//! // a column of 3 m, a steel tube, cut into four beams
//! let member = Member {
//!     section: Section::tube(0.2, 0.01, 0.3)?,
//!     material: Material::new(210e9, 0.3, 7850.0)?,
//!     orientation: [1.0, 0.0, 0.0],
//!     releases: EndReleases::default(),
//! };
//! let mut model = Model::new();
//! let ends = [model.add_node([0.0; 3]), model.add_node([0.0, 0.0, 3.0])];
//! let group = model.group("column");
//! member.add_to(&mut model, group, ends, 4)?;
//! model.fix("foot", ends[0]);
//! assert!(check(&model, 1).is_empty());
//!
//! let assembly = Assembly::new(&model)?;
//! assert_eq!(assembly.stiffness()?.free.size(), 4 * 6);
//! let mass = assembly.mass_properties()?;
//! assert!((mass.mass - member.section.area * 3.0 * 7850.0).abs() < 1e-9);
//! assert!((mass.centre[2] - 1.5).abs() < 1e-12);
//! # Ok::<(), hati_fem::FemError>(())
//! ```
//!
//! - [`material`], [`section`]: what members and solids are made of;
//! - [`element`]: beams, bars, hexahedra, tetrahedra, springs, dashpots, point masses;
//! - [`mesh`]: nodes and elements of a block and of a member;
//! - [`model`], [`constraint`], [`assembly`]: the structure and its equations;
//! - [`check`], [`mechanism`]: what is wrong with it, with names;
//! - [`statics`]: displacements and reactions at rest;
//! - [`modes`]: natural modes, effective masses, and the count that none is missed;
//! - [`reduction`]: a structure by its interface and a few of its modes;
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
pub mod modes;
pub mod reduction;
pub mod section;
pub mod sparse;
pub mod statics;

pub use error::FemError;

/// A number in $[-1, 1)$ of a fixed sequence (splitmix64): start vectors and probes are the same in every run.
fn random(state: &mut u64) -> f64 {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mut z = *state;
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((z ^ (z >> 31)) >> 11) as f64 * f64::powi(2.0, -52) - 1.0
}
