//! A camera's view of a walk as a small coloured picture: shaded hulls on a tiled floor.
//!
//! It shows people the effect of a confounder. Recognizers never see it: silhouettes come from the
//! core.

mod canvas;
mod solid;

use canvas::{Canvas, TriangleCorner};
use edgegait_core::camera::{Camera, NEAR_M};
use edgegait_core::outline;
use glam::Vec3;
use image::RgbImage;
use image::imageops;
use solid::facets;

/// Red, green and blue, 0..=255.
type Colour = Vec3;

/// Each pixel is the mean of `SAMPLES` by `SAMPLES` samples.
const SAMPLES: u32 = 4;
const BACKGROUND: Colour = Vec3::new(238.0, 241.0, 245.0);
/// Alternating colours of the floor's tiles.
const TILES: [Colour; 2] = [
    Vec3::new(205.0, 209.0, 212.0),
    Vec3::new(220.0, 224.0, 227.0),
];
const FLOOR_SIDE: Colour = Vec3::new(190.0, 194.0, 198.0);
/// Side of a tile, metres, and the number of tiles from the middle to each edge.
const TILE_M: f32 = 0.5;
const TILES_TO_EDGE: i16 = 12;
/// Thickness of the floor, which makes it visible to a level camera, metres.
const FLOOR_M: f32 = 0.6;
/// Share of the light that is left in a shadow.
const SHADOW: f32 = 0.62;
/// Height of shadows above the floor, metres.
const SHADOW_LIFT_M: f32 = 0.01;
/// Share of the background in a colour, per metre behind the centre.
const HAZE: f32 = 0.12;

/// The kind of a hull, which decides its colour.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum HullKind {
    /// The body.
    Body,
    /// Hair.
    Hair,
    /// Clothes, shoes and hats.
    Garment,
    /// A carried load.
    Load,
    /// A shadow on the floor, which darkens what is below it.
    Shadow,
    /// An object or a person in front of the walker.
    Occluder,
}

impl HullKind {
    const fn colour(self) -> Colour {
        match self {
            Self::Body => Vec3::new(226.0, 178.0, 142.0),
            Self::Hair => Vec3::new(92.0, 62.0, 46.0),
            Self::Garment => Vec3::new(52.0, 120.0, 178.0),
            Self::Load => Vec3::new(206.0, 92.0, 38.0),
            Self::Shadow => Vec3::ZERO,
            Self::Occluder => Vec3::new(128.0, 132.0, 138.0),
        }
    }
}

/// A convex hull to show.
#[derive(Clone, Debug)]
pub(super) struct ShownHull {
    /// The points in the walker's space, metres, at most 32.
    pub points: Vec<Vec3>,
    /// The kind of hull.
    pub kind: HullKind,
}

/// A plane to walk on.
#[derive(Clone, Copy, Debug)]
pub(super) struct DrawnFloor {
    /// A point of the floor, metres: the middle of the visible part.
    pub point: Vec3,
    /// The upward normal, a unit vector that is not along X.
    pub normal: Vec3,
}

/// The camera and the frame of a picture of a scene.
#[derive(Clone, Copy, Debug)]
pub(super) struct SceneShot {
    /// The camera.
    pub camera: Camera,
    /// The point in the middle of the picture, metres.
    pub centre: Vec3,
    /// Metres from the picture's lower to its upper edge, at the centre.
    pub height_m: f32,
    /// The floor.
    pub floor: DrawnFloor,
    /// Width and height of the picture, pixels.
    pub size_px: (u32, u32),
}

/// Draws the picture of a scene.
///
/// Nearer hulls cover farther ones pixel by pixel, in any order. A floor seen from below is left
/// out, and so is everything behind a perspective camera.
#[must_use]
pub(super) fn frame(hulls: &[ShownHull], shot: &SceneShot) -> RgbImage {
    let (width, height) = shot.size_px;
    let eye = ShotCamera::new(shot, height * SAMPLES);
    let mut canvas = Canvas::new((width * SAMPLES, height * SAMPLES), BACKGROUND);
    draw_floor(&mut canvas, &eye);
    let (shadows, solids): (Vec<_>, Vec<_>) =
        hulls.iter().partition(|hull| hull.kind == HullKind::Shadow);
    draw_shadows(&mut canvas, &eye, &shadows);
    for hull in solids {
        draw_solid(&mut canvas, &eye, hull);
    }
    imageops::thumbnail(&canvas.into_picture(), width, height)
}

/// A shot, with its scale and light.
struct ShotCamera<'s> {
    shot: &'s SceneShot,
    /// Samples per metre.
    scale: f32,
    /// Direction to the light: over the left shoulder of the viewer.
    light: Vec3,
}

