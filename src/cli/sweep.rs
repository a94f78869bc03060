//! `edgegait sweep`: makes a dataset of walks seen from viewpoints, or of a tree's gait cycles.

mod tree;
mod work;

use super::args::{Common, FileArgs, ViewArgs, gei_rmse, stated_choice};
use super::augment::AugmentArgs;
use super::conditions::{ConditionArgs, listing};
use super::drawing::DrawArgs;
use super::export::{ExportArgs, sized, templates_of};
use super::layout::{LayoutArgs, refuse_without_tree};
use super::walks::SourceArgs;
pub(super) use crate::bench::peak_rss_bytes;
use crate::dataset::sequences::PackSource;
use crate::dataset::{Contents, DatasetFormat, DatasetRun, Items, PackItems, check_folder_name};
use crate::draw::confounders::Condition;
use crate::draw::sweep::{Job, Settings, UNCUT_FPS, Views, Wanted, is_uncut, walk_name};
use crate::draw::template::Template;
use crate::encode::within_error::choose;
use crate::error::{Error, Result};
use crate::files::ResultHeader;
use edgegait_core::pack::Pack;
use serde::Serialize;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::time::Instant;
use work::{SweepWork, grouped};

/// The default output.
const OUT: &str = "dataset";

/// Sweep walks over viewpoints, or a tree of silhouettes, into a dataset of GEIs or other templates
#[derive(Debug, clap::Args)]
#[command(
    mut_arg("pack", |arg| arg.value_name("PACK|TREE").help("A pack, or a tree of silhouettes (<person>/<take>/<view>/), which is cut into gait cycles [default: the built-in cohort of 26 people]")),
    after_help = "Examples:\n  edgegait sweep --out dataset                 # 26 people at 5 km/h, 703 viewpoints\n  edgegait sweep cohort.egp --views side --cycles 8 --out side --json -\n  edgegait sweep --views side --template mhi --augment flip,crop --out mhi\n  edgegait sweep --views side --template gei,silhouettes --joints --out sequences\n  edgegait sweep --views side --conditions casia-b --format opengait --out tree\n  edgegait sweep tree --fps 30 --out geis       # a template of each gait cycle of a tree\n  edgegait sweep --shard 1/3 --out one    # then: edgegait merge one two three --out whole\n  edgegait sweep cohort.egp --cycles 250 --raster columns --framing cycle --digest"
)]
pub(super) struct SweepArgs {
    #[command(flatten)]
    pub source: SourceArgs,
    /// Folder to write: geis.npy (NAME.npy for another template), index.csv and manifest.json;
    /// --format chooses another format
    #[arg(long, value_name = "PATH", default_value = OUT)]
    out: PathBuf,
    /// Store nothing, and print one hash of all templates: the SHA-256 of the SHA-256 hashes of all
    /// cycles, in the order of a dataset
    #[arg(long, conflicts_with_all = ["out", "format", "shard", "resume"])]
    digest: bool,
    /// Cycles of each walk: the stored one, then seeded variations of it
    /// [default: 1]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1000))]
    cycles: Option<u32>,
    /// First cycle: 0 is the stored one; `train` uses 0 to 7, `score` 1000 and up
    /// [default: 0]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(0..=1_000_000))]
    first_cycle: Option<u32>,
    #[command(flatten)]
    conditions: ConditionArgs,
    /// List all confounders and built-in conditions, and do nothing else
    #[arg(long, exclusive = true)]
    list_conditions: bool,
    #[command(flatten)]
    views: ViewArgs,
    #[command(flatten)]
    draw: DrawArgs,
    /// Choose the fastest rasteriser, jitter and frames per cycle whose GEIs differ by at most this
    /// root mean square (of 255) from exact coverage, on a sample of these walks and viewpoints
    #[arg(long, value_name = "X", value_parser = gei_rmse, conflicts_with_all = ["raster", "jitter", "frames_per_cycle", "resume", "shard", "fps"])]
    max_gei_rmse: Option<f64>,
    /// Also write the positions of 19 joints in space and in the image (joints.npy, keypoints.npy)
    #[arg(long, conflicts_with_all = ["digest", "augment"])]
    joints: bool,
    /// Frames a second, instead of --frames-per-cycle; uncut motions are swept from start to end.
    /// For a tree, the frame rate of its recordings, to find gait cycles
    /// [default for uncut motions and trees: 25]
    #[arg(long, value_name = "F", value_parser = fps, conflicts_with = "frames_per_cycle")]
    fps: Option<f64>,
    /// Make one template of each whole recording of a tree, not of each gait cycle
    #[arg(long, conflicts_with = "fps")]
    whole_recordings: bool,
    #[command(flatten)]
    layout: LayoutArgs,
    #[command(flatten)]
    export: ExportArgs,
    #[command(flatten)]
    augment: AugmentArgs,
    #[command(flatten)]
    pub common: Common,
}

