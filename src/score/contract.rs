//! What a recognizer expects and promises: the `<model>.toml` beside `<model>.onnx`.
//!
//! An ONNX file says that its input is `[N, 1, 50, 30]` floats, but not whether
//! white is 1 or 255, nor how the figure was framed. Fed wrongly, a model gives
//! plausible numbers and a poor Rank-1, so that is written down.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::input::{Distance, InputAxis, InputLayout, InputRange};
use crate::error::{Error, Result, ScoreError, TemplateOrigin};
use crate::sweep::FramingMode;
use crate::template::{Template, TemplateShape};
use edgegait_core::silhouette::Size;

/// Most bytes a contract may have.
const MAX_BYTES: u64 = 1 << 20;

/// Input and output conventions of a recognizer. Every key may be left out.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Contract {
    /// What to call the recognizer in reports; empty means the model's file name.
    pub name: String,
    /// What background and foreground are: `"0..1"` (default), `"0..255"` or `"-1..1"`.
    pub input_range: InputRange,
    /// What is subtracted from each number in that range: one number for all channels, or one for each;
    /// empty: nothing.
    #[serde(
        deserialize_with = "one_or_many",
        skip_serializing_if = "Vec::is_empty"
    )]
    pub mean: Vec<f32>,
    /// What each number is divided by after that: one number for all channels, or one for each; empty:
    /// nothing.
    #[serde(
        deserialize_with = "one_or_many",
        skip_serializing_if = "Vec::is_empty"
    )]
    pub std: Vec<f32>,
    /// Equal channels in which one image is given, 1 unless given.
    #[serde(skip_serializing_if = "is_one")]
    pub channels: usize,
    /// Rows of the silhouettes that the input is made of, 50 unless given.
    pub rows: usize,
    /// Columns of the silhouettes that the input is made of, 30 unless given.
    pub columns: usize,
    /// Order of the input's axes: `"NCHW"` (default), `"NHWC"`, `"NHW"` or, row by row, `"ND"` for GEIs
    /// and other single images, `"NCHW"` for several (frequency), `"NTHW"`, `"NTCHW"` or `"NCTHW"` for
    /// silhouettes, `"ND"` for vectors.
    pub layout: InputLayout,
    /// How figures were framed in training: `"height"` (default), `"box"`, `"cycle"` or
    /// `"camera"`.
    pub framing: FramingMode,
    /// Which template the recognizer takes: `"gei"` (default), `"silhouettes"`, `"mei"`, `"mhi"`,
    /// `"msi"`, `"ghi"`, `"geni"`, `"frequency"`, `"kfd"` or `"row-width"`.
    pub template: Template,
    /// Frames of one input of silhouettes; if left out, as many as the model's file says, or any
    /// number if it leaves them free.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub frames: Option<usize>,
    /// Name of a second input, f32 `[N, 2]`: azimuth and elevation, in degrees, from which each input is
    /// seen. Only viewpoints of [`Training::viewpoints`] are given, if it has any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub view_input: Option<String>,
    /// How embeddings are compared: `"euclidean"` (default), `"cosine"`, `"votes"` or `"view"`.
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
    #[serde(deserialize_with = "pairs")]
    pub viewpoints: Vec<[f64; 2]>,
    /// Names of the people; empty if they are the classes.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub subjects: Vec<String>,
    /// Names of the walks; empty if unknown.
    pub walks: Vec<String>,
    /// Which recorded cycles of the walks, from 0; empty if unknown.
    pub cycles: Vec<u32>,
    /// Which seeded variations of those cycles; 0 is the cycle itself.
    pub variations: Vec<u32>,
    /// Seed of the variations.
    pub seed: u64,
    /// Seeds of others of them, if there are any; each variation counts as one of every seed.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub seeds: Vec<u64>,
}

