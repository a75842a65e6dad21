//! Scene files: every mistake is named with its line and key, and good scenes survive being written back.

mod mistakes;
mod process;
mod resolved;
mod schema;
mod validator;
mod volume;
mod volume_mistakes;

use std::fs;
use std::path::{Path, PathBuf};

use hati_inputs::motion::{Filter, Scaling};
use hati_inputs::scene::{self, Auto, Band, Component, Diagnostics, MotionKind, Process, Scene, Written};
use proptest::prelude::*;
use proptest::test_runner::FileFailurePersistence;

/// A scene that uses many keys and is right.
const GOOD: &str = r#"version = 1
title = "test"
accuracy = 5e-3

[motion]
kind = "within"
quantity = "acceleration"
process = [{ step = "filter", f_min = 0.2, order = 2 }, { step = "scale", factor = 2.0 }]
band = [0.2, 20.0]
# the components
[motion.x]
wavelet = { kind = "ricker", frequency = 5.0, amplitude = 1.0, time = 0.5, dt = 0.005, duration = 4.0 }
[motion.y]
wavelet = { kind = "sine_burst", frequency = 4.0, amplitude = 1.0, time = 1.5, dt = 0.005, duration = 4.0, cycles = 5 }

[soil]
reference_frequency = 2.0
[[soil.layer]]
name = "fill"
thickness = 5
vs = 150.0
nu = 0.3
rho = 1800.0
damping = 0.02
[[soil.layer]]
thickness = 10.0
vs = 250.0
vp = 550.0
rho = 1900.0
q = 25
q_p = 50
[soil.base]
kind = "elastic"
vs = 800.0
rho = 2200.0

[discretisation]
order = 6
elements = [2, 3]
dt = 1e-4
mechanisms = 3
tail = 5

[output]
stations = [ { name = "surface", depth = 0.0 }, { name = "mid", depth = 12.5 } ]
field_spacing = 0.5
"#;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

fn load(text: &str) -> Result<Scene, Diagnostics> {
    scene::load_str(text, "scene.toml", &[])
}

fn sets(pairs: &[(&str, &str)]) -> Vec<(String, String)> {
    pairs.iter().map(|(k, v)| ((*k).to_owned(), (*v).to_owned())).collect()
}

/// GOOD with one text put in place of another that has to be there.
fn with(old: &str, new: &str) -> String {
    assert!(GOOD.contains(old), "{old:?} is not in the scene");
    GOOD.replacen(old, new, 1)
}

/// Line of GOOD, counted from 1, that starts with `start`.
fn line_of(text: &str, start: &str) -> usize {
    1 + text
        .lines()
        .position(|l| l.starts_with(start))
        .unwrap_or_else(|| panic!("no line starts with {start:?}"))
}

/// The errors of a text as `line key: message | help`.
fn errors(text: &str) -> Vec<String> {
    match load(text) {
        Ok(_) => Vec::new(),
        Err(found) => found
            .errors()
            .map(|d| {
                let line = d.line.map_or("-".to_owned(), |l| l.to_string());
                let help = d.help.clone().unwrap_or_default();
                format!("{line} {}: {} | {help}", d.key_path, d.message)
            })
            .collect(),
    }
}

/// Asserts that a text has one error, which contains each of `parts`.
fn one_error(text: &str, parts: &[&str]) {
    let found = errors(text);
    assert_eq!(found.len(), 1, "expected one error, found {found:#?}\n{text}");
    for part in parts {
        assert!(found[0].contains(part), "{part:?} is not in {:?}", found[0]);
    }
}

fn warnings(text: &str) -> Vec<String> {
    match load(text) {
        Ok(scene) => scene.source.warnings.iter().map(ToString::to_string).collect(),
        Err(found) => panic!("{found}"),
    }
}

