//! Sequences of a pack, a dataset or a tree of silhouettes: the inputs of recognizers.
//!
//! A sequence is one gait cycle (or one recording) of one person, seen from one viewpoint. A
//! protocol chooses sequences by person, take and viewpoint, whatever their source.

mod cohort;
mod dataset;
mod packs;
mod tree;
mod walks;

pub(crate) use cohort::stored;
#[cfg(feature = "train")]
pub(crate) use packs::require;
pub(crate) use packs::{BUILT_IN_WALK, built_in, is_pack_or_folder};
pub use packs::{PackSource, Selection};
pub(crate) use tree::{CutRecordings, RecordingSummary, Recordings, in_form, silhouettes, summary};
pub(crate) use walks::{MadeTake, PackWalks};

use crate::dataset::{Dataset, Tree, TreeLayout};
use crate::draw::sweep::{Settings, View};
use crate::draw::template::Template;
use crate::error::{Error, Result};
use edgegait_core::silhouette::Size;
use serde::{Deserialize, Serialize};
use std::collections::HashMap;
use std::fmt;
use std::path::Path;

/// A take: one recording of a person, with all cycles of one walk.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SequenceTake {
    /// The number of the person in [`Sequences::subjects`].
    pub subject: usize,
    /// The name of the take, such as `nm-01`.
    pub name: String,
    /// The condition, such as `normal` or `bag`; empty if the source does not state it.
    pub condition: String,
}

/// The origin of a sequence, without the person: walk, cycle and variation.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct SequenceOrigin {
    /// The walk's name in the source. It equals the take's name, unless takes were made from walks.
    pub walk: String,
    /// The number of the recorded cycle, from 0, or `None` for a whole recording.
    pub cycle: Option<u32>,
    /// The number of the seeded variation of the cycle; 0 is the cycle itself.
    pub variation: u32,
    /// The seed of the variation.
    pub seed: u64,
}

/// The viewpoint of a sequence: angles or a name.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum ViewLabel {
    /// The azimuth and elevation, degrees.
    Angles(f64, f64),
    /// The name of a camera or a recording with unknown angles.
    Named(String),
}

impl From<View> for ViewLabel {
    fn from(view: View) -> Self {
        let (azimuth, elevation) = view.angles_deg();
        Self::Angles(azimuth, elevation)
    }
}

impl ViewLabel {
    /// Returns azimuth and elevation in degrees, if they are known.
    #[must_use]
    pub const fn angles_deg(&self) -> Option<(f64, f64)> {
        match *self {
            Self::Angles(azimuth, elevation) => Some((azimuth, elevation)),
            Self::Named(_) => None,
        }
    }

    /// Returns the name, if the angles are unknown.
    #[must_use]
    pub fn name(&self) -> Option<&str> {
        match self {
            Self::Angles(..) => None,
            Self::Named(name) => Some(name),
        }
    }
}

/// Writes `90`, `90/15` with an elevation, or the name.
impl fmt::Display for ViewLabel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Angles(azimuth, 0.0) => write!(f, "{azimuth}"),
            Self::Angles(azimuth, elevation) => write!(f, "{azimuth}/{elevation}"),
            Self::Named(name) => write!(f, "{name}"),
        }
    }
}

/// What a sequence is for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SequencePurpose {
    /// All recognizers, in the gallery and as a probe.
    #[default]
    Any,
    /// Recognizers that take templates: a gait cycle of a recording.
    Templates,
    /// Recognizers that take silhouettes: a whole recording, beside its gait cycles.
    Silhouettes,
    /// The gallery only: it is seen from a viewpoint that is not one of the probes.
    Gallery,
}

impl SequencePurpose {
    /// Returns whether a recognizer that takes this template is shown the sequence.
    #[must_use]
    pub fn suits(self, template: Template) -> bool {
        match self {
            Self::Any | Self::Gallery => true,
            Self::Templates => template != Template::Silhouettes,
            Self::Silhouettes => template == Template::Silhouettes,
        }
    }
}

