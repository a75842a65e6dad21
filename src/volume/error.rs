//! What ends a run early.

use crate::outputs::OutputError;
use crate::plan::PlanError;
use crate::run::RunError;
use std::path::PathBuf;

/// What ends a run in two or three dimensions early.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum VolumeError {
    /// As a column's run.
    #[error(transparent)]
    Run(#[from] RunError),
    /// The checkpoint belongs to another scene.
    #[error(
        "{}: the checkpoint is that of another scene, mesh, record or version of hati\n  help: give the scene and the --set of the first run, or run without --restart", path.display()
    )]
    OtherScene {
        /// The checkpoint.
        path: PathBuf,
    },
    /// The checkpoint cannot be read.
    #[error("{}: the checkpoint cannot be gone on with: {why}\n  help: run without --restart", path.display())]
    Checkpoint {
        /// The checkpoint.
        path: PathBuf,
        /// Why not.
        why: String,
    },
    /// No threads to be had.
    #[error("{threads} threads cannot be started: {why}\n  help: give fewer --threads")]
    Threads {
        /// How many.
        threads: usize,
        /// Why not.
        why: String,
    },
}

impl From<OutputError> for VolumeError {
    fn from(error: OutputError) -> Self {
        Self::Run(error.into())
    }
}

impl From<PlanError> for VolumeError {
    fn from(error: PlanError) -> Self {
        Self::Run(error.into())
    }
}
