//! The steps of processing that an engineer asks for, in order, by scene, command line or code.

use std::fmt;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value, json};

use super::matching::Matching;
use super::trend::TREND_ORDER_TO;
use super::{AXES, Filter, Motion, Quantity, Scaling, Step, filter, processing, resampling, rest, trend};
use crate::error::InputError;
use crate::number::plain;

/// One step of processing, as it is written in a scene (`motion.process`) or after `--process`.
///
/// Each acts on all components of a [`Motion`] and leaves a [`Step`] whose `parameters` repeat it
/// exactly ([`Process::from_step`]). Times in s from the motion's first sample, frequencies in Hz, samples
/// in SI. An error leaves the motion as it was.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "step", rename_all = "snake_case", deny_unknown_fields)]
#[schemars(extend("x-section" = true))]
pub enum Process {
    /// Subtract from each component its mean, over the whole record or over its first seconds, which should come before
    /// the first arrival. An acceleration whose offset is within 5 % of ±1 g carries gravity; it is taken off,
    /// and said.
    ///
    /// $x_i \leftarrow x_i - \frac1m\sum_{j<m} x_j$, m the samples averaged.
    Demean {
        /// Time from the start to average over, at most the record's length.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        #[schemars(extend("exclusiveMinimum" = 0.0, "x-unit" = "s", "x-default" = "the whole record"))]
        first_seconds: Option<f64>,
    },
    /// Subtract from each component its least-squares polynomial of the samples, constant term included.
    ///
    /// $x_i \leftarrow x_i - \sum_{k=0}^{m} c_k t_i^k$ with $\min_c \sum_i (x_i - \sum_k c_k t_i^k)^2$; two samples more
    /// than the order, or more.
    Detrend {
        /// Order of the polynomial; 1 is a straight line.
        #[schemars(extend("minimum" = 1, "maximum" = TREND_ORDER_TO, "x-unit" = "1"))]
        order: usize,
    },
    /// Take a drift of the velocity off the acceleration: the least-squares polynomial of the velocity, without a
    /// constant term so that the velocity still starts from 0, is differentiated and subtracted. Needs an acceleration.
    /// It lessens a drift; `rest` ends it.
    ///
    /// $\min_c \sum_i (v_i - \sum_{k=1}^{m} c_k t_i^k)^2$ with v the spectral integral from rest, then
    /// $a_i \leftarrow a_i - \sum_{k=1}^{m} k\,c_k t_i^{k-1}$.
    Baseline {
        /// Order of the velocity's polynomial; 1 takes off a constant acceleration.
        #[schemars(extend("minimum" = 1, "maximum" = TREND_ORDER_TO, "x-unit" = "1"))]
        order: usize,
    },
    /// Bring the ends to zero with half-cosines.
    ///
    /// Gain $\frac12(1 - \cos(\pi t/T))$ for t below T = `start`, likewise over `end` from the last sample backwards.
    Taper {
        /// Length of the taper at the start; 0 leaves the start alone. Both together fit into the record.
        #[serde(default)]
        #[schemars(extend("minimum" = 0.0, "x-unit" = "s"))]
        start: f64,
        /// Length of the taper at the end; 0 leaves the end alone.
        #[serde(default)]
        #[schemars(extend("minimum" = 0.0, "x-unit" = "s"))]
        end: f64,
    },
    /// Butterworth filter: high-pass with `f_min`, low-pass with `f_max`, band-pass with both. Forth and back: no phase
    /// shift, −6 dB at the corners, twice the fall-off; with `causal` one pass, −3 dB at the corners. The record is
    /// continued with zeros, 1.5·order/f_min s on either side, for the response to run out into.
    Filter(Filter),
    /// Turn the horizontal axes about the vertical. Needs both horizontals.
    ///
    /// $x' = x\cos\theta + y\sin\theta$, $y' = -x\sin\theta + y\cos\theta$; exact at multiples of 90°.
    Rotate {
        /// Angle θ from the old x axis to the new one, counter-clockwise seen from above.
        #[schemars(extend("x-unit" = "degrees"))]
        angle: f64,
    },
    /// Keep the samples from one time to another, both counted from the first sample; the start time moves along.
    Trim {
        /// First time that is kept.
        #[serde(default)]
        #[schemars(extend("minimum" = 0.0, "x-unit" = "s"))]
        from: f64,
        /// Last time that is kept, above `from` and within the record.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        #[schemars(extend("exclusiveMinimum" = 0.0, "x-unit" = "s", "x-default" = "the record's end"))]
        to: Option<f64>,
    },
    /// Add zeros, rounded to whole steps; the start time moves along.
    Pad {
        /// Time of zeros before the record.
        #[serde(default)]
        #[schemars(extend("minimum" = 0.0, "x-unit" = "s"))]
        before: f64,
        /// Time of zeros after the record.
        #[serde(default)]
        #[schemars(extend("minimum" = 0.0, "x-unit" = "s"))]
        after: f64,
    },
    /// Go to another time step by band-limited interpolation. To a coarser step a zero-phase low-pass comes first, flat
    /// to 0.8 of the new Nyquist frequency, a half-cosine down to zero at it: nothing is folded back. The first sample
    /// stays, the last is the last that fits.
    ///
    /// $x(t) = \frac1M\sum_m X_m e^{i2\pi mt/(M\,dt)}$ of the record and 20 s or more of zeros, on a period that holds
    /// whole numbers of both steps. The old step over the new one is p/q to 1e-9 with p and q up to 10000;
    /// a step without such a ratio is refused with the nearest ones.
    Resample {
        /// New time step.
        #[schemars(extend("exclusiveMinimum" = 0.0, "x-unit" = "s"))]
        dt: f64,
    },
    /// Multiply all components by one factor: `factor` itself, or the one that brings the largest component to a peak
    /// acceleration `pga`, a peak velocity `pgv`, or a pseudo-spectral acceleration `sa` at `period` and `damping`.
    Scale(Scaling),
    /// Match each component to a design spectrum by adding wavelets in the time domain.
    Match(Matching),
    /// Bring the ground to rest at the end, velocity and displacement both zero, by the smallest smooth correction of the
    /// acceleration. Needs an acceleration. It mends a remainder, not a record: look at `correction_over_peak` in the
    /// step.
    ///
    /// $a \leftarrow a + c$, $c = \sin^2(\pi t/T)\,(\alpha + \beta\,(2t/T - 1))$ with α and β such that $v(T) = d(T) = 0$
    /// from rest at t = 0, by the program's own integration (to round-off). c is zero with its slope at both ends; of
    /// all corrections that do it, it is the one of least $\int c^2/\sin^2(\pi t/T)\,dt$. 8 samples or more.
    Rest {},
    /// Integrate or differentiate in the frequency domain. An integral starts from rest; nothing is removed, so an
    /// offset becomes a drift. A motion of another quantity becomes an acceleration in the end without this step.
    ///
    /// $X_m \leftarrow (i\omega_m)^p X_m$; see [`resample_as`](super::resample_as).
    Convert {
        /// The quantity to go to.
        to: Quantity,
    },
}

