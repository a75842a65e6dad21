//! `hati run`: the run folder, the same scene again, and the ways to steer a run.

use std::path::Path;

use crate::program::{command, folder, hati, number, read_json, shipped, write};
use crate::results::{FILES, File};
use crate::scenes::SceneText;

/// Everything that a run leaves behind.
const FOLDER: [&str; 8] = [
    "field.nc",
    "figures",
    "ledger.nc",
    "progress.json",
    "report.html",
    "scene.resolved.toml",
    "stations.nc",
    "summary.json",
];

fn names(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).expect("the run folder");
    let mut names: Vec<String> =
        entries.map(|e| e.expect("an entry").file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

#[test]
fn a_run_folder_holds_what_the_book_says() {
    let folder = folder();
    let answer = hati(folder.path(), &["run", &shipped("three-layer"), "--out", "r"]).exits(0);
    assert_eq!(answer.stdout, "r/report.html\n");
    let answer = answer.tells(&["plan of “Three layers", "finished: solver", "PGA x: outcrop"]);
    assert!(!answer.stderr.contains("warning"), "{}", answer.stderr);
    let run = folder.path().join("r");
    assert_eq!(names(&run), FOLDER);
    let figures = names(&run.join("figures"));
    for figure in ["acceleration-x", "transfer-functions-x", "response-spectra-x", "energy-ledger"] {
        for ending in ["svg", "csv"] {
            assert!(figures.contains(&format!("{figure}.{ending}")), "{figure}.{ending} in {figures:?}");
        }
    }
    let progress = read_json(run.join("progress.json"));
    assert_eq!(progress["samples_done"], progress["samples"]);
    let samples = progress["samples"].as_u64().expect("a number") as usize;
    for name in FILES {
        assert_eq!(File::open(&run, name).records(), samples, "{name}");
    }
    let summary = read_json(run.join("summary.json"));
    assert_eq!(summary["status"], "finished");
    assert!(number(&summary, "/energy/closing_error") < 1e-10);
    for name in summary["outputs"].as_array().expect("a list") {
        assert!(run.join(name.as_str().expect("a name")).exists(), "{name}");
    }
    report_stands_alone(&run);
}

/// One file, no network: every address is the name of an XML namespace, every image is inside.
fn report_stands_alone(run: &Path) {
    let page = std::fs::read_to_string(run.join("report.html")).expect("the report");
    assert!(page.contains("Three layers under a Ricker pulse"));
    for scheme in ["http://", "https://"] {
        for (at, _) in page.match_indices(scheme) {
            let rest: String = page[at + scheme.len()..].chars().take(40).collect();
            assert!(rest.starts_with("www.w3.org/"), "{scheme}{rest}");
            assert!(
                page[..at].ends_with('"') || page[..at].ends_with('\''),
                "an address in the text: {rest}"
            );
        }
    }
    for mark in ["src=", "href="] {
        for (at, _) in page.match_indices(mark) {
            let rest = page[at + mark.len()..].trim_start_matches(['"', '\'']);
            let target = rest.split(['"', '\'', '>']).next().unwrap_or_default();
            assert!(
                ["#", "data:"].iter().any(|start| target.starts_with(start)) || run.join(target).exists(),
                "{mark}{target}"
            );
        }
    }
    for word in ["@import", "fetch(", "XMLHttpRequest", "<iframe", "<link"] {
        assert!(!page.contains(word), "{word}");
    }
}

#[test]
fn json_is_the_summary() {
    let folder = folder();
    let answer = hati(folder.path(), &["run", "--json", &shipped("three-layer"), "--out", "r"]).exits(0);
    assert_eq!(answer.stderr, "");
    assert_eq!(answer.json(), read_json(folder.path().join("r/summary.json")));
}

#[test]
fn the_resolved_scene_runs_again_to_the_same_bits() {
    let folder = folder();
    hati(folder.path(), &["run", &shipped("three-layer"), "--out", "a"]).exits(0);
    let resolved = "a/scene.resolved.toml";
    hati(folder.path(), &["check", resolved]).exits(0);
    hati(folder.path(), &["run", resolved, "--out", "b"]).exits(0);
    let [a, b] = ["a", "b"].map(|name| folder.path().join(name));
    for name in FILES {
        let (first, second) = (File::open(&a, name), File::open(&b, name));
        let variables = first.numeric();
        assert!(variables.len() > 5 && variables == second.numeric(), "{variables:?}");
        for variable in variables {
            let bits = |file: &File| file.values(&variable).iter().map(|x| x.to_bits()).collect::<Vec<_>>();
            assert!(bits(&first) == bits(&second), "{name}: {variable} differs");
        }
    }
    let results = |run: &Path| read_json(run.join("summary.json"))["results"].clone();
    assert_eq!(results(&a), results(&b));
}

#[test]
fn a_second_run_replaces_the_first() {
    let folder = folder();
    let scene = shipped("three-layer");
    hati(folder.path(), &["run", &scene, "--out", "r", "--set", "accuracy=1e-3"]).exits(0);
    let run = folder.path().join("r");
    let fine = read_json(run.join("summary.json"));
    assert_eq!(number(&fine, "/accuracy/asked"), 1e-3);
    assert!(number(&fine, "/accuracy/predicted") <= 1e-3);
    let resolved = std::fs::read_to_string(run.join("scene.resolved.toml")).expect("the resolved scene");
    assert!(resolved.contains("accuracy = 0.001"), "{resolved}");

    hati(folder.path(), &["run", &scene, "--out", "r"]).exits(0);
    let coarse = read_json(run.join("summary.json"));
    assert_eq!(number(&coarse, "/accuracy/asked"), 1e-2);
    assert!(number(&coarse, "/model/points") < number(&fine, "/model/points"));
    let samples = read_json(run.join("progress.json"))["samples"].as_u64().expect("a number") as usize;
    FILES.iter().for_each(|name| assert_eq!(File::open(&run, name).records(), samples, "{name}"));
    assert_eq!(names(&run), FOLDER, "nothing is left over");
}

#[test]
fn finer_is_near() {
    let folder = folder();
    let surface = |accuracy: &str| {
        let out = format!("r{accuracy}");
        let set = format!("accuracy={accuracy}");
        hati(folder.path(), &["run", &shipped("three-layer"), "--out", &out, "--set", &set]).exits(0);
        File::open(&folder.path().join(out), "stations.nc").at("acceleration_x", "surface")
    };
    let (coarse, fine) = (surface("1e-2"), surface("1e-3"));
    // The fine run may have another band and tail: compare where both have samples.
    let n = coarse.len().min(fine.len());
    let norm = |values: &mut dyn Iterator<Item = f64>| values.map(|x| x * x).sum::<f64>().sqrt();
    let error = norm(&mut (0..n).map(|i| coarse[i] - fine[i])) / norm(&mut fine.iter().copied());
    assert!(error > 0.0 && error < 0.03, "{error}");
}

#[test]
fn wall_time_stops_a_run() {
    let folder = folder();
    let scene = write(folder.path(), "long.toml", &crate::scenes::long().text());
    let start = std::time::Instant::now();
    let answer = hati(folder.path(), &["run", &scene, "--out", "r", "--max-wall-time", "1.5s"]).exits(5);
    assert!(start.elapsed().as_secs_f64() < 20.0);
    assert_eq!(answer.stdout, "r/report.html\n");
    answer.tells(&["interrupted"]);
    let run = folder.path().join("r");
    assert_eq!(read_json(run.join("summary.json"))["status"], "interrupted");
    let records = FILES.map(|name| File::open(&run, name).records());
    assert!(records[0] > 0 && records.iter().all(|&n| n == records[0]), "{records:?}");
    assert_eq!(names(&run), FOLDER);

    for wrong in ["0", "-3", "5parsec", "h"] {
        let option = format!("--max-wall-time={wrong}");
        hati(folder.path(), &["run", &scene, &option]).exits(2).prints_nothing().tells(&["is no time"]);
    }
}

#[test]
fn results_go_to_runs_by_default() {
    let folder = folder();
    let answer = hati(folder.path(), &["run", &shipped("three-layer")]).exits(0);
    assert_eq!(answer.stdout, "runs/three-layer/report.html\n");
    assert!(folder.path().join("runs/three-layer/summary.json").exists());
    write(folder.path(), "my-site.toml", &SceneText::default().text());
    let answer = hati(folder.path(), &["run", "my-site.toml"]).exits(0);
    assert_eq!(answer.stdout, "runs/my-site/report.html\n");
}

#[test]
fn a_synthetic_motion_needs_no_python() {
    let folder = folder();
    let mut command = command(folder.path(), &["run", &shipped("three-layer"), "--out", "r"]);
    let output = command.env("HATI_PYTHON", "/nowhere/python").env("PATH", "").output().expect("start");
    assert_eq!(output.status.code(), Some(0));
}
