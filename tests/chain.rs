//! From a made walker to Gait Energy Images: what the encoder states is true, what is
//! made does not depend on threads, and people differ more than their cycles do.

use edgegait::encode::{EncodedClip, encode_avatar, encode_cycle, encode_subjects};
use edgegait::scene::Cycle;
use edgegait::scene::cohort::{self, CohortOptions, Person};
use edgegait::sweep::{Job, Settings, View, Views, sweep};
use edgegait_core::avatar::Avatar;
use edgegait_core::clip::Clip;
use edgegait_core::pack::{Gait, Pack};
use edgegait_core::raster::Rasterizer;
use edgegait_core::skeleton::{JOINTS, Skeleton};
use edgegait_core::template::Gei;
use glam::{DMat4, DQuat, DVec3};

/// Carriers of pelvis, spine, thorax, neck, head, left arm (4), right arm (4), left leg
/// (3), right leg (3); the pelvis has none.
const PARENTS: [usize; JOINTS] = [
    0, 0, 1, 2, 3, 2, 5, 6, 7, 2, 9, 10, 11, 0, 13, 14, 0, 16, 17,
];

fn person(index: usize) -> Person {
    Person::of_cohort(1, index).expect("a person of the cohort")
}

/// The skeleton as it is decoded, which the encoder aims with.
fn skeleton(person: &Person) -> Skeleton {
    let bytes = encode_avatar(&person.body).expect("a body").bytes;
    Avatar::parse(&bytes).expect("an avatar").skeleton()
}

/// The points 3 cm along each axis of each joint's frame, metres.
fn virtual_points(skeleton: &Skeleton, root: DVec3, rotations: &[DQuat; JOINTS]) -> Vec<DVec3> {
    let mut frames = [DMat4::IDENTITY; JOINTS];
    for joint in 0..JOINTS {
        frames[joint] = if joint == 0 {
            DMat4::from_rotation_translation(rotations[0].normalize(), root)
        } else {
            let offset = skeleton.offsets[joint].as_dvec3();
            frames[PARENTS[joint]]
                * DMat4::from_rotation_translation(rotations[joint].normalize(), offset)
        };
    }
    let axes = [DVec3::X, DVec3::Y, DVec3::Z];
    let points = frames
        .iter()
        .flat_map(|frame| axes.map(|axis| frame.transform_point3(0.03 * axis)));
    points.collect()
}

/// Greatest and mean distance, mm, between a cycle and its decoded clip.
fn errors_mm(cycle: &Cycle, skeleton: &Skeleton, clip: &Clip<'_>) -> (f64, f64) {
    let frames = cycle.root.len();
    let mut distances = Vec::new();
    for frame in 0..frames {
        let truth = virtual_points(skeleton, cycle.root[frame], &cycle.rotations[frame]);
        let pose = clip.pose((frame as f64 / frames as f64) as f32);
        let decoded = virtual_points(
            skeleton,
            pose.root.as_dvec3(),
            &pose.rotations.map(glam::Quat::as_dquat),
        );
        distances.extend(
            truth
                .iter()
                .zip(&decoded)
                .map(|(a, b)| 1e3 * a.distance(*b)),
        );
    }
    let mean = distances.iter().sum::<f64>() / distances.len() as f64;
    (distances.into_iter().fold(0.0, f64::max), mean)
}

/// Checks that what is stated is what an independent measurement finds.
fn assert_stated_errors_are_true(encoded: &EncodedClip, cycle: &Cycle, skeleton: &Skeleton) {
    let clip = Clip::parse(&encoded.bytes).expect("a clip");
    let (max, mean) = errors_mm(cycle, skeleton, &clip);
    assert!(
        (max - encoded.max_error_mm).abs() < 0.01,
        "{max} {}",
        encoded.max_error_mm
    );
    assert!(
        (mean - encoded.mean_error_mm).abs() < 0.01,
        "{mean} {}",
        encoded.mean_error_mm
    );
    // In the file they are rounded up to hundredths.
    let stored = (
        f64::from(clip.max_error_mm()),
        f64::from(clip.mean_error_mm()),
    );
    assert!(
        stored.0 > max - 0.001 && stored.0 < max + 0.011,
        "{max} {}",
        stored.0
    );
    assert!(
        stored.1 > mean - 0.001 && stored.1 < mean + 0.011,
        "{mean} {}",
        stored.1
    );
}

