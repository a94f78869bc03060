//! Drawing and framing of fine pictures, compared with silhouettes that the core draws directly.

use super::picture::FigureSamples;
use super::*;
use crate::encode::{MAX_ERROR_MM, encode_subjects};
use crate::people::cohort::{CohortOptions, subjects};
use edgegait_core::body::{Figure, UnpackedBody};
use edgegait_core::camera::{Camera, Framing, Viewpoint};
use edgegait_core::pack::Pack;
use edgegait_core::pose::ModelPose;
use edgegait_core::raster::{Rasterizer, RenderView, Renderer};
use edgegait_core::silhouette::{AnySilhouette, Silhouette, Size};
use edgegait_core::skeleton::Joint;
use glam::{Vec2, Vec3};
use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;
use std::sync::OnceLock;

/// Returns a pack of two built-in people who walk at 5 km/h.
fn pack() -> Pack<'static> {
    static BYTES: OnceLock<Vec<u8>> = OnceLock::new();
    let bytes = BYTES.get_or_init(|| {
        let options = CohortOptions {
            people: 2,
            speeds_kmh: vec![5.0],
            ..CohortOptions::default()
        };
        let people = subjects(&options).expect("5 km/h is within the norms");
        encode_subjects(&people, MAX_ERROR_MM, &|| Ok(())).expect("two people fit")
    });
    Pack::parse(bytes).expect("our own pack")
}

/// Returns points and joint of each hull of one of the two people.
pub(super) fn hulls(person: usize) -> Vec<(Vec<Vec3>, Joint)> {
    let pack = pack();
    let avatar = pack.avatar(person).expect("an avatar");
    let hulls = avatar.hulls();
    hulls
        .map(|hull| (hull.points().collect(), hull.joint()))
        .collect()
}

/// Returns the two bodies, and sixteen poses of a cycle of each.
pub(super) fn people() -> &'static [(Box<UnpackedBody>, Vec<ModelPose>)] {
    static PEOPLE: OnceLock<Vec<(Box<UnpackedBody>, Vec<ModelPose>)>> = OnceLock::new();
    PEOPLE.get_or_init(|| {
        let pack = pack();
        let person = |number: usize| {
            let avatar = pack.avatar(number).expect("an avatar");
            let clip = pack.clip(number).and_then(|clip| clip.as_loop());
            let cycle = clip.expect("a cycle");
            let pose = |phase: u8| {
                let pose = cycle.pose(f32::from(phase) / 16.0);
                ModelPose::new(&avatar.skeleton(), &pose)
            };
            (
                Box::new(UnpackedBody::new(&avatar)),
                (0..16).map(pose).collect(),
            )
        };
        vec![person(0), person(1)]
    })
}

/// Returns a camera with parallel rays, or one 4 m from the pelvis.
pub(super) fn camera((azimuth, elevation): (f32, f32), is_perspective: bool) -> Camera {
    let viewpoint = Viewpoint::from_degrees(azimuth, elevation).expect("a viewpoint");
    if is_perspective {
        let aim = Vec3::new(0.02, 0.95, -0.01);
        Camera::perspective(viewpoint, aim, 4.0).expect("a camera")
    } else {
        Camera::orthographic(viewpoint)
    }
}

pub(super) fn seen(camera: Camera, framing: Framing) -> RenderView {
    RenderView {
        camera,
        framing,
        jitter: Vec2::ZERO,
    }
}

/// Returns the figure of [`side_view`].
pub(super) fn side_figure(frame: usize) -> Figure<'static> {
    let (body, poses) = &people()[frame % 2];
    Figure::new(body, &poses[frame % 16])
}

/// Returns the fine picture of a person from the side, and its bounding box.
pub(super) fn side_view(frame: usize) -> (Fine, BitPicture, FigureSamples) {
    let figure = side_figure(frame);
    let (view, size) = (
        seen(camera((90.0, 0.0), false), Framing::Height),
        Size::S50x30,
    );
    let fine = Fine::lay_out(&figure, &[], view, size).expect("a picture");
    let mut renderer = FineRenderer::new(Rasterizer::Rows, Size::S50x30).expect("binary");
    let drawn = fine.draw_figure(&mut renderer, &figure);
    let (picture, bounds) = drawn.expect("a drawing");
    (fine, picture, bounds)
}

