//! The canonical joints as markers determine them, before segment lengths are made constant.

use edgegait_core::skeleton::{JOINTS, Joint};
use glam::{DQuat, DVec3};

use crate::people::retarget::rest_pose::base_of;

/// Positions (metres, Y up) and orientations by joint, then by frame. A joint that no marker
/// determines has none.
#[derive(Default)]
pub(super) struct MarkerJoints {
    points: [Option<Vec<DVec3>>; JOINTS],
    turns: [Option<Vec<DQuat>>; JOINTS],
}

impl MarkerJoints {
    /// Sets a joint's position in every frame.
    pub(super) fn put(&mut self, joint: Joint, points: Vec<DVec3>) {
        self.points[joint.index()] = Some(points);
    }

    /// Sets the world orientation of a joint's segment in every frame.
    pub(super) fn turn(&mut self, joint: Joint, turns: Vec<DQuat>) {
        self.turns[joint.index()] = Some(turns);
    }

    /// Returns a joint's positions, if markers determine them.
    pub(super) fn points(&self, joint: Joint) -> Option<&[DVec3]> {
        self.points[joint.index()].as_deref()
    }

    /// Returns the orientations of a joint's segment, if markers determine them.
    pub(super) fn turns(&self, joint: Joint) -> Option<&[DQuat]> {
        self.turns[joint.index()].as_deref()
    }
}

/// Returns the rotation of each frame with +Y along `up` and +X as near to `left` as possible. A
/// degenerate frame repeats the one before it; at the start, the first valid one.
pub(super) fn frames_of(left: &[DVec3], up: &[DVec3]) -> Vec<DQuat> {
    let found: Vec<Option<DQuat>> = left.iter().zip(up).map(|(l, u)| base_of(*l, *u)).collect();
    let mut last = found
        .iter()
        .flatten()
        .next()
        .copied()
        .unwrap_or(DQuat::IDENTITY);
    found
        .into_iter()
        .map(|turn| {
            last = turn.unwrap_or(last);
            last
        })
        .collect()
}

/// Combines two tracks frame by frame.
pub(super) fn each<A: Copy, B: Copy, C>(a: &[A], b: &[B], f: impl Fn(A, B) -> C) -> Vec<C> {
    a.iter().zip(b).map(|(a, b)| f(*a, *b)).collect()
}

/// Returns the midpoints of two tracks, frame by frame.
pub(super) fn middles(a: &[DVec3], b: &[DVec3]) -> Vec<DVec3> {
    each(a, b, DVec3::midpoint)
}
