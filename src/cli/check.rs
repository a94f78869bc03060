//! `edgegait check`: tests whether a model works, before it is scored.

use super::Ending;
use super::args::{Common, FileArgs};
use super::hints::WithFlags;
use super::recognizers::with_contracts;
use super::runtime::RuntimeChoice;
use super::trial::try_out;
use super::walks::{SelectionArgs, SourceArgs};
use crate::bench::DrawnInputs;
use crate::draw::sweep::{Settings, View, Views};
use crate::draw::template::Template;
use crate::error::{ChoiceError, Error, Result};
use crate::evaluate::checkup::Checkup;
use crate::evaluate::contest::{ContestOptions, DrawnContest, Entrant};
use crate::evaluate::protocol::Protocol;
use crate::files::ResultHeader;
use crate::inference::baseline::PIXELS;
use crate::inference::{Contract, Model, list_of, shipped};
use crate::report::percent;
use edgegait_core::pack::Pack;
use serde::Serialize;
use std::path::PathBuf;

/// The error of ONNX Runtime if its library was not found.
const NO_LIBRARY: &str =
    "its library was not found (pip install onnxruntime, or name it with --ort-lib)";
/// Azimuths of the probes, degrees, with the gallery at the side: from exactly the side, even an
/// untrained model recognizes people. Our choice.
const SIDES_DEG: [f32; 3] = [60.0, 90.0, 120.0];
/// People in the test inputs, one input each.
const SHOWN: usize = 8;

/// Try a model on both runtimes with a few inputs, and report problems
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  edgegait check mine.onnx\n  edgegait check mine.onnx --ort-lib /path/to/libonnxruntime.so --json -\n\nA model passes if it loads, if its answers are finite and depend on its input alone, and if all available runtimes give the same answers. A rank-1 below that of the pixel baseline indicates wrong outputs, distance or framing. The exit code is 0 without problems, 4 with problems, 1 or 2 after an error."
)]
pub(super) struct CheckArgs {
    /// An ONNX model, or a shipped model's name
    #[arg(value_name = "MODEL")]
    model: PathBuf,
    /// The ONNX Runtime library [env: EDGEGAIT_ORT_LIB, ORT_DYLIB_PATH; default: searched for in
    /// Python's onnxruntime and in the system's library folders]
    #[arg(long, value_name = "PATH")]
    ort_lib: Option<PathBuf>,
    #[command(flatten)]
    pub common: Common,
}

impl CheckArgs {
    /// Returns the files that the command reads and writes.
    pub(super) fn files(&self) -> FileArgs {
        FileArgs {
            inputs: with_contracts(std::slice::from_ref(&self.model)),
            outputs: Vec::new(),
        }
    }
}

/// The result of trying a model on a runtime.
#[derive(Serialize)]
struct Tried {
    /// The requested runtime: `rten` or `ort`.
    runtime: String,
    /// The checkup, if the model loaded.
    checkup: Option<Checkup>,
    /// Why it did not load.
    error: Option<String>,
    /// Whether only the library is missing, which is not a problem of the model.
    #[serde(skip)]
    lacks_library: bool,
}

/// Rank-1 with a gallery at the side, or at each other viewpoint.
#[derive(Serialize)]
struct FromTheSide {
    seen_from: String,
    people: u64,
    probes: u64,
    rank1: f64,
    /// Rank-1 of the pixel baseline; none for sequences of silhouettes.
    pixels_rank1: Option<f64>,
}

/// The results of the command.
#[derive(Serialize)]
struct CheckResults<'a> {
    #[serde(flatten)]
    header: ResultHeader,
    contract: &'a Contract,
    /// Whether the contract was guessed, without a file beside the model.
    guessed: bool,
    parameters: u64,
    tried: Vec<Tried>,
    /// The difference between the runtimes' answers, relative to the distance of answers from
    /// their mean.
    runtimes_apart: Option<f64>,
    from_the_side: Option<FromTheSide>,
    /// The problems that were found.
    problems: Vec<String>,
}

