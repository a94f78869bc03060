//! Whether what is learnt of synthetic silhouettes holds of real ones, and the other way round: PCA and
//! linear support vector machines over the number of components.

use super::example::{Example, RealAndSynthetic, SIZE};
use super::likeness::mean;
use super::splits::{ExampleSplit, SplitUnit, split};
use crate::error::Result;
use crate::evaluate::bootstrap::interval_95;
use crate::evaluate::rank1::{ProbeOutcome, Tally, closed_set};
use crate::template::Template;
use crate::template::augment::{Augmentation, varied};
use crate::train::{Analysed, Components, TrainMethod, TrainOptions};
use ndarray::Array2;
use rayon::prelude::*;
use serde::Serialize;
use std::collections::BTreeMap;

/// Numbers of principal components. The paper's figure has them to the right and does not state them.
pub(crate) const COMPONENTS: [usize; 10] = [1, 2, 5, 9, 15, 20, 30, 40, 50, 60];

/// Weight of the errors; the paper does not state it.
const C: f64 = 1.0;

/// What is trained on and what is looked for: R is real, S synthetic, and 70 and 30 are percent.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub(crate) enum Experiment {
    /// 70 % of R, and the rest of it; also the control of [`Self::MixedSeventy`].
    #[serde(rename = "R-R")]
    RealReal,
    /// 70 % of S, and the rest of it.
    #[serde(rename = "S-S")]
    SyntheticSynthetic,
    /// All of R, and S.
    #[serde(rename = "R-S")]
    RealSynthetic,
    /// All of S, and R.
    #[serde(rename = "S-R")]
    SyntheticReal,
    /// 70 % of R and all of S, and the rest of R.
    #[serde(rename = "70%R+S - 30%R")]
    MixedSeventy,
    /// 30 % of R and all of S, and the rest of R.
    #[serde(rename = "30%R+S - 70%R")]
    MixedThirty,
    /// 30 % of R, and the rest of it: the control of [`Self::MixedThirty`].
    #[serde(rename = "30%R - 70%R")]
    ControlThirty,
}

impl Experiment {
    /// All of them, in the order of reports.
    pub(crate) const ALL: [Self; 7] = [
        Self::RealReal,
        Self::SyntheticSynthetic,
        Self::MixedSeventy,
        Self::MixedThirty,
        Self::ControlThirty,
        Self::SyntheticReal,
        Self::RealSynthetic,
    ];

    /// What results call it: what is trained on, and what is looked for.
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

    /// Whether nothing of it is real.
    pub(crate) const fn is_synthetic(self) -> bool {
        matches!(self, Self::SyntheticSynthetic)
    }

    /// How it parts cycles; where it does not, one of them, which changes nothing.
    pub(crate) const fn units(self) -> &'static [SplitUnit] {
        if self.is_split() {
            &[SplitUnit::Cycle, SplitUnit::Take]
        } else {
            &[SplitUnit::Cycle]
        }
    }

    /// Whether it parts cycles, so that it depends on how, and on the seed.
    pub(crate) const fn is_split(self) -> bool {
        !matches!(self, Self::RealSynthetic | Self::SyntheticReal)
    }
}

/// What is learnt and looked for.
struct RecognitionTrial<'a> {
    train: Vec<&'a Example>,
    test: Vec<&'a Example>,
}

/// How well people were told apart, with so many components.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct AccuracyPoint {
    /// Principal components.
    pub components: usize,
    /// The share of cycles whose person was found, 0..1, over all splits.
    pub accuracy: f64,
    /// Its 95 % interval, which draws people; none of fewer than two.
    pub low: Option<f64>,
    /// Its upper end.
    pub high: Option<f64>,
}

/// One experiment.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct AccuracyCurve {
    /// Which.
    pub experiment: Experiment,
    /// How cycles are parted; none where they are not.
    pub split: Option<SplitUnit>,
    /// How many splits were drawn.
    pub splits: usize,
    /// People who are told apart, and among them those who are looked for.
    pub classes: usize,
    pub people: usize,
    /// Cycles that are trained on and looked for in a split, mean.
    pub trained: f64,
    pub tested: f64,
    /// Over the number of components.
    pub points: Vec<AccuracyPoint>,
    /// The same of the nearest pixels: no components and no learning.
    pub nearest: AccuracyPoint,
    /// What guessing finds.
    pub chance: f64,
}

impl AccuracyCurve {
    /// The point of the most components.
    pub(crate) fn last(&self) -> Option<&AccuracyPoint> {
        self.points.last()
    }
}

/// Runs an experiment over splits with seeds from `seeds`, on all cores; nothing if there is nobody who
/// can be looked for, or one class alone. Only what is trained on is augmented.
///
/// # Errors
/// If nothing is learnt.
pub(crate) fn curve(
    experiment: Experiment,
    both: RealAndSynthetic<'_>,
    unit: SplitUnit,
    seeds: &[u64],
    augmentation: Augmentation,
    progress: &(dyn Fn() + Sync),
) -> Result<Option<AccuracyCurve>> {
    let seeds = if experiment.is_split() {
        seeds
    } else {
        &seeds[..1]
    };
    let one = |&seed: &u64| -> Result<Option<TrialOutcome>> {
        let trial = trial(experiment, both.real, both.synthetic, unit, seed);
        let judged = judge(&trial, augmentation)?;
        progress();
        Ok(judged)
    };
    let judged: Vec<Result<Option<TrialOutcome>>> = seeds.par_iter().map(one).collect();
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

/// What became of one trial, by person.
struct TrialOutcome {
    classes: usize,
    trained: usize,
    tested: usize,
    /// Of each number of components that the samples have.
    by_components: Vec<BTreeMap<usize, Tally>>,
    nearest: BTreeMap<usize, Tally>,
}

/// Learns and looks for; people who are not among those trained on are not looked for.
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
    let analysed = Analysed::<f64>::of(Template::Gei, SIZE, samples.view(), &labels, people.len())?;
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

/// The squared distance of two GEIs.
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
