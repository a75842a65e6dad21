//! Spectral elements for the ground. Today D = 1: the layered column with three components.
//!
//! - [`gll`]: Gauss–Lobatto–Legendre points, weights, derivatives and interpolation, order 1–10.
//! - [`soil`]: layers and the base of a profile.
//! - [`attenuation`]: the causal constant-D modulus and its memory variables.
//! - [`column`]: the column as a subdomain: mesh, kernel, step, and its exact discrete frequency
//!   response, from which sizes are chosen and motions are deconvolved.

mod aligned;
pub mod attenuation;
pub mod column;
mod error;
pub mod gll;
pub mod mesh;
pub mod numbering;
pub mod soil;
pub mod solid;

pub use error::SemError;
