//! `hati plan`: sizes and reasons; refusals before anything runs.

use crate::program::{folder, hati, number, shipped};

#[test]
fn text_for_people() {
    let folder = folder();
    let answer = hati(folder.path(), &["plan", &shipped("three-layer")]).exits(0);
    assert_eq!(answer.stderr, "");
    assert!(answer.stdout.starts_with("plan of “Three layers under a Ricker pulse”\n"));
    let words = [
        "motion.band",
        "discretisation.order",
        "discretisation.dt",
        "critical step",
        "accuracy",
        "predicted",
    ];
    for word in words {
        assert!(answer.stdout.contains(word), "{word} is missing in {}", answer.stdout);
    }
    assert_eq!(std::fs::read_dir(folder.path()).expect("the folder").count(), 0, "plan writes nothing");
}

#[test]
fn json_for_programs() {
    let folder = folder();
    let answer = hati(folder.path(), &["plan", "--json", &shipped("three-layer")]).exits(0);
    assert_eq!(answer.stderr, "");
    let plan = answer.json();
    for key in ["accuracy", "model", "limits", "cost", "reasons", "warnings"] {
        assert!(plan.get(key).is_some(), "{key}");
    }
    assert_eq!(number(&plan, "/accuracy/asked"), 1e-2);
    let predicted = number(&plan, "/accuracy/predicted");
    assert!(predicted > 0.0 && predicted <= 1e-2, "{predicted}");
    assert_eq!(plan["accuracy"]["met"], true);
    assert!(number(&plan, "/model/dt") < number(&plan, "/limits/dt_critical"));
    assert_eq!(plan["limits"]["layer"], "upper");
    for key in ["solver_s", "memory_bytes", "disk_bytes"] {
        assert!(number(&plan, &format!("/cost/{key}")) > 0.0, "{key}");
    }
    let reasons = plan["reasons"].as_array().expect("a list");
    for key in
        ["motion.band", "discretisation.order", "discretisation.elements", "discretisation.dt", "accuracy"]
    {
        let reason =
            reasons.iter().find(|r| r["key"] == key).unwrap_or_else(|| panic!("no reason for {key}"));
        assert!(reason["why"].as_str().is_some_and(|why| why.len() > 10), "{reason}");
    }
}

#[test]
fn a_better_answer_costs_more() {
    let folder = folder();
    let plan = |accuracy: &str| {
        let set = format!("accuracy={accuracy}");
        hati(folder.path(), &["plan", "--json", &shipped("three-layer"), "--set", &set]).exits(0).json()
    };
    let (coarse, fine) = (plan("1e-1"), plan("1e-3"));
    assert!(number(&fine, "/accuracy/predicted") <= 1e-3);
    assert!(number(&fine, "/cost/solver_s") > number(&coarse, "/cost/solver_s"));
}

#[test]
fn an_unstable_step_is_refused_with_its_limit() {
    let folder = folder();
    let arguments = |verb| {
        let mut all = vec![verb, "--json"].into_iter().map(String::from).collect::<Vec<_>>();
        all.push(shipped("three-layer"));
        for set in ["order=8", "elements=[4,4,4]", "dt=0.005"] {
            all.extend(["--set".into(), format!("discretisation.{set}")]);
        }
        all
    };
    for verb in ["plan", "run"] {
        let answer = hati(folder.path(), &arguments(verb)).exits(2);
        let text = answer.json()["error"].as_str().expect("a text").to_owned();
        for word in ["discretisation.dt", "unstable", "critical step is", "layer `upper`", "\"auto\""] {
            assert!(text.contains(word), "{word} is missing in {text}");
        }
        answer.fails_in_json(2, &["unstable"]);
    }
    assert_eq!(std::fs::read_dir(folder.path()).expect("the folder").count(), 0, "nothing was run");
}

#[test]
fn an_accuracy_out_of_reach_is_told() {
    let folder = folder();
    let scene = shipped("three-layer");
    let arguments =
        ["plan", &scene, "--set", "discretisation.order=1", "--set", "discretisation.elements=[1,1,1]"];
    let answer = hati(folder.path(), &arguments).exits(1);
    let warning = answer.stdout.lines().find(|l| l.contains("warning:")).expect("a warning");
    assert!(
        warning.contains("above the accuracy asked") && warning.contains("largest part is space"),
        "{warning}"
    );
    let plan = hati(folder.path(), &[&arguments[..], &["--json"]].concat()).exits(1).json();
    assert_eq!(plan["accuracy"]["met"], false);
    assert_eq!(plan["warnings"].as_array().map(Vec::len), Some(1));
    // A run does what the scene says, and says how far it is off.
    let run = hati(
        folder.path(),
        &["run", &scene, "--json", "--out", "r", arguments[2], arguments[3], arguments[4], arguments[5]],
    );
    let summary = run.exits(1).json();
    assert_eq!(summary["status"], "finished");
    assert!(number(&summary, "/accuracy/predicted") > number(&summary, "/accuracy/asked"));
}
