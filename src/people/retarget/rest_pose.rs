//! The relation between a source skeleton's rest pose and the canonical one.
//!
//! Each source joint's frame is world-parallel at rest. One constant rotation per joint, from the
//! canonical rest pose to the source's, therefore carries its motion over with the twist. If a
//! file's rest pose is not a standing body (Character Creator's BVH has legs and trunk folded into
//! one line), the frame that stands best serves as rest.

use crate::import::Motion;
use crate::people::retarget::joint_roles::JointRoles;
use crate::people::retarget::unit::{UnitFamily, choose_unit, leg_of};
use edgegait_core::skeleton::{JOINTS, Joint};
use glam::{DMat3, DQuat, DVec3};

/// Largest rotation over a whole motion that counts as still, radians.
const STILL_RAD: f64 = 0.005;

/// A pose of the source: world positions and orientations of all joints.
pub(in crate::people) struct Globals {
    pub(in crate::people) positions: Vec<DVec3>,
    pub(in crate::people) rotations: Vec<DQuat>,
}

/// A point fixed to a source joint.
#[derive(Clone, Copy, Debug)]
pub(in crate::people) struct Anchor {
    pub(in crate::people) joint: usize,
    /// Offset in the joint's frame at rest, source units.
    pub(in crate::people) offset: DVec3,
}

/// The counterpart of a canonical joint in the source.
#[derive(Clone, Copy, Debug)]
pub(in crate::people) struct RestJoint {
    /// The source joint with which it turns.
    pub(in crate::people) turns_with: usize,
    /// Its position.
    pub(in crate::people) lies_at: Anchor,
    /// Rotation from canonical axes at rest to source axes at rest.
    pub(in crate::people) axes: DQuat,
}

/// The calibration of one source skeleton.
pub(in crate::people) struct RestCalibration {
    pub(in crate::people) parts: [RestJoint; JOINTS],
    /// World orientation of every source joint in the rest pose: identity in a file whose own rest
    /// pose stands.
    pub(in crate::people) zero: Vec<DQuat>,
    /// Canonical offsets, source units.
    pub(in crate::people) offsets: [DVec3; JOINTS],
    /// Whether the rest pose is a standing pose of the file, not a frame of the motion.
    pub(in crate::people) stands: bool,
    pub(in crate::people) warnings: Vec<String>,
}

/// Returns the midpoint of a pair of joints.
fn middle(positions: &[DVec3], pair: [usize; 2]) -> DVec3 {
    positions[pair[0]].midpoint(positions[pair[1]])
}

/// Returns the signed axis nearest to `direction`.
pub(in crate::people) fn nearest_axis(direction: DVec3) -> DVec3 {
    let magnitudes = direction.abs();
    let axis = (0..3)
        .max_by(|&a, &b| magnitudes[a].total_cmp(&magnitudes[b]))
        .unwrap_or(1);
    DVec3::AXES[axis] * direction[axis].signum()
}

/// Drops the joints of a fine trunk that never turn: they belong to the segment below.
fn keep_bending(motion: &Motion, roles: &mut JointRoles) {
    let turns = |joint: usize| {
        let first = motion.frames[0].rotations[joint];
        let mut others = motion.frames.iter().map(|frame| frame.rotations[joint]);
        others.any(|rotation| rotation.angle_between(first) > STILL_RAD)
    };
    if roles.is_fine_trunk && roles.trunk.iter().any(|&joint| turns(joint)) {
        let head = roles.trunk.last().copied();
        roles
            .trunk
            .retain(|&joint| Some(joint) == head || turns(joint));
    }
}

/// Returns the file's own rest pose.
pub(in crate::people) fn identity_pose(motion: &Motion) -> Globals {
    let mut positions: Vec<DVec3> = Vec::with_capacity(motion.joints.len());
    for joint in &motion.joints {
        positions.push(
            joint
                .parent
                .map_or(DVec3::ZERO, |parent| positions[parent] + joint.offset),
        );
    }
    let rotations = vec![DQuat::IDENTITY; motion.joints.len()];
    Globals {
        positions,
        rotations,
    }
}

