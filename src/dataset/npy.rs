//! NumPy's .npy files of bytes, written atomically and validated when read.
//!
//! Format: NEP 1 (Kern, 2007), <https://numpy.org/neps/nep-0001-npy-format.html>.

use std::borrow::Cow;
use std::io::Write as _;
use std::path::Path;

use super::mask_numbers::{ByteArray, NumberType};
use crate::draw::template::{Template, TemplateShape};
use crate::error::{Error, Result};
use crate::files::write_atomically;
use edgegait_core::silhouette::Size;

/// The longest header that is parsed, bytes. NumPy writes 128 bytes for our shapes.
const MAX_HEADER: usize = 1024;

/// The length of [`npy_header`], bytes.
pub(super) const NPY_HEADER: usize = 128;

/// Returns the header of a .npy file, version 1.0: 128 bytes for our shapes, the text padded with
/// spaces.
pub(super) fn npy_header(descr: &str, shape: &[usize]) -> Vec<u8> {
    let mut sides: Vec<String> = shape.iter().map(usize::to_string).collect();
    if sides.len() == 1 {
        sides.push(String::new());
    }
    let sides = sides.join(", ");
    let text = format!(
        "{{'descr': '{descr}', 'fortran_order': False, 'shape': ({})}}",
        sides.trim_end()
    );
    let mut bytes = b"\x93NUMPY\x01\x00\x76\x00".to_vec();
    bytes.extend(text.as_bytes());
    bytes.resize(NPY_HEADER - 1, b' ');
    bytes.push(b'\n');
    bytes
}

/// Writes bytes as a .npy file, whole or not at all: `[T, rows, columns]` for one
/// viewpoint's silhouettes, `[V, T, rows, columns]` for several.
///
/// # Errors
///
/// If the shape is not that of so many bytes, or the file cannot be written.
pub fn write_npy(path: impl AsRef<Path>, shape: &[usize], numbers: &[u8]) -> Result<()> {
    let path = path.as_ref();
    if product(shape) != Some(numbers.len()) {
        let found = numbers.len();
        let problem = format!("expected numbers of the shape {shape:?}, found {found} numbers");
        return Err(Error::input(path, problem));
    }
    write_atomically(path, |file| {
        file.write_all(&npy_header("|u1", shape))
            .and_then(|()| file.write_all(numbers))
            .map_err(|source| Error::io(path, source))
    })
}

/// Locates the templates in the bytes of the .npy file `path`: returns the offset of the first, the
/// size of the underlying silhouettes, and the number of templates. Vectors do not show that size,
/// so it must be `stated`.
pub(super) fn template_bytes(
    path: &Path,
    bytes: &[u8],
    template: Template,
    stated: Option<Size>,
) -> Result<(usize, Size, usize)> {
    let refuse = |problem: String| Error::input(path, problem);
    let header = Header::of_file(bytes).map_err(refuse)?;
    let dimensions = header.shape.len();
    let (size, count) = if let TemplateShape::Vector(_) = template.shape(Size::default()) {
        let [count, numbers] = header.shape[..] else {
            return Err(refuse(format!(
                "expected 2 dimensions [N, numbers], found {dimensions}"
            )));
        };
        let Some(size) = stated else {
            return Err(refuse(
                "expected the size of the silhouettes under \"settings\" in manifest.json, as in \"size\": \"50x30\", found none".into(),
            ));
        };
        let expected = template.shape(size).numbers();
        if numbers != expected {
            return Err(refuse(format!(
                "expected shape [N, {expected}], found [{count}, {numbers}]"
            )));
        }
        (size, count)
    } else {
        let [count, rows, columns] = header.shape[..] else {
            return Err(refuse(format!(
                "expected 3 dimensions [N, rows, columns], found {dimensions}"
            )));
        };
        let stacked = |size: Size| {
            let rows = template.shape(size).numbers() / size.columns();
            (rows, size.columns())
        };
        let size = Size::ALL
            .into_iter()
            .find(|&size| stacked(size) == (rows, columns));
        let Some(size) = size else {
            let [a, b, c] = Size::ALL
                .map(stacked)
                .map(|(r, c)| format!("[N, {r}, {c}]"));
            return Err(refuse(format!(
                "expected shape {a}, {b} or {c}, found [{count}, {rows}, {columns}]"
            )));
        };
        (size, count)
    };
    if header.is_fortran {
        return Err(refuse(FORTRAN.into()));
    }
    Ok((header.first, size, count))
}

