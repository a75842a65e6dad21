//! Headers, units, steps and times of plain text columns as they are found, told apart or refused.
//!
//! Needs Python with ObsPy and the readers (`make setup`); without ObsPy the tests say that they were
//! skipped. The formats with a header of their own stand in `records_text.rs`.

mod python;

use std::path::{Path, PathBuf};

use hati_inputs::motion::Quantity;
use hati_inputs::records::{ReadOptions, Source, read_each};
use python::refusal;

/// Writes 400 rows at 100 Hz under a header. In the template `t` is the time in s, `m` in ms, `i` the number
/// of the row from 1, and `a`, `b`, `c` are values of the motion; the rest stands as it is.
fn written(name: &str, header: &str, template: &str) -> PathBuf {
    let row = |i: usize| -> String {
        let field = |letter: char| match letter {
            't' => format!("{:.3}", 0.01 * i as f64),
            'm' => format!("{}", 10 * i),
            'i' => format!("{}", i + 1),
            'a' => format!("{:.5}", expected(i + 400)),
            'b' => format!("{:.5}", -0.5 * expected(i + 420)),
            'c' => format!("{:.5}", 0.25 * expected(i + 440)),
            other => other.to_string(),
        };
        template.chars().map(field).collect()
    };
    let rows: Vec<String> = (0..400).map(row).collect();
    put(name, &format!("{header}{}{}\n", if header.is_empty() { "" } else { "\n" }, rows.join("\n")))
}

/// A file of that text in the build's own temporary folder.
fn put(name: &str, text: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("records_columns");
    std::fs::create_dir_all(&folder).unwrap();
    let path = folder.join(name);
    std::fs::write(&path, text).unwrap();
    path
}

/// The motion of the files, m/s².
fn expected(i: usize) -> f64 {
    let t = i as f64 * 0.01;
    1.5 * (4.0 * std::f64::consts::PI * t).sin() * (-((t - 6.0) / 2.0).powi(2)).exp()
}

fn acceleration() -> ReadOptions {
    ReadOptions { quantity: Some(Quantity::Acceleration), ..ReadOptions::default() }
}

/// Files of a header and rows, each with the words of its refusal; one call of Python for all.
#[track_caller]
fn assert_refused(test: &str, cases: &[(&str, &str, &str)]) {
    if !python::has_obspy() {
        return;
    }
    let path =
        |(at, case): (usize, &(&str, &str, &str))| written(&format!("{test}_{at}.txt"), case.0, case.1);
    let sources: Vec<Source> = cases.iter().enumerate().map(path).map(Source::new).collect();
    let answers = read_each(&sources, &ReadOptions::default()).unwrap();
    for ((header, template, words), answer) in cases.iter().zip(answers) {
        let error = refusal(&format!("{header:?} over {template:?}"), answer);
        assert!(error.contains(words), "{header:?} over {template:?}: no {words:?} in: {error}");
    }
}

/// What is read of a file: the file's words for the unit, the step, and the last parts of the ids.
type Reading<'a> = (&'a str, &'a str, &'a str, f64, &'a [&'a str]);

#[track_caller]
fn assert_read(test: &str, cases: &[Reading]) {
    if !python::has_obspy() {
        return;
    }
    let path = |(at, case): (usize, &Reading)| written(&format!("{test}_{at}.txt"), case.0, case.1);
    let sources: Vec<Source> = cases.iter().enumerate().map(path).map(Source::new).collect();
    let answers = read_each(&sources, &ReadOptions::default()).unwrap();
    for ((header, template, units, dt, ids), answer) in cases.iter().zip(answers) {
        let channels = answer.unwrap_or_else(|error| panic!("{header:?} over {template:?}: {error}"));
        let found: Vec<&str> = channels.iter().map(|c| c.id.rsplit('.').next().unwrap()).collect();
        assert_eq!(&found, ids, "{header:?} over {template:?}");
        let found: Vec<&str> = channels.iter().map(|c| c.unit_stored.as_str()).collect();
        assert_eq!(found.join(" "), *units, "{header:?} over {template:?}");
        assert!(channels.iter().all(|c| c.dt == *dt), "{header:?} over {template:?}: {}", channels[0].dt);
        assert!(channels.iter().all(|c| c.samples.len() == 400), "{header:?} over {template:?}");
    }
}

