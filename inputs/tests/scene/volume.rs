//! Scenes in two and three dimensions: read, filled in, written back.

use std::fs;

use hati_inputs::scene::{
    self, Action, Auto, BoundaryKind, MemoryVariables, OutputQuantity, Place, Precision, Pulse, PulseKind,
    Scene, TimeFunction,
};

use super::validator::violations;
use super::{root, sets};

/// A box that uses many keys and is right.
pub(crate) const BOX: &str = r#"version = 1
title = "box"

[domain]
dimension = 3
x = [-20, 30.0]
y = [0.0, 25.0]
depth = 40.0
[domain.boundary]
y_min = "symmetry"
bottom = "fixed"

[soil]
reference_frequency = 5.0
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
q_p = 40
[soil.base]
kind = "elastic"
vs = 800.0
rho = 2200.0

[[source]]
name = "weight"
kind = "force"
position = [0.0, 0.0, -1.0]
force = [0.0, 0.0, -1e6]
wavelet = { kind = "ricker", frequency = 5.0, time = 0.4 }
[[source]]
kind = "moment"
position = [10.0, 5.0]
depth = 12.5
moment = [1e9, 1e9, 1e9, 0.0, 0.0, 2e8]
rate = true
wavelet = { kind = "sine_burst", frequency = 4.0, time = 1.0, cycles = 4, amplitude = -2 }
[[source]]
kind = "traction"
centre = [0.0, 0.0]
sigma = 0.5
force = [1e3, 0.0, 0.0]
wavelet = { kind = "ramp", frequency = 5.0, time = 0.4 }
[[source]]
kind = "traction"
boundary = "x_min"
traction = [0.0, 0.0, 2e3]
file = "obspy:io/nied/tests/data/test.knet"
channel = "EW"
dt = 0.01
amplitude = -3.0

[discretisation]
order = 4
elements = [2, 3, 4]
element_size = 2.5
points_per_wavelength = 5
f_max = 15.0
precision = "f64"
dt = 1e-4
mechanisms = 3
memory_variables = "coarse"

[run]
duration = 2.5

[output]
quantities = ["velocity", "displacement"]
vtkhdf = true
stations = [
    { name = "top", position = [10.0, 0.0, 0.0] },
    { name = "deep", position = [10.0, 25.0], depth = 12.5, quantities = ["stress", "strain"] },
]
[output.surface]
boundary = "bottom"
dt = 0.01
quantities = ["acceleration"]
[output.volume]
material = "base"
dt = 0.1
quantities = ["displacement"]
[output.field]
spacing = 1.0
dt = 0.02
quantities = ["velocity", "acceleration"]
x = [-10.0, 10.0]
y = [5.0, 5.0]
z = [-12.0, 0.0]
[output.checkpoint]
every = 600
"#;

/// A section on a mesh; to be read in the folder of the basin's scene.
pub(crate) const SECTION: &str = r#"version = 1
[domain]
dimension = 2
mesh = "basin.msh"
boundary = { "east side" = "fixed", x_min = "absorbing" }
[[material]]
name = "basin"
vs = 200.0
nu = 0.4
rho = 1800.0
damping = 0.02
[[material]]
name = "rock"
vs = 800.0
vp = 1500.0
rho = 2200.0
q = 100
q_p = 80
[[source]]
kind = "force"
position = [-150.0, -60.0]
force = [1e3, 2e3, 0.0]
wavelet = { kind = "gaussian", frequency = 3.0, time = 0.5 }
[run]
duration = 4.0
[output]
stations = [{ name = "a", position = [0.0], depth = 0.0 }]
[output.volume]
material = "rock"
"#;

/// Reads a text as if it lay beside the basin's mesh.
pub(crate) fn load(text: &str) -> Result<Scene, scene::Diagnostics> {
    let name = root().join("scenes/basin-2d/scene.toml");
    scene::load_str(text, &name.display().to_string(), &[])
}

fn good(text: &str) -> Scene {
    load(text).unwrap_or_else(|e| panic!("{e}"))
}