/// One cycle of a take, seen from one viewpoint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sequence {
    /// The number of the take in [`Sequences::takes`].
    pub take: usize,
    /// The number of the origin in [`Sequences::origins`].
    pub origin: usize,
    /// The number of the viewpoint in [`Sequences::views`].
    pub view: usize,
    /// What the sequence is for.
    pub purpose: SequencePurpose,
}

/// The labels of all sequences of a source.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sequences {
    /// The names of the people, each once.
    pub subjects: Vec<String>,
    /// The takes, in the source's order.
    pub takes: Vec<SequenceTake>,
    /// The origins of the sequences, each once.
    pub origins: Vec<SequenceOrigin>,
    /// The viewpoints, each once.
    pub views: Vec<ViewLabel>,
    /// The sequences in the source's order.
    pub list: Vec<Sequence>,
}

impl Sequences {
    /// Returns the number of the person in a sequence.
    #[must_use]
    pub fn subject(&self, sequence: usize) -> usize {
        self.takes[self.list[sequence].take].subject
    }

    /// Returns the origin of a sequence.
    #[must_use]
    pub fn origin(&self, sequence: usize) -> &SequenceOrigin {
        &self.origins[self.list[sequence].origin]
    }

    /// Returns the viewpoint of a sequence.
    #[must_use]
    pub fn view_label(&self, sequence: usize) -> &ViewLabel {
        &self.views[self.list[sequence].view]
    }
}

/// Numbers for distinct keys, in the order of their first appearance.
#[derive(Debug)]
struct Register<K> {
    numbers: HashMap<K, usize>,
}

impl<K> Default for Register<K> {
    fn default() -> Self {
        Self {
            numbers: HashMap::new(),
        }
    }
}

impl<K: std::hash::Hash + Eq> Register<K> {
    /// Returns the number of `key`, and calls `add` if it is new.
    fn number(&mut self, key: K, add: impl FnOnce()) -> usize {
        let next = self.numbers.len();
        *self.numbers.entry(key).or_insert_with(|| {
            add();
            next
        })
    }
}

/// A collector of labels.
#[derive(Debug, Default)]
struct Labels {
    sequences: Sequences,
    subjects: Register<String>,
    takes: Register<(usize, String, String)>,
    origins: Register<SequenceOrigin>,
    views: Register<String>,
}

impl Labels {
    /// Returns the number of a take, and adds it if it is new.
    fn take(&mut self, subject: &str, name: &str, condition: &str) -> usize {
        let Sequences {
            subjects, takes, ..
        } = &mut self.sequences;
        let person = self
            .subjects
            .number(subject.to_owned(), || subjects.push(subject.to_owned()));
        let key = (person, name.to_owned(), condition.to_owned());
        self.takes.number(key, || {
            takes.push(SequenceTake {
                subject: person,
                name: name.to_owned(),
                condition: condition.to_owned(),
            });
        })
    }

    /// Returns the number of a viewpoint, and adds it if it is new.
    fn view(&mut self, label: ViewLabel) -> usize {
        let label = match label {
            // Adding 0 removes the sign of a negative zero.
            ViewLabel::Angles(azimuth, elevation) => {
                ViewLabel::Angles(azimuth + 0.0, elevation + 0.0)
            }
            named @ ViewLabel::Named(_) => named,
        };
        let views = &mut self.sequences.views;
        self.views
            .number(label.to_string(), || views.push(label.clone()))
    }

    /// Returns the number of an origin, and adds it if it is new.
    fn origin(&mut self, origin: SequenceOrigin) -> usize {
        let origins = &mut self.sequences.origins;
        self.origins.number(origin.clone(), || origins.push(origin))
    }

    fn push(&mut self, take: usize, origin: usize, view: usize) {
        self.push_for(SequencePurpose::Any, take, origin, view);
    }

    fn push_for(&mut self, purpose: SequencePurpose, take: usize, origin: usize, view: usize) {
        self.sequences.list.push(Sequence {
            take,
            origin,
            view,
            purpose,
        });
    }
}

/// The form in which sequences are requested.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Form {
    /// The template, and the settings for drawing silhouettes; for silhouettes from files, their
    /// size and framing.
    pub settings: Settings,
    /// The number of silhouettes in a sequence from a recording, or `None` for all. For drawn
    /// sequences, the settings state it.
    pub frames: Option<usize>,
}

