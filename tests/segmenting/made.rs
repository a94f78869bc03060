//! Tests of `edgegait segment` on a synthetic video: a block that crosses a wall.

use crate::command::*;
use image::{Rgb, RgbImage};
use std::fs;
use std::path::Path;

pub const SIZE: (u32, u32) = (96, 64);
const FRAMES: u32 = 20;

/// Returns a frame of the wall, with the block of 12 by 32 pixels at a column.
pub fn frame(at: Option<u32>) -> RgbImage {
    RgbImage::from_fn(SIZE.0, SIZE.1, |x, y| {
        let is_on = at.is_some_and(|at| (at..at + 12).contains(&x) && (16..48).contains(&y));
        Rgb(if is_on {
            [40, 50, 150]
        } else {
            [150, 140 + (x % 5) as u8, 130]
        })
    })
}

fn place(number: u32) -> u32 {
    4 + 4 * number
}

/// Returns a folder with frames, `f1.png` to `f20.png`, and an image of the wall.
fn video() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    let frames = folder.path().join("frames");
    fs::create_dir(&frames).expect("a folder");
    for number in 0..FRAMES {
        let path = frames.join(format!("f{}.png", number + 1));
        frame(Some(place(number))).save(path).expect("a frame");
    }
    frame(None)
        .save(folder.path().join("wall.png"))
        .expect("a picture");
    folder
}

/// Returns the video as grey Y4M in full range.
fn y4m(frames: u32) -> Vec<u8> {
    let mut bytes = format!(
        "YUV4MPEG2 W{} H{} F30:1 Ip Cmono XCOLORRANGE=FULL\n",
        SIZE.0, SIZE.1
    )
    .into_bytes();
    for number in 0..frames {
        bytes.extend(b"FRAME\n");
        let picture = image::DynamicImage::from(frame(Some(place(number)))).into_luma8();
        bytes.extend(picture.into_raw());
    }
    bytes
}

/// Asserts that the silhouettes of a folder are the blocks.
fn assert_blocks(folder: &Path, start: &str, frames: u32) {
    let expected: Vec<String> = (1..=frames)
        .map(|at| format!("{start}{at:03}.png"))
        .collect();
    assert_eq!(names(folder), expected);
    for (number, name) in expected.iter().enumerate() {
        let found = image::open(folder.join(name)).expect("a PNG").into_luma8();
        assert_eq!(found.dimensions(), SIZE);
        for (x, y, pixel) in found.enumerate_pixels() {
            let from = place(number as u32);
            let is_on = (from..from + 12).contains(&x) && (16..48).contains(&y);
            assert_eq!(pixel.0[0], if is_on { 255 } else { 0 }, "{name} {x} {y}");
        }
    }
}

#[test]
fn a_folder_of_frames_becomes_a_sequence_of_a_tree_on_any_number_of_threads() {
    let folder = video();
    let at = folder.path();
    let common = "--background wall.png --contact-sheet look.png --json r.json";
    let mut files = Vec::new();
    for threads in ["1", "5"] {
        let all = format!("segment frames --out tree-{threads} --threads {threads} {common}");
        let said = done(at, &all.split(' ').collect::<Vec<_>>());
        assert!(
            said.contains("20 silhouettes of 96x64 pixels, 0 of them empty; 384 pixels"),
            "{said}"
        );
        let sequence = at.join(format!("tree-{threads}/001/nm-01/090"));
        assert_blocks(&sequence, "001-nm-01-090-", FRAMES);
        let json = fs::read_to_string(at.join("r.json")).expect("results");
        let value: serde_json::Value = serde_json::from_str(&json).expect("JSON");
        assert_eq!(value["schema"], 1);
        assert_eq!(value["command"], "segment");
        assert_eq!(
            (&value["frames"], &value["empty_frames"]),
            (&20.into(), &0.into())
        );
        assert_eq!(value["area_px"]["mean"], 384.0);
        assert_eq!(value["inputs"].as_array().expect("inputs").len(), 2);
        files.push((
            fs::read(at.join("look.png")).expect("a sheet"),
            value["inputs"].clone(),
        ));
    }
    assert!(files[0] == files[1], "the same on 1 and 5 threads");
    let sheet = image::open(at.join("look.png"))
        .expect("a sheet")
        .into_rgb8();
    // Four columns and five rows of frames.
    assert_eq!(sheet.dimensions(), (4 * 98 + 2, 5 * 66 + 2));
    // The first block's corner is outlined.
    assert_eq!(sheet.get_pixel(2 + 4, 2 + 16).0, [255, 0, 255]);
    let tree = edgegait::Tree::open(at.join("tree-1"), &edgegait::dataset::TreeLayout::default())
        .expect("a tree");
    assert_eq!(tree.sequences().len(), 1);
}

