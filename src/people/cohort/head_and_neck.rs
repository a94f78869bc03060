//! The hulls of a body's neck and head.

use super::anthropometry::Dimensions;
use super::rings::{ELLIPSE, half_depth, radius, ring};
use glam::DVec3;

/// The lowest cervical joint ahead of the skin over the seventh vertebra, as a share of stature: 5
/// cm, as where markers are read. Our choice.
pub(super) const NECK_WITHIN: f64 = 0.030;
/// Height of the head's greatest section above the ears, as a share of the crown's. Our choice.
const TEMPLES: f64 = 0.30;
/// The greatest breadth of a neck as a share of the head's. Our choice: beyond it necks are deeper.
const NECK_BREADTH: f64 = 0.80;

/// Returns the points of a neck about its joint, at the height of the seventh vertebra: a straight
/// column from `root` below it to the head's joint, `skull`.
pub(super) fn neck_points(d: &Dimensions, skull: &DVec3, root: f64) -> Vec<DVec3> {
    let broad = radius(d.neck_circumference).min(0.5 * NECK_BREADTH * d.head_breadth);
    let deep = half_depth(d.neck_circumference, broad, ELLIPSE);
    let (centre, top) = (deep - NECK_WITHIN * d.stature, skull.y + 0.01);
    let lean = (skull.z - centre) / top;
    let at = |y: f64| DVec3::new(0.0, y, centre + lean * y);
    [
        ring(at(root), (broad, deep), ELLIPSE),
        ring(at(0.0), (broad, deep), ELLIPSE),
        ring(at(top), (0.92 * broad, deep), ELLIPSE),
    ]
    .concat()
}

/// Returns the points of the head about the ear's height: chin, jaw, temples and vault. Above the
/// temples it follows an ellipsoid from there to the crown, of exponent 2.2 (our choice: between an
/// ellipsoid and a box).
pub(super) fn head_points(d: &Dimensions) -> Vec<DVec3> {
    let (half_breadth, half_length) = (0.5 * d.head_breadth, 0.5 * d.head_length);
    let crown = d.tragion_to_vertex;
    let at = |y: f64, z: f64| DVec3::new(0.0, y, z);
    let chin_z = half_length - 0.02;
    let mut points = vec![
        DVec3::new(0.25 * half_breadth, -0.75 * crown, chin_z),
        DVec3::new(-0.25 * half_breadth, -0.75 * crown, chin_z),
        DVec3::new(0.55 * half_breadth, -0.62 * crown, 0.3 * half_length),
        DVec3::new(-0.55 * half_breadth, -0.62 * crown, 0.3 * half_length),
        at(crown, 0.0),
    ];
    let jaw = (0.93 * half_breadth, 0.96 * half_length);
    // The back of the head curves in to the neck: without the rearmost point, the seventh.
    let under = ring(at(-0.25 * crown, 0.005), jaw, 0.74);
    points.extend([&under[..6], &under[7..]].concat());
    points.extend(ring(
        at(TEMPLES * crown, 0.0),
        (half_breadth, half_length),
        0.74,
    ));
    let vault = |height: f64| {
        let up = (height - TEMPLES) / (1.0 - TEMPLES);
        let out = libm::pow(1.0 - libm::pow(up, 2.2), 1.0 / 2.2);
        ring(
            at(height * crown, 0.0),
            (out * half_breadth, out * half_length),
            0.72,
        )
    };
    points.extend(vault(0.72));
    // Four points span the top, since a hull has at most 32.
    points.extend(vault(0.92).into_iter().step_by(2));
    points
}
