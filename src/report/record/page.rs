//! The page itself: first screen, table of measures, figures, files.

use std::fmt::Write as _;

use hati_inputs::records::Channel;
use serde_json::Value;

use super::super::figures::GRAVITY;
use super::super::page::{Entry, FIGURES_TOO, document, entry_html};
use super::super::parameters;
use super::super::place::COMPONENTS;
use super::super::svg::{escape, significant};
use super::super::value::{at, duration, list, number, show, text, with_unit};
use crate::calendar::iso8601;
use crate::record::{Measured, Recording};
use crate::results::AXES;

/// The whole page.
pub(super) fn page(recording: &Recording, measured: &Measured, summary: &Value, entries: &[Entry]) -> String {
    let mut html = header(recording);
    html.push_str(&warnings(summary));
    html.push_str(&cards(measured));
    html.push_str(&measures(measured));
    html.push_str(&found(recording, summary));
    html.push_str(&processing(recording));
    html.push_str("<section class=\"component\">");
    entries.iter().for_each(|entry| entry_html(&mut html, entry));
    html.push_str("</section>");
    html.push_str(&files(summary));
    let footer = format!(
        "SI units; x and y horizontal, z up. The motion can be made again, to the last bit, from its account: \
         <code>hati record --from record.json</code>. {FIGURES_TOO}"
    );
    document(&recording.name, &html, &footer)
}

fn header(recording: &Recording) -> String {
    let motion = &recording.motion;
    let count = recording.axes().len();
    let mut line = format!(
        "{count} component{} · {} samples of {} · {}",
        if count == 1 { "" } else { "s" },
        show(Some(&motion.len().into())),
        duration(Some(motion.dt)),
        duration(Some(motion.duration())),
    );
    match motion.start {
        Some(start) => line.push_str(&format!(" · starts {}", iso8601(start))),
        None => line.push_str(" · start unknown"),
    }
    format!(
        "<header><p class=\"eyebrow\">hati {} · record</p><h1>{}</h1><p class=\"sub\">{line}</p></header>",
        env!("CARGO_PKG_VERSION"),
        escape(&recording.name),
    )
}

fn warnings(summary: &Value) -> String {
    let warnings = list(summary, &["warnings"]);
    if warnings.is_empty() {
        return String::new();
    }
    // What changes every number on the page is larger than the rest.
    let loud = |w: &Value| {
        w.as_str().is_some_and(|w| {
            w.contains("is scaled by") || w.starts_with("implausible") || w.contains("gravity")
        })
    };
    let items: String = (warnings.iter())
        .map(|w| format!("<li{}>{}</li>", if loud(w) { " class=\"loud\"" } else { "" }, show(Some(w))))
        .collect();
    let word = if warnings.len() == 1 { "Warning" } else { "Warnings" };
    format!("<section class=\"warnings\" role=\"alert\"><h2>{word}</h2><ul>{items}</ul></section>")
}

/// The numbers one looks for first: a peak per component.
fn cards(measured: &Measured) -> String {
    let mut html = String::from("<section class=\"numbers\">");
    for c in &measured.components {
        let _ = write!(
            html,
            "<div class=\"number\"><span class=\"label\">PGA {}</span><span class=\"value\">{}</span>\
             <span class=\"note\">{} · PGV {}</span></div>",
            AXES[c.trace.axis],
            with_unit(Some(c.measures.pga / GRAVITY), 3, "g"),
            with_unit(Some(c.measures.pga), 4, "m/s²"),
            with_unit(Some(c.measures.pgv), 4, "m/s"),
        );
    }
    html.push_str("</section>");
    html
}

