//! What is wrong with a scene in two or three dimensions is said at once, with its place and what to do.

use super::volume::{BOX, SECTION, load};
use super::{GOOD, one_error, with};

/// The errors of a text as `key: message | help`.
fn errors(text: &str) -> Vec<String> {
    let found = match load(text) {
        Ok(_) => return Vec::new(),
        Err(found) => found,
    };
    let text = |d: &hati_inputs::scene::Diagnostic| {
        assert!(d.line.is_some());
        format!("{}: {} | {}", d.key_path, d.message, d.help.clone().unwrap_or_default())
    };
    found.errors().map(text).collect()
}

/// Each mistake alone: in which scene what is changed into what, and what its one message says.
fn alone(scene: &str, cases: &[(&str, &str, &[&str])]) {
    for (old, new, parts) in cases {
        assert!(scene.contains(old), "{old:?} is not in the scene");
        let found = errors(&scene.replacen(old, new, 1));
        assert_eq!(found.len(), 1, "{old:?} to {new:?}: {found:#?}");
        for part in *parts {
            assert!(found[0].contains(part), "{new:?}: {part:?} is not in {:?}", found[0]);
        }
    }
}

#[test]
fn a_box() {
    alone(
        BOX,
        &[
            ("dimension = 3\n", "", &["domain.dimension: missing", "dimension = 2 for a section"]),
            (
                "dimension = 3",
                "dimension = 1",
                &["domain.dimension: expected a whole number from 2 to 3", "without [domain]"],
            ),
            ("x = [-20, 30.0]\n", "", &["domain.x: missing", "x = [-50.0, 50.0]"]),
            ("y = [0.0, 25.0]\n", "", &["domain.y: missing"]),
            ("x = [-20, 30.0]", "x = [30.0, -20]", &["domain.x: 30 m is not below -20 m", "smaller"]),
            ("x = [-20, 30.0]", "x = [-20, 30.0, 3]", &["domain.x: expected a list of 2 numbers"]),
            ("x = [-20, 30.0]", "x = [-20, nan]", &["domain.x[2]: expected a number of at least -1e8"]),
            ("x = [-20, 30.0]", "z = [0, 1]\nx = [-20, 30.0]", &["domain.z: unknown key"]),
            (
                "depth = 40.0",
                "depth = 15.0",
                &["domain.depth: 15 m is not below the layers, which end at 15 m"],
            ),
            ("depth = 40.0", "depth = 1e-300", &["domain.depth: expected a number of at least 1e-6"]),
            ("depth = 40.0", "depth = -4", &["domain.depth: expected a number of at least 1e-6"]),
            (
                "depth = 40.0\n",
                "depth = 40.0\ntopography = \"http://a/b\"\n",
                &["domain.topography: ", "is a URL"],
            ),
            (
                "depth = 40.0\n",
                "depth = 40.0\ntopography = \"none.xyz\"\n",
                &["domain.topography: there is no file none.xyz"],
            ),
            (
                "y_min = \"symmetry\"",
                "y_min = \"mirror\"",
                &["domain.boundary.y_min: expected \"free\", \"fixed\", \"symmetry\" or \"absorbing\""],
            ),
            (
                "y_min = \"symmetry\"",
                "ymin = \"symmetry\"",
                &["domain.boundary.ymin: unknown boundary", "`y_min`"],
            ),
            (
                "y_min = \"symmetry\"",
                "front = \"symmetry\"",
                &["domain.boundary.front: unknown boundary", "a box has `top`"],
            ),
            (
                "kind = \"elastic\"\nvs = 800.0\nrho = 2200.0",
                "kind = \"rigid\"",
                &["domain.depth: a rigid base ends the box"],
            ),
            (
                "name = \"fill\"",
                "name = \"base\"",
                &["soil.layer[1].name: `base` names the material under the layers"],
            ),
            (
                "thickness = 10.0",
                "name = \"fill\"\nthickness = 10.0",
                &["soil.layer[2].name: \"fill\" is the name of layer 1"],
            ),
            ("q_p = 40", "q_p = 500", &["soil.layer[2].q_p: a P-wave damping of 0.001 is below", "raise it"]),
            (
                "[soil]\n",
                "[motion]\nkind = \"outcrop\"\n[soil]\n",
                &["motion: a motion drives a column", "take it out and give [[source]]"],
            ),
            ("[run]\nduration = 2.5\n", "", &["run: missing", "write [run] with duration"]),
            ("duration = 2.5", "", &["run.duration: missing"]),
            ("duration = 2.5", "duration = 0", &["run.duration: expected a number above 0"]),
            (
                "duration = 2.5",
                "duration = 0.9",
                &["source[2].wavelet.time: the pulse at 1 s comes after the run's end at 0.9 s"],
            ),
            ("[run]", "[[material]]\nname = \"a\"\n[run]", &["material: belongs to a mesh's physical group"]),
        ],
    );
    let without = BOX[..BOX.find("[[source]]").expect("a source")].to_owned() + "[run]\nduration = 1.0\n";
    let found = errors(&without);
    assert!(found.len() == 1 && found[0].starts_with("source: missing | write [[source]]"), "{found:?}");
    let found = errors(&without.replace("[run]", "[source]\nkind = \"force\"\n[run]"));
    assert!(found.len() == 1 && found[0].contains("found a table | write [[source]] with two"), "{found:?}");
}

