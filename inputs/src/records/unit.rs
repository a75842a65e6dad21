//! Units that a sample of a record may have.

use std::fmt;
use std::str::FromStr;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::error::InputError;
use crate::motion::{Quantity, STANDARD_GRAVITY};

/// What one sample value of a record means.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
pub enum Unit {
    /// m/s².
    #[serde(rename = "m/s2")]
    MetrePerSecond2,
    /// cm/s².
    #[serde(rename = "cm/s2")]
    CentimetrePerSecond2,
    /// Gal, the same as cm/s².
    #[serde(rename = "gal")]
    Gal,
    /// Standard gravity, 9.80665 m/s².
    #[serde(rename = "g")]
    G,
    /// A tenth of standard gravity.
    #[serde(rename = "g/10")]
    TenthG,
    /// mm/s².
    #[serde(rename = "mm/s2")]
    MillimetrePerSecond2,
    /// nm/s².
    #[serde(rename = "nm/s2")]
    NanometrePerSecond2,
    /// m/s.
    #[serde(rename = "m/s")]
    MetrePerSecond,
    /// cm/s.
    #[serde(rename = "cm/s")]
    CentimetrePerSecond,
    /// mm/s.
    #[serde(rename = "mm/s")]
    MillimetrePerSecond,
    /// nm/s.
    #[serde(rename = "nm/s")]
    NanometrePerSecond,
    /// m.
    #[serde(rename = "m")]
    Metre,
    /// cm.
    #[serde(rename = "cm")]
    Centimetre,
    /// mm.
    #[serde(rename = "mm")]
    Millimetre,
    /// nm.
    #[serde(rename = "nm")]
    Nanometre,
}

impl Unit {
    /// All units, in the order in which messages list them.
    pub const ALL: [Self; 15] = [
        Self::MetrePerSecond2,
        Self::CentimetrePerSecond2,
        Self::Gal,
        Self::G,
        Self::TenthG,
        Self::MillimetrePerSecond2,
        Self::NanometrePerSecond2,
        Self::MetrePerSecond,
        Self::CentimetrePerSecond,
        Self::MillimetrePerSecond,
        Self::NanometrePerSecond,
        Self::Metre,
        Self::Centimetre,
        Self::Millimetre,
        Self::Nanometre,
    ];

    /// The word that stands for the unit in scene files.
    #[must_use]
    pub fn symbol(self) -> &'static str {
        match self {
            Self::MetrePerSecond2 => "m/s2",
            Self::CentimetrePerSecond2 => "cm/s2",
            Self::Gal => "gal",
            Self::G => "g",
            Self::TenthG => "g/10",
            Self::MillimetrePerSecond2 => "mm/s2",
            Self::NanometrePerSecond2 => "nm/s2",
            Self::MetrePerSecond => "m/s",
            Self::CentimetrePerSecond => "cm/s",
            Self::MillimetrePerSecond => "mm/s",
            Self::NanometrePerSecond => "nm/s",
            Self::Metre => "m",
            Self::Centimetre => "cm",
            Self::Millimetre => "mm",
            Self::Nanometre => "nm",
        }
    }

    /// One of this unit in SI: multiply stored values by it.
    #[must_use]
    pub fn factor(self) -> f64 {
        match self {
            Self::MetrePerSecond2 | Self::MetrePerSecond | Self::Metre => 1.0,
            Self::CentimetrePerSecond2 | Self::Gal | Self::CentimetrePerSecond | Self::Centimetre => 1e-2,
            Self::G => STANDARD_GRAVITY,
            Self::TenthG => 0.980665,
            Self::MillimetrePerSecond2 | Self::MillimetrePerSecond | Self::Millimetre => 1e-3,
            Self::NanometrePerSecond2 | Self::NanometrePerSecond | Self::Nanometre => 1e-9,
        }
    }

    /// What the unit measures.
    #[must_use]
    pub fn quantity(self) -> Quantity {
        match self {
            Self::MetrePerSecond2
            | Self::CentimetrePerSecond2
            | Self::Gal
            | Self::G
            | Self::TenthG
            | Self::MillimetrePerSecond2
            | Self::NanometrePerSecond2 => Quantity::Acceleration,
            Self::MetrePerSecond
            | Self::CentimetrePerSecond
            | Self::MillimetrePerSecond
            | Self::NanometrePerSecond => Quantity::Velocity,
            Self::Metre | Self::Centimetre | Self::Millimetre | Self::Nanometre => Quantity::Displacement,
        }
    }

    /// All words, comma-separated, for messages.
    #[must_use]
    pub fn choices() -> String {
        Self::ALL.map(Self::symbol).join(", ")
    }
}

impl fmt::Display for Unit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.symbol())
    }
}

impl FromStr for Unit {
    type Err = InputError;

    /// Reads a unit's word; `m/s^2` and `m/s²` are understood like `m/s2`, `Gal` like `gal`.
    fn from_str(text: &str) -> Result<Self, InputError> {
        let plain = text.trim().replace('^', "").replace('²', "2");
        Self::ALL
            .into_iter()
            .find(|unit| unit.symbol() == plain || (*unit == Self::Gal && plain == "Gal"))
            .ok_or_else(|| InputError::UnitUnknown { found: text.to_string(), choices: Self::choices() })
    }
}
