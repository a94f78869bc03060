//! Sequences of a pack's walks, which are drawn on demand.

use super::{Form, Labels, SequenceOrigin, SequencePurpose, Sequences, ShownCounts};
use crate::draw::confounders::Condition;
use crate::draw::sweep::{Job, Moments, Settings, Shot, Swept, View, jobs, silhouettes, sweep};
use crate::draw::template::Template;
use crate::error::{ChoiceError, Error, Result};
use edgegait_core::pack::Pack;
use edgegait_core::silhouette::AnySilhouette;
use rayon::prelude::*;
use serde::Deserialize;

/// Viewpoints whose silhouettes are in memory together: 5 MB for 32 frames at 64x64.
const VIEWS_AT_ONCE: usize = 37;

/// A take that is made from a walk by a seeded variation of its stored cycle.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MadeTake {
    /// The name of the take.
    pub take: String,
    /// The number of the first variation of the stored cycle; 0 is the cycle itself.
    pub variation: u32,
    /// The name of the condition, or `None` for none.
    pub condition: Option<String>,
}

/// The sequences of a pack's walks.
#[derive(Clone, Debug)]
pub struct PackWalks<'a> {
    pack: &'a Pack<'a>,
    pub(super) sequences: Sequences,
    /// The cycles, each with the number of its first sequence.
    jobs: Vec<(Job<'a>, usize)>,
}

/// The takes of walks, without viewpoints.
#[derive(Clone, Debug)]
pub struct WalkCycles<'a> {
    pack: &'a Pack<'a>,
    labels: Vec<Label>,
    jobs: Vec<Job<'a>>,
}

/// The person, walk, take and condition of a cycle.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Label {
    person: String,
    /// The walk's name and the cycle's number.
    walk: (String, u32),
    take: String,
    condition: String,
}

/// A take of a walk.
#[derive(Clone)]
struct WalkTake<'a> {
    name: String,
    variation: u32,
    condition: Option<&'a Condition>,
}

impl<'a> PackWalks<'a> {
    /// Returns the recorded cycles of the numbered walks.
    ///
    /// # Errors
    /// If a walk is an uncut motion, not a cycle.
    pub fn recorded(pack: &'a Pack<'a>, walks: &[usize]) -> Result<WalkCycles<'a>> {
        let stored = |name: &str| WalkTake {
            name: name.to_owned(),
            variation: 0,
            condition: None,
        };
        Self::cycles(pack, walks, &|name| vec![stored(name)])
    }

    /// Returns takes that are made from each of the walks, under the conditions that they name.
    ///
    /// # Errors
    /// If a walk is an uncut motion, not a cycle, or a condition is unknown.
    pub fn made(
        pack: &'a Pack<'a>,
        walks: &[usize],
        made: &[MadeTake],
        conditions: &'a [Condition],
    ) -> Result<WalkCycles<'a>> {
        let condition = |name: &String| {
            let found = conditions.iter().find(|condition| condition.name == *name);
            found.ok_or_else(|| {
                let known = conditions.iter().map(|it| it.name.clone()).collect();
                ChoiceError::NoCondition {
                    name: name.clone(),
                    known,
                }
            })
        };
        let takes: Vec<_> = made
            .iter()
            .map(|made_take| {
                Ok(WalkTake {
                    name: made_take.take.clone(),
                    variation: made_take.variation,
                    condition: made_take.condition.as_ref().map(condition).transpose()?,
                })
            })
            .collect::<Result<_>>()?;
        Self::cycles(pack, walks, &|_| takes.clone())
    }

    fn cycles(
        pack: &'a Pack<'a>,
        walks: &[usize],
        takes: &dyn Fn(&str) -> Vec<WalkTake<'a>>,
    ) -> Result<WalkCycles<'a>> {
        // Uncut motions have no cycles, and are errors.
        jobs(pack, walks, 0..1)?;
        let all: Vec<_> = pack.walks().collect();
        let names: Vec<&str> = pack.subjects().map(|subject| subject.name).collect();
        let (mut labels, mut jobs) = (Vec::new(), Vec::new());
        for &walk in walks {
            for take in takes(all[walk].name) {
                let job = Job {
                    walk,
                    variation: take.variation,
                    condition: take.condition,
                };
                labels.push(Label {
                    person: names[all[walk].subject].to_owned(),
                    walk: (all[walk].name.to_owned(), u32::from(all[walk].cycle)),
                    take: take.name,
                    condition: job.condition_name().to_owned(),
                });
                jobs.push(job);
            }
        }
        Ok(WalkCycles { pack, labels, jobs })
    }
}

