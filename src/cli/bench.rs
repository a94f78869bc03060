//! `edgegait bench`: what recognizers cost on this machine.

mod compare;
mod doubts;
mod video;

use super::again::again;
use super::args::{Common, FileArgs, ViewArgs};
use super::baselines::is_baseline;
use super::drawing::DrawArgs;
use super::hints::WithFlags;
use super::outputs::{Output, OutputKind};
use super::progress::TimedProgress;
use super::recognizers::{models, sort_inputs, with_contracts};
use super::runtime::RuntimeArgs;
use super::trial::try_out;
use super::walks::{SelectionArgs, SourceArgs};
use crate::bench::Task;
use crate::bench::board::{Board, CpuList, load_of_others};
use crate::bench::windows::TimingPlan;
use crate::bench::{
    BenchResults, DrawnInputs, MeasuringProgress, ModelResult, ProcessOutcome, ResultColumn,
    TableFormat, csv, end_with_parent, measure, measure_lengths, measured_by, pin, render,
    require_any_length,
};
use crate::dataset::sequences::PackSource;
use crate::draw::sweep::jobs;
use crate::error::{Error, Result};
use crate::files::{ResultHeader, Staging, write_bytes};
use crate::inference::{Model, shipped};
use doubts::{cut_short, warn};
use edgegait_core::pack::Pack;
use serde::de::DeserializeOwned;
use std::ffi::{OsStr, OsString};
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};
use video::PathArgs;

/// Default limit on the measuring time of a model, seconds. Our choice: a linear model takes half a
/// minute, including the rendering for its rank-1 on a slow board.
const USUAL_S: f64 = 300.0;

