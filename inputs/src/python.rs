//! Where the Python is that reads records and meshes geometries.

use std::path::{Path, PathBuf};

/// The interpreter to start, and in words where it was looked for.
///
/// HATI_PYTHON; else `.venv/bin/python` in the current folder or above it, or in the folder of this
/// program or above it; else `python3` on the PATH. The path is not resolved further: a virtual
/// environment is known by the link that starts it.
pub(crate) fn find_python() -> (PathBuf, String) {
    if let Some(python) = std::env::var_os("HATI_PYTHON").filter(|value| !value.is_empty()) {
        let tried = format!("HATI_PYTHON = {}", Path::new(&python).display());
        return (PathBuf::from(python), tried);
    }
    let current = std::env::current_dir().ok();
    let program = std::env::current_exe().ok();
    let starts = [current.as_deref(), program.as_deref().and_then(Path::parent)];
    let mut folders = starts.iter().flatten().flat_map(|start| start.ancestors());
    let found = folders.by_ref().map(|folder| folder.join(".venv/bin/python")).find(|python| python.exists());
    let tried = ".venv/bin/python in the current folder and above it, beside the program and above it, \
                 and python3 on the PATH";
    (found.unwrap_or_else(|| PathBuf::from("python3")), tried.to_string())
}
