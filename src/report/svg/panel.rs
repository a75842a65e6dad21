//! A panel: one pair of axes inside a figure.

use std::fmt::Write as _;

use super::figure::{Anchor, Figure, Text};
use super::thin;
use super::{Axis, Stroke, escape};

const FRAME: Stroke = Stroke::solid("#9aa5b1", 1.0);
const GRID: Stroke = Stroke::solid("#e4e7eb", 1.0);
const FINE: Stroke = Stroke::solid("#f1f3f5", 1.0);
const QUIET: &str = "#52606d";

/// Place of a panel in its figure, pixels.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Rect {
    pub(crate) x: f64,
    pub(crate) y: f64,
    pub(crate) width: f64,
    pub(crate) height: f64,
}

/// A pair of axes.
#[derive(Debug, Clone)]
pub(crate) struct Panel {
    pub(crate) at: Rect,
    pub(crate) x: Axis,
    pub(crate) y: Axis,
}

impl Panel {
    /// Draws the grid and the axes; `x_text` and `y_text` say whether ticks carry numbers and the axes their labels.
    pub(crate) fn draw(figure: &mut Figure, at: Rect, x: Axis, y: Axis, x_text: bool, y_text: bool) -> Self {
        let panel = Self { at, x, y };
        panel.grid(figure);
        if x_text {
            panel.x_numbers(figure);
        }
        if y_text {
            panel.y_numbers(figure);
        }
        panel
    }

    /// Frame and the numbers that the page's script needs; call it after the lines.
    pub(crate) fn close(&self, figure: &mut Figure) {
        let Rect { x, y, width, height } = self.at;
        let mut markup = String::new();
        let _ = write!(
            markup,
            "<rect class=\"panel\" x=\"{x:.1}\" y=\"{y:.1}\" width=\"{width:.1}\" height=\"{height:.1}\" \
             fill=\"none\" pointer-events=\"all\" stroke=\"{}\" \
             data-x=\"{:e},{:e},{}\" data-y=\"{:e},{:e},{}\" data-xl=\"{}\" data-yl=\"{}\"/>",
            FRAME.colour,
            self.x.min,
            self.x.max,
            u8::from(self.x.log),
            self.y.min,
            self.y.max,
            u8::from(self.y.log),
            escape(&self.x.label),
            escape(&self.y.label),
        );
        figure.push(&markup);
    }

    /// Pixel of a value along x.
    pub(crate) fn px(&self, value: f64) -> f64 {
        self.at.x + self.at.width * self.x.fraction(value)
    }

    /// Pixel of a value along y (values grow upwards).
    pub(crate) fn py(&self, value: f64) -> f64 {
        self.at.y + self.at.height * (1.0 - self.y.fraction(value))
    }

    fn right(&self) -> f64 {
        self.at.x + self.at.width
    }

    fn bottom(&self) -> f64 {
        self.at.y + self.at.height
    }

    fn grid(&self, figure: &mut Figure) {
        let mut vertical = |value: f64, stroke| {
            let x = self.px(value);
            figure.segment((x, self.at.y), (x, self.bottom()), stroke);
        };
        self.x.minor.iter().for_each(|&v| vertical(v, FINE));
        self.x.ticks.iter().for_each(|(v, _)| vertical(*v, GRID));
        let mut horizontal = |value: f64, stroke| {
            let y = self.py(value);
            figure.segment((self.at.x, y), (self.right(), y), stroke);
        };
        self.y.minor.iter().for_each(|&v| horizontal(v, FINE));
        self.y.ticks.iter().for_each(|(v, _)| horizontal(*v, GRID));
    }

    fn x_numbers(&self, figure: &mut Figure) {
        let style = Text::new(11.5).anchor(Anchor::Middle).colour(QUIET);
        for (value, text) in &self.x.ticks {
            figure.text(self.px(*value), self.bottom() + 16.0, text, style);
        }
        let middle = self.at.x + self.at.width / 2.0;
        let style = Text::new(12.0).anchor(Anchor::Middle);
        figure.text(middle, self.bottom() + 34.0, &self.x.label, style);
    }

