//! A disk that fills up in the middle of a run in three dimensions: exit code 4, and what was written before can be read.

use std::path::Path;

use crate::disk::SmallDisk;
use crate::program::{folder, hati, number, read_json, write};
use crate::volume::scene_3d;

/// Rows of each file that is there: all open, their times rise, and their motions are whole.
fn rows(run: &Path) -> Vec<(&'static str, usize)> {
    let mut rows = vec![];
    for name in ["stations", "surface", "volume", "field", "ledger"] {
        let path = run.join(format!("{name}.nc"));
        if !path.is_file() {
            continue;
        }
        let file = netcdf::open(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        let values =
            |variable: &netcdf::Variable<'_>| -> Vec<f64> { variable.get_values(..).expect("values") };
        let time = values(&file.variable("elapsed_time").expect("elapsed_time"));
        assert!(time.windows(2).all(|t| t[1] > t[0]), "{name}: {} rows", time.len());
        for variable in file.variables() {
            let motion = ["displacement", "velocity", "acceleration", "energy"]
                .iter()
                .any(|word| variable.name().starts_with(word));
            let along_time = variable.dimensions().first().is_some_and(|d| d.len() == time.len());
            if motion && along_time {
                // a station holds what it was asked for, the whole time, and nothing else
                let places = variable.len() / time.len().max(1);
                let values = values(&variable);
                for place in 0..places {
                    let missing = (0..time.len()).filter(|k| !values[k * places + place].is_finite()).count();
                    let unasked = name == "stations" && missing == time.len();
                    assert!(missing == 0 || unasked, "{name}: {} has holes", variable.name());
                }
            }
        }
        rows.push((name, time.len()));
    }
    rows
}

#[test]
fn a_full_disk_ends_a_run_of_the_volume_with_readable_files() {
    let dir = folder();
    let scene = write(dir.path(), "scene.toml", &scene_3d(4.0, ""));
    hati(dir.path(), &["run", &scene, "--out", "whole"]).exits(0);
    let whole = rows(&dir.path().join("whole"));
    let (mut within, mut refused) = (0, 0);
    // from not even the files' heads, over rows of the fields, to the figures
    for size in ["16k", "400k", "1m", "2m", "3m", "4m", "8m", "30m"] {
        let Some(disk) = SmallDisk::mount(dir.path(), size) else { return };
        let run = disk.folder.join("r");
        let out = run.display().to_string();
        let answer = hati(dir.path(), &["run", "--json", &scene, "--out", &out]);
        if answer.code == Some(0) {
            assert_eq!(rows(&run), whole, "{size}");
            break;
        }
        answer.fails_in_json(4, &["no space left", &out, "--out"]);
        refused += 1;
        let left = rows(&run);
        within += usize::from(left.iter().zip(&whole).any(|(l, w)| l.1 > 0 && l.1 < w.1));
        for (left, whole) in left.iter().zip(&whole) {
            assert!(left.1 <= whole.1, "{size}: {left:?} of {whole:?}");
        }
        // what is left is no obstacle to a run elsewhere, and no summary says that it ended well
        if run.join("summary.json").is_file() {
            assert_ne!(read_json(run.join("summary.json"))["status"], "finished", "{size}");
        }
    }
    assert!(refused > 2 && within > 0, "{refused} disks were too small, {within} filled inside the loop");
    assert!(number(&read_json(dir.path().join("whole/summary.json")), "/energy/closing_error") < 1e-5);
}
