//! `hati record`: what stands in a record's file, and refusals that open nothing.

use crate::program::{folder, hati, number};
use crate::python::{fixtures, hati_with, interpreter};

/// The motion of all fixtures, m/s²; see `inputs/python/make_fixtures.py`.
fn acceleration() -> Vec<f64> {
    let value = |t: f64| 1.5 * (4.0 * std::f64::consts::PI * t).sin() * (-((t - 6.0) / 2.0).powi(2)).exp();
    (0..2000).map(|i| value(0.01 * f64::from(i))).collect()
}

#[test]
fn a_table_for_people() {
    let Some(python) = interpreter() else { return };
    let fixtures = fixtures(python);
    let arguments = ["record", "--process", "filter f_min=0.5 f_max=20", "east.knet", "acceleration.sac"];
    let answer = hati_with(python, fixtures.path(), &arguments).exits(0);
    let lines: Vec<&str> = answer.stdout.lines().collect();
    for head in ["channel", "stored in", "PGA m/s²", "PGV m/s", "PGD m", "Arias m/s", "D5-95 s", "band Hz"] {
        assert!(lines[0].contains(head), "{head}");
    }
    assert!(lines.iter().all(|line| line.chars().count() <= 100), "{}", answer.stdout);
    for cell in [
        "2000 samples, step 0.01 s, 0 to 19.99 s, from 2020-02-03T",
        "  east.knet (K-NET)",
        "  acceleration.sac (SAC)",
        "filter f_min=0.5 f_max=20 order=4",
        "nm/s2",
        "1.49",
    ] {
        assert!(answer.stdout.contains(cell), "{cell} in {}", answer.stdout);
    }
    // Numbers stand under the right end of their heads.
    let end = lines[0].chars().take_while(|c| *c != '²').count();
    let row = lines.iter().find(|line| line.starts_with("  x ")).expect("a row");
    assert!(row.chars().nth(end).is_some_and(|c| c.is_ascii_digit()), "{}", answer.stdout);
    assert_eq!(row.chars().nth(end + 1), Some(' '), "{}", answer.stdout);
}

#[test]
fn measures_for_programs() {
    let Some(python) = interpreter() else { return };
    let answer =
        hati_with(python, fixtures(python).path(), &["record", "--json", "east.knet", "acceleration.sac"])
            .exits(0);
    let value = answer.json();
    let channels = value["channels"].as_array().expect("a list");
    assert_eq!(channels.len(), 2);
    let a = acceleration();
    let sum = |f: &dyn Fn(f64) -> f64| a.iter().map(|&x| f(x)).sum::<f64>() * 0.01;
    let arias = std::f64::consts::PI / (2.0 * 9.80665) * sum(&|x| x * x);
    let cav = sum(&f64::abs);
    let pga = a.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    for channel in channels {
        assert!(channel["id"].as_str().is_some_and(|id| id.contains("HATI")), "{channel}");
        assert_eq!((number(channel, "/dt"), number(channel, "/npts")), (0.01, 2000.0));
        assert_eq!((&channel["unit"], &channel["quantity"]), (&"m/s²".into(), &"acceleration".into()));
        assert_eq!(channel["sha256"].as_str().map(str::len), Some(64));
        for (key, exact) in [("pga", pga), ("arias", arias), ("cav", cav)] {
            let found = number(channel, &format!("/{key}"));
            assert!((found / exact - 1.0).abs() < 2e-3, "{key}: {found} against {exact}");
        }
        // A slowly modulated sine: v = a/ω, u = a/ω², roughly.
        let omega = 4.0 * std::f64::consts::PI;
        for (key, rough) in [("pgv", pga / omega), ("pgd", pga / omega.powi(2))] {
            let found = number(channel, &format!("/{key}"));
            assert!((found / rough - 1.0).abs() < 0.03, "{key}: {found} against {rough}");
        }
        // The spectrum is a Gaussian about 2 Hz with exp(−(2π(f − 2))²·2) for its energy: outside 2 Hz ± x lies the
        // share erfc(2√2 π x), which is (1e-2/2)² at x = 0.335 Hz.
        let (f_min, f_max) = (number(channel, "/band/0"), number(channel, "/band/1"));
        assert!((f_min - 1.665).abs() < 0.06 && (f_max - 2.335).abs() < 0.06, "{f_min} to {f_max} Hz");
        // The middle nine tenths of a Gaussian of variance 1 s² in energy: 2 · 1.645 s.
        assert!((number(channel, "/d5_95") / 3.29 - 1.0).abs() < 0.05, "{channel}");
    }
}

