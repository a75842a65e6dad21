//! From the scene's `[motion]` to an acceleration in SI: read, offset, quantity, scale.

use crate::results::AXES;
use hati_inputs::motion::{Motion, Offset, Quantity, Step};
use hati_inputs::records::{self, Channel, ReadOptions};
use hati_inputs::scene::{self, Component, Scene};
use hati_inputs::{InputError, measures::Measures};
use serde_json::{Value, json};

/// The scene's motion as an acceleration, offset removed and scaled, not yet limited to a band.
#[derive(Debug, Clone)]
pub struct MotionInput {
    /// Acceleration, m/s², with every step recorded.
    pub motion: Motion,
    /// One JSON object per channel: axis, file, id, format, unit, dt, npts, pga, sha256.
    pub channels: Vec<Value>,
    /// Factor and why, if the scene scales.
    pub scale: Option<(f64, String)>,
    /// Warnings for the user.
    pub warnings: Vec<String>,
}

/// Active components of a scene, 0 = x, 1 = y, 2 = z.
pub fn active_axes(scene: &Scene) -> Vec<usize> {
    (0..3).filter(|&a| scene.components()[a].is_some()).collect()
}

impl MotionInput {
    /// Reads all components. Python is started once, and only if a component is a file.
    pub fn read(scene: &Scene) -> Result<Self, InputError> {
        let quantity = scene.motion.quantity;
        let mut channels: [Option<Channel>; 3] = [None, None, None];
        let mut described = vec![];
        let mut files = vec![];
        for axis in 0..3 {
            if let Some(Component::Record(r)) = scene.components()[axis] {
                let location = scene.record_path(r);
                files.push((axis, records::Source { location, unit: r.unit, channel: r.channel.clone() }));
            }
        }
        let sources: Vec<records::Source> = files.iter().map(|(_, s)| s.clone()).collect();
        let options = ReadOptions { quantity: Some(quantity), ..ReadOptions::default() };
        let read = if sources.is_empty() { vec![] } else { records::read_many(&sources, &options)? };
        for ((axis, source), found) in files.into_iter().zip(read) {
            channels[axis] = Some(pick(found, &source, axis)?);
        }
        for axis in 0..3 {
            if let Some(c) = &channels[axis] {
                described.push(describe(axis, c));
            }
        }
        let recorded = channels.iter().any(Option::is_some);
        let mut motion = if recorded {
            let mut motion =
                Motion::from_channels([channels[0].as_ref(), channels[1].as_ref(), channels[2].as_ref()])?;
            // a wavelet has no instrument's offset: it joins afterwards
            match scene.motion.offset {
                scene::Offset::Mean => motion.remove_offset(Offset::Mean)?,
                scene::Offset::First { first_seconds } => {
                    motion.remove_offset(Offset::FirstSeconds(first_seconds))?;
                }
                scene::Offset::None => {}
            }
            with_wavelets(scene, motion, &mut described)?
        } else {
            from_wavelets(scene, quantity, &mut described)?
        };
        to_acceleration(&mut motion);
        let mut input = Self { motion, channels: described, scale: None, warnings: vec![] };
        input.scale(scene)?;
        input.warn();
        Ok(input)
    }

    fn scale(&mut self, scene: &Scene) -> Result<(), InputError> {
        self.scale = match scene.motion.scale {
            None => None,
            Some(scene::Scale::Factor(factor)) => {
                self.motion.scale(factor)?;
                Some((factor, "factor given by the scene".into()))
            }
            Some(scene::Scale::Pga(pga)) => {
                let factor = self.motion.scale_to_peak(pga)?;
                Some((
                    factor,
                    format!("to a peak of {pga} m/s² in the largest component, before the band is applied"),
                ))
            }
        };
        Ok(())
    }

    fn warn(&mut self) {
        for step in &self.motion.steps {
            let gravity = step.parameters.get("z").and_then(|z| z.get("gravity_g"));
            if gravity.is_some() {
                self.warnings
                    .push("the vertical channel carried gravity; it was removed with the offset".into());
            }
        }
        if let Some((factor, _)) = self.scale
            && (factor.abs() > 10.0 || factor.abs() < 0.1)
        {
            self.warnings.push(format!(
                "the motion is scaled by {factor:.4}: a weak record made strong keeps the frequency content and duration of a weak one"
            ));
        }
    }
}

