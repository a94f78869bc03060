//! Looks at a shared library before it is loaded.
//!
//! The system's loader maps a truncated library without complaint and the
//! process dies of SIGBUS at the first missing page; a library for another
//! processor gives an error that names neither. Both are told here.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use crate::error::{Error, Result};

/// Oldest ONNX Runtime that this build can talk to (`ort`'s feature `api-18`).
const OLDEST: (u32, u32) = (1, 18);
/// Most bytes of names that are read.
const MAX_NAMES: u64 = 64 << 20;
/// The function that every ONNX Runtime has.
const ENTRY: &[u8] = b"OrtGetApiBase";

/// A shared library that is worth loading.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Library {
    /// Absolute.
    pub path: PathBuf,
    /// The version that the library or its name states.
    pub version: Option<String>,
}

impl Library {
    /// Checks the file.
    ///
    /// # Errors
    /// If there is no such file, or it is not a complete ONNX Runtime library of at least 1.18
    /// for this system.
    pub fn inspect(path: &Path) -> Result<Self> {
        let io = |error| Error::io(path, error);
        let absolute = path.canonicalize().map_err(io)?;
        let metadata = std::fs::metadata(&absolute).map_err(io)?;
        if !metadata.is_file() {
            return Err(Error::input(
                path,
                "expected the ONNX Runtime library itself, found no regular file \
                 (give the full path of libonnxruntime)",
            ));
        }
        let mut file = File::open(&absolute).map_err(io)?;
        let version = if cfg!(any(target_os = "macos", target_os = "ios")) {
            expect_magic(&mut file, path, "a Mach-O library", &MACH_O)?;
            None
        } else if cfg!(windows) {
            expect_magic(&mut file, path, "a DLL", &[b"MZ"])?;
            None
        } else {
            elf::check(&mut file, metadata.len(), path)?
        };
        let version = version.or_else(|| version_in_name(&absolute));
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

fn expect_magic(file: &mut File, path: &Path, what: &str, magics: &[&[u8]]) -> Result<()> {
    let mut start = Vec::new();
    file.take(4)
        .read_to_end(&mut start)
        .map_err(|error| Error::io(path, error))?;
    if magics.iter().any(|magic| start.starts_with(magic)) {
        return Ok(());
    }
    Err(Error::input(
        path,
        format!("expected {what}, found another kind of file"),
    ))
}

/// `1.31.1` in `libonnxruntime.so.1.31.1` or `libonnxruntime.1.31.1.dylib`.
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

/// The ELF format: System V ABI, chapter 4; `elf(5)`.
mod elf {
    use super::*;

    const SHT_NOBITS: u64 = 8;
    const SHT_DYNSYM: u64 = 11;
    const MAX_HEADERS: u64 = 4096;

    /// `EM_*` of this build.
    const MACHINE: Option<(u64, &str)> = if cfg!(target_arch = "x86_64") {
        Some((62, "x86-64"))
    } else if cfg!(target_arch = "aarch64") {
        Some((183, "aarch64"))
    } else if cfg!(target_arch = "arm") {
        Some((40, "arm"))
    } else if cfg!(target_arch = "x86") {
        Some((3, "x86"))
    } else if cfg!(target_arch = "riscv64") {
        Some((243, "riscv64"))
    } else {
        None
    };

    /// Offset and width in the header of a 32-bit and of a 64-bit file.
    type Spot = [(usize, usize); 2];
    const E_PHOFF: Spot = [(28, 4), (32, 8)];
    const E_SHOFF: Spot = [(32, 4), (40, 8)];
    const E_PHENTSIZE: Spot = [(42, 2), (54, 2)];
    const E_PHNUM: Spot = [(44, 2), (56, 2)];
    const E_SHENTSIZE: Spot = [(46, 2), (58, 2)];
    const E_SHNUM: Spot = [(48, 2), (60, 2)];
    const P_OFFSET: Spot = [(4, 4), (8, 8)];
    const P_FILESZ: Spot = [(16, 4), (32, 8)];
    const SH_TYPE: Spot = [(4, 4), (4, 4)];
    const SH_OFFSET: Spot = [(16, 4), (24, 8)];
    const SH_SIZE: Spot = [(20, 4), (32, 8)];
    const SH_LINK: Spot = [(24, 4), (40, 4)];

    /// A header, whose numbers are read by their spots.
    struct Header<'a> {
        bytes: &'a [u8],
        is_64: bool,
    }

    impl Header<'_> {
        /// The number there; 0 beyond the end. Byte order is checked to be this machine's.
        fn at(&self, spot: Spot) -> u64 {
            let (offset, width) = spot[usize::from(self.is_64)];
            let mut number = [0; 8];
            let Some(found) = self.bytes.get(offset..offset + width) else {
                return 0;
            };
            if cfg!(target_endian = "little") {
                number[..width].copy_from_slice(found);
            } else {
                number[8 - width..].copy_from_slice(found);
            }
            u64::from_ne_bytes(number)
        }
    }

