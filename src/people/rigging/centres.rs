//! The joints of a mesh: those of a person of the same stature, in the middle of the limbs.

use edgegait_core::skeleton::{JOINTS, Joint};
use glam::DVec3;

use super::bounds;
use super::surface::{Ring, distances, ring};
use crate::import::obj::Mesh;
use crate::people::cohort::anthropometry::Dimensions;
use crate::people::cohort::body;

/// Distance between the sections of an arm, metres.
const STEP_M: f64 = 0.01;

/// Distances from the fingertip, in hand lengths, where the thinnest section is the wrist. Our
/// choice.
const WRIST: std::ops::RangeInclusive<f64> = 0.8..=1.25;

/// The part of the upper arm, from the elbow, whose sections contain the arm alone. Our choice.
const FREE_ARM: std::ops::Range<f64> = 0.1..0.6;

/// Joints of a mesh, metres, in its own pose.
pub(super) struct Centres {
    pub(super) joints: [DVec3; JOINTS],
    /// The far end of the segments that end without a joint: crown, fingertips and toes.
    pub(super) ends: [Option<DVec3>; JOINTS],
}

impl Centres {
    /// Finds the joints of a mesh that stands on y = 0 and faces +Z.
    pub(super) fn find(mesh: &Mesh, d: &Dimensions) -> Result<Self, String> {
        let middle = {
            let (low, high) = bounds(&mesh.vertices);
            0.5 * (low.x + high.x)
        };
        // From the left (+X) fingertip, then from the right one.
        let tips = [1.0, -1.0].map(|sign| {
            let reach = |v: &usize| sign * mesh.vertices[*v].x;
            let all = 0..mesh.vertices.len();
            all.max_by(|a, b| reach(a).total_cmp(&reach(b)))
                .unwrap_or(0)
        });
        let along = tips.map(|tip| distances(mesh, tip));
        let arm_m = d.acromion_radiale_length + d.radiale_stylion_length + d.hand_length;
        let is_arm = |v: usize| along.iter().any(|along| along[v] < 0.9 * arm_m);
        let heights: Vec<f64> = mesh.vertices.iter().map(|v| v.y).collect();
        let trunk = |height: f64| {
            ring(mesh, &heights, height, |v| !is_arm(v))
                .map(|ring| ring.centre)
                .ok_or_else(|| {
                    format!("no trunk {height:.2} m above the soles: is it a standing person?")
                })
        };
        let leg = |side: usize, height: f64| {
            let is_side = |v: usize| (mesh.vertices[v].x > middle) == (side == 0);
            ring(mesh, &heights, height, |v| is_side(v) && !is_arm(v))
                .map(|ring| ring.centre)
                .ok_or_else(|| {
                    format!("no leg {height:.2} m above the soles: is it a standing person?")
                })
        };

        let mut centres = Self {
            joints: standing(d),
            ends: [None; JOINTS],
        };
        for joint in [Joint::Pelvis, Joint::Neck, Joint::Head] {
            let at = &mut centres.joints[joint.index()];
            *at = DVec3::new(middle, at.y, trunk(at.y)?.z);
        }
        // The spine is not the trunk's middle. Both of its joints are as far behind the hips as a
        // person's lumbar joint: the bones of meshes do not curve forwards above it.
        let hips_z = centres.joints[Joint::Pelvis.index()].z;
        let spine_z = hips_z + centres.joints[Joint::Spine.index()].z;
        for joint in [Joint::Spine, Joint::Thorax] {
            let at = &mut centres.joints[joint.index()];
            *at = DVec3::new(middle, at.y, spine_z);
        }
        let neck = centres.joints[Joint::Neck.index()];
        let head = centres.joints[Joint::Head.index()];
        centres.ends[Joint::Head.index()] = Some(DVec3::new(head.x, d.stature, head.z));
        for (side, limb) in LIMBS.iter().enumerate() {
            let sign = [1.0, -1.0][side];
            let set = |centres: &mut Self, joint: Joint, at| centres.joints[joint.index()] = at;
            let hip = centres.joints[limb.thigh.index()];
            let pelvis = centres.joints[Joint::Pelvis.index()];
            set(
                &mut centres,
                limb.thigh,
                DVec3::new(middle + hip.x, hip.y, pelvis.z),
            );
            let knee = leg(side, d.knee_height)?;
            set(&mut centres, limb.shank, knee);
            // Sections at the ankle include the foot, so the shank is extrapolated to it.
            let above = leg(side, 2.0 * d.malleolus_height)?;
            let share = (d.knee_height - d.malleolus_height) / (knee.y - above.y);
            let ankle = knee.lerp(above, share);
            set(&mut centres, limb.foot, ankle);
            let toes = mesh
                .vertices
                .iter()
                .copied()
                .filter(|v| (v.x > middle) == (side == 0) && v.y < d.malleolus_height);
            centres.ends[limb.foot.index()] = toes.max_by(|a, b| a.z.total_cmp(&b.z));

            let clavicle = centres.joints[limb.clavicle.index()];
            set(
                &mut centres,
                limb.clavicle,
                DVec3::new(middle + clavicle.x, clavicle.y, neck.z + 0.04),
            );
            let shoulder_x = middle + centres.joints[limb.upper_arm.index()].x;
            let tip = mesh.vertices[tips[side]];
            let arm = Arm::find(mesh, &along[side], tip, d).ok_or_else(|| {
                format!(
                    "no {} arm away from the trunk: expected an A- or T-pose",
                    ["left", "right"][side]
                )
            })?;
            set(
                &mut centres,
                limb.upper_arm,
                arm.shoulder(sign, shoulder_x, d),
            );
            set(&mut centres, limb.forearm, arm.elbow);
            set(&mut centres, limb.hand, arm.wrist);
            centres.ends[limb.hand.index()] = Some(tip);
        }
        Ok(centres)
    }

