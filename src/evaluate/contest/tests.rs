use super::*;
use crate::dataset::TreeLayout;
use crate::draw::sweep::Settings;
use crate::evaluate::testing::{Gei, write_geis};
use crate::inference::RuntimeName;
use crate::inference::{InputRange, Outputs, Recognizer};

/// A recognizer that answers with the first two pixels of a GEI, as embedding and as class scores,
/// or with NaN where the first pixel is 13.
struct FirstTwoPixels {
    contract: Contract,
    runtime: RuntimeName,
}

impl Recognizer for FirstTwoPixels {
    fn runtime(&self) -> &RuntimeName {
        &self.runtime
    }

    fn contract(&self) -> &Contract {
        &self.contract
    }

    fn run(&self, geis: &[f32], _batch: usize) -> Result<Outputs> {
        let two: Vec<f32> = geis
            .chunks(self.contract.numbers())
            .flat_map(|gei| [gei[0], gei[1]])
            .map(|pixel| if pixel == 13.0 { f32::NAN } else { pixel })
            .collect();
        Ok(Outputs {
            scores: Some(two.clone()),
            embedding: two,
            embedding_dims: 2,
            embedding_parts: 1,
            classes: 2,
            non_finite: 0,
        })
    }
}

const FRONT: (f64, f64) = (0.0, 0.0);
const SIDE: (f64, f64) = (90.0, 0.0);

