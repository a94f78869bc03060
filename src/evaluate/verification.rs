//! Verification of a claimed identity: ROC, EER, AUC and TAR at a fixed FAR.
//!
//! A pair is accepted at a threshold t if its distance is at most t. FAR(t) is the share of
//! impostor pairs (two people) that are accepted, TAR(t) the share of genuine pairs (one person),
//! and FRR = 1 - TAR (ISO/IEC 19795-1). The curve has a point at t = -inf and at every distinct
//! distance; it is constant between them.

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// False accept rates at which [`Verification::tars`] reports.
pub(crate) const FARS: [f64; 4] = [1e-1, 1e-2, 1e-3, 1e-4];

/// The number of errors that must be observed for a rate to be known to about 30 % with 90 %
/// confidence: the "rule of 30" (Doddington et al., "The NIST speaker recognition evaluation",
/// Speech Communication 31, 2000).
const RULE_OF_30: f64 = 30.0;

/// The maximum number of points of [`Verification::roc`].
pub(crate) const MAX_ROC_POINTS: usize = 200;

/// The distances of the pairs of one subject, or of all subjects.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Pairs {
    /// Distances between samples of one person.
    pub genuine: Vec<f64>,
    /// Distances between samples of two people.
    pub impostor: Vec<f64>,
}

/// Genuine and impostor pairs, counted by distance.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Verification {
    /// Steps by rising threshold, each with the number of pairs accepted at it.
    steps: Vec<RocStep>,
    non_finite_genuine: u64,
    non_finite_impostor: u64,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct RocStep {
    threshold: f64,
    genuine: u64,
    impostor: u64,
}

/// The point where false accepts and false rejects are equally frequent.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Eer {
    /// The equal error rate, 0..1.
    pub rate: f64,
    /// The lowest distance that, as threshold, gives a FAR of at least the FRR.
    pub threshold: f64,
}

/// A point of the ROC, both rates 0..1.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct RocPoint {
    /// False accept rate.
    pub far: f64,
    /// True accept rate.
    pub tar: f64,
}

/// The true accept rate at a threshold that accepts at most a share `far` of the impostors.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TarAtFar {
    /// The false accept rate asked for.
    pub far: f64,
    /// The true accept rate, 0..1; none if there are too few impostors.
    pub tar: Option<f64>,
    /// The highest distance with a FAR of at most `far`; none if there are too few impostors, or if
    /// no distance has such a FAR.
    pub threshold: Option<f64>,
    /// Why there is no rate, or why it is unreliable.
    pub note: Option<String>,
}

impl Verification {
    /// Returns the curve of these distances. Those that are NaN or infinite are counted and left
    /// out.
    ///
    /// Takes 16 bytes per distance while sorting, and 24 bytes per distinct distance afterwards.
    #[must_use]
    pub(crate) fn from_distances(genuine: &[f64], impostor: &[f64]) -> Self {
        let (genuine, non_finite_genuine) = finite(genuine);
        let (impostor, non_finite_impostor) = finite(impostor);
        let mut pairs: Vec<(f64, bool)> = genuine
            .map(|distance| (distance, true))
            .chain(impostor.map(|distance| (distance, false)))
            .collect();
        pairs.par_sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        let same = pairs.chunk_by(|a, b| a.0 == b.0).map(|same| {
            let genuine = same.iter().filter(|(_, is_genuine)| *is_genuine).count() as u64;
            (same[0].0, genuine, same.len() as u64 - genuine)
        });
        Self {
            steps: accumulate(same),
            non_finite_genuine,
            non_finite_impostor,
        }
    }

    /// Returns the curve of counts: (distance, genuine pairs, impostor pairs) by rising distance.
    pub(super) fn of_counts(counts: impl Iterator<Item = (f64, u64, u64)>) -> Self {
        Self {
            steps: accumulate(counts),
            non_finite_genuine: 0,
            non_finite_impostor: 0,
        }
    }

    /// Returns the number of genuine pairs with a finite distance.
    #[must_use]
    pub(crate) fn genuine(&self) -> u64 {
        self.steps.last().map_or(0, |step| step.genuine)
    }

    /// Returns the number of impostor pairs with a finite distance.
    #[must_use]
    pub(crate) fn impostors(&self) -> u64 {
        self.steps.last().map_or(0, |step| step.impostor)
    }

    /// Returns the numbers of (genuine, impostor) pairs with a non-finite distance. No rate
    /// includes them.
    #[must_use]
    pub(crate) const fn non_finite(&self) -> (u64, u64) {
        (self.non_finite_genuine, self.non_finite_impostor)
    }

