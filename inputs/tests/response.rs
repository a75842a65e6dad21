//! From counts to ground motion with station metadata: StationXML, RESP, SAC poles and zeros.

mod python;

use std::path::{Path, PathBuf};

use hati_inputs::InputError;
use hati_inputs::motion::Quantity;
use hati_inputs::records::{
    Channel, ReadOptions, Response, ResponseMode, Source, Unit, read_each, read_many,
};

fn collection() -> Option<PathBuf> {
    let shared = std::env::var_os("HATI_SHARED")
        .map_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared"), PathBuf::from);
    if !shared.join("records/expected.csv").is_file() {
        python::say("skipped: no collection of records (HATI_SHARED or ../shared)");
        return None;
    }
    python::has_obspy().then(|| shared.join("records"))
}

fn with(record: PathBuf, metadata: PathBuf, mode: ResponseMode) -> Source {
    Source { response: Some(Response { mode, ..Response::new(metadata) }), ..Source::new(record) }
}

fn one(source: Source) -> Result<Channel, InputError> {
    read_many(&[source], &ReadOptions::default()).map(|mut files| files.remove(0).remove(0))
}

fn peak(channel: &Channel) -> f64 {
    let mean = channel.samples.iter().sum::<f64>() / channel.samples.len() as f64;
    channel.samples.iter().fold(0.0, |peak: f64, value| peak.max((value - mean).abs()))
}

#[test]
fn ridgecrest_with_its_metadata_gives_the_reference_peaks() {
    let Some(folder) = collection() else { return };
    let folder = folder.join("mseed_stationxml/ridgecrest2019");
    for (channel, full, by_sensitivity) in
        [("HNE", 3.17698, 3.36677), ("HNN", 5.24214, 4.99578), ("HNZ", 3.78452, 3.39396)]
    {
        let record = folder.join(format!("CI.CLC..{channel}.mseed"));
        let metadata = folder.join("CI.CLC.xml");
        for (mode, expected) in [(ResponseMode::Full, full), (ResponseMode::Sensitivity, by_sensitivity)] {
            let found = one(with(record.clone(), metadata.clone(), mode)).unwrap();
            assert_eq!((found.quantity, found.samples.len()), (Quantity::Acceleration, 39001));
            let error = peak(&found) / expected - 1.0;
            python::say(&format!("{channel} {}: {:.5} m/s², {error:+.1e}", mode.as_str(), peak(&found)));
            assert!(error.abs() < 1e-4, "{channel} {}: {error}", mode.as_str());
        }
    }
}

