//! `edgegait confounders`: the effect of each confounder on recognizers.

use super::args::{Common, FileArgs, ViewArgs};
use super::baselines::WantedBaselines;
use super::cache::CacheArgs;
use super::contest::InputSource;
use super::drawing::DrawArgs;
use super::outputs::{Output, OutputKind};
use super::progress::Progress;
use super::recognizers::{load, sort_inputs, with_contracts};
use super::render::has_extension;
use super::runtime::RuntimeArgs;
use super::walks::{SelectionArgs, SourceArgs};
use crate::draw::confounders::catalogue::{CATALOGUE, Confounder, named};
use crate::draw::sweep::Views;
use crate::error::{Error, Result};
use crate::evaluate::contest::{ContestOptions, DrawnContest};
use crate::evaluate::strengths::{ConfounderResult, StrengthStudy};
use crate::files::ResultHeader;
use crate::report::{strength_table, write_strengths};
use edgegait_core::pack::Pack;
use serde::Serialize;
use std::path::PathBuf;

/// Default number of probe cycles of each walk.
const CYCLES: u32 = 4;
/// Number of measurements of each cost; the least counts.
const ROUNDS: usize = 3;
/// Azimuths at which costs are measured, degrees; they share the work that is done once a walk.
const COST_AZIMUTHS_DEG: [f32; 10] = [
    0.0, 20.0, 40.0, 60.0, 80.0, 100.0, 120.0, 140.0, 160.0, 180.0,
];
/// Elevation of the camera, degrees; shadows are visible from it.
const ELEVATION_DEG: f32 = 10.0;

/// Measure the effect of each confounder on recognizers, by strength, and its cost
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  edgegait confounders                                 # all confounders, from azimuth 90, elevation 10\n  edgegait confounders pixels cohort.egp --only coat,backpack --views models/spread.csv --json -"
)]
pub(super) struct ConfoundersArgs {
    /// ONNX models or "pixels" (the pixel baseline), and a pack [default: the shipped models, the
    /// built-in cohort]
    #[arg(value_name = "MODEL|PACK")]
    inputs: Vec<PathBuf>,
    /// Only these confounders [default: all; `edgegait sweep --list-conditions` lists them]
    #[arg(long, value_name = "NAME[,NAME..]", value_delimiter = ',', value_parser = confounder)]
    only: Vec<&'static Confounder>,
    /// Strengths above 0; signed confounders are also measured at the negative strengths
    #[arg(long, value_name = "S[,S..]", value_delimiter = ',', default_value = "0.25,0.5,0.75,1", value_parser = strength)]
    strengths: Vec<f64>,
    #[command(flatten)]
    selection: SelectionArgs,
    /// Probe cycles of each walk, if they are seeded variations [default: 4]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1000))]
    cycles: Option<u32>,
    /// Where to write the chart of rank-1 against strength
    #[arg(long, value_name = "SVG", default_value = "edgegait-confounders.svg")]
    out: PathBuf,
    #[command(flatten)]
    runtime: RuntimeArgs,
    #[command(flatten)]
    cache: CacheArgs,
    #[command(flatten)]
    views: ViewArgs,
    #[command(flatten)]
    draw: DrawArgs,
    #[command(flatten)]
    pub common: Common,
}

/// Returns the confounder of this name.
fn confounder(name: &str) -> std::result::Result<&'static Confounder, String> {
    named(name).ok_or_else(|| {
        let names: Vec<&str> = CATALOGUE.iter().map(|known| known.name).collect();
        format!("expected one of {}", names.join(", "))
    })
}

/// Returns the first item that appears again later in the list.
fn repeated<T: PartialEq>(list: &[T]) -> Option<&T> {
    let twice = (1..list.len()).find(|&at| list[..at].contains(&list[at]));
    twice.map(|at| &list[at])
}

fn strength(text: &str) -> std::result::Result<f64, String> {
    match text.parse() {
        Ok(strength) if strength > 0.0 && strength <= 1.0 => Ok(strength),
        _ => Err("expected a strength above 0, at most 1".to_owned()),
    }
}

impl ConfoundersArgs {
    /// Returns the files that the command reads and writes.
    pub(super) fn files(&self) -> FileArgs {
        let inputs = with_contracts(&self.inputs).into_iter();
        FileArgs {
            inputs: inputs.chain(self.views.file()).collect(),
            outputs: vec![Output::new("--out", &self.out, OutputKind::Svg)],
        }
    }

    /// Checks flags before any work.
    fn check(&self) -> Result<()> {
        if !has_extension(&self.out, "svg") {
            return Err(Error::Usage(format!(
                "--out {}: expected a name that ends in .svg",
                self.out.display()
            )));
        }
        if let Some(twice) = repeated(&self.strengths) {
            return Err(Error::Usage(format!("--strengths: {twice} appears twice")));
        }
        if let Some(twice) = repeated(&self.only) {
            let name = twice.name;
            return Err(Error::Usage(format!("--only: {name} appears twice")));
        }
        Ok(())
    }

