use super::*;
use crate::dataset::sequences::ViewLabel;
use crate::evaluate::results::tests::{result_of, set};
use std::collections::BTreeMap;

/// Returns ten people, each with `probes` probes and `hits(number)` hits.
fn people(probes: u64, hits: impl Fn(u64) -> u64) -> Vec<PersonResult> {
    let person = |number| PersonResult {
        person: format!("p{number}"),
        probes,
        hits: hits(number),
        taken_for: Vec::new(),
    };
    (0..10).map(person).collect()
}

fn result(name: &str, by_person: Vec<PersonResult>) -> RecognizerResult {
    let hits = by_person.iter().map(|tested| tested.hits).sum();
    let probes = by_person.iter().map(|tested| tested.probes).sum();
    RecognizerResult {
        name: name.into(),
        by_person,
        ..result_of(&[(90.0, 0.0, hits, probes)])
    }
}

/// People differ from 0 to 90 %, so that each interval is wide. The worse recognizer misses one
/// probe in ten more for every person, so that the difference is certain.
#[test]
fn a_difference_that_all_people_share_is_sure_however_people_differ() {
    let results = [
        result("worse", people(100, |number| number * 10)),
        result("better", people(100, |number| number * 10 + 10)),
    ];
    let [found] = &each_from_each(&results, 1)[..] else {
        panic!("one pair");
    };
    assert_eq!((&*found.recognizer, &*found.other), ("better", "worse"));
    assert!((found.difference - 0.1).abs() < 1e-12);
    assert_eq!(
        (found.low, found.high),
        (Some(found.difference), Some(found.difference))
    );
    assert_eq!((found.differs(), found.people), (Some(true), 10));
}

#[test]
fn whom_people_are_taken_for_comes_by_how_often() {
    let names = ["a", "b", "c"].map(String::from);
    let tally = |hits, probes| Tally {
        hits,
        probes,
        ..Tally::default()
    };
    let taken = |all: &[(&str, u64)]| {
        all.iter()
            .map(|(name, count)| ((*name).to_owned(), *count))
            .collect()
    };
    let confused = vec![
        taken(&[("b", 1), ("c", 4), ("d", 1), ("e", 2)]),
        BTreeMap::new(),
    ];
    let found = PersonResult::list(&names, &[tally(2, 10), tally(3, 3), tally(0, 0)], &confused);
    let said: Vec<_> = found
        .iter()
        .map(|tested| {
            (
                tested.person.as_str(),
                tested
                    .taken_for
                    .iter()
                    .map(|tested| (tested.person.as_str(), tested.probes))
                    .collect::<Vec<_>>(),
            )
        })
        .collect();
    assert_eq!(
        said,
        [("a", vec![("c", 4), ("e", 2), ("b", 1)]), ("b", vec![])]
    );
}

#[test]
fn viewpoints_are_compared_each_for_itself() {
    let view = |azimuth| ViewLabel::Angles(azimuth, 0.0);
    let tally = |hits| Tally {
        hits,
        probes: 4,
        ..Tally::default()
    };
    let with = |name: &str, hits: [[u64; 3]; 3]| {
        let hits_by_view = HitsByView {
            views: [0.0, 45.0, 90.0].map(view).to_vec(),
            tallies: hits.map(|people| people.map(tally).to_vec()).to_vec(),
        };
        RecognizerResult {
            hits_by_view,
            ..result(name, people(4, |number| number % 4))
        }
    };
    // Better by one hit of every person, equal, and worse.
    let one = with("a", [[2, 3, 4], [1, 2, 3], [0, 1, 2]]);
    let other = with("b", [[1, 2, 3], [1, 2, 3], [1, 2, 3]]);
    let found = each_from_each(&[one.clone(), other], 1);
    assert_eq!(found[0].viewpoints_beyond_and_behind(), (1, 1));
    let at = |number: usize| {
        let found = &found[0].by_viewpoint[number];
        (found.azimuth_deg, found.difference, found.low, found.high)
    };
    assert_eq!(at(0), (Some(0.0), 0.25, Some(0.25), Some(0.25)));
    assert_eq!(at(1), (Some(45.0), 0.0, Some(0.0), Some(0.0)));
    assert_eq!(at(2), (Some(90.0), -0.25, Some(-0.25), Some(-0.25)));
    let mut elsewhere = with("c", [[0; 3]; 3]);
    elsewhere.hits_by_view.views[1] = view(50.0);
    let found = each_from_each(&[one, elsewhere], 1);
    assert_eq!(found[0].by_viewpoint, []);
}

