//! Wave fields in 2D and 3D: written beside a loop, read by xarray, killed, cut back and gone on with.

#![allow(clippy::print_stderr, clippy::print_stdout)] // a skipped test says so; a child reports

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Duration;

use hati::outputs::thread::{Background, Sink};
use hati::outputs::wave::{Cells, Grid, Peaks, Sensor, SensorLayout, SensorWriter, WaveLayout, WaveWriter};
use hati::outputs::{OutputError, Provenance};
use hati::report::wave::{KeyNumber, MeshPicture, SurfaceMotion, WavePage, write_wave_report};
use hati::results::Trace;

const ROWS: usize = 70;
const DT: f64 = 0.01;
/// Points along an edge of an element.
const N: usize = 5;
/// Edge of an element, m.
const EDGE: f64 = 100.0;

fn provenance() -> Provenance {
    Provenance {
        title: "Two elements".to_owned(),
        hati_version: "0.1.0".to_owned(),
        history: "2026-01-01T00:00:00Z hati run scene.toml".to_owned(),
        start: Some("1996-08-10T18:12:00.500Z".to_owned()),
        accuracy: Some(0.01),
        ..Provenance::default()
    }
}

/// Motion that the Python side works out again.
fn value(place: [f64; 3], axis: usize, motion: usize, t: f64) -> f32 {
    let [x, y, z] = place;
    ((motion + 1) as f64 * (5.0 * t + axis as f64 + 0.01 * x + 0.02 * y - 0.03 * z).sin()) as f32
}

fn layout(motions: [bool; 3], axes: &[usize]) -> WaveLayout {
    let [displacement, velocity, acceleration] = motions;
    WaveLayout { displacement, velocity, acceleration, axes: axes.to_vec() }
}

/// Point `(i, j, k)` of two elements side by side along x, below z = 0; not evenly spaced, as GLL points are.
fn position(number: u32) -> [f64; 3] {
    const GLL: [f64; N] = [0.0, 0.172_673_164_646, 0.5, 0.827_326_835_354, 1.0];
    let number = number as usize;
    let (i, j, k) = (number % 9, number / 9 % 5, number / 45);
    let along = |i: usize| EDGE * (GLL[i % (N - 1)] + (i / (N - 1)) as f64);
    [along(i), along(j), along(k) - EDGE]
}

/// Points of both elements; of their top, or of its front edge on the first one.
fn points(dimension: usize) -> Vec<u32> {
    let number = |i: usize, j: usize, k: usize| (i + 9 * j + 45 * k) as u32;
    match dimension {
        1 => (0..N).map(|i| number(i, 0, 4)).collect(),
        2 => (0..2 * N * N).map(|p| number(p / 25 * 4 + p % 5, p / 5 % 5, 4)).collect(),
        _ => (0..2 * N * N * N).map(|p| number(p / 125 * 4 + p % 5, p / 5 % 5, p / 25 % 5)).collect(),
    }
}

fn cells(dimension: usize) -> Cells {
    Cells::of_elements(dimension, N, &points(dimension), position).0
}

fn grid() -> Grid {
    // Its first points along x lie outside the ground.
    Grid::over([-20.0, 0.0, -100.0], [200.0, 100.0, 0.0], 10.0, 3)
}

/// The four files, each with what a row of it holds.
fn writers(folder: &Path, resume: Option<usize>) -> Vec<(WaveWriter, WaveLayout, Vec<[f64; 3]>)> {
    let path = |name: &str| folder.join(name);
    let (about, all) = (provenance(), layout([true; 3], &[0, 1, 2]));
    let (surface, volume, line) = (cells(2), cells(3), cells(1));
    let velocity = |axes: &[usize]| layout([false, true, false], axes);
    let (part, vector, one) = (velocity(&[0, 2]), velocity(&[0, 1, 2]), layout([true, false, false], &[0]));
    let made = || -> Result<_, OutputError> {
        Ok(vec![
            (
                WaveWriter::surface(&path("surface.nc"), &about, &all, &surface, resume)?,
                all.clone(),
                surface.points.clone(),
            ),
            (
                WaveWriter::volume(&path("volume.nc"), &about, &part, &volume, resume)?,
                part.clone(),
                volume.points.clone(),
            ),
            (
                WaveWriter::surface(&path("line.nc"), &about, &one, &line, resume)?,
                one.clone(),
                line.points.clone(),
            ),
            (
                WaveWriter::grid(&path("field.nc"), &about, &vector, &grid(), resume)?,
                vector.clone(),
                grid().iter().collect(),
            ),
        ])
    };
    made().expect("the writers")
}

