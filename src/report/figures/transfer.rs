//! Transfer functions of the run with two closed forms: the causal law that the run uses, and the textbooks'.

use num_complex::Complex64;

use super::super::place::{self, COLUMN};
use super::super::svg::{Axis, Figure, Panel, Rect, Stroke, Text, significant};
use super::super::table::Table;
use super::{Plate, View, WIDTH, extent};
use crate::results::TransferFunction;

const LEFT: f64 = 72.0;
const GAP: f64 = 78.0;
const AMPLITUDE: f64 = 290.0;
const PHASE: f64 = 150.0;
const CAUSAL: Stroke = COLUMN.wide(1.3);
const HYSTERETIC: Stroke = Stroke::solid("#9b3d9a", 1.6).dashed("6 4");

/// Largest differences between the curves of one transfer function, relative to the causal law's peak.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in super::super) struct LawGap {
    /// Peak of the causal amplitude, 1, and where it lies, Hz.
    pub(in super::super) peak: (f64, f64),
    /// Largest difference of the two closed forms' amplitudes over that peak, and where it lies, Hz.
    pub(in super::super) between_laws: (f64, f64),
    /// Largest difference of the run's amplitude from the causal one over that peak, and where it lies, Hz.
    pub(in super::super) of_run: Option<(f64, f64)>,
}

/// Differences of one transfer function's curves; `None` without closed forms.
pub(in super::super) fn law_gap(transfer: &TransferFunction) -> Option<LawGap> {
    let frequency = &transfer.closed_form_frequency;
    let causal: Vec<f64> = transfer.causal.iter().map(|c| c.norm()).collect();
    let largest = |pairs: &mut dyn Iterator<Item = (f64, f64)>| {
        pairs.filter(|(size, at)| size.is_finite() && at.is_finite()).max_by(|a, b| a.0.total_cmp(&b.0))
    };
    let peak = largest(&mut causal.iter().copied().zip(frequency.iter().copied()))?;
    if peak.0 <= 0.0 {
        return None;
    }
    let mut laws = causal
        .iter()
        .zip(&transfer.hysteretic)
        .zip(frequency)
        .map(|((c, h), f)| ((c - h.norm()).abs() / peak.0, *f));
    let between_laws = largest(&mut laws)?;
    let mut run = transfer.frequency.iter().zip(&transfer.computed).filter_map(|(f, c)| {
        let reference = interpolate(frequency, &causal, *f)?;
        Some(((c.norm() - reference).abs() / peak.0, *f))
    });
    let of_run = largest(&mut run);
    Some(LawGap { peak, between_laws, of_run })
}

/// Linear interpolation in a table with increasing `x`; `None` outside it.
fn interpolate(x: &[f64], y: &[f64], at: f64) -> Option<f64> {
    let above = x.partition_point(|v| *v < at);
    let (x1, y1) = (*x.get(above)?, *y.get(above)?);
    if x1 == at {
        return Some(y1);
    }
    let below = above.checked_sub(1)?;
    let part = (at - x[below]) / (x1 - x[below]);
    Some(y[below] + part * (y1 - y[below]))
}

/// Amplitude and phase of every transfer function of one component, side by side.
pub(in super::super) fn transfer(view: &View<'_>) -> Option<Plate> {
    let all: Vec<&TransferFunction> = view
        .data
        .transfer
        .iter()
        .filter(|t| t.axis == view.axis)
        .filter(|t| !(t.computed.is_empty() && t.causal.is_empty()))
        .take(2)
        .collect();
    if all.is_empty() {
        return None;
    }
    let (low, high) = frequency_range(&all)?;
    let title = format!("Transfer functions along {}", view.letter());
    let height = 88.0 + AMPLITUDE + 22.0 + PHASE + 50.0;
    let mut figure = Figure::new(&view.name("transfer-functions"), &title, WIDTH, height);
    let count = all.len() as f64;
    let width = (WIDTH - LEFT - 24.0 - (count - 1.0) * GAP) / count;
    for (number, transfer) in all.iter().enumerate() {
        let x = LEFT + number as f64 * (width + GAP);
        draw_one(&mut figure, transfer, x, width, (low, high));
    }
    let run = run_stroke(&all[0].name);
    figure.legend(
        WIDTH - 24.0,
        &[
            ("this run".to_owned(), run),
            ("causal law, closed form".to_owned(), CAUSAL),
            ("G(1 + 2iD), not causal".to_owned(), HYSTERETIC),
        ],
    );
    Some(Plate {
        figure,
        csv: table(&all),
        caption: "Ratio of the run’s own spectra where the denominator carries energy (wide), and closed \
                  forms for the same layers. Phase: positive where the numerator leads."
            .to_owned(),
    })
}

