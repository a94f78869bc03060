//! `edgegait score`: how well recognizers hold up.

use super::args::{Common, ViewArgs};
use super::drawing::{DrawArgs, STATED, framing_of, stated};
use super::leave_out::{self, Probes};
use super::progress::Progress;
use super::recognizers::{load, sort_inputs};
use super::source::SourceArgs;
use super::sweep::peak_rss_bytes;
use crate::dataset::{Dataset, Header, IndexRow, InputFile};
use crate::error::{Error, Result};
use crate::evaluate::contest::Contest;
use crate::evaluate::results::{Latency, RunTime, ScoreResults};
use crate::report::{Sample, table, write_page};
use crate::score::{Recognizer, Runtime};
use crate::sweep::{Job, Settings, View, jobs, sweep};
use clap::ValueEnum;
use edgegait_core::pack::Pack;
use edgegait_core::template::Gei;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// First variation that `score` probes with: training stays below.
const PROBES_FROM: u32 = 1_000;
/// Inferences before and during the measurement of latency.
const WARM_UP: usize = 20;
const TIMED: usize = 300;
/// Viewpoints of which the report shows GEIs, where they were swept.
const SHOWN: [(f32, f32); 8] = [
    (0.0, 0.0),
    (45.0, 0.0),
    (90.0, 0.0),
    (135.0, 0.0),
    (180.0, 0.0),
    (90.0, 30.0),
    (90.0, 60.0),
    (90.0, 90.0),
];
/// People whom the report shows.
const SHOWN_PEOPLE: usize = 3;

/// Score recognizers on walks seen from many viewpoints, and write a report
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  edgegait score                                # the shipped models, 26 people, 703 viewpoints\n  edgegait score mine.onnx cohort.egp --walks walk-5kmh --views side --json -\n  edgegait score --runtime ort --ort-lib /path/to/libonnxruntime.so\n\nPeople whom a model has classes for are probed with cycles that training has not seen, and\nthe highest class score decides. Others are enrolled by their first take at the model's\ntraining viewpoints, probed with their other takes, and the nearest embedding decides."
)]
pub struct Args {
    /// ONNX models or "pixels" (the GEI itself), and a pack or a dataset [default: the shipped
    /// models, the built-in cohort]
    #[arg(value_name = "MODEL|PACK|DATASET")]
    inputs: Vec<PathBuf>,
    /// Only these people, by name
    #[arg(long, value_name = "NAME[,NAME..]", value_delimiter = ',')]
    subjects: Vec<String>,
    /// Only these walks, by name [default: walk-5kmh of the built-in cohort, all of a pack]
    #[arg(long, value_name = "NAME[,NAME..]", value_delimiter = ',')]
    walks: Vec<String>,
    /// How people are looked for: among their first takes (or by the model's classes), or each
    /// take among all others at the same viewpoint
    #[arg(long, value_name = "NAME", default_value = "first-take")]
    protocol: ProtocolArg,
    /// Folder of the report
    #[arg(long, value_name = "PATH", default_value = "edgegait-report")]
    out: PathBuf,
    /// Cycles of each walk to probe with, where these are seeded variations [default: 1]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1000))]
    cycles: Option<u32>,
    /// What runs the models: the embedded runtime, or the real ONNX Runtime
    #[arg(long, value_name = "NAME", default_value = "rten")]
    runtime: RuntimeArg,
    /// The ONNX Runtime library, for `--runtime ort` [env: EDGEGAIT_ORT_LIB]
    #[arg(long, value_name = "PATH")]
    ort_lib: Option<PathBuf>,
    #[command(flatten)]
    views: ViewArgs,
    #[command(flatten)]
    draw: DrawArgs,
    #[command(flatten)]
    pub common: Common,
}

/// Names of the protocols.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum ProtocolArg {
    FirstTake,
    LeaveOneTakeOut,
}

/// Names of the runtimes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum RuntimeArg {
    /// rten, embedded
    Rten,
    /// ONNX Runtime, from its shared library
    Ort,
}

impl Args {
    fn runtime(&self) -> Result<Runtime> {
        let named = self
            .ort_lib
            .clone()
            .or_else(|| std::env::var_os("EDGEGAIT_ORT_LIB").map(PathBuf::from));
        match (self.runtime, named) {
            (RuntimeArg::Rten, _) => Ok(Runtime::rten()),
            (RuntimeArg::Ort, Some(library)) => Runtime::ort(library),
            (RuntimeArg::Ort, None) => Err(Error::Usage(
                "--runtime ort needs --ort-lib PATH or EDGEGAIT_ORT_LIB: the onnxruntime wheel has it as onnxruntime/capi/libonnxruntime.so.*".into(),
            )),
        }
    }
}

