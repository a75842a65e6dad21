//! Whether what comes out of a run is what must come out: closed forms that a page of paper gives.

use hati::closed_form::{Law, surface_ratios};
use std::f64::consts::PI;
use std::path::Path;

use serde_json::Value;

use crate::program::{folder, hati, number, write};
use crate::results::{File, distance, peak};
use crate::scenes::{DT, SceneText, ricker, ricker_value, wavelet};

/// Runs a scene into `folder/name` and returns its summary and `stations.nc`.
fn run(folder: &Path, name: &str, scene: &SceneText) -> (Value, File) {
    let path = write(folder, &format!("{name}.toml"), &scene.text());
    let summary = hati(folder, &["run", &path, "--json", "--out", name]).exits(0).json();
    assert!(number(&summary, "/energy/closing_error") < 1e-10, "the ledger of {name} does not close");
    (summary, File::open(&folder.join(name), "stations.nc"))
}

/// A layer like the half-space below it reflects nothing: the surface has the outcrop's motion, later by
/// the travel time, each component with its own speed and without a trace of the others.
#[test]
fn no_contrast_only_delays() {
    let folder = folder();
    let ground = [300.0, 600.0, 2000.0];
    let pulse = [('x', 4.0, 1.0, 0.6), ('y', 3.0, -0.5, 0.7), ('z', 5.0, 0.3, 0.5)];
    let scene = SceneText {
        accuracy: 1e-3,
        motions: pulse.iter().map(|&(axis, f, a, t)| (axis, ricker(f, a, t, 3.0))).collect(),
        layers: vec![[30.0, ground[0], ground[1], ground[2], 0.0]],
        base: Some(ground),
        ..SceneText::default()
    };
    let (summary, stations) = run(folder.path(), "r", &scene);
    let time = stations.values("elapsed_time");
    for (axis, f, a, t0) in pulse {
        let delay = 30.0 / if axis == 'z' { 600.0 } else { 300.0 };
        let exact = |late: f64| time.iter().map(|t| ricker_value(f, a, t0 + late, *t)).collect::<Vec<_>>();
        let surface = stations.at(&format!("acceleration_{axis}"), "surface");
        let error = distance(&surface, &exact(delay)) / a.abs();
        assert!(error < 5e-3, "{axis}: {error}");
        let outcrop = stations.values(&format!("outcrop_acceleration_{axis}"));
        let error = distance(&outcrop, &exact(0.0)) / a.abs();
        assert!(error < 2e-3, "{axis}: {error}");
        // At depth H the wave passes twice: half before, half on its way back.
        let within = stations.at(&format!("acceleration_{axis}"), "within");
        let both: Vec<f64> = exact(0.0).iter().zip(exact(2.0 * delay)).map(|(u, d)| 0.5 * (u + d)).collect();
        let error = distance(&within, &both) / a.abs();
        assert!(error < 5e-3, "{axis}: {error}");
        let pga = number(&summary, &format!("/results/surface/{axis}/pga"));
        assert!((pga - peak(&surface)).abs() < 1e-12 * pga.max(1.0), "{axis}: the summary has another peak");
    }
}

/// A within motion is prescribed: the base has it, to round-off of its integration and back.
#[test]
fn a_within_motion_comes_back_at_the_base() {
    let folder = folder();
    for (name, base) in [("elastic", Some([800.0, 1400.0, 2200.0])), ("rigid", None)] {
        let motions = vec![('x', ricker(4.0, 1.0, 0.6, 4.0)), ('z', ricker(6.0, -0.4, 0.5, 4.0))];
        let scene = SceneText { kind: "within", band: "\"full\"", motions, base, ..SceneText::default() };
        let (summary, stations) = run(folder.path(), name, &scene);
        let time = stations.values("elapsed_time");
        for (axis, f, a, t0) in [('x', 4.0, 1.0, 0.6), ('z', 6.0, -0.4, 0.5)] {
            // The step follows the displacement; velocity and acceleration are its central differences,
            // so they are off by (2πf·dt)²/6 and half of it where the pulse is fastest.
            let pulse = |t: f64| (-(PI * f * (t - t0)).powi(2)).exp();
            let displacement = |t: f64| -0.5 * a / (PI * f).powi(2) * pulse(t);
            let velocity = |t: f64| a * (t - t0) * pulse(t);
            let acceleration = |t: f64| ricker_value(f, a, t0, t);
            let off = |motion: &str, exact: &dyn Fn(f64) -> f64| {
                let found = stations.at(&format!("{motion}_{axis}"), "within");
                let found: Vec<f64> = found.iter().map(|x| x - found[0]).collect();
                let exact: Vec<f64> = time.iter().map(|&t| exact(t)).collect();
                distance(&found, &exact) / peak(&exact)
            };
            let bound = (2.0 * PI * 3.0 * f * number(&summary, "/model/dt")).powi(2) / 6.0;
            assert!(bound < 3e-3, "{bound}");
            for (motion, error, limit) in [
                ("displacement", off("displacement", &displacement), 1e-9),
                ("velocity", off("velocity", &velocity), bound),
                ("acceleration", off("acceleration", &acceleration), bound),
            ] {
                assert!(error < limit, "{name} {axis} {motion}: {error}");
            }
        }
        // A rigid base has no outcrop; over an elastic one it follows from what leaves the column.
        assert_eq!(summary.pointer("/results/outcrop/x/pga").is_some(), base.is_some());
    }
}

