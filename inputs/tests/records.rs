//! Records through the ObsPy process: what is read, what is refused and how the refusal reads.
//!
//! Needs Python with ObsPy (`make setup`); without it the tests say that they were skipped.

mod python;

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use hati_inputs::InputError;
use hati_inputs::motion::{Motion, Process, Quantity};
use hati_inputs::records::{Channel, Limits, ReadOptions, Source, Unit, read, read_many};
use python::fixtures;

const DT: f64 = 0.01;

/// The motion that the sound fixtures hold, m/s².
fn expected() -> Vec<f64> {
    let wave = |i: usize| {
        let t = i as f64 * DT;
        1.5 * (4.0 * std::f64::consts::PI * t).sin() * (-((t - 6.0) / 2.0).powi(2)).exp()
    };
    (0..2000).map(wave).collect()
}

fn with_unit(unit: Unit) -> ReadOptions {
    ReadOptions { unit: Some(unit), ..ReadOptions::default() }
}

fn accelerogram() -> ReadOptions {
    ReadOptions { quantity: Some(Quantity::Acceleration), ..ReadOptions::default() }
}

#[track_caller]
fn assert_samples(channel: &Channel, factor: f64, offset: f64, tolerance: f64) {
    let expected = expected();
    assert_eq!(channel.samples.len(), expected.len());
    for (i, (found, wanted)) in channel.samples.iter().zip(&expected).enumerate() {
        let wanted = wanted * factor + offset;
        assert!((found - wanted).abs() <= tolerance, "sample {i}: {found} against {wanted}");
    }
}

#[track_caller]
fn refusal(path: &Path, options: &ReadOptions) -> InputError {
    match read(path, options) {
        Err(error) => error,
        Ok(channels) => panic!("{} was read: {} channels", path.display(), channels.len()),
    }
}

#[test]
fn knet_counts_become_metres_per_second_squared() {
    let Some(folder) = fixtures() else { return };
    let path = folder.join("east.knet");
    let channels = read(&path, &accelerogram()).unwrap();
    let [channel] = channels.as_slice() else { panic!("one channel") };
    let count = 2000.0 / 8_388_608.0 / 100.0;
    assert_samples(channel, 1.0, 5000.0 * count, 0.51 * count);
    assert_eq!(channel.id, "BO.HATI01..EW");
    assert_eq!(channel.axis_hint, Some(0));
    assert_eq!(channel.quantity, Quantity::Acceleration);
    // 13:05:21 in Japan less the logger's 15 s is 2020-02-03 04:05:06 UTC.
    assert_eq!(channel.start, Some(1_580_702_706.0));
    assert_eq!(channel.dt, DT);
    assert_eq!(channel.sha256.len(), 64);
    let unit = &channel.steps[1].parameters;
    assert_eq!(unit["given_by"], "file");
    assert!((unit["factor_to_si"].as_f64().unwrap() - count).abs() < 1e-18);
    // The user's unit sets the calibration aside.
    let given = read(&path, &with_unit(Unit::MillimetrePerSecond2)).unwrap();
    let ratio = given[0].samples[600] / channel.samples[600];
    assert!((ratio - 1e-3 / count).abs() < 1e-6 * ratio);
    assert!(
        (given[0].steps[1].parameters["calibration_not_applied"].as_f64().unwrap() - count).abs() < 1e-18
    );
}

