//! `edgegait sweep`: walks by viewpoints, as a dataset.

use super::args::{Common, Files, ViewArgs, gei_rmse, stated_choice};
use super::augment::AugmentArgs;
use super::conditions::{ConditionArgs, listing};
use super::drawing::DrawArgs;
use super::outputs::{Kind, Output};
use super::progress::Progress;
use super::source::SourceArgs;
pub(super) use crate::bench::peak_rss_bytes;
use crate::dataset::{DatasetWriter, Existing, Header, IndexRow, hex};
use crate::error::{Error, Result};
use crate::frontier::choose;
use crate::sweep::{Job, Settings, Swept, View, drawn, jobs, sweep};
use crate::template::Template;
use crate::template::augment::{Variant, varied};
use edgegait_core::pack::Pack;
use serde::Serialize;
use sha2::{Digest as _, Sha256};
use std::ops::Range;
use std::path::PathBuf;
use std::time::Instant;

/// Sweep walks over viewpoints into a dataset of GEIs or other templates
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  edgegait sweep --out dataset                 # 26 people at 5 km/h, 703 viewpoints\n  edgegait sweep cohort.egp --views side --cycles 8 --out side --json -\n  edgegait sweep --views side --template mhi --augment flip,crop --out mhi\n  edgegait sweep cohort.egp --cycles 250 --raster columns --framing cycle --digest"
)]
pub(super) struct Args {
    #[command(flatten)]
    source: SourceArgs,
    /// Folder to write (geis.npy or, of another template, NAME.npy; index.csv, manifest.json)
    #[arg(long, value_name = "PATH", default_value = "dataset")]
    out: PathBuf,
    /// Store nothing, and print one hash of all templates: SHA-256 of the SHA-256 of each cycle's,
    /// in the order of a dataset
    #[arg(long, conflicts_with = "out")]
    digest: bool,
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

/// Cycles that are listed at once: enough for all cores, and a list of 48 kB.
const CYCLES_AT_ONCE: usize = 2_048;

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
    #[serde(skip_serializing_if = "Option::is_none")]
    digest: Option<String>,
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
            outputs: if self.digest {
                Vec::new()
            } else {
                vec![Output::new("--out", &self.out, Kind::Dataset)]
            },
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
    let cycles = args.first_cycle..args.first_cycle + args.cycles;
    let firsts = jobs(&pack, &walks, cycles.start..cycles.start + 1)?;
    let firsts = Job::under(&firsts, &conditions);
    let choice = match args.max_gei_rmse {
        Some(most) => {
            let choice = choose::drawing(&pack, (&walks, &views.list), settings, most)?;
            args.common.say(format_args!("chosen: {choice}"));
            settings = choice.chosen.applied_to(settings);
            Some(choice)
        }
        None => None,
    };
    let work = Work {
        pack: &pack,
        firsts: &firsts,
        variations: cycles,
        views: &views.list,
        settings,
        variants: &variants,
    };
    let drawn = work.cycles() * views.list.len();
    let geis = drawn * variants.len();
    let existing = Existing::of(args.common.overwrite);
    let create = || DatasetWriter::create(&args.out, (template, size), geis, existing);
    let mut writer = (!args.digest).then(create).transpose()?;
    let started = Instant::now();
    let (clipped, digest) = match &mut writer {
        Some(writer) => (work.store(writer)?, None),
        None => work
            .digest()
            .map(|(clipped, digest)| (clipped, Some(digest)))?,
    };
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
    if let Some(writer) = writer {
        writer.finish(header.clone())?;
    }
    let made = match &digest {
        Some(digest) => format!("sha256 {digest}"),
        None => format!("wrote {}", args.out.display()),
    };
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
        digest,
    };
    args.common.say(format_args!(
        "{made}: {} {} of {} silhouettes in {:.1} s, {:.0} silhouettes a second on {} threads; {:.2} % of the figures lay outside of the image",
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

/// What is swept.
struct Work<'w> {
    pack: &'w Pack<'w>,
    /// The first cycle of each walk under each condition.
    firsts: &'w [Job<'w>],
    /// Which cycles of each.
    variations: Range<u32>,
    views: &'w [View],
    settings: Settings,
    /// What is made of each image, first of all itself.
    variants: &'w [Variant],
}

impl<'w> Work<'w> {
    /// How many there are.
    fn cycles(&self) -> usize {
        self.firsts.len() * self.variations.len()
    }

    /// Sweeps all cycles, in the order of a dataset; memory does not grow with their number.
    fn each<R: Send>(
        &self,
        map: impl Fn(Swept) -> R + Sync,
        mut sink: impl FnMut(Job<'w>, R) -> Result<()>,
    ) -> Result<()> {
        let progress = Progress::new("cycles", self.cycles());
        let mut all = self.firsts.iter().flat_map(|&first| {
            let cycles = self.variations.clone();
            cycles.map(move |variation| Job { variation, ..first })
        });
        loop {
            let jobs: Vec<_> = all.by_ref().take(CYCLES_AT_ONCE).collect();
            if jobs.is_empty() {
                return Ok(());
            }
            let map = |_, swept| {
                progress.step();
                Ok(map(swept))
            };
            sweep(self.pack, &jobs, self.views, self.settings, map, &mut sink)?;
        }
    }

    /// Hashes all templates. Sum over all silhouettes of the share that lay outside of the image,
    /// and SHA-256 of the cycles' SHA-256: cycles are hashed where they are made, on all cores.
    fn digest(&self) -> Result<(f64, String)> {
        let (mut clipped, mut digest) = (0.0, Sha256::new());
        self.each(
            |swept| {
                let mut cycle = Sha256::new();
                for bytes in &swept.templates {
                    cycle.update(bytes);
                    for &variant in self.variants.iter().skip(1) {
                        cycle.update(varied(bytes, self.settings.size, variant));
                    }
                }
                (swept.clipped, cycle.finalize())
            },
            |_, (share, cycle)| {
                clipped += share;
                digest.update(cycle);
                Ok(())
            },
        )?;
        Ok((clipped, hex(&digest.finalize())))
    }

    /// Writes all templates. Sum over all silhouettes of the share that lay outside of the image.
    fn store(&self, writer: &mut DatasetWriter) -> Result<f64> {
        let walks: Vec<_> = self.pack.walks().collect();
        let subjects: Vec<_> = self.pack.subjects().collect();
        let settings = self.settings;
        let mut clipped = 0.0;
        self.each(
            |swept| swept,
            |job, swept| {
                clipped += swept.clipped;
                let walk = walks[job.walk];
                let subject = subjects[walk.subject].name;
                let alternative = drawn(self.pack, job, settings.seed)?;
                for (view, bytes) in self.views.iter().zip(&swept.templates) {
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
                    for &variant in self.variants.iter().skip(1) {
                        let row = IndexRow {
                            condition: variant.condition(&row.condition),
                            ..row.clone()
                        };
                        writer.push(&varied(bytes, settings.size, variant), &row)?;
                    }
                }
                Ok(())
            },
        )?;
        Ok(clipped)
    }
}

/// A speed in km/h, to 0.01, from mm/s.
pub(super) fn kmh(speed_mm_per_s: u16) -> f64 {
    (f64::from(speed_mm_per_s) * 0.36).round() / 100.0
}
