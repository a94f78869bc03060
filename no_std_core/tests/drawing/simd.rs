//! Tests that images do not depend on the registers: all instruction sets of this processor draw
//! the same bits for random and hostile hulls, and `skia` those of tiny-skia.

use crate::plain::random_angles;
use crate::random::Random;
use edgegait_core::body::{Figure, UnpackedBody};
use edgegait_core::camera::{Camera, Framing, Viewpoint};
use edgegait_core::raster::{Rasterizer, RenderView, Renderer, Simd};
use edgegait_core::silhouette::Size;
use edgegait_core::skeleton::Joint;
use glam::{Vec2, Vec3};

/// The number of kinds of hulls.
const KINDS: usize = 9;

/// Returns a hull of one of the kinds, near `centre`.
fn hull(random: &mut Random, kind: usize, centre: Vec3) -> Vec<Vec3> {
    let points = 1 + random.below(32);
    let between = |random: &mut Random, reach: f64| random.between(-reach, reach) as f32;
    let size = 10f64.powf(random.between(-3.0, 0.3));
    let (a, b) = (
        Vec3::from([0; 3].map(|_| between(random, size))),
        Vec3::from([0; 3].map(|_| between(random, size))),
    );
    let mut all: Vec<Vec3> = (0..points)
        .map(|index| {
            let cell = |random: &mut Random, cells: usize| random.below(cells) as f32;
            match kind {
                // Anywhere.
                0 => centre + Vec3::from([0; 3].map(|_| between(random, size))),
                // A grid of sixteenths and one of halves of these: at 16 pixels a metre, on pixels'
                // edges and centres.
                1 => Vec3::from([0; 3].map(|_| cell(random, 33) / 16.0 - 1.0)),
                2 => Vec3::from([0; 3].map(|_| cell(random, 65) / 32.0 - 1.0)),
                // The corners of a box.
                3 => {
                    let corner = [0, 1, 2].map(|axis| (index >> axis & 1) as f32);
                    centre + Vec3::from(corner) * a
                }
                // On one plane, and on one line.
                4 => centre + a * between(random, 1.0) + b * between(random, 1.0),
                5 => centre + a * between(random, 1.0),
                // A needle.
                6 => {
                    let thick = Vec3::from([0; 3].map(|_| between(random, 1e-4)));
                    centre + 10.0 * a * between(random, 1.0) + thick
                }
                // Far outside.
                7 => 1e3 * a + Vec3::from([0; 3].map(|_| between(random, size))),
                // Of any size.
                _ => {
                    let sizes = [0; 3].map(|_| 10f64.powf(random.between(-30.0, 30.0)));
                    Vec3::from(sizes.map(|size| between(random, size)))
                }
            }
        })
        .collect();
    // Some points occur twice.
    for _ in 0..random.below(4) {
        let (from, to) = (random.below(points), random.below(points));
        all[to] = all[from];
    }
    all
}

