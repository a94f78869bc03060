//! The outputs of one viewpoint.

/// The outputs that were made from one view.
#[derive(Clone, Debug, Default)]
pub(super) struct PaintedView {
    /// The templates in the order of the request.
    pub(super) templates: Vec<Vec<u8>>,
    /// The sum over frames of the share of the figure outside of the image.
    pub(super) clipped: f64,
    /// The number of frames in which nothing was left of the figure.
    pub(super) empty: u64,
    /// The keypoints, in the format of [`Swept::keypoints`](super::Swept::keypoints).
    pub(super) keypoints: Vec<u8>,
}
