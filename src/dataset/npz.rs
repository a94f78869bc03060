//! A dataset as one `.npz` file: its arrays, and the columns of the index as arrays.
//!
//! Nothing is compressed and no time is written, so the same dataset gives the same bytes.

use std::fs::File;
use std::io::{BufReader, BufWriter, Read as _, Write as _};
use std::path::Path;

use super::index::RECORDED_COLUMNS;
use super::manifest::parse_manifest;
use super::npy::npy_header;
use super::{INDEX, MANIFEST, Manifest};
use crate::error::{Error, Result};
use zip::write::{SimpleFileOptions, ZipWriter};
use zip::{CompressionMethod, ZipArchive};

/// The name of the file while it is written.
pub(super) const FILE: &str = "whole.npz";

/// Returns NumPy's type of a column of numbers by the column's name; none for text.
fn descr(column: &str) -> Option<&'static str> {
    match column {
        "cycle" | "variation" | "frames" | "first_frame" | "last_frame" => Some("<u4"),
        "seed" => Some("<u8"),
        "speed_kmh" | "azimuth_deg" | "elevation_deg" => Some("<f8"),
        _ => None,
    }
}

/// Writes the files of these names and the manifest into one archive. Columns are read one at a
/// time, so that memory does not grow with the rows.
pub(super) fn write(made: &Path, names: &[String]) -> Result<()> {
    let path = made.join(FILE);
    let io = |source| Error::io(&path, source);
    let failed = |error: zip::result::ZipError| Error::input(&path, error.to_string());
    let file = File::create(&path).map_err(io)?;
    let mut archive = ZipWriter::new(BufWriter::with_capacity(1 << 16, file));
    let options = SimpleFileOptions::default()
        .compression_method(CompressionMethod::Stored)
        .last_modified_time(zip::DateTime::default())
        .large_file(true);
    let whole = [MANIFEST.to_owned()];
    for name in names.iter().filter(|name| *name != INDEX).chain(&whole) {
        archive.start_file(name.as_str(), options).map_err(failed)?;
        let mut from = crate::files::open(made.join(name))?;
        std::io::copy(&mut from, &mut archive).map_err(io)?;
    }
    let index = made.join(INDEX);
    for (at, column) in columns(&index)?.into_iter().enumerate() {
        archive
            .start_file(format!("{column}.npy"), options)
            .map_err(failed)?;
        let (mut rows, mut width) = (0, 1);
        each(&index, at, |text| {
            rows += 1;
            width = width.max(text.chars().count());
            Ok(())
        })?;
        let descr = descr(column).map_or_else(|| format!("<U{width}"), str::to_owned);
        archive
            .write_all(&npy_header(&descr, &[rows]))
            .map_err(io)?;
        each(&index, at, |text| {
            let bytes = bytes(&descr, text, width);
            let bytes = bytes.ok_or_else(|| Error::input(&index, format!("{column}: {text:?}")))?;
            archive.write_all(&bytes).map_err(io)
        })?;
    }
    let file = archive.finish().map_err(failed)?;
    file.into_inner().map_err(|error| io(error.into_error()))?;
    Ok(())
}

/// The maximum number of bytes in a manifest. A usual one has a few thousand.
const MOST_MANIFEST: u64 = 1 << 24;

/// Reads the manifest in a `.npz` file.
///
/// # Errors
/// If the file is not a dataset or cannot be read.
pub(super) fn manifest(path: &Path) -> Result<Manifest> {
    let refuse = |error: zip::result::ZipError| {
        Error::input(
            path,
            format!("expected a dataset as .npz, with a {MANIFEST}: {error}"),
        )
    };
    let file = crate::files::open(path)?;
    let mut archive = ZipArchive::new(BufReader::new(file)).map_err(refuse)?;
    let entry = archive.by_name(MANIFEST).map_err(refuse)?;
    let mut text = Vec::new();
    let read = entry.take(MOST_MANIFEST).read_to_end(&mut text);
    read.map_err(|error| Error::io(path, error))?;
    parse_manifest(path, &text)
}

/// Returns the columns of an index.
fn columns(index: &Path) -> Result<Vec<&'static str>> {
    let mut reader = csv::Reader::from_reader(BufReader::new(crate::files::open(index)?));
    let header = reader.headers();
    let header = header.map_err(|error| Error::input(index, error.to_string()))?;
    Ok(RECORDED_COLUMNS.into_iter().take(header.len()).collect())
}

/// Calls `take` with the text of each row in a column.
fn each(index: &Path, column: usize, mut take: impl FnMut(&str) -> Result<()>) -> Result<()> {
    let file = crate::files::open(index)?;
    let mut reader = csv::Reader::from_reader(BufReader::new(file));
    let mut record = csv::StringRecord::new();
    let refuse = |error: csv::Error| Error::input(index, error.to_string());
    while reader.read_record(&mut record).map_err(refuse)? {
        take(record.get(column).unwrap_or_default())?;
    }
    Ok(())
}

/// Encodes a number or a text in NumPy's format; text in UCS-4, padded with zeros.
fn bytes(descr: &str, text: &str, width: usize) -> Option<Vec<u8>> {
    Some(match descr {
        "<u4" => text.parse::<u32>().ok()?.to_le_bytes().to_vec(),
        "<u8" => text.parse::<u64>().ok()?.to_le_bytes().to_vec(),
        "<f8" => text.parse::<f64>().ok()?.to_le_bytes().to_vec(),
        _ => {
            let letters = text.chars().map(u32::from);
            let filled = letters.chain(std::iter::repeat(0)).take(width);
            filled.flat_map(u32::to_le_bytes).collect()
        }
    })
}
