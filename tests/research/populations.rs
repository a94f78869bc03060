//! Makes the table of bare and dressed people in src/guide/designs.md: training on them, tested on
//! people that other software rendered from skinned bodies in clothes.

use crate::command::done;
use crate::data::given;
use crate::means::{apart, mean_row, over_people};
use crate::people::{Seen, spans};
use crate::skinned::CHOICES;
use crate::walker::takes;
use edgegait::dataset::TreeLayout;
use edgegait::inference::{Model, Runtime};
use edgegait::{Dataset, Tree};
use edgegait_core::silhouette::Size;
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

/// The viewpoints of the other set: name, azimuth and elevation, degrees.
const VIEWS: [(&str, f64, f64); 5] = [
    ("000", 0.0, 0.0),
    ("045", 45.0, 0.0),
    ("090", 90.0, 0.0),
    ("135", 135.0, 0.0),
    ("090e15", 90.0, 15.0),
];

/// A GEI, from 0 to 255, with its person, take and viewpoint.
struct Shown {
    person: String,
    take: String,
    view: usize,
    gei: Vec<f64>,
    /// The embedding by a recognizer.
    embedding: Vec<f64>,
}

/// Returns the mean GEI of each person at a viewpoint.
fn people(shown: &[Shown], view: usize) -> BTreeMap<&str, Vec<f64>> {
    let mut of: BTreeMap<&str, Vec<&[f64]>> = BTreeMap::new();
    for one in shown.iter().filter(|one| one.view == view) {
        of.entry(&one.person).or_default().push(&one.gei);
    }
    of.into_iter()
        .map(|(person, geis)| (person, mean_row(geis.into_iter())))
        .collect()
}

/// Returns the share of probes, in percent, whose nearest GEI in the gallery that `is_gallery`
/// selects is of the same person.
fn rank1(
    shown: &[Shown],
    of: fn(&Shown) -> &[f64],
    is_probe: impl Fn(&Shown) -> bool,
    is_gallery: impl Fn(&Shown, &Shown) -> bool,
) -> (f64, f64) {
    let mut probes = Vec::new();
    for probe in shown.iter().filter(|probe| is_probe(probe)) {
        let gallery = shown.iter().filter(|other| is_gallery(probe, other));
        let nearest = gallery.min_by(|a, b| {
            let [a, b] = [a, b].map(|other| apart(of(other), of(probe)));
            a.total_cmp(&b)
        });
        if let Some(nearest) = nearest {
            let is_right = nearest.person == probe.person;
            probes.push((probe.person.as_str(), 100.0 * f64::from(u8::from(is_right))));
        }
    }
    over_people(probes)
}

/// Returns the cycles of the people for choices.
fn seen(data: &Path) -> Vec<Shown> {
    let tree = Tree::open(data.join("people/people"), &TreeLayout::default()).expect("a tree");
    let mut shown = Vec::new();
    for row in takes(data) {
        let view = VIEWS.iter().position(|view| row["view"] == view.0);
        let Some(view) = view.filter(|_| CHOICES.contains(&row["id"].as_str())) else {
            continue;
        };
        let seen = Seen::of(&tree, &row, Size::S50x30);
        for span in spans(&row["phase_cycles"]) {
            shown.push(Shown {
                person: row["id"].clone(),
                take: row["take"].clone(),
                view,
                gei: seen.gei(span),
                embedding: Vec::new(),
            });
        }
    }
    shown
}

/// The people of a design.
const COUNT: usize = 400;
/// The viewpoints of a design.
const FIXED: &str = "[views]\nazimuth_deg = [0, 45, 90, 135]\nelevation_deg = [0, 15]";
const RANDOM: &str = "[views]\nazimuth_deg = { uniform = [0, 180] }\nelevation_deg = { uniform = [0, 20] }\ncount = 8";

/// The populations: name, dressing, conditions, viewpoints.
const POPULATIONS: [(&str, &str, &str, &str); 5] = [
    ("bare", "never", "", FIXED),
    ("dressed for good", "for-good", "", FIXED),
    ("dressed per take", "per-take", "", FIXED),
    ("dressed per take, from anywhere", "per-take", "", RANDOM),
    (
        "domain-random, from anywhere",
        "never",
        "conditions = \"domain-random\"\n",
        RANDOM,
    ),
];

mod slow_of_data {
    use super::*;