/// Draws figures until they have had this many hulls.
fn compare(seed: u64, hulls: usize) {
    let mut random = Random(seed);
    let rasterizers = [Rasterizer::Skia, Rasterizer::Rows, Rasterizer::Rows3x3];
    let mut renderers: Vec<Vec<Renderer>> = rasterizers
        .into_iter()
        .flat_map(|rasterizer| Size::ALL.map(|size| (rasterizer, size)))
        .map(|(rasterizer, size)| {
            Simd::available()
                .map(|simd| Renderer::with_simd(rasterizer, size, simd))
                .collect()
        })
        .collect();
    let (mut had, mut drawn, mut refused) = (0, 0, 0);
    for turn in 0.. {
        if had >= hulls {
            break;
        }
        let mut body = UnpackedBody::default();
        // All hulls of one kind, or of any.
        let kind = random.below(2 * KINDS);
        let centre = Vec3::from([0; 3].map(|_| random.between(-1.0, 1.0) as f32));
        for _ in 0..=random.below(24) {
            let kind = if kind < KINDS {
                kind
            } else {
                random.below(KINDS - 2)
            };
            let hull = hull(&mut random, kind, centre);
            had += 1;
            if body.push(Joint::Pelvis, hull).is_err() {
                break;
            }
        }
        let [azimuth, elevation] = match turn % 3 {
            0 => [90.0 * random.below(5) as f64, 90.0 * random.below(2) as f64],
            _ => random_angles(&mut random, turn),
        };
        let viewpoint = Viewpoint::from_degrees(azimuth as f32, elevation as f32);
        let viewpoint = viewpoint.expect("a viewpoint");
        let distance_m = 10f64.powf(random.between(0.0, 3.0)) as f32;
        let camera = match random.below(2) {
            0 => Camera::orthographic(viewpoint),
            _ => Camera::perspective(viewpoint, centre, distance_m).expect("a camera"),
        };
        let framing = match random.below(4) {
            0 => Framing::Height,
            1 => Framing::Box,
            2 => Framing::Fixed {
                centre: Vec3::ZERO,
                pixels_per_metre: 16.0,
            },
            _ => Framing::Fixed {
                centre,
                pixels_per_metre: 10f64.powf(random.between(0.0, 3.0)) as f32,
            },
        };
        let jitter = match turn % 2 {
            0 => Vec2::ZERO,
            _ => Vec2::from([0; 2].map(|_| random.between(-0.5, 0.5) as f32)),
        };
        let figure = Figure::at_rest(&body);
        let at = random.below(renderers.len());
        let [portable, wider @ ..] = &mut renderers[at][..] else {
            panic!("no registers at all");
        };
        #[cfg(feature = "tiny-skia")]
        if portable.rasterizer() == Rasterizer::Skia {
            let mut oracle = Renderer::new(Rasterizer::TinySkia, portable.size());
            let expected = oracle.draw(&figure, &camera, framing, jitter);
            let found = portable.draw(&figure, &camera, framing, jitter);
            assert!(found == expected, "turn {turn} of kind {kind}: {found:?}");
        }
        let expected = portable.draw(&figure, &camera, framing, jitter);
        for wider in wider {
            let found = wider.draw(&figure, &camera, framing, jitter);
            assert!(found == expected, "turn {turn} of kind {kind}: {found:?}");
        }
        match expected {
            Ok(_) => drawn += 1,
            Err(_) => refused += 1,
        }
    }
    println!("{drawn} figures of {had} hulls drawn and {refused} refused");
    assert!(drawn > refused, "{drawn} drawn, {refused} refused");
}

/// Returns views of all kinds, more than are handled together; the last two have no image.
fn views(random: &mut Random) -> Vec<RenderView> {
    let mut views: Vec<RenderView> = (0..21)
        .map(|turn| {
            let [azimuth, elevation] = random_angles(random, turn).map(|angle| angle as f32);
            let viewpoint = Viewpoint::from_degrees(azimuth, elevation).expect("a viewpoint");
            let distance_m = 10f64.powf(random.between(0.5, 3.0)) as f32;
            let fixed = Framing::Fixed {
                centre: Vec3::ZERO,
                pixels_per_metre: 16.0,
            };
            RenderView {
                camera: match turn % 2 {
                    0 => Camera::orthographic(viewpoint),
                    _ => Camera::perspective(viewpoint, Vec3::Y, distance_m).expect("a camera"),
                },
                framing: [Framing::Height, Framing::Box, fixed][turn % 3],
                jitter: Vec2::new(random.between(-0.5, 0.5) as f32, 0.0),
            }
        })
        .collect();
    views[19].jitter.x = 0.6;
    let viewpoint = views[20].camera.viewpoint();
    let inside = Camera::perspective(viewpoint, Vec3::ZERO, 0.1);
    views[20].camera = inside.expect("a camera");
    views
}