#[test]
fn a_box_is_read_as_it_is_written() {
    let scene = good(BOX);
    assert!(scene.source.warnings.is_empty(), "{}", scene.source.warnings);
    assert_eq!(scene.dimension(), 3);
    assert!(scene.motion.is_none() && scene.components() == [None; 3] && scene.stations().len() == 2);
    let kinds = ["top", "bottom", "x_min", "x_max", "y_min", "y_max"].map(|b| scene.boundary_kind(b));
    use BoundaryKind::{Absorbing, Fixed, Free, Symmetry};
    assert_eq!(kinds, [Free, Fixed, Absorbing, Absorbing, Symmetry, Absorbing]);
    let materials = scene.materials();
    let names: Vec<&str> = materials.iter().map(|m| m.name.as_str()).collect();
    assert_eq!(names, ["fill", "layer 2", "base"]);
    assert_eq!(scene.thicknesses(), [5.0, 10.0, 25.0]);
    assert_eq!((materials[1].damping, materials[1].damping_p, materials[2].damping), (0.02, 0.0125, 0.0));
    assert!((materials[2].vp - 800.0 * 3f64.sqrt()).abs() < 1e-9);
    let d = &scene.discretisation;
    assert_eq!((d.precision, d.f_max), (Auto::Value(Precision::F64), Auto::Value(15.0)));
    assert_eq!(d.memory_variables, Auto::Value(MemoryVariables::Coarse));
    assert_eq!(scene.run.map(|r| r.duration), Some(2.5));
    let sensors = scene.sensors();
    assert_eq!(sensors[0].at, Place::Point([10.0, 0.0, 0.0]));
    assert_eq!(sensors[0].quantities, [OutputQuantity::Displacement, OutputQuantity::Velocity]);
    assert_eq!(sensors[1].at, Place::Below { x: 10.0, y: 25.0, depth: 12.5 });
    assert_eq!(sensors[1].at.point(|x, y| x + y), [10.0, 25.0, 22.5]);
    assert_eq!(sensors[1].quantities, [OutputQuantity::Strain, OutputQuantity::Stress]);
    assert_eq!(scene.output.field.as_ref().and_then(|f| f.y), Some([5.0, 5.0]));
}

#[test]
fn sources_hold_what_their_kind_asks_for() {
    let sources = good(BOX).sources();
    let names: Vec<&str> = sources.iter().map(|s| s.name.as_str()).collect();
    assert_eq!(names, ["weight", "source 2", "source 3", "source 4"]);
    let at = Place::Point([0.0, 0.0, -1.0]);
    assert_eq!(sources[0].action, Action::Force { at, force: [0.0, 0.0, -1e6] });
    let pulse = Pulse { kind: PulseKind::Ricker, frequency: 5.0, amplitude: 1.0, time: 0.4, cycles: None };
    assert_eq!(sources[0].time, TimeFunction::Pulse(pulse));
    let at = Place::Below { x: 10.0, y: 5.0, depth: 12.5 };
    let moment = [1e9, 1e9, 1e9, 0.0, 0.0, 2e8];
    assert_eq!(sources[1].action, Action::Moment { at, moment, rate: true });
    let patch = Action::Patch {
        boundary: "top".into(),
        centre: [0.0; 3],
        horizontal: true,
        sigma: 0.5,
        force: [1e3, 0.0, 0.0],
    };
    assert_eq!(sources[2].action, patch);
    let traction = Action::Traction { boundary: "x_min".into(), traction: [0.0, 0.0, 2e3] };
    assert_eq!(sources[3].action, traction);
    let TimeFunction::Record { record, amplitude } = &sources[3].time else { panic!("a record") };
    assert_eq!((record.channel.as_deref(), record.dt, *amplitude), (Some("EW"), Some(0.01), -3.0));
    assert!(record.location.starts_with("obspy:io") && record.unit.is_some());
}

#[test]
fn a_section_has_two_coordinates_and_a_meshs_materials() {
    let scene = good(SECTION);
    assert!(scene.source.warnings.is_empty(), "{}", scene.source.warnings);
    assert_eq!(scene.dimension(), 2);
    let materials = scene.materials();
    assert_eq!((materials.len(), materials[0].name.as_str(), materials[1].damping), (2, "basin", 0.005));
    assert_eq!(materials[1].damping_p, 0.5 / 80.0);
    assert_eq!(scene.boundary_kind("east side"), BoundaryKind::Fixed);
    assert_eq!(scene.boundary_kind("elsewhere"), BoundaryKind::Absorbing);
    assert_eq!(scene.boundary_kind("top"), BoundaryKind::Free);
    let at = Place::Point([-150.0, 0.0, -60.0]);
    assert_eq!(scene.sources()[0].action, Action::Force { at, force: [1e3, 2e3, 0.0] });
    let sensors = scene.sensors();
    assert_eq!(sensors[0].at, Place::Below { x: 0.0, y: 0.0, depth: 0.0 });
    use OutputQuantity::{Acceleration, Displacement, Velocity};
    assert_eq!(sensors[0].quantities, [Displacement, Velocity, Acceleration]);
    assert!(scene.thicknesses().is_empty() && scene.half_space().is_none());
}

