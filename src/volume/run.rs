//! The time loop of a run in two or three dimensions.

use super::checkpoint::{self, Head};
use super::error::VolumeError;
use super::files::Streams;
use super::plan::VolumePlan;
use super::{report, summary};
use crate::outputs::{OutputError, Provenance, write_progress, write_summary};
use crate::results::LedgerRow;
use crate::run::{RunError, sha256};
use hati_coupling::{CouplingError, Ledger, Subdomain};
use hati_inputs::scene::{Precision, Scene, resolved_toml};
use hati_sem::solid::{Execution, Real, Solid};
use serde_json::{Value, json};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Steps between rows of the ledger, where it gets its hundred rows: one costs about a step.
const LEDGER_STEPS: usize = 64;
/// Steps between rows of a short run's ledger at least.
const LEDGER_STEPS_LEAST: usize = 20;
/// Rows below which the ledger's figure would have corners.
const LEDGER_ROWS: usize = 100;
/// Wall time between progress reports, and between syncs.
const TELL: Duration = Duration::from_millis(500);
const SYNC: Duration = Duration::from_secs(4);

/// What the caller wants of a run besides its results.
pub struct VolumeControl<'a> {
    /// Set from outside to stop at the next sample.
    pub interrupt: &'a AtomicBool,
    /// Stops as if interrupted after this wall time.
    pub max_wall_time: Option<Duration>,
    /// Told about progress: samples done, samples in all, seconds of the loop.
    pub progress: &'a mut (dyn FnMut(usize, usize, f64) + Send),
    /// Command line for the files' history.
    pub history: String,
    /// Goes on from the folder's checkpoint, if it has one.
    pub restart: bool,
}

/// How a run ended.
#[derive(Debug, Clone)]
pub struct Outcome {
    /// The content of `summary.json`.
    pub summary: Value,
    /// Whether it was interrupted; the folder then holds a checkpoint.
    pub interrupted: bool,
    /// What a restart found, in words.
    pub note: Option<String>,
}

/// Counts of a run under way.
pub(super) struct Progress {
    pub(super) sample: usize,
    pub(super) ledger: Ledger,
    pub(super) input_max: f64,
    pub(super) seconds: f64,
    pub(super) step_seconds: f64,
    pub(super) restarts: usize,
    pub(super) waited: f64,
    pub(super) checkpoints: usize,
}

/// Runs a planned scene into a folder, or goes on with it. Call it inside the `rayon` pool of [`VolumePlan::threads`].
///
/// The folder then holds `scene.resolved.toml`, `stations.nc`, `surface.nc`, `volume.nc`, `field.nc`, `ledger.nc`,
/// `summary.json`, `report.html` and `progress.json`; while it runs, or when it was interrupted, `checkpoint.hati`.
///
/// # Errors
/// Too little memory, what cannot be written, a checkpoint of another scene, growth without physical cause.
pub fn run(
    scene: &Scene,
    plan: &VolumePlan,
    out: &Path,
    control: &mut VolumeControl<'_>,
) -> Result<Outcome, VolumeError> {
    plan.check_memory()?;
    match plan.precision {
        Precision::F32 => run_in::<f32>(scene, plan, out, control),
        Precision::F64 => run_in::<f64>(scene, plan, out, control),
    }
}

/// What an earlier run may have left under names of this one.
const LEFT: [&str; 8] = [
    "summary.json",
    "progress.json",
    "report.html",
    "stations.nc",
    "surface.nc",
    "volume.nc",
    "field.nc",
    checkpoint::NAME,
];

fn prepare(out: &Path, anew: bool) -> Result<(), OutputError> {
    let unwritable = |cause| OutputError::UnwritableFolder { folder: out.to_path_buf(), cause };
    std::fs::create_dir_all(out).map_err(unwritable)?;
    for name in LEFT.iter().filter(|_| anew) {
        match std::fs::remove_file(out.join(name)) {
            Err(cause) if cause.kind() != std::io::ErrorKind::NotFound => return Err(unwritable(cause)),
            _ => {}
        }
    }
    Ok(())
}

