//! Flags that choose how a tree of silhouettes is read.

use crate::dataset::{Modality, TreeLayout};
use crate::error::{Error, Result};
use std::path::Path;

/// The flags that choose how a tree is read.
#[derive(Clone, Debug, Default, clap::Args)]
pub(super) struct LayoutArgs {
    /// Treat the names of a tree's views as cameras or recordings, even if they look like angles
    /// [default: only if no person's views are named by angles]
    #[arg(long)]
    named_views: bool,
    /// Modality to read if a view's folder holds several: a part of the file name, or the number of
    /// the file in order of names, from 0
    #[arg(long, value_name = "NAME|N")]
    modality: Option<String>,
}

/// Rejects flags about reading a tree where there is none.
pub(super) fn refuse_without_tree(
    mut flags: impl Iterator<Item = (&'static str, bool)>,
) -> Result<()> {
    match flags.find(|(_, is_given)| *is_given) {
        None => Ok(()),
        Some((flag, _)) => Err(Error::Usage(format!(
            "{flag}: expected a tree of silhouettes"
        ))),
    }
}

/// Returns the error that nothing in a folder was chosen.
pub(super) fn none_chosen(path: &Path) -> Error {
    Error::input(
        path,
        "expected some of the chosen people, takes and viewpoints, found none",
    )
}

impl LayoutArgs {
    /// Returns the flags, and whether each was given.
    pub(super) fn given(&self) -> [(&'static str, bool); 2] {
        [
            ("--named-views", self.named_views),
            ("--modality", self.modality.is_some()),
        ]
    }

    /// Returns the layout.
    pub(super) fn layout(&self) -> TreeLayout {
        TreeLayout {
            named_views: self.named_views,
            modality: self.modality.as_deref().map(Modality::parse),
        }
    }
}
