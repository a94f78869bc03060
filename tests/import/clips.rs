//! The manifest of recorded clips.

use std::collections::HashMap;
use std::path::Path;

/// A row of a manifest: column name to value.
pub type Row = HashMap<String, String>;

/// Returns the rows of `mocap/manifest.csv` whose file has one of these endings; at least one.
pub fn manifest(data: &Path, endings: &[&str]) -> Vec<Row> {
    let path = data.join("mocap/manifest.csv");
    let mut reader = csv::Reader::from_path(&path).expect("a manifest");
    let rows = reader.deserialize().map(|row| row.expect("a row"));
    let rows: Vec<Row> = rows
        .filter(|row: &Row| endings.iter().any(|ending| row["file"].ends_with(ending)))
        .collect();
    assert!(!rows.is_empty(), "{}: no {endings:?}", path.display());
    rows
}

/// Returns a number of a row.
pub fn number(row: &Row, column: &str) -> f64 {
    row[column].parse().expect("a number")
}
