//! The command line: one module a subcommand.

mod args;
mod augment;
mod bench;
mod body;
mod budget;
mod cohort;
mod conditions;
mod confounders;
mod contest;
mod drawing;
mod encoding;
mod frontier;
mod gallery;
mod import;
mod inspect;
mod keep_going;
mod progress;
mod quantize;
mod recognizers;
mod render;
mod runtime;
mod score;
mod shared_warnings;
mod source;
mod sweep;
mod train;
mod walkers;

use crate::error::{Error, Result};
use clap::{Parser, Subcommand};

/// Makes human gait silhouettes from compressed motion, and measures with them how well
/// gait recognizers hold up.
#[derive(Debug, Parser)]
#[command(
    name = "edgegait",
    version,
    max_term_width = 100,
    propagate_version = true
)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    Bench(bench::Args),
    Cohort(cohort::Args),
    Confounders(confounders::Args),
    Frontier(frontier::Args),
    Import(import::Args),
    Inspect(inspect::Args),
    Quantize(quantize::Args),
    Render(render::Args),
    Score(score::Args),
    Sweep(sweep::Args),
    Train(train::Args),
}

/// Runs the command that the process was started with; its exit code.
#[must_use]
pub fn main() -> std::process::ExitCode {
    let cli = Cli::parse();
    match run(&cli.command) {
        Ok(()) => std::process::ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            std::process::ExitCode::from(error.exit_code())
        }
    }
}

fn run(command: &Command) -> Result<()> {
    match command {
        Command::Bench(args) => bench::run(args),
        Command::Cohort(args) => with_threads(&args.common, || cohort::run(args)),
        Command::Confounders(args) => with_threads(&args.common, || confounders::run(args)),
        Command::Frontier(args) => with_threads(&args.common, || frontier::run(args)),
        Command::Import(args) => with_threads(&args.common, || import::run(args)),
        Command::Inspect(args) => with_threads(&args.common, || inspect::run(args)),
        Command::Quantize(args) => with_threads(&args.common, || quantize::run(args)),
        Command::Render(args) => with_threads(&args.common, || render::run(args)),
        Command::Score(args) => with_threads(&args.common, || score::run(args)),
        Command::Sweep(args) => with_threads(&args.common, || sweep::run(args)),
        Command::Train(args) => with_threads(&args.common, || train::run(args)),
    }
}

/// Runs `work` with as many threads as were asked for.
fn with_threads(common: &args::Common, work: impl FnOnce() -> Result<()> + Send) -> Result<()> {
    common.check()?;
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(common.threads.map_or(0, usize::from))
        .build()
        .map_err(|error| Error::Failed(format!("cannot start threads: {error}")))?;
    pool.install(work)
}
