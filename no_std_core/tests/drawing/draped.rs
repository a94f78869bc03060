//! Tests of draped hulls against rigid hulls with their points in the same places, and of rolled
//! cameras against plain f64 code.

use crate::plain::{dot, image_axes, random_angles, random_quaternion, single};
use crate::random::Random;
use edgegait_core::body::{Figure, OverBudget, UnpackedBody};
use edgegait_core::camera::{Camera, Framing, Viewpoint};
use edgegait_core::pose::{ModelPose, Pose};
use edgegait_core::raster::columns::{self, Azimuth, AzimuthError, ElevationImages, FigurePlace};
use edgegait_core::raster::{DrawError, Rasterizer, Renderer, Simd};
use edgegait_core::silhouette::{Silhouette, Size};
use edgegait_core::skeleton::{JOINTS, Joint, Skeleton};
use glam::{Mat3, Quat, Vec2, Vec3};

/// The points of a hull, each with its joint.
type Hung = Vec<(Joint, Vec3)>;

/// Rigid and draped hulls.
struct Dressed {
    hulls: Vec<(bool, Hung)>,
}

fn between(random: &mut Random, reach: f64) -> Vec3 {
    single([0; 3].map(|_| random.between(-reach, reach)))
}

fn some_joint(random: &mut Random) -> Joint {
    Joint::from_index(1 + random.below(JOINTS - 1)).expect("a joint")
}

impl Dressed {
    /// Returns up to 4 draped hulls among rigid ones: solid, flat, or of a few points.
    fn random(random: &mut Random) -> Self {
        let draped = 1 + random.below(4);
        let hulls = (0..draped + random.below(6)).map(|hull| {
            let is_draped = hull < draped;
            let points = match random.below(4) {
                0 => random.below(6),
                1 => 32,
                _ => 4 + random.below(29),
            };
            let joint = some_joint(random);
            let is_flat = random.below(5) == 0;
            let points = (0..points).map(|_| {
                let on = if is_draped { some_joint(random) } else { joint };
                let mut point = between(random, 0.4);
                if is_flat {
                    point.z = 0.0;
                }
                (on, point)
            });
            (is_draped, points.collect())
        });
        let mut hulls: Vec<_> = hulls.collect();
        let last = hulls.len() - 1;
        hulls.swap(0, random.below(last + 1));
        Self { hulls }
    }

    fn body(&self) -> UnpackedBody {
        let mut body = UnpackedBody::default();
        for (is_draped, points) in &self.hulls {
            let pushed = if *is_draped {
                body.push_draped(points.iter().copied())
            } else {
                push_rigid(&mut body, points)
            };
            pushed.expect("within the budget");
        }
        body
    }

    /// Returns the body with its draped hulls as rigid hulls of the pelvis, at `places`.
    fn where_they_are(&self, places: &[Vec<Vec3>]) -> UnpackedBody {
        let mut body = UnpackedBody::default();
        for ((is_draped, points), places) in self.hulls.iter().zip(places) {
            let pushed = if *is_draped {
                body.push(Joint::Pelvis, places.iter().copied())
            } else {
                push_rigid(&mut body, points)
            };
            pushed.expect("within the budget");
        }
        body
    }
}

fn push_rigid(body: &mut UnpackedBody, points: &Hung) -> Result<(), OverBudget> {
    let joint = points.first().map_or(Joint::Pelvis, |(joint, _)| *joint);
    body.push(joint, points.iter().map(|(_, point)| *point))
}

/// Returns a pose with every joint anywhere, except the pelvis, which is at the origin.
fn random_pose(random: &mut Random) -> ModelPose {
    let skeleton = Skeleton {
        offsets: [Vec3::ZERO; JOINTS],
    };
    let mut pose = ModelPose::new(&skeleton, &Pose::REST);
    for joint in 1..JOINTS {
        pose.positions[joint] = between(random, 0.5);
        let turn = random_quaternion(random).map(|c| c as f32);
        pose.orientations[joint] = Mat3::from_quat(Quat::from_array(turn));
    }
    if random.below(6) == 0 {
        // All in one plane, so that flat hulls stay flat.
        pose.orientations = [Mat3::IDENTITY; JOINTS];
        for place in &mut pose.positions {
            place.z = 0.0;
        }
    }
    pose
}

fn random_camera(random: &mut Random, frame: usize) -> Camera {
    let [azimuth, elevation] = random_angles(random, frame);
    let viewpoint = Viewpoint::from_degrees(azimuth as f32, elevation as f32).expect("in range");
    let viewpoint = match frame % 3 {
        0 => viewpoint.rolled(random.between(-180.0, 180.0) as f32),
        _ => viewpoint,
    };
    match frame % 4 {
        3 => Camera::perspective(viewpoint, between(random, 0.2), 4.0).expect("a camera"),
        _ => Camera::orthographic(viewpoint),
    }
}

