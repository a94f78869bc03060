//! `edgegait generate`: makes whole training sets from a design, as datasets.

use super::args::{Common, FileArgs};
use super::export::{ExportArgs, sized, take_name};
use super::progress::Progress;
use super::sweep::peak_rss_bytes;
use crate::dataset::design::{Design, Split};
use crate::dataset::{
    Contents, DatasetFormat, DatasetRun, DatasetWriter, IndexRow, Item, WalkerRow,
};
use crate::draw::sweep::{DrawingRequest, Swept, View, sweep_each};
use crate::draw::template::Template;
use crate::encode::{Effort, MAX_ERROR_MM, encode_population};
use crate::error::{Error, Result};
use crate::files::{InputFile, ResultHeader};
use crate::people::variation::CYCLES_OF_A_TAKE;
use edgegait_core::pack::{Pack, Sex};
use edgegait_core::silhouette::Size;
use serde::Serialize;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Generate a training set from a design: people, walks, viewpoints, conditions and splits in one
/// file of about twenty lines
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Built-in designs: casia-b-like (124 people, 11 viewpoints, NM, BG and CL), domain-random (1,000 dressed people of 18 to 80 years, everything varied together). A design of your own:\n\n  seed = 7\n  conditions = \"casia-b\"                # or [[conditions]], as `sweep --conditions` reads them\n  [population]\n  people = \"0..1000\"                    # or [splits]\n  reference = \"us-army\"               # or \"britain\" or \"china\"\n  age_years = [18, 80]\n  dressed = \"per-take\"                  # or \"for-good\" or \"never\"\n  [walks]\n  speeds_kmh = { uniform = [3, 7], walks = 2 }   # or [4, 5, 6]\n  takes = 2\n  cycles = 1                            # of each take\n  [views]\n  azimuth_deg = { uniform = [0, 360] }  # or [0, 45, 90]\n  elevation_deg = [0]\n  count = 8                             # sampled for each cycle\n  [images]\n  template = \"gei\"\n  size = \"64x44\"\n  raster = \"rows\"\n\nOther people and walks of a built-in design come from --seed; a file states its seed.\n\nExamples:\n  edgegait generate casia-b-like --out casia --people 4\n  edgegait generate design.toml --out sets"
)]
pub(super) struct GenerateArgs {
    /// The name of a built-in design, or a .toml file
    #[arg(value_name = "NAME|FILE")]
    design: String,
    /// Folder to write: a dataset, or a subfolder with a dataset for each split
    #[arg(long, value_name = "PATH", default_value = "generated")]
    out: PathBuf,
    /// Maximum number of people in each split, to try a design
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    people: Option<u32>,
    #[command(flatten)]
    export: ExportArgs,
    #[command(flatten)]
    pub common: Common,
    /// Whether `--seed` was given, which a built-in design takes in place of its own.
    #[arg(skip)]
    pub is_seeded: bool,
}

/// Number of people that are made at the same time: enough for all cores, in a few megabytes.
const PEOPLE_AT_ONCE: usize = 64;

/// The results of the command.
#[derive(Serialize)]
struct GenerateResults {
    #[serde(flatten)]
    header: ResultHeader,
    people: usize,
    walks: usize,
    geis: usize,
    seconds: f64,
    people_per_second: f64,
    threads: usize,
    peak_rss_bytes: Option<u64>,
}

impl GenerateArgs {
    /// Returns whether the design is a file's, and no built-in one.
    fn is_file(&self) -> bool {
        Path::new(&self.design).extension().is_some()
    }

    /// Returns the files that the command reads and writes.
    pub(super) fn files(&self) -> FileArgs {
        let folders = match Design::named(&self.design) {
            Ok(design) => {
                let parts = self.parts(&design).into_iter();
                parts.map(|part| part.folder).collect()
            }
            // Errors are reported when it is read again.
            Err(_) => Vec::new(),
        };
        FileArgs {
            inputs: { self.is_file().then(|| PathBuf::from(&self.design)) }
                .into_iter()
                .collect(),
            outputs: folders
                .iter()
                .map(|folder| self.export.output(folder))
                .collect(),
        }
    }
}

/// The people of one dataset, and its folder.
struct SplitPart<'d> {
    folder: PathBuf,
    splits: Vec<&'d Split>,
}

impl SplitPart<'_> {
    /// Returns the number of each person, and the name of the split.
    fn people(&self) -> impl Iterator<Item = (usize, &str)> {
        self.splits.iter().flat_map(|split| {
            let name = split.name.as_deref().unwrap_or("train");
            split.people.clone().map(move |number| (number, name))
        })
    }
}

