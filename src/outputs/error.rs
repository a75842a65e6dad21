//! What can go wrong when a run writes its results.

use std::io::Write as _;
use std::path::{Path, PathBuf};

/// Failure to write a result; every variant names the file or folder.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum OutputError {
    /// The folder is missing, is not a folder or may not be written to.
    #[error("cannot write into folder {}: {cause}\n  help: create it, free it for writing, or choose another one with --out", folder.display())]
    UnwritableFolder {
        /// The folder.
        folder: PathBuf,
        /// What the system said.
        cause: std::io::Error,
    },
    /// The file system has no room left.
    #[error("no space left on the disk while writing {}\n  help: free space or choose another disk with --out; what was written before is intact", path.display())]
    DiskFull {
        /// The file that was being written.
        path: PathBuf,
    },
    /// Any other failure of the operating system.
    #[error("cannot write {}: {cause}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system said.
        cause: std::io::Error,
    },
    /// The NetCDF library refused an operation.
    #[error("NetCDF could not {action} in {}: {cause}", path.display())]
    NetCdf {
        /// The file.
        path: PathBuf,
        /// What was being done, for instance `define variable acceleration_x`.
        action: String,
        /// What the library said.
        cause: netcdf::Error,
    },
    /// An array has another length than the file's layout asks for.
    #[error("{}: {variable} has {found} values where {expected} are expected", path.display())]
    Length {
        /// The file.
        path: PathBuf,
        /// The variable, or what was counted.
        variable: String,
        /// Length given.
        found: usize,
        /// Length asked for.
        expected: usize,
    },
    /// A component number above 2, or a component that the file was not created with.
    #[error("{}: component {axis} is not in this file (0 = x, 1 = y, 2 = z; created with {available:?})", path.display())]
    Axis {
        /// The file.
        path: PathBuf,
        /// Component given.
        axis: usize,
        /// Components that the file has.
        available: Vec<usize>,
    },
    /// A value could not be turned into JSON text.
    #[error("cannot write {} as JSON: {cause}", path.display())]
    Json {
        /// The file.
        path: PathBuf,
        /// What the encoder said.
        cause: serde_json::Error,
    },
    /// A figure's image could not be encoded.
    #[error("cannot encode the image of {}: {cause}", path.display())]
    Image {
        /// The figure's file.
        path: PathBuf,
        /// What the encoder said.
        cause: png::EncodingError,
    },
}

impl OutputError {
    /// Sorts a failure of the system into disk full, unwritable folder or anything else.
    pub(crate) fn from_io(path: &Path, cause: std::io::Error) -> Self {
        use std::io::ErrorKind;
        let path = path.to_path_buf();
        match cause.kind() {
            ErrorKind::StorageFull | ErrorKind::QuotaExceeded => Self::DiskFull { path },
            ErrorKind::NotFound
            | ErrorKind::PermissionDenied
            | ErrorKind::ReadOnlyFilesystem
            | ErrorKind::NotADirectory => Self::UnwritableFolder { folder: folder_of(&path), cause },
            _ => Self::Io { path, cause },
        }
    }

    /// Wraps a failure of the NetCDF library.
    ///
    /// HDF5 hides the system's reason behind one number, so a trial file of 1 MiB beside the output
    /// tells a full disk and an unwritable folder from a fault of the library.
    pub(crate) fn from_netcdf(path: &Path, action: impl Into<String>, cause: netcdf::Error) -> Self {
        match trial_write(&folder_of(path)) {
            Err(reason) => match Self::from_io(path, reason) {
                Self::Io { .. } => Self::netcdf_as_is(path, action.into(), cause),
                recognised => recognised,
            },
            Ok(()) => Self::netcdf_as_is(path, action.into(), cause),
        }
    }

    fn netcdf_as_is(path: &Path, action: String, cause: netcdf::Error) -> Self {
        Self::NetCdf { path: path.to_path_buf(), action, cause }
    }
}

/// Folder that holds `path`; the current folder for a bare name.
pub(crate) fn folder_of(path: &Path) -> PathBuf {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent.to_path_buf(),
        _ => PathBuf::from("."),
    }
}

fn trial_write(folder: &Path) -> std::io::Result<()> {
    let trial = folder.join(format!(".hati-trial-{}", std::process::id()));
    let outcome = std::fs::File::create(&trial).and_then(|mut file| {
        file.write_all(&vec![0x5a_u8; 1 << 20])?;
        file.sync_all()
    });
    let _ = std::fs::remove_file(&trial);
    outcome
}
