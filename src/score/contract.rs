//! What a recognizer expects and promises: the `<model>.toml` beside `<model>.onnx`.
//!
//! An ONNX file says that its input is `[N, 1, 50, 30]` floats, but not whether
//! white is 1 or 255, nor how the figure was framed. Fed wrongly, a model gives
//! plausible numbers and a poor Rank-1, so that is written down.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::input::{Axis, Distance, InputRange, Layout, Template};
use crate::error::{Error, Result};
use crate::sweep::Framing;
use edgegait_core::silhouette::Size;

/// Most bytes a contract may have.
const MAX_BYTES: u64 = 1 << 20;
/// Most rows, columns or frames of an input.
const MAX_SIDE: usize = 4096;

/// Input and output conventions of a recognizer. Every key may be left out.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Contract {
    /// What to call the recognizer in reports; empty means the model's file name.
    pub name: String,
    /// What background and foreground are: `"0..1"` (default) or `"0..255"`.
    pub input_range: InputRange,
    /// Rows of the input, 50 unless given.
    pub rows: usize,
    /// Columns of the input, 30 unless given.
    pub columns: usize,
    /// Order of the input's axes, with one channel: `"NCHW"` (default), `"NHWC"` or `"NHW"` for
    /// GEIs, `"NTHW"`, `"NTCHW"` or `"NCTHW"` for silhouettes.
    pub layout: Layout,
    /// How figures were framed in training: `"height"` (default), `"box"`, `"cycle"` or
    /// `"camera"`.
    pub framing: Framing,
    /// Which template the recognizer takes: `"gei"` (default) or `"silhouettes"`.
    pub template: Template,
    /// Frames of one input of silhouettes; if left out, as many as the model's file says, or any
    /// number if it leaves them free.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub frames: Option<usize>,
    /// How embeddings are compared: `"euclidean"` (default) or `"cosine"`.
    #[serde(skip_serializing_if = "Distance::is_default")]
    pub distance: Distance,
    /// Names of the people that the scores stand for, in their order; empty if unknown.
    pub classes: Vec<String>,
    /// Names of the model's outputs.
    pub outputs: OutputNames,
    /// What the recognizer was trained on.
    pub training: Training,
}

/// Names of the model's outputs; those left out are found from the model.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct OutputNames {
    /// The f32 `[N, dims]` or `[N, dims, parts]` output that is compared by distance.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub embedding: Option<String>,
    /// The f32 `[N, classes]` output whose highest column is the answer.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub scores: Option<String>,
}

/// What a recognizer was trained on.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Training {
    /// Free text: data, recipe, seed.
    pub description: String,
    /// Viewpoints as `[azimuth_deg, elevation_deg]`.
    pub viewpoints: Vec<[f64; 2]>,
    /// Names of the walks; empty if unknown.
    pub walks: Vec<String>,
    /// Cycles 0 to one fewer of each walk; 0 if unknown.
    pub cycles: u32,
    /// Seed of the cycles' variations.
    pub seed: u64,
}

impl Default for Contract {
    fn default() -> Self {
        Self {
            name: String::new(),
            input_range: InputRange::Unit,
            rows: 50,
            columns: 30,
            layout: Layout::Nchw,
            framing: Framing::Height,
            template: Template::Gei,
            frames: None,
            distance: Distance::Euclidean,
            classes: Vec::new(),
            outputs: OutputNames::default(),
            training: Training::default(),
        }
    }
}

impl Contract {
    /// Reads a contract from TOML; `path` is only for messages.
    ///
    /// # Errors
    /// If the text is not TOML, a key is unknown, or a value cannot be.
    pub fn parse(path: &Path, text: &str) -> Result<Self> {
        let contract: Self =
            toml::from_str(text).map_err(|error| Error::toml(path, text, &error))?;
        contract.check(path)?;
        Ok(contract)
    }

    /// The contract beside a model: `pca.toml` for `pca.onnx`; the defaults if there is none.
    ///
    /// # Errors
    /// If the file is there but cannot be read or used.
    pub fn beside(model: &Path) -> Result<Self> {
        let path = Self::path_beside(model);
        match std::fs::metadata(&path) {
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(Self::default()),
            Err(error) => Err(Error::io(path, error)),
            Ok(metadata) if metadata.len() > MAX_BYTES => Err(Error::input(
                path,
                format!(
                    "expected a contract of at most {MAX_BYTES} bytes, found {}",
                    metadata.len()
                ),
            )),
            Ok(_) => {
                let text =
                    std::fs::read_to_string(&path).map_err(|error| Error::io(&path, error))?;
                Self::parse(&path, &text)
            }
        }
    }

