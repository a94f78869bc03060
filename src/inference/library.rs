//! Checks a shared library before it is loaded.
//!
//! The system's loader maps a truncated library without an error, and the process dies of SIGBUS at
//! the first missing page. Its error for a library of another processor names neither processor.
//! This module reports both.

use std::env::consts::ARCH;
use std::fs::File;
use std::path::{Path, PathBuf};

use object::elf::{self, ELFMAG};
use object::read::elf::{FileHeader, ProgramHeader, SectionHeader};
use object::{FileKind, NativeEndian, ReadCache, ReadRef};

use crate::error::{Error, Result};

/// The oldest ONNX Runtime that this build can use (`ort`'s feature `api-18`).
const OLDEST: (u32, u32) = (1, 18);
/// The maximum number of bytes of symbol names that are read.
const MAX_NAMES: u64 = 64 << 20;
/// The function that every ONNX Runtime exports.
const ENTRY: &[u8] = b"OrtGetApiBase";

/// A shared library that passed the checks.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Library {
    /// The absolute path.
    pub path: PathBuf,
    /// The version that the library or its name states.
    pub version: Option<String>,
}

impl Library {
    /// Checks the file at `path`.
    ///
    /// # Errors
    /// If there is no such file, or it is not a complete ONNX Runtime library of at least 1.18
    /// for this system.
    pub(super) fn inspect(path: &Path) -> Result<Self> {
        let io = |error| Error::io(path, error);
        let refuse = |problem: String| Error::input(path, problem);
        let absolute = path.canonicalize().map_err(io)?;
        if !std::fs::metadata(&absolute).map_err(io)?.is_file() {
            return Err(refuse(
                "expected the ONNX Runtime library itself, found no regular file \
                 (give the full path of libonnxruntime)"
                    .into(),
            ));
        }
        let file = ReadCache::new(crate::files::open(&absolute)?);
        let (kind, magics): (_, &[&[u8]]) = if cfg!(any(target_os = "macos", target_os = "ios")) {
            ("a Mach-O library", &MACH_O)
        } else if cfg!(windows) {
            ("a DLL", &[b"MZ"])
        } else {
            ("a shared library (ELF)", &[&ELFMAG])
        };
        let start = (&file).read_bytes_at(0, 4).unwrap_or_default();
        if !magics.iter().any(|magic| start.starts_with(magic)) {
            return Err(refuse(format!(
                "expected {kind}, found another kind of file"
            )));
        }
        let stated = if start == ELFMAG {
            version_in_elf(&file).map_err(refuse)?
        } else {
            None
        };
        let version = stated.or_else(|| version_in_name(&absolute));
        if let Some(found) = &version {
            refuse_old(path, found)?;
        }
        Ok(Self {
            path: absolute,
            version,
        })
    }
}

/// 64-bit and 32-bit little-endian Mach-O, and a file with several of them.
const MACH_O: [&[u8]; 3] = [
    b"\xCF\xFA\xED\xFE",
    b"\xCE\xFA\xED\xFE",
    b"\xCA\xFE\xBA\xBE",
];

#[cfg(target_pointer_width = "32")]
use elf::FileHeader32 as NativeFileHeader;
#[cfg(target_pointer_width = "64")]
use elf::FileHeader64 as NativeFileHeader;

type ElfHeader = NativeFileHeader<NativeEndian>;

/// Checks that an ELF file is complete and for this machine, and returns the version it states.
fn version_in_elf(file: &ReadCache<File>) -> std::result::Result<Option<String>, String> {
    let size = file.len().unwrap_or(0);
    let cut_short = |why: &str| {
        format!("the library is cut short or damaged: {why} (copy or download it again)")
    };
    let unreadable = |error: object::read::Error| cut_short(&error.to_string());
    let beyond = |()| cut_short(&format!("its parts end beyond its {size} bytes"));

    let found = match FileKind::parse(file).map_err(unreadable)? {
        FileKind::Elf64 => 64,
        _ => 32,
    };
    if found != usize::BITS {
        let bits = usize::BITS;
        return Err(format!(
            "expected a {bits}-bit library, found a {found}-bit one"
        ));
    }
    let header = ElfHeader::parse(file).map_err(unreadable)?;
    let Ok(endian) = header.endian() else {
        return Err("the library is for the other byte order".into());
    };
    let machine = match ARCH {
        "x86_64" => Some(elf::EM_X86_64),
        "aarch64" => Some(elf::EM_AARCH64),
        "arm" => Some(elf::EM_ARM),
        "x86" => Some(elf::EM_386),
        "riscv64" => Some(elf::EM_RISCV),
        _ => None,
    };
    let found = header.e_machine(endian);
    if let Some(expected) = machine
        && found != expected
    {
        return Err(format!(
            "expected a library for {ARCH} (ELF machine {expected}), found machine {found}"
        ));
    }
    if header.e_type(endian) != elf::ET_DYN {
        return Err("expected a shared library, found another kind of ELF file".into());
    }

    let segments = header.program_headers(endian, file).map_err(unreadable)?;
    let sections = header.section_headers(endian, file).map_err(unreadable)?;
    let ranges = (segments.iter().map(|segment| segment.file_range(endian))).chain(
        sections
            .iter()
            .filter_map(|section| section.file_range(endian)),
    );
    for (offset, length) in ranges {
        if offset.checked_add(length).is_none_or(|end| end > size) {
            return Err(beyond(()));
        }
    }

    let symbols = sections
        .iter()
        .find(|section| section.sh_type(endian) == elf::SHT_DYNSYM);
    let names = symbols.and_then(|section| sections.get(section.link(endian).0));
    let Some((offset, length)) = names.and_then(|names| names.file_range(endian)) else {
        return Ok(None);
    };
    let names = file
        .read_bytes_at(offset, length.min(MAX_NAMES))
        .map_err(beyond)?;
    let mut names = names.split(|byte| *byte == 0);
    if !names.clone().any(|name| name == ENTRY) {
        return Err("expected libonnxruntime, found a library without OrtGetApiBase".into());
    }
    // The name of the library's symbol version, `VERS_1.31.1`.
    let version = names.find_map(|name| {
        let version = std::str::from_utf8(name.strip_prefix(b"VERS_")?).ok()?;
        version
            .starts_with(|c: char| c.is_ascii_digit())
            .then(|| version.to_owned())
    });
    Ok(version)
}

