//! `edgegait generate`: whole training sets from a design, as datasets.

use super::args::{Common, Files};
use super::outputs::{Kind, Output};
use super::progress::Progress;
use super::sweep::{kmh, peak_rss_bytes};
use crate::dataset::{DatasetWriter, Existing, Header, IndexRow, InputFile, WalkerRow};
use crate::design::{Design, Split};
use crate::encode::{Effort, MAX_ERROR_MM, encode_population};
use crate::error::{Error, Result};
use crate::scene::cohort::DEFAULT_SEED;
use crate::sweep::{View, drawn, sweep_each};
use edgegait_core::pack::{Pack, Sex};
use serde::Serialize;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Generate a training set from a design: people, walks, viewpoints, conditions and splits in one
/// file of about twenty lines
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Designs that are built in: casia-b-like (124 people, 11 viewpoints, NM, BG and CL), domain-random\n(1,000 dressed people of 18 to 80 years, everything varied at once). One of your own:\n\n  seed = 7\n  conditions = \"casia-b\"                # or [[conditions]], as `sweep --conditions` reads them\n  [population]\n  people = \"0..1000\"                    # or [splits]\n  age_years = [18, 80]\n  dressed = \"per-take\"                  # or \"for-good\" or \"never\"\n  [walks]\n  speeds_kmh = { uniform = [3, 7], walks = 2 }   # or [4, 5, 6]\n  takes = 2\n  cycles = 1                            # of each take\n  [views]\n  azimuth_deg = { uniform = [0, 360] }  # or [0, 45, 90]\n  elevation_deg = [0]\n  count = 8                             # drawn for each cycle\n  [images]\n  template = \"gei\"\n  size = \"64x44\"\n  raster = \"rows\"\n\nExamples:\n  edgegait generate casia-b-like --out casia --people 4\n  edgegait generate design.toml --out sets"
)]
pub(super) struct Args {
    /// The name of a design that is built in, or a .toml file
    #[arg(value_name = "NAME|FILE")]
    design: String,
    /// Folder to write: a dataset, or one for each split, in a folder of its name
    #[arg(long, value_name = "PATH", default_value = "generated")]
    out: PathBuf,
    /// At most so many people of each split, to try a design
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    people: Option<u32>,
    #[command(flatten)]
    pub common: Common,
}

/// People who are made at once: enough for all cores, and a few megabytes.
const PEOPLE_AT_ONCE: usize = 64;

/// The results.
#[derive(Serialize)]
struct Results {
    #[serde(flatten)]
    header: Header,
    people: usize,
    walks: usize,
    geis: usize,
    seconds: f64,
    people_per_second: f64,
    threads: usize,
    peak_rss_bytes: Option<u64>,
}

impl Args {
    /// What it reads and writes.
    pub(super) fn files(&self) -> Files {
        let is_file = Path::new(&self.design).extension().is_some();
        let folders = match Design::named(&self.design) {
            Ok(design) => {
                let folder = |split: &Split| folder_of(&self.out, split);
                design.splits.iter().map(folder).collect()
            }
            // What is wrong is said when it is read again.
            Err(_) => Vec::new(),
        };
        Files {
            inputs: is_file
                .then(|| PathBuf::from(&self.design))
                .into_iter()
                .collect(),
            outputs: folders
                .iter()
                .map(|folder| Output::new("--out", folder, Kind::Dataset))
                .collect(),
        }
    }
}

fn folder_of(out: &Path, split: &Split) -> PathBuf {
    match &split.name {
        Some(name) => out.join(name),
        None => out.to_path_buf(),
    }
}

