//! Scene files: every mistake is named with its line and key, and good scenes survive being written back.

use std::fs;
use std::path::{Path, PathBuf};

use hati_inputs::scene::{
    self, Auto, Band, Base, Component, Diagnostics, MotionKind, Offset, Resolved, Scale, Scene, Severity,
    Unit, Written,
};
use proptest::prelude::*;

/// A scene that uses many keys and is right.
const GOOD: &str = r#"version = 1
title = "test"
accuracy = 5e-3

[motion]
kind = "within"
quantity = "acceleration"
scale = { factor = 2.0 }
band = [0.2, 20.0]
offset = { first_seconds = 0.2 }
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
    assert_eq!(scene.motion.kind, MotionKind::Within);
    assert_eq!(scene.motion.scale, Some(Scale::Factor(2.0)));
    assert_eq!(scene.motion.band, Band::Range([0.2, 20.0]));
    assert_eq!(scene.motion.offset, Offset::First { first_seconds: 0.2 });
    assert!(matches!(scene.motion.y, Some(Component::Synthetic(_))) && scene.motion.z.is_none());
    assert_eq!(scene.soil.reference_frequency, Auto::Value(2.0));
    assert_eq!(scene.discretisation.elements, Auto::Value(vec![2, 3]));
    let layers = scene.layers();
    assert_eq!((layers[0].name.as_str(), layers[1].name.as_str()), ("fill", "layer 2"));
    assert_eq!((layers[1].top, scene.depth()), (5.0, 15.0));
    assert_eq!((layers[1].damping, layers[1].damping_p, layers[0].damping_p), (0.02, 0.01, 0.02));
    assert!((layers[0].vp - 150.0 * 3.5f64.sqrt()).abs() < 1e-9);
    let base = scene.soil.base.half_space().expect("an elastic base");
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
fn five_mistakes_give_five_messages() {
    let text = with("accuracy = 5e-3", "accuracy = 0.5")
        .replace("kind = \"within\"", "kind = \"outcrops\"")
        .replace("thickness = 5\n", "thicknes = 5\n")
        .replace("vp = 550.0", "vp = 300.0")
        .replace("depth = 12.5", "depth = \"12.5\"");
    let found = load(&text).expect_err("five mistakes");
    // A misspelt key is one finding, not an unknown key and a missing one.
    let expected = r#"scene.toml:3 accuracy: expected a number above 1e-6 and of at most 0.3, found 0.5
scene.toml:6 motion.kind: expected "outcrop", "within" or "surface", found "outcrops"
  help: did you mean "outcrop"?
scene.toml:20 soil.layer[1].thicknes: unknown key
  help: did you mean `thickness`?
scene.toml:27 soil.layer[2].vs: 250 m/s is above vp/√2 = 212 m/s (Poisson's ratio would be negative)
  help: raise vp or lower vs, or give nu instead of vp
scene.toml:45 output.stations[2].depth: expected a number of at least 0 m, found the string "12.5"
  help: take the quotes off"#;
    assert_eq!(found.to_string(), expected);
    assert!(found.iter().all(|d| d.severity == Severity::Error && d.column.is_some()));
}

#[test]
fn the_example_of_the_style_guide() {
    let text = with("vs = 250.0\nvp = 550.0", "vs = 1200.0\nvp = 1100.0");
    let found = load(&text).expect_err("vs above vp");
    assert_eq!(
        found.to_string(),
        "scene.toml:27 soil.layer[2].vs: 1200 m/s is above vp/√2 = 778 m/s (Poisson's ratio would be negative)\n  \
         help: raise vp or lower vs, or give nu instead of vp"
    );
    let text = with("vs = 250.0\nvp = 550.0", "vs = 550.0\nvp = 250.0");
    one_error(&text, &["177 m/s", "swap vp and vs"]);
}

#[test]
fn syntax_errors_do_not_hide_the_rest() {
    let text = with("vs = 150.0", "vs = 15O.0")
        .replace("kind = \"elastic\"", "kind = elastic")
        .replace("accuracy = 5e-3", "accuracy = 1e-7")
        .replace("rho = 1900.0", "rho = -1900.0");
    let found = errors(&text);
    assert_eq!(found.len(), 4, "{found:#?}");
    assert!(found[0].starts_with("3 accuracy: expected"), "{}", found[0]);
    assert!(found[1].starts_with("21 soil.layer[1].vs: TOML syntax: invalid float"), "{}", found[1]);
    assert!(found[2].starts_with("29 soil.layer[2].rho: expected a number above 0 kg/m³"), "{}", found[2]);
    assert!(found[3].starts_with("33 soil.base.kind: TOML syntax"), "{}", found[3]);
    assert!(found[3].contains("\"elastic\""), "{}", found[3]);
    // A second table of the same name, an open bracket, an open string.
    one_error(&format!("{GOOD}[motion]\n"), &["duplicate key"]);
    assert!(errors(&with("[soil.base]", "[soil.base")).iter().any(|e| e.contains("TOML syntax")));
    assert!(
        errors(&with("\"fill\"", "\"fill"))
            .iter()
            .any(|e| e.starts_with("19 soil.layer[1].name: TOML syntax"))
    );
}

/// Each single mistake: what to change in the good scene, and what its one message must say.
#[test]
fn single_mistakes() {
    let cases: &[(&str, &str, &[&str])] = &[
        ("version = 1\n", "\n", &["1 version: missing", "version = 1"]),
        ("version = 1\n", "version = 2\n", &["1 version: this program reads version 1, found 2"]),
        ("title = \"test\"", "title = 3", &["2 title: expected a text"]),
        ("5e-3", "1e-6", &["3 accuracy: ", "above 1e-6"]),
        ("5e-3", "nan", &["3 accuracy: ", "found NaN"]),
        (
            "quantity = \"acceleration\"",
            "quantity = \"accelaration\"",
            &["7 motion.quantity", "did you mean \"acceleration\"?"],
        ),
        ("{ factor = 2.0 }", "2.0", &["8 motion.scale: expected a table", "{ factor = … }"]),
        ("{ factor = 2.0 }", "{ factor = 2.0, pga = 1.0 }", &["8 motion.scale.pga: `factor` is given too"]),
        ("{ factor = 2.0 }", "{ factor = 0 }", &["8 motion.scale.factor: the factor is 0"]),
        ("{ factor = 2.0 }", "{ pga = -1 }", &["8 motion.scale.pga: expected a number above 0 m/s²"]),
        ("{ factor = 2.0 }", "{}", &["8 motion.scale: expected `factor` or `pga`"]),
        ("[0.2, 20.0]", "[20.0, 0.2]", &["9 motion.band: f_min = 20 Hz is not below f_max = 0.2 Hz"]),
        ("[0.2, 20.0]", "[0, 20.0]", &["9 motion.band[1]: expected a number above 0 Hz"]),
        ("[0.2, 20.0]", "[1, 2, 3]", &["9 motion.band: expected two frequencies", "list of 3"]),
        (
            "[0.2, 20.0]",
            "[0.2, 101]",
            &["9 motion.band: f_max = 101 Hz is above the Nyquist frequency 100 Hz"],
        ),
        ("[0.2, 20.0]", "\"ful\"", &["9 motion.band", "did you mean \"full\"?"]),
        ("{ first_seconds = 0.2 }", "\"median\"", &["10 motion.offset: expected \"mean\" or \"none\""]),
        (
            "{ first_seconds = 0.2 }",
            "{ first_second = 0.2 }",
            &["10 motion.offset.first_second: unknown key", "`first_seconds`"],
        ),
        (
            "frequency = 5.0",
            "frequency = 80.0",
            &["motion.x.wavelet.frequency: 80 Hz is not below 0.4/dt = 80 Hz"],
        ),
        ("time = 0.5", "time = 4.5", &["motion.x.wavelet.time: the pulse at 4.5 s comes after"]),
        (
            "dt = 0.005",
            "dt = 0.004",
            &["motion.y.wavelet.dt: 0.005 s differs from motion.x.wavelet.dt = 0.004 s"],
        ),
        ("duration = 4.0", "duration = 1e9", &["motion.x.wavelet.duration: duration/dt = 2e11 samples"]),
        (", cycles = 5", "", &["motion.y.wavelet.cycles: missing"]),
        (
            "duration = 4.0 }",
            "duration = 4.0, cycles = 3 }",
            &["motion.x.wavelet.cycles: a ricker pulse has no cycles"],
        ),
        ("kind = \"ricker\"", "kind = \"rickre\"", &["motion.x.wavelet.kind", "did you mean \"ricker\"?"]),
        ("[motion.x]\n", "[motion.x]\nunit = \"g\"\n", &["12 motion.x.unit: belongs to a file"]),
        ("[motion.x]\n", "[motion.x]\nfile = \"obspy:a\"\n", &["13 motion.x.wavelet: `file` is given too"]),
        (
            "reference_frequency = 2.0",
            "reference_frequency = \"aut\"",
            &["17 soil.reference_frequency", "did you mean \"auto\"?"],
        ),
        (
            "reference_frequency = 2.0",
            "reference_frequency = -2",
            &["17 soil.reference_frequency: expected a number above 0 Hz, found -2 Hz"],
        ),
        (
            "thickness = 5\n",
            "thickness = 0\n",
            &["20 soil.layer[1].thickness: expected a number above 0 m, found 0 m"],
        ),
        ("thickness = 5\n", "thickness = inf\n", &["20 soil.layer[1].thickness", "found inf"]),
        ("thickness = 10.0\n", "", &["25 soil.layer[2].thickness: missing"]),
        ("vs = 150.0", "vs = 0", &["21 soil.layer[1].vs: expected a number above 0 m/s"]),
        ("nu = 0.3", "nu = 0.5", &["22 soil.layer[1].nu", "of at least 0 and below 0.5, found 0.5"]),
        ("nu = 0.3", "nu = -0.1", &["22 soil.layer[1].nu"]),
        ("nu = 0.3", "nu = 0.3\nvp = 400.0", &["23 soil.layer[1].vp: `nu` is given too"]),
        (
            "rho = 1800.0",
            "rho = [1800.0]",
            &["23 soil.layer[1].rho: expected a number above 0 kg/m³, found a list"],
        ),
        ("damping = 0.02", "damping = 2", &["24 soil.layer[1].damping", "2 % is 0.02"]),
        ("damping = 0.02", "damping = 0.02\nq = 25", &["25 soil.layer[1].q: `damping` is given too"]),
        ("q = 25", "q = 1", &["30 soil.layer[2].q"]),
        ("q_p = 50", "q_p = 50\ndamping_p = 0.01", &["32 soil.layer[2].damping_p: `q_p` is given too"]),
        ("kind = \"elastic\"", "kind = \"elastc\"", &["33 soil.base.kind", "did you mean \"elastic\"?"]),
        (
            "kind = \"elastic\"\nvs = 800.0\nrho = 2200.0",
            "kind = \"rigid\"\nvs = 800.0",
            &["34 soil.base.vs: a rigid base has no such key"],
        ),
        ("vs = 800.0", "Vs = 800.0", &["34 soil.base.Vs: unknown key", "`vs`"]),
        (
            "rho = 2200.0",
            "rho = 2200.0\ndamping = 0.01",
            &["36 soil.base.damping: an elastic base has no such key"],
        ),
        (
            "order = 6",
            "order = 11",
            &["38 discretisation.order: expected a whole number from 1 to 10, found 11"],
        ),
        (
            "order = 6",
            "order = 6.0",
            &["38 discretisation.order: expected a whole number from 1 to 10, found the number 6"],
        ),
        ("[2, 3]", "[2, 3, 4]", &["39 discretisation.elements: 3 counts for 2 layers"]),
        ("[2, 3]", "[2, 0]", &["39 discretisation.elements[2]: expected a whole number from 1"]),
        (
            "[2, 3]",
            "4",
            &["39 discretisation.elements: expected \"auto\" or a list with one count per layer"],
        ),
        ("dt = 1e-4", "dt = 0", &["40 discretisation.dt: expected a number above 0 s"]),
        ("mechanisms = 3", "mechanisms = 9", &["41 discretisation.mechanisms"]),
        ("tail = 5", "tail = -1", &["42 discretisation.tail"]),
        (
            "depth = 12.5",
            "depth = 15.5",
            &["45 output.stations[2].depth: 15.5 m is below the column, which ends at 15 m"],
        ),
        ("depth = 12.5", "depth = -1", &["45 output.stations[2].depth: expected a number of at least 0 m"]),
        ("\"mid\"", "\"surface\"", &["45 output.stations[2].name: "]),
        ("\"mid\"", "\"outcrop\"", &["45 output.stations[2].name: `outcrop` names the input"]),
        (
            "field_spacing = 0.5",
            "field_spacing = \"non\"",
            &["46 output.field_spacing", "did you mean \"none\"?"],
        ),
        ("[output]", "[ouput]", &["44 ouput: unknown key", "`output`"]),
    ];
    for (old, new, parts) in cases {
        if old == &"\"mid\"" && new == &"\"surface\"" {
            // Two stations of one name, and a depth that the name `surface` does not have.
            let found = errors(&with(old, new));
            assert!(found.iter().any(|e| e.contains("is the name of station 1 already")), "{found:#?}");
            continue;
        }
        one_error(&with(old, new), parts);
    }
}

#[test]
fn whole_sections_missing() {
    let found = errors("");
    assert_eq!(found.len(), 3, "{found:#?}");
    for (found, key) in found.iter().zip(["1 version", "1 motion", "1 soil"]) {
        assert!(found.starts_with(&format!("{key}: missing")), "{found}");
    }
    let found = errors("version = 1\n[motion]\nkind = \"within\"\n[soil]\nlayer = []\n");
    assert_eq!(found.len(), 3, "{found:#?}");
    assert!(found[0].starts_with("2 motion.x: missing | give at least one component"), "{}", found[0]);
    assert!(found[1].starts_with("4 soil.base: missing"), "{}", found[1]);
    assert!(found[2].starts_with("5 soil.layer: there is no layer"), "{}", found[2]);
    let one_bracket = with("[[soil.layer]]\nname", "[soil.layer]\nname").replace("[[soil.layer]]", "[later]");
    assert!(
        errors(&one_bracket).iter().any(|e| e.starts_with("18 soil.layer: ") && e.contains("two brackets"))
    );
}

#[test]
fn motion_against_base() {
    let rigid = with("kind = \"elastic\"\nvs = 800.0\nrho = 2200.0", "kind = \"rigid\"");
    assert!(warnings(&rigid).is_empty());
    one_error(
        &rigid.replace("kind = \"within\"", "kind = \"outcrop\""),
        &["6 motion.kind: an outcrop motion has no meaning over a rigid base", "\"within\""],
    );
    let undamped = rigid.replace("damping = 0.02\n", "").replace("q = 25\nq_p = 50\n", "");
    let found = warnings(&undamped);
    assert_eq!(found.len(), 1, "{found:#?}");
    assert!(found[0].starts_with("scene.toml:29 soil.base: warning: no layer is damped"), "{}", found[0]);
    one_error(
        &undamped.replace("kind = \"within\"", "kind = \"surface\""),
        &["6 motion.kind: a surface motion over a rigid base without damping"],
    );
    assert!(load(&rigid.replace("kind = \"within\"", "kind = \"surface\"")).is_ok());
}

#[test]
fn warnings_do_not_forbid_a_run() {
    let cases = [
        ("rho = 1800.0", "rho = 1.8", "soil.layer[1].rho: warning: 1.8 kg/m³ is unusual"),
        ("vs = 150.0", "vs = 9.0", "soil.layer[1].vs: warning: 9 m/s is unusual"),
        ("q_p = 50", "q_p = 5000", "soil.layer[2].q_p: warning: a P-wave damping of 0.0001"),
        ("time = 0.5", "time = 0.1", "motion.x.wavelet.time: warning: the motion cuts the pulse"),
        (
            "frequency = 5.0",
            "frequency = 40.0",
            "motion.x.wavelet.dt: warning: the spectrum of a Ricker pulse",
        ),
        ("{ factor = 2.0 }", "{ pga = 200 }", "motion.scale.pga: warning: 200 m/s²"),
    ];
    for (old, new, part) in cases {
        let found = warnings(&with(old, new));
        assert_eq!(found.len(), 1, "{found:#?}");
        assert!(found[0].contains(part), "{part:?} is not in {:?}", found[0]);
    }
}

#[test]
#[allow(clippy::print_stderr, reason = "a test says what it skipped")]
fn records_are_looked_for_beside_the_scene() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("scene.toml");
    let records = folder.path().join("records");
    fs::create_dir(&records).expect("a folder");
    fs::write(records.join("station.EW"), "data").expect("a file");
    fs::write(records.join("empty.EW"), "").expect("a file");
    let wavelets = GOOD.find("[motion.x]").expect("x")..GOOD.find("[soil]").expect("soil");
    let load_file = |file: &str, more: &str| {
        let mut text = GOOD.to_owned();
        text.replace_range(wavelets.clone(), &format!("[motion.z]\nfile = {file:?}\n{more}\n"));
        fs::write(&path, text).expect("a file");
        scene::load(&path)
    };
    let refused = |file: &str, more: &str, parts: &[&str]| {
        let found = load_file(file, more).expect_err(file);
        assert_eq!(found.len(), 1, "{found}");
        let text = found.to_string();
        for part in parts {
            assert!(text.contains(part), "{part:?} is not in {text:?}");
        }
    };
    let scene =
        load_file("records/station.EW", "unit = \"g\"\nchannel = \"EW\"").unwrap_or_else(|e| panic!("{e}"));
    let Some(Component::Record(record)) = &scene.motion.z else {
        panic!("z is a record");
    };
    assert_eq!((record.unit, record.channel.as_deref()), (Some(Unit::G), Some("EW")));
    assert_eq!(scene.record_path(record), records.join("station.EW"));
    // The folder of the scene stands for its scene.toml.
    assert!(scene::load(folder.path()).is_ok());

    let here = records.display().to_string();
    refused(
        "records/stations.EW",
        "",
        &["scene.toml:12 motion.z.file: there is no file stations.EW in the folder", &here, "station.EW"],
    );
    refused("nowhere/station.EW", "", &["there is no folder", "nowhere"]);
    refused("records", "", &["is a folder, expected a file", "station.EW"]);
    refused("records/empty.EW", "", &["is empty (0 bytes)"]);
    refused("records/*.EW", "", &["holds a wildcard"]);
    refused("https://example.org/station.EW", "", &["is a URL"]);
    refused("~/station.EW", "", &["\"~\" is not expanded"]);
    refused("", "", &["motion.z.file: expected a text, found an empty one"]);
    refused("obspy:../../../etc/passwd", "", &["does not name a file inside the ObsPy package"]);
    refused(
        "records/station.EW",
        "unit = \"cm/s\"",
        &["scene.toml:13 motion.z.unit: cm/s is a unit of velocity, but motion.quantity is acceleration"],
    );
    refused("records/station.EW", "unit = \"gals\"", &["did you mean \"gal\"?"]);
    assert!(load_file("obspy:io/nied/tests/data/test.knet", "").is_ok());

    let unreadable = records.join("locked.EW");
    fs::write(&unreadable, "data").expect("a file");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        fs::set_permissions(&unreadable, fs::Permissions::from_mode(0o000)).expect("permissions");
    }
    if fs::File::open(&unreadable).is_err() {
        refused("records/locked.EW", "", &["cannot be read", "permissions"]);
    } else {
        eprintln!("skipped: this user may read every file, so an unreadable one cannot be made");
    }
}

