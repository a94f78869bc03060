//! `edgegait quantize`: exports a linear recognizer with 8-bit weights, for firmware.

use super::args::{Common, FileArgs, ViewArgs};
use super::drawing::DrawArgs;
use super::outputs::{Output, OutputKind};
use super::recognizers::with_contracts;
use super::runtime::RuntimeArgs;
use super::trial::try_out;
use super::walks::{SelectionArgs, SourceArgs};
use crate::dataset::sequences::{Form, PackWalks, SequenceSource};
use crate::draw::sweep::{Settings, View};
use crate::error::{Error, Result};
use crate::evaluate::contest::training_views;
use crate::evaluate::eight_bit::Agreement;
use crate::evaluate::protocol::Protocol;
use crate::files::text_table::Column::Left;
use crate::files::text_table::Table;
use crate::files::{InputFile, ResultHeader, sha256_of_bytes, write_bytes};
use crate::inference::{AffineScores, Contract, GeiForm, shipped};
use edgegait_core::linear::LinearRecognizer;
use edgegait_core::pack::Pack;
use serde::Serialize;
use std::fmt;
use std::path::PathBuf;

/// Export a linear recognizer of GEIs with 8-bit weights, which firmware reads in place
#[derive(Debug, clap::Args)]
#[command(
    mut_arg("walks", |walks| walks.help("Only these walks, by name [default: the training walks of the contract]")),
    after_help = "Examples:\n  edgegait quantize models/spread.onnx --out spread.egr\n  edgegait quantize mine.onnx --pack cohort.egp --raster rows --cycles 8 --out mine.egr\n\nThe file's answers are compared with the model's on unseen variations of walks."
)]
pub(super) struct QuantizeArgs {
    /// A model whose class scores are an affine function of a GEI, with its contract (.toml)
    /// beside it
    #[arg(value_name = "MODEL")]
    model: PathBuf,
    /// Where to write the recognizer
    #[arg(long, value_name = "PATH", default_value = "recognizer.egr")]
    out: PathBuf,
    /// Pack of the walks on which answers are compared [default: the built-in cohort]
    #[arg(long, value_name = "PACK")]
    pack: Option<PathBuf>,
    #[command(flatten)]
    selection: SelectionArgs,
    /// Cycles of each walk on which answers are compared, from variation 1000 on, which training
    /// never uses
    #[arg(long, value_name = "N", default_value_t = 4, value_parser = clap::value_parser!(u32).range(1..=1000))]
    cycles: u32,
    #[command(flatten)]
    runtime: RuntimeArgs,
    #[command(flatten)]
    views: ViewArgs,
    #[command(flatten)]
    draw: DrawArgs,
    #[command(flatten)]
    pub common: Common,
}

/// The results of the command.
#[derive(Serialize)]
struct QuantizeResults {
    #[serde(flatten)]
    header: ResultHeader,
    file: InputFile,
    bytes: usize,
    classes: usize,
    weights: usize,
    /// The greatest difference between the model's scores and an affine function, as a share of the
    /// effect of pixels on the scores.
    affine_deviation: f64,
    #[serde(flatten)]
    agreement: Agreement,
}

