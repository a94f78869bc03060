//! `edgegait sweep`: walks by viewpoints, as a dataset.

use super::args::{Common, Files, ViewArgs, gei_rmse, stated_choice};
use super::augment::AugmentArgs;
use super::conditions::{ConditionArgs, listing};
use super::drawing::DrawArgs;
use super::outputs::{Kind, Output};
use super::progress::Progress;
use super::source::SourceArgs;
pub(super) use crate::bench::peak_rss_bytes;
use crate::dataset::{DatasetWriter, Existing, Header, IndexRow};
use crate::error::{Error, Result};
use crate::frontier::choose;
use crate::sweep::{Job, alternative, jobs, sweep};
use crate::template::Template;
use crate::template::augment::varied;
use edgegait_core::pack::Pack;
use serde::Serialize;
use std::path::PathBuf;
use std::time::Instant;

/// Sweep walks over viewpoints into a dataset of GEIs or other templates
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  edgegait sweep --out dataset                 # 26 people at 5 km/h, 703 viewpoints\n  edgegait sweep cohort.egp --views side --cycles 8 --out side --json -\n  edgegait sweep --views side --template mhi --augment flip,crop --out mhi"
)]
pub(super) struct Args {
    #[command(flatten)]
    source: SourceArgs,
    /// Folder to write (geis.npy or, of another template, NAME.npy; index.csv, manifest.json)
    #[arg(long, value_name = "PATH", default_value = "dataset")]
    out: PathBuf,
    /// Cycles of each walk: the stored one, then seeded variations of it
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=1000))]
    cycles: u32,
    /// First cycle: 0 is the stored one; `train` uses 0 to 7, `score` 1000 and up
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = clap::value_parser!(u32).range(0..=1_000_000))]
    first_cycle: u32,
    #[command(flatten)]
    conditions: ConditionArgs,
    /// List all confounders and built-in conditions, and do nothing else
    #[arg(long, exclusive = true)]
    list_conditions: bool,
    #[command(flatten)]
    views: ViewArgs,
    #[command(flatten)]
    draw: DrawArgs,
    /// Choose the fastest rasteriser, jitter and frames per cycle whose GEIs are this close to exact
    /// coverage, root mean square of 255, on a sample of these walks and viewpoints
    #[arg(long, value_name = "X", value_parser = gei_rmse, conflicts_with_all = ["raster", "jitter", "frames_per_cycle"])]
    max_gei_rmse: Option<f64>,
    #[command(flatten)]
    augment: AugmentArgs,
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

impl Args {
    /// What it reads and writes.
    pub(super) fn files(&self) -> Files {
        if self.list_conditions {
            return Files::default();
        }
        let (pack, conditions) = (self.source.pack.clone(), self.conditions.file());
        let inputs = pack.into_iter().chain(conditions).chain(self.views.file());
        Files {
            inputs: inputs.collect(),
            outputs: vec![Output::new("--out", &self.out, Kind::Dataset)],
        }
    }
}

/// Runs the subcommand.
pub(super) fn run(args: &Args) -> Result<()> {
    if args.list_conditions {
        args.common.say(listing()?);
        return Ok(());
    }
    let mut header = Header::new("sweep", args.common.seed);
    let conditions = args.conditions.load(None, &mut header)?;
    let views = args.views.views("paper")?;
    let mut settings = args.draw.settings(args.common.seed)?;
    let (template, size) = (settings.template, settings.size);
    if template == Template::Silhouettes {
        return Err(Error::Usage(
            "--template silhouettes: a dataset holds one image of each cycle (`render --out x.npy` writes silhouettes)".into(),
        ));
    }
    if args.max_gei_rmse.is_some() && template != Template::Gei {
        return Err(Error::Usage(format!(
            "--max-gei-rmse is about GEIs, found --template {}",
            template.name()
        )));
    }
    let augmentation = args.augment.augmentation()?;
    augmentation.check(template, size)?;
    let variants = augmentation.variants();
    let source = args.source.load()?;
    let pack = Pack::parse(&source.bytes)?;
    let walks = args.source.choose(&pack)?;
    let last = args.first_cycle + args.cycles;
    let jobs = jobs(&pack, &walks, args.first_cycle..last)?;
    let jobs = Job::under(&jobs, &conditions);
    let choice = match args.max_gei_rmse {
        Some(most) => {
            let choice = choose::drawing(&pack, (&walks, &views.list), settings, most)?;
            args.common.say(format_args!("chosen: {choice}"));
            settings = choice.chosen.applied_to(settings);
            Some(choice)
        }
        None => None,
    };
    let existing = Existing::of(args.common.overwrite);
    let drawn = jobs.len() * views.list.len();
    let geis = drawn * variants.len();
    let mut writer = DatasetWriter::create(&args.out, (template, size), geis, existing)?;
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
                let subject = subjects[walk.subject].name;
                let alternative = alternative(job, subject, settings.seed);
                for (view, bytes) in views.list.iter().zip(&swept.templates) {
                    let row = IndexRow {
                        subject: subject.into(),
                        walk: walk.name.into(),
                        cycle: u32::from(walk.cycle),
                        variation: job.variation,
                        speed_kmh: kmh(walk.speed_mm_per_s),
                        azimuth_deg: f64::from(view.azimuth_deg),
                        elevation_deg: f64::from(view.elevation_deg),
                        condition: job.condition_name().into(),
                        alternative: alternative.clone(),
                        frames: settings.frames_per_cycle,
                        seed: settings.seed,
                    };
                    writer.push(bytes, &row)?;
                    for &variant in variants.iter().skip(1) {
                        let row = IndexRow {
                            condition: variant.condition(&row.condition),
                            ..row.clone()
                        };
                        writer.push(&varied(bytes, size, variant), &row)?;
                    }
                }
                Ok(())
            },
        )?;
    }
    let seconds = started.elapsed().as_secs_f64();
    let silhouettes = drawn as u64 * u64::from(settings.frames_per_cycle);
    let mut header = header
        .drawn(&settings)
        .with("pack", source.name.as_str())
        .with("views", views.name.as_str())
        .with("viewpoints", views.list.len())
        .with("walks", walks.len())
        .with("first_cycle", args.first_cycle)
        .with("cycles", args.cycles);
    if let Some(choice) = &choice {
        header = stated_choice(header, args.max_gei_rmse, choice);
    }
    header = header.augmented(augmentation);
    header.inputs.extend(source.inputs);
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
        "wrote {}: {} {} of {} silhouettes in {:.1} s, {:.0} silhouettes a second on {} threads; {:.2} % of the figures lay outside of the image",
        args.out.display(),
        results.geis,
        template.plural(),
        results.silhouettes,
        results.seconds,
        results.silhouettes_per_second,
        results.threads,
        100.0 * results.clipped_share
    ));
    args.common.write_json(&results)
}

/// A speed in km/h, to 0.01, from mm/s.
pub(super) fn kmh(speed_mm_per_s: u16) -> f64 {
    (f64::from(speed_mm_per_s) * 0.36).round() * 0.01
}