/// Frames a figure without any effect.
fn unchanged(
    renderer: &mut FineRenderer,
    figure: &Figure<'_>,
    view: RenderView,
    size: Size,
) -> Option<Framed> {
    let fine = Fine::lay_out(figure, &[], view, size).expect("a picture");
    let (picture, before) = fine.draw_figure(renderer, figure).expect("a drawing");
    fine.frame(&picture, before)
}

fn differing(a: &Silhouette, b: &Silhouette) -> u32 {
    let rows = a.rows().iter().zip(b.rows());
    rows.map(|(a, b)| (a ^ b).count_ones()).sum()
}

const FIXED: Framing = Framing::Fixed {
    centre: Vec3::new(0.0, 0.9, 0.0),
    pixels_per_metre: 26.0,
};
const CROSSING: Framing = Framing::Fixed {
    centre: Vec3::new(0.3, 1.4, 0.2),
    pixels_per_metre: 41.0,
};

#[test]
fn what_nothing_changed_is_the_silhouette_that_the_core_draws() {
    let mut summary = Vec::new();
    for rasterizer in [Rasterizer::Rows, Rasterizer::Skia] {
        let mut fine = FineRenderer::new(rasterizer, Size::S50x30).expect("binary");
        for framing in [Framing::Height, Framing::Box, FIXED, CROSSING] {
            let (mut silhouettes, mut differ, mut pixels, mut share) = (0, 0, 0, 0.0f32);
            for (number, (body, poses)) in people().iter().enumerate() {
                for (frame, pose) in poses.iter().enumerate().step_by(3) {
                    let figure = Figure::new(body, pose);
                    for turn in 0..12u8 {
                        let angles = (f32::from(turn) * 33.0, f32::from(turn % 6) * 18.0);
                        let camera = camera(angles, (turn + frame as u8).is_multiple_of(2));
                        let size = Size::ALL[(frame + usize::from(turn) + number) % 3];
                        let jitter = if turn % 3 == 0 {
                            Vec2::new(0.37, -0.48)
                        } else {
                            Vec2::ZERO
                        };
                        let view = RenderView {
                            jitter,
                            ..seen(camera, framing)
                        };
                        let mut direct = Renderer::new(rasterizer, size);
                        let direct = direct
                            .draw(&figure, &camera, framing, jitter)
                            .expect("drawn");
                        let AnySilhouette::Binary(expected) = direct.frame else {
                            panic!("expected bits");
                        };
                        let found =
                            unchanged(&mut fine, &figure, view, size).expect("a silhouette");
                        let wrong = differing(&found.silhouette, expected);
                        silhouettes += 1;
                        differ += u32::from(wrong > 0);
                        pixels += wrong;
                        share = share.max((found.clipped_share - direct.clipped_share).abs());
                    }
                }
            }
            summary.push(format!(
                "{rasterizer} {framing:?}: {differ} of {silhouettes} differ, in {pixels} pixels, clipped share within {share}"
            ));
            assert_eq!(differ, 0, "{summary:?}");
            assert!(share < 0.05, "{summary:?}");
        }
    }
    println!("{summary:#?}");
}

#[test]
fn each_fine_sample_is_the_cores_with_its_samples_moved_by_thirds() {
    let mut renderer = FineRenderer::new(Rasterizer::Rows, Size::S64x44).expect("binary");
    let mut direct = Renderer::new(Rasterizer::Rows, Size::S64x44);
    let (body, poses) = &people()[1];
    let figure = Figure::new(body, &poses[5]);
    for (angles, is_perspective) in [((70.0, 0.0), false), ((200.0, 40.0), true)] {
        let camera = camera(angles, is_perspective);
        let (view, size) = (seen(camera, FIXED), Size::S64x44);
        let fine = Fine::lay_out(&figure, &[], view, size).expect("a picture");
        let picture = fine.draw(&mut renderer, &figure).expect("a drawing");
        let (mut on, mut wrong) = (0, 0);
        for (down, across) in (0..3_u8).flat_map(|down| (0..3_u8).map(move |c| (down, c))) {
            let third = |step: u8| (f32::from(step) - 1.0) / 3.0;
            let jitter = Vec2::new(third(across), third(down));
            let drawing = direct.draw(&figure, &camera, FIXED, jitter).expect("drawn");
            let silhouette = drawing.frame.silhouette();
            for (row, column) in (0..64).flat_map(|row| (0..44).map(move |c| (row, c))) {
                let row_of = 3 * (fine.above + row) + usize::from(down);
                let column_of = 3 * (fine.left + column) + usize::from(across);
                let is_on = silhouette.is_on(row, column);
                on += u32::from(is_on);
                wrong += u32::from(picture.is_on(row_of, column_of) != is_on);
            }
        }
        assert!(on > 2_000 && wrong <= 2, "{wrong} of {on}");
    }
}

