//! Which files `hati record` takes for one recording, and what it says of those that it does not.
#![cfg(unix)]

use std::fmt::Write as _;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

use crate::program::{Answer, command, folder, hati, number, read_json, write};
use crate::python::{fixtures, hati_with, interpreter};

/// A PEER file: `event` is its second line.
fn peer(folder: &Path, name: &str, event: &str, dt: &str, samples: u32) {
    let mut text = format!(
        "PEER STRONG MOTION DATABASE RECORD\n{event}\nACCELERATION TIME SERIES IN UNITS OF G\nNPTS= {samples}, DT= {dt} SEC\n"
    );
    for i in 0..samples {
        let t = 0.01 * f64::from(i);
        let _ = writeln!(text, "{:.6}", 0.2 * (9.0 * t).sin() * (-(t - 5.0).powi(2) / 4.0).exp());
    }
    write(folder, name, &text);
}

/// Components and warnings of each recording.
fn recordings(answer: &Answer) -> Vec<(usize, String)> {
    let value = answer.json();
    let list = value["recordings"].as_array().expect("a list").clone();
    let count = |r: &serde_json::Value| r["channels"].as_array().map_or(0, Vec::len);
    list.iter().map(|r| (count(r), r["warnings"].to_string())).collect()
}

fn look(python: &Path, folder: &Path, words: &[&str]) -> Vec<(usize, String)> {
    recordings(&hati_with(python, folder, &[&["record", "--json"], words].concat()).exits(0))
}

#[test]
fn files_without_a_start_are_one_recording_only_where_nothing_speaks_against_it() {
    let Some(python) = interpreter() else { return };
    let folder = folder();
    let cwd = folder.path();
    peer(cwd, "a090.AT2", "IMPERIAL VALLEY, 10/15/79, EL CENTRO, 090", ".0100", 1000);
    peer(cwd, "a180.AT2", "IMPERIAL VALLEY, 10/15/79, EL CENTRO, 000", ".0100", 1000);
    peer(cwd, "b000.AT2", "SUPERSTITION HILLS, 11/24/87, EL CENTRO, 000", ".0100", 1000);
    peer(cwd, "short.AT2", "IMPERIAL VALLEY, 10/15/79, EL CENTRO, 000", ".0100", 900);
    peer(cwd, "coarse.AT2", "IMPERIAL VALLEY, 10/15/79, EL CENTRO, 000", ".0200", 1000);
    let one = look(python, cwd, &["a090.AT2", "a180.AT2"]);
    assert_eq!(one.len(), 1, "{one:?}");
    assert!(one[0].0 == 2 && one[0].1.contains("taken to begin together"), "{one:?}");
    let answer = hati_with(python, cwd, &["record", "a090.AT2", "a180.AT2", "--out", "r"]).exits(0);
    assert!(answer.stdout.contains("  azimuth in the file: x 90°, y 0°\n"), "{}", answer.stdout);
    assert_eq!(read_json(cwd.join("r/record.json"))["channels"][0]["azimuth_deg"], 90.0);
    let page = std::fs::read_to_string(cwd.join("r/report.html")).expect("a page");
    assert!(page.contains("<dt>azimuth in the file</dt><dd>90° clockwise from north</dd>"));
    for (other, why) in [
        ("b000.AT2", "the files name different events"),
        ("short.AT2", "1000 samples stand against 900"),
        ("coarse.AT2", "a step of 0.01 s against 0.02 s"),
    ] {
        let two = look(python, cwd, &["a090.AT2", other]);
        assert_eq!(two.len(), 2, "{other}: {two:?}");
        for (count, warnings) in &two {
            assert_eq!(*count, 1, "{other}");
            for words in ["not one recording", "a090.AT2", other, "in a scene"] {
                assert!(warnings.contains(words), "{other}: no {words} in {warnings}");
            }
        }
        assert!(two[0].1.contains(why), "{other}: {two:?}");
    }
    // The same of a pair that stands askew.
    peer(cwd, "a042.AT2", "IMPERIAL VALLEY, 10/15/79, EL CENTRO, 042", ".0100", 1000);
    peer(cwd, "a132.AT2", "IMPERIAL VALLEY, 10/15/79, EL CENTRO, 132", ".0100", 1000);
    peer(cwd, "b132.AT2", "SUPERSTITION HILLS, 11/24/87, EL CENTRO, 132", ".0100", 1000);
    assert_eq!(look(python, cwd, &["a042.AT2", "a132.AT2"]).len(), 1);
    let two = look(python, cwd, &["a042.AT2", "b132.AT2"]);
    assert!(two.len() == 2 && two[0].1.contains("different events"), "{two:?}");
    // A direction that comes twice.
    peer(cwd, "again.AT2", "IMPERIAL VALLEY, 10/15/79, EL CENTRO, 090", ".0100", 1000);
    let three = look(python, cwd, &["a090.AT2", "a180.AT2", "again.AT2"]);
    assert!(three.iter().any(|(_, warnings)| warnings.contains("the direction x comes twice")), "{three:?}");
}