/// Runs the subcommand.
pub fn run(args: &Args) -> Result<()> {
    let started = Instant::now();
    if args.out.exists() && !args.out.is_dir() {
        return Err(Error::Usage(format!(
            "--out {}: expected a folder, found a file",
            args.out.display()
        )));
    }
    let runtime = args.runtime()?;
    let (models, data) = sort_inputs(&args.inputs)?;
    let mut header = Header::new("score", args.common.seed).with("runtime", runtime.name().name);
    let settings = args.draw.settings(args.common.seed)?;
    let recognizers = load(&models, &runtime, &settings, &mut header)?;
    let (mut results, samples) = match data {
        Some(path) if path.is_dir() => score_dataset(args, &path, &recognizers, header)?,
        pack => score_walks(args, pack, &recognizers, settings, header)?,
    };
    for (result, recognizer) in results.recognizers.iter_mut().zip(&recognizers) {
        result.latency = latency(recognizer.as_ref(), &samples)?;
    }
    if let Some(bytes) = peak_rss_bytes() {
        args.common
            .say(format_args!("peak memory: {} MB", bytes / 1_000_000));
    }
    results.time = Some(RunTime {
        seconds: started.elapsed().as_secs_f64(),
    });
    let page = args.out.join("index.html");
    write_page(&page, &results, &samples)?;
    args.common.say(table(&results));
    for warning in &results.header.warnings {
        args.common.say(format_args!("warning: {warning}"));
    }
    args.common.say(format_args!("report: {}", page.display()));
    args.common.write_json(&results)
}

/// Scores on walks that are drawn here.
fn score_walks(
    args: &Args,
    pack: Option<PathBuf>,
    recognizers: &[Box<dyn Recognizer>],
    settings: Settings,
    mut header: Header,
) -> Result<(ScoreResults, Vec<Sample>)> {
    let views = args.views.views("paper")?;
    header = stated(header, &settings);
    for recognizer in recognizers {
        let framing = Some(settings.framing);
        recognizer
            .contract()
            .require(settings.size, framing, "use")?;
    }
    let source_args = SourceArgs {
        pack,
        subjects: args.subjects.clone(),
        walks: args.walks.clone(),
    };
    let source = source_args.load()?;
    header.inputs.extend(source.inputs.iter().cloned());
    let pack = Pack::parse(&source.bytes).map_err(|error| Error::Failed(error.to_string()))?;
    let walks = source_args.choose(&pack)?;
    header = header
        .with("pack", source.name.as_str())
        .with("views", views.name.as_str())
        .with("viewpoints", views.list.len());
    if args.protocol == ProtocolArg::LeaveOneTakeOut {
        if args.cycles.is_some() {
            return Err(Error::Usage(
                "--cycles: --protocol leave-one-take-out probes with recorded cycles only".into(),
            ));
        }
        let probes = Probes {
            pack: &pack,
            walks: &walks,
            views: &views,
            settings,
        };
        return leave_out::score(&probes, recognizers, header, SHOWN_PEOPLE * SHOWN.len());
    }
    let cycles = args.cycles.unwrap_or(1);
    let all: Vec<_> = pack.walks().collect();
    let names: Vec<&str> = pack.subjects().map(|subject| subject.name).collect();

    let mut contest = Contest::new(
        recognizers,
        walks.iter().map(|&walk| names[all[walk].subject]),
    );
    // People with several takes are enrolled by the first; the others' further cycles are
    // seeded variations.
    let first_take = |subject: usize| {
        let first = walks.iter().find(|&&walk| all[walk].subject == subject);
        first.map_or("", |&walk| all[walk].name)
    };
    let others: Vec<usize> = walks
        .iter()
        .copied()
        .filter(|&walk| all[walk].name != first_take(all[walk].subject))
        .collect();
    let variations = contest.is_closed_set() || others.is_empty();
    let probes = if variations {
        jobs(&pack, &walks, PROBES_FROM..PROBES_FROM + cycles)?
    } else {
        jobs(&pack, &others, 0..1)?
    };
    if !contest.is_closed_set() {
        if variations {
            header.warnings.push(
                "every person has one take: probes are seeded variations of the cycles that enrolled them".into(),
            );
        }
        let first: Vec<usize> = walks
            .iter()
            .copied()
            .filter(|walk| variations || !others.contains(walk))
            .collect();
        let gallery = jobs(&pack, &first, 0..1)?;
        for index in 0..recognizers.len() {
            let viewpoints = contest.gallery_views(index)?;
            let draw = |_: Job, swept: crate::sweep::Swept| Ok(swept.geis);
            sweep(&pack, &gallery, &viewpoints, settings, draw, |job, geis| {
                let subject = names[all[job.walk].subject];
                contest.enrol(index, subject, geis.iter().map(Gei::pixels))
            })?;
        }
        contest.close_gallery()?;
    }

    let mut samples = Vec::new();
    let mut clipped = 0.0;
    let progress = Progress::new("cycles", probes.len());
    sweep(
        &pack,
        &probes,
        &views.list,
        settings,
        |_, swept| {
            progress.step();
            Ok(swept)
        },
        |job, swept| {
            clipped += swept.clipped;
            let subject = names[all[job.walk].subject];
            if samples.len() < SHOWN_PEOPLE * SHOWN.len() {
                samples.extend(shown(subject, &views.list, &swept.geis));
            }
            let angles = views.list.iter().map(angles_of);
            contest.probe(subject, angles, swept.geis.iter().map(Gei::pixels))
        },
    )?;
    drop(progress);
    let geis = (probes.len() * views.list.len()) as u64;
    let silhouettes = geis * u64::from(settings.frames_per_cycle);
    header = header.with("walks", walk_names(&walks, &all)).with(
        "probes",
        if variations {
            format!("variations {PROBES_FROM} to {}", PROBES_FROM + cycles - 1)
        } else {
            "recorded cycles of all takes but the first".into()
        },
    );
    Ok((
        ScoreResults {
            header,
            silhouettes,
            geis,
            clipped_share: Some(clipped / silhouettes as f64),
            recognizers: contest.results(args.common.seed),
            time: None,
        },
        samples,
    ))
}

