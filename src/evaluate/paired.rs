//! Do two recognizers differ? Rank-1 on the same probes, person by person.
//!
//! Two intervals that overlap do not say that two recognizers are alike: people who are hard for one
//! are hard for the other. What counts is the difference, drawn over people who answer to both
//! (the paired bootstrap; Efron and Tibshirani, "An Introduction to the Bootstrap", 1993, chapter 8).

use std::ops::AddAssign;

use serde::{Deserialize, Serialize};

use super::bootstrap::interval_95;
use super::rank::Tally;
use super::results::{ProbeSetResult, RecognizerResult};
use super::wilson::Interval;

/// Rank-1 on the probes of one person.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PersonResult {
    /// The person's name.
    pub person: String,
    /// Probes of this person.
    pub probes: u64,
    /// Those at Rank-1.
    pub hits: u64,
}

impl PersonResult {
    /// One entry for each person who is looked for, in the order of `names`.
    pub(super) fn list(names: &[String], tallies: &[Tally]) -> Vec<Self> {
        let probed = names.iter().zip(tallies).filter(|(_, one)| one.probes > 0);
        let person = |(name, tally): (&String, &Tally)| Self {
            person: name.clone(),
            probes: tally.probes,
            hits: tally.hits,
        };
        probed.map(person).collect()
    }
}

/// How far Rank-1 of two recognizers is apart on the same probes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PairedResult {
    /// The better one, or of equals the one that is listed first.
    pub recognizer: String,
    /// The other one.
    pub other: String,
    /// The set of probes; none where it is what leads, as [`RecognizerResult::of_probe_sets`] says.
    pub probe_set: Option<String>,
    /// People who are looked for.
    pub people: u64,
    /// Rank-1 of the one less Rank-1 of the other, -1..1.
    pub difference: f64,
    /// Lower end of the 95 % interval of the difference that draws people; none of fewer than two.
    pub low: Option<f64>,
    /// Upper end.
    pub high: Option<f64>,
}

impl PairedResult {
    /// Whether 0 is outside the interval; none without an interval.
    #[must_use]
    pub fn differs(&self) -> Option<bool> {
        let (low, high) = self.low.zip(self.high)?;
        Some(low > 0.0 || high < 0.0)
    }
}

/// Hits of two recognizers among the same probes.
#[derive(Clone)]
struct Pair {
    probes: u64,
    hits: [u64; 2],
}

impl AddAssign<&Self> for Pair {
    fn add_assign(&mut self, more: &Self) {
        self.probes += more.probes;
        for (sum, hits) in self.hits.iter_mut().zip(more.hits) {
            *sum += hits;
        }
    }
}

/// How far recognizers are apart, each from each, the best from the others first; on what leads and
/// on each set of probes, as far as their probes are the same.
///
/// The best is chosen by these very probes: that it is beyond others is said a little too easily.
/// `seed` draws people.
pub(super) fn each_from_each(results: &[RecognizerResult], seed: u64) -> Vec<PairedResult> {
    let mut ranked: Vec<&RecognizerResult> = results.iter().filter(|one| one.probes > 0).collect();
    // Of equals the first stays first.
    ranked.sort_by(|a, b| b.rank1.total_cmp(&a.rank1));
    let of = |(at, one): (usize, &&RecognizerResult)| {
        let others = ranked[at + 1..].iter();
        others
            .flat_map(|other| between(one, other, seed))
            .collect::<Vec<_>>()
    };
    ranked.iter().enumerate().flat_map(of).collect()
}

/// How far one recognizer is from another, on what leads and on each set of probes; of these
/// only what both were asked in the same way.
#[must_use]
pub(crate) fn between(
    one: &RecognizerResult,
    other: &RecognizerResult,
    seed: u64,
) -> Vec<PairedResult> {
    let named = |probe_set, people: [&[PersonResult]; 2]| {
        let (difference, drawn) = difference(people, seed)?;
        Some(PairedResult {
            recognizer: one.name.clone(),
            other: other.name.clone(),
            probe_set,
            people: people[0].len() as u64,
            difference,
            low: drawn.map(|drawn| drawn.low),
            high: drawn.map(|drawn| drawn.high),
        })
    };
    let is_led_alike = one.of_probe_sets == other.of_probe_sets;
    let leading = is_led_alike.then(|| named(None, [&one.by_person, &other.by_person]));
    let of_set = |set: &ProbeSetResult| {
        let mut others = other.probe_sets.iter();
        let same = others.find(|its| its.name == set.name)?;
        named(Some(set.name.clone()), [&set.by_person, &same.by_person])
    };
    // One set is what leads, once more.
    let sets = if one.probe_sets.len() > 1 {
        &one.probe_sets[..]
    } else {
        &[]
    };
    let sets = sets.iter().filter_map(of_set);
    leading.flatten().into_iter().chain(sets).collect()
}

/// A number and its interval over people; none of fewer than two.
type Drawn = (f64, Option<Interval>);

/// What is between two rates of hits on the same probes.
pub(crate) struct Rates {
    /// The one divided by the other; 1 where both are 0.
    pub ratio: Drawn,
    /// The one less the other.
    pub difference: Drawn,
}

