//! Flags that choose the number and size of random subspaces.

use crate::train::subspaces::SubspaceOptions;

#[derive(Debug, clap::Args)]
pub(super) struct SubspaceArgs {
    /// Number of random subspaces that vote
    /// [default: 300]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=2000))]
    subspaces: Option<u16>,
    /// Random eigenvectors of each subspace
    /// [default: 2]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=80))]
    eigenvectors: Option<u16>,
    /// Maximum number of discriminants of each subspace
    /// [default: 10]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=128))]
    discriminants: Option<u16>,
}

impl SubspaceArgs {
    /// Returns whether any of these flags was given.
    pub(super) fn is_given(&self) -> bool {
        [self.subspaces, self.eigenvectors, self.discriminants]
            .iter()
            .any(Option::is_some)
    }

    /// Returns the requested options, or the defaults.
    pub(super) fn subspaces(&self, seed: u64) -> SubspaceOptions {
        let usual = SubspaceOptions::default();
        let or = |given: Option<u16>, usual| given.map_or(usual, usize::from);
        SubspaceOptions {
            classifiers: or(self.subspaces, usual.classifiers),
            eigenvectors: or(self.eigenvectors, usual.eigenvectors),
            discriminants: or(self.discriminants, usual.discriminants),
            seed,
        }
    }
}
