//! The soil column to scale beside the peak values with depth.

use super::super::place::COLUMN;
use super::super::svg::{Anchor, Axis, Figure, Panel, Rect, Stroke, Text, significant};
use super::super::table::Table;
use super::{GRAVITY, Plate, View, WIDTH, extent, peak};
use crate::results::{LayerView, PeakProfile};

const TOP: f64 = 64.0;
const BOTTOM: f64 = 56.0;
const HEIGHT: f64 = 560.0;
const LEFT: f64 = 66.0;
const COLUMN_WIDTH: f64 = 264.0;
const GAP: f64 = 30.0;
/// Fills of the layers in turn, light enough to write on.
const FILLS: [&str; 2] = ["#f6f1e7", "#ebe3d3"];

/// The soil profile and the peaks with depth.
pub(in super::super) fn profile(view: &View<'_>) -> Option<Plate> {
    let peaks = view.data.peaks.iter().find(|p| p.axis == view.axis);
    let layers = &view.data.layers;
    let deepest = deepest(layers, peaks)?;
    let title = format!("Soil profile and peak values along {}", view.letter());
    let mut figure = Figure::new(&view.name("profile"), &title, WIDTH, HEIGHT);
    let depth = Axis::linear(0.0, deepest * 1.1, "depth (m)", 10).reversed();
    draw_column(&mut figure, view, layers, &depth);
    if let Some(peaks) = peaks {
        draw_peaks(&mut figure, view, peaks, layers, &depth);
    }
    Some(Plate {
        figure,
        csv: table(view, layers, peaks),
        caption: "Largest absolute values over the whole run; not all depths peak at one time. \
                  The speed is that at the reference frequency. Dots carry the colours of the places."
            .to_owned(),
    })
}

fn deepest(layers: &[LayerView], peaks: Option<&PeakProfile>) -> Option<f64> {
    let bounds = layers.iter().flat_map(|l| [l.top, l.bottom]);
    let points = peaks.into_iter().flat_map(|p| p.depth.iter().copied());
    extent(bounds.chain(points)).map(|(_, deep)| if deep > 0.0 { deep } else { 10.0 })
}

fn draw_column(figure: &mut Figure, view: &View<'_>, layers: &[LayerView], depth: &Axis) {
    let at = Rect { x: LEFT, y: TOP, width: COLUMN_WIDTH, height: HEIGHT - TOP - BOTTOM };
    let vertical = view.axis == 2;
    let speed = |layer: &LayerView| if vertical { layer.vp } else { layer.vs };
    let top = layers.iter().map(speed).filter(|v| v.is_finite()).fold(0.0, f64::max);
    let label = if vertical { "vp (m/s)" } else { "vs (m/s)" };
    let x = Axis::from_zero(top, label, 4);
    let panel = Panel::draw(figure, at, x, depth.clone(), true, true);
    let mut steps = Vec::new();
    for (number, layer) in layers.iter().enumerate() {
        let bottom = if layer.bottom.is_finite() { layer.bottom } else { depth.high() };
        let (y0, y1) = (panel.py(layer.top), panel.py(bottom));
        if !(y0.is_finite() && y1.is_finite()) {
            continue;
        }
        let fill = if layer.bottom.is_finite() { FILLS[number % 2] } else { "#d8d5cf" };
        figure.rectangle(at.x, y0, at.width, y1 - y0, fill);
        steps.push((speed(layer), layer.top));
        steps.push((speed(layer), bottom));
    }
    for (value, _) in &panel.x.ticks {
        panel.vertical(figure, *value, Stroke::solid("#ffffff", 1.0));
    }
    panel.polyline(figure, &steps, COLUMN.wide(2.2));
    name_layers(figure, &panel, layers, vertical);
    panel.close(figure);
    let heading = Text::new(12.5).bold().anchor(Anchor::Middle);
    figure.text(at.x + at.width / 2.0, TOP - 10.0, "soil column", heading);
}

/// Writes name and speed of each layer where it is thick enough to carry them.
fn name_layers(figure: &mut Figure, panel: &Panel, layers: &[LayerView], vertical: bool) {
    for layer in layers {
        let bottom = if layer.bottom.is_finite() { layer.bottom } else { panel.y.high() };
        let (y0, y1) = (panel.py(layer.top), panel.py(bottom));
        let thick = y1 - y0;
        if !(thick.is_finite() && thick >= 13.0) {
            continue;
        }
        let speed = if vertical { layer.vp } else { layer.vs };
        let right = panel.px(speed) > panel.at.x + 0.55 * panel.at.width;
        let (x, anchor) = if right {
            (panel.at.x + 9.0, Anchor::Start)
        } else {
            (panel.at.x + panel.at.width - 9.0, Anchor::End)
        };
        let style = Text::new(12.0).anchor(anchor);
        let speed = format!("{} m/s, D = {} %", significant(speed, 4), significant(layer.damping * 100.0, 3));
        if thick >= 36.0 {
            let y = (y0 + y1) / 2.0;
            figure.text(x, y - 3.0, &layer.name, style.bold());
            figure.text(x, y + 13.0, &speed, style);
        } else {
            let y = (y0 + y1) / 2.0 + 4.0;
            figure.text(x, y, &layer.name, style.bold());
        }
    }
}

