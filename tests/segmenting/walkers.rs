//! Tests of which figure is the walker, and of what is said about the camera.

use crate::command::*;
use crate::made::{SIZE, frame};
use image::{Rgb, RgbImage};
use std::fs;
use std::path::Path;

/// Returns the first row and the number of pixels of each silhouette of a folder.
fn rows_and_areas(folder: &Path) -> Vec<(u32, usize)> {
    let mask = |name: String| {
        let found = image::open(folder.join(name)).expect("a PNG").into_luma8();
        let on = found
            .enumerate_pixels()
            .filter(|(_, _, pixel)| pixel.0[0] > 0);
        let rows: Vec<u32> = on.map(|(_, row, _)| row).collect();
        (rows.first().copied().unwrap_or(0), rows.len())
    };
    names(folder).into_iter().map(mask).collect()
}

#[test]
fn one_of_two_walkers_is_chosen_by_number_by_place_or_by_time() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    fs::create_dir(at.join("frames")).expect("a folder");
    for number in 0..20 {
        // The upper one, of 10x20 pixels, walks to the right, and the lower one, of 12x24, to the
        // left until a side cuts it in the last two frames.
        let mut picture = frame(None);
        let (upper, lower) = (4 + 4 * number, 72 - 4 * number.min(18));
        for (columns, rows) in [(upper..upper + 10, 4..24), (lower..lower + 12, 36..60)] {
            for (x, y) in columns.flat_map(|x| rows.clone().map(move |y| (x, y))) {
                picture.put_pixel(x, y, Rgb([200, 40, 40]));
            }
        }
        let path = at.join(format!("frames/{number:02}.png"));
        picture.save(path).expect("a frame");
    }
    frame(None).save(at.join("wall.png")).expect("a picture");
    let common = ["segment", "frames", "--background", "wall.png", "--out"];
    let which = "expected one walker, found 2: 1 in frames 0 to 19, 2 in frames 0 to 19 (choose one with --walker N";
    refused(at, &[&common[..], &["none"]].concat(), 1, &[which]);
    let segmented = |out: &str, options: &[&str]| {
        done(
            at,
            &[&common[..], &[out, "--json", "r.json"], options].concat(),
        );
        let json = fs::read_to_string(at.join("r.json")).expect("results");
        (rows_and_areas(&at.join(out).join("001/nm-01/090")), json)
    };
    let (lower, said) = segmented("lower", &["--walker", "1"]);
    assert_eq!(lower, [vec![(36, 288); 18], vec![(0, 0); 2]].concat());
    let cut = "2 frames are empty, in which a side of the picture cuts the walker: 18 to 19";
    assert!(said.contains(cut), "{said}");
    let (upper, _) = segmented("upper", &["--walker", "2"]);
    assert_eq!(upper, [(4, 200); 20]);
    let (place, _) = segmented("place", &["--region", "0,0,96,30"]);
    assert_eq!(place, upper);
    let (time, said) = segmented("time", &["--walker", "1", "--frames", "6..19"]);
    assert_eq!(time, [vec![(36, 288); 12], vec![(0, 0)]].concat());
    assert!(said.contains("cuts the walker: 18"), "{said}");
    let beyond = [&common[..], &["none", "--frames", "30..40"]].concat();
    refused(
        at,
        &beyond,
        2,
        &["--frames 30..40: the video has 20 frames"],
    );
    let third = [&common[..], &["none", "--walker", "3"]].concat();
    refused(at, &third, 1, &["--walker 3: expected 1 to 2"]);
    assert!(!at.join("none").exists());
}

#[test]
fn a_camera_that_moves_and_a_video_that_lies_on_its_side_are_said() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    // A chequered wall, which the camera sees four pixels further to the right from a frame on. A
    // block of these columns and rows crosses it.
    let made = |name: &str, moves_at: u32, block: (u32, u32)| {
        let folder = at.join(name);
        fs::create_dir(&folder).expect("a folder");
        for number in 0..20 {
            let shift = if number < moves_at { 0 } else { 4 };
            let picture = RgbImage::from_fn(SIZE.0, SIZE.1, |x, y| {
                let (from, down) = (2 + 3 * number, 10);
                let is_on =
                    (from..from + block.0).contains(&x) && (down..down + block.1).contains(&y);
                let tone = if ((x + shift) / 12 + y / 16) % 2 == 0 {
                    110
                } else {
                    160
                };
                Rgb(if is_on { [40, 50, 220] } else { [tone; 3] })
            });
            let path = folder.join(format!("{number:02}.png"));
            picture.save(path).expect("a frame");
        }
    };
    made("wall", 20, (0, 0));
    let options = |name| {
        [
            "segment",
            name,
            "--background",
            "wall",
            "--out",
            "tree",
            "--json",
            "r.json",
            "--overwrite",
        ]
    };
    let warnings = |name| {
        done(at, &options(name));
        let json = fs::read_to_string(at.join("r.json")).expect("results");
        let value: serde_json::Value = serde_json::from_str(&json).expect("JSON");
        value["warnings"].to_string()
    };
    made("still", 20, (12, 36));
    assert_eq!(warnings("still"), "[]");
    made("moved", 15, (12, 36));
    let moved = "5 frames show another place than the background (the camera moves, or the video is cut): 15 to 19";
    assert!(warnings("moved").contains(moved), "{}", warnings("moved"));
    made("turned", 20, (36, 12));
    assert!(warnings("turned").contains("turned by 90 degrees"));
    made("moves", 5, (12, 36));
    let expected = "moves: expected a camera that stands still before the scene of the background, found that 15 frames show";
    refused(at, &options("moves"), 1, &[expected]);
}
