//! Silhouettes and templates: the order of frames, their pixels, their gait cycles.

use crate::command::{done, edgegait, names, text};
use crate::npy::npy;
use image::{GrayImage, Luma};
use std::f64::consts::TAU;
use std::fs;
use std::path::{Path, PathBuf};

fn fault(name: &str) -> PathBuf {
    let faults = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/faults");
    faults.join(name)
}

/// Draws a walker from the side: a trunk of 10 columns, and two legs whose feet are farthest apart,
/// 33 columns, twice a cycle. `time` is in cycles.
fn walker(time: f64) -> GrayImage {
    let apart = 14.0 * (TAU * time).cos();
    GrayImage::from_fn(60, 90, |x, y| {
        let (x, y) = (f64::from(x) - 29.5, f64::from(y));
        let is_trunk = (5.0..50.0).contains(&y) && x.abs() < 5.0;
        let down = (y - 50.0) / 35.0;
        let is_leg = |side: f64| (x - side * apart * down).abs() < 2.5;
        let is_on = is_trunk || ((0.0..1.0).contains(&down) && (is_leg(1.0) || is_leg(-1.0)));
        Luma([if is_on { 255 } else { 0 }])
    })
}

/// Writes a tree of one take of two people from these views, with a cycle of `cycle` frames, and
/// these names of frames.
pub(super) fn tree(
    at: &Path,
    views: &[&str],
    (frames, cycle): (u32, f64),
    name: &dyn Fn(u32) -> String,
) {
    for (person, start) in [("p1", 0.1), ("p2", 0.3)] {
        for view in views {
            let folder = at.join(person).join("nm-01").join(view);
            fs::create_dir_all(&folder).expect("a folder");
            for frame in 0..frames {
                let picture = walker(start + f64::from(frame) / cycle);
                picture.save(folder.join(name(frame + 1))).expect("written");
            }
        }
    }
}

/// Sweeps `tree` in a folder; returns the frames of each cycle, the GEIs and the warnings.
pub(super) fn swept(at: &Path, tree: &str, more: &[&str]) -> (Vec<u32>, Vec<u8>, String) {
    let usual = [
        "sweep",
        tree,
        "--size",
        "64x44",
        "--out",
        "g",
        "--overwrite",
    ];
    let output = edgegait(at, &[&usual[..], more].concat());
    assert!(output.status.success(), "{}", text(&output.stderr));
    let said = text(&output.stdout);
    let index = fs::read_to_string(at.join("g/index.csv")).expect("an index");
    let frames = index.lines().skip(1).map(|line| {
        let field = line.split(',').nth(9).expect("frames");
        field.parse().expect("a number")
    });
    let warnings = said.lines().filter(|line| line.starts_with("warning"));
    let warnings: Vec<&str> = warnings.collect();
    (
        frames.collect(),
        npy(at.join("g/geis.npy")).1,
        warnings.join("\n"),
    )
}

#[test]
fn frames_of_a_tree_come_by_number_whatever_their_names() {
    let place = tempfile::tempdir().expect("a folder");
    let at = place.path();
    let walk = (120, 27.5);
    tree(&at.join("padded"), &["090"], walk, &|n| {
        format!("{n:03}.png")
    });
    let (frames, geis, warnings) = swept(at, "padded", &[]);
    assert!(frames.len() >= 6, "{frames:?}");
    assert!(
        frames.iter().all(|frames| (27..=28).contains(frames)),
        "{frames:?}"
    );
    assert_eq!(warnings, "");
    let forms: [&dyn Fn(u32) -> String; 4] = [
        &|n| format!("{n}.png"),
        &|n| format!("{n}_of_120.png"),
        &|n| format!("frame-{}-left.png", n + 7),
        &|n| format!("p1-nm-01-090-{}.png", 5 * n),
    ];
    for (number, form) in forms.into_iter().enumerate() {
        let name = format!("tree{number}");
        tree(&at.join(&name), &["090"], walk, form);
        assert_eq!(
            swept(at, &name, &[]),
            (frames.clone(), geis.clone(), String::new())
        );
    }
}

#[test]
fn a_gap_in_the_numbers_of_frames_and_a_number_twice_are_said() {
    let place = tempfile::tempdir().expect("a folder");
    let at = place.path();
    tree(&at.join("t"), &["090"], (120, 27.5), &|n| {
        format!("{n}.png")
    });
    let folder = at.join("t/p1/nm-01/090");
    fs::remove_file(folder.join("60.png")).expect("removed");
    let (.., warnings) = swept(at, "t", &[]);
    assert!(
        warnings.contains("1 of 2 recordings have doubtful numbers of frames: p1/nm-01/090: the numbers of 119 frames have gaps: 1, the first between 59.png and 61.png"),
        "{warnings}"
    );
    fs::copy(folder.join("61.png"), folder.join("061.png")).expect("copied");
    let said = done(at, &["train", "t", "--out", "m.onnx"]);
    assert!(
        said.contains("061.png and 61.png have the same number"),
        "{said}"
    );
    // A video has its frames in a folder too. Its scene is black.
    let frame = image::open(folder.join("1.png")).expect("a PNG");
    let scene = GrayImage::new(frame.width(), frame.height());
    scene.save(at.join("scene.png")).expect("a picture");
    let output = edgegait(
        at,
        &[
            "segment",
            "t/p1/nm-01/090",
            "--background",
            "scene.png",
            "--out",
            "s",
        ],
    );
    let said = text(&output.stderr);
    assert!(
        said.contains("061.png and 61.png have the same number"),
        "{said}"
    );
}

