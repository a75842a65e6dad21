//! What scenes in two and three dimensions take in: scripts, records, topography; and sources that cannot stand where they do.

use std::path::Path;
use std::process::Command;

use serde_json::Value;

use crate::program::{Answer, folder, hati, number, root, say, write};
use crate::python::{hati_with, interpreter};
use crate::volume::{SCENE_2D, content, expect_same, scene_3d, with};

const OF_SCRIPT: &str = r#"
version = 1
[domain]
dimension = 3
mesh = "layers.geo"
[[material]]
name = "clay"
vs = 150.0
rho = 1800.0
[[material]]
name = "rock"
vs = 500.0
rho = 2200.0
[[source]]
kind = "force"
position = [22.0, 17.0, 0.0]
force = [0.0, 0.0, -1e6]
wavelet = { kind = "ricker", frequency = 4.0, time = 0.3 }
[discretisation]
order = 3
[run]
duration = 0.4
[output]
stations = [{ name = "a", position = [48.0, 31.0, 0.0] }]
"#;

/// A script that would leave a trace if it ran, in a folder.
fn script(folder: &Path) {
    let geo = root().join("inputs/tests/data/gmsh/two-layers.geo");
    let geo = std::fs::read_to_string(geo).expect("the script");
    let text = format!("SystemCall \"touch {}\";\n{geo}", folder.join("ran").display());
    write(folder, "layers.geo", &with(&text, "size = 5;", "size = 10;"));
}

#[test]
fn a_script_is_not_run_without_leave() {
    let dir = folder();
    script(dir.path());
    let scene = write(dir.path(), "scene.toml", OF_SCRIPT);
    for verb in [&["plan", &scene][..], &["run", &scene, "--out", "run"]] {
        hati(dir.path(), verb).exits(2).tells(&["layers.geo", "is a program", "--allow-scripts", ".msh"]);
    }
    assert!(!dir.path().join("ran").exists(), "the script ran");
    assert!(!dir.path().join("run/stations.nc").exists());
}

#[test]
fn a_script_outside_the_scenes_folder_is_refused_with_leave_too() {
    let dir = folder();
    let [inside, outside] = ["scene", "outside"].map(|name| dir.path().join(name));
    for folder in [&inside, &outside] {
        std::fs::create_dir(folder).expect("a folder");
    }
    script(&outside);
    let absolute = outside.join("layers.geo").display().to_string();
    for path in ["../outside/layers.geo", &absolute] {
        let scene = write(&inside, "scene.toml", &with(OF_SCRIPT, "layers.geo", path));
        hati(&inside, &["run", &scene, "--out", "run", "--allow-scripts"])
            .exits(2)
            .tells(&["scene's folder", "copy it beside scene.toml"]);
    }
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(&absolute, inside.join("layers.geo")).expect("a link");
        let scene = write(&inside, "scene.toml", OF_SCRIPT);
        hati(&inside, &["run", &scene, "--out", "run", "--allow-scripts"])
            .exits(2)
            .tells(&["links followed"]);
    }
    assert!(!outside.join("ran").exists(), "the script ran");
}

#[test]
fn a_script_runs_with_leave() {
    let Some(python) = interpreter() else { return };
    if !Command::new(python).args(["-I", "-c", "import gmsh"]).output().is_ok_and(|o| o.status.success()) {
        say("skipped: Gmsh is missing (run `make setup`)");
        return;
    }
    let dir = folder();
    script(dir.path());
    let scene = write(dir.path(), "scene.toml", OF_SCRIPT);
    let plan = hati_with(python, dir.path(), &["plan", &scene, "--allow-scripts", "--json"]).exits(0).json();
    assert!(dir.path().join("ran").exists(), "the script did not run");
    assert_eq!(plan["model"]["elements"], 6 * 4 * 3);
    let run = ["run", &scene, "--allow-scripts", "--out", "run", "--json"];
    let summary = hati_with(python, dir.path(), &run).exits(0).json();
    assert!(dir.path().join("run/layers.msh").is_file());
    assert!(number(&summary, "/results/a/z/pga") > 0.0);
}

