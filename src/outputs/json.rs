//! Small JSON files that are replaced in one step.

use std::io::Write as _;
use std::path::Path;

use serde_json::Value;

use super::OutputError;
use super::error::folder_of;

/// Writes `summary.json`: aside, flushed to the disk, then renamed over `path`.
///
/// A reader finds the old content or the new one, never a part, also after a power cut.
///
/// # Errors
/// Unwritable folder, full disk.
pub fn write_summary(path: &Path, summary: &Value) -> Result<(), OutputError> {
    replace(path, summary, true)
}

/// Writes `progress.json` as [`write_summary`] does, but leaves the flush to the system: it is
/// rewritten every few seconds and worth nothing after a crash.
///
/// # Errors
/// Unwritable folder, full disk.
pub fn write_progress(path: &Path, progress: &Value) -> Result<(), OutputError> {
    replace(path, progress, false)
}

fn replace(path: &Path, value: &Value, flush: bool) -> Result<(), OutputError> {
    let mut text = serde_json::to_vec_pretty(value)
        .map_err(|cause| OutputError::Json { path: path.to_path_buf(), cause })?;
    text.push(b'\n');
    replace_bytes(path, &text, flush)
}

/// Replaces the file `path` by `content` in one step.
pub(crate) fn replace_bytes(path: &Path, content: &[u8], flush: bool) -> Result<(), OutputError> {
    let folder = folder_of(path);
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let aside = folder.join(format!(".{name}.{}.part", std::process::id()));
    let outcome = std::fs::File::create(&aside)
        .and_then(|mut file| {
            file.write_all(content)?;
            if flush { file.sync_all() } else { Ok(()) }
        })
        .and_then(|()| std::fs::rename(&aside, path));
    if let Err(cause) = outcome {
        let _ = std::fs::remove_file(&aside);
        return Err(OutputError::from_io(path, cause));
    }
    if flush {
        // The new name itself must reach the disk; some systems cannot flush a folder.
        let _ = std::fs::File::open(&folder).and_then(|f| f.sync_all());
    }
    Ok(())
}
