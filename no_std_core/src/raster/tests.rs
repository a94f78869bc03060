//! Tests of framings and lenses on boxes whose pixels can be counted by hand.

use super::moments::AreaMoments;
use super::*;
use crate::body::{Figure, UnpackedBody};
use crate::camera::Viewpoint;
use crate::silhouette::Silhouette;
use crate::skeleton::Joint;
use glam::Vec3;

fn front() -> Camera {
    Camera::orthographic(Viewpoint::from_degrees(0.0, 0.0).expect("a viewpoint"))
}

/// Returns an axis-parallel box, metres.
fn slab(min: [f32; 3], max: [f32; 3]) -> [Vec3; 8] {
    core::array::from_fn(|corner| {
        Vec3::from_array(core::array::from_fn(|axis| {
            if corner >> axis & 1 == 1 {
                max[axis]
            } else {
                min[axis]
            }
        }))
    })
}

fn body(hulls: &[[Vec3; 8]]) -> UnpackedBody {
    let mut body = UnpackedBody::default();
    for hull in hulls {
        body.push(Joint::Pelvis, *hull).expect("within the budget");
    }
    body
}

/// Returns the image of each rasteriser at 50x30 from the front, and the share that is cut off.
fn drawn(
    body: &UnpackedBody,
    framing: Framing,
) -> impl Iterator<Item = Result<(AnySilhouette, f32), DrawError>> {
    drawn_at(body, framing, Size::S50x30)
}

fn drawn_at(
    body: &UnpackedBody,
    framing: Framing,
    size: Size,
) -> impl Iterator<Item = Result<(AnySilhouette, f32), DrawError>> {
    Rasterizer::ALL.iter().map(move |&rasterizer| {
        let mut renderer = Renderer::new(rasterizer, size);
        let figure = Figure::at_rest(body);
        let drawing = renderer.draw(&figure, &front(), framing, Vec2::ZERO)?;
        Ok((*drawing.frame, drawing.clipped_share))
    })
}

/// Asserts that all rasterisers reject a figure for the same reason.
fn assert_refused(body: &UnpackedBody, framing: Framing, error: DrawError) {
    for found in drawn(body, framing) {
        assert_eq!(found, Err(error));
    }
}

/// Returns the silhouettes of each rasteriser, framed by height; grey pixels are on from half
/// coverage up.
fn silhouettes(body: &UnpackedBody) -> impl Iterator<Item = Silhouette> {
    let drawings = drawn(body, Framing::Height);
    drawings.map(|drawing| drawing.expect("a figure").0.silhouette())
}

/// Returns a silhouette with rows `top..bottom` of columns `left..right` on.
fn block(size: Size, [left, right]: [u32; 2], [top, bottom]: [usize; 2]) -> Silhouette {
    let bits = (u64::MAX >> (64 - (right - left))) << left;
    let rows: [u64; 64] = core::array::from_fn(|row| {
        if (top..bottom).contains(&row) {
            bits
        } else {
            0
        }
    });
    Silhouette::from_rows(size, &rows)
}

#[test]
fn a_box_fills_its_rows_and_is_centred() {
    // 0.4 m by 2 m: 25 pixels a metre, so 10 columns, 10..20.
    let body = body(&[slab([3.0, 0.0, 0.0], [3.4, 2.0, 0.3])]);
    for found in silhouettes(&body) {
        assert_eq!(found, block(Size::S50x30, [10, 20], [0, 50]));
    }
}

#[test]
fn the_picture_does_not_depend_on_where_the_figure_stands_or_how_large_it_is() {
    let at_origin = body(&[
        slab([-0.2, 0.0, 0.0], [0.2, 2.0, 0.3]),
        slab([0.2, 1.0, 0.0], [0.5, 1.2, 0.3]),
    ]);
    let mut elsewhere = UnpackedBody::default();
    for hull in Figure::at_rest(&at_origin).hulls() {
        let moved = hull.map(|p| p * 0.5 + Vec3::new(64.0, 8.0, -4.0));
        elsewhere
            .push(Joint::Head, moved)
            .expect("within the budget");
    }
    assert!(silhouettes(&at_origin).eq(silhouettes(&elsewhere)));
}

#[test]
fn what_is_cut_away_is_reported() {
    // 60 columns wide: half of it lies outside the 30.
    let wide = body(&[slab([0.0, 0.0, 0.0], [2.4, 2.0, 0.3])]);
    for drawing in drawn(&wide, Framing::Height) {
        let (frame, clipped_share) = drawing.expect("a figure");
        assert!((clipped_share - 0.5).abs() < 1e-6);
        assert_eq!(frame.silhouette().area(), 1_500);
    }
}

