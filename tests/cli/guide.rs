//! Tests that the commands in the README and the guide are valid.

use crate::command::done;
use edgegait::dataset::design::Design;
use edgegait::draw::confounders::Conditions;
use edgegait::evaluate::protocol::Protocol;
use edgegait::inference::Contract;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Returns the README and the pages of the guide.
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

/// Returns the kind and the text of each code block of a page, in order.
fn blocks(text: &str) -> Vec<(&str, String)> {
    let (mut blocks, mut open): (Vec<(&str, String)>, bool) = (Vec::new(), false);
    for line in text.lines() {
        if let Some(kind) = line.trim_start().strip_prefix("```") {
            open = !open;
            if open {
                blocks.push((kind, String::new()));
            }
        } else if let (true, Some((_, block))) = (open, blocks.last_mut()) {
            block.push_str(line);
            block.push('\n');
        }
    }
    blocks
}

/// What a shell does before the commands of a `console` block: `edgegait` is the tested program.
/// Where a command would take a minute, it does less.
const PRELUDE: &str = r#"set -euo pipefail
edgegait() {
    case $1 in
        bench) set -- "$@" --windows 2 --window-s 0.05 --max-seconds 5 ;;
        confounders) set -- "$@" --subjects F01,M01 --cycles 1 ;;
        generate) set -- "$@" --people 20 ;;
    esac
    "$PROGRAM" "$@" || { echo "failed: edgegait $*" >&2; return 1; }
}
"#;

/// Runs the `console` blocks of a page in one folder, after writing the files that it shows: blocks
/// that begin with a comment with the file's name. Returns the number of blocks that ran.
fn run_page(path: &Path, text: &str) -> usize {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let models = Path::new(env!("CARGO_MANIFEST_DIR")).join("models");
    fs::copy(models.join("geinet.onnx"), at.join("mine.onnx")).expect("a model");
    let mut ran = 0;
    for (kind, block) in blocks(text) {
        let name = block
            .lines()
            .next()
            .and_then(|line| line.strip_prefix("# "));
        if let Some(name) = name.filter(|name| kind == "toml" && name.ends_with(".toml")) {
            fs::write(at.join(name), &block).expect("written");
        }
        if kind != "console" {
            continue;
        }
        if block.contains("--runtime ort") && std::env::var_os("EDGEGAIT_ORT_LIB").is_none() {
            continue;
        }
        let output = Command::new("bash")
            .args(["-c", &format!("{PRELUDE}{block}")])
            .env("PROGRAM", env!("CARGO_BIN_EXE_edgegait"))
            .env("EDGEGAIT_CACHE", at.join("cache"))
            .current_dir(at)
            .output()
            .expect("bash");
        assert!(
            output.status.success(),
            "{}: {block}{}",
            path.display(),
            String::from_utf8_lossy(&output.stderr)
        );
        ran += 1;
    }
    ran
}

#[test]
#[ignore = "a minute if the program is optimised: .ci/run runs it with --release"]
fn the_console_blocks_of_the_guide_run() {
    let pages = pages();
    let ran: usize = pages.iter().map(|(path, text)| run_page(path, text)).sum();
    assert!(ran >= 8, "{ran}");
}

#[test]
#[should_panic(expected = "failed: edgegait render --no-such-flag")]
fn a_console_block_with_a_command_that_fails_is_found() {
    let page = "```console\nedgegait render --no-such-flag\nedgegait --version\n```\n";
    run_page(Path::new("page"), page);
}

/// Returns the commands of a page: text between backticks and lines of code blocks that begin with
/// the command's name.
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
        "import", "bench", "score", "sweep", "train", "quantize", "cohort", "gate", "check",
    ] {
        assert!(helps.contains_key(name), "{name}");
    }
}

#[test]
fn the_files_that_the_guide_shows_can_be_read() {
    let mut read = [0; 5];
    for (path, text) in pages() {
        let toml = blocks(&text)
            .into_iter()
            .filter(|(kind, _)| *kind == "toml");
        for (_, block) in toml {
            let block = block.as_str();
            if block.contains("[views]") || block.contains("\nviews = {") {
                Design::parse(&path, block).expect("a design");
                read[2] += 1;
            } else if block.contains("[[limit]]") {
                holds(block);
                read[3] += 1;
            } else if block.contains("[[probes]]") {
                let folder = tempfile::tempdir().expect("a folder");
                let file = folder.path().join("protocol.toml");
                fs::write(&file, block).expect("written");
                Protocol::named(&file.display().to_string()).expect("a protocol");
                read[4] += 1;
            } else if block.contains("[[conditions]]") {
                Conditions::parse(&path, block).expect("conditions");
                read[0] += 1;
            } else {
                Contract::parse(&path, block).expect("a contract");
                read[1] += 1;
            }
        }
    }
    assert_eq!(read, [2, 2, 2, 3, 1]);
}

/// Checks good results against limits.
fn holds(limits: &str) {
    let folder = tempfile::tempdir().expect("a folder");
    let write =
        |name: &str, text: &str| fs::write(folder.path().join(name), text).expect("written");
    write("limits.toml", limits);
    let results = serde_json::json!({
        "schema": 1, "command": "score", "version": "0.1.0", "seed": 1, "inputs": [], "settings": {}, "warnings": [],
        "models": [{ "name": "mine", "p50_us": 5.0, "p99_us": 15.0 }],
        "benchmarks": [
            { "name": "draw/slow", "median_ns": 5.0, "measured_s": 4e9 },
            { "name": "draw/fast", "median_ns": 1.0, "measured_s": 4e9 },
        ],
        "recognizers": [{ "name": "mine", "rank1": 0.9, "probe_sets": [{ "name": "BG", "rank1": 0.7 }] }],
    });
    write("results.json", &results.to_string());
    let said = done(
        folder.path(),
        &["gate", "limits.toml", "results.json", "results.json"],
    );
    let expected = match limits.matches("[[limit]]").count() {
        1 => "the limit holds".to_owned(),
        // One of its three limits has two bounds.
        _ => "all 4 limits hold".to_owned(),
    };
    assert!(said.contains(&expected), "{said}");
}

