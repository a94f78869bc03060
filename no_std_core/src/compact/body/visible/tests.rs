use super::super::{BodyScale, CompactBody, CompactCarrier, CompactHull};
use super::*;
use crate::camera::Viewpoint;
use crate::pose::ModelPose;
use glam::{Mat3, Quat};

/// Returns a generator of a fixed sequence of numbers, -1 to 1 (Roberts 2018).
fn numbers() -> impl FnMut() -> f32 {
    let mut sum = 0.0f32;
    move || {
        sum = (sum + 0.618_034).fract();
        let mixed = (sum * 97.31).fract();
        2.0 * mixed - 1.0
    }
}

/// Returns a hull of the first joint, whose points lie between these units along each axis.
fn alone(bounds: [i8; 2], is_image: bool) -> CompactHull {
    CompactHull {
        carrier: CompactCarrier(0),
        is_image,
        points_end: 0,
        facets_end: 0,
        bounds: [bounds; 3],
    }
}

/// Returns a pose that turns the first joint.
fn turned(turn: Mat3) -> ModelPose {
    let mut pose = ModelPose::REST;
    pose.orientations[0] = turn;
    pose
}

/// Returns how many triangles of random points in a box of half this size, in a body of this reach,
/// the draft leaves open and decides, and asserts that it decides as floats do.
fn told(reach: f32, half: f32, is_image: bool) -> [usize; 2] {
    let (mut number, mut counts) = (numbers(), [0; 2]);
    let scale = BodyScale {
        step: 0.001,
        reach: reach as u16,
        unit: reach as u16 / 127 + 1,
    };
    // Away from the joint as far as the reach allows.
    let middle = reach - half;
    let [least, most] = [middle - half, middle + half].map(|steps| steps / f32::from(scale.unit));
    let hull = alone([least.floor() as i8, most.ceil() as i8], is_image);
    for round in 0..40 {
        let mut points = [[0; 3]; MAX_HULL_POINTS];
        for coordinate in points.as_flattened_mut() {
            *coordinate = (middle + half * number()) as i16;
        }
        // Every third time, all points are in a plane that is seen edge-on except for rounding.
        if round % 3 == 0 {
            points.iter_mut().for_each(|point| point[0] = middle as i16);
        }
        let body = CompactBody::<0, 0>::EMPTY;
        let turn = Quat::from_xyzw(number(), number(), number(), number()).normalize();
        let turn = if round % 3 == 0 { Quat::IDENTITY } else { turn };
        let place = turned(Mat3::from_quat(turn));
        let hull = PosedHull {
            hull: &hull,
            pose: &place,
            scale,
            points: &points,
            facets: &[],
        };
        let azimuth = if round % 3 == 0 {
            0.0
        } else {
            180.0 * number()
        };
        let viewpoint = Viewpoint::from_degrees(azimuth, 60.0 * number());
        let camera = Camera::orthographic(viewpoint.expect("a viewpoint"));
        let posed = body.posed(&ModelPose::REST);
        let sight = CompactSight::new(&posed, &camera);
        let mut seen = SeenHull::new(&sight);
        let toward = hull.place().direction(sight.seen_from);
        let drafted = seen.draft(&hull, toward).expect("a rotation");
        for a in 0..10u8 {
            for (b, c) in [(11, 12), (13, 17), (21, 30), (12, 31)] {
                let corners = FacetCorners::from_numbers([a, b, c]);
                let off = error_of(&seen, &drafted, &hull, corners);
                assert!(off <= 0.0, "{off} {hull:?} {corners:?}");
                let side = turn_of(&seen, &drafted, corners);
                counts[usize::from(side.is_some())] += 1;
                if let Some(is_seen) = side {
                    let eye = FacetEye::Toward(toward);
                    assert_eq!(is_seen, eye.sees(&hull, corners), "{hull:?} {corners:?}");
                }
            }
        }
    }
    counts
}

/// Returns whether a facet is seen if the draft tells it, and asserts that its error is within the
/// greatest one.
fn turn_of(seen: &SeenHull<'_>, scale: &DraftScale, corners: FacetCorners) -> Option<bool> {
    let sides = corners.sides(&seen.sketch.places);
    let (turn, error) = (turn(sides) ^ corners.turned(), scale.error(sides));
    assert!(
        error <= scale.tolerance + 3 * scale.error / 256,
        "{corners:?}"
    );
    (turn.abs() > error).then_some(turn > 0)
}

/// Returns by how much the turn of a facet is farther from the exact one than the draft's errors
/// allow, square units.
fn error_of(
    seen: &SeenHull<'_>,
    scale: &DraftScale,
    hull: &PosedHull<'_>,
    corners: FacetCorners,
) -> f64 {
    let viewpoint = seen.sight.camera.viewpoint();
    let units = f64::from(scale.units) / 65_536.0;
    let places = corners.numbers().map(|number| {
        let point =
            (Vec3::from(hull.points[number].map(f32::from)) * hull.step().signum()).as_dvec3();
        [viewpoint.right(), viewpoint.up()]
            .map(|axis| units * hull.place().direction(axis).as_dvec3().dot(point))
    });
    let [a, b, c] = places;
    let exact = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    let sides = corners.sides(&seen.sketch.places);
    (f64::from(turn(sides)) - exact).abs() - f64::from(scale.error(sides))
}

#[test]
fn what_a_draft_tells_is_what_floats_say() {
    for reach in [3.0, 40.0, 450.0, 5_000.0, 32_767.0] {
        for (share, is_image) in [(1.0, false), (1.0, true), (0.1, false), (0.001, true)] {
            let [untold, told] = told(reach, share * reach, is_image);
            // Floats have to tell what is small and far from its joint.
            let is_told = told > untold || share < 0.1 || share * reach < 3.0;
            assert!(is_told, "{reach}: {untold} untold, {told} told");
        }
    }
}

#[test]
fn a_frame_that_is_not_turned_alone_has_no_draft() {
    let (pose, camera) = (
        ModelPose::REST,
        Camera::orthographic(Viewpoint::from_degrees(30.0, 20.0).expect("a viewpoint")),
    );
    let body = CompactBody::<0, 0>::EMPTY;
    let posed = body.posed(&pose);
    let sight = CompactSight::new(&posed, &camera);
    let mut seen = SeenHull::new(&sight);
    let hull = alone([-1, 1], false);
    let mut drafted = |turn: Mat3| {
        let pose = turned(turn);
        let hull = PosedHull {
            hull: &hull,
            pose: &pose,
            scale: BodyScale::NONE,
            points: &[],
            facets: &[],
        };
        let toward = hull.place().direction(sight.seen_from);
        seen.draft(&hull, toward).is_some()
    };
    assert!(drafted(Mat3::IDENTITY));
    assert!(!drafted(1.000_01 * Mat3::IDENTITY));
    assert!(!drafted(Mat3::from_diagonal(Vec3::new(1.0, 1.0, -1.0))));
    assert!(!drafted(Mat3::from_diagonal(Vec3::splat(f32::NAN))));
}
