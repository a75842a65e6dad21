//! `hati record --out` and `--from`: the page, the motion as files, and the same motion made again.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

use crate::disk::SmallDisk;
use crate::program::{Answer, folder, hati, number, read_json, say};
use crate::python::{fixtures, hati_with, interpreter};

/// Makes `three.mseed` in `folder`: counts of 1 mm/s² of three different components, `seconds` at 200 Hz.
fn three_components(python: &Path, folder: &Path, seconds: u32) -> PathBuf {
    let script = format!(
        "import sys, numpy as np\n\
         from obspy import Stream, Trace, UTCDateTime\n\
         n, dt = {seconds} * 200, 0.005\n\
         t = np.arange(n) * dt\n\
         out = Stream()\n\
         for i, (code, f, peak) in enumerate((('HNE', 1.3, 2.0), ('HNN', 2.1, 2.5), ('HNZ', 6.0, 1.2))):\n\
         \x20   pulse = np.exp(-((t - 0.4 * n * dt - i) / 4.0) ** 2)\n\
         \x20   noise = np.random.default_rng(i).standard_normal(n) * 2e-3\n\
         \x20   a = peak * pulse * np.sin(2 * np.pi * f * t) + noise\n\
         \x20   head = dict(network='XX', station='THREE', channel=code, delta=dt, starttime=UTCDateTime(2030, 1, 2))\n\
         \x20   out.append(Trace(data=np.round(a * 1e3).astype(np.int32), header=head))\n\
         out.write(sys.argv[1], format='MSEED')\n"
    );
    let path = folder.join("three.mseed");
    let status = Command::new(python).args(["-I", "-c", &script]).arg(&path).status();
    assert!(status.is_ok_and(|status| status.success()), "the record could not be made");
    path
}

fn record(python: &Path, cwd: &Path, words: &[&str]) -> Answer {
    hati_with(python, cwd, &[&["record"], words].concat())
}

