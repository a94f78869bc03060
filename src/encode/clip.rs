//! Gait cycles as Fourier coefficients: from a stated error to bytes.
//!
//! Joints are encoded parents first, in a closed loop: a child aims at its true
//! orientation in the walker's space given its *decoded* parent, so that errors do
//! not add up down a limb. Steps are searched, not derived: the coarsest ones
//! whose measured error is within the stated one.

use super::bits::{BitWriter, signed_width};
use crate::error::{Error, Result};
use crate::scene::{Cycle, forward_kinematics};
use edgegait_core::budget::{MAX_COEFFICIENTS, MAX_HARMONICS};
use edgegait_core::clip::Clip;
use edgegait_core::format::{
    CLIP_HEADER_BYTES, CLIP_LOOP, COUNT_BITS, REFERENCE_BITS, STEP_BITS, WIDTH_BITS, band_length,
    step_size,
};
use edgegait_core::pose::{ModelPose, Pose};
use edgegait_core::skeleton::{JOINTS, Joint, Skeleton};
use glam::{DQuat, DVec3, Vec3};
use std::f64::consts::TAU;

/// Distance of the virtual points from their joint at which errors are measured,
/// metres: 3 cm, as the Animation Compression Library does (Frechette 2017).
const VIRTUAL_POINT_M: f64 = 0.03;
/// Least number of frames that a cycle needs: two for each harmonic that it may hold.
const MIN_FRAMES: usize = 8;
/// Coarsest step index of the format.
const MAX_STEP: u32 = (1 << STEP_BITS) - 1;
/// Widest coefficient of the format.
const MAX_WIDTH: u32 = (1 << WIDTH_BITS) - 1;

/// A clip's bytes and what its encoding cost.
#[derive(Clone, Debug)]
pub struct EncodedClip {
    /// What [`Clip::parse`] reads.
    pub bytes: Vec<u8>,
    /// Greatest error, mm, over virtual points, joints and frames.
    pub max_error_mm: f64,
    /// Mean of the same, mm.
    pub mean_error_mm: f64,
}

/// Encodes one cycle so that no virtual point is off by more than `max_error_mm`.
/// When the format cannot reach that, the finest encoding is returned; its
/// [`EncodedClip::max_error_mm`] tells.
///
/// # Errors
/// For a cycle with fewer than 8 frames, with numbers that are not finite, or with
/// a travel or period that the format does not hold.
pub fn encode_cycle(cycle: &Cycle, skeleton: &Skeleton, max_error_mm: f64) -> Result<EncodedClip> {
    check(cycle)?;
    let truth = Truth::new(cycle, skeleton);
    let basis = Basis::new(cycle.root.len());
    let levers = levers(skeleton);
    let encode = |steps: &[u32; JOINTS + 1]| Attempt::new(cycle, &truth, &basis, skeleton, steps);

    // One scale for all joints first: the coarsest that is good enough.
    let scaled = |index: u32| levers.map(|lever| index.saturating_sub(lever).min(MAX_STEP));
    let (mut low, mut high) = (0, 2 * MAX_STEP);
    while low < high {
        let middle = (low + high).div_ceil(2);
        let good = encode(&scaled(middle)).is_some_and(|a| a.max_error_mm <= max_error_mm);
        if good {
            low = middle;
        } else {
            high = middle - 1;
        }
    }
    let mut steps = scaled(low);
    let mut best = encode(&steps);
    // Then each joint alone, as coarse as the others allow.
    for joint in 0..steps.len() {
        while steps[joint] < MAX_STEP {
            steps[joint] += 1;
            match encode(&steps) {
                Some(attempt)
                    if attempt.max_error_mm <= max_error_mm
                        && best
                            .as_ref()
                            .is_none_or(|b| attempt.bytes.len() <= b.bytes.len()) =>
                {
                    best = Some(attempt);
                }
                _ => {
                    steps[joint] -= 1;
                    break;
                }
            }
        }
    }
    let Some(best) = best else {
        return Err(Error::Failed(
            "a cycle whose rotations do not fit the loop format".into(),
        ));
    };
    Ok(EncodedClip {
        bytes: best.bytes,
        max_error_mm: best.max_error_mm,
        mean_error_mm: best.mean_error_mm,
    })
}

