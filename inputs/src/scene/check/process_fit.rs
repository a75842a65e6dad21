//! Steps of `motion.process` against what the scene itself tells of the motion: components, quantity, step.

use crate::motion::{PAD_SAMPLES_TO, Process, Quantity};

use super::super::diagnostic::{plain, rounded};
use super::super::types::{Component, Synthetic};
use super::reader::{Checker, Place, Section};

/// What is known of a motion before its records are read.
#[derive(Debug, Clone, Copy)]
pub(super) struct Known {
    quantity: Option<Quantity>,
    /// Components that are written.
    given: [bool; 3],
    /// Whether one of them is a record; corrections of instruments are not done without.
    records: bool,
    /// Time step, s, where the scene says it.
    dt: Option<f64>,
}

impl Known {
    pub(super) fn new(
        quantity: Option<Quantity>,
        given: [bool; 3],
        components: [Option<&Component>; 3],
    ) -> Self {
        let present = || components.into_iter().flatten();
        let records = present().any(|c| matches!(c, Component::Record(_)));
        let dt = present().find_map(|component| match component {
            Component::Record(record) => record.dt,
            Component::Synthetic(Synthetic { wavelet }) => (!records).then_some(wavelet.dt),
        });
        Self { quantity, given, records, dt }
    }
}

/// Goes through the steps as they will be done and reports those that cannot be.
pub(super) fn check(cx: &mut Checker<'_>, s: &Section<'_>, process: &[Process], known: &Known) {
    let mut known = *known;
    for (i, step) in process.iter().enumerate() {
        if step.mends_an_instrument() && !known.records {
            continue;
        }
        let place = |key: &str| s.in_list("process", i + 1, key);
        one(cx, step, &known, place);
        match step {
            Process::Convert { to } => known.quantity = Some(*to),
            Process::Resample { dt } => known.dt = Some(*dt),
            // It may go to a finer step.
            Process::Match(_) => known.dt = None,
            _ => {}
        }
    }
}

fn one(cx: &mut Checker<'_>, step: &Process, known: &Known, place: impl Fn(&str) -> Place) {
    match step {
        Process::Rotate { .. } => {
            for (axis, _) in ["x", "y"].into_iter().zip(known.given).filter(|(_, given)| !given) {
                let message =
                    format!("a rotation about the vertical needs both horizontals; motion.{axis} is missing");
                cx.error(place(""), message, &format!("give [motion.{axis}], or take the step out"));
            }
        }
        Process::Baseline { .. } | Process::Rest {} | Process::Match(_) => {
            if let Some(quantity) = known.quantity.filter(|quantity| *quantity != Quantity::Acceleration) {
                let message =
                    format!("the motion is a {quantity} here; `{}` acts on an acceleration", step.word());
                cx.error(place(""), message, "put { step = \"convert\", to = \"acceleration\" } before it");
            }
        }
        Process::Filter(filter) => {
            let Some(dt) = known.dt else { return };
            let nyquist = 0.5 / dt;
            for (key, corner) in [("f_min", filter.f_min), ("f_max", filter.f_max)] {
                if let Some(f) = corner.filter(|f| *f >= nyquist) {
                    let message = format!(
                        "{} Hz is not below the Nyquist frequency {} Hz of a step of {} s",
                        plain(f),
                        rounded(nyquist),
                        plain(dt)
                    );
                    cx.error(place(key), message, "lower the corner, or leave it out");
                }
            }
        }
        Process::Pad { before, after } => {
            // No record of a ground motion has a step above a second.
            let most = PAD_SAMPLES_TO * known.dt.unwrap_or(1.0);
            if before + after > most {
                let message = format!(
                    "{} s of zeros are too many: at most {} samples, {} s",
                    rounded(before + after),
                    plain(PAD_SAMPLES_TO),
                    rounded(most)
                );
                cx.error(place(""), message, "give fewer zeros, or resample to a longer step before");
            }
        }
        _ => {}
    }
}