/// Runs the subcommand.
pub(super) fn run(args: &Args) -> Result<()> {
    let mut design = Design::named(&args.design)?;
    if args.common.seed != DEFAULT_SEED && args.common.seed != design.settings.seed {
        return Err(Error::Usage(
            "--seed: a design states its own (change `seed` in a copy of it)".into(),
        ));
    }
    if let Some(most) = args.people {
        for split in &mut design.splits {
            let most = split.people.start.saturating_add(most as usize);
            split.people.end = split.people.end.min(most);
        }
    }
    let started = Instant::now();
    let progress = Progress::new("people", design.people());
    let mut made = Vec::new();
    for split in &design.splits {
        let count = split.people.len() * design.cycles() * design.viewpoints();
        let writer = DatasetWriter::create(
            folder_of(&args.out, split),
            (design.settings.template, design.settings.size),
            count,
            Existing::of(args.common.overwrite),
        )?;
        made.push((split, writer));
    }
    for (split, writer) in &mut made {
        for first in split.people.clone().step_by(PEOPLE_AT_ONCE) {
            let people = first..split.people.end.min(first + PEOPLE_AT_ONCE);
            draw(&design, people, writer, &progress)?;
        }
    }
    let mut header = Header::new("generate", design.settings.seed)
        .drawn(&design.settings)
        .with("design", args.design.as_str())
        .with("people_at_most", args.people)
        .with("viewpoints", design.viewpoints())
        .with("takes", design.takes.len())
        .with("cycles", design.cycles)
        .with("encoding", "quick")
        .with("max_error_mm", MAX_ERROR_MM);
    if !design.conditions.is_empty() {
        header = header.with("conditions", serde_json::json!(design.conditions));
    }
    header.inputs = match Path::new(&args.design).extension() {
        Some(_) => vec![InputFile::of(&args.design)?],
        None => Vec::new(),
    };
    for (split, writer) in made {
        let Range { start, end } = split.people;
        let people = format!("{start}..{end}");
        writer.finish(header.clone().with("people", people))?;
    }
    let seconds = started.elapsed().as_secs_f64();
    let people = design.people();
    let results = Results {
        header,
        people,
        walks: people * design.walks(),
        geis: people * design.cycles() * design.viewpoints(),
        seconds,
        people_per_second: people as f64 / seconds,
        threads: rayon::current_num_threads(),
        peak_rss_bytes: peak_rss_bytes(),
    };
    args.common.say(format_args!(
        "wrote {}: {} {} of {} walks of {people} people in {seconds:.1} s, {:.0} people a second on {} threads",
        args.out.display(),
        results.geis,
        design.settings.template.plural(),
        results.walks,
        results.people_per_second,
        results.threads
    ));
    args.common.write_json(&results)
}

/// Makes people, encodes them quickly, draws them and forgets them.
fn draw(
    design: &Design,
    people: Range<usize>,
    writer: &mut DatasetWriter,
    progress: &Progress,
) -> Result<()> {
    let make = |number| design.subject(number);
    let bytes = encode_population(people, &make, (MAX_ERROR_MM, Effort::Quick), &|| {})?;
    let pack = Pack::parse(&bytes)?;
    describe(&pack, writer)?;
    let (walks, settings) = (pack.walks().collect::<Vec<_>>(), design.settings);
    let subjects: Vec<_> = pack.subjects().collect();
    let mut last = None;
    sweep_each(
        &pack,
        &design.jobs(&pack),
        |job| design.views_of(&pack, job),
        settings,
        |_, views, swept| Ok((views.to_vec(), swept)),
        |job, (views, swept): (Vec<View>, _)| {
            let walk = walks[job.walk];
            if last.replace(walk.subject) != Some(walk.subject) {
                progress.step();
            }
            let row = IndexRow {
                subject: subjects[walk.subject].name.into(),
                walk: design.take_of(job).unwrap_or(walk.name).into(),
                cycle: u32::from(walk.cycle),
                variation: job.variation,
                speed_kmh: kmh(walk.speed_mm_per_s),
                azimuth_deg: 0.0,
                elevation_deg: 0.0,
                condition: job.condition_name().into(),
                alternative: drawn(&pack, job, settings.seed)?,
                frames: settings.frames_per_cycle,
                seed: settings.seed,
            };
            for (view, bytes) in views.iter().zip(&swept.templates) {
                let (azimuth_deg, elevation_deg) = view.angles_deg();
                let row = IndexRow {
                    azimuth_deg,
                    elevation_deg,
                    ..row.clone()
                };
                writer.push(bytes, &row)?;
            }
            Ok(())
        },
    )
}

/// Says who walks in each walk of a pack.
fn describe(pack: &Pack<'_>, writer: &mut DatasetWriter) -> Result<()> {
    for walk in pack.walks() {
        let Some((subject, avatar)) = pack.subject(walk.subject).zip(pack.avatar(walk.avatar))
        else {
            continue;
        };
        let sex = subject.sex.map_or("", |sex| match sex {
            Sex::Female => "female",
            Sex::Male => "male",
        });
        let clothes = avatar.clothes();
        writer.describe(&WalkerRow {
            subject: subject.name.into(),
            walk: walk.name.into(),
            sex: sex.into(),
            age_years: subject.age_years,
            stature_m: f64::from(subject.stature_mm) / 1e3,
            mass_kg: f64::from(subject.mass_hg) / 10.0,
            clothes: clothes.map_or_else(String::new, |clothes| clothes.to_string()),
        })?;
    }
    Ok(())
}
