//! What is wrong is said at once, with its place and what to do.

use std::fs;
use std::path::Path;

use hati_inputs::scene::{self, Component, ResponseMode, Severity, Unit};

use super::{GOOD, errors, load, one_error, sets, warnings, with};

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
    assert!(
        found[2].starts_with("29 soil.layer[2].rho: expected a number of at least 0.001"),
        "{}",
        found[2]
    );
    assert!(found[3].starts_with("33 soil.base.kind: TOML syntax"), "{}", found[3]);
    assert!(found[3].contains("\"elastic\""), "{}", found[3]);
    one_error(&with("vs = 150.0", "vs = 150 m/s"), &["21 soil.layer[1].vs: TOML syntax", "without its unit"]);
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
        ("factor = 2.0", "factor = 2.0, pga = 1.0", &["8 motion.process[2].pga: `factor` given too"]),
        ("factor = 2.0", "factor = 0", &["8 motion.process[2].factor: the factor is 0"]),
        ("factor = 2.0", "pga = -1", &["8 motion.process[2].pga: expected a number above 0 m/s²"]),
        (", factor = 2.0", "", &["8 motion.process[2]: expected `factor`, `pga`, `pgv` or `sa`"]),
        ("factor = 2.0", "sa = 2.0", &["8 motion.process[2].period: missing"]),
        ("factor = 2.0", "pgv = 2.0, damping = 0.1", &["8 motion.process[2].damping: belongs to `sa`"]),
        (
            "\"scale\"",
            "\"scael\"",
            &["8 motion.process[2].step: expected \"demean\"", "did you mean \"scale\"?"],
        ),
        ("step = \"scale\", ", "", &["8 motion.process[2]: the step's name is missing", "\"convert\""]),
        (
            "{ step = \"scale\", factor = 2.0 }",
            "\"demean\"",
            &["8 motion.process[2]: expected a table with a step"],
        ),
        (
            "[{ step = \"filter\", f_min = 0.2, order = 2 }, { step = \"scale\", factor = 2.0 }]",
            "\"demean\"",
            &["8 motion.process: expected a list of steps", "process = [{ step = \"demean\" }"],
        ),
        ("f_min = 0.2", "f_mni = 0.2, f_max = 3", &["8 motion.process[1].f_mni: unknown key", "`f_min`"]),
        (
            "f_min = 0.2",
            "f_min = 5, f_max = 3",
            &["8 motion.process[1].f_max: 3 Hz is not above f_min = 5 Hz"],
        ),
        ("f_min = 0.2, ", "", &["8 motion.process[1]: expected `f_min`, `f_max` or both"]),
        (
            "order = 2",
            "causal = 1",
            &["8 motion.process[1].causal: expected true or false, found the number 1"],
        ),
        (
            "step = \"scale\", factor = 2.0",
            "step = \"match\", spectrum = { kind = \"points\", periods = [0.1, 0.2] }",
            &["8 motion.process[2].spectrum.psa: missing", "m/s² for each period"],
        ),
        (
            "step = \"scale\", factor = 2.0",
            "step = \"match\", spectrum = { kind = \"points\", periods = [0.2, 0.1], psa = [1.0, 1.0] }",
            &["8 motion.process[2].spectrum: ", "a period above 0.2 s", "sort the points"],
        ),
        (
            "step = \"scale\", factor = 2.0",
            "step = \"match\", spectrum = { kind = \"rg160\" }",
            &["8 motion.process[2].spectrum.pga: missing", "acceleration in m/s², for instance pga = 2.0"],
        ),
        (
            "f_min = 0.2",
            "f_min = 0.2, f_max = 100",
            &["8 motion.process[1].f_max: 100 Hz is not below the Nyquist frequency 100 Hz", "lower"],
        ),
        (
            "step = \"scale\", factor = 2.0",
            "step = \"resample\", dt = 0.02 }, { step = \"filter\", f_max = 30",
            &[
                "8 motion.process[3].f_max: 30 Hz is not below the Nyquist frequency 25 Hz",
                "lower the corner",
            ],
        ),
        (
            "step = \"scale\", factor = 2.0",
            "step = \"convert\", to = \"velocity\" }, { step = \"rest\"",
            &[
                "8 motion.process[3]: the motion is a velocity here; `rest`",
                "to = \"acceleration\" } before it",
            ],
        ),
        (
            "step = \"scale\", factor = 2.0",
            "step = \"pad\", before = 4e5",
            &["8 motion.process[2]: 400000 s of zeros are too many: at most 2e7 samples, 100000 s", "fewer"],
        ),
        ("[0.2, 20.0]", "[20.0, 0.2]", &["9 motion.band: f_min = 20 Hz is not below f_max = 0.2 Hz"]),
        ("[0.2, 20.0]", "[0, 20.0]", &["9 motion.band[1]: expected a number above 0 Hz"]),
        ("[0.2, 20.0]", "[1, 2, 3]", &["9 motion.band: expected two frequencies", "list of 3"]),
        (
            "[0.2, 20.0]",
            "[0.2, 101]",
            &["9 motion.band: f_max = 101 Hz is above the Nyquist frequency 100 Hz"],
        ),
        ("[0.2, 20.0]", "\"ful\"", &["9 motion.band", "did you mean \"full\"?"]),
        (
            "# the components",
            "offset = { first_seconds = 2 }",
            &["10 motion.offset: is a step of `process` now", "[{ step = \"demean\", first_seconds = 2.0 }]"],
        ),
        (
            "# the components",
            "scale = { pga = 3 }",
            &["10 motion.scale: is a step", "[{ step = \"demean\" }, { step = \"scale\", pga = 3.0 }]"],
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
            &[
                "20 soil.layer[1].thickness: expected a number of at least 1e-6 and of at most 100000 m, found 0 m",
            ],
        ),
        ("thickness = 5\n", "thickness = inf\n", &["20 soil.layer[1].thickness", "found inf"]),
        ("thickness = 10.0\n", "", &["25 soil.layer[2].thickness: missing"]),
        (
            "vs = 150.0",
            "vs = 0",
            &["21 soil.layer[1].vs: expected a number above 0 and of at most 10000 m/s"],
        ),
        ("nu = 0.3", "nu = 0.5", &["22 soil.layer[1].nu", "of at least 0 and below 0.5, found 0.5"]),
        ("nu = 0.3", "nu = -0.1", &["22 soil.layer[1].nu"]),
        ("nu = 0.3", "nu = 0.3\nvp = 400.0", &["23 soil.layer[1].vp: `nu` is given too"]),
        (
            "rho = 1800.0",
            "rho = [1800.0]",
            &[
                "23 soil.layer[1].rho: expected a number of at least 0.001 and of at most 100000 kg/m³, found a list",
            ],
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
        ("dt = 1e-4", "dt = 0", &["40 discretisation.dt: expected a number of at least 1e-9 s, found 0 s"]),
        ("dt = 1e-4", "dt = 9e-10", &["40 discretisation.dt: expected a number of at least 1e-9 s"]),
        ("mechanisms = 3", "mechanisms = 13", &["41 discretisation.mechanisms"]),
        ("tail = 5", "tail = -1", &["42 discretisation.tail"]),
        ("tail = 5", "tail = 1e9", &["42 discretisation.tail", "of at most 3600 s, found 1e9 s"]),
        ("[2, 3]", "[2, 20001]", &["39 discretisation.elements[2]: expected a whole number from 1 to 20000"]),
        (
            "[2, 3]",
            "[20000, 1]",
            &["39 discretisation.elements: 20001 elements in all are too many (limit 20000)", "higher order"],
        ),
        (
            "field_spacing = 0.5",
            "field_spacing = 0.0074",
            &[
                "46 output.field_spacing: 0.0074 m is below 0.0075 m, the column's depth over 2000",
                "\"auto\"",
            ],
        ),
        ("thickness = 5\n", "thickness = 100001\n", &["20 soil.layer[1].thickness", "of at most 100000 m"]),
        ("vs = 800.0", "vs = 10001", &["34 soil.base.vs", "of at most 10000 m/s"]),
        ("vp = 550.0", "vp = 20001", &["28 soil.layer[2].vp", "of at most 20000 m/s"]),
        (
            "nu = 0.3",
            "nu = 0.4999999",
            &["22 soil.layer[1].nu: vs = 150 m/s and nu = 0.4999999 make vp = 335400 m/s", "lower nu"],
        ),
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
    let undamped_rigid = rigid.replace("damping = 0.02\n", "").replace("q = 25\nq_p = 50\n", "");
    warns_of(&undamped_rigid, "along x and y and the base is rigid: resonances grow without bound");
    let surface = |text: &str| text.replace("kind = \"within\"", "kind = \"surface\"");
    one_error(
        &surface(&undamped_rigid),
        &["6 motion.kind: a surface motion over a rigid base cannot be carried down along x and y"],
    );
    assert!(warnings(&surface(&rigid)).is_empty());
    // An elastic base takes no energy from a motion that is imposed on it, but radiates one found by deconvolution.
    let undamped = without_damping(GOOD);
    warns_of(&undamped, "along x and y and a within motion is imposed on the base");
    assert!(warnings(&surface(&undamped)).is_empty());
    assert!(warnings(&undamped.replace("kind = \"within\"", "kind = \"outcrop\"")).is_empty());
}