    /// Where the contract of a model lies.
    #[must_use]
    pub fn path_beside(model: &Path) -> PathBuf {
        model.with_extension("toml")
    }

    /// The contract as TOML, in a fixed order of keys.
    ///
    /// # Errors
    /// If a number cannot be written as TOML.
    pub fn to_toml(&self) -> Result<String> {
        toml::to_string(self).map_err(|error| Error::Failed(format!("contract: {error}")))
    }

    /// Numbers in one GEI or silhouette.
    #[must_use]
    pub const fn pixels(&self) -> usize {
        self.rows * self.columns
    }

    /// Appends pixels (0 to 255) in the contract's range.
    pub fn feed(&self, bytes: &[u8], into: &mut Vec<f32>) {
        into.extend(bytes.iter().map(|&byte| self.input_range.of_byte(byte)));
    }

    /// How many frames each of `batch` inputs has that are so many numbers together; 1 for GEIs.
    ///
    /// # Errors
    /// If that is no whole number, none, or another than the contract states.
    pub fn frames_in(&self, numbers: usize, batch: usize) -> Result<usize> {
        let frames = batch
            .checked_mul(self.pixels())
            .filter(|step| *step > 0 && numbers.is_multiple_of(*step))
            .map_or(0, |step| numbers / step);
        let expected = match self.template {
            Template::Gei => Some(1),
            Template::Silhouettes => self.frames,
        };
        if frames > 0 && expected.is_none_or(|expected| expected == frames) {
            return Ok(frames);
        }
        let (rows, columns) = (self.rows, self.columns);
        let inputs = match (self.template, self.frames) {
            (Template::Gei, _) => "GEIs".to_owned(),
            (Template::Silhouettes, Some(frames)) => format!("sequences of {frames} silhouettes"),
            (Template::Silhouettes, None) => "sequences of equally many silhouettes".to_owned(),
        };
        Err(Error::Failed(format!(
            "{}: expected {batch} {inputs} of {rows} x {columns} = {} numbers and at least one, found {numbers} numbers",
            self.name,
            self.pixels(),
        )))
    }

    /// The shape in which `batch` inputs of `frames` frames are given.
    #[must_use]
    pub fn input_shape(&self, batch: usize, frames: usize) -> Vec<usize> {
        let size = |axis: &Axis| match axis {
            Axis::Batch => batch,
            Axis::Frame => frames,
            Axis::Channel => 1,
            Axis::Row => self.rows,
            Axis::Column => self.columns,
        };
        self.layout.axes().iter().map(size).collect()
    }

    /// Refuses GEIs of another size, and of another framing if it is known, than the model
    /// asks for. `remedy` says what to do, before the flag to do it with.
    ///
    /// # Errors
    /// Naming both, and the flag.
    pub fn require(&self, size: Size, framing: Option<Framing>, remedy: &str) -> Result<()> {
        let asked = format!("{}x{}", self.rows, self.columns);
        if asked != size.name() {
            let remedy = if Size::ALL.iter().any(|size| size.name() == asked) {
                format!("{remedy} --size {asked}")
            } else {
                "only 50x30, 64x44 and 64x64 can be drawn".to_owned()
            };
            return Err(Error::Failed(format!(
                "{}: the model's contract asks for GEIs of {asked}, found {size} ({remedy})",
                self.name
            )));
        }
        match framing {
            Some(framing) if framing != self.framing => Err(Error::Failed(format!(
                "{}: the model's contract asks for framing {asked}, found {} ({remedy} --framing {asked})",
                self.name,
                framing.name(),
                asked = self.framing.name(),
            ))),
            _ => Ok(()),
        }
    }

