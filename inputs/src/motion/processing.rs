//! Offset, scale, band and taper: the operations that a record goes through before it is used.

use std::f64::consts::PI;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value, json};

use super::{AXES, BandWindow, Motion, Quantity, STANDARD_GRAVITY, Spectrum, Step};
use crate::error::InputError;

/// Which stretch of the record gives the offset that is removed.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Offset {
    /// The mean over the whole record.
    Mean,
    /// The mean over the first seconds, which should come before the first arrival.
    FirstSeconds(f64),
}

/// Relative distance from 1 g within which the mean of a vertical accelerogram is called gravity.
const GRAVITY_TOLERANCE: f64 = 0.05;

fn refuse<T>(
    step: &'static str,
    parameter: &'static str,
    found: f64,
    expected: impl Into<String>,
) -> Result<T, InputError> {
    Err(InputError::StepParameter { step, parameter, found, expected: expected.into() })
}

impl Motion {
    fn record_step(&mut self, name: &str, parameters: Value) {
        self.steps.push(Step::new(name, parameters));
    }

    /// Subtracts from each component its mean over the whole record or over its first seconds.
    ///
    /// The step records each offset (SI). A vertical acceleration whose offset is within 5 % of ±1 g
    /// carries gravity: the step then says so under `gravity_g` (+1 or −1).
    ///
    /// Errors: a stretch that is not positive or longer than the record.
    pub fn remove_offset(&mut self, offset: Offset) -> Result<(), InputError> {
        const STEP: &str = "remove offset";
        let n = self.len();
        let (count, mut parameters) = match offset {
            Offset::Mean => (n, Map::from_iter([("over".into(), json!("whole record"))])),
            Offset::FirstSeconds(seconds) => {
                let longest = n as f64 * self.dt;
                if !(seconds > 0.0 && seconds <= longest * (1.0 + 1e-9)) {
                    let expected = format!("more than 0 and at most {longest} s");
                    return refuse(STEP, "first_seconds", seconds, expected);
                }
                let count = ((seconds / self.dt).round() as usize).clamp(1, n);
                let entries = [
                    ("over".to_string(), json!("first seconds")),
                    ("seconds".to_string(), json!(seconds)),
                    ("samples".to_string(), json!(count)),
                ];
                (count, Map::from_iter(entries))
            }
        };
        let suffix = self.quantity.key_suffix();
        for axis in 0..3 {
            let Some(samples) = &mut self.components[axis] else { continue };
            let mean = samples[..count].iter().sum::<f64>() / count as f64;
            samples.iter_mut().for_each(|value| *value -= mean);
            let mut entry = Map::new();
            entry.insert(format!("offset_{suffix}"), json!(mean));
            let off_gravity = (mean.abs() - STANDARD_GRAVITY).abs() / STANDARD_GRAVITY;
            if axis == 2 && self.quantity == Quantity::Acceleration && off_gravity <= GRAVITY_TOLERANCE {
                entry.insert("gravity_g".into(), json!(mean.signum()));
            }
            parameters.insert(AXES[axis].to_string(), Value::Object(entry));
        }
        self.record_step(STEP, Value::Object(parameters));
        Ok(())
    }

    /// Multiplies all components by one factor (negative: the motion is reversed).
    ///
    /// Errors: a factor that is zero or not finite.
    pub fn scale(&mut self, factor: f64) -> Result<(), InputError> {
        const STEP: &str = "scale";
        if !factor.is_finite() || factor == 0.0 {
            return refuse(STEP, "factor", factor, "a finite number other than 0");
        }
        self.multiply(factor);
        let peak = self.peak();
        let key = format!("peak_{}", self.quantity.key_suffix());
        self.record_step(STEP, json!({ "factor": factor, key: peak }));
        Ok(())
    }

