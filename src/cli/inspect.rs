//! `edgegait inspect`: shows what a pack, a tree or a dataset contains.

mod folder;

use super::args::{Common, FileArgs};
use super::layout::{LayoutArgs, refuse_without_tree};
use super::tree_cycles::CuttingArgs;
use crate::dataset::sequences::PackSource;
use crate::encode::inspect::Summary;
use crate::error::Result;
use crate::files::ResultHeader;
use std::path::PathBuf;

/// Show what a pack contains and costs, or what a tree of silhouettes or a dataset contains by
/// person, take and view, with gait cycles and what cannot be read
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  edgegait inspect cohort.egp --json -\n  edgegait inspect silhouettes --fps 30     # a tree: recordings, gait cycles, and what cannot be read\n  edgegait inspect dataset"
)]
pub(super) struct InspectArgs {
    /// The pack, tree (<person>/<take>/<view>/) or dataset
    #[arg(value_name = "PACK|TREE|DATASET")]
    path: PathBuf,
    /// Measure the decoded and rendered people, and print the results beside published norms
    #[cfg(feature = "import")]
    #[arg(long)]
    audit: bool,
    #[command(flatten)]
    cutting: CuttingArgs,
    #[command(flatten)]
    layout: LayoutArgs,
    #[command(flatten)]
    pub common: Common,
}

impl InspectArgs {
    /// Returns the files that the command reads and writes.
    pub(super) fn files(&self) -> FileArgs {
        FileArgs {
            inputs: vec![self.path.clone()],
            outputs: Vec::new(),
        }
    }
}

/// Runs the subcommand.
pub(super) fn run(args: &InspectArgs) -> Result<()> {
    if args.path.is_dir() {
        return folder::run(args);
    }
    refuse_without_tree(args.cutting.given().into_iter().chain(args.layout.given()))?;
    let source = PackSource::read(&args.path)?;
    let mut header = ResultHeader::new("inspect", args.common.seed);
    header.inputs = source.inputs;
    let summary = Summary::from_bytes(header, &args.path, &source.bytes)?;
    #[cfg(feature = "import")]
    let summary = if args.audit {
        summary.with_audit(&source.bytes)
    } else {
        summary
    };
    args.common.say(format_args!("{summary:#}"));
    args.common.write_json(&summary)
}
