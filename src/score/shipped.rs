//! The models that come with EdgeGait, in the program itself.

use super::{Contract, Model};
use crate::error::Result;
use std::path::Path;

/// Name, graph and contract of each; `models/README.md` has a card a model.
const SHIPPED: [(&str, &[u8], &str); 2] = [
    (
        "side",
        include_bytes!("../../models/side.onnx"),
        include_str!("../../models/side.toml"),
    ),
    (
        "spread",
        include_bytes!("../../models/spread.onnx"),
        include_str!("../../models/spread.toml"),
    ),
];

/// All of them, in the order in which results list them.
///
/// # Errors
/// Never, for the models shipped.
pub fn models() -> Result<Vec<Model>> {
    SHIPPED
        .into_iter()
        .map(|(name, bytes, contract)| {
            let path = format!("models/{name}.onnx");
            let contract = Contract::parse(Path::new(&format!("models/{name}.toml")), contract)?;
            Model::from_bytes(path, bytes, contract)
        })
        .collect()
}
