//! What a motion's samples are.

use std::fmt;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What the samples of a motion are; SI units throughout.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Quantity {
    /// m/s².
    Acceleration,
    /// m/s.
    Velocity,
    /// m.
    Displacement,
}

impl Quantity {
    /// SI unit, as it is printed: `m/s²`, `m/s`, `m`.
    #[must_use]
    pub fn si_unit(self) -> &'static str {
        match self {
            Self::Acceleration => "m/s²",
            Self::Velocity => "m/s",
            Self::Displacement => "m",
        }
    }

    /// Number of time derivatives above displacement: 2, 1, 0.
    #[must_use]
    pub fn derivative_order(self) -> i32 {
        match self {
            Self::Acceleration => 2,
            Self::Velocity => 1,
            Self::Displacement => 0,
        }
    }

    /// Smallest and largest peak (SI) that a file's own unit may give before it is disbelieved.
    ///
    /// Acceleration 1e-4 to 30 m/s²; velocity 1e-6 to 10 m/s; displacement 1e-8 to 30 m. The largest
    /// recorded ground motions (about 4 g, 3 m/s, 10 m) lie inside.
    #[must_use]
    pub fn plausible_peak(self) -> (f64, f64) {
        match self {
            Self::Acceleration => (1e-4, 30.0),
            Self::Velocity => (1e-6, 10.0),
            Self::Displacement => (1e-8, 30.0),
        }
    }

    /// The same with a key-friendly unit suffix: `m_s2`, `m_s`, `m`.
    pub(crate) fn key_suffix(self) -> &'static str {
        match self {
            Self::Acceleration => "m_s2",
            Self::Velocity => "m_s",
            Self::Displacement => "m",
        }
    }
}

impl fmt::Display for Quantity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Acceleration => "acceleration",
            Self::Velocity => "velocity",
            Self::Displacement => "displacement",
        })
    }
}
