//! One operation on samples, with its numbers, as it goes into every output.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

/// One operation that was applied to the samples, with what was asked and what came out.
///
/// The steps of a channel or a motion, in their order, take the stored file to the samples at hand;
/// they hold no clock times and no machine names, so the same input gives the same steps. A step of
/// processing has the name of its [`Process`](super::Process), and `parameters` alone repeat it:
/// [`Process::from_step`](super::Process::from_step).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Step {
    /// What was done, in the field's words: `read`, `unit`, `demean`, `scale`, `filter`, …
    pub name: String,
    /// What was asked: enough to do the same again.
    pub parameters: Map<String, Value>,
    /// What came out: offsets, factors, peaks; units stand in the keys (`offset_m_s2`, `pad_s`, …).
    #[serde(default, skip_serializing_if = "Map::is_empty")]
    pub found: Map<String, Value>,
}

/// The entries of a JSON object; any other value stands under the key `value`.
fn entries(value: Value) -> Map<String, Value> {
    match value {
        Value::Object(map) => map,
        other => Map::from_iter([("value".to_string(), other)]),
    }
}

impl Step {
    /// A step from its name and a JSON object; any other JSON value stands under the key `value`.
    #[must_use]
    pub fn new(name: &str, parameters: Value) -> Self {
        Self { name: name.to_string(), parameters: entries(parameters), found: Map::new() }
    }

    /// The same step with what came out, a JSON object as in [`Step::new`].
    #[must_use]
    pub fn with_found(mut self, found: Value) -> Self {
        self.found = entries(found);
        self
    }

    /// What must not be missed about the step, in words: gravity taken off, a factor above 10 or below 0.1,
    /// a correction to rest above a tenth of the peak, a filter's response cut off at the record's ends.
    #[must_use]
    pub fn warning(&self) -> Option<String> {
        let number = |map: &Map<String, Value>, key: &str| map.get(key).and_then(Value::as_f64);
        let worst = |share: &dyn Fn(&Map<String, Value>) -> Option<f64>| {
            let shares =
                self.found.iter().filter_map(|(axis, entry)| Some((axis, share(entry.as_object()?)?)));
            shares.max_by(|a, b| a.1.total_cmp(&b.1))
        };
        match self.name.as_str() {
            "demean" => {
                let (axis, sign) = worst(&|entry| number(entry, "gravity_g"))?;
                let sign = if sign < 0.0 { "−" } else { "+" };
                let which = if axis == "z" { "" } else { ", though it is no vertical one" };
                Some(format!(
                    "channel {axis} carried gravity ({sign}1 g){which}; it was removed with the offset"
                ))
            }
            "scale" | "match" => {
                let scale = || worst(&|entry| number(entry, "scale")).map(|(_, scale)| scale);
                let factor = number(&self.found, "factor").or_else(scale)?;
                let why = match factor.abs() {
                    f if f > 10.0 => {
                        ": a weak record made strong keeps the frequency content and duration of a weak one"
                    }
                    f if f < 0.1 => {
                        ": a strong record made weak keeps the frequency content and duration of a strong one"
                    }
                    _ => return None,
                };
                Some(format!("the motion is scaled by {factor:.4}{why}"))
            }
            "rest" => {
                let (axis, share) = worst(&|entry| number(entry, "correction_over_peak"))?;
                (share > REST_SHARE).then(|| {
                    let percent = 100.0 * share;
                    format!(
                        "component {axis}: bringing the ground to rest took {percent:.0} % of the peak acceleration; \
                         remove the offset, or filter, before"
                    )
                })
            }
            "filter" => {
                let (axis, share) = worst(&|entry| number(entry, "cut_over_peak"))?;
                (share > CUT_SHARE).then(|| {
                    let percent = 100.0 * share;
                    format!(
                        "component {axis}: {percent:.0} % of the filtered peak fell outside the record's time and was \
                         cut; taper or pad before, or keep the pads"
                    )
                })
            }
            _ => None,
        }
    }
}

/// Share of the peak above which a correction to rest is told.
const REST_SHARE: f64 = 0.1;

/// Share of the peak above which a filter's response that was cut off is told.
const CUT_SHARE: f64 = 0.05;
