//! `edgegait score`: scores recognizers.

use super::args::{Common, FileArgs};
use super::baselines::WantedBaselines;
use super::cache::CacheArgs;
use super::contest::{ContestArgs, Participants};
use super::outputs::{Output, OutputKind};
use super::progress::Progress;
use super::recognizers::{load, sort_inputs, with_contracts, with_held};
use super::runtime::RuntimeArgs;
use super::sweep::peak_rss_bytes;
use crate::dataset::sequences::ViewLabel;
use crate::draw::template::TemplateShape;
use crate::error::Result;
use crate::evaluate::contest::{Contest, Entrant, ShownPicture};
use crate::evaluate::results::{Latency, ProbeAnswer, RunTime, ScoreResults};
use crate::files::{ResultHeader, write_bytes};
use crate::inference::{Recognizer, shipped};
use crate::report::{TemplateSample, contest_table, speed_error_svg, table, write_page};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Numbers of inferences before and during the measurement of latency.
const WARM_UP: usize = 20;
const TIMED: usize = 300;
/// Time limits of the warm-up and the measurement of a slow recognizer, and the time after which as
/// many samples as the highest percentile needs are enough.
const MOST_WARM_UP: Duration = Duration::from_secs(1);
const MOST_TIMED: Duration = Duration::from_secs(10);
const USUALLY_TIMED: Duration = Duration::from_secs(2);
const ENOUGH: usize = 100;
/// The advice about scoring that takes long.
const LESS: &str = "--views side, --subjects and --walks reduce the work; networks' answers are cached, \
                    so that the same command continues where it was interrupted (--cache)";
/// Viewpoints of the templates in the report, if they were drawn.
const SHOWN: [(f64, f64); 8] = [
    (0.0, 0.0),
    (45.0, 0.0),
    (90.0, 0.0),
    (135.0, 0.0),
    (180.0, 0.0),
    (90.0, 30.0),
    (90.0, 60.0),
    (90.0, 90.0),
];
/// The picture of Rank-1 against time in the report's folder.
const PICTURE: &str = "speed-error.svg";
/// The shipped model of GEIs with the longest embedding.
const LARGEST: &str = "geinet";
/// Number of people that the report shows.
const SHOWN_PEOPLE: usize = 3;

/// Score recognizers on walks seen from many viewpoints, and write a report
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  edgegait score                                # the shipped models on people whom none has seen\n  edgegait score mine.onnx geinet --protocol sessions   # beside your own\n  edgegait score side spread                    # linear models on their own 26 people, 703 viewpoints\n  edgegait score mine.onnx cohort.egp --walks walk-5kmh --views side --json -\n  edgegait score --runtime ort --ort-lib /path/to/libonnxruntime.so\n\nIf a model has classes for all people, probes are cycles that training has not seen, and the highest class score decides. Otherwise the gallery is each person's first take at the model's training viewpoints, probes are the other takes, and the nearest embedding decides."
)]
pub(super) struct ScoreArgs {
    /// ONNX models or "pixels" (the pixel baseline), and a pack, a dataset or a tree of silhouettes
    /// (<person>/<take>/<view>/ with PNG frames or a pickled array) [default: the six shipped models
    /// on 30 people whom none has seen; for chosen walks, side and spread on the built-in cohort]
    #[arg(value_name = "MODEL|PACK|DATASET|TREE")]
    inputs: Vec<PathBuf>,
    /// Folder of the report
    #[arg(long, value_name = "PATH", default_value = "edgegait-report")]
    out: PathBuf,
    /// Write each recognizer's answer to each probe, with the rank and distance of the right person
    #[arg(long, value_name = "FILE")]
    probes_csv: Option<PathBuf>,
    #[command(flatten)]
    runtime: RuntimeArgs,
    #[command(flatten)]
    pub contest: ContestArgs,
    /// Omit the baselines: `pixels`, which compares the templates themselves, and `random`, which
    /// compares random projections of them
    #[arg(long)]
    no_baselines: bool,
    #[command(flatten)]
    cache: CacheArgs,
    #[command(flatten)]
    pub common: Common,
}

/// Runs the subcommand.
pub(super) fn run(args: &ScoreArgs) -> Result<()> {
    run_with(args, &[])
}

