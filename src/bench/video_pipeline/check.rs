//! Checks before measuring that a model can take its input from a video, and that the video has a
//! gait cycle.

use crate::dataset::gait_cycles::{CycleFinder, LowerBody, NoCycle};
use crate::draw::sweep::FramingMode;
use crate::error::{Error, Result, TemplateOrigin};
use crate::files::InputFile;
use crate::inference::Model;
use crate::segment::{Segmenter, Video};
use edgegait_core::budget::CYCLE_STEPS_PER_MINUTE;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// The properties of a video.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct CheckedVideo {
    /// The pixels of a row.
    pub columns: u32,
    /// The number of rows.
    pub rows: u32,
    /// The frames a second.
    pub fps: f64,
    /// The number of frames.
    pub frames: usize,
    /// The number of frames in which nobody was found.
    pub empty_frames: usize,
    /// The number of gait cycles.
    pub cycles: usize,
}

/// Rejects a model whose input cannot be made from a video.
///
/// # Errors
/// If the contract has a size that silhouettes do not have, a framing that depends on the camera's
/// position, or a viewpoint as an input.
pub(crate) fn check_model(model: &Model) -> Result<()> {
    let contract = model.contract();
    let size = contract.size().unwrap_or_default();
    contract.require(size, None, TemplateOrigin::Drawn)?;
    if let Some(input) = &contract.view_input {
        return Err(Error::input(
            model.path(),
            format!(
                "expected a contract without view_input, found {input:?}: the viewpoint of a video is unknown"
            ),
        ));
    }
    match contract.framing {
        FramingMode::Height | FramingMode::Box => Ok(()),
        FramingMode::Cycle | FramingMode::Camera => Err(Error::input(
            model.path(),
            format!(
                "expected a contract with framing \"height\" or \"box\", found {:?}: it depends on the camera's position, which is unknown for a video",
                contract.framing.name()
            ),
        )),
    }
}

/// Segments a video once and finds its gait cycles, on all cores. Returns its properties, and the
/// entry of its file for the results. `progress` is called for each frame. Memory holds the leg
/// measurements of all frames, but not their pixels.
///
/// # Errors
/// If the video cannot be read, or has no gait cycle; the error then states what was found, and how
/// many frames two cycles take.
pub(crate) fn check(
    mut video: Video,
    path: &Path,
    fps: f32,
    segmenter: &Segmenter,
    progress: &(dyn Fn() -> Result<()> + Sync),
) -> Result<(CheckedVideo, InputFile)> {
    let finder = CycleFinder::new(fps)?;
    let (columns, rows) = video.size();
    let mut legs: Vec<Option<LowerBody>> = Vec::new();
    loop {
        let batch = video.batch()?;
        if batch.is_empty() {
            break;
        }
        let find = |frame| {
            let mask = segmenter.segment(frame).mask;
            progress()?;
            Ok(LowerBody::of_pixels(&mask.grey(), mask.columns()))
        };
        legs.extend(batch.par_iter().map(find).collect::<Result<Vec<_>>>()?);
    }
    let frames = legs.len();
    let empty_frames = legs.iter().filter(|legs| legs.is_none()).count();
    let found = finder.find(legs);
    let found = found.map_err(|reason| none(path, reason, fps, frames, empty_frames))?;
    let checked = CheckedVideo {
        columns,
        rows,
        fps: fps.into(),
        frames,
        empty_frames,
        cycles: found.cycles.len(),
    };
    Ok((checked, video.input()?))
}

/// Returns the error for a video without a gait cycle.
fn none(path: &Path, reason: NoCycle, fps: f32, frames: usize, empty: usize) -> Error {
    let (slow, fast) = CYCLE_STEPS_PER_MINUTE;
    // Two cycles are four steps.
    let frames_of = |steps_a_minute: f32| (4.0 * 60.0 / steps_a_minute * fps).ceil();
    Error::input(
        path,
        format!(
            "{reason}; {} of {frames} frames show a person, and at {fps} frames a second two cycles are {} (the fastest steps) to {} frames",
            frames - empty,
            frames_of(fast),
            frames_of(slow)
        ),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_error_without_a_cycle_states_frames() {
        // 4 x 60 / 220 x 25 = 27.3 and 4 x 60 / 70 x 25 = 85.7.
        let error = none(
            Path::new("walk"),
            NoCycle::TooShort { frames: 12 },
            25.0,
            12,
            3,
        );
        assert_eq!(
            error.to_string(),
            "walk: expected a whole gait cycle, found 12 frames, which are too few (record two cycles or more); 9 of 12 frames show a person, and at 25 frames a second two cycles are 28 (the fastest steps) to 86 frames"
        );
    }
}
