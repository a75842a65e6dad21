//! The report of a run: one page with figures, each figure also as a file with its numbers beside it.
//!
//! [`write_report`] writes into the run folder
//! - `report.html`: self-contained, opens from the disk without a network, prints;
//! - `figures/*.svg`: every figure of the page;
//! - `figures/*.csv`: the numbers behind it, at full resolution unless the figure's text says otherwise.
//!
//! Values missing from the summary read `—`; what cannot be drawn (no samples, no ledger) is left out.

mod chart;
mod coarse;
mod cost;
mod dispersion;
mod figures;
mod first_screen;
mod measure;
mod page;
mod parameters;
mod place;
mod record;
mod svg;
mod table;
mod tables;
mod value;
pub mod wave;

use std::path::Path;

pub(crate) use chart::{chart_figure, chart_page};
pub(crate) use coarse::{CoarseCurve, coarse_figure};
pub(crate) use cost::{CostCurve, cost_figure};
pub(crate) use dispersion::{DispersionCurve, dispersion_figure};
pub(crate) use record::{Row, clear_record_figures, write_index, write_record_report};

use figures::{Motion, Plate, View};
use page::{Component, Entry};

use crate::outputs::OutputError;
use crate::results::SiteResponse;

/// Writes `report.html` and `figures/` into the existing folder `dir`.
///
/// Spectra are computed only for the traces that are drawn: per component outcrop, within, surface and
/// the first four stations.
///
/// # Errors
/// Unwritable folder, full disk, an image that cannot be encoded.
pub fn write_report(dir: &Path, data: &SiteResponse) -> Result<(), OutputError> {
    let periods = measure::periods();
    let measures = measure::of_all(data, &periods);
    let mut components = Vec::new();
    for axis in active_axes(data) {
        let view = View::new(data, axis, &measures, &periods);
        components.push(Component { axis, entries: entries(&view)? });
    }
    let ledger = figures::ledger(&data.ledger, figures::Ledgered::Column).map(|plate| Entry {
        plate,
        heading: "Where the energy went",
        folded: false,
        words: String::new(),
    });
    write_figures(dir, components.iter().flat_map(|c| &c.entries).chain(&ledger))?;
    let html = page::page(data, &components, ledger.as_ref());
    crate::outputs::replace_bytes(&dir.join("report.html"), html.as_bytes(), false)
}

/// Components that anything was recorded for.
fn active_axes(data: &SiteResponse) -> Vec<usize> {
    (0..3)
        .filter(|&axis| {
            data.traces.iter().any(|t| t.axis == axis)
                || data.peaks.iter().any(|p| p.axis == axis)
                || data.transfer.iter().any(|t| t.axis == axis)
                || data.sections.iter().any(|s| s.axis == axis)
        })
        .collect()
}

/// The figures of one component in reading order.
fn entries(view: &View<'_>) -> Result<Vec<Entry>, OutputError> {
    let mut entries = Vec::new();
    let mut add = |plate: Option<Plate>, heading, folded, words: String| {
        entries.extend(plate.map(|plate| Entry { plate, heading, folded, words }));
    };
    let none = String::new;
    add(figures::histories(&view.traces, Motion::Acceleration, None), "Time histories", false, none());
    add(figures::histories(&view.traces, Motion::Velocity, None), "Velocity", true, none());
    add(figures::histories(&view.traces, Motion::Displacement, None), "Displacement", true, none());
    add(figures::profile(view), "With depth", false, none());
    add(figures::response_spectra(view), "Response spectra", false, none());
    add(figures::ratio(view), "Amplification", false, none());
    let laws = page::damping_laws(view);
    add(figures::transfer(view), "Transfer functions", false, laws);
    add(figures::section(view)?, "Waves in the column", false, none());
    add(figures::husid(&view.traces), "Duration", false, none());
    add(figures::fourier(&view.traces), "Fourier spectra", false, none());
    Ok(entries)
}

fn write_figures<'a>(dir: &Path, entries: impl Iterator<Item = &'a Entry>) -> Result<(), OutputError> {
    let folder = dir.join("figures");
    std::fs::create_dir_all(&folder).map_err(|cause| OutputError::from_io(&folder, cause))?;
    for entry in entries {
        let plate = &entry.plate;
        for (ending, content) in [("svg", plate.figure.finish()), ("csv", plate.csv.clone())] {
            let path = folder.join(format!("{}.{ending}", plate.figure.name));
            std::fs::write(&path, content).map_err(|cause| OutputError::from_io(&path, cause))?;
        }
    }
    Ok(())
}