/// A surface motion is deconvolved with the response of the run itself: the surface has it again.
#[test]
fn a_surface_motion_comes_back_at_the_surface() {
    let folder = folder();
    for (name, base) in [("elastic", Some([800.0, 1400.0, 2200.0])), ("rigid", None)] {
        let scene = SceneText { kind: "surface", base, band: "[0.2, 25.0]", ..SceneText::default() };
        let (summary, stations) = run(folder.path(), name, &scene);
        let time = stations.values("elapsed_time");
        assert!(time[0] < -0.5, "the waves start before the record");
        let given: Vec<f64> = time.iter().map(|&t| ricker_value(4.0, 1.0, 0.5, t)).collect();
        let surface = stations.at("acceleration_x", "surface");
        // What the band takes off the pulse is far below this.
        let error = distance(&surface, &given);
        assert!(error < 2e-3, "{name}: {error}");
        assert!(number(&summary, "/results/within/x/pga") < 0.6);
        assert!(number(&summary, "/record/deconvolution_amplification") >= 1.0);
    }
}

/// The run's own spectra have the ratio of the closed form of layered ground.
#[test]
fn the_run_has_the_transfer_function_of_the_closed_form() {
    let folder = folder();
    let scene = SceneText { accuracy: 1e-3, ..SceneText::default() };
    let (summary, _) = run(folder.path(), "outcrop", &scene);
    let transfer = summary["transfer"].as_array().expect("a list");
    assert_eq!(transfer.len(), 2);
    let loaded = hati_inputs::scene::load_str(&scene.text(), "scene.toml", &[]).expect("a sound scene");
    let profile = hati::plan::Plan::new(&loaded).expect("a plan").profile;
    for ratio in transfer {
        let (peak, frequency) = (number(ratio, "/run_peak"), number(ratio, "/run_frequency"));
        let exact = surface_ratios(&profile, 0, Law::Causal, 0.0, frequency);
        let exact = if ratio["name"] == "surface/outcrop" { exact.outcrop } else { exact.within };
        assert!((peak / exact.norm() - 1.0).abs() < 0.05, "{ratio}: {exact}");
    }
    let outcrop = number(&summary, "/results/outcrop/x/pga");
    assert!((outcrop - 1.0).abs() < 2e-3, "{outcrop}");
}

/// One pulse, taken as an outcrop motion and taken as a within motion, is not the same event.
#[test]
fn within_and_outcrop_differ_as_they_must() {
    let folder = folder();
    let outcrop = SceneText::default();
    let within = SceneText { kind: "within", ..SceneText::default() };
    let (from_outcrop, _) = run(folder.path(), "outcrop", &outcrop);
    let (from_within, _) = run(folder.path(), "within", &within);
    let pga = |s: &Value, place: &str| number(s, &format!("/results/{place}/x/pga"));
    // Soil on the rock holds it back: less than the outcrop's motion within, and the other way round.
    assert!(pga(&from_outcrop, "within") < 0.9 * pga(&from_outcrop, "outcrop"));
    assert!(pga(&from_within, "outcrop") > 1.1 * pga(&from_within, "within"));
    assert!(pga(&from_within, "surface") > 1.1 * pga(&from_outcrop, "surface"));
}

