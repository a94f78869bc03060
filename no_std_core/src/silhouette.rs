//! Silhouettes: bits or grey coverage, in one of three sizes.

use crate::bit_adder::full_add;
use crate::budget::{COLUMNS, MAX_COLUMNS, MAX_PIXELS, MAX_ROWS, ROWS};
use core::fmt;

/// The rows and columns of a silhouette or template. Each size is drawn natively, without
/// resampling.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Size {
    /// 50 rows by 30 columns: Charalambous & Bharath (BMVC 2016).
    #[default]
    S50x30,
    /// 64 rows by 44 columns: OpenGait (Fan et al. 2023), sides cut off.
    S64x44,
    /// 64 rows by 64 columns: OpenGait (Fan et al. 2023).
    S64x64,
}

impl Size {
    /// All sizes.
    pub const ALL: [Self; 3] = [Self::S50x30, Self::S64x44, Self::S64x64];

    /// Returns the number of rows.
    #[must_use]
    pub const fn rows(self) -> usize {
        match self {
            Self::S50x30 => ROWS,
            Self::S64x44 | Self::S64x64 => MAX_ROWS,
        }
    }

    /// Returns the number of columns.
    #[must_use]
    pub const fn columns(self) -> usize {
        match self {
            Self::S50x30 => COLUMNS,
            Self::S64x44 => 44,
            Self::S64x64 => MAX_COLUMNS,
        }
    }

    /// Returns the number of pixels.
    #[must_use]
    pub const fn pixels(self) -> usize {
        self.rows() * self.columns()
    }

    /// Returns the name that results use for it, such as `50x30`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::S50x30 => "50x30",
            Self::S64x44 => "64x44",
            Self::S64x64 => "64x64",
        }
    }
}

impl fmt::Display for Size {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A binary silhouette: rows of bits. 520 bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Silhouette {
    size: Size,
    /// Bit `c` of row `r` is the pixel in column `c`; row 0 is on top. Bits and rows
    /// beyond the size are zero.
    rows: [u64; MAX_ROWS],
}

impl Silhouette {
    /// Makes a silhouette with no pixel on.
    #[must_use]
    pub const fn empty(size: Size) -> Self {
        Self {
            size,
            rows: [0; MAX_ROWS],
        }
    }

    /// Makes a silhouette from rows of bits, the upper one first. Missing rows are empty; rows and
    /// bits beyond the size are dropped.
    #[must_use]
    pub fn from_rows(size: Size, rows: &[u64]) -> Self {
        let mut silhouette = Self::empty(size);
        let mask = u64::MAX >> (MAX_COLUMNS - size.columns());
        let kept = silhouette.rows.iter_mut().take(size.rows());
        for (row, bits) in kept.zip(rows) {
            *row = bits & mask;
        }
        silhouette
    }

    /// Returns the rows and columns.
    #[must_use]
    pub const fn size(&self) -> Size {
        self.size
    }

    /// Returns the rows from the top; bit `c` is column `c`.
    #[must_use]
    pub fn rows(&self) -> &[u64] {
        self.rows.get(..self.size.rows()).unwrap_or_default()
    }

    /// Returns the rows, followed by empty rows up to the largest size.
    pub(crate) const fn all_rows(&self) -> &[u64; MAX_ROWS] {
        &self.rows
    }

    /// Returns all rows to write to. Bits and rows beyond the size have to stay zero.
    pub(crate) const fn all_rows_mut(&mut self) -> &mut [u64; MAX_ROWS] {
        &mut self.rows
    }

