//! Tests of framings, lenses, sizes and sample jitter against independent plain f64 code. Framing
//! by height has its own tests in `oracle.rs`.

use crate::plain::*;
use crate::random::Random;
use edgegait_core::body::{Figure, UnpackedBody};
use edgegait_core::camera::{Camera, Framing, Viewpoint};
use edgegait_core::raster::{Rasterizer, Renderer};
use edgegait_core::silhouette::Size;
use edgegait_core::skeleton::Joint;
use glam::{Vec2, Vec3};

/// The camera, size and jitter of a comparison.
#[derive(Clone, Copy)]
struct Scene {
    angles: V2,
    aim: V3,
    /// The camera's distance, metres; without one, rays are parallel.
    distance_m: Option<f64>,
    size: Size,
    jitter: V2,
}

impl Scene {
    fn random(random: &mut Random, frame: usize, is_perspective: bool) -> Self {
        let single = |value: f64| f64::from(value as f32);
        Self {
            angles: random_angles(random, frame),
            // Near the bodies.
            aim: [3.0, 0.9, -2.0].map(|c| single(c + random.between(-0.3, 0.3))),
            distance_m: is_perspective.then(|| single(random.between(2.5, 8.0))),
            size: Size::ALL[frame % 3],
            jitter: [0; 2].map(|_| single(random.between(-0.5, 0.5))),
        }
    }

    fn camera(&self) -> Camera {
        let [azimuth, elevation] = self.angles.map(|angle| angle as f32);
        let viewpoint = Viewpoint::from_degrees(azimuth, elevation).expect("a viewpoint");
        match self.distance_m {
            None => Camera::orthographic(viewpoint),
            Some(distance_m) => {
                let camera = Camera::perspective(viewpoint, single(self.aim), distance_m as f32);
                camera.expect("a camera")
            }
        }
    }

    /// Projects a point to the image, metres to the right and up from where the aim appears.
    fn project(&self, point: V3) -> V2 {
        let (right, up) = image_axes(self.angles[0], self.angles[1]);
        let from_aim: V3 = std::array::from_fn(|axis| point[axis] - self.aim[axis]);
        let [x, y] = [dot(right, from_aim), dot(up, from_aim)];
        let Some(distance_m) = self.distance_m else {
            return [x, y];
        };
        // The ray from the eye through the point meets the plane through the aim.
        let toward = [
            right[1] * up[2] - right[2] * up[1],
            right[2] * up[0] - right[0] * up[2],
            right[0] * up[1] - right[1] * up[0],
        ];
        let share = distance_m / (distance_m - dot(toward, from_aim));
        [x * share, y * share]
    }
}

/// Returns the smallest and largest coordinates.
fn bounds(hulls: &[Vec<V2>]) -> [V2; 2] {
    let all = || hulls.iter().flatten();
    let fold = |axis: usize, pick: fn(f64, f64) -> f64| {
        all().map(|p| p[axis]).reduce(pick).expect("a point")
    };
    [
        [fold(0, f64::min), fold(1, f64::min)],
        [fold(0, f64::max), fold(1, f64::max)],
    ]
}

/// Returns whether a point lies in any hull.
fn covers(hulls: &[Vec<V2>], at: V2) -> bool {
    hulls.iter().any(|hull| is_inside(hull, at))
}

/// Returns how many of `4 x 4` samples a pixel lie in any hull, within these bounds.
fn area(hulls: &[Vec<V2>], [min, max]: [V2; 2]) -> f64 {
    let steps = |axis: usize| {
        let first = (4.0 * min[axis]).floor() as i64;
        (first..(4.0 * max[axis]).ceil() as i64).map(|step| (step as f64 + 0.5) / 4.0)
    };
    let mut count = 0.0;
    for y in steps(1) {
        for x in steps(0) {
            count += f64::from(covers(hulls, [x, y]));
        }
    }
    count
}

/// The result of a comparison over many frames for one rasteriser.
#[derive(Debug)]
struct Found {
    rasterizer: Rasterizer,
    frames: f64,
    differing: f64,
    on: f64,
    /// Figures that lie partly outside.
    across: f64,
    outside: f64,
    /// The greatest error of a clipped share.
    share_error: f64,
}

impl Found {
    fn new(rasterizer: Rasterizer) -> Self {
        Self {
            rasterizer,
            frames: 0.0,
            differing: 0.0,
            on: 0.0,
            across: 0.0,
            outside: 0.0,
            share_error: 0.0,
        }
    }

