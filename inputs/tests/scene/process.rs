//! Steps against what the scene tells of its motion, and where their keys stand.

use hati_inputs::scene;

use super::{GOOD, errors, load, one_error, sets, with};

/// A rotation without one of the horizontals, which no line of the step tells.
#[test]
fn a_rotation_needs_both_horizontals() {
    let text = with("step = \"scale\", factor = 2.0", "step = \"rotate\", angle = 30");
    assert_eq!(errors(&text), Vec::<String>::new());
    let y = text.lines().find(|line| line.contains("sine_burst")).unwrap().to_owned();
    let text = text.replace(&format!("[motion.y]\n{y}\n"), "");
    one_error(&text, &["8 motion.process[2]: a rotation", "motion.y is missing", "give [motion.y]"]);
}

/// What is refused while it runs is told with the line and the key that its author wrote.
#[test]
fn keys_have_places() {
    let scene = scene::load_str(GOOD, "scene.toml", &sets(&[("motion.process[2].factor", "3.0")])).unwrap();
    for (key, place) in [
        ("motion.process[1].f_min", "scene.toml:8 motion.process[1].f_min"),
        ("motion.process[1].f_max", "scene.toml:8 motion.process[1]"),
        ("motion.process[2].factor", "--set motion.process[2].factor"),
        ("motion.accept_clipped", "scene.toml:5 motion"),
        ("other.key", "scene.toml other.key"),
    ] {
        assert_eq!(scene.source.place_of(key), place);
    }
    assert!(!scene.motion().accept_clipped);
    assert!(load(&with("# the components", "accept_clipped = true")).unwrap().motion().accept_clipped);
    one_error(
        &with("# the components", "accept_clipped = 1"),
        &["10 motion.accept_clipped: expected true or"],
    );
}
