//! Each recognizer has the results beside others that it has alone.

use crate::command::{done, names};
use crate::network::write_column_means;
use crate::rows::{results, row, rows, warnings, words};
use crate::two;
use serde_json::{Map, Value};
use std::fs;
use std::path::Path;

/// Recordings of two gait cycles of FRAMES frames: three people, two takes, two viewpoints.
const DESIGN: &str = "seed = 5\n[population]\npeople = \"0..3\"\n[walks]\ntakes = 2\ncycles = 2\n[views]\nazimuth_deg = [60, 90]\n\
     elevation_deg = [0]\n[images]\nraster = \"rows\"\nframes_per_cycle = FRAMES\n";

/// Orders of three recognizers: each is the first, and each comes before and after each other.
const ORDERS: [[usize; 3]; 3] = [[0, 1, 2], [1, 2, 0], [2, 1, 0]];

/// Returns the name in results of a model or a file.
fn name_of(model: &str) -> &str {
    model.trim_end_matches(".onnx")
}

/// Checks that each recognizer and its baselines have the same results alone as beside the others
/// in these orders, and returns those beside the others.
fn is_alike_alone(
    at: &Path,
    models: [&str; 3],
    orders: &[[usize; 3]],
    rest: &str,
) -> Vec<(String, Map<String, Value>)> {
    let score = |models: &[&str]| rows(&results(at, &format!("score {} {rest}", models.join(" "))));
    let alone = models.map(|model| score(&[model]));
    let mut last = Vec::new();
    for order in orders {
        let beside = score(&order.map(|at| models[at]));
        for (model, alone) in models.iter().zip(&alone) {
            let model = name_of(model);
            for (name, expected) in alone {
                let name = match name.as_str() {
                    own if own == model => own.to_owned(),
                    baseline => format!("{baseline} as {model}"),
                };
                let found = row(&beside, &name);
                for (key, value) in expected {
                    assert_eq!(&found[key], value, "{key} of {name} of {order:?}");
                }
            }
        }
        last = beside;
    }
    last
}

/// Returns the number of pictures in a tree.
fn pictures(tree: &Path) -> usize {
    let entries = fs::read_dir(tree).expect("a folder");
    let counts = entries.map(|entry| {
        let path = entry.expect("an entry").path();
        match path.is_dir() {
            true => pictures(&path),
            false => usize::from(path.extension().is_some_and(|end| end == "png")),
        }
    });
    counts.sum()
}

/// Writes the tree of the design, and returns the number of its pictures.
fn tree(at: &Path, frames: usize) -> usize {
    let design = DESIGN.replace("FRAMES", &frames.to_string());
    fs::write(at.join("d.toml"), design).expect("a design");
    done(
        at,
        &words("generate d.toml --format casia-b --out tree --overwrite"),
    );
    let pictures = pictures(&at.join("tree"));
    assert_eq!(pictures, 3 * 2 * 2 * 2 * frames);
    pictures
}

#[test]
fn a_recognizer_of_sequences_does_not_change_the_probes_of_one_of_templates() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let frames = tree(at, 8);
    write_column_means(at, "columns");
    let models = ["spread", "columns.onnx", "side"];
    let protocol = "--protocol leave-one-take-out";
    let found = is_alike_alone(at, models, &ORDERS, &format!("tree {protocol}"));
    // Templates are of cycles, sequences are recordings.
    for (model, probes) in [
        ("spread", frames / 8),
        ("columns", frames / 16),
        ("side", frames / 8),
        ("random as columns", frames / 16),
        ("pixels as side", frames / 8),
    ] {
        assert_eq!(row(&found, model)["probes"], probes, "{model}");
    }

    // The table says why, and compares only those that have the same probes.
    let score = format!("score spread columns.onnx side tree {protocol} --no-baselines");
    let three = results(at, &score);
    let said = warnings(&three);
    let why = "probes are whole recordings for columns, which take silhouettes, and their gait cycles for spread, side, which take templates";
    assert!(said.contains(why), "{said}");
    let pairs = three["paired"].as_array().expect("a list");
    assert_eq!(pairs.len(), 1, "{pairs:?}");
    let named = ["recognizer", "other"].map(|key| pairs[0][key].clone());
    assert!(named.iter().all(|name| *name != "columns"), "{named:?}");
    // From each of the two viewpoints, whichever recognizer is the best of all.
    let lead = pairs[0]["by_viewpoint"].as_array().expect("viewpoints");
    assert_eq!(lead.len(), 2);

    // With whole recordings, all have the same probes.
    let whole = results(at, &format!("{score} --whole-recordings"));
    assert!(!warnings(&whole).contains("probes are whole recordings"));
    for model in ["spread", "columns", "side"] {
        assert_eq!(row(&rows(&whole), model)["probes"], frames / 16);
    }

    // A tree without a manifest, of 30 frames a second or so: its cycles are searched.
    let frames = tree(at, 32);
    fs::remove_file(at.join("tree/manifest.json")).expect("a manifest");
    let rest = format!("tree {protocol} --fps 30 --no-baselines");
    let found = is_alike_alone(at, models, &ORDERS[..1], &rest);
    assert_eq!(row(&found, "columns")["probes"], frames / 64);
}

