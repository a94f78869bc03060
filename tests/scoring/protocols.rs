//! Protocols in the command: the same people give the same results from any source.

use crate::command::{done, refused};
use crate::data::fixtures;
use crate::two::folder;
use serde_json::Value;
use std::path::Path;

/// The columns of `--probes-csv` that tests use.
#[derive(serde::Deserialize)]
struct Answer {
    probe_set: String,
    subject: String,
    take: String,
    walk: String,
    cycle: u32,
    variation: u32,
    answer: String,
    rank: usize,
    distance: Option<f64>,
    right_distance: Option<f64>,
    score: Option<f64>,
    right_score: Option<f64>,
}

/// Returns the results of a command with `--json -`.
fn found(at: &Path, arguments: &[&str]) -> Value {
    let text = done(at, &[arguments, &["--json", "-"]].concat());
    serde_json::from_str(&text).expect("JSON")
}

/// Writes a pack of four people at three speeds, and a protocol for them.
fn four_people(at: &Path) {
    let cohort = ["cohort", "--people", "4", "--speeds-kmh", "4,5,6"];
    done(at, &[&cohort[..], &["--out", "four.egp"]].concat());
    std::fs::write(
        at.join("speeds.toml"),
        "name = \"speeds\"\ndescription = \"Known at 4, looked for at 5 and 6 km/h.\"\n\
         decision = \"nearest embedding\"\ngallery_views = \"each\"\n\
         [gallery]\ntakes = [\"walk-4kmh\"]\n\
         [[probes]]\nname = \"5\"\ntakes = [\"walk-5kmh\"]\n\
         [[probes]]\nname = \"6\"\ntakes = [\"walk-6*\"]\n",
    )
    .expect("written");
}

const VIEWS: [&str; 6] = [
    "--azimuth-deg",
    "0,45,90",
    "--elevation-deg",
    "0",
    "--raster",
    "rows",
];

#[test]
fn people_whom_no_model_has_seen_are_sought_on_another_day() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let score = ["score", "side", "--protocol", "sessions"];
    let views = ["--azimuth-deg", "60,90", "--elevation-deg", "0"];
    let results = found(at, &[&score[..], &views].concat());
    assert_eq!(results["warnings"], serde_json::json!([]));
    let picture = std::fs::read_to_string(at.join("edgegait-report/speed-error.svg"));
    assert!(picture.expect("a picture").starts_with("<svg "));
    let recognizers = results["recognizers"].as_array().expect("a list");
    let names: Vec<_> = recognizers.iter().map(|result| &result["name"]).collect();
    assert_eq!(names, ["side", "pixels", "random"]);
    for result in recognizers {
        let sets = result["probe_sets"].as_array().expect("a list");
        let names: Vec<_> = sets.iter().map(|set| &set["name"]).collect();
        assert_eq!(names, ["normal", "bag", "coat"]);
        for set in sets {
            // One probe of each person from either viewpoint, sought from the other one.
            assert_eq!((&set["probes"], &set["people"]), (&60.into(), &30.into()));
        }
        let rank1 = |value: &Value| value["rank1"].as_f64().expect("a rate");
        let same = rank1(&sets[0]["cross_view"]["same_view"]);
        assert!(same > 0.8 && same > rank1(&sets[0]), "{same}");
    }
    assert_eq!(results["recognizers"][0]["model_bytes"], 153_212);
    // Everybody walked on one day only.
    done(
        at,
        &[
            "cohort",
            "--people",
            "2",
            "--speeds-kmh",
            "4,5",
            "--out",
            "day.egp",
        ],
    );
    let words = ["protocol sessions", "probes", "walk-4kmh, walk-5kmh"];
    let score = ["score", "side", "day.egp", "--protocol", "sessions"];
    refused(at, &score, 1, &words);
}

