//! Options for reading a tree whose names and files are ambiguous.

use std::fmt;
use std::path::PathBuf;

/// Options for reading a tree.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct TreeLayout {
    /// Whether views are cameras or recordings, even if their names look like angles.
    pub named_views: bool,
    /// The modality to read, if several share a view's folder.
    pub modality: Option<Modality>,
}

/// A choice among the files in a view's folder.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Modality {
    /// The files whose name without extension contains this text.
    Named(String),
    /// The file with this number in the order of names, from 0, as in OpenGait's `data_in_use`.
    Number(usize),
}

impl Modality {
    /// Parses a number from 0 or a part of a name; digits after a leading zero are part of a name.
    #[must_use]
    pub fn parse(text: &str) -> Self {
        let is_number = text == "0" || !text.starts_with('0');
        match text.parse().ok().filter(|_| is_number) {
            Some(number) => Self::Number(number),
            None => Self::Named(text.to_owned()),
        }
    }

    /// Selects the files of the modality.
    pub(super) fn select(&self, files: Vec<PathBuf>) -> Vec<PathBuf> {
        match self {
            Self::Number(number) => {
                // OpenGait sorts names as text.
                let mut sorted = files;
                sorted.sort_unstable();
                sorted.into_iter().skip(*number).take(1).collect()
            }
            Self::Named(part) => {
                let is_meant = |path: &PathBuf| {
                    let stem = path.file_stem().unwrap_or_default();
                    stem.to_string_lossy().contains(part.as_str())
                };
                files.into_iter().filter(is_meant).collect()
            }
        }
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