#[test]
fn a_spectrum_is_told_by_the_names_of_its_columns() {
    let words = "a spectrum, not a motion";
    assert_refused(
        "spectra",
        &[
            ("T (s),Sa (g)", "t,a", words),
            ("T(s);Sa(g)", "t;a", words),
            ("T[s] PSA[m/s2]", "t a", words),
            ("Tn (s),SA (g)", "t,a", words),
            ("x,Sa (g)", "t,a", words),
            ("time (s),Sa (g)", "t,a", words),
            ("t (s),SD (cm)", "t,a", words),
            ("frequency Hz,amplitude", "t,a", words),
            ("frequency Hz amplitude", "t a", words),
            ("f,psa", "t,a", words),
            ("freq,acc (g)", "t,a", words),
            ("x (Hz);acc (g)", "t;a", words),
            ("Spectral acceleration (g)", "a", words),
            ("PSA (g), 5 % damping\ndt = 0.01", "a", words),
            ("# Fourier amplitude spectrum\nunit: g\ntime acc", "t a", words),
        ],
    );
    // A motion that was made to fit a spectrum is one.
    assert_read("fitted", &[("Matched to a design spectrum\ntime (s),acc (g)", "t,a", "g", 0.01, &["ACC"])]);
}

#[test]
fn a_unit_counts_only_where_the_header_speaks_of_the_motion() {
    let none = "the file states no unit";
    assert_refused(
        "units",
        &[
            (
                "STATION ALTITUDE (m)  : 76\nRAW PGA VALUES (gal)  : (N-S) 150 (E-W) 110\n  N-S  E-W  U-D",
                "t a b c",
                none,
            ),
            ("Sensor depth (m): 10\nTime NS EW UD", "t a b c", none),
            ("Station ABC, PGA = 0.0021 (g)\nTime NS", "t a", none),
            ("Acc (gal), scale factor 0.01\nTime NS", "t a", none),
            ("Station 12, distance (m) 1200\nNPTS= 400, DT= .0100 SEC", "a", none),
            ("unit: counts\nPGA (gal) 12\nTime NS", "t a", "the file says \"counts\""),
            ("Station (G), unit of record unknown\nTime NS", "t a", "the file says \"unknown\""),
            ("Units: g x 1e-2\nTime NS", "t a", "the file says \"g x 1e-2\""),
            ("UNITS OF G * 100\nNPTS= 400, DT= .0100 SEC", "a", "the file says \"G * 100\""),
            ("Acceleration (milli g)\nTime NS", "t a", "the file says \"milli g\""),
            (
                "Acceleration (g), acceleration (gal)\nTime NS",
                "t a",
                "states \"g\" (line 1) and \"gal\" (line 1)",
            ),
            (
                "Units: time s, velocity cm/s, acceleration cm/s2\ntime acc",
                "t a",
                "states \"cm/s\" (line 1) and \"cm/s2\"",
            ),
            ("unit: gal\nunit: g\ntime acc", "t a", "states \"gal\" (line 1) and \"g\" (line 2)"),
            ("Time (s),acc NS (gal),EW", "t,a,b", none),
        ],
    );
    assert_read(
        "stated",
        &[
            ("Station ABC, PGA = 0.0021 (g)\nTime series in gal\nTime NS", "t a", "gal", 0.01, &["NS"]),
            ("ACCELERATION TIME SERIES IN CM/S/S\nNPTS= 400, DT= .0100 SEC", "a", "CM/S/S", 0.01, &["ACC"]),
            ("Acceleration (g), dt=0.01 s", "a", "g", 0.01, &["CH"]),
            ("unit: acceleration in cm/s/s, time in s\ntime acc", "t a", "cm/s/s", 0.01, &["ACC"]),
            ("units: s, g\ntime acc", "t a", "g", 0.01, &["ACC"]),
            ("The units are (g)\nNPTS= 400, DT= .0100 SEC", "a", "g", 0.01, &["CH"]),
            (
                "IN UNITS OF G. FILTER POINTS: HP=.2 HZ LP= 35.0 HZ\n 400 .0100 NPTS, DT",
                "a",
                "G",
                0.01,
                &["CH"],
            ),
            (
                "X, 1/1/99, VELOCITY RANCH, 090\nUNITS OF G\nNPTS= 400, DT= .0100 SEC",
                "a",
                "G",
                0.01,
                &["090"],
            ),
            (
                "#SampleRate(Hz): 100\n#AmplitudeUnit: gal. DCoffset(corr)\n#AmplitudeMAX. U: 70.0~ -70.0\n\
             #DataSequence: Time U(+); N(+); E(+)\n#Data: 4F10.3",
                "  t  c  b  a",
                "gal gal gal",
                0.01,
                &["U", "N", "E"],
            ),
        ],
    );
}

