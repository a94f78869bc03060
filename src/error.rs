//! The error type of the host. Messages state where, what was expected, what was found, what to do.
//!
//! Each area has an error type of its own, with the causes that a caller may want to distinguish.
//! Messages name causes and settings, never flags: the command adds the flags that help.

mod choice;
mod encode;
mod evaluate;
mod inference;
mod report;
mod sweep;
mod train;
mod visible;

use edgegait_core::camera::ViewpointError;
use edgegait_core::cycle::FrameRateError;
use edgegait_core::format::FormatError;
use edgegait_core::raster::columns::AzimuthError;
use edgegait_core::template::FrameError;
use std::fmt;
use std::path::{Path, PathBuf};

pub use choice::{ChoiceError, SettingError};
pub use encode::EncodeError;
pub use evaluate::EvaluateError;
pub use inference::{InferenceError, TemplateOrigin};
pub use report::ReportError;
pub use sweep::SweepError;
pub use train::TrainError;
pub(crate) use visible::{is_hidden, visible, visible_name, visible_toml};

/// A result whose error is ready to be shown to a user.
pub type Result<T> = std::result::Result<T, Error>;

/// The cause of an error, of any type.
pub type Cause = Box<dyn std::error::Error + Send + Sync>;

/// Any error of the host.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A file holds something that cannot be used.
    #[error("{}{place}: {problem}", shown(path))]
    Input {
        /// The file.
        path: PathBuf,
        /// The place in the file.
        place: FilePlace,
        /// What was expected, what was found, what to do.
        problem: String,
        /// A setting that may help.
        remedy: Option<Remedy>,
    },
    /// The operating system refused an operation.
    #[error("{}: {source}", shown(path))]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// The system's error.
        source: std::io::Error,
    },
    /// A value or a flag is invalid, as the text explains: exit code 2.
    #[error("{0}")]
    Usage(String),
    /// A setting is invalid, or settings contradict each other: exit code 2.
    #[error(transparent)]
    Choice(#[from] ChoiceError),
    /// Angles are not a viewpoint: exit code 2.
    #[error(transparent)]
    Viewpoint(#[from] ViewpointError),
    /// Gait cycles cannot be found at this frame rate: exit code 2.
    #[error(transparent)]
    FrameRate(#[from] FrameRateError),
    /// Walks cannot be encoded, or people have no plausible body; the rest is not affected.
    #[error("{}", lines(.0))]
    Refused(Vec<RefusedWalk>),
    /// Bytes are not a pack.
    #[error(transparent)]
    Pack(#[from] FormatError),
    /// People or their walks cannot be encoded.
    #[error(transparent)]
    Encode(#[from] EncodeError),
    /// Training fails.
    #[error(transparent)]
    Train(#[from] TrainError),
    /// Walks cannot be drawn.
    #[error(transparent)]
    Sweep(#[from] SweepError),
    /// Viewpoints do not share an azimuth.
    #[error(transparent)]
    Azimuth(#[from] AzimuthError),
    /// A frame does not belong in a template.
    #[error(transparent)]
    Frame(#[from] FrameError),
    /// A recognizer cannot be run, or its answers cannot be used.
    #[error(transparent)]
    Inference(#[from] InferenceError),
    /// Recognizers cannot be compared.
    #[error(transparent)]
    Evaluate(#[from] EvaluateError),
    /// Results cannot be shown.
    #[error(transparent)]
    Report(#[from] ReportError),
    /// No body can be fitted to a mesh, as the text explains.
    #[error("{0}")]
    Mesh(String),
    /// Data that the work needs is missing: a defect of the caller.
    #[error("expected {0}, found none")]
    Missing(&'static str),
    /// The system cannot start threads.
    #[error("cannot start threads: {0}")]
    Threads(#[source] std::io::Error),
    /// Results cannot be written as JSON.
    #[error("cannot write the results as JSON: {0}")]
    Json(#[from] serde_json::Error),
    /// Results cannot be written as CSV.
    #[error("cannot write the results as CSV: {0}")]
    Csv(#[from] csv::Error),
    /// Numbers do not fill an array: a defect of the code that counted them.
    #[error(transparent)]
    Shape(#[from] ndarray::ShapeError),
    /// The caller ended the work.
    #[error("interrupted")]
    Cancelled,
    /// The command, or a process that it started, failed in another way, as the text explains.
    #[error("{0}")]
    Failed(String),
    /// An error about what these files hold, which names none of them.
    #[error("{}: {error}", paths(.files))]
    Within {
        /// The files and folders that were read.
        files: Vec<PathBuf>,
        /// The error.
        error: Box<Self>,
    },
}

/// A walk that cannot be encoded, or a person with all of their walks.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RefusedWalk {
    /// Name of the subject.
    pub subject: String,
    /// Name of the take and number of its cycle; `None` for all walks of the subject.
    pub walk: Option<(String, u16)>,
    /// What was expected, what was found, what to do.
    pub problem: String,
}

impl fmt::Display for RefusedWalk {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.walk {
            Some((name, _)) => {
                let (subject, name) = (visible_name(&self.subject), visible_name(name));
                write!(f, "{subject} {name}: {}", self.problem)
            }
            None => write!(f, "subject {:?}: {}", self.subject, self.problem),
        }
    }
}

/// Returns a path for a message, in one line.
fn shown(path: &Path) -> String {
    visible_name(&path.to_string_lossy()).into_owned()
}

/// Returns the first paths for a message, in one line, and how many more there are.
pub(crate) fn paths(all: &[PathBuf]) -> String {
    const MOST: usize = 3;
    let first: Vec<String> = all.iter().take(MOST).map(|path| shown(path)).collect();
    match all.len().saturating_sub(MOST) {
        0 => first.join(", "),
        more => format!("{} and {more} more", first.join(", ")),
    }
}

/// Joins names with commas, or returns "none".
fn listed(names: &[String]) -> String {
    if names.is_empty() {
        "none".to_owned()
    } else {
        names.join(", ")
    }
}

/// Formats each rejected walk as a line.
fn lines(refused: &[RefusedWalk]) -> String {
    let lines: Vec<String> = refused.iter().map(ToString::to_string).collect();
    lines.join("\n")
}

/// A setting that may help if an input cannot be used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Remedy {
    /// Run the model with ONNX Runtime.
    OnnxRuntime,
    /// Choose one of a file's animations.
    NameAnimation,
    /// State the frame rate of a recording.
    StateFrameRate,
    /// Choose one of the people in a recording.
    NamePerson,
    /// Give joints the names that the importer knows.
    RenameJoints,
    /// Use the names of folders as names of subjects.
    FolderIsSubject,
    /// Frame a tree's images again instead of using them as they are stored.
    FrameAnew,
    /// Make a dataset of templates, or a tree.
    OtherTemplate,
    /// Treat the names of views as names of cameras or recordings.
    NamedViews,
    /// Choose one of the modalities in a folder.
    OneModality,
    /// Give a picture of the empty scene.
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

impl From<rayon::ThreadPoolBuildError> for Error {
    fn from(error: rayon::ThreadPoolBuildError) -> Self {
        Self::Threads(std::io::Error::other(error))
    }
}

impl Error {
    /// Creates an error about a file as a whole.
    pub fn input(path: impl AsRef<Path>, problem: impl Into<String>) -> Self {
        Self::at(path, FilePlace::File, problem)
    }

    /// Creates an error about a known place in a file.
    pub fn at(path: impl AsRef<Path>, place: FilePlace, problem: impl Into<String>) -> Self {
        Self::Input {
            path: path.as_ref().to_path_buf(),
            place,
            problem: problem.into(),
            remedy: None,
        }
    }

    /// Adds a remedy to an error about an input; other errors stay as they are.
    #[must_use]
    pub fn with_remedy(mut self, may_help: Remedy) -> Self {
        if let Self::Input { remedy, .. } = &mut self {
            *remedy = Some(may_help);
        }
        self
    }

    /// Creates an error about a file whose `text` is not the expected TOML, at the line that
    /// `error` names.
    pub fn toml(path: impl AsRef<Path>, text: &str, error: &toml::de::Error) -> Self {
        let line = error.span().map(|span| {
            let before = text.as_bytes().iter().take(span.start);
            1 + before.filter(|byte| **byte == b'\n').count()
        });
        let place = line.map_or(FilePlace::File, FilePlace::Line);
        Self::at(path, place, error.message().trim())
    }

    /// Creates an error about a file that is not the expected JSON, at the line that `error` names.
    pub fn json(path: impl AsRef<Path>, error: &serde_json::Error) -> Self {
        let place = FilePlace::Line(error.line().max(1));
        Self::at(path, place, error.to_string())
    }

    /// Creates an error about a `path` that the system refused to read or write.
    pub fn io(path: impl AsRef<Path>, source: std::io::Error) -> Self {
        Self::Io {
            path: path.as_ref().to_path_buf(),
            source,
        }
    }

    /// Adds the files and folders that the work read, `inputs`, to an error about their contents
    /// that names none of them. Those that do not exist are left out.
    #[must_use]
    pub fn within(self, inputs: &[PathBuf]) -> Self {
        let is_of_contents = matches!(
            self,
            Self::Refused(_)
                | Self::Pack(_)
                | Self::Encode(_)
                | Self::Train(_)
                | Self::Sweep(_)
                | Self::Azimuth(_)
                | Self::Frame(_)
                | Self::Inference(_)
                | Self::Evaluate(_)
                | Self::Report(_)
                | Self::Mesh(_)
        );
        let text = self.to_string();
        let mut files: Vec<PathBuf> = inputs
            .iter()
            .filter(|path| path.exists())
            .cloned()
            .collect();
        files.dedup();
        let mut names = files.iter().filter_map(|path| path.file_name());
        let is_named = names.any(|name| text.contains(&*name.to_string_lossy()));
        if !is_of_contents || is_named || files.is_empty() {
            return self;
        }
        Self::Within {
            files,
            error: Box::new(self),
        }
    }

    /// Returns the process's exit code for this error: 2 for wrong usage, including implausible
    /// bodies, else 1.
    #[must_use]
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Usage(_) | Self::Choice(_) | Self::Viewpoint(_) | Self::FrameRate(_) => 2,
            Self::Refused(refused) if refused.iter().all(|refusal| refusal.walk.is_none()) => 2,
            Self::Within { error, .. } => error.exit_code(),
            _ => 1,
        }
    }
}
