//! One builder for every template.

use super::FrameError;
use super::Kind;
use super::entropy::entropies;
use super::frequency::Frequencies;
use super::history::{Event, History};
use super::sums::Sums;
use crate::raster::Simd;
use crate::silhouette::{Frame, Size};

/// Builds a template of any kind, frame by frame. 82 kB, as the frequencies take; of the others
/// 17 kB are touched, and 9 kB by those of motion.
///
/// ```
/// use edgegait_core::budget::MAX_TEMPLATE_BYTES;
/// use edgegait_core::silhouette::{Frame, Silhouette, Size};
/// use edgegait_core::template::{Kind, TemplateBuilder};
///
/// let size = Size::S50x30;
/// let mut bytes = [0; MAX_TEMPLATE_BYTES];
/// for kind in Kind::ALL {
///     let mut builder = TemplateBuilder::new(kind, size, 2);
///     builder.add(&Frame::Binary(Silhouette::from_rows(size, &[0b01])))?;
///     builder.add(&Frame::Binary(Silhouette::from_rows(size, &[0b11])))?;
///     let template = &mut bytes[..kind.bytes(size)];
///     builder.finish(template);
///     // The first pixel was always on, the second one in the second frame.
///     println!("{}: {:?}", kind.name(), &template[..2]);
/// }
/// # Ok::<(), edgegait_core::template::FrameError>(())
/// ```
#[derive(Clone, Debug)]
pub struct TemplateBuilder {
    kind: Kind,
    size: Size,
    frames: u32,
    tau: u32,
    decrement: u8,
    made_from: Source,
}

#[derive(Clone, Debug)]
#[expect(
    clippy::large_enum_variant,
    reason = "82 kB for a cycle; a box would need a heap"
)]
enum Source {
    Sums(Sums),
    History(History),
    Frequencies(Frequencies),
}

impl TemplateBuilder {
    /// Most frames of one template.
    pub const MAX_FRAMES: u32 = Sums::MAX_FRAMES;

    /// No frame yet; `frames` are to come, at least 1 and at most [`Self::MAX_FRAMES`]: all of
    /// one cycle. Motion is remembered over all of them, and a silhouette fades by 1 a frame.
    #[must_use]
    pub fn new(kind: Kind, size: Size, frames: u32) -> Self {
        Self::with_simd(kind, size, frames, Simd::widest())
    }

    /// The same, with these registers. Templates do not depend on it.
    #[must_use]
    pub fn with_simd(kind: Kind, size: Size, frames: u32, simd: Simd) -> Self {
        let frames = frames.clamp(1, Self::MAX_FRAMES);
        Self {
            kind,
            size,
            frames,
            tau: frames - 1,
            decrement: 1,
            made_from: match kind {
                Kind::Gei | Kind::Geni => Source::Sums(Sums::new(size, simd)),
                Kind::Mei | Kind::Mhi | Kind::Ghi => {
                    Source::History(History::new(Event::Change, size))
                }
                Kind::Msi => Source::History(History::new(Event::End, size)),
                Kind::Frequency => Source::Frequencies(Frequencies::new(size, simd, frames)),
            },
        }
    }

    /// The same, with motion remembered over `tau` steps from one frame to the next: tau of
    /// [`Kind::Mei`] and [`Kind::Mhi`], at least 1.
    #[must_use]
    pub const fn with_tau(mut self, tau: u32) -> Self {
        self.tau = tau;
        self
    }

    /// The same, with silhouettes that fade by so much of 255 a frame: of [`Kind::Msi`].
    #[must_use]
    pub const fn with_decrement(mut self, decrement: u8) -> Self {
        self.decrement = decrement;
        self
    }

    /// Which template it builds.
    #[must_use]
    pub const fn kind(&self) -> Kind {
        self.kind
    }

    /// Adds a frame. Of grey frames motion, silhouettes and history take the pixels that are at
    /// least half covered, energy, entropy and frequencies the coverage.
    ///
    /// # Errors
    /// If it is of another size, or one more than were to come.
    pub fn add(&mut self, frame: &Frame) -> Result<(), FrameError> {
        FrameError::check([self.size, frame.size()], self.frames(), self.frames)?;
        match &mut self.made_from {
            Source::Sums(sums) => sums.add(frame),
            Source::History(history) => history.add(&frame.silhouette()),
            Source::Frequencies(frequencies) => frequencies.add(frame),
        }
    }

    /// How many frames were added.
    #[must_use]
    pub fn frames(&self) -> u32 {
        match &self.made_from {
            Source::Sums(sums) => sums.frames(),
            Source::History(history) => u32::from(history.frames()),
            Source::Frequencies(frequencies) => frequencies.frames(),
        }
    }

    /// Writes the template of the frames so far, 0..=255, rounded half up, row by row from the
    /// top: [`Kind::bytes`], or as many as there is room for. Black without any frame. More may
    /// be added.
    pub fn finish(&mut self, bytes: &mut [u8]) {
        let room = bytes.len().min(self.kind.bytes(self.size));
        let bytes = bytes.get_mut(..room).unwrap_or_default();
        match (self.kind, &mut self.made_from) {
            (Kind::Geni, Source::Sums(sums)) => copy(&entropies(sums), bytes),
            (_, Source::Sums(sums)) => copy(&sums.means(), bytes),
            (Kind::Mei, Source::History(history)) => history.moved(self.tau, bytes),
            (Kind::Msi, Source::History(history)) => history.presence(self.decrement, bytes),
            (Kind::Ghi, Source::History(history)) => history.lasting(bytes),
            (_, Source::History(history)) => history.motion(self.tau, bytes),
            (_, Source::Frequencies(frequencies)) => frequencies.write(bytes),
        }
    }

    /// Forgets all frames, for the next cycle.
    pub fn clear(&mut self) {
        match &mut self.made_from {
            Source::Sums(sums) => sums.clear(),
            Source::History(history) => history.clear(),
            Source::Frequencies(frequencies) => frequencies.clear(),
        }
    }
}

fn copy(from: &[u8], into: &mut [u8]) {
    for (into, from) in into.iter_mut().zip(from) {
        *into = *from;
    }
}

#[cfg(test)]
mod tests;
