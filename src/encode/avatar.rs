//! Encoding of bodies: offsets to 0.1 mm, hull points in the coarsest steps within an error
//! bound, and symmetric parts by their half.

#[cfg(test)]
mod tests;

use super::bits::{BitWriter, signed_width};
use super::hull::{StepPoint, image, write_drape};
use super::symmetry::{Halves, counts, distance, position};
use crate::error::{EncodeError, Result};
use crate::people::{Body, BodyHull};
use edgegait_core::avatar::Avatar;
use edgegait_core::budget::{MAX_DRAPED_HULLS, MAX_HULL_POINTS, MAX_HULLS, MAX_POINTS};
use edgegait_core::format::{
    CLOTHES_BITS, DRESSED, FITTED, HULL_STEP_M, JOINT_BITS, OFFSET_STEP_M, OFFSET_WIDTH_BITS,
    PARTS_BITS, SYMMETRIC_SKELETON, WIDTH_BITS,
};
use edgegait_core::skeleton::{JOINTS, Joint};
use glam::{DVec3, Vec3};

/// The maximum number of steps that the format holds in a coordinate.
const MAX_COUNT: f64 = ((1 << ((1 << WIDTH_BITS) - 2)) - 1) as f64;
/// The greatest error that the format can state, mm.
const MAX_STATED_MM: f64 = 655.35;

/// The maximum number of stored parts of a draped hull, without mirror images.
const MAX_PARTS: usize = 1 << PARTS_BITS;

/// An avatar's bytes and encoding error.
#[derive(Clone, Debug)]
pub struct EncodedAvatar {
    /// The bytes that [`Avatar::parse`] reads.
    pub bytes: Vec<u8>,
    /// The greatest distance from a hull's point to the nearest decoded point, or from a decoded
    /// point to the nearest point of the hull, mm.
    pub max_error_mm: f64,
}

/// Encodes a body in the coarsest steps that keep every hull point within `max_error_mm`. Where
/// the format cannot reach this error, the finest steps are used (1/16383 of the farthest
/// coordinate: 0.06 mm for 1 m); [`EncodedAvatar::max_error_mm`] states the error.
///
/// Points that round to the same point are merged. Where the error allows, symmetric hulls, and
/// pairs of hulls on the left and the right, are stored by their half. So is a skeleton whose
/// offsets are symmetric to 0.1 mm.
///
/// # Errors
/// For bodies beyond the core's budget, or larger than 3.2 m.
pub fn encode_avatar(body: &Body, max_error_mm: f64) -> Result<EncodedAvatar> {
    check_budget(body)?;
    let offsets = rounded_offsets(body)?;
    let max_error_mm = max_error_mm.min(MAX_STATED_MM);
    let finest = finest_step_um(body)?;
    for step_um in (finest..=coarsest_step_um(body, max_error_mm)).rev() {
        if is_within(body, step_um, max_error_mm) {
            let encoded = encode(body, &offsets, step_um, max_error_mm)?;
            // An error within the bound in f64 may exceed it in the core's f32.
            if encoded.max_error_mm <= max_error_mm {
                return Ok(encoded);
            }
        }
    }
    encode(body, &offsets, finest, max_error_mm)
}

fn check_budget(body: &Body) -> Result<()> {
    let lens =
        |hulls: &[BodyHull]| -> Vec<usize> { hulls.iter().map(|hull| hull.points.len()).collect() };
    let finite = |point: &DVec3| point.is_finite();
    let is_finite = |hull: &BodyHull| hull.points.iter().all(finite);
    if !body.offsets.iter().all(finite) || !body.all_hulls().all(is_finite) {
        return Err(EncodeError::NotFinite("a body".into()).into());
    }
    // The points of all parts of a draped hull count together.
    let wholes = body.draped.iter().map(|parts| lens(parts).iter().sum());
    let largest = lens(&body.hulls).into_iter().chain(wholes).max();
    let hulls = body.all_hulls().count();
    let points: usize = body.all_hulls().map(|hull| hull.points.len()).sum();
    let is_empty = |hull: &BodyHull| hull.points.is_empty();
    if hulls > MAX_HULLS
        || points > MAX_POINTS
        || largest > Some(MAX_HULL_POINTS)
        || body.draped.len() > MAX_DRAPED_HULLS
        || body.all_hulls().any(is_empty)
        || body
            .draped
            .iter()
            .any(|parts| parts.is_empty() || parts.len() > MAX_PARTS)
    {
        return Err(EncodeError::BodyTooLarge {
            hulls,
            draped: body.draped.len(),
            points,
            largest: largest.unwrap_or(0),
        }
        .into());
    }
    Ok(())
}

/// Checks that a coordinate fits the 16 bits of an offset, as bodies in metres do.
fn check_size(coordinate: f64) -> Result<()> {
    if coordinate.abs() > f64::from(i16::MAX) * f64::from(OFFSET_STEP_M) {
        return Err(EncodeError::OutOfRange {
            what: "a body with a coordinate of",
            found: coordinate,
            unit: "m",
            expected: "at most 3.2 m (are the units metres?)",
        }
        .into());
    }
    Ok(())
}

/// Returns joint offsets in units of 0.1 mm, rounded to nearest.
fn rounded_offsets(body: &Body) -> Result<[StepPoint; JOINTS]> {
    let mut rounded = [[0; 3]; JOINTS];
    for (offset, rounded) in body.offsets.iter().zip(&mut rounded) {
        for coordinate in offset.to_array() {
            check_size(coordinate)?;
        }
        *rounded = counts(*offset, f64::from(OFFSET_STEP_M));
    }
    Ok(rounded)
}

