//! A folder that one process at a time works in.

use std::fs::{self, File, TryLockError};
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

use crate::error::{Error, Result};

/// The name of the lock in its folder.
pub(crate) const LOCK: &str = "lock";

/// The number of times that a folder may vanish while it is being locked.
const TRIES: usize = 100;

/// A folder with a lock file in it, which is locked until this value is dropped.
#[derive(Debug)]
pub(crate) struct LockedFolder {
    path: PathBuf,
    _lock: File,
}

impl LockedFolder {
    /// Creates a folder if it is missing, and locks it; none if another process, or another part of
    /// this one, holds the lock. Where the file system has no locks, nobody else is seen.
    ///
    /// # Errors
    /// If the folder or its lock is a link, and errors of the system.
    pub(crate) fn take(path: &Path) -> Result<Option<Self>> {
        let io = |source| Error::io(path, source);
        let lock_path = path.join(LOCK);
        for _ in 0..TRIES {
            fs::create_dir_all(path).map_err(io)?;
            refuse_link(path)?;
            refuse_link(&lock_path)?;
            let mut options = File::options();
            let lock = options.write(true).create(true).truncate(false);
            let lock = match lock.open(&lock_path) {
                Err(error) if error.kind() == ErrorKind::NotFound => continue,
                lock => lock.map_err(io)?,
            };
            match lock.try_lock() {
                Err(TryLockError::WouldBlock) => return Ok(None),
                Err(TryLockError::Error(source)) if source.kind() != ErrorKind::Unsupported => {
                    return Err(io(source));
                }
                _ => {}
            }
            // Its last owner may have removed the folder between the opening and the locking.
            if is_at(&lock, &lock_path).map_err(io)? {
                let path = path.to_path_buf();
                return Ok(Some(Self { path, _lock: lock }));
            }
        }
        Err(io(ErrorKind::ResourceBusy.into()))
    }

    /// Returns the path of the folder.
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// Removes everything in the folder but its lock.
    ///
    /// # Errors
    /// If the system refuses.
    pub(crate) fn clear(&self) -> io::Result<()> {
        clear(&self.path)
    }
}

/// Removes a folder whose lock this process holds. Another process may take the folder at any
/// moment: then it stays, with what that process makes in it.
///
/// # Errors
/// If the system refuses.
pub(crate) fn remove_locked(path: &Path) -> io::Result<()> {
    clear(path)?;
    fs::remove_file(path.join(LOCK))?;
    match fs::remove_dir(path) {
        Err(error) if error.kind() != ErrorKind::DirectoryNotEmpty => Err(error),
        _ => Ok(()),
    }
}

fn clear(path: &Path) -> io::Result<()> {
    for entry in fs::read_dir(path)? {
        let entry = entry?;
        if entry.file_name() == LOCK {
            continue;
        }
        if entry.file_type()?.is_dir() {
            fs::remove_dir_all(entry.path())?;
        } else {
            fs::remove_file(entry.path())?;
        }
    }
    Ok(())
}

/// Checks that a path is not a link.
///
/// # Errors
/// If it is one.
pub(crate) fn refuse_link(path: &Path) -> Result<()> {
    if path.is_symlink() {
        return Err(Error::input(
            path,
            "expected none of our own folders or files to be a link (remove it)",
        ));
    }
    Ok(())
}

/// Returns whether an open file is the one at a path.
#[cfg(unix)]
fn is_at(file: &File, path: &Path) -> io::Result<bool> {
    use std::os::unix::fs::MetadataExt as _;
    let there = match fs::symlink_metadata(path) {
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(false),
        there => there?,
    };
    let here = file.metadata()?;
    Ok((here.dev(), here.ino()) == (there.dev(), there.ino()))
}

/// Returns true: other systems do not remove a file that is open.
#[cfg(not(unix))]
#[allow(clippy::unnecessary_wraps)]
fn is_at(_: &File, _: &Path) -> io::Result<bool> {
    Ok(true)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_belongs_to_one_at_a_time_and_is_removed_whole() {
        let place = tempfile::tempdir().unwrap();
        let path = place.path().join("a/b");
        let taken = LockedFolder::take(&path).unwrap().expect("free");
        assert!(LockedFolder::take(&path).unwrap().is_none());
        fs::create_dir(path.join("sub")).unwrap();
        fs::write(path.join("sub/x"), "1").unwrap();
        taken.clear().unwrap();
        assert_eq!(fs::read_dir(&path).unwrap().count(), 1, "the lock");
        remove_locked(&path).unwrap();
        assert!(!path.exists());
        // Whoever waited on the removed lock takes a new one.
        let next = LockedFolder::take(&path).unwrap().expect("free");
        drop(taken);
        assert!(LockedFolder::take(&path).unwrap().is_none());
        drop(next);
        LockedFolder::take(&path).unwrap().expect("free again");
    }

    #[cfg(unix)]
    #[test]
    fn links_are_refused() {
        let place = tempfile::tempdir().unwrap();
        let victim = place.path().join("victim");
        fs::create_dir(&victim).unwrap();
        let path = place.path().join("a");
        std::os::unix::fs::symlink(&victim, &path).unwrap();
        LockedFolder::take(&path).unwrap_err();
        fs::remove_file(&path).unwrap();
        fs::create_dir(&path).unwrap();
        fs::write(victim.join("x"), "precious").unwrap();
        std::os::unix::fs::symlink(victim.join("x"), path.join(LOCK)).unwrap();
        LockedFolder::take(&path).unwrap_err();
        assert_eq!(fs::read(victim.join("x")).unwrap(), b"precious");
    }
}
