//! Command line: verbs, options, exit codes.
//!
//! | code | meaning |
//! |---|---|
//! | 0 | fine |
//! | 1 | outside the accuracy asked, or a failed `verify` |
//! | 2 | wrong input |
//! | 3 | unstable |
//! | 4 | machine: disk, memory, a folder that cannot be written |
//! | 5 | interrupted; the files are valid up to that instant, and `--restart` goes on |
//!
//! Results for machines go to stdout (one JSON value with `--json`), everything else to stderr.
mod arguments;
mod export;
mod record;
mod record_table;
mod show;
mod volume;

use crate::outputs::OutputError;
use crate::plan::{Plan, PlanError};
use crate::run::{RunControl, RunError, run};
use crate::verify::Check;
use arguments::{Arguments, RunArguments, SceneArguments, Verb, VerifyArguments};
use clap::Parser;
use hati_inputs::scene::{self, Scene};
use serde_json::{Value, json};
use std::io::{ErrorKind, Write as _};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

/// Exit codes; see the module's table.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Exit {
    /// 0
    Fine = 0,
    /// 1
    OutsideAccuracy = 1,
    /// 2
    WrongInput = 2,
    /// 3
    Unstable = 3,
    /// 4
    Machine = 4,
    /// 5
    Interrupted = 5,
}

/// An error with the exit code that it deserves.
struct Failure {
    exit: Exit,
    text: String,
}

impl Failure {
    fn new(exit: Exit, text: impl ToString) -> Self {
        Self { exit, text: text.to_string() }
    }

    fn input(text: impl ToString) -> Self {
        Self::new(Exit::WrongInput, text)
    }
}

impl From<PlanError> for Failure {
    fn from(e: PlanError) -> Self {
        let exit = if e.is_memory() { Exit::Machine } else { Exit::WrongInput };
        Self::new(exit, e)
    }
}

impl From<RunError> for Failure {
    fn from(e: RunError) -> Self {
        let exit = match &e {
            RunError::Plan(e) if e.is_memory() => Exit::Machine,
            RunError::Scene(_) | RunError::Plan(_) | RunError::Sem(_) => Exit::WrongInput,
            RunError::Output(_) => Exit::Machine,
            RunError::Coupling(hati_coupling::CouplingError::Unstable { .. }) => Exit::Unstable,
            RunError::Coupling(_) => Exit::WrongInput,
        };
        Self::new(exit, e)
    }
}

/// Prints a line to stderr.
pub fn note(text: &str) {
    tell(&format!("hati: {text}\n"));
}

/// Writes to stderr. A reader that has gone away does not stop a run.
fn tell(text: &str) {
    let _ = std::io::stderr().write_all(text.as_bytes());
}

/// Writes to stdout. A reader that has seen enough (`hati schema | head`) is no failure, a full disk is.
fn print(text: &str) -> Result<(), Failure> {
    let mut stdout = std::io::stdout().lock();
    match stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush()) {
        Err(cause) if cause.kind() != ErrorKind::BrokenPipe => {
            Err(Failure::new(Exit::Machine, format!("cannot write to standard output: {cause}")))
        }
        _ => Ok(()),
    }
}

/// Parses the command line and runs the verb.
pub fn main() -> ExitCode {
    let arguments = match Arguments::try_parse() {
        Ok(arguments) => arguments,
        Err(refusal) => return refused(&refusal),
    };
    let json = arguments.json;
    let outcome = match arguments.verb {
        Verb::Check(a) => check(&a, json),
        Verb::Plan(a) => plan(&a, json),
        Verb::Run(a) => run_verb(&a, json),
        Verb::Record(a) => record::record(&a, json),
        Verb::Export(a) => export::export_verb(&a, json),
        Verb::Schema { markdown } => schema(markdown),
        Verb::Chart(a) => chart(&a, json),
        Verb::Verify(a) => verify(&a, json),
    };
    match outcome {
        Ok(exit) => ExitCode::from(exit as u8),
        Err(failure) => report_failure(&failure, json),
    }
}

fn report_failure(failure: &Failure, json: bool) -> ExitCode {
    note(&failure.text);
    if json {
        // what failed may be stdout itself: the exit code tells all the same
        let _ = print(&format!("{}\n", json!({ "error": failure.text, "exit": failure.exit as u8 })));
    }
    ExitCode::from(failure.exit as u8)
}

/// Help and version go to stdout; a command line that cannot be read is wrong input.
fn refused(refusal: &clap::Error) -> ExitCode {
    let _ = refusal.print();
    if !refusal.use_stderr() {
        return ExitCode::from(Exit::Fine as u8);
    }
    if std::env::args_os().any(|a| a == "--json") {
        let text = refusal.render().to_string();
        let text = text.trim_start_matches("error: ").trim_end();
        let _ = print(&format!("{}\n", json!({ "error": text, "exit": Exit::WrongInput as u8 })));
    }
    ExitCode::from(Exit::WrongInput as u8)
}

