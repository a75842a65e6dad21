//! One SVG figure.

use std::fmt::Write as _;

use super::{Stroke, escape};

/// Colour of text.
const INK: &str = "#1f2933";
const FONT: &str = "Inter, 'Helvetica Neue', Helvetica, Arial, 'Liberation Sans', sans-serif";

/// Which end of a text stands at its place.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Anchor {
    /// Left end.
    Start,
    /// Middle.
    Middle,
    /// Right end.
    End,
}

/// How a text is set.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Text {
    /// Height, pixels.
    pub(crate) size: f64,
    /// Which end stands at the place.
    pub(crate) anchor: Anchor,
    /// CSS colour.
    pub(crate) colour: &'static str,
    /// Bold.
    pub(crate) bold: bool,
    /// Rotation about the place, degrees.
    pub(crate) angle: f64,
    /// White rim that keeps it readable over lines.
    pub(crate) halo: bool,
}

impl Text {
    /// Plain text that starts at its place.
    pub(crate) const fn new(size: f64) -> Self {
        Self { size, anchor: Anchor::Start, colour: INK, bold: false, angle: 0.0, halo: false }
    }

    /// With another anchor.
    pub(crate) const fn anchor(self, anchor: Anchor) -> Self {
        Self { anchor, ..self }
    }

    /// In another colour.
    pub(crate) const fn colour(self, colour: &'static str) -> Self {
        Self { colour, ..self }
    }

    /// Bold.
    pub(crate) const fn bold(self) -> Self {
        Self { bold: true, ..self }
    }

    /// Turned.
    pub(crate) const fn angle(self, angle: f64) -> Self {
        Self { angle, ..self }
    }

    /// With a white rim.
    pub(crate) const fn halo(self) -> Self {
        Self { halo: true, ..self }
    }
}

/// A figure under construction; `name` is its file's name without ending and makes its ids unique.
#[derive(Debug)]
pub(crate) struct Figure {
    pub(crate) name: String,
    pub(crate) width: f64,
    pub(crate) height: f64,
    title: String,
    body: String,
    clips: usize,
}

impl Figure {
    /// An empty white figure with its title in the upper left corner.
    pub(crate) fn new(name: &str, title: &str, width: f64, height: f64) -> Self {
        let mut figure = Self {
            name: name.to_owned(),
            width,
            height,
            title: title.to_owned(),
            body: String::with_capacity(1 << 16),
            clips: 0,
        };
        figure.text(16.0, 25.0, title, Text::new(15.0).bold());
        figure
    }