impl<'a> WalkCycles<'a> {
    /// Returns whether every person has at most one take.
    #[must_use]
    pub fn are_of_one_take(&self) -> bool {
        self.labels.iter().enumerate().all(|(at, label)| {
            let before = self.labels[..at].iter();
            let other = |l: &Label| l.person == label.person && l.take != label.take;
            !before.clone().any(other)
        })
    }

    /// Repeats the takes that are `probed` under each of the conditions. Without a condition, takes
    /// stay if they are `known` (enrolled) or not probed.
    #[must_use]
    pub fn under(
        self,
        conditions: &'a [Condition],
        known: impl Fn(usize) -> bool,
        probed: impl Fn(usize) -> bool,
    ) -> Self {
        let mut numbers = Labels::default();
        let mut cycles = Self {
            pack: self.pack,
            labels: Vec::new(),
            jobs: Vec::new(),
        };
        for (label, job) in self.labels.into_iter().zip(self.jobs) {
            let take = numbers.take(&label.person, &label.take, &label.condition);
            if known(take) || !probed(take) {
                cycles.labels.push(label.clone());
                cycles.jobs.push(job);
            }
            if !probed(take) {
                continue;
            }
            for job in Job::under(&[job], conditions) {
                cycles.labels.push(Label {
                    condition: job.condition_name().to_owned(),
                    ..label.clone()
                });
                cycles.jobs.push(job);
            }
        }
        cycles
    }

    /// Returns the takes, each once, numbered as in the sequences.
    #[must_use]
    pub fn sequences(&self) -> Sequences {
        let mut labels = Labels::default();
        for Label {
            person,
            take,
            condition,
            ..
        } in &self.labels
        {
            labels.take(person, take, condition);
        }
        labels.sequences
    }

    /// Returns the sequences of the cycles from the viewpoints that `views` returns for each take.
    /// The viewpoints in `probed` are listed first; sequences from others are for the gallery only.
    /// `seed` is the seed of the variations.
    #[must_use]
    pub fn seen(
        self,
        probed: &[View],
        seed: u64,
        views: impl Fn(usize) -> Vec<View>,
    ) -> PackWalks<'a> {
        let mut labels = Labels::default();
        for &view in probed {
            labels.view(view.into());
        }
        let probed = labels.sequences.views.len();
        let mut begins = Vec::new();
        for (label, &job) in self.labels.iter().zip(&self.jobs) {
            let take = labels.take(&label.person, &label.take, &label.condition);
            let (walk, cycle) = label.walk.clone();
            let origin = labels.origin(SequenceOrigin {
                walk,
                cycle: Some(cycle),
                variation: job.variation,
                seed,
            });
            begins.push((job, labels.sequences.list.len()));
            for view in views(take) {
                let view = labels.view(view.into());
                let purpose = if view < probed {
                    SequencePurpose::Any
                } else {
                    SequencePurpose::Gallery
                };
                labels.push_for(purpose, take, origin, view);
            }
        }
        PackWalks {
            pack: self.pack,
            sequences: labels.sequences,
            jobs: begins,
        }
    }
}

/// A cycle, with the numbers and viewpoints of its requested sequences.
struct WantedCycle<'a> {
    job: Job<'a>,
    numbers: Vec<usize>,
    views: Vec<View>,
}

