//! Fourier amplitude spectra, raw and smoothed.

use super::super::measure::BANDWIDTH;
use super::super::place::legend;
use super::super::svg::{Axis, Figure, Panel, Rect, significant};
use super::super::table::Table;
use super::{Plate, Traces, WIDTH, extent};

/// Fourier amplitude of the acceleration at all places.
pub(in super::super) fn fourier(traces: &Traces<'_>) -> Option<Plate> {
    let curves: Vec<_> =
        traces.drawn.iter().filter(|d| !traces.measures[d.index].smoothed.is_empty()).collect();
    let nyquist = 0.5 / traces.dt;
    let smoothed = curves.iter().flat_map(|d| traces.measures[d.index].smoothed.iter().copied());
    let (_, top) = extent(smoothed)?;
    let raw = curves.iter().flat_map(|d| traces.measures[d.index].amplitude.iter().copied());
    let (_, highest) = extent(raw)?;
    if !(top > 0.0 && nyquist.is_finite()) {
        return None;
    }
    let at = Rect { x: 84.0, y: 60.0, width: WIDTH - 84.0 - 24.0, height: 330.0 };
    let title = format!("Fourier amplitude of acceleration {}", traces.subject);
    let mut figure = Figure::new(&traces.name("fourier-amplitude"), &title, WIDTH, 444.0);
    let lowest = curves
        .iter()
        .filter_map(|d| traces.measures[d.index].centres.first().copied())
        .fold(f64::INFINITY, f64::min);
    let x = Axis::log(lowest.clamp(0.02, 0.5), nyquist, "frequency (Hz)");
    // Five decades show all that matters; below lie only tapers and round-off.
    let y = Axis::log(top * 1e-5, highest * 1.5, "Fourier amplitude (m/s)");
    let panel = Panel::draw(&mut figure, at, x, y, true, true);
    for d in &curves {
        let m = &traces.measures[d.index];
        let points = m.frequency.iter().copied().zip(m.amplitude.iter().copied());
        let points = points.filter(|(f, _)| *f > 0.0);
        panel.line(&mut figure, points, d.stroke.dashed("").wide(0.7).faint(0.28));
    }
    let mut table = Table::default();
    for d in &curves {
        let m = &traces.measures[d.index];
        let points: Vec<_> = m.centres.iter().copied().zip(m.smoothed.iter().copied()).collect();
        panel.polyline(&mut figure, &points, d.stroke.wide(d.stroke.width + 0.5));
        let place = &d.trace.place;
        table = table
            .column(format!("{place}_frequency_hz"), m.frequency.as_slice())
            .column(format!("{place}_amplitude_m_s"), m.amplitude.as_slice())
            .column(format!("{place}_centre_frequency_hz"), m.centres.as_slice())
            .column(format!("{place}_smoothed_amplitude_m_s"), m.smoothed.as_slice());
    }
    figure.legend(at.x + at.width, &legend(&traces.drawn));
    panel.close(&mut figure);
    Some(Plate {
        figure,
        csv: table.to_csv(),
        caption: format!(
            "Faint: |∫a e<sup>−iωt</sup> dt| as it is. Bold: smoothed with the Konno–Ohmachi window, b = {}.",
            significant(BANDWIDTH, 2)
        ),
    })
}