/// A record of a Ricker pulse does what the pulse does; twice the amplitude does twice as much, with a turned sign.
#[test]
fn a_record_drives_a_source() {
    let Some(python) = interpreter() else { return };
    let dir = folder();
    let make = r#"
import numpy, obspy
a = (numpy.pi * 5.0 * (numpy.arange(161) * 0.005 - 0.3)) ** 2
pulse = 7.0 * (1.0 - 2.0 * a) * numpy.exp(-a)
obspy.Trace(pulse.astype("f4"), header={"delta": 0.005, "station": "A"}).write("pulse.sac", format="SAC")
"#;
    let made = Command::new(python).args(["-I", "-c", make]).current_dir(dir.path()).status();
    assert!(made.is_ok_and(|status| status.success()), "the record could not be written");
    let given = "[discretisation]\nf_max = 14.0\nelement_size = 12.0\nelements = [3]\ndt = 1e-3\nprecision = \"f64\"\n\n[run]";
    let wavelet = "wavelet = { kind = \"gaussian\", frequency = 5.0, time = 0.3 }";
    let run = |name: &str, time: &str| {
        let scene = with(&with(SCENE_2D, wavelet, time), "[run]", given);
        let scene = write(dir.path(), &format!("{name}.toml"), &scene);
        hati_with(python, dir.path(), &["run", &scene, "--out", name]).exits(0);
        let content = content(&dir.path().join(name));
        content["stations velocity_z"].iter().map(|b| f64::from_bits(*b)).collect::<Vec<_>>()
    };
    let pulse = run("pulse", "wavelet = { kind = \"ricker\", frequency = 5.0, time = 0.3 }");
    let record = run("record", "file = \"pulse.sac\"");
    let turned = run("turned", "file = \"pulse.sac\"\namplitude = -2.0");
    let peak = pulse.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    assert!(peak > 0.0 && pulse.len() == record.len() && pulse.len() == turned.len());
    for (n, v) in pulse.iter().enumerate() {
        assert!((record[n] - v).abs() < 1e-4 * peak, "{n}: {} against {v}", record[n]);
        assert!((turned[n] + 2.0 * record[n]).abs() < 1e-9 * peak, "{n}: {} against {v}", turned[n]);
    }
}

/// Heights `x y z` over the box, of a function.
fn heights(folder: &Path, name: &str, height: impl Fn(f64, f64) -> f64) {
    let places = (0..=8).flat_map(|i| (0..=6).map(move |j| (5.0 * f64::from(i), -15.0 + 5.0 * f64::from(j))));
    let lines: Vec<String> = places.map(|(x, y)| format!("{x} {y} {}", height(x, y))).collect();
    write(folder, name, &lines.join("\n"));
}

#[test]
fn the_surface_follows_the_topography() {
    let dir = folder();
    let with_heights = |name: &str| {
        with(&scene_3d(0.3, ""), "depth = 30.0", &format!("depth = 30.0\ntopography = \"{name}\""))
    };
    let sunk = |text: &str| with(text, "position = [11.0, 2.0, 0.0]", "position = [11.0, 2.0]\ndepth = 0.0");
    let run = |name: &str, text: &str| -> Value {
        let scene = write(dir.path(), &format!("{name}.toml"), text);
        hati(dir.path(), &["run", &scene, "--out", name, "--json"]).exits(0).json()
    };
    heights(dir.path(), "flat.txt", |_, _| 0.0);
    heights(dir.path(), "slope.txt", |x, y| 0.1 * x - 0.05 * y);
    run("none", &sunk(&scene_3d(0.3, "")));
    run("flat", &sunk(&with_heights("flat.txt")));
    expect_same(&dir.path().join("flat"), &dir.path().join("none"));
    let below = |text: &str| {
        with(
            text,
            "{ name = \"a\", position = [22.0, 3.0, 0.0] }",
            "{ name = \"a\", position = [22.0, 3.0], depth = 0.0 }",
        )
    };
    let slope = run("slope", &below(&sunk(&with_heights("slope.txt"))));
    // a plane is one also between the corners of the elements
    let z = |station: &str| number(&slope, &format!("/results/{station}/position/2"));
    assert!((z("a") - (2.2 - 0.15)).abs() < 1e-9 && (z("b") - (0.5 + 0.2 - 6.0)).abs() < 1e-9, "{slope}");
    assert!(
        number(&slope, "/model/metric/from_corners") > 0.0 && number(&slope, "/energy/closing_error") < 1e-5
    );
    write(dir.path(), "short.txt", "0 -15 1\n0 15 1\n20 -15 1\n20 15 1\n");
    let short = write(dir.path(), "short.toml", &sunk(&with_heights("short.txt")));
    hati(dir.path(), &["plan", &short]).exits(2).tells(&["domain.topography", "to 20 m", "40 m"]);
}

