//! Recordings as a table of plain text, 100 columns at most for usual names.

use crate::record::{figures, shortest};
use serde_json::Value;
use std::fmt::Write as _;

const HEAD: [&str; 9] =
    ["", "channel", "stored in", "PGA m/s²", "PGV m/s", "PGD m", "Arias m/s", "D5-95 s", "band Hz"];
/// Columns that are numbers and stand at the right of their column.
const NUMBERS: std::ops::Range<usize> = 3..9;
/// Letters of a unit that are shown.
const STORED: usize = 22;
/// Width that is not to be left.
const WIDTH: usize = 100;

/// A block per recording: what was found, then a line per component with its measures.
pub(super) fn table(summaries: &[Value]) -> String {
    if summaries.is_empty() {
        return String::new();
    }
    let blocks: Vec<Vec<[String; 9]>> = summaries.iter().map(rows).collect();
    let width: [usize; 9] = std::array::from_fn(|i| {
        let rows = blocks.iter().flatten().map(|row| row[i].chars().count());
        rows.chain([HEAD[i].chars().count()]).max().unwrap_or(0)
    });
    let mut text = line(&HEAD.map(String::from), &width);
    for (summary, rows) in summaries.iter().zip(&blocks) {
        text.push_str(&heading(summary));
        rows.iter().for_each(|row| text.push_str(&line(row, &width)));
    }
    text
}

fn line(cells: &[String; 9], width: &[usize; 9]) -> String {
    let mut text = String::new();
    for (i, cell) in cells.iter().enumerate() {
        let pad = " ".repeat(width[i] - cell.chars().count());
        let gap = if i == 0 { "  " } else { " " };
        let _ = match NUMBERS.contains(&i) {
            true => write!(text, "{gap}{pad}{cell}"),
            false => write!(text, "{gap}{cell}{pad}"),
        };
    }
    format!("{}\n", text.trim_end())
}

/// Name, size, time, files and formats, steps; one line each as far as there is something to say.
fn heading(summary: &Value) -> String {
    let npts = summary["npts"].as_u64().unwrap_or(0);
    let start = summary["start"].as_str().map_or_else(|| "start unknown".to_owned(), |s| format!("from {s}"));
    let mut text = format!(
        "{}: {npts} samples, step {} s, 0 to {} s, {start}\n",
        summary["name"].as_str().unwrap_or("record"),
        plain(&summary["dt"]),
        plain(&summary["duration"]),
    );
    let channels = summary["channels"].as_array().map_or(&[][..], Vec::as_slice);
    let mut files: Vec<(&str, &str)> = vec![];
    for c in channels {
        let file = (c["file"].as_str().unwrap_or(""), c["format"].as_str().unwrap_or(""));
        if !files.contains(&file) {
            files.push(file);
        }
    }
    for (file, format) in files {
        let _ = writeln!(text, "{}", shortened(&format!("  {file}"), &format!(" ({format})")));
    }
    let stated =
        |c: &Value| Some(format!("{} {}°", c["axis"].as_str()?, shortest(c["azimuth_deg"].as_f64()?)));
    let azimuths: Vec<String> = channels.iter().filter_map(stated).collect();
    if !azimuths.is_empty() {
        let _ = writeln!(text, "  azimuth in the file: {}", azimuths.join(", "));
    }
    let steps = summary["motion"]["process"].as_array().map_or(&[][..], Vec::as_slice);
    let steps: Vec<String> = steps.iter().map(words).collect();
    let steps = if steps.is_empty() { "nothing done".to_owned() } else { steps.join(", ") };
    for (number, row) in wrapped(&steps, WIDTH - 4).iter().enumerate() {
        let _ = writeln!(text, "  {}{row}", if number == 0 { "" } else { "  " });
    }
    text
}

/// A step as it is asked for: `filter f_min=0.1 f_max=25`.
fn words(step: &Value) -> String {
    let mut text = step["step"].as_str().unwrap_or("step").to_owned();
    for (key, value) in step.as_object().into_iter().flatten().filter(|(key, _)| *key != "step") {
        let shown = match value {
            Value::String(word) => word.clone(),
            Value::Number(_) => plain(value),
            Value::Bool(true) => "true".to_owned(),
            // Switches that are off and options that are not given say nothing.
            Value::Bool(false) | Value::Null => continue,
            Value::Array(items) => {
                format!("[{}]", items.iter().map(plain).collect::<Vec<_>>().join(","))
            }
            Value::Object(table) => spectrum(table),
        };
        let _ = write!(text, " {key}={shown}");
    }
    text
}

