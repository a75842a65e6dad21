//! From a plan to a run folder: the time loop, the files, the summary.

mod drive;
mod recorder;

pub use drive::{Drive, drive};
pub use recorder::{CHUNK, FieldRows, Recorder};

use crate::motion_input::measures_json;
use crate::outputs::{
    FieldChunk, FieldWriter, LedgerWriter, OutputError, Provenance, StationsWriter, TraceChunk, TraceLayout,
    write_progress, write_summary,
};
use crate::plan::{Plan, PlanError};
use crate::results::{AXES, Trace};
use crate::spectrum::band_spectrum;
use hati_coupling::{CouplingError, Subdomain};
use hati_inputs::measures::Measures;
use hati_inputs::motion::{Quantity, resample_as};
use hati_inputs::scene::{Scene, resolved_toml};
use hati_sem::SemError;
use hati_sem::column::Column;
use num_complex::Complex64;
use serde_json::{Value, json};
use sha2::{Digest, Sha256};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// What ends a run early.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RunError {
    /// A scene with mistakes.
    #[error("{0}")]
    Scene(Box<hati_inputs::scene::Diagnostics>),
    /// While planning.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// While writing.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// Unstable, or a state that does not fit.
    #[error(transparent)]
    Coupling(#[from] CouplingError),
    /// A model that cannot be built.
    #[error(transparent)]
    Sem(#[from] SemError),
}

/// What the caller wants of a run besides its results.
pub struct RunControl<'a> {
    /// Set from outside to stop at the next sample.
    pub interrupt: &'a AtomicBool,
    /// Stops as if interrupted after this wall time.
    pub max_wall_time: Option<Duration>,
    /// Told about progress: samples done, samples in all, solver seconds.
    pub progress: &'a mut dyn FnMut(usize, usize, f64),
    /// Command line for the files' history.
    pub history: String,
}

/// How a run ended, what it holds, and its summary.
pub struct Outcome {
    /// The finished simulation: what a report is made from.
    pub simulation: Simulation,
    /// The content of `summary.json`.
    pub summary: Value,
    /// Whether it was interrupted.
    pub interrupted: bool,
}

/// A column with its recorder, ready to step.
pub struct Simulation {
    /// The column.
    pub column: Column,
    /// What is kept.
    pub recorder: Recorder,
    /// The input.
    pub drive: Drive,
    /// Seconds spent in steps and samples.
    pub solver_seconds: f64,
    /// Seconds of these spent in steps alone.
    pub step_seconds: f64,
}

impl Simulation {
    /// Builds column, drive and recorder of a plan.
    pub fn new(plan: &Plan) -> Result<Self, RunError> {
        let mut drive = drive(plan)?;
        let base = std::mem::take(&mut drive.base);
        let mut column = Column::new(&plan.column, &plan.discretisation, &plan.arms, plan.dt(), base)?;
        let recorder = Recorder::new(plan, &mut column, velocity_scale(plan, &drive))?;
        Ok(Self { column, recorder, drive, solver_seconds: 0.0, step_seconds: 0.0 })
    }

    /// Steps to the next sample instant and takes it. Allocates nothing.
    ///
    /// Errors: growth without physical cause, with the place and the likely reason.
    pub fn advance(&mut self, plan: &Plan) -> Result<(), CouplingError> {
        let steps = if self.recorder.samples_taken() == 0 { 1 } else { plan.substeps };
        let start = Instant::now();
        for _ in 0..steps {
            self.column.step();
        }
        self.step_seconds += start.elapsed().as_secs_f64();
        let elapsed = plan.time_first() + self.recorder.samples_taken() as f64 * plan.sample_dt;
        let energies = self.recorder.sample(&mut self.column, elapsed);
        if self.recorder.grows_without_cause(&energies) {
            return Err(unstable(plan, &self.column, elapsed));
        }
        Ok(())
    }

    /// Runs to the end without writing anything.
    pub fn run_through(&mut self, plan: &Plan) -> Result<(), CouplingError> {
        let start = Instant::now();
        while self.recorder.samples_taken() < plan.samples {
            self.advance(plan)?;
        }
        self.solver_seconds += start.elapsed().as_secs_f64();
        Ok(())
    }

