//! Sixteen numbers in four registers of NEON, which every 64-bit ARM processor has.
#![expect(
    unsafe_code,
    reason = "intrinsics; every processor of the target has the instructions"
)]

use super::{LANES, Lanes};
use core::arch::aarch64::*;

/// A 64-bit ARM processor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Neon;

macro_rules! with {
    ($($call:tt)*) => {
        // SAFETY: NEON is a part of the target; addresses are those of arrays of the length
        // that is read or written.
        unsafe { $($call)* }
    };
}

/// An expression for each of the four registers.
macro_rules! four {
    ($k:ident => $value:expr) => {
        [
            with!({
                let $k = 0;
                $value
            }),
            with!({
                let $k = 1;
                $value
            }),
            with!({
                let $k = 2;
                $value
            }),
            with!({
                let $k = 3;
                $value
            }),
        ]
    };
}

/// Those numbers that the mask names, and zeros.
#[inline(always)]
fn named(mask: [uint32x4_t; 4], numbers: &[u64; LANES]) -> [[uint64x2_t; 2]; 4] {
    four!(k => {
        let numbers = numbers.as_ptr().add(4 * k);
        let mask = vreinterpretq_s32_u32(mask[k]);
        let low = vreinterpretq_u64_s64(vmovl_s32(vget_low_s32(mask)));
        let high = vreinterpretq_u64_s64(vmovl_high_s32(mask));
        [vandq_u64(low, vld1q_u64(numbers)), vandq_u64(high, vld1q_u64(numbers.add(2)))]
    })
}

impl Lanes for Neon {
    type Floats = [float32x4_t; 4];
    type Words = [uint32x4_t; 4];
    type Mask = [uint32x4_t; 4];
    type Parity = uint64x2_t;

    #[inline(always)]
    fn splat(self, value: f32) -> Self::Floats {
        [with!(vdupq_n_f32(value)); 4]
    }
    #[inline(always)]
    fn load(self, from: &[f32; LANES]) -> Self::Floats {
        four!(k => vld1q_f32(from.as_ptr().add(4 * k)))
    }
    #[inline(always)]
    fn store(self, floats: Self::Floats, to: &mut [f32; LANES]) {
        for (quarter, floats) in floats.into_iter().enumerate() {
            with!(vst1q_f32(to.as_mut_ptr().add(4 * quarter), floats));
        }
    }
    #[inline(always)]
    fn add(self, a: Self::Floats, b: Self::Floats) -> Self::Floats {
        four!(k => vaddq_f32(a[k], b[k]))
    }
    #[inline(always)]
    fn sub(self, a: Self::Floats, b: Self::Floats) -> Self::Floats {
        four!(k => vsubq_f32(a[k], b[k]))
    }
    #[inline(always)]
    fn mul(self, a: Self::Floats, b: Self::Floats) -> Self::Floats {
        four!(k => vmulq_f32(a[k], b[k]))
    }
    #[inline(always)]
    fn div(self, a: Self::Floats, b: Self::Floats) -> Self::Floats {
        four!(k => vdivq_f32(a[k], b[k]))
    }
    // Not vminq and vmaxq: of a NaN these make a NaN.
    #[inline(always)]
    fn min(self, a: Self::Floats, b: Self::Floats) -> Self::Floats {
        four!(k => vbslq_f32(vcltq_f32(a[k], b[k]), a[k], b[k]))
    }
    #[inline(always)]
    fn max(self, a: Self::Floats, b: Self::Floats) -> Self::Floats {
        four!(k => vbslq_f32(vcgtq_f32(a[k], b[k]), a[k], b[k]))
    }
    #[inline(always)]
    fn less(self, a: Self::Floats, b: Self::Floats) -> Self::Mask {
        four!(k => vcltq_f32(a[k], b[k]))
    }
    #[inline(always)]
    fn not_less(self, a: Self::Floats, b: Self::Floats) -> Self::Mask {
        four!(k => vcgeq_f32(a[k], b[k]))
    }
    #[inline(always)]
    fn and(self, a: Self::Mask, b: Self::Mask) -> Self::Mask {
        four!(k => vandq_u32(a[k], b[k]))
    }
    #[inline(always)]
    fn all(self, mask: Self::Mask) -> bool {
        with!(vminvq_u32(vandq_u32(
            vandq_u32(mask[0], mask[1]),
            vandq_u32(mask[2], mask[3])
        ))) != 0
    }
    #[inline(always)]
    fn within(self, top: Self::Floats, row: Self::Floats, bottom: Self::Floats) -> Self::Mask {
        four!(k => vandq_u32(vcltq_f32(top[k], row[k]), vcleq_f32(row[k], bottom[k])))
    }
    #[inline(always)]
    fn widen(
        self,
        (left, right): (Self::Floats, Self::Floats),
        x: Self::Floats,
        mask: Self::Mask,
    ) -> (Self::Floats, Self::Floats) {
        (
            four!(k => vbslq_f32(vandq_u32(mask[k], vcltq_f32(x[k], left[k])), x[k], left[k])),
            four!(k => vbslq_f32(vandq_u32(mask[k], vcgtq_f32(x[k], right[k])), x[k], right[k])),
        )
    }
    #[inline(always)]
    fn truncate(self, floats: Self::Floats) -> Self::Words {
        four!(k => vcvtq_u32_f32(floats[k]))
    }

