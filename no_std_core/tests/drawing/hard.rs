//! Tests of figures and cameras that are hard to draw, each with the result of every rasteriser: an
//! image that can be checked by hand, or an error.

use DrawError::{Empty, Flat, NotFinite, TooLarge, TooNear, Vanished};
use edgegait_core::body::{Figure, UnpackedBody};
use edgegait_core::camera::{Camera, Framing, Viewpoint};
use edgegait_core::raster::{DrawError, Rasterizer, Renderer};
use edgegait_core::silhouette::{Silhouette, Size};
use edgegait_core::skeleton::Joint;
use glam::{Vec2, Vec3};

type Hull = Vec<Vec3>;

/// Returns a box between two corners.
fn slab(min: [f32; 3], max: [f32; 3]) -> Hull {
    let corner =
        |corner: usize| Vec3::from([0, 1, 2].map(|axis| [min, max][corner >> axis & 1][axis]));
    (0..8).map(corner).collect()
}

fn body(hulls: &[Hull]) -> UnpackedBody {
    let mut body = UnpackedBody::default();
    for hull in hulls {
        body.push(Joint::Pelvis, hull.iter().copied())
            .expect("within the budget");
    }
    body
}

fn viewpoint(azimuth_deg: f32, elevation_deg: f32) -> Viewpoint {
    Viewpoint::from_degrees(azimuth_deg, elevation_deg).expect("a viewpoint")
}

fn front() -> Camera {
    Camera::orthographic(viewpoint(0.0, 0.0))
}

/// A framing of a pixel a metre, with the origin in the middle: x = 15 and y = 25.
const METRES: Framing = Framing::Fixed {
    centre: Vec3::ZERO,
    pixels_per_metre: 1.0,
};

fn fixed(pixels_per_metre: f32) -> Framing {
    Framing::Fixed {
        centre: Vec3::ZERO,
        pixels_per_metre,
    }
}

const FRAMINGS: [Framing; 3] = [Framing::Height, Framing::Box, METRES];

/// Returns the silhouette of a rasteriser at 50x30, and the share that lies outside.
fn draw(
    rasterizer: Rasterizer,
    hulls: &[Hull],
    camera: &Camera,
    framing: Framing,
) -> Result<(Silhouette, f32), DrawError> {
    let mut renderer = Renderer::new(rasterizer, Size::S50x30);
    let body = body(hulls);
    let drawing = renderer.draw(&Figure::at_rest(&body), camera, framing, Vec2::ZERO)?;
    Ok((drawing.frame.silhouette(), drawing.clipped_share))
}

/// Draws with every rasteriser.
fn drawn(
    hulls: &[Hull],
    camera: &Camera,
    framing: Framing,
) -> Vec<Result<(Silhouette, f32), DrawError>> {
    let all = Rasterizer::ALL.iter();
    all.map(|&rasterizer| draw(rasterizer, hulls, camera, framing))
        .collect()
}

/// Returns a silhouette with rows `rows` and columns `columns` on.
fn block(columns: [u32; 2], rows: [usize; 2]) -> Silhouette {
    let bits = (1 << columns[1]) - (1 << columns[0]);
    let rows: Vec<u64> = (0..50)
        .map(|row| {
            if (rows[0]..rows[1]).contains(&row) {
                bits
            } else {
                0
            }
        })
        .collect();
    Silhouette::from_rows(Size::S50x30, &rows)
}

/// Returns the number of pixels that differ.
fn difference(a: &Silhouette, b: &Silhouette) -> u32 {
    let rows = a.rows().iter().zip(b.rows());
    rows.map(|(a, b)| (a ^ b).count_ones()).sum()
}

/// Returns whether a rasteriser takes one sample, at the centre of a pixel.
fn is_of_centres(rasterizer: Rasterizer) -> bool {
    matches!(rasterizer.name(), "skia" | "rows")
}

#[test]
fn what_is_not_finite_is_refused_wherever_it_stands() {
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        for at in [0, 3, 7] {
            for axis in 0..3 {
                for hull in 0..2 {
                    let mut hulls = [slab([0.0; 3], [1.0; 3]), slab([0.0; 3], [2.0; 3])];
                    hulls[hull][at][axis] = bad;
                    for framing in FRAMINGS {
                        let near = Camera::perspective(viewpoint(30.0, 20.0), Vec3::ZERO, 9.0);
                        for camera in [front(), near.expect("a camera")] {
                            for found in drawn(&hulls, &camera, framing) {
                                assert_eq!(found, Err(NotFinite), "{bad} {at} {axis} {framing:?}");
                            }
                        }
                    }
                }
            }
        }
    }
}

