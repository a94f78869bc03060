//! Sequences of a pack's walks, drawn when they are wanted.

use super::{Form, Labels, Sequences, Shown};
use crate::error::Result;
use crate::score::Template;
use crate::sweep::{Job, Moments, Settings, Shot, Swept, View, jobs, silhouettes, sweep};
use edgegait_core::pack::Pack;
use edgegait_core::silhouette::Frame;
use edgegait_core::template::Gei;
use rayon::prelude::*;
use serde::Deserialize;

/// Viewpoints of which silhouettes are kept at once: 5 MB of 32 frames at 64x64.
const VIEWS_AT_ONCE: usize = 37;

/// A take that a made walk stands for: cycles that differ from the stored one by a seed.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Made {
    /// What the take is called.
    pub take: String,
    /// Which variation of the stored cycle it begins with; 0 is that cycle itself.
    pub cycle: u32,
}

/// Which sequences of a pack there are.
#[derive(Clone, Debug)]
pub struct Walks<'a> {
    pack: &'a Pack<'a>,
    pub(super) sequences: Sequences,
    /// The cycles, and where the sequences of each begin.
    jobs: Vec<(Job, usize)>,
}

/// The takes of walks, before it is said from where each is seen.
#[derive(Clone, Debug)]
pub struct Cycles<'a> {
    pack: &'a Pack<'a>,
    labels: Vec<(String, String)>,
    jobs: Vec<Job>,
}

impl<'a> Walks<'a> {
    /// The recorded cycles of the walks of these numbers.
    ///
    /// # Errors
    /// If one of them is a whole take, not a cycle.
    pub fn recorded(pack: &'a Pack<'a>, walks: &[usize]) -> Result<Cycles<'a>> {
        Self::cycles(pack, walks, &|name| vec![(name.to_owned(), 0)])
    }

    /// Takes made of each of the walks.
    ///
    /// # Errors
    /// If one of them is a whole take, not a cycle.
    pub fn made(pack: &'a Pack<'a>, walks: &[usize], made: &[Made]) -> Result<Cycles<'a>> {
        let all = |_: &str| {
            made.iter()
                .map(|one| (one.take.clone(), one.cycle))
                .collect()
        };
        Self::cycles(pack, walks, &all)
    }

    fn cycles(
        pack: &'a Pack<'a>,
        walks: &[usize],
        takes: &dyn Fn(&str) -> Vec<(String, u32)>,
    ) -> Result<Cycles<'a>> {
        // Refuses what has no cycles.
        jobs(pack, walks, 0..1)?;
        let all: Vec<_> = pack.walks().collect();
        let names: Vec<&str> = pack.subjects().map(|subject| subject.name).collect();
        let (mut labels, mut jobs) = (Vec::new(), Vec::new());
        for &walk in walks {
            for (take, cycle) in takes(all[walk].name) {
                labels.push((names[all[walk].subject].to_owned(), take));
                jobs.push(Job { walk, cycle });
            }
        }
        Ok(Cycles { pack, labels, jobs })
    }
}

impl<'a> Cycles<'a> {
    /// Whether no person has more than one take.
    #[must_use]
    pub fn are_of_one_take(&self) -> bool {
        self.labels.iter().enumerate().all(|(at, (person, take))| {
            let before = self.labels[..at].iter();
            before.clone().all(|(p, t)| p != person || t == take)
        })
    }

    /// The takes, each once, in order, as the sequences will number them.
    #[must_use]
    pub fn sequences(&self) -> Sequences {
        let mut labels = Labels::default();
        for (person, take) in &self.labels {
            labels.take(person, take, "");
        }
        labels.sequences
    }