#[test]
fn a_pack_and_a_dataset_of_it_score_alike_under_a_protocol_of_ones_own() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    four_people(at);
    done(
        at,
        &[&["sweep", "four.egp", "--out", "four"], &VIEWS[..]].concat(),
    );
    let score = |data: &str, more: &[&str]| {
        let common = ["score", "pixels", data, "--protocol", "speeds.toml"];
        found(at, &[&common[..], more].concat())["recognizers"][0].clone()
    };
    let drawn = score("four.egp", &VIEWS);
    let read = score("four", &[]);
    assert_eq!(drawn["probe_sets"], read["probe_sets"]);
    assert_eq!(drawn["by_viewpoint"].as_array().map(Vec::len), Some(3));
    let sets = drawn["probe_sets"].as_array().expect("a list");
    let names: Vec<_> = sets.iter().map(|set| set["name"].clone()).collect();
    assert_eq!(names, ["5", "6"]);
    for set in sets {
        // 4 people from 3 viewpoints, each against 2 other viewpoints with 4 images.
        assert_eq!(set["probes"], 4 * 3 * 2);
        assert_eq!(set["verification"]["genuine"], 4 * 3 * 2);
        assert_eq!(set["verification"]["impostors"], 4 * 3 * 2 * 3);
        assert_eq!(set["cross_view"]["rank1"].as_array().map(Vec::len), Some(3));
        assert!(set["cross_view"]["mean_percent"].is_number());
    }
    let same_view = |set: &Value| {
        let cells = set["cross_view"]["rank1"].as_array().expect("a matrix");
        (0..3)
            .map(|at| cells[at][at].as_f64().expect("a rate"))
            .sum::<f64>()
            / 3.0
    };
    // The answers add up to the rates.
    let common = ["score", "pixels", "four", "--protocol", "speeds.toml"];
    done(at, &[&common[..], &["--probes-csv", "probes.csv"]].concat());
    let mut rows = csv::Reader::from_path(at.join("probes.csv")).expect("a table");
    let rows: Vec<Answer> = rows.deserialize().map(|row| row.expect("a row")).collect();
    assert_eq!(rows.len(), 2 * 4 * 3 * 2);
    for (set, name) in sets.iter().zip(["5", "6"]) {
        let of_set = rows.iter().filter(|row| row.probe_set == name);
        let hits = of_set
            .clone()
            .filter(|row| row.subject == row.answer)
            .count();
        let first = of_set.filter(|row| row.rank == 1).count();
        assert_eq!(hits as f64 / 24.0, set["rank1"].as_f64().expect("a rate"));
        assert_eq!(hits, first);
    }
    // Rank-1 is higher from the same viewpoint than from others.
    assert!(same_view(&sets[0]) > sets[0]["rank1"].as_f64().expect("a rate"));
}

#[test]
fn shipped_protocols_make_takes_of_one_walk_and_say_so() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    four_people(at);
    let score = |protocol: &str| {
        let arguments = ["score", "pixels", "four.egp", "--walks", "walk-5kmh"];
        let more = ["--protocol", protocol, "--raster", "rows"];
        found(at, &[&arguments[..], &more].concat())
    };
    for (protocol, probes) in [
        // The factors are people, takes, viewpoints and other viewpoints. The count is of NM; BG
        // and CL are other probe sets.
        ("casia-b", 4 * 2 * 11 * 10),
        ("ou-mvlp", 4 * 14 * 13),
        ("cross-view", 4 * 13 * 12),
        ("verification", 4 * 3 * 7),
    ] {
        let results = score(protocol);
        assert_eq!(results["recognizers"][0]["probes"], probes, "{protocol}");
        assert_eq!(results["recognizers"][0]["protocol"], protocol);
        let warning = results["warnings"][0].as_str().unwrap_or_default();
        assert!(
            warning.contains("seeded variations"),
            "{protocol}: {results}"
        );
    }
    refused(
        at,
        &["score", "pixels", "four.egp", "--protocol", "casia-b"],
        1,
        &["no take is in its gallery", "walk-4kmh"],
    );
    refused(
        at,
        &["score", "pixels", "four.egp", "--protocol", "nonsense"],
        2,
        &["casia-b", ".toml"],
    );
    let rows = (0..1025).map(|at| format!("{},{}\n", at % 180, at / 180));
    let many = rows.fold(String::from("azimuth_deg,elevation_deg\n"), |all, row| {
        all + &row
    });
    std::fs::write(at.join("many.csv"), many).expect("written");
    refused(
        at,
        &[
            "score",
            "pixels",
            "four.egp",
            "--protocol",
            "cross-view",
            "--views",
            "many.csv",
        ],
        1,
        &["at most 1024"],
    );
}