#[test]
fn the_stated_error_is_true_and_within_the_tolerance_and_sizes_fall_with_it() {
    let mut totals = [0; 3];
    for index in [0, 1, 7] {
        let person = person(index);
        let skeleton = skeleton(&person);
        for speed in [3.0, 5.0, 7.0, 12.0] {
            let cycle = person.cycle(speed);
            let mut before = usize::MAX;
            for (tolerance, total) in [1.0, 5.0, 10.0].into_iter().zip(&mut totals) {
                let encoded = encode_cycle(&cycle, &skeleton, tolerance).expect("a clip");
                assert_stated_errors_are_true(&encoded, &cycle, &skeleton);
                assert!(encoded.max_error_mm <= tolerance);
                assert!(encoded.bytes.len() < before, "{speed} km/h, {tolerance} mm");
                before = encoded.bytes.len();
                *total += before;
            }
        }
    }
    println!(
        "mean bytes at 1, 5 and 10 mm: {:?}",
        totals.map(|total| total / 12)
    );
}

#[test]
fn a_tolerance_of_zero_gives_the_finest_encoding_and_says_what_it_reached() {
    let person = person(2);
    let skeleton = skeleton(&person);
    let cycle = person.cycle(4.0);
    let finest = encode_cycle(&cycle, &skeleton, 0.0).expect("a clip");
    assert_stated_errors_are_true(&finest, &cycle, &skeleton);
    println!(
        "finest: {} mm, {} bytes",
        finest.max_error_mm,
        finest.bytes.len()
    );
    // Measured: 0.28 mm.
    assert!(finest.max_error_mm > 0.0 && finest.max_error_mm < 0.3);
    let fine = encode_cycle(&cycle, &skeleton, 1.0).expect("a clip");
    assert!(fine.max_error_mm > finest.max_error_mm && fine.bytes.len() < finest.bytes.len());
}

#[test]
fn a_body_returns_within_a_millimetre_and_the_stated_error_is_true() {
    for index in 0..6 {
        let body = person(index).body;
        let encoded = encode_avatar(&body).expect("a body");
        let avatar = Avatar::parse(&encoded.bytes).expect("an avatar");
        let mut worst = 0.0f64;
        for (hull, decoded) in body.hulls.iter().zip(avatar.hulls()) {
            assert_eq!(hull.joint, decoded.joint());
            assert_eq!(hull.points.len(), decoded.len());
            for (point, found) in hull.points.iter().zip(decoded.points()) {
                worst = worst.max(1e3 * point.distance(found.as_dvec3()));
            }
        }
        println!("body {index}: {worst:.2} mm");
        assert!((worst - encoded.max_error_mm).abs() < 1e-6);
        // Half of 1/255 of a trunk of 15 by 45 by 15 cm is 0.98 mm across.
        assert!(worst < 1.0, "{worst}");
        for (offset, found) in body.offsets.iter().zip(avatar.skeleton().offsets) {
            assert!((*offset - found.as_dvec3()).abs().max_element() < 0.05e-3 + 1e-7);
        }
    }
}

fn on_threads<R: Send>(threads: usize, work: impl FnOnce() -> R + Send) -> R {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    pool.expect("threads").install(work)
}

fn pack(seed: u64, people: usize, speeds_kmh: &[f64]) -> Vec<u8> {
    let options = CohortOptions {
        seed,
        people,
        speeds_kmh: speeds_kmh.to_vec(),
    };
    let subjects = cohort::subjects(&options).expect("a cohort");
    encode_subjects(&subjects, 5.0, &|| ()).expect("a pack")
}