    /// Turns on the pixels of 32 columns of each row, the first of them at column `left`. Bits
    /// outside are dropped.
    #[inline(always)]
    pub(crate) fn add_columns(&mut self, bits: impl Iterator<Item = u32>, left: isize) {
        let mask = u64::MAX >> (MAX_COLUMNS - self.size.columns());
        let by = u32::try_from(left.unsigned_abs()).unwrap_or(u32::MAX);
        let rows = self.rows.iter_mut().zip(bits).take(self.size.rows());
        if left < 0 && by < u32::BITS {
            rows.for_each(|(row, bits)| *row |= u64::from(bits >> by) & mask);
        } else if left >= 0 && by < u32::BITS && self.size.columns() <= 32 {
            // Like the next case, in one register of a microcontroller.
            rows.for_each(|(row, bits)| *row |= u64::from(bits << by) & mask);
        } else if left >= 0 && by < u64::BITS {
            rows.for_each(|(row, bits)| *row |= u64::from(bits) << by & mask);
        }
    }

    /// Returns whether the pixel is on; pixels outside the silhouette are off.
    #[must_use]
    pub fn is_on(&self, row: usize, column: usize) -> bool {
        column < MAX_COLUMNS
            && self
                .rows
                .get(row)
                .is_some_and(|bits| bits >> column & 1 == 1)
    }

    /// Returns the number of pixels that are on.
    #[must_use]
    pub fn area(&self) -> u32 {
        self.rows.iter().map(|row| row.count_ones()).sum()
    }

    /// Returns the Jaccard index (Jaccard 1912), 0..=1: the number of pixels that are on in both,
    /// divided by the number that are on in either, with the upper left pixels aligned. Two empty
    /// silhouettes are equal: 1.
    #[must_use]
    pub fn jaccard(&self, other: &Self) -> f32 {
        let (mut both, mut either) = (0u16, 0u16);
        for (a, b) in self.rows.iter().zip(&other.rows) {
            #[expect(clippy::cast_possible_truncation, reason = "at most 64 a row")]
            {
                both += (a & b).count_ones() as u16;
                either += (a | b).count_ones() as u16;
            }
        }
        if either == 0 {
            return 1.0;
        }
        f32::from(both) / f32::from(either)
    }

    /// Returns the pixels as bytes: 0 or 255.
    #[must_use]
    pub fn to_coverage(&self) -> Coverage {
        let mut coverage = Coverage::empty(self.size);
        let out = coverage.pixels_mut().chunks_exact_mut(self.size.columns());
        for (row, out) in self.rows.iter().zip(out) {
            for (column, pixel) in out.iter_mut().enumerate() {
                *pixel = if row >> column & 1 == 1 { 255 } else { 0 };
            }
        }
        coverage
    }
}

/// Writes text art: a line of `#` and `.` for each row.
impl fmt::Display for Silhouette {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for row in self.rows() {
            for column in 0..self.size.columns() {
                f.write_str(if row >> column & 1 == 1 { "#" } else { "." })?;
            }
            f.write_str("\n")?;
        }
        Ok(())
    }
}

/// A grey silhouette: how much of each pixel is covered, 0..=255. 4,097 bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Coverage {
    size: Size,
    /// Bytes beyond the size are zero.
    pixels: [u8; MAX_PIXELS],
}

impl Coverage {
    /// Makes a silhouette with nothing covered.
    #[must_use]
    pub const fn empty(size: Size) -> Self {
        Self {
            size,
            pixels: [0; MAX_PIXELS],
        }
    }

    /// Returns the rows and columns.
    #[must_use]
    pub const fn size(&self) -> Size {
        self.size
    }

    /// Returns the pixels row by row from the top, as many bytes as the size has pixels.
    #[must_use]
    pub fn pixels(&self) -> &[u8] {
        self.pixels.get(..self.size.pixels()).unwrap_or_default()
    }

    /// Returns the pixels to write to.
    pub fn pixels_mut(&mut self) -> &mut [u8] {
        self.pixels
            .get_mut(..self.size.pixels())
            .unwrap_or_default()
    }

    /// Returns the pixels that are at least half covered.
    #[must_use]
    pub fn to_silhouette(&self) -> Silhouette {
        let mut silhouette = Silhouette::empty(self.size);
        let pixels = self.pixels().chunks_exact(self.size.columns());
        for (row, pixels) in silhouette.rows.iter_mut().zip(pixels) {
            for (column, &pixel) in pixels.iter().enumerate() {
                *row |= u64::from(pixel >= 128) << column;
            }
        }
        silhouette
    }
}

