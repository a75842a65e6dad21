//! A step of processing as one argument of a command line: `filter f_min=0.1 f_max=25 causal=true`.

use std::path::Path;

use crate::InputError;
use crate::motion::Process;

use super::check::{self, Checker};
use super::diagnostic::listed;
use super::document::{self, Lines, Node, Origin, Table, Value};

impl Process {
    /// Reads a step from text: its word, then `key=value` with blanks or commas between them.
    ///
    /// Keys, values and checks are those of a scene's `motion.process`; quotes around words may be left out,
    /// and a key may name one entry of a table (`spectrum.pga=2`). What [`Process`] prints is read as the same
    /// step.
    ///
    /// Errors: [`InputError::ProcessText`] with every mistake of the text.
    pub fn parse(text: &str) -> Result<Self, InputError> {
        let refused = |problems: String| InputError::ProcessText { text: text.trim().to_owned(), problems };
        let words = words(text);
        let mut words = words.iter();
        let Some(name) = words.next() else {
            let known = listed(&Self::WORDS, "").replace(" or ", ", ");
            return Err(refused(format!("expected a step\n  help: give one of {known}")));
        };
        let at = Origin::Override;
        let name = ("step".to_owned(), Node { value: Value::String(name.clone()), at });
        let mut table = Table { entries: vec![name] };
        let mut given = vec!["step"];
        for word in words {
            let Some((key, value)) = word.split_once('=') else {
                return Err(refused(format!("{word}: expected key=value\n  help: for instance f_min=0.1")));
            };
            if given.contains(&key) {
                return Err(refused(format!("{key}: given twice\n  help: give it once")));
            }
            given.push(key);
            document::set(&mut table, key, value).map_err(|found| {
                refused(format!("{key}: {}{}", found.message, help(found.help.as_deref())))
            })?;
        }
        let lines = Lines::new("");
        let mut checker = Checker::new("", &lines, Path::new(""), false);
        let process = check::step(&mut checker, &table, check::Place { path: String::new(), at });
        let mistakes: Vec<String> = checker
            .found
            .iter()
            .filter(|found| found.severity == super::Severity::Error)
            .map(|found| {
                let key = match found.key_path.as_str() {
                    "" | "step" => String::new(),
                    key => format!("{key}: "),
                };
                format!("{key}{}{}", found.message, help(found.help.as_deref()))
            })
            .collect();
        match process {
            Some(process) if mistakes.is_empty() => Ok(process),
            _ => Err(refused(mistakes.join("\n"))),
        }
    }
}

fn help(help: Option<&str>) -> String {
    help.map(|help| format!("\n  help: {help}")).unwrap_or_default()
}

/// Words between blanks and commas; brackets and quotes keep what is inside together, and so does an equals sign.
fn words(text: &str) -> Vec<String> {
    let mut words = Vec::new();
    let mut word = String::new();
    let (mut depth, mut quote) = (0_usize, None);
    for c in text.chars() {
        let between = (c.is_whitespace() || c == ',') && depth == 0 && quote.is_none();
        if between {
            if !word.is_empty() && (!word.ends_with('=') || c == ',') {
                words.push(std::mem::take(&mut word));
            }
            continue;
        }
        match (quote, c) {
            (Some(open), c) if c == open => quote = None,
            (None, '"' | '\'') => quote = Some(c),
            (None, '[' | '{') => depth += 1,
            (None, ']' | '}') => depth = depth.saturating_sub(1),
            _ => {}
        }
        if c == '='
            && depth == 0
            && word.is_empty()
            && let Some(key) = words.pop()
        {
            word = key;
        }
        word.push(c);
    }
    words.extend((!word.is_empty()).then_some(word));
    words
}

#[cfg(test)]
mod tests {
    use super::words;

    #[test]
    fn words_end_at_blanks_and_commas_outside_of_brackets_and_quotes() {
        assert_eq!(words("  filter  f_min=0.1,f_max = 25 "), ["filter", "f_min=0.1", "f_max=25"]);
        assert_eq!(
            words("a b={ c = [1, 2], d = \"x y\" } e='p q'"),
            ["a", "b={ c = [1, 2], d = \"x y\" }", "e='p q'"]
        );
        assert_eq!(words("a b= , c=1"), ["a", "b=", "c=1"]);
        assert!(words(" , ").is_empty());
        assert_eq!(words("= x"), ["=x"]);
    }
}