fn places(figure: &Figure<'_>) -> Vec<Vec<Vec3>> {
    figure.hulls().map(Iterator::collect).collect()
}

#[test]
fn each_point_of_a_draped_hull_goes_where_its_joint_takes_it() {
    let mut random = Random(31);
    let mut worst = 0.0f64;
    for _ in 0..200 {
        let (dressed, pose) = (Dressed::random(&mut random), random_pose(&mut random));
        let body = dressed.body();
        let figure = Figure::new(&body, &pose);
        for ((_, points), places) in dressed.hulls.iter().zip(places(&figure)) {
            assert_eq!(points.len(), places.len());
            for ((joint, point), place) in points.iter().zip(places) {
                let turn = pose.orientations[joint.index()].to_cols_array_2d();
                let at = pose.positions[joint.index()].to_array();
                let point = point.to_array().map(f64::from);
                for axis in 0..3 {
                    let turned: f64 = (0..3).map(|k| f64::from(turn[k][axis]) * point[k]).sum();
                    let expected = f64::from(at[axis]) + turned;
                    worst = worst.max((f64::from(place[axis]) - expected).abs());
                }
            }
        }
    }
    // A few roundings of numbers below 2.
    assert!(worst < 1e-6, "{worst}");
}

#[test]
fn a_draped_hull_is_drawn_as_a_rigid_one_that_has_its_points_where_they_are() {
    let mut random = Random(32);
    let mut renderers: Vec<Renderer> = Rasterizer::ALL
        .iter()
        .flat_map(|&rasterizer| {
            Simd::available().map(move |simd| Renderer::with_simd(rasterizer, Size::S50x30, simd))
        })
        .collect();
    let mut drawn = 0;
    for _ in 0..150 {
        let dressed = Dressed::random(&mut random);
        let body = dressed.body();
        // One figure through all poses, so that remains of an earlier pose would show.
        let mut figure = Figure::at_rest(&body);
        for frame in 0..4 {
            let pose = random_pose(&mut random);
            figure.update(&pose);
            let rigid = dressed.where_they_are(&places(&figure));
            let expected = Figure::new(&rigid, &pose);
            let camera = random_camera(&mut random, frame);
            let framing = match frame % 3 {
                0 => Framing::Box,
                1 => Framing::Height,
                _ => Framing::Fixed {
                    centre: Vec3::ZERO,
                    pixels_per_metre: 25.0,
                },
            };
            for renderer in &mut renderers {
                let found = renderer.draw(&figure, &camera, framing, Vec2::ZERO);
                let found = found.map(|it| (*it.frame, it.clipped_share));
                let expected = renderer.draw(&expected, &camera, framing, Vec2::ZERO);
                let expected = expected.map(|it| (*it.frame, it.clipped_share));
                drawn += usize::from(found.is_ok());
                assert_eq!(found, expected, "{}", renderer.rasterizer());
            }
        }
    }
    assert!(drawn > 400 * renderers.len(), "{drawn}");
}

#[test]
fn columns_draw_it_as_the_rigid_one() {
    let mut random = Random(33);
    let mut pixels = 0;
    for _ in 0..100 {
        let dressed = Dressed::random(&mut random);
        let (body, pose) = (dressed.body(), random_pose(&mut random));
        let figure = Figure::new(&body, &pose);
        let rigid = dressed.where_they_are(&places(&figure));
        let expected = Figure::new(&rigid, &pose);
        let viewpoints = [0.0, 15.0, 40.0, 90.0]
            .map(|elevation| Viewpoint::from_degrees(35.0, elevation).expect("in range"));
        let azimuth = Azimuth::new(&viewpoints).expect("one azimuth");
        let place = FigurePlace {
            centre: Vec3::ZERO,
            pixels_per_metre: 25.0,
            jitter: Vec2::new(0.1, -0.2),
        };
        for simd in Simd::available() {
            let draw = |figure: &Figure<'_>| {
                let mut images = ElevationImages::empty(Size::S64x44);
                let drawn = columns::ColumnRenderer::with_simd(simd)
                    .draw(figure, &azimuth, &place, &mut images)
                    .map(|()| images);
                drawn.map(|images| [0, 1, 2, 3].map(|at| images.silhouette(at)))
            };
            let found = draw(&figure);
            assert_eq!(found, draw(&expected));
            if let Ok(found) = found {
                pixels += found.iter().map(Silhouette::area).sum::<u32>();
            }
        }
    }
    assert!(pixels > 10_000, "{pixels}");
}

