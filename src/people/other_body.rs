//! Transfers a motion to another body: feet keep their places relative to the hips, everything else
//! its world orientation.

use edgegait_core::skeleton::{JOINTS, Joint};
use glam::{DQuat, DVec3};

use crate::people::cleaning::flips::MotionEnds;
use crate::people::forward_kinematics;
use crate::people::leg::LegLengths;
use crate::people::retarget::leg_length_m;
use crate::people::{Cycle, UncutMotion};

/// Hip, knee and ankle of each side.
const LEGS: [[Joint; 3]; 2] = [
    [Joint::LeftThigh, Joint::LeftShank, Joint::LeftFoot],
    [Joint::RightThigh, Joint::RightShank, Joint::RightFoot],
];

/// Flexion near straight over which a knee bends gradually instead of reaching exactly, radians.
/// Our choice: 5 degrees.
const SOFT: f64 = 0.09;

/// Half-width in frames of the window over which the extra bend of knees is smoothed, so that no
/// knee snaps. Our choice: a seventh of a swing of 64 frames a cycle.
const SMOOTH: isize = 3;

/// The largest amount by which the hips are lowered or raised to keep the knees' bend, as a share
/// of the leg's length. Our choice.
const LOWER_BY: f64 = 0.1;

/// The frame in which a leg of the other body misses its foot's place the most.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct TooShort {
    /// The frame.
    pub frame: usize,
    /// Distance of the ankle from its place in that frame, mm.
    pub mm: f64,
}

impl Cycle {
    /// Transfers this cycle from a walker with `own` joint offsets to a body with `target` offsets.
    ///
    /// The middle of the hips, both ankles and the travel scale with the hip-to-ankle length. Steps
    /// keep their proportions, and standing feet slide no more than before. `lifts` raises each
    /// ankle, metres, left first, and the hips by their mean. Thighs and shanks are solved in
    /// closed form: the knee takes up the distance, smoothed over time near straight, and then the
    /// leg turns as little as possible. The hips are lowered or raised so that the knees keep their
    /// mean bend. Feet, trunk and arms keep their world orientation. An ankle out of the leg's
    /// reach is put as near as possible in its direction.
    #[must_use]
    pub fn onto(&self, own: &[DVec3; JOINTS], target: &[DVec3; JOINTS], lifts: [f64; 2]) -> Self {
        let moved = self.moved(own, target, lifts);
        Self {
            drift_m: self.drift_m * moved.ratio,
            root: moved.roots,
            rotations: moved.rotations,
            ..*self
        }
    }

    /// Returns the motion on the other body.
    pub(in crate::people) fn moved(
        &self,
        own: &[DVec3; JOINTS],
        target: &[DVec3; JOINTS],
        lifts: [f64; 2],
    ) -> Moved {
        Moved::transfer(
            &self.root,
            &self.rotations,
            own,
            target,
            lifts,
            MotionEnds::Meet,
        )
    }
}

impl UncutMotion {
    /// Transfers this motion from a walker with `own` joint offsets to a body with `target`
    /// offsets, as [`Cycle::onto`] does.
    #[must_use]
    pub fn onto(&self, own: &[DVec3; JOINTS], target: &[DVec3; JOINTS], lifts: [f64; 2]) -> Self {
        let moved = self.moved(own, target, lifts);
        Self {
            roots: moved.roots,
            rotations: moved.rotations,
            ..*self
        }
    }

    /// Returns the motion on the other body.
    pub(in crate::people) fn moved(
        &self,
        own: &[DVec3; JOINTS],
        target: &[DVec3; JOINTS],
        lifts: [f64; 2],
    ) -> Moved {
        Moved::transfer(
            &self.roots,
            &self.rotations,
            own,
            target,
            lifts,
            MotionEnds::Open,
        )
    }
}

/// A motion that was transferred to the other body.
pub(in crate::people) struct Moved {
    roots: Vec<DVec3>,
    rotations: Vec<[DQuat; JOINTS]>,
    /// The other body's hip-to-ankle length over the walker's own.
    ratio: f64,
    /// The frame in which the legs miss their place most.
    pub too_short: TooShort,
}

