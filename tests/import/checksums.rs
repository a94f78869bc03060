//! Files from other sources are unchanged.

use crate::data::fixtures;
use sha2::{Digest, Sha256};
use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

/// Collects all files under a folder.
fn files(folder: &Path, found: &mut BTreeSet<String>) {
    for entry in fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            files(&path, found);
        } else {
            let name = path.strip_prefix(fixtures()).expect("a part of it");
            found.insert(name.to_str().expect("UTF-8").replace('\\', "/"));
        }
    }
}

#[test]
fn every_file_has_the_checksum_of_the_list() {
    let list = fs::read_to_string(fixtures().join("SHA256SUMS")).expect("a list");
    let mut listed = BTreeSet::new();
    for line in list.lines() {
        let (checksum, name) = line.split_once("  ").expect("a checksum and a name");
        let digest = Sha256::digest(fs::read(fixtures().join(name)).expect("a file"));
        let hex: String = digest.iter().map(|byte| format!("{byte:02x}")).collect();
        assert_eq!(hex, checksum, "{name}");
        listed.insert(name.to_owned());
    }
    let mut there = BTreeSet::new();
    files(&fixtures(), &mut there);
    there.retain(|name| !name.starts_with("golden/"));
    for name in ["README.md", "SHA256SUMS"] {
        assert!(there.remove(name));
    }
    assert_eq!(there, listed);
}