fn measures(measured: &Measured) -> String {
    let heads = [
        ("PGA", "m/s²"),
        ("PGV", "m/s"),
        ("PGD", "m"),
        ("Arias", "m/s"),
        ("CAV", "m/s"),
        ("D5–75", "s"),
        ("D5–95", "s"),
        ("mean period", "s"),
        ("band", "Hz"),
    ];
    let heads: String =
        heads.iter().map(|(name, unit)| format!("<th>{name}<br><i>{unit}</i></th>")).collect();
    let mut html = format!(
        "<section class=\"tables\"><div class=\"scroll\"><table><thead><tr><th class=\"l\">component</th>{heads}\
         </tr></thead><tbody>"
    );
    for c in &measured.components {
        let m = &c.measures;
        let values = [m.pga, m.pgv, m.pgd, m.arias_intensity, m.cav, m.d5_75, m.d5_95, m.mean_period];
        let cells: String = values.iter().map(|v| format!("<td>{}</td>", significant(*v, 4))).collect();
        let _ = write!(
            html,
            "<tr><td class=\"l\"><i class=\"dot\" style=\"background:{}\"></i>{}</td>{cells}<td>{} to {}</td></tr>",
            COMPONENTS[c.trace.axis.min(2)].colour,
            AXES[c.trace.axis],
            significant(c.band.0, 3),
            significant(c.band.1, 3),
        );
    }
    html.push_str("</tbody></table></div><p class=\"quiet\">PGV and PGD are peaks of the integrals ");
    html.push_str(if measured.from_rest {
        "from rest, as a model follows them: the ground was brought to rest."
    } else {
        "without what lies below one period in the record."
    });
    html.push_str("</p></section>");
    html
}

/// One article per channel: the file, the unit and how it was decided.
fn found(recording: &Recording, summary: &Value) -> String {
    let channels = list(summary, &["channels"]);
    let mut html = format!("<h2>What was found</h2><section class=\"doubts found-{}\">", channels.len());
    for (value, (axis, channel)) in channels.iter().zip(present(recording)) {
        let _ = write!(html, "<article><h2>{} · {}</h2><dl>", AXES[axis], text(value, &["id"]));
        let mut fact = |name: &str, words: String| {
            let _ = write!(html, "<dt>{name}</dt><dd>{words}</dd>");
        };
        fact("file", text(value, &["file"]));
        fact("format", text(value, &["format"]));
        fact("start", instant(&text(value, &["start"])));
        fact("step", duration(number(value, &["dt"])));
        let samples = number(value, &["npts"]).zip(number(value, &["dt"])).map(|(n, dt)| n * dt);
        fact("length", format!("{} samples, {}", text(value, &["npts"]), duration(samples)));
        if let Some(azimuth) = number(value, &["azimuth_deg"]) {
            fact("azimuth in the file", format!("{}° clockwise from north", significant(azimuth, 4)));
        }
        fact("stored in", format!("<b>{}</b>", text(value, &["unit_stored"])));
        fact("unit decided by", decided(value));
        if let Some(factor) = number(value, &["factor_to_si"]) {
            fact("factor to SI", format!("{} {}", significant(factor, 6), text(value, &["unit"])));
        }
        fact("peak as read", peak_as_read(value));
        fact("mean as read", with_unit(number(value, &["mean_as_read"]), 3, &text(value, &["unit"])));
        if let Some(cut) = cut(recording, axis) {
            fact("cut to the common time", cut);
        }
        let _ = write!(
            html,
            "</dl><p class=\"hash\">sha256 {}</p>{}</article>",
            text(value, &["sha256"]),
            reading(channel)
        );
    }
    html.push_str("</section>");
    html
}

/// An ISO 8601 instant as date and time, zeros at its end left out.
pub(super) fn instant(iso: &str) -> String {
    let Some((date, time)) = iso.strip_suffix('Z').and_then(|i| i.split_once('T')) else {
        return iso.to_owned();
    };
    let time = if time.contains('.') { time.trim_end_matches('0').trim_end_matches('.') } else { time };
    format!("<span class=\"unbroken\">{date}</span> <span class=\"unbroken\">{time} UTC</span>")
}

fn present(recording: &Recording) -> impl Iterator<Item = (usize, &Channel)> {
    recording.channels.iter().enumerate().filter_map(|(axis, c)| c.as_ref().map(|c| (axis, c)))
}

fn decided(channel: &Value) -> String {
    match at(channel, &["unit_given_by"]).and_then(Value::as_str) {
        Some("user") => "you (the file’s own statement is set aside)".to_owned(),
        Some("file") => "the file".to_owned(),
        Some("metadata") => "the station’s metadata".to_owned(),
        _ => show(at(channel, &["unit_given_by"])),
    }
}

fn peak_as_read(channel: &Value) -> String {
    let (peak, unit) = (number(channel, &["peak_as_read"]), text(channel, &["unit"]));
    match at(channel, &["quantity"]).and_then(Value::as_str) {
        Some("acceleration") => {
            format!("{} = {}", with_unit(peak, 4, &unit), with_unit(peak.map(|p| p / GRAVITY), 3, "g"))
        }
        _ => with_unit(peak, 4, &unit),
    }
}

