//! Leave one take out: every take is looked for among all the others.
//!
//! With few takes a person, none can be kept back as a gallery. Each GEI is a probe in turn, the
//! gallery are those of all other takes at the same viewpoint, and the nearest embedding decides.
//! Cycles of the probe's own take are left out, because they are the same minute's walk.

use super::rank::{Outcome, Tally};
use crate::error::{Error, Result};
use rayon::prelude::*;

/// What a GEI shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shown {
    /// Number of the person.
    pub person: usize,
    /// Number of the take, over all people.
    pub take: usize,
}

/// The outcome of each GEI as a probe, from embeddings of `width` numbers at one viewpoint; none
/// of a person without another take. Of equally near ones the first counts.
///
/// # Errors
/// If there are not `width` numbers for each GEI.
pub fn leave_one_take_out(
    embeddings: &[f32],
    width: usize,
    shown: &[Shown],
) -> Result<Vec<Option<Outcome>>> {
    if width == 0 || width.checked_mul(shown.len()) != Some(embeddings.len()) {
        return Err(Error::Failed(format!(
            "leave one take out: expected {} embeddings of {width} numbers, found {} numbers",
            shown.len(),
            embeddings.len()
        )));
    }
    let outcome = |(probe, one): (&[f32], &Shown)| {
        let others = || {
            let all = embeddings.chunks_exact(width).zip(shown);
            all.filter(|(_, other)| other.take != one.take)
        };
        if !others().any(|(_, other)| other.person == one.person) {
            return None;
        }
        if probe.iter().any(|number| !number.is_finite()) {
            return Some(Outcome::NonFinite);
        }
        let distance = |known: &[f32]| -> f64 {
            let pairs = known.iter().zip(probe);
            pairs
                .map(|(&known, &found)| (f64::from(known) - f64::from(found)).powi(2))
                .sum()
        };
        let nearest = others()
            .map(|(known, other)| (distance(known), other.person))
            .min_by(|a, b| a.0.total_cmp(&b.0));
        Some(match nearest {
            Some((_, person)) if person == one.person => Outcome::Hit,
            _ => Outcome::Miss,
        })
    };
    let probes: Vec<&[f32]> = embeddings.chunks_exact(width).collect();
    let probes = probes.into_par_iter().zip(shown);
    Ok(probes.map(outcome).collect())
}

/// The outcomes counted: of all, and of each of so many people.
#[must_use]
pub fn tallies(
    outcomes: &[Option<Outcome>],
    shown: &[Shown],
    people: usize,
) -> (Tally, Vec<Tally>) {
    let mut by_person = vec![Tally::default(); people];
    for (outcome, one) in outcomes.iter().zip(shown) {
        if let (Some(outcome), Some(tally)) = (outcome, by_person.get_mut(one.person)) {
            tally.add(*outcome);
        }
    }
    (by_person.iter().copied().sum(), by_person)
}

#[cfg(test)]
mod tests {
    use super::*;

    const fn of(person: usize, take: usize) -> Shown {
        Shown { person, take }
    }

    #[test]
    fn a_cycle_of_the_same_take_cannot_vouch_for_the_probe() {
        // On a line: two cycles of take 0 next to each other, their person's other take far off,
        // and a stranger between.
        let shown = [of(0, 0), of(0, 0), of(1, 1), of(1, 2), of(0, 3)];
        let line = [0.0, 0.1, 1.0, 1.5, 9.0];
        let outcomes = leave_one_take_out(&line, 1, &shown).expect("five numbers");
        let expected = [
            Outcome::Miss,
            Outcome::Miss,
            Outcome::Hit,
            Outcome::Hit,
            Outcome::Miss,
        ];
        assert_eq!(outcomes, expected.map(Some));
        let (all, people) = tallies(&outcomes, &shown, 2);
        assert_eq!((all.hits, all.probes), (2, 5));
        assert_eq!((people[0].hits, people[1].hits), (0, 2));
    }

    #[test]
    fn a_person_with_one_take_is_a_stranger_to_others_and_no_probe() {
        let shown = [of(0, 0), of(1, 1), of(1, 2)];
        let outcomes = leave_one_take_out(&[0.0, 0.4, 1.0], 1, &shown).expect("three numbers");
        assert_eq!(outcomes, [None, Some(Outcome::Miss), Some(Outcome::Hit)]);
    }

    #[test]
    fn numbers_that_are_not_finite_never_hit() {
        let shown = [of(0, 0), of(0, 1), of(1, 2), of(1, 3)];
        let line = [f32::NAN, 1.0, 2.0, 3.0];
        let outcomes = leave_one_take_out(&line, 1, &shown).expect("four numbers");
        assert_eq!(outcomes[0], Some(Outcome::NonFinite));
        // NaN is farther than anything.
        assert_eq!(outcomes[1], Some(Outcome::Miss));
        assert!(leave_one_take_out(&line, 3, &shown).is_err());
    }
}
