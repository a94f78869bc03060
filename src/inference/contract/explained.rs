//! A contract for people to edit, with every key explained.

use std::fmt::Write as _;

use super::Contract;
use crate::error::{InferenceError, Result, visible_toml};

/// A key of a contract.
struct ContractKey {
    key: &'static str,
    /// Its explanation.
    remark: &'static str,
    /// The line that is written if the contract leaves it out.
    absent: &'static str,
}

const fn key(key: &'static str, remark: &'static str, absent: &'static str) -> ContractKey {
    ContractKey {
        key,
        remark,
        absent,
    }
}

const KEYS: [ContractKey; 16] = [
    key(
        "name",
        "Name of the recognizer in results. Empty: the name of the model's file.",
        "",
    ),
    key(
        "template",
        "What one input is: \"gei\", \"silhouettes\" (a sequence), \"mei\", \"mhi\", \"msi\", \"ghi\", \"geni\",\n\
         \"frequency\" (three images), \"kfd\" or \"row-width\" (vectors).",
        "",
    ),
    key(
        "layout",
        "Order of the input's axes: N inputs, T frames, C channels, H rows, W columns, D numbers. Images: \"NCHW\",\n\
         \"NHWC\", \"NHW\", \"ND\" (row by row). Silhouettes: \"NTHW\", \"NTCHW\", \"NCTHW\". Vectors: \"ND\".",
        "",
    ),
    key(
        "rows",
        "Rows and columns of a silhouette: 50x30, 64x44 or 64x64.",
        "",
    ),
    key("columns", "", ""),
    key(
        "frames",
        "Frames of one sequence of silhouettes, if the model needs a fixed number.",
        "# frames = 30",
    ),
    key(
        "framing",
        "How figures were framed in training: \"height\" (each fills the rows), \"box\" (each is stretched to\n\
         fill rows and columns), \"cycle\" (one scale for a gait cycle) or \"camera\" (as a sensor sees it). CHECK THIS.",
        "",
    ),
    key(
        "input_range",
        "Values of background and foreground: \"0..1\", \"0..255\" or \"-1..1\". CHECK THIS.",
        "",
    ),
    key(
        "mean",
        "Subtracted from each value in that range: one number, or one for each channel.",
        "# mean = 0.5",
    ),
    key(
        "std",
        "The result is divided by this: one number, or one for each channel.",
        "# std = 0.5",
    ),
    key(
        "channels",
        "Number of equal channels that repeat an image, for networks that take colour images.",
        "# channels = 3",
    ),
    key(
        "view_input",
        "Name of a second input, f32 [N, 2]: azimuth and elevation of each input's viewpoint, in degrees.",
        "# view_input = \"view\"",
    ),
    key(
        "distance",
        "How embeddings are compared: \"euclidean\" or \"cosine\" (of embeddings in parts: the mean over the parts),\n\
         \"votes\" (each part votes for the nearest person) or \"view\" (only the part of the probe's viewpoint counts;\n\
         parts are in the order of training.viewpoints). CHECK THIS.",
        "distance = \"euclidean\"",
    ),
    key(
        "classes",
        "The people that the class scores stand for, in the order of the scores. Empty: people are enrolled, and the\n\
         nearest embedding decides.",
        "",
    ),
    key("outputs", "", ""),
    key("training", "", ""),
];

const OUTPUTS: [ContractKey; 2] = [
    key(
        "embedding",
        "The output that is compared by distance, f32 [N, numbers] or [N, numbers, parts].",
        "# embedding = \"embedding\"",
    ),
    key(
        "scores",
        "The output whose highest number decides, f32 [N, classes].",
        "# scores = \"scores\"",
    ),
];

const TRAINING: [ContractKey; 8] = [
    key("description", "Data, recipe and seed, in words.", ""),
    key(
        "viewpoints",
        "Training viewpoints, [azimuth, elevation] in degrees: azimuth 90 is the walker's left side, elevation 0 level.\n\
         People are enrolled from these, unless a protocol states others. Empty: from [90, 0].",
        "",
    ),
    key(
        "subjects",
        "People in the training data, if they are not the classes: edgegait score warns about probes that the model was trained on.",
        "# subjects = [\"somebody\"]",
    ),
    key(
        "walks",
        "Training walks of an EdgeGait pack, the numbers of their cycles, and the numbers of seeded variations.",
        "",
    ),
    key("cycles", "", ""),
    key("variations", "", ""),
    key("seed", "The seed of the variations.", ""),
    key("seeds", "Further seeds of variations.", "# seeds = [2]"),
];

