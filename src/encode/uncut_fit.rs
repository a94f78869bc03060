//! Fits of an uncut motion's channels with knots of one interval, and their decoded errors.

use super::knots::{KnotChannel, write};
use super::spline::{Factor, KnotGrid};
use super::target::hundredths;
use super::uncut_target::{EncodedClip, Encoder, Errors};
use edgegait_core::format::{
    CLIP_UNCUT, MAX_INTEGER_WIDTH, SPACING_CONSTANT, UNCUT_CHANNELS, UNCUT_HEADER_BYTES,
};
use edgegait_core::skeleton::{JOINTS, Joint};
use glam::{DQuat, DVec3, Quat};

/// The number of fits after the first for one scale, each with new weights. Our choice: CMU
/// recordings need 5 to 11 % fewer bytes than without; twice as many fits save 1 to 2 % more.
const REWEIGHTINGS: usize = 4;
/// The ratio of the error to the stated one above which weights do not help.
const HOPELESS: f64 = 1.8;
/// The share of the stated error from which on a moment gets more weight.
const HEAVY: f64 = 0.5;
/// The largest root mean square error of knots further apart with which they are used, in steps.
const MISSED_STEPS: f64 = 0.35;
/// The largest error of a constant with which a channel becomes constant, in steps.
const STILL_STEPS: f64 = 1.0;
/// The minimum component w of a quaternion up to which rotations are followed beyond half a turn:
/// 280 degrees. At 360 degrees their vectors are infinite.
const FURTHEST_W: f64 = -0.766;

/// Fits with knots of one interval.
pub(super) struct Fits<'a> {
    encoder: &'a Encoder<'a>,
    interval_us: u32,
    /// The grids for knots 1, 2 and 4 intervals apart.
    grids: [KnotGrid; SPACING_CONSTANT as usize],
    /// The weights of the last fit that was good enough, 1 on average.
    pub(super) weights: Weights,
}

/// The weights by joint and frame.
type Weights = [Vec<f64>; JOINTS];

impl<'a> Fits<'a> {
    pub(super) fn new(encoder: &'a Encoder<'a>, interval_us: u32) -> Self {
        let intervals = encoder.duration_us.div_ceil(u64::from(interval_us)).max(1);
        let grid = |spacing: u32| {
            #[expect(clippy::cast_precision_loss, reason = "exact up to 2^53 microseconds")]
            let positions = (0..encoder.len()).map(|frame| {
                let at_us = frame as f64 / encoder.span.sample_rate_hz * 1e6;
                let interval_us = f64::from(interval_us) * f64::from(1 << spacing);
                at_us.min(encoder.duration_us as f64) / interval_us
            });
            let intervals = intervals.div_ceil(1 << spacing);
            KnotGrid::new(positions, u32::try_from(intervals).unwrap_or(u32::MAX))
        };
        Self {
            encoder,
            interval_us,
            grids: [grid(0), grid(1), grid(2)],
            weights: std::array::from_fn(|_| vec![1.0; encoder.len()]),
        }
    }

    /// Returns an encoding of this scale that is good enough, if one is found.
    pub(super) fn good(&mut self, scale: u8, max_error_mm: f64) -> Option<EncodedClip> {
        let mut weights = self.weights.clone();
        for _ in 0..=REWEIGHTINGS {
            let (found, errors) = self.encode(scale, &weights)?;
            if found.max_error_mm <= max_error_mm {
                self.weights = weights;
                return Some(found);
            }
            if found.max_error_mm > HOPELESS * max_error_mm {
                break;
            }
            reweigh(&mut weights, &errors, max_error_mm);
        }
        None
    }