#[test]
fn a_unit_can_be_given_and_a_missing_one_is_asked_for() {
    let Some(python) = interpreter() else { return };
    let fixtures = fixtures(python);
    let records = fixtures.path();
    hati_with(python, records, &["record", "counts.mseed"]).exits(2).prints_nothing().tells(&[
        "counts.mseed",
        "no unit",
        "one of m/s2",
    ]);
    let value =
        hati_with(python, records, &["record", "--json", "counts.mseed", "--unit", "nm/s2"]).exits(0).json();
    assert_eq!(value["channels"].as_array().map(Vec::len), Some(3));
    // 1e5 counts are 1 m/s² there, and one count is said to be 1e-9 m/s².
    let pga = number(&value, "/channels/0/pga");
    assert!((pga / 1.4917e-4 - 1.0).abs() < 1e-3, "{pga}");
    // A unit that makes it no ground motion is taken, and said to be likely wrong.
    hati_with(python, records, &["record", "counts.mseed", "--unit", "g"]).exits(0).tells(&[
        "implausible",
        "read in g",
        "the unit is likely wrong",
    ]);
    hati_with(python, records, &["record", "east.knet", "--unit", "furlong"])
        .exits(2)
        .tells(&["unknown unit", "cm/s2"]);
}

/// One bad file does not stop the others; the table tells what was found, the messages what was refused.
#[test]
fn a_batch_goes_on_past_what_is_refused() {
    let Some(python) = interpreter() else { return };
    let fixtures = fixtures(python);
    let files = ["record", "gap.mseed", "east.knet", "no_such.sac", "pickle2.mseed", "acceleration.sac"];
    let answer = hati_with(python, fixtures.path(), &files).exits(2);
    assert_eq!(answer.stdout.matches(" samples, step ").count(), 2, "{}", answer.stdout);
    let answer = answer.tells(&["gap of 0.5", "no_such.sac: no such file", "is a Python pickle"]);
    assert_eq!(answer.stderr.matches("help:").count(), 3, "{}", answer.stderr);
    let value = hati_with(python, fixtures.path(), &[&["--json"], &files[..]].concat()).exits(2).json();
    assert_eq!(value["channels"].as_array().map(Vec::len), Some(2));
    assert_eq!(value["recordings"].as_array().map(Vec::len), Some(2));
    let refused: Vec<&str> =
        value["refused"].as_array().expect("a list").iter().filter_map(|r| r["what"].as_str()).collect();
    assert_eq!(refused, ["gap.mseed", "no_such.sac", "pickle2.mseed"]);
    assert_eq!(value["exit"], 2);
}

