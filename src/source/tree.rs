//! Sequences of a tree of silhouettes.

use super::{Form, Labels, Sequences, Shown, mean};
use crate::dataset::{Tree, TreeSequence};
use crate::error::{Error, Result};
use crate::template::{Builder, Template};
use edgegait_core::silhouette::{Coverage, Frame, Size};
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
        Ok(Self::of(Tree::open(path)?, |_| true))
    }

    fn of(tree: Tree, is_kept: impl Fn(&TreeSequence) -> bool) -> Self {
        let mut labels = Labels::default();
        let mut numbers = Vec::new();
        for (number, recording) in tree.sequences().iter().enumerate() {
            if !is_kept(recording) {
                continue;
            }
            numbers.push(number);
            let take = labels.take(&recording.subject, &recording.take, "");
            let view = labels.view((recording.azimuth_deg, recording.elevation_deg));
            labels.push(take, 0, view);
        }
        Self {
            tree,
            numbers,
            sequences: labels.sequences,
            as_stored: false,
        }
    }

    /// Only some of the sequences.
    #[must_use]
    pub fn only(self, is_kept: impl Fn(&TreeSequence) -> bool) -> Self {
        Self {
            as_stored: self.as_stored,
            ..Self::of(self.tree, is_kept)
        }
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
        let (size, framing) = (form.settings.size, form.settings.framing);
        let mut shown = Shown::default();
        for &number in wanted {
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
            shown.empty += found.empty as u64;
            shown.clipped =
                Some(shown.clipped.unwrap_or(0.0) + found.clipped_share * frames as f64);
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
            shown.silhouettes += frames as u64;
            sink(number, &bytes)?;
        }
        Ok(shown)
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