/// Runs the subcommand.
pub(super) fn run(args: &CheckArgs) -> Result<Ending> {
    let model = shipped::open(&args.model)?;
    let contract = model.contract();
    let seed = args.common.seed;
    let mut header = ResultHeader::new("check", seed);
    header.inputs = model.inputs()?;
    header.warnings = model.warnings();
    let source_args = SourceArgs::new(None, SelectionArgs::default());
    let source = source_args.load(&args.common)?;
    let pack = Pack::parse(&source.bytes)?;
    let walks = source_args.choose(&pack)?;
    let usual = Settings {
        seed,
        ..Settings::default()
    };
    let settings = Entrant::settings_of(contract, usual)?;
    let views = views(contract)?;
    let scene = DrawnInputs {
        pack: &pack,
        walks: &walks,
        views: &views,
        settings,
    };
    let mut inputs = Vec::new();
    for at in 0..SHOWN.min(walks.len()) {
        let mut input = Vec::new();
        scene.append_input(contract, at, &mut input)?;
        inputs.push(input);
    }
    let (tried, best) = try_on_both(args, &model, settings, &inputs);
    let mut problems = problems_of(&tried)?;
    let both: Vec<&Checkup> = tried
        .iter()
        .filter_map(|run| run.checkup.as_ref())
        .collect();
    let runtimes_apart = match both[..] {
        [one, other] => one.apart(other),
        _ => None,
    };
    problems.extend(doubts(&model, &both, runtimes_apart));
    let from_the_side = best
        .map(|entrant| from_the_side(entrant, &scene, seed))
        .transpose()?;
    if let Some(found) = &from_the_side {
        problems.extend(found.doubt());
    }
    let results = CheckResults {
        header,
        contract,
        guessed: model.is_guessed(),
        parameters: model.graph().parameters,
        tried,
        runtimes_apart,
        from_the_side,
        problems,
    };
    say(args, &model, &results);
    args.common.write_json(&results)?;
    Ok(if results.problems.is_empty() {
        Ending::Done
    } else {
        Ending::LimitMissed
    })
}

/// Shows the inputs to a model on each runtime. Returns what was found, and the model on the first
/// runtime where it has no problem.
fn try_on_both(
    args: &CheckArgs,
    model: &Model,
    settings: Settings,
    inputs: &[Vec<f32>],
) -> (Vec<Tried>, Option<Entrant>) {
    let mut tried = Vec::new();
    let mut best: Option<Entrant> = None;
    for engine in [RuntimeChoice::EMBEDDED, RuntimeChoice::ONNX_RUNTIME] {
        let found = engine.load(args.ort_lib.as_deref()).and_then(|runtime| {
            try_out(model, &runtime)?;
            let entrant = Entrant::drawn(model, &runtime, settings)?;
            let checkup = Checkup::run(entrant.recognizer.as_ref(), inputs)?;
            Ok((entrant, checkup))
        });
        let mut one = Tried {
            runtime: engine.to_string(),
            checkup: None,
            error: None,
            lacks_library: false,
        };
        match found {
            Ok((entrant, checkup)) => {
                if checkup.problems.is_empty() {
                    best.get_or_insert(entrant);
                }
                one.checkup = Some(checkup);
            }
            Err(Error::Choice(ChoiceError::NoLibrary { .. })) if args.ort_lib.is_none() => {
                one.error = Some(NO_LIBRARY.into());
                one.lacks_library = true;
            }
            Err(other) => one.error = Some(WithFlags(&other).with_runtime("--runtime ort")),
        }
        tried.push(one);
    }
    (tried, best)
}

