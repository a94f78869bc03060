use super::*;
use std::collections::BTreeSet;

/// Makes two people with two takes of three cycles each. Each person's GEIs have a bar of their
/// own, and real GEIs have a mark.
fn examples(is_real: bool) -> Vec<Example> {
    let one = |number: usize| {
        let (person, take, position) = (number / 6, number / 3, number % 3);
        let mut gei = vec![0; SIZE.pixels()];
        gei[600 * person..600 * person + 60].fill(200);
        gei[1_499] = if is_real { 255 } else { 0 };
        // No two cycles are the same.
        gei[1_400 + number] = 40;
        Example {
            person,
            take,
            position,
            span_s: (0.0, 1.0),
            frames: Vec::new(),
            gei,
        }
    };
    (0..12).map(one).collect()
}

/// Returns the examples in a part: whether each is real, its take and its cycle.
fn contents(part: &[&Example]) -> BTreeSet<(bool, usize, usize)> {
    let name = |one: &&Example| (one.gei[1_499] > 0, one.take, one.position);
    part.iter().map(name).collect()
}

#[test]
fn nothing_that_is_looked_for_or_next_to_it_is_trained_on() {
    let (real, synthetic) = (examples(true), examples(false));
    for experiment in Experiment::ALL {
        for (unit, seed) in [SplitUnit::Cycle, SplitUnit::Take].into_iter().zip(0..20) {
            let RecognitionTrial { train, test } = trial(experiment, &real, &synthetic, unit, seed);
            assert!(!test.is_empty() && contents(&train).is_disjoint(&contents(&test)));
            let tests_real = experiment != Experiment::RealSynthetic && !experiment.is_synthetic();
            assert!(
                contents(&test)
                    .iter()
                    .all(|example| example.0 == tests_real),
                "{experiment:?}"
            );
            for one in train.iter().filter(|_| experiment.is_split()) {
                let is_near = |other: &&&Example| {
                    (one.gei[1_499], one.take) == (other.gei[1_499], other.take)
                        && (unit == SplitUnit::Take || one.position.abs_diff(other.position) == 1)
                };
                assert!(
                    !test.iter().any(|other| is_near(&other)),
                    "{experiment:?} {unit:?}"
                );
            }
        }
    }
}

#[test]
fn each_experiment_trains_on_what_its_name_says() {
    let (real, synthetic) = (examples(true), examples(false));
    let parts = |experiment, unit| {
        let RecognitionTrial { train, test } = trial(experiment, &real, &synthetic, unit, 3);
        let count = |part: &[&Example], is_real: bool| {
            part.iter()
                .filter(|example| (example.gei[1_499] > 0) == is_real)
                .count()
        };
        [
            count(&train, true),
            count(&train, false),
            count(&test, true),
            count(&test, false),
        ]
    };
    use Experiment::*;
    assert_eq!(parts(SyntheticReal, SplitUnit::Cycle), [0, 12, 12, 0]);
    assert_eq!(parts(RealSynthetic, SplitUnit::Cycle), [12, 0, 0, 12]);
    // One of the two takes of each person.
    assert_eq!(parts(RealReal, SplitUnit::Take), [6, 0, 6, 0]);
    assert_eq!(parts(SyntheticSynthetic, SplitUnit::Take), [0, 6, 0, 6]);
    assert_eq!(parts(MixedSeventy, SplitUnit::Take), [6, 12, 6, 0]);
    assert_eq!(parts(MixedThirty, SplitUnit::Take), [6, 12, 6, 0]);
    // Two of the six cycles of each person; the larger part lacks the one or two of the guard.
    let [trained, _, tested, _] = parts(RealReal, SplitUnit::Cycle);
    assert!(
        tested == 4 && (4..=8).contains(&trained),
        "{trained} {tested}"
    );
    let [trained, synthetic, tested, _] = parts(MixedThirty, SplitUnit::Cycle);
    assert_eq!((trained, synthetic), (4, 12));
    assert!((4..=8).contains(&tested));
}

#[test]
fn people_who_differ_by_a_bar_are_told_apart_and_strangers_are_not_looked_for() {
    let (real, synthetic) = (examples(true), examples(false));
    let run = |synthetic: &[Example], augmentation| {
        let both = RealAndSynthetic {
            real: &real,
            synthetic,
        };
        let unit = SplitUnit::Cycle;
        curve(
            Experiment::SyntheticReal,
            both,
            unit,
            &[1, 2],
            augmentation,
            &|| Ok(()),
        )
    };
    let flip = Augmentation {
        flip: true,
        crops: None,
    };
    for augmentation in [Augmentation::default(), flip] {
        let found = run(&synthetic, augmentation)
            .expect("learnt")
            .expect("two people");
        assert_eq!((found.splits, found.people, found.tested), (1, 2, 12.0));
        assert_eq!(found.last().map(|last| last.accuracy), Some(1.0));
        assert_eq!((found.nearest.accuracy, found.chance), (1.0, 0.5));
    }
    // One class alone gives no result.
    let alone: Vec<Example> = synthetic[..6].to_vec();
    assert!(
        run(&alone, Augmentation::default())
            .expect("no error")
            .is_none()
    );
    // A third person is not in the training set, so only the other one is tested.
    let mut strangers = real.clone();
    strangers
        .iter_mut()
        .filter(|stranger| stranger.person == 0)
        .for_each(|example| example.person = 2);
    let both = RealAndSynthetic {
        real: &strangers,
        synthetic: &synthetic,
    };
    let unit = SplitUnit::Cycle;
    let found = curve(
        Experiment::SyntheticReal,
        both,
        unit,
        &[1],
        flip,
        &|| Ok(()),
    );
    assert_eq!(found.expect("learnt").expect("people").tested, 6.0);
}
