//! What a run needs to go on after any end: `checkpoint.hati` in its folder.
//!
//! ```text
//! "hatickp1"  length of the head  head (JSON)  filters and peaks  state of the solid (raw numbers)
//! ```
//!
//! It is written aside, flushed and renamed, after all rows that it counts are on the disk. So whatever ends the run,
//! there is either the checkpoint before or this one, whole, and every file holds at least its rows; a restart cuts
//! the files back to them.

use super::error::VolumeError;
use super::files::{RowCounts, Streams};
use crate::outputs::{OutputError, expect_room};
use hati_coupling::Ledger;
use hati_sem::solid::{Real, Solid};
use serde::{Deserialize, Serialize};
use std::fs::File;
use std::io::{BufReader, BufWriter, Read, Write as _};
use std::path::{Path, PathBuf};

/// Name in the run folder.
pub const NAME: &str = "checkpoint.hati";
const MAGIC: &[u8; 8] = b"hatickp1";
/// Longest head, bytes.
const HEAD_MOST: u64 = 1 << 24;

/// Everything of a checkpoint but large arrays.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct Head {
    /// SHA-256 of scene, mesh, records and version.
    pub(super) hash: String,
    /// Samples taken.
    pub(super) sample: usize,
    /// Whether the loop had ended.
    pub(super) complete: bool,
    /// Rows of the files.
    pub(super) rows: RowCounts,
    /// Bytes of filters and peaks.
    pub(super) streams: u64,
    pub(super) ledger: Ledger,
    pub(super) input_max: f64,
    /// Seconds that the loop has taken, and its steps alone.
    pub(super) seconds: [f64; 2],
    /// How many times the run went on.
    pub(super) restarts: usize,
}

/// Path of a run folder's checkpoint.
pub fn path(folder: &Path) -> PathBuf {
    folder.join(NAME)
}

/// Writes a checkpoint; all rows that it counts have to be on the disk.
pub(super) fn write<T: Real>(
    folder: &Path,
    mut head: Head,
    streams: &Streams,
    solid: &Solid<T>,
) -> Result<(), OutputError> {
    let path = path(folder);
    let mut state = vec![];
    streams.save(&mut state);
    head.streams = state.len() as u64;
    let head = serde_json::to_vec(&head).map_err(|cause| OutputError::Json { path: path.clone(), cause })?;
    expect_room(&path, ((solid.state_bytes() + state.len()) / 2) as u64)?;
    let aside = folder.join(format!(".{NAME}.part"));
    let written = (|| {
        let mut to = BufWriter::with_capacity(1 << 20, File::create(&aside)?);
        to.write_all(MAGIC)?;
        to.write_all(&(head.len() as u64).to_le_bytes())?;
        to.write_all(&head)?;
        to.write_all(&state)?;
        solid.write_state(&mut to)?;
        to.into_inner().map_err(std::io::IntoInnerError::into_error)?.sync_all()?;
        std::fs::rename(&aside, &path)
    })();
    if let Err(cause) = written {
        let _ = std::fs::remove_file(&aside);
        return Err(OutputError::from_io(&path, cause));
    }
    // the new name itself must reach the disk; some systems cannot flush a folder
    let _ = File::open(folder).and_then(|f| f.sync_all());
    Ok(())
}

/// A checkpoint whose head is read.
pub(super) struct Found {
    pub(super) head: Head,
    path: PathBuf,
    rest: BufReader<File>,
}

/// Opens the checkpoint of a folder; `None` where there is none. `hash` is that of the scene at hand.
pub(super) fn open(folder: &Path, hash: &str) -> Result<Option<Found>, VolumeError> {
    let path = path(folder);
    let damaged = |why: String| VolumeError::Checkpoint { path: path.clone(), why };
    let file = match File::open(&path) {
        Ok(file) => file,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(None),
        Err(error) => return Err(damaged(error.to_string())),
    };
    let mut rest = BufReader::with_capacity(1 << 20, file);
    let mut start = [0; 16];
    rest.read_exact(&mut start).map_err(|e| damaged(e.to_string()))?;
    let length = u64::from_le_bytes(std::array::from_fn(|i| start[8 + i]));
    if start[..8] != *MAGIC || length > HEAD_MOST {
        return Err(damaged("it is no checkpoint of this version of hati".into()));
    }
    let mut head = vec![0; length as usize];
    rest.read_exact(&mut head).map_err(|e| damaged(e.to_string()))?;
    let head: Head = serde_json::from_slice(&head).map_err(|e| damaged(e.to_string()))?;
    if head.hash != hash {
        return Err(VolumeError::OtherScene { path });
    }
    Ok(Some(Found { head, path, rest }))
}

impl Found {
    /// Gives filters, peaks and solid their state back.
    pub(super) fn restore<T: Real>(
        &mut self,
        streams: &mut Streams,
        solid: &mut Solid<T>,
    ) -> Result<(), VolumeError> {
        let path = self.path.clone();
        let damaged = |why: String| VolumeError::Checkpoint { path: path.clone(), why };
        let mut state = vec![];
        let mut part = (&mut self.rest).take(self.head.streams);
        part.read_to_end(&mut state).map_err(|e| damaged(e.to_string()))?;
        streams.restore(&state).ok_or_else(|| damaged("its filters or peaks are of another size".into()))?;
        solid.read_state(&mut self.rest).map_err(|e| damaged(e.to_string()))
    }
}

/// Takes the checkpoint of a finished run away.
pub(super) fn remove(folder: &Path) {
    let _ = std::fs::remove_file(path(folder));
}