/// What is between two rates, with intervals over people; none if the probes are not the same.
pub(crate) fn paired_rates(both: [&[PersonResult]; 2], seed: u64) -> Option<Rates> {
    let ratio = |sum: &Pair| {
        let [a, b] = sum.hits.map(|hits| hits as f64);
        (sum.probes > 0).then_some(if a == b { 1.0 } else { a / b })
    };
    Some(Rates {
        ratio: drawn(both, seed, ratio)?,
        difference: difference(both, seed)?,
    })
}

/// The difference and its interval over people; none if the probes are not the same.
fn difference(both: [&[PersonResult]; 2], seed: u64) -> Option<Drawn> {
    drawn(both, seed, |sum| {
        let [a, b] = sum.hits.map(|hits| hits as f64);
        (sum.probes > 0).then(|| (a - b) / sum.probes as f64)
    })
}

fn drawn(
    [one, other]: [&[PersonResult]; 2],
    seed: u64,
    statistic: impl Fn(&Pair) -> Option<f64>,
) -> Option<Drawn> {
    let is_same =
        |(a, b): (&PersonResult, &PersonResult)| (&a.person, a.probes) == (&b.person, b.probes);
    if one.len() != other.len() || !one.iter().zip(other).all(is_same) {
        return None;
    }
    let both = one.iter().zip(other);
    let pairs: Vec<Pair> = both
        .map(|(a, b)| Pair {
            probes: a.probes,
            hits: [a.hits, b.hits],
        })
        .collect();
    let (first, more) = pairs.split_first()?;
    let mut all = first.clone();
    more.iter().for_each(|pair| all += pair);
    Some((statistic(&all)?, interval_95(&pairs, seed, statistic)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluate::results::tests::{result_of, set};

    /// Ten people, of each `probes` and `hits(number)`.
    fn people(probes: u64, hits: impl Fn(u64) -> u64) -> Vec<PersonResult> {
        let person = |number| PersonResult {
            person: format!("p{number}"),
            probes,
            hits: hits(number),
        };
        (0..10).map(person).collect()
    }

    fn result(name: &str, by_person: Vec<PersonResult>) -> RecognizerResult {
        let hits = by_person.iter().map(|one| one.hits).sum();
        let probes = by_person.iter().map(|one| one.probes).sum();
        RecognizerResult {
            name: name.into(),
            by_person,
            ..result_of(&[(90.0, 0.0, hits, probes)])
        }
    }

    /// People differ from 0 to 90 %, so that each interval is wide; the other one misses one in ten
    /// more of every person, so that the difference has no doubt.
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
    fn the_best_stands_first_and_of_equals_the_one_listed_first() {
        let of = |name, hits| result(name, people(10, move |_| hits));
        let results = [of("a", 3), of("b", 5), of("c", 5)];
        let names = each_from_each(&results, 1)
            .into_iter()
            .map(|one| (one.recognizer, one.other));
        let expected = [("b", "c"), ("b", "a"), ("c", "a")];
        assert!(names.eq(expected.map(|(one, other)| (one.to_owned(), other.to_owned()))));
    }

    /// Of one probe each, the sum of ten draws from two who lose, three who win and five who tie:
    /// its distribution is a convolution, whose quantiles the oracle adds up.
    #[test]
    fn the_interval_is_that_of_the_exact_distribution() {
        let one = people(1, |number| u64::from(number < 3));
        let other = people(1, |number| u64::from((3..5).contains(&number)));
        let (found, drawn) = difference([&one, &other], 4).unwrap();
        assert!((found - 0.1).abs() < 1e-12);
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
        let drawn = drawn.unwrap();
        // A draw of 2,000 may be a step beside: 0.1.
        assert!((drawn.low - quantile(0.025)).abs() < 0.11, "{drawn:?}");
        assert!((drawn.high - quantile(0.975)).abs() < 0.11, "{drawn:?}");
        assert!(drawn.low < 0.0 && drawn.high > 0.0);
    }

    #[test]
    fn a_ratio_that_all_people_share_is_sure() {
        let [one, other] = [people(10, |_| 9), people(10, |_| 6)];
        let rates = paired_rates([&one, &other], 1).unwrap();
        let (ratio, drawn) = rates.ratio;
        let ends = drawn.map(|drawn| (drawn.low, drawn.high));
        assert_eq!((ratio, ends), (1.5, Some((1.5, 1.5))));
        let nothing = people(10, |_| 0);
        assert_eq!(paired_rates([&nothing, &nothing], 1).unwrap().ratio.0, 1.0);
        assert!(paired_rates([&one, &people(9, |_| 9)], 1).is_none());
    }

    #[test]
    fn the_same_answers_do_not_differ() {
        let same = people(7, |number| number % 7);
        let (difference, drawn) = difference([&same, &same], 2).unwrap();
        assert_eq!(
            (difference, drawn.unwrap().low, drawn.unwrap().high),
            (0.0, 0.0, 0.0)
        );
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
            .map(|one| (one.probe_set.as_deref(), (one.difference * 10.0).round()))
            .collect();
        assert_eq!(said, [(None, 0.0), (Some("NM"), 0.0), (Some("BG"), -4.0)]);
    }
}
