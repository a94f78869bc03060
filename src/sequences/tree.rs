//! Sequences of a tree of silhouettes.

use super::packs::{Selection, require};
use super::{Form, Labels, SequenceOrigin, Sequences, Shown, ViewLabel, mean};
use crate::dataset::{Partition, Tree, TreeLayout, TreeSequence};
use crate::error::{Error, Result};
use crate::gait_cycles::{CycleFinder, whole_frames};
use crate::sweep::Views;
use crate::template::{Builder, Template};
use edgegait_core::silhouette::{AnySilhouette, Coverage, Size};
use rayon::prelude::*;
use std::collections::HashSet;
use std::ops::Range;
use std::path::Path;

mod cycles;

/// The recordings of a tree with their labels.
pub struct Recordings {
    tree: Tree,
    /// For each sequence its number in the tree, and which of its pictures.
    parts: Vec<(usize, Range<usize>)>,
    pub(super) sequences: Sequences,
    /// For each sequence of the tree its gait cycles, if they were looked for; none where they were not
    /// found.
    cycles: Vec<Vec<Range<usize>>>,
    as_stored: bool,
    /// Which sequences are looked for among which, if a partition says so.
    roles: Option<SequenceRoles>,
}

/// What takes are called that people are known by, and those that are looked for, as conditions.
const GALLERY: &str = "gallery";
const PROBE: &str = "probe";

/// Names of sequences, `<person>-<take>-<view>`.
#[derive(Clone, Debug)]
struct SequenceRoles {
    gallery: Option<HashSet<String>>,
    probes: Option<HashSet<String>>,
}

impl SequenceRoles {
    /// The part of a sequence; empty if it has none.
    fn of(&self, name: &str) -> &'static str {
        let is_in =
            |set: &Option<HashSet<String>>| set.as_ref().is_some_and(|set| set.contains(name));
        if is_in(&self.probes) || (self.probes.is_none() && !is_in(&self.gallery)) {
            PROBE
        } else if is_in(&self.gallery) || self.gallery.is_none() {
            GALLERY
        } else {
            ""
        }
    }
}

/// What a partition calls a sequence.
fn name_of(sequence: &TreeSequence) -> String {
    let TreeSequence {
        subject,
        take,
        view,
        ..
    } = sequence;
    format!("{subject}-{take}-{view}")
}

impl Recordings {
    pub(super) fn open(path: &Path, layout: &TreeLayout) -> Result<Self> {
        let all = Self {
            tree: Tree::open(path, layout)?,
            parts: Vec::new(),
            sequences: Sequences::default(),
            cycles: Vec::new(),
            as_stored: false,
            roles: None,
        };
        Ok(all.of(|_, _| true))
    }

    /// The sequences to keep, by their number in the tree and what they are.
    fn of(self, is_kept: impl Fn(usize, &TreeSequence) -> bool) -> Self {
        let Self { tree, roles, .. } = &self;
        let mut labels = Labels::default();
        let mut parts = Vec::new();
        for (number, recording) in tree.sequences().iter().enumerate() {
            if !is_kept(number, recording) {
                continue;
            }
            let role = roles
                .as_ref()
                .map_or("", |roles| roles.of(&name_of(recording)));
            let take = match (roles, recording.angles_deg) {
                // Each recording has a part of its own.
                (Some(_), None) => format!("{}-{}", recording.take, recording.view),
                _ => recording.take.clone(),
            };
            let take = labels.take(&recording.subject, &take, role);
            let view = labels.view(match recording.angles_deg {
                Some((azimuth, elevation)) => ViewLabel::Angles(azimuth, elevation),
                None => ViewLabel::Named(recording.view.clone()),
            });
            let mut push = |cycle: Option<u32>, frames: Range<usize>| {
                let origin = labels.origin(SequenceOrigin {
                    walk: recording.take.clone(),
                    cycle,
                    variation: 0,
                    seed: 0,
                });
                labels.push(take, origin, view);
                parts.push((number, frames));
            };
            match self.cycles.get(number).map_or(&[][..], Vec::as_slice) {
                [] => push(None, 0..usize::MAX),
                cycles => (0..)
                    .zip(cycles)
                    .for_each(|(at, frames)| push(Some(at), frames.clone())),
            }
        }
        Self {
            parts,
            sequences: labels.sequences,
            ..self
        }
    }

