//! Records that must not go in: each kind of bad input through `hati record`, with exit code 2 and the reason in words.
//!
//! Several files go to one call, since a refused one does not stop the others: what is sound among them is
//! still read, and each of the others is told apart with its remedy.

use std::fs::File;
use std::io::Write as _;
use std::path::Path;

use serde_json::Value;

use crate::program::{Answer, command, folder, write};
use crate::python::{fixtures, hati_with, interpreter};

/// A file and what the refusal has to say about it.
type Refusal<'a> = (&'a str, &'a [&'a str]);

/// Asserts that exactly these files were refused, in this order, each for its own reason and with a remedy.
#[track_caller]
fn refuses(answer: &Answer, wanted: &[Refusal]) {
    assert_eq!(answer.code, Some(2), "{}", answer.stderr);
    let value = answer.json();
    assert_eq!(value["exit"], 2);
    let refused = value["refused"].as_array().expect("a list");
    let text = |entry: &Value, key: &str| entry[key].as_str().expect("a text").to_owned();
    let names: Vec<String> = refused.iter().map(|entry| text(entry, "what")).collect();
    let expected: Vec<&str> = wanted.iter().map(|(name, _)| *name).collect();
    assert_eq!(names, expected, "{}", answer.stderr);
    for (entry, (name, words)) in refused.iter().zip(wanted) {
        let error = text(entry, "error");
        assert!(error.starts_with(name), "{name} is not at the beginning of {error:?}");
        for word in *words {
            assert!(error.contains(word), "{name}: {word:?} is missing in {error:?}");
        }
        assert!(answer.stderr.contains(&error), "{name} is told to programs only");
        // An empty file has no other remedy than itself, nor has a single sample.
        let plain = error.ends_with("the file is empty") || error.contains("needs at least 2");
        assert!(plain || error.contains("\n  help: "), "{name} has no remedy: {error:?}");
    }
}

