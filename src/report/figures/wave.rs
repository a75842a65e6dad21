//! What the figures of a surface share: its picture from above, and colours for sizes.

use base64::Engine as _;

use super::super::svg::{Anchor, Axis, Figure, Rect, Text, significant};
use crate::outputs::OutputError;
use crate::outputs::wave::Cells;

/// Colours of a scale.
pub(super) const COLOURS: usize = 128;
/// Index of the colour that means "outside the ground".
pub(super) const OUTSIDE: u8 = 255;

/// A surface seen from above as pixels: for each the three points about it and their weights.
#[derive(Debug)]
pub(super) struct Raster {
    pub(super) width: usize,
    pub(super) height: usize,
    /// Smallest and largest x, m.
    pub(super) x: (f64, f64),
    /// Smallest and largest y, m.
    pub(super) y: (f64, f64),
    pixels: Vec<Option<([u32; 3], [f32; 3])>>,
}

impl Raster {
    /// A picture of at most `most` pixels along the longer side, the same scale along both.
    ///
    /// `None` where the surface has no extent seen from above.
    pub(super) fn new(cells: &Cells, most: usize) -> Option<Self> {
        let range = |axis: usize| super::extent(cells.points.iter().map(|p| p[axis]));
        let (x, y) = (range(0)?, range(1)?);
        let (wide, high) = (x.1 - x.0, y.1 - y.0);
        let longer = wide.max(high);
        if wide.min(high) <= 1e-6 * longer {
            return None;
        }
        let along = |extent: f64| ((extent / longer * most as f64).round() as usize).max(2);
        let (width, height) = (along(wide), along(high));
        let mut raster = Self { width, height, x, y, pixels: vec![None; width * height] };
        for cell in cells.corners.chunks_exact(4) {
            // Two triangles: exact for plane cells, and enough for a picture of others.
            for triangle in [[cell[0], cell[1], cell[2]], [cell[0], cell[2], cell[3]]] {
                raster.fill(cells, triangle);
            }
        }
        Some(raster)
    }

    /// Height over width.
    pub(super) fn aspect(&self) -> f64 {
        (self.y.1 - self.y.0) / (self.x.1 - self.x.0)
    }

    fn fill(&mut self, cells: &Cells, triangle: [u32; 3]) {
        let step = [(self.x.1 - self.x.0) / self.width as f64, (self.y.1 - self.y.0) / self.height as f64];
        // In pixels, the first row at the largest y.
        let at = triangle.map(|p| {
            let [x, y, _] = cells.points[p as usize];
            [(x - self.x.0) / step[0] - 0.5, (self.y.1 - y) / step[1] - 0.5]
        });
        let [a, b, c] = at;
        let area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        if area == 0.0 {
            return;
        }
        let span = |axis: usize, count: usize| {
            let values = at.map(|p| p[axis]);
            let low = values.iter().fold(f64::INFINITY, |m, v| m.min(*v)).floor().max(0.0) as usize;
            let high = values.iter().fold(f64::NEG_INFINITY, |m, v| m.max(*v)).ceil().max(0.0) as usize;
            low..=high.min(count - 1)
        };
        for row in span(1, self.height) {
            for column in span(0, self.width) {
                let p = [column as f64, row as f64];
                let v = ((p[0] - a[0]) * (c[1] - a[1]) - (p[1] - a[1]) * (c[0] - a[0])) / area;
                let w = ((b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0])) / area;
                let u = 1.0 - v - w;
                // A pixel on an edge belongs to either side.
                if u.min(v).min(w) >= -1e-6 {
                    self.pixels[row * self.width + column] = Some((triangle, [u as f32, v as f32, w as f32]));
                }
            }
        }
    }

    /// Values at the points as indices of colours; row by row from the largest y.
    pub(super) fn paint(&self, values: &[f32], scale: Scale) -> Vec<u8> {
        let of = |pixel: &Option<([u32; 3], [f32; 3])>| match pixel {
            Some((points, weights)) => {
                let value: f32 = points.iter().zip(weights).map(|(&p, w)| values[p as usize] * w).sum();
                scale.index(f64::from(value))
            }
            None => OUTSIDE,
        };
        self.pixels.iter().map(of).collect()
    }
}

/// From sizes to colours: along the square root, so that weak motion can be seen beside strong one.
#[derive(Debug, Clone, Copy)]
pub(super) struct Scale {
    /// Its end.
    pub(super) limit: f64,
}

