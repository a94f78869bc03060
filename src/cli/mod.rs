//! The command line, with one module for each subcommand.

mod again;
mod args;
mod augment;
mod baselines;
mod bench;
#[cfg(feature = "import")]
mod body;
mod cache;
mod check;
mod cohort;
mod completions;
mod conditions;
#[cfg(feature = "plots")]
mod confounders;
mod contest;
mod contract;
mod drawing;
pub mod embed;
#[cfg(feature = "import")]
mod encode_recordings;
mod encoding;
mod export;
#[cfg(feature = "plots")]
mod frontier;
mod gate;
mod generate;
mod hints;
#[cfg(feature = "import")]
mod import;
mod inspect;
mod interrupt;
mod keep_going;
mod layout;
#[cfg(feature = "train")]
mod literature;
mod merge;
#[cfg(feature = "import")]
mod motion_files;
mod outputs;
mod parity;
mod progress;
mod quantize;
mod recognizers;
mod render;
mod runtime;
mod score;
mod segment;
#[cfg(feature = "import")]
mod shared_warnings;
mod stop;
#[cfg(all(feature = "import", feature = "train", feature = "plots"))]
mod study;
#[cfg(feature = "train")]
mod subspaces;
mod sweep;
#[cfg(feature = "train")]
mod train;
mod tree_cycles;
mod trial;
mod values;
mod walks;

use crate::error::{Result, is_hidden, visible};
use again::set_program;
use clap::parser::ValueSource;
use clap::{CommandFactory as _, FromArgMatches as _, Parser, Subcommand};
use hints::WithFlags;
use std::ffi::OsString;
use std::path::PathBuf;
use stop::Stop;

/// The version and, in a release build from a checkout, the commit.
const VERSION: &str = match option_env!("EDGEGAIT_VERSION") {
    Some(version) => version,
    None => env!("CARGO_PKG_VERSION"),
};

/// Makes human gait silhouettes from compressed motion, and tests gait recognizers with them.
#[derive(Debug, Parser)]
#[command(
    name = "edgegait",
    version = VERSION,
    max_term_width = 100,
    propagate_version = true
)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    Bench(bench::BenchArgs),
    Check(check::CheckArgs),
    Cohort(cohort::CohortArgs),
    Completions(completions::CompletionsArgs),
    #[cfg(feature = "plots")]
    Confounders(confounders::ConfoundersArgs),
    Contract(contract::ContractArgs),
    #[cfg(feature = "plots")]
    Frontier(frontier::FrontierArgs),
    Gate(gate::GateArgs),
    Generate(generate::GenerateArgs),
    #[cfg(feature = "import")]
    Import(import::ImportArgs),
    Inspect(inspect::InspectArgs),
    #[cfg(feature = "train")]
    Literature(literature::LiteratureArgs),
    Merge(merge::MergeArgs),
    Parity(parity::ParityArgs),
    Quantize(quantize::QuantizeArgs),
    Render(render::RenderArgs),
    Score(score::ScoreArgs),
    Segment(segment::SegmentArgs),
    #[cfg(all(feature = "import", feature = "train", feature = "plots"))]
    Study(study::StudyArgs),
    Sweep(sweep::SweepArgs),
    #[cfg(feature = "train")]
    Train(train::TrainArgs),
    #[command(hide = true)]
    TryModel(trial::TryModelArgs),
}

impl Cli {
    /// Returns the arguments that were found, and which of them were not left out.
    fn of_matches(matches: &clap::ArgMatches) -> clap::error::Result<Self> {
        let mut cli = Self::from_arg_matches(matches)?;
        if let (Command::Generate(args), Some((_, found))) =
            (&mut cli.command, matches.subcommand())
        {
            args.is_seeded = found.value_source("seed") == Some(ValueSource::CommandLine);
        }
        Ok(cli)
    }
}

/// Returns the command, with the settings that all subcommands share.
fn command() -> clap::Command {
    Cli::command().mut_subcommands(|command| {
        let command = command.display_name("edgegait");
        // A number below 0 is a value, possibly out of range, but not a flag.
        command.mut_args(|arg| {
            let is_flag_with_value = !arg.is_positional() && arg.get_action().takes_values();
            if is_flag_with_value && !arg.is_allow_hyphen_values_set() {
                arg.allow_negative_numbers(true)
            } else {
                arg
            }
        })
    })
}

/// Runs the command that the process was started with, and returns its exit code.
#[must_use]
pub fn main() -> std::process::ExitCode {
    let program = std::env::current_exe();
    let program = program.ok().map(PathBuf::into_os_string);
    code_of(std::env::args_os().collect(), program.into_iter().collect()).into()
}

