//! Eight numbers in two registers of NEON, which every 64-bit ARM processor has.
#![expect(
    unsafe_code,
    reason = "intrinsics; every processor of the target has the instructions"
)]

use super::{Lanes, TwoHalves, Wide};
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

/// Evaluates an expression for both registers.
macro_rules! both {
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
        ]
    };
}

impl Lanes<8> for Neon {
    type Floats = [float32x4_t; 2];
    type Words = [uint32x4_t; 2];
    type Mask = [uint32x4_t; 2];

    #[inline(always)]
    fn splat(self, value: f32) -> Self::Floats {
        [with!(vdupq_n_f32(value)); 2]
    }
    #[inline(always)]
    fn load(self, from: &[f32; 8]) -> Self::Floats {
        both!(k => vld1q_f32(from.as_ptr().add(4 * k)))
    }
    #[inline(always)]
    fn store(self, floats: Self::Floats, to: &mut [f32; 8]) {
        for (half, floats) in floats.into_iter().enumerate() {
            with!(vst1q_f32(to.as_mut_ptr().add(4 * half), floats));
        }
    }
    #[inline(always)]
    fn add(self, a: Self::Floats, b: Self::Floats) -> Self::Floats {
        both!(k => vaddq_f32(a[k], b[k]))
    }
    #[inline(always)]
    fn sub(self, a: Self::Floats, b: Self::Floats) -> Self::Floats {
        both!(k => vsubq_f32(a[k], b[k]))
    }
    #[inline(always)]
    fn mul(self, a: Self::Floats, b: Self::Floats) -> Self::Floats {
        both!(k => vmulq_f32(a[k], b[k]))
    }
    #[inline(always)]
    fn div(self, a: Self::Floats, b: Self::Floats) -> Self::Floats {
        both!(k => vdivq_f32(a[k], b[k]))
    }
    // Not vminq and vmaxq: these propagate NaN.
    #[inline(always)]
    fn min(self, a: Self::Floats, b: Self::Floats) -> Self::Floats {
        both!(k => vbslq_f32(vcltq_f32(a[k], b[k]), a[k], b[k]))
    }
    #[inline(always)]
    fn max(self, a: Self::Floats, b: Self::Floats) -> Self::Floats {
        both!(k => vbslq_f32(vcgtq_f32(a[k], b[k]), a[k], b[k]))
    }
    #[inline(always)]
    fn less(self, a: Self::Floats, b: Self::Floats) -> Self::Mask {
        both!(k => vcltq_f32(a[k], b[k]))
    }
    #[inline(always)]
    fn not_less(self, a: Self::Floats, b: Self::Floats) -> Self::Mask {
        both!(k => vcgeq_f32(a[k], b[k]))
    }
    #[inline(always)]
    fn and(self, a: Self::Mask, b: Self::Mask) -> Self::Mask {
        both!(k => vandq_u32(a[k], b[k]))
    }
    #[inline(always)]
    fn reach(
        self,
        (left, right): (Self::Floats, Self::Floats),
        x: Self::Floats,
        [top, row, bottom]: [Self::Floats; 3],
    ) -> (Self::Floats, Self::Floats) {
        // With all bits set, x is a NaN, which has no effect.
        let x = both!(k => {
            let is_inside = vandq_u32(vcltq_f32(top[k], row[k]), vcleq_f32(row[k], bottom[k]));
            vreinterpretq_f32_u32(vornq_u32(vreinterpretq_u32_f32(x[k]), is_inside))
        });
        (self.min(x, left), self.max(x, right))
    }
    #[inline(always)]
    fn truncate(self, floats: Self::Floats) -> Self::Words {
        both!(k => vcvtq_u32_f32(floats[k]))
    }

    #[inline(always)]
    fn round(self, floats: Self::Floats) -> Self::Words {
        both!(k => vcvtnq_u32_f32(floats[k]))
    }