#[test]
fn the_median_is_the_background_of_those_who_cross_and_not_of_those_who_stay() {
    let folder = video();
    let at = folder.path();
    done(
        at,
        &["segment", "frames", "--out", "tree", "--view", "090e15"],
    );
    assert_blocks(
        &at.join("tree/001/nm-01/090e15"),
        "001-nm-01-090e15-",
        FRAMES,
    );
    let stays = at.join("stays");
    fs::create_dir(&stays).expect("a folder");
    for number in 0..20 {
        let path = stays.join(format!("{number:02}.png"));
        frame(Some(40 + number / 4)).save(path).expect("a frame");
    }
    let way_out = "(give a picture of the empty scene, or a folder of several, with --background)";
    refused(
        at,
        &["segment", "stays", "--out", "other"],
        1,
        &[
            "stays: expected a figure that moves over the image",
            way_out,
        ],
    );
    assert_eq!(names(at), ["frames", "stays", "tree", "wall.png"]);
}

#[test]
fn what_cannot_be_segmented_is_refused_by_name_before_any_work() {
    let folder = video();
    let at = folder.path();
    let save = |name: &str, width| {
        let path = at.join(name);
        fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
        RgbImage::new(width, 64).save(path).expect("a picture");
    };
    save("sizes/1.png", 96);
    save("sizes/2.png", 95);
    save("narrow.png", 90);
    save("few/1.png", 96);
    fs::create_dir(at.join("none")).expect("a folder");
    for (folder, name, text) in [
        ("broken", "1.png", "no picture"),
        ("mixed", "notes.txt", "text"),
        ("cut", "1.png", "\u{0089}PNG"),
    ] {
        fs::create_dir(at.join(folder)).expect("a folder");
        fs::write(at.join(folder).join(name), text).expect("a file");
    }
    let whole = fs::read(at.join("wall.png")).expect("a picture");
    fs::write(at.join("cut/1.png"), &whole[..whole.len() / 2]).expect("a file");
    for (arguments, code, words) in [
        (
            "sizes",
            1,
            &[
                "sizes/2.png: expected a frame of 96x64 pixels",
                "found 95x64",
            ][..],
        ),
        (
            "none",
            1,
            &["none: expected frames as .png or .jpg, found none"],
        ),
        ("nowhere", 1, &["nowhere: No such file"]),
        ("broken", 1, &["broken/1.png: cannot be read as a picture"]),
        (
            "mixed",
            1,
            &["mixed/notes.txt: expected a folder of frames"],
        ),
        (
            "cut --background wall.png",
            1,
            &["cut/1.png: cannot be read as a picture"],
        ),
        (
            "few",
            1,
            &[
                "few: expected at least 10 frames",
                "found 1",
                "--background",
            ],
        ),
        (
            "frames --background narrow.png",
            1,
            &["narrow.png: expected a background of 96x64", "found 90x64"],
        ),
        (
            "frames --background nowhere.png",
            1,
            &["nowhere.png: No such file"],
        ),
        ("frames --background none", 1, &["none: expected frames"]),
        ("frames --view left", 2, &["left"]),
        ("frames --person a/b", 2, &["a/b"]),
        ("frames --closing-px 99", 2, &["--closing-px"]),
        ("- ", 1, &["standard input"]),
    ] {
        let all = format!("segment {} --out tree", arguments.trim());
        refused(at, &all.split(' ').collect::<Vec<_>>(), code, words);
        assert!(!at.join("tree").exists(), "{arguments}");
    }
    let within = ["segment", "frames", "--out", "frames/tree"];
    refused(
        at,
        &within,
        2,
        &["would be in frames, which this command reads"],
    );
}

#[test]
fn a_sequence_that_is_there_is_replaced_only_if_asked() {
    let folder = video();
    let at = folder.path();
    let arguments = [
        "segment",
        "frames",
        "--out",
        "tree",
        "--background",
        "wall.png",
    ];
    done(at, &arguments);
    refused(
        at,
        &arguments,
        2,
        &["090: already exists", "use --overwrite"],
    );
    fs::remove_file(at.join("frames/f20.png")).expect("a frame less");
    let again = [&arguments[..], &["--overwrite"]].concat();
    done(at, &again);
    assert_blocks(&at.join("tree/001/nm-01/090"), "001-nm-01-090-", FRAMES - 1);
    fs::write(at.join("tree/001/nm-01/090/notes.txt"), "mine").expect("a file");
    refused(at, &again, 2, &["holds notes.txt"]);
    assert_eq!(names(&at.join("tree/001/nm-01")), ["090"]);
}