/// Counts of the silhouettes that were shown.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ShownCounts {
    /// The number of silhouettes in the GEIs and sequences.
    pub silhouettes: u64,
    /// The share of the figures' pixels outside of the images, summed over silhouettes, or `None`
    /// if the source does not state it.
    pub clipped: Option<f64>,
    /// The number of frames without a figure, which were left out.
    pub empty: u64,
}

impl ShownCounts {
    /// Returns the number of the last frame of a sequence whose first frame has this number.
    #[must_use]
    pub const fn last_frame(&self, first: usize) -> usize {
        first + (self.silhouettes + self.empty).saturating_sub(1) as usize
    }

    /// Returns the sum of both counts.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        Self {
            silhouettes: self.silhouettes + other.silhouettes,
            clipped: self.clipped.zip(other.clipped).map(|(a, b)| a + b),
            empty: self.empty + other.empty,
        }
    }
}

/// A source of sequences.
pub enum SequenceSource<'a> {
    /// Walks of a pack, which are drawn.
    Walks(PackWalks<'a>),
    /// Templates of a dataset.
    Dataset(Box<dataset::DatasetTemplates>),
    /// Silhouettes of a tree.
    Tree(Box<Recordings>),
}

impl SequenceSource<'_> {
    /// Opens the folder `path`: a dataset, or a tree of silhouettes with this layout.
    ///
    /// # Errors
    /// If the folder is neither, or cannot be read.
    pub fn open(path: &Path, made: &[MadeTake], layout: &TreeLayout) -> Result<Self> {
        // A dataset has a manifest; a tree that EdgeGait wrote has `sequences.csv`, too.
        let has_templates =
            path.join("manifest.json").exists() && !path.join("sequences.csv").exists();
        let is_of_pictures = Dataset::pictures(path).is_some();
        if Tree::is_at(path) && !has_templates && !is_of_pictures {
            return Ok(Self::Tree(Box::new(Recordings::open(path, layout)?)));
        }
        let files = ["manifest.json", "index.csv", "geis.npy"];
        if !is_of_pictures && !files.iter().any(|name| path.join(name).exists()) {
            return Err(Error::input(
                path,
                "expected a dataset (manifest.json, index.csv, geis.npy) or a tree of silhouettes (<person>/<take>/<view>/ with frames), found neither",
            ));
        }
        let dataset = Dataset::open(path)?;
        let geis = dataset::DatasetTemplates::new(dataset, path.to_path_buf(), made);
        Ok(Self::Dataset(Box::new(geis)))
    }

    /// Returns the labels of all sequences.
    #[must_use]
    pub const fn sequences(&self) -> &Sequences {
        match self {
            Self::Walks(walks) => &walks.sequences,
            Self::Dataset(geis) => &geis.sequences,
            Self::Tree(recordings) => &recordings.sequences,
        }
    }

    /// Shows the sequences with these numbers, in ascending order: `sink` gets the number and the
    /// bytes (0 to 255, rows from the top; silhouettes one after another).
    ///
    /// # Errors
    /// The first error of `sink`, of drawing, or of reading.
    pub fn show(
        &self,
        wanted: &[usize],
        form: &Form,
        sink: &mut dyn FnMut(usize, &[u8]) -> Result<()>,
    ) -> Result<ShownCounts> {
        match self {
            Self::Walks(walks) => walks.show(wanted, form, sink),
            Self::Dataset(geis) => geis.show(wanted, form, sink),
            Self::Tree(recordings) => recordings.show(wanted, form, sink),
        }
    }
}

/// Returns the mean of silhouettes with pixels of 0 or 255, rounded half up like the core's GEI.
fn mean(silhouettes: &[u8], size: Size) -> Vec<u8> {
    let pixels = size.pixels();
    let frames = (silhouettes.len() / pixels) as u64;
    (0..pixels)
        .map(|pixel| {
            let column = silhouettes.iter().skip(pixel).step_by(pixels);
            let sum: u64 = column.map(|&byte| u64::from(byte)).sum();
            u8::try_from((sum + frames / 2).checked_div(frames).unwrap_or(0)).unwrap_or(u8::MAX)
        })
        .collect()
}