impl Moved {
    fn transfer(
        roots: &[DVec3],
        rotations: &[[DQuat; JOINTS]],
        own: &[DVec3; JOINTS],
        target: &[DVec3; JOINTS],
        lifts: [f64; 2],
        ends: MotionEnds,
    ) -> Self {
        let [own_leg_m, target_leg_m] = [own, target].map(leg_length_m);
        let ratio = if own_leg_m > 0.0 {
            target_leg_m / own_leg_m
        } else {
            1.0
        };
        let mut other = Other {
            own,
            target,
            ratio,
            lifts,
            lower_m: 0.0,
        };
        other.lower(roots, rotations);
        let poses = || roots.iter().zip(rotations);
        let asked: Vec<[f64; 2]> = poses()
            .map(|(root, pose)| other.posed(*root, pose, None).bends)
            .collect();
        let mut moved = Self {
            roots: Vec::with_capacity(roots.len()),
            rotations: Vec::with_capacity(roots.len()),
            ratio,
            too_short: TooShort::default(),
        };
        for (frame, (root, pose)) in poses().enumerate() {
            let posed = other.posed(*root, pose, Some(smoothed(&asked, frame, ends)));
            moved.roots.push(posed.root);
            moved.rotations.push(posed.pose);
            let mm = 1e3 * posed.short_m;
            if mm > moved.too_short.mm {
                moved.too_short = TooShort { frame, mm };
            }
        }
        moved
    }
}

/// Returns the extra bend of both knees around a frame, smoothed with raised-cosine weights.
fn smoothed(asked: &[[f64; 2]], frame: usize, ends: MotionEnds) -> [f64; 2] {
    let last = asked.len() - 1;
    let near = -SMOOTH..=SMOOTH;
    let (mut sum, mut weights) = ([0.0; 2], 0.0);
    for by in near {
        let at = frame as isize + by;
        let at = match ends {
            MotionEnds::Meet => at.rem_euclid(asked.len() as isize),
            MotionEnds::Open => at.clamp(0, last as isize),
        };
        let weight = 1.0 + libm::cos(std::f64::consts::PI * by as f64 / (SMOOTH + 1) as f64);
        for (sum, asked) in sum.iter_mut().zip(asked[at as usize]) {
            *sum += weight * asked;
        }
        weights += weight;
    }
    sum.map(|sum| sum / weights)
}

/// The other body and the walker's own, with the parameters of the transfer.
#[derive(Clone, Copy)]
struct Other<'a> {
    own: &'a [DVec3; JOINTS],
    target: &'a [DVec3; JOINTS],
    /// The other body's hip-to-ankle length over the walker's own.
    ratio: f64,
    /// Height of each ankle above its scaled place, metres.
    lifts: [f64; 2],
    /// Depth of the hips below their scaled place, metres.
    lower_m: f64,
}

/// A pose on the other body.
struct TransferredPose {
    root: DVec3,
    pose: [DQuat; JOINTS],
    /// Distance of the farther ankle from its place, metres.
    short_m: f64,
    /// Extra bend of each knee over the walker's own, radians.
    bends: [f64; 2],
}

