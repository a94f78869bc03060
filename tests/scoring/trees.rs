//! Trees whose views are cameras or recordings, and partitions of their people.

use crate::command::{done, edgegait, refused, text};
use edgegait::Tree;
use edgegait::dataset::TreeLayout;
use edgegait::draw::sweep::FramingMode;
use edgegait_core::silhouette::Size;
use serde_json::Value;
use std::fs;
use std::path::Path;

pub const DESIGN: &str = "seed = 3\n[walks]\ntakes = 3\ncycles = 2\n[views]\nazimuth_deg = [0, 60, 90]\nelevation_deg = [0]\n\
     [images]\nraster = \"rows\"\n[splits]\ntrain = \"0..2\"\ntest = \"2..6\"\n";

/// The views' new names, as in Gait3D.
const RECORDINGS: [(&str, &str); 3] = [("000", "seq0"), ("060", "seq1"), ("090", "seq2")];

pub fn words(command: &str) -> Vec<&str> {
    command.split_whitespace().collect()
}

/// Generates a tree of six people, three takes and three views, which are renamed to recordings.
pub fn tree(at: &Path, format: &str) {
    fs::write(at.join("d.toml"), DESIGN).expect("a design");
    let generate = format!("generate d.toml --format {format} --out tree");
    done(at, &words(&generate));
    for person in folders(&at.join("tree")) {
        for take in folders(&at.join("tree").join(&person)) {
            let take = at.join("tree").join(&person).join(take);
            for (old, new) in RECORDINGS {
                fs::rename(take.join(old), take.join(new)).expect("renamed");
            }
        }
    }
}

pub fn folders(path: &Path) -> Vec<String> {
    let entries = fs::read_dir(path).expect("a folder");
    let entries = entries.map(|entry| entry.expect("an entry"));
    let mut names: Vec<String> = entries
        .filter(|entry| entry.path().is_dir())
        .map(|entry| entry.file_name().to_string_lossy().into_owned())
        .collect();
    names.sort();
    names
}

/// Returns the names of each sequence and its GEI by definition: the mean of silhouettes.
pub fn geis(tree: &Path) -> Vec<(String, String, Vec<f64>)> {
    let tree = Tree::open(tree, &TreeLayout::default()).expect("a tree");
    let sequences = tree.sequences().iter().enumerate();
    sequences
        .map(|(at, one)| {
            let found = tree.silhouettes(at, Size::S50x30, FramingMode::Height);
            let found = found.expect("readable");
            let mean = |pixel: usize| {
                let column = found.pixels.iter().skip(pixel).step_by(1_500);
                let sum: u32 = column.map(|&byte| u32::from(byte)).sum();
                (f64::from(sum) / found.frames as f64).round()
            };
            let name = format!("{}-{}-{}", one.subject, one.take, one.view);
            (one.subject.clone(), name, (0..1_500).map(mean).collect())
        })
        .collect()
}

/// Returns the number of probes whose nearest neighbour in the gallery is the right person.
fn hits(
    tree: &Path,
    is_probe: impl Fn(&str) -> bool,
    is_known: impl Fn(&str) -> bool,
) -> (u64, u64) {
    let all = geis(tree);
    let distance =
        |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum() };
    let (mut probes, mut hits) = (0, 0);
    for (person, _, gei) in all.iter().filter(|(_, name, _)| is_probe(name)) {
        let nearest = all
            .iter()
            .filter(|(_, name, _)| is_known(name))
            .min_by(|a, b| distance(gei, &a.2).total_cmp(&distance(gei, &b.2)));
        probes += 1;
        hits += u64::from(nearest.expect("somebody").0 == *person);
    }
    (probes, hits)
}

fn score(at: &Path, flags: &str) -> Value {
    let command = format!("score pixels tree --whole-recordings --json - {flags}");
    serde_json::from_str(&done(at, &words(&command))).expect("JSON")
}

