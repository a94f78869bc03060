//! A pack of two people.

use crate::command::done;
use std::fs;
use std::sync::OnceLock;
use tempfile::TempDir;

/// Returns a folder with `two.egp`: F01 and M01 at 4 and 8 km/h.
pub fn folder() -> TempDir {
    static PACK: OnceLock<Vec<u8>> = OnceLock::new();
    let bytes = PACK.get_or_init(|| {
        let folder = tempfile::tempdir().expect("a folder");
        done(folder.path(), &COHORT);
        fs::read(folder.path().join("two.egp")).expect("the pack")
    });
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join("two.egp"), bytes).expect("the pack");
    folder
}

pub const COHORT: [&str; 7] = [
    "cohort",
    "--people",
    "2",
    "--speeds-kmh",
    "4,8",
    "--out",
    "two.egp",
];