#[test]
fn a_row_of_units_is_read_column_by_column() {
    assert_read(
        "rows",
        &[
            ("time NS EW UD\n(s) (gal) (g) (m/s2)", "t a b c", "gal g m/s2", 0.01, &["NS", "EW", "UD"]),
            ("time,acc,vel\ns,m/s2,cm/s", "t,a,b", "m/s2 cm/s", 0.01, &["ACC", "VEL"]),
            ("time A V D\n(ms) (cm/s2) (cm/s) (cm)", "m a b c", "cm/s2 cm/s cm", 0.01, &["A", "V", "D"]),
        ],
    );
}

#[test]
fn a_step_needs_a_known_unit() {
    let comma = "the comma may be the decimal sign";
    let given = "no time step: the file holds values without times";
    assert_refused(
        "steps",
        &[
            ("Unit: gal\nSampling interval: 5,0 ms", "a", comma),
            ("Unit: gal\nsample spacing 0,01 s", "a", comma),
            ("Unit: gal\nSampling rate: 1,000 Hz", "a", comma),
            ("UNITS OF G\nNPTS= 400, DT= 1,5 s", "a", comma),
            ("UNITS OF G\n 400 0,0100 NPTS, DT", "a", "a comma within the numbers"),
            ("Unit: gal; dt=0.01 min", "a", "line 1: \"dt = 0.01 min\": \"min\" is no unit of a step"),
            ("Unit: gal; dt=5000 us", "a", "\"us\" is no unit of a step"),
            ("Unit: gal; dt = -0.01", "a", "time step -0.01 s"),
            (
                "Unit: gal\nSAMPLING RATE = .02 SEC",
                "a",
                "line 2: \"SAMPLING RATE = .02 SEC\": a rate in \"SEC\"",
            ),
            ("Unit: gal; FS = 25 Hz lowpass; dt=0.01", "a", "a step of 0.01 s here and of 0.04 s in line 1"),
            ("Unit: gal\nSensor spacing: 2 m", "a", given),
            ("Unit: gal\nFreq 100 Hz, corner 0.1-25 Hz", "a", given),
            (
                "Unit: gal; dt = 5",
                "a",
                "no sure time step: line 1 states a step of 5 s, outside 0.0001 to 0.5 s: it may be in another unit",
            ),
            ("Unit: gal; dt = 0.00001", "a", "line 1 states a step of 1e-05 s, outside"),
            ("UNITS OF G\nNPTS= 400, DT= 5.0", "a", "line 2 states DT = 5 s, outside"),
            // Probably ms, but nothing says so.
            ("t a (m/s2)", "m a", "the times, without a unit, have a step of 10 s, outside"),
        ],
    );
    assert_read(
        "steps_read",
        &[
            ("Unit: gal\ndt = 5 milliseconds", "a", "gal", 0.005, &["CH"]),
            ("Unit: gal\ndt (msec): 5", "a", "gal", 0.005, &["CH"]),
            ("Unit: gal\nSampling rate: 0.1 kHz", "a", "gal", 0.01, &["CH"]),
            ("Unit: gal\nSampling rate 200 samples per second", "a", "gal", 0.005, &["CH"]),
            ("Unit: gal; dt=0.01 s, delay 20 (ms)", "a", "gal", 0.01, &["CH"]),
            ("Unit: gal\n400 points at equal spacing of 0.02 sec", "a", "gal", 0.02, &["CH"]),
            ("UNITS OF G\nNPTS= 400, DT= 10 milliseconds", "a", "G", 0.01, &["CH"]),
            ("Time/ms;Acc/(m/s2)", "m;a", "m/s2", 0.01, &["ACC"]),
            ("Zeit/ms;Beschleunigung/(m/s2)", "m;a", "m/s2", 0.01, &["BESCHLEU"]),
            ("time,ms;acc (gal)", "m;a", "gal", 0.01, &["ACC"]),
            ("ms acc (gal)", "m a", "gal", 0.01, &["ACC"]),
        ],
    );
}

