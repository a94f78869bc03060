//! Faults of segmentation: holes, missing parts, added parts, and noise.
//!
//! Holes and missing parts follow the body's hulls, since segmenters lose clothes and limbs rather
//! than parts of an image; others are placed at shares of the figure. With the same random numbers
//! they stay in place on the body from frame to frame and from strength to strength.

use super::fine::{Fine, FineRenderer};
use super::morphology::median;
use super::picture::BitPicture;
use edgegait_core::body::{Figure, UnpackedBody};
use edgegait_core::raster::DrawError;
use edgegait_core::skeleton::Joint;
use glam::{DVec2, Vec3};
use rand::RngExt as _;
use rand_chacha::ChaCha8Rng;
use std::f64::consts::PI;

/// Area of all holes together at strength 1, as a share of the figure's area. Our choice.
const HOLES_AREA: f64 = 0.25;
/// The number of holes.
const HOLES: usize = 6;
/// Area of all blobs together at strength 1, as a share of the figure's area; about half of it
/// lies on the figure. Our choice.
const BLOBS_AREA: f64 = 0.5;
/// The number of blobs.
const BLOBS: usize = 3;
/// The number of neighbouring hulls that are missing. Our choice: a forearm has a hand, a head a neck.
const LOST: usize = 3;
/// Shares of samples that salt and pepper flip at strength 1, and that are flipped before a median.
/// Our choice: the median leaves a tenth of 30 %.
const TURNED: f64 = 0.1;
const TURNED_BEFORE_MEDIAN: f64 = 0.3;

/// Cuts six elliptic holes, together a quarter of the figure's area at strength 1, less where
/// they overlap or lie beside the figure. Each stays at one place of one of its hulls.
pub(crate) fn holes(
    picture: &mut BitPicture,
    fine: &Fine,
    figure: &Figure<'_>,
    strength: f64,
    rng: &mut ChaCha8Rng,
) {
    let area = picture.area() as f64;
    let radius = radius(fine, area * HOLES_AREA * strength / HOLES as f64);
    let hulls = hulls(figure);
    for spot in Spot::draw::<HOLES>(rng) {
        let centre = on_body(&hulls, spot.place).and_then(|place| fine.sample_of(place));
        if let Some(centre) = centre {
            ellipse(picture, centre, radius * spot.shape, false);
        }
    }
}

/// Joins three elliptic blobs to the figure. Their centres lie on its left or right border, and
/// together they have half of its area at strength 1; about half of that lies beside the figure.
pub(crate) fn merged_background(
    picture: &mut BitPicture,
    fine: &Fine,
    strength: f64,
    rng: &mut ChaCha8Rng,
) {
    let area = picture.area();
    let spots = Spot::draw::<BLOBS>(rng);
    let radius = radius(fine, area as f64 * BLOBS_AREA * strength / BLOBS as f64);
    let centres = spots.map(|spot| border(picture, spot));
    for (spot, centre) in spots.iter().zip(centres) {
        if let Some(centre) = centre {
            ellipse(picture, centre, radius * spot.shape, true);
        }
    }
}

/// Removes three neighbouring hulls of the figure, such as a thigh, a shank and a foot, with all that
/// is seen before or behind them. Their lengths grow with the strength.
///
/// # Errors
/// If they cannot be drawn.
pub(crate) fn missing_part(
    picture: &mut BitPicture,
    fine: &Fine,
    renderer: &mut FineRenderer,
    figure: &Figure<'_>,
    strength: f64,
    rng: &mut ChaCha8Rng,
) -> Result<(), DrawError> {
    let hulls = hulls(figure);
    let first = at_most(rng.random::<f64>() * hulls.len() as f64, hulls.len());
    #[expect(clippy::cast_possible_truncation, reason = "a share")]
    let share = strength as f32;
    let mut lost = Box::<UnpackedBody>::default();
    for points in hulls.iter().cycle().skip(first).take(LOST.min(hulls.len())) {
        let middle = middle(points);
        let kept = points
            .iter()
            .map(|&point| middle + share * (point - middle));
        let fits = lost.push(Joint::Pelvis, kept);
        debug_assert!(fits.is_ok(), "a part is within the budget of its figure");
    }
    picture.remove(&fine.draw(renderer, &Figure::at_rest(&lost))?);
    Ok(())
}