fn check(cycle: &Cycle) -> Result<()> {
    let frames = cycle.root.len();
    if frames < MIN_FRAMES || cycle.rotations.len() != frames {
        return Err(Error::Failed(format!(
            "a gait cycle of {frames} frames: expected at least {MIN_FRAMES}"
        )));
    }
    let finite = cycle.root.iter().all(|root| root.is_finite())
        && cycle
            .rotations
            .iter()
            .flatten()
            .all(|rotation| rotation.is_normalized());
    if !finite {
        return Err(Error::Failed(
            "a gait cycle with numbers that are not finite, or rotations that are not unit quaternions".into(),
        ));
    }
    if !(1e-6..=4_000.0).contains(&cycle.period_s) || !(-2e3..=2e3).contains(&cycle.drift_m) {
        return Err(Error::Failed(format!(
            "a gait cycle of {} s and {} m: expected up to 4,000 s and 2,000 m",
            cycle.period_s, cycle.drift_m
        )));
    }
    Ok(())
}

/// How much finer than the root each joint's step is, in quarter octaves: the
/// longer the segment that a joint swings, the finer. The last entry is the root.
fn levers(skeleton: &Skeleton) -> [u32; JOINTS + 1] {
    let mut levers = [VIRTUAL_POINT_M; JOINTS + 1];
    for joint in Joint::ALL {
        if let Some(parent) = joint.parent() {
            let length = f64::from(skeleton.offsets[joint.index()].length());
            levers[parent.index()] = levers[parent.index()].max(length);
        }
    }
    levers[JOINTS] = 1.0;
    let finest = levers.iter().copied().fold(f64::MAX, f64::min);
    levers.map(|lever| {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "segments are at most tens of times as long as 3 cm"
        )]
        let quarters = (4.0 * (lever / finest).log2()).round() as u32;
        quarters
    })
}

/// Where a cycle really puts its joints.
struct Truth {
    /// Per frame, per joint: orientation in the walker's space.
    orientations: Vec<[DQuat; JOINTS]>,
    /// Per frame, per joint: its three virtual points, metres.
    points: Vec<[[DVec3; 3]; JOINTS]>,
}

impl Truth {
    fn new(cycle: &Cycle, skeleton: &Skeleton) -> Self {
        let mut truth = Self {
            orientations: Vec::with_capacity(cycle.root.len()),
            points: Vec::with_capacity(cycle.root.len()),
        };
        let offsets = skeleton.offsets.map(Vec3::as_dvec3);
        for (root, rotations) in cycle.root.iter().zip(&cycle.rotations) {
            let (positions, orientations) = forward_kinematics(&offsets, *root, rotations);
            truth.points.push(std::array::from_fn(|joint| {
                DVec3::AXES
                    .map(|axis| positions[joint] + orientations[joint] * (axis * VIRTUAL_POINT_M))
            }));
            truth.orientations.push(orientations);
        }
        truth
    }
}

/// One trial encoding and its measured error.
struct Attempt {
    bytes: Vec<u8>,
    max_error_mm: f64,
    mean_error_mm: f64,
}

impl Attempt {
    /// Encodes with these step indices, coarser ones where a coefficient is too wide;
    /// `None` where even the coarsest do not hold it.
    fn new(
        cycle: &Cycle,
        truth: &Truth,
        basis: &Basis,
        skeleton: &Skeleton,
        steps: &[u32; JOINTS + 1],
    ) -> Option<Self> {
        let frames = cycle.root.len();
        let mut bits = BitWriter::default();
        let mut decoded = vec![[DQuat::IDENTITY; JOINTS]; frames];
        for joint in Joint::ALL {
            let index = joint.index();
            let targets: Vec<DQuat> = (0..frames)
                .map(|frame| {
                    let aim = truth.orientations[frame][index];
                    match joint.parent() {
                        Some(parent) => decoded[frame][parent.index()].inverse() * aim,
                        None => aim,
                    }
                })
                .collect();
            let reference = write_reference(&mut bits, mean_rotation(&targets));
            let vectors: Vec<DVec3> = targets
                .iter()
                .map(|target| rotation_vector(reference.inverse() * *target))
                .collect();
            let quantised = write_finest(&mut bits, basis, &vectors, steps[index])?;
            for (frame, vector) in quantised.into_iter().enumerate() {
                let local = reference * DQuat::from_scaled_axis(vector);
                decoded[frame][index] = match joint.parent() {
                    Some(parent) => decoded[frame][parent.index()] * local,
                    None => local,
                };
            }
        }
        write_finest(&mut bits, basis, &cycle.root, steps[JOINTS])?;
        let mut bytes = header(cycle);
        let stream = bits.into_bytes();
        let length = u16::try_from(stream.len()).ok()?;
        bytes[14..16].copy_from_slice(&length.to_le_bytes());
        bytes.extend(stream);

        let clip = Clip::parse(&bytes).ok()?;
        let (max, mean) = measure(&clip, skeleton, truth);
        bytes[10..12].copy_from_slice(&hundredths(max).to_le_bytes());
        bytes[12..14].copy_from_slice(&hundredths(mean).to_le_bytes());
        Some(Self {
            bytes,
            max_error_mm: max,
            mean_error_mm: mean,
        })
    }
}

