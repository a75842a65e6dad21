//! Design spectra of codes and of users: the targets that a motion is compared with or matched to.

use std::f64::consts::TAU;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::error::InputError;
use crate::motion::STANDARD_GRAVITY;

/// Direction of a component; codes give the vertical one a spectrum of its own.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Direction {
    /// Along x or y.
    Horizontal,
    /// Along z.
    Vertical,
}

/// A pseudo-acceleration spectrum given by a code or point by point.
///
/// In a scene it is a table whose `kind` names the source:
/// ```
/// # use hati_inputs::measures::DesignSpectrum;
/// let text = r#"{ "kind": "rg160", "pga": 2.0, "damping": 0.05 }"#;
/// let spectrum: DesignSpectrum = serde_json::from_str(text).unwrap();
/// assert!((spectrum.psa(1.0 / 9.0) - 2.61 * 2.0).abs() < 1e-12);
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum DesignSpectrum {
    /// US NRC Regulatory Guide 1.60.
    Rg160(Rg160),
    /// EN 1998-1:2004, elastic.
    Eurocode8(Eurocode8),
    /// Points of the user.
    Points(SpectrumPoints),
}

fn five_percent() -> f64 {
    0.05
}

/// Design response spectrum of US NRC Regulatory Guide 1.60.
///
/// Control points A (33 Hz), B (9 Hz), C (2.5 Hz horizontal, 3.5 Hz vertical) and D (0.25 Hz). A, B and
/// C multiply the peak horizontal ground acceleration; D multiplies the peak horizontal ground
/// displacement, 36 in (0.9144 m) for 1 g: `PSA_D = D · 0.9144 m · (pga/g) · (2π 0.25 Hz)²`. Between
/// them straight lines on logarithmic axes; above 33 Hz PSA = PGA (the vertical one has A = 1 too, of the
/// horizontal PGA); below 0.25 Hz the displacement is constant, PSA ∝ 1/T².
/// For a damping ratio between two rows the factors are interpolated linearly, as the guide asks.
///
/// | damping, % | horizontal A, B, C, D | vertical A, B, C, D |
/// |---|---|---|
/// | 0.5 | 1, 4.96, 5.95, 3.20 | 1, 4.96, 5.67, 2.13 |
/// | 2 | 1, 3.54, 4.25, 2.50 | 1, 3.54, 4.05, 1.67 |
/// | 5 | 1, 2.61, 3.13, 2.05 | 1, 2.61, 2.98, 1.37 |
/// | 7 | 1, 2.27, 2.72, 1.88 | 1, 2.27, 2.59, 1.25 |
/// | 10 | 1, 1.90, 2.28, 1.70 | 1, 1.90, 2.17, 1.13 |
///
/// All forty numbers, the control frequencies and the 36 in agree with those in a public
/// soil-structure interaction program that cites tables I and II of revision 2; the control
/// frequencies, the 36 in, the line at constant displacement below 0.25 Hz and the ratio 2/3 of the
/// vertical to the horizontal spectrum there (held by the D column) also with a structural program's
/// manual that relates the guide. They were not compared with the guide's own pages.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Rg160 {
    /// Peak horizontal ground acceleration, also for the vertical spectrum.
    #[schemars(extend("exclusiveMinimum" = 0.0, "x-unit" = "m/s²"))]
    pub pga: f64,
    /// Damping ratio, 0.005 to 0.10; factors between the rows of the guide's tables lie on straight lines.
    #[serde(default = "five_percent")]
    #[schemars(extend("minimum" = 0.005, "maximum" = 0.1, "x-unit" = "1"))]
    pub damping: f64,
    /// Whose spectrum; absent: that of the component (z vertical), horizontal where there is none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub direction: Option<Direction>,
}

/// Damping ratio; factors B, C, D of the horizontal and of the vertical spectrum (A is 1).
type Rg160Row = (f64, [f64; 3], [f64; 3]);

const RG160_ROWS: [Rg160Row; 5] = [
    (0.005, [4.96, 5.95, 3.20], [4.96, 5.67, 2.13]),
    (0.02, [3.54, 4.25, 2.50], [3.54, 4.05, 1.67]),
    (0.05, [2.61, 3.13, 2.05], [2.61, 2.98, 1.37]),
    (0.07, [2.27, 2.72, 1.88], [2.27, 2.59, 1.25]),
    (0.10, [1.90, 2.28, 1.70], [1.90, 2.17, 1.13]),
];