    /// Returns the share of on-pixels that differ from samples at the centres.
    fn error(&self) -> f64 {
        self.differing / self.on
    }

    /// Returns the largest acceptable [`Self::error`].
    fn tolerance(&self) -> f64 {
        match self.rasterizer {
            // tiny-skia truncates coordinates to 1/64 pixel.
            Rasterizer::Skia => 0.006,
            // Half of a pixel's area may be covered without its centre.
            #[cfg(feature = "tiny-skia")]
            Rasterizer::SkiaAa => 0.045,
            Rasterizer::Rows => 2e-5,
            Rasterizer::Rows3x3 => 0.02,
            other => panic!("no tolerance for {other}"),
        }
    }
}

/// Draws random people with every rasteriser, and samples them in f64. `framing` returns the core's
/// framing, and the same as a map from image metres to pixels: scales to the right and up, and
/// where the aim appears.
fn compare(
    frames: usize,
    is_perspective: bool,
    framing: impl Fn(&mut Random, &Scene, &[Vec<V2>]) -> (Framing, V2, V2),
) -> Vec<Found> {
    let mut random = Random(31);
    let mut all: Vec<Found> = Rasterizer::ALL.iter().copied().map(Found::new).collect();
    for frame in 0..frames {
        let scene = Scene::random(&mut random, frame, is_perspective);
        let hulls = body(&mut random);
        let images: Vec<Vec<V2>> = hulls
            .iter()
            .map(|hull| hull.iter().map(|&point| scene.project(point)).collect())
            .collect();
        let (framing, scale, at) = framing(&mut random, &scene, &images);
        let placed: Vec<Vec<V2>> = images
            .iter()
            .map(|hull| {
                let pixels = hull
                    .iter()
                    .map(|p| [at[0] + p[0] * scale[0], at[1] - p[1] * scale[1]]);
                wrapped(&pixels.collect::<Vec<_>>())
            })
            .collect();

        let (rows, columns) = (scene.size.rows(), scene.size.columns());
        let expected: Vec<bool> = (0..rows * columns)
            .map(|pixel| {
                let corner = [pixel % columns, pixel / columns];
                covers(
                    &placed,
                    std::array::from_fn(|axis| corner[axis] as f64 + 0.5 + scene.jitter[axis]),
                )
            })
            .collect();
        let [min, max] = bounds(&placed);
        let corner = [columns as f64, rows as f64];
        let is_inside = (0..2).all(|axis| min[axis] >= -1e-3 && max[axis] <= corner[axis] + 1e-3);
        let kept = area(&placed, [[0.0; 2], corner]);
        let share = 1.0 - kept / area(&placed, [min, max]);

        let body = posed(&hulls);
        let jitter = Vec2::from(scene.jitter.map(|c| c as f32));
        for found in &mut all {
            let mut renderer = Renderer::new(found.rasterizer, scene.size);
            let figure = Figure::at_rest(&body);
            let drawing = renderer.draw(&figure, &scene.camera(), framing, jitter);
            let drawing = drawing.expect("a person");
            let drawn = drawing.frame.silhouette();
            found.frames += 1.0;
            for (pixel, &expected) in expected.iter().enumerate() {
                let is_on = drawn.is_on(pixel / columns, pixel % columns);
                found.on += f64::from(expected);
                found.differing += f64::from(expected != is_on);
            }
            if is_inside {
                assert!(drawing.clipped_share < 1e-3, "{drawing:?}");
                continue;
            }
            found.across += f64::from(kept > 0.0);
            found.outside += f64::from(kept == 0.0);
            let error = (f64::from(drawing.clipped_share) - share).abs();
            found.share_error = found.share_error.max(error);
        }
    }
    for found in &all {
        println!("{found:?}, {:.6} of on-pixels differ", found.error());
    }
    all
}

/// Returns the framing that stretches a figure to the image.
fn boxed(_: &mut Random, scene: &Scene, images: &[Vec<V2>]) -> (Framing, V2, V2) {
    let [min, max] = bounds(images);
    let scale = [
        scene.size.columns() as f64 / (max[0] - min[0]),
        scene.size.rows() as f64 / (max[1] - min[1]),
    ];
    (Framing::Box, scale, [-min[0] * scale[0], max[1] * scale[1]])
}

