//! Faults of segmentation: holes, missing parts, added parts, and noise.
//!
//! Places are sampled as shares of the figure: with the same random numbers they stay in place on
//! the body from frame to frame and from strength to strength.

use super::counts::ColumnCounts;
use super::fine::Fine;
use super::picture::{BitPicture, SampleBounds};
use glam::DVec2;
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
/// Share of samples that salt and pepper flip at strength 1. Our choice.
const TURNED: f64 = 0.1;

/// Cuts six elliptic holes, together a quarter of the figure's area at strength 1, less where
/// they overlap or lie beside the figure.
pub(crate) fn holes(picture: &mut BitPicture, fine: &Fine, strength: f64, rng: &mut ChaCha8Rng) {
    let rows = RowCounts::count(picture);
    let spots = Spot::draw::<HOLES>(rng);
    let radius = radius(fine, rows.area() * HOLES_AREA * strength / HOLES as f64);
    let centres = spots.map(|spot| rows.nth(picture, spot.place));
    for (spot, centre) in spots.iter().zip(centres) {
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

/// Removes one of three parts. Sizes at strength 1: the head, the uppermost fifth of the figure;
/// a leg, the lower half of the figure on one side of the legs' middle; or a band, a quarter of
/// the figure's height, centred at a quarter to three quarters of the height.
pub(crate) fn missing_part(picture: &mut BitPicture, strength: f64, rng: &mut ChaCha8Rng) {
    let (part, place) = (rng.random_range(0..4_u8), rng.random::<f64>());
    let Some(bounds) = picture.bounds() else {
        return;
    };
    let height = (bounds.bottom - bounds.top) as f64;
    let row = |share: f64| at_most(libm::round(share * height), bounds.bottom - bounds.top);
    let (left, right) = (bounds.left.cast_signed(), bounds.right.cast_signed());
    let (rows, columns) = match part {
        0 => (0..row(0.2 * strength), left..right),
        1 => {
            let middle = 0.25 + 0.5 * place;
            let half = 0.125 * strength;
            (row(middle - half)..row(middle + half), left..right)
        }
        side => {
            let first = row(1.0 - 0.5 * strength);
            let middle = middle_column(picture, bounds, bounds.top + row(0.5));
            let columns = if side == 2 {
                left..middle
            } else {
                middle..right
            };
            (first..row(1.0), columns)
        }
    };
    for row in rows {
        picture.fill(bounds.top + row, columns.start, columns.end, false);
    }
}

/// Flips random samples in the figure's bounding box, a tenth of them at strength 1.
pub(crate) fn salt_and_pepper(picture: &mut BitPicture, strength: f64, rng: &mut ChaCha8Rng) {
    let Some(bounds) = picture.bounds() else {
        return;
    };
    /// The number of binary digits of the share.
    const DIGITS: u32 = 16;
    let share = libm::round(TURNED * strength * f64::from(1 << DIGITS));
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "0 to 2^16"
    )]
    let share = share as u32;
    let mut mask = BitPicture::empty(1, picture.columns() / 64);
    mask.fill(
        0,
        bounds.left.cast_signed(),
        bounds.right.cast_signed(),
        true,
    );
    for row in bounds.top..bounds.bottom {
        let words = picture.row_mut(row).iter_mut().zip(mask.row(0));
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
            *word ^= below & mask;
        }
    }
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

/// The number of samples that are on in each row and all rows above it.
struct RowCounts(Vec<u32>);

impl RowCounts {
    fn count(picture: &BitPicture) -> Self {
        let mut all = 0;
        let rows = (0..picture.rows()).map(|row| {
            all += picture
                .row(row)
                .iter()
                .map(|word| word.count_ones())
                .sum::<u32>();
            all
        });
        Self(rows.collect())
    }

    fn area(&self) -> f64 {
        self.0.last().copied().unwrap_or(0).into()
    }

    /// Returns the sample that follows this share of the samples that are on.
    fn nth(&self, picture: &BitPicture, share: f64) -> Option<DVec2> {
        let before = share * self.area();
        let row = self.0.partition_point(|&on| f64::from(on) <= before);
        let above = row.checked_sub(1).map_or(0, |above| self.0[above]);
        let mut left = at_most(before - f64::from(above), picture.columns());
        for (word, &bits) in (0..).zip(self.0.get(row).map_or(&[] as &[u64], |_| picture.row(row)))
        {
            let on = bits.count_ones() as usize;
            if left < on {
                let bits = (0..left).fold(bits, |bits, _| bits & (bits - 1));
                let column = 64 * word + bits.trailing_zeros();
                return Some(DVec2::new(f64::from(column) + 0.5, row as f64 + 0.5));
            }
            left -= on;
        }
        None
    }
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

/// Returns the mean column of the samples that are on in the lower rows, from `from` on.
fn middle_column(picture: &BitPicture, bounds: SampleBounds, from: usize) -> isize {
    let rows = (from..bounds.bottom).map(|row| picture.row(row));
    let counts = ColumnCounts::count(rows, picture.columns() / 64, picture.rows());
    let (mut sum, mut count) = (0, 0);
    for column in bounds.left..bounds.right {
        let on = counts.of_column(column) as usize;
        (sum, count) = (sum + on * column, count + on);
    }
    sum.checked_div(count).unwrap_or(bounds.left).cast_signed()
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
    use super::super::tests::side_view;
    use super::*;
    use rand::SeedableRng as _;

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
                holes(&mut picture, &fine, strength, &mut seeded(seed));
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
    fn a_missing_part_is_a_head_a_band_or_a_leg() {
        let mut seen = [false; 4];
        for seed in 0..40 {
            let (_, before, bounds) = side_view(0);
            let mut picture = before.clone();
            missing_part(&mut picture, 1.0, &mut seeded(seed));
            assert_eq!(without(&picture, &before), 0);
            let height = bounds.bottom - bounds.top;
            let now = picture.bounds().expect("most of the figure");
            let is_empty = |row: usize| picture.row(row).iter().all(|&word| word == 0);
            let gap = (now.top..now.bottom).filter(|&row| is_empty(row)).count();
            if now.top > bounds.top {
                assert_eq!(now.top - bounds.top, (height + 2) / 5);
                seen[0] = true;
            } else if gap > 0 {
                assert!(gap.abs_diff(height / 4) <= 1, "{gap} of {height}");
                seen[1] = true;
            } else {
                let upper = |picture: &BitPicture| {
                    let rows = bounds.top..bounds.top + height / 2 - 1;
                    rows.map(|row| picture.count(row, 0, 9_999)).sum::<u32>()
                };
                assert_eq!(upper(&picture), upper(&before));
                let lost = without(&before, &picture) as f64 / before.area() as f64;
                assert!((0.05..0.35).contains(&lost), "{lost}");
                seen[if now.left > bounds.left { 2 } else { 3 }] = true;
            }
        }
        assert_eq!(seen, [true; 4]);
    }

    #[test]
    fn salt_and_pepper_turn_the_stated_share_of_the_rectangle_over() {
        for (strength, share) in [(1.0, 0.1), (0.25, 0.025)] {
            let (_, before, bounds) = side_view(9);
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
