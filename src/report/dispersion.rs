//! Phase error of plane waves against points per wavelength: the figure of the case `dispersion`.

use super::svg::{Anchor, Axis, Figure, Panel, Rect, Stroke, Text};
use super::table::Table;

const WIDTH: f64 = 1080.0;
const HEIGHT: f64 = 520.0;
/// Least and largest error drawn, parts of a cycle.
const ERRORS: (f64, f64) = (1e-8, 0.3);

/// One colour and one dash per order, so that the lines part in grey as well.
pub(super) const STROKES: [(&str, &str); 8] = [
    ("#7b8794", "2 3"),
    ("#b44d12", "6 3"),
    ("#de911d", ""),
    ("#3f9142", "8 3 2 3"),
    ("#0967d2", ""),
    ("#6b2fb3", "4 2"),
    ("#ba2525", "1 2"),
    ("#102a43", ""),
];

/// Phase errors of one order, absolute, parts of a cycle per wavelength.
#[derive(Debug, Clone)]
pub(crate) struct DispersionCurve {
    /// Polynomial order.
    pub(crate) order: usize,
    /// Points per wavelength.
    pub(crate) points: Vec<f64>,
    /// Space alone.
    pub(crate) space: Vec<f64>,
    /// Step alone.
    pub(crate) time: Vec<f64>,
    /// Both.
    pub(crate) both: Vec<f64>,
}

/// The figure as SVG and its numbers as CSV; `part` is the step over its limit.
pub(crate) fn dispersion_figure(curves: &[DispersionCurve], part: f64) -> (String, String) {
    let title = "Phase error of plane waves along an axis of the mesh";
    let mut figure = Figure::new("dispersion", title, WIDTH, HEIGHT);
    let range = |pick: fn(f64, f64) -> f64, from: f64| {
        curves.iter().flat_map(|c| c.points.iter().copied()).fold(from, pick)
    };
    let (low, high) = (range(f64::min, f64::INFINITY), range(f64::max, 0.0));
    let step = format!("with a step of {part} of the limit (P wave, cubes)");
    let halves = [("space alone".to_owned(), false), (step, true)];
    for (i, (words, stepped)) in halves.iter().enumerate() {
        let at = Rect { x: 84.0 + 500.0 * i as f64, y: 84.0, width: 440.0, height: 376.0 };
        let x = Axis::log(low, high, "points per wavelength, N λ/h (1)");
        let y = Axis::log(ERRORS.0, ERRORS.1, "phase error per wavelength (cycles)");
        let panel = Panel::draw(&mut figure, at, x, y, true, i == 0);
        for (c, (colour, dash)) in curves.iter().zip(STROKES.iter().cycle()) {
            let stroke = Stroke::solid(colour, 1.8).dashed(dash);
            let drawn = |errors: &[f64]| -> Vec<(f64, f64)> {
                c.points.iter().copied().zip(errors.iter().copied()).filter(|p| p.1 >= ERRORS.0).collect()
            };
            if *stepped {
                panel.polyline(&mut figure, &drawn(&c.time), stroke.wide(3.5).faint(0.25).dashed(""));
            }
            panel.polyline(&mut figure, &drawn(if *stepped { &c.both } else { &c.space }), stroke);
        }
        let style = Text::new(12.5).bold().anchor(Anchor::End).halo();
        figure.text(at.x + at.width - 10.0, at.y + 20.0, words, style);
        if *stepped {
            let style = Text::new(12.0).anchor(Anchor::End).halo();
            figure.text(at.x + at.width - 10.0, at.y + 38.0, "broad and faint: the step alone", style);
        }
        panel.close(&mut figure);
    }
    let legend: Vec<(String, Stroke)> = (curves.iter().zip(STROKES.iter().cycle()))
        .map(|(c, (colour, dash))| (format!("N = {}", c.order), Stroke::solid(colour, 1.8).dashed(dash)))
        .collect();
    figure.legend(WIDTH - 16.0, &legend);
    (figure.finish(), csv(curves))
}

fn csv(curves: &[DispersionCurve]) -> String {
    let points = curves.first().map(|c| c.points.clone()).unwrap_or_default();
    let mut table = Table::default().column("points_per_wavelength", points);
    for c in curves {
        table = table
            .column(format!("n{}_space_cycles", c.order), c.space.as_slice())
            .column(format!("n{}_step_cycles", c.order), c.time.as_slice())
            .column(format!("n{}_both_cycles", c.order), c.both.as_slice());
    }
    table.to_csv()
}