#[test]
fn a_box_may_be_the_half_space_alone_or_stand_on_rock() {
    let layers = BOX.find("[[soil.layer]]").expect("layers")..BOX.find("[soil.base]").expect("a base");
    let mut text = BOX.replace("elements = [2, 3, 4]", "elements = [8]");
    text.replace_range(layers, "");
    let scene = good(&text);
    assert_eq!((scene.thicknesses(), scene.materials().len()), (vec![40.0], 1));
    let rigid = BOX
        .replace("kind = \"elastic\"\nvs = 800.0\nrho = 2200.0", "kind = \"rigid\"")
        .replace("depth = 40.0\n", "")
        .replace("bottom = \"fixed\"\n", "")
        .replace("[2, 3, 4]", "[2, 3]")
        .replace("material = \"base\"", "material = \"layer 2\"");
    let scene = good(&rigid);
    assert_eq!(scene.boundary_kind("bottom"), BoundaryKind::Fixed);
    assert_eq!((scene.thicknesses(), scene.materials().len()), (vec![5.0, 10.0], 2));
}

#[test]
fn heights_are_read_with_the_scene() {
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join("hills.xyz"), "-20 0 1\n-20 25 2\n30 0 3\n30 25 4\n").expect("a file");
    let path = folder.path().join("scene.toml");
    let text = BOX.replace("depth = 40.0", "depth = 40.0\ntopography = \"hills.xyz\"");
    let load = |text: &str| {
        fs::write(&path, text).expect("a file");
        scene::load(&path)
    };
    // A station at z = 0.5 lies in the ground now; one below the surface follows it.
    let raised =
        text.replace("[10.0, 0.0, 0.0]", "[10.0, 0.0, 0.5]").replace("depth = 12.5, q", "depth = 43.0, q");
    let scene = load(&raised).unwrap_or_else(|e| panic!("{e}"));
    let heights = scene.domain.as_ref().and_then(|d| d.heights.as_ref()).expect("heights");
    assert_eq!(heights.height(5.0, 12.5), 2.5);
    assert_eq!(heights.range(), (1.0, 4.0));
    assert_eq!(good(BOX).domain.expect("a domain").heights, None);
    let again = scene::load_str(&scene::resolved_toml(&scene, &[]), "run/scene.resolved.toml", &[]);
    assert_eq!(
        again.unwrap_or_else(|e| panic!("{e}")).domain.and_then(|d| d.heights).as_ref(),
        Some(heights)
    );

    let refused = |text: &str, parts: &[&str]| {
        let found = load(text).map(|_| "sound").expect_err("refused").to_string();
        assert!(found.contains("scene.toml:9 domain.topography: ") || !parts[0].contains("hills"), "{found}");
        assert!(parts.iter().all(|p| found.contains(p)) && found.matches(": ").count() < 8, "{found}");
    };
    refused(
        &text.replace("0.0, -1.0]", "0.0, 2.0]"),
        &["source[1].position: z = 2 m is above the surface at z = 1.8 m"],
    );
    refused(
        &text.replace("depth = 12.5, q", "depth = 45, q"),
        &["45 m is below the domain's bottom at 43.2 m"],
    );
    refused(
        &text.replace("[-20, 30.0]", "[-20, 40.0]"),
        &["the heights reach from x = -20 m to 30 m, the domain from -20 m to 40 m"],
    );
    fs::write(folder.path().join("hills.xyz"), "-20 0 1\n-20 25\n").expect("a file");
    refused(&text, &["hills.xyz:2: expected three numbers x y z, found `-20 25`"]);
    fs::remove_file(folder.path().join("hills.xyz")).expect("a file");
    refused(&text, &["there is no file hills.xyz"]);
}

/// Lines without comments, blank ones and what stands behind the values.
fn values(text: &str) -> Vec<String> {
    let lines = text.lines().filter(|l| !l.starts_with('#') && !l.is_empty());
    lines.map(|l| l.split(" # ").next().unwrap_or_default().to_owned()).collect()
}