    /// Outcrop motions: the input, known before the run starts, or what goes with an imposed base on a
    /// half-space, known for the samples taken; none for a rigid base.
    pub fn outcrop_traces(&self, plan: &Plan) -> Vec<Trace> {
        let mut traces = vec![];
        for (c, &axis) in plan.axes.iter().enumerate() {
            if !plan.imposed() {
                traces.push(outcrop_trace(
                    plan,
                    axis,
                    self.drive.acceleration[axis].clone().unwrap_or_default(),
                ));
            } else if !self.recorder.outcrop_velocity[c].is_empty() {
                let v = &self.recorder.outcrop_velocity[c];
                let a = resample_as(v, plan.sample_dt, Quantity::Velocity, Quantity::Acceleration, 1);
                traces.push(outcrop_trace(plan, axis, a));
            }
        }
        traces
    }
}

fn outcrop_trace(plan: &Plan, axis: usize, acceleration: Vec<f64>) -> Trace {
    let as_quantity = |to| resample_as(&acceleration, plan.sample_dt, Quantity::Acceleration, to, 1);
    let (velocity, displacement) = (as_quantity(Quantity::Velocity), as_quantity(Quantity::Displacement));
    Trace { place: "outcrop".into(), depth: None, axis, acceleration, velocity, displacement }
}

fn velocity_scale(plan: &Plan, drive: &Drive) -> f64 {
    let peak = |a: &Vec<f64>| {
        let v = resample_as(a, plan.sample_dt, Quantity::Acceleration, Quantity::Velocity, 1);
        v.iter().fold(0.0_f64, |m, x| m.max(x.abs()))
    };
    drive.acceleration.iter().flatten().map(peak).fold(0.0, f64::max)
}

fn unstable(plan: &Plan, column: &Column, time: f64) -> CouplingError {
    let (v, depth) = column.fastest_point();
    let layer = column
        .mesh()
        .probe(depth.min(plan.column.depth()))
        .map_or(0, |p| column.mesh().elements[p.element].layer);
    CouplingError::Unstable {
        subdomain: column.name().into(),
        time,
        symptom: format!(
            "kinetic energy beyond all energy that came in; fastest point {v:.3e} m/s at {depth:.2} m depth, layer `{}`",
            plan.column.layers[layer].name
        ),
        dt: plan.dt(),
        dt_critical: plan.dt_critical,
        likely: if plan.dt() > plan.dt_critical {
            "the step is above its critical value: leave discretisation.dt to \"auto\"".into()
        } else {
            "the step is below its critical value, so this is a fault of the program: please report the scene"
                .into()
        },
    }
}

/// Runs a planned scene into a folder.
///
/// The folder then holds `scene.resolved.toml`, `stations.nc`, `field.nc`, `ledger.nc`, `summary.json` and
/// `progress.json`; the report is made afterwards from the outcome. Files are complete after every
/// append; an interrupt ends the run at the next sample with valid files and the status `interrupted`,
/// an instability with the status `unstable` and what was computed up to it.
pub fn run(
    scene: &Scene,
    plan: &Plan,
    out: &Path,
    control: &mut RunControl<'_>,
) -> Result<Outcome, RunError> {
    let wall = Instant::now();
    plan.check_memory()?;
    let resolved = resolved_toml(scene, &plan.resolved);
    let mut files = Files::create(out, scene, plan, &resolved, &control.history)?;
    let mut simulation = Simulation::new(plan)?;
    files.open_streams(plan, &simulation)?;
    let ended = step_through(plan, out, &mut files, &mut simulation, control, wall);
    let status = match &ended {
        Ok(false) => "finished",
        Ok(true) => "interrupted",
        Err(RunError::Coupling(_)) => "unstable",
        Err(_) => "failed",
    };
    if status != "failed" {
        files.append(plan, &mut simulation)?;
        files.finish(&simulation, simulation.recorder.ledger.closing_error())?;
        write_progress(&out.join("progress.json"), &progress(plan, &simulation, status))?;
    }
    let interrupted = ended.or_else(|e| {
        if status == "unstable" {
            write_summary(&out.join("summary.json"), &summary(scene, plan, &simulation, status))?;
        }
        Err(e)
    })?;
    let mut summary = summary(scene, plan, &simulation, status);
    summary["cost"]["wall_s"] = json!(wall.elapsed().as_secs_f64());
    write_summary(&out.join("summary.json"), &summary)?;
    Ok(Outcome { simulation, summary, interrupted })
}