#[test]
fn a_figure_wider_than_the_window_is_measured_in_several() {
    // 40 m by 2 m: 1,000 columns; 30 are kept.
    let wide = body(&[slab([0.0, 0.0, 0.0], [40.0, 2.0, 0.3])]);
    for drawing in drawn(&wide, Framing::Height) {
        let (frame, clipped_share) = drawing.expect("a figure");
        assert!((clipped_share - 0.97).abs() < 1e-3);
        assert_eq!(frame.silhouette().area(), 1_500);
    }
    let wider = body(&[slab([0.0, 0.0, 0.0], [90.0, 2.0, 0.3])]);
    assert_refused(&wider, Framing::Height, DrawError::TooWide(2_250.0));
}

#[test]
fn overlapping_hulls_do_not_cancel() {
    let trunk = slab([-0.2, 0.0, 0.0], [0.2, 2.0, 0.3]);
    let mirrored = trunk.map(|p| Vec3::new(-p.x, p.y, p.z));
    assert!(silhouettes(&body(&[trunk, mirrored])).eq(silhouettes(&body(&[trunk]))));
}

#[test]
fn grey_pixels_tell_how_much_is_covered() {
    // 10.5 columns: centred, the outer columns are covered by a quarter, which is one of four
    // columns of samples for tiny-skia and one of three for bit rows.
    let body = body(&[slab([0.0, 0.0, 0.0], [0.42, 2.0, 0.3])]);
    for (drawing, rasterizer) in drawn(&body, Framing::Height).zip(Rasterizer::ALL) {
        let coverage = drawing.expect("a figure").0.to_coverage();
        let total: u32 = coverage.pixels().iter().map(|&p| u32::from(p)).sum();
        let columns = f64::from(total) / 255.0 / 50.0;
        let expected = match rasterizer.name() {
            "skia-aa" => 10.5,
            "rows-3x3" => 10.0 + 2.0 / 3.0,
            // The centres of the outer columns are outside.
            _ => 10.0,
        };
        assert!((columns - expected).abs() < 0.05, "{rasterizer}: {columns}");
    }
}

#[test]
fn what_has_no_image_is_a_typed_error() {
    assert_refused(&UnpackedBody::default(), Framing::Height, DrawError::Empty);
    assert_refused(&body(&[[Vec3::ONE; 8]]), Framing::Height, DrawError::Flat);
    let needle = body(&[slab([0.0; 3], [1e-6, 1.0, 0.0])]);
    assert_refused(&needle, Framing::Height, DrawError::Vanished);
}

/// Returns a framing of 50 pixels a metre around a point.
fn fixed(centre: [f32; 3]) -> Framing {
    Framing::Fixed {
        centre: Vec3::from(centre),
        pixels_per_metre: 50.0,
    }
}

#[test]
fn a_box_stretches_to_rows_and_columns_in_every_size() {
    // A T: the bar is the upper half, the stem the middle half of its width.
    let tee = body(&[
        slab([5.0, 1.0, 0.0], [9.0, 2.0, 0.3]),
        slab([6.0, 0.0, 0.0], [8.0, 2.0, 0.3]),
    ]);
    for (size, [left, right]) in [
        (Size::S50x30, [7.5, 22.5]),
        (Size::S64x44, [11.0, 33.0]),
        (Size::S64x64, [16.0, 48.0]),
    ] {
        for drawing in drawn_at(&tee, Framing::Box, size) {
            let (frame, clipped_share) = drawing.expect("a T");
            let found = frame.silhouette();
            assert_eq!((clipped_share, found.size()), (0.0, size));
            for (row, &bits) in found.rows().iter().enumerate() {
                for column in 0..size.columns() {
                    let middle = column as f32 + 0.5;
                    // On the edge itself either is right: 7.5 is the centre of column 7.
                    if middle == left || middle == right {
                        continue;
                    }
                    let is_on = row < size.rows() / 2 || (left..right).contains(&middle);
                    assert_eq!(bits >> column & 1 == 1, is_on, "{size} {row} {column}");
                }
            }
        }
    }
}

