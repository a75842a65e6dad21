//! Text records: every format and dialect of `inputs/python/hati_obspy`, what is read and what is refused.
//!
//! Needs Python with ObsPy and the readers (`make setup`); without ObsPy the tests say that they were
//! skipped. The rows of the collection need that as well (see `records_collection.rs`).

mod python;

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

use hati_inputs::InputError;
use hati_inputs::motion::Quantity;
use hati_inputs::records::{Channel, ReadOptions, Source, Unit, read, read_each};
use python::refusal;

/// The fixtures of `make_fixtures_text.py`, with readers that are those of the source tree.
fn fixtures() -> Option<&'static Path> {
    static FOLDER: OnceLock<Option<PathBuf>> = OnceLock::new();
    let folder = FOLDER.get_or_init(|| {
        let folder = python::made_by("make_fixtures_text.py")?;
        let sources = Path::new(env!("CARGO_MANIFEST_DIR")).join("python").display().to_string();
        let same = readers(&format!("import sys; sys.path.insert(0, {sources:?})")) == readers("");
        assert!(same, "the installed readers are not those of inputs/python: run `make setup`");
        Some(folder)
    });
    folder.as_deref()
}

/// The text of the readers that Python imports after `setup`.
fn readers(setup: &str) -> String {
    let code = "import hati_obspy, pathlib; folder = pathlib.Path(hati_obspy.__file__).parent\n\
                for file in sorted(folder.glob('*.py')): print(file.name, file.read_text('utf-8'))";
    let output =
        Command::new(python::interpreter()).args(["-I", "-c", &format!("{setup}\n{code}")]).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

/// The motion that the sound fixtures hold, m/s².
fn expected(i: usize) -> f64 {
    let t = i as f64 * 0.01;
    1.5 * (4.0 * std::f64::consts::PI * t).sin() * (-((t - 6.0) / 2.0).powi(2)).exp()
}

#[track_caller]
fn assert_motion(channel: &Channel, factor: f64, offset: f64, tolerance: f64) {
    assert_eq!(channel.samples.len(), 2000, "{}", channel.id);
    for (i, found) in channel.samples.iter().enumerate() {
        let wanted = factor * expected(i) + offset;
        assert!((found - wanted).abs() <= tolerance, "{} sample {i}: {found} against {wanted}", channel.id);
    }
}

fn acceleration() -> ReadOptions {
    ReadOptions { quantity: Some(Quantity::Acceleration), ..ReadOptions::default() }
}

#[test]
fn each_dialect_gives_the_same_motion() {
    let Some(folder) = fixtures() else { return };
    // File, format, the file's words for the unit, half a unit of its last digit in m/s².
    let cases = [
        ("peer_new.AT2", "PEER", "G", 1e-7),
        ("peer_mid.AT2", "PEER", "G", 1e-7),
        ("peer_next_line.AT2", "PEER", "G", 1e-7),
        ("peer_dos.AT2", "PEER", "G", 1e-7),
        ("peer_moved.AT2", "PEER", "cm/sec/sec", 6e-8),
        ("esm_acceleration.ASC", "ESM", "cm/s^2", 6e-9),
        ("esm_latin.ASC", "ESM", "cm/s^2", 6e-9),
        ("cosmos.v2c", "COSMOS", "cm/sec2", 6e-8),
        ("csmip.v2", "CSMIP", "cm/sec/sec", 6e-6),
        ("csmip_new.v2", "CSMIP", "cm/sec/sec", 6e-8),
        ("csmip_pairs.v1", "CSMIP", "G/10", 5e-4),
        ("csmip_values.v1", "CSMIP", "G/10", 5e-4),
        ("renadic.v1", "RENADIC", "G/10", 5e-4),
        ("usc.s0a", "USC", "cm/sec/sec", 6e-6),
        ("smc.smc", "SMC", "cm/s2 by definition of the format", 1e-4),
        ("columns_si.csv", "text columns", "m_s2", 6e-7),
        ("columns_comma.csv", "text columns", "m/s²", 6e-7),
        ("columns_tabs.txt", "text columns", "g", 6e-7),
    ];
    let sources: Vec<Source> = cases.iter().map(|(name, ..)| Source::new(folder.join(name))).collect();
    let files = read_each(&sources, &acceleration()).unwrap();
    for ((name, format, unit, tolerance), channels) in cases.into_iter().zip(files) {
        let channels = channels.unwrap_or_else(|error| panic!("{name}: {error}"));
        let channel = &channels[0];
        assert_motion(channel, 1.0, 0.0, tolerance);
        assert_eq!((channel.format, channel.unit_stored.as_str()), (format, unit), "{name}");
        assert_eq!((channel.dt, channel.quantity), (0.01, Quantity::Acceleration), "{name}");
    }
}

#[test]
fn channels_of_one_file_keep_their_order_direction_and_time() {
    let Some(folder) = fixtures() else { return };
    // File, half a unit of the last digit, and per channel: id, axis, factor, offset in m/s².
    let blue = [(".00001.01.090", Some(0), 1.0, 0.0), (".00001.02.UP", Some(2), -0.5, 0.0)];
    let blue = [blue[0], blue[1], (".00001.03.352", None, 0.25, 0.0)];
    let chile = [
        (".7.01.090", Some(0), 1.0, 0.0),
        (".7.02.360", Some(1), -0.5, 0.0),
        (".7.03.V", Some(2), 0.25, 0.0),
    ];
    // The third channel of the COSMOS file has columns that touch each other.
    let cosmos = [
        ("XX.HATI.01.090", Some(0), 1.0, 0.0),
        ("XX.HATI.02.360", Some(1), -0.5, 0.0),
        ("XX.HATI.03.UP", Some(2), 0.25, 10.0),
    ];
    let columns =
        [("...NS", Some(1), -0.5, 0.0), ("...EW", Some(0), 1.0, 0.0), ("...UD", Some(2), 0.25, 0.0)];
    let cases = [
        ("csmip.v2", 6e-6, blue, true),
        ("renadic.v1", 5e-4, chile, true),
        ("cosmos.v2c", 6e-8, cosmos, true),
        ("columns_three.txt", 6e-7, columns, false),
        ("columns_header.txt", 6e-8, columns, false),
    ];
    for (name, tolerance, wanted, dated) in cases {
        let channels = read(&folder.join(name), &acceleration()).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(channels.len(), 3, "{name}");
        for (channel, (id, axis, factor, offset)) in channels.iter().zip(wanted) {
            assert_eq!((channel.id.as_str(), channel.axis_hint), (id, axis), "{name}");
            assert_motion(channel, factor, offset, tolerance);
            // 2020-02-03 04:05:06 UTC.
            assert_eq!(channel.start, dated.then_some(1_580_702_706.0), "{name}");
        }
    }
}

#[test]
fn columns_that_touch_are_taken_apart() {
    let Some(folder) = fixtures() else { return };
    let channels = read(&folder.join("peer_touching.AT2"), &acceleration()).unwrap();
    assert_motion(&channels[0], 1.0, -10.0, 6e-7);
}

#[test]
fn a_step_that_is_no_round_number_is_found_from_rounded_times() {
    let Some(folder) = fixtures() else { return };
    let channels = read(&folder.join("columns_128.txt"), &acceleration()).unwrap();
    assert_eq!(channels[0].dt, 1.0 / 128.0);
}

#[test]
fn velocities_are_velocities() {
    let Some(folder) = fixtures() else { return };
    for name in [
        "peer_velocity.VT2",
        "esm_velocity.ASC",
        "cosmos_speed.v2c",
        "smc_velocity.smc",
        "columns_velocity.csv",
    ] {
        let path = folder.join(name);
        let channels = read(&path, &ReadOptions::default()).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(channels[0].quantity, Quantity::Velocity, "{name}");
        let error = read(&path, &acceleration()).unwrap_err();
        assert!(matches!(error, InputError::QuantityMismatch { .. }), "{name}: {error}");
    }
}

/// A vertical channel whose file counts it downwards is turned: z is up here.
#[test]
fn a_channel_that_points_down_is_turned_up() {
    let Some(folder) = fixtures() else { return };
    let text = std::fs::read_to_string(folder.join("csmip.v2")).unwrap();
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("down-{}.v2", std::process::id()));
    std::fs::write(&path, text.replace("Chan  2: Up", "Chan  2: Dn")).unwrap();
    let up = read(&folder.join("csmip.v2"), &acceleration()).unwrap().remove(1);
    let down = read(&path, &acceleration()).unwrap().remove(1);
    std::fs::remove_file(&path).unwrap();
    assert_eq!((up.axis_hint, down.axis_hint), (Some(2), Some(2)));
    assert!(down.unit_stored.ends_with("positive down") && !up.unit_stored.contains("down"));
    assert_eq!(down.steps[0].found["sense"], "down");
    for (up, down) in up.samples.iter().zip(&down.samples) {
        assert_eq!(*up, -down);
    }
}