/// Writes the silhouettes of a pack's walks as a tree of 64x64 images.
fn write_tree(pack: &Path, root: &Path) {
    use edgegait::draw::sweep::{Job, Moments, Settings, Shot, View, silhouettes};
    use edgegait_core::pack::Pack;
    use edgegait_core::silhouette::Size;
    let bytes = std::fs::read(pack).expect("a pack");
    let pack = Pack::parse(&bytes).expect("it was just made");
    let settings = Settings {
        size: Size::S64x64,
        ..Settings::default()
    };
    let views = [0.0, 45.0, 90.0].map(|azimuth| View::new(azimuth, 0.0).expect("a viewpoint"));
    let subjects: Vec<&str> = pack.subjects().map(|subject| subject.name).collect();
    for (number, walk) in pack.walks().enumerate() {
        let shot = Shot {
            job: Job::plain(number, 0),
            moments: Moments::Cycle,
            views: &views,
        };
        let seen = silhouettes(&pack, shot, settings).expect("drawn");
        for (view, frames) in ["000", "045", "090"].iter().zip(seen) {
            let folder = root.join(subjects[walk.subject]).join(walk.name).join(view);
            std::fs::create_dir_all(&folder).expect("a folder");
            for (at, frame) in frames.iter().enumerate() {
                let pixels = frame.to_coverage().pixels().to_vec();
                image::GrayImage::from_raw(64, 64, pixels)
                    .expect("64x64")
                    .save(folder.join(format!("{at:03}.png")))
                    .expect("written");
            }
        }
    }
}

#[test]
fn a_tree_of_pictures_scores_like_the_walks_that_they_show() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    four_people(at);
    write_tree(&at.join("four.egp"), &at.join("tree"));
    // From the front, a found cycle may be a few frames shorter than the one that was drawn.
    for person in ["F01", "F02", "M01", "M02"] {
        for kmh in 4..=6 {
            let walk = at.join(format!("tree/{person}/walk-{kmh}kmh"));
            std::fs::remove_dir_all(walk.join("000")).expect("a view");
        }
    }
    let score = |data: &str, more: &[&str]| {
        let common = ["score", "pixels", data, "--protocol", "speeds.toml"];
        let size = ["--size", "64x64"];
        found(at, &[&common[..], &size, more].concat())["recognizers"][0].clone()
    };
    let views = ["--azimuth-deg", "45,90", "--elevation-deg", "0"];
    let (drawn, read) = (score("four.egp", &views), score("tree", &[]));
    // Images that are framed already give the same bits when framed again or used as stored. People
    // have another order, on which the resampled intervals depend.
    let stored = score("tree", &["--as-stored"]);
    for set in 0..2 {
        for key in ["cross_view", "cmc"] {
            let of = |result: &Value| result["probe_sets"][set][key].clone();
            assert_eq!(of(&drawn), of(&read), "{key}");
            assert_eq!(of(&drawn), of(&stored), "{key}");
        }
        // Means, which the order of people rounds.
        for key in ["map", "minp"] {
            let of = |result: &Value| result["probe_sets"][set][key].as_f64().expect("a mean");
            assert!((of(&drawn) - of(&read)).abs() < 1e-12, "{key}");
            assert!((of(&drawn) - of(&stored)).abs() < 1e-12, "{key}");
        }
        let curve = |result: &Value| result["probe_sets"][set]["verification"]["roc"].clone();
        assert!(curve(&drawn) == curve(&stored), "another ROC");
    }
    let common = ["score", "pixels", "four.egp", "--as-stored"];
    refused(at, &common, 2, &["expected a tree of silhouettes"]);
    std::fs::write(at.join("tree/F01/walk-4kmh/045/000.png"), b"no picture").expect("written");
    let common = ["score", "pixels", "tree", "--protocol", "speeds.toml"];
    refused(at, &common, 1, &["000.png", "--keep-going"]);
}

