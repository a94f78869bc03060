//! `edgegait parity`: checks whether runtimes, or forms of a model, give the same answers.

mod text;

use super::Ending;
use super::args::{Common, FileArgs};
use super::baselines::{WantedBaselines, is_baseline};
use super::contest::{ContestArgs, InputSource, Participants};
use super::keep_going::with_hint;
use super::progress::Progress;
use super::recognizers::{entrant, sort_inputs, with_contracts};
use super::runtime::{RuntimeChoice, refuse_idle_library};
use super::trial::try_out;
use crate::draw::sweep::Views;
use crate::error::{ChoiceError, Error, EvaluateError, Result, SettingError};
use crate::evaluate::contest::{Contest, Entrant, ShownPicture};
use crate::evaluate::parity::{Limits, ParityResults, ParitySide, SideAnswers, Verdict};
use crate::files::ResultHeader;
use crate::inference::{Contract, Model, Runtime, shipped};
use std::path::{Path, PathBuf};

/// Default viewpoints: the walker's left from front to back, level and from above. Our choice: ten
/// viewpoints take seconds and show each kind of image.
const AZIMUTHS_DEG: [f32; 5] = [0.0, 45.0, 90.0, 135.0, 180.0];
const ELEVATIONS_DEG: [f32; 2] = [0.0, 30.0];

/// Compare the answers of one model on several runtimes, or of several forms of a model
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  edgegait parity mine.onnx                                  # the embedded runtime and ONNX Runtime\n  edgegait parity mine.onnx --runtime ort --runtime ort:xnnpack\n  edgegait parity float.onnx int8.onnx --runtime ort\n  edgegait parity float.onnx int8.onnx int8.onnx --runtime ort --runtime ort --runtime ort:qnn\n\nThe first side is the reference, and each of the others is compared with it: several models with one runtime, several runtimes with one model, or equal numbers of both, in pairs. All get the same images, by default from 10 viewpoints, and rank-1 is computed as in `edgegait score`. A relative difference is the length of the difference of two answers, divided by the root mean square distance of the reference's answers from their mean. The exit code is 0 if all sides give the same answers, 4 if one differs, 1 or 2 after an error."
)]
pub(super) struct ParityArgs {
    /// ONNX models, the reference first, and a pack, a dataset or a tree of silhouettes [default:
    /// the built-in cohort]; a model without a .toml beside it uses the contract of the first
    #[arg(value_name = "MODEL|PACK|DATASET|TREE", required = true)]
    inputs: Vec<PathBuf>,
    /// Runtime of a side: rten (the embedded runtime), ort (ONNX Runtime), or ort:PROVIDER with one
    /// of cpu, xnnpack, acl, armnn, nnapi, coreml, qnn, rknpu, cuda, tensorrt, openvino; repeat it
    /// for several sides [default: rten, and ort too if there is one model]
    #[arg(long, value_name = "NAME[:PROVIDER]", value_parser = RuntimeChoice::parse)]
    runtime: Vec<RuntimeChoice>,
    /// The ONNX Runtime library, for `--runtime ort` [env: EDGEGAIT_ORT_LIB, ORT_DYLIB_PATH;
    /// default: searched for in Python's onnxruntime and in the system's library folders]
    #[arg(long, value_name = "PATH")]
    ort_lib: Option<PathBuf>,
    /// Limit of the relative difference of any answer [default: 0.0002; 0.5 if a side is quantised]
    #[arg(long, value_name = "X", value_parser = limit)]
    max_relative_difference: Option<f64>,
    /// Limit of the mean relative difference [default: 0.0002; 0.1 if a side is quantised]
    #[arg(long, value_name = "X", value_parser = limit)]
    max_mean_relative_difference: Option<f64>,
    /// Limit of the share of probes that only one side identifies correctly, 0 to 1 [default:
    /// 0.001; 0.05 if a side is quantised]
    #[arg(long, value_name = "SHARE", value_parser = share)]
    max_changed_hits: Option<f64>,
    #[command(flatten)]
    contest: ContestArgs,
    #[command(flatten)]
    pub common: Common,
}

fn limit(text: &str) -> std::result::Result<f64, String> {
    let found = text
        .parse()
        .ok()
        .filter(|x: &f64| x.is_finite() && *x >= 0.0);
    found.ok_or_else(|| "expected a number, 0 or more".to_owned())
}

fn share(text: &str) -> std::result::Result<f64, String> {
    let found = text.parse().ok().filter(|x| (0.0..=1.0).contains(x));
    found.ok_or_else(|| "expected a share from 0 to 1".to_owned())
}

