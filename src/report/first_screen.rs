//! The page's first screen: title, warnings, main numbers, and answers to the three doubts.

use std::fmt::Write as _;

use serde_json::Value;

use super::figures::{GRAVITY, closing_error, peak};
use super::parameters;
use super::svg::{escape, significant};
use super::value::{at, duration, list, number, quantity, show, text, with_unit};
use crate::results::{AXES, SiteResponse};

/// Header, warnings, key numbers and the three answers, as HTML.
pub(super) fn first_screen(data: &SiteResponse) -> String {
    let mut html = header(data);
    html.push_str(&warnings(&data.summary));
    html.push_str(&key_numbers(data));
    html.push_str("<section class=\"doubts\">");
    html.push_str(&record(&data.summary));
    html.push_str(&boundary(data));
    html.push_str(&step(&data.summary));
    html.push_str("</section>");
    html
}

fn header(data: &SiteResponse) -> String {
    let status = at(&data.summary, &["status"]).and_then(Value::as_str).unwrap_or("—");
    let fine = matches!(status, "ok" | "fine" | "complete" | "completed" | "finished" | "done");
    let samples = data.traces.iter().map(|t| t.acceleration.len()).max().unwrap_or(0);
    let mut line = format!(
        "site response · {} layers over a half-space",
        data.layers.iter().filter(|l| l.bottom.is_finite()).count()
    );
    if let Some(start) = data.start.as_deref().filter(|s| !s.trim().is_empty()) {
        let _ = write!(line, " · record starts {}", escape(start));
    }
    if samples > 1 && data.dt.is_finite() {
        let _ = write!(line, " · {} samples of {}", samples, duration(Some(data.dt)));
    }
    format!(
        "<header><p class=\"eyebrow\">hati {}</p><h1>{}</h1><p class=\"sub\">{line} \
         <span class=\"badge {}\">{}</span></p></header>",
        text(&data.summary, &["hati_version"]),
        escape(&data.title),
        if fine { "good" } else { "neutral" },
        escape(status),
    )
}

fn warnings(summary: &Value) -> String {
    let warnings = list(summary, &["warnings"]);
    if warnings.is_empty() {
        return String::new();
    }
    let items: String = warnings.iter().map(|w| format!("<li>{}</li>", show(Some(w)))).collect();
    let word = if warnings.len() == 1 { "Warning" } else { "Warnings" };
    format!("<section class=\"warnings\" role=\"alert\"><h2>{word}</h2><ul>{items}</ul></section>")
}

fn card(label: &str, value: &str, note: &str) -> String {
    format!(
        "<div class=\"number\"><span class=\"label\">{label}</span><span class=\"value\">{value}</span>\
         <span class=\"note\">{note}</span></div>"
    )
}

fn key_numbers(data: &SiteResponse) -> String {
    let summary = &data.summary;
    let mut html = String::from("<section class=\"numbers\">");
    let pga = |place: &str, axis: usize| {
        data.traces
            .iter()
            .find(|t| t.place == place && t.axis == axis && !t.acceleration.is_empty())
            .map(|t| peak(&t.acceleration))
    };
    for axis in 0..3 {
        let Some(surface) = pga("surface", axis) else {
            continue;
        };
        let note = match pga("outcrop", axis).filter(|v| *v > 0.0) {
            Some(outcrop) => format!(
                "{} m/s² · outcrop {} g · ratio {}",
                significant(surface, 3),
                significant(outcrop / GRAVITY, 3),
                significant(surface / outcrop, 3)
            ),
            None => format!("{} m/s²", significant(surface, 3)),
        };
        let label = format!("PGA at the surface, {}", AXES[axis]);
        html.push_str(&card(&label, &with_unit(Some(surface / GRAVITY), 3, "g"), &note));
    }
    let percent = |path: &[&str]| with_unit(number(summary, path).map(|v| v * 100.0), 2, "%");
    html.push_str(&card(
        "predicted error",
        &percent(&["accuracy", "predicted"]),
        &format!("asked for {}", percent(&["accuracy", "asked"])),
    ));
    let closing = number(summary, &["energy", "closing_error"]).or_else(|| closing_error(&data.ledger));
    html.push_str(&card(
        "energy closing error",
        &with_unit(closing, 2, ""),
        "unaccounted energy / largest energy",
    ));
    html.push_str(&card(
        "solver time",
        &duration(number(summary, &["cost", "solver_s"])),
        &format!(
            "whole run {} · {}",
            duration(number(summary, &["cost", "wall_s"])),
            quantity(
                summary,
                &["cost", "ns_per_point_component_step"],
                3,
                "ns per point, component and step"
            ),
        ),
    ));
    html.push_str("</section>");
    html
}