#[test]
fn a_box_of_any_finite_size_fills_the_image_or_is_refused() {
    let all = block([0, 30], [0, 50]);
    let oblique = Camera::orthographic(viewpoint(20.0, 0.0));
    for exponent in -36..38 {
        let reach = 10f32.powi(exponent);
        let hulls = [slab([-reach; 3], [reach; 3])];
        for framing in [Framing::Height, Framing::Box] {
            for camera in [front(), oblique] {
                for found in drawn(&hulls, &camera, framing) {
                    assert_eq!(found.map(|(found, _)| found), Ok(all), "{reach:e}");
                }
            }
        }
    }
    // Twice 1e38, the width of this box, is finite.
    for found in drawn(&[slab([-1e38; 3], [1e38; 3])], &front(), Framing::Box) {
        assert_eq!(found.map(|(found, _)| found), Ok(all));
    }
    // The height of this box is not.
    for framing in [Framing::Height, Framing::Box] {
        for found in drawn(&[slab([-3e38; 3], [3e38; 3])], &front(), framing) {
            assert!(found.is_err(), "{framing:?}");
        }
    }
    // So small that no scale is finite.
    for framing in [Framing::Height, Framing::Box] {
        for found in drawn(&[slab([0.0; 3], [1e-38; 3])], &front(), framing) {
            assert_eq!(found, Err(Flat));
        }
    }
    // At a pixel a metre: too large, or too small to be visible.
    for found in drawn(&[slab([-1e38; 3], [1e38; 3])], &front(), METRES) {
        assert_eq!(found, Err(TooLarge(1e38)));
    }
    for found in drawn(&[slab([0.1; 3], [0.1001; 3])], &front(), METRES) {
        assert_eq!(found, Ok((Silhouette::empty(Size::S50x30), 0.0)));
    }
}

#[test]
fn boxes_of_any_size_are_drawn_in_perspective() {
    // At a distance of ten times its size, its near side fills the image.
    for exponent in -1..5 {
        let reach = 10f32.powi(exponent);
        let hulls = [slab([-reach; 3], [reach; 3])];
        let camera = Camera::perspective(viewpoint(0.0, 0.0), Vec3::ZERO, 10.0 * reach);
        for found in drawn(&hulls, &camera.expect("a camera"), Framing::Box) {
            let found = found.expect("a box").0;
            assert_eq!(found, block([0, 30], [0, 50]), "{reach:e}");
        }
    }
}

#[test]
fn a_board_seen_edge_on_is_refused_or_empty() {
    let board = [slab([0.0; 3], [0.0, 2.0, 2.0])];
    let lying = [slab([0.0; 3], [2.0, 0.0, 2.0])];
    for (hulls, framing, expected) in [
        (&board, Framing::Height, Err(Vanished)),
        (&board, Framing::Box, Err(Flat)),
        (&board, fixed(5.0), Ok(0)),
        (&lying, Framing::Height, Err(Flat)),
        (&lying, Framing::Box, Err(Flat)),
        (&lying, fixed(5.0), Ok(0)),
    ] {
        for found in drawn(hulls, &front(), framing) {
            assert_eq!(
                found.map(|(found, _)| found.area()),
                expected,
                "{framing:?}"
            );
        }
    }
    // From the side it is fully visible: 10 pixels to the left of the middle.
    let side = Camera::orthographic(viewpoint(90.0, 0.0));
    for found in drawn(&board, &side, fixed(5.0)) {
        assert_eq!(found, Ok((block([5, 15], [15, 25]), 0.0)));
    }
}

#[test]
fn slivers_thinner_than_a_pixel_show_where_they_cover_samples() {
    // A tenth of a pixel wide, 20 high: around the centres of column 17, and between them.
    let sliver = |left: f32| [slab([left, 0.0, 0.0], [left + 0.1, 20.0, 0.1])];
    for &rasterizer in Rasterizer::ALL {
        for (left, on) in [(2.45, 20), (2.15, 0), (2.75, 0)] {
            let found = draw(rasterizer, &sliver(left), &front(), METRES);
            let (found, clipped_share) = found.expect("a sliver");
            // For the others, less than half of a pixel is covered.
            let expected = if is_of_centres(rasterizer) { on } else { 0 };
            assert_eq!(
                (found.area(), clipped_share),
                (expected, 0.0),
                "{rasterizer} {left}"
            );
            assert!(on == 0 || found.rows().iter().all(|row| row & !(1 << 17) == 0));
        }
    }
}