/// Runs the command of these words in a process of its own, and returns the exit code. The first
/// word is the command's own name; `program` is the program and first words that start such a
/// process.
#[must_use]
pub fn code_of(words: Vec<OsString>, program: Vec<OsString>) -> u8 {
    let matches = command().try_get_matches_from(&words);
    set_program(program);
    let mut cli = match matches.and_then(|matches| Cli::of_matches(&matches)) {
        Ok(cli) => cli,
        Err(error) => return refuse_words(&words, &error),
    };
    if let Command::Bench(args) = &mut cli.command {
        args.words = words.into_iter().skip(2).collect();
    }
    match interrupt::listen().and_then(|()| run(cli.command, &Stop::default())) {
        Ok(ending) => ending as u8,
        Err(error) => {
            eprintln!("error: {}", WithFlags(&error));
            interrupt::tell_unfinished();
            error.exit_code()
        }
    }
}

/// Prints what is wrong with the words of a command, or the help that they ask for, and returns the
/// exit code.
fn refuse_words(words: &[OsString], error: &clap::Error) -> u8 {
    let mut each = words.iter();
    if each.any(|word| word.to_string_lossy().contains(is_hidden)) {
        // Without colours, as clap repeats words as they are.
        eprintln!("{}", visible(&error.render().to_string()));
    } else {
        // A closed pipe is no error.
        let _ = error.print();
    }
    u8::try_from(error.exit_code()).unwrap_or(2)
}

/// The outcome of a command that did its work, as the exit code of the process. Errors have 1 and
/// 2.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Ending {
    /// The work is done, and no limit is missed.
    Done = 0,
    /// A limit is undecided.
    CannotTell = 3,
    /// A limit is missed.
    LimitMissed = 4,
}

/// Runs a command until it is done or `stop` ends it.
fn run(command: Command, stop: &Stop) -> Result<Ending> {
    macro_rules! run {
        ($name:ident, $args:expr) => {{
            let mut args = $args;
            args.common.stop = stop.clone();
            let files = args.files();
            with_files(&args.common, stringify!($name), &files, || {
                $name::run(&args)
            })
        }};
    }
    match command {
        // Its threads are the threads of one inference.
        Command::Bench(mut args) => {
            args.common.stop = stop.clone();
            let inputs = args.files().inputs;
            bench::run(&args).map_err(|error| error.within(&inputs))
        }
        Command::Check(args) => return run!(check, args),
        Command::Cohort(args) => run!(cohort, args),
        Command::Completions(args) => run!(completions, args),
        #[cfg(feature = "plots")]
        Command::Confounders(args) => run!(confounders, args),
        Command::Contract(args) => run!(contract, args),
        #[cfg(feature = "plots")]
        Command::Frontier(args) => run!(frontier, args),
        Command::Gate(args) => return run!(gate, args),
        Command::Generate(args) => run!(generate, args),
        #[cfg(feature = "import")]
        Command::Import(args) => run!(import, args),
        Command::Inspect(args) => run!(inspect, args),
        #[cfg(feature = "train")]
        Command::Literature(args) => run!(literature, args),
        Command::Merge(args) => run!(merge, args),
        Command::Parity(args) => return run!(parity, args),
        Command::Quantize(args) => run!(quantize, args),
        Command::Render(args) => run!(render, args),
        Command::Score(args) => run!(score, args),
        Command::Segment(args) => run!(segment, args),
        #[cfg(all(feature = "import", feature = "train", feature = "plots"))]
        Command::Study(args) => run!(study, args),
        Command::Sweep(args) => run!(sweep, args),
        #[cfg(feature = "train")]
        Command::Train(args) => run!(train, args),
        Command::TryModel(args) => trial::run(&args),
    }
    .map(|()| Ending::Done)
}

/// Checks the files of a command, and runs `work` on them with the requested number of threads.
fn with_files<R: Send>(
    common: &args::Common,
    command: &'static str,
    files: &args::FileArgs,
    work: impl FnOnce() -> Result<R> + Send,
) -> Result<R> {
    common.check(command, files)?;
    with_threads(common, work).map_err(|error| error.within(&files.inputs))
}

/// Runs `work` with the requested number of threads.
fn with_threads<R: Send>(
    common: &args::Common,
    work: impl FnOnce() -> Result<R> + Send,
) -> Result<R> {
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(common.one_thread_count()?.unwrap_or(0))
        .build()?;
    pool.install(work)
}