pub fn angles_of(view: &View) -> (f64, f64) {
    (f64::from(view.azimuth_deg), f64::from(view.elevation_deg))
}

/// The walks' names, each once, at most a dozen.
pub fn walk_names(walks: &[usize], all: &[edgegait_core::pack::Walk<'_>]) -> String {
    let mut names: Vec<&str> = walks.iter().map(|&walk| all[walk].name).collect();
    names.sort_unstable();
    names.dedup();
    if names.len() > 12 {
        return format!("{} names", names.len());
    }
    names.join(",")
}

/// The GEIs of one person that the report shows.
pub fn shown<'a>(
    subject: &'a str,
    views: &'a [View],
    geis: &'a [Gei],
) -> impl Iterator<Item = Sample> + use<'a> {
    views
        .iter()
        .zip(geis)
        .filter(|(view, _)| SHOWN.contains(&(view.azimuth_deg, view.elevation_deg)))
        .map(move |(view, gei)| Sample {
            caption: format!("{subject}, {}°/{}°", view.azimuth_deg, view.elevation_deg),
            size: gei.size(),
            gei: gei.pixels().to_vec(),
        })
}

/// Scores on a dataset's GEIs.
fn score_dataset(
    args: &Args,
    path: &Path,
    recognizers: &[Box<dyn Recognizer>],
    mut header: Header,
) -> Result<(ScoreResults, Vec<Sample>)> {
    let names = [args.subjects.as_slice(), &args.walks];
    args.draw
        .refuse_for_datasets(names, args.cycles, &args.views)?;
    if args.protocol == ProtocolArg::LeaveOneTakeOut {
        return Err(Error::Usage(
            "--protocol leave-one-take-out draws the takes itself: expected a pack, found a dataset"
                .into(),
        ));
    }
    let dataset = Dataset::open(path)?;
    header
        .inputs
        .push(InputFile::of(path.join("manifest.json"))?);
    let framing = framing_of(&dataset, path)?;
    for recognizer in recognizers {
        let contract = recognizer.contract();
        contract.require(dataset.size(), framing, "sweep another dataset with")?;
    }
    if framing.is_none() {
        header.warnings.push(format!(
            "{} does not say how its figures are framed: whether that is as the models expect is unknown",
            path.display()
        ));
    }
    // How these GEIs were drawn is theirs to say.
    for key in STATED {
        if let Some(value) = dataset.manifest().header.settings.get(key) {
            header = header.with(key, value.clone());
        }
    }
    let rows = dataset.index();
    let mut contest = Contest::new(recognizers, rows.iter().map(|row| row.subject.as_str()));
    let first_take = |subject: &str| {
        let first = rows.iter().find(|row| row.subject == subject);
        first.map_or("", |row| row.walk.as_str())
    };
    let is_gallery = |index: usize| rows[index].walk == first_take(&rows[index].subject);
    let closed = contest.is_closed_set();
    if closed {
        for recognizer in recognizers {
            header
                .warnings
                .extend(seen_in_training(recognizer.as_ref(), rows));
        }
    } else {
        if (0..rows.len()).all(is_gallery) {
            return Err(Error::input(
                path,
                "every person has one walk only: expected another to probe with, or a model that has classes for these people",
            ));
        }
        for recognizer in 0..recognizers.len() {
            let views = contest.gallery_views(recognizer)?;
            for (index, row) in rows
                .iter()
                .enumerate()
                .filter(|(index, _)| is_gallery(*index))
            {
                let at = (row.azimuth_deg, row.elevation_deg);
                if views.iter().any(|view| angles_of(view) == at) {
                    contest.enrol(recognizer, &row.subject, [dataset.gei(index)])?;
                }
            }
        }
        contest.close_gallery()?;
    }
    let probes: Vec<usize> = (0..rows.len())
        .filter(|&index| closed || !is_gallery(index))
        .collect();
    let progress = Progress::new("GEIs", probes.len());
    for run in probes.chunk_by(|&a, &b| rows[a].subject == rows[b].subject) {
        let angles = run
            .iter()
            .map(|&index| (rows[index].azimuth_deg, rows[index].elevation_deg));
        let geis = run.iter().map(|&index| dataset.gei(index));
        contest.probe(&rows[run[0]].subject, angles, geis)?;
        run.iter().for_each(|_| progress.step());
    }
    let samples = probes
        .iter()
        .take(SHOWN_PEOPLE * SHOWN.len())
        .map(|&index| Sample {
            caption: format!(
                "{}, {}°/{}°",
                rows[index].subject, rows[index].azimuth_deg, rows[index].elevation_deg
            ),
            size: dataset.size(),
            gei: dataset.gei(index).to_vec(),
        });
    let samples = samples.collect();
    let geis = probes.len() as u64;
    let silhouettes = probes
        .iter()
        .map(|&index| u64::from(rows[index].frames))
        .sum();
    header = header.with("dataset", path.display().to_string());
    Ok((
        ScoreResults {
            header,
            silhouettes,
            geis,
            clipped_share: None,
            recognizers: contest.results(args.common.seed),
            time: None,
        },
        samples,
    ))
}

