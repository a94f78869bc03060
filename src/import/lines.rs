//! Reads the numbered lines of a text file in bounded memory.
//!
//! Motion files come with a byte-order mark, with CR, LF or CRLF, with names in Latin-1 or
//! Shift-JIS, and sometimes as one line of 100 MB. This reader accepts all but the last, which it
//! rejects before it is in memory.

use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};

use crate::error::{Error, FilePlace, Result};
use crate::files::open;

/// Longest accepted line, bytes. Our choice: a row of 4,096 joints fits.
const MAX_LINE: usize = 1 << 20;

/// Longest accepted file, bytes. Our choice: the largest real clip has 2 MB; parsed values take up
/// to six times the text.
const MAX_FILE: usize = 256 << 20;

/// The lines of one file, in order.
pub(super) struct Lines {
    path: PathBuf,
    reader: Box<dyn BufRead>,
    number: usize,
    bytes: usize,
    ended_with_cr: bool,
    raw: Vec<u8>,
}

impl Lines {
    /// Opens the file at `path`.
    pub(super) fn open(path: &Path) -> Result<Self> {
        let file = open(path)?;
        Ok(Self::over(path, Box::new(BufReader::new(file))))
    }

    /// Reads from `reader`. Errors name `path`.
    pub(super) fn over(path: &Path, reader: Box<dyn BufRead>) -> Self {
        Self {
            path: path.to_path_buf(),
            reader,
            number: 0,
            bytes: 0,
            ended_with_cr: false,
            raw: Vec::new(),
        }
    }

    /// Returns the path of the file.
    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    /// Returns the number of the line read last, counted from 1.
    pub(super) const fn number(&self) -> usize {
        self.number
    }

    /// Returns an error at the line read last.
    pub(super) fn error(&self, problem: impl Into<String>) -> Error {
        Error::at(&self.path, FilePlace::Line(self.number.max(1)), problem)
    }

    /// Returns the next line that is not blank, trimmed. Bytes that are not UTF-8 become U+FFFD: in
    /// a valid file only names hold them.
    ///
    /// # Errors
    /// For a line or file over the limits, a NUL byte, UTF-16, or a failed read.
    pub(super) fn next_line(&mut self) -> Result<Option<String>> {
        let line = self.next_row()?;
        Ok(line.map(|line| line.trim().to_owned()))
    }

    /// Returns the next line that is not blank, untrimmed, since white space may be empty cells of
    /// a table.
    ///
    /// # Errors
    /// As [`Lines::next_line`].
    pub(super) fn next_row(&mut self) -> Result<Option<String>> {
        while self.fill()? {
            if self.number == 1 {
                if self.raw.starts_with(&[0xFF, 0xFE]) || self.raw.starts_with(&[0xFE, 0xFF]) {
                    return Err(self.error("the text is UTF-16; save it as UTF-8"));
                }
                if self.raw.starts_with(&[0xEF, 0xBB, 0xBF]) {
                    self.raw.drain(..3);
                }
            }
            if self.raw.contains(&0) {
                return Err(self.error("a NUL byte: this is not a text file"));
            }
            let text = String::from_utf8_lossy(&self.raw);
            if !text.trim().is_empty() {
                return Ok(Some(text.into_owned()));
            }
        }
        Ok(None)
    }

    /// Reads one line without its end into `raw`. Returns false at the end of the file.
    fn fill(&mut self) -> Result<bool> {
        self.raw.clear();
        self.number += 1;
        loop {
            let chunk = self
                .reader
                .fill_buf()
                .map_err(|source| Error::io(&self.path, source))?;
            if chunk.is_empty() {
                return Ok(!self.raw.is_empty());
            }
            // The LF of a CRLF that was split between two calls.
            let skip = usize::from(self.ended_with_cr && chunk.first() == Some(&b'\n'));
            self.ended_with_cr = false;
            let body = &chunk[skip..];
            let end = body.iter().position(|&b| b == b'\n' || b == b'\r');
            let taken = end.unwrap_or(body.len());
            if self.raw.len() + taken > MAX_LINE {
                return Err(self.error(format!("the line is longer than {MAX_LINE} bytes")));
            }
            self.raw.extend_from_slice(&body[..taken]);
            self.ended_with_cr = end.is_some_and(|at| body[at] == b'\r');
            let used = skip + taken + usize::from(end.is_some());
            self.bytes += used;
            self.reader.consume(used);
            if self.bytes > MAX_FILE {
                return Err(self.error(format!("the file is longer than {MAX_FILE} bytes")));
            }
            if end.is_some() {
                return Ok(true);
            }
        }
    }
}

/// Parses a finite number. The error describes what is wrong with `token`.
pub(super) fn finite(token: &str) -> std::result::Result<f64, String> {
    match token.parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        Ok(_) => Err(format!(
            "expected a finite number, found `{}`",
            shown(token)
        )),
        Err(_) if token.contains(',') => Err(format!(
            "expected a number, found `{}` (decimal commas are not numbers)",
            shown(token)
        )),
        Err(_) => Err(format!("expected a number, found `{}`", shown(token))),
    }
}

/// Escapes `text` and shortens it for an error message.
pub(super) fn shown(text: &str) -> String {
    const LONGEST: usize = 40;
    if text.chars().count() <= LONGEST {
        return text.escape_debug().to_string();
    }
    let head: String = text.chars().take(LONGEST).collect();
    format!("{}...", head.escape_debug())
}

#[cfg(test)]
mod tests {
    use std::io::{Cursor, Read};

    use super::*;

    fn read_all(bytes: &[u8]) -> Result<Vec<(usize, String)>> {
        let mut lines = Lines::over(Path::new("t"), Box::new(Cursor::new(bytes.to_vec())));
        let mut all = Vec::new();
        while let Some(text) = lines.next_line()? {
            all.push((lines.number(), text));
        }
        Ok(all)
    }

    #[test]
    fn every_line_ending_gives_the_same_lines_and_numbers() {
        let expected = vec![(1, "a b".to_owned()), (3, "c".to_owned())];
        for text in [
            "a b\n\nc",
            "a b\r\n\r\nc\r\n",
            "a b\r\rc\r",
            "\u{feff}a b\n\n c \n",
        ] {
            assert_eq!(read_all(text.as_bytes()).unwrap(), expected, "{text:?}");
        }
    }

    #[test]
    fn an_endless_line_is_refused_in_bounded_memory() {
        let endless = BufReader::new(std::io::repeat(b'7').take(1 << 40));
        let mut lines = Lines::over(Path::new("t"), Box::new(endless));
        let message = lines.next_line().unwrap_err().to_string();
        assert_eq!(message, "t:1: the line is longer than 1048576 bytes");
    }

    #[test]
    fn utf_16_and_nul_bytes_are_refused() {
        assert!(
            read_all(b"\xff\xfeH\0")
                .unwrap_err()
                .to_string()
                .contains("UTF-16")
        );
        assert!(
            read_all(b"a\nb\0c")
                .unwrap_err()
                .to_string()
                .starts_with("t:2: a NUL")
        );
    }
}
