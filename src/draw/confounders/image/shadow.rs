//! Cast shadows, which segmentation takes for a part of the figure.

use edgegait_core::body::{Figure, UnpackedBody};
use edgegait_core::budget::MAX_HULL_POINTS;
use edgegait_core::camera::{Viewpoint, ViewpointError};
use edgegait_core::outline::{clipped, convex};
use edgegait_core::skeleton::Joint;
use glam::{Vec2, Vec3};

/// The minimum elevation of the sun, degrees: shadows are then 11 times as long as the figure is
/// high.
const LEAST_ELEVATION_DEG: f32 = 5.0;

/// The direction to the sun.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Sun {
    toward: Vec3,
}

impl Sun {
    /// Returns the sun at an azimuth from the walker's heading, as for viewpoints: 0 is in front,
    /// 90 on the walker's left; shadows fall to the other side. Elevations below 5 degrees become
    /// 5.
    ///
    /// # Errors
    /// For angles out of the range of viewpoints.
    pub(crate) fn from_degrees(
        azimuth_deg: f32,
        elevation_deg: f32,
    ) -> Result<Self, ViewpointError> {
        // NaN stays NaN, and is rejected.
        let elevation_deg = if elevation_deg < LEAST_ELEVATION_DEG {
            LEAST_ELEVATION_DEG
        } else {
            elevation_deg
        };
        let toward = Viewpoint::from_degrees(azimuth_deg, elevation_deg)?.toward();
        Ok(Self { toward })
    }
}

/// The plane on which a walker walks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Floor {
    /// A point of the plane, metres.
    pub point: Vec3,
    /// The upward normal of the plane, a unit vector.
    pub normal: Vec3,
}

impl Floor {
    /// Returns a level floor at a height.
    #[must_use]
    pub const fn level(height_m: f32) -> Self {
        Self {
            point: Vec3::new(0.0, height_m, 0.0),
            normal: Vec3::Y,
        }
    }
}

/// Returns the shadow of a figure on the floor: a flat hull for each of its hulls, to be drawn at
/// rest ([`Figure::at_rest`]). At strength 1 the shadow is whole; at lower strengths it ends at
/// this share of its length, since its contrast with the floor falls with the distance.
#[must_use]
pub(crate) fn shadow_body(
    figure: &Figure<'_>,
    sun: Sun,
    floor: &Floor,
    strength: f64,
) -> Box<UnpackedBody> {
    // Axes of the floor, the first one along the shadow.
    let across = sun.toward.cross(floor.normal);
    let across = across.try_normalize().unwrap_or(Vec3::X);
    let along = across.cross(floor.normal);
    let cast = |point: Vec3| {
        let height = floor.normal.dot(point - floor.point);
        let at = point - sun.toward * (height / floor.normal.dot(sun.toward)) - floor.point;
        Vec2::new(along.dot(at), across.dot(at))
    };
    let lengths = figure.points().map(|point| cast(point).x);
    let (least, most) = lengths.fold((f32::MAX, f32::MIN), |(least, most), length| {
        (least.min(length), most.max(length))
    });
    #[expect(clippy::cast_possible_truncation, reason = "a share")]
    let end = least + strength as f32 * (most - least);
    let mut body = Box::<UnpackedBody>::default();
    for hull in figure.hulls() {
        let whole = convex(hull.map(cast));
        let kept = clipped(&whole, Vec2::splat(f32::MIN), Vec2::new(end, f32::MAX));
        // A hull that only touches the end has no area.
        if kept.len() < 3 || kept.iter().all(|corner| corner.x >= end) {
            continue;
        }
        // Clipping adds at most one corner; a 33rd one is dropped.
        let corners = kept.iter().take(MAX_HULL_POINTS);
        let points = corners.map(|at| floor.point + along * at.x + across * at.y);
        // There are at most as many hulls as in the figure, and points within its budget.
        let fits = body.push(Joint::Pelvis, points);
        debug_assert!(fits.is_ok(), "a shadow is within the budget of its figure");
    }
    body
}

#[cfg(test)]
mod tests {
    use super::super::tests::{camera, people, seen};
    use super::super::{Fine, FineRenderer};
    use super::*;
    use edgegait_core::camera::Framing;
    use edgegait_core::raster::{Rasterizer, Renderer};
    use edgegait_core::silhouette::Size;

    /// Returns a post 1 m high and 20 cm thick.
    fn post() -> UnpackedBody {
        let mut post = UnpackedBody::default();
        let corners = (0..8_u8).map(|corner| {
            let at = |bit: u8, low: f32, high: f32| if corner >> bit & 1 == 1 { high } else { low };
            Vec3::new(at(0, -0.1, 0.1), at(1, 0.0, 1.0), at(2, -0.1, 0.1))
        });
        post.push(Joint::Pelvis, corners).expect("eight points");
        post
    }

