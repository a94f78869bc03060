//! Long work that can be resumed: a folder beside the target with the files and a journal.
//!
//! `NAME.unfinished` holds `journal.json` and, in `made`, the incomplete files. Files only grow,
//! and the journal states the number of finished units of work and the length of each file at
//! that point. What was written later is cut off when the work is resumed. The journal is replaced
//! whole, so it is always either the old or the new one. This survives any end of the process and
//! a full disk. After a power cut the system may have kept the journal and lost the data that it
//! describes.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::error::{ChoiceError, Error, Result};
use crate::files::{LOCK, LockedFolder, SCHEMA, folder_of, refuse_link, remove_locked, together};

const JOURNAL: &str = "journal.json";
const NEXT: &str = "journal.next";
const MADE: &str = "made";
const FORMER: &str = "former";

/// The time between two entries of the journal. It has no influence on the result.
const INTERVAL: Duration = Duration::from_millis(100);

/// The folders of this process, and whether each holds work that is worth resuming.
static ALIVE: Mutex<BTreeMap<PathBuf, bool>> = Mutex::new(BTreeMap::new());

/// The record of finished work.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(super) struct Journal {
    schema: u32,
    /// Everything that the written bytes depend on.
    run: Value,
    /// The number of finished units of work.
    pub done: usize,
    /// The number of rows of the index.
    pub rows: usize,
    /// The number of frames of all rows.
    pub frames: usize,
    /// The sum over all silhouettes of the share that lay outside the image.
    pub clipped: f64,
    /// The people of each split, in the order of their first appearance.
    pub parts: BTreeMap<String, Vec<String>>,
    /// The length of each file, bytes.
    pub files: BTreeMap<String, u64>,
}

/// Unfinished work in its folder.
#[derive(Debug)]
pub(super) struct Unfinished {
    folder: LockedFolder,
    target: PathBuf,
    pub journal: Journal,
    noted: Instant,
}

impl Unfinished {
    /// Begins the work that will become `target`, or resumes it.
    ///
    /// # Errors
    /// If there is unfinished work and `resume` is false, it belongs to another run, another
    /// process uses it, it holds links, or the file system fails.
    pub(super) fn begin(target: &Path, run: Value, resume: bool) -> Result<Self> {
        let folder = path_beside(target)?;
        let parent = folder_of(target);
        fs::create_dir_all(&parent).map_err(|source| Error::io(&parent, source))?;
        let locked = take(&folder)?;
        let journal = if is_work(&folder, target)? {
            if !resume {
                return Err(unfinished(folder, target));
            }
            let journal = read(&folder)?;
            if let Some(differs) = difference(&journal.run, &run) {
                return Err(Error::Usage(format!(
                    "{}: it belongs to another run: {differs} (give the same settings as that run, or remove the folder)",
                    folder.display()
                )));
            }
            journal
        } else {
            let cleared = locked.clear();
            cleared.map_err(|source| Error::io(&folder, source))?;
            Journal {
                schema: SCHEMA,
                run,
                ..Journal::default()
            }
        };
        alive().insert(folder, journal.done > 0);
        let unfinished = Self {
            folder: locked,
            target: target.to_path_buf(),
            journal,
            noted: Instant::now(),
        };
        let made = unfinished.made();
        fs::create_dir_all(&made).map_err(|source| Error::io(&made, source))?;
        unfinished.cut()?;
        Ok(unfinished)
    }

    fn path(&self) -> &Path {
        self.folder.path()
    }

    /// Returns the folder of the incomplete files.
    pub(super) fn made(&self) -> PathBuf {
        self.path().join(MADE)
    }