#[test]
fn sources() {
    alone(
        BOX,
        &[
            (
                "kind = \"force\"",
                "kind = \"push\"",
                &["source[1].kind: expected \"force\", \"moment\" or \"traction\""],
            ),
            ("kind = \"force\"\n", "", &["source[1].kind: missing"]),
            (
                "position = [0.0, 0.0, -1.0]\n",
                "",
                &["source[1].position: missing", "[x, y, z], or as [x, y] with `depth`"],
            ),
            (
                "[0.0, 0.0, -1.0]",
                "[0.0, 0.0]",
                &["source[1].position: expected [x, y, z] at dimension 3, found 2 numbers", "give `depth`"],
            ),
            ("[0.0, 0.0, -1.0]", "[0.0]", &["source[1].position: expected [x, y, z]"]),
            ("[0.0, 0.0, -1.0]", "0.0", &["source[1].position: expected a list of coordinates"]),
            (
                "[0.0, 0.0, -1.0]",
                "[0.0, \"0\", -1.0]",
                &["source[1].position[2]: expected a number", "quotes"],
            ),
            (
                "[0.0, 0.0, -1.0]",
                "[31.0, 0.0, -1.0]",
                &["source[1].position: x = 31 m is outside of the domain, -20 m to 30 m"],
            ),
            ("[0.0, 0.0, -1.0]", "[0.0, -1.0, -1.0]", &["source[1].position: y = -1 m is outside"]),
            (
                "[0.0, 0.0, -1.0]",
                "[0.0, 0.0, 1.0]",
                &["source[1].position: z = 1 m is above the surface", "z points up"],
            ),
            (
                "[0.0, 0.0, -1.0]",
                "[0.0, 0.0, -41.0]",
                &["source[1].position: z = -41 m is below the domain's bottom at z = -40 m"],
            ),
            (
                "[0.0, 0.0, -1.0]",
                "[0.0, 0.0, -1.0]\ndepth = 1",
                &["source[1].depth: [x, y, z] says where it is already"],
            ),
            (
                "depth = 12.5\nm",
                "depth = 40.5\nm",
                &["source[2].depth: 40.5 m is below the domain's bottom at 40 m"],
            ),
            ("depth = 12.5\nm", "depth = -1\nm", &["source[2].depth: expected a number of at least 0 m"]),
            ("force = [0.0, 0.0, -1e6]\n", "", &["source[1].force: missing", "[fx, fy, fz] in N"]),
            ("force = [0.0, 0.0, -1e6]", "force = [0.0, 0.0, 0.0]", &["source[1].force: the force is 0"]),
            ("force = [0.0, 0.0, -1e6]", "force = [1.0]", &["source[1].force: expected a list of 3 numbers"]),
            (
                "force = [0.0, 0.0, -1e6]",
                "force = [0.0, 0.0, -1e6]\nmoment = [1.0]",
                &["source[1].moment: a force has no such key"],
            ),
            (
                "force = [0.0, 0.0, -1e6]",
                "force = [0.0, 0.0, -1e6]\nrate = true",
                &["source[1].rate: a force has no such key"],
            ),
            ("rate = true", "rate = 1", &["source[2].rate: expected true or false"]),
            (
                "1e9, 1e9, 1e9, 0.0",
                "1e9, 1e9, 0.0",
                &["source[2].moment: expected a list of 6 numbers, found 5"],
            ),
            ("sigma = 0.5\n", "", &["source[3].sigma: missing"]),
            ("sigma = 0.5", "sigma = 0", &["source[3].sigma: expected a number above 0 m"]),
            ("centre = [0.0, 0.0]\n", "", &["source[3].centre: missing"]),
            (
                "centre = [0.0, 0.0]",
                "centre = [0.0]",
                &["source[3].centre: expected [x, y, z] or [x, y] at dimension 3"],
            ),
            ("force = [1e3, 0.0, 0.0]\n", "", &["source[3].force: missing", "the sum of the traction"]),
            (
                "sigma = 0.5",
                "sigma = 0.5\nposition = [1.0]",
                &["source[3].position: a traction has no such key"],
            ),
            (
                "boundary = \"x_min\"",
                "boundary = \"west\"",
                &["source[4].boundary: expected \"top\"", "found \"west\""],
            ),
            (
                "traction = [0.0, 0.0, 2e3]\n",
                "",
                &["source[4].traction: missing", "or `centre`, `sigma` and `force`"],
            ),
            (
                "traction = [0.0, 0.0, 2e3]",
                "traction = [0.0, 0.0, 2e3]\nsigma = 1",
                &["source[4].sigma: `traction` is given too"],
            ),
            ("amplitude = -3.0", "amplitude = 0", &["source[4].amplitude: the amplitude is 0"]),
            ("amplitude = -3.0", "unit = \"g\"", &["source[4].unit: unknown key"]),
            (
                "file = \"obspy:io/nied/tests/data/test.knet\"",
                "file = \"gone.knet\"",
                &["source[4].file: there is no file gone.knet"],
            ),
            (
                "file = \"obspy:io/nied/tests/data/test.knet\"\nchannel = \"EW\"\ndt = 0.01\namplitude = -3.0\n",
                "",
                &["source[4].wavelet: missing", "or `file`"],
            ),
            (
                "channel = \"EW\"",
                "wavelet = { kind = \"ramp\", frequency = 1.0, time = 1.0 }",
                &["source[4].wavelet: `file` is given too"],
            ),
            (
                "time = 0.4 }",
                "time = 0.4, dt = 0.1 }",
                &["source[1].wavelet.dt: a source's pulse is not sampled"],
            ),
            (
                "time = 0.4 }",
                "time = 0.4, cycles = 3 }",
                &["source[1].wavelet.cycles: a ricker pulse has no cycles"],
            ),
            (", cycles = 4", "", &["source[2].wavelet.cycles: missing"]),
            (", amplitude = -2", ", amplitude = 0", &["source[2].wavelet.amplitude: the amplitude is 0"]),
            (
                "kind = \"ricker\"",
                "kind = \"step\"",
                &["source[1].wavelet.kind: expected \"ricker\", \"gaussian\", \"sine_burst\" or \"ramp\""],
            ),
            ("frequency = 5.0, time", "time", &["source[1].wavelet.frequency: missing"]),
            (
                "{ kind = \"ricker\", frequency = 5.0, time = 0.4 }",
                "\"ricker\"",
                &["source[1].wavelet: expected a table"],
            ),
        ],
    );
    // Two pulses are faster than that.
    let found = errors(&BOX.replace("f_max = 15.0", "f_max = 4.5"));
    assert_eq!(found.len(), 2, "{found:#?}");
    assert!(
        found[0].starts_with("source[1].wavelet.frequency: 5 Hz is above discretisation.f_max = 4.5 Hz"),
        "{found:?}"
    );
    let early = BOX.replace(
        "frequency = 5.0, time = 0.4 }\n[[source]]\nkind = \"moment\"",
        "frequency = 5.0, time = 0.1 }\n[[source]]\nkind = \"moment\"",
    );
    let scene = load(&early).unwrap_or_else(|e| panic!("{e}"));
    let warned = scene.source.warnings.to_string();
    assert!(
        warned.contains("source[1].wavelet.time: warning: the run cuts the pulse, which begins at -0.1031 s"),
        "{warned}"
    );
}

