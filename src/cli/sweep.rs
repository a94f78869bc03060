//! `edgegait sweep`: walks by viewpoints, as a dataset.

use super::args::{Common, ViewArgs, gei_rmse, stated_choice};
use super::drawing::{DrawArgs, stated};
use super::progress::Progress;
use super::source::SourceArgs;
pub use crate::bench::peak_rss_bytes;
use crate::dataset::{DatasetWriter, Existing, Header, IndexRow};
use crate::error::{Error, Result};
use crate::frontier::choose;
use crate::sweep::{jobs, sweep};
use edgegait_core::pack::Pack;
use serde::Serialize;
use std::path::PathBuf;
use std::time::Instant;

/// Sweep walks over viewpoints into a dataset of GEIs
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  edgegait sweep --out dataset                 # 26 people at 5 km/h, 703 viewpoints\n  edgegait sweep cohort.egp --views side --cycles 8 --out side --json -"
)]
pub struct Args {
    #[command(flatten)]
    source: SourceArgs,
    /// Folder to write (geis.npy, index.csv, manifest.json)
    #[arg(long, value_name = "PATH", default_value = "dataset")]
    out: PathBuf,
    /// Replace the dataset in that folder
    #[arg(long)]
    overwrite: bool,
    /// Cycles of each walk: the stored one, then seeded variations of it
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=1000))]
    cycles: u32,
    /// First cycle: 0 is the stored one; `train` uses 0 to 7, `score` 1000 and up
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = clap::value_parser!(u32).range(0..=1_000_000))]
    first_cycle: u32,
    #[command(flatten)]
    views: ViewArgs,
    #[command(flatten)]
    draw: DrawArgs,
    /// Choose the fastest rasteriser, jitter and frames per cycle whose GEIs are this close to exact
    /// coverage, root mean square of 255, on a sample of these walks and viewpoints
    #[arg(long, value_name = "X", value_parser = gei_rmse, conflicts_with_all = ["raster", "jitter", "frames_per_cycle"])]
    max_gei_rmse: Option<f64>,
    #[command(flatten)]
    pub common: Common,
}

/// The results of a sweep.
#[derive(Serialize)]
struct Results {
    #[serde(flatten)]
    header: Header,
    silhouettes: u64,
    geis: u64,
    seconds: f64,
    silhouettes_per_second: f64,
    threads: usize,
    raster: &'static str,
    framing: &'static str,
    peak_rss_bytes: Option<u64>,
    clipped_share: f64,
}

/// Runs the subcommand.
pub fn run(args: &Args) -> Result<()> {
    let views = args.views.views("paper")?;
    let mut settings = args.draw.settings(args.common.seed)?;
    let source = args.source.load()?;
    let pack = Pack::parse(&source.bytes).map_err(|error| Error::Failed(error.to_string()))?;
    let walks = args.source.choose(&pack)?;
    let last = args.first_cycle + args.cycles;
    let jobs = jobs(&pack, &walks, args.first_cycle..last)?;
    let choice = match args.max_gei_rmse {
        Some(most) => {
            let choice = choose::drawing(&pack, (&walks, &views.list), settings, most)?;
            args.common.say(format_args!("chosen: {choice}"));
            settings = choice.chosen.applied_to(settings);
            Some(choice)
        }
        None => None,
    };
    let existing = if args.overwrite {
        Existing::Replace
    } else {
        Existing::Refuse
    };
    let geis = jobs.len() * views.list.len();
    let mut writer = DatasetWriter::create(&args.out, settings.size, geis, existing)?;
    let mut clipped = 0.0;
    let walk_list: Vec<_> = pack.walks().collect();
    let subjects: Vec<_> = pack.subjects().collect();
    let started = Instant::now();
    {
        let progress = Progress::new("cycles", jobs.len());
        sweep(
            &pack,
            &jobs,
            &views.list,
            settings,
            |_, swept| {
                progress.step();
                Ok(swept)
            },
            |job, swept| {
                clipped += swept.clipped;
                let walk = walk_list[job.walk];
                for (view, gei) in views.list.iter().zip(&swept.geis) {
                    writer.push(
                        gei.pixels(),
                        &IndexRow {
                            subject: subjects[walk.subject].name.into(),
                            walk: walk.name.into(),
                            cycle: u32::from(walk.cycle) * last + job.cycle,
                            speed_kmh: kmh(walk.speed_mm_per_s),
                            azimuth_deg: f64::from(view.azimuth_deg),
                            elevation_deg: f64::from(view.elevation_deg),
                            condition: "normal".into(),
                            frames: settings.frames_per_cycle,
                            seed: settings.seed,
                        },
                    )?;
                }
                Ok(())
            },
        )?;
    }
    let seconds = started.elapsed().as_secs_f64();
    let silhouettes = geis as u64 * u64::from(settings.frames_per_cycle);
    let mut header = stated(Header::new("sweep", args.common.seed), &settings)
        .with("pack", source.name.as_str())
        .with("views", views.name.as_str())
        .with("viewpoints", views.list.len())
        .with("walks", walks.len())
        .with("first_cycle", args.first_cycle)
        .with("cycles", args.cycles);
    if let Some(choice) = &choice {
        header = stated_choice(header, args.max_gei_rmse, choice);
    }
    header.inputs = source.inputs;
    writer.finish(header.clone())?;
    let results = Results {
        header,
        silhouettes,
        geis: geis as u64,
        seconds,
        silhouettes_per_second: silhouettes as f64 / seconds,
        threads: rayon::current_num_threads(),
        raster: settings.rasterizer.name(),
        framing: settings.framing.name(),
        peak_rss_bytes: peak_rss_bytes(),
        clipped_share: clipped / silhouettes as f64,
    };
    args.common.say(format_args!(
        "wrote {}: {} GEIs of {} silhouettes in {:.1} s, {:.0} silhouettes a second on {} threads; {:.2} % of the figures lay outside of the image",
        args.out.display(),
        results.geis,
        results.silhouettes,
        results.seconds,
        results.silhouettes_per_second,
        results.threads,
        100.0 * results.clipped_share
    ));
    args.common.write_json(&results)
}

/// A speed in km/h, to 0.01, from mm/s.
pub fn kmh(speed_mm_per_s: u16) -> f64 {
    (f64::from(speed_mm_per_s) * 0.36).round() * 0.01
}