/// What makes two runs the same: the resolved scene, the files that it names, and the program.
fn hash(plan: &VolumePlan, resolved: &str) -> String {
    let mut text = format!("hati {}\n{resolved}", env!("CARGO_PKG_VERSION"));
    text.extend(plan.file.iter().map(|f| f.sha256.as_str()));
    text.extend(plan.record_sha256.iter().map(String::as_str));
    sha256(text.as_bytes())
}

fn run_in<T: Real>(
    scene: &Scene,
    plan: &VolumePlan,
    out: &Path,
    control: &mut VolumeControl<'_>,
) -> Result<Outcome, VolumeError> {
    let wall = Instant::now();
    let resolved = resolved_toml(scene, &plan.resolved);
    let hash = hash(plan, &resolved);
    let found = if control.restart { checkpoint::open(out, &hash)? } else { None };
    let mut note = None;
    if control.restart && found.is_none() {
        if let Some(summary) = finished(out, &hash) {
            let note = Some("the run is finished already: nothing was done".to_owned());
            return Ok(Outcome { summary, interrupted: false, note });
        }
        note = Some("there is no checkpoint: the run starts from its beginning".to_owned());
    }
    prepare(out, found.is_none())?;
    crate::outputs::replace_bytes(&out.join("scene.resolved.toml"), resolved.as_bytes(), true)?;
    let provenance = provenance(scene, plan, &resolved, &control.history);
    let execution = Execution { threads: plan.threads, ..Execution::default() };
    let mut solid = Solid::<T>::new(&plan.ground, plan.sampling.dt, plan.dt_critical, execution);
    if let Some(found) = &found {
        note = Some(format!("going on from sample {} of {}", found.head.sample, plan.sampling.samples));
    }
    let (mut streams, mut progress) = open_streams(plan, &mut solid, out, &provenance, found)?;
    let mut looped = Loop { plan, out, control, wall, hash: &hash };
    let ended = looped.run(&mut solid, &mut streams, &mut progress);
    let status = match &ended {
        Ok(false) => "finished",
        Ok(true) => "interrupted",
        Err(VolumeError::Run(RunError::Coupling(_))) => "unstable",
        Err(_) => "failed",
    };
    if status == "failed" {
        return ended.map(|_| Outcome { summary: Value::Null, interrupted: false, note });
    }
    looped.close(&solid, streams, &mut progress, status)?;
    let (bytes, metrics) = (solid.bytes(), solid.metrics());
    drop(solid);
    write_progress(&out.join("progress.json"), &telling(plan, &progress, status))?;
    let traces = report::traces(plan, out)?;
    let mut summary = summary::summary(scene, plan, &progress, &traces, status);
    summary["scene_hash"] = json!(hash);
    summary["cost"]["bytes_of_solid"] = json!(bytes);
    summary["model"]["metric_of_run"] = json!(metrics);
    if status != "unstable" {
        report::report(scene, plan, &summary, &traces, out)?;
    }
    summary["cost"]["wall_s"] = json!(wall.elapsed().as_secs_f64());
    write_summary(&out.join("summary.json"), &summary)?;
    let interrupted = ended?;
    if !interrupted {
        checkpoint::remove(out);
    }
    Ok(Outcome { summary, interrupted, note })
}

/// Opens the files, new or as a checkpoint counts them, and gives everything the state that it keeps.
fn open_streams<T: Real>(
    plan: &VolumePlan,
    solid: &mut Solid<T>,
    out: &Path,
    provenance: &Provenance,
    found: Option<checkpoint::Found>,
) -> Result<(Streams, Progress), VolumeError> {
    let Some(mut found) = found else {
        let streams = Streams::open(plan, solid, out, provenance, None, false)?;
        return Ok((streams, Progress::new(solid, None)));
    };
    let head = found.head.clone();
    let mut streams = Streams::open(plan, solid, out, provenance, Some(&head.rows), head.complete)?;
    found.restore(&mut streams, solid)?;
    Ok((streams, Progress::new(solid, Some(&head))))
}