/// The results of a sweep.
#[derive(Serialize)]
struct SweepResults {
    #[serde(flatten)]
    header: ResultHeader,
    silhouettes: u64,
    geis: u64,
    seconds: f64,
    silhouettes_per_second: f64,
    threads: usize,
    /// The rasteriser; none for a tree, which is not drawn.
    #[serde(skip_serializing_if = "Option::is_none")]
    raster: Option<&'static str>,
    framing: &'static str,
    peak_rss_bytes: Option<u64>,
    clipped_share: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    digest: Option<String>,
}

impl SweepArgs {
    /// Rejects flags that only apply to a tree of silhouettes.
    fn refuse_without_tree(&self) -> Result<()> {
        let flags = [("--whole-recordings", self.whole_recordings)].into_iter();
        refuse_without_tree(flags.chain(self.layout.given()))
    }

    /// Returns the files that the command reads and writes.
    pub(super) fn files(&self) -> FileArgs {
        if self.list_conditions {
            return FileArgs::default();
        }
        let (pack, conditions) = (self.source.pack.clone(), self.conditions.file());
        let inputs = pack.into_iter().chain(conditions).chain(self.views.file());
        FileArgs {
            inputs: inputs.collect(),
            outputs: if self.digest {
                Vec::new()
            } else {
                vec![self.export.output(&self.out)]
            },
        }
    }
}

/// A request to sweep a pack.
struct SweepRequest {
    header: ResultHeader,
    conditions: Vec<Condition>,
    views: Views,
    settings: Settings,
    wanted: Wanted,
    source: PackSource,
    walks: Vec<usize>,
}

impl SweepRequest {
    /// Reads all files that the flags name, and rejects walks that cannot be swept.
    fn from_args(args: &SweepArgs) -> Result<Self> {
        let mut header = ResultHeader::new("sweep", args.common.seed);
        let conditions = args.conditions.load(None, &mut header)?;
        let views = args.views.views("paper")?;
        let (settings, wanted) = args.wanted()?;
        let augmentation = args.augment.augmentation()?;
        for &template in &wanted.templates {
            augmentation.check(template, settings.size)?;
        }
        let source = args.source.load(&args.common)?;
        let pack = Pack::parse(&source.bytes)?;
        let walks = args.source.choose(&pack)?;
        let firsts = args.firsts(&walks);
        args.check_walks(&pack, &firsts, &settings, &wanted, views.list.len())?;
        Ok(Self {
            header,
            conditions,
            views,
            settings,
            wanted,
            source,
            walks,
        })
    }
}

/// Returns the items that would be stored.
///
/// # Errors
/// The same as [`run`], and for flags about storing.
pub(super) fn items(args: &SweepArgs) -> Result<Items> {
    let export = &args.export;
    let flags = [
        ("--out", args.out != Path::new(OUT)),
        ("--digest", args.digest),
        ("--max-gei-rmse", args.max_gei_rmse.is_some()),
        ("--augment", args.augment.is_given()),
        ("--format", export.format != DatasetFormat::Folder),
        ("--shard", export.shard.is_some()),
        ("--resume", export.resume),
        ("--list-conditions", args.list_conditions),
    ];
    if let Some((flag, _)) = flags.iter().find(|(_, is_given)| *is_given) {
        return Err(Error::Usage(format!("{flag}: nothing is stored here")));
    }
    if let Some(path) = args.source.pack.as_deref().filter(|path| path.is_dir()) {
        return Err(Error::input(path, "expected a pack, found a folder"));
    }
    args.refuse_without_tree()?;
    let SweepRequest {
        conditions,
        views,
        settings,
        wanted,
        source,
        walks,
        ..
    } = SweepRequest::from_args(args)?;
    let items = PackItems {
        bytes: source.bytes.into(),
        walks,
        conditions,
        variations: args.variations(),
        views: views.list,
    };
    Items::of_pack(items, settings, wanted)
}

