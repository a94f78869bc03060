//! The codebook's joint frames: the reference rotation and the axes of each joint's motion.

use edgegait_core::format::{CHANNELS, FRAME_STEP, step_size};
use edgegait_core::skeleton::{JOINTS, Joint};
use glam::{DMat3, DQuat, DVec3};

/// The distance of virtual points from their joint, metres. Errors are measured at these points:
/// 3 cm, as in the Animation Compression Library (ACL; Frechette 2017).
pub(super) const VIRTUAL_POINT_M: f64 = 0.03;
/// The number of virtual points of a joint, in both directions of its three axes. ACL has one on
/// each axis. With those alone, the error of the joint itself and of points on its other side
/// exceeds the stated one: 8 mm at "5 mm", measured on CMU's walks.
pub(super) const VIRTUAL_POINTS: usize = 6;

/// The cosine of half the largest angle of a track from its reference: 300 degrees. Our choice;
/// vectors grow without bound towards a full turn.
const FARTHEST: f64 = -0.866;

/// How much finer steps become, in octaves, for each doubling of the number of joints that a joint
/// moves. Measured on CMU's walks: 2 to 4 % fewer bytes than with 0.
const SHARED: f64 = 0.16;

/// The references, bases and step offsets, as the decoder reads them.
#[derive(Clone, Debug)]
pub(super) struct Frames {
    references: [[i16; 3]; JOINTS],
    bases: [[i16; 3]; JOINTS],
    steps: [u8; CHANNELS],
    left: [DQuat; JOINTS],
    right: [DQuat; JOINTS],
}

impl Frames {
    /// Creates frames from the codebook's numbers.
    pub(super) fn new(
        references: [[i16; 3]; JOINTS],
        bases: [[i16; 3]; JOINTS],
        steps: [u8; CHANNELS],
    ) -> Self {
        let bases_of = bases.map(decoded);
        Self {
            left: std::array::from_fn(|joint| decoded(references[joint]) * bases_of[joint]),
            right: bases_of.map(DQuat::inverse),
            references,
            bases,
            steps,
        }
    }

    /// Fits frames to motions, given as local rotations by frame, of people with these mean joint
    /// offsets.
    pub(super) fn fit(motions: &[&[[DQuat; JOINTS]]], offsets: &[DVec3; JOINTS]) -> Self {
        let mut references = [[0; 3]; JOINTS];
        let mut bases = [[0; 3]; JOINTS];
        for joint in 0..JOINTS {
            let means: Vec<DQuat> = motions
                .iter()
                .map(|motion| mean_rotation(motion.iter().map(|frame| frame[joint])))
                .collect();
            let (reference, stored) = rounded(mean_rotation(means.iter().copied()));
            references[joint] = stored;
            let mut spread = [[0.0; 3]; 3];
            for motion in motions {
                scatter(
                    &mut spread,
                    motion.iter().map(|frame| frame[joint]),
                    reference,
                );
            }
            let (_, stored) = rounded(DQuat::from_mat3(&principal_axes(spread)));
            bases[joint] = stored;
        }
        let mut frames = Self::new(references, bases, [0; CHANNELS]);
        frames.steps = steps(&frames, offsets);
        frames
    }

    /// Returns the vectors, in a joint's basis, of its local rotations through a cycle. The first
    /// is at most half a turn, and the others follow without a jump. Returns `None` if they do not
    /// close, because the joint turns full circle or comes near a full turn from its reference.
    pub(super) fn vectors(
        &self,
        joint: usize,
        locals: impl Iterator<Item = DQuat>,
    ) -> Option<Vec<DVec3>> {
        let (left, right) = (self.left[joint].inverse(), self.right[joint].inverse());
        let mut before: Option<DQuat> = None;
        let mut first = DQuat::IDENTITY;
        let mut vectors = Vec::new();
        for local in locals {
            let own = left * local * right;
            let sign = before.map_or(own.w, |before| before.dot(own));
            let own = if sign < 0.0 { -own } else { own }.normalize();
            if before.replace(own).is_none() {
                first = own;
            }
            if own.w < FARTHEST {
                return None;
            }
            vectors.push(own.xyz() * (4.0 / (1.0 + own.w)));
        }
        before
            .is_none_or(|last| last.dot(first) >= 0.0)
            .then_some(vectors)
    }

    /// Returns the joint's local rotation for a vector in its basis.
    pub(super) fn rotation(&self, joint: usize, vector: DVec3) -> DQuat {
        self.left[joint] * rotation_of(vector) * self.right[joint]
    }

    /// Returns an axis of the joint's basis, in its parent's frame at the reference.
    pub(super) fn axis(&self, joint: usize, axis: usize) -> DVec3 {
        self.left[joint] * DVec3::AXES[axis]
    }

