//! A validator for the words of JSON Schema that the scene's schema uses; any other word is a failure of the test.

use serde_json::{Map, Value};

/// What `value` breaks of `schema`, each with its place.
pub(crate) fn violations(schema: &Value, value: &Value) -> Vec<String> {
    let mut found = Vec::new();
    check(schema, schema, value, "", &mut found);
    found
}

fn check(root: &Value, schema: &Value, value: &Value, at: &str, found: &mut Vec<String>) {
    let words = schema.as_object().expect("a schema is an object");
    for (word, rule) in words {
        if let Some(problem) = broken(root, words, word, rule, value, at, found) {
            found.push(format!("{at}: {problem}"));
        }
    }
}

/// What is wrong with `value` by one word; problems inside of it go to `found` at once.
fn broken(
    root: &Value,
    words: &Map<String, Value>,
    word: &str,
    rule: &Value,
    value: &Value,
    at: &str,
    found: &mut Vec<String>,
) -> Option<String> {
    let fits = |schema: &Value| {
        let mut inner = Vec::new();
        check(root, schema, value, at, &mut inner);
        inner.is_empty()
    };
    let matching = || rule.as_array().expect("alternatives").iter().filter(|s| fits(s)).count();
    // A limit binds numbers, a count lists, a key tables; other values pass.
    let limit = |holds: fn(f64, f64) -> bool| match value.as_f64() {
        Some(x) => holds(x, rule.as_f64().expect("a number")),
        None => true,
    };
    let count = |holds: fn(u64, u64) -> bool| match value.as_array() {
        Some(list) => holds(list.len() as u64, rule.as_u64().expect("a count")),
        None => true,
    };
    let good = match word {
        "$schema" | "$defs" | "title" | "description" | "format" | "default" => true,
        extension if extension.starts_with("x-") => true,
        "$ref" => {
            let pointer = rule.as_str().and_then(|r| r.strip_prefix('#')).expect("a local reference");
            let target = root.pointer(pointer).expect("the reference exists");
            check(root, target, value, at, found);
            true
        }
        "type" => is_type(value, rule.as_str().expect("one type")),
        "const" => value == rule,
        "enum" => rule.as_array().expect("words").contains(value),
        "anyOf" => matching() >= 1,
        "oneOf" => matching() == 1,
        "minimum" => limit(|x, l| x >= l),
        "maximum" => limit(|x, l| x <= l),
        "exclusiveMinimum" => limit(|x, l| x > l),
        "exclusiveMaximum" => limit(|x, l| x < l),
        "minItems" => count(|n, l| n >= l),
        "maxItems" => count(|n, l| n <= l),
        "items" => {
            for (i, entry) in value.as_array().into_iter().flatten().enumerate() {
                check(root, rule, entry, &format!("{at}[{i}]"), found);
            }
            true
        }
        "properties" => {
            for (key, schema) in rule.as_object().expect("properties") {
                if let Some(inner) = value.get(key) {
                    check(root, schema, inner, &format!("{at}.{key}"), found);
                }
            }
            true
        }
        "required" => {
            let keys = rule.as_array().expect("keys").iter().filter_map(Value::as_str);
            !value.is_object() || keys.into_iter().all(|k| value.get(k).is_some())
        }
        "additionalProperties" if rule.is_object() => {
            for (key, inner) in value.as_object().into_iter().flatten() {
                check(root, rule, inner, &format!("{at}.{key}"), found);
            }
            true
        }
        "additionalProperties" => {
            assert_eq!(rule, &Value::Bool(false), "closed, or of one kind");
            let known = words.get("properties").and_then(Value::as_object);
            let mut keys = value.as_object().into_iter().flat_map(|v| v.keys());
            keys.all(|k| known.is_some_and(|p| p.contains_key(k)))
        }
        other => panic!("the schema uses {other}, which this validator does not know"),
    };
    (!good).then(|| format!("{value} breaks {word}: {rule}"))
}

fn is_type(value: &Value, name: &str) -> bool {
    match name {
        "string" => value.is_string(),
        "number" => value.is_number(),
        "integer" => value.is_i64() || value.is_u64(),
        "array" => value.is_array(),
        "object" => value.is_object(),
        "boolean" => value.is_boolean(),
        other => panic!("the schema uses the type {other}, which this validator does not know"),
    }
}
