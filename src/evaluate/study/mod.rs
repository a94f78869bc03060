//! The experiments of Charalambous & Bharath (BMVC 2016) on real silhouettes (R) and synthetic
//! twins (S) of the same people.
//!
//! Twins walk with the motion capture of each real walk, on bodies with each person's measurements.
//! A `manifest` pairs takes with recordings, and `plan` checks everything before any long work.
//! `similarity` compares frames, and `subspaces` principal components. `recognition` trains on one
//! and tests on the other, and `differences` measures the effect of each difference between the
//! two. Everything has 50x30 pixels, the paper's size, and each Gait Energy Image (GEI) is of one
//! cycle.

mod differences;
mod example;
mod likeness;
mod manifest;
mod masks;
mod paper_order;
mod plan;
mod real_cycles;
mod recognition;
mod similarity;
mod splits;
mod subspaces;
mod twins;

pub(crate) use differences::{BANDS, ChangeEffect, banded};
pub(crate) use example::SIZE;
pub(crate) use likeness::BoxPlot;
pub(crate) use masks::Masks;
pub(crate) use paper_order::PaperOrder;
pub(crate) use plan::{Paths, StudyPlan};
pub(crate) use recognition::{AccuracyCurve, Experiment};
pub(crate) use similarity::{Overlay, Similarity, SimilarityGroup};
pub(crate) use splits::SplitUnit;
pub(crate) use subspaces::ComparedSubspaces;

use crate::draw::confounders::Doses;
use crate::draw::confounders::{Condition, dose};
use crate::draw::sweep::{FramingMode, View};
use crate::draw::template::augment::{Augmentation, Crops};
use crate::error::{Error, Result};
use crate::people::measured::MeasuredPeople;
use example::{Example, RealAndSynthetic, StudySetting};
use likeness::{mean, shifted};
use serde::Serialize;
use similarity::mean_likeness;
use twins::{Twins, Walkers};

/// The settings that a study varies.
#[derive(Clone, Debug)]
pub(crate) struct Choices {
    /// The masks of real people.
    pub masks: Vec<Masks>,
    /// The framings of figures; parts 1 and 2 use the first.
    pub framings: Vec<FramingMode>,
    /// The augmentations of the training set.
    pub augmentations: Vec<Augmentation>,
    /// The seeds of the splits.
    pub seeds: Vec<u64>,
}

impl Choices {
    /// Returns given and segmented masks, framing by height, and `splits` splits from a seed on.
    pub(crate) fn usual(seed: u64, splits: u32) -> Self {
        Self {
            masks: vec![Masks::Given, Masks::Segmented],
            framings: vec![FramingMode::Height],
            augmentations: vec![Augmentation::default()],
            seeds: (0..u64::from(splits))
                .map(|at| seed.wrapping_add(at))
                .collect(),
        }
    }

    /// Returns all masks, both framings, and training with and without the paper's flips and crops.
    pub(crate) fn full(seed: u64, splits: u32) -> Self {
        Self {
            masks: vec![Masks::Given, Masks::Segmented, Masks::Degraded],
            framings: vec![FramingMode::Height, FramingMode::Box],
            augmentations: vec![
                Augmentation::default(),
                Augmentation {
                    flip: true,
                    crops: Some(Crops::default()),
                },
            ],
            ..Self::usual(seed, splits)
        }
    }
}

/// The result of one setting of part 3.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Recognition {
    /// The view's name.
    pub view: String,
    /// The name of the masks.
    pub masks: &'static str,
    /// The name of the framing.
    pub framing: &'static str,
    /// Whether the training set also has flipped and cropped GEIs.
    pub augmented: bool,
    /// The experiment.
    #[serde(flatten)]
    pub curve: AccuracyCurve,
}

/// The numbers of cycles of a view.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct CycleCounts {
    /// The view's name.
    pub view: String,
    /// The name of the masks.
    pub masks: &'static str,
    /// The number of real cycles.
    pub real: usize,
    /// The number of twins' cycles.
    pub synthetic: usize,
    /// The mean Jaccard index of the masks with the stored masks of the tree; none without real
    /// takes.
    pub mask_jaccard: Option<f64>,
    /// The mean Jaccard index of the worst take.
    pub worst_mask_jaccard: Option<f64>,
    /// The takes without a cycle, and the reasons.
    pub without: Vec<String>,
}

