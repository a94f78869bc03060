//! Kinematics, projection, rasterisation and templates against plain f64 code that
//! shares nothing with the crate: written from the conventions of its front page.
#![cfg(feature = "skia")]

mod random;

use edgegait_core::avatar::PosedHulls;
use edgegait_core::camera::{Camera, Viewpoint};
use edgegait_core::pose::{ModelPose, Pose};
use edgegait_core::raster::{Rasterizer, Renderer};
use edgegait_core::silhouette::{Coverage, Frame, Silhouette};
use edgegait_core::skeleton::{JOINTS, Skeleton};
use edgegait_core::template::GeiBuilder;
use glam::{Quat, Vec2, Vec3};
use random::Random;

type V3 = [f64; 3];
type V2 = [f64; 2];
type M4 = [[f64; 4]; 4];

// ---- kinematics

/// Carriers of pelvis, spine, thorax, neck, head, left arm (4), right arm (4), left leg
/// (3), right leg (3); 99 is none.
const PARENTS: [usize; 19] = [
    99, 0, 1, 2, 3, 2, 5, 6, 7, 2, 9, 10, 11, 0, 13, 14, 0, 16, 17,
];

fn product(a: &M4, b: &M4) -> M4 {
    std::array::from_fn(|row| {
        std::array::from_fn(|column| (0..4).map(|k| a[row][k] * b[k][column]).sum())
    })
}

/// Rotation by a unit quaternion (x, y, z, w), then translation (Shoemake 1985).
fn rigid([x, y, z, w]: [f64; 4], t: V3) -> M4 {
    [
        [
            1.0 - 2.0 * (y * y + z * z),
            2.0 * (x * y - w * z),
            2.0 * (x * z + w * y),
            t[0],
        ],
        [
            2.0 * (x * y + w * z),
            1.0 - 2.0 * (x * x + z * z),
            2.0 * (y * z - w * x),
            t[1],
        ],
        [
            2.0 * (x * z - w * y),
            2.0 * (y * z + w * x),
            1.0 - 2.0 * (x * x + y * y),
            t[2],
        ],
        [0.0, 0.0, 0.0, 1.0],
    ]
}

fn random_quaternion(random: &mut Random) -> [f64; 4] {
    loop {
        let q = [0; 4].map(|_| random.between(-1.0, 1.0));
        let length = q.iter().map(|c| c * c).sum::<f64>().sqrt();
        if (0.1..=1.0).contains(&length) {
            return q.map(|c| c / length);
        }
    }
}

fn single(v: V3) -> Vec3 {
    Vec3::from(v.map(|c| c as f32))
}

#[test]
fn forward_kinematics_is_the_product_of_4_by_4_matrices() {
    let mut random = Random(21);
    let mut worst = 0.0f64;
    for _ in 0..2_000 {
        let mut skeleton = Skeleton {
            offsets: [Vec3::ZERO; JOINTS],
        };
        let mut pose = Pose::REST;
        let mut matrices = [[[0.0; 4]; 4]; JOINTS];
        for joint in 0..JOINTS {
            let rotation = random_quaternion(&mut random);
            let place: V3 = [0; 3].map(|_| random.between(-0.5, 0.5));
            pose.rotations[joint] = Quat::from_array(rotation.map(|c| c as f32));
            if joint == 0 {
                pose.root = single(place);
                matrices[0] = rigid(rotation, place);
            } else {
                skeleton.offsets[joint] = single(place);
                matrices[joint] = product(&matrices[PARENTS[joint]], &rigid(rotation, place));
            }
        }
        let model = ModelPose::new(&skeleton, &pose);
        for (joint, matrix) in matrices.iter().enumerate() {
            for (row, expected) in matrix.iter().take(3).enumerate() {
                let position = f64::from(model.positions[joint][row]);
                worst = worst.max((position - expected[3]).abs());
                for (column, expected) in expected.iter().take(3).enumerate() {
                    let found = f64::from(model.orientations[joint].col(column)[row]);
                    worst = worst.max((found - expected).abs());
                }
            }
        }
    }
    println!("forward kinematics: {worst:.1e}");
    // Measured: 6e-7 m.
    assert!(worst < 1e-5, "{worst}");
}

