//! Walking faster, slower, or as the old do.

use super::GaitFacts;
use super::excursion::scale;
use super::trunk::{Lean, lean};
use edgegait_core::pose::Pose;
use edgegait_core::skeleton::Joint;

/// Step frequency grows with speed to this power (Grieve & Gear 1966, Ergonomics 9:379-399);
/// stride length takes the rest.
const FREQUENCY_POWER: f64 = 0.58;

/// How many times as fast strength 1 of [`speed`] is. Ours: 5 km/h become 7.5 or 3.3, the
/// range in which people walk.
const SPEED_RATIO: f64 = 1.5;

/// Walking speed at 80 years or more over that of the twenties: 0.97 over 1.36 m/s for men,
/// 0.94 over 1.34 for women (Bohannon & Williams Andrews 2011, Physiotherapy 97:182-189, as
/// recalled).
const AGED_SPEED_RATIO: f64 = 0.71;

/// Stoop at 80 years against the twenties, degrees forward from the joint below; the head
/// turns back by as much as all of them, but for a sixth.
///
/// Thoracic kyphosis grows by about 12 degrees from the twenties to the seventies (Fon, Pitt
/// & Thies 1980, AJR 134:979-983, as recalled): the chest's chord tips by half of it, the base
/// of the neck by all. The spine's share and the head's are ours.
const STOOP: Lean = Lean {
    pelvis_deg: 0.0,
    spine_deg: 3.0,
    thorax_deg: 7.0,
    neck_deg: 8.0,
    head_deg: -15.0,
};

/// What a change of speed makes of a cycle: factors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Pace {
    /// Of the stride length and of the joints' excursions.
    pub stride: f64,
    /// Of the cycle's duration.
    pub duration: f64,
}

impl Pace {
    /// `ratio` times as fast.
    fn of_speed_ratio(ratio: f64) -> Self {
        Self {
            stride: libm::pow(ratio, 1.0 - FREQUENCY_POWER),
            duration: libm::pow(ratio, -FREQUENCY_POWER),
        }
    }
}

/// The pace of [`speed`] at a strength of -1..=1.
#[must_use]
pub(crate) fn speed_pace(strength: f64) -> Pace {
    Pace::of_speed_ratio(libm::pow(SPEED_RATIO, strength))
}

/// The pace of [`age_gait`] at a strength of 0..=1.
#[must_use]
pub(crate) fn age_pace(strength: f64) -> Pace {
    Pace::of_speed_ratio(libm::pow(AGED_SPEED_RATIO, strength))
}

/// Walks at another speed: all joints' excursions about their means grow with the stride
/// length. Strength -1..=1: 1 is 1.5 times as fast, -1 two thirds.
///
/// The mean pose and the root stay as they are: a narrow range of speeds, where the knees'
/// and the hips' means change by less than a person's standard deviation (Schwartz et al.
/// 2008, J. Biomech. 41:1639-1650).
pub(crate) fn speed(pose: &mut Pose, gait: &GaitFacts, strength: f64) {
    if strength != 0.0 {
        scale(pose, gait, Joint::ALL, speed_pace(strength).stride);
    }
}

/// Walks as the old do: stoops, and takes shorter steps. Strength 0..=1: 1 is 80 years
/// against the adults in their twenties of the norms.
///
/// Excursions shrink as the stride does at the speed that the old prefer: their gait is that
/// of the young at the same low speed (Ferrandez et al. 1990).
pub(crate) fn age_gait(pose: &mut Pose, gait: &GaitFacts, strength: f64) {
    if strength != 0.0 {
        scale(pose, gait, Joint::ALL, age_pace(strength).stride);
        lean(pose, STOOP, strength);
    }
}
