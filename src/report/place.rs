//! One look per place through all figures, told apart in grey by width and dash.

use super::svg::Stroke;
use crate::results::Trace;

/// The motion at the surface.
pub(super) const SURFACE: Stroke = Stroke::solid("#c8452b", 1.9);
/// The motion of the outcrop: the input.
pub(super) const OUTCROP: Stroke = Stroke::solid("#1d5fa8", 1.4);
/// The motion within the column, at the top of the half-space.
pub(super) const WITHIN: Stroke = Stroke::solid("#2a8c6f", 1.5).dashed("6 2.5");
/// Other stations in turn.
const STATIONS: [Stroke; 4] = [
    Stroke::solid("#7b4fa6", 1.5).dashed("9 3 2 3"),
    Stroke::solid("#b07d12", 1.4).dashed("2.5 2.5"),
    Stroke::solid("#4a98c9", 1.6).dashed("12 4"),
    Stroke::solid("#8a5a44", 1.4).dashed("5 2 2 2 2 2"),
];
/// Curves that belong to no place (profiles, closed forms).
pub(super) const COLUMN: Stroke = Stroke::solid("#27323d", 1.7);
/// Layer boundaries and other auxiliary lines.
pub(super) const AUXILIARY: Stroke = Stroke::solid("#7b8794", 1.0).dashed("3 3");

/// The components x, y, z of a recording; their dashes are those of no other curve in a figure with them.
pub(super) const COMPONENTS: [Stroke; 3] = [
    Stroke::solid("#c8452b", 1.7),
    Stroke::solid("#1d5fa8", 1.5).dashed("10 2.5 2 2.5"),
    Stroke::solid("#2a8c6f", 1.5).dashed("4 2.5"),
];

/// Most traces in one figure.
const MOST: usize = 7;

/// Line of a place; `station` counts the places that have no line of their own.
pub(super) fn stroke(place: &str, station: usize) -> Stroke {
    match place {
        "surface" => SURFACE,
        "outcrop" => OUTCROP,
        "within" => WITHIN,
        _ => STATIONS[station % STATIONS.len()],
    }
}

/// A trace with its line.
#[derive(Debug, Clone, Copy)]
pub(super) struct Drawn<'a> {
    /// Number of the trace among all of the run.
    pub(super) index: usize,
    /// The trace.
    pub(super) trace: &'a Trace,
    /// Its line.
    pub(super) stroke: Stroke,
}

/// Traces of one component in drawing order: outcrop, within, surface, then stations; seven at most.
pub(super) fn drawn(traces: &[Trace], axis: usize) -> Vec<Drawn<'_>> {
    let rank = |place: &str| match place {
        "outcrop" => 0,
        "within" => 1,
        "surface" => 2,
        _ => 3,
    };
    let mut stations = 0;
    let mut list: Vec<Drawn<'_>> = traces
        .iter()
        .enumerate()
        .filter(|(_, trace)| trace.axis == axis)
        .map(|(index, trace)| {
            let stroke = stroke(&trace.place, stations);
            stations += usize::from(rank(&trace.place) == 3);
            Drawn { index, trace, stroke }
        })
        .collect();
    list.sort_by_key(|drawn| rank(&drawn.trace.place));
    list.truncate(MOST);
    list
}

/// How a place is called in legends.
pub(super) fn words(place: &str) -> String {
    match place {
        "outcrop" => "outcrop (input)".to_owned(),
        other => other.to_owned(),
    }
}

/// Entries of a legend.
pub(super) fn legend(drawn: &[Drawn<'_>]) -> Vec<(String, Stroke)> {
    drawn.iter().map(|d| (words(&d.trace.place), d.stroke)).collect()
}