/// Returns the vector from the middle of the hips to the middle of the shoulders.
fn trunk_of(positions: &[DVec3], roles: &JointRoles) -> DVec3 {
    middle(positions, roles.upper_arm) - middle(positions, roles.thigh)
}

/// Returns the vector from the right to the left hip, or knee if the hips coincide.
pub(in crate::people) fn across(
    positions: &[DVec3],
    thigh: [usize; 2],
    shank: [usize; 2],
) -> DVec3 {
    let hips = positions[thigh[0]] - positions[thigh[1]];
    if hips == DVec3::ZERO {
        positions[shank[0]] - positions[shank[1]]
    } else {
        hips
    }
}

/// Returns whether the legs continue the trunk downwards and the hips lie across it.
fn stands(positions: &[DVec3], roles: &JointRoles) -> bool {
    let up = trunk_of(positions, roles).normalize_or_zero();
    let left = across(positions, roles.thigh, roles.shank).normalize_or_zero();
    (0..2).all(|side| {
        let chain = [roles.thigh[side], roles.shank[side], roles.foot[side]].map(|j| positions[j]);
        // A segment without length (an ankle on the knee) has no direction.
        chain.windows(2).all(|pair| {
            pair[0] == pair[1] || (pair[1] - pair[0]).normalize_or_zero().dot(up) < -0.8
        })
    }) && left.dot(up).abs() < 0.5
}

/// Returns the frame whose legs are straightest under the trunk along the world's `up`.
fn best_standing(frames: &[Globals], roles: &JointRoles, up: DVec3) -> usize {
    let score = |globals: &Globals| {
        let p = &globals.positions;
        let limb = |a: usize, b: usize| (p[b] - p[a]).normalize_or_zero().dot(-up);
        let legs: f64 = (0..2)
            .map(|s| limb(roles.thigh[s], roles.shank[s]) + limb(roles.shank[s], roles.foot[s]))
            .sum();
        legs + trunk_of(p, roles).normalize_or_zero().dot(up)
    };
    (0..frames.len())
        .max_by(|&a, &b| score(&frames[a]).total_cmp(&score(&frames[b])))
        .unwrap_or(0)
}

/// Returns the canonical joint positions in a file's own standing rest pose, metres, Y up.
///
/// # Errors
/// If a joint that gait needs is missing, or the rest pose does not stand.
pub(in crate::people) fn standing_points(motion: &Motion) -> Result<[DVec3; JOINTS], String> {
    let mut roles = JointRoles::find(&motion.joints)?;
    let unit_m = choose_unit(
        leg_of(motion, &roles),
        motion.unit_m,
        UnitFamily::from_motion(motion),
        &mut Vec::new(),
    )?;
    let mut own = identity_pose(motion);
    if let Some(skin) = &motion.skin {
        for position in &mut own.positions {
            *position += skin.root;
        }
    }
    if !stands(&own.positions, &roles) {
        return Err("the skeleton's rest pose does not stand".into());
    }
    let up = nearest_axis(trunk_of(&own.positions, &roles));
    let rest = RestCalibration::calibrate(motion, &mut roles, &[], None, up)?;
    let world = DQuat::from_rotation_arc(up, DVec3::Y);
    Ok(source_points(&rest, &own).map(|point| world * point * unit_m))
}

/// Returns the frame in which a foot is flat: its ankle and toe move least.
fn flat_foot(frames: &[Globals], foot: usize, toe: usize) -> usize {
    let speed = |i: usize| {
        let (a, b) = (&frames[i - 1].positions, &frames[i + 1].positions);
        (a[foot] - b[foot]).length() + (a[toe] - b[toe]).length()
    };
    (1..frames.len().saturating_sub(1))
        .min_by(|&a, &b| speed(a).total_cmp(&speed(b)))
        .unwrap_or(0)
}

