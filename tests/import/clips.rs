//! The manifest of recorded clips.

use edgegait::people::recorded::{ReadOptions, Recording, SubjectName};
use std::collections::HashMap;
use std::path::Path;

/// A row of a manifest: column name to value.
pub type Row = HashMap<String, String>;

/// Returns the rows of `mocap/manifest.csv` whose file has one of these endings; at least one.
pub fn manifest(data: &Path, endings: &[&str]) -> Vec<Row> {
    let mut rows = listed(&data.join("mocap"));
    rows.retain(|row| endings.iter().any(|ending| row["file"].ends_with(ending)));
    assert!(!rows.is_empty(), "{}: no {endings:?}", data.display());
    rows
}

/// Returns all rows of a folder's `manifest.csv`.
pub fn listed(folder: &Path) -> Vec<Row> {
    let mut reader = csv::Reader::from_path(folder.join("manifest.csv")).expect("a manifest");
    reader
        .deserialize()
        .map(|row| row.expect("a row"))
        .collect()
}

/// Returns a number of a row.
pub fn number(row: &Row, column: &str) -> f64 {
    row[column].parse().expect("a number")
}

/// Folders of recordings with a manifest.
pub const FOLDERS: [&str; 2] = ["mocap", "people/mocap_extra"];

/// Reads all recordings of a folder's manifest that can be kept so.
pub fn recordings(folder: &Path, options: &ReadOptions) -> Vec<Recording> {
    let read = |row: &Row| {
        let options = ReadOptions {
            subject: SubjectName::Given(format!("{} {}", row["dataset"], row["subject"])),
            // An AMC does not state its rate.
            sample_rate_hz: row["file"].ends_with(".amc").then(|| number(row, "fps")),
            ..options.clone()
        };
        Recording::read(&folder.join(&row["file"]), &options).ok()
    };
    listed(folder).iter().filter_map(read).collect()
}