#[test]
fn what_is_left_of_a_figure_fills_the_rows_again() {
    for (size, framing) in [
        (Size::S50x30, Framing::Height),
        (Size::S64x64, Framing::Height),
        (Size::S64x44, Framing::Box),
    ] {
        let (body, poses) = &people()[0];
        let figure = Figure::new(body, &poses[2]);
        let (view, size) = (seen(camera((90.0, 0.0), false), framing), size);
        let fine = Fine::lay_out(&figure, &[], view, size).expect("a picture");
        let mut renderer = FineRenderer::new(Rasterizer::Rows, size).expect("binary");
        let drawn = fine.draw_figure(&mut renderer, &figure);
        let (mut picture, before) = drawn.expect("a drawing");
        for row in 0..before.bounds.top + 40 {
            picture.fill(row, 0, 9_999, false);
        }
        let framed = fine.frame(&picture, before).expect("a body without a head");
        let rows = framed.silhouette.rows();
        assert!(rows[0] != 0 && rows[size.rows() - 1] != 0);
        // Computed in floating point: the rest is (3 rows - 40) samples high and begins 40 lower.
        let top = 3.0 * fine.above as f64 + 40.0;
        let height = 3.0 * size.rows() as f64 - 40.0;
        for (number, bits) in rows.iter().enumerate() {
            let at = top + (number as f64 + 0.5) * height / size.rows() as f64;
            let sampled = (at - 1e-9).floor() as usize..=(at + 1e-9).floor() as usize;
            let is_empty = |row: usize| picture.row(row).iter().all(|&word| word == 0);
            assert!(sampled.into_iter().any(|row| is_empty(row) == (*bits == 0)));
        }
    }
}

#[test]
fn nothing_is_framed_of_nothing() {
    let (fine, mut picture, before) = side_view(3);
    picture.fill(before.bounds.top, 0, 9_999, true);
    assert!(fine.frame(&picture, before).is_some());
    assert_eq!(fine.frame(&fine.blank(), before), None);
}

#[test]
fn grey_rasterisers_are_refused() {
    let refused = |rasterizer| FineRenderer::new(rasterizer, Size::S50x30).is_err();
    assert!(refused(Rasterizer::SkiaAa) && refused(Rasterizer::Rows3x3));
}

type Effect = (
    &'static str,
    fn(&mut BitPicture, &Fine, f64, &mut ChaCha8Rng),
);

const EFFECTS: [Effect; 11] = [
    ("radial-distortion", |picture, fine, strength, _| {
        distort(picture, fine, strength);
    }),
    ("resolution", coarsen),
    ("light", |picture, fine, strength, rng| {
        Light::new(strength, rng).segment(picture, fine, rng);
    }),
    ("holes", |picture, fine, strength, rng| {
        holes(picture, fine, &side_figure(4), strength, rng);
    }),
    ("missing-parts", |picture, fine, strength, rng| {
        let mut renderer = FineRenderer::new(Rasterizer::Rows, Size::S50x30).expect("binary");
        let figure = side_figure(4);
        let lost = missing_part(picture, fine, &mut renderer, &figure, strength, rng);
        lost.expect("a part");
    }),
    ("merged-background", merged_background),
    ("erosion", erode),
    ("dilation", dilate),
    ("waver", |picture, fine, strength, rng| {
        waver(picture, fine, 0.3, strength, rng);
    }),
    ("filtered-noise", |picture, _, strength, rng| {
        filtered_noise(picture, strength, rng);
    }),
    ("salt-and-pepper", |picture, _, strength, rng| {
        salt_and_pepper(picture, strength, rng);
    }),
];

