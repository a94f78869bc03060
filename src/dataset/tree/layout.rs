//! How a tree is to be read, where its names and files do not tell.

use std::fmt;
use std::path::PathBuf;

/// How a tree is to be read.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct TreeLayout {
    /// Whether views are cameras or recordings, even if their names look like angles.
    pub named_views: bool,
    /// Which files of a view's folder are meant, if several modalities share it.
    pub modality: Option<Modality>,
}

/// Which of the files in a view's folder are meant.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Modality {
    /// Those whose name, without what follows its last dot, has this part.
    Named(String),
    /// The one of this number by name, from 0, as OpenGait's `data_in_use` counts them.
    Number(usize),
}

impl Modality {
    /// A number from 0, or a part of a name; digits behind a leading zero are such a part.
    #[must_use]
    pub fn parse(text: &str) -> Self {
        let is_number = text == "0" || !text.starts_with('0');
        match text.parse().ok().filter(|_| is_number) {
            Some(number) => Self::Number(number),
            None => Self::Named(text.to_owned()),
        }
    }

    /// Those of some files, which are in order.
    pub(super) fn of(&self, files: &[PathBuf]) -> Vec<PathBuf> {
        let is_meant = |(at, path): &(usize, &PathBuf)| match self {
            Self::Number(number) => at == number,
            Self::Named(part) => {
                let stem = path.file_stem().unwrap_or_default();
                stem.to_string_lossy().contains(part.as_str())
            }
        };
        let meant = files.iter().enumerate().filter(is_meant);
        meant.map(|(_, path)| path.clone()).collect()
    }
}

impl fmt::Display for Modality {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Named(part) => write!(f, "{part}"),
            Self::Number(number) => write!(f, "{number}"),
        }
    }
}
