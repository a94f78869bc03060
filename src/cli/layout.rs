//! How a tree of silhouettes is to be read: flags of the commands that read one.

use crate::dataset::{Modality, TreeLayout};
use crate::error::{Error, Result};

/// The flags.
#[derive(Clone, Debug, Default, clap::Args)]
pub(super) struct LayoutArgs {
    /// Take the names of a tree's views for those of cameras or recordings, even if they look like
    /// angles [default: names where nobody's views are named by angles]
    #[arg(long)]
    named_views: bool,
    /// Which files of a view's folder to read, if several modalities share it: a part of their name,
    /// or a number from 0 in the order of names
    #[arg(long, value_name = "NAME|N")]
    modality: Option<String>,
}

/// Refuses flags that say how a tree is read, where there is none.
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

impl LayoutArgs {
    /// The flags, and whether each was given.
    pub(super) fn given(&self) -> [(&'static str, bool); 2] {
        [
            ("--named-views", self.named_views),
            ("--modality", self.modality.is_some()),
        ]
    }

    /// The layout.
    pub(super) fn layout(&self) -> TreeLayout {
        TreeLayout {
            named_views: self.named_views,
            modality: self.modality.as_deref().map(Modality::parse),
        }
    }
}