/// The results of a study.
#[derive(Clone, Debug, Default, Serialize)]
pub(crate) struct Findings {
    /// The names of the people.
    pub people: Vec<String>,
    /// The numbers of cycles.
    pub counts: Vec<CycleCounts>,
    /// The results of part 1.
    pub similarity: Vec<Similarity>,
    /// The results of part 2.
    pub subspaces: Vec<ComparedSubspaces>,
    /// The results of part 3.
    pub recognition: Vec<Recognition>,
    /// The order of the results compared with the paper's.
    pub orders: Vec<PaperOrder>,
    /// The effects of the differences between S and R.
    pub prices: Vec<ChangeEffect>,
    /// Warnings for the user.
    #[serde(skip)]
    pub warnings: Vec<String>,
}

/// The changes of twins that are measured, by their names in reports: features that real people
/// have and twins lack, and effects of cameras and segmentation.
const CHANGES: [(&str, &str); 11] = [
    ("a cap of hair, half as full", "hair=0.5"),
    ("hair to the shoulder blades", "hair=1"),
    ("shoes", "shoes=1"),
    ("trousers wider by half of wide ones", "wide-trousers=0.5"),
    ("a coat of half its thickness", "coat=0.5"),
    ("clothes: an outline 1 cm wider", "dilation=1cm"),
    ("an outline 1 cm tighter", "erosion=1cm"),
    ("a camera rolled by 2 degrees", "roll=2deg"),
    ("a camera rolled by 5 degrees", "roll=5deg"),
    (
        "noise: 2 % of the samples turned over",
        "salt-and-pepper=2%",
    ),
    (
        "light: bad light through segmentation, a third",
        "light=0.33",
    ),
];

/// The numbers of takes of each person of the built-in cohort, and of cycles of each take.
const COHORT_TAKES: u32 = 3;
const COHORT_CYCLES: u32 = 3;

/// Returns about how often [`run`] calls `progress`.
pub(crate) fn steps(plan: &StudyPlan, choices: &Choices) -> usize {
    let Choices {
        masks,
        framings,
        augmentations,
        seeds,
    } = choices;
    let splits = |one: Experiment| one.units().len() * if one.is_split() { seeds.len() } else { 1 };
    let of_masks = |number| experiments(number).map(splits).sum::<usize>();
    let all_masks: usize = (0..masks.len()).map(of_masks).sum();
    let curves = plan.views.len() * framings.len() * augmentations.len() * all_masks;
    plan.sources.len() + plan.shown.len() * masks.len() + curves
}

/// Runs a study on all cores.
///
/// # Errors
/// If a file is broken, a figure cannot be drawn, or training fails.
pub(crate) fn run(
    plan: &StudyPlan,
    choices: &Choices,
    progress: &(dyn Fn() -> Result<()> + Sync),
) -> Result<Findings> {
    let mut findings = Findings {
        people: plan.people.clone(),
        warnings: plan.warnings.clone(),
        ..Findings::default()
    };
    let walkers = Walkers::read(&plan.sources, &plan.people, progress)?;
    findings.warnings.extend(walkers.warnings.iter().cloned());
    let estimated = MeasuredPeople::default();
    let bodies = plan.bodies.as_ref().unwrap_or(&estimated);
    let twins = walkers.with_bodies(bodies, 0.0)?;
    let others = other_twins(&walkers, bodies, plan.dressed.as_ref())?;
    for seen in &plan.views {
        let (view, distance_m) = (seen.view, seen.distance_m);
        let shown: Vec<_> = plan
            .shown
            .iter()
            .filter(|shown| shown.pairing.view == seen.name)
            .collect();
        let framings = with_box(&choices.framings);
        let synthetic: Vec<Vec<Example>> = framings
            .iter()
            .map(|framing| twins.draw(view, distance_m, *framing, None))
            .collect::<Result<_>>()?;
        for (number, &masks) in choices.masks.iter().enumerate() {
            let seed = choices.seeds.first().copied().unwrap_or(1);
            let real = real_cycles::read(&plan.tree, &shown, masks, seed, &framings, progress)?;
            findings.counts.push(CycleCounts {
                view: seen.name.clone(),
                masks: masks.name(),
                real: real.by_framing.first().map_or(0, Vec::len),
                synthetic: synthetic.first().map_or(0, Vec::len),
                mask_jaccard: (!real.mask_jaccards.is_empty()).then(|| mean(&real.mask_jaccards)),
                worst_mask_jaccard: real.mask_jaccards.iter().copied().reduce(f64::min),
                without: real.without.clone(),
            });
            for ((framing, real), synthetic) in choices
                .framings
                .iter()
                .zip(&real.by_framing)
                .zip(&synthetic)
            {
                let setting = StudySetting {
                    view: &seen.name,
                    masks: masks.name(),
                    framing: framing.name(),
                };
                let both = RealAndSynthetic { real, synthetic };
                let found = Similarity::compare(setting, both, &plan.people);
                findings.similarity.push(found);
                for &augmentation in &choices.augmentations {
                    let found = recognized(
                        setting,
                        both,
                        experiments(number),
                        augmentation,
                        &choices.seeds,
                        progress,
                    )?;
                    findings.recognition.extend(found);
                }
            }
            if number > 0 {
                continue;
            }
            let (real_all, synthetic_all) = (&real.by_framing, &synthetic);
            let (Some(real), Some(synthetic)) = (real_all.first(), synthetic_all.first()) else {
                continue;
            };
            let both = RealAndSynthetic { real, synthetic };
            findings
                .subspaces
                .extend(ComparedSubspaces::compare(&seen.name, real, synthetic)?);
            let priced = prices(seen, both, &twins, &others, choices)?;
            findings.prices.extend(priced);
            if let Some((real, synthetic)) = real_all.last().zip(synthetic_all.last()) {
                let jaccard = mean_likeness(real, synthetic);
                let both = RealAndSynthetic { real, synthetic };
                let price =
                    ChangeEffect::measure(&seen.name, "both framed by box", both, jaccard, seed)?;
                findings.prices.extend(price);
            }
        }
    }
    findings.orders = paper_order::orders(&findings.recognition);
    Ok(findings)
}