    /// Returns the step of a channel's numbers in a clip of this scale.
    pub(super) fn step(&self, channel: usize, scale: u8) -> f64 {
        f64::from(step_size(scale.saturating_add(self.steps[channel])))
    }

    /// Returns references, bases and step offsets.
    #[cfg(test)]
    pub(super) const fn numbers(
        &self,
    ) -> (&[[i16; 3]; JOINTS], &[[i16; 3]; JOINTS], &[u8; CHANNELS]) {
        (&self.references, &self.bases, &self.steps)
    }

    /// Returns the beginning of a codebook: references and bases, then step offsets.
    pub(super) fn to_bytes(&self) -> Vec<u8> {
        let rotations = self.references.iter().zip(&self.bases);
        let numbers = rotations.flat_map(|(reference, basis)| [*reference, *basis].concat());
        numbers
            .flat_map(i16::to_le_bytes)
            .chain(self.steps)
            .collect()
    }
}

/// Returns the decoder's rotation for a vector ([`edgegait_core::rotation`]), in f64.
pub(super) fn rotation_of(vector: DVec3) -> DQuat {
    let quarter = 0.25 * vector;
    let square = quarter.length_squared();
    let part = 2.0 / (1.0 + square) * quarter;
    DQuat::from_xyzw(part.x, part.y, part.z, (1.0 - square) / (1.0 + square))
}

/// Returns the vector of a rotation, by at most half a turn.
fn vector_of(rotation: DQuat) -> DVec3 {
    let shortest = if rotation.w < 0.0 {
        -rotation
    } else {
        rotation
    };
    let shortest = shortest.normalize();
    shortest.xyz() * (4.0 / (1.0 + shortest.w))
}

/// Returns a rotation as the codebook holds it, and its numbers.
fn rounded(rotation: DQuat) -> (DQuat, [i16; 3]) {
    let step = f64::from(FRAME_STEP);
    // At most 4 / step = 32,767: half a turn.
    #[expect(clippy::cast_possible_truncation, reason = "clamped")]
    let numbers = (vector_of(rotation) / step)
        .to_array()
        .map(|number| number.round().clamp(-32_767.0, 32_767.0) as i16);
    (decoded(numbers), numbers)
}

/// Returns the rotation for the codebook's numbers.
fn decoded(numbers: [i16; 3]) -> DQuat {
    rotation_of(DVec3::from_array(numbers.map(f64::from)) * f64::from(FRAME_STEP))
}

/// Returns the normalised sum of rotations, each in the first one's hemisphere.
fn mean_rotation(mut rotations: impl Iterator<Item = DQuat>) -> DQuat {
    let Some(first) = rotations.next() else {
        return DQuat::IDENTITY;
    };
    let sum = rotations.fold(first, |sum, rotation| {
        if first.dot(rotation) < 0.0 {
            sum - rotation
        } else {
            sum + rotation
        }
    });
    if sum.length_squared() < 1e-12 {
        return first;
    }
    sum.normalize()
}

/// Adds the scatter of rotation vectors about their own mean.
fn scatter(
    spread: &mut [[f64; 3]; 3],
    rotations: impl ExactSizeIterator<Item = DQuat>,
    reference: DQuat,
) {
    #[expect(clippy::cast_precision_loss, reason = "frames")]
    let count = rotations.len().max(1) as f64;
    let inverse = reference.inverse();
    let vectors: Vec<DVec3> = rotations
        .map(|rotation| vector_of(inverse * rotation))
        .collect();
    let mean = vectors.iter().sum::<DVec3>() / count;
    for vector in vectors {
        let off = (vector - mean).to_array();
        for (row, a) in spread.iter_mut().zip(off) {
            for (cell, b) in row.iter_mut().zip(off) {
                *cell += a * b / count;
            }
        }
    }
}

/// Returns the eigenvectors of a symmetric matrix as a rotation, largest eigenvalue first, by
/// cyclic Jacobi (Golub and Van Loan 2013, section 8.5). Plain arithmetic makes packs identical on
/// every host.
fn principal_axes(mut a: [[f64; 3]; 3]) -> DMat3 {
    let mut axes = DMat3::IDENTITY.to_cols_array_2d();
    for _ in 0..30 {
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            if a[p][q].abs() < 1e-30 {
                continue;
            }
            let slope = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
            let tangent = slope.signum() / (slope.abs() + (slope * slope + 1.0).sqrt());
            let cos = 1.0 / (tangent * tangent + 1.0).sqrt();
            let sin = tangent * cos;
            for row in &mut a {
                (row[p], row[q]) = (cos * row[p] - sin * row[q], sin * row[p] + cos * row[q]);
            }
            for rows in [&mut a, &mut axes] {
                let (x, y) = (rows[p], rows[q]);
                rows[p] = std::array::from_fn(|i| cos * x[i] - sin * y[i]);
                rows[q] = std::array::from_fn(|i| sin * x[i] + cos * y[i]);
            }
        }
    }
    let mut order = [0, 1, 2];
    order.sort_by(|&i, &j| a[j][j].total_cmp(&a[i][i]));
    let [x, y, z] = order.map(|axis| DVec3::from_array(axes[axis]));
    let handed = if x.cross(y).dot(z) < 0.0 { -z } else { z };
    DMat3::from_cols(x, y, handed)
}

