//! The collection of real and made-up records beside the workspace, against its `expected.csv`.
//!
//! The collection is no part of the project: HATI_SHARED names its folder, or it lies in `../shared`
//! of the workspace. Where it is absent these tests say so and pass.

mod python;

use std::path::{Path, PathBuf};

use hati_inputs::InputError;
use hati_inputs::motion::{Motion, Offset, Quantity};
use hati_inputs::records::{Channel, ReadOptions, Source, Unit, read, read_many};

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
        motion.remove_offset(Offset::FirstSeconds(1.0)).unwrap();
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
        motion.remove_offset(Offset::Mean).unwrap();
        assert!((motion.peak() / pga - 1.0).abs() < 1e-5, "{end}: {}", motion.peak());
        let step = &motion.steps.last().unwrap().parameters;
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
        ("bad_input/nan_float32.mseed", true, "no unit"),
        ("fixtures_cc0/bad_clipped.mseed", false, "clipped"),
        ("fixtures_cc0/bad_dead_channel.mseed", false, "dead channel"),
        ("fixtures_cc0/bad_gap_overlap_mixed_rate.mseed", false, "gap"),
        ("bad_input/broken_head.gse2", false, "0 samples"),
        ("bad_input/loc_RJOB20050831023349.z.wrong_chksum", false, "hecksum"),
        ("bad_input/brokenlastrecord.mseed", false, "broken miniSEED"),
        ("bad_input/corrupt_one_extra_byte_at_end.mseed", false, "broken miniSEED"),
        ("bad_input/gaps_3comp_ffbx_unrotated.mseed", false, "gap"),
        ("mseed_stationxml/ridgecrest2019/CI.CLC.xml", false, "XML"),
        ("peer_at2/elcentro1940_NS.AT2", false, "no known record format"),
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