/// Returns the experiments for the masks of this number. The experiment without real data does not
/// depend on masks and runs only with the first.
fn experiments(masks: usize) -> impl Iterator<Item = Experiment> {
    let all = Experiment::ALL.into_iter();
    all.filter(move |experiment| masks == 0 || !experiment.is_synthetic())
}

/// Returns these framings with that by box at the end, whose effect is measured against the first.
fn with_box(framings: &[FramingMode]) -> Vec<FramingMode> {
    let others = framings
        .iter()
        .copied()
        .filter(|&one| one != FramingMode::Box);
    others.chain([FramingMode::Box]).collect()
}

/// Makes twins with other bodies or with trunks that lean further ahead.
fn other_twins(
    walkers: &Walkers,
    bodies: &MeasuredPeople,
    dressed: Option<&MeasuredPeople>,
) -> Result<Vec<(&'static str, Twins)>> {
    let begins = |starts: &'static [&str]| {
        bodies.without(|name| starts.iter().any(|start| name.starts_with(start)))
    };
    let mut all = Vec::new();
    if *bodies != MeasuredPeople::default() {
        all.push((
            "bodies without any measurement",
            MeasuredPeople::default(),
            0.0,
        ));
        all.push((
            "only stature, mass and sex measured",
            bodies.without(|_| true),
            0.0,
        ));
        all.push((
            "hands and feet not measured",
            begins(&["hand_", "foot_"]),
            0.0,
        ));
        all.push(("heads not measured", begins(&["head_", "tragion_"]), 0.0));
    }
    all.extend(dressed.map(|it| ("bodies measured with clothes and hair", it.clone(), 0.0)));
    all.push((
        "trunks that lean further ahead by 2 degrees",
        bodies.clone(),
        2.0,
    ));
    all.push((
        "trunks that lean further ahead by 4 degrees",
        bodies.clone(),
        4.0,
    ));
    let twins = all.into_iter().map(|(name, bodies, lean_deg)| {
        let twins = walkers.with_bodies(&bodies, lean_deg)?;
        Ok((name, twins))
    });
    twins.collect()
}

