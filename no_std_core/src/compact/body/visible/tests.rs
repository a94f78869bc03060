use super::super::CompactBody;
use super::*;
use crate::body::JointPlace;
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

/// Returns how many triangles of random points the draft leaves open and decides, and asserts that
/// it decides as floats do.
fn told(reach: f32, is_image: bool) -> [usize; 2] {
    let (mut number, mut counts) = (numbers(), [0; 2]);
    for round in 0..40 {
        let mut points = [[0; 3]; MAX_HULL_POINTS];
        for coordinate in points.as_flattened_mut() {
            *coordinate = (reach * number()) as i16;
        }
        // Every third time, all points are in a plane that is seen edge-on except for rounding.
        if round % 3 == 0 {
            points.iter_mut().for_each(|point| point[0] = 0);
        }
        let mut body = CompactBody::<0, 0>::EMPTY;
        body.scale.reach = reach as u16;
        let turn = Quat::from_xyzw(number(), number(), number(), number()).normalize();
        let turn = if round % 3 == 0 { Quat::IDENTITY } else { turn };
        let hull = PosedHull {
            place: JointPlace {
                turn: Mat3::from_quat(turn),
                offset: Vec3::new(number(), number(), number()),
            },
            is_draped: false,
            step: Vec3::new(if is_image { -0.001 } else { 0.001 }, 0.001, 0.001),
            points: &points,
            facets: &[],
            bounds: [[0; 2]; 3],
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
        let toward = hull.place.direction(sight.seen_from);
        assert!(seen.draft(&hull, toward));
        for a in 0..10u8 {
            for (b, c) in [(11, 12), (13, 17), (21, 30), (12, 31)] {
                let corners = FacetCorners::from_numbers([a, b, c]);
                let side = turn_of(&seen, corners);
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

fn turn_of(seen: &SeenHull<'_>, corners: FacetCorners) -> Option<bool> {
    let (turn, tolerance) = (turn(&seen.points, corners), seen.scale.tolerance);
    let is_clear = turn.abs() > tolerance;
    is_clear.then_some((turn.cast_unsigned() ^ corners.turn()).cast_signed() >= 0)
}

#[test]
fn what_a_draft_tells_is_what_floats_say() {
    for reach in [3.0, 40.0, 450.0, 5_000.0, 32_767.0] {
        for is_image in [false, true] {
            let [untold, told] = told(reach, is_image);
            assert!(told > untold, "{reach}: {untold} untold, {told} told");
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
    let mut drafted = |turn: Mat3| {
        let hull = PosedHull {
            place: JointPlace {
                turn,
                offset: Vec3::ZERO,
            },
            is_draped: false,
            step: Vec3::ONE,
            points: &[],
            facets: &[],
            bounds: [[0; 2]; 3],
        };
        seen.draft(&hull, hull.place.direction(sight.seen_from))
    };
    assert!(drafted(Mat3::IDENTITY));
    assert!(!drafted(1.000_01 * Mat3::IDENTITY));
    assert!(!drafted(Mat3::from_diagonal(Vec3::new(1.0, 1.0, -1.0))));
    assert!(!drafted(Mat3::from_diagonal(Vec3::splat(f32::NAN))));
}
