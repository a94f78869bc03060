//! Tests of the loop with a simulated clock.

use super::*;
use crate::bench::video_pipeline::testing::{SIZE, echo, segmenter, walker, write_video};
use crate::dataset::gait_cycles::CycleFinder;
use crate::draw::template::Template;
use std::sync::atomic::{AtomicU64, Ordering};

const FPS: f32 = 25.0;
/// 12.5 frames a step are 120 steps a minute.
const STEP: f64 = 12.5;
const FRAMES: usize = 110;

/// Counts windows, lets an hour pass between them, and reports 3 J for each.
struct Watched<'a> {
    clock: &'a AtomicU64,
    begun: usize,
    ended: usize,
}

impl Watch for Watched<'_> {
    fn begin(&mut self) -> Result<()> {
        self.begun += 1;
        self.clock.fetch_add(3_600_000, Ordering::Relaxed);
        Ok(())
    }

    fn end(&mut self) -> Option<f64> {
        self.ended += 1;
        self.clock.fetch_add(3_600_000, Ordering::Relaxed);
        Some(3.0)
    }
}

fn video(folder: &std::path::Path) -> Video {
    write_video((0..FRAMES).map(|number| walker(number, STEP)), folder);
    Video::open(folder).expect("a video")
}

/// Measures with a clock that advances by 1 ms at each reading.
fn measured(plan: PathPlan) -> (MeasuredPath, usize) {
    let folder = tempfile::tempdir().expect("a folder");
    let mut video = video(folder.path());
    let (segmenter, echo) = (segmenter(), echo(Template::Gei));
    let mut walk = WatchedWalker::new(&segmenter, &echo, FPS).expect("a path");
    first_answer(&mut walk, &mut video).expect("an answer");
    let ms = AtomicU64::new(0);
    let mut clock = || Duration::from_millis(1 + ms.fetch_add(1, Ordering::Relaxed));
    let mut watch = Watched {
        clock: &ms,
        begun: 0,
        ended: 0,
    };
    let mut laps = Laps::new(&mut clock);
    let found = timed(&mut walk, &mut video, plan, &mut laps, &mut watch).expect("measured");
    let windows: f64 = found.windows.iter().map(|window| window.seconds).sum();
    assert!((windows - laps.total().as_secs_f64()).abs() < 1e-9);
    assert_eq!(watch.begun, watch.ended);
    (found, watch.ended)
}

#[test]
fn stages_add_up_to_the_time_that_was_measured_and_what_is_between_windows_does_not_count() {
    // 0.3 s each: 75 frames of 4 ms, fewer where there are answers of 2 ms more.
    let plan = PathPlan {
        windows: 5,
        window: Duration::from_millis(300),
    };
    let (found, ended) = measured(plan);
    assert_eq!((found.windows.len(), ended), (5, 5));
    let frames: u64 = found.windows.iter().map(|window| window.frames).sum();
    let answers: u64 = found.windows.iter().map(|window| window.answers).sum();
    assert_eq!(answers, found.answers);
    assert!(found.again >= 2 && answers >= 4, "{found:?}");
    let stages = &found.stages;
    for stage in [stages.segment, stages.framing] {
        assert_eq!(
            (stage.calls, stage.min_us, stage.max_us),
            (frames, 1e3, 1e3)
        );
    }
    for stage in [stages.template, stages.network] {
        assert_eq!(
            (stage.calls, stage.min_us, stage.max_us),
            (answers, 1e3, 1e3)
        );
    }
    // The end of a recording reads the video and the detector once more.
    for stage in [stages.decode, stages.cycle] {
        assert_eq!(
            (stage.calls, stage.min_us, stage.max_us),
            (frames, 1e3, 2e3)
        );
    }
    let sum_ms = |times: &Times| times.mean_us * times.calls as f64 * 1e-3;
    let all = [
        stages.decode,
        stages.segment,
        stages.framing,
        stages.cycle,
        stages.template,
        stages.network,
    ];
    let all: f64 = all.iter().map(sum_ms).sum();
    let seconds: f64 = found.windows.iter().map(|window| window.seconds).sum();
    let ms = 4 * frames + 2 * answers + 2 * found.again;
    assert!((all - ms as f64).abs() < 1e-6 && (1e3 * seconds - ms as f64).abs() < 1e-6);
    assert!((sum_ms(&stages.frame) - all).abs() < 1e-6);
    for window in &found.windows {
        assert!((0.3..0.32).contains(&window.seconds), "{window:?}");
        let rate = window.frames as f64 / window.seconds;
        assert_eq!(
            (window.frames_per_second, window.energy_j),
            (rate, Some(3.0))
        );
    }
    // From the frame's file to the network's answer: 4 stages of the frame and 2 of the answer. At
    // a recording's end: the last frame, two further readings, and up to two answers.
    assert_eq!(found.answer.min_us, 6e3);
    assert!(found.answer.max_us <= 14e3, "{:?}", found.answer);
}

