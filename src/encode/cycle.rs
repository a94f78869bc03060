//! Quantisation of gait cycles: Fourier coefficients in steps, within a stated error.
//!
//! Joints are quantised parents first, in a closed loop: a child aims at its true orientation in
//! the walker's space given its *decoded* parent, so that errors do not add up down a limb. A
//! search finds the coarsest scale of steps at which [`DecodedCycle::refine`] brings all points
//! within the stated error.

use super::coefficients::{CycleCoefficients, Mean, mean_of, trim};
use super::decoded::DecodedCycle;
use super::frames::Frames;
use super::target::EncodingTarget;
use edgegait_core::format::ESCAPE_BITS;
use edgegait_core::skeleton::{JOINTS, Joint};
use glam::{DQuat, DVec3};

/// The excess over a half above which numbers are rounded away from zero. It saves more bits than
/// its error costs, measured on CMU's straight walks.
const DEAD_ZONE: f64 = 0.2;
/// The finest scale of the search, and the end of the range beyond the coarsest: steps of
/// 1 micrometre and of 30 cm.
const SCALES: (u8, u8) = (0, 146);
/// The change of scale between tries of [`quickly`], in eighths of an octave.
const QUICK_STEP: u8 = 3;
/// The largest amount by which the refined scale may be coarser than that of plain rounding, in
/// eighths of an octave.
const MOST_REFINED: u8 = 12;

/// A cycle as whole numbers of steps of a scale.
#[derive(Clone, Debug)]
pub(super) struct Quantised {
    pub(super) scale: u8,
    pub(super) numbers: CycleCoefficients,
}

/// Quantises a cycle with the smallest numbers that keep every virtual point within
/// `max_error_mm`. Where no scale reaches this error, the finest is used. Returns `None` if the
/// cycle's rotations do not close, or even the coarsest scale does not hold them.
pub(super) fn quantise(
    target: &EncodingTarget<'_>,
    frames: &Frames,
    mean: Option<&Mean>,
    max_error_mm: f64,
) -> Option<Quantised> {
    let mut best = plainly(target, frames, mean, max_error_mm)?;
    let rounded = best.scale;
    // Then the coarsest scale at which changes of single numbers reach the error.
    let (mut good, mut bad) = (rounded, rounded.saturating_add(MOST_REFINED + 1));
    while bad - good > 1 {
        let scale = good.midpoint(bad);
        let refined = round(target, frames, mean, scale).and_then(|numbers| {
            let mut figure = DecodedCycle::new(target, frames, mean, scale, numbers, max_error_mm);
            figure.refine().then(|| {
                figure.shorten();
                figure.into_numbers()
            })
        });
        if let Some(numbers) = refined {
            good = scale;
            best = Quantised { scale, numbers };
        } else {
            bad = scale;
        }
    }
    if best.scale == rounded {
        let numbers = best.numbers;
        let mut figure = DecodedCycle::new(target, frames, mean, rounded, numbers, max_error_mm);
        figure.shorten();
        best.numbers = figure.into_numbers();
    }
    Some(best)
}

/// Returns the coarsest scale that is good enough with plain rounding, and its numbers.
pub(super) fn plainly(
    target: &EncodingTarget<'_>,
    frames: &Frames,
    mean: Option<&Mean>,
    max_error_mm: f64,
) -> Option<Quantised> {
    let (mut low, mut high) = SCALES;
    let mut best: Option<(Quantised, f64)> = None;
    while low < high {
        let scale = low.midpoint(high);
        let Some(numbers) = round(target, frames, mean, scale) else {
            // Numbers too large for the format: the scale has to be coarser.
            low = scale + 1;
            continue;
        };
        let figure = DecodedCycle::new(target, frames, mean, scale, numbers, max_error_mm);
        let error_mm = figure.max_error_mm();
        let good = error_mm <= max_error_mm;
        // If no scale is good enough, the one with the least error is kept.
        if good || best.as_ref().is_none_or(|(_, least)| error_mm < *least) {
            let numbers = figure.into_numbers();
            best = Some((Quantised { scale, numbers }, error_mm));
        }
        if good {
            low = scale + 1;
        } else {
            high = scale;
        }
    }
    best.map(|(best, _)| best)
}