#[test]
fn sizes_and_outputs() {
    alone(
        BOX,
        &[
            (
                "[2, 3, 4]",
                "[2, 3]",
                &["discretisation.elements: 2 counts for 3 layers", "the base's material"],
            ),
            (
                "element_size = 2.5",
                "element_size = 0",
                &["discretisation.element_size: expected a number of at least 1e-6 m"],
            ),
            (
                "element_size = 2.5",
                "element_size = \"small\"",
                &["discretisation.element_size: expected \"auto\""],
            ),
            (
                "points_per_wavelength = 5",
                "points_per_wavelength = 1",
                &["discretisation.points_per_wavelength: ", "of at least 2"],
            ),
            ("f_max = 15.0", "f_max = -1", &["discretisation.f_max: expected a number above 0 Hz"]),
            (
                "\"f64\"",
                "\"f16\"",
                &["discretisation.precision: expected \"auto\", \"f32\" or \"f64\", found \"f16\""],
            ),
            ("\"f64\"", "64", &["discretisation.precision: expected \"auto\", \"f32\" or \"f64\""]),
            (
                "\"coarse\"",
                "\"corse\"",
                &[
                    "discretisation.memory_variables: expected \"auto\", \"full\" or \"coarse\", found \"corse\"",
                ],
            ),
            ("mechanisms = 3", "tail = 3", &["discretisation.tail: belongs to a column"]),
            (
                "quantities = [\"velocity\", \"displacement\"]",
                "quantities = []",
                &["output.quantities: there is no quantity"],
            ),
            (
                "quantities = [\"velocity\", \"displacement\"]",
                "quantities = \"velocity\"",
                &["output.quantities: expected a list of quantities"],
            ),
            (
                "[\"velocity\", \"displacement\"]",
                "[\"velocity\", \"velocity\"]",
                &["output.quantities[2]: \"velocity\" stands there twice"],
            ),
            (
                "\"stress\", \"strain\"]",
                "\"stres\"]",
                &["output.stations[2].quantities[1]: ", "did you mean \"stress\"?"],
            ),
            ("vtkhdf = true", "vtkhdf = \"yes\"", &["output.vtkhdf: expected true or false"]),
            (
                "vtkhdf = true",
                "field_spacing = 1.0",
                &["output.field_spacing: belongs to a column", "[output.field]"],
            ),
            (
                "[10.0, 0.0, 0.0]",
                "[10.0, 0.0, 5.0]",
                &["output.stations[1].position: z = 5 m is above the surface"],
            ),
            ("position = [10.0, 0.0, 0.0]", "depth = 0.0", &["output.stations[1].position: missing"]),
            (
                "name = \"deep\"",
                "name = \"top\"",
                &["output.stations[2].name: \"top\" is the name of station 1 already"],
            ),
            ("boundary = \"bottom\"", "boundary = \"botom\"", &["output.surface.boundary: expected \"top\""]),
            (
                "dt = 0.01\nquantities",
                "dt = 0\nquantities",
                &["output.surface.dt: expected a number above 0 s"],
            ),
            ("boundary = \"bottom\"", "material = \"base\"", &["output.surface.material: unknown key"]),
            (
                "material = \"base\"",
                "material = \"bas\"",
                &["output.volume.material: there is no material \"bas\"", "did you mean \"base\"?"],
            ),
            (
                "material = \"base\"",
                "material = \"granite\"",
                &["output.volume.material", "\"fill\", \"layer 2\" and \"base\""],
            ),
            ("spacing = 1.0", "spacing = 0", &["output.field.spacing: expected a number above 0 m"]),
            (
                "z = [-12.0, 0.0]",
                "z = [-50.0, 0.0]",
                &["output.field.z: -50 m to 0 m reaches out of the domain, -40 m to 0 m"],
            ),
            (
                "x = [-10.0, 10.0]",
                "x = [-10.0, 31.0]",
                &["output.field.x: -10 m to 31 m reaches out of the domain, -20 m to 30 m"],
            ),
            ("z = [-12.0, 0.0]", "z = [0.0, -12.0]", &["output.field.z: 0 m is not below -12 m"]),
            (
                "every = 600",
                "every = 0",
                &["output.checkpoint.every: expected a number of at least 1 and of at most 1e9 s"],
            ),
            ("every = 600", "every = 1e30", &["output.checkpoint.every: ", "found 1e30 s"]),
            (
                "[\"velocity\", \"acceleration\"]",
                "[\"velocity\", \"strain\"]",
                &["output.field.quantities: \"strain\" is written at stations only", "[[output.stations]]"],
            ),
            (
                "[\"acceleration\"]\n[output.volume]",
                "[\"stress\"]\n[output.volume]",
                &["output.surface.quantities: \"stress\" is written at stations only"],
            ),
        ],
    );
    let bare = BOX[..BOX.find("[output]").expect("outputs")].to_owned();
    let scene = load(&bare).unwrap_or_else(|e| panic!("{e}"));
    assert!(scene.source.warnings.to_string().contains("nothing of the motion is written"));
}

