//! Python for the tests that read records or look at results as a notebook would.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

use crate::program::{Answer, root, say};

/// The interpreter, if it has ObsPy and xarray; says so where it has not.
pub(crate) fn interpreter() -> Option<&'static Path> {
    static FOUND: OnceLock<Option<PathBuf>> = OnceLock::new();
    let found = FOUND.get_or_init(|| {
        let given = std::env::var_os("HATI_PYTHON").filter(|p| !p.is_empty()).map(PathBuf::from);
        let python = given.unwrap_or_else(|| root().join(".venv/bin/python"));
        let ready = Command::new(&python)
            .args(["-I", "-c", "import obspy, xarray, netCDF4"])
            .output()
            .is_ok_and(|output| output.status.success());
        if ready {
            return Some(python);
        }
        let words = format!("{} with ObsPy and xarray is missing (run `make setup`)", python.display());
        assert!(std::env::var("HATI_REQUIRE_PYTHON").as_deref() != Ok("1"), "{words}");
        say(&format!("skipped: {words}"));
        None
    });
    found.as_deref()
}

/// The program with that interpreter.
pub(crate) fn hati_with(python: &Path, cwd: &Path, arguments: &[&str]) -> Answer {
    let mut command = crate::program::command(cwd, arguments);
    Answer::from(command.env("HATI_PYTHON", python).output().expect("the program starts"))
}

/// A folder with the records of `inputs/python/make_fixtures.py`, gone with the value.
pub(crate) fn fixtures(python: &Path) -> tempfile::TempDir {
    let folder = crate::program::folder();
    let script = root().join("inputs/python/make_fixtures.py");
    let status = Command::new(python).arg(script).arg(folder.path()).status();
    assert!(status.is_ok_and(|status| status.success()), "the fixtures could not be made");
    folder
}