    /// Returns the equal error rate: at the first threshold where FAR >= FRR or, if they are not
    /// equal there, where straight lines from the previous point cross. None without pairs of both
    /// kinds.
    #[must_use]
    pub(crate) fn eer(&self) -> Option<Eer> {
        let mut before = RocPoint { far: 0.0, tar: 0.0 };
        let mut frr_before = 1.0;
        for step in &self.steps {
            let here = self.rates(step)?;
            // Not 1 - TAR, so that equal fractions are equal numbers.
            let frr = (self.genuine() - step.genuine) as f64 / self.genuine() as f64;
            if here.far >= frr {
                let (gap_before, gap) = (frr_before - before.far, here.far - frr);
                let rate = if gap == 0.0 {
                    frr
                } else {
                    before.far + (here.far - before.far) * gap_before / (gap_before + gap)
                };
                return Some(Eer {
                    rate,
                    threshold: step.threshold,
                });
            }
            (before, frr_before) = (here, frr);
        }
        None
    }

    /// Returns the area under the ROC: how often a genuine pair is nearer than an impostor pair,
    /// ties counted half (Mann and Whitney, 1947). None without pairs of both kinds.
    #[must_use]
    pub(crate) fn auc(&self) -> Option<f64> {
        let (mut twice_wins, mut before) = (0_u128, (0, 0));
        for step in &self.steps {
            let farther = u128::from(step.impostor - before.1);
            twice_wins += farther * u128::from(step.genuine + before.0);
            before = (step.genuine, step.impostor);
        }
        let pairs = u128::from(self.genuine()) * u128::from(self.impostors());
        (pairs > 0).then(|| twice_wins as f64 / (2 * pairs) as f64)
    }

    /// Returns the ROC from (0, 0) to (1, 1) with at most [`MAX_ROC_POINTS`] points. All of them
    /// are exact; points too close to the previous one are left out. Empty without pairs of both
    /// kinds.
    #[must_use]
    pub(crate) fn roc(&self) -> Vec<RocPoint> {
        let Some(all) = self
            .steps
            .iter()
            .map(|step| self.rates(step))
            .collect::<Option<Vec<_>>>()
        else {
            return Vec::new();
        };
        let Some((&last, inner)) = all.split_last() else {
            return Vec::new();
        };
        // FAR + TAR rises from 0 to 2.
        let least = if all.len() < MAX_ROC_POINTS {
            0.0
        } else {
            2.0 / (MAX_ROC_POINTS - 2) as f64
        };
        let mut kept = vec![RocPoint { far: 0.0, tar: 0.0 }];
        let mut moved = 0.0;
        for point in inner {
            if point.far + point.tar >= moved + least {
                kept.push(*point);
                moved = point.far + point.tar;
            }
        }
        kept.push(last);
        kept
    }

    /// Returns the true accept rate at each of [`FARS`]; empty without genuine pairs.
    #[must_use]
    pub(crate) fn tars(&self) -> Vec<TarAtFar> {
        FARS.iter().filter_map(|&far| self.tar_at(far)).collect()
    }

    /// Returns the true accept rate at the highest threshold with a FAR of at most `far`, without
    /// interpolation. A FAR below 1 / impostors cannot be observed, so there is no rate then; below
    /// 30 / impostors the rate has a note. None without genuine pairs.
    #[must_use]
    pub(crate) fn tar_at(&self, far: f64) -> Option<TarAtFar> {
        if self.genuine() == 0 {
            return None;
        }
        let impostors = self.impostors();
        let shortest = |errors: f64| (errors / far).round();
        if far < 1.0 / impostors as f64 {
            return Some(TarAtFar {
                far,
                tar: None,
                threshold: None,
                note: Some(format!(
                    "needs at least {} impostor pairs, found {impostors}",
                    shortest(1.0)
                )),
            });
        }
        let step = self.step_within(far);
        Some(TarAtFar {
            far,
            tar: Some(step.map_or(0.0, |step| step.genuine as f64 / self.genuine() as f64)),
            threshold: step.map(|step| step.threshold),
            note: (far < RULE_OF_30 / impostors as f64).then(|| {
                format!(
                    "rough: based on fewer than 30 false accepts (rule of 30: expected {} impostor pairs, found {impostors})",
                    shortest(RULE_OF_30)
                )
            }),
        })
    }

    /// Returns the highest step with a FAR of at most `far`.
    fn step_within(&self, far: f64) -> Option<&RocStep> {
        let impostors = self.impostors() as f64;
        let within = self
            .steps
            .partition_point(|step| step.impostor as f64 / impostors <= far);
        self.steps[..within].last()
    }