/// The time loop with its files; true when it was interrupted.
fn step_through(
    plan: &Plan,
    out: &Path,
    files: &mut Files,
    simulation: &mut Simulation,
    control: &mut RunControl<'_>,
    wall: Instant,
) -> Result<bool, RunError> {
    let mut last_sync = Instant::now();
    while simulation.recorder.samples_taken() < plan.samples {
        let overdue = control.max_wall_time.is_some_and(|t| wall.elapsed() > t);
        if control.interrupt.load(Ordering::Relaxed) || overdue {
            return Ok(true);
        }
        let start = Instant::now();
        let due = (files.written + CHUNK).min(plan.samples);
        let mut outcome = Ok(());
        while outcome.is_ok() && simulation.recorder.samples_taken() < due {
            outcome = simulation.advance(plan);
            let slow = start.elapsed() > Duration::from_millis(500);
            if slow || control.interrupt.load(Ordering::Relaxed) {
                break;
            }
        }
        simulation.solver_seconds += start.elapsed().as_secs_f64();
        outcome?;
        let full = simulation.recorder.samples_taken() == due;
        if full || last_sync.elapsed() > Duration::from_secs(4) {
            files.append(plan, simulation)?;
            write_progress(&out.join("progress.json"), &progress(plan, simulation, "running"))?;
            last_sync = Instant::now();
        }
        (control.progress)(simulation.recorder.samples_taken(), plan.samples, simulation.solver_seconds);
    }
    Ok(false)
}

fn progress(plan: &Plan, simulation: &Simulation, status: &str) -> Value {
    let done = simulation.recorder.samples_taken();
    json!({
        "status": status, "samples_done": done, "samples": plan.samples,
        "elapsed_time_s": plan.time_first() + done.saturating_sub(1) as f64 * plan.sample_dt,
        "solver_s": simulation.solver_seconds,
    })
}

/// SHA-256 in hexadecimal.
pub fn sha256(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|b| format!("{b:02x}")).collect()
}

/// Start of the run's time axis (elapsed time 0), ISO 8601.
pub fn start_iso(plan: &Plan) -> Option<String> {
    let start = plan.input.motion.start? + plan.lead as f64 * plan.sample_dt;
    Some(crate::calendar::iso8601(start))
}

struct Files {
    stations: Option<StationsWriter>,
    field: Option<FieldWriter>,
    ledger: Option<LedgerWriter>,
    inputs: Vec<Trace>,
    provenance: Provenance,
    folder: std::path::PathBuf,
    written: usize,
}

impl Files {
    fn create(
        out: &Path,
        scene: &Scene,
        plan: &Plan,
        resolved: &str,
        history: &str,
    ) -> Result<Self, RunError> {
        std::fs::create_dir_all(out)
            .map_err(|cause| OutputError::UnwritableFolder { folder: out.to_path_buf(), cause })?;
        // what an earlier run left must not pass for this one's
        for name in ["summary.json", "progress.json", "report.html", "field.nc"] {
            match std::fs::remove_file(out.join(name)) {
                Err(cause) if cause.kind() != std::io::ErrorKind::NotFound => {
                    return Err(OutputError::UnwritableFolder { folder: out.to_path_buf(), cause }.into());
                }
                _ => {}
            }
        }
        crate::outputs::replace_bytes(&out.join("scene.resolved.toml"), resolved.as_bytes(), true)?;
        let record_sha256 = (plan.input.channels.iter())
            .filter_map(|c| c.get("sha256").and_then(Value::as_str).map(str::to_owned))
            .collect();
        let provenance = Provenance {
            title: scene.title.clone(),
            hati_version: env!("CARGO_PKG_VERSION").into(),
            history: history.into(),
            start: start_iso(plan),
            scene_sha256: sha256(resolved.as_bytes()),
            record_sha256,
            accuracy: Some(scene.accuracy),
            record_steps: json!(plan.input.motion.steps),
        };
        let folder = out.to_path_buf();
        Ok(Self { stations: None, field: None, ledger: None, inputs: vec![], provenance, folder, written: 0 })
    }

