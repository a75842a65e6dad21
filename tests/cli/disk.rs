//! Folders that cannot be written and disks that fill up: exit code 4, and what was written before can be read.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::program::{folder, hati, say, shipped, write};
use crate::results::{FILES, File};
use crate::scenes::{SceneText, wavelet};

#[test]
fn a_file_where_the_folder_should_be() {
    let folder = folder();
    write(folder.path(), "taken", "not a folder");
    let scene = shipped("three-layer");
    for out in ["taken", "taken/r", "taken/r/deeper"] {
        hati(folder.path(), &["run", &scene, "--out", out])
            .exits(4)
            .prints_nothing()
            .tells(&["cannot write into folder taken", "--out"]);
        hati(folder.path(), &["run", &scene, "--json", "--out", out])
            .fails_in_json(4, &["cannot write into folder"]);
        hati(folder.path(), &["chart", &scene, "--json", "--out", out])
            .fails_in_json(4, &["cannot write into folder"]);
    }
    assert_eq!(std::fs::read_to_string(folder.path().join("taken")).expect("still there"), "not a folder");
}

/// A disk in memory, gone with the value.
pub(crate) struct SmallDisk {
    pub(crate) folder: PathBuf,
}

impl SmallDisk {
    /// Mounts it, or says why the test is skipped.
    pub(crate) fn mount(folder: &Path, size: &str) -> Option<Self> {
        let folder = folder.join(format!("disk-{size}"));
        std::fs::create_dir_all(&folder).expect("a folder");
        let mounted = cfg!(target_os = "linux")
            && Command::new("mount")
                .args(["-t", "tmpfs", "-o", &format!("size={size}"), "tmpfs"])
                .arg(&folder)
                .output()
                .is_ok_and(|output| output.status.success());
        if !mounted {
            say("skipped: a disk of a few hundred kilobytes cannot be mounted here (needs root)");
        }
        mounted.then_some(Self { folder })
    }
}

impl Drop for SmallDisk {
    fn drop(&mut self) {
        let _ = Command::new("umount").arg("--lazy").arg(&self.folder).output();
    }
}

/// Records of the NetCDF files of a run that ended early, all of which have to open and to be whole in themselves:
/// every variable along `time` is as long as the time itself. A file may be missing.
fn whole_files(run: &Path) -> [Option<usize>; 3] {
    FILES.map(|name| {
        run.join(name).exists().then(|| {
            let file = File::open(run, name);
            let records = file.records();
            assert_eq!(file.values("elapsed_time").len(), records);
            assert!(file.values("elapsed_time").windows(2).all(|t| t[1] > t[0]), "{name}: {records} records");
            for variable in file.numeric() {
                let values = file.values(&variable);
                if file.is_along_time(&variable) {
                    assert!(values.iter().all(|x| x.is_finite()), "{name}: {variable} has holes");
                }
            }
            records
        })
    })
}

#[test]
fn a_full_disk_is_told_at_every_stage() {
    let folder = folder();
    // From not even the files' heads, over the streams, to the figures and the report.
    let (mut heads_only, mut streams) = (0, 0);
    for size in ["8k", "64k", "600k", "1m", "1200k", "1400k", "1700k", "2m", "2600k", "3300k", "4m", "5m"] {
        let Some(disk) = SmallDisk::mount(folder.path(), size) else { return };
        let run = disk.folder.join("r");
        let out = run.display().to_string();
        let answer = hati(folder.path(), &["run", "--json", &shipped("three-layer"), "--out", &out]);
        if answer.code == Some(0) {
            assert!(size.ends_with('m') && streams > 0, "{size} suffices");
            continue;
        }
        answer.fails_in_json(4, &["no space left", &out, "--out"]);
        let records = whole_files(&run);
        heads_only += usize::from(records == [Some(0); 3]);
        streams += usize::from(records[0].is_some_and(|n| n > 0));
    }
    assert!(heads_only > 0, "no disk was too small for the first append");
    assert!(streams > 0, "no disk was filled by the results");
}

/// The field is nearly all of the output, so the disk fills while it is being written.
#[test]
fn a_disk_that_fills_inside_the_field_leaves_what_was_before() {
    let folder = folder();
    let scene = SceneText {
        motions: vec![('x', wavelet("sine_burst", 4.0, 1.0, 30.0, 60.0, ", cycles = 200.0"))],
        output: "field_spacing = 0.05".into(),
        ..SceneText::default()
    };
    let scene = write(folder.path(), "field.toml", &scene.text());
    let Some(disk) = SmallDisk::mount(folder.path(), "24m") else { return };
    let run = disk.folder.join("r");
    let out = run.display().to_string();
    hati(folder.path(), &["run", &scene, "--out", &out]).exits(4).prints_nothing().tells(&[
        "no space left",
        "r/field.nc",
        "its next part was not begun",
        "what was written before is intact",
    ]);
    let [stations, field, ledger] = whole_files(&run).map(|records| records.expect("the file is there"));
    // The field is refused after the stations' part and before the ledger's.
    assert!(ledger >= 1024 && field == ledger && stations > field, "{stations} {field} {ledger}");
}
