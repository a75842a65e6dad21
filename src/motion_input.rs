//! From the scene's `[motion]` to an acceleration in SI: read, joined with wavelets, processed.

use crate::results::AXES;
use hati_inputs::motion::{Motion, Process, Quantity, Scaling, Step};
use hati_inputs::records::{self, Channel, ReadOptions};
use hati_inputs::scene::{self, Component, Scene};
use hati_inputs::{InputError, measures::Measures};
use serde_json::{Value, json};

/// The scene's motion as an acceleration, processed as the scene says, not yet limited to a band.
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
    /// Reads all components and processes them. Python is started once, and only if a component is a file.
    pub fn read(scene: &Scene) -> Result<Self, InputError> {
        let channels = recorded(scene)?;
        let mut described: Vec<Value> =
            (0..3).filter_map(|axis| Some(describe(axis, channels[axis].as_ref()?))).collect();
        let motion = if channels.iter().any(Option::is_some) {
            let motion = Motion::from_channels(channels.each_ref().map(Option::as_ref))?;
            with_wavelets(scene, motion, &mut described)?
        } else {
            from_wavelets(scene, scene.motion().quantity, &mut described)?
        };
        let mut input = Self { motion, channels: described, scale: None, warnings: vec![] };
        input.process(scene, channels.map(|channel| channel.is_some()))?;
        Ok(input)
    }

    /// Does the scene's steps; `recorded`: the components that come from files.
    fn process(&mut self, scene: &Scene, mut recorded: [bool; 3]) -> Result<(), InputError> {
        let motion = &mut self.motion;
        for (i, step) in scene.motion().process.iter().enumerate() {
            let refused = |source| in_process(scene, i + 1, source);
            if step.mends_an_instrument() {
                on_records(step, motion, recorded).map_err(refused)?;
                continue;
            }
            step.apply(motion).map_err(refused)?;
            match step {
                Process::Scale(scaling) => {
                    let factor = motion.steps.last().and_then(|step| step.found.get("factor")?.as_f64());
                    let (before, said) = self.scale.take().unwrap_or((1.0, String::new()));
                    let and = if said.is_empty() { "" } else { ", then " };
                    let why = format!("{said}{and}{}", scaled(scaling));
                    self.scale = Some((before * factor.unwrap_or(1.0), why));
                }
                // A turned axis holds a share of both.
                Process::Rotate { .. } => {
                    let [x, y, z] = recorded;
                    recorded = [x || y, x || y, z];
                }
                _ => {}
            }
        }
        if motion.quantity != Quantity::Acceleration {
            Process::Convert { to: Quantity::Acceleration }.apply(motion)?;
        }
        self.warnings = motion.steps.iter().filter_map(Step::warning).collect();
        Ok(())
    }
}

/// A refusal with file, line and key of its step; `number` counts the steps from 1.
fn in_process(scene: &Scene, number: usize, source: InputError) -> InputError {
    let mut key = format!("motion.process[{number}]");
    if let InputError::StepParameter { parameter, .. } = &source {
        let inside = format!("{key}.{parameter}");
        if scene.source.written.contains_key(&inside) {
            key = inside;
        }
    }
    InputError::InProcess { place: scene.source.place_of(&key), source: Box::new(source) }
}

/// The channels of the components that are files, all read by one process.
fn recorded(scene: &Scene) -> Result<[Option<Channel>; 3], InputError> {
    let mut sources = vec![];
    for (axis, component) in scene.components().into_iter().enumerate() {
        if let Some(Component::Record(record)) = component {
            sources.push((axis, scene.source_of(record)));
        }
    }
    let mut channels = [None, None, None];
    if sources.is_empty() {
        return Ok(channels);
    }
    let options = ReadOptions {
        quantity: Some(scene.motion().quantity),
        accept_clipped: scene.motion().accept_clipped,
        ..ReadOptions::default()
    };
    let (axes, sources): (Vec<usize>, Vec<records::Source>) = sources.into_iter().unzip();
    let read = records::read_many(&sources, &options)?;
    for ((axis, source), found) in axes.into_iter().zip(&sources).zip(read) {
        channels[axis] = Some(records::choose(found, source, axis)?);
    }
    Ok(channels)
}

/// Does a step for the recorded components; a wavelet has no instrument that left it an offset or a drift.
fn on_records(step: &Process, motion: &mut Motion, recorded: [bool; 3]) -> Result<(), InputError> {
    if recorded == [false; 3] {
        return Ok(());
    }
    let mut aside = [None, None, None];
    for axis in (0..3).filter(|&axis| !recorded[axis]) {
        aside[axis] = motion.components[axis].take();
    }
    let done = step.apply(motion);
    for (component, aside) in motion.components.iter_mut().zip(aside) {
        *component = component.take().or(aside);
    }
    done
}

