//! `schema`, `verify`, `chart`, the command line itself, and where its words go.

use std::process::Stdio;

use serde_json::Value;

use crate::program::{Answer, command, folder, hati, number, shipped, write};
use crate::scenes::{SceneText, ricker};

#[test]
fn schema_names_the_keys_of_a_scene() {
    let folder = folder();
    let answer = hati(folder.path(), &["schema"]).exits(0);
    assert_eq!(answer.stderr, "");
    let schema = answer.json();
    assert_eq!(schema["type"], "object");
    assert_eq!(schema["additionalProperties"], false);
    let properties = schema["properties"].as_object().expect("properties");
    for key in ["version", "title", "accuracy", "motion", "soil", "discretisation", "output"] {
        assert!(properties.contains_key(key), "{key}");
    }
    assert_eq!(schema["required"], serde_json::json!(["version"]));
    // A column, or ground in two or three dimensions.
    let column_or_domain =
        [&["motion", "soil"][..], &["domain", "source", "run"]].map(|r| serde_json::json!({ "required": r }));
    assert_eq!(schema["anyOf"], serde_json::json!(column_or_domain));
    let mut references = vec![];
    collect_references(&schema, &mut references);
    for reference in references {
        let pointer =
            reference.strip_prefix('#').unwrap_or_else(|| panic!("{reference} leaves the document"));
        assert!(schema.pointer(pointer).is_some(), "{reference} leads nowhere");
    }
}

fn collect_references(value: &Value, found: &mut Vec<String>) {
    match value {
        Value::Object(map) => {
            found.extend(map.get("$ref").and_then(Value::as_str).map(str::to_owned));
            map.values().for_each(|v| collect_references(v, found));
        }
        Value::Array(list) => list.iter().for_each(|v| collect_references(v, found)),
        _ => {}
    }
}

#[test]
fn schema_as_a_page_of_the_book() {
    let folder = folder();
    let answer = hati(folder.path(), &["schema", "--markdown"]).exits(0);
    assert!(answer.stdout.starts_with("# The scene file\n"));
    for row in ["| `thickness` |", "| `accuracy` |", "`[motion]`", "`[[soil.layer]]`"] {
        assert!(answer.stdout.contains(row), "{row}");
    }
}

#[test]
fn verify_compares_and_counts() {
    let folder = folder();
    let answer = hati(folder.path(), &["verify", "--json", "damping-fit"]).exits(0);
    assert_eq!(answer.stderr, "");
    let value = answer.json();
    let checks = value.as_array().expect("a list");
    assert!(checks.len() >= 3);
    for check in checks {
        assert_eq!(check["case"], "damping-fit");
        assert_eq!(check["pass"], true);
        assert!(check["quantity"].as_str().is_some_and(|q| !q.is_empty()));
        assert!(number(check, "/error") <= number(check, "/limit"));
        let relative = (number(check, "/value") / number(check, "/reference") - 1.0).abs();
        assert!((relative - number(check, "/error")).abs() < 1e-12, "{check}");
    }
    let answer = hati(folder.path(), &["verify", "damping-fit"]).exits(0);
    assert_eq!(answer.stdout, format!("{} quantities checked, 0 failed\n", checks.len()));
    assert_eq!(answer.stderr.lines().filter(|l| l.starts_with("ok ")).count(), checks.len());
}

#[test]
fn the_self_check_sees_every_twisted_constant() {
    let folder = folder();
    let answer = hati(folder.path(), &["verify", "--self-check", "damping-fit"]).exits(0);
    assert!(answer.stdout.ends_with(" quantities twisted, 0 unnoticed\n"), "{}", answer.stdout);
    assert!(answer.stderr.lines().all(|l| l.starts_with("noticed ")), "{}", answer.stderr);
    let value = hati(folder.path(), &["verify", "--self-check", "--json", "damping-fit"]).exits(0).json();
    assert!(value.as_array().is_some_and(|list| !list.is_empty() && list.iter().all(|c| c["pass"] == false)));
}

#[test]
fn verify_refuses_a_case_that_there_is_not() {
    let folder = folder();
    hati(folder.path(), &["verify", "nonsense"])
        .exits(2)
        .prints_nothing()
        .tells(&["no case named nonsense", "damping-fit"]);
    // Beside a known one, too: a slip of the pen must not skip a case.
    hati(folder.path(), &["verify", "damping-fit", "nonsense", "--json"]).fails_in_json(2, &["nonsense"]);
    hati(folder.path(), &["verify", "step-bound-million"]).exits(2).tells(&["--long"]);
}