#[test]
fn a_good_scene_is_read_as_it_is_written() {
    let scene = load(GOOD).unwrap_or_else(|e| panic!("{e}"));
    assert!(scene.source.warnings.is_empty(), "{}", scene.source.warnings);
    assert_eq!(scene.title, "test");
    assert_eq!(scene.accuracy, 5e-3);
    assert_eq!(scene.motion().kind, MotionKind::Within);
    let filter = Filter { f_min: Some(0.2), order: 2, ..Filter::default() };
    assert_eq!(scene.motion().process, [Process::Filter(filter), Process::Scale(Scaling::Factor(2.0))]);
    assert_eq!(scene.motion().band, Band::Range([0.2, 20.0]));
    assert!(matches!(scene.motion().y, Some(Component::Synthetic(_))) && scene.motion().z.is_none());
    assert_eq!(scene.soil.reference_frequency, Auto::Value(2.0));
    assert_eq!(scene.discretisation.elements, Auto::Value(vec![2, 3]));
    let layers = scene.layers();
    assert_eq!((layers[0].name.as_str(), layers[1].name.as_str()), ("fill", "layer 2"));
    assert_eq!((layers[1].top, scene.depth()), (5.0, 15.0));
    assert_eq!((layers[1].damping, layers[1].damping_p, layers[0].damping_p), (0.02, 0.01, 0.02));
    assert!((layers[0].vp - 150.0 * 3.5f64.sqrt()).abs() < 1e-9);
    let base = scene.half_space().expect("an elastic base");
    assert_eq!(base.impedance()[0], 800.0 * 2200.0);
    assert!((base.vp - 800.0 * 3f64.sqrt()).abs() < 1e-9, "nu = 0.25 by default");
    assert_eq!(scene.source.written.get("soil.layer[2].vs"), Some(&Written::File(line_of(GOOD, "vs = 250"))));
    assert_eq!(scene.source.written.get("soil.layer[2].damping"), None);
}

/// The hand-written reader and serde take a right scene for the same thing.
#[test]
fn reader_and_serde_agree() {
    let mut texts = vec![GOOD.to_owned()];
    for name in ["site-response", "three-layer"] {
        texts.push(
            fs::read_to_string(root().join("scenes").join(name).join("scene.toml"))
                .expect("the scene is there"),
        );
    }
    for text in texts {
        let ours = load(&text).unwrap_or_else(|e| panic!("{e}"));
        let serdes: Scene = toml::from_str(&text).expect("serde reads the scene");
        assert_eq!(serde_json::to_value(&ours).expect("JSON"), serde_json::to_value(&serdes).expect("JSON"));
    }
}

#[test]
fn overrides_are_applied_and_checked() {
    let set = |pairs: &[(&str, &str)]| scene::load_str(GOOD, "scene.toml", &sets(pairs));
    let scene = set(&[
        ("accuracy", "1e-3"),
        ("soil.layer[2].vs", "300"),
        ("soil.layer[2].nu", "0.4"),
        ("soil.layer[1].q", "50"),
        ("motion.kind", "surface"),
        ("motion.band", "full"),
        ("motion.process[2].pga", "3.5"),
        ("output.stations[2]", "{ name = \"deep\", depth = 14 }"),
        ("discretisation.elements[1]", "7"),
    ])
    .unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(scene.accuracy, 1e-3);
    let layer = &scene.soil.layer[1];
    assert_eq!((layer.vs, layer.vp, layer.nu), (300.0, None, Some(0.4)), "nu takes the place of vp");
    assert_eq!(scene.soil.layer[0].damping_s(), 0.01);
    assert_eq!(scene.motion().kind, MotionKind::Surface);
    assert_eq!(scene.motion().band, Band::Full);
    assert_eq!(scene.motion().process[1], Process::Scale(Scaling::Pga(3.5)), "pga takes the place of factor");
    assert_eq!(scene.stations()[1].name, "deep");
    assert_eq!(scene.discretisation.elements, Auto::Value(vec![7, 3]));
    assert_eq!(scene.source.written.get("accuracy"), Some(&Written::Override));

    let refused = |pairs: &[(&str, &str)], expected: &[&str]| {
        let found = set(pairs).expect_err("refused");
        let lines: Vec<String> = found.iter().map(ToString::to_string).collect();
        assert_eq!(lines.len(), expected.len(), "{lines:#?}");
        for (line, expected) in lines.iter().zip(expected) {
            assert!(line.starts_with(expected), "{line:?} does not start with {expected:?}");
        }
    };
    refused(
        &[("soil.layer[3].vs", "300")],
        &["--set soil.layer[3].vs: there is no layer[3]: the list goes from layer[1] to layer[2]"],
    );
    refused(&[("soil.layer[0].vs", "300")], &["--set soil.layer[0].vs: there is no layer[0]"]);
    refused(&[("soil.layer.vs", "300")], &["--set soil.layer.vs: `layer` is a list"]);
    refused(&[("soil.lay[1].vs", "300")], &["--set soil.lay[1].vs: there is no list `lay`"]);
    refused(&[("acuracy", "1e-3")], &["--set acuracy: unknown key\n  help: did you mean `accuracy`?"]);
    refused(&[("accuracy", "[1")], &["--set accuracy: TOML syntax"]);
    refused(&[("accuracy", "")], &["--set accuracy: TOML syntax"]);
    refused(&[("a..b", "1")], &["--set a..b: \"a..b\" is not a key"]);
    refused(&[("soil.layer[2].vs", "600")], &["--set soil.layer[2].vs: 600 m/s is above vp/√2 = 389 m/s"]);
    refused(&[("soil.layer[1].vp", "400"), ("soil.layer[1].nu", "0.1"), ("accuracy", "7")], &["--set"; 2]);
}