#[test]
fn resolved_scenes_load_again_as_the_same_run() {
    let plain =
        BOX.replace("dt = 0.01\nquantities", "quantities").replace("[output.checkpoint]\nevery = 600\n", "");
    for text in [BOX, SECTION, &plain] {
        let scene = good(text);
        let resolved = scene::resolved_toml(&scene, &[]);
        let again = scene::load_str(&resolved, "elsewhere/scene.resolved.toml", &[])
            .unwrap_or_else(|e| panic!("{e}\n{resolved}"));
        assert_eq!(again.sources(), scene.sources());
        assert_eq!(again.sensors(), scene.sensors());
        assert_eq!(again.materials(), scene.materials());
        assert_eq!(again.thicknesses(), scene.thicknesses());
        assert_eq!((again.run, &again.discretisation), (scene.run, &scene.discretisation));
        let output = |s: &Scene| (s.output.surface.clone(), s.output.volume.clone(), s.output.field.clone());
        assert_eq!((output(&again), again.output.vtkhdf), (output(&scene), scene.output.vtkhdf));
        for name in ["top", "bottom", "x_min", "y_min", "y_max", "east side"] {
            assert_eq!(again.boundary_kind(name), scene.boundary_kind(name), "{name}");
        }
        assert_eq!(values(&scene::resolved_toml(&again, &[])), values(&resolved));
    }
    let text = scene::resolved_toml(
        &good(BOX),
        &[scene::Resolved {
            key: "output.surface.dt".into(),
            value: 0.005.into(),
            why: "a fifth of a period at f_max".into(),
        }],
    );
    for line in [
        "dimension = 3 # user",
        "x_max = \"absorbing\" # default",
        "y_min = \"symmetry\" # user",
        "name = \"source 2\" # default",
        "boundary = \"top\" # default",
        "dt = 0.005 # auto: a fifth of a period at f_max",
        "quantities = [\"displacement\", \"velocity\"] # default: output.quantities",
        "# topography: flat, z = 0 # default",
    ] {
        assert!(text.lines().any(|l| l == line), "{line:?} is not in\n{text}");
    }
    assert!(!text.contains("[motion]") && !text.contains("field_spacing") && !text.contains("tail"));
}

#[test]
fn reader_serde_and_schema_agree() {
    let schema = scene::schema();
    let shipped = ["lamb", "basin-2d"].map(|name| {
        fs::read_to_string(root().join("scenes").join(name).join("scene.toml")).expect("the scene is there")
    });
    for text in [BOX, SECTION, &shipped[0], &shipped[1]] {
        let ours = good(text);
        assert!(ours.source.warnings.is_empty(), "{}", ours.source.warnings);
        let serdes: Scene = toml::from_str(text).expect("serde reads the scene");
        assert_eq!(serde_json::to_value(&ours).expect("JSON"), serde_json::to_value(&serdes).expect("JSON"));
        let value: serde_json::Value = toml::from_str(text).expect("TOML");
        assert_eq!(violations(&schema, &value), Vec::<String>::new());
    }
    for (old, new) in [
        ("dimension = 3", "dimension = 4"),
        ("\"symmetry\"", "\"mirror\""),
        ("[run]\nduration = 2.5\n", ""),
        ("kind = \"moment\"", "kind = \"torque\""),
        ("\"f64\"", "\"f16\""),
        ("[\"velocity\", \"displacement\"]", "[]"),
        ("every = 600", "every = 0.5"),
        ("every = 600", "every = 1e30"),
        ("depth = 40.0", "depth = 1e-300"),
        ("[\"velocity\", \"acceleration\"]", "[\"velocity\", \"strain\"]"),
        ("moment = [1e9, ", "moment = ["),
    ] {
        assert!(BOX.contains(old), "{old}");
        let value: serde_json::Value = toml::from_str(&BOX.replacen(old, new, 1)).expect("TOML");
        assert!(!violations(&schema, &value).is_empty(), "{new}");
    }
}