    /// Replaces the joints with known ones, metres; those without a place are put onto the mesh's
    /// ankles.
    pub(super) fn with_joints(
        self,
        mut points: [DVec3; JOINTS],
        has_place: bool,
        mesh: &Mesh,
    ) -> Result<Self, String> {
        let ankles = |points: &[DVec3; JOINTS]| {
            points[Joint::LeftFoot.index()].midpoint(points[Joint::RightFoot.index()])
        };
        if !has_place {
            let shift = ankles(&self.joints) - ankles(&points);
            points = points.map(|point| point + shift);
        }
        let (low, high) = bounds(&mesh.vertices);
        let is_inside = |p: &&DVec3| p.cmpge(low).all() && p.cmple(high).all();
        let outside = JOINTS - points.iter().filter(is_inside).count();
        if outside > 0 {
            return Err(format!(
                "{outside} of {JOINTS} joints of the skeleton at rest lie outside of the mesh: expected both in the same pose and place"
            ));
        }
        Ok(Self {
            joints: points,
            ends: self.ends,
        })
    }
}

/// The joints of one side.
struct Limb {
    clavicle: Joint,
    upper_arm: Joint,
    forearm: Joint,
    hand: Joint,
    thigh: Joint,
    shank: Joint,
    foot: Joint,
}

/// The joints of the left and the right side.
const LIMBS: [Limb; 2] = [
    Limb {
        clavicle: Joint::LeftClavicle,
        upper_arm: Joint::LeftUpperArm,
        forearm: Joint::LeftForearm,
        hand: Joint::LeftHand,
        thigh: Joint::LeftThigh,
        shank: Joint::LeftShank,
        foot: Joint::LeftFoot,
    },
    Limb {
        clavicle: Joint::RightClavicle,
        upper_arm: Joint::RightUpperArm,
        forearm: Joint::RightForearm,
        hand: Joint::RightHand,
        thigh: Joint::RightThigh,
        shank: Joint::RightShank,
        foot: Joint::RightFoot,
    },
];

/// Returns the joints of a person of these dimensions in the canonical rest pose, on y = 0.
fn standing(d: &Dimensions) -> [DVec3; JOINTS] {
    let offsets = body::offsets(d);
    let mut at = [DVec3::Y * d.trochanterion_height; JOINTS];
    for joint in Joint::ALL {
        if let Some(parent) = joint.parent() {
            at[joint.index()] = at[parent.index()] + offsets[joint.index()];
        }
    }
    at
}

/// The axis of an arm.
struct Arm {
    wrist: DVec3,
    elbow: DVec3,
    /// Unit vector from the elbow to the shoulder.
    up: DVec3,
}

impl Arm {
    /// Follows an arm from the fingertip; `along` holds the distances from it.
    fn find(mesh: &Mesh, along: &[f64], tip: DVec3, d: &Dimensions) -> Option<Self> {
        let length = d.hand_length + d.radiale_stylion_length + d.acromion_radiale_length;
        let mut axis: Vec<(f64, Ring)> = Vec::new();
        let (mut at, mut run) = (tip, 0.0);
        for step in 1..(length / STEP_M) as usize {
            let ring = ring(mesh, along, step as f64 * STEP_M, |_| true)?;
            run += at.distance(ring.centre);
            at = ring.centre;
            axis.push((run, ring));
        }
        let point = |run: f64| {
            let after = axis.partition_point(|(reached, _)| *reached < run);
            let (a, b) = (axis.get(after.checked_sub(1)?)?, axis.get(after)?);
            Some(a.1.centre.lerp(b.1.centre, (run - a.0) / (b.0 - a.0)))
        };
        let (wrist_run, wrist) = axis
            .iter()
            .filter(|(run, _)| WRIST.contains(&(run / d.hand_length)))
            .min_by(|a, b| a.1.length.total_cmp(&b.1.length))?;
        let elbow_run = wrist_run + d.radiale_stylion_length;
        let elbow = point(elbow_run)?;
        let free = |share: f64| point(elbow_run + share * d.acromion_radiale_length);
        let up = (free(FREE_ARM.end)? - free(FREE_ARM.start)?).try_normalize()?;
        Some(Self {
            wrist: wrist.centre,
            elbow,
            up,
        })
    }

    /// Returns the point where the axis reaches the shoulder's distance from the midline. The axis
    /// of a hanging arm never does; there the usual length counts.
    fn shoulder(&self, sign: f64, shoulder_x: f64, d: &Dimensions) -> DVec3 {
        let usual_m = d.acromion_radiale_length;
        let inwards = -sign * self.up.x;
        let length_m = if inwards > 0.3 {
            sign * (self.elbow.x - shoulder_x) / inwards
        } else {
            usual_m
        };
        self.elbow + self.up * length_m.clamp(0.6 * usual_m, 1.2 * usual_m)
    }
}
