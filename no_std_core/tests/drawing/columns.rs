//! Tests of the column rasteriser against independent plain f64 code: sampling from the definition,
//! over all pairs of points instead of a hull's edges.

use crate::random::Random;
use edgegait_core::body::{Figure, UnpackedBody};
use edgegait_core::budget::MAX_REACH_PIXELS;
use edgegait_core::camera::Viewpoint;
use edgegait_core::raster::columns::{
    Azimuth, AzimuthError, ColumnRenderer, ElevationImages, FigurePlace,
};
use edgegait_core::raster::{DrawError, Simd};
use edgegait_core::silhouette::Size;
use edgegait_core::skeleton::Joint;
use edgegait_core::template::GeiTally;
use glam::{Vec2, Vec3};

type V3 = [f64; 3];

/// Hulls, and how they are seen.
struct Scene {
    hulls: Vec<Vec<Vec3>>,
    azimuth_deg: f32,
    elevations_deg: Vec<f32>,
    centre: Vec3,
    scale: f32,
    jitter: Vec2,
}

/// Returns the elevations 0, 5, ..., 90.
fn paper() -> Vec<f32> {
    (0..19u8).map(|step| 5.0 * f32::from(step)).collect()
}

fn wide(point: Vec3) -> V3 {
    point.to_array().map(f64::from)
}

fn body_of(hulls: &[Vec<Vec3>]) -> UnpackedBody {
    let mut body = UnpackedBody::default();
    for hull in hulls {
        let pushed = body.push(Joint::Pelvis, hull.iter().copied());
        pushed.expect("within the budget");
    }
    body
}

fn seen_from(azimuth_deg: f32, elevations_deg: &[f32]) -> Azimuth {
    let viewpoint = |&deg: &f32| Viewpoint::from_degrees(azimuth_deg, deg).expect("in range");
    let viewpoints: Vec<Viewpoint> = elevations_deg.iter().map(viewpoint).collect();
    Azimuth::new(&viewpoints).expect("one azimuth")
}

impl Scene {
    fn draw(&self, size: Size, simd: Simd) -> ElevationImages {
        self.draw_body(&body_of(&self.hulls), size, simd)
    }

    fn draw_body(&self, body: &UnpackedBody, size: Size, simd: Simd) -> ElevationImages {
        let azimuth = seen_from(self.azimuth_deg, &self.elevations_deg);
        let place = FigurePlace {
            centre: self.centre,
            pixels_per_metre: self.scale,
            jitter: self.jitter,
        };
        let mut images = ElevationImages::empty(size);
        let figure = Figure::at_rest(body);
        let drawn = ColumnRenderer::with_simd(simd).draw(&figure, &azimuth, &place, &mut images);
        drawn.expect("near points");
        images
    }

    /// Returns the rows of one column at all elevations, sampled from the definition.
    fn expected(&self, size: Size, column: usize) -> Vec<u64> {
        let jitter = [self.jitter.x, self.jitter.y].map(f64::from);
        let (sin_a, cos_a) = f64::from(self.azimuth_deg).to_radians().sin_cos();
        let plane = column as f64 + 0.5 + jitter[0] - size.columns() as f64 / 2.0;
        let mut rows = vec![0u64; self.elevations_deg.len()];
        for hull in &self.hulls {
            let seen: Vec<V3> = hull
                .iter()
                .map(|&point| {
                    let (p, c) = (wide(point), wide(self.centre));
                    let [x, y, z] =
                        [0, 1, 2].map(|axis| (p[axis] - c[axis]) * f64::from(self.scale));
                    [x * cos_a - z * sin_a, y, x * sin_a + z * cos_a]
                })
                .collect();
            let left = seen.iter().filter(|p| p[0] < plane);
            let cuts: Vec<[f64; 2]> = left
                .flat_map(|a| {
                    let right = seen.iter().filter(|p| p[0] >= plane);
                    right.map(move |b| {
                        let share = (plane - a[0]) / (b[0] - a[0]);
                        [1, 2].map(|axis| a[axis] + share * (b[axis] - a[axis]))
                    })
                })
                .collect();
            for (rows, &elevation) in rows.iter_mut().zip(&self.elevations_deg) {
                let (sin_e, cos_e) = f64::from(elevation).to_radians().sin_cos();
                let heights = cuts.iter().map(|[y, w]| y * cos_e - w * sin_e);
                let top =
                    size.rows() as f64 / 2.0 - heights.clone().fold(f64::NEG_INFINITY, f64::max);
                let bottom = size.rows() as f64 / 2.0 - heights.fold(f64::INFINITY, f64::min);
                for row in 0..size.rows() {
                    let centre = row as f64 + 0.5 + jitter[1];
                    *rows |= u64::from(top < centre && centre <= bottom) << row;
                }
            }
        }
        rows
    }

