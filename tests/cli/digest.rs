//! One hash of a sweep that is too large to store.

use crate::command::*;
use crate::npy::npy;
use crate::two::folder;
use serde_json::Value;
use sha2::{Digest as _, Sha256};

#[test]
fn a_digest_is_the_hash_of_the_dataset_that_it_does_not_store() {
    let folder = folder();
    let at = folder.path();
    let sweep = "sweep two.egp --raster columns --framing cycle --frames-per-cycle 8 --cycles 3 \
        --azimuth-deg 0,90 --elevation-deg 0,40 --augment flip --conditions casia-b --json -";
    let sweep: Vec<&str> = sweep.split_whitespace().collect();
    let json = |more: &[&str]| -> Value {
        serde_json::from_str(&done(at, &[&sweep[..], more].concat())).expect("JSON")
    };
    json(&["--out", "stored"]);
    let (_, images) = npy(at.join("stored/geis.npy"));
    // Four viewpoints, each as it is and mirrored, for a cycle; four walks, three conditions.
    let cycles = images.chunks(4 * 2 * 1500);
    assert_eq!(cycles.len(), 3 * 4 * 3);
    let mut all = Sha256::new();
    cycles.for_each(|cycle| all.update(Sha256::digest(cycle)));
    let expected: String = all
        .finalize()
        .iter()
        .map(|byte| format!("{byte:02x}"))
        .collect();
    for threads in ["1", "3"] {
        let results = json(&["--digest", "--threads", threads]);
        assert_eq!(results["digest"], expected.as_str());
        assert_eq!(results["geis"], 3 * 4 * 3 * 4 * 2);
    }
    assert_eq!(names(at), ["stored", "two.egp"]);
    // Each cycle is another, and so is each seed.
    let of = |more: &[&str]| json(&[&["--digest"], more].concat())["digest"].clone();
    assert_ne!(of(&["--first-cycle", "1"]), expected.as_str());
    assert_ne!(of(&["--seed", "2"]), expected.as_str());
    let printed = done(at, &["sweep", "two.egp", "--views", "side", "--digest"]);
    assert!(printed.starts_with("sha256 "), "{printed}");
    assert_eq!(names(at), ["stored", "two.egp"]);
    let both = ["sweep", "two.egp", "--digest", "--out", "new"];
    refused(at, &both, 2, &["--digest", "--out"]);
}