/// Returns a framing of a random scale, and a random centre within `reach` metres around the aim.
fn fixed(reach: f64) -> impl Fn(&mut Random, &Scene, &[Vec<V2>]) -> (Framing, V2, V2) {
    move |random, scene, _| {
        let rows = scene.size.rows() as f64;
        let scale = f64::from((rows * random.between(0.2, 0.7)) as f32);
        let centre = scene
            .aim
            .map(|c| f64::from((c + random.between(-reach, reach)) as f32));
        let [x, y] = scene.project(centre);
        let framing = Framing::Fixed {
            centre: single(centre),
            pixels_per_metre: scale as f32,
        };
        let middle = [0.5 * scene.size.columns() as f64, 0.5 * rows];
        let at = [middle[0] - x * scale, middle[1] + y * scale];
        (framing, [scale; 2], at)
    }
}

#[test]
fn a_box_is_the_stretched_figure_with_both_lenses() {
    for is_perspective in [false, true] {
        for found in compare(200, is_perspective, boxed) {
            assert_eq!(found.across + found.outside, 0.0);
            assert!(found.error() < found.tolerance(), "{found:?}");
        }
    }
}

#[test]
fn a_fixed_framing_shows_what_is_there_with_both_lenses() {
    for is_perspective in [false, true] {
        for found in compare(200, is_perspective, fixed(0.3)) {
            assert!(found.across > 50.0, "{found:?}");
            assert!(found.error() < found.tolerance(), "{found:?}");
            assert!(found.share_error < 0.03, "{found:?}");
        }
    }
}

#[test]
fn figures_partly_and_wholly_outside_are_drawn_with_the_share_that_is_missing() {
    for is_perspective in [false, true] {
        for found in compare(200, is_perspective, fixed(1.5)) {
            assert!(found.across > 50.0 && found.outside > 20.0, "{found:?}");
            assert!(found.share_error < 0.03, "{found:?}");
        }
    }
}

/// Returns a number of any magnitude, small as often as large, and sometimes not a finite one.
fn wild(random: &mut Random) -> f32 {
    match random.below(64) {
        0 => f32::NAN,
        1 => f32::INFINITY,
        2 => 0.0,
        3 => f32::MAX,
        _ => (random.between(-1.0, 1.0) * 10f64.powf(random.between(-44.0, 38.5))) as f32,
    }
}

#[test]
fn wild_figures_cameras_and_scales_are_drawn_or_refused() {
    let mut random = Random(32);
    let mut renderers: Vec<_> = Rasterizer::ALL
        .iter()
        .map(|&rasterizer| Size::ALL.map(|size| Renderer::new(rasterizer, size)))
        .collect();
    let (mut drawn, mut across) = (0, 0);
    for turn in 0..30_000 {
        // One magnitude for all numbers, or another for each.
        let unit = wild(&mut random).abs();
        let number = |random: &mut Random| match turn % 3 {
            0 => wild(random),
            _ => random.between(-1.0, 1.0) as f32 * unit,
        };
        let mut body = UnpackedBody::default();
        for _ in 0..2 {
            let points: Vec<Vec3> = (0..5)
                .map(|_| Vec3::from([0; 3].map(|_| number(&mut random))))
                .collect();
            body.push(Joint::Pelvis, points).expect("within the budget");
        }
        let aim = Vec3::from([0; 3].map(|_| number(&mut random)));
        let [azimuth, elevation] = random_angles(&mut random, turn).map(|angle| angle as f32);
        let viewpoint = Viewpoint::from_degrees(azimuth, elevation).expect("a viewpoint");
        let distance_m = random.between(0.1, 10.0) as f32;
        let camera = match Camera::perspective(viewpoint, aim, distance_m) {
            Ok(camera) if turn % 2 == 0 => camera,
            _ => Camera::orthographic(viewpoint),
        };
        let framing = match random.below(4) {
            0 => Framing::Height,
            1 => Framing::Box,
            2 => Framing::Fixed {
                centre: aim,
                pixels_per_metre: wild(&mut random).abs(),
            },
            _ => Framing::Fixed {
                centre: aim,
                pixels_per_metre: 10f64.powf(random.between(0.0, 4.0)) as f32 / unit,
            },
        };
        let jitter = Vec2::from([0; 2].map(|_| random.between(-0.5, 0.5) as f32));
        let figure = Figure::at_rest(&body);
        for renderers in &mut renderers {
            let renderer = &mut renderers[turn % 3];
            if let Ok(drawing) = renderer.draw(&figure, &camera, framing, jitter) {
                assert!((0.0..=1.0).contains(&drawing.clipped_share), "{turn}");
                drawn += 1;
                across += usize::from((0.01..0.99).contains(&drawing.clipped_share));
            }
        }
    }
    assert!(
        drawn > 10_000 && across > 500,
        "{drawn} drawn, {across} across"
    );
}
