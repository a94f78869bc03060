//! Which configurations are not beaten.

/// What a configuration costs and gets wrong: less is better of each.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Merits {
    /// Time of a GEI, ns.
    pub ns_per_gei: f64,
    /// Size of the pack.
    pub pack_bytes: usize,
    /// Error of a GEI.
    pub gei_rmse: f64,
}

/// Times closer than this share are the same: what a shared machine's noise leaves of the
/// least of several rounds. Ours.
const TIME_NOISE: f64 = 0.05;

impl Merits {
    /// Whether nothing is worse than of `other`, and something better. Of times only what
    /// exceeds noise counts.
    #[must_use]
    pub(crate) fn beats(&self, other: &Self) -> bool {
        let not_worse = self.ns_per_gei <= other.ns_per_gei * (1.0 + TIME_NOISE)
            && self.pack_bytes <= other.pack_bytes
            && self.gei_rmse <= other.gei_rmse;
        let better = self.ns_per_gei * (1.0 + TIME_NOISE) < other.ns_per_gei
            || self.pack_bytes < other.pack_bytes
            || self.gei_rmse < other.gei_rmse;
        not_worse && better
    }
}

/// For each whether no other beats it: the Pareto set.
#[must_use]
pub(crate) fn pareto(all: &[Merits]) -> Vec<bool> {
    let is_best = |one: &Merits| !all.iter().any(|other| other.beats(one));
    all.iter().map(is_best).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn merits((ns_per_gei, pack_bytes, gei_rmse): (f64, usize, f64)) -> Merits {
        Merits {
            ns_per_gei,
            pack_bytes,
            gei_rmse,
        }
    }

    #[test]
    fn what_is_beaten_in_everything_is_not_in_the_set() {
        let all = [
            (100.0, 500, 4.0),
            (200.0, 500, 2.0), // slower and closer
            (200.0, 500, 4.0), // slower only
            (300.0, 400, 5.0), // smaller
            (300.0, 600, 2.0), // slower and larger than the second
            (50.0, 500, 9.0),  // fastest
        ];
        let expected = [true, true, false, true, false, true];
        assert_eq!(pareto(&all.map(merits)), expected);
    }

    #[test]
    fn a_time_within_noise_is_no_merit_and_no_fault() {
        // 4 % slower, and closer: the second beats the first.
        let all = [(100.0, 500, 4.0), (104.0, 500, 3.0)];
        assert_eq!(pareto(&all.map(merits)), [false, true]);
        // 4 % slower alone is nothing; 6 % is something.
        let same = [(100.0, 500, 4.0), (104.0, 500, 4.0)];
        assert_eq!(pareto(&same.map(merits)), [true, true]);
        let slower = [(100.0, 500, 4.0), (106.0, 500, 4.0)];
        assert_eq!(pareto(&slower.map(merits)), [true, false]);
    }
}
