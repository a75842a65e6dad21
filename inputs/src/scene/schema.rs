//! The format's JSON Schema and its reference page, both made from the types.

use schemars::generate::SchemaSettings;
use serde_json::{Map, Value};

use super::types::Scene;

/// JSON Schema (draft 2020-12) of the scene file.
///
/// Beside the standard words, `x-unit` names a number's unit (`"1"` for none) and `x-default` says in words what stands
/// for a key that is left out. What spans several keys (vs against vp, stations against the column) is beyond a schema:
/// [`super::load`] checks it.
pub fn schema() -> Value {
    let mut schema =
        SchemaSettings::draft2020_12().into_generator().into_root_schema_for::<Scene>().to_value();
    without_null(&mut schema);
    schema
}

/// TOML has no null: a key that may be left out is not required, and that is all.
fn without_null(schema: &mut Value) {
    match schema {
        Value::Array(list) => list.iter_mut().for_each(without_null),
        Value::Object(map) => {
            if let Some(Value::Array(types)) = map.get_mut("type") {
                types.retain(|t| t != "null");
                if let [only] = types.as_slice() {
                    let only = only.clone();
                    map.insert("type".to_owned(), only);
                }
            }
            if let Some(Value::Array(choices)) = map.get_mut("anyOf") {
                choices.retain(|c| c.get("type").is_none_or(|t| t != "null"));
                if let [Value::Object(only)] = choices.as_slice() {
                    let only = only.clone();
                    map.shift_remove("anyOf");
                    for (key, value) in only {
                        map.entry(key).or_insert(value);
                    }
                }
            }
            map.values_mut().for_each(without_null);
        }
        _ => {}
    }
}

/// The scene reference in Markdown: for each section a table of key, value, default and meaning.
pub fn reference_markdown() -> String {
    let schema = schema();
    let mut page =
        Page { defs: schema.get("$defs").and_then(Value::as_object), out: INTRODUCTION.to_owned() };
    let root = page.members(&schema);
    page.out.push_str("\n## The file's head\n\n");
    page.section(&root, "");
    page.out
}

const INTRODUCTION: &str = "\
# The scene file

A scene is a TOML file. All values are in SI units. Keys that are not listed here are refused, so that a slip of the
pen is not taken for a default. A value with default `\"auto\"` is chosen by the program, which says what it chose and
why in `scene.resolved.toml`.

Messages and `--set` write a key with points and count list entries from 1: `soil.layer[2].vs`. An override on the
command line is checked like the file: `--set accuracy=1e-3 --set 'soil.layer[2].vs=300'`. Where only one of two keys
may be given (`vp` or `nu`, `damping` or `q`, `factor` or `pga`), an override of one takes the place of the other.

A scene without `[domain]` is a column of soil under a motion: `motion` and `soil` make it. With `[domain]` the ground
has two or three dimensions and is moved by sources: `domain`, `soil` (or `material` for a mesh), `source` and `run`
make it. What belongs to the one is refused in the other. Axes: x and y horizontal, z up, the flat surface at z = 0.

This page is made from the program's own types.
";

/// One key of a section.
struct Member<'s> {
    name: &'s str,
    schema: &'s Value,
    required: bool,
    /// For a key of one variant only: the variant's `kind`.
    only: Option<&'s str>,
}

struct Page<'s> {
    defs: Option<&'s Map<String, Value>>,
    out: String,
}

fn text<'s>(schema: &'s Value, key: &str) -> Option<&'s str> {
    schema.get(key).and_then(Value::as_str)
}

fn list<'s>(schema: &'s Value, key: &str) -> &'s [Value] {
    schema.get(key).and_then(Value::as_array).map_or(&[], Vec::as_slice)
}

/// The alternatives of a schema, if it has any.
fn choices(schema: &Value) -> &[Value] {
    match list(schema, "oneOf") {
        [] => list(schema, "anyOf"),
        some => some,
    }
}

/// What a description says in words; equations stand in its further paragraphs.
fn first_paragraph(schema: &Value) -> &str {
    let text = text(schema, "description").unwrap_or_default();
    text.split("\n\n").next().unwrap_or_default()
}

/// Text on one line, fit for a cell of a table.
fn cell(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ").replace('|', "\\|")
}

