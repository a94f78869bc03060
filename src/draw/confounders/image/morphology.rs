//! Outlines that are too tight or too wide: erosion and dilation by a disc (Serra 1982); and the
//! median.

use super::fine::Fine;
use super::picture::BitPicture;
use glam::DVec2;
use rand::RngExt as _;
use rand_chacha::ChaCha8Rng;

/// The disc's radius at strength 1, metres. Our choice: 1.8 % of a stature of 1.7 m, or two pixels
/// of a figure 110 pixels high.
const RADIUS_M: f64 = 0.03;

/// Removes what is nearer to the background than 3 cm at strength 1.
///
/// Random radii within half a sample of the nominal radius make means over frames continuous.
/// Nothing changes where the radius is below one sample.
pub(crate) fn erode(picture: &mut BitPicture, fine: &Fine, strength: f64, rng: &mut ChaCha8Rng) {
    let radii = radii(fine, strength, rng);
    invert(picture);
    *picture = dilated(picture, radii);
    invert(picture);
}

/// Adds what is nearer to the figure than 3 cm at strength 1, with the radii of [`erode`].
pub(crate) fn dilate(picture: &mut BitPicture, fine: &Fine, strength: f64, rng: &mut ChaCha8Rng) {
    *picture = dilated(picture, radii(fine, strength, rng));
}

/// Samples the radii of the disc to the side and up, in samples.
fn radii(fine: &Fine, strength: f64, rng: &mut ChaCha8Rng) -> DVec2 {
    let spread = rng.random::<f64>() - 0.5;
    fine.samples_per_metre() * (RADIUS_M * strength) + spread
}

fn invert(picture: &mut BitPicture) {
    for word in picture.words_mut() {
        *word = !*word;
    }
}

/// Returns every sample within an ellipse about one that is on; all is off outside of the picture.
fn dilated(picture: &BitPicture, radii: DVec2) -> BitPicture {
    let words = picture.columns() / 64;
    let mut grown = picture.clone();
    // From the ellipse's upper end to its middle, rows grow wider step by step.
    let mut wide = picture.clone();
    let mut width = 0;
    #[expect(clippy::cast_possible_truncation, reason = "a few samples")]
    let height = libm::floor(radii.y.max(0.0)) as i32;
    for up in (0..=height).rev() {
        let share = f64::from(up) / radii.y;
        let reach = radii.x.max(0.0) * libm::sqrt(1.0 - share * share).max(0.0);
        while f64::from(width + 1) <= reach && width < 63 {
            width += 1;
            widen(wide.words_mut(), picture, width);
        }
        let up = up.unsigned_abs() as usize * words;
        let (wide, grown) = (wide.words(), grown.words_mut());
        // Upwards, and downwards.
        for (grown, wide) in grown.iter_mut().zip(wide.iter().skip(up)) {
            *grown |= wide;
        }
        for (grown, wide) in grown.iter_mut().skip(up).zip(wide) {
            *grown |= wide;
        }
    }
    grown
}

/// Adds the rows of a picture, moved by 1 to 63 columns to each side.
fn widen(wide: &mut [u64], picture: &BitPicture, by: u32) {
    let words = picture.columns() / 64;
    let rows = picture.words().chunks_exact(words);
    for (wide, row) in wide.chunks_exact_mut(words).zip(rows) {
        for (at, wide) in wide.iter_mut().enumerate() {
            let [right, left] = beside(row, at, by);
            *wide |= left | right;
        }
    }
}

/// Returns a word of a row moved by 1 to 63 columns to the right, and to the left.
fn beside(row: &[u64], at: usize, by: u32) -> [u64; 2] {
    let word = |at: Option<usize>| at.and_then(|at| row.get(at)).copied().unwrap_or(0);
    let (before, behind) = (word(at.checked_sub(1)), word(at.checked_add(1)));
    [
        row[at] << by | before >> (64 - by),
        row[at] >> by | behind << (64 - by),
    ]
}

