//! The figures of a site response, one function each; all take the same view of the run.

mod fourier;
mod histories;
mod husid;
mod ledger;
mod mesh;
mod profile;
mod section;
mod spectra;
mod transfer;
mod wave;
mod wave_film;
mod wave_maps;

pub(super) use fourier::fourier;
pub(super) use histories::{Behind, Motion, histories};
pub(super) use husid::husid;
pub(super) use ledger::{Ledgered, closing_error, ledger};
pub(super) use mesh::mesh;
pub(super) use profile::profile;
pub(super) use section::section;
pub(super) use spectra::{ratio, response_spectra};
pub(super) use transfer::{LawGap, law_gap, percent, transfer};
pub(super) use wave_film::{Film, film};
pub(super) use wave_maps::{distance_time, peak_maps, snapshots};

use super::measure::TraceMeasures;
use super::place::{self, Drawn};
use super::svg::Figure;
use crate::results::{AXES, SiteResponse, Trace};

/// Standard gravity, m/s².
pub(super) const GRAVITY: f64 = 9.806_65;
/// Width of every figure, pixels.
pub(super) const WIDTH: f64 = 1080.0;

/// Traces over one time axis that figures draw together: those of one component of a run at several
/// places, or the components of a recording.
#[derive(Debug)]
pub(super) struct Traces<'a> {
    /// What they have in common, for titles: `along x`, `of E`.
    pub(super) subject: String,
    /// Ending of the figures' file names, with its hyphen.
    pub(super) suffix: String,
    /// Step, s.
    pub(super) dt: f64,
    /// Elapsed time of the first sample, s.
    pub(super) time_first: f64,
    /// Traces to draw, in order.
    pub(super) drawn: Vec<Drawn<'a>>,
    /// Spectra and Husid curves; [`Drawn::index`] counts in here.
    pub(super) measures: &'a [TraceMeasures],
    /// Periods of the response spectra, s.
    pub(super) periods: &'a [f64],
}

impl Traces<'_> {
    /// File name without ending.
    pub(super) fn name(&self, what: &str) -> String {
        format!("{what}{}", self.suffix)
    }

    /// Elapsed time of sample `index`, s.
    pub(super) fn time(&self, index: usize) -> f64 {
        self.time_first + index as f64 * self.dt
    }

    fn longest(&self) -> usize {
        let longest = |t: &Trace| t.acceleration.len().max(t.velocity.len()).max(t.displacement.len());
        self.drawn.iter().map(|d| longest(d.trace)).max().unwrap_or(0)
    }

    /// From the first sample to one step after the last, s.
    pub(super) fn time_range(&self) -> (f64, f64) {
        (self.time(0), self.time(self.longest()))
    }

    /// Elapsed times of the longest trace drawn, s.
    pub(super) fn times(&self) -> Vec<f64> {
        (0..self.longest()).map(|i| self.time(i)).collect()
    }
}

/// One component of a run with what was computed for its figures.
#[derive(Debug)]
pub(super) struct View<'a> {
    /// The run.
    pub(super) data: &'a SiteResponse,
    /// Component.
    pub(super) axis: usize,
    /// Its motions at all places that are drawn.
    pub(super) traces: Traces<'a>,
}

impl<'a> View<'a> {
    /// The view of component `axis`.
    pub(super) fn new(
        data: &'a SiteResponse,
        axis: usize,
        measures: &'a [TraceMeasures],
        periods: &'a [f64],
    ) -> Self {
        let letter = AXES.get(axis).copied().unwrap_or('?');
        let traces = Traces {
            subject: format!("along {letter}"),
            suffix: format!("-{letter}"),
            dt: data.dt,
            time_first: data.time_first,
            drawn: place::drawn(&data.traces, axis),
            measures,
            periods,
        };
        Self { data, axis, traces }
    }

    /// Letter of the component.
    pub(super) fn letter(&self) -> char {
        AXES.get(self.axis).copied().unwrap_or('?')
    }

    /// File name without ending.
    pub(super) fn name(&self, what: &str) -> String {
        self.traces.name(what)
    }
}

/// A finished figure: the drawing, the numbers behind it, the words below it.
#[derive(Debug)]
pub(super) struct Plate {
    /// The drawing.
    pub(super) figure: Figure,
    /// Comma-separated numbers.
    pub(super) csv: String,
    /// Words below it, as HTML.
    pub(super) caption: String,
}

/// Largest absolute finite value; 0 for none.
pub(super) fn peak(values: &[f64]) -> f64 {
    values.iter().filter(|v| v.is_finite()).fold(0.0, |m: f64, v| m.max(v.abs()))
}

/// Index and value of the largest absolute finite value.
pub(super) fn peak_at(values: &[f64]) -> Option<(usize, f64)> {
    values
        .iter()
        .copied()
        .enumerate()
        .filter(|(_, v)| v.is_finite())
        .max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))
}

/// Smallest and largest finite value.
pub(super) fn extent(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    values.filter(|v| v.is_finite()).fold(None, |range, v| match range {
        None => Some((v, v)),
        Some((low, high)) => Some((v.min(low), v.max(high))),
    })
}

impl View<'_> {
    /// One-way travel time from the half-space to the surface at the reference frequency, s;
    /// `None` without layers above a half-space.
    pub(super) fn travel_time(&self) -> Option<f64> {
        let time: f64 = self
            .data
            .layers
            .iter()
            .filter(|layer| layer.bottom.is_finite())
            .map(|layer| {
                let speed = if self.axis == 2 { layer.vp } else { layer.vs };
                (layer.bottom - layer.top) / speed
            })
            .sum();
        (time.is_finite() && time > 0.0).then_some(time)
    }
}
