//! Means and spreads of recorded walkers by data set.

use super::features::{AngleFeatures, Features};
use super::statistics::mean_and_sd;
use super::walkers::ManifestTake;
use crate::people::cohort::norms::Angle;
use std::collections::BTreeMap;

/// Prints the mean of a number over each person's takes, by data set: its mean and standard
/// deviation over people.
fn print_number(name: &str, takes: &[ManifestTake], of: impl Fn(&Features) -> f64) {
    let mut people: BTreeMap<(&str, &str), Vec<f64>> = BTreeMap::new();
    for take in takes {
        let mean = take.cycles.iter().map(&of).sum::<f64>() / take.cycles.len() as f64;
        let person = people.entry((&take.dataset, &take.subject));
        person.or_default().push(mean);
    }
    let mut sets: BTreeMap<&str, Vec<f64>> = BTreeMap::new();
    for ((dataset, _), takes) in people {
        let mean = takes.iter().sum::<f64>() / takes.len() as f64;
        sets.entry(dataset).or_default().push(mean);
    }
    print!("{name:34}");
    for (dataset, values) in sets {
        let (mean, sd) = mean_and_sd(&values);
        print!(" {dataset} {}: {mean:.3} ({sd:.3});", values.len());
    }
    println!();
}

/// Prints how the angles of recorded walkers differ from the norm's.
pub(super) fn print(takes: &[ManifestTake]) {
    println!("mean (standard deviation) over people");
    let print_angle = |angle: Angle, name: &str, number: fn(&AngleFeatures) -> f64| {
        let of = |features: &Features| number(&features.angles[angle as usize]);
        print_number(&format!("{angle:?} {name}"), takes, of);
    };
    for angle in Angle::ALL {
        print_angle(angle, "offset, degrees", |angle| angle.offset_deg);
        print_angle(angle, "amplitude, log", |angle| angle.log_amplitude);
        print_angle(angle, "delay, cycles", |angle| angle.delay);
        print_angle(angle, "likeness", |angle| angle.likeness);
        print_angle(angle, "asymmetry, degrees", |angle| angle.asymmetry_deg);
    }
    print_number("elbow's plane inwards, degrees", takes, |features| {
        features.elbow_plane_deg
    });
}
