//! Motion blur: several moments in one picture.

use super::picture::BitPicture;

/// Returns the samples that are on for at least half of an exposure, from pictures at evenly
/// spaced moments: segmentation finds a blurred border where its contrast is half. Returns `None`
/// without pictures.
///
/// # Panics
/// If the pictures differ in size.
#[must_use]
pub(crate) fn exposed(moments: &[BitPicture]) -> Option<BitPicture> {
    let (first, others) = moments.split_first()?;
    let mut exposed = first.clone();
    if others.is_empty() {
        return Some(exposed);
    }
    for other in others {
        // Panics if the sizes differ.
        exposed.join(other);
    }
    // Counts 64 samples at a time, with one binary digit in each word. The counts start such that
    // half of the moments carry into the digit after the last one.
    let digits = moments.len().next_power_of_two().trailing_zeros();
    let start = (1 << digits) - moments.len().div_ceil(2);
    for row in 0..exposed.rows() {
        for word in 0..exposed.row(row).len() {
            if exposed.row(row)[word] == 0 {
                continue;
            }
            let mut counts = [0_u64; usize::BITS as usize];
            for (digit, count) in counts.iter_mut().enumerate() {
                *count = if start >> digit & 1 == 1 { u64::MAX } else { 0 };
            }
            for moment in moments {
                let mut carry = moment.row(row)[word];
                for count in &mut counts[..=digits as usize] {
                    (*count, carry) = (*count ^ carry, *count & carry);
                }
            }
            exposed.row_mut(row)[word] = counts[digits as usize];
        }
    }
    Some(exposed)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sample_is_on_if_it_is_on_in_at_least_half_of_the_moments() {
        for count in 1..=17 {
            // Column c is on in c of the moments.
            let moments: Vec<BitPicture> = (0..count)
                .map(|moment| {
                    let mut picture = BitPicture::empty(2, 1);
                    picture.fill(1, moment + 1, count + 1, true);
                    picture
                })
                .collect();
            let exposed = exposed(&moments).expect("moments");
            for column in 0..64 {
                let on = if column > count { 0 } else { column };
                let expected = on > 0 && 2 * on >= count;
                assert_eq!(
                    exposed.is_on(1, column.cast_unsigned()),
                    expected,
                    "{count} {column}"
                );
            }
            assert!((0..64).all(|column| !exposed.is_on(0, column)));
        }
        assert_eq!(exposed(&[]), None);
    }
}