#[test]
fn scene_files_that_cannot_be_read() {
    let folder = tempfile::tempdir().expect("a folder");
    let message = |path: &Path| scene::load(path).expect_err("no scene").to_string();
    fs::write(folder.path().join("scene.toml"), [b'a', b'\n', 0xff]).expect("a file");
    assert!(message(folder.path()).contains("line 2 holds a byte that is not UTF-8"));
    let missing = message(&folder.path().join("scenes.toml"));
    assert!(
        missing.contains("there is no file scenes.toml") && missing.contains("near names there: scene.toml"),
        "{missing}"
    );
    fs::remove_file(folder.path().join("scene.toml")).expect("removed");
    assert!(message(folder.path()).contains("is a folder, expected a file"));
    let large = folder.path().join("large.toml");
    fs::write(&large, vec![b'#'; 5 << 20]).expect("a file");
    assert!(message(&large).contains("too many for a scene"));
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
        ("motion.scale.pga", "3.5"),
        ("output.stations[2]", "{ name = \"deep\", depth = 14 }"),
        ("discretisation.elements[1]", "7"),
    ])
    .unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(scene.accuracy, 1e-3);
    let layer = &scene.soil.layer[1];
    assert_eq!((layer.vs, layer.vp, layer.nu), (300.0, None, Some(0.4)), "nu takes the place of vp");
    assert_eq!(scene.soil.layer[0].damping_s(), 0.01);
    assert_eq!(scene.motion.kind, MotionKind::Surface);
    assert_eq!(scene.motion.band, Band::Full);
    assert_eq!(scene.motion.scale, Some(Scale::Pga(3.5)));
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