fn outcome(protocol: &str, classes: &[&str], geis: &[Gei<'_>]) -> Result<ContestOutcome> {
    let folder = tempfile::tempdir().expect("a folder");
    let dir = folder.path().join("geis");
    write_geis(&dir, geis)?;
    let protocol = Protocol::named(protocol)?;
    let contest = Contest::new(
        SequenceSource::open(&dir, &protocol.made, &TreeLayout::default())?,
        protocol,
    )?;
    let entrant = Entrant {
        recognizer: Box::new(FirstTwoPixels {
            contract: Contract {
                input_range: InputRange::Byte,
                classes: classes.iter().map(|&name| name.to_owned()).collect(),
                ..Contract::default()
            },
            runtime: RuntimeName {
                name: "test".into(),
                version: "1".into(),
                provider: String::new(),
            },
        }),
        settings: Settings::default(),
        model_bytes: None,
    };
    contest.run(&[entrant], 1, &mut |_| Ok(()), &mut |_| Ok(()))
}

#[test]
fn people_with_classes_are_recognized_by_the_highest_score() {
    let geis = [
        // The source's order of people is not the model's order of classes.
        ("bob", "w", SIDE, (1, 9)),
        ("ann", "w", FRONT, (9, 1)),
        ("ann", "w", SIDE, (1, 9)),
    ];
    let outcome = outcome("closed-set", &["ann", "bob"], &geis).expect("three probes");
    let result = &outcome.results[0];
    assert_eq!((result.probes, result.classes), (3, 2));
    assert!((result.rank1 - 2.0 / 3.0).abs() < 1e-12);
    let by_view: Vec<_> = result
        .by_viewpoint
        .iter()
        .map(|view| (view.azimuth_deg, view.probes, view.rank1))
        .collect();
    assert_eq!(by_view, [(90.0, 2, 0.5), (0.0, 1, 1.0)]);
    // The wrong class is second of two.
    assert_eq!(result.probe_sets[0].cmc[1], 1.0);
    assert_eq!((outcome.sequences, outcome.shown.silhouettes), (3, 96));
}

#[test]
fn people_without_classes_are_recognized_by_the_nearest_enrolled() {
    let geis = [
        ("ann", "1", SIDE, (0, 0)),
        // Not a training viewpoint, so it is not in the gallery.
        ("ann", "1", FRONT, (200, 0)),
        ("cid", "1", SIDE, (200, 0)),
        ("ann", "2", SIDE, (90, 0)),
        ("ann", "2", SIDE, (110, 0)),
    ];
    let outcome = outcome("first-take", &[], &geis).expect("two probes");
    let result = &outcome.results[0];
    assert_eq!(result.protocol, "first-take");
    assert_eq!((result.probes, result.rank1, result.classes), (2, 0.5, 2));
    assert_eq!(outcome.sequences, 4);
}

#[test]
fn a_cycle_of_the_same_take_cannot_vouch_for_the_probe() {
    // On a line: two cycles of a take next to each other, their person's other take far off,
    // and another person between them.
    let geis = [
        ("ann", "1", SIDE, (0, 0)),
        ("ann", "1", SIDE, (1, 0)),
        ("bob", "1", SIDE, (10, 0)),
        ("bob", "2", SIDE, (15, 0)),
        ("ann", "2", SIDE, (90, 0)),
        // Seen from elsewhere, and therefore no help.
        ("ann", "2", FRONT, (0, 0)),
    ];
    let outcome = outcome("leave-one-take-out", &[], &geis).expect("six probes");
    let set = &outcome.results[0].probe_sets[0];
    assert_eq!((set.probes, set.without_mate), (6, 1));
    assert!((set.rank1 - 2.0 / 6.0).abs() < 1e-12, "{}", set.rank1);
}

#[test]
fn each_pair_of_viewpoints_is_a_cell_and_the_identical_ones_do_not_count() {
    let geis = [
        ("ann", "01", FRONT, (0, 0)),
        ("bob", "01", FRONT, (100, 0)),
        ("ann", "01", SIDE, (60, 0)),
        ("bob", "01", SIDE, (20, 0)),
        ("ann", "00", FRONT, (10, 0)),
        ("bob", "00", FRONT, (90, 0)),
        ("ann", "00", SIDE, (0, 0)),
        ("bob", "00", SIDE, (30, 0)),
    ];
    let outcome = outcome("ou-mvlp", &[], &geis).expect("four probes");
    let result = &outcome.results[0];
    let cells = result.probe_sets[0].cross_view.as_ref().expect("a matrix");
    // Front probes: both are recognized in the front gallery, neither in the side gallery (60, 20).
    // Side probes: ann (0) is recognized in the front gallery (0, 100), bob (30) is not; in the
    // side gallery, bob is.
    assert_eq!(
        cells.rank1,
        [[Some(1.0), Some(0.0)], [Some(0.5), Some(0.5)]]
    );
    assert_eq!(cells.by_probe_view_percent, [0.0, 50.0]);
    assert_eq!(cells.mean_percent, Some(25.0));
    assert_eq!((result.probes, result.rank1), (4, 0.25));
}

#[test]
fn what_is_not_finite_is_a_miss_or_left_out_of_the_gallery_and_counted() {
    let geis = [
        ("ann", "1", SIDE, (0, 0)),
        ("bob", "1", SIDE, (13, 0)),
        ("ann", "2", SIDE, (13, 0)),
        ("ann", "2", SIDE, (50, 0)),
        ("bob", "2", SIDE, (50, 0)),
    ];
    let found = outcome("first-take", &[], &geis).expect("three probes");
    let result = &found.results[0];
    assert_eq!((result.probes, result.non_finite), (3, 1));
    assert_eq!(result.gallery_non_finite, 1);
    assert!(
        found.warnings[0]
            .text
            .contains("1 embeddings of the gallery")
    );
    let set = &result.probe_sets[0];
    // Bob has no mate in the gallery; ann's other probe is right, since only she is enrolled.
    assert_eq!((set.without_mate, set.non_finite), (1, 1));
    assert!((set.rank1 - 1.0 / 3.0).abs() < 1e-12);
    assert_eq!(set.map, Some(1.0));
    let nobody = [("ann", "1", SIDE, (13, 0)), ("ann", "2", SIDE, (1, 0))];
    let error = outcome("first-take", &[], &nobody).err();
    assert!(error.is_some_and(|error| error.to_string().contains("no embedding of the gallery")));
}

#[test]
fn an_absent_set_of_probes_is_warned_of_and_strangers_to_a_model_are_refused() {
    let geis = [
        ("ann", "nm-01", FRONT, (0, 0)),
        ("ann", "nm-05", SIDE, (0, 0)),
    ];
    let found = outcome("casia-b", &[], &geis).expect("one probe");
    let warned = |text: &str| {
        found
            .warnings
            .iter()
            .any(|warning| warning.text.contains(text))
    };
    assert!(
        warned("probe set BG") && warned("probe set CL"),
        "{:?}",
        found.warnings
    );
    assert!(warned("no take is called \"nm-02\"") && warned("no take is called \"nm-06\""));
    assert!(warned("one person only") && warned("one person to choose from"));
    let error = outcome("closed-set", &["bob"], &geis).err();
    assert!(error.is_some_and(|error| error.to_string().contains("no class is called \"ann\"")));
}

#[test]
fn a_recognizer_that_answers_the_same_to_all_ties_and_that_is_said() {
    let geis = [
        ("ann", "1", SIDE, (5, 5)),
        ("bob", "1", SIDE, (5, 5)),
        ("ann", "2", SIDE, (5, 5)),
        ("bob", "2", SIDE, (5, 5)),
    ];
    let found = outcome("first-take", &[], &geis).expect("two probes");
    let set = &found.results[0].probe_sets[0];
    // Ties go to the person listed first: ann.
    assert_eq!(
        (set.tied, set.probes, set.people, set.rank1),
        (2, 2, 2, 0.5)
    );
    let verification = set.verification.as_ref().expect("four pairs");
    assert_eq!((verification.eer, verification.auc), (Some(0.5), Some(0.5)));
    assert!(
        found.warnings[0]
            .text
            .contains("2 of 2 answers are as near to another")
    );
}

#[test]
fn probes_that_meet_nobody_are_refused() {
    let geis = [
        ("ann", "nm-01", SIDE, (0, 0)),
        ("ann", "nm-05", SIDE, (0, 0)),
    ];
    let error = outcome("casia-b", &[], &geis).err();
    assert!(error.is_some_and(|error| error.to_string().contains("no probe has a gallery")));
}

#[test]
fn results_lead_with_the_clean_probes_and_do_not_pool_walks_with_bags() {
    let geis = [
        ("ann", "nm-01", FRONT, (0, 0)),
        ("bob", "nm-01", FRONT, (100, 0)),
        ("ann", "nm-05", SIDE, (1, 0)),
        ("bob", "nm-05", SIDE, (99, 0)),
        // With bags each looks like the other, and one answer is not finite.
        ("ann", "bg-01", SIDE, (99, 0)),
        ("bob", "bg-01", SIDE, (1, 0)),
        ("bob", "bg-02", SIDE, (13, 0)),
    ];
    let found = outcome("casia-b", &[], &geis).expect("five probes");
    let result = &found.results[0];
    assert_eq!(result.of_probe_sets, ["NM"]);
    assert_eq!((result.probes, result.people, result.rank1), (2, 2, 1.0));
    let by_view: Vec<_> = result
        .by_viewpoint
        .iter()
        .map(|view| (view.azimuth_deg, view.probes, view.rank1))
        .collect();
    assert_eq!(by_view, [(90.0, 2, 1.0)]);
    let sets: Vec<_> = result
        .probe_sets
        .iter()
        .map(|set| (set.name.as_str(), set.clean, set.probes, set.rank1))
        .collect();
    assert_eq!(sets, [("NM", true, 2, 1.0), ("BG", false, 3, 0.0)]);
    // Non-finite answers of all probe sets are counted.
    assert_eq!(result.non_finite, 1);
    // Without a clean probe all are pooled, and the result names the sets.
    let bags = [&geis[..2], &geis[4..6]].concat();
    let found = outcome("casia-b", &[], &bags).expect("two probes");
    let result = &found.results[0];
    assert_eq!(result.of_probe_sets, ["BG"]);
    assert_eq!((result.probes, result.rank1), (2, 0.0));
}
