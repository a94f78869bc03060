//! Temporary folders in which files are made before they get their names.

use std::collections::BTreeSet;
use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use crate::error::{Error, Result};

/// The existing staging folders of this process.
static ALIVE: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

/// A temporary folder, which is removed with its contents when it is dropped, and by
/// [`remove_unfinished`].
///
/// The folder and the files created in it have the permissions of the user's umask, and keep them.
#[derive(Debug)]
pub struct Staging {
    folder: PathBuf,
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
        let prefix = format!(".{}.", name.to_string_lossy());
        Self::new(&prefix, &folder_of(path)).map_err(|source| Error::io(path, source))
    }

    /// Creates a folder in the system's folder for temporary files.
    ///
    /// # Errors
    /// If the system cannot create it.
    pub fn temporary() -> Result<Self> {
        let place = std::env::temp_dir();
        Self::new("edgegait.", &place).map_err(|source| Error::io(place, source))
    }

    fn new(prefix: &str, place: &Path) -> std::io::Result<Self> {
        // Made and noted under one lock, so that none is forgotten.
        let mut alive = alive();
        let mut number = alive.len();
        loop {
            let folder = place.join(format!("{prefix}{}-{number}", std::process::id()));
            match fs::create_dir(&folder) {
                Ok(()) => {
                    alive.insert(folder.clone());
                    return Ok(Self { folder });
                }
                // Another process's folder, or one that a former process of this number left.
                Err(error) if error.kind() == ErrorKind::AlreadyExists => number += 1,
                Err(error) => return Err(error),
            }
        }
    }

    /// Renames `made`, a file or folder in this folder, to `target`, replacing an existing one. The
    /// parent folders of `target` are made if missing.
    ///
    /// # Errors
    /// If the system refuses; then the existing `target` stays.
    pub fn place(self, made: &str, target: &Path) -> Result<()> {
        let io = |source| Error::io(target, source);
        let (made, former) = (self.folder.join(made), self.folder.join("former"));
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
        &self.folder
    }
}

impl Drop for Staging {
    fn drop(&mut self) {
        // Forgotten only after its removal.
        let mut alive = alive();
        let _ = fs::remove_dir_all(&self.folder);
        alive.remove(&self.folder);
    }
}

/// Removes all staging folders of this process, when it ends before its work is done. Waits for
/// work that must not be interrupted. Afterwards, no file is made or given its name.
pub fn remove_unfinished() {
    let alive = alive();
    for folder in alive.iter() {
        // Retried, as another thread may make a file in it. Errors are ignored: the process ends.
        let _ = (0..3).any(|_| fs::remove_dir_all(folder).is_ok());
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