/// A clip's header without errors and stream length.
fn header(cycle: &Cycle) -> Vec<u8> {
    let mut bytes = vec![0; CLIP_HEADER_BYTES];
    bytes[0] = CLIP_LOOP;
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "checked: up to 4,000 s and 2,000 m"
    )]
    {
        let period = (cycle.period_s * 1e6).round() as u32;
        let drift = (cycle.drift_m * 1e6).round() as i32;
        bytes[2..6].copy_from_slice(&period.to_le_bytes());
        bytes[6..10].copy_from_slice(&drift.to_le_bytes());
    }
    bytes
}

/// An error in units of 0.01 mm, rounded up so that it is never understated.
fn hundredths(error_mm: f64) -> u16 {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "clamped"
    )]
    let hundredths = (error_mm * 100.0).ceil().clamp(0.0, 65_535.0) as u16;
    hundredths
}

/// Greatest and mean distance, mm, of the decoded virtual points from the true ones.
fn measure(clip: &Clip<'_>, skeleton: &Skeleton, truth: &Truth) -> (f64, f64) {
    let frames = truth.points.len();
    let (mut max, mut sum) = (0.0f64, 0.0f64);
    for (frame, joints) in truth.points.iter().enumerate() {
        #[expect(
            clippy::cast_precision_loss,
            clippy::cast_possible_truncation,
            reason = "the decoder takes f32"
        )]
        let pose: Pose = clip.pose((frame as f64 / frames as f64) as f32);
        let model = ModelPose::new(skeleton, &pose);
        for (joint, points) in joints.iter().enumerate() {
            for (axis, point) in points.iter().enumerate() {
                #[expect(clippy::cast_possible_truncation, reason = "3 cm")]
                let arm = Vec3::AXES[axis] * VIRTUAL_POINT_M as f32;
                let found = model.positions[joint] + model.orientations[joint] * arm;
                let error = point.distance(found.as_dvec3()) * 1e3;
                max = max.max(error);
                sum += error;
            }
        }
    }
    #[expect(clippy::cast_precision_loss, reason = "thousands of points")]
    let mean = sum / (frames * JOINTS * 3) as f64;
    (max, mean)
}

/// The normalised sum of rotations, each in the first one's hemisphere.
fn mean_rotation(rotations: &[DQuat]) -> DQuat {
    let first = rotations.first().copied().unwrap_or(DQuat::IDENTITY);
    let sum = rotations
        .iter()
        .fold(DQuat::from_xyzw(0.0, 0.0, 0.0, 0.0), |sum, &q| {
            if first.dot(q) < 0.0 { sum - q } else { sum + q }
        });
    if sum.length_squared() < 1e-12 {
        return first;
    }
    sum.normalize()
}

/// The rotation vector of a rotation by at most half a turn.
fn rotation_vector(rotation: DQuat) -> DVec3 {
    let shortest = if rotation.w < 0.0 {
        -rotation
    } else {
        rotation
    };
    shortest.normalize().to_scaled_axis()
}

/// Writes a rotation as its three smallest components; what the decoder reads.
fn write_reference(bits: &mut BitWriter, rotation: DQuat) -> DQuat {
    let limit = std::f64::consts::FRAC_1_SQRT_2;
    let scale = limit / f64::from((1 << (REFERENCE_BITS - 1)) - 1);
    let mut components = rotation.to_array();
    let mut largest = 0;
    for (index, component) in components.iter().enumerate() {
        if component.abs() > components[largest].abs() {
            largest = index;
        }
    }
    let sign = if components[largest] < 0.0 { -1.0 } else { 1.0 };
    #[expect(clippy::cast_possible_truncation, reason = "an index below 4")]
    bits.unsigned(largest as u32, 2);
    let mut squares = 0.0;
    for (index, component) in components.iter_mut().enumerate() {
        if index != largest {
            #[expect(clippy::cast_possible_truncation, reason = "15 bits")]
            let steps = (*component * sign / scale).round() as i32;
            bits.signed(steps, REFERENCE_BITS);
            *component = f64::from(steps) * scale;
            squares += *component * *component;
        }
    }
    components[largest] = (1.0 - squares).max(0.0).sqrt();
    DQuat::from_array(components).normalize()
}

