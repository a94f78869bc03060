//! One training image: a mesh seen by a camera, and the hulls over it.
//!
//! A hull's gain is the sum over its pixels of +1 where the mesh is and -1 where it is not,
//! without pixels that other hulls cover. It measures the hull's effect on the image's Jaccard
//! index. Sums along rows reduce it to two look-ups per row, and make it continuous in x.

use super::outline::{self, Chains};
use super::{FittedHulls, PosedMesh};
use edgegait_core::skeleton::JOINTS;
use glam::{DVec3, Vec2, Vec3, Vec3A};

/// Rows of the mesh in an image, about 1 cm of a body each. Our choice: about four rows for each of
/// a silhouette's 50.
pub(super) const FIGURE_ROWS: f64 = 192.0;
/// Empty pixels around the mesh.
const MARGIN: f64 = 10.0;
/// Rows above and below a hull for which gains are summed: as far as its points move in one visit.
const REACH: usize = 14;
/// The maximum number of pixels in one image.
const MAX_PIXELS: f64 = 2.0e6;

/// A camera: orthographic, or in perspective at `distance_m` from what it looks at.
#[derive(Clone, Copy, Debug)]
pub(super) struct FitCamera {
    pub(super) azimuth: f64,
    pub(super) elevation: f64,
    pub(super) distance_m: Option<f64>,
}

/// A projective map from a joint's frame to pixels, as three rows.
#[derive(Clone, Copy, Debug)]
struct Map {
    x: Vec3A,
    y: Vec3A,
    w: Vec3A,
    at: Vec3A,
}

/// A training image.
pub(super) struct TrainingView {
    maps: [Map; JOINTS],
    is_perspective: bool,
    rows: usize,
    columns: usize,
    target: Vec<bool>,
    /// Pixels of the target.
    area: usize,
    /// Number of hulls over each pixel.
    count: Vec<u8>,
    /// Points of each hull in the image.
    points: Vec<Vec<Vec2>>,
    /// Sums of gains along each row for the visited hull.
    sums: Vec<i16>,
    /// Rows for which the sums are valid.
    region: (usize, usize),
    /// All points of the visited hull but one, by y.
    others: Vec<Vec2>,
}

