//! Counts whose binary digits are planes of bits.

use super::Avx512;
use core::arch::x86_64::*;

/// Indices of the bytes of eight words each, the last word first, as squares of bits: the words'
/// first and second bytes, and the others.
const SQUARES: [[u8; 64]; 2] = {
    let mut squares = [[0; 64]; 2];
    let mut at = 0;
    while at < 64 {
        let (square, byte) = (at / 8, at % 8);
        let (from, words) = (square / 4, square % 4);
        let first = 4 * (8 * words + 7 - byte) + from;
        squares[0][at as usize] = first;
        squares[1][at as usize] = first + 2;
        at += 1;
    }
    squares
};

/// Indices of the bytes of each row in two times four squares.
const ROWS: [u8; 64] = {
    let mut rows = [0; 64];
    let mut at = 0;
    while at < 64 {
        let (row, square) = (at / 4, at % 4);
        rows[at as usize] = 8 * (4 * (row / 8) + square) + row % 8;
        at += 1;
    }
    rows
};

/// Transposes squares of bits by multiplying the one with ones in its diagonal by them.
#[inline(always)]
pub fn turn(_: Avx512<true>, columns: &[u32; 32]) -> [u32; 32] {
    let mut rows = [0; 32];
    with! {
        let diagonal = _mm512_set1_epi64(0x8040_2010_0804_0201u64.cast_signed());
        let order = _mm512_loadu_si512(ROWS.as_ptr().cast());
        let low = _mm512_loadu_si512(columns.as_ptr().cast());
        let high = _mm512_loadu_si512(columns.as_ptr().add(16).cast());
        let first = _mm512_loadu_si512(SQUARES[0].as_ptr().cast());
        let first = _mm512_permutex2var_epi8(low, first, high);
        let first = _mm512_gf2p8affine_epi64_epi8::<0>(diagonal, first);
        let rest = _mm512_loadu_si512(SQUARES[1].as_ptr().cast());
        let rest = _mm512_permutex2var_epi8(low, rest, high);
        let rest = _mm512_gf2p8affine_epi64_epi8::<0>(diagonal, rest);
        let first = _mm512_permutexvar_epi8(order, first);
        let rest = _mm512_permutexvar_epi8(order, rest);
        _mm512_storeu_si512(rows.as_mut_ptr().cast(), first);
        _mm512_storeu_si512(rows.as_mut_ptr().add(16).cast(), rest);
    }
    rows
}

#[inline(always)]
pub fn numbers<const BYTES: bool>(_: Avx512<BYTES>, digits: &[u64]) -> [u8; 64] {
    let mut numbers = [0; 64];
    with! {
        let (mut sum, mut worth) = (_mm512_setzero_si512(), _mm512_set1_epi8(1));
        for &digit in digits {
            sum = _mm512_mask_add_epi8(sum, digit, sum, worth);
            worth = _mm512_add_epi8(worth, worth);
        }
        _mm512_storeu_si512(numbers.as_mut_ptr().cast(), sum);
    }
    numbers
}

#[inline(always)]
pub fn find(_: Avx512<true>, table: &[u8; 128], numbers: &mut [u8; 64]) {
    with! {
        let low = _mm512_loadu_si512(table.as_ptr().cast());
        let high = _mm512_loadu_si512(table.as_ptr().add(64).cast());
        let found = _mm512_loadu_si512(numbers.as_ptr().cast());
        let found = _mm512_permutex2var_epi8(low, found, high);
        _mm512_storeu_si512(numbers.as_mut_ptr().cast(), found);
    }
}
