//! A file of a shard, read once and checked against its hash.

use super::npy::NPY_HEADER;
use super::{MANIFEST, Manifest};
use crate::error::{Error, Result};
use crate::files::hex;
use sha2::{Digest as _, Sha256};
use std::fs::File;
use std::io::{BufRead as _, BufReader, Read as _};
use std::path::{Path, PathBuf};

/// A file of a shard that is read once and checked against the SHA-256 in the manifest.
pub(super) struct CheckedFile {
    path: PathBuf,
    file: BufReader<File>,
    digest: Sha256,
    expected: Option<String>,
}

impl CheckedFile {
    pub(super) fn open(shard: &Path, name: &str, manifest: &Manifest) -> Result<Self> {
        let path = shard.join(name);
        let file = crate::files::open(&path)?;
        let known = manifest.files.iter().find(|file| file.path == name);
        Ok(Self {
            path,
            file: BufReader::with_capacity(1 << 16, file),
            digest: Sha256::new(),
            expected: known.map(|file| file.sha256.clone()),
        })
    }

    /// Skips the header of an array, which EdgeGait wrote.
    pub(super) fn skip_header(&mut self) -> Result<()> {
        let mut header = [0; NPY_HEADER];
        let read = self.file.read_exact(&mut header);
        read.map_err(|source| Error::io(&self.path, source))?;
        self.digest.update(header);
        Ok(())
    }

    /// Skips the first line.
    pub(super) fn skip_line(&mut self) -> Result<()> {
        let mut line = Vec::new();
        let read = self.file.read_until(b'\n', &mut line);
        read.map_err(|source| Error::io(&self.path, source))?;
        self.digest.update(line);
        Ok(())
    }

    /// Passes the rest to `take`, piece by piece.
    ///
    /// # Errors
    /// If the file does not have the SHA-256 in the manifest; `take` has received it by then.
    pub(super) fn copy(mut self, mut take: impl FnMut(&[u8]) -> Result<()>) -> Result<()> {
        let mut piece = vec![0; 1 << 16];
        loop {
            let read = self.file.read(&mut piece);
            let read = read.map_err(|source| Error::io(&self.path, source))?;
            if read == 0 {
                break;
            }
            self.digest.update(&piece[..read]);
            take(&piece[..read])?;
        }
        let found = hex(&self.digest.finalize());
        match self.expected {
            Some(expected) if expected != found => Err(Error::input(
                self.path,
                format!(
                    "expected SHA-256 {expected}, as {MANIFEST} says, found {found} (make the shard again)"
                ),
            )),
            _ => Ok(()),
        }
    }

    /// Reads the whole rest of the file.
    pub(super) fn whole(self) -> Result<Vec<u8>> {
        let mut all = Vec::new();
        self.copy(|bytes| {
            all.extend_from_slice(bytes);
            Ok(())
        })?;
        Ok(all)
    }
}
