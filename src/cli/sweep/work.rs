//! The work of a sweep, in pieces.

use crate::cli::args::Common;
use crate::cli::export::take_name;
use crate::cli::progress::Progress;
use crate::dataset::{DatasetWriter, IndexRow, Item};
use crate::draw::sweep::{
    DrawingRequest, Job, Settings, Swept, View, Wanted, is_uncut, sweep_each,
};
use crate::draw::template::augment::{Variant, varied};
use crate::error::Result;
use crate::files::hex;
use crate::people::variation::CYCLES_OF_A_TAKE;
use edgegait_core::pack::Pack;
use sha2::{Digest as _, Sha256};
use std::ops::Range;

/// Number of cycles in a list of jobs: enough for all cores, in 48 kB.
const CYCLES_AT_ONCE: usize = 2_048;

/// Groups consecutive jobs of one walk of one person under one condition: a recording, which is one
/// sequence for each viewpoint in a tree.
pub(super) fn grouped(pack: &Pack<'_>, firsts: &[Job<'_>]) -> Vec<Range<usize>> {
    let walks: Vec<_> = pack.walks().collect();
    let key = |job: &Job<'_>| {
        let walk = walks[job.walk];
        (job.condition_name().to_owned(), walk.subject, walk.name)
    };
    let mut groups: Vec<Range<usize>> = Vec::new();
    for (at, job) in firsts.iter().enumerate() {
        match groups.last_mut() {
            Some(last) if key(&firsts[last.start]) == key(job) => last.end = at + 1,
            _ => groups.push(at..at + 1),
        }
    }
    groups
}

/// The input and settings of a sweep.
pub(super) struct SweepWork<'w> {
    pub common: &'w Common,
    pub pack: &'w Pack<'w>,
    /// The ranges of [`Self::firsts`] that are one piece of work each, in all their variations. If
    /// empty, each cycle is a piece.
    pub groups: Vec<Range<usize>>,
    /// The first cycle of each walk under each condition.
    pub firsts: &'w [Job<'w>],
    /// The cycles of each walk.
    pub variations: Range<u32>,
    pub views: &'w [View],
    pub settings: Settings,
    pub wanted: &'w Wanted,
    /// The variants of each image, the first of which is the image itself.
    pub variants: &'w [Variant],
    /// The pieces of work to do.
    pub units: Range<usize>,
}