/// Returns the points of each of a figure's hulls.
fn hulls(figure: &Figure<'_>) -> Vec<Vec<Vec3>> {
    figure.hulls().map(Iterator::collect).collect()
}

/// Returns the mean of a hull's points.
fn middle(points: &[Vec3]) -> Vec3 {
    #[expect(clippy::cast_precision_loss, reason = "a few points")]
    let count = points.len().max(1) as f32;
    points.iter().sum::<Vec3>() / count
}

/// Returns a place of the body at a share of all of its points: halfway from the point to the middle
/// of its hull.
fn on_body(hulls: &[Vec<Vec3>], share: f64) -> Option<Vec3> {
    let count = hulls.iter().map(Vec::len).sum();
    let mut left = at_most(share * count as f64, count);
    for points in hulls {
        match points.get(left) {
            Some(point) => return Some(0.5 * (*point + middle(points))),
            None => left -= points.len(),
        }
    }
    None
}

/// Flips random samples in the figure's bounding box, a tenth of them at strength 1.
pub(crate) fn salt_and_pepper(picture: &mut BitPicture, strength: f64, rng: &mut ChaCha8Rng) {
    let noise = noise(picture, TURNED * strength, rng);
    picture.flip(&noise);
}

/// Flips what a median of 3x3, with which segmenters clean their masks, leaves of random samples in
/// the figure's bounding box, 30 % of them at strength 1. Inside and outside of the figure this is
/// the median of a noisy picture; outlines stay.
pub(crate) fn filtered_noise(picture: &mut BitPicture, strength: f64, rng: &mut ChaCha8Rng) {
    let mut noise = noise(picture, TURNED_BEFORE_MEDIAN * strength, rng);
    median(&mut noise);
    picture.flip(&noise);
}

/// Returns a picture in which a share of the samples in the figure's bounding box is on, at random.
fn noise(picture: &BitPicture, share: f64, rng: &mut ChaCha8Rng) -> BitPicture {
    let words = picture.columns() / 64;
    let mut noise = BitPicture::empty(picture.rows(), words);
    let Some(bounds) = picture.bounds() else {
        return noise;
    };
    /// The number of binary digits of the share.
    const DIGITS: u32 = 16;
    let share = libm::round(share * f64::from(1 << DIGITS));
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "0 to 2^16"
    )]
    let share = share as u32;
    let mut mask = BitPicture::empty(1, words);
    mask.fill(
        0,
        bounds.left.cast_signed(),
        bounds.right.cast_signed(),
        true,
    );
    for row in bounds.top..bounds.bottom {
        let words = noise.row_mut(row).iter_mut().zip(mask.row(0));
        for (word, mask) in words.filter(|(_, mask)| **mask != 0) {
            // Compares a random number of 16 binary digits for each sample with the share, from the
            // last digit on, 64 samples at a time.
            let mut below = 0;
            for digit in 0..DIGITS {
                let random = rng.random::<u64>();
                below = if share >> digit & 1 == 1 {
                    !random | below
                } else {
                    !random & below
                };
            }
            *word = below & mask;
        }
    }
    noise
}

/// The place and the shape of a hole or a blob.
#[derive(Clone, Copy)]
struct Spot {
    /// The place as a share of the figure, 0..1.
    place: f64,
    is_left: bool,
    /// Half width and half height, in units of the mean radius.
    shape: DVec2,
}

impl Spot {
    fn draw<const N: usize>(rng: &mut ChaCha8Rng) -> [Self; N] {
        std::array::from_fn(|_| {
            let [place, size, aspect] = [0; 3].map(|_| rng.random::<f64>());
            let is_left = rng.random::<bool>();
            // Areas of 0.4 to 1.6 of the mean, up to twice as high as wide or the reverse.
            let radius = libm::sqrt(0.4 + 1.2 * size);
            let aspect = libm::sqrt(libm::exp2(2.0 * aspect - 1.0));
            Self {
                place,
                is_left,
                shape: DVec2::new(radius / aspect, radius * aspect),
            }
        })
    }
}

