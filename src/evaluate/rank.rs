//! Rank-1: is the best match the right person?

use ndarray::ArrayView2;

use super::wilson::{Interval, wilson_95};
use crate::error::{Error, Result};

/// What became of one probe.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// The best match is the right person.
    Hit,
    /// It is another.
    Miss,
    /// The recognizer gave a number that is not finite: a miss, counted apart.
    NonFinite,
}

impl Outcome {
    const fn of(is_right: bool) -> Self {
        if is_right { Self::Hit } else { Self::Miss }
    }
}

/// Outcomes counted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// All probes.
    pub probes: u64,
    /// The hits among them.
    pub hits: u64,
    /// The misses among them whose output was not finite.
    pub non_finite: u64,
}

impl Tally {
    /// Counts one more probe.
    pub const fn add(&mut self, outcome: Outcome) {
        self.probes += 1;
        match outcome {
            Outcome::Hit => self.hits += 1,
            Outcome::Miss => {}
            Outcome::NonFinite => self.non_finite += 1,
        }
    }

    /// The rate of hits, 0..1; none without probes.
    #[must_use]
    pub fn rank1(&self) -> Option<f64> {
        (self.probes > 0).then(|| self.hits as f64 / self.probes as f64)
    }

    /// Wilson's 95 % interval of the rate.
    #[must_use]
    pub fn interval(&self) -> Interval {
        wilson_95(self.hits, self.probes)
    }
}

impl std::ops::AddAssign for Tally {
    fn add_assign(&mut self, other: Self) {
        self.probes += other.probes;
        self.hits += other.hits;
        self.non_finite += other.non_finite;
    }
}

impl std::ops::AddAssign<&Self> for Tally {
    fn add_assign(&mut self, other: &Self) {
        *self += *other;
    }
}

impl std::iter::Sum for Tally {
    fn sum<I: Iterator<Item = Self>>(tallies: I) -> Self {
        let mut sum = Self::default();
        for tally in tallies {
            sum += tally;
        }
        sum
    }
}

impl FromIterator<Outcome> for Tally {
    fn from_iter<I: IntoIterator<Item = Outcome>>(outcomes: I) -> Self {
        let mut tally = Self::default();
        for outcome in outcomes {
            tally.add(outcome);
        }
        tally
    }
}

/// Closed set by class score: a hit if class `truth` has the highest score.
///
/// Of equal highest scores the lowest index wins, so that a recognizer that
/// answers the same to everything hits one class only. A row with a number that
/// is not finite is [`Outcome::NonFinite`]; a `truth` beyond the row is a miss.
#[must_use]
pub fn closed_set(scores: &[f32], truth: usize) -> Outcome {
    if scores.iter().any(|score| !score.is_finite()) {
        return Outcome::NonFinite;
    }
    let mut best: Option<(usize, f32)> = None;
    for (class, &score) in scores.iter().enumerate() {
        if best.is_none_or(|(_, highest)| score > highest) {
            best = Some((class, score));
        }
    }
    Outcome::of(best.is_some_and(|(class, _)| class == truth))
}

/// The embeddings of known people that probes are compared with.
#[derive(Clone, Debug)]
pub struct Gallery {
    embeddings: Vec<f32>,
    width: usize,
    labels: Vec<usize>,
}

impl Gallery {
    /// A gallery of `labels.len()` embeddings of `width` numbers each, one after
    /// the other.
    ///
    /// # Errors
    ///
    /// If it is empty, if the lengths disagree, or if a number is not finite.
    pub fn new(embeddings: Vec<f32>, width: usize, labels: Vec<usize>) -> Result<Self> {
        if labels.is_empty() || width == 0 {
            return Err(Error::Failed(
                "gallery: expected at least one embedding".into(),
            ));
        }
        if width.checked_mul(labels.len()) != Some(embeddings.len()) {
            return Err(Error::Failed(format!(
                "gallery: expected {} embeddings of {width} numbers, found {} numbers",
                labels.len(),
                embeddings.len()
            )));
        }
        if let Some(at) = embeddings.iter().position(|value| !value.is_finite()) {
            return Err(Error::Failed(format!(
                "gallery: embedding {} holds {}, expected finite numbers",
                at / width,
                embeddings[at]
            )));
        }
        Ok(Self {
            embeddings,
            width,
            labels,
        })
    }