/// Runs only the synthetic part, on the built-in cohort seen from these viewpoints, which are named
/// by their azimuths: principal components and recognition.
///
/// # Errors
/// If a figure cannot be drawn or training fails.
pub(crate) fn run_synthetic(
    azimuths_deg: &[f32],
    distance_m: f64,
    choices: &Choices,
    progress: &(dyn Fn() -> Result<()> + Sync),
) -> Result<Findings> {
    let (twins, people) = Twins::of_cohort(COHORT_TAKES, COHORT_CYCLES, progress)?;
    let mut findings = Findings {
        people,
        ..Findings::default()
    };
    for &azimuth in azimuths_deg {
        let (name, view) = (format!("{azimuth:03}"), View::new(azimuth, 0.0)?);
        for (number, &framing) in choices.framings.iter().enumerate() {
            let synthetic = twins.draw(view, distance_m, framing, None)?;
            for &augmentation in &choices.augmentations {
                let both = RealAndSynthetic {
                    real: &[],
                    synthetic: &synthetic,
                };
                let setting = StudySetting {
                    view: &name,
                    masks: Masks::Given.name(),
                    framing: framing.name(),
                };
                let found = recognized(
                    setting,
                    both,
                    experiments(0),
                    augmentation,
                    &choices.seeds,
                    progress,
                )?;
                findings.recognition.extend(found);
            }
            if number > 0 {
                continue;
            }
            findings
                .subspaces
                .extend(ComparedSubspaces::compare(&name, &synthetic, &synthetic)?);
            findings.counts.push(CycleCounts {
                view: name.clone(),
                masks: Masks::Given.name(),
                real: 0,
                synthetic: synthetic.len(),
                mask_jaccard: None,
                worst_mask_jaccard: None,
                without: Vec::new(),
            });
        }
    }
    Ok(findings)
}

/// Runs these experiments under one setting.
fn recognized(
    setting: StudySetting<'_>,
    both: RealAndSynthetic<'_>,
    experiments: impl Iterator<Item = Experiment>,
    augmentation: Augmentation,
    seeds: &[u64],
    progress: &(dyn Fn() -> Result<()> + Sync),
) -> Result<Vec<Recognition>> {
    let mut found = Vec::new();
    for experiment in experiments {
        for &unit in experiment.units() {
            let curve = recognition::curve(experiment, both, unit, seeds, augmentation, progress)?;
            found.extend(curve.map(|curve| Recognition {
                view: setting.view.to_owned(),
                masks: setting.masks,
                framing: setting.framing,
                augmented: augmentation != Augmentation::default(),
                curve,
            }));
        }
    }
    Ok(found)
}

/// Measures the effects of the differences between twins and real people, from one viewpoint.
fn prices(
    seen: &plan::StudyView,
    both: RealAndSynthetic<'_>,
    twins: &Twins,
    others: &[(&str, Twins)],
    choices: &Choices,
) -> Result<Vec<ChangeEffect>> {
    let (Some(&seed), Some(&framing)) = (choices.seeds.first(), choices.framings.first()) else {
        return Err(Error::Missing("a seed and a framing"));
    };
    let RealAndSynthetic { real, synthetic } = both;
    let (view, distance_m) = (seen.view, seen.distance_m);
    let mut prices = Vec::new();
    let mut add = |change: &str, own: Option<f64>, changed: &[Example]| -> Result<()> {
        let jaccard = mean_likeness(real, changed);
        let price = ChangeEffect::measure(
            &seen.name,
            change,
            RealAndSynthetic {
                real,
                synthetic: changed,
            },
            jaccard,
            seed,
        )?;
        prices.extend(price.map(|price| ChangeEffect { own, ..price }));
        Ok(())
    };
    add("as they are", None, synthetic)?;
    for (name, twins) in others {
        add(name, None, &twins.draw(view, distance_m, framing, None)?)?;
    }
    for (name, written) in CHANGES {
        let dose = dose(written).map_err(Error::Usage)?;
        let condition = Condition::from_doses(Doses::new([dose]));
        let changed = twins.draw(view, distance_m, framing, Some(&condition))?;
        add(name, Some(own(synthetic, &changed)), &changed)?;
    }
    let right = |example: &Example| example.with_frames(|frame| shifted(frame, 1, 0));
    let moved: Vec<Example> = synthetic.iter().map(right).collect();
    add(
        "a shift of one column",
        Some(own(synthetic, &moved)),
        &moved,
    )?;
    prices.extend(differences::shared(&seen.name, real, synthetic, seed)?);
    Ok(prices)
}

/// Returns the mean Jaccard index of frames before and after a change.
fn own(before: &[Example], after: &[Example]) -> f64 {
    let frames = before.iter().zip(after).flat_map(|(before, after)| {
        let pairs = before.frames.iter().zip(&after.frames);
        pairs.map(|((_, before), (_, after))| f64::from(before.jaccard(after)))
    });
    mean(&frames.collect::<Vec<_>>())
}
