//! The builder of every template.

use super::frame_sums::FrameSums;
use super::frequency::Frequencies;
use super::history::{History, PixelEvent};
use super::memory::Memory;
use super::{FrameError, Gei, TemplateKind};
use crate::raster::Simd;
use crate::silhouette::{AnySilhouette, Size};

/// A builder of a template of any kind, frame by frame. 82 kB, the size of frequencies; other
/// templates touch only 17 kB, and motion templates 9 kB.
///
/// ```
/// use edgegait_core::budget::MAX_TEMPLATE_BYTES;
/// use edgegait_core::silhouette::{AnySilhouette, Silhouette, Size};
/// use edgegait_core::template::{TemplateBuilder, TemplateKind};
///
/// let size = Size::S50x30;
/// let mut bytes = [0; MAX_TEMPLATE_BYTES];
/// for kind in TemplateKind::ALL {
///     let mut builder = TemplateBuilder::for_kind(kind, size, 2);
///     builder.add(&AnySilhouette::Binary(Silhouette::from_rows(size, &[0b01])))?;
///     builder.add(&AnySilhouette::Binary(Silhouette::from_rows(size, &[0b11])))?;
///     let template = &mut bytes[..kind.bytes(size)];
///     builder.finish(template);
///     // The first pixel was always on, the second one in the second frame.
///     println!("{}: {:?}", kind.name(), &template[..2]);
/// }
/// # Ok::<(), edgegait_core::template::FrameError>(())
/// ```
#[derive(Clone, Debug)]
pub struct TemplateBuilder<M = AnyMemory> {
    kind: TemplateKind,
    size: Size,
    frames: u32,
    memory: M,
}

/// A builder of a GEI. 16 kB.
pub type GeiBuilder = TemplateBuilder<FrameSums>;

/// The memory of a builder of any kind.
#[derive(Clone, Debug)]
#[expect(
    clippy::large_enum_variant,
    reason = "82 kB for a cycle; a box would need a heap"
)]
pub enum AnyMemory {
    Sums(FrameSums),
    History(History),
    Frequencies(Frequencies),
}

impl GeiBuilder {
    /// Makes a builder of a [`TemplateKind::Gei`], for at most [`Self::MAX_FRAMES`] frames.
    #[must_use]
    pub fn new(size: Size) -> Self {
        Self::with_simd(size, Simd::widest())
    }

    /// Makes a builder of a [`TemplateKind::Gei`] that uses these registers. GEIs do not depend on
    /// them.
    #[must_use]
    pub const fn with_simd(size: Size, simd: Simd) -> Self {
        Self::keeping(
            TemplateKind::Gei,
            size,
            Self::MAX_FRAMES,
            FrameSums::new(size, simd),
        )
    }

    /// Returns the mean of the frames so far, rounded half up; black without frames. More frames
    /// may be added.
    #[must_use]
    pub fn gei(&mut self) -> Gei {
        Gei::from_means(self.size, self.memory.means())
    }
}

impl TemplateBuilder {
    /// Makes a builder for all `frames` of one cycle, at least 1 and at most [`Self::MAX_FRAMES`].
    /// Motion is remembered over all of them, and a silhouette fades by 1 a frame.
    #[must_use]
    pub fn for_kind(kind: TemplateKind, size: Size, frames: u32) -> Self {
        let (frames, simd) = (frames.clamp(1, Self::MAX_FRAMES), Simd::widest());
        let memory = match kind {
            TemplateKind::Gei | TemplateKind::Geni => AnyMemory::Sums(FrameSums::new(size, simd)),
            TemplateKind::Mei | TemplateKind::Mhi | TemplateKind::Ghi => {
                AnyMemory::History(History::new(PixelEvent::Change, size))
            }
            TemplateKind::Msi => AnyMemory::History(History::new(PixelEvent::End, size)),
            TemplateKind::Frequency => AnyMemory::Frequencies(Frequencies::new(size, simd, frames)),
        };
        Self::keeping(kind, size, frames, memory)
    }
}

impl<M> TemplateBuilder<M> {
    /// The maximum number of frames in one template, as counters hold: four minutes at 30 Hz.
    pub const MAX_FRAMES: u32 = FrameSums::MAX_FRAMES;

    const fn keeping(kind: TemplateKind, size: Size, frames: u32, memory: M) -> Self {
        Self {
            kind,
            size,
            frames,
            memory,
        }
    }

    /// Returns the kind of template that it builds.
    #[must_use]
    pub const fn kind(&self) -> TemplateKind {
        self.kind
    }
}

impl<M: Memory> TemplateBuilder<M> {
    /// Adds a frame. From grey frames, MEI, MHI, MSI and GHI take the pixels that are at least half
    /// covered; GEI, GEnI and frequencies take the coverage. Frames should come from one
    /// rasteriser, because the first one decides the resolution of counts.
    ///
    /// # Errors
    /// If it is of another size, or the builder has all its frames.
    pub fn add(&mut self, frame: &AnySilhouette) -> Result<(), FrameError> {
        FrameError::check([self.size, frame.size()], self.frames(), self.frames)?;
        self.memory.add(frame)
    }

    /// Returns the number of frames added so far.
    #[must_use]
    pub fn frames(&self) -> u32 {
        self.memory.frames()
    }

    /// Writes the template of the frames so far, 0..=255, rounded half up, row by row from the top:
    /// [`TemplateKind::bytes`], or as many as there is room for. Black without frames. More frames
    /// may be added.
    pub fn finish(&mut self, bytes: &mut [u8]) {
        let room = bytes.len().min(self.kind.bytes(self.size));
        let bytes = bytes.get_mut(..room).unwrap_or_default();
        self.memory.write(self.kind, self.frames, bytes);
    }

    /// Forgets all frames, for the next cycle.
    pub fn clear(&mut self) {
        self.memory.clear();
    }
}

/// Evaluates an expression with the memory in use, whichever it is.
macro_rules! each {
    ($self:ident, $memory:ident => $does:expr) => {
        match $self {
            AnyMemory::Sums($memory) => $does,
            AnyMemory::History($memory) => $does,
            AnyMemory::Frequencies($memory) => $does,
        }
    };
}

impl Memory for AnyMemory {
    fn add(&mut self, frame: &AnySilhouette) -> Result<(), FrameError> {
        each!(self, memory => Memory::add(memory, frame))
    }
    fn frames(&self) -> u32 {
        each!(self, memory => Memory::frames(memory))
    }
    fn clear(&mut self) {
        each!(self, memory => Memory::clear(memory));
    }
    fn write(&mut self, kind: TemplateKind, planned: u32, bytes: &mut [u8]) {
        each!(self, memory => Memory::write(memory, kind, planned, bytes));
    }
}

#[cfg(test)]
mod tests;
