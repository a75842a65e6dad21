//! Reading `summary.json`'s content without trust: what is missing or of another kind reads `—`.

use serde_json::Value;

use super::svg::{escape, significant};

/// Stands for a value that is not there.
pub(super) const MISSING: &str = "—";

/// Value at a path of keys.
pub(super) fn at<'a>(root: &'a Value, path: &[&str]) -> Option<&'a Value> {
    path.iter().try_fold(root, |value, key| value.get(key)).filter(|value| !value.is_null())
}

/// Number at a path.
pub(super) fn number(root: &Value, path: &[&str]) -> Option<f64> {
    at(root, path)?.as_f64().filter(|v| v.is_finite())
}

/// Elements of the list at a path; none where there is no list.
pub(super) fn list<'a>(root: &'a Value, path: &[&str]) -> &'a [Value] {
    at(root, path).and_then(Value::as_array).map_or(&[], Vec::as_slice)
}

/// Any value as escaped text, numbers with four digits.
pub(super) fn show(value: Option<&Value>) -> String {
    match value {
        None | Some(Value::Null) => MISSING.to_owned(),
        Some(Value::String(text)) if text.trim().is_empty() => MISSING.to_owned(),
        Some(Value::String(text)) => escape(text),
        Some(Value::Number(n)) => match (n.as_i64(), n.as_f64()) {
            (Some(whole), _) => grouped(whole),
            (None, Some(real)) => significant(real, 4),
            _ => escape(&n.to_string()),
        },
        Some(Value::Bool(true)) => "yes".to_owned(),
        Some(Value::Bool(false)) => "no".to_owned(),
        Some(Value::Array(items)) => items.iter().map(|item| show(Some(item))).collect::<Vec<_>>().join(", "),
        Some(Value::Object(entries)) => entries
            .iter()
            .map(|(key, item)| format!("{} {}", escape(&key.replace('_', " ")), show(Some(item))))
            .collect::<Vec<_>>()
            .join(", "),
    }
}

/// A whole number, from five digits on in groups of three.
fn grouped(value: i64) -> String {
    let digits = value.unsigned_abs().to_string();
    let sign = if value < 0 { "−" } else { "" };
    if digits.len() < 5 {
        return format!("{sign}{digits}");
    }
    let mut text = sign.to_owned();
    for (place, digit) in digits.chars().enumerate() {
        if place > 0 && (digits.len() - place).is_multiple_of(3) {
            text.push('\u{202f}');
        }
        text.push(digit);
    }
    text
}

/// Text of the value at a path.
pub(super) fn text(root: &Value, path: &[&str]) -> String {
    show(at(root, path))
}

/// Number at a path with `digits` digits and its unit; `—` alone where there is none.
pub(super) fn quantity(root: &Value, path: &[&str], digits: usize, unit: &str) -> String {
    with_unit(number(root, path), digits, unit)
}

/// A number with `digits` digits and its unit; `—` alone for none.
pub(super) fn with_unit(value: Option<f64>, digits: usize, unit: &str) -> String {
    match value.filter(|v| v.is_finite()) {
        Some(value) if unit.is_empty() => significant(value, digits),
        Some(value) => format!("{}\u{202f}{unit}", significant(value, digits)),
        None => MISSING.to_owned(),
    }
}

/// A time in seconds, or in milliseconds or microseconds where that reads better.
pub(super) fn duration(seconds: Option<f64>) -> String {
    match seconds {
        Some(s) if s > 0.0 && s < 1e-3 => with_unit(Some(s * 1e6), 3, "µs"),
        Some(s) if s > 0.0 && s < 0.5 => with_unit(Some(s * 1e3), 3, "ms"),
        Some(s) if s >= 600.0 => with_unit(Some(s / 60.0), 3, "min"),
        other => with_unit(other, 3, "s"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn missing_reads_as_a_dash() {
        let root = json!({"a": {"b": null, "c": "x"}, "n": 0.012345});
        assert_eq!(text(&root, &["a", "b"]), MISSING);
        assert_eq!(text(&root, &["a", "c", "d"]), MISSING);
        assert_eq!(quantity(&root, &["a"], 3, "m"), MISSING);
        assert_eq!(quantity(&root, &["n"], 3, "m"), "0.0123\u{202f}m");
        assert!(list(&root, &["n"]).is_empty());
        assert_eq!(text(&Value::Null, &["x"]), MISSING);
    }

    #[test]
    fn long_whole_numbers_are_grouped() {
        assert_eq!(grouped(240_000), "240\u{202f}000");
        assert_eq!(grouped(-6000), "−6000");
        assert_eq!(grouped(1_234_567), "1\u{202f}234\u{202f}567");
    }

    #[test]
    fn durations_choose_their_unit() {
        assert_eq!(duration(Some(2.5e-4)), "250\u{202f}µs");
        assert_eq!(duration(Some(0.02)), "20\u{202f}ms");
        assert_eq!(duration(Some(1200.0)), "20\u{202f}min");
        assert_eq!(duration(None), MISSING);
    }
}