    /// Returns the number of wrong pixels, and of pixels that should be on.
    fn compare(&self, images: &ElevationImages) -> [u32; 2] {
        let mut sums = [0; 2];
        for column in 0..images.size().columns() {
            for (elevation, rows) in self.expected(images.size(), column).into_iter().enumerate() {
                sums[0] += (rows ^ images.rows(elevation, column)).count_ones();
                sums[1] += rows.count_ones();
            }
        }
        sums
    }
}

fn point_within(random: &mut Random, reach: [f64; 3]) -> Vec3 {
    Vec3::from(reach.map(|reach| random.between(-reach, reach) as f32))
}

/// Returns a person-sized heap of 19 hulls of 16 points on ellipsoids, 48 rows tall.
fn body(random: &mut Random) -> Scene {
    let hulls = (0..19)
        .map(|_| {
            let place = point_within(random, [0.25, 0.75, 0.25]);
            let radii = [0; 3].map(|_| random.between(0.03, 0.2) as f32);
            let mut point = || {
                let direction = point_within(random, [1.0; 3]).normalize_or(Vec3::X);
                place + direction * Vec3::from(radii)
            };
            (0..16).map(|_| point()).collect()
        })
        .collect();
    Scene {
        hulls,
        azimuth_deg: random.between(-180.0, 180.0) as f32,
        elevations_deg: paper(),
        centre: point_within(random, [0.05; 3]),
        scale: 25.0,
        jitter: Vec2::ZERO,
    }
}

/// Compares bodies from above the horizon, and from everywhere.
fn bodies(count: usize, seed: u64) -> [u32; 2] {
    let mut random = Random(seed);
    let mut sums = [0; 2];
    for turn in 0..count {
        let mut scene = body(&mut random);
        if turn % 2 == 1 {
            let angles = (0..20).map(|_| random.between(-90.0, 90.0) as f32);
            scene.elevations_deg = angles.chain([90.0, 89.999, 0.0, -90.0]).collect();
            scene.jitter = Vec2::new(0.37, -0.21);
        }
        let images = scene.draw(Size::S50x30, Simd::widest());
        let [wrong, on] = scene.compare(&images);
        sums = [sums[0] + wrong, sums[1] + on];
    }
    println!("{} wrong of {} pixels on", sums[0], sums[1]);
    sums
}

#[test]
fn bodies_are_drawn_as_in_exact_arithmetic() {
    let [wrong, on] = bodies(100, 31);
    assert!(wrong <= 3 && on > 400_000, "{wrong} of {on}");
}

#[test]
#[ignore = "the rate itself: 1,000 bodies, ten seconds"]
fn at_most_one_pixel_of_a_million_is_wrong() {
    let [wrong, on] = bodies(1_000, 32);
    assert!(f64::from(wrong) <= f64::from(on) * 1e-6, "{wrong} of {on}");
}

