//! The first limits of results, which the results themselves hold.

use crate::command::done;
use std::fs;
use std::path::Path;

/// Checks that results are within the limits that `gate --init` derives from them, and returns the
/// limits.
pub fn holds(folder: &Path, results: &str) -> String {
    let limits = done(folder, &["gate", "--init", results]);
    let name = format!("{results}.limits.toml");
    fs::write(folder.join(&name), &limits).expect("written");
    let said = done(folder, &["gate", &name, results]);
    assert!(said.contains("holds"), "{results}: {said}");
    limits
}