    #[test]
    #[ignore = "slow without optimisation; needs EDGEGAIT_DATA"]
    fn recognizers_of_bare_dressed_and_random_people_on_those_of_other_software() {
        let data = given();
        let mut shown = seen(&data);
        let folder = tempfile::tempdir().expect("a folder");
        let at = folder.path();
        println!(
            "{} cycles of {} people for choices; {COUNT} made people",
            shown.len() / 5,
            CHOICES.len()
        );

        println!(
            "mean GEIs apart, of 255 (of people of the other set, one from the rest: mean); and how near the nearest made person is"
        );
        let mut rates = Vec::new();
        let pixels: fn(&Shown) -> &[f64] = |shown| &shown.gei;
        let embedded: fn(&Shown) -> &[f64] = |shown| &shown.embedding;
        for (name, dressed, conditions, views) in POPULATIONS {
            let design = format!(
                "seed = 11\n{conditions}\n[population]\npeople = \"0..{COUNT}\"\ndressed = \"{dressed}\"\n[walks]\nspeeds_kmh = {{ uniform = [3, 6], walks = 2 }}\ntakes = 2\n{views}\n[images]\nraster = \"rows\"\nlens = \"persp\"\ndistance_m = 6\n"
            );
            fs::write(at.join("design.toml"), design).expect("a design");
            done(
                at,
                &["generate", "design.toml", "--out", "made", "--overwrite"],
            );
            if views == FIXED {
                let made = Dataset::open(at.join("made")).expect("a dataset");
                let made: Vec<Shown> = made
                    .index()
                    .iter()
                    .enumerate()
                    .filter_map(|(index, row)| {
                        let view = VIEWS.iter().position(|view| {
                            (view.1, view.2) == (row.azimuth_deg, row.elevation_deg)
                        })?;
                        Some(Shown {
                            person: row.subject.clone(),
                            take: String::new(),
                            view,
                            gei: made.bytes(index).iter().copied().map(f64::from).collect(),
                            embedding: Vec::new(),
                        })
                    })
                    .collect();
                let cells = (0..VIEWS.len()).map(|view| {
                    let (made, seen) = (people(&made, view), people(&shown, view));
                    let mean =
                        |of: &BTreeMap<&str, Vec<f64>>| mean_row(of.values().map(Vec::as_slice));
                    let nearest: Vec<(&str, f64)> = seen
                        .iter()
                        .map(|(person, own)| {
                            let all = made.values().map(|other| apart(own, other));
                            (*person, all.fold(f64::MAX, f64::min))
                        })
                        .collect();
                    let (near, half) = over_people(nearest);
                    let means = apart(&mean(&made), &mean(&seen));
                    format!("{}: {means:.1}, {near:.1} +-{half:.1}", VIEWS[view].0)
                });
                println!("{name}: {}", cells.collect::<Vec<_>>().join("; "));
            }
            done(at, &["train", "made", "--out", "model.onnx", "--overwrite"]);
            let model = Model::open(at.join("model.onnx")).expect("a model");
            let recognizer = Runtime::rten().load(&model).expect("a model");
            for one in &mut shown {
                let input: Vec<f32> = one.gei.iter().map(|pixel| (pixel / 255.0) as f32).collect();
                let outputs = recognizer.run(&input, 1).expect("answers");
                one.embedding = outputs.embedding.iter().copied().map(f64::from).collect();
            }
            rates.push((name, rates_of(&shown, embedded)));
        }
        rates.insert(0, ("pixels", rates_of(&shown, pixels)));
        println!(
            "Rank-1, %, +- 95 % over people: another take from the same side (5 views); any take from 090, 045 and 000 among those from another side"
        );
        for (name, cells) in rates {
            let cells = cells.map(|(rate, half)| format!("{rate:>5.1} +-{half:>4.1}"));
            println!("{name:>32}: {}", cells.join(" | "));
        }
    }

    /// Returns rank-1 for another take; for other viewpoints together; and for 045 against 090, 000
    /// against 045 and 000 against 090.
    fn rates_of(shown: &[Shown], of: fn(&Shown) -> &[f64]) -> [(f64, f64); 5] {
        let has_more = |one: &Shown| {
            shown
                .iter()
                .any(|other| other.person == one.person && other.take != one.take)
        };
        let is_same = |a: &Shown, b: &Shown| a.person == b.person && a.take == b.take;
        let other_take = rank1(shown, of, has_more, |probe, other| {
            probe.view == other.view && !is_same(probe, other)
        });
        let across = |probe_view: usize, gallery_view: usize| {
            rank1(
                shown,
                of,
                |probe| probe.view == probe_view,
                |_, other| other.view == gallery_view,
            )
        };
        let all = rank1(shown, of, |_| true, |probe, other| probe.view != other.view);
        [other_take, all, across(1, 2), across(0, 1), across(0, 2)]
    }
}
