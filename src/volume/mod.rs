//! Ground in two and three dimensions under sources: from the scene to the run folder.
//!
//! ```text
//! Scene ─► VolumePlan: mesh, sizes, step, sources, sensors, with reasons ─► run: time loop, files, checkpoints
//!                                                                            └─► summary.json, report.html
//! ```
//!
//! - [`VolumePlan::new`] decides everything and assembles the ground; it runs no step but those of the spectral bound.
//! - [`run()`] takes the steps and writes; [`checkpoint`] lets it go on after any end.

pub mod checkpoint;
mod cost;
mod error;
mod explain;
mod fields;
mod files;
pub mod forces;
pub mod mesh;
mod picture;
mod plan;
mod report;
pub mod rounding;
mod run;
pub mod sampling;
pub mod sizes;
pub mod sources;
mod stations;
mod summary;
pub mod symmetry;

pub use error::VolumeError;
pub use mesh::MeshOptions;
pub use plan::{
    Limiting, PlannedField, PlannedSensor, PlannedSource, PlannedSurface, PlannedVolume, Reached, VolumePlan,
};
pub use run::{Outcome, VolumeControl, run};
