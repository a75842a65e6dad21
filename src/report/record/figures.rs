//! Figures that only recordings have: spectra over all directions, the ratio of horizontal to vertical, CAV.

use hati_inputs::measures::{self, RotatedSpectrum};

use super::super::figures::{GRAVITY, Plate, Traces, WIDTH, extent, peak, peak_at};
use super::super::measure::{BANDWIDTH, DAMPING, TraceMeasures};
use super::super::place::{AUXILIARY, Drawn, legend, words};
use super::super::svg::{Anchor, Axis, Figure, Panel, Rect, Stroke, Text, significant};
use super::super::table::Table;
use super::{has_spectra, target};
use crate::record::Matched;

const ROTD50: Stroke = Stroke::solid("#27323d", 2.4);
const ROTD100: Stroke = Stroke::solid("#27323d", 1.5).dashed("13 4");
const RATIO: Stroke = Stroke::solid("#27323d", 1.8);
const PSA: Rect = Rect { x: 78.0, y: 60.0, width: WIDTH - 78.0 - 78.0, height: 330.0 };
const SMALL: f64 = 250.0;
const PERIOD: (f64, f64) = (0.01, 10.0);

/// PSA with RotD50 and RotD100 above, PSV and SD below.
pub(super) fn response_spectra(
    group: &Traces<'_>,
    rotated: Option<&RotatedSpectrum>,
    matched: Option<&Matched>,
) -> Option<Plate> {
    let curves: Vec<&Drawn<'_>> =
        group.drawn.iter().filter(|d| has_spectra(&group.measures[d.index])).collect();
    let of_curves = curves.iter().map(|d| peak(&group.measures[d.index].psa)).fold(0.0, f64::max);
    let targets = targets(group, matched);
    let of_targets = targets.iter().flat_map(|(_, curves)| &curves[1]).map(|(_, value)| *value);
    let top = of_targets.fold(rotated.map_or(0.0, |r| peak(&r.rotd100)).max(of_curves), f64::max);
    if curves.is_empty() || top <= 0.0 {
        return None;
    }
    let title = format!("Response spectra {}, {} % damping", group.subject, significant(DAMPING * 100.0, 2));
    let height = PSA.y + PSA.height + 64.0 + SMALL + 54.0;
    let mut figure = Figure::new(&group.name("response-spectra"), &title, WIDTH, height);
    let y = Axis::from_zero(top, "pseudo-acceleration PSA (m/s²)", 7);
    let right = Axis::linear(y.min / GRAVITY, y.max / GRAVITY, "PSA (g)", 7);
    let panel = Panel::draw(&mut figure, PSA, Axis::log(PERIOD.0, PERIOD.1, "period (s)"), y, true, true);
    panel.right_scale(&mut figure, &right);
    for (_, [low, high, _]) in &targets {
        panel.band(&mut figure, low, high, target::BAND);
    }
    for d in &curves {
        panel.polyline(&mut figure, &points(group, &group.measures[d.index].psa), d.stroke);
    }
    let mut entries = legend(&group.drawn);
    if let Some(rotated) = rotated {
        for (values, stroke, name) in
            [(&rotated.rotd50, ROTD50, "RotD50"), (&rotated.rotd100, ROTD100, "RotD100")]
        {
            panel.polyline(&mut figure, &points(group, values), stroke);
            entries.push((name.to_owned(), stroke));
        }
    }
    for (name, [_, _, line]) in &targets {
        panel.polyline(&mut figure, line, target::TARGET);
        entries.push((name.clone(), target::TARGET));
    }
    figure.legend(PSA.x + PSA.width, &entries);
    panel.close(&mut figure);
    let width = (WIDTH - 78.0 - 96.0 - 30.0) / 2.0;
    let y = PSA.y + PSA.height + 64.0;
    let left = Rect { x: 78.0, y, width, height: SMALL };
    small(&mut figure, group, &curves, left, "pseudo-velocity PSV (m/s)", |m| &m.psv);
    let right = Rect { x: 78.0 + width + 96.0, ..left };
    small(&mut figure, group, &curves, right, "relative displacement SD (m)", |m| &m.sd);
    let mut caption =
        "PSA = (2π/T)² SD, PSV = (2π/T) SD, SD the largest relative displacement of an oscillator of \
                       period T."
            .to_owned();
    if rotated.is_some() {
        caption.push_str(
            " RotD50 and RotD100: median and largest PSA over all directions of an oscillator in the horizontal \
             plane.",
        );
    }
    Some(Plate { figure, csv: spectra_table(group, &curves, rotated), caption })
}