#[test]
fn default_stations_are_the_layers_tops() {
    let text =
        with("stations = [ { name = \"surface\", depth = 0.0 }, { name = \"mid\", depth = 12.5 } ]\n", "");
    let stations = load(&text).unwrap_or_else(|e| panic!("{e}")).stations();
    let listed: Vec<(&str, f64)> = stations.iter().map(|s| (s.name.as_str(), s.depth)).collect();
    assert_eq!(listed, [("surface", 0.0), ("top of layer 2", 5.0), ("within", 15.0)]);
}

proptest! {
    #![proptest_config(ProptestConfig {
        failure_persistence: Some(Box::new(FileFailurePersistence::WithSource("proptest-regressions"))),
        ..ProptestConfig::default()
    })]

    /// Whatever is done to a scene's bytes, the answer is a scene or findings whose lines are in the file.
    #[test]
    fn mutations_never_panic(
        good in prop::sample::select(vec![GOOD, volume::BOX, volume::SECTION]),
        edits in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>(), 0u8..4), 1..12),
        cut in prop::option::of(any::<prop::sample::Index>()),
    ) {
        let mut bytes = good.as_bytes().to_vec();
        for (at, byte, how) in edits {
            let at = at.index(bytes.len());
            match how {
                0 => bytes[at] = byte,
                1 => bytes.insert(at, byte),
                2 if bytes.len() > 1 => { bytes.remove(at); }
                // A byte that means something to TOML.
                _ => bytes[at] = b"[]{}=.,\"'\n#-+e0"[usize::from(byte) % 15],
            }
        }
        if let Some(cut) = cut {
            bytes.truncate(cut.index(good.len()));
        }
        let text = String::from_utf8_lossy(&bytes);
        let lines = text.lines().count() + 1;
        match volume::load(&text) {
            Ok(scene) => {
                let again = scene::resolved_toml(&scene, &[]);
                prop_assert!(volume::load(&again).is_ok(), "{}", again);
                // What the reader takes, the schema takes.
                let value: serde_json::Value = toml::from_str(&text).expect("TOML");
                let schema = scene::schema();
                prop_assert_eq!(validator::violations(&schema, &value), Vec::<String>::new());
            }
            Err(found) => {
                prop_assert!(found.has_errors());
                prop_assert!(found.iter().all(|d| d.line.is_some_and(|l| l >= 1 && l <= lines)));
            }
        }
    }

    #[test]
    fn overrides_never_panic(key in "[a-z.\\[\\]0-9]{0,20}|soil\\.layer\\[[0-9]{1,25}\\]\\.[a-z]{1,3}|motion\\.(x|band|process\\[[12]\\])(\\.[a-z]{1,8})?", value in ".{0,20}") {
        if let Err(found) = scene::load_str(GOOD, "scene.toml", &[(key, value)]) {
            prop_assert!(found.has_errors());
        }
    }
}
