//! The packs in the firmware's flash are those that the command makes, and its answers are those of
//! the ONNX model, also for dressed people, on which the model was not trained.

#[path = "../../no_std_core/tests/golden/study.rs"]
mod study;

use crate::command::done;
use edgegait::inference::{Model, Runtime};
use edgegait_core::body::{Figure, UnpackedBody};
use edgegait_core::linear::LinearRecognizer;
use edgegait_core::pack::Pack;
use edgegait_core::pose::ModelPose;
use edgegait_core::raster::{Rasterizer, Renderer};
use edgegait_core::silhouette::Size;
use edgegait_core::template::GeiBuilder;
use glam::Vec2;
use std::fs;
use std::path::Path;
use study::{BARE, DRESSED, FRAMES, Fnv, RECOGNIZER};

fn model() -> Model {
    let models = Path::new(env!("CARGO_MANIFEST_DIR")).join("models");
    Model::open(models.join("spread.onnx")).expect("a shipped model")
}

#[test]
fn the_packs_in_flash_are_those_of_the_command() {
    let dir = tempfile::tempdir().expect("a folder");
    let made = |arguments: &[&str]| {
        done(dir.path(), arguments);
        fs::read(dir.path().join("made.egp")).expect("a pack")
    };
    let bare = ["cohort", "--sessions", "1", "--out", "made.egp"];
    assert!(made(&bare) == BARE.pack);
    let dressed = "cohort --people 198..201 --speeds-kmh 5 --dressed --out made.egp --overwrite";
    assert!(made(&dressed.split(' ').collect::<Vec<_>>()) == DRESSED.pack);
    let eight = "cohort --people 1 --speeds-kmh 5 --hull-points 152 --out made.egp";
    let eight: Vec<&str> = eight.split(' ').collect();
    let golden = include_bytes!("../../no_std_core/tests/golden/eight.egp");
    assert!(made(&eight) == golden);
}

/// The scores with 8-bit weights differ from the model's by at most 0.18 over 2,184 GEIs (`edgegait
/// quantize models/spread.onnx`), which is less than the margins here.
#[test]
fn the_board_gives_the_answers_of_the_onnx_model() {
    let quantized = LinearRecognizer::parse(RECOGNIZER).expect("the recognizer");
    let model = model();
    let people = &model.contract().classes;
    let recognizer = Runtime::rten().load(&model).expect("a shipped model");
    let packs = [BARE, DRESSED].map(|study| Pack::parse(study.pack).expect("a pack"));
    let studies = [BARE, DRESSED].into_iter().zip(&packs);
    let jobs = studies.flat_map(|(study, pack)| {
        let answers = study.answers.lines();
        let answers = answers.filter(|line| line.starts_with("rows "));
        let jobs = (0..study.jobs()).map(move |number| study.job(pack, number));
        jobs.zip(answers)
    });
    let mut count = 0;
    for (job, answer) in jobs {
        let (body, skeleton) = (UnpackedBody::new(&job.avatar), job.avatar.skeleton());
        let mut renderer = Renderer::new(Rasterizer::Rows, Size::S50x30);
        let mut gei = GeiBuilder::new(Size::S50x30);
        for frame in 0..FRAMES {
            let phase = f32::from(frame) / f32::from(FRAMES);
            let pose = ModelPose::new(&skeleton, &job.cycle.pose(phase));
            let figure = Figure::new(&body, &pose);
            let drawing = renderer.draw(&figure, &job.camera, quantized.framing(), Vec2::ZERO);
            gei.add(drawing.expect("a figure").frame).expect("room");
        }
        let gei = gei.gei();
        let input: Vec<f32> = gei
            .pixels()
            .iter()
            .map(|&byte| f32::from(byte) / 255.0)
            .collect();
        let scores = recognizer
            .run(&input, 1)
            .expect("answers")
            .scores
            .expect("scores");
        let mut ranked: Vec<usize> = (0..scores.len()).collect();
        ranked.sort_by(|&a, &b| scores[b].total_cmp(&scores[a]));

        let mut hash = Fnv::NEW;
        hash.add(gei.pixels());
        let [azimuth, elevation] = job.view;
        let answered = &people[ranked[0]];
        let expected = format!(
            "rows {} {} {azimuth} {elevation} {:016x} {answered} ",
            job.person, job.walk, hash.0
        );
        let bits = answer.strip_prefix(&expected);
        let bits = bits.unwrap_or_else(|| panic!("expected {expected}, found {answer}"));
        let score = f32::from_bits(u32::from_str_radix(bits, 16).expect("a score"));
        let difference = (score - scores[ranked[0]]).abs();
        // `edgegait quantize` finds up to 0.204; the best score leads by 7.9 on average.
        assert!(difference < 0.25, "{answer}: {difference}");
        count += 1;
    }
    assert_eq!(count, BARE.jobs() + DRESSED.jobs());
}