#[test]
fn a_draped_hull_at_rest_is_the_hull_of_its_points_as_they_are() {
    let mut random = Random(34);
    let mut renderer = Renderer::new(Rasterizer::Rows, Size::S50x30);
    for frame in 0..50 {
        let points: Hung = (0..20)
            .map(|_| (some_joint(&mut random), between(&mut random, 0.5)))
            .collect();
        let (mut draped, mut rigid) = (UnpackedBody::default(), UnpackedBody::default());
        draped
            .push_draped(points.iter().copied())
            .expect("one hull");
        let own = points.iter().map(|(_, point)| *point);
        rigid.push(Joint::Head, own).expect("one hull");
        let camera = random_camera(&mut random, frame);
        let mut draw = |body: &UnpackedBody| {
            let figure = Figure::at_rest(body);
            let drawn = renderer.draw(&figure, &camera, Framing::Height, Vec2::ZERO);
            *drawn.expect("a figure").frame
        };
        assert_eq!(draw(&draped), draw(&rigid));
    }
}

#[test]
fn a_draped_hull_that_is_torn_to_nowhere_is_refused() {
    let corners = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z];
    let joints = [
        Joint::LeftShank,
        Joint::RightShank,
        Joint::Spine,
        Joint::Pelvis,
    ];
    let mut body = UnpackedBody::default();
    body.push_draped(joints.into_iter().zip(corners))
        .expect("one hull");
    let mut random = Random(35);
    let camera = random_camera(&mut random, 1);
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let mut pose = random_pose(&mut random);
        pose.positions[Joint::RightShank.index()].y = bad;
        for &rasterizer in Rasterizer::ALL {
            let mut renderer = Renderer::new(rasterizer, Size::S50x30);
            let figure = Figure::new(&body, &pose);
            let drawn = renderer.draw(&figure, &camera, Framing::Height, Vec2::ZERO);
            assert_eq!(drawn.err(), Some(DrawError::NotFinite));
        }
    }
}

#[test]
fn a_rolled_camera_turns_the_image_the_other_way() {
    let mut random = Random(36);
    let mut worst = 0.0f64;
    for frame in 0..500 {
        let [azimuth, elevation] = random_angles(&mut random, frame);
        let roll = random.between(-400.0, 400.0) as f32;
        let upright = Viewpoint::from_degrees(azimuth as f32, elevation as f32).expect("in range");
        let rolled = Camera::orthographic(upright.rolled(roll));
        let (right, up) = image_axes(azimuth, elevation);
        let point = [0; 3].map(|_| f64::from(random.between(-1.0, 1.0) as f32));
        // The image turns counterclockwise by the angle.
        let (sin, cos) = f64::from(roll).to_radians().sin_cos();
        let (x, y) = (dot(right, point), dot(up, point));
        let found = rolled.project(single(point));
        worst = worst.max((f64::from(found.x) - (cos * x - sin * y)).abs());
        worst = worst.max((f64::from(found.y) - (sin * x + cos * y)).abs());
        assert_eq!(rolled.viewpoint().toward(), upright.toward());
    }
    assert!(worst < 4e-6, "{worst}");
}

#[test]
fn a_camera_that_is_rolled_by_whole_turns_is_not_rolled() {
    let viewpoint = Viewpoint::from_degrees(33.0, 21.0).expect("in range");
    for roll in [0.0, -0.0, 360.0, -720.0] {
        assert_eq!(viewpoint.rolled(roll), viewpoint);
    }
    // A quarter clockwise: the head of a figure points to the left.
    let quarter = Camera::orthographic(
        Viewpoint::from_degrees(0.0, 0.0)
            .expect("in range")
            .rolled(90.0),
    );
    assert_eq!(quarter.project(Vec3::Y), -Vec2::X);
    assert_eq!(quarter.project(Vec3::X), Vec2::Y);
}

#[test]
fn columns_refuse_cameras_whose_right_is_not_level_or_whose_up_is_down() {
    let at = |elevation| Viewpoint::from_degrees(40.0, elevation).expect("in range");
    for roll in [10.0, 90.0, 180.0, f32::NAN] {
        let viewpoints = [at(20.0), at(20.0).rolled(roll)];
        assert_eq!(
            Azimuth::new(&viewpoints),
            Err(AzimuthError::Rolled(1)),
            "{roll}"
        );
    }
    assert!(Azimuth::new(&[at(20.0).rolled(360.0)]).is_ok());
    // From straight above a roll is another azimuth.
    assert!(Azimuth::new(&[at(90.0).rolled(30.0)]).is_ok());
}

#[test]
fn a_roll_that_is_no_number_draws_nothing() {
    let mut body = UnpackedBody::default();
    body.push(Joint::Pelvis, [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z])
        .expect("one hull");
    let viewpoint = Viewpoint::from_degrees(0.0, 0.0).expect("in range");
    for bad in [f32::NAN, f32::INFINITY] {
        let camera = Camera::orthographic(viewpoint.rolled(bad));
        let mut renderer = Renderer::new(Rasterizer::Rows, Size::S50x30);
        let drawn = renderer.draw(
            &Figure::at_rest(&body),
            &camera,
            Framing::Height,
            Vec2::ZERO,
        );
        assert_eq!(drawn.err(), Some(DrawError::NotFinite));
    }
}
