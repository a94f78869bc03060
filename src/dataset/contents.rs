//! The contents of each row of a dataset's index, and the arrays that hold them.

use crate::draw::template::{Template, TemplateShape};
use edgegait_core::silhouette::Size;
use edgegait_core::skeleton::JOINTS;
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// The file format of a dataset.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum DatasetFormat {
    /// A folder of arrays and tables.
    #[default]
    Folder,
    /// One `.npz` file of the arrays and the index's columns as arrays.
    Npz,
    /// Silhouettes in OpenGait's layout: a pickled array for each take and viewpoint.
    Opengait,
    /// Silhouettes in CASIA-B's layout: a picture for each frame.
    CasiaB,
}

impl DatasetFormat {
    /// Returns the name in flags and manifests.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Folder => "folder",
            Self::Npz => "npz",
            Self::Opengait => "opengait",
            Self::CasiaB => "casia-b",
        }
    }

    /// Returns whether the dataset is a tree of folders of people, takes and viewpoints.
    #[must_use]
    pub const fn is_tree(self) -> bool {
        matches!(self, Self::Opengait | Self::CasiaB)
    }
}

/// The number of one shard of a dataset: a contiguous part of the index.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Shard {
    /// The number of the shard, from 1.
    pub number: usize,
    /// The number of all shards.
    pub of: usize,
}

impl Shard {
    /// Returns the shard's part of a number of units of work.
    #[must_use]
    pub fn of_units(self, units: usize) -> Range<usize> {
        let bound = |number: usize| number.saturating_mul(units) / self.of;
        bound(self.number - 1)..bound(self.number)
    }
}

/// The contents of each row of a dataset.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Contents {
    /// The templates, at least one and each once.
    pub templates: Vec<Template>,
    /// The size of the silhouettes that the templates are made of.
    pub size: Size,
    /// Whether the dataset holds joints.
    pub joints: bool,
}

/// The name and shape of one array of a dataset.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Array {
    /// The name of the file without `.npy`.
    pub name: String,
    /// The type of the numbers in NumPy's notation.
    pub descr: &'static str,
    /// The sizes of all dimensions except the first.
    pub sides: Vec<usize>,
    /// Whether the first dimension counts the frames of all rows instead of rows.
    pub is_of_frames: bool,
}

impl Array {
    /// Returns whether the numbers are f32 instead of bytes.
    #[must_use]
    pub fn is_float(&self) -> bool {
        self.descr == FLOATS
    }

    /// Returns the number of bytes of a row or a frame.
    #[must_use]
    pub fn bytes(&self) -> usize {
        let number = if self.descr == BYTES { 1 } else { 4 };
        self.sides.iter().product::<usize>() * number
    }

    /// Returns the name of the array's file.
    pub(super) fn file(&self) -> String {
        format!("{}.npy", self.name)
    }
}

const BYTES: &str = "|u1";
const FLOATS: &str = "<f4";

impl Contents {
    /// Returns contents with one template and no joints.
    #[must_use]
    pub fn one(template: Template, size: Size) -> Self {
        Self {
            templates: vec![template],
            size,
            joints: false,
        }
    }

    /// Returns the arrays, in the order of templates; joints come last.
    pub(super) fn arrays(&self) -> Vec<Array> {
        let of = |&template: &Template| Array {
            name: name_of(template).to_owned(),
            descr: BYTES,
            sides: match template.shape(self.size) {
                TemplateShape::Image {
                    planes,
                    rows,
                    columns,
                } => vec![planes * rows, columns],
                TemplateShape::Vector(numbers) => vec![numbers],
            },
            is_of_frames: template == Template::Silhouettes,
        };
        let joints = [("joints", 3), ("keypoints", 2)].map(|(name, axes)| Array {
            name: name.to_owned(),
            descr: FLOATS,
            sides: vec![JOINTS, axes],
            is_of_frames: true,
        });
        let templates = self.templates.iter().map(of);
        templates
            .chain(joints.into_iter().filter(|_| self.joints))
            .collect()
    }
}

/// Returns the name of a template's array.
pub(super) const fn name_of(template: Template) -> &'static str {
    match template {
        Template::Gei => "geis",
        other => other.name(),
    }
}

/// Returns the header of a .npy file, version 1.0 (NEP 1): 128 bytes for our shapes, the text
/// padded with spaces.
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

/// The length of [`npy_header`], bytes.
pub(super) const NPY_HEADER: usize = 128;

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray_npy::WriteNpyExt as _;

    #[test]
    fn headers_are_those_of_another_writer() {
        let size = Size::S64x44;
        let bytes = ndarray::Array3::<u8>::zeros((2, 64, 44));
        let mut expected = Vec::new();
        bytes.write_npy(&mut expected).expect("memory");
        let templates = vec![Template::Silhouettes];
        let contents = Contents {
            templates,
            size,
            joints: true,
        };
        let [silhouettes, joints, keypoints] = &contents.arrays()[..] else {
            panic!("three arrays");
        };
        let header =
            |array: &Array, count| npy_header(array.descr, &[&[count][..], &array.sides].concat());
        assert_eq!(header(silhouettes, 2), expected[..128]);
        let mut expected = Vec::new();
        let floats = ndarray::Array3::<f32>::zeros((12345, 19, 3));
        floats.write_npy(&mut expected).expect("memory");
        assert_eq!(header(joints, 12345), expected[..128]);
        assert_eq!((joints.bytes(), keypoints.bytes()), (228, 152));
        let mut expected = Vec::new();
        ndarray::Array1::<u8>::zeros(7)
            .write_npy(&mut expected)
            .expect("memory");
        assert_eq!(npy_header("|u1", &[7]), expected[..128]);
    }

    #[test]
    fn shards_are_parts_in_order() {
        for (units, of) in [(10, 3), (3, 3), (1000, 7), (5, 1)] {
            let mut next = 0;
            for number in 1..=of {
                let part = Shard { number, of }.of_units(units);
                assert_eq!(part.start, next);
                assert!(part.len().abs_diff(units / of) <= 1, "{part:?}");
                next = part.end;
            }
            assert_eq!(next, units);
        }
    }
}