/// Jobs and their GEIs, in the order in which they come.
fn swept(bytes: &[u8], cycles: u32, views: &[View], seed: u64) -> Vec<(Job, Vec<Gei>)> {
    let pack = Pack::parse(bytes).expect("a pack");
    let jobs: Vec<Job> = (0..pack.walks().len())
        .flat_map(|walk| (0..cycles).map(move |cycle| Job { walk, cycle }))
        .collect();
    let settings = Settings {
        rasterizer: Rasterizer::Skia,
        frames_per_cycle: 16,
        seed,
    };
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
        |_, swept| Ok(swept.geis),
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
    // 4 km/h are 1.111 m/s; 8 are 2.222.
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
        let pose = |pack: &Pack<'_>| pack.clip(index).expect("a clip").pose(0.25);
        assert_eq!(pose(&few), pose(&many));
        assert_eq!(few.subject(index), many.subject(index));
    }
}

#[test]
fn a_sweep_is_the_same_on_1_and_4_threads_and_its_seed_varies_all_cycles_but_the_stored_one() {
    let bytes = pack(1, 3, &[3.0, 9.0]);
    let views = Views::grid("list", [0.0, 55.0, 90.0], [0.0, 45.0, 90.0]).expect("viewpoints");
    let on = |threads, seed| on_threads(threads, || swept(&bytes, 3, &views.list, seed));
    let one = on(1, 1);
    assert_eq!(one.len(), 3 * 2 * 3);
    assert!(one == on(4, 1), "differs between 1 and 4 threads");
    for ((job, geis), (_, others)) in one.iter().zip(on(4, 2)) {
        assert_eq!(*geis == others, job.cycle == 0, "{job:?}");
    }
}

#[test]
fn a_varied_cycle_does_not_depend_on_what_else_is_in_the_pack() {
    let side = Views::side().expect("the side view").list;
    let few = swept(&pack(1, 1, &[5.0]), 2, &side, 1);
    let many = swept(&pack(1, 1, &[4.0, 5.0]), 2, &side, 1);
    // walk-5kmh, stored and varied: the second walk of the second pack.
    for cycle in 0..2 {
        assert!(few[cycle].1 == many[2 + cycle].1, "cycle {cycle}");
    }
}

#[test]
fn what_is_not_finite_or_no_rotation_is_refused() {
    let person = person(0);
    let skeleton = skeleton(&person);
    for bad in [f64::NAN, f64::INFINITY] {
        let mut body = person.body.clone();
        body.hulls[0].points[3].y = bad;
        assert!(encode_avatar(&body).is_err(), "a hull point {bad}");
        let mut cycle = person.cycle(5.0);
        cycle.root[2].x = bad;
        assert!(
            encode_cycle(&cycle, &skeleton, 5.0).is_err(),
            "a root {bad}"
        );
    }
    let mut cycle = person.cycle(5.0);
    cycle.rotations[2][0] = DQuat::from_xyzw(0.0, 0.0, 0.0, 0.0);
    assert!(
        encode_cycle(&cycle, &skeleton, 5.0).is_err(),
        "a rotation of length 0"
    );
}

#[test]
fn people_differ_more_than_the_cycles_of_one_person() {
    const PEOPLE: usize = 10;
    const CYCLES: usize = 4;
    let bytes = pack(1, PEOPLE, &[5.0]);
    let side = Views::side().expect("the side view").list;
    let geis = swept(&bytes, CYCLES as u32, &side, 1);
    let distance = |a: usize, b: usize| {
        let pixels = geis[a].1[0].pixels.iter().zip(&geis[b].1[0].pixels);
        let squares = pixels.map(|(a, b)| (f64::from(*a) - f64::from(*b)).powi(2));
        (squares.sum::<f64>() / 1_500.0).sqrt()
    };
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