#[test]
fn the_collections_metadata_are_used_or_refused_with_the_remedy() {
    let Some(folder) = collection() else { return };
    let [weak, colocated, bad] =
        ["mseed_stationxml/napa2014", "mseed_stationxml/colocated_vel_acc", "bad_input"];
    // Record, metadata, mode, and what comes of it: a quantity with its peak, or words of the refusal.
    type Outcome = Result<(Quantity, f64), &'static str>;
    let napa = format!("{weak}/BK.CMB.00.HNE.mseed");
    let clashing = format!("{bad}/differing_sensitivity_CI.Q0056.01.HNE.mseed");
    let clashing_xml = format!("{bad}/differing_sensitivity_CI.Q0056.xml");
    let bpaw_xml = format!("{colocated}/AK.BPAW.xml");
    let [bhe, bne] = ["BHE", "BNE"].map(|code| format!("{colocated}/AK.BPAW..{code}.mseed"));
    use Quantity::{Acceleration, Velocity};
    use ResponseMode::{Full, Sensitivity, Stages};
    let cases: [(&str, &str, ResponseMode, Outcome); 12] = [
        (&napa, "mseed_stationxml/napa2014/BK.CMB.xml", Full, Ok((Acceleration, 0.00511))),
        (&napa, "mseed_stationxml/napa2014/BK.CMB.xml", Sensitivity, Ok((Acceleration, 0.00513))),
        (&bhe, &bpaw_xml, Full, Err("no response stages and state only its sensitivity")),
        (&bne, &bpaw_xml, Stages, Err("no response stages")),
        (&bhe, &bpaw_xml, Sensitivity, Ok((Velocity, 0.00172))),
        (&bne, &bpaw_xml, Sensitivity, Ok((Acceleration, 0.0254))),
        (&clashing, &clashing_xml, Full, Err("contradicts itself: its stated sensitivity is 25635.4")),
        (&clashing, &clashing_xml, Stages, Ok((Acceleration, 0.3816))),
        (&clashing, &clashing_xml, Sensitivity, Ok((Acceleration, 3.8233))),
        (&clashing, "sac/RESP.NZ.CRLZ.10.HHZ", Full, Err("hold NZ.CRLZ.10.HHZ, not CI.Q0056.01.HNE")),
        (&clashing, "sac/NZCRLZ_HHZ10.pz", Full, Err("for network NZ, the record is CI.Q0056.01.HNE")),
        (
            &clashing,
            "sac/SAC_PZs_NZ_CRLZ_HHZ",
            Full,
            Err("is of velocity, but its code HNE is that of an accelerometer"),
        ),
    ];
    let sources: Vec<Source> =
        cases.iter().map(|case| with(folder.join(case.0), folder.join(case.1), case.2)).collect();
    let files = read_each(&sources, &ReadOptions::default()).unwrap();
    for ((record, _, mode, expected), found) in cases.iter().zip(files) {
        match (expected, found) {
            (Ok((quantity, expected)), Ok(channels)) => {
                assert_eq!(channels[0].quantity, *quantity, "{record}");
                let peak = peak(&channels[0]);
                assert!((peak / expected - 1.0).abs() < 5e-3, "{record} {mode:?}: {peak}");
            }
            (Err(words), Err(error)) => {
                let text = error.to_string();
                assert!(text.contains(words) && text.contains("\n  help: "), "{record} {mode:?}: {text}");
            }
            (expected, found) => panic!("{record} {mode:?}: {expected:?}, {found:?}"),
        }
    }
    // Velocity does not pass for acceleration.
    let options = ReadOptions { quantity: Some(Acceleration), ..ReadOptions::default() };
    let error =
        read_many(&[with(folder.join(&bhe), folder.join(&bpaw_xml), Sensitivity)], &options).unwrap_err();
    assert!(matches!(error, InputError::QuantityMismatch { .. }), "{error}");
}

/// The ground motion behind the fixtures, at their samples.
fn ground(t: f64) -> f64 {
    1.5 * (4.0 * std::f64::consts::PI * t).sin() * (-((t - 30.0) / 3.0).powi(2)).exp()
}

#[test]
fn metadata_of_every_kind_give_back_the_ground_motion() {
    let Some(folder) = python::made_by("make_fixtures_response.py") else { return };
    for metadata in ["station.xml", "station.resp", "station.pz", "bare.pz", "nanometres.pz"] {
        let found = one(with(folder.join("HNE.mseed"), folder.join(metadata), ResponseMode::Full)).unwrap();
        assert_eq!(found.quantity, Quantity::Acceleration, "{metadata}");
        let wrong = |(i, value): (usize, &f64)| (value - ground(i as f64 * found.dt)).powi(2);
        let error = found.samples.iter().enumerate().map(wrong).sum::<f64>();
        let right = (0..6000).map(|i| ground(i as f64 * 0.01).powi(2)).sum::<f64>();
        let error = (error / right).sqrt();
        python::say(&format!("{metadata}: relative L2 error {error:.1e}"));
        assert!(error < 2e-5, "{metadata}: {error}");
        let unit = &found.steps[1].parameters;
        assert_eq!(unit["given_by"], "metadata");
        assert_eq!(unit["response"]["pre_filter_hz"][3], 48.0);
        assert_eq!(unit["metadata_sha256"].as_str().unwrap().len(), 64);
    }
    // By the sensitivity alone the instrument's 20 Hz show at 2 Hz, by 1 %.
    let found =
        one(with(folder.join("HNE.mseed"), folder.join("station.xml"), ResponseMode::Sensitivity)).unwrap();
    assert!((peak(&found) / 1.5 - 1.0).abs() < 0.02 && found.quantity == Quantity::Acceleration);
    let found =
        one(with(folder.join("HHE.mseed"), folder.join("seismometer.pz"), ResponseMode::Full)).unwrap();
    assert_eq!(found.quantity, Quantity::Velocity);
    let expected = 1.5 / (4.0 * std::f64::consts::PI);
    assert!((peak(&found) / expected - 1.0).abs() < 3e-3, "{}", peak(&found));
}

