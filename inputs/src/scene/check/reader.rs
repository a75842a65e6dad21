//! Reading typed values out of the tree, one key at a time, so that each mistake is reported and none hides another.

use std::path::{Path, PathBuf};

use super::super::diagnostic::{Diagnostic, Severity, listed, nearest, plain, with_unit};
use super::super::document::{Lines, Node, OVERRIDE, Origin, Table, Value, join};
use super::super::types::Auto;
use super::super::values::Words;

/// Collects findings; every reading function returns `None` where it has reported an error.
pub(in super::super) struct Checker<'t> {
    file: String,
    lines: &'t Lines<'t>,
    /// Folder of the scene file.
    pub(super) folder: PathBuf,
    /// True after a syntax error: keys may have been lost with it, so missing ones are not reported.
    broken: bool,
    /// What was found so far.
    pub(in super::super) found: Vec<Diagnostic>,
}

/// A key in full and where it stands, for a finding.
#[derive(Debug, Clone)]
pub(in super::super) struct Place {
    pub(in super::super) path: String,
    pub(in super::super) at: Origin,
}

/// A table being read: remembers which keys were asked for, so that the rest can be called unknown.
pub(super) struct Section<'n> {
    table: &'n Table,
    pub(super) place: Place,
    known: Vec<&'static str>,
    /// Required keys that are not there, with what to do.
    missing: Vec<(&'static str, String)>,
}

impl<'n> Section<'n> {
    pub(super) fn root(table: &'n Table) -> Self {
        let place = Place { path: String::new(), at: Origin::File(0) };
        Self::new(table, place)
    }

    pub(super) fn new(table: &'n Table, place: Place) -> Self {
        Self { table, place, known: Vec::new(), missing: Vec::new() }
    }

    /// The value of a key; from here on the key is known.
    pub(super) fn get(&mut self, key: &'static str) -> Option<&'n Node> {
        if !self.known.contains(&key) {
            self.known.push(key);
        }
        self.table.get(key)
    }

    /// True where the scene gives the key, rightly or wrongly.
    pub(super) fn has(&self, key: &str) -> bool {
        self.table.get(key).is_some()
    }

    /// Place of a key, or of the table where it is missing.
    pub(super) fn at(&self, key: &str) -> Place {
        Place { path: join(&self.place.path, key), at: self.table.get(key).map_or(self.place.at, |n| n.at) }
    }

    /// Every key with its value.
    pub(super) fn entries(&self) -> impl Iterator<Item = (&'n str, &'n Node)> + use<'n> {
        self.table.entries.iter().map(|(key, node)| (key.as_str(), node))
    }

    /// Place of the entry `number` (from 1) of a list, or of a key in it where it is written there.
    pub(super) fn in_list(&self, list: &str, number: usize, key: &str) -> Place {
        let place = self.at(list);
        let path = format!("{}[{number}]", place.path);
        let Some(Value::List(entries)) = self.table.get(list).map(|node| &node.value) else {
            return Place { path, ..place };
        };
        let Some(entry) = entries.get(number - 1) else { return Place { path, ..place } };
        match &entry.value {
            Value::Table(table) if table.get(key).is_some() => {
                Place { path: join(&path, key), at: table.get(key).map_or(entry.at, |node| node.at) }
            }
            _ => Place { path, at: entry.at },
        }
    }

    /// Of two keys the one that was written last; an override is later than the file.
    pub(super) fn later<'k>(&self, a: &'k str, b: &'k str) -> &'k str {
        let rank = |key: &str| match self.at(key).at {
            Origin::File(offset) => (0, offset),
            Origin::Override => (1, 0),
        };
        if rank(a) > rank(b) { a } else { b }
    }
}

/// Range of a number; `None` is no limit.
#[derive(Debug, Clone, Copy)]
pub(super) struct Bounds {
    pub(super) unit: &'static str,
    pub(super) above: Option<f64>,
    pub(super) from: Option<f64>,
    pub(super) to: Option<f64>,
    pub(super) below: Option<f64>,
}

