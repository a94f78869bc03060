//! Models and contracts: parsing, and all checks before a runtime sees them.
//!
//! A runtime is not given mutated models here: the command runs each once in a process of its own,
//! because it may end that process.

use super::{Target, below, contents, target};
use crate::chance::Chance;
use crate::data::fixtures;
use crate::mutators::{bytes, onnx, text};
use edgegait::{Contract, Model};
use std::fs;
use std::path::Path;

pub fn targets(folder: &Path) -> Vec<Target> {
    let mut small = below(&fixtures().join("faults/onnx"), &["onnx"], 1 << 20);
    small.extend(below(&fixtures().join("parity"), &["onnx"], 1 << 20));
    // Several layers with convolutions, and quantized ones.
    small.push("models/gei-small.onnx".into());
    small.push("models/side.onnx".into());
    let stated = below(Path::new("models"), &["toml"], 1 << 14);
    let stated: Vec<_> = stated
        .into_iter()
        .filter(|path| !path.starts_with("models/recipe"))
        .collect();
    let at = crate::run::fresh(&folder.join("onnx"));
    let contracts: Vec<Vec<u8>> = contents(stated.clone());
    let onnx_read = move |bytes: &[u8], chance: &mut Chance| {
        let (model, contract) = (at.join("m.onnx"), at.join("m.toml"));
        fs::write(&model, bytes)?;
        let _ = fs::remove_file(&contract);
        if chance.is(30) {
            fs::write(&contract, &contracts[chance.below(contracts.len())])?;
        }
        let model = Model::open(&model)?;
        let _ = (
            model.warnings(),
            model.batching(),
            model.stated_contract(),
            model.at_once(),
        );
        let _ = format!("{:?}", model.graph());
        Ok(())
    };
    let contract_read = |bytes: &[u8], _: &mut Chance| {
        let contract = Contract::parse(Path::new("a.toml"), std::str::from_utf8(bytes)?)?;
        let again = contract.to_toml()?;
        Contract::parse(Path::new("again.toml"), &again).expect("a contract of our own");
        let _ = (contract.size(), contract.frames_in(1500, 1));
        let mut numbers = Vec::new();
        contract.feed(&[0, 127, 255], &mut numbers);
        assert!(
            numbers.iter().all(|number: &f32| number.is_finite()),
            "an input"
        );
        Ok(())
    };
    vec![
        target(
            "onnx",
            60,
            contents(small),
            &[onnx::onnx],
            &bytes::ALL,
            onnx_read,
        ),
        target(
            "contract",
            40,
            contents(stated),
            &text::ALL,
            &[],
            contract_read,
        ),
    ]
}
