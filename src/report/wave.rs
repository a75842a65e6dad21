//! The page of a run in two or three dimensions: the mesh, the surface's motion as pictures and a film, peak maps,
//! histories at stations, the energy ledger.

use std::fmt::Write as _;
use std::path::Path;

use super::figures::{self, Film, Ledgered, Motion, Traces};
use super::page::{self, Entry};
use super::svg::escape;
use super::{measure, place};
use crate::outputs::OutputError;
use crate::outputs::wave::Cells;
use crate::results::{AXES, LedgerRow, Trace};

/// Motion of the surface over time, as the page draws it.
#[derive(Debug, Clone)]
pub struct SurfaceMotion {
    /// Points and cells of the surface: quadrilaterals, or edges of a section; drawn from above.
    pub cells: Cells,
    /// Elapsed time of every instant, s, increasing.
    pub time: Vec<f64>,
    /// Length of the velocity vector, m/s, `[instant][point]`.
    pub speed: Vec<f32>,
    /// Largest length of displacement (m), velocity (m/s) and acceleration (m/s²) at the points over the
    /// run; empty where it was not kept.
    pub peaks: [Vec<f32>; 3],
}

impl SurfaceMotion {
    /// Whether the lengths of its arrays fit together and there is something to draw.
    #[must_use]
    pub fn is_sound(&self) -> bool {
        let points = self.cells.points.len();
        points > 0
            && !self.cells.is_empty()
            && self.cells.corners.iter().all(|&corner| (corner as usize) < points)
            && self.speed.len() == self.time.len() * points
            && self.peaks.iter().all(|peak| peak.is_empty() || peak.len() == points)
    }

    /// Speeds at an instant.
    pub(super) fn frame(&self, instant: usize) -> &[f32] {
        let points = self.cells.points.len();
        &self.speed[instant * points..(instant + 1) * points]
    }
}

/// The mesh as the page draws it.
#[derive(Debug, Clone, Default)]
pub struct MeshPicture {
    /// Names of the materials.
    pub materials: Vec<String>,
    /// Views, drawn side by side.
    pub views: Vec<MeshView>,
    /// Names and places x, y, z of the sources, m.
    pub sources: Vec<(String, [f64; 3])>,
    /// Names and places of the stations, m.
    pub stations: Vec<(String, [f64; 3])>,
}

/// A view of the mesh.
#[derive(Debug, Clone)]
pub struct MeshView {
    /// From where.
    pub title: String,
    /// Which coordinates run to the right and up: 0 x, 1 y, 2 z.
    pub axes: [usize; 2],
    /// What is seen, from far to near.
    pub faces: Vec<MeshFace>,
}

/// An element or a side of one, as a view shows it.
#[derive(Debug, Clone)]
pub struct MeshFace {
    /// Number of its material.
    pub material: usize,
    /// Its outline: to the right and up, m.
    pub outline: Vec<[f64; 2]>,
}

/// A number of the page's head with what it is and a word on it.
#[derive(Debug, Clone)]
pub struct KeyNumber {
    /// What it is.
    pub label: String,
    /// The number with its unit.
    pub value: String,
    /// A word on it.
    pub note: String,
}

/// What the page shows.
#[derive(Debug, Clone, Default)]
pub struct WavePage {
    /// The scene's title.
    pub title: String,
    /// A line below it: dimension, elements, order.
    pub subtitle: String,
    /// What a reader has to know first.
    pub warnings: Vec<String>,
    /// The head's numbers.
    pub numbers: Vec<KeyNumber>,
    /// The mesh.
    pub mesh: MeshPicture,
    /// Rows of the energy ledger: J, of a section J/m.
    pub ledger: Vec<LedgerRow>,
    /// Whether the ground is a section.
    pub is_section: bool,
    /// The surface, where it was kept.
    pub surface: Option<SurfaceMotion>,
    /// Motions at stations.
    pub traces: Vec<Trace>,
    /// Their step, s.
    pub dt: f64,
    /// Elapsed time of their first sample, s.
    pub time_first: f64,
}

