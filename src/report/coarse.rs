//! Coarse-grained memory against full memory: the figure of the case `attenuation-coarse`.

use super::dispersion::STROKES;
use super::svg::{Anchor, Axis, Figure, Panel, Rect, Stroke, Text};
use super::table::Table;

const WIDTH: f64 = 1080.0;
const HEIGHT: f64 = 520.0;

/// What plane waves have become after twenty wavelengths, worst of P and SV, for one order and quality factor.
#[derive(Debug, Clone)]
pub(crate) struct CoarseCurve {
    /// Polynomial order.
    pub(crate) order: usize,
    /// Quality factor.
    pub(crate) quality: f64,
    /// Points per wavelength of SV waves; P waves of the mesh have twice as many.
    pub(crate) points: Vec<f64>,
    /// Amplitude with coarse memory over that with full memory, less one, absolute.
    pub(crate) amplitude: Vec<f64>,
    /// The same of the phase velocity.
    pub(crate) velocity: Vec<f64>,
    /// Amplitude with full memory over the exact one, less one, absolute.
    pub(crate) amplitude_full: Vec<f64>,
    /// The same of the phase velocity.
    pub(crate) velocity_full: Vec<f64>,
}

/// The figure as SVG and its numbers as CSV; orders at one quality factor, and one order at several.
pub(crate) fn coarse_figure(orders: &[CoarseCurve], qualities: &[CoarseCurve]) -> (String, String) {
    let title = "Coarse against full memory after 20 wavelengths";
    let mut figure = Figure::new("attenuation-coarse", title, WIDTH, HEIGHT);
    let all = || orders.iter().chain(qualities);
    let points = || all().flat_map(|c| c.points.iter().copied());
    let (low, high) = (points().fold(f64::INFINITY, f64::min), points().fold(0.0, f64::max));
    let name = |curves: &[CoarseCurve], what: &str| match curves.first() {
        Some(c) => format!("{what}, Q = {}", c.quality),
        None => what.to_owned(),
    };
    let of_order = match qualities.first() {
        Some(c) => format!("amplitude, N = {}", c.order),
        None => String::new(),
    };
    type Pick = fn(&CoarseCurve) -> (&[f64], &[f64]);

    /// Curves, heading, what is drawn of them, and the range drawn.
    type CoarsePanel<'a> = (&'a [CoarseCurve], String, Pick, (f64, f64));
    let amplitude: Pick = |c| (&c.amplitude, &c.amplitude_full);
    let velocity: Pick = |c| (&c.velocity, &c.velocity_full);
    let panels: [CoarsePanel<'_>; 3] = [
        (orders, name(orders, "amplitude"), amplitude, (1e-4, 1.0)),
        (orders, name(orders, "phase velocity"), velocity, (1e-6, 1e-1)),
        (qualities, of_order, amplitude, (1e-4, 1.0)),
    ];
    for (i, (curves, words, pick, range)) in panels.iter().enumerate() {
        let at = Rect { x: 84.0 + 342.0 * i as f64, y: 92.0, width: 264.0, height: 368.0 };
        let x = Axis::log(low, high, "points per wavelength of SV (1)");
        let y = Axis::log(range.0, range.1, "relative error (1)");
        let panel = Panel::draw(&mut figure, at, x, y, true, true);
        for curve in *curves {
            let stroke = if i == 2 { quality_stroke(curve) } else { order_stroke(curve) };
            let (coarse, full) = pick(curve);
            let drawn = |errors: &[f64]| -> Vec<(f64, f64)> {
                curve.points.iter().copied().zip(errors.iter().map(|e| e.max(0.1 * range.0))).collect()
            };
            panel.polyline(&mut figure, &drawn(full), stroke.wide(3.5).faint(0.25).dashed(""));
            panel.polyline(&mut figure, &drawn(coarse), stroke);
        }
        figure.text(at.x + at.width, at.y - 8.0, words, Text::new(12.0).bold().anchor(Anchor::End));
        let style = Text::new(11.0).anchor(Anchor::End).halo();
        let right = at.x + at.width - 8.0;
        if i == 2 {
            figure.text(right, at.y + 18.0, "dashes Q = 25, line 50, dots 100", style);
        } else {
            figure.text(right, at.y + 18.0, "broad and faint: full memory", style);
            figure.text(right, at.y + 33.0, "against the exact wave", style);
        }
        panel.close(&mut figure);
    }
    let legend: Vec<(String, Stroke)> =
        orders.iter().map(|c| (format!("N = {}", c.order), order_stroke(c))).collect();
    figure.legend(WIDTH - 16.0, &legend);
    (figure.finish(), csv(orders, qualities))
}

fn order_stroke(curve: &CoarseCurve) -> Stroke {
    let (colour, dash) = STROKES[(curve.order - 2) % STROKES.len()];
    Stroke::solid(colour, 1.8).dashed(dash)
}

fn quality_stroke(curve: &CoarseCurve) -> Stroke {
    let dash = if curve.quality < 40.0 {
        "8 3"
    } else if curve.quality < 75.0 {
        ""
    } else {
        "2 3"
    };
    Stroke::solid(STROKES[(curve.order - 2) % STROKES.len()].0, 1.8).dashed(dash)
}

fn csv(orders: &[CoarseCurve], qualities: &[CoarseCurve]) -> String {
    let known = |c: &&CoarseCurve| !orders.iter().any(|o| (o.order, o.quality) == (c.order, c.quality));
    let curves: Vec<&CoarseCurve> = orders.iter().chain(qualities.iter().filter(known)).collect();
    let each = |of: fn(&CoarseCurve) -> f64| -> Vec<f64> {
        curves.iter().flat_map(|c| std::iter::repeat_n(of(c), c.points.len())).collect()
    };
    let all = |of: fn(&CoarseCurve) -> &[f64]| -> Vec<f64> {
        curves.iter().flat_map(|c| of(c).iter().copied()).collect()
    };
    Table::default()
        .column("order", each(|c| c.order as f64))
        .column("q", each(|c| c.quality))
        .column("points_per_sv_wavelength", all(|c| &c.points))
        .column("amplitude_coarse_over_full_less_1", all(|c| &c.amplitude))
        .column("velocity_coarse_over_full_less_1", all(|c| &c.velocity))
        .column("amplitude_full_over_exact_less_1", all(|c| &c.amplitude_full))
        .column("velocity_full_over_exact_less_1", all(|c| &c.velocity_full))
        .to_csv()
}