#[test]
fn effects_change_nothing_at_strength_0_little_at_little_and_repeat_with_their_seed() {
    for (name, effect) in EFFECTS {
        let changed = |strength: f64, seed: u64| {
            let (fine, mut picture, _) = side_view(4);
            let before = picture.clone();
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            effect(&mut picture, &fine, strength, &mut rng);
            let again = picture.clone();
            let mut other = picture.clone();
            other.join(&before);
            let mut shared = again.clone();
            shared.keep(&before);
            let share = (other.area() - shared.area()) as f64 / before.area() as f64;
            (share, picture)
        };
        let mean = |strength| (0..20).map(|seed| changed(strength, seed).0).sum::<f64>() / 20.0;
        assert_eq!(mean(0.0), 0.0, "{name}");
        let (little, half, full) = (mean(0.02), mean(0.5), mean(1.0));
        println!("{name}: {little:.4} {half:.3} {full:.3}");
        assert!(little < 0.05, "{name}: {little}");
        assert!(full > half && full > 0.05, "{name}: {half} {full}");
        assert_eq!(changed(0.7, 3).1, changed(0.7, 3).1, "{name}");
        let (fine, mut nothing, _) = side_view(4);
        nothing.keep(&fine.blank());
        effect(&mut nothing, &fine, 0.9, &mut ChaCha8Rng::seed_from_u64(5));
    }
}

/// Prints the time of drawing, framing and each effect, for a figure from the side in pictures of
/// 198 rows: `cargo test --release --lib confounders::image -- --ignored --nocapture`.
#[test]
#[ignore = "measures time"]
fn effects_have_a_cost() {
    let median = |act: &mut dyn FnMut(usize)| {
        let mut times: Vec<u128> = (0..401)
            .map(|round| {
                let start = std::time::Instant::now();
                act(round);
                start.elapsed().as_nanos()
            })
            .collect();
        times.sort_unstable();
        times[times.len() / 2]
    };
    let (body, poses) = &people()[0];
    for rasterizer in [Rasterizer::Rows, Rasterizer::Skia] {
        for framing in [Framing::Height, Framing::Box] {
            for size in [Size::S50x30, Size::S64x64] {
                let mut renderer = FineRenderer::new(rasterizer, size).expect("binary");
                let (view, size) = (seen(camera((90.0, 0.0), false), framing), size);
                let ns = median(&mut |round| {
                    let figure = Figure::new(body, &poses[round % 16]);
                    let fine = Fine::lay_out(&figure, &[], view, size).expect("a picture");
                    let drawn = fine.draw_figure(&mut renderer, &figure);
                    let (picture, before) = drawn.expect("a drawing");
                    assert!(fine.frame(&picture, before).is_some());
                });
                println!("draw and frame, {rasterizer}, {framing:?}, {size}: {ns} ns");
            }
        }
    }
    let views: Vec<(Fine, BitPicture, FigureSamples)> = (0..16).map(side_view).collect();
    for (name, effect) in EFFECTS {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let mut pictures: Vec<BitPicture> = views.iter().map(|view| view.1.clone()).collect();
        let ns = median(&mut |round| {
            pictures[round % 16].clone_from(&views[round % 16].1);
            effect(
                &mut pictures[round % 16],
                &views[round % 16].0,
                1.0,
                &mut rng,
            );
        });
        println!("{name}: {ns} ns");
    }
    let moments: Vec<BitPicture> = vec![views[3].1.clone(); 9];
    let ns = median(&mut |_| assert!(exposure::exposed(&moments).is_some()));
    println!("motion-blur, 9 drawn moments: {ns} ns");
    let figure = Figure::new(body, &poses[3]);
    let sun = Sun::from_degrees(40.0, 30.0).expect("a sun");
    let ns = median(&mut |_| drop(shadow_body(&figure, sun, &Floor::level(0.0), 1.0)));
    println!("shadow, its body: {ns} ns");
}
