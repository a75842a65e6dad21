//! Response spectra and their ratio.

use super::super::measure::DAMPING;
use super::super::place::{AUXILIARY, SURFACE, legend};
use super::super::svg::{Anchor, Axis, Figure, Panel, Rect, Stroke, Text, significant};
use super::super::table::Table;
use super::{GRAVITY, Plate, View, WIDTH, peak_at};

const AT: Rect = Rect { x: 78.0, y: 60.0, width: WIDTH - 78.0 - 78.0, height: 330.0 };
const HEIGHT: f64 = 444.0;

/// Pseudo-acceleration response spectra of all places.
pub(in super::super) fn response_spectra(view: &View<'_>) -> Option<Plate> {
    let curves: Vec<_> =
        view.traces.drawn.iter().filter(|d| !view.traces.measures[d.index].psa.is_empty()).collect();
    let top = curves.iter().map(|d| super::peak(&view.traces.measures[d.index].psa)).fold(0.0, f64::max);
    if curves.is_empty() || top <= 0.0 {
        return None;
    }
    let percent = significant(DAMPING * 100.0, 2);
    let title = format!("Response spectra along {}, {percent} % damping", view.letter());
    let mut figure = Figure::new(&view.name("response-spectra"), &title, WIDTH, HEIGHT);
    let y = Axis::from_zero(top, "pseudo-acceleration PSA (m/s²)", 7);
    let right = Axis::linear(y.min / GRAVITY, y.max / GRAVITY, "PSA (g)", 7);
    let x = Axis::log(0.01, 10.0, "period (s)");
    let panel = Panel::draw(&mut figure, AT, x, y, true, true);
    panel.right_scale(&mut figure, &right);
    mark_site_period(&mut figure, &panel, view);
    let mut table = Table::default().column("period_s", view.traces.periods);
    for d in &curves {
        let psa = &view.traces.measures[d.index].psa;
        let points = view.traces.periods.iter().copied().zip(psa.iter().copied());
        panel.polyline(&mut figure, &points.collect::<Vec<_>>(), d.stroke);
        table = table.column(format!("{}_psa_m_s2", d.trace.place), psa.as_slice());
    }
    figure.legend(AT.x + AT.width, &legend(&view.traces.drawn));
    panel.close(&mut figure);
    Some(Plate {
        figure,
        csv: table.to_csv(),
        caption: "PSA = (2π/T)² · largest relative displacement of an oscillator of period T. At the \
                  left edge each curve tends to the peak acceleration of its motion."
            .to_owned(),
    })
}

/// Ratio of the response spectra, surface over outcrop.
pub(in super::super) fn ratio(view: &View<'_>) -> Option<Plate> {
    let psa = |place: &str| {
        view.traces
            .drawn
            .iter()
            .find(|d| d.trace.place == place)
            .map(|d| &view.traces.measures[d.index].psa)
            .filter(|psa| !psa.is_empty())
    };
    let (surface, outcrop) = (psa("surface")?, psa("outcrop")?);
    let ratio: Vec<f64> = surface.iter().zip(outcrop).map(|(s, o)| s / o).collect();
    let (index, top) = peak_at(&ratio)?;
    let title = format!("Amplification of the response spectrum along {}", view.letter());
    let mut figure = Figure::new(&view.name("spectral-ratio"), &title, WIDTH, 348.0);
    let at = Rect { height: 234.0, ..AT };
    let x = Axis::log(0.01, 10.0, "period (s)");
    let y = Axis::from_zero(top.max(1.5), "PSA surface / PSA outcrop (1)", 5);
    let panel = Panel::draw(&mut figure, at, x, y, true, true);
    panel.horizontal(&mut figure, 1.0, AUXILIARY);
    mark_site_period(&mut figure, &panel, view);
    let points: Vec<_> = view.traces.periods.iter().copied().zip(ratio.iter().copied()).collect();
    panel.polyline(&mut figure, &points, SURFACE);
    let period = view.traces.periods[index];
    let (px, py) = (panel.px(period), panel.py(top));
    figure.dot(px, py, 4.0, SURFACE.colour);
    let label = format!("{} at {} s", significant(top, 3), significant(period, 3));
    let (anchor, shift) =
        if px > at.x + at.width * 0.75 { (Anchor::End, -9.0) } else { (Anchor::Start, 9.0) };
    figure.text(px + shift, py + 4.0, &label, Text::new(12.0).anchor(anchor).halo());
    panel.close(&mut figure);
    let table =
        Table::default().column("period_s", view.traces.periods).column("psa_ratio_surface_outcrop", ratio);
    Some(Plate {
        figure,
        csv: table.to_csv(),
        caption: "Above 1 the ground shakes an oscillator of that period harder than the outcrop does."
            .to_owned(),
    })
}

/// Marks four times the travel time of the waves from the half-space to the surface.
fn mark_site_period(figure: &mut Figure, panel: &Panel, view: &View<'_>) {
    let Some(travel) = view.travel_time() else {
        return;
    };
    let period = 4.0 * travel;
    if !(panel.x.low()..=panel.x.high()).contains(&period) {
        return;
    }
    panel.vertical(figure, period, Stroke::solid("#7b8794", 1.0).dashed("3 3"));
    let label = format!("4 Σh/v = {} s", significant(period, 3));
    let style = Text::new(11.5).colour("#52606d").anchor(Anchor::Start).halo();
    figure.text(panel.px(period) + 5.0, panel.at.y + panel.at.height - 9.0, &label, style);
}