    fn open_streams(&mut self, plan: &Plan, simulation: &Simulation) -> Result<(), RunError> {
        let layout = |t: &Trace| TraceLayout { place: t.place.clone(), depth: t.depth, axis: t.axis };
        self.inputs = if plan.imposed() { vec![] } else { simulation.outcrop_traces(plan) };
        let layouts: Vec<TraceLayout> =
            simulation.recorder.traces.iter().chain(&self.inputs).map(layout).collect();
        self.stations =
            Some(StationsWriter::create(&self.folder.join("stations.nc"), &self.provenance, &layouts)?);
        if !plan.field_depths.is_empty() {
            let path = self.folder.join("field.nc");
            let points = simulation.column.element_point_depths();
            self.field =
                Some(FieldWriter::create(&path, &self.provenance, &plan.axes, &plan.field_depths, &points)?);
        }
        self.ledger = Some(LedgerWriter::create(&self.folder.join("ledger.nc"), &self.provenance)?);
        Ok(())
    }

    fn append(&mut self, plan: &Plan, simulation: &mut Simulation) -> Result<(), RunError> {
        let recorder = &mut simulation.recorder;
        let range = self.written..recorder.samples_taken();
        if range.is_empty() {
            return Ok(());
        }
        let time = &recorder.time[range.clone()];
        if let Some(stations) = &mut self.stations {
            let chunks: Vec<TraceChunk<'_>> = recorder
                .traces
                .iter()
                .chain(&self.inputs)
                .map(|t| TraceChunk::of(t, range.clone()))
                .collect();
            stations.append(time, &chunks)?;
        }
        if let Some(field) = &mut self.field {
            let chunks: Vec<FieldChunk<'_>> = (recorder.field.iter().zip(&plan.axes))
                .map(|(rows, &axis)| FieldChunk {
                    axis,
                    displacement: &rows.displacement,
                    velocity: &rows.velocity,
                    acceleration: &rows.acceleration,
                })
                .collect();
            field.append(time, &chunks)?;
        }
        if let Some(ledger) = &mut self.ledger {
            ledger.append(&recorder.ledger_rows[range])?;
        }
        for rows in &mut recorder.field {
            rows.displacement.clear();
            rows.velocity.clear();
            rows.acceleration.clear();
        }
        self.written = recorder.samples_taken();
        Ok(())
    }

    fn finish(&mut self, simulation: &Simulation, closing_error: f64) -> Result<(), RunError> {
        if let Some(stations) = self.stations.take() {
            stations.finish()?;
        }
        if let Some(mut field) = self.field.take() {
            field.write_peaks(&simulation.recorder.peaks)?;
            field.finish()?;
        }
        if let Some(ledger) = self.ledger.take() {
            ledger.finish(closing_error)?;
        }
        Ok(())
    }
}

/// What a run leaves in its folder, besides its progress.
fn outputs(plan: &Plan) -> Vec<&'static str> {
    let field = if plan.field_depths.is_empty() { None } else { Some("field.nc") };
    let rest = ["ledger.nc", "report.html", "figures/", "summary.json"];
    ["scene.resolved.toml", "stations.nc"].into_iter().chain(field).chain(rest).collect()
}

