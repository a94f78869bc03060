//! Moments of a drawn window, and the image that is cut out of it.

use super::{BitWindow, MAX_SAMPLES, Sampling, WORD};
use crate::budget::MAX_ROWS;
use crate::raster::moments::AreaMoments;
use crate::silhouette::{AnySilhouette, Ninths, Silhouette};
use crate::simd::{LANES, Wide};

/// Computes the moments in whole numbers: a sample counts `n`, so that places in a pixel are whole
/// numbers.
#[inline(always)]
pub fn moments<L: Wide>(l: L, window: &BitWindow) -> AreaMoments {
    let n = window.sampling.places().len();
    // Rows that are filled together with the last one and lie below it do not count.
    let height = window.size.rows();
    let kept = core::array::from_fn(|row| if row < height { u32::MAX } else { 0 });
    let mut moments = AreaMoments::default();
    for (image, words) in window.bits.iter().take(n * n).enumerate() {
        for (word, rows) in words.iter().take(window.words).enumerate() {
            let (area, columns) = word_moments(l, rows, &kept);
            // Three times twice the centre of a pixel's third is 6 columns + 1, 3 or 5.
            let first = (2 * n * WORD * word + 2 * (image / n) + 1) as u64;
            moments.area += n as u64 * u64::from(area);
            moments.doubled += (2 * n) as u64 * u64::from(columns) + first * u64::from(area);
        }
    }
    moments
}

/// Returns the number of `kept` bits of a word that are on, and the sum of their columns.
#[inline(always)]
fn word_moments<L: Wide>(l: L, rows: &[u32], kept: &[u32; MAX_ROWS]) -> (u32, u32) {
    /// Columns whose number has bit 0, 1, 2, 3 or 4.
    const COLUMNS: [u32; 5] = [
        0xaaaa_aaaa,
        0xcccc_cccc,
        0xf0f0_f0f0,
        0xff00_ff00,
        0xffff_0000,
    ];
    let mut area = l.splat_word(0);
    let mut counts = [area; COLUMNS.len()];
    let (rows, _) = rows.as_chunks::<LANES>();
    let (kept, _) = kept.as_chunks::<LANES>();
    for (rows, kept) in rows.iter().zip(kept) {
        let rows = l.and_words(l.load_words(rows), l.load_words(kept));
        area = l.add_words(area, l.count_ones(rows));
        for (count, columns) in counts.iter_mut().zip(COLUMNS) {
            let some = l.and_words(rows, l.splat_word(columns));
            *count = l.add_words(*count, l.count_ones(some));
        }
    }
    let mut columns = 0;
    for (bit, count) in counts.into_iter().enumerate() {
        columns += l.sum(count) << bit;
    }
    (l.sum(area), columns)
}

/// Cuts out the columns from `left` on, without copying unused parts of a frame, and returns their
/// area.
#[inline(always)]
pub fn cut<L: Wide>(_: L, window: &BitWindow, left: isize, frame: &mut AnySilhouette) -> u64 {
    match window.sampling {
        Sampling::Once => {
            if !matches!(frame, AnySilhouette::Binary(_)) {
                *frame = AnySilhouette::Binary(Silhouette::empty(window.size));
            }
            if let AnySilhouette::Binary(silhouette) = frame {
                cut_image(window, 0, left, silhouette);
                return u64::from(silhouette.area());
            }
            0
        }
        Sampling::ThreeByThree => {
            let mut images = [Silhouette::empty(window.size); MAX_SAMPLES];
            cut_images(window, left, &mut images);
            let ninths = Ninths::count(&images);
            *frame = AnySilhouette::Ninths(ninths);
            3 * u64::from(ninths.samples())
        }
    }
}

/// Cuts the columns from `left` on out of the images of nine samples a pixel.
#[inline(always)]
pub fn cut_images(window: &BitWindow, left: isize, images: &mut [Silhouette; MAX_SAMPLES]) {
    for (image, silhouette) in images.iter_mut().enumerate() {
        cut_image(window, image, left, silhouette);
    }
}

/// Cuts the columns from `left` on out of one image.
#[inline(always)]
fn cut_image(window: &BitWindow, image: usize, left: isize, silhouette: &mut Silhouette) {
    *silhouette = Silhouette::empty(window.size);
    if let Some(image) = window.bits.get(image) {
        for (word, bits) in image.iter().take(window.words).enumerate() {
            let first = (WORD * word).cast_signed() - left;
            silhouette.add_columns(bits.iter().copied(), first);
        }
    }
}