impl<'s> ShotCamera<'s> {
    fn new(shot: &'s SceneShot, rows: u32) -> Self {
        let from = shot.camera.viewpoint();
        Self {
            shot,
            scale: rows as f32 / shot.height_m,
            light: (0.7 * from.up() + 0.6 * from.toward() - 0.5 * from.right()).normalize(),
        }
    }

    /// Returns the distance of a point in front of the centre, metres.
    fn nearness(&self, point: Vec3) -> f32 {
        self.shot
            .camera
            .viewpoint()
            .toward()
            .dot(point - self.shot.centre)
    }

    /// Returns a point's place on the canvas; none if it is behind the camera.
    fn corner(&self, point: Vec3, colour: Colour) -> Option<TriangleCorner> {
        let SceneShot {
            camera,
            centre,
            size_px,
            ..
        } = self.shot;
        if camera.depth_m(point) < NEAR_M {
            return None;
        }
        let at = camera.project(point) - camera.project(*centre);
        let middle = 0.5 * SAMPLES as f32;
        Some(TriangleCorner {
            x: at.x * self.scale + middle * size_px.0 as f32,
            y: middle * size_px.1 as f32 - at.y * self.scale,
            nearness: self.nearness(point),
            colour,
        })
    }

    /// Returns a surface's colour after light and haze.
    fn lit(&self, colour: Colour, point: Vec3, normal: Vec3) -> Colour {
        let light = 0.68 + 0.38 * normal.dot(self.light);
        let haze = (-HAZE * self.nearness(point)).clamp(0.0, 0.5);
        (colour * light.max(0.35)).lerp(BACKGROUND, haze)
    }
}

fn draw_floor(canvas: &mut Canvas, eye: &ShotCamera<'_>) {
    let DrawnFloor { point, normal } = eye.shot.floor;
    if eye.shot.camera.viewpoint().toward().dot(normal) < 0.0 {
        return;
    }
    let ahead = Vec3::X.cross(normal).normalize();
    let left = normal.cross(ahead);
    let at = |x: i16, z: i16| point + TILE_M * (f32::from(x) * left + f32::from(z) * ahead);
    let edge = f32::from(TILES_TO_EDGE) * TILE_M;
    let mut quad = |points: [Vec3; 4], colour: &dyn Fn(Vec3) -> Colour| {
        let corners = points.map(|point| eye.corner(point, colour(point)));
        if let [Some(a), Some(b), Some(c), Some(d)] = corners {
            canvas.fill([a, b, c]);
            canvas.fill([a, c, d]);
        }
    };
    for x in -TILES_TO_EDGE..TILES_TO_EDGE {
        for z in -TILES_TO_EDGE..TILES_TO_EDGE {
            let tile = TILES[usize::from((x + z) & 1 != 0)];
            let corners = [at(x, z), at(x + 1, z), at(x + 1, z + 1), at(x, z + 1)];
            quad(corners, &|corner| {
                let share = (corner.distance(point) / edge).min(1.0);
                tile.lerp(BACKGROUND, share * share)
            });
        }
    }
    let (n, below) = (TILES_TO_EDGE, FLOOR_M * normal);
    let rim = [at(-n, -n), at(n, -n), at(n, n), at(-n, n)];
    for (index, &a) in rim.iter().enumerate() {
        let b = rim[(index + 1) % rim.len()];
        quad([a, b, b - below, a - below], &|_| FLOOR_SIDE);
    }
}

fn draw_shadows(canvas: &mut Canvas, eye: &ShotCamera<'_>, shadows: &[&ShownHull]) {
    let lift = SHADOW_LIFT_M * eye.shot.floor.normal;
    for shadow in shadows {
        let corners = shadow
            .points
            .iter()
            .map(|&p| eye.corner(p + lift, Vec3::ZERO));
        let Some(corners) = corners.collect::<Option<Vec<_>>>() else {
            continue;
        };
        let flat = outline::convex(
            corners
                .iter()
                .map(|corner| glam::Vec2::new(corner.x, corner.y)),
        );
        let around: Vec<&TriangleCorner> = flat
            .iter()
            .filter_map(|at| {
                corners
                    .iter()
                    .find(|corner| corner.x == at.x && corner.y == at.y)
            })
            .collect();
        if let [first, rest @ ..] = around.as_slice() {
            for pair in rest.windows(2) {
                canvas.darken([**first, *pair[0], *pair[1]], SHADOW);
            }
        }
    }
}