#[test]
fn one_time_through_the_video_answers_each_of_its_cycles_and_counts_the_frames_waited_for() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut video = video(folder.path());
    let segmenter = segmenter();
    let mut frames = Vec::new();
    while let Some(frame) = video.frame().expect("a frame") {
        frames.push(frame);
    }
    let legs = crate::bench::video_pipeline::testing::legs(&segmenter, &frames);
    let cycles = CycleFinder::new(FPS)
        .expect("a rate")
        .find(legs)
        .expect("cycles");
    // 110 frames of 25 a cycle.
    assert!((3..=4).contains(&cycles.cycles.len()), "{cycles:?}");
    // Just long enough for the video to begin again once: 4 ms a frame, 2 ms an answer and 2 ms at
    // the end.
    let plan = PathPlan {
        windows: 1,
        window: Duration::from_millis(4 * FRAMES as u64 + 2 * cycles.cycles.len() as u64 + 3),
    };
    let (found, _) = measured(plan);
    assert_eq!(
        (found.again, found.answers),
        (1, cycles.cycles.len() as u64)
    );
    assert_eq!(found.windows[0].frames, FRAMES as u64 + 1);
    let (sum, most) = found.waited;
    // A cycle is known at most two steps and one reading later.
    assert!(sum > 0 && (1..=35).contains(&most), "{:?}", found.waited);
    assert!(sum <= found.answers * most as u64);
}

#[test]
fn measuring_continues_until_there_is_an_answer() {
    let plan = PathPlan {
        windows: 2,
        window: Duration::from_millis(1),
    };
    let (found, _) = measured(plan);
    assert!(found.answers == 1 && found.windows.len() > 10, "{found:?}");
}

#[test]
fn a_minute_is_six_windows_and_a_second_two() {
    let of = |seconds| PathPlan::for_duration(Duration::from_secs_f64(seconds));
    let plan = |windows, ms| PathPlan {
        windows,
        window: Duration::from_millis(ms),
    };
    assert_eq!(of(60.0), plan(6, 10_000));
    assert_eq!(of(33.0), plan(3, 11_000));
    assert_eq!(of(1.0), plan(2, 500));
}

#[test]
fn a_video_without_a_walker_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let empty = walker(0, STEP);
    let wall = *empty.get_pixel(0, 0);
    let frames = (0..30).map(|_| image::RgbImage::from_pixel(SIZE.0, SIZE.1, wall));
    write_video(frames, folder.path());
    let mut video = Video::open(folder.path()).expect("a video");
    let (segmenter, echo) = (segmenter(), echo(Template::Gei));
    let mut walk = WatchedWalker::new(&segmenter, &echo, FPS).expect("a path");
    let error = first_answer(&mut walk, &mut video).expect_err("nobody");
    assert_eq!(
        error.to_string(),
        "expected a gait cycle in the video, found none"
    );
}
