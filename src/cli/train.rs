//! `edgegait train`: fit a recognizer and export it as ONNX.

mod samples;

use super::args::{Common, Files, ViewArgs};
use super::augment::AugmentArgs;
use super::drawing::DrawArgs;
use super::outputs::{Kind, Output};
use super::source::SourceArgs;
use crate::dataset::{Header, InputFile, sha256_of_bytes, write_bytes};
use crate::error::{Error, Result};
use crate::evaluate::rank::{Outcome, closed_set};
use crate::score::{Contract, Layout, OutputNames, Training};
use crate::train::{Analysed, Components, LinearRecognizer, Method, Options, Real, onnx};
use ndarray::Array2;
use samples::{Samples, from_dataset, from_walks};
use serde::Serialize;
use std::path::{Path, PathBuf};

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
    let matrix = Array2::from_shape_vec((samples.labels.len(), columns), numbers)?;
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