/// Draws boxes with corners on pixel centres, borders and column planes, often without a volume and
/// often outside the image.
#[test]
fn ties_are_decided_as_tiny_skia_does() {
    let mut random = Random(33);
    for turn in 0..400 {
        let mut coordinate = |reach: f64| random.between(-reach, reach).round() as f32 * 0.5;
        let low = Vec3::new(coordinate(50.0), coordinate(80.0), coordinate(80.0));
        let size = Vec3::new(coordinate(40.0), coordinate(40.0), coordinate(40.0)).abs();
        let corner = |bits: u8| {
            let on = |bit: u8| f32::from(bits >> bit & 1);
            low + size * Vec3::new(on(0), on(1), on(2))
        };
        let scene = Scene {
            hulls: vec![(0..8).map(corner).collect()],
            azimuth_deg: [0.0, 180.0][turn % 2],
            elevations_deg: vec![0.0, 90.0, -90.0],
            centre: Vec3::ZERO,
            scale: 1.0,
            jitter: Vec2::ZERO,
        };
        // x is to the right, y down; the depth towards the camera is down at 90 and up at -90.
        let turned = 1.0 - 2.0 * (turn % 2) as f32;
        let span = |a: f32, b: f32, half: f32| [a.min(b) + half, a.max(b) + half];
        let high = low + size;
        let [left, right] = span(turned * low.x, turned * high.x, 15.0);
        let rows = [
            span(-low.y, -high.y, 25.0),
            span(turned * low.z, turned * high.z, 25.0),
            span(-turned * low.z, -turned * high.z, 25.0),
        ];
        for simd in Simd::available() {
            let images = scene.draw(Size::S50x30, simd);
            for (elevation, [top, bottom]) in rows.into_iter().enumerate() {
                for column in 0..30u8 {
                    let mut expected = 0u64;
                    for row in 0..50u8 {
                        let (x, y) = (f32::from(column) + 0.5, f32::from(row) + 0.5);
                        let is_on = left < x && x <= right && top < y && y <= bottom;
                        expected |= u64::from(is_on) << row;
                    }
                    let found = images.rows(elevation, usize::from(column));
                    assert_eq!(found, expected, "{low} {high} {elevation} {column}");
                }
            }
        }
    }
}

/// Returns a hull of 1 to 13 points: needles, slivers, flat hulls and repeated points, also far
/// outside.
fn odd_hull(random: &mut Random) -> Vec<Vec3> {
    let reach = [0; 3].map(|_| [1.0, 1.0, 0.3, 1e-3, 1e-7, 0.0][random.below(6)]);
    let far = [[0.3; 3], [2.0; 3]][random.below(2)];
    let place = point_within(random, far);
    let count = 1 + random.below(13);
    let mut hull: Vec<Vec3> = Vec::new();
    for _ in 0..count {
        let point = match random.below(5) {
            0 if !hull.is_empty() => hull[random.below(hull.len())],
            _ => place + point_within(random, reach),
        };
        hull.push(point);
    }
    hull
}

#[test]
fn odd_hulls_are_drawn_as_in_exact_arithmetic() {
    let mut random = Random(34);
    let mut sums = [0; 2];
    for _ in 0..300 {
        let scene = Scene {
            hulls: vec![odd_hull(&mut random)],
            azimuth_deg: random.between(0.0, 360.0) as f32,
            elevations_deg: vec![0.0, 30.0, 60.0, 89.999, 90.0],
            centre: Vec3::ZERO,
            scale: 20.0,
            jitter: Vec2::ZERO,
        };
        let images = scene.draw(Size::S50x30, Simd::widest());
        let [wrong, on] = scene.compare(&images);
        sums = [sums[0] + wrong, sums[1] + on];
    }
    assert!(sums[0] <= 2 && sums[1] > 50_000, "{sums:?}");
}

/// Draws scenes with every instruction set, and returns the number of hulls drawn with each.
fn assert_all_sets_agree(scenes: usize, seed: u64) -> usize {
    let mut random = Random(seed);
    let mut hulls = 0;
    for _ in 0..scenes {
        let mut scene = body(&mut random);
        scene.hulls.truncate(13);
        scene.hulls.extend((0..6).map(|_| odd_hull(&mut random)));
        let body = body_of(&scene.hulls);
        for _ in 0..40 {
            scene.azimuth_deg = random.between(-360.0, 360.0) as f32;
            scene.scale = random.between(1.0, 60.0) as f32;
            let portable = scene.draw_body(&body, Size::S50x30, Simd::PORTABLE);
            for simd in Simd::available().skip(1) {
                let wider = scene.draw_body(&body, Size::S50x30, simd);
                assert_eq!(wider, portable, "{simd}");
            }
            hulls += scene.hulls.len();
        }
    }
    hulls
}

