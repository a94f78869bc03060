//! `edgegait train`: fit a recognizer and export it as ONNX.

use super::args::{Common, Files, ViewArgs};
use super::augment::{AugmentArgs, append_varied, described, stated_augmentation};
use super::drawing::{DrawArgs, framing_of, stated};
use super::outputs::{Kind, Output};
use super::progress::Progress;
use super::source::SourceArgs;
use crate::dataset::{Dataset, Header, IndexRow, InputFile, sha256_of_bytes, write_bytes};
use crate::error::{Error, Result};
use crate::evaluate::rank::{Outcome, closed_set};
use crate::score::{Contract, Layout, OutputNames, Training};
use crate::sweep::{Framing, Lens, jobs, sweep};
use crate::template::Template;
use crate::template::augment::Augmentation;
use crate::train::{Analysed, Components, LinearRecognizer, Method, Options, Real, onnx};
use edgegait_core::pack::Pack;
use edgegait_core::silhouette::Size;
use ndarray::Array2;
use serde::Serialize;
use std::collections::{BTreeSet, HashSet};
use std::path::{Path, PathBuf};

/// Cycles of each walk that are trained on unless a user says otherwise.
const CYCLES: u32 = 8;

/// Train PCA + LDA or PCA + SVM recognizers and export each as one ONNX graph of plain operators
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  edgegait train --out side.onnx                      # built-in cohort, side view\n  edgegait train --azimuth-deg 0,45,90,135,180 --elevation-deg 0,30,60 --out spread.onnx\n  edgegait train dataset --out mine.onnx              # a dataset that `sweep` wrote\n  edgegait train --template geni --augment flip,crop --out geni.onnx\n  edgegait train --method svm --components 5,10,20,50 # recognizer-5.onnx, recognizer-10.onnx ..."
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
    /// What tells people apart in the principal components: the nearest mean along linear
    /// discriminants, or linear support vector machines, one for each person against the rest
    #[arg(long, value_name = "METHOD", default_value = "lda")]
    method: MethodArg,
    /// Principal components that are kept; several counts write NAME-N.onnx for each
    #[arg(long, value_name = "N[,N..]", default_value = "100", value_delimiter = ',', value_parser = clap::value_parser!(u16).range(1..=4096))]
    components: Vec<u16>,
    /// Weight of the errors of `--method svm`
    /// [default: 1]
    #[arg(long, value_name = "C")]
    svm_c: Option<f64>,
    /// Floating-point type that training computes in; models are f32
    #[arg(long, value_name = "TYPE", default_value = "f64")]
    precision: Precision,
    #[command(flatten)]
    views: ViewArgs,
    #[command(flatten)]
    draw: DrawArgs,
    #[command(flatten)]
    augment: AugmentArgs,
    #[command(flatten)]
    pub common: Common,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum MethodArg {
    Lda,
    Svm,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Precision {
    F32,
    F64,
}

/// The results of training.
#[derive(Serialize)]
struct Results {
    #[serde(flatten)]
    header: Header,
    samples: usize,
    classes: usize,
    models: Vec<ModelResult>,
}

/// A model that was written.
#[derive(Serialize)]
struct ModelResult {
    #[serde(flatten)]
    file: InputFile,
    components: u16,
    dims: usize,
    bytes: usize,
    training_rank1: f64,
}

/// Templates with their people; `training.description` says of what and how.
struct Samples {
    numbers: Vec<f32>,
    template: Template,
    size: Size,
    framing: Framing,
    labels: Vec<usize>,
    names: Vec<String>,
    training: Training,
    header: Header,
}

/// Runs the subcommand.
pub fn run(args: &Args) -> Result<()> {
    let method = args.method()?;
    let outs = args.outs()?;
    let mut samples = match &args.source.pack {
        Some(path) if path.is_dir() => from_dataset(args, path)?,
        _ => from_walks(args)?,
    };
    let counts: Vec<String> = args.components.iter().map(u16::to_string).collect();
    let recipe = [
        ("components", counts.join(",")),
        ("method", method.to_string()),
        ("precision", args.precision.name().to_owned()),
    ];
    for (name, value) in recipe {
        samples.header = samples.header.with(name, value);
    }
    let numbers = std::mem::take(&mut samples.numbers);
    let columns = samples.template.shape(samples.size).numbers();
    let matrix = Array2::from_shape_vec((samples.labels.len(), columns), numbers)
        .map_err(|error| Error::Failed(error.to_string()))?;
    let models = match args.precision {
        Precision::F64 => train::<f64>(args, method, &outs, &samples, &matrix)?,
        Precision::F32 => train::<f32>(args, method, &outs, &samples, &matrix)?,
    };
    args.common.write_json(&Results {
        header: samples.header,
        samples: samples.labels.len(),
        classes: samples.names.len(),
        models,
    })
}

impl Args {
    /// What it reads and writes.
    pub fn files(&self) -> Files {
        let outs = self.outs().unwrap_or_default().into_iter();
        Files {
            inputs: self
                .source
                .pack
                .clone()
                .into_iter()
                .chain(self.views.file())
                .collect(),
            outputs: outs
                .map(|out| Output::new("--out", &out, Kind::Model))
                .collect(),
        }
    }

    fn method(&self) -> Result<Method> {
        match (self.method, self.svm_c) {
            (MethodArg::Lda, None) => Ok(Method::LDA),
            (MethodArg::Lda, Some(_)) => Err(Error::Usage(
                "--svm-c is the weight of errors of --method svm: LDA has none".into(),
            )),
            (MethodArg::Svm, c) => match c.unwrap_or(1.0) {
                c if c > 0.0 && c.is_finite() => Ok(Method::Svm { c }),
                c => Err(Error::Usage(format!(
                    "--svm-c: expected a C above 0, found {c}"
                ))),
            },
        }
    }

    /// Where the model with each number of components goes.
    fn outs(&self) -> Result<Vec<PathBuf>> {
        let out = &self.out;
        if out.extension().is_none_or(|extension| extension != "onnx") {
            return Err(Error::Usage(format!(
                "--out {}: expected a name that ends in .onnx",
                out.display()
            )));
        }
        let counts = &self.components;
        if let Some(twice) = (1..counts.len()).find(|&i| counts[..i].contains(&counts[i])) {
            return Err(Error::Usage(format!(
                "--components: {} is there twice",
                counts[twice]
            )));
        }
        let numbered = |count| out.with_file_name(format!("{}-{count}.onnx", stem(out)));
        Ok(match counts.as_slice() {
            [_] => vec![out.clone()],
            _ => counts.iter().map(numbered).collect(),
        })
    }
}

impl Precision {
    const fn name(self) -> &'static str {
        match self {
            Self::F32 => "f32",
            Self::F64 => "f64",
        }
    }
}

