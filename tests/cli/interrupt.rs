//! A run that is stopped in the middle, and a run that is looked at while it goes on.
#![cfg(unix)]

use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use crate::program::{Answer, command, folder, read_json, write};
use crate::results::{FILES, File};

/// A long run under way in `folder/r`.
struct Running {
    child: Option<Child>,
    run: PathBuf,
}

impl Running {
    /// Starts it and waits for its first samples.
    fn start(folder: &Path, more: &[&str]) -> Self {
        let scene = write(folder, "long.toml", &crate::scenes::long().text());
        let mut arguments = vec!["run", &scene, "--out", "r"];
        arguments.extend(more);
        let mut command = command(folder, &arguments);
        let child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("start");
        let mut running = Self { child: Some(child), run: folder.join("r") };
        running.wait_for_more_than(0);
        running
    }

    /// Waits until `progress.json` tells of more samples than `known`; returns their number.
    fn wait_for_more_than(&mut self, known: u64) -> u64 {
        let path = self.run.join("progress.json");
        let begin = Instant::now();
        loop {
            if path.exists()
                && let Some(done) = read_json(path.clone())["samples_done"].as_u64()
                && done > known
            {
                return done;
            }
            let ended = self.child.as_mut().and_then(|c| c.try_wait().expect("a child"));
            assert!(ended.is_none(), "the run ended before it could be interrupted: {ended:?}");
            assert!(begin.elapsed() < Duration::from_secs(60), "no progress in a minute");
            std::thread::sleep(Duration::from_millis(10));
        }
    }

    fn signal(&self, name: &str) {
        let number = self.child.as_ref().expect("still running").id().to_string();
        let status = Command::new("kill").args([name, &number]).status();
        assert!(status.is_ok_and(|s| s.success()), "kill {name} {number}");
    }

    fn end(mut self) -> std::process::Output {
        self.child.take().expect("still running").wait_with_output().expect("end")
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        if let Some(child) = &mut self.child {
            let _ = child.kill();
            let _ = child.wait();
        }
    }
}

/// Records of the three files; all values of the first ones are numbers.
fn records(run: &Path) -> [usize; 3] {
    let files = FILES.map(|name| File::open(run, name));
    let records = [0, 1, 2].map(|i| files[i].records());
    let whole = records.into_iter().min().unwrap_or(0);
    for (file, variable) in files.iter().zip(["acceleration_x", "acceleration_x", "energy_input"]) {
        assert!(file.first(variable, whole).iter().all(|x| x.is_finite()), "{variable}");
        assert!(file.first("elapsed_time", whole).windows(2).all(|w| w[1] > w[0]));
    }
    records
}

fn stops_with_valid_files(signal: &str, json: bool) {
    let folder = folder();
    let running = Running::start(folder.path(), if json { &["--json"] } else { &[] });
    let begin = Instant::now();
    running.signal(signal);
    let answer = Answer::from(running.end()).exits(5).tells(&["interrupted", "run again"]);
    assert!(begin.elapsed() < Duration::from_secs(15), "it takes {:?} to stop", begin.elapsed());
    let run = folder.path().join("r");
    let summary = read_json(run.join("summary.json"));
    assert_eq!(summary["status"], "interrupted");
    if json {
        assert_eq!(answer.json(), summary);
    } else {
        assert_eq!(answer.stdout, "r/report.html\n");
    }
    let [stations, field, ledger] = records(&run);
    assert!(stations > 0 && stations == field && stations == ledger, "{stations} {field} {ledger}");
    let progress = read_json(run.join("progress.json"));
    assert_eq!(progress["samples_done"], stations);
    assert!(progress["samples"].as_u64() > progress["samples_done"].as_u64());
    assert!(run.join("report.html").exists());
}

#[test]
fn ctrl_c_leaves_valid_files() {
    stops_with_valid_files("-INT", false);
}

#[test]
fn a_polite_kill_leaves_valid_files() {
    stops_with_valid_files("-TERM", true);
}

/// Nothing can be said at a hard kill: the samples that `progress.json` told of are on the disk.
#[test]
fn a_hard_kill_leaves_what_was_told() {
    let folder = folder();
    let mut running = Running::start(folder.path(), &[]);
    let first = running.wait_for_more_than(0);
    // Just told, so the next samples are being computed, not written.
    let told = running.wait_for_more_than(first);
    running.signal("-KILL");
    let output = running.end();
    assert_eq!(output.status.code(), None, "{output:?}");
    let run = folder.path().join("r");
    let records = records(&run);
    assert!(records.iter().all(|&n| n as u64 >= told), "{records:?} of {told}");
    assert!(!run.join("summary.json").exists(), "a summary of a run that did not end");
}

/// A notebook opens the files twice during the run and sees them grow.
#[test]
fn readers_look_while_it_runs() {
    let Some(python) = crate::python::interpreter() else { return };
    let folder = folder();
    let mut running = Running::start(folder.path(), &[]);
    let run = running.run.clone();
    let look = || -> Vec<u64> {
        let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/python/look_at_run.py");
        let output = Command::new(python).arg(script).arg(&run).output().expect("python");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8_lossy(&output.stdout)
            .split_whitespace()
            .map(|n| n.parse().expect("a number"))
            .collect()
    };
    let done = running.wait_for_more_than(0);
    let first = look();
    assert!(first.len() == 3 && first.iter().all(|&n| n >= done), "{first:?} of {done}");
    running.wait_for_more_than(first[0]);
    let second = look();
    assert!(second.iter().zip(&first).all(|(b, a)| b > a), "{first:?}, then {second:?}");
    // Reading through the program's own NetCDF library, just after an append.
    let told = running.wait_for_more_than(second[0]);
    assert!(File::open(&run, "stations.nc").records() as u64 >= told);
    running.signal("-INT");
    Answer::from(running.end()).exits(5);
    assert_eq!(records(&run).map(|n| n as u64 > second[0]), [true; 3]);
}
