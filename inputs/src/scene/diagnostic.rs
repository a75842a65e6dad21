//! What is wrong with a scene, where, and what to do about it.

use std::fmt;

use serde::Serialize;

pub(super) use crate::number::{plain, rounded};

/// How much a [`Diagnostic`] matters.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Severity {
    /// The scene cannot be run.
    Error,
    /// The scene can be run, but its author should know.
    Warning,
}

/// One finding about one key of a scene.
///
/// Its `Display` is the line that a user reads:
/// ```text
/// scene.toml:41 soil.layer[2].vs: 1200 m/s is above vp/√2 = 424 m/s (Poisson's ratio would be negative)
///   help: swap vp and vs, or give nu instead of vp
/// ```
/// A warning has the word `warning:` before its message.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Diagnostic {
    /// Error or warning.
    pub severity: Severity,
    /// File as the user named it, or `--set` for an override.
    pub file: String,
    /// Line in the file, counted from 1; `None` for an override or a file that could not be read.
    pub line: Option<usize>,
    /// Column in characters, counted from 1; given with `line`.
    pub column: Option<usize>,
    /// Key in full, list entries counted from 1 (`soil.layer[2].vs`); empty where no key is concerned.
    pub key_path: String,
    /// What was found and what was expected.
    pub message: String,
    /// What to do, where there is advice to give.
    pub help: Option<String>,
}

impl fmt::Display for Diagnostic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.file)?;
        if let Some(line) = self.line {
            write!(f, ":{line}")?;
        }
        if !self.key_path.is_empty() {
            write!(f, " {}", self.key_path)?;
        }
        f.write_str(": ")?;
        if self.severity == Severity::Warning {
            f.write_str("warning: ")?;
        }
        f.write_str(&self.message)?;
        if let Some(help) = &self.help {
            write!(f, "\n  help: {help}")?;
        }
        Ok(())
    }
}

/// Every finding of one scene, in the order of its lines, overrides last.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize)]
#[serde(transparent)]
pub struct Diagnostics {
    list: Vec<Diagnostic>,
}

impl Diagnostics {
    /// Sorts by line and column and drops repetitions.
    pub(super) fn new(mut list: Vec<Diagnostic>) -> Self {
        // A finding without a line belongs to an override and stands last; the sort is stable.
        list.sort_by_key(|d| (d.line.unwrap_or(usize::MAX), d.column.unwrap_or(usize::MAX), d.severity));
        let mut kept: Vec<Diagnostic> = Vec::with_capacity(list.len());
        for d in list {
            if kept.last() != Some(&d) {
                kept.push(d);
            }
        }
        Self { list: kept }
    }

    /// All findings.
    pub fn iter(&self) -> std::slice::Iter<'_, Diagnostic> {
        self.list.iter()
    }

    /// Findings that forbid a run.
    pub fn errors(&self) -> impl Iterator<Item = &Diagnostic> {
        self.list.iter().filter(|d| d.severity == Severity::Error)
    }

    /// Findings that do not.
    pub fn warnings(&self) -> impl Iterator<Item = &Diagnostic> {
        self.list.iter().filter(|d| d.severity == Severity::Warning)
    }

    /// True where at least one error stands.
    pub fn has_errors(&self) -> bool {
        self.errors().next().is_some()
    }

    /// Number of findings.
    pub fn len(&self) -> usize {
        self.list.len()
    }

    /// True where nothing was found.
    pub fn is_empty(&self) -> bool {
        self.list.is_empty()
    }
}

impl fmt::Display for Diagnostics {
    /// One finding after the other, without a final line break.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, d) in self.list.iter().enumerate() {
            if i > 0 {
                f.write_str("\n")?;
            }
            d.fmt(f)?;
        }
        Ok(())
    }
}

impl std::error::Error for Diagnostics {}

impl<'a> IntoIterator for &'a Diagnostics {
    type Item = &'a Diagnostic;
    type IntoIter = std::slice::Iter<'a, Diagnostic>;
    fn into_iter(self) -> Self::IntoIter {
        self.iter()
    }
}

/// A value with its unit; dimensionless values (`""` or `"1"`) stand alone.
pub(super) fn with_unit(text: String, unit: &str) -> String {
    if unit.is_empty() || unit == "1" { text } else { format!("{text} {unit}") }
}

/// The word of `known` that looks most like `word`, if any is close enough to be what was meant.
pub(super) fn nearest<'w>(word: &str, known: &[&'w str]) -> Option<&'w str> {
    let lower = word.to_lowercase();
    known
        .iter()
        .map(|k| (strsim::damerau_levenshtein(&lower, k), *k))
        .filter(|(d, k)| *d <= 1 + k.chars().count().min(lower.chars().count()) / 3)
        .min_by_key(|(d, _)| *d)
        .map(|(_, k)| k)
}

/// `"a", "b" or "c"`, each between the given marks.
pub(super) fn listed(words: &[&str], mark: &str) -> String {
    let quoted: Vec<String> = words.iter().map(|w| format!("{mark}{w}{mark}")).collect();
    match quoted.split_last() {
        None => String::new(),
        Some((last, [])) => last.clone(),
        Some((last, head)) => format!("{} or {last}", head.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nearest_word_needs_resemblance() {
        assert_eq!(nearest("thicknes", &["thickness", "vs"]), Some("thickness"));
        assert_eq!(nearest("zebra", &["thickness", "rho"]), None);
        assert_eq!(nearest("VS", &["thickness", "vs"]), Some("vs"));
    }
}