    /// The cycles seen from the viewpoints that `views` gives for each take; of a take without any
    /// there is no sequence. Those of `first` are listed first.
    #[must_use]
    pub fn seen(self, first: &[View], views: impl Fn(usize) -> Vec<View>) -> Walks<'a> {
        let mut labels = Labels::default();
        for view in first {
            labels.view(view.angles_deg());
        }
        let mut counts: Vec<u32> = Vec::new();
        let mut begins = Vec::new();
        for ((person, take), &job) in self.labels.iter().zip(&self.jobs) {
            let take = labels.take(person, take, "");
            counts.resize(counts.len().max(take + 1), 0);
            begins.push((job, labels.sequences.list.len()));
            for view in views(take) {
                let view = labels.view(view.angles_deg());
                labels.push(take, counts[take], view);
            }
            counts[take] += 1;
        }
        Walks {
            pack: self.pack,
            sequences: labels.sequences,
            jobs: begins,
        }
    }
}

/// A cycle, and the sequences that are wanted of it with their viewpoints.
type Wanted = (Job, Vec<usize>, Vec<View>);

impl Walks<'_> {
    /// What is wanted of each cycle.
    fn by_job(&self, wanted: &[usize]) -> Result<Vec<Wanted>> {
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
                let (azimuth, elevation) = self.sequences.angles(number);
                #[expect(clippy::cast_possible_truncation, reason = "it was an f32")]
                View::new(azimuth as f32, elevation as f32)
            };
            let views = of_job.iter().map(view).collect::<Result<_>>()?;
            found.push((job, of_job.to_vec(), views));
        }
        Ok(found)
    }

    pub(super) fn show(
        &self,
        wanted: &[usize],
        form: &Form,
        sink: &mut dyn FnMut(usize, &[u8]) -> Result<()>,
    ) -> Result<Shown> {
        let by_job = self.by_job(wanted)?;
        let clipped = match form.template {
            Template::Gei => self.show_geis(&by_job, form.settings, sink)?,
            Template::Silhouettes => self.show_silhouettes(&by_job, form.settings, sink)?,
        };
        let frames = form.settings.frames_per_cycle;
        Ok(Shown {
            silhouettes: wanted.len() as u64 * u64::from(frames),
            clipped,
            empty: 0,
        })
    }

    fn show_geis(
        &self,
        wanted: &[Wanted],
        settings: Settings,
        sink: &mut dyn FnMut(usize, &[u8]) -> Result<()>,
    ) -> Result<Option<f64>> {
        let mut clipped = 0.0;
        for alike in wanted.chunk_by(|a, b| a.2 == b.2) {
            let jobs: Vec<Job> = alike.iter().map(|(job, ..)| *job).collect();
            let mut numbers = alike.iter().map(|(_, numbers, _)| numbers);
            let keep = |_: Job, swept: Swept| Ok(swept);
            sweep(self.pack, &jobs, &alike[0].2, settings, keep, |_, swept| {
                clipped += swept.clipped;
                let numbers = numbers.next().into_iter().flatten();
                for (&number, gei) in numbers.zip(swept.geis.iter().map(Gei::pixels)) {
                    sink(number, gei)?;
                }
                Ok(())
            })?;
        }
        Ok(Some(clipped))
    }

    /// Frames as they come from the core: coverage of those that have more than a bit a pixel.
    fn show_silhouettes(
        &self,
        wanted: &[Wanted],
        settings: Settings,
        sink: &mut dyn FnMut(usize, &[u8]) -> Result<()>,
    ) -> Result<Option<f64>> {
        let parts: Vec<(Job, &[usize], &[View])> = wanted
            .iter()
            .flat_map(|(job, numbers, views)| {
                let parts = numbers
                    .chunks(VIEWS_AT_ONCE)
                    .zip(views.chunks(VIEWS_AT_ONCE));
                parts.map(|(numbers, views)| (*job, numbers, views))
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
                    let bytes = |frames: &Vec<Frame>| {
                        let coverage = frames.iter().map(Frame::to_coverage);
                        coverage.flat_map(|one| one.pixels().to_vec()).collect()
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
        Ok(None)
    }
}
