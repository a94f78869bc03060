//! Images of the parts of a body: convex hulls, filled at any resolution.
//!
//! The code is independent of the rasterisers.

use edgegait::people::{Body, forward_kinematics};
use edgegait_core::skeleton::{JOINTS, Joint};
use glam::{DQuat, DVec2, DVec3};

pub const TRUNK: u8 = 1;
pub const ARMS: u8 = 2;
pub const LEGS: u8 = 4;

/// An image whose pixels hold the parts that are visible there.
pub struct Parts {
    pub columns: usize,
    pub pixels: Vec<u8>,
}

/// A pose: the place of the pelvis, and the rotation of each joint.
pub type Posed<'a> = (DVec3, &'a [DQuat; JOINTS]);

impl Parts {
    /// Draws a posed body. `place` projects a point of the world to pixels from the upper left
    /// corner, x to the right, y down. A pixel is set if its centre is inside a hull.
    pub fn draw(
        body: &Body,
        (root, rotations): Posed<'_>,
        place: impl Fn(DVec3) -> DVec2,
        (rows, columns): (usize, usize),
    ) -> Self {
        let (positions, globals) = forward_kinematics(&body.offsets, root, rotations);
        let mut pixels = vec![0; rows * columns];
        for hull in &body.hulls {
            let (at, turn) = (positions[hull.joint.index()], globals[hull.joint.index()]);
            let points: Vec<DVec2> = hull.points.iter().map(|&p| place(at + turn * p)).collect();
            let part = part(hull.joint);
            for row in 0..rows {
                let y = row as f64 + 0.5;
                let Some((from, to)) = span(&points, y) else {
                    continue;
                };
                let first = (from - 0.5).ceil().max(0.0) as usize;
                let end = ((to + 0.5).floor().max(0.0) as usize).min(columns);
                for column in first..end {
                    pixels[row * columns + column] |= part;
                }
            }
        }
        Self { columns, pixels }
    }
}

/// Returns the range in which a horizontal line cuts the convex hull of points, from the lines
/// between points above and below it.
fn span(points: &[DVec2], y: f64) -> Option<(f64, f64)> {
    let mut found: Option<(f64, f64)> = None;
    for a in points.iter().filter(|p| p.y <= y) {
        for b in points.iter().filter(|p| p.y > y) {
            let x = a.x + (y - a.y) / (b.y - a.y) * (b.x - a.x);
            let (from, to) = found.unwrap_or((x, x));
            found = Some((from.min(x), to.max(x)));
        }
    }
    found
}

fn part(joint: Joint) -> u8 {
    let of =
        |top: Joint| std::iter::successors(Some(joint), |joint| joint.parent()).any(|at| at == top);
    if of(Joint::LeftUpperArm) || of(Joint::RightUpperArm) {
        ARMS
    } else if of(Joint::LeftThigh) || of(Joint::RightThigh) {
        LEGS
    } else {
        TRUNK
    }
}
