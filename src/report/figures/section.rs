//! The wave in the column: acceleration over depth and time as an image.

use base64::Engine as _;

use super::super::svg::{Anchor, Axis, Figure, Panel, Rect, Stroke, Text, significant};
use super::super::table::Table;
use super::{Plate, View, WIDTH};
use crate::outputs::OutputError;
use crate::results::Section;

/// Most columns of an image: half a pixel of the figure each.
const MOST_COLUMNS: usize = 1400;
/// Share of the samples of the strongest shaking below the colour scale's end.
const COVERED: f64 = 0.98;
/// Colours from the most negative value to the most positive: blue, white, red; equal lightness on both sides.
const RAMP: [[f64; 3]; 9] = [
    [9.0, 48.0, 107.0],
    [33.0, 102.0, 172.0],
    [92.0, 160.0, 205.0],
    [172.0, 210.0, 230.0],
    [250.0, 250.0, 250.0],
    [246.0, 200.0, 170.0],
    [225.0, 134.0, 103.0],
    [186.0, 52.0, 54.0],
    [103.0, 0.0, 31.0],
];

const LEFT: f64 = 66.0;
const IMAGE_WIDTH: f64 = WIDTH - LEFT - 204.0;

/// Depth–time section, whole and enlarged about the strongest shaking at the surface.
pub(in super::super) fn section(view: &View<'_>) -> Result<Option<Plate>, OutputError> {
    let found = view.data.sections.iter().find(|s| s.axis == view.axis);
    let Some(section) = found.filter(|s| is_sound(s)) else {
        return Ok(None);
    };
    let window = strong_window(view, section);
    let depths = section.depth.len();
    let strong = window.clone().unwrap_or(0..section.time.len());
    let samples = &section.acceleration[strong.start * depths..strong.end * depths];
    let Some(limit) = colour_limit(samples) else {
        return Ok(None);
    };
    let heights: &[f64] = if window.is_some() { &[250.0, 300.0] } else { &[320.0] };
    let total = 52.0 + heights.iter().map(|h| h + 66.0).sum::<f64>() - 12.0;
    let title = format!("Acceleration along {} over depth and time", view.letter());
    let mut figure = Figure::new(&view.name("depth-time"), &title, WIDTH, total);
    let whole = 0..section.time.len();
    let mut y = 52.0;
    for (number, range) in std::iter::once(whole).chain(window.clone()).enumerate() {
        let at = Rect { x: LEFT, y, width: IMAGE_WIDTH, height: heights[number.min(heights.len() - 1)] };
        draw_image(&mut figure, view, section, range, limit, at)?;
        y += at.height + 66.0;
    }
    let bar = Rect { x: WIDTH - 84.0, y: 66.0, width: 16.0, height: heights[0] - 28.0 };
    draw_colour_bar(&mut figure, bar, limit)?;
    let peak = section.acceleration.iter().fold(0.0_f32, |m, v| m.max(v.abs()));
    let covered = section.acceleration.iter().filter(|v| f64::from(v.abs()) <= limit).count();
    let share = significant(100.0 * covered as f64 / section.acceleration.len() as f64, 4);
    Ok(Some(Plate {
        figure,
        csv: table(section),
        caption: format!(
            "Colours end at ±{} m/s², which covers {share} % of the samples; the peak is {} m/s². Dashed: \
             layer boundaries. {}",
            significant(limit, 3),
            significant(f64::from(peak), 3),
            if window.is_some() {
                "Below: the same about the strongest shaking at the surface; stripes that lean are waves on their way up and down."
            } else {
                ""
            }
        ),
    }))
}

fn is_sound(section: &Section) -> bool {
    section.depth.len() >= 2
        && section.time.len() >= 2
        && section.acceleration.len() == section.depth.len() * section.time.len()
        && section.depth.windows(2).all(|w| w[1] > w[0])
        && section.time.windows(2).all(|w| w[1] > w[0])
}