/// The steps that are asked for are done in their order, and a step that cannot be done names the recording.
#[test]
fn steps_of_processing() {
    let Some(python) = interpreter() else { return };
    let fixtures = fixtures(python);
    let records = fixtures.path();
    let process = |steps: &[&str]| -> Vec<String> {
        let words = steps.iter().flat_map(|s| ["--process".to_owned(), (*s).to_owned()]);
        ["record", "--json", "east.knet"].map(str::to_owned).into_iter().chain(words).collect()
    };
    let run = |steps: &[&str]| {
        let arguments = process(steps);
        let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
        hati_with(python, records, &arguments)
    };
    let names = |answer: &crate::program::Answer| -> Vec<String> {
        let value = answer.json();
        let steps = value["channels"][0]["steps"].as_array().expect("steps").clone();
        steps.iter().skip(1).map(|s| s["name"].as_str().unwrap_or("").to_owned()).collect()
    };
    assert_eq!(names(&run(&[]).exits(0)), ["demean"]);
    assert!(names(&run(&["none"]).exits(0)).is_empty());
    let asked = ["trim from=2 to=12", "demean", "scale pga=3"];
    let answer = run(&asked).exits(0);
    assert_eq!(names(&answer), ["trim", "demean", "scale"]);
    let value = answer.json();
    assert!((number(&value, "/channels/0/pga") - 3.0).abs() < 1e-12);
    assert_eq!(number(&value, "/recordings/0/npts"), 1001.0);
    assert_eq!(number(&value, "/channels/0/npts"), 2000.0);
    let warnings = value["recordings"][0]["warnings"].to_string();
    assert!(warnings.contains("scaled by 2."), "{warnings}");
    run(&["none", "demean"]).exits(2).tells(&["--process none: stands alone"]);
    run(&["fliter f_min=1"]).exits(2).tells(&["fliter", "did you mean \"filter\"?"]);
    run(&["filter f_min=60"]).exits(2).tells(&["HATI01", "f_min = 60", "Nyquist"]);
    run(&["rotate angle=30"]).exits(2).tells(&["HATI01", "rotate"]);
}

#[test]
fn the_packaged_record_is_read() {
    let Some(python) = interpreter() else { return };
    let name = "obspy:io/nied/tests/data/test.knet";
    let value = hati_with(python, folder().path(), &["record", "--json", name]).exits(0).json();
    let channel = &value["channels"][0];
    assert_eq!((number(channel, "/npts"), number(channel, "/dt")), (5900.0, 0.01));
    assert_eq!(channel["start"], "1996-08-10T18:12:24.000000Z");
}

#[test]
fn what_is_no_record_is_refused_and_not_opened() {
    let Some(python) = interpreter() else { return };
    let fixtures = fixtures(python);
    let records = fixtures.path();
    let folder = folder();
    let marker = records.join("marker");
    for protocol in 0..=5 {
        let pickle = records.join(format!("pickle{protocol}.mseed")).display().to_string();
        hati_with(python, folder.path(), &["record", &pickle]).exits(2).prints_nothing().tells(&[&pickle]);
        hati_with(python, folder.path(), &["record", "--json", &pickle]).fails_in_json(2, &[&pickle]);
    }
    let plain = records.join("pickle2.mseed").display().to_string();
    hati_with(python, folder.path(), &["record", &plain])
        .exits(2)
        .tells(&["is a Python pickle", "not opened"]);
    let behind = records.join("behind2.mseed").display().to_string();
    hati_with(python, folder.path(), &["record", &behind]).exits(2).prints_nothing();
    assert!(!marker.exists(), "a pickle was executed");
    let gap = records.join("gap.mseed").display().to_string();
    hati_with(python, folder.path(), &["record", &gap]).exits(2).tells(&["gap of 0.500000 s"]);
}

#[test]
fn a_wrong_place_needs_no_python_to_be_refused() {
    let folder = folder();
    std::fs::create_dir(folder.path().join("inside")).expect("a folder");
    hati(folder.path(), &["record", "gone.mseed"])
        .exits(2)
        .prints_nothing()
        .tells(&["gone.mseed: no such file"]);
    hati(folder.path(), &["record", "inside"]).exits(2).prints_nothing().tells(&["inside: is a folder"]);
    hati(folder.path(), &["record", "--json", "inside"]).fails_in_json(2, &["is a folder", "help:"]);
    hati(folder.path(), &["record", "https://example.org/a.mseed"]).exits(2).tells(&["network address"]);
    hati(folder.path(), &["record", "*.mseed"]).exits(2).tells(&["wildcards"]);
}

#[test]
fn missing_python_is_told_with_the_remedy() {
    let folder = folder();
    crate::program::write(folder.path(), "a.sac", &"x".repeat(700));
    let name = "obspy:io/nied/tests/data/test.knet";
    let mut command = crate::program::command(folder.path(), &["record", name]);
    let output = command.env("HATI_PYTHON", "/nowhere/python").output().expect("start");
    crate::program::Answer::from(output).exits(2).prints_nothing().tells(&["/nowhere/python", "make setup"]);
}