/// Runs the subcommand.
pub(super) fn run(args: &QuantizeArgs) -> Result<()> {
    args.check_out()?;
    let runtime = args.runtime.runtime()?;
    let model = shipped::open(&args.model)?;
    let contract = model.contract();
    let form = GeiForm::from_contract(contract)?;
    let settings = args.draw.settings_for(contract, args.common.seed)?;
    let views = if args.views.is_given() {
        args.views.views("side")?.list
    } else {
        training_views(contract)?
    };
    try_out(&model, &runtime)?;
    let recognizer = runtime.load(&model)?;
    let scores = AffineScores::measure(recognizer.as_ref(), args.common.seed)?;
    let bytes = form.write(&scores.map, &contract.classes)?;
    let quantized = LinearRecognizer::parse(&bytes)
        .map_err(|error| Error::input(&args.out, error.to_string()))?;

    let source_args = args.source(contract);
    let source = source_args.load(&args.common)?;
    let mut header = ResultHeader::new("quantize", args.common.seed)
        .drawn(&settings)
        .with("runtime", runtime.name().name)
        .with("pack", source.name.as_str())
        .with("walks", source_args.selection.walks.join(","))
        .with("viewpoints", views.len())
        .with("cycles", args.cycles);
    header.inputs = model.inputs()?;
    header.inputs.extend(source.inputs.iter().cloned());
    header.warnings.extend(model.warnings());
    let pack = Pack::parse(&source.bytes)?;
    let walks = source_args.choose(&pack)?;
    let (source, shown) = probes(&pack, &walks, &views, settings, args.cycles)?;
    let agreement = Agreement::measure(recognizer.as_ref(), &quantized, &source, &shown)?;

    let results = QuantizeResults {
        header,
        file: InputFile {
            path: args.out.display().to_string(),
            sha256: sha256_of_bytes(&bytes),
        },
        bytes: bytes.len(),
        classes: quantized.classes(),
        weights: quantized.size().pixels(),
        affine_deviation: scores.deviation,
        agreement,
    };
    args.common.say(&results);
    args.common.say_warnings(&results.header.warnings);
    write_bytes(&args.out, &bytes)?;
    args.common
        .say(format_args!("wrote {}", args.out.display()));
    args.common.write_json(&results)
}

/// Returns unseen cycles of walks, and the form of the inputs.
fn probes<'a>(
    pack: &'a Pack<'a>,
    walks: &[usize],
    views: &[View],
    settings: Settings,
    cycles: u32,
) -> Result<(SequenceSource<'a>, Form)> {
    let made = Protocol::named("closed-set")?.made(cycles)?;
    let cycles = PackWalks::made(pack, walks, &made, &[])?;
    let form = Form {
        settings,
        frames: None,
    };
    Ok((
        SequenceSource::Walks(cycles.seen(&[], settings.seed, |_| views.to_vec())),
        form,
    ))
}

impl QuantizeArgs {
    /// Returns the files that the command reads and writes.
    pub(super) fn files(&self) -> FileArgs {
        let model = with_contracts(std::slice::from_ref(&self.model)).into_iter();
        FileArgs {
            inputs: model
                .chain(self.pack.clone())
                .chain(self.views.file())
                .collect(),
            outputs: vec![Output::new("--out", &self.out, OutputKind::Recognizer)],
        }
    }

    /// Checks the name of the output, before any work is done.
    fn check_out(&self) -> Result<()> {
        let out = &self.out;
        if out.extension().is_none_or(|extension| extension != "egr") {
            return Err(Error::Usage(format!(
                "--out {}: expected a name that ends in .egr",
                out.display()
            )));
        }
        Ok(())
    }

    /// Returns the source of the walks on which answers are compared.
    fn source(&self, contract: &Contract) -> SourceArgs {
        let mut selection = self.selection.clone();
        if selection.walks.is_empty() {
            selection.walks.clone_from(&contract.training.walks);
        }
        SourceArgs::new(self.pack.clone(), selection)
    }
}

impl fmt::Display for QuantizeResults {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "{}: {} bytes, {} classes of {} weights\n",
            self.file.path, self.bytes, self.classes, self.weights
        )?;
        let found = &self.agreement;
        let mut table = Table::new(&[Left(0)]);
        let same = format!("{} of {}", found.equal_answers, found.probes);
        table.row(["same answers as the model", &same]);
        if let (Some(model), Some(int8)) = (found.rank1, found.rank1_int8) {
            let [int8, model] = [int8, model].map(|rate| format!("{:.2}", 100.0 * rate));
            table.row(["rank-1 %", &format!("{int8} (the model: {model})")]);
        }
        let difference = format!(
            "at most {:.3}, mean {:.3} (mean lead of the best score: {:.3})",
            found.greatest_difference, found.mean_difference, found.mean_lead
        );
        table.row(["score difference", &difference]);
        f.write_str(table.to_string().trim_end())
    }
}
