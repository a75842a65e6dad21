//! What the tests of records need of Python: the fixtures, and the script spoken to directly.
#![allow(dead_code, unreachable_pub)]

use std::hash::{DefaultHasher, Hash, Hasher};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::OnceLock;

use hati_inputs::InputError;
use hati_inputs::records::Channel;

/// The interpreter of the workspace, found as the library does.
pub fn interpreter() -> PathBuf {
    if let Some(python) = std::env::var_os("HATI_PYTHON").filter(|value| !value.is_empty()) {
        return python.into();
    }
    let crate_folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    crate_folder
        .ancestors()
        .map(|folder| folder.join(".venv/bin/python"))
        .find(|python| python.exists())
        .unwrap_or_else(|| "python3".into())
}

/// Whether that interpreter has ObsPy; says so when it has not.
pub fn has_obspy() -> bool {
    static HAS: OnceLock<bool> = OnceLock::new();
    *HAS.get_or_init(|| {
        let status = Command::new(interpreter()).args(["-I", "-c", "import obspy"]).status();
        let has = status.is_ok_and(|status| status.success());
        if !has {
            say("skipped: no Python with ObsPy (run `make setup`)");
        }
        has
    })
}

/// A folder with the files of `inputs/python/make_fixtures.py`, made once; `None` without ObsPy.
pub fn fixtures() -> Option<&'static Path> {
    static FOLDER: OnceLock<Option<PathBuf>> = OnceLock::new();
    FOLDER.get_or_init(|| made_by("make_fixtures.py")).as_deref()
}

/// A folder with the files that a script of `inputs/python` makes, made once and kept until the script
/// changes; `None` without ObsPy.
pub fn made_by(script: &str) -> Option<PathBuf> {
    if !has_obspy() {
        return None;
    }
    // Tests run as processes of their own: the folder is made aside and takes its name in one step.
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("python").join(script);
    let mut key = DefaultHasher::new();
    std::fs::read(&path).expect("the script is part of the project").hash(&mut key);
    let name = script.trim_end_matches(".py");
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{name}_{:x}", key.finish()));
    if !folder.exists() {
        let aside = folder.with_extension(std::process::id().to_string());
        std::fs::create_dir_all(&aside).expect("the build's own temporary folder");
        make(script, &aside, &folder);
        if std::fs::rename(&aside, &folder).is_err() {
            assert!(folder.exists(), "the fixtures could not be put in place");
            let _ = std::fs::remove_dir_all(&aside);
        }
    }
    Some(folder)
}

/// Runs a script of `inputs/python` that makes files in a folder, which later has the name `known_as`.
pub fn make(script: &str, folder: &Path, known_as: &Path) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("python").join(script);
    let status = Command::new(interpreter()).arg(path).args([folder, known_as]).status();
    assert!(status.is_ok_and(|status| status.success()), "the fixtures could not be made");
}

/// The reader script's answer to one file under a format word of choice.
pub fn ask_script(format: &str, content: &[u8]) -> String {
    let script = include_str!("../../python/hati_records.py");
    let mut child = Command::new(interpreter())
        .args(["-I", "-c", script])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .expect("the interpreter was found");
    let mut stdin = child.stdin.take().expect("piped");
    let request = format!(
        "{{\"op\": \"read\", \"max_samples\": 1000, \"max_segments\": 10, \"memory_bytes\": 8589934592, \
         \"files\": [{{\"format\": \"{format}\", \"bytes\": {}, \"response\": null}}]}}\n",
        content.len()
    );
    stdin.write_all(request.as_bytes()).expect("the script reads");
    stdin.write_all(content).expect("the script reads");
    drop(stdin);
    let output = child.wait_with_output().expect("the script ends");
    String::from_utf8_lossy(&output.stdout).into_owned()
}

/// Opens a pickle as careless code would.
pub fn unpickle(path: &Path) {
    let status = Command::new(interpreter())
        .args(["-I", "-c", "import pickle, sys; pickle.load(open(sys.argv[1], 'rb'))"])
        .arg(path)
        .status();
    assert!(status.is_ok_and(|status| status.success()));
}

/// A line for whoever reads the test's output, past the capture of the test harness.
pub fn say(line: &str) {
    let _ = writeln!(std::io::stderr(), "{line}");
}

/// The text of a refusal.
#[track_caller]
pub fn refusal(name: &str, answer: Result<Vec<Channel>, InputError>) -> String {
    match answer {
        Err(error) => error.to_string(),
        Ok(channels) => panic!("{name} was read: {} channel(s)", channels.len()),
    }
}
