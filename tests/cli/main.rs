//! The command line from the outside: every verb with its exit code, its messages and what it leaves behind.
//!
//! The program that cargo has just built is started as a user would start it, in folders of its own. No
//! test needs a network. Tests that need Python with ObsPy or xarray, or the right to mount a small disk,
//! say so on the error output where that is missing and check nothing; with `HATI_REQUIRE_PYTHON=1`
//! missing Python is a failure.

mod check;
mod disk;
mod documentation;
mod export;
mod interrupt;
mod physics;
mod plan;
mod program;
mod python;
mod record;
mod record_bad_input;
mod record_files;
mod record_grouping;
mod regression;
mod results;
mod run;
mod scenes;
mod verbs;
mod volume;
mod volume_accuracy;
mod volume_choices;
mod volume_disk;
mod volume_input;
