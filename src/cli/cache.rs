//! Where what is costly is kept: the flag of the commands that keep anything.

use crate::cache::Cache;
use std::path::PathBuf;

/// The flag.
#[derive(Clone, Debug, Default, clap::Args)]
pub(super) struct CacheArgs {
    /// Where hulls that were fitted to meshes and answers of networks are kept for the next run, a
    /// gigabyte at most; "none" keeps nothing [default: EDGEGAIT_CACHE, or a folder among the system's
    /// caches]
    #[arg(long, value_name = "FOLDER|none")]
    cache: Option<PathBuf>,
}

impl CacheArgs {
    /// The cache.
    pub(super) fn cache(&self) -> Cache {
        Cache::named(self.cache.as_deref())
    }
}
