//! Inverse kinematics of a leg of two links, in closed form.

use glam::{DQuat, DVec3};

/// The share of its length to which a leg may be stretched, since nearly straight knees bend too
/// fast. Our choice: knees are bent by 16 degrees there.
const BENT: f64 = 0.99;

/// The joints of a leg in the walker's space, with their orientations.
#[derive(Clone, Copy, Debug)]
pub(super) struct PosedLeg {
    pub hip: DVec3,
    pub knee: DVec3,
    pub ankle: DVec3,
    pub thigh: DQuat,
    pub shank: DQuat,
}

/// A shank's direction relative to its thigh: the angle by which it is bent backwards about the
/// thigh's X, and its component along that axis, which bending does not change.
#[derive(Clone, Copy, Debug)]
struct ShankBend {
    flexion: f64,
    aside: f64,
}

impl ShankBend {
    /// Returns the cosine of the angle between shank and thigh with the knee straight.
    fn cosine_if_straight(self) -> f64 {
        libm::sqrt(1.0 - self.aside * self.aside)
    }
}

impl PosedLeg {
    /// Returns the lengths of thigh and shank, metres.
    fn lengths(&self) -> (f64, f64) {
        (self.hip.distance(self.knee), self.knee.distance(self.ankle))
    }

    /// Returns the hinge axis (the thigh's X, made normal to the thigh), and the unit vectors down
    /// the thigh and in the direction in which the shank bends.
    fn axes(&self) -> [DVec3; 3] {
        let down = (self.knee - self.hip).normalize();
        let hinge = (self.thigh * DVec3::X)
            .reject_from_normalized(down)
            .normalize();
        [hinge, down, hinge.cross(down)]
    }

    fn bend(&self) -> ShankBend {
        let [hinge, down, back] = self.axes();
        let shank = (self.ankle - self.knee).normalize();
        ShankBend {
            flexion: libm::atan2(back.dot(shank), down.dot(shank)),
            aside: hinge.dot(shank),
        }
    }

    /// Returns the largest distance of the ankle from the hip, metres: the present one, or [`BENT`]
    /// times the straight leg's length if that is larger.
    pub(super) fn reach(&self) -> f64 {
        let (thigh, shank) = self.lengths();
        let straight = self.bend().cosine_if_straight();
        let longest = libm::sqrt(thigh * thigh + shank * shank + 2.0 * thigh * shank * straight);
        self.hip.distance(self.ankle).max(BENT * longest)
    }

    /// Returns the leg with its hip moved to `hip`, and its ankle at `ankle` or as near as it
    /// reaches.
    ///
    /// The knee bends forwards about the thigh's X by the law of cosines; then the whole leg turns
    /// about the hip by the least angle. An overstretched knee keeps the share `overstretch`
    /// (0..=1) of its overstretching; at 0 the ankle reaches its target.
    pub(super) fn reaching(&self, hip: DVec3, ankle: DVec3, overstretch: f64) -> Self {
        let (thigh, shank) = self.lengths();
        let bend = self.bend();
        let square = hip.distance_squared(ankle);
        let cosine = (square - thigh * thigh - shank * shank) / (2.0 * thigh * shank);
        let flexion = libm::acos((cosine / bend.cosine_if_straight()).clamp(-1.0, 1.0));
        let flexion = flexion - 2.0 * overstretch * (-bend.flexion).max(0.0);
        let [hinge, ..] = self.axes();
        let at_knee = DQuat::from_axis_angle(hinge, flexion - bend.flexion);
        let bent = self.knee + at_knee * (self.ankle - self.knee);
        let at_hip =
            DQuat::from_rotation_arc((bent - self.hip).normalize(), (ankle - hip).normalize());
        let knee = hip + at_hip * (self.knee - self.hip);
        Self {
            hip,
            knee,
            ankle: knee + at_hip * (bent - self.knee),
            thigh: at_hip * self.thigh,
            shank: at_hip * at_knee * self.shank,
        }
    }
}