/// Measure what recognizers cost on this machine: latency, throughput, memory, energy, accuracy
#[derive(Debug, clap::Args)]
#[command(
    mut_arg("threads", |threads| threads.value_name("N[,N..]").help("Threads of one inference; each number is measured in turn [default: 1]")),
    mut_arg("views", |views| views.visible_alias("accuracy").help("Viewpoints at which rank-1 is measured: \"paper\" (703), \"side\", or a CSV file with azimuth_deg and elevation_deg [default: paper]")),
    after_help = "Examples:\n  edgegait bench                               # the shipped models, the embedded runtime\n  edgegait bench mine.onnx --runtime ort --ort-lib /path/to/libonnxruntime.so --cpus 2,3 --threads 2\n  edgegait bench gaitbase.onnx --max-seconds 60 --frames 1,8,16,32,64\n  edgegait bench mine.onnx --mlperf --json pi4.json\n  edgegait bench mine.onnx --video made        # from video frames to answers\n  edgegait bench mine.onnx --video walk --background empty.png --minutes 10 --json path.json\n  edgegait bench mine.onnx --no-accuracy --threads 1,2,4 --batch 1,8,64 --csv mine.csv\n  edgegait bench --compare pi4.json pi5.json --format markdown --chart boards.svg\n\nEach model is measured in a process of its own: one input at a time, then batches, then the rendering of its input, then both together, and finally its rank-1, with the same runtime and settings. Results are from the median window. Values that a machine does not expose are left out."
)]
pub(super) struct BenchArgs {
    /// ONNX models, and a pack whose walks are their inputs [default: the shipped models, the
    /// built-in cohort]
    #[arg(value_name = "MODEL|PACK")]
    inputs: Vec<PathBuf>,
    #[command(flatten)]
    selection: SelectionArgs,
    /// Inputs of a batch; each size is measured in turn
    #[arg(long, value_name = "N[,N..]", value_delimiter = ',', default_value = "64", value_parser = clap::value_parser!(u16).range(1..=4096))]
    batch: Vec<u16>,
    /// Untimed calls before each window
    #[arg(long, value_name = "N", default_value_t = TimingPlan::DEFAULT.warm_up, value_parser = clap::value_parser!(u32).range(0..=1_000_000))]
    warm_up: u32,
    /// Shortest window in seconds; a window has at least 100 inferences
    #[arg(long, value_name = "S", default_value_t = TimingPlan::DEFAULT.window.as_secs_f64(), value_parser = seconds)]
    window_s: f64,
    /// Number of windows
    #[arg(long, value_name = "N", default_value_t = TimingPlan::DEFAULT.windows, value_parser = clap::value_parser!(u32).range(1..=1000))]
    windows: u32,
    /// Time limit for measuring a model, in seconds from its first inference on. If the full
    /// measurement would take longer, windows, inferences, batches and viewpoints are reduced;
    /// results state each reduction [default: 300, or twice the requested windows; none with
    /// --mlperf]
    #[arg(long, value_name = "S", value_parser = max_seconds)]
    max_seconds: Option<f64>,
    /// Also measure inputs of these lengths in frames, one at a time: consecutive gait cycles of a
    /// walk [for models that take sequences of any length]
    #[arg(long, value_name = "N[,N..]", value_delimiter = ',', value_parser = clap::value_parser!(u16).range(1..=4096))]
    frames: Vec<u16>,
    /// Measure five windows of 10 s, as MLPerf Tiny does
    #[arg(long, conflicts_with_all = ["warm_up", "window_s", "windows"])]
    mlperf: bool,
    /// Use only these processors, as in 0,2-3
    #[arg(long, value_name = "LIST", value_parser = cpus)]
    cpus: Option<CpuList>,
    /// Compare with a bare loop around ONNX Runtime, in alternating windows
    #[arg(long)]
    bare: bool,
    /// Do not measure rank-1; with --compare, leave it out
    #[arg(long, conflicts_with_all = ["views", "azimuth_deg", "elevation_deg"])]
    no_accuracy: bool,
    /// Measure the time of each operator in an inference, where the runtime reports it (ONNX
    /// Runtime does)
    #[arg(long)]
    profile: bool,
    /// Write a table with a row for each model, number of threads and batch size
    #[arg(long, value_name = "FILE", conflicts_with = "compare")]
    csv: Option<PathBuf>,
    /// Write a chart of latency against rank-1, with a point for each model and board (SVG)
    #[arg(long, value_name = "FILE", requires = "compare")]
    chart: Option<PathBuf>,
    /// Format of the tables
    #[arg(long, value_name = "NAME", default_value = "text")]
    format: TableFormat,
    /// Measure nothing, and show the JSON results of several boards side by side, with the time of
    /// each model relative to the first board that has it
    #[arg(long, value_name = "FILE", num_args = 2.., conflicts_with_all = ["inputs", "json", "frames"])]
    compare: Vec<PathBuf>,
    #[command(flatten)]
    path: PathArgs,
    #[command(flatten)]
    runtime: RuntimeArgs,
    #[command(flatten)]
    views: ViewArgs,
    #[command(flatten)]
    draw: DrawArgs,
    #[command(flatten)]
    pub common: Common,
    /// The words after the subcommand.
    #[arg(skip)]
    pub(super) words: Vec<OsString>,
    /// Measure the model of this number here, and print its result as JSON
    #[arg(long, value_name = "N", hide = true)]
    alone: Option<usize>,
    /// Name of that model in its result
    #[arg(long, value_name = "NAME", hide = true)]
    alone_name: Option<String>,
    /// Threads to measure that model with
    #[arg(long, value_name = "N", hide = true)]
    alone_threads: Option<usize>,
    /// Measure only its inputs of several lengths
    #[arg(long, hide = true, requires = "alone")]
    only_lengths: bool,
    /// The pack that `--alone` renders inputs from
    #[arg(long, value_name = "PATH", hide = true)]
    pack_at: Option<PathBuf>,
}

/// Sorts numbers in ascending order, without duplicates.
fn rising(mut numbers: Vec<usize>) -> Vec<usize> {
    numbers.sort_unstable();
    numbers.dedup();
    numbers
}

fn seconds(text: &str) -> std::result::Result<f64, String> {
    let found = text
        .parse()
        .ok()
        .filter(|s: &f64| (0.0..=3600.0).contains(s));
    found.ok_or_else(|| "expected 0 to 3600 seconds".to_owned())
}

fn max_seconds(text: &str) -> std::result::Result<f64, String> {
    let found = text
        .parse()
        .ok()
        .filter(|s: &f64| (1.0..=1_000_000.0).contains(s));
    found.ok_or_else(|| "expected 1 to 1000000 seconds".to_owned())
}

