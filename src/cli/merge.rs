//! `edgegait merge`: joins shards into the same bytes as one run.

use super::args::{Common, FileArgs};
use super::outputs::{Output, OutputKind};
use crate::dataset::{DatasetFormat, Existing, check_unfinished, merge};
use crate::error::Result;
use crate::files::{InputFile, ResultHeader};
use serde::Serialize;
use std::path::PathBuf;

/// Join the shards of `sweep` or `generate` into the same bytes as one run
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  edgegait sweep --shard 1/2 --out one\n  edgegait sweep --shard 2/2 --out two\n  edgegait merge one two --out whole"
)]
pub(super) struct MergeArgs {
    /// Folders that `--shard` made, in any order
    #[arg(value_name = "SHARD", required = true)]
    shards: Vec<PathBuf>,
    /// Folder or file to write
    #[arg(long, value_name = "PATH")]
    out: PathBuf,
    /// Format [default: that of the shards]
    #[arg(long, value_name = "FORMAT")]
    format: Option<DatasetFormat>,
    /// Resume a run that was interrupted
    #[arg(long)]
    resume: bool,
    #[command(flatten)]
    pub common: Common,
}

#[derive(Serialize)]
struct MergeResults {
    #[serde(flatten)]
    header: ResultHeader,
    rows: usize,
}

impl MergeArgs {
    /// Returns the files that the command reads and writes.
    pub(super) fn files(&self) -> FileArgs {
        let kind = if self.resume {
            OutputKind::Resumed
        } else {
            OutputKind::Dataset(self.format.unwrap_or_default())
        };
        FileArgs {
            inputs: self.shards.clone(),
            outputs: vec![Output::new("--out", &self.out, kind)],
        }
    }
}

/// Runs the subcommand.
pub(super) fn run(args: &MergeArgs) -> Result<()> {
    check_unfinished(&args.out, args.resume)?;
    let existing = Existing::from_overwrite(args.common.overwrite);
    let rows = merge(&args.shards, &args.out, args.format, existing, args.resume)?;
    let mut header = ResultHeader::new("merge", args.common.seed);
    for shard in &args.shards {
        header
            .inputs
            .push(InputFile::read(shard.join("manifest.json"))?);
    }
    args.common.say(format_args!(
        "wrote {}: {rows} rows of {} shards",
        args.out.display(),
        args.shards.len()
    ));
    args.common.write_json(&MergeResults { header, rows })
}