impl TrainingView {
    /// Draws the mesh, without hulls.
    pub(super) fn new(example: &PosedMesh, triangles: &[[u32; 3]], camera: FitCamera) -> Self {
        let (sin_a, cos_a) = libm::sincos(camera.azimuth);
        let (sin_e, cos_e) = libm::sincos(camera.elevation);
        let towards = DVec3::new(sin_a * cos_e, sin_e, cos_a * cos_e);
        let right = DVec3::new(cos_a, 0.0, -sin_a);
        let up = towards.cross(right);
        let centre = example.positions[0];
        let inverse_distance = camera.distance_m.map_or(0.0, |metres| 1.0 / metres);
        // x and y in metres at the centre's depth.
        let seen = |point: DVec3| {
            let from = point - centre;
            let w = 1.0 - from.dot(towards) * inverse_distance;
            (from.dot(right) / w, -from.dot(up) / w)
        };
        let seen: Vec<(f64, f64)> = example.mesh.iter().map(|&point| seen(point)).collect();
        let range = |of: fn(&(f64, f64)) -> f64| {
            let values = seen.iter().map(of);
            values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
                (low.min(value), high.max(value))
            })
        };
        let ((left, end), (top, bottom)) = (range(|p| p.0), range(|p| p.1));
        let mut scale = FIGURE_ROWS / (bottom - top).max(1e-3);
        let pixels = |scale: f64| {
            ((bottom - top) * scale + 2.0 * MARGIN) * ((end - left) * scale + 2.0 * MARGIN)
        };
        while pixels(scale) > MAX_PIXELS {
            scale *= 0.5;
        }
        let size = |low: f64, high: f64| {
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "positive, within MAX_PIXELS"
            )]
            let size = ((high - low) * scale + 2.0 * MARGIN).ceil() as usize;
            size
        };
        let (rows, columns) = (size(top, bottom), size(left, end));
        let origin = (MARGIN - left * scale, MARGIN - top * scale);
        let maps = std::array::from_fn(|joint| {
            let turn = example.rotations[joint].inverse();
            let from = example.positions[joint] - centre;
            let row = |axis: DVec3| (turn * axis).as_vec3a();
            let w_row = -towards * inverse_distance;
            let w_at = 1.0 + from.dot(w_row);
            // Pixels are origin + scale * x / w: the origin is put into the numerator.
            let x_axis = right * scale + w_row * origin.0;
            let y_axis = -up * scale + w_row * origin.1;
            Map {
                x: row(x_axis),
                y: row(y_axis),
                w: row(w_row),
                at: DVec3::new(
                    from.dot(right) * scale + origin.0 * w_at,
                    -from.dot(up) * scale + origin.1 * w_at,
                    w_at,
                )
                .as_vec3a(),
            }
        });
        let to_pixels = |&(x, y): &(f64, f64)| {
            DVec3::new(x * scale + origin.0, y * scale + origin.1, 0.0)
                .as_vec3()
                .truncate()
        };
        let vertices: Vec<Vec2> = seen.iter().map(to_pixels).collect();
        let mut target = vec![false; rows * columns];
        for corners in triangles {
            let mut corners = corners.map(|corner| vertices[corner as usize]);
            corners.sort_unstable_by(|a, b| a.y.total_cmp(&b.y));
            Chains::from_sorted(&corners).each_row(rows, columns, |row, from, to| {
                target[row * columns + from..row * columns + to].fill(true);
            });
        }
        Self {
            maps,
            is_perspective: camera.distance_m.is_some(),
            rows,
            columns,
            area: target.iter().filter(|on| **on).count().max(1),
            count: vec![0; target.len()],
            target,
            points: Vec::new(),
            sums: vec![0; rows * (columns + 1)],
            region: (0, 0),
            others: Vec::new(),
        }
    }

    /// Puts these hulls into the image, in place of the present ones.
    pub(super) fn put(&mut self, parts: &FittedHulls) {
        self.count.fill(0);
        self.points.clear();
        for part in &parts.hulls {
            let joint = part.joint.index();
            let points = part.points.iter().map(|&point| self.project(joint, point));
            self.points.push(points.collect());
        }
        for hull in 0..self.points.len() {
            self.cover(hull, 1);
        }
    }

    fn project(&self, joint: usize, point: Vec3) -> Vec2 {
        let map = &self.maps[joint];
        let point = Vec3A::from(point);
        let plain = Vec2::new(map.x.dot(point) + map.at.x, map.y.dot(point) + map.at.y);
        if self.is_perspective {
            plain / (map.w.dot(point) + map.at.z).max(1e-3)
        } else {
            plain
        }
    }

    /// Adds `by` to the count of each pixel of a hull.
    fn cover(&mut self, hull: usize, by: i8) {
        let mut points = self.points[hull].clone();
        outline::sort(&mut points);
        let (rows, columns) = (self.rows, self.columns);
        let count = &mut self.count;
        Chains::from_sorted(&points).each_row(rows, columns, |row, from, to| {
            for pixel in &mut count[row * columns + from..row * columns + to] {
                *pixel = pixel.wrapping_add_signed(by);
            }
        });
    }

    /// Takes a hull out and sums up the gain of each pixel.
    pub(super) fn begin(&mut self, hull: usize) {
        self.cover(hull, -1);
        let (mut top, mut bottom) = (f32::INFINITY, f32::NEG_INFINITY);
        for point in &self.points[hull] {
            top = top.min(point.y);
            bottom = bottom.max(point.y);
        }
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "clamped to the image's rows"
        )]
        let row = |y: f32| y.clamp(0.0, self.rows as f32) as usize;
        let region = (
            row(top).saturating_sub(REACH),
            (row(bottom) + REACH).min(self.rows),
        );
        let (columns, stride) = (self.columns, self.columns + 1);
        for row in region.0..region.1 {
            let pixels = row * columns..(row + 1) * columns;
            let sums = &mut self.sums[row * stride..(row + 1) * stride];
            let mut sum = 0i16;
            sums[0] = 0;
            for ((count, on), place) in self.count[pixels.clone()]
                .iter()
                .zip(&self.target[pixels])
                .zip(&mut sums[1..])
            {
                let gain = i16::from(*on) * 2 - 1;
                sum += if *count == 0 { gain } else { 0 };
                *place = sum;
            }
        }
        self.region = region;
    }

    /// Puts the hull back.
    pub(super) fn end(&mut self, hull: usize) {
        self.cover(hull, 1);
    }

    /// Adds to `gains` the gains of the visited hull with its point `index` at each of these
    /// places, as shares of the mesh's area.
    pub(super) fn add_gains<const N: usize>(
        &mut self,
        hull: usize,
        joint: usize,
        index: usize,
        places: &[Vec3; N],
        gains: &mut [f64; N],
    ) {
        let points = &self.points[hull];
        self.others.clear();
        self.others.extend(&points[..index]);
        self.others.extend(&points[index + 1..]);
        outline::sort(&mut self.others);
        let base = Chains::from_sorted(&self.others);
        let scale = 1.0 / self.area as f64;
        // Most places are inside of what the other points span, and have the same gain.
        let mut inside = None;
        for (place, gain) in places.iter().zip(gains) {
            let at = self.project(joint, *place);
            let won = if base.contains(at) {
                *inside.get_or_insert_with(|| self.gain(&base))
            } else {
                self.gain(&Chains::with(&self.others, at))
            };
            *gain += f64::from(won) * scale;
        }
    }

    /// Returns the gain of the visited hull without its point `index`.
    pub(super) fn gain_without(&mut self, hull: usize, index: usize) -> f64 {
        let points = &self.points[hull];
        self.others.clear();
        self.others.extend(&points[..index]);
        self.others
            .extend(points.get(index + 1..).unwrap_or_default());
        outline::sort(&mut self.others);
        f64::from(self.gain(&Chains::from_sorted(&self.others))) / self.area as f64
    }

    fn gain(&self, chains: &Chains) -> f32 {
        let stride = self.columns + 1;
        let mut gain = 0.0;
        let most = self.columns as f32;
        let sum_to = |row: usize, x: f32| {
            let x = x.clamp(0.0, most);
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "within the row"
            )]
            let pixel = (x as usize).min(self.columns - 1);
            let at = row * stride + pixel;
            let (low, high) = (f32::from(self.sums[at]), f32::from(self.sums[at + 1]));
            low + (x - pixel as f32) * (high - low)
        };
        chains.each_span(self.region, |row, from, to| {
            gain += sum_to(row, to) - sum_to(row, from);
        });
        gain
    }

    /// Moves a point of a hull that is taken out of the image.
    pub(super) fn set(&mut self, hull: usize, joint: usize, index: usize, place: Vec3) {
        self.points[hull][index] = self.project(joint, place);
    }

    /// Returns the Jaccard index of the hulls' pixels and the mesh's.
    pub(super) fn jaccard(&self) -> f64 {
        let (mut both, mut either) = (0usize, 0usize);
        for (count, on) in self.count.iter().zip(&self.target) {
            both += usize::from(*count > 0 && *on);
            either += usize::from(*count > 0 || *on);
        }
        both as f64 / either.max(1) as f64
    }
}
