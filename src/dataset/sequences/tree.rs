//! Sequences of a tree of silhouettes: whole recordings or gait cycles.

use super::packs::{Selection, require};
use super::{Form, Labels, SequenceOrigin, SequencePurpose, Sequences, ShownCounts, ViewLabel};
use crate::dataset::gait_cycles::NoCycle;
use crate::dataset::{Partition, Tree, TreeLayout, TreeSequence};
use crate::draw::sweep::Views;
use crate::draw::template::{Builder, Template};
use crate::error::{Error, Result};
use edgegait_core::silhouette::Size;
use rayon::prelude::*;
use std::collections::{BTreeMap, HashSet};
use std::ops::Range;
use std::path::Path;

mod cut;
mod cycles;
mod forms;
mod listed;

pub(crate) use cut::CutRecordings;
pub(crate) use forms::{in_form, silhouettes};
pub(crate) use listed::RecordingSummary;

/// A whole recording of a tree, or a gait cycle of it.
#[derive(Clone)]
struct RecordingPart {
    /// The recording's number in the tree.
    number: usize,
    /// Its frames, from 0; up to `usize::MAX` if it is whole.
    frames: Range<usize>,
}

/// The recordings of a tree with their labels.
pub struct Recordings {
    tree: Tree,
    /// The part of the tree that each sequence is.
    parts: Vec<RecordingPart>,
    pub(super) sequences: Sequences,
    /// For each sequence of the tree its gait cycles; empty where none were searched or found.
    cycles: Vec<Vec<Range<usize>>>,
    /// Why recordings have no gait cycle, by their numbers in the tree.
    no_cycle: BTreeMap<usize, NoCycle>,
    as_stored: bool,
    /// Whether a recording stays a sequence beside its gait cycles, for recognizers that take
    /// silhouettes.
    keeps_whole: bool,
    /// The gallery and probe sequences, if a partition states them.
    roles: Option<SequenceRoles>,
}

/// The conditions of gallery takes and of probe takes.
const GALLERY: &str = "gallery";
const PROBE: &str = "probe";

/// The names of gallery and probe sequences, `<person>-<take>-<view>`.
#[derive(Clone, Debug)]
struct SequenceRoles {
    gallery: Option<HashSet<String>>,
    probes: Option<HashSet<String>>,
}