/// Runs the subcommand with recognizers of the program that runs it in its own process; shipped
/// models are scored only if named.
pub(super) fn run_with(args: &ScoreArgs, held: &[Arc<dyn Recognizer>]) -> Result<()> {
    let started = Instant::now();
    let runtime = args.runtime.runtime()?;
    let (mut models, data) = sort_inputs(&args.inputs)?;
    // The command with nothing but its name.
    let is_showcase = args.inputs.is_empty() && held.is_empty() && args.contest.is_open();
    let contest = if is_showcase {
        models.extend(shipped::names().map(PathBuf::from));
        // The baselines have the input of the first, and as many numbers.
        models.sort_by_key(|name| name != Path::new(LARGEST));
        args.contest.of_sessions()
    } else {
        args.contest.clone()
    };
    let mut baselines = WantedBaselines {
        has_all: !args.no_baselines,
        is_of_first: is_showcase,
        ..WantedBaselines::default()
    };
    baselines.apart(&mut models, !held.is_empty());
    let header = ResultHeader::new("score", args.common.seed)
        .with("runtime", runtime.name().name)
        .with("provider", runtime.name().provider);
    let cache = args.cache.cache();
    let field = Participants {
        common: &args.common,
        load: &|inputs, header| {
            let loaded = if models.is_empty() && !held.is_empty() {
                Vec::new()
            } else {
                load(&models, &runtime, &cache, inputs, header)?
            };
            with_held(loaded, held, inputs)
        },
        baselines,
        views: None,
    };
    let mut rows = args
        .probes_csv
        .as_ref()
        .map(|_| csv::Writer::from_writer(Vec::new()));
    let (mut results, samples) =
        contest.run(&field, data, header, |contest, entrants, header| {
            judged(contest, entrants, header, &args.common, &mut rows)
        })?;
    if let Some(bytes) = peak_rss_bytes().filter(|_| !is_showcase) {
        args.common
            .say(format_args!("peak memory: {} MB", bytes / 1_000_000));
    }
    results.time = Some(RunTime {
        seconds: started.elapsed().as_secs_f64(),
    });
    args.common.say(if is_showcase {
        contest_table(&results)
    } else {
        table(&results)
    });
    args.common.say_warnings(&results.header.warnings);
    // Each output is tried, even if another fails.
    let rows = match (&args.probes_csv, rows) {
        (Some(path), Some(rows)) => written_rows(path, rows),
        _ => Ok(()),
    };
    let page = args.out.join("index.html");
    let report = write_page(&page, &results, &samples);
    if report.is_ok() {
        args.common.say(format_args!("report: {}", page.display()));
    }
    let picture = speed_error_svg(&results).map_or(Ok(()), |picture| {
        write_bytes(args.out.join(PICTURE), picture.as_bytes())
    });
    let written = args.common.write_json(&results).and(report).and(picture);
    written.and(rows)
}

impl ScoreArgs {
    /// Returns the files that the command reads and writes.
    pub(super) fn files(&self) -> FileArgs {
        let report = Output::new("--out", &self.out, OutputKind::Report);
        let picture = Output::new("--out", &self.out.join(PICTURE), OutputKind::Svg);
        let rows = self.probes_csv.as_ref();
        let rows =
            rows.map(|path| Output::new("--probes-csv", path, OutputKind::Csv("recognizer")));
        FileArgs {
            inputs: with_contracts(&self.inputs)
                .into_iter()
                .chain(self.contest.inputs())
                .collect(),
            outputs: [report, picture].into_iter().chain(rows).collect(),
        }
    }
}

/// Writes the table of answers.
fn written_rows(path: &Path, rows: ProbeTable) -> Result<()> {
    let bytes = rows.into_inner();
    let bytes = bytes.map_err(|error| csv::Error::from(error.into_error()))?;
    write_bytes(path, &bytes)
}

/// A table that is being written.
type ProbeTable = csv::Writer<Vec<u8>>;