#[test]
fn an_unreadable_image_costs_its_sequence_with_keep_going() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    four_people(at);
    write_tree(&at.join("four.egp"), &at.join("tree"));
    write_tree(&at.join("four.egp"), &at.join("less"));
    let score = |data: &str, more: &[&str]| {
        let common = ["score", "pixels", data, "--protocol", "speeds.toml"];
        found(at, &[&common[..], more].concat())
    };
    let keep_going = ["--keep-going"];
    let whole = score("tree", &keep_going);
    assert_eq!(whole["warnings"], score("tree", &[])["warnings"]);

    std::fs::write(at.join("tree/F01/walk-4kmh/000/000.png"), b"no picture").expect("written");
    std::fs::write(at.join("tree/M01/walk-6kmh/090/000.pkl"), b"no pickle").expect("written");
    let lost = ["F01/walk-4kmh/000", "M01/walk-6kmh/090"];
    for sequence in lost {
        assert!(at.join("tree").join(sequence).is_dir(), "{sequence}");
        std::fs::remove_dir_all(at.join("less").join(sequence)).expect("removed");
    }
    let (found, expected) = (score("tree", &keep_going), score("less", &[]));
    assert_eq!(
        found["recognizers"][0]["probe_sets"],
        expected["recognizers"][0]["probe_sets"]
    );
    let said: Vec<&str> = found["warnings"]
        .as_array()
        .expect("a list")
        .iter()
        .filter_map(Value::as_str)
        .filter(|one| one.contains("left out"))
        .collect();
    assert_eq!(said.len(), 3, "{said:?}");
    assert!(
        said[0].starts_with("left out: tree/F01/walk-4kmh/000/000.png: cannot be read"),
        "{said:?}"
    );
    assert!(
        said[1].starts_with("left out: tree/M01/walk-6kmh/090: "),
        "{said:?}"
    );
    assert!(
        said[2].starts_with("2 of ") && said[2].ends_with(" sequences were left out"),
        "{said:?}"
    );
    for threads in ["1", "2"] {
        let again = score("tree", &["--keep-going", "--threads", threads]);
        assert_eq!(again["warnings"], found["warnings"], "{threads} threads");
    }

    for entry in walkdir(&at.join("less")) {
        std::fs::write(entry, b"no picture").expect("written");
    }
    let score = [
        "score",
        "pixels",
        "--protocol",
        "speeds.toml",
        "--keep-going",
    ];
    refused(
        at,
        &[&score[..], &["less"]].concat(),
        1,
        &["sequences cannot be read", "000.png"],
    );
    refused(
        at,
        &[&score[..], &["four.egp"]].concat(),
        2,
        &["--keep-going: expected a tree"],
    );
}

/// Returns the files in a folder and below it.
fn walkdir(folder: &Path) -> Vec<std::path::PathBuf> {
    let mut files = Vec::new();
    for entry in std::fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            files.extend(walkdir(&path));
        } else {
            files.push(path);
        }
    }
    files
}

#[test]
fn a_row_of_a_probe_states_its_source_and_keeps_scores_apart_from_distances() {
    let folder = folder();
    let at = folder.path();
    let rows = |arguments: &[&str]| -> Vec<Answer> {
        let csv = ["--probes-csv", "rows.csv", "--raster", "rows"];
        done(at, &[arguments, &csv].concat());
        let mut table = csv::Reader::from_path(at.join("rows.csv")).expect("a table");
        table.deserialize().map(|row| row.expect("a row")).collect()
    };
    let train = ["train", "two.egp", "--views", "side", "--cycles", "2"];
    done(
        at,
        &[&train[..], &["--components", "3", "--out", "m.onnx"]].concat(),
    );
    let score = ["score", "m.onnx", "two.egp", "--views", "side"];
    for row in rows(&[&score[..], &["--protocol", "closed-set"]].concat()) {
        assert_eq!(
            (row.take.as_str(), row.cycle, row.variation),
            ("probe", 0, 1000)
        );
        assert!(
            ["walk-4kmh", "run-8kmh"].contains(&row.walk.as_str()),
            "{}",
            row.walk
        );
        assert!(row.distance.is_none() && row.right_distance.is_none());
        // The answer is the class with the highest score.
        assert!(row.score >= row.right_score && row.right_score.is_some());
    }
    let nearest = [
        "score",
        "pixels",
        "two.egp",
        "--views",
        "side",
        "--protocol",
        "first-take",
    ];
    for row in rows(&nearest) {
        assert_eq!(
            (row.take.as_str(), row.walk.as_str()),
            ("run-8kmh", "run-8kmh")
        );
        assert_eq!((row.cycle, row.variation), (0, 0));
        assert!(row.distance <= row.right_distance && row.distance.is_some());
        assert!(row.score.is_none() && row.right_score.is_none());
    }
}

