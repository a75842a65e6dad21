//! The collection of real and made-up records beside the workspace, against its `expected.csv`.
//!
//! The collection is no part of the project: HATI_SHARED names its folder, or it lies in `../shared`
//! of the workspace. Where it is absent these tests say so and pass.

mod python;

use std::path::{Path, PathBuf};

use hati_inputs::InputError;
use hati_inputs::motion::{Motion, Process, Quantity};
use hati_inputs::records::{Channel, ReadOptions, Response, Source, Unit, read, read_each, read_many};

fn collection() -> Option<PathBuf> {
    let shared = std::env::var_os("HATI_SHARED")
        .map_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared"), PathBuf::from);
    let folder = shared.join("records");
    if !folder.join("expected.csv").is_file() {
        python::say("skipped: no collection of records (HATI_SHARED or ../shared)");
        return None;
    }
    python::has_obspy().then_some(folder)
}

fn accelerogram(unit: Option<Unit>) -> ReadOptions {
    ReadOptions { unit, quantity: Some(Quantity::Acceleration), ..ReadOptions::default() }
}

fn vertical_or_x(channel: &Channel) -> Motion {
    let components =
        if channel.axis_hint == Some(2) { [None, None, Some(channel)] } else { [Some(channel), None, None] };
    Motion::from_channels(components).unwrap()
}

/// Fields of a line of comma-separated values, with quotes where a field has commas.
fn fields(line: &str) -> Vec<String> {
    let (mut found, mut quoted) = (vec![String::new()], false);
    for letter in line.chars() {
        match letter {
            '"' => quoted = !quoted,
            ',' if !quoted => found.push(String::new()),
            other => found.last_mut().unwrap().push(other),
        }
    }
    found
}

/// Files that a name of the table stands for; a star is any end of a name.
fn files(folder: &Path, name: &str) -> Vec<PathBuf> {
    let Some(before) = name.strip_suffix('*') else { return vec![folder.join(name)] };
    let entries = std::fs::read_dir(folder.join(before)).unwrap().map(|entry| entry.unwrap().path());
    let mut files: Vec<_> =
        entries.filter(|path| path.extension().is_some_and(|end| end == "mseed")).collect();
    files.sort();
    files
}

/// The source that the table means: counts come with the StationXML of their folder.
fn source(file: &Path, stored: &str) -> Source {
    let metadata = std::fs::read_dir(file.parent().unwrap()).unwrap().map(|entry| entry.unwrap().path());
    let metadata = metadata.into_iter().find(|path| path.extension().is_some_and(|end| end == "xml"));
    let wanted = stored.contains("xml") || stored.contains("StationXML");
    let response = metadata.filter(|_| wanted).map(Response::new);
    Source { response, ..Source::new(file) }
}

/// Every row: read with that step, number, unit and peak, or refused with file and remedy.
#[test]
fn every_file_of_the_collection_gives_what_its_table_says() {
    let Some(folder) = collection() else { return };
    let table = std::fs::read_to_string(folder.join("expected.csv")).unwrap();
    let rows: Vec<Vec<String>> = table.lines().skip(1).map(fields).collect();
    let (mut read, mut refused) = (0, 0);
    for row in &rows {
        let [name, _, npts, dt, stored, expected, ..] = row.as_slice() else { panic!("{row:?}") };
        let files = files(&folder, name);
        assert!(!files.is_empty(), "{name}");
        let sources: Vec<Source> = files.iter().map(|file| source(file, stored)).collect();
        for (file, answer) in files.iter().zip(read_each(&sources, &accelerogram(None)).unwrap()) {
            let open = expected.is_empty() && answer.is_err();
            if expected == "refuse" || open {
                let text = answer.map(|channels| channels.len()).expect_err(name).to_string();
                assert!(text.contains(&file.display().to_string()) && text.contains("\n  help: "), "{text}");
                // What the table leaves open is refused for its unit alone.
                assert!(!open || text.contains("no unit"), "{text}");
                refused += 1;
                continue;
            }
            let channels = answer.unwrap_or_else(|error| panic!("{name}: {error}"));
            let channel = &channels[0];
            assert_eq!(channel.quantity, Quantity::Acceleration);
            // The table gives no number of samples for one file, whose header says 3500 at 0.01 s.
            let stated = (npts.parse().unwrap_or(3500), dt.parse().unwrap_or(0.01));
            assert_eq!((channel.samples.len(), channel.dt), stated, "{name}");
            let found = channel.steps[1].parameters["factor_to_si"].as_f64();
            match stored.split(' ').next().unwrap().replace('^', "").to_lowercase().parse::<Unit>() {
                Ok(unit) => assert_eq!(found, Some(unit.factor()), "{name}: {}", channel.unit_stored),
                // Counts; and the unit that stands in the block of data alone.
                Err(_) => assert!(stored.starts_with("counts") || stored == "see the data block", "{stored}"),
            }
            if let Ok(peak) = expected.parse::<f64>() {
                let offset = match name.contains("SYNH01") {
                    true => channel.samples[..100].iter().sum::<f64>() / 100.0,
                    false => 0.0,
                };
                let found =
                    channel.samples.iter().fold(0.0_f64, |peak, value| peak.max((value - offset).abs()));
                assert!((found / peak - 1.0).abs() < 1e-3, "{name}: {found} against {peak}");
            }
            read += 1;
        }
    }
    python::say(&format!("{} rows: {read} files read as expected, {refused} refused", rows.len()));
    assert!(read >= 20 && refused >= 30, "{read} read, {refused} refused");
}