/// All keys of the schema are keys of the reader, with the schema's ranges.
#[test]
fn the_reader_knows_the_schemas_keys_and_ranges() {
    let schema = scene::schema();
    let places = [
        ("/$defs/Domain/properties", BOX, "domain."),
        ("/$defs/Material/properties", SECTION, "material[1]."),
        ("/$defs/Pulse/properties", BOX, "source[2].wavelet."),
        ("/$defs/Run/properties", BOX, "run."),
        ("/$defs/Discretisation/properties", BOX, "discretisation."),
        ("/$defs/StationEntry/properties", BOX, "output.stations[2]."),
        ("/$defs/Output/properties", BOX, "output."),
        ("/$defs/SurfaceOutput/properties", BOX, "output.surface."),
        ("/$defs/VolumeOutput/properties", BOX, "output.volume."),
        ("/$defs/FieldOutput/properties", BOX, "output.field."),
        ("/$defs/Checkpoint/properties", BOX, "output.checkpoint."),
    ];
    let name = root().join("scenes/basin-2d/scene.toml").display().to_string();
    let found = |text: &str, key: &str, value: &str| -> Vec<String> {
        let found = scene::load_str(text, &name, &sets(&[(key, value)]));
        let found = found.err().into_iter().flat_map(|found| {
            let here: Vec<String> =
                found.iter().filter(|d| d.key_path == key).map(|d| d.message.clone()).collect();
            here
        });
        found.collect()
    };
    let mut checked = 0;
    for (pointer, text, section) in places {
        let keys = schema.pointer(pointer).and_then(serde_json::Value::as_object).expect(pointer);
        for (key, definition) in keys {
            let path = format!("{section}{key}");
            let date = found(text, &path, "1979-05-27");
            assert!(date.iter().any(|m| m.contains("found the date")), "{path}: {date:?}");
            let whole = ["order", "mechanisms", "dimension"].contains(&key.as_str());
            for (word, step, inside) in [
                ("minimum", -1.0, true),
                ("exclusiveMinimum", -1.0, false),
                ("maximum", 1.0, true),
                ("exclusiveMaximum", 1.0, false),
            ] {
                let Some(limit) = definition.get(word).and_then(serde_json::Value::as_f64) else { continue };
                let refused = |x: f64| {
                    let value = if whole { format!("{x:.0}") } else { format!("{x:e}") };
                    found(text, &path, &value).iter().any(|m| m.starts_with("expected a"))
                };
                let beyond = if whole { limit + step } else { limit + step * 1e-7 * limit.abs().max(1.0) };
                assert!(refused(beyond), "{path} = {beyond} has to be refused ({word} {limit})");
                assert_eq!(refused(limit), !inside, "{path} = {limit} ({word})");
                checked += 1;
            }
        }
    }
    assert!(checked >= 35, "{checked} limits");
    // The keys of a source belong to its kind.
    let keys = schema.pointer("/$defs/SourceEntry/properties").and_then(serde_json::Value::as_object);
    for key in keys.expect("keys").keys() {
        let said = (1..=4).any(|number| {
            let messages = found(BOX, &format!("source[{number}].{key}"), "1979-05-27");
            messages.iter().any(|m| m.contains("found the date"))
        });
        assert!(said, "{key}");
    }
}

#[test]
fn overrides_reach_every_part() {
    let set = |pairs: &[(&str, &str)]| scene::load_str(BOX, "scene.toml", &sets(pairs));
    let scene = set(&[
        ("source[1].force[3]", "-2e6"),
        ("source[2].wavelet.kind", "sine_burst"),
        ("source[4].wavelet", "{ kind = \"ramp\", frequency = 2.0, time = 1.0 }"),
        ("source[4].channel", "\"x\""),
        ("domain.boundary.x_max", "fixed"),
        ("output.surface.quantities", "[\"displacement\"]"),
        ("run.duration", "3"),
        ("discretisation.precision", "f32"),
    ])
    .expect_err("a channel without a file");
    assert!(scene.to_string().contains("source[4].channel: belongs to a file"), "{scene}");
    let scene = set(&[
        ("source[1].force[3]", "-2e6"),
        ("domain.boundary.x_max", "fixed"),
        ("domain.dimension", "3"),
        ("run.duration", "3"),
        ("discretisation.precision", "f32"),
    ])
    .unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(scene.source_entries[0].force, Some([0.0, 0.0, -2e6]));
    assert_eq!(scene.boundary_kind("x_max"), BoundaryKind::Fixed);
    assert_eq!(scene.run.map(|r| r.duration), Some(3.0));
    assert_eq!(scene.discretisation.precision, Auto::Value(Precision::F32));
    assert!(set(&[("source[5].kind", "force")]).expect_err("no fifth").to_string().contains("source[5]"));
}
