//! One operation on samples, with its numbers, as it goes into every output.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

/// One operation that was applied to the samples, with the numbers that it used.
///
/// The steps of a channel or a motion, in their order, take the stored file to the samples at hand;
/// they hold no clock times and no machine names, so the same input gives the same steps.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Step {
    /// What was done, in the field's words: `read`, `unit`, `remove offset`, `scale`, `band`, …
    pub name: String,
    /// Its numbers; units stand in the keys (`f_min_hz`, `offset_m_s2`, …).
    pub parameters: Map<String, Value>,
}

impl Step {
    /// A step from its name and a JSON object; any other JSON value stands under the key `value`.
    #[must_use]
    pub fn new(name: &str, parameters: Value) -> Self {
        let parameters = match parameters {
            Value::Object(map) => map,
            other => Map::from_iter([("value".to_string(), other)]),
        };
        Self { name: name.to_string(), parameters }
    }
}