/// Returns the finest step in which the format holds all coordinates, micrometres.
fn finest_step_um(body: &Body) -> Result<u16> {
    let mut finest = 1.0f64;
    for point in body.all_hulls().flat_map(|hull| &hull.points) {
        let farthest = point.abs().max_element();
        check_size(farthest)?;
        finest = finest.max((farthest / (MAX_COUNT * f64::from(HULL_STEP_M))).ceil());
    }
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "1 to 201: 3.3 m by 16383"
    )]
    let finest = finest as u16;
    Ok(finest)
}

/// Returns a step beyond which some coordinate exceeds the error, micrometres. A coordinate
/// farther from 0 than the error needs at least one step, which may exceed it by the error at
/// most.
fn coarsest_step_um(body: &Body, max_error_mm: f64) -> u16 {
    let error_m = max_error_mm * 1e-3;
    let points = body.all_hulls().flat_map(|hull| &hull.points);
    let counted = points.flat_map(|point| point.abs().to_array());
    let nearest = counted.filter(|&m| m > error_m).fold(f64::MAX, f64::min);
    let most = ((nearest + error_m) / f64::from(HULL_STEP_M)).ceil();
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "clamped"
    )]
    let most = most.clamp(1.0, f64::from(u16::MAX)) as u16;
    most
}

fn step_m(step_um: u16) -> f64 {
    f64::from(step_um) * f64::from(HULL_STEP_M)
}

/// Returns whether all points are within an error of whole numbers of steps.
fn is_within(body: &Body, step_um: u16, max_error_mm: f64) -> bool {
    let step_m = step_m(step_um);
    let mut points = body.all_hulls().flat_map(|hull| &hull.points);
    points.all(|&point| {
        let found = position(counts(point, step_m), step_m);
        point.distance(found) * 1e3 <= max_error_mm
    })
}

/// Encodes a body in these steps, and measures the error with the core's reader.
fn encode(
    body: &Body,
    offsets: &[StepPoint; JOINTS],
    step_um: u16,
    max_error_mm: f64,
) -> Result<EncodedAvatar> {
    let stored_hulls = |hulls| {
        let halves = Halves {
            hulls,
            step_m: step_m(step_um),
            max_error_m: max_error_mm * 1e-3,
        };
        halves.stored_hulls()
    };
    let (stored, mut sources) = stored_hulls(&body.hulls);
    let is_symmetric = is_symmetric(offsets);
    let mut writer = BitWriter::default();
    write_offsets(&mut writer, offsets, is_symmetric);
    if let Some(clothes) = body.clothes {
        writer.unsigned(DRESSED, JOINT_BITS);
        writer.unsigned(u32::from(clothes.bits()), CLOTHES_BITS);
    }
    for hull in &stored {
        hull.write(&mut writer);
    }
    let mut stored_count = stored.len();
    for parts in &body.draped {
        let (parts, of_parts) = stored_hulls(parts);
        write_drape(parts.len(), &mut writer);
        for part in &parts {
            part.write(&mut writer);
        }
        stored_count += parts.len();
        sources.extend(of_parts);
    }
    let skeleton = if is_symmetric { SYMMETRIC_SKELETON } else { 0 };
    let hull_count =
        u8::try_from(stored_count).map_err(|_| EncodeError::PackTooLarge(stored_count))?;
    let mut bytes = vec![0, 0];
    bytes.extend(step_um.to_le_bytes());
    let is_fitted = if body.fit.is_some() { FITTED } else { 0 };
    bytes.push(is_fitted | skeleton | hull_count);
    if let Some(fit) = &body.fit {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a share of 10,000"
        )]
        let jaccard = (fit.jaccard.clamp(0.0, 1.0) * 1e4).round() as u16;
        bytes.extend(jaccard.to_le_bytes());
    }
    bytes.extend(writer.into_bytes());

    let avatar = Avatar::parse(&bytes).map_err(EncodeError::read_back("the avatar"))?;
    let mut max_error_mm = 0.0f64;
    for (hull, decoded) in sources.iter().zip(avatar.hulls()) {
        let found: Vec<DVec3> = decoded.points().map(Vec3::as_dvec3).collect();
        max_error_mm = max_error_mm.max(distance(&hull.points, &found) * 1e3);
    }
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "at most 65535"
    )]
    let stated = (max_error_mm.min(MAX_STATED_MM) * 100.0).ceil() as u16;
    bytes[..2].copy_from_slice(&stated.to_le_bytes());
    Ok(EncodedAvatar {
        bytes,
        max_error_mm,
    })
}

/// Returns whether the right joints' offsets are mirror images of the left ones, and the middle
/// joints' offsets lie in the plane between.
fn is_symmetric(offsets: &[StepPoint; JOINTS]) -> bool {
    let at = |joint: Joint| offsets[joint.index()];
    let mut joints = Joint::ALL.into_iter().skip(1);
    joints.all(|joint| at(joint) == image(at(joint.mirrored())))
}

/// Appends the offsets of all joints except the pelvis, or of the left and middle ones only.
fn write_offsets(writer: &mut BitWriter, offsets: &[StepPoint; JOINTS], is_symmetric: bool) {
    let joints = Joint::ALL.into_iter().zip(offsets).skip(1);
    let coordinates: Vec<i32> = joints
        .filter(|(joint, _)| !is_symmetric || *joint <= joint.mirrored())
        .flat_map(|(joint, offset)| {
            let is_middle = joint == joint.mirrored();
            &offset[usize::from(is_symmetric && is_middle)..]
        })
        .copied()
        .collect();
    let width = coordinates.iter().copied().map(signed_width).max();
    let width = width.unwrap_or(0);
    writer.unsigned(width, OFFSET_WIDTH_BITS);
    for coordinate in coordinates {
        writer.unsigned(u32::from(coordinate != 0), 1);
        writer.signed(coordinate, if coordinate == 0 { 0 } else { width });
    }
}
