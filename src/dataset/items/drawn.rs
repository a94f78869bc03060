//! The arrays of one rendered item.

use crate::draw::sweep::Swept;

/// The arrays of one rendered item.
#[derive(Clone, Debug, Default)]
pub struct DrawnItem {
    /// The bytes of each array, in the order of [`Items::arrays`](super::Items::arrays).
    pub arrays: Vec<Vec<u8>>,
    /// The number of frames of the item.
    pub frames: u32,
}

impl DrawnItem {
    /// Splits the result of a sweep from `views` viewpoints into items.
    pub(super) fn split(swept: Swept, views: usize, with_joints: bool) -> Vec<Self> {
        let Swept {
            templates,
            frames,
            joints,
            keypoints,
            ..
        } = swept;
        let each = templates.len() / views.max(1);
        let mut templates = templates.into_iter();
        let mut keypoints = keypoints.into_iter();
        let one = |_| {
            let mut arrays: Vec<Vec<u8>> = templates.by_ref().take(each).collect();
            let keypoints = keypoints.next().unwrap_or_default();
            if with_joints {
                arrays.extend([joints.clone(), keypoints]);
            }
            Self { arrays, frames }
        };
        (0..views).map(one).collect()
    }
}
