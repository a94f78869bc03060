//! A bounded reader of protobuf messages over borrowed bytes.
//!
//! See protobuf.dev/programming-guides/encoding. It allocates only strings that a caller asks for,
//! and never recurses.
//!
//! rten-onnx 0.27 has no bounds: it allocates whatever a length claims (2^38 bytes for a file of 7)
//! and follows nested graphs until the stack overflows, both of which kill the process. It also
//! accepts a graph that is cut between two fields, and rejects packed integers, which ONNX Runtime
//! reads. rten uses it, so every file is read here first.

/// Where and why bytes are not a message.
#[derive(Debug)]
pub(super) struct Malformed {
    /// The offset from the start of the file.
    pub byte: usize,
    pub problem: String,
}

/// The value of a field.
pub(super) enum ProtobufField<'a> {
    /// An integer.
    Number(u64),
    /// Text, raw bytes, packed numbers or a message.
    Bytes(ProtobufReader<'a>),
    /// Four or eight fixed bytes, which no caller needs.
    Fixed,
}

/// A message, or the part of it that is still to be read.
#[derive(Clone, Copy)]
pub(super) struct ProtobufReader<'a> {
    rest: &'a [u8],
    /// Offset of `rest` in the file.
    byte: usize,
}

impl<'a> ProtobufReader<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Self {
            rest: bytes,
            byte: 0,
        }
    }

    pub(super) fn is_empty(&self) -> bool {
        self.rest.is_empty()
    }

    pub(super) fn malformed(&self, problem: impl Into<String>) -> Malformed {
        Malformed {
            byte: self.byte,
            problem: problem.into(),
        }
    }

    /// Returns the next field's number and value; `None` at the end.
    pub(super) fn next(&mut self) -> Result<Option<(u64, ProtobufField<'a>)>, Malformed> {
        if self.rest.is_empty() {
            return Ok(None);
        }
        let start = *self;
        let tag = self.varint()?;
        let number = tag >> 3;
        if number == 0 {
            return Err(start.malformed("a field with the number 0"));
        }
        let field = match tag & 7 {
            0 => ProtobufField::Number(self.varint()?),
            1 => self.take(8).map(|_| ProtobufField::Fixed)?,
            2 => {
                let length = self.varint()?;
                ProtobufField::Bytes(self.take(length)?)
            }
            5 => self.take(4).map(|_| ProtobufField::Fixed)?,
            kind => return Err(start.malformed(format!("a field of unknown kind {kind}"))),
        };
        Ok(Some((number, field)))
    }

    /// Reads to the end, to check that each field is as long as it claims.
    pub(super) fn skim(mut self) -> Result<(), Malformed> {
        while self.next()?.is_some() {}
        Ok(())
    }

    /// Returns the next packed integer; `None` at the end.
    pub(super) fn packed_number(&mut self) -> Result<Option<u64>, Malformed> {
        if self.rest.is_empty() {
            return Ok(None);
        }
        self.varint().map(Some)
    }

    /// Returns the remaining bytes.
    pub(super) fn bytes(&self) -> &'a [u8] {
        self.rest
    }

    /// Returns the remaining bytes as text.
    pub(super) fn text(&self) -> Result<String, Malformed> {
        match std::str::from_utf8(self.rest) {
            Ok(text) => Ok(text.to_owned()),
            Err(_) => Err(self.malformed("a name that is not UTF-8")),
        }
    }

    fn take(&mut self, length: u64) -> Result<Self, Malformed> {
        let taken = usize::try_from(length)
            .ok()
            .and_then(|length| self.rest.split_at_checked(length));
        let Some((content, rest)) = taken else {
            return Err(self.malformed(format!(
                "expected {length} more bytes, found {}",
                self.rest.len()
            )));
        };
        let content = Self {
            rest: content,
            byte: self.byte,
        };
        self.byte += content.rest.len();
        self.rest = rest;
        Ok(content)
    }

    fn varint(&mut self) -> Result<u64, Malformed> {
        let mut value = 0;
        for (index, &byte) in self.rest.iter().take(10).enumerate() {
            let low = u64::from(byte & 0x7F);
            value |= low << (7 * index);
            if byte < 0x80 {
                self.rest = &self.rest[index + 1..];
                self.byte += index + 1;
                return Ok(value);
            }
        }
        Err(self.malformed("an integer that does not end"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_guides_examples_are_read() {
        let mut message = ProtobufReader::new(b"\x08\x96\x01\x12\x07testing");
        assert!(matches!(
            message.next(),
            Ok(Some((1, ProtobufField::Number(150))))
        ));
        let Ok(Some((2, ProtobufField::Bytes(text)))) = message.next() else {
            panic!("expected field 2");
        };
        assert_eq!(text.text().expect("UTF-8"), "testing");
        assert!(matches!(message.next(), Ok(None)));
    }

    #[test]
    fn the_largest_integer_is_read_and_an_endless_one_refused() {
        let largest = [0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0x01];
        assert!(matches!(
            ProtobufReader::new(&largest).packed_number(),
            Ok(Some(u64::MAX))
        ));
        assert!(ProtobufReader::new(&[0xFF; 11]).packed_number().is_err());
    }

    #[test]
    fn errors_point_at_the_byte_in_the_file() {
        let mut message = ProtobufReader::new(b"\x08\x01\x12\x7Fshort");
        assert!(message.next().is_ok());
        let error = message.next().err().expect("cut short");
        assert_eq!(
            (error.byte, error.problem.as_str()),
            (4, "expected 127 more bytes, found 5")
        );
    }
}