    /// Returns the rates at a step; none without pairs of both kinds.
    fn rates(&self, step: &RocStep) -> Option<RocPoint> {
        let (genuine, impostors) = (self.genuine(), self.impostors());
        (genuine > 0 && impostors > 0).then(|| RocPoint {
            far: step.impostor as f64 / impostors as f64,
            tar: step.genuine as f64 / genuine as f64,
        })
    }
}

/// Returns the finite distances, with -0 as 0, and the number of others.
pub(super) fn finite(distances: &[f64]) -> (impl Iterator<Item = f64>, u64) {
    let is_finite = |distance: &&f64| distance.is_finite();
    let others = distances.len() - distances.iter().filter(is_finite).count();
    let finite = distances
        .iter()
        .filter(is_finite)
        .map(|distance| distance + 0.0);
    (finite, others as u64)
}

fn accumulate(counts: impl Iterator<Item = (f64, u64, u64)>) -> Vec<RocStep> {
    let mut sum = (0, 0);
    counts
        .map(|(threshold, genuine, impostor)| {
            sum = (sum.0 + genuine, sum.1 + impostor);
            RocStep {
                threshold,
                genuine: sum.0,
                impostor: sum.1,
            }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluate::testing::{E1, E1_GALLERY, E1_PROBES};
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    fn e1() -> Verification {
        let (mut genuine, mut impostor) = (Vec::new(), Vec::new());
        for (row, person) in E1.iter().zip(E1_PROBES) {
            for (&distance, mate) in row.iter().zip(E1_GALLERY) {
                let pairs = if mate == person {
                    &mut genuine
                } else {
                    &mut impostor
                };
                pairs.push(distance);
            }
        }
        Verification::from_distances(&genuine, &impostor)
    }

    #[test]
    fn the_reference_matrix_has_its_worked_rates() {
        let e1 = e1();
        assert_eq!((e1.genuine(), e1.impostors()), (6, 12));
        assert_eq!(e1.auc(), Some(0.9375));
        let eer = e1.eer().unwrap();
        assert_eq!((eer.rate, eer.threshold), (1.0 / 6.0, 0.40));
        let none = e1.step_within(0.0).unwrap();
        assert_eq!((none.genuine, none.threshold), (3, 0.25));
        let tar = e1.tar_at(1.0 / 12.0).unwrap();
        assert!((tar.tar.unwrap() - 0.6667).abs() < 5e-5);
        assert!(tar.note.unwrap().starts_with("rough"));
    }

    #[test]
    fn a_far_below_one_in_the_impostors_is_refused() {
        let tars = e1().tars();
        assert!(tars[0].tar.is_some());
        assert_eq!((tars[1].tar, tars[1].threshold), (None, None));
        assert_eq!(
            tars[3].note.as_deref(),
            Some("needs at least 10000 impostor pairs, found 12")
        );
    }

    #[test]
    fn thirty_false_accepts_are_enough_for_no_note() {
        let impostor: Vec<f64> = (0..3000).map(f64::from).collect();
        let tars = Verification::from_distances(&[-1.0, 29.0, 30.0], &impostor).tars();
        // FAR 0.01 is 30 of 3000, so the threshold is the 30th distance, 29.
        assert_eq!(
            (tars[1].tar, tars[1].threshold, &tars[1].note),
            (Some(2.0 / 3.0), Some(29.0), &None)
        );
        assert_eq!(tars[2].threshold, Some(2.0));
        assert!(
            tars[2]
                .note
                .as_ref()
                .unwrap()
                .contains("30000 impostor pairs")
        );
        assert_eq!(tars[3].tar, None);
    }

    #[test]
    fn all_equal_distances_have_an_eer_of_one_half() {
        let equal = Verification::from_distances(&[2.0; 3], &[2.0; 50]);
        assert_eq!(
            equal.eer(),
            Some(Eer {
                rate: 0.5,
                threshold: 2.0
            })
        );
        assert_eq!(equal.auc(), Some(0.5));
        let corners = [
            RocPoint { far: 0.0, tar: 0.0 },
            RocPoint { far: 1.0, tar: 1.0 },
        ];
        assert_eq!(equal.roc(), corners);
        let tar = equal.tar_at(0.1).unwrap();
        assert_eq!((tar.tar, tar.threshold), (Some(0.0), None));
    }

    #[test]
    fn pairs_of_one_kind_have_no_curve() {
        for (genuine, impostor) in [(&[0.5][..], &[][..]), (&[], &[0.5]), (&[], &[])] {
            let one = Verification::from_distances(genuine, impostor);
            assert_eq!((one.eer(), one.auc(), one.roc()), (None, None, vec![]));
            assert!(one.tars().iter().all(|tar| tar.tar.is_none()));
        }
        assert!(Verification::from_distances(&[], &[0.5]).tars().is_empty());
        let note = Verification::from_distances(&[0.5], &[]).tars()[0]
            .note
            .clone();
        assert_eq!(note.unwrap(), "needs at least 10 impostor pairs, found 0");
    }

    #[test]
    fn distances_that_are_not_finite_are_counted_and_in_no_rate() {
        let bad = Verification::from_distances(
            &[0.0, f64::NAN],
            &[f64::INFINITY, 1.0, f64::NEG_INFINITY],
        );
        assert_eq!(bad.non_finite(), (1, 2));
        assert_eq!((bad.genuine(), bad.impostors()), (1, 1));
        assert_eq!((bad.auc(), bad.eer().unwrap().rate), (Some(1.0), 0.0));
    }

    #[test]
    fn zero_and_minus_zero_are_one_distance() {
        assert_eq!(
            Verification::from_distances(&[0.0], &[-0.0]).auc(),
            Some(0.5)
        );
    }

    /// The oracle scans every threshold and counts, and compares all pairs for the AUC.
    #[test]
    fn rates_are_those_of_counting_at_every_threshold() {
        let mut random = ChaCha8Rng::seed_from_u64(66);
        for _ in 0..600 {
            let mut draw = |shift: i32| -> Vec<f64> {
                let n = random.random_range(1..14);
                (0..n)
                    .map(|_| f64::from(random.random_range(0..9) + shift) / 4.0)
                    .collect()
            };
            let (genuine, impostor) = (draw(0), draw(1));
            let curve = Verification::from_distances(&genuine, &impostor);

            let (mut wins, mut pairs) = (0.0, 0.0);
            for g in &genuine {
                for i in &impostor {
                    wins += if g < i {
                        1.0
                    } else if g > i {
                        0.0
                    } else {
                        0.5
                    };
                    pairs += 1.0;
                }
            }
            assert!((curve.auc().unwrap() - wins / pairs).abs() < 1e-12);

            // Thresholds in steps of 1/8 cover every distance and every gap between two.
            let far = |t: f64| {
                impostor.iter().filter(|d| **d <= t).count() as f64 / impostor.len() as f64
            };
            let frr =
                |t: f64| genuine.iter().filter(|d| **d > t).count() as f64 / genuine.len() as f64;
            let thresholds: Vec<f64> = (-1..30).map(|k| f64::from(k) / 8.0).collect();
            let cross = thresholds.iter().position(|&t| far(t) >= frr(t)).unwrap();
            let (t, s) = (thresholds[cross], thresholds[cross - 1]);
            // The segments (0, FAR(s))-(1, FAR(t)) and (0, FRR(s))-(1, FRR(t)) meet at x.
            let x = (frr(s) - far(s)) / ((far(t) - far(s)) + (frr(s) - frr(t)));
            let expected = frr(s) + x * (frr(t) - frr(s));
            let eer = curve.eer().unwrap();
            assert!((eer.rate - expected).abs() < 1e-12, "{eer:?} {expected}");
            assert_eq!(eer.threshold, t);

            for asked in [0.1, 0.25, 0.5, 1.0] {
                let tar = curve.tar_at(asked).unwrap();
                let best = thresholds
                    .iter()
                    .filter(|t| far(**t) <= asked)
                    .map(|t| 1.0 - frr(*t))
                    .fold(0.0, f64::max);
                match tar.tar {
                    Some(tar) => assert!((tar - best).abs() < 1e-12),
                    None => assert!(asked * (impostor.len() as f64) < 1.0),
                }
            }
        }
    }

    #[test]
    fn a_thinned_roc_keeps_its_corners_and_lies_on_the_curve() {
        let mut random = ChaCha8Rng::seed_from_u64(67);
        let genuine: Vec<f64> = (0..4000).map(|_| random.random_range(0.0..2.0)).collect();
        let impostor: Vec<f64> = (0..90_000).map(|_| random.random_range(1.0..4.0)).collect();
        let curve = Verification::from_distances(&genuine, &impostor);
        let roc = curve.roc();
        assert!((150..=MAX_ROC_POINTS).contains(&roc.len()), "{}", roc.len());
        assert_eq!(roc[0], RocPoint { far: 0.0, tar: 0.0 });
        assert_eq!(roc[roc.len() - 1], RocPoint { far: 1.0, tar: 1.0 });
        assert!(roc.is_sorted_by(|a, b| a.far <= b.far && a.tar <= b.tar));
        // Half of the genuine pairs are nearer than any impostor: TAR = 1/2 + 3/2 FAR up to 1.
        assert!(
            roc.iter()
                .all(|p| p.far == 0.0 || (p.tar - (0.5 + 1.5 * p.far).min(1.0)).abs() < 0.03)
        );
    }
}