#[test]
fn a_cut_to_the_common_time_is_told() {
    let Some(python) = interpreter() else { return };
    let folder = folder();
    let script = "import sys, numpy as np\n\
        from obspy import Stream, Trace, UTCDateTime\n\
        out = Stream()\n\
        for i, code in enumerate(('HNE', 'HNN')):\n\
        \x20   n = 2000 - 100 * i\n\
        \x20   t = np.arange(n) * 0.01\n\
        \x20   a = 1000 * np.sin(9 * t) * np.exp(-((t - 9) / 3) ** 2)\n\
        \x20   head = dict(network='XX', station='CUT', channel=code, delta=0.01, starttime=UTCDateTime(2030, 1, 2) + i)\n\
        \x20   out.append(Trace(data=np.round(a).astype(np.int32), header=head))\n\
        out.write(sys.argv[1], format='MSEED')\n";
    let status =
        Command::new(python).args(["-I", "-c", script]).arg(folder.path().join("cut.mseed")).status();
    assert!(status.is_ok_and(|status| status.success()));
    let found = look(python, folder.path(), &["cut.mseed", "--unit", "mm/s2"]);
    let told = "cut to the time common to all components: x loses 100 samples at the start";
    assert!(found.len() == 1 && found[0].1.contains(told), "{found:?}");
}

/// A unit of another quantity than the file or the channel's code says is taken, and told.
#[test]
fn a_unit_of_another_quantity_is_told() {
    let Some(python) = interpreter() else { return };
    let fixtures = fixtures(python);
    for (file, unit, words) in [
        ("seismometer.mseed", "nm/s2", "its code names a velocity seismometer"),
        ("counts.mseed", "nm/s", "its code names an accelerometer"),
        ("east.knet", "mm/s", "its file states counts × scale factor (gal/count), an acceleration"),
    ] {
        let found = look(python, fixtures.path(), &[file, "--unit", unit]);
        assert!(found[0].1.contains(words), "{file}: {found:?}");
    }
    let right = look(python, fixtures.path(), &["counts.mseed", "--unit", "nm/s2"]);
    assert!(!right[0].1.contains("where its"), "{right:?}");
}

/// The duration that is printed is one that `trim` takes.
#[test]
fn the_printed_end_can_be_trimmed_to() {
    let Some(python) = interpreter() else { return };
    let fixtures = fixtures(python);
    let answer = hati_with(python, fixtures.path(), &["record", "east.knet"]).exits(0);
    let end = answer.stdout.split("0 to ").nth(1).and_then(|rest| rest.split(" s,").next()).expect("an end");
    let step = format!("trim from=5 to={end}");
    let value = hati_with(python, fixtures.path(), &["record", "--json", "east.knet", "--process", &step]);
    assert_eq!(number(&value.exits(0).json(), "/recordings/0/npts"), 1500.0);
}

#[test]
fn time_steps_out_of_range_and_pipes_are_refused_at_once() {
    let folder = folder();
    for dt in ["0", "nan", "inf", "-1", "1e-9", "1e9"] {
        hati(folder.path(), &["record", "a.csv", "--dt", dt]).exits(2).prints_nothing().tells(&[
            "--dt",
            dt,
            "1e-6 to 100",
        ]);
    }
    hati(folder.path(), &["record", "a.csv", "--process", "filter,f_min=0.1"])
        .exits(2)
        .prints_nothing()
        .tells(&["a comma follows the step's word", "'filter f_min=0.1'"]);
    let pipe = folder.path().join("pipe");
    assert!(Command::new("mkfifo").arg(&pipe).status().is_ok_and(|status| status.success()));
    hati(folder.path(), &["record", "--from", "pipe"])
        .exits(2)
        .prints_nothing()
        .tells(&["pipe", "not a regular file"]);
}

