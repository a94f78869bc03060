//! Bodies as bytes: offsets to 0.1 mm, hull points to 1/255 of their hull's box.

use crate::error::{Error, Result};
use crate::scene::{Body, BodyHull};
use edgegait_core::avatar::Avatar;
use edgegait_core::budget::{MAX_HULL_POINTS, MAX_HULLS, MAX_POINTS};
use edgegait_core::format::{HULL_STEP_M, OFFSET_STEP_M};
use glam::DVec3;

/// An avatar's bytes and how far its points moved.
#[derive(Clone, Debug)]
pub struct EncodedAvatar {
    /// What [`Avatar::parse`] reads.
    pub bytes: Vec<u8>,
    /// Greatest distance from a hull point to its decoded one, mm.
    pub max_error_mm: f64,
}

/// Encodes a body.
///
/// # Errors
/// For bodies beyond the core's budget, or larger than 3.2 m.
pub fn encode_avatar(body: &Body) -> Result<EncodedAvatar> {
    check_budget(body)?;
    let mut bytes = Vec::new();
    for offset in &body.offsets {
        push_offset(&mut bytes, *offset)?;
    }
    for hull in &body.hulls {
        push_hull(&mut bytes, hull)?;
    }
    let avatar = Avatar::parse(&bytes)
        .map_err(|error| Error::Failed(format!("the avatar does not read back: {error}")))?;
    let mut max_error_mm = 0.0f64;
    for (hull, decoded) in body.hulls.iter().zip(avatar.hulls()) {
        for (point, found) in hull.points.iter().zip(decoded.points()) {
            max_error_mm = max_error_mm.max(point.distance(found.as_dvec3()) * 1e3);
        }
    }
    Ok(EncodedAvatar {
        bytes,
        max_error_mm,
    })
}

fn check_budget(body: &Body) -> Result<()> {
    let points: usize = body.hulls.iter().map(|hull| hull.points.len()).sum();
    let finite = |point: &DVec3| point.is_finite();
    if !body.offsets.iter().all(finite) || !body.hulls.iter().all(|h| h.points.iter().all(finite)) {
        return Err(Error::Failed(
            "a body with coordinates that are not finite".into(),
        ));
    }
    let largest = body.hulls.iter().map(|hull| hull.points.len()).max();
    let smallest = body.hulls.iter().map(|hull| hull.points.len()).min();
    if body.hulls.len() > MAX_HULLS
        || points > MAX_POINTS
        || largest > Some(MAX_HULL_POINTS)
        || smallest == Some(0)
    {
        return Err(Error::Failed(format!(
            "a body of {} hulls, {points} points and at most {} in one: expected at most {MAX_HULLS} hulls of 1 to {MAX_HULL_POINTS} points, {MAX_POINTS} in all",
            body.hulls.len(),
            largest.unwrap_or(0),
        )));
    }
    Ok(())
}

/// Appends three coordinates in units of 0.1 mm, rounded to nearest.
fn push_offset(bytes: &mut Vec<u8>, offset: DVec3) -> Result<()> {
    for coordinate in offset.to_array() {
        let steps = (coordinate / f64::from(OFFSET_STEP_M)).round();
        if !(f64::from(i16::MIN)..=f64::from(i16::MAX)).contains(&steps) {
            return Err(Error::Failed(format!(
                "a body with a coordinate of {coordinate} m: expected at most 3.2 m (are the units metres?)"
            )));
        }
        #[expect(clippy::cast_possible_truncation, reason = "checked above")]
        bytes.extend((steps as i16).to_le_bytes());
    }
    Ok(())
}

fn push_hull(bytes: &mut Vec<u8>, hull: &BodyHull) -> Result<()> {
    let unit = f64::from(OFFSET_STEP_M);
    let min = hull.points.iter().copied().fold(DVec3::MAX, DVec3::min);
    let max = hull.points.iter().copied().fold(DVec3::MIN, DVec3::max);
    // The origin is rounded down, so that every point is a positive number of steps.
    let origin = (min / unit).floor() * unit;
    let steps = ((max - origin) / (255.0 * f64::from(HULL_STEP_M))).ceil();
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "joints and points are below 33; steps of a hull under 16 m fit"
    )]
    {
        bytes.push(hull.joint.index() as u8);
        bytes.push(hull.points.len() as u8);
        push_offset(bytes, origin)?;
        for axis in steps.to_array() {
            bytes.extend((axis.min(65_535.0) as u16).to_le_bytes());
        }
        let step = steps.max(DVec3::ONE) * f64::from(HULL_STEP_M);
        for point in &hull.points {
            let count = ((point - origin) / step).round();
            bytes.extend(count.to_array().map(|axis| axis.clamp(0.0, 255.0) as u8));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use edgegait_core::skeleton::{JOINTS, Joint};

    #[test]
    fn points_return_within_a_step_and_the_error_is_stated() {
        let mut offsets = [DVec3::ZERO; JOINTS];
        offsets[1] = DVec3::new(0.0, 0.123_46, -0.05);
        let points: Vec<_> = (0..32)
            .map(|i| DVec3::new(f64::from(i) * 0.01, (f64::from(i) * 0.7).sin(), -0.2))
            .collect();
        let body = Body {
            offsets,
            hulls: vec![BodyHull {
                joint: Joint::Head,
                points,
            }],
        };
        let encoded = encode_avatar(&body).expect("a body within the budget");
        // Steps of 310/255 and 2000/255 mm: half of each, and the origin's 0.1 mm.
        assert!(encoded.max_error_mm < 4.2, "{}", encoded.max_error_mm);
        assert!(encoded.max_error_mm > 1.0);
        let avatar = Avatar::parse(&encoded.bytes).expect("it was checked");
        let spine = avatar.skeleton().offsets[1];
        assert!((spine.y - 0.1235).abs() < 1e-6 && (spine.z + 0.05).abs() < 1e-6);
    }

    #[test]
    fn a_body_beyond_the_budget_is_refused() {
        let hull = BodyHull {
            joint: Joint::Head,
            points: vec![DVec3::ZERO; 33],
        };
        let mut body = Body {
            offsets: [DVec3::ZERO; JOINTS],
            hulls: vec![hull],
        };
        assert!(encode_avatar(&body).is_err());
        body.hulls.clear();
        body.offsets[3].x = 3.3;
        let error = encode_avatar(&body).expect_err("3.3 m").to_string();
        assert!(error.contains("units"), "{error}");
    }
}