#[test]
fn samples_on_an_edge_count_on_the_right_and_on_the_lower_one() {
    // From the centre of column 12 and row 22 to the centre of 17 and 27, and on pixels' corners.
    for (min, max, columns, rows) in [
        ([-2.5, -2.5], [2.5, 2.5], [13, 18], [23, 28]),
        ([-3.0, -3.0], [3.0, 3.0], [12, 18], [22, 28]),
        ([-2.5, -3.0], [3.0, 2.5], [13, 18], [23, 28]),
    ] {
        let hulls = [slab([min[0], min[1], 0.0], [max[0], max[1], 1.0])];
        for &rasterizer in Rasterizer::ALL {
            if is_of_centres(rasterizer) {
                let found = draw(rasterizer, &hulls, &front(), METRES);
                assert_eq!(
                    found,
                    Ok((block(columns, rows), 0.0)),
                    "{rasterizer} {min:?}"
                );
            }
        }
    }
    // A diamond about a pixel's corner with the centres of the 4 pixels around it on its
    // sides: left < x and top < y leave the lower right one.
    let ring = [[0.0, 1.0], [1.0, 0.0], [0.0, -1.0], [-1.0, 0.0]];
    let diamond: Hull = ring.iter().map(|&[x, y]| Vec3::new(x, y, 0.0)).collect();
    let rows = draw(Rasterizer::Rows, &[diamond], &front(), METRES).expect("a diamond");
    // Upper: x = 14.5 on the left edge, 15.5 on the right one; the same below.
    assert_eq!(rows.0, block([15, 16], [24, 26]));
}

#[test]
fn hulls_wholly_and_partly_outside_show_what_is_inside() {
    for (min, max, columns, rows, clipped_share) in [
        // 10 by 10 metres, half of it beyond each side in turn.
        ([-20.0, -5.0], [-10.0, 5.0], [0, 5], [20, 30], 0.5),
        ([10.0, -5.0], [20.0, 5.0], [25, 30], [20, 30], 0.5),
        ([-5.0, 20.0], [5.0, 30.0], [10, 20], [0, 5], 0.5),
        ([-5.0, -30.0], [5.0, -20.0], [10, 20], [45, 50], 0.5),
        // At a corner, a quarter is visible.
        ([10.0, 20.0], [20.0, 30.0], [25, 30], [0, 5], 0.75),
        // Wholly outside.
        ([15.0, -5.0], [25.0, 5.0], [0, 0], [0, 0], 1.0),
        ([-1e6, -5.0], [-1e5, 5.0], [0, 0], [0, 0], 1.0),
        ([-5.0, 1e30], [5.0, 1e31], [0, 0], [0, 0], 1.0),
    ] {
        let hulls = [slab([min[0], min[1], -3.0], [max[0], max[1], 3.0])];
        for found in drawn(&hulls, &front(), METRES) {
            let (found, share) = found.expect("a box");
            assert_eq!(found, block(columns, rows), "{min:?}");
            assert!((share - clipped_share).abs() < 1e-3, "{min:?}: {share}");
        }
    }
    // A hull outside does not disturb one inside.
    let hulls = [
        slab([-2.0, -2.0, 0.0], [2.0, 2.0, 1.0]),
        slab([40.0, 40.0, 0.0], [44.0, 44.0, 1.0]),
    ];
    for found in drawn(&hulls, &front(), METRES) {
        let (found, share) = found.expect("a box");
        assert_eq!(found, block([13, 17], [23, 27]));
        assert!((share - 0.5).abs() < 0.1, "{share}");
    }
    // So far apart that samples of the whole miss both.
    let (near, far) = (slab([0.0; 3], [1.0; 3]), slab([9e3; 3], [9.001e3; 3]));
    for found in drawn(&[near, far], &front(), METRES) {
        assert_eq!(found, Err(Vanished));
    }
}

#[test]
fn points_behind_the_camera_or_nearer_than_ten_centimetres_are_refused() {
    for (distance_m, depth_m) in [(0.5, 0.05), (0.1, -0.35), (0.45, 0.0), (0.54, 0.09)] {
        // The front side lies 0.45 m before the aim.
        let hulls = [slab([-0.2, -1.0, -0.2], [0.2, 1.0, 0.45])];
        let camera = Camera::perspective(viewpoint(0.0, 0.0), Vec3::ZERO, distance_m);
        for framing in FRAMINGS {
            for found in drawn(&hulls, &camera.expect("a camera"), framing) {
                let Err(TooNear(found)) = found else {
                    panic!("{distance_m}: expected to be too near, found {found:?}");
                };
                assert!((found - depth_m).abs() < 1e-6, "{distance_m}: {found}");
            }
        }
    }
    // The camera is inside the body.
    let hulls = [slab([-1.0; 3], [1.0; 3])];
    let camera = Camera::perspective(viewpoint(77.0, 12.0), Vec3::ZERO, 0.3);
    for found in drawn(&hulls, &camera.expect("a camera"), Framing::Height) {
        assert!(matches!(found, Err(TooNear(_))));
    }
}

