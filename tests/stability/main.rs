//! Each limit from both sides, and the watchdog behind it.

use hati::run::{RunError, Simulation};
use hati::verify::{accelerogram, scene_with, simulate, verify};
use hati_coupling::CouplingError;

#[test]
fn stable_below_the_computed_step_and_unstable_above_it() {
    let checks = verify(&|name| name == "step-bound", false, &mut |_| ()).unwrap();
    assert_eq!(checks.len(), 40);
    let failed: Vec<String> = checks.iter().filter(|c| !c.pass).map(ToString::to_string).collect();
    assert!(failed.is_empty(), "{}", failed.join("\n"));
}

#[test]
fn the_solid_is_stable_below_its_step_and_unstable_above_it() {
    let checks = verify(&|name| name == "solid-step-bound", false, &mut |_| ()).unwrap();
    assert_eq!(checks.len(), 416);
    let failed: Vec<String> = checks.iter().filter(|c| !c.pass).map(ToString::to_string).collect();
    assert!(failed.is_empty(), "{}", failed.join("\n"));
}

#[test]
#[ignore = "a million steps; `make test-long` and `hati verify --long step-bound-million` run it"]
fn stable_through_a_million_steps() {
    let checks = verify(&|name| name == "step-bound-million", true, &mut |_| ()).unwrap();
    assert!(!checks.is_empty() && checks.iter().all(|c| c.pass), "{checks:?}");
}

const SOIL: &str = "[soil]\n[[soil.layer]]\nname = \"slow\"\nthickness = 8.0\nvs = 150.0\nrho = 1800.0\n\
    [[soil.layer]]\nname = \"thin and stiff\"\nthickness = 0.5\nvs = 600.0\nrho = 2000.0\n\
    [soil.base]\nkind = \"elastic\"\nvs = 700.0\nrho = 2200.0\n";

#[test]
fn the_watchdog_stops_a_run_beyond_its_step_and_names_the_place() {
    let scene = scene_with(SOIL, "outcrop", 1e-2, "", "").unwrap();
    let (mut plan, sound) = simulate(&scene, accelerogram(0.01, 5.0), 0.01).unwrap();
    assert_eq!(sound.recorder.samples_taken(), plan.samples);
    // the plan refuses such a step; here it is forced
    plan.substeps = (plan.sample_dt / (1.05 * plan.dt_critical)).floor().max(1.0) as usize;
    let beyond = plan.sample_dt / plan.substeps as f64;
    assert!(beyond > 1.01 * plan.dt_critical);
    let mut run = Simulation::new(&plan).unwrap();
    let error = run.run_through(&plan).unwrap_err();
    assert!(matches!(error, CouplingError::Unstable { .. }), "{error}");
    let text = error.to_string();
    assert!(text.contains("thin and stiff") && text.contains("critical step"), "{text}");
    assert!(run.recorder.samples_taken() < plan.samples);
}

#[test]
fn a_given_step_beyond_the_limit_is_refused_with_the_layer_that_sets_it() {
    let scene = scene_with(SOIL, "outcrop", 1e-2, "", "[discretisation]\norder = 6\ndt = 0.01").unwrap();
    let Err(RunError::Plan(error)) = simulate(&scene, accelerogram(0.01, 5.0), 0.01) else {
        panic!("accepted");
    };
    let text = error.to_string();
    assert!(
        text.contains("`thin and stiff`") && text.contains("critical step") && text.contains("help:"),
        "{text}"
    );
}