#[test]
fn all_sets_of_instructions_draw_the_same() {
    assert!(assert_all_sets_agree(100, 35) >= 76_000);
}

#[test]
#[ignore = "ten seconds"]
fn all_sets_of_instructions_draw_a_million_hulls_alike() {
    assert!(assert_all_sets_agree(1_316, 36) >= 1_000_000);
}

#[test]
fn a_figure_is_all_of_its_hulls_in_the_largest_size_too() {
    // 24 hulls of 32 points, some with more than 64 edges, that each cross 64 columns.
    let mut random = Random(37);
    let mut point = || point_within(&mut random, [1.0; 3]).normalize();
    let hulls = (0..24).map(|_| (0..32).map(|_| point()).collect());
    let mut scene = Scene {
        hulls: hulls.collect(),
        azimuth_deg: 20.0,
        elevations_deg: (0..24u8).map(|step| 3.5 * f32::from(step)).collect(),
        centre: Vec3::new(0.1, 0.0, 0.0),
        scale: 31.0,
        jitter: Vec2::ZERO,
    };
    let together = scene.draw(Size::S64x64, Simd::widest());
    assert_eq!(scene.draw(Size::S64x64, Simd::PORTABLE), together);
    let hulls = std::mem::take(&mut scene.hulls);
    let mut union = [[0; 64]; 24];
    let mut wrong = 0;
    for hull in hulls {
        scene.hulls = vec![hull];
        let alone = scene.draw(Size::S64x64, Simd::widest());
        wrong += scene.compare(&alone)[0];
        for (elevation, union) in union.iter_mut().enumerate() {
            for (column, rows) in union.iter_mut().enumerate() {
                *rows |= alone.rows(elevation, column);
            }
        }
    }
    assert!(wrong <= 3, "{wrong} of 1.5 million");
    for (elevation, union) in union.iter().enumerate() {
        for (column, &rows) in union.iter().enumerate() {
            assert_eq!(together.rows(elevation, column), rows);
        }
    }
}

#[test]
fn an_image_does_not_depend_on_what_is_drawn_with_it() {
    let mut random = Random(39);
    let mut scene = body(&mut random);
    for elevations in [paper(), (-12..12).map(|step| 7.5 * step as f32).collect()] {
        scene.elevations_deg = elevations.clone();
        let together = scene.draw(Size::S50x30, Simd::widest());
        for (at, elevation) in elevations.into_iter().enumerate() {
            scene.elevations_deg = vec![elevation];
            let alone = scene.draw(Size::S50x30, Simd::widest());
            assert_eq!(alone.silhouette(0), together.silhouette(at), "{elevation}");
        }
    }
}

#[test]
fn a_tally_makes_means_of_frames_as_single_additions_do() {
    let mut random = Random(38);
    let mut scene = body(&mut random);
    scene.elevations_deg = (0..24u8).map(|step| 3.5 * f32::from(step)).collect();
    let body = body_of(&scene.hulls);
    let size = Size::S64x44;
    let images: Vec<ElevationImages> = (0..64u8)
        .map(|frame| {
            scene.azimuth_deg = f32::from(frame) * 5.0;
            scene.draw_body(&body, size, Simd::widest())
        })
        .collect();
    for simd in Simd::available() {
        let mut tally = Box::new(GeiTally::with_simd(size, simd));
        assert_eq!(tally.gei(0).pixels(), [0; 64 * 44]);
        for frames in [1, 7, 8, 9, 33, 64] {
            tally.clear();
            for images in &images[..frames] {
                *tally.next_frame().expect("a frame more") = *images;
            }
            for elevation in [0, 15, 16, 23] {
                let gei = tally.gei(elevation);
                for (pixel, &mean) in gei.pixels().iter().enumerate() {
                    let is_on = |it: &&ElevationImages| {
                        it.rows(elevation, pixel % 44) >> (pixel / 44) & 1 == 1
                    };
                    let count = images[..frames].iter().filter(is_on).count();
                    let expected = (255.0 * count as f64 / frames as f64 + 0.5).floor();
                    assert_eq!(f64::from(mean), expected, "{frames} {elevation} {pixel}");
                }
            }
        }
    }
}

