//! Arrays of bytes in NumPy's format.

use std::fs;
use std::path::Path;

/// Returns the shape and the bytes of an npy file of `u8`, read as the format's description (NEP 1)
/// says.
pub fn npy(path: impl AsRef<Path>) -> (String, Vec<u8>) {
    let bytes = fs::read(path).expect("a file");
    assert_eq!(&bytes[..8], b"\x93NUMPY\x01\x00");
    let end = 10 + usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
    let header = String::from_utf8_lossy(&bytes[10..end]);
    assert!(header.contains("'descr': '|u1'"), "{header}");
    assert!(header.contains("'fortran_order': False"), "{header}");
    let shape = header.split_once("'shape': (").expect("a shape").1;
    let shape = shape.split_once(')').expect("a shape").0;
    (
        shape.trim_end_matches([',', ' ']).into(),
        bytes[end..].to_vec(),
    )
}
