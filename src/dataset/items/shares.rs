//! Divides the work on items among cores.

/// The cost of posing a cycle, in views that are drawn in the same time.
const POSING: usize = 9;
/// Shares of the work for each core, so that all cores end at about the same time.
const SHARES: usize = 4;
/// The minimum work in a share when a core gets several.
const LEAST_SHARE: usize = 128;
/// The minimum work that is worth another core.
const LEAST_WORK: usize = 24;

/// Returns the number of shares that an amount of work is divided into.
fn count(work: usize, threads: usize) -> usize {
    let many = (work / LEAST_SHARE).min(SHARES * threads);
    let few = (work / LEAST_WORK).min(threads);
    many.max(few).max(1)
}

/// Divides positions in `items` into shares of about the same duration, ordered by cycle; a cycle
/// has `views` items. If a cycle is divided, each share gets views from all around.
pub(super) fn divide(items: &[usize], views: usize, threads: usize) -> Vec<Vec<usize>> {
    let cycle_of = |at: usize| items[at] / views;
    let mut order: Vec<usize> = (0..items.len()).collect();
    order.sort_by_key(|&at| items[at]);
    let cycles: Vec<&[usize]> = order
        .chunk_by(|&a, &b| cycle_of(a) == cycle_of(b))
        .collect();
    let all = items.len() + cycles.len() * POSING;
    let count = count(all, threads);
    // A divided cycle is posed once more.
    let most = (all + (count - 1) * POSING).div_ceil(count);
    let mut shares = vec![Vec::new()];
    let mut left = most;
    for cycle in cycles {
        left = left.saturating_sub(POSING);
        let turns = cycle.iter().step_by(2);
        for &at in turns.chain(cycle.iter().skip(1).step_by(2)) {
            if left == 0 {
                shares.push(Vec::new());
                left = most - POSING;
            }
            left -= 1;
            if let Some(share) = shares.last_mut() {
                share.push(at);
            }
        }
    }
    shares
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the cost of each share, in views.
    fn costs(items: &[usize], views: usize, shares: &[Vec<usize>]) -> Vec<usize> {
        let cost = |share: &Vec<usize>| {
            let cycles = share.chunk_by(|&a, &b| items[a] / views == items[b] / views);
            share.len() + POSING * cycles.count()
        };
        shares.iter().map(cost).collect()
    }

    #[test]
    fn work_is_shared_evenly_and_every_item_is_drawn_once() {
        let cases: [(Vec<usize>, usize, usize); 7] = [
            // A batch of one cycle, and one across two cycles.
            ((0..256).collect(), 703, 2),
            ((600..856).collect(), 703, 2),
            // Whole cycles, and single views of many.
            ((0..4 * 703).collect(), 703, 8),
            ((0..703 * 300).step_by(703).collect(), 703, 8),
            // Four cycles from ten sides, two views, and nothing.
            ((0..40).collect(), 10, 2),
            ((0..2).collect(), 11, 1),
            (Vec::new(), 11, 1),
        ];
        for (items, views, count) in cases {
            let shares = divide(&items, views, 2);
            assert_eq!(shares.len(), count);
            let mut all = shares.concat();
            all.sort_unstable();
            assert!(all.into_iter().eq(0..items.len()));
            let costs = costs(&items, views, &shares);
            let most = costs.iter().max().copied().unwrap_or(0);
            let mean = costs.iter().sum::<usize>() as f64 / count as f64;
            assert!(most as f64 <= 1.1 * mean + 1.0, "{costs:?}");
        }
    }

    #[test]
    fn both_halves_of_a_cycle_have_views_from_all_around() {
        let items: Vec<usize> = (0..256).collect();
        let shares = divide(&items, 703, 2);
        assert_eq!(shares[0][..3], [0, 2, 4]);
        assert_eq!(shares[1][..3], [1, 3, 5]);
    }
}
