//! The digest of a sweep that is too large to store.

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
    // Each cycle has four viewpoints, plain and mirrored; there are four walks and three
    // conditions.
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
    // Other cycles and other seeds give other digests.
    let of = |more: &[&str]| json(&[&["--digest"], more].concat())["digest"].clone();
    assert_ne!(of(&["--first-cycle", "1"]), expected.as_str());
    assert_ne!(of(&["--seed", "2"]), expected.as_str());
    let printed = done(at, &["sweep", "two.egp", "--views", "side", "--digest"]);
    assert!(printed.starts_with("sha256 "), "{printed}");
    assert_eq!(names(at), ["stored", "two.egp"]);
    let both = ["sweep", "two.egp", "--digest", "--out", "new"];
    refused(at, &both, 2, &["--digest", "--out"]);
}

#[test]
fn sampled_strengths_are_in_the_index_and_do_not_depend_on_threads() {
    let folder = folder();
    let at = folder.path();
    let written = "[[conditions]]\nname = 'drawn'\nconfounders = { coat = { p = 0.5, uniform = [0.2, 1] }, roll = { normal = ['0 deg', '3 deg'], per = 'person' } }\n";
    std::fs::write(at.join("drawn.toml"), written).expect("a file");
    let sweep = |more: &str| {
        let sweep = format!("sweep two.egp --azimuth-deg 90 --elevation-deg 0 --cycles 20 {more}");
        done(at, &sweep.split_whitespace().collect::<Vec<_>>())
    };
    let hash = |threads: &str| {
        let said = sweep(&format!(
            "--conditions drawn.toml --digest --threads {threads}"
        ));
        said.split(':').next().expect("a hash").to_owned()
    };
    assert_eq!(hash("1"), hash("3"));
    sweep("--conditions drawn.toml --out all");
    let index = std::fs::read(at.join("all/index.csv")).expect("an index");
    let mut rows = csv::Reader::from_reader(index.as_slice());
    let header = rows.headers().expect("a header").clone();
    let column = |name: &str| header.iter().position(|column| column == name).expect(name);
    let [subject, drawn] = ["subject", "alternative"].map(column);
    let (mut coats, mut rolls) = (0, std::collections::BTreeSet::new());
    let mut count = 0;
    for row in rows.records() {
        let row = row.expect("a row");
        count += 1;
        for dose in row[drawn].split(',') {
            match dose.split_once('=').expect("a dose") {
                ("coat", strength) => {
                    coats += 1;
                    let strength: f64 = strength.parse().expect("a number");
                    assert!((0.2..=1.0).contains(&strength), "{strength}");
                }
                ("roll", strength) => {
                    rolls.insert((row[subject].to_owned(), strength.to_owned()));
                }
                other => panic!("{other:?}"),
            }
        }
    }
    // Two people at two speeds; each person has one roll.
    assert_eq!((count, rolls.len()), (80, 2));
    assert!((25..=55).contains(&coats), "{coats}");
    // The index states what was drawn: the same strengths without chance give the same image.
    let mut rows = csv::Reader::from_reader(index.as_slice());
    let first = rows.records().next().expect("a row").expect("a row");
    let fixed = format!(
        "--confound {} --subjects {} --out one",
        &first[drawn], &first[subject]
    );
    sweep(&fixed);
    let [(_, all), (_, one)] = ["all", "one"].map(|name| npy(at.join(name).join("geis.npy")));
    assert_eq!(all[..1500], one[..1500]);
}

#[test]
fn the_environment_names_registers_and_pixels_do_not_depend_on_them() {
    let folder = folder();
    let at = folder.path();
    let sweep = |raster: &str, registers: Option<&str>| {
        let mut command = program(at);
        command.args([
            "sweep",
            "two.egp",
            "--views",
            "paper",
            "--frames-per-cycle",
            "4",
        ]);
        command.args(["--digest", "--raster", raster]);
        if let Some(name) = registers {
            command.env("EDGEGAIT_SIMD", name);
        }
        command.output().expect("the program runs")
    };
    for raster in ["skia", "rows"] {
        let hash = |registers: Option<&str>| {
            let output = sweep(raster, registers);
            assert_eq!(code(&output), 0, "{}", text(&output.stderr));
            let said = text(&output.stdout);
            said.split(':').next().expect("a hash").to_owned()
        };
        let expected = hash(None);
        for simd in edgegait_core::raster::Simd::available() {
            assert_eq!(hash(Some(simd.name())), expected, "{raster}, {simd}");
        }
    }
    let output = sweep("skia", Some("mmx"));
    assert_eq!(code(&output), 2);
    let error = text(&output.stderr);
    assert!(
        error.contains("EDGEGAIT_SIMD") && error.contains("portable"),
        "{error}"
    );
}
