//! Every refusal says what to do, in a line of its own.

use std::path::PathBuf;

use super::InputError;
use crate::gmsh::MeshFault;
use crate::motion::Quantity;

fn path() -> PathBuf {
    "a.rec".into()
}

fn word() -> String {
    "something".into()
}

/// Of files: where they are and what they are.
fn of_files() -> Vec<InputError> {
    use InputError::*;
    let (format, source) = ("SAC", std::io::Error::other("refused"));
    vec![
        LocationIsUrl { location: word() },
        LocationIsPattern { location: word() },
        RecordMissing { path: path() },
        RecordIsFolder { path: path() },
        RecordNotRegular { path: path() },
        RecordUnreadable { path: path(), source },
        RecordTooLarge { path: path(), bytes: 9, limit: 8 },
        RecordEmpty { path: path() },
        PackagedOutside { location: word() },
        FormatUnknown { path: path(), beginning: word(), known: word() },
        FormatRefused { path: path(), what: "a picture", remedy: "take another" },
        RecordBroken { path: path(), format, problem: word() },
        RecordRefused { path: path(), format, problem: word(), remedy: word() },
        TooManySamples { path: path(), samples: 9, limit: 8 },
        ChannelMissing { path: path(), wanted: word(), present: word() },
        MetadataUnknown { path: path(), problem: word() },
        ResponseRefused { path: path(), metadata: path(), problem: word(), remedy: word() },
        UnitAndResponse { path: path(), unit: word(), metadata: path() },
        PythonMissing { tried: word() },
        ObspyMissing { python: path(), reason: word() },
        PlugInsMissing { path: path(), reason: word() },
        ReaderCrashed { path: path(), problem: word(), stderr: word() },
        ReaderTimeout { python: path(), seconds: 1.0, stderr: word() },
        ReaderFailed { python: path(), problem: word(), stderr: word(), crashed: false },
    ]
}

/// Of channels: their samples and what these mean.
fn of_channels() -> Vec<InputError> {
    use InputError::*;
    let quantity = Quantity::Acceleration;
    let (low, high, si, value) = (1e-6, 1e2, "m/s²", 1e308);
    vec![
        Gap { path: path(), channel: word(), end: word(), begin: word(), seconds: 1.0 },
        Overlap { path: path(), channel: word(), end: word(), begin: word(), seconds: 1.0 },
        MixedRates {
            path: path(),
            channel: word(),
            first: 0.01,
            first_begin: word(),
            second: 0.02,
            second_begin: word(),
        },
        TooShort { path: path(), channel: word(), samples: 1 },
        BadStep { path: path(), channel: word(), dt: 0.0 },
        NotFinite { path: path(), channel: word(), index: 3, time: 0.1, value: f64::NAN, count: 1 },
        DeadChannel { path: path(), channel: word(), samples: 9, value },
        Clipped { path: path(), channel: word(), run: 9, count: 9, value, time: 1.0 },
        UnitMissing { path: path(), channel: word(), reason: word(), choices: word() },
        UnitUnknown { found: word(), choices: word() },
        PeakImplausible { path: path(), channel: word(), unit: word(), quantity, peak: value, si, low, high },
        QuantityMismatch { path: path(), channel: word(), found: Quantity::Velocity, expected: quantity },
        StepMissing { path: path(), channel: word(), doubt: Some(word()), fits: Some(0.005) },
        StepImplausible { path: path(), channel: word(), dt: 9.0, low, high },
        StepContradicts { path: path(), channel: word(), stated: 0.01, given: 0.02 },
    ]
}

/// Of meshes and Gmsh.
fn of_meshes() -> Vec<InputError> {
    use InputError::*;
    let (problem, remedy, messages) = (word(), word(), String::from("\n  Error   : of Gmsh"));
    vec![
        MeshBroken { path: path(), place: "line 3".into(), problem: word() },
        MeshRefused { path: path(), problem, remedy },
        MeshElement {
            path: path(),
            tag: 7,
            centre: [999_968.820_000_000_1, 0.0, -1e-7],
            fault: Box::new(MeshFault::NoGroup),
            others: 2,
        },
        GeoRefused { path: path(), problem: word(), remedy: "leave it" },
        GmshMissing { python: path(), reason: word() },
        GmshFailed { path: path(), problem: word(), messages: messages.clone() },
        GmshTimeout { path: path(), seconds: 60.0, messages },
    ]
}

/// Of motions and their processing.
fn of_motions() -> Vec<InputError> {
    use InputError::*;
    let (first, second, step) = ("x", "y", "filter");
    let refused = || StepParameter {
        step,
        parameter: "f_max",
        found: 999_968.820_000_000_1,
        expected: word(),
        remedy: word(),
    };
    vec![
        NoComponent,
        ComponentTwice { first, second, channel: word(), path: path() },
        ComponentsDiffer { first, second, what: "step", first_value: word(), second_value: word() },
        StepUnfit { step, problem: word(), remedy: "leave it" },
        ProcessText { text: word(), problems: "key: wrong\n  help: mend it".into() },
        NotMatched { component: first, ratio: 0.5, period: 1.0, low: 0.9, high: 1.1, iterations: 30 },
        InProcess { place: "scene.toml:6 motion.process[1]".into(), source: Box::new(refused()) },
        refused(),
    ]
}

#[test]
fn every_refusal_ends_with_a_help_in_plain_numbers() {
    let all: Vec<InputError> =
        [of_files(), of_channels(), of_meshes(), of_motions()].into_iter().flatten().collect();
    let variants = include_str!("../error.rs").matches("    #[error(").count();
    assert_eq!(all.len(), variants, "each variant once");
    for error in all {
        let text = error.to_string();
        let (_, help) = text.split_once("\n  help: ").unwrap_or_else(|| panic!("no help: {text}"));
        assert!(!help.trim().is_empty() && !help.contains('\n'), "{text}");
        assert!(!text.contains("::"), "names the program's code: {text}");
        assert!(!text.split_whitespace().any(|word| word.len() > 60), "a number of many digits: {text}");
        assert!(!text.contains("999968.8200000001"), "{text}");
    }
}

#[test]
fn steps_are_told_in_the_digits_that_confirm_them() {
    let (path, channel) = (PathBuf::from("r.sac"), String::from("..A"));
    let dt = f64::from(0.6_f32);
    let text = InputError::StepImplausible {
        path: path.clone(),
        channel: channel.clone(),
        dt,
        low: 1e-4,
        high: 0.5,
    };
    let text = text.to_string();
    assert!(text.contains("is read as 0.6 s") && text.contains("--dt 0.6 (dt = 0.6 in a scene)"), "{text}");
    let text = InputError::StepMissing { path, channel, doubt: None, fits: None }.to_string();
    assert!(
        text.contains("no time step: the file holds values without times\n  help: give the step"),
        "{text}"
    );
}