fn tiny() -> String {
    SceneText {
        accuracy: 0.1,
        motions: vec![('x', ricker(3.0, 1.0, 0.5, 1.0))],
        layers: vec![[10.0, 300.0, 600.0, 1800.0, 0.05]],
        base: Some([600.0, 1200.0, 2000.0]),
        discretisation: "tail = 0.5".into(),
        output: "field_spacing = \"none\"".into(),
        ..SceneText::default()
    }
    .text()
}

#[test]
#[ignore = "measures every discretisation of a family several times: half a minute; run by `make test-long`"]
fn chart_measures_error_against_cost() {
    let folder = folder();
    let scene = write(folder.path(), "tiny.toml", &tiny());
    let value = hati(folder.path(), &["chart", &scene, "--json", "--out", "c"]).exits(0).json();
    let points = value["points"].as_array().expect("a list");
    assert!(points.len() > 5);
    assert_eq!(points.iter().filter(|p| p["auto"] == true).count(), 1);
    for point in points {
        let (measured, predicted) = (number(point, "/measured"), number(point, "/predicted"));
        assert!(measured > 0.0 && measured < 5.0 * predicted.max(1e-6), "{point}");
        assert!(number(point, "/seconds") > 0.0);
    }
    for name in ["chart.csv", "chart.svg", "chart.html", "chart.json"] {
        assert!(folder.path().join("c").join(name).exists(), "{name}");
    }
}

#[test]
fn chart_refuses_a_wrong_scene_before_it_measures() {
    let folder = folder();
    hati(folder.path(), &["chart", "gone.toml", "--json"]).fails_in_json(2, &["gone.toml"]);
    assert_eq!(std::fs::read_dir(folder.path()).expect("the folder").count(), 0);
}

#[test]
fn the_command_line_itself() {
    let folder = folder();
    let answer = hati(folder.path(), &["--version"]).exits(0);
    assert_eq!(answer.stdout, format!("hati {}\n", env!("CARGO_PKG_VERSION")));
    let answer = hati(folder.path(), &["--help"]).exits(0);
    for verb in ["check", "plan", "run", "record", "export", "schema", "chart", "verify", "Exit codes"] {
        assert!(answer.stdout.contains(verb), "{verb}");
    }
    hati(folder.path(), &["dance"]).exits(2).prints_nothing().tells(&["dance"]);
    hati(folder.path(), &["run"]).exits(2).prints_nothing().tells(&["SCENE"]);
    hati(folder.path(), &["record"]).exits(2).prints_nothing();
    hati(folder.path(), &["plan", "--jsn", "x"]).exits(2).prints_nothing().tells(&["--json"]);
    let threads = ["run", "scene.toml", "--threads", "100000"];
    hati(folder.path(), &threads).exits(2).prints_nothing().tells(&["100000", "1..=1024"]);
    hati(folder.path(), &["plan", "x", "--json", "--dance"]).fails_in_json(2, &["--dance"]);
    let none: [&str; 0] = [];
    hati(folder.path(), &none).exits(2).prints_nothing();
}

/// `hati schema | head -1`: the pipe breaks while the program still writes.
#[test]
fn a_reader_that_leaves_early_is_no_failure() {
    let folder = folder();
    for stream in ["stdout", "stderr"] {
        let scene = shipped("three-layer");
        let arguments = ["run", "--json", &scene, "--out", stream];
        let mut command =
            command(folder.path(), if stream == "stdout" { &arguments } else { &arguments[..] });
        let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("start");
        if stream == "stdout" {
            drop(child.stdout.take());
        } else {
            drop(child.stderr.take());
        }
        let answer = Answer::from(child.wait_with_output().expect("end")).exits(0);
        assert_eq!(answer.stderr, "");
        assert!(folder.path().join(stream).join("summary.json").exists());
    }
    // The text for people goes to stderr: a run goes on without anyone to read it.
    let mut command = command(folder.path(), &["run", &shipped("three-layer"), "--out", "quiet"]);
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("start");
    drop(child.stderr.take());
    let answer = Answer::from(child.wait_with_output().expect("end")).exits(0);
    assert_eq!(answer.stdout, "quiet/report.html\n");
}

#[test]
#[cfg(target_os = "linux")]
fn a_full_standard_output_is_told() {
    let folder = folder();
    let full = std::fs::OpenOptions::new().write(true).open("/dev/full").expect("/dev/full");
    let output = command(folder.path(), &["schema"]).stdout(full).output().expect("start");
    Answer::from(output).exits(4).tells(&["standard output", "No space left"]);
}
