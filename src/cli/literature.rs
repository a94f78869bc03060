//! `edgegait literature`: compares recognizers from the literature.

use super::args::{Common, FileArgs};
use super::progress::Progress;
use super::subspaces::SubspaceArgs;
use super::tree_cycles::CuttingArgs;
use crate::dataset::TreeLayout;
use crate::dataset::sequences::{Recordings, SequenceSource};
use crate::draw::sweep::{View, Views};
use crate::error::{Error, Result};
use crate::evaluate::contest::Entrant;
use crate::evaluate::literature::{
    COLUMNS, CONTESTS, ConfounderClass, ContestPlan, FITTED, Garments, JudgedRecognizer,
    LiteratureRow, PublishedRecognizer, judge, judge_recorded,
};
use crate::files::ResultHeader;
use crate::people::cohort::SPEEDS_KMH;
use crate::report::{garments_table, literature_table};
use edgegait_core::pack::Pack;
use serde::Serialize;
use std::path::{Path, PathBuf};

/// The number of the first training person; the built-in cohort has lower numbers.
const FIRST_TRAINED: usize = 1000;
/// The maximum number of viewpoints of which each pair is transformed.
const MAX_VIEWS: usize = 64;
/// Defaults of the numbers of tested people and of probe cycles of each condition.
const USUAL_PEOPLE: u16 = 26;
const USUAL_CYCLES: u32 = 2;

/// Evaluate recognizers from the literature by class of confounder: view, speed, clothes, carrying,
/// occlusion, segmentation
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  edgegait literature                  # 26 people, trained on 26 others\n  edgegait literature --people 100 --training-people 100 --json literature.json\n  edgegait literature tree --fps 30    # recorded people: other cycles, other viewpoints"
)]
pub(super) struct LiteratureArgs {
    /// A tree of silhouettes (<person>/<take>/<view>/) to test with, by gait cycle, instead of
    /// synthetic people
    #[arg(value_name = "TREE")]
    tree: Option<PathBuf>,
    #[command(flatten)]
    cutting: CuttingArgs,
    /// Synthetic people to test with; the built-in cohort comes first
    /// [default: 26]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(2..=500))]
    people: Option<u16>,
    /// Other synthetic people to train with
    #[arg(long, value_name = "N", default_value_t = 26, value_parser = clap::value_parser!(u16).range(2..=500))]
    training_people: u16,
    /// Probe cycles of each condition
    /// [default: 2]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100))]
    cycles: Option<u32>,
    #[command(flatten)]
    subspaces: SubspaceArgs,
    #[command(flatten)]
    pub common: Common,
}

/// The results of the command.
#[derive(Serialize)]
struct LiteratureResults {
    #[serde(flatten)]
    header: ResultHeader,
    #[serde(skip_serializing_if = "<[ConfounderClass]>::is_empty")]
    classes: &'static [ConfounderClass],
    recognizers: Vec<LiteratureRow>,
    garments: Garments,
}

impl LiteratureArgs {
    /// Returns the files that the command reads and writes.
    pub(super) fn files(&self) -> FileArgs {
        FileArgs {
            inputs: self.tree.iter().cloned().collect(),
            ..FileArgs::default()
        }
    }

    /// Rejects flags that do not apply.
    fn check(&self) -> Result<()> {
        let usage = |text: &str| Err(Error::Usage(text.into()));
        let [fps, whole] = self.cutting.given();
        if whole.1 {
            return usage("--whole-recordings: the probes are gait cycles");
        }
        if self.tree.is_none() && fps.1 {
            return usage("--fps applies to a tree's recordings: no tree is given");
        }
        if self.tree.is_some() && (self.people.is_some() || self.cycles.is_some()) {
            return usage("--people and --cycles apply to synthetic people: a tree has its own");
        }
        Ok(())
    }
}