impl ParityArgs {
    /// Returns the files that the command reads and writes.
    pub(super) fn files(&self) -> FileArgs {
        FileArgs {
            inputs: with_contracts(&self.inputs)
                .into_iter()
                .chain(self.contest.inputs())
                .collect(),
            outputs: Vec::new(),
        }
    }

    /// Returns the limits for these sides.
    fn limits(&self, reference: &ParitySide, other: &ParitySide) -> Limits {
        let usual = Limits::default_for(reference, other);
        let or = |given: Option<f64>, usual: f64| given.unwrap_or(usual);
        Limits {
            relative_difference: or(self.max_relative_difference, usual.relative_difference),
            mean_relative_difference: or(
                self.max_mean_relative_difference,
                usual.mean_relative_difference,
            ),
            changed_hits: or(self.max_changed_hits, usual.changed_hits),
        }
    }
}

/// A model, named after its side, and its runtime.
struct Planned {
    model: Model,
    runtime: Runtime,
}

/// Runs the subcommand.
pub(super) fn run(args: &ParityArgs) -> Result<Ending> {
    let (paths, data) = sort_inputs(&args.inputs)?;
    let engines = paired(&paths, &args.runtime)?;
    let mut header = ResultHeader::new("parity", args.common.seed).with(
        "runtime",
        engines.iter().map(ToString::to_string).collect::<Vec<_>>(),
    );
    let planned = planned(&paths, &engines, args.ort_lib.as_deref(), &mut header)?;
    let field = Participants {
        common: &args.common,
        load: &|inputs, _| load(&planned, inputs),
        baselines: WantedBaselines::default(),
        views: Some(Views::grid("10 of parity", AZIMUTHS_DEG, ELEVATIONS_DEG)?),
    };
    let results = args
        .contest
        .run(&field, data, header, |contest, entrants, header| {
            compared(args, &planned, contest, entrants, header)
        })?;
    args.common.say(text::Text(&results));
    args.common.say_warnings(&results.header.warnings);
    args.common.write_json(&results)?;
    Ok(match results.verdict {
        Verdict::Same => Ending::Done,
        Verdict::Differs => Ending::LimitMissed,
    })
}

/// Returns the runtime of each side; there are as many sides as models or runtimes.
fn paired(models: &[PathBuf], runtimes: &[RuntimeChoice]) -> Result<Vec<RuntimeChoice>> {
    if models.iter().any(|path| is_baseline(path)) {
        return Err(Error::Usage(
            "pixels: expected models to compare, found the baseline, which computes nothing".into(),
        ));
    }
    let usual: &[RuntimeChoice] = match (models.len(), runtimes) {
        (1, []) => &[RuntimeChoice::EMBEDDED, RuntimeChoice::ONNX_RUNTIME],
        (_, []) => &[RuntimeChoice::EMBEDDED],
        _ => runtimes,
    };
    match (models.len(), usual) {
        (0, _) => Err(Error::Usage(
            "expected a model to compare, found none".into(),
        )),
        (1, [_]) => Err(Error::Usage(
            "expected two sides to compare, found one (name another --runtime or another model)"
                .into(),
        )),
        (1, several) => Ok(several.to_vec()),
        (all, &[one]) => Ok(vec![one; all]),
        (all, several) if all == several.len() => Ok(several.to_vec()),
        (all, several) => Err(Error::Usage(format!(
            "expected one model, one --runtime, or as many of both, found {all} and {}",
            several.len()
        ))),
    }
}

/// Opens the models and starts the runtimes.
fn planned(
    paths: &[PathBuf],
    engines: &[RuntimeChoice],
    ort_lib: Option<&Path>,
    header: &mut ResultHeader,
) -> Result<Vec<Planned>> {
    refuse_idle_library(ort_lib, engines)?;
    let mut planned: Vec<Planned> = Vec::new();
    for (at, engine) in engines.iter().enumerate() {
        let path = paths.get(at).unwrap_or(&paths[0]);
        let runtime = engine.load(ort_lib).map_err(|error| match error {
            Error::Choice(
                error @ ChoiceError::Setting {
                    problem: SettingError::Provider { .. },
                    ..
                },
            ) => Error::Usage(format!("--runtime {engine}: {error}")),
            other => other,
        })?;
        let model = opened(path, planned.first(), header)?;
        let label = ParitySide::new(&model, runtime.name()).label();
        let one = Planned {
            model: model.named(label),
            runtime,
        };
        one.refuse_like(&planned)?;
        try_out(&one.model, &one.runtime)?;
        planned.push(one);
    }
    Ok(planned)
}