/// A grey silhouette of nine samples a pixel, counted in bits. 2,056 bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ninths {
    size: Size,
    /// The binary digits of the number of samples that are on, 0 to 9: rows of bits worth 1, 2, 4
    /// and 8.
    planes: [[u64; MAX_ROWS]; 4],
}

impl Ninths {
    /// Counts the samples of nine silhouettes of one size, by full adders.
    #[must_use]
    pub(crate) fn count(images: &[Silhouette; 9]) -> Self {
        let [first, ..] = images;
        let mut ninths = Self {
            size: first.size,
            planes: [[0; MAX_ROWS]; 4],
        };
        let [ones, twos, fours, eights] = &mut ninths.planes;
        let planes = ones.iter_mut().zip(twos).zip(fours).zip(eights);
        for (row, (((one, two), four), eight)) in planes.enumerate() {
            let [a, b, c, d, e, f, g, h, i] = images
                .each_ref()
                .map(|image| image.rows.get(row).copied().unwrap_or_default());
            let (a, carry_a) = full_add(a, b, c);
            let (b, carry_b) = full_add(d, e, f);
            let (c, carry_c) = full_add(g, h, i);
            let (sum, carry) = full_add(a, b, c);
            let (twos, carry_twos) = full_add(carry_a, carry_b, carry_c);
            (*one, *two) = (sum, twos ^ carry);
            (*four, *eight) = (carry_twos ^ (twos & carry), carry_twos & twos & carry);
        }
        ninths
    }

    /// Returns the rows and columns.
    #[must_use]
    pub const fn size(&self) -> Size {
        self.size
    }

    /// Returns the number of samples of all pixels that are on.
    pub(crate) fn samples(&self) -> u32 {
        let on = |plane: &[u64; MAX_ROWS]| plane.iter().map(|row| row.count_ones()).sum::<u32>();
        (0..)
            .zip(&self.planes)
            .map(|(worth, plane)| on(plane) << worth)
            .sum()
    }

    /// Returns rows of the bits worth 1, 2, 4 and 8.
    pub(crate) const fn planes(&self) -> &[[u64; MAX_ROWS]; 4] {
        &self.planes
    }

    /// Returns the pixels with at least five samples on.
    #[must_use]
    pub fn to_silhouette(&self) -> Silhouette {
        let mut silhouette = Silhouette::empty(self.size);
        let [ones, twos, fours, eights] = &self.planes;
        let planes = ones.iter().zip(twos).zip(fours).zip(eights);
        for (row, (((one, two), four), eight)) in silhouette.rows.iter_mut().zip(planes) {
            *row = eight | (four & (one | two));
        }
        silhouette
    }

    /// Returns the pixels as bytes: ninths of 255, rounded half up.
    #[must_use]
    pub fn to_coverage(&self) -> Coverage {
        let mut coverage = Coverage::empty(self.size);
        let columns = self.size.columns();
        for (row, pixels) in coverage.pixels_mut().chunks_exact_mut(columns).enumerate() {
            for (column, pixel) in pixels.iter_mut().enumerate() {
                let bits = (0..).zip(&self.planes).map(|(worth, plane)| {
                    let bit = plane.get(row).map_or(0, |bits| bits >> column & 1);
                    bit << worth
                });
                let on: u64 = bits.sum();
                // Rounded half up: 255 and 9 have a common factor of 3.
                *pixel = u8::try_from((on * 170 + 3) / 6).unwrap_or(u8::MAX);
            }
        }
        coverage
    }
}

/// The image of any rasteriser: bits with one sample a pixel, otherwise grey.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[expect(
    clippy::large_enum_variant,
    reason = "4 kB on the stack for one frame; a box would need a heap"
)]
pub enum AnySilhouette {
    /// One sample a pixel.
    Binary(Silhouette),
    /// Nine samples a pixel.
    Ninths(Ninths),
    /// tiny-skia's coverage.
    Grey(Coverage),
}

