//! Recognition across real and synthetic silhouettes: PCA and linear support vector machines by
//! the number of components.

use super::example::{Example, RealAndSynthetic, SIZE};
use super::likeness::mean;
use super::splits::{ExampleSplit, SplitUnit, split};
use crate::draw::template::Template;
use crate::draw::template::augment::{Augmentation, varied};
use crate::error::Result;
use crate::evaluate::bootstrap::interval_95;
use crate::evaluate::rank1::{ProbeOutcome, Tally, closed_set};
use crate::train::{Analysed, Components, TrainMethod, TrainOptions};
use ndarray::Array2;
use rayon::prelude::*;
use serde::Serialize;
use std::collections::BTreeMap;

/// The numbers of principal components. The paper's figure has them on its horizontal axis and does
/// not state them.
pub(crate) const COMPONENTS: [usize; 10] = [1, 2, 5, 9, 15, 20, 30, 40, 50, 60];

/// The weight of the errors. The paper does not state it.
const C: f64 = 1.0;

/// The training and the test set of an experiment: R is real, S synthetic, and 70 and 30 are
/// percent.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub(crate) enum Experiment {
    /// Trains on 70 % of R and tests on the rest; also the control of [`Self::MixedSeventy`].
    #[serde(rename = "R-R")]
    RealReal,
    /// Trains on 70 % of S and tests on the rest.
    #[serde(rename = "S-S")]
    SyntheticSynthetic,
    /// Trains on all of R and tests on S.
    #[serde(rename = "R-S")]
    RealSynthetic,
    /// Trains on all of S and tests on R.
    #[serde(rename = "S-R")]
    SyntheticReal,
    /// Trains on 70 % of R and all of S, and tests on the rest of R.
    #[serde(rename = "70%R+S - 30%R")]
    MixedSeventy,
    /// Trains on 30 % of R and all of S, and tests on the rest of R.
    #[serde(rename = "30%R+S - 70%R")]
    MixedThirty,
    /// Trains on 30 % of R and tests on the rest: the control of [`Self::MixedThirty`].
    #[serde(rename = "30%R - 70%R")]
    ControlThirty,
}

impl Experiment {
    /// All experiments, in the order of reports.
    pub(crate) const ALL: [Self; 7] = [
        Self::RealReal,
        Self::SyntheticSynthetic,
        Self::MixedSeventy,
        Self::MixedThirty,
        Self::ControlThirty,
        Self::SyntheticReal,
        Self::RealSynthetic,
    ];

    /// Returns the name in results: the training set and the test set.
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::RealReal => "R-R",
            Self::SyntheticSynthetic => "S-S",
            Self::RealSynthetic => "R-S",
            Self::SyntheticReal => "S-R",
            Self::MixedSeventy => "70%R+S - 30%R",
            Self::MixedThirty => "30%R+S - 70%R",
            Self::ControlThirty => "30%R - 70%R",
        }
    }

    /// Returns whether the experiment has no real data.
    pub(crate) const fn is_synthetic(self) -> bool {
        matches!(self, Self::SyntheticSynthetic)
    }

    /// Returns the units by which cycles are split; if they are not, a single unit, which has no
    /// effect.
    pub(crate) const fn units(self) -> &'static [SplitUnit] {
        if self.is_split() {
            &[SplitUnit::Cycle, SplitUnit::Take]
        } else {
            &[SplitUnit::Cycle]
        }
    }

    /// Returns whether the experiment splits cycles, and so depends on the unit and the seed.
    pub(crate) const fn is_split(self) -> bool {
        !matches!(self, Self::RealSynthetic | Self::SyntheticReal)
    }
}

/// The training and test examples of one trial.
struct RecognitionTrial<'a> {
    train: Vec<&'a Example>,
    test: Vec<&'a Example>,
}

/// The accuracy with a number of components.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct AccuracyPoint {
    /// The number of principal components.
    pub components: usize,
    /// The share of cycles whose person was identified, 0..1, over all splits.
    pub accuracy: f64,
    /// The lower end of the 95 % interval, which resamples people; none for fewer than two.
    pub low: Option<f64>,
    /// The upper end of the 95 % interval.
    pub high: Option<f64>,
}