/// Returns problems that checkups of a model show together, and the difference between runtimes.
fn doubts(model: &Model, checkups: &[&Checkup], apart: Option<f64>) -> Vec<String> {
    let mut problems = Vec::new();
    if let [one, other] = checkups
        && one.embedding_dims != other.embedding_dims
    {
        problems.push("the runtimes give embeddings of different lengths".into());
    }
    let has_classes = !model.contract().classes.is_empty();
    if checkups.first().is_some_and(|checkup| checkup.is_softmax()) && !has_classes {
        problems.push(
            "its embeddings sum to 1, as after a softmax: export the layer before it, or name classes in its \
             .toml"
                .into(),
        );
    }
    let is_quantized = model.graph().is_quantized();
    if let Some(apart) = apart.filter(|apart| !Checkup::is_alike(*apart, is_quantized)) {
        problems.push(format!(
            "the runtimes' answers differ by {apart:.1e}, relative to the distance of answers from their mean \
             (see edgegait parity)"
        ));
    }
    problems
}

/// Returns the problems of a model on any runtime.
///
/// # Errors
/// If it runs on no runtime.
fn problems_of(tried: &[Tried]) -> Result<Vec<String>> {
    if tried.iter().all(|run| run.checkup.is_none()) {
        let errors = tried.iter().filter_map(|run| run.error.clone());
        return Err(Error::Failed(errors.collect::<Vec<_>>().join("\n")));
    }
    let of = |one: &Tried| {
        let problems = one.checkup.iter().flat_map(|checkup| &checkup.problems);
        problems
            .map(|problem| format!("{}: {problem}", one.runtime))
            .collect::<Vec<_>>()
    };
    let mut problems: Vec<String> = tried.iter().flat_map(of).collect();
    let refused = tried.iter().filter(|run| !run.lacks_library);
    problems.extend(refused.filter_map(|refusal| {
        let error = refusal.error.as_ref()?;
        Some(format!("{}: {error}", refusal.runtime))
    }));
    Ok(problems)
}

impl FromTheSide {
    /// Returns a possible reason for a low rank-1.
    fn doubt(&self) -> Option<String> {
        let chance = 1.0 / self.people.max(1) as f64;
        let is_poor = self.rank1 < (2.0 * chance).max(0.75 * self.pixels_rank1.unwrap_or(0.5));
        is_poor.then(|| {
            format!(
                "rank-1 is {} %, but {}: do its input range, framing, distance and outputs match its \
                 training?",
                percent(self.rank1),
                match self.pixels_rank1 {
                    Some(rank1) => format!("comparing pixels gives {} %", percent(rank1)),
                    None => format!("chance is {} %", percent(chance)),
                }
            )
        })
    }
}

/// Returns whether probes are compared with the gallery at other viewpoints, which is the purpose
/// of a model that takes viewpoints. The model has to be trained on several.
fn is_across(contract: &Contract) -> bool {
    contract.view_input.is_some() && contract.training.viewpoints.len() != 1
}

/// Returns the viewpoints of the probes: for a model that takes viewpoints, the ones of its
/// training that are nearest to the side.
fn views(contract: &Contract) -> Result<Views> {
    if contract.view_input.is_none() || contract.training.viewpoints.is_empty() {
        return Views::grid("60, 90 and 120 degrees", SIDES_DEG, [0.0]);
    }
    let nearest = contract.usual_views().into_iter().take(SIDES_DEG.len());
    let views = nearest.map(|angles| View::at(angles.into()));
    Ok(Views {
        name: "the viewpoints of its training nearest to the side".into(),
        list: views.collect::<Result<_>>()?,
    })
}