impl GenerateArgs {
    /// Returns the parts to write: a dataset for each split, or one tree with all splits.
    fn parts<'d>(&self, design: &'d Design) -> Vec<SplitPart<'d>> {
        if self.export.format.is_tree() {
            return vec![SplitPart {
                folder: self.out.clone(),
                splits: design.splits.iter().collect(),
            }];
        }
        let part = |split: &'d Split| SplitPart {
            folder: match (&split.name, self.export.format) {
                (None, _) => self.out.clone(),
                (Some(name), DatasetFormat::Npz) => self.out.join(format!("{name}.npz")),
                (Some(name), _) => self.out.join(name),
            },
            splits: vec![split],
        };
        design.splits.iter().map(part).collect()
    }

    /// Reads the design, and applies the number of people and the format to it.
    fn design(&self) -> Result<Design> {
        let mut design = Design::named(&self.design)?;
        let seed = self.common.seed;
        if self.is_seeded && seed != design.settings.seed {
            if self.is_file() {
                return Err(Error::Usage(format!(
                    "--seed {seed}: {} states its own seed, {} (change `seed` there; --seed is for built-in designs)",
                    self.design, design.settings.seed
                )));
            }
            design.settings.seed = seed;
        }
        if let Some(most) = self.people {
            for split in &mut design.splits {
                let most = split.people.start.saturating_add(most as usize);
                split.people.end = split.people.end.min(most);
            }
        }
        let format = self.export.format;
        if format.is_tree() {
            design.images.wanted.templates = vec![Template::Silhouettes];
        }
        // OpenGait crops its 64x64 files to 64x44.
        let is_other = design.images.has_size && design.settings.size != Size::S64x44;
        design.settings = sized(design.settings, is_other, format);
        design.settings.template = design.images.wanted.templates[0];
        let wanted = &design.images.wanted;
        self.export
            .check(&wanted.templates, design.settings.size, wanted.joints)?;
        let mut names = design
            .splits
            .iter()
            .filter_map(|split| split.name.as_deref());
        let other = names.find(|name| !["train", "test"].contains(name));
        if let (DatasetFormat::Opengait, Some(other)) = (format, other) {
            return Err(Error::Usage(format!(
                "--format opengait: expected the splits train and test, as OpenGait has, found {other:?} (rename the splits)"
            )));
        }
        Ok(design)
    }
}

/// Runs the subcommand.
pub(super) fn run(args: &GenerateArgs) -> Result<()> {
    let design = args.design()?;
    let started = Instant::now();
    let parts = args.parts(&design);
    for part in &parts {
        args.export.check_unfinished(&part.folder)?;
    }
    let mut header = ResultHeader::new("generate", design.settings.seed)
        .drawn(&design.settings)
        .with("design", args.design.as_str())
        .with("people_at_most", args.people)
        .with("population", design.population.reference.name())
        .with("viewpoints", design.viewpoints())
        .with("takes", design.takes.len())
        .with("cycles", design.cycles)
        .with("encoding", "quick")
        .with("max_error_mm", MAX_ERROR_MM);
    if !design.conditions.is_empty() {
        header = header.with("conditions", serde_json::json!(design.conditions));
    }
    if let Some(fps) = design.images.wanted.fps {
        header = header.with("fps", fps);
    }
    if args.is_file() {
        header.inputs.push(InputFile::read(&args.design)?);
    }
    let mut shares = Vec::new();
    for part in &parts {
        let all: Vec<(usize, &str)> = part.people().collect();
        shares.push(all[args.export.units(all.len())?].to_vec());
    }
    let people: usize = shares.iter().map(Vec::len).sum();
    let progress = Progress::new(&args.common, ("generating", "people"), people);
    let (mut rows, mut people, mut drawn) = (0, 0, 0);
    for (part, share) in parts.iter().zip(&shares) {
        let ranges = part.splits.iter().map(|split| {
            let Range { start, end } = split.people;
            format!("{start}..{end}")
        });
        let run = DatasetRun {
            header: header
                .clone()
                .with("people", ranges.collect::<Vec<_>>().join(",")),
            contents: Contents {
                templates: design.images.wanted.templates.clone(),
                size: design.settings.size,
                joints: design.images.wanted.joints,
            },
            format: args.export.format,
            units: share.len(),
            shard: args.export.shard,
            is_recorded: false,
        };
        let Some(mut writer) = args
            .export
            .begin(&part.folder, run, args.common.overwrite)?
        else {
            args.common.say(format_args!(
                "{} is already complete",
                part.folder.display()
            ));
            continue;
        };
        let left = &share[writer.done()..];
        (people, drawn) = (people + share.len(), drawn + left.len());
        for people in left.chunks(PEOPLE_AT_ONCE) {
            draw(&design, people, &mut writer, &progress)?;
        }
        rows += writer.rows();
        writer.finish()?;
    }
    let seconds = started.elapsed().as_secs_f64();
    let results = GenerateResults {
        header,
        people,
        walks: people * design.walks(),
        geis: rows,
        seconds,
        people_per_second: drawn as f64 / seconds,
        threads: rayon::current_num_threads(),
        peak_rss_bytes: peak_rss_bytes(),
    };
    let what = match *design.images.wanted.templates.as_slice() {
        [Template::Silhouettes] => "silhouette sequences".to_owned(),
        [template] => template.plural().to_owned(),
        ref several => format!("rows of {} templates", several.len()),
    };
    if people > 0 {
        args.common.say(format_args!(
            "wrote {}: {} {what} of {} walks of {people} people in {seconds:.1} s, {:.0} people a second on {} threads",
            args.out.display(),
            results.geis,
            results.walks,
            results.people_per_second,
            results.threads
        ));
    }
    args.common.write_json(&results)
}

