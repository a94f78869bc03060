//! Datasets: manifests, indexes and arrays, in folders, in shards and in one file.

use super::{Target, command, contents, make, target};
use crate::chance::Chance;
use crate::data::fixtures;
use crate::mutators::{bytes, checksums, structure, text};
use edgegait::Dataset;
use edgegait::dataset::{DatasetFormat, Existing, check_replaceable};
use std::fs;
use std::path::{Path, PathBuf};

pub fn targets(folder: &Path, made: &Path) -> Vec<Target> {
    let pack = fixtures().join("golden/v1-loops.egp");
    let sweep = "sweep @ --views side --raster rows --threads 1 --overwrite --out @";
    let [whole, one, two, npz] = ["whole", "one", "two", "whole.npz"].map(|name| made.join(name));
    make(sweep, &[&pack, &whole]);
    make(&format!("{sweep} --shard 1/2"), &[&pack, &one]);
    make(&format!("{sweep} --shard 2/2"), &[&pack, &two]);
    make(&format!("{sweep} --format npz"), &[&pack, &npz]);
    let at = |name: &str, from: &Path| {
        let to = crate::run::fresh(&folder.join(name));
        for entry in fs::read_dir(from).expect("a dataset").flatten() {
            fs::copy(entry.path(), to.join(entry.file_name())).expect("a copy");
        }
        to
    };
    // Its GEIs have pixels of 0 and 1 only, which is refused.
    let plain = at("plain", &fixtures().join("faults/geis_0_1"));
    let mut array = fs::read(plain.join("geis.npy")).expect("an array");
    array[128..].iter_mut().for_each(|pixel| *pixel *= 255);
    fs::write(plain.join("geis.npy"), array).expect("an array");
    let in_folder = |folder: PathBuf, name: &'static str| {
        move |bytes: &[u8], _: &mut Chance| {
            fs::write(folder.join(name), bytes)?;
            open(&folder)
        }
    };
    let shards = [at("shard-1", &one), at("shard-2", &two)];
    let merged = folder.join("merged");
    let merge = move |bytes: &[u8], _: &mut Chance| {
        fs::write(shards[0].join("manifest.json"), bytes)?;
        let _ = fs::remove_dir_all(&merged);
        let _ = fs::remove_dir_all(merged.with_extension("unfinished"));
        command(
            "merge @ @ --threads 1 --out @",
            &[&shards[0], &shards[1], &merged],
        )
    };
    let npz_at = crate::run::fresh(&folder.join("npz")).join("a.npz");
    let read_npz = move |bytes: &[u8], _: &mut Chance| {
        fs::write(&npz_at, bytes)?;
        check_replaceable(&npz_at, DatasetFormat::Npz, Existing::ReplaceOwn)?;
        Ok(())
    };
    let file = |folder: &Path, name: &str| contents([folder.join(name)]);
    vec![
        target(
            "dataset manifest",
            20,
            file(&whole, "manifest.json"),
            &[structure::json],
            &text::ALL[..8],
            in_folder(at("manifest", &whole), "manifest.json"),
        ),
        target(
            "dataset index",
            20,
            file(&plain, "index.csv"),
            &text::TABLE,
            &[],
            in_folder(at("index", &plain), "index.csv"),
        ),
        target(
            "npy",
            30,
            file(&plain, "geis.npy"),
            &[structure::npy],
            &bytes::ALL,
            in_folder(at("npy", &plain), "geis.npy"),
        ),
        target(
            "npz",
            20,
            contents([npz]),
            &[checksums::zip],
            &bytes::ALL,
            read_npz,
        ),
        target(
            "shards",
            4,
            file(&one, "manifest.json"),
            &[structure::json],
            &text::ALL[..4],
            merge,
        ),
    ]
}

fn open(folder: &Path) -> super::Outcome {
    let dataset = Dataset::open(folder)?;
    assert_eq!(dataset.index().len(), dataset.templates().count());
    for row in 0..dataset.index().len() {
        let _ = dataset.bytes(row);
    }
    Ok(())
}
