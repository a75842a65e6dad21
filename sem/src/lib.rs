//! Spectral elements for the ground: the layered column (D = 1), sections and volumes (D = 2, 3).
//! Displacement has three components in all of them.
//!
//! - [`gll`]: Gauss–Lobatto–Legendre points, weights, derivatives and interpolation, order 1–10.
//! - [`soil`], [`attenuation`]: layers, the causal constant-D modulus and its memory variables.
//! - [`column`]: the column as a subdomain: mesh, kernel, step, and its exact discrete frequency
//!   response, from which sizes are chosen and motions are deconvolved.
//! - [`mesh`]: quadrilaterals and hexahedra, made from layers or given; checks, places in them.
//! - [`numbering`]: the elements' own points.
//! - [`solid`]: sections and volumes as a subdomain: supports, loads, kernels, step, energies.

mod aligned;
pub mod attenuation;
pub mod column;
mod error;
pub mod gll;
pub mod mesh;
pub mod numbering;
mod prefetch;
pub mod soil;
pub mod solid;

pub use error::SemError;
