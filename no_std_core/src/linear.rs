//! A linear recognizer with 8-bit weights, read in place, which identifies the walker of a GEI.
//!
//! PCA and LDA, or a linear support vector machine on principal components, are one affine function
//! from pixels to class scores. Its weights in 8 bits lie in flash, 1,500 bytes a class, and a
//! score is a sum of integers. `edgegait quantize` makes the file from an ONNX model; `FORMAT.md`
//! has its layout.

use crate::budget::{MAX_CLASSES, MAX_PIXELS};
use crate::camera::Framing;
use crate::format::{
    CLASS_BYTES, FRAMING_BOX, FRAMING_HEIGHT, FormatError, RECOGNIZER_CLASSES_AT,
    RECOGNIZER_CRC_AT, RECOGNIZER_FRAMING_AT, RECOGNIZER_HEADER_BYTES, RECOGNIZER_MAGIC,
    RECOGNIZER_SIZE_AT, RECOGNIZER_VERSION, RECOGNIZER_VERSION_AT, crc32, f32_at, u16_at, u32_at,
};
use crate::silhouette::Size;

/// A recognizer in a file's bytes.
#[derive(Clone, Copy, Debug)]
pub struct LinearRecognizer<'a> {
    size: Size,
    framing: Framing,
    /// A scale and a bias for each class.
    classes: &'a [u8],
    /// The weights, class after class, rows from the top.
    weights: &'a [u8],
    names: PackedNames<'a>,
}

impl<'a> LinearRecognizer<'a> {
    /// Checks all of `bytes` once; reading cannot fail afterwards. Most of the time goes into the
    /// checksum ([`crc32`]).
    ///
    /// # Errors
    /// If the bytes are not a recognizer of this version. The error states the byte, and what was
    /// expected there.
    pub fn parse(bytes: &'a [u8]) -> Result<Self, FormatError> {
        if bytes.get(..RECOGNIZER_MAGIC.len()) != Some(&RECOGNIZER_MAGIC) {
            return Err(FormatError::new(
                0,
                "\"EGLR\", the first bytes of a recognizer",
            ));
        }
        if bytes.len() < RECOGNIZER_HEADER_BYTES {
            return Err(FormatError::new(bytes.len(), "the rest of the header"));
        }
        if u16_at(bytes, RECOGNIZER_VERSION_AT) != RECOGNIZER_VERSION {
            return Err(FormatError::new(
                RECOGNIZER_VERSION_AT,
                "version 1 (make the recognizer again, or use the EdgeGait that wrote it)",
            ));
        }
        let checked = bytes.get(RECOGNIZER_VERSION_AT..).unwrap_or_default();
        if u32_at(bytes, RECOGNIZER_CRC_AT) != crc32(checked) {
            return Err(FormatError::new(
                RECOGNIZER_CRC_AT,
                "the CRC-32 of what follows (the file is damaged)",
            ));
        }
        let size = read_size(bytes)?;
        let framing = match bytes.get(RECOGNIZER_FRAMING_AT) {
            Some(&FRAMING_HEIGHT) => Framing::Height,
            Some(&FRAMING_BOX) => Framing::Box,
            _ => {
                return Err(FormatError::new(
                    RECOGNIZER_FRAMING_AT,
                    "framing 0 (height) or 1 (box)",
                ));
            }
        };
        let count = bytes
            .get(RECOGNIZER_CLASSES_AT)
            .copied()
            .map_or(0, usize::from);
        if count == 0 {
            return Err(FormatError::new(
                RECOGNIZER_CLASSES_AT,
                "at least one class",
            ));
        }
        let weights_at = RECOGNIZER_HEADER_BYTES + count * CLASS_BYTES;
        let names_at = weights_at + count * size.pixels();
        let (Some(classes), Some(weights), Some(names)) = (
            bytes.get(RECOGNIZER_HEADER_BYTES..weights_at),
            bytes.get(weights_at..names_at),
            bytes.get(names_at..),
        ) else {
            return Err(FormatError::new(
                bytes.len(),
                "the rest of the classes and their weights",
            ));
        };
        check_classes(classes).map_err(|error| error.behind(RECOGNIZER_HEADER_BYTES))?;
        let names = PackedNames { rest: names };
        names.check(count).map_err(|error| error.behind(names_at))?;
        Ok(Self {
            size,
            framing,
            classes,
            weights,
            names,
        })
    }

    /// Returns the number of classes, 1..=255.
    #[must_use]
    pub const fn classes(&self) -> usize {
        self.classes.len() / CLASS_BYTES
    }