    /// The whole SVG document.
    pub(crate) fn finish(&self) -> String {
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {w} {h}\" width=\"{w}\" \
             height=\"{h}\" role=\"img\" aria-label=\"{title}\" font-family=\"{FONT}\">\
             <title>{title}</title><rect width=\"{w}\" height=\"{h}\" fill=\"#ffffff\"/>{body}</svg>\n",
            w = self.width,
            h = self.height,
            title = escape(&self.title),
            body = self.body,
        )
    }

    /// Adds markup.
    pub(super) fn push(&mut self, markup: &str) {
        self.body.push_str(markup);
    }

    /// A text.
    pub(crate) fn text(&mut self, x: f64, y: f64, content: &str, style: Text) {
        let anchor = match style.anchor {
            Anchor::Start => "start",
            Anchor::Middle => "middle",
            Anchor::End => "end",
        };
        let _ = write!(
            self.body,
            "<text x=\"{x:.1}\" y=\"{y:.1}\" font-size=\"{}\" text-anchor=\"{anchor}\" fill=\"{}\"",
            style.size, style.colour
        );
        if style.bold {
            self.body.push_str(" font-weight=\"600\"");
        }
        if style.angle != 0.0 {
            let _ = write!(self.body, " transform=\"rotate({} {x:.1} {y:.1})\"", style.angle);
        }
        if style.halo {
            self.body.push_str(
                " stroke=\"#ffffff\" stroke-width=\"3.5\" stroke-linejoin=\"round\" paint-order=\"stroke\"",
            );
        }
        let _ = write!(self.body, ">{}</text>", escape(content));
    }

    /// A straight line.
    pub(crate) fn segment(&mut self, from: (f64, f64), to: (f64, f64), stroke: Stroke) {
        let _ = write!(
            self.body,
            "<line x1=\"{:.1}\" y1=\"{:.1}\" x2=\"{:.1}\" y2=\"{:.1}\"{}/>",
            from.0,
            from.1,
            to.0,
            to.1,
            stroke_attributes(stroke)
        );
    }

    /// A filled rectangle.
    pub(crate) fn rectangle(&mut self, x: f64, y: f64, width: f64, height: f64, fill: &str) {
        let _ = write!(
            self.body,
            "<rect x=\"{x:.1}\" y=\"{y:.1}\" width=\"{width:.1}\" height=\"{height:.1}\" fill=\"{fill}\"/>"
        );
    }

    /// A dot with a white rim.
    pub(crate) fn dot(&mut self, x: f64, y: f64, radius: f64, fill: &str) {
        let _ = write!(
            self.body,
            "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{radius}\" fill=\"{fill}\" stroke=\"#ffffff\" stroke-width=\"1.2\"/>"
        );
    }

    /// A path given by its commands, drawn as a line.
    pub(super) fn path(&mut self, commands: &str, stroke: Stroke) {
        let _ = write!(
            self.body,
            "<path d=\"{commands}\" fill=\"none\" stroke-linejoin=\"round\"{}/>",
            stroke_attributes(stroke)
        );
    }

    /// A path given by its commands, filled.
    pub(super) fn area(&mut self, commands: &str, fill: &str) {
        let _ = write!(self.body, "<path d=\"{commands}\" fill=\"{fill}\" stroke=\"none\"/>");
    }

    /// Closed polygons of one fill, with outlines or without.
    pub(crate) fn polygons<P>(
        &mut self,
        all: impl IntoIterator<Item = P>,
        fill: &str,
        outline: Option<Stroke>,
    ) where
        P: IntoIterator<Item = (f64, f64)>,
    {
        self.body.push_str("<path d=\"");
        for polygon in all {
            let mut command = 'M';
            for (x, y) in polygon {
                let _ = write!(self.body, "{command}{x:.1} {y:.1}");
                command = 'L';
            }
            self.body.push('Z');
        }
        let stroke = outline.map_or_else(|| " stroke=\"none\"".to_owned(), stroke_attributes);
        let _ = write!(self.body, "\" fill=\"{fill}\" stroke-linejoin=\"round\"{stroke}/>");
    }

    /// A PNG image stretched over a rectangle.
    pub(crate) fn image(&mut self, x: f64, y: f64, width: f64, height: f64, base64: &str) {
        let _ = write!(
            self.body,
            "<image x=\"{x:.1}\" y=\"{y:.1}\" width=\"{width:.1}\" height=\"{height:.1}\" \
             preserveAspectRatio=\"none\" href=\"data:image/png;base64,{base64}\"/>"
        );
    }

    /// Opens a group that shows only what lies in the rectangle; [`Self::close_group`] ends it.
    pub(super) fn open_clip(&mut self, x: f64, y: f64, width: f64, height: f64) {
        self.clips += 1;
        let id = format!("{}-{}", self.name, self.clips);
        let _ = write!(
            self.body,
            "<clipPath id=\"{id}\"><rect x=\"{x:.1}\" y=\"{y:.1}\" width=\"{width:.1}\" height=\"{height:.1}\"/></clipPath><g clip-path=\"url(#{id})\">"
        );
    }

    /// Ends a group.
    pub(super) fn close_group(&mut self) {
        self.body.push_str("</g>");
    }

    /// A row of line samples with names, its right end at `right`: beside the title where there is room,
    /// else below it. The panels start at 60 or lower.
    pub(crate) fn legend(&mut self, right: f64, entries: &[(String, Stroke)]) {
        let width = |text: &str| 47.0 + 6.9 * text.chars().count() as f64;
        let total: f64 = entries.iter().map(|(name, _)| width(name)).sum::<f64>() - 14.0;
        let title = 40.0 + 8.6 * self.title.chars().count() as f64;
        let y = if right - total > title { 26.0 } else { 48.0 };
        let mut x = (right - total).max(16.0);
        for (name, stroke) in entries {
            self.segment((x, y - 4.0), (x + 24.0, y - 4.0), *stroke);
            self.text(x + 30.0, y, name, Text::new(12.0));
            x += width(name);
        }
    }
}

fn stroke_attributes(stroke: Stroke) -> String {
    let mut text = format!(" stroke=\"{}\" stroke-width=\"{}\"", stroke.colour, stroke.width);
    if !stroke.dash.is_empty() {
        let _ = write!(text, " stroke-dasharray=\"{}\"", stroke.dash);
    }
    if stroke.opacity < 1.0 {
        let _ = write!(text, " stroke-opacity=\"{}\"", stroke.opacity);
    }
    text
}