impl Contract {
    /// Returns the contract as TOML with a remark at each key, including keys that it leaves out.
    /// `about` is the first line, which describes the model.
    ///
    /// # Errors
    /// If a number cannot be written as TOML.
    pub fn explained(&self, about: &str) -> Result<String> {
        let table = toml::Table::try_from(self).map_err(InferenceError::from)?;
        let mut text = format!("# {about}\n");
        add(&mut text, &table, &KEYS);
        for (name, keys) in [("outputs", &OUTPUTS[..]), ("training", &TRAINING)] {
            // Writing to a string cannot fail.
            let _ = write!(text, "\n[{name}]\n");
            if let Some(inner) = table.get(name).and_then(toml::Value::as_table) {
                add(&mut text, inner, keys);
            }
        }
        Ok(text)
    }
}

fn add(text: &mut String, table: &toml::Table, keys: &[ContractKey]) {
    for ContractKey {
        key,
        remark,
        absent,
    } in keys
    {
        let line = match table.get(*key) {
            Some(toml::Value::Table(_)) => continue,
            Some(value) => format!("{key} = {}", visible_value(value)),
            None => (*absent).to_owned(),
        };
        for remark in remark.lines() {
            let _ = writeln!(text, "# {remark}");
        }
        let _ = writeln!(text, "{line}");
    }
}

/// Returns a value as TOML, with characters that a terminal acts upon as escapes, as in `\u001B`.
fn visible_value(value: &toml::Value) -> String {
    match value {
        toml::Value::Array(all) => {
            let all: Vec<String> = all.iter().map(visible_value).collect();
            format!("[{}]", all.join(", "))
        }
        toml::Value::String(text) => visible_toml(text),
        _ => value.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::super::{OutputNames, Training};
    use super::*;
    use crate::draw::template::Template;
    use crate::error::visible;
    use crate::inference::input::{Distance, InputLayout, InputRange};
    use std::path::Path;

    fn full() -> Contract {
        Contract {
            name: "a \"name\"".into(),
            input_range: InputRange::Byte,
            mean: vec![0.5, 0.25],
            std: vec![2.0],
            channels: 2,
            rows: 64,
            columns: 44,
            layout: InputLayout::Ntchw,
            template: Template::Silhouettes,
            frames: Some(30),
            view_input: Some("seen".into()),
            distance: Distance::Cosine,
            classes: vec!["a".into(), "b\n".into(), "\u{9b}31m\u{202e}c".into()],
            outputs: OutputNames {
                embedding: Some("x/y".into()),
                scores: Some("z".into()),
            },
            training: Training {
                description: "so\nand so".into(),
                viewpoints: vec![[90.0, 0.5]],
                subjects: vec!["c".into()],
                walks: vec!["w".into()],
                cycles: vec![1],
                variations: vec![2, 3],
                seed: 4,
                seeds: vec![5],
            },
            ..Contract::default()
        }
    }

    #[test]
    fn what_is_explained_reads_back_the_same() {
        for contract in [Contract::default(), full()] {
            let text = contract.explained("m.onnx").expect("text");
            let read = Contract::parse(Path::new("m.toml"), &text).expect(&text);
            assert_eq!(read, contract, "{text}");
            assert_eq!(visible(&text), text);
        }
    }

    #[test]
    fn every_key_is_there_with_a_remark_or_below_one_that_speaks_for_it() {
        let text = full().explained("m.onnx").expect("text");
        let table = toml::Table::try_from(full()).expect("a table");
        let inner = ["outputs", "training"].map(|name| table[name].as_table().expect("a table"));
        for key in inner
            .into_iter()
            .chain([&table])
            .flat_map(toml::Table::keys)
        {
            let is_there = text
                .lines()
                .any(|line| line.starts_with(&format!("{key} = ")) || line == format!("[{key}]"));
            assert!(is_there, "{key} is not explained:\n{text}");
        }
        let plain = Contract::default().explained("m.onnx").expect("text");
        for line in [
            "# frames = 30",
            "distance = \"euclidean\"",
            "# embedding = \"embedding\"",
        ] {
            assert!(plain.lines().any(|other| other == line), "{plain}");
        }
        assert!(plain.starts_with("# m.onnx\n"));
    }
}