/// What counts is the damping of the waves that run: shear waves along x and y, P waves along z.
#[test]
fn damping_is_judged_by_the_active_components() {
    let vertical = with("[motion.y]", "[motion.z]");
    assert!(warnings(&vertical).is_empty());
    let only_s = vertical.replace("damping = 0.02", "damping = 0.02\ndamping_p = 0.0");
    let only_s = only_s
        .replace("q = 25\nq_p = 50", "q = 25\ndamping_p = 0.0")
        .replace("kind = \"elastic\"", "kind = \"rigid\"");
    let only_s = only_s.replace("vs = 800.0\nrho = 2200.0\n", "");
    assert!(
        warnings(&only_s).iter().any(|w| w.contains("motion.kind: warning: no layer is damped along z and")),
        "{:#?}",
        warnings(&only_s)
    );
    one_error(&only_s.replace("kind = \"within\"", "kind = \"surface\""), &["carried down along z, where"]);
    let only_p = without_damping(&vertical).replace("rho = 1800.0", "rho = 1800.0\ndamping_p = 0.02");
    warns_of(&only_p, "no layer is damped along x and");
    warns_of(&without_damping(&vertical), "no layer is damped along x and z and");
    // A misspelt damping is one mistake.
    let misspelt = without_damping(GOOD).replace("rho = 1800.0", "rho = 1800.0\ndampin = 0.02");
    let found = load(&misspelt).expect_err("an unknown key");
    assert_eq!(found.len(), 1, "{found}");
    assert!(found.to_string().contains("did you mean `damping`?"), "{found}");
}

