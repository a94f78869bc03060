//! Sixteen numbers at once: portably, and with the wider registers of some processors.
//!
//! All do the same IEEE 754 operations in the same order, without fused ones, so that
//! pictures do not depend on which is used; `tests/simd.rs` compares them bit for bit.

#[cfg(target_arch = "x86_64")]
mod avx2;
#[cfg(target_arch = "x86_64")]
mod avx512;
#[cfg(target_arch = "aarch64")]
mod neon;
mod portable;

#[cfg(target_arch = "x86_64")]
pub(crate) use avx2::Avx2;
#[cfg(target_arch = "x86_64")]
pub(crate) use avx512::Avx512;
#[cfg(target_arch = "aarch64")]
pub(crate) use neon::Neon;
pub(crate) use portable::Portable;

pub(crate) use crate::budget::LANES;
use crate::budget::MAX_HULL_EDGES;
use core::fmt;

/// Which instructions draw.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Simd(Kind);

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    Portable(Portable),
    #[cfg(target_arch = "x86_64")]
    Avx2(Avx2),
    #[cfg(target_arch = "x86_64")]
    Avx512(Avx512),
    #[cfg(target_arch = "aarch64")]
    Neon(Neon),
}

impl Simd {
    /// What the compiler makes for every processor of the target.
    pub const PORTABLE: Self = Self(Kind::Portable(Portable));

    /// The widest that this processor has.
    #[must_use]
    pub fn widest() -> Self {
        Self::available().last().unwrap_or(Self::PORTABLE)
    }

    /// All that this processor has, the narrowest first.
    pub fn available() -> impl Iterator<Item = Self> {
        #[cfg(target_arch = "x86_64")]
        let wider = [
            Avx2::detect().map(Kind::Avx2),
            Avx512::detect().map(Kind::Avx512),
        ];
        #[cfg(target_arch = "aarch64")]
        let wider = [Some(Kind::Neon(Neon))];
        #[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
        let wider = [None];
        core::iter::once(Self::PORTABLE).chain(wider.into_iter().flatten().map(Self))
    }

    /// The name under which results state it.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self.0 {
            Kind::Portable(_) => "portable",
            #[cfg(target_arch = "x86_64")]
            Kind::Avx2(_) => "avx2",
            #[cfg(target_arch = "x86_64")]
            Kind::Avx512(_) => "avx512",
            #[cfg(target_arch = "aarch64")]
            Kind::Neon(_) => "neon",
        }
    }

    pub(crate) const fn kind(self) -> Kind {
        self.0
    }
}

impl fmt::Display for Simd {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// Straight lines between two points of the image: `x + slope * (row - y)` for rows in
/// `top..=bottom`, the top left out. By part, so that sixteen are written at once.
#[derive(Clone, Debug)]
pub(crate) struct Lines {
    pub x: [f32; MAX_LINES],
    pub y: [f32; MAX_LINES],
    pub slope: [f32; MAX_LINES],
    pub top: [f32; MAX_LINES],
    pub bottom: [f32; MAX_LINES],
}

/// One of them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Line {
    pub x: f32,
    pub y: f32,
    pub slope: f32,
    pub top: f32,
    pub bottom: f32,
}

/// All edges of a hull, in whole lanes, and lanes that the last ones may reach into.
pub(crate) const MAX_LINES: usize = MAX_HULL_EDGES.next_multiple_of(LANES) + LANES;

impl Lines {
    pub const EMPTY: Self = Self {
        x: [0.0; MAX_LINES],
        y: [0.0; MAX_LINES],
        slope: [0.0; MAX_LINES],
        top: [0.0; MAX_LINES],
        bottom: [0.0; MAX_LINES],
    };

    /// All lines, whether written or not.
    #[inline(always)]
    pub fn iter(&self) -> impl Iterator<Item = Line> + '_ {
        let parts = self.x.iter().zip(&self.y).zip(&self.slope);
        let parts = parts.zip(&self.top).zip(&self.bottom);
        parts.map(|((((&x, &y), &slope), &top), &bottom)| Line {
            x,
            y,
            slope,
            top,
            bottom,
        })
    }
}

