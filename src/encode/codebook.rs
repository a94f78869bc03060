//! The code that all clips of a pack share: joint frames, mean walks and Rice parameters.

use super::coefficients::{CycleCoefficients, Mean};
use super::cycle::Quantised;
use super::entry_table::table;
use super::frames::Frames;
use super::rice::RiceParameters;
use super::target::{EncodingTarget, JointErrors, hundredths, mean, tenths, worst};
use crate::error::{EncodeError, Result};
use edgegait_core::clip::Clip;
use edgegait_core::codebook::Codebook;
use edgegait_core::format::{
    CHANNELS, CLIP_LOOP, CODEBOOK_BYTES, JOINT_ERRORS_AT, LOOP_HEADER_BYTES,
};
use edgegait_core::skeleton::JOINTS;
use serde::{Deserialize, Serialize};

/// A mean walk, relative to which clips are stored.
#[derive(Clone, Debug)]
pub(super) struct EncodedMeanWalk {
    /// The scale of the numbers.
    pub(super) scale: u8,
    /// The coefficients in steps.
    pub(super) numbers: CycleCoefficients,
    /// The coefficients as they are decoded, radians and metres.
    pub(super) mean: Mean,
}

impl EncodedMeanWalk {
    pub(super) fn new(scale: u8, numbers: CycleCoefficients, frames: &Frames) -> Self {
        let mean = std::array::from_fn(|channel| {
            let step = frames.step(channel, scale);
            let values = numbers[channel].iter();
            values.map(|&number| f64::from(number) * step).collect()
        });
        Self {
            scale,
            numbers,
            mean,
        }
    }
}

/// The joint frames, mean walks and Rice parameters of a pack.
#[derive(Clone, Debug)]
pub(super) struct Code {
    pub(super) frames: Frames,
    pub(super) templates: Vec<EncodedMeanWalk>,
    pub(super) parameters: RiceParameters,
}

/// The sections of a pack that hold a code.
#[derive(Clone, Debug)]
pub(super) struct CodeSections {
    /// The section `CODE`.
    pub(super) codebook: Vec<u8>,
    /// The section `TMPL`.
    pub(super) templates: Vec<u8>,
}

impl CodeSections {
    /// Parses the sections with the core's reader.
    pub(super) fn parsed(&self) -> Result<Codebook<'_>> {
        let parsed = Codebook::parse(&self.codebook);
        let parsed = parsed.and_then(|codebook| codebook.with_templates(&self.templates));
        Ok(parsed.map_err(EncodeError::read_back("the codebook"))?)
    }

    /// Writes each joint's greatest and mean error over all clips into the codebook.
    pub(super) fn state_joint_errors(&mut self, errors: &ErrorsOfAll) {
        for (joint, (most, sum)) in errors.joints.iter().enumerate() {
            let at = JOINT_ERRORS_AT + 4 * joint;
            #[expect(clippy::cast_precision_loss, reason = "clips of a pack")]
            let mean = sum / errors.clips.max(1) as f64;
            self.codebook[at..at + 2].copy_from_slice(&hundredths(*most).to_le_bytes());
            self.codebook[at + 2..at + 4].copy_from_slice(&hundredths(mean).to_le_bytes());
        }
    }
}

/// The errors of each joint over clips: the greatest, and the sum of the means, mm.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct ErrorsOfAll {
    joints: JointErrors,
    clips: usize,
}

impl ErrorsOfAll {
    /// Adds the errors of one clip.
    pub(super) fn add(&mut self, errors: &JointErrors) {
        for (all, own) in self.joints.iter_mut().zip(errors) {
            *all = (all.0.max(own.0), all.1 + own.1);
        }
        self.clips += 1;
    }
}

impl Code {
    /// Returns the sections, without the errors, which are stated later.
    pub(super) fn sections(&self) -> Result<CodeSections> {
        let mut codebook = self.frames.to_bytes();
        codebook.resize(CODEBOOK_BYTES, 0);
        codebook.extend(self.parameters.to_bytes());
        let entries: Vec<Vec<u8>> = self
            .templates
            .iter()
            .map(|template| {
                let written = self.parameters.write_template(&template.numbers);
                [vec![template.scale], written].concat()
            })
            .collect();
        Ok(CodeSections {
            codebook,
            templates: table(&entries)?,
        })
    }