#[test]
fn views_at_once_are_drawn_as_one_by_one() {
    let mut random = Random(53);
    for round in 0..40 {
        let mut body = UnpackedBody::default();
        for _ in 0..=random.below(24) {
            let kind = random.below(KINDS - 2);
            let hull = hull(&mut random, kind, Vec3::ZERO);
            if body.push(Joint::Pelvis, hull).is_err() {
                break;
            }
        }
        let figure = Figure::at_rest(&body);
        let views = views(&mut random);
        for &rasterizer in Rasterizer::ALL {
            let size = Size::ALL[round % 3];
            let mut alone = Renderer::new(rasterizer, size);
            let mut together = Renderer::new(rasterizer, size);
            let (mut seen, mut refused) = (0, 0);
            let all = together.draw_views(&figure, &views, |number, found| {
                assert_eq!(number, seen);
                seen += 1;
                let RenderView {
                    camera,
                    framing,
                    jitter,
                } = views[number];
                let expected = alone.draw(&figure, &camera, framing, jitter);
                assert!(found == expected, "{rasterizer}, view {number}: {found:?}");
                refused += usize::from(found.is_err());
                Ok::<_, ()>(())
            });
            assert_eq!((all, seen), (Ok(()), views.len()));
            assert!((2..views.len()).contains(&refused), "{refused} refused");
        }
        // Drawing stops at the first error of the callback.
        let mut renderer = Renderer::new(Rasterizer::Rows, Size::S50x30);
        let mut seen = 0;
        let stopped = renderer.draw_views(&figure, &views, |number, _| {
            seen += 1;
            if number == 9 { Err(number) } else { Ok(()) }
        });
        assert_eq!((stopped, seen), (Err(9), 10));
    }
}

/// A figure as wide as two windows, whose sides meet in its middle, hulls that reach across them by
/// less than a pixel, and hulls around the centre of a pixel that are hardly there.
#[cfg(feature = "tiny-skia")]
#[test]
fn hulls_across_the_sides_of_windows_have_the_pixels_of_tiny_skia() {
    let mut random = Random(54);
    let camera = Camera::orthographic(Viewpoint::from_degrees(0.0, 0.0).expect("a viewpoint"));
    for size in Size::ALL {
        let rows = size.rows() as f32;
        let mut oracle = Renderer::new(Rasterizer::TinySkia, size);
        let mut renderers: Vec<Renderer> = Simd::available()
            .map(|simd| Renderer::with_simd(Rasterizer::Skia, size, simd))
            .collect();
        for figure in 0..2_000 {
            let mut body = UnpackedBody::default();
            // 1 m high: as many pixels a metre as rows.
            let corners = [[-60.0, 0.0], [-60.0, 1.0], [60.0, 0.0], [60.0, 1.0]];
            for [x, y] in corners.map(|[x, y]: [f32; 2]| [x / rows, y]) {
                let point = |dx: f32| Vec3::new(x + dx, y, dx);
                let hull = [point(0.0), point(0.001), point(-0.001)];
                body.push(Joint::Pelvis, hull).expect("within the budget");
            }
            for _ in 0..6 {
                // Within a pixel of a side, and up to ten pixels away from it.
                let side = random.between(-1.0, 1.0).signum();
                let hull: Vec<Vec3> = (0..4 + random.below(12))
                    .map(|_| {
                        let depth = random.between(0.0, 10.0).powf(random.between(0.3, 2.0));
                        let x = side * (random.between(-1.0, 1.0) - depth.min(10.0));
                        let [y, z] = [0.5, 0.0].map(|middle| middle + random.between(-0.3, 0.3));
                        Vec3::from([x / f64::from(rows), y, z].map(|metres| metres as f32))
                    })
                    .collect();
                body.push(Joint::Pelvis, hull).expect("within the budget");
            }
            let centre = [5, 10].map(|first| (first + random.below(20)) as f64 + 0.5);
            let size = 10f64.powf(random.between(-5.0, -2.0));
            let hull: Vec<Vec3> = (0..8)
                .map(|_| {
                    let [x, y] = centre.map(|centre| centre + random.between(-size, size));
                    let z = random.between(-size, size);
                    Vec3::from([x, y, z].map(|pixels| (pixels / f64::from(rows)) as f32))
                })
                .collect();
            body.push(Joint::Pelvis, hull).expect("within the budget");
            let posed = Figure::at_rest(&body);
            let expected = oracle.draw(&posed, &camera, Framing::Height, Vec2::ZERO);
            for renderer in &mut renderers {
                let found = renderer.draw(&posed, &camera, Framing::Height, Vec2::ZERO);
                assert!(found == expected, "{size:?}, figure {figure}: {found:?}");
            }
        }
    }
}

#[test]
fn all_instruction_sets_draw_the_same_bits() {
    compare(51, 150_000);
}

#[test]
#[ignore = "two minutes"]
fn all_instruction_sets_draw_the_same_bits_of_ten_million_hulls() {
    compare(52, 10_000_000);
}