impl Bounds {
    /// Any finite number.
    pub(super) const fn any(unit: &'static str) -> Self {
        Self { unit, above: None, from: None, to: None, below: None }
    }

    /// A finite number above zero.
    pub(super) const fn positive(unit: &'static str) -> Self {
        Self { above: Some(0.0), ..Self::any(unit) }
    }

    /// A finite number of at least `from`.
    pub(super) const fn at_least(from: f64, unit: &'static str) -> Self {
        Self { from: Some(from), ..Self::any(unit) }
    }

    /// From one number to another, both included.
    pub(super) const fn between(from: f64, to: f64, unit: &'static str) -> Self {
        Self { to: Some(to), ..Self::at_least(from, unit) }
    }

    fn holds(&self, x: f64) -> bool {
        x.is_finite()
            && self.above.is_none_or(|l| x > l)
            && self.from.is_none_or(|l| x >= l)
            && self.to.is_none_or(|l| x <= l)
            && self.below.is_none_or(|l| x < l)
    }

    fn describe(&self) -> String {
        let mut parts = Vec::new();
        if let Some(l) = self.above {
            parts.push(format!("above {}", plain(l)));
        }
        if let Some(l) = self.from {
            parts.push(format!("of at least {}", plain(l)));
        }
        if let Some(l) = self.to {
            parts.push(format!("of at most {}", plain(l)));
        }
        if let Some(l) = self.below {
            parts.push(format!("below {}", plain(l)));
        }
        let limits = parts.join(" and ");
        if limits.is_empty() {
            "a finite number".to_owned()
        } else {
            format!("a number {}", with_unit(limits, self.unit))
        }
    }
}

/// A list of tables, in words for messages.
pub(super) struct Entries {
    /// One of them, for instance `layer`.
    pub(super) one: &'static str,
    /// How it is written, for instance `[[soil.layer]]`.
    pub(super) header: &'static str,
    /// The most there may be.
    pub(super) to: usize,
    /// What to do where there is none.
    pub(super) help: &'static str,
    /// What to do where there are too many.
    pub(super) fewer: &'static str,
}

impl<'t> Checker<'t> {
    pub(in super::super) fn new(file: &str, lines: &'t Lines<'t>, folder: &Path, broken: bool) -> Self {
        Self { file: file.to_owned(), lines, folder: folder.to_path_buf(), broken, found: Vec::new() }
    }

    fn report(&mut self, severity: Severity, place: Place, message: String, help: Option<String>) {
        let (file, position) = match place.at {
            Origin::File(offset) => (self.file.clone(), Some(self.lines.place(offset))),
            Origin::Override => (OVERRIDE.to_owned(), None),
        };
        self.found.push(Diagnostic {
            severity,
            file,
            line: position.map(|p| p.0),
            column: position.map(|p| p.1),
            key_path: place.path,
            message,
            help,
        });
    }

    pub(super) fn error(&mut self, place: Place, message: impl Into<String>, help: &str) {
        let help = (!help.is_empty()).then(|| help.to_owned());
        self.report(Severity::Error, place, message.into(), help);
    }

    pub(super) fn warn(&mut self, place: Place, message: impl Into<String>, help: &str) {
        let help = (!help.is_empty()).then(|| help.to_owned());
        self.report(Severity::Warning, place, message.into(), help);
    }

    /// Notes that a required key is missing; [`Self::finish`] reports it at the table that should hold it.
    pub(super) fn missing(&mut self, section: &mut Section<'_>, key: &'static str, help: &str) {
        if !self.broken {
            section.missing.push((key, help.to_owned()));
        }
    }

