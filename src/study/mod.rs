//! The experiments of Charalambous & Bharath (BMVC 2016) on real silhouettes (R) and on synthetic twins (S)
//! of the same people.
//!
//! Twins walk by the motion capture of each real walk, on bodies of each person's measurements. A `manifest`
//! says which take shows which recording, and `plan` checks all of it before any long work. `similarity`
//! compares frames, `subspaces` principal components, `recognition` what is learnt of one with what the
//! other shows, and `differences` says what separates the two, and at which price. Everything is of 50x30
//! pixels, the paper's size, and each Gait Energy Image (GEI) is of one cycle.

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

pub(crate) use differences::{BANDS, Price, banded};
pub(crate) use example::SIZE;
pub(crate) use likeness::BoxPlot;
pub(crate) use masks::Masks;
pub(crate) use paper_order::PaperOrder;
pub(crate) use plan::{Paths, StudyPlan};
pub(crate) use recognition::{AccuracyCurve, Experiment};
pub(crate) use similarity::{Overlay, Similarity, SimilarityGroup};
pub(crate) use splits::SplitUnit;
pub(crate) use subspaces::ComparedSubspaces;

use crate::confounders::Doses;
use crate::confounders::{Condition, dose};
use crate::error::{Error, Result};
use crate::people::measured::MeasuredPeople;
use crate::sweep::{FramingMode, View};
use crate::template::augment::{Augmentation, Crops};
use example::{Example, RealAndSynthetic, StudySetting};
use likeness::{mean, shifted};
use serde::Serialize;
use similarity::mean_likeness;
use twins::{Twins, Walkers};

/// What is varied.
#[derive(Clone, Debug)]
pub(crate) struct Choices {
    /// Which masks of real people.
    pub masks: Vec<Masks>,
    /// How figures are framed; the first is that of parts 1 and 2.
    pub framings: Vec<FramingMode>,
    /// What is trained on besides the GEIs themselves.
    pub augmentations: Vec<Augmentation>,
    /// Seeds of the splits.
    pub seeds: Vec<u64>,
}

impl Choices {
    /// Given and segmented masks, by height, and so many splits from a seed on.
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

    /// All masks, both framings, and with and without the paper's flips and crops.
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

/// One setting of part 3.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Recognition {
    /// The view's name.
    pub view: String,
    /// What the masks are called.
    pub masks: &'static str,
    /// What the framing is called.
    pub framing: &'static str,
    /// Whether what is trained on is flipped and cropped besides.
    pub augmented: bool,
    /// The experiment.
    #[serde(flatten)]
    pub curve: AccuracyCurve,
}

/// How many cycles there are of a view.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct CycleCounts {
    /// The view's name.
    pub view: String,
    /// What the masks are called.
    pub masks: &'static str,
    /// Real cycles.
    pub real: usize,
    /// Those of twins.
    pub synthetic: usize,
    /// Mean Jaccard index of the masks with those of the tree, as they are stored, and that of the worst
    /// take; none without real takes.
    pub mask_jaccard: Option<f64>,
    pub worst_mask_jaccard: Option<f64>,
    /// Takes without a cycle, and why.
    pub without: Vec<String>,
}

/// What a study found.
#[derive(Clone, Debug, Default, Serialize)]
pub(crate) struct Findings {
    /// Names of the people.
    pub people: Vec<String>,
    /// Cycles.
    pub counts: Vec<CycleCounts>,
    /// Part 1.
    pub similarity: Vec<Similarity>,
    /// Part 2.
    pub subspaces: Vec<ComparedSubspaces>,
    /// Part 3.
    pub recognition: Vec<Recognition>,
    /// The paper's order beside it.
    pub orders: Vec<PaperOrder>,
    /// What separates S from R.
    pub prices: Vec<Price>,
    /// What a user should know.
    pub warnings: Vec<String>,
}

/// Changes of twins that are priced, as a report calls them: what real people have and twins have not, and
/// what cameras and segmentation do.
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

/// How many takes and cycles each person of the built-in cohort has.
const COHORT: (u32, u32) = (3, 3);

