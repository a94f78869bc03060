//! What markers tell of the canonical joints, before segment lengths are made constant.

use edgegait_core::skeleton::{JOINTS, Joint};
use glam::{DQuat, DVec3};

use crate::people::retarget::rest_pose::base_of;

/// Positions and orientations by joint, then by frame: metres, Y up. A joint of which no marker
/// tells has none.
#[derive(Default)]
pub(super) struct MarkerJoints {
    points: [Option<Vec<DVec3>>; JOINTS],
    turns: [Option<Vec<DQuat>>; JOINTS],
}

impl MarkerJoints {
    /// States where a joint is in every frame.
    pub(super) fn put(&mut self, joint: Joint, points: Vec<DVec3>) {
        self.points[joint.index()] = Some(points);
    }

    /// States how a joint's segment is turned in the world in every frame.
    pub(super) fn turn(&mut self, joint: Joint, turns: Vec<DQuat>) {
        self.turns[joint.index()] = Some(turns);
    }

    /// Where a joint is, if markers tell.
    pub(super) fn points(&self, joint: Joint) -> Option<&[DVec3]> {
        self.points[joint.index()].as_deref()
    }

    /// How a joint's segment is turned, if markers tell.
    pub(super) fn turns(&self, joint: Joint) -> Option<&[DQuat]> {
        self.turns[joint.index()].as_deref()
    }
}

/// Rotations with +Y along `up` and +X as near to `left` as can be, by frame; a degenerate frame
/// repeats the one before it (the first: the one after it).
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

/// One vector a frame from two tracks.
pub(super) fn each<A: Copy, B: Copy, C>(a: &[A], b: &[B], f: impl Fn(A, B) -> C) -> Vec<C> {
    a.iter().zip(b).map(|(a, b)| f(*a, *b)).collect()
}

/// Middles of two tracks.
pub(super) fn middles(a: &[DVec3], b: &[DVec3]) -> Vec<DVec3> {
    each(a, b, DVec3::midpoint)
}