fn draw_solid(canvas: &mut Canvas, eye: &ShotCamera<'_>, hull: &ShownHull) {
    let colour = hull.kind.colour();
    for facet in facets(&hull.points) {
        let corners =
            facet.map(|(point, normal)| eye.corner(point, eye.lit(colour, point, normal)));
        if let [Some(a), Some(b), Some(c)] = corners {
            canvas.fill([a, b, c]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use edgegait_core::camera::Viewpoint;

    /// Returns a shot of 40 by 40 pixels of 5 cm around a point at a height of 1 m, orthographic.
    fn shot(azimuth_deg: f32, elevation_deg: f32) -> SceneShot {
        let viewpoint = Viewpoint::from_degrees(azimuth_deg, elevation_deg).unwrap();
        SceneShot {
            camera: Camera::orthographic(viewpoint),
            centre: Vec3::Y,
            height_m: 2.0,
            floor: DrawnFloor {
                point: Vec3::ZERO,
                normal: Vec3::Y,
            },
            size_px: (40, 40),
        }
    }

    /// Returns a cube with edges of half a metre.
    fn cube(middle: Vec3, kind: HullKind) -> ShownHull {
        let side = |bit: usize| if bit == 0 { -0.25 } else { 0.25 };
        let corner = |i: usize| middle + Vec3::new(side(i & 1), side(i & 2), side(i & 4));
        ShownHull {
            points: (0..8).map(corner).collect(),
            kind,
        }
    }

    fn is_reddish(picture: &RgbImage, x: u32, y: u32) -> bool {
        let [red, _, blue] = picture.get_pixel(x, y).0;
        red.saturating_sub(blue) > 40
    }

    #[test]
    fn hulls_are_where_the_camera_sees_them() {
        // Seen from the walker's left, ahead is to the image's left: 0.5 m are 10 pixels.
        let ahead = cube(Vec3::new(0.0, 1.25, 0.5), HullKind::Load);
        let picture = frame(&[ahead], &shot(90.0, 0.0));
        let lit = |x, y| is_reddish(&picture, x, y);
        assert!(lit(5, 10) && lit(14, 19));
        assert!(!lit(4, 15) && !lit(15, 15) && !lit(10, 9) && !lit(10, 20));
        let empty = frame(&[], &shot(90.0, 0.0));
        assert_eq!(empty.get_pixel(20, 20).0, [238, 241, 245]);
    }

    #[test]
    fn what_is_nearer_hides_what_is_farther_in_any_order() {
        let near = cube(Vec3::new(0.6, 1.0, 0.0), HullKind::Garment);
        let far = cube(Vec3::new(0.0, 1.0, 0.0), HullKind::Load);
        let one = frame(&[near.clone(), far.clone()], &shot(90.0, 0.0));
        let other = frame(&[far, near], &shot(90.0, 0.0));
        assert_eq!(one, other);
        assert!(!is_reddish(&one, 20, 20));
    }

    #[test]
    fn shadows_darken_the_floor_and_not_what_stands_on_it() {
        let flat = |x: f32| ShownHull {
            points: [(-0.2, -0.2), (0.2, -0.2), (0.2, 0.2), (-0.2, 0.2)]
                .map(|(dx, z)| Vec3::new(x + dx, 0.0, z))
                .into(),
            kind: HullKind::Shadow,
        };
        let stands = cube(Vec3::new(0.0, 1.0, 0.0), HullKind::Load);
        let from_above = |hulls: &[ShownHull]| frame(hulls, &shot(0.0, 90.0));
        let bare = from_above(std::slice::from_ref(&stands));
        // One under the cube, two on top of each other to the image's right.
        let shaded = from_above(&[stands, flat(0.0), flat(0.6), flat(0.6)]);
        assert_eq!(shaded.get_pixel(20, 20), bare.get_pixel(20, 20));
        let [dark, light] = [&shaded, &bare].map(|p| f32::from(p.get_pixel(33, 20).0[0]));
        assert!((dark / light - SHADOW).abs() < 0.02, "{dark} {light}");
    }

    #[test]
    fn a_floor_is_level_to_a_level_camera_and_hidden_from_below() {
        let picture = frame(&[], &shot(30.0, 0.0));
        let side = FLOOR_SIDE.to_array().map(|part| part as u8);
        // A metre above the floor, the picture ends at the floor; otherwise the floor is in the
        // middle.
        let mut lower = shot(30.0, 0.0);
        lower.centre = Vec3::ZERO;
        let lower = frame(&[], &lower);
        assert_eq!(picture.get_pixel(20, 39).0, [238, 241, 245]);
        assert_eq!(lower.get_pixel(20, 19).0, [238, 241, 245]);
        assert_eq!(lower.get_pixel(20, 20).0, side);
        let below = frame(&[], &shot(30.0, -20.0));
        assert!(below.pixels().all(|pixel| pixel.0 == [238, 241, 245]));
    }
}
