//! Scene files: what a user writes to describe a run, read, checked and written back with every choice made.
//!
//! ```text
//! scene.toml ──load──► Scene ──(the plan chooses what is "auto")──► resolved_toml ──► scene.resolved.toml
//!                 └──► Diagnostics: every mistake at once, with line, key and advice
//! ```
//!
//! - [`Scene`] and its parts are the format; the comments on their fields are its reference, from which [`schema`]
//!   (JSON Schema) and [`reference_markdown`] (the book's page) are made.
//! - [`load`], [`load_with`] and [`load_str`] read a scene. Each section is read on its own, so that one mistake hides
//!   no other; overrides (`soil.layer[2].vs=300`) are checked like the rest.
//! - [`Scene::layers`], [`Scene::stations`], [`Base::half_space`] and the like fill in what the format lets a user
//!   leave out; for a scene with a [`Domain`] [`Scene::materials`], [`Scene::sources`], [`Scene::sensors`] and
//!   [`Scene::boundary_kind`] do.
//! - [`resolved_toml`] writes a scene with every value and where it came from; the text loads again to the same run.

mod check;
mod diagnostic;
mod document;
mod files;
mod load;
mod process_text;
mod pulse;
mod resolved;
mod schema;
mod topography;
mod types;
mod values;
mod volume;
mod volume_values;
mod wavelet;

pub use crate::motion::{Process, Quantity};
pub use crate::records::{ResponseMode, Unit};
pub use diagnostic::{Diagnostic, Diagnostics, Severity};
pub use load::{Source, Written, load, load_str, load_with};
pub use pulse::{Pulse, PulseKind, erf};
pub use resolved::{Resolved, resolved_toml};
pub use schema::{reference_markdown, schema};
pub use topography::Topography;
pub use types::{
    Auto, Band, Base, Component, DEFAULT_NU, Discretisation, FieldSpacing, Layer, Motion, MotionKind, Output,
    RecordFile, Scene, Soil, StationEntry, Synthetic,
};
pub use values::{HalfSpace, LayerValues, Station, nu_from_speeds, vp_from_nu};
pub use volume::{
    BoundaryKind, Checkpoint, Domain, FieldOutput, Material, MemoryVariables, OutputQuantity, Precision, Run,
    SourceEntry, SourceKind, SurfaceOutput, VolumeOutput,
};
pub use volume_values::{Action, MaterialValues, Place, Sensor, SourceTerm, TimeFunction};
pub use wavelet::{Wavelet, WaveletKind};
