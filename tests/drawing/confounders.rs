//! Confounders in sweeps: strength 0, seeds, threads and combinations.

use crate::command::{done, refused};
use crate::npy::npy;
use crate::two::folder;
use edgegait::draw::confounders::{CATALOGUE, Condition, ConfounderKind, Dose, Doses, Stage};
use edgegait::draw::sweep::{FramingMode, Job, Lens, Raster, Settings, Swept, View, sweep};
use edgegait::encode::{MAX_ERROR_MM, encode_subjects};
use edgegait::people::cohort::{CohortOptions, subjects};
use edgegait_core::pack::Pack;
use edgegait_core::raster::Rasterizer;
use serde_json::Value;

/// Returns a pack of a woman and a man of the cohort, walking at 5 km/h.
fn pack() -> Vec<u8> {
    let options = CohortOptions {
        people: 2,
        speeds_kmh: vec![5.0],
        ..CohortOptions::default()
    };
    let people = subjects(&options).expect("a speed within the norms");
    encode_subjects(&people, MAX_ERROR_MM, &|| Ok(())).expect("two people fit a pack")
}

fn settings() -> Settings {
    Settings {
        rasterizer: Rasterizer::Rows.into(),
        frames_per_cycle: 16,
        ..Settings::default()
    }
}

fn views() -> Vec<View> {
    let angles = [(90.0, 0.0), (30.0, 20.0)];
    let view = |(azimuth, elevation)| View::new(azimuth, elevation).expect("a viewpoint");
    angles.map(view).to_vec()
}

/// Returns the GEIs of both people under a condition.
fn geis(pack: &[u8], condition: Option<&Condition>, settings: Settings) -> Vec<Vec<u8>> {
    let pack = Pack::parse(pack).expect("it was just made");
    let jobs = [0, 1].map(|walk| Job {
        condition,
        ..Job::plain(walk, 0)
    });
    let mut all = Vec::new();
    let keep = |_: Job<'_>, swept: Swept| Ok(swept.templates);
    let sink = |_: Job<'_>, geis: Vec<Vec<u8>>| {
        all.extend(geis);
        Ok(())
    };
    sweep(&pack, &jobs, &views(), settings, keep, sink).expect("walkers can be drawn");
    all
}

fn alone(kind: ConfounderKind, strength: f64) -> Condition {
    Condition::from_doses(Doses::new([Dose { kind, strength }]))
}

fn rmse(a: &[Vec<u8>], b: &[Vec<u8>]) -> f64 {
    let pairs = a.iter().flatten().zip(b.iter().flatten());
    let squares = pairs.map(|(&a, &b)| (f64::from(a) - f64::from(b)).powi(2));
    (squares.sum::<f64>() / a.iter().flatten().count() as f64).sqrt()
}

#[test]
fn at_strength_0_every_confounder_draws_the_unconfounded_bytes() {
    let pack = pack();
    let plain = geis(&pack, None, settings());
    for confounder in &CATALOGUE {
        let found = geis(&pack, Some(&alone(confounder.kind, 0.0)), settings());
        assert_eq!(found, plain, "{}", confounder.name);
    }
}

#[test]
fn as_strength_goes_to_0_every_effect_goes_to_nothing_and_at_1_all_have_one() {
    let pack = pack();
    let plain = geis(&pack, None, settings());
    for confounder in &CATALOGUE {
        let effect = |strength| {
            let condition = alone(confounder.kind, strength);
            rmse(&plain, &geis(&pack, Some(&condition), settings()))
        };
        let name = confounder.name;
        let little = effect(2e-4);
        assert!(little < 3.0, "{name}: {little} of 255 at 0.0002");
        let full = effect(1.0);
        assert!(
            full > 4.0 && full > 2.0 * little,
            "{name}: {full} at 1, {little} at 0.0002"
        );
        if confounder.is_signed {
            let opposite = effect(-1.0);
            assert!(opposite > 4.0, "{name}: {opposite} at -1");
        }
    }
}

