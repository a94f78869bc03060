//! Errors about settings that are invalid, alone or together.

use super::{Cause, listed};
use std::path::PathBuf;

/// An invalid choice of settings; the process's exit code is 2.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ChoiceError {
    /// A run was interrupted, and can be resumed.
    #[error(
        "{}: an earlier run that was writing {} did not finish",
        folder.display(), target.display()
    )]
    Unfinished {
        /// The folder of the unfinished run.
        folder: PathBuf,
        /// The dataset that it was to become.
        target: PathBuf,
    },
    /// A complete dataset of another run exists.
    #[error("{}: is already complete, from another run: {differs}", target.display())]
    OtherRun {
        /// The dataset.
        target: PathBuf,
        /// The difference between the runs.
        differs: String,
    },
    /// A design has no such split, or has several and none was named.
    #[error(
        "{}, expected one of {}",
        match name {
            Some(name) => format!("there is no split {name:?}"),
            None => "no split is named".to_owned(),
        },
        listed(known)
    )]
    NoSplit {
        /// The requested split.
        name: Option<String>,
        /// The splits of the design.
        known: Vec<String>,
    },
    /// A walk does not have this many variations.
    #[error("there are no variations left for pass {0}")]
    NoMorePasses(u32),
    /// More items are requested in one call than fit into memory.
    #[error("expected at most {most} bytes at once, found {bytes} of {items} items: ask for fewer")]
    TooMuchAtOnce {
        /// Number of items.
        items: usize,
        /// Number of their bytes.
        bytes: usize,
        /// The maximum number of bytes.
        most: usize,
    },
    /// A file already exists.
    #[error("{}: already exists", .0.display())]
    IsThere(PathBuf),
    /// A name cannot be a folder's name on every system.
    #[error(
        "{0:?}: expected a name that a folder can have, without / \\ : * ? \" < > | and without a dot at its start"
    )]
    FolderName(String),
    /// Framing a whole cycle with one scale needs parallel rays.
    #[error("framing cycle uses one scale for all elevations, which needs parallel rays")]
    CycleNeedsParallelRays,
    /// A camera is too near or too far, metres.
    #[error("expected a distance of 0.1 to 1,000,000 metres, found {0}")]
    Distance(f64),
    /// A field of view is too narrow or too wide, degrees.
    #[error("expected a field of view of 0.1 to 170 degrees, found {0}")]
    FieldOfView(f64),
    /// A camera's aim is out of range.
    #[error("expected an aim of three numbers within a million metres, found {0}")]
    Aim(glam::Vec3),
    /// A setting cannot have its value here.
    #[error("{setting} {value}: {problem}")]
    Setting {
        /// Name of the setting: `raster`, `provider` or `cpus`.
        setting: &'static str,
        /// Its value.
        value: String,
        /// The reason.
        #[source]
        problem: SettingError,
    },
    /// Augmentation needs a template that is an image.
    #[error("expected a template that is an image, found {0}")]
    NoImage(&'static str),
    /// Crops leave nothing or too little.
    #[error(
        "expected crops in at least 1 step of at least 1 row, with at most {most} rows cut off in the last step, found {steps} steps of {rows} rows"
    )]
    Crops {
        /// Number of steps.
        steps: usize,
        /// Rows that each step cuts off.
        rows: usize,
        /// The maximum number of rows that may be cut off in all.
        most: usize,
    },
    /// Errors of GEIs are measured against exact coverage, which has one framing and lens.
    #[error("errors are measured with framing height and lens ortho, found {framing} and {lens}")]
    NotMeasured {
        /// The framing.
        framing: &'static str,
        /// The lens.
        lens: &'static str,
    },
    /// An uncut motion has no GEI whose error could be measured.
    #[error("{subject} {walk} is an uncut motion, which has no GEI")]
    UncutHasNoGei {
        /// Name of the subject.
        subject: String,
        /// Name of the walk.
        walk: String,
    },
    /// A protocol asks for a condition that was not chosen.
    #[error(
        "the protocol needs condition {name:?}, found {}",
        .known.join(", ")
    )]
    NoCondition {
        /// The condition.
        name: String,
        /// The chosen conditions.
        known: Vec<String>,
    },
    /// A number of cycles is given although no cycles are made.
    #[error("protocol {0} uses recorded cycles as probes here, since people have several takes")]
    CyclesAreRecorded(String),
    /// The ONNX Runtime library was not found.
    #[error(
        "expected the ONNX Runtime library, found none (pip install onnxruntime, or name its file); looked at\n  {}",
        looked.join("\n  ")
    )]
    NoLibrary {
        /// Each searched place, and what was found there.
        looked: Vec<String>,
    },
    /// Only ONNX Runtime can be measured in a bare loop.
    #[error("a bare runtime: expected ONNX Runtime, found the embedded runtime")]
    BareEmbedded,
    /// A name is unknown.
    #[error("there is no {what} {name:?}: expected one of {}", .known.join(", "))]
    Unknown {
        /// The kind of thing: a subject, a walk, a take.
        what: &'static str,
        /// The name.
        name: String,
        /// Some known names.
        known: Vec<String>,
    },
    /// No walk of a chosen person has a chosen name.
    #[error("no walk of the chosen people has the chosen name")]
    NothingChosen,
    /// Several sources cannot be trained on together.
    #[error(
        "expected sources of one {setting}, found {} of {} and {} of {}",
        .values[0], .sources[0], .values[1], .sources[1]
    )]
    SourcesDiffer {
        /// `template`, `size` or `framing`.
        setting: &'static str,
        /// Two of the sources.
        sources: [String; 2],
        /// The value of each.
        values: [&'static str; 2],
    },
    /// A dataset is already augmented, which cannot be done twice.
    #[error("{} is augmented already", .0.display())]
    Augmented(PathBuf),
    /// A folder contains a dataset of another program.
    #[error("{}: holds a dataset that edgegait sweep did not make", .0.display())]
    ForeignDataset(PathBuf),
}