    #[inline(always)]
    fn splat_word(self, value: u32) -> Self::Words {
        [with!(vdupq_n_u32(value)); 4]
    }
    #[inline(always)]
    fn load_words(self, from: &[u32; LANES]) -> Self::Words {
        four!(k => vld1q_u32(from.as_ptr().add(4 * k)))
    }
    #[inline(always)]
    fn store_words(self, words: Self::Words, to: &mut [u32; LANES]) {
        for (quarter, words) in words.into_iter().enumerate() {
            with!(vst1q_u32(to.as_mut_ptr().add(4 * quarter), words));
        }
    }
    #[inline(always)]
    fn merge(self, words: Self::Words, to: &mut [u32; LANES]) {
        let before = self.load_words(to);
        self.store_words(four!(k => vorrq_u32(before[k], words[k])), to);
    }
    #[inline(always)]
    fn add_words(self, a: Self::Words, b: Self::Words) -> Self::Words {
        four!(k => vaddq_u32(a[k], b[k]))
    }
    #[inline(always)]
    fn sub_words(self, a: Self::Words, b: Self::Words) -> Self::Words {
        four!(k => vsubq_u32(a[k], b[k]))
    }
    #[inline(always)]
    fn and_words(self, a: Self::Words, b: Self::Words) -> Self::Words {
        four!(k => vandq_u32(a[k], b[k]))
    }
    #[inline(always)]
    fn max_words(self, a: Self::Words, b: Self::Words) -> Self::Words {
        four!(k => vreinterpretq_u32_s32(vmaxq_s32(
            vreinterpretq_s32_u32(a[k]),
            vreinterpretq_s32_u32(b[k]),
        )))
    }
    #[inline(always)]
    fn power_of_two(self, exponents: Self::Words) -> Self::Words {
        // Shifts by 32 to 127 leave nothing; windows have 128 columns at most.
        four!(k => vshlq_u32(vdupq_n_u32(1), vreinterpretq_s32_u32(vminq_u32(exponents[k], vdupq_n_u32(32)))))
    }
    #[inline(always)]
    fn count_ones(self, words: Self::Words) -> Self::Words {
        four!(k => vpaddlq_u16(vpaddlq_u8(vcntq_u8(vreinterpretq_u8_u32(words[k])))))
    }
    #[inline(always)]
    fn bits_from(self, first: Self::Words) -> Self::Words {
        four!(k => vshlq_u32(
            vdupq_n_u32(u32::MAX),
            vreinterpretq_s32_u32(vminq_u32(first[k], vdupq_n_u32(32))),
        ))
    }
    #[inline(always)]
    fn bits_but(self, highest: Self::Words) -> Self::Words {
        // A shift to the left by less than nothing.
        four!(k => vshlq_u32(
            vdupq_n_u32(u32::MAX),
            vnegq_s32(vreinterpretq_s32_u32(vminq_u32(highest[k], vdupq_n_u32(32)))),
        ))
    }
    #[inline(always)]
    fn without(self, a: Self::Words, b: Self::Words) -> Self::Words {
        four!(k => vbicq_u32(a[k], b[k]))
    }

    #[inline(always)]
    fn no_parity(self) -> uint64x2_t {
        with!(vdupq_n_u64(0))
    }
    #[inline(always)]
    fn toggle(self, parity: uint64x2_t, mask: Self::Mask, numbers: &[u64; LANES]) -> uint64x2_t {
        let mut parity = parity;
        for [low, high] in named(mask, numbers) {
            parity = with!(veorq_u64(parity, veorq_u64(low, high)));
        }
        parity
    }
    #[inline(always)]
    fn parity(self, parity: uint64x2_t) -> u64 {
        with!(vgetq_lane_u64::<0>(parity) ^ vgetq_lane_u64::<1>(parity))
    }
    #[inline(always)]
    fn unite(self, union: uint64x2_t, mask: Self::Mask, numbers: &[u64; LANES]) -> uint64x2_t {
        let mut union = union;
        for [low, high] in named(mask, numbers) {
            union = with!(vorrq_u64(union, vorrq_u64(low, high)));
        }
        union
    }
    #[inline(always)]
    fn union(self, union: uint64x2_t) -> u64 {
        with!(vgetq_lane_u64::<0>(union) | vgetq_lane_u64::<1>(union))
    }
}