/// Reads the array in the bytes of a .npy file of masks as grey pixels.
pub(super) fn mask_array(bytes: &[u8]) -> std::result::Result<ByteArray<'_>, String> {
    let header = Header::parse(bytes)?;
    let name = header.descr.trim_matches('\'');
    let kind = NumberType::parse(name.trim_start_matches(['<', '|']));
    let kind = kind.ok_or_else(|| NumberType::expected(name))?;
    if header.is_fortran {
        return Err(FORTRAN.into());
    }
    let numbers = product(&header.shape).and_then(|numbers| numbers.checked_mul(kind.bytes()));
    header.check_length(bytes, numbers.unwrap_or(usize::MAX))?;
    Ok(ByteArray {
        bytes: kind.grey(Cow::Borrowed(&bytes[header.first..]))?,
        shape: header.shape,
    })
}

/// Returns the shape that the beginning of a .npy file states, if it has three sides.
pub(super) fn stated_shape(start: &[u8]) -> Option<[usize; 3]> {
    Header::parse(start).ok()?.shape.try_into().ok()
}

/// The message about an array whose columns come first.
const FORTRAN: &str = "expected C order, found Fortran order (save numpy.ascontiguousarray of it)";

/// The header of a .npy file, read where it lies: nothing is allocated for what it claims.
struct Header {
    /// The type of the numbers in NumPy's notation, with quotes.
    descr: String,
    is_fortran: bool,
    shape: Vec<usize>,
    /// The offset of the first number.
    first: usize,
}

impl Header {
    /// Reads the header of a file of bytes, which must be as long as the header says.
    fn of_file(bytes: &[u8]) -> std::result::Result<Self, String> {
        let header = Self::parse(bytes)?;
        let expected = product(&header.shape)
            .ok_or("expected a .npy file: overflow computing length from shape")?;
        if !["'|u1'", "'u1'", "'B'"].contains(&&*header.descr) {
            return Err(format!(
                "expected bytes from 0 to 255 ('|u1'), found {} (for numbers from 0 to 1: (255 * x).round().astype('uint8'))",
                header.descr
            ));
        }
        header.check_length(bytes, expected)?;
        Ok(header)
    }

    /// Checks that a file ends with this number of bytes after the header.
    fn check_length(&self, bytes: &[u8], expected: usize) -> std::result::Result<(), String> {
        match (bytes.len() - self.first, expected) {
            (found, expected) if found < expected => Err(format!(
                "the file ends {} bytes too early (was it copied whole?)",
                expected - found
            )),
            (found, expected) if found > expected => Err(format!(
                "expected the end of the file, found {} more bytes",
                found - expected
            )),
            _ => Ok(()),
        }
    }

    fn parse(bytes: &[u8]) -> std::result::Result<Self, String> {
        let another = || {
            format!(
                "expected a .npy header of at most {MAX_HEADER} bytes without nesting, found another"
            )
        };
        // Magic (6 bytes), version (2), length (2 in version 1, 4 after), text.
        let versioned = bytes.strip_prefix(b"\x93NUMPY").ok_or_else(another)?;
        let (start, length) = match *versioned {
            [1, 0, a, b, ..] => (10, usize::from(u16::from_le_bytes([a, b]))),
            [2 | 3, 0, a, b, 0, 0, ..] => (12, usize::from(u16::from_le_bytes([a, b]))),
            _ => return Err(another()),
        };
        if length > MAX_HEADER {
            return Err(another());
        }
        let first = start + length;
        let text = bytes.get(start..first).unwrap_or_default();
        let text = String::from_utf8_lossy(text);
        let broken = || {
            let found = text.trim_end();
            format!("expected the header of a .npy file of bytes, found {found:?}")
        };
        let (descr, is_fortran, shape) = entries(&text).ok_or_else(broken)?;
        Ok(Self {
            descr,
            is_fortran,
            shape,
            first,
        })
    }
}

/// Returns the number of numbers in an array of this shape; none if it overflows.
fn product(shape: &[usize]) -> Option<usize> {
    let mut sides = shape.iter();
    sides.try_fold(1_usize, |product, &side| product.checked_mul(side))
}

