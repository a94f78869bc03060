//! A line of text without a heap.

use core::fmt::{Error, Result, Write};

/// A line of at most 96 bytes of text; more is an error.
pub struct Line {
    bytes: [u8; 96],
    len: usize,
}

impl Line {
    /// An empty line.
    pub const EMPTY: Self = Self {
        bytes: [0; 96],
        len: 0,
    };

    /// Returns the text.
    #[must_use]
    pub fn as_str(&self) -> &str {
        let bytes = self.bytes.get(..self.len).unwrap_or_default();
        core::str::from_utf8(bytes).unwrap_or_default()
    }
}

impl Write for Line {
    fn write_str(&mut self, part: &str) -> Result {
        let room = self.bytes.get_mut(self.len..self.len + part.len());
        room.ok_or(Error)?.copy_from_slice(part.as_bytes());
        self.len += part.len();
        Ok(())
    }
}
