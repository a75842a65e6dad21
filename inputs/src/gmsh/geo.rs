//! A `.geo` file meshed by Gmsh, in a process of its own.

use std::fs::{self, File};
use std::path::{Component, Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use crate::error::InputError;
use crate::python::find_python;

/// Gmsh as its wheel offers it, without the options that a user's home may hold: the same file gives the
/// same mesh.
const SCRIPT: &str = "import sys, gmsh
gmsh.initialize(['gmsh'] + sys.argv[1:], readConfigFiles=False, run=True)
gmsh.finalize()";
/// How much of the end of Gmsh's messages goes into an error, bytes.
const MESSAGES_TAIL: usize = 2000;

/// What to mesh, and under which conditions.
#[derive(Debug, Clone)]
pub struct GeoRun<'a> {
    /// The `.geo` file: relative to the scene's folder, or absolute and within it.
    pub geo: &'a Path,
    /// Folder of the scene.
    pub scene_folder: &'a Path,
    /// D: 2 or 3.
    pub dimension: usize,
    /// Whether the user lets programs of the scene run (`--allow-scripts`).
    pub allow_scripts: bool,
    /// Python with the package `gmsh`; `None`: found as for records (HATI_PYTHON, `.venv`, `python3`).
    pub python: Option<&'a Path>,
    /// Folder for the mesh and Gmsh's messages; made if it is not there.
    pub out_folder: &'a Path,
    /// Longest time that Gmsh may take.
    pub time_limit: Duration,
}

/// Meshes a `.geo` file and gives the path of the `.msh` file (4.1, binary), `<name>.msh` in the folder for
/// results; Gmsh's messages are beside it in `<name>.gmsh.log`.
///
/// A `.geo` file is a program that may run commands of the system. It is run only with
/// [`GeoRun::allow_scripts`] and only when the file, links followed, lies in the scene's own folder. Gmsh
/// reads no options of the user, nothing from standard input, and is stopped after its time. Any line of
/// error in its messages fails the run: Gmsh itself goes on and ends as if all were well.
///
/// # Errors
/// [`InputError::GeoRefused`] before anything is run; [`InputError::GmshMissing`],
/// [`InputError::GmshFailed`] and [`InputError::GmshTimeout`] of the run.
pub fn mesh_geo(run: &GeoRun<'_>) -> Result<PathBuf, InputError> {
    let geo = permitted(run)?;
    let stem = run.geo.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let failed = |problem: String, messages: String| InputError::GmshFailed {
        path: run.geo.to_path_buf(),
        problem,
        messages,
    };
    let cannot = |what: &str, error: std::io::Error| failed(format!("{what}: {error}"), String::new());
    fs::create_dir_all(run.out_folder)
        .map_err(|error| cannot("its folder for results cannot be made", error))?;
    let out_folder = run
        .out_folder
        .canonicalize()
        .map_err(|error| cannot("its folder for results is not there", error))?;
    let mesh = out_folder.join(format!("{stem}.msh"));
    let part = out_folder.join(format!("{stem}.part.msh"));
    let log = out_folder.join(format!("{stem}.gmsh.log"));
    // A mesh left by another run must not pass for this one's.
    let _ = fs::remove_file(&part);

    let python = interpreter(run.python);
    let mut command = gmsh(&python);
    command.arg(&geo).args(["-nopopup", if run.dimension == 2 { "-2" } else { "-3" }]);
    command.args(["-format", "msh41", "-bin", "-v", "3", "-o"]).arg(&part);
    let status = watched(command, &log, run.time_limit)
        .map_err(|error| InputError::GmshMissing { python: python.clone(), reason: error.to_string() })?;
    let messages = fs::read(&log).unwrap_or_default();
    let messages = String::from_utf8_lossy(&messages);
    let Some(status) = status else {
        let seconds = run.time_limit.as_secs_f64();
        let _ = fs::remove_file(&part);
        return Err(InputError::GmshTimeout {
            path: run.geo.to_path_buf(),
            seconds,
            messages: tail(&messages),
        });
    };
    // What Python says when the package, or a library that it needs, is not there.
    if !status.success()
        && ["ModuleNotFoundError", "ImportError", "OSError"].iter().any(|e| messages.contains(e))
    {
        let reason = messages.trim_end().lines().last().unwrap_or_default().to_string();
        return Err(InputError::GmshMissing { python, reason });
    }
    if !status.success() {
        return Err(failed(format!("Gmsh ended early ({status})"), tail(&messages)));
    }
    let errors: Vec<&str> = messages.lines().filter(|line| line.starts_with("Error")).collect();
    if !errors.is_empty() {
        let _ = fs::remove_file(&part);
        return Err(failed("Gmsh reports errors".into(), tail(&errors.join("\n"))));
    }
    if !part.is_file() {
        return Err(failed("Gmsh wrote no mesh".into(), tail(&messages)));
    }
    fs::rename(&part, &mesh).map_err(|error| cannot("the mesh cannot be put in its place", error))?;
    Ok(mesh)
}