fn stem(path: &Path) -> String {
    let stem = path.file_stem().unwrap_or_default();
    stem.to_string_lossy().into_owned()
}

/// Fits and writes a model for each number of components.
fn train<F: Real>(
    args: &Args,
    method: Method,
    outs: &[PathBuf],
    samples: &Samples,
    matrix: &Array2<f32>,
) -> Result<Vec<ModelResult>> {
    let (labels, classes) = (&samples.labels, samples.names.len());
    let form = (samples.template, samples.size);
    let analysed = Analysed::<F>::of(form, matrix.view(), labels, classes)?;
    let mut models = Vec::new();
    if outs.len() > 1 {
        args.common.say(format_args!(
            "trained on {} {} of {classes} people: {method}\n\n{:>10}  {:>5}  {:>8}  {:>17}",
            labels.len(),
            samples.template.plural(),
            "components",
            "dims",
            "bytes",
            "training rank-1 %"
        ));
    }
    for (&components, out) in args.components.iter().zip(outs) {
        let kept = usize::from(components).min(labels.len().saturating_sub(1));
        let recognizer = analysed.fit(Options {
            components: Components::Count(kept),
            method,
        })?;
        let training_rank1 = rank1(&recognizer, matrix, labels);
        let name = stem(out);
        let model = onnx::write(&recognizer, &name, &[]);
        let toml = Contract {
            name,
            ..contract(args, samples, method, components)
        }
        .to_toml()?;
        let (dims, bytes, percent) = (recognizer.dims(), model.len(), 100.0 * training_rank1);
        if outs.len() > 1 {
            args.common.say(format_args!(
                "{components:>10}  {dims:>5}  {bytes:>8}  {percent:>17.2}  {}",
                out.display()
            ));
        } else {
            args.common.say(format_args!(
                "{}: {bytes} bytes, {classes} people, {dims} dimensions, trained on {} {}, of which it recognizes {percent:.2} %",
                out.display(),
                labels.len(),
                samples.template.plural(),
            ));
        }
        let contract_at = Contract::path_beside(out);
        write_bytes(out, &model)?;
        write_bytes(&contract_at, toml.as_bytes())?;
        args.common.say(format_args!(
            "wrote {} and {}",
            out.display(),
            contract_at.display()
        ));
        models.push(ModelResult {
            file: InputFile {
                path: out.display().to_string(),
                sha256: sha256_of_bytes(&model),
            },
            components,
            dims,
            bytes,
            training_rank1,
        });
    }
    Ok(models)
}