#[test]
fn what_a_file_does_not_say_must_be_given() {
    let Some(folder) = fixtures() else { return };
    let path = folder.join("columns_wrapped.txt");
    let error = read(&path, &acceleration()).unwrap_err();
    assert!(matches!(error, InputError::StepMissing { .. }), "{error}");
    let with_step = Source { dt: Some(0.01), ..Source::new(&path) };
    let answers = read_each(std::slice::from_ref(&with_step), &acceleration()).unwrap();
    let error = answers.into_iter().next().unwrap().unwrap_err();
    assert!(error.to_string().contains("the file states no unit"), "{error}");
    let both = Source { unit: Some(Unit::MetrePerSecond2), ..with_step };
    let channels = read_each(&[both], &acceleration()).unwrap().remove(0).unwrap();
    assert_motion(&channels[0], 1.0, 0.0, 6e-7);
    assert_eq!(channels[0].dt, 0.01);
    // A file that states its step needs only the unit.
    let unit = ReadOptions { unit: Some(Unit::MetrePerSecond2), ..acceleration() };
    assert_motion(&read(&folder.join("columns_counts.txt"), &unit).unwrap()[0], 1.0, 0.0, 6e-7);
}

#[test]
fn a_refusal_names_the_line_what_was_found_and_what_to_do() {
    let Some(folder) = fixtures() else { return };
    let cases = [
        ("bad_peer_count.AT2", "line 4: NPTS = 2001, but 2000 numbers follow (lines 5 to 404)"),
        ("bad_peer_zero_step.AT2", "line 4: time step 0 s"),
        (
            "bad_peer_no_numbers.AT2",
            "line 4: \"NPTS=   many, DT=   some SEC,\" does not give a count and a step",
        ),
        ("bad_peer_no_unit.AT2", "no unit: the file states no unit"),
        ("bad_peer_inches.AT2", "no unit: the file says \"IN/S2\""),
        ("bad_peer_contradiction.AT2", "calls its samples accelerations and gives CM/S, a unit of velocity"),
        (
            "bad_peer_stars.AT2",
            "line 7: \"2.4172924E-05***************\" is a number too wide for its column",
        ),
        ("bad_peer_nan.AT2", "line 7: \"NaN\" is not a finite number"),
        ("bad_peer_word.AT2", "line 7: \"lost\" is not a number"),
        ("bad_esm_peak.ASC", "line 10: the header says the peak (PGA_CM/S^2) is 298.332 cm/s2"),
        ("bad_esm_cut.ASC", "line 7: NDATA = 2000, but 1485 numbers follow"),
        ("bad_esm_spectrum.ASC", "line 13: DATA_TYPE: \"ACCELERATION RESPONSE SPECTRUM\" is not a motion"),
        ("bad_cosmos_peak.v2c", "line 26: the header says the largest value (real header 64) is 1 cm/s2"),
        ("bad_cosmos_code.v2c", "line 45: units=\"g\", but the code 4 means cm/s2"),
        ("bad_cosmos_cut.v2c", "line 45: number of points = 2000, but 859 numbers follow"),
        ("bad_cosmos_spectra.v3", "line 1: \"Response spectra\": response spectra, not a motion"),
        ("bad_cosmos_counts.v0", "no unit: the file says \"counts\""),
        ("bad_csmip_peak.v2", "line 13: the header says the peak acceleration is 20 cm/s2"),
        ("bad_csmip_cut.v2", "line 36: number of points = 2000, but 512 numbers follow"),
        ("bad_csmip_uneven.v1", "line 223: gap in time: 10.3 s after 9.99 s, 30 sample(s) missing"),
        ("bad_csmip_spectra.v3", "response spectra, not a motion"),
        ("bad_smc_spectra.smc", "line 1: \"5 RESPONSE SPECTRA\" is not a motion"),
        ("bad_smc_rate.smc", "line 18: no sampling rate in the header"),
        ("bad_smc_count.smc", "line 14: number of samples = 2008, but 2000 numbers follow"),
        ("bad_smc_peak.smc", "line 23: the header says the peak is 500 cm/s2"),
        ("bad_columns_nan.csv", "line 102: \"NaN\" is not a finite number"),
        ("bad_columns_stars.csv", "line 202: \"**********\" is a number too wide for its column"),
        ("bad_columns_overflow.csv", "line 302: \"1e400\" is too large for a number"),
        ("bad_columns_word.csv", "line 52: \"lost\" is not a number"),
        ("bad_columns_empty.csv", "line 52: \"0.50,\" has an empty field"),
        ("bad_columns_ragged.csv", "line 52: 3 numbers in this row, 2 in the first"),
        ("bad_columns_backwards.csv", "line 52: time runs backwards: 0.4 s after 0.49 s"),
        ("bad_columns_still.csv", "line 52: time stands still: 0.49 s after 0.49 s"),
        ("bad_columns_gap.csv", "line 252: gap in time: 3 s after 2.49 s, 50 sample(s) missing"),
        ("bad_columns_change.csv", "line 1003: the time step changes: 0.02 s here"),
        ("bad_columns_mixed.csv", "line 52: \"0,50;0,1\" mixes decimal points and commas"),
        ("bad_columns_ambiguous.txt", "line 1: in \"1000,2000\" the comma may be the decimal sign"),
        ("bad_columns_nameless.txt", "line 1: rows of 3 numbers without column names"),
        ("bad_columns_spectrum.csv", "line 1: the first column is \"Period (s)\": a spectrum"),
        ("bad_columns_step.csv", "line 1: the header says a step of 0.02 s, the column of times has 0.01 s"),
        ("bad_columns_minutes.csv", "line 1: the column of times is in \"min\""),
        (
            "bad_columns_cut.txt",
            "line 1: \"2000 0.01\" looks like a count and a step, but 1000 numbers follow",
        ),
    ];
    let sources: Vec<Source> = cases.iter().map(|(name, _)| Source::new(folder.join(name))).collect();
    let answers = read_each(&sources, &acceleration()).unwrap();
    for ((name, words), answer) in cases.into_iter().zip(answers) {
        let error = refusal(name, answer);
        assert!(error.contains(words), "{name}: no \"{words}\" in: {error}");
        assert!(error.contains(name) && error.contains("\n  help: "), "{name}: {error}");
    }
    let bad = std::fs::read_dir(folder).unwrap().flatten();
    let bad = bad.filter(|entry| entry.file_name().to_string_lossy().starts_with("bad_")).count();
    assert_eq!(bad, cases.len(), "each broken fixture has its row");
}