    /// Says that a value has the wrong type.
    pub(super) fn wrong_type(&mut self, place: Place, value: &Value, expected: &str, help: &str) {
        if !matches!(value, Value::Broken) {
            let message = format!("expected {expected}, found {}", value.describe());
            self.error(place, message, help);
        }
    }

    /// Reports the keys that nobody asked for and those that are missing; to be called once a section is read.
    pub(super) fn finish(&mut self, section: &Section<'_>) {
        let mut meant = Vec::new();
        for (key, node) in &section.table.entries {
            if section.known.contains(&key.as_str()) {
                continue;
            }
            let near = nearest(key, &section.known);
            meant.extend(near);
            let help = match near {
                Some(near) => format!("did you mean `{near}`?"),
                None => format!("known here: {}", section.known.join(", ")),
            };
            let place = Place { path: join(&section.place.path, key), at: node.at };
            self.error(place, "unknown key", &help);
        }
        // A misspelt key is one slip: its proper name is not called missing as well.
        for (key, help) in section.missing.iter().filter(|(k, _)| !meant.contains(k)) {
            let mut place = section.place.clone();
            place.path = join(&place.path, key);
            self.error(place, "missing", help);
        }
    }

    /// A table under a key; `None` where it is missing or not a table.
    pub(super) fn table<'n>(&mut self, section: &mut Section<'n>, key: &'static str) -> Option<Section<'n>> {
        let node = section.get(key)?;
        let place = section.at(key);
        match &node.value {
            Value::Table(table) => Some(Section::new(table, place)),
            other => {
                let path = place.path.clone();
                self.wrong_type(place, other, "a table", &format!("write it as [{path}]"));
                None
            }
        }
    }