/// The targets of a match that hold for the damping of this figure, one for x and y together and one for z, each with
/// its name in the legend.
fn targets(group: &Traces<'_>, matched: Option<&Matched>) -> Vec<(String, target::Band)> {
    let Some(matched) = matched.filter(|m| (m.matching.spectrum.damping() - DAMPING).abs() < 1e-9) else {
        return vec![];
    };
    let has = |axes: &[usize]| group.drawn.iter().any(|d| axes.contains(&d.trace.axis));
    let level = has(&[0, 1]).then_some((0, "target"));
    let upright = has(&[2]).then_some((2, "target of z"));
    let same = matched.matching.spectrum.for_axis(0) == matched.matching.spectrum.for_axis(2);
    let wanted = level.into_iter().chain(upright.filter(|_| level.is_none() || !same));
    wanted.map(|(axis, name)| (name.to_owned(), target::band(matched, axis, group.periods))).collect()
}

fn points(group: &Traces<'_>, values: &[f64]) -> Vec<(f64, f64)> {
    group.periods.iter().copied().zip(values.iter().copied()).collect()
}

fn small(
    figure: &mut Figure,
    group: &Traces<'_>,
    curves: &[&Drawn<'_>],
    at: Rect,
    label: &str,
    of: impl Fn(&TraceMeasures) -> &Vec<f64>,
) {
    let top = curves.iter().map(|d| peak(of(&group.measures[d.index]))).fold(0.0, f64::max);
    let x = Axis::log(PERIOD.0, PERIOD.1, "period (s)");
    let panel = Panel::draw(figure, at, x, Axis::from_zero(top, label, 5), true, true);
    for d in curves {
        panel.polyline(figure, &points(group, of(&group.measures[d.index])), d.stroke);
    }
    panel.close(figure);
}

fn spectra_table(group: &Traces<'_>, curves: &[&Drawn<'_>], rotated: Option<&RotatedSpectrum>) -> String {
    let mut table = Table::default().column("period_s", group.periods);
    for d in curves {
        let (m, place) = (&group.measures[d.index], &d.trace.place);
        table = table
            .column(format!("{place}_psa_m_s2"), m.psa.as_slice())
            .column(format!("{place}_psv_m_s"), m.psv.as_slice())
            .column(format!("{place}_sd_m"), m.sd.as_slice());
    }
    if let Some(rotated) = rotated {
        table = table
            .column("rotd50_psa_m_s2", rotated.rotd50.as_slice())
            .column("rotd100_psa_m_s2", rotated.rotd100.as_slice())
            .column("rotd100_angle_deg", rotated.rotd100_angle.as_slice());
    }
    table.to_csv()
}

