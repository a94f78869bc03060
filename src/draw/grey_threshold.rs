//! The threshold between two clusters of grey levels.
//!
//! Segmentation applies it to the differences between a frame and its background (Charalambous &
//! Bharath, BMVC 2016, section 3.3), and the confounder `light` simulates that.

/// Returns the threshold midway between the means of two clusters of levels, from the count of each
/// level: k-means (Lloyd 1982), starting from the least and the greatest level. Levels above the
/// threshold are the figure.
#[must_use]
pub(crate) fn threshold(counts: &[u32; 256]) -> f64 {
    let used = |level: &usize| counts[*level] > 0;
    let (first, last) = ((0..256).find(used), (0..256).rfind(used));
    let mut threshold = 0.5 * (first.unwrap_or(0) + last.unwrap_or(0)) as f64;
    // Counts and sums of all levels below each level: whole numbers, so that differences are exact.
    let mut below = [(0, 0); 257];
    for level in 0..256 {
        let (count, sum) = below[level];
        let here = u64::from(counts[level]);
        below[level + 1] = (count + here, sum + here * level as u64);
    }
    // Each step moves levels to one side, so that there are at most 256 steps.
    for _ in 0..256 {
        let mean = |levels: std::ops::Range<usize>| {
            let (from, to) = (below[levels.start], below[levels.end]);
            let (count, sum) = (to.0 - from.0, to.1 - from.1);
            (count > 0).then(|| sum as f64 / count as f64)
        };
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "0 to 255"
        )]
        let split = threshold as usize + 1;
        let Some((low, high)) = mean(0..split).zip(mean(split..256)) else {
            break;
        };
        let next = 0.5 * (low + high);
        if next == threshold {
            break;
        }
        threshold = next;
    }
    threshold
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_threshold_lies_midway_between_the_clusters_means() {
        let counts = |levels: &[(usize, u32)]| {
            let mut counts = [0; 256];
            for &(level, count) in levels {
                counts[level] = count;
            }
            counts
        };
        assert_eq!(threshold(&counts(&[(10, 90), (110, 3)])), 60.0);
        // From 50 on: 0 and 10 have the mean 2.5, so that 40 is nearer to it than to 100.
        assert_eq!(threshold(&counts(&[(0, 6), (10, 2), (100, 2)])), 51.25);
        // From 50: (0 x 8 + 45 x 1) / 9 = 5, and 100; from 52.5 on nothing moves.
        assert_eq!(threshold(&counts(&[(0, 8), (45, 1), (100, 4)])), 52.5);
        // From 30 on 40 goes with 60: 3 and 55 give 29; then 30 goes with them: 0 and 50.
        assert_eq!(
            threshold(&counts(&[(0, 9), (30, 1), (40, 1), (60, 3)])),
            25.0
        );
        assert_eq!(threshold(&counts(&[(7, 3)])), 7.0);
    }

    /// Finds, by trying all, the splits at which every level is nearest to the mean of its own
    /// cluster, and the split whose clusters have the least sum of squares.
    fn brute_force(counts: &[u32; 256]) -> (Vec<usize>, usize) {
        let moments = |levels: std::ops::Range<usize>| {
            let sum = |power: i32| -> f64 {
                let part = levels.clone();
                part.map(|at| f64::from(counts[at]) * (at as f64).powi(power))
                    .sum()
            };
            (sum(0), sum(1), sum(2))
        };
        let (mut fixed, mut best) = (Vec::new(), (f64::INFINITY, 0));
        for split in 1..256 {
            let (low, high) = (moments(0..split), moments(split..256));
            if low.0 == 0.0 || high.0 == 0.0 {
                continue;
            }
            let middle = 0.5 * (low.1 / low.0 + high.1 / high.0);
            if middle < split as f64 && middle >= (split - 1) as f64 {
                fixed.push(split);
            }
            let squares = |(count, sum, squares): (f64, f64, f64)| squares - sum * sum / count;
            let cost = squares(low) + squares(high);
            if cost < best.0 {
                best = (cost, split);
            }
        }
        (fixed, best.1)
    }

    #[test]
    fn it_is_a_split_that_brute_force_finds_and_the_best_of_two_clusters_apart() {
        let mut state = 7_u32;
        let mut next = |below: u32| {
            // Numerical Recipes' generator, its upper bits.
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) % below
        };
        for round in 0..200 {
            let mut counts = [0; 256];
            let is_apart = round % 2 == 0;
            for _ in 0..400 {
                let level = if !is_apart {
                    next(256)
                } else if next(8) == 0 {
                    170 + next(30) + next(30)
                } else {
                    next(30) + next(30)
                };
                counts[level as usize] += 1;
            }
            let split = threshold(&counts) as usize + 1;
            let (fixed, best) = brute_force(&counts);
            assert!(fixed.contains(&split), "{split} of {fixed:?}");
            if is_apart {
                // No level is used between the clusters: splits there are one and the same.
                let same =
                    |at: usize| counts[at.min(split)..at.max(split)].iter().sum::<u32>() == 0;
                assert!(same(best), "{split}, best {best}");
            }
        }
    }
}