    /// Encodes and measures. Returns `None` if the format does not hold a knot.
    pub(super) fn encode(&self, scale: u8, weights: &Weights) -> Option<(EncodedClip, Errors)> {
        let body = write(&self.channels(scale, weights)?)?;
        let mut bytes = Vec::with_capacity(UNCUT_HEADER_BYTES + body.len());
        bytes.extend([CLIP_UNCUT, scale]);
        bytes.extend(self.encoder.duration_us.to_le_bytes());
        bytes.extend(self.interval_us.to_le_bytes());
        bytes.extend([0; 4]);
        bytes.extend(u32::try_from(self.encoder.len()).ok()?.to_le_bytes());
        bytes.extend(body);
        let (max_error_mm, mean_error_mm, errors) = self.encoder.measure(&bytes)?;
        bytes[14..16].copy_from_slice(&hundredths(max_error_mm).to_le_bytes());
        bytes[16..18].copy_from_slice(&hundredths(mean_error_mm).to_le_bytes());
        let found = EncodedClip {
            bytes,
            max_error_mm,
        };
        Some((found, errors))
    }

    /// Returns all channels in the format's order, fitted parents first.
    fn channels(&self, scale: u8, weights: &Weights) -> Option<Vec<KnotChannel>> {
        let (encoder, codebook) = (self.encoder, self.encoder.codebook);
        let pelvis = ChannelFits::new(self, &weights[0]);
        let (heading, looks) =
            pelvis.channel(&encoder.heading, codebook.heading_step(scale).into())?;
        let mut channels = Vec::with_capacity(UNCUT_CHANNELS);
        let mut decoded: Vec<[DQuat; JOINTS]> = vec![[DQuat::IDENTITY; JOINTS]; encoder.len()];
        for joint in Joint::ALL {
            let index = joint.index();
            let fit = ChannelFits::new(self, &weights[index]);
            let (left, right) = codebook.frame_rotations(joint);
            let (left, right) = (unit(left), unit(right));
            let carrier = |frame: usize, decoded: &[[DQuat; JOINTS]]| match joint.parent() {
                Some(parent) => decoded[frame][parent.index()],
                None => DQuat::from_rotation_y(looks[frame]),
            };
            let aims = encoder.orientations.iter().enumerate().map(|(frame, aim)| {
                let local = carrier(frame, &decoded).inverse() * aim[index];
                left.inverse() * local * right.inverse()
            });
            let axes = followed(aims);
            let mut vectors = vec![DVec3::ZERO; encoder.len()];
            for (axis, values) in axes.iter().enumerate() {
                let step = codebook.step(3 * index + axis, scale).into();
                let (channel, values) = fit.channel(values, step)?;
                channels.push(channel);
                for (vector, value) in vectors.iter_mut().zip(values) {
                    vector[axis] = value;
                }
            }
            for (frame, vector) in vectors.into_iter().enumerate() {
                let turned = carrier(frame, &decoded) * (left * turn(vector) * right);
                decoded[frame][index] = turned.normalize();
            }
        }
        for axis in 0..3 {
            let values: Vec<f64> = encoder.span.roots.iter().map(|root| root[axis]).collect();
            let step = codebook.step(3 * JOINTS + axis, scale).into();
            channels.push(pelvis.channel(&values, step)?.0);
        }
        channels.push(heading);
        Some(channels)
    }
}

/// The fits of one joint's channels.
struct ChannelFits<'a> {
    grids: &'a [KnotGrid],
    weights: &'a [f64],
    factors: Vec<Factor>,
}

impl<'a> ChannelFits<'a> {
    fn new(fits: &'a Fits<'_>, weights: &'a [f64]) -> Self {
        Self {
            grids: &fits.grids,
            weights,
            factors: fits.grids.iter().map(|grid| grid.factor(weights)).collect(),
        }
    }

