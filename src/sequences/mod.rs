//! What recognizers are shown: sequences of a pack, of a dataset, or of a tree of silhouettes.
//!
//! A sequence is one gait cycle (or one recording) of one person, seen from one viewpoint. A
//! protocol chooses among sequences by who walks, in which take, and from where, and does not
//! know how they were made.

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
pub(crate) use tree::{Recordings, in_form};
pub(crate) use walks::{MadeTake, PackWalks};

use crate::dataset::{Dataset, Tree, TreeLayout};
use crate::error::{Error, Result};
use crate::sweep::{Settings, View};
use edgegait_core::silhouette::Size;
use serde::{Deserialize, Serialize};
use std::collections::HashMap;
use std::fmt;
use std::path::Path;

/// One recording of a person: all cycles of one walk.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SequenceTake {
    /// Number of the person in [`Sequences::subjects`].
    pub subject: usize,
    /// What it is called, such as `nm-01`.
    pub name: String,
    /// The condition, such as `normal` or `bag`; empty if the source does not say.
    pub condition: String,
}

/// What a sequence shows, whoever's it is: which cycle of which walk, and which variation of it.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct SequenceOrigin {
    /// The walk by its name in the source, which is the take's unless takes were made of walks.
    pub walk: String,
    /// Which recorded cycle of the walk, from 0; none where a sequence is a whole recording.
    pub cycle: Option<u32>,
    /// Which seeded variation of the cycle; 0 is the cycle itself.
    pub variation: u32,
    /// The seed of the variation.
    pub seed: u64,
}

/// From where a sequence is seen.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum ViewLabel {
    /// From this azimuth and elevation, degrees.
    Angles(f64, f64),
    /// By a camera, or in a recording, of which only the name is known.
    Named(String),
}

impl From<View> for ViewLabel {
    fn from(view: View) -> Self {
        let (azimuth, elevation) = view.angles_deg();
        Self::Angles(azimuth, elevation)
    }
}

impl ViewLabel {
    /// Azimuth and elevation in degrees, if they are known.
    #[must_use]
    pub const fn angles_deg(&self) -> Option<(f64, f64)> {
        match *self {
            Self::Angles(azimuth, elevation) => Some((azimuth, elevation)),
            Self::Named(_) => None,
        }
    }

    /// The name, where angles are not known.
    #[must_use]
    pub fn name(&self) -> Option<&str> {
        match self {
            Self::Angles(..) => None,
            Self::Named(name) => Some(name),
        }
    }
}

/// `90`, `90/15` at an elevation, or the name.
impl fmt::Display for ViewLabel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Angles(azimuth, 0.0) => write!(f, "{azimuth}"),
            Self::Angles(azimuth, elevation) => write!(f, "{azimuth}/{elevation}"),
            Self::Named(name) => write!(f, "{name}"),
        }
    }
}

/// One cycle of a take, seen from one viewpoint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sequence {
    /// Number of the take.
    pub take: usize,
    /// Number of what it shows in [`Sequences::origins`].
    pub origin: usize,
    /// Number of the viewpoint in [`Sequences::views`].
    pub view: usize,
}

/// Labels of all sequences of a source.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sequences {
    /// Names of the people, each once.
    pub subjects: Vec<String>,
    /// The takes, in the source's order.
    pub takes: Vec<SequenceTake>,
    /// What the sequences show, each once.
    pub origins: Vec<SequenceOrigin>,
    /// Viewpoints, each once.
    pub views: Vec<ViewLabel>,
    /// The sequences.
    pub list: Vec<Sequence>,
}

impl Sequences {
    /// The number of the person in a sequence.
    #[must_use]
    pub fn subject(&self, sequence: usize) -> usize {
        self.takes[self.list[sequence].take].subject
    }

    /// What a sequence shows.
    #[must_use]
    pub fn origin(&self, sequence: usize) -> &SequenceOrigin {
        &self.origins[self.list[sequence].origin]
    }

    /// Where a sequence is seen from.
    #[must_use]
    pub fn view_label(&self, sequence: usize) -> &ViewLabel {
        &self.views[self.list[sequence].view]
    }
}

/// Numbers of equal things, in the order of their first appearance.
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
    /// The number of `key`; `add` is called if it is new.
    fn number(&mut self, key: K, add: impl FnOnce()) -> usize {
        let next = self.numbers.len();
        *self.numbers.entry(key).or_insert_with(|| {
            add();
            next
        })
    }
}

/// Labels that are collected one by one.
#[derive(Debug, Default)]
struct Labels {
    sequences: Sequences,
    subjects: Register<String>,
    takes: Register<(usize, String, String)>,
    origins: Register<SequenceOrigin>,
    views: Register<String>,
}