/// Returns a person of a trunk, a head and two legs.
fn person() -> [Hull; 4] {
    [
        slab([-0.21, 0.83, -0.12], [0.22, 1.43, 0.13]),
        slab([-0.09, 1.45, -0.08], [0.08, 1.71, 0.14]),
        slab([0.05, 0.02, 0.11], [0.19, 0.86, 0.31]),
        slab([-0.17, 0.0, -0.29], [-0.03, 0.85, -0.08]),
    ]
}

#[test]
fn nothing_jumps_straight_above_or_after_a_turn() {
    let seen = |azimuth, elevation| {
        let camera = Camera::orthographic(viewpoint(azimuth, elevation));
        drawn(&person(), &camera, Framing::Height)
            .into_iter()
            .map(|found| found.expect("a person").0)
    };
    for azimuth in [0.0, 33.0, 90.0, 180.0, 270.0] {
        for (near, above) in seen(azimuth, 89.999).zip(seen(azimuth, 90.0)) {
            assert!(difference(&near, &above) <= 2, "{azimuth}");
        }
        for elevation in [0.0, 41.0, 90.0] {
            for turned in [azimuth + 360.0, azimuth - 360.0, azimuth - 7_200.0] {
                assert!(seen(azimuth, elevation).eq(seen(turned, elevation)));
            }
        }
    }
}

#[test]
fn from_behind_a_level_view_is_the_mirror_image() {
    // Framed by a fixed scale; no sample lies on an edge.
    let seen = |azimuth| {
        let camera = Camera::orthographic(viewpoint(azimuth, 0.0));
        let framing = Framing::Fixed {
            centre: Vec3::Y,
            pixels_per_metre: 25.3,
        };
        draw(Rasterizer::Rows, &person(), &camera, framing)
            .expect("a person")
            .0
    };
    for azimuth in [0.0, 35.0, -75.0] {
        let mirrored: Vec<u64> = seen(azimuth)
            .rows()
            .iter()
            .map(|row| row.reverse_bits() >> 34)
            .collect();
        let mirrored = Silhouette::from_rows(Size::S50x30, &mirrored);
        assert_eq!(mirrored, seen(azimuth + 180.0), "{azimuth}");
    }
}

#[test]
fn distances_from_half_a_metre_to_a_kilometre_are_drawn() {
    let aim = Vec3::new(0.0, 0.85, 0.0);
    for angles in [(0.0, 0.0), (90.0, 0.0), (37.0, 41.0)] {
        let viewpoint = viewpoint(angles.0, angles.1);
        let parallel = drawn(&person(), &Camera::orthographic(viewpoint), Framing::Height);
        let mut before = vec![u32::MAX; parallel.len()];
        for distance_m in [1.5, 5.0, 50.0, 1_000.0, 100_000.0] {
            let camera = Camera::perspective(viewpoint, aim, distance_m).expect("a camera");
            let found = drawn(&person(), &camera, Framing::Height);
            for ((found, parallel), before) in found.iter().zip(&parallel).zip(&mut before) {
                let found = found.expect("a person").0;
                let differs = difference(&found, &parallel.expect("a person").0);
                assert!(differs <= *before, "{angles:?} {distance_m}: {differs}");
                assert!(
                    distance_m < 1e3 || differs <= 4,
                    "{angles:?} {distance_m}: {differs}"
                );
                *before = differs;
            }
        }
        // From half a metre before the trunk, the toes are nearer than the head.
        let near = Camera::perspective(viewpoint, aim, 0.5).expect("a camera");
        for found in drawn(&person(), &near, Framing::Height) {
            assert!(matches!(found, Ok(_) | Err(TooNear(_))), "{found:?}");
        }
    }
}

#[test]
fn bodies_of_nothing_of_a_point_and_of_two_have_no_image() {
    let (point, two) = (vec![Vec3::ONE], vec![Vec3::ZERO, Vec3::ONE]);
    for (hulls, framing, expected) in [
        (&[][..], Framing::Height, Err(Empty)),
        (&[], Framing::Box, Err(Empty)),
        (&[], METRES, Err(Empty)),
        (std::slice::from_ref(&point), Framing::Height, Err(Flat)),
        (std::slice::from_ref(&point), Framing::Box, Err(Flat)),
        (std::slice::from_ref(&point), METRES, Ok(0)),
        (std::slice::from_ref(&two), Framing::Height, Err(Vanished)),
        (std::slice::from_ref(&two), Framing::Box, Err(Vanished)),
        (std::slice::from_ref(&two), METRES, Ok(0)),
        // As two hulls of a point each, they have a height too.
        (
            &[vec![Vec3::ZERO], vec![Vec3::ONE]],
            Framing::Height,
            Err(Vanished),
        ),
    ] {
        for found in drawn(hulls, &front(), framing) {
            let found = found.map(|(found, _)| found.area());
            assert_eq!(found, expected, "{hulls:?} {framing:?}");
        }
    }
}