/// Summary of a folder whose run of the same scene is finished.
fn finished(out: &Path, hash: &str) -> Option<Value> {
    let text = std::fs::read_to_string(out.join("summary.json")).ok()?;
    let summary: Value = serde_json::from_str(&text).ok()?;
    let same = summary["scene_hash"] == hash && summary["status"] == "finished";
    same.then_some(summary)
}

fn provenance(scene: &Scene, plan: &VolumePlan, resolved: &str, history: &str) -> Provenance {
    Provenance {
        title: scene.title.clone(),
        hati_version: env!("CARGO_PKG_VERSION").into(),
        history: history.into(),
        start: None,
        scene_sha256: sha256(resolved.as_bytes()),
        record_sha256: plan.record_sha256.clone(),
        accuracy: Some(scene.accuracy),
        record_steps: plan.file.as_ref().map_or(Value::Null, |f| json!({ "mesh_sha256": f.sha256 })),
    }
}

fn telling(plan: &VolumePlan, progress: &Progress, status: &str) -> Value {
    json!({
        "status": status, "samples_done": progress.sample, "samples": plan.sampling.samples,
        "elapsed_time_s": progress.sample.saturating_sub(1) as f64 * plan.sampling.sample_dt(),
        "solver_s": progress.seconds,
    })
}

impl Progress {
    fn new<T: Real>(solid: &mut Solid<T>, head: Option<&Head>) -> Self {
        let ledger = head.map_or_else(|| Ledger::start(&solid.energies()), |h| h.ledger);
        let [seconds, step_seconds] = head.map_or([0.0; 2], |h| h.seconds);
        Self {
            sample: head.map_or(0, |h| h.sample),
            ledger,
            input_max: head.map_or(0.0, |h| h.input_max),
            seconds,
            step_seconds,
            restarts: head.map_or(0, |h| h.restarts + 1),
            waited: 0.0,
            checkpoints: 0,
        }
    }
}

struct Loop<'a, 'c> {
    plan: &'a VolumePlan,
    out: &'a Path,
    control: &'a mut VolumeControl<'c>,
    wall: Instant,
    hash: &'a str,
}

impl Loop<'_, '_> {
    /// Steps to the end; true when it was interrupted, with a checkpoint.
    fn run<T: Real>(
        &mut self,
        solid: &mut Solid<T>,
        streams: &mut Streams,
        progress: &mut Progress,
    ) -> Result<bool, VolumeError> {
        let sampling = self.plan.sampling;
        let apart = (sampling.steps() as usize / LEDGER_ROWS).clamp(LEDGER_STEPS_LEAST, LEDGER_STEPS);
        let ledger_every = apart.div_ceil(sampling.stride);
        let (mut told, mut synced, mut kept) = (Instant::now(), Instant::now(), Instant::now());
        while progress.sample < sampling.samples {
            let overdue = self.control.max_wall_time.is_some_and(|t| self.wall.elapsed() > t);
            if self.control.interrupt.load(Ordering::Relaxed) || overdue {
                self.checkpoint(solid, streams, progress, false)?;
                return Ok(true);
            }
            let start = Instant::now();
            let outcome = self.sample(solid, streams, progress, ledger_every);
            progress.seconds += start.elapsed().as_secs_f64();
            outcome?;
            if told.elapsed() > TELL {
                told = Instant::now();
                (self.control.progress)(progress.sample, sampling.samples, progress.seconds);
            }
            if synced.elapsed() > SYNC {
                synced = Instant::now();
                streams.sync()?;
                write_progress(&self.out.join("progress.json"), &telling(self.plan, progress, "running"))?;
            }
            if kept.elapsed() > self.plan.checkpoint_every {
                self.checkpoint(solid, streams, progress, false)?;
                kept = Instant::now();
            }
        }
        Ok(false)
    }

