//! Temporary folders in which files are made before they get their names.

use std::collections::BTreeSet;
use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use super::locked_folder::{LockedFolder, remove_locked};
use crate::error::{Error, Result};

/// The existing staging folders of this process.
static ALIVE: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

/// A temporary folder, which is removed with its contents when it is dropped, and by
/// [`remove_unfinished`]. What a killed process left is removed by the next one that stages the
/// same path.
///
/// The folder and the files created in it have the permissions of the user's umask, and keep them.
#[derive(Debug)]
pub struct Staging {
    folder: LockedFolder,
}

impl Staging {
    /// Creates a hidden folder in the folder of `path`, so that files made inside can be renamed
    /// to `path`.
    ///
    /// # Errors
    /// If `path` does not end in a name, and errors of the system, about `path`.
    pub fn beside(path: &Path) -> Result<Self> {
        let name = path.file_name().ok_or_else(|| {
            Error::Usage(format!(
                "{}: expected a path that ends in a name",
                path.display()
            ))
        })?;
        let place = folder_of(path);
        // Not made here: a path that was mistyped is an error.
        fs::metadata(&place).map_err(|source| Error::io(path, source))?;
        let prefix = format!(".{}.unfinished-", name.to_string_lossy());
        Self::new(&place, &prefix, true)
    }

    /// Creates a folder in the system's folder for temporary files.
    ///
    /// # Errors
    /// If the system cannot create it.
    pub fn temporary() -> Result<Self> {
        let prefix = format!("edgegait.{}-", std::process::id());
        Self::new(&std::env::temp_dir(), &prefix, false)
    }

    /// Takes the first folder of these that nobody uses. One that exists is a leftover, if
    /// `reuse`; or else it may be anybody's.
    fn new(place: &Path, prefix: &str, reuse: bool) -> Result<Self> {
        // Made and noted under one lock, so that none is forgotten.
        let mut alive = alive();
        let mut numbers = 0_u64..;
        let folder = loop {
            let number = numbers.next().unwrap_or_default();
            let path = place.join(format!("{prefix}{number}"));
            let is_there = path.symlink_metadata().is_ok();
            if !reuse {
                match fs::create_dir(&path) {
                    Err(error) if error.kind() == ErrorKind::AlreadyExists => continue,
                    made => made.map_err(|source| Error::io(&path, source))?,
                }
            }
            match LockedFolder::take(&path) {
                Ok(Some(folder)) => break folder,
                Err(error) if !is_there => return Err(error),
                // Somebody else's.
                _ => {}
            }
        };
        alive.insert(folder.path().to_path_buf());
        let cleared = folder.clear();
        let staging = Self { folder };
        drop(alive);
        cleared.map_err(|source| Error::io(staging.path(), source))?;
        Ok(staging)
    }

    /// Renames `made`, a file or folder in this folder, to `target`, replacing an existing one. The
    /// parent folders of `target` are made if missing.
    ///
    /// # Errors
    /// If the system refuses; then the existing `target` stays.
    pub fn place(self, made: &str, target: &Path) -> Result<()> {
        let io = |source| Error::io(target, source);
        let (made, former) = (self.path().join(made), self.path().join("former"));
        fs::create_dir_all(folder_of(target)).map_err(io)?;
        together(|| {
            let is_there = target.exists();
            if is_there {
                fs::rename(target, &former).map_err(io)?;
            }
            if let Err(source) = fs::rename(&made, target) {
                if is_there {
                    fs::rename(&former, target).map_err(io)?;
                }
                return Err(io(source));
            }
            Ok(())
        })
    }

    /// Returns the path of the folder.
    #[must_use]
    pub fn path(&self) -> &Path {
        self.folder.path()
    }
}

impl Drop for Staging {
    fn drop(&mut self) {
        // Forgotten only after its removal.
        let mut alive = alive();
        let _ = remove_locked(self.path());
        alive.remove(self.path());
    }
}

/// Removes all staging folders of this process, when it ends before its work is done. Waits for
/// work that must not be interrupted. Afterwards, no file is made or given its name.
pub fn remove_unfinished() {
    let alive = alive();
    for folder in alive.iter() {
        // Retried, as another thread may make a file in it. Errors are ignored: the process ends.
        let _ = (0..3).any(|_| remove_locked(folder).is_ok());
    }
    // The lock is never released: the process ends.
    std::mem::forget(alive);
}

/// Does work that [`remove_unfinished`] must not interrupt half-way, such as exchanging folders.
pub(crate) fn together<R>(work: impl FnOnce() -> R) -> R {
    let _alive = alive();
    work()
}

/// Returns the folder of `path`.
pub(crate) fn folder_of(path: &Path) -> PathBuf {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent.to_path_buf(),
        _ => PathBuf::from("."),
    }
}

fn alive() -> MutexGuard<'static, BTreeSet<PathBuf>> {
    ALIVE.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_that_lacks_is_the_systems_error_about_the_users_path() {
        let error = Staging::beside(Path::new("/nowhere/at/all.npy")).unwrap_err();
        assert_eq!(
            error.to_string(),
            "/nowhere/at/all.npy: No such file or directory (os error 2)"
        );
    }

    #[test]
    fn a_folder_that_was_made_takes_the_place_of_the_former_one() {
        let place = tempfile::tempdir().unwrap();
        let target = place.path().join("a/b");
        for text in ["first", "second"] {
            let staging = Staging::beside(&place.path().join("a")).unwrap();
            let made = staging.path().join("made");
            fs::create_dir(&made).unwrap();
            fs::write(made.join("x"), text).unwrap();
            staging.place("made", &target).unwrap();
            assert_eq!(fs::read_to_string(target.join("x")).unwrap(), text);
            assert_eq!(fs::read_dir(place.path()).unwrap().count(), 1);
        }
        let staging = Staging::beside(&place.path().join("a")).unwrap();
        staging.place("not made", &target).unwrap_err();
        assert_eq!(fs::read_to_string(target.join("x")).unwrap(), "second");
    }

    #[test]
    fn a_dropped_folder_is_gone_and_forgotten() {
        let place = tempfile::tempdir().unwrap();
        let staging = Staging::beside(&place.path().join("x.npy")).unwrap();
        let path = staging.path().to_path_buf();
        fs::write(path.join("unfinished"), "half").unwrap();
        assert!(alive().contains(&path));
        drop(staging);
        assert!(!path.exists() && !alive().contains(&path));
    }
}