/// Interrupted at any time, the program ends with 5 and one line, and the old page is there, whole.
#[test]
fn an_interrupt_leaves_the_old_page_whole() {
    let Some(python) = interpreter() else { return };
    let fixtures = fixtures(python);
    let cwd = fixtures.path();
    let words = ["record", "counts.mseed", "--unit", "nm/s2", "--out", "r"];
    hati_with(python, cwd, &words).exits(0);
    let account = read_json(cwd.join("r/record.json"));
    let slow = ["--process", "pad before=4000", "--process", "filter f_min=0.5 f_max=20"];
    let mut interrupted = 0;
    for (signal, wait) in [("-INT", 300), ("-TERM", 900), ("-INT", 1500)] {
        let mut command = command(cwd, &[&words[..], &slow].concat());
        command.env("HATI_PYTHON", python).stdout(Stdio::piped()).stderr(Stdio::piped());
        let child = command.spawn().expect("start");
        std::thread::sleep(Duration::from_millis(wait));
        let _ = Command::new("kill").args([signal, &child.id().to_string()]).status();
        let output = child.wait_with_output().expect("end");
        if output.status.code() == Some(0) {
            continue;
        }
        interrupted += 1;
        let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(5), "{stderr}");
        assert!(stderr.ends_with("are whole\n") && stderr.contains("hati: interrupted"), "{stderr}");
        assert_eq!(read_json(cwd.join("r/record.json")), account);
        assert!(
            std::fs::read_to_string(cwd.join("r/report.html")).is_ok_and(|page| page.ends_with("</html>\n"))
        );
        let left = std::fs::read_dir(cwd.join("r")).expect("a folder").flatten();
        assert!(left.into_iter().all(|entry| !entry.file_name().to_string_lossy().contains(".part")));
    }
    assert!(interrupted > 0, "the program was never caught under way");
}

/// The page of a match shows its target, and all that is integrated is so from rest.
#[test]
fn the_page_of_a_match_shows_the_target() {
    let Some(python) = interpreter() else { return };
    let fixtures = fixtures(python);
    let cwd = fixtures.path();
    for (damping, in_five_percent) in [("0.05", true), ("0.07", false)] {
        let step = format!(
            "match spectrum.kind=rg160 spectrum.pga=2 spectrum.damping={damping} periods=[0.1,2] tolerance=0.2"
        );
        let words = ["record", "east.knet", "--process", "demean", "--process", &step, "--out", "r"];
        let answer = hati_with(python, cwd, &words).exits(0);
        assert!(answer.stdout.contains("rg160, pga 2 m/s²"), "{}", answer.stdout);
        assert!(answer.stdout.lines().all(|line| line.chars().count() <= 100), "{}", answer.stdout);
        let page = std::fs::read_to_string(cwd.join("r/report.html")).expect("a page");
        for text in ["Match to the target", "± 20 %", "seed, scaled", "step now", "from rest, as a model"] {
            assert!(page.contains(text), "no {text}");
        }
        let spectra = std::fs::read_to_string(cwd.join("r/figures/response-spectra.svg")).expect("a figure");
        assert_eq!(spectra.contains(">target<"), in_five_percent, "{damping}");
        let csv = std::fs::read_to_string(cwd.join("r/figures/target-spectra.csv")).expect("numbers");
        let mut rows = csv
            .lines()
            .skip(1)
            .map(|line| -> Vec<f64> { line.split(',').filter_map(|value| value.parse().ok()).collect() });
        assert!(rows.all(|row| !(0.1..=2.0).contains(&row[0]) || (row[1] / row[2] - 1.0).abs() <= 0.2));
        // The peaks are those of the integrals from rest, which the match itself tells.
        let summary = read_json(cwd.join("r/record.json"));
        let found = &summary["steps"][2]["found"]["x"];
        for key in ["pgv", "pgd"] {
            let own =
                found[format!("{key}_m{}", if key == "pgv" { "_s" } else { "" })].as_f64().expect("a peak");
            let shown = number(&summary, &format!("/measures/x/{key}"));
            assert!((shown / own - 1.0).abs() < 5e-3, "{key}: {shown} against {own}");
        }
    }
}