/// Makes people, encodes them quickly, draws them, and drops them.
fn draw(
    design: &Design,
    people: &[(usize, &str)],
    writer: &mut DatasetWriter,
    progress: &Progress,
) -> Result<()> {
    let make = |at: usize| design.subject(people[at].0);
    let bytes = encode_population(0..people.len(), &make, MAX_ERROR_MM, Effort::Quick, &|| {
        progress.check()
    })?;
    let pack = Pack::parse(&bytes)?;
    let (walks, settings) = (pack.walks().collect::<Vec<_>>(), design.settings);
    let subjects: Vec<_> = pack.subjects().collect();
    let wanted = &design.images.wanted;
    let jobs = design.jobs(&pack);
    let request = DrawingRequest { settings, wanted };
    let mut last = None;
    let mut at = 0;
    sweep_each(
        &pack,
        &jobs,
        |job| design.views_of(&pack, job),
        request,
        |_, views, swept| Ok((views.to_vec(), swept)),
        |job, (views, swept): (Vec<View>, Swept)| {
            let walk = walks[job.walk];
            if last.replace(walk.subject) != Some(walk.subject) {
                writer.belongs(subjects[walk.subject].name, people[walk.subject].1);
                describe(design, &pack, walk.subject, writer)?;
            }
            writer.clip(swept.clipped);
            let take = match design.take_of(job) {
                Some(take) => take.to_owned(),
                None => {
                    let take = job.variation / CYCLES_OF_A_TAKE;
                    take_name(walk.name, job.condition_name(), Some(take))
                }
            };
            let mut row = IndexRow::of_job(&pack, job, settings.seed, swept.frames)?;
            if let Some(take) = design.take_of(job) {
                take.clone_into(&mut row.walk);
            }
            let templates = swept.templates.chunks_exact(wanted.templates.len());
            for ((view, templates), keypoints) in views.iter().zip(templates).zip(&swept.keypoints)
            {
                let row = row.seen_from(view);
                writer.push(Item {
                    row: &row,
                    take: &take,
                    templates,
                    joints: [&swept.joints, keypoints],
                })?;
            }
            at += 1;
            let next = jobs.get(at).map(|job| walks[job.walk].subject);
            if next != Some(walk.subject) {
                progress.step()?;
                writer.end_unit()?;
            }
            Ok(())
        },
    )
}

/// Writes the walker of each walk of a person, or of each take if takes have names.
fn describe(
    design: &Design,
    pack: &Pack<'_>,
    person: usize,
    writer: &mut DatasetWriter,
) -> Result<()> {
    for walk in pack.walks().filter(|walk| walk.subject == person) {
        let Some((subject, avatar)) = pack.subject(walk.subject).zip(pack.avatar(walk.avatar))
        else {
            continue;
        };
        let sex = subject.sex.map_or("", Sex::name);
        let clothes = avatar.clothes();
        // The names in the index.
        let takes = design.takes.iter();
        let mut names: Vec<&str> = takes.filter_map(|take| take.name.as_deref()).collect();
        if names.is_empty() {
            names.push(walk.name);
        }
        for name in names {
            writer.describe(&WalkerRow {
                subject: subject.name.into(),
                walk: name.into(),
                sex: sex.into(),
                age_years: subject.age_years,
                stature_m: f64::from(subject.stature_mm) / 1e3,
                mass_kg: f64::from(subject.mass_hg) / 10.0,
                clothes: clothes.map_or_else(String::new, |clothes| clothes.to_string()),
            })?;
        }
    }
    Ok(())
}
