//! NetCDF and JSON files of a run: written, killed, read back by xarray, refused with clear words.

#![allow(clippy::print_stderr, clippy::print_stdout)] // a skipped test says so; a child reports

use std::path::{Path, PathBuf};
use std::process::Command;

use hati::outputs::{
    FieldChunk, FieldWriter, LedgerWriter, OutputError, Provenance, StationsWriter, TraceChunk, TraceLayout,
    write_progress, write_summary,
};
use hati::results::{LedgerRow, PeakProfile, Trace};
use serde_json::json;

const DT: f64 = 0.005;
const SAMPLES: usize = 3000;
/// Not a divisor of the samples: the last append is shorter.
const BATCH: usize = 700;
const DEPTHS: usize = 21;

fn provenance() -> Provenance {
    Provenance {
        title: "Two layers".to_owned(),
        hati_version: "0.1.0".to_owned(),
        history: "2026-01-01T00:00:00Z hati run scene.toml".to_owned(),
        start: Some("1996-08-10T18:12:00.500Z".to_owned()),
        scene_sha256: "ab".repeat(32),
        record_sha256: vec!["cd".repeat(32), "ef".repeat(32)],
        accuracy: Some(0.01),
        record_steps: json!([{"name": "scale", "parameters": {"factor": 23.4}}]),
    }
}

/// Motion that the Python side can work out again: depends on place, component, kind and time.
fn sample(place: f64, axis: usize, kind: f64, t: f64) -> f64 {
    (kind + place) * (3.0 * t + axis as f64).sin()
}

fn trace(place: &str, depth: Option<f64>, axis: usize, number: f64) -> Trace {
    let of = |kind: f64| -> Vec<f64> {
        (0..SAMPLES).map(|i| sample(number, axis, kind, i as f64 * DT - 1.0)).collect()
    };
    Trace {
        place: place.to_owned(),
        depth,
        axis,
        displacement: of(1.0),
        velocity: of(2.0),
        acceleration: of(3.0),
    }
}

fn times(range: std::ops::Range<usize>) -> Vec<f64> {
    range.map(|i| i as f64 * DT - 1.0).collect()
}

fn batches() -> impl Iterator<Item = std::ops::Range<usize>> {
    (0..SAMPLES).step_by(BATCH).map(|from| from..(from + BATCH).min(SAMPLES))
}

fn write_stations(path: &Path) -> Result<(), OutputError> {
    let traces = [
        trace("surface", Some(0.0), 0, 0.1),
        trace("surface", Some(0.0), 1, 0.1),
        trace("mid-clay", Some(12.5), 0, 0.2),
        trace("within", Some(30.0), 0, 0.3),
        trace("within", Some(30.0), 1, 0.3),
        trace("outcrop", None, 0, 0.4),
        trace("outcrop", None, 1, 0.4),
    ];
    let layout: Vec<TraceLayout> = traces.iter().map(TraceLayout::from).collect();
    let mut writer = StationsWriter::create(path, &provenance(), &layout)?;
    for range in batches() {
        let chunks: Vec<TraceChunk<'_>> = traces.iter().map(|t| TraceChunk::of(t, range.clone())).collect();
        writer.append(&times(range), &chunks)?;
    }
    assert_eq!(writer.rows(), SAMPLES);
    writer.finish()
}

fn grid() -> Vec<f64> {
    (0..DEPTHS).map(|i| i as f64 * 1.5).collect()
}

fn rows_of(range: std::ops::Range<usize>, axis: usize, kind: f64) -> Vec<f32> {
    times(range)
        .iter()
        .flat_map(|t| grid().into_iter().map(move |z| sample(z, axis, kind, *t) as f32))
        .collect()
}

