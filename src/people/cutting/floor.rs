//! Levels the floor of a recording.
//!
//! A capture's world is level only as far as its calibration is. On a floor that is tilted against it,
//! feet stand higher and higher on the way. Closing takes that out of a gait cycle, and this module out
//! of motions that are kept uncut.

use super::flat_feet::flat_frames;
use crate::people::cutting::stance::FeetMotion;
use crate::people::extent;
use crate::people::retarget::{ANKLE_HEIGHT, RetargetedMotion};
use edgegait_core::skeleton::Joint;
use glam::{DQuat, DVec3};

/// Steepest tilt of a floor, as rise over run, that counts as an error of the recording: what is
/// steeper was built as a ramp (ISO 21542: 1 in 20).
const STEEPEST: f64 = 0.05;

/// Smallest spread of places where feet stand, as their standard deviation, metres, that shows a tilt
/// in a direction. Our choice: two steps show it, the width of a step does not.
const LEAST_SPREAD_M: f64 = 0.3;

/// Largest distance of standing ankles from a plane that counts as a floor, as root mean square,
/// metres. Our choice: levelled walks are within 0.006, a step of 12 cm on the way is 0.03.
const LARGEST_OFF_M: f64 = 0.01;

/// Rise over the motion beyond which a warning is given, metres. Our choice.
const NOTED_M: f64 = 0.02;

/// Rounds of levelling: feet that stand are found among the lowest ones.
const ROUNDS: usize = 3;

/// Turns a motion so that the floor on which its feet stand is level and at y = 0. Only directions
/// in which one foot stands far enough apart are levelled, so it needs two whole stances. A motion
/// on stairs, on a ramp or on uneven ground stays as it is.
pub(in crate::people) fn level_floor(take: &mut RetargetedMotion) {
    let mut level = take.clone();
    let mut turned = DQuat::IDENTITY;
    for _ in 0..ROUNDS {
        let Some(floor) = StandingPlane::of(&level) else {
            return;
        };
        turned = floor.turn * turned;
        floor.put_level(&mut level);
    }
    // The floor's way up in the recording.
    let up = turned.inverse() * DVec3::Y;
    let rise = DVec3::new(-up.x, 0.0, -up.z) / up.y;
    if rise.length() > STEEPEST {
        return;
    }
    let (low, high) = extent(take.roots.iter().map(|root| rise.dot(*root)));
    if high - low > NOTED_M {
        level.warnings.push(format!(
            "the floor is tilted by {:.1} degrees, {:.0} mm over the walk: levelled",
            libm::atan(rise.length()).to_degrees(),
            1e3 * (high - low)
        ));
    }
    *take = level;
}

/// The floor under a motion.
struct StandingPlane {
    /// The rotation that makes it level.
    turn: DQuat,
    /// Its height after that, metres.
    height_m: f64,
}

impl StandingPlane {
    /// Finds the floor of feet that stand on a plane; a floor that cannot be told from a level one
    /// is level.
    fn of(take: &RetargetedMotion) -> Option<Self> {
        let motion = FeetMotion::of_take(take);
        let stands = motion.stances();
        // Where ankles stand, and the same from the middle of their own foot's: heights of ankles
        // differ.
        let (mut middle, mut places) = (DVec3::ZERO, Vec::new());
        for (side, foot) in [Joint::LeftFoot, Joint::RightFoot].into_iter().enumerate() {
            let own: Vec<bool> = stands.iter().map(|stands| stands[side]).collect();
            let at = |frame: usize| take.posed(frame).0[foot.index()];
            let at: Vec<DVec3> = flat_frames(&own).into_iter().map(at).collect();
            let sum: DVec3 = at.iter().sum();
            middle += sum;
            places.extend(at.iter().map(|place| *place - sum / at.len() as f64));
        }
        let of = |of: &dyn Fn(&DVec3) -> f64| {
            places.iter().map(of).sum::<f64>() / places.len().max(1) as f64
        };
        // Along the axes of most and least spread, slopes are independent.
        let [xx, zz, xz] = [
            of(&|at| at.x * at.x),
            of(&|at| at.z * at.z),
            of(&|at| at.x * at.z),
        ];
        let (sin, cos) = libm::sincos(0.5 * libm::atan2(2.0 * xz, xx - zz));
        let mut rise = DVec3::ZERO;
        for axis in [DVec3::new(cos, 0.0, sin), DVec3::new(-sin, 0.0, cos)] {
            let spread = of(&|at| at.dot(axis).powi(2));
            if spread > LEAST_SPREAD_M * LEAST_SPREAD_M {
                rise += axis * of(&|at| at.dot(axis) * at.y) / spread;
            }
        }
        let off = of(&|at| (at.y - rise.dot(*at)).powi(2));
        if rise == DVec3::ZERO || off > LARGEST_OFF_M * LARGEST_OFF_M {
            return None;
        }
        let turn = DQuat::from_rotation_arc((DVec3::Y - rise).normalize(), DVec3::Y);
        let ankles_m = (turn * middle).y / places.len() as f64;
        Some(Self {
            turn,
            height_m: ankles_m - ANKLE_HEIGHT * motion.leg_m(),
        })
    }

