//! Sums of frames for each pixel, from which GEI, GEnI and frequency 0 are computed.
//!
//! Bits are counted in planes: plane `k` holds the bits of worth 2^k of all pixels' counts,
//! so that one operation counts 64 pixels. Eight frames at a time go through carry-save
//! adders (Harley & Seal; Warren 2013, "Hacker's Delight", section 5-1).

use super::FrameError;
use super::entropy::EntropyTable;
use super::memory::Memory;
use crate::bit_adder::add_eight;
use crate::budget::{MAX_PIXELS, MAX_ROWS};
use crate::silhouette::{AnySilhouette, Size};
use crate::simd::{Simd, Wide, compiled, dispatch};
use core::ops::Range;

/// Rows of bits.
type BitPlane = [u64; MAX_ROWS];
/// Planes of a count: up to 65,535.
const PLANES: usize = 16;
/// Frames that are counted together.
const BATCH: usize = 8;

/// The sum of the frames for each pixel. 16 kB.
#[derive(Clone, Debug)]
pub struct FrameSums {
    size: Size,
    simd: Simd,
    frames: u32,
    kind: SumKind,
}

#[derive(Clone, Debug)]
#[expect(
    clippy::large_enum_variant,
    reason = "16 kB for a cycle; a box would need a heap"
)]
enum SumKind {
    /// No frame yet.
    None,
    /// Sums of bits, 1 a frame.
    Bits(Counter),
    /// Sums of ninths, 9 a frame.
    Ninths(Counter),
    /// Sums of bytes, 255 a frame.
    Grey([u32; MAX_PIXELS]),
}

impl FrameSums {
    /// The maximum number of frames for which the planes can count ninths.
    pub const MAX_FRAMES: u32 = 0xffff / 9;

    pub const fn new(size: Size, simd: Simd) -> Self {
        Self {
            size,
            simd,
            frames: 0,
            kind: SumKind::None,
        }
    }

    pub const fn size(&self) -> Size {
        self.size
    }

    /// Returns the mean of each pixel over the frames so far, 0..=255, rounded half up; 0 without
    /// frames.
    pub fn means(&mut self) -> [u8; MAX_PIXELS] {
        if let SumKind::Grey(_) = self.kind {
            let frames = self.frames;
            return self.map(0, |sum| rounded(sum, frames));
        }
        let scale = CountScale::new(self.whole().max(1));
        self.map(0, |sum| scale.mean(sum))
    }

    /// Returns the sum of a pixel that is on in all frames.
    pub const fn whole(&self) -> u32 {
        self.frames
            * match self.kind {
                SumKind::None | SumKind::Bits(_) => 1,
                SumKind::Ninths(_) => 9,
                SumKind::Grey(_) => 255,
            }
    }

    /// Maps each pixel's sum by `of`, row by row; `none` beyond the size, or everywhere without
    /// frames.
    #[inline(always)]
    pub fn map<T: Copy>(&mut self, none: T, mut of: impl FnMut(u32) -> T) -> [T; MAX_PIXELS] {
        let mut mapped = [none; MAX_PIXELS];
        let whole = self.whole();
        let counter = match &mut self.kind {
            SumKind::None => return mapped,
            SumKind::Bits(counter) | SumKind::Ninths(counter) => counter,
            SumKind::Grey(sums) => {
                let pixels = mapped.iter_mut().zip(sums).take(self.size.pixels());
                pixels.for_each(|(mapped, &mut sum)| *mapped = of(sum));
                return mapped;
            }
        };
        counter.settle();
        let bits = (u32::BITS - whole.leading_zeros()) as usize;
        let columns = self.size.columns();
        let rows = mapped.chunks_exact_mut(columns).take(self.size.rows());
        for (row, pixels) in rows.enumerate() {
            for (byte, pixels) in pixels.chunks_mut(8).enumerate() {
                let low = counter.eight_counts(row, byte, 0..bits.min(8));
                // Only for counts above 255.
                let high = counter.eight_counts(row, byte, 8..bits.max(8));
                for ((mapped, low), high) in pixels.iter_mut().zip(low).zip(high) {
                    *mapped = of(u32::from(low) + 256 * u32::from(high));
                }
            }
        }
        mapped
    }
}