impl<'s> Page<'s> {
    /// The definition that a schema refers to, or the schema itself.
    fn target(&self, schema: &'s Value) -> &'s Value {
        text(schema, "$ref")
            .and_then(|r| r.strip_prefix("#/$defs/"))
            .and_then(|name| self.defs?.get(name))
            .unwrap_or(schema)
    }

    /// The keys of a table; those of all its variants where it has several.
    fn members(&self, schema: &'s Value) -> Vec<Member<'s>> {
        let schema = self.target(schema);
        let variants = choices(schema);
        // A table that has keys of its own says by its alternatives which of them go together.
        if variants.is_empty() || schema.get("properties").is_some() {
            return self.own_members(schema, None);
        }
        let mut all: Vec<Member<'s>> = Vec::new();
        for variant in variants {
            let variant = self.target(variant);
            let only = variant.pointer("/properties/kind/const").and_then(Value::as_str);
            for mut member in self.own_members(variant, only) {
                if member.name == "kind" {
                    member.only = None;
                }
                // Of keys that exclude each other none is required alone.
                member.required &= only.is_some();
                if !all.iter().any(|m| m.name == member.name) {
                    all.push(member);
                }
            }
        }
        all
    }

    fn own_members(&self, schema: &'s Value, only: Option<&'s str>) -> Vec<Member<'s>> {
        let required = list(schema, "required");
        let properties = schema.get("properties").and_then(Value::as_object);
        let members = properties.into_iter().flatten();
        members
            .map(|(name, schema)| Member { name, schema, required: required.iter().any(|r| r == name), only })
            .collect()
    }

    /// The definition of a key that has a section of its own, and whether it is a list of such.
    fn subsection(&self, schema: &'s Value) -> Option<(&'s Value, bool)> {
        let own = |schema: &'s Value| {
            let target = self.target(schema);
            let table = target.get("properties").is_some() || target.get("x-section").is_some();
            table.then_some(target)
        };
        own(schema).map(|t| (t, false)).or_else(|| Some((own(schema.get("items")?)?, true)))
    }

