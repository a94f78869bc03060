//! Makes the tables of synthetic and recorded people in src/guide/people.md: how well a classifier
//! distinguishes them, and the distances between and within people.
//!
//! The meaning of a recognizer's score on synthetic people for recorded ones depends on this.
//! Datasets have their own conventions (the place of a hip, arms that were not recorded), so the
//! recorded people of one are also distinguished from those of the others. That is the floor that
//! synthetic people can reach.

mod angles;
mod classifier;
mod picture;
mod walkers;

use crate::data::given;
use classifier::{Case, Separation, interval, resamples};
use edgegait::people::Subject;
use edgegait::{Condition, Doses, dose};
use std::collections::BTreeMap;
use std::path::Path;
use walkers::{
    MADE_PEOPLE, Sample, Split, VIEWS_DEG, is_patient, made, made_on_two_days, on_one_body,
    recorded, samples, set_of,
};

/// The rows of a GEI.
const ROWS: usize = 50;
/// The parts of a standing figure, by their rows.
const PARTS: [(&str, std::ops::Range<usize>); 5] = [
    ("head and neck", 0..9),
    ("trunk and arms", 9..25),
    ("hips to knees", 25..37),
    ("shanks", 37..46),
    ("feet", 46..50),
];
/// The fewest people of a dataset that is compared with the others.
const LEAST_PEOPLE: usize = 4;

/// An area under the curve that is always low enough, even if that between datasets is lower.
const LEAST_ASKED: f64 = 0.85;
/// The largest excess of synthetic people's area over these: 0.07 was measured from the front, none
/// from other viewpoints.
const SLACK: f64 = 0.08;

/// People and their cycles, with a level camera and with one rolled by 3 degrees.
struct Walkers {
    people: Vec<Subject>,
    level: Vec<Sample>,
    rolled: Vec<Sample>,
}

impl Walkers {
    fn of(people: Vec<Subject>, variations: &[u32]) -> Self {
        let roll = Condition::from_doses(Doses::new(dose("roll=3deg").ok()));
        Self {
            level: samples(&people, variations, None),
            rolled: samples(&people, variations, Some(&roll)),
            people,
        }
    }

    /// Returns the stored cycles of healthy people, with `first` added to the number of each
    /// person.
    fn stored(&self, first: usize) -> Vec<Sample> {
        let is_stored = |sample: &&Sample| sample.cycle.1 == 0 && !self.is_patient(sample.person);
        let mut stored: Vec<Sample> = self.level.iter().filter(is_stored).cloned().collect();
        for sample in &mut stored {
            sample.person += first;
        }
        stored
    }

    fn is_patient(&self, person: usize) -> bool {
        is_patient(&self.people[person])
    }
}

/// Formats a number with its interval.
fn with_interval(value: f64, (low, high): (f64, f64)) -> String {
    format!("{value:.2} ({low:.2} - {high:.2})")
}

/// The separation of groups of people by viewpoint, also by parts of the image.
struct Apart<'a> {
    /// The group of each person: a dataset or `made`.
    groups: Vec<String>,
    samples: &'a [Sample],
    resamples: Vec<Vec<f64>>,
}

