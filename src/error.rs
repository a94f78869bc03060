//! The one error of the host: where, what was expected, what was found, what to do.
//!
//! Each area has a kind of its own with the causes that a caller may want to tell apart. Messages
//! name causes and settings, never flags: the command adds the flags that help.

mod choice;
mod encode;
mod evaluate;
mod report;
mod score;
mod sweep;
mod train;

use edgegait_core::camera::ViewpointError;
use edgegait_core::cycle::FrameRateError;
use edgegait_core::format::FormatError;
use edgegait_core::raster::columns::AzimuthError;
use edgegait_core::template::FrameError;
use std::fmt;
use std::path::{Path, PathBuf};

pub use choice::ChoiceError;
pub use encode::EncodeError;
pub use evaluate::EvaluateError;
pub use report::ReportError;
pub use score::{ScoreError, TemplateOrigin};
pub use sweep::SweepError;
pub use train::TrainError;

/// A result whose error is ready to be shown to a user.
pub type Result<T> = std::result::Result<T, Error>;

/// Why an error came about, where it may be of many types.
pub type Cause = Box<dyn std::error::Error + Send + Sync>;

/// Why work could not be done.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A file holds something that cannot be used.
    #[error("{}{place}: {problem}", path.display())]
    Input {
        /// The file.
        path: PathBuf,
        /// Where in it.
        place: FilePlace,
        /// What was expected, what was found, what to do.
        problem: String,
        /// What else may help.
        remedy: Option<Remedy>,
    },
    /// The operating system refused.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// A value or a flag makes no sense, in words: exit code 2.
    #[error("{0}")]
    Usage(String),
    /// A setting makes no sense, or settings do not go together: exit code 2.
    #[error(transparent)]
    Choice(#[from] ChoiceError),
    /// Angles are no viewpoint: exit code 2.
    #[error(transparent)]
    Viewpoint(#[from] ViewpointError),
    /// Cycles are not looked for at such a frame rate: exit code 2.
    #[error(transparent)]
    FrameRate(#[from] FrameRateError),
    /// Walks cannot be encoded, or people have no plausible body; what is left can do without them.
    #[error("{}", lines(.0))]
    Refused(Vec<RefusedWalk>),
    /// Bytes are no pack.
    #[error(transparent)]
    Pack(#[from] FormatError),
    /// People or their walks are not encoded.
    #[error(transparent)]
    Encode(#[from] EncodeError),
    /// Nothing is learnt.
    #[error(transparent)]
    Train(#[from] TrainError),
    /// Walks are not drawn.
    #[error(transparent)]
    Sweep(#[from] SweepError),
    /// Viewpoints do not share an azimuth.
    #[error(transparent)]
    Azimuth(#[from] AzimuthError),
    /// A frame does not belong into a template.
    #[error(transparent)]
    Frame(#[from] FrameError),
    /// A recognizer is not run, or its answers are not used.
    #[error(transparent)]
    Score(#[from] ScoreError),
    /// Recognizers are not compared.
    #[error(transparent)]
    Evaluate(#[from] EvaluateError),
    /// Results are not shown.
    #[error(transparent)]
    Report(#[from] ReportError),
    /// A mesh is no figure that a body can be fitted to, in words.
    #[error("{0}")]
    Mesh(String),
    /// Nothing is there of what the work needs: a defect of what asks for it.
    #[error("expected {0}, found none")]
    Missing(&'static str),
    /// The system starts no threads.
    #[error("cannot start threads: {0}")]
    Threads(#[from] rayon::ThreadPoolBuildError),
    /// Results cannot be written as JSON.
    #[error("cannot write the results as JSON: {0}")]
    Json(#[from] serde_json::Error),
    /// Results cannot be written as CSV.
    #[error("cannot write the results as CSV: {0}")]
    Csv(#[from] csv::Error),
    /// Numbers do not fill an array: a defect of what counted them.
    #[error(transparent)]
    Shape(#[from] ndarray::ShapeError),
    /// What else stops the command, or a process that it started, in words.
    #[error("{0}")]
    Failed(String),
}

/// A walk that cannot be encoded, or a person with all walks.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RefusedWalk {
    /// Who walks.
    pub subject: String,
    /// Name of the take and number of its cycle; `None` for all of the subject's.
    pub walk: Option<(String, u16)>,
    /// What was expected, what was found, what to do.
    pub problem: String,
}

impl fmt::Display for RefusedWalk {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.walk {
            Some((name, _)) => write!(f, "{} {name}: {}", self.subject, self.problem),
            None => write!(f, "subject {:?}: {}", self.subject, self.problem),
        }
    }
}

/// Names one after the other, or that there are none.
fn listed(names: &[String]) -> String {
    if names.is_empty() {
        "none".to_owned()
    } else {
        names.join(", ")
    }
}

/// Each in a line.
fn lines(refused: &[RefusedWalk]) -> String {
    let lines: Vec<String> = refused.iter().map(ToString::to_string).collect();
    lines.join("\n")
}

/// What may help where an input cannot be used: another setting.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Remedy {
    /// To run the model with ONNX Runtime.
    OnnxRuntime,
    /// To name one of a file's animations.
    NameAnimation,
    /// To take folders' names as those of subjects.
    FolderIsSubject,
    /// To frame a tree's pictures anew instead of taking them as they are stored.
    FrameAnew,
    /// To make a dataset of templates, or a tree.
    OtherTemplate,
    /// To take the names of views for those of cameras or recordings.
    NamedViews,
    /// To name one of the modalities in a folder.
    OneModality,
    /// To give a picture of the empty scene.
    GiveBackground,
}

/// A place in an input file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FilePlace {
    /// The file as a whole.
    File,
    /// A line, counted from 1.
    Line(usize),
    /// A byte, counted from 0.
    Byte(usize),
}

impl fmt::Display for FilePlace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::File => Ok(()),
            Self::Line(line) => write!(f, ":{line}"),
            Self::Byte(byte) => write!(f, " at byte {byte}"),
        }
    }
}

impl Error {
    /// A file as a whole cannot be used.
    pub fn input(path: impl AsRef<Path>, problem: impl Into<String>) -> Self {
        Self::at(path, FilePlace::File, problem)
    }

    /// Something at a known place of a file cannot be used.
    pub fn at(path: impl AsRef<Path>, place: FilePlace, problem: impl Into<String>) -> Self {
        Self::Input {
            path: path.as_ref().to_path_buf(),
            place,
            problem: problem.into(),
            remedy: None,
        }
    }

    /// The same, if it is about an input, with what may help.
    #[must_use]
    pub fn with_remedy(mut self, may_help: Remedy) -> Self {
        if let Self::Input { remedy, .. } = &mut self {
            *remedy = Some(may_help);
        }
        self
    }

    /// A file's `text` is not the TOML that is expected, at the line that `error` names.
    pub fn toml(path: impl AsRef<Path>, text: &str, error: &toml::de::Error) -> Self {
        let line = error.span().map(|span| {
            let before = text.as_bytes().iter().take(span.start);
            1 + before.filter(|byte| **byte == b'\n').count()
        });
        let place = line.map_or(FilePlace::File, FilePlace::Line);
        Self::at(path, place, error.message().trim())
    }

    /// The system refused to read or write `path`.
    pub fn io(path: impl AsRef<Path>, source: std::io::Error) -> Self {
        Self::Io {
            path: path.as_ref().to_path_buf(),
            source,
        }
    }

    /// The process's exit code for this error: 2 for usage, bodies that nobody has among it, 1
    /// otherwise.
    #[must_use]
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Usage(_) | Self::Choice(_) | Self::Viewpoint(_) | Self::FrameRate(_) => 2,
            Self::Refused(refused) if refused.iter().all(|one| one.walk.is_none()) => 2,
            _ => 1,
        }
    }
}