fn facts(rows: &[(&str, String)]) -> String {
    let mut html = String::from("<dl>");
    for (name, value) in rows {
        let _ = write!(html, "<dt>{name}</dt><dd>{value}</dd>");
    }
    html.push_str("</dl>");
    html
}

fn record(summary: &Value) -> String {
    let mut html = String::from("<article><h2>Did the record go in right?</h2>");
    html.push_str(&scale(summary));
    for channel in list(summary, &["record", "channels"]) {
        let _ = write!(
            html,
            "<p class=\"channel\"><b>{}</b> {}<br><span class=\"quiet\">{} · {} · stored in \
             <b>{}</b> · {} samples of {} · peak as read {}</span></p>",
            text(channel, &["axis"]),
            text(channel, &["id"]),
            text(channel, &["file"]),
            text(channel, &["format"]),
            text(channel, &["unit_stored"]),
            text(channel, &["npts"]),
            duration(number(channel, &["dt"])),
            peak_as_read(channel),
        );
    }
    if list(summary, &["record", "channels"]).is_empty() {
        html.push_str("<p class=\"quiet\">no channel listed</p>");
    }
    let steps = list(summary, &["record", "steps"]);
    if !steps.is_empty() {
        html.push_str("<h3>Processing, in order</h3><ol>");
        for step in steps {
            let _ = write!(html, "<li>{}</li>", parameters::step(step));
        }
        html.push_str("</ol>");
    }
    html.push_str("</article>");
    html
}

/// Peak of a channel before any processing, in its SI unit, for an acceleration also in g.
fn peak_as_read(channel: &Value) -> String {
    let peak = number(channel, &["pga"]).or_else(|| number(channel, &["peak_as_read"]));
    let unit = match at(channel, &["unit"]).and_then(Value::as_str) {
        None | Some("m/s²" | "m/s2" | "m s-2") => {
            let in_g = with_unit(peak.map(|v| v / GRAVITY), 3, "g");
            return format!("{} = {in_g}", with_unit(peak, 3, "m/s²"));
        }
        Some(unit) => escape(unit),
    };
    with_unit(peak, 3, &unit)
}

fn scale(summary: &Value) -> String {
    let factor = number(summary, &["record", "scale", "factor"]);
    let why = at(summary, &["record", "scale", "why"])
        .map(|why| format!(" <span class=\"quiet\">{}</span>", show(Some(why))))
        .unwrap_or_default();
    match factor {
        Some(factor) if (factor - 1.0).abs() > 1e-12 => {
            format!("<p class=\"scaled\">scaled by {}{why}</p>", significant(factor, 4))
        }
        Some(_) => format!("<p class=\"unscaled\">not scaled{why}</p>"),
        None => "<p class=\"unscaled\">scale: —</p>".to_owned(),
    }
}

fn boundary(data: &SiteResponse) -> String {
    let summary = &data.summary;
    let last = data.ledger.last();
    let share = |value: Option<f64>, fallback: Option<f64>| {
        let input = number(summary, &["energy", "input"]).or(last.map(|r| r.input));
        let value = value.or(fallback)?;
        input.filter(|i| *i > 0.0).map(|i| 100.0 * value / i)
    };
    let outflow = share(number(summary, &["energy", "outflow"]), last.map(|r| r.outflow));
    let viscous = share(number(summary, &["energy", "viscous"]), last.map(|r| r.viscous));
    let base = |key: &str| number(summary, &["model", "base", key]);
    let mut html = String::from("<article><h2>Is the boundary quiet?</h2>");
    let _ = write!(html, "<p class=\"lead\">base: <b>{}</b></p>", text(summary, &["model", "base", "kind"]));
    html.push_str(&facts(&[
        ("impedance, S waves", impedance(base("impedance_s"))),
        ("impedance, P waves", impedance(base("impedance_p"))),
        ("energy in", energy(number(summary, &["energy", "input"]).or(last.map(|r| r.input)))),
        ("radiated downwards", with_unit(outflow, 3, "% of it")),
        ("lost in the soil", with_unit(viscous, 3, "% of it")),
        ("stored at most", energy(number(summary, &["energy", "stored_max"]))),
    ]));
    if data.layers.len() >= 2 {
        html.push_str(&contrast(data));
    }
    html.push_str("</article>");
    html
}