impl Apart<'_> {
    fn cases(&self, view: usize, is_first: impl Fn(usize) -> Option<bool>) -> Vec<Case<'_>> {
        let case = |sample: &Sample| is_first(sample.person).map(|first| (sample.person, first));
        let cases = self
            .samples
            .iter()
            .filter_map(|it| case(it).map(|case| (it, case)));
        cases
            .map(|(sample, (person, is_first))| Case {
                person,
                is_first,
                gei: &sample.geis[view],
            })
            .collect()
    }

    /// Returns the area under the curve in each resample of people.
    fn spread(&self, separation: &Separation) -> Vec<f64> {
        let auc = |times: &Vec<f64>| separation.auc(|person| times[person]);
        self.resamples.iter().map(auc).collect()
    }

    fn is_made(&self, person: usize) -> bool {
        self.groups[person] == "made"
    }

    /// Separates synthetic from recorded people, with each dataset judged by a classifier trained
    /// on the others, where the conventions of one dataset do not help.
    fn unseen(&self, view: usize, sets: &[(String, usize)]) -> Separation {
        let cases = self.cases(view, |person| Some(self.is_made(person)));
        let part = |person: usize| {
            let set = sets.iter().position(|(set, _)| *set == self.groups[person]);
            (person, set.unwrap_or(person % sets.len()))
        };
        let parts = cases.iter().map(|case| part(case.person)).collect();
        Separation::by(&cases, 0..ROWS, &parts)
    }

    /// Prints the areas of one viewpoint, and returns those of synthetic against recorded people,
    /// and of datasets against the others (mean).
    fn print(&self, view: usize, sets: &[(String, usize)]) -> (f64, f64) {
        let cases = self.cases(view, |person| Some(self.is_made(person)));
        let whole = Separation::of(&cases, 0..ROWS);
        let found = whole.auc(|_| 1.0);
        let text = with_interval(found, interval(self.spread(&whole)));
        println!("  made against recorded        {text}");
        for (set, people) in sets {
            let of = |person: usize| {
                f64::from(u8::from(
                    self.is_made(person) || self.groups[person] == *set,
                ))
            };
            println!(
                "    of them {set:<20} {:.2} ({people} people)",
                whole.auc(of)
            );
        }
        let unseen = self.unseen(view, sets);
        let text = with_interval(unseen.auc(|_| 1.0), interval(self.spread(&unseen)));
        println!("    of data sets not learnt from {text}");
        for (part, rows) in PARTS {
            let auc = Separation::of(&cases, rows).auc(|_| 1.0);
            println!("    by {part:<25} {auc:.2}");
        }
        let recorded: usize = sets.iter().map(|(_, people)| people).sum();
        let large = sets.iter().filter(|(_, people)| *people >= LEAST_PEOPLE);
        let (mut floor, mut alike) = (Vec::new(), Vec::new());
        let mut spreads = Vec::new();
        let mut by_part = [const { Vec::new() }; PARTS.len()];
        for (set, people) in large {
            let cases = self.cases(view, |person| {
                (!self.is_made(person)).then(|| self.groups[person] == *set)
            });
            let others = Separation::of(&cases, 0..ROWS);
            for ((_, rows), areas) in PARTS.into_iter().zip(&mut by_part) {
                areas.push(Separation::of(&cases, rows).auc(|_| 1.0));
            }
            // As many synthetic people as there are recorded people in other datasets.
            let most = recorded - people;
            let made = Separation::of(
                &self.cases(view, |person| match self.groups[person].as_str() {
                    "made" => (person < most).then_some(false),
                    group => (group == set).then_some(true),
                }),
                0..ROWS,
            );
            floor.push(others.auc(|_| 1.0));
            alike.push(made.auc(|_| 1.0));
            let spread = self.spread(&others);
            let text = with_interval(floor[floor.len() - 1], interval(spread.clone()));
            println!(
                "  {set:<10} against the other {most} {text}, against {most} made {:.2}",
                alike[alike.len() - 1],
            );
            spreads.push(spread);
        }
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
        let resampled = (0..self.resamples.len()).map(|at| {
            mean(
                &spreads
                    .iter()
                    .map(|spread| spread[at])
                    .collect::<Vec<f64>>(),
            )
        });
        println!(
            "  data sets against the others {}, against made {:.2}",
            with_interval(mean(&floor), interval(resampled.collect())),
            mean(&alike)
        );
        for ((part, _), areas) in PARTS.into_iter().zip(&by_part) {
            println!("    by {part:<25} {:.2}", mean(areas));
        }
        (found, mean(&floor))
    }
}

/// Returns the mean template of each person, and of all people.
fn means(samples: &[Sample], view: usize) -> (BTreeMap<usize, Vec<f64>>, Vec<f64>) {
    let mut sums: BTreeMap<usize, (Vec<f64>, f64)> = BTreeMap::new();
    for sample in samples {
        let gei = &sample.geis[view];
        let (sum, count) = sums
            .entry(sample.person)
            .or_insert_with(|| (vec![0.0; gei.len()], 0.0));
        for (sum, &pixel) in sum.iter_mut().zip(gei) {
            *sum += f64::from(pixel);
        }
        *count += 1.0;
    }
    let people: BTreeMap<usize, Vec<f64>> = sums
        .into_iter()
        .map(|(person, (sum, count))| (person, sum.iter().map(|sum| sum / count).collect()))
        .collect();
    let pixels = people.values().next().map_or(0, Vec::len);
    let mean = |at: usize| people.values().map(|gei| gei[at]).sum::<f64>() / people.len() as f64;
    let all = (0..pixels).map(mean).collect();
    (people, all)
}

