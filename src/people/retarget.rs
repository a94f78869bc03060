//! A recorded motion on the canonical skeleton: metres, Y up, floor at zero.
//!
//! Whatever the joint names, unit and axes of a file, the result is one root position and 19 local
//! rotations a frame, with the walker's own segment lengths.

pub(crate) mod follow;
pub(crate) mod joint_roles;
pub(crate) mod missing_joints;
pub(crate) mod rest_pose;
pub(crate) mod unit;

use super::cleaning::low_pass::LowPass;
use super::cleaning::usable_part::longest_clean_stretch;
use super::forward_kinematics;
use super::residual::Residual;
use crate::import::Motion;
use edgegait_core::skeleton::{JOINTS, Joint};
use follow::{local_rotations, main_child};
use glam::{DQuat, DVec3};
use joint_roles::JointRoles;
use missing_joints::completed;
use rest_pose::{Globals, RestCalibration, nearest_axis, source_points};
use unit::{UnitFamily, choose_unit, leg_of};

/// Ankle height over hip-to-ankle length: 0.039 / 0.491 (Winter 2009, figure 4.1, after
/// Drillis & Contini 1966).
pub const ANKLE_HEIGHT: f64 = 0.0794;

/// Largest distance at which the feet's floor counts as the file's stated y = 0, metres. It allows
/// for soles thicker or thinner than [`ANKLE_HEIGHT`], or sinking in. Our choice.
const NEAR_FLOOR_M: f64 = 0.1;

/// The default cut-off of the low-pass, Hz.
pub const DEFAULT_CUT_OFF_HZ: f64 = 10.0;

/// A recorded motion on the canonical skeleton.
#[derive(Clone, Debug)]
pub struct RetargetedMotion {
    /// The frame rate, Hz.
    pub sample_rate_hz: f64,
    /// Seconds from the source's frame 0 to the first frame here.
    pub start_s: f64,
    /// Cut-off of the low-pass that was applied, Hz; `None` for an unfiltered motion.
    pub cut_off_hz: Option<f64>,
    /// Metres in one source unit.
    pub unit_m: f64,
    /// The walker's own joint offsets in the canonical rest pose, metres.
    pub offsets: [DVec3; JOINTS],
    /// Whether heading and position belong to a world whose axes the file states; otherwise they
    /// are arbitrary.
    pub is_placed: bool,
    /// Whether markers or the skeleton's standing rest pose define upright; otherwise the trunk of
    /// one frame of the motion does.
    pub knows_upright: bool,
    /// Pelvis position by frame, metres, Y up, with the lowest stance on y = 0 (the file's own
    /// floor if the motion is placed); heading as in the file.
    pub roots: Vec<DVec3>,
    /// Local rotations about the canonical rest pose, by frame.
    pub rotations: Vec<[DQuat; JOINTS]>,
    /// Positions of the source's own joints, metres, in the axes of `roots`.
    pub positions: Vec<[DVec3; JOINTS]>,
    /// Distance of forward kinematics with constant segment lengths from the measured joints, root
    /// mean square over joints and frames, mm.
    pub residual_mm: f64,
    /// Warnings about what was assumed, repaired or dropped.
    pub warnings: Vec<String>,
}

/// Returns the length from hip to knee to ankle, mean of both sides, metres.
#[must_use]
pub fn leg_length_m(offsets: &[DVec3; JOINTS]) -> f64 {
    [
        Joint::LeftShank,
        Joint::LeftFoot,
        Joint::RightShank,
        Joint::RightFoot,
    ]
    .iter()
    .map(|joint| offsets[joint.index()].length())
    .sum::<f64>()
        / 2.0
}

/// Returns whether the joints of a skeleton have known names, so that each has its part.
pub(super) fn has_known_joints(motion: &Motion) -> bool {
    completed(motion).is_ok_and(|complete| JointRoles::find(&complete.joints).is_ok())
}

