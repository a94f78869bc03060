//! Tests of `edgegait study` on real input, six takes of three people, and its errors.

use crate::command::{done, names, refused};
use crate::data::fixtures;
use crate::people::{Seen, body, rows, spans};
use edgegait::dataset::TreeLayout;
use edgegait::{Dataset, Tree};
use edgegait_core::silhouette::Size;
use image::{GrayImage, imageops};
use serde_json::Value;
use std::fs;
use std::path::Path;

/// The rows and columns of a frame.
const FRAME: (u32, u32) = (240, 180);

/// Unpacks the silhouettes into a tree, `people`, with its tables next to it.
fn unpacked(at: &Path) {
    let study = fixtures().join("study");
    for name in names(&study.join("silhouettes")) {
        let all = image::open(study.join("silhouettes").join(&name)).expect("a picture");
        let all: GrayImage = all.to_luma8();
        let name = name.trim_end_matches(".png").replace('_', "/");
        let folder = at.join("people").join(name);
        fs::create_dir_all(&folder).expect("a folder");
        for frame in 0..all.height() / FRAME.0 {
            let one = imageops::crop_imm(&all, 0, frame * FRAME.0, FRAME.1, FRAME.0);
            let path = folder.join(format!("{:03}.png", frame + 1));
            one.to_image().save(path).expect("a file");
        }
    }
    for table in ["manifest.csv", "bodies.csv", "bodies_dressed.csv"] {
        fs::copy(study.join(table), at.join(table)).expect("a copy");
    }
}

/// Returns the command with these flags and the folders of recordings.
fn command(flags: &str) -> Vec<String> {
    let recordings = [fixtures().join("mocap"), fixtures().join("study")];
    let mut all = vec!["study".to_owned(), "people".to_owned()];
    all.extend(recordings.map(|folder| folder.display().to_string()));
    all.extend("--manifest manifest.csv".split(' ').map(str::to_owned));
    all.extend(flags.split(' ').map(str::to_owned));
    all
}

fn run(at: &Path, flags: &str) -> String {
    let command = command(flags);
    done(at, &command.iter().map(String::as_str).collect::<Vec<_>>())
}

fn refuses(at: &Path, flags: &str, expected: i32, words: &[&str]) {
    let command = command(flags);
    let command: Vec<&str> = command.iter().map(String::as_str).collect();
    refused(at, &command, expected, words);
}

fn json(path: &Path) -> Value {
    serde_json::from_str(&fs::read_to_string(path).expect("a file")).expect("JSON")
}

/// Returns the accuracy of an experiment with the most components, and that of the nearest pixels.
fn accuracy(study: &Value, masks: &str, experiment: &str, split: &Value) -> (f64, f64) {
    let all = study["recognition"].as_array().expect("experiments");
    let found = all.iter().find(|one| {
        one["masks"] == masks && one["experiment"] == experiment && &one["split"] == split
    });
    let found = found.expect(experiment);
    let last = found["points"].as_array().expect("points").last();
    let of = |point: &Value| point["accuracy"].as_f64().expect("a rate");
    (of(last.expect("a point")), of(&found["nearest"]))
}

/// Returns the share of real cycles whose nearest GEI of a twin is of the same person, computed
/// with `import` and `sweep` and the frames of the manifest.
fn found_by_hand(at: &Path) -> f64 {
    let mut twins: Vec<(String, Vec<u8>)> = Vec::new();
    let takes = rows(&at.join("manifest.csv"));
    let takes: Vec<_> = takes.iter().filter(|row| row["view"] == "090").collect();
    for body_of in &rows(&at.join("bodies.csv")) {
        let id = &body_of["id"];
        fs::write(at.join("body.csv"), body(body_of)).expect("a table");
        let own = takes.iter().filter(|row| &row["id"] == id);
        let clips = own.map(|row| {
            let places = ["mocap", "study"].map(|it| fixtures().join(it).join("clips"));
            let clip = places.map(|place| place.join(&row["source"]));
            let clip = clip.into_iter().find(|clip| clip.is_file());
            clip.expect("a clip").display().to_string()
        });
        let clips: Vec<String> = clips.collect();
        let import =
            format!("import --subject {id} --bodies body.csv --keep-going --overwrite --out w.egp");
        let import: Vec<&str> = import
            .split(' ')
            .chain(clips.iter().map(String::as_str))
            .collect();
        done(at, &import);
        let sweep = "sweep w.egp --raster rows --lens persp --distance-m 6 --frames-per-cycle 64 --views side --out w --overwrite";
        done(at, &sweep.split(' ').collect::<Vec<_>>());
        let made = Dataset::open(at.join("w")).expect("a dataset");
        twins.extend(made.templates().map(|gei| (id.clone(), gei.to_vec())));
    }
    let tree = Tree::open(at.join("people"), &TreeLayout::default()).expect("a tree");
    let (mut hits, mut all) = (0, 0);
    for row in takes {
        let seen = Seen::of(&tree, row, Size::S50x30);
        for span in spans(&row["phase_cycles"]) {
            let gei = seen.gei(span);
            let apart = |twin: &[u8]| -> f64 {
                let pairs = gei.iter().zip(twin);
                pairs.map(|(a, b)| (a - f64::from(*b)).powi(2)).sum()
            };
            let nearest = twins
                .iter()
                .min_by(|a, b| apart(&a.1).total_cmp(&apart(&b.1)));
            hits += u32::from(nearest.expect("a twin").0 == row["id"]);
            all += 1;
        }
    }
    assert_eq!(all, 12);
    f64::from(hits) / f64::from(all)
}

