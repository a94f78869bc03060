//! The baselines next to a recognizer, compared with distances that are computed here.

use crate::command::done;
use edgegait::evaluate::contest::{BaselineKind, Baselines};
use edgegait::people::cohort;
use edgegait::{
    CohortOptions, ContestOptions, DrawnContest, Entrant, Job, MAX_ERROR_MM, Model, Pack, Protocol,
    Runtime, Settings, Views, encode_subjects, sweep,
};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use serde_json::Value;
use std::path::Path;

/// The seed of the random projection.
const SEED: u64 = 5;
/// The numbers in the embedding of `side`: one fewer than its people.
const DIMS: usize = 25;

/// Returns the GEIs (pixels in 0..1) of this variation of the cohort's cycles, by person and
/// viewpoint.
fn geis(pack: &Pack<'_>, variation: u32, views: &Views) -> Vec<Vec<Vec<f64>>> {
    let jobs: Vec<Job<'_>> = (0..26).map(|walk| Job::plain(walk, variation)).collect();
    let mut all = Vec::new();
    let shares = |gei: &Vec<u8>| gei.iter().map(|&byte| f64::from(byte) / 255.0).collect();
    sweep(
        pack,
        &jobs,
        &views.list,
        Settings::default(),
        |_, swept| Ok(swept.templates.iter().map(shares).collect()),
        |_, geis| {
            all.push(geis);
            Ok(())
        },
    )
    .expect("drawn");
    all
}

/// Projects a GEI with the documented random matrix: normal numbers of variance 1 / [`DIMS`], row
/// by row.
fn projected(gei: &[f64]) -> Vec<f64> {
    let mut rng = ChaCha8Rng::seed_from_u64(SEED);
    let mut row = || -> f64 {
        let weights = gei.iter().map(|pixel| {
            let normal: f64 = StandardNormal.sample(&mut rng);
            pixel * normal / 5.0
        });
        weights.sum()
    };
    (0..DIMS).map(|_| row()).collect()
}

/// Returns the share of the probes, given by person, whose nearest entry is of the same person.
fn hits(known: &[Vec<f64>], probes: &[Vec<Vec<f64>>]) -> f64 {
    let apart =
        |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum() };
    let is_hit = |person: usize, probe: &[f64]| {
        let own = apart(&known[person], probe);
        (0..known.len()).all(|other| other == person || apart(&known[other], probe) > own)
    };
    let all = probes
        .iter()
        .enumerate()
        .flat_map(|(person, of)| of.iter().map(move |probe| is_hit(person, probe)));
    let (count, hits) = all.fold((0_usize, 0_usize), |(count, hits), hit| {
        (count + 1, hits + usize::from(hit))
    });
    hits as f64 / count as f64
}