fn row(layout: &WaveLayout, places: &[[f64; 3]], number: usize, to: &mut [f32]) {
    let t = number as f64 * DT;
    let variables = layout.motions().into_iter().flat_map(|m| layout.axes.iter().map(move |&a| (m, a)));
    for ((motion, axis), block) in variables.zip(to.chunks_mut(places.len())) {
        for (slot, place) in block.iter_mut().zip(places) {
            *slot = if place[0] < 0.0 { f32::NAN } else { value(*place, axis, motion, t) };
        }
    }
}

fn peaks(rows: usize) -> Peaks {
    let places = cells(2).points;
    let all = layout([true; 3], &[0, 1, 2]);
    let mut peaks = Peaks::new(&all.axes, places.len());
    let mut values = vec![0.0; all.values(places.len())];
    for number in 0..rows {
        row(&all, &places, number, &mut values);
        values.chunks(3 * places.len()).enumerate().for_each(|(motion, part)| peaks.take(motion, part));
    }
    peaks
}

/// Writes rows from `from` to `to` beside this thread and gives the writers back.
fn write(folder: &Path, from: usize, to: usize) -> Vec<WaveWriter> {
    let parts = writers(folder, (from > 0).then_some(from));
    let what: Vec<_> = parts.iter().map(|(_, layout, places)| (layout.clone(), places.clone())).collect();
    let sinks = parts.into_iter().map(|(writer, ..)| writer).collect();
    let mut background = Background::start(sinks, 3).expect("a thread");
    for number in from..to {
        for (sink, (layout, places)) in what.iter().enumerate() {
            let mut frame = background.frame(sink).expect("a frame");
            frame.time = number as f64 * DT;
            row(layout, places, number, &mut frame.values);
            background.send(frame).expect("handed over");
        }
    }
    background.finish().expect("no failure")
}

/// A child that starts while HDF5 holds a lock holds it too, and whoever opens that file next is refused.
fn alone() -> std::sync::MutexGuard<'static, ()> {
    static ONE: std::sync::Mutex<()> = std::sync::Mutex::new(());
    ONE.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
}

/// Python with xarray: `HATI_PYTHON` or the workspace's environment; `None` where there is none.
fn python() -> Option<PathBuf> {
    let given = std::env::var_os("HATI_PYTHON").filter(|p| !p.is_empty()).map(PathBuf::from);
    let python = given.unwrap_or_else(|| root().join(".venv/bin/python"));
    let works = Command::new(&python)
        .args(["-c", "import xarray, netCDF4"])
        .output()
        .is_ok_and(|output| output.status.success());
    if !works {
        assert!(std::env::var("HATI_REQUIRE_PYTHON").as_deref() != Ok("1"), "Python with xarray is missing");
        eprintln!("SKIPPED: no Python with xarray and netCDF4 (run `make setup`)");
    }
    works.then_some(python)
}

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

fn check(folder: &Path, state: &str) {
    let Some(python) = python() else { return };
    let output = Command::new(python)
        .arg(root().join("tests/python/check_fields.py"))
        .arg(folder)
        .arg(state)
        .output()
        .expect("Python starts");
    let said = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{said}{}", String::from_utf8_lossy(&output.stderr));
    // A script that stops early must not pass.
    assert!(said.trim_end().ends_with("all checks passed"), "{said}");
}