#[test]
fn real_silhouettes_are_compared_with_those_of_twins() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    unpacked(at);
    let said = run(at, "--views 090 --splits 2 --out study");
    for part in [
        "3 people",
        "Mean Jaccard index",
        "Subspaces",
        "Recognition:",
        "What separates S from R",
        "wrote study/index.html",
    ] {
        assert!(said.contains(part), "{part}: {said}");
    }
    let study = json(&at.join("study/study.json"));
    assert_eq!(study["people"], serde_json::json!(["101", "102", "104"]));
    let counts = &study["counts"][0];
    // Two whole cycles of each of six takes.
    assert_eq!(
        (&counts["real"], &counts["masks"]),
        (&12.into(), &"given".into())
    );
    assert!(counts["synthetic"].as_u64() >= Some(6));

    // Two cycles of one walk are more similar than two walks, and these more than a walk and its
    // twin's.
    let likeness = &study["similarity"][0];
    let mean = |group: &str| {
        likeness[group]["by_phase"]["mean"]
            .as_f64()
            .expect("a mean")
    };
    let means = ["same_take", "other_take", "synthetic"].map(mean);
    assert!(
        means[0] > means[1] && means[1] > means[2] && means[2] > 0.6,
        "{means:?}"
    );
    // The differences by row add up to 1 less the index.
    let rows = likeness["rows"].as_array().expect("rows").iter();
    let lost: f64 = rows
        .map(|row| row[0].as_f64().expect("a share") + row[1].as_f64().expect("a share"))
        .sum();
    assert!((lost - (1.0 - means[2])).abs() < 1e-3, "{lost} {means:?}");

    let angles = study["subspaces"][0]["angles_deg"]
        .as_array()
        .expect("angles");
    // One fewer than the smaller number of cycles, up to nine.
    let synthetic = counts["synthetic"].as_u64().expect("a count");
    assert_eq!(angles.len() as u64, (synthetic - 1).min(9));
    assert!(
        angles
            .windows(2)
            .all(|pair| pair[0].as_f64() <= pair[1].as_f64())
    );
    let (own, _) = accuracy(&study, "given", "R-R", &"cycle".into());
    // Three people with cycles of two walks each; guessing gives a third.
    assert!(own > 0.6, "{own}");
    let (_, nearest) = accuracy(&study, "given", "S-R", &Value::Null);
    let expected = found_by_hand(at);
    // Walks are encoded again, without a search, so the answer to one cycle may differ.
    assert!(
        (nearest - expected).abs() < 1.1 / 12.0,
        "{nearest} {expected}"
    );
    let orders = study["orders"].as_array().expect("orders");
    // Given and segmented masks, by cycle and by take.
    assert_eq!(orders.len(), 4);
    let prices = study["prices"].as_array().expect("prices");
    assert!(
        prices
            .iter()
            .any(|one| one["change"] == "bodies measured with clothes and hair")
    );

    let page = fs::read_to_string(at.join("study/index.html")).expect("a page");
    assert!(page.contains("The paper's order, and ours") && !page.contains("<script"));
    let figures = names(&at.join("study/figures"));
    for figure in [
        "accuracy-090-given-height-cycle.svg",
        "components-090.png",
        "likeness-090-segmented-height.svg",
        "overlays-090-given-height.png",
    ] {
        assert!(figures.iter().any(|name| name == figure), "{figures:?}");
    }

    // Results do not depend on threads, and an earlier study is replaced without a flag.
    run(at, "--views 090 --splits 2 --out study --threads 1");
    assert_eq!(json(&at.join("study/study.json")), study);
}