    /// Cuts files to their lengths in the journal, and removes files that it does not list.
    fn cut(&self) -> Result<()> {
        let made = self.made();
        let io = |source| Error::io(&made, source);
        for entry in fs::read_dir(&made).map_err(io)? {
            let entry = entry.map_err(io)?;
            let path = entry.path();
            // Unfinished recordings are written again.
            if entry.file_type().map_err(io)?.is_dir() {
                continue;
            }
            let name = entry.file_name().to_string_lossy().into_owned();
            let Some(&length) = self.journal.files.get(&name) else {
                fs::remove_file(&path).map_err(io)?;
                continue;
            };
            let file = File::options().write(true).open(&path).map_err(io)?;
            if file.metadata().map_err(io)?.len() < length {
                return Err(Error::input(
                    &path,
                    format!(
                        "expected {length} bytes or more, as {JOURNAL} says (remove {} and start again)",
                        self.path().display()
                    ),
                ));
            }
            file.set_len(length).map_err(io)?;
        }
        Ok(())
    }

    /// Returns whether the next journal entry is due.
    pub(super) fn is_due(&self) -> bool {
        self.noted.elapsed() >= INTERVAL
    }

    /// Writes the journal; all data that it lists must have been flushed before.
    pub(super) fn note(&mut self) -> Result<()> {
        let io = |source| Error::io(self.path(), source);
        let next = self.path().join(NEXT);
        fs::write(&next, serde_json::to_vec(&self.journal)?).map_err(io)?;
        fs::rename(&next, self.path().join(JOURNAL)).map_err(io)?;
        self.noted = Instant::now();
        if self.journal.done > 0 {
            alive().insert(self.path().to_path_buf(), true);
        }
        Ok(())
    }

    /// Renames the file `name` of the work, or its whole folder, to the target, and replaces what
    /// is there.
    pub(super) fn finish(self, name: Option<&str>) -> Result<()> {
        let io = |source| Error::io(&self.target, source);
        let made = name.map_or_else(|| self.made(), |name| self.made().join(name));
        let former = self.path().join(FORMER);
        together(|| {
            if self.target.exists() {
                fs::rename(&self.target, &former).map_err(io)?;
                if let Err(source) = fs::rename(&made, &self.target) {
                    fs::rename(&former, &self.target).map_err(io)?;
                    return Err(io(source));
                }
            } else {
                fs::rename(&made, &self.target).map_err(io)?;
            }
            // Without it, nothing in the folder counts any more.
            let journal = self.path().join(JOURNAL);
            fs::remove_file(&journal).map_err(|source| Error::io(journal, source))
        })?;
        alive().insert(self.path().to_path_buf(), false);
        Ok(())
    }
}

impl Drop for Unfinished {
    fn drop(&mut self) {
        let mut alive = alive();
        // Empty work is removed; the process reports the rest at its end.
        if alive.get(self.path()) == Some(&false) {
            alive.remove(self.path());
            let _ = remove_locked(self.path());
        }
    }
}

/// Returns the folders in which work of this process can be resumed, and removes those that hold
/// nothing useful. For a process that ends early.
pub fn unfinished_work() -> Vec<PathBuf> {
    let alive = alive();
    let kept = alive.iter().filter(|(folder, is_worth)| {
        if !**is_worth {
            // Retried because another thread may create a file in it meanwhile. Errors are ignored
            // because the process ends.
            let _ = (0..3).any(|_| remove_locked(folder).is_ok());
        }
        **is_worth
    });
    kept.map(|(folder, _)| folder.clone()).collect()
}

/// Checks that no unfinished work lies beside a target, unless it is to be resumed, and removes
/// what a process left that was killed after its work.
///
/// # Errors
/// If unfinished work is there and `resume` is false, or another process is at work.
pub fn check_unfinished(target: &Path, resume: bool) -> Result<()> {
    let folder = path_beside(target)?;
    if folder.symlink_metadata().is_err() {
        return Ok(());
    }
    let _locked = take(&folder)?;
    if !is_work(&folder, target)? {
        return remove_locked(&folder).map_err(|source| Error::io(folder, source));
    }
    if resume {
        return Ok(());
    }
    Err(unfinished(folder, target))
}

/// Takes the folder of unfinished work for this process.
fn take(folder: &Path) -> Result<LockedFolder> {
    LockedFolder::take(folder)?.ok_or_else(|| at_work(folder))
}

