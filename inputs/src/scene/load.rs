//! From a file or a text to a checked [`Scene`].

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use super::check;
use super::diagnostic::{Diagnostic, Diagnostics, Severity};
use super::document::{self, Lines, Node, Origin, Table, Value, join};
use super::files;
use super::types::Scene;

/// Largest scene file, bytes. A scene is a page of text; anything beyond is another file by mistake.
const MAX_BYTES: u64 = 4 << 20;

/// Who wrote a key of a scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Written {
    /// The scene's author, on this line of the file (counted from 1).
    File(usize),
    /// An override.
    Override,
}

/// Where a scene came from.
#[derive(Debug, Clone, Default)]
pub struct Source {
    /// File name as it was given.
    pub name: String,
    /// Folder against which the records' paths are taken; empty for the current folder.
    pub folder: PathBuf,
    /// The text as it was read, without overrides.
    pub text: String,
    /// Overrides in the order in which they were applied, key and TOML value.
    pub overrides: Vec<(String, String)>,
    /// Every key that somebody wrote (tables and list entries included), with who did.
    pub written: BTreeMap<String, Written>,
    /// Findings that do not forbid the run.
    pub warnings: Diagnostics,
}

impl Source {
    /// Where a key stands, as a finding begins: `scene.toml:6 motion.process[1].f_max`, `--set motion.band`.
    ///
    /// A key that nobody wrote is looked for in the table or list around it; without any of these the file's name
    /// and the key remain.
    #[must_use]
    pub fn place_of(&self, key: &str) -> String {
        let mut written = key;
        loop {
            match self.written.get(written) {
                Some(Written::File(line)) => return format!("{}:{line} {written}", self.name),
                Some(Written::Override) => return format!("{} {written}", document::OVERRIDE),
                None => match written.rfind(['.', '[']) {
                    Some(end) => written = &written[..end],
                    None => return format!("{} {key}", self.name),
                },
            }
        }
    }
}

/// Reads and checks a scene: `path` is a scene file, or a folder that holds a `scene.toml`.
///
/// Errors: every problem of the scene at once, in the order of its lines, each with line, column and key. Warnings are
/// among them; where there are only warnings the scene is returned and they stand in `scene.source.warnings`.
pub fn load(path: &Path) -> Result<Scene, Diagnostics> {
    load_with(path, &[])
}

/// As [`load`], with overrides (see [`load_str`]).
pub fn load_with(path: &Path, overrides: &[(String, String)]) -> Result<Scene, Diagnostics> {
    let inside = path.join("scene.toml");
    let path = if path.is_dir() && inside.exists() { &inside } else { path };
    let name = path.display().to_string();
    match read_text(path) {
        Ok(text) => load_str(&text, &name, overrides),
        Err((message, help)) => Err(Diagnostics::new(vec![Diagnostic {
            severity: Severity::Error,
            file: name,
            line: None,
            column: None,
            key_path: String::new(),
            message,
            help,
        }])),
    }
}

/// Checks a scene's text.
///
/// - `name`: the file's path as messages shall show it; records are looked for in its folder.
/// - `overrides`: keys as messages write them (`soil.layer[2].vs`, layers counted from 1) with values in TOML, a bare
///   word standing for a string; applied in turn. An override of `vp`, `damping`, `factor`, … takes the place of the
///   `nu`, `q`, `pga`, … of the file, since only one of each pair may be given.
///
/// Errors: as [`load`]; those of an override carry `--set` for a file name and no line. Never panics, whatever the text.
pub fn load_str(text: &str, name: &str, overrides: &[(String, String)]) -> Result<Scene, Diagnostics> {
    let lines = Lines::new(text);
    let mut document = document::parse(name, text, &lines);
    let broken = !document.errors.is_empty();
    for (key, value) in overrides {
        if let Err(e) = document::set(&mut document.root, key, value) {
            document.errors.push(*e);
        }
    }
    let folder = Path::new(name).parent().map(Path::to_path_buf).unwrap_or_default();
    let mut checker = check::Checker::new(name, &lines, &folder, broken);
    let scene = check::scene(&mut checker, &document.root);
    let mut found = document.errors;
    found.append(&mut checker.found);
    let found = Diagnostics::new(found);
    match scene {
        Some(mut scene) if !found.has_errors() => {
            scene.source = Source {
                name: name.to_owned(),
                folder,
                text: text.to_owned(),
                overrides: overrides.to_vec(),
                written: written(&document.root, &lines),
                warnings: found,
            };
            Ok(scene)
        }
        _ => Err(found),
    }
}

/// Every key of the tree with who wrote it.
fn written(root: &Table, lines: &Lines<'_>) -> BTreeMap<String, Written> {
    fn walk(node: &Node, path: String, lines: &Lines<'_>, out: &mut BTreeMap<String, Written>) {
        match &node.value {
            Value::Table(t) => {
                for (key, child) in &t.entries {
                    walk(child, join(&path, key), lines, out);
                }
            }
            Value::List(l) => {
                for (i, child) in l.iter().enumerate() {
                    walk(child, format!("{path}[{}]", i + 1), lines, out);
                }
            }
            _ => {}
        }
        let who = match node.at {
            Origin::File(offset) => Written::File(lines.place(offset).0),
            Origin::Override => Written::Override,
        };
        out.insert(path, who);
    }
    let mut out = BTreeMap::new();
    for (key, node) in &root.entries {
        walk(node, key.clone(), lines, &mut out);
    }
    out
}

/// The text of a scene file, or what is wrong and what to do.
fn read_text(path: &Path) -> Result<String, (String, Option<String>)> {
    let size = files::regular_file(path, "toml").map_err(|e| (e.message, e.help))?;
    if size > MAX_BYTES {
        return Err((
            format!("{size} bytes are too many for a scene (limit {MAX_BYTES})"),
            Some("give the scene's TOML file, not a record or a result".to_owned()),
        ));
    }
    let bytes = std::fs::read(path).map_err(|e| (format!("cannot be read: {e}"), None))?;
    String::from_utf8(bytes).map_err(|e| {
        let good = e.utf8_error().valid_up_to();
        let line = 1 + e.as_bytes()[..good].iter().filter(|b| **b == b'\n').count();
        (
            format!("line {line} holds a byte that is not UTF-8 text"),
            Some("save the file as UTF-8".to_owned()),
        )
    })
}
