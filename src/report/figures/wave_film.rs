//! The surface in motion: all pictures in one image, and a small player.

use std::fmt::Write as _;

use super::super::svg::{Figure, Rect, significant};
use super::super::table::Table;
use super::super::wave::SurfaceMotion;
use super::wave::{Raster, Scale, encode};
use super::wave_maps::{instants, map};
use super::{Plate, WIDTH};
use crate::outputs::OutputError;

/// Letters of the film's image at most; the page stays below 2 MB.
const MOST_BYTES: usize = 1_500_000;
/// Pictures at most.
const MOST_FRAMES: usize = 120;
/// Length of the film, s.
const SECONDS: f64 = 8.0;

const PLAYER: &str = include_str!("../film.js");

/// A film: its figure with one picture, and the player that moves it.
#[derive(Debug)]
pub(in super::super) struct Film {
    /// One picture of it.
    pub(in super::super) plate: Plate,
    /// The player, HTML.
    pub(in super::super) words: String,
}

/// Speed of the surface as a film; `None` where nothing moves or there are fewer than four instants.
pub(in super::super) fn film(surface: &SurfaceMotion) -> Result<Option<Film>, OutputError> {
    let Some(scale) = Scale::over(&surface.speed).filter(|_| surface.time.len() >= 4) else {
        return Ok(None);
    };
    let mut strip = None;
    // Smaller pictures, then fewer, until the image is small enough.
    for (pixels, frames) in [(220, MOST_FRAMES), (170, MOST_FRAMES), (130, MOST_FRAMES), (130, 60), (80, 40)]
    {
        let Some(made) = Strip::new(surface, scale, pixels, frames)? else { return Ok(None) };
        let small = made.image.len() <= MOST_BYTES;
        strip = Some(made);
        if small {
            break;
        }
    }
    let Some(strip) = strip else { return Ok(None) };
    let aspect = strip.raster.aspect();
    let width = 700.0_f64.min(520.0 / aspect);
    let at = Rect { x: 0.5 * (WIDTH - width), y: 58.0, width, height: width * aspect };
    let mut figure =
        Figure::new("surface-film", "Speed of the surface in motion", WIDTH, at.y + at.height + 46.0);
    // Midway is where a picture without the player says most.
    let poster = instants(surface, 3).get(1).copied().unwrap_or(0);
    let shown = strip.frames.iter().position(|&f| f >= poster).unwrap_or(0);
    map(&mut figure, &strip.raster, surface.frame(strip.frames[shown]), scale, at, [true, true], "")?;
    let bar = Rect { x: at.x + at.width + 16.0, y: at.y + 12.0, width: 14.0, height: at.height - 14.0 };
    scale.bar(&mut figure, bar, "m/s")?;
    let words = strip.player(surface, at, figure.height, shown);
    let largest: Vec<f64> = (0..surface.time.len())
        .map(|i| f64::from(surface.frame(i).iter().fold(0.0_f32, |m, v| m.max(*v))))
        .collect();
    let table =
        Table::default().column("elapsed_time_s", surface.time.clone()).column("largest_speed_m_s", largest);
    let caption = format!(
        "{} of {} instants; the still picture is that of t = {} s. All values are in surface.nc; the table holds the \
         largest speed of each instant.",
        strip.frames.len(),
        surface.time.len(),
        significant(surface.time[strip.frames[shown]], 4)
    );
    Ok(Some(Film { plate: Plate { figure, csv: table.to_csv(), caption }, words }))
}

/// All pictures of a film side by side in one image.
struct Strip {
    raster: Raster,
    /// Instants that are shown.
    frames: Vec<usize>,
    /// Pictures in a row of the image.
    columns: usize,
    image: String,
}

impl Strip {
    fn new(
        surface: &SurfaceMotion,
        scale: Scale,
        pixels: usize,
        frames: usize,
    ) -> Result<Option<Self>, OutputError> {
        let Some(raster) = Raster::new(&surface.cells, pixels) else { return Ok(None) };
        let stride = surface.time.len().div_ceil(frames);
        let frames: Vec<usize> = (0..surface.time.len()).step_by(stride).collect();
        let columns = (frames.len() as f64).sqrt().ceil() as usize;
        let rows = frames.len().div_ceil(columns);
        let (width, height) = (raster.width, raster.height);
        let mut indices = vec![super::wave::OUTSIDE; columns * width * rows * height];
        for (number, &frame) in frames.iter().enumerate() {
            let painted = raster.paint(surface.frame(frame), scale);
            let (x, y) = (number % columns * width, number / columns * height);
            for (row, line) in painted.chunks_exact(width).enumerate() {
                let at = (y + row) * columns * width + x;
                indices[at..at + width].copy_from_slice(line);
            }
        }
        let image = encode("surface-film", columns * width, rows * height, &indices)?;
        Ok(Some(Self { raster, frames, columns, image }))
    }

    /// The player, which lays its pictures over the figure's map.
    fn player(&self, surface: &SurfaceMotion, at: Rect, figure_height: f64, shown: usize) -> String {
        let mut times = String::new();
        for &frame in &self.frames {
            let comma = if times.is_empty() { "" } else { "," };
            let _ = write!(times, "{comma}{:.6}", surface.time[frame]);
        }
        let percent = |part: f64, whole: f64| 100.0 * part / whole;
        format!(
            "<div class=\"film\" hidden style=\"display:flex;gap:12px;align-items:center;margin:6px 0 0\" \
             data-figure=\"surface-film\" data-times=\"{times}\" data-width=\"{}\" data-height=\"{}\" \
             data-columns=\"{}\" data-shown=\"{shown}\" data-pause=\"{:.1}\" \
             data-left=\"{:.4}\" data-top=\"{:.4}\" data-wide=\"{:.4}\" data-high=\"{:.4}\">\
             <button type=\"button\">Play</button>\
             <input type=\"range\" min=\"0\" max=\"{}\" value=\"{shown}\" style=\"flex:1\" aria-label=\"instant\">\
             <output style=\"min-width:9em;text-align:right\"></output>\
             <img alt=\"\" hidden src=\"data:image/png;base64,{}\"></div><script>{PLAYER}</script>",
            self.raster.width,
            self.raster.height,
            self.columns,
            1000.0 * SECONDS / self.frames.len() as f64,
            percent(at.x, WIDTH),
            percent(at.y, figure_height),
            percent(at.width, WIDTH),
            percent(at.height, figure_height),
            self.frames.len() - 1,
            self.image,
        )
    }
}
