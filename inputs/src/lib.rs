//! What a user hands in to `hati`, read, checked and turned into SI units.
//!
//! | module | holds |
//! |---|---|
//! | [`records`] | accelerograms of observatories, read by ObsPy in a child process, with their units made sure of |
//! | [`motion`] | a motion of one to three components: offset, scale, band, taper, integration, resampling |
//! | [`measures`] | peaks, Arias intensity, duration, response spectra, Fourier amplitudes |
//! | [`gmsh`] | meshes that Gmsh wrote, with materials and boundaries by their names; `.geo` files meshed by it |
//! | [`scene`] | scene files: format, schema, checks that name every mistake at once, resolved scenes |
//!
//! A record becomes a motion in three lines:
//! ```no_run
//! use hati_inputs::{motion::{Motion, Process}, records};
//! # fn main() -> Result<(), hati_inputs::InputError> {
//! let channels = records::read("station.EW2".as_ref(), &records::ReadOptions::default())?;
//! let mut motion = Motion::from_channels([Some(&channels[0]), None, None])?;
//! Process::Demean { first_seconds: None }.apply(&mut motion)?;
//! # Ok(()) }
//! ```
//!
//! Nothing here prints or panics on what a user gives; every refusal is an [`InputError`] that says
//! what to do. Every operation on a motion leaves a [`records::Step`] with its numbers.

mod error;
pub mod gmsh;
pub mod measures;
pub mod motion;
mod number;
mod python;
pub mod records;
pub mod scene;

pub use error::InputError;
