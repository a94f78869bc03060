//! The configurations that no other beats.

/// The costs and the error of a configuration; less is better for each.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ConfigurationCost {
    /// The time of a GEI, ns.
    pub ns_per_gei: f64,
    /// The size of the pack.
    pub pack_bytes: usize,
    /// The error of a GEI.
    pub gei_rmse: f64,
}

/// The relative difference below which times count as equal: the noise of a shared machine in the
/// least time of several rounds. Our choice.
const TIME_NOISE: f64 = 0.05;

impl ConfigurationCost {
    /// Returns whether nothing is worse than in `other` and something is better. Differences of
    /// time within noise do not count.
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

/// Returns for each whether no other beats it: the Pareto set.
#[must_use]
pub(crate) fn pareto(all: &[ConfigurationCost]) -> Vec<bool> {
    let is_best = |one: &ConfigurationCost| !all.iter().any(|other| other.beats(one));
    all.iter().map(is_best).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn merits((ns_per_gei, pack_bytes, gei_rmse): (f64, usize, f64)) -> ConfigurationCost {
        ConfigurationCost {
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
        // 4 % slower alone does not count; 6 % does.
        let same = [(100.0, 500, 4.0), (104.0, 500, 4.0)];
        assert_eq!(pareto(&same.map(merits)), [true, true]);
        let slower = [(100.0, 500, 4.0), (106.0, 500, 4.0)];
        assert_eq!(pareto(&slower.map(merits)), [true, false]);
    }
}