#[test]
fn xarray_reads_the_fields_while_they_grow_and_when_they_are_finished() {
    let _alone = alone();
    let folder = tempfile::tempdir().expect("temporary folder");
    let mut writers = write(folder.path(), 0, ROWS);
    assert!(writers.iter().all(|w| w.rows() == ROWS));
    writers[0].write_peaks(&peaks(ROWS)).expect("peaks");
    check(folder.path(), "growing");
    let plain = std::fs::metadata(folder.path().join("volume.nc")).expect("a file").len();
    writers.into_iter().for_each(|writer| writer.finish().expect("compressed"));
    check(folder.path(), "finished");
    let packed = std::fs::metadata(folder.path().join("volume.nc")).expect("a file").len();
    assert!(packed < plain, "{packed} of {plain} bytes");
    let left = std::fs::read_dir(folder.path()).expect("a folder").count();
    assert_eq!(left, 4, "nothing is left beside the files");
}

/// The bytes after a restart are those of a run that was never stopped.
#[test]
fn a_run_that_goes_on_leaves_the_same_bytes() {
    let _alone = alone();
    let folder = tempfile::tempdir().expect("temporary folder");
    let (whole, parts) = (folder.path().join("whole"), folder.path().join("parts"));
    for folder in [&whole, &parts] {
        std::fs::create_dir(folder).expect("a folder");
    }
    drop(write(&whole, 0, 40));
    // Rows behind the checkpoint at 17 are there, and others than those that follow.
    drop(write(&parts, 0, 30));
    drop(write(&parts, 17, 40));
    for name in ["surface.nc", "volume.nc", "line.nc", "field.nc"] {
        let bytes = |folder: &Path| std::fs::read(folder.join(name)).expect("a file");
        assert!(bytes(&whole) == bytes(&parts), "{name}");
    }
    let error = WaveWriter::surface(
        &whole.join("surface.nc"),
        &provenance(),
        &layout([true; 3], &[0, 1, 2]),
        &cells(3),
        Some(3),
    );
    assert!(matches!(error, Err(OutputError::Unresumable { .. })), "{error:?}");
    write(&whole, 40, 41).into_iter().for_each(|writer| writer.finish().expect("compressed"));
    let error = WaveWriter::grid(
        &whole.join("field.nc"),
        &provenance(),
        &layout([false, true, false], &[0, 1, 2]),
        &grid(),
        Some(3),
    );
    let text = error.expect_err("a finished run").to_string();
    assert!(text.contains("is finished") && text.contains("field.nc"), "{text}");
}

/// Not a test of its own: writes without end until it is killed.
#[test]
#[ignore = "a part of killed_at_any_instant"]
fn child_that_is_killed() {
    let Some(folder) = std::env::var_os("HATI_TEST_FOLDER").map(PathBuf::from) else { return };
    let from = std::env::var("HATI_TEST_ROWS").ok().and_then(|n| n.parse().ok()).unwrap_or(0);
    let places = cells(2).points;
    let all = layout([true; 3], &[0, 1, 2]);
    let resume = (from > 0).then_some(from);
    let writer = WaveWriter::surface(&folder.join("surface.nc"), &provenance(), &all, &cells(2), resume)
        .expect("a writer");
    // Syncs all the time, so that a kill hits one more often than not.
    let mut background = Background::start_with(vec![writer], 2, Duration::ZERO).expect("a thread");
    println!("ready");
    for number in from.. {
        let mut frame = background.frame(0).expect("a frame");
        frame.time = number as f64 * DT;
        row(&all, &places, number, &mut frame.values);
        background.send(frame).expect("handed over");
    }
}

