//! From a synthetic walker to Gait Energy Images: the encoder's stated errors are true, results do
//! not depend on threads, and people differ more than their cycles do.

use edgegait::draw::sweep::{FramingMode, Job, Settings, View, Views, sweep};
use edgegait::encode::{encode_avatar, encode_subjects};
use edgegait::people::cohort::{self, CohortOptions};
use edgegait::people::{Cycle, Subject, Track};
use edgegait_core::avatar::Avatar;
use edgegait_core::pack::{Gait, Pack};
use edgegait_core::pose::ModelPose;
use glam::{DQuat, DVec3};

/// Returns the greatest distance from a point of one set to the nearest of the other, both ways,
/// mm.
fn distance_mm(some: &[DVec3], others: &[DVec3]) -> f64 {
    let mut greatest = 0.0f64;
    for (from, to) in [(some, others), (others, some)] {
        for point in from {
            let nearest = to.iter().map(|o| point.distance(*o)).min_by(f64::total_cmp);
            greatest = greatest.max(1e3 * nearest.expect("a point"));
        }
    }
    greatest
}

#[test]
fn a_body_returns_within_what_was_asked_for_and_the_stated_error_is_true() {
    let options = CohortOptions {
        speeds_kmh: vec![],
        ..CohortOptions::default()
    };
    let subjects = cohort::subjects(&options).expect("a cohort");
    assert_eq!(subjects.len(), 26);
    for asked_mm in [0.4, 2.0, 4.0] {
        for subject in &subjects {
            let body = &subject.body;
            let encoded = encode_avatar(body, asked_mm).expect("a body");
            let avatar = Avatar::parse(&encoded.bytes).expect("an avatar");
            let decoded: Vec<_> = avatar.hulls().collect();
            assert_eq!(decoded.len(), body.hulls.len());
            let mut worst = 0.0f64;
            for hull in &body.hulls {
                let found = decoded.iter().find(|found| found.joint() == hull.joint);
                let found = found.expect("one hull a joint").points();
                let found: Vec<DVec3> = found.map(glam::Vec3::as_dvec3).collect();
                worst = worst.max(distance_mm(&hull.points, &found));
            }
            let name = &subject.name;
            assert!((worst - encoded.max_error_mm).abs() < 1e-6, "{name}");
            assert!(worst <= asked_mm, "{name}: {worst}");
            // The file's error is rounded up to hundredths.
            let stated = f64::from(avatar.max_error_mm());
            assert!(
                stated > worst - 1e-4 && stated < worst + 0.0101,
                "{name}: {stated} {worst}"
            );
            for (offset, found) in body.offsets.iter().zip(avatar.skeleton().offsets) {
                assert!((*offset - found.as_dvec3()).abs().max_element() < 0.05e-3 + 1e-7);
            }
        }
    }
}

fn on_threads<R: Send>(threads: usize, work: impl FnOnce() -> R + Send) -> R {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    pool.expect("threads").install(work)
}

fn pack(seed: u64, people: usize, speeds_kmh: &[f64]) -> Vec<u8> {
    encoded(5.0, seed, people, speeds_kmh)
}

/// Returns a pack with seed 1 and this error bound.
fn pack_within(max_error_mm: f64, people: usize, speeds_kmh: &[f64]) -> Vec<u8> {
    encoded(max_error_mm, 1, people, speeds_kmh)
}

fn encoded(max_error_mm: f64, seed: u64, people: usize, speeds_kmh: &[f64]) -> Vec<u8> {
    let options = CohortOptions {
        seed,
        people,
        speeds_kmh: speeds_kmh.to_vec(),
        ..CohortOptions::default()
    };
    let subjects = cohort::subjects(&options).expect("a cohort");
    encode_subjects(&subjects, max_error_mm, &|| Ok(())).expect("a pack")
}

fn seeded(seed: u64) -> Settings {
    Settings {
        frames_per_cycle: 16,
        seed,
        ..Settings::default()
    }
}

