//! Augmentation of templates: mirrored images, and images with the lowest rows cut off.
//!
//! Images are flipped left to right; rows are cut off the bottom and the rest is enlarged. Cuts are
//! the synthetic templates of Han & Bhanu 2006, "Individual recognition using gait energy image".
//! They simulate shoes, grass and shadows that change a silhouette's lowest part. Nothing is
//! random.

use super::{Template, TemplateShape};
use crate::error::{ChoiceError, Result};
use edgegait_core::silhouette::Size;

/// Cuts of rows off the bottom, with `rows` more rows in each of `steps` steps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Crops {
    /// The number of steps, K.
    pub steps: usize,
    /// The number of rows in a step, k.
    pub rows: usize,
}

impl Default for Crops {
    /// Returns four steps of one row, which cut 2 to 8 % of 50 rows. Our choice.
    fn default() -> Self {
        Self { steps: 4, rows: 1 }
    }
}

/// The variants to make from each image.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Augmentation {
    /// Whether to add mirrored images, of cropped ones too.
    pub flip: bool,
    /// The cuts off the bottom, if any.
    pub crops: Option<Crops>,
}

/// A variant of an image.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Variant {
    /// Whether the image is mirrored.
    pub is_flipped: bool,
    /// The number of rows that are cut off.
    pub rows_cut: usize,
}

impl Variant {
    /// Returns the walk's condition with the changes of the variant, as in `normal+flip+crop2`.
    #[must_use]
    pub fn condition(self, of_walk: &str) -> String {
        let flip = if self.is_flipped { "+flip" } else { "" };
        let crop = match self.rows_cut {
            0 => String::new(),
            rows => format!("+crop{rows}"),
        };
        format!("{of_walk}{flip}{crop}")
    }
}

impl Augmentation {
    /// Checks that the template is an image that can be augmented.
    ///
    /// # Errors
    /// For vectors and silhouettes, and if a crop leaves fewer than half of the rows.
    pub fn check(self, template: Template, size: Size) -> Result<()> {
        if self == Self::default() {
            return Ok(());
        }
        let is_image = matches!(template.shape(size), TemplateShape::Image { .. });
        if !is_image || template == Template::Silhouettes {
            return Err(ChoiceError::NoImage(template.name()).into());
        }
        let Some(Crops { steps, rows }) = self.crops else {
            return Ok(());
        };
        let most = size.rows() / 2;
        if steps == 0 || rows == 0 || steps.saturating_mul(rows) > most {
            return Err(ChoiceError::Crops { steps, rows, most }.into());
        }
        Ok(())
    }

    /// Returns the variants of each image, the image itself first.
    #[must_use]
    pub fn variants(self) -> Vec<Variant> {
        let Crops { steps, rows } = self.crops.unwrap_or(Crops { steps: 0, rows: 0 });
        let flips = if self.flip {
            &[false, true][..]
        } else {
            &[false]
        };
        let of_step = |step: usize| {
            flips.iter().map(move |&is_flipped| Variant {
                is_flipped,
                rows_cut: step * rows,
            })
        };
        (0..=steps).flat_map(of_step).collect()
    }
}

/// Returns a variant of an image template, with bytes row by row from the top. Each plane is
/// changed.
#[must_use]
pub fn varied(bytes: &[u8], size: Size, variant: Variant) -> Vec<u8> {
    let planes = bytes.chunks_exact(size.pixels());
    planes
        .flat_map(|plane| {
            let mut plane = cropped(plane, size, variant.rows_cut);
            if variant.is_flipped {
                let rows = plane.chunks_exact_mut(size.columns());
                rows.for_each(<[u8]>::reverse);
            }
            plane
        })
        .collect()
}

