//! Distances between embeddings, as OpenGait's evaluator defines them.
//!
//! An embedding is `[c, p]`: c numbers for each of p parts of the body, stored row by row, so
//! that number i of part j is at `i * p + j` (OpenGait's `[n, c, p]`). A plain vector has one part.
//!
//! - Euclidean: the mean over the parts of `|x - y|` (OpenGait's `euc`), 0 or more.
//! - Cosine: 1 minus the mean over the parts of `x . y / (|x| |y|)` (OpenGait's `cos`), 0..2. A
//!   part that is zero in one of the two has no direction; its cosine counts as 0, as with
//!   `F.normalize`.
//! - Votes: the share of the parts whose nearest gallery entry is another person's, 0..1. It is
//!   defined only within a gallery.
//! - View: `|x - y|` in the part of the probe's viewpoint, or the mean over the parts where that
//!   viewpoint is not known.

use crate::inference::Distance;
use std::collections::HashMap;

impl Distance {
    /// Returns the distance between two embeddings of `parts` parts, computed in f64.
    ///
    /// # Guarantees
    /// Finite for finite numbers, since squares of f32 do not overflow f64. Equal embeddings are
    /// exactly 0 apart, except for parts that are zero under [`Self::Cosine`]. A NaN or infinite
    /// number anywhere makes the distance NaN or infinite.
    ///
    /// # Panics
    /// If the embeddings differ in length, or their length is not a multiple of `parts`.
    #[must_use]
    pub fn between(self, x: &[f32], y: &[f32], parts: usize) -> f64 {
        assert_eq!(x.len(), y.len(), "embeddings of one length");
        assert!(
            parts > 0 && x.len().is_multiple_of(parts),
            "{} numbers in {parts} parts",
            x.len()
        );
        let mut taken = [Vec::new(), Vec::new()];
        let mut of_part = |part: usize| {
            for (taken, numbers) in taken.iter_mut().zip([x, y]) {
                taken.clear();
                taken.extend(numbers.iter().skip(part).step_by(parts));
            }
            self.of_vectors(&taken[0], &taken[1])
        };
        let mean = match parts {
            1 => self.of_vectors(x, y),
            _ => (0..parts).map(&mut of_part).sum::<f64>() / parts as f64,
        };
        match self {
            Self::Euclidean | Self::Votes | Self::View => mean,
            Self::Cosine => 1.0 - mean,
        }
    }

    /// Returns the distance of a probe from each embedding of a gallery. `person` maps an entry to
    /// its person; `view` is the part of the probe's viewpoint, if there is one.
    ///
    /// # Panics
    /// As [`Self::between`].
    #[must_use]
    pub(crate) fn over_gallery(
        self,
        probe: &[f32],
        view: Option<usize>,
        gallery: &[&[f32]],
        person: &dyn Fn(usize) -> usize,
        parts: usize,
    ) -> Vec<f64> {
        let of: &dyn Fn(&&[f32]) -> f64 = match (self, view) {
            (Self::Votes, _) => return votes(probe, gallery, person, parts),
            (Self::View, Some(view)) => &move |other| {
                let part = |of: &[f32]| -> Vec<f32> {
                    of.iter().skip(view).step_by(parts).copied().collect()
                };
                self.of_vectors(&part(probe), &part(other))
            },
            _ => &|other| self.between(probe, other, parts),
        };
        gallery.iter().map(of).collect()
    }

    /// Returns the Euclidean distance of two vectors, or their cosine under [`Self::Cosine`].
    fn of_vectors(self, x: &[f32], y: &[f32]) -> f64 {
        match self {
            Self::Euclidean | Self::Votes | Self::View => {
                let [squares] = sums(x, y, |x, y| [(x - y) * (x - y)]);
                squares.sqrt()
            }
            Self::Cosine => cosine(x, y),
        }
    }
}

/// Returns for each entry of a gallery the share of the parts that do not vote for its person. A
/// part votes for the person of the nearest entry; ties go to the first entry. An entry with
/// non-finite numbers has the distance NaN, and gets no vote for the parts where they are.
fn votes(
    probe: &[f32],
    gallery: &[&[f32]],
    person: &dyn Fn(usize) -> usize,
    parts: usize,
) -> Vec<f64> {
    let people: Vec<usize> = (0..gallery.len()).map(person).collect();
    let mut squares = vec![vec![0.0f64; parts]; gallery.len()];
    for (other, squares) in gallery.iter().zip(&mut squares) {
        assert_eq!(probe.len(), other.len(), "embeddings of one length");
        for (x, y) in probe.chunks_exact(parts).zip(other.chunks_exact(parts)) {
            for ((sum, &x), &y) in squares.iter_mut().zip(x).zip(y) {
                *sum += (f64::from(x) - f64::from(y)).powi(2);
            }
        }
    }
    let mut votes = HashMap::new();
    for part in 0..parts {
        let all = squares.iter().map(|of_entry| of_entry[part]).enumerate();
        let finite = all.filter(|(_, square)| square.is_finite());
        let nearest = finite.reduce(|best, next| if next.1 < best.1 { next } else { best });
        if let Some((entry, _)) = nearest {
            *votes.entry(people[entry]).or_insert(0usize) += 1;
        }
    }
    let of_entry = |(entry, person): (usize, &usize)| {
        if squares[entry].iter().all(|square| square.is_finite()) {
            1.0 - votes.get(person).copied().unwrap_or(0) as f64 / parts as f64
        } else {
            f64::NAN
        }
    };
    people.iter().enumerate().map(of_entry).collect()
}