/// The results of one experiment.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct AccuracyCurve {
    /// The experiment.
    pub experiment: Experiment,
    /// The unit by which cycles are split; none if they are not.
    pub split: Option<SplitUnit>,
    /// The number of random splits.
    pub splits: usize,
    /// The number of people in the training set.
    pub classes: usize,
    /// The number of people in the test set.
    pub people: usize,
    /// The mean number of training cycles in a split.
    pub trained: f64,
    /// The mean number of test cycles in a split.
    pub tested: f64,
    /// The accuracies by the number of components.
    pub points: Vec<AccuracyPoint>,
    /// The accuracy of the nearest GEI in pixels, without components or training.
    pub nearest: AccuracyPoint,
    /// The accuracy of guessing.
    pub chance: f64,
}

impl AccuracyCurve {
    /// Returns the point with the most components.
    pub(crate) fn last(&self) -> Option<&AccuracyPoint> {
        self.points.last()
    }
}

/// Runs an experiment over splits with seeds from `seeds`, on all cores; none if there are no test
/// cycles or only one class. Only the training set is augmented.
///
/// # Errors
/// If training fails.
pub(crate) fn curve(
    experiment: Experiment,
    both: RealAndSynthetic<'_>,
    unit: SplitUnit,
    seeds: &[u64],
    augmentation: Augmentation,
    progress: &(dyn Fn() -> Result<()> + Sync),
) -> Result<Option<AccuracyCurve>> {
    let seeds = if experiment.is_split() {
        seeds
    } else {
        &seeds[..1]
    };
    let one = |&seed: &u64| {
        let trial = trial(experiment, both.real, both.synthetic, unit, seed);
        let judged = judge(&trial, augmentation);
        progress()?;
        Ok(judged)
    };
    let judged = seeds.par_iter().map(one);
    let judged: Vec<Result<Option<TrialOutcome>>> = judged.collect::<Result<_>>()?;
    let judged: Vec<Option<TrialOutcome>> = judged.into_iter().collect::<Result<_>>()?;
    let Some(judged) = judged.into_iter().collect::<Option<Vec<TrialOutcome>>>() else {
        return Ok(None);
    };
    let seed = seeds.first().copied().unwrap_or(1);
    let point = |components, of: &dyn Fn(&TrialOutcome) -> &BTreeMap<usize, Tally>| {
        let mut people: BTreeMap<usize, Tally> = BTreeMap::new();
        for (&person, tally) in judged.iter().flat_map(of) {
            *people.entry(person).or_default() += tally;
        }
        let people: Vec<Tally> = people.into_values().collect();
        let interval = interval_95(&people, seed, Tally::rank1);
        AccuracyPoint {
            components,
            accuracy: people.iter().copied().sum::<Tally>().rank1().unwrap_or(0.0),
            low: interval.map(|interval| interval.low),
            high: interval.map(|interval| interval.high),
        }
    };
    let points = COMPONENTS.iter().enumerate().filter(|(at, _)| {
        // A split may have fewer samples than the most components.
        judged.iter().all(|judged| judged.by_components.len() > *at)
    });
    let points: Vec<AccuracyPoint> = points
        .map(|(at, &components)| point(components, &|judged| &judged.by_components[at]))
        .collect();
    let over = |of: &dyn Fn(&TrialOutcome) -> usize| {
        mean(
            &judged
                .iter()
                .map(|judged| of(judged) as f64)
                .collect::<Vec<_>>(),
        )
    };
    let classes = judged
        .iter()
        .map(|judged| judged.classes)
        .max()
        .unwrap_or(0);
    Ok(Some(AccuracyCurve {
        experiment,
        split: experiment.is_split().then_some(unit),
        splits: seeds.len(),
        classes,
        people: judged
            .iter()
            .map(|judged| judged.nearest.len())
            .max()
            .unwrap_or(0),
        trained: over(&|judged| judged.trained),
        tested: over(&|judged| judged.tested),
        points,
        nearest: point(0, &|judged| &judged.nearest),
        chance: 1.0 / classes.max(1) as f64,
    }))
}

