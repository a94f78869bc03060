//! The people in silhouettes of other software: their tables and their sequences.

use edgegait::Tree;
use edgegait::draw::sweep::FramingMode;
use edgegait::people::cohort::anthropometry::NAMES;
use edgegait_core::silhouette::Size;
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

/// Parses pairs of numbers, such as `13.5-46.25;46.25-77.75`.
pub fn spans(text: &str) -> Vec<(f64, f64)> {
    let number = |text: &str| text.parse::<f64>().expect("a frame");
    let spans = text.split(';').filter_map(|span| span.split_once('-'));
    spans.map(|(from, to)| (number(from), number(to))).collect()
}

/// The frames of one sequence of the other software.
pub struct Seen {
    pixels: Vec<u8>,
    size: usize,
}

impl Seen {
    /// Reads the sequence of a row of `people/manifest.csv`, framed by height.
    pub fn of(tree: &Tree, row: &Row, size: Size) -> Self {
        let place = tree.sequences().iter().position(|one| {
            one.subject == row["id"] && one.take == row["take"] && one.view == row["view"]
        });
        let seen = tree.silhouettes(place.expect("a sequence"), size, FramingMode::Height);
        let seen = seen.expect("silhouettes");
        assert_eq!(seen.empty, 0);
        Self {
            size: size.rows() * size.columns(),
            pixels: seen.pixels,
        }
    }

    /// Returns the pixels of a frame, if there is one.
    pub fn frame(&self, index: usize) -> Option<&[u8]> {
        self.pixels.get(index * self.size..(index + 1) * self.size)
    }

    /// Returns the mean of the frames of a cycle, from 0 to 255.
    pub fn gei(&self, (from, to): (f64, f64)) -> Vec<f64> {
        let frames = from.ceil() as usize..to.ceil() as usize;
        let frames: Vec<&[u8]> = frames.filter_map(|frame| self.frame(frame)).collect();
        let sum = |at: usize| frames.iter().map(|frame| f64::from(frame[at])).sum::<f64>();
        (0..self.size)
            .map(|at| sum(at) / frames.len() as f64)
            .collect()
    }
}