/// End of the colour scale: [`COVERED`] of the absolute values lie below it.
fn colour_limit(values: &[f32]) -> Option<f64> {
    // A hundred thousand samples fix this share well enough.
    let stride = (values.len() / 100_000).max(1);
    let mut sizes: Vec<f32> =
        values.iter().step_by(stride).map(|v| v.abs()).filter(|v| v.is_finite()).collect();
    if sizes.is_empty() {
        return None;
    }
    let place = ((sizes.len() - 1) as f64 * COVERED) as usize;
    let (_, value, _) = sizes.select_nth_unstable_by(place, f32::total_cmp);
    let limit = f64::from(*value);
    (limit > 0.0).then_some(limit)
}

/// Rows about the surface's peak, sixteen travel times long; `None` where that is most of the record.
fn strong_window(view: &View<'_>, section: &Section) -> Option<std::ops::Range<usize>> {
    let travel = view.travel_time()?;
    let (first, last) = (*section.time.first()?, *section.time.last()?);
    let length = (16.0 * travel).max(1.0);
    if length > 0.5 * (last - first) {
        return None;
    }
    let depths = section.depth.len();
    let strongest = (0..section.time.len()).max_by(|&a, &b| {
        let size = |row: usize| section.acceleration[row * depths].abs();
        size(a).total_cmp(&size(b))
    })?;
    let centre = section.time[strongest].clamp(first + length / 2.0, last - length / 2.0);
    let from = section.time.partition_point(|t| *t < centre - length / 2.0);
    let to = section.time.partition_point(|t| *t <= centre + length / 2.0);
    (to >= from + 8).then_some(from..to)
}

fn draw_image(
    figure: &mut Figure,
    view: &View<'_>,
    section: &Section,
    rows: std::ops::Range<usize>,
    limit: f64,
    at: Rect,
) -> Result<(), OutputError> {
    let depths = section.depth.len();
    let columns = rows.len().min(MOST_COLUMNS);
    let mut pixels = vec![0_u8; columns * depths * 3];
    for column in 0..columns {
        let from = rows.start + column * rows.len() / columns;
        let to = (rows.start + (column + 1) * rows.len() / columns).max(from + 1);
        for depth in 0..depths {
            // Of the samples that share a pixel the largest is shown, with its sign.
            let value = (from..to)
                .map(|row| section.acceleration[row * depths + depth])
                .max_by(|a, b| a.abs().total_cmp(&b.abs()))
                .unwrap_or(0.0);
            let place = (depth * columns + column) * 3;
            pixels[place..place + 3].copy_from_slice(&colour(f64::from(value) / limit));
        }
    }
    let (shallow, deep) = (section.depth[0], section.depth[depths - 1]);
    let x = Axis::linear(section.time[rows.start], section.time[rows.end - 1], "elapsed time (s)", 10);
    let y = Axis::linear(shallow, deep, "depth (m)", 6).reversed();
    let image = encode(figure, columns, depths, &pixels)?;
    let panel = Panel::draw(figure, at, x, y, true, true);
    figure.image(at.x, at.y, at.width, at.height, &image);
    let mut last_label = f64::NEG_INFINITY;
    for (number, layer) in view.data.layers.iter().enumerate() {
        if !(layer.top >= shallow && layer.top <= deep) {
            continue;
        }
        if number > 0 {
            panel.horizontal(figure, layer.top, Stroke::solid("#1f2933", 1.0).dashed("5 4").faint(0.75));
        }
        let bottom = layer.bottom.min(deep);
        let middle = panel.py((layer.top + bottom) / 2.0) + 4.0;
        if middle - last_label >= 13.0 {
            let name = shortened(&layer.name, 18);
            figure.text(at.x + at.width + 8.0, middle, &name, Text::new(11.5).colour("#52606d"));
            last_label = middle;
        }
    }
    panel.close(figure);
    Ok(())
}

