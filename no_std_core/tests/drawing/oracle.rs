//! Tests of kinematics, projection and rasterisation against independent plain f64 code, written
//! from the conventions of the crate's front page.

use crate::plain::*;
use crate::random::Random;
use edgegait_core::body::Figure;
use edgegait_core::camera::{Camera, Framing, Viewpoint};
use edgegait_core::pose::{ModelPose, Pose};
use edgegait_core::raster::{Rasterizer, Renderer};
use edgegait_core::silhouette::{AnySilhouette, Size};
use edgegait_core::skeleton::{JOINTS, Skeleton};
use glam::{Quat, Vec2, Vec3};

type M4 = [[f64; 4]; 4];

// ---- kinematics

/// The parents of pelvis, spine, thorax, neck, head, left arm (4), right arm (4), left leg (3),
/// right leg (3); 99 is none.
const PARENTS: [usize; 19] = [
    99, 0, 1, 2, 3, 2, 5, 6, 7, 2, 9, 10, 11, 0, 13, 14, 0, 16, 17,
];

fn product(a: &M4, b: &M4) -> M4 {
    std::array::from_fn(|row| {
        std::array::from_fn(|column| (0..4).map(|k| a[row][k] * b[k][column]).sum())
    })
}

/// Returns the rotation by a unit quaternion (x, y, z, w), then translation (Shoemake 1985).
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
        // From above and in front the walker moves down the image; from above and behind, up.
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
    /// The maximum number of columns that it takes; an even number.
    columns: usize,
}

impl Picture {
    /// Frames hulls by height: 50 rows from the highest point to the lowest, and the middle of the
    /// figure's width on the border between two columns. `None` if it is wider than `columns`.
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

    /// Returns whether each of `50 n` by `columns n` samples, evenly spaced, lies in any hull.
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

/// Returns the centroid's x in columns of an image of weights, with pixel centres at i + 0.5.
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

/// Returns the 30 columns with the centroid at x = 15, moved by `shift` columns.
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

/// Returns the sum of absolute differences.
fn difference(a: &[Vec<f64>], b: &[Vec<f64>]) -> f64 {
    a.iter()
        .flatten()
        .zip(b.iter().flatten())
        .map(|(a, b)| (a - b).abs())
        .sum()
}

/// The figures that are compared.
#[derive(Clone, Copy)]
struct Figures {
    frames: usize,
    /// The maximum number of hulls in a figure.
    hulls: usize,
    /// Their width and depth as multiples of a person's.
    stretch: f64,
    /// The maximum number of columns that they take; wider figures are left out.
    columns: usize,
}

const PEOPLE: Figures = Figures {
    frames: 60,
    hulls: 32,
    stretch: 1.0,
    columns: 128,
};

/// The result of a comparison over many frames.
#[derive(Default)]
struct Found {
    frames: f64,
    ties: f64,
    differing: f64,
    on: f64,
    /// The sum over frames of the mean difference of 1,500 pixels.
    mean: f64,
    /// The signed difference, drawn minus true.
    bias: f64,
}

/// Draws random figures and compares them with `n` by `n` samples a pixel.
fn compare(rasterizer: Rasterizer, n: usize, figures: Figures) -> Found {
    let mut random = Random(23);
    let mut renderer = Renderer::new(rasterizer, Size::S50x30);
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
        let camera = camera(azimuth, elevation);
        let drawing = renderer.draw(
            &Figure::at_rest(&posed(&hulls)),
            &camera,
            Framing::Height,
            Vec2::ZERO,
        );
        let drawing = drawing.expect("a person");
        let frame = drawing.frame;
        assert_eq!(
            matches!(frame, AnySilhouette::Binary(_)),
            matches!(rasterizer.name(), "skia" | "rows")
        );
        let drawn: Vec<Vec<f64>> = frame
            .to_coverage()
            .pixels()
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
        // A half is a tie between two columns. tiny-skia's edges lie up to 1/32 pixel too far left,
        // and a steep edge between two pixel centres affects many rows.
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

/// The centre-sampling rasterisers, and the share of on-pixels that may differ.
const CENTRES: &[(Rasterizer, f64)] = &[
    // Measured: 0.40 %, because tiny-skia truncates coordinates to 1/64 pixel.
    (Rasterizer::Skia, 0.005),
    // Measured: none.
    (Rasterizer::Rows, 1e-5),
];

#[test]
fn centres_are_sampled_as_in_f64() {
    for &(rasterizer, most) in CENTRES {
        let figures = Figures {
            frames: 600,
            ..PEOPLE
        };
        let found = compare(rasterizer, 1, figures);
        assert!(found.frames > 400.0 && found.ties < 0.3 * found.frames);
        let share = found.differing / found.on;
        assert!(share < most, "{rasterizer}: {share}");
    }
}

#[test]
fn figures_over_several_windows_are_drawn_and_centred_as_exactly() {
    for &(rasterizer, most) in CENTRES {
        let figures = Figures {
            frames: 200,
            stretch: 16.0,
            columns: 1_024,
            ..PEOPLE
        };
        let found = compare(rasterizer, 1, figures);
        assert!(found.frames > 100.0 && found.ties < 0.3 * found.frames);
        let share = found.differing / found.on;
        assert!(share < most, "{rasterizer}: {share}");
    }
}

/// The rasterisers with several samples a pixel, and by how much of 255 they may differ from
/// coverage, for one hull and for many.
const GREYS: &[(Rasterizer, [f64; 2])] = &[
    // Measured: 0.62, and 1.10 hull by hull.
    #[cfg(feature = "tiny-skia")]
    (Rasterizer::SkiaAa, [0.7, 1.25]),
    // Measured: 0.95, and 1.49.
    (Rasterizer::Rows3x3, [1.1, 1.7]),
];

#[test]
fn grey_is_the_coverage_of_one_hull_and_of_the_union_of_many_but_for_its_samples() {
    for &(rasterizer, most) in GREYS {
        for (hulls, most) in [1, PEOPLE.hulls].into_iter().zip(most) {
            let found = compare(rasterizer, 16, Figures { hulls, ..PEOPLE });
            assert!(found.frames > 40.0);
            let mean = 255.0 * found.mean / found.frames;
            assert!(mean < most, "{rasterizer}: {mean}");
        }
    }
}