    fn check(&self, path: &Path) -> Result<()> {
        for (key, side) in [("rows", self.rows), ("columns", self.columns)] {
            if !(1..=MAX_SIDE).contains(&side) {
                return Err(Error::input(
                    path,
                    format!("{key}: expected 1 to {MAX_SIDE}, found {side}"),
                ));
            }
        }
        if self.layout.template() != self.template {
            let fitting = Layout::ALL
                .iter()
                .filter(|layout| layout.template() == self.template);
            let names: Vec<_> = fitting.map(|layout| layout.name()).collect();
            return Err(Error::input(
                path,
                format!(
                    "layout: template {:?} comes as {}, found {} ({} unless it is given)",
                    self.template.name(),
                    names.join(", "),
                    self.layout.name(),
                    Layout::default().name()
                ),
            ));
        }
        if let Some(frames) = self.frames {
            let problem = match self.template {
                Template::Gei => "template \"gei\" has none".to_owned(),
                Template::Silhouettes => format!("expected 1 to {MAX_SIDE}"),
            };
            if self.template == Template::Gei || !(1..=MAX_SIDE).contains(&frames) {
                return Err(Error::input(
                    path,
                    format!("frames: {problem}, found {frames}"),
                ));
            }
        }
        let angles = self.training.viewpoints.iter().flatten();
        if let Some(angle) = angles.copied().find(|angle| !angle.is_finite()) {
            return Err(Error::input(
                path,
                format!("viewpoints: expected degrees, found {angle}"),
            ));
        }
        if let Some(twice) = first_repeated(&self.classes) {
            return Err(Error::input(
                path,
                format!("classes: {twice:?} is there twice"),
            ));
        }
        Ok(())
    }
}