    #[inline(always)]
    fn splat_word(self, value: u32) -> Self::Words {
        [with!(vdupq_n_u32(value)); 2]
    }
    #[inline(always)]
    fn load_words(self, from: &[u32; 8]) -> Self::Words {
        both!(k => vld1q_u32(from.as_ptr().add(4 * k)))
    }
    #[inline(always)]
    fn store_words(self, words: Self::Words, to: &mut [u32; 8]) {
        for (half, words) in words.into_iter().enumerate() {
            with!(vst1q_u32(to.as_mut_ptr().add(4 * half), words));
        }
    }
    #[inline(always)]
    fn add_words(self, a: Self::Words, b: Self::Words) -> Self::Words {
        both!(k => vaddq_u32(a[k], b[k]))
    }
    #[inline(always)]
    fn sub_words(self, a: Self::Words, b: Self::Words) -> Self::Words {
        both!(k => vsubq_u32(a[k], b[k]))
    }
    #[inline(always)]
    fn and_words(self, a: Self::Words, b: Self::Words) -> Self::Words {
        both!(k => vandq_u32(a[k], b[k]))
    }
    #[inline(always)]
    fn less_words(self, a: Self::Words, b: Self::Words) -> Self::Mask {
        both!(k => vcltq_s32(vreinterpretq_s32_u32(a[k]), vreinterpretq_s32_u32(b[k])))
    }
    #[inline(always)]
    fn max_words(self, a: Self::Words, b: Self::Words) -> Self::Words {
        both!(k => vreinterpretq_u32_s32(vmaxq_s32(
            vreinterpretq_s32_u32(a[k]),
            vreinterpretq_s32_u32(b[k]),
        )))
    }
    #[inline(always)]
    fn count_ones(self, words: Self::Words) -> Self::Words {
        both!(k => vpaddlq_u16(vpaddlq_u8(vcntq_u8(vreinterpretq_u8_u32(words[k])))))
    }
    #[inline(always)]
    fn choose(self, mask: Self::Mask, a: Self::Words, b: Self::Words) -> Self::Words {
        both!(k => vbslq_u32(mask[k], a[k], b[k]))
    }
    #[inline(always)]
    fn mul_words(self, a: Self::Words, b: Self::Words) -> Self::Words {
        both!(k => vmulq_u32(a[k], b[k]))
    }
    #[inline(always)]
    fn up<const BY: u32>(self, words: Self::Words) -> Self::Words {
        both!(k => vshlq_u32(words[k], vdupq_n_s32(BY.cast_signed())))
    }
    #[inline(always)]
    fn down<const BY: u32>(self, words: Self::Words) -> Self::Words {
        both!(k => {
            let signed = vreinterpretq_s32_u32(words[k]);
            vreinterpretq_u32_s32(vshlq_s32(signed, vdupq_n_s32(-BY.cast_signed())))
        })
    }
    #[inline(always)]
    fn whole(self, floats: Self::Floats) -> Self::Floats {
        both!(k => vrndq_f32(floats[k]))
    }
    #[inline(always)]
    fn cut_off(self, floats: Self::Floats) -> Self::Words {
        both!(k => vreinterpretq_u32_s32(vcvtq_s32_f32(floats[k])))
    }
    #[inline(always)]
    fn slopes(self, across: Self::Words, down: Self::Words) -> Self::Words {
        // A quotient that is not whole is 2^-14 or more from a whole number.
        both!(k => {
            let across = vreinterpretq_s32_u32(vshlq_n_u32::<16>(across[k]));
            let down = vreinterpretq_s32_u32(down[k]);
            let slopes = |across, down| {
                let [across, down] = [across, down].map(|half| vcvtq_f64_s64(vmovl_s32(half)));
                vmovn_s64(vcvtq_s64_f64(vdivq_f64(across, down)))
            };
            let low = slopes(vget_low_s32(across), vget_low_s32(down));
            let high = slopes(vget_high_s32(across), vget_high_s32(down));
            vreinterpretq_u32_s32(vcombine_s32(low, high))
        })
    }
    #[inline(always)]
    fn min_words(self, a: Self::Words, b: Self::Words) -> Self::Words {
        both!(k => vreinterpretq_u32_s32(vminq_s32(
            vreinterpretq_s32_u32(a[k]),
            vreinterpretq_s32_u32(b[k]),
        )))
    }
    #[inline(always)]
    fn widen(
        self,
        (left, right): (Self::Words, Self::Words),
        at: Self::Words,
        row: Self::Words,
        [first, last]: [Self::Words; 2],
    ) -> (Self::Words, Self::Words) {
        let is_inside = both!(k => {
            let [first, row, last] = [first[k], row[k], last[k]].map(|of| vreinterpretq_s32_u32(of));
            vandq_u32(vcleq_s32(first, row), vcleq_s32(row, last))
        });
        (
            both!(k => vminq_u32(left[k], vornq_u32(at[k], is_inside[k]))),
            both!(k => vmaxq_u32(right[k], vandq_u32(at[k], is_inside[k]))),
        )
    }
    #[inline(always)]
    fn bits_from(self, first: Self::Words) -> Self::Words {
        both!(k => vshlq_u32(
            vdupq_n_u32(u32::MAX),
            vreinterpretq_s32_u32(vminq_u32(first[k], vdupq_n_u32(32))),
        ))
    }
    #[inline(always)]
    fn bits_but(self, highest: Self::Words) -> Self::Words {
        // A shift to the left by a negative number.
        both!(k => vshlq_u32(
            vdupq_n_u32(u32::MAX),
            vnegq_s32(vreinterpretq_s32_u32(vminq_u32(highest[k], vdupq_n_u32(32)))),
        ))
    }
    #[inline(always)]
    fn without(self, a: Self::Words, b: Self::Words) -> Self::Words {
        both!(k => vbicq_u32(a[k], b[k]))
    }
    #[inline(always)]
    fn or_words(self, a: Self::Words, b: Self::Words) -> Self::Words {
        both!(k => vorrq_u32(a[k], b[k]))
    }
    #[inline(always)]
    fn bits(self, mask: Self::Mask) -> u32 {
        const WORTH: [[u32; 4]; 2] = [[1, 2, 4, 8], [16, 32, 64, 128]];
        let bits = both!(k => vandq_u32(mask[k], vld1q_u32(WORTH[k].as_ptr())));
        with!(vaddvq_u32(vorrq_u32(bits[0], bits[1])))
    }
}

impl Wide for TwoHalves<Neon> {
    type Half = Neon;

    super::cuts::edge_by_edge!();

    #[inline(always)]
    fn half(self) -> Neon {
        self.0
    }
}