/// Rank-1 on the samples that it was trained on.
fn rank1(recognizer: &LinearRecognizer, matrix: &Array2<f32>, labels: &[usize]) -> f64 {
    let hits = matrix
        .rows()
        .into_iter()
        .zip(labels)
        .filter(|(gei, label)| {
            let scores = recognizer.scores(recognizer.embed(&gei.to_vec()).view());
            closed_set(&scores.to_vec(), **label) == Outcome::Hit
        })
        .count();
    hits as f64 / labels.len() as f64
}

fn contract(args: &Args, samples: &Samples, method: Method, components: u16) -> Contract {
    let precision = match args.precision {
        Precision::F64 => "",
        Precision::F32 => " trained in f32",
    };
    let description = &samples.training.description;
    Contract {
        rows: samples.size.rows(),
        columns: samples.size.columns(),
        layout: Layout::of(samples.template),
        framing: samples.framing,
        template: samples.template,
        classes: samples.names.clone(),
        outputs: OutputNames {
            embedding: Some(onnx::EMBEDDING.into()),
            scores: Some(onnx::SCORES.into()),
        },
        training: Training {
            description: format!("PCA ({components}) + {method}{precision} on {description}"),
            ..samples.training.clone()
        },
        ..Contract::default()
    }
}

/// Each of these once, in the order of their first appearance.
fn each_once(all: impl Iterator<Item = usize>) -> Vec<usize> {
    let mut seen = HashSet::new();
    all.filter(|one| seen.insert(*one)).collect()
}

/// Each of these once, rising.
fn sorted<T: Ord>(all: impl Iterator<Item = T>) -> Vec<T> {
    all.collect::<BTreeSet<T>>().into_iter().collect()
}

