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
    #[error("no space left on the disk for {}: {}\n  help: free space or choose another disk with --out", path.display(), state(room.as_ref()))]
    DiskFull {
        /// The file that was to be written.
        path: PathBuf,
        /// Where the file was not even touched: what was wanted and what is free.
        room: Option<Room>,
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
    /// A file of an earlier run that a restart cannot go on with.
    #[error("cannot go on with {}: {why}\n  help: run without --restart, or choose another folder with --out", path.display())]
    Unresumable {
        /// The file.
        path: PathBuf,
        /// Why not.
        why: Unresumable,
    },
    /// Rows closer together than the samples they are made from.
    #[error(
        "rows every {dt_out} s cannot be made from samples every {dt} s that begin at {first} s\n  help: ask for rows no closer together than the step"
    )]
    Schedule {
        /// Time between samples, s.
        dt: f64,
        /// Time between rows, s.
        dt_out: f64,
        /// Time of the first sample, s.
        first: f64,
    },
    /// A stored state of another size or set-up than the one it should go into.
    #[error(
        "the stored state of {what} has {found} bytes where {expected} are expected\n  help: it belongs to another scene; run without --restart"
    )]
    State {
        /// What it is the state of.
        what: &'static str,
        /// Bytes given.
        found: usize,
        /// Bytes asked for.
        expected: usize,
    },
    /// The thread that writes ended at an earlier failure, which was told then.
    #[error("nothing more can be written: the writer ended at the failure told before")]
    WriterEnded,
    /// A figure's image could not be encoded.
    #[error("cannot encode the image of {}: {cause}", path.display())]
    Image {
        /// The figure's file.
        path: PathBuf,
        /// What the encoder said.
        cause: png::EncodingError,
    },
}

/// Why a restart cannot go on with a file.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Unresumable {
    /// It is compressed, as only a finished run leaves it.
    #[error("the run that wrote it is finished")]
    Finished,
    /// It cannot be read.
    #[error("it is no file that hati wrote for a run under way")]
    Unreadable,
    /// Its dimensions or variables are others.
    #[error("the scene asks for {what}, and the file does not hold that")]
    OtherLayout {
        /// The first that differs.
        what: String,
    },
    /// It holds fewer rows than the checkpoint tells of.
    #[error("it has {found} rows where {expected} are expected")]
    TooShort {
        /// Rows in the file.
        found: u64,
        /// Rows at the checkpoint.
        expected: u64,
    },
}

/// Room on a file system, found too small before anything was written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Room {
    /// Bytes wanted: those of the next part twice, and a mebibyte.
    pub wanted: u64,
    /// Bytes free.
    pub free: u64,
}

/// What a full disk means for the file.
fn state(room: Option<&Room>) -> String {
    match room {
        Some(Room { wanted, free }) => format!(
            "its next part was not begun, since that wants {} MiB with a reserve and {} MiB are free; what was \
             written before is intact",
            mebibytes(*wanted, f64::ceil),
            mebibytes(*free, f64::floor)
        ),
        None => "it was cut off in the middle; files that were complete before are intact".to_owned(),
    }
}

/// Mebibytes with one decimal, rounded to the side that `round` says.
fn mebibytes(bytes: u64, round: fn(f64) -> f64) -> String {
    format!("{:.1}", round(bytes as f64 / f64::from(1 << 20) * 10.0) / 10.0)
}

impl OutputError {
    /// Sorts a failure of the system into disk full, unwritable folder or anything else.
    pub(crate) fn from_io(path: &Path, cause: std::io::Error) -> Self {
        use std::io::ErrorKind;
        let path = path.to_path_buf();
        match cause.kind() {
            ErrorKind::StorageFull | ErrorKind::QuotaExceeded => Self::DiskFull { path, room: None },
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

/// Room kept free beside every part, bytes: for what a library writes about it and for the small files.
const RESERVE: u64 = 1 << 20;

/// Refuses to begin a part of `bytes` bytes unless the file system has room for it twice and a mebibyte more.
///
/// HDF5 keeps chunks in memory and writes them when it flushes; one that fails half-way may leave a file
/// that does not open. A file system that does not tell its room counts as having enough.
pub(crate) fn expect_room(path: &Path, bytes: u64) -> Result<(), OutputError> {
    let wanted = bytes.saturating_mul(2).saturating_add(RESERVE);
    match free(&folder_of(path)) {
        Some(free) if free < wanted => {
            Err(OutputError::DiskFull { path: path.to_path_buf(), room: Some(Room { wanted, free }) })
        }
        _ => Ok(()),
    }
}

/// Bytes that the file system of a folder has free for this user.
#[cfg(unix)]
fn free(folder: &Path) -> Option<u64> {
    let told = rustix::fs::statvfs(folder).ok()?;
    // Some file systems of networks and of user space tell nothing at all.
    (told.f_blocks > 0).then(|| told.f_bavail.saturating_mul(told.f_frsize))
}

#[cfg(not(unix))]
fn free(_: &Path) -> Option<u64> {
    None
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
