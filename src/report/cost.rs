//! Error against cost of Lamb's problem: the figure of the case `lamb-chart`.

use super::dispersion::STROKES;
use super::svg::{Anchor, Axis, Figure, Panel, Rect, Stroke, Text};

const WIDTH: f64 = 1080.0;
const HEIGHT: f64 = 520.0;
/// Least and largest error drawn, parts of the peak.
const ERRORS: (f64, f64) = (3e-4, 1.0);

/// Runs of one order.
#[derive(Debug, Clone)]
pub(crate) struct CostCurve {
    /// Polynomial order.
    pub(crate) order: usize,
    /// Cost and error of the best runs, worst of all receivers, in f32 and in f64.
    pub(crate) near: [Vec<(f64, f64)>; 2],
    /// The same at the farthest receiver alone.
    pub(crate) far: [Vec<(f64, f64)>; 2],
    /// Step over its limit, and error, on the finest mesh.
    pub(crate) steps: Vec<(f64, f64)>,
}

/// Draws errors over cost, at all receivers and at the farthest, beside errors over the step.
pub(crate) fn cost_figure(curves: &[CostCurve]) -> String {
    let mut figure = Figure::new("lamb-chart", "Lamb's problem: error against cost", WIDTH, HEIGHT);
    let costs = || curves.iter().flat_map(|c| c.near.iter().chain(&c.far).flatten()).map(|p| p.0);
    let (low, high) = (costs().fold(f64::INFINITY, f64::min), costs().fold(0.0, f64::max));
    let halves = ["worst of 10, 20 and 40 m", "at 40 m alone", "finest meshes, 10 to 40 m"];
    for (i, words) in halves.into_iter().enumerate() {
        let at = Rect { x: 84.0 + 336.0 * i as f64, y: 84.0, width: 300.0, height: 376.0 };
        let x = match i {
            2 => Axis::linear(0.2, 1.0, "step over critical step (1)", 5),
            _ => Axis::log(low, high, "processor time over simulated time (1)"),
        };
        let y = Axis::log(ERRORS.0, ERRORS.1, "largest difference over peak (1)");
        let panel = Panel::draw(&mut figure, at, x, y, true, i == 0);
        for (c, (colour, dash)) in curves.iter().zip(STROKES.iter().cycle()) {
            let stroke = Stroke::solid(colour, 1.8).dashed(dash);
            if i == 2 {
                panel.polyline(&mut figure, &c.steps, stroke);
                continue;
            }
            let [single, double] = if i == 0 { &c.near } else { &c.far };
            panel.polyline(&mut figure, double, stroke.wide(3.5).faint(0.25).dashed(""));
            panel.polyline(&mut figure, single, stroke);
        }
        let style = Text::new(12.5).bold().anchor(Anchor::End).halo();
        figure.text(at.x + at.width - 10.0, at.y + 20.0, words, style);
        let thin = if i < 2 { "best step; broad and faint: f64" } else { "f32" };
        let style = Text::new(12.0).anchor(Anchor::End).halo();
        figure.text(at.x + at.width - 10.0, at.y + 38.0, thin, style);
        panel.close(&mut figure);
    }
    let legend: Vec<(String, Stroke)> = (curves.iter().zip(STROKES.iter().cycle()))
        .map(|(c, (colour, dash))| (format!("N = {}", c.order), Stroke::solid(colour, 1.8).dashed(dash)))
        .collect();
    figure.legend(WIDTH - 16.0, &legend);
    figure.finish()
}