#[test]
fn a_fixed_framing_puts_its_centre_in_the_middle_and_moves_nothing() {
    // 0.2 m by 0.5 m: 10 columns by 25 rows, its lower left corner on the centre; a metre is
    // 50 pixels; depth does not matter.
    let body = body(&[slab([0.0; 3], [0.2, 0.5, 0.3])]);
    for (centre, expected) in [
        ([0.0; 3], block(Size::S50x30, [15, 25], [0, 25])),
        ([0.1, 0.2, -7.0], block(Size::S50x30, [10, 20], [10, 35])),
    ] {
        for drawing in drawn(&body, fixed(centre)) {
            let (frame, clipped_share) = drawing.expect("a figure");
            assert_eq!(clipped_share, 0.0, "{centre:?}");
            assert_eq!(frame.silhouette(), expected, "{centre:?}");
        }
    }
}

#[test]
fn what_a_fixed_framing_cuts_off_is_reported() {
    let slim = body(&[slab([0.0; 3], [0.2, 0.5, 0.3])]);
    let tall = body(&[slab([-1.0, -2.5, 0.0], [1.0, 2.5, 0.3])]);
    for (body, centre, share, area) in [
        // Half of the width beyond the left side: 5 of 10 columns of 25 rows are left.
        (&slim, [0.4, 0.0, 0.0], 0.5, 125),
        // 20 of 25 rows above the upper side.
        (&slim, [0.0, -0.4, 0.0], 0.8, 50),
        // Beyond each side.
        (&slim, [0.51, 0.0, 0.0], 1.0, 0),
        (&slim, [-0.31, 0.0, 0.0], 1.0, 0),
        (&slim, [0.0, 1.01, 0.0], 1.0, 0),
        (&slim, [0.0, -0.51, 0.0], 1.0, 0),
        (&slim, [1e38, -1e38, 0.0], 1.0, 0),
        // Larger than the image: 1500 pixels of 100 by 250.
        (&tall, [0.0; 3], 0.94, 1_500),
    ] {
        for drawing in drawn(body, fixed(centre)) {
            let (frame, clipped_share) = drawing.expect("a figure");
            assert!((clipped_share - share).abs() < 1e-3, "{centre:?}");
            assert_eq!(frame.silhouette().area(), area, "{centre:?}");
        }
    }
}

#[test]
fn a_figure_across_the_image_is_drawn_up_to_two_to_the_sixteenth_pixels() {
    let bar = |reach: f32| body(&[slab([-reach, -0.1, 0.0], [reach, 0.1, 0.1])]);
    // 65,000 pixels to each side.
    for drawing in drawn(&bar(1_300.0), fixed([0.0; 3])) {
        let (frame, clipped_share) = drawing.expect("a bar");
        let expected = block(Size::S50x30, [0, 30], [20, 30]);
        assert_eq!(frame.silhouette(), expected);
        // 30 of 130,000 columns are left, 0.02 %.
        assert!((0.999..1.0).contains(&clipped_share));
    }
    let (far, farther) = (
        DrawError::TooLarge(100_015.0),
        DrawError::TooLarge(f32::INFINITY),
    );
    assert_refused(&bar(2_000.0), fixed([0.0; 3]), far);
    assert_refused(&bar(1e38), fixed([0.0; 3]), farther);
}

#[test]
fn jitter_moves_the_samples() {
    // Columns 15..25 and rows 0..25, and a tenth of a pixel more to the right and down.
    let body = body(&[slab([0.0, -0.002, 0.0], [0.202, 0.5, 0.3])]);
    for rasterizer in centre_samplers() {
        let mut renderer = Renderer::new(rasterizer, Size::S50x30);
        let mut at = |x, y| {
            let figure = Figure::at_rest(&body);
            let drawing = renderer.draw(&figure, &front(), fixed([0.0; 3]), Vec2::new(x, y));
            drawing.expect("a figure").frame.silhouette()
        };
        let still = block(Size::S50x30, [15, 25], [0, 25]);
        assert_eq!(at(0.0, 0.0), still);
        assert_eq!(at(0.3, 0.3), still);
        // Samples at i + 0.05: those of column 25 or row 25 are inside.
        assert_eq!(at(-0.45, 0.0), block(Size::S50x30, [15, 26], [0, 25]));
        assert_eq!(at(0.0, -0.45), block(Size::S50x30, [15, 25], [0, 26]));
    }
}

/// Returns the rasterisers with one sample a pixel.
fn centre_samplers() -> impl Iterator<Item = Rasterizer> {
    let all = Rasterizer::ALL.iter().copied();
    all.filter(|rasterizer| matches!(rasterizer.name(), "skia" | "rows"))
}

