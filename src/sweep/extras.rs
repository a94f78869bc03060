//! What stands beside a walker.

use super::walker::{Moment, PosedWalker, Walker};
use crate::confounders::image::{self, Sun};
use crate::confounders::{ConfounderKind, DosePlan};
use edgegait_core::body::{Figure, UnpackedBody};

/// What a frame's picture has besides the figure.
pub(super) struct Extras<'a> {
    /// Strides since the first frame.
    pub(super) strides: f64,
    shadow: Option<Box<UnpackedBody>>,
    /// The figure at moments around that of the frame, its own among them.
    pub exposures: Vec<Figure<'a>>,
}

impl<'a> Extras<'a> {
    /// Those of the figure at a moment.
    pub(super) fn new(
        plan: &DosePlan,
        walker: &Walker<'a>,
        moment: Moment,
        posed: &PosedWalker<'a>,
    ) -> Self {
        let floor = walker.floor(posed.pelvis);
        let shadow = plan.strength(ConfounderKind::Shadow).zip(sun());
        let shadow =
            shadow.map(|(strength, sun)| image::shadow_body(&posed.figure, sun, &floor, strength));
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
    /// The figure's shadow.
    pub(super) fn shadow(&self) -> Option<Figure<'_>> {
        self.shadow.as_deref().map(Figure::at_rest)
    }
}

/// Pictures that an exposure is made of.
pub(super) const EXPOSURES: u32 = 7;

pub(super) fn sun() -> Option<Sun> {
    Sun::from_degrees(SUN_AZIMUTH_DEG, SUN_ELEVATION_DEG).ok()
}

/// Where the sun stands that casts shadows, degrees: ahead of the walker to the left. Ours: a summer
/// afternoon's, with shadows as long as figures.
pub(super) const SUN_AZIMUTH_DEG: f32 = 60.0;

pub(super) const SUN_ELEVATION_DEG: f32 = 45.0;