/// Enlarges the upper rows to all rows, and the columns by the same factor about their middle.
/// Interpolates linearly between pixel centres; beyond the outermost centres, their values
/// continue.
fn cropped(plane: &[u8], size: Size, rows_cut: usize) -> Vec<u8> {
    if rows_cut == 0 {
        return plane.to_vec();
    }
    let columns = size.columns();
    let [down, right] = crop_taps(size, rows_cut);
    let mut cropped = Vec::with_capacity(plane.len());
    for &(top, bottom, low) in &down {
        for &(left, right, far) in &right {
            let at = |row: usize, column: usize| f64::from(plane[row * columns + column]);
            let upper = at(top, left) * (1.0 - far) + at(top, right) * far;
            let lower = at(bottom, left) * (1.0 - far) + at(bottom, right) * far;
            let byte = upper * (1.0 - low) + lower * low;
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "0 to 255.5"
            )]
            cropped.push((byte + 0.5) as u8);
        }
    }
    cropped
}

/// Returns the weights of a crop of one plane: (source pixel, target pixel, weight). Each target
/// has four sources, whose weights add up to 1.
#[cfg(feature = "train")]
pub(crate) fn crop_weights(size: Size, rows_cut: usize) -> Vec<(usize, usize, f64)> {
    let columns = size.columns();
    let [down, right] = crop_taps(size, rows_cut);
    let mut weights = Vec::with_capacity(4 * size.pixels());
    for (row, &(top, bottom, low)) in down.iter().enumerate() {
        for (column, &(left, right, far)) in right.iter().enumerate() {
            let made = row * columns + column;
            for (from_row, of_row) in [(top, 1.0 - low), (bottom, low)] {
                for (from_column, of_column) in [(left, 1.0 - far), (right, far)] {
                    weights.push((from_row * columns + from_column, made, of_row * of_column));
                }
            }
        }
    }
    weights
}

/// Returns the source rows and source columns of a crop, with their weights.
fn crop_taps(size: Size, rows_cut: usize) -> [Vec<(usize, usize, f64)>; 2] {
    let (rows, columns) = (size.rows(), size.columns());
    let kept = rows - rows_cut;
    let scale = kept as f64 / rows as f64;
    let middle = 0.5 * columns as f64;
    [
        taps(rows, kept, |row| (row + 0.5) * scale - 0.5),
        taps(columns, columns, |column| {
            (column + 0.5 - middle) * scale + middle - 0.5
        }),
    ]
}

