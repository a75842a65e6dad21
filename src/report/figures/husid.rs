//! How the energy of the shaking builds up: Husid curves with the significant duration.

use super::super::place::{AUXILIARY, legend, words};
use super::super::svg::{Anchor, Axis, Figure, Panel, Rect, Stroke, Text, significant};
use super::super::table::Table;
use super::{Plate, Traces, WIDTH};

/// Times at which the Husid curve passes `low` and `high`, by linear interpolation, s since the first sample.
fn duration(husid: &[f64], dt: f64, low: f64, high: f64) -> Option<(f64, f64)> {
    let crossing = |level: f64| {
        let after = husid.iter().position(|v| *v >= level)?;
        let before = after.checked_sub(1)?;
        let (a, b) = (husid[before], husid[after]);
        let part = if b > a { (level - a) / (b - a) } else { 0.0 };
        Some((before as f64 + part) * dt)
    };
    Some((crossing(low)?, crossing(high)?))
}

/// Times of 5, 75 and 95 %.
fn times_of_shares(husid: &[f64], dt: f64) -> Option<[f64; 3]> {
    let (from, middle) = duration(husid, dt, 0.05, 0.75)?;
    let (_, to) = duration(husid, dt, 0.05, 0.95)?;
    Some([from, middle, to])
}

/// Husid curves of all places.
pub(in super::super) fn husid(traces: &Traces<'_>) -> Option<Plate> {
    let curves: Vec<_> = traces.drawn.iter().filter(|d| !traces.measures[d.index].husid.is_empty()).collect();
    if curves.is_empty() {
        return None;
    }
    let bars = 22.0 * curves.len() as f64 + 10.0;
    let at = Rect { x: 78.0, y: 60.0, width: WIDTH - 78.0 - 24.0, height: 230.0 + bars };
    let title = format!("Build-up of Arias intensity {}", traces.subject);
    let mut figure = Figure::new(&traces.name("husid"), &title, WIDTH, at.y + at.height + 52.0);
    let times = traces.times();
    let (first, last) = traces.time_range();
    let floor = -110.0 * bars / 230.0;
    let x = Axis::linear(first, last, "elapsed time (s)", 12);
    let y = Axis::linear(floor, 110.0, "share of Arias intensity (%)", 6)
        .with_ticks(&[0.0, 20.0, 40.0, 60.0, 80.0, 100.0]);
    let panel = Panel::draw(&mut figure, at, x, y, true, true);
    for level in [5.0, 75.0, 95.0] {
        panel.horizontal(&mut figure, level, AUXILIARY);
    }
    let mut table = Table::default().column("elapsed_time_s", times);
    for (row, d) in curves.iter().enumerate() {
        let husid = &traces.measures[d.index].husid;
        let points = husid.iter().enumerate().map(|(i, v)| (traces.time(i), 100.0 * v));
        panel.line(&mut figure, points, d.stroke);
        table = table.column(format!("{}_husid", d.trace.place), husid.as_slice());
        let known = traces.measures[d.index].times;
        let Some([from, middle, to]) = known.or_else(|| times_of_shares(husid, traces.dt)) else {
            continue;
        };
        let [x0, xm, x1] = [from, middle, to].map(|time| panel.px(time + traces.time_first));
        let y = panel.py(0.0) + 16.0 + 22.0 * row as f64;
        figure.segment((x0, y), (x1, y), Stroke::solid(d.stroke.colour, 3.0));
        figure.segment((x0, y), (xm, y), Stroke::solid(d.stroke.colour, 8.0));
        for (x, level) in [(x0, 5.0), (xm, 75.0), (x1, 95.0)] {
            figure.dot(x, panel.py(level), 3.6, d.stroke.colour);
        }
        let label = format!(
            "{}: Arias {} m/s, D5–75 = {} s, D5–95 = {} s",
            words(&d.trace.place),
            significant(traces.measures[d.index].arias_intensity, 3),
            significant(middle - from, 3),
            significant(to - from, 3)
        );
        // Beside the bar where there is room, else on it.
        let width = 6.9 * label.chars().count() as f64 + 16.0;
        let (x, anchor) = if x1 + width < at.x + at.width {
            (x1 + 8.0, Anchor::Start)
        } else if x0 - width > at.x {
            (x0 - 8.0, Anchor::End)
        } else {
            ((x0 + x1) / 2.0, Anchor::Middle)
        };
        figure.text(x, y + 4.0, &label, Text::new(12.0).anchor(anchor).halo());
    }
    figure.legend(at.x + at.width, &legend(&traces.drawn));
    panel.close(&mut figure);
    Some(Plate {
        figure,
        csv: table.to_csv(),
        caption:
            "Share of ∫a² dt reached by each time. Bars: significant duration, thick from 5 to 75 %, thin on \
                  to 95 %."
                .to_owned(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn duration_of_a_ramp() {
        let ramp: Vec<f64> = (0..=100).map(|i| f64::from(i) / 100.0).collect();
        let (from, to) = duration(&ramp, 0.1, 0.05, 0.95).expect("crossings");
        assert!((from - 0.5).abs() < 1e-12 && (to - 9.5).abs() < 1e-12);
        assert!(duration(&[], 0.1, 0.05, 0.95).is_none());
        assert!(duration(&[f64::NAN; 4], 0.1, 0.05, 0.95).is_none());
    }
}