/// The run's line: the colour of the place in the numerator, wide and pale under the closed forms.
fn run_stroke(name: &str) -> Stroke {
    let place = name.split('/').next().unwrap_or_default().trim();
    place::stroke(place, 0).dashed("").wide(5.0).faint(0.45)
}

fn frequency_range(all: &[&TransferFunction]) -> Option<(f64, f64)> {
    let closed = all.iter().flat_map(|t| t.closed_form_frequency.iter());
    let run = all.iter().flat_map(|t| t.frequency.iter());
    let positive = |f: &&f64| **f > 0.0;
    extent(closed.filter(positive).copied()).or_else(|| extent(run.filter(positive).copied()))
}

fn draw_one(figure: &mut Figure, transfer: &TransferFunction, x: f64, width: f64, range: (f64, f64)) {
    // Closed forms have no holes, whatever the spacing of their frequencies.
    let (run, closed) = (&transfer.frequency, &transfer.closed_form_frequency);
    let curves = [
        (run, &transfer.computed, run_stroke(&transfer.name), hole(run)),
        (closed, &transfer.hysteretic, HYSTERETIC, f64::INFINITY),
        (closed, &transfer.causal, CAUSAL, f64::INFINITY),
    ];
    let inside = |f: f64| f >= range.0 && f <= range.1;
    let sizes = curves.iter().flat_map(|(frequency, values, ..)| {
        frequency.iter().zip(values.iter()).filter(|(f, _)| inside(**f)).map(|(_, v)| v.norm())
    });
    let top = extent(sizes).map_or(1.0, |(_, high)| high);
    let at = Rect { x, y: 88.0, width, height: AMPLITUDE };
    figure.text(x, 76.0, &transfer.name.replace('/', " / "), Text::new(13.0).bold());
    let frequency_axis = Axis::log(range.0, range.1, "frequency (Hz)");
    let y = Axis::from_zero(top, "amplitude (1)", 6);
    let panel = Panel::draw(figure, at, frequency_axis.clone(), y, false, true);
    for (frequency, values, stroke, hole) in &curves {
        panel.line(figure, with_gaps(frequency, values, *hole, |v| v.norm()), *stroke);
    }
    panel.close(figure);
    let at = Rect { x, y: at.y + AMPLITUDE + 22.0, width, height: PHASE };
    let y = Axis::linear(-190.0, 190.0, "phase (°)", 4).with_ticks(&[-180.0, -90.0, 0.0, 90.0, 180.0]);
    let panel = Panel::draw(figure, at, frequency_axis, y, true, true);
    for (frequency, values, stroke, hole) in &curves {
        let points = with_gaps(frequency, values, *hole, |v| v.arg().to_degrees());
        let stroke = if stroke.width > 4.0 { stroke.wide(4.0) } else { *stroke };
        panel.line(figure, without_wraps(points), stroke);
    }
    panel.close(figure);
}

/// Distance of neighbouring frequencies above which a spectrum has a hole: six times the median one.
fn hole(frequency: &[f64]) -> f64 {
    let mut steps: Vec<f64> = frequency.windows(2).map(|w| w[1] - w[0]).collect();
    if steps.is_empty() {
        return f64::INFINITY;
    }
    let middle = steps.len() / 2;
    let (_, median, _) = steps.select_nth_unstable_by(middle, f64::total_cmp);
    6.0 * *median
}