#[test]
fn filmed_people_are_probed_as_if_alone() {
    let folder = tempfile::tempdir().expect("a folder");
    let tree = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/people/people");
    let rest = format!("{} --fps 30 --protocol leave-one-take-out", tree.display());
    write_column_means(folder.path(), "columns");
    let models = ["columns.onnx", "side", "spread"];
    let found = is_alike_alone(folder.path(), models, &ORDERS[1..2], &rest);
    // Two takes of two people from one side.
    assert_eq!(row(&found, "columns")["probes"], 4);
}

#[test]
#[ignore = "needs EDGEGAIT_DATA"]
fn recordings_of_many_cycles_are_probed_as_if_alone_with_data() {
    let folder = tempfile::tempdir().expect("a folder");
    let data = std::env::var_os("EDGEGAIT_DATA").expect("EDGEGAIT_DATA");
    let tree = Path::new(&data).join("people/people");
    let people = "101,102,103,111";
    let rest = format!("{} --fps 30 --subjects {people}", tree.display());
    let models = ["gei-small", "gaitset-small", "side"];
    let found = is_alike_alone(folder.path(), models, &ORDERS[1..2], &rest);
    // Each person's first take is enrolled, and the others are probes, from five viewpoints.
    let takes = people
        .split(',')
        .map(|person| names(&tree.join(person)).len());
    let probes: usize = takes.map(|takes| 5 * (takes - 1)).sum();
    assert_eq!(row(&found, "gaitset-small")["probes"], probes);
    let cycles = row(&found, "gei-small")["probes"]
        .as_u64()
        .expect("a count");
    assert!(cycles > 2 * probes as u64, "{cycles} of {probes}");
}

#[test]
fn recognizers_beside_each_other_are_scored_as_alone_on_packs_and_arrays() {
    let folder = two::folder();
    let at = folder.path();
    write_column_means(at, "columns");
    let models = ["side", "spread", "columns.onnx"];
    let found = is_alike_alone(
        at,
        models,
        &ORDERS,
        "two.egp --azimuth-deg 60,90 --protocol first-take --raster rows",
    );
    // The second walk of two people from two viewpoints.
    assert_eq!(row(&found, "spread")["probes"], 4);
    done(
        at,
        &words("sweep two.egp --azimuth-deg 60,90 --raster rows --out set"),
    );
    let models = ["side", "spread", "other.onnx"];
    let train = "train two.egp --components 2 --azimuth-deg 45,90 --raster rows --out other.onnx";
    done(at, &words(train));
    let found = is_alike_alone(at, models, &ORDERS, "set --protocol leave-one-take-out");
    assert_eq!(row(&found, "side")["probes"], 8);
}

/// The gallery is seen from the training viewpoints of each recognizer, and its takes are probes
/// too: those from the viewpoints that are asked for, not from others' training viewpoints.
#[test]
fn the_training_viewpoints_of_others_are_no_probes() {
    let folder = two::folder();
    let at = folder.path();
    fs::write(
        at.join("own.toml"),
        "name = \"own\"\ndescription = \"All takes.\"\ndecision = \"nearest embedding\"\ngallery_views = \"training\"\n\
         exclude_own_take = true\n[gallery]\n[[probes]]\nname = \"all\"\n",
    )
    .expect("a protocol");
    let rest = "two.egp --azimuth-deg 60 --protocol own.toml --raster rows";
    write_column_means(at, "columns");
    let found = is_alike_alone(at, ["side", "spread", "columns.onnx"], &ORDERS[1..], rest);
    for model in ["side", "spread", "columns", "pixels as spread"] {
        assert_eq!(row(&found, model)["probes"], 4, "{model}");
    }
}

#[test]
fn what_is_asked_for_besides_leaves_a_viewpoint_a_person_and_a_condition_as_they_are() {
    let folder = two::folder();
    let at = folder.path();
    let score = |flags: &str| {
        let rest = "two.egp --protocol leave-one-take-out --raster rows --no-baselines";
        results(at, &format!("score side {rest} {flags}"))["recognizers"][0].clone()
    };
    let of_view = |scored: &Value, azimuth: f64| {
        let all = scored["by_viewpoint"].as_array().expect("a list").clone();
        let found = all.into_iter().find(|one| one["azimuth_deg"] == azimuth);
        found.expect("the viewpoint")
    };
    let one = score("--azimuth-deg 60");
    for more in ["60,90", "90,60", "0,60,120"] {
        let more = score(&format!("--azimuth-deg {more}"));
        assert_eq!(of_view(&more, 60.0), of_view(&one, 60.0));
    }
    let conditions = |names: &[&str]| {
        let each = names.iter().map(|name| match *name {
            "bag" => "[[conditions]]\nname = \"bag\"\nconfounders = { backpack = 0.5 }\n",
            _ => "[[conditions]]\nname = \"shaky\"\nconfounders = { roll = 0.3, missing-parts = 0.4 }\n",
        });
        fs::write(at.join("c.toml"), each.collect::<String>()).expect("conditions");
        let scored = score("--azimuth-deg 60 --conditions c.toml");
        let sets = scored["probe_sets"].as_array().expect("sets").clone();
        let of = |name: &str| {
            let found = sets
                .iter()
                .find(|set| set["name"].as_str().is_some_and(|set| set.contains(name)));
            found.expect("a set").clone()
        };
        names.iter().map(|name| of(name)).collect::<Vec<Value>>()
    };
    let [bag, shaky] = [conditions(&["bag"]), conditions(&["shaky"])];
    assert_eq!(
        conditions(&["bag", "shaky"]),
        [bag.clone(), shaky.clone()].concat()
    );
    assert_eq!(conditions(&["shaky", "bag"]), [shaky, bag].concat());
}