    fn ends(body: &UnpackedBody) -> (Vec3, Vec3) {
        let figure = Figure::at_rest(body);
        figure
            .points()
            .fold((Vec3::MAX, Vec3::MIN), |(low, high), point| {
                (low.min(point), high.max(point))
            })
    }

    #[test]
    fn a_sun_at_45_degrees_casts_a_shadow_as_long_as_the_post_is_high() {
        let post = post();
        let figure = Figure::at_rest(&post);
        let near = |found: Vec3, expected: [f32; 3]| {
            assert!(
                (found - Vec3::from(expected)).length() < 1e-5,
                "{found} {expected:?}"
            );
        };
        // On the walker's left (+X): to the right. In front (+Z): behind.
        let left = Sun::from_degrees(90.0, 45.0).expect("a sun");
        let (low, high) = ends(&shadow_body(&figure, left, &Floor::level(0.0), 1.0));
        near(low, [-1.1, 0.0, -0.1]);
        near(high, [0.1, 0.0, 0.1]);
        let front = Sun::from_degrees(0.0, 45.0).expect("a sun");
        let (low, high) = ends(&shadow_body(&figure, front, &Floor::level(-0.5), 1.0));
        near(low, [-0.1, -0.5, -1.6]);
        near(high, [0.1, -0.5, -0.4]);
        // A quarter of 1.2 m, from the post's left side on.
        let (low, high) = ends(&shadow_body(&figure, left, &Floor::level(0.0), 0.25));
        near(low, [-0.2, 0.0, -0.1]);
        near(high, [0.1, 0.0, 0.1]);
        let nothing = shadow_body(&figure, left, &Floor::level(0.0), 0.0);
        assert!(Figure::at_rest(&nothing).is_empty());
    }

    #[test]
    fn a_shadow_lies_on_a_sloping_floor_along_the_suns_rays() {
        let post = post();
        let figure = Figure::at_rest(&post);
        let floor = Floor {
            point: Vec3::new(0.0, -0.2, 0.3),
            normal: Vec3::new(0.0, 2.0, -1.0).normalize(),
        };
        let sun = Sun::from_degrees(130.0, 35.0).expect("a sun");
        let shadow = shadow_body(&figure, sun, &floor, 1.0);
        let rays = Figure::at_rest(&shadow);
        for at in rays.points() {
            assert!(floor.normal.dot(at - floor.point).abs() < 1e-5);
            let distance = |point: Vec3| (point - at).cross(sun.toward).length();
            assert!(figure.points().any(|point| distance(point) < 1e-5), "{at}");
        }
    }

    #[test]
    fn a_shadow_joins_the_silhouette_as_if_it_were_a_part_of_the_body() {
        // As many of a person's hulls as fit in one body together with their shadows.
        let (body, poses) = &people()[0];
        let whole = Figure::new(body, &poses[2]);
        let mut person = UnpackedBody::default();
        for hull in whole.hulls().take(16) {
            person.push(Joint::Pelvis, hull).expect("fewer than before");
        }
        let figure = Figure::at_rest(&person);
        let sun = Sun::from_degrees(40.0, 30.0).expect("a sun");
        let cast = shadow_body(&figure, sun, &Floor::level(0.0), 1.0);
        let shadow = Figure::at_rest(&cast);
        let mut both = person.clone();
        for hull in shadow.hulls() {
            both.push(Joint::Pelvis, hull).expect("as many again");
        }
        let both = Figure::at_rest(&both);
        for size in Size::ALL {
            // A camera level with the floor does not see the shadow.
            for (angles, expected, least) in [
                ((90.0, 0.0), &figure, 1.0),
                ((60.0, 30.0), &both, 0.92),
                ((300.0, 80.0), &both, 0.92),
            ] {
                let camera = camera(angles, false);
                let (view, size) = (seen(camera, Framing::Height), size);
                let fine = Fine::lay_out(&figure, &[&shadow], view, size).expect("a picture");
                let mut renderer = FineRenderer::new(Rasterizer::Rows, size).expect("binary");
                let drawn = fine.draw_figure(&mut renderer, &figure);
                let (mut picture, before) = drawn.expect("a figure");
                picture.join(&fine.draw(&mut renderer, &shadow).expect("a shadow"));
                let found = fine.frame(&picture, before).expect("a silhouette");
                let mut direct = Renderer::new(Rasterizer::Rows, size);
                let drawing = direct.draw(expected, &camera, Framing::Height, Vec2::ZERO);
                let silhouette = drawing.expect("drawn").frame.silhouette();
                let jaccard = silhouette.jaccard(&found.silhouette);
                println!("{size} {angles:?}: {jaccard}");
                assert!(jaccard >= least, "{size} {angles:?}: {jaccard}");
            }
        }
    }
}
