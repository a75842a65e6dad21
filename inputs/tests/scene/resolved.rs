//! A scene written back with every choice made.

use std::fs;

use hati_inputs::scene::{self, Auto, Band, Component, Resolved};

use super::{GOOD, root, sets};

#[test]
fn a_resolved_scene_loads_again_as_the_same_run() {
    let resolved = [
        Resolved {
            key: "discretisation.order".into(),
            value: 5.into(),
            why: "cheapest of 2 to 10 at the accuracy asked\n(not a second line)".into(),
        },
        Resolved {
            key: "discretisation.elements".into(),
            value: vec![1i64, 2, 3].into(),
            why: "a wavelength at 15 Hz".into(),
        },
        Resolved { key: "motion.band".into(), value: vec![0.5, 15.25].into(), why: "energy".into() },
        Resolved { key: "soil.layer[1].vp".into(), value: 259.8.into(), why: "from nu".into() },
    ];
    let path = root().join("scenes/three-layer/scene.toml");
    let overrides = sets(&[("soil.layer[2].vs", "260")]);
    let scene = scene::load_with(&path, &overrides).unwrap_or_else(|e| panic!("{e}"));
    let text = scene::resolved_toml(&scene, &resolved);
    for line in [
        "title = \"Three layers under a Ricker pulse\" # user",
        "vs = 260 # user (--set)",
        "process = [{ step = \"demean\" }] # default",
        "nu = 0.25 # default",
        "tail = \"auto\" # default",
        "band = [0.5, 15.25] # auto: energy",
        "order = 5 # auto: cheapest of 2 to 10 at the accuracy asked (not a second line)",
        "# soil.layer[1].vp = 259.8 (from nu)",
    ] {
        let line = line.replace("vs = 260 ", "vs = 260.0 ");
        assert!(text.lines().any(|l| l == line), "{line:?} is not in\n{text}");
    }
    let again = scene::load_str(&text, "elsewhere/scene.resolved.toml", &[])
        .unwrap_or_else(|e| panic!("{e}\n{text}"));
    assert_eq!(again.layers(), scene.layers());
    assert_eq!(again.stations(), scene.stations());
    assert_eq!(again.half_space(), scene.half_space());
    assert_eq!((again.accuracy, &again.title), (scene.accuracy, &scene.title));
    assert_eq!(again.motion().x, scene.motion().x);
    assert_eq!(again.motion().band, Band::Range([0.5, 15.25]));
    assert_eq!(again.discretisation.order, Auto::Value(5));
    assert_eq!(again.discretisation.elements, Auto::Value(vec![1, 2, 3]));
    assert_eq!(again.discretisation.tail, Auto::Auto);
    // Written back once more, only the provenance changes.
    let strip = |text: &str| -> Vec<String> {
        text.lines()
            .filter(|l| !l.starts_with('#') && !l.is_empty())
            .map(|l| l.split(" # ").next().unwrap_or_default().to_owned())
            .collect()
    };
    assert_eq!(strip(&scene::resolved_toml(&again, &[])), strip(&text));
}

#[test]
fn a_resolved_scene_finds_its_records_from_another_folder() {
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join("a b#\"c.EW"), "data").expect("a file");
    let wavelets = GOOD.find("[motion.x]").expect("x")..GOOD.find("[soil]").expect("soil");
    let mut text = GOOD.to_owned();
    text.replace_range(
        wavelets,
        "[motion.x]\nfile = 'a b#\"c.EW'\ndt = 0.01\nmetadata = 'a b#\"c.EW'\n[motion.y]\nfile = \"obspy:io/x.knet\"\nunit = \"g\"\n",
    );
    let path = folder.path().join("scene.toml");
    fs::write(&path, text).expect("a file");
    let scene = scene::load(&path).unwrap_or_else(|e| panic!("{e}"));
    let resolved = scene::resolved_toml(&scene, &[]);
    let again = scene::load_str(&resolved, "run/scene.resolved.toml", &[])
        .unwrap_or_else(|e| panic!("{e}\n{resolved}"));
    let (Some(Component::Record(a)), Some(Component::Record(b))) = (&scene.motion().x, &again.motion().x)
    else {
        panic!("records");
    };
    assert_eq!(scene.source_of(a), again.source_of(b));
    assert_eq!(scene.motion().y, again.motion().y);
    assert_eq!(scene.motion().process, again.motion().process);
    assert_eq!(scene.layers(), again.layers());
    assert_eq!(scene.discretisation, again.discretisation);
}
