//! Parameters of a processing step in a line of words.

use serde_json::{Map, Value};

use super::svg::{escape, significant};
use super::value::show;

/// Units that the keys' endings stand for, longest first.
const UNITS: [(&str, &str); 8] = [
    ("_m_s2", "m/s²"),
    ("_m_s", "m/s"),
    ("_hz", "Hz"),
    ("_mm", "mm"),
    ("_g", "g"),
    ("_m", "m"),
    ("_s", "s"),
    ("_1", ""),
];

/// Units of the keys that steps of processing are written with.
const STEP_KEYS: [(&str, &str); 16] = [
    ("f_min", "Hz"),
    ("f_max", "Hz"),
    ("first_seconds", "s"),
    ("start", "s"),
    ("end", "s"),
    ("from", "s"),
    ("to", "s"),
    ("before", "s"),
    ("after", "s"),
    ("dt", "s"),
    ("angle", "°"),
    ("pga", "m/s²"),
    ("pgv", "m/s"),
    ("sa", "m/s²"),
    ("period", "s"),
    ("seconds", "s"),
];

/// Entries that the list of channels already tells.
const TOLD: [&str; 7] = ["sha256", "file", "id", "channel", "format", "unit_stored", "obspy"];

/// A step's name and parameters as HTML; nested steps follow their channel.
pub(super) fn step(step: &Value) -> String {
    let name = match step {
        Value::String(_) => show(Some(step)),
        _ => show(step.get("name")),
    };
    match numbers(step) {
        words if words.is_empty() => name,
        words => format!("{name} <span class=\"quiet\">{words}</span>"),
    }
}

/// A step's parameters and what came out, as HTML without markup of its own.
pub(super) fn numbers(step: &Value) -> String {
    let parts = ["parameters", "found"].into_iter().filter_map(|key| step.get(key)).map(words);
    parts.filter(|words| !words.is_empty()).collect::<Vec<_>>().join(" → ")
}

fn words(parameters: &Value) -> String {
    match parameters {
        Value::Object(entries) => object(entries),
        other => show(Some(other)),
    }
}

fn object(entries: &Map<String, Value>) -> String {
    let shown = entries
        .iter()
        .filter(|(key, value)| !value.is_null() && !TOLD.contains(&key.as_str()))
        .filter(|(key, value)| !(key.starts_with("samples_cut") && value.as_f64() == Some(0.0)));
    let mut parts = Vec::new();
    for (key, value) in shown {
        let part = match value {
            Value::Object(inner) => match object(inner) {
                inner if inner.is_empty() => String::new(),
                inner => format!("{}: {inner}", escape(key)),
            },
            Value::Array(items) if items.iter().any(Value::is_object) => {
                items.iter().map(nested).collect::<Vec<_>>().join("; ")
            }
            plain => entry(key, plain),
        };
        if !part.is_empty() {
            parts.push(part);
        }
    }
    parts.join(", ")
}

fn nested(step: &Value) -> String {
    let name = show(step.get("name"));
    match step.get("parameters").map(words).filter(|words| !words.is_empty()) {
        Some(words) => format!("{name} ({words})"),
        None => name,
    }
}

fn entry(key: &str, value: &Value) -> String {
    if let (Some((_, unit)), Some(number)) = (STEP_KEYS.iter().find(|(k, _)| *k == key), value.as_f64()) {
        return format!("{} {} {unit}", escape(&key.replace('_', " ")), significant(number, 4));
    }
    let unit = UNITS.iter().find(|(ending, _)| key.ends_with(ending) && key.len() > ending.len());
    match (unit, value.as_f64()) {
        (Some((ending, unit)), Some(number)) => {
            let name = key[..key.len() - ending.len()].replace('_', " ");
            format!("{} {} {unit}", escape(&name), significant(number, 4)).trim_end().to_owned()
        }
        _ => format!("{} {}", escape(&key.replace('_', " ")), show(Some(value))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn units_come_from_the_keys() {
        let band = json!({"name": "band", "parameters": {"f_max_hz": 16.0, "window": "half-cosine", "x": {"offset_m_s2": -0.5}}});
        assert_eq!(
            step(&band),
            "band <span class=\"quiet\">f max 16 Hz, window half-cosine, x: offset −0.5 m/s²</span>"
        );
    }

    #[test]
    fn what_the_channels_tell_is_left_out() {
        let record = json!({"name": "record", "parameters": {"x": {
            "sha256": "ab", "samples_cut_before": 0, "samples_cut_after": 7,
            "steps": [{"name": "read", "parameters": {"format": "SAC", "dt_s": 0.01}}, {"name": "unit"}]}}});
        assert_eq!(
            step(&record),
            "record <span class=\"quiet\">x: samples cut after 7, read (dt 0.01 s); unit</span>"
        );
        assert_eq!(step(&json!("demean")), "demean");
        assert_eq!(step(&json!(3)), "—");
    }
}