fn summary(scene: &Scene, plan: &Plan, simulation: &Simulation, status: &str) -> Value {
    let ledger = &simulation.recorder.ledger;
    let steps_done = simulation.column.steps_taken();
    let work = steps_done as f64 * plan.points() as f64 * plan.axes.len() as f64;
    let scale = plan.input.scale.as_ref().map(|(factor, why)| json!({ "factor": factor, "why": why }));
    json!({
        "title": scene.title, "hati_version": env!("CARGO_PKG_VERSION"), "format_version": 1, "status": status,
        "accuracy": { "asked": scene.accuracy, "predicted": plan.search.chosen.error },
        "record": {
            "channels": plan.input.channels, "scale": scale, "steps": plan.input.motion.steps,
            "start": start_iso(plan), "kind": scene.motion().kind.as_str(),
            "deconvolution_amplification": plan.amplification,
        },
        "model": plan.model_json(),
        "plan": plan.reasons.iter().map(|r| format!("{} = {}: {}", r.key, r.value, r.why)).collect::<Vec<_>>(),
        "energy": {
            "closing_error": ledger.closing_error(), "input": ledger.last.input, "viscous": ledger.last.viscous,
            "outflow": ledger.last.outflow, "stored_end": ledger.last.stored(), "stored_max": ledger.stored_max,
        },
        "cost": {
            "solver_s": simulation.solver_seconds,
            "steps_s": simulation.step_seconds,
            "ns_per_point_component_step": 1e9 * simulation.step_seconds / work.max(1.0),
            "solver_estimated_s": plan.seconds(),
        },
        "outputs": outputs(plan),
        "warnings": plan.warnings,
        "results": measures_by_place(plan, simulation),
        "transfer": transfer_peaks(plan, simulation),
        "same_bits_for_any_thread_count": true,
    })
}

/// Peaks, intensities and durations: `{place: {axis: {pga, …}}}`.
fn measures_by_place(plan: &Plan, simulation: &Simulation) -> Value {
    let taken = simulation.recorder.samples_taken();
    let mut places = serde_json::Map::new();
    for t in simulation.outcrop_traces(plan).iter().chain(&simulation.recorder.traces) {
        let a = &t.acceleration[..taken.min(t.acceleration.len())];
        let mut m = measures_json(&Measures::of(a, plan.sample_dt, plan.band.0));
        m["depth"] = json!(t.depth);
        let entry = places.entry(t.place.clone()).or_insert_with(|| json!({}));
        entry[AXES[t.axis].to_string()] = m;
    }
    Value::Object(places)
}

/// A ratio of the run's own spectra.
pub struct Ratio {
    /// `surface/outcrop` or `surface/within`.
    pub name: String,
    /// Component.
    pub axis: usize,
    /// Frequencies, Hz, where the denominator carries energy.
    pub frequency: Vec<f64>,
    /// The ratio there.
    pub ratio: Vec<Complex64>,
}

/// Share of the largest amplitude of the denominator below which a ratio of spectra is not shown.
const RATIO_FLOOR: f64 = 1e-3;

/// Surface/outcrop and surface/within of every component, from the run's own motions.
pub fn transfer_ratios(plan: &Plan, simulation: &Simulation) -> Vec<Ratio> {
    let outcrop = simulation.outcrop_traces(plan);
    let mut ratios = vec![];
    for &axis in &plan.axes {
        let spectrum = |place: &str| {
            let all = outcrop.iter().chain(&simulation.recorder.traces);
            let t = all.into_iter().find(|t| t.place == place && t.axis == axis)?;
            Some(band_spectrum(&t.acceleration, plan.sample_dt, plan.band))
        };
        let Some((frequency, surface)) = spectrum("surface") else { continue };
        for place in ["outcrop", "within"] {
            let Some((_, below)) = spectrum(place).filter(|(f, _)| f.len() == frequency.len()) else {
                continue;
            };
            let floor = RATIO_FLOOR * below.iter().map(|b| b.norm()).fold(0.0, f64::max);
            let (frequency, ratio) = (0..frequency.len())
                .filter(|&k| below[k].norm() > floor)
                .map(|k| (frequency[k], surface[k] / below[k]))
                .unzip();
            ratios.push(Ratio { name: format!("surface/{place}"), axis, frequency, ratio });
        }
    }
    ratios
}

/// Largest value of each of the run's own transfer functions and its frequency.
fn transfer_peaks(plan: &Plan, simulation: &Simulation) -> Value {
    let peak = |r: &Ratio| {
        let top = (r.frequency.iter().zip(&r.ratio)).max_by(|a, b| a.1.norm().total_cmp(&b.1.norm()));
        top.map(|(f, value)| {
            json!({ "name": r.name, "axis": AXES[r.axis].to_string(), "run_peak": value.norm(), "run_frequency": f })
        })
    };
    Value::Array(transfer_ratios(plan, simulation).iter().filter_map(peak).collect())
}