/// The names, behind `record --json` and the options.
fn call<'a>(options: &[&'a str], wanted: &[Refusal<'a>]) -> Vec<&'a str> {
    let names = wanted.iter().map(|(name, _)| *name);
    ["record", "--json"].into_iter().chain(options.iter().copied()).chain(names).collect()
}

/// What is no record for certain is refused without Python, so that nothing is opened that could act.
#[test]
fn refused_before_python_is_asked() {
    let folder = folder();
    let cwd = folder.path();
    let marker = cwd.join("marker");
    write(cwd, "empty.AT2", "");
    std::fs::create_dir(cwd.join("inside")).expect("a folder");
    // A pickle under the name of a record; opened as one, it would write the file `marker`.
    let pickle = b"\x80\x02cbuiltins\nexec\nU\x12open(\"marker\",\"w\")\x85R.";
    std::fs::write(cwd.join("quake.AT2"), pickle).expect("written");
    std::fs::write(cwd.join("quake.zip"), b"PK\x03\x04 and so on").expect("written");
    std::fs::write(cwd.join("quake.csv.gz"), b"\x1f\x8b\x08\x00 and so on").expect("written");
    // 2 GB that take no room on the disk, behind a head that promises a table.
    let mut file = File::create(cwd.join("huge.csv")).expect("a file");
    file.write_all(b"time (s),acc (m/s2)\n0.00,0.1\n0.01,0.2\n").expect("written");
    file.set_len(2 << 30).expect("a sparse file");
    let wanted: [Refusal; 9] = [
        ("empty.AT2", &["the file is empty"]),
        ("quake.AT2", &["is a Python pickle", "not opened", "miniSEED or SAC"]),
        ("huge.csv", &["2147483648 bytes", "above the limit of"]),
        ("https://example.org/quake.mseed", &["network address", "download the file"]),
        ("quake*.mseed", &["wildcards are not expanded"]),
        ("gone.mseed", &["no such file"]),
        ("inside", &["is a folder"]),
        ("quake.zip", &["compressed", "unpack"]),
        ("quake.csv.gz", &["compressed", "unpack"]),
    ];
    let output = command(cwd, &call(&[], &wanted)).env("HATI_PYTHON", "/nowhere/python").output();
    let answer = Answer::from(output.expect("the program starts"));
    refuses(&answer, &wanted);
    assert_eq!(answer.json()["channels"].as_array().map(Vec::len), Some(0));
    assert!(!marker.exists(), "the pickle was run");
}

/// Broken files of the binary formats and of K-NET; the one sound file among them is read all the same.
#[test]
fn broken_binary_records() {
    let Some(python) = interpreter() else { return };
    let fixtures = fixtures(python);
    let wanted: [Refusal; 16] = [
        ("nan.mseed", &["sample 700", "at 7.000000 s", "is NaN", "2 sample(s)"]),
        ("gap.mseed", &["gap of 0.500000 s", "2020-02-03T04:05:14.500000Z"]),
        ("overlap.mseed", &["overlap of 0.500000 s", "2020-02-03T04:05:13.500000Z"]),
        ("rates.mseed", &["mixed sampling", "step 0.01 s", "step 0.02 s"]),
        ("clipped.mseed", &["XX.HATI.00.HNE", "clipped", "117 samples at the extreme value 60000"]),
        ("dead.mseed", &["dead channel", "all 2000 samples are 0"]),
        ("stuck.mseed", &["dead channel", "all 2000 samples are 77"]),
        ("cut.mseed", &["broken miniSEED", "has 512 bytes, but only 312 are left"]),
        ("trailing.mseed", &["broken miniSEED", "1 bytes from byte 3072 on are no record"]),
        ("cut.sac", &["broken SAC", "NPTS = 2000 needs 8632 bytes, the file has 8232"]),
        ("uneven.sac", &["not evenly spaced"]),
        ("short.knet", &["Duration Time is 20 s", "samples last 15.00 s"]),
        ("checksum.gse2", &["hecksum", "CHK 131 != CHK 1"]),
        ("many.gse2", &["99999999 samples", "the whole file has"]),
        ("behind2.mseed", &["broken miniSEED", "are no record"]),
        ("pickle2.mseed", &["is a Python pickle", "not opened"]),
    ];
    let mut words = call(&["--unit", "gal"], &wanted);
    words.push("floats.mseed");
    let answer = hati_with(python, fixtures.path(), &words);
    refuses(&answer, &wanted);
    assert_eq!(answer.json()["channels"][0]["file"], "floats.mseed");
    assert!(!fixtures.path().join("marker").exists(), "a pickle was run");
    // The same for people: nothing on stdout but the table of what was read.
    let words: Vec<&str> = words.into_iter().filter(|word| *word != "--json").collect();
    let answer = hati_with(python, fixtures.path(), &words).exits(2);
    assert_eq!(answer.stdout.matches(" samples, step ").count(), 1, "{}", answer.stdout);
    assert_eq!(answer.stderr.matches("hati: ").count(), wanted.len(), "{}", answer.stderr);
}

/// Two columns under `head`: one motion of 400 samples at 100 Hz, each row as `row(i, acceleration)` writes it.
fn table(head: &str, row: impl Fn(usize, f64) -> String) -> String {
    let motion = |i: usize| {
        let t = 0.01 * f64::from(u32::try_from(i).unwrap_or(0));
        1.5 * (9.0 * t).sin() * (-(t - 2.0).powi(2)).exp()
    };
    (0..400).fold(format!("{head}\n"), |text, i| text + &row(i, motion(i)) + "\n")
}

/// The time of sample `i`, with two digits.
fn time(i: usize) -> String {
    format!("{}.{:02}", i / 100, i % 100)
}

/// A PEER file that announces `npts` samples and holds 400.
fn peer(npts: &str) -> String {
    let head = "PEER STRONG MOTION DATABASE\nSOMEWHERE, STATION, 090\nACCELERATION TIME SERIES IN UNITS OF G";
    table(&format!("{head}\nNPTS= {npts}, DT= .0100 SEC"), |_, a| format!("{a:15.7E}"))
}

/// Writes a table and its damaged copies.
fn write_tables(folder: &Path) {
    const HEAD: &str = "time (s),acc (m/s2)";
    let spoil =
        |name: &str, at: usize, value: &str| {
            let text = table(HEAD, |i, a| {
                if i == at { format!("{},{value}", time(i)) } else { format!("{},{a:.5}", time(i)) }
            });
            write(folder, name, &text);
        };
    let times = |name: &str, time_of: &dyn Fn(usize) -> String| {
        write(folder, name, &table(HEAD, |i, a| format!("{},{a:.5}", time_of(i))));
    };
    times("sound.csv", &time);
    spoil("nan.csv", 100, "NaN");
    spoil("infinite.csv", 100, "-inf");
    spoil("stars.csv", 100, "*******");
    spoil("words.csv", 100, "calm");
    spoil("large.csv", 100, "1e400");
    spoil("hole.csv", 100, "");
    times("gap.csv", &|i| time(if i < 200 { i } else { i + 50 }));
    times("lost.csv", &|i| time(if i < 200 { i } else { i + 1 }));
    times("backwards.csv", &|i| {
        time(if i == 200 {
            199
        } else if i == 199 {
            200
        } else {
            i
        })
    });
    times("rates.csv", &|i| time(if i < 200 { i } else { 2 * i - 200 }));
    write(folder, "still.csv", &table(HEAD, |i, a| format!("{}0,{a:.5}", time(i - usize::from(i > 200)))));
    write(
        folder,
        "signs.csv",
        &table("time (s);acc (m/s2)", |i, a| format!("{};{a:.5}", time(i)).replacen('.', ",", 1)),
    );
    write(folder, "commas.csv", &table("acc (gal)", |i, a| format!("{a:.3},{}", 100 + i).replace('.', "")));
    write(folder, "clipped.csv", &table(HEAD, |i, a| format!("{},{:.5}", time(i), a.clamp(-0.5, 0.5))));
    write(folder, "dead.csv", &table(HEAD, |i, _| format!("{},0.00000", time(i))));
    let cut = table(HEAD, |i, a| format!("{},{a:.5}", time(i)));
    write(folder, "cut.csv", cut.rsplit_once(',').map_or("", |(before, _)| before));
    write(folder, "many.AT2", &peer("500"));
    write(folder, "few.AT2", &peer("300"));
    write(folder, "no_unit.AT2", &peer("400").replace(" IN UNITS OF G", ""));
    write(folder, "furlong.AT2", &peer("400").replace("OF G", "OF FURLONG"));
    write(folder, "still.AT2", &peer("400").replace(".0100", ".0000"));
}

#[test]
fn damaged_tables_and_headers() {
    let Some(python) = interpreter() else { return };
    let folder = folder();
    write_tables(folder.path());
    let wanted: [Refusal; 20] = [
        ("nan.csv", &["line 102", "\"NaN\" is not a finite number"]),
        ("infinite.csv", &["line 102", "\"-inf\" is not a finite number"]),
        ("stars.csv", &["line 102", "\"*******\"", "too wide for its column"]),
        ("words.csv", &["line 102", "calm"]),
        ("large.csv", &["line 102", "\"1e400\" is too large"]),
        ("hole.csv", &["line 102", "empty field"]),
        ("gap.csv", &["line 202", "gap in time", "2.5 s after 1.99 s", "50 sample(s) missing"]),
        ("lost.csv", &["line 202", "gap in time", "1 sample(s) missing at a step of 0.01 s"]),
        ("backwards.csv", &["line 202", "time runs backwards", "1.99 s after 2 s"]),
        ("rates.csv", &["line 203", "2.02 s after 2 s"]),
        ("still.csv", &["line 203", "time stands still", "2 s after 2 s"]),
        ("signs.csv", &["line 2", "mixes decimal points and commas"]),
        ("commas.csv", &["line 2", "the comma may be the decimal sign or separate two columns"]),
        ("clipped.csv", &["clipped", "at the extreme value"]),
        ("dead.csv", &["dead channel", "all 400 samples are 0"]),
        ("cut.csv", &["line 401", "1 numbers in this row, 2 in the first"]),
        ("many.AT2", &["line 4", "NPTS = 500, but 400 numbers follow"]),
        ("few.AT2", &["line 4", "NPTS = 300, but 400 numbers follow"]),
        ("no_unit.AT2", &["no unit", "cm/s2"]),
        ("furlong.AT2", &["FURLONG", "cm/s2"]),
    ];
    let mut words = call(&[], &wanted);
    words.push("sound.csv");
    let answer = hati_with(python, folder.path(), &words);
    refuses(&answer, &wanted);
    assert_eq!(answer.json()["channels"][0]["file"], "sound.csv");
    let wanted: [Refusal; 1] = [("still.AT2", &["line 4", "time step 0 s"])];
    refuses(&hati_with(python, folder.path(), &call(&[], &wanted)), &wanted);
}

/// Spectra are tables of numbers like motions; they are no motion, whatever unit is given.
#[test]
fn spectra_are_no_motions() {
    let Some(python) = interpreter() else { return };
    let folder = folder();
    let cwd = folder.path();
    for (name, head) in [
        ("period.csv", "Period (s),PSA (g)"),
        ("plain.csv", "period_s,psa_g"),
        ("frequency.csv", "frequency (Hz),amplitude (g)"),
        ("fourier.csv", "# Fourier amplitude spectrum\nf,acc (g)"),
        ("design.csv", "# Design spectrum, 5 %\nx,acc (g)"),
    ] {
        write(cwd, name, &table(head, |i, a| format!("{},{:.5}", time(i + 1), a.abs())));
    }
    let volume3 = "Response and Fourier amplitude spectra (78 periods,  .04 -  6.0 sec)   for\n\
                   Corrected accelerogram   12345-L2500-12044.02       Chan  1: 360 Deg     from\n\
                   Uncorrected Accelerogram Data             Processed: 02/13/12\n";
    write(cwd, "quake.V3", volume3);
    let wanted: [Refusal; 6] = [
        ("period.csv", &["line 1", "the first column is \"Period (s)\"", "a spectrum, not a motion"]),
        ("plain.csv", &["the first column is \"period_s\"", "a spectrum, not a motion"]),
        ("frequency.csv", &["the first column is \"frequency (Hz)\"", "a spectrum, not a motion"]),
        ("fourier.csv", &["line 1", "Fourier amplitude spectrum", "a spectrum, not a motion"]),
        ("design.csv", &["line 1", "Design spectrum", "a spectrum, not a motion"]),
        ("quake.V3", &["line 1", "response spectra, not a motion", "Volume 2"]),
    ];
    for options in [&[][..], &["--unit", "g"]] {
        refuses(&hati_with(python, cwd, &call(options, &wanted)), &wanted);
    }
}

/// What might pass for a motion and is none: spectra under a header without the word period, and a sample whose
/// time, printed with two digits, comes twice.
#[test]
fn spectra_and_repeated_times() {
    let Some(python) = interpreter() else { return };
    let folder = folder();
    let cwd = folder.path();
    let heads =
        [("sa.csv", "T (s),Sa (g)"), ("psa.txt", "T[s] PSA[m/s2]"), ("f.csv", "frequency Hz,acc (g)")];
    for (name, head) in heads {
        let sign = if name == "psa.txt" { " " } else { "," };
        write(cwd, name, &table(head, |i, a| format!("{}{sign}{:.5}", time(i + 1), a.abs())));
    }
    let twice = table("time (s),acc (m/s2)", |i, a| format!("{},{a:.5}", time(i - usize::from(i > 200))));
    write(cwd, "twice.csv", &twice);
    let wanted: [Refusal; 4] = [
        ("sa.csv", &["a spectrum, not a motion"]),
        ("psa.txt", &["a spectrum, not a motion"]),
        ("f.csv", &["a spectrum, not a motion"]),
        ("twice.csv", &["line 203", "time stands still"]),
    ];
    refuses(&hati_with(python, cwd, &call(&["--unit", "g"], &wanted)), &wanted);
}