/// The figure moves to the right in each frame.
#[test]
fn frames_of_a_video_come_by_number_wherever_it_is_in_their_names() {
    let place = tempfile::tempdir().expect("a folder");
    let at = place.path();
    let [video, empty] = ["number_of_total", "empty_small.png"].map(fault);
    let paths = [&video, &empty].map(|path| path.to_str().expect("UTF-8"));
    done(
        at,
        &["segment", paths[0], "--background", paths[1], "--out", "s"],
    );
    let folder = at.join("s/001/nm-01/090");
    let middle = |name: &String| {
        let picture = image::open(folder.join(name)).expect("a mask").into_luma8();
        let on = picture
            .enumerate_pixels()
            .filter(|(.., pixel)| pixel.0[0] > 0);
        let (count, sum) = on.fold((0, 0), |(count, sum), (x, ..)| (count + 1, sum + x));
        f64::from(sum) / f64::from(count)
    };
    let middles: Vec<f64> = names(&folder).iter().map(middle).collect();
    assert_eq!(middles.len(), 24);
    // Arms and legs move the middle by less than a column back.
    assert!(
        middles.windows(2).all(|two| two[1] > two[0] - 1.0),
        "{middles:?}"
    );
}

/// 25 and 30 frames a second, 50 to 67 steps a minute: analytic cycles.
#[test]
fn a_slow_walker_has_whole_cycles_from_the_side() {
    let place = tempfile::tempdir().expect("a folder");
    let at = place.path();
    for (number, (fps, cycle)) in [("25", 60.0), ("30", 60.0), ("25", 50.0), ("50", 89.5)]
        .into_iter()
        .enumerate()
    {
        let name = format!("t{number}");
        tree(
            &at.join(&name),
            &["090"],
            ((4.4 * cycle) as u32, cycle),
            &|n| format!("{n}.png"),
        );
        let (frames, ..) = swept(at, &name, &["--fps", fps]);
        assert!(frames.len() >= 4, "{fps} {cycle}: {frames:?}");
        for found in frames {
            assert!(
                (f64::from(found) - cycle).abs() < 2.0,
                "{fps} {cycle}: {found}"
            );
        }
    }
}

#[test]
fn a_slow_walker_from_another_view_is_used_whole_with_the_reason() {
    let place = tempfile::tempdir().expect("a folder");
    let at = place.path();
    tree(&at.join("t"), &["018"], (240, 60.0), &|n| {
        format!("{n}.png")
    });
    let (frames, _, warnings) = swept(at, "t", &["--fps", "25"]);
    assert_eq!(frames, [240, 240]);
    assert!(
        warnings.contains("expected 70 to 220 steps a minute, found 51 (check the frame rate)"),
        "{warnings}"
    );
}

#[test]
fn a_frame_rate_that_is_assumed_is_said_where_it_is_in_doubt() {
    let place = tempfile::tempdir().expect("a folder");
    let at = place.path();
    // 60 frames a second: 109 steps a minute, or 45 at 25.
    tree(&at.join("t60"), &["090"], (240, 66.0), &|n| {
        format!("{n}.png")
    });
    let (frames, _, warnings) = swept(at, "t60", &[]);
    assert!(
        frames.iter().all(|frames| (65..=67).contains(frames)),
        "{frames:?}"
    );
    let assumed = "45 steps a minute at 25 frames a second, which are assumed (if the recordings have another rate, state it with --fps)";
    assert!(warnings.contains(assumed), "{warnings}");
    assert_eq!(swept(at, "t60", &["--fps", "60"]).2, "");
    // 120 frames a second: 22 steps a minute at 25, which nobody takes.
    tree(&at.join("t120"), &["090"], (400, 135.0), &|n| {
        format!("{n}.png")
    });
    let (frames, _, warnings) = swept(at, "t120", &[]);
    assert_eq!(frames, [400, 400]);
    assert!(
        warnings.contains("at 25 frames a second, which are assumed (state theirs with --fps)"),
        "{warnings}"
    );
    // 10 frames a second: 300 steps a minute at 25.
    tree(&at.join("t10"), &["090"], (80, 10.0), &|n| {
        format!("{n}.png")
    });
    let (.., warnings) = swept(at, "t10", &[]);
    assert!(warnings.contains("--fps"), "{warnings}");
}

mod with_data {
    use super::*;

    /// Public bug reports: a stride of 60 frames in both trees.
    #[test]
    #[ignore = "needs EDGEGAIT_DATA"]
    fn slow_walkers_of_a_report_have_strides_of_60_frames() {
        let data = std::env::var_os("EDGEGAIT_DATA").expect("EDGEGAIT_DATA");
        let reports = Path::new(&data).join("faults/reports/05_slow_walker_half_cycles");
        let place = tempfile::tempdir().expect("a folder");
        for (tree, fps) in [("slow", "25"), ("slow30", "30")] {
            let tree = reports.join(tree);
            let tree = tree.to_str().expect("UTF-8");
            let (frames, ..) = swept(place.path(), tree, &["--fps", fps]);
            assert_eq!(frames, [60; 3]);
        }
    }
}
