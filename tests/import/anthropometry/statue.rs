//! A body that stands in the rest pose with its soles on the floor, for cuts along planes.

use edgegait::people::{Body, forward_kinematics};
use edgegait_core::skeleton::{JOINTS, Joint};
use glam::{DQuat, DVec2, DVec3};

/// The number of levels at which a range of heights is searched.
const LEVELS: usize = 400;

/// Hull points and joints of a standing body, metres; the floor is at y = 0.
pub struct Statue {
    pub hulls: Vec<(Joint, Vec<DVec3>)>,
    joints: [DVec3; JOINTS],
}

impl Statue {
    pub fn of(body: &Body) -> Self {
        let rest = [DQuat::IDENTITY; JOINTS];
        let (at_hips, _) = forward_kinematics(&body.offsets, DVec3::ZERO, &rest);
        let all = body.hulls.iter();
        let points = all.flat_map(|hull| {
            let joint = at_hips[hull.joint.index()];
            hull.points.iter().map(move |&point| joint + point)
        });
        let floor = points.map(|point| point.y).fold(f64::MAX, f64::min);
        let joints = at_hips.map(|joint| joint - floor * DVec3::Y);
        let hulls = body.hulls.iter().map(|hull| {
            let at = joints[hull.joint.index()];
            let points = hull.points.iter().map(|&point| at + point);
            (hull.joint, points.collect())
        });
        Self {
            hulls: hulls.collect(),
            joints,
        }
    }

    pub fn joint(&self, joint: Joint) -> DVec3 {
        self.joints[joint.index()]
    }

    /// Returns the points of the hulls of these joints.
    pub fn points(&self, of: &[Joint]) -> Vec<DVec3> {
        let hulls = self.hulls.iter().filter(|(joint, _)| of.contains(joint));
        hulls.flat_map(|(_, points)| points.clone()).collect()
    }

    /// Returns the range of the hulls of these joints along an axis.
    pub fn extent(&self, of: &[Joint], axis: usize) -> (f64, f64) {
        extent(self.points(of).iter().map(|point| point[axis]))
    }

    /// Returns points where the plane `axis` = `at` cuts the hulls of these joints. Lines between
    /// the points of a hull on both sides of the plane cut it in points whose convex hull is the
    /// section.
    pub fn cut(&self, of: &[Joint], axis: usize, at: f64) -> Vec<DVec3> {
        let mut cut = Vec::new();
        for (_, points) in self.hulls.iter().filter(|(joint, _)| of.contains(joint)) {
            for a in points.iter().filter(|point| point[axis] <= at) {
                for b in points.iter().filter(|point| point[axis] >= at) {
                    let along = b[axis] - a[axis];
                    let share = if along > 0.0 {
                        (at - a[axis]) / along
                    } else {
                        0.0
                    };
                    cut.push(a.lerp(*b, share));
                }
            }
        }
        cut
    }

    /// Returns the breadth from left to right at a height.
    pub fn breadth(&self, of: &[Joint], height: f64) -> f64 {
        let (from, to) = extent(self.cut(of, 1, height).iter().map(|point| point.x));
        to - from
    }

    /// Returns the depth from back to front at a height.
    pub fn depth(&self, of: &[Joint], height: f64) -> f64 {
        let (from, to) = extent(self.cut(of, 1, height).iter().map(|point| point.z));
        to - from
    }

    /// Returns the length of a tape around the hulls of these joints at a height.
    pub fn tape(&self, of: &[Joint], height: f64) -> f64 {
        let cut = self.cut(of, 1, height);
        perimeter(
            cut.iter()
                .map(|point| DVec2::new(point.x, point.z))
                .collect(),
        )
    }
}

/// Returns evenly spaced heights between two, both included.
pub fn levels(from: f64, to: f64) -> impl Iterator<Item = f64> {
    (0..=LEVELS).map(move |level| from + (to - from) * level as f64 / LEVELS as f64)
}

/// Returns the least and the greatest number.
pub fn extent(numbers: impl Iterator<Item = f64>) -> (f64, f64) {
    numbers.fold((f64::MAX, f64::MIN), |(least, most), number| {
        (least.min(number), most.max(number))
    })
}

/// Returns the perimeter of the convex hull of points (monotone chain, Andrew 1979).
fn perimeter(mut points: Vec<DVec2>) -> f64 {
    points.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    let half = |points: &mut dyn Iterator<Item = DVec2>| {
        let mut chain: Vec<DVec2> = Vec::new();
        for point in points {
            while let [.., a, b] = chain[..] {
                if (b - a).perp_dot(point - b) > 0.0 {
                    break;
                }
                chain.pop();
            }
            chain.push(point);
        }
        chain
            .windows(2)
            .map(|pair| pair[0].distance(pair[1]))
            .sum::<f64>()
    };
    half(&mut points.iter().copied()) + half(&mut points.iter().rev().copied())
}

#[test]
fn a_tape_around_a_square_and_a_point_within_measures_its_four_sides() {
    let corners = [(0.0, 0.0), (2.0, 0.0), (1.0, 0.5), (2.0, 2.0), (0.0, 2.0)];
    let around = perimeter(corners.map(DVec2::from).to_vec());
    assert!((around - 8.0).abs() < 1e-12, "{around}");
}