fn cpus(text: &str) -> std::result::Result<CpuList, String> {
    CpuList::parse(text).ok_or_else(|| "expected processors as in 0,2-3".to_owned())
}

impl BenchArgs {
    pub(super) fn files(&self) -> FileArgs {
        let inputs = [&self.inputs[..], &self.compare].concat();
        FileArgs {
            inputs: with_contracts(&inputs)
                .into_iter()
                .chain(self.views.file())
                .chain(self.path.files())
                .collect(),
            outputs: [
                self.csv
                    .as_ref()
                    .map(|path| Output::new("--csv", path, OutputKind::Csv("model"))),
                self.chart
                    .as_ref()
                    .map(|path| Output::new("--chart", path, OutputKind::Svg)),
            ]
            .into_iter()
            .flatten()
            .collect(),
        }
    }

    fn plan(&self) -> TimingPlan {
        if self.mlperf {
            return TimingPlan::MLPERF;
        }
        TimingPlan {
            warm_up: self.warm_up,
            window: Duration::from_secs_f64(self.window_s),
            windows: self.windows,
            ..TimingPlan::DEFAULT
        }
    }

    /// Returns the input lengths to measure, ascending, without duplicates.
    fn lengths(&self) -> Vec<usize> {
        rising(self.frames.iter().map(|&frames| frames.into()).collect())
    }

    /// Returns the limit on the measuring time of a model. Half of the time is for inputs of
    /// several lengths, if requested. The default is at least twice the time of all windows.
    fn most(&self) -> Option<Duration> {
        let (plan, lengths) = (self.plan(), self.frames.len());
        // Single inferences and their two loops, batches, rendering, both together.
        let kinds = if self.bare { 5 } else { 3 } + self.batches().len() + lengths;
        let windows_s = plan.window.as_secs_f64() * f64::from(plan.windows) * kinds as f64;
        let usual_s = (!self.mlperf).then(|| USUAL_S.max(2.0 * windows_s));
        let most = Duration::from_secs_f64(self.max_seconds.or(usual_s)?);
        Some(if lengths > 0 { most / 2 } else { most })
    }

    /// Prints results, and writes the requested files.
    fn show(&self, results: &BenchResults) -> Result<()> {
        let columns = [ResultColumn { name: "", results }];
        self.common.say(render(&columns, self.format).trim_end());
        self.common.say_warnings(&results.header.warnings);
        if let Some(path) = &self.csv {
            write_bytes(path, &csv(results)?)?;
        }
        self.common.write_json(results)
    }

    /// Returns the numbers of threads to measure with, ascending, without duplicates.
    fn threads(&self) -> Vec<usize> {
        let threads: Vec<usize> = self
            .common
            .threads
            .iter()
            .map(|&threads| threads.into())
            .collect();
        if threads.is_empty() {
            vec![1]
        } else {
            rising(threads)
        }
    }

    /// Returns the batch sizes to measure, ascending, without duplicates.
    fn batches(&self) -> Vec<usize> {
        rising(self.batch.iter().map(|&batch| batch.into()).collect())
    }

    fn source(&self, pack: Option<PathBuf>) -> SourceArgs {
        SourceArgs::new(pack, self.selection.clone())
    }
}

/// Runs the subcommand.
pub(super) fn run(args: &BenchArgs) -> Result<()> {
    if args.alone.is_none() {
        args.common.check("bench", &args.files())?;
    }
    if !args.compare.is_empty() {
        return compare::run(args);
    }
    let (paths, data) = sort_inputs(&args.inputs)?;
    if paths.iter().any(|path| is_baseline(path)) {
        return Err(Error::Usage(
            "pixels: expected models to measure, found the baseline, which computes nothing".into(),
        ));
    }
    if let Some(index) = args.alone {
        return alone(args, &paths, data, index);
    }
    if let Some(cpus) = &args.cpus {
        pin(cpus)?;
    }
    // Models are measured in other processes.
    let pool = rayon::ThreadPoolBuilder::new().build()?;
    pool.install(|| measure_all(args, &paths, data))
}