/// What a step of 5 s in the header may mean is for the user to say: it can be given.
#[test]
fn a_doubtful_step_is_taken_when_given() {
    if !python::has_obspy() {
        return;
    }
    let path = written("doubtful.txt", "Unit: gal; dt = 5", "a");
    let source = Source { dt: Some(0.005), ..Source::new(path) };
    let channels = read_each(&[source], &acceleration()).unwrap().remove(0).unwrap();
    assert_eq!(channels[0].dt, 0.005);
}

/// 200 Hz with two decimals: times that stand twice do not show their step, which can be given if it fits them.
#[test]
fn times_too_coarse_for_their_step() {
    if !python::has_obspy() {
        return;
    }
    let rows: String =
        (0..800).map(|i| format!("{:.2},{:.5}\n", 0.005 * i as f64, expected(i + 300))).collect();
    let path = put("coarse.csv", &format!("time (s),acc (m/s2)\n{rows}"));
    let agreeing = put("coarse_stated.csv", &format!("dt = 0.005 s\ntime (s),acc (m/s2)\n{rows}"));
    let given = |dt| Source { dt, ..Source::new(&path) };
    let sources = [given(None), given(Some(0.005)), given(Some(0.01)), Source::new(agreeing)];
    let answers: [_; 4] = read_each(&sources, &acceleration()).unwrap().try_into().unwrap();
    let [unknown, sound, wrong, agreeing] = answers;
    let error = refusal("unknown", unknown);
    for words in
        ["line 4: time 0.01 stands a second time", "rounded", "step of 0.005 s", "--dt 0.005 (dt = 0.005 in"]
    {
        assert!(error.contains(words), "no {words} in {error}");
    }
    let error = refusal("wrong", wrong);
    assert!(error.contains("not the 0.01 s that were given") && error.contains("--dt 0.005"), "{error}");
    for channels in [sound.unwrap(), agreeing.unwrap()] {
        assert_eq!((channels[0].dt, channels[0].samples.len()), (0.005, 800));
    }
}

#[test]
fn times_are_no_motion_and_prose_is_no_name() {
    assert_refused(
        "times",
        &[
            ("Acc_g Time", "a t", "column 2 (\"Time\") changes by equal steps of 0.01 all along"),
            ("", "i t a", "column 2 changes by equal steps of 0.01 all along"),
            ("Acc (m/s2)*100", "t a", "changes by equal steps"),
            ("unit: g; dt = 0.01", "t", "the only column changes by equal steps"),
            ("Unit: gal\nt1 NS t2 EW", "t a t b", "the first column is \"t1\" and rises evenly"),
            ("Unit: gal\ntime NS t2 EW", "t a t b", "column 3 (\"t2\") changes by equal steps"),
            (
                "Time followed by 5 values per row, acceleration (m/s2)",
                "t a b c a b",
                "or one series in rows that begin with their time",
            ),
        ],
    );
    assert_read(
        "prose",
        &[
            ("Acceleration history (g)", "t a", "g", 0.01, &["CH"]),
            ("Ground acceleration time history (m/s2)", "t a", "m/s2", 0.01, &["CH"]),
            ("Acceleration time history (gal)", "t a b", "gal gal", 0.01, &["CH", "CH_2"]),
            ("Unit: gal\nAcceleration record NS", "t a b", "gal gal", 0.01, &["CH", "CH_2"]),
            ("No Time(s) Acc(m/s2)", "i t a", "m/s2", 0.01, &["ACC"]),
            ("Unit: gal; dt = 0.01\nNS", "a", "gal", 0.01, &["NS"]),
            ("dt = 0.01\nUnit: gal", "a", "gal", 0.01, &["CH"]),
        ],
    );
}