impl RetargetedMotion {
    /// Retargets a motion. `cut_off_hz` is the cut-off of the low-pass, usually
    /// [`DEFAULT_CUT_OFF_HZ`]; `None` leaves the motion as recorded.
    ///
    /// A T-pose in frame 0 is dropped. The recording is cut where the root moves faster than
    /// 15 m/s or a joint turns faster than 3,600 degrees a second (30 a frame at 120 Hz; never more
    /// than 75 a frame), and its longest clean stretch is used. Warnings report this. A skeleton
    /// without feet, arms, hands or head gets those of an average adult, which turn with their
    /// parent joints.
    ///
    /// # Errors
    /// A sentence without the file's name: leg joints are missing, or no known unit gives human
    /// legs.
    pub fn from_motion(motion: &Motion, cut_off_hz: Option<f64>) -> Result<Self, String> {
        let motion = &*completed(motion)?;
        let mut warnings = motion.warnings.clone();
        let mut roles = JointRoles::find(&motion.joints)?;
        let unit_m = choose_unit(
            leg_of(motion, &roles),
            motion.unit_m,
            UnitFamily::from_motion(motion),
            &mut warnings,
        )?;
        let roots: Vec<DVec3> = (0..motion.frames.len())
            .map(|i| motion.globals(i).0[roles.pelvis])
            .collect();
        let clean = longest_clean_stretch(motion, &roles.turning(), unit_m, &roots);
        warnings.extend(clean.warnings);
        if clean.frames.is_empty() {
            return Err("no frames of the motion are left".into());
        }
        let globals = |motion: &Motion, frame| {
            let (positions, rotations) = motion.globals(frame);
            Globals {
                positions,
                rotations,
            }
        };
        let t_pose = clean.t_pose.then(|| globals(motion, 0));
        let (smooth, filtered_at) = filtered(motion, &clean.frames, cut_off_hz, &mut warnings);
        let frames: Vec<Globals> = (0..smooth.frames.len())
            .map(|frame| globals(&smooth, frame))
            .collect();

        let up = up_axis(&frames, &roles);
        let is_placed = motion.format.states_axes() && up == DVec3::Y;
        if motion.format.states_axes() && !is_placed {
            warnings.push(format!(
                "up is {up}, not Y as in {} files: heading and position are not kept",
                motion.format
            ));
        }
        let rest = RestCalibration::calibrate(motion, &mut roles, &frames, t_pose.as_ref(), up)?;
        warnings.extend(rest.warnings.iter().cloned());
        let world = DQuat::from_rotation_arc(up, DVec3::Y);
        let mut positions: Vec<[DVec3; JOINTS]> = frames
            .iter()
            .map(|frame| source_points(&rest, frame).map(|point| world * point * unit_m))
            .collect();
        let offsets = rest.offsets.map(|offset| offset * unit_m);
        for joint in Joint::ALL {
            let is_limb =
                joint.mirrored() != joint && joint.parent().and_then(main_child) == Some(joint);
            if is_limb && offsets[joint.index()].length() < 0.01 {
                warnings.push(format!(
                    "{joint:?} lies on its parent joint: a segment has no length"
                ));
            }
        }
        let mut floor_m = floor(&positions, leg_length_m(&offsets));
        if is_placed && floor_m.abs() <= NEAR_FLOOR_M {
            floor_m = 0.0;
        } else if is_placed {
            warnings.push(format!(
                "the feet stand on y = {floor_m:.2} m, not 0: moved to the floor"
            ));
        }
        for point in positions.iter_mut().flatten() {
            point.y -= floor_m;
        }
        let rotations: Vec<[DQuat; JOINTS]> = frames
            .iter()
            .zip(&positions)
            .map(|(frame, points)| local_rotations(&rest, world, frame, points, &offsets))
            .collect();
        let mut residual = Residual::default();
        for (pose, points) in rotations.iter().zip(&positions) {
            let (reached, _) = forward_kinematics(&offsets, points[Joint::Pelvis.index()], pose);
            residual.add_all(&reached, points);
        }
        Ok(Self {
            sample_rate_hz: motion.sample_rate_hz,
            start_s: clean.frames.start as f64 / motion.sample_rate_hz,
            cut_off_hz: filtered_at,
            unit_m,
            offsets,
            is_placed,
            knows_upright: rest.stands,
            roots: positions
                .iter()
                .map(|points| points[Joint::Pelvis.index()])
                .collect(),
            rotations,
            positions,
            residual_mm: residual.rms_mm(),
            warnings,
        })
    }

