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
    pub(super) fn within(dir: &Path) -> Result<Self, OutputError> {
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

/// Takes away what is not in place yet, for a program that ends now: nothing is put into place from here on, and
/// whoever tries waits for that end.
pub(crate) fn abandon() {
    let under_way = under_way();
    if let Some(folder) = under_way.as_ref() {
        let _ = fs::remove_dir_all(folder);
    }
    std::mem::forget(under_way);
}
