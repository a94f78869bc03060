//! The people in silhouettes of other software: their bodies, and the recordings of their walks.

use edgegait::people::cohort::anthropometry::NAMES;
use std::collections::HashMap;
use std::path::Path;

/// A row of a table, by column.
pub type Row = HashMap<String, String>;

/// Reads the rows of a table.
pub fn rows(path: &Path) -> Vec<Row> {
    let mut reader = csv::Reader::from_path(path).expect("a table");
    let rows = reader.deserialize();
    rows.map(|row| row.expect("a row")).collect()
}

/// Formats a row of `people/bodies.csv` for `--bodies`.
pub fn body(row: &Row) -> String {
    let dimensions: Vec<String> = NAMES.map(|name| format!("{name}_m")).into();
    let known = dimensions.iter().filter(|name| row.contains_key(*name));
    let known: Vec<&str> = known.map(String::as_str).collect();
    let sex = match row["sex"].as_str() {
        "M" => "male",
        _ => "female",
    };
    let fixed = [&row["id"], sex, &row["stature_m"], &row["mass_kg"]].join(",");
    let values: Vec<&str> = known.iter().map(|name| row[*name].as_str()).collect();
    format!(
        "subject,sex,stature_m,mass_kg,{}\n{fixed},{}\n",
        known.join(","),
        values.join(",")
    )
}

/// Returns the recordings of a person of `people`.
pub fn recordings(data: &Path, person: &str) -> Vec<String> {
    let takes = rows(&data.join("people/manifest.csv"));
    let own = takes.iter().filter(|row| row["id"] == person);
    let mut files: Vec<String> = own
        .map(|row| {
            let root = match row["source_root"].as_str() {
                "mocap" => "mocap/clips",
                _ => "people/mocap_extra/clips",
            };
            data.join(root).join(&row["source"]).display().to_string()
        })
        .collect();
    files.sort_unstable();
    files.dedup();
    files
}