fn write_field(path: &Path) -> Result<(), OutputError> {
    let profile = [0.0, 10.0, 10.0, 30.0];
    let mut writer = FieldWriter::create(path, &provenance(), &[0, 2], &grid(), &profile)?;
    for range in batches() {
        let values: Vec<[Vec<f32>; 3]> = [0, 2]
            .iter()
            .map(|&axis| [1.0, 2.0, 3.0].map(|kind| rows_of(range.clone(), axis, kind)))
            .collect();
        let chunks: Vec<FieldChunk<'_>> = [0, 2]
            .iter()
            .zip(&values)
            .map(|(&axis, [displacement, velocity, acceleration])| FieldChunk {
                axis,
                displacement,
                velocity,
                acceleration,
            })
            .collect();
        writer.append(&times(range), &chunks)?;
    }
    let peak = |axis: usize| PeakProfile {
        axis,
        depth: profile.to_vec(),
        acceleration: vec![4.0, 3.0, 3.0, 2.0],
        velocity: vec![0.4, 0.3, 0.3, 0.2],
        displacement: vec![0.04, 0.02, 0.02, 0.0],
        strain: vec![0.0, 2e-3, 5e-4, 1e-3],
        stress: vec![0.0, 5e4, 5e4, 9e4],
    };
    writer.write_peaks(&[peak(0), peak(2)])?;
    writer.finish()
}

fn ledger_rows() -> Vec<LedgerRow> {
    (0..SAMPLES)
        .map(|i| LedgerRow {
            time: i as f64 * DT - 1.0,
            input: i as f64,
            kinetic: 0.25,
            strain: 0.5,
            viscous: 0.5 * i as f64,
            outflow: 0.5 * i as f64 - 0.75,
            residual: 0.0,
        })
        .collect()
}

fn write_ledger(path: &Path) -> Result<(), OutputError> {
    let rows = ledger_rows();
    let mut writer = LedgerWriter::create(path, &provenance())?;
    for range in batches() {
        writer.append(&rows[range])?;
    }
    writer.finish(3.5e-13)
}

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

/// Python with xarray: `HATI_PYTHON` or the workspace's environment; `None` where there is none.
fn python() -> Option<PathBuf> {
    let python =
        std::env::var_os("HATI_PYTHON").map_or_else(|| root().join(".venv/bin/python"), PathBuf::from);
    let works = Command::new(&python)
        .args(["-c", "import xarray, netCDF4"])
        .output()
        .is_ok_and(|output| output.status.success());
    works.then_some(python)
}

#[test]
fn xarray_reads_all_files() {
    let dir = tempfile::tempdir().expect("temporary folder");
    write_stations(&dir.path().join("stations.nc")).expect("stations.nc");
    write_field(&dir.path().join("field.nc")).expect("field.nc");
    write_ledger(&dir.path().join("ledger.nc")).expect("ledger.nc");
    let Some(python) = python() else {
        eprintln!("SKIPPED xarray_reads_all_files: no Python with xarray and netCDF4 (run `make setup`)");
        return;
    };
    let output = Command::new(python)
        .arg(root().join("tests/python/check_outputs.py"))
        .arg(dir.path())
        .output()
        .expect("Python starts");
    let said = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{said}{}", String::from_utf8_lossy(&output.stderr));
    // A script that stops early must not pass.
    assert!(said.trim_end().ends_with("all checks passed"), "{said}");
}

#[test]
fn file_is_whole_between_appends() {
    let dir = tempfile::tempdir().expect("temporary folder");
    let path = dir.path().join("ledger.nc");
    let copy = dir.path().join("copy.nc");
    let rows = ledger_rows();
    let mut writer = LedgerWriter::create(&path, &provenance()).expect("ledger.nc");
    let mut written = 0;
    for range in batches() {
        written = range.end;
        writer.append(&rows[range]).expect("append");
        // What is on the disk now is what a kill would leave.
        std::fs::copy(&path, &copy).expect("copy");
        let file = netcdf::open(&copy).expect("the copy opens");
        assert_eq!(file.dimension_len("time"), Some(written));
        let variable = file.variable("energy_input").expect("energy_input");
        let values = variable.get_values::<f64, _>(..).expect("values");
        assert!(values.iter().enumerate().all(|(i, v)| *v == i as f64));
    }
    assert_eq!(written, SAMPLES);
}

