//! Tests of the pipeline against a tree of the segmented video, read as `score` reads it.

use super::*;
use crate::bench::video_pipeline::made::write_made;
use crate::bench::video_pipeline::testing::{echo, legs, segmenter, walker, write_video};
use crate::dataset::TreeLayout;
use crate::dataset::gait_cycles::CycleFinder;
use crate::dataset::gait_cycles::FoundCycles;
use crate::dataset::sequences::SequenceSource;
use crate::draw::sweep::FramingMode;
use crate::draw::template::Template;
use crate::inference::testing::{MadeUp, bytes_of_a_mean_over_frames, contract_of_sequences};
use crate::inference::{Contract, InputLayout, Model, Runtime, shipped};
use crate::segment::{SegmentSettings as Segmentation, SequenceNames, SequenceWriter, Video};
use std::path::Path;

/// Returns all answers to one pass of a video.
fn answers(
    video: &Path,
    segmenter: &Segmenter,
    recognizer: &dyn Recognizer,
    fps: f32,
) -> Vec<CycleAnswer> {
    let mut still = || std::time::Duration::ZERO;
    let mut laps = Laps::new(&mut still);
    let mut video = Video::open(video).expect("a video");
    let mut walk = WatchedWalker::new(segmenter, recognizer, fps).expect("a path");
    let mut found = Vec::new();
    while let Some(frame) = video.frame().expect("a frame") {
        found.extend(walk.frame(&frame, &mut laps).expect("an answer"));
    }
    found.extend(walk.finish(&mut laps).expect("answers"));
    found
}

/// Writes a tree of one sequence, as `segment` does.
fn write_tree(video: &Path, segmenter: &Segmenter, tree: &Path) {
    let names = SequenceNames::new("001", "nm-01", "090").expect("names");
    let mut writer = SequenceWriter::new(tree, &names).expect("a writer");
    let mut video = Video::open(video).expect("a video");
    loop {
        let batch = video.batch().expect("frames");
        if batch.is_empty() {
            break;
        }
        let masks: Vec<_> = batch
            .iter()
            .map(|frame| segmenter.segment(frame).mask)
            .collect();
        writer
            .push(&masks.iter().collect::<Vec<_>>())
            .expect("written");
    }
    writer.finish().expect("a tree");
}

/// Returns the recognizer's answer to each gait cycle of the tree.
fn of_tree(tree: &Path, recognizer: &dyn Recognizer, fps: f32) -> Vec<Outputs> {
    let source = SequenceSource::open(tree, &[], &TreeLayout::default()).expect("a tree");
    let SequenceSource::Tree(recordings) = source else {
        panic!("another source");
    };
    let finder = CycleFinder::new(fps).expect("a frame rate");
    let cut = recordings.in_cycles(&finder, &|| Ok(())).expect("readable");
    assert_eq!(cut.without, [""; 0]);
    let source = SequenceSource::Tree(Box::new(cut.recordings));
    let contract = recognizer.contract();
    let form = Form {
        settings: Settings {
            template: contract.template,
            size: contract.size().expect("a size"),
            framing: contract.framing,
            ..Settings::default()
        },
        frames: contract.frames,
    };
    let all: Vec<usize> = (0..source.sequences().list.len()).collect();
    let mut outputs = Vec::new();
    source
        .show(&all, &form, &mut |_, bytes| {
            let mut input = Vec::new();
            contract.feed(bytes, &mut input);
            outputs.push(recognizer.run(&input, 1)?);
            Ok(())
        })
        .expect("shown");
    outputs
}

/// Asserts that the pipeline's answers equal the tree's, and returns their number.
fn same(
    (video, tree): (&Path, &Path),
    segmenter: &Segmenter,
    recognizer: &dyn Recognizer,
    fps: f32,
) -> usize {
    let found = answers(video, segmenter, recognizer, fps);
    let expected = of_tree(tree, recognizer, fps);
    let outputs: Vec<&Outputs> = found.iter().map(|answer| &answer.outputs).collect();
    assert_eq!(outputs, expected.iter().collect::<Vec<_>>());
    found.len()
}