/// Returns half width and half height of a circle in the scene, from its area in samples.
fn radius(fine: &Fine, area: f64) -> DVec2 {
    let stretch = fine.samples_per_metre();
    let round = libm::sqrt(area / PI);
    let aspect = libm::sqrt(stretch.x / stretch.y);
    DVec2::new(round * aspect, round / aspect)
}

/// Returns the sample at the figure's left or right border, at a share of its height.
fn border(picture: &BitPicture, spot: Spot) -> Option<DVec2> {
    let bounds = picture.bounds()?;
    let height = bounds.bottom - bounds.top;
    let first = bounds.top + at_most(spot.place * height as f64, height - 1);
    let mut rows = (first..bounds.bottom).chain(bounds.top..first);
    let row = rows.find(|&row| picture.count(row, bounds.left, bounds.right) > 0)?;
    let mut columns = bounds.left..bounds.right;
    let is_on = |column: &usize| picture.is_on(row, *column);
    let column = if spot.is_left {
        columns.find(is_on)?
    } else {
        columns.rfind(is_on)?
    };
    Some(DVec2::new(column as f64 + 0.5, row as f64 + 0.5))
}

/// Turns on or off the samples whose centres lie within an ellipse.
fn ellipse(picture: &mut BitPicture, centre: DVec2, radii: DVec2, on: bool) {
    let first = at_most(centre.y - radii.y, picture.rows());
    let end = at_most(centre.y + radii.y + 1.0, picture.rows());
    for row in first..end {
        let up = (row as f64 + 0.5 - centre.y) / radii.y;
        let half = radii.x * libm::sqrt(1.0 - up * up);
        // Above and below the ellipse the half width is NaN, which fills no samples.
        #[expect(clippy::cast_possible_truncation, reason = "samples of a picture")]
        let column = |at: f64| {
            let whole = (at - 0.5) as isize;
            whole.saturating_add(isize::from((whole as f64) < at - 0.5))
        };
        picture.fill(row, column(centre.x - half), column(centre.x + half), on);
    }
}

/// Returns a number as a count from 0 to `most`.
fn at_most(number: f64, most: usize) -> usize {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "clamped"
    )]
    let count = number.clamp(0.0, most as f64) as usize;
    count
}

#[cfg(test)]
mod tests {
    use super::super::picture::FigureSamples;
    use super::super::tests::{side_figure, side_view};
    use super::*;
    use edgegait_core::raster::Rasterizer;
    use edgegait_core::silhouette::Size;
    use rand::SeedableRng as _;
    use std::collections::BTreeSet;

    fn seeded(seed: u64) -> ChaCha8Rng {
        ChaCha8Rng::seed_from_u64(seed)
    }

    /// Returns the number of samples that are on in the first picture only.
    fn without(picture: &BitPicture, other: &BitPicture) -> u64 {
        let mut rest = picture.clone();
        rest.remove(other);
        rest.area()
    }

    #[test]
    fn holes_take_a_share_of_the_area_and_grow_with_strength() {
        let mut taken = 0.0;
        for seed in 0..30 {
            let (fine, before, _) = side_view(3);
            let cut = |strength| {
                let mut picture = before.clone();
                holes(
                    &mut picture,
                    &fine,
                    &side_figure(3),
                    strength,
                    &mut seeded(seed),
                );
                picture
            };
            let (some, most) = (cut(0.3), cut(1.0));
            assert_eq!(without(&some, &before) + without(&most, &some), 0);
            let share = without(&before, &most) as f64 / before.area() as f64;
            // The limit is that of six holes of the largest size.
            assert!(share <= 1.6 * HOLES_AREA + 0.01, "{share}");
            taken += share / 30.0;
        }
        // Less than 0.25, since holes overlap or lie partly beside the figure.
        assert!((0.1..0.25).contains(&taken), "{taken}");
    }

