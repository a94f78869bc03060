//! `edgegait train`: trains a recognizer and exports it as ONNX.

mod fitting;
mod mix;
mod opened_source;
mod samples;
mod sources;

use super::args::{Common, FileArgs, ViewArgs};
use super::augment::AugmentArgs;
use super::drawing::DrawArgs;
use super::layout::LayoutArgs;
use super::outputs::{Output, OutputKind};
use super::subspaces::SubspaceArgs;
use super::tree_cycles::CuttingArgs;
use super::walks::SelectionArgs;
use crate::draw::template::augment::Augmentation;
use crate::error::{Error, Result};
use crate::evaluate::rank1::{ProbeOutcome, closed_set};
use crate::files::text_table::Column::{Left, Right};
use crate::files::text_table::Table;
use crate::files::{InputFile, ResultHeader, sha256_of_bytes, write_bytes};
use crate::inference::Contract;
use crate::train::subspaces::{RandomSubspaces, SubspaceOptions};
use crate::train::view_transformation::ViewTransformation;
use crate::train::{
    Analysed, Components, LinearModel, Real, Samples, TrainMethod, TrainOptions, feature_choice,
    onnx,
};
use fitting::FittingMethod;
use mix::MixArgs;
use serde::Serialize;
use sources::{Gathered, SourceResult, gathered};
use std::path::{Path, PathBuf};

/// The default number of principal components.
const USUAL_COMPONENTS: u16 = 100;

/// Train recognizers and export each as one ONNX graph of plain operators
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  edgegait train --out side.onnx                      # built-in cohort, side view\n  edgegait train --azimuth-deg 0,45,90,135,180 --elevation-deg 0,30,60 --out spread.onnx\n  edgegait train dataset --out mine.onnx              # a dataset that `sweep` wrote\n  edgegait train tree --fps 30 --partition p.json     # silhouettes, cut into gait cycles\n  edgegait train real synthetic.egp --mix real:0.7    # several sources, one in part\n  edgegait train --template geni --augment flip,crop --out geni.onnx\n  edgegait train --method svm --components 5,10,20,50 # recognizer-5.onnx, recognizer-10.onnx ...\n  edgegait train --method gabor-subspaces --out gabor.onnx\n  edgegait train --method view-transformation --template frequency --azimuth-deg 0,45,90,135,180 --out vtm.onnx"
)]
pub(super) struct TrainArgs {
    /// Packs, datasets and trees of silhouettes (<person>/<take>/<view>/); people with the same
    /// name are one class. --subjects, --walks and the viewpoints choose from each
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
    /// Training method
    #[arg(long, value_name = "METHOD", default_value = "lda")]
    method: MethodArg,
    /// Number of principal components to keep, if the method uses them; with several numbers, a
    /// model NAME-N.onnx is written for each
    #[arg(long, value_name = "N[,N..]", default_values_t = [USUAL_COMPONENTS], value_delimiter = ',', value_parser = clap::value_parser!(u16).range(1..=4096))]
    components: Vec<u16>,
    /// Weight C of the training errors, for `--method svm`
    /// [default: 1]
    #[arg(long, value_name = "C")]
    svm_c: Option<f64>,
    #[command(flatten)]
    subspaces: SubspaceArgs,
    /// Floating-point type in which lda, real-synthetic and svm are computed; models are f32
    #[arg(long, value_name = "TYPE", default_value = "f64")]
    precision: Precision,
    /// Only the training people of a tree's partition, in OpenGait's format: a JSON file with
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
    /// The nearest mean along linear discriminants of the principal components
    Lda,
    /// LDA of templates and of their crops (--crop-steps, --crop-rows), in two parts (Han & Bhanu)
    RealSynthetic,
    /// Linear support vector machines on the principal components, one-versus-rest for each person
    Svm,
    /// Values of a template that vary more between people than within them (after Nandy et al.:
    /// row-width)
    FeatureChoice,
    /// Votes of discriminants in random subspaces of the GEIs' Gabor features (Guan & Li)
    GaborSubspaces,
    /// Templates transformed from the gallery's viewpoint to the probe's (Makihara et al.:
    /// frequency)
    ViewTransformation,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Precision {
    F32,
    F64,
}

/// The results of training.
#[derive(Serialize)]
struct TrainResults {
    #[serde(flatten)]
    header: ResultHeader,
    samples: usize,
    classes: usize,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    sources: Vec<SourceResult>,
    models: Vec<TrainedModel>,
}

/// A model that was written.
#[derive(Serialize)]
struct TrainedModel {
    #[serde(flatten)]
    file: InputFile,
    #[serde(skip_serializing_if = "Option::is_none")]
    components: Option<u16>,
    dims: usize,
    bytes: usize,
    #[serde(skip_serializing_if = "Option::is_none")]
    training_rank1: Option<f64>,
}

/// A model to write.
struct MadeModel {
    bytes: Vec<u8>,
    contract: Contract,
    components: Option<u16>,
    dims: usize,
    training_rank1: Option<f64>,
}

/// Runs the subcommand.
pub(super) fn run(args: &TrainArgs) -> Result<()> {
    let how = args.how()?;
    let outs = args.outs()?;
    let Gathered {
        samples,
        header,
        sources,
    } = gathered(args)?;
    for source in &sources {
        args.common.say(source);
    }
    args.common.say_warnings(&header.warnings);
    let header = header.with("method", how.said());
    let header = if how.has_components() {
        let counts: Vec<String> = args.components.iter().map(u16::to_string).collect();
        header.with("components", counts.join(","))
    } else {
        header
    };
    let header = match how {
        FittingMethod::Linear(_) => header.with("precision", args.precision.name()),
        _ => header,
    };
    let models = match (how, args.precision) {
        (FittingMethod::Linear(method), Precision::F64) => {
            linear::<f64>(args, method, &outs, &samples)?
        }
        (FittingMethod::Linear(method), Precision::F32) => {
            linear::<f32>(args, method, &outs, &samples)?
        }
        (FittingMethod::FeatureChoice, _) => vec![feature_choice(args, &outs[0], &samples)?],
        (FittingMethod::GaborSubspaces(subspaces), _) => {
            vec![gabor_subspaces(args, &outs[0], &samples, subspaces)?]
        }
        (FittingMethod::ViewTransformation, _) => view_transformation(args, &outs, &samples)?,
    };
    if models.len() > 1 {
        args.common.say(format_args!(
            "trained on {} {} of {} people: {}\n\n{}",
            samples.labels.len(),
            samples.template.plural(),
            samples.names.len(),
            how.said(),
            table(&models).to_string().trim_end()
        ));
    }
    args.common.write_json(&TrainResults {
        header,
        samples: samples.labels.len(),
        classes: samples.names.len(),
        sources,
        models,
    })
}

impl TrainArgs {
    /// Returns the files that the command reads and writes.
    pub(super) fn files(&self) -> FileArgs {
        let outs = self.outs().unwrap_or_default().into_iter();
        FileArgs {
            inputs: self
                .sources
                .iter()
                .cloned()
                .chain(self.views.file())
                .chain(self.partition.clone())
                .collect(),
            outputs: outs
                .map(|out| Output::new("--out", &out, OutputKind::Model))
                .collect(),
        }
    }