impl FrameSums {
    /// Returns for each pixel Shannon's entropy of whether it is on (Bashir, Xiang & Gong 2009),
    /// scaled from the image's least (0) to its largest (255) and rounded half up. Black if all are
    /// equal.
    fn entropies(&mut self) -> [u8; MAX_PIXELS] {
        let table = EntropyTable::new(self.whole());
        let (mut least, mut largest) = (f64::INFINITY, f64::NEG_INFINITY);
        self.map((), |sum| {
            let bits = table.entropy(sum);
            least = least.min(bits);
            largest = largest.max(bits);
        });
        let range = largest - least;
        self.map(0, |sum| {
            if range > 0.0 {
                let byte = (table.entropy(sum) - least) * 255.0 / range;
                #[expect(
                    clippy::cast_possible_truncation,
                    clippy::cast_sign_loss,
                    reason = "0 to 255.5"
                )]
                {
                    (byte + 0.5) as u8
                }
            } else {
                0
            }
        })
    }
}

impl Memory for FrameSums {
    /// Adds a frame. The first frame decides the kind of sum, and later frames of another kind are
    /// converted.
    fn add(&mut self, frame: &AnySilhouette) -> Result<(), FrameError> {
        FrameError::check([self.size, frame.size()], self.frames, Self::MAX_FRAMES)?;
        self.frames += 1;
        if matches!(self.kind, SumKind::None) {
            self.kind = match frame {
                AnySilhouette::Binary(_) => SumKind::Bits(Counter::EMPTY),
                AnySilhouette::Ninths(_) => SumKind::Ninths(Counter::EMPTY),
                AnySilhouette::Grey(_) => SumKind::Grey([0; MAX_PIXELS]),
            };
        }
        let simd = self.simd;
        match (&mut self.kind, frame) {
            (SumKind::None, _) => {}
            (SumKind::Bits(counter), AnySilhouette::Binary(silhouette)) => {
                counter.add(silhouette.all_rows(), simd);
            }
            (SumKind::Bits(counter), frame) => counter.add(frame.silhouette().all_rows(), simd),
            (SumKind::Ninths(counter), AnySilhouette::Ninths(ninths)) => {
                dispatch!(simd, count_ninths(counter, ninths.planes()));
            }
            (SumKind::Ninths(counter), frame) => {
                // Nine samples: one and eight.
                let silhouette = frame.silhouette();
                counter.ripple(silhouette.all_rows(), 0);
                counter.ripple(silhouette.all_rows(), 3);
            }
            (SumKind::Grey(sums), frame) => {
                for (sum, &pixel) in sums.iter_mut().zip(frame.to_coverage().pixels()) {
                    *sum += u32::from(pixel);
                }
            }
        }
        Ok(())
    }

    fn frames(&self) -> u32 {
        self.frames
    }

    fn clear(&mut self) {
        self.frames = 0;
        self.kind = SumKind::None;
    }

    fn write(&mut self, template: super::TemplateKind, _: u32, bytes: &mut [u8]) {
        let pixels = match template {
            super::TemplateKind::Geni => self.entropies(),
            _ => self.means(),
        };
        for (byte, pixel) in bytes.iter_mut().zip(pixels) {
            *byte = pixel;
        }
    }
}

/// The means of counts, with a table for the usual counts.
pub(super) struct CountScale {
    all: u32,
    table: [u8; Self::TABLE],
}

impl CountScale {
    /// Counts of 56 frames of ninths.
    const TABLE: usize = 512;