fn first_repeated(names: &[String]) -> Option<&String> {
    let mut seen = std::collections::HashSet::new();
    names.iter().find(|name| !seen.insert(*name))
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: &str = r#"
name = "pca-lda-side"
input_range = "0..255"
rows = 64
columns = 44
layout = "NCHW"
framing = "cycle"
template = "gei"
classes = ["s01", "s02"]

[outputs]
embedding = "features"
scores = "logits"

[training]
description = "26 people, side view, seed 7"
viewpoints = [[90.0, 0.0], [270.0, 15.0]]
"#;

    fn parse(text: &str) -> Result<Contract> {
        Contract::parse(Path::new("m.toml"), text)
    }

    #[test]
    fn every_key_is_read() {
        let contract = parse(ALL).expect("all keys are known");
        assert_eq!(contract.name, "pca-lda-side");
        assert_eq!(contract.input_range, InputRange::Byte);
        assert_eq!(
            (contract.rows, contract.columns, contract.pixels()),
            (64, 44, 2816)
        );
        assert_eq!(contract.framing, Framing::Cycle);
        assert_eq!(contract.classes, ["s01", "s02"]);
        assert_eq!(contract.outputs.embedding.as_deref(), Some("features"));
        assert_eq!(contract.outputs.scores.as_deref(), Some("logits"));
        assert_eq!(contract.training.viewpoints, [[90.0, 0.0], [270.0, 15.0]]);
    }

    #[test]
    fn a_written_contract_reads_back() {
        let contract = parse(ALL).expect("all keys are known");
        let text = contract.to_toml().expect("plain values");
        assert_eq!(parse(&text).expect("our own text"), contract);
        let defaults = Contract::default();
        assert_eq!(
            parse(&defaults.to_toml().expect("plain values")).expect("our own text"),
            defaults
        );
    }

    #[test]
    fn geis_of_another_size_or_framing_are_refused_with_the_flag_that_helps() {
        let contract = parse(ALL).expect("all keys are known");
        let refusal = |size, framing| {
            let found = contract.require(size, framing, "use");
            found.map_err(|error| error.to_string())
        };
        assert_eq!(refusal(Size::S64x44, Some(Framing::Cycle)), Ok(()));
        assert_eq!(refusal(Size::S64x44, None), Ok(()));
        assert_eq!(
            refusal(Size::S50x30, Some(Framing::Cycle)),
            Err("pca-lda-side: the model's contract asks for GEIs of 64x44, found 50x30 (use --size 64x44)".into())
        );
        assert_eq!(
            refusal(Size::S64x44, Some(Framing::Height)),
            Err("pca-lda-side: the model's contract asks for framing cycle, found height (use --framing cycle)".into())
        );
        let odd = Contract {
            rows: 128,
            ..contract.clone()
        };
        let refused = odd
            .require(Size::S64x44, None, "use")
            .map_err(|e| e.to_string());
        assert!(refused.is_err_and(|text| text.contains("only 50x30, 64x44")));
    }

    #[test]
    fn an_empty_contract_is_the_default() {
        let contract = parse("").expect("every key may be left out");
        assert_eq!(contract, Contract::default());
        let mut fed = vec![0.5];
        contract.feed(&[0, 255], &mut fed);
        assert_eq!(fed, [0.5, 0.0, 1.0]);
    }

    #[test]
    fn a_sequence_model_states_its_layout_frames_and_distance() {
        let text =
            "template = \"silhouettes\"\nlayout = \"NTHW\"\nframes = 30\ndistance = \"cosine\"\n";
        let contract = parse(text).expect("all keys are known");
        assert_eq!(contract.template, Template::Silhouettes);
        assert_eq!(contract.frames, Some(30));
        assert_eq!(contract.distance, Distance::Cosine);
        assert_eq!(contract.input_shape(2, 30), [2, 30, 50, 30]);
        let written = contract.to_toml().expect("plain values");
        assert_eq!(parse(&written).expect("our own text"), contract);

        let refusal = |text: &str| parse(text).expect_err("a mistake").to_string();
        assert_eq!(
            refusal("template = \"silhouettes\""),
            "m.toml: layout: template \"silhouettes\" comes as NTHW, NTCHW, NCTHW, found NCHW (NCHW unless it is given)"
        );
        assert!(refusal("layout = \"NTHW\"").contains("template \"gei\" comes as NCHW, NHWC, NHW"));
        assert_eq!(
            refusal("frames = 30"),
            "m.toml: frames: template \"gei\" has none, found 30"
        );
        assert_eq!(
            refusal("template = \"silhouettes\"\nlayout = \"NTHW\"\nframes = 0"),
            "m.toml: frames: expected 1 to 4096, found 0"
        );
    }

    #[test]
    fn frames_are_counted_from_the_numbers_given() {
        let gei = Contract::default();
        assert_eq!(gei.frames_in(3 * 1500, 3).ok(), Some(1));
        assert!(gei.frames_in(3 * 1500, 1).is_err());
        let any = Contract {
            name: "set".into(),
            template: Template::Silhouettes,
            layout: Layout::Nthw,
            ..Contract::default()
        };
        assert_eq!(any.frames_in(12 * 1500, 3).ok(), Some(4));
        let wrong = [(0, 1), (1500, 0), (1501, 1), (1500, 2), (1500, usize::MAX)];
        assert!(
            wrong
                .iter()
                .all(|&(numbers, batch)| any.frames_in(numbers, batch).is_err())
        );
        let thirty = Contract {
            frames: Some(30),
            ..any
        };
        assert_eq!(thirty.frames_in(60 * 1500, 2).ok(), Some(30));
        let error = thirty.frames_in(29 * 1500, 1).expect_err("29 of 30");
        assert_eq!(
            error.to_string(),
            "set: expected 1 sequences of 30 silhouettes of 50 x 30 = 1500 numbers and at least one, found 43500 numbers"
        );
    }

    #[test]
    fn mistakes_are_named_with_their_line() {
        let refusal = |text: &str| parse(text).expect_err("a mistake").to_string();
        let text = refusal("name = \"x\"\ninput_rnage = \"0..1\"\n");
        assert!(
            text.starts_with("m.toml:2") && text.contains("input_rnage"),
            "{text}"
        );
        let text = refusal("input_range = \"-1..1\"\n");
        assert!(
            text.starts_with("m.toml:1") && text.contains("0..255"),
            "{text}"
        );
        assert!(refusal("layout = \"CHW\"").contains("`NCHW`"));
        let text = refusal("template = \"mhi\"");
        assert!(
            text.starts_with("m.toml:1") && text.contains("`gei` or `silhouettes`"),
            "{text}"
        );
        assert!(refusal("distance = \"dtw\"").contains("`euclidean` or `cosine`"));
        assert_eq!(
            refusal("rows = 0"),
            "m.toml: rows: expected 1 to 4096, found 0"
        );
        assert_eq!(
            refusal("classes = [\"a\", \"a\"]"),
            "m.toml: classes: \"a\" is there twice"
        );
        assert!(refusal("training = { viewpoints = [[nan, 0.0]] }").contains("found NaN"));
        assert!(refusal("rows = ").starts_with("m.toml:1"));
    }

    #[test]
    fn a_model_without_a_contract_has_the_default_one() {
        let folder = tempfile::tempdir().expect("a folder");
        let model = folder.path().join("m.onnx");
        assert_eq!(
            Contract::beside(&model).expect("none there"),
            Contract::default()
        );
        std::fs::write(folder.path().join("m.toml"), "name = \"here\"").expect("written");
        assert_eq!(Contract::beside(&model).expect("one there").name, "here");
    }
}