    fn y_numbers(&self, figure: &mut Figure) {
        let style = Text::new(11.5).anchor(Anchor::End).colour(QUIET);
        let mut longest = 0;
        for (value, text) in &self.y.ticks {
            longest = longest.max(text.chars().count());
            figure.text(self.at.x - 7.0, self.py(*value) + 4.0, text, style);
        }
        let middle = self.at.y + self.at.height / 2.0;
        let style = Text::new(12.0).anchor(Anchor::Middle).angle(-90.0);
        let x = self.at.x - 20.0 - 6.4 * longest as f64;
        figure.text(x.max(13.0), middle, &self.y.label, style);
    }

    /// A second scale on the right: `axis` must cover the same range in other units.
    pub(crate) fn right_scale(&self, figure: &mut Figure, axis: &Axis) {
        let style = Text::new(11.5).colour(QUIET);
        let mut longest = 0;
        for (value, text) in &axis.ticks {
            let y = self.bottom() - self.at.height * axis.fraction(*value);
            figure.segment((self.right(), y), (self.right() + 4.0, y), FRAME);
            figure.text(self.right() + 8.0, y + 4.0, text, style);
            longest = longest.max(text.chars().count());
        }
        let middle = self.at.y + self.at.height / 2.0;
        let x = self.right() + 22.0 + 6.4 * longest as f64;
        let style = Text::new(12.0).anchor(Anchor::Middle).angle(90.0);
        figure.text(x, middle, &axis.label, style);
    }

    /// A line through points whose x does not decrease, thinned to the screen.
    pub(crate) fn line(&self, figure: &mut Figure, points: impl Iterator<Item = (f64, f64)>, stroke: Stroke) {
        let path = thin::line(self.pixels(points));
        self.clipped(figure, |figure| figure.path(&path, stroke));
    }

    /// A line through points in any order, none left out.
    pub(crate) fn polyline(&self, figure: &mut Figure, points: &[(f64, f64)], stroke: Stroke) {
        let mut path = String::new();
        let mut command = 'M';
        for (x, y) in self.pixels(points.iter().copied()) {
            if x.is_finite() && y.is_finite() {
                let _ = write!(path, "{command}{x:.1} {y:.1}");
                command = 'L';
            } else {
                command = 'M';
            }
        }
        self.clipped(figure, |figure| figure.path(&path, stroke));
    }

    /// The area between two curves over the same x.
    pub(crate) fn band(&self, figure: &mut Figure, low: &[(f64, f64)], high: &[(f64, f64)], fill: &str) {
        let mut path = String::new();
        let mut command = 'M';
        for (x, y) in self.pixels(high.iter().chain(low.iter().rev()).copied()) {
            if x.is_finite() && y.is_finite() {
                let _ = write!(path, "{command}{x:.1} {y:.1}");
                command = 'L';
            }
        }
        if !path.is_empty() {
            path.push('Z');
            self.clipped(figure, |figure| figure.area(&path, fill));
        }
    }

    /// A straight line across the panel at one x.
    pub(crate) fn vertical(&self, figure: &mut Figure, value: f64, stroke: Stroke) {
        if (self.x.low()..=self.x.high()).contains(&value) {
            let x = self.px(value);
            figure.segment((x, self.at.y), (x, self.bottom()), stroke);
        }
    }

    /// A straight line across the panel at one y.
    pub(crate) fn horizontal(&self, figure: &mut Figure, value: f64, stroke: Stroke) {
        if (self.y.low()..=self.y.high()).contains(&value) {
            let y = self.py(value);
            figure.segment((self.at.x, y), (self.right(), y), stroke);
        }
    }

    fn pixels(&self, points: impl Iterator<Item = (f64, f64)>) -> impl Iterator<Item = (f64, f64)> {
        // Far outside the frame a coordinate is of no use, and a huge number breaks some viewers.
        let bounded = |pixel: f64| if pixel.is_nan() { pixel } else { pixel.clamp(-1e5, 1e5) };
        points.map(move |(x, y)| {
            if x.is_finite() && y.is_finite() {
                (bounded(self.px(x)), bounded(self.py(y)))
            } else {
                (f64::NAN, f64::NAN)
            }
        })
    }

    fn clipped(&self, figure: &mut Figure, draw: impl FnOnce(&mut Figure)) {
        let Rect { x, y, width, height } = self.at;
        figure.open_clip(x - 1.0, y - 1.0, width + 2.0, height + 2.0);
        draw(figure);
        figure.close_group();
    }
}
