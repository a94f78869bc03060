//! Compares made people with recorded ones row by row: with `rows.csv` of `reality/`, whose README
//! defines its columns. No page publishes the table.

use crate::command::done;
use crate::data::given;
use crate::means::{mean, mean_row};
use crate::people::{Row, rows};
use edgegait::Dataset;
use edgegait_core::silhouette::Size;
use std::fs;

/// The design nearest to the recorded people: students in Beijing who walk at their own speed.
const DESIGN: &str = r#"seed = 2
conditions = "casia-b"
[population]
people = "0..24"
reference = "china"
age_years = [20, 30]
dressed = "for-good"
[walks]
speeds_kmh = [4.5]
takes = [{ name = "nm-01" }, { name = "bg-01", condition = "BG" }, { name = "cl-01", condition = "CL" }]
[views]
azimuth_deg = [0, 90]
[images]
size = "64x44"
raster = "rows"
"#;
const SIZE: Size = Size::S64x44;
/// Bands of rows, from the crown to the sole.
const BANDS: [(&str, usize, usize); 8] = [
    ("head", 0, 8),
    ("neck, shoulders", 8, 15),
    ("upper trunk", 15, 24),
    ("forearms", 24, 30),
    ("hips", 30, 36),
    ("thighs", 36, 46),
    ("shanks", 46, 58),
    ("feet", 58, 64),
];
/// The rows whose centroid is column 0.
const MIDDLE: std::ops::Range<usize> = 30..36;
/// Columns of the file, in the order of [`measures`].
const NAMES: [&str; 5] = ["width", "front", "back", "centroid", "motion"];

/// Returns the measures of each row of the mean of GEIs from 0 to 1, one a person; not a number
/// where a row has no such pixel.
fn measures(people: &[Vec<f64>]) -> Vec<[f64; NAMES.len()]> {
    let gei = mean_row(people.iter().map(Vec::as_slice));
    let columns = SIZE.columns();
    let sums = |pixels: &[f64]| {
        let moments = pixels
            .iter()
            .enumerate()
            .map(|(at, pixel)| (at % columns) as f64 * pixel);
        (moments.sum::<f64>(), pixels.iter().sum::<f64>())
    };
    let (moment, sum) = sums(&gei[MIDDLE.start * columns..MIDDLE.end * columns]);
    let middle = moment / sum;
    let row = |(row, pixels): (usize, &[f64])| {
        let (moment, width) = sums(pixels);
        // The outer side of a pixel, as in the file.
        let edge =
            |at: Option<usize>, side: f64| at.map_or(f64::NAN, |at| at as f64 + side - middle);
        let moves = people.iter().map(|gei| {
            let own = &gei[row * columns..][..columns];
            own.iter().map(|pixel| pixel * (1.0 - pixel)).sum::<f64>()
        });
        [
            width,
            edge(pixels.iter().position(|pixel| *pixel >= 0.5), -0.5),
            edge(pixels.iter().rposition(|pixel| *pixel >= 0.5), 0.5),
            moment / width - middle,
            mean(moves),
        ]
    };
    gei.chunks_exact(columns).enumerate().map(row).collect()
}

/// Returns the mean of a measure over those of some rows that have it.
fn of(rows: &[[f64; NAMES.len()]], measure: usize) -> f64 {
    mean(
        rows.iter()
            .map(|row| row[measure])
            .filter(|value| value.is_finite()),
    )
}

mod slow_of_data {
    use super::*;

    #[test]
    #[ignore = "slow without optimisation; needs EDGEGAIT_DATA"]
    fn made_people_beside_recorded_ones_by_bands_of_rows() {
        let file = rows(&given().join("reality/rows.csv"));
        let folder = tempfile::tempdir().expect("a folder");
        let at = folder.path();
        fs::write(at.join("near.toml"), DESIGN).expect("a design");
        done(at, &["generate", "near.toml", "--out", "near"]);
        let made = Dataset::open(at.join("near")).expect("a dataset");
        for (view, condition) in [0, 90]
            .into_iter()
            .flat_map(|view| ["nm", "bg", "cl"].map(|take| (view, take)))
        {
            let of_set = |set: &str| -> Vec<[f64; NAMES.len()]> {
                let is_it = |row: &&Row| {
                    row["set"] == set
                        && row["view"] == view.to_string()
                        && row["condition"] == condition
                };
                let values = |row: &Row| NAMES.map(|name| row[name].parse().unwrap_or(f64::NAN));
                file.iter().filter(is_it).map(values).collect()
            };
            let (recorded, before) = (of_set("recorded"), of_set("edgegait"));
            let index = made.index().iter().enumerate();
            let seen = index.filter(|(_, one)| {
                one.azimuth_deg == f64::from(view) && one.walk.starts_with(condition)
            });
            let geis: Vec<Vec<f64>> = seen
                .map(|(at, _)| {
                    made.bytes(at)
                        .iter()
                        .map(|pixel| f64::from(*pixel) / 255.0)
                        .collect()
                })
                .collect();
            assert_eq!(
                (geis.len(), recorded.len(), before.len()),
                (24, SIZE.rows(), SIZE.rows())
            );
            let now = measures(&geis);
            println!("{view:03} {condition}: made, recorded (made on 2026-11-26); columns");
            println!(
                "{:<16} {}",
                "",
                NAMES.map(|name| format!("{name:<22}")).concat()
            );
            for (name, from, to) in BANDS {
                let cells = std::array::from_fn::<_, { NAMES.len() }, _>(|measure| {
                    let [now, recorded, before] =
                        [&now, &recorded, &before].map(|rows| of(&rows[from..to], measure));
                    format!("{now:>6.2} {recorded:>6.2} ({before:>5.2}) ")
                });
                println!("{name:<16} {}", cells.concat());
            }
            // The mean width of a row: made people are within 10 % of what is known.
            let [now, recorded, before] = [&now, &recorded, &before].map(|rows| of(rows, 0));
            assert!(
                (0.9 * recorded.min(before)..1.1 * recorded.max(before)).contains(&now),
                "{view} {condition}: {now} {recorded} {before}"
            );
        }
    }
}