// ---- projection

/// The directions of the image's right and up.
///
/// The camera stands at `towards` from the walker: in front (+Z) at azimuth 0, on the
/// walker's left (+X) at 90, above at elevation 90. Up is the vertical as far as it is
/// seen; from straight above it is the horizontal away from the camera.
fn image_axes(azimuth_deg: f64, elevation_deg: f64) -> (V3, V3) {
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

fn dot(a: V3, b: V3) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn camera(azimuth_deg: f64, elevation_deg: f64) -> Camera {
    let viewpoint = Viewpoint::from_degrees(azimuth_deg as f32, elevation_deg as f32);
    Camera::orthographic(viewpoint.expect("a viewpoint"))
}

#[test]
fn cameras_see_what_the_conventions_say() {
    // Azimuth, elevation; where the walker's left, up and ahead appear: (right, up).
    let h = std::f32::consts::FRAC_1_SQRT_2;
    let table = [
        (0.0, 0.0, [(1.0, 0.0), (0.0, 1.0), (0.0, 0.0)]),
        (90.0, 0.0, [(0.0, 0.0), (0.0, 1.0), (-1.0, 0.0)]),
        (180.0, 0.0, [(-1.0, 0.0), (0.0, 1.0), (0.0, 0.0)]),
        (270.0, 0.0, [(0.0, 0.0), (0.0, 1.0), (1.0, 0.0)]),
        (45.0, 0.0, [(h, 0.0), (0.0, 1.0), (-h, 0.0)]),
        // From above and in front the walker comes down the image; from above and
        // behind he goes up.
        (0.0, 90.0, [(1.0, 0.0), (0.0, 0.0), (0.0, -1.0)]),
        (180.0, 90.0, [(-1.0, 0.0), (0.0, 0.0), (0.0, 1.0)]),
        (90.0, 90.0, [(0.0, -1.0), (0.0, 0.0), (-1.0, 0.0)]),
        (0.0, 45.0, [(1.0, 0.0), (0.0, h), (0.0, -h)]),
        // From below, the soles: ahead is up.
        (0.0, -90.0, [(1.0, 0.0), (0.0, 0.0), (0.0, 1.0)]),
    ];
    for (azimuth, elevation, expected) in table {
        let camera = camera(azimuth, elevation);
        for (axis, (right, up)) in [Vec3::X, Vec3::Y, Vec3::Z].into_iter().zip(expected) {
            let found = camera.project(axis);
            let error = (found - Vec2::new(right, up)).length();
            assert!(error < 1e-6, "{azimuth} {elevation} {axis}: {found}");
        }
    }
}

#[test]
fn every_camera_of_the_papers_grid_and_between_projects_as_in_f64() {
    let mut random = Random(22);
    let mut angles: Vec<V2> = Vec::new();
    for azimuth in (0..=180).step_by(5) {
        for elevation in (0..=90).step_by(5) {
            angles.push([f64::from(azimuth), f64::from(elevation)]);
        }
    }
    for _ in 0..1_000 {
        // Whole 64ths of a degree, which f32 holds.
        let steps = [
            random.between(-46_080.0, 46_080.0),
            random.between(-5_696.0, 5_696.0),
        ];
        angles.push(steps.map(|step| step.round() / 64.0));
    }
    let mut worst = 0.0f64;
    for [azimuth, elevation] in angles {
        let (right, up) = image_axes(azimuth, elevation);
        let point: V3 = [0; 3].map(|_| f64::from(random.between(-2.0, 2.0) as f32));
        let found = camera(azimuth, elevation).project(single(point));
        worst = worst.max((f64::from(found.x) - dot(right, point)).abs());
        worst = worst.max((f64::from(found.y) - dot(up, point)).abs());
    }
    println!("projection: {worst:.1e}");
    // Measured: 3e-7 m, or 1e-5 pixel of a person of 1.7 m.
    assert!(worst < 1e-6, "{worst}");
}

#[test]
fn azimuths_a_million_turns_apart_are_the_same_viewpoint() {
    // f32 holds both exactly: 359,999,968 = 999,999 turns and 328 degrees.
    assert_eq!(camera(359_999_968.0, 0.0), camera(328.0, 0.0));
    assert_eq!(camera(-359_999_968.0, 0.0), camera(32.0, 0.0));
}

// ---- rasterisation

/// A convex figure in the image: hulls of points, x to the right and y down, pixels.
struct Picture {
    hulls: Vec<Vec<V2>>,
    /// Columns that it takes at most; an even number.
    columns: usize,
}

impl Picture {
    /// Framed by height: 50 rows from the highest point to the lowest, and the middle
    /// of the figure's width on the border between two columns. `None` if it is wider than `columns`.
    fn new(hulls: &[Vec<V3>], columns: usize, [azimuth_deg, elevation_deg]: V2) -> Option<Self> {
        let (right, up) = image_axes(azimuth_deg, elevation_deg);
        let mut images: Vec<Vec<V2>> = hulls
            .iter()
            .map(|hull| hull.iter().map(|&p| [dot(right, p), dot(up, p)]).collect())
            .collect();
        let all = || images.iter().flatten();
        let (mut left, mut low) = (f64::MAX, f64::MAX);
        let (mut most_right, mut high) = (f64::MIN, f64::MIN);
        for &[x, y] in all() {
            (left, most_right) = (left.min(x), most_right.max(x));
            (low, high) = (low.min(y), high.max(y));
        }
        let scale = 50.0 / (high - low);
        if (most_right - left) * scale > columns as f64 {
            return None;
        }
        for [x, y] in images.iter_mut().flatten() {
            *x = (*x - 0.5 * (left + most_right)) * scale + 0.5 * columns as f64;
            *y = (high - *y) * scale;
        }
        Some(Self {
            hulls: images.iter().map(|points| wrapped(points)).collect(),
            columns,
        })
    }

    /// Whether each of `50 n` by `columns n` samples, evenly spaced, lies in any hull.
    fn samples(&self, n: usize) -> Vec<Vec<bool>> {
        let mut samples = vec![vec![false; self.columns * n]; 50 * n];
        let at = |index: usize| (index as f64 + 0.5) / n as f64;
        for hull in &self.hulls {
            let range = |axis: usize, end: usize| {
                let values = || hull.iter().map(|p| p[axis] * n as f64);
                let first = values().fold(f64::MAX, f64::min).floor().max(0.0) as usize;
                let last = values().fold(f64::MIN, f64::max).ceil().max(0.0) as usize;
                first.min(end)..last.min(end)
            };
            for row in range(1, 50 * n) {
                for column in range(0, self.columns * n) {
                    let sample = &mut samples[row][column];
                    *sample = *sample || is_inside(hull, [at(column), at(row)]);
                }
            }
        }
        samples
    }
}

/// Twice the area of the triangle, positive if it turns left in x right, y up.
fn turn(a: V2, b: V2, c: V2) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// The convex hull by gift wrapping (Jarvis 1973), counter-clockwise.
fn wrapped(points: &[V2]) -> Vec<V2> {
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

fn is_inside(hull: &[V2], sample: V2) -> bool {
    (0..hull.len()).all(|i| turn(hull[i], hull[(i + 1) % hull.len()], sample) > 0.0)
}

/// The centroid's x in columns of a picture of weights, pixel centres at i + 0.5.
fn centroid(weights: &[Vec<f64>]) -> f64 {
    let (mut sum, mut moment) = (0.0, 0.0);
    for row in weights {
        for (column, weight) in row.iter().enumerate() {
            sum += weight;
            moment += weight * (column as f64 + 0.5);
        }
    }
    moment / sum
}

/// The 30 columns that have the centroid at x = 15, moved by `shift` columns.
fn cut(weights: &[Vec<f64>], centre: f64, shift: isize) -> Vec<Vec<f64>> {
    let left = (centre + 0.5).floor() as isize - 15 + shift;
    let cell = |row: &[f64], column: isize| {
        usize::try_from(left + column)
            .ok()
            .and_then(|at| row.get(at))
            .copied()
            .unwrap_or(0.0)
    };
    weights
        .iter()
        .map(|row| (0..30).map(|column| cell(row, column)).collect())
        .collect()
}

/// The sum of the differences' sizes.
fn difference(a: &[Vec<f64>], b: &[Vec<f64>]) -> f64 {
    a.iter()
        .flatten()
        .zip(b.iter().flatten())
        .map(|(a, b)| (a - b).abs())
        .sum()
}

/// A person-sized heap of ellipsoids: a trunk, a head and limbs at random.
fn body(random: &mut Random) -> Vec<Vec<V3>> {
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
                    // The image of an axis under a random rotation: evenly on a sphere.
                    let direction = [
                        2.0 * (x * z + w * y),
                        2.0 * (y * z - w * x),
                        1.0 - 2.0 * (x * x + y * y),
                    ];
                    std::array::from_fn(|axis| {
                        let size = if hull == 0 { 1.0 } else { stretch[axis] };
                        // What f32 holds, so that both sides get the same figure.
                        f64::from((centre[axis] + radii[axis] * size * direction[axis]) as f32)
                    })
                })
                .collect(),
        );
    }
    hulls
}

