//! The contract of a recognizer, which states what it expects and promises: the `<model>.toml`
//! beside `<model>.onnx`.
//!
//! An ONNX file states that its input is `[N, 1, 50, 30]` floats, but not whether white is 1 or
//! 255, nor how the figure was framed. With wrong inputs, a model gives plausible numbers and a
//! poor rank-1.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::input::{Distance, InputAxis, InputLayout, InputRange};
use crate::draw::sweep::FramingMode;
use crate::draw::template::{Template, TemplateShape};
use crate::error::{Error, InferenceError, Result, TemplateOrigin};
use edgegait_core::silhouette::Size;

/// The maximum number of bytes a contract may have.
const MAX_BYTES: u64 = 1 << 20;

/// Input and output conventions of a recognizer. Every key may be left out.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Contract {
    /// The recognizer's name in reports; if empty, the name of the model's file.
    pub name: String,
    /// The values of background and foreground: `"0..1"` (default), `"0..255"` or `"-1..1"`.
    pub input_range: InputRange,
    /// The numbers that are subtracted from the values in that range: one for all channels, or one
    /// for each; none if empty.
    #[serde(
        deserialize_with = "one_or_many",
        skip_serializing_if = "Vec::is_empty"
    )]
    pub mean: Vec<f32>,
    /// The numbers by which the result is divided: one for all channels, or one for each; none if
    /// empty.
    #[serde(
        deserialize_with = "one_or_many",
        skip_serializing_if = "Vec::is_empty"
    )]
    pub std: Vec<f32>,
    /// Equal channels that repeat an image; 1 by default.
    #[serde(skip_serializing_if = "is_one")]
    pub channels: usize,
    /// Rows of the silhouettes; 50 by default.
    pub rows: usize,
    /// Columns of the silhouettes; 30 by default.
    pub columns: usize,
    /// The order of the input's axes. GEIs and other single images: `"NCHW"` (default), `"NHWC"`,
    /// `"NHW"` or, row by row, `"ND"`. Several images (frequency): `"NCHW"`. Silhouettes: `"NTHW"`,
    /// `"NTCHW"` or `"NCTHW"`. Vectors: `"ND"`.
    pub layout: InputLayout,
    /// How figures were framed in training: `"height"` (default), `"box"`, `"cycle"` or
    /// `"camera"`.
    pub framing: FramingMode,
    /// The template that the recognizer takes: `"gei"` (default), `"silhouettes"`, `"mei"`,
    /// `"mhi"`, `"msi"`, `"ghi"`, `"geni"`, `"frequency"`, `"kfd"` or `"row-width"`.
    pub template: Template,
    /// Frames of one input of silhouettes. By default, the number in the model's file, or any
    /// number if that leaves it free.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub frames: Option<usize>,
    /// The name of a second input, f32 `[N, 2]`: azimuth and elevation of each input's viewpoint,
    /// degrees. If [`Training::viewpoints`] lists any, all others are errors.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub view_input: Option<String>,
    /// How embeddings are compared: `"euclidean"` (default), `"cosine"`, `"votes"` or `"view"`.
    #[serde(skip_serializing_if = "Distance::is_default")]
    pub distance: Distance,
    /// Names of the people that the class scores stand for, in the order of the scores; empty if
    /// unknown.
    pub classes: Vec<String>,
    /// Names of the model's outputs.
    pub outputs: OutputNames,
    /// The recognizer's training data.
    pub training: Training,
}

/// Names of the model's outputs; those left out are determined from the model.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct OutputNames {
    /// The f32 `[N, dims]` or `[N, dims, parts]` output that is compared by distance.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub embedding: Option<String>,
    /// The f32 `[N, classes]` output whose highest column decides.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub scores: Option<String>,
}

