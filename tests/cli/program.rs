//! Starts the program and looks at what it answers.

use std::ffi::OsStr;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use serde_json::Value;

/// Root of the workspace.
pub(crate) fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// A scene that comes with the program.
pub(crate) fn shipped(name: &str) -> String {
    root().join("scenes").join(name).display().to_string()
}

/// An empty folder that goes away with the value.
pub(crate) fn folder() -> tempfile::TempDir {
    tempfile::tempdir().expect("a temporary folder")
}

/// A command for the program; its working folder is `cwd`, its input empty.
pub(crate) fn command<S: AsRef<OsStr>>(cwd: &Path, arguments: &[S]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_hati"));
    command.args(arguments).current_dir(cwd).stdin(Stdio::null());
    command
}

/// Runs the program to its end.
pub(crate) fn hati<S: AsRef<OsStr>>(cwd: &Path, arguments: &[S]) -> Answer {
    Answer::from(command(cwd, arguments).output().expect("the program starts"))
}

/// What the program answered.
#[derive(Debug)]
pub(crate) struct Answer {
    pub(crate) code: Option<i32>,
    pub(crate) stdout: String,
    pub(crate) stderr: String,
}

impl From<Output> for Answer {
    fn from(output: Output) -> Self {
        let text = |bytes| String::from_utf8(bytes).expect("the program writes UTF-8");
        Self { code: output.status.code(), stdout: text(output.stdout), stderr: text(output.stderr) }
    }
}

impl Answer {
    /// Asserts the exit code.
    #[track_caller]
    pub(crate) fn exits(self, code: i32) -> Self {
        assert_eq!(self.code, Some(code), "stdout: {}\nstderr: {}", self.stdout, self.stderr);
        assert!(!self.stderr.contains("panicked"), "{}", self.stderr);
        self
    }

    /// Asserts that all of these words stand on stderr.
    #[track_caller]
    pub(crate) fn tells(self, words: &[&str]) -> Self {
        for word in words {
            assert!(self.stderr.contains(word), "{word:?} is missing in:\n{}", self.stderr);
        }
        self
    }

    /// Asserts that stdout is empty.
    #[track_caller]
    pub(crate) fn prints_nothing(self) -> Self {
        assert_eq!(self.stdout, "");
        self
    }

    /// The one JSON value that stdout holds, and nothing else.
    #[track_caller]
    pub(crate) fn json(&self) -> Value {
        assert!(self.stdout.ends_with('\n'), "no line break at the end");
        let values: Result<Vec<Value>, _> =
            serde_json::Deserializer::from_str(&self.stdout).into_iter().collect();
        let mut values = values.unwrap_or_else(|e| panic!("not JSON: {e}\n{}", self.stdout));
        assert_eq!(values.len(), 1, "{}", self.stdout);
        values.swap_remove(0)
    }

    /// Asserts that stdout holds `{"error", "exit"}` with these words, and stderr the same text.
    #[track_caller]
    pub(crate) fn fails_in_json(self, code: i32, words: &[&str]) {
        let value = self.json();
        assert_eq!(value["exit"], code);
        let text = value["error"].as_str().expect("a text");
        for word in words {
            assert!(text.contains(word), "{word:?} is missing in {text:?}");
        }
        self.exits(code).tells(words);
    }
}

/// Writes `text` as `folder/name` and returns the path as text.
pub(crate) fn write(folder: &Path, name: &str, text: &str) -> String {
    let path = folder.join(name);
    std::fs::write(&path, text).expect("write a scene");
    path.display().to_string()
}

/// A JSON file.
#[track_caller]
pub(crate) fn read_json(path: PathBuf) -> Value {
    let text = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    serde_json::from_str(&text).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// A number inside a JSON value.
#[track_caller]
pub(crate) fn number(value: &Value, pointer: &str) -> f64 {
    value
        .pointer(pointer)
        .and_then(Value::as_f64)
        .unwrap_or_else(|| panic!("no number at {pointer} in {value:#}"))
}

/// A line for whoever reads the test's output, past the capture of the test harness.
pub(crate) fn say(line: &str) {
    let _ = writeln!(std::io::stderr(), "{line}");
}