impl RestCalibration {
    /// Calibrates a source skeleton. `frames` is the clean motion, `t_pose` the pose before it, if
    /// any, and `up` the world's up axis in the source, found from the motion.
    ///
    /// # Errors
    /// If the skeleton is too degenerate to have a left and an up direction.
    pub(in crate::people) fn calibrate(
        motion: &Motion,
        roles: &mut JointRoles,
        frames: &[Globals],
        t_pose: Option<&Globals>,
        up: DVec3,
    ) -> Result<Self, String> {
        keep_bending(motion, roles);
        let own = identity_pose(motion);
        let mut warnings = Vec::new();
        let own_stands = stands(&own.positions, roles);
        let pose = if own_stands {
            &own
        } else if let Some(pose) = t_pose.filter(|pose| stands(&pose.positions, roles)) {
            warnings.push("the file's rest pose is folded: its T-pose is used".into());
            pose
        } else {
            let frame = best_standing(frames, roles, up);
            warnings.push(format!(
                "the file's rest pose is folded: upright frame {frame} is used, twists are relative to it"
            ));
            &frames[frame]
        };
        let is_rest = !frames.iter().any(|frame| std::ptr::eq(frame, pose));
        let p = &pose.positions;
        let trunk = trunk_of(p, roles);
        let vertical = nearest_axis(if own_stands { trunk } else { up });
        // A standing rest pose is upright even if its trunk curves; a frame of the motion leans.
        let is_upright = trunk.normalize_or_zero().dot(vertical) > 0.94;
        let rest_up = if is_upright && is_rest {
            vertical
        } else {
            trunk
        };
        let base = swap_sides_if_needed(p, rest_up, roles, &mut warnings)?;
        let mut parts = place(p, roles, base, rest_up);
        let points: [DVec3; JOINTS] = std::array::from_fn(|j| {
            let at = parts[j].lies_at;
            p[at.joint] + at.offset
        });

        hang_limbs(&mut parts, &points, base);
        let feet = [
            (Joint::LeftFoot, Joint::LeftShank),
            (Joint::RightFoot, Joint::RightShank),
        ];
        for (side, (foot, shank)) in feet.into_iter().enumerate() {
            let source = roles.foot[side];
            let toe_in = |pose: &Globals| match (roles.toe[side], motion.joints[source].end) {
                (Some(toe), _) => pose.positions[toe] - pose.positions[source],
                (None, Some(end)) => pose.rotations[source] * end,
                (None, None) => base * DVec3::Z,
            };
            parts[foot.index()].axes = if is_rest {
                // Legs spread sideways at rest (CMU: 20 degrees) tilt the soles, so the sole is
                // level when the leg hangs straight.
                let down = base.inverse() * parts[shank.index()].axes * -DVec3::Y;
                let spread = DQuat::from_rotation_z(libm::atan2(down.x, -down.y));
                let level = base * spread;
                level * yaw_towards(level.inverse() * toe_in(pose))
            } else {
                let toe = roles.toe[side].unwrap_or(source);
                let flat = &frames[flat_foot(frames, source, toe)];
                let level = DQuat::from_rotation_arc(base * DVec3::Y, up) * base;
                // Back from the flat frame to the rest pose.
                let level = level * yaw_towards(level.inverse() * toe_in(flat));
                pose.rotations[source] * flat.rotations[source].inverse() * level
            };
        }

        let offsets = std::array::from_fn(|index| {
            let parent = Joint::ALL[index].parent();
            parent.map_or(DVec3::ZERO, |parent| {
                let parent = parent.index();
                parts[parent].axes.inverse() * (points[index] - points[parent])
            })
        });
        for part in &mut parts {
            let at = &mut part.lies_at;
            at.offset = pose.rotations[at.joint].inverse() * at.offset;
        }
        Ok(Self {
            parts,
            zero: pose.rotations.clone(),
            offsets,
            stands: is_rest,
            warnings,
        })
    }
}