    /// Returns the confounders to study.
    fn chosen(&self) -> Vec<&'static Confounder> {
        if self.only.is_empty() {
            CATALOGUE.iter().collect()
        } else {
            self.only.clone()
        }
    }

    /// Prints the results and writes them.
    fn report(&self, results: &ConfoundersResults) -> Result<()> {
        let (confounders, classes) = (&results.confounders, results.classes);
        self.common
            .say(strength_table(confounders, classes, results.probes));
        self.common.say_warnings(&results.header.warnings);
        let written = write_strengths(&self.out, confounders, classes);
        if written.is_ok() {
            self.common
                .say(format_args!("wrote {}", self.out.display()));
        }
        self.common.write_json(results).and(written)
    }
}

/// The results of the command.
#[derive(Serialize)]
struct ConfoundersResults {
    #[serde(flatten)]
    header: ResultHeader,
    /// Number of people among whom each recognizer chooses.
    classes: usize,
    /// Number of probes of each recognizer at each strength.
    probes: u64,
    confounders: Vec<ConfounderResult>,
}

/// Runs the subcommand.
pub(super) fn run(args: &ConfoundersArgs) -> Result<()> {
    let seed = args.common.seed;
    args.check()?;
    let runtime = args.runtime.runtime()?;
    let (mut models, data) = sort_inputs(&args.inputs)?;
    let mut baselines = WantedBaselines::default();
    baselines.apart(&mut models, false);
    if let Some(folder) = data.as_ref().filter(|path| path.is_dir()) {
        return Err(Error::Usage(format!(
            "{}: expected a pack, found a folder, whose images cannot be drawn under other conditions",
            folder.display()
        )));
    }
    let mut header = ResultHeader::new("confounders", seed).with("runtime", runtime.name().name);
    let inputs = InputSource {
        draw: &args.draw,
        seed,
        stored: None,
    };
    let cache = args.cache.cache();
    let mut entrants = load(&models, &runtime, &cache, inputs, &mut header)?;
    let source_args = SourceArgs::new(data, args.selection.clone());
    let source = source_args.load(&args.common)?;
    let pack = Pack::parse(&source.bytes)?;
    let walks = source_args.choose(&pack)?;
    let views = if args.views.is_given() {
        args.views.views("side")?
    } else {
        Views::grid("side from above", [90.0], [ELEVATION_DEG])?
    };
    let around = Views::grid("around", COST_AZIMUTHS_DEG, [ELEVATION_DEG])?;
    let chosen = args.chosen();
    let study = StrengthStudy::new(&chosen, &args.strengths);
    let settings = entrants
        .first()
        .map(|entrant| entrant.settings)
        .ok_or_else(|| Error::Usage("expected a model".into()))?;

    let rounds = (1 + chosen.len()) * ROUNDS;
    let progress = Progress::new(
        &args.common,
        ("measuring", "costs and effects"),
        rounds + study.conditions().len(),
    );
    let step = || progress.step();
    let costs = study.costs(&pack, walks[0], &around.list, settings, ROUNDS, &step)?;
    let effects = study.effects(&pack, &walks, &views.list, settings, &step)?;
    drop(progress);
    let is_made = args.cycles.is_none() && DrawnContest::is_made(&pack, &walks, &entrants)?;
    let options = ContestOptions {
        protocol: None,
        cycles: args.cycles.or(is_made.then_some(CYCLES)),
        views: Some(views.clone()),
        conditions: study.conditions(),
    };
    let DrawnContest {
        contest,
        probes,
        warnings,
        ..
    } = DrawnContest::new(&pack, &walks, &entrants, options)?;
    baselines.add(&contest, &mut entrants, Some(&pack), &mut header)?;
    let sequences = contest.source().sequences().list.len();
    let progress = Progress::new(
        &args.common,
        ("recognizing", "sequences"),
        sequences * entrants.len(),
    );
    let outcome = contest.run(&entrants, seed, &mut |_| progress.step(), &mut |_| Ok(()))?;
    drop(progress);

    let mut header = header
        .drawn(&settings)
        .with("pack", source.name.as_str())
        .with("views", views.name.as_str())
        .with("viewpoints", views.list.len())
        .with("walks", walks.len())
        .with("protocol", contest.protocol().name.as_str())
        .with("probes", probes)
        .with("strengths", args.strengths.clone());
    header.inputs.extend(source.inputs);
    header.warnings.extend(warnings);
    header
        .warnings
        .extend(outcome.warnings.iter().map(ToString::to_string));
    if outcome.shown.empty > 0 {
        header.warnings.push(format!(
            "{} frames in which nothing is left of the figure were left out of templates",
            outcome.shown.empty
        ));
    }
    let confounders = study.results(&outcome.results, &effects, &costs)?;
    let first = outcome.results.first();
    let results = ConfoundersResults {
        classes: first.map_or(0, |result| result.classes),
        probes: first
            .and_then(|result| result.probe_sets.first())
            .map_or(0, |set| set.probes),
        header,
        confounders,
    };
    args.report(&results)
}