fn impedance(value: Option<f64>) -> String {
    with_unit(value.map(|v| v / 1e6), 3, "MPa·s/m")
}

fn energy(value: Option<f64>) -> String {
    match value {
        Some(v) if v.abs() >= 2e6 => with_unit(Some(v / 1e6), 3, "MJ/m²"),
        Some(v) if v.abs() >= 2e3 => with_unit(Some(v / 1e3), 3, "kJ/m²"),
        other => with_unit(other, 3, "J/m²"),
    }
}

/// What the base does to a downgoing wave: the share of its amplitude that comes back.
fn contrast(data: &SiteResponse) -> String {
    let [.., above, half_space] = data.layers.as_slice() else {
        return String::new();
    };
    let kind = text(&data.summary, &["model", "base", "kind"]);
    if kind.contains("rigid") || kind.contains("imposed") {
        return "<p class=\"quiet\">The base follows the motion given and sends every downgoing wave back: \
                right only where that motion was recorded at the base itself (within).</p>"
            .to_owned();
    }
    let (soil, rock) = (above.rho * above.vs, half_space.rho * half_space.vs);
    let back = (rock - soil) / (rock + soil);
    if !back.is_finite() {
        return String::new();
    }
    format!(
        "<p class=\"quiet\">Impedance of the lowest layer is {} of the half-space’s: by layering alone {} % \
         of a downgoing S wave’s amplitude comes back, and the rest leaves.</p>",
        significant(soil / rock, 2),
        significant(100.0 * back.abs(), 2)
    )
}

fn step(summary: &Value) -> String {
    let model = |key: &str| number(summary, &["model", key]);
    let (dt, critical) = (model("dt"), model("dt_critical"));
    let share = match (dt, critical) {
        (Some(dt), Some(critical)) if critical > 0.0 => Some(dt / critical),
        _ => None,
    };
    let mut html = String::from("<article><h2>Is the step stable?</h2>");
    let verdict = match share {
        Some(share) if share < 1.0 => format!(
            "<p class=\"lead\">step is <b>{} %</b> of the critical step</p>",
            significant(100.0 * share, 3)
        ),
        Some(share) => format!(
            "<p class=\"lead bad\">step is <b>{} %</b> of the critical step</p>",
            significant(100.0 * share, 3)
        ),
        None => "<p class=\"lead\">share of the critical step: —</p>".to_owned(),
    };
    html.push_str(&verdict);
    if let Some(share) = share {
        let _ = write!(
            html,
            "<div class=\"gauge\" role=\"img\" aria-label=\"{0:.0} percent\"><i style=\"width:{0:.1}%\"></i></div>",
            (100.0 * share).clamp(0.0, 100.0)
        );
    }
    html.push_str(&facts(&[
        ("step", duration(dt)),
        ("critical step", duration(critical)),
        ("limited by", text(summary, &["model", "limited_by"])),
        ("steps", text(summary, &["model", "steps"])),
        ("elements", elements(summary)),
        ("order", text(summary, &["model", "order"])),
        ("points", text(summary, &["model", "points"])),
        ("damping mechanisms", show(at(summary, &["model", "mechanisms"]))),
        ("band", band(summary)),
        ("reference frequency", quantity(summary, &["model", "reference_frequency"], 3, "Hz")),
    ]));
    html.push_str("</article>");
    html
}

/// Number of elements: one number, or one per layer with their sum.
fn elements(summary: &Value) -> String {
    let counts: Vec<u64> = list(summary, &["model", "elements"]).iter().filter_map(Value::as_u64).collect();
    match counts.as_slice() {
        [] => text(summary, &["model", "elements"]),
        counts => {
            let words: Vec<String> = counts.iter().map(u64::to_string).collect();
            format!("{} ({} by layer)", counts.iter().sum::<u64>(), words.join(" + "))
        }
    }
}

fn band(summary: &Value) -> String {
    match list(summary, &["model", "band"]) {
        [low, high] => format!("{} to {}", with_unit(low.as_f64(), 3, ""), with_unit(high.as_f64(), 3, "Hz")),
        _ => text(summary, &["model", "band"]),
    }
}
