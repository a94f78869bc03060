//! The offline fit of differences between people's gaits to recorded walkers.
//!
//! Imports the healthy walkers of the data folder, computes the norms' angles of every gait cycle
//! and their differences from the norm at that speed and stature. Prints the tables of
//! `covariation`, and means and spreads of angles by data set, from which the constants of `style`
//! and the lean in `angles` were chosen:
//!
//! ```text
//! EDGEGAIT_DATA=... cargo test --release -p edgegait --lib cohort::fit -- --ignored --nocapture
//! ```
//!
//! It is here and not in tests/research because it measures by the norms and the pose of the model,
//! which are private.
//!
//! Imported cycles are closed loops: half of the gap between their ends is noise, and so is what
//! the low-pass filter removes. Spreads between cycles are therefore upper bounds for a cycle's
//! mean, and lower bounds for its swing.

mod features;
mod invert;
mod report;
mod statistics;
mod walkers;

use super::covariation::{FACTORS, FEATURES, Feature, LOADINGS, ORDER, SPREADS};
use super::norms::Angle;
use features::Features;
use statistics::{Matrix, correlation, mean_and_sd, principal_factors, shrunk_correlations};
use std::collections::BTreeMap;
use walkers::{ManifestTake, clips};

/// Returns a feature of a cycle.
fn value(feature: Feature, of: &Features) -> f64 {
    match feature {
        Feature::Offset(Angle::HipFlexion) => {
            let offset_deg = |angle: Angle| of.angles[angle as usize].offset_deg;
            offset_deg(Angle::HipFlexion)
                - offset_deg(Angle::PelvicTilt)
                - 0.5 * offset_deg(Angle::KneeFlexion)
        }
        Feature::Offset(angle) => of.angles[angle as usize].offset_deg,
        Feature::Amplitude(angle) => of.angles[angle as usize].log_amplitude,
        Feature::Delay(angle) => of.angles[angle as usize].delay,
        Feature::StepWidth => of.steps.step_width_m,
        Feature::WalkRatio => of.steps.log_walk_ratio,
        Feature::Bob => of.steps.bob_m,
        Feature::Sway => of.steps.sway_m,
        Feature::Clearance => of.steps.clearance_m,
        Feature::HeadPitch => of.steps.head_deg,
    }
}

/// Returns the features of a cycle, and its speed last.
fn row(of: &Features) -> Vec<f64> {
    let mut row: Vec<f64> = ORDER.iter().map(|&feature| value(feature, of)).collect();
    row.push(of.steps.speed_mps);
    row
}

/// Returns the mean of rows.
fn mean_row(rows: &[Vec<f64>]) -> Vec<f64> {
    let count = rows.len() as f64;
    (0..rows[0].len())
        .map(|column| rows.iter().map(|row| row[column]).sum::<f64>() / count)
        .collect()
}

/// Returns rows without the linear effect of their last column, the speed, and without that column.
fn without_speed(rows: &[Vec<f64>]) -> Matrix {
    let mean = mean_row(rows);
    let speed = FEATURES;
    let squares: f64 = rows
        .iter()
        .map(|row| (row[speed] - mean[speed]).powi(2))
        .sum();
    let slopes: Vec<f64> = (0..speed)
        .map(|column| {
            let products = rows
                .iter()
                .map(|row| (row[column] - mean[column]) * (row[speed] - mean[speed]));
            products.sum::<f64>() / squares.max(1e-12)
        })
        .collect();
    rows.iter()
        .map(|row| {
            (0..speed)
                .map(|column| row[column] - slopes[column] * (row[speed] - mean[speed]))
                .collect()
        })
        .collect()
}

/// Returns the means of each person's takes, for the people of `dataset`.
fn people(clips: &[ManifestTake], dataset: &str) -> BTreeMap<String, Vec<Vec<f64>>> {
    let mut people: BTreeMap<String, Vec<Vec<f64>>> = BTreeMap::new();
    for clip in clips.iter().filter(|clip| clip.dataset == dataset) {
        let rows: Vec<Vec<f64>> = clip.cycles.iter().map(row).collect();
        people
            .entry(clip.subject.clone())
            .or_default()
            .push(mean_row(&rows));
    }
    people
}

