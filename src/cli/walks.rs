//! Flags that choose walks from a pack or from the built-in cohort.

use super::args::Common;
use crate::dataset::sequences::{BUILT_IN_WALK, PackSource, Selection, built_in};
use crate::error::Result;
use edgegait_core::pack::Pack;
use std::path::PathBuf;

/// The flags that choose walks.
#[derive(Clone, Debug, Default, clap::Args)]
pub(super) struct SelectionArgs {
    /// Only these people, by name
    #[arg(long, value_name = "NAME[,NAME..]", value_delimiter = ',')]
    pub subjects: Vec<String>,
    /// Only these walks, by name [default: walk-5kmh of the built-in cohort, all of a pack; for
    /// `render` without names, the first]
    #[arg(long, value_name = "NAME[,NAME..]", value_delimiter = ',')]
    pub walks: Vec<String>,
}

/// The flags that choose a pack and its walks.
#[derive(Clone, Debug, clap::Args)]
pub(super) struct SourceArgs {
    /// A pack [default: the built-in cohort of 26 people]
    #[arg(value_name = "PACK")]
    pub pack: Option<PathBuf>,
    #[command(flatten)]
    pub selection: SelectionArgs,
    /// A pack held by the program that runs the command in its own process.
    #[arg(skip)]
    pub held: Option<PackSource>,
}

impl SelectionArgs {
    /// Returns the requested selection; by default, one walk of each person of the built-in cohort.
    #[must_use]
    pub(super) fn selection(&self, is_built_in: bool) -> Selection {
        Selection {
            subjects: self.subjects.clone(),
            walks: if self.walks.is_empty() && is_built_in {
                vec![BUILT_IN_WALK.into()]
            } else {
                self.walks.clone()
            },
        }
    }
}

impl SourceArgs {
    /// Creates the choice of a pack file, or of the built-in cohort.
    pub(super) const fn new(pack: Option<PathBuf>, selection: SelectionArgs) -> Self {
        Self {
            pack,
            selection,
            held: None,
        }
    }

    /// Reads the pack, or makes the built-in cohort at the speeds that are needed.
    ///
    /// # Errors
    /// If the file cannot be read or is not a pack.
    pub(super) fn load(&self, common: &Common) -> Result<PackSource> {
        if let Some(held) = &self.held {
            return Ok(held.clone());
        }
        if let Some(path) = &self.pack {
            return PackSource::read(path);
        }
        // It is stored, so that nothing takes long.
        let options = built_in(&self.selection.selection(true).walks);
        PackSource::made(&options, &|| common.stop.check())
    }

    /// Returns the numbers of the chosen walks, in pack order.
    ///
    /// # Errors
    /// If a name is unknown.
    pub(super) fn choose(&self, pack: &Pack<'_>) -> Result<Vec<usize>> {
        let is_built_in = self.pack.is_none() && self.held.is_none();
        self.selection.selection(is_built_in).selected_walks(pack)
    }
}