    /// Returns the number of frames.
    #[must_use]
    pub fn len(&self) -> usize {
        self.roots.len()
    }

    /// Returns whether there are no frames; false for every motion that was built.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.roots.is_empty()
    }

    /// Returns the world orientation of a joint in a frame.
    ///
    /// # Panics
    /// If there is no such frame.
    pub(super) fn turn_of(&self, frame: usize, joint: Joint) -> DQuat {
        self.posed(frame).1[joint.index()]
    }

    /// Returns the positions and world orientations of the joints in a frame.
    ///
    /// # Panics
    /// If there is no such frame.
    pub(super) fn posed(&self, frame: usize) -> ([DVec3; JOINTS], [DQuat; JOINTS]) {
        forward_kinematics(&self.offsets, self.roots[frame], &self.rotations[frame])
    }

    /// Returns the canonical joint positions of a frame by forward kinematics, metres.
    ///
    /// # Panics
    /// If there is no such frame.
    #[must_use]
    pub fn joint_positions(&self, frame: usize) -> [DVec3; JOINTS] {
        self.posed(frame).0
    }
}

/// Returns the frames of a stretch, low-passed, and the cut-off if they were filtered.
fn filtered(
    motion: &Motion,
    range: &std::ops::Range<usize>,
    cut_off_hz: Option<f64>,
    warnings: &mut Vec<String>,
) -> (Motion, Option<f64>) {
    let mut smooth = Motion {
        frames: motion.frames[range.clone()].to_vec(),
        joints: motion.joints.clone(),
        warnings: Vec::new(),
        skin: None,
        ..*motion
    };
    let Some(cut_off_hz) = cut_off_hz else {
        return (smooth, None);
    };
    let Some(filter) = LowPass::new(cut_off_hz, motion.sample_rate_hz) else {
        warnings.push(format!(
            "the frame rate is too low for a {cut_off_hz} Hz low-pass: not filtered"
        ));
        return (smooth, None);
    };
    let mut roots: Vec<DVec3> = smooth.frames.iter().map(|frame| frame.root).collect();
    filter.positions(&mut roots);
    for (frame, root) in smooth.frames.iter_mut().zip(roots) {
        frame.root = root;
    }
    for joint in 0..smooth.joints.len() {
        let mut track: Vec<DQuat> = smooth.frames.iter().map(|f| f.rotations[joint]).collect();
        filter.rotations(&mut track);
        for (frame, rotation) in smooth.frames.iter_mut().zip(track) {
            frame.rotations[joint] = rotation;
        }
    }
    (smooth, Some(cut_off_hz))
}

/// Returns the signed axis nearest to the median direction from ankles to hips over the motion.
pub(super) fn up_axis(frames: &[Globals], roles: &JointRoles) -> DVec3 {
    let mut along: [Vec<f64>; 3] = Default::default();
    for Globals { positions: p, .. } in frames {
        let hips = p[roles.thigh[0]].midpoint(p[roles.thigh[1]]);
        let ankles = p[roles.foot[0]].midpoint(p[roles.foot[1]]);
        for (axis, values) in along.iter_mut().enumerate() {
            values.push((hips - ankles)[axis]);
        }
    }
    let medians = along.map(|mut values| {
        values.sort_by(f64::total_cmp);
        values.get(values.len() / 2).copied().unwrap_or_default()
    });
    nearest_axis(DVec3::from_array(medians))
}