/// Runs the subcommand.
pub(super) fn run(args: &SweepArgs) -> Result<()> {
    if args.list_conditions {
        args.common.say(listing()?);
        return Ok(());
    }
    args.export.check_unfinished(&args.out)?;
    if let Some(path) = args.source.pack.as_deref().filter(|path| path.is_dir()) {
        return tree::run(args, path);
    }
    args.refuse_without_tree()?;
    let SweepRequest {
        header,
        conditions,
        views,
        mut settings,
        wanted,
        source,
        walks,
    } = SweepRequest::from_args(args)?;
    let augmentation = args.augment.augmentation()?;
    let variants = augmentation.variants();
    let pack = Pack::parse(&source.bytes)?;
    let cycles = args.variations();
    let firsts = args.firsts(&walks);
    let firsts = Job::under(&firsts, &conditions);
    let choice = args.max_gei_rmse;
    let choice = choice.map(|most| choose::drawing(&pack, &walks, &views.list, settings, most));
    let choice = choice.transpose()?;
    if let Some(choice) = &choice {
        args.common.say(format_args!("chosen: {choice}"));
        settings = choice.chosen.applied_to(settings);
    }
    let format = args.export.format;
    let mut work = SweepWork {
        common: &args.common,
        pack: &pack,
        groups: match format.is_tree() {
            true => grouped(&pack, &firsts),
            false => Vec::new(),
        },
        firsts: &firsts,
        variations: cycles.clone(),
        views: &views.list,
        settings,
        wanted: &wanted,
        variants: &variants,
        units: 0..0,
    };
    work.units = args.export.units(work.all_units())?;
    let mut header = header
        .drawn(&settings)
        .with("pack", source.name.as_str())
        .with("views", views.name.as_str())
        .with("viewpoints", views.list.len())
        .with("walks", walks.len())
        .with("first_cycle", cycles.start)
        .with("cycles", cycles.len());
    let has_takes = firsts.iter().any(|job| is_uncut(&pack, job.walk));
    if let Some(fps) = args.fps.or(has_takes.then_some(UNCUT_FPS)) {
        header = header.with("fps", fps);
    }
    if let Some(choice) = &choice {
        header = stated_choice(header, args.max_gei_rmse, choice);
    }
    header = header.augmented(augmentation);
    header.inputs.extend(source.inputs);
    let started = Instant::now();
    if args.digest {
        let made = MadeDataset::hashed(&work)?;
        return args.report(header, &settings, &wanted, made, started);
    }
    let run = DatasetRun {
        header: header.clone(),
        contents: Contents {
            templates: wanted.templates.clone(),
            size: settings.size,
            joints: wanted.joints,
        },
        format,
        units: work.units.len(),
        shard: args.export.shard,
        is_recorded: false,
    };
    let Some(mut writer) = args.export.begin(&args.out, run, args.common.overwrite)? else {
        args.common
            .say(format_args!("{} is already complete", args.out.display()));
        return Ok(());
    };
    work.store(&mut writer)?;
    let made = MadeDataset {
        rows: writer.rows(),
        silhouettes: (writer.frames() / variants.len()) as u64,
        clipped: writer.clipped(),
        said: format!("wrote {}", args.out.display()),
        raster: Some(settings.rasterizer.name()),
        digest: None,
    };
    writer.finish()?;
    args.report(header, &settings, &wanted, made, started)
}

/// A finished dataset.
struct MadeDataset {
    rows: usize,
    silhouettes: u64,
    clipped: f64,
    said: String,
    raster: Option<&'static str>,
    digest: Option<String>,
}

impl MadeDataset {
    /// Draws a dataset that is hashed, but not stored.
    fn hashed(work: &SweepWork<'_>) -> Result<Self> {
        let (clipped, digest) = work.digest()?;
        let (drawn, settings) = (work.cycles() * work.views.len(), &work.settings);
        Ok(Self {
            rows: drawn * work.variants.len(),
            silhouettes: drawn as u64 * u64::from(settings.frames_per_cycle),
            clipped,
            said: format!("sha256 {digest}"),
            raster: Some(settings.rasterizer.name()),
            digest: Some(digest),
        })
    }
}

impl SweepArgs {
    /// Returns the range of cycles of each walk.
    fn variations(&self) -> Range<u32> {
        let first = self.first_cycle.unwrap_or(0);
        first..first + self.cycles.unwrap_or(1)
    }