/// Ratio of the smoothed Fourier amplitudes, horizontal over vertical.
pub(super) fn horizontal_to_vertical(group: &Traces<'_>, centres: &[f64], ratio: &[f64]) -> Option<Plate> {
    let (low, high) = extent(ratio.iter().copied().filter(|r| *r > 0.0))?;
    let title = format!("Horizontal to vertical amplitudes {}", group.subject);
    let mut figure = Figure::new(&group.name("horizontal-to-vertical"), &title, WIDTH, 374.0);
    let at = Rect { x: 84.0, y: 60.0, width: WIDTH - 84.0 - 24.0, height: 260.0 };
    let first = centres.first().copied().unwrap_or(0.1).clamp(0.02, 0.5);
    let x = Axis::log(first, 0.5 / group.dt, "frequency (Hz)");
    let y = Axis::log(low.max(high * 1e-4).min(0.5) * 0.8, high.max(2.0) * 1.4, "H/V (1)");
    let panel = Panel::draw(&mut figure, at, x, y, true, true);
    panel.horizontal(&mut figure, 1.0, AUXILIARY);
    let curve: Vec<(f64, f64)> = centres.iter().copied().zip(ratio.iter().copied()).collect();
    panel.polyline(&mut figure, &curve, RATIO);
    let inside: Vec<f64> = curve.iter().map(|(f, r)| if *f >= first { *r } else { f64::NAN }).collect();
    if let Some((index, top)) = peak_at(&inside) {
        let (px, py) = (panel.px(centres[index]), panel.py(top));
        figure.dot(px, py, 4.0, RATIO.colour);
        let label = format!("{} at {} Hz", significant(top, 3), significant(centres[index], 3));
        let (anchor, shift) =
            if px > at.x + at.width * 0.75 { (Anchor::End, -9.0) } else { (Anchor::Start, 9.0) };
        figure.text(px + shift, py - 6.0, &label, Text::new(12.0).anchor(anchor).halo());
    }
    panel.close(&mut figure);
    let table = Table::default().column("frequency_hz", centres).column("horizontal_to_vertical_1", ratio);
    Some(Plate {
        figure,
        csv: table.to_csv(),
        caption: format!(
            "Geometric mean of the horizontal amplitudes over the vertical one, whole record, each smoothed with the \
             Konno–Ohmachi window, b = {}. Of an earthquake it is a hint at the site, not its transfer function.",
            significant(BANDWIDTH, 2)
        ),
    })
}

/// Build-up of the cumulative absolute velocity.
pub(super) fn cumulative_absolute_velocity(group: &Traces<'_>) -> Option<Plate> {
    let curves: Vec<Vec<f64>> = group
        .drawn
        .iter()
        .map(|d| measures::cumulative_absolute_velocity(&d.trace.acceleration, group.dt))
        .collect();
    let top = curves.iter().filter_map(|c| c.last().copied()).fold(0.0, f64::max);
    if top <= 0.0 {
        return None;
    }
    let title = format!("Cumulative absolute velocity {}", group.subject);
    let mut figure = Figure::new(&group.name("cumulative-absolute-velocity"), &title, WIDTH, 334.0);
    let at = Rect { x: 78.0, y: 60.0, width: WIDTH - 78.0 - 24.0, height: 220.0 };
    let (first, last) = group.time_range();
    let x = Axis::linear(first, last, "elapsed time (s)", 12);
    let panel = Panel::draw(&mut figure, at, x, Axis::from_zero(top, "CAV (m/s)", 5), true, true);
    let mut table = Table::default().column("elapsed_time_s", group.times());
    for (number, (d, curve)) in group.drawn.iter().zip(&curves).enumerate() {
        let points = curve.iter().enumerate().map(|(i, v)| (group.time(i), *v));
        panel.line(&mut figure, points, d.stroke);
        let end = curve.last().copied().unwrap_or(0.0);
        let label = format!("{}: CAV {} m/s", words(&d.trace.place), significant(end, 3));
        let style = Text::new(12.0).colour(d.stroke.colour).halo();
        figure.text(at.x + 10.0, at.y + 18.0 + 18.0 * number as f64, &label, style);
        table = table.column(format!("{}_cav_m_s", d.trace.place), curve.as_slice());
    }
    figure.legend(at.x + at.width, &legend(&group.drawn));
    panel.close(&mut figure);
    Some(Plate { figure, csv: table.to_csv(), caption: "CAV = ∫|a| dt up to each time.".to_owned() })
}

#[cfg(test)]
mod tests {
    use super::super::super::place::COMPONENTS;
    use super::*;

    /// What one figure may hold side by side differs without its colours, by dash or clearly by width.
    #[test]
    fn curves_differ_in_grey() {
        let [x, y, z] = COMPONENTS;
        let curves = [x, y, z, ROTD50, ROTD100, target::TARGET];
        for (number, a) in curves.iter().enumerate() {
            for b in &curves[number + 1..] {
                assert!(a.dash != b.dash || (a.width - b.width).abs() >= 0.6, "{a:?} and {b:?}");
            }
        }
    }
}