#[test]
fn seeds_reproduce_and_threads_change_nothing() {
    let pack = pack();
    let one = rayon::ThreadPoolBuilder::new()
        .num_threads(1)
        .build()
        .expect("a thread");
    let three = rayon::ThreadPoolBuilder::new()
        .num_threads(3)
        .build()
        .expect("threads");
    let drawn = [
        ConfounderKind::DroppedFrames,
        ConfounderKind::StaticOccluder,
        ConfounderKind::MovingOccluder,
        ConfounderKind::Resolution,
        ConfounderKind::Light,
        ConfounderKind::Holes,
        ConfounderKind::MissingParts,
        ConfounderKind::MergedBackground,
        ConfounderKind::Waver,
        ConfounderKind::FilteredNoise,
        ConfounderKind::SaltAndPepper,
    ];
    for kind in drawn {
        let condition = alone(kind, 0.7);
        let first = one.install(|| geis(&pack, Some(&condition), settings()));
        let again = three.install(|| geis(&pack, Some(&condition), settings()));
        assert_eq!(first, again, "{kind:?}");
        let other = Condition {
            seed: 1,
            ..condition.clone()
        };
        assert_ne!(
            first,
            geis(&pack, Some(&other), settings()),
            "{kind:?}: its own seed"
        );
        let other = Settings {
            seed: 2,
            ..settings()
        };
        assert_ne!(
            first,
            geis(&pack, Some(&condition), other),
            "{kind:?}: the user's seed"
        );
    }
}

/// Returns whether a confounder is a second coat, or held in hands that hold a suitcase already.
fn is_too_much(kind: ConfounderKind) -> bool {
    matches!(
        kind,
        ConfounderKind::OpenCoat
            | ConfounderKind::DownJacket
            | ConfounderKind::Umbrella
            | ConfounderKind::CarriedBox
            | ConfounderKind::Stroller
    )
}

#[test]
fn all_confounders_act_together_within_the_budget() {
    let pack = pack();
    let together = CATALOGUE.iter().filter(|it| !is_too_much(it.kind));
    let all = together.clone().map(|confounder| Dose {
        kind: confounder.kind,
        strength: 0.6,
    });
    let condition = Condition::from_doses(Doses::new(all));
    let found = geis(&pack, Some(&condition), settings());
    assert!(rmse(&geis(&pack, None, settings()), &found) > 20.0);
    // All worn confounders, without those that remove parts of the figure, in every framing and
    // lens.
    let body = together.filter(|confounder| confounder.stage == Stage::Body);
    let worn = Condition::from_doses(Doses::new(body.map(|confounder| Dose {
        kind: confounder.kind,
        strength: 1.0,
    })));
    for (framing, lens) in [
        (FramingMode::Box, Lens::Ortho),
        (FramingMode::Cycle, Lens::Ortho),
        (FramingMode::Camera, Lens::Persp),
    ] {
        let settings = Settings {
            framing,
            lens,
            ..settings()
        };
        let geis = geis(&pack, Some(&worn), settings);
        assert!(geis.iter().all(|gei| gei.contains(&255)), "{framing:?}");
    }
}

#[test]
fn columns_draw_what_is_worn_and_how_it_moves_as_rows_do() {
    let pack = pack();
    for kind in [
        ConfounderKind::Coat,
        ConfounderKind::Backpack,
        ConfounderKind::AsymmetricGait,
        ConfounderKind::Slope,
    ] {
        let condition = alone(kind, 1.0);
        let of = |rasterizer: Raster| {
            let settings = Settings {
                rasterizer,
                framing: FramingMode::Cycle,
                ..settings()
            };
            geis(&pack, Some(&condition), settings)
        };
        let difference = rmse(&of(Raster::Columns), &of(Rasterizer::Rows.into()));
        assert!(difference < 0.5, "{kind:?}: {difference} of 255");
    }
}

#[test]
fn images_are_confounded_in_every_framing() {
    let pack = pack();
    for framing in [
        FramingMode::Height,
        FramingMode::Box,
        FramingMode::Cycle,
        FramingMode::Camera,
    ] {
        let settings = Settings {
            framing,
            ..settings()
        };
        let plain = geis(&pack, None, settings);
        let dilated = |strength| {
            let condition = alone(ConfounderKind::Dilation, strength);
            geis(&pack, Some(&condition), settings)
        };
        // A dilation of less than one sample of the fine image, which is then framed again, has no
        // effect.
        assert_eq!(dilated(0.01), plain, "{framing:?}");
        let full = rmse(&plain, &dilated(1.0));
        assert!(full > 4.0, "{framing:?}: {full}");
    }
}