/// Points of a curve with a missing point where two frequencies are further apart than `hole`.
fn with_gaps<'a>(
    frequency: &'a [f64],
    values: &'a [Complex64],
    hole: f64,
    of: impl Fn(&Complex64) -> f64 + 'a,
) -> impl Iterator<Item = (f64, f64)> + 'a {
    let mut before = f64::NAN;
    frequency.iter().zip(values).flat_map(move |(f, v)| {
        let missing = (f - before > hole).then_some((f64::NAN, f64::NAN));
        before = *f;
        missing.into_iter().chain(std::iter::once((*f, of(v))))
    })
}

/// Breaks a curve of phases where it jumps from one end of the circle to the other.
fn without_wraps(points: impl Iterator<Item = (f64, f64)>) -> impl Iterator<Item = (f64, f64)> {
    let mut before = f64::NAN;
    points.flat_map(move |(f, phase)| {
        let jump = ((phase - before).abs() > 180.0).then_some((f64::NAN, f64::NAN));
        before = phase;
        jump.into_iter().chain(std::iter::once((f, phase)))
    })
}

fn table(all: &[&TransferFunction]) -> String {
    let mut table = Table::default();
    for t in all {
        let name = t.name.replace('/', "_over_");
        let amplitude = |v: &[Complex64]| v.iter().map(|c| c.norm()).collect::<Vec<f64>>();
        let phase = |v: &[Complex64]| v.iter().map(|c| c.arg().to_degrees()).collect::<Vec<f64>>();
        table = table
            .column(format!("{name}_frequency_hz"), t.frequency.as_slice())
            .column(format!("{name}_run_amplitude"), amplitude(&t.computed))
            .column(format!("{name}_run_phase_deg"), phase(&t.computed))
            .column(format!("{name}_closed_form_frequency_hz"), t.closed_form_frequency.as_slice())
            .column(format!("{name}_causal_amplitude"), amplitude(&t.causal))
            .column(format!("{name}_causal_phase_deg"), phase(&t.causal))
            .column(format!("{name}_hysteretic_amplitude"), amplitude(&t.hysteretic))
            .column(format!("{name}_hysteretic_phase_deg"), phase(&t.hysteretic));
    }
    table.to_csv()
}

/// The size of a relative difference in words, for captions.
pub(in super::super) fn percent(share: f64) -> String {
    format!("{} %", significant(share * 100.0, 2))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn example() -> TransferFunction {
        let frequency: Vec<f64> = (1..=100).map(|i| f64::from(i) * 0.1).collect();
        let real = |f: fn(f64) -> f64| frequency.iter().map(|x| Complex64::new(f(*x), 0.0)).collect();
        TransferFunction {
            name: "surface/outcrop".to_owned(),
            axis: 0,
            frequency: vec![1.05],
            computed: vec![Complex64::new(0.0, 2.5)],
            closed_form_frequency: frequency.clone(),
            causal: real(|_| 2.0),
            hysteretic: real(|x| if x > 9.95 { 3.0 } else { 2.0 }),
        }
    }

    #[test]
    fn gaps_are_relative_to_the_peak() {
        let gap = law_gap(&example()).expect("closed forms");
        assert!((gap.between_laws.0 - 0.5).abs() < 1e-12);
        assert!((gap.between_laws.1 - 10.0).abs() < 1e-9);
        let (run, at) = gap.of_run.expect("run inside the table");
        assert!((run - 0.25).abs() < 1e-12 && (at - 1.05).abs() < 1e-12);
    }

    #[test]
    fn no_closed_form_no_gap() {
        let empty = TransferFunction { causal: Vec::new(), ..example() };
        assert!(law_gap(&empty).is_none());
    }

    #[test]
    fn wraps_break_the_line() {
        let points = without_wraps([(1.0, 170.0), (2.0, -170.0)].into_iter()).collect::<Vec<_>>();
        assert_eq!(points.len(), 3);
        assert!(points[1].1.is_nan());
    }
}