/// Replaces each sample by the median of the 3x3 around it (Tukey 1971): on if at least five are.
pub(super) fn median(picture: &mut BitPicture) {
    let words = picture.columns() / 64;
    // Binary digits of sums of three bits, for 64 columns at a time.
    let sum = |a: u64, b: u64, c: u64| [a ^ b ^ c, (a & b) | (c & (a ^ b))];
    let across = |row: &[u64]| -> Vec<[u64; 2]> {
        let each = row.iter().enumerate().map(|(at, &word)| {
            let [right, left] = beside(row, at, 1);
            sum(left, word, right)
        });
        each.collect()
    };
    let mut rows: Vec<Vec<[u64; 2]>> = vec![vec![[0; 2]; words]];
    rows.extend(picture.words().chunks_exact(words).map(across));
    rows.push(vec![[0; 2]; words]);
    let three = rows.windows(3);
    for (row, three) in picture.words_mut().chunks_exact_mut(words).zip(three) {
        for (at, word) in row.iter_mut().enumerate() {
            let [ones, twos] = [0, 1].map(|digit| {
                let [above, own, below] = [0, 1, 2].map(|row| three[row][at][digit]);
                sum(above, own, below)
            });
            // The count is one + 2 (two + other) + 4 four.
            let ([one, two], [other, four]) = (ones, twos);
            *word = (four & (one | two | other)) | (one & two & other);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spots() -> BitPicture {
        let mut picture = BitPicture::empty(40, 2);
        for (row, from, to) in [(20, 62, 67), (21, 62, 90), (3, 5, 6), (35, 100, 101)] {
            picture.fill(row, from, to, true);
        }
        picture
    }

    #[test]
    fn dilation_is_every_sample_within_the_ellipse_of_one_that_is_on() {
        for radii in [
            DVec2::new(0.9, 0.9),
            DVec2::new(1.0, 1.0),
            DVec2::new(3.7, 3.7),
            DVec2::new(2.2, 7.1),
            DVec2::new(-0.5, -0.5),
        ] {
            let (spots, found) = (spots(), dilated(&spots(), radii));
            let samples = || (0..40).flat_map(|row| (0..128).map(move |column| (row, column)));
            let ons: Vec<_> = samples().filter(|&(r, c)| spots.is_on(r, c)).collect();
            for (row, column) in samples() {
                let near = |at: usize, to: usize, radius: f64| {
                    let away = at as f64 - to as f64;
                    if away == 0.0 {
                        0.0
                    } else {
                        away / radius.max(1e-9)
                    }
                };
                let expected = ons.iter().any(|&(r, c)| {
                    let (y, x) = (near(r, row, radii.y), near(c, column, radii.x));
                    x * x + y * y <= 1.0 + 1e-12
                });
                assert_eq!(found.is_on(row, column), expected, "{radii} {row} {column}");
            }
        }
    }

    #[test]
    fn eroding_a_dilated_square_leaves_the_square() {
        let mut square = BitPicture::empty(40, 1);
        for row in 10..30 {
            square.fill(row, 15, 45, true);
        }
        let radii = DVec2::splat(4.3);
        let mut closed = dilated(&square, radii);
        invert(&mut closed);
        closed = dilated(&closed, radii);
        invert(&mut closed);
        assert_eq!(closed, square);
    }

    #[test]
    fn a_median_is_what_most_of_nine_samples_are() {
        let mut picture = spots();
        for row in 8..18 {
            picture.fill(row, 58, 71, true);
            picture.fill(row, 60 + row.cast_signed() % 3, 63, false);
        }
        let before = picture.clone();
        median(&mut picture);
        for (row, column) in (1..39).flat_map(|row| (1..127).map(move |column| (row, column))) {
            let near =
                (row - 1..=row + 1).flat_map(|r| (column - 1..=column + 1).map(move |c| (r, c)));
            let on = near.filter(|&(r, c)| before.is_on(r, c)).count();
            assert_eq!(picture.is_on(row, column), on >= 5, "{row} {column}");
        }
    }
}