/// Returns jobs and their GEIs, in the order of their completion.
fn swept(
    bytes: &[u8],
    cycles: u32,
    views: &[View],
    settings: Settings,
) -> Vec<(Job<'static>, Vec<Vec<u8>>)> {
    let pack = Pack::parse(bytes).expect("a pack");
    let jobs: Vec<Job<'static>> = (0..pack.walks().len())
        .flat_map(|walk| (0..cycles).map(move |cycle| Job::plain(walk, cycle)))
        .collect();
    let mut found = Vec::new();
    let sink = |job, geis| {
        found.push((job, geis));
        Ok(())
    };
    sweep(
        &pack,
        &jobs,
        views,
        settings,
        |_, swept| Ok(swept.templates),
        sink,
    )
    .expect("a sweep");
    assert!(found.iter().map(|(job, _)| *job).eq(jobs));
    found
}

#[test]
fn a_cohort_is_the_same_on_1_and_4_threads_and_another_with_another_seed() {
    let make = |seed| move || pack(seed, 5, &[4.0, 8.0]);
    let one = on_threads(1, make(1));
    assert_eq!(one, on_threads(4, make(1)));
    assert_ne!(one, on_threads(4, make(2)));
    let pack = Pack::parse(&one).expect("a pack");
    let names: Vec<&str> = pack.subjects().map(|subject| subject.name).collect();
    assert_eq!(names, ["F01", "M01", "F02", "M02", "F03"]);
    let walks: Vec<_> = pack
        .walks()
        .take(2)
        .map(|w| (w.name, w.gait, w.speed_mm_per_s))
        .collect();
    // 4 km/h are 1.111 m/s, and 8 km/h are 2.222 m/s.
    assert_eq!(
        walks,
        [
            ("walk-4kmh", Gait::Walk, 1_111),
            ("run-8kmh", Gait::Run, 2_222)
        ]
    );
}

#[test]
fn a_person_does_not_depend_on_how_many_others_there_are() {
    let (few, many) = (pack(1, 2, &[5.0]), pack(1, 4, &[5.0]));
    let (few, many) = (
        Pack::parse(&few).expect("a pack"),
        Pack::parse(&many).expect("a pack"),
    );
    for index in 0..2 {
        let body = |pack: &Pack<'_>| {
            let avatar = pack.avatar(index).expect("an avatar");
            let hulls = avatar.hulls();
            let points: Vec<_> = hulls.flat_map(|hull| hull.points()).collect();
            (avatar.skeleton().offsets, points)
        };
        assert_eq!(body(&few), body(&many));
        assert_eq!(few.subject(index), many.subject(index));
        // All walks of a pack share quantisation steps, so a walk in another pack is the same
        // within the error of 5 mm, but not bit for bit.
        let model = |pack: &Pack<'_>| {
            let pose = pack.clip(index).expect("a clip").sample(0.25);
            let avatar = pack.avatar(index).expect("an avatar");
            ModelPose::new(&avatar.skeleton(), &pose).positions
        };
        for (a, b) in model(&few).iter().zip(model(&many)) {
            assert!(a.distance(b) < 0.010, "{a} {b}");
        }
    }
}

#[test]
fn a_sweep_is_the_same_on_1_and_4_threads_and_its_seed_varies_all_cycles_but_the_stored_one() {
    let bytes = pack(1, 3, &[3.0, 9.0]);
    let views = Views::grid("list", [0.0, 55.0, 90.0], [0.0, 45.0, 90.0]).expect("viewpoints");
    let on = |threads, seed| on_threads(threads, || swept(&bytes, 3, &views.list, seeded(seed)));
    let one = on(1, 1);
    assert_eq!(one.len(), 3 * 2 * 3);
    assert!(one == on(4, 1), "differs between 1 and 4 threads");
    for ((job, geis), (_, others)) in one.iter().zip(on(4, 2)) {
        assert_eq!(*geis == others, job.variation == 0, "{job:?}");
    }
}

/// Returns the root mean square difference of the first views' pixels, grey levels.
fn distance(a: &[Vec<u8>], b: &[Vec<u8>]) -> f64 {
    let pixels = a[0].iter().zip(&b[0]);
    let squares = pixels.map(|(a, b)| (f64::from(*a) - f64::from(*b)).powi(2));
    (squares.sum::<f64>() / 1_500.0).sqrt()
}