/// Returns the Euclidean distance of templates with pixels in 0..1.
fn distance<T: Copy + Into<f64>>(a: &[T], b: &[T]) -> f64 {
    let squares = a
        .iter()
        .zip(b)
        .map(|(&a, &b)| (a.into() - b.into()).powi(2));
    squares.sum::<f64>().sqrt()
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

/// Returns the median distance between cycles of different people.
fn between(samples: &[Sample], view: usize) -> f64 {
    let pairs = samples.iter().enumerate().flat_map(|(at, a)| {
        let others = samples[at + 1..].iter().filter(|b| b.person != a.person);
        others.map(move |b| distance(&a.geis[view], &b.geis[view]))
    });
    median(pairs.collect())
}

/// Returns, for each person with such pairs of cycles, the mean distance of the pairs over the
/// median distance of the person's cycles to those of others.
fn ratios(samples: &[Sample], view: usize, is_pair: impl Fn(&Sample, &Sample) -> bool) -> Vec<f64> {
    let mut people: Vec<usize> = samples.iter().map(|sample| sample.person).collect();
    people.sort_unstable();
    people.dedup();
    let of_person = |person: usize| {
        let (own, others): (Vec<&Sample>, Vec<&Sample>) =
            samples.iter().partition(|sample| sample.person == person);
        let apart = |a: &Sample, b: &Sample| distance(&a.geis[view], &b.geis[view]);
        let mut within = Vec::new();
        for (at, a) in own.iter().enumerate() {
            let pairs = own[at + 1..].iter().filter(|b| is_pair(a, b));
            within.extend(pairs.map(|b| apart(a, b)));
        }
        let to_others = own
            .iter()
            .flat_map(|a| others.iter().map(move |b| apart(a, b)));
        let mean = within.iter().sum::<f64>() / within.len() as f64;
        (!within.is_empty()).then(|| mean / median(to_others.collect()))
    };
    people.into_iter().filter_map(of_person).collect()
}

/// Formats the mean of people's numbers, with its interval over people.
fn mean_over_people(values: &[f64]) -> String {
    let groups = vec![0; values.len()];
    let mean = |times: &Vec<f64>| {
        times
            .iter()
            .zip(values)
            .map(|(times, value)| times * value)
            .sum::<f64>()
            / values.len() as f64
    };
    let spread = resamples(&groups).iter().map(mean).collect();
    with_interval(mean(&vec![1.0; values.len()]), interval(spread))
}

/// Returns the share of people that the nearest template identifies, enrolled by the first cycle of
/// a pair and probed by the second.
fn found(gallery: &[Sample], probes: &[Sample], view: usize, pairs: &[(usize, usize)]) -> f64 {
    let nearest = |probe: &Sample| {
        let apart = |at: usize| distance(&gallery[at].geis[view], &probe.geis[view]);
        let enrolled = pairs.iter().map(|&(enrolled, _)| enrolled);
        let best = enrolled.min_by(|&a, &b| apart(a).total_cmp(&apart(b)));
        best.map(|at| gallery[at].person)
    };
    let hits = pairs
        .iter()
        .filter(|&&(_, probe)| nearest(&probes[probe]) == Some(probes[probe].person));
    hits.count() as f64 / pairs.len() as f64
}

/// Returns the first such pair of cycles of each person.
fn pairs(samples: &[Sample], is_pair: impl Fn(&Sample, &Sample) -> bool) -> Vec<(usize, usize)> {
    let mut pairs: BTreeMap<usize, (usize, usize)> = BTreeMap::new();
    for (first, a) in samples.iter().enumerate() {
        for (second, b) in samples.iter().enumerate().skip(first + 1) {
            if a.person == b.person && is_pair(a, b) {
                pairs.entry(a.person).or_insert((first, second));
            }
        }
    }
    pairs.into_values().collect()
}

/// Returns the number of healthy people in each dataset.
fn sets(people: &[Subject]) -> Vec<(String, usize)> {
    let mut sets: BTreeMap<&str, usize> = BTreeMap::new();
    for person in people.iter().filter(|person| !is_patient(person)) {
        *sets.entry(set_of(person)).or_default() += 1;
    }
    sets.into_iter()
        .map(|(set, people)| (set.to_owned(), people))
        .collect()
}

/// Prints (a), (b) and (c), and writes the images.
fn told_apart(made: &Walkers, recorded: &Walkers) -> Vec<(f64, f64)> {
    let (of_made, of_recorded) = (made.stored(0), recorded.stored(made.people.len()));
    let people = || made.people.iter().chain(&recorded.people);
    let groups: Vec<String> = people().map(|person| set_of(person).to_owned()).collect();
    let numbers: Vec<usize> = people()
        .map(|person| match is_patient(person) {
            true => usize::MAX,
            false => groups
                .iter()
                .position(|group| group == set_of(person))
                .expect("its own"),
        })
        .collect();
    let all = [&of_made[..], &of_recorded[..]].concat();
    let apart = Apart {
        resamples: resamples(&numbers),
        samples: &all,
        groups,
    };
    let sets = sets(&recorded.people);
    let mut rows = Vec::new();
    let mut areas = Vec::new();
    for (view, (azimuth, elevation)) in VIEWS_DEG.into_iter().enumerate() {
        println!("azimuth {azimuth}, elevation {elevation}");
        areas.push(apart.print(view, &sets));
        let (_, mean_made) = means(&of_made, view);
        let (_, mean_recorded) = means(&of_recorded, view);
        let pairs = mean_made.iter().zip(&mean_recorded);
        let off = pairs.map(|(a, b)| (a - b).abs()).sum::<f64>() / mean_made.len() as f64;
        println!(
            "  mean GEIs differ by {:.1} of 255; median distance between people {:.1} made, {:.1} recorded",
            255.0 * off,
            between(&of_made, view),
            between(&of_recorded, view),
        );
        let mut row = vec![
            mean_made.clone(),
            mean_recorded.clone(),
            picture::difference(&mean_made, &mean_recorded),
        ];
        for (set, _) in sets.iter().filter(|(_, people)| *people >= LEAST_PEOPLE) {
            let of: Vec<Sample> = of_recorded
                .iter()
                .filter(|sample| apart.groups[sample.person] == *set)
                .cloned()
                .collect();
            row.push(picture::difference(&mean_made, &means(&of, view).1));
        }
        rows.push(row);
    }
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("likeness.png");
    picture::write(&path, &rows);
    println!(
        "{}: means of made and of recorded people, and what made people have more of (white)",
        path.display()
    );
    areas
}

/// The variations of synthetic cycles: the mean, two cycles of the first take and one of the
/// second.
const MADE_VARIATIONS: [u32; 4] = [0, 1, 2, 9];

/// Returns the number of the take of a synthetic cycle; takes have eight cycles.
fn day(sample: &Sample) -> u32 {
    sample.cycle.1 / 8
}

/// Prints distances between the days of synthetic people, and how many people pixels find.
fn between_days() {
    let all = samples(&made_on_two_days(MADE_PEOPLE), &[1, 2, 9], None);
    let of_day = |sample: &&Sample| sample.take == "walk-5kmh";
    let first: Vec<Sample> = all.iter().filter(of_day).cloned().collect();
    let same_take = |a: &Sample, b: &Sample| a.take == b.take && day(a) == day(b);
    let other_take = |a: &Sample, b: &Sample| a.take == b.take && day(a) != day(b);
    let other_day = |a: &Sample, b: &Sample| a.take != b.take;
    for (view, (azimuth, elevation)) in VIEWS_DEG.into_iter().enumerate() {
        println!("azimuth {azimuth}, elevation {elevation}: people who walk at 5 km/h");
        for (what, among, is_pair) in [
            (
                "cycles of a take",
                &first,
                &same_take as &dyn Fn(&Sample, &Sample) -> bool,
            ),
            ("takes of a day", &first, &other_take),
            ("days", &all, &other_day),
        ] {
            let apart = mean_over_people(&ratios(among, view, is_pair));
            let rate = 100.0 * found(among, among, view, &pairs(among, is_pair));
            println!("  made, {what:<21} {apart}, {rate:.0} % found");
        }
    }
}

/// Prints (d) and (e).
fn within_and_rolled(made: &Walkers, recorded: &Walkers) {
    let same_take = |a: &Sample, b: &Sample| a.take == b.take && day(a) == day(b);
    let other_take = |a: &Sample, b: &Sample| a.take != b.take;
    // The takes of a synthetic person have one speed; the mean cycle belongs to no take.
    let made_cycles: Vec<Sample> = made
        .level
        .iter()
        .filter(|sample| sample.cycle.1 > 0)
        .cloned()
        .collect();
    let other_day = |a: &Sample, b: &Sample| a.take == b.take && day(a) != day(b);
    let healthy: Vec<Sample> = recorded.stored(0);
    for (view, (azimuth, elevation)) in VIEWS_DEG.into_iter().enumerate() {
        println!(
            "azimuth {azimuth}, elevation {elevation}: distance within a person over between people"
        );
        for (what, values) in [
            (
                "recorded, cycles of a take",
                ratios(&healthy, view, same_take),
            ),
            (
                "made, cycles of a walk",
                ratios(&made_cycles, view, same_take),
            ),
            ("recorded, takes", ratios(&recorded.level, view, other_take)),
            ("made, takes", ratios(&made_cycles, view, other_day)),
        ] {
            let people = values.len();
            println!(
                "  {what:<27} {} ({people} people)",
                mean_over_people(&values)
            );
        }
    }
    let enrolled = pairs(&healthy, same_take);
    let people = enrolled.len();
    let is_healthy = |sample: &&Sample| !recorded.is_patient(sample.person);
    let rolled: Vec<Sample> = recorded.rolled.iter().filter(is_healthy).cloned().collect();
    // The same number of synthetic people, at 5 km/h, as most of the recorded people walk.
    let varied = pairs(&made.level, |a, b| {
        same_take(a, b) && a.take == "walk-5kmh" && a.cycle.1 > 0
    });
    let varied = &varied[..people.min(varied.len())];
    for (view, (azimuth, elevation)) in VIEWS_DEG.into_iter().enumerate() {
        let of = |walkers: [&[Sample]; 2], pairs: &[(usize, usize)]| {
            let rates = walkers.map(|probes| 100.0 * found(walkers[0], probes, view, pairs));
            format!("{:.0} % level, {:.0} % rolled", rates[0], rates[1])
        };
        println!(
            "azimuth {azimuth}, elevation {elevation}: {people} people found by pixels, recorded {}, made {}",
            of([&healthy, &rolled], &enrolled),
            of([&made.level, &made.rolled], varied),
        );
    }
}

mod slow_of_data {
    use super::*;

    /// Prints the measurements, and bounds the separation of synthetic from recorded people, so
    /// that a change of the synthetic people cannot increase it unnoticed.
    #[test]
    #[ignore = "slow without optimisation; needs EDGEGAIT_DATA"]
    fn made_people_are_measured_beside_recorded_ones() {
        let split = Split::asked();
        let recorded = Walkers::of(recorded(&given(), split), &[0]);
        let made = Walkers::of(made(MADE_PEOPLE), &MADE_VARIATIONS);
        println!("{split:?}: {:?}", sets(&recorded.people));
        let areas = told_apart(&made, &recorded);
        within_and_rolled(&made, &recorded);
        between_days();
        angles::print(&made.people, &recorded.people);
        for (made_against_recorded, floor) in areas {
            // An area of one half is chance.
            assert!((0.5..=1.0).contains(&floor), "{floor}");
            assert!(
                made_against_recorded <= floor.max(LEAST_ASKED) + SLACK,
                "{made_against_recorded}: data sets are told from each other with {floor}"
            );
        }
    }

    /// Prints how well motions are told apart when everybody has the same body, and bounds it.
    #[test]
    #[ignore = "slow without optimisation; needs EDGEGAIT_DATA"]
    fn motion_is_measured_on_one_body() {
        let recorded = Walkers::of(on_one_body(recorded(&given(), Split::asked())), &[0]);
        let made = Walkers::of(on_one_body(made(MADE_PEOPLE)), &[0]);
        for (made_against_recorded, _) in told_apart(&made, &recorded) {
            assert!(made_against_recorded < 0.95, "{made_against_recorded}");
        }
    }
}