/// Returns the spread of each feature between takes, less the part due to their few cycles, and
/// between cycles.
fn spreads_within(clips: &[ManifestTake], dataset: &str) -> Vec<(f64, f64)> {
    let (mut cycles, mut freedom, mut shares) = (Vec::new(), 0.0, Vec::new());
    for clip in clips.iter().filter(|clip| clip.dataset == dataset) {
        let rows: Vec<Vec<f64>> = clip.cycles.iter().map(row).collect();
        shares.push(1.0 / rows.len() as f64);
        if rows.len() > 1 {
            freedom += rows.len() as f64 - 1.0;
            cycles.extend(centred(&rows));
        }
    }
    let (mut takes, mut take_freedom) = (Vec::new(), -1.0);
    for rows in people(clips, dataset)
        .values()
        .filter(|rows| rows.len() > 1)
    {
        take_freedom += rows.len() as f64 - 1.0;
        takes.extend(centred(rows));
    }
    let takes = without_speed(&takes);
    let share = shares.iter().sum::<f64>() / shares.len() as f64;
    let variance = |rows: &[Vec<f64>], column: usize, freedom: f64| {
        rows.iter()
            .map(|row| row[column] * row[column])
            .sum::<f64>()
            / freedom
    };
    println!(
        "within people: {} takes and {} cycles that have others beside them",
        takes.len(),
        cycles.len()
    );
    (0..FEATURES)
        .map(|column| {
            let cycle = variance(&cycles, column, freedom);
            let take = variance(&takes, column, take_freedom) - share * cycle;
            (libm::sqrt(take.max(0.0)), libm::sqrt(cycle))
        })
        .collect()
}

fn centred(rows: &[Vec<f64>]) -> Matrix {
    let mean = mean_row(rows);
    rows.iter()
        .map(|row| {
            row.iter()
                .zip(&mean)
                .map(|(value, mean)| value - mean)
                .collect()
        })
        .collect()
}

fn print_table(name: &str, width: &str, decimals: usize, table: &Matrix) {
    println!("pub(super) const {name}: [[f64; {width}]; FEATURES] = [");
    for (feature, row) in ORDER.iter().zip(table) {
        let row: Vec<String> = row
            .iter()
            .map(|value| format!("{value:.decimals$}"))
            .collect();
        println!("    [{}], // {feature:?}", row.join(", "));
    }
    println!("];");
}

fn off_diagonals(matrix: &Matrix, columns: &[usize]) -> Vec<f64> {
    let mut values = Vec::new();
    for (index, &i) in columns.iter().enumerate() {
        values.extend(columns[..index].iter().map(|&j| matrix[i][j]));
    }
    values
}

/// Returns the correlation of two samples' correlations, over the columns that both recorded.
fn agreement(rows: &[Vec<f64>], others: &[Vec<f64>]) -> f64 {
    let is_recorded = |feature: &Feature| match feature {
        Feature::Offset(angle) | Feature::Amplitude(angle) | Feature::Delay(angle) => {
            (*angle as usize) < Angle::ThoraxTilt as usize
        }
        Feature::HeadPitch => false,
        _ => true,
    };
    let legs: Vec<usize> = (0..FEATURES)
        .filter(|&index| is_recorded(&ORDER[index]))
        .collect();
    let [a, b] = [rows, others].map(|rows| off_diagonals(&shrunk_correlations(rows).sample, &legs));
    correlation(&a, &b)
}

#[test]
#[ignore = "a fit of recorded walkers: needs EDGEGAIT_DATA"]
fn the_tables_are_those_of_the_recorded_walkers() {
    let data = std::env::var_os("EDGEGAIT_DATA").expect("EDGEGAIT_DATA: expected a folder");
    let walks = clips(std::path::Path::new(&data));
    report::print(&walks);

    let people_of = |dataset: &str| -> Matrix {
        let people = people(&walks, dataset);
        people.values().map(|takes| mean_row(takes)).collect()
    };
    let rows = without_speed(&people_of("cmu"));
    // The mean and the slope of speed take a degree of freedom each.
    let lost = libm::sqrt((rows.len() as f64 - 1.0) / (rows.len() as f64 - 2.0));
    let spreads: Matrix = spreads_within(&walks, "cmu")
        .into_iter()
        .enumerate()
        .map(|(column, (take, cycle))| {
            let values: Vec<f64> = rows.iter().map(|row| row[column]).collect();
            vec![lost * mean_and_sd(&values).1, take, cycle]
        })
        .collect();
    let shrunk = shrunk_correlations(&rows);
    println!(
        "{} people, intensity of shrinkage {:.3}",
        rows.len(),
        shrunk.intensity
    );
    let loadings = principal_factors(&shrunk.shrunk, FACTORS);
    print_table("SPREADS", "3", 4, &spreads);
    print_table("LOADINGS", "FACTORS", 2, &loadings);

    let mut others = Matrix::new();
    for dataset in ["auckland_c3dparser", "biomechzoo", "btkdata", "opensim"] {
        let rows = people_of(dataset)
            .into_iter()
            .filter(|row| row.iter().all(|v| v.is_finite()));
        others.extend(centred(&rows.collect::<Vec<_>>()));
    }
    println!(
        "correlation of correlations with {} others, centred by data set, over legs and pelvis: {:.2}",
        others.len(),
        agreement(&rows, &without_speed(&others))
    );

    for (committed, found) in LOADINGS.iter().flatten().zip(loadings.iter().flatten()) {
        assert!((committed - found).abs() < 0.0051, "{committed} {found}");
    }
    for (committed, found) in SPREADS.iter().flatten().zip(spreads.iter().flatten()) {
        assert!((committed - found).abs() < 5.1e-5, "{committed} {found}");
    }
}
