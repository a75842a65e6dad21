//! The commands that the documentation shows are run as they stand.

use std::path::Path;
use std::process::Command;

use crate::program::{folder, hati, root};

/// Lines of the `sh` blocks of a page.
fn shell_lines(page: &str) -> Vec<String> {
    let text = std::fs::read_to_string(root().join(page)).unwrap_or_else(|e| panic!("{page}: {e}"));
    let mut inside = false;
    let mut lines = vec![];
    for line in text.lines() {
        match line.trim() {
            "```sh" => inside = true,
            "```" => inside = false,
            command if inside && !command.is_empty() && !command.starts_with('#') => {
                lines.push(command.to_owned())
            }
            _ => {}
        }
    }
    lines
}

/// Runs the lines of a page that call the program or copy a scene, in a folder that looks like a clone
/// after `make build`, and looks up those that call make. Returns how many there are of both kinds.
fn runs(page: &str) -> (usize, usize) {
    let folder = folder();
    let clone = folder.path();
    std::fs::create_dir_all(clone.join("target/debug")).expect("a folder");
    link(Path::new(env!("CARGO_BIN_EXE_hati")), &clone.join("target/debug/hati"));
    link(&root().join("scenes"), &clone.join("scenes"));
    let makefile = std::fs::read_to_string(root().join("Makefile")).expect("the Makefile");
    let (mut run, mut made) = (0, 0);
    for line in shell_lines(page) {
        let command = line.split('#').next().unwrap_or_default().trim();
        if let Some(targets) = command.strip_prefix("make ") {
            for target in targets.split_whitespace().filter(|word| !word.contains(['=', '-'])) {
                let rule = format!("{target}:");
                assert!(makefile.lines().any(|l| l.starts_with(&rule)), "{page}: no target {target}");
                made += 1;
            }
        } else if command.starts_with("target/debug/hati ") || command.starts_with("cp ") {
            let output =
                Command::new("sh").args(["-e", "-c", command]).current_dir(clone).output().expect("sh");
            let told = String::from_utf8_lossy(&output.stderr);
            assert_eq!(output.status.code(), Some(0), "{page}: {line}\n{told}");
            run += usize::from(command.starts_with("target"));
        } else {
            assert!(!command.contains("hati "), "{page}: {line} is not tried");
        }
    }
    (run, made)
}

fn link(target: &Path, name: &Path) {
    #[cfg(unix)]
    std::os::unix::fs::symlink(target, name).expect("a link");
    #[cfg(not(unix))]
    panic!("{} and {}: links are made on Unix only", target.display(), name.display());
}

#[test]
#[cfg(unix)]
fn commands_of_the_readme_run() {
    let (run, made) = runs("README.md");
    assert!(run + made >= 1, "the README shows no command");
}

#[test]
#[cfg(unix)]
fn commands_of_the_book_run() {
    let (run, _) = runs("docs/src/use.md");
    assert!(run >= 2, "the chapter shows no command");
}

/// Every case of `verify` has a row in the chapter's table, and the rows name no other.
#[test]
fn the_table_of_cases_is_true() {
    let page = std::fs::read_to_string(root().join("docs/src/verification.md")).expect("the chapter");
    let shown: Vec<&str> = page
        .lines()
        .filter_map(|line| line.strip_prefix("| `"))
        .filter_map(|rest| rest.split_once('`').map(|(name, _)| name))
        .collect();
    assert_eq!(shown, hati::verify::names());
}

/// Every verb of the book's table is a verb.
#[test]
fn the_table_of_verbs_is_true() {
    let folder = folder();
    let page = std::fs::read_to_string(root().join("docs/src/use.md")).expect("the chapter");
    let shown: Vec<&str> = page
        .lines()
        .filter_map(|line| line.strip_prefix("| `hati "))
        .filter_map(|rest| rest.split([' ', '`']).next())
        .collect();
    assert!(shown.len() >= 5, "{shown:?}");
    for verb in &shown {
        hati(folder.path(), &[verb, "--help"]).exits(0);
    }
}

/// The scene reference is what the program writes.
#[test]
fn the_scene_reference_is_up_to_date() {
    let page = std::fs::read_to_string(root().join("docs/src/scene-reference.md")).expect("the chapter");
    let answer = hati(folder().path(), &["schema", "--markdown"]).exits(0);
    assert!(page == answer.stdout, "run: target/debug/hati schema --markdown > docs/src/scene-reference.md");
}