#[test]
fn example_scenes_load_and_fit_the_schema() {
    let validator = jsonschema::validator_for(&scene::schema()).expect("the schema is a schema");
    for name in ["site-response", "three-layer"] {
        let path = root().join("scenes").join(name).join("scene.toml");
        let scene = scene::load(&path).unwrap_or_else(|e| panic!("{e}"));
        assert!(scene.source.warnings.is_empty(), "{}", scene.source.warnings);
        assert!(matches!(scene.soil.base, Base::Elastic { .. }));
        let text = fs::read_to_string(&path).expect("the scene is there");
        let value: serde_json::Value = toml::from_str(&text).expect("TOML");
        let found: Vec<String> = validator.iter_errors(&value).map(|e| e.to_string()).collect();
        assert!(found.is_empty(), "{name}: {found:#?}");
    }
    let value: serde_json::Value = toml::from_str(GOOD).expect("TOML");
    assert!(validator.is_valid(&value));
    for (old, new) in [
        ("order = 6", "order = 11"),
        ("nu = 0.3", "nu = 0.5"),
        ("name = \"fill\"", "nam = \"fill\""),
        ("\"within\"", "\"inside\""),
    ] {
        let value: serde_json::Value = toml::from_str(&with(old, new)).expect("TOML");
        assert!(!validator.is_valid(&value), "{new}");
    }
}

