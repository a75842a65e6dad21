//! What once broke, each test named by it.

use crate::program::{folder, hati, number, read_json, shipped, write};
use crate::results::{File, peak};
use crate::scenes::{SceneText, ricker};

/// A given step above the record's was silently cut down to it and shown as the user's.
#[test]
fn a_step_above_the_records_is_judged_as_given() {
    let folder = folder();
    let scene = shipped("three-layer");
    hati(folder.path(), &["plan", &scene, "--json", "--set", "discretisation.dt=0.05"])
        .fails_in_json(2, &["discretisation.dt = 5.0000e-2 s is unstable", "critical step", "layer `upper`"]);
}

/// With fixed sizes, a prediction below the accuracy asked counted as a failure when it was above the
/// planner's own target, 0.85 of it.
#[test]
fn fixed_sizes_are_judged_against_the_accuracy_asked() {
    let folder = folder();
    let plan = |accuracy: f64| {
        let set = format!("accuracy={accuracy}");
        let sizes = ["order=3", "elements=[1,1,1]", "dt=0.0025", "mechanisms=3"]
            .map(|s| format!("discretisation.{s}"));
        let mut arguments =
            vec!["plan".to_owned(), "--json".into(), shipped("three-layer"), "--set".into(), set];
        // The band follows from the accuracy: keep it, so that the prediction stays.
        arguments.extend(["--set".into(), "motion.band=[0.45, 13.8]".into()]);
        arguments.extend(sizes.into_iter().flat_map(|s| ["--set".into(), s]));
        hati(folder.path(), &arguments)
    };
    let predicted = number(&plan(0.1).exits(0).json(), "/accuracy/predicted");
    let value = plan(predicted / 0.95).exits(0).json();
    assert_eq!(value["accuracy"]["met"], true, "{value:#}");
    assert_eq!(value["warnings"], serde_json::json!([]));
    plan(predicted / 1.05).exits(1);
}

/// The imposed velocity fell to zero at the last sample: an acceleration of v/dt, larger with every finer step.
#[test]
fn an_imposed_motion_does_not_stop_dead_at_the_last_sample() {
    let folder = folder();
    let scene = SceneText {
        kind: "within",
        base: None,
        // Cut where the ground still moves.
        motions: vec![('x', ricker(3.0, 1.0, 0.9, 1.0))],
        discretisation: "tail = 0.0".into(),
        band: "\"full\"",
        ..SceneText::default()
    };
    let path = write(folder.path(), "cut.toml", &scene.text());
    for accuracy in ["1e-2", "1e-3"] {
        let set = format!("accuracy={accuracy}");
        hati(folder.path(), &["run", &path, "--set", &set, "--out", accuracy]).exits(0);
        let base = File::open(&folder.path().join(accuracy), "stations.nc").at("acceleration_x", "within");
        assert!(peak(&base) < 1.01, "{accuracy}: {}", peak(&base));
    }
}

/// A field of an earlier run stayed in the folder of a run without one, and both summaries named it.
#[test]
fn a_run_without_a_field_leaves_no_field() {
    let folder = folder();
    let scene = shipped("three-layer");
    hati(folder.path(), &["run", &scene, "--out", "r"]).exits(0);
    hati(folder.path(), &["run", &scene, "--out", "r", "--set", "output.field_spacing=none"]).exits(0);
    let run = folder.path().join("r");
    assert!(!run.join("field.nc").exists());
    let outputs = read_json(run.join("summary.json"))["outputs"].clone();
    assert!(outputs.as_array().is_some_and(|list| list.iter().all(|name| name != "field.nc")), "{outputs}");
}

/// `summary.json` of an earlier run outlived a run that failed: the folder said "finished".
#[test]
fn a_failed_run_leaves_no_old_summary() {
    let folder = folder();
    let scene = shipped("three-layer");
    hati(folder.path(), &["run", &scene, "--out", "r"]).exits(0);
    let run = folder.path().join("r");
    // A folder in the place of a figure's name fails the second run at its end.
    let figure = run.join("figures/acceleration-x.svg");
    std::fs::remove_file(&figure).expect("a figure");
    std::fs::create_dir(&figure).expect("a folder");
    hati(folder.path(), &["run", &scene, "--out", "r", "--set", "accuracy=0.02"]).exits(4);
    // What stands there is this run's, whose computation did finish.
    assert_eq!(read_json(run.join("summary.json"))["accuracy"]["asked"], 0.02);
}