impl PackWalks<'_> {
    /// Groups the requested sequences by cycle.
    fn by_job(&self, wanted: &[usize]) -> Result<Vec<WantedCycle<'_>>> {
        let mut rest = wanted;
        let mut found = Vec::new();
        for (at, &(job, _)) in self.jobs.iter().enumerate() {
            let end = self.jobs.get(at + 1).map_or(usize::MAX, |next| next.1);
            let (of_job, later) = rest.split_at(rest.partition_point(|&number| number < end));
            rest = later;
            if of_job.is_empty() {
                continue;
            }
            let view = |&number: &usize| {
                let label = self.sequences.view_label(number);
                let (azimuth, elevation) = label.angles_deg().ok_or(Error::Missing("angles"))?;
                #[expect(clippy::cast_possible_truncation, reason = "it was an f32")]
                View::new(azimuth as f32, elevation as f32)
            };
            found.push(WantedCycle {
                job,
                numbers: of_job.to_vec(),
                views: of_job.iter().map(view).collect::<Result<_>>()?,
            });
        }
        Ok(found)
    }

    pub(super) fn show(
        &self,
        wanted: &[usize],
        form: &Form,
        sink: &mut dyn FnMut(usize, &[u8]) -> Result<()>,
    ) -> Result<ShownCounts> {
        let by_job = self.by_job(wanted)?;
        let frames = form.settings.frames_per_cycle;
        let shown = ShownCounts {
            silhouettes: wanted.len() as u64 * u64::from(frames),
            ..ShownCounts::default()
        };
        if form.settings.template == Template::Silhouettes {
            self.show_silhouettes(&by_job, form.settings, sink)?;
            return Ok(shown);
        }
        let (clipped, empty) = self.show_templates(&by_job, form.settings, sink)?;
        Ok(ShownCounts {
            clipped: Some(clipped),
            empty,
            ..shown
        })
    }

    fn show_templates(
        &self,
        wanted: &[WantedCycle<'_>],
        settings: Settings,
        sink: &mut dyn FnMut(usize, &[u8]) -> Result<()>,
    ) -> Result<(f64, u64)> {
        let (mut clipped, mut empty) = (0.0, 0);
        for alike in wanted.chunk_by(|a, b| a.views == b.views) {
            let jobs: Vec<Job<'_>> = alike.iter().map(|cycle| cycle.job).collect();
            let mut numbers = alike.iter().map(|cycle| &cycle.numbers);
            let keep = |_: Job<'_>, swept: Swept| Ok(swept);
            sweep(
                self.pack,
                &jobs,
                &alike[0].views,
                settings,
                keep,
                |_, swept| {
                    clipped += swept.clipped;
                    empty += swept.empty;
                    let numbers = numbers.next().into_iter().flatten();
                    for (&number, bytes) in numbers.zip(&swept.templates) {
                        sink(number, bytes)?;
                    }
                    Ok(())
                },
            )?;
        }
        Ok((clipped, empty))
    }

    /// Shows frames as the core draws them; frames with more than one bit a pixel as coverage.
    fn show_silhouettes(
        &self,
        wanted: &[WantedCycle<'_>],
        settings: Settings,
        sink: &mut dyn FnMut(usize, &[u8]) -> Result<()>,
    ) -> Result<()> {
        let parts: Vec<(Job<'_>, &[usize], &[View])> = wanted
            .iter()
            .flat_map(|cycle| {
                let parts =
                    { cycle.numbers.chunks(VIEWS_AT_ONCE) }.zip(cycle.views.chunks(VIEWS_AT_ONCE));
                parts.map(|(numbers, views)| (cycle.job, numbers, views))
            })
            .collect();
        let at_once = rayon::current_num_threads().max(1);
        for parts in parts.chunks(at_once) {
            let drawn: Vec<Result<Vec<Vec<u8>>>> = parts
                .par_iter()
                .map(|&(job, _, views)| {
                    let shot = Shot {
                        job,
                        moments: Moments::Cycle,
                        views,
                    };
                    let frames = silhouettes(self.pack, shot, settings)?;
                    let bytes = |frames: &Vec<AnySilhouette>| {
                        let coverage = frames.iter().map(AnySilhouette::to_coverage);
                        coverage.flat_map(|image| image.pixels().to_vec()).collect()
                    };
                    Ok(frames.iter().map(bytes).collect())
                })
                .collect();
            for (&(_, numbers, _), sequences) in parts.iter().zip(drawn) {
                for (&number, bytes) in numbers.iter().zip(sequences?) {
                    sink(number, &bytes)?;
                }
            }
        }
        Ok(())
    }
}