/// Measures rank-1 of all people of the scene, enrolled from the side.
fn from_the_side(entrant: Entrant, scene: &DrawnInputs<'_>, seed: u64) -> Result<FromTheSide> {
    let template = entrant.recognizer.contract().template;
    let mut entrants = vec![entrant];
    if template != Template::Silhouettes {
        entrants.push(Entrant::pixels(None, entrants[0].form().settings));
    }
    // The model's classes are usually other people, so everybody is enrolled.
    let protocol = Protocol::named(if is_across(entrants[0].recognizer.contract()) {
        "cross-view"
    } else {
        "first-take"
    })?;
    let options = ContestOptions {
        views: Some(scene.views.clone()),
        protocol: Some(protocol),
        ..ContestOptions::default()
    };
    let drawn = DrawnContest::new(scene.pack, scene.walks, &entrants, options)?;
    let outcome = drawn
        .contest
        .run(&entrants, seed, &mut |_| Ok(()), &mut |_| Ok(()))?;
    let first = outcome.results.first();
    let first = first.ok_or(Error::Missing("the result of a recognizer"))?;
    Ok(FromTheSide {
        seen_from: scene.views.name.clone(),
        people: first.people,
        probes: first.probes,
        rank1: first.rank1,
        pixels_rank1: outcome.results.get(1).map(|pixels| pixels.rank1),
    })
}

fn say(args: &CheckArgs, model: &Model, results: &CheckResults<'_>) {
    let contract = model.contract();
    let graph = model.graph();
    let say = |text: String| args.common.say(text);
    say(format!(
        "{}: takes {}; gives {}",
        args.model.display(),
        list_of(&graph.inputs),
        list_of(&graph.outputs)
    ));
    let from = if shipped::is_name(&args.model) {
        "as shipped".to_owned()
    } else if results.guessed {
        "guessed from its shape".to_owned()
    } else {
        format!("from {}", Contract::path_beside(&args.model).display())
    };
    let list = |numbers: &[f32]| {
        let all: Vec<String> = numbers.iter().map(ToString::to_string).collect();
        all.join(", ")
    };
    let mut shifted = String::new();
    for (what, numbers) in [("minus", &contract.mean), ("divided by", &contract.std)] {
        if !numbers.is_empty() {
            shifted += &format!(" {what} {}", list(numbers));
        }
    }
    let used = model.stated_contract().outputs;
    say(format!(
        "contract {from}: {}, input range {}{shifted}, framing {}, {} distance; embedding {:?}{}; \
         {} parameters",
        contract.given(),
        contract.input_range.name(),
        contract.framing.name(),
        contract.distance.name(),
        used.embedding.unwrap_or_default(),
        used.scores
            .map_or(String::new(), |scores| format!(", class scores {scores:?}")),
        results.parameters
    ));
    for one in &results.tried {
        say(match (&one.checkup, &one.error) {
            (Some(found), _) => format!(
                "{}: {} inputs, {:.3} ms each; embeddings of {} numbers{}{}",
                found.runtime,
                found.inputs,
                found.ms,
                found.embedding_dims,
                match found.embedding_parts {
                    1 => String::new(),
                    parts => format!(" in {parts} parts"),
                },
                match found.classes {
                    0 => String::new(),
                    classes => format!(", {classes} class scores"),
                }
            ),
            (None, Some(error)) => format!("{}: {error}", one.runtime),
            (None, None) => format!("{}: not tried", one.runtime),
        });
    }
    if let Some(apart) = results.runtimes_apart {
        say(format!(
            "the runtimes' answers differ by {apart:.1e}, relative to the distance of answers from their mean"
        ));
    }
    if let Some(found) = &results.from_the_side {
        let pixels = found.pixels_rank1;
        let pixels = pixels.map_or(String::new(), |rank1| {
            format!("; {PIXELS} {} %", percent(rank1))
        });
        say(format!(
            "rank-1 of people enrolled from {}, seen from {}: {} % of {} probes of {} people{pixels}",
            if is_across(contract) {
                "each other viewpoint"
            } else {
                "the side"
            },
            found.seen_from,
            percent(found.rank1),
            found.probes,
            found.people
        ));
    }
    args.common.say_warnings(&results.header.warnings);
    for problem in &results.problems {
        say(format!("problem: {problem}"));
    }
    if results.problems.is_empty() {
        say("no problems found".into());
    }
}