/// Returns whether a folder, which this process holds, has work that can be resumed. Gives the
/// target its former dataset back if the process ended while it was being replaced.
///
/// # Errors
/// If the folder has links or other files, which could be anybody's, and errors of the system.
fn is_work(folder: &Path, target: &Path) -> Result<bool> {
    let io = |source| Error::io(folder, source);
    for entry in fs::read_dir(folder).map_err(io)? {
        let entry = entry.map_err(io)?;
        refuse_link(&entry.path())?;
        let name = entry.file_name();
        if ![JOURNAL, NEXT, MADE, FORMER, LOCK]
            .iter()
            .any(|own| name == *own)
        {
            let problem = format!(
                "expected only the files of an unfinished run in {} (remove or rename it)",
                folder.display()
            );
            return Err(Error::input(entry.path(), problem));
        }
    }
    let [journal, made, former] = [JOURNAL, MADE, FORMER].map(|name| folder.join(name));
    if former.exists() && !target.exists() {
        fs::rename(former, target).map_err(|source| Error::io(target, source))?;
    }
    if !journal.exists() || !made.exists() {
        return Ok(false);
    }
    refuse_links_in(&made)?;
    Ok(true)
}

fn refuse_links_in(folder: &Path) -> Result<()> {
    let io = |source| Error::io(folder, source);
    for entry in fs::read_dir(folder).map_err(io)? {
        let path = entry.map_err(io)?.path();
        refuse_link(&path)?;
        if path.is_dir() {
            refuse_links_in(&path)?;
        }
    }
    Ok(())
}

fn unfinished(folder: PathBuf, target: &Path) -> Error {
    let target = target.to_path_buf();
    ChoiceError::Unfinished { folder, target }.into()
}

fn at_work(folder: &Path) -> Error {
    Error::Usage(format!("{}: another process is using it", folder.display()))
}

/// Returns the folder of a target's unfinished work.
fn path_beside(target: &Path) -> Result<PathBuf> {
    let name = target.file_name().ok_or_else(|| {
        Error::Usage(format!(
            "{}: expected a path that ends in a name",
            target.display()
        ))
    })?;
    let mut name = name.to_os_string();
    name.push(".unfinished");
    Ok(target.with_file_name(name))
}

fn read(folder: &Path) -> Result<Journal> {
    let path = folder.join(JOURNAL);
    let text = crate::files::read(&path)?;
    let journal = serde_json::from_slice(&text);
    let journal: Journal = journal.map_err(|error| Error::json(&path, &error))?;
    if journal.schema != SCHEMA {
        return Err(Error::input(
            path,
            format!("expected schema {SCHEMA}, found {}", journal.schema),
        ));
    }
    Ok(journal)
}

/// Returns the first difference between two values, for a message.
pub(super) fn difference(there: &Value, here: &Value) -> Option<String> {
    fn find(place: &str, there: &Value, here: &Value) -> Option<String> {
        let inner = |name: &str| {
            let dot = if place.is_empty() { "" } else { "." };
            format!("{place}{dot}{name}")
        };
        match (there, here) {
            (Value::Object(there), Value::Object(here)) => {
                let mut names: Vec<&String> = there.keys().chain(here.keys()).collect();
                names.sort_unstable();
                names.into_iter().find_map(|name| {
                    let of = |map: &serde_json::Map<String, Value>| {
                        map.get(name).cloned().unwrap_or(Value::Null)
                    };
                    find(&inner(name), &of(there), &of(here))
                })
            }
            _ if there == here => None,
            _ => {
                let short = |value: &Value| {
                    let text = value.to_string();
                    let cut: String = text.chars().take(60).collect();
                    if cut == text {
                        text
                    } else {
                        format!("{cut}...")
                    }
                };
                Some(format!(
                    "{place} is {} there, {} here",
                    short(there),
                    short(here)
                ))
            }
        }
    }
    find("", there, here)
}

fn alive() -> MutexGuard<'static, BTreeMap<PathBuf, bool>> {
    ALIVE.lock().unwrap_or_else(PoisonError::into_inner)
}