impl Labels {
    /// The number of a take, which is added if it is new.
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

    /// The number of a viewpoint.
    fn view(&mut self, label: ViewLabel) -> usize {
        let label = match label {
            // Without a sign of zero.
            ViewLabel::Angles(azimuth, elevation) => {
                ViewLabel::Angles(azimuth + 0.0, elevation + 0.0)
            }
            named @ ViewLabel::Named(_) => named,
        };
        let views = &mut self.sequences.views;
        self.views
            .number(label.to_string(), || views.push(label.clone()))
    }

    /// The number of what a sequence shows, which is added if it is new.
    fn origin(&mut self, origin: SequenceOrigin) -> usize {
        let origins = &mut self.sequences.origins;
        self.origins.number(origin.clone(), || origins.push(origin))
    }

    fn push(&mut self, take: usize, origin: usize, view: usize) {
        let sequence = Sequence { take, origin, view };
        self.sequences.list.push(sequence);
    }
}

/// How sequences are wanted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Form {
    /// Which template is made of silhouettes, and how these are drawn or, if they come from
    /// files, of which size and framing they are.
    pub settings: Settings,
    /// How many silhouettes of a recording a sequence has; all if not said. Of what is drawn, the
    /// settings say it.
    pub frames: Option<usize>,
}

/// What was shown, besides the pictures.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Shown {
    /// Silhouettes in the GEIs and sequences.
    pub silhouettes: u64,
    /// Share of the figures' pixels that lay outside of the images, summed over silhouettes;
    /// none if the source does not know.
    pub clipped: Option<f64>,
    /// Frames without a figure, which were left out.
    pub empty: u64,
}

impl Shown {
    /// Both together.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        Self {
            silhouettes: self.silhouettes + other.silhouettes,
            clipped: self.clipped.zip(other.clipped).map(|(a, b)| a + b),
            empty: self.empty + other.empty,
        }
    }
}

/// Where sequences come from.
pub enum SequenceSource<'a> {
    /// Walks that are drawn.
    Walks(PackWalks<'a>),
    /// GEIs in a folder.
    Dataset(Box<dataset::DatasetTemplates>),
    /// Silhouettes in folders.
    Tree(Box<Recordings>),
}

impl SequenceSource<'_> {
    /// A dataset, or a tree of silhouettes that is read as `layout` says: `path` is a folder of one or
    /// the other kind.
    ///
    /// # Errors
    /// If it is neither, or cannot be read.
    pub fn open(path: &Path, made: &[MadeTake], layout: &TreeLayout) -> Result<Self> {
        // A tree that was made here has a manifest too, and no templates.
        let has_templates =
            path.join("manifest.json").exists() && !path.join("sequences.csv").exists();
        if Tree::is_at(path) && !has_templates {
            return Ok(Self::Tree(Box::new(Recordings::open(path, layout)?)));
        }
        let files = ["manifest.json", "index.csv", "geis.npy"];
        if !files.iter().any(|name| path.join(name).exists()) {
            return Err(Error::input(
                path,
                "expected a dataset (manifest.json, index.csv, geis.npy) or a tree of silhouettes (<person>/<take>/<view>/ with frames), found neither",
            ));
        }
        let dataset = Dataset::open(path)?;
        let geis = dataset::DatasetTemplates::new(dataset, path.to_path_buf(), made);
        Ok(Self::Dataset(Box::new(geis)))
    }

    /// The labels.
    #[must_use]
    pub const fn sequences(&self) -> &Sequences {
        match self {
            Self::Walks(walks) => &walks.sequences,
            Self::Dataset(geis) => &geis.sequences,
            Self::Tree(recordings) => &recordings.sequences,
        }
    }

    /// Shows the sequences of these numbers, which rise: `sink` gets the number, and the bytes
    /// (0 to 255, rows top first; of a sequence of silhouettes one after another).
    ///
    /// # Errors
    /// The first of `sink`, or of what cannot be drawn or read.
    pub fn show(
        &self,
        wanted: &[usize],
        form: &Form,
        sink: &mut dyn FnMut(usize, &[u8]) -> Result<()>,
    ) -> Result<Shown> {
        match self {
            Self::Walks(walks) => walks.show(wanted, form, sink),
            Self::Dataset(geis) => geis.show(wanted, form, sink),
            Self::Tree(recordings) => recordings.show(wanted, form, sink),
        }
    }
}

/// The mean of silhouettes, half up, as the core's GEI is: pixels of 0 or 255 each.
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