/// Largest sample (SI) that a step may leave, far beyond any motion: sums of squares of such samples are still numbers.
pub(super) const PEAK_TO: f64 = 1e30;

/// Refuses a number of a step: what would do, and what to do about it.
pub(super) fn refuse<T>(
    step: &'static str,
    parameter: &'static str,
    found: f64,
    expected: impl Into<String>,
    remedy: impl Into<String>,
) -> Result<T, InputError> {
    Err(InputError::StepParameter {
        step,
        parameter,
        found,
        expected: expected.into(),
        remedy: remedy.into(),
    })
}

/// Refuses a motion that a step cannot act on, or a step that lacks something.
pub(super) fn unfit<T>(
    step: &'static str,
    problem: impl Into<String>,
    remedy: &'static str,
) -> Result<T, InputError> {
    Err(InputError::StepUnfit { step, problem: problem.into(), remedy })
}

/// Refuses a motion of another quantity than the one that a step is made for.
pub(super) fn refuse_quantity(
    step: &'static str,
    found: Quantity,
    wanted: Quantity,
) -> Result<(), InputError> {
    if found == wanted {
        return Ok(());
    }
    let problem = format!("the motion is a {found}; the step acts on an {wanted}");
    unfit(step, problem, "put { step = \"convert\", to = \"acceleration\" } before it")
}

/// Runs a change over each component that there is; what it says stands under the axis' name.
pub(super) fn per_component(
    motion: &mut Motion,
    mut change: impl FnMut(usize, &mut Vec<f64>) -> Value,
) -> Map<String, Value> {
    let mut found = Map::new();
    for (axis, samples) in motion.components.iter_mut().enumerate() {
        if let Some(samples) = samples {
            found.insert(AXES[axis].to_string(), change(axis, samples));
        }
    }
    found
}

impl Process {
    /// The words of all steps, as a scene writes them.
    pub const WORDS: [&'static str; 13] = [
        "demean", "detrend", "baseline", "taper", "filter", "rotate", "trim", "pad", "resample", "scale",
        "match", "rest", "convert",
    ];