    /// Returns the channel of these values in steps, and its decoded values, or `None` if a knot is
    /// wider than 25 bits.
    fn channel(&self, values: &[f64], step: f64) -> Option<(KnotChannel, Vec<f64>)> {
        let (least, most) = values
            .iter()
            .fold((f64::MAX, f64::MIN), |(least, most), &value| {
                (least.min(value), most.max(value))
            });
        let middle = (0.5 * (least + most) / step).round();
        if (most - middle * step).max(middle * step - least) <= STILL_STEPS * step {
            let channel = KnotChannel {
                spacing: SPACING_CONSTANT,
                knots: vec![whole(middle)?],
            };
            return Some((channel, vec![middle * step; values.len()]));
        }
        let mut spacing = 0;
        for wider in (1..self.grids.len()).rev() {
            if self.missed(wider, values) <= MISSED_STEPS * step {
                spacing = wider;
                break;
            }
        }
        let (grid, factor) = (&self.grids[spacing], &self.factors[spacing]);
        let knots = grid.fit(factor, self.weights, values, Some(step));
        let decoded = grid.values(&knots).collect();
        let channel = KnotChannel {
            spacing: u32::try_from(spacing).ok()?,
            knots: knots
                .iter()
                .map(|knot| whole((knot / step).round()))
                .collect::<Option<_>>()?,
        };
        Some((channel, decoded))
    }

    /// Returns the root mean square error of unrounded knots of this spacing.
    fn missed(&self, spacing: usize, values: &[f64]) -> f64 {
        let (grid, factor) = (&self.grids[spacing], &self.factors[spacing]);
        let knots = grid.fit(factor, self.weights, values, None);
        let missed = grid.values(&knots).zip(values).zip(self.weights);
        let sum: f64 = missed
            .map(|((found, value), weight)| weight * (found - value) * (found - value))
            .sum();
        (sum / values.len() as f64).sqrt()
    }
}

/// Adds weight where a joint, or a joint of its subtree, has a large error (after Lawson 1961, who
/// multiplies weights by errors until the greatest error is least; small errors are ignored here).
fn reweigh(weights: &mut Weights, errors: &Errors, max_error_mm: f64) {
    for (frame, errors) in errors.iter().enumerate() {
        let mut worst = *errors;
        for joint in Joint::ALL.into_iter().rev() {
            if let Some(parent) = joint.parent() {
                worst[parent.index()] = worst[parent.index()].max(worst[joint.index()]);
            }
        }
        for (weights, worst) in weights.iter_mut().zip(worst) {
            weights[frame] *= (worst / (HEAVY * max_error_mm)).max(1.0);
        }
    }
    for weights in weights {
        let mean = weights.iter().sum::<f64>() / weights.len() as f64;
        for weight in weights {
            *weight /= mean;
        }
    }
}

/// Returns the vectors of rotations by axis. Of the two vectors of a rotation, each is the one
/// nearer to the previous vector.
fn followed(rotations: impl Iterator<Item = DQuat>) -> [Vec<f64>; 3] {
    let mut axes: [Vec<f64>; 3] = Default::default();
    let mut last = DQuat::IDENTITY;
    for rotation in rotations {
        let mut nearest = if rotation.dot(last) < 0.0 {
            -rotation
        } else {
            rotation
        };
        if nearest.w < FURTHEST_W {
            nearest = -nearest;
        }
        last = nearest;
        let scale = 4.0 / (1.0 + nearest.w);
        for (axis, component) in axes.iter_mut().zip([nearest.x, nearest.y, nearest.z]) {
            axis.push(component * scale);
        }
    }
    axes
}

/// Returns the rotation of a vector `4 tan(a/4) n`, as `edgegait_core::rotation` but in `f64`.
fn turn(vector: DVec3) -> DQuat {
    let quarter = 0.25 * vector;
    let scale = 1.0 / (1.0 + quarter.length_squared());
    let axis = quarter * (2.0 * scale);
    DQuat::from_xyzw(axis.x, axis.y, axis.z, 2.0 * scale - 1.0)
}

fn unit(rotation: Quat) -> DQuat {
    rotation.as_dquat().normalize()
}

/// Returns a whole number of steps, if it has at most 25 bits.
fn whole(steps: f64) -> Option<i32> {
    const WIDEST: f64 = (1 << (MAX_INTEGER_WIDTH - 1)) as f64;
    #[expect(clippy::cast_possible_truncation, reason = "checked: 25 bits")]
    (steps.abs() < WIDEST).then_some(steps as i32)
}