#[test]
fn what_stands_between_rows_may_begin_another_channel() {
    if !python::has_obspy() {
        return;
    }
    let head = "Unit: gal; dt = 0.01\n";
    let rows = |sign: f64| (0..200).map(|i| format!("{:.4}\n", sign * expected(i + 500))).collect::<String>();
    let spaced = head.to_owned() + &rows(1.0).replace('\n', "\n\n");
    let cases = [
        (
            "comment",
            format!("{head}{}# EW, unit: g\n{}", rows(1.0), rows(-1.0)),
            Some("line 202: \"# EW, unit: g\" between rows"),
        ),
        (
            "blank",
            format!("{head}{}\n\n{}", rows(1.0), rows(-1.0)),
            Some("line 202: a blank line between rows"),
        ),
        ("rule", format!("{head}{}# -----\n{}", rows(1.0), rows(-1.0)), None),
        ("spaced", spaced, None),
        ("end", format!("{head}{}\n# end of data\n", rows(1.0)), None),
    ];
    let sources: Vec<Source> =
        cases.iter().map(|(name, text, _)| Source::new(put(&format!("between_{name}.txt"), text))).collect();
    for ((name, _, words), answer) in cases.iter().zip(read_each(&sources, &acceleration()).unwrap()) {
        match (words, answer) {
            (Some(words), answer) => {
                let error = refusal(name, answer);
                assert!(error.contains(words), "{name}: {error}");
            }
            (None, Ok(channels)) => assert_eq!(channels[0].samples.len() % 200, 0, "{name}"),
            (None, Err(error)) => panic!("{name}: {error}"),
        }
    }
}

/// One wrong time must not be spread over all the others.
#[test]
fn a_wrong_time_is_not_absorbed_into_the_step() {
    if !python::has_obspy() {
        return;
    }
    type Case<'a> = (&'a str, usize, &'a dyn Fn(usize) -> String, Result<f64, &'a str>);
    let cases: [Case; 8] = [
        (
            "twice",
            500,
            &|i| format!("{:.2}", 0.01 * (i - usize::from(i > 200)) as f64),
            Err("line 203: time stands still"),
        ),
        (
            "lost",
            100,
            &|i| format!("{:.2}", 0.01 * (i + usize::from(i > 50)) as f64),
            Err("line 53: gap in time"),
        ),
        (
            "seventh",
            500,
            &|i| format!("{:.3}", 0.01 * i as f64 + 0.001 * f64::from(i % 7 == 6)),
            Err("line 8: the time step changes"),
        ),
        ("last", 500, &|i| format!("{:.3}", 0.01 * i as f64 + 0.001 * f64::from(i == 499)), Ok(0.01)),
        (
            "coarse",
            500,
            &|i| format!("{:.2}", (i / 2) as f64 * 0.01),
            Err("line 3: time 0.00 stands a second time"),
        ),
        (
            "coarse_lost",
            500,
            &|i| format!("{:.2}", 0.005 * (i + 9 * usize::from(i > 200)) as f64),
            Err("time stands still"),
        ),
        (
            "falling",
            500,
            &|i| format!("{:.3}", 0.01 * if i < 250 { i } else { 749 - i } as f64),
            Err("line 253: time runs backwards"),
        ),
        ("odd", 500, &|i| format!("{:.2}", i as f64 / 30.0), Ok(1.0 / 30.0)),
    ];
    let text = |count: usize, time: &dyn Fn(usize) -> String| {
        (0..count).fold("time (s),acc (m/s2)\n".to_owned(), |text, i| {
            text + &format!("{},{:.5}\n", time(i), expected(i + 300))
        })
    };
    let sources: Vec<Source> = cases
        .iter()
        .map(|(name, count, time, _)| Source::new(put(&format!("times_{name}.csv"), &text(*count, *time))))
        .collect();
    for ((name, _, _, wanted), answer) in cases.into_iter().zip(read_each(&sources, &acceleration()).unwrap())
    {
        match wanted {
            Ok(dt) => {
                assert_eq!(answer.unwrap_or_else(|error| panic!("{name}: {error}"))[0].dt, dt, "{name}")
            }
            Err(words) => {
                let error = refusal(name, answer);
                assert!(error.contains(words), "{name}: {error}");
            }
        }
    }
}
