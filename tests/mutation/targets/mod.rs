//! What is run: a target for each kind of file.

mod commands;
mod datasets;
mod meshes;
mod models;
mod motions;
mod packs;
mod pictures;
mod tables;

use crate::chance::Chance;
use crate::data::fixtures;
use crate::mutators::Mutator;
use crate::run::{Outcome, Target};
use edgegait::Error;
use edgegait::cli::embed::{EmbeddedInputs, Stop, results, text_of};
use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};

/// Returns all targets, which work below a folder.
pub fn all(folder: &Path) -> Vec<Target> {
    let made = folder.join("made");
    fs::create_dir_all(&made).expect("a folder");
    let mut all = Vec::new();
    all.extend(packs::targets());
    all.extend(motions::targets(folder, &made));
    all.extend(meshes::targets(folder));
    all.extend(models::targets(folder));
    all.extend(tables::targets(folder, &made));
    all.extend(datasets::targets(folder, &made));
    all.extend(pictures::targets(folder, &made));
    all.extend(commands::targets());
    all
}

fn target(
    name: &'static str,
    in_a_round: u64,
    seeds: Vec<Vec<u8>>,
    own: &[Mutator],
    any: &[Mutator],
    read: impl Fn(&[u8], &mut Chance) -> Outcome + 'static,
) -> Target {
    assert!(
        !seeds.is_empty() && seeds.iter().all(|seed| !seed.is_empty()),
        "{name}: seeds"
    );
    Target {
        name,
        in_a_round,
        seeds,
        own: own.to_vec(),
        any: any.to_vec(),
        read: Box::new(read),
    }
}

/// Returns the paths of the files below a folder with one of these extensions and at most so many
/// bytes, in order.
fn below(folder: &Path, extensions: &[&str], most: u64) -> Vec<PathBuf> {
    let (mut folders, mut found) = (vec![folder.to_path_buf()], Vec::new());
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(&folder).into_iter().flatten().flatten() {
            let path = entry.path();
            let extension = path.extension().unwrap_or_default().to_ascii_lowercase();
            let is_small =
                || fs::metadata(&path).is_ok_and(|file| (1..=most).contains(&file.len()));
            if path.is_dir() {
                folders.push(path);
            } else if extensions.iter().any(|it| extension == *it) && is_small() {
                found.push(path);
            }
        }
    }
    found.sort();
    found
}

fn contents(paths: impl IntoIterator<Item = PathBuf>) -> Vec<Vec<u8>> {
    paths
        .into_iter()
        .map(|path| fs::read(path).expect("a seed"))
        .collect()
}

/// Returns the seeds with one of these extensions: those of the repository, and the broken
/// recordings if there are any here.
fn seeds(extensions: &[&str], most: u64) -> Vec<Vec<u8>> {
    let mut paths = below(&fixtures(), extensions, most);
    if std::env::var_os("EDGEGAIT_DATA").is_some() {
        paths.extend(below(&crate::data::given().join("hard"), extensions, most));
    }
    contents(paths)
}

/// Runs a command in this process until it is done or `stop` ends it. An end is no refusal: what
/// was read before was accepted.
fn command_until(words: &[&str], paths: &[&Path], stop: &Stop) -> Outcome {
    let mut paths = paths.iter();
    // "@" stands for the next path.
    let words: Vec<OsString> = words
        .iter()
        .map(|word| match *word {
            "@" => paths.next().expect("a path").as_os_str().to_owned(),
            word => word.into(),
        })
        .collect();
    let held = EmbeddedInputs {
        stop: stop.clone(),
        ..EmbeddedInputs::default()
    };
    match results(&words, held) {
        Err(Error::Cancelled) => Ok(()),
        Err(error) => Err(text_of(&error).into()),
        Ok(json) if json.is_empty() => Ok(()),
        Ok(json) => {
            serde_json::from_str::<serde_json::Value>(&json).expect("JSON of our own");
            Ok(())
        }
    }
}

fn command(words: &str, paths: &[&Path]) -> Outcome {
    let words: Vec<&str> = words.split_whitespace().collect();
    command_until(&words, paths, &Stop::default())
}

/// Runs a command up to its first step, which is behind the reading of its tables.
fn command_begun(words: &str, paths: &[&Path]) -> Outcome {
    let words: Vec<&str> = words.split_whitespace().collect();
    let stop = Stop::default();
    stop.end();
    command_until(&words, paths, &stop)
}

/// Runs a command that makes seeds.
fn make(words: &str, paths: &[&Path]) {
    command(words, paths).unwrap_or_else(|error| panic!("{words}: {error}"));
}
