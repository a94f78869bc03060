//! What firmware has to make of the study: its GEIs and answers, made here by what unpacks
//! bodies first.
//!
//! `UPDATE_GOLDEN=1 cargo test -p edgegait-core --test study` writes the list again.

#[path = "golden/study.rs"]
mod study;

use edgegait_core::body::{Body, Figure};
use edgegait_core::lean::Room;
use edgegait_core::linear::LinearRecognizer;
use edgegait_core::pack::Pack;
use edgegait_core::pose::ModelPose;
use edgegait_core::raster::{Rasterizer, Renderer};
use edgegait_core::silhouette::Size;
use edgegait_core::template::{Gei, GeiBuilder};
use glam::Vec2;
use std::fmt::Write as _;
use study::{ANSWERS, COHORT, FRAMES, Fnv, JOBS, Job, RECOGNIZER, job};

fn gei(job: &Job<'_>, rasterizer: Rasterizer, recognizer: &LinearRecognizer<'_>) -> Gei {
    let (body, skeleton) = (Body::new(&job.avatar), job.avatar.skeleton());
    let mut figure = Figure::at_rest(&body);
    let mut renderer = Renderer::new(rasterizer, Size::S50x30);
    let mut gei = GeiBuilder::new(Size::S50x30);
    for frame in 0..FRAMES {
        let phase = f32::from(frame) / f32::from(FRAMES);
        figure.update(&ModelPose::new(&skeleton, &job.cycle.pose(phase)));
        let drawing = renderer.draw(&figure, &job.camera, recognizer.framing(), Vec2::ZERO);
        gei.add(drawing.expect("a figure").frame).expect("room");
    }
    gei.gei()
}

/// The list by one rasteriser.
fn list(rasterizer: Rasterizer) -> String {
    let pack = Pack::parse(COHORT).expect("the cohort");
    let recognizer = LinearRecognizer::parse(RECOGNIZER).expect("the recognizer");
    let mut list = String::new();
    for job in (0..JOBS).map(|number| job(&pack, number)) {
        let gei = gei(&job, rasterizer, &recognizer);
        let (class, score) = recognizer.classify(gei.pixels()).expect("its size");
        let mut hash = Fnv::NEW;
        hash.add(gei.pixels());
        let Job {
            person,
            walk,
            view: [azimuth, elevation],
            ..
        } = job;
        let (hash, score) = (hash.0, score.to_bits());
        let name = recognizer.name(class).expect("a class");
        writeln!(
            list,
            "{rasterizer} {person} {walk} {azimuth} {elevation} {hash:016x} {name} {score:08x}"
        )
        .expect("text");
    }
    list
}

#[test]
fn answers_are_those_of_the_list() {
    let rasterizers = Rasterizer::ALL.iter().filter(|it| it.spacing() == 1.0);
    let made: String = rasterizers.map(|&rasterizer| list(rasterizer)).collect();
    if std::env::var_os("UPDATE_GOLDEN").is_some() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/golden/study.txt");
        std::fs::write(path, &made).expect("a place to write");
        return;
    }
    let is_made = |line: &&str| cfg!(feature = "skia") || !line.starts_with("skia");
    let expected: Vec<&str> = ANSWERS.lines().filter(is_made).collect();
    assert!(expected.len() >= 36, "{} lines", expected.len());
    assert_eq!(made.lines().collect::<Vec<_>>(), expected);
}

/// Three people at four speeds from three sides: most are found at the speed that `spread` was
/// trained at, from the viewpoints it was trained on.
#[test]
fn people_who_walk_as_in_training_are_recognized() {
    let lines = ANSWERS
        .lines()
        .map(|line| line.split(' ').collect::<Vec<_>>());
    let trained: Vec<_> = lines.filter(|fields| fields[2] == "walk-5kmh").collect();
    let right = trained
        .iter()
        .filter(|fields| fields[1] == fields[6])
        .count();
    assert!(
        right * 10 >= trained.len() * 8,
        "{right} of {}",
        trained.len()
    );
}

#[test]
fn the_firmware_has_room_for_every_body_of_the_cohort() {
    let pack = Pack::parse(COHORT).expect("the cohort");
    let mut most = Room::default();
    for subject in pack.subjects() {
        let avatar = pack.avatar(subject.avatar).expect("an avatar");
        let room = Room::of(&avatar);
        most.points = most.points.max(room.points);
        most.facets = most.facets.max(room.facets);
    }
    assert!((470..=488).contains(&most.points), "{most:?}");
    assert!((860..=896).contains(&most.facets), "{most:?}");
}