impl Scale {
    /// A scale that ends at a round number just above all but the largest thousandth of the values.
    pub(super) fn over(values: &[f32]) -> Option<Self> {
        let stride = (values.len() / 1_000_000).max(1);
        let mut sizes: Vec<f32> = values.iter().step_by(stride).copied().filter(|v| v.is_finite()).collect();
        let place = (sizes.len().checked_sub(1)? as f64 * 0.999) as usize;
        let (_, high, _) = sizes.select_nth_unstable_by(place, f32::total_cmp);
        let mut high = f64::from(*high);
        if high <= 0.0 {
            // Nearly nothing moves: then the largest of it.
            high = values.iter().filter(|v| v.is_finite()).fold(0.0_f64, |m, v| m.max(f64::from(*v)));
        }
        if high <= 0.0 {
            return None;
        }
        let power = 10_f64.powf(high.log10().floor());
        let steps = [1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0];
        let step = steps.into_iter().find(|step| step * power >= high * (1.0 - 1e-9)).unwrap_or(10.0);
        Some(Self { limit: step * power })
    }

    /// Place of a value between 0 and 1.
    fn place(self, value: f64) -> f64 {
        (value / self.limit).clamp(0.0, 1.0).sqrt()
    }

    /// Number of the colour of a value.
    pub(super) fn index(self, value: f64) -> u8 {
        if value.is_finite() { (self.place(value) * (COLOURS - 1) as f64).round() as u8 } else { OUTSIDE }
    }

    /// Draws the bar with its numbers; the unit stands above it.
    pub(super) fn bar(self, figure: &mut Figure, at: Rect, unit: &str) -> Result<(), OutputError> {
        let steps: Vec<u8> = (0..COLOURS as u8).rev().collect();
        let image = encode(&figure.name, 1, COLOURS, &steps)?;
        figure.image(at.x, at.y, at.width, at.height, &image);
        for share in [0.0, 0.05, 0.2, 0.5, 1.0] {
            let y = at.y + at.height * (1.0 - self.place(share * self.limit)) + 4.0;
            let sign = if share == 1.0 { "≥ " } else { "" };
            let text = format!("{sign}{}", significant(share * self.limit, 3));
            figure.text(at.x + at.width + 6.0, y, &text, Text::new(11.5).colour("#52606d"));
        }
        let style = Text::new(12.0).anchor(Anchor::Middle);
        figure.text(at.x + at.width / 2.0, at.y - 10.0, unit, style);
        Ok(())
    }
}

/// The colours: lightness falls evenly from nearly white to nearly black, so that grey shows the same order;
/// the hue turns from yellow over red to violet. Made in Ottosson's Oklab.
pub(super) fn palette() -> Vec<[u8; 3]> {
    (0..COLOURS)
        .map(|number| {
            let part = number as f64 / (COLOURS - 1) as f64;
            let lightness = 0.985 - 0.785 * part;
            let hue = (95.0 - 190.0 * part).to_radians();
            let chroma = 0.155 * (std::f64::consts::PI * part.powf(0.85)).sin().max(0.0).powf(0.8) + 0.01;
            srgb(lightness, chroma * hue.cos(), chroma * hue.sin())
        })
        .collect()
}

/// From Oklab to sRGB, cut at its borders.
fn srgb(lightness: f64, a: f64, b: f64) -> [u8; 3] {
    let l = (lightness + 0.396_337_777_4 * a + 0.215_803_757_3 * b).powi(3);
    let m = (lightness - 0.105_561_345_8 * a - 0.063_854_172_8 * b).powi(3);
    let s = (lightness - 0.089_484_177_5 * a - 1.291_485_548_0 * b).powi(3);
    let linear = [
        4.076_741_662_1 * l - 3.307_711_591_3 * m + 0.230_969_929_2 * s,
        -1.268_438_004_6 * l + 2.609_757_401_1 * m - 0.341_319_396_5 * s,
        -0.004_196_086_3 * l - 0.703_418_614_7 * m + 1.707_614_701_0 * s,
    ];
    linear.map(|c| {
        let c = c.clamp(0.0, 1.0);
        let encoded = if c <= 0.003_130_8 { 12.92 * c } else { 1.055 * c.powf(1.0 / 2.4) - 0.055 };
        (255.0 * encoded).round() as u8
    })
}