/// Samples drawn here, from a pack or from the built-in cohort.
fn from_walks(args: &Args) -> Result<Samples> {
    let views = args.views.views("side")?;
    let settings = args.draw.settings(args.common.seed)?;
    let (template, size) = (settings.template, settings.size);
    if template == Template::Silhouettes {
        return Err(Error::Usage(
            "--template silhouettes: these recognizers take one image or vector of each cycle"
                .into(),
        ));
    }
    let augmentation = args.augment.augmentation()?;
    augmentation.check(template, size)?;
    let source = args.source.load()?;
    let pack = Pack::parse(&source.bytes).map_err(|error| Error::Failed(error.to_string()))?;
    let walks = args.source.choose(&pack)?;
    let all: Vec<_> = pack.walks().collect();
    let people = each_once(walks.iter().map(|&walk| all[walk].subject));
    let cycles = args.cycles.unwrap_or(CYCLES);
    let jobs = jobs(&pack, &walks, 0..cycles)?;
    let (mut numbers, mut labels) = (Vec::new(), Vec::new());
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
            for bytes in &swept.templates {
                let added = append_varied(bytes, (size, augmentation), &mut numbers);
                labels.extend(std::iter::repeat_n(label, added));
            }
            Ok(())
        },
    )?;
    let names = sorted(walks.iter().map(|&walk| all[walk].name));
    let mut header = stated(Header::new("train", args.common.seed), &settings)
        .with("pack", source.name.as_str())
        .with("walks", names.join(","))
        .with("cycles", cycles)
        .with("views", views.name.as_str());
    header = stated_augmentation(header, augmentation);
    header.inputs = source.inputs;
    let subjects: Vec<_> = pack.subjects().collect();
    Ok(Samples {
        training: Training {
            description: format!(
                "{} of {}, variations 0 to {}, {} viewpoints, seed {}, raster {}{}{}",
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
                described(augmentation),
            ),
            viewpoints: views
                .list
                .iter()
                .map(|view| [f64::from(view.azimuth_deg), f64::from(view.elevation_deg)])
                .collect(),
            subjects: Vec::new(),
            walks: names.iter().map(|&name| name.to_owned()).collect(),
            cycles: sorted(walks.iter().map(|&walk| u32::from(all[walk].cycle))),
            variations: (0..cycles).collect(),
            seed: args.common.seed,
        },
        numbers,
        template,
        size,
        framing: settings.framing,
        labels,
        names: people
            .iter()
            .map(|&p| subjects[p].name.to_owned())
            .collect(),
        header,
    })
}

/// All of a dataset's templates.
fn from_dataset(args: &Args, path: &Path) -> Result<Samples> {
    let names = [args.source.subjects.as_slice(), &args.source.walks];
    args.draw
        .refuse_for_folders(names, args.cycles, &args.views)?;
    let dataset = Dataset::open(path)?;
    let (template, size) = (dataset.template(), dataset.size());
    let augmentation = args.augment.augmentation()?;
    augmentation.check(template, size)?;
    let settings = &dataset.manifest().header.settings;
    if augmentation != Augmentation::default() && settings.contains_key("augment") {
        return Err(Error::Usage(format!(
            "--augment: {} is augmented already",
            path.display()
        )));
    }
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
    let walks = sorted(rows.iter().map(|row: &IndexRow| row.walk.clone()));
    let (mut numbers, mut labels_of_all) = (Vec::new(), Vec::new());
    for (bytes, &label) in dataset.templates().zip(&labels) {
        let added = append_varied(bytes, (size, augmentation), &mut numbers);
        labels_of_all.extend(std::iter::repeat_n(label, added));
    }
    let header = Header::new("train", args.common.seed);
    let mut header = stated_augmentation(header, augmentation);
    if template != Template::Gei {
        header = header.with("template", template.name());
    }
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
                "the {} {} of {}{}",
                labels.len(),
                template.plural(),
                path.display(),
                described(augmentation)
            ),
            viewpoints,
            subjects: Vec::new(),
            walks,
            cycles: sorted(rows.iter().map(|row| row.cycle)),
            variations: sorted(rows.iter().map(|row| row.variation)),
            seed: rows.first().map_or(0, |row| row.seed),
        },
        numbers,
        template,
        size,
        framing: framing.unwrap_or_default(),
        labels: labels_of_all,
        names,
        header,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn people_whose_walks_are_not_side_by_side_are_one_class_each() {
        assert_eq!(each_once([2, 0, 2, 2, 1, 0].into_iter()), [2, 0, 1]);
        assert_eq!(sorted([2, 0, 2, 1, 0].into_iter()), [0, 1, 2]);
    }
}
