//! A test that poses, silhouettes and templates are the same bytes on every target, by a committed
//! list of hashes, which the firmware in `examples/firmware` must match as well.
//!
//! `UPDATE_GOLDEN=1 cargo test -p edgegait-core --test bytes same_bytes` rewrites the list, after
//! an intended change of the images that was inspected.

use crate::golden;
use crate::golden::HASHES;
use std::fmt::Write as _;

#[test]
fn every_hash_is_that_of_the_list() {
    let mut made = String::new();
    golden::list(&mut |name, hash| writeln!(made, "{name} {:016x}", hash.0).expect("text"));
    if std::env::var_os("UPDATE_GOLDEN").is_some() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/golden/hashes.txt");
        std::fs::write(path, &made).expect("a place to write");
        return;
    }
    // Without tiny-skia, its lines are left out.
    let is_made = |line: &&str| cfg!(feature = "tiny-skia") || !line.contains("skia-aa");
    let expected: Vec<&str> = HASHES.lines().filter(is_made).collect();
    let made: Vec<&str> = made.lines().collect();
    assert!(expected.len() > 100, "{} lines", expected.len());
    for (made, expected) in made.iter().zip(&expected) {
        assert_eq!(made, expected);
    }
    assert_eq!(made.len(), expected.len());
}

#[test]
fn drawn_hull_by_hull_a_silhouette_has_the_hash_that_it_has_drawn_at_once() {
    let hash = |name: &str| {
        let line = HASHES.lines().find_map(|line| line.strip_prefix(name));
        line.unwrap_or_else(|| panic!("{name} is not in the list"))
            .trim()
    };
    let mut compared = 0;
    for line in HASHES.lines() {
        if let Some((name, found)) = line.split_once(' ')
            && let Some(whole) = name.strip_prefix("compact-")
        {
            assert_eq!(found, hash(&format!("{whole} ")), "{name}");
            compared += 1;
        }
    }
    assert!(compared >= 30, "{compared}");
}
