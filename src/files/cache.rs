//! A cache of costly, deterministic results.
//!
//! The cache is a folder of files. The folder or any file may be removed at any time: missing or
//! broken files are made again. A file's name is a hash of everything that determines its content,
//! so that files are never out of date. Above a gigabyte, the least recently used files are
//! removed.

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use super::hex;
use crate::error::{Error, Result};
use sha2::{Digest as _, Sha256};

/// The maximum number of bytes in all files. Our choice: a hundred thousand embeddings of GaitSet's
/// 16,000 numbers would take six times as much, and ten thousand fitted bodies a tenth.
const MOST_BYTES: u64 = 1 << 30;

/// The environment variable that names the folder.
const VARIABLE: &str = "EDGEGAIT_CACHE";
/// The name that stands for no folder.
const NONE: &str = "none";

/// The folder of cached results, if there is one.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Cache {
    folder: Option<PathBuf>,
}

impl Cache {
    /// Returns the cache in the folder of this name, else in the folder that `EDGEGAIT_CACHE`
    /// names, else in a folder in the system's cache folder. It caches nothing if the name is
    /// `none`, or if the system has no such folder. The folder is made when it is first used.
    #[must_use]
    pub fn named(name: Option<&Path>) -> Self {
        let variable = || std::env::var_os(VARIABLE).filter(|name| !name.is_empty());
        let name = name
            .map(Path::to_path_buf)
            .or_else(|| variable().map(PathBuf::from));
        let usual = || Some(dirs::cache_dir()?.join("edgegait"));
        Self {
            folder: match name {
                Some(name) if name == Path::new(NONE) => None,
                Some(name) => Some(name),
                None => usual(),
            },
        }
    }

    /// Returns the path of a result of this kind, if there is a folder.
    pub(crate) fn path(&self, kind: &str, key: &CacheKey) -> Option<PathBuf> {
        Some(self.folder.as_ref()?.join(kind).join(&key.0))
    }

    /// Returns the bytes of a result, if they are cached.
    #[cfg(feature = "import")]
    pub(crate) fn read(&self, kind: &str, key: &CacheKey) -> Option<Vec<u8>> {
        let path = self.path(kind, key)?;
        let bytes = super::read(&path).ok()?;
        touch(&path);
        Some(bytes)
    }

    /// Caches the bytes of a result, if there is a folder.
    ///
    /// # Errors
    /// For errors of the system; then nothing is cached.
    #[cfg(feature = "import")]
    pub(crate) fn keep(&self, kind: &str, key: &CacheKey, bytes: &[u8]) -> Result<()> {
        let Some(path) = self.path(kind, key) else {
            return Ok(());
        };
        crate::files::write_bytes(&path, bytes)?;
        self.make_room()
    }

    /// Removes files, the least recently used first, until all take at most a gigabyte.
    ///
    /// # Errors
    /// If the folder cannot be read.
    pub(crate) fn make_room(&self) -> Result<()> {
        self.prune(MOST_BYTES)
    }

    fn prune(&self, most: u64) -> Result<()> {
        let Some(folder) = &self.folder else {
            return Ok(());
        };
        let mut files: Vec<(SystemTime, u64, PathBuf)> = Vec::new();
        for kind in entries(folder)?.into_iter().filter(|kind| kind.is_dir()) {
            for path in entries(&kind)? {
                // Another process may have removed the file in the meantime.
                let Ok(found) = fs::metadata(&path) else {
                    continue;
                };
                let used = found.modified().unwrap_or(SystemTime::UNIX_EPOCH);
                files.push((used, found.len(), path));
            }
        }
        files.sort();
        let mut bytes: u64 = files.iter().map(|(_, bytes, _)| bytes).sum();
        for (_, own, path) in files {
            if bytes <= most {
                break;
            }
            bytes -= own;
            let _ = fs::remove_file(path);
        }
        Ok(())
    }
}

/// Marks a file as used, which determines the order of removal.
pub(crate) fn touch(path: &Path) {
    let file = File::options().append(true).open(path);
    let _ = file.and_then(|file| file.set_modified(SystemTime::now()));
}

fn entries(folder: &Path) -> Result<Vec<PathBuf>> {
    let io = |error| Error::io(folder, error);
    let entries = fs::read_dir(folder).map_err(io)?;
    let paths = entries.map(|entry| entry.map(|entry| entry.path()));
    paths.collect::<std::io::Result<_>>().map_err(io)
}

/// The hash of everything that determines a result.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct CacheKey(String);

impl CacheKey {
    /// Hashes these parts, with their boundaries, and the version of this program.
    pub(crate) fn hash(parts: &[&[u8]]) -> Self {
        let mut digest = Sha256::new();
        for part in [env!("CARGO_PKG_VERSION").as_bytes()].iter().chain(parts) {
            digest.update((part.len() as u64).to_le_bytes());
            digest.update(part);
        }
        Self(hex(&digest.finalize()))
    }
}

#[cfg(all(test, feature = "import"))]
mod tests {
    use super::*;
    use std::time::Duration;

    fn cache() -> (tempfile::TempDir, Cache) {
        let folder = tempfile::tempdir().unwrap();
        let at = folder.path().join("cache");
        let cache = Cache::named(Some(&at));
        (folder, cache)
    }

    #[test]
    fn what_is_kept_is_found_by_all_that_it_follows_from() {
        let (folder, cache) = cache();
        let key = CacheKey::hash(&[b"mesh", b"384"]);
        assert_eq!(cache.read("hulls", &key), None);
        assert!(!folder.path().join("cache").exists());
        cache.keep("hulls", &key, b"points").unwrap();
        assert_eq!(cache.read("hulls", &key).as_deref(), Some(&b"points"[..]));
        assert_eq!(cache.read("answers", &key), None);
        for other in [
            &[&b"mesh"[..], b"385"][..],
            &[b"mesh3", b"84"],
            &[b"mesh384"],
        ] {
            assert_eq!(cache.read("hulls", &CacheKey::hash(other)), None);
        }
    }

    #[test]
    fn nothing_is_kept_where_none_was_asked_for() {
        let cache = Cache::named(Some(Path::new("none")));
        assert_eq!(cache, Cache::default());
        let key = CacheKey::hash(&[b"a"]);
        cache.keep("hulls", &key, b"points").unwrap();
        assert_eq!(cache.read("hulls", &key), None);
        assert!(!Path::new("none").exists());
    }

    #[test]
    fn what_was_used_longest_ago_goes_first() {
        let (_folder, cache) = cache();
        let keys = [b"a", b"b", b"c"].map(|name| CacheKey::hash(&[name]));
        for (age, key) in [3, 2, 1].into_iter().zip(&keys) {
            cache.keep("hulls", key, &[0; 100]).unwrap();
            let path = cache.path("hulls", key).unwrap();
            let file = File::options().append(true).open(path).unwrap();
            let then = SystemTime::now() - Duration::from_secs(60 * age);
            file.set_modified(then).unwrap();
        }
        // The oldest is used again.
        assert!(cache.read("hulls", &keys[0]).is_some());
        cache.prune(250).unwrap();
        let is_kept = keys
            .each_ref()
            .map(|key| cache.read("hulls", key).is_some());
        assert_eq!(is_kept, [true, false, true]);
    }
}
