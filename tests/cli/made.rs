//! Expected values for the tests of the command.

use edgegait::people::Subject;
use edgegait::people::cohort::{self, CohortOptions};
use sha2::{Digest, Sha256};
use std::fs;
use std::path::PathBuf;

pub fn sha256(path: PathBuf) -> String {
    let digest = Sha256::digest(fs::read(path).expect("a file"));
    digest.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// Returns people of the cohort at these speeds, before they are encoded.
pub fn made(people: usize, speeds_kmh: Vec<f64>) -> Vec<Subject> {
    let options = CohortOptions {
        seed: 1,
        people,
        speeds_kmh,
        ..CohortOptions::default()
    };
    cohort::subjects(&options).expect("people")
}
