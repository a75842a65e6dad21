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
mod explain;
mod fields;
mod files;
pub mod forces;
pub mod mesh;
mod plan;
mod report;
mod run;
pub mod sampling;
pub mod sizes;
pub mod sources;
mod summary;

pub use files::VolumeError;
pub use mesh::MeshOptions;
pub use plan::{Limiting, PlannedField, PlannedSensor, PlannedSurface, PlannedVolume, VolumePlan};
pub use run::{Outcome, VolumeControl, run};