/// The reason why a setting cannot have a value.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SettingError {
    /// Elevations do not share a scale, which columns need.
    #[error(
        "it draws all elevations of an azimuth in one pass, which needs one scale and parallel rays, but {setting} {value} has {has}"
    )]
    ColumnsShareScale {
        /// `framing` or `lens`.
        setting: &'static str,
        /// Its value.
        value: &'static str,
        /// The property that it has instead.
        has: &'static str,
    },
    /// Columns cannot make this template.
    #[error("it sums frames as it draws them, which makes a gei, not {0}")]
    ColumnsSumFrames(&'static str),
    /// Columns cannot sum this many frames.
    #[error("expected at most {0} frames a cycle")]
    ColumnsFrames(u32),
    /// A raster cannot draw under a condition.
    #[error("condition {condition} {why}")]
    RasterUnderCondition {
        /// The condition.
        condition: String,
        /// The property of the condition that the raster cannot draw.
        why: &'static str,
    },
    /// A raster draws grey pixels, which confounders of the image cannot use.
    #[error(
        "confounders of the image need pixels that are on or off, expected rows or skia, which have one sample a pixel"
    )]
    GreyRaster,
    /// The embedded runtime does not have this provider.
    #[error("the embedded runtime has cpu only")]
    EmbeddedProvider,
    /// A library was built without a provider.
    #[error(
        "expected a library that was built with {provider}, found {} in {}",
        listed(known), library.display()
    )]
    Provider {
        /// The provider.
        provider: &'static str,
        /// The providers that it was built with.
        known: Vec<String>,
        /// The library.
        library: PathBuf,
    },
    /// Processors cannot be chosen.
    #[error("{0}")]
    Processors(#[source] Cause),
}

impl SettingError {
    /// Returns the error about a setting with this value.
    pub(crate) fn refuses(self, setting: &'static str, value: impl ToString) -> super::Error {
        ChoiceError::Setting {
            setting,
            value: value.to_string(),
            problem: self,
        }
        .into()
    }
}
