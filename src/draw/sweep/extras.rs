//! Additions to a walker's frame: shadow and exposures.

use super::posed_walker::PosedWalker;
use super::walker::{Moment, Walker};
use crate::draw::confounders::image::{self, Sun};
use crate::draw::confounders::{ConfounderKind, DosePlan};
use edgegait_core::body::{Figure, UnpackedBody};

/// The additions to the figure in a frame's picture.
pub(super) struct Extras<'a> {
    /// The number of strides since the first frame.
    pub(super) strides: f64,
    shadow: Option<Box<UnpackedBody>>,
    /// The figure at the moments of the exposure, which include the frame's own.
    pub exposures: Vec<Figure<'a>>,
}

impl<'a> Extras<'a> {
    /// Computes the additions to the figure at a moment.
    pub(super) fn new(
        plan: &DosePlan,
        walker: &Walker<'a>,
        moment: Moment,
        posed: &PosedWalker<'a>,
    ) -> Self {
        let shadow = plan.strength(ConfounderKind::Shadow).zip(sun());
        let shadow = shadow.map(|(strength, sun)| {
            image::shadow_body(&posed.figure, sun, &walker.floor(posed.pelvis), strength)
        });
        let blur = plan.amount(ConfounderKind::MotionBlur);
        let exposures = blur.map_or(Vec::new(), |exposure_s| {
            let exposure = |number: u32| {
                let share = f64::from(number) / f64::from(EXPOSURES - 1) - 0.5;
                walker.passing(moment, share * exposure_s)
            };
            (0..EXPOSURES).map(exposure).collect()
        });
        Self {
            strides: walker.strides(moment),
            shadow,
            exposures,
        }
    }
}

impl Extras<'_> {
    /// Returns the figure's shadow, if there is one.
    pub(super) fn shadow(&self) -> Option<Figure<'_>> {
        self.shadow.as_deref().map(Figure::at_rest)
    }
}

/// The number of pictures in an exposure.
pub(super) const EXPOSURES: u32 = 7;

pub(super) fn sun() -> Option<Sun> {
    Sun::from_degrees(SUN_AZIMUTH_DEG, SUN_ELEVATION_DEG).ok()
}

/// The direction of the sun, degrees: ahead of the walker to the left. Our choice: a summer
/// afternoon, with shadows as long as the figures are high.
pub(super) const SUN_AZIMUTH_DEG: f32 = 60.0;

pub(super) const SUN_ELEVATION_DEG: f32 = 45.0;