/// Sets the axes of limbs, which hang along -Y; the minimal rotation keeps their twist.
fn hang_limbs(parts: &mut [RestJoint; JOINTS], points: &[DVec3; JOINTS], base: DQuat) {
    for (joint, child) in [
        (Joint::LeftUpperArm, Joint::LeftForearm),
        (Joint::LeftForearm, Joint::LeftHand),
        (Joint::RightUpperArm, Joint::RightForearm),
        (Joint::RightForearm, Joint::RightHand),
        (Joint::LeftThigh, Joint::LeftShank),
        (Joint::LeftShank, Joint::LeftFoot),
        (Joint::RightThigh, Joint::RightShank),
        (Joint::RightShank, Joint::RightFoot),
    ] {
        let along = base.inverse() * (points[child.index()] - points[joint.index()]);
        if let Some(along) = along.try_normalize() {
            parts[joint.index()].axes = base * DQuat::from_rotation_arc(-DVec3::Y, along);
        } else if let Some(parent) = joint.parent() {
            parts[joint.index()].axes = parts[parent.index()].axes;
        }
    }
    for (hand, forearm) in [
        (Joint::LeftHand, Joint::LeftForearm),
        (Joint::RightHand, Joint::RightForearm),
    ] {
        parts[hand.index()].axes = parts[forearm.index()].axes;
    }
}

/// Returns the rotation about Y that turns +Z towards the floor projection of `toe`.
fn yaw_towards(toe: DVec3) -> DQuat {
    if libm::hypot(toe.x, toe.z) < 1e-6 * toe.length() || toe == DVec3::ZERO {
        return DQuat::IDENTITY;
    }
    DQuat::from_rotation_y(libm::atan2(toe.x, toe.z))
}

/// Returns the rotation from canonical to source axes with +X along `left` and +Y along `up`; none
/// if they are degenerate.
pub(in crate::people) fn base_of(left: DVec3, up: DVec3) -> Option<DQuat> {
    let y = up.try_normalize()?;
    let x = left.reject_from_normalized(y).try_normalize()?;
    Some(DQuat::from_mat3(&DMat3::from_cols(x, y, x.cross(y))).normalize())
}

/// Returns the axes of the rest pose, after exchanging sides that were named the wrong way round.
/// The feet show it for the legs, because they point ahead.
fn swap_sides_if_needed(
    p: &[DVec3],
    up: DVec3,
    roles: &mut JointRoles,
    warnings: &mut Vec<String>,
) -> Result<DQuat, String> {
    let degenerate = || "the skeleton is degenerate: it has no left or no up direction".to_owned();
    let mut left = across(p, roles.thigh, roles.shank);
    let base = base_of(left, up).ok_or_else(degenerate)?;
    let toes: DVec3 = (0..2)
        .filter_map(|side| Some(p[roles.toe[side]?] - p[roles.foot[side]]))
        .sum();
    if (base.inverse() * toes).z < -0.3 * toes.length() {
        warnings.push("left and right legs were named the wrong way round: exchanged".into());
        for pair in [&mut roles.thigh, &mut roles.shank, &mut roles.foot] {
            pair.swap(0, 1);
        }
        roles.toe.swap(0, 1);
        left = -left;
    }
    if (p[roles.upper_arm[0]] - p[roles.upper_arm[1]]).dot(left) < 0.0 {
        warnings.push("left and right arms were named the wrong way round: exchanged".into());
        for pair in [&mut roles.upper_arm, &mut roles.forearm, &mut roles.hand] {
            pair.swap(0, 1);
        }
        roles.clavicle.swap(0, 1);
    }
    base_of(left, up).ok_or_else(degenerate)
}

/// The joints of both sides, from the clavicle to the foot.
const SIDES: [[Joint; 7]; 2] = [
    [
        Joint::LeftClavicle,
        Joint::LeftUpperArm,
        Joint::LeftForearm,
        Joint::LeftHand,
        Joint::LeftThigh,
        Joint::LeftShank,
        Joint::LeftFoot,
    ],
    [
        Joint::RightClavicle,
        Joint::RightUpperArm,
        Joint::RightForearm,
        Joint::RightHand,
        Joint::RightThigh,
        Joint::RightShank,
        Joint::RightFoot,
    ],
];

