//! The page of a recording: what was found in the files, what was done, what the motion measures.
//!
//! The same look, drawing and files as the report of a run: `report.html` without network, `figures/*.svg`
//! with their numbers as CSV beside them.

mod figures;
mod index;
mod page;
mod target;

use std::path::Path;

use hati_inputs::measures::{self, RotatedSpectrum};
use serde_json::Value;

use super::figures::{Behind, Motion, Plate, Traces};
use super::measure::{self, BANDWIDTH, DAMPING, TraceMeasures};
use super::page::Entry;
use super::place::{COMPONENTS, Drawn};
use crate::outputs::OutputError;
use crate::record::{Component, Matched, Measured, Recording};
use crate::results::Trace;

pub(crate) use index::{Row, write_index};

/// Centre frequencies of the ratio of spectra.
const RATIO_CENTRES: usize = 200;
/// Names of all figures that a recording can have.
const FIGURES: [&str; 9] = [
    "acceleration",
    "velocity",
    "displacement",
    "target-spectra",
    "response-spectra",
    "fourier-amplitude",
    "horizontal-to-vertical",
    "husid",
    "cumulative-absolute-velocity",
];

/// Writes `report.html` and `figures/` into the existing folder `dir`; `summary` is the content of
/// `record.json`. Returns the files' names within `dir`, the page last.
pub(crate) fn write_record_report(
    dir: &Path,
    recording: &Recording,
    measured: &Measured,
    summary: &Value,
) -> Result<Vec<String>, OutputError> {
    let traces: Vec<Trace> = measured.components.iter().map(|c| c.trace.clone()).collect();
    let periods = measure::periods();
    let wanted = vec![true; traces.len()];
    let mut spectra = measure::of_traces(&traces, &wanted, measured.dt, &periods);
    for (spectra, c) in spectra.iter_mut().zip(&measured.components) {
        let m = &c.measures;
        spectra.times = Some([m.t5, m.t5 + m.d5_75, m.t5 + m.d5_95]);
        spectra.peaks = Some([m.pga, m.pgv, m.pgd]);
    }
    let group = Traces {
        subject: format!("of {}", recording.name),
        suffix: String::new(),
        dt: measured.dt,
        time_first: 0.0,
        drawn: drawn(&traces),
        measures: &spectra,
        periods: &periods,
    };
    let entries = entries(&group, measured, recording.matched().as_ref());
    super::write_figures(dir, entries.iter())?;
    let html = page::page(recording, measured, summary, &entries);
    crate::outputs::replace_bytes(&dir.join("report.html"), html.as_bytes(), false)?;
    let names = entries.iter().map(|entry| entry.plate.figure.name.as_str());
    let files = names.flat_map(|name| ["svg", "csv"].map(|ending| format!("figures/{name}.{ending}")));
    Ok(files.chain(["report.html".to_owned()]).collect())
}

/// Takes away the figures that an earlier call left in `dir`.
pub(crate) fn clear_record_figures(dir: &Path) -> Result<(), OutputError> {
    for name in FIGURES {
        for ending in ["svg", "csv"] {
            let path = dir.join("figures").join(format!("{name}.{ending}"));
            match std::fs::remove_file(&path) {
                Err(cause) if cause.kind() != std::io::ErrorKind::NotFound => {
                    return Err(OutputError::from_io(&path, cause));
                }
                _ => {}
            }
        }
    }
    Ok(())
}

fn drawn(traces: &[Trace]) -> Vec<Drawn<'_>> {
    (traces.iter().enumerate())
        .map(|(index, trace)| Drawn { index, trace, stroke: COMPONENTS[trace.axis.min(2)] })
        .collect()
}

/// The figures in reading order.
fn entries(group: &Traces<'_>, measured: &Measured, matched: Option<&Matched>) -> Vec<Entry> {
    let mut entries = Vec::new();
    let mut add = |plate: Option<Plate>, heading| {
        entries.extend(plate.map(|plate| Entry { plate, heading, folded: false, words: String::new() }));
    };
    add(super::figures::histories(group, Motion::Acceleration, None), "Time histories");
    for (motion, heading) in [(Motion::Velocity, "Velocity"), (Motion::Displacement, "Displacement")] {
        let from_rest = |c: &Component| match motion {
            Motion::Velocity => c.velocity_from_rest.clone(),
            _ => c.displacement_from_rest.clone(),
        };
        let values: Vec<Vec<f64>> = measured.components.iter().map(from_rest).collect();
        // Brought to rest, the motion has one history, which is the one from rest.
        let behind = (!measured.from_rest).then(|| behind(&values));
        let mut plate = super::figures::histories(group, motion, behind.as_ref());
        if let Some(plate) = &mut plate {
            plate.caption.push_str(" The labels tell the peak, which may lie between two samples.");
        }
        if let (Some(plate), true) = (&mut plate, measured.from_rest) {
            plate
                .caption
                .push_str(" Integrated from rest, as a model follows it; PGV and PGD are its peaks.");
        }
        add(plate, heading);
    }
    add(matched.and_then(|matched| target::target_spectra(group, matched)), "Target spectrum");
    let rotated = rotated(group);
    add(figures::response_spectra(group, rotated.as_ref(), matched), "Response spectra");
    add(super::figures::fourier(group), "Fourier spectra");
    add(
        ratio(group).and_then(|(f, r)| figures::horizontal_to_vertical(group, &f, &r)),
        "Horizontal to vertical",
    );
    add(super::figures::husid(group), "Duration");
    add(figures::cumulative_absolute_velocity(group), "Cumulative absolute velocity");
    entries
}

fn behind(values: &[Vec<f64>]) -> Behind<'_> {
    Behind {
        key: "from_rest",
        words: " Coloured: without what lies below one period in the record; PGV and PGD are its peaks. Grey: \
                integrated from rest, drift included, as a model follows it.",
        values,
    }
}

/// Acceleration along an axis.
fn along<'a>(group: &Traces<'a>, axis: usize) -> Option<&'a [f64]> {
    group.drawn.iter().find(|d| d.trace.axis == axis).map(|d| d.trace.acceleration.as_slice())
}

/// Spectrum over all directions, where both horizontals are there and move.
fn rotated(group: &Traces<'_>) -> Option<RotatedSpectrum> {
    let (x, y) = (along(group, 0)?, along(group, 1)?);
    let moves = x.iter().chain(y).any(|v| *v != 0.0);
    moves.then(|| measures::rotated_spectrum(x, y, group.dt, group.periods, DAMPING))
}

/// Centre frequencies (Hz) and the smoothed ratio of horizontal to vertical amplitudes, where all three are there.
fn ratio(group: &Traces<'_>) -> Option<(Vec<f64>, Vec<f64>)> {
    let (x, y, z) = (along(group, 0)?, along(group, 1)?, along(group, 2)?);
    let duration = x.len() as f64 * group.dt;
    let centres = measures::log_periods(2.0 / duration, 0.5 / group.dt, RATIO_CENTRES);
    let ratio = measures::horizontal_to_vertical(x, y, z, group.dt, &centres, BANDWIDTH);
    Some((centres, ratio))
}

/// Whether a trace has spectra to draw.
fn has_spectra(measures: &TraceMeasures) -> bool {
    !measures.psa.is_empty()
}
