//! Means, distances of templates, and intervals over people.

use std::collections::BTreeMap;

/// Returns the mean of numbers.
pub fn mean(values: impl IntoIterator<Item = f64>) -> f64 {
    let values = values.into_iter();
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), value| (sum + value, count + 1.0));
    sum / count
}

/// Returns the mean of rows of the same length, number by number.
pub fn mean_row<'a>(rows: impl Iterator<Item = &'a [f64]> + Clone) -> Vec<f64> {
    let length = rows.clone().next().map_or(0, <[f64]>::len);
    (0..length)
        .map(|at| mean(rows.clone().map(|row| row[at])))
        .collect()
}

/// Returns the root mean square difference of two templates.
pub fn apart(a: &[f64], b: &[f64]) -> f64 {
    mean(a.iter().zip(b).map(|(a, b)| (a - b) * (a - b))).sqrt()
}

/// Returns a mean over people's values and half of its 95 % interval: 1.96 standard errors over
/// people, whose values are similar, as a ratio of sums (Cochran 1977, 6.3).
pub fn over_people<'a>(values: impl IntoIterator<Item = (&'a str, f64)>) -> (f64, f64) {
    let mut people: BTreeMap<&str, (f64, f64)> = BTreeMap::new();
    for (person, value) in values {
        let person = people.entry(person).or_default();
        *person = (person.0 + value, person.1 + 1.0);
    }
    let all: f64 = people.values().map(|person| person.1).sum();
    let middle = people.values().map(|person| person.0).sum::<f64>() / all;
    let count = people.len() as f64;
    let squares = people
        .values()
        .map(|(sum, values)| (sum - middle * values).powi(2));
    let variance = squares.sum::<f64>() * count / (count - 1.0);
    (middle, 1.96 * variance.sqrt() / all)
}
