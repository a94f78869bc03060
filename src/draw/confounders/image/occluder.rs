//! Occluders: a pillar or a person between the camera and the walker.
//!
//! Walkers walk on the spot, so a static object moves backwards by one stride in a cycle. Occluders
//! repeat from cycle to cycle. High cameras see little occlusion: at an elevation of 60 degrees,
//! an object one metre nearer appears 0.87 m further down.

use edgegait_core::body::UnpackedBody;
use edgegait_core::camera::Viewpoint;
use edgegait_core::pose::ModelPose;
use edgegait_core::skeleton::Joint;
use glam::{Mat3, Vec3};
use rand::RngExt as _;
use rand_chacha::ChaCha8Rng;

/// Level distance from the walker's path towards the camera, metres. Our choice: as between two
/// people who pass each other.
const DISTANCE_M: f32 = 1.0;

/// Height of a pillar, and its width at strength 1, metres. Our choice: as on railway platforms.
const PILLAR_HEIGHT_M: f32 = 3.0;
const PILLAR_WIDTH_M: f32 = 0.5;
/// How far a pillar reaches below the floor, metres: farther than soles, which sink in by their
/// smoothed motion.
const PILLAR_DEPTH_M: f32 = 0.05;
/// The largest sideways offset of a pillar, seen from the camera, metres.
const ASIDE_M: f32 = 0.2;

/// A pillar that the walker passes behind.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Pillar {
    width_m: f32,
    aside_m: f32,
    start: f64,
}

impl Pillar {
    /// Samples a pillar 3 m high, half a metre thick at strength 1, one metre from the walker
    /// towards the camera. Random are the phase at which the walker passes it and its sideways
    /// offset, which shows from the front and from behind.
    #[must_use]
    pub(crate) fn new(strength: f64, rng: &mut ChaCha8Rng) -> Self {
        #[expect(clippy::cast_possible_truncation, reason = "a share")]
        let width_m = PILLAR_WIDTH_M * strength as f32;
        Self {
            width_m,
            aside_m: ASIDE_M * (2.0 * rng.random::<f32>() - 1.0),
            start: rng.random(),
        }
    }

    /// Returns the pillar at a phase of the cycle, seen from a viewpoint; draw it at rest.
    #[must_use]
    pub(crate) fn body(
        &self,
        phase: f64,
        stride_m: f64,
        viewpoint: Viewpoint,
    ) -> Box<UnpackedBody> {
        let travelled = travelled(phase + self.start, stride_m);
        let (toward, right) = level_axes(viewpoint);
        let foot = toward * DISTANCE_M + right * self.aside_m - Vec3::Z * travelled;
        let corners = (0..8_u8).flat_map(|corner| {
            let (sin, cos) = libm::sincosf(f32::from(corner) * std::f32::consts::FRAC_PI_4);
            let side = foot + Vec3::new(cos, 0.0, sin) * (0.5 * self.width_m);
            [-PILLAR_DEPTH_M, PILLAR_HEIGHT_M].map(|height| side + Vec3::Y * height)
        });
        let mut body = Box::<UnpackedBody>::default();
        let fits = body.push(Joint::Pelvis, corners);
        debug_assert!(fits.is_ok(), "16 points are within the budget");
        body
    }
}

/// A person who crosses between the camera and the walker.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Crossing {
    scale: f32,
    start: f64,
}

impl Crossing {
    /// Samples the phase at which a person crosses, who is as large as the walker at strength 1 and
    /// half as large at 0.5.
    #[must_use]
    pub(crate) fn new(strength: f64, rng: &mut ChaCha8Rng) -> Self {
        #[expect(clippy::cast_possible_truncation, reason = "a share")]
        let scale = strength as f32;
        Self {
            scale,
            start: rng.random(),
        }
    }

    /// Returns the person's size relative to the walker, the factor on the points of the hulls.
    #[must_use]
    pub(crate) const fn scale(&self) -> f32 {
        self.scale
    }