/// Returns the version in a file's name: `1.31.1` for `libonnxruntime.so.1.31.1` or
/// `libonnxruntime.1.31.1.dylib`.
fn version_in_name(path: &Path) -> Option<String> {
    let name = path.file_name()?.to_str()?;
    let start = name.find(|c: char| c.is_ascii_digit())?;
    let digits = name[start..].trim_end_matches(|c: char| !c.is_ascii_digit());
    let is_version =
        digits.split('.').count() >= 2 && digits.split('.').all(|part| part.parse::<u32>().is_ok());
    is_version.then(|| digits.to_owned())
}

fn refuse_old(path: &Path, found: &str) -> Result<()> {
    let mut parts = found
        .split('.')
        .map(|part| part.parse::<u32>().unwrap_or(0));
    let version = (parts.next().unwrap_or(0), parts.next().unwrap_or(0));
    if version >= OLDEST {
        return Ok(());
    }
    Err(Error::input(
        path,
        format!(
            "expected ONNX Runtime {}.{} or later, found {found}",
            OLDEST.0, OLDEST.1
        ),
    ))
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::*;
    use crate::inference::testing::ort_library;

    fn refusal(content: &[u8]) -> String {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("lib.so");
        std::fs::write(&path, content).expect("written");
        let error = Library::inspect(&path)
            .expect_err("not a library")
            .to_string();
        error.replace(&folder.path().display().to_string(), "")
    }

    #[test]
    fn what_is_not_a_library_is_refused() {
        assert_eq!(
            refusal(b"not a library"),
            "/lib.so: expected a shared library (ELF), found another kind of file"
        );
        assert!(refusal(b"").contains("another kind of file"));
        assert!(refusal(b"\x7FELF\x02\x01\x01").contains("cut short"));
        let missing = Library::inspect(Path::new("/no/such/lib.so")).expect_err("missing");
        assert!(
            missing.to_string().starts_with("/no/such/lib.so: "),
            "{missing}"
        );
        let folder = Library::inspect(Path::new("/"))
            .expect_err("a folder")
            .to_string();
        assert!(folder.contains("no regular file"), "{folder}");
    }

    #[test]
    fn a_running_program_is_not_a_library_but_is_complete() {
        let path = std::env::current_exe().expect("a test runs from a file");
        let text = Library::inspect(&path)
            .expect_err("no ONNX Runtime")
            .to_string();
        assert!(
            text.contains("OrtGetApiBase") || text.contains("ELF file"),
            "{text}"
        );
    }

    #[test]
    fn a_library_for_another_machine_is_refused_by_number() {
        let path = std::env::current_exe().expect("a test runs from a file");
        let mut bytes = std::fs::read(path).expect("readable");
        bytes[18] = 12;
        bytes[19] = 0;
        let text = refusal(&bytes);
        assert!(text.contains("found machine 12"), "{text}");
    }

    #[test]
    fn versions_are_found_in_names_and_old_ones_refused() {
        let in_name = |name: &str| version_in_name(Path::new(name));
        assert_eq!(
            in_name("/x/libonnxruntime.so.1.31.1").as_deref(),
            Some("1.31.1")
        );
        assert_eq!(
            in_name("libonnxruntime.1.20.0.dylib").as_deref(),
            Some("1.20.0")
        );
        assert_eq!(in_name("libonnxruntime.so"), None);
        assert_eq!(in_name("libonnxruntime.so.1"), None);
        let path = Path::new("l.so");
        assert!(refuse_old(path, "1.18.0").is_ok() && refuse_old(path, "2.0").is_ok());
        assert_eq!(
            refuse_old(path, "1.17.3").expect_err("old").to_string(),
            "l.so: expected ONNX Runtime 1.18 or later, found 1.17.3"
        );
    }

    mod with_ort {
        use super::*;

        #[test]
        #[ignore = "needs EDGEGAIT_ORT_LIB"]
        fn every_truncation_of_the_real_library_is_refused() {
            let path = ort_library();
            let whole = Library::inspect(&path).expect("the real library");
            assert!(whole.version.is_some(), "{whole:?}");
            let bytes = std::fs::read(&path).expect("readable");
            for keep in [
                0,
                3,
                5,
                63,
                64,
                1000,
                bytes.len() / 2,
                bytes.len() - 4096,
                bytes.len() - 1,
            ] {
                let text = refusal(&bytes[..keep]);
                assert!(
                    text.contains("cut short") || text.contains("another kind"),
                    "{keep}: {text}"
                );
            }
        }
    }
}
