//! Baselines: recognizers that have learnt nothing, for comparison.
//!
//! A rate means little by itself: a few pixels may suffice to distinguish people. So the same
//! probes are also compared by their pixels and by a random projection of the pixels, with the same
//! gallery pictures that the recognizers have.

use super::{Contest, Entrant, training_views};
use crate::draw::sweep::{FRAMES_PER_CYCLE, Job, View, sweep};
use crate::draw::template::Template;
use crate::error::Result;
use crate::evaluate::protocol::{Decision, GalleryViews};
use crate::inference::baseline::{Baseline, PIXELS, RANDOM};
use crate::inference::{Contract, Recognizer};
use edgegait_core::pack::Pack;
use ndarray::Array2;

/// The maximum number of multiplications of a baseline for one probe (about the cost of rendering
/// it), unless those of all probes are few (some seconds). Our choice.
const MAX_WORK: usize = 1_000_000;
const MAX_WORK_OF_ALL: usize = 10_000_000_000;
/// The maximum number of values in a baseline's answers: 256 MB.
const MAX_KEPT: usize = 1 << 26;

/// The baselines of a contest.
#[derive(Default)]
pub struct Baselines {
    /// The baselines that take part.
    pub entrants: Vec<Entrant>,
    /// The baselines that do not take part, and why.
    pub warnings: Vec<String>,
}

/// Mean pictures of each class, one per row, and the class of each row.
type ClassMeans = (Array2<f32>, Vec<usize>);

impl Contest<'_> {
    /// Returns the baselines for these recognizers: two for each group of recognizers with the same
    /// input and the same reference pictures. Where embeddings decide, the reference pictures are
    /// the protocol's gallery. Where class scores decide, they are the mean templates of the cycles
    /// that a recognizer was trained on, by person and viewpoint, rendered from `pack`.
    ///
    /// # Errors
    /// If a recognizer fails, or the cycles that it was trained on cannot be rendered.
    pub fn baselines(
        &self,
        entrants: &[Entrant],
        pack: Option<&Pack<'_>>,
        seed: u64,
    ) -> Result<Baselines> {
        let is_named = entrants
            .iter()
            .any(|entrant| entrant.recognizer.is_baseline());
        let learnt: Vec<&Entrant> = entrants
            .iter()
            .filter(|entrant| !entrant.recognizer.is_baseline())
            .collect();
        let mut firsts: Vec<&Entrant> = Vec::new();
        for &entrant in &learnt {
            if !firsts.iter().any(|first| self.knows_alike(first, entrant)) {
                firsts.push(entrant);
            }
        }
        let mut baselines = Baselines::default();
        for &first in &firsts {
            let recognizer = first.recognizer.as_ref();
            let name = |what: &str| match firsts.len() {
                1 => what.to_owned(),
                _ => format!("{what} as {}", recognizer.name()),
            };
            let known = match self.protocol.decision {
                Decision::NearestEmbedding => None,
                Decision::ClassScore => match known(first, pack, self.probes())? {
                    Some(known) => Some(known),
                    None => {
                        baselines.warnings.push(format!(
                            "{}: no baselines beside it: the walks that it was trained on are not in a pack (score a pack that contains them, or use the protocol first-take)",
                            recognizer.name()
                        ));
                        continue;
                    }
                },
            };
            let like = |what| {
                Baseline::like(Contract {
                    name: name(what),
                    ..contract(recognizer.contract())
                })
            };
            let numbers = recognizer.contract().numbers();
            if !is_named {
                match self.refusal(recognizer.contract(), known.as_ref())? {
                    Some(why) => baselines
                        .warnings
                        .push(format!("{}: left out: {why}", name(PIXELS))),
                    None => baselines
                        .entrants
                        .push(with(like(PIXELS), known.as_ref(), first)),
                }
            }
            let dims = embedding_dims(recognizer)?.min(numbers);
            let random = like(RANDOM).projected(dims, seed);
            baselines.entrants.push(with(random, known.as_ref(), first));
        }
        Ok(baselines)
    }

    /// Returns whether two recognizers have the same input and the same reference pictures.
    fn knows_alike(&self, one: &Entrant, other: &Entrant) -> bool {
        let [a, b] = [one, other].map(|entrant| entrant.recognizer.contract());
        let is_alike = match (self.protocol.decision, self.protocol.gallery_views) {
            (Decision::ClassScore, _) => {
                let of = |contract: &Contract| {
                    let mut training = contract.training.clone();
                    training.description.clear();
                    (contract.classes.clone(), training)
                };
                of(a) == of(b)
            }
            (Decision::NearestEmbedding, GalleryViews::Training) => {
                a.training.viewpoints == b.training.viewpoints
            }
            (Decision::NearestEmbedding, _) => true,
        };
        is_alike && one.is_shown_as(other)
    }

    /// Returns the number of probe sequences.
    fn probes(&self) -> usize {
        let sequences = &self.source.sequences().list;
        sequences
            .iter()
            .filter(|sequence| self.roles.is_probed(sequence.take))
            .count()
    }

    /// Returns why the pixels baseline would be too expensive, if so.
    fn refusal(&self, of: &Contract, known: Option<&ClassMeans>) -> Result<Option<String>> {
        let (numbers, probes) = (of.numbers(), self.probes().max(1));
        let compared = match known {
            Some((known, _)) => known.nrows(),
            None => (self.trial(of)?.comparisons() / probes as u64) as usize,
        };
        let kept = self.source.sequences().list.len().saturating_mul(numbers);
        let work = compared.saturating_mul(numbers);
        if work > MAX_WORK && work.saturating_mul(probes) > MAX_WORK_OF_ALL {
            return Ok(Some(format!(
                "each probe would be compared with {compared} pictures of {numbers} numbers"
            )));
        }
        Ok((known.is_none() && kept > MAX_KEPT)
            .then(|| format!("its answers would take {kept} numbers")))
    }
}

