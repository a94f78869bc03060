//! Reading NumPy's .npz archives, which contain Blender's results for skinned bodies.

use std::collections::HashMap;
use std::io::Read as _;
use std::path::Path;

use flate2::read::DeflateDecoder;
use ndarray::ArrayD;

/// The members of a zip archive, by name without `.npy`, unpacked.
pub struct Npz(HashMap<String, Vec<u8>>);

impl Npz {
    pub fn read(path: &Path) -> Self {
        let bytes = std::fs::read(path).unwrap();
        let u16_at = |at: usize| usize::from(u16::from_le_bytes([bytes[at], bytes[at + 1]]));
        let u32_at = |at: usize| u16_at(at) + (u16_at(at + 2) << 16);
        // End of central directory, without a comment: 22 bytes.
        let end = bytes.len() - 22;
        assert_eq!(&bytes[end..end + 4], b"PK\x05\x06");
        let mut at = u32_at(end + 16);
        let mut members = HashMap::new();
        for _ in 0..u16_at(end + 10) {
            assert_eq!(u16_at(at + 10), 8, "expected deflated members");
            let (packed, size) = (u32_at(at + 20), u32_at(at + 24));
            let name = &bytes[at + 46..at + 46 + u16_at(at + 28)];
            let name = std::str::from_utf8(name).unwrap().trim_end_matches(".npy");
            let local = u32_at(at + 42);
            let data = local + 30 + u16_at(local + 26) + u16_at(local + 28);
            let mut member = Vec::with_capacity(size);
            DeflateDecoder::new(&bytes[data..data + packed])
                .read_to_end(&mut member)
                .unwrap();
            assert_eq!(member.len(), size);
            members.insert(name.to_owned(), member);
            at += 46 + u16_at(at + 28) + u16_at(at + 30) + u16_at(at + 32);
        }
        Self(members)
    }

    /// An array of numbers, such as `array("heads", f32::from_le_bytes)`.
    pub fn array<T, const N: usize>(&self, name: &str, number: fn([u8; N]) -> T) -> ArrayD<T> {
        let (header, data) = self.parts(name);
        let kind = &std::any::type_name::<T>()[..1];
        assert!(
            header.contains(&format!("{kind}{N}', 'fortran_order': False")),
            "{header}"
        );
        let (_, shape) = header.split_once("'shape': (").unwrap();
        let (shape, _) = shape.split_once(')').unwrap();
        let sides = shape.trim_end_matches(',').split(", ");
        let shape: Vec<usize> = sides.map(|side| side.parse().unwrap()).collect();
        let (numbers, rest) = data.as_chunks();
        assert!(rest.is_empty(), "{name}");
        ArrayD::from_shape_vec(shape, numbers.iter().copied().map(number).collect()).unwrap()
    }

    /// A one-dimensional array of fixed-width UTF-32 strings.
    pub fn strings(&self, name: &str) -> Vec<String> {
        let (header, data) = self.parts(name);
        let width = header.split("<U").nth(1).unwrap();
        let width: usize = width.split('\'').next().unwrap().parse().unwrap();
        let characters: Vec<char> = data
            .chunks_exact(4)
            .map(|c| char::from_u32(u32::from_le_bytes([c[0], c[1], c[2], c[3]])).unwrap())
            .collect();
        let words = characters.chunks_exact(width);
        words
            .map(|word| word.iter().take_while(|c| **c != '\0').collect())
            .collect()
    }

    /// The header and the data of an array.
    fn parts(&self, name: &str) -> (String, &[u8]) {
        let bytes = &self.0[name];
        assert_eq!(&bytes[..8], b"\x93NUMPY\x01\x00");
        let start = 10 + usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
        (
            String::from_utf8_lossy(&bytes[10..start]).into(),
            &bytes[start..],
        )
    }
}