impl<'w> SweepWork<'w> {
    /// Returns how figures are drawn, and what is made of them.
    fn request(&self) -> DrawingRequest<'w> {
        DrawingRequest {
            settings: self.settings,
            wanted: self.wanted,
        }
    }

    /// Returns the number of cycles.
    pub(super) fn cycles(&self) -> usize {
        self.firsts.len() * self.variations.len()
    }

    /// Returns the number of all pieces of work.
    pub(super) fn all_units(&self) -> usize {
        if self.groups.is_empty() {
            self.cycles()
        } else {
            self.groups.len()
        }
    }

    /// Returns the cycles of a piece of work, in the order of a dataset.
    fn jobs_of(&self, unit: usize) -> Vec<Job<'w>> {
        let varied = |first: Job<'w>| {
            let cycles = self.variations.clone();
            cycles.map(move |variation| Job { variation, ..first })
        };
        match self.groups.get(unit) {
            Some(group) => self.firsts[group.clone()]
                .iter()
                .copied()
                .flat_map(varied)
                .collect(),
            None => {
                let cycles = self.variations.len();
                let variation = self.variations.start + (unit % cycles) as u32;
                vec![Job {
                    variation,
                    ..self.firsts[unit / cycles]
                }]
            }
        }
    }

    /// Sweeps the cycles of these pieces of work, in the order of a dataset. Memory does not grow
    /// with their number. `sink` learns whether a cycle is the last of its piece.
    fn each<R: Send>(
        &self,
        units: Range<usize>,
        map: impl Fn(Swept) -> R + Sync,
        mut sink: impl FnMut(Job<'w>, R, bool) -> Result<()>,
    ) -> Result<()> {
        let cycles: usize = units.clone().map(|unit| self.jobs_of(unit).len()).sum();
        let progress = Progress::new(self.common, ("drawing", "cycles"), cycles);
        let mut units = units.peekable();
        while units.peek().is_some() {
            let mut jobs: Vec<Job<'w>> = Vec::new();
            let mut is_last = Vec::new();
            while let (true, Some(unit)) = (jobs.len() < CYCLES_AT_ONCE, units.peek()) {
                jobs.extend(self.jobs_of(*unit));
                is_last.resize(jobs.len(), false);
                if let Some(last) = is_last.last_mut() {
                    *last = true;
                }
                units.next();
            }
            let mut is_last = is_last.into_iter();
            sweep_each(
                self.pack,
                &jobs,
                |_| Ok(self.views.to_vec()),
                self.request(),
                |_, _, swept| {
                    progress.step()?;
                    Ok(map(swept))
                },
                |job, made| sink(job, made, is_last.next().unwrap_or(true)),
            )?;
        }
        Ok(())
    }

    /// Hashes all templates. Returns the sum over all silhouettes of the share outside the image,
    /// and the SHA-256 of the cycles' SHA-256. Cycles are hashed where they are made, on all cores.
    pub(super) fn digest(&self) -> Result<(f64, String)> {
        let (mut clipped, mut digest) = (0.0, Sha256::new());
        self.each(
            0..self.all_units(),
            |swept| {
                let mut cycle = Sha256::new();
                for bytes in &swept.templates {
                    cycle.update(bytes);
                    for &variant in self.variants.iter().skip(1) {
                        cycle.update(varied(bytes, self.settings.size, variant));
                    }
                }
                (swept.clipped, cycle.finalize())
            },
            |_, (share, cycle), _| {
                clipped += share;
                digest.update(cycle);
                Ok(())
            },
        )?;
        Ok((clipped, hex(&digest.finalize())))
    }

    /// Does and writes the remaining work.
    pub(super) fn store(&self, writer: &mut DatasetWriter) -> Result<()> {
        let walks: Vec<_> = self.pack.walks().collect();
        let subjects: Vec<_> = self.pack.subjects().collect();
        let (settings, of_view) = (self.settings, self.wanted.templates.len());
        let left = self.units.start + writer.done()..self.units.end;
        self.each(
            left,
            |swept| swept,
            |job, swept, is_last| {
                writer.clip(swept.clipped);
                let walk = walks[job.walk];
                let subject = subjects[walk.subject].name;
                writer.belongs(subject, "train");
                let take =
                    (!is_uncut(self.pack, job.walk)).then_some(job.variation / CYCLES_OF_A_TAKE);
                let take = take_name(walk.name, job.condition_name(), take);
                let row = IndexRow::of_job(self.pack, job, settings.seed, swept.frames)?;
                let templates = swept.templates.chunks_exact(of_view);
                for ((view, templates), keypoints) in
                    self.views.iter().zip(templates).zip(&swept.keypoints)
                {
                    let row = row.seen_from(view);
                    writer.push(Item {
                        row: &row,
                        take: &take,
                        templates,
                        joints: [&swept.joints, keypoints],
                    })?;
                    for &variant in self.variants.iter().skip(1) {
                        let row = IndexRow {
                            condition: variant.condition(&row.condition),
                            ..row.clone()
                        };
                        let varied = |bytes: &Vec<u8>| varied(bytes, settings.size, variant);
                        let templates: Vec<Vec<u8>> = templates.iter().map(varied).collect();
                        writer.push(Item {
                            row: &row,
                            take: &take,
                            templates: &templates,
                            joints: [&[], &[]],
                        })?;
                    }
                }
                if is_last {
                    writer.end_unit()?;
                }
                Ok(())
            },
        )
    }
}