/// Warnings of a plan.
fn warnings(answer: Answer) -> Vec<String> {
    let plan = answer.exits(0).json();
    let all = plan["warnings"].as_array().expect("a list").iter();
    all.map(|w| w.as_str().expect("text").to_owned()).collect()
}

/// The station stands 21.95 m from the source: within two elements of 12 m, and beyond two of 10 m.
#[test]
fn a_station_in_the_near_field_of_a_source_is_warned_of() {
    let dir = folder();
    for (size, near) in [(12, true), (10, false)] {
        let given =
            format!("[discretisation]\nelement_size = {size}.0\nelements = [3]\nf_max = 12.0\n\n[run]");
        let scene = write(dir.path(), "scene.toml", &with(SCENE_2D, "[run]", &given));
        let all = warnings(hati(dir.path(), &["plan", &scene, "--json"]));
        let told = all.iter().find(|w| w.contains("near field"));
        assert_eq!(told.is_some(), near, "{all:?}");
        for word in ["`source 1`", "`top` (21.954 m)", "12.000 m long", "two elements"] {
            assert!(told.is_none_or(|w| w.contains(word)), "{word}: {told:?}");
        }
    }
}

#[test]
fn a_source_that_its_plane_of_symmetry_turns_round_is_refused() {
    let dir = folder();
    let on = with(&scene_3d(0.2, ""), "position = [11.0, 2.0, 0.0]", "position = [0.0, 2.0, -4.0]");
    let force = "kind = \"force\"";
    let moment = |m: &str| {
        let text = with(&on, force, "kind = \"moment\"");
        with(&text, "force = [2e5, 1e5, -1e6]", &format!("moment = {m}"))
    };
    let plan = |text: &str| hati(dir.path(), &["plan", &write(dir.path(), "scene.toml", text)]);
    plan(&on).exits(2).tells(&["`hammer`", "`x_min`", "force along x = 2.0000e5", "help"]);
    plan(&with(&on, "[2e5, 1e5, -1e6]", "[0.0, 1e5, -1e6]")).exits(0);
    plan(&moment("[1e6, 2e6, 3e6, 4e5, 0.0, 5e5]")).exits(2).tells(&["`x_min`", "mxy = 4.0000e5", "help"]);
    plan(&moment("[1e6, 2e6, 3e6, 0.0, -7e5, 5e5]")).exits(2).tells(&["mxz = -7.0000e5"]);
    plan(&moment("[1e6, 2e6, 3e6, 0.0, 0.0, 5e5]")).exits(0);
    // beside the plane it is one of a pair
    plan(&with(&on, "[0.0, 2.0, -4.0]", "[0.1, 2.0, -4.0]")).exits(0);
    let patch = "kind = \"traction\"\ncentre = [0.0, 2.0]\nsigma = 3.0";
    let patch = with(&with(&on, force, patch), "position = [0.0, 2.0, -4.0]\n", "");
    plan(&patch).exits(2).tells(&["force along x", "`x_min`"]);
    plan(&with(&patch, "[2e5, 1e5, -1e6]", "[0.0, 1e5, -1e6]")).exits(0);
}
