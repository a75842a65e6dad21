//! From the words of a user to the bytes of one local, regular file.

use std::fs::{self, File};
use std::io::{ErrorKind, Read};
use std::path::{Component, Path, PathBuf};

use crate::error::InputError;

/// Prefix of files that come with the installed ObsPy package.
const PACKAGED: &str = "obspy:";

/// The path after `obspy:`, checked to stay inside a folder; `None` for an ordinary location.
pub(super) fn packaged(location: &Path) -> Result<Option<PathBuf>, InputError> {
    let Some(rest) = location.to_str().and_then(|text| text.strip_prefix(PACKAGED)) else {
        return Ok(None);
    };
    let path = PathBuf::from(rest);
    let inside = path.components().all(|part| matches!(part, Component::Normal(_)));
    if rest.is_empty() || !inside {
        return Err(outside(location));
    }
    Ok(Some(path))
}

fn outside(location: &Path) -> InputError {
    InputError::PackagedOutside { location: location.display().to_string() }
}

/// Content of a file inside the ObsPy package at `root`; links that leave it are refused.
pub(super) fn content_packaged(
    location: &Path,
    root: &Path,
    inner: &Path,
    limit: u64,
) -> Result<Vec<u8>, InputError> {
    let path = root.join(inner);
    if let (Ok(root), Ok(real)) = (root.canonicalize(), path.canonicalize())
        && !real.starts_with(&root)
    {
        return Err(outside(location));
    }
    content_named(&path, location, limit)
}

/// Content of a local file.
pub(super) fn content(location: &Path, limit: u64) -> Result<Vec<u8>, InputError> {
    if is_url(location) {
        return Err(InputError::LocationIsUrl { location: location.display().to_string() });
    }
    content_named(location, location, limit)
}

fn is_url(location: &Path) -> bool {
    let text = location.to_string_lossy();
    let Some((scheme, _)) = text.split_once("://") else {
        return false;
    };
    scheme.starts_with(|c: char| c.is_ascii_alphabetic())
        && scheme.chars().all(|c| c.is_ascii_alphanumeric() || "+.-".contains(c))
}

/// Reads `path`; errors speak of `shown`.
fn content_named(path: &Path, shown: &Path, limit: u64) -> Result<Vec<u8>, InputError> {
    let shown = || shown.to_path_buf();
    let unreadable = |source| InputError::RecordUnreadable { path: shown(), source };
    let meta = match fs::metadata(path) {
        Ok(meta) => meta,
        Err(error) if matches!(error.kind(), ErrorKind::NotFound | ErrorKind::NotADirectory) => {
            let text = path.to_string_lossy();
            return Err(if text.contains(['*', '?', '[']) {
                InputError::LocationIsPattern { location: shown().display().to_string() }
            } else {
                InputError::RecordMissing { path: shown() }
            });
        }
        Err(error) => return Err(unreadable(error)),
    };
    if meta.is_dir() {
        return Err(InputError::RecordIsFolder { path: shown() });
    }
    if !meta.is_file() {
        return Err(InputError::RecordNotRegular { path: shown() });
    }
    let too_large = |bytes| InputError::RecordTooLarge { path: shown(), bytes, limit };
    if meta.len() > limit {
        return Err(too_large(meta.len()));
    }
    let mut bytes = Vec::with_capacity(meta.len() as usize);
    File::open(path)
        .and_then(|file| file.take(limit.saturating_add(1)).read_to_end(&mut bytes))
        .map_err(unreadable)?;
    // The file may have grown since its size was asked for.
    if bytes.len() as u64 > limit {
        return Err(too_large(bytes.len() as u64));
    }
    if bytes.is_empty() {
        return Err(InputError::RecordEmpty { path: shown() });
    }
    Ok(bytes)
}
