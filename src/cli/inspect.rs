//! `edgegait inspect`: what a pack holds, and what it costs.

use super::args::{Common, Files};
use crate::dataset::Header;
use crate::error::Result;
use crate::source::PackSource;
use crate::summary::Summary;
use std::path::PathBuf;

/// Show what a pack holds and takes: people, walks, bytes, errors, memory
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  edgegait inspect cohort.egp --json -")]
pub(super) struct Args {
    /// The pack
    #[arg(value_name = "PACK")]
    pack: PathBuf,
    /// Measure people as they are decoded and drawn, and print it beside what is published
    #[cfg(feature = "import")]
    #[arg(long)]
    audit: bool,
    #[command(flatten)]
    pub common: Common,
}

impl Args {
    /// What it reads and writes.
    pub(super) fn files(&self) -> Files {
        Files {
            inputs: vec![self.pack.clone()],
            outputs: Vec::new(),
        }
    }
}

/// Runs the subcommand.
pub(super) fn run(args: &Args) -> Result<()> {
    let source = PackSource::read(&args.pack)?;
    let mut header = Header::new("inspect", args.common.seed);
    header.inputs = source.inputs;
    let summary = Summary::of(header, &args.pack, &source.bytes)?;
    #[cfg(feature = "import")]
    let summary = if args.audit {
        summary.with_audit(&source.bytes)
    } else {
        summary
    };
    args.common.say(format_args!("{summary:#}"));
    args.common.write_json(&summary)
}
