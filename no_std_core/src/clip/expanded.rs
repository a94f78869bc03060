//! A loop's coefficients unpacked once, for many poses.

use super::basis::Basis;
use crate::codebook::Codebook;
use crate::format::CHANNELS;
use crate::pose::Pose;
use crate::rotation::{product, quaternion};
use crate::skeleton::{JOINTS, Joint};
use glam::{Quat, Vec3};

/// Entries of each axis in a row of coefficients: the joints and the root.
const LANES: usize = CHANNELS / 3;

/// A loop's coefficients unpacked in RAM: 240 bytes for each coefficient of its longest channel in
/// the caller's buffer (5 kB at 10 harmonics) and 650 bytes here. Coefficients of all channels are
/// adjacent, so that compilers vectorise over joints.
#[derive(Clone, Debug)]
pub struct Expanded<'b> {
    coefficients: &'b [f32],
    left: [[f32; LANES]; 4],
    right: [[f32; LANES]; 4],
}

impl<'b> Expanded<'b> {
    /// Returns the buffer length for this many coefficients a channel.
    pub(super) const fn len_for(coefficients: usize) -> usize {
        coefficients * CHANNELS
    }

    /// Returns where a coefficient lies: by index, then axis, then joint.
    pub(super) const fn slot(channel: usize, index: usize) -> usize {
        index * CHANNELS + channel % 3 * LANES + channel / 3
    }

    pub(super) fn new(coefficients: &'b [f32], codebook: &Codebook<'_>) -> Self {
        let mut expanded = Self {
            coefficients,
            left: [[0.0; LANES]; 4],
            right: [[0.0; LANES]; 4],
        };
        for joint in Joint::ALL {
            let frame = codebook.frame(joint);
            for component in 0..4 {
                expanded.left[component][joint.index()] = frame.left[component];
                expanded.right[component][joint.index()] = frame.right[component];
            }
        }
        expanded
    }

    /// Returns the pose at `phase`, bit for bit equal to [`super::Loop::pose`].
    #[must_use]
    pub fn pose(&self, phase: f32) -> Pose {
        let (rows, _) = self.coefficients.as_chunks::<CHANNELS>();
        let basis = Basis::up_to(phase, rows.len() / 2);
        let mut sums = [0.0f32; CHANNELS];
        // No row uses the constant's second value.
        let (&[first, _], values) = (&basis.pairs[0], basis.pairs[1..].as_flattened());
        let values = core::iter::once(first).chain(values.iter().copied());
        for (row, value) in rows.iter().zip(values) {
            for (sum, coefficient) in sums.iter_mut().zip(row) {
                *sum += coefficient * value;
            }
        }
        let (axes, _) = sums.as_chunks::<LANES>();
        let &[x, y, z] = axes else {
            return Pose::REST;
        };
        let mut turned = [[0.0f32; LANES]; 4];
        for lane in 0..LANES {
            let of = |parts: &[[f32; LANES]; 4]| {
                [
                    parts[0][lane],
                    parts[1][lane],
                    parts[2][lane],
                    parts[3][lane],
                ]
            };
            let own = quaternion([x[lane], y[lane], z[lane]]);
            let [a, b, c, d] = product(product(of(&self.left), own), of(&self.right));
            turned[0][lane] = a;
            turned[1][lane] = b;
            turned[2][lane] = c;
            turned[3][lane] = d;
        }
        let mut pose = Pose::REST;
        let [a, b, c, d] = &turned;
        for (joint, rotation) in pose.rotations.iter_mut().enumerate() {
            *rotation = Quat::from_xyzw(a[joint], b[joint], c[joint], d[joint]);
        }
        pose.root = Vec3::new(x[JOINTS], y[JOINTS], z[JOINTS]);
        pose
    }
}
