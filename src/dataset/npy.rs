//! NumPy's .npy files of bytes, written atomically and validated when read.
//!
//! Format: NEP 1 (Kern, 2007), <https://numpy.org/neps/nep-0001-npy-format.html>.

use std::path::Path;

use ndarray::{ArrayView, ArrayView2, ArrayView3, Dimension};
use ndarray_npy::{ViewNpyError, ViewNpyExt, WriteNpyError, WriteNpyExt};

use crate::draw::template::{Template, TemplateShape};
use crate::error::{Error, Result};
use crate::files::write_atomically;
use edgegait_core::silhouette::Size;

/// The longest header that is parsed, bytes. NumPy writes 128 bytes for our shapes. The
/// parser recurses, so a hostile header of many brackets must not reach it.
const MAX_HEADER: usize = 1024;

/// Writes bytes as a .npy file, whole or not at all: `[T, rows, columns]` for one
/// viewpoint's silhouettes, `[V, T, rows, columns]` for several.
///
/// # Errors
///
/// If the file cannot be written.
pub fn write_npy<D: Dimension>(path: impl AsRef<Path>, array: &ArrayView<'_, u8, D>) -> Result<()> {
    let path = path.as_ref();
    write_atomically(path, |file| {
        array.write_npy(file).map_err(|error| match error {
            WriteNpyError::Io(source) => Error::io(path, source),
            other => Error::input(path, other.to_string()),
        })
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
    if header_is_hostile(bytes) {
        return Err(refuse(format!(
            "expected a .npy header of at most {MAX_HEADER} bytes without nesting, found another"
        )));
    }
    if let TemplateShape::Vector(_) = template.shape(Size::default()) {
        let array = ArrayView2::<u8>::view_npy(bytes).map_err(|error| refuse(vectors(&error)))?;
        let (count, numbers) = array.dim();
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
        require_c_order(array.is_standard_layout()).map_err(refuse)?;
        return Ok((bytes.len() - count * numbers, size, count));
    }
    let array = ArrayView3::<u8>::view_npy(bytes).map_err(|error| refuse(problem(&error)))?;
    let (count, rows, columns) = array.dim();
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
    require_c_order(array.is_standard_layout()).map_err(refuse)?;
    Ok((bytes.len() - count * rows * columns, size, count))
}

fn require_c_order(is_standard: bool) -> std::result::Result<(), String> {
    if is_standard {
        return Ok(());
    }
    Err("expected C order, found Fortran order (save numpy.ascontiguousarray of it)".into())
}

fn vectors(error: &ViewNpyError) -> String {
    match error {
        ViewNpyError::WrongNdim(_, found) => {
            format!("expected 2 dimensions [N, numbers], found {found}")
        }
        other => problem(other),
    }
}

fn header_is_hostile(bytes: &[u8]) -> bool {
    // Magic (6 bytes), version (2), length (2 in version 1, 4 after), text.
    let length = match bytes {
        [_, _, _, _, _, _, 1, _, low, high, ..] => usize::from(u16::from_le_bytes([*low, *high])),
        [_, _, _, _, _, _, _, _, a, b, 0, 0, ..] => usize::from(u16::from_le_bytes([*a, *b])),
        _ => return bytes.len() >= 12,
    };
    let text = &bytes[8..bytes.len().min(12 + length)];
    let opened = text.iter().filter(|byte| b"([{".contains(byte)).count();
    length > MAX_HEADER || opened > 8
}

fn problem(error: &ViewNpyError) -> String {
    match error {
        ViewNpyError::WrongDescriptor(found) => {
            format!(
                "expected bytes from 0 to 255 ('|u1'), found {found} (for numbers from 0 to 1: (255 * x).round().astype('uint8'))"
            )
        }
        ViewNpyError::WrongNdim(_, found) => {
            format!("expected 3 dimensions [N, rows, columns], found {found}")
        }
        ViewNpyError::MissingBytes(missing) => {
            format!("the file ends {missing} bytes too early (was it copied whole?)")
        }
        ViewNpyError::ExtraBytes(extra) => {
            format!("expected the end of the file, found {extra} more bytes")
        }
        other => format!("expected a .npy file: {other}"),
    }
}

#[cfg(test)]
mod tests {
    use ndarray::{Array3, Array4};
    use ndarray_npy::read_npy;

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
    fn silhouettes_of_one_and_of_several_viewpoints_come_back() {
        let folder = tempfile::tempdir().unwrap();
        let one = Array3::from_shape_fn((2, 50, 30), |(t, r, c)| (t * 100 + r + c) as u8);
        let several = Array4::from_shape_fn((3, 2, 50, 30), |(v, t, r, c)| (v + t + r + c) as u8);
        let (path_one, path_several) = (folder.path().join("1.npy"), folder.path().join("3.npy"));
        write_npy(&path_one, &one.view()).unwrap();
        write_npy(&path_several, &several.view()).unwrap();
        assert_eq!(read_npy::<_, Array3<u8>>(&path_one).unwrap(), one);
        assert_eq!(read_npy::<_, Array4<u8>>(&path_several).unwrap(), several);
    }

    #[test]
    fn the_header_says_bytes_in_c_order_and_fills_128_bytes() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.npy");
        write_npy(&path, &Array3::<u8>::zeros((1, 50, 30)).view()).unwrap();
        let bytes = std::fs::read(&path).unwrap();
        assert_eq!(bytes.len(), 128 + 1500);
        let text = b"{'descr': '|u1', 'fortran_order': False, 'shape': (1, 50, 30)}";
        assert_eq!(&bytes[..10], b"\x93NUMPY\x01\x00\x76\x00");
        assert_eq!(&bytes[10..10 + text.len()], text);
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
    fn a_header_that_claims_more_than_the_file_or_nests_is_refused() {
        let huge = "{'descr': '|u1', 'fortran_order': False, 'shape': (999999999999, 50, 30), }";
        assert!(refusal(huge, 10).contains("too early"));
        assert!(refusal(&"(".repeat(60_000), 10).contains("without nesting"));
        let mut version_2 = b"\x93NUMPY\x02\x00\xff\xff\xff\xff".to_vec();
        version_2.extend([b'('; 100]);
        assert!(template_bytes(Path::new("g"), &version_2, Template::Gei, None).is_err());
    }
}
