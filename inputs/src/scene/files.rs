//! Whether a path names a file that can be read, and near names where it does not.

use std::fs;
use std::io::ErrorKind;
use std::path::Path;

/// Why a file cannot be taken.
pub(super) struct FileProblem {
    pub(super) message: String,
    pub(super) help: Option<String>,
}

impl FileProblem {
    fn new(message: impl Into<String>, help: Option<String>) -> Self {
        Self { message: message.into(), help }
    }
}

/// Checks what a scene says about a record's place: no URL, no wildcard, an existing regular file that can be opened.
///
/// `obspy:PATH` is only checked for its form: Python alone knows where the package lies.
pub(super) fn record(folder: &Path, file: &str) -> Result<(), FileProblem> {
    if file.trim().is_empty() {
        return Err(FileProblem::new("the file's name is empty", None));
    }
    if let Some(inside) = file.strip_prefix("obspy:") {
        return inside_package(inside);
    }
    local(folder, file, "name the file; for several channels in one file give `channel`")
}

/// As [`record`], for a file that is no record; `one`: what to do in place of a wildcard.
pub(super) fn local(folder: &Path, file: &str, one: &str) -> Result<(), FileProblem> {
    if file.contains("://") {
        return Err(FileProblem::new(
            format!("{file:?} is a URL; only local files are read"),
            Some("download it and name the local file".to_owned()),
        ));
    }
    if file.contains('\0') {
        return Err(FileProblem::new("the file's name holds a NUL byte", None));
    }
    let path = folder.join(file);
    if path.symlink_metadata().is_err() && file.contains(['*', '?', '[']) {
        return Err(FileProblem::new(
            format!("{file:?} holds a wildcard, expected one file"),
            Some(one.to_owned()),
        ));
    }
    let size = regular_file(&path, "")?;
    if size == 0 {
        return Err(FileProblem::new(
            format!("{} is empty (0 bytes)", path.display()),
            Some("copy or download it again".to_owned()),
        ));
    }
    Ok(())
}

fn inside_package(inside: &str) -> Result<(), FileProblem> {
    let steps_out = inside.split(['/', '\\']).any(|part| part == "..");
    if inside.is_empty() || inside.starts_with(['/', '\\']) || steps_out || inside.contains('\0') {
        return Err(FileProblem::new(
            format!("obspy:{inside} does not name a file inside the ObsPy package"),
            Some(
                "write a relative path without \"..\", for instance obspy:io/nied/tests/data/test.knet"
                    .to_owned(),
            ),
        ));
    }
    Ok(())
}

/// Checks that `path` is a regular file that opens for reading; returns its size in bytes.
///
/// `extension`: what near names must end in, `""` for any.
pub(super) fn regular_file(path: &Path, extension: &str) -> Result<u64, FileProblem> {
    let shown = path.display();
    let meta = match fs::metadata(path) {
        Ok(meta) => meta,
        Err(e) if matches!(e.kind(), ErrorKind::NotFound | ErrorKind::NotADirectory) => {
            return Err(missing(path, extension));
        }
        Err(e) => return Err(FileProblem::new(format!("{shown} cannot be looked at: {e}"), None)),
    };
    if meta.is_dir() {
        return Err(FileProblem::new(
            format!("{shown} is a folder, expected a file"),
            folder_help(path, extension),
        ));
    }
    // A pipe or a device would block the reader or never end.
    if !meta.is_file() {
        return Err(FileProblem::new(
            format!("{shown} is not a regular file"),
            Some("copy its content into a file first".to_owned()),
        ));
    }
    fs::File::open(path).map_err(|e| {
        FileProblem::new(
            format!("{shown} cannot be read: {e}"),
            Some("check the file's permissions".to_owned()),
        )
    })?;
    Ok(meta.len())
}

/// Names of the entries of a folder that end in `extension`, at most a thousand, sorted.
fn names_in(folder: &Path, extension: &str) -> Vec<String> {
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let Ok(entries) = fs::read_dir(folder) else {
        return Vec::new();
    };
    let mut names: Vec<String> = entries
        .take(1000)
        .filter_map(|e| e.ok()?.file_name().into_string().ok())
        .filter(|n| extension.is_empty() || n.ends_with(extension))
        .collect();
    names.sort();
    names
}

fn folder_help(folder: &Path, extension: &str) -> Option<String> {
    let names = names_in(folder, extension);
    (!names.is_empty()).then(|| format!("it holds {}", few(&names)))
}

/// The first few names, and how many more there are.
fn few(names: &[String]) -> String {
    let head = names[..names.len().min(4)].join(", ");
    if names.len() > 4 { format!("{head} and {} more", names.len() - 4) } else { head }
}

fn missing(path: &Path, extension: &str) -> FileProblem {
    let folder = match path.parent() {
        Some(p) if !p.as_os_str().is_empty() => p,
        _ => Path::new("."),
    };
    let name = path.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
    if !folder.is_dir() {
        return FileProblem::new(
            format!("there is no folder {} to look for {name} in", folder.display()),
            home_help(path)
                .or_else(|| Some("files are looked for relative to the scene's folder".to_owned())),
        );
    }
    let lower = name.to_lowercase();
    let all = names_in(folder, extension);
    let mut near: Vec<(f64, &String)> = all
        .iter()
        .map(|n| (strsim::jaro_winkler(&lower, &n.to_lowercase()), n))
        .filter(|(s, _)| *s > 0.8)
        .collect();
    near.sort_by(|a, b| b.0.total_cmp(&a.0));
    let near: Vec<String> = near.into_iter().map(|(_, n)| n.clone()).collect();
    let help = if near.is_empty() {
        home_help(path).or_else(|| (!all.is_empty()).then(|| format!("the folder holds {}", few(&all))))
    } else {
        Some(format!("near names there: {}", few(&near)))
    };
    FileProblem::new(format!("there is no file {name} in the folder {}", folder.display()), help)
}

fn home_help(path: &Path) -> Option<String> {
    path.components()
        .any(|c| c.as_os_str() == "~")
        .then(|| "\"~\" is not expanded: write the path in full".to_owned())
}
