//! Maps of the surface: speed at some instants, and the largest motion over the run.

use super::super::svg::{Anchor, Axis, Figure, Panel, Rect, Stroke, Text, significant};
use super::super::table::Table;
use super::super::wave::SurfaceMotion;
use super::wave::{Raster, Scale, encode, metres};
use super::{Plate, WIDTH};
use crate::outputs::OutputError;

/// Pixels along the longer side of a map.
const PIXELS: usize = 420;
/// Maps in a row.
const COLUMNS: usize = 3;
const LEFT: f64 = 72.0;
const RIGHT: f64 = 108.0;
const GAP: f64 = 36.0;
const TALLEST: f64 = 460.0;

/// Speed of the surface at six instants between the first motion and the last.
pub(in super::super) fn snapshots(surface: &SurfaceMotion) -> Result<Option<Plate>, OutputError> {
    let (Some(raster), Some(scale)) = (Raster::new(&surface.cells, PIXELS), Scale::over(&surface.speed))
    else {
        return Ok(None);
    };
    let instants = instants(surface, 6);
    let rows = instants.len().div_ceil(COLUMNS);
    let (width, height) = map_size(&raster, (WIDTH - LEFT - RIGHT - GAP * 2.0) / 3.0);
    let total = 62.0 + rows as f64 * (height + 28.0) + 16.0;
    let mut figure = Figure::new("surface-speed", "Speed of the surface, seen from above", WIDTH, total);
    for (number, &instant) in instants.iter().enumerate() {
        let (row, column) = (number / COLUMNS, number % COLUMNS);
        let x = LEFT + column as f64 * (width + GAP);
        let at = Rect { x, y: 62.0 + row as f64 * (height + 28.0), width, height };
        let below = number + COLUMNS >= instants.len();
        let words = format!("t = {} s", significant(surface.time[instant], 4));
        map(&mut figure, &raster, surface.frame(instant), scale, at, [below, column == 0], &words)?;
    }
    let bar = bar_beside(LEFT + 3.0 * width + 2.0 * GAP, 74.0, height);
    scale.bar(&mut figure, bar, "m/s")?;
    let peak = surface.speed.iter().fold(0.0_f32, |m, v| m.max(*v));
    let caption = format!(
        "Length of the velocity vector. Colours follow its square root, so that weak waves show beside strong ones, \
         and end at {} m/s; the largest value is {} m/s.",
        significant(scale.limit, 3),
        significant(f64::from(peak), 3)
    );
    let mut table = places(surface);
    for &instant in &instants {
        let values: Vec<f64> = surface.frame(instant).iter().map(|v| f64::from(*v)).collect();
        table = table.column(format!("speed_m_s_at_{:.4}_s", surface.time[instant]), values);
    }
    Ok(Some(Plate { csv: table.to_csv(), figure, caption }))
}

/// PGA, PGV and PGD of the surface.
pub(in super::super) fn peak_maps(surface: &SurfaceMotion) -> Result<Option<Plate>, OutputError> {
    let Some(raster) = Raster::new(&surface.cells, PIXELS) else { return Ok(None) };
    let kinds = [
        (2, "PGA", "m/s²", "pga_m_s2", "acceleration"),
        (1, "PGV", "m/s", "pgv_m_s", "velocity"),
        (0, "PGD", "m", "pgd_m", "displacement"),
    ];
    let scales = kinds.map(|(motion, ..)| Scale::over(&surface.peaks[motion]));
    if scales.iter().all(Option::is_none) {
        return Ok(None);
    }
    let (width, height) = map_size(&raster, (WIDTH - LEFT - 12.0) / 3.0 - 92.0);
    let title = "Largest acceleration, velocity and displacement over the run";
    let mut figure = Figure::new("surface-peaks", title, WIDTH, 62.0 + height + 46.0);
    let mut table = places(surface);
    for (column, ((motion, word, unit, name, _), scale)) in kinds.into_iter().zip(scales).enumerate() {
        let Some(scale) = scale else { continue };
        let values = &surface.peaks[motion];
        let at = Rect { x: LEFT + column as f64 * (width + 92.0), y: 62.0, width, height };
        let peak = values.iter().fold(0.0_f32, |m, v| m.max(*v));
        let words = format!("{word}, up to {} {unit}", significant(f64::from(peak), 3));
        map(&mut figure, &raster, values, scale, at, [true, column == 0], &words)?;
        let bar = Rect { width: 11.0, ..bar_beside(at.x + width - 6.0, 74.0, height) };
        scale.bar(&mut figure, bar, unit)?;
        table = table.column(name, values.iter().map(|v| f64::from(*v)).collect::<Vec<_>>());
    }
    let caption = "Largest length of the vector at every point, of all steps of the run. Colours follow the square root."
        .to_owned();
    Ok(Some(Plate { csv: table.to_csv(), figure, caption }))
}