/// Peak ground displacement that goes with 1 g in Regulatory Guide 1.60: 36 in, m.
const RG160_DISPLACEMENT: f64 = 0.9144;

impl Rg160 {
    /// Factors of the damping ratio, straight lines in damping between the rows.
    fn factors(&self) -> Option<Rg160Row> {
        let between = |pair: &&[Rg160Row]| pair[0].0 <= self.damping && self.damping <= pair[1].0;
        let [low, high] = RG160_ROWS.windows(2).find(between)? else { return None };
        let share = (self.damping - low.0) / (high.0 - low.0);
        let between = |a: [f64; 3], b: [f64; 3]| [0, 1, 2].map(|i| a[i] + share * (b[i] - a[i]));
        Some((self.damping, between(low.1, high.1), between(low.2, high.2)))
    }

    /// Control points by increasing period: s and m/s².
    fn control_points(&self) -> Option<[(f64, f64); 4]> {
        let (_, horizontal, vertical) = self.factors()?;
        let (factors, corner) = match self.direction.unwrap_or(Direction::Horizontal) {
            Direction::Horizontal => (horizontal, 2.5),
            Direction::Vertical => (vertical, 3.5),
        };
        let displacement = factors[2] * RG160_DISPLACEMENT * self.pga / STANDARD_GRAVITY;
        let at_d = displacement * (TAU * 0.25).powi(2);
        let [at_b, at_c] = [factors[0] * self.pga, factors[1] * self.pga];
        Some([(1.0 / 33.0, self.pga), (1.0 / 9.0, at_b), (1.0 / corner, at_c), (4.0, at_d)])
    }

    fn psa(&self, period: f64) -> f64 {
        let Some(points) = self.control_points() else { return f64::NAN };
        let (last, at_last) = points[3];
        if period > last { at_last * (last / period).powi(2) } else { log_log(&points, period) }
    }
}

/// Number of an Eurocode 8 elastic spectrum.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(try_from = "u8", into = "u8")]
#[schemars(with = "u8", extend("enum" = [1, 2]))]
pub enum SpectrumType {
    /// Type 1, where earthquakes of surface-wave magnitude above 5.5 govern.
    One,
    /// Type 2, where smaller ones do.
    Two,
}

impl TryFrom<u8> for SpectrumType {
    type Error = String;

    fn try_from(number: u8) -> Result<Self, String> {
        match number {
            1 => Ok(Self::One),
            2 => Ok(Self::Two),
            other => Err(format!("type {other}: Eurocode 8 has elastic spectra of type 1 and 2")),
        }
    }
}

impl From<SpectrumType> for u8 {
    fn from(kind: SpectrumType) -> Self {
        match kind {
            SpectrumType::One => 1,
            SpectrumType::Two => 2,
        }
    }
}

/// Ground type of EN 1998-1 table 3.1.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum Ground {
    /// Rock.
    A,
    /// Very dense sand, gravel, very stiff clay.
    B,
    /// Deep deposits of dense or medium-dense sand, gravel or stiff clay.
    C,
    /// Loose to medium cohesionless soil, soft to firm cohesive soil.
    D,
    /// A layer of type C or D, 5 m to 20 m thick, on stiffer material.
    E,
}

/// Elastic response spectrum of EN 1998-1:2004, 3.2.2.2 (horizontal) and 3.2.2.3 (vertical).
///
/// With η = max(√(10/(5 + ξ)), 0.55), ξ the damping in per cent:
///
/// | period | horizontal `S_e/(a_g S)` | vertical `S_ve/a_vg` |
/// |---|---|---|
/// | 0 to T_B | 1 + T/T_B (2.5 η − 1) | 1 + T/T_B (3 η − 1) |
/// | T_B to T_C | 2.5 η | 3 η |
/// | T_C to T_D | 2.5 η T_C/T | 3 η T_C/T |
/// | from T_D | 2.5 η T_C T_D/T² | 3 η T_C T_D/T² |
///
/// S, T_B, T_C, T_D from tables 3.2 and 3.3 (recommended values, no national annex); vertical: a_vg/a_g
/// = 0.90 (type 1) and 0.45 (type 2), T_B = 0.05 s, T_C = 0.15 s, T_D = 1.0 s (table 3.4), whatever the
/// ground. The standard's formula ends at 4 s; here it goes on with constant displacement, which is not
/// below the standard's informative annex A.
///
/// All numbers of the three tables agree with those of a public seismology library; the row of
/// ground C for type 2, and table 3.4 for type 2, also with a finite-element vendor's example. They were not
/// compared with the standard's own pages.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Eurocode8 {
    /// Design ground acceleration on type A ground, a_g.
    #[schemars(extend("exclusiveMinimum" = 0.0, "x-unit" = "m/s²"))]
    pub ag: f64,
    /// 1 or 2.
    #[serde(rename = "type")]
    pub spectrum_type: SpectrumType,
    /// Ground type.
    pub ground: Ground,
    /// Damping ratio.
    #[serde(default = "five_percent")]
    #[schemars(extend("exclusiveMinimum" = 0.0, "x-unit" = "1"))]
    pub damping: f64,
    /// Whose spectrum; absent: that of the component (z vertical), horizontal where there is none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub direction: Option<Direction>,
}