/// An undamped layer on a rigid base under a slowly swelling sine: the surface has 1/cos(ω H/v) times the
/// base's motion, with the speed of the component.
#[test]
fn a_rigid_base_amplifies_by_one_over_the_cosine() {
    let folder = folder();
    let burst = |f: f64| wavelet("sine_burst", f, 1.0, 10.0, 20.0, ", cycles = 40.0");
    let scene = SceneText {
        accuracy: 1e-3,
        kind: "within",
        band: "\"full\"",
        motions: vec![('x', burst(2.5)), ('z', burst(5.0))],
        layers: vec![[20.0, 400.0, 1000.0, 1900.0, 0.0]],
        base: None,
        discretisation: "tail = 0.5".into(),
        ..SceneText::default()
    };
    let path = write(folder.path(), "s.toml", &scene.text());
    let answer = hati(folder.path(), &["run", &path, "--json", "--out", "r"]).exits(0);
    let summary = answer.json();
    answer.tells(&["warning", "resonances grow without bound"]);
    for (axis, f, speed) in [('x', 2.5, 400.0), ('z', 5.0, 1000.0)] {
        let exact = 1.0 / (2.0 * PI * f * 20.0 / speed).cos();
        let pga = |place: &str| number(&summary, &format!("/results/{place}/{axis}/pga"));
        let found = pga("surface") / pga("within");
        assert!((found / exact - 1.0).abs() < 0.01, "{axis}: {found} against {exact}");
    }
}

/// The second derivative of a Gaussian is a Ricker pulse: given as displacement or as acceleration, the
/// motion is the same.
#[test]
fn displacement_and_acceleration_of_one_pulse_agree() {
    let folder = folder();
    let f = 4.0;
    let amplitude = 1e-3;
    let given = |quantity: &'static str, wavelet: String| SceneText {
        accuracy: 0.05,
        quantity,
        motions: vec![('x', wavelet)],
        band: "[0.1, 25.0]",
        discretisation: "order = 4\nelements = [2, 2]\ndt = 0.001\nmechanisms = 3\ntail = 2.0".into(),
        ..SceneText::default()
    };
    let displacement = given("displacement", wavelet("gaussian", f, amplitude, 1.0, 4.0, ""));
    let acceleration = given("acceleration", ricker(f, -2.0 * amplitude * (PI * f).powi(2), 1.0, 4.0));
    let (_, a) = run(folder.path(), "displacement", &displacement);
    let (_, b) = run(folder.path(), "acceleration", &acceleration);
    for motion in ["acceleration_x", "velocity_x", "displacement_x"] {
        for place in ["surface", "within"] {
            let (one, other) = (a.at(motion, place), b.at(motion, place));
            let error = distance(&one, &other) / peak(&other);
            assert!(error < 1e-3, "{motion} {place}: {error}");
        }
    }
}

/// A motion given as velocity is that velocity at the outcrop, with the right sign and size.
#[test]
fn a_velocity_is_taken_as_a_velocity() {
    let folder = folder();
    let scene = SceneText {
        quantity: "velocity",
        band: "[0.1, 30.0]",
        motions: vec![('y', ricker(4.0, -0.2, 1.0, 4.0))],
        ..SceneText::default()
    };
    let (summary, stations) = run(folder.path(), "r", &scene);
    let time = stations.values("elapsed_time");
    let given: Vec<f64> = time.iter().map(|&t| ricker_value(4.0, -0.2, 1.0, t)).collect();
    let outcrop = stations.values("outcrop_velocity_y");
    let error = distance(&outcrop, &given) / 0.2;
    assert!(error < 2e-3, "{error}");
    // Central differences of the displacement are a check by other means.
    let u = stations.values("outcrop_displacement_y");
    let slope: Vec<f64> = u.windows(3).map(|w| (w[2] - w[0]) / (2.0 * DT)).collect();
    let error = distance(&slope, &outcrop[1..outcrop.len() - 1]) / 0.2;
    assert!(error < 1e-2, "{error}");
    assert_eq!(summary["record"]["channels"][0]["quantity"], "velocity");
    assert!((number(&summary, "/results/outcrop/y/pgv") / 0.2 - 1.0).abs() < 2e-3);
}

/// An outcrop needs a half-space to rise from.
#[test]
fn an_outcrop_over_a_rigid_base_is_refused() {
    let folder = folder();
    let scene = SceneText { base: None, ..SceneText::default() };
    let path = write(folder.path(), "s.toml", &scene.text());
    hati(folder.path(), &["run", &path, "--out", "r"]).exits(2).prints_nothing().tells(&[
        "motion.kind",
        "rigid base",
        "\"within\"",
    ]);
    assert!(!folder.path().join("r").exists());
}
