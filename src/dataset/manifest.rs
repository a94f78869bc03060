//! The manifest of a dataset, read.

use super::{DatasetFormat, Manifest};
use crate::draw::template::Template;
use crate::error::{Error, Result};
use crate::files::{ResultHeader, SCHEMA};
use edgegait_core::silhouette::Size;
use std::path::Path;

impl Manifest {
    /// Returns the manifest that stands for a folder without one.
    pub(super) fn plain() -> Self {
        Self {
            header: ResultHeader::new("", 0),
            template: Template::Gei,
            besides: Vec::new(),
            joints: false,
            format: DatasetFormat::Folder,
            shard: None,
            geis: 0,
            files: Vec::new(),
        }
    }

    /// Returns the size of silhouettes that the settings state, if it is one that can be drawn.
    pub(super) fn size(&self) -> Option<Size> {
        let stated = self.header.settings.get("size")?;
        Size::ALL.into_iter().find(|size| stated == size.name())
    }
}

pub(super) fn read_manifest(path: &Path) -> Result<Manifest> {
    let text = crate::files::read(path)?;
    parse_manifest(path, &text)
}

/// Parses a manifest from JSON; `path` is for messages.
pub(super) fn parse_manifest(path: &Path, text: &[u8]) -> Result<Manifest> {
    let manifest = serde_json::from_slice(text);
    let manifest: Manifest = manifest.map_err(|error| Error::json(path, &error))?;
    if manifest.header.schema != SCHEMA {
        return Err(Error::input(
            path,
            format!(
                "expected schema {SCHEMA}, found {} (was it made by another version?)",
                manifest.header.schema
            ),
        ));
    }
    Ok(manifest)
}