    /// Checks that the file is complete and for this machine; the version it states.
    pub(super) fn check(file: &mut File, size: u64, path: &Path) -> Result<Option<String>> {
        let refuse = |problem: String| Error::input(path, problem);
        let start = read(file, path, 0, size.min(64))?;
        if !start.starts_with(b"\x7FELF") {
            return Err(refuse(
                "expected a shared library (ELF), found another kind of file".into(),
            ));
        }
        let cut_short = || {
            refuse(format!(
                "the library is cut short: its parts end beyond its {size} bytes (copy or download it again)"
            ))
        };
        if size < 64 {
            return Err(cut_short());
        }
        let bits = usize::BITS;
        let found = if start[4] == 2 { 64 } else { 32 };
        if found != bits {
            return Err(refuse(format!(
                "expected a {bits}-bit library, found a {found}-bit one"
            )));
        }
        let order = if cfg!(target_endian = "little") { 1 } else { 2 };
        if start[5] != order {
            return Err(refuse("the library is for the other byte order".into()));
        }
        let header = Header {
            bytes: &start,
            is_64: bits == 64,
        };
        let machine = header.at([(18, 2); 2]);
        if let Some((expected, name)) = MACHINE
            && machine != expected
        {
            return Err(refuse(format!(
                "expected a library for {name} (ELF machine {expected}), found machine {machine}"
            )));
        }
        if header.at([(16, 2); 2]) != 3 {
            return Err(refuse(
                "expected a shared library, found another kind of ELF file".into(),
            ));
        }

        let mut table = |offset: Spot, entry: Spot, count: Spot| -> Result<Vec<Vec<u8>>> {
            let (offset, entry, count) = (header.at(offset), header.at(entry), header.at(count));
            if count > MAX_HEADERS || ends_beyond(offset, entry * count, size) {
                return Err(cut_short());
            }
            let bytes = read(file, path, offset, entry * count)?;
            Ok(bytes
                .chunks_exact(entry.max(1) as usize)
                .map(<[u8]>::to_vec)
                .collect())
        };
        let segments = table(E_PHOFF, E_PHENTSIZE, E_PHNUM)?;
        let sections = table(E_SHOFF, E_SHENTSIZE, E_SHNUM)?;
        let view = |bytes: &'_ Vec<u8>, spot| {
            Header {
                bytes,
                is_64: bits == 64,
            }
            .at(spot)
        };
        for segment in &segments {
            if ends_beyond(view(segment, P_OFFSET), view(segment, P_FILESZ), size) {
                return Err(cut_short());
            }
        }
        for section in &sections {
            if view(section, SH_TYPE) != SHT_NOBITS
                && ends_beyond(view(section, SH_OFFSET), view(section, SH_SIZE), size)
            {
                return Err(cut_short());
            }
        }

        let symbols = sections
            .iter()
            .find(|section| view(section, SH_TYPE) == SHT_DYNSYM);
        let names = symbols.and_then(|section| sections.get(view(section, SH_LINK) as usize));
        let Some(names) = names else {
            return Ok(None);
        };
        let length = view(names, SH_SIZE).min(MAX_NAMES);
        let names = read(file, path, view(names, SH_OFFSET), length)?;
        if !names.split(|byte| *byte == 0).any(|name| name == ENTRY) {
            return Err(refuse(
                "expected libonnxruntime, found a library without OrtGetApiBase".into(),
            ));
        }
        Ok(version(&names))
    }

    /// The name of the library's symbol version, `VERS_1.31.1`.
    fn version(names: &[u8]) -> Option<String> {
        names
            .split(|byte| *byte == 0)
            .filter_map(|name| std::str::from_utf8(name.strip_prefix(b"VERS_")?).ok())
            .find(|version| version.starts_with(|c: char| c.is_ascii_digit()))
            .map(str::to_owned)
    }

    fn ends_beyond(offset: u64, length: u64, size: u64) -> bool {
        offset.checked_add(length).is_none_or(|end| end > size)
    }

    fn read(file: &mut File, path: &Path, offset: u64, length: u64) -> Result<Vec<u8>> {
        let mut bytes = Vec::new();
        file.seek(SeekFrom::Start(offset))
            .and_then(|_| file.take(length).read_to_end(&mut bytes))
            .map_err(|error| Error::io(path, error))?;
        if (bytes.len() as u64) < length {
            return Err(Error::input(path, "the library is cut short"));
        }
        Ok(bytes)
    }
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::*;
    use crate::score::testing::ort_library;

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
