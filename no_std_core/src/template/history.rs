//! The time of each pixel's last change, or when it was last on, from which motion templates are
//! computed.
//!
//! Motion is the difference of consecutive silhouettes, so that each frame touches only the pixels
//! at a figure's edge. Ages are computed when the template is written.

use super::memory::Memory;
use super::{FrameError, TemplateKind};
use crate::budget::{MAX_PIXELS, MAX_ROWS};
use crate::silhouette::{AnySilhouette, Silhouette, Size};

/// The event of a pixel whose number is stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum PixelEvent {
    /// A frame changes the pixel: the number of the step that leads to the frame, from 1.
    Change,
    /// A frame turns the pixel off: the number of the last frame in which it was on, from 1.
    End,
}

/// The last event of each pixel. 9 kB.
#[derive(Clone, Debug)]
pub struct History {
    event: PixelEvent,
    frames: u16,
    /// The last frame.
    last: Silhouette,
    /// Pixels that were on in all frames.
    always: [u64; MAX_ROWS],
    /// The number of the last event; 0 if there was none.
    numbers: [u16; MAX_PIXELS],
}

impl History {
    pub(super) const fn new(event: PixelEvent, size: Size) -> Self {
        Self {
            event,
            frames: 0,
            last: Silhouette::empty(size),
            always: [u64::MAX; MAX_ROWS],
            numbers: [0; MAX_PIXELS],
        }
    }

    /// Writes the brightness of each pixel with motion: white in the last step, and a tau-th less
    /// for each step before, where tau is the number of planned steps (at least 1).
    fn motion(&self, planned: u32, bytes: &mut [u8]) {
        let tau = planned.saturating_sub(1).max(1);
        let steps = u32::from(self.frames.saturating_sub(1));
        for (byte, &number) in bytes.iter_mut().zip(&self.numbers) {
            let age = steps - u32::from(number);
            let value = if number == 0 {
                0
            } else {
                tau.saturating_sub(age)
            };
            *byte = share(u64::from(value), u64::from(tau));
        }
    }

    /// Writes white for each pixel with motion, otherwise black.
    fn moved(&self, bytes: &mut [u8]) {
        for (byte, &number) in bytes.iter_mut().zip(&self.numbers) {
            *byte = if number > 0 { u8::MAX } else { 0 };
        }
    }

    /// Writes white for each pixel that is on in the last frame, and 1 less for each frame since it
    /// was on.
    fn presence(&self, bytes: &mut [u8]) {
        let is_on = Self::pixels(self.last.size(), self.last.all_rows());
        for ((byte, &number), is_on) in bytes.iter_mut().zip(&self.numbers).zip(is_on) {
            let since = self.frames - number;
            *byte = match (is_on, number) {
                (true, _) => u8::MAX,
                (false, 0) => 0,
                _ => u8::MAX.saturating_sub(u8::try_from(since).unwrap_or(u8::MAX)),
            };
        }
    }

    /// Writes white for each pixel that is on in all frames, and t/P (1 - 1/P) if step t of P was
    /// the last that changed it.
    fn lasting(&self, bytes: &mut [u8]) {
        let always = if self.frames == 0 {
            &[0; MAX_ROWS]
        } else {
            &self.always
        };
        let steps = u64::from(self.frames.saturating_sub(1));
        let is_always = Self::pixels(self.last.size(), always);
        for ((byte, &number), is_always) in bytes.iter_mut().zip(&self.numbers).zip(is_always) {
            *byte = match (is_always, number) {
                (true, _) => u8::MAX,
                (false, 0) => 0,
                _ => share(u64::from(number) * (steps - 1), steps * steps),
            };
        }
    }

    /// Returns whether each pixel is on, row by row.
    fn pixels(size: Size, rows: &[u64; MAX_ROWS]) -> impl Iterator<Item = bool> {
        let columns = move |row: &u64| {
            let row = *row;
            (0..size.columns()).map(move |column| row >> column & 1 == 1)
        };
        rows.iter().take(size.rows()).flat_map(columns)
    }
}

impl Memory for History {
    fn add(&mut self, frame: &AnySilhouette) -> Result<(), FrameError> {
        let frame = frame.silhouette();
        let sizes = [self.last.size(), frame.size()];
        FrameError::check(sizes, u32::from(self.frames), u32::from(u16::MAX))?;
        let columns = self.last.size().columns();
        let before = self.last.all_rows().iter().zip(frame.all_rows());
        for (row, (&before, &now)) in before.enumerate() {
            let mut events = match self.event {
                _ if self.frames == 0 => 0,
                PixelEvent::Change => before ^ now,
                PixelEvent::End => before & !now,
            };
            while events != 0 {
                let pixel = row * columns + events.trailing_zeros() as usize;
                if let Some(number) = self.numbers.get_mut(pixel) {
                    *number = self.frames;
                }
                events &= events - 1;
            }
        }
        for (always, now) in self.always.iter_mut().zip(frame.all_rows()) {
            *always &= now;
        }
        self.last = frame;
        self.frames += 1;
        Ok(())
    }

    fn frames(&self) -> u32 {
        u32::from(self.frames)
    }

    fn clear(&mut self) {
        self.frames = 0;
        self.always = [u64::MAX; MAX_ROWS];
        self.numbers.fill(0);
    }

    fn write(&mut self, kind: TemplateKind, planned: u32, bytes: &mut [u8]) {
        match kind {
            TemplateKind::Mei => self.moved(bytes),
            TemplateKind::Msi => self.presence(bytes),
            TemplateKind::Ghi => self.lasting(bytes),
            _ => self.motion(planned, bytes),
        }
    }
}

/// Returns 255 times a share of 0..=1, rounded half up.
fn share(part: u64, whole: u64) -> u8 {
    u8::try_from((255 * part + whole / 2) / whole).unwrap_or(u8::MAX)
}