/// The points and edges of one hull in the image.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Edges<'a> {
    /// Of its points, and whatever stands behind them up to 32.
    pub x: &'a [f32; 32],
    pub y: &'a [f32; 32],
    /// Points at which the edges begin and end.
    pub from: &'a [u8],
    pub to: &'a [u8],
    /// Which of its edges to take: numbers 0 to 63, then 64 to 89.
    pub outline: [u64; 2],
}

/// The points and edges of one hull, as one azimuth sees them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Solid<'a> {
    /// Of its points, and whatever stands behind them up to 32: to the right, upwards, and
    /// towards the camera.
    pub points: [&'a [f32; 32]; 3],
    /// Points at which the edges begin and end, of at most 64 edges.
    pub from: &'a [u8],
    pub to: &'a [u8],
}

/// A function of `lanes` compiled for each of the instruction sets: `compiled!` makes, for a
/// generic function of that name, those that `dispatch!` chooses from.
macro_rules! compiled {
    (fn $name:ident($($argument:ident: $type:ty),*) $(-> $result:ty)?) => {
        /// The same function for each instruction set.
        #[cfg(target_arch = "x86_64")]
        mod $name {
            use super::*;

            #[target_feature(enable = "avx2,bmi1,bmi2,popcnt")]
            pub fn avx2(
                lanes: crate::raster::simd::Avx2,
                $($argument: $type),*
            ) $(-> $result)? {
                super::$name(lanes, $($argument),*)
            }

            #[target_feature(
                enable = "avx2,bmi1,bmi2,popcnt,avx512f,avx512bw,avx512dq,avx512vl,avx512vpopcntdq,avx512vbmi2"
            )]
            pub fn avx512(
                lanes: crate::raster::simd::Avx512,
                $($argument: $type),*
            ) $(-> $result)? {
                super::$name(lanes, $($argument),*)
            }
        }
    };
}

macro_rules! dispatch {
    ($simd:expr, $name:ident($($argument:expr),*)) => {
        match $simd.kind() {
            crate::raster::simd::Kind::Portable(lanes) => $name(lanes, $($argument),*),
            #[cfg(target_arch = "x86_64")]
            #[expect(unsafe_code, reason = "a value of that kind was made after asking")]
            // SAFETY: such a value exists only where the processor has the instructions.
            crate::raster::simd::Kind::Avx2(lanes) => unsafe { $name::avx2(lanes, $($argument),*) },
            #[cfg(target_arch = "x86_64")]
            #[expect(unsafe_code, reason = "a value of that kind was made after asking")]
            // SAFETY: such a value exists only where the processor has the instructions.
            crate::raster::simd::Kind::Avx512(lanes) => unsafe {
                $name::avx512(lanes, $($argument),*)
            },
            #[cfg(target_arch = "aarch64")]
            crate::raster::simd::Kind::Neon(lanes) => $name(lanes, $($argument),*),
        }
    };
}

pub(crate) use {compiled, dispatch};

/// What is worked on 16 numbers at once. A value is the proof that the processor can.
pub(crate) trait Lanes: Copy {
    /// Sixteen `f32`.
    type Floats: Copy;
    /// Sixteen `u32`.
    type Words: Copy;
    /// Sixteen truth values.
    type Mask: Copy;
    /// The exclusive or of some `u64`, not yet put together.
    type Parity: Copy;

