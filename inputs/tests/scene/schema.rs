//! The schema, the reference page and the reader say the same.

use std::fs;

use hati_inputs::scene::{self, Base};

use super::validator::violations;
use super::{GOOD, root, sets, with};

#[test]
fn example_scenes_load_and_fit_the_schema() {
    let schema = scene::schema();
    let violations = |text: &str| {
        let value: serde_json::Value = toml::from_str(text).expect("TOML");
        violations(&schema, &value)
    };
    for name in ["site-response", "three-layer"] {
        let path = root().join("scenes").join(name).join("scene.toml");
        let scene = scene::load(&path).unwrap_or_else(|e| panic!("{e}"));
        assert!(scene.source.warnings.is_empty(), "{}", scene.source.warnings);
        assert!(matches!(scene.soil.base, Some(Base::Elastic { .. })));
        let text = fs::read_to_string(&path).expect("the scene is there");
        let found = violations(&text);
        assert!(found.is_empty(), "{name}: {found:#?}");
    }
    assert_eq!(violations(GOOD), Vec::<String>::new());
    for (old, new) in [
        ("order = 6", "order = 11"),
        ("nu = 0.3", "nu = 0.5"),
        ("name = \"fill\"", "nam = \"fill\""),
        ("\"within\"", "\"inside\""),
        ("[2, 3]", "[2, 0]"),
        ("[2, 3]", "[2, 20001]"),
        ("tail = 5", "tail = 3601"),
        ("factor = 2.0", "factor = 2.0, pga = 1.0"),
        ("factor = 2.0", "sa = 2.0"),
        ("\"scale\"", "\"rest\""),
        ("f_min = 0.2", "fmin = 0.2"),
        ("[0.2, 20.0]", "[0.2]"),
    ] {
        assert!(!violations(&with(old, new)).is_empty(), "{new}");
    }
}

/// Every range of the schema is the reader's: just outside is refused, the limit itself is as the schema says.
#[test]
fn ranges_of_schema_and_reader_agree() {
    let schema = scene::schema();
    let places: &[(&str, &str, &str)] = &[
        ("/properties", "", "accuracy"),
        ("/$defs/Soil/properties", "soil", "reference_frequency"),
        ("/$defs/Layer/properties", "soil.layer[1]", "thickness vs vp nu rho damping q damping_p q_p"),
        ("/$defs/Base/oneOf/0/properties", "soil.base", "vs rho nu vp"),
        ("/$defs/Discretisation/properties", "discretisation", "order dt mechanisms tail"),
        ("/$defs/Output/properties", "output", "field_spacing"),
        ("/$defs/StationEntry/properties", "output.stations[2]", "depth"),
        ("/$defs/Wavelet/properties", "motion.y.wavelet", "frequency time dt duration cycles"),
    ];
    let mut checked = 0;
    for (pointer, section, keys) in places {
        for key in keys.split(' ') {
            let definition =
                schema.pointer(&format!("{pointer}/{key}")).unwrap_or_else(|| panic!("{pointer}/{key}"));
            for (word, step, inside) in [
                ("minimum", -1.0, true),
                ("exclusiveMinimum", -1.0, false),
                ("maximum", 1.0, true),
                ("exclusiveMaximum", 1.0, false),
            ] {
                let Some(limit) = definition.get(word).and_then(serde_json::Value::as_f64) else {
                    continue;
                };
                let whole = ["order", "mechanisms"].contains(&key);
                let path = if section.is_empty() { key.to_owned() } else { format!("{section}.{key}") };
                let refused = |x: f64| {
                    let value = if whole { format!("{x:.0}") } else { format!("{x:e}") };
                    match scene::load_str(GOOD, "scene.toml", &sets(&[(&path, &value)])) {
                        Ok(_) => false,
                        // Only a refusal of this value counts, not one of what it does elsewhere.
                        Err(found) => {
                            found.iter().any(|d| d.key_path == path && d.message.starts_with("expected a"))
                        }
                    }
                };
                let beyond = if whole { limit + step } else { limit + step * 1e-7 };
                assert!(refused(beyond), "{path} = {beyond} has to be refused ({word} {limit})");
                assert_eq!(refused(limit), !inside, "{path} = {limit} ({word})");
                checked += 1;
            }
        }
    }
    assert!(checked >= 30, "{checked} limits");
}