/// Rows of a file that may have been cut anywhere; all of them are whole.
fn expect_whole(path: &Path) -> usize {
    let places = cells(2).points;
    let all = layout([true; 3], &[0, 1, 2]);
    let file = netcdf::open(path).expect("the file opens");
    let rows = file.dimension_len("time").expect("time");
    let times: Vec<f64> = file.variable("time").expect("time").get_values(..).expect("times");
    assert!(times.iter().enumerate().all(|(number, t)| *t == number as f64 * DT), "{times:?}");
    for number in [0, rows / 2, rows.saturating_sub(1)].into_iter().filter(|n| *n < rows) {
        let mut wanted = vec![0.0; all.values(places.len())];
        row(&all, &places, number, &mut wanted);
        let names = ["displacement", "velocity", "acceleration"];
        let names = names.iter().flat_map(|m| ["x", "y", "z"].map(|a| format!("{m}_{a}")));
        for (name, wanted) in names.zip(wanted.chunks(places.len())) {
            let variable = file.variable(&name).expect("a motion");
            let found: Vec<f32> = variable.get_values([number..number + 1, 0..places.len()]).expect("values");
            assert_eq!(found, wanted, "{name}, row {number} of {rows}");
        }
    }
    rows
}

#[cfg(unix)]
#[test]
fn killed_at_any_instant_the_file_is_whole_and_the_run_goes_on() {
    let _alone = alone();
    use std::io::Read as _;
    let folder = tempfile::tempdir().expect("temporary folder");
    let path = folder.path().join("surface.nc");
    let mut rows = 0;
    let mut grown = 0;
    for round in 0..12 {
        let mut child = Command::new(std::env::current_exe().expect("this program"))
            .args(["--ignored", "--exact", "child_that_is_killed", "--nocapture"])
            .env("HATI_TEST_FOLDER", folder.path())
            .env("HATI_TEST_ROWS", rows.to_string())
            .stdout(Stdio::piped())
            .spawn()
            .expect("a child");
        let mut said = [0; 1];
        let mut out = child.stdout.take().expect("its output");
        // Until it says that it writes.
        let mut text = String::new();
        while !text.ends_with("ready\n") && out.read(&mut said).is_ok_and(|n| n == 1) {
            text.push(char::from(said[0]));
        }
        std::thread::sleep(Duration::from_micros(20_000 + 1_313 * round));
        child.kill().expect("killed");
        child.wait().expect("ended");
        let found = expect_whole(&path);
        assert!(found >= rows, "round {round}: {found} after {rows}");
        grown += usize::from(found > rows);
        // As if the last checkpoint had been a little earlier.
        rows = found.saturating_sub(3);
    }
    assert!(grown > 6, "most rounds write something: {grown}");
}

/// A run's files, then what the export makes of them, by its structure and by its numbers.
#[test]
fn fields_become_vtkhdf() {
    let _alone = alone();
    use hati::export::{ExportError, Wanted, export};
    let folder = tempfile::tempdir().expect("temporary folder");
    let run = folder.path();
    let wanted = Wanted { vtkhdf: true, ..Wanted::default() };
    let out = run.join("export");
    let options = hati_inputs::records::ReadOptions::default();
    let error = export(run, &out, &wanted, &options).expect_err("nothing to export");
    assert!(matches!(error, ExportError::NoFields { .. }), "{error}");
    // From files of a run under way and from those of a finished one, the same.
    let mut written = write(run, 0, ROWS);
    written[0].write_peaks(&peaks(ROWS)).expect("peaks");
    let mut told = vec![];
    for state in ["growing", "finished"] {
        let exported = export(run, &out.join(state), &wanted, &options).expect("exported");
        let names: Vec<_> = exported.iter().filter_map(|e| e.path.file_name()).collect();
        assert_eq!(names, ["surface.vtkhdf", "volume.vtkhdf", "field.vtkhdf"]);
        told.push(exported.into_iter().map(|e| e.content).collect::<Vec<_>>());
        written.drain(..).for_each(|writer| writer.finish().expect("compressed"));
        let Some(python) = python() else { continue };
        let output = Command::new(python)
            .arg(root().join("tests/python/check_vtkhdf.py"))
            .arg(out.join(state))
            .output()
            .expect("Python starts");
        let said = String::from_utf8_lossy(&output.stdout);
        assert!(output.status.success(), "{said}{}", String::from_utf8_lossy(&output.stderr));
        assert!(said.trim_end().ends_with("all checks passed"), "{said}");
    }
    assert_eq!(told[0], told[1]);
    assert!(told[0][0].starts_with("45 points, 32 cells, 70 instants"), "{}", told[0][0]);
    // A file that is no field of hati's.
    std::fs::write(run.join("volume.nc"), b"CDF no").expect("write");
    let error = export(run, &out, &wanted, &options).expect_err("unreadable").to_string();
    assert!(error.contains("volume.nc") && error.contains("cannot be read"), "{error}");
}