fn print_json(value: &Value) -> Result<(), Failure> {
    print(&format!("{value:#}\n"))
}

/// A scene named by its file or by the folder that holds `scene.toml`.
fn scene_file(path: &Path) -> PathBuf {
    if path.is_dir() { path.join("scene.toml") } else { path.to_path_buf() }
}

fn overrides(a: &SceneArguments) -> Result<Vec<(String, String)>, Failure> {
    a.set
        .iter()
        .map(|s| {
            s.split_once('=').map(|(k, v)| (k.trim().to_string(), v.trim().to_string())).ok_or_else(|| {
                Failure::input(format!("--set {s}: expected key=value, for instance --set accuracy=1e-3"))
            })
        })
        .collect()
}

fn load(a: &SceneArguments) -> Result<Scene, Failure> {
    let scene = scene::load_with(&scene_file(&a.scene), &overrides(a)?).map_err(Failure::input)?;
    scene.source.warnings.iter().for_each(|warning| tell(&format!("{warning}\n")));
    Ok(scene)
}

fn check(a: &SceneArguments, json: bool) -> Result<Exit, Failure> {
    let found = scene::load_with(&scene_file(&a.scene), &overrides(a)?);
    if let Ok(scene) = &found {
        volume::check_mesh(scene, a)?;
    }
    let (diagnostics, exit) = match &found {
        Ok(scene) => (&scene.source.warnings, Exit::Fine),
        Err(diagnostics) => (diagnostics, Exit::WrongInput),
    };
    if json {
        print_json(
            &json!({ "valid": exit == Exit::Fine, "diagnostics": diagnostics.iter().collect::<Vec<_>>() }),
        )?;
    } else {
        diagnostics.iter().for_each(|d| tell(&format!("{d}\n")));
        if exit == Exit::Fine {
            print(&format!("{}: the scene is sound\n", scene_file(&a.scene).display()))?;
        } else {
            tell(&format!("{} to mend\n", show::count(diagnostics.errors().count(), "mistake")));
        }
    }
    Ok(exit)
}

fn plan(a: &SceneArguments, json: bool) -> Result<Exit, Failure> {
    let scene = load(a)?;
    if scene.domain.is_some() {
        return volume::plan_verb(&scene, a, json);
    }
    let plan = Plan::new(&scene)?;
    if json {
        print_json(&plan.to_json())?;
    } else {
        print(&show::plan(&scene, &plan))?;
    }
    Ok(if plan.search.met { Exit::Fine } else { Exit::OutsideAccuracy })
}

fn interrupt_flag() -> Arc<AtomicBool> {
    let flag = Arc::new(AtomicBool::new(false));
    for signal in [signal_hook::consts::SIGINT, signal_hook::consts::SIGTERM] {
        if let Err(cause) = signal_hook::flag::register(signal, flag.clone()) {
            note(&format!(
                "signals cannot be caught ({cause}); an interrupt will cut the files at their last append"
            ));
        }
    }
    flag
}

fn run_verb(a: &RunArguments, json: bool) -> Result<Exit, Failure> {
    let flag = interrupt_flag();
    let scene = load(&a.scene)?;
    if scene.domain.is_some() {
        return volume::run_verb(&scene, a, &flag, json);
    }
    if a.restart {
        note("a column is computed in seconds and keeps no checkpoint: it runs from its beginning");
    }
    let plan = Plan::new(&scene)?;
    let out = a.out.clone().unwrap_or_else(|| default_folder(&a.scene.scene));
    if !json {
        tell(&show::plan(&scene, &plan));
    }
    let mut meter = show::Meter::new(plan.samples);
    let mut control = RunControl {
        interrupt: &flag,
        max_wall_time: a.max_wall_time,
        progress: &mut |done, all, seconds| meter.update(done, all, seconds),
        history: format!("{} hati {} run {}", now(), env!("CARGO_PKG_VERSION"), a.scene.scene.display()),
    };
    let start = std::time::Instant::now();
    let outcome = run(&scene, &plan, &out, &mut control)?;
    meter.finish();
    let (mut summary, interrupted) = (outcome.summary.clone(), outcome.interrupted);
    crate::site_response::report(&scene, &plan, outcome, &out).map_err(RunError::from)?;
    summary["cost"]["wall_s"] = json!(start.elapsed().as_secs_f64());
    crate::outputs::write_summary(&out.join("summary.json"), &summary).map_err(RunError::from)?;
    if json {
        print_json(&summary)?;
    } else {
        tell(&show::summary(&summary));
        print(&format!("{}\n", out.join("report.html").display()))?;
    }
    if interrupted {
        note("interrupted: the files hold the motion up to this instant; run again for the whole of it");
        return Ok(Exit::Interrupted);
    }
    Ok(if plan.search.met { Exit::Fine } else { Exit::OutsideAccuracy })
}

