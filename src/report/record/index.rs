//! The page of a batch: one line per recording, and what was refused.

use std::fmt::Write as _;
use std::path::Path;

use serde_json::Value;

use super::super::page::document;
use super::super::svg::escape;
use super::super::value::{at, duration, list, number, text, with_unit};
use super::page::instant;
use crate::outputs::{OutputError, replace_bytes};
use crate::results::AXES;

/// A recording of the batch: the folder beside the page, and its `record.json`.
#[derive(Debug)]
pub(crate) struct Row<'a> {
    /// Folder, also the link.
    pub(crate) folder: &'a str,
    /// Content of `record.json`.
    pub(crate) summary: &'a Value,
}

/// Writes `index.html` into `dir`: recordings with links to their pages; refusals as names and texts.
pub(crate) fn write_index(
    dir: &Path,
    rows: &[Row<'_>],
    refused: &[(String, String)],
) -> Result<(), OutputError> {
    let mut html = format!(
        "<header><p class=\"eyebrow\">hati {} · records</p><h1>{} recording{}</h1></header>",
        env!("CARGO_PKG_VERSION"),
        rows.len(),
        if rows.len() == 1 { "" } else { "s" }
    );
    if !refused.is_empty() {
        let items: String = (refused.iter())
            .map(|(_, why)| format!("<li>{}</li>", escape(why).replace("  help:", "<br>help:")))
            .collect();
        let _ = write!(
            html,
            "<section class=\"warnings\" role=\"alert\"><h2>{} refused</h2><ul>{items}</ul></section>",
            refused.len()
        );
    }
    html.push_str(
        "<section class=\"tables dense\"><div class=\"scroll\"><table><thead><tr><th class=\"l\">recording</th>\
         <th class=\"l\">start</th><th>step</th><th>length</th><th class=\"l\">axis</th><th>PGA<br><i>m/s²</i></th>\
         <th>PGV<br><i>m/s</i></th><th>PGD<br><i>m</i></th><th>Arias<br><i>m/s</i></th>\
         <th>D5–95<br><i>s</i></th><th class=\"l\">warnings</th></tr></thead><tbody>",
    );
    rows.iter().for_each(|row| lines(&mut html, row));
    html.push_str("</tbody></table></div></section>");
    let page = document("Records", &html, "SI units; x and y horizontal, z up.");
    replace_bytes(&dir.join("index.html"), page.as_bytes(), false)
}

/// One line per component; what is common stands in the first.
fn lines(html: &mut String, row: &Row<'_>) {
    let Some(measures) = at(row.summary, &["measures"]).and_then(Value::as_object) else { return };
    let axes = AXES.iter().filter_map(|a| measures.get_key_value(a.to_string().as_str()));
    for (number_of_line, (axis, values)) in axes.enumerate() {
        let common = if number_of_line == 0 { common(row) } else { "<td></td>".repeat(4) };
        let cells: String = ["pga", "pgv", "pgd", "arias", "d5_95"]
            .iter()
            .map(|key| format!("<td>{}</td>", with_unit(number(values, &[key]), 4, "")))
            .collect();
        let warnings = match list(row.summary, &["warnings"]).len() {
            0 => String::new(),
            _ if number_of_line > 0 => String::new(),
            count => count.to_string(),
        };
        let _ = write!(
            html,
            "<tr>{common}<td class=\"l\">{}</td>{cells}<td class=\"l\">{warnings}</td></tr>",
            escape(axis)
        );
    }
}

fn common(row: &Row<'_>) -> String {
    format!(
        "<td class=\"l\"><a href=\"{}/report.html\">{}</a></td><td class=\"l\">{}</td><td>{}</td><td>{}</td>",
        link(row.folder),
        text(row.summary, &["name"]),
        instant(&text(row.summary, &["start"])),
        duration(number(row.summary, &["dt"])),
        duration(number(row.summary, &["duration"])),
    )
}

/// A folder's name as part of an address: what is not plain as percent signs and hexadecimal digits.
fn link(folder: &str) -> String {
    let mut text = String::new();
    for byte in folder.bytes() {
        match byte {
            b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' | b'.' | b'-' | b'_' => text.push(char::from(byte)),
            other => text.push_str(&format!("%{other:02X}")),
        }
    }
    text
}