#[test]
fn the_command_takes_conditions_and_says_which() {
    let folder = folder();
    let at = folder.path();
    let list = done(at, &["sweep", "--list-conditions"]);
    for confounder in &CATALOGUE {
        assert!(list.contains(confounder.name), "{}", confounder.name);
    }
    assert!(list.contains("--conditions casia-b") && list.contains("static-occlusion"));

    let sweep = [
        "sweep",
        "two.egp",
        "--views",
        "side",
        "--frames-per-cycle",
        "4",
        "--out",
    ];
    let swept = |out: &str, more: &[&str]| -> Vec<String> {
        let arguments: Vec<&str> = sweep.iter().chain(&[out]).chain(more).copied().collect();
        done(at, &arguments);
        let index = std::fs::read_to_string(at.join(out).join("index.csv")).expect("an index");
        let conditions = index.lines().skip(1).map(|line| line.split(',').nth(7));
        conditions
            .map(|field| field.expect("a condition").to_owned())
            .collect()
    };
    assert_eq!(swept("plain", &[]), ["normal"; 4]);
    let casia = swept("casia", &["--conditions", "casia-b"]);
    let of = |name: &str| casia.iter().filter(|condition| *condition == name).count();
    assert_eq!((of("NM"), of("BG"), of("CL")), (4, 4, 4));
    std::fs::write(
        at.join("mine.toml"),
        "[[conditions]]\nname = \"tilted\"\nconfounders = { roll = \"10 deg\", hat = 1 }\n",
    )
    .expect("a file");
    assert_eq!(swept("mine", &["--conditions", "mine.toml"]), ["tilted"; 4]);
    let manifest = std::fs::read_to_string(at.join("mine/manifest.json")).expect("a manifest");
    let manifest: Value = serde_json::from_str(&manifest).expect("JSON");
    let stated = &manifest["settings"]["conditions"][0];
    assert_eq!(stated["name"], "tilted");
    assert_eq!(stated["confounders"]["roll"], 0.5);
    assert!(manifest["inputs"].to_string().contains("mine.toml"));

    let refuse = |more: &[&str], exit, words: &[&str]| {
        let arguments: Vec<&str> = sweep.iter().chain(&["no"]).chain(more).copied().collect();
        refused(at, &arguments, exit, words);
        assert!(!at.join("no").exists());
    };
    refuse(&["--confound", "fog=1"], 2, &["fog", "backpack"]);
    refuse(&["--confound", "coat=2"], 2, &["coat", "0 to 1"]);
    refuse(
        &["--confound", "coat=1,coat=0.5"],
        2,
        &["coat appears twice"],
    );
    refuse(&["--conditions", "rain"], 2, &["rain", "casia-b"]);
    refuse(&["--conditions", "absent.toml"], 1, &["absent.toml"]);
    refuse(
        &["--confound", "holes=1", "--raster", "rows-3x3"],
        2,
        &["rows-3x3", "holes=1", "use --raster skia or rows"],
    );
    refuse(
        &[
            "--confound",
            "roll=1",
            "--raster",
            "columns",
            "--framing",
            "cycle",
        ],
        2,
        &["columns", "roll=1"],
    );
}

#[test]
fn the_index_names_the_alternative_that_each_person_drew() {
    let folder = folder();
    let at = folder.path();
    // The subject, walk, condition and alternative of a row, and its GEI.
    type Row = ([String; 4], Vec<u8>);
    let swept = |out: &str, flags: [&str; 2]| -> Vec<Row> {
        let common = "sweep two.egp --views side --frames-per-cycle 4 --raster rows --out";
        let arguments: Vec<&str> = common.split(' ').chain([out]).chain(flags).collect();
        done(at, &arguments);
        let mut index = csv::Reader::from_path(at.join(out).join("index.csv")).expect("a table");
        let pixels = npy(at.join(out).join("geis.npy")).1;
        let rows = index.records().map(|row| {
            let row = row.expect("a row");
            [0, 1, 7, 8].map(|field| row[field].to_owned())
        });
        rows.zip(pixels.chunks(1_500).map(<[u8]>::to_vec)).collect()
    };
    let mut drawn = std::collections::BTreeSet::new();
    for (row, gei) in swept("casia", ["--conditions", "casia-b"]) {
        let [subject, walk, condition, alternative] = &row;
        if condition == "NM" {
            assert_eq!(alternative, "");
            continue;
        }
        // The named confounder alone gives the same image.
        let alone = swept(alternative, ["--confound", alternative]);
        let own = alone
            .iter()
            .find(|(one, _)| (&one[0], &one[1]) == (subject, walk));
        let (own, expected) = own.expect("the same walk");
        assert_eq!((own[3].as_str(), &gei), ("", expected), "{row:?}");
        drawn.insert((condition.clone(), subject.clone(), alternative.clone()));
    }
    // One alternative for each person and condition, for all walks.
    assert_eq!(drawn.len(), 4, "{drawn:?}");
}