#[test]
fn reader_opens_a_file_that_is_being_written() {
    let Some(python) = python() else {
        eprintln!("SKIPPED reader_opens_a_file_that_is_being_written: no Python with xarray and netCDF4");
        return;
    };
    let dir = tempfile::tempdir().expect("temporary folder");
    let path = dir.path().join("ledger.nc");
    let mut writer = LedgerWriter::create(&path, &provenance()).expect("ledger.nc");
    writer.append(&ledger_rows()[..1234]).expect("append");
    let script = "import sys, xarray; print(xarray.open_dataset(sys.argv[1]).sizes['time'])";
    let output = Command::new(python)
        .args(["-c", script])
        .arg(&path)
        // Locking off on one side is enough; a program of hati's switches it off on the writer's.
        .env(hati::outputs::FILE_LOCKING_VARIABLE, "FALSE")
        .output()
        .expect("Python starts");
    let said = String::from_utf8_lossy(&output.stdout);
    assert_eq!(said.trim(), "1234", "{}", String::from_utf8_lossy(&output.stderr));
    writer.append(&ledger_rows()[1234..]).expect("append after a reader came");
    writer.finish(0.0).expect("close");
}

#[test]
fn wrong_lengths_and_components_are_named() {
    let dir = tempfile::tempdir().expect("temporary folder");
    let path = dir.path().join("stations.nc");
    let layout = |axis| [TraceLayout { place: "surface".to_owned(), depth: Some(0.0), axis }];
    let error = StationsWriter::create(&path, &provenance(), &layout(3)).expect_err("no component 3");
    assert!(error.to_string().contains("component 3"), "{error}");
    let mut writer = StationsWriter::create(&path, &provenance(), &layout(0)).expect("stations.nc");
    let chunk = TraceChunk { acceleration: &[1.0, 2.0], velocity: &[1.0, 2.0], displacement: &[1.0] };
    let error = writer.append(&[0.0, 0.1], &[chunk]).expect_err("one value short");
    let text = error.to_string();
    assert!(text.contains("displacement_x has 1 values where 2"), "{text}");
    let error = writer.append(&[0.0], &[]).expect_err("no traces");
    assert!(error.to_string().contains("0 values where 1"), "{error}");
    assert_eq!(writer.rows(), 0, "a refused append leaves nothing behind");

    let path = dir.path().join("field.nc");
    let mut writer = FieldWriter::create(&path, &provenance(), &[0], &[0.0, 1.0], &[]).expect("field.nc");
    let chunk = FieldChunk { axis: 1, displacement: &[0.0; 2], velocity: &[0.0; 2], acceleration: &[0.0; 2] };
    let error = writer.append(&[0.0], &[chunk]).expect_err("component y is not there");
    assert!(matches!(error, OutputError::Axis { axis: 1, .. }), "{error}");
    assert!(FieldWriter::create(&path, &provenance(), &[0], &[], &[]).is_err());
}

#[test]
fn missing_folder_is_named() {
    let path = Path::new("/nowhere/at/all/ledger.nc");
    let error = LedgerWriter::create(path, &provenance()).expect_err("no such folder");
    assert!(matches!(error, OutputError::UnwritableFolder { .. }), "{error}");
    assert!(error.to_string().contains("/nowhere/at/all"), "{error}");
    let error = write_summary(Path::new("/nowhere/summary.json"), &json!({})).expect_err("no such folder");
    assert!(matches!(error, OutputError::UnwritableFolder { .. }), "{error}");
}

/// A file system in memory, gone with the value.
struct SmallDisk(tempfile::TempDir);

impl SmallDisk {
    fn mount(size: &str) -> Option<Self> {
        let folder = tempfile::tempdir().expect("temporary folder");
        let mounted = cfg!(target_os = "linux")
            && Command::new("mount")
                .args(["-t", "tmpfs", "-o", &format!("size={size}"), "tmpfs"])
                .arg(folder.path())
                .output()
                .is_ok_and(|output| output.status.success());
        mounted.then_some(Self(folder))
    }
}

impl Drop for SmallDisk {
    fn drop(&mut self) {
        let _ = Command::new("umount").arg("--lazy").arg(self.0.path()).output();
    }
}

