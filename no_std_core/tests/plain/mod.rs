//! Geometry in plain f64, and random figures, written from the conventions of the crate's front
//! page and independent of its code.

use crate::random::Random;
use edgegait_core::body::UnpackedBody;
use edgegait_core::skeleton::Joint;
use glam::Vec3;

pub type V3 = [f64; 3];
pub type V2 = [f64; 2];

pub fn random_quaternion(random: &mut Random) -> [f64; 4] {
    loop {
        let q = [0; 4].map(|_| random.between(-1.0, 1.0));
        let length = q.iter().map(|c| c * c).sum::<f64>().sqrt();
        if (0.1..=1.0).contains(&length) {
            return q.map(|c| c / length);
        }
    }
}

pub fn single(v: V3) -> Vec3 {
    Vec3::from(v.map(|c| c as f32))
}

/// Returns the directions of the image's right and up.
///
/// The camera stands at `towards` from the walker: in front (+Z) at azimuth 0, on the walker's left
/// (+X) at 90, above at elevation 90. Up is the visible part of the vertical; from straight above
/// it is the horizontal direction away from the camera.
pub fn image_axes(azimuth_deg: f64, elevation_deg: f64) -> (V3, V3) {
    let (sin_a, cos_a) = azimuth_deg.to_radians().sin_cos();
    let (sin_e, cos_e) = elevation_deg.to_radians().sin_cos();
    let towards = [sin_a * cos_e, sin_e, cos_a * cos_e];
    let up = if elevation_deg == 90.0 {
        [-sin_a, 0.0, -cos_a]
    } else {
        let seen: V3 = std::array::from_fn(|axis| f64::from(axis == 1) - sin_e * towards[axis]);
        let length = dot(seen, seen).sqrt();
        seen.map(|c| c / length)
    };
    // Looking along -towards: right = ahead x up = up x towards.
    let right = [
        up[1] * towards[2] - up[2] * towards[1],
        up[2] * towards[0] - up[0] * towards[2],
        up[0] * towards[1] - up[1] * towards[0],
    ];
    (right, up)
}

pub fn dot(a: V3, b: V3) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Returns twice the area of the triangle, positive if it turns left with x to the right and y up.
pub fn turn(a: V2, b: V2, c: V2) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// Returns the convex hull by gift wrapping (Jarvis 1973), counter-clockwise.
pub fn wrapped(points: &[V2]) -> Vec<V2> {
    let first = points
        .iter()
        .copied()
        .fold(points[0], |a, b| if b < a { b } else { a });
    let mut hull = vec![first];
    loop {
        let last = hull[hull.len() - 1];
        let mut next = points[0];
        for &candidate in points {
            if next == last || turn(last, next, candidate) < 0.0 {
                next = candidate;
            }
        }
        if next == first || hull.len() > points.len() {
            return hull;
        }
        hull.push(next);
    }
}

pub fn is_inside(hull: &[V2], sample: V2) -> bool {
    (0..hull.len()).all(|i| turn(hull[i], hull[(i + 1) % hull.len()], sample) > 0.0)
}

/// Returns a person-sized heap of ellipsoids: a trunk, a head and random limbs.
pub fn body(random: &mut Random) -> Vec<Vec<V3>> {
    let mut hulls = Vec::new();
    for hull in 0..=random.below(22) {
        let centre = [
            random.between(-0.25, 0.25) + 3.0,
            random.between(0.1, 1.7),
            random.between(-0.35, 0.35) - 2.0,
        ];
        let radii = if hull == 0 {
            [0.2, 0.9, 0.15]
        } else {
            [0.03, 0.05, 0.03]
        };
        let stretch = [0; 3].map(|_| random.between(1.0, 5.0));
        let points = 6 + random.below(27);
        hulls.push(
            (0..points)
                .map(|_| {
                    let [x, y, z, w] = random_quaternion(random);
                    // The image of an axis under a random rotation: uniform on a sphere.
                    let direction = [
                        2.0 * (x * z + w * y),
                        2.0 * (y * z - w * x),
                        1.0 - 2.0 * (x * x + y * y),
                    ];
                    std::array::from_fn(|axis| {
                        let size = if hull == 0 { 1.0 } else { stretch[axis] };
                        // Rounded to f32, so that both sides get the same figure.
                        f64::from((centre[axis] + radii[axis] * size * direction[axis]) as f32)
                    })
                })
                .collect(),
        );
    }
    hulls
}

pub fn posed(hulls: &[Vec<V3>]) -> UnpackedBody {
    let mut body = UnpackedBody::default();
    for hull in hulls {
        body.push(Joint::Pelvis, hull.iter().map(|&p| single(p)))
            .expect("within the budget");
    }
    body
}

pub fn random_angles(random: &mut Random, frame: usize) -> V2 {
    if frame.is_multiple_of(2) {
        [random.below(37) as f64 * 5.0, random.below(19) as f64 * 5.0]
    } else {
        let steps = [
            random.between(-23_040.0, 23_040.0),
            random.between(-5_696.0, 5_696.0),
        ];
        steps.map(|step| step.round() / 64.0)
    }
}
