//! Compares the order of the paper's results with ours.

use super::Recognition;
use super::recognition::Experiment;
use super::splits::SplitUnit;
use serde::Serialize;

/// The paper's statements on accuracies "given a sufficient number" of components (section 4.2),
/// and whether they hold here with the most components.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct PaperOrder {
    /// The view's name.
    pub view: String,
    /// The name of the masks.
    pub masks: &'static str,
    /// The name of the framing.
    pub framing: &'static str,
    /// Whether the training set also has flipped and cropped GEIs.
    pub augmented: bool,
    /// The unit by which cycles are split.
    pub split: SplitUnit,
    /// The experiments and their accuracies, the best first.
    pub ranked: Vec<(Experiment, f64)>,
    /// Whether R-R and S-S are at least as good as all other experiments.
    pub own_is_best: bool,
    /// Whether both mixed experiments are above 95 %.
    pub mixed_above_95: bool,
    /// Whether R-S and S-R are below all other experiments.
    pub across_is_lowest: bool,
    /// The accuracy that S adds to 70 % of R, over the control without S.
    pub gain_of_seventy: f64,
    /// The accuracy that S adds to 30 % of R, over the control without S.
    pub gain_of_thirty: f64,
}

/// Returns the order under each setting that has all experiments.
pub(crate) fn orders(all: &[Recognition]) -> Vec<PaperOrder> {
    let mut orders: Vec<PaperOrder> = Vec::new();
    for first in all {
        let Some(split) = first.curve.split else {
            continue;
        };
        let is_setting = |one: &PaperOrder| {
            one.view == first.view
                && (one.masks, one.framing) == (first.masks, first.framing)
                && (one.augmented, one.split) == (first.augmented, split)
        };
        if orders.iter().any(is_setting) {
            continue;
        }
        let accuracy = |experiment: Experiment| {
            let found = all.iter().find(|curve| {
                // The experiment without real data was measured once.
                let is_masks = curve.masks == first.masks || experiment.is_synthetic();
                curve.curve.experiment == experiment
                    && is_masks
                    && curve.view == first.view
                    && (curve.framing, curve.augmented) == (first.framing, first.augmented)
                    && curve.curve.split.is_none_or(|unit| unit == split)
            });
            Some((experiment, found?.curve.last()?.accuracy))
        };
        let ranked: Option<Vec<(Experiment, f64)>> =
            Experiment::ALL.into_iter().map(accuracy).collect();
        let Some(mut ranked) = ranked else { continue };
        let of = |experiment| {
            let found = ranked.iter().find(|(one, _)| *one == experiment);
            found.map_or(f64::NAN, |(_, accuracy)| *accuracy)
        };
        let own = of(Experiment::RealReal).min(of(Experiment::SyntheticSynthetic));
        let mixed = [Experiment::MixedSeventy, Experiment::MixedThirty].map(of);
        let across = of(Experiment::RealSynthetic).max(of(Experiment::SyntheticReal));
        let order = PaperOrder {
            view: first.view.clone(),
            masks: first.masks,
            framing: first.framing,
            augmented: first.augmented,
            split,
            own_is_best: own >= mixed[0].max(mixed[1]).max(across),
            mixed_above_95: mixed[0].min(mixed[1]) > 0.95,
            across_is_lowest: across < own.min(mixed[0]).min(mixed[1]),
            gain_of_seventy: mixed[0] - of(Experiment::RealReal),
            gain_of_thirty: mixed[1] - of(Experiment::ControlThirty),
            ranked: {
                ranked.sort_by(|a, b| b.1.total_cmp(&a.1));
                ranked
            },
        };
        orders.push(order);
    }
    orders
}

#[cfg(test)]
mod tests {
    use super::super::recognition::{AccuracyCurve, AccuracyPoint};
    use super::*;

    fn found(experiment: Experiment, masks: &'static str, accuracy: f64) -> Recognition {
        let point = AccuracyPoint {
            components: 60,
            accuracy,
            low: None,
            high: None,
        };
        Recognition {
            view: "090".into(),
            masks,
            framing: "height",
            augmented: false,
            curve: AccuracyCurve {
                experiment,
                split: experiment.is_split().then_some(SplitUnit::Cycle),
                splits: 1,
                classes: 2,
                people: 2,
                trained: 2.0,
                tested: 2.0,
                points: vec![point.clone()],
                nearest: point,
                chance: 0.5,
            },
        }
    }

    #[test]
    fn the_papers_order_is_known_where_it_holds_and_where_it_does_not() {
        use Experiment::*;
        let of = |own, mixed, control, across| {
            let rates = [
                (RealReal, own),
                (SyntheticSynthetic, own),
                (MixedSeventy, mixed),
                (MixedThirty, mixed),
                (ControlThirty, control),
                (SyntheticReal, across),
                (RealSynthetic, across),
            ];
            let all = rates.map(|(experiment, rate)| found(experiment, "given", rate));
            orders(&all).remove(0)
        };
        let papers = of(0.99, 0.97, 0.9, 0.4);
        assert!(papers.own_is_best && papers.mixed_above_95 && papers.across_is_lowest);
        assert!((papers.gain_of_thirty - 0.07).abs() < 1e-12);
        assert!((papers.gain_of_seventy + 0.02).abs() < 1e-12);
        assert_eq!(papers.ranked[0].1, 0.99);
        let other = of(0.9, 0.95, 0.9, 0.92);
        assert!(!other.own_is_best && !other.mixed_above_95 && !other.across_is_lowest);
    }

    #[test]
    fn what_is_synthetic_on_both_sides_counts_for_all_masks_and_a_setting_that_lacks_one_has_no_order()
     {
        use Experiment::*;
        let mut all = vec![found(SyntheticSynthetic, "given", 0.8)];
        for experiment in Experiment::ALL {
            if experiment != SyntheticSynthetic {
                all.push(found(experiment, "segmented", 0.5));
            }
        }
        let found_orders = orders(&all);
        let known: Vec<_> = found_orders
            .iter()
            .map(|found_order| found_order.masks)
            .collect();
        assert_eq!(known, ["segmented"]);
        assert_eq!(found_orders[0].ranked[0], (SyntheticSynthetic, 0.8));
    }
}