/// The training data of a recognizer.
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
    /// Numbers of the recorded cycles of the walks, from 0; empty if unknown.
    pub cycles: Vec<u32>,
    /// Numbers of the seeded variations of those cycles; 0 is the cycle itself.
    pub variations: Vec<u32>,
    /// Seed of the variations.
    pub seed: u64,
    /// Further seeds, if any; each variation counts as trained with every seed.
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
    /// If the text is not TOML, a key is unknown, or a value is invalid.
    pub fn parse(path: &Path, text: &str) -> Result<Self> {
        let contract: Self =
            toml::from_str(text).map_err(|error| Error::toml(path, text, &error))?;
        contract.check(path)?;
        Ok(contract)
    }

    /// Reads the contract beside a model: `pca.toml` for `pca.onnx`. Returns `None` if there is no
    /// such file.
    ///
    /// # Errors
    /// If the file is there but cannot be read or used.
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
                let text = crate::files::read_to_string(&path)?;
                Self::parse(&path, &text).map(Some)
            }
        }
    }

    /// Returns the path of a model's contract.
    #[must_use]
    pub fn path_beside(model: &Path) -> PathBuf {
        model.with_extension("toml")
    }

    /// Returns the contract as TOML, in a fixed order of keys.
    ///
    /// # Errors
    /// If a number cannot be written as TOML.
    pub fn to_toml(&self) -> Result<String> {
        Ok(toml::to_string(self).map_err(InferenceError::from)?)
    }

    /// Returns the shape of one template or silhouette.
    #[must_use]
    pub const fn shape(&self) -> TemplateShape {
        self.template.shape_of(self.rows, self.columns)
    }

    /// Returns the length of one template or silhouette.
    #[must_use]
    pub const fn numbers(&self) -> usize {
        self.shape().numbers()
    }

    /// Describes the inputs: `GEIs of 64x44 in 3 equal channels (NCHW)`.
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

    /// Returns the length of an input, or of one frame of it: that of a template or silhouette in
    /// each channel.
    #[must_use]
    pub const fn input_numbers(&self) -> usize {
        self.numbers() * self.channels
    }

    /// Returns the channels of the input: its images, each repeated; 1 for a vector.
    pub(super) const fn input_channels(&self) -> usize {
        match self.shape() {
            TemplateShape::Image { planes, .. } => planes * self.channels,
            TemplateShape::Vector(_) => 1,
        }
    }

    /// Appends an input in the contract's range, channels and layout. `bytes` are all its pixels (0
    /// to 255), frame after frame.
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

    /// Returns the number of frames in each of `batch` inputs that have `numbers` values in total,
    /// including viewpoints; 1 for templates.
    ///
    /// # Errors
    /// If that is not a whole number, is 0, or contradicts the contract.
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
            (Template::Silhouettes, None) => "equally long sequences of silhouettes".to_owned(),
            (template, _) => template.plural().to_owned(),
        };
        Err(InferenceError::Input {
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

    /// Returns the shape of `batch` inputs of `frames` frames.
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

    /// Returns the size of the silhouettes, if it is one that can be drawn.
    #[must_use]
    pub fn size(&self) -> Option<Size> {
        let asked = (self.rows, self.columns);
        let mut known = Size::ALL.into_iter();
        known.find(|size| (size.rows(), size.columns()) == asked)
    }

    /// Checks that the model takes this template.
    ///
    /// # Errors
    /// If it takes another one; the error names both.
    pub fn require_template(&self, template: Template, origin: TemplateOrigin) -> Result<()> {
        if template == self.template {
            return Ok(());
        }
        let asked = self.template.name().to_owned();
        self.refuse("template", asked, template.name(), origin)
    }

    /// Checks that the model takes silhouettes, or templates of them, of this size and, if it is
    /// known, this framing.
    ///
    /// # Errors
    /// If it takes another size or framing; the error names both.
    pub fn require(
        &self,
        size: Size,
        framing: Option<FramingMode>,
        origin: TemplateOrigin,
    ) -> Result<()> {
        let asked = format!("{}x{}", self.rows, self.columns);
        if asked != size.name() {
            return self.refuse("size", asked, size.name(), origin);
        }
        match framing {
            Some(framing) if framing != self.framing => {
                let asked = self.framing.name().to_owned();
                self.refuse("framing", asked, framing.name(), origin)
            }
            _ => Ok(()),
        }
    }

    fn refuse(
        &self,
        setting: &'static str,
        asked: String,
        found: &'static str,
        origin: TemplateOrigin,
    ) -> Result<()> {
        Err(InferenceError::Contract {
            model: self.name.clone(),
            setting,
            asked,
            found,
            origin,
        }
        .into())
    }
}

/// Reads a number or a list of numbers.
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

/// Reads a list of pairs. (From a longer list, serde would silently drop the rest.)
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