/// Sensors of a run under way and of a finished one, read by the library and exported.
#[test]
fn sensors_are_read_while_they_grow_and_when_they_are_finished() {
    use hati::export::{Wanted, export};
    let _alone = alone();
    let folder = tempfile::tempdir().expect("temporary folder");
    let path = folder.path().join("stations.nc");
    let sensor =
        |name: &str, x: f64| Sensor { name: name.to_owned(), asked: [x, 2.0, 0.5], position: [x, 2.0, 0.0] };
    let sensors = [sensor("kerb", 1.0), sensor("Höhe 7", 4.0)];
    let layout = SensorLayout { axes: vec![0, 2], strain: false, stress: true };
    assert_eq!(layout.variables(), 12);
    let value = |row: usize, i: usize| (row * 100 + i) as f64 + 0.1;
    let write = |resume: Option<usize>, to: usize| {
        let mut writer = SensorWriter::create(&path, &provenance(), &layout, &sensors, resume).expect("made");
        for row in writer.rows()..to {
            let values: Vec<f64> = (0..24).map(|i| value(row, i)).collect();
            writer.append(row as f64 * DT, &values).expect("a row");
        }
        assert!(writer.append(0.0, &[1.0; 23]).is_err(), "a value short");
        writer.sync().expect("synced");
        writer
    };
    drop(write(None, 900));
    for (from, to, finished) in [(400, 700, false), (700, 701, true)] {
        let writer = write(Some(from), to);
        if finished {
            writer.finish().expect("compressed");
        }
        let file = netcdf::open(&path).expect("opens");
        assert_eq!(file.dimension_len("time"), Some(to));
        for (variable, first) in [("displacement_x", 0), ("acceleration_z", 10), ("stress_xz", 22)] {
            let found: Vec<f64> = file.variable(variable).expect(variable).get_values(..).expect("values");
            for (i, found) in found.iter().enumerate() {
                assert_eq!(*found, value(i / 2, first + i % 2), "{variable}");
            }
        }
        let asked: Vec<f64> = file.variable("z_asked").expect("asked").get_values(..).expect("values");
        assert_eq!(asked, [0.5, 0.5]);
        drop(file);
        let wanted = Wanted { csv: true, place: Some("Höhe 7".into()), ..Wanted::default() };
        let out = folder.path().join("out");
        let made = export(folder.path(), &out, &wanted, &Default::default()).expect("exported");
        let text = std::fs::read_to_string(&made[0].path).expect("CSV");
        let last = text.lines().last().expect("a row");
        let wanted = format!("{:?},{:?},", (to - 1) as f64 * DT, value(to - 1, 9));
        assert!(last.starts_with(&wanted), "{last}");
    }
}

