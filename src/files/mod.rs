//! Safe reading and writing: files that are whole or not there, their SHA-256, results that are
//! kept, what other files name, the header of every result, numbered files, named or own TOML files, and text tables.

pub mod cache;
mod header;
mod locked_folder;
#[cfg(feature = "import")]
pub(crate) mod named_below;
pub(crate) mod named_or_file;
mod numbered;
mod picture;
mod regular;
mod staging;
pub(crate) mod text_table;

pub use header::{InputFile, ResultHeader, SCHEMA};
pub(crate) use locked_folder::{LOCK, LockedFolder, refuse_link, remove_locked};
pub(crate) use numbered::{doubts, numbered_files};
pub(crate) use picture::picture_limits;
pub(crate) use regular::{open, read, read_to_string};
pub use staging::{Staging, remove_unfinished};
pub(crate) use staging::{folder_of, together};

use crate::error::{Error, Result};
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder as _};
use sha2::{Digest, Sha256};
use std::fs::{self, File};
use std::io::{BufWriter, Read, Write};
use std::path::Path;

/// Returns the SHA-256 of a file's bytes as 64 lower-case hexadecimal digits. Reads the file
/// in pieces of 64 KiB.
///
/// # Errors
///
/// If the file cannot be read.
pub fn sha256_of_file(path: impl AsRef<Path>) -> Result<String> {
    let path = path.as_ref();
    let io = |source| Error::io(path, source);
    let mut file = open(path)?;
    let mut hasher = Sha256::new();
    let mut piece = vec![0; 1 << 16];
    loop {
        match file.read(&mut piece).map_err(io)? {
            0 => return Ok(hex(&hasher.finalize())),
            read => hasher.update(&piece[..read]),
        }
    }
}

/// Returns the SHA-256 of bytes as 64 lower-case hexadecimal digits.
#[must_use]
pub fn sha256_of_bytes(bytes: &[u8]) -> String {
    hex(&Sha256::digest(bytes))
}

/// Writes bytes into a file as [`write_atomically`] does.
///
/// # Errors
///
/// If the file cannot be written; then nothing has changed.
pub fn write_bytes(path: impl AsRef<Path>, bytes: &[u8]) -> Result<()> {
    let path = path.as_ref();
    write_atomically(path, |file| {
        file.write_all(bytes)
            .map_err(|error| Error::io(path, error))
    })
}

/// Writes a file through `write`, and gives it its name only when it is complete. A former file of
/// that name stays until then. A link stays a link. A pipe or device (such as `/dev/null`) is
/// written into, not replaced. The folder of the file is made if it is missing.
///
/// # Errors
///
/// The errors of `write` and of the system; then nothing has changed.
pub fn write_atomically(
    path: impl AsRef<Path>,
    write: impl FnOnce(&mut BufWriter<File>) -> Result<()>,
) -> Result<()> {
    let path = path.as_ref();
    let io = |source| Error::io(path, source);
    let target = fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf());
    if fs::metadata(&target).is_ok_and(|found| !found.is_file() && !found.is_dir()) {
        let mut file = BufWriter::new(File::create(&target).map_err(io)?);
        write(&mut file)?;
        return file.flush().map_err(io);
    }
    let folder = folder_of(&target);
    fs::create_dir_all(&folder).map_err(|source| Error::io(&folder, source))?;
    let staging = Staging::beside(&target)?;
    let unfinished = staging.path().join("unfinished");
    let mut file = BufWriter::new(File::create(&unfinished).map_err(io)?);
    write(&mut file)?;
    file.flush().map_err(io)?;
    drop(file);
    together(|| fs::rename(&unfinished, &target)).map_err(io)
}

/// Encodes pixels, row by row, as a grey PNG. The same pixels always give the same bytes.
///
/// # Errors
/// Never for pixels in whole rows.
pub fn grey_png(pixels: &[u8], columns: usize) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    let encoder =
        PngEncoder::new_with_quality(&mut bytes, CompressionType::Fast, FilterType::NoFilter);
    let side = |side: usize| u32::try_from(side).unwrap_or(u32::MAX);
    let rows = pixels.len().checked_div(columns).unwrap_or(0);
    encoder
        .write_image(pixels, side(columns), side(rows), ExtendedColorType::L8)
        .map_err(|error| Error::Failed(error.to_string()))?;
    Ok(bytes)
}

/// Formats bytes as lower-case hexadecimal digits.
#[must_use]
pub fn hex(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 16] = b"0123456789abcdef";
    bytes
        .iter()
        .flat_map(|byte| [byte >> 4, byte & 15])
        .map(|digit| char::from(DIGITS[usize::from(digit)]))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// FIPS 180-2, appendix B.1 and B.3.
    #[test]
    fn a_file_has_the_published_sha256() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("abc");
        fs::write(&path, "abc").unwrap();
        let abc = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
        assert_eq!(sha256_of_file(&path).unwrap(), abc);
        assert_eq!(sha256_of_bytes(b"abc"), abc);

        fs::write(&path, vec![b'a'; 1_000_000]).unwrap();
        assert_eq!(
            sha256_of_file(&path).unwrap(),
            "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0"
        );
    }

    #[test]
    fn a_write_that_fails_leaves_the_former_file_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("x.npy");
        fs::write(&path, "former").unwrap();
        let failed = write_atomically(&path, |file| {
            file.write_all(b"half").map_err(|e| Error::io("x", e))?;
            Err(Error::Missing("ideas"))
        });
        assert_eq!(
            failed.unwrap_err().to_string(),
            "expected ideas, found none"
        );
        assert_eq!(fs::read(&path).unwrap(), b"former");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);

        write_atomically(&path, |file| {
            file.write_all(b"whole").map_err(|e| Error::io("x", e))
        })
        .unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"whole");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn a_path_without_a_name_is_refused() {
        let refused = write_atomically("/", |_| Ok(())).unwrap_err();
        assert_eq!(
            refused.to_string(),
            "/: expected a path that ends in a name"
        );
    }
}