fn draw_peaks(figure: &mut Figure, view: &View<'_>, peaks: &PeakProfile, layers: &[LayerView], depth: &Axis) {
    let shear = if view.axis == 2 { "" } else { "shear " };
    let (stress_scale, stress_unit) = stress_unit(peak(&peaks.stress));
    let panels: [(&str, String, &[f64], f64); 4] = [
        ("acceleration", "m/s²".to_owned(), &peaks.acceleration, 1.0),
        ("velocity", "m/s".to_owned(), &peaks.velocity, 1.0),
        ("strain", "%".to_owned(), &peaks.strain, 100.0),
        ("stress", stress_unit.to_owned(), &peaks.stress, stress_scale),
    ];
    let start = LEFT + COLUMN_WIDTH + GAP + 8.0;
    let width = (WIDTH - start - 22.0 - 3.0 * GAP) / 4.0;
    for (number, (name, unit, values, scale)) in panels.into_iter().enumerate() {
        let at =
            Rect { x: start + number as f64 * (width + GAP), y: TOP, width, height: HEIGHT - TOP - BOTTOM };
        let word = if number > 1 { shear } else { "" };
        let x = Axis::from_zero(peak(values) * scale, &format!("{word}{name} ({unit})"), 3);
        let panel = Panel::draw(figure, at, x, depth.clone(), true, false);
        for layer in layers.iter().skip(1) {
            panel.horizontal(figure, layer.top, Stroke::solid("#b8a98a", 1.0));
        }
        let points: Vec<(f64, f64)> = values.iter().zip(&peaks.depth).map(|(v, d)| (v * scale, *d)).collect();
        panel.polyline(figure, &points, COLUMN);
        if number < 2 {
            mark_places(figure, &panel, view, number == 0);
        }
        panel.close(figure);
        let heading = Text::new(12.5).bold().anchor(Anchor::Middle);
        figure.text(at.x + at.width / 2.0, TOP - 10.0, &format!("peak {word}{name}"), heading);
        label_peak(figure, &panel, &points, number == 0);
    }
}

/// Dots where a recorded place lies, in the colour that it has in all figures.
fn mark_places(figure: &mut Figure, panel: &Panel, view: &View<'_>, acceleration: bool) {
    for drawn in &view.traces.drawn {
        let Some(depth) = drawn.trace.depth else {
            continue;
        };
        let values = if acceleration { &drawn.trace.acceleration } else { &drawn.trace.velocity };
        let (x, y) = (panel.px(peak(values)), panel.py(depth));
        if x.is_finite() && y.is_finite() && panel.y.high() >= depth {
            figure.dot(x, y, 4.6, drawn.stroke.colour);
        }
    }
}

/// Writes the largest value of the profile at the panel's foot.
fn label_peak(figure: &mut Figure, panel: &Panel, points: &[(f64, f64)], also_g: bool) {
    let largest =
        points.iter().filter(|(v, d)| v.is_finite() && d.is_finite()).max_by(|a, b| a.0.total_cmp(&b.0));
    let Some((value, depth)) = largest else {
        return;
    };
    let text = if also_g {
        format!("max {} = {} g", significant(*value, 3), significant(value / GRAVITY, 3))
    } else {
        format!("max {} at {} m", significant(*value, 3), significant(*depth, 3))
    };
    let style = Text::new(11.5).anchor(Anchor::Middle).colour("#52606d").halo();
    let x = panel.at.x + panel.at.width / 2.0;
    figure.text(x, panel.at.y + panel.at.height - 9.0, &text, style);
}

fn stress_unit(top: f64) -> (f64, &'static str) {
    if top >= 2e6 {
        (1e-6, "MPa")
    } else if top >= 2e3 || top == 0.0 {
        (1e-3, "kPa")
    } else {
        (1.0, "Pa")
    }
}

fn table(view: &View<'_>, layers: &[LayerView], peaks: Option<&PeakProfile>) -> String {
    let column = |of: fn(&LayerView) -> f64| layers.iter().map(of).collect::<Vec<f64>>();
    let mut table = Table::default()
        .column("layer_top_m", column(|l| l.top))
        .column("layer_bottom_m", column(|l| l.bottom))
        .column("layer_vs_m_s", column(|l| l.vs))
        .column("layer_vp_m_s", column(|l| l.vp))
        .column("layer_density_kg_m3", column(|l| l.rho))
        .column("layer_damping", column(|l| l.damping));
    if let Some(p) = peaks {
        table = table
            .column("depth_m", p.depth.as_slice())
            .column("peak_acceleration_m_s2", p.acceleration.as_slice())
            .column("peak_velocity_m_s", p.velocity.as_slice())
            .column("peak_displacement_relative_m", p.displacement.as_slice())
            .column(
                if view.axis == 2 { "peak_axial_strain" } else { "peak_shear_strain" },
                p.strain.as_slice(),
            )
            .column("peak_stress_pa", p.stress.as_slice());
    }
    table.to_csv()
}
