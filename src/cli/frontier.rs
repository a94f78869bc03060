//! `edgegait frontier`: measures speed against error.

use super::args::{Common, FileArgs};
use super::outputs::{Output, OutputKind};
use super::progress::Progress;
use crate::bench::frontier::{FrontierPeople, FrontierPoint, FrontierStudy, plot};
use crate::dataset::sequences::{PackSource, Selection};
use crate::draw::sweep::jobs;
use crate::encode::within_error::reference::REFERENCE_FRAMES;
use crate::error::Result;
use crate::files::text_table::Column::{Left, Right};
use crate::files::text_table::Table;
use crate::files::{ResultHeader, write_bytes};
use edgegait_core::pack::Pack;
use serde::Serialize;
use std::path::{Path, PathBuf};

/// Measure speed, bytes and error of every configuration, and mark the Pareto set
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  edgegait frontier                       # people of the built-in cohort, encoded in every way\n  edgegait frontier cmu.egp --json -      # a pack's walks as they are stored\n\nErrors are measured against exact coverage (16x16 samples a pixel, f64) of the finest motion: for the built-in people, their finest encoding with 128 frames a cycle; for a pack, its own motion. Rank-1 is measured with the shipped models on the built-in cohort. Times, and therefore the Pareto set, differ between runs; all other results are the same in every run."
)]
pub(super) struct FrontierArgs {
    /// A pack [default: people of the built-in cohort]
    #[arg(value_name = "PACK")]
    pack: Option<PathBuf>,
    /// Folder to write (frontier.json, frontier.csv and frontier.svg)
    #[arg(long, value_name = "PATH", default_value = "edgegait-frontier")]
    out: PathBuf,
    /// Measure roughly: two people, four viewpoints, one round
    #[arg(long)]
    quick: bool,
    #[command(flatten)]
    pub common: Common,
}

impl FrontierArgs {
    /// Returns the files that the command reads and writes.
    pub(super) fn files(&self) -> FileArgs {
        FileArgs {
            inputs: self.pack.iter().cloned().collect(),
            outputs: vec![Output::new("--out", &self.out, OutputKind::Frontier)],
        }
    }
}

/// The results of the command.
#[derive(Serialize)]
struct FrontierResults {
    #[serde(flatten)]
    header: ResultHeader,
    points: Vec<FrontierPoint>,
}

/// Runs the subcommand.
pub(super) fn run(args: &FrontierArgs) -> Result<()> {
    let source = match &args.pack {
        Some(path) => Some(read(path)?),
        None => None,
    };
    let scene = match &source {
        Some((source, walks)) => FrontierPeople::Pack {
            bytes: &source.bytes,
            walks,
        },
        None => FrontierPeople::BuiltIn,
    };
    let study = FrontierStudy {
        scene,
        seed: args.common.seed,
        is_quick: args.quick,
    };
    let views = study.views()?;
    let mut header = ResultHeader::new("frontier", args.common.seed)
        .with("quick", args.quick)
        .with("views", views.name)
        .with("viewpoints", views.list.len())
        .with("reference", "exact coverage, 16x16 samples a pixel, f64")
        .with("reference_frames_per_cycle", REFERENCE_FRAMES)
        .with("framing", "height")
        .with("size", "50x30");
    header.warnings.push(
        "times, and therefore the Pareto set, differ between runs; all other results are the same in every run".into(),
    );
    header = match &source {
        Some((source, walks)) => {
            header.inputs.clone_from(&source.inputs);
            header.warnings.push(
                "for a pack, the reference is its own motion, track error and hull points are as stored, and rank-1 is that of the built-in cohort".into(),
            );
            header
                .with("pack", source.name.as_str())
                .with("walks", walks.len())
        }
        None => header.with("pack", "built-in cohort"),
    };
    let progress = Progress::new(&args.common, ("measuring", "steps"), study.steps());
    let points = study.run(&|| progress.step())?;
    drop(progress);
    let results = FrontierResults { header, points };
    args.common.say(table(&results.points));
    args.common.say_warnings(&results.header.warnings);
    let json = serde_json::to_string_pretty(&results)?;
    for (name, bytes) in [
        ("frontier.json", format!("{json}\n").into_bytes()),
        ("frontier.csv", csv(&results.points)?),
        ("frontier.svg", plot::svg(&results.points).into_bytes()),
    ] {
        write_bytes(args.out.join(name), &bytes)?;
    }
    args.common.say(format_args!(
        "wrote {}: frontier.json, frontier.csv, frontier.svg",
        args.out.display()
    ));
    args.common.write_json(&results)
}

/// Reads a pack, and returns it with the numbers of its walks, which have to be cycles.
fn read(path: &Path) -> Result<(PackSource, Vec<usize>)> {
    let source = PackSource::read(path)?;
    let pack = Pack::parse(&source.bytes)?;
    let walks = Selection::default().selected_walks(&pack)?;
    jobs(&pack, &walks, 0..1)?;
    Ok((source, walks))
}

/// Formats points as CSV, one row each.
fn csv(points: &[FrontierPoint]) -> Result<Vec<u8>> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record([
        "name",
        "raster",
        "jitter",
        "hull_points",
        "frames_per_cycle",
        "track_error_mm",
        "ns_per_silhouette",
        "ns_per_gei",
        "time_ratio",
        "jaccard",
        "gei_rmse",
        "rank1_delta",
        "pack_bytes",
        "heap_bytes",
        "stack_bytes",
        "is_default",
        "pareto",
    ])?;
    for point in points {
        writer.write_record([
            point.name.clone(),
            point.raster.to_owned(),
            point.jitter.to_owned(),
            point.hull_points.to_string(),
            point.frames_per_cycle.to_string(),
            point.track_error_mm.to_string(),
            point.ns_per_silhouette.to_string(),
            point.ns_per_gei.to_string(),
            point.time_ratio.to_string(),
            point.jaccard.to_string(),
            point.gei_rmse.to_string(),
            point.rank1_delta.to_string(),
            point.pack_bytes.to_string(),
            point.heap_bytes.to_string(),
            point.stack_bytes.to_string(),
            point.is_default.to_string(),
            point.pareto.to_string(),
        ])?;
    }
    Ok(writer
        .into_inner()
        .map_err(|error| csv::Error::from(error.into_error()))?)
}

/// Formats points as a table for a terminal; `*` marks the Pareto set.
fn table(points: &[FrontierPoint]) -> String {
    let mut table = Table::new(&[Left(0), Right(8)]);
    table.row("|ns|us/GEI|x default|Jaccard|GEI RMSE|rank-1 %|pack B|heap B".split('|'));
    for (number, point) in (1..).zip(points) {
        let mark = if point.pareto { '*' } else { ' ' };
        table.row([
            format!("{number:>2}{mark}{}", point.name),
            format!("{:.0}", point.ns_per_silhouette),
            format!("{:.0}", 1e-3 * point.ns_per_gei),
            format!("{:.3}", point.time_ratio),
            format!("{:.4}", point.jaccard),
            format!("{:.2}", point.gei_rmse),
            format!("{:+.1}", 100.0 * point.rank1_delta),
            point.pack_bytes.to_string(),
            point.heap_bytes.to_string(),
        ]);
    }
    format!(
        "{table}(*: no other is better in time of a GEI, bytes or error without being worse in another)"
    )
}