/// Measures each model in a process of its own, and shows the results.
fn measure_all(args: &BenchArgs, paths: &[PathBuf], data: Option<PathBuf>) -> Result<()> {
    let models = models(paths)?;
    if args.path.is_given() {
        return video::run(args, &models, data);
    }
    if let Some(folder) = data.as_ref().filter(|path| path.is_dir()) {
        return Err(Error::input(
            folder,
            "expected a pack to render, found a dataset",
        ));
    }
    let runtime = args.runtime.runtime()?;
    if args.bare && runtime.name().name != "onnxruntime" {
        return Err(Error::Usage(format!(
            "--bare compares with ONNX Runtime: expected --runtime ort, found {}",
            runtime.name().name
        )));
    }
    if !args.frames.is_empty() {
        models.iter().try_for_each(require_any_length)?;
    }
    models
        .iter()
        .try_for_each(|model| try_out(model, &runtime))?;
    let header = header(args, &models)?
        .with("runtime", runtime.name().name)
        .with("provider", runtime.name().provider);
    let root = Path::new("/");
    let load_of_others = load_of_others(root);

    let source_args = args.source(data);
    let source = source_args.load(&args.common)?;
    let pack = Pack::parse(&source.bytes)?;
    // Uncut motions have no cycle to average: rejected here.
    jobs(&pack, &source_args.choose(&pack)?, 0..1)?;
    let folder = Staging::temporary()?;
    let pack_at = folder.path().join("pack.egp");
    write_bytes(&pack_at, &source.bytes)?;
    let mut results = BenchResults {
        header: header.with("pack", source.name),
        date: humantime::format_rfc3339_seconds(SystemTime::now()).to_string(),
        board: Board::read(root),
        load_of_others,
        models: Vec::new(),
        paths: Vec::new(),
    };
    results.header.inputs.extend(source.inputs);
    warn(&mut results);
    let progress = TimedProgress::new(&args.common);
    let here: [&OsStr; 2] = ["--pack-at".as_ref(), pack_at.as_os_str()];
    let all_threads = args.threads();
    let cases = models.iter().enumerate().flat_map(|(index, model)| {
        let each = all_threads.iter();
        each.map(move |threads| (index, model, threads.to_string()))
    });
    for (index, model, threads) in cases {
        let told = |told: &MeasuringProgress| progress.now(&told.what, told.left_s);
        let with: [&OsStr; 2] = ["--alone-threads".as_ref(), threads.as_ref()];
        let here = [&here[..], &with].concat();
        let mut result: ModelResult = elsewhere(args, model, index, &here, &told)?;
        if !args.frames.is_empty() {
            let only = [&here[..], &["--only-lengths".as_ref()]].concat();
            let (lengths, cut) = elsewhere(args, model, index, &only, &told)?;
            result.lengths = lengths;
            result.add(cut);
        }
        result.warnings.extend(cut_short(args, &result));
        let warnings = result.warnings.iter();
        let warnings = warnings.map(|warning| format!("{}: {warning}", result.name));
        results.header.warnings.extend(warnings);
        results.models.push(result);
    }
    drop(progress);
    args.show(&results)
}

/// Returns a header with the requested settings.
fn header(args: &BenchArgs, models: &[Model]) -> Result<ResultHeader> {
    let plan = args.plan();
    let views = args.views.views("paper")?;
    let seed = args.common.seed;
    let mut drawn = ResultHeader::new("bench", seed);
    for (index, model) in models.iter().enumerate() {
        let settings = args.draw.settings_for(model.contract(), seed)?;
        let one = ResultHeader::new("bench", seed).drawn(&settings);
        if index == 0 {
            drawn = one;
        } else {
            // Models may differ in size and framing, which each entry states.
            drawn
                .settings
                .retain(|name, value| one.settings.get(name) == Some(value));
        }
    }
    let mut header = drawn
        .with("batch", one_or_all(args.batches()))
        .with("threads", one_or_all(args.threads()))
        .with("warm_up", plan.warm_up)
        .with("window_s", plan.window.as_secs_f64())
        .with("windows", plan.windows)
        .with("mlperf", args.mlperf)
        .with("max_seconds", args.most().map(|most| most.as_secs_f64()))
        .with("bare", args.bare)
        .with("profile", args.profile)
        .with("no_accuracy", args.no_accuracy)
        .with("build", build());
    if !args.no_accuracy {
        header = header
            .with("views", views.name.as_str())
            .with("viewpoints", views.list.len());
    }
    if !args.frames.is_empty() {
        header = header.with("frames", args.lengths());
    }
    if let Some(cpus) = &args.cpus {
        header = header.with("cpus", cpus.to_string());
    }
    header.inputs = models.iter().map(Model::input).collect();
    Ok(header)
}

