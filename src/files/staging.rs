//! Folders in which files are made before they get their names, and that do not outlive the process.

use std::collections::BTreeSet;
use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use crate::error::{Error, Result};

/// Those that there are now.
static ALIVE: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

/// A folder that is removed with all that is in it when it is dropped, and by
/// [`remove_unfinished`].
///
/// It and what is created inside have the permissions that the user's umask gives, and keep them.
#[derive(Debug)]
pub struct Staging {
    folder: PathBuf,
}

impl Staging {
    /// A hidden folder in the folder that holds `path`, so that what is made inside
    /// can be renamed to `path`.
    ///
    /// # Errors
    /// If `path` ends in no name, or the system's, about `path`.
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

    /// A folder in the system's place for temporary files.
    ///
    /// # Errors
    /// The system's.
    pub fn temporary() -> Result<Self> {
        let place = std::env::temp_dir();
        Self::new("edgegait.", &place).map_err(|source| Error::io(place, source))
    }

    fn new(prefix: &str, place: &Path) -> std::io::Result<Self> {
        // Made and noted at once, so that none is forgotten.
        let mut alive = alive();
        let mut number = alive.len();
        loop {
            let folder = place.join(format!("{prefix}{}-{number}", std::process::id()));
            match fs::create_dir(&folder) {
                Ok(()) => {
                    alive.insert(folder.clone());
                    return Ok(Self { folder });
                }
                // Another one's, or what a former process of this number left.
                Err(error) if error.kind() == ErrorKind::AlreadyExists => number += 1,
                Err(error) => return Err(error),
            }
        }
    }

    /// Gives `made`, a folder that was made in this one, the name `target`, in place of what has it
    /// now. The folders that hold it are made if need be.
    ///
    /// # Errors
    /// The system's; then what had the name has it still.
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

    /// Where it is.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.folder
    }
}

impl Drop for Staging {
    fn drop(&mut self) {
        // Forgotten only when it is gone.
        let mut alive = alive();
        let _ = fs::remove_dir_all(&self.folder);
        alive.remove(&self.folder);
    }
}

/// Removes all folders of this process that are still being worked in, for a process that ends
/// before its work does. What has to happen together is waited for. Nothing is made or
/// given its name afterwards.
pub fn remove_unfinished() {
    let alive = alive();
    for folder in alive.iter() {
        // Again if another thread makes a file in it meanwhile. The process ends: there is nobody
        // to tell.
        let _ = (0..3).any(|_| fs::remove_dir_all(folder).is_ok());
    }
    // Never given back: the process ends with it.
    std::mem::forget(alive);
}

/// Does what must not be interrupted half-way by [`remove_unfinished`], such as to exchange
/// folders.
pub(crate) fn together<R>(work: impl FnOnce() -> R) -> R {
    let _alive = alive();
    work()
}

/// The folder that holds `path`.
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