    /// Returns the crossing person's pose, from a pose of the walker and a phase of the cycle. One
    /// metre towards the camera, the person crosses the line of sight at right angles at twice the
    /// walking speed. Seen from the side, the person walks the other way.
    #[must_use]
    pub(crate) fn pose(
        &self,
        pose: &ModelPose,
        phase: f64,
        stride_m: f64,
        viewpoint: Viewpoint,
    ) -> ModelPose {
        let (toward, right) = level_axes(viewpoint);
        let heading = if right.z > 0.0 { -right } else { right };
        let turn = Mat3::from_cols(Vec3::Y.cross(heading), Vec3::Y, heading);
        let travelled = travelled(phase + self.start, 2.0 * stride_m);
        let place = toward * DISTANCE_M + heading * travelled;
        ModelPose {
            positions: pose
                .positions
                .map(|position| place + turn * (position * self.scale)),
            orientations: pose.orientations.map(|orientation| turn * orientation),
        }
    }
}

/// Returns metres from the middle of a path of `length_m`, which restarts with each cycle.
fn travelled(phase: f64, length_m: f64) -> f32 {
    #[expect(clippy::cast_possible_truncation, reason = "metres")]
    let travelled = ((phase - libm::floor(phase) - 0.5) * length_m) as f32;
    travelled
}

/// Returns the level directions to the camera, and to the image's right for a camera without
/// roll. For a camera straight above, the first is the direction down in the image.
fn level_axes(viewpoint: Viewpoint) -> (Vec3, Vec3) {
    let level = |direction: Vec3| {
        let flat = Vec3::new(direction.x, 0.0, direction.z);
        (flat.length() > 1e-3).then(|| flat.normalize())
    };
    let toward = level(viewpoint.toward()).or_else(|| level(-viewpoint.up()));
    let toward = toward.unwrap_or(Vec3::Z);
    (toward, Vec3::Y.cross(toward))
}

#[cfg(test)]
mod tests {
    use super::super::tests::{camera, hulls, people, seen, side_view};
    use super::super::{Fine, FineRenderer};
    use super::*;
    use edgegait_core::body::Figure;
    use edgegait_core::camera::Framing;
    use edgegait_core::raster::Rasterizer;
    use edgegait_core::silhouette::Size;
    use rand::SeedableRng as _;

    fn viewpoint(azimuth: f32) -> Viewpoint {
        Viewpoint::from_degrees(azimuth, 0.0).expect("a viewpoint")
    }

    /// Returns the middle of a body's bounding box.
    fn middle(body: &UnpackedBody) -> Vec3 {
        let figure = Figure::at_rest(body);
        let points = figure.points();
        let (low, high) = points.fold((Vec3::MAX, Vec3::MIN), |(low, high), point| {
            (low.min(point), high.max(point))
        });
        0.5 * (low + high)
    }

    #[test]
    fn a_pillar_passes_backwards_by_a_stride_in_a_cycle_a_metre_towards_the_camera() {
        let pillar = Pillar {
            width_m: 0.5,
            aside_m: 0.15,
            start: 0.25,
        };
        let at = |phase, azimuth| middle(&pillar.body(phase, 1.4, viewpoint(azimuth)));
        let near = |found: Vec3, expected: [f32; 3]| {
            assert!(
                (found - Vec3::from(expected)).length() < 1e-5,
                "{found} {expected:?}"
            );
        };
        // Seen from the left: nearer means further left (+X), and the image's right is -Z.
        near(at(0.25, 90.0), [1.0, 1.475, -0.15]);
        near(at(0.5, 90.0), [1.0, 1.475, -0.5]);
        near(at(0.8, 90.0), [1.0, 1.475, 0.48]);
        near(at(1.25, 90.0), [1.0, 1.475, -0.15]);
        // Seen from the front: the image's right is +X.
        near(at(0.25, 0.0), [0.15, 1.475, 1.0]);
        near(at(0.25, 180.0), [-0.15, 1.475, -1.0]);
    }