    /// Returns a loop's bytes, relative to a mean walk if its number is given, and its errors after
    /// decoding by the core with `parsed`, the same code.
    pub(super) fn entry(
        &self,
        target: &EncodingTarget<'_>,
        template: Option<usize>,
        quantised: &Quantised,
        parsed: &Codebook<'_>,
    ) -> Result<(Vec<u8>, JointErrors)> {
        let template = template.map_or(0, |number| number + 1);
        let mut bytes = header(target, template, quantised.scale);
        bytes.extend(self.parameters.write_clip(&quantised.numbers));
        let read = Clip::parse(&bytes, parsed).map_err(EncodeError::read_back("a clip"))?;
        let errors = read.as_loop().map(|cycle| target.measure(&cycle));
        let errors = errors.unwrap_or_default();
        bytes[11..13].copy_from_slice(&hundredths(worst(&errors)).to_le_bytes());
        bytes[13..15].copy_from_slice(&hundredths(mean(&errors)).to_le_bytes());
        Ok((bytes, errors))
    }
}

/// Returns a loop's header without its errors.
fn header(target: &EncodingTarget<'_>, template: usize, scale: u8) -> Vec<u8> {
    let cycle = target.cycle;
    let mut bytes = Vec::with_capacity(LOOP_HEADER_BYTES);
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "checked: at most 255 templates, 4,000 s, 2,000 m and 65,535 frames"
    )]
    {
        bytes.extend([CLIP_LOOP, template as u8, scale]);
        bytes.extend(((cycle.period_s * 1e6).round() as u32).to_le_bytes());
        bytes.extend(((cycle.drift_m * 1e6).round() as i32).to_le_bytes());
        bytes.extend([0; 4]);
        bytes.extend(tenths(cycle.closure_mm).to_le_bytes());
        bytes.extend((target.len() as u16).to_le_bytes());
    }
    bytes
}

/// A code as it is stored in a file: numbers of the pack format, by joint and channel.
#[derive(Serialize, Deserialize)]
pub(super) struct StoredCode {
    /// The references and bases of the joints, and the step offsets of the channels.
    frames: (Vec<[i16; 3]>, Vec<[i16; 3]>, Vec<u8>),
    /// The scale and numbers of each mean walk.
    templates: Vec<(u8, Vec<Vec<i32>>)>,
    parameters: RiceParameters,
}

impl StoredCode {
    /// Returns the code, if its numbers of joints and channels are right.
    pub(super) fn code(self) -> Option<Code> {
        let (references, bases, steps) = self.frames;
        let frames = Frames::new(
            references.try_into().ok()?,
            bases.try_into().ok()?,
            steps.try_into().ok()?,
        );
        let template = |(scale, numbers): (u8, Vec<Vec<i32>>)| {
            Some(EncodedMeanWalk::new(
                scale,
                numbers.try_into().ok()?,
                &frames,
            ))
        };
        let templates: Option<_> = self.templates.into_iter().map(template).collect();
        let is_whole = self.parameters.channels() == CHANNELS;
        Some(Code {
            templates: templates?,
            frames,
            parameters: self.parameters,
        })
        .filter(|_| is_whole)
    }
}

#[cfg(test)]
impl From<&Code> for StoredCode {
    fn from(code: &Code) -> Self {
        let (references, bases, steps) = code.frames.numbers();
        let template = |one: &EncodedMeanWalk| (one.scale, one.numbers.to_vec());
        Self {
            frames: (references.to_vec(), bases.to_vec(), steps.to_vec()),
            templates: code.templates.iter().map(template).collect(),
            parameters: code.parameters.clone(),
        }
    }
}

/// Checks the numbers of joints and channels of the stored code.
const _: () = assert!(JOINTS == 19 && CHANNELS == 60);