    /// Returns the first cycle of each walk.
    fn firsts(&self, walks: &[usize]) -> Vec<Job<'static>> {
        let first = self.variations().start;
        walks.iter().map(|&walk| Job::plain(walk, first)).collect()
    }

    /// Returns the settings, and the templates to make.
    fn wanted(&self) -> Result<(Settings, Wanted)> {
        let format = self.export.format;
        let templates = templates_of(&self.draw.template, format);
        let settings = Settings {
            template: templates[0],
            ..self.draw.without_template().settings(self.common.seed)?
        };
        let settings = sized(settings, self.draw.has_size(), format);
        settings.check()?;
        self.export.check(&templates, settings.size, self.joints)?;
        if self.max_gei_rmse.is_some() && templates != [Template::Gei] {
            return Err(Error::Usage(format!(
                "--max-gei-rmse is about GEIs, found --template {}",
                templates[0].name()
            )));
        }
        let wanted = Wanted {
            templates,
            joints: self.joints,
            blanks: true,
            fps: self.fps,
        };
        wanted.check(&settings)?;
        Ok((settings, wanted))
    }

    /// Rejects, before any work, walks that cannot be swept.
    fn check_walks(
        &self,
        pack: &Pack<'_>,
        jobs: &[Job<'_>],
        settings: &Settings,
        wanted: &Wanted,
        views: usize,
    ) -> Result<()> {
        let varied = self.variations() != (0..1);
        let walks: Vec<_> = pack.walks().collect();
        let subjects: Vec<_> = pack.subjects().collect();
        for &job in jobs {
            if varied && is_uncut(pack, job.walk) {
                return Err(Error::Usage(format!(
                    "--cycles, --first-cycle: {} is an uncut motion, which has no variations",
                    walk_name(pack, job.walk)
                )));
            }
            let frames = wanted.frames(pack, job, settings)? as usize;
            let numbers: usize = wanted
                .templates
                .iter()
                .map(|template| match template {
                    Template::Silhouettes => frames * settings.size.pixels(),
                    other => other.shape(settings.size).numbers(),
                })
                .sum();
            let kept = if self.export.format.is_tree() {
                self.variations().len()
            } else {
                1
            };
            if numbers.saturating_mul(views).saturating_mul(kept) > MOST_BYTES {
                return Err(Error::Usage(format!(
                    "{}: expected at most {MOST_BYTES} bytes of a walk in memory, found {numbers} for each of {views} viewpoints (choose fewer viewpoints, frames or cycles)",
                    walk_name(pack, job.walk)
                )));
            }
            if self.export.format.is_tree() {
                let walk = walks[job.walk];
                check_folder_name(walk.name)?;
                check_folder_name(subjects[walk.subject].name)?;
            }
        }
        Ok(())
    }

    /// Reports the finished dataset.
    fn report(
        &self,
        header: ResultHeader,
        settings: &Settings,
        wanted: &Wanted,
        made: MadeDataset,
        started: Instant,
    ) -> Result<()> {
        let seconds = started.elapsed().as_secs_f64();
        let results = SweepResults {
            header,
            silhouettes: made.silhouettes,
            geis: made.rows as u64,
            seconds,
            silhouettes_per_second: made.silhouettes as f64 / seconds,
            threads: rayon::current_num_threads(),
            raster: made.raster,
            framing: settings.framing.name(),
            peak_rss_bytes: peak_rss_bytes(),
            clipped_share: made.clipped / made.silhouettes.max(1) as f64,
            digest: made.digest,
        };
        let what = match *wanted.templates.as_slice() {
            [Template::Silhouettes] => "silhouette sequences".to_owned(),
            [template] => template.plural().to_owned(),
            ref several => format!("rows of {} templates", several.len()),
        };
        self.common.say(format_args!(
            "{}: {} {what} from {} silhouettes in {:.1} s, {:.0} silhouettes a second on {} threads; {:.2} % of the figures lay outside the image",
            made.said,
            results.geis,
            results.silhouettes,
            results.seconds,
            results.silhouettes_per_second,
            results.threads,
            100.0 * results.clipped_share
        ));
        self.common.write_json(&results)
    }
}

/// The maximum number of bytes in the templates of one walk: four walks in memory take a gigabyte.
const MOST_BYTES: usize = 1 << 28;

/// Parses the value of `--fps`.
fn fps(text: &str) -> std::result::Result<f64, String> {
    let found = text
        .parse()
        .ok()
        .filter(|fps: &f64| *fps > 0.0 && *fps <= 1e4);
    found.ok_or_else(|| "expected a number above 0, at most 10,000".to_owned())
}