/// Rounds a cycle in steps of a scale, or of finer scales until every virtual point is within
/// `max_error_mm`. Returns `None` in the cases of [`quantise`].
pub(super) fn quickly(
    target: &EncodingTarget<'_>,
    frames: &Frames,
    mean: Option<&Mean>,
    scale: f64,
    max_error_mm: f64,
) -> Option<Quantised> {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "clamped"
    )]
    let mut scale = scale.clamp(f64::from(SCALES.0), f64::from(SCALES.1)) as u8;
    loop {
        let Some(numbers) = round(target, frames, mean, scale) else {
            // Numbers too large for the format: search the scale.
            return plainly(target, frames, mean, max_error_mm);
        };
        let figure = DecodedCycle::new(target, frames, mean, scale, numbers, max_error_mm);
        if figure.max_error_mm() <= max_error_mm || scale == SCALES.0 {
            let numbers = figure.into_numbers();
            return Some(Quantised { scale, numbers });
        }
        scale = scale.saturating_sub(QUICK_STEP).max(SCALES.0);
    }
}

/// Returns the coefficients of a cycle in steps of this scale without a mean walk, or `None` if
/// the format does not hold them.
pub(super) fn rounded_at(
    target: &EncodingTarget<'_>,
    frames: &Frames,
    scale: u8,
) -> Option<CycleCoefficients> {
    round(target, frames, None, scale)
}

/// Returns the coefficients of a cycle in steps of this scale, or `None` if the format does not
/// hold them.
fn round(
    target: &EncodingTarget<'_>,
    frames: &Frames,
    mean: Option<&Mean>,
    scale: u8,
) -> Option<CycleCoefficients> {
    let mut numbers: CycleCoefficients = std::array::from_fn(|_| Vec::new());
    let mut decoded = vec![[DQuat::IDENTITY; JOINTS]; target.len()];
    for joint in Joint::ALL {
        let index = joint.index();
        let parents: Vec<DQuat> = decoded
            .iter()
            .map(|joints| {
                joint
                    .parent()
                    .map_or(DQuat::IDENTITY, |parent| joints[parent.index()])
            })
            .collect();
        let aims = target.orientations.iter().map(|joints| joints[index]);
        let locals = parents
            .iter()
            .zip(aims)
            .map(|(parent, aim)| parent.inverse() * aim);
        let vectors = frames.vectors(index, locals)?;
        let quantised = round_vectors(target, frames, mean, scale, index, &vectors, &mut numbers)?;
        for ((joints, parent), vector) in decoded.iter_mut().zip(parents).zip(quantised) {
            joints[index] = parent * frames.rotation(index, vector);
        }
    }
    let root = &target.cycle.root;
    round_vectors(target, frames, mean, scale, JOINTS, root, &mut numbers)?;
    Some(numbers)
}

/// Quantises the three channels of a joint, or of the root (number [`JOINTS`]), and returns their
/// decoded values by frame.
fn round_vectors(
    target: &EncodingTarget<'_>,
    frames: &Frames,
    mean: Option<&Mean>,
    scale: u8,
    joint: usize,
    vectors: &[DVec3],
    numbers: &mut CycleCoefficients,
) -> Option<Vec<DVec3>> {
    let mut decoded = vec![DVec3::ZERO; vectors.len()];
    for axis in 0..3 {
        let channel = 3 * joint + axis;
        let step = frames.step(channel, scale);
        let values: Vec<f64> = vectors.iter().map(|vector| vector[axis]).collect();
        let mut coefficients = target.series.analyse(&values);
        let own = &mut numbers[channel];
        for (index, coefficient) in coefficients.iter_mut().enumerate() {
            let usual = mean_of(mean, channel, index);
            let steps = (*coefficient - usual) / step;
            let number = (steps.abs() + 0.5 - DEAD_ZONE).floor().copysign(steps);
            if number.abs() >= f64::from(1 << (ESCAPE_BITS - 1)) {
                return None;
            }
            #[expect(clippy::cast_possible_truncation, reason = "checked: 24 bits")]
            own.push(number as i32);
            *coefficient = usual + number * step;
        }
        trim(own);
        let decoded_channel = target.series.synthesise(&coefficients);
        for (vector, value) in decoded.iter_mut().zip(decoded_channel) {
            vector[axis] = value;
        }
    }
    Some(decoded)
}