#[test]
fn miniseed_needs_a_unit_and_then_gives_every_channel() {
    let Some(folder) = fixtures() else { return };
    let path = folder.join("counts.mseed");
    let error = refusal(&path, &accelerogram());
    assert!(matches!(error, InputError::UnitMissing { .. }), "{error}");
    let text = error.to_string();
    assert!(
        text.contains("XX.HATI.00.HNE")
            && text.contains("counts")
            && text.contains("--metadata")
            && text.contains("--unit"),
        "{text}"
    );
    // 1e5 counts per m/s² in the file: 1 mm/s² per count makes it a hundred times as large.
    let channels = read(&path, &with_unit(Unit::MillimetrePerSecond2)).unwrap();
    assert_eq!(channels.len(), 3);
    for (channel, (factor, axis)) in channels.iter().zip([(100.0, 0), (-50.0, 1), (25.0, 2)]) {
        assert_samples(channel, factor, 0.0, 0.51e-3);
        assert_eq!(channel.axis_hint, Some(axis));
        assert_eq!(channel.start, Some(1_580_702_706.0));
    }
    // One channel, by its last part and by its full id.
    for name in ["HNN", "XX.HATI.00.HNN"] {
        let source = Source { unit: Some(Unit::Gal), channel: Some(name.into()), ..Source::new(&path) };
        let files = read_many(&[source], &ReadOptions::default()).unwrap();
        assert_eq!(files[0].len(), 1);
        assert_eq!(files[0][0].id, "XX.HATI.00.HNN");
    }
    let source = Source { channel: Some("HNX".into()), ..Source::new(&path) };
    let error = read_many(&[source], &ReadOptions::default()).unwrap_err();
    assert!(matches!(error, InputError::ChannelMissing { .. }), "{error}");
    // Floats and the other byte order are the same motion.
    let floats = read(&folder.join("floats.mseed"), &with_unit(Unit::MetrePerSecond2)).unwrap();
    // NumPy's sine and exponential may differ from Rust's in the last digits.
    assert_samples(&floats[0], 1.0, 0.0, 1e-14);
    let little = read(&folder.join("little_endian.mseed"), &with_unit(Unit::MillimetrePerSecond2)).unwrap();
    assert_eq!(little[0].samples, channels[0].samples);
    // Two segments that differ by a fifth of a step are one stretch.
    let jitter = read(&folder.join("jitter.mseed"), &with_unit(Unit::MillimetrePerSecond2)).unwrap();
    assert_eq!(jitter[0].samples, channels[0].samples);
}

#[test]
fn the_channel_code_of_a_seismometer_is_named() {
    let Some(folder) = fixtures() else { return };
    let path = folder.join("seismometer.mseed");
    assert!(refusal(&path, &accelerogram()).to_string().contains("velocity seismometer"));
    let mut options = accelerogram();
    options.unit = Some(Unit::MillimetrePerSecond);
    let error = refusal(&path, &options);
    assert!(matches!(error, InputError::QuantityMismatch { found: Quantity::Velocity, .. }), "{error}");
    options.unit = Some(Unit::G);
    let channel = read(&path, &options).unwrap().remove(0);
    assert_eq!(channel.steps[1].parameters["instrument_by_code"], "a velocity seismometer");
}

#[test]
fn sac_units_follow_its_header_in_both_byte_orders() {
    let Some(folder) = fixtures() else { return };
    // Single precision: 2⁻²⁴ of 1.5.
    for name in ["acceleration.sac", "acceleration_big.sac"] {
        let channel = read(&folder.join(name), &accelerogram()).unwrap().remove(0);
        assert_samples(&channel, 1.0, 0.0, 1e-7);
        assert_eq!(channel.unit_stored, "nm/s2");
        assert_eq!(channel.dt, DT);
    }
    for (name, quantity, factor) in
        [("velocity.sac", Quantity::Velocity, 1.0), ("displacement.sac", Quantity::Displacement, 0.01)]
    {
        let path = folder.join(name);
        let channel = read(&path, &ReadOptions::default()).unwrap().remove(0);
        assert_eq!(channel.quantity, quantity);
        assert_samples(&channel, factor, 0.0, 1e-7 * factor);
        let error = refusal(&path, &accelerogram());
        assert!(matches!(error, InputError::QuantityMismatch { .. }), "{error}");
        assert!(error.to_string().contains("quantity = "), "{error}");
    }
    for name in ["unknown.sac", "scaled.sac"] {
        let error = refusal(&folder.join(name), &accelerogram());
        assert!(matches!(error, InputError::UnitMissing { .. }), "{error}");
    }
    let channel = read(&folder.join("unknown.sac"), &with_unit(Unit::MetrePerSecond2)).unwrap().remove(0);
    assert_samples(&channel, 1.0, 0.0, 1e-7);
}

#[test]
fn an_absurd_peak_is_refused_until_the_unit_is_given() {
    let Some(folder) = fixtures() else { return };
    let path = folder.join("mislabelled.sac");
    let error = refusal(&path, &accelerogram());
    let InputError::PeakImplausible { peak, low, .. } = &error else { panic!("{error}") };
    assert!((peak / (1.5e-9 / 9.80665) - 1.0).abs() < 0.01 && *low == 1e-4, "{peak}");
    assert!(error.to_string().contains("unit = \"g\""), "{error}");
    let channel = read(&path, &with_unit(Unit::G)).unwrap().remove(0);
    assert_samples(&channel, 1.0, 0.0, 1e-6);
}

