//! Offset, taper, rotation, cut, zeros, quantity and band.

use std::f64::consts::PI;

use serde_json::{Map, Value, json};

use super::process::{per_component, refuse, unfit};
use super::{BandWindow, Motion, Quantity, Spectrum, Step, gravity};
use crate::error::InputError;
use crate::number::{nine, plain};

/// Share of a step within which a time counts as that of a sample.
const ON_SAMPLE: f64 = 1e-6;

/// Most samples of a padded motion.
pub(crate) const SAMPLES_TO: f64 = 2e7;

/// See [`Process::Demean`](super::Process::Demean).
pub(super) fn demean(
    motion: &mut Motion,
    first_seconds: Option<f64>,
) -> Result<Map<String, Value>, InputError> {
    let n = motion.len();
    let count = match first_seconds {
        None => n,
        Some(seconds) => {
            let longest = n as f64 * motion.dt;
            if !(seconds > 0.0 && seconds <= longest * (1.0 + 1e-9)) {
                let expected = format!("more than 0 and at most the motion's {} s", nine(longest));
                let remedy =
                    "give the quiet time before the first arrival, or leave it out for the whole record";
                return refuse("demean", "first_seconds", seconds, expected, remedy);
            }
            ((seconds / motion.dt).round() as usize).clamp(1, n)
        }
    };
    let quantity = motion.quantity;
    let mut found = per_component(motion, |_, samples| {
        let mean = samples[..count].iter().sum::<f64>() / count as f64;
        samples.iter_mut().for_each(|value| *value -= mean);
        let mut entry = Map::new();
        entry.insert(format!("offset_{}", quantity.key_suffix()), json!(mean));
        if let Some(sign) = gravity(quantity, mean) {
            entry.insert("gravity_g".into(), json!(sign));
        }
        Value::Object(entry)
    });
    found.insert("samples_averaged".into(), json!(count));
    Ok(found)
}

/// See [`Process::Taper`](super::Process::Taper).
pub(super) fn taper(motion: &mut Motion, start: f64, end: f64) -> Result<Map<String, Value>, InputError> {
    const STEP: &str = "taper";
    const REMEDY: &str = "give shorter tapers; a twentieth of the record at either end is customary";
    let (dt, duration) = (motion.dt, motion.duration());
    let longest = duration + ON_SAMPLE * dt;
    for (parameter, length) in [("start", start), ("end", end)] {
        if !(length >= 0.0 && length <= longest) {
            let expected = format!("0 to the motion's {} s", nine(duration));
            return refuse(STEP, parameter, length, expected, REMEDY);
        }
    }
    if start + end > longest {
        let expected = format!("at most the motion's {} s", nine(duration));
        return refuse(STEP, "start + end", start + end, expected, REMEDY);
    }
    let gain = |t: f64, length: f64| if t < length { 0.5 * (1.0 - (PI * t / length).cos()) } else { 1.0 };
    for samples in motion.components.iter_mut().flatten() {
        let last = samples.len() - 1;
        for (i, value) in samples.iter_mut().enumerate() {
            *value *= gain(i as f64 * dt, start) * gain((last - i) as f64 * dt, end);
        }
    }
    Ok(Map::new())
}

/// See [`Process::Rotate`](super::Process::Rotate).
pub(super) fn rotate(motion: &mut Motion, angle: f64) -> Result<Map<String, Value>, InputError> {
    if !angle.is_finite() {
        let remedy = "give the angle from the old x axis to the new one, counter-clockwise";
        return refuse("rotate", "angle", angle, "a finite number of degrees", remedy);
    }
    let (sin, cos) = turned(angle);
    let [Some(x), Some(y), _] = &mut motion.components else {
        let remedy = "give the motion's two horizontal components, x and y";
        return unfit("rotate", "a rotation about the vertical needs both horizontals", remedy);
    };
    for (x, y) in x.iter_mut().zip(y.iter_mut()) {
        (*x, *y) = (*x * cos + *y * sin, *y * cos - *x * sin);
    }
    Ok(Map::new())
}

/// Sine and cosine of an angle in degrees; exact at multiples of a right angle.
fn turned(angle: f64) -> (f64, f64) {
    match angle.rem_euclid(360.0) {
        0.0 => (0.0, 1.0),
        90.0 => (1.0, 0.0),
        180.0 => (0.0, -1.0),
        270.0 => (-1.0, 0.0),
        degrees => degrees.to_radians().sin_cos(),
    }
}

