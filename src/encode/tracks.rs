//! All clips of a pack and what they share.

use super::cycle::{Quantised, plainly, quantise};
use super::frames::Frames;
use super::pack::table;
use super::parameters::Parameters;
use super::take::{encode_take, looking_ahead, measure_joints};
use super::target::{JointErrors, Target};
use super::templates::Templates;
use crate::error::{EncodeError, Error, Result};
use crate::scene::Span;
use edgegait_core::clip::Clip;
use edgegait_core::codebook::Codebook;
use edgegait_core::format::{CLIP_LOOP, CODEBOOK_BYTES, JOINT_ERRORS_AT, LOOP_HEADER_BYTES};
use edgegait_core::skeleton::{JOINTS, Skeleton};
use glam::{DQuat, DVec3};
use rayon::prelude::*;
use std::borrow::Cow;

/// How often a clip is encoded again with a tighter bound because the decoder's f32 put it
/// beyond the stated error, and by how much the bound is tightened.
const TRIES: usize = 3;
const TIGHTER: f64 = 0.98;

/// What is encoded, on its walker's skeleton.
pub(super) enum Motion<'a> {
    Loop(Box<Target<'a>>),
    Take(&'a Span, Box<Skeleton>),
}

/// Sections of a pack that hold motion.
pub(super) struct Tracks {
    /// Section `CODE`.
    pub(super) codebook: Vec<u8>,
    /// Section `TMPL`.
    pub(super) templates: Vec<u8>,
    /// The entries of section `CLIP`, in the order of the motions.
    pub(super) clips: Vec<Vec<u8>>,
}

/// Why motions were not encoded.
pub(super) enum Stopped {
    /// Some of them cannot be: their numbers, and why.
    Motions(Vec<(usize, Error)>),
    /// Anything else.
    Else(Error),
}

impl<E: Into<Error>> From<E> for Stopped {
    fn from(error: E) -> Self {
        Self::Else(error.into())
    }
}

/// What came of each motion, or all of them of which nothing came.
fn all<T>(results: Vec<(usize, Result<T>)>) -> std::result::Result<Vec<T>, Stopped> {
    let (mut good, mut refused) = (Vec::with_capacity(results.len()), Vec::new());
    for (number, result) in results {
        match result {
            Ok(one) => good.push(one),
            Err(error) => refused.push((number, error)),
        }
    }
    if refused.is_empty() {
        Ok(good)
    } else {
        Err(Stopped::Motions(refused))
    }
}

/// What all clips of a pack are encoded with.
struct Shared {
    frames: Frames,
    templates: Templates,
}

impl Tracks {
    /// Encodes motions, each within `max_error_mm` where the format allows.
    ///
    /// # Errors
    /// With the cycles in which a joint turns almost full circle from its mean over the pack, or
    /// the takes that [`encode_take`] refuses.
    pub(super) fn encode(
        motions: &[Motion<'_>],
        max_error_mm: f64,
        progress: &(dyn Fn() + Sync),
    ) -> std::result::Result<Self, Stopped> {
        let frames = fit_frames(motions);
        let (numbers, targets): (Vec<usize>, Vec<&Target<'_>>) = motions
            .iter()
            .enumerate()
            .filter_map(|(number, motion)| match motion {
                Motion::Loop(target) => Some((number, target.as_ref())),
                Motion::Take(..) => None,
            })
            .unzip();
        let sketches = targets
            .par_iter()
            .zip(&numbers)
            .map(|(target, &number)| {
                let sketch = plainly(target, &frames, None, max_error_mm);
                (
                    number,
                    sketch.ok_or_else(|| EncodeError::TurnsTooFar.into()),
                )
            })
            .collect();
        let sketches = all(sketches)?;
        let templates = Templates::fit(&sketches, &frames);
        let shared = Shared { frames, templates };
        let quantised = (0..targets.len())
            .into_par_iter()
            .map(|clip| {
                let one = shared.quantise(targets[clip], clip, max_error_mm);
                progress();
                (numbers[clip], one)
            })
            .collect();
        let mut quantised = all(quantised)?;
        let mut written = shared.write(&targets, &quantised)?;
        let mut bound_mm = max_error_mm;
        for _ in 0..TRIES {
            let missed: Vec<usize> = (0..targets.len())
                .filter(|&clip| {
                    let worst = worst(&written.errors[clip]);
                    // Far beyond it, the format is not finer.
                    worst > max_error_mm && worst < 1.05 * max_error_mm
                })
                .collect();
            if missed.is_empty() {
                break;
            }
            bound_mm *= TIGHTER;
            for clip in missed {
                quantised[clip] = shared.quantise(targets[clip], clip, bound_mm)?;
            }
            written = shared.write(&targets, &quantised)?;
        }
        let Written {
            mut codebook,
            templates,
            clips,
            mut errors,
        } = written;
        let takes = takes(motions, &codebook, max_error_mm, progress)?;
        let (mut loops, mut rest) = (clips.into_iter(), Vec::with_capacity(motions.len()));
        let mut takes = takes.into_iter();
        for motion in motions {
            match motion {
                Motion::Loop(_) => rest.extend(loops.next()),
                Motion::Take(..) => {
                    if let Some((bytes, own)) = takes.next() {
                        rest.push(bytes);
                        errors.push(own);
                    }
                }
            }
        }
        state_joint_errors(&mut codebook, &errors);
        Ok(Self {
            codebook,
            templates,
            clips: rest,
        })
    }
}

/// The takes among the motions: their bytes and errors.
fn takes(
    motions: &[Motion<'_>],
    codebook: &[u8],
    max_error_mm: f64,
    progress: &(dyn Fn() + Sync),
) -> std::result::Result<Vec<(Vec<u8>, JointErrors)>, Stopped> {
    let codebook = Codebook::parse(codebook)?;
    let encoded = |span: &Span, skeleton: &Skeleton| {
        let bytes = encode_take(span, skeleton, &codebook, max_error_mm)?.bytes;
        let errors = Clip::parse(&bytes, &codebook)
            .map_err(EncodeError::read_back("a clip"))?
            .as_take()
            .map(|take| measure_joints(span, skeleton, &take));
        progress();
        Ok((bytes, errors.unwrap_or_default()))
    };
    let results = motions
        .par_iter()
        .enumerate()
        .filter_map(|(number, motion)| match motion {
            Motion::Loop(_) => None,
            Motion::Take(span, skeleton) => Some((number, encoded(span, skeleton))),
        })
        .collect();
    all(results)
}

/// The frames that suit all motions.
fn fit_frames(motions: &[Motion<'_>]) -> Frames {
    let mut offsets = [DVec3::ZERO; JOINTS];
    let mut rotations: Vec<Cow<'_, [[DQuat; JOINTS]]>> = Vec::with_capacity(motions.len());
    for motion in motions {
        let (own, skeleton) = match motion {
            Motion::Loop(target) => (
                Cow::Borrowed(target.cycle.rotations.as_slice()),
                &target.skeleton,
            ),
            Motion::Take(span, skeleton) => (Cow::Owned(looking_ahead(span)), skeleton.as_ref()),
        };
        rotations.push(own);
        #[expect(clippy::cast_precision_loss, reason = "motions of a pack")]
        let share = 1.0 / motions.len() as f64;
        for (sum, offset) in offsets.iter_mut().zip(skeleton.offsets) {
            *sum += share * offset.as_dvec3();
        }
    }
    let rotations: Vec<&[[DQuat; JOINTS]]> = rotations.iter().map(AsRef::as_ref).collect();
    Frames::fit(&rotations, &offsets)
}

/// Loops as bytes, with what they share, and the errors that the core's decoder finds.
struct Written {
    codebook: Vec<u8>,
    templates: Vec<u8>,
    clips: Vec<Vec<u8>>,
    errors: Vec<JointErrors>,
}

impl Shared {
    fn quantise(&self, target: &Target<'_>, clip: usize, max_error_mm: f64) -> Result<Quantised> {
        let mean = self.templates.mean(clip);
        quantise(target, &self.frames, mean, max_error_mm)
            .ok_or_else(|| EncodeError::TurnsTooFar.into())
    }

    fn write(&self, targets: &[&Target<'_>], quantised: &[Quantised]) -> Result<Written> {
        let numbers: Vec<_> = quantised.iter().map(|one| &one.numbers).collect();
        let stored = self.templates.stored.iter();
        let stored: Vec<_> = stored.map(|(_, numbers)| numbers.clone()).collect();
        let parameters = Parameters::fit(&numbers, &stored);
        let mut codebook = self.frames.to_bytes();
        codebook.resize(CODEBOOK_BYTES, 0);
        codebook.extend(parameters.to_bytes());
        let entries: Vec<Vec<u8>> = self
            .templates
            .stored
            .iter()
            .map(|(scale, numbers)| [vec![*scale], parameters.write_template(numbers)].concat())
            .collect();
        let templates = table(&entries)?;
        let parsed = Codebook::parse(&codebook)
            .and_then(|codebook| codebook.with_templates(&templates))
            .map_err(EncodeError::read_back("the codebook"))?;
        let (mut clips, errors): (Vec<_>, Vec<_>) = targets
            .par_iter()
            .zip(quantised)
            .enumerate()
            .map(|(clip, (target, quantised))| {
                let template = self.templates.of[clip].map_or(0, |group| group + 1);
                let mut bytes = header(target, template, quantised.scale);
                bytes.extend(parameters.write_clip(&quantised.numbers));
                let read =
                    Clip::parse(&bytes, &parsed).map_err(EncodeError::read_back("a clip"))?;
                let errors = read.as_loop().map(|cycle| target.measure(&cycle));
                Ok((bytes, errors.unwrap_or_default()))
            })
            .collect::<Result<Vec<_>>>()?
            .into_iter()
            .unzip();
        for (bytes, errors) in clips.iter_mut().zip(&errors) {
            bytes[11..13].copy_from_slice(&hundredths(worst(errors)).to_le_bytes());
            bytes[13..15].copy_from_slice(&hundredths(mean(errors)).to_le_bytes());
        }
        Ok(Written {
            codebook,
            templates,
            clips,
            errors,
        })
    }
}

/// Writes each joint's greatest and mean error over all clips into the codebook.
fn state_joint_errors(codebook: &mut [u8], errors: &[JointErrors]) {
    for joint in 0..JOINTS {
        let at = JOINT_ERRORS_AT + 4 * joint;
        let most = errors
            .iter()
            .map(|errors| errors[joint].0)
            .fold(0.0, f64::max);
        let sum: f64 = errors.iter().map(|errors| errors[joint].1).sum();
        #[expect(clippy::cast_precision_loss, reason = "clips of a pack")]
        let mean = sum / errors.len().max(1) as f64;
        codebook[at..at + 2].copy_from_slice(&hundredths(most).to_le_bytes());
        codebook[at + 2..at + 4].copy_from_slice(&hundredths(mean).to_le_bytes());
    }
}

fn worst(errors: &JointErrors) -> f64 {
    errors.iter().map(|joint| joint.0).fold(0.0, f64::max)
}

fn mean(errors: &JointErrors) -> f64 {
    errors.iter().map(|joint| joint.1).sum::<f64>() / JOINTS as f64
}

/// A loop's header without its errors.
fn header(target: &Target<'_>, template: usize, scale: u8) -> Vec<u8> {
    let cycle = target.cycle;
    let mut bytes = Vec::with_capacity(LOOP_HEADER_BYTES);
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "checked: at most 8 templates, 4,000 s, 2,000 m and 65,535 frames"
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

/// An error in units of 0.01 mm, rounded up so that it is never understated.
pub(super) fn hundredths(error_mm: f64) -> u16 {
    rounded_up(error_mm * 100.0)
}

/// The same in units of 0.1 mm.
fn tenths(error_mm: f64) -> u16 {
    rounded_up(error_mm * 10.0)
}

fn rounded_up(value: f64) -> u16 {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "clamped"
    )]
    let whole = value.ceil().clamp(0.0, 65_535.0) as u16;
    whole
}