    /// The nodes of a list of tables; at least one, and no more than there may be.
    pub(super) fn entries<'n>(
        &mut self,
        section: &mut Section<'n>,
        key: &'static str,
        what: &Entries,
    ) -> Option<&'n [Node]> {
        let Some(node) = section.get(key) else {
            self.missing(section, key, what.help);
            return None;
        };
        let (place, one) = (section.at(key), what.one);
        match &node.value {
            Value::List(list) if list.is_empty() => {
                self.error(place, format!("there is no {one}"), what.help);
                None
            }
            Value::List(list) if list.len() > what.to => {
                let message = format!("expected at most {} {one}s, found {}", what.to, list.len());
                self.error(place, message, what.fewer);
                None
            }
            Value::List(list) => Some(list),
            Value::Table(_) => {
                let message = format!("expected a list of {one}s, found a table");
                let help = format!("write {} with two brackets, once per {one}", what.header);
                self.error(place, message, &help);
                None
            }
            other => {
                self.wrong_type(place, other, &format!("a list of {one}s"), what.help);
                None
            }
        }
    }

    /// Refuses keys that have no place here; those about which something was said already are passed over.
    pub(super) fn misplaced(
        &mut self,
        section: &mut Section<'_>,
        keys: &[&'static str],
        message: &str,
        help: &str,
    ) {
        for key in keys {
            let place = section.at(key);
            let said = |d: &Diagnostic| {
                let rest = d.key_path.strip_prefix(&place.path);
                rest.is_some_and(|rest| rest.is_empty() || rest.starts_with(['.', '[']))
            };
            if section.get(key).is_some() && !self.found.iter().any(said) {
                self.error(place, message, help);
            }
        }
    }

    /// A number of a node, an integer or a float, finite and within its bounds.
    pub(super) fn number_of(&mut self, node: &Node, place: Place, bounds: &Bounds) -> Option<f64> {
        let x = match &node.value {
            Value::Integer(i) => *i as f64,
            Value::Float(x) => *x,
            other => {
                let looks_like_one = matches!(other, Value::String(s) if s.trim().parse::<f64>().is_ok());
                let help = if looks_like_one { "take the quotes off" } else { "" };
                self.wrong_type(place, other, &bounds.describe(), help);
                return None;
            }
        };
        if bounds.holds(x) {
            return Some(x);
        }
        let found = with_unit(plain(x), bounds.unit);
        self.error(place, format!("expected {}, found {found}", bounds.describe()), "");
        None
    }

    /// A number that may be left out.
    pub(super) fn number(
        &mut self,
        section: &mut Section<'_>,
        key: &'static str,
        bounds: &Bounds,
    ) -> Option<f64> {
        let node = section.get(key)?;
        self.number_of(node, section.at(key), bounds)
    }

    /// A number that may be left out; the outer `None` is a mistake that has been reported.
    pub(super) fn optional(
        &mut self,
        section: &mut Section<'_>,
        key: &'static str,
        bounds: &Bounds,
    ) -> Option<Option<f64>> {
        match section.get(key) {
            None => Some(None),
            Some(_) => self.number(section, key, bounds).map(Some),
        }
    }

    /// `true` or `false`; `false` where the key is missing.
    pub(super) fn flag(&mut self, section: &mut Section<'_>, key: &'static str) -> Option<bool> {
        match section.get(key).map(|node| &node.value) {
            None => Some(false),
            Some(Value::Boolean(flag)) => Some(*flag),
            Some(other) => {
                self.wrong_type(section.at(key), other, "true or false", "");
                None
            }
        }
    }

    /// A list of so many numbers, each within the bounds.
    pub(super) fn numbers<const N: usize>(
        &mut self,
        node: &Node,
        place: Place,
        bounds: &Bounds,
    ) -> Option<[f64; N]> {
        let expected = format!("a list of {N} numbers");
        let Value::List(list) = &node.value else {
            self.wrong_type(place, &node.value, &expected, "");
            return None;
        };
        let found: Vec<Option<f64>> = list
            .iter()
            .enumerate()
            .map(|(i, n)| {
                let place = Place { path: format!("{}[{}]", place.path, i + 1), at: n.at };
                self.number_of(n, place, bounds)
            })
            .collect();
        if found.len() != N {
            self.error(place, format!("expected {expected}, found {}", found.len()), "");
            return None;
        }
        let found: Option<Vec<f64>> = found.into_iter().collect();
        found.and_then(|numbers| numbers.try_into().ok())
    }

    /// A number that has to be there.
    pub(super) fn required_number(
        &mut self,
        section: &mut Section<'_>,
        key: &'static str,
        bounds: &Bounds,
    ) -> Option<f64> {
        if section.get(key).is_none() {
            let help = format!("give `{key}`, {}", bounds.describe());
            self.missing(section, key, &help);
            return None;
        }
        self.number(section, key, bounds)
    }

    /// A whole number of a node between two limits, both included.
    pub(super) fn whole_of(&mut self, node: &Node, place: Place, from: usize, to: usize) -> Option<usize> {
        let expected = format!("a whole number from {from} to {to}");
        match &node.value {
            Value::Integer(i) => {
                let value = usize::try_from(*i).ok().filter(|n| (from..=to).contains(n));
                if value.is_none() {
                    self.error(place, format!("expected {expected}, found {i}"), "");
                }
                value
            }
            other => {
                self.wrong_type(place, other, &expected, "");
                None
            }
        }
    }

    /// A text of a node; not empty.
    pub(super) fn text_of<'n>(&mut self, node: &'n Node, place: Place) -> Option<&'n str> {
        match &node.value {
            Value::String(s) if s.trim().is_empty() => {
                self.error(place, "expected a text, found an empty one", "");
                None
            }
            Value::String(s) if s.chars().any(char::is_control) => {
                self.error(
                    place,
                    format!("expected a text on one line, found {s:?}"),
                    "take the control characters out",
                );
                None
            }
            Value::String(s) => Some(s),
            other => {
                self.wrong_type(place, other, "a text in quotes", "");
                None
            }
        }
    }

    /// A text that may be left out.
    pub(super) fn text(&mut self, section: &mut Section<'_>, key: &'static str) -> Option<String> {
        let node = section.get(key)?;
        self.text_of(node, section.at(key)).map(str::to_owned)
    }

    /// One of an enum's words.
    pub(super) fn word<T: Words>(&mut self, section: &mut Section<'_>, key: &'static str) -> Option<T> {
        let node = section.get(key)?;
        self.word_of(node, section.at(key))
    }

    /// One of an enum's words, of a node.
    pub(super) fn word_of<T: Words>(&mut self, node: &Node, place: Place) -> Option<T> {
        let words: Vec<&str> = T::WORDS.iter().map(|(w, _)| *w).collect();
        match &node.value {
            Value::String(s) => {
                let found = T::WORDS.iter().find(|(w, _)| w == s).map(|(_, v)| *v);
                if found.is_none() {
                    self.unknown_word(place, s, &words, "");
                }
                found
            }
            other => {
                self.wrong_type(place, other, &listed(&words, "\""), "");
                None
            }
        }
    }

    /// An enum's word that has to be there.
    pub(super) fn required_word<T: Words>(
        &mut self,
        section: &mut Section<'_>,
        key: &'static str,
    ) -> Option<T> {
        if section.get(key).is_none() {
            let words: Vec<&str> = T::WORDS.iter().map(|(w, _)| *w).collect();
            let help = format!("give `{key}` as {}", listed(&words, "\""));
            self.missing(section, key, &help);
            return None;
        }
        self.word(section, key)
    }

    /// Says that a word is none of the known ones; `or` names what else would do.
    pub(super) fn unknown_word(&mut self, place: Place, word: &str, words: &[&str], or: &str) {
        let help = nearest(word, words).map_or_else(String::new, |near| format!("did you mean \"{near}\"?"));
        let known = listed(words, "\"");
        let or = if or.is_empty() { String::new() } else { format!(" or {or}") };
        self.error(place, format!("expected {known}{or}, found {word:?}"), &help);
    }

    /// `"auto"` or what `read` makes of the node; `Auto` where the key is missing.
    pub(super) fn auto<T>(
        &mut self,
        section: &mut Section<'_>,
        key: &'static str,
        expected: &str,
        read: impl FnOnce(&mut Self, &Node, Place) -> Option<T>,
    ) -> Option<Auto<T>> {
        let Some(node) = section.get(key) else {
            return Some(Auto::Auto);
        };
        let place = section.at(key);
        match &node.value {
            Value::String(s) if s == "auto" => Some(Auto::Auto),
            Value::String(s) => {
                self.unknown_word(place, s, &["auto"], expected);
                None
            }
            _ => read(self, node, place).map(Auto::Value),
        }
    }

    /// `"auto"` or a number within its bounds.
    pub(super) fn auto_number(
        &mut self,
        section: &mut Section<'_>,
        key: &'static str,
        bounds: &Bounds,
    ) -> Option<Auto<f64>> {
        self.auto(section, key, &bounds.describe(), |cx, node, place| cx.number_of(node, place, bounds))
    }

    /// `"auto"` or a whole number between two limits, both included.
    pub(super) fn auto_whole(
        &mut self,
        section: &mut Section<'_>,
        key: &'static str,
        from: usize,
        to: usize,
    ) -> Option<Auto<usize>> {
        let expected = format!("a whole number from {from} to {to}");
        self.auto(section, key, &expected, |cx, node, place| cx.whole_of(node, place, from, to))
    }

    /// Says that two keys exclude each other where both are given; at the one that was written last.
    pub(super) fn only_one(&mut self, section: &Section<'_>, a: &str, b: &str, help: &str) -> bool {
        let both = section.has(a) && section.has(b);
        if both {
            let later = section.later(a, b);
            let other = if later == a { b } else { a };
            self.error(section.at(later), format!("`{other}` is given too; give one of the two"), help);
        }
        !both
    }
}