/// Returns a baseline's contract: the input and the training set of a recognizer's contract.
fn contract(of: &Contract) -> Contract {
    let usual = Contract::default();
    Contract {
        input_range: usual.input_range,
        mean: usual.mean,
        std: usual.std,
        channels: usual.channels,
        distance: usual.distance,
        outputs: usual.outputs,
        ..of.clone()
    }
}

fn with(baseline: Baseline, known: Option<&ClassMeans>, like: &Entrant) -> Entrant {
    let baseline = match known {
        Some((templates, classes)) => baseline.enrolled(templates.view(), classes.clone()),
        None => baseline,
    };
    Entrant {
        recognizer: Box::new(baseline),
        settings: like.settings,
    }
}

/// Returns the length of a recognizer's embedding, from its answer to a black image.
fn embedding_dims(recognizer: &dyn Recognizer) -> Result<usize> {
    let contract = recognizer.contract();
    let frames = match contract.template {
        Template::Silhouettes => contract.frames.unwrap_or(FRAMES_PER_CYCLE as usize),
        _ => 1,
    };
    let mut black = vec![0.0; frames * contract.input_numbers()];
    contract.feed_view(Some(contract.usual_views()[0].into()), &mut black)?;
    Ok(recognizer.run(&black, 1)?.embedding_dims)
}

/// Returns the mean templates of a recognizer's training cycles, by class and viewpoint; none if
/// `pack` does not have walks of all classes. Renders only as many variations as give no more
/// pictures than half of the probes, but at least the first.
fn known(entrant: &Entrant, pack: Option<&Pack<'_>>, probes: usize) -> Result<Option<ClassMeans>> {
    let contract = entrant.recognizer.contract();
    let training = &contract.training;
    let (Some(pack), false) = (pack, training.walks.is_empty()) else {
        return Ok(None);
    };
    let class = |walk: usize| {
        let subject = pack.walk(walk).and_then(|walk| pack.subject(walk.subject));
        let name = subject.map(|subject| subject.name);
        contract
            .classes
            .iter()
            .position(|class| Some(class.as_str()) == name)
    };
    let was_trained_on = |&walk: &usize| {
        pack.walk(walk).is_some_and(|walk| {
            let cycle = u32::from(walk.cycle);
            training.walks.iter().any(|name| name == walk.name)
                && (training.cycles.is_empty() || training.cycles.contains(&cycle))
        }) && class(walk).is_some()
    };
    let walks: Vec<usize> = (0..pack.walks().len()).filter(was_trained_on).collect();
    let is_known = |at: usize| walks.iter().any(|&walk| class(walk) == Some(at));
    if walks.is_empty() || !(0..contract.classes.len()).all(is_known) {
        return Ok(None);
    }
    let views: Vec<View> = training_views(contract)?;
    let mut variations = training.variations.clone();
    let most = probes / (2 * walks.len() * views.len());
    variations.truncate(most.max(1));
    if variations.is_empty() {
        variations.push(0);
    }
    let of_walk = |&walk: &usize| {
        variations
            .iter()
            .map(move |&variation| Job::plain(walk, variation))
    };
    let jobs: Vec<Job<'_>> = walks.iter().flat_map(of_walk).collect();
    let mut settings = entrant.settings;
    settings.seed = training.seed;
    if settings.template == Template::Silhouettes {
        settings.template = Template::Gei;
    }
    let rows = contract.classes.len() * views.len();
    let mut sums = Array2::<f32>::zeros((rows, contract.numbers()));
    let mut counts = vec![0.0; contract.classes.len()];
    sweep(
        pack,
        &jobs,
        &views,
        settings,
        |_, swept| Ok(swept.templates),
        |job, templates| {
            let Some(class) = class(job.walk) else {
                return Ok(());
            };
            counts[class] += 1.0;
            for (view, template) in templates.iter().enumerate() {
                let mut sum = sums.row_mut(class * views.len() + view);
                for (sum, &byte) in sum.iter_mut().zip(template) {
                    *sum += f32::from(byte) / 255.0;
                }
            }
            Ok(())
        },
    )?;
    let classes: Vec<usize> = (0..rows).map(|row| row / views.len()).collect();
    for (mut sum, &class) in sums.outer_iter_mut().zip(&classes) {
        sum /= counts[class];
    }
    Ok(Some((sums, classes)))
}