/// Every range of the schema is the reader's: just outside is refused, the limit itself is as the schema says.
#[test]
fn ranges_of_schema_and_reader_agree() {
    let schema = scene::schema();
    let places: &[(&str, &str, &str)] = &[
        ("/properties", "", "accuracy"),
        ("/$defs/Soil/properties", "soil", "reference_frequency"),
        ("/$defs/Layer/properties", "soil.layer[1]", "thickness vs vp nu rho damping q damping_p q_p"),
        ("/$defs/Base/oneOf/0/properties", "soil.base", "vs rho nu vp"),
        ("/$defs/Discretisation/properties", "discretisation", "order dt mechanisms tail"),
        ("/$defs/Output/properties", "output", "field_spacing"),
        ("/$defs/Station/properties", "output.stations[2]", "depth"),
        ("/$defs/Wavelet/properties", "motion.y.wavelet", "frequency time dt duration cycles"),
    ];
    let mut checked = 0;
    for (pointer, section, keys) in places {
        for key in keys.split(' ') {
            let definition =
                schema.pointer(&format!("{pointer}/{key}")).unwrap_or_else(|| panic!("{pointer}/{key}"));
            for (word, step, inside) in [
                ("minimum", -1.0, true),
                ("exclusiveMinimum", -1.0, false),
                ("maximum", 1.0, true),
                ("exclusiveMaximum", 1.0, false),
            ] {
                let Some(limit) = definition.get(word).and_then(serde_json::Value::as_f64) else {
                    continue;
                };
                let whole = ["order", "mechanisms"].contains(&key);
                let path = if section.is_empty() { key.to_owned() } else { format!("{section}.{key}") };
                let refused = |x: f64| {
                    let value = if whole { format!("{x:.0}") } else { format!("{x:e}") };
                    match scene::load_str(GOOD, "scene.toml", &sets(&[(&path, &value)])) {
                        Ok(_) => false,
                        // Only a refusal of this value counts, not one of what it does elsewhere.
                        Err(found) => {
                            found.iter().any(|d| d.key_path == path && d.message.starts_with("expected a"))
                        }
                    }
                };
                let beyond = if whole { limit + step } else { limit + step * 1e-7 };
                assert!(refused(beyond), "{path} = {beyond} has to be refused ({word} {limit})");
                assert_eq!(refused(limit), !inside, "{path} = {limit} ({word})");
                checked += 1;
            }
        }
    }
    assert!(checked >= 30, "{checked} limits");
}

