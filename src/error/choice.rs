//! Settings that make no sense, alone or together.

use super::{Cause, listed};
use std::path::PathBuf;

/// What was chosen that cannot be: the process's exit code is 2.
///
/// Messages that begin with a setting's name mean the setting as a whole.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ChoiceError {
    /// A run was ended before it was done, and waits to be gone on with.
    #[error("{}: a run that was to be {} ended before it was done", folder.display(), target.display())]
    Unfinished {
        /// Where it waits.
        folder: PathBuf,
        /// What it was to be.
        target: PathBuf,
    },
    /// A whole dataset of another run is there.
    #[error("{}: is already complete, and of another run: {differs}", target.display())]
    OtherRun {
        /// The dataset.
        target: PathBuf,
        /// How it differs.
        differs: String,
    },
    /// A design has no such split, or several of which none was named.
    #[error(
        "{}, expected one of {}",
        match name {
            Some(name) => format!("there is no split {name:?}"),
            None => "no split is named".to_owned(),
        },
        listed(known)
    )]
    NoSplit {
        /// What was asked for.
        name: Option<String>,
        /// Those that there are.
        known: Vec<String>,
    },
    /// There are not so many variations of a walk.
    #[error("there are no variations left for pass {0}")]
    NoMorePasses(u32),
    /// Nobody has so much memory to draw into.
    #[error("expected at most {most} bytes at once, found {bytes} of {items} items: ask for fewer")]
    TooMuchAtOnce {
        /// How many items.
        items: usize,
        /// How many bytes they are.
        bytes: usize,
        /// How many there may be.
        most: usize,
    },
    /// A file is there already.
    #[error("{}: already exists", .0.display())]
    IsThere(PathBuf),
    /// A name cannot be that of a folder on every system.
    #[error(
        "{0:?}: expected a name that can be a folder's, without / \\ : * ? \" < > | and no dot at its start"
    )]
    FolderName(String),
    /// One scale for a cycle needs rays without an eye.
    #[error("framing cycle fits one scale for all elevations, which only parallel rays have")]
    CycleNeedsParallelRays,
    /// A camera is too near or too far, metres.
    #[error("expected a distance of 0.1 to 1,000,000 metres, found {0}")]
    Distance(f64),
    /// A field of view is too narrow or too wide, degrees.
    #[error("expected a field of view of 0.1 to 170 degrees, found {0}")]
    FieldOfView(f64),
    /// A camera aims at no place.
    #[error("expected an aim of three metres within a million, found {0}")]
    Aim(glam::Vec3),
    /// Elevations have no scale that they share.
    #[error(
        "raster columns: it draws all elevations of an azimuth at once, for which they have to share one scale and parallel rays, but {setting} {value} has {has}"
    )]
    ColumnsShareScale {
        /// `framing` or `lens`.
        setting: &'static str,
        /// Its value.
        value: &'static str,
        /// What it has instead.
        has: &'static str,
    },
    /// Columns make no such template.
    #[error("raster columns: it sums frames as it draws them, which makes a gei, not {0}")]
    ColumnsSumFrames(&'static str),
    /// Columns sum fewer frames.
    #[error("raster columns: expected at most {0} frames a cycle")]
    ColumnsFrames(u32),
    /// A raster cannot draw under a condition.
    #[error("raster {raster}: condition {condition} {why}")]
    RasterUnderCondition {
        /// The raster.
        raster: &'static str,
        /// The condition.
        condition: String,
        /// What it does that the raster cannot.
        why: &'static str,
    },
    /// A raster draws grey where silhouettes are segmented into on and off.
    #[error(
        "raster {0}: confounders of the image segment it into on and off, expected rows or skia, which have one sample a pixel"
    )]
    GreyRaster(edgegait_core::raster::Rasterizer),
    /// Only a template that is an image has sides and a bottom to cut off.
    #[error("expected a template that is an image, found {0}")]
    NoImage(&'static str),
    /// Crops leave nothing or too little.
    #[error(
        "expected crops in at least 1 step of at least 1 row, and {most} rows cut off in the last step at most, found {steps} of {rows}"
    )]
    Crops {
        /// Steps.
        steps: usize,
        /// Rows that each cuts off.
        rows: usize,
        /// How many may be cut off in all.
        most: usize,
    },
    /// Exact coverage, which errors of GEIs are measured against, is of one framing and lens.
    #[error("errors are measured with framing height and lens ortho, found {framing} and {lens}")]
    NotMeasured {
        /// The framing.
        framing: &'static str,
        /// The lens.
        lens: &'static str,
    },
    /// A take has no GEI that could have an error.
    #[error("{subject} {walk} is a whole take, which has no GEI")]
    TakeHasNoGei {
        /// Who walks.
        subject: String,
        /// The take.
        walk: String,
    },
    /// A protocol asks for a condition that was not chosen.
    #[error(
        "there is no condition {name:?}, as the protocol asks for: expected it among {}",
        .known.join(", ")
    )]
    NoCondition {
        /// The condition.
        name: String,
        /// Those that were chosen.
        known: Vec<String>,
    },
    /// A number of cycles is given where none are made.
    #[error("protocol {0} probes with recorded cycles here, since people have several takes")]
    CyclesAreRecorded(String),
    /// Nothing says where ONNX Runtime is.
    #[error(
        "expected the ONNX Runtime library, found none (pip install onnxruntime, or name its file); looked at\n  {}",
        looked.join("\n  ")
    )]
    NoLibrary {
        /// Each place, and what was there.
        looked: Vec<String>,
    },
    /// The embedded runtime has another provider only.
    #[error("provider {0}: the embedded runtime has cpu only")]
    EmbeddedProvider(&'static str),
    /// A library was built without a provider.
    #[error(
        "provider {provider}: expected a library that was built with {provider}, found {} in {}",
        listed(known), library.display()
    )]
    Provider {
        /// The provider.
        provider: &'static str,
        /// Those that it was built with.
        known: Vec<String>,
        /// The library.
        library: PathBuf,
    },
    /// A runtime cannot be measured without what is around it.
    #[error("a bare runtime: expected ONNX Runtime, found the embedded runtime")]
    BareEmbedded,
    /// Processors cannot be chosen.
    #[error("cpus {cpus}: {cause}")]
    Processors {
        /// Their numbers.
        cpus: String,
        /// Why not.
        #[source]
        cause: Cause,
    },
    /// Nobody and nothing is called so.
    #[error("there is no {what} {name:?}: expected one of {}", .known.join(", "))]
    Unknown {
        /// What it would be: a subject, a walk, a take.
        what: &'static str,
        /// The name.
        name: String,
        /// Some names that there are.
        known: Vec<String>,
    },
    /// No walk is of a chosen person and has a chosen name.
    #[error("no walk of the chosen people has the chosen name")]
    NothingChosen,
    /// What several sources give cannot be trained on together.
    #[error(
        "expected sources of one {setting}, found {} of {} and {} of {}",
        .values[0], .sources[0], .values[1], .sources[1]
    )]
    SourcesDiffer {
        /// `template`, `size` or `framing`.
        setting: &'static str,
        /// Two of the sources.
        sources: [String; 2],
        /// What each gives.
        values: [&'static str; 2],
    },
    /// A dataset is augmented, which cannot be done twice.
    #[error("{} is augmented already", .0.display())]
    Augmented(PathBuf),
    /// A folder holds a dataset of another program.
    #[error("{}: holds a dataset that edgegait sweep did not make", .0.display())]
    ForeignDataset(PathBuf),
}