/// Returns a single number as itself, several as a list.
fn one_or_all(numbers: Vec<usize>) -> serde_json::Value {
    match numbers[..] {
        [one] => one.into(),
        _ => numbers.into(),
    }
}

/// Returns the build profile of this program.
const fn build() -> &'static str {
    if cfg!(debug_assertions) {
        "debug"
    } else {
        "release"
    }
}

/// Measures one model in a process of its own, by running this program again.
fn elsewhere<R: DeserializeOwned>(
    args: &BenchArgs,
    model: &Model,
    index: usize,
    flags: &[&OsStr],
    told: &(dyn Fn(&MeasuringProgress) -> Result<()> + Sync),
) -> Result<R> {
    let mut command = again()?;
    command
        .args(["bench", "--alone", &index.to_string()])
        .args(["--alone-name", &model.contract().name])
        .args(flags)
        .args(&args.words);
    measured_by(command, model.path(), told)
}

/// Measures one model in this process, and prints the outcome for the process that started it.
fn alone(args: &BenchArgs, paths: &[PathBuf], pack: Option<PathBuf>, index: usize) -> Result<()> {
    end_with_parent()?;
    let outcome = match measured(args, paths, pack, index) {
        Ok(result) => ProcessOutcome::Measured(result),
        Err(error) if error.exit_code() == 2 => {
            ProcessOutcome::Usage(WithFlags(&error).to_string())
        }
        Err(error) => ProcessOutcome::Failed(WithFlags(&error).to_string()),
    };
    let json = serde_json::to_string(&outcome)?;
    writeln!(std::io::stdout(), "{json}").map_err(|error| Error::io("standard output", error))
}

/// Returns the result of measuring one model in this process, as JSON.
fn measured(
    args: &BenchArgs,
    paths: &[PathBuf],
    pack: Option<PathBuf>,
    index: usize,
) -> Result<serde_json::Value> {
    let open = || {
        let shipped_or_named = match paths.get(index) {
            Some(path) => vec![shipped::open(path)?],
            None => models(paths)?.into_iter().skip(index).collect(),
        };
        let model = shipped_or_named.into_iter().next();
        let model = model
            .ok_or_else(|| Error::Usage(format!("--alone {index}: there is no such model")))?;
        Ok(match &args.alone_name {
            Some(name) => model.named(name),
            None => model,
        })
    };
    if let Some(folder) = args.path.at() {
        return Ok(serde_json::to_value(video::alone(args, &open, folder)?)?);
    }
    let pack_at = args.pack_at.as_deref();
    let pack_at = pack_at.ok_or(Error::Missing("a pack"))?;
    let settings = args
        .draw
        .settings_for(open()?.contract(), args.common.seed)?;
    let source = PackSource::read(pack_at)?;
    let pack_read = Pack::parse(&source.bytes)?;
    let walks = args.source(pack).choose(&pack_read)?;
    let views = args.views.views("paper")?;
    let batches = args.batches();
    let task = Task {
        open: &open,
        start: &|| args.runtime.runtime(),
        threads: args.alone_threads.unwrap_or(1),
        batches: &batches,
        with_accuracy: !args.no_accuracy,
        with_operators: args.profile,
        plan: args.plan(),
        most: args.most(),
        tell: &MeasuringProgress::say,
        bare: args.bare,
        scene: DrawnInputs {
            pack: &pack_read,
            walks: &walks,
            views: &views,
            settings,
        },
        seed: args.common.seed,
        root: Path::new("/"),
    };
    if args.only_lengths {
        let lengths = measure_lengths(&task, &args.lengths())?;
        return Ok(serde_json::to_value(lengths)?);
    }
    Ok(serde_json::to_value(measure(&task)?)?)
}