/// Writes `report.html` and `figures/` into the existing folder `dir`.
///
/// # Errors
/// Unwritable folder, full disk, an image that cannot be encoded.
pub fn write_wave_report(dir: &Path, page: &WavePage) -> Result<(), OutputError> {
    let mut entries = vec![];
    let plain = |plate, heading| Entry { plate, heading, folded: false, words: String::new() };
    entries.extend(figures::mesh(&page.mesh).map(|plate| plain(plate, "The model")));
    if let Some(surface) = page.surface.as_ref().filter(|s| s.is_sound()) {
        entries.extend(surface_entries(surface)?);
    }
    let periods = measure::periods();
    let wanted: Vec<bool> = vec![true; page.traces.len()];
    let measures = measure::of_traces(&page.traces, &wanted, page.dt, &periods);
    for axis in (0..3).filter(|&axis| page.traces.iter().any(|t| t.axis == axis)) {
        let letter = AXES[axis];
        let traces = Traces {
            subject: format!("along {letter}"),
            suffix: format!("-{letter}"),
            dt: page.dt,
            time_first: page.time_first,
            drawn: place::drawn(&page.traces, axis),
            measures: &measures,
            periods: &periods,
        };
        let plates = [
            (figures::histories(&traces, Motion::Velocity, None), "Velocity at the stations", false),
            (figures::histories(&traces, Motion::Acceleration, None), "Acceleration", true),
            (figures::histories(&traces, Motion::Displacement, None), "Displacement", true),
            (figures::fourier(&traces), "Fourier spectra", true),
        ];
        for (plate, heading, folded) in plates {
            entries.extend(plate.map(|plate| Entry { plate, heading, folded, words: String::new() }));
        }
    }
    let kind = if page.is_section { Ledgered::Section } else { Ledgered::Volume };
    entries.extend(figures::ledger(&page.ledger, kind).map(|plate| plain(plate, "Where the energy went")));
    super::write_figures(dir, entries.iter())?;
    crate::outputs::replace_bytes(&dir.join("report.html"), html(page, &entries).as_bytes(), false)
}

/// Pictures, film and peak maps of the surface.
fn surface_entries(surface: &SurfaceMotion) -> Result<Vec<Entry>, OutputError> {
    let mut entries = vec![];
    let plain = |plate, heading| Entry { plate, heading, folded: false, words: String::new() };
    if surface.cells.dimension == 1 {
        entries.extend(figures::distance_time(surface)?.map(|plate| plain(plate, "Waves along the surface")));
        return Ok(entries);
    }
    entries.extend(figures::snapshots(surface)?.map(|plate| plain(plate, "Waves on the surface")));
    if let Some(Film { plate, words }) = figures::film(surface)? {
        entries.push(Entry { plate, heading: "The same in motion", folded: false, words });
    }
    entries.extend(figures::peak_maps(surface)?.map(|plate| plain(plate, "Largest motion of the surface")));
    Ok(entries)
}

fn html(page: &WavePage, entries: &[Entry]) -> String {
    let mut html = format!(
        "<header><p class=\"eyebrow\">hati {}</p><h1>{}</h1><p class=\"sub\">{}</p></header>",
        env!("CARGO_PKG_VERSION"),
        escape(&page.title),
        escape(&page.subtitle)
    );
    if !page.warnings.is_empty() {
        let items: String = page.warnings.iter().map(|w| format!("<li>{}</li>", escape(w))).collect();
        let word = if page.warnings.len() == 1 { "Warning" } else { "Warnings" };
        let _ = write!(
            html,
            "<section class=\"warnings\" role=\"alert\"><h2>{word}</h2><ul>{items}</ul></section>"
        );
    }
    if !page.numbers.is_empty() {
        html.push_str("<section class=\"numbers\">");
        for KeyNumber { label, value, note } in &page.numbers {
            let _ = write!(
                html,
                "<div class=\"number\"><span class=\"label\">{}</span><span class=\"value\">{}</span>\
                 <span class=\"note\">{}</span></div>",
                escape(label),
                escape(value),
                escape(note)
            );
        }
        html.push_str("</section>");
    }
    html.push_str("<section class=\"component\">");
    entries.iter().for_each(|entry| page::entry_html(&mut html, entry));
    html.push_str("</section>");
    let footer = format!("SI units; x and y horizontal, z up. {}", page::FIGURES_TOO);
    page::document(&page.title, &html, &footer)
}