#[test]
fn a_partition_defines_gallery_and_probes() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    tree(at, "opengait");
    let made = fs::read_to_string(at.join("tree/partition.json")).expect("a partition");
    let made: Value = serde_json::from_str(&made).expect("JSON");
    let names = |set: &str| -> Vec<String> {
        let names = made[set].as_array().expect("a list").iter();
        names
            .map(|name| name.as_str().expect("a name").to_owned())
            .collect()
    };
    let (train, test) = (names("TRAIN_SET"), names("TEST_SET"));
    assert_eq!((train.len(), test.len()), (2, 4));
    let probes: Vec<String> = test
        .iter()
        .flat_map(|name| {
            [
                format!("{name}-walk-5kmh-02-seq1"),
                format!("{name}-walk-5kmh-03-seq2"),
            ]
        })
        .collect();
    let write = |name: &str, partition: Value| {
        fs::write(at.join(name), partition.to_string()).expect("written");
    };
    let partition = serde_json::json!({"TRAIN_SET": train, "TEST_SET": test, "PROBE_SET": probes});
    write("p.json", partition.clone());
    let found = score(at, "--partition p.json");
    let is_tested = |name: &str| test.iter().any(|one| name.starts_with(one.as_str()));
    let is_probe = |name: &str| probes.iter().any(|one| one == name);
    let expected = hits(&at.join("tree"), is_probe, |name| {
        is_tested(name) && !is_probe(name)
    });
    let result = &found["recognizers"][0];
    assert_eq!(found["settings"]["protocol"], "partition");
    assert_eq!(result["probes"], expected.0);
    let rate = expected.1 as f64 / expected.0 as f64;
    assert!((result["rank1"].as_f64().expect("a rate") - rate).abs() < 1e-12);
    assert_eq!(result["by_viewpoint"], serde_json::json!([]));
    let by_name = result["by_named_view"].as_array().expect("a list");
    let names: Vec<_> = by_name.iter().map(|one| one["view"].clone()).collect();
    assert_eq!(names, ["seq1", "seq2"]);
    assert_eq!(found["inputs"][0]["path"], "p.json");
    let page = fs::read_to_string(at.join("edgegait-report/index.html")).expect("a page");
    let mut page_words = page.split(|letter: char| !letter.is_alphanumeric());
    assert!(page.contains("seq1") && page_words.all(|word| word != "NaN"));

    // With only a gallery, all other sequences are probes.
    let gallery: Vec<String> = test
        .iter()
        .map(|name| format!("{name}-walk-5kmh-01-seq2"))
        .collect();
    write(
        "g.json",
        serde_json::json!({"TRAIN_SET": [], "TEST_SET": test, "GALLERY_SET": gallery}),
    );
    let found = score(at, "--partition g.json");
    let is_known = |name: &str| gallery.iter().any(|one| one == name);
    let expected = hits(
        &at.join("tree"),
        |name| is_tested(name) && !is_known(name),
        is_known,
    );
    assert_eq!(found["recognizers"][0]["probes"], expected.0);
    let rate = expected.1 as f64 / expected.0 as f64;
    assert!((found["recognizers"][0]["rank1"].as_f64().expect("a rate") - rate).abs() < 1e-12);

    // Without gallery and probes, the partition selects people for the usual protocol; each
    // recording is a view.
    write(
        "t.json",
        serde_json::json!({"TRAIN_SET": train, "TEST_SET": test}),
    );
    let found = score(
        at,
        "--partition t.json --protocol cross-view --probes-csv rows.csv",
    );
    let result = &found["recognizers"][0]["probe_sets"][0];
    // Four people, two takes at three views, each against the two other views.
    assert_eq!(result["probes"], 4 * 2 * 3 * 2);
    assert_eq!(
        result["cross_view"]["views"],
        serde_json::json!(["seq0", "seq1", "seq2"])
    );
    let rows = fs::read_to_string(at.join("rows.csv")).expect("a table");
    let mut lines = rows.lines();
    let columns: Vec<&str> = lines.next().expect("columns").split(',').collect();
    let first: Vec<&str> = lines.next().expect("a row").split(',').collect();
    let field = |name: &str| first[columns.iter().position(|it| *it == name).expect(name)];
    assert_eq!((field("azimuth_deg"), field("view")), ("", "seq0"));
    assert_eq!(field("gallery_view"), "seq1");

    // People and sequences that do not exist cause a warning, or an error if none exists.
    let mut more = partition;
    more["TEST_SET"]
        .as_array_mut()
        .expect("a list")
        .push("zoe".into());
    write("more.json", more);
    let output = edgegait(at, &words("score pixels tree --partition more.json"));
    let said = text(&output.stdout) + &text(&output.stderr);
    assert!(
        said.contains("TEST_SET: 1 of 5 names are not in the tree, first \"zoe\""),
        "{said}"
    );
    write(
        "none.json",
        serde_json::json!({"TRAIN_SET": [], "TEST_SET": ["zoe"]}),
    );
    for (flags, code, problem) in [
        (
            "--partition none.json",
            1,
            "TEST_SET: expected names that are in the tree",
        ),
        ("--partition d.toml", 1, "expected a partition"),
        ("--partition nowhere.json", 1, "nowhere.json: No such file"),
        ("--azimuth-deg 90", 2, "expected views named by angles"),
        ("--protocol partition", 1, "gallery"),
    ] {
        refused(
            at,
            &words(&format!("score pixels tree {flags}")),
            code,
            &[problem],
        );
    }
    done(at, &words("generate d.toml --out sets"));
    for flag in ["--partition t.json", "--named-views", "--modality sils"] {
        let command = format!("score pixels sets/test {flag}");
        refused(at, &words(&command), 2, &["expected a tree of silhouettes"]);
    }
}