/// Runs a contest, and returns its results and the templates for the report.
fn judged(
    contest: &Contest<'_>,
    entrants: &[Entrant],
    mut header: ResultHeader,
    common: &Common,
    rows: &mut Option<ProbeTable>,
) -> Result<(ScoreResults, Vec<TemplateSample>)> {
    let sequences = contest.source().sequences();
    let (mut samples, mut others) = (Vec::new(), Vec::new());
    let mut pictures: Vec<Vec<SeenPicture>> = vec![Vec::new(); entrants.len()];
    let is_first = |&at: &usize| !(0..at).any(|other| entrants[at].is_shown_as(&entrants[other]));
    let shown = |at: usize| {
        let template = entrants[at].recognizer.contract().template;
        let all = sequences.list.iter();
        all.filter(|sequence| sequence.purpose.suits(template))
            .count()
    };
    let shown: usize = (0..entrants.len()).filter(is_first).map(shown).sum();
    let progress = Progress::new(common, ("recognizing", "sequences"), shown).advising(LESS);
    let mut tell = |answer: ProbeAnswer<'_>| {
        progress.check()?;
        rows.as_mut()
            .map_or(Ok(()), |rows| Ok(rows.serialize(answer)?))
    };
    let mut see = |picture: ShownPicture<'_>| {
        let ShownPicture {
            sequence,
            entrant,
            is_probe,
            bytes,
        } = picture;
        progress.step()?;
        let contract = entrants[entrant].recognizer.contract();
        if pictures[entrant].len() < SHOWN_PEOPLE * SHOWN.len() {
            pictures[entrant].push(SeenPicture {
                bytes: bytes.to_vec(),
                angles_deg: sequences.view_label(sequence).angles_deg(),
            });
        }
        let TemplateShape::Image { planes, .. } = contract.shape() else {
            return Ok(());
        };
        let is_one = bytes.len() == contract.numbers();
        if !is_probe || !is_one || samples.len() == SHOWN_PEOPLE * SHOWN.len() {
            return Ok(());
        }
        let seen = sequences.view_label(sequence);
        let name = &sequences.subjects[sequences.subject(sequence)];
        let sample = TemplateSample {
            caption: match seen {
                ViewLabel::Angles(azimuth, elevation) => format!("{name}, {azimuth}°/{elevation}°"),
                ViewLabel::Named(view) => format!("{name}, {view}"),
            },
            template: contract.template,
            rows: planes * contract.rows,
            columns: contract.columns,
            pixels: bytes.to_vec(),
        };
        if seen.angles_deg().is_some_and(|at| SHOWN.contains(&at)) {
            samples.push(sample);
        } else if others.len() < SHOWN_PEOPLE * SHOWN.len() {
            others.push(sample);
        }
        Ok(())
    };
    let outcome = contest.run(entrants, common.seed, &mut see, &mut tell)?;
    drop(progress);
    header
        .warnings
        .extend(outcome.warnings.iter().map(ToString::to_string));
    let shown = outcome.shown;
    if shown.empty > 0 {
        header.warnings.push(format!(
            "{} frames without a figure were left out",
            shown.empty
        ));
    }
    let mut results = ScoreResults {
        header: header.with(
            "protocol_description",
            contest.protocol().description.as_str(),
        ),
        silhouettes: shown.silhouettes,
        geis: outcome.sequences,
        clipped_share: shown
            .clipped
            .map(|clipped| clipped / shown.silhouettes.max(1) as f64),
        recognizers: outcome.results,
        paired: outcome.paired,
        time: None,
    };
    for (at, (result, entrant)) in results.recognizers.iter_mut().zip(entrants).enumerate() {
        // Entrants with the same inputs were shown them together with the first such entrant.
        result.model_bytes = entrant.model_bytes;
        let of =
            |other: &usize| !pictures[*other].is_empty() && entrants[*other].is_shown_as(entrant);
        if let Some(first) = (0..=at).find(of) {
            let recognizer = entrant.recognizer.as_ref();
            let computing = recognizer.behind().unwrap_or(recognizer);
            result.latency = latency(computing, &pictures[first])?;
        }
    }
    if samples.is_empty() {
        samples = others;
    }
    Ok((results, samples))
}

/// An image that a recognizer was shown.
#[derive(Clone)]
struct SeenPicture {
    bytes: Vec<u8>,
    /// Azimuth and elevation, if known.
    angles_deg: Option<(f64, f64)>,
}

/// Measures the time of an inference of one input, after a warm-up.
fn latency(recognizer: &dyn Recognizer, pictures: &[SeenPicture]) -> Result<Option<Latency>> {
    let contract = recognizer.contract();
    let fed = |seen: &SeenPicture| {
        let mut input = Vec::new();
        contract.feed(&seen.bytes, &mut input);
        contract.feed_view(seen.angles_deg, &mut input)?;
        Ok(input)
    };
    let inputs: Vec<Vec<f32>> = pictures.iter().map(fed).collect::<Result<_>>()?;
    let mut times = Vec::with_capacity(TIMED);
    let mut failed = Ok(());
    recognizer.beside(&mut || {
        failed = timed(recognizer, &inputs, &mut times);
    });
    failed.map(|()| Latency::from_samples(&times))
}

/// Appends the times of inferences of one input in microseconds, after a warm-up. If there is an
/// input, both run at least once; both stop at their time limits.
fn timed(recognizer: &dyn Recognizer, inputs: &[Vec<f32>], times: &mut Vec<f64>) -> Result<()> {
    let started = Instant::now();
    for input in inputs.iter().cycle().take(WARM_UP) {
        recognizer.run(input, 1)?;
        if started.elapsed() > MOST_WARM_UP {
            break;
        }
    }
    let first = Instant::now();
    for input in inputs.iter().cycle().take(TIMED) {
        let started = Instant::now();
        recognizer.run(input, 1)?;
        times.push(started.elapsed().as_secs_f64() * 1e6);
        let limit = if times.len() < ENOUGH {
            MOST_TIMED
        } else {
            USUALLY_TIMED
        };
        if first.elapsed() > limit {
            break;
        }
    }
    Ok(())
}
