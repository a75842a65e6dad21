//! `hati`: from an accelerogram to the response of ground and structure, with error, cost and energy
//! balance stated.
//!
//! ```text
//! scene.toml ─► hati_inputs::scene ─► plan ─► run ─► outputs, report
//!                        records ─► motion_input ─┘      verify, chart: what the result is worth
//! ```
//!
//! - [`motion_input`]: the scene's motion, read, processed, converted;
//! - [`record`]: records by themselves: what was found, done and measured, the motion as files;
//! - [`plan`]: every size with its reason and the predicted error;
//! - [`run`]: the time loop and the run folder; [`volume`]: plan and run of ground in two and three dimensions;
//! - [`outputs`], [`report`]: NetCDF files and the page; [`results`]: what they are made from;
//! - [`export`]: a run folder in the formats of other programs;
//! - [`closed_form`]: the yardstick, never used by a run's solver.

pub mod calendar;
pub mod chart;
pub mod cli;
pub mod closed_form;
pub mod export;
pub mod measured;
pub mod motion_input;
pub mod outputs;
pub mod plan;
pub mod record;
pub mod report;
pub mod results;
pub mod run;
pub mod site_response;
pub mod spectrum;
pub mod verify;
pub mod volume;
