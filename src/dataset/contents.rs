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

    /// Returns the number of bytes of a row with this number of frames.
    pub(super) fn bytes_of(&self, frames: u32) -> usize {
        let times = if self.is_of_frames { frames } else { 1 };
        self.bytes() * times as usize
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn silhouettes_are_bytes_and_joints_floats_of_three_or_two_axes() {
        let contents = Contents {
            templates: vec![Template::Silhouettes],
            size: Size::S64x44,
            joints: true,
        };
        let arrays = contents.arrays();
        let [silhouettes, joints, keypoints] = &arrays[..] else {
            panic!("three arrays");
        };
        assert_eq!(
            (silhouettes.descr, &silhouettes.sides[..]),
            ("|u1", &[64, 44][..])
        );
        assert_eq!((joints.descr, &joints.sides[..]), ("<f4", &[19, 3][..]));
        assert_eq!((joints.bytes(), keypoints.bytes()), (228, 152));
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