impl SequenceRoles {
    /// Returns the role of a sequence, or an empty text if it has none.
    fn role(&self, name: &str) -> &'static str {
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

/// Returns the name of a sequence in a partition.
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
            no_cycle: BTreeMap::new(),
            as_stored: false,
            keeps_whole: false,
            roles: None,
        };
        Ok(all.filter(|_, _| true))
    }

    /// Keeps the sequences for which `is_kept` is true; it gets the number in the tree.
    fn filter(self, is_kept: impl Fn(usize, &TreeSequence) -> bool) -> Self {
        let Self { tree, roles, .. } = &self;
        let mut labels = Labels::default();
        let mut parts = Vec::new();
        for (number, recording) in tree.sequences().iter().enumerate() {
            if !is_kept(number, recording) {
                continue;
            }
            let role = roles
                .as_ref()
                .map_or("", |roles| roles.role(&name_of(recording)));
            let take = match (roles, recording.angles_deg) {
                // Each recording has a role of its own.
                (Some(_), None) => format!("{}-{}", recording.take, recording.view),
                _ => recording.take.clone(),
            };
            let take = labels.take(&recording.subject, &take, role);
            let view = labels.view(match recording.angles_deg {
                Some((azimuth, elevation)) => ViewLabel::Angles(azimuth, elevation),
                None => ViewLabel::Named(recording.view.clone()),
            });
            let mut push = |purpose, cycle: Option<u32>, frames: Range<usize>| {
                let origin = labels.origin(SequenceOrigin {
                    walk: recording.take.clone(),
                    cycle,
                    variation: 0,
                    seed: 0,
                });
                labels.push_for(purpose, take, origin, view);
                parts.push(RecordingPart { number, frames });
            };
            let cycles = self.cycles.get(number).map_or(&[][..], Vec::as_slice);
            let (of_cycle, of_whole) = match (cycles, self.keeps_whole) {
                ([], _) => (SequencePurpose::Any, Some(SequencePurpose::Any)),
                (_, false) => (SequencePurpose::Any, None),
                (_, true) => (
                    SequencePurpose::Templates,
                    Some(SequencePurpose::Silhouettes),
                ),
            };
            for (at, frames) in (0..).zip(cycles) {
                push(of_cycle, Some(at), frames.clone());
            }
            if let Some(purpose) = of_whole {
                push(purpose, None, 0..usize::MAX);
            }
        }
        Self {
            parts,
            sequences: labels.sequences,
            ..self
        }
    }

    /// Returns the numbers of the tree's sequences that are kept at least in part, ascending.
    fn numbers(&self) -> Vec<usize> {
        let mut numbers: Vec<usize> = self.parts.iter().map(|part| part.number).collect();
        numbers.dedup();
        numbers
    }

    /// Returns the number of frames of each gait cycle, if EdgeGait wrote the tree from whole
    /// cycles.
    #[must_use]
    pub fn frames_per_cycle(&self) -> Option<usize> {
        self.tree.frames_per_cycle()
    }

    /// Keeps the people of a partition's test set, with gallery and probe sequences if it states
    /// them. Returns warnings about names that are not in the tree.
    ///
    /// # Errors
    /// If the tree has none of the people, or none of the sequences of a set.
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
                warnings.extend(lacking(path, set, names, &recordings)?);
            }
        }
        let set = |names: &Option<Vec<String>>| {
            names.as_ref().map(|names| names.iter().cloned().collect())
        };
        let roles = partition.has_roles().then(|| SequenceRoles {
            gallery: set(&partition.gallery),
            probes: set(&partition.probes),
        });
        let (tested, more) = Self { roles, ..self }.of_people(path, "TEST_SET", &partition.test)?;
        Ok((tested, more.into_iter().chain(warnings).collect()))
    }

    /// Keeps the people of a partition's training set. Returns a warning about names that are not
    /// in the tree.
    ///
    /// # Errors
    /// If the tree has none of the people.
    pub fn trained(self, partition: &Partition, path: &Path) -> Result<(Self, Option<String>)> {
        self.of_people(path, "TRAIN_SET", &partition.train)
    }

    /// Keeps the people of one set of a partition.
    fn of_people(
        self,
        path: &Path,
        set: &str,
        people: &[String],
    ) -> Result<(Self, Option<String>)> {
        let subjects: HashSet<String> = self.sequences.subjects.iter().cloned().collect();
        let warning = lacking(path, set, people, &subjects)?;
        let people: HashSet<&String> = people.iter().collect();
        let kept: HashSet<usize> = self.numbers().into_iter().collect();
        let is_kept = |number, sequence: &TreeSequence| {
            kept.contains(&number) && people.contains(&sequence.subject)
        };
        Ok((self.filter(is_kept), warning))
    }

    /// Checks by the headers of files, on all cores, that each sequence's pictures have one size,
    /// and that pictures to be used unchanged fit all sizes in `stored`. `progress` is called once
    /// a sequence.
    ///
    /// # Errors
    /// The first error in the tree's order.
    pub fn check_sizes(
        &self,
        stored: &[Size],
        progress: &(dyn Fn() -> Result<()> + Sync),
    ) -> Result<()> {
        let stored = if self.as_stored { stored } else { &[] };
        let check = |&number: &usize| {
            let result = self.tree.check_size(number, stored);
            progress()?;
            Ok(result)
        };
        let numbers = self.numbers();
        let results = numbers.par_iter().map(check);
        let results: Vec<Result<()>> = results.collect::<Result<_>>()?;
        results.into_iter().collect()
    }

    /// Returns warnings about recordings whose frames have doubtful numbers ([`Tree::doubts`]).
    /// Folders that cannot be read are left to those who read them.
    #[must_use]
    pub fn doubts(&self) -> Vec<String> {
        let numbers = self.numbers();
        let doubt = |&number: &usize| {
            let doubt = self.tree.doubts(number).ok().flatten()?;
            Some(format!("{}: {doubt}", self.name(number)))
        };
        let found: Vec<String> = numbers.par_iter().filter_map(doubt).collect();
        let what = format!(
            "{} of {} recordings have doubtful numbers of frames",
            found.len(),
            numbers.len()
        );
        summary(what, &found).into_iter().collect()
    }

    /// Returns the name of a recording of the tree.
    fn name(&self, number: usize) -> String {
        let TreeSequence {
            subject,
            take,
            view,
            ..
        } = &self.tree.sequences()[number];
        format!("{subject}/{take}/{view}")
    }

    /// Returns the labels of all sequences.
    #[must_use]
    pub const fn sequences(&self) -> &Sequences {
        &self.sequences
    }

    /// Returns the number of sequences.
    #[must_use]
    pub const fn len(&self) -> usize {
        self.parts.len()
    }

    /// Returns whether a partition states gallery and probe sequences.
    #[must_use]
    pub const fn has_roles(&self) -> bool {
        self.roles.is_some()
    }

    /// Returns whether there are no sequences.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.parts.is_empty()
    }

    /// Keeps the sequences of the selected people and takes, from these viewpoints if any are
    /// given.
    ///
    /// # Errors
    /// For unknown names, and for viewpoints if the tree's views have no angles.
    pub fn chosen(self, selection: &Selection, views: Option<&Views>) -> Result<Self> {
        let Sequences {
            subjects, takes, ..
        } = &self.sequences;
        let people: Vec<&str> = subjects.iter().map(String::as_str).collect();
        let takes: Vec<&str> = takes.iter().map(|take| take.name.as_str()).collect();
        require("subject", &selection.subjects, &people)?;
        require("take", &selection.walks, &takes)?;
        let is_kept = |sequence: &TreeSequence| {
            let is_seen =
                |views: &Views| sequence.angles_deg.is_some_and(|angles| views.has(angles));
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
                "expected views named by angles, to choose viewpoints, found names of cameras or recordings".into(),
            ));
        }
        Ok(self.filter(|_, sequence| is_kept(sequence)))
    }

    /// Keeps the sequences that can be shown in all of these forms, and returns the errors of the
    /// others, in the tree's order. Reads every picture once for each form, on all cores;
    /// `progress` is called once a sequence.
    ///
    /// # Errors
    /// For a form that no tree supports.
    pub fn readable(
        self,
        forms: &[Form],
        progress: &(dyn Fn() -> Result<()> + Sync),
    ) -> Result<(Self, Vec<Error>)> {
        let read = |number| -> Result<()> {
            let mut forms = forms.iter();
            forms.try_for_each(|form| self.template(number, form).map(drop))
        };
        let results: Vec<Result<()>> = (0..self.parts.len())
            .into_par_iter()
            .map(|number| {
                let result = read(number);
                progress()?;
                Ok(result)
            })
            .collect::<Result<_>>()?;
        let (mut kept, mut refused) = (HashSet::new(), Vec::new());
        for (part, result) in self.parts.iter().zip(results) {
            match result {
                Ok(()) => {
                    kept.insert(part.number);
                }
                Err(Error::Usage(problem)) => return Err(Error::Usage(problem)),
                Err(error) => refused.push(error),
            }
        }
        Ok((self.filter(|number, _| kept.contains(&number)), refused))
    }

    /// Keeps each recording beside the gait cycles into which it is split later: recognizers that
    /// take silhouettes are shown the recording, the others its cycles.
    #[must_use]
    pub fn keeping_whole(self) -> Self {
        Self {
            keeps_whole: true,
            ..self
        }
    }

    /// Uses the pictures unchanged, since they are framed already, as OpenGait does.
    #[must_use]
    pub fn taken_as_stored(self) -> Self {
        Self {
            as_stored: true,
            ..self
        }
    }

    /// Returns the entries of the tree that were skipped because they are not sequences.
    #[must_use]
    pub fn skipped(&self) -> &[String] {
        self.tree.skipped()
    }

    pub(super) fn show(
        &self,
        wanted: &[usize],
        form: &Form,
        sink: &mut dyn FnMut(usize, &[u8]) -> Result<()>,
    ) -> Result<ShownCounts> {
        let mut shown = ShownCounts {
            clipped: wanted.first().map(|_| 0.0),
            ..ShownCounts::default()
        };
        for &number in wanted {
            let (bytes, own) = self.template(number, form)?;
            shown = shown.and(own);
            sink(number, &bytes)?;
        }
        Ok(shown)
    }

    /// Returns a sequence in a form, and counts of its silhouettes.
    fn template(&self, number: usize, form: &Form) -> Result<(Vec<u8>, ShownCounts)> {
        let (size, framing) = (form.settings.size, form.settings.framing);
        let RecordingPart { number, frames } = self.parts[number].clone();
        let found = if self.as_stored {
            self.tree.stored_of(number, frames, size)?
        } else {
            self.tree.silhouettes_of(number, frames, size, framing)?
        };
        let frames = found.frames;
        let brightest = found.pixels.iter().copied().max().unwrap_or(0);
        if frames == 0 || brightest == 0 {
            return Err(Error::input(
                self.tree.folder(number),
                "expected a figure in some frame, pixels of 128 to 255, found none (leave the sequence out; labels such as 0 and 2 need to be 0 and 255)",
            ));
        }
        let shown = ShownCounts {
            silhouettes: frames as u64,
            clipped: Some(found.clipped_share * frames as f64),
            empty: found.empty as u64,
        };
        let (template, most) = (form.settings.template, Builder::MAX_FRAMES as usize);
        if frames > most && ![Template::Gei, Template::Silhouettes].contains(&template) {
            return Err(Error::input(
                self.tree.folder(number),
                format!(
                    "expected at most {most} frames for {}, found {frames}",
                    template.plural()
                ),
            ));
        }
        Ok((in_form(found.pixels, form)?, shown))
    }
}

/// The maximum number of recordings that a warning names.
const NAMED: usize = 5;

/// Returns a warning that names the first few of what was found; none if nothing was.
pub(crate) fn summary(what: String, found: &[String]) -> Option<String> {
    if found.is_empty() {
        return None;
    }
    let more = match found.len().saturating_sub(NAMED) {
        0 => String::new(),
        more => format!("; and {more} more"),
    };
    let named = found[..found.len().min(NAMED)].join("; ");
    Some(format!("{what}: {named}{more}"))
}

/// Returns a warning with the number of a partition set's names that are not in the tree, if there
/// are any. A set without any name in the tree is an error.
fn lacking(
    path: &Path,
    set: &str,
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
            Some(first) => format!("none of them (the first is {first:?})"),
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