/// The steps of `motion.process`: their ranges are the reader's, and so are their keys.
#[test]
fn steps_of_schema_and_reader_agree() {
    let schema = scene::schema();
    let variants =
        schema.pointer("/$defs/Process/oneOf").and_then(serde_json::Value::as_array).expect("steps");
    let mut words = Vec::new();
    let mut checked = 0;
    for variant in variants {
        let properties = variant["properties"].as_object().expect("keys");
        let word = properties["step"]["const"].as_str().expect("a word");
        words.push(word);
        let found_for = |key: &str, value: &str| {
            let text = format!("[{{ step = \"{word}\", {key} = {value} }}]");
            match scene::load_str(GOOD, "scene.toml", &sets(&[("motion.process", &text)])) {
                Ok(_) => Vec::new(),
                Err(found) => found
                    .iter()
                    .filter(|d| d.key_path == format!("motion.process[1].{key}"))
                    .map(|d| d.message.clone())
                    .collect(),
            }
        };
        for (key, definition) in properties.iter().filter(|(key, _)| *key != "step") {
            let date = found_for(key, "1979-05-27");
            assert!(date.iter().any(|m| m.contains("found the date")), "{word} {key}: {date:?}");
            let whole = definition["type"] == "integer";
            for (limit, step, inside) in [
                ("minimum", -1.0, true),
                ("exclusiveMinimum", -1.0, false),
                ("maximum", 1.0, true),
                ("exclusiveMaximum", 1.0, false),
            ] {
                let Some(at) = definition.get(limit).and_then(serde_json::Value::as_f64) else { continue };
                let refused = |x: f64| {
                    let value = if whole { format!("{x:.0}") } else { format!("{x:e}") };
                    found_for(key, &value).iter().any(|m| m.starts_with("expected a"))
                };
                assert!(refused(if whole { at + step } else { at + step * 1e-7 }), "{word} {key} {limit}");
                assert_eq!(refused(at), !inside, "{word} {key} {limit}");
                checked += 1;
            }
        }
    }
    assert_eq!(words, scene::Process::WORDS);
    assert!(checked >= 20, "{checked} limits");
}

/// All keys of the schema are keys of the reader.
#[test]
fn the_reader_knows_every_key_of_the_schema() {
    let schema = scene::schema();
    let places = [
        ("/properties", ""),
        ("/$defs/Motion/properties", "motion."),
        ("/$defs/RecordFile/properties", "motion.x."),
        ("/$defs/Synthetic/properties", "motion.x."),
        ("/$defs/Wavelet/properties", "motion.x.wavelet."),
        ("/$defs/Soil/properties", "soil."),
        ("/$defs/Layer/properties", "soil.layer[1]."),
        ("/$defs/Base/oneOf/0/properties", "soil.base."),
        ("/$defs/Discretisation/properties", "discretisation."),
        ("/$defs/Output/properties", "output."),
        ("/$defs/StationEntry/properties", "output.stations[1]."),
    ];
    for (pointer, section) in places {
        let keys = schema
            .pointer(pointer)
            .and_then(serde_json::Value::as_object)
            .unwrap_or_else(|| panic!("{pointer}"));
        for key in keys.keys() {
            let path = format!("{section}{key}");
            // A date is no value of any key: a known key complains about its type, or belongs to another kind of scene,
            // and an unknown one is unknown.
            let found =
                scene::load_str(GOOD, "scene.toml", &sets(&[(&path, "1979-05-27")])).expect_err("a date");
            assert!(
                found.iter().any(|d| d.key_path == path
                    && (d.message.contains("found the date") || d.message.contains("belongs to"))),
                "{path}: {found}"
            );
        }
    }
}

#[test]
fn the_reference_page_names_every_key_with_its_unit() {
    let page = scene::reference_markdown();
    for part in [
        "| `accuracy` | number, above 1e-6, at most 0.3 | `0.01` |",
        "## `[motion]`",
        "## `[motion.x]`, `[motion.y]`, `[motion.z]`",
        "## `[motion.x.wavelet]`",
        "## `[[motion.process]]`",
        "### `step = \"filter\"`",
        "| `f_max` | number, Hz, above 0 | high frequencies pass |",
        "### `step = \"rest\"`",
        "## `[[soil.layer]]`",
        "| `thickness` | number, m, from 1e-6 to 100000 | required |",
        "| `kind` | `\"elastic\"` or `\"rigid\"` | required |",
        "| `order` | `\"auto\"` or whole number, from 1 to 10 | `\"auto\"` |",
        "| `tail` | `\"auto\"` or number, s, from 0 to 3600 |",
        "## `[[output.stations]]`",
        "## `[domain]`",
        "| `boundary` | a table of names, each `\"free\"` or `\"fixed\"` or `\"symmetry\"` or `\"absorbing\"` |",
        "## `[[material]]`",
        "## `[[source]]`",
        "## `[source.wavelet]`",
        "## `[run]`",
        "## `[output.checkpoint]`",
        "| `memory_variables` | `\"auto\"` or `\"full\"` or `\"coarse\"` | `\"auto\"` |",
        "| `precision` | `\"auto\"` or `\"f32\"` or `\"f64\"` | `\"auto\"` |",
        "`\"rigid\"`: A rigid base that follows the motion",
    ] {
        assert!(page.contains(part), "{part:?} is not in\n{page}");
    }
    let columns = |line: &str| line.replace("\\|", "").matches('|').count();
    for line in page.lines().filter(|l| l.starts_with('|')) {
        assert_eq!(columns(line), 5, "{line}");
    }
    assert!(!page.contains("null"), "TOML has no null");
}