/// Collects the keys of objects at any depth, except for those of settings.
fn keys(value: &serde_json::Value, found: &mut BTreeSet<String>) {
    match value {
        serde_json::Value::Object(object) => {
            for (key, value) in object {
                found.insert(key.clone());
                if key != "settings" {
                    keys(value, found);
                }
            }
        }
        serde_json::Value::Array(list) => list.iter().for_each(|value| keys(value, found)),
        _ => {}
    }
}

#[test]
fn the_keys_of_results_are_those_that_the_guide_lists() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let score = [
        "score",
        "side",
        "--subjects",
        "F01,F02,M01",
        "--views",
        "side",
        "--protocol",
        "first-take",
    ];
    done(
        at,
        &[&score[..], &["--json", "score.json", "--quiet"]].concat(),
    );
    let bench = [
        "bench",
        "side",
        "--window-s",
        "0.01",
        "--windows",
        "2",
        "--views",
        "side",
        "--batch",
        "1,2",
    ];
    done(
        at,
        &[&bench[..], &["--json", "bench.json", "--quiet"]].concat(),
    );
    let page = fs::read_to_string("src/guide/results.md").expect("the page");
    let (_, page) = page.split_once("## JSON results").expect("the section");
    let words: BTreeSet<&str> = page
        .split('`')
        .flat_map(|part| part.split([' ', ',', '(', ')']))
        .map(|word| word.trim_start_matches('.'))
        .collect();
    // The content of these describes the machine, or is self-explanatory.
    let inner = [
        "name",
        "version",
        "provider",
        "path",
        "sha256",
        "architecture",
        "cpus",
        "features",
        "affinity",
        "kernel",
        "libc",
        "model",
        "soc",
        "ram_bytes",
        "max_khz",
        "capacity",
        "part",
        "numbers",
        "governor",
        "current_khz",
        "temperature_c",
        "clocks",
        "throttled",
        "hottest_c",
        "windows_planned",
        "windows",
        "inferences_planned",
        "inferences",
        "warm_up_planned",
        "warm_up",
        "window_s_planned",
        "batch_planned",
        "viewpoints_planned",
        "macs_unknown",
        "full_seconds",
        "what",
        "genuine",
        "impostors",
        "non_finite_genuine",
        "non_finite_impostors",
        "eer_threshold",
        "far",
        "tar",
        "threshold",
        "note",
    ];
    for name in ["score.json", "bench.json"] {
        let text = fs::read_to_string(at.join(name)).expect("results");
        let value = serde_json::from_str(&text).expect("JSON");
        let mut found = BTreeSet::new();
        keys(&value, &mut found);
        assert!(found.len() > 30, "{found:?}");
        let is_told = |key: &&String| {
            let is_end = ["_low", "_high"].iter().any(|end| key.ends_with(end));
            is_end || words.contains(key.as_str()) || inner.contains(&key.as_str())
        };
        let untold: Vec<&String> = found.iter().filter(|key| !is_told(key)).collect();
        assert!(untold.is_empty(), "{name}: not in the guide: {untold:?}");
    }
}

#[test]
fn links_between_pages_lead_to_files() {
    let mut links = 0;
    for (path, text) in pages() {
        for link in text.split("](").skip(1) {
            let link = link.split(')').next().expect("a link's end");
            if link.contains("://") {
                continue;
            }
            let (file, anchor) = link.split_once('#').unwrap_or((link, ""));
            let to = if file.is_empty() {
                path.clone()
            } else {
                path.parent().expect("a folder").join(file)
            };
            assert!(to.exists(), "{}: {link}", path.display());
            if !anchor.is_empty() {
                let text = fs::read_to_string(&to).expect("a page");
                let is_there = anchors(&text).contains(anchor);
                assert!(is_there, "{}: no heading for {link}", path.display());
            }
            links += 1;
        }
    }
    assert!(links >= 100, "{links}");
}

#[test]
fn the_readme_is_short_and_leads_to_every_page() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let readme = fs::read_to_string(root.join("README.md")).expect("the README");
    assert!(readme.lines().count() <= 200, "{}", readme.lines().count());
    let words = readme.split_whitespace().count();
    assert!(words <= 1_500, "{words} words");
    let modules = fs::read_to_string(root.join("src/guide/mod.rs")).expect("the guide");
    for (path, _) in pages() {
        let name = path.file_name().expect("a name").to_string_lossy();
        if name != "README.md" {
            let link = format!("](src/guide/{name}");
            assert!(readme.contains(&link), "README.md: no link to {name}");
            let include = format!("\"/guide/{name}\"");
            assert!(modules.contains(&include), "mod.rs: no module of {name}");
        }
    }
}

/// Returns the anchors of a page's headings, as GitHub makes them.
fn anchors(text: &str) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    let mut is_code = false;
    for line in text.lines() {
        is_code ^= line.starts_with("```");
        if let Some(heading) = line.strip_prefix('#').filter(|_| !is_code) {
            let heading = heading.trim_start_matches('#').trim().to_lowercase();
            let kept = heading
                .chars()
                .filter(|c| c.is_alphanumeric() || [' ', '-', '_'].contains(c));
            found.insert(kept.collect::<String>().replace(' ', "-"));
        }
    }
    found
}