/// Chooses the source joint of every canonical joint. All axes are `base`.
fn place(p: &[DVec3], roles: &JointRoles, base: DQuat, up: DVec3) -> [RestJoint; JOINTS] {
    let hips = middle(p, roles.thigh);
    let shoulders = middle(p, roles.upper_arm);
    // Height in the trunk: 0 at the hips, 1 at the shoulders.
    let up = up.normalize_or_zero();
    let full = (shoulders - hips).dot(up);
    let height = |joint: usize| (p[joint] - hips).dot(up) / full;
    let at = |joint: usize, point: DVec3| Anchor {
        joint,
        offset: point - p[joint],
    };
    let on = |joint: usize| at(joint, p[joint]);

    let (head, trunk) = roles
        .trunk
        .split_last()
        .map_or((roles.chest, &[][..]), |(h, t)| (*h, t));
    let chest_at = trunk.iter().position(|&joint| joint == roles.chest);
    // The neck is the chest itself if the arms hang on the base of the neck (Shum), else the first
    // joint above the chest.
    let neck_at = match chest_at {
        Some(chest) if height(trunk[chest]) > 0.95 => Some(chest),
        Some(chest) => (chest + 1..trunk.len()).find(|&i| height(trunk[i]) > 0.6),
        None => trunk.iter().position(|&joint| height(joint) > 0.8),
    };
    let below = &trunk[..neck_at.unwrap_or(trunk.len())];
    let nearest = |joints: &[usize], target: f64| {
        joints.iter().copied().min_by(|&a, &b| {
            (height(a) - target)
                .abs()
                .total_cmp(&(height(b) - target).abs())
        })
    };
    let ribs = below.last().copied().unwrap_or(roles.chest);
    let thorax = match nearest(below, 0.45) {
        Some(joint) => on(joint),
        None => at(ribs, hips.lerp(shoulders, 0.45)),
    };
    let lumbar: Vec<usize> = below
        .iter()
        .copied()
        .filter(|&joint| joint != thorax.joint && (-0.2..0.35).contains(&height(joint)))
        .collect();
    let thorax_point = p[thorax.joint] + thorax.offset;
    let (spine_turns, spine) = match nearest(&lumbar, 0.18) {
        Some(joint) => (joint, on(joint)),
        None => (roles.pelvis, at(roles.pelvis, hips.lerp(thorax_point, 0.4))),
    };
    let (neck_turns, neck) = match neck_at {
        Some(i) => (trunk[i], on(trunk[i])),
        None => (ribs, at(ribs, shoulders)),
    };

    let mut parts = [RestJoint {
        turns_with: roles.pelvis,
        lies_at: at(roles.pelvis, hips),
        axes: base,
    }; JOINTS];
    let mut set = |joint: Joint, turns_with: usize, lies_at: Anchor| {
        parts[joint.index()] = RestJoint {
            turns_with,
            lies_at,
            axes: base,
        };
    };
    // The ribs of a fine trunk turn with their base, which fits MakeHuman's skin best.
    let thorax_turns = if roles.is_fine_trunk {
        thorax.joint
    } else {
        ribs
    };
    set(Joint::Spine, spine_turns, spine);
    set(Joint::Thorax, thorax_turns, thorax);
    set(Joint::Neck, neck_turns, neck);
    set(Joint::Head, head, on(head));
    for (side, [clavicle, upper_arm, forearm, hand, thigh, shank, foot]) in
        SIDES.into_iter().enumerate()
    {
        match roles.clavicle[side] {
            Some(joint) => set(clavicle, joint, on(joint)),
            None => set(
                clavicle,
                ribs,
                at(ribs, shoulders.lerp(p[roles.upper_arm[side]], 0.15)),
            ),
        }
        for (joint, pair) in [
            (upper_arm, roles.upper_arm),
            (forearm, roles.forearm),
            (hand, roles.hand),
            (thigh, roles.thigh),
            (shank, roles.shank),
            (foot, roles.foot),
        ] {
            set(joint, pair[side], on(pair[side]));
        }
    }
    parts
}

/// Returns the canonical joint positions in the source, source units and axes.
pub(in crate::people) fn source_points(rest: &RestCalibration, frame: &Globals) -> [DVec3; JOINTS] {
    std::array::from_fn(|joint| {
        let at = rest.parts[joint].lies_at;
        frame.positions[at.joint] + frame.rotations[at.joint] * at.offset
    })
}
