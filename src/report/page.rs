//! Puts the page together: first screen, figures per component, tables.

use std::fmt::Write as _;

use super::figures::{LawGap, Plate, View, law_gap, percent};
use super::first_screen::first_screen;
use super::svg::{escape, significant};
use super::tables;
use crate::results::{AXES, SiteResponse};

const STYLE: &str = include_str!("style.css");
const SCRIPT: &str = include_str!("script.js");

/// A figure with the heading it stands under; a folded one opens on a click.
#[derive(Debug)]
pub(super) struct Entry {
    /// The figure.
    pub(super) plate: Plate,
    /// Heading, HTML-free.
    pub(super) heading: &'static str,
    /// Shown only on demand.
    pub(super) folded: bool,
    /// Further words, HTML.
    pub(super) words: String,
}

/// All figures of one component.
#[derive(Debug)]
pub(super) struct Component {
    /// 0 = x, 1 = y, 2 = z.
    pub(super) axis: usize,
    /// In reading order.
    pub(super) entries: Vec<Entry>,
}

/// The whole page of a run.
pub(super) fn page(data: &SiteResponse, components: &[Component], ledger: Option<&Entry>) -> String {
    let mut html = first_screen(data);
    components_html(&mut html, components);
    if let Some(entry) = ledger {
        html.push_str("<section class=\"component\">");
        entry_html(&mut html, entry);
        html.push_str("</section>");
    }
    html.push_str("<section class=\"tables\">");
    html.push_str(&tables::motions(data));
    html.push_str(&tables::layers(&data.layers));
    html.push_str(&tables::plan(&data.summary));
    html.push_str(&tables::outputs(&data.summary));
    html.push_str("</section>");
    let footer = format!("SI units; x and y horizontal, z up; depth positive down. {FIGURES_TOO}");
    document(&data.title, &html, &footer)
}

/// Words of the footer on the figures' files.
pub(super) const FIGURES_TOO: &str = "Each figure is also in <code>figures/</code> as SVG, with its numbers as CSV \
                                      beside it. Point at a figure to read values.";

/// A page of its own: title without markup, body and footer as HTML.
pub(super) fn document(title: &str, body: &str, footer: &str) -> String {
    let mut html = String::with_capacity(body.len() + (1 << 14));
    let _ = writeln!(
        html,
        "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\
         <meta name=\"viewport\" content=\"width=device-width,initial-scale=1\">\
         <meta name=\"color-scheme\" content=\"light dark\">\
         <meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; img-src data:; \
         style-src 'unsafe-inline'; script-src 'unsafe-inline'\">\
         <title>{} — hati</title><style>{STYLE}</style></head><body><main>{body}</main><footer>{footer}</footer>\
         <div id=\"readout\" hidden></div><script>{SCRIPT}</script></body></html>",
        escape(title)
    );
    html
}

/// Components one after another, or as tabs where there are several.
fn components_html(html: &mut String, components: &[Component]) {
    let tabs = components.len() > 1;
    if tabs {
        html.push_str("<nav class=\"tabs\" role=\"tablist\">");
        for (number, component) in components.iter().enumerate() {
            let letter = AXES[component.axis];
            let _ = write!(
                html,
                "<button role=\"tab\" aria-selected=\"{}\" aria-controls=\"component-{letter}\">{} {letter}</button>",
                number == 0,
                if component.axis == 2 { "vertical" } else { "horizontal" },
            );
        }
        html.push_str("</nav>");
    }
    for component in components {
        let _ = write!(
            html,
            "<section class=\"component{}\" id=\"component-{}\">",
            if tabs { " tabbed" } else { "" },
            AXES[component.axis]
        );
        for entry in &component.entries {
            entry_html(html, entry);
        }
        html.push_str("</section>");
    }
}

/// A figure with its heading, its words and the links to its files.
pub(super) fn entry_html(html: &mut String, entry: &Entry) {
    let plate = &entry.plate;
    let name = &plate.figure.name;
    if entry.folded {
        let _ = write!(html, "<details><summary>{}</summary>", entry.heading);
    } else {
        let _ = write!(html, "<h2>{}</h2>", entry.heading);
    }
    let _ = write!(
        html,
        "<figure>{}<figcaption><span>{}</span> <span class=\"links\"><a href=\"figures/{name}.svg\">SVG</a> \
         <a href=\"figures/{name}.csv\">CSV</a></span></figcaption></figure>{}",
        plate.figure.finish(),
        plate.caption,
        entry.words
    );
    if entry.folded {
        html.push_str("</details>");
    }
}

/// The paragraph on the two damping laws, with the gaps of this run.
pub(super) fn damping_laws(view: &View<'_>) -> String {
    let gaps: Vec<(&str, LawGap)> = view
        .data
        .transfer
        .iter()
        .filter(|t| t.axis == view.axis)
        .filter_map(|t| law_gap(t).map(|gap| (t.name.as_str(), gap)))
        .take(2)
        .collect();
    if gaps.is_empty() {
        return String::new();
    }
    let mut html = String::from(
        "<div class=\"prose\"><h3>Two damping laws, and why they differ</h3><p>The run keeps the damping \
         ratio D constant over the scene’s band. Causality then makes the soil stiffer towards high \
         frequencies: Re&nbsp;G grows by about 4D/π for each factor e in frequency and equals the given G at \
         the reference frequency only",
    );
    if let Some(damping) = largest_damping(view) {
        let _ = write!(
            html,
            " (largest D of these layers {}: {} per factor e, {} per decade)",
            percent(damping),
            percent(4.0 * damping / std::f64::consts::PI),
            percent(10_f64.powf(4.0 * damping / std::f64::consts::PI) - 1.0),
        );
    }
    html.push_str(
        ". The textbooks’ G(1&nbsp;+&nbsp;2iD) holds both D and Re&nbsp;G constant. Such a material would \
         answer before it is loaded, so no computation in time can reproduce it; it is drawn dashed for \
         comparison only. Its peaks lie off those of the run because its waves travel at one speed.</p><ul>",
    );
    for (name, gap) in gaps {
        let _ = write!(
            html,
            "<li><b>{}</b>: peak {} at {} Hz; the two laws differ by at most {} of that peak (at {} Hz)",
            escape(&name.replace('/', " / ")),
            significant(gap.peak.0, 3),
            significant(gap.peak.1, 3),
            percent(gap.between_laws.0),
            significant(gap.between_laws.1, 3),
        );
        if let Some((size, frequency)) = gap.of_run {
            let _ = write!(
                html,
                "; this run differs from the causal law by at most {} of it (at {} Hz)",
                percent(size),
                significant(frequency, 3)
            );
        }
        html.push_str(".</li>");
    }
    html.push_str("</ul></div>");
    html
}

fn largest_damping(view: &View<'_>) -> Option<f64> {
    view.data
        .layers
        .iter()
        .filter(|l| l.bottom.is_finite() && l.damping.is_finite())
        .map(|l| l.damping)
        .max_by(f64::total_cmp)
        .filter(|d| *d > 0.0)
}
