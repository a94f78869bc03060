//! Builders that make templates from single frames.

use super::{Template, kfd, row_width};
use crate::error::Result;
use edgegait_core::silhouette::{AnySilhouette, Size};
use edgegait_core::template::{FrameError, TemplateBuilder, TemplateKind};
use glam::DVec2;

/// A builder that makes one template after another.
pub struct Builder {
    template: Template,
    size: Size,
    /// The number of expected frames, and of added frames.
    frames: u32,
    added: u32,
    made_from: MadeFrom,
}

enum MadeFrom {
    /// A template of the core.
    Images(Box<TemplateBuilder>),
    /// The outlines of all frames with a figure.
    Outlines(Vec<Vec<DVec2>>),
    /// The bytes of all frames.
    Frames(Vec<u8>),
}

impl Builder {
    /// The maximum number of frames in one template.
    pub const MAX_FRAMES: u32 = <TemplateBuilder>::MAX_FRAMES;

    /// Creates a builder for templates of `frames` frames, one cycle, at most [`Self::MAX_FRAMES`]
    /// except for [`Template::Silhouettes`]. Templates of motion history cover the whole cycle, and
    /// a silhouette fades by 1 a frame.
    #[must_use]
    pub fn new(template: Template, size: Size, frames: u32) -> Self {
        let made_from = match template {
            Template::Silhouettes => MadeFrom::Frames(Vec::new()),
            Template::Kfd => MadeFrom::Outlines(Vec::new()),
            Template::Gei => images(TemplateKind::Gei, size, frames),
            Template::Mei => images(TemplateKind::Mei, size, frames),
            Template::Mhi => images(TemplateKind::Mhi, size, frames),
            Template::Msi => images(TemplateKind::Msi, size, frames),
            Template::Ghi => images(TemplateKind::Ghi, size, frames),
            Template::Geni | Template::RowWidth => images(TemplateKind::Geni, size, frames),
            Template::Frequency => images(TemplateKind::Frequency, size, frames),
        };
        Self {
            template,
            size,
            frames: match template {
                Template::Silhouettes => frames,
                _ => frames.clamp(1, Self::MAX_FRAMES),
            },
            added: 0,
            made_from,
        }
    }

    /// Returns the template that the builder makes.
    #[must_use]
    pub const fn template(&self) -> Template {
        self.template
    }

    /// Returns the number of frames of a template.
    #[must_use]
    pub const fn frames(&self) -> u32 {
        self.frames
    }

    /// Adds a frame.
    ///
    /// # Errors
    /// If the frame has another size, or the template is full.
    pub fn add(&mut self, frame: &AnySilhouette) -> Result<()> {
        let (expected, found) = (self.size, frame.size());
        if found != expected {
            return Err(FrameError::Size { expected, found }.into());
        }
        if self.added == self.frames {
            let frames = self.frames;
            return Err(FrameError::Full { frames }.into());
        }
        match &mut self.made_from {
            MadeFrom::Images(builder) => builder.add(frame)?,
            MadeFrom::Outlines(outlines) => {
                outlines.extend(kfd::centred_outline(&frame.silhouette()));
            }
            MadeFrom::Frames(bytes) => bytes.extend(frame.to_coverage().pixels()),
        }
        self.added += 1;
        Ok(())
    }

    /// Returns the bytes of the template of the frames so far, and clears the frames. A template
    /// has as many bytes as [`Template::shape`] states; silhouettes have as many for each frame.
    #[must_use]
    pub fn finish(&mut self) -> Vec<u8> {
        self.added = 0;
        match &mut self.made_from {
            MadeFrom::Images(builder) => {
                let mut bytes = vec![0; builder.kind().bytes(self.size)];
                builder.finish(&mut bytes);
                builder.clear();
                if self.template == Template::RowWidth {
                    let widths = row_width::row_widths(&bytes, self.size, 0);
                    return row_width::bytes(&widths, self.size);
                }
                bytes
            }
            MadeFrom::Outlines(outlines) => {
                kfd::bytes(&kfd::descriptors(&std::mem::take(outlines)))
            }
            MadeFrom::Frames(bytes) => std::mem::take(bytes),
        }
    }
}

fn images(kind: TemplateKind, size: Size, frames: u32) -> MadeFrom {
    MadeFrom::Images(Box::new(TemplateBuilder::for_kind(kind, size, frames)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use edgegait_core::silhouette::Silhouette;

    #[test]
    fn every_template_has_the_bytes_that_its_shape_says_and_forgets_its_frames() {
        let frame = |rows: &[u64]| AnySilhouette::Binary(Silhouette::from_rows(Size::S64x44, rows));
        let frames = [frame(&[7, 7, 5]), frame(&[7, 7, 9])];
        for template in Template::ALL {
            let mut builder = Builder::new(template, Size::S64x44, 2);
            let mut made = || {
                for frame in &frames {
                    builder.add(frame).expect("room");
                }
                builder.finish()
            };
            let first = made();
            let inputs = if template == Template::Silhouettes {
                2
            } else {
                1
            };
            let numbers = template.shape(Size::S64x44).numbers();
            assert_eq!(first.len(), inputs * numbers, "{template:?}");
            assert!(first.iter().any(|&byte| byte > 0), "{template:?}");
            assert_eq!(made(), first, "{template:?}");
        }
    }

    #[test]
    fn frames_of_another_size_and_more_than_were_to_come_are_refused_by_all_templates() {
        let frame = |size| AnySilhouette::Binary(Silhouette::from_rows(size, &[1]));
        for template in Template::ALL {
            let mut builder = Builder::new(template, Size::S64x44, 2);
            let other = builder.add(&frame(Size::S50x30));
            assert_eq!(
                other.expect_err("another size").to_string(),
                "expected a frame of 64x44 pixels, found one of 50x30 (draw it at that size)"
            );
            for _ in 0..2 {
                builder.add(&frame(Size::S64x44)).expect("room");
            }
            let more = builder.add(&frame(Size::S64x44));
            assert_eq!(
                more.expect_err("a third frame").to_string(),
                "expected at most 2 frames in this template, found one more (begin another)"
            );
            let _ = builder.finish();
            builder.add(&frame(Size::S64x44)).expect("room again");
        }
    }

    #[test]
    fn row_widths_are_those_of_the_entropy_image() {
        let size = Size::S50x30;
        let mut builder = Builder::new(Template::RowWidth, size, 2);
        for rows in [[0b0001_0110, 0b111], [0b0001_1010, 0b111]] {
            let frame = AnySilhouette::Binary(Silhouette::from_rows(size, &rows));
            builder.add(&frame).expect("room");
        }
        // Columns 2 and 3 of the first row change; the second row does not change.
        let found = builder.finish();
        assert_eq!((found.len(), &found[..3]), (50, &[17, 0, 0][..]));
    }
}