#[test]
fn the_chilean_file_has_three_channels_in_tenths_of_g() {
    let Some(folder) = collection() else { return };
    let channels = read(&folder.join("renadic_chile/altohospicio0911131.v1"), &accelerogram(None)).unwrap();
    assert_eq!(channels.iter().map(|c| c.axis_hint).collect::<Vec<_>>(), [Some(0), Some(1), Some(2)]);
    // Peaks that the headers of the three channels state, g.
    for (channel, stated) in channels.iter().zip([0.051, 0.084, 0.035]) {
        assert_eq!((channel.samples.len(), channel.dt, channel.unit_stored.as_str()), (3500, 0.01, "G/10"));
        let found = channel.samples.iter().fold(0.0_f64, |peak, value| peak.max(value.abs()));
        assert!((found / 9.80665 - stated).abs() < 6e-4, "{}: {found}", channel.id);
    }
}

#[test]
fn kiknet_files_give_the_expected_peaks() {
    let Some(folder) = collection() else { return };
    let cases = [("EW1", 0.574542), ("NS1", 0.912528), ("EW2", 1.38982), ("NS2", 2.63617)];
    let sources: Vec<Source> = cases
        .iter()
        .map(|(end, _)| Source::new(folder.join(format!("fixtures_cc0/SYNH013001020304.{end}"))))
        .collect();
    let files = read_many(&sources, &accelerogram(None)).unwrap();
    for ((end, pga), channels) in cases.iter().zip(files) {
        let channel = &channels[0];
        assert_eq!((channel.samples.len(), channel.dt), (6000, 0.01), "{end}");
        let mut motion = vertical_or_x(channel);
        Process::Demean { first_seconds: Some(1.0) }.apply(&mut motion).unwrap();
        assert!((motion.peak() / pga - 1.0).abs() < 1e-5, "{end}: {} against {pga}", motion.peak());
    }
}

#[test]
fn sac_files_in_g_under_a_header_of_nanometres_are_refused_until_told() {
    let Some(folder) = collection() else { return };
    for (end, pga, gravity) in [("HNE", 0.20674, false), ("HNN", 0.187933, false), ("HNZ", 0.0929635, true)] {
        let path = folder.join(format!("sac/20190706031952.CJ.T001230.{end}.sac"));
        let error = read(&path, &accelerogram(None)).unwrap_err();
        assert!(matches!(error, InputError::PeakImplausible { .. }), "{error}");
        let channel = read(&path, &accelerogram(Some(Unit::G))).unwrap().remove(0);
        assert_eq!((channel.samples.len(), channel.dt), (15001, 0.02));
        let mut motion = vertical_or_x(&channel);
        Process::Demean { first_seconds: None }.apply(&mut motion).unwrap();
        assert!((motion.peak() / pga - 1.0).abs() < 1e-5, "{end}: {}", motion.peak());
        let step = &motion.steps.last().unwrap().found;
        let named = step.get("z").and_then(|z| z.get("gravity_g"));
        assert_eq!(named.and_then(serde_json::Value::as_f64), gravity.then_some(1.0), "{step:?}");
    }
}