fn without_damping(text: &str) -> String {
    text.replace("damping = 0.02\n", "").replace("q = 25\nq_p = 50\n", "")
}

/// Asserts that a text has one warning, about the place of its motion.
fn warns_of(text: &str, part: &str) {
    let found = warnings(text);
    assert_eq!(found.len(), 1, "{found:#?}");
    assert!(
        found[0].starts_with("scene.toml:6 motion.kind: warning: no layer is damped along"),
        "{}",
        found[0]
    );
    assert!(found[0].contains(part), "{part:?} is not in {:?}", found[0]);
}

/// Numbers that would fill the memory are refused where two keys make them together.
#[test]
fn sizes_are_bounded() {
    let layer = "[[soil.layer]]\nthickness = 1.0\nvs = 200.0\nrho = 1800.0\n";
    let many = |n: usize| {
        let text = with("[soil.base]", &(layer.repeat(n) + "[soil.base]"));
        text.replace("[2, 3]", "\"auto\"").replace("field_spacing = 0.5\n", "")
    };
    assert!(load(&many(1998)).is_ok());
    one_error(&many(1999), &["soil.layer: expected at most 2000 layers, found 2001"]);
    let fine = GOOD.replace("dt = 0.005, duration = 4.0", "dt = 1e-6, duration = 4.0");
    assert!(errors(&fine).is_empty(), "{:?}", errors(&fine));
    one_error(
        &fine.replace("tail = 5", "tail = 3600"),
        &["discretisation.tail: motion and tail are 3.604e9 samples, too many", "the wavelet's dt"],
    );
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
        ("factor = 2.0", "pga = 200", "motion.process[2].pga: warning: 200 m/s²"),
        (
            "step = \"scale\", factor = 2.0",
            "step = \"demean\"",
            "motion.process[2]: warning: `demean` acts on records, and this motion has wavelets only",
        ),
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
    let Some(Component::Record(record)) = &scene.motion().z else {
        panic!("z is a record");
    };
    assert_eq!((record.unit, record.channel.as_deref()), (Some(Unit::G), Some("EW")));
    assert_eq!(scene.path_of(&record.file), records.join("station.EW"));
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
    let more = "dt = 0.005\nmetadata = \"records/inventory.xml\"\nresponse = \"stages\"\npre_filter = [0, 0.1, 20, 25.5]";
    refused("records/station.EW", more, &["scene.toml:14 motion.z.metadata: there is no file inventory.xml"]);
    fs::write(records.join("inventory.xml"), "data").expect("a file");
    let scene = load_file("records/station.EW", more).unwrap_or_else(|e| panic!("{e}"));
    let Some(Component::Record(record)) = &scene.motion().z else {
        panic!("z is a record");
    };
    let source = scene.source_of(record);
    let response = source.response.expect("a response");
    assert_eq!((source.location, source.dt), (records.join("station.EW"), Some(0.005)));
    assert_eq!((response.metadata, response.mode), (records.join("inventory.xml"), ResponseMode::Stages));
    assert_eq!(response.pre_filter, Some([0.0, 0.1, 20.0, 25.5]));
    let with = |key: &str| format!("metadata = \"records/inventory.xml\"\n{key}");
    refused("records/station.EW", "dt = 0", &["scene.toml:13 motion.z.dt: expected a number above 0 s"]);
    refused(
        "records/station.EW",
        "response = \"full\"",
        &["motion.z.response: needs `metadata`", "StationXML"],
    );
    refused("records/station.EW", &with("response = \"ful\""), &["did you mean \"full\"?"]);
    refused("records/station.EW", &with("unit = \"g\""), &["motion.z.unit: `metadata` is given too"]);
    refused(
        "records/station.EW",
        &with("pre_filter = [1, 2, 3]"),
        &["expected a list of 4 numbers, found 3"],
    );
    refused(
        "records/station.EW",
        &with("pre_filter = [1, 2, 2, 3]"),
        &["four rising frequencies, found 1, 2, 2, 3 Hz"],
    );
    let sensitivity = with("response = \"sensitivity\"\npre_filter = [1, 2, 3, 4]");
    refused(
        "records/station.EW",
        &sensitivity,
        &["motion.z.pre_filter: has no use with response = \"sensitivity\""],
    );
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
