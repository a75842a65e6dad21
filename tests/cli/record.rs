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
    let answer = hati_with(python, fixtures(python).path(), &["record", "east.knet"]).exits(0);
    assert_eq!(answer.stderr, "");
    let lines: Vec<&str> = answer.stdout.lines().collect();
    assert_eq!(lines.len(), 2, "{}", answer.stdout);
    for head in
        ["channel", "npts", "PGA m/s²", "PGV m/s", "PGD m", "Arias m/s", "CAV m/s", "D5-95 s", "band Hz"]
    {
        assert!(lines[0].contains(head), "{head}");
    }
    for cell in ["HATI01", "K-NET", "2000", "0.01", "1.49"] {
        assert!(lines[1].contains(cell), "{cell} in {}", lines[1]);
    }
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
        "give unit = one of",
    ]);
    let value =
        hati_with(python, records, &["record", "--json", "counts.mseed", "--unit", "nm/s2"]).exits(0).json();
    assert_eq!(value["channels"].as_array().map(Vec::len), Some(3));
    // 1e5 counts are 1 m/s² there, and one count is said to be 1e-9 m/s².
    let pga = number(&value, "/channels/0/pga");
    assert!((pga / 1.4917e-4 - 1.0).abs() < 1e-3, "{pga}");
    hati_with(python, records, &["record", "east.knet", "--unit", "furlong"])
        .exits(2)
        .tells(&["unknown unit", "cm/s2"]);
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