    /// Takes a sample and steps to the next one.
    fn sample<T: Real>(
        &self,
        solid: &mut Solid<T>,
        streams: &mut Streams,
        progress: &mut Progress,
        ledger_every: usize,
    ) -> Result<(), VolumeError> {
        let sampling = &self.plan.sampling;
        let sample = progress.sample;
        let time = sample as f64 * sampling.sample_dt();
        let mut stepped = 0.0;
        let mut step = |solid: &mut Solid<T>, count: usize| {
            let start = Instant::now();
            (0..count).for_each(|_| solid.step());
            stepped += start.elapsed().as_secs_f64();
        };
        streams.before(solid, sample);
        step(solid, 1);
        streams.after(self.plan, solid, sample, time)?;
        let last = sample + 1 == sampling.samples;
        if !last {
            step(solid, sampling.stride - 1);
        }
        progress.sample += 1;
        progress.step_seconds += stepped;
        if last || progress.sample.is_multiple_of(ledger_every) || streams.broken {
            self.book(solid, streams, progress)?;
        }
        Ok(())
    }

    /// Books the energies and looks for growth without cause.
    fn book<T: Real>(
        &self,
        solid: &mut Solid<T>,
        streams: &mut Streams,
        progress: &mut Progress,
    ) -> Result<(), VolumeError> {
        let energies = solid.energies();
        progress.input_max = progress.input_max.max(energies.input);
        let unphysical = energies.kinetic > 4.0 * progress.input_max && energies.kinetic > 0.0;
        if streams.broken || !energies.kinetic.is_finite() || unphysical {
            return Err(VolumeError::Run(self.unstable(solid).into()));
        }
        let residual = progress.ledger.book(&energies);
        streams.book(&LedgerRow {
            time: solid.time(),
            input: energies.input,
            kinetic: energies.kinetic,
            strain: energies.strain,
            viscous: energies.viscous,
            outflow: energies.outflow,
            residual,
        })?;
        Ok(())
    }

    fn unstable<T: Real>(&self, solid: &Solid<T>) -> CouplingError {
        let (speed, point) = solid.fastest_point();
        let ground = &self.plan.ground;
        let element = (0..ground.mesh().len())
            .find(|&e| ground.numbering().element(e).contains(&point))
            .unwrap_or_default();
        let place = super::explain::place(ground.mesh().centre(element), self.plan.dimension);
        let material = &ground.material(element).name;
        CouplingError::Unstable {
            subdomain: solid.name().into(),
            time: solid.time(),
            symptom: format!(
                "kinetic energy beyond all energy that came in; fastest point {speed:.3e} m/s in element {element} of \
                 `{material}` around {place}"
            ),
            dt: solid.dt(),
            dt_critical: self.plan.dt_critical,
            likely: "the step is below its critical value, so either numbers left the range of the precision (try \
                     discretisation.precision = \"f64\") or this is a fault of the program: please report the scene"
                .into(),
        }
    }

    /// Ends the files: compressed where the run is finished, else as they are.
    fn close<T: Real>(
        &self,
        solid: &Solid<T>,
        mut streams: Streams,
        progress: &mut Progress,
        status: &str,
    ) -> Result<(), OutputError> {
        progress.waited = streams.waited();
        let closing = progress.ledger.closing_error();
        if status == "finished" {
            // from here on a kill leaves some files finished and some not: the checkpoint says that the loop is done
            self.checkpoint(solid, &mut streams, progress, true)?;
            streams.finish(closing)
        } else {
            streams.leave(closing)
        }
    }

    /// Brings all rows to the disk and writes the checkpoint that counts them.
    fn checkpoint<T: Real>(
        &self,
        solid: &Solid<T>,
        streams: &mut Streams,
        progress: &mut Progress,
        complete: bool,
    ) -> Result<(), OutputError> {
        let rows = streams.sync()?;
        progress.checkpoints += 1;
        let head = Head {
            hash: self.hash.to_owned(),
            sample: progress.sample,
            complete,
            rows,
            streams: 0,
            ledger: progress.ledger,
            input_max: progress.input_max,
            seconds: [progress.seconds, progress.step_seconds],
            restarts: progress.restarts,
        };
        checkpoint::write(self.out, head, streams, solid)
    }
}

#[cfg(test)]
mod tests;