#[test]
fn obspy_reads_them_by_itself() {
    let Some(folder) = fixtures() else { return };
    let code = "import obspy, sys, glob, os\n\
        for name in sys.argv[2:]:\n\
        \x20   path = os.path.join(sys.argv[1], name)\n\
        \x20   a = obspy.read(path)\n\
        \x20   b = obspy.read(open(path, 'rb'), format=a[0].stats._format)\n\
        \x20   assert (a[0].data == b[0].data).all() and a[0].stats.hati.quantity == 'acceleration', name\n\
        \x20   print(a[0].stats._format)";
    let files = [
        ("peer_new.AT2", "PEER_AT2"),
        ("esm_acceleration.ASC", "ESM_DYNA"),
        ("cosmos.v2c", "COSMOS"),
        ("csmip.v2", "CSMIP"),
        ("renadic.v1", "RENADIC"),
        ("usc.s0a", "USC"),
        ("smc.smc", "SMC"),
        ("columns_comma.csv", "COLUMNS"),
    ];
    let output = Command::new(python::interpreter())
        .args(["-c", code])
        .arg(folder)
        .args(files.map(|(name, _)| name))
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let found = String::from_utf8(output.stdout).unwrap();
    assert_eq!(found.lines().collect::<Vec<_>>(), files.map(|(_, format)| format));
}

/// Stations of a network that numbers them all 0 go by the number of the recording.
#[test]
fn a_station_without_a_number_goes_by_its_recording() {
    let Some(folder) = fixtures() else { return };
    let text = std::fs::read_to_string(folder.join("renadic.v1")).unwrap();
    assert!(text.contains("STATION NO. 7"));
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("zero-{}.v1", std::process::id()));
    std::fs::write(&path, text.replace("STATION NO. 7", "STATION NO.          0.000N    0.000E")).unwrap();
    let channels = read(&path, &acceleration()).unwrap();
    std::fs::remove_file(&path).unwrap();
    let second = text.lines().nth(1).unwrap().trim();
    assert_eq!(channels[0].id, format!(".{second}.01.090"));
}
