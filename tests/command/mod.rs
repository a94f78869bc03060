//! Running the built command: what the tests of it share.

use edgegait::scene::Subject;
use edgegait::scene::cohort::{self, CohortOptions};
use sha2::{Digest, Sha256};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::OnceLock;
use tempfile::TempDir;

pub fn edgegait(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_edgegait"))
        .args(arguments)
        .current_dir(folder)
        .output()
        .expect("the command starts")
}

pub fn code(output: &Output) -> i32 {
    output.status.code().expect("an exit code")
}

pub fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).expect("UTF-8")
}

/// Runs what must succeed; its standard output.
pub fn done(folder: &Path, arguments: &[&str]) -> String {
    let output = edgegait(folder, arguments);
    assert_eq!(code(&output), 0, "{arguments:?}: {}", text(&output.stderr));
    text(&output.stdout)
}

/// Runs what must fail with `expected` and print nothing but an error that holds all of
/// `words`.
pub fn refused(folder: &Path, arguments: &[&str], expected: i32, words: &[&str]) {
    let output = edgegait(folder, arguments);
    let error = text(&output.stderr);
    assert_eq!(code(&output), expected, "{arguments:?}: {error}");
    assert!(
        output.stdout.is_empty(),
        "{arguments:?}: {}",
        text(&output.stdout)
    );
    let is_error = error.lines().any(|line| line.starts_with("error: "));
    assert!(is_error, "{arguments:?}: {error}");
    for word in words {
        assert!(error.contains(word), "{arguments:?}: {error}");
    }
}

/// A folder with `two.egp`: F01 and M01 at 4 and 8 km/h.
pub fn folder() -> TempDir {
    static PACK: OnceLock<Vec<u8>> = OnceLock::new();
    let bytes = PACK.get_or_init(|| {
        let folder = tempfile::tempdir().expect("a folder");
        done(folder.path(), &COHORT);
        fs::read(folder.path().join("two.egp")).expect("the pack")
    });
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join("two.egp"), bytes).expect("the pack");
    folder
}

pub const COHORT: [&str; 7] = [
    "cohort",
    "--people",
    "2",
    "--speeds-kmh",
    "4,8",
    "--out",
    "two.egp",
];

pub fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> = fs::read_dir(folder)
        .expect("a folder")
        .map(|entry| {
            entry
                .expect("an entry")
                .file_name()
                .to_string_lossy()
                .into()
        })
        .collect();
    names.sort();
    names
}

pub fn sha256(path: PathBuf) -> String {
    let digest = Sha256::digest(fs::read(path).expect("a file"));
    digest.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// Shape and bytes of an npy file of `u8`, read by the format's description (NEP 1).
pub fn npy(path: PathBuf) -> (String, Vec<u8>) {
    let bytes = fs::read(path).expect("a file");
    assert_eq!(&bytes[..8], b"\x93NUMPY\x01\x00");
    let end = 10 + usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
    let header = text(&bytes[10..end]);
    assert!(header.contains("'descr': '|u1'"), "{header}");
    assert!(header.contains("'fortran_order': False"), "{header}");
    let shape = header.split_once("'shape': (").expect("a shape").1;
    let shape = shape.split_once(')').expect("a shape").0;
    (
        shape.trim_end_matches([',', ' ']).into(),
        bytes[end..].to_vec(),
    )
}

/// People of the cohort at these speeds, before they are encoded.
pub fn made(people: usize, speeds_kmh: Vec<f64>) -> Vec<Subject> {
    let options = CohortOptions {
        seed: 1,
        people,
        speeds_kmh,
    };
    cohort::subjects(&options).expect("people")
}