/// Returns for each of `count` places the two of `of` pixels around it, and the weight of the
/// second one.
fn taps(count: usize, of: usize, place: impl Fn(f64) -> f64) -> Vec<(usize, usize, f64)> {
    let tap = |at: usize| {
        let place = place(at as f64).clamp(0.0, (of - 1) as f64);
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a pixel's number"
        )]
        let first = place as usize;
        (first, (first + 1).min(of - 1), place - first as f64)
    };
    (0..count).map(tap).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: Size = Size::S50x30;

    fn image(pixel: impl Fn(usize, usize) -> u8) -> Vec<u8> {
        let at = |at: usize| pixel(at / 30, at % 30);
        (0..1500).map(at).collect()
    }

    const FLIPPED: Variant = Variant {
        is_flipped: true,
        rows_cut: 0,
    };

    #[test]
    fn a_flip_puts_the_left_column_right_in_every_plane() {
        let planes = [
            image(|r, c| (r + 7 * c) as u8),
            image(|r, c| (3 * r + c) as u8),
        ]
        .concat();
        let flipped = varied(&planes, SIZE, FLIPPED);
        for (at, byte) in flipped.iter().enumerate() {
            let (row, column) = (at / 30, at % 30);
            assert_eq!(*byte, planes[row * 30 + 29 - column]);
        }
        assert_eq!(varied(&flipped, SIZE, FLIPPED), planes);
        assert_eq!(varied(&planes, SIZE, Variant::default()), planes);
    }

    #[test]
    fn half_of_the_rows_become_twice_as_high_and_wide() {
        // Rows 0 to 24 are a slope in both directions; the rows below are cut off.
        let ramp = image(|row, column| {
            if row < 25 {
                (4 * row + 3 * column) as u8
            } else {
                255
            }
        });
        let half = Variant {
            is_flipped: false,
            rows_cut: 25,
        };
        let found = varied(&ramp, SIZE, half);
        // A pixel's centre (r + 1/2, c + 1/2) shows ((r + 1/2) / 2, 15 + (c + 1/2 - 15) / 2).
        for row in 1..49 {
            for column in 0..30 {
                let from_row = (row as f64 + 0.5) / 2.0 - 0.5;
                let from_column = 15.0 + (column as f64 + 0.5 - 15.0) / 2.0 - 0.5;
                let expected = (4.0 * from_row + 3.0 * from_column + 0.5).floor();
                assert_eq!(
                    f64::from(found[row * 30 + column]),
                    expected,
                    "{row} {column}"
                );
            }
        }
        // Values above the first centre and below the last kept one equal those at the centres.
        assert_eq!(found[15], 44); // 3 * 14.75 = 44.25
        assert_eq!(found[49 * 30 + 15], 140); // 4 * 24 + 44.25
    }

    #[test]
    #[cfg(feature = "train")]
    fn weights_of_a_crop_make_what_the_crop_makes() {
        let noise = image(|row, column| (row * 97 + column * 59 + row * column * 31) as u8);
        for rows_cut in [0, 1, 7, 25] {
            let mut made = vec![0.0; 1500];
            let mut sums = vec![0.0; 1500];
            for (from, to, weight) in crop_weights(SIZE, rows_cut) {
                made[to] += weight * f64::from(noise[from]);
                sums[to] += weight;
            }
            assert!(sums.iter().all(|sum| (sum - 1.0_f64).abs() < 1e-12));
            for (made, &byte) in made.iter().zip(&cropped(&noise, SIZE, rows_cut)) {
                assert!((made - f64::from(byte)).abs() <= 0.5 + 1e-9);
            }
        }
    }

    #[test]
    fn a_crop_of_a_few_rows_moves_the_feet_below_and_keeps_the_top_and_the_middle() {
        // A pole of two columns with a plate below.
        let statue = image(|row, column| match (row, column) {
            (46.., _) | (_, 14 | 15) => 255,
            _ => 0,
        });
        let of = |rows_cut| {
            let variant = Variant {
                is_flipped: false,
                rows_cut,
            };
            varied(&statue, SIZE, variant)
        };
        let white = |image: &[u8], row: usize| {
            image[row * 30..][..30]
                .iter()
                .filter(|&&byte| byte == 255)
                .count()
        };
        for rows_cut in 1..5 {
            let found = of(rows_cut);
            assert_eq!(white(&found, 0), 2);
            // Columns are symmetric about the middle.
            let flipped = varied(&found, SIZE, FLIPPED);
            assert_eq!(found, flipped);
            let plate = (0..50).filter(|&row| white(&found, row) == 30).count();
            assert_eq!(plate, 4 - rows_cut);
        }
    }

    #[test]
    fn variants_are_named_by_what_was_done() {
        let all = Augmentation {
            flip: true,
            crops: Some(Crops { steps: 2, rows: 3 }),
        };
        let names: Vec<String> = all
            .variants()
            .into_iter()
            .map(|variant| variant.condition("normal"))
            .collect();
        assert_eq!(
            names,
            [
                "normal",
                "normal+flip",
                "normal+crop3",
                "normal+flip+crop3",
                "normal+crop6",
                "normal+flip+crop6"
            ]
        );
        assert_eq!(Augmentation::default().variants(), [Variant::default()]);
    }

    #[test]
    fn what_has_no_sides_is_refused() {
        let flip = Augmentation {
            flip: true,
            crops: None,
        };
        for template in Template::ALL {
            let is_refused = matches!(
                template,
                Template::Silhouettes | Template::Kfd | Template::RowWidth
            );
            assert_eq!(
                flip.check(template, SIZE).is_err(),
                is_refused,
                "{template:?}"
            );
            assert!(Augmentation::default().check(template, SIZE).is_ok());
        }
        let crops = |steps, rows| Augmentation {
            flip: false,
            crops: Some(Crops { steps, rows }),
        };
        assert!(crops(25, 1).check(Template::Gei, SIZE).is_ok());
        for (steps, rows) in [(26, 1), (0, 1), (1, 0), (usize::MAX, 2)] {
            let refused = crops(steps, rows).check(Template::Gei, SIZE);
            assert!(refused.is_err_and(|error| error.to_string().contains("25 rows")));
        }
    }
}