#[test]
fn the_best_stands_first_and_of_equals_the_one_listed_first() {
    let of = |name, hits| result(name, people(10, move |_| hits));
    let results = [of("a", 3), of("b", 5), of("c", 5)];
    let names = each_from_each(&results, 1)
        .into_iter()
        .map(|tested| (tested.recognizer, tested.other));
    let expected = [("b", "c"), ("b", "a"), ("c", "a")];
    assert!(names.eq(expected.map(|(one, other)| (one.to_owned(), other.to_owned()))));
}

/// With one probe each, the sum of ten draws from two people who lose, three who win and five who
/// tie. Its distribution is a convolution, from which the oracle computes the quantiles.
#[test]
fn the_interval_is_that_of_the_exact_distribution() {
    let one = people(1, |number| u64::from(number < 3));
    let other = people(1, |number| u64::from((3..5).contains(&number)));
    let PairedEstimate { value, interval } = difference([&one, &other], 4).unwrap();
    assert!((value - 0.1).abs() < 1e-12);
    // [sum + 10]
    let mut chances = vec![0.0; 21];
    chances[10] = 1.0;
    for _ in 0..10 {
        let mut next = vec![0.0; 21];
        for (at, chance) in chances
            .iter()
            .enumerate()
            .filter(|(_, chance)| **chance > 0.0)
        {
            next[at - 1] += chance * 0.2;
            next[at] += chance * 0.5;
            next[at + 1] += chance * 0.3;
        }
        chances = next;
    }
    let quantile = |share: f64| {
        let mut sum = 0.0;
        let at = chances.iter().position(|chance| {
            sum += chance;
            sum >= share
        });
        (at.unwrap() as f64 - 10.0) / 10.0
    };
    let drawn = interval.unwrap();
    // With 2,000 resamples a quantile may be one step off: 0.1.
    assert!((drawn.low - quantile(0.025)).abs() < 0.11, "{drawn:?}");
    assert!((drawn.high - quantile(0.975)).abs() < 0.11, "{drawn:?}");
    assert!(drawn.low < 0.0 && drawn.high > 0.0);
}

#[test]
fn a_ratio_that_all_people_share_is_sure() {
    let [one, other] = [people(10, |_| 9), people(10, |_| 6)];
    let rates = paired_rates([&one, &other], 1).unwrap();
    let PairedEstimate { value, interval } = rates.ratio;
    let ends = interval.map(|interval| (interval.low, interval.high));
    assert_eq!((value, ends), (1.5, Some((1.5, 1.5))));
    let nothing = people(10, |_| 0);
    assert_eq!(
        paired_rates([&nothing, &nothing], 1).unwrap().ratio.value,
        1.0
    );
    assert!(paired_rates([&one, &people(9, |_| 9)], 1).is_none());
}

#[test]
fn the_same_answers_do_not_differ() {
    let same = people(7, |number| number % 7);
    let PairedEstimate { value, interval } = difference([&same, &same], 2).unwrap();
    let interval = interval.unwrap();
    assert_eq!((value, interval.low, interval.high), (0.0, 0.0, 0.0));
}

#[test]
fn other_probes_are_not_compared() {
    let hits = |number| number;
    let mut renamed = people(20, hits);
    renamed[3].person = "somebody".into();
    let others = [
        people(21, hits),
        renamed,
        people(20, hits)[1..].to_vec(),
        Vec::new(),
    ];
    for other in others {
        assert_eq!(difference([&people(20, hits), &other], 1), None);
    }
    assert_eq!(difference([&[], &[]], 1), None);
    let mut led_otherwise = result("b", people(20, hits));
    led_otherwise.of_probe_sets = vec!["BG".into()];
    let results = [result("a", people(20, hits)), led_otherwise];
    assert_eq!(each_from_each(&results, 1), Vec::new());
    assert_eq!(each_from_each(&[], 1), Vec::new());
}

#[test]
fn each_set_of_probes_is_compared_where_there_are_several() {
    let with_sets = |name: &str, bg: u64| {
        let set_of = |name, by_person| ProbeSetResult {
            by_person,
            ..set(name, name == "NM", 0)
        };
        RecognizerResult {
            of_probe_sets: vec!["NM".into()],
            probe_sets: vec![
                set_of("NM", people(10, |_| 5)),
                set_of("BG", people(10, |_| bg)),
            ],
            ..result(name, people(10, |_| 5))
        }
    };
    let found = between(&with_sets("a", 2), &with_sets("b", 6), 1);
    let said: Vec<_> = found
        .iter()
        .map(|tested| {
            (
                tested.probe_set.as_deref(),
                (tested.difference * 10.0).round(),
            )
        })
        .collect();
    assert_eq!(said, [(None, 0.0), (Some("NM"), 0.0), (Some("BG"), -4.0)]);
}