    /// The numbers of the tree's sequences of which any part is here, rising.
    fn numbers(&self) -> Vec<usize> {
        let mut numbers: Vec<usize> = self.parts.iter().map(|(number, _)| *number).collect();
        numbers.dedup();
        numbers
    }

    /// Frames of each gait cycle, if the tree was made here of whole cycles.
    #[must_use]
    pub fn frames_per_cycle(&self) -> Option<usize> {
        self.tree.frames_per_cycle()
    }

    /// The same by gait cycles of so many frames each, or the whole recording where these do not fill
    /// it.
    ///
    /// # Errors
    /// If a recording cannot be read.
    pub fn in_even_cycles(self, frames: usize) -> Result<Self> {
        let numbers = self.numbers();
        let mut cycles = vec![Vec::new(); self.tree.sequences().len()];
        let counts: Vec<Result<Option<usize>>> = numbers
            .par_iter()
            .map(|&number| self.tree.frames(number))
            .collect();
        for (&number, count) in numbers.iter().zip(counts) {
            // Frames without a figure were left out of others.
            let count = count?.filter(|count| count.is_multiple_of(frames));
            let starts = (0..count.unwrap_or(0)).step_by(frames.max(1));
            cycles[number] = starts.map(|start| start..start + frames).collect();
        }
        let kept: HashSet<usize> = numbers.into_iter().collect();
        Ok(Self { cycles, ..self }.of(|number, _| kept.contains(&number)))
    }

    /// The same by gait cycles: one sequence for each, or the whole recording where none is found, and
    /// why. Reads every picture, on all cores; `progress` is called once a recording.
    ///
    /// # Errors
    /// If a recording cannot be read.
    pub fn in_cycles(
        self,
        finder: &CycleFinder,
        progress: &(dyn Fn() + Sync),
    ) -> Result<(Self, Vec<String>)> {
        let numbers = self.numbers();
        let find = |&number: &usize| -> Result<_> {
            let legs = self.tree.lower_bodies(number)?;
            progress();
            Ok(finder.find(legs))
        };
        let found: Vec<Result<_>> = numbers.par_iter().map(find).collect();
        let mut cycles = vec![Vec::new(); self.tree.sequences().len()];
        let mut without = Vec::new();
        for (&number, found) in numbers.iter().zip(found) {
            match found? {
                Ok(found) => cycles[number] = found.cycles.iter().map(whole_frames).collect(),
                Err(reason) => {
                    let TreeSequence {
                        subject,
                        take,
                        view,
                        ..
                    } = &self.tree.sequences()[number];
                    without.push(format!("{subject}/{take}/{view}: {reason}"));
                }
            }
        }
        let kept: HashSet<usize> = numbers.into_iter().collect();
        let cut = Self { cycles, ..self };
        Ok((cut.of(|number, _| kept.contains(&number)), without))
    }

    /// Only the people whom a partition tests, and which of their sequences are looked for among
    /// which, if it says so; what of it is not in the tree, in words.
    ///
    /// # Errors
    /// If the tree has none of those people, or none of those sequences.
    pub fn tested(self, partition: &Partition, path: &Path) -> Result<(Self, Vec<String>)> {
        let numbers = self.numbers();
        let recordings = numbers
            .iter()
            .map(|&at| name_of(&self.tree.sequences()[at]));
        let recordings: HashSet<String> = recordings.collect();
        let mut warnings = Vec::new();
        for (set, names) in [
            ("GALLERY_SET", &partition.gallery),
            ("PROBE_SET", &partition.probes),
        ] {
            if let Some(names) = names {
                warnings.extend(lacking((path, set), names, &recordings)?);
            }
        }
        let set = |names: &Option<Vec<String>>| {
            names.as_ref().map(|names| names.iter().cloned().collect())
        };
        let roles = partition.has_roles().then(|| SequenceRoles {
            gallery: set(&partition.gallery),
            probes: set(&partition.probes),
        });
        let (tested, more) =
            Self { roles, ..self }.of_people((path, "TEST_SET"), &partition.test)?;
        Ok((tested, more.into_iter().chain(warnings).collect()))
    }

    /// Only the people whom a partition trains with; who of them is not in the tree, in words.
    ///
    /// # Errors
    /// If the tree has none of them.
    pub fn trained(self, partition: &Partition, path: &Path) -> Result<(Self, Option<String>)> {
        self.of_people((path, "TRAIN_SET"), &partition.train)
    }

