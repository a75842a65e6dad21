//! A TOML text as a tree that knows where each of its values stands, and overrides put into it.
//!
//! The parser goes on after a syntax error, so that one slip does not hide the rest; a value that it touches is kept
//! as [`Value::Broken`] and draws no second message.

use std::ops::Range;

use toml::de::{DeTable, DeValue};

use super::diagnostic::{Diagnostic, Severity};

/// File name under which overrides are reported.
pub(super) const OVERRIDE: &str = "--set";

/// Where a key or value was written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Origin {
    /// Byte offset in the file.
    File(usize),
    /// An override.
    Override,
}

/// A value with its place.
#[derive(Debug, Clone)]
pub(super) struct Node {
    /// The value.
    pub(super) value: Value,
    /// Place of its key; for an entry of a list that of the value.
    pub(super) at: Origin,
}

/// A TOML value.
#[derive(Debug, Clone)]
pub(super) enum Value {
    String(String),
    Integer(i64),
    Float(f64),
    Boolean(bool),
    Datetime(String),
    List(Vec<Node>),
    Table(Table),
    /// Touched by a syntax error that has been reported.
    Broken,
}

impl Value {
    /// The value in words, for messages: `the string "abc"`, `a table`.
    pub(super) fn describe(&self) -> String {
        match self {
            Self::String(s) if s.chars().count() > 60 => {
                let head: String = s.chars().take(57).collect();
                format!("the string {head:?}…")
            }
            Self::String(s) => format!("the string {s:?}"),
            Self::Integer(i) => format!("the number {i}"),
            Self::Float(x) => format!("the number {x}"),
            Self::Boolean(b) => format!("{b}"),
            Self::Datetime(d) => format!("the date {d}"),
            Self::List(_) => "a list".to_owned(),
            Self::Table(_) => "a table".to_owned(),
            Self::Broken => "a broken value".to_owned(),
        }
    }

    /// The same value in JSON; a date or a broken value is null.
    pub(super) fn to_json(&self) -> serde_json::Value {
        match self {
            Self::String(s) => s.as_str().into(),
            Self::Integer(i) => (*i).into(),
            Self::Float(x) => (*x).into(),
            Self::Boolean(b) => (*b).into(),
            Self::List(list) => list.iter().map(|node| node.value.to_json()).collect(),
            Self::Table(table) => {
                let entries = table.entries.iter().map(|(key, node)| (key.clone(), node.value.to_json()));
                serde_json::Value::Object(entries.collect())
            }
            Self::Datetime(_) | Self::Broken => serde_json::Value::Null,
        }
    }
}

/// Keys with their values, sorted by key.
#[derive(Debug, Clone, Default)]
pub(super) struct Table {
    pub(super) entries: Vec<(String, Node)>,
}

impl Table {
    /// The value of a key.
    pub(super) fn get(&self, key: &str) -> Option<&Node> {
        self.entries.iter().find(|(k, _)| k == key).map(|(_, n)| n)
    }

    fn position(&self, key: &str) -> Option<usize> {
        self.entries.iter().position(|(k, _)| k == key)
    }
}

/// Joins a table's path and a key.
pub(super) fn join(path: &str, key: &str) -> String {
    if path.is_empty() { key.to_owned() } else { format!("{path}.{key}") }
}

/// Turns byte offsets into lines and columns.
#[derive(Debug)]
pub(super) struct Lines<'t> {
    text: &'t str,
    starts: Vec<usize>,
}

impl<'t> Lines<'t> {
    pub(super) fn new(text: &'t str) -> Self {
        let breaks = text.match_indices('\n').map(|(i, _)| i + 1);
        Self { text, starts: std::iter::once(0).chain(breaks).collect() }
    }

    /// Line and column in characters, both counted from 1.
    pub(super) fn place(&self, offset: usize) -> (usize, usize) {
        let offset = offset.min(self.text.len());
        let line = self.starts.partition_point(|s| *s <= offset);
        let start = self.starts[line - 1];
        let column = self
            .text
            .get(start..offset)
            .map_or(offset - start, |head| head.trim_start_matches('\u{feff}').chars().count());
        (line, column + 1)
    }
}

/// A parsed text: its tree, and what the parser had to say.
pub(super) struct Document {
    pub(super) root: Table,
    pub(super) errors: Vec<Diagnostic>,
}

/// A syntax error of the parser and the key whose value it touches.
struct Slip {
    span: Range<usize>,
    message: String,
    key_path: String,
}

