//! Recorded clips and what is known of them, if they are there.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// A row of the manifest: column name to value.
pub type Row = HashMap<String, String>;

/// A folder of real data, if it is there.
pub fn shared(folder: &str) -> Option<PathBuf> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../shared")
        .join(folder);
    if path.is_dir() {
        return Some(path);
    }
    eprintln!("skipped: {} is not there", path.display());
    None
}

/// The rows of the manifest whose file is there and ends with one of these.
pub fn manifest(endings: &[&str]) -> Vec<Row> {
    let Some(folder) = shared("mocap") else {
        return Vec::new();
    };
    let mut reader = csv::Reader::from_path(folder.join("manifest.csv")).unwrap();
    let rows = reader.deserialize().map(|row| row.unwrap());
    rows.filter(|row: &Row| endings.iter().any(|ending| row["file"].ends_with(ending)))
        .filter(|row| folder.join(&row["file"]).is_file())
        .collect()
}

/// A number of a row.
pub fn number(row: &Row, column: &str) -> f64 {
    row[column].parse().unwrap()
}
