//! Sequences of a tree of silhouettes.

use super::packs::{Selection, require};
use super::{Form, Labels, Origin, Sequences, Shown, mean};
use crate::dataset::{Tree, TreeSequence};
use crate::error::{Error, Result};
use crate::sweep::Views;
use crate::template::{Builder, Template};
use edgegait_core::silhouette::{Coverage, Frame, Size};
use rayon::prelude::*;
use std::collections::HashSet;
use std::path::Path;

/// The recordings of a tree with their labels.
pub struct Recordings {
    tree: Tree,
    /// For each sequence its number in the tree.
    numbers: Vec<usize>,
    pub(super) sequences: Sequences,
    as_stored: bool,
}

impl Recordings {
    pub(super) fn open(path: &Path) -> Result<Self> {
        Ok(Self::of(Tree::open(path)?, |_, _| true))
    }

    /// The sequences to keep, by their number in the tree and what they are.
    fn of(tree: Tree, is_kept: impl Fn(usize, &TreeSequence) -> bool) -> Self {
        let mut labels = Labels::default();
        let mut numbers = Vec::new();
        for (number, recording) in tree.sequences().iter().enumerate() {
            if !is_kept(number, recording) {
                continue;
            }
            numbers.push(number);
            let take = labels.take(&recording.subject, &recording.take, "");
            let view = labels.view((recording.azimuth_deg, recording.elevation_deg));
            let origin = labels.origin(Origin {
                walk: recording.take.clone(),
                cycle: None,
                variation: 0,
                seed: 0,
            });
            labels.push(take, origin, view);
        }
        Self {
            tree,
            numbers,
            sequences: labels.sequences,
            as_stored: false,
        }
    }

    /// How many sequences there are.
    #[must_use]
    pub const fn len(&self) -> usize {
        self.numbers.len()
    }

    /// Whether none was chosen.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.numbers.is_empty()
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
            let seen_at = (sequence.azimuth_deg, sequence.elevation_deg);
            let is_seen =
                |views: &Views| views.list.iter().any(|view| view.angles_deg() == seen_at);
            selection.has(&sequence.subject, &sequence.take) && views.is_none_or(is_seen)
        };
        Ok(Self {
            as_stored: self.as_stored,
            ..Self::of(self.tree, |_, sequence| is_kept(sequence))
        })
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
        let results: Vec<Result<()>> = (0..self.numbers.len())
            .into_par_iter()
            .map(|number| {
                let result = read(number);
                progress();
                result
            })
            .collect();
        let (mut kept, mut refused) = (HashSet::new(), Vec::new());
        for (&number, result) in self.numbers.iter().zip(results) {
            match result {
                Ok(()) => {
                    kept.insert(number);
                }
                Err(Error::Usage(problem)) => return Err(Error::Usage(problem)),
                Err(error) => refused.push(error),
            }
        }
        let readable = Self {
            as_stored: self.as_stored,
            ..Self::of(self.tree, |number, _| kept.contains(&number))
        };
        Ok((readable, refused))
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
        let found = if self.as_stored {
            self.tree.stored(self.numbers[number], size)?
        } else {
            self.tree.silhouettes(self.numbers[number], size, framing)?
        };
        let frames = found.frames;
        if frames == 0 {
            return Err(Error::input(
                self.tree.folder(self.numbers[number]),
                "expected a figure in some frame, found none (leave the sequence out)",
            ));
        }
        let shown = Shown {
            silhouettes: frames as u64,
            clipped: Some(found.clipped_share * frames as f64),
            empty: found.empty as u64,
        };
        let bytes = match (form.settings.template, form.frames) {
            (Template::Gei, _) => mean(&found.pixels, size),
            (Template::Silhouettes, None) => found.pixels,
            (Template::Silhouettes, Some(wanted)) => (0..wanted)
                .flat_map(|at| {
                    // Evenly, or again from the start if there are fewer.
                    let from = if frames > wanted {
                        at * frames / wanted
                    } else {
                        at % frames
                    };
                    found.pixels[from * size.pixels()..][..size.pixels()].to_vec()
                })
                .collect(),
            (template, _) => {
                let most = Builder::MAX_FRAMES as usize;
                if frames > most {
                    return Err(Error::input(
                        self.tree.folder(self.numbers[number]),
                        format!(
                            "expected at most {most} frames for {}, found {frames}",
                            template.plural()
                        ),
                    ));
                }
                whole(template, &found.pixels, size)?
            }
        };
        Ok((bytes, shown))
    }
}

/// The template of silhouettes, bytes one after another, which count as one cycle.
fn whole(template: Template, silhouettes: &[u8], size: Size) -> Result<Vec<u8>> {
    let frames = silhouettes.chunks_exact(size.pixels());
    let mut builder = Builder::new(template, size, frames.len() as u32);
    for bytes in frames {
        let mut coverage = Coverage::empty(size);
        coverage.pixels_mut().copy_from_slice(bytes);
        builder.add(&Frame::Grey(coverage))?;
    }
    Ok(builder.finish())
}
