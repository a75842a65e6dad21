//! Subdomains, time integrators and the energy ledger. This crate knows no physics.
//!
//! A part of a scene is a [`Subdomain`]: it takes its own steps, shows its position and velocity on
//! its interfaces, feels a multiplier there, states its energies, and can be saved and restored. It
//! never hands out a matrix; what `coupling` needs of an operator it finds by unit multipliers
//! ([`window_response`]).
//!
//! - [`central_difference`]: the explicit update of one freedom, drift–kick–drift; an integrator's
//!   formula stands once, here, and kernels that fuse the update call it.
//! - [`alpha`]: the implicit schemes of the α family (Chung and Hulbert, HHT, WBZ, Newmark), one freedom at a time.
//! - [`spectral_bound`]: the largest eigenfrequency of an assembled operator, hence the critical step.
//! - [`ledger`]: the energy balance of a run and its closing error.

pub mod alpha;
pub mod central_difference;
mod error;
pub mod ledger;
pub mod spectral_bound;
mod subdomain;

pub use error::CouplingError;
pub use ledger::{Energies, Ledger};
pub use subdomain::{State, Subdomain, window_response};
