//! One factor for all components of a motion.

use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value, json};

use super::process::{PEAK_TO, refuse, unfit};
use super::{Motion, Quantity};
use crate::error::InputError;
use crate::measures;
use crate::number::{plain, rounded};

/// Damping ratio of the oscillator where none is given.
pub(crate) const SCALING_DAMPING: f64 = 0.05;

/// Smallest peak (SI) that a scaling may leave: the squares of its samples are still above 0.
const PEAK_FROM: f64 = 1e-30;

const STEP: &str = "scale";

/// What the one factor brings about; all components are multiplied by it, whatever their quantity.
///
/// A peak is that of the component where it is largest, before the scaling; the factor is the value
/// asked divided by it. Written with the keys `factor`, `pga`, `pgv` or `sa` with `period` and `damping`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Keys", into = "Keys")]
pub enum Scaling {
    /// Multiply by this number; negative turns the motion over, 0 is refused.
    Factor(f64),
    /// Peak acceleration at the samples, m/s².
    Pga(f64),
    /// Peak velocity at the samples, from rest, m/s. The drift of an offset counts: remove it before.
    Pgv(f64),
    /// Pseudo-spectral acceleration `sa` (m/s²) of the oscillator of this `period` (s) and `damping` (ratio).
    Sa {
        /// Pseudo-spectral acceleration, m/s².
        sa: f64,
        /// Natural period, s.
        period: f64,
        /// Damping ratio, 0 ≤ ζ < 1.
        damping: f64,
    },
}

/// The keys of a scaling as they are written.
#[derive(Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("oneOf" = [
    {"required": ["factor"]}, {"required": ["pga"]}, {"required": ["pgv"]}, {"required": ["sa", "period"]}
]))]
struct Keys {
    /// Multiply by this number; it may be negative, not zero. Give one of `factor`, `pga`, `pgv` and `sa`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("x-unit" = "1"))]
    factor: Option<f64>,
    /// Peak acceleration to reach in the largest component.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0.0, "x-unit" = "m/s²"))]
    pga: Option<f64>,
    /// Peak velocity to reach in the largest component.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0.0, "x-unit" = "m/s"))]
    pgv: Option<f64>,
    /// Pseudo-spectral acceleration to reach in the largest component at `period`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0.0, "x-unit" = "m/s²"))]
    sa: Option<f64>,
    /// Natural period of the oscillator; with `sa`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0.0, "x-unit" = "s", "x-default" = "required with `sa`"))]
    period: Option<f64>,
    /// Damping ratio of the oscillator; with `sa`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("minimum" = 0.0, "exclusiveMaximum" = 1.0, "x-unit" = "1", "x-default" = "0.05 with `sa`"))]
    damping: Option<f64>,
}

impl TryFrom<Keys> for Scaling {
    type Error = String;

    fn try_from(keys: Keys) -> Result<Self, String> {
        let Keys { factor, pga, pgv, sa, period, damping } = keys;
        let scaling = match (factor, pga, pgv, sa, period) {
            (Some(factor), None, None, None, None) => Self::Factor(factor),
            (None, Some(pga), None, None, None) => Self::Pga(pga),
            (None, None, Some(pgv), None, None) => Self::Pgv(pgv),
            (None, None, None, Some(sa), Some(period)) => {
                return Ok(Self::Sa { sa, period, damping: damping.unwrap_or(SCALING_DAMPING) });
            }
            _ => return Err("expected one of factor, pga, pgv and sa, and with sa its period".into()),
        };
        match damping {
            None => Ok(scaling),
            Some(_) => Err("damping belongs to sa".into()),
        }
    }
}

impl From<Scaling> for Keys {
    fn from(scaling: Scaling) -> Self {
        let none = Self { factor: None, pga: None, pgv: None, sa: None, period: None, damping: None };
        match scaling {
            Scaling::Factor(factor) => Self { factor: Some(factor), ..none },
            Scaling::Pga(pga) => Self { pga: Some(pga), ..none },
            Scaling::Pgv(pgv) => Self { pgv: Some(pgv), ..none },
            Scaling::Sa { sa, period, damping } => {
                Self { sa: Some(sa), period: Some(period), damping: Some(damping), ..none }
            }
        }
    }
}

