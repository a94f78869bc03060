//! The people and the measuring times that all benchmarks share.

use criterion::Criterion;
use edgegait::encode::{MAX_ERROR_MM, encode_subjects};
use edgegait::people::cohort::{CohortOptions, subjects};
use std::time::Duration;

/// Returns a pack of four people of the built-in cohort (seed 1), each with one walk at 5 km/h. A
/// person's avatar, walk and clip have the person's number.
pub fn pack() -> Vec<u8> {
    let options = CohortOptions {
        people: 4,
        speeds_kmh: vec![5.0],
        ..CohortOptions::default()
    };
    let people = subjects(&options).expect("5 km/h is within the norms");
    encode_subjects(&people, MAX_ERROR_MM, &|| Ok(())).expect("four people fit a pack")
}

/// Returns settings of half a second of warm-up and two seconds of measuring for each benchmark,
/// under two minutes in total. `cargo bench -- --measurement-time 20` measures longer.
pub fn criterion() -> Criterion {
    Criterion::default()
        .warm_up_time(Duration::from_millis(500))
        .measurement_time(Duration::from_secs(2))
        .sample_size(50)
        .without_plots()
        .configure_from_args()
}
