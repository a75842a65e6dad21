//! Motion over time, one row per place on a common scale.

use super::super::place::{Drawn, words};
use super::super::svg::{Anchor, Axis, Figure, Panel, Rect, Stroke, Text, significant};
use super::super::table::Table;
use super::{GRAVITY, Plate, Traces, WIDTH, peak, peak_at};
use crate::results::Trace;

/// Which motion is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in super::super) enum Motion {
    /// m/s².
    Acceleration,
    /// m/s.
    Velocity,
    /// m.
    Displacement,
}

impl Motion {
    /// Name for files and titles.
    pub(in super::super) const fn name(self) -> &'static str {
        match self {
            Self::Acceleration => "acceleration",
            Self::Velocity => "velocity",
            Self::Displacement => "displacement",
        }
    }

    const fn unit(self) -> &'static str {
        match self {
            Self::Acceleration => "m/s²",
            Self::Velocity => "m/s",
            Self::Displacement => "m",
        }
    }

    const fn file_unit(self) -> &'static str {
        match self {
            Self::Acceleration => "m_s2",
            Self::Velocity => "m_s",
            Self::Displacement => "m",
        }
    }

    fn of(self, trace: &Trace) -> &[f64] {
        match self {
            Self::Acceleration => &trace.acceleration,
            Self::Velocity => &trace.velocity,
            Self::Displacement => &trace.displacement,
        }
    }
}

const LEFT: f64 = 78.0;
const RIGHT: f64 = 24.0;
const TOP: f64 = 46.0;
const ROW: f64 = 122.0;
const GAP: f64 = 14.0;
/// How far the scale follows the lines behind, in multiples of the largest peak of the rows' own.
const DRIFT_SHOWN: f64 = 2.0;
const BEHIND: Stroke = Stroke::solid("#8a94a0", 1.3);

/// A second line behind each row's own, faint: what it is, and its values in the order of the rows.
#[derive(Debug)]
pub(in super::super) struct Behind<'a> {
    /// For the columns of the table: `from_rest`.
    pub(in super::super) key: &'static str,
    /// For the caption, HTML.
    pub(in super::super) words: &'static str,
    /// Values, one list per trace drawn.
    pub(in super::super) values: &'a [Vec<f64>],
}

/// Time histories of one kind of motion.
pub(in super::super) fn histories(
    traces: &Traces<'_>,
    motion: Motion,
    behind: Option<&Behind<'_>>,
) -> Option<Plate> {
    let rows: Vec<_> = traces.drawn.iter().filter(|d| !motion.of(d.trace).is_empty()).collect();
    if rows.is_empty() {
        return None;
    }
    let hidden = |d: &Drawn<'_>| behind.and_then(|b| b.values.get(d.index)).map_or(&[][..], Vec::as_slice);
    let shown = rows.iter().map(|d| peak(motion.of(d.trace))).fold(0.0, f64::max);
    // A drift may leave the frame: it must not flatten the motion.
    let peak = rows.iter().map(|d| peak(hidden(d))).fold(shown, f64::max).min(DRIFT_SHOWN * shown);
    let height = TOP + rows.len() as f64 * (ROW + GAP) - GAP + 48.0;
    let title = format!("{} {}", capital(motion.name()), traces.subject);
    let mut figure = Figure::new(&traces.name(motion.name()), &title, WIDTH, height);
    let times = traces.times();
    let (first, last) = traces.time_range();
    for (number, drawn) in rows.iter().enumerate() {
        let at =
            Rect { x: LEFT, y: TOP + number as f64 * (ROW + GAP), width: WIDTH - LEFT - RIGHT, height: ROW };
        let is_last = number + 1 == rows.len();
        let y = Axis::symmetric(peak, motion.unit(), 4);
        let x = Axis::linear(first, last, "elapsed time (s)", 12);
        let panel = Panel::draw(&mut figure, at, x, y, is_last, true);
        panel.horizontal(&mut figure, 0.0, Stroke::solid("#b8c0c8", 1.0));
        let drift = hidden(drawn).iter().enumerate().map(|(i, v)| (traces.time(i), *v));
        panel.line(&mut figure, drift, BEHIND);
        let values = motion.of(drawn.trace);
        let points = values.iter().enumerate().map(|(i, v)| (traces.time(i), *v));
        panel.line(&mut figure, points, drawn.stroke.wide(1.1).dashed(""));
        mark_peak(&mut figure, &panel, traces, drawn, motion);
        let name = match drawn.trace.depth {
            Some(depth) if depth != 0.0 => {
                format!("{}, {} m deep", words(&drawn.trace.place), significant(depth, 4))
            }
            _ => words(&drawn.trace.place),
        };
        let style = Text::new(13.0).bold().colour(drawn.stroke.colour).halo();
        figure.text(at.x + 10.0, at.y + 18.0, &name, style);
        panel.close(&mut figure);
    }
    let mut table = Table::default().column("elapsed_time_s", times);
    for d in &rows {
        let name = format!("{}_{}_{}", d.trace.place, motion.name(), motion.file_unit());
        table = table.column(name, motion.of(d.trace));
        if let Some(behind) = behind {
            let name = format!("{}_{}_{}_{}", d.trace.place, motion.name(), behind.key, motion.file_unit());
            table = table.column(name, hidden(d));
        }
    }
    let mut caption = "All rows share one scale; the dot marks each row’s largest absolute value.".to_owned();
    if let Some(behind) = behind {
        caption.push_str(behind.words);
    }
    Some(Plate { figure, csv: table.to_csv(), caption })
}

fn mark_peak(figure: &mut Figure, panel: &Panel, traces: &Traces<'_>, drawn: &Drawn<'_>, motion: Motion) {
    let Some((index, value)) = peak_at(motion.of(drawn.trace)) else {
        return;
    };
    let time = traces.time(index);
    figure.dot(panel.px(time), panel.py(value), 4.0, drawn.stroke.colour);
    // A table of measures beside the figure has the same number.
    let known = traces.measures.get(drawn.index).and_then(|m| m.peaks);
    let (peak, digits) = known.map_or((value.abs(), 3), |peaks| (peaks[motion as usize], 4));
    let amount = significant(peak, digits);
    let label = if motion == Motion::Acceleration {
        let in_g = significant(peak / GRAVITY, 3);
        format!("peak {amount} m/s² = {in_g} g at {} s", significant(time, 4))
    } else {
        format!("peak {amount} {} at {} s", motion.unit(), significant(time, 4))
    };
    let style = Text::new(12.0).anchor(Anchor::End).halo();
    let x = panel.at.x + panel.at.width - 10.0;
    figure.text(x, panel.at.y + 18.0, &label, style);
}

fn capital(word: &str) -> String {
    let mut letters = word.chars();
    letters.next().map(|c| c.to_uppercase().chain(letters).collect()).unwrap_or_default()
}
