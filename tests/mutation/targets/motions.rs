//! Recordings: first as their files state them, then as people who walk.

use super::{Outcome, Target, packs, seeds, target};
use crate::chance::Chance;
use crate::data::fixtures;
use crate::mutators::{Mutator, bytes, records, structure, text};
use edgegait::import::{FileContents, ImportOptions, Motion};
use edgegait::people::recorded::{BodyOptions, Keep, subjects};
use edgegait::people::{Body, Track};
use edgegait::{MAX_ERROR_MM, ReadOptions, Recording, encode_subjects};
use glam::DVec3;
use std::fs;
use std::path::{Path, PathBuf};

/// Lines of a recording that the readers' targets are given: they need no whole walk.
const LINES: usize = 140;

const C3D: [Mutator; 9] = [
    records::c3d_header,
    records::c3d_header,
    records::c3d_parameter,
    records::c3d_parameter,
    records::c3d_parameter,
    records::c3d_frames,
    bytes::flip,
    bytes::number,
    bytes::cut,
];
const GLB: [Mutator; 10] = [
    structure::glb,
    structure::glb,
    structure::glb,
    structure::glb,
    structure::glb_numbers,
    structure::glb_numbers,
    bytes::flip,
    bytes::number,
    bytes::delete,
    bytes::cut,
];

pub fn targets(folder: &Path, made: &Path) -> Vec<Target> {
    let walking = crate::recording::walk(made, "walk.bvh", 0.0, |_, _| None);
    let walking = fs::read(walking).expect("a recording");
    let clips = fixtures().join("mocap/clips/cmu_amc");
    let skeletons = super::contents(super::below(&clips, &["asf"], 1 << 14));
    let small = 300_000;
    let mut bvhs = seeds(&["bvh"], 200_000);
    bvhs.push(walking.clone());
    let mut short_bvhs: Vec<Vec<u8>> = seeds(&["bvh"], 600_000).iter().map(shortened).collect();
    short_bvhs.push(shortened(&walking));
    let own = super::contents(super::below(&clips.join("s02"), &["amc"], small));
    let mut amcs: Vec<Vec<u8>> = own.iter().map(shortened).collect();
    amcs.extend(seeds(&["amc"], small).iter().map(shortened));
    let mut gltfs = seeds(&["glb"], 100_000);
    gltfs.extend(seeds(&["gltf"], 100_000));
    let (trcs, c3ds) = (seeds(&["trc"], small), seeds(&["c3d"], 1 << 20));
    let short_trcs: Vec<Vec<u8>> = trcs.iter().map(shortened).collect();
    let small_c3ds: Vec<Vec<u8>> = seeds(&["c3d"], 100_000);
    let at = |name: &str| crate::run::fresh(&folder.join(name));
    let amc_read = of_amc(&at("amc"), Given::Motion(clips.join("s02/02.asf")));
    let asf_read = of_amc(&at("asf"), Given::Skeleton(amcs[0].clone()));
    vec![
        target(
            "bvh",
            40,
            short_bvhs,
            &text::ALL,
            &[],
            contents_of(&at("bvh"), "a.bvh"),
        ),
        target("amc", 40, amcs, &text::ALL, &[], amc_read),
        target("asf", 40, skeletons, &text::ALL, &[], asf_read),
        target(
            "trc",
            40,
            short_trcs,
            &text::ALL,
            &[],
            contents_of(&at("trc"), "a.trc"),
        ),
        target(
            "c3d",
            90,
            small_c3ds.clone(),
            &C3D,
            &[],
            contents_of(&at("c3d"), "a.c3d"),
        ),
        target(
            "glb",
            60,
            gltfs.clone(),
            &GLB,
            &[],
            contents_of(&at("glb"), "a.glb"),
        ),
        target(
            "people of bvh",
            15,
            bvhs,
            &text::ALL,
            &[],
            people_of(&at("pbvh"), "a_1.bvh"),
        ),
        target(
            "people of amc",
            4,
            own,
            &text::ALL,
            &[],
            people_of_amc(&at("pamc"), &clips),
        ),
        target(
            "people of trc",
            4,
            trcs,
            &text::ALL,
            &[],
            people_of(&at("ptrc"), "a_1.trc"),
        ),
        target(
            "people of c3d",
            8,
            c3ds,
            &C3D,
            &[],
            people_of(&at("pc3d"), "a_1.c3d"),
        ),
        target(
            "people of glb",
            10,
            gltfs,
            &GLB,
            &[],
            people_of(&at("pglb"), "a_1.glb"),
        ),
    ]
}

/// The first lines of a recording.
fn shortened(text: &Vec<u8>) -> Vec<u8> {
    let lines: Vec<&[u8]> = text.split(|byte| *byte == b'\n').collect();
    // A hierarchy stays whole.
    let motion = lines
        .iter()
        .position(|line| line.starts_with(b"MOTION"))
        .unwrap_or(0);
    let mut count = lines.len().min(motion + LINES);
    // An AMC ends with a whole frame, after which comes the number of the next one.
    let is_number =
        |line: &&[u8]| !line.is_empty() && line.trim_ascii().iter().all(u8::is_ascii_digit);
    if count < lines.len() {
        count = lines[..count].iter().rposition(is_number).unwrap_or(count);
    }
    let frames = format!("Frames: {}", count.saturating_sub(motion + 3));
    let lines = lines[..count].iter().map(|line| {
        if line.starts_with(b"Frames:") {
            frames.as_bytes()
        } else {
            line
        }
    });
    lines.collect::<Vec<_>>().join(&b'\n')
}