    /// Scales all components by one factor so that the largest sample of all becomes `peak` (SI), and
    /// returns the factor. For an acceleration this is a scaling to a PGA.
    ///
    /// Errors: a peak that is not positive and finite; a motion that is zero throughout.
    pub fn scale_to_peak(&mut self, peak: f64) -> Result<f64, InputError> {
        const STEP: &str = "scale to peak";
        if !(peak.is_finite() && peak > 0.0) {
            return refuse(STEP, "peak", peak, "a positive number (SI)");
        }
        let found = self.peak();
        let factor = peak / found;
        if !factor.is_finite() || factor == 0.0 {
            return refuse(STEP, "peak of the motion", found, "a motion that is not zero");
        }
        self.multiply(factor);
        let suffix = self.quantity.key_suffix();
        let (wanted, before) = (format!("peak_{suffix}"), format!("peak_before_{suffix}"));
        self.record_step(STEP, json!({ "factor": factor, wanted: peak, before: found }));
        Ok(factor)
    }

    fn multiply(&mut self, factor: f64) {
        let samples = self.components.iter_mut().flatten().flatten();
        samples.for_each(|value| *value *= factor);
    }

    /// Keeps the band from `f_min` to `f_max` (Hz) with the zero-phase window [`BandWindow`].
    ///
    /// Arrival times stay; being zero-phase, the window also spreads a little before them, and what
    /// falls outside the record's time is cut off. `f_min = 0` keeps the low end, offset included;
    /// `f_max` at Nyquist keeps the high end.
    ///
    /// Errors: negative or unordered frequencies; `f_max` above Nyquist.
    pub fn band(&mut self, f_min: f64, f_max: f64) -> Result<(), InputError> {
        const STEP: &str = "band";
        let nyquist = 0.5 / self.dt;
        if !(f_min >= 0.0 && f_min.is_finite()) {
            return refuse(STEP, "f_min", f_min, "0 or a positive frequency in Hz");
        }
        if !(f_max > f_min && f_max <= nyquist * (1.0 + 1e-9)) {
            let expected = format!("above f_min = {f_min} Hz and at most Nyquist = {nyquist} Hz");
            return refuse(STEP, "f_max", f_max, expected);
        }
        let window = BandWindow::new(f_min, f_max, self.dt);
        for samples in self.components.iter_mut().flatten() {
            let mut spectrum = Spectrum::of(samples, self.dt, window.pad_seconds());
            spectrum.apply(|f| window.gain(f));
            *samples = spectrum.periodic(0, 1, samples.len());
        }
        let parameters = json!({
            "f_min_hz": f_min, "f_max_hz": f_max,
            "f_zero_below_hz": 0.5 * f_min, "f_zero_above_hz": window.f_stop,
            "window": "half-cosine, zero phase", "zeros_s": window.pad_seconds(),
        });
        self.record_step(STEP, parameters);
        Ok(())
    }

    /// Brings the ends to zero with half-cosines over `start` and `end` seconds (0: that end stays).
    ///
    /// `gain = ½(1 − cos(π t/start))` for t < start, likewise from the last sample backwards.
    ///
    /// Errors: negative lengths, or lengths that overlap.
    pub fn taper(&mut self, start: f64, end: f64) -> Result<(), InputError> {
        const STEP: &str = "taper";
        let duration = self.duration();
        for (parameter, length) in [("start", start), ("end", end)] {
            if !(length >= 0.0 && length <= duration) {
                return refuse(STEP, parameter, length, format!("0 to {duration} s"));
            }
        }
        if start + end > duration {
            let expected = format!("at most the motion's {duration} s");
            return refuse(STEP, "start + end", start + end, expected);
        }
        let dt = self.dt;
        let gain = |t: f64, length: f64| {
            if t < length { 0.5 * (1.0 - (PI * t / length).cos()) } else { 1.0 }
        };
        for samples in self.components.iter_mut().flatten() {
            let last = samples.len() - 1;
            for (i, value) in samples.iter_mut().enumerate() {
                *value *= gain(i as f64 * dt, start) * gain((last - i) as f64 * dt, end);
            }
        }
        self.record_step(STEP, json!({ "start_s": start, "end_s": end, "window": "half-cosine" }));
        Ok(())
    }
}