impl Other<'_> {
    /// Lowers or raises the hips until the knees have the same mean bend as before.
    fn lower(&mut self, roots: &[DVec3], rotations: &[[DQuat; JOINTS]]) {
        let more = |other: &Self| -> f64 {
            let poses = roots.iter().zip(rotations);
            let posed = poses.map(|(root, pose)| other.posed(*root, pose, None));
            // A leg that does not reach calls for lower hips.
            posed
                .map(|posed| posed.bends[0] + posed.bends[1] - posed.short_m)
                .sum()
        };
        if more(self).abs() < 1e-6 * roots.len() as f64 {
            return;
        }
        let most = LOWER_BY * leg_length_m(self.target);
        let (mut low, mut high) = (-most, most);
        while high - low > 1e-6 {
            self.lower_m = 0.5 * (low + high);
            if more(self) < 0.0 {
                low = self.lower_m;
            } else {
                high = self.lower_m;
            }
        }
    }

    /// Returns a pose on these legs. The extra bend of the knees is `bends`, or what the ankles
    /// need.
    fn posed(
        &self,
        root: DVec3,
        pose: &[DQuat; JOINTS],
        bends: Option<[f64; 2]>,
    ) -> TransferredPose {
        let (at, turns) = forward_kinematics(self.own, root, pose);
        let pelvis = turns[Joint::Pelvis.index()];
        let hips = LEGS.map(|[thigh, ..]| pelvis * self.target[thigh.index()]);
        let [left, right] = LEGS.map(|[thigh, ..]| at[thigh.index()]);
        let higher = 0.5 * (self.lifts[0] + self.lifts[1]) - self.lower_m;
        let middle = self.ratio * left.midpoint(right) + higher * DVec3::Y;
        let mut posed = TransferredPose {
            root: middle - hips[0].midpoint(hips[1]),
            pose: *pose,
            short_m: 0.0,
            bends: [0.0; 2],
        };
        for (side, [thigh, shank, foot]) in LEGS.into_iter().enumerate() {
            let ankle = self.ratio * at[foot.index()] + self.lifts[side] * DVec3::Y;
            let wanted = ankle - (posed.root + hips[side]);
            let bones = [
                turns[thigh.index()] * self.target[shank.index()],
                turns[shank.index()] * self.target[foot.index()],
            ];
            let Some(mut bend) = KneeBend::reaching(bones, turns[thigh.index()] * DVec3::X, wanted)
            else {
                continue;
            };
            if let Some(bends) = bends {
                bend.more = bends[side];
            }
            let knee = DQuat::from_axis_angle(bend.axis, bend.more);
            let reached = bones[0] + knee * bones[1];
            let whole = DQuat::from_rotation_arc(
                reached.normalize_or(-DVec3::Y),
                wanted.normalize_or(-DVec3::Y),
            );
            let turned_thigh = (whole * turns[thigh.index()]).normalize();
            let turned_shank = (whole * knee * turns[shank.index()]).normalize();
            let pose = &mut posed.pose;
            pose[thigh.index()] = (pelvis.inverse() * turned_thigh).normalize();
            pose[shank.index()] = (turned_thigh.inverse() * turned_shank).normalize();
            pose[foot.index()] = (turned_shank.inverse() * turns[foot.index()]).normalize();
            posed.short_m = posed.short_m.max((whole * reached).distance(wanted));
            posed.bends[side] = bend.more;
        }
        posed
    }
}

/// The extra bend of a knee.
struct KneeBend {
    /// Axis of the bend, a unit vector.
    axis: DVec3,
    /// Angle of the bend, radians.
    more: f64,
}