#[test]
fn a_tally_holds_4096_frames() {
    let mut random = Random(40);
    let scene = body(&mut random);
    let images = scene.draw(Size::S50x30, Simd::widest());
    let mut tally = Box::new(GeiTally::new(Size::S50x30));
    while let Some(frame) = tally.next_frame() {
        *frame = images;
    }
    assert_eq!(tally.frames(), 4_096);
    for elevation in 0..19 {
        let silhouette = images.silhouette(elevation);
        assert_eq!(
            tally.gei(elevation).pixels(),
            silhouette.to_coverage().pixels()
        );
    }
}

#[test]
fn whether_all_of_a_figure_is_inside_is_known() {
    let hull: Vec<Vec3> = (0..8u8)
        .map(|bits| Vec3::from([0, 1, 2].map(|axis| f32::from(bits >> axis & 1) - 0.5)))
        .collect();
    let is_whole = |scale, x| {
        let scene = Scene {
            hulls: vec![hull.clone()],
            azimuth_deg: 0.0,
            elevations_deg: vec![0.0],
            centre: Vec3::X * x,
            scale,
            jitter: Vec2::ZERO,
        };
        scene.draw(Size::S50x30, Simd::widest()).is_whole()
    };
    // 30 columns, and 50 rows for a cube whose diagonal may point upwards.
    assert!(is_whole(30.0, 0.0) && !is_whole(30.1, 0.0));
    assert!(is_whole(20.0, 0.25) && !is_whole(20.0, 0.26));
    assert!(!is_whole(20.0, 40.0));
}

#[test]
fn what_cannot_be_drawn_is_refused() {
    let points = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z];
    let azimuth = seen_from(0.0, &paper());
    let refusal = |points: &[Vec3], pixels_per_metre, jitter| {
        let body = body_of(&[points.to_vec()]);
        let place = FigurePlace {
            centre: Vec3::ZERO,
            pixels_per_metre,
            jitter,
        };
        let mut images = ElevationImages::empty(Size::S50x30);
        let figure = Figure::at_rest(&body);
        ColumnRenderer::new()
            .draw(&figure, &azimuth, &place, &mut images)
            .err()
    };
    assert_eq!(refusal(&points, 10.0, Vec2::ZERO), None);
    assert_eq!(refusal(&[], 10.0, Vec2::ZERO), Some(DrawError::Empty));
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX] {
        for axis in 0..3 {
            let mut points = points;
            points[2][axis] = bad;
            assert_eq!(
                refusal(&points, 10.0, Vec2::ZERO),
                Some(DrawError::NotFinite)
            );
        }
    }
    for bad in [0.0, -1.0, f32::INFINITY] {
        assert_eq!(
            refusal(&points, bad, Vec2::ZERO),
            Some(DrawError::Scale(bad))
        );
    }
    let beside = Vec2::new(0.6, 0.0);
    assert_eq!(
        refusal(&points, 10.0, beside),
        Some(DrawError::Jitter(beside))
    );
    let reach = 2.0 * MAX_REACH_PIXELS;
    assert_eq!(
        refusal(&points, reach, Vec2::ZERO),
        Some(DrawError::TooLarge(reach))
    );
}

#[test]
fn viewpoints_of_several_azimuths_are_refused() {
    let at = |azimuth, elevation| Viewpoint::from_degrees(azimuth, elevation).expect("in range");
    let refusal = |viewpoints: &[Viewpoint]| Azimuth::new(viewpoints).err();
    assert_eq!(refusal(&[]), Some(AzimuthError::Elevations(0)));
    assert_eq!(
        refusal(&[at(0.0, 0.0); 25]),
        Some(AzimuthError::Elevations(25))
    );
    assert_eq!(
        refusal(&[at(0.0, 0.0), at(5.0, 0.0)]),
        Some(AzimuthError::Differs(1))
    );
    assert_eq!(refusal(&[at(0.0, 0.0), at(360.0, 5.0)]), None);
}