impl Eurocode8 {
    /// Soil factor S and corner periods T_B, T_C, T_D (s) of the horizontal spectrum.
    fn horizontal(&self) -> [f64; 4] {
        use Ground::{A, B, C, D, E};
        match (self.spectrum_type, self.ground) {
            (SpectrumType::One, A) => [1.0, 0.15, 0.4, 2.0],
            (SpectrumType::One, B) => [1.2, 0.15, 0.5, 2.0],
            (SpectrumType::One, C) => [1.15, 0.20, 0.6, 2.0],
            (SpectrumType::One, D) => [1.35, 0.20, 0.8, 2.0],
            (SpectrumType::One, E) => [1.4, 0.15, 0.5, 2.0],
            (SpectrumType::Two, A) => [1.0, 0.05, 0.25, 1.2],
            (SpectrumType::Two, B) => [1.35, 0.05, 0.25, 1.2],
            (SpectrumType::Two, C) => [1.5, 0.10, 0.25, 1.2],
            (SpectrumType::Two, D) => [1.8, 0.10, 0.30, 1.2],
            (SpectrumType::Two, E) => [1.6, 0.05, 0.25, 1.2],
        }
    }

    fn psa(&self, period: f64) -> f64 {
        let eta = (10.0 / (5.0 + 100.0 * self.damping)).sqrt().max(0.55);
        let (ground, plateau, [t_b, t_c, t_d]) = match self.direction.unwrap_or(Direction::Horizontal) {
            Direction::Horizontal => {
                let [s, t_b, t_c, t_d] = self.horizontal();
                (self.ag * s, 2.5 * eta, [t_b, t_c, t_d])
            }
            Direction::Vertical => {
                let share = if self.spectrum_type == SpectrumType::One { 0.90 } else { 0.45 };
                (self.ag * share, 3.0 * eta, [0.05, 0.15, 1.0])
            }
        };
        let shape = if period < t_b {
            1.0 + period / t_b * (plateau - 1.0)
        } else if period < t_c {
            plateau
        } else if period < t_d {
            plateau * t_c / period
        } else {
            plateau * t_c * t_d / (period * period)
        };
        ground * shape
    }
}

/// A spectrum given point by point, straight lines between the points on logarithmic axes.
///
/// Before the first point PSA is constant; after the last the displacement is (PSA ∝ 1/T²). It holds for
/// whatever component it is used on.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SpectrumPoints {
    /// Periods, positive and increasing, at least two.
    #[schemars(extend("x-unit" = "s"))]
    pub periods: Vec<f64>,
    /// Pseudo-accelerations beside them, positive.
    #[schemars(extend("x-unit" = "m/s²"))]
    pub psa: Vec<f64>,
    /// Damping ratio for which they hold.
    #[serde(default = "five_percent")]
    #[schemars(extend("exclusiveMinimum" = 0.0, "x-unit" = "1"))]
    pub damping: f64,
}

impl SpectrumPoints {
    fn psa(&self, period: f64) -> f64 {
        let points: Vec<(f64, f64)> = self.periods.iter().copied().zip(self.psa.iter().copied()).collect();
        let Some(&(last, at_last)) = points.last() else { return f64::NAN };
        if period > last { at_last * (last / period).powi(2) } else { log_log(&points, period) }
    }
}

/// Straight lines between points on logarithmic axes; constant before the first and after the last.
fn log_log(points: &[(f64, f64)], x: f64) -> f64 {
    let next = points.partition_point(|point| point.0 < x);
    match (next.checked_sub(1).map(|i| points[i]), points.get(next)) {
        (Some((x0, y0)), Some((x1, y1))) => y0 * (y1 / y0).powf((x / x0).ln() / (x1 / x0).ln()),
        (Some((_, y)), None) => y,
        (None, Some((_, y))) => *y,
        (None, None) => f64::NAN,
    }
}

