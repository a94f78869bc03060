//! Arrays that grow: .npy files whose first dimension is known only at the end.

use std::fs::File;
use std::io::{BufWriter, Seek as _, SeekFrom, Write as _};
use std::path::Path;

use super::contents::Array;
use super::npy::{NPY_HEADER, npy_header};
use crate::error::{Error, Result};

/// A .npy file that is being written.
#[derive(Debug)]
pub(super) struct GrowingArray {
    pub array: Array,
    file: BufWriter<File>,
}

impl GrowingArray {
    /// Opens the array's file in a folder to append after `known` bytes, or creates it.
    pub(super) fn open(folder: &Path, array: Array, known: Option<u64>) -> Result<Self> {
        let path = folder.join(array.file());
        let mut file = open(&path, known)?;
        if known.unwrap_or(0) == 0 {
            let room = [0; NPY_HEADER];
            file.write_all(&room)
                .map_err(|source| Error::io(path, source))?;
        }
        Ok(Self { array, file })
    }

    /// Appends the bytes of numbers.
    pub(super) fn push(&mut self, bytes: &[u8]) -> std::io::Result<()> {
        self.file.write_all(bytes)
    }

    /// Flushes the file and returns its length, bytes.
    pub(super) fn flush(&mut self) -> std::io::Result<u64> {
        self.file.flush()?;
        self.file.stream_position()
    }

    /// Writes the header, now that the first dimension is known.
    pub(super) fn close(mut self) -> std::io::Result<()> {
        let count = (self.flush()? - NPY_HEADER as u64) / self.array.bytes() as u64;
        let count = usize::try_from(count).map_err(std::io::Error::other)?;
        let shape = [&[count][..], &self.array.sides].concat();
        self.file.seek(SeekFrom::Start(0))?;
        self.file.write_all(&npy_header(self.array.descr, &shape))?;
        self.file.flush()
    }
}

/// Opens a file to append after `known` bytes, or creates it if there are none.
fn open(path: &Path, known: Option<u64>) -> Result<BufWriter<File>> {
    let opened = match known {
        None => File::create(path),
        Some(bytes) => File::options().write(true).open(path).and_then(|mut file| {
            file.seek(SeekFrom::Start(bytes))?;
            Ok(file)
        }),
    };
    let file = opened.map_err(|source| Error::io(path, source))?;
    Ok(BufWriter::with_capacity(1 << 16, file))
}

/// A CSV table that is being written.
#[derive(Debug)]
pub(super) struct GrowingTable {
    name: &'static str,
    file: BufWriter<File>,
}

impl GrowingTable {
    /// Opens a table in a folder to append after `known` bytes, or creates it with these columns.
    pub(super) fn open(
        folder: &Path,
        name: &'static str,
        columns: &[&str],
        known: Option<u64>,
    ) -> Result<Self> {
        let file = open(&folder.join(name), known)?;
        let mut table = Self { name, file };
        if known.unwrap_or(0) == 0 {
            table.push(&columns)?;
        }
        Ok(table)
    }

    /// Returns the name of the table's file.
    pub(super) const fn name(&self) -> &'static str {
        self.name
    }

    /// Appends a row.
    pub(super) fn push(&mut self, row: &impl serde::Serialize) -> Result<()> {
        let failed = |error: String| Error::input(self.name, error);
        let mut builder = csv::WriterBuilder::new();
        let mut line = builder
            .has_headers(false)
            .buffer_capacity(1 << 8)
            .from_writer(Vec::new());
        line.serialize(row)
            .map_err(|error| failed(error.to_string()))?;
        let line = line.into_inner();
        self.append(&line.map_err(|error| failed(error.to_string()))?)
    }

    /// Appends rows that are already encoded.
    pub(super) fn append(&mut self, bytes: &[u8]) -> Result<()> {
        let written = self.file.write_all(bytes);
        written.map_err(|source| Error::io(self.name, source))
    }

    /// Flushes the file and returns its length, bytes.
    pub(super) fn flush(&mut self) -> std::io::Result<u64> {
        self.file.flush()?;
        self.file.stream_position()
    }
}
