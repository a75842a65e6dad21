//! From the segments of one channel to samples in SI: sound, of a sure unit, plausible.

use serde_json::{Value, json};

use super::formats::{RecordFormat, StoredUnit};
use super::naming::{ACCELEROMETER, axis_hint, instrument};
use super::reader::{Ground, Segment};
use super::unit::Unit;
use super::{Channel, ReadOptions, Recognised, broken, checks, response, sha256};
use crate::error::InputError;
use crate::motion::{Quantity, Step, gravity};

/// Time steps, s, that a file may state without the user's word: 10 kHz to 2 Hz.
const PLAUSIBLE_STEP: (f64, f64) = (1e-4, 0.5);

/// What a header may say of its samples that a user should see beside them.
const FACTS: [&str; 9] = [
    "title",
    "corrected",
    "filter",
    "left_out",
    "sense",
    "azimuth_deg",
    "peak_stated",
    "npts_stated",
    "step_doubt",
];

/// The unit of a vertical channel that counts downwards, turned so that z is up.
fn upward(mut unit: StoredUnit, whole: &Segment) -> StoredUnit {
    if whole.text("sense") == Some("down") {
        unit.factor = -unit.factor;
        unit.text.push_str(", positive down");
    }
    unit
}

/// What the channels of one file have in common.
pub(super) struct Origin<'a> {
    pub(super) file: &'a Recognised<'a>,
    pub(super) format: &'static RecordFormat,
    pub(super) sha256: String,
    pub(super) obspy: &'a str,
    pub(super) warnings: Vec<String>,
    pub(super) options: &'a ReadOptions,
}