/// All keys of the schema are keys of the reader.
#[test]
fn the_reader_knows_every_key_of_the_schema() {
    let schema = scene::schema();
    let places = [
        ("/properties", ""),
        ("/$defs/Motion/properties", "motion."),
        ("/$defs/RecordFile/properties", "motion.x."),
        ("/$defs/Synthetic/properties", "motion.x."),
        ("/$defs/Wavelet/properties", "motion.x.wavelet."),
        ("/$defs/Soil/properties", "soil."),
        ("/$defs/Layer/properties", "soil.layer[1]."),
        ("/$defs/Base/oneOf/0/properties", "soil.base."),
        ("/$defs/Discretisation/properties", "discretisation."),
        ("/$defs/Output/properties", "output."),
        ("/$defs/Station/properties", "output.stations[1]."),
    ];
    for (pointer, section) in places {
        let keys = schema
            .pointer(pointer)
            .and_then(serde_json::Value::as_object)
            .unwrap_or_else(|| panic!("{pointer}"));
        for key in keys.keys() {
            let path = format!("{section}{key}");
            // A date is no value of any key, so a known key complains about its type and an unknown one is unknown.
            let found =
                scene::load_str(GOOD, "scene.toml", &sets(&[(&path, "1979-05-27")])).expect_err("a date");
            assert!(
                found.iter().any(|d| d.key_path == path && d.message.contains("found the date")),
                "{path}: {found}"
            );
        }
    }
}

