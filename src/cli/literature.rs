//! `edgegait literature`: recognizers of the literature beside each other.

use super::args::{Common, Files};
use super::progress::Progress;
use super::subspaces::SubspaceArgs;
use crate::dataset::Header;
use crate::error::Result;
use crate::literature::{COLUMNS, Column, Known, Plan, Row, run as judged, steps};
use crate::report::literature_table;
use crate::scene::cohort::SPEEDS_KMH;
use edgegait_core::pack::Pack;
use rayon::prelude::*;
use serde::Serialize;

/// The number of the first person whom recognizers learn from, so that nobody of the built-in cohort is
/// among them.
const FIRST_TRAINED: usize = 1000;

/// Judge recognizers of the literature by class of confounder: view, speed, clothes, carrying,
/// occlusion, segmentation
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  edgegait literature                  # 26 people, trained on 26 others\n  edgegait literature --people 100 --training-people 100 --json literature.json"
)]
pub(super) struct Args {
    /// People who are looked for among each other, the built-in cohort first
    #[arg(long, value_name = "N", default_value_t = 26, value_parser = clap::value_parser!(u16).range(2..=500))]
    people: u16,
    /// Other people, whom recognizers learn from
    #[arg(long, value_name = "N", default_value_t = 26, value_parser = clap::value_parser!(u16).range(2..=500))]
    training_people: u16,
    /// Cycles of each condition that are looked for
    #[arg(long, value_name = "N", default_value_t = 2, value_parser = clap::value_parser!(u32).range(1..=100))]
    cycles: u32,
    #[command(flatten)]
    subspaces: SubspaceArgs,
    #[command(flatten)]
    pub common: Common,
}

/// The results.
#[derive(Serialize)]
struct Results {
    #[serde(flatten)]
    header: Header,
    classes: &'static [Column],
    recognizers: Vec<Row>,
}

impl Args {
    /// What it reads and writes.
    pub(super) fn files(&self) -> Files {
        Files::default()
    }
}

/// Runs the subcommand.
pub(super) fn run(args: &Args) -> Result<()> {
    let (people, training) = (usize::from(args.people), usize::from(args.training_people));
    let seed = args.common.seed;
    let plan = Plan {
        training: FIRST_TRAINED..FIRST_TRAINED + training,
        people: 0..people,
        cycles: args.cycles,
        seed,
    };
    let subspaces = args.subspaces.subspaces(seed);
    let progress = Progress::new("walks", (people + training) * SPEEDS_KMH.len());
    let step = || progress.step();
    let trained = plan.pack(&plan.training, &step)?;
    let looked_for = plan.pack(&plan.people, &step)?;
    drop(progress);
    let progress = Progress::new("contests", steps());
    let step = || progress.step();
    let known = Known::all(&Pack::parse(&trained)?, (subspaces, seed), &step)?;
    let pack = Pack::parse(&looked_for)?;
    let row = |one: &Known| -> Result<Row> { Ok(Row::of(one, judged(&pack, one, &plan, &step)?)) };
    let recognizers: Vec<Row> = known.par_iter().map(row).collect::<Result<_>>()?;
    drop(progress);
    let header = Header::new("literature", seed)
        .with("people", people)
        .with("training_people", training)
        .with("cycles", args.cycles)
        .with("subspaces", subspaces.classifiers)
        .with("eigenvectors", subspaces.eigenvectors)
        .with("discriminants", subspaces.discriminants);
    args.common.say(literature_table(&recognizers, people));
    for column in &COLUMNS {
        args.common
            .say(format_args!("{}: {}", column.name, column.what));
    }
    args.common.write_json(&Results {
        header,
        classes: &COLUMNS,
        recognizers,
    })
}
