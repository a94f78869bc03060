//! Encoding of all clips of a pack and of their shared code.

use super::codebook::{Code, CodeSections, ErrorsOfAll};
use super::cycle::{Quantised, plainly, quantise};
use super::frames::Frames;
use super::mean_walks::MeanWalks;
use super::rice::RiceParameters;
use super::target::{EncodingTarget, JointErrors, worst};
use super::uncut::{encode_uncut, looking_ahead, measure_joints};
use crate::error::{EncodeError, Error, Result};
use crate::people::UncutMotion;
use edgegait_core::clip::Clip;
use edgegait_core::codebook::Codebook;
use edgegait_core::skeleton::{JOINTS, Skeleton};
use glam::{DQuat, DVec3};
use rayon::prelude::*;
use std::borrow::Cow;

/// The maximum number of repetitions of a clip's encoding where the decoder's f32 exceeds the
/// stated error, and the factor by which each tightens the bound.
pub(super) const TRIES: usize = 3;
pub(super) const TIGHTER: f64 = 0.98;

/// A motion to encode, on its walker's skeleton.
pub(super) enum EncodableMotion<'a> {
    Loop(Box<EncodingTarget<'a>>),
    Uncut(&'a UncutMotion, Box<Skeleton>),
}

/// The sections of a pack that hold motion.
pub(super) struct MotionSections {
    /// The sections of the code that clips share.
    pub(super) sections: CodeSections,
    /// The entries of section `CLIP`, in the order of the motions.
    pub(super) clips: Vec<Vec<u8>>,
}

/// The reason why motions were not encoded.
pub(super) enum Stopped {
    /// The numbers of motions that cannot be encoded, with their errors.
    Motions(Vec<(usize, Error)>),
    /// Any other error.
    Else(Error),
}

impl<E: Into<Error>> From<E> for Stopped {
    fn from(error: E) -> Self {
        Self::Else(error.into())
    }
}

/// Returns the results of all motions, or the errors of all motions that failed.
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

/// The joint frames and mean walks that all clips of a pack share.
struct SharedTables {
    frames: Frames,
    templates: MeanWalks,
}

impl MotionSections {
    /// Encodes motions, each within `max_error_mm` where the format allows.
    ///
    /// # Errors
    /// If there are cycles in which a joint turns almost full circle from its mean over the pack,
    /// or uncut motions that [`encode_uncut`] rejects; the error lists all of them.
    pub(super) fn encode(
        motions: &[EncodableMotion<'_>],
        max_error_mm: f64,
        progress: &(dyn Fn() -> Result<()> + Sync),
    ) -> std::result::Result<Self, Stopped> {
        let frames = fit_frames(motions);
        let (numbers, targets): (Vec<usize>, Vec<&EncodingTarget<'_>>) = motions
            .iter()
            .enumerate()
            .filter_map(|(number, motion)| match motion {
                EncodableMotion::Loop(target) => Some((number, target.as_ref())),
                EncodableMotion::Uncut(..) => None,
            })
            .unzip();
        let sketches = targets
            .par_iter()
            .zip(&numbers)
            .map(|(target, &number)| {
                progress()?;
                let sketch = plainly(target, &frames, None, max_error_mm);
                let sketch = sketch.ok_or_else(|| EncodeError::TurnsTooFar.into());
                Ok((number, sketch))
            })
            .collect::<Result<_>>()?;
        let sketches = all(sketches)?;
        let templates = MeanWalks::fit(&sketches, &frames);
        let shared = SharedTables { frames, templates };
        let quantised = (0..targets.len())
            .into_par_iter()
            .map(|clip| {
                let one = shared.quantise(targets[clip], clip, max_error_mm);
                progress()?;
                Ok((numbers[clip], one))
            })
            .collect::<Result<_>>()?;
        let mut quantised = all(quantised)?;
        let mut written = shared.write(&targets, &quantised)?;
        let mut bound_mm = max_error_mm;
        for _ in 0..TRIES {
            let missed: Vec<usize> = (0..targets.len())
                .filter(|&clip| {
                    let worst = worst(&written.errors[clip]);
                    // Errors far beyond the bound mean that the format has no finer steps.
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
        let WrittenLoops {
            mut sections,
            clips,
            mut errors,
        } = written;
        let takes = takes(motions, &sections.codebook, max_error_mm, progress)?;
        let (mut loops, mut rest) = (clips.into_iter(), Vec::with_capacity(motions.len()));
        let mut takes = takes.into_iter();
        for motion in motions {
            match motion {
                EncodableMotion::Loop(_) => rest.extend(loops.next()),
                EncodableMotion::Uncut(..) => {
                    if let Some((bytes, own)) = takes.next() {
                        rest.push(bytes);
                        errors.push(own);
                    }
                }
            }
        }
        let mut all = ErrorsOfAll::default();
        errors.iter().for_each(|own| all.add(own));
        sections.state_joint_errors(&all);
        Ok(Self {
            sections,
            clips: rest,
        })
    }
}

/// Returns the code with which these cycles, and any others, can be encoded.
#[cfg(test)]
pub(super) fn settled(motions: &[EncodableMotion<'_>], max_error_mm: f64) -> Code {
    let frames = fit_frames(motions);
    let targets = motions.iter().filter_map(|motion| match motion {
        EncodableMotion::Loop(target) => Some(target.as_ref()),
        EncodableMotion::Uncut(..) => None,
    });
    let targets: Vec<&EncodingTarget<'_>> = targets.collect();
    let sketch = |target: &&EncodingTarget<'_>| plainly(target, &frames, None, max_error_mm);
    let sketches: Option<Vec<_>> = targets.par_iter().map(sketch).collect();
    let templates = MeanWalks::fit(&sketches.expect("cycles"), &frames);
    let shared = SharedTables { frames, templates };
    let quantised: Vec<_> = (0..targets.len())
        .into_par_iter()
        .map(|clip| shared.quantise(targets[clip], clip, max_error_mm))
        .collect::<Result<_>>()
        .expect("cycles");
    let numbers: Vec<_> = quantised
        .iter()
        .map(|quantised_walk| &quantised_walk.numbers)
        .collect();
    let stored = shared.templates.list.iter();
    let stored: Vec<_> = stored.map(|template| template.numbers.clone()).collect();
    Code {
        parameters: RiceParameters::fit(&numbers, &stored).open(),
        frames: shared.frames,
        templates: shared.templates.list,
    }
}

/// Encodes the uncut motions, and returns their bytes and errors.
fn takes(
    motions: &[EncodableMotion<'_>],
    codebook: &[u8],
    max_error_mm: f64,
    progress: &(dyn Fn() -> Result<()> + Sync),
) -> std::result::Result<Vec<(Vec<u8>, JointErrors)>, Stopped> {
    let codebook = Codebook::parse(codebook)?;
    let encoded = |span: &UncutMotion, skeleton: &Skeleton| {
        let bytes = encode_uncut(span, skeleton, &codebook, max_error_mm)?.bytes;
        let errors = Clip::parse(&bytes, &codebook)
            .map_err(EncodeError::read_back("a clip"))?
            .as_uncut()
            .map(|take| measure_joints(span, skeleton, &take));
        Ok((bytes, errors.unwrap_or_default()))
    };
    let results = motions
        .par_iter()
        .enumerate()
        .filter_map(|(number, motion)| match motion {
            EncodableMotion::Loop(_) => None,
            EncodableMotion::Uncut(span, skeleton) => Some((number, span, skeleton)),
        })
        .map(|(number, span, skeleton)| {
            progress()?;
            let encoded = encoded(span, skeleton);
            progress()?;
            Ok((number, encoded))
        })
        .collect::<Result<_>>()?;
    all(results)
}

/// Fits joint frames to all motions.
fn fit_frames(motions: &[EncodableMotion<'_>]) -> Frames {
    let mut offsets = [DVec3::ZERO; JOINTS];
    let mut rotations: Vec<Cow<'_, [[DQuat; JOINTS]]>> = Vec::with_capacity(motions.len());
    for motion in motions {
        let (own, skeleton) = match motion {
            EncodableMotion::Loop(target) => (
                Cow::Borrowed(target.cycle.rotations.as_slice()),
                &target.skeleton,
            ),
            EncodableMotion::Uncut(span, skeleton) => {
                (Cow::Owned(looking_ahead(span)), skeleton.as_ref())
            }
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

/// Encoded loops with their shared code, and the errors that the core's decoder finds.
struct WrittenLoops {
    sections: CodeSections,
    clips: Vec<Vec<u8>>,
    errors: Vec<JointErrors>,
}

impl SharedTables {
    fn quantise(
        &self,
        target: &EncodingTarget<'_>,
        clip: usize,
        max_error_mm: f64,
    ) -> Result<Quantised> {
        let mean = self.templates.mean(clip);
        quantise(target, &self.frames, mean, max_error_mm)
            .ok_or_else(|| EncodeError::TurnsTooFar.into())
    }

    fn write(
        &self,
        targets: &[&EncodingTarget<'_>],
        quantised: &[Quantised],
    ) -> Result<WrittenLoops> {
        let numbers: Vec<_> = quantised
            .iter()
            .map(|quantised_walk| &quantised_walk.numbers)
            .collect();
        let stored = self.templates.list.iter();
        let stored: Vec<_> = stored.map(|template| template.numbers.clone()).collect();
        let code = Code {
            frames: self.frames.clone(),
            templates: self.templates.list.clone(),
            parameters: RiceParameters::fit(&numbers, &stored),
        };
        let sections = code.sections()?;
        let parsed = sections.parsed()?;
        let (clips, errors): (Vec<_>, Vec<_>) = targets
            .par_iter()
            .zip(quantised)
            .enumerate()
            .map(|(clip, (target, quantised))| {
                code.entry(target, self.templates.of[clip], quantised, &parsed)
            })
            .collect::<Result<Vec<_>>>()?
            .into_iter()
            .unzip();
        Ok(WrittenLoops {
            sections,
            clips,
            errors,
        })
    }
}