    pub fn new(all: u32) -> Self {
        let mut table = [0; Self::TABLE];
        for (count, mean) in (0..=all).zip(&mut table) {
            *mean = rounded(255 * count, all);
        }
        Self { all, table }
    }

    pub fn mean(&self, count: u32) -> u8 {
        let known = self.table.get(count as usize).copied();
        known.unwrap_or_else(|| rounded(255 * count, self.all))
    }
}

/// Returns a mean of at most 255, rounded half up.
fn rounded(sum: u32, of: u32) -> u8 {
    u8::try_from((sum + of / 2) / of).unwrap_or(u8::MAX)
}

/// A count for each pixel. 12 kB.
#[derive(Clone, Debug)]
struct Counter {
    planes: [BitPlane; PLANES],
    /// Frames that wait for their batch to be full.
    waiting: [BitPlane; BATCH],
    waits: usize,
}

impl Counter {
    const EMPTY: Self = Self {
        planes: [[0; MAX_ROWS]; PLANES],
        waiting: [[0; MAX_ROWS]; BATCH],
        waits: 0,
    };

    /// Counts the bits of a frame.
    fn add(&mut self, rows: &BitPlane, simd: Simd) {
        if let Some(place) = self.waiting.get_mut(self.waits) {
            *place = *rows;
        }
        self.waits += 1;
        if self.waits == BATCH {
            self.waits = 0;
            dispatch!(simd, count(self));
        }
    }

    /// Adds 2^`worth` to the counts of the pixels whose bits are set.
    #[inline(always)]
    fn ripple(&mut self, rows: &BitPlane, worth: usize) {
        let mut carries = *rows;
        for plane in self.planes.iter_mut().skip(worth) {
            let mut rest = 0;
            for (bits, carry) in plane.iter_mut().zip(&mut carries) {
                (*bits, *carry) = (*bits ^ *carry, *bits & *carry);
                rest |= *carry;
            }
            if rest == 0 {
                break;
            }
        }
    }

    /// Counts the frames that wait.
    fn settle(&mut self) {
        for waiting in 0..self.waits {
            if let Some(rows) = self.waiting.get(waiting).copied() {
                self.ripple(&rows, 0);
            }
        }
        self.waits = 0;
    }

    /// Returns these bits, at most eight, of the counts of eight columns, without frames that wait.
    fn eight_counts(&self, row: usize, byte: usize, bits: Range<usize>) -> [u8; 8] {
        const ONES: u64 = 0x0101_0101_0101_0101;
        /// Bit k of byte k.
        const DIAGONAL: u64 = 0x8040_2010_0804_0201;
        let mut counts = 0;
        let planes = self.planes.get(bits).unwrap_or_default();
        for (worth, plane) in planes.iter().enumerate() {
            let bits = plane.get(row).map_or(0, |bits| bits >> (8 * byte) & 0xff);
            // A byte each, 0 or a power of two, and then 0 or 1.
            let spread = (bits * ONES) & DIAGONAL;
            counts |= (((spread + 0x7f * ONES) >> 7) & ONES) << worth;
        }
        counts.to_le_bytes()
    }
}

compiled!(fn count(counter: &mut Counter));
compiled!(fn count_ninths(counter: &mut Counter, planes: &[BitPlane; 4]));

/// Counts ninths by the worth of their bits, without waiting.
#[inline(always)]
fn count_ninths<L: Wide>(_: L, counter: &mut Counter, planes: &[BitPlane; 4]) {
    for (worth, plane) in planes.iter().enumerate() {
        counter.ripple(plane, worth);
    }
}

