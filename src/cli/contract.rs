//! `edgegait contract`: writes the contract of a model, for the user to check.

use super::args::{Common, FileArgs};
use super::outputs::{Output, OutputKind};
use crate::error::{Result, visible_name};
use crate::files::{ResultHeader, write_bytes};
use crate::inference::{Contract, Model, list_of};
use serde::Serialize;
use std::path::{Path, PathBuf};

/// Write the contract (.toml) of a model of your own, every key explained
///
/// Keys that follow from the model's file are filled in; the others are marked "CHECK THIS".
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  edgegait contract mine.onnx                  # writes mine.toml\n  edgegait contract mine.onnx --out -          # to standard output"
)]
pub(super) struct ContractArgs {
    /// An ONNX model
    #[arg(value_name = "MODEL")]
    model: PathBuf,
    /// Where to write the contract; "-" is standard output [default: beside the model, where
    /// commands expect it]
    #[arg(long, value_name = "PATH")]
    out: Option<PathBuf>,
    #[command(flatten)]
    pub common: Common,
}

/// Runs the subcommand.
pub(super) fn run(args: &ContractArgs) -> Result<()> {
    let model = Model::open(&args.model)?;
    let graph = model.graph();
    let about = format!(
        "{}: takes {}; gives {}.",
        args.model.display(),
        list_of(&graph.inputs),
        list_of(&graph.outputs)
    );
    let contract = model.stated_contract();
    let text = contract.explained(&visible_name(&about))?;
    let out = args.out();
    let mut header = ResultHeader::new("contract", args.common.seed);
    header.inputs = model.inputs()?;
    header.warnings = model.warnings();
    if out == Path::new("-") {
        args.common.put(text.trim_end());
    } else {
        write_bytes(&out, text.as_bytes())?;
        args.common.say_warnings(&header.warnings);
        args.common.say(format_args!("wrote {}", out.display()));
    }
    args.common.write_json(&ContractResults {
        header,
        contract: &contract,
    })
}

/// The results of the command.
#[derive(Serialize)]
struct ContractResults<'a> {
    #[serde(flatten)]
    header: ResultHeader,
    contract: &'a Contract,
}

impl ContractArgs {
    fn out(&self) -> PathBuf {
        let beside = || Contract::path_beside(&self.model);
        self.out.clone().unwrap_or_else(beside)
    }

    /// Returns the files that the command reads and writes.
    pub(super) fn files(&self) -> FileArgs {
        let out = self.out();
        let output =
            (out != Path::new("-")).then(|| Output::new("--out", &out, OutputKind::Explained));
        FileArgs {
            inputs: vec![self.model.clone()],
            outputs: output.into_iter().collect(),
        }
    }
}