    /// The step's word, which is also the name of the [`Step`] that it leaves.
    #[must_use]
    pub fn word(&self) -> &'static str {
        match self {
            Self::Demean { .. } => "demean",
            Self::Detrend { .. } => "detrend",
            Self::Baseline { .. } => "baseline",
            Self::Taper { .. } => "taper",
            Self::Filter(_) => "filter",
            Self::Rotate { .. } => "rotate",
            Self::Trim { .. } => "trim",
            Self::Pad { .. } => "pad",
            Self::Resample { .. } => "resample",
            Self::Scale(_) => "scale",
            Self::Match(_) => "match",
            Self::Rest {} => "rest",
            Self::Convert { .. } => "convert",
        }
    }

    /// Whether the step mends what an instrument leaves (offset, trend, drift) and so acts on records only, not on a
    /// pulse with a closed form.
    #[must_use]
    pub fn mends_an_instrument(&self) -> bool {
        matches!(self, Self::Demean { .. } | Self::Detrend { .. } | Self::Baseline { .. })
    }

    /// Does the step and records it.
    ///
    /// Errors: [`InputError::StepParameter`] for a number that cannot be, alone or with this motion (a corner
    /// at Nyquist, a time outside the record); [`InputError::StepUnfit`] for a motion that the step
    /// cannot act on. The motion is then as before.
    pub fn apply(&self, motion: &mut Motion) -> Result<(), InputError> {
        let before = Motion { steps: Vec::new(), ..motion.clone() };
        let found = self.change(motion).and_then(|found| {
            let sound = motion.components.iter().flatten().flatten().all(|value| value.abs() <= PEAK_TO);
            match sound {
                true => Ok(found),
                false => unfit(
                    self.word(),
                    format!("samples would exceed {} {}", plain(PEAK_TO), motion.quantity.si_unit()),
                    "check the unit of the record and the step's numbers",
                ),
            }
        });
        match found {
            Ok(found) => {
                let step = Step::new(self.word(), Value::Object(self.parameters()));
                motion.steps.push(step.with_found(Value::Object(found)));
                Ok(())
            }
            Err(error) => {
                let steps = std::mem::take(&mut motion.steps);
                *motion = Motion { steps, ..before };
                Err(error)
            }
        }
    }

    fn change(&self, motion: &mut Motion) -> Result<Map<String, Value>, InputError> {
        match self {
            Self::Demean { first_seconds } => processing::demean(motion, *first_seconds),
            Self::Detrend { order } => trend::detrend(motion, *order),
            Self::Baseline { order } => trend::baseline(motion, *order),
            Self::Taper { start, end } => processing::taper(motion, *start, *end),
            Self::Filter(asked) => filter::filter(motion, asked),
            Self::Rotate { angle } => processing::rotate(motion, *angle),
            Self::Trim { from, to } => processing::trim(motion, *from, *to),
            Self::Pad { before, after } => processing::pad(motion, *before, *after),
            Self::Resample { dt } => resampling::resample(motion, *dt),
            Self::Scale(scaling) => scaling.apply(motion),
            Self::Match(matching) => {
                matching.apply(motion)?;
                // It has recorded itself; what it found goes into the one step of this process.
                Ok(motion.steps.pop().map(|step| step.found).unwrap_or_default())
            }
            Self::Rest {} => rest::rest(motion),
            Self::Convert { to } => Ok(processing::convert(motion, *to)),
        }
    }

    /// The step's keys with all defaults written out, without its word.
    fn parameters(&self) -> Map<String, Value> {
        // Every variant is a table of numbers, words and tables of such: it has a JSON form.
        let mut all = match serde_json::to_value(self) {
            Ok(Value::Object(all)) => all,
            _ => Map::new(),
        };
        all.shift_remove("step");
        all
    }

    /// The process that a step records; `None` for a step of reading, or one that is not of this program.
    ///
    /// Applied to the same samples it gives the same samples, bit for bit.
    #[must_use]
    pub fn from_step(step: &Step) -> Option<Self> {
        let mut all = Map::from_iter([("step".to_string(), json!(step.name))]);
        all.extend(step.parameters.clone());
        serde_json::from_value(Value::Object(all)).ok()
    }

    /// The step as an inline table of a scene, `{ step = "filter", f_min = 0.1, … }`.
    #[must_use]
    pub fn to_toml(&self) -> String {
        let head = Map::from_iter([("step".to_string(), json!(self.word()))]);
        inline(&Value::Object(head.into_iter().chain(self.parameters()).collect()))
    }
}

/// A JSON value as TOML on one line.
fn inline(value: &Value) -> String {
    match value {
        Value::Object(map) if map.is_empty() => "{}".to_owned(),
        Value::Object(map) => {
            let entries: Vec<String> = map.iter().map(|(key, v)| format!("{key} = {}", inline(v))).collect();
            format!("{{ {} }}", entries.join(", "))
        }
        Value::Array(list) => {
            let entries: Vec<String> = list.iter().map(inline).collect();
            format!("[{}]", entries.join(", "))
        }
        // Numbers, texts and truth values are written alike in both.
        other => other.to_string(),
    }
}

impl fmt::Display for Process {
    /// As `--process` takes it: `filter f_min=0.1 f_max=25.0 order=4 causal=false keep_pads=false`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.word())?;
        for (key, value) in self.parameters() {
            match &value {
                Value::String(word) => write!(f, " {key}={word}")?,
                other => write!(f, " {key}={}", inline(other))?,
            }
        }
        Ok(())
    }
}