#[test]
fn without_real_silhouettes_the_synthetic_part_runs_and_says_what_is_lacking() {
    let folder = tempfile::tempdir().expect("a folder");
    let said = done(
        folder.path(),
        &["study", "--splits", "1", "--json", "s.json", "--out", "s"],
    );
    assert!(said.contains("warning: no real silhouettes"), "{said}");
    let study = json(&folder.path().join("s.json"));
    crate::limits::holds(folder.path(), "s.json");
    // JSON readers keep an arbitrary one of two equal keys.
    let text = fs::read_to_string(folder.path().join("s.json")).expect("results");
    assert_eq!(text.matches("\n  \"warnings\":").count(), 1);
    let all = study["recognition"].as_array().expect("experiments");
    assert!(all.iter().all(|one| one["experiment"] == "S-S") && all.len() == 6);
    assert_eq!(study["people"].as_array().map(Vec::len), Some(26));
    assert!(study["similarity"].as_array().is_some_and(Vec::is_empty));
    let page = fs::read_to_string(folder.path().join("s/index.html")).expect("a page");
    assert!(page.contains("nine principal components of S;"));
    assert!(!page.contains("of R (above)"));
}

#[test]
fn what_does_not_fit_together_is_refused_before_the_work() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    unpacked(at);
    let manifest = fs::read_to_string(at.join("manifest.csv")).expect("a manifest");
    let with = |text: &str| fs::write(at.join("manifest.csv"), text).expect("a manifest");

    with(&manifest.replace(",nm-06,", ",nm-07,"));
    let words = [
        "manifest.csv: ",
        "expected takes that are in people",
        "3 of 18 that are not: 101/nm-07/000",
    ];
    refuses(at, "--out a", 1, &words);
    with(
        &manifest
            .replace("\n101,", "\n9,")
            .replace("\n102,", "\n8,")
            .replace("\n104,", "\n7,"),
    );
    refuses(
        at,
        "--out a",
        1,
        &["found none: it has the people 101, 102, 104, the manifest has 9, 8, 7"],
    );
    with(&manifest.replace("08_02.amc", "08_03.amc"));
    refuses(
        at,
        "--out a",
        1,
        &[
            "manifest.csv:",
            "expected the recording cmu_amc/s08/08_03.amc in",
        ],
    );
    with(
        &manifest
            .replace(",45,0,", ",30,0,")
            .replacen(",30,0,", ",45,0,", 1),
    );
    refuses(
        at,
        "--out a",
        1,
        &["view \"045\": expected one camera for all its takes, found another in line"],
    );
    with(&manifest);

    refuses(
        at,
        "--subjects 101 --out a",
        1,
        &["expected two people or more to tell apart, found 101"],
    );
    refuses(
        at,
        "--subjects 101,anna --out a",
        2,
        &["no person \"anna\" in the manifest: expected one of 101, 102, 104"],
    );
    refuses(
        at,
        "--views 060 --out a",
        2,
        &["no view \"060\" in the manifest: expected one of 000, 045, 090"],
    );
    refuses(
        at,
        "--distance-m 0 --out a",
        2,
        &["--distance-m: expected 0.1 to"],
    );
    refuses(at, "--bodies none.csv --out a", 1, &["none.csv"]);
    // Frames of two sizes.
    let odd = at.join("people/102/nm-01/045/004.png");
    GrayImage::new(90, 120).save(&odd).expect("a file");
    refuses(at, "--out a", 1, &["004.png", "120x90"]);
    fs::remove_file(&odd).expect("removed");
    // A folder of figures that is not from a study.
    fs::create_dir_all(at.join("mine/figures")).expect("a folder");
    refuses(at, "--out mine", 2, &["--out mine: figures already exists"]);
    let error = ["study", "people", "--out", "a"];
    refused(at, &error, 2, &["--manifest"]);
    assert!(!at.join("a").exists());
}

#[test]
fn takes_whose_cycles_are_not_known_are_cut_or_listed() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    unpacked(at);
    // Without stated cycles, they are detected; a take of a few frames has none.
    let manifest = fs::read_to_string(at.join("manifest.csv")).expect("a manifest");
    fs::write(
        at.join("manifest.csv"),
        manifest.replace("phase_cycles", "unknown"),
    )
    .expect("one");
    let short = at.join("people/104/nm-02/090");
    for name in names(&short).iter().skip(12) {
        fs::remove_file(short.join(name)).expect("removed");
    }
    run(at, "--views 090 --splits 1 --out study");
    let study = json(&at.join("study/study.json"));
    let counts = &study["counts"][0];
    let without = counts["without"].as_array().expect("a list");
    assert_eq!(without.len(), 1, "{without:?}");
    let reason = without[0].as_str().expect("a reason");
    assert!(reason.starts_with("104/nm-02/090: "), "{reason}");
    assert!(counts["real"].as_u64() >= Some(5), "{counts}");
    let page = fs::read_to_string(at.join("study/index.html")).expect("a page");
    assert!(page.contains("Takes without a gait cycle") && page.contains("104/nm-02/090"));
}