/// See [`Process::Trim`](super::Process::Trim).
pub(super) fn trim(
    motion: &mut Motion,
    from: f64,
    to: Option<f64>,
) -> Result<Map<String, Value>, InputError> {
    const STEP: &str = "trim";
    let (n, dt, duration) = (motion.len(), motion.dt, motion.duration());
    let slack = ON_SAMPLE * dt;
    let end = to.unwrap_or(duration);
    let length = nine(duration);
    if !(from >= 0.0 && from < duration) {
        let expected = format!("at least 0 and below the motion's {length} s");
        return refuse(STEP, "from", from, expected, "times count from the first sample, in s");
    }
    if !(end > from && end <= duration + slack) {
        let expected = format!("above from = {} s and at most the motion's {length} s", nine(from));
        let remedy = "times count from the first sample, in s; leave `to` out for the record's end";
        return refuse(STEP, "to", end, expected, remedy);
    }
    let first = (from / dt - ON_SAMPLE).ceil().max(0.0) as usize;
    let last = ((end / dt + ON_SAMPLE).floor() as usize).min(n - 1);
    if last < first + 1 {
        let expected = format!("two samples or more from {} s on; the step is {} s", nine(from), nine(dt));
        return refuse(STEP, "to", end, expected, "keep a longer part of the record");
    }
    for samples in motion.components.iter_mut().flatten() {
        samples.truncate(last + 1);
        samples.drain(..first);
    }
    motion.start = motion.start.map(|start| start + first as f64 * dt);
    Ok(Map::from_iter([
        ("samples_cut_before".to_string(), json!(first)),
        ("samples_cut_after".to_string(), json!(n - 1 - last)),
    ]))
}

/// See [`Process::Pad`](super::Process::Pad).
pub(super) fn pad(motion: &mut Motion, before: f64, after: f64) -> Result<Map<String, Value>, InputError> {
    let dt = motion.dt;
    const REMEDY: &str = "give fewer zeros, or resample to a longer step before";
    let most = (SAMPLES_TO - motion.len() as f64).max(0.0) * dt;
    let limit = format!("{} s: a motion has at most {} samples", nine(most), plain(SAMPLES_TO));
    for (parameter, seconds) in [("before", before), ("after", after)] {
        if !(seconds >= 0.0 && seconds <= most) {
            return refuse("pad", parameter, seconds, format!("0 to {limit}"), REMEDY);
        }
    }
    if before + after > most {
        return refuse("pad", "before + after", before + after, format!("at most {limit}"), REMEDY);
    }
    let zeros = [before, after].map(|seconds| (seconds / dt).round() as usize);
    for samples in motion.components.iter_mut().flatten() {
        let mut long = vec![0.0; zeros[0]];
        long.append(samples);
        long.resize(long.len() + zeros[1], 0.0);
        *samples = long;
    }
    motion.start = motion.start.map(|start| start - zeros[0] as f64 * dt);
    Ok(Map::from_iter([
        ("zeros_before".to_string(), json!(zeros[0])),
        ("zeros_after".to_string(), json!(zeros[1])),
    ]))
}

/// See [`Process::Convert`](super::Process::Convert).
pub(super) fn convert(motion: &mut Motion, to: Quantity) -> Map<String, Value> {
    let from = motion.quantity;
    for axis in 0..3 {
        motion.components[axis] = motion.component_as(axis, to, 1);
    }
    motion.quantity = to;
    Map::from_iter([
        ("from".to_string(), json!(from)),
        (format!("peak_{}", to.key_suffix()), json!(motion.peak())),
    ])
}

impl Motion {
    /// Keeps the band from `f_min` to `f_max` (Hz) with the zero-phase window [`BandWindow`]: the band of a model.
    ///
    /// Arrival times stay; being zero-phase, the window also spreads a little before them, and what
    /// falls outside the record's time is cut off. `f_min = 0` keeps the low end, offset included;
    /// `f_max` at Nyquist keeps the high end. To process a record, see [`Filter`](super::Filter).
    ///
    /// Errors: negative or unordered frequencies; `f_max` above Nyquist.
    pub fn band(&mut self, f_min: f64, f_max: f64) -> Result<(), InputError> {
        const STEP: &str = "band";
        let nyquist = 0.5 / self.dt;
        if !(f_min >= 0.0 && f_min.is_finite()) {
            let remedy = "give motion.band = [f_min, f_max], or \"auto\"";
            return refuse(STEP, "f_min", f_min, "0 or a positive frequency in Hz", remedy);
        }
        if !(f_max > f_min && f_max <= nyquist * (1.0 + 1e-9)) {
            let expected =
                format!("above f_min = {} Hz and at most Nyquist = {} Hz", nine(f_min), nine(nyquist));
            let remedy = "end motion.band at Nyquist or below, or leave it to \"auto\"";
            return refuse(STEP, "f_max", f_max, expected, remedy);
        }
        let window = BandWindow::new(f_min, f_max, self.dt);
        for samples in self.components.iter_mut().flatten() {
            let mut spectrum = Spectrum::of(samples, self.dt, window.pad_seconds());
            spectrum.apply(|f| window.gain(f));
            *samples = spectrum.periodic(0, 1, samples.len());
        }
        let found = json!({
            "f_zero_below_hz": 0.5 * f_min, "f_zero_above_hz": window.f_stop,
            "window": "half-cosine, zero phase", "zeros_s": window.pad_seconds(),
        });
        let asked = json!({ "f_min_hz": f_min, "f_max_hz": f_max });
        self.steps.push(Step::new(STEP, asked).with_found(found));
        Ok(())
    }
}