    #[test]
    fn a_pillar_hides_a_strip_as_wide_as_it_is() {
        let (fine, mut picture, before) = side_view(0);
        let mut renderer = FineRenderer::new(Rasterizer::Rows, Size::S50x30).expect("binary");
        let pillar = Pillar {
            width_m: 0.2,
            aside_m: 0.0,
            start: 0.5,
        };
        let body = pillar.body(0.0, 1.4, viewpoint(90.0));
        let strip = fine
            .draw(&mut renderer, &Figure::at_rest(&body))
            .expect("a pillar");
        let width = 0.2 * fine.samples_per_metre().x;
        for row in before.bounds.top..before.bounds.bottom {
            let columns = f64::from(strip.count(row, 0, 9_999));
            assert!((columns - width).abs() <= 1.0, "{columns} {width}");
        }
        let whole = picture.area();
        picture.remove(&strip);
        assert!(picture.area() < whole && picture.area() > whole / 4);
    }

    #[test]
    fn somebody_crosses_at_right_angles_and_the_other_way_from_the_side() {
        let crossing = Crossing {
            scale: 1.0,
            start: 0.25,
        };
        let own = &people()[0].1[4];
        let posed = |phase, azimuth| crossing.pose(own, phase, 1.4, viewpoint(azimuth));
        for (number, joint) in own.positions.iter().enumerate() {
            let near = |found: Vec3, expected: [f32; 3]| {
                assert!(
                    (found - Vec3::from(expected)).length() < 1e-5,
                    "{found} {expected:?}"
                );
            };
            // Turned by 180 degrees, a metre to the left, and 0.7 m further after a quarter cycle.
            let [x, y, z] = joint.to_array();
            near(posed(0.25, 90.0).positions[number], [1.0 - x, y, -z]);
            near(posed(0.5, 90.0).positions[number], [1.0 - x, y, -z - 0.7]);
            near(posed(0.25, 270.0).positions[number], [-1.0 - x, y, -z]);
            // Seen from the front, the person walks to the image's right, +X.
            near(posed(0.5, 0.0).positions[number], [0.7 + z, y, 1.0 - x]);
        }
        let turned = posed(0.0, 90.0).orientations;
        for (own, turned) in own.orientations.iter().zip(turned) {
            let expected = Mat3::from_rotation_y(std::f32::consts::PI) * *own;
            assert!(expected.abs_diff_eq(turned, 1e-6));
        }
    }

    #[test]
    fn somebody_as_large_hides_nearly_all_as_he_passes_and_somebody_small_little() {
        let (body, poses) = &people()[0];
        let mut renderer = FineRenderer::new(Rasterizer::Rows, Size::S50x30).expect("binary");
        for (azimuth, is_perspective) in [(90.0, false), (90.0, true), (0.0, false), (30.0, true)] {
            let figure = Figure::new(body, &poses[0]);
            let camera = camera((azimuth, 0.0), is_perspective);
            let (view, size) = (seen(camera, Framing::Height), Size::S50x30);
            let fine = Fine::lay_out(&figure, &[], view, size).expect("a picture");
            let (picture, _) = fine.draw_figure(&mut renderer, &figure).expect("a drawing");
            let mut hidden = |strength: f64| {
                let mut rng = ChaCha8Rng::seed_from_u64(2);
                let crossing = Crossing {
                    start: 0.5,
                    ..Crossing::new(strength, &mut rng)
                };
                let mut small = Box::<UnpackedBody>::default();
                for (points, joint) in hulls(0) {
                    let points = points.into_iter().map(|point| point * crossing.scale());
                    small.push(joint, points).expect("as many as before");
                }
                let pose = crossing.pose(&poses[0], 0.0, 1.4, viewpoint(azimuth));
                let occluder = fine.draw(&mut renderer, &Figure::new(&small, &pose));
                let mut left = picture.clone();
                left.remove(&occluder.expect("an occluder"));
                1.0 - left.area() as f64 / picture.area() as f64
            };
            let (small, full) = (hidden(0.2), hidden(1.0));
            assert!(full > 0.45 && small < 0.15, "{azimuth}: {small} {full}");
        }
    }
}