/// A scaling in words.
fn scaled(scaling: &Scaling) -> String {
    match scaling {
        Scaling::Factor(_) => "factor given by the scene".into(),
        Scaling::Pga(pga) => {
            format!("to a peak of {pga} m/s² in the largest component, before the band is applied")
        }
        Scaling::Pgv(pgv) => {
            format!("to a peak velocity of {pgv} m/s in the largest component, before the band is applied")
        }
        Scaling::Sa { sa, period, damping } => format!(
            "to a pseudo-spectral acceleration of {sa} m/s² at {period} s and a damping of {damping} in the largest component, before the band is applied"
        ),
    }
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

/// The measures of a component as the JSON of `record` and `summary.json`.
pub fn measures_json(m: &Measures) -> Value {
    json!({
        "pga": m.pga, "pgv": m.pgv, "pgd": m.pgd, "arias": m.arias_intensity, "cav": m.cav,
        "d5_75": m.d5_75, "d5_95": m.d5_95, "mean_period": m.mean_period,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const SOIL: &str = "[[soil.layer]]\nthickness = 5\nvs = 150.0\nrho = 1800.0\n\
        [soil.base]\nkind = \"elastic\"\nvs = 800.0\nrho = 2200.0\n";

    fn read(motion: &str) -> Result<MotionInput, InputError> {
        let pulse = "{ kind = \"gaussian\", frequency = 5.0, amplitude = 1.0, time = 0.5, dt = 0.005, duration = 2.0 }";
        let text = format!(
            "version = 1\n[motion]\nkind = \"outcrop\"\n{motion}\n[motion.x]\nwavelet = {pulse}\n\
             [motion.y]\nwavelet = {pulse}\n{SOIL}"
        );
        let scene = scene::load_str(&text, "scene.toml", &[]).unwrap_or_else(|e| panic!("{e}"));
        MotionInput::read(&scene)
    }

    #[test]
    fn a_wavelet_keeps_its_closed_form() {
        let input = read("").unwrap();
        assert_eq!(input.motion.components[0].as_ref().unwrap()[100], 1.0);
        assert!(input.motion.steps.is_empty() && input.scale.is_none() && input.warnings.is_empty());
    }

    #[test]
    fn corrections_of_instruments_leave_a_wavelet_beside_a_record_alone() {
        let mut motion = read("").unwrap().motion;
        let before = motion.components[1].clone();
        on_records(&Process::Demean { first_seconds: None }, &mut motion, [true, false, false]).unwrap();
        assert!(motion.components[0].as_ref().unwrap().iter().sum::<f64>().abs() < 1e-9);
        assert_eq!(motion.components[1], before);
        let refused = Process::Demean { first_seconds: Some(9.0) };
        assert!(on_records(&refused, &mut motion, [true, false, false]).is_err());
        assert_eq!(motion.components[1], before);
    }

    #[test]
    fn factors_multiply_and_refusals_name_their_place() {
        let input =
            read("process = [{ step = \"scale\", pga = 2 }, { step = \"scale\", factor = -10 }]").unwrap();
        let (factor, why) = input.scale.unwrap();
        assert!((factor + 20.0).abs() < 1e-12, "{factor}");
        assert!(
            why.starts_with("to a peak of 2 m/s²") && why.ends_with(", then factor given by the scene"),
            "{why}"
        );
        let steps = "process = [\n  { step = \"rest\" },\n  { step = \"trim\", from = 1, to = 100 },\n]";
        let refused = read(steps).unwrap_err().to_string();
        let place = "scene.toml:6 motion.process[2].to: trim: to = 100; expected above from = 1 s";
        assert!(refused.starts_with(place) && refused.contains("\n  help: "), "{refused}");
        let refused =
            read("process = [{ step = \"taper\", start = 1.5, end = 1.5 }]").unwrap_err().to_string();
        assert!(refused.starts_with("scene.toml:4 motion.process[1]: taper: start + end = 3"), "{refused}");
    }

    #[test]
    fn another_quantity_becomes_an_acceleration_in_the_end() {
        let input = read("quantity = \"velocity\"\nprocess = [{ step = \"scale\", pgv = 0.5 }]").unwrap();
        assert_eq!(input.motion.quantity, Quantity::Acceleration);
        let names: Vec<&str> = input.motion.steps.iter().map(|step| step.name.as_str()).collect();
        assert_eq!(names, ["scale", "convert"]);
        let velocity = input.motion.component_as(0, Quantity::Velocity, 1).unwrap();
        assert!((velocity.iter().fold(0.0, |peak: f64, v| peak.max(v.abs())) - 0.5).abs() < 1e-9);
    }
}
