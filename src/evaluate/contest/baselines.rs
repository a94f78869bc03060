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

/// A kind of baseline.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BaselineKind {
    /// Compares the pictures themselves, pixel by pixel.
    Pixels,
    /// Compares random projections of them, in as few numbers as the recognizer's embedding has.
    Random,
}

/// The baselines of a contest.
#[derive(Default)]
pub struct Baselines {
    /// The baselines that take part.
    pub entrants: Vec<Entrant>,
    /// The baselines that do not take part, and why.
    pub warnings: Vec<String>,
}

/// Recognizers with the same input and the same reference pictures.
struct BaselineGroup<'e> {
    first: &'e Entrant,
    /// The lengths of their embeddings, each with the first recognizer of that length.
    dims: Vec<(&'e Entrant, usize)>,
}

/// Mean pictures of each class.
struct ClassMeans {
    /// One in each row.
    templates: Array2<f32>,
    /// The class of each row.
    classes: Vec<usize>,
}

impl Contest<'_> {
    /// Returns the baselines of these kinds for recognizers: one of each kind for each group of
    /// recognizers with the same input and the same reference pictures and, if it is random, with
    /// embeddings of one length. So what a recognizer is compared with does not depend on the
    /// others. Where embeddings decide, the reference pictures are the protocol's gallery. Where
    /// class scores decide, they are the mean templates of the cycles that a recognizer was trained
    /// on, by person and viewpoint, rendered from `pack`.
    ///
    /// # Errors
    /// If a recognizer fails, or the cycles that it was trained on cannot be rendered.
    pub fn baselines(
        &self,
        entrants: &[Entrant],
        kinds: &[BaselineKind],
        pack: Option<&Pack<'_>>,
        seed: u64,
    ) -> Result<Baselines> {
        let groups = self.groups(entrants)?;
        let lengths: usize = groups.iter().map(|group| group.dims.len()).sum();
        let mut baselines = Baselines::default();
        for group in &groups {
            let first = group.first;
            let contract = first.recognizer.contract();
            let like = |what: &str, all: usize, beside: &Entrant| {
                let name = match all {
                    1 => what.to_owned(),
                    _ => format!("{what} as {}", beside.recognizer.name()),
                };
                Baseline::like(Contract {
                    name,
                    ..plain(contract)
                })
            };
            let known = match self.protocol.decision {
                Decision::NearestEmbedding => None,
                Decision::ClassScore => match known(first, pack, self.probes(contract)?)? {
                    Some(known) => Some(known),
                    None => {
                        baselines.warnings.push(format!(
                            "{}: no baselines beside it: the walks that it was trained on are not in a pack (score a pack that contains them, or use the protocol first-take)",
                            first.recognizer.name()
                        ));
                        continue;
                    }
                },
            };
            if kinds.contains(&BaselineKind::Pixels) {
                let pixels = like(PIXELS, groups.len(), first);
                match self.refusal(contract, known.as_ref())? {
                    Some(why) => baselines
                        .warnings
                        .push(format!("{}: left out: {why}", pixels.name())),
                    None => baselines.entrants.push(with(pixels, known.as_ref(), first)),
                }
            }
            if kinds.contains(&BaselineKind::Random) {
                for &(beside, dims) in &group.dims {
                    let random = like(RANDOM, lengths, beside).projected(dims, seed);
                    baselines.entrants.push(with(random, known.as_ref(), first));
                }
            }
        }
        Ok(baselines)
    }

    /// Returns the groups of recognizers that have baselines in common; baselines are in none.
    fn groups<'e>(&self, entrants: &'e [Entrant]) -> Result<Vec<BaselineGroup<'e>>> {
        let mut groups: Vec<BaselineGroup<'_>> = Vec::new();
        let learnt = entrants.iter();
        for entrant in learnt.filter(|entrant| !entrant.recognizer.is_baseline()) {
            let dims = embedding_dims(entrant.recognizer.as_ref())?;
            let dims = dims.min(entrant.recognizer.contract().numbers());
            let is_alike = |group: &&mut BaselineGroup<'_>| self.knows_alike(group.first, entrant);
            match groups.iter_mut().find(is_alike) {
                Some(group) if group.dims.iter().any(|(_, other)| *other == dims) => {}
                Some(group) => group.dims.push((entrant, dims)),
                None => groups.push(BaselineGroup {
                    first: entrant,
                    dims: vec![(entrant, dims)],
                }),
            }
        }
        Ok(groups)
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
            // Results are summed by the angle from the training viewpoints, too.
            (Decision::NearestEmbedding, GalleryViews::Training | GalleryViews::Same) => {
                a.training.viewpoints == b.training.viewpoints
            }
            (Decision::NearestEmbedding, _) => true,
        };
        is_alike && one.is_shown_as(other)
    }

    /// Returns the number of probe sequences of a recognizer.
    fn probes(&self, of: &Contract) -> Result<usize> {
        Ok(self.trial(of)?.probes().count())
    }

    /// Returns why the pixels baseline would be too expensive, if so.
    fn refusal(&self, of: &Contract, known: Option<&ClassMeans>) -> Result<Option<String>> {
        let (numbers, probes) = (of.numbers(), self.probes(of)?.max(1));
        let compared = match known {
            Some(known) => known.templates.nrows(),
            None => (self.trial(of)?.comparisons() / probes as u64) as usize,
        };
        let sequences = self.source.sequences().list.iter();
        let shown = sequences.filter(|sequence| sequence.purpose.suits(of.template));
        let kept = shown.count().saturating_mul(numbers);
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
fn plain(of: &Contract) -> Contract {
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
        Some(known) => baseline.enrolled(known.templates.view(), known.classes.clone()),
        None => baseline,
    };
    Entrant {
        recognizer: Box::new(baseline),
        settings: like.settings,
        model_bytes: None,
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
    Ok(Some(ClassMeans {
        templates: sums,
        classes,
    }))
}
