//! Recordings, bodies and silhouettes from other sources: a few in the repository, the rest in a
//! folder with the same layout.

use std::path::{Path, PathBuf};

/// Returns the folder of the files in the repository.
pub fn fixtures() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data")
}

/// Returns the folder that `EDGEGAIT_DATA` names.
pub fn given() -> PathBuf {
    let folder = std::env::var_os("EDGEGAIT_DATA");
    let folder = folder
        .expect("EDGEGAIT_DATA: expected a folder laid out as tests/data, found no such variable");
    let path = Path::new(&folder).canonicalize();
    path.unwrap_or_else(|error| panic!("EDGEGAIT_DATA: {}: {error}", Path::new(&folder).display()))
}