#[test]
fn a_response_that_cannot_be_right_is_refused_with_the_remedy() {
    let Some(folder) = python::made_by("make_fixtures_response.py") else { return };
    let cases = [
        ("contradictory.xml", "its stages give", "response = \"stages\""),
        ("no_stages.xml", "no response stages", "response = \"sensitivity\""),
        ("no_response.xml", "without a response", "metadata of that time"),
        ("ended.xml", "hold for 2000-01-01", "metadata of that time"),
        ("other_channel.xml", "hold XX.HATI.00.HNN, not XX.HATI.00.HNE", "metadata of this channel"),
        ("pressure.xml", "takes in 'PA'", "give unit"),
        ("entity.xml", "document type or entities", "StationXML"),
        ("cut.xml", "cannot be removed", "check the metadata file"),
        ("cut.pz", "no CONSTANT", "intact"),
        ("word.pz", "line 1 of the pole-zero file", "intact"),
        ("seismometer.pz", "for channel HHE", "metadata of this channel"),
        ("HNE.mseed", "no station metadata", "RESP"),
        ("missing.xml", "no such file", "spelling"),
    ];
    let record = folder.join("HNE.mseed");
    let sources: Vec<Source> =
        cases.iter().map(|case| with(record.clone(), folder.join(case.0), ResponseMode::Full)).collect();
    let files = read_each(&sources, &ReadOptions::default()).unwrap();
    for ((name, problem, remedy), found) in cases.iter().zip(files) {
        let text = found.expect_err(name).to_string();
        let help = text.split("help: ").nth(1).unwrap_or_default();
        assert!(text.contains(problem) && help.contains(remedy), "{name}: {text}");
    }
    let both =
        Source { unit: Some(Unit::Gal), ..with(record, folder.join("station.xml"), ResponseMode::Full) };
    assert!(matches!(one(both).unwrap_err(), InputError::UnitAndResponse { .. }));
}

#[test]
fn settings_of_the_removal_are_checked_and_matter() {
    let Some(folder) = python::made_by("make_fixtures_response.py") else { return };
    let asked = |pre_filter, water_level| {
        let response = Response { pre_filter, water_level, ..Response::new(folder.join("station.xml")) };
        one(Source { response: Some(response), ..Source::new(folder.join("HNE.mseed")) })
    };
    for corners in [[0.0, 0.1, 60.0, 70.0], [0.1, 0.05, 20.0, 30.0], [-1.0, 0.05, 20.0, 30.0]] {
        let text = asked(Some(corners), None).unwrap_err().to_string();
        assert!(text.contains("four corners must rise"), "{text}");
    }
    // A window above the motion's 2 Hz leaves nothing of it that a ground motion would be.
    let text = asked(Some([10.0, 12.0, 40.0, 48.0]), None).map(|channel| peak(&channel));
    assert!(text.is_err() || text.as_ref().is_ok_and(|peak| *peak < 1e-3), "{text:?}");
    let found = asked(Some([0.02, 0.05, 40.0, 48.0]), Some(60.0)).unwrap();
    assert_eq!(found.steps[1].parameters["response"]["water_level_db"], 60.0);
    let highest = (0..6000).map(|i| ground(i as f64 * 0.01)).fold(0.0, f64::max);
    assert!((peak(&found) / highest - 1.0).abs() < 1e-4, "{} {highest}", peak(&found));
}

/// Metadata that come with the installed ObsPy package are found there.
#[test]
fn packaged_metadata_are_named_like_packaged_records() {
    let Some(folder) = python::made_by("make_fixtures_response.py") else { return };
    let packaged = |path: &str| with(folder.join("HNE.mseed"), path.into(), ResponseMode::Full);
    let text =
        one(packaged("obspy:io/stationxml/tests/data/IRIS_single_channel_with_response.xml")).unwrap_err();
    assert!(text.to_string().contains("not XX.HATI.00.HNE"), "{text}");
    let text = one(packaged("obspy:../metadata.xml")).unwrap_err();
    assert!(matches!(text, InputError::PackagedOutside { .. }), "{text}");
}
