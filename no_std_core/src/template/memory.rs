//! The memory of a template builder.

use super::{FrameError, TemplateKind};
use crate::silhouette::AnySilhouette;

/// The data that a template builder keeps of the frames.
pub trait Memory {
    fn add(&mut self, frame: &AnySilhouette) -> Result<(), FrameError>;
    fn frames(&self) -> u32;
    fn clear(&mut self);

    /// Writes the template `kind` of a cycle for which so many frames were planned.
    fn write(&mut self, kind: TemplateKind, planned: u32, bytes: &mut [u8]);
}