    fn splat(self, value: f32) -> Self::Floats;
    fn load(self, from: &[f32; LANES]) -> Self::Floats;
    fn store(self, floats: Self::Floats, to: &mut [f32; LANES]);
    fn add(self, a: Self::Floats, b: Self::Floats) -> Self::Floats;
    fn sub(self, a: Self::Floats, b: Self::Floats) -> Self::Floats;
    fn mul(self, a: Self::Floats, b: Self::Floats) -> Self::Floats;
    fn div(self, a: Self::Floats, b: Self::Floats) -> Self::Floats;
    /// `a` where it is less than `b`, otherwise `b`.
    fn min(self, a: Self::Floats, b: Self::Floats) -> Self::Floats;
    /// `a` where it is greater than `b`, otherwise `b`.
    fn max(self, a: Self::Floats, b: Self::Floats) -> Self::Floats;
    /// Whether `a < b`.
    fn less(self, a: Self::Floats, b: Self::Floats) -> Self::Mask;
    fn and(self, a: Self::Mask, b: Self::Mask) -> Self::Mask;
    fn all(self, mask: Self::Mask) -> bool;
    /// Whether `a >= b`; not of a NaN.
    fn not_less(self, a: Self::Floats, b: Self::Floats) -> Self::Mask;
    /// Whether `top < row <= bottom`.
    fn within(self, top: Self::Floats, row: Self::Floats, bottom: Self::Floats) -> Self::Mask;
    /// Makes the span from the first to the second number reach `x` where the mask is set.
    fn widen(
        self,
        span: (Self::Floats, Self::Floats),
        x: Self::Floats,
        mask: Self::Mask,
    ) -> (Self::Floats, Self::Floats);
    /// The integer part of numbers from 0 to 2^24.
    fn truncate(self, floats: Self::Floats) -> Self::Words;

    fn splat_word(self, value: u32) -> Self::Words;
    fn load_words(self, from: &[u32; LANES]) -> Self::Words;
    fn store_words(self, words: Self::Words, to: &mut [u32; LANES]);
    /// Sets in `to` the bits of `words`, in halves that later halves may be read from.
    fn merge(self, words: Self::Words, to: &mut [u32; LANES]);
    /// Wrapping.
    fn add_words(self, a: Self::Words, b: Self::Words) -> Self::Words;
    /// Wrapping.
    fn sub_words(self, a: Self::Words, b: Self::Words) -> Self::Words;
    fn and_words(self, a: Self::Words, b: Self::Words) -> Self::Words;
    /// The greater of signed numbers.
    fn max_words(self, a: Self::Words, b: Self::Words) -> Self::Words;
    /// Two to the power of each, 0 from 32 on.
    fn power_of_two(self, exponents: Self::Words) -> Self::Words;
    fn count_ones(self, words: Self::Words) -> Self::Words;
    /// The bits from each number on, none from 32 on.
    fn bits_from(self, first: Self::Words) -> Self::Words;
    /// All bits but so many highest ones, none from 32 on.
    fn bits_but(self, highest: Self::Words) -> Self::Words;
    /// `a` without the bits of `b`.
    fn without(self, a: Self::Words, b: Self::Words) -> Self::Words;

    fn no_parity(self) -> Self::Parity;
    /// With those numbers that the mask names.
    fn toggle(self, parity: Self::Parity, mask: Self::Mask, numbers: &[u64; LANES])
    -> Self::Parity;
    fn parity(self, parity: Self::Parity) -> u64;
    /// With the bits of those numbers that the mask names; it began as [`Self::no_parity`].
    fn unite(self, union: Self::Parity, mask: Self::Mask, numbers: &[u64; LANES]) -> Self::Parity;
    fn union(self, union: Self::Parity) -> u64;

    /// Writes the lines of a hull's outline: how many, the least top and the greatest bottom.
    #[inline(always)]
    fn lines(self, edges: Edges<'_>, lines: &mut Lines) -> (usize, f32, f32) {
        let mut count = 0;
        let (mut least, mut greatest) = (f32::INFINITY, f32::NEG_INFINITY);
        for (base, half) in [0, 64].into_iter().zip(edges.outline) {
            let mut left = half;
            while left != 0 {
                let edge = base + left.trailing_zeros() as usize;
                left &= left - 1;
                let (Some(&a), Some(&b)) = (edges.from.get(edge), edges.to.get(edge)) else {
                    break;
                };
                let [a, b] = [a, b].map(|end| usize::from(end) % 32);
                let (ax, ay, bx, by) = (edges.x[a], edges.y[a], edges.x[b], edges.y[b]);
                let at = count % MAX_LINES;
                lines.x[at] = ax;
                lines.y[at] = ay;
                lines.slope[at] = (bx - ax) / (by - ay);
                let (top, bottom) = (if ay < by { ay } else { by }, if ay > by { ay } else { by });
                (lines.top[at], lines.bottom[at]) = (top, bottom);
                least = if top < least { top } else { least };
                greatest = if bottom > greatest { bottom } else { greatest };
                count += 1;
            }
        }
        (count, least, greatest)
    }

