//! `edgegait train`: fit a recognizer and export it as ONNX.

mod mix;
mod opened;
mod part;
mod sources;

use super::args::{Common, Files, ViewArgs};
use super::augment::AugmentArgs;
use super::cutting::CuttingArgs;
use super::drawing::DrawArgs;
use super::layout::LayoutArgs;
use super::outputs::{Kind, Output};
use super::source::SelectionArgs;
use crate::dataset::{Header, InputFile, sha256_of_bytes, write_bytes};
use crate::error::{Error, Result};
use crate::evaluate::rank::{Outcome, closed_set};
use crate::score::Contract;
use crate::table::Column::{Left, Right};
use crate::table::Table;
use crate::template::augment::Augmentation;
use crate::train::{Analysed, Components, LinearRecognizer, Method, Options, Real, Samples, onnx};
use mix::MixArgs;
use serde::Serialize;
use sources::{Gathered, SourceResult, gathered};
use std::path::{Path, PathBuf};

/// Train PCA + LDA or PCA + SVM recognizers and export each as one ONNX graph of plain operators
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  edgegait train --out side.onnx                      # built-in cohort, side view\n  edgegait train --azimuth-deg 0,45,90,135,180 --elevation-deg 0,30,60 --out spread.onnx\n  edgegait train dataset --out mine.onnx              # a dataset that `sweep` wrote\n  edgegait train tree --fps 30 --partition p.json     # silhouettes, cut into gait cycles\n  edgegait train real synthetic.egp --mix real:0.7    # several sources, of one all, of the other a share\n  edgegait train --template geni --augment flip,crop --out geni.onnx\n  edgegait train --method svm --components 5,10,20,50 # recognizer-5.onnx, recognizer-10.onnx ..."
)]
pub(super) struct Args {
    /// Packs, datasets and trees of silhouettes (<person>/<take>/<view>/): of several, people of one
    /// name are one class. Names of people and walks, and viewpoints, choose from each
    /// [default: the built-in cohort of 26 people]
    #[arg(value_name = "PACK|DATASET|TREE")]
    sources: Vec<PathBuf>,
    #[command(flatten)]
    mix: MixArgs,
    #[command(flatten)]
    selection: SelectionArgs,
    /// Where to write the model; its contract goes beside it as .toml
    #[arg(long, value_name = "PATH", default_value = "recognizer.onnx")]
    out: PathBuf,
    /// Cycles of each walk to train on: the stored one, then seeded variations. `score` probes
    /// with variations from number 1000 on, which training never uses
    /// [default: 8]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1000))]
    cycles: Option<u32>,
    /// What tells people apart in the principal components: the nearest mean along linear
    /// discriminants; the same of templates and of their crops (--crop-steps, --crop-rows), in two
    /// parts (Han & Bhanu's real and synthetic templates); or linear support vector machines, one for
    /// each person against the rest
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
    /// Only people whom a partition trains with, of a tree, as OpenGait has them: a JSON file with
    /// TRAIN_SET and TEST_SET
    #[arg(long, value_name = "FILE.json")]
    partition: Option<PathBuf>,
    #[command(flatten)]
    cutting: CuttingArgs,
    #[command(flatten)]
    layout: LayoutArgs,
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
    RealSynthetic,
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
    #[serde(skip_serializing_if = "Vec::is_empty")]
    sources: Vec<SourceResult>,
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
pub(super) fn run(args: &Args) -> Result<()> {
    let method = args.method()?;
    let outs = args.outs()?;
    let Gathered {
        samples,
        header,
        sources,
    } = gathered(args)?;
    for source in &sources {
        args.common.say(source);
    }
    for warning in &header.warnings {
        args.common.say(format_args!("warning: {warning}"));
    }
    let counts: Vec<String> = args.components.iter().map(u16::to_string).collect();
    let header = header
        .with("components", counts.join(","))
        .with("method", method.to_string())
        .with("precision", args.precision.name());
    let models = match args.precision {
        Precision::F64 => train::<f64>(args, method, &outs, &samples)?,
        Precision::F32 => train::<f32>(args, method, &outs, &samples)?,
    };
    args.common.write_json(&Results {
        header,
        samples: samples.labels.len(),
        classes: samples.names.len(),
        sources,
        models,
    })
}

impl Args {
    /// What it reads and writes.
    pub(super) fn files(&self) -> Files {
        let outs = self.outs().unwrap_or_default().into_iter();
        Files {
            inputs: self
                .sources
                .iter()
                .cloned()
                .chain(self.views.file())
                .chain(self.partition.clone())
                .collect(),
            outputs: outs
                .map(|out| Output::new("--out", &out, Kind::Model))
                .collect(),
        }
    }

    /// What is made of each template before a method learns.
    fn augmentation(&self) -> Result<Augmentation> {
        match self.method {
            MethodArg::RealSynthetic => self.augment.without_crops(),
            MethodArg::Lda | MethodArg::Svm => self.augment.augmentation(),
        }
    }

    fn method(&self) -> Result<Method> {
        match (self.method, self.svm_c) {
            (MethodArg::Lda, None) => Ok(Method::LDA),
            (MethodArg::RealSynthetic, None) => Ok(Method::RealSynthetic {
                crops: self.augment.crops(),
            }),
            (MethodArg::Lda | MethodArg::RealSynthetic, Some(_)) => Err(Error::Usage(
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
) -> Result<Vec<ModelResult>> {
    let (labels, classes) = (&samples.labels, samples.names.len());
    let form = (samples.template, samples.size);
    let analysed = Analysed::<F>::of(form, samples.numbers.view(), labels, classes)?;
    let mut models = Vec::new();
    for (&components, out) in args.components.iter().zip(outs) {
        let kept = usize::from(components).min(labels.len().saturating_sub(1));
        let recognizer = analysed.fit(Options {
            components: Components::Count(kept),
            method,
        })?;
        let training_rank1 = rank1(&recognizer, samples);
        let name = stem(out);
        let model = onnx::write(&recognizer, &name, &[]);
        let precision = match args.precision {
            Precision::F64 => "",
            Precision::F32 => " trained in f32",
        };
        let contract = samples.contract(name, (components, method), precision);
        let toml = contract.to_toml()?;
        let (dims, bytes, percent) = (recognizer.dims(), model.len(), 100.0 * training_rank1);
        if outs.len() == 1 {
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
    if outs.len() > 1 {
        args.common.say(format_args!(
            "trained on {} {} of {classes} people: {method}\n\n{}",
            labels.len(),
            samples.template.plural(),
            table(&models).to_string().trim_end()
        ));
    }
    Ok(models)
}

fn table(models: &[ModelResult]) -> Table<'static> {
    let mut table = Table::new(&[Right(0), Right(5), Right(8), Right(0), Left(0)]);
    table.row("components|dims|bytes|training rank-1 %|model".split('|'));
    for model in models {
        table.row([
            model.components.to_string(),
            model.dims.to_string(),
            model.bytes.to_string(),
            format!("{:.2}", 100.0 * model.training_rank1),
            model.file.path.clone(),
        ]);
    }
    table
}

/// Rank-1 on the samples that it was trained on.
fn rank1(recognizer: &LinearRecognizer, samples: &Samples) -> f64 {
    let (rows, labels) = (samples.numbers.rows(), &samples.labels);
    let hits = rows
        .into_iter()
        .zip(labels)
        .filter(|(gei, label)| {
            let scores = recognizer.scores(recognizer.embed(&gei.to_vec()).view());
            closed_set(&scores.to_vec(), **label) == Outcome::Hit
        })
        .count();
    hits as f64 / labels.len() as f64
}