#[test]
fn the_reference_page_names_every_key_with_its_unit() {
    let page = scene::reference_markdown();
    for part in [
        "| `accuracy` | number, above 1e-6, at most 0.3 | `0.01` |",
        "## `[motion]`",
        "## `[motion.x]`, `[motion.y]`, `[motion.z]`",
        "## `[motion.x.wavelet]`",
        "## `[[soil.layer]]`",
        "| `thickness` | number, m, above 0 | required |",
        "| `kind` | `\"elastic\"` or `\"rigid\"` | required |",
        "| `order` | `\"auto\"` or whole number, from 1 to 10 | `\"auto\"` |",
        "## `[[output.stations]]`",
        "`\"rigid\"`: A rigid base that follows the motion",
    ] {
        assert!(page.contains(part), "{part:?} is not in\n{page}");
    }
    let columns = |line: &str| line.replace("\\|", "").matches('|').count();
    for line in page.lines().filter(|l| l.starts_with('|')) {
        assert_eq!(columns(line), 5, "{line}");
    }
    assert!(!page.contains("null"), "TOML has no null");
}

#[test]
fn a_resolved_scene_loads_again_as_the_same_run() {
    let resolved = [
        Resolved {
            key: "discretisation.order".into(),
            value: 5.into(),
            why: "cheapest of 2 to 10 at the accuracy asked\n(not a second line)".into(),
        },
        Resolved {
            key: "discretisation.elements".into(),
            value: vec![1i64, 2, 3].into(),
            why: "a wavelength at 15 Hz".into(),
        },
        Resolved { key: "motion.band".into(), value: vec![0.5, 15.25].into(), why: "energy".into() },
        Resolved { key: "soil.layer[1].vp".into(), value: 259.8.into(), why: "from nu".into() },
    ];
    let path = root().join("scenes/three-layer/scene.toml");
    let overrides = sets(&[("soil.layer[2].vs", "260")]);
    let scene = scene::load_with(&path, &overrides).unwrap_or_else(|e| panic!("{e}"));
    let text = scene::resolved_toml(&scene, &resolved);
    for line in [
        "title = \"Three layers under a Ricker pulse\" # user",
        "vs = 260 # user (--set)",
        "offset = \"mean\" # default",
        "nu = 0.25 # default",
        "tail = \"auto\" # default",
        "band = [0.5, 15.25] # auto: energy",
        "order = 5 # auto: cheapest of 2 to 10 at the accuracy asked (not a second line)",
        "# soil.layer[1].vp = 259.8 (from nu)",
    ] {
        let line = line.replace("vs = 260 ", "vs = 260.0 ");
        assert!(text.lines().any(|l| l == line), "{line:?} is not in\n{text}");
    }
    let again = scene::load_str(&text, "elsewhere/scene.resolved.toml", &[])
        .unwrap_or_else(|e| panic!("{e}\n{text}"));
    assert_eq!(again.layers(), scene.layers());
    assert_eq!(again.stations(), scene.stations());
    assert_eq!(again.soil.base.half_space(), scene.soil.base.half_space());
    assert_eq!((again.accuracy, &again.title), (scene.accuracy, &scene.title));
    assert_eq!(again.motion.x, scene.motion.x);
    assert_eq!(again.motion.band, Band::Range([0.5, 15.25]));
    assert_eq!(again.discretisation.order, Auto::Value(5));
    assert_eq!(again.discretisation.elements, Auto::Value(vec![1, 2, 3]));
    assert_eq!(again.discretisation.tail, Auto::Auto);
    // Written back once more, only the provenance changes.
    let strip = |text: &str| -> Vec<String> {
        text.lines()
            .filter(|l| !l.starts_with('#') && !l.is_empty())
            .map(|l| l.split(" # ").next().unwrap_or_default().to_owned())
            .collect()
    };
    assert_eq!(strip(&scene::resolved_toml(&again, &[])), strip(&text));
}

