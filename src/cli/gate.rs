//! `edgegait gate`: checks whether results are within limits.

use super::Ending;
use super::args::{Common, FileArgs};
use super::outputs::{Output, OutputKind};
use crate::bench::gate::{
    GateLimits, GateOutcome, GateReport, JUNIT_START, JudgedRuns, MARKDOWN_START, ResultFile, gate,
    starter,
};
use crate::error::{Error, Result};
use crate::files::{InputFile, ResultHeader, write_bytes};
use std::path::{Path, PathBuf};
use std::time::SystemTime;

/// Check results against limits, alone or relative to a baseline, so that a build can fail
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  edgegait gate --init bench.json > limits.toml       # a first set of limits\n  edgegait gate limits.toml bench.json main.json\n  edgegait gate limits.toml 1.json main-1.json --run 2.json,3.json --baseline-run main-2.json\n  edgegait gate limits.toml score.json main.json --markdown comment.md --junit gate.xml\n\nA limit names a value by the keys of the JSON results, as in models[mine].p50_us or recognizers[mine].probe_sets[BG].rank1; [*] stands for all of them, and per = \"...\" divides by another value of the same results. The results of criterion are a folder, with benchmarks[NAME].median_ns. Times have an interval, from their windows and runs. A limit within that interval cannot be decided, nor can a miss while other processes kept the machine busy. Rank-1 is compared with a baseline's on the same probes, with an interval over people. The exit code is 0 if all limits hold, 4 if one is missed, 3 if one cannot be decided and none is missed, 1 or 2 after an error."
)]
pub(super) struct GateArgs {
    /// The limits (TOML), the results to check, and the results of a baseline; results are JSON of
    /// a command or a folder of criterion's
    #[arg(value_name = "FILE", num_args = 2..=3, required_unless_present = "init")]
    files: Vec<PathBuf>,
    /// Further runs of the results to check; the medians of all runs count
    #[arg(long, value_name = "FILE[,FILE..]", value_delimiter = ',')]
    run: Vec<PathBuf>,
    /// Further runs of the baseline
    #[arg(long, value_name = "FILE[,FILE..]", value_delimiter = ',')]
    baseline_run: Vec<PathBuf>,
    /// Skip limits relative to a baseline, if there is no baseline yet
    #[arg(long, conflicts_with_all = ["baseline_run", "init"])]
    without_baseline: bool,
    /// Skip limits that need two idle threads, because other work ran during the measurement
    #[arg(long, conflicts_with = "init")]
    busy: bool,
    /// Print a first set of limits from these results, and check nothing
    #[arg(long, value_name = "RESULT", conflicts_with_all = ["files", "run", "baseline_run", "markdown", "junit", "bencher", "json"])]
    init: Option<PathBuf>,
    /// Write a table for a pull request
    #[arg(long, value_name = "FILE")]
    markdown: Option<PathBuf>,
    /// Write JUnit XML: a missed limit is a failure, an undecided one an error
    #[arg(long, value_name = "FILE")]
    junit: Option<PathBuf>,
    /// Write the values in Bencher's metric format (JSON)
    #[arg(long, value_name = "FILE")]
    bencher: Option<PathBuf>,
    #[command(flatten)]
    pub common: Common,
}

impl GateArgs {
    /// Returns the files that the command reads and writes.
    pub(super) fn files(&self) -> FileArgs {
        let named = |flag, path: &Option<PathBuf>, kind| {
            path.as_ref().map(|path| Output::new(flag, path, kind))
        };
        let outputs = [
            named(
                "--markdown",
                &self.markdown,
                OutputKind::Begins(MARKDOWN_START),
            ),
            named("--junit", &self.junit, OutputKind::Begins(JUNIT_START)),
            named("--bencher", &self.bencher, OutputKind::Bencher),
        ];
        FileArgs {
            inputs: [&self.files[..], &self.run, &self.baseline_run].concat(),
            outputs: outputs.into_iter().flatten().collect(),
        }
    }
}

/// Runs the subcommand.
pub(super) fn run(args: &GateArgs) -> Result<Ending> {
    if let Some(path) = &args.init {
        args.common
            .put(starter(&ResultFile::read(path)?)?.trim_end());
        return Ok(Ending::Done);
    }
    let [limits_at, result, baseline @ ..] = &args.files[..] else {
        return Err(Error::Missing("limits and results"));
    };
    if baseline.is_empty() && !args.baseline_run.is_empty() {
        return Err(Error::Usage(
            "--baseline-run: expected a baseline as the third file, found none".into(),
        ));
    }
    if args.without_baseline && !baseline.is_empty() {
        return Err(Error::Usage(
            "--without-baseline: expected no baseline, found one".into(),
        ));
    }
    for list in [
        std::iter::once(result).chain(&args.run).collect::<Vec<_>>(),
        baseline.iter().chain(&args.baseline_run).collect(),
    ] {
        if let Some((_, twice)) = list
            .iter()
            .enumerate()
            .find(|(at, one)| list[..*at].contains(one))
        {
            let problem = "appears twice: expected results of another run";
            return Err(Error::Usage(format!("{}: {problem}", twice.display())));
        }
    }
    let limits = GateLimits::read(limits_at)?;
    let read = |paths: &mut dyn Iterator<Item = &PathBuf>| {
        paths
            .map(|path| ResultFile::read(path))
            .collect::<Result<Vec<_>>>()
    };
    let runs = read(&mut std::iter::once(result).chain(&args.run))?;
    let baselines = read(&mut baseline.iter().chain(&args.baseline_run))?;
    let mut header = ResultHeader::new("gate", args.common.seed);
    header.inputs.push(InputFile::read(limits_at)?);
    let firsts = [runs.first(), baselines.first()].into_iter().flatten();
    let others = runs.iter().skip(1).chain(baselines.iter().skip(1));
    for file in firsts.chain(others) {
        header.inputs.push(file.input()?);
    }
    let judged = JudgedRuns {
        runs: &runs,
        baselines: &baselines,
        without_baseline: args.without_baseline,
        is_busy: args.busy,
        now: SystemTime::now(),
    };
    let report = gate(limits_at, &limits, &judged, header)?;
    args.common.say(format!("{report}").trim_end());
    args.common.say_warnings(&report.header.warnings);
    written(args, &report)?;
    Ok(match report.outcome {
        GateOutcome::Holds => Ending::Done,
        GateOutcome::CannotTell => Ending::CannotTell,
        GateOutcome::Missed => Ending::LimitMissed,
    })
}

/// Writes the requested reports.
fn written(args: &GateArgs, report: &GateReport) -> Result<()> {
    let write = |path: &Option<PathBuf>, text: &dyn Fn() -> Result<String>| {
        let path: Option<&Path> = path.as_deref();
        path.map_or(Ok(()), |path| write_bytes(path, text()?.as_bytes()))
    };
    write(&args.markdown, &|| Ok(report.markdown()))?;
    write(&args.junit, &|| Ok(report.junit()))?;
    write(&args.bencher, &|| {
        Ok(serde_json::to_string_pretty(&report.bencher())? + "\n")
    })?;
    args.common.write_json(report)
}
