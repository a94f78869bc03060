//! Finds the cycles of a whole sequence.

use super::found::FoundCycles;
use super::{CycleDetector, DetectedCycle, FrameRateError, LowerBody, NoCycle};
use std::ops::Range;

/// A finder of gait cycles in recordings of one frame rate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CycleFinder {
    frame_rate_hz: f32,
    view: FinderView,
}

/// What is known about the camera.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum FinderView {
    Unknown,
    Side,
}

impl CycleFinder {
    /// Makes a finder for this many frames a second, of walkers who take 70 to 220 steps a minute.
    ///
    /// # Errors
    /// Unless there are 10 to 120 frames a second.
    pub fn new(frame_rate_hz: f32) -> Result<Self, FrameRateError> {
        CycleDetector::new(frame_rate_hz)?;
        Ok(Self {
            frame_rate_hz,
            view: FinderView::Unknown,
        })
    }

    /// Also finds walkers of 35 to 70 steps a minute, if the camera sees the walker from the side.
    /// Obliquely from in front or behind, a slow walker's steps look like the whole cycles of another.
    #[must_use]
    pub const fn from_the_side(self) -> Self {
        Self {
            view: FinderView::Side,
            ..self
        }
    }

    /// Finds the cycles of a sequence by the wave that fits four steps best, as on a board
    /// ([`CycleDetector`]). `frames` are the legs in each frame, `None` where nobody is
    /// visible.
    ///
    /// # Errors
    /// The reason why there are no cycles. It is not a fault of the sequence: a person may stand.
    pub fn find(
        &self,
        frames: impl IntoIterator<Item = Option<LowerBody>>,
    ) -> Result<FoundCycles, NoCycle> {
        let frames: Vec<Option<LowerBody>> = frames.into_iter().collect();
        let found = self.detect(frames.iter().copied());
        match (self.view, found) {
            (
                FinderView::Side,
                Err(reason @ (NoCycle::Slower { .. } | NoCycle::Irregular { .. })),
            ) => {
                // Every second frame shows the walker at twice the speed.
                let twice = self.detect(frames.iter().copied().step_by(2));
                twice.map(FoundCycles::at_half_speed).map_err(|_| reason)
            }
            (_, found) => found,
        }
    }

    fn detect(
        &self,
        frames: impl Iterator<Item = Option<LowerBody>>,
    ) -> Result<FoundCycles, NoCycle> {
        let Ok(mut detector) = CycleDetector::new(self.frame_rate_hz) else {
            return Err(NoCycle::TooShort { frames: 0 });
        };
        let mut cycles = Vec::new();
        for frame in frames {
            cycles.extend(detector.push(frame));
        }
        let mut rest = detector.finish();
        cycles.extend(&mut rest);
        let frames = rest.detector().frames();
        let reason = match rest.detector().walking() {
            Err(reason) => reason,
            // Long enough, but without three steps in a row.
            Ok(end) if frames as f64 >= 2.0 * f64::from(end.period_frames) => NoCycle::Irregular {
                regular: end.regular,
            },
            Ok(_) => NoCycle::TooShort { frames },
        };
        FoundCycles::collect(cycles, reason)
    }
}

/// Returns the whole frames of a cycle, `ceil(start)..ceil(end)`, so that each belongs to one
/// cycle.
#[must_use]
pub fn whole_frames(cycle: &DetectedCycle) -> Range<usize> {
    cycle.start.ceil() as usize..cycle.end.ceil() as usize
}

/// Measures the legs in each frame of an array `[frames][rows][columns]`; pixels of 128 and more
/// are on. An incomplete last frame is left out, and without rows or columns there are no frames.
pub fn lower_bodies(
    pixels: &[u8],
    [rows, columns]: [usize; 2],
) -> impl Iterator<Item = Option<LowerBody>> {
    let frame = rows.saturating_mul(columns);
    let frames = if frame == 0 { &[] } else { pixels };
    let frames = frames.chunks_exact(frame.max(1));
    frames.map(move |pixels| LowerBody::of_pixels(pixels, columns))
}
