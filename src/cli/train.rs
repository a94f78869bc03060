//! `edgegait train`: fit a recognizer and export it as ONNX.

use super::args::{Common, ViewArgs};
use super::drawing::{DrawArgs, framing_of, stated};
use super::progress::Progress;
use super::source::SourceArgs;
use crate::dataset::{Dataset, Header, InputFile, sha256_of_bytes, write_atomically};
use crate::error::{Error, Result};
use crate::score::{Contract, OutputNames, Training};
use crate::sweep::{Framing, Lens, jobs, sweep};
use crate::train::{Components, Options, fit, onnx};
use edgegait_core::pack::Pack;
use edgegait_core::silhouette::Size;
use ndarray::Array2;
use serde::Serialize;
use std::io::Write as _;
use std::path::{Path, PathBuf};

/// Cycles of each walk that are trained on unless a user says otherwise.
const CYCLES: u32 = 8;

/// Train a PCA + LDA recognizer and export it as one ONNX graph of plain operators
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  edgegait train --out side.onnx                      # built-in cohort, side view\n  edgegait train --azimuth-deg 0,45,90,135,180 --elevation-deg 0,30,60 --out spread.onnx\n  edgegait train dataset --out mine.onnx              # a dataset that `sweep` wrote"
)]
pub struct Args {
    #[command(flatten)]
    source: SourceArgs,
    /// Where to write the model; its contract goes beside it as .toml
    #[arg(long, value_name = "PATH", default_value = "recognizer.onnx")]
    out: PathBuf,
    /// Cycles of each walk to train on: the stored one, then seeded variations. `score` probes
    /// with variations from number 1000 on, which training never uses
    /// [default: 8]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1000))]
    cycles: Option<u32>,
    /// Principal components that the discriminants are sought in
    #[arg(long, value_name = "N", default_value_t = 100, value_parser = clap::value_parser!(u16).range(1..=4096))]
    components: u16,
    #[command(flatten)]
    views: ViewArgs,
    #[command(flatten)]
    draw: DrawArgs,
    #[command(flatten)]
    pub common: Common,
}

/// The results of training.
#[derive(Serialize)]
struct Results {
    #[serde(flatten)]
    header: Header,
    model: InputFile,
    samples: usize,
    classes: usize,
    dims: usize,
    bytes: usize,
    training_rank1: f64,
}

/// GEIs with their people.
struct Samples {
    pixels: Vec<f32>,
    size: Size,
    framing: Framing,
    labels: Vec<usize>,
    names: Vec<String>,
    training: Training,
    header: Header,
}

/// Runs the subcommand.
pub fn run(args: &Args) -> Result<()> {
    if args
        .out
        .extension()
        .is_none_or(|extension| extension != "onnx")
    {
        return Err(Error::Usage(format!(
            "--out {}: expected a name that ends in .onnx",
            args.out.display()
        )));
    }
    let samples = match &args.source.pack {
        Some(path) if path.is_dir() => from_dataset(args, path)?,
        _ => from_walks(args)?,
    };
    let count = samples.labels.len();
    let matrix = Array2::from_shape_vec((count, samples.size.pixels()), samples.pixels)
        .map_err(|error| Error::Failed(error.to_string()))?;
    let options = Options {
        components: Components::Count(usize::from(args.components).min(count.saturating_sub(1))),
        ..Options::default()
    };
    let recognizer = fit(matrix.view(), &samples.labels, samples.names.len(), options)?;
    let hits = matrix
        .rows()
        .into_iter()
        .zip(&samples.labels)
        .filter(|(gei, label)| {
            let scores = recognizer.scores(recognizer.embed(&gei.to_vec()).view());
            crate::evaluate::rank::closed_set(&scores.to_vec(), **label)
                == crate::evaluate::rank::Outcome::Hit
        })
        .count();
    let name = args
        .out
        .file_stem()
        .map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
    let bytes = onnx::write(&recognizer, &name, &[]);
    let contract = Contract {
        name,
        rows: samples.size.rows(),
        columns: samples.size.columns(),
        framing: samples.framing,
        classes: samples.names,
        outputs: OutputNames {
            embedding: Some(onnx::EMBEDDING.into()),
            scores: Some(onnx::SCORES.into()),
        },
        training: samples.training,
        ..Contract::default()
    };
    let toml = contract.to_toml()?;
    let write = |path: &Path, bytes: &[u8]| {
        write_atomically(path, |file| {
            file.write_all(bytes)
                .map_err(|error| Error::io(path, error))
        })
    };
    write(&args.out, &bytes)?;
    write(&Contract::path_beside(&args.out), toml.as_bytes())?;
    let results = Results {
        header: samples.header,
        model: InputFile {
            path: args.out.display().to_string(),
            sha256: sha256_of_bytes(&bytes),
        },
        samples: count,
        classes: recognizer.classes(),
        dims: recognizer.dims(),
        bytes: bytes.len(),
        training_rank1: hits as f64 / count as f64,
    };
    args.common.say(format_args!(
        "wrote {}: {} bytes, {} people, {} dimensions, trained on {} GEIs, of which it recognizes {:.2} %",
        args.out.display(),
        results.bytes,
        results.classes,
        results.dims,
        results.samples,
        100.0 * results.training_rank1
    ));
    args.common.write_json(&results)
}

