//! What the README and the guide tell users to type is what the command takes.

use crate::command::done;
use edgegait::confound::Conditions;
use edgegait::design::Design;
use edgegait::score::Contract;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

/// The README and each page of the guide.
fn pages() -> Vec<(PathBuf, String)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let entries = fs::read_dir(root.join("src/guide")).expect("the guide");
    let mut paths: Vec<PathBuf> = entries.map(|entry| entry.expect("a page").path()).collect();
    paths.retain(|path| path.extension().is_some_and(|kind| kind == "md"));
    paths.push(root.join("README.md"));
    let read = |path: PathBuf| {
        let text = fs::read_to_string(&path).expect("readable");
        (path, text)
    };
    paths.into_iter().map(read).collect()
}

/// The commands of a page: what stands between backticks, and the lines of blocks, if it begins
/// with the command's name.
fn commands(text: &str) -> impl Iterator<Item = &str> {
    let parts = text.split('`').chain(text.lines());
    let parts = parts.filter_map(|part| {
        let cargo = part.strip_prefix("cargo run --release -- ");
        cargo.or_else(|| part.strip_prefix("edgegait "))
    });
    parts.map(|part| part.split('#').next().unwrap_or(part))
}

#[test]
fn every_flag_of_every_command_in_the_guide_is_one_that_the_command_has() {
    let mut helps: BTreeMap<String, String> = BTreeMap::new();
    let mut flags = 0;
    for (path, text) in pages() {
        for command in commands(&text) {
            let mut words = command.split_whitespace();
            let name = words.next().expect("a subcommand");
            let help = helps
                .entry(name.to_owned())
                .or_insert_with(|| done(Path::new("."), &[name, "--help"]));
            for flag in words.filter(|word| word.starts_with("--")) {
                let flag = flag.trim_end_matches([',', '.', ')']);
                let is_known = help.split_whitespace().any(|word| word == flag);
                assert!(is_known, "{}: {command}: {flag}", path.display());
                flags += 1;
            }
        }
    }
    assert!(flags >= 40, "{flags}");
    for name in [
        "import", "bench", "score", "sweep", "train", "quantize", "cohort",
    ] {
        assert!(helps.contains_key(name), "{name}");
    }
}

#[test]
fn the_files_that_the_guide_shows_can_be_read() {
    let mut read = [0, 0, 0];
    for (path, text) in pages() {
        for block in text.split("```toml\n").skip(1) {
            let block = block.split("```").next().expect("the block's end");
            if block.contains("[views]") {
                Design::parse(&path, block).expect("a design");
                read[2] += 1;
            } else if block.contains("[[conditions]]") {
                Conditions::parse(&path, block).expect("conditions");
                read[0] += 1;
            } else {
                Contract::parse(&path, block).expect("a contract");
                read[1] += 1;
            }
        }
    }
    assert_eq!(read, [1, 1, 1]);
}

#[test]
fn links_between_pages_lead_to_files() {
    let mut links = 0;
    for (path, text) in pages() {
        for link in text.split("](").skip(1) {
            let link = link.split([')', '#']).next().expect("a link's end");
            if !link.is_empty() && !link.contains("://") {
                let to = path.parent().expect("a folder").join(link);
                assert!(to.exists(), "{}: {link}", path.display());
                links += 1;
            }
        }
    }
    assert!(links >= 15, "{links}");
}