fn read(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// A column of a CSV file.
fn column(path: &Path, name: &str) -> Vec<f64> {
    let text = read(path);
    let mut lines = text.lines().filter(|line| !line.starts_with('#'));
    let index = lines
        .next()
        .and_then(|head| head.split(',').position(|h| h == name))
        .unwrap_or_else(|| panic!("no column {name} in {}", path.display()));
    lines.filter_map(|line| line.split(',').nth(index).and_then(|v| v.parse().ok())).collect()
}

#[test]
fn the_page_shows_what_was_found_done_and_measured() {
    let Some(python) = interpreter() else { return };
    let folder = folder();
    three_components(python, folder.path(), 40);
    let words =
        ["three.mseed", "--unit", "mm/s2", "--process", "demean", "--process", "scale pga=3", "--out", "r"];
    let answer = record(python, folder.path(), &words)
        .exits(0)
        .tells(&["warning: XX.THREE.HN: the motion is scaled by 1"]);
    assert!(answer.stdout.ends_with("r/report.html\n"), "{}", answer.stdout);
    let run = folder.path().join("r");
    let html = read(&run.join("report.html"));
    let summary = read_json(run.join("record.json"));
    let sha256 = summary["channels"][0]["sha256"].as_str().expect("a hash").to_owned();
    for text in [
        "XX.THREE.HN",
        "three.mseed",
        &sha256,
        "<b>mm/s2</b>",
        "you (the file’s own statement is set aside)",
        "scaled by 1",
        "What was done, in order",
        "the mean is taken off",
        "RotD50",
        "RotD100",
        "D5–75",
        "CAV",
        "Konno–Ohmachi",
    ] {
        assert!(html.contains(text), "the page lacks {text:?}");
    }
    for address in ["https://", "<link", "@import", "/tmp/"] {
        assert!(!html.contains(address), "{address}");
    }
    for name in [
        "acceleration",
        "velocity",
        "displacement",
        "response-spectra",
        "fourier-amplitude",
        "horizontal-to-vertical",
        "husid",
        "cumulative-absolute-velocity",
    ] {
        let svg = read(&run.join(format!("figures/{name}.svg")));
        assert!(html.contains(svg.trim_end()), "{name} is not on the page");
        assert!(!svg.contains("NaN") && !svg.contains("inf"), "{name} has places that are no numbers");
        let csv = read(&run.join(format!("figures/{name}.csv")));
        let columns = csv.lines().next().map_or(0, |head| head.split(',').count());
        assert!(columns >= 2 && csv.lines().all(|line| line.split(',').count() == columns), "{name}.csv");
    }
}

/// The numbers beside the figures agree with the table and with each other.
#[test]
fn numbers_beside_the_figures_agree() {
    let Some(python) = interpreter() else { return };
    let folder = folder();
    three_components(python, folder.path(), 40);
    record(python, folder.path(), &["three.mseed", "--unit", "mm/s2", "--out", "r"]).exits(0);
    let run = folder.path().join("r");
    let summary = read_json(run.join("record.json"));
    let figure = |name: &str, of: &str| column(&run.join(format!("figures/{name}.csv")), of);
    let peak = |values: &[f64]| values.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    for axis in ["x", "y", "z"] {
        let measure = |key: &str| number(&summary, &format!("/measures/{axis}/{key}"));
        for (name, of, key) in [
            ("acceleration", "acceleration_m_s2", "pga"),
            ("velocity", "velocity_m_s", "pgv"),
            ("displacement", "displacement_m", "pgd"),
            ("cumulative-absolute-velocity", "cav_m_s", "cav"),
        ] {
            let found = peak(&figure(name, &format!("{axis}_{of}")));
            let told = measure(key);
            // PGV and PGD may lie between two samples of the history: 1 − cos(π/33) of a sine of 6 Hz at 200 Hz.
            let limit = if matches!(key, "pgv" | "pgd") { 5e-3 } else { 1e-6 };
            assert!((found / told - 1.0).abs() < limit, "{axis} {key}: {found} and {told}");
        }
        // The label of each history has the digits of the table.
        let page = read(&run.join("report.html"));
        for (name, key) in [("acceleration", "pga"), ("velocity", "pgv"), ("displacement", "pgd")] {
            let svg = read(&run.join(format!("figures/{name}.svg")));
            let labels: Vec<&str> =
                svg.split("peak ").skip(1).filter_map(|text| text.split(' ').next()).collect();
            let label = labels[["x", "y", "z"].iter().position(|a| *a == axis).expect("an axis")];
            assert!(
                (label.parse::<f64>().expect("a number") / measure(key) - 1.0).abs() < 5e-4,
                "{axis} {key}"
            );
            assert!(page.contains(&format!("<td>{label}</td>")), "{axis} {key}: no {label} in the table");
        }
        assert!(
            (figure("husid", &format!("{axis}_husid")).last().copied().unwrap_or(0.0) - 1.0).abs() < 1e-9
        );
    }
    let spectra = |of: &str| figure("response-spectra", of);
    let periods = spectra("period_s");
    assert!(periods.len() >= 100 && periods[0] == 0.01 && periods[periods.len() - 1] == 10.0);
    let (x, y) = (spectra("x_psa_m_s2"), spectra("y_psa_m_s2"));
    let (median, largest) = (spectra("rotd50_psa_m_s2"), spectra("rotd100_psa_m_s2"));
    for i in 0..periods.len() {
        assert!(largest[i] >= x[i].max(y[i]) * (1.0 - 1e-6), "{} s", periods[i]);
        // No direction sees more than both components' peaks together.
        assert!(largest[i] <= x[i].hypot(y[i]) * (1.0 + 1e-6) && median[i] <= largest[i], "{} s", periods[i]);
        let omega = std::f64::consts::TAU / periods[i];
        assert!((spectra("x_sd_m")[i] * omega * omega / x[i] - 1.0).abs() < 1e-6);
    }
    // The horizontals sway at 1.3 and 2.1 Hz, the vertical at 6 Hz.
    let (f, ratio) = (
        figure("horizontal-to-vertical", "frequency_hz"),
        figure("horizontal-to-vertical", "horizontal_to_vertical_1"),
    );
    let at = |wanted: f64| ratio[f.iter().position(|f| *f >= wanted).expect("inside")];
    assert!(at(1.65) > 5.0 && at(6.0) < 0.2, "{} and {}", at(1.65), at(6.0));
}

/// The motion is made again from its own account, to the last bit, from the CSV and from `record.json`.
#[test]
fn a_motion_is_made_again_to_the_last_bit() {
    let Some(python) = interpreter() else { return };
    let folder = folder();
    three_components(python, folder.path(), 20);
    // Numbers that no short decimal holds.
    let steps = [
        "demean",
        "filter f_min=0.30000000000000004 f_max=33.333333333333336 causal=true",
        "rotate angle=33.333333333333336",
        "trim from=1 to=18",
        "taper start=0.1 end=1",
        "resample dt=0.01",
        "scale factor=0.1",
        "baseline order=3",
        "rest",
    ];
    let mut words = vec!["three.mseed", "--unit", "mm/s2", "--out", "first"];
    steps.iter().for_each(|step| words.extend(["--process", step]));
    record(python, folder.path(), &words).exits(0);
    let first = read(&folder.path().join("first/motion.csv"));
    for (from, out) in [("first/motion.csv", "second"), ("first/record.json", "third")] {
        record(python, folder.path(), &["--from", from, "--out", out]).exits(0);
        assert!(first == read(&folder.path().join(out).join("motion.csv")), "{from}: another motion");
        assert_eq!(
            read_json(folder.path().join("first/record.json")),
            read_json(folder.path().join(out).join("record.json"))
        );
    }
    // The record is also found beside the file that tells of it, from another folder.
    let moved = crate::program::folder();
    for name in ["three.mseed", "first/motion.csv"] {
        let to = moved.path().join(Path::new(name).file_name().expect("a name"));
        std::fs::copy(folder.path().join(name), to).expect("a copy");
    }
    let elsewhere = crate::program::folder();
    let from = moved.path().join("motion.csv").display().to_string();
    record(python, elsewhere.path(), &["--from", &from, "--out", "again"]).exits(0);
    assert!(first == read(&elsewhere.path().join("again/motion.csv")), "another motion");
}

#[test]
fn an_account_without_its_record_is_refused() {
    let Some(python) = interpreter() else { return };
    let folder = folder();
    let source = three_components(python, folder.path(), 10);
    record(python, folder.path(), &["three.mseed", "--unit", "mm/s2", "--out", "r"]).exits(0);
    let mut bytes = std::fs::read(&source).expect("the record");
    // A station's name: the file stays sound, its hash does not.
    bytes[8] = b'Q';
    std::fs::write(&source, &bytes).expect("written");
    record(python, folder.path(), &["--from", "r/motion.csv"])
        .exits(2)
        .prints_nothing()
        .tells(&["three.mseed", "help:"]);
    bytes[8] = b'T';
    bytes[63] ^= 0xff;
    std::fs::write(&source, &bytes).expect("written");
    record(python, folder.path(), &["--from", "r/motion.csv"]).exits(2).prints_nothing().tells(&["help:"]);
    std::fs::remove_file(&source).expect("gone");
    record(python, folder.path(), &["--from", "r/motion.csv"]).exits(2).prints_nothing().tells(&[
        "three.mseed",
        "is not there",
        "put the record beside",
    ]);
    crate::program::write(folder.path(), "foreign.csv", "# a head\ntime,a\n0,1\n");
    record(python, folder.path(), &["--from", "foreign.csv"])
        .exits(2)
        .tells(&["does not say how", "# hati-motion:"]);
    crate::program::write(folder.path(), "new.json", "{\"motion\": {\"version\": 7}}");
    record(python, folder.path(), &["--from", "new.json"]).exits(2).tells(&["new.json", "help:"]);
    record(python, folder.path(), &["--from", "no.csv"]).exits(2).tells(&["no.csv: cannot be read"]);
    record(python, folder.path(), &["--from", "r/motion.csv", "three.mseed"]).exits(2).prints_nothing();
}

/// Another program finds in the files what their formats promise, and so does this one.
#[test]
fn the_motion_in_files_of_other_programs() {
    let Some(python) = interpreter() else { return };
    let folder = folder();
    three_components(python, folder.path(), 20);
    let words = ["three.mseed", "--unit", "mm/s2", "--out", "r", "--write", "csv,mseed,sac"];
    record(python, folder.path(), &words).exits(0);
    let script = "import json, obspy\n\
                  s = obspy.read('r/motion.mseed')\n\
                  out = [[t.id, t.stats.mseed.encoding, t.stats.npts, t.stats.delta, abs(t.data).max()] for t in s]\n\
                  a = obspy.read('r/motion.y.sac')[0]\n\
                  out.append([a.id, int(a.stats.sac.idep), a.stats.npts, a.stats.delta, float(abs(a.data).max())])\n\
                  print(json.dumps(out))\n";
    let output =
        Command::new(python).args(["-I", "-c", script]).current_dir(folder.path()).output().expect("Python");
    let found: serde_json::Value = serde_json::from_slice(&output.stdout)
        .unwrap_or_else(|e| panic!("{e}: {}", String::from_utf8_lossy(&output.stderr)));
    let summary = read_json(folder.path().join("r/record.json"));
    for (i, (axis, code)) in [("x", "HNE"), ("y", "HNN"), ("z", "HNZ")].into_iter().enumerate() {
        let pga = number(&summary, &format!("/measures/{axis}/pga"));
        assert_eq!(found[i][0], format!("XX.THREE..{code}"));
        assert_eq!((&found[i][1], number(&found[i], "/2")), (&"FLOAT64".into(), 4000.0));
        assert_eq!(number(&found[i], "/4"), pga, "miniSEED keeps every bit");
    }
    // Acceleration in nm/s² under IDEP 8, never m/s².
    assert_eq!(found[3][1], 8);
    let pga = number(&summary, "/measures/y/pga");
    assert!((number(&found[3], "/4") / (pga * 1e9) - 1.0).abs() < 1e-6);
    assert_eq!(summary["files"]["motion.y.sac"]["unit"], "nm/s²");
    assert_eq!(summary["files"]["motion.mseed"]["unit"], "m/s²");
    let back =
        record(python, folder.path(), &["r/motion.y.sac", "--process", "none", "--json"]).exits(0).json();
    assert!((number(&back, "/channels/0/pga") / pga - 1.0).abs() < 1e-6);
    let back =
        record(python, folder.path(), &["r/motion.csv", "--process", "none", "--json"]).exits(0).json();
    assert_eq!(number(&back, "/channels/1/pga"), pga, "the CSV file keeps every bit");
}

#[test]
fn a_batch_has_a_folder_per_recording_and_an_index() {
    let Some(python) = interpreter() else { return };
    let fixtures = fixtures(python);
    let records = fixtures.path();
    three_components(python, records, 10);
    let words = ["three.mseed", "gap.mseed", "east.knet", "--unit", "mm/s2", "--out", "batch"];
    let answer = record(python, records, &words).exits(2).tells(&["gap of 0.5"]);
    assert!(answer.stdout.ends_with("batch/index.html\n"), "{}", answer.stdout);
    let index = read(&records.join("batch/index.html"));
    let all = read_json(records.join("batch/records.json"));
    let names: Vec<&str> =
        all["recordings"].as_array().expect("a list").iter().filter_map(|n| n.as_str()).collect();
    assert_eq!(names.len(), 2);
    for name in names {
        assert!(records.join("batch").join(name).join("report.html").is_file(), "{name}");
        assert!(records.join("batch").join(name).join("motion.csv").is_file(), "{name}");
        assert!(index.contains(&format!("href=\"{name}/report.html\"")), "{name}");
    }
    assert!(index.contains("1 refused") && index.contains("gap of 0.5"));
}

#[test]
fn only_own_outputs_are_replaced() {
    let Some(python) = interpreter() else { return };
    let folder = folder();
    let cwd = folder.path();
    three_components(python, cwd, 10);
    let out = |more: &[&str]| {
        record(python, cwd, &[&["three.mseed", "--unit", "mm/s2", "--out", "r"], more].concat())
    };
    out(&["--write", "mseed,sac"]).exits(0);
    assert!(cwd.join("r/motion.x.sac").is_file() && !cwd.join("r/motion.csv").exists());
    // What the second call does not write does not stay from the first.
    out(&["--channel", "HNZ"]).exits(0);
    assert!(cwd.join("r/motion.csv").is_file());
    for name in ["motion.x.sac", "motion.mseed", "figures/horizontal-to-vertical.svg"] {
        assert!(!cwd.join("r").join(name).exists(), "{name}");
    }
    let names: Vec<String> = std::fs::read_dir(cwd.join("r"))
        .expect("the folder")
        .map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned())
        .collect();
    assert!(names.iter().all(|name| !name.ends_with(".part")), "{names:?}");
    // Neither a foreign file nor the record itself is touched.
    std::fs::create_dir(cwd.join("mine")).expect("a folder");
    crate::program::write(&cwd.join("mine"), "motion.csv", "my own\n");
    let words = ["three.mseed", "--unit", "mm/s2", "--out", "mine"];
    record(python, cwd, &words).exits(2).tells(&[
        "mine/motion.csv: is there already",
        "not replaced",
        "--out",
    ]);
    assert_eq!(read(&cwd.join("mine/motion.csv")), "my own\n");
    assert!(!cwd.join("mine/record.json").exists());
    record(python, cwd, &["r/motion.csv", "--out", "r"])
        .exits(2)
        .tells(&["is one of the records that were read"]);
    assert!(cwd.join("r/motion.csv").is_file());
}