/// Returns recognizers for each template, another size and framing, and sequences of fixed lengths.
fn echoes() -> Vec<MadeUp> {
    let mut all: Vec<MadeUp> = Template::ALL.into_iter().map(echo).collect();
    let contract = |change: &dyn Fn(&mut Contract)| {
        let mut contract = Contract::default();
        change(&mut contract);
        MadeUp::new(contract, <[f32]>::to_vec)
    };
    all.push(contract(&|c| (c.rows, c.columns) = (64, 44)));
    all.push(contract(&|c| c.framing = FramingMode::Box));
    for frames in [5, 90] {
        all.push(contract(&|c| {
            (c.template, c.layout) = (Template::Silhouettes, InputLayout::Nthw);
            c.frames = Some(frames);
        }));
    }
    all
}

#[test]
fn answers_of_the_path_are_those_of_a_tree_of_the_segmented_video() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let source = cohort();
    let pack = edgegait_core::pack::Pack::parse(&source.bytes).expect("a pack");
    write_made(&pack, 0, 1, at).expect("a video");
    let background = image::open(at.join("background.png")).expect("a picture");
    let segmenter = Segmenter::new(background.into_rgb8(), Segmentation::default());
    let (video, tree) = (at.join("frames"), at.join("tree"));
    write_tree(&video, &segmenter, &tree);
    let paths = (video.as_path(), tree.as_path());
    let mut counts = vec![same(paths, &segmenter, &echo(Template::Gei), 25.0)];
    for model in shipped::linear().expect("models") {
        let recognizer = Runtime::rten().load(&model).expect("a recognizer");
        counts.push(same(paths, &segmenter, recognizer.as_ref(), 25.0));
    }
    let bytes = bytes_of_a_mean_over_frames(None, None);
    let model = Model::from_bytes("mean.onnx", bytes, contract_of_sequences());
    let model = Runtime::rten().load(&model.expect("a model"));
    counts.push(same(
        paths,
        &segmenter,
        model.expect("loaded").as_ref(),
        25.0,
    ));
    // 5 km/h are 50 to 60 cycles a minute: two or three in the three seconds of the crossing.
    assert!(
        counts[0] >= 2 && counts.iter().all(|count| *count == counts[0]),
        "{counts:?}"
    );
}

#[test]
fn answers_agree_for_every_template_size_framing_and_number_of_frames() {
    let folder = tempfile::tempdir().expect("a folder");
    let (video, tree) = (folder.path().join("video"), folder.path().join("tree"));
    // The person appears after some frames, is lost for two frames, and leaves.
    let empty = |number: usize| number < 4 || (50..52).contains(&number) || number > 105;
    let frames = (0..110).map(|number| {
        let mut frame = walker(number, 12.5);
        if empty(number) {
            let wall = *frame.get_pixel(0, 0);
            frame.pixels_mut().for_each(|pixel| *pixel = wall);
        }
        frame
    });
    write_video(frames, &video);
    let segmenter = segmenter();
    write_tree(&video, &segmenter, &tree);
    for echo in echoes() {
        let count = same((&video, &tree), &segmenter, &echo, 25.0);
        assert!(count >= 3, "{count} {:?}", echo.contract());
    }
}

/// Returns the pack of the built-in cohort.
fn cohort() -> crate::dataset::sequences::PackSource {
    let walks = [crate::dataset::sequences::BUILT_IN_WALK.to_owned()];
    let options = crate::dataset::sequences::built_in(&walks);
    crate::dataset::sequences::PackSource::made(&options, &|| Ok(())).expect("a pack")
}

/// Returns the cycles that are found in all frames together.
fn in_all(segmenter: &Segmenter, frames: &[RgbImage], fps: f32) -> FoundCycles {
    let finder = CycleFinder::new(fps).expect("a frame rate");
    finder.find(legs(segmenter, frames)).expect("cycles")
}