/// Every writer refuses what does not fit before it touches its file, the first append like a later one.
#[test]
fn full_disk_is_recognised_and_leaves_whole_files() {
    // Room for the heads alone, and for some appends.
    for (size, fits) in [("1300k", false), ("9m", true)] {
        let Some(disk) = SmallDisk::mount(size) else {
            eprintln!("SKIPPED full_disk_is_recognised: a small disk cannot be mounted here (needs root)");
            return;
        };
        let path = disk.0.path().join("ledger.nc");
        let mut writer = LedgerWriter::create(&path, &provenance()).expect("ledger.nc");
        let mut rows = ledger_rows();
        let mut error = None;
        while error.is_none() {
            assert!(writer.rows() < 10_000_000, "the disk never fills");
            error = writer.append(&rows).err();
            rows.iter_mut().for_each(|row| row.time += SAMPLES as f64 * DT);
        }
        let error = error.expect("the disk fills up");
        assert!(matches!(error, OutputError::DiskFull { room: Some(_), .. }), "{error}");
        assert!(error.to_string().contains("was not begun"), "{error}");
        let written = writer.rows();
        assert_eq!(written > 0, fits, "{size}: {written} rows");
        // Refused again, and closed as a program does that gives up.
        assert!(writer.append(&rows).is_err());
        drop(writer);
        let file = netcdf::open(&path).expect("the file opens");
        assert_eq!(file.dimension_len("time"), Some(written));
        for name in ["time", "elapsed_time", "energy_input", "energy_residual"] {
            let values = file.variable(name).expect(name).get_values::<f64, _>(..).expect("values");
            assert!(values.len() == written && values.iter().all(|x| x.is_finite()), "{size}: {name}");
        }
        let error =
            write_summary(&disk.0.path().join("summary.json"), &json!({"text": "x".repeat(10 << 20)}))
                .expect_err("no room");
        assert!(matches!(error, OutputError::DiskFull { room: None, .. }), "{error}");
    }
}

#[test]
fn a_disk_without_room_for_the_heads_gets_no_file() {
    let Some(disk) = SmallDisk::mount("900k") else {
        eprintln!(
            "SKIPPED a_disk_without_room_for_the_heads: a small disk cannot be mounted here (needs root)"
        );
        return;
    };
    let refused = |path: &Path, error: Option<OutputError>| {
        assert!(matches!(error, Some(OutputError::DiskFull { room: Some(_), .. })), "{error:?}");
        assert!(!path.exists());
    };
    let path = disk.0.path().join("stations.nc");
    let layout = [TraceLayout { place: "surface".to_owned(), depth: Some(0.0), axis: 0 }];
    refused(&path, StationsWriter::create(&path, &provenance(), &layout).err());
    let path = disk.0.path().join("field.nc");
    refused(&path, FieldWriter::create(&path, &provenance(), &[0], &[0.0, 1.0], &[]).err());
    let path = disk.0.path().join("ledger.nc");
    refused(&path, LedgerWriter::create(&path, &provenance()).err());
}

#[test]
fn json_is_replaced_in_one_step() {
    let dir = tempfile::tempdir().expect("temporary folder");
    let path = dir.path().join("summary.json");
    write_summary(&path, &json!({"status": "running"})).expect("first");
    let reader = std::fs::File::open(&path).expect("open the first");
    write_summary(&path, &json!({"status": "ok", "x": 1})).expect("second");
    let old: serde_json::Value = serde_json::from_reader(reader).expect("the old content stays whole");
    assert_eq!(old["status"], "running");
    let text = std::fs::read_to_string(&path).expect("read");
    assert!(text.find("status") < text.find("\"x\""), "keys keep their order");
    write_progress(&dir.path().join("progress.json"), &json!({"done": 0.5})).expect("progress");
    let left: Vec<_> = std::fs::read_dir(dir.path())
        .expect("folder")
        .map(|entry| entry.expect("entry").file_name())
        .filter(|name| name.to_string_lossy().contains("part"))
        .collect();
    assert!(left.is_empty(), "left behind: {left:?}");
}

#[test]
fn unknown_start_counts_from_1970() {
    let unknown = Provenance { start: None, ..provenance() };
    assert_eq!(unknown.time_units(), "seconds since 1970-01-01T00:00:00Z");
    assert_eq!(provenance().time_units(), "seconds since 1996-08-10T18:12:00.500Z");
}