/// Parses a scene's text. Never fails: what could not be read is in `errors`.
pub(super) fn parse(file: &str, text: &str, lines: &Lines<'_>) -> Document {
    let (root, errors) = DeTable::parse_recoverable(text);
    let mut slips: Vec<Slip> = errors
        .iter()
        .map(|e| Slip {
            span: e.span().unwrap_or(0..0),
            message: e.message().to_owned(),
            key_path: String::new(),
        })
        .collect();
    let root = convert_table(root.get_ref(), "", &mut slips);
    let mut errors: Vec<Diagnostic> = Vec::with_capacity(slips.len());
    for slip in slips {
        let (line, column) = lines.place(slip.span.start);
        let found = text.get(slip.span.clone()).unwrap_or_default();
        let found = found.lines().next().unwrap_or_default();
        let quote = if found.is_empty() {
            String::new()
        } else {
            format!(", found `{}`", found.chars().take(40).collect::<String>())
        };
        errors.push(Diagnostic {
            severity: Severity::Error,
            file: file.to_owned(),
            line: Some(line),
            column: Some(column),
            key_path: slip.key_path,
            help: syntax_help(&slip.message, found),
            message: format!("TOML syntax: {}{quote}", slip.message),
        });
    }
    // Deep nesting draws the same message for every level; the first says it.
    errors.dedup_by(|b, a| a.line == b.line && a.message == b.message);
    Document { root, errors }
}

fn syntax_help(message: &str, found: &str) -> Option<String> {
    if message.contains("must be quoted") {
        let word = found.trim();
        let number = word.split_whitespace().next().is_some_and(|w| w.parse::<f64>().is_ok());
        Some(if word.is_empty() {
            "give a value after the equals sign".to_owned()
        } else if number {
            "write the number alone, without its unit; text needs quotes".to_owned()
        } else {
            format!("a word needs quotes (\"{word}\"), a number digits only")
        })
    } else if message.contains("invalid mantissa") {
        Some("write a digit before the point: 0.5, not .5".to_owned())
    } else if message.contains("duplicate key") {
        Some("keep one of the two".to_owned())
    } else {
        None
    }
}

fn convert_table(table: &DeTable<'_>, path: &str, slips: &mut [Slip]) -> Table {
    let entries = table
        .iter()
        .map(|(key, value)| {
            let name = key.get_ref().to_string();
            let value = convert(value.get_ref(), value.span(), &join(path, &name), slips);
            let at = Origin::File(key.span().start);
            (name, Node { value, at })
        })
        .collect();
    Table { entries }
}

fn convert(value: &DeValue<'_>, span: Range<usize>, path: &str, slips: &mut [Slip]) -> Value {
    match value {
        DeValue::Table(t) => Value::Table(convert_table(t, path, slips)),
        DeValue::Array(a) => Value::List(
            a.iter()
                .enumerate()
                .map(|(i, entry)| {
                    let path = format!("{path}[{}]", i + 1);
                    let value = convert(entry.get_ref(), entry.span(), &path, slips);
                    let at = Origin::File(entry.span().start);
                    Node { value, at }
                })
                .collect(),
        ),
        leaf => {
            if mark_touched(&span, path, slips) {
                Value::Broken
            } else {
                convert_leaf(leaf)
            }
        }
    }
}

/// Writes a leaf's path into the slips that touch it; true where there is one.
fn mark_touched(span: &Range<usize>, path: &str, slips: &mut [Slip]) -> bool {
    let mut touched = false;
    for slip in slips.iter_mut().filter(|s| s.key_path.is_empty()) {
        if slip.span.start <= span.end && slip.span.end >= span.start {
            path.clone_into(&mut slip.key_path);
            touched = true;
        }
    }
    touched
}

fn convert_leaf(value: &DeValue<'_>) -> Value {
    match value {
        DeValue::String(s) => Value::String(s.to_string()),
        DeValue::Integer(i) => i64::from_str_radix(i.as_str(), i.radix()).map_or_else(
            // Beyond 64 bits; as a float it still says how large it is.
            |_| Value::Float(i.as_str().parse().unwrap_or(f64::INFINITY)),
            Value::Integer,
        ),
        DeValue::Float(x) => x.as_str().parse().map_or(Value::Broken, Value::Float),
        DeValue::Boolean(b) => Value::Boolean(*b),
        DeValue::Datetime(d) => Value::Datetime(d.to_string()),
        DeValue::Array(_) | DeValue::Table(_) => Value::Broken,
    }
}

/// One step of an override's key: a name and, for an entry of a list, its number counted from 1.
struct Step<'k> {
    name: &'k str,
    index: Option<usize>,
}

fn steps(key: &str) -> Option<Vec<Step<'_>>> {
    key.split('.')
        .map(|part| {
            let (name, index) = match part.split_once('[') {
                None => (part, None),
                Some((name, rest)) => {
                    let index: usize = rest.strip_suffix(']')?.trim().parse().ok()?;
                    (name, Some(index))
                }
            };
            let name = name.trim();
            let word = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
            (!name.is_empty() && name.chars().all(word)).then_some(Step { name, index })
        })
        .collect()
}

/// Keys that exclude each other: an override of one takes the place of the other.
const ALTERNATIVES: &[&[&str]] = &[
    &["vp", "nu"],
    &["damping", "q"],
    &["damping_p", "q_p"],
    &["factor", "pga", "pgv", "sa"],
    &["file", "wavelet"],
    &["unit", "metadata"],
];

