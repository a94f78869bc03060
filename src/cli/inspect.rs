//! `edgegait inspect`: shows what a pack contains, and its size and errors.

use super::args::{Common, FileArgs};
use crate::dataset::sequences::PackSource;
use crate::encode::inspect::Summary;
use crate::error::Result;
use crate::files::ResultHeader;
use std::path::PathBuf;

/// Show the contents of a pack: people, walks, bytes, errors, memory
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  edgegait inspect cohort.egp --json -")]
pub(super) struct InspectArgs {
    /// The pack
    #[arg(value_name = "PACK")]
    pack: PathBuf,
    /// Measure the decoded and rendered people, and print the results beside published norms
    #[cfg(feature = "import")]
    #[arg(long)]
    audit: bool,
    #[command(flatten)]
    pub common: Common,
}

impl InspectArgs {
    /// Returns the files that the command reads and writes.
    pub(super) fn files(&self) -> FileArgs {
        FileArgs {
            inputs: vec![self.pack.clone()],
            outputs: Vec::new(),
        }
    }
}

/// Runs the subcommand.
pub(super) fn run(args: &InspectArgs) -> Result<()> {
    let source = PackSource::read(&args.pack)?;
    let mut header = ResultHeader::new("inspect", args.common.seed);
    header.inputs = source.inputs;
    let summary = Summary::from_bytes(header, &args.pack, &source.bytes)?;
    #[cfg(feature = "import")]
    let summary = if args.audit {
        summary.with_audit(&source.bytes)
    } else {
        summary
    };
    args.common.say(format_args!("{summary:#}"));
    args.common.write_json(&summary)
}