/// Runs the subcommand.
pub(super) fn run(args: &LiteratureArgs) -> Result<()> {
    args.check()?;
    let (people, training) = (
        usize::from(args.people.unwrap_or(USUAL_PEOPLE)),
        usize::from(args.training_people),
    );
    let seed = args.common.seed;
    let subspaces = args.subspaces.subspaces(seed);
    let mut header = ResultHeader::new("literature", seed)
        .with("training_people", training)
        .with("subspaces", subspaces.classifiers)
        .with("eigenvectors", subspaces.eigenvectors)
        .with("discriminants", subspaces.discriminants);
    let recorded = match &args.tree {
        Some(path) => Some(recordings(path, &args.cutting, &mut header, &args.common)?),
        None => {
            header = header.with("people", people);
            None
        }
    };
    let plan = ContestPlan {
        training: FIRST_TRAINED..FIRST_TRAINED + training,
        people: 0..people,
        cycles: args.cycles.unwrap_or(USUAL_CYCLES),
        seed,
    };
    let drawn = if recorded.is_some() { 0 } else { people };
    let progress = Progress::new(
        &args.common,
        ("making", "walks"),
        (drawn + training) * SPEEDS_KMH.len(),
    );
    let step = || progress.step();
    let trained = plan.pack(&plan.training, &step)?;
    let looked_for = match recorded {
        Some(_) => Vec::new(),
        None => plan.pack(&plan.people, &step)?,
    };
    drop(progress);

    let seen_from = recorded.as_ref().map(|(_, views)| views.clone());
    let progress = Progress::new(&args.common, ("fitting", "recognizers"), FITTED);
    let trained = Pack::parse(&trained)?;
    let step = || progress.step();
    let (known, garments) = PublishedRecognizer::all(&trained, seen_from, subspaces, seed, &step)?;
    drop(progress);
    let (entrants, publications): (Vec<Entrant>, Vec<&'static str>) = { known.into_iter() }
        .map(|publication| (publication.entrant, publication.publication))
        .unzip();
    let (judged, people): (Vec<JudgedRecognizer>, usize) = match recorded {
        Some((recordings, _)) => {
            let people = recordings.people();
            let (judged, warnings) = judge_recorded(recordings, &entrants, seed)?;
            header.warnings.extend(warnings);
            (judged, people)
        }
        None => {
            header = header.with("cycles", plan.cycles);
            let progress = Progress::new(
                &args.common,
                ("recognizing people in", "contests"),
                CONTESTS,
            );
            let pack = Pack::parse(&looked_for)?;
            let judged = judge(&pack, &entrants, &plan, &|| progress.step())?;
            (judged, people)
        }
    };
    let rows = entrants.iter().zip(publications).zip(judged);
    let recognizers: Vec<LiteratureRow> = rows
        .map(|((entrant, publication), judged)| {
            LiteratureRow::from_entrant(entrant, publication, judged)
        })
        .collect();
    args.common
        .say(literature_table(&recognizers, people, |row| {
            &row.judged.cells
        }));
    if args.tree.is_some() {
        args.common.say("normal: other cycles, including those of the same recording, from the same viewpoint\nview: other cycles, from each other viewpoint");
    } else {
        for column in &COLUMNS {
            args.common
                .say(format_args!("{}: {}", column.name, column.what));
        }
        args.common
            .say("\nconfigurations of TUM-IITKGP, without colour and depth");
        args.common
            .say(literature_table(&recognizers, people, |row| {
                &row.judged.configurations
            }));
        args.common.say(garments_table(&garments));
    }
    args.common.say_warnings(&header.warnings);
    args.common.write_json(&LiteratureResults {
        header,
        classes: if args.tree.is_some() { &[] } else { &COLUMNS },
        recognizers,
        garments,
    })
}

/// Reads the gait cycles of a tree, and the viewpoints.
///
/// # Errors
/// If it is not a tree of silhouettes, if the angles of a view are unknown, or if it cannot be
/// read.
fn recordings(
    path: &Path,
    cutting: &CuttingArgs,
    header: &mut ResultHeader,
    common: &Common,
) -> Result<(Recordings, Views)> {
    let SequenceSource::Tree(tree) = SequenceSource::open(path, &[], &TreeLayout::default())?
    else {
        return Err(Error::input(
            path,
            "expected a tree of silhouettes (<person>/<take>/<view>/), found a dataset of templates",
        ));
    };
    *header = header.clone().with("tree", path.display().to_string());
    header.warnings.extend(tree.doubts());
    let progress = Progress::new(common, ("reading", "folders"), tree.len());
    tree.check_sizes(&[], &|| progress.step())?;
    drop(progress);
    let cut = cutting.cut(*tree, header, common)?.by_cycle();
    if cut.people() < 2 || !cut.has_others() {
        return Err(Error::input(
            path,
            format!(
                "expected at least 2 people, one of them with more than two gait cycles (one for the gallery, another as a probe), found {} people",
                cut.people()
            ),
        ));
    }
    let angles = cut.viewpoints().ok_or_else(|| {
        Error::input(
            path,
            "expected views named by their angles (090), found names of cameras: a view transformation needs the viewpoints",
        )
    })?;
    let list: Vec<View> = angles.into_iter().map(View::at).collect::<Result<_>>()?;
    if !(2..=MAX_VIEWS).contains(&list.len()) {
        return Err(Error::input(
            path,
            format!("expected 2 to {MAX_VIEWS} viewpoints, found {}", list.len()),
        ));
    }
    let name = path.display().to_string();
    Ok((cut, Views { name, list }))
}