#[test]
fn a_resolved_scene_finds_its_records_from_another_folder() {
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join("a b#\"c.EW"), "data").expect("a file");
    let wavelets = GOOD.find("[motion.x]").expect("x")..GOOD.find("[soil]").expect("soil");
    let mut text = GOOD.to_owned();
    text.replace_range(
        wavelets,
        "[motion.x]\nfile = 'a b#\"c.EW'\n[motion.y]\nfile = \"obspy:io/x.knet\"\nunit = \"g\"\n",
    );
    let path = folder.path().join("scene.toml");
    fs::write(&path, text).expect("a file");
    let scene = scene::load(&path).unwrap_or_else(|e| panic!("{e}"));
    let resolved = scene::resolved_toml(&scene, &[]);
    let again = scene::load_str(&resolved, "run/scene.resolved.toml", &[])
        .unwrap_or_else(|e| panic!("{e}\n{resolved}"));
    let (Some(Component::Record(a)), Some(Component::Record(b))) = (&scene.motion.x, &again.motion.x) else {
        panic!("records");
    };
    assert_eq!(scene.record_path(a), again.record_path(b));
    assert_eq!(scene.motion.y, again.motion.y);
    assert_eq!(scene.motion.scale, again.motion.scale);
    assert_eq!(scene.layers(), again.layers());
    assert_eq!(scene.discretisation, again.discretisation);
}