/// A tree's GEIs, computed here by definition and given as arrays, train the same model.
#[test]
fn a_tree_trains_what_its_geis_train() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    tree(at, "opengait");
    let all = geis(&at.join("tree"));
    fs::create_dir(at.join("mine")).expect("made");
    let mut rows = "subject\n".to_owned();
    let mut numbers = Vec::new();
    for (person, _, gei) in &all {
        rows += &format!("{person}\n");
        numbers.extend(gei.iter().map(|&mean| mean as u8));
    }
    fs::write(at.join("mine/index.csv"), rows).expect("a table");
    edgegait::dataset::write_npy(at.join("mine/geis.npy"), &[all.len(), 50, 30], &numbers)
        .expect("an array");
    let train = "--components 8 --method svm";
    done(at, &words(&format!("train mine --out mine.onnx {train}")));
    done(
        at,
        &words(&format!(
            "train tree --whole-recordings --out tree.onnx {train}"
        )),
    );
    let model = |name: &str| fs::read(at.join(name)).expect("a model");
    // The models differ only by names in the graph, which have the same length.
    assert_eq!(model("mine.onnx").len(), model("tree.onnx").len());
    let differ = model("mine.onnx")
        .iter()
        .zip(model("tree.onnx"))
        .filter(|(a, b)| **a != *b)
        .count();
    assert!(differ <= 8, "{differ}");

    // The cycles of synthetic recordings are known: two of 32 frames in each.
    let score = |flags: &str| {
        let command = format!("score pixels tree --json - {flags}");
        let found: Value = serde_json::from_str(&done(at, &words(&command))).expect("JSON");
        found["geis"].as_u64().expect("a count")
    };
    let recordings = all.len() as u64;
    assert_eq!(
        score("--whole-recordings --protocol leave-one-take-out"),
        recordings
    );
    assert_eq!(score("--protocol leave-one-take-out"), 2 * recordings);

    // Training on a partition's training set, and testing on its test set.
    let command = "train tree --partition tree/partition.json --fps 25 --out part.onnx --components 4 --json -";
    let found: Value = serde_json::from_str(&done(at, &words(command))).expect("JSON");
    assert_eq!(found["classes"], 2);
    let score = "score part.onnx tree --partition tree/partition.json --protocol leave-one-take-out --json -";
    let found: Value = serde_json::from_str(&done(at, &words(score))).expect("JSON");
    assert_eq!(found["recognizers"][0]["people"], 4);
    for (flags, code, problem) in [
        ("tree --cycles 3", 2, "all gait cycles of a tree"),
        ("tree --raster rows", 2, "--raster: a folder is used whole"),
        ("tree --template silhouettes", 2, "one image or vector"),
        ("tree --fps 5", 2, "10 to 120"),
        ("mine --fps 25", 2, "--fps: expected a tree of silhouettes"),
        (
            "mine --partition tree/partition.json",
            2,
            "--partition: expected a tree",
        ),
    ] {
        refused(
            at,
            &words(&format!("train {flags} --out x.onnx")),
            code,
            &[problem],
        );
    }
    assert!(!at.join("x.onnx").exists());
}

#[test]
fn pictures_of_mixed_sizes_are_refused_before_any_is_read() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    tree(at, "casia-b");
    let person = folders(&at.join("tree")).pop().expect("somebody");
    let other = format!("tree/{person}/walk-5kmh-03/seq2/{person}-walk-5kmh-03-090-064.png");
    assert!(at.join(&other).exists());
    let picture = image::GrayImage::new(31, 50);
    picture.save(at.join(&other)).expect("written");
    let problem = "expected 50x30 pixels as in the frames before, found 50x31";
    refused(at, &words("score pixels tree"), 1, &[&other, problem]);
}
