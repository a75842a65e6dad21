//! Elements, constraints and statics against closed forms.
#![allow(clippy::print_stdout, reason = "a test says what it found")]

mod beams;
mod bodies;
mod constraints;
mod convergence;
mod faults;
mod free_vibration;
mod geometric;
mod invariance;
mod locking;
mod patch;