#[test]
fn gse2_calibration_is_no_unit() {
    let Some(folder) = fixtures() else { return };
    let path = folder.join("counts.gse2");
    let error = refusal(&path, &accelerogram());
    assert!(matches!(error, InputError::UnitMissing { .. }), "{error}");
    assert!(error.to_string().contains("displacement"), "{error}");
    let channel = read(&path, &with_unit(Unit::MillimetrePerSecond2)).unwrap().remove(0);
    assert_samples(&channel, 100.0, 0.0, 0.51e-3);
}

#[test]
fn unsound_samples_are_refused_with_their_place() {
    let Some(folder) = fixtures() else { return };
    let check = |name: &str, words: &[&str]| {
        // The refusal comes before the question of the unit.
        let text = refusal(&folder.join(name), &ReadOptions::default()).to_string();
        for word in words {
            assert!(text.contains(word), "{name}: no \"{word}\" in: {text}");
        }
    };
    check("gap.mseed", &["gap of 0.5", "2020-02-03T04:05:13.990000Z", "2020-02-03T04:05:14.500000Z"]);
    check("overlap.mseed", &["overlap of 0.5", "2020-02-03T04:05:13.500000Z"]);
    check("rates.mseed", &["mixed sampling", "0.01 s", "0.02 s"]);
    check("nan.mseed", &["sample 700 (at 7.000000 s) is NaN", "2 sample(s)"]);
    check("dead.mseed", &["dead channel", "2000 samples are 0"]);
    check("stuck.mseed", &["dead channel", "2000 samples are 77"]);
    check("clipped.mseed", &["clipped", "60000"]);
    check("cut.mseed", &["broken miniSEED", "has 512 bytes, but only 312 are left"]);
    check("trailing.mseed", &["broken miniSEED", "1 bytes from byte"]);
    check("cut.sac", &["NPTS = 2000 needs 8632 bytes, the file has 8232"]);
    check("uneven.sac", &["LEVEN"]);
    check("short.knet", &["Duration Time is 20 s, the samples last 15.00 s"]);
    check("no_memo.knet", &["Memo"]);
    check("checksum.gse2", &["broken GSE2", "hecksum"]);
    check("many.gse2", &["99999999 samples"]);
    check("one_sample.mseed", &["at least 2"]);
    // A slow swell of few counts also stands still at its top, and is no clipping.
    assert!(read(&folder.join("coarse.mseed"), &with_unit(Unit::Gal)).is_ok());
    let accept = ReadOptions { accept_clipped: true, ..with_unit(Unit::Gal) };
    assert!(read(&folder.join("clipped.mseed"), &accept).is_ok());
}