    /// Returns the augmentation of training templates.
    fn augmentation(&self) -> Result<Augmentation> {
        match self.method {
            MethodArg::RealSynthetic => self.augment.without_crops(),
            _ => self.augment.augmentation(),
        }
    }

    fn how(&self) -> Result<FittingMethod> {
        let usage = |text: String| Err(Error::Usage(text));
        let method = self.method;
        if self.svm_c.is_some() && method != MethodArg::Svm {
            return usage(
                "--svm-c is the weight of errors of --method svm: other methods have none".into(),
            );
        }
        if self.subspaces.is_given() && method != MethodArg::GaborSubspaces {
            return usage(
                "--subspaces, --eigenvectors and --discriminants need --method gabor-subspaces"
                    .into(),
            );
        }
        let how = match method {
            MethodArg::Lda => FittingMethod::Linear(TrainMethod::LDA),
            MethodArg::RealSynthetic => FittingMethod::Linear(TrainMethod::RealSynthetic {
                crops: self.augment.crops(),
            }),
            MethodArg::Svm => match self.svm_c.unwrap_or(1.0) {
                c if c > 0.0 && c.is_finite() => FittingMethod::Linear(TrainMethod::Svm { c }),
                c => return usage(format!("--svm-c: expected a C above 0, found {c}")),
            },
            MethodArg::FeatureChoice => FittingMethod::FeatureChoice,
            MethodArg::GaborSubspaces => {
                FittingMethod::GaborSubspaces(self.subspaces.subspaces(self.common.seed))
            }
            MethodArg::ViewTransformation => FittingMethod::ViewTransformation,
        };
        let is_linear = matches!(how, FittingMethod::Linear(_));
        if !how.has_components() && self.components != [USUAL_COMPONENTS] {
            return usage("--components: this method has no principal components".into());
        }
        if !is_linear && self.precision != Precision::F64 {
            return usage("--precision applies to lda, real-synthetic and svm".into());
        }
        if matches!(how, FittingMethod::ViewTransformation) && self.augmentation()?.flip {
            return usage(
                "--augment flip: a mirrored template shows another viewpoint, and --method view-transformation learns viewpoints"
                    .into(),
            );
        }
        Ok(how)
    }

