//! A canvas with a depth buffer: at each sample the nearest triangle is visible.

use super::Colour;
use image::{Rgb, RgbImage};

/// A corner of a triangle on the canvas.
#[derive(Clone, Copy, Debug)]
pub(super) struct TriangleCorner {
    /// Distance from the left, samples.
    pub x: f32,
    /// Distance from the top, samples.
    pub y: f32,
    /// Metres towards the camera, from any fixed origin.
    pub nearness: f32,
    /// The colour, interpolated between the corners.
    pub colour: Colour,
}

/// A grid of samples with colours and depths.
pub(super) struct Canvas {
    width: usize,
    samples: Vec<CanvasSample>,
}

#[derive(Clone, Copy)]
struct CanvasSample {
    nearness: f32,
    colour: Colour,
    is_dark: bool,
}

impl Canvas {
    pub(super) fn new((width, height): (u32, u32), ground: Colour) -> Self {
        let empty = CanvasSample {
            nearness: f32::NEG_INFINITY,
            colour: ground,
            is_dark: false,
        };
        Self {
            width: width as usize,
            samples: vec![empty; width as usize * height as usize],
        }
    }

    /// Paints a triangle where it is nearer than all triangles before it.
    pub(super) fn fill(&mut self, corners: [TriangleCorner; 3]) {
        self.visit(corners, |sample, nearness, colour| {
            *sample = CanvasSample {
                nearness,
                colour,
                is_dark: false,
            };
        });
    }

    /// Darkens the samples behind a triangle to this share of their light, each only once.
    pub(super) fn darken(&mut self, corners: [TriangleCorner; 3], light: f32) {
        self.visit(corners, |sample, _, _| {
            if !sample.is_dark {
                sample.colour *= light;
                sample.is_dark = true;
            }
        });
    }

    /// Calls `paint` for each sample that a triangle is in front of, with the triangle's nearness
    /// and colour there.
    fn visit(
        &mut self,
        corners: [TriangleCorner; 3],
        mut paint: impl FnMut(&mut CanvasSample, f32, Colour),
    ) {
        let [a, b, c] = corners;
        let area = (b.x - a.x) * (c.y - a.y) - (c.x - a.x) * (b.y - a.y);
        if area == 0.0 || !area.is_finite() {
            return;
        }
        let rows = self.samples.len() / self.width.max(1);
        let ys = within(corners.map(|corner| corner.y), rows);
        let xs = within(corners.map(|corner| corner.x), self.width);
        let share = |p: TriangleCorner, q: TriangleCorner, x: f32, y: f32| {
            ((p.x - x) * (q.y - y) - (q.x - x) * (p.y - y)) / area
        };
        for row in ys {
            for column in xs.clone() {
                let (x, y) = (column as f32 + 0.5, row as f32 + 0.5);
                let shares = [share(b, c, x, y), share(c, a, x, y), share(a, b, x, y)];
                if shares.iter().any(|share| *share < 0.0) {
                    continue;
                }
                let nearness = shares
                    .iter()
                    .zip(corners)
                    .map(|(share, corner)| share * corner.nearness)
                    .sum();
                let sample = &mut self.samples[row * self.width + column];
                if nearness > sample.nearness {
                    let colours = shares.iter().zip(corners);
                    let colour = colours.map(|(share, corner)| *share * corner.colour).sum();
                    paint(sample, nearness, colour);
                }
            }
        }
    }

    pub(super) fn into_picture(self) -> RgbImage {
        let (width, height) = (self.width, self.samples.len() / self.width.max(1));
        let mut picture = RgbImage::new(width as u32, height as u32);
        for (pixel, sample) in picture.pixels_mut().zip(self.samples) {
            // Rounded, and saturating at 0 and 255.
            *pixel = Rgb(sample.colour.to_array().map(|part| (part + 0.5) as u8));
        }
        picture
    }
}

/// Returns the samples whose centres may lie between these coordinates.
fn within(coordinates: [f32; 3], samples: usize) -> std::ops::Range<usize> {
    let least = coordinates.into_iter().fold(f32::INFINITY, f32::min);
    let most = coordinates.into_iter().fold(f32::NEG_INFINITY, f32::max);
    // Saturating at 0.
    let end = (most + 1.0) as usize;
    (least as usize).min(samples)..end.min(samples)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    fn triangle(places: [(f32, f32); 3], nearness: f32, colour: Colour) -> [TriangleCorner; 3] {
        places.map(|(x, y)| TriangleCorner {
            x,
            y,
            nearness,
            colour,
        })
    }

    const WHOLE: [(f32, f32); 3] = [(-9.0, -9.0), (9.0, -9.0), (0.0, 30.0)];
    const RED: Colour = Vec3::new(200.0, 0.0, 0.0);
    const BLUE: Colour = Vec3::new(0.0, 0.0, 200.0);

    fn colours(canvas: Canvas) -> Vec<[u8; 3]> {
        canvas
            .into_picture()
            .pixels()
            .map(|pixel| pixel.0)
            .collect()
    }

    #[test]
    fn the_nearer_one_is_seen_whatever_comes_first() {
        for order in [[0, 1], [1, 0]] {
            let mut canvas = Canvas::new((2, 1), Vec3::ZERO);
            for which in order {
                let (nearness, colour) = [(1.0, RED), (2.0, BLUE)][which];
                canvas.fill(triangle(WHOLE, nearness, colour));
            }
            assert_eq!(colours(canvas), [[0, 0, 200]; 2]);
        }
    }

    #[test]
    fn samples_are_taken_in_their_middles() {
        let mut canvas = Canvas::new((3, 3), Vec3::ZERO);
        // Below the line y = x + 0.2: half of the square, without its falling diagonal.
        canvas.fill(triangle([(-0.2, 0.0), (-0.2, 3.2), (3.0, 3.2)], 0.0, RED));
        let on: Vec<bool> = colours(canvas).iter().map(|c| c[0] > 0).collect();
        let expected = [false, false, false, true, false, false, true, true, false];
        assert_eq!(on, expected);
    }

    #[test]
    fn two_shadows_are_as_dark_as_one() {
        let mut canvas = Canvas::new((1, 1), RED);
        canvas.darken(triangle(WHOLE, 1.0, BLUE), 0.5);
        canvas.darken(triangle(WHOLE, 1.0, BLUE), 0.5);
        assert_eq!(colours(canvas), [[100, 0, 0]]);
    }
}
