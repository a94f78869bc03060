//! Synthetic bodies, measured as ANSUR II measured people, have the requested dimensions.

#[path = "anthropometry/measured.rs"]
mod measured;
#[path = "anthropometry/statue.rs"]
mod statue;

use edgegait::people::cohort::Person;
use edgegait::people::cohort::anthropometry::{DIMENSIONS, Dimensions};
use edgegait::people::cohort::body;
use edgegait_core::pack::Sex;
use measured::{Measured, measure};
use statue::Statue;

const SEXES: [Sex; 2] = [Sex::Female, Sex::Male];
/// The largest relative error of a dimension.
const TOLERANCE: f64 = 0.02;

/// ANSUR II's published means of women and men, mm, with the names of [`Measured`].
const MEANS: [(&str, f64, f64); DIMENSIONS + 1] = [
    ("stature", 1628.5, 1756.2),
    ("biacromial_breadth", 365.3, 415.7),
    ("bideltoid_breadth", 450.3, 510.4),
    ("hip_breadth", 353.8, 345.7),
    ("bicristal_breadth", 273.3, 275.4),
    ("chest_breadth", 269.3, 289.4),
    ("chest_depth", 247.4, 253.8),
    ("waist_breadth", 299.9, 326.4),
    ("waist_depth", 213.0, 237.8),
    ("buttock_depth", 232.9, 245.8),
    ("thigh_circumference", 616.1, 625.1),
    ("lower_thigh_circumference", 400.7, 409.3),
    ("calf_circumference", 373.3, 392.3),
    ("ankle_circumference", 215.7, 229.3),
    ("biceps_circumference", 305.6, 358.1),
    ("forearm_circumference", 264.1, 310.1),
    ("wrist_circumference", 154.8, 175.9),
    ("neck_circumference", 329.8, 397.6),
    ("head_breadth", 147.8, 154.3),
    ("head_length", 189.8, 199.5),
    ("acromial_height", 1335.1, 1440.7),
    ("cervicale_height", 1395.7, 1517.3),
    ("suprasternale_height", 1329.7, 1438.6),
    ("trochanterion_height", 845.4, 900.9),
    ("crotch_height", 782.3, 845.9),
    ("knee_height", 465.9, 491.7),
    ("malleolus_height", 62.7, 72.9),
    ("iliocristale_height", 995.7, 1061.6),
    ("chest_height", 1171.6, 1291.1),
    ("acromion_radiale_length", 311.2, 335.2),
    ("radiale_stylion_length", 241.3, 267.9),
    ("hand_length", 181.1, 193.3),
    ("hand_breadth", 78.2, 88.3),
    ("foot_length", 246.3, 271.2),
    ("foot_breadth", 92.7, 101.9),
    ("tragion_to_vertex", 126.5, 131.1),
];

/// Returns slight and heavy, small and tall people of both sexes.
fn grid() -> Vec<(Dimensions, Sex)> {
    let mut people = Vec::new();
    for sex in SEXES {
        for stature_m in [1.45, 1.55, 1.65, 1.75, 1.85, 1.95] {
            for bmi in [18.0, 22.0, 26.0, 30.0, 35.0] {
                let mass_kg = bmi * stature_m * stature_m;
                let person =
                    Dimensions::expected(stature_m, mass_kg, Some(sex), &[0.0; DIMENSIONS]);
                people.push((person.expect("a plausible person"), sex));
            }
        }
    }
    people
}

/// Returns the people of the built-in cohort, who differ from the expected dimensions everywhere.
fn cohort() -> Vec<(Dimensions, Sex)> {
    let person = |index| Person::of_cohort(1, index).expect("a person");
    let people = (0..26).map(person);
    people
        .map(|person| (person.dimensions, person.sex))
        .collect()
}

/// Returns the relative errors of each dimension over all people, and prints them as a table.
fn errors(title: &str, people: &[(Dimensions, Sex)]) -> Vec<(&'static str, f64)> {
    let bodies: Vec<Vec<Measured>> = people
        .iter()
        .map(|(d, sex)| measure(&Statue::of(&body::body(d, body::offsets(d))), d, *sex))
        .collect();
    println!("{title}, {} people: error %", people.len());
    println!(
        "{:<26} {:>6} {:>6} {:>6}",
        "dimension", "least", "mean", "most"
    );
    let dimensions = 0..bodies[0].len();
    dimensions
        .map(|row| {
            let all: Vec<f64> = bodies.iter().map(|body| body[row].error()).collect();
            let least = all.iter().copied().fold(f64::MAX, f64::min);
            let most = all.iter().copied().fold(f64::MIN, f64::max);
            let mean = all.iter().sum::<f64>() / all.len() as f64;
            let name = bodies[0][row].name;
            println!(
                "{name:<26} {:>6.2} {:>6.2} {:>6.2}",
                1e2 * least,
                1e2 * mean,
                1e2 * most
            );
            (name, most.max(-least))
        })
        .collect()
}

#[test]
fn bodies_have_the_dimensions_that_they_were_asked_for() {
    let mut missed = Vec::new();
    for (title, people) in [("grid", grid()), ("cohort", cohort())] {
        let errors = errors(title, &people);
        assert_eq!(errors.len(), DIMENSIONS + 1);
        missed.extend(errors.into_iter().filter(|(_, error)| *error > TOLERANCE));
    }
    assert!(missed.is_empty(), "{missed:?}");
}

#[test]
fn the_mean_woman_and_man_have_the_published_means() {
    for sex in SEXES {
        let person = Person::average(sex);
        let found = measure(&Statue::of(&person.body), &person.dimensions, sex);
        assert_eq!(found.len(), MEANS.len());
        for (measured, (name, woman, man)) in found.iter().zip(MEANS) {
            assert_eq!(measured.name, name);
            let mean_m = 1e-3 * if sex == Sex::Male { man } else { woman };
            let error = measured.found_m / (measured.share * mean_m) - 1.0;
            assert!(
                error.abs() < TOLERANCE,
                "{sex:?} {name}: {} instead of {mean_m} m",
                measured.found_m
            );
        }
    }
}

#[test]
fn left_and_right_mirror_each_other_to_a_tenth_of_a_millimetre() {
    for (d, _) in grid().iter().chain(&cohort()) {
        let statue = Statue::of(&body::body(d, body::offsets(d)));
        for (joint, points) in &statue.hulls {
            let others = statue.points(&[joint.mirrored()]);
            for point in points {
                let mirrored = glam::DVec3::new(-point.x, point.y, point.z);
                assert!(
                    others.iter().any(|other| other.distance(mirrored) < 1e-4),
                    "{joint:?} {point}"
                );
            }
        }
    }
}
