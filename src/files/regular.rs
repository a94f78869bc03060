//! Opening and reading of regular files: a pipe, a socket or a device may never end, or wait for
//! ever when it is opened.

use crate::error::{Error, Result};
use std::fs::{self, File};
use std::io::{self, ErrorKind, Read as _};
use std::path::Path;

/// Opens a regular file. All files that the program did not make are opened here.
///
/// # Errors
/// If it is anything else, or cannot be opened.
pub(crate) fn open(path: impl AsRef<Path>) -> Result<File> {
    let path = path.as_ref();
    let opened = || {
        let kind = fs::metadata(path)?.file_type();
        if kind.is_file() {
            return File::open(path);
        }
        let problem = format!("expected a regular file, found {}", name_of(kind));
        Err(io::Error::new(ErrorKind::InvalidData, problem))
    };
    opened().map_err(|error| Error::io(path, error))
}

/// Reads a whole regular file.
///
/// # Errors
/// As [`open`], and if it cannot be read.
pub(crate) fn read(path: impl AsRef<Path>) -> Result<Vec<u8>> {
    let path = path.as_ref();
    let mut bytes = Vec::new();
    let read = open(path)?.read_to_end(&mut bytes);
    read.map_err(|error| Error::io(path, error))?;
    Ok(bytes)
}

/// Reads a whole regular file of text.
///
/// # Errors
/// As [`read`], and if it is not UTF-8.
pub(crate) fn read_to_string(path: impl AsRef<Path>) -> Result<String> {
    let path = path.as_ref();
    let mut text = String::new();
    let read = open(path)?.read_to_string(&mut text);
    read.map_err(|error| Error::io(path, error))?;
    Ok(text)
}

/// Returns what a file is that is not a regular one.
fn name_of(kind: fs::FileType) -> &'static str {
    #[cfg(unix)]
    {
        use std::os::unix::fs::FileTypeExt as _;
        if kind.is_fifo() {
            return "a pipe";
        }
        if kind.is_socket() {
            return "a socket";
        }
        if kind.is_char_device() || kind.is_block_device() {
            return "a device";
        }
    }
    if kind.is_dir() { "a folder" } else { "none" }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(unix)]
    #[test]
    fn folders_devices_and_sockets_are_no_regular_files() {
        let folder = tempfile::tempdir().expect("a folder");
        let socket = folder.path().join("s");
        let _bound = std::os::unix::net::UnixListener::bind(&socket).expect("a socket");
        for (path, found) in [
            (folder.path(), "a folder"),
            (Path::new("/dev/zero"), "a device"),
            (&socket, "a socket"),
        ] {
            let expected = format!("{}: expected a regular file, found {found}", path.display());
            for refused in [
                open(path).map(drop),
                read(path).map(drop),
                read_to_string(path).map(drop),
            ] {
                assert_eq!(refused.expect_err("a refusal").to_string(), expected);
            }
        }
        let file = folder.path().join("f");
        fs::write(&file, "text").expect("a file");
        assert_eq!(read(&file).expect("bytes"), b"text");
        assert_eq!(read_to_string(&file).expect("text"), "text");
    }

    /// Collects lines of the library's code that open a file in another way than this one.
    fn elsewhere(folder: &Path, found: &mut Vec<String>) {
        let ways = [
            "fs::read(",
            "fs::read_to_string(",
            " File::open(",
            "fs::File::open(",
            "(File::open(",
            "image::open(",
            "ImageReader::open(",
            ".from_path(",
            "Reader::from_path(",
        ];
        // They read what the system or this program wrote, or are not part of it.
        let own = [
            "files/regular.rs",
            "build.rs",
            "tests.rs",
            "testing.rs",
            "bench/board/tree.rs",
            "bench/memory.rs",
            "cli/interrupt.rs",
            "cli/embed.rs",
            "inference/find_runtime.rs",
            "cli/outputs.rs",
            "cohort/fit/walkers.rs",
        ];
        for entry in fs::read_dir(folder).expect("readable") {
            let path = entry.expect("readable").path();
            if path.is_dir() && !path.ends_with("tests") {
                elsewhere(&path, found);
            } else if path.extension().is_some_and(|it| it == "rs")
                && !own.iter().any(|own| path.ends_with(own))
            {
                let text = fs::read_to_string(&path).expect("text");
                let code = text.split("\nmod tests {").next().unwrap_or_default();
                let lines = code
                    .lines()
                    .filter(|line| ways.iter().any(|way| line.contains(way)));
                found.extend(lines.map(|line| format!("{}: {}", path.display(), line.trim())));
            }
        }
    }

    #[test]
    fn all_files_are_opened_here() {
        let mut found = Vec::new();
        elsewhere(
            &Path::new(env!("CARGO_MANIFEST_DIR")).join("src"),
            &mut found,
        );
        assert_eq!(found, [""; 0]);
    }
}