impl Default for Contract {
    fn default() -> Self {
        Self {
            name: String::new(),
            input_range: InputRange::Unit,
            mean: Vec::new(),
            std: Vec::new(),
            channels: 1,
            rows: 50,
            columns: 30,
            layout: InputLayout::Nchw,
            framing: FramingMode::Height,
            template: Template::Gei,
            frames: None,
            view_input: None,
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
        Ok(Self::stated_beside(model)?.unwrap_or_default())
    }

    /// The same; none if there is no such file.
    ///
    /// # Errors
    /// As [`Self::beside`].
    pub(super) fn stated_beside(model: &Path) -> Result<Option<Self>> {
        let path = Self::path_beside(model);
        match std::fs::metadata(&path) {
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(None),
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
                Self::parse(&path, &text).map(Some)
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
        Ok(toml::to_string(self).map_err(ScoreError::from)?)
    }

    /// What the numbers of one template or silhouette are.
    #[must_use]
    pub const fn shape(&self) -> TemplateShape {
        self.template.shape_of(self.rows, self.columns)
    }

    /// Numbers in one template or silhouette.
    #[must_use]
    pub const fn numbers(&self) -> usize {
        self.shape().numbers()
    }

    /// What is given and how, in words: `GEIs of 64x44 in 3 equal channels (NCHW)`.
    pub(crate) fn given(&self) -> String {
        let channels = match self.channels {
            1 => String::new(),
            channels => format!(" in {channels} equal channels"),
        };
        format!(
            "{} of {}x{}{channels} ({})",
            self.template.plural(),
            self.rows,
            self.columns,
            self.layout.name()
        )
    }

    /// Numbers of an input, or of one frame of it: as many as in a template or silhouette, in each channel.
    #[must_use]
    pub const fn input_numbers(&self) -> usize {
        self.numbers() * self.channels
    }

    /// Channels of the input: its images, or equal ones; 1 of a vector.
    pub(super) const fn input_channels(&self) -> usize {
        match self.shape() {
            TemplateShape::Image { planes, .. } => planes * self.channels,
            TemplateShape::Vector(_) => 1,
        }
    }

    /// Appends a whole input, of which these are the pixels (0 to 255), frame after frame: in the
    /// contract's range, channels and layout.
    pub fn feed(&self, bytes: &[u8], into: &mut Vec<f32>) {
        let mut add = |pixels: &[u8], channel: usize| {
            let of = |all: &[f32]| all.get(channel).or(all.first()).copied();
            let (mean, std) = (of(&self.mean).unwrap_or(0.0), of(&self.std));
            let numbers = pixels
                .iter()
                .map(|&byte| self.input_range.of_byte(byte) - mean);
            match std {
                None => into.extend(numbers),
                Some(std) => into.extend(numbers.map(|number| number / std)),
            }
        };
        let block = match self.layout {
            _ if self.channels == 1 => bytes.len(),
            InputLayout::Nhwc => 1,
            InputLayout::Ntchw => self.numbers(),
            _ => bytes.len(),
        };
        for block in bytes.chunks(block.max(1)) {
            for channel in 0..self.channels {
                add(block, channel);
            }
        }
    }

    /// How many frames each of `batch` inputs has that are so many numbers together, those of the
    /// viewpoint among them; 1 for templates.
    ///
    /// # Errors
    /// If that is no whole number, none, or another than the contract states.
    pub fn frames_in(&self, numbers: usize, batch: usize) -> Result<usize> {
        let pixels = { batch.checked_mul(self.view_numbers()) }
            .and_then(|of_views| numbers.checked_sub(of_views));
        let step = batch.checked_mul(self.input_numbers());
        let frames = match (pixels, step) {
            (Some(pixels), Some(step)) if step > 0 && pixels.is_multiple_of(step) => pixels / step,
            _ => 0,
        };
        let expected = match self.template {
            Template::Silhouettes => self.frames,
            _ => Some(1),
        };
        if frames > 0 && expected.is_none_or(|expected| expected == frames) {
            return Ok(frames);
        }
        let inputs = match (self.template, self.frames) {
            (Template::Silhouettes, Some(frames)) => format!("sequences of {frames} silhouettes"),
            (Template::Silhouettes, None) => "sequences of equally many silhouettes".to_owned(),
            (template, _) => template.plural().to_owned(),
        };
        Err(ScoreError::Input {
            model: self.name.clone(),
            batch,
            inputs,
            shape: match self.channels {
                1 => self.shape().to_string(),
                channels => format!("{} in {channels} channels", self.shape()),
            },
            numbers: self.input_numbers() + self.view_numbers(),
            found: numbers,
        }
        .into())
    }

    /// The shape in which `batch` inputs of `frames` frames are given.
    #[must_use]
    pub fn input_shape(&self, batch: usize, frames: usize) -> Vec<usize> {
        let size = |axis: &InputAxis| match axis {
            InputAxis::Batch => batch,
            InputAxis::Frame => frames,
            InputAxis::Channel => self.input_channels(),
            InputAxis::Row => self.rows,
            InputAxis::Column => self.columns,
            InputAxis::Number => self.numbers(),
        };
        self.layout.axes().iter().map(size).collect()
    }

    /// The size of the silhouettes, if it is one that can be drawn.
    #[must_use]
    pub fn size(&self) -> Option<Size> {
        let asked = (self.rows, self.columns);
        let mut known = Size::ALL.into_iter();
        known.find(|size| (size.rows(), size.columns()) == asked)
    }

    /// Refuses another template than the model asks for.
    ///
    /// # Errors
    /// Naming both.
    pub fn require_template(&self, template: Template, origin: TemplateOrigin) -> Result<()> {
        if template == self.template {
            return Ok(());
        }
        let asked = self.template.name().to_owned();
        self.refuse("template", (asked, template.name()), origin)
    }

    /// Refuses silhouettes, or templates of them, of another size, and of another framing if it is known, than the model
    /// asks for.
    ///
    /// # Errors
    /// Naming both.
    pub fn require(
        &self,
        size: Size,
        framing: Option<FramingMode>,
        origin: TemplateOrigin,
    ) -> Result<()> {
        let asked = format!("{}x{}", self.rows, self.columns);
        if asked != size.name() {
            return self.refuse("size", (asked, size.name()), origin);
        }
        match framing {
            Some(framing) if framing != self.framing => {
                let asked = self.framing.name().to_owned();
                self.refuse("framing", (asked, framing.name()), origin)
            }
            _ => Ok(()),
        }
    }

    fn refuse(
        &self,
        setting: &'static str,
        (asked, found): (String, &'static str),
        origin: TemplateOrigin,
    ) -> Result<()> {
        Err(ScoreError::Contract {
            model: self.name.clone(),
            setting,
            asked,
            found,
            origin,
        }
        .into())
    }
}

/// A number, or a list of them.
fn one_or_many<'de, D: serde::Deserializer<'de>>(
    from: D,
) -> std::result::Result<Vec<f32>, D::Error> {
    #[derive(Deserialize)]
    #[serde(untagged, expecting = "expected a number, or a list of numbers")]
    enum OneOrMany {
        One(f32),
        Many(Vec<f32>),
    }
    Ok(match OneOrMany::deserialize(from)? {
        OneOrMany::One(one) => vec![one],
        OneOrMany::Many(many) => many,
    })
}

/// A list of pairs: of a longer list serde would leave out the rest without a word.
fn pairs<'de, D: serde::Deserializer<'de>>(
    from: D,
) -> std::result::Result<Vec<[f64; 2]>, D::Error> {
    let lists = Vec::<Vec<f64>>::deserialize(from)?;
    let pair = |list: Vec<f64>| {
        let found = list.len();
        list.try_into().map_err(|_| {
            serde::de::Error::custom(format!(
                "expected viewpoints of two numbers, [azimuth, elevation], found {found}"
            ))
        })
    };
    lists.into_iter().map(pair).collect()
}

#[expect(
    clippy::trivially_copy_pass_by_ref,
    reason = "serde passes a reference"
)]
fn is_one(channels: &usize) -> bool {
    *channels == 1
}

mod checks;
mod difference;
mod explained;
mod viewpoint;

#[cfg(feature = "train")]
pub(crate) use viewpoint::SAME_VIEW_DEG;

#[cfg(test)]
mod tests;
