//! Tests of the studies that firmware repeats: their GEIs and answers, computed here with unpacked
//! bodies.
//!
//! `UPDATE_GOLDEN=1 cargo test -p edgegait-core --test study` rewrites the lists.

#[path = "golden/study.rs"]
mod study;

use edgegait_core::body::{Figure, UnpackedBody};
use edgegait_core::clothes::Legs;
use edgegait_core::compact::Room;
use edgegait_core::linear::LinearRecognizer;
use edgegait_core::pack::Pack;
use edgegait_core::pose::ModelPose;
use edgegait_core::raster::{Rasterizer, Renderer};
use edgegait_core::silhouette::Size;
use edgegait_core::template::{Gei, GeiBuilder};
use glam::Vec2;
use std::fmt::Write as _;
use study::{BARE, DRESSED, FRAMES, Fnv, Job, RECOGNIZER, Study};

fn gei(job: &Job<'_>, rasterizer: Rasterizer, recognizer: &LinearRecognizer<'_>) -> Gei {
    let (body, skeleton) = (UnpackedBody::new(&job.avatar), job.avatar.skeleton());
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

/// Returns the list of a study by one rasteriser.
fn list(study: &Study, rasterizer: Rasterizer) -> String {
    let pack = Pack::parse(study.pack).expect("a pack");
    let recognizer = LinearRecognizer::parse(RECOGNIZER).expect("the recognizer");
    let mut list = String::new();
    for job in (0..study.jobs()).map(|number| study.job(&pack, number)) {
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
    for (study, name, least) in [(BARE, "study.txt", 36), (DRESSED, "dressed.txt", 9)] {
        let rasterizers = Rasterizer::ALL.iter().filter(|it| it.spacing() == 1.0);
        let made = rasterizers.map(|&rasterizer| list(&study, rasterizer));
        let made: String = made.collect();
        if std::env::var_os("UPDATE_GOLDEN").is_some() {
            let golden = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/golden");
            let path = std::path::Path::new(golden).join(name);
            std::fs::write(path, &made).expect("a place to write");
            continue;
        }
        let expected: Vec<&str> = study.answers.lines().collect();
        assert!(expected.len() >= least, "{} lines", expected.len());
        assert_eq!(made.lines().collect::<Vec<_>>(), expected);
    }
}

/// Asserts that most of three people at the speed that `spread` was trained at are found from three
/// viewpoints.
#[test]
fn people_who_walk_as_in_training_are_recognized() {
    let lines = BARE
        .answers
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
fn the_firmware_has_room_for_every_body_of_its_studies() {
    for (study, points, facets) in [
        (BARE, 470..=488, 860..=896),
        (DRESSED, 530..=548, 840..=896),
    ] {
        let pack = Pack::parse(study.pack).expect("a pack");
        let avatars = (0..pack.avatar_count()).filter_map(|number| pack.avatar(number));
        let most = avatars.map(|avatar| Room::for_avatar(&avatar));
        let most = most.fold(Room::default(), Room::max);
        assert!(points.contains(&most.points), "{most:?}");
        assert!(facets.contains(&most.facets), "{most:?}");
    }
}

#[test]
fn the_dressed_study_has_a_coat_a_skirt_and_long_hair() {
    let pack = Pack::parse(DRESSED.pack).expect("a pack");
    let avatars = (0..pack.avatar_count()).filter_map(|number| pack.avatar(number));
    let clothes: Vec<_> = avatars.filter_map(|avatar| avatar.clothes()).collect();
    assert_eq!(clothes.len(), 3);
    assert!(
        clothes
            .iter()
            .any(|worn| worn.has_coat && worn.has_long_hair)
    );
    assert!(clothes.iter().any(|worn| worn.legs == Legs::Skirt));
    let draped = [0, 1, 2].map(|number| {
        let avatar = pack.avatar(number).expect("an avatar");
        avatar.hulls().filter_map(|hull| hull.drape()).max()
    });
    assert_eq!(draped, [Some(1), None, Some(1)]);
}