impl DesignSpectrum {
    /// Pseudo-acceleration at a period (s), m/s²; 0 s gives the plateau at short periods.
    ///
    /// Not a number for a spectrum that [`DesignSpectrum::check`] refuses.
    #[must_use]
    pub fn psa(&self, period: f64) -> f64 {
        match self {
            Self::Rg160(spectrum) => spectrum.psa(period),
            Self::Eurocode8(spectrum) => spectrum.psa(period),
            Self::Points(spectrum) => spectrum.psa(period),
        }
    }

    /// Damping ratio for which the spectrum holds.
    #[must_use]
    pub fn damping(&self) -> f64 {
        match self {
            Self::Rg160(spectrum) => spectrum.damping,
            Self::Eurocode8(spectrum) => spectrum.damping,
            Self::Points(spectrum) => spectrum.damping,
        }
    }

    /// The same spectrum for a component (0 = x, 1 = y, 2 = z): a direction that is absent becomes the
    /// component's, one that is given stays.
    #[must_use]
    pub fn for_axis(&self, axis: usize) -> Self {
        let own = if axis == 2 { Direction::Vertical } else { Direction::Horizontal };
        let mut spectrum = self.clone();
        match &mut spectrum {
            Self::Rg160(Rg160 { direction, .. }) | Self::Eurocode8(Eurocode8 { direction, .. }) => {
                direction.get_or_insert(own);
            }
            Self::Points(_) => {}
        }
        spectrum
    }

    /// Refuses numbers for which there is no spectrum.
    ///
    /// Errors: an acceleration that is not positive; a damping outside 0.005 to 0.10 (Regulatory
    /// Guide 1.60) or outside 0 to 0.5; points that are fewer than two, not positive, not increasing, or
    /// whose lists differ in length.
    pub fn check(&self) -> Result<(), InputError> {
        match self {
            Self::Rg160(spectrum) => {
                positive("pga", spectrum.pga)?;
                if spectrum.factors().is_none() {
                    let range = "a ratio from 0.005 to 0.10, the range of Regulatory Guide 1.60";
                    return refuse("spectrum.damping", spectrum.damping, range, RATIO);
                }
                Ok(())
            }
            Self::Eurocode8(spectrum) => {
                positive("ag", spectrum.ag)?;
                damping(spectrum.damping)
            }
            Self::Points(SpectrumPoints { periods, psa, damping: ratio }) => {
                let lengths = format!("as many values as periods, {}", periods.len());
                if psa.len() != periods.len() {
                    return refuse("number of spectrum.psa", psa.len() as f64, lengths, PAIRS);
                }
                if periods.len() < 2 {
                    return refuse("number of spectrum.periods", periods.len() as f64, "at least 2", PAIRS);
                }
                for value in periods {
                    positive("periods", *value)?;
                }
                for value in psa {
                    positive("psa", *value)?;
                }
                if let Some(pair) = periods.windows(2).find(|pair| pair[1] <= pair[0]) {
                    let remedy = "sort the points by period, each period once";
                    return refuse(
                        "spectrum.periods",
                        pair[1],
                        format!("a period above {} s", pair[0]),
                        remedy,
                    );
                }
                damping(*ratio)
            }
        }
    }
}

const RATIO: &str = "give a ratio, not per cent: 5 % is 0.05";
const PAIRS: &str = "give one psa (m/s²) for each period (s)";

fn refuse(
    parameter: &'static str,
    found: f64,
    expected: impl Into<String>,
    remedy: &str,
) -> Result<(), InputError> {
    Err(InputError::StepParameter {
        step: "design spectrum",
        parameter,
        found,
        expected: expected.into(),
        remedy: remedy.into(),
    })
}

fn positive(parameter: &'static str, found: f64) -> Result<(), InputError> {
    const SI: &str = "accelerations are in m/s² (0.3 g is 2.942 m/s²), periods in s";
    if found.is_finite() && found > 0.0 {
        Ok(())
    } else {
        refuse(parameter, found, "a positive number (SI)", SI)
    }
}

fn damping(found: f64) -> Result<(), InputError> {
    let within = found > 0.0 && found <= 0.5;
    if within { Ok(()) } else { refuse("spectrum.damping", found, "a ratio above 0 and at most 0.5", RATIO) }
}
