//! Outputs are made aside, in a folder within the one they are for, and put into place together in the end: what
//! was there before stays whole until then, whatever happens.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use crate::outputs::OutputError;

/// The folder that is being made. Whoever holds the lock may put files into place or take the folder away; nobody
/// else does.
static UNDER_WAY: Mutex<Option<PathBuf>> = Mutex::new(None);

fn under_way() -> MutexGuard<'static, Option<PathBuf>> {
    UNDER_WAY.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A folder of files that are not in place yet; dropped, it goes with all that is in it.
#[derive(Debug)]
pub(super) struct Aside {
    folder: PathBuf,
}

impl Aside {
    /// Makes the folder within `dir`.
    ///
    /// Those that programs left there which were killed go first.
    pub(super) fn within(dir: &Path) -> Result<Self, OutputError> {
        clear_left(dir, Path::new("/proc"));
        let folder = dir.join(format!(".hati-record.{}.part", std::process::id()));
        let mut under_way = under_way();
        fs::create_dir(&folder)
            .map_err(|cause| OutputError::UnwritableFolder { folder: dir.to_path_buf(), cause })?;
        *under_way = Some(folder.clone());
        Ok(Self { folder })
    }

    /// Where to write.
    pub(super) fn folder(&self) -> &Path {
        &self.folder
    }

    /// Takes the old files away and puts the new ones into `dir`, in this order; not to be interrupted by
    /// [`abandon`].
    ///
    /// Errors: those of `clear` and of the disk.
    pub(super) fn put<E: From<OutputError>>(
        self,
        dir: &Path,
        names: &[String],
        clear: impl FnOnce() -> Result<(), E>,
    ) -> Result<(), E> {
        let held = under_way();
        clear()?;
        for name in names {
            let to = dir.join(name);
            if let Some(parent) = to.parent() {
                fs::create_dir_all(parent).map_err(|cause| OutputError::from_io(parent, cause))?;
            }
            fs::rename(self.folder.join(name), &to).map_err(|cause| OutputError::from_io(&to, cause))?;
        }
        drop(held);
        Ok(())
    }
}

impl Drop for Aside {
    fn drop(&mut self) {
        let mut under_way = under_way();
        // What is left of it is of no use to anybody.
        let _ = fs::remove_dir_all(&self.folder);
        *under_way = None;
    }
}

/// Takes away the folders of programs that are no more; where `proc` does not tell which are, none.
fn clear_left(dir: &Path, proc: &Path) {
    if !proc.join("self").exists() {
        return;
    }
    for entry in fs::read_dir(dir).into_iter().flatten().flatten() {
        let left = entry.file_name().to_str().and_then(process).is_some_and(|id| {
            // Not to be told apart from a living one, it stays.
            matches!(proc.join(id.to_string()).try_exists(), Ok(false))
        });
        if left && entry.file_type().is_ok_and(|kind| kind.is_dir()) {
            // What cannot be taken away harms nobody.
            let _ = fs::remove_dir_all(entry.path());
        }
    }
}

/// The process whose folder has this name.
fn process(name: &str) -> Option<u32> {
    let id = name.strip_prefix(".hati-record.")?.strip_suffix(".part")?;
    id.parse().ok().filter(|number: &u32| number.to_string() == id)
}

/// Takes away what is not in place yet, for a program that ends now: nothing is put into place from here on, and
/// whoever tries waits for that end.
pub(crate) fn abandon() {
    let under_way = under_way();
    if let Some(folder) = under_way.as_ref() {
        let _ = fs::remove_dir_all(folder);
    }
    std::mem::forget(under_way);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_folders_of_processes_that_are_no_more_go() {
        let root = tempfile::tempdir().expect("a folder");
        let (dir, proc) = (root.path().join("out"), root.path().join("proc"));
        for folder in ["proc/self", "proc/7"] {
            fs::create_dir_all(root.path().join(folder)).expect("a folder");
        }
        let names = |dir: &Path| -> Vec<String> {
            let entries = fs::read_dir(dir).expect("a folder").flatten();
            let mut names: Vec<String> =
                entries.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
            names.sort();
            names
        };
        let kept = [
            ".hati-record.+8.part",
            ".hati-record.08.part",
            ".hati-record.7.part",
            ".hati-record.8.parts",
            ".hati-record..part",
            "a.hati-record.8.part",
            "figures",
        ];
        for name in kept.iter().chain(&[".hati-record.8.part", ".hati-record.4000000.part"]) {
            fs::create_dir_all(dir.join(name).join("figures")).expect("a folder");
        }
        fs::write(dir.join(".hati-record.9.part"), "").expect("a file");
        let all = names(&dir);
        clear_left(&dir, &root.path().join("nowhere"));
        assert_eq!(names(&dir), all);
        clear_left(&dir, &proc);
        let mut kept: Vec<&str> = kept.iter().copied().chain([".hati-record.9.part"]).collect();
        kept.sort_unstable();
        assert_eq!(names(&dir), kept);
    }
}
