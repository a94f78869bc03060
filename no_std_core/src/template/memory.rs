//! The memory of a template builder.

use super::{FrameError, TemplateKind};
use crate::silhouette::AnySilhouette;

/// The data that a template builder keeps of the frames.
pub trait Memory {
    fn add(&mut self, frame: &AnySilhouette) -> Result<(), FrameError>;
    fn frames(&self) -> u32;
    fn clear(&mut self);

    /// Writes the template `kind` with this tau and decrement.
    fn write(&mut self, kind: TemplateKind, tau: u32, decrement: u8, bytes: &mut [u8]);
}