#[test]
fn options_that_do_not_go_together() {
    let folder = folder();
    let refused = |words: &[&str], tells: &[&str]| {
        let words = [&["record", "a.mseed"], words].concat();
        hati(folder.path(), &words).exits(2).prints_nothing().tells(tells);
    };
    refused(&["--write", "csv"], &["--out"]);
    refused(&["--write", "tsv", "--out", "r"], &["tsv", "csv, mseed and sac"]);
    refused(&["--pre-filter", "1,2,3,4"], &["--metadata"]);
    refused(&["--metadata", "m.xml", "--pre-filter", "1,2,2,4"], &["four rising"]);
    refused(&["--metadata", "m.xml", "--unit", "gal"], &["--unit"]);
    refused(&["--response", "half", "--metadata", "m.xml"], &["full, sensitivity, stages"]);
    hati(folder.path(), &["record"]).exits(2).prints_nothing().tells(&["<FILES>"]);
}

#[test]
fn a_full_disk_is_the_machines_fault() {
    let Some(python) = interpreter() else { return };
    let folder = folder();
    three_components(python, folder.path(), 60);
    crate::program::write(folder.path(), "taken", "not a folder");
    let words = |out: &'static str| ["three.mseed", "--unit", "mm/s2", "--out", out];
    record(python, folder.path(), &words("taken/r"))
        .exits(4)
        .prints_nothing()
        .tells(&["cannot write into folder"]);
    let mut full = 0;
    for size in ["16k", "700k", "3m"] {
        let Some(disk) = SmallDisk::mount(folder.path(), size) else { return };
        let out = disk.folder.join("r").display().to_string();
        let words = ["three.mseed", "--unit", "mm/s2", "--json", "--out", &out];
        record(python, folder.path(), &words).fails_in_json(4, &["no space left", "--out"]);
        full += 1;
    }
    assert_eq!(full, 3);
}

/// Twenty minutes at 200 Hz, three components: read, processed and on a page in less than 5 s.
#[test]
#[ignore = "a time limit: run it on a machine that does nothing else"]
fn twenty_minutes_in_five_seconds() {
    let Some(python) = interpreter() else { return };
    let folder = folder();
    three_components(python, folder.path(), 1200);
    let begin = Instant::now();
    record(python, folder.path(), &["three.mseed", "--unit", "mm/s2", "--out", "r"]).exits(0);
    let seconds = begin.elapsed().as_secs_f64();
    say(&format!("240 000 samples, three components: {seconds:.2} s"));
    assert_eq!(column(&folder.path().join("r/motion.csv"), "x_m_s2").len(), 240_000);
    assert!(seconds < 5.0, "{seconds} s");
}
