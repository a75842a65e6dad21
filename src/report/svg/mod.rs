//! Drawing: an SVG figure, its panels with axes, and lines thinned to what a screen can show.
//!
//! Text is placed without measuring fonts; every figure is white with dark text, so that it prints
//! and stands alone. The numbers of a panel's axes go along as `data-` attributes: the page's script
//! reads them to show the value under the pointer.

mod axis;
mod figure;
mod number;
mod panel;
mod thin;

pub(crate) use axis::Axis;
pub(crate) use figure::{Anchor, Figure, Text};
pub(crate) use number::{escape, significant};
pub(crate) use panel::{Panel, Rect};

/// How a line is drawn.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Stroke {
    /// CSS colour.
    pub(crate) colour: &'static str,
    /// Width, pixels of the figure.
    pub(crate) width: f64,
    /// Dash pattern; empty for a full line.
    pub(crate) dash: &'static str,
    /// 0 invisible … 1 full.
    pub(crate) opacity: f64,
}

impl Stroke {
    /// A full line.
    pub(crate) const fn solid(colour: &'static str, width: f64) -> Self {
        Self { colour, width, dash: "", opacity: 1.0 }
    }

    /// The same line, dashed.
    pub(crate) const fn dashed(self, dash: &'static str) -> Self {
        Self { dash, ..self }
    }

    /// The same line, faint.
    pub(crate) const fn faint(self, opacity: f64) -> Self {
        Self { opacity, ..self }
    }

    /// The same line, wider or thinner.
    pub(crate) const fn wide(self, width: f64) -> Self {
        Self { width, ..self }
    }
}
