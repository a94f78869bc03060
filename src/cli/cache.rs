//! The flag that names the cache of costly results.

use crate::files::cache::Cache;
use std::path::PathBuf;

/// The flag that names the cache.
#[derive(Clone, Debug, Default, clap::Args)]
pub(super) struct CacheArgs {
    /// Folder that caches hulls fitted to meshes and the answers of networks, a gigabyte at most;
    /// "none" caches nothing [default: EDGEGAIT_CACHE, or a folder in the system's cache folder]
    #[arg(long, value_name = "FOLDER|none")]
    cache: Option<PathBuf>,
}

impl CacheArgs {
    /// Returns the cache.
    pub(super) fn cache(&self) -> Cache {
        Cache::named(self.cache.as_deref())
    }
}
