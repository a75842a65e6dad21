//! What can go wrong with an export.

use std::path::PathBuf;

use hati_inputs::InputError;

use crate::outputs::OutputError;

/// Failure to export a run folder; every variant names the file or folder.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ExportError {
    /// No such folder.
    #[error("{}: is no folder\n  help: name the folder that `hati run` wrote its results into", path.display())]
    NoRunFolder {
        /// What was named.
        path: PathBuf,
    },
    /// A file that is wanted is not in the run folder.
    #[error("{}: is not there, and what was asked for is made from it\n  help: name the folder that `hati run` wrote its results into", path.display())]
    Missing {
        /// The file.
        path: PathBuf,
    },
    /// No field over points in space.
    #[error("{}: holds no surface.nc, no volume.nc and no field.nc over x and z, from which VTKHDF is made\n  help: a column's field.nc goes over depth only: read it with xarray, or export its stations with --csv", path.display())]
    NoFields {
        /// The run folder.
        path: PathBuf,
    },
    /// No such station.
    #[error("{}: holds no place “{place}”\n  help: its places are {}", path.display(), known.join(", "))]
    Place {
        /// The file.
        path: PathBuf,
        /// What was asked for.
        place: String,
        /// Places that are there.
        known: Vec<String>,
    },
    /// The NetCDF library refused to read.
    #[error("{}: cannot be read, {action}: {cause}", path.display())]
    NetCdf {
        /// The file.
        path: PathBuf,
        /// What was being done.
        action: String,
        /// What the library said.
        cause: netcdf::Error,
    },
    /// A file that hati did not write, or wrote in another version.
    #[error("{}: {expected} is missing\n  help: this is no file of a run of this version of hati; run the scene again", path.display())]
    Layout {
        /// The file.
        path: PathBuf,
        /// What should be there.
        expected: String,
    },
    /// Nothing was recorded yet.
    #[error("{}: holds {found} rows where at least {expected} are expected\n  help: the run was stopped before it wrote them; run the scene again", path.display())]
    TooFewRows {
        /// The file.
        path: PathBuf,
        /// Rows found.
        found: usize,
        /// Rows wanted.
        expected: usize,
    },
    /// Samples that are not evenly spaced.
    #[error("{}: its samples are not evenly spaced (sample {sample} comes {found} s after the one before, the mean is {mean} s), which miniSEED and SAC cannot say\n  help: export it with --csv", path.display())]
    Uneven {
        /// The file.
        path: PathBuf,
        /// The first sample out of step, counted from 0.
        sample: usize,
        /// Its distance from the one before, s.
        found: f64,
        /// Mean distance, s.
        mean: f64,
    },
    /// While writing.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// What the Python side said.
    #[error(transparent)]
    Input(#[from] InputError),
}