fn posed(hulls: &[Vec<V3>]) -> PosedHulls {
    let mut figure = PosedHulls::default();
    for hull in hulls {
        figure
            .push(hull.iter().map(|&p| single(p)))
            .expect("within the budget");
    }
    figure
}

fn random_angles(random: &mut Random, frame: usize) -> V2 {
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

/// What is compared.
#[derive(Clone, Copy)]
struct Figures {
    frames: usize,
    /// Most hulls of a figure.
    hulls: usize,
    /// How many times as wide and deep as people they are.
    stretch: f64,
    /// Most columns that they take; wider ones are left out.
    columns: usize,
}

const PEOPLE: Figures = Figures {
    frames: 60,
    hulls: 32,
    stretch: 1.0,
    columns: 128,
};

/// What a comparison over many frames found.
#[derive(Default)]
struct Found {
    frames: f64,
    ties: f64,
    differing: f64,
    on: f64,
    /// Sum over frames of the mean difference of 1,500 pixels.
    mean: f64,
    /// Signed, drawn minus true.
    bias: f64,
}

/// Draws random figures and compares them with `n` by `n` samples a pixel.
fn compare(rasterizer: Rasterizer, n: usize, figures: Figures) -> Found {
    let mut random = Random(23);
    let mut renderer = Renderer::new(rasterizer);
    let mut found = Found::default();
    for frame in 0..figures.frames {
        let mut hulls = body(&mut random);
        hulls.truncate(figures.hulls);
        for [x, _, z] in hulls.iter_mut().flatten() {
            *x = f64::from((*x * figures.stretch) as f32);
            *z = f64::from((*z * figures.stretch) as f32);
        }
        let [azimuth, elevation] = random_angles(&mut random, frame);
        let Some(picture) = Picture::new(&hulls, figures.columns, [azimuth, elevation]) else {
            continue;
        };
        let samples = picture.samples(n);
        let weights: Vec<Vec<f64>> = samples
            .chunks(n)
            .map(|rows| {
                (0..figures.columns)
                    .map(|column| {
                        let cell = rows.iter().flat_map(|row| &row[column * n..][..n]);
                        cell.filter(|&&on| on).count() as f64 / (n * n) as f64
                    })
                    .collect()
            })
            .collect();
        let drawing = renderer.draw(&posed(&hulls), &camera(azimuth, elevation));
        let drawing = drawing.expect("a person");
        let frame = drawing.frame;
        assert_eq!(
            matches!(frame, Frame::Grey(_)),
            rasterizer == Rasterizer::SkiaAa
        );
        let drawn: Vec<Vec<f64>> = frame
            .to_pixels()
            .chunks(30)
            .map(|row| row.iter().map(|&pixel| f64::from(pixel) / 255.0).collect())
            .collect();

        let centre = centroid(&weights);
        let mut expected = cut(&weights, centre, 0);
        found.frames += 1.0;
        if drawing.clipped_share == 0.0 {
            let own = centroid(&drawn);
            assert!((14.5..15.5).contains(&own), "{own}");
        }
        // A half is a tie between two columns. tiny-skia's edges lie up to 1/32 pixel too
        // far left, and a steep edge between two pixel centres takes many rows along.
        if ((centre + 0.5) - (centre + 0.5).round()).abs() < 0.1 {
            found.ties += 1.0;
            for shift in [-1, 1] {
                let other = cut(&weights, centre, shift);
                if difference(&drawn, &other) < difference(&drawn, &expected) {
                    expected = other;
                }
            }
        } else {
            for shift in [-1, 1] {
                let other = cut(&weights, centre, shift);
                assert!(
                    difference(&drawn, &other) > difference(&drawn, &expected),
                    "centroid {centre}, but moved by {shift}; azimuth {azimuth}, elevation {elevation}"
                );
            }
        }
        found.differing += difference(&drawn, &expected);
        found.on += expected.iter().flatten().sum::<f64>();
        found.mean += difference(&drawn, &expected) / 1_500.0;
        found.bias += (drawn.iter().flatten().sum::<f64>()
            - expected.iter().flatten().sum::<f64>())
            / 1_500.0;
    }
    println!(
        "{rasterizer}, {n}x{n}: {} frames, {} near a tie, {:.4} of on-pixels differ, mean difference {:.3} of 255, bias {:.3}",
        found.frames,
        found.ties,
        found.differing / found.on,
        255.0 * found.mean / found.frames,
        255.0 * found.bias / found.frames
    );
    found
}

#[test]
fn skia_differs_from_exact_centre_sampling_in_one_of_two_hundred_pixels() {
    let figures = Figures {
        frames: 600,
        ..PEOPLE
    };
    let found = compare(Rasterizer::Skia, 1, figures);
    assert!(found.frames > 400.0 && found.ties < 0.3 * found.frames);
    // Measured: 0.40 %, since tiny-skia cuts coordinates to 1/64 pixel.
    let share = found.differing / found.on;
    assert!(share < 0.005, "{share}");
}

#[test]
fn figures_over_several_windows_are_drawn_and_centred_as_exactly() {
    let figures = Figures {
        frames: 200,
        stretch: 16.0,
        columns: 1_024,
        ..PEOPLE
    };
    let found = compare(Rasterizer::Skia, 1, figures);
    assert!(found.frames > 100.0 && found.ties < 0.3 * found.frames);
    let share = found.differing / found.on;
    assert!(share < 0.005, "{share}");
}

#[test]
fn anti_aliasing_of_one_hull_is_its_coverage() {
    let figures = Figures { hulls: 1, ..PEOPLE };
    let found = compare(Rasterizer::SkiaAa, 16, figures);
    assert!(found.frames > 50.0);
    // Measured: 0.62 of 255.
    let mean = 255.0 * found.mean / found.frames;
    assert!(mean < 0.7, "{mean}");
}

#[test]
fn anti_aliasing_hull_by_hull_is_the_coverage_of_their_union_but_where_edges_meet() {
    let found = compare(Rasterizer::SkiaAa, 16, PEOPLE);
    assert!(found.frames > 40.0);
    // Measured: 1.10 of 255.
    let mean = 255.0 * found.mean / found.frames;
    assert!(mean < 1.25, "{mean}");
}

// ---- templates

#[test]
fn a_gei_is_the_mean_in_f64_rounded_half_up() {
    let mut random = Random(24);
    for frames in [1, 2, 3, 7, 32, 100, 255] {
        let mut builder = GeiBuilder::new();
        let mut sums = [0.0f64; 1_500];
        for _ in 0..frames {
            let frame = if random.below(2) == 0 {
                Frame::Grey(Coverage {
                    pixels: std::array::from_fn(|_| random.below(256) as u8),
                })
            } else {
                let rows = std::array::from_fn(|_| random.bits() as u32);
                Frame::Binary(Silhouette::from_rows(rows))
            };
            builder.add(&frame);
            for (at, sum) in sums.iter_mut().enumerate() {
                *sum += match &frame {
                    Frame::Grey(coverage) => f64::from(coverage.pixels[at]),
                    Frame::Binary(bits) => f64::from(bits.is_on(at / 30, at % 30)) * 255.0,
                };
            }
        }
        let found = builder.finish().pixels;
        for (pixel, sum) in found.into_iter().zip(sums) {
            let mean = sum / f64::from(frames);
            assert_eq!(f64::from(pixel), (mean + 0.5).floor(), "{mean} of {frames}");
        }
    }
}