/// How often `progress` is called by [`run`], about.
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
/// For files that are broken, and what cannot be drawn or learnt.
pub(crate) fn run(
    plan: &StudyPlan,
    choices: &Choices,
    progress: &(dyn Fn() + Sync),
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
        let camera = (seen.view, seen.distance_m);
        let shown: Vec<_> = plan
            .shown
            .iter()
            .filter(|shown| shown.pairing.view == seen.name)
            .collect();
        let framings = with_box(&choices.framings);
        let synthetic: Vec<Vec<Example>> = framings
            .iter()
            .map(|framing| twins.seen(camera, *framing, None))
            .collect::<Result<_>>()?;
        for (number, &masks) in choices.masks.iter().enumerate() {
            let seed = choices.seeds.first().copied().unwrap_or(1);
            let real = real_cycles::read(&plan.tree, &shown, (masks, seed), &framings, progress)?;
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
                let found = Similarity::of(setting, both, &plan.people);
                findings.similarity.push(found);
                for &augmentation in &choices.augmentations {
                    let found = recognized(
                        setting,
                        both,
                        experiments(number),
                        (augmentation, &choices.seeds),
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
                .extend(ComparedSubspaces::of(&seen.name, real, synthetic)?);
            let priced = prices(seen, both, &twins, &others, choices)?;
            findings.prices.extend(priced);
            if let Some((real, synthetic)) = real_all.last().zip(synthetic_all.last()) {
                let jaccard = mean_likeness(real, synthetic);
                let both = RealAndSynthetic { real, synthetic };
                let price = Price::of(&seen.name, "both framed by box", both, jaccard, seed)?;
                findings.prices.extend(price);
            }
        }
    }
    findings.orders = paper_order::orders(&findings.recognition);
    Ok(findings)
}

/// The experiments with masks of this number: what is synthetic on both sides does not depend on them, and
/// goes with the first.
fn experiments(masks: usize) -> impl Iterator<Item = Experiment> {
    let all = Experiment::ALL.into_iter();
    all.filter(move |one| masks == 0 || !one.is_synthetic())
}

/// These framings and, at the end, by box, which is priced beside the first.
fn with_box(framings: &[FramingMode]) -> Vec<FramingMode> {
    let others = framings
        .iter()
        .copied()
        .filter(|&one| one != FramingMode::Box);
    others.chain([FramingMode::Box]).collect()
}

/// Twins with other bodies and another carriage.
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

/// The synthetic part alone, of the built-in cohort seen from these viewpoints, named by their azimuths:
/// principal components, how well people are told apart, and what changes do to silhouettes.
///
/// # Errors
/// For what cannot be drawn or learnt.
pub(crate) fn run_synthetic(
    azimuths_deg: &[f32],
    distance_m: f64,
    choices: &Choices,
    progress: &(dyn Fn() + Sync),
) -> Result<Findings> {
    let (twins, people) = Twins::of_cohort(COHORT, progress)?;
    let mut findings = Findings {
        people,
        ..Findings::default()
    };
    for &azimuth in azimuths_deg {
        let (name, view) = (format!("{azimuth:03}"), View::new(azimuth, 0.0)?);
        let camera = (view, distance_m);
        for (number, &framing) in choices.framings.iter().enumerate() {
            let synthetic = twins.seen(camera, framing, None)?;
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
                    (augmentation, &choices.seeds),
                    progress,
                )?;
                findings.recognition.extend(found);
            }
            if number > 0 {
                continue;
            }
            findings
                .subspaces
                .extend(ComparedSubspaces::of(&name, &synthetic, &synthetic)?);
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

/// These experiments under one setting.
fn recognized(
    setting: StudySetting<'_>,
    both: RealAndSynthetic<'_>,
    experiments: impl Iterator<Item = Experiment>,
    (augmentation, seeds): (Augmentation, &[u64]),
    progress: &(dyn Fn() + Sync),
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

/// What separates twins from real people, seen from one viewpoint.
fn prices(
    seen: &plan::StudyView,
    both: RealAndSynthetic<'_>,
    twins: &Twins,
    others: &[(&str, Twins)],
    choices: &Choices,
) -> Result<Vec<Price>> {
    let (Some(&seed), Some(&framing)) = (choices.seeds.first(), choices.framings.first()) else {
        return Err(Error::Missing("a seed and a framing"));
    };
    let RealAndSynthetic { real, synthetic } = both;
    let camera = (seen.view, seen.distance_m);
    let mut prices = Vec::new();
    let mut add = |change: &str, (own, changed): (Option<f64>, &[Example])| -> Result<()> {
        let jaccard = mean_likeness(real, changed);
        let price = Price::of(
            &seen.name,
            change,
            RealAndSynthetic {
                real,
                synthetic: changed,
            },
            jaccard,
            seed,
        )?;
        prices.extend(price.map(|price| Price { own, ..price }));
        Ok(())
    };
    add("as they are", (None, synthetic))?;
    for (name, twins) in others {
        add(name, (None, &twins.seen(camera, framing, None)?))?;
    }
    for (name, written) in CHANGES {
        let dose = dose(written).map_err(Error::Usage)?;
        let condition = Condition::of(Doses::new([dose]));
        let changed = twins.seen(camera, framing, Some(&condition))?;
        add(name, (Some(own(synthetic, &changed)), &changed))?;
    }
    let right = |example: &Example| example.with_frames(|frame| shifted(frame, 1, 0));
    let moved: Vec<Example> = synthetic.iter().map(right).collect();
    add(
        "a shift of one column",
        (Some(own(synthetic, &moved)), &moved),
    )?;
    prices.extend(differences::shared(&seen.name, real, synthetic, seed)?);
    Ok(prices)
}

/// The mean Jaccard index of frames before and after a change.
fn own(before: &[Example], after: &[Example]) -> f64 {
    let frames = before.iter().zip(after).flat_map(|(before, after)| {
        let pairs = before.frames.iter().zip(&after.frames);
        pairs.map(|((_, before), (_, after))| f64::from(before.jaccard(after)))
    });
    mean(&frames.collect::<Vec<_>>())
}
