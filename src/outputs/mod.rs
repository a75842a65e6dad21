//! Files of a run folder: NetCDF time series and fields, the energy ledger, and small JSON files.
//!
//! | file | writer | content |
//! |---|---|---|
//! | `stations.nc` | [`StationsWriter`] | motions at named depths (CF `timeSeries`) and the input motions |
//! | `field.nc` | [`FieldWriter`] | motion of the whole column on a regular depth grid, peak values with depth |
//! | `surface.nc`, `volume.nc`, `field.nc` in 2D and 3D | [`wave::WaveWriter`] | motion over points and cells (UGRID), or a regular grid |
//! | `ledger.nc` | [`LedgerWriter`] | cumulative energies over time and the closing error |
//! | `summary.json`, `progress.json` | [`write_summary`], [`write_progress`] | replaced in one step, never half written |
//!
//! Stations, fields and the ledger never share a file: CF forbids mixing sampling geometries.
//!
//! **Reading while a run goes on.** A writer touches its file only inside `append`, which adds whole
//! rows and then flushes them to the disk; between two appends the file is complete. HDF5 locks an
//! open file by default, and a reader is then refused. The lock can be switched off only by the
//! environment variable `HDF5_USE_FILE_LOCKING`, which HDF5 reads when it first opens a file:
//! [`restart_without_file_locking`] sets it for a program. Where it is not set the files are the
//! same, and a reader that sets the variable itself can still open them during the run. A reader that
//! comes in the middle of an append may be told of an HDF error, or see a shorter file; it has to look
//! again a moment later.
//!
//! **A disk that fills up.** Before each part the file system is asked for its room, and where the part
//! would not fit, the writer refuses ([`OutputError::DiskFull`]) without having touched the file.

mod classic;
mod compress;
pub mod decimate;
mod error;
mod field;
mod file;
mod json;
mod ledger;
mod locking;
mod provenance;
mod stations;
pub mod thread;
pub mod wave;

pub(crate) use classic::aside;
pub(crate) use error::expect_room;
pub use error::{OutputError, Room, Unresumable};
pub use field::{FieldChunk, FieldWriter};
pub(crate) use json::replace_bytes;
pub use json::{write_progress, write_summary};
pub use ledger::LedgerWriter;
pub use locking::{FILE_LOCKING_VARIABLE, file_locking_is_off, restart_without_file_locking};
pub use provenance::Provenance;
pub use stations::{StationsWriter, TraceChunk, TraceLayout};
