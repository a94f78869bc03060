//! The images of one viewpoint.

/// What was made of a view.
#[derive(Clone, Debug, Default)]
pub(super) struct PaintedView {
    /// In the order in which they are wanted.
    pub(super) templates: Vec<Vec<u8>>,
    /// Sum over the frames of the share that lay outside of the image.
    pub(super) clipped: f64,
    /// Frames in which nothing was left of the figure.
    pub(super) empty: u64,
    /// As [`Swept::keypoints`] has them.
    pub(super) keypoints: Vec<u8>,
}
