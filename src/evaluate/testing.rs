//! Shared test data: distance matrix E1, with metrics computed by hand, and tiny datasets of GEIs.

use crate::dataset::{
    Contents, DatasetFormat, DatasetRun, DatasetWriter, Existing, IndexRow, Item,
};
use crate::draw::template::Template;
use crate::error::Result;
use crate::files::ResultHeader;
use edgegait_core::budget::PIXELS;
use edgegait_core::silhouette::Size;
use std::path::Path;

/// Distances `[probe][gallery]`.
pub(crate) const E1: [[f64; 6]; 3] = [
    [0.10, 0.40, 0.35, 0.60, 0.70, 0.55],
    [0.50, 0.30, 0.20, 0.45, 0.65, 0.80],
    [0.90, 0.75, 0.60, 0.50, 0.25, 0.30],
];
/// The person of each probe.
pub(crate) const E1_PROBES: [usize; 3] = [1, 2, 3];
/// The person of each gallery entry.
pub(crate) const E1_GALLERY: [usize; 6] = [1, 1, 2, 2, 3, 3];

/// A GEI: (person, take, viewpoint, first two pixels).
pub(crate) type Gei<'a> = (&'a str, &'a str, (f64, f64), (u8, u8));

/// Writes a dataset of GEIs to a new folder; their other pixels are 0.
pub(crate) fn write_geis(dir: &Path, geis: &[Gei<'_>]) -> Result<()> {
    let run = DatasetRun {
        header: ResultHeader::new("sweep", 1),
        contents: Contents::one(Template::Gei, Size::S50x30),
        format: DatasetFormat::Folder,
        units: 0,
        shard: None,
        is_recorded: false,
    };
    let mut writer = DatasetWriter::begin(dir, run, Existing::ReplaceOwn, false)?;
    for &(subject, walk, (azimuth_deg, elevation_deg), (first, second)) in geis {
        let mut pixels = vec![0; PIXELS];
        pixels[..2].copy_from_slice(&[first, second]);
        let row = IndexRow {
            subject: subject.into(),
            walk: walk.into(),
            cycle: 0,
            variation: 0,
            speed_kmh: 5.0,
            azimuth_deg,
            elevation_deg,
            condition: String::new(),
            alternative: String::new(),
            frames: 32,
            seed: 1,
            ..IndexRow::default()
        };
        writer.push(Item {
            row: &row,
            take: walk,
            templates: &[pixels],
            joints: [&[], &[]],
        })?;
    }
    writer.finish()?;
    Ok(())
}
