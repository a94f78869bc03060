//! Trees with one template for each view, as a picture: the GEIs that other tools leave.

use super::IndexRow;
use super::tree::{TEMPLATE, Tree, TreeLayout, decode};
use crate::error::{Error, Result};
use edgegait_core::silhouette::Size;
use std::path::{Path, PathBuf};

/// The GEIs of a tree `<person>/<take>/<view>/gei.png`, listed but not read.
pub(super) struct GeiPictures {
    tree: Tree,
}

impl GeiPictures {
    /// Lists the GEIs of a tree, if its first view holds one and no frames.
    pub(super) fn find(root: &Path) -> Option<Self> {
        let is_gei = |view: &PathBuf| {
            let entries = std::fs::read_dir(view).into_iter().flatten().flatten();
            let mut names = entries.map(|entry| entry.file_name());
            names.next().is_some_and(|name| name == TEMPLATE) && names.next().is_none()
        };
        // Trees of frames are large: their folders are not listed here.
        if !Tree::some_views(root).iter().any(is_gei) {
            return None;
        }
        let tree = Tree::open(root, &TreeLayout::default()).ok()?;
        is_gei(&tree.folder(0)).then_some(Self { tree })
    }

    /// Returns the paths of all GEIs, by person, take and view.
    pub(super) fn paths(&self) -> impl Iterator<Item = PathBuf> {
        let all = 0..self.tree.sequences().len();
        all.map(|index| self.tree.folder(index).join(TEMPLATE))
    }

    /// Reads all GEIs: their rows of an index, their size, and the pixels of one after another.
    ///
    /// # Errors
    /// If a view has no GEI, one cannot be read, or sizes differ or are none that can be drawn.
    pub(super) fn read(&self) -> Result<(Vec<IndexRow>, Size, Vec<u8>)> {
        let (mut index, mut first, mut all) = (Vec::new(), None, Vec::new());
        for (path, sequence) in self.paths().zip(self.tree.sequences()) {
            let (pixels, columns) = decode(&path)?;
            let found = (pixels.len() / columns, columns);
            let mut sizes = Size::ALL.into_iter();
            let size = sizes.find(|size| {
                let expected = (size.rows(), size.columns());
                expected == found && first.is_none_or(|first| first == *size)
            });
            let Some(size) = size else {
                let expected = first.map_or("50x30, 64x44 or 64x64".to_owned(), |size| {
                    format!("{size} as before")
                });
                let (rows, columns) = found;
                let problem = format!("expected a GEI of {expected}, found {rows}x{columns}");
                return Err(Error::input(path, problem));
            };
            first = Some(size);
            all.extend(pixels);
            let (azimuth_deg, elevation_deg) = sequence.angles_deg.unwrap_or_default();
            index.push(IndexRow {
                subject: sequence.subject.clone(),
                walk: sequence.take.clone(),
                azimuth_deg,
                elevation_deg,
                frames: 1,
                ..IndexRow::default()
            });
        }
        Ok((index, first.unwrap_or_default(), all))
    }
}
