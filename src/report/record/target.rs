//! The design spectrum that a motion was matched to, beside the spectra of the motion and of its seed.

use hati_inputs::measures::{log_periods, psa};

use super::super::figures::{Plate, Traces, WIDTH, peak};
use super::super::place::COMPONENTS;
use super::super::svg::{Anchor, Axis, Figure, Panel, Rect, Stroke, Text, significant};
use super::super::table::Table;
use crate::record::Matched;

/// The target's line.
pub(super) const TARGET: Stroke = Stroke::solid("#111820", 1.6).dashed("2 2.5");
/// Its tolerance.
pub(super) const BAND: &str = "#e3d9b8";
const SEED: Stroke = Stroke::solid("#8a94a0", 1.2);
/// Periods at which the spectra are drawn.
const PERIODS: usize = 240;
const ROW: f64 = 210.0;
const GAP: f64 = 16.0;
const TOP: f64 = 60.0;

/// Lower and upper limit, and the target itself, as points of a panel.
pub(super) type Band = [Vec<(f64, f64)>; 3];

/// Target with its band of tolerance over some periods; the limits
/// only within the periods of the match.
pub(super) fn band(matched: &Matched, axis: usize, periods: &[f64]) -> Band {
    let target = matched.matching.spectrum.for_axis(axis);
    let ([shortest, longest], tolerance) = (matched.matching.periods, matched.matching.tolerance);
    let line: Vec<(f64, f64)> = periods.iter().map(|&period| (period, target.psa(period))).collect();
    let inside = line.iter().filter(|(period, _)| (shortest..=longest).contains(period));
    let limit = |share: f64| inside.clone().map(|(period, value)| (*period, share * value)).collect();
    [limit(1.0 - tolerance), limit(1.0 + tolerance), line]
}

/// One row per component, at the target's damping: target and band, seed faint, matched motion.
pub(super) fn target_spectra(group: &Traces<'_>, matched: &Matched) -> Option<Plate> {
    let damping = matched.matching.spectrum.damping();
    let [shortest, longest] = matched.matching.periods;
    let periods = log_periods(shortest.min(0.01), longest.max(10.0), PERIODS);
    let rows: Vec<_> = group.drawn.iter().filter(|d| !d.trace.acceleration.is_empty()).collect();
    let height = TOP + rows.len() as f64 * (ROW + GAP) - GAP + 54.0;
    let percent = significant(100.0 * damping, 3);
    let title = format!("Match to the target {}, {percent} % damping", group.subject);
    let mut figure = Figure::new(&group.name("target-spectra"), &title, WIDTH, height);
    let mut table = Table::default().column("period_s", periods.as_slice());
    for (number, drawn) in rows.iter().enumerate() {
        let axis = drawn.trace.axis;
        let own = psa(&drawn.trace.acceleration, group.dt, &periods, damping);
        let scale = matched.scale[axis];
        let seed = matched.seed[axis].as_ref().map(|seed| psa(seed, matched.seed_dt, &periods, damping));
        let seed: Vec<f64> = seed.unwrap_or_default().iter().map(|value| value * scale).collect();
        let [low, high, line] = band(matched, axis, &periods);
        let target: Vec<f64> = line.iter().map(|(_, value)| *value).collect();
        // A seed far from the target may leave the frame: it must not flatten the other two.
        let shown = peak(&own).max(peak(&target));
        let top = peak(&seed).clamp(shown, 2.0 * shown);
        if top <= 0.0 {
            return None;
        }
        let y = TOP + number as f64 * (ROW + GAP);
        let at = Rect { x: 78.0, y, width: WIDTH - 78.0 - 24.0, height: ROW };
        let x = Axis::log(periods[0], periods[PERIODS - 1], "period (s)");
        let last = number + 1 == rows.len();
        let panel = Panel::draw(&mut figure, at, x, Axis::from_zero(top, "PSA (m/s²)", 5), last, true);
        panel.band(&mut figure, &low, &high, BAND);
        let points = |values: &[f64]| -> Vec<(f64, f64)> {
            periods.iter().copied().zip(values.iter().copied()).collect()
        };
        panel.polyline(&mut figure, &points(&seed), SEED);
        panel.polyline(&mut figure, &line, TARGET);
        panel.polyline(&mut figure, &points(&own), drawn.stroke.dashed(""));
        let name = &drawn.trace.place;
        let style = Text::new(13.0).bold().colour(COMPONENTS[axis.min(2)].colour).halo();
        figure.text(at.x + 10.0, at.y + 18.0, name, style);
        let label = ratio(&own, &target, &periods, matched.matching.periods);
        let style = Text::new(12.0).anchor(Anchor::End).halo();
        figure.text(at.x + at.width - 10.0, at.y + 18.0, &label, style);
        panel.close(&mut figure);
        table = table
            .column(format!("{name}_psa_m_s2"), own)
            .column(format!("{name}_target_psa_m_s2"), target)
            .column(format!("{name}_seed_scaled_psa_m_s2"), seed);
    }
    let solid = |colour| Stroke::solid(colour, 8.0);
    let entries = [
        ("target".to_owned(), TARGET),
        (format!("± {} %", significant(100.0 * matched.matching.tolerance, 3)), solid(BAND)),
        ("seed, scaled".to_owned(), SEED),
    ];
    figure.legend(78.0 + WIDTH - 78.0 - 24.0, &entries);
    let scales: Vec<String> = rows
        .iter()
        .map(|d| format!("{} by {}", d.trace.place, significant(matched.scale[d.trace.axis], 4)))
        .collect();
    let caption = format!(
        "Coloured: the motion of this page. Grey: the seed as it came into the match, scaled ({}) to the target's level. \
         The band spans the periods of the match; the label tells the smallest and largest ratio there.",
        scales.join(", ")
    );
    Some(Plate { figure, csv: table.to_csv(), caption })
}

/// Smallest and largest ratio to the target, in words.
fn ratio(own: &[f64], target: &[f64], periods: &[f64], within: [f64; 2]) -> String {
    let inside = periods.iter().zip(own.iter().zip(target));
    let inside = inside.filter(|(period, _)| (within[0]..=within[1]).contains(*period));
    let ratios = inside.map(|(_, (own, target))| own / target);
    let (low, high) = ratios.fold((f64::INFINITY, 0.0_f64), |(low, high), r| (low.min(r), high.max(r)));
    format!("{} to {} of the target", significant(low, 3), significant(high, 3))
}