impl AnySilhouette {
    /// Returns the rows and columns.
    #[must_use]
    pub const fn size(&self) -> Size {
        match self {
            Self::Binary(silhouette) => silhouette.size(),
            Self::Ninths(ninths) => ninths.size(),
            Self::Grey(coverage) => coverage.size(),
        }
    }

    /// Returns the binary silhouette: grey pixels are on from half coverage up.
    #[must_use]
    pub fn silhouette(&self) -> Silhouette {
        match self {
            Self::Binary(silhouette) => *silhouette,
            Self::Ninths(ninths) => ninths.to_silhouette(),
            Self::Grey(coverage) => coverage.to_silhouette(),
        }
    }

    /// Returns the pixels as bytes; bits become 0 or 255.
    #[must_use]
    pub fn to_coverage(&self) -> Coverage {
        match self {
            Self::Binary(silhouette) => silhouette.to_coverage(),
            Self::Ninths(ninths) => ninths.to_coverage(),
            Self::Grey(coverage) => *coverage,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SMALL: Size = Size::S50x30;

    fn rows(first: &[u64]) -> Silhouette {
        Silhouette::from_rows(SMALL, first)
    }

    #[test]
    fn jaccard_is_shared_over_covered() {
        // [[1,1,0],[0,1,0]] and [[1,0,0],[0,1,1]] share 2 of 4 pixels.
        let (a, b) = (rows(&[0b011, 0b010]), rows(&[0b001, 0b110]));
        let empty = Silhouette::empty(SMALL);
        assert_eq!(a.jaccard(&b), 0.5);
        assert_eq!(empty.jaccard(&empty), 1.0);
        assert_eq!(a.jaccard(&empty), 0.0);
    }

    #[test]
    fn bits_and_pixels_agree_in_all_sizes() {
        let silhouette = rows(&[0b101, 1 << 29 | 1 << 30]);
        assert_eq!(silhouette.area(), 3);
        assert!(silhouette.is_on(0, 2) && !silhouette.is_on(0, 1) && !silhouette.is_on(1, 30));
        assert_eq!(silhouette.to_coverage().pixels()[..4], [255, 0, 255, 0]);
        for (size, last_row, last_column) in [
            (Size::S50x30, 49, 29),
            (Size::S64x44, 63, 43),
            (Size::S64x64, 63, 63),
        ] {
            let all = Silhouette::from_rows(size, &[u64::MAX; 70]);
            assert_eq!(all.area() as usize, size.pixels());
            assert!(all.is_on(last_row, last_column));
            assert!(!all.is_on(last_row + 1, 0) && !all.is_on(0, last_column + 1));
            let coverage = all.to_coverage();
            assert!(coverage.pixels().iter().all(|&pixel| pixel == 255));
            assert_eq!(coverage.pixels().len(), (last_row + 1) * (last_column + 1));
            assert_eq!(coverage.to_silhouette(), all);
        }
    }

    #[test]
    fn nine_samples_are_counted() {
        // Column k of the first row is on in the first k images.
        let images: [Silhouette; 9] =
            core::array::from_fn(|image| rows(&[0x3ff << (image + 1) & 0x3ff]));
        let ninths = Ninths::count(&images);
        let expected = [0, 28, 57, 85, 113, 142, 170, 198, 227, 255];
        assert_eq!(ninths.to_coverage().pixels()[..10], expected);
        // Columns from five on.
        assert_eq!(ninths.to_silhouette(), rows(&[0x3e0]));
    }

    #[test]
    fn half_coverage_is_on() {
        let mut coverage = Coverage::empty(SMALL);
        coverage.pixels_mut()[..2].copy_from_slice(&[127, 128]);
        assert_eq!(coverage.to_silhouette(), rows(&[0b10]));
    }
}