    #[test]
    fn holes_keep_their_place_on_the_body() {
        for share in [0.1, 0.35, 0.6, 0.9] {
            // Two frames of one person: each place is as far from the nearest point of its hull.
            let [one, other] = [2, 6].map(|frame| {
                let figure = side_figure(frame);
                let place = on_body(&hulls(&figure), share).expect("a place");
                let away = figure.points().map(|point| point.distance(place));
                away.fold(f32::MAX, f32::min)
            });
            assert!((one - other).abs() < 0.03, "{share}: {one} {other}");
        }
    }

    #[test]
    fn blobs_touch_the_figure_add_only_and_grow_with_strength() {
        for seed in 0..30 {
            let (fine, before, _) = side_view(6);
            let joined = |strength| {
                let mut picture = before.clone();
                merged_background(&mut picture, &fine, strength, &mut seeded(seed));
                picture
            };
            let (some, most) = (joined(0.3), joined(1.0));
            assert_eq!(without(&before, &some) + without(&some, &most), 0);
            let share = without(&most, &before) as f64 / before.area() as f64;
            assert!((0.05..1.6 * BLOBS_AREA).contains(&share), "{share}");
        }
    }

    #[test]
    fn a_missing_part_follows_the_body_and_grows_with_strength() {
        let mut renderer = FineRenderer::new(Rasterizer::Rows, Size::S50x30).expect("binary");
        let mut kinds = BTreeSet::new();
        for seed in 0..20 {
            let mut shares = [0, 4].map(|frame| {
                let (fine, before, _) = side_view(frame);
                let mut cut = |strength| {
                    let mut picture = before.clone();
                    let rng = &mut seeded(seed);
                    let lost = missing_part(
                        &mut picture,
                        &fine,
                        &mut renderer,
                        &side_figure(frame),
                        strength,
                        rng,
                    );
                    lost.expect("a part");
                    picture
                };
                let (some, most) = (cut(0.5), cut(1.0));
                assert_eq!(without(&some, &before) + without(&most, &some), 0);
                without(&before, &most) as f64 / before.area() as f64
            });
            // The same part in both frames of a person: its outline turns.
            shares.sort_by(f64::total_cmp);
            let [less, more] = shares;
            assert!(less > 0.0 && more < 0.7 && more < 2.5 * less, "{shares:?}");
            kinds.insert((20.0 * more) as u32);
        }
        assert!(kinds.len() > 3, "{kinds:?}");
    }

    #[test]
    fn a_median_leaves_a_tenth_of_much_noise_and_hardly_any_of_little() {
        let (_, before, FigureSamples { bounds, .. }) = side_view(9);
        let area = ((bounds.bottom - bounds.top) * (bounds.right - bounds.left)) as f64;
        for (strength, shares) in [(1.0, 0.08..0.14), (0.2, 0.0..0.01)] {
            let mut picture = before.clone();
            filtered_noise(&mut picture, strength, &mut seeded(8));
            let turned = (without(&before, &picture) + without(&picture, &before)) as f64;
            assert!(shares.contains(&(turned / area)), "{}", turned / area);
        }
    }

    #[test]
    fn salt_and_pepper_turn_the_stated_share_of_the_rectangle_over() {
        for (strength, share) in [(1.0, 0.1), (0.25, 0.025)] {
            let (_, before, FigureSamples { bounds, .. }) = side_view(9);
            let mut picture = before.clone();
            salt_and_pepper(&mut picture, strength, &mut seeded(8));
            let turned = (without(&before, &picture) + without(&picture, &before)) as f64;
            let area = ((bounds.bottom - bounds.top) * (bounds.right - bounds.left)) as f64;
            // Five standard deviations of a binomial number.
            let spread = 5.0 * (area * share * (1.0 - share)).sqrt();
            assert!((turned - area * share).abs() < spread, "{turned} of {area}");
            let now = picture.bounds().expect("samples");
            assert!(now.top >= bounds.top && now.bottom <= bounds.bottom);
            assert!(now.left >= bounds.left && now.right <= bounds.right);
        }
    }
}