#[test]
fn casia_b_has_probes_with_bags_and_coats() {
    let folder = folder();
    let json = done(
        folder.path(),
        &[
            "score",
            "two.egp",
            "--walks",
            "walk-4kmh",
            "--protocol",
            "casia-b",
            "--azimuth-deg",
            "54,90",
            "--elevation-deg",
            "0",
            "--json",
            "-",
        ],
    );
    let results: Value = serde_json::from_str(&json).expect("JSON");
    let sets = results["recognizers"][0]["probe_sets"]
        .as_array()
        .expect("sets");
    let names: Vec<&str> = sets.iter().filter_map(|set| set["name"].as_str()).collect();
    assert_eq!(names, ["NM", "BG", "CL"]);
    // Two takes and two viewpoints of each person, compared with a gallery of two.
    let asked: Vec<u64> = sets
        .iter()
        .filter_map(|set| set["probes"].as_u64())
        .collect();
    assert_eq!(asked.len(), 3);
    assert!(
        asked.iter().all(|&count| count > 0 && count == asked[0]),
        "{asked:?}"
    );
    // Bags and coats are not pooled with normal walks, and the report shows them.
    let result = &results["recognizers"][0];
    assert_eq!(result["of_probe_sets"], serde_json::json!(["NM"]));
    assert_eq!(result["probes"], asked[0]);
    assert_eq!(result["rank1"], sets[0]["rank1"]);
    let page = std::fs::read_to_string(folder.path().join("edgegait-report/index.html"));
    let page = page.expect("a report");
    assert!(page.contains("the clean probe set NM, 1 of 3"));
}

#[test]
fn confounders_are_measured_by_strength_whatever_the_protocol() {
    let folder = folder();
    let measured = [
        "confounders",
        "pixels",
        "two.egp",
        "--walks",
        "walk-4kmh",
        "--only",
        "coat,roll",
        "--strengths",
        "0.5,1",
        "--cycles",
        "1",
        "--raster",
        "rows",
        "--out",
        "c.svg",
        "--json",
        "-",
    ];
    let printed = done(folder.path(), &measured);
    std::fs::write(folder.path().join("c.json"), &printed).expect("written");
    crate::limits::holds(folder.path(), "c.json");
    let results: Value = serde_json::from_str(&printed).expect("JSON");
    let strengths = |at: usize| -> Vec<f64> {
        let points = results["confounders"][at]["by_strength"]
            .as_array()
            .expect("points");
        points
            .iter()
            .filter_map(|point| point["strength"].as_f64())
            .collect()
    };
    assert_eq!(results["confounders"][0]["name"], "coat");
    assert_eq!(strengths(0), [0.0, 0.5, 1.0]);
    assert_eq!(strengths(1), [-1.0, -0.5, 0.0, 0.5, 1.0]);
    let effect =
        |point: usize| results["confounders"][0]["by_strength"][point]["gei_rmse"].as_f64();
    assert!(effect(0) == Some(0.0) && effect(1) > Some(4.0) && effect(2) > effect(1));
    assert_eq!(results["probes"], 2);
    let chart = std::fs::read_to_string(folder.path().join("c.svg")).expect("a chart");
    assert!(chart.starts_with("<svg xmlns=\"http://www.w3.org/2000/svg\""));
    assert!(chart.contains(">coat</text>") && chart.contains(">roll</text>"));
    std::fs::write(folder.path().join("other.svg"), "<svg></svg>").expect("a file");
    for (out, words) in [
        ("c.png", "--out c.png: expected a name that ends in .svg"),
        ("other.svg", "already exists, and is not known to be"),
    ] {
        let arguments = ["confounders", "two.egp", "--out", out];
        refused(folder.path(), &arguments, 2, &[words]);
    }
    refused(
        folder.path(),
        &["confounders", "two.egp", "--strengths", "0.5,0.5"],
        2,
        &["--strengths", "twice"],
    );
}