    /// The label of the nearest embedding by Euclidean distance, computed in f64;
    /// of equally near ones the lowest index wins. None if the probe has another
    /// width or a number that is not finite.
    #[must_use]
    pub fn nearest(&self, probe: &[f32]) -> Option<usize> {
        if probe.len() != self.width || probe.iter().any(|value| !value.is_finite()) {
            return None;
        }
        let mut best = (0, f64::INFINITY);
        for (label, embedding) in self
            .labels
            .iter()
            .zip(self.embeddings.chunks_exact(self.width))
        {
            let squared = embedding
                .iter()
                .zip(probe)
                .map(|(&known, &found)| (f64::from(known) - f64::from(found)).powi(2))
                .sum();
            if squared < best.1 {
                best = (*label, squared);
            }
        }
        Some(best.0)
    }

    /// The outcome of a probe whose right label is `truth`.
    #[must_use]
    pub fn identify(&self, probe: &[f32], truth: usize) -> Outcome {
        self.nearest(probe)
            .map_or(Outcome::NonFinite, |label| Outcome::of(label == truth))
    }
}

/// Rank-1 of a matrix of distances, `[probe][gallery]`.
///
/// Of equal distances the lowest gallery index wins. A probe whose person is not
/// in the gallery is a miss (OpenGait's `evaluate_rank` leaves it out), and so is
/// a row with NaN, counted apart; an infinite distance is merely far.
///
/// # Errors
///
/// If the labels are not as many as the rows and columns.
pub fn rank1_of_distances(
    distances: ArrayView2<'_, f64>,
    probe_labels: &[usize],
    gallery_labels: &[usize],
) -> Result<Tally> {
    if distances.dim() != (probe_labels.len(), gallery_labels.len()) {
        return Err(Error::Failed(format!(
            "distances: expected {} x {}, found {} x {}",
            probe_labels.len(),
            gallery_labels.len(),
            distances.nrows(),
            distances.ncols()
        )));
    }
    let outcome = |(row, truth): (ndarray::ArrayView1<'_, f64>, &usize)| {
        if row.iter().any(|distance| distance.is_nan()) {
            return Outcome::NonFinite;
        }
        let nearest = row
            .iter()
            .zip(gallery_labels)
            .min_by(|a, b| a.0.total_cmp(b.0));
        Outcome::of(nearest.is_some_and(|(_, label)| label == truth))
    };
    Ok(distances
        .outer_iter()
        .zip(probe_labels)
        .map(outcome)
        .collect())
}

#[cfg(test)]
mod tests {
    use ndarray::{Array2, arr2};
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;

    #[test]
    fn the_highest_score_decides_and_the_lowest_index_wins_a_tie() {
        assert_eq!(closed_set(&[0.1, 0.7, 0.2], 1), Outcome::Hit);
        assert_eq!(closed_set(&[0.1, 0.7, 0.2], 2), Outcome::Miss);
        assert_eq!(closed_set(&[0.5, 0.5], 0), Outcome::Hit);
        assert_eq!(closed_set(&[0.5, 0.5], 1), Outcome::Miss);
        assert_eq!(closed_set(&[-3.0, -2.0], 1), Outcome::Hit);
        assert_eq!(closed_set(&[], 0), Outcome::Miss);
        assert_eq!(closed_set(&[1.0], 5), Outcome::Miss);
    }

    #[test]
    fn numbers_that_are_not_finite_are_misses_counted_apart() {
        let rows = [
            [f32::NAN, 1.0],
            [0.0, f32::INFINITY],
            [0.0, 1.0],
            [1.0, 0.0],
        ];
        let tally: Tally = rows.iter().map(|row| closed_set(row, 1)).collect();
        assert_eq!(
            tally,
            Tally {
                probes: 4,
                hits: 1,
                non_finite: 2
            }
        );
        assert_eq!(tally.rank1(), Some(0.25));
        assert_eq!(Tally::default().rank1(), None);
    }

    #[test]
    fn the_nearest_embedding_decides_and_the_lowest_index_wins_a_tie() {
        let gallery = Gallery::new(vec![0.0, 0.0, 3.0, 4.0, 6.0, 8.0], 2, vec![7, 8, 9]).unwrap();
        assert_eq!(gallery.nearest(&[2.9, 4.2]), Some(8));
        assert_eq!(
            gallery.nearest(&[1.5, 2.0]),
            Some(7),
            "halfway between 7 and 8"
        );
        assert_eq!(gallery.nearest(&[f32::NAN, 0.0]), None);
        assert_eq!(gallery.nearest(&[0.0]), None);
        assert_eq!(gallery.identify(&[9.0, 9.0], 9), Outcome::Hit);
        assert_eq!(gallery.identify(&[f32::NAN, 0.0], 9), Outcome::NonFinite);
    }