/// Reads the text of a header: a dictionary of Python with three entries in any order.
fn entries(text: &str) -> Option<(String, bool, Vec<usize>)> {
    let text = text.strip_suffix('\n')?.replace('"', "'");
    let entries = text.trim().strip_prefix('{')?.strip_suffix('}')?;
    let (before, shape) = entries.split_once("'shape'")?;
    let shape = shape.trim_start().strip_prefix(':')?.trim_start();
    let (shape, after) = shape.strip_prefix('(')?.split_once(')')?;
    let (mut descr, mut is_fortran) = (None, None);
    let others = before.split(',').chain(after.split(',')).map(str::trim);
    for entry in others.filter(|entry| !entry.is_empty()) {
        let (key, value) = entry.split_once(':')?;
        match (key.trim_end(), value.trim_start()) {
            ("'descr'", text) => descr = Some(text.to_owned()),
            ("'fortran_order'", "True") => is_fortran = Some(true),
            ("'fortran_order'", "False") => is_fortran = Some(false),
            _ => return None,
        }
    }
    let shape = shape.trim_end();
    let sides = shape.strip_suffix(',').unwrap_or(shape).split(',');
    let sides = sides.map(|side| side.trim().parse().ok());
    let shape = sides.collect::<Option<_>>()?;
    Some((descr?, is_fortran?, shape))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn npy(header: &str, data: usize) -> Vec<u8> {
        let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
        bytes.extend(u16::try_from(header.len() + 1).unwrap().to_le_bytes());
        bytes.extend(header.as_bytes());
        bytes.push(b'\n');
        bytes.resize(bytes.len() + data, 7);
        bytes
    }

    fn refusal(header: &str, data: usize) -> String {
        template_bytes(
            Path::new("geis.npy"),
            &npy(header, data),
            Template::Gei,
            None,
        )
        .unwrap_err()
        .to_string()
    }

    #[test]
    fn headers_are_those_of_numpy_and_fill_128_bytes() {
        // As `numpy.save` writes them, without the comma before the brace.
        for (descr, shape, expected) in [
            ("|u1", &[2, 64, 44][..], "(2, 64, 44)"),
            ("<f4", &[12_345, 19, 3], "(12345, 19, 3)"),
            ("|u1", &[3, 2, 50, 30], "(3, 2, 50, 30)"),
            ("<U7", &[7], "(7,)"),
        ] {
            let text =
                format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': {expected}}}");
            let bytes = npy_header(descr, shape);
            assert_eq!(&bytes[..10], b"\x93NUMPY\x01\x00\x76\x00");
            assert_eq!(bytes[10..], format!("{text:<117}\n").into_bytes());
        }
    }

    #[test]
    fn silhouettes_come_back_and_are_as_many_as_their_shape_says() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.npy");
        let numbers: Vec<u8> = (0..3000).map(|at| (at % 251) as u8).collect();
        write_npy(&path, &[2, 50, 30], &numbers).unwrap();
        let bytes = std::fs::read(&path).unwrap();
        assert_eq!(bytes[128..], numbers);
        assert_eq!(
            template_bytes(&path, &bytes, Template::Gei, None).unwrap(),
            (128, Size::S50x30, 2)
        );
        for shape in [[2, 50, 31], [usize::MAX, 2, 1]] {
            let refused = write_npy(&path, &shape, &numbers).unwrap_err().to_string();
            assert!(refused.contains("found 3000 numbers"), "{refused}");
        }
        assert_eq!(std::fs::read(&path).unwrap(), bytes);
    }

    #[test]
    fn the_first_gei_begins_after_the_header() {
        let bytes = npy(
            "{'descr': '|u1', 'fortran_order': False, 'shape': (2, 50, 30), }",
            3000,
        );
        assert_eq!(
            template_bytes(Path::new("g"), &bytes, Template::Gei, None).unwrap(),
            (bytes.len() - 3000, Size::S50x30, 2)
        );
    }

    #[test]
    fn what_is_not_geis_is_refused_with_the_reason() {
        let shape = |s| format!("{{'descr': '|u1', 'fortran_order': False, 'shape': {s}, }}");
        assert_eq!(
            refusal(&shape("(2, 44, 64)"), 2 * 64 * 44),
            "geis.npy: expected shape [N, 50, 30], [N, 64, 44] or [N, 64, 64], found [2, 44, 64]"
        );
        assert_eq!(
            refusal(&shape("(2, 1500)"), 3000),
            "geis.npy: expected 3 dimensions [N, rows, columns], found 2"
        );
        assert_eq!(
            refusal(&shape("(2, 50, 30)"), 2999),
            "geis.npy: the file ends 1 bytes too early (was it copied whole?)"
        );
        assert_eq!(
            refusal(&shape("(1, 50, 30)"), 1502),
            "geis.npy: expected the end of the file, found 2 more bytes"
        );
        assert_eq!(
            refusal(
                "{'descr': '<f4', 'fortran_order': False, 'shape': (1, 50, 30), }",
                6000
            ),
            "geis.npy: expected bytes from 0 to 255 ('|u1'), found '<f4' (for numbers from 0 to 1: (255 * x).round().astype('uint8'))"
        );
        assert_eq!(
            refusal(
                "{'descr': '|u1', 'fortran_order': True, 'shape': (2, 50, 30), }",
                3000
            ),
            "geis.npy: expected C order, found Fortran order (save numpy.ascontiguousarray of it)"
        );
        assert!(template_bytes(Path::new("g"), b"", Template::Gei, None).is_err());
        assert!(template_bytes(Path::new("g"), b"\x93NUMPY\x01\x00", Template::Gei, None).is_err());
        assert!(
            template_bytes(
                Path::new("g"),
                b"PK\x03\x04 a zip of some length",
                Template::Gei,
                None
            )
            .is_err()
        );
    }

    #[test]
    fn a_header_in_any_order_spacing_and_version_is_read() {
        let text = b"{\"shape\":( 2,50,30 , ),'fortran_order' : False\t,'descr':'|u1'  }\n";
        let length = u8::try_from(text.len()).unwrap();
        for start in [
            &[1, 0, length, 0][..],
            &[2, 0, length, 0, 0, 0],
            &[3, 0, length, 0, 0, 0],
        ] {
            let bytes = [b"\x93NUMPY", start, text, &[7; 3000]].concat();
            assert_eq!(
                template_bytes(Path::new("g"), &bytes, Template::Gei, None).unwrap(),
                (6 + start.len() + text.len(), Size::S50x30, 2)
            );
        }
    }

    #[test]
    fn what_is_no_header_of_bytes_is_refused_and_shown() {
        for text in [
            "{'descr': '|u1', 'fortran_order': False}",
            "{'descr': '|u1', 'shape': (2, 50, 30)}",
            "{'fortran_order': False, 'shape': (2, 50, 30)}",
            "{'descr': '|u1', 'fortran_order': False, 'shape': (2, 50, 30), 'more': 1}",
            "{'descr': '|u1', 'fortran_order': 0, 'shape': (2, 50, 30)}",
            "{'descr': '|u1', 'fortran_order': False, 'shape': (-2, 50, 30)}",
            "{'descr': '|u1', 'fortran_order': False, 'shape': (2,, 50, 30)}",
            "{'descr': '|u1', 'fortran_order': False, 'shape': (99999999999999999999, 50, 30)}",
            "{'descr': [('a', '|u1')], 'fortran_order': False, 'shape': (2, 50, 30)}",
            "'descr': '|u1', 'fortran_order': False, 'shape': (2, 50, 30)",
        ] {
            let expected =
                format!("geis.npy: expected the header of a .npy file of bytes, found {text:?}");
            assert_eq!(refusal(text, 3000), expected);
        }
        let overflow =
            "{'descr': '|u1', 'fortran_order': False, 'shape': (9999999999, 9999999999, 9)}";
        assert!(refusal(overflow, 10).contains("overflow computing length from shape"));
        let big = "{'descr': '>u2', 'fortran_order': False, 'shape': (1, 50, 30), }";
        assert!(refusal(big, 3000).contains("expected bytes from 0 to 255 ('|u1'), found '>u2'"));
    }

    #[test]
    fn no_byte_of_a_header_and_no_length_leads_beyond_the_file() {
        let whole = [npy_header("|u1", &[1, 50, 30]), vec![7; 1500]].concat();
        let located = |bytes: &[u8]| {
            let found = template_bytes(Path::new("g"), bytes, Template::Gei, None);
            if let Ok((first, size, count)) = found {
                assert_eq!(first + count * size.pixels(), bytes.len());
            }
        };
        for at in 0..NPY_HEADER {
            for byte in 0..=u8::MAX {
                let mut bytes = whole.clone();
                bytes[at] = byte;
                located(&bytes);
            }
        }
        for length in 0..whole.len() {
            let found = template_bytes(Path::new("g"), &whole[..length], Template::Gei, None);
            assert!(found.is_err(), "{length}");
        }
    }

    #[test]
    fn a_header_that_claims_more_than_the_file_or_nests_is_refused() {
        let huge = "{'descr': '|u1', 'fortran_order': False, 'shape': (999999999999, 50, 30), }";
        assert!(refusal(huge, 10).contains("too early"));
        assert!(refusal(&"(".repeat(60_000), 10).contains("without nesting"));
        let mut version_2 = b"\x93NUMPY\x02\x00\xff\xff\xff\xff".to_vec();
        version_2.extend([b'('; 100]);
        assert!(template_bytes(Path::new("g"), &version_2, Template::Gei, None).is_err());
    }
}