/// A warning if a recognizer was trained on cycles that are among these rows.
fn seen_in_training(recognizer: &dyn Recognizer, rows: &[IndexRow]) -> Option<String> {
    let training = &recognizer.contract().training;
    let seen = rows.iter().filter(|row| {
        // Cycle 0 is the stored one, whatever the seed.
        training.walks.contains(&row.walk)
            && row.cycle < training.cycles
            && (row.cycle == 0 || row.seed == training.seed)
    });
    let seen = seen.count();
    (seen > 0).then(|| {
        format!(
            "{}: {seen} of {} probes show cycles that it was trained on (sweep others with --first-cycle 1000)",
            recognizer.name(),
            rows.len()
        )
    })
}

/// How long one GEI takes, one at a time, after a warm-up.
fn latency(recognizer: &dyn Recognizer, samples: &[Sample]) -> Result<Option<Latency>> {
    let range = recognizer.contract().input_range;
    let inputs: Vec<Vec<f32>> = samples
        .iter()
        .map(|sample| sample.gei.iter().map(|&byte| range.of_byte(byte)).collect())
        .collect();
    if inputs.is_empty() {
        return Ok(None);
    }
    let mut times = Vec::with_capacity(TIMED);
    for (index, input) in inputs.iter().cycle().take(WARM_UP + TIMED).enumerate() {
        let started = Instant::now();
        recognizer.run(input, 1)?;
        if index >= WARM_UP {
            times.push(started.elapsed().as_secs_f64() * 1e6);
        }
    }
    Ok(Latency::of(&times))
}