fn pick(mut found: Vec<Channel>, source: &records::Source, axis: usize) -> Result<Channel, InputError> {
    let present = found.iter().map(|c| c.id.clone()).collect::<Vec<_>>().join(", ");
    let candidates: Vec<usize> = match &source.channel {
        Some(id) => (0..found.len()).filter(|&i| found[i].id == *id).collect(),
        None if found.len() == 1 => vec![0],
        None => (0..found.len()).filter(|&i| found[i].axis_hint == Some(axis)).collect(),
    };
    if let [only] = candidates[..] {
        return Ok(found.swap_remove(only));
    }
    let wanted = source.channel.clone().unwrap_or_else(|| {
        format!("that is plainly the {} component; name one as motion.{0}.channel", AXES[axis])
    });
    Err(InputError::ChannelMissing { path: source.location.clone(), wanted, present })
}

fn describe(axis: usize, c: &Channel) -> Value {
    let peak = c.samples.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    json!({
        "axis": AXES[axis].to_string(), "file": c.file.display().to_string(), "id": c.id,
        "format": c.format.to_string(), "quantity": c.quantity.to_string(), "unit_stored": c.unit_stored.to_string(),
        "unit": c.quantity.si_unit(), "dt": c.dt, "npts": c.samples.len(), "peak_as_read": peak,
        "start": c.start, "sha256": c.sha256,
        "steps": c.steps,
    })
}

fn describe_wavelet(axis: usize, w: &scene::Wavelet, quantity: Quantity) -> Value {
    json!({
        "axis": AXES[axis].to_string(), "file": "synthetic", "id": w.kind.as_str(), "format": "closed form",
        "quantity": quantity.to_string(), "unit_stored": quantity.si_unit(), "unit": quantity.si_unit(),
        "dt": w.dt, "npts": w.sample_count(), "peak_as_read": w.amplitude.abs(),
    })
}

fn from_wavelets(
    scene: &Scene,
    quantity: Quantity,
    described: &mut Vec<Value>,
) -> Result<Motion, InputError> {
    let mut components = [None, None, None];
    let mut dt = 0.0;
    for axis in 0..3 {
        if let Some(Component::Synthetic(s)) = scene.components()[axis] {
            components[axis] = Some(s.wavelet.samples());
            dt = s.wavelet.dt;
            described.push(describe_wavelet(axis, &s.wavelet, quantity));
        }
    }
    Motion::new(dt, None, quantity, components)
}

/// Synthetic components beside recorded ones are sampled on the record's own instants.
fn with_wavelets(
    scene: &Scene,
    mut motion: Motion,
    described: &mut Vec<Value>,
) -> Result<Motion, InputError> {
    let n = motion.len();
    for axis in 0..3 {
        if let Some(Component::Synthetic(s)) = scene.components()[axis] {
            motion.components[axis] = Some((0..n).map(|i| s.wavelet.value(i as f64 * motion.dt)).collect());
            described.push(describe_wavelet(axis, &s.wavelet, motion.quantity));
        }
    }
    Ok(motion)
}

fn to_acceleration(motion: &mut Motion) {
    if motion.quantity == Quantity::Acceleration {
        return;
    }
    let from = motion.quantity;
    for axis in 0..3 {
        motion.components[axis] = motion.component_as(axis, Quantity::Acceleration, 1);
    }
    motion.quantity = Quantity::Acceleration;
    let parameters = json!({ "from": from.to_string(), "to": "acceleration", "by": "spectral derivative" });
    motion.steps.push(Step::new("differentiate", parameters));
}

/// The measures of a component as the JSON of `record` and `summary.json`.
pub fn measures_json(m: &Measures) -> Value {
    json!({
        "pga": m.pga, "pgv": m.pgv, "pgd": m.pgd, "arias": m.arias_intensity, "cav": m.cav,
        "d5_75": m.d5_75, "d5_95": m.d5_95, "mean_period": m.mean_period,
    })
}
