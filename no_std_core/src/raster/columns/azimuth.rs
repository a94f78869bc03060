//! The viewpoints of the column rasteriser: one azimuth, and elevations.

use crate::budget::{LANES, MAX_ELEVATIONS};
use crate::camera::Viewpoint;
use core::fmt;
use glam::Vec3;

/// Viewpoints that differ only in their elevations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Azimuth {
    pub(super) right: Vec3,
    /// Cosines and sines of the first sixteen elevations, one a lane.
    pub(super) cos: [f32; LANES],
    pub(super) sin: [f32; LANES],
    /// Cosines and sines of the others, twice if they are few, and all of that again with the
    /// opposite sign.
    pub(super) cos_rest: [f32; LANES],
    pub(super) sin_rest: [f32; LANES],
    /// Whether there are at most four others.
    pub(super) is_few: bool,
    /// Whether no elevation is below the horizon.
    pub(super) is_above: bool,
    count: usize,
}

/// The reason why viewpoints cannot be drawn in one pass.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum AzimuthError {
    /// The number of viewpoints is out of range.
    Elevations(usize),
    /// The viewpoint with this number has another azimuth than the first one.
    Differs(usize),
    /// The camera of the viewpoint with this number is rolled: its image's right is not level.
    Rolled(usize),
}

impl fmt::Display for AzimuthError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Elevations(found) => write!(
                f,
                "expected 1 to {MAX_ELEVATIONS} viewpoints of one azimuth, found {found}"
            ),
            Self::Differs(at) => write!(
                f,
                "viewpoint {at}: expected the azimuth of the first one (draw it separately)"
            ),
            Self::Rolled(at) => write!(
                f,
                "viewpoint {at}: expected an upright camera, found a rolled one (draw it with rows)"
            ),
        }
    }
}

impl core::error::Error for AzimuthError {}

impl Azimuth {
    /// Checks and groups viewpoints whose images have the same right, in the order of the images.
    ///
    /// # Errors
    /// For none, more than [`MAX_ELEVATIONS`], rolled cameras, or different azimuths.
    pub fn new(viewpoints: &[Viewpoint]) -> Result<Self, AzimuthError> {
        let count = viewpoints.len();
        let Some(first) = viewpoints.first().filter(|_| count <= MAX_ELEVATIONS) else {
            return Err(AzimuthError::Elevations(count));
        };
        // A NaN fails the comparisons.
        let is_upright = |it: &Viewpoint| it.right().y == 0.0 && it.up().y >= 0.0;
        if let Some(at) = viewpoints.iter().position(|it| !is_upright(it)) {
            return Err(AzimuthError::Rolled(at));
        }
        let right = first.right();
        if let Some(at) = viewpoints.iter().position(|other| other.right() != right) {
            return Err(AzimuthError::Differs(at));
        }
        let mut azimuth = Self {
            right,
            cos: [1.0; LANES],
            sin: [0.0; LANES],
            cos_rest: [1.0; LANES],
            sin_rest: [0.0; LANES],
            is_few: count <= LANES + LANES / 4,
            is_above: viewpoints.iter().all(|it| it.toward().y >= 0.0),
            count,
        };
        let first = azimuth.cos.iter_mut().zip(&mut azimuth.sin);
        let rest = azimuth.cos_rest.iter_mut().zip(&mut azimuth.sin_rest);
        for (viewpoint, (cos, sin)) in viewpoints.iter().zip(first.chain(rest)) {
            (*cos, *sin) = (viewpoint.up().y, viewpoint.toward().y);
        }
        for rest in [&mut azimuth.cos_rest, &mut azimuth.sin_rest] {
            if azimuth.is_few {
                rest.copy_within(..LANES / 4, LANES / 4);
            }
            let (rest, opposite) = rest.split_at_mut(LANES / 2);
            for (opposite, rest) in opposite.iter_mut().zip(rest) {
                *opposite = -*rest;
            }
        }
        Ok(azimuth)
    }

    /// Returns the number of viewpoints.
    #[must_use]
    pub const fn count(&self) -> usize {
        self.count
    }
}