/// Returns the cosine between two vectors, -1..1; 0 if one is zero.
fn cosine(x: &[f32], y: &[f32]) -> f64 {
    let [dot, xx, yy] = sums(x, y, |x, y| [x * y, x * x, y * y]);
    // One root of the product, not two: for equal vectors it is exactly the dot product.
    let lengths = f64::sqrt(xx * yy);
    if lengths == 0.0 {
        return 0.0;
    }
    (dot / lengths).clamp(-1.0, 1.0)
}

/// Returns the sums of `of` over pairs of numbers.
///
/// Number i is added to sum i modulo 4, and the four sums are added at the end. The order is the
/// same on every machine, and lets a compiler vectorise the additions.
fn sums<const N: usize>(x: &[f32], y: &[f32], of: impl Fn(f64, f64) -> [f64; N]) -> [f64; N] {
    let mut lanes = [[0.0; 4]; N];
    let mut add = |lane: usize, x: f32, y: f32| {
        let terms = of(f64::from(x), f64::from(y));
        for (sums, term) in lanes.iter_mut().zip(terms) {
            sums[lane] += term;
        }
    };
    let (x, x_rest) = x.as_chunks::<4>();
    let (y, y_rest) = y.as_chunks::<4>();
    for (x, y) in x.iter().zip(y) {
        for lane in 0..4 {
            add(lane, x[lane], y[lane]);
        }
    }
    for (lane, (&x, &y)) in x_rest.iter().zip(y_rest).enumerate() {
        add(lane, x, y);
    }
    lanes.map(|[a, b, c, d]| (a + b) + (c + d))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluate::identification::{ProbeRank, rank};
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    #[test]
    fn two_parts_have_the_distances_that_opengait_gives() {
        // Part 0 is (1, 0) and part 1 (0, 2); against zeros, and against part 0 alone.
        let x = [1.0, 0.0, 0.0, 2.0];
        for (y, euclidean, cosine) in [([0.0; 4], 1.5, 1.0), ([1.0, 0.0, 0.0, 0.0], 1.0, 0.5)] {
            assert_eq!(Distance::Euclidean.between(&x, &y, 2), euclidean);
            assert_eq!(Distance::Cosine.between(&x, &y, 2), cosine);
        }
    }

    #[test]
    fn votes_are_counted_by_hand() {
        // Three parts of one number, three entries of two people.
        let probe = [0.0, 0.0, 0.0];
        let gallery: [&[f32]; 3] = [&[1.0, 5.0, 2.0], &[3.0, 1.0, 2.0], &[2.0, 2.0, 3.0]];
        let person = |entry: usize| [0, 1, 0][entry];
        // Part 0: entry 0; part 1: entry 1; part 2: entries 0 and 1, and the tie goes to entry 0.
        let found = Distance::Votes.over_gallery(&probe, None, &gallery, &person, 3);
        let third = 1.0 / 3.0;
        assert_eq!(found, [1.0 - 2.0 * third, 1.0 - third, 1.0 - 2.0 * third]);
        // An entry that is not finite gets no vote, and no distance.
        let broken: [&[f32]; 2] = [&[f32::NAN, 0.0, 0.0], &[9.0, 9.0, 9.0]];
        let found = Distance::Votes.over_gallery(&probe, None, &broken, &|entry| entry, 3);
        assert!(found[0].is_nan());
        assert_eq!(found[1], 1.0 - third);
        // Under other distances the entries do not depend on each other.
        let found = Distance::Euclidean.over_gallery(&probe, None, &gallery, &person, 1);
        assert_eq!(found[0], 30.0_f64.sqrt());
    }

    #[test]
    fn only_the_part_of_the_probes_viewpoint_is_compared() {
        // Two numbers of two parts: part 0 is (0, 0), part 1 is (1, 1).
        let probe = [0.0, 1.0, 0.0, 1.0];
        let gallery: [&[f32]; 2] = [&[3.0, 1.0, 4.0, 1.0], &[0.0, 1.0, 0.0, 3.0]];
        let found = |view| {
            let person = |entry: usize| entry;
            Distance::View.over_gallery(&probe, view, &gallery, &person, 2)
        };
        assert_eq!(found(Some(0)), [5.0, 0.0]);
        assert_eq!(found(Some(1)), [0.0, 2.0]);
        assert_eq!(found(None), [2.5, 1.0]);
    }

    #[test]
    fn one_part_is_a_plain_vector() {
        let (x, y) = ([3.0, 0.0], [0.0, 4.0]);
        assert_eq!(Distance::Euclidean.between(&x, &y, 1), 5.0);
        assert_eq!(Distance::Cosine.between(&x, &y, 1), 1.0);
        assert_eq!(Distance::Cosine.between(&x, &[-6.0, 0.0], 1), 2.0);
        // 45 degrees.
        let diagonal = Distance::Cosine.between(&x, &[2.0, 2.0], 1);
        assert!((diagonal - (1.0 - 0.5_f64.sqrt())).abs() < 1e-15);
    }

    #[test]
    fn equal_embeddings_are_exactly_zero_apart() {
        for x in [
            [0.1, -0.7, 3.3],
            [1e-30, 2e-30, 5e-31],
            [f32::MAX, f32::MIN, 1.0],
        ] {
            for metric in [Distance::Euclidean, Distance::Cosine] {
                assert_eq!(metric.between(&x, &x, 1), 0.0);
                assert_eq!(metric.between(&x, &x, 3), 0.0);
            }
        }
    }

    #[test]
    fn a_nan_or_an_infinite_number_leaves_no_finite_distance() {
        for bad in [f32::NAN, f32::INFINITY] {
            for y in [[0.0, 0.0], [1.0, 2.0], [bad, bad]] {
                for metric in [Distance::Euclidean, Distance::Cosine] {
                    assert!(!metric.between(&[bad, 1.0], &y, 1).is_finite());
                    assert!(!metric.between(&y, &[bad, 1.0], 2).is_finite());
                }
            }
        }
    }

    #[test]
    fn two_zero_vectors_are_0_apart_but_1_by_cosine() {
        assert_eq!(Distance::Euclidean.between(&[0.0; 4], &[0.0; 4], 2), 0.0);
        assert_eq!(Distance::Cosine.between(&[0.0; 4], &[0.0; 4], 2), 1.0);
    }

    /// Ranks a probe against a gallery of embeddings of `width` numbers, stored one after another.
    fn ranked(known: &[f32], width: usize, labels: &[usize], probe: (&[f32], usize)) -> ProbeRank {
        let (found, truth) = probe;
        let distances: Vec<f64> = known
            .chunks(width)
            .map(|known| Distance::Euclidean.between(found, known, 1))
            .collect();
        rank(&distances, |at| labels[at] == truth)
    }

    fn strangers_before(ranked: ProbeRank) -> Option<usize> {
        match ranked {
            ProbeRank::Found {
                strangers_before, ..
            } => Some(strangers_before),
            ProbeRank::NoMate | ProbeRank::NonFinite => None,
        }
    }

    #[test]
    fn the_nearest_embedding_decides_and_the_lowest_index_wins_a_tie() {
        let known = [0.0, 0.0, 3.0, 4.0, 6.0, 8.0];
        let of = |probe: [f32; 2], truth| ranked(&known, 2, &[7, 8, 9], (&probe, truth));
        assert_eq!(strangers_before(of([2.9, 4.2], 8)), Some(0));
        let between = |truth| strangers_before(of([1.5, 2.0], truth));
        assert_eq!((between(7), between(8)), (Some(0), Some(1)), "halfway");
        assert_eq!(strangers_before(of([9.0, 9.0], 9)), Some(0));
        assert_eq!(of([f32::NAN, 0.0], 9), ProbeRank::NonFinite);
        assert_eq!(of([9.0, 9.0], 6), ProbeRank::NoMate);
    }

    #[test]
    fn huge_embeddings_do_not_overflow() {
        let found = ranked(&[f32::MAX, f32::MIN], 1, &[0, 1], (&[f32::MIN], 1));
        assert_eq!(strangers_before(found), Some(0));
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
            for p in 0..probes {
                let truth = (p * 7) % 5;
                let mut order = Vec::new();
                for g in 0..gallery {
                    let mut sum = 0.0;
                    for k in 0..width {
                        sum += f64::from(known[g * width + k] - found[p * width + k]).powf(2.0);
                    }
                    order.push((sum as i64, g));
                }
                order.sort_unstable();
                let probe = &found[p * width..][..width];
                let is_hit = strangers_before(ranked(&known, width, &labels, (probe, truth)));
                assert_eq!(is_hit == Some(0), labels[order[0].1] == truth);
            }
        }
    }
}