enum Given {
    /// A motion for this skeleton's file.
    Motion(PathBuf),
    /// A skeleton for this motion.
    Skeleton(Vec<u8>),
}

fn contents_of(folder: &Path, name: &str) -> impl Fn(&[u8], &mut Chance) -> Outcome + use<> {
    let path = folder.join(name);
    move |bytes, chance| {
        fs::write(&path, bytes)?;
        let options = ImportOptions {
            sample_rate_hz: chance.is(10).then_some(120.0),
            ..ImportOptions::default()
        };
        check(&FileContents::read_with(&path, &options)?);
        Ok(())
    }
}

fn of_amc(folder: &Path, given: Given) -> impl Fn(&[u8], &mut Chance) -> Outcome + use<> {
    let (motion, skeleton) = (folder.join("a.amc"), folder.join("a.asf"));
    match &given {
        Given::Motion(path) => drop(fs::copy(path, &skeleton).expect("a skeleton")),
        Given::Skeleton(bytes) => fs::write(&motion, bytes).expect("a motion"),
    }
    move |bytes, _| {
        let path = if matches!(given, Given::Motion(_)) {
            &motion
        } else {
            &skeleton
        };
        fs::write(path, bytes)?;
        check(&FileContents::read(&motion)?);
        Ok(())
    }
}

/// Asserts that all numbers of a file that was accepted are finite.
fn check(contents: &FileContents) {
    match contents {
        FileContents::Motion(motion) => check_motion(motion),
        FileContents::Markers(markers) => {
            assert!(markers.sample_rate_hz.is_finite(), "a frame rate");
            let positions = markers.frames.iter().flatten().flatten();
            assert!(positions.into_iter().all(|it| it.is_finite()), "a marker");
        }
    }
}

pub fn check_motion(motion: &Motion) {
    assert!(motion.sample_rate_hz.is_finite(), "a frame rate");
    let offsets = motion.joints.iter().map(|joint| joint.offset);
    assert!(offsets.into_iter().all(DVec3::is_finite), "an offset");
    for frame in &motion.frames {
        let is_finite = frame.root.is_finite() && frame.rotations.iter().all(|it| it.is_finite());
        assert!(is_finite, "a frame");
    }
    if let Some(skin) = &motion.skin {
        assert!(skin.vertices.iter().all(|it| it.is_finite()), "a vertex");
        let last = motion.frames.len() - 1;
        assert!(
            skin.posed(motion, last).iter().all(|it| it.is_finite()),
            "a posed vertex"
        );
    }
}

fn people_of(folder: &Path, name: &str) -> impl Fn(&[u8], &mut Chance) -> Outcome + use<> {
    let path = folder.join(name);
    move |bytes, chance| {
        fs::write(&path, bytes)?;
        people(&path, chance)
    }
}

fn people_of_amc(folder: &Path, clips: &Path) -> impl Fn(&[u8], &mut Chance) -> Outcome + use<> {
    fs::copy(clips.join("s02/02.asf"), folder.join("02.asf")).expect("a skeleton");
    people_of(folder, "02_1.amc")
}

/// Makes people of a recording, and now and then a pack of them.
fn people(path: &Path, chance: &mut Chance) -> Outcome {
    let keep = match chance.below(4) {
        0 => Keep::MeanCycle,
        1 => Keep::Uncut,
        _ => Keep::Cycles,
    };
    let options = ReadOptions {
        keep,
        mend: chance.is(80),
        ..ReadOptions::default()
    };
    let recording = Recording::read(path, &options)?;
    let people = subjects(&[recording], &BodyOptions::default())?;
    for person in &people {
        check_body(&person.body);
        for walk in &person.walks {
            assert!(walk.speed_mps.is_finite(), "a speed");
            let (roots, rotations) = match &walk.motion {
                Track::Loop(cycle) => (&cycle.root, &cycle.rotations),
                Track::Uncut(motion) => (&motion.roots, &motion.rotations),
            };
            assert!(roots.iter().all(|it| it.is_finite()), "a root");
            assert!(
                rotations.iter().flatten().all(|it| it.is_finite()),
                "a rotation"
            );
        }
    }
    if chance.is(10) {
        let pack = encode_subjects(&people, MAX_ERROR_MM, &|| Ok(()))?;
        let read = packs::read_pack(&pack);
        read.unwrap_or_else(|error| panic!("a pack of our own: {error}"));
    }
    Ok(())
}

fn check_body(body: &Body) {
    assert!(
        body.offsets.iter().all(|it| it.is_finite()),
        "an offset of a body"
    );
    let points = body.hulls.iter().flat_map(|hull| &hull.points);
    assert!(
        points.into_iter().all(|it| it.is_finite()),
        "a point of a body"
    );
}