#[test]
fn the_centroid_is_that_of_the_jittered_samples() {
    // Framed by height this is 10.4 columns wide around a window's middle, 58.8 to 69.2. Samples
    // at i + 0.5 are inside in 59..69: centroid 64. At i + 0.3, in 59..69: 63.8. At i + 0.1, in
    // 59..70: 64.1. At i + 0.9, in 58..69: 63.9. All round to 64, and 64 goes to 15.
    let body = body(&[slab([0.0; 3], [0.416, 2.0, 0.3])]);
    for rasterizer in centre_samplers() {
        let mut renderer = Renderer::new(rasterizer, Size::S50x30);
        for (x, columns) in [
            (0.0, [10, 20]),
            (-0.2, [10, 20]),
            (-0.4, [10, 21]),
            (0.4, [9, 20]),
        ] {
            let (figure, jitter) = (Figure::at_rest(&body), Vec2::new(x, 0.0));
            let drawing = renderer.draw(&figure, &front(), Framing::Height, jitter);
            let found = drawing.expect("a figure").frame.silhouette();
            assert_eq!(found, block(Size::S50x30, columns, [0, 50]), "{x}");
        }
    }
    // Columns 59..69 of 255: a centroid of 64, or of 64.5 with samples moved by half a pixel.
    let ten = AreaMoments {
        area: 2_550,
        doubled: 2_550 * 128,
    };
    assert_eq!(ten.centroid_column(0.0), 64);
    assert_eq!(ten.centroid_column(0.49), 64);
    assert_eq!(ten.centroid_column(0.5), 65);
    assert_eq!(ten.centroid_column(-0.5), 64);
}

#[test]
fn what_is_nearer_is_larger_in_perspective() {
    // Two boxes 0.2 m wide and 0.4 m high, thin; one at the aim, one a metre nearer at 4 m.
    let far = slab([-0.2, -0.2, 0.0], [0.0, 0.2, 0.0]);
    let near = slab([0.0, -0.2, 1.0], [0.2, 0.2, 1.0]);
    let body = body(&[far, near]);
    let viewpoint = Viewpoint::from_degrees(0.0, 0.0).expect("a viewpoint");
    let camera = Camera::perspective(viewpoint, Vec3::ZERO, 4.0).expect("a camera");
    let framing = Framing::Fixed {
        centre: Vec3::ZERO,
        pixels_per_metre: 45.0,
    };
    for &rasterizer in Rasterizer::ALL {
        let mut renderer = Renderer::new(rasterizer, Size::S50x30);
        let drawing = renderer.draw(&Figure::at_rest(&body), &camera, framing, Vec2::ZERO);
        let drawing = drawing.expect("two boxes");
        // 9 by 18 pixels, and 12 by 24.
        let found = drawing.frame.silhouette();
        let far = block(Size::S50x30, [6, 15], [16, 34]);
        let near = block(Size::S50x30, [15, 27], [13, 37]);
        let rows = found.rows().iter().zip(far.rows()).zip(near.rows());
        for ((&found, far), near) in rows {
            assert_eq!(found, far | near, "{rasterizer}");
        }
        assert_eq!(drawing.clipped_share, 0.0);
    }
}

#[test]
fn every_framing_refuses_what_has_no_image() {
    let any = body(&[slab([0.0; 3], [1.0; 3])]);
    for framing in [Framing::Height, Framing::Box, fixed([0.0; 3])] {
        assert_refused(&UnpackedBody::default(), framing, DrawError::Empty);
        for bad in [f32::NAN, f32::INFINITY] {
            for &rasterizer in Rasterizer::ALL {
                let mut renderer = Renderer::new(rasterizer, Size::S64x44);
                for jitter in [Vec2::new(bad, 0.0), Vec2::new(0.0, 0.51), Vec2::splat(-0.6)] {
                    let refused = renderer.draw(&Figure::at_rest(&any), &front(), framing, jitter);
                    assert!(matches!(refused, Err(DrawError::Jitter(_))));
                }
            }
        }
    }
    assert_refused(&body(&[[Vec3::ONE; 8]]), Framing::Box, DrawError::Flat);
    let board = body(&[slab([0.0; 3], [0.0, 1.0, 1.0])]);
    assert_refused(&board, Framing::Box, DrawError::Flat);
    for bad in [0.0, -1.0, f32::INFINITY] {
        let framing = Framing::Fixed {
            centre: Vec3::ZERO,
            pixels_per_metre: bad,
        };
        assert_refused(&any, framing, DrawError::Scale(bad));
    }
    assert_refused(&any, fixed([0.0, f32::NAN, 0.0]), DrawError::NotFinite);
    // Half outside, and too thin to be measured.
    let needle = body(&[slab([-1.0, 0.0, 0.0], [1.0, 0.0, 0.3])]);
    assert_refused(&needle, fixed([0.0; 3]), DrawError::Vanished);
}