impl KneeBend {
    /// Returns the bend that puts the ankle at the distance of `wanted` from the hip; `None` for a
    /// leg without length.
    ///
    /// Near straight, a knee that reached exactly would snap. There it bends by up to [`SOFT`] less
    /// or more, and the ankle misses its place by up to 2 mm. The walker's own legs are unchanged.
    fn reaching([thigh, shank]: [DVec3; 2], axis: DVec3, wanted: DVec3) -> Option<Self> {
        let axis = axis.reject_from(thigh.try_normalize()?).try_normalize()?;
        // The part of the shank that the knee turns.
        let beside = shank.dot(axis);
        let turning = shank - beside * axis;
        let leg = LegLengths {
            thigh_m: thigh.length(),
            shank_m: turning.length(),
        };
        if leg.shank_m < 1e-6 {
            return None;
        }
        let bent = libm::atan2(thigh.cross(turning).dot(axis), thigh.dot(turning));
        let distance = libm::sqrt((wanted.length_squared() - beside * beside).max(0.0));
        let soft = |knee: f64| libm::sqrt(knee * knee + SOFT * SOFT);
        let more = soft(leg.knee(distance)) - soft(bent);
        Some(Self { axis, more })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::people::cohort::Person;
    use edgegait_core::pack::Sex;

    /// Hips and legs of 0.5 + 0.42 m, scaled; nothing else.
    fn legs(scale: f64) -> [DVec3; JOINTS] {
        let mut offsets = [DVec3::ZERO; JOINTS];
        for (thigh, shank, foot, x) in [
            (Joint::LeftThigh, Joint::LeftShank, Joint::LeftFoot, 0.1),
            (Joint::RightThigh, Joint::RightShank, Joint::RightFoot, -0.1),
        ] {
            offsets[thigh.index()] = DVec3::X * x * scale;
            offsets[shank.index()] = -DVec3::Y * 0.5 * scale;
            offsets[foot.index()] = -DVec3::Y * 0.42 * scale;
        }
        offsets
    }

    fn cycle() -> Cycle {
        let mut bent = [DQuat::IDENTITY; JOINTS];
        bent[Joint::RightThigh.index()] = DQuat::from_rotation_x(-0.5);
        bent[Joint::RightShank.index()] = DQuat::from_rotation_x(1.0);
        Cycle {
            period_s: 1.0,
            drift_m: 1.2,
            closure_mm: 0.0,
            root: vec![DVec3::new(0.0, 1.0, 0.0), DVec3::new(0.01, 1.02, 0.02)],
            rotations: vec![[DQuat::IDENTITY; JOINTS], bent],
        }
    }

    #[test]
    fn a_cycle_on_its_own_body_is_unchanged() {
        let moved = cycle().onto(&legs(1.0), &legs(1.0), [0.0; 2]);
        for (a, b) in moved.root.iter().zip(&cycle().root) {
            assert!(a.distance(*b) < 1e-12, "{a} {b}");
        }
    }

    #[test]
    fn a_body_of_half_the_size_takes_half_the_steps() {
        let moved = cycle().onto(&legs(1.0), &legs(0.5), [0.0; 2]);
        assert!((moved.drift_m - 0.6).abs() < 1e-12);
        assert!(moved.root[1].distance(DVec3::new(0.005, 0.51, 0.01)) < 1e-12);
    }

    #[test]
    fn an_uncut_motion_moves_as_a_cycle_does() {
        let span = UncutMotion {
            sample_rate_hz: 100.0,
            roots: cycle().root,
            rotations: cycle().rotations,
        };
        let moved = span.onto(&legs(1.0), &legs(0.5), [0.0; 2]);
        assert!(moved.roots[1].distance(DVec3::new(0.005, 0.51, 0.01)) < 1e-12);
        assert_eq!(moved.sample_rate_hz, 100.0);
    }

    /// Returns a body's offsets with other proportions of thighs, shanks and hips.
    fn others(body: &crate::people::Body) -> [DVec3; JOINTS] {
        let mut offsets = body.offsets;
        for [thigh, shank, foot] in LEGS {
            offsets[thigh.index()].x *= 1.2;
            offsets[shank.index()] *= 0.9;
            offsets[foot.index()] *= 1.2;
        }
        offsets
    }

    #[test]
    fn ankles_are_where_they_were_against_the_hips_whatever_the_shares_of_the_legs() {
        let person = Person::average(Sex::Male);
        let (own, target) = (&person.body.offsets, &others(&person.body));
        let ratio = leg_length_m(target) / leg_length_m(own);
        for speed_kmh in [3.0, 6.0, 10.0] {
            let cycle = person.cycle(speed_kmh);
            let moved = cycle.onto(own, target, [0.0; 2]);
            assert!((moved.drift_m - ratio * cycle.drift_m).abs() < 1e-12);
            for frame in 0..cycle.root.len() {
                let (was, had) =
                    forward_kinematics(own, cycle.root[frame], &cycle.rotations[frame]);
                let (is, has) =
                    forward_kinematics(target, moved.root[frame], &moved.rotations[frame]);
                for [_, _, foot] in LEGS {
                    let (was, is) = (ratio * was[foot.index()], is[foot.index()]);
                    assert!(was.distance(is) < 2e-3, "{speed_kmh} {frame}: {was} {is}");
                }
                for joint in Joint::ALL {
                    let is_leg = LEGS.iter().any(|leg| leg[..2].contains(&joint));
                    let turned = had[joint.index()].angle_between(has[joint.index()]);
                    assert!(
                        turned < if is_leg { 0.3 } else { 1e-6 },
                        "{joint:?} {turned}"
                    );
                }
            }
        }
    }

    #[test]
    fn feet_are_lifted_each_by_its_own_and_the_hips_by_the_mean() {
        let person = Person::average(Sex::Male);
        let body = &person.body.offsets;
        // A runner in a crouch, whose legs are never straight.
        let mut cycle = person.cycle(10.0);
        for pose in &mut cycle.rotations {
            for (joint, turn) in LEGS
                .into_iter()
                .flat_map(|leg| leg.into_iter().zip([-0.2, 0.4, -0.2]))
            {
                pose[joint.index()] *= DQuat::from_rotation_x(turn);
            }
        }
        let lifts = [0.02, -0.01];
        let moved = cycle.onto(body, body, lifts);
        let mut lowered: Vec<f64> = Vec::new();
        let mut bent = 0;
        for frame in 0..cycle.root.len() {
            let (was, _) = forward_kinematics(body, cycle.root[frame], &cycle.rotations[frame]);
            let (is, _) = forward_kinematics(body, moved.root[frame], &moved.rotations[frame]);
            let raised = moved.root[frame].y - cycle.root[frame].y;
            for ([thigh, shank, foot], lift) in LEGS.into_iter().zip(lifts) {
                let [hip, knee, ankle] = [thigh, shank, foot].map(|joint| is[joint.index()]);
                let off = (was[foot.index()] + lift * DVec3::Y).distance(ankle);
                // A straight leg does not reach down, and one near straight bends gradually.
                if (knee - hip).angle_between(ankle - knee) > 0.3 {
                    assert!(off < 2e-3, "{frame} {foot:?}: {off}");
                    bent += 1;
                }
                // At worst it goes all the way with the hips.
                let with_hips = (raised - lift).abs();
                assert!(
                    off < with_hips + 1e-4,
                    "{frame} {foot:?}: {off} {with_hips}"
                );
            }
            lowered.push(raised);
        }
        assert!(bent > cycle.root.len(), "{bent}");
        // By the mean, except for the correction that keeps the knees' mean bend.
        assert!(lowered.iter().all(|by| (by - lowered[0]).abs() < 1e-9));
        assert!((lowered[0] - 0.005).abs() < 1e-3, "{}", lowered[0]);
    }

    #[test]
    fn a_knee_that_passes_through_straight_does_not_jump() {
        let own = legs(1.0);
        let mut target = own;
        target[Joint::LeftThigh.index()].x = 0.06;
        target[Joint::LeftShank.index()].y = -0.45;
        target[Joint::LeftFoot.index()].y = -0.47;
        let at = |degrees: f64| {
            let mut pose = [DQuat::IDENTITY; JOINTS];
            pose[Joint::LeftShank.index()] = DQuat::from_rotation_x(degrees.to_radians());
            let other = Other {
                own: &own,
                target: &target,
                ratio: 1.0,
                lifts: [0.0; 2],
                lower_m: 0.0,
            };
            let posed = other.posed(DVec3::Y, &pose, None);
            let (reached, _) = forward_kinematics(&target, posed.root, &posed.pose);
            assert!(posed.short_m < 2e-3, "{}", posed.short_m);
            reached[Joint::LeftShank.index()]
        };
        for tenth in -80..300 {
            let [before, after] = [tenth, tenth + 1].map(|tenth| at(0.1 * f64::from(tenth)));
            assert!(before.distance(after) < 2e-3, "{tenth}: {before} {after}");
        }
    }

    #[test]
    fn an_ankle_that_is_out_of_reach_is_as_near_as_it_gets_and_is_reported() {
        // Straight legs on ankles that stay 0.2 m apart, below hips of other widths.
        let straight = Cycle {
            rotations: vec![[DQuat::IDENTITY; JOINTS]; 2],
            ..cycle()
        };
        let on_hips = |half_m: f64| {
            let mut target = legs(1.0);
            target[Joint::LeftThigh.index()].x = half_m;
            target[Joint::RightThigh.index()].x = -half_m;
            let Cycle {
                root, rotations, ..
            } = &straight;
            Moved::transfer(
                root,
                rotations,
                &legs(1.0),
                &target,
                [0.0; 2],
                MotionEnds::Meet,
            )
        };
        assert!(on_hips(0.1).too_short.mm < 1e-6);
        // The hips come down: by 2.2 cm, and by a tenth of the leg at most.
        let lower = on_hips(0.3);
        let height = f64::sqrt(0.92 * 0.92 - 0.2 * 0.2) - 0.92;
        assert!(
            (lower.roots[0].y - (1.0 + height)).abs() < 1e-3,
            "{}",
            lower.roots[0].y
        );
        assert!(lower.too_short.mm < 1.0, "{:?}", lower.too_short);
        let far = on_hips(0.7).too_short.mm;
        let missing = f64::hypot(0.9 * 0.92, 0.6) - 0.92;
        assert!((far - 1e3 * missing).abs() < 0.1, "{far} {missing}");
    }
}