fn trial<'a>(
    experiment: Experiment,
    real: &'a [Example],
    synthetic: &'a [Example],
    unit: SplitUnit,
    seed: u64,
) -> RecognitionTrial<'a> {
    let all = |examples: &'a [Example]| examples.iter().collect::<Vec<_>>();
    let parts = |examples: &'a [Example]| {
        let ExampleSplit {
            smaller,
            larger,
            whole,
        } = split(examples, unit, seed);
        [smaller, larger, whole].map(|numbers| {
            numbers
                .into_iter()
                .map(|at| &examples[at])
                .collect::<Vec<_>>()
        })
    };
    match experiment {
        Experiment::RealSynthetic => RecognitionTrial {
            train: all(real),
            test: all(synthetic),
        },
        Experiment::SyntheticReal => RecognitionTrial {
            train: all(synthetic),
            test: all(real),
        },
        Experiment::RealReal | Experiment::SyntheticSynthetic => {
            let of = if experiment == Experiment::RealReal {
                real
            } else {
                synthetic
            };
            let [smaller, larger, whole] = parts(of);
            RecognitionTrial {
                train: [larger, whole].concat(),
                test: smaller,
            }
        }
        Experiment::MixedSeventy => {
            let [smaller, larger, whole] = parts(real);
            RecognitionTrial {
                train: [larger, whole, all(synthetic)].concat(),
                test: smaller,
            }
        }
        Experiment::MixedThirty | Experiment::ControlThirty => {
            let [smaller, larger, whole] = parts(real);
            let mut train = [smaller, whole].concat();
            if experiment == Experiment::MixedThirty {
                train.extend(synthetic);
            }
            RecognitionTrial {
                train,
                test: larger,
            }
        }
    }
}

/// The outcome of one trial, by person.
struct TrialOutcome {
    classes: usize,
    trained: usize,
    tested: usize,
    /// The tallies for each number of components that the samples allow.
    by_components: Vec<BTreeMap<usize, Tally>>,
    nearest: BTreeMap<usize, Tally>,
}

/// Trains and tests; people who are not in the training set are not tested.
fn judge(trial: &RecognitionTrial<'_>, augmentation: Augmentation) -> Result<Option<TrialOutcome>> {
    let mut people: Vec<usize> = trial.train.iter().map(|example| example.person).collect();
    people.sort_unstable();
    people.dedup();
    let class = |example: &Example| people.binary_search(&example.person).ok();
    let test: Vec<(&Example, usize)> = trial
        .test
        .iter()
        .filter_map(|example| class(example).map(|class| (*example, class)))
        .collect();
    if people.len() < 2 || test.is_empty() {
        return Ok(None);
    }
    let variants = augmentation.variants();
    let (mut pixels, mut labels) = (Vec::new(), Vec::new());
    for example in &trial.train {
        for &variant in &variants {
            let unit = |byte: u8| f32::from(byte) / 255.0;
            pixels.extend(varied(&example.gei, SIZE, variant).into_iter().map(unit));
            labels.extend(class(example));
        }
    }
    let samples = Array2::from_shape_vec((labels.len(), SIZE.pixels()), pixels)?;
    let analysed =
        Analysed::<f64>::analyse(Template::Gei, SIZE, samples.view(), &labels, people.len())?;
    let mut by_components = Vec::new();
    for components in COMPONENTS {
        if components >= trial.train.len() {
            break;
        }
        let learnt = analysed.fit(TrainOptions {
            components: Components::Count(components),
            method: TrainMethod::Svm { c: C },
        })?;
        let hits = test.iter().map(|(example, class)| {
            let gei: Vec<f32> = example
                .gei
                .iter()
                .map(|&it| f32::from(it) / 255.0)
                .collect();
            let scores = learnt.scores(learnt.embed(&gei).view());
            (example.person, closed_set(&scores.to_vec(), *class))
        });
        by_components.push(tallies(hits));
    }
    let nearest = test.iter().map(|(example, _)| {
        let found = trial
            .train
            .iter()
            .min_by_key(|other| apart(&example.gei, &other.gei));
        let is_own = found.is_some_and(|found| found.person == example.person);
        (
            example.person,
            if is_own {
                ProbeOutcome::Hit
            } else {
                ProbeOutcome::Miss
            },
        )
    });
    Ok(Some(TrialOutcome {
        classes: people.len(),
        trained: trial.train.len(),
        tested: test.len(),
        by_components,
        nearest: tallies(nearest),
    }))
}

/// Returns the squared distance of two GEIs.
fn apart(a: &[u8], b: &[u8]) -> u64 {
    let squares = a
        .iter()
        .zip(b)
        .map(|(a, b)| u64::from(a.abs_diff(*b)).pow(2));
    squares.sum()
}

fn tallies(outcomes: impl Iterator<Item = (usize, ProbeOutcome)>) -> BTreeMap<usize, Tally> {
    let mut tallies: BTreeMap<usize, Tally> = BTreeMap::new();
    for (person, outcome) in outcomes {
        tallies.entry(person).or_default().add(outcome);
    }
    tallies
}

#[cfg(test)]
mod tests;