#[test]
fn a_varied_cycle_depends_on_what_else_is_in_the_pack_by_no_more_than_a_stored_one() {
    let side = Views::side().expect("the side view").list;
    let (few, many) = (
        pack_within(0.25, 1, &[5.0]),
        pack_within(0.25, 1, &[4.0, 5.0]),
    );
    // One framing for all frames, as a frame whose centroid is between two columns could be placed
    // at either.
    let kept = |seed| Settings {
        framing: FramingMode::Cycle,
        ..seeded(seed)
    };
    let many = swept(&many, 2, &side, kept(1));
    let other_seed = &swept(&few, 2, &side, kept(2))[1].1;
    let few = swept(&few, 2, &side, kept(1));
    // walk-5kmh, stored and varied, is the second walk of the second pack. It differs only by the
    // quantisation steps, which both walks share: twice 0.25 mm, where a pixel is 35 mm.
    for cycle in 0..2 {
        let off = distance(&few[cycle].1, &many[2 + cycle].1);
        let varied = distance(&few[1].1, other_seed);
        println!("cycle {cycle}: {off:.2} of 255, another variation {varied:.2}");
        assert!(off < 0.2 * varied, "cycle {cycle}: {off} {varied}");
    }
}

/// Returns the first person with one changed walk at 5 km/h.
fn changed(change: impl Fn(&mut Cycle)) -> Vec<Subject> {
    let options = CohortOptions {
        people: 1,
        speeds_kmh: vec![5.0],
        ..CohortOptions::default()
    };
    let mut subjects = cohort::subjects(&options).expect("a cohort");
    if let Track::Loop(cycle) = &mut subjects[0].walks[0].motion {
        change(cycle);
    }
    subjects
}

#[test]
fn what_is_not_finite_or_no_rotation_is_refused() {
    for bad in [f64::NAN, f64::INFINITY] {
        let mut body = changed(|_| ()).remove(0).body;
        body.hulls[0].points[3].y = bad;
        assert!(encode_avatar(&body, 2.0).is_err(), "a hull point {bad}");
        for (what, subjects) in [
            ("a root", changed(|cycle| cycle.root[2].x = bad)),
            ("a travel", changed(|cycle| cycle.drift_m = bad)),
            ("a period", changed(|cycle| cycle.period_s = bad)),
        ] {
            let encoded = encode_subjects(&subjects, 5.0, &|| Ok(()));
            assert!(encoded.is_err(), "{what} {bad}");
        }
    }
    let none = DQuat::from_xyzw(0.0, 0.0, 0.0, 0.0);
    let error = encode_subjects(&changed(|c| c.rotations[2][0] = none), 5.0, &|| Ok(()));
    let error = error.expect_err("a rotation of length 0").to_string();
    assert!(
        error.contains("F01 walk-5kmh: a gait cycle with"),
        "{error}"
    );
}

#[test]
fn people_differ_more_than_the_cycles_of_one_person() {
    const PEOPLE: usize = 10;
    const CYCLES: usize = 4;
    let bytes = pack(1, PEOPLE, &[5.0]);
    let side = Views::side().expect("the side view").list;
    let geis = swept(&bytes, CYCLES as u32, &side, seeded(1));
    let distance = |a: usize, b: usize| distance(&geis[a].1, &geis[b].1);
    let mut within = Vec::new();
    let mut between = Vec::new();
    for a in 0..geis.len() {
        for b in 0..a {
            if a / CYCLES == b / CYCLES {
                within.push(distance(a, b));
            } else {
                between.push(distance(a, b));
            }
        }
    }
    assert_eq!((within.len(), between.len()), (60, 720));
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let (within, between) = (mean(&within), mean(&between));
    println!(
        "within {within:.2}, between {between:.2} of 255, ratio {:.2}",
        between / within
    );
    assert!(within > 1.0 && between > 1.5 * within, "{within} {between}");
}