/// Returns the height of the floor: the 5 % quantile of the lower ankle's height, less the ankle's
/// height above its sole. One frame in twenty may be a glitch.
pub(super) fn floor(positions: &[[DVec3; JOINTS]], leg_m: f64) -> f64 {
    let mut heights: Vec<f64> = positions
        .iter()
        .map(|p| {
            p[Joint::LeftFoot.index()]
                .y
                .min(p[Joint::RightFoot.index()].y)
        })
        .collect();
    heights.sort_by(f64::total_cmp);
    heights.get(heights.len() / 20).copied().unwrap_or_default() - ANKLE_HEIGHT * leg_m
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::import::{MotionFormat, SourceFrame, SourceJoint};

    /// Returns a figure with a T-pose at rest and legs of 0.9 m that swing, in centimetres, Y up,
    /// facing +Z.
    fn figure() -> Motion {
        let spec: [(&str, usize, [f64; 3]); 18] = [
            ("Hips", 0, [0.0, 0.0, 0.0]),
            ("LeftUpLeg", 0, [10.0, 0.0, 0.0]),
            ("LeftLeg", 1, [0.0, -45.0, 0.0]),
            ("LeftFoot", 2, [0.0, -45.0, 0.0]),
            ("LeftToe", 3, [0.0, -5.0, 15.0]),
            ("RightUpLeg", 0, [-10.0, 0.0, 0.0]),
            ("RightLeg", 5, [0.0, -45.0, 0.0]),
            ("RightFoot", 6, [0.0, -45.0, 0.0]),
            ("RightToe", 7, [0.0, -5.0, 15.0]),
            ("Chest", 0, [0.0, 22.0, 0.0]),
            ("Neck", 9, [0.0, 28.0, 0.0]),
            ("Head", 10, [0.0, 10.0, 0.0]),
            ("LeftArm", 9, [18.0, 26.0, 0.0]),
            ("LeftForeArm", 12, [28.0, 0.0, 0.0]),
            ("LeftHand", 13, [25.0, 0.0, 0.0]),
            ("RightArm", 9, [-18.0, 26.0, 0.0]),
            ("RightForeArm", 15, [-28.0, 0.0, 0.0]),
            ("RightHand", 16, [-25.0, 0.0, 0.0]),
        ];
        let joints: Vec<SourceJoint> = spec
            .iter()
            .enumerate()
            .map(|(i, (name, parent, offset))| SourceJoint {
                name: (*name).into(),
                parent: (i > 0).then_some(*parent),
                offset: DVec3::from_array(*offset),
                end: None,
            })
            .collect();
        let frames = (0..40)
            .map(|i| {
                let swing = 0.5 * libm::sin(f64::from(i) * 0.1);
                let mut rotations = vec![DQuat::IDENTITY; joints.len()];
                rotations[1] = DQuat::from_rotation_x(-swing);
                rotations[2] = DQuat::from_rotation_x(swing.abs());
                rotations[5] = DQuat::from_rotation_x(swing);
                rotations[9] = DQuat::from_rotation_y(0.1 * swing);
                // Arms hang down from the T, then swing about the lateral axis.
                rotations[12] = DQuat::from_rotation_x(swing) * DQuat::from_rotation_z(-1.5);
                rotations[15] = DQuat::from_rotation_x(-swing) * DQuat::from_rotation_z(1.5);
                SourceFrame {
                    root: DVec3::new(0.0, 95.0, f64::from(i)),
                    rotations,
                    offsets: None,
                }
            })
            .collect();
        Motion {
            format: MotionFormat::Bvh,
            joints,
            sample_rate_hz: 100.0,
            frames,
            unit_m: None,
            skin: None,
            warnings: Vec::new(),
        }
    }

    /// Returns the motion in a world turned by `turn`, in another unit.
    fn turned(mut motion: Motion, turn: DQuat, scale: f64) -> Motion {
        for joint in &mut motion.joints {
            joint.offset = turn * joint.offset * scale;
        }
        for frame in &mut motion.frames {
            frame.root = turn * frame.root * scale;
            for rotation in &mut frame.rotations {
                *rotation = turn * *rotation * turn.inverse();
            }
        }
        motion
    }

    fn assert_same(a: &RetargetedMotion, b: &RetargetedMotion) {
        for (x, y) in a.offsets.iter().zip(&b.offsets) {
            assert!(x.distance(*y) < 1e-9, "{x} {y}");
        }
        for (x, y) in a.rotations.iter().zip(&b.rotations) {
            for joint in 1..JOINTS {
                assert!(x[joint].dot(y[joint]).abs() > 1.0 - 1e-9, "{joint}");
            }
        }
    }

    #[test]
    fn segments_hang_in_the_canonical_rest_pose_with_their_own_lengths() {
        let take = RetargetedMotion::from_motion(&figure(), None).unwrap();
        assert!(take.warnings.is_empty(), "{:?}", take.warnings);
        assert_eq!(take.unit_m, 0.01);
        let offset = |joint: Joint| take.offsets[joint.index()];
        assert!(offset(Joint::LeftThigh).distance(DVec3::new(0.10, 0.0, 0.0)) < 1e-12);
        assert!(offset(Joint::RightShank).distance(DVec3::new(0.0, -0.45, 0.0)) < 1e-12);
        assert!(offset(Joint::LeftForearm).distance(DVec3::new(0.0, -0.28, 0.0)) < 1e-12);
        assert!(offset(Joint::RightHand).distance(DVec3::new(0.0, -0.25, 0.0)) < 1e-12);
    }

    #[test]
    fn canonical_kinematics_puts_every_joint_where_the_source_has_it() {
        let take = RetargetedMotion::from_motion(&figure(), None).unwrap();
        for frame in 0..take.len() {
            let reached = take.joint_positions(frame);
            for joint in Joint::ALL {
                let (a, b) = (reached[joint.index()], take.positions[frame][joint.index()]);
                assert!(a.distance(b) < 1e-9, "{joint:?} {a} {b}");
            }
        }
    }

    #[test]
    fn thighs_turn_as_the_source_and_hanging_arms_are_near_rest() {
        let take = RetargetedMotion::from_motion(&figure(), None).unwrap();
        let thigh = take.rotations[10][Joint::LeftThigh.index()].to_scaled_axis();
        assert!(
            thigh.distance(DVec3::X * -0.5 * libm::sin(1.0)) < 1e-9,
            "{thigh}"
        );
        // 90 degrees down from the T is canonical: 1.5 rad leaves 0.07 of abduction.
        let arm = take.rotations[0][Joint::LeftUpperArm.index()].to_scaled_axis();
        assert!(
            (arm.z - (std::f64::consts::FRAC_PI_2 - 1.5)).abs() < 1e-9,
            "{arm}"
        );
    }

    #[test]
    fn any_up_axis_heading_and_unit_give_the_same_take() {
        let plain = RetargetedMotion::from_motion(&figure(), None).unwrap();
        let z_up = DQuat::from_rotation_x(std::f64::consts::FRAC_PI_2);
        for (turn, scale) in [
            (z_up, 1.0),
            (DQuat::from_rotation_y(1.0), 0.01),
            (z_up * DQuat::from_rotation_y(2.0), 10.0),
            (DQuat::from_rotation_z(std::f64::consts::PI), 1.0 / 2.54),
        ] {
            assert_same(
                &plain,
                &RetargetedMotion::from_motion(&turned(figure(), turn, scale), None).unwrap(),
            );
        }
    }

    #[test]
    fn legs_with_exchanged_names_are_exchanged_back() {
        let mut motion = figure();
        for joint in &mut motion.joints[1..9] {
            joint.name = match joint.name.strip_prefix("Left") {
                Some(rest) => format!("Right{rest}"),
                None => joint.name.replace("Right", "Left"),
            };
        }
        let take = RetargetedMotion::from_motion(&motion, None).unwrap();
        assert!(
            take.warnings[0].contains("legs were named the wrong way"),
            "{:?}",
            take.warnings
        );
        assert_same(
            &take,
            &RetargetedMotion::from_motion(&figure(), None).unwrap(),
        );
    }

    #[test]
    fn a_t_pose_before_the_motion_and_a_jump_in_it_are_cut_away() {
        let mut motion = figure();
        let mut still = motion.frames[0].clone();
        still.rotations = vec![DQuat::IDENTITY; motion.joints.len()];
        motion.frames.insert(0, still);
        motion.frames[31].root.x += 300.0;
        let take = RetargetedMotion::from_motion(&motion, None).unwrap();
        assert_eq!(take.warnings[0], "frame 0 is a T-pose and was dropped");
        assert_eq!(
            take.warnings[1],
            "the root jumps 3.00 m at frame 31: only frames 1 to 30 of 41 are used"
        );
        assert_eq!((take.len(), take.start_s), (30, 0.01));
    }
}