/// Returns how much coarser each channel's step is than the finest, in eighths of an octave. A
/// change by one step moves the points of any joint's subtree by about the same distance, and by
/// less if the joint moves more joints ([`SHARED`]).
fn steps(frames: &Frames, offsets: &[DVec3; JOINTS]) -> [u8; CHANNELS] {
    // The root's steps are metres, as of a joint with a lever of one metre.
    let mut levers = [1.0; CHANNELS];
    let mut moves = [JOINTS; CHANNELS];
    for joint in Joint::ALL {
        let children = || {
            Joint::ALL
                .iter()
                .filter(|child| child.parent() == Some(joint))
        };
        for axis in 0..3 {
            let channel = 3 * joint.index() + axis;
            let turned = frames.right[joint.index()].inverse() * DVec3::AXES[axis];
            levers[channel] = children()
                .map(|child| turned.cross(offsets[child.index()]).length())
                .fold(VIRTUAL_POINT_M, f64::max);
            moves[channel] = hanging_on(joint.index()).len();
        }
    }
    #[expect(clippy::cast_precision_loss, reason = "at most 19 joints")]
    let fineness: [f64; CHANNELS] = std::array::from_fn(|channel| {
        8.0 * (libm::log2(levers[channel]) + SHARED * libm::log2(moves[channel] as f64))
    });
    let finest = fineness.iter().copied().fold(f64::MIN, f64::max);
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "clamped; levers are 3 cm to a metre"
    )]
    fineness.map(|own| (finest - own).round().clamp(0.0, 255.0) as u8)
}

/// Returns a joint's subtree, the joint itself included, parents first.
pub(super) fn hanging_on(joint: usize) -> Vec<usize> {
    let mut hangs = [false; JOINTS];
    hangs[joint] = true;
    for below in Joint::ALL {
        if below.parent().is_some_and(|parent| hangs[parent.index()]) {
            hangs[below.index()] = true;
        }
    }
    (0..JOINTS).filter(|&below| hangs[below]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_hinge_moves_along_its_first_axis() {
        let hinge = DVec3::new(0.6, 0.0, 0.8);
        let knee = Joint::LeftShank.index();
        let motion: Vec<[DQuat; JOINTS]> = (0..40)
            .map(|frame| {
                let mut pose = [DQuat::IDENTITY; JOINTS];
                let angle = 0.5 + 0.4 * (f64::from(frame) * 0.3).sin();
                pose[knee] = DQuat::from_axis_angle(hinge, angle);
                pose
            })
            .collect();
        let frames = Frames::fit(&[&motion], &[DVec3::NEG_Y; JOINTS]);
        let locals = motion.iter().map(|pose| pose[knee]);
        let vectors = frames.vectors(knee, locals).expect("a short way");
        for (pose, vector) in motion.iter().zip(vectors) {
            assert!(vector.y.hypot(vector.z) < 2e-3, "{vector}");
            let back = frames.rotation(knee, vector);
            assert!(back.angle_between(pose[knee]) < 1e-7);
        }
    }

    #[test]
    fn tracks_go_through_half_a_turn_but_not_full_circle() {
        let rest = [[DQuat::IDENTITY; JOINTS]];
        let frames = Frames::fit(&[&rest], &[DVec3::NEG_Y; JOINTS]);
        // There and back, 100 to 260 degrees from the reference, with either sign.
        let turn = |frame: i32| {
            DQuat::from_rotation_z((180.0 + 80.0 * (f64::from(frame) * 0.2).sin()).to_radians())
        };
        let there = (0..31).map(|frame| {
            if frame % 3 == 0 {
                turn(frame)
            } else {
                -turn(frame)
            }
        });
        let vectors = frames.vectors(4, there).expect("it comes back");
        for pair in vectors.windows(2) {
            assert!(pair[0].distance(pair[1]) < 2.0, "{pair:?}");
        }
        let circle =
            (0..36).map(|frame| DQuat::from_rotation_z(f64::from(frame).to_radians() * 10.0));
        assert!(frames.vectors(4, circle).is_none());
    }

    #[test]
    fn opposite_quaternions_are_one_rotation() {
        let turn = DQuat::from_rotation_y(1.0);
        let mean = mean_rotation([turn, -turn, turn].into_iter());
        assert!(mean.angle_between(turn) < 1e-9);
        assert!((vector_of(turn) - vector_of(-turn)).length() < 1e-12);
    }
}