impl JsonSchema for Scaling {
    fn inline_schema() -> bool {
        Keys::inline_schema()
    }

    fn schema_name() -> std::borrow::Cow<'static, str> {
        "Scaling".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        Keys::json_schema(generator)
    }
}

impl Scaling {
    /// The number asked for and the largest one before, with their keys.
    fn asked(&self, motion: &Motion) -> Result<(&'static str, f64, &'static str, f64), InputError> {
        let positive = |parameter: &'static str, value: f64, unit: &str| {
            if value.is_finite() && value > 0.0 {
                return Ok(());
            }
            let remedy = "give it in SI: 0.3 g is 2.942 m/s²";
            refuse(STEP, parameter, value, format!("a positive number in {unit}"), remedy)
        };
        let as_quantity = |to| (0..3).filter_map(move |axis| motion.component_as(axis, to, 1));
        let peak = |to| as_quantity(to).flatten().fold(0.0, |peak: f64, value: f64| peak.max(value.abs()));
        Ok(match *self {
            Self::Factor(factor) => ("factor", factor, "", 1.0),
            Self::Pga(pga) => {
                positive("pga", pga, "m/s²")?;
                ("pga", pga, "pga_before_m_s2", peak(Quantity::Acceleration))
            }
            Self::Pgv(pgv) => {
                positive("pgv", pgv, "m/s")?;
                ("pgv", pgv, "pgv_before_m_s", peak(Quantity::Velocity))
            }
            Self::Sa { sa, period, damping } => {
                positive("sa", sa, "m/s²")?;
                positive("period", period, "s")?;
                if !(0.0..1.0).contains(&damping) {
                    let remedy = "give a ratio, not per cent: 5 % is 0.05";
                    return refuse(STEP, "damping", damping, "a ratio of at least 0 and below 1", remedy);
                }
                let psa = |a: Vec<f64>| measures::psa(&a, motion.dt, &[period], damping)[0];
                let largest = as_quantity(Quantity::Acceleration).map(psa).fold(0.0, f64::max);
                ("sa", sa, "sa_before_m_s2", largest)
            }
        })
    }

    /// Multiplies; returns the factor and what it was taken from.
    pub(super) fn apply(&self, motion: &mut Motion) -> Result<Map<String, Value>, InputError> {
        let (parameter, wanted, key, before) = self.asked(motion)?;
        if before == 0.0 {
            let remedy = "choose another record, or a factor";
            return unfit(
                STEP,
                format!("the motion is zero throughout, so no {parameter} can be reached"),
                remedy,
            );
        }
        let factor = wanted / before;
        // A motion at rest stays at rest, whatever the factor.
        let peak = motion.peak();
        let after = (peak * factor).abs();
        let sound = factor.is_finite() && factor != 0.0;
        if !sound || (peak > 0.0 && !(PEAK_FROM..=PEAK_TO).contains(&after)) {
            let unit = motion.quantity.si_unit();
            let expected = format!(
                "a value that leaves a peak from {} to {} {unit}, not {}",
                plain(PEAK_FROM),
                plain(PEAK_TO),
                rounded(after)
            );
            let remedy = "give the peak or the factor that is meant, in SI";
            return refuse(STEP, parameter, wanted, expected, remedy);
        }
        let samples = motion.components.iter_mut().flatten().flatten();
        samples.for_each(|value| *value *= factor);
        let mut found = Map::from_iter([("factor".to_string(), json!(factor))]);
        if !key.is_empty() {
            found.insert(key.into(), json!(before));
        }
        found.insert(format!("peak_{}", motion.quantity.key_suffix()), json!(motion.peak()));
        Ok(found)
    }
}