fn default_folder(scene: &Path) -> PathBuf {
    let folder = if scene.is_dir() { Some(scene) } else { scene.parent() };
    let named = folder.and_then(Path::file_name).or_else(|| scene.file_stem());
    let stem = if scene.is_dir() || scene.file_stem().is_some_and(|s| s == "scene") {
        named
    } else {
        scene.file_stem()
    };
    Path::new("runs").join(stem.unwrap_or_else(|| "scene".as_ref()))
}

fn now() -> String {
    let since = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH).unwrap_or_default();
    crate::calendar::iso8601(since.as_secs() as f64)
}

fn schema(markdown: bool) -> Result<Exit, Failure> {
    if markdown {
        print(&scene::reference_markdown())?;
    } else {
        print_json(&json!(scene::schema()))?;
    }
    Ok(Exit::Fine)
}

fn chart(a: &RunArguments, json: bool) -> Result<Exit, Failure> {
    let flag = interrupt_flag();
    let scene = load(&a.scene)?;
    let out = a.out.clone().unwrap_or_else(|| default_folder(&a.scene.scene));
    let begin = Instant::now();
    let mut cut = false;
    let mut told = |line: &str| {
        if !json {
            tell(&format!("{line}\n"));
        }
        cut |= flag.load(Ordering::Relaxed) || a.max_wall_time.is_some_and(|t| begin.elapsed() > t);
        !cut
    };
    let chart = crate::chart::chart(&scene, &out, &mut told)?;
    if json {
        print_json(&chart)?;
    } else {
        print(&format!("{}\n", out.join("chart.html").display()))?;
    }
    if cut {
        note("interrupted: the chart holds the points measured up to this instant");
        return Ok(Exit::Interrupted);
    }
    Ok(Exit::Fine)
}

fn verify(a: &VerifyArguments, json: bool) -> Result<Exit, Failure> {
    all_known(&a.cases)?;
    let mut told = |check: &Check| {
        if !json {
            let line = if a.self_check { show::twisted(check) } else { check.to_string() };
            tell(&format!("{line}\n"));
        }
    };
    let wanted = |name: &str| a.cases.is_empty() || a.cases.iter().any(|c| name.contains(c.as_str()));
    let run = if a.self_check { crate::verify::self_check } else { crate::verify::verify };
    let checks = run(&wanted, a.long, &mut told)?;
    if checks.is_empty() {
        return Err(Failure::input(format!("{}: runs only with --long", a.cases.join(", "))));
    }
    if let Some(out) = &a.out {
        write_figures(out, &crate::verify::figures(&wanted, a.long)?)?;
    }
    // A twisted case that still passes is blind.
    let bad = checks.iter().filter(|c| c.pass == a.self_check).count();
    if json {
        print_json(&json!(checks))?;
    } else {
        let count = show::count(checks.len(), "quantity");
        let line = if a.self_check {
            format!("{count} twisted, {bad} unnoticed\n")
        } else {
            format!("{count} checked, {bad} failed\n")
        };
        print(&line)?;
    }
    Ok(if bad == 0 { Exit::Fine } else { Exit::OutsideAccuracy })
}

/// Writes the figures of cases into a folder.
fn write_figures(out: &Path, figures: &[crate::verify::CaseFigure]) -> Result<(), OutputError> {
    std::fs::create_dir_all(out).map_err(|cause| OutputError::from_io(out, cause))?;
    for f in figures {
        let drawing = (format!("{}.svg", f.name), &f.svg);
        let tables = f.tables.iter().map(|(name, text)| (format!("{name}.csv"), text));
        for (name, text) in std::iter::once(drawing).chain(tables) {
            let path = out.join(name);
            crate::outputs::replace_bytes(&path, text.as_bytes(), false)?;
            tell(&format!("{}\n", path.display()));
        }
    }
    Ok(())
}

/// Refuses a word that no case has in its name, so that a slip of the pen does not skip a case.
fn all_known(cases: &[String]) -> Result<(), Failure> {
    let names = crate::verify::names();
    match cases.iter().find(|case| !names.iter().any(|name| name.contains(case.as_str()))) {
        Some(case) => {
            Err(Failure::input(format!("no case named {case}\n  help: the cases are {}", names.join(", "))))
        }
        None => Ok(()),
    }
}