    /// Only these people, a set of a partition.
    fn of_people(self, set: (&Path, &str), people: &[String]) -> Result<(Self, Option<String>)> {
        let subjects: HashSet<String> = self.sequences.subjects.iter().cloned().collect();
        let warning = lacking(set, people, &subjects)?;
        let people: HashSet<&String> = people.iter().collect();
        let kept: HashSet<usize> = self.numbers().into_iter().collect();
        let is_kept = |number, sequence: &TreeSequence| {
            kept.contains(&number) && people.contains(&sequence.subject)
        };
        Ok((self.of(is_kept), warning))
    }

    /// Checks, by the beginnings of files, that each sequence's pictures have one size and, if they
    /// are to be taken as they are, that it serves for each of these; on all cores. `progress` is
    /// called once a sequence.
    ///
    /// # Errors
    /// The first in the tree's order.
    pub fn check_sizes(&self, stored: &[Size], progress: &(dyn Fn() + Sync)) -> Result<()> {
        let stored = if self.as_stored { stored } else { &[] };
        let check = |&number: &usize| {
            let result = self.tree.check_size(number, stored);
            progress();
            result
        };
        let results: Vec<Result<()>> = self.numbers().par_iter().map(check).collect();
        results.into_iter().collect()
    }

    /// How many sequences there are.
    #[must_use]
    pub const fn len(&self) -> usize {
        self.parts.len()
    }

    /// Whether a partition says which sequences are looked for among which.
    #[must_use]
    pub const fn has_roles(&self) -> bool {
        self.roles.is_some()
    }

    /// Whether none was chosen.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.parts.is_empty()
    }

    /// Only the sequences of these people and takes, seen from these viewpoints if any are given.
    ///
    /// # Errors
    /// For names that are not there.
    pub fn chosen(self, selection: &Selection, views: Option<&Views>) -> Result<Self> {
        let Sequences {
            subjects, takes, ..
        } = &self.sequences;
        let people: Vec<&str> = subjects.iter().map(String::as_str).collect();
        let takes: Vec<&str> = takes.iter().map(|take| take.name.as_str()).collect();
        require("subject", &selection.subjects, &people)?;
        require("take", &selection.walks, &takes)?;
        let is_kept = |sequence: &TreeSequence| {
            let is_seen = |views: &Views| {
                let mut views = views.list.iter();
                views.any(|view| Some(view.angles_deg()) == sequence.angles_deg)
            };
            selection.has(&sequence.subject, &sequence.take) && views.is_none_or(is_seen)
        };
        if views.is_some()
            && self
                .sequences
                .views
                .iter()
                .all(|view| view.angles_deg().is_none())
        {
            return Err(Error::Usage(
                "expected views named by angles, to choose by viewpoint, found names of cameras or recordings".into(),
            ));
        }
        Ok(self.of(|_, sequence| is_kept(sequence)))
    }

    /// Only the sequences that can be shown in all of these forms, and why the others cannot, in
    /// the tree's order. Reads every picture once for each form, on all cores; `progress` is called
    /// once a sequence.
    ///
    /// # Errors
    /// For a form that no tree has.
    pub fn readable(
        self,
        forms: &[Form],
        progress: &(dyn Fn() + Sync),
    ) -> Result<(Self, Vec<Error>)> {
        let read = |number| -> Result<()> {
            let mut forms = forms.iter();
            forms.try_for_each(|form| self.template(number, form).map(drop))
        };
        let results: Vec<Result<()>> = (0..self.parts.len())
            .into_par_iter()
            .map(|number| {
                let result = read(number);
                progress();
                result
            })
            .collect();
        let (mut kept, mut refused) = (HashSet::new(), Vec::new());
        for ((number, _), result) in self.parts.iter().zip(results) {
            match result {
                Ok(()) => {
                    kept.insert(*number);
                }
                Err(Error::Usage(problem)) => return Err(Error::Usage(problem)),
                Err(error) => refused.push(error),
            }
        }
        Ok((self.of(|number, _| kept.contains(&number)), refused))
    }

    /// The same, its pictures taken as they are: they have been framed already, as OpenGait does.
    #[must_use]
    pub fn taken_as_stored(self) -> Self {
        Self {
            as_stored: true,
            ..self
        }
    }

    /// What in the tree is no sequence and was left out.
    #[must_use]
    pub fn skipped(&self) -> &[String] {
        self.tree.skipped()
    }

    pub(super) fn show(
        &self,
        wanted: &[usize],
        form: &Form,
        sink: &mut dyn FnMut(usize, &[u8]) -> Result<()>,
    ) -> Result<Shown> {
        let mut shown = Shown {
            clipped: wanted.first().map(|_| 0.0),
            ..Shown::default()
        };
        for &number in wanted {
            let (bytes, own) = self.template(number, form)?;
            shown = shown.and(own);
            sink(number, &bytes)?;
        }
        Ok(shown)
    }

    /// A sequence in a form, and what was shown of it.
    fn template(&self, number: usize, form: &Form) -> Result<(Vec<u8>, Shown)> {
        let (size, framing) = (form.settings.size, form.settings.framing);
        let part = self.parts[number].clone();
        let recording = part.0;
        let found = if self.as_stored {
            self.tree.stored_of(part, size)?
        } else {
            self.tree.silhouettes_of(part, size, framing)?
        };
        let frames = found.frames;
        let brightest = found.pixels.iter().copied().max().unwrap_or(0);
        if frames == 0 || brightest == 0 {
            return Err(Error::input(
                self.tree.folder(recording),
                "expected a figure in some frame, pixels of 128 to 255, found none (leave the sequence out; pixels of 0 and 1 need to be 0 and 255)",
            ));
        }
        if brightest == 1 {
            return Err(Error::input(
                self.tree.folder(recording),
                "expected pixels from 0 to 255, found 0 and 1 alone (multiply them by 255)",
            ));
        }
        let shown = Shown {
            silhouettes: frames as u64,
            clipped: Some(found.clipped_share * frames as f64),
            empty: found.empty as u64,
        };
        let (template, most) = (form.settings.template, Builder::MAX_FRAMES as usize);
        if frames > most && ![Template::Gei, Template::Silhouettes].contains(&template) {
            return Err(Error::input(
                self.tree.folder(recording),
                format!(
                    "expected at most {most} frames for {}, found {frames}",
                    template.plural()
                ),
            ));
        }
        Ok((in_form(found.pixels, form)?, shown))
    }
}