/// Opens a model that can be compared with the first.
fn opened(path: &Path, first: Option<&Planned>, header: &mut ResultHeader) -> Result<Model> {
    let Some(first) = first else {
        let model = shipped::open(path)?;
        header.inputs.extend(model.inputs()?);
        header.warnings.extend(model.warnings());
        return Ok(model);
    };
    let usual = Contract {
        name: String::new(),
        ..first.model.contract().clone()
    };
    let model = if shipped::is_name(path) {
        shipped::open(path)?
    } else {
        Model::open_or(path, &usual)?
    };
    if path == first.model.path() {
        return Ok(model);
    }
    if !shipped::is_name(path) && !Contract::path_beside(path).is_file() {
        let warning = format!(
            "{}: no .toml lies beside it, so it uses the contract of {}",
            path.display(),
            first.model.path().display()
        );
        if !header.warnings.contains(&warning) {
            header.warnings.push(warning);
        }
    }
    if let Some((what, values)) = first.model.contract().difference(model.contract()) {
        let sides = [&first.model, &model].map(|side| {
            let guessed = if side.is_guessed() {
                " (which has no .toml beside it)"
            } else {
                ""
            };
            format!("{}{guessed}", side.path().display())
        });
        return Err(EvaluateError::SidesDiffer {
            what,
            sides,
            values,
        }
        .into());
    }
    let known = |path: &String| header.inputs.iter().any(|input| input.path == *path);
    let inputs = model.inputs()?.into_iter();
    let new: Vec<_> = inputs.filter(|input| !known(&input.path)).collect();
    header.inputs.extend(new);
    header.warnings.extend(model.warnings());
    Ok(model)
}

impl Planned {
    /// Rejects a side that is the same as an earlier one.
    fn refuse_like(&self, before: &[Self]) -> Result<()> {
        let is_like = |other: &&Self| {
            other.model.bytes() == self.model.bytes() && other.runtime.name() == self.runtime.name()
        };
        match before.iter().find(is_like) {
            None => Ok(()),
            Some(other) if other.model.path() == self.model.path() => Err(Error::Usage(format!(
                "{}: appears twice (name another --runtime or another model)",
                self.model.contract().name
            ))),
            Some(other) => Err(Error::Usage(format!(
                "{} and {}: are the same file on the same runtime",
                other.model.path().display(),
                self.model.path().display()
            ))),
        }
    }
}

/// Loads each model on its runtime; an error names the side.
fn load(planned: &[Planned], inputs: InputSource<'_>) -> Result<Vec<Entrant>> {
    let each = planned.iter().enumerate().map(|(at, one)| {
        entrant(&one.model, &one.runtime, inputs)
            .map_err(|error| with_hint(error, &format!("side {}: {}", at + 1, one.runtime.name())))
    });
    each.collect()
}

/// Shows all sides the same images, and compares their answers.
fn compared(
    args: &ParityArgs,
    planned: &[Planned],
    contest: &Contest<'_>,
    entrants: &[Entrant],
    mut header: ResultHeader,
) -> Result<ParityResults> {
    let sequences = contest.source().sequences();
    let progress = Progress::new(
        &args.common,
        ("comparing", "sequences"),
        sequences.list.len(),
    );
    let (mut first, mut seen_from) = (Vec::new(), None);
    let mut seen = |picture: ShownPicture<'_>| {
        if first.is_empty() {
            first = picture.bytes.to_vec();
            seen_from = sequences.view_label(picture.sequence).angles_deg();
        }
        progress.step()
    };
    let answered = SideAnswers::run(contest, entrants, args.common.seed, &mut seen)?;
    drop(progress);
    let mut sides = Vec::new();
    for (at, one) in planned.iter().enumerate() {
        let mut side = ParitySide::new(&one.model, one.runtime.name());
        answered.complete(&mut side, at);
        if side.is_worth_profiling() {
            let mut input = Vec::new();
            one.model.contract().feed(&first, &mut input);
            one.model.contract().feed_view(seen_from, &mut input)?;
            match one.runtime.profile(&one.model, &input) {
                Ok(ran) => side = side.with_operators(ran),
                Err(error) => header
                    .warnings
                    .push(format!("it is not known where each operation ran: {error}")),
            }
        }
        sides.push(side);
    }
    let others = 1..sides.len();
    let comparisons: Vec<_> = others
        .map(|at| answered.compare(&sides, at, args.limits(&sides[0], &sides[at])))
        .collect();
    let is_same = comparisons
        .iter()
        .all(|comparison| comparison.verdict == Verdict::Same);
    Ok(ParityResults {
        verdict: if is_same {
            Verdict::Same
        } else {
            Verdict::Differs
        },
        sequences: answered.sequences(),
        people: sequences.subjects.len(),
        viewpoints: sequences.views.len(),
        protocol: contest.protocol().name.clone(),
        header,
        sides,
        comparisons,
    })
}