    /// Returns the name of a class, such as a person's.
    #[must_use]
    pub fn name(&self, class: usize) -> Option<&'a str> {
        let mut names = self.names;
        (0..class).try_for_each(|_| names.next().map(drop))?;
        names.next()
    }

    /// Returns the size of the GEIs that it accepts.
    #[must_use]
    pub const fn size(&self) -> Size {
        self.size
    }

    /// Returns how figures have to be framed: [`Framing::Height`] or [`Framing::Box`].
    #[must_use]
    pub const fn framing(&self) -> Framing {
        self.framing
    }

    /// Returns the score of a class for a GEI's pixels, rows from the top; `None` if there is no
    /// such class, or for pixels of another size.
    ///
    /// The score is `scale * sum(weight * pixel) + bias`. The sum of integers is exact, then
    /// rounded to 24 bits; the product and the final sum are rounded likewise. Never NaN.
    #[must_use]
    pub fn score(&self, class: usize, pixels: &[u8]) -> Option<f32> {
        if pixels.len() != self.size.pixels() {
            return None;
        }
        let numbers = self.classes.chunks_exact(CLASS_BYTES).nth(class)?;
        let weights = self.weights.chunks_exact(self.size.pixels()).nth(class)?;
        Some(affine(numbers, weights, pixels))
    }

    /// Returns the class with the greatest score, and that score. Ties go to the first class.
    /// `None` for pixels of another size.
    #[must_use]
    pub fn classify(&self, pixels: &[u8]) -> Option<(usize, f32)> {
        if pixels.len() != self.size.pixels() {
            return None;
        }
        let numbers = self.classes.chunks_exact(CLASS_BYTES);
        let weights = self.weights.chunks_exact(self.size.pixels());
        let mut best: Option<(usize, f32)> = None;
        for (class, (numbers, weights)) in numbers.zip(weights).enumerate() {
            let score = affine(numbers, weights, pixels);
            if best.is_none_or(|(_, greatest)| score > greatest) {
                best = Some((class, score));
            }
        }
        best
    }
}

/// No sum of products overflows: 4,096 x 128 x 255 = 133,693,440.
const _: () = assert!(MAX_PIXELS * 128 * 255 <= i32::MAX as usize);
/// The number of classes fits into a byte.
const _: () = assert!(MAX_CLASSES == u8::MAX as usize);

/// Returns the score of one class; `numbers` are its scale and bias.
fn affine(numbers: &[u8], weights: &[u8], pixels: &[u8]) -> f32 {
    let products = weights.iter().zip(pixels);
    let sum: i32 = products
        .map(|(weight, &pixel)| i32::from(weight.cast_signed()) * i32::from(pixel))
        .sum();
    #[expect(
        clippy::cast_precision_loss,
        reason = "rounded to the nearest, ties to even, on every target"
    )]
    let sum = sum as f32;
    f32_at(numbers, 0) * sum + f32_at(numbers, 4)
}

fn read_size(bytes: &[u8]) -> Result<Size, FormatError> {
    let at = |at: usize| bytes.get(at).copied().map(usize::from);
    let (rows, columns) = (at(RECOGNIZER_SIZE_AT), at(RECOGNIZER_SIZE_AT + 1));
    let is_it = |size: &Size| (Some(size.rows()), Some(size.columns())) == (rows, columns);
    Size::ALL.into_iter().find(is_it).ok_or(FormatError::new(
        RECOGNIZER_SIZE_AT,
        "50 rows and 30 columns, 64 and 44, or 64 and 64",
    ))
}

fn check_classes(classes: &[u8]) -> Result<(), FormatError> {
    for (at, number) in classes.chunks_exact(4).enumerate() {
        if !f32_at(number, 0).is_finite() {
            return Err(FormatError::new(4 * at, "a finite scale and a finite bias"));
        }
    }
    Ok(())
}

/// Names one after another, each preceded by a byte with its length.
#[derive(Clone, Copy, Debug)]
struct PackedNames<'a> {
    rest: &'a [u8],
}

impl PackedNames<'_> {
    /// Checks that there are exactly `count` names, in UTF-8.
    fn check(mut self, count: usize) -> Result<(), FormatError> {
        let all = self.rest.len();
        for _ in 0..count {
            let at = all - self.rest.len();
            if self.next().is_none() {
                return Err(FormatError::new(
                    at,
                    "the length of a name, and that many bytes of UTF-8",
                ));
            }
        }
        if !self.rest.is_empty() {
            return Err(FormatError::new(
                all - self.rest.len(),
                "the end of the recognizer after its last name",
            ));
        }
        Ok(())
    }
}

impl<'a> Iterator for PackedNames<'a> {
    type Item = &'a str;

    fn next(&mut self) -> Option<&'a str> {
        let (&length, rest) = self.rest.split_first()?;
        let (name, rest) = rest.split_at_checked(usize::from(length))?;
        self.rest = rest;
        core::str::from_utf8(name).ok()
    }
}