    /// Turns a motion so that this floor of it is level, at y = 0.
    fn put_level(&self, take: &mut RetargetedMotion) {
        let level = |at: &mut DVec3| *at = self.turn * *at - self.height_m * DVec3::Y;
        take.roots.iter_mut().for_each(level);
        take.positions.iter_mut().flatten().for_each(level);
        for pose in &mut take.rotations {
            let pelvis = &mut pose[Joint::Pelvis.index()];
            *pelvis = (self.turn * *pelvis).normalize();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::people::cohort::Person;
    use edgegait_core::pack::Sex;

    /// Returns four cycles of a walk along +Z on a level floor.
    fn walk() -> RetargetedMotion {
        let person = Person::average(Sex::Male);
        let mut take = RetargetedMotion::of_person(&person, 5.0);
        let again = 2.0 * person.cycle(5.0).drift_m * DVec3::Z;
        let later: Vec<DVec3> = take.roots.iter().map(|root| *root + again).collect();
        take.roots.extend(later);
        take.rotations = take.rotations.repeat(2);
        take.positions = take.positions.repeat(2);
        take
    }

    /// Returns a walk after levelling in a world that is turned, and by how far the heights of its
    /// ankles above the floor differ from what they were, metres.
    fn levelled(turn: DQuat) -> (RetargetedMotion, f64) {
        let level = walk();
        let mut take = level.clone();
        for (root, pose) in take.roots.iter_mut().zip(&mut take.rotations) {
            *root = turn * *root;
            pose[Joint::Pelvis.index()] = turn * pose[Joint::Pelvis.index()];
        }
        level_floor(&mut take);
        let feet = [Joint::LeftFoot, Joint::RightFoot];
        let (low, high) = extent((0..take.len()).flat_map(|frame| {
            let [was, is] = [&level, &take].map(|take| take.posed(frame).0);
            feet.map(|foot| is[foot.index()].y - was[foot.index()].y)
        }));
        (take, high - low)
    }

    #[test]
    fn a_floor_tilted_by_any_known_angle_is_level_again() {
        // 2 degrees along the way are 206 mm of 5.9 m.
        for (heading, deg, noted) in [
            (0.0, 2.0, true),
            (2.1, -2.0, true),
            (0.7, 0.1, false),
            (0.0, 0.0, false),
        ] {
            let tilt = DQuat::from_rotation_x(f64::to_radians(deg));
            let (take, off_m) = levelled(DQuat::from_rotation_y(heading) * tilt);
            // Where synthetic ankles stand, they differ by a few mm: that is levelled as well.
            assert!(off_m < 0.008, "{heading} {deg}: {off_m}");
            assert_eq!(
                take.warnings.len(),
                usize::from(noted),
                "{:?}",
                take.warnings
            );
        }
        let (take, _) = levelled(DQuat::from_rotation_x(2_f64.to_radians()));
        assert!(
            take.warnings[0].contains("tilted by 2.0 degrees"),
            "{:?}",
            take.warnings
        );
    }

    #[test]
    fn ramps_and_stairs_stay() {
        let (ramp, _) = levelled(DQuat::from_rotation_x(4_f64.to_radians()));
        let up = ramp.roots[ramp.len() - 1] - ramp.roots[0];
        assert!(
            (libm::atan2(up.y, up.z).to_degrees() + 4.0).abs() < 0.1,
            "{up}"
        );
        let mut stairs = walk();
        let half = stairs.len() / 2;
        for root in &mut stairs.roots[half..] {
            root.y += 0.12;
        }
        let before = stairs.roots.clone();
        level_floor(&mut stairs);
        let moved = stairs.roots.iter().zip(&before);
        let moved_m = moved.map(|(is, was)| is.distance(*was)).fold(0.0, f64::max);
        // The feet before the step are levelled as they are: within a few mm.
        assert!(moved_m < 0.01, "{moved_m}");
    }
}