    /// Returns the path of the model for each number of components.
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
                "--components: {} appears twice",
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
fn linear<F: Real>(
    args: &TrainArgs,
    method: TrainMethod,
    outs: &[PathBuf],
    samples: &Samples,
) -> Result<Vec<TrainedModel>> {
    let (labels, classes) = (&samples.labels, samples.names.len());
    let analysed = Analysed::<F>::analyse(
        samples.template,
        samples.size,
        samples.numbers.view(),
        labels,
        classes,
    )?;
    let each = args.components.iter().zip(outs);
    let model = |(&components, out): (&u16, &PathBuf)| {
        let kept = usize::from(components).min(labels.len().saturating_sub(1));
        let recognizer = analysed.fit(TrainOptions {
            components: Components::Count(kept),
            method,
        })?;
        let precision = match args.precision {
            Precision::F64 => "",
            Precision::F32 => " trained in f32",
        };
        let how = format!("PCA ({components}) + {method}{precision}");
        let made = MadeModel::linear(&recognizer, samples, stem(out), &how);
        write(args, out, samples, made.with(components))
    };
    each.map(model).collect()
}

fn feature_choice(args: &TrainArgs, out: &Path, samples: &Samples) -> Result<TrainedModel> {
    let recognizer = feature_choice::fit(samples)?;
    let how = feature_choice::described(&recognizer);
    let made = MadeModel::linear(&recognizer, samples, stem(out), &how);
    write(args, out, samples, made)
}

fn gabor_subspaces(
    args: &TrainArgs,
    out: &Path,
    samples: &Samples,
    subspaces: SubspaceOptions,
) -> Result<TrainedModel> {
    let fitted = RandomSubspaces::fit(samples, subspaces)?;
    let name = stem(out);
    let (bytes, dims) = (fitted.write(&name), fitted.dims());
    let made = MadeModel::embeddings(bytes, fitted.contract(samples, name), dims);
    write(args, out, samples, made)
}

fn view_transformation(
    args: &TrainArgs,
    outs: &[PathBuf],
    samples: &Samples,
) -> Result<Vec<TrainedModel>> {
    let each = args.components.iter().zip(outs);
    let model = |(&components, out): (&u16, &PathBuf)| {
        let fitted = ViewTransformation::fit(samples, Components::Count(components.into()))?;
        let name = stem(out);
        let (bytes, dims) = (fitted.write(&name), fitted.dims());
        let made = MadeModel::embeddings(bytes, fitted.contract(samples, name), dims);
        write(args, out, samples, made.with(components))
    };
    each.map(model).collect()
}

impl MadeModel {
    fn linear(recognizer: &LinearModel, samples: &Samples, name: String, how: &str) -> Self {
        Self {
            bytes: onnx::write(recognizer, &name, &[]),
            contract: samples.contract(name, how),
            components: None,
            dims: recognizer.dims(),
            training_rank1: Some(rank1(recognizer, samples)),
        }
    }

    /// Creates a model without class scores.
    const fn embeddings(bytes: Vec<u8>, contract: Contract, dims: usize) -> Self {
        Self {
            bytes,
            contract,
            components: None,
            dims,
            training_rank1: None,
        }
    }

    fn with(self, components: u16) -> Self {
        Self {
            components: Some(components),
            ..self
        }
    }
}

/// Writes a model and its contract.
fn write(args: &TrainArgs, out: &Path, samples: &Samples, made: MadeModel) -> Result<TrainedModel> {
    let (bytes, people) = (made.bytes.len(), samples.names.len());
    let recognized = made.training_rank1.map_or(String::new(), |rank1| {
        format!(", of which it recognizes {:.2} %", 100.0 * rank1)
    });
    if args.components.len() == 1 {
        args.common.say(format_args!(
            "{}: {bytes} bytes, {people} people, {} dimensions, trained on {} {}{recognized}",
            out.display(),
            made.dims,
            samples.labels.len(),
            samples.template.plural(),
        ));
    }
    let contract_at = Contract::path_beside(out);
    let toml = made.contract.to_toml()?;
    write_bytes(out, &made.bytes)?;
    write_bytes(&contract_at, toml.as_bytes())?;
    args.common.say(format_args!(
        "wrote {} and {}",
        out.display(),
        contract_at.display()
    ));
    Ok(TrainedModel {
        file: InputFile {
            path: out.display().to_string(),
            sha256: sha256_of_bytes(&made.bytes),
        },
        components: made.components,
        dims: made.dims,
        bytes,
        training_rank1: made.training_rank1,
    })
}

fn table(models: &[TrainedModel]) -> Table<'static> {
    let mut table = Table::new(&[Right(0), Right(5), Right(8), Right(0), Left(0)]);
    table.row("components|dims|bytes|training rank-1 %|model".split('|'));
    for model in models {
        table.row([
            model
                .components
                .map_or_else(String::new, |count| count.to_string()),
            model.dims.to_string(),
            model.bytes.to_string(),
            model
                .training_rank1
                .map_or_else(String::new, |rank1| format!("{:.2}", 100.0 * rank1)),
            model.file.path.clone(),
        ]);
    }
    table
}

/// Returns rank-1 on the training samples.
fn rank1(recognizer: &LinearModel, samples: &Samples) -> f64 {
    let (rows, labels) = (samples.numbers.rows(), &samples.labels);
    let hits = rows
        .into_iter()
        .zip(labels)
        .filter(|(gei, label)| {
            let scores = recognizer.scores(recognizer.embed(&gei.to_vec()).view());
            closed_set(&scores.to_vec(), **label) == ProbeOutcome::Hit
        })
        .count();
    hits as f64 / labels.len() as f64
}
