//! Tables of the page: layers, motions per place, reasons of the plan, files.

use std::fmt::Write as _;

use serde_json::Value;

use super::figures::GRAVITY;
use super::place;
use super::svg::{escape, significant};
use super::value::{MISSING, at, list, number, show, with_unit};
use crate::results::{LayerView, SiteResponse};

/// Layers from the surface down.
pub(super) fn layers(layers: &[LayerView]) -> String {
    if layers.is_empty() {
        return String::new();
    }
    let mut html = String::from(
        "<section><h2>Layers</h2><div class=\"scroll\"><table><thead><tr><th class=\"l\">layer</th>\
         <th>top<br><i>m</i></th><th>bottom<br><i>m</i></th><th>v<sub>s</sub><br><i>m/s</i></th>\
         <th>v<sub>p</sub><br><i>m/s</i></th><th>density<br><i>kg/m³</i></th><th>damping D<br><i>%</i></th>\
         <th>S travel time<br><i>ms</i></th></tr></thead><tbody>",
    );
    for layer in layers {
        let bottom = if layer.bottom.is_infinite() { "∞".to_owned() } else { significant(layer.bottom, 5) };
        let travel = (layer.bottom - layer.top) / layer.vs * 1e3;
        let _ = write!(
            html,
            "<tr><td class=\"l\">{}</td><td>{}</td><td>{bottom}</td><td>{}</td><td>{}</td><td>{}</td>\
             <td>{}</td><td>{}</td></tr>",
            escape(&layer.name),
            significant(layer.top, 5),
            significant(layer.vs, 4),
            significant(layer.vp, 4),
            significant(layer.rho, 4),
            significant(layer.damping * 100.0, 3),
            significant(travel, 3),
        );
    }
    html.push_str("</tbody></table></div></section>");
    html
}

/// Peak values, Arias intensity, CAV and durations per place and component, from `summary.results`.
pub(super) fn motions(data: &SiteResponse) -> String {
    let Some(places) = at(&data.summary, &["results"]).and_then(Value::as_object) else {
        return String::new();
    };
    let mut html = String::from(
        "<section><h2>Motions</h2><div class=\"scroll\"><table><thead><tr><th class=\"l\">place</th>\
         <th class=\"l\">axis</th><th>PGA<br><i>m/s²</i></th><th>PGA<br><i>g</i></th>\
         <th>PGV<br><i>m/s</i></th><th>PGD<br><i>m</i></th><th>Arias<br><i>m/s</i></th>\
         <th>CAV<br><i>m/s</i></th><th>D5–75<br><i>s</i></th><th>D5–95<br><i>s</i></th></tr></thead><tbody>",
    );
    for (place, axes) in places {
        let Some(axes) = axes.as_object() else {
            continue;
        };
        for (axis, values) in axes {
            let cell = |key: &str| with_unit(number(values, &[key]), 3, "");
            let in_g = with_unit(number(values, &["pga"]).map(|v| v / GRAVITY), 3, "");
            let _ = write!(
                html,
                "<tr><td class=\"l\">{}</td><td class=\"l\">{}</td><td>{}</td><td>{in_g}</td><td>{}</td>\
                 <td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td></tr>",
                place_words(place),
                escape(axis),
                cell("pga"),
                cell("pgv"),
                cell("pgd"),
                cell("arias"),
                cell("cav"),
                cell("d5_75"),
                cell("d5_95"),
            );
        }
    }
    html.push_str("</tbody></table></div></section>");
    html
}

/// A place's name beside its colour in the figures.
fn place_words(name: &str) -> String {
    let colour = match name {
        "surface" | "within" | "outcrop" => place::stroke(name, 0).colour,
        _ => "transparent",
    };
    format!("<i class=\"dot\" style=\"background:{colour}\"></i>{}", escape(name))
}

/// The plan's lines: every size and why.
pub(super) fn plan(summary: &Value) -> String {
    let lines = list(summary, &["plan"]);
    if lines.is_empty() {
        return String::new();
    }
    let mut html = String::from("<section><h2>Why these sizes</h2><ul class=\"plan\">");
    for line in lines {
        let _ = write!(html, "<li>{}</li>", show(Some(line)));
    }
    html.push_str("</ul></section>");
    html
}

/// Files of the run folder.
pub(super) fn outputs(summary: &Value) -> String {
    let files = list(summary, &["outputs"]);
    if files.is_empty() {
        return String::new();
    }
    let mut html = String::from("<section><h2>Files of this run</h2><ul class=\"files\">");
    for file in files {
        let shown = show(Some(file));
        match file.as_str().filter(|name| is_plain(name)) {
            Some(_) => {
                let _ = write!(html, "<li><a href=\"{shown}\">{shown}</a></li>");
            }
            None if shown == MISSING => {}
            None => {
                let _ = write!(html, "<li>{shown}</li>");
            }
        }
    }
    html.push_str("</ul></section>");
    html
}

/// Whether a name is a path inside the run folder, safe to link to.
fn is_plain(name: &str) -> bool {
    !name.starts_with('/')
        && !name.contains("..")
        && name.chars().all(|c| c.is_ascii_alphanumeric() || matches!(c, '.' | '_' | '-' | '/'))
}