#[test]
fn a_pickle_is_never_opened_whatever_its_name() {
    if fixtures().is_none() {
        return;
    }
    // A folder of its own: whoever opens a pickle of it leaves the mark there.
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("pickles-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    python::make("make_fixtures.py", &folder, &folder);
    let marker = folder.join("marker");
    assert!(!marker.exists());
    let mut tried = 0;
    for entry in std::fs::read_dir(&folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        if !(name.starts_with("pickle") || name.starts_with("behind")) {
            continue;
        }
        let error = refusal(&path, &with_unit(Unit::Gal));
        // Protocols 0 and 1 have no mark of their own: they are just no format.
        let plain = matches!(name.as_bytes()[6], b'0' | b'1');
        match &error {
            InputError::FormatRefused { .. } => assert!(!plain, "{name}: {error}"),
            InputError::FormatUnknown { .. } => assert!(plain, "{name}: {error}"),
            InputError::RecordBroken { .. } => assert!(name.starts_with("behind"), "{name}: {error}"),
            _ => panic!("{name}: {error}"),
        }
        tried += 1;
        assert!(!marker.exists(), "{name} was executed");
    }
    assert_eq!(tried, 6 * 7);
    // The payload is real: opened as a pickle it leaves its mark. And the script itself refuses the
    // format, should it ever be asked.
    let content = std::fs::read(folder.join("pickle4.mseed")).unwrap();
    let reply = python::ask_script("PICKLE", &content);
    assert!(reply.contains("not among those that may be read"), "{reply}");
    assert!(!marker.exists());
    python::unpickle(&folder.join("pickle4.mseed"));
    assert!(marker.exists());
    std::fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn only_one_local_regular_file_is_a_location() {
    let Some(folder) = fixtures() else { return };
    let options = with_unit(Unit::Gal);
    let error = |location: &str| refusal(Path::new(location), &options);
    let inside = |name: &str| folder.join(name).display().to_string();
    for url in ["https://example.org/record.mseed", "file:///etc/hostname", "FTP://host/x"] {
        assert!(matches!(error(url), InputError::LocationIsUrl { .. }), "{url}");
    }
    assert!(matches!(error(&inside("*.mseed")), InputError::LocationIsPattern { .. }));
    assert!(matches!(error(&inside("absent.mseed")), InputError::RecordMissing { .. }));
    assert!(matches!(error(&inside("note.txt/x")), InputError::RecordMissing { .. }));
    assert!(matches!(error(&inside("")), InputError::RecordIsFolder { .. }));
    assert!(matches!(error("/dev/null"), InputError::RecordNotRegular { .. }));
    assert!(matches!(error(&inside("empty.mseed")), InputError::RecordEmpty { .. }));
    assert!(matches!(error(&inside("note.txt")), InputError::FormatUnknown { .. }));
    assert!(matches!(error(&inside("compressed.mseed.gz")), InputError::FormatRefused { .. }));
    // A name that looks like a pattern is a name when the file is there.
    assert_eq!(read(&folder.join("odd[1] name*.mseed"), &options).unwrap().len(), 1);
    let small = ReadOptions { limits: Limits { file_bytes: 100, ..Limits::default() }, ..options.clone() };
    let large = refusal(&folder.join("counts.mseed"), &small);
    assert!(matches!(large, InputError::RecordTooLarge { bytes: 9216, .. }), "{large}");
    let few = ReadOptions { limits: Limits { samples: 5999, ..Limits::default() }, ..options.clone() };
    let many = refusal(&folder.join("counts.mseed"), &few);
    assert!(matches!(many, InputError::TooManySamples { samples: 6000, .. }), "{many}");
}

#[test]
fn the_real_record_that_comes_with_obspy_is_read_by_its_place_in_the_package() {
    if fixtures().is_none() {
        return;
    }
    let location = Path::new("obspy:io/nied/tests/data/test.knet");
    let channel = read(location, &accelerogram()).unwrap().remove(0);
    assert_eq!(channel.id, "BO.AKT013..EW");
    assert_eq!((channel.dt, channel.samples.len()), (0.01, 5900));
    assert_eq!(channel.file, location);
    // Its header says 4.383 gal, about the mean.
    let mut motion = Motion::from_channels([Some(&channel), None, None]).unwrap();
    Process::Demean { first_seconds: None }.apply(&mut motion).unwrap();
    assert!((motion.peak() - 0.04383).abs() < 1e-5, "{}", motion.peak());
    for outside in ["obspy:../numpy/version.py", "obspy:/etc/hostname", "obspy:", "obspy:io/../../x"] {
        let error = refusal(Path::new(outside), &accelerogram());
        assert!(matches!(error, InputError::PackagedOutside { .. }), "{outside}: {error}");
    }
    let error = refusal(Path::new("obspy:io/absent"), &accelerogram());
    assert!(matches!(error, InputError::RecordMissing { .. }), "{error}");
    let error = refusal(Path::new("obspy:io"), &accelerogram());
    assert!(matches!(error, InputError::RecordIsFolder { .. }), "{error}");
}

#[test]
fn several_files_come_from_one_process_in_order() {
    let Some(folder) = fixtures() else { return };
    let sources = [
        Source::new(folder.join("east.knet")),
        Source { unit: Some(Unit::MillimetrePerSecond2), ..Source::new(folder.join("counts.mseed")) },
        Source::new("obspy:io/nied/tests/data/test.knet"),
        Source::new(folder.join("acceleration.sac")),
    ];
    let files = read_many(&sources, &accelerogram()).unwrap();
    let ids: Vec<&str> = files.iter().flatten().map(|channel| channel.id.as_str()).collect();
    let expected = [
        "BO.HATI01..EW",
        "XX.HATI.00.HNE",
        "XX.HATI.00.HNN",
        "XX.HATI.00.HNZ",
        "BO.AKT013..EW",
        "XX.HATI.00.HNE",
    ];
    assert_eq!(ids, expected);
    assert_samples(&files[3][0], 1.0, 0.0, 1e-7);
    assert!(read_many(&[], &accelerogram()).unwrap().is_empty());
}

#[test]
fn a_python_that_is_missing_silent_or_slow_is_told_apart() {
    use std::os::unix::fs::PermissionsExt;
    let Some(folder) = fixtures() else { return };
    let record = folder.join("east.knet");
    let with = |python: PathBuf, seconds: f64| ReadOptions {
        python: Some(python),
        limits: Limits { time: Duration::from_secs_f64(seconds), ..Limits::default() },
        ..ReadOptions::default()
    };
    let script = |name: &str, body: &str| {
        let path = folder.join(name);
        std::fs::write(&path, format!("#!/bin/sh\n{body}\n")).unwrap();
        std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o755)).unwrap();
        path
    };
    let error = refusal(&record, &with(folder.join("no_such_python"), 60.0));
    assert!(matches!(error, InputError::PythonMissing { .. }), "{error}");
    assert!(error.to_string().contains("make setup") && error.to_string().contains("HATI_PYTHON"));

    let broken = script("broken_python", "echo some last words >&2; exit 3");
    let error = refusal(&record, &with(broken, 60.0));
    let text = error.to_string();
    assert!(matches!(error, InputError::ReaderFailed { .. }), "{text}");
    assert!(text.contains("some last words") && text.contains("exit status: 3"), "{text}");

    let noisy = script("noisy_python", "read line; echo not json; exec cat >/dev/null");
    let error = refusal(&record, &with(noisy, 60.0));
    assert!(error.to_string().contains("not JSON"), "{error}");

    let short = script(
        "short_python",
        r#"read line; echo '{"obspy":"1","files":[{"format":"SAC","channels":[{"id":"a","channel":"a","npts":9,"dt":1,"start_ns":0,"start_utc":"","end_utc":"","calib":1,"header":{}}],"warnings":[]}]}'"#,
    );
    let error = refusal(&record, &with(short, 60.0));
    assert!(error.to_string().contains("before all it announced"), "{error}");

    let slow = script("slow_python", "exec sleep 30");
    let begin = Instant::now();
    let error = refusal(&record, &with(slow, 0.3));
    assert!(matches!(error, InputError::ReaderTimeout { .. }), "{error}");
    assert!(begin.elapsed() < Duration::from_secs(10));

    // A Python without ObsPy: the interpreter of the virtual environment, without its packages.
    let bare = script("bare_python", &format!("exec {} -S \"$@\"", python::interpreter().display()));
    let error = refusal(&record, &with(bare, 60.0));
    assert!(matches!(error, InputError::ObspyMissing { .. }), "{error}");
    assert!(error.to_string().contains("pip install obspy==1.5.0"), "{error}");
}

