//! `hati check`: all mistakes at once, each with its line and key.

use std::path::Path;

use serde_json::Value;

use crate::program::{folder, hati, shipped, write};

const SOUND: &str = r#"version = 1
[motion]
kind = "within"
[motion.x]
file = "here.mseed"
[motion.y]
file = "here.mseed"
[[soil.layer]]
thickness = 5.0
vs = 150.0
vp = 1100.0
rho = 1800.0
damping = 0.02
[soil.base]
kind = "elastic"
vs = 800.0
rho = 2200.0
"#;

/// What to replace in [`SOUND`], by what, and the line, key and words of the message.
const MISTAKES: [(&str, &str, usize, &str, &[&str]); 5] = [
    (
        "file = \"here.mseed\"\n[motion.y]",
        "file = \"gone.mseed\"\n[motion.y]",
        5,
        "motion.x.file",
        &["no file gone.mseed", "here.mseed"],
    ),
    (
        "file = \"here.mseed\"\n[[soil",
        "file = \"inside\"\n[[soil",
        7,
        "motion.y.file",
        &["is a folder", "expected a file"],
    ),
    (
        "thickness = 5.0",
        "thickness = -5.0",
        9,
        "soil.layer[1].thickness",
        &["at least 1e-6 and of at most 100000 m", "-5 m"],
    ),
    ("vs = 150.0", "vs = 1200.0", 10, "soil.layer[1].vs", &["1200 m/s", "vp/√2 = 778 m/s", "Poisson"]),
    ("damping = 0.02", "dampin = 0.02", 13, "soil.layer[1].dampin", &["unknown key", "`damping`"]),
];

fn prepare(folder: &Path, mistakes: &[usize]) -> String {
    write(folder, "here.mseed", "only its name is looked at");
    std::fs::create_dir_all(folder.join("inside")).expect("a folder");
    let mut text = SOUND.to_owned();
    for &i in mistakes {
        let (sound, wrong, ..) = MISTAKES[i];
        assert_eq!(text.matches(sound).count(), 1, "{sound}");
        text = text.replace(sound, wrong);
    }
    write(folder, "scene.toml", &text)
}

/// Asserts that exactly these mistakes are told, as text and as JSON.
fn finds(mistakes: &[usize]) {
    let folder = folder();
    let scene = prepare(folder.path(), mistakes);
    let answer = hati(folder.path(), &["check", "scene.toml"]).exits(2).prints_nothing();
    let head: Vec<&str> = answer.stderr.lines().filter(|l| l.starts_with("scene.toml:")).collect();
    assert_eq!(head.len(), mistakes.len(), "{}", answer.stderr);
    let closing = if mistakes.len() == 1 { "1 mistake to mend" } else { "5 mistakes to mend" };
    assert_eq!(answer.stderr.lines().last(), Some(closing));

    let answer = hati(folder.path(), &["check", &scene, "--json"]).exits(2);
    assert_eq!(answer.stderr, "");
    let value = answer.json();
    assert_eq!(value["valid"], false);
    let told = value["diagnostics"].as_array().expect("a list");
    assert_eq!(told.len(), mistakes.len());
    for (k, &i) in mistakes.iter().enumerate() {
        let (_, _, line, key, words) = MISTAKES[i];
        assert!(head[k].starts_with(&format!("scene.toml:{line} {key}: ")), "{}", head[k]);
        assert_eq!((&told[k]["line"], &told[k]["key_path"]), (&line.into(), &Value::from(key)));
        assert_eq!(told[k]["severity"], "error");
        let text = format!("{} {}", told[k]["message"], told[k]["help"]);
        for word in words {
            assert!(text.contains(word), "{word:?} is missing in {text}");
        }
    }
}

#[test]
fn five_mistakes_at_once() {
    finds(&[0, 1, 2, 3, 4]);
}

#[test]
fn each_mistake_alone() {
    (0..MISTAKES.len()).for_each(|i| finds(&[i]));
}

#[test]
fn the_scene_without_the_mistakes_is_sound() {
    let folder = folder();
    prepare(folder.path(), &[]);
    let answer = hati(folder.path(), &["check", "scene.toml"]).exits(0);
    assert_eq!(answer.stdout, "scene.toml: the scene is sound\n");
    assert_eq!(answer.stderr, "");
}

#[test]
fn shipped_scenes_are_sound() {
    let folder = folder();
    for name in ["three-layer", "site-response", "lamb", "basin-2d"] {
        let answer = hati(folder.path(), &["check", &shipped(name)]).exits(0);
        assert_eq!(answer.stdout, format!("{}/scene.toml: the scene is sound\n", shipped(name)));
        assert_eq!(answer.stderr, "");
        let value = hati(folder.path(), &["check", "--json", &shipped(name)]).exits(0).json();
        assert_eq!(value, serde_json::json!({ "valid": true, "diagnostics": [] }));
    }
    assert_eq!(std::fs::read_dir(folder.path()).expect("the folder").count(), 0, "check writes nothing");
}

#[test]
fn overrides_are_checked_like_the_file() {
    let folder = folder();
    let scene = shipped("three-layer");
    let check = |set: &str| hati(folder.path(), &["check", &scene, "--set", set]);
    check("soil.layer[2].vs=300").exits(0);
    check("soil.layer[2].v=300").exits(2).tells(&["--set soil.layer[2].v", "unknown key", "`vs`"]);
    check("soil.layer[4].vs=300").exits(2).tells(&["--set", "soil.layer[4]", "3"]);
    check("accuracy").exits(2).prints_nothing().tells(&["--set accuracy", "key=value"]);
    check("accuracy=fine").exits(2).tells(&["--set accuracy", "number"]);
}

#[test]
fn a_scene_that_is_not_there() {
    let folder = folder();
    hati(folder.path(), &["check", "gone.toml"])
        .exits(2)
        .prints_nothing()
        .tells(&["gone.toml", "there is no file"]);
    // A folder stands for the scene.toml inside.
    hati(folder.path(), &["check", "."]).exits(2).tells(&["scene.toml", "there is no file"]);
    hati(folder.path(), &["run", "gone.toml", "--json"]).fails_in_json(2, &["gone.toml", "there is no file"]);
    write(folder.path(), "noise.toml", "version = = 1\n");
    hati(folder.path(), &["check", "noise.toml"]).exits(2).tells(&["noise.toml:1"]);
}

/// What the plan may choose, a scene may give: a resolved scene has to load again.
#[test]
fn orders_and_mechanisms_of_scene_and_solver_agree() {
    let schema = hati_inputs::scene::schema();
    let most = |key: &str| {
        schema.pointer(&format!("/$defs/Discretisation/properties/{key}/maximum")).and_then(|m| m.as_u64())
    };
    assert_eq!(most("mechanisms"), Some(hati_sem::attenuation::MECHANISMS_MAX as u64));
    assert_eq!(most("order"), Some(hati_sem::gll::ORDER_MAX as u64));
}