#[test]
fn a_stream_is_segmented_with_a_background_that_is_given() {
    use std::io::Write as _;
    use std::process::{Command, Stdio};
    let folder = video();
    let at = folder.path();
    let run = |bytes: &[u8], more: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_edgegait"))
            .args(["segment", "-", "--out", "tree"])
            .args(more)
            .current_dir(at)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the command starts");
        let mut input = command.stdin.take().expect("its input");
        // The command may fail before it reads everything.
        let _ = input.write_all(bytes);
        drop(input);
        command.wait_with_output().expect("its end")
    };
    let grey = image::DynamicImage::from(frame(None)).into_luma8();
    grey.save(at.join("grey.png")).expect("a picture");
    let output = run(&y4m(45), &["--background", "grey.png"]);
    assert_eq!(code(&output), 0, "{}", text(&output.stderr));
    assert_eq!(names(&at.join("tree/001/nm-01/090")).len(), 45);
    fs::remove_dir_all(at.join("tree")).expect("removed");
    for (bytes, more, expected) in [
        (y4m(20), &[][..], "cannot be read twice"),
        (
            y4m(20)[..9000].to_vec(),
            &["--background", "grey.png"],
            "standard input at byte",
        ),
        (
            y4m(0),
            &["--background", "grey.png"],
            "expected frames, found none",
        ),
    ] {
        let output = run(&bytes, more);
        assert_eq!(code(&output), 1);
        assert!(
            text(&output.stderr).contains(expected),
            "{}",
            text(&output.stderr)
        );
        assert!(!at.join("tree").exists());
    }
}

#[test]
fn a_y4m_file_has_a_median_and_the_silhouettes_of_its_frames() {
    let folder = video();
    let at = folder.path();
    fs::write(at.join("walk.y4m"), y4m(FRAMES)).expect("a file");
    done(at, &["segment", "walk.y4m", "--out", "tree"]);
    assert_blocks(&at.join("tree/001/nm-01/090"), "001-nm-01-090-", FRAMES);
}

/// A stand-in for ffmpeg that writes a file, or fails as the real one does.
#[cfg(unix)]
#[test]
fn any_video_goes_through_ffmpeg_and_what_it_says_is_passed_on() {
    use std::os::unix::fs::PermissionsExt as _;
    use std::process::Command;
    let folder = video();
    let at = folder.path();
    fs::write(at.join("walk.mp4"), "not Y4M").expect("a file");
    fs::write(at.join("decoded"), y4m(FRAMES)).expect("a file");
    let run = |script: Option<&str>| {
        let programs = at.join("programs");
        fs::create_dir_all(&programs).expect("a folder");
        if let Some(script) = script {
            let program = programs.join("ffmpeg");
            fs::write(&program, format!("#!/bin/sh\n{script}\n")).expect("a file");
            fs::set_permissions(&program, fs::Permissions::from_mode(0o755)).expect("a program");
        }
        let path = format!("{}:/bin:/usr/bin", programs.display());
        Command::new(env!("CARGO_BIN_EXE_edgegait"))
            .args(["segment", "walk.mp4", "--out", "tree"])
            .env(
                "PATH",
                if script.is_some() {
                    path
                } else {
                    "/nowhere".into()
                },
            )
            .current_dir(at)
            .output()
            .expect("the command starts")
    };
    let absent = run(None);
    assert_eq!(code(&absent), 1);
    let said = text(&absent.stderr);
    assert!(
        said.contains("walk.mp4: ") && said.contains("ffmpeg, which is not installed"),
        "{said}"
    );
    let fails = run(Some("echo 'moov atom not found' >&2; exit 183"));
    assert_eq!(code(&fails), 1);
    let said = text(&fails.stderr);
    assert!(
        said.contains("walk.mp4: ffmpeg cannot read it (exit status: 183): moov atom not found"),
        "{said}"
    );
    // Half of the video, and then an error.
    let fails = run(Some("head -c 60000 decoded; echo 'corrupt' >&2; exit 1"));
    assert!(
        text(&fails.stderr).contains("corrupt"),
        "{}",
        text(&fails.stderr)
    );
    assert!(!at.join("tree").exists());
    // The arguments name the file with its protocol, and select the first video track.
    let works = run(Some(
        "case \"$*\" in *'-i file:walk.mp4 -map 0:v:0'*) cat decoded;; *) exit 9;; esac",
    ));
    assert_eq!(code(&works), 0, "{}", text(&works.stderr));
    assert_blocks(&at.join("tree/001/nm-01/090"), "001-nm-01-090-", FRAMES);
}