#[test]
fn baselines_compare_with_the_training_or_the_gallery_of_a_recognizer() {
    let options = CohortOptions {
        speeds_kmh: vec![5.0],
        ..CohortOptions::default()
    };
    let people = cohort::subjects(&options).expect("people");
    let bytes = encode_subjects(&people, MAX_ERROR_MM, &|| Ok(())).expect("a pack");
    let pack = Pack::parse(&bytes).expect("its own bytes");
    let model = Path::new(env!("CARGO_MANIFEST_DIR")).join("models/side.onnx");
    let model = Model::open(&model).expect("a model");
    let views = Views::grid("four", [90.0, 60.0], [0.0, 25.0]).expect("angles");
    let side = Views::side().expect("angles");
    let walks: Vec<usize> = (0..26).collect();

    // `side` was trained on variations 0 to 7. Half of the 104 probes are 52 images, two of each
    // person.
    let seen = [0, 1].map(|variation| geis(&pack, variation, &side));
    let mean = |person: usize| -> Vec<f64> {
        let pairs = seen[0][person][0].iter().zip(&seen[1][person][0]);
        pairs.map(|(a, b)| 0.5 * (a + b)).collect()
    };
    // The closed set is probed with variation 1000.
    let probes = geis(&pack, 1000, &views);
    let closed: Vec<Vec<f64>> = (0..26).map(mean).collect();
    let enrolled: Vec<Vec<f64>> = (0..26).map(|person| seen[0][person][0].clone()).collect();

    for (protocol, known) in [("closed-set", closed), ("first-take", enrolled)] {
        let mut entrants =
            vec![Entrant::drawn(&model, &Runtime::rten(), Settings::default()).expect("side")];
        let options = ContestOptions {
            protocol: Some(Protocol::named(protocol).expect("a protocol")),
            views: Some(views.clone()),
            ..ContestOptions::default()
        };
        let drawn = DrawnContest::new(&pack, &walks, &entrants, options).expect("a contest");
        let Baselines {
            entrants: added,
            warnings,
        } = drawn
            .contest
            .baselines(
                &entrants,
                &[BaselineKind::Pixels, BaselineKind::Random],
                Some(&pack),
                SEED,
            )
            .expect("baselines");
        assert_eq!(warnings, [""; 0]);
        entrants.extend(added);
        let outcome = drawn
            .contest
            .run(&entrants, 1, &mut |_| Ok(()), &mut |_| Ok(()))
            .expect("results");
        let found: Vec<_> = outcome
            .results
            .iter()
            .map(|result| (result.name.as_str(), result.baseline, result.probes))
            .collect();
        assert_eq!(
            found,
            [
                ("side", false, 104),
                ("pixels", true, 104),
                ("random", true, 104)
            ]
        );
        let rates = [1, 2].map(|at: usize| outcome.results[at].rank1);
        let of = |map: &dyn Fn(&[f64]) -> Vec<f64>| {
            let known: Vec<_> = known.iter().map(|gei| map(gei)).collect();
            let probes: Vec<Vec<_>> = probes
                .iter()
                .map(|of| of.iter().map(|gei| map(gei)).collect())
                .collect();
            hits(&known, &probes)
        };
        assert_eq!(rates, [of(&<[f64]>::to_vec), of(&projected)], "{protocol}");
        // The rates are neither 0 nor 1, so that an error is noticed.
        assert!(
            rates.iter().all(|rate| (0.2..0.95).contains(rate)),
            "{protocol}: {rates:?}"
        );
    }
}

#[test]
fn baselines_are_in_results_unless_they_are_not_wanted_or_nobody_can_be_known() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    done(
        at,
        &[
            "cohort",
            "--speeds-kmh",
            "4",
            "--quick",
            "--out",
            "slow.egp",
        ],
    );
    let models = Path::new(env!("CARGO_MANIFEST_DIR")).join("models");
    let [side, spread] = ["side", "spread"].map(|it| models.join(it).with_extension("onnx"));
    let [side, spread] = [side.display().to_string(), spread.display().to_string()];
    let of = |arguments: &[&str]| -> (Vec<String>, String) {
        let score = ["score", "--views", "side", "--json", "-"];
        let text = done(at, &[&score, arguments].concat());
        let results: Value = serde_json::from_str(&text).expect("JSON");
        let mut names = Vec::new();
        for result in results["recognizers"].as_array().expect("a list") {
            let name = result["name"].as_str().expect("a name");
            let is_baseline = name.starts_with("pixels") || name.starts_with("random");
            assert_eq!(result["baseline"], is_baseline, "{name}");
            names.push(name.to_owned());
        }
        (names, results["warnings"].to_string())
    };
    assert_eq!(of(&[&side]).0, ["side", "pixels", "random"]);
    let both = of(&[&side, &spread]).0;
    let each = [
        "pixels as side",
        "random as side",
        "pixels as spread",
        "random as spread",
    ];
    assert_eq!(both, [&["side", "spread"][..], &each].concat());
    assert_eq!(of(&[&side, "--no-baselines"]).0, ["side"]);
    assert_eq!(of(&["pixels"]).0, ["pixels"]);
    assert_eq!(of(&["pixels", &side]).0, ["pixels", "side", "random"]);
    // `side` was trained on walks at 5 km/h.
    let (names, warnings) = of(&[&side, "slow.egp"]);
    assert_eq!(names, ["side"]);
    assert!(warnings.contains("no baselines beside it"), "{warnings}");
    // People that are enrolled by their takes need not occur in training.
    let first = of(&[&side, "slow.egp", "--protocol", "first-take"]).0;
    assert_eq!(first, ["side", "pixels", "random"]);
}