/// Samples drawn here, from a pack or from the built-in cohort.
fn from_walks(args: &Args) -> Result<Samples> {
    let views = args.views.views("side")?;
    let settings = args.draw.settings(args.common.seed)?;
    let source = args.source.load()?;
    let pack = Pack::parse(&source.bytes).map_err(|error| Error::Failed(error.to_string()))?;
    let walks = args.source.choose(&pack)?;
    let all: Vec<_> = pack.walks().collect();
    let mut people: Vec<usize> = walks.iter().map(|&walk| all[walk].subject).collect();
    people.dedup();
    let cycles = args.cycles.unwrap_or(CYCLES);
    let jobs = jobs(&pack, &walks, 0..cycles)?;
    let (mut pixels, mut labels) = (Vec::new(), Vec::new());
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
            let person = all[job.walk].subject;
            let label = people.iter().position(|&p| p == person).unwrap_or(0);
            for gei in &swept.geis {
                pixels.extend(gei.pixels().iter().map(|&pixel| f32::from(pixel) / 255.0));
                labels.push(label);
            }
            Ok(())
        },
    )?;
    let mut names: Vec<&str> = walks.iter().map(|&walk| all[walk].name).collect();
    names.sort_unstable();
    names.dedup();
    let mut header = stated(Header::new("train", args.common.seed), &settings)
        .with("pack", source.name.as_str())
        .with("walks", names.join(","))
        .with("cycles", cycles)
        .with("views", views.name.as_str())
        .with("components", args.components);
    header.inputs = source.inputs;
    let subjects: Vec<_> = pack.subjects().collect();
    Ok(Samples {
        training: Training {
            description: format!(
                "PCA ({}) + LDA on {} of {}, cycles 0 to {}, {} viewpoints, seed {}, raster {}{}",
                args.components,
                names.join(","),
                source.name,
                cycles - 1,
                views.list.len(),
                args.common.seed,
                settings.rasterizer,
                if settings.lens == Lens::Persp {
                    format!(", in perspective from {} m", settings.sensor.distance_m)
                } else {
                    String::new()
                },
            ),
            viewpoints: views
                .list
                .iter()
                .map(|view| [f64::from(view.azimuth_deg), f64::from(view.elevation_deg)])
                .collect(),
            walks: names.iter().map(|&name| name.to_owned()).collect(),
            cycles,
            seed: args.common.seed,
        },
        pixels,
        size: settings.size,
        framing: settings.framing,
        labels,
        names: people
            .iter()
            .map(|&p| subjects[p].name.to_owned())
            .collect(),
        header,
    })
}

/// All of a dataset's GEIs.
fn from_dataset(args: &Args, path: &Path) -> Result<Samples> {
    let names = [args.source.subjects.as_slice(), &args.source.walks];
    args.draw
        .refuse_for_datasets(names, args.cycles, &args.views)?;
    let dataset = Dataset::open(path)?;
    let mut names: Vec<String> = Vec::new();
    let mut viewpoints: Vec<[f64; 2]> = Vec::new();
    let mut labels = Vec::new();
    for row in dataset.index() {
        let known = names.iter().position(|name| *name == row.subject);
        labels.push(known.unwrap_or_else(|| {
            names.push(row.subject.clone());
            names.len() - 1
        }));
        let viewpoint = [row.azimuth_deg, row.elevation_deg];
        if !viewpoints.contains(&viewpoint) {
            viewpoints.push(viewpoint);
        }
    }
    let rows = dataset.index();
    let mut walks: Vec<String> = rows.iter().map(|row| row.walk.clone()).collect();
    walks.sort_unstable();
    walks.dedup();
    let pixels = dataset.geis().flatten();
    let mut header = Header::new("train", args.common.seed).with("components", args.components);
    let framing = framing_of(&dataset, path)?;
    if framing.is_none() {
        header.warnings.push(format!(
            "{} does not say how its figures are framed: the model's contract says height",
            path.display()
        ));
    }
    header.inputs = vec![InputFile::of(path.join("manifest.json"))?];
    Ok(Samples {
        training: Training {
            description: format!(
                "PCA ({}) + LDA on the {} GEIs of {}",
                args.components,
                labels.len(),
                path.display()
            ),
            viewpoints,
            walks,
            cycles: 1 + rows.iter().map(|row| row.cycle).max().unwrap_or(0),
            seed: rows.first().map_or(0, |row| row.seed),
        },
        pixels: pixels.map(|&pixel| f32::from(pixel) / 255.0).collect(),
        size: dataset.size(),
        framing: framing.unwrap_or_default(),
        labels,
        names,
        header,
    })
}