/// K-NET states its peak: a scale factor that does not give it is wrong.
#[test]
fn a_scale_factor_that_misses_the_stated_peak_is_refused() {
    let Some(folder) = fixtures() else { return };
    let text = std::fs::read_to_string(folder.join("east.knet")).unwrap();
    let line = text.lines().find(|line| line.starts_with("Scale Factor")).unwrap();
    let wrong = text.replace(line, &line.replace("(gal)/8388608", "(gal)/83886080"));
    assert_ne!(text, wrong);
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("scale-{}.EW", std::process::id()));
    std::fs::write(&path, wrong).unwrap();
    let error = refusal(&path, &ReadOptions::default());
    std::fs::remove_file(&path).unwrap();
    assert!(error.to_string().contains("Max. Acc. is 14"), "{error}");
    assert!(error.to_string().contains("counts times Scale Factor give"), "{error}");
}

/// A unit that is given sets the file's own aside; the step says which.
#[test]
fn a_given_unit_tells_what_the_file_states() {
    let Some(folder) = fixtures() else { return };
    let told = read(&folder.join("east.knet"), &with_unit(Unit::Gal)).unwrap().remove(0);
    assert_eq!(told.steps[1].found["file_states"], "counts × scale factor (gal/count)");
    let own = read(&folder.join("east.knet"), &ReadOptions::default()).unwrap().remove(0);
    assert!(own.steps[1].found.get("file_states").is_none());
}

/// A header in milliseconds that is read as seconds shows in the step.
#[test]
fn a_step_that_no_accelerograph_has_must_be_confirmed() {
    if fixtures().is_none() {
        return;
    }
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("slow-{}.csv", std::process::id()));
    let rows = (0..200).map(|i| format!("{},{:.4}\n", 10 * i, (0.3 * f64::from(i)).sin()));
    std::fs::write(&path, format!("time_s,acc_m_s2\n{}", rows.collect::<String>())).unwrap();
    let error = refusal(&path, &ReadOptions::default());
    assert!(error.to_string().contains("read as 10 s") && error.to_string().contains("--dt 10"), "{error}");
    let told = Source { dt: Some(10.0), ..Source::new(&path) };
    let found = read_many(&[told], &ReadOptions::default()).unwrap().remove(0).remove(0);
    std::fs::remove_file(&path).unwrap();
    assert_eq!((found.dt, found.samples.len()), (10.0, 200));
}