#[test]
fn counts_are_refused_until_a_unit_is_given_and_bad_files_always() {
    let Some(folder) = collection() else { return };
    let gal = accelerogram(Some(Unit::Gal));
    // File, whether it can be read once a unit is given, and a word of the refusal without one.
    let cases = [
        ("mseed_stationxml/ridgecrest2019/CI.CLC..HNE.mseed", true, "no unit"),
        ("mseed_stationxml/napa2014/BK.CMB.00.HNZ.mseed", true, "no unit"),
        ("mseed_stationxml/colocated_vel_acc/AK.BPAW..BHE.mseed", true, "velocity seismometer"),
        ("mseed_stationxml/colocated_vel_acc/AK.BPAW..BNE.mseed", true, "accelerometer"),
        ("bad_input/differing_sensitivity_CI.Q0056.01.HNE.mseed", true, "no unit"),
        ("gse2/acc.gse", true, "no unit"),
        ("gse2/loc_RJOB20050831023349.z", true, "displacement"),
        ("fixtures_cc0/trap_velocity_not_acceleration.sac", true, "no unit"),
        ("bad_input/nan_float32.mseed", false, "read as 1 s, which no accelerograph has"),
        ("fixtures_cc0/bad_clipped.mseed", false, "clipped"),
        ("fixtures_cc0/bad_dead_channel.mseed", false, "dead channel"),
        ("fixtures_cc0/bad_gap_overlap_mixed_rate.mseed", false, "gap"),
        ("bad_input/broken_head.gse2", false, "0 samples"),
        ("bad_input/loc_RJOB20050831023349.z.wrong_chksum", false, "hecksum"),
        ("bad_input/brokenlastrecord.mseed", false, "broken miniSEED"),
        ("bad_input/corrupt_one_extra_byte_at_end.mseed", false, "broken miniSEED"),
        ("bad_input/gaps_3comp_ffbx_unrotated.mseed", false, "gap"),
        ("mseed_stationxml/ridgecrest2019/CI.CLC.xml", false, "XML"),
        ("expected.csv", false, "no known record format"),
    ];
    for (name, readable, word) in cases {
        let path = folder.join(name);
        let error = read(&path, &accelerogram(None)).expect_err(name).to_string();
        assert!(error.contains(word), "{name}: no \"{word}\" in: {error}");
        match read(&path, &gal) {
            Ok(_) => assert!(readable, "{name} was read"),
            Err(error) => assert!(!readable, "{name}: {error}"),
        }
    }
}

#[test]
fn the_velocity_trap_holds_when_its_true_unit_is_given() {
    let Some(folder) = collection() else { return };
    let path = folder.join("fixtures_cc0/trap_velocity_not_acceleration.sac");
    let error = read(&path, &accelerogram(Some(Unit::MetrePerSecond))).unwrap_err();
    assert!(matches!(error, InputError::QuantityMismatch { .. }), "{error}");
}

#[test]
fn the_traps_of_the_collection_load_once_told() {
    let Some(folder) = collection() else { return };
    let bare = Source {
        unit: Some(Unit::G),
        dt: Some(0.02),
        ..Source::new(folder.join("peer_at2/elcentro1940_NS_bare.dat"))
    };
    let platform = Source {
        unit: Some(Unit::CentimetrePerSecond2),
        ..Source::new(folder.join("generic_ascii/accel_ts.bbp"))
    };
    let mut answers = read_each(&[bare, platform], &accelerogram(None)).unwrap().into_iter();
    let bare = answers.next().unwrap().unwrap();
    assert_eq!((bare[0].samples.len(), bare[0].dt), (1559, 0.02));
    let platform = answers.next().unwrap().unwrap();
    assert_eq!(platform.iter().map(|c| c.axis_hint).collect::<Vec<_>>(), [Some(1), Some(0), Some(2)]);
    assert_eq!((platform[0].samples.len(), platform[0].dt), (4096, 0.025));
}