/// Samples that the other components do not cover.
fn cut(recording: &Recording, axis: usize) -> Option<String> {
    let record = recording.motion.steps.iter().find(|step| step.name == "record")?;
    let entry = record.parameters.get(AXES[axis].to_string().as_str())?;
    let samples = |key: &str| entry.get(key).and_then(Value::as_u64).unwrap_or(0);
    let (before, after) = (samples("samples_cut_before"), samples("samples_cut_after"));
    (before + after > 0).then(|| format!("{before} samples before, {after} after"))
}

/// How the channel was read, on demand.
fn reading(channel: &Channel) -> String {
    let steps: String = (channel.steps.iter())
        .map(|step| format!("<li>{}</li>", parameters::step(&serde_json::json!(step))))
        .collect();
    format!("<details><summary>how it was read</summary><ol>{steps}</ol></details>")
}

/// Every step in words, then with its numbers and what came out.
fn processing(recording: &Recording) -> String {
    let steps = recording.motion.steps.iter().filter(|step| step.name != "record");
    let items: String = steps
        .map(|step| {
            let value = serde_json::json!(step);
            let words = [axis_of_time(&value), words(&step.name).to_owned()];
            let words: Vec<String> = words.into_iter().filter(|words| !words.is_empty()).collect();
            let words = if words.is_empty() { String::new() } else { format!(": {}", words.join("; ")) };
            format!(
                "<li><b>{}</b>{words} <span class=\"quiet\">{}</span></li>",
                escape(&step.name),
                parameters::numbers(&value)
            )
        })
        .collect();
    let items = if items.is_empty() {
        "<p>nothing: the samples are those of the files, in SI</p>".to_owned()
    } else {
        format!("<ol>{items}</ol>")
    };
    format!(
        "<section class=\"doubts found-1\"><article><h2>What was done, in order</h2>{items}</article></section>"
    )
}

/// What a step did to the time step and the length, first of all that is said of it.
fn axis_of_time(step: &Value) -> String {
    let positive = |path: &[&str]| number(step, path).filter(|seconds| *seconds > 0.0);
    let mut parts = vec![];
    let asked = number(step, &["parameters", "dt"]).filter(|_| step["name"] == "resample");
    if let Some(dt) = asked.or_else(|| positive(&["found", "dt_s"])) {
        parts.push(format!("<b>step now {}</b>", duration(Some(dt))));
    }
    for (key, place) in [("pad_before_s", "before"), ("pad_after_s", "after")] {
        if let Some(seconds) = positive(&["found", key]) {
            parts.push(format!("<b>{} of zeros {place}</b>", duration(Some(seconds))));
        }
    }
    parts.join(", ")
}

/// What a step does.
fn words(name: &str) -> &'static str {
    match name {
        "demean" => "the mean is taken off",
        "detrend" => "the least-squares polynomial is taken off",
        "baseline" => "the drift of the velocity is taken off",
        "taper" => "the ends are brought to zero by half-cosines",
        "filter" => "Butterworth filter",
        "rotate" => "the horizontal axes are turned, counter-clockwise seen from above",
        "trim" => "a stretch is kept",
        "pad" => "zeros are added",
        "resample" => "band-limited interpolation to another step",
        "scale" => "all components are multiplied by one factor",
        "match" => "the motion is fitted to a target spectrum",
        "rest" => "the ground is brought to rest at the end",
        "convert" => "integrated or differentiated in the frequency domain",
        _ => "",
    }
}

fn files(summary: &Value) -> String {
    let Some(files) = at(summary, &["files"]).and_then(Value::as_object) else { return String::new() };
    let mut html = String::from(
        "<section><h2>Files of this motion</h2><ul class=\"plan\"><li><a href=\"record.json\">record.json</a>: \
         sources, steps, measures</li>",
    );
    for (name, about) in files {
        let name = escape(name);
        let _ = write!(
            html,
            "<li><a href=\"{name}\">{name}</a>: {}, {}</li>",
            text(about, &["unit"]),
            text(about, &["encoding"])
        );
    }
    html.push_str("</ul></section>");
    html
}