    /// The table of a section's keys, then its subsections.
    fn section(&mut self, members: &[Member<'s>], path: &str) {
        self.out.push_str("| key | value | default | meaning |\n|---|---|---|---|\n");
        for m in members {
            let row = format!(
                "| `{}` | {} | {} | {} |\n",
                m.name,
                cell(&self.value(m, path)),
                cell(&self.default(m)),
                cell(&self.meaning(m))
            );
            self.out.push_str(&row);
        }
        let mut done: Vec<&Value> = Vec::new();
        for m in members {
            let Some((target, is_list)) = self.subsection(m.schema) else {
                continue;
            };
            if done.iter().any(|d| std::ptr::eq(*d, target)) {
                continue;
            }
            done.push(target);
            let twins: Vec<String> = members
                .iter()
                .filter(|o| self.subsection(o.schema).is_some_and(|(t, _)| std::ptr::eq(t, target)))
                .map(|o| heading(path, o.name, is_list))
                .collect();
            let intro = cell(first_paragraph(target));
            self.out.push_str(&format!("\n## {}\n\n{intro}\n", twins.join(", ")));
            if choices(target).iter().any(|v| v.pointer("/properties/step/const").is_some()) {
                self.steps(choices(target));
                continue;
            }
            self.out.push('\n');
            let inner = self.members(target);
            self.section(&inner, &super::document::join(path, m.name));
        }
    }

    /// A table of keys for each step of a list.
    fn steps(&mut self, variants: &'s [Value]) {
        for variant in variants {
            let word = variant.pointer("/properties/step/const").and_then(Value::as_str).unwrap_or_default();
            let mut members = self.own_members(variant, None);
            members.retain(|m| m.name != "step");
            let intro = cell(first_paragraph(variant));
            self.out.push_str(&format!("\n### `step = \"{word}\"`\n\n{intro}\n"));
            if members.is_empty() {
                continue;
            }
            self.out.push('\n');
            self.section(&members, "");
        }
    }

    /// What a key takes: its type, words, unit and range.
    fn value(&self, m: &Member<'s>, path: &str) -> String {
        let variants = self.variants_of(m);
        if !variants.is_empty() {
            let words: Vec<String> = variants.iter().map(kind_word).collect();
            return words.join(" or ");
        }
        if let Some((_, is_list)) = self.subsection(m.schema) {
            return format!("{} below", heading(path, m.name, is_list));
        }
        let mut value = self.type_text(m.schema);
        let unit = text(m.schema, "x-unit").filter(|u| *u != "1");
        if let Some(unit) = unit {
            value.push_str(&format!(", {unit}"));
        }
        let range = range(m.schema);
        if !range.is_empty() {
            value.push_str(&format!(", {range}"));
        }
        value
    }

    /// The variants that a key `kind` tells apart; none for any other key.
    fn variants_of(&self, m: &Member<'s>) -> &'s [Value] {
        if m.name != "kind" || m.schema.get("const").is_none() {
            return &[];
        }
        let kind = |variant: &'s Value| variant.pointer("/properties/kind");
        self.defs
            .into_iter()
            .flat_map(|defs| defs.values())
            .map(choices)
            .find(|all| all.iter().filter_map(kind).any(|k| std::ptr::eq(k, m.schema)))
            .unwrap_or_default()
    }

    fn type_text(&self, schema: &'s Value) -> String {
        let schema = self.target(schema);
        if let Some(value) = schema.get("const") {
            return format!("`{value}`");
        }
        let words = list(schema, "enum");
        if !words.is_empty() {
            let words: Vec<String> = words.iter().map(|w| format!("`{w}`")).collect();
            return words.join(" or ");
        }
        let variants = choices(schema);
        if !variants.is_empty() {
            let all: Vec<String> = variants.iter().map(|v| self.type_text(v)).collect();
            return all.join(" or ");
        }
        match text(schema, "type") {
            Some("string") => "text".to_owned(),
            Some("number") => "number".to_owned(),
            Some("integer") => "whole number".to_owned(),
            Some("boolean") => "`true` or `false`".to_owned(),
            Some("array") => self.array_text(schema),
            Some("object") if schema.get("additionalProperties").is_some_and(Value::is_object) => {
                let inner = schema.get("additionalProperties").map(|s| self.type_text(s));
                format!("a table of names, each {}", inner.unwrap_or_default())
            }
            Some("object") => {
                let inner: Vec<String> = self
                    .members(schema)
                    .iter()
                    .map(|m| format!("{} = {}", m.name, self.type_text(m.schema).replace('`', "")))
                    .collect();
                format!("`{{ {} }}`", inner.join(", "))
            }
            _ => "value".to_owned(),
        }
    }

    fn array_text(&self, schema: &'s Value) -> String {
        let entry = schema.get("items").map_or_else(|| "value".to_owned(), |i| self.type_text(i));
        let count = schema.get("maxItems").filter(|n| schema.get("minItems") == Some(n));
        match count {
            // words are not put into the plural
            _ if entry.ends_with('`') => format!("list of {entry}"),
            Some(n) => format!("list of {n} {entry}s"),
            None => format!("list of {entry}s"),
        }
    }

    fn default(&self, m: &Member<'s>) -> String {
        if let Some(words) = text(m.schema, "x-default") {
            return words.to_owned();
        }
        match m.schema.get("default") {
            Some(Value::Object(_)) => "as its keys".to_owned(),
            Some(value) => format!("`{value}`"),
            None if m.required => "required".to_owned(),
            None => "—".to_owned(),
        }
    }

    /// The text of a key and of each of its words.
    fn meaning(&self, m: &Member<'s>) -> String {
        let target = self.target(m.schema);
        let own = text(m.schema, "description").unwrap_or_default();
        let mut meaning = match m.only {
            Some(kind) => format!("(`{kind}` only) {own}"),
            None => own.to_owned(),
        };
        if self.subsection(m.schema).is_some() {
            return meaning;
        }
        let mut explain = |word: String, variant: &Value| {
            if let Some(described) = text(variant, "description") {
                meaning.push_str(&format!(" {word}: {};", described.trim_end_matches('.')));
            }
        };
        for variant in self.variants_of(m) {
            explain(kind_word(variant), variant);
        }
        let words = choices(target);
        // What `"auto"` means is said once, and a long list of units explains itself.
        if !is_auto(target) && words.len() <= 4 {
            for variant in words {
                let kind = variant.pointer("/properties/kind/const").is_some();
                explain(if kind { kind_word(variant) } else { self.type_text(variant) }, variant);
            }
        }
        if meaning.ends_with(';') {
            meaning.pop();
            meaning.push('.');
        }
        meaning
    }
}

/// True for the two-way choice of `"auto"` or a value, whose words need no explanation at each key.
fn is_auto(schema: &Value) -> bool {
    let variants = choices(schema);
    variants.len() == 2 && variants.iter().any(|v| v.get("const").is_some_and(|c| c == "auto"))
}

/// The word of a variant's `kind`, as it is written.
fn kind_word(variant: &Value) -> String {
    let word = variant.pointer("/properties/kind/const").and_then(Value::as_str);
    format!("`\"{}\"`", word.unwrap_or_default())
}

fn heading(path: &str, name: &str, is_list: bool) -> String {
    let path = super::document::join(path, name);
    if is_list { format!("`[[{path}]]`") } else { format!("`[{path}]`") }
}

/// A number's range in words.
fn range(schema: &Value) -> String {
    if schema.get("const").is_some() {
        return String::new();
    }
    let limit = |key: &str| {
        let limit = schema.get(key).and_then(Value::as_f64);
        limit.map(super::diagnostic::rounded)
    };
    if let (Some(from), Some(to)) = (limit("minimum"), limit("maximum")) {
        return format!("from {from} to {to}");
    }
    let words = [
        ("exclusiveMinimum", "above"),
        ("minimum", "at least"),
        ("maximum", "at most"),
        ("exclusiveMaximum", "below"),
    ];
    let parts: Vec<String> =
        words.into_iter().filter_map(|(key, word)| Some(format!("{word} {}", limit(key)?))).collect();
    parts.join(", ")
}
