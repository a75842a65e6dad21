//! `plan` and `run` of a scene in two or three dimensions.

use super::arguments::{RunArguments, SceneArguments};
use super::{Exit, Failure, default_folder, note, now, print, print_json, show, tell};
use crate::export::{Wanted, export};
use crate::volume::{MeshOptions, VolumeControl, VolumeError, VolumePlan, run};
use hati_inputs::records::ReadOptions;
use hati_inputs::scene::Scene;
use serde_json::Value;
use std::path::Path;
use std::sync::atomic::AtomicBool;

impl From<VolumeError> for Failure {
    fn from(e: VolumeError) -> Self {
        match e {
            VolumeError::Run(e) => e.into(),
            VolumeError::Threads { .. } => Self::new(Exit::Machine, e),
            _ => Self::input(e),
        }
    }
}

/// Threads: as many as asked, else all of the machine.
fn threads(asked: Option<u16>) -> usize {
    let all = || std::thread::available_parallelism().map_or(1, std::num::NonZeroUsize::get);
    asked.map_or_else(all, usize::from)
}

/// Does something in a pool of so many threads.
fn within<R: Send>(threads: usize, work: impl FnOnce() -> R + Send) -> Result<R, VolumeError> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    let pool = pool.map_err(|why| VolumeError::Threads { threads, why: why.to_string() })?;
    Ok(pool.install(work))
}

/// Reads the mesh of a scene, if it has one, and compares its names with the scene's. A script is not run without leave: the
/// scene may be sound, which only its mesh can tell.
pub(super) fn check_mesh(scene: &Scene, a: &SceneArguments) -> Result<(), Failure> {
    let Some(name) = scene.domain.as_ref().and_then(|d| d.mesh.as_deref()) else { return Ok(()) };
    let scripted = Path::new(name).extension().is_some_and(|e| e.eq_ignore_ascii_case("geo"));
    if scripted && !a.allow_scripts {
        note(&format!("{name} was not run: with --allow-scripts its mesh is checked too"));
        return Ok(());
    }
    let folder = scratch();
    let options = MeshOptions { allow_scripts: a.allow_scripts, folder: &folder };
    let made = crate::volume::mesh::read(scene, &options);
    let _ = std::fs::remove_dir_all(&folder);
    if let Some((mesh, file)) = made? {
        let order = scene.discretisation.order.value().copied().unwrap_or(crate::volume::sizes::ORDER);
        crate::volume::mesh::checked(&mesh, order, Some(&file))?;
        file.notes.iter().for_each(|text| note(text));
    }
    Ok(())
}

/// A folder for what a verb that leaves nothing behind makes.
fn scratch() -> std::path::PathBuf {
    std::env::temp_dir().join(format!("hati-plan-{}", std::process::id()))
}

pub(super) fn plan_verb(scene: &Scene, a: &SceneArguments, json: bool) -> Result<Exit, Failure> {
    let threads = threads(None);
    // a plan leaves nothing behind, the mesh of a script least of all
    let folder = scratch();
    let options = MeshOptions { allow_scripts: a.allow_scripts, folder: &folder };
    let plan = within(threads, || VolumePlan::new(scene, threads, &options));
    let _ = std::fs::remove_dir_all(&folder);
    let plan = plan??;
    if json {
        print_json(&plan.to_json())?;
    } else {
        print(&plan.text(&scene.title))?;
    }
    plan.check_memory()?;
    Ok(Exit::Fine)
}

pub(super) fn run_verb(
    scene: &Scene,
    a: &RunArguments,
    flag: &AtomicBool,
    json: bool,
) -> Result<Exit, Failure> {
    let threads = threads(a.threads);
    let out = a.out.clone().unwrap_or_else(|| default_folder(&a.scene.scene));
    let start = std::time::Instant::now();
    let options = MeshOptions { allow_scripts: a.scene.allow_scripts, folder: &out };
    let outcome = within(threads, || -> Result<_, VolumeError> {
        let plan = VolumePlan::new(scene, threads, &options)?;
        if !json {
            tell(&plan.text(&scene.title));
        }
        let mut meter = show::Meter::new(plan.sampling.samples);
        let mut control = VolumeControl {
            interrupt: flag,
            max_wall_time: a.max_wall_time.map(|t| t.saturating_sub(start.elapsed())),
            progress: &mut |done, all, seconds| meter.update(done, all, seconds),
            history: format!("{} hati {} run {}", now(), env!("CARGO_PKG_VERSION"), a.scene.scene.display()),
            restart: a.restart,
        };
        let outcome = run(scene, &plan, &out, &mut control);
        meter.finish();
        outcome
    })??;
    outcome.note.iter().for_each(|text| note(text));
    if scene.output.vtkhdf && !outcome.interrupted {
        let wanted = Wanted { vtkhdf: true, ..Wanted::default() };
        export(&out, &out, &wanted, &ReadOptions::default())?;
    }
    if json {
        print_json(&outcome.summary)?;
    } else {
        tell(&text(&outcome.summary));
        print(&format!("{}\n", out.join("report.html").display()))?;
    }
    if outcome.interrupted {
        note(&format!("interrupted: --restart with the same folder ({}) goes on", shown(&out)));
        return Ok(Exit::Interrupted);
    }
    Ok(Exit::Fine)
}

fn shown(path: &Path) -> String {
    path.display().to_string()
}

/// The end of a run.
fn text(summary: &Value) -> String {
    use std::fmt::Write as _;
    let number = |path: &str| summary.pointer(path).and_then(Value::as_f64).unwrap_or(f64::NAN);
    let mut text = format!(
        "{}: loop {:.2} s ({:.1} ns per point and step, {:.2} M element-steps/s), in all {:.2} s; energy closes to {:.1e}\n",
        summary["status"].as_str().unwrap_or("ended"),
        number("/cost/solver_s"),
        number("/cost/ns_per_point_step"),
        1e-6 * number("/cost/element_steps_per_s"),
        number("/cost/wall_s"),
        number("/energy/closing_error"),
    );
    for (place, axes) in summary["results"].as_object().into_iter().flatten() {
        let of = |axis: &str| axes.pointer(&format!("/{axis}/pga")).and_then(Value::as_f64);
        let peaks: Vec<String> =
            ["x", "y", "z"].iter().filter_map(|c| Some(format!("{c} {:.4e}", of(c)?))).collect();
        if !peaks.is_empty() {
            let _ = writeln!(text, "  PGA {place}: {} m/s²", peaks.join(", "));
        }
    }
    text
}
