//! LOH.1 at an epicentral distance of 1 km, up to 5 Hz, by ObsPy's time-frequency misfits.

use hati::verify::{LOH1_RATE, Loh1Model, loh1_reference};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Python with ObsPy: `HATI_PYTHON` or the workspace's environment; `None` where there is none.
fn python() -> Option<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let given = std::env::var_os("HATI_PYTHON").filter(|p| !p.is_empty()).map(PathBuf::from);
    let python = given.unwrap_or_else(|| root.join(".venv/bin/python"));
    let ready = Command::new(&python).args(["-I", "-c", "import obspy.signal.tf_misfit"]).output();
    if ready.is_ok_and(|output| output.status.success()) {
        return Some(python);
    }
    let words = format!("{} with ObsPy is missing (run `make setup`)", python.display());
    assert!(std::env::var("HATI_REQUIRE_PYTHON").as_deref() != Ok("1"), "{words}");
    println!("SKIPPED: {words}");
    None
}

/// Largest misfit of any component, per cent.
const LIMIT: f64 = 3.0;

fn misfits_are_small(model: &Loh1Model) {
    let Some(python) = python() else { return };
    let found = model.run::<f32>(1.0).unwrap().velocity;
    let reference = loh1_reference();
    let mut table = String::new();
    for k in 0..found[0].len().min(reference[0].len()) {
        let row: Vec<String> = found.iter().chain(&reference).map(|c| format!("{:e}", c[k])).collect();
        writeln!(table, "{}", row.join(",")).unwrap();
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("loh1.csv");
    std::fs::write(&path, table).unwrap();
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/python/check_tf_misfit.py");
    let step = (1.0 / LOH1_RATE as f64).to_string();
    let output =
        Command::new(python).arg(script).arg(&path).args([step, LIMIT.to_string()]).output().unwrap();
    let said = String::from_utf8_lossy(&output.stdout);
    println!("{said}");
    assert!(output.status.success(), "{said}{}", String::from_utf8_lossy(&output.stderr));
    assert_eq!(said.lines().count(), 3, "{said}");
}

#[test]
fn the_beginning_has_small_misfits() {
    misfits_are_small(&Loh1Model::beginning());
}

#[test]
#[ignore = "long: minutes on two cores"]
fn the_whole_record_has_small_misfits() {
    misfits_are_small(&Loh1Model::whole());
}
