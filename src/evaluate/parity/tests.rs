//! Tests with sides whose answers are functions of two pixels.

use super::*;
use crate::dataset::TreeLayout;
use crate::dataset::sequences::{SequenceSource, ViewLabel};
use crate::draw::sweep::Settings;
use crate::evaluate::protocol::Protocol;
use crate::evaluate::testing::{Gei, write_geis};
use crate::inference::RuntimeName;
use crate::inference::testing::small_model;
use crate::inference::{Contract, InputRange, Outputs, Recognizer};

/// A recognizer that answers with a function of the first two pixels, as embedding and as class
/// scores.
struct OfTwoPixels {
    contract: Contract,
    runtime: RuntimeName,
    function: fn(f32, f32) -> Vec<f32>,
}

impl Recognizer for OfTwoPixels {
    fn runtime(&self) -> &RuntimeName {
        &self.runtime
    }

    fn contract(&self) -> &Contract {
        &self.contract
    }

    fn run(&self, geis: &[f32], batch: usize) -> Result<Outputs> {
        let each = geis.chunks(self.contract.numbers());
        let all: Vec<f32> = each
            .flat_map(|gei| (self.function)(gei[0], gei[1]))
            .collect();
        Ok(Outputs {
            embedding_dims: all.len() / batch,
            embedding_parts: 1,
            classes: all.len() / batch,
            scores: Some(all.clone()),
            embedding: all,
            non_finite: 0,
        })
    }
}

fn entrant(name: &str, function: fn(f32, f32) -> Vec<f32>) -> Entrant {
    Entrant {
        recognizer: Box::new(OfTwoPixels {
            contract: Contract {
                name: name.into(),
                input_range: InputRange::Byte,
                classes: vec!["ann".into(), "bob".into()],
                ..Contract::default()
            },
            runtime: RuntimeName::default(),
            function,
        }),
        settings: Settings::default(),
        model_bytes: None,
    }
}

const FRONT: (f64, f64) = (0.0, 0.0);
const SIDE: (f64, f64) = (90.0, 0.0);
/// GEIs in which ann has the higher first pixel, and bob the higher second one.
const GEIS: [Gei<'_>; 4] = [
    ("ann", "w", FRONT, (9, 1)),
    ("ann", "w", SIDE, (8, 2)),
    ("bob", "w", FRONT, (1, 9)),
    ("bob", "w", SIDE, (2, 8)),
];

/// Compares the second side with the first, with limits for float.
fn compared(others: [fn(f32, f32) -> Vec<f32>; 2]) -> Result<(Vec<ParitySide>, Comparison)> {
    let folder = tempfile::tempdir().expect("a folder");
    let dir = folder.path().join("geis");
    write_geis(&dir, &GEIS)?;
    let protocol = Protocol::named("closed-set")?;
    let source = SequenceSource::open(&dir, &protocol.made, &TreeLayout::default())?;
    let contest = Contest::new(source, protocol)?;
    let entrants = [entrant("a", others[0]), entrant("b", others[1])];
    let answered = SideAnswers::run(&contest, &entrants, 1, &mut |_| Ok(()))?;
    assert_eq!(answered.sequences(), 4);
    let mut sides = vec![ParitySide::new(&small_model(), RuntimeName::default()); 2];
    for (at, side) in sides.iter_mut().enumerate() {
        answered.complete(side, at);
    }
    let comparison = answered.compare(&sides, 1, Limits::FLOAT);
    Ok((sides, comparison))
}

fn plain(first: f32, second: f32) -> Vec<f32> {
    vec![first, second]
}

#[test]
fn equal_answers_are_the_same_in_every_number() {
    let (sides, found) = compared([plain, plain]).expect("two sides");
    assert_eq!((found.verdict, found.reasons.len()), (Verdict::Same, 0));
    // The single output is both the embedding and the scores.
    assert_eq!(found.scores, None);
    let embedding = found.embedding.expect("finite");
    assert_eq!((embedding.inputs, embedding.greatest), (4, 0.0));
    // The mean is (5, 5): two lie (4, 4) from it and two (3, 3).
    assert_eq!(embedding.spread, 25.0_f64.sqrt());
    assert!(found.worst.is_empty());
    assert_eq!(sides[1].rank1, Some(1.0));
}

#[test]
fn one_input_that_differs_is_found_with_its_person_and_viewpoint() {
    // Bob from the side, (2, 8), is identified as ann.
    let other = |first, second| {
        if first == 2.0 {
            vec![12.0, second]
        } else {
            vec![first, second]
        }
    };
    let (_, found) = compared([plain, other]).expect("two sides");
    assert_eq!(found.verdict, Verdict::Differs);
    let embedding = found.embedding.expect("finite");
    assert_eq!((embedding.greatest, embedding.mean), (10.0, 10.0 / 8.0));
    assert_eq!(
        (embedding.greatest_relative, embedding.mean_relative),
        (2.0, 0.5)
    );
    let expected = InputDifference {
        subject: "bob".into(),
        take: "w".into(),
        view: ViewLabel::Angles(90.0, 0.0),
        relative: Some(2.0),
    };
    assert_eq!(found.worst, [expected]);
    let means = |parts: &[ParityPart]| -> Vec<(String, f64)> {
        let each = parts.iter();
        each.map(|part| (part.name.clone(), part.mean_relative))
            .collect()
    };
    let expected = [("ann".to_owned(), 0.0), ("bob".to_owned(), 1.0)];
    assert_eq!(means(&found.by_subject), expected);
    let expected = [("0".to_owned(), 0.0), ("90".to_owned(), 1.0)];
    assert_eq!(means(&found.by_view), expected);
    let ranks = found.ranks.expect("finite");
    assert_eq!((ranks.other_answers, ranks.lost, ranks.gained), (1, 1, 0));
    assert_eq!((ranks.rank1_of_reference, ranks.rank1), (1.0, 0.75));
    assert_eq!(
        found.reasons,
        [
            "the greatest relative difference of embeddings is 2.000e0, more than 0.0002",
            "the mean relative difference of embeddings is 5.000e-1, more than 0.0002",
            "1 of 4 probes are identified correctly by one side only, more than 0.1 %"
        ]
    );
}

#[test]
fn a_number_that_is_not_finite_differs_even_from_another_such() {
    let broken = |first, second| {
        if first == 9.0 {
            vec![f32::NAN, second]
        } else {
            vec![first, second]
        }
    };
    let (sides, found) = compared([broken, broken]).expect("two sides");
    assert_eq!(found.verdict, Verdict::Differs);
    // Once in the embedding and once in the scores.
    assert_eq!((sides[0].non_finite, sides[0].numbers), (2, 16));
    assert_eq!(found.reasons.len(), 2);
    assert!(found.reasons[0].ends_with("2 of 16 numbers are NaN or infinite"));
    assert_eq!(found.embedding.expect("three inputs").inputs, 3);
    let worst = &found.worst[0];
    assert_eq!((worst.subject.as_str(), worst.relative), ("ann", None));
    assert_eq!(found.by_view[0].non_finite, 1);

    let nothing = |_, _| vec![f32::INFINITY; 2];
    let (_, found) = compared([plain, nothing]).expect("two sides");
    assert_eq!((found.verdict, found.embedding), (Verdict::Differs, None));
}

#[test]
fn answers_of_another_length_are_refused() {
    let longer = |first, second| vec![first, second, 0.0];
    let error = compared([plain, longer]).expect_err("another length");
    assert_eq!(
        error.to_string(),
        "expected one form of embeddings to compare, found [2] of a and [3] of b"
    );
}