/// Indices of colours as a PNG image in base 64; [`OUTSIDE`] is see-through.
pub(super) fn encode(name: &str, width: usize, height: usize, indices: &[u8]) -> Result<String, OutputError> {
    let failed = |cause| OutputError::Image { path: format!("{name}.svg").into(), cause };
    let mut colours = palette().concat();
    // One colour more, that cannot be seen.
    colours.extend([255, 255, 255]);
    let mut opacity = vec![255; COLOURS];
    opacity.push(0);
    let data: Vec<u8> = indices.iter().map(|&index| index.min(COLOURS as u8)).collect();
    let mut bytes = vec![];
    let mut encoder = png::Encoder::new(&mut bytes, width as u32, height as u32);
    encoder.set_color(png::ColorType::Indexed);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_palette(colours);
    encoder.set_trns(opacity);
    encoder.set_compression(png::Compression::Balanced);
    encoder.set_filter(png::Filter::NoFilter);
    let mut writer = encoder.write_header().map_err(failed)?;
    writer.write_image_data(&data).map_err(failed)?;
    writer.finish().map_err(failed)?;
    Ok(base64::engine::general_purpose::STANDARD.encode(bytes))
}

/// An axis over metres, in km where they are many; the values on it stay metres.
pub(super) fn metres(range: (f64, f64), letter: char, count: usize) -> Axis {
    if range.1 - range.0 < 5000.0 {
        return Axis::linear(range.0, range.1, &format!("{letter} (m)"), count);
    }
    Axis::linear(1e-3 * range.0, 1e-3 * range.1, &format!("{letter} (km)"), count)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lightness_falls_evenly() {
        let grey: Vec<f64> = (palette().iter())
            .map(|[r, g, b]| 0.2126 * f64::from(*r) + 0.7152 * f64::from(*g) + 0.0722 * f64::from(*b))
            .collect();
        assert!(grey.windows(2).all(|w| w[1] < w[0] - 0.2), "{grey:?}");
        assert!(grey[0] > 235.0 && grey[COLOURS - 1] < 40.0, "{} {}", grey[0], grey[COLOURS - 1]);
    }

    #[test]
    fn pixels_interpolate_and_lie_the_right_way_up() {
        let points: Vec<u32> = (0..9).collect();
        // Two by two cells over 4 m by 2 m.
        let position = |p: u32| [2.0 * f64::from(p % 3), f64::from(p / 3), 0.0];
        let (cells, _) = Cells::of_elements(2, 3, &points, position);
        let raster = Raster::new(&cells, 40).expect("a surface");
        assert_eq!((raster.width, raster.height), (40, 20));
        let values: Vec<f32> = cells.points.iter().map(|p| (p[0] + 10.0 * p[1]) as f32).collect();
        let scale = Scale { limit: 24.0 };
        let painted = raster.paint(&values, scale);
        for (row, column) in [(0, 0), (0, 39), (19, 0), (10, 20), (19, 39)] {
            let (x, y) = (0.1 * (column as f64 + 0.5), 2.0 - 0.1 * (row as f64 + 0.5));
            assert_eq!(painted[row * 40 + column], scale.index(x + 10.0 * y), "{row} {column}");
        }
    }

    #[test]
    fn a_hole_and_a_wall_are_told() {
        let quad = |y: f64| [[0.0, y, 0.0], [1.0, y, 0.0], [1.0, y + 1.0, 0.0], [0.0, y + 1.0, 0.0]];
        let points: Vec<[f64; 3]> = quad(0.0).into_iter().chain(quad(2.0)).collect();
        let cells = Cells { dimension: 2, points, corners: (0..8).collect() };
        let painted = Raster::new(&cells, 30).expect("a surface").paint(&[1.0; 8], Scale { limit: 1.0 });
        assert_eq!(painted[15 * 10 + 5], OUTSIDE);
        assert_eq!(painted[5], COLOURS as u8 - 1);
        let upright = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 0.0, 1.0], [0.0, 0.0, 1.0]];
        let wall = Cells { dimension: 2, points: upright, corners: (0..4).collect() };
        assert!(Raster::new(&wall, 30).is_none());
    }

    #[test]
    fn scales_end_at_round_numbers() {
        let limit = |values: &[f32]| Scale::over(values).map(|s| s.limit);
        assert_eq!(limit(&[0.0, 0.21]), Some(0.25));
        assert_eq!(limit(&[0.0; 5]), None);
        assert_eq!(limit(&[]), None);
        let mut spike = vec![1.0_f32; 10_000];
        spike[3] = 1e6;
        assert_eq!(limit(&spike), Some(1.0));
        let mut lone = vec![0.0_f32; 10_000];
        lone[3] = 3.0;
        assert_eq!(limit(&lone), Some(3.0));
    }
}
