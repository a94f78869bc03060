//! Confounders of pace: faster, slower, aged, or hindered walking.

use super::GaitFacts;
use super::excursion::scale;
use super::trunk::{Lean, lean};
use edgegait_core::pose::Pose;
use edgegait_core::skeleton::Joint;

/// The power of speed with which step frequency grows (Grieve & Gear 1966, Ergonomics 9:379-399);
/// stride length grows with the rest.
const FREQUENCY_POWER: f64 = 0.58;

/// The factor on speed at strength 1 of [`speed`]. Our choice: 5 km/h become 7.5 or 3.3, the range
/// in which people walk.
const SPEED_RATIO: f64 = 1.5;

/// The ratio of walking speeds at 80 years or more and in the twenties: 0.97 to 1.36 m/s for men,
/// 0.94 to 1.34 m/s for women (Bohannon & Williams Andrews 2011, Physiotherapy 97:182-189, as
/// recalled).
const AGED_SPEED_RATIO: f64 = 0.71;

/// The share of the stride that a long skirt takes: its hem, taut around both legs, would have to be
/// wider than free legs stride otherwise. Our choice.
const HINDERED: f64 = 0.2;

/// The stoop at 80 years compared with the twenties, degrees forward from the joint below. The
/// head turns back by five sixths of the sum of the others.
///
/// Thoracic kyphosis grows by about 12 degrees from the twenties to the seventies (Fon, Pitt
/// & Thies 1980, AJR 134:979-983, as recalled): the chest's chord tips by half of this, the base
/// of the neck by all. The shares of spine and head are ours.
const STOOP: Lean = Lean {
    pelvis_deg: 0.0,
    spine_deg: 3.0,
    thorax_deg: 7.0,
    neck_deg: 8.0,
    head_deg: -15.0,
};

/// The factors by which a change of speed changes a cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Pace {
    /// The factor on the stride length and on the joints' excursions.
    pub stride: f64,
    /// The factor on the cycle's duration.
    pub duration: f64,
}

impl Pace {
    /// Returns the pace at `ratio` times the speed.
    fn of_speed_ratio(ratio: f64) -> Self {
        Self {
            stride: libm::pow(ratio, 1.0 - FREQUENCY_POWER),
            duration: libm::pow(ratio, -FREQUENCY_POWER),
        }
    }
}

/// Returns the pace of [`speed`] at a strength of -1..=1.
#[must_use]
pub(crate) fn speed_pace(strength: f64) -> Pace {
    Pace::of_speed_ratio(libm::pow(SPEED_RATIO, strength))
}

/// Returns the pace of [`age_gait`] at a strength of 0..=1.
#[must_use]
pub(crate) fn age_pace(strength: f64) -> Pace {
    Pace::of_speed_ratio(libm::pow(AGED_SPEED_RATIO, strength))
}

/// Returns the pace of [`skirt_gait`] at a strength of 0..=1.
#[must_use]
pub(crate) fn skirt_pace(strength: f64) -> Pace {
    Pace {
        stride: 1.0 - HINDERED * strength,
        duration: 1.0,
    }
}

/// Shortens the steps as a skirt does: the excursions of all joints shrink with the stride. Strength
/// 0..=1: the length of the skirt.
pub(crate) fn skirt_gait(pose: &mut Pose, gait: &GaitFacts, strength: f64) {
    if strength != 0.0 {
        scale(pose, gait, Joint::ALL, skirt_pace(strength).stride);
    }
}

/// Changes the walking speed: all joints' excursions about their means grow with the stride
/// length. Strength -1..=1: 1 is 1.5 times as fast, -1 two thirds.
///
/// The mean pose and the root stay the same, since in this narrow range of speeds the means of
/// knees and hips change by less than a person's standard deviation (Schwartz et al. 2008,
/// J. Biomech. 41:1639-1650).
pub(crate) fn speed(pose: &mut Pose, gait: &GaitFacts, strength: f64) {
    if strength != 0.0 {
        scale(pose, gait, Joint::ALL, speed_pace(strength).stride);
    }
}

/// Ages the gait by a stoop and shorter steps. Strength 0..=1: 1 is 80 years, compared with the
/// norms' adults in their twenties.
///
/// Excursions shrink with the stride at the speed that old people prefer: their gait equals that
/// of young people at the same low speed (Ferrandez et al. 1990).
pub(crate) fn age_gait(pose: &mut Pose, gait: &GaitFacts, strength: f64) {
    if strength != 0.0 {
        scale(pose, gait, Joint::ALL, age_pace(strength).stride);
        lean(pose, STOOP, strength);
    }
}
