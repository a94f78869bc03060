//! Limits for reading pictures, which may be made to take much memory.

use image::Limits;

/// The maximum number of bytes for what a picture has beside its pixels, such as a colour profile,
/// which is compressed. Our choice: profiles have up to 3 MB.
const BESIDE_BYTES: u64 = 8 << 20;

/// Returns the limits for decoding a picture of this many columns and rows, or for reading its
/// header (0 and 0), if a side may have at most `most_side` pixels.
pub(crate) fn picture_limits(most_side: u32, (columns, rows): (u32, u32)) -> Limits {
    let mut limits = Limits::default();
    (limits.max_image_width, limits.max_image_height) = (Some(most_side), Some(most_side));
    // Four channels of 16 bits.
    limits.max_alloc = Some(BESIDE_BYTES + 8 * u64::from(columns) * u64::from(rows));
    limits
}
