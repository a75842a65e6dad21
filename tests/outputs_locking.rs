//! A program that calls `restart_without_file_locking` runs with HDF5's locking off, under its own number.
//!
//! The test program starts itself as a child that runs `program` alone and restarts there.

#![allow(clippy::print_stderr, clippy::print_stdout)] // a skipped test says so; a child reports

use std::process::Command;

use hati::outputs::{FILE_LOCKING_VARIABLE, file_locking_is_off, restart_without_file_locking};

/// Set for the child that plays the part of the program.
const PART: &str = "HATI_TEST_RESTART";

/// Played by the child: restarts, then says what it finds.
#[test]
fn program() {
    if std::env::var_os(PART).is_none() {
        return;
    }
    let failure = restart_without_file_locking();
    println!("off={} failed={} pid={}", file_locking_is_off(), failure.is_some(), std::process::id());
}

fn run(variable: Option<&str>) -> (u32, String) {
    let mut command = Command::new(std::env::current_exe().expect("this program"));
    command
        .args(["--exact", "program", "--nocapture", "--test-threads=1"])
        .env(PART, "1")
        .env_remove(FILE_LOCKING_VARIABLE)
        .stdout(std::process::Stdio::piped());
    if let Some(value) = variable {
        command.env(FILE_LOCKING_VARIABLE, value);
    }
    let child = command.spawn().expect("start");
    let number = child.id();
    let output = child.wait_with_output().expect("end");
    assert!(output.status.success());
    (number, String::from_utf8_lossy(&output.stdout).into_owned())
}

#[test]
#[cfg(unix)]
fn locking_is_off_after_the_restart() {
    let (number, said) = run(None);
    assert!(said.contains(&format!("off=true failed=false pid={number}")), "{said}");
}

#[test]
fn a_choice_that_stands_is_kept() {
    let (_, said) = run(Some("BEST_EFFORT"));
    assert!(said.contains("off=false failed=false"), "{said}");
    let (_, said) = run(Some("false"));
    assert!(said.contains("off=true failed=false"), "{said}");
}