#[test]
fn a_section_and_a_mesh() {
    alone(
        SECTION,
        &[
            (
                "\"basin.msh\"",
                "\"basin.vtk\"",
                &["domain.mesh: expected a Gmsh mesh (.msh) or script (.geo)"],
            ),
            (
                "\"basin.msh\"",
                "\"basn.msh\"",
                &["domain.mesh: there is no file basn.msh", "near names there: basin.msh"],
            ),
            ("mesh = \"basin.msh\"", "mesh = \"basin.msh\"\nx = [0.0, 1.0]", &["domain.x: belongs to a box"]),
            (
                "mesh = \"basin.msh\"",
                "mesh = \"basin.msh\"\ndepth = 1.0",
                &["domain.depth: belongs to a box"],
            ),
            ("\"fixed\"", "\"rigid\"", &["domain.boundary.east side: expected \"free\""]),
            (
                "name = \"rock\"\n",
                "name = \"basin\"\n",
                &["material[2].name: \"basin\" is the name of material 1 already"],
            ),
            ("rho = 2200.0", "rho = 2200.0\nthickness = 3", &["material[2].thickness: unknown key"]),
            ("vp = 1500.0", "vp = 900.0", &["material[2].vs: 800 m/s is above vp/√2 = 636 m/s"]),
            ("q_p = 80", "q_p = 800", &["material[2].q_p: a P-wave damping of 0.000625 is below"]),
            (
                "[[source]]",
                "[soil]\n[[soil.layer]]\nthickness = 1\n[[source]]",
                &["soil.layer: belongs to a column or a box"],
            ),
            (
                "[-150.0, -60.0]",
                "[-150.0, 0.0, -60.0]",
                &["source[1].position: expected [x, z] at dimension 2, found 3"],
            ),
            (
                "[-150.0, -60.0]",
                "[-150.0]",
                &["source[1].position: expected [x, z] at dimension 2, found 1", "add z"],
            ),
            (
                "kind = \"force\"",
                "kind = \"moment\"\nmoment = [1.0, 0, 1.0, 0, 0, 0]",
                &["source[1].force: a moment has no such key"],
            ),
            (
                "kind = \"force\"\nposition = [-150.0, -60.0]\nforce = [1e3, 2e3, 0.0]",
                "kind = \"moment\"\nposition = [-150.0, -60.0]\nmoment = [1, 2, 1, 0, 0, 0]",
                &["source[1].moment: myy = 2 acts on nothing"],
            ),
            (
                "[run]",
                "[discretisation]\nelements = [1]\n[run]",
                &["discretisation.elements: belongs to a box"],
            ),
            (
                "[run]",
                "[discretisation]\nelement_size = 1\n[run]",
                &["discretisation.element_size: belongs to a box"],
            ),
            (
                "[0.0], depth",
                "[0.0, 0.0], depth",
                &["output.stations[1].depth: [x, z] says where it is already"],
            ),
            (
                "material = \"rock\"",
                "material = \"roc\"",
                &["output.volume.material: there is no material \"roc\""],
            ),
            (
                "[output.volume]",
                "[output.field]\ny = [0.0, 1.0]\n[output.volume]",
                &["output.field.y: nothing varies along y"],
            ),
        ],
    );
    let flat = BOX.replace("dimension = 3", "dimension = 2");
    let found = errors(&flat);
    assert!(
        found.iter().any(|e| e.starts_with("domain.y: nothing varies along y at dimension 2")),
        "{found:#?}"
    );
    assert!(found.iter().any(|e| e.starts_with("domain.boundary.y_min: unknown boundary")), "{found:#?}");
    assert!(found.iter().any(|e| e.starts_with("source[1].position: expected [x, z]")), "{found:#?}");
}