    #[test]
    fn huge_embeddings_do_not_overflow() {
        let gallery = Gallery::new(vec![f32::MAX, f32::MIN], 1, vec![0, 1]).unwrap();
        assert_eq!(gallery.nearest(&[f32::MIN]), Some(1));
    }

    #[test]
    fn a_gallery_that_cannot_be_is_refused() {
        let refused =
            |e: Vec<f32>, w, l: &[usize]| Gallery::new(e, w, l.to_vec()).unwrap_err().to_string();
        assert_eq!(
            refused(vec![], 2, &[]),
            "gallery: expected at least one embedding"
        );
        assert_eq!(
            refused(vec![1.0; 5], 2, &[0, 1]),
            "gallery: expected 2 embeddings of 2 numbers, found 5 numbers"
        );
        assert_eq!(
            refused(vec![1.0, 1.0, 1.0, f32::NAN], 2, &[0, 1]),
            "gallery: embedding 1 holds NaN, expected finite numbers"
        );
    }

    /// Matrix E1 of the project's reference: Rank-1 is 1.
    #[test]
    fn the_reference_matrix_has_rank_1_of_100_percent() {
        let distances = arr2(&[
            [0.10, 0.40, 0.35, 0.60, 0.70, 0.55],
            [0.50, 0.30, 0.20, 0.45, 0.65, 0.80],
            [0.90, 0.75, 0.60, 0.50, 0.25, 0.30],
        ]);
        let tally = rank1_of_distances(distances.view(), &[1, 2, 3], &[1, 1, 2, 2, 3, 3]).unwrap();
        assert_eq!(
            tally,
            Tally {
                probes: 3,
                hits: 3,
                non_finite: 0
            }
        );
        let wrong = rank1_of_distances(distances.view(), &[1, 1, 9], &[1, 1, 2, 2, 3, 3]).unwrap();
        assert_eq!(
            wrong.hits, 1,
            "a probe without a mate in the gallery is a miss"
        );
        assert!(rank1_of_distances(distances.view(), &[1, 2], &[1, 1, 2, 2, 3, 3]).is_err());
    }

    /// The oracle: sort every gallery entry by (distance, index), look at the first.
    #[test]
    fn rank_1_is_what_a_full_stable_sort_gives() {
        let mut random = ChaCha8Rng::seed_from_u64(20_260_401);
        for _ in 0..200 {
            let (probes, gallery, width) = (
                random.random_range(1..9),
                random.random_range(1..12),
                random.random_range(1..4),
            );
            // Few distinct values, so that there are many ties.
            let mut numbers = |n: usize| -> Vec<f32> {
                (0..n).map(|_| random.random_range(0..3) as f32).collect()
            };
            let (known, found) = (numbers(gallery * width), numbers(probes * width));
            let labels: Vec<usize> = (0..gallery).map(|i| i % 4).collect();
            let truths: Vec<usize> = (0..probes).map(|i| (i * 7) % 5).collect();

            let mut distances = Array2::zeros((probes, gallery));
            let mut hits = 0;
            for p in 0..probes {
                let mut order = Vec::new();
                for g in 0..gallery {
                    let mut sum = 0.0;
                    for k in 0..width {
                        sum += f64::from(known[g * width + k] - found[p * width + k]).powf(2.0);
                    }
                    distances[[p, g]] = sum.sqrt();
                    order.push((sum as i64, g));
                }
                order.sort_unstable();
                hits += u64::from(labels[order[0].1] == truths[p]);
            }
            let by_matrix = rank1_of_distances(distances.view(), &truths, &labels).unwrap();
            let gallery = Gallery::new(known, width, labels).unwrap();
            let by_gallery: Tally = found
                .chunks(width)
                .zip(&truths)
                .map(|(probe, &truth)| gallery.identify(probe, truth))
                .collect();
            assert_eq!((by_matrix.hits, by_gallery.hits), (hits, hits));
        }
    }
}
