//! Skin weights: the joint with the nearest bone moves a vertex, near a joint with its neighbour.
//!
//! Distances are in units of a person's thickness around the bone: the flank is farther from the
//! spine than from the upper arm, and still belongs to the trunk.

use std::f64::consts::TAU;

use edgegait_core::skeleton::{JOINTS, Joint};
use glam::DVec3;

use super::centres::Centres;
use crate::people::cohort::anthropometry::Dimensions;
use crate::people::retarget::follow::main_child;

/// Difference of distances, in thicknesses, below which two bones share a vertex. Our choice.
const BLEND: f64 = 0.4;

/// A segment of a joint's bones, around which the joint moves vertices.
struct BoneSegments {
    joint: Joint,
    from: DVec3,
    to: DVec3,
    thickness_m: f64,
}

impl BoneSegments {
    /// Returns the distance of a point, in thicknesses.
    fn distance(&self, point: DVec3) -> f64 {
        let along = self.to - self.from;
        let share = (point - self.from).dot(along) / along.length_squared().max(1e-12);
        let nearest = self.from + along * share.clamp(0.0, 1.0);
        point.distance(nearest) / self.thickness_m
    }
}

/// Returns the joints that move each vertex, and their shares.
pub(super) fn weights(
    vertices: &[DVec3],
    centres: &Centres,
    d: &Dimensions,
) -> Vec<Vec<(usize, f64)>> {
    let bones = bones(centres, d);
    let middle = centres.joints[Joint::Pelvis.index()].x;
    vertices
        .iter()
        .map(|vertex| shares(*vertex, vertex.x > middle, &bones))
        .collect()
}

fn shares(vertex: DVec3, is_left: bool, bones: &[BoneSegments]) -> Vec<(usize, f64)> {
    let mut distances = [f64::INFINITY; JOINTS];
    for bone in bones {
        let is_midline = bone.joint.mirrored() == bone.joint;
        if is_midline || bone.joint.is_left() == is_left {
            let distance = &mut distances[bone.joint.index()];
            *distance = distance.min(bone.distance(vertex));
        }
    }
    let nearest = |is_candidate: &dyn Fn(Joint) -> bool| {
        let candidates = Joint::ALL.into_iter().filter(|joint| is_candidate(*joint));
        candidates.min_by(|a, b| distances[a.index()].total_cmp(&distances[b.index()]))
    };
    let Some(first) = nearest(&|_| true) else {
        return Vec::new();
    };
    let is_neighbour =
        |joint: Joint| joint.parent() == Some(first) || first.parent() == Some(joint);
    let Some(second) = nearest(&is_neighbour) else {
        return vec![(first.index(), 1.0)];
    };
    let apart = distances[second.index()] - distances[first.index()];
    let share = 0.5 * (1.0 - apart / BLEND).max(0.0);
    if share == 0.0 {
        return vec![(first.index(), 1.0)];
    }
    vec![(first.index(), 1.0 - share), (second.index(), share)]
}

fn bones(centres: &Centres, d: &Dimensions) -> Vec<BoneSegments> {
    let at = |joint: Joint| centres.joints[joint.index()];
    let mut bones: Vec<BoneSegments> = Joint::ALL
        .into_iter()
        .filter_map(|joint| {
            let end = main_child(joint).map(at).or(centres.ends[joint.index()]);
            Some(BoneSegments {
                joint,
                from: at(joint),
                to: end?,
                thickness_m: thickness_m(joint, d),
            })
        })
        .collect();
    for to in [Joint::LeftThigh, Joint::RightThigh, Joint::Spine] {
        bones.push(BoneSegments {
            joint: Joint::Pelvis,
            from: at(Joint::Pelvis),
            to: at(to),
            thickness_m: thickness_m(Joint::Pelvis, d),
        });
    }
    bones
}

/// Returns half of the mean of breadth and depth, or the radius of a circumference, metres.
fn thickness_m(joint: Joint, d: &Dimensions) -> f64 {
    match joint {
        Joint::Pelvis => 0.25 * (d.hip_breadth + d.buttock_depth),
        Joint::Spine => 0.25 * (d.waist_breadth + d.waist_depth),
        Joint::Thorax => 0.25 * (d.chest_breadth + d.chest_depth),
        Joint::Neck => d.neck_circumference / TAU,
        Joint::Head => 0.25 * (d.head_breadth + d.head_length),
        Joint::LeftClavicle | Joint::RightClavicle | Joint::LeftUpperArm | Joint::RightUpperArm => {
            d.biceps_circumference / TAU
        }
        Joint::LeftForearm | Joint::RightForearm => d.forearm_circumference / TAU,
        Joint::LeftHand | Joint::RightHand => 0.5 * d.hand_breadth,
        Joint::LeftThigh | Joint::RightThigh => d.thigh_circumference / TAU,
        Joint::LeftShank | Joint::RightShank => d.calf_circumference / TAU,
        Joint::LeftFoot | Joint::RightFoot => 0.5 * d.foot_breadth,
    }
}