/// Speed along the surface of a section over time: a wave leaves a stripe, the steeper the slower it is.
pub(in super::super) fn distance_time(surface: &SurfaceMotion) -> Result<Option<Plate>, OutputError> {
    let points = &surface.cells.points;
    let mut order: Vec<usize> = (0..points.len()).collect();
    order.sort_by(|&a, &b| points[a][0].total_cmp(&points[b][0]));
    let x = (points[order[0]][0], points[order[order.len() - 1]][0]);
    let Some(scale) = Scale::over(&surface.speed).filter(|_| surface.time.len() > 1 && x.1 > x.0) else {
        return Ok(None);
    };
    let (columns, rows) = (900, surface.time.len().min(900));
    let mut values = vec![0.0_f32; columns * rows];
    for row in 0..rows {
        let frame = surface.frame(row * (surface.time.len() - 1) / (rows - 1).max(1));
        let mut after = 1;
        for column in 0..columns {
            let at = x.0 + (x.1 - x.0) * (column as f64 + 0.5) / columns as f64;
            while after + 1 < order.len() && points[order[after]][0] < at {
                after += 1;
            }
            let (a, b) = (order[after - 1], order[after]);
            let part =
                ((at - points[a][0]) / (points[b][0] - points[a][0]).max(1e-300)).clamp(0.0, 1.0) as f32;
            values[row * columns + column] = frame[a] * (1.0 - part) + frame[b] * part;
        }
    }
    let indices: Vec<u8> = values.iter().map(|v| scale.index(f64::from(*v))).collect();
    let mut figure = Figure::new("surface-speed", "Speed along the surface over time", WIDTH, 560.0);
    let at = Rect { x: LEFT, y: 62.0, width: WIDTH - LEFT - RIGHT, height: 440.0 };
    let (first, last) = (surface.time[0], surface.time[surface.time.len() - 1]);
    let time = Axis::linear(first, last, "elapsed time (s)", 8).reversed();
    let panel = Panel::draw(&mut figure, at, metres(x, 'x', 10), time, true, true);
    let image = encode(&figure.name, columns, rows, &indices)?;
    figure.image(at.x, at.y, at.width, at.height, &image);
    panel.close(&mut figure);
    scale.bar(&mut figure, bar_beside(at.x + at.width, 74.0, at.height), "m/s")?;
    let caption =
        "Length of the velocity vector; time runs downwards. A wave leaves a stripe, the steeper the slower \
                   it runs. Colours follow the square root."
            .to_owned();
    let times: Vec<usize> = (0..surface.time.len()).step_by(surface.time.len().div_ceil(200)).collect();
    let mut table = Table::default().column("x_m", order.iter().map(|&p| points[p][0]).collect::<Vec<_>>());
    for instant in times {
        let frame = surface.frame(instant);
        let values: Vec<f64> = order.iter().map(|&p| f64::from(frame[p])).collect();
        table = table.column(format!("speed_m_s_at_{:.4}_s", surface.time[instant]), values);
    }
    Ok(Some(Plate { csv: table.to_csv(), figure, caption }))
}

fn places(surface: &SurfaceMotion) -> Table<'static> {
    let along = |axis: usize| surface.cells.points.iter().map(|p| p[axis]).collect::<Vec<_>>();
    Table::default().column("x_m", along(0)).column("y_m", along(1)).column("z_m", along(2))
}

/// Size of a map no wider than `widest`, the same scale along both sides.
fn map_size(raster: &Raster, widest: f64) -> (f64, f64) {
    let width = widest.min(TALLEST / raster.aspect());
    (width, width * raster.aspect())
}

fn bar_beside(x: f64, y: f64, height: f64) -> Rect {
    Rect { x: x + 16.0, y, width: 14.0, height: (height - 14.0).max(90.0) }
}

/// Draws one map; `texts` says whether x and y carry numbers.
pub(super) fn map(
    figure: &mut Figure,
    raster: &Raster,
    values: &[f32],
    scale: Scale,
    at: Rect,
    texts: [bool; 2],
    words: &str,
) -> Result<(), OutputError> {
    let ticks = |size: f64| ((size / 75.0) as usize).clamp(2, 6);
    let (x, y) = (metres(raster.x, 'x', ticks(at.width)), metres(raster.y, 'y', ticks(at.height)));
    let panel = Panel::draw(figure, at, x, y, texts[0], texts[1]);
    let image = encode(&figure.name, raster.width, raster.height, &raster.paint(values, scale))?;
    figure.image(at.x, at.y, at.width, at.height, &image);
    panel.close(figure);
    figure.text(at.x, at.y - 6.0, words, Text::new(12.0).anchor(Anchor::Start));
    let corner = (at.x + at.width, at.y + at.height);
    figure.segment((at.x, corner.1), corner, Stroke::solid("#9aa5b1", 1.0));
    Ok(())
}

/// Instants evenly between the first motion and the end of the strong one.
pub(super) fn instants(surface: &SurfaceMotion, count: usize) -> Vec<usize> {
    let all = surface.time.len();
    // of the whole picture: the largest value stays at a point source while the waves run on
    let strength: Vec<f64> = (0..all)
        .map(|i| surface.frame(i).iter().map(|v| f64::from(*v).powi(2)).sum::<f64>().sqrt())
        .collect();
    let peak = strength.iter().fold(0.0_f64, |m, v| m.max(*v));
    let first = strength.iter().position(|v| *v >= 0.02 * peak).unwrap_or(0);
    let last = strength.iter().rposition(|v| *v >= 0.05 * peak).unwrap_or(all.saturating_sub(1));
    let count = count.min(last + 1 - first.min(last));
    // The very first motion is a dot: begin a little later, end a little earlier.
    let place = |k: usize| first as f64 + (last - first) as f64 * (k as f64 + 0.7) / (count as f64 + 0.2);
    let mut instants: Vec<usize> = (0..count).map(|k| (place(k).round() as usize).min(last)).collect();
    instants.dedup();
    instants
}