/// Version of the Gmsh that [`mesh_geo`] would run.
///
/// # Errors
/// [`InputError::GmshMissing`] with what Python or the loader said.
pub fn gmsh_version(python: Option<&Path>) -> Result<String, InputError> {
    let python = interpreter(python);
    let missing = |reason: String| InputError::GmshMissing { python: python.clone(), reason };
    let answer = gmsh(&python).arg("--version").stdin(Stdio::null()).output();
    let answer = answer.map_err(|error| missing(error.to_string()))?;
    let last = |bytes: &[u8]| {
        let text = String::from_utf8_lossy(bytes);
        text.trim_end().lines().last().unwrap_or_default().to_string()
    };
    // Gmsh says its version on stderr.
    let words = [last(&answer.stdout), last(&answer.stderr)].into_iter().find(|words| !words.is_empty());
    let words = words.unwrap_or_default();
    if answer.status.success() && !words.is_empty() { Ok(words) } else { Err(missing(words)) }
}

/// The canonical path of a `.geo` file that may be run.
fn permitted(run: &GeoRun<'_>) -> Result<PathBuf, InputError> {
    let refused = |problem: &str, remedy: &'static str| InputError::GeoRefused {
        path: run.geo.to_path_buf(),
        problem: problem.into(),
        remedy,
    };
    if !matches!(run.dimension, 2 | 3) {
        return Err(refused("is to be meshed in another dimension than 2 or 3", "set dimension = 2 or 3"));
    }
    if !run.geo.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("geo")) {
        return Err(refused("is no .geo file", "name a .geo file, or a mesh by its .msh file"));
    }
    if run.geo.components().any(|part| part == Component::ParentDir) {
        return Err(refused(
            "leads out of the scene's folder (..); a .geo file is a program and runs only from there",
            "copy it beside scene.toml and give its name",
        ));
    }
    let missing = |_| InputError::RecordMissing { path: run.geo.to_path_buf() };
    let folder = run.scene_folder.canonicalize().map_err(missing)?;
    let geo = folder.join(run.geo).canonicalize().map_err(missing)?;
    if !geo.starts_with(&folder) {
        return Err(refused(
            "lies outside the scene's folder, links followed; a .geo file is a program and runs only from there",
            "copy it beside scene.toml, in place of a link",
        ));
    }
    if !geo.is_file() {
        return Err(refused("is not a regular file", "name the .geo file itself"));
    }
    if !run.allow_scripts {
        return Err(refused(
            "is a program, which Gmsh would run with all your rights; programs of a scene run only when they are allowed to",
            "read it, then give --allow-scripts; or mesh it yourself (gmsh -3 -format msh41) and name the .msh file",
        ));
    }
    Ok(geo)
}

/// The Python given, or the one that reads records.
fn interpreter(python: Option<&Path>) -> PathBuf {
    python.map_or_else(|| find_python().0, Path::to_path_buf)
}

/// A call of Gmsh by a Python that has its wheel.
fn gmsh(python: &Path) -> Command {
    let mut command = Command::new(python);
    command.args(["-I", "-X", "utf8", "-c", SCRIPT]);
    // Libraries that the set-up fetched because the machine has them not; those of the machine go first.
    let libraries = python.parent().and_then(Path::parent).map(|venv| venv.join("lib/gmsh-libraries"));
    if let Some(libraries) = libraries.filter(|folder| folder.is_dir()) {
        let before = std::env::var_os("LD_LIBRARY_PATH").unwrap_or_default();
        let folders = std::env::split_paths(&before).filter(|folder| !folder.as_os_str().is_empty());
        if let Ok(all) = std::env::join_paths(folders.chain([libraries])) {
            command.env("LD_LIBRARY_PATH", all);
        }
    }
    command
}

/// Runs a command to its end with all that it says in a file; `None` if its time ran out.
///
/// A file and no pipe: a program that it started in turn could hold a pipe open beyond its end.
fn watched(mut command: Command, log: &Path, limit: Duration) -> std::io::Result<Option<ExitStatus>> {
    let log = File::create(log)?;
    command.stdin(Stdio::null()).stdout(log.try_clone()?).stderr(log);
    let mut child = Stopped(command.spawn()?);
    let begin = Instant::now();
    let mut pause = Duration::from_millis(2);
    loop {
        if let Some(status) = child.0.try_wait()? {
            return Ok(Some(status));
        }
        if begin.elapsed() >= limit {
            return Ok(None);
        }
        std::thread::sleep(pause.min(limit.saturating_sub(begin.elapsed())));
        pause = (pause * 2).min(Duration::from_millis(50));
    }
}

/// A child that does not outlive its owner.
struct Stopped(Child);

impl Drop for Stopped {
    fn drop(&mut self) {
        // It may have ended by itself.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// The end of messages, on lines of their own.
fn tail(messages: &str) -> String {
    let text = messages.trim();
    let from = (text.len().saturating_sub(MESSAGES_TAIL)..).find(|&from| text.is_char_boundary(from));
    let text = &text[from.unwrap_or(0)..];
    if text.is_empty() { String::new() } else { format!("\n  {}", text.replace('\n', "\n  ")) }
}