/// Writes three channels with the finest step from `step` on that holds all of their
/// coefficients: the height of a pelvis does not fit steps that suit a hand.
fn write_finest(
    bits: &mut BitWriter,
    basis: &Basis,
    vectors: &[DVec3],
    step: u32,
) -> Option<Vec<DVec3>> {
    (step..=MAX_STEP).find_map(|step| {
        let mut trial = bits.clone();
        let values = write_vector(&mut trial, basis, vectors, step)?;
        *bits = trial;
        Some(values)
    })
}

/// Writes three channels with one step; their values after quantisation, by frame.
fn write_vector(
    bits: &mut BitWriter,
    basis: &Basis,
    vectors: &[DVec3],
    step: u32,
) -> Option<Vec<DVec3>> {
    let mut decoded = vec![DVec3::ZERO; vectors.len()];
    for axis in 0..3 {
        let channel: Vec<f64> = vectors.iter().map(|vector| vector[axis]).collect();
        let values = write_channel(bits, basis, &channel, step)?;
        for (vector, value) in decoded.iter_mut().zip(values) {
            vector[axis] = value;
        }
    }
    Some(decoded)
}

/// Writes one channel; its values after quantisation. `None` where a coefficient
/// is wider than the format allows.
fn write_channel(
    bits: &mut BitWriter,
    basis: &Basis,
    values: &[f64],
    step: u32,
) -> Option<Vec<f64>> {
    let size = f64::from(step_size(step));
    let mut coefficients = Vec::with_capacity(MAX_COEFFICIENTS);
    for value in basis.analyse(values) {
        let steps = (value / size).round();
        if steps.abs() >= f64::from(1 << (MAX_WIDTH - 1)) {
            return None;
        }
        #[expect(clippy::cast_possible_truncation, reason = "checked: 15 bits")]
        coefficients.push(steps as i32);
    }
    while coefficients.last() == Some(&0) {
        coefficients.pop();
    }
    #[expect(clippy::cast_possible_truncation, reason = "at most 63")]
    bits.unsigned(coefficients.len() as u32, COUNT_BITS);
    if coefficients.is_empty() {
        return Some(vec![0.0; values.len()]);
    }
    bits.unsigned(step, STEP_BITS);
    let mut rest = coefficients.as_slice();
    for band in 0.. {
        if rest.is_empty() {
            break;
        }
        let (head, tail) = rest.split_at(band_length(band).min(rest.len()));
        let width = head.iter().copied().map(signed_width).max().unwrap_or(0);
        bits.unsigned(width, WIDTH_BITS);
        for &coefficient in head {
            bits.signed(coefficient, width);
        }
        rest = tail;
    }
    Some(basis.synthesise(&coefficients, size))
}

/// The Fourier basis at evenly spaced phases: one row for each coefficient.
struct Basis {
    rows: Vec<Vec<f64>>,
    frames: usize,
}

impl Basis {
    /// A constant, then cosine and sine of each harmonic below half the sampling rate, at
    /// most 31.
    fn new(frames: usize) -> Self {
        let harmonics = MAX_HARMONICS.min((frames - 1) / 2);
        let mut rows = vec![vec![1.0; frames]];
        for harmonic in 1..=harmonics {
            let waves: Vec<(f64, f64)> = (0..frames)
                .map(|frame| {
                    // The product is reduced first, in integers.
                    #[expect(clippy::cast_precision_loss, reason = "frames of a cycle")]
                    let turns = ((harmonic * frame) % frames) as f64 / frames as f64;
                    libm::sincos(TAU * turns)
                })
                .collect();
            rows.push(waves.iter().map(|(_, cos)| *cos).collect());
            rows.push(waves.iter().map(|(sin, _)| *sin).collect());
        }
        Self { rows, frames }
    }

    /// The coefficients of evenly spaced samples.
    fn analyse(&self, values: &[f64]) -> Vec<f64> {
        #[expect(clippy::cast_precision_loss, reason = "frames of a cycle")]
        let count = self.frames as f64;
        let products = self.rows.iter().enumerate().map(|(index, row)| {
            let sum: f64 = row
                .iter()
                .zip(values)
                .map(|(wave, value)| wave * value)
                .sum();
            if index == 0 {
                sum / count
            } else {
                2.0 * sum / count
            }
        });
        products.collect()
    }

    /// The values of quantised coefficients at evenly spaced phases.
    fn synthesise(&self, coefficients: &[i32], size: f64) -> Vec<f64> {
        let mut values = vec![0.0; self.frames];
        for (&coefficient, row) in coefficients.iter().zip(&self.rows) {
            if coefficient != 0 {
                let scale = f64::from(coefficient) * size;
                for (value, wave) in values.iter_mut().zip(row) {
                    *value += scale * wave;
                }
            }
        }
        values
    }
}