/// Surface of `elements` by `elements / 2` elements of order 4 with rings that run outwards.
fn rings(elements: usize, instants: usize) -> SurfaceMotion {
    let (nx, ny) = (4 * elements + 1, 2 * elements + 1);
    let element = |e: usize| (e % elements * 4, e / elements * 4);
    let points: Vec<u32> = (0..elements * elements / 2)
        .flat_map(|e| (0..25).map(move |p| (element(e).0 + p % 5 + nx * (element(e).1 + p / 5)) as u32))
        .collect();
    let step = 2000.0 / (nx - 1) as f64;
    let at = |p: u32| {
        let p = p as usize;
        [step * (p % nx) as f64, step * (p / nx) as f64, 0.0]
    };
    let (cells, _) = Cells::of_elements(2, N, &points, at);
    assert_eq!(cells.points.len(), nx * ny);
    let time: Vec<f64> = (0..instants).map(|i| 0.02 * i as f64).collect();
    let one = |p: &[f64; 3], t: f64| {
        let r = (p[0] - 700.0).hypot(p[1] - 400.0);
        let ring = |speed: f64, size: f64| {
            let phase = (t - 0.4 - r / speed) / 0.12;
            size * (-phase * phase).exp() / (1.0 + r / 100.0).sqrt()
        };
        (ring(500.0, 0.3) + ring(1100.0, 0.08)) as f32
    };
    let speed: Vec<f32> = time.iter().flat_map(|&t| cells.points.iter().map(move |p| one(p, t))).collect();
    let mut pgv = vec![0.0_f32; cells.points.len()];
    for frame in speed.chunks(pgv.len()) {
        pgv.iter_mut().zip(frame).for_each(|(peak, v)| *peak = peak.max(*v));
    }
    let scaled = |factor: f32| pgv.iter().map(|v| factor * v).collect();
    SurfaceMotion { cells, time, speed, peaks: [scaled(0.03), scaled(1.0), scaled(40.0)] }
}

fn page(surface: SurfaceMotion) -> WavePage {
    let samples: Vec<f64> = (0..400).map(|i| (-(0.01 * f64::from(i) - 1.5).powi(2) / 0.02).exp()).collect();
    let trace = |place: &str, axis: usize| Trace {
        place: place.to_owned(),
        depth: Some(0.0),
        axis,
        acceleration: samples.clone(),
        velocity: samples.clone(),
        displacement: samples.clone(),
    };
    let number = KeyNumber { label: "elements".into(), value: "512".into(), note: "order 4".into() };
    WavePage {
        title: "Rings on a plain".into(),
        subtitle: "3D ground · made for a test".into(),
        warnings: vec!["made by a formula".into()],
        numbers: vec![number],
        mesh: MeshPicture::default(),
        ledger: vec![],
        is_section: false,
        surface: Some(surface),
        traces: vec![trace("A", 0), trace("B", 0), trace("A", 2)],
        dt: 0.01,
        time_first: 0.0,
    }
}

#[test]
fn the_page_shows_pictures_a_film_and_peaks() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let page = page(rings(32, 150));
    write_wave_report(folder.path(), &page).expect("written");
    let html = std::fs::read_to_string(folder.path().join("report.html")).expect("a page");
    assert!(html.len() < 2_500_000, "{} bytes", html.len());
    let links = html.replace("http://www.w3.org/2000/svg", "");
    assert!(!links.contains("http://") && !links.contains("https://"), "the page needs no network");
    for name in ["surface-speed", "surface-film", "surface-peaks", "velocity-x", "velocity-z"] {
        let found = html.contains(&format!("figures/{name}.csv"));
        assert!(found, "{name} is not on the page");
        for ending in ["svg", "csv"] {
            assert!(folder.path().join(format!("figures/{name}.{ending}")).exists(), "{name}.{ending}");
        }
    }
    assert_eq!(html.matches("data-times=").count(), 1);
    assert_eq!(
        html.split("data-times=\"")
            .nth(1)
            .expect("times")
            .split('"')
            .next()
            .expect("times")
            .split(',')
            .count(),
        75
    );
    for words in ["PGA, up to", "PGV, up to", "PGD, up to", ">m/s²<", ">m/s<", ">m<", "x (m)", "y (m)"] {
        assert!(html.contains(words), "{words}");
    }
    let csv = std::fs::read_to_string(folder.path().join("figures/surface-peaks.csv")).expect("CSV");
    assert!(csv.starts_with("x_m,y_m,z_m,pga_m_s2,pgv_m_s,pgd_m\n"), "{}", &csv[..60]);
    assert_eq!(csv.lines().count(), 1 + page.surface.expect("a surface").cells.points.len());
}