#[test]
fn probes_that_training_was_shown_or_that_vary_what_it_was_shown_are_warned_of() {
    let folder = folder();
    let at = folder.path();
    let train = |walks: &str, out: &str| {
        let common = ["train", "two.egp", "--views", "side", "--cycles", "2"];
        let rest = ["--walks", walks, "--components", "3", "--out", out];
        done(at, &[&common[..], &rest].concat());
    };
    train("walk-4kmh", "walk.onnx");
    let warned = |arguments: &[&str]| -> Vec<String> {
        let results = found(
            at,
            &[&["score", "walk.onnx", "--no-baselines"], arguments].concat(),
        );
        let warnings = results["warnings"].as_array().expect("a list");
        let texts = warnings
            .iter()
            .map(|text| text.as_str().expect("text").to_owned());
        texts.filter(|text| text.contains("trained on")).collect()
    };
    let varied = |count: &str| {
        format!(
            "walk: {count} probes are seeded variations of cycles that it was trained on, not other walks: rank-1 shows only its robustness to noise and viewpoint"
        )
    };
    // A pack: variation 1000 of the training's walk, and a run that was not in training.
    let walks = ["two.egp", "--views", "side", "--walks"];
    assert_eq!(
        warned(&[&walks[..], &["walk-4kmh"]].concat()),
        [varied("2 of 2")]
    );
    assert_eq!(
        warned(&[&walks[..], &["walk-4kmh,run-8kmh"]].concat()),
        [varied("2 of 4")]
    );
    assert_eq!(warned(&[&walks[..], &["run-8kmh"]].concat()), [""; 0]);
    // By embeddings, with one take each, and with two, of which the run is the probe.
    let first_take = ["--protocol", "first-take"];
    assert_eq!(
        warned(&[&walks[..], &["walk-4kmh"], &first_take].concat()),
        [varied("2 of 2")]
    );
    assert_eq!(warned(&[&walks[..3], &first_take].concat()), [""; 0]);
    // Datasets of the same cycles, and of others.
    for (first, expected) in [
        ("0", "walk: 4 of 8 probes show cycles that it was trained on, judging by the names of people and walks (use other walks as probes)".to_owned()),
        ("1000", varied("4 of 8")),
    ] {
        let sweep = ["sweep", "two.egp", "--views", "side", "--cycles", "2", "--out", "d"];
        done(at, &[&sweep[..], &["--first-cycle", first]].concat());
        assert_eq!(warned(&["d", "--protocol", "closed-set"]), [expected]);
    }
}

/// Two people with two takes each; one take of each is the gallery.
#[test]
fn silhouettes_that_others_made_are_scored() {
    let tree = fixtures().join("people/people");
    let folder = tempfile::tempdir().expect("a folder");
    let score = [
        "score",
        "pixels",
        tree.to_str().expect("UTF-8"),
        "--json",
        "-",
    ];
    let results: Value = serde_json::from_str(&done(folder.path(), &score)).expect("JSON");
    let pixels = &results["recognizers"][0];
    assert_eq!(pixels["rank1"], 1.0, "{pixels}");
    assert_eq!(pixels["probe_sets"][0]["probes"], 2, "{pixels}");
}
