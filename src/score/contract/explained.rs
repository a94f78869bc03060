//! A contract for people to edit: every key with what it means.

use std::fmt::Write as _;

use super::Contract;
use crate::error::{Result, ScoreError};

/// A key, what it means, and its line where the contract leaves it out.
type ContractKey = (&'static str, &'static str, &'static str);

const KEYS: [ContractKey; 16] = [
    (
        "name",
        "What to call the recognizer in results; empty: the name of the model's file.",
        "",
    ),
    (
        "template",
        "What the input is made of: \"gei\", \"silhouettes\" (a sequence), \"mei\", \"mhi\", \"msi\", \"ghi\", \"geni\",\n\
         \"frequency\" (three images), \"kfd\" or \"row-width\" (vectors).",
        "",
    ),
    (
        "layout",
        "Order of the input's axes: N inputs, T frames, C channels, H rows, W columns, D numbers. Images: \"NCHW\",\n\
         \"NHWC\", \"NHW\", \"ND\" (row by row); silhouettes: \"NTHW\", \"NTCHW\", \"NCTHW\"; vectors: \"ND\".",
        "",
    ),
    (
        "rows",
        "Rows and columns of a silhouette: 50x30, 64x44 and 64x64 can be drawn.",
        "",
    ),
    ("columns", "", ""),
    (
        "frames",
        "Frames of one sequence of silhouettes, if they must be so many.",
        "# frames = 30",
    ),
    (
        "framing",
        "How figures were framed in training: \"height\" (each fills the rows), \"box\" (each is stretched to its\n\
         bounding box), \"cycle\" (one scale for a gait cycle) or \"camera\" (as a sensor sees it). CHECK THIS.",
        "",
    ),
    (
        "input_range",
        "Values of background and foreground: \"0..1\", \"0..255\" or \"-1..1\". CHECK THIS.",
        "",
    ),
    (
        "mean",
        "Subtracted from each number in that range: one number, or one a channel.",
        "# mean = 0.5",
    ),
    (
        "std",
        "Each number is divided by it after that: one number, or one a channel.",
        "# std = 0.5",
    ),
    (
        "channels",
        "Equal channels in which an image is given, for networks that were made for colour.",
        "# channels = 3",
    ),
    (
        "view_input",
        "Name of a second input, f32 [N, 2]: azimuth and elevation, in degrees, from which each input is seen.",
        "# view_input = \"view\"",
    ),
    (
        "distance",
        "How embeddings are compared: \"euclidean\" or \"cosine\"; in parts, the mean over these. \"votes\": each part\n\
         votes for the nearest. \"view\": the part of the probe's viewpoint, in the order of training.viewpoints. CHECK THIS.",
        "distance = \"euclidean\"",
    ),
    (
        "classes",
        "The people whom the class scores stand for, in the order of the scores; empty: people are enrolled, and\n\
         the nearest embedding decides.",
        "",
    ),
    ("outputs", "", ""),
    ("training", "", ""),
];

const OUTPUTS: [ContractKey; 2] = [
    (
        "embedding",
        "The output that is compared by distance, f32 [N, numbers] or [N, numbers, parts].",
        "# embedding = \"embedding\"",
    ),
    (
        "scores",
        "The output whose highest number decides, f32 [N, classes].",
        "# scores = \"scores\"",
    ),
];

const TRAINING: [ContractKey; 8] = [
    ("description", "Data, recipe and seed, in words.", ""),
    (
        "viewpoints",
        "Where people are enrolled, unless a protocol says otherwise: [azimuth, elevation] in degrees, 90 from the\n\
         walker's left side, 0 level; empty: [90, 0].",
        "",
    ),
    (
        "subjects",
        "Whom it was trained on, if these are not the classes: it is said which of them are looked for.",
        "# subjects = [\"somebody\"]",
    ),
    (
        "walks",
        "Which walks of a pack of EdgeGait's, which of their cycles, and which seeded variations.",
        "",
    ),
    ("cycles", "", ""),
    ("variations", "", ""),
    ("seed", "The seed of the variations.", ""),
    ("seeds", "Seeds of others of them.", "# seeds = [2]"),
];

impl Contract {
    /// The contract as TOML with a remark at each key, those that are left out too; `about` says what
    /// it is of, in one line.
    ///
    /// # Errors
    /// If a number cannot be written as TOML.
    pub fn explained(&self, about: &str) -> Result<String> {
        let table = toml::Table::try_from(self).map_err(ScoreError::from)?;
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
    for (key, remark, absent) in keys {
        let line = match table.get(*key) {
            Some(toml::Value::Table(_)) => continue,
            Some(value) => format!("{key} = {value}"),
            None => (*absent).to_owned(),
        };
        for remark in remark.lines() {
            let _ = writeln!(text, "# {remark}");
        }
        let _ = writeln!(text, "{line}");
    }
}

#[cfg(test)]
mod tests {
    use super::super::{OutputNames, Training};
    use super::*;
    use crate::score::input::{Distance, InputLayout, InputRange};
    use crate::template::Template;
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
            classes: vec!["a".into(), "b\n".into()],
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
            assert!(plain.lines().any(|one| one == line), "{plain}");
        }
        assert!(plain.starts_with("# m.onnx\n"));
    }
}