/// Keys of the one kind of scene in the other.
#[test]
fn a_column_has_no_volumes_keys() {
    for (old, new, parts) in [
        (
            "[soil]\n",
            "[run]\nduration = 1.0\n[soil]\n",
            &["run: belongs to a scene with [domain]", "tail"][..],
        ),
        (
            "[soil]\n",
            "[[source]]\nkind = \"force\"\n[soil]\n",
            &["source: belongs to a scene with [domain]", "[motion]"],
        ),
        (
            "[soil]\n",
            "[[material]]\nname = \"a\"\n[soil]\n",
            &["material: belongs to a mesh's physical group"],
        ),
        (
            "order = 6",
            "order = 6\nelement_size = 1.0",
            &["discretisation.element_size: belongs to a scene with [domain]"],
        ),
        (
            "order = 6",
            "order = 6\nprecision = \"f64\"",
            &["discretisation.precision: belongs to a scene with [domain]"],
        ),
        (
            "order = 6",
            "order = 6\nmemory_variables = \"coarse\"",
            &["discretisation.memory_variables: belongs to a scene with [domain]"],
        ),
        (
            "depth = 12.5",
            "depth = 12.5, position = [1.0]",
            &["output.stations[2].position: belongs to a scene with [domain]"],
        ),
        (
            "depth = 12.5",
            "depth = 12.5, quantities = [\"strain\"]",
            &["output.stations[2].quantities: belongs to"],
        ),
        ("field_spacing = 0.5", "vtkhdf = true", &["output.vtkhdf: belongs to a scene with [domain]"]),
        (
            "field_spacing = 0.5",
            "[output.surface]\ndt = 0.1",
            &["output.surface: belongs to a scene with [domain]"],
        ),
        (
            "kind = \"ricker\"",
            "kind = \"ramp\"",
            &["motion.x.wavelet.kind: expected \"ricker\", \"gaussian\" or \"sine_burst\""],
        ),
    ] {
        one_error(&with(old, new), parts);
    }
    let empty = super::errors("version = 1\n[domain]\n");
    let keys: Vec<&str> = empty.iter().filter_map(|e| e.split(' ').nth(1)).collect();
    assert_eq!(keys, ["soil:", "run:", "source:", "domain.dimension:", "domain.x:"], "{empty:#?}");
    assert!(super::errors(GOOD).is_empty());
}

/// Five mistakes in five sections are told together, in the order of their lines.
#[test]
fn five_mistakes_give_five_messages() {
    let text = BOX
        .replace("depth = 40.0", "dept = 40.0")
        .replace("force = [0.0, 0.0, -1e6]", "forces = [0.0, 0.0, -1e6]")
        .replace("precision = \"f64\"", "precision = \"double\"")
        .replace("duration = 2.5", "duration = \"2.5\"")
        .replace("every = 600", "evry = 600");
    let found = errors(&text);
    let keys: Vec<&str> = found.iter().map(|e| e.split(": ").next().unwrap_or_default()).collect();
    // Without its depth the box ends with its layers, which the counts and the volume's material show as well.
    let expected = [
        "domain.dept",
        "source[1].forces",
        "discretisation.elements",
        "discretisation.precision",
        "run.duration",
        "output.volume.material",
        "output.checkpoint.evry",
    ];
    assert_eq!(keys, expected, "{found:#?}");
    assert!(found[1].contains("did you mean `force`?"));
}