/// A name of at most `most` letters.
fn shortened(name: &str, most: usize) -> String {
    if name.chars().count() <= most {
        return name.to_owned();
    }
    name.chars().take(most - 1).chain(std::iter::once('…')).collect()
}

fn draw_colour_bar(figure: &mut Figure, at: Rect, limit: f64) -> Result<(), OutputError> {
    let steps = 128;
    let mut pixels = Vec::with_capacity(steps * 3);
    for step in 0..steps {
        pixels.extend(colour(1.0 - 2.0 * step as f64 / (steps - 1) as f64));
    }
    let image = encode(figure, 1, steps, &pixels)?;
    figure.image(at.x, at.y, at.width, at.height, &image);
    let style = Text::new(11.5).colour("#52606d");
    let ends = [
        (0.0, format!("≥ {}", significant(limit, 2))),
        (0.5, "0".to_owned()),
        (1.0, format!("≤ {}", significant(-limit, 2))),
    ];
    for (share, text) in ends {
        figure.text(at.x + at.width + 6.0, at.y + share * at.height + 4.0, &text, style);
    }
    let style = Text::new(12.0).anchor(Anchor::Middle);
    figure.text(at.x + at.width / 2.0, at.y - 12.0, "m/s²", style);
    Ok(())
}

/// Colour of a value between −1 and 1; grey where it is not a number.
fn colour(value: f64) -> [u8; 3] {
    if !value.is_finite() {
        return [128, 128, 128];
    }
    let place = (value.clamp(-1.0, 1.0) + 1.0) / 2.0 * (RAMP.len() - 1) as f64;
    let lower = (place.floor() as usize).min(RAMP.len() - 2);
    let part = place - lower as f64;
    std::array::from_fn(|c| (RAMP[lower][c] * (1.0 - part) + RAMP[lower + 1][c] * part).round() as u8)
}

fn encode(figure: &Figure, width: usize, height: usize, rgb: &[u8]) -> Result<String, OutputError> {
    let failed = |cause| OutputError::Image { path: format!("{}.svg", figure.name).into(), cause };
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width as u32, height as u32);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::Fast);
    let mut writer = encoder.write_header().map_err(failed)?;
    writer.write_image_data(rgb).map_err(failed)?;
    writer.finish().map_err(failed)?;
    Ok(base64::engine::general_purpose::STANDARD.encode(bytes))
}

/// Every n-th sample in time and depth, so that the table stays below some hundred thousand numbers.
fn table(section: &Section) -> String {
    let depths = section.depth.len();
    let every = depths.div_ceil(25);
    let stride = section.time.len().div_ceil(3000).max(1);
    let rows: Vec<usize> = (0..section.time.len()).step_by(stride).collect();
    let times: Vec<f64> = rows.iter().map(|&r| section.time[r]).collect();
    let mut table = Table::default().column("elapsed_time_s", times);
    for depth in (0..depths).step_by(every) {
        let values: Vec<f64> =
            rows.iter().map(|&r| f64::from(section.acceleration[r * depths + depth])).collect();
        let name = format!("acceleration_m_s2_at_{:.3}_m", section.depth[depth]);
        table = table.column(name, values);
    }
    table.to_csv()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_are_centred() {
        assert_eq!(colour(0.0), [250, 250, 250]);
        assert_eq!(colour(-2.0), [9, 48, 107]);
        assert_eq!(colour(1.0), [103, 0, 31]);
        assert_eq!(colour(f64::NAN), [128, 128, 128]);
    }

    #[test]
    fn limit_ignores_a_single_spike() {
        let mut values = vec![1.0_f32; 10_000];
        values[7] = 1000.0;
        assert_eq!(colour_limit(&values), Some(1.0));
        assert_eq!(colour_limit(&[0.0; 4]), None);
        assert_eq!(colour_limit(&[]), None);
    }
}