/// Text that nests deeper than any stack is refused, not followed.
#[test]
fn deep_nesting_is_refused() {
    for text in [
        format!("{}=1", vec!["a"; 100_000].join(".")),
        format!("a={}", "[".repeat(100_000)),
        format!("a={}", "{a=".repeat(100_000)),
        format!("[{}]", vec!["a"; 100_000].join(".")),
    ] {
        assert!(errors(&text).iter().any(|e| e.contains("recurs")));
    }
    let key = vec!["a"; 100_000].join(".");
    let found = scene::load_str(GOOD, "scene.toml", &sets(&[(&key, "1")])).expect_err("a key too deep");
    assert!(found.to_string().contains("deep"), "{found}");
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 512, failure_persistence: None, ..ProptestConfig::default() })]

    /// Whatever is done to a scene's bytes, the answer is a scene or findings whose lines are in the file.
    #[test]
    fn mutations_never_panic(
        edits in prop::collection::vec((0usize..GOOD.len(), any::<u8>(), 0u8..4), 1..12),
        cut in prop::option::of(0usize..GOOD.len()),
    ) {
        let mut bytes = GOOD.as_bytes().to_vec();
        for (at, byte, how) in edits {
            let at = at.min(bytes.len().saturating_sub(1));
            match how {
                0 => bytes[at] = byte,
                1 => bytes.insert(at, byte),
                2 if bytes.len() > 1 => { bytes.remove(at); }
                // A byte that means something to TOML.
                _ => bytes[at] = b"[]{}=.,\"'\n#-+e0"[usize::from(byte) % 15],
            }
        }
        if let Some(cut) = cut {
            bytes.truncate(cut);
        }
        let text = String::from_utf8_lossy(&bytes);
        let lines = text.lines().count() + 1;
        match load(&text) {
            Ok(scene) => {
                let again = scene::resolved_toml(&scene, &[]);
                prop_assert!(load(&again).is_ok(), "{}", again);
            }
            Err(found) => {
                prop_assert!(found.has_errors());
                prop_assert!(found.iter().all(|d| d.line.is_some_and(|l| l >= 1 && l <= lines)));
            }
        }
    }

    #[test]
    fn overrides_never_panic(key in "[a-z.\\[\\]0-9]{0,20}|soil\\.layer\\[[0-9]{1,25}\\]\\.[a-z]{1,3}|motion\\.(x|band|scale)(\\.[a-z]{1,8})?", value in ".{0,20}") {
        if let Err(found) = scene::load_str(GOOD, "scene.toml", &[(key, value)]) {
            prop_assert!(found.has_errors());
        }
    }
}