/// A target spectrum by its kind and level: `rg160, pga 2 m/s²`.
fn spectrum(table: &serde_json::Map<String, Value>) -> String {
    let number = |key: &str| table.get(key).filter(|value| value.is_number()).map(plain);
    let kind = table.get("kind").and_then(Value::as_str).unwrap_or("table");
    let level = number("pga").map(|pga| format!(", pga {pga} m/s²"));
    let level = level.or_else(|| number("ag").map(|ag| format!(", ag {ag} m/s²")));
    let damping = number("damping").map(|damping| format!(", damping {damping}"));
    format!("({kind}{}{})", level.unwrap_or_default(), damping.unwrap_or_default())
}

fn rows(summary: &Value) -> Vec<[String; 9]> {
    let channels = summary["channels"].as_array().map_or(&[][..], Vec::as_slice);
    let of = |c: &Value| {
        let axis = c["axis"].as_str().unwrap_or("");
        let m = &summary["measures"][axis];
        let band = match (m["band"][0].as_f64(), m["band"][1].as_f64()) {
            (Some(low), Some(high)) => format!("{}–{}", figures(low, 3), figures(high, 3)),
            _ => String::new(),
        };
        let number = |key: &str| m[key].as_f64().map_or_else(String::new, |x| figures(x, 4));
        let stored = c["unit_stored"].as_str().unwrap_or("");
        let by = if c["unit_given_by"] == "user" { " (given)" } else { "" };
        [
            axis.to_owned(),
            channel_name(summary, c),
            stored_in(stored, by),
            number("pga"),
            number("pgv"),
            number("pgd"),
            number("arias"),
            number("d5_95"),
            band,
        ]
    };
    channels.iter().map(of).collect()
}

/// The channel's id; where the file names no channel the file; after a rotation the direction and its turn.
fn channel_name(summary: &Value, channel: &Value) -> String {
    let id = channel["id"].as_str().unwrap_or("");
    let axis = channel["axis"].as_str().unwrap_or("");
    let steps = summary["motion"]["process"].as_array().map_or(&[][..], Vec::as_slice);
    let turns =
        steps.iter().filter(|step| step["step"] == "rotate").filter_map(|step| step["angle"].as_f64());
    let turned: Vec<f64> = turns.collect();
    if !turned.is_empty() && axis != "z" {
        return format!("{axis} rotated by {}°", shortest(turned.iter().sum()));
    }
    if id == "...CH" {
        let file = std::path::Path::new(channel["file"].as_str().unwrap_or("")).file_stem();
        return file.map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
    }
    id.to_owned()
}

/// The unit in the file's words, cut where they are many.
fn stored_in(stored: &str, by: &str) -> String {
    if stored.chars().count() <= STORED {
        return format!("{stored}{by}");
    }
    let kept: String = stored.chars().take(STORED - 1).collect();
    format!("{}…{by}", kept.trim_end())
}

/// The warnings of a recording, each with the recording's name.
pub(super) fn warnings(summary: &Value) -> Vec<String> {
    let name = summary["name"].as_str().unwrap_or("record");
    let warnings = summary["warnings"].as_array().map_or(&[][..], Vec::as_slice);
    warnings.iter().filter_map(Value::as_str).map(|w| format!("warning: {name}: {w}\n")).collect()
}

/// A number as short as it is.
fn plain(value: &Value) -> String {
    value.as_f64().map_or_else(|| value.to_string(), shortest)
}

/// `head` and `tail` on one line, dots in the head's middle where it would be too long.
fn shortened(head: &str, tail: &str) -> String {
    let letters: Vec<char> = head.chars().collect();
    let room = WIDTH.saturating_sub(tail.chars().count());
    if letters.len() <= room {
        return format!("{head}{tail}");
    }
    let first: String = letters[..room / 3].iter().collect();
    let last: String = letters[letters.len() - (room - room / 3 - 1)..].iter().collect();
    format!("{first}…{last}{tail}")
}

/// Lines of at most `width` letters, broken at spaces.
fn wrapped(text: &str, width: usize) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in text.split(' ') {
        let line = lines.last().map_or(0, |l| l.chars().count());
        if line > 0 && line + 1 + word.chars().count() > width {
            lines.push(String::new());
        }
        if let Some(line) = lines.last_mut() {
            if !line.is_empty() {
                line.push(' ');
            }
            line.push_str(word);
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_names_keep_both_ends() {
        let name = shortened(&"a/".repeat(90), "end.sac (SAC)");
        assert_eq!(name.chars().count(), WIDTH);
        assert!(name.ends_with("end.sac (SAC)") && name.contains('…'));
    }

    #[test]
    fn long_lists_are_wrapped() {
        assert!(wrapped(&"step, ".repeat(60), 96).iter().all(|line| line.chars().count() <= 96));
    }
}