/// Counts the eight frames that wait.
#[inline(always)]
fn count<L: Wide>(_: L, counter: &mut Counter) {
    let mut eights = [0; MAX_ROWS];
    let [ones, twos, fours, ..] = &mut counter.planes;
    let [a, b, c, d, e, f, g, h] = &counter.waiting;
    for (row, eight) in eights.iter_mut().enumerate() {
        let bits = [
            a[row], b[row], c[row], d[row], e[row], f[row], g[row], h[row],
        ];
        let (digits, carry) = add_eight([ones[row], twos[row], fours[row]], bits);
        [ones[row], twos[row], fours[row]] = digits;
        *eight = carry;
    }
    counter.ripple(&eights, 3);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::silhouette::{Coverage, Ninths, Silhouette};

    const SIZE: Size = Size::S50x30;

    /// Returns frame `number`, in which pixel (r, c) is on if the fifth bit of a sum of multiples
    /// of all three is set.
    fn frame(number: u64) -> Silhouette {
        let bit = |row: u64, column: u64| (row * 7 + column * 13 + number * 29) >> 4 & 1;
        let rows: heapless::Vec<u64, MAX_ROWS> = (0..50)
            .map(|row| (0..30).map(|column| bit(row, column) << column).sum())
            .collect();
        Silhouette::from_rows(SIZE, &rows)
    }

    #[test]
    fn counts_are_those_of_single_pixels_whatever_the_number_of_frames() {
        for frames in [1, 7, 8, 9, 31, 64, 300] {
            let mut sums = FrameSums::new(SIZE, Simd::widest());
            let mut plain = [0u32; 1_500];
            for number in 0..frames {
                let frame = frame(number);
                sums.add(&AnySilhouette::Binary(frame)).expect("room");
                for (pixel, sum) in plain.iter_mut().enumerate() {
                    *sum += u32::from(frame.is_on(pixel / 30, pixel % 30));
                }
            }
            let means = sums.means();
            for (mean, sum) in means.iter().zip(plain) {
                let expected = (f64::from(sum) * 255.0 / frames as f64 + 0.5).floor();
                assert_eq!(f64::from(*mean), expected);
            }
        }
    }

    #[test]
    fn ninths_are_counted_by_their_worth() {
        let images: [Silhouette; 9] = core::array::from_fn(|image| frame(image as u64));
        let ninths = AnySilhouette::Ninths(Ninths::count(&images));
        let mut sums = FrameSums::new(SIZE, Simd::widest());
        let mut parts = FrameSums::new(SIZE, Simd::widest());
        for _ in 0..3 {
            sums.add(&ninths).expect("room");
            for image in &images {
                parts.add(&AnySilhouette::Binary(*image)).expect("room");
            }
        }
        assert_eq!(sums.means(), parts.means());
        // Bits among ninths count as nine ninths.
        sums.add(&AnySilhouette::Binary(images[0])).expect("room");
        for _ in 0..9 {
            parts.add(&AnySilhouette::Binary(images[0])).expect("room");
        }
        assert_eq!(sums.means(), parts.means());
    }

    #[test]
    fn a_frame_of_another_size_is_refused() {
        let mut sums = FrameSums::new(SIZE, Simd::widest());
        let refused = sums.add(&AnySilhouette::Grey(Coverage::empty(Size::S64x44)));
        let (expected, found) = (SIZE, Size::S64x44);
        assert_eq!(refused, Err(FrameError::Size { expected, found }));
        assert_eq!(sums.frames(), 0);
        assert_eq!(sums.means(), [0; MAX_PIXELS]);
    }

    #[test]
    fn a_frame_after_7281_is_refused_and_changes_nothing() {
        let mut sums = FrameSums::new(SIZE, Simd::widest());
        let white = AnySilhouette::Binary(Silhouette::from_rows(SIZE, &[1]));
        for _ in 0..FrameSums::MAX_FRAMES {
            sums.add(&white).expect("room");
        }
        let black = AnySilhouette::Binary(Silhouette::empty(SIZE));
        let full = Err(FrameError::Full { frames: 7_281 });
        assert_eq!(sums.add(&black), full);
        assert_eq!((sums.frames(), sums.means()[0]), (7_281, 255));
    }
}
