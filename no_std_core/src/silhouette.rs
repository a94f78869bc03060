//! Silhouettes at 50x30: bits, or grey coverage.

use crate::budget::{COLUMNS, PIXELS, ROWS};
use core::fmt;

/// A binary silhouette: 50 rows of 30 bits. 200 bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Silhouette {
    /// Bit `c` of row `r` is the pixel in column `c`; row 0 is on top. Bits from
    /// 30 on are zero.
    rows: [u32; ROWS],
}

impl Silhouette {
    /// No pixel on.
    pub const EMPTY: Self = Self { rows: [0; ROWS] };

    /// A silhouette from rows of bits; bits from 30 on are dropped.
    #[must_use]
    pub fn from_rows(rows: [u32; ROWS]) -> Self {
        Self {
            rows: rows.map(|row| row & ((1 << COLUMNS) - 1)),
        }
    }

    /// The rows; bit `c` is column `c`.
    #[must_use]
    pub const fn rows(&self) -> &[u32; ROWS] {
        &self.rows
    }

    /// Whether the pixel is on; off outside 50x30.
    #[must_use]
    pub fn is_on(&self, row: usize, column: usize) -> bool {
        column < COLUMNS
            && self
                .rows
                .get(row)
                .is_some_and(|bits| bits >> column & 1 == 1)
    }

    /// How many pixels are on.
    #[must_use]
    pub fn area(&self) -> u32 {
        self.rows.iter().map(|row| row.count_ones()).sum()
    }

    /// Pixels on in both over pixels on in either (Jaccard 1912), 0..=1. Two empty
    /// silhouettes are equal: 1.
    #[must_use]
    pub fn jaccard(&self, other: &Self) -> f32 {
        let (mut both, mut either) = (0u16, 0u16);
        for (a, b) in self.rows.iter().zip(&other.rows) {
            #[expect(clippy::cast_possible_truncation, reason = "at most 30 a row")]
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

    /// The same as bytes, row by row: 0 or 255.
    #[must_use]
    pub fn to_pixels(&self) -> [u8; PIXELS] {
        let mut pixels = [0; PIXELS];
        for (row, out) in self.rows.iter().zip(pixels.chunks_exact_mut(COLUMNS)) {
            for (column, pixel) in out.iter_mut().enumerate() {
                *pixel = if row >> column & 1 == 1 { 255 } else { 0 };
            }
        }
        pixels
    }
}

/// Text art: 50 lines of `#` and `.`.
impl fmt::Display for Silhouette {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for row in &self.rows {
            for column in 0..COLUMNS {
                f.write_str(if row >> column & 1 == 1 { "#" } else { "." })?;
            }
            f.write_str("\n")?;
        }
        Ok(())
    }
}

/// A grey silhouette: how much of each pixel is covered, 0..=255. 1,500 bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Coverage {
    /// Row by row from the top.
    pub pixels: [u8; PIXELS],
}

impl Coverage {
    /// The pixels that are at least half covered.
    #[must_use]
    pub fn to_silhouette(&self) -> Silhouette {
        let mut rows = [0u32; ROWS];
        for (row, pixels) in rows.iter_mut().zip(self.pixels.chunks_exact(COLUMNS)) {
            for (column, &pixel) in pixels.iter().enumerate() {
                *row |= u32::from(pixel >= 128) << column;
            }
        }
        Silhouette { rows }
    }
}

/// What a rasteriser draws: bits where it samples once a pixel, grey otherwise.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[expect(
    clippy::large_enum_variant,
    reason = "1.5 kB on the stack for one frame; a box would need a heap"
)]
pub enum Frame {
    /// One sample a pixel.
    Binary(Silhouette),
    /// Several samples a pixel.
    Grey(Coverage),
}

impl Frame {
    /// The binary silhouette: grey pixels are on from half coverage up.
    #[must_use]
    pub fn silhouette(&self) -> Silhouette {
        match self {
            Self::Binary(silhouette) => *silhouette,
            Self::Grey(coverage) => coverage.to_silhouette(),
        }
    }

    /// Row by row from the top, 0..=255.
    #[must_use]
    pub fn to_pixels(&self) -> [u8; PIXELS] {
        match self {
            Self::Binary(silhouette) => silhouette.to_pixels(),
            Self::Grey(coverage) => coverage.pixels,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows(first: &[u32]) -> Silhouette {
        let mut rows = [0; ROWS];
        rows[..first.len()].copy_from_slice(first);
        Silhouette::from_rows(rows)
    }

    #[test]
    fn jaccard_is_shared_over_covered() {
        // [[1,1,0],[0,1,0]] and [[1,0,0],[0,1,1]] share 2 of 4 pixels.
        let (a, b) = (rows(&[0b011, 0b010]), rows(&[0b001, 0b110]));
        assert_eq!(a.jaccard(&b), 0.5);
        assert_eq!(Silhouette::EMPTY.jaccard(&Silhouette::EMPTY), 1.0);
        assert_eq!(a.jaccard(&Silhouette::EMPTY), 0.0);
    }

    #[test]
    fn bits_and_pixels_agree() {
        let silhouette = rows(&[0b101, 1 << 29 | 1 << 30]);
        assert_eq!(silhouette.area(), 3);
        assert!(silhouette.is_on(0, 2) && !silhouette.is_on(0, 1) && !silhouette.is_on(1, 30));
        let pixels = silhouette.to_pixels();
        assert_eq!(pixels[..4], [255, 0, 255, 0]);
        assert_eq!(Coverage { pixels }.to_silhouette(), silhouette);
    }

    #[test]
    fn half_coverage_is_on() {
        let mut pixels = [0; PIXELS];
        pixels[0] = 127;
        pixels[1] = 128;
        assert_eq!(Coverage { pixels }.to_silhouette(), rows(&[0b10]));
    }
}