impl Origin<'_> {
    /// The channel that these segments make, or the first thing that is wrong with it.
    pub(super) fn channel(&self, members: Vec<Segment>) -> Result<Channel, InputError> {
        let (path, format) = (self.file.source.location.as_path(), self.format);
        let mut whole = checks::join(path, members)?;
        self.time_step(&mut whole)?;
        checks::sound(path, &whole, self.options.accept_clipped)?;
        (format.consistent)(&whole).map_err(|problem| broken(path, format.name, problem))?;

        let removed = self.removed_response(&mut whole)?;
        let given = self.file.source.unit.or(self.options.unit);
        let unit = match &removed {
            Some((_, about)) => response::unit(about).ok_or_else(|| self.response_refused(&whole, "", ""))?,
            None => upward(self.unit(&whole, given)?, &whole),
        };
        let samples: Vec<f64> = match &removed {
            Some((ground, _)) => ground.clone(),
            None => whole.samples.iter().map(|value| value * unit.factor).collect(),
        };
        if given.is_none() {
            self.plausible(&whole, &unit, &samples)?;
        }
        if let Some(expected) = self.options.quantity.filter(|wanted| *wanted != unit.quantity) {
            return Err(InputError::QuantityMismatch {
                path: path.into(),
                channel: whole.id,
                found: unit.quantity,
                expected,
            });
        }
        let mut unit_step = self.unit_step(&whole, &unit, given, removed.as_ref());
        let mean = samples.iter().sum::<f64>() / samples.len() as f64;
        if let Some(sign) = gravity(unit.quantity, mean) {
            unit_step.found.insert("gravity_g".into(), json!(sign));
        }
        let steps = vec![self.read_step(&whole), unit_step];
        Ok(Channel {
            file: path.into(),
            format: format.name,
            start: (whole.start_ns != 0).then_some(whole.start_ns as f64 * 1e-9),
            dt: whole.dt,
            samples,
            quantity: unit.quantity,
            unit_stored: unit.text,
            axis_hint: axis_hint(&whole),
            steps,
            sha256: self.sha256.clone(),
            id: whole.id,
        })
    }

    /// The step that was given, for a file that states none.
    fn time_step(&self, whole: &mut Segment) -> Result<(), InputError> {
        let (path, channel) = (self.file.source.location.clone(), whole.id.clone());
        let stated = whole.flag("dt_stated") != Some(false);
        match self.file.source.dt {
            None if stated => {
                let (low, high) = PLAUSIBLE_STEP;
                if !(low..=high).contains(&whole.dt) {
                    return Err(InputError::StepImplausible { path, channel, dt: whole.dt, low, high });
                }
            }
            None => return Err(self.step_missing(whole, None)),
            Some(given) if !(given.is_finite() && given > 0.0) => {
                return Err(InputError::BadStep { path, channel, dt: given });
            }
            Some(given) if stated && (given - whole.dt).abs() > 1e-6 * whole.dt => {
                return Err(InputError::StepContradicts { path, channel, stated: whole.dt, given });
            }
            // Coarse times do not show a step, but not every step fits them.
            Some(given)
                if (whole.number("step_fits").zip(whole.number("step_slack")))
                    .is_some_and(|(fits, slack)| (given - fits).abs() > slack) =>
            {
                return Err(self.step_missing(whole, Some(given)));
            }
            Some(given) => whole.dt = given,
        }
        Ok(())
    }

    fn step_missing(&self, whole: &Segment, given: Option<f64>) -> InputError {
        let doubt = whole.text("step_doubt").map(|doubt| match given {
            Some(given) => format!("{doubt}, not the {given} s that were given"),
            None => doubt.to_owned(),
        });
        let (path, channel) = (self.file.source.location.clone(), whole.id.clone());
        InputError::StepMissing { path, channel, doubt, fits: whole.number("step_fits") }
    }

    /// Ground motion in SI and the account of how it came about, where a response was to be removed.
    fn removed_response(&self, whole: &mut Segment) -> Result<Option<(Vec<f64>, Value)>, InputError> {
        if self.file.source.response.is_none() {
            return Ok(None);
        }
        match whole.ground.take() {
            Some(Ground::Removed { samples, about }) => {
                let finite = samples.iter().all(|value| value.is_finite());
                if !finite {
                    let problem = "the division by the response gave values that are not finite";
                    return Err(self.response_refused(whole, problem, "give a narrower pre_filter"));
                }
                // Poles and zeros often do not say whose they are: the channel's code then tells.
                let quantity = response::unit(&about).map(|unit| unit.quantity);
                if let (Some(instrument), Some(Quantity::Velocity)) = (instrument(&whole.channel), quantity)
                    && instrument == ACCELEROMETER
                {
                    let code = &whole.channel;
                    let problem = format!("it is of velocity, but its code {code} is that of {instrument}");
                    return Err(self.response_refused(whole, &problem, "give the metadata of this channel"));
                }
                Ok(Some((samples, about)))
            }
            Some(Ground::Refused { problem, remedy }) => Err(self.response_refused(whole, &problem, &remedy)),
            None => {
                let problem = "the channel comes in several pieces";
                Err(self.response_refused(whole, problem, "join the pieces, or cut one out"))
            }
        }
    }

    fn response_refused(&self, whole: &Segment, problem: &str, remedy: &str) -> InputError {
        let metadata = self.file.source.response.as_ref().map(|response| response.metadata.clone());
        InputError::ResponseRefused {
            path: self.file.source.location.clone(),
            metadata: metadata.unwrap_or_default(),
            problem: if problem.contains(&whole.id) {
                problem.into()
            } else {
                format!("{}: {problem}", whole.id)
            },
            remedy: remedy.into(),
        }
    }

    fn read_step(&self, whole: &Segment) -> Step {
        let mut read = json!({
            "format": self.format.name, "obspy": self.obspy, "samples": whole.samples.len(), "dt_s": whole.dt,
        });
        if self.file.source.dt.is_some() {
            read["dt_given_by"] = json!("user");
        }
        if !self.warnings.is_empty() {
            read["warnings"] = json!(self.warnings);
        }
        let facts = FACTS.iter().filter_map(|key| Some((key.to_string(), whole.header.get(*key)?.clone())));
        Step::new("read", read).with_found(Value::Object(facts.collect()))
    }

    fn unit_step(
        &self,
        whole: &Segment,
        unit: &StoredUnit,
        given: Option<Unit>,
        removed: Option<&(Vec<f64>, Value)>,
    ) -> Step {
        let by = match (removed, given) {
            (Some(_), _) => "metadata",
            (None, Some(_)) => "user",
            (None, None) => "file",
        };
        let stored = if given.is_some() { self.format.stored } else { unit.text.as_str() };
        let mut convert = json!({
            "stored": stored, "given_by": by, "unit": unit.text, "quantity": unit.quantity,
            "factor_to_si": unit.factor, "si": unit.quantity.si_unit(),
        });
        if let (Some((_, about)), Some(response)) = (removed, &self.file.source.response) {
            convert["factor_to_si"] = Value::Null;
            convert["metadata_file"] = json!(response.metadata);
            if let Some((content, _)) = &self.file.metadata {
                convert["metadata_sha256"] = json!(sha256(content));
            }
            convert["response"] = about.clone();
        }
        if given.is_some()
            && let Some(calib) = whole.calib.filter(|calib| *calib != 1.0)
        {
            convert["calibration_not_applied"] = json!(calib);
        }
        if let Some(instrument) = instrument(&whole.channel) {
            convert["instrument_by_code"] = json!(instrument);
        }
        // What was set aside for the user's unit.
        let stated = given.and_then(|_| (self.format.unit)(whole).ok());
        let step = Step::new("unit", convert);
        match stated {
            Some(stated) => step.with_found(json!({ "file_states": stated.text })),
            None => step,
        }
    }

    /// The user's unit, else the file's.
    fn unit(&self, whole: &Segment, given: Option<Unit>) -> Result<StoredUnit, InputError> {
        if let Some(unit) = given {
            return Ok(StoredUnit {
                text: unit.symbol().into(),
                quantity: unit.quantity(),
                factor: unit.factor(),
            });
        }
        (self.format.unit)(whole).map_err(|reason| InputError::UnitMissing {
            path: self.file.source.location.clone(),
            channel: whole.id.clone(),
            reason,
            choices: Unit::choices(),
        })
    }

    /// Whether a ground motion can have this peak about its mean.
    fn plausible(&self, whole: &Segment, unit: &StoredUnit, samples: &[f64]) -> Result<(), InputError> {
        let mean = samples.iter().sum::<f64>() / samples.len() as f64;
        let peak = samples.iter().fold(0.0, |peak: f64, value| peak.max((value - mean).abs()));
        let (low, high) = unit.quantity.plausible_peak();
        if (low..=high).contains(&peak) {
            return Ok(());
        }
        Err(InputError::PeakImplausible {
            path: self.file.source.location.clone(),
            channel: whole.id.clone(),
            unit: unit.text.clone(),
            quantity: unit.quantity,
            peak,
            si: unit.quantity.si_unit(),
            low,
            high,
        })
    }
}