    /// The lowest eight bits, a byte each, the lowest one first.
    #[inline(always)]
    fn spread(self, bits: u64) -> u64 {
        const ONES: u64 = 0x0101_0101_0101_0101;
        /// Bit k of byte k.
        const DIAGONAL: u64 = 0x8040_2010_0804_0201;
        // A byte each, 0 or a power of two, and then 0 or 1.
        let spread = ((bits & 0xff) * ONES) & DIAGONAL;
        ((spread + 0x7f * ONES) >> 7) & ONES
    }

    /// Lane `lane`, below 8, in the first half of the lanes, and lane 8 + `lane` in the other.
    #[inline(always)]
    fn pair(self, floats: Self::Floats, lane: usize) -> Self::Floats {
        let mut lanes = [0.0; LANES];
        self.store(floats, &mut lanes);
        let [low, high] = [lane, LANES / 2 + lane].map(|lane| lanes[lane % LANES]);
        for (at, place) in lanes.iter_mut().enumerate() {
            *place = if at < LANES / 2 { low } else { high };
        }
        self.load(&lanes)
    }

    /// Where a plane cuts the first eight edges of each mask, all of which it crosses: upwards
    /// and towards the camera, in eight lanes for each mask. What lanes are left are NaN.
    #[inline(always)]
    fn corners(self, solid: Solid<'_>, masks: [u64; 2], plane: f32) -> [Self::Floats; 2] {
        let (mut a, mut b) = ([[0.0; LANES]; 3], [[0.0; LANES]; 3]);
        for (half, mask) in masks.into_iter().enumerate() {
            let mut left = mask;
            for lane in LANES / 2 * half..LANES / 2 * (half + 1) {
                let edge = left.trailing_zeros() as usize;
                let (Some(&from), Some(&to)) = (solid.from.get(edge), solid.to.get(edge)) else {
                    break;
                };
                left &= left - 1;
                for (axis, points) in solid.points.into_iter().enumerate() {
                    a[axis][lane] = points[usize::from(from) % 32];
                    b[axis][lane] = points[usize::from(to) % 32];
                }
            }
        }
        let a = [self.load(&a[0]), self.load(&a[1]), self.load(&a[2])];
        let b = [self.load(&b[0]), self.load(&b[1]), self.load(&b[2])];
        cut(self, a, b, plane)
    }

    /// The least of the first numbers and the greatest of the others.
    #[inline(always)]
    fn bounds(self, low: Self::Floats, high: Self::Floats) -> (f32, f32) {
        let (mut lows, mut highs) = ([0.0; LANES], [0.0; LANES]);
        self.store(low, &mut lows);
        self.store(high, &mut highs);
        let (mut least, mut greatest) = (f32::INFINITY, f32::NEG_INFINITY);
        for (low, high) in lows.into_iter().zip(highs) {
            least = if low < least { low } else { least };
            greatest = if high > greatest { high } else { greatest };
        }
        (least, greatest)
    }

    /// The wrapping sum.
    #[inline(always)]
    fn sum(self, words: Self::Words) -> u32 {
        let mut lanes = [0; LANES];
        self.store_words(words, &mut lanes);
        lanes.into_iter().fold(0, u32::wrapping_add)
    }
}

/// The points of lines from `a` to `b` in a plane to the right: upwards and towards the camera.
#[inline(always)]
fn cut<L: Lanes>(l: L, a: [L::Floats; 3], b: [L::Floats; 3], plane: f32) -> [L::Floats; 2] {
    let share = l.div(l.sub(l.splat(plane), a[0]), l.sub(b[0], a[0]));
    [
        l.add(a[1], l.mul(share, l.sub(b[1], a[1]))),
        l.add(a[2], l.mul(share, l.sub(b[2], a[2]))),
    ]
}