#[test]
fn every_cycle_is_answered_by_its_own_frames_at_any_pace_and_frame_rate() {
    let segmenter = segmenter();
    let echo = echo(Template::Silhouettes);
    for (fps, steps_a_minute) in [
        (25.0, 75.0),
        (10.0, 110.0),
        (25.0, 215.0),
        (30.0, 100.0),
        (60.0, 72.0),
        (120.0, 120.0),
    ] {
        let step = 60.0 / steps_a_minute * f64::from(fps);
        // Six seconds, then five at 1.4 times the pace or its inverse, so that periods change.
        let other = if steps_a_minute < 110.0 {
            step / 1.4
        } else {
            step * 1.4
        };
        let seconds = |s: f32| (s * fps) as usize;
        let frames: Vec<RgbImage> = (0..seconds(6.0))
            .map(|number| walker(number, step))
            .chain((0..seconds(5.0)).map(|number| walker(number, other)))
            .collect();
        let expected = in_all(&segmenter, &frames, fps);
        let expected: Vec<_> = expected.cycles.iter().map(whole_frames).collect();
        let silhouettes: Vec<_> = frames
            .iter()
            .map(|frame| {
                let mask = segmenter.segment(frame).mask;
                let size = Settings::default().size;
                let framed = framed(&mask.grey(), mask.columns(), size, FramingMode::Height);
                framed.expect("framed").expect("a figure").to_coverage()
            })
            .collect();
        let mut still = || std::time::Duration::ZERO;
        let mut laps = Laps::new(&mut still);
        let mut walk = WatchedWalker::new(&segmenter, &echo, fps).expect("a path");
        // Run twice: no state of the first recording remains.
        for _ in 0..2 {
            let mut found = Vec::new();
            for (at, frame) in frames.iter().enumerate() {
                let answer = walk.frame(frame, &mut laps).expect("an answer");
                if let Some(answer) = &answer {
                    assert_eq!(answer.frames.end + answer.waited, at + 1);
                }
                found.extend(answer);
            }
            found.extend(walk.finish(&mut laps).expect("answers"));
            let ranges: Vec<_> = found.iter().map(|answer| answer.frames.clone()).collect();
            assert_eq!(ranges, expected, "{fps} {steps_a_minute}");
            for answer in &found {
                let shown = answer.outputs.scores.as_deref().expect("an echo");
                let pixels = shown.chunks_exact(1500);
                for (shown, framed) in pixels.zip(&silhouettes[answer.frames.clone()]) {
                    let mut pairs = framed.pixels().iter().zip(shown);
                    let is_same = pairs.all(|(a, b)| (*a == 255) == (*b == 1.0));
                    assert!(is_same, "{fps} {steps_a_minute}");
                }
                assert_eq!(shown.len(), 1500 * answer.frames.len());
            }
        }
        assert!(expected.len() > 4, "{fps} {steps_a_minute}: {expected:?}");
    }
}

#[test]
#[ignore = "needs EDGEGAIT_DATA: a folder with people/video/<name>/frames and background.png"]
fn with_data_answers_of_the_path_are_those_of_a_tree() {
    let data = std::env::var_os("EDGEGAIT_DATA").expect("EDGEGAIT_DATA");
    let all = std::fs::read_dir(Path::new(&data).join("people/video")).expect("videos");
    let mut videos: Vec<_> = all.map(|entry| entry.expect("an entry").path()).collect();
    videos.retain(|path| path.is_dir());
    videos.sort();
    let mut total = 0;
    // A few seconds each.
    for video in videos.iter().take(3) {
        let background = image::open(video.join("background.png")).expect("a picture");
        let segmenter = Segmenter::new(background.into_rgb8(), Segmentation::default());
        let folder = tempfile::tempdir().expect("a folder");
        write_tree(&video.join("frames"), &segmenter, folder.path());
        let frames = video.join("frames");
        let source = (frames.as_path(), folder.path());
        let echo = echo(Template::Gei);
        let found = answers(&frames, &segmenter, &echo, 30.0);
        if found.is_empty() {
            println!("{}: no cycle", video.display());
            continue;
        }
        let count = same(source, &segmenter, &echo, 30.0);
        println!("{}: {count} answers", video.display());
        total += count;
    }
    assert!(total > 0);
}