#[test]
fn a_section_and_a_still_surface_have_pages() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let mut still = rings(4, 6);
    still.speed.fill(0.0);
    still.peaks = [vec![], vec![], vec![]];
    write_wave_report(folder.path(), &page(still)).expect("written");
    let html = std::fs::read_to_string(folder.path().join("report.html")).expect("a page");
    assert!(!html.contains("surface-speed") && html.contains("velocity-x"));
    let (cells, _) =
        Cells::of_elements(1, N, &(0..9).flat_map(|e| e * 4..e * 4 + 5).collect::<Vec<_>>(), |p| {
            [10.0 * f64::from(p), 0.0, 0.0]
        });
    let time: Vec<f64> = (0..200).map(|i| 0.01 * f64::from(i)).collect();
    let one = |p: &[f64; 3], t: f64| (-((t - 0.3 - p[0] / 300.0) / 0.05).powi(2)).exp() as f32;
    let speed = time.iter().flat_map(|&t| cells.points.iter().map(move |p| one(p, t))).collect();
    let line = SurfaceMotion { cells, time, speed, peaks: [vec![], vec![], vec![]] };
    write_wave_report(folder.path(), &page(line)).expect("written");
    let html = std::fs::read_to_string(folder.path().join("report.html")).expect("a page");
    assert!(html.contains("Speed along the surface over time"));
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
        if !mounted {
            eprintln!("SKIPPED: a small disk cannot be mounted here (needs root)");
        }
        mounted.then_some(Self(folder))
    }
}

impl Drop for SmallDisk {
    fn drop(&mut self) {
        let _ = Command::new("umount").arg("--lazy").arg(self.0.path()).output();
    }
}

#[test]
fn a_disk_that_fills_is_told_to_the_loop_and_leaves_whole_rows() {
    let _alone = alone();
    let Some(disk) = SmallDisk::mount("3m") else { return };
    let path = disk.0.path().join("surface.nc");
    let (places, all) = (cells(2).points, layout([true; 3], &[0, 1, 2]));
    let writer = WaveWriter::surface(&path, &provenance(), &all, &cells(2), None).expect("a writer");
    let mut background = Background::start_with(vec![writer], 2, Duration::ZERO).expect("a thread");
    let mut number = 0;
    let error = loop {
        assert!(number < 100_000, "the disk never fills");
        match background.frame(0) {
            Ok(mut frame) => {
                frame.time = number as f64 * DT;
                row(&all, &places, number, &mut frame.values);
                background.send(frame).expect("handed over");
                number += 1;
            }
            Err(error) => break error,
        }
    };
    assert!(matches!(error, OutputError::DiskFull { room: Some(_), .. }), "{error}");
    assert!(error.to_string().contains("surface.nc"), "{error}");
    drop(background);
    assert!(expect_whole(&path) > 100, "{} rows", expect_whole(&path));
}

#[test]
fn what_cannot_be_a_field_is_refused() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let path = folder.path().join("surface.nc");
    let make =
        |layout: &WaveLayout, cells: &Cells| WaveWriter::surface(&path, &provenance(), layout, cells, None);
    for axes in [&[0, 3][..], &[1, 0], &[1, 1]] {
        let error = make(&layout([true; 3], axes), &cells(2)).expect_err("components");
        assert!(matches!(error, OutputError::Axis { .. }), "{error}");
    }
    let none = Cells { dimension: 2, points: vec![], corners: vec![] };
    assert!(matches!(make(&layout([true; 3], &[0]), &none), Err(OutputError::Length { .. })));
    let mut writer = make(&layout([true, false, false], &[0]), &cells(2)).expect("a writer");
    let error = writer.append(0.0, &[1.0; 44]).expect_err("a value short");
    assert!(error.to_string().contains("44 values where 45"), "{error}");
    assert!(writer.write_peaks(&Peaks::new(&[0, 1], 45)).is_err(), "no y in this file");
    assert!(writer.write_peaks(&Peaks::new(&[0], 44)).is_err(), "a point short");
    let nowhere = Path::new("/nowhere/at/all/surface.nc");
    let error = WaveWriter::surface(nowhere, &provenance(), &layout([true; 3], &[0]), &cells(2), None);
    assert!(matches!(error, Err(OutputError::UnwritableFolder { .. })), "{error:?}");
}
