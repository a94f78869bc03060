//! The arrays of drawn items.

use crate::dataset::contents::Array;
use crate::draw::sweep::Swept;
use crate::error::{Error, Result};

/// The arrays of drawn items.
#[derive(Clone, Debug, Default)]
pub struct DrawnItems {
    /// The bytes of each array, in the order of [`Items::arrays`](super::Items::arrays): those of
    /// all items, one after another.
    pub arrays: Vec<Vec<u8>>,
    /// The number of frames of each item.
    pub frames: Vec<u32>,
}

impl DrawnItems {
    /// Makes room for items with these numbers of frames.
    pub(super) fn new(arrays: &[Array], frames: Vec<u32>) -> Self {
        let bytes = |array: &Array| frames.iter().map(|&frames| array.bytes_of(frames)).sum();
        let arrays = arrays.iter().map(|array| vec![0; bytes(array)]).collect();
        Self { arrays, frames }
    }

    /// Returns the place of each item in each array.
    pub(super) fn places(&mut self, arrays: &[Array]) -> Vec<ItemBytes<'_>> {
        let none = |_| ItemBytes(Vec::with_capacity(arrays.len()));
        let mut places: Vec<ItemBytes<'_>> = self.frames.iter().map(none).collect();
        for (all, array) in self.arrays.iter_mut().zip(arrays) {
            let mut left = all.as_mut_slice();
            for (place, &frames) in places.iter_mut().zip(&self.frames) {
                let (own, others) = left.split_at_mut(array.bytes_of(frames));
                place.0.push(own);
                left = others;
            }
        }
        places
    }
}

/// The bytes of one item in each array.
#[derive(Default)]
pub(super) struct ItemBytes<'a>(pub(super) Vec<&'a mut [u8]>);

impl ItemBytes<'_> {
    /// Copies the result of a sweep into the places of its views.
    pub(super) fn fill(places: &mut [ItemBytes<'_>], swept: &Swept) -> Result<()> {
        let each = swept.templates.len() / places.len().max(1);
        for (at, place) in places.iter_mut().enumerate() {
            let templates = swept.templates.iter().skip(at * each).take(each);
            let joints = swept
                .keypoints
                .get(at)
                .map(|points| [&swept.joints, points]);
            let parts = templates.chain(joints.into_iter().flatten());
            for (own, part) in place.0.iter_mut().zip(parts) {
                if own.len() != part.len() {
                    return Err(Error::Missing("as many frames of an item as it states"));
                }
                own.copy_from_slice(part);
            }
        }
        Ok(())
    }
}