/// What a recognizer is shown of a recording or a gait cycle, from its silhouettes: bytes of 0 to 255,
/// one frame after another, at least one.
///
/// # Errors
/// For a template of more frames than [`Builder::MAX_FRAMES`], of others than GEIs and silhouettes.
pub(crate) fn in_form(silhouettes: Vec<u8>, form: &Form) -> Result<Vec<u8>> {
    let size = form.settings.size;
    let frames = silhouettes.len() / size.pixels();
    match (form.settings.template, form.frames) {
        (Template::Gei, _) => Ok(mean(&silhouettes, size)),
        (Template::Silhouettes, None) => Ok(silhouettes),
        (Template::Silhouettes, Some(wanted)) => Ok((0..wanted)
            .flat_map(|at| {
                // Evenly, or again from the start if there are fewer.
                let from = if frames > wanted {
                    at * frames / wanted
                } else {
                    at % frames
                };
                silhouettes[from * size.pixels()..][..size.pixels()].to_vec()
            })
            .collect()),
        (template, _) => whole(template, &silhouettes, size),
    }
}

/// How many names of a set of a partition are not in the tree, if any; refuses a set none of which is.
fn lacking(
    (path, set): (&Path, &str),
    names: &[String],
    known: &HashSet<String>,
) -> Result<Option<String>> {
    let lacking: Vec<&String> = names.iter().filter(|name| !known.contains(*name)).collect();
    if lacking.len() == names.len() {
        let form = match set {
            "GALLERY_SET" | "PROBE_SET" => ", as <person>-<take>-<view>",
            _ => "",
        };
        let found = match names.first() {
            Some(first) => format!("{first:?} and no other that is"),
            None => "none".to_owned(),
        };
        return Err(Error::input(
            path,
            format!("{set}: expected names that are in the tree{form}, found {found}"),
        ));
    }
    Ok(lacking.first().map(|first| {
        format!(
            "{}: {set}: {} of {} names are not in the tree, first {first:?}",
            path.display(),
            lacking.len(),
            names.len()
        )
    }))
}

/// The template of silhouettes, bytes one after another, which count as one cycle.
fn whole(template: Template, silhouettes: &[u8], size: Size) -> Result<Vec<u8>> {
    let frames = silhouettes.chunks_exact(size.pixels());
    let mut builder = Builder::new(template, size, frames.len() as u32);
    for bytes in frames {
        let mut coverage = Coverage::empty(size);
        coverage.pixels_mut().copy_from_slice(bytes);
        builder.add(&AnySilhouette::Grey(coverage))?;
    }
    Ok(builder.finish())
}