/// Most names in an override's key; the longest of the format has four.
const MAX_STEPS: usize = 8;

fn override_error(key: &str, message: String, help: Option<String>) -> Diagnostic {
    Diagnostic {
        severity: Severity::Error,
        file: OVERRIDE.to_owned(),
        line: None,
        column: None,
        key_path: key.to_owned(),
        message,
        help,
    }
}

/// Puts one override into the tree: `key` as in messages (`soil.layer[2].vs`), `value` in TOML, a bare word as a string.
pub(super) fn set(root: &mut Table, key: &str, value: &str) -> Result<(), Box<Diagnostic>> {
    let fail =
        |message: String, help: Option<&str>| Box::new(override_error(key, message, help.map(str::to_owned)));
    let Some(steps) = steps(key.trim()) else {
        return Err(fail(
            format!("{key:?} is not a key"),
            Some("write names joined by points, list entries counted from 1: soil.layer[2].vs=300"),
        ));
    };
    // A longer key would also nest the tree deeper than a stack may hold.
    if steps.len() > MAX_STEPS {
        let message = format!("{} names are deeper than any key of a scene", steps.len());
        return Err(fail(message, None));
    }
    let value = parse_override(value)
        .map_err(|m| fail(m, Some("write the value as in the scene file, with quotes around text")))?;
    insert(root, &steps, value).map_err(|m| fail(m, None))
}

fn parse_override(text: &str) -> Result<Value, String> {
    let text = text.trim();
    match DeValue::parse(text) {
        Ok(value) => Ok(mark_override(convert(value.get_ref(), value.span(), "", &mut []))),
        // On a command line the quotes of a word are easily lost to the shell.
        Err(_) if !text.is_empty() && !text.contains(['"', '\'', '[', ']', '{', '}', '\n', '=']) => {
            Ok(Value::String(text.to_owned()))
        }
        Err(e) => Err(format!("TOML syntax: {}, found `{text}`", e.message())),
    }
}

/// Gives every place inside an override's value the override as its origin.
fn mark_override(value: Value) -> Value {
    let node = |n: Node| Node { value: mark_override(n.value), at: Origin::Override };
    match value {
        Value::List(l) => Value::List(l.into_iter().map(node).collect()),
        Value::Table(t) => {
            Value::Table(Table { entries: t.entries.into_iter().map(|(k, n)| (k, node(n))).collect() })
        }
        leaf => leaf,
    }
}

fn insert(table: &mut Table, steps: &[Step<'_>], value: Value) -> Result<(), String> {
    let Some((step, rest)) = steps.split_first() else {
        return Ok(());
    };
    if rest.is_empty() && step.index.is_none() {
        for alternatives in ALTERNATIVES.iter().filter(|all| all.contains(&step.name)) {
            let other = |key: &str| key != step.name && alternatives.contains(&key);
            table.entries.retain(|(k, n)| !other(k) || n.at == Origin::Override);
        }
    }
    let node = match table.position(step.name) {
        Some(i) => &mut table.entries[i].1,
        None if step.index.is_some() => {
            return Err(format!("there is no list `{}` in the scene", step.name));
        }
        None => {
            let empty = Node { value: Value::Table(Table::default()), at: Origin::Override };
            let i = table.entries.partition_point(|(k, _)| k.as_str() < step.name);
            table.entries.insert(i, (step.name.to_owned(), empty));
            &mut table.entries[i].1
        }
    };
    let node = match step.index {
        None => node,
        Some(index) => entry(node, step.name, index)?,
    };
    if rest.is_empty() {
        *node = Node { value, at: Origin::Override };
        return Ok(());
    }
    match &mut node.value {
        Value::Table(t) => insert(t, rest, value),
        Value::List(l) => Err(format!(
            "`{name}` is a list: say which entry, {name}[1] to {name}[{n}]",
            name = step.name,
            n = l.len()
        )),
        // `band`, `dt` and the like may be a word in the file and a table in the override.
        leaf => {
            let mut fresh = Table::default();
            insert(&mut fresh, rest, value)?;
            *leaf = Value::Table(fresh);
            node.at = Origin::Override;
            Ok(())
        }
    }
}

/// Entry `index`, counted from 1, of a list.
fn entry<'n>(node: &'n mut Node, name: &str, index: usize) -> Result<&'n mut Node, String> {
    let list = match &mut node.value {
        Value::List(list) => list,
        other => return Err(format!("`{name}` is {}, not a list", other.describe())),
    };
    let n = list.len();
    index.checked_sub(1).and_then(|i| list.get_mut(i)).ok_or_else(|| match n {
        0 => format!("`{name}` is an empty list"),
        1 => format!("there is no {name}[{index}]: the list has the one entry {name}[1]"),
        _ => format!("there is no {name}[{index}]: the list goes from {name}[1] to {name}[{n}]"),
    })
}
