//! Silhouettes and templates: the order of frames, their pixels, their gait cycles.

use crate::command::{done, edgegait, names, refused, text};
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
fn tree(at: &Path, views: &[&str], (frames, cycle): (u32, f64), name: &dyn Fn(u32) -> String) {
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
fn swept(at: &Path, tree: &str, more: &[&str]) -> (Vec<u32>, Vec<u8>, String) {
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
    // A video has its frames in a folder too.
    let output = edgegait(
        at,
        &[
            "segment",
            "t/p1/nm-01/090",
            "--background",
            "t/p1/nm-01/090/1.png",
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
        warnings
            .contains("expected 70 to 220 steps a minute, found a stronger wave of 50 a minute"),
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

#[test]
fn inverted_and_grey_pictures_are_refused_wherever_a_tree_is_read() {
    let place = tempfile::tempdir().expect("a folder");
    let at = place.path();
    let change = |name: &str, change: &dyn Fn(u8, u32) -> u8| {
        tree(&at.join(name), &["090"], (60, 27.5), &|n| {
            format!("{n}.png")
        });
        for person in ["p1", "p2"] {
            let folder = at.join(name).join(person).join("nm-01/090");
            for file in names(&folder) {
                let mut picture = image::open(folder.join(&file))
                    .expect("a picture")
                    .into_luma8();
                for (_, y, pixel) in picture.enumerate_pixels_mut() {
                    pixel.0[0] = change(pixel.0[0], y);
                }
                picture.save(folder.join(file)).expect("written");
            }
        }
    };
    change("inverted", &|pixel, _| 255 - pixel);
    change("grey", &|pixel, row| {
        if row > 40 { pixel / 2 } else { pixel }
    });
    for (name, words) in [
        (
            "inverted",
            [
                "expected a white figure on black, found 100 % of the border",
                "invert them",
            ],
        ),
        (
            "grey",
            [
                "expected silhouettes, whose pixels are black or white",
                "geis.npy",
            ],
        ),
    ] {
        refused(at, &["sweep", name, "--out", "g"], 1, &words);
        refused(
            at,
            &["sweep", name, "--whole-recordings", "--out", "g"],
            1,
            &words,
        );
        refused(at, &["train", name, "--out", "m.onnx"], 1, &words);
        refused(at, &["score", "pixels", name, "--out", "r"], 1, &words);
        refused(at, &["literature", name], 1, &words);
    }
}

#[test]
fn a_view_with_nothing_but_a_gei_is_refused_with_the_way_out() {
    let place = tempfile::tempdir().expect("a folder");
    let at = place.path();
    let from = fault("gei_png_tree");
    let words = [
        "found only gei.png, a template",
        "geis.npy with an index.csv",
    ];
    let path = from.to_str().expect("UTF-8");
    refused(at, &["sweep", path, "--out", "g"], 1, &words);
    refused(at, &["score", "pixels", path, "--out", "r"], 1, &words);
    // Under another name, it is read and found grey.
    for person in names(&from) {
        for take in names(&from.join(&person)) {
            let view = at.join("t").join(&person).join(&take).join("090");
            fs::create_dir_all(&view).expect("a folder");
            let gei = from.join(&person).join(&take).join("090/gei.png");
            fs::copy(gei, view.join(format!("{take}.png"))).expect("copied");
        }
    }
    let words = ["expected silhouettes", "within grey areas", "geis.npy"];
    for whole in [&[][..], &["--whole-recordings"]] {
        refused(
            at,
            &[&["sweep", "t", "--out", "g"], whole].concat(),
            1,
            &words,
        );
        refused(
            at,
            &[&["score", "pixels", "t", "--out", "r"], whole].concat(),
            1,
            &words,
        );
    }
}

#[test]
fn geis_of_0_and_1_or_black_on_white_are_refused() {
    let place = tempfile::tempdir().expect("a folder");
    let at = place.path();
    let refused_by_all = |path: &str, words: &[&str]| {
        refused(at, &["score", "pixels", path, "--out", "r"], 1, words);
        refused(at, &["train", path, "--out", "m.onnx"], 1, words);
    };
    let path = fault("geis_0_1");
    let words = [
        "geis.npy: GEI 0: ",
        "found only 0 and 1",
        "(255 * x).round()",
    ];
    refused_by_all(path.to_str().expect("UTF-8"), &words);
    // Right ones, but for the last.
    tree(&at.join("t"), &["090"], (120, 27.5), &|n| {
        format!("{n:03}.png")
    });
    let (frames, geis, _) = swept(at, "t", &[]);
    fs::remove_file(at.join("g/manifest.json")).expect("removed");
    done(at, &["train", "g", "--out", "right.onnx"]);
    let file = fs::read(at.join("g/geis.npy")).expect("GEIs");
    let last = frames.len() - 1;
    let numbers = geis.len() / frames.len();
    let changed = |change: &dyn Fn(u8) -> u8| {
        let mut file = file.clone();
        let end = file.len();
        file[end - numbers..]
            .iter_mut()
            .for_each(|pixel| *pixel = change(*pixel));
        fs::write(at.join("g/geis.npy"), file).expect("written");
    };
    changed(&|pixel| u8::from(pixel == 255));
    refused_by_all("g", &[&format!("GEI {last}: "), "found only 0 and 1"]);
    changed(&|pixel| 255 - pixel);
    refused_by_all(
        "g",
        &[&format!("GEI {last}: "), "expected a white figure on black"],
    );
}

/// Pickles the frames of a folder as NumPy's arrays of this type with protocol 3: as one array, or
/// as a list.
fn pickle(
    folder: &Path,
    (kind, order): (&str, &str),
    as_list: bool,
    number: &dyn Fn(u8) -> Vec<u8>,
) {
    let files: Vec<PathBuf> = (1..=120)
        .map(|n| folder.join(format!("{n:03}.png")))
        .collect();
    let pictures = files
        .iter()
        .map(|file| image::open(file).expect("a picture").into_luma8());
    let pictures: Vec<Vec<u8>> = pictures
        .map(|picture| picture.into_raw().into_iter().flat_map(number).collect())
        .collect();
    let array = |shape: &[u8], bytes: &[u8]| {
        let mut array = b"cnumpy.core.multiarray\n_reconstruct\ncnumpy\nndarray\n".to_vec();
        array.extend(b"K\x00\x85C\x01b\x87R(K\x01");
        array.extend(shape);
        array.extend(format!("cnumpy\ndtype\nX\x02\0\0\0{kind}").bytes());
        array.extend(b"\x89\x88\x87R(K\x03X\x01\0\0\0");
        array.extend(order.bytes());
        array.extend(b"NNNJ\xFF\xFF\xFF\xFFJ\xFF\xFF\xFF\xFFK\0tb\x89B");
        array.extend(u32::try_from(bytes.len()).expect("few").to_le_bytes());
        array.extend(bytes);
        array.extend(b"tb");
        array
    };
    let mut pickle = b"\x80\x03".to_vec();
    if as_list {
        pickle.extend(b"](");
        for picture in &pictures {
            pickle.extend(array(b"K\x5AK\x3C\x86", picture));
        }
        pickle.push(b'e');
    } else {
        pickle.extend(array(b"K\x78K\x5AK\x3C\x87", &pictures.concat()));
    }
    pickle.push(b'.');
    for file in files {
        fs::remove_file(file).expect("removed");
    }
    fs::write(folder.join("090.pkl"), pickle).expect("written");
}

#[test]
fn masks_are_read_in_every_form_that_people_have() {
    let place = tempfile::tempdir().expect("a folder");
    let at = place.path();
    let walk = (120, 27.5);
    let padded = |n: u32| format!("{n:03}.png");
    tree(&at.join("t"), &["090"], walk, &padded);
    let expected = swept(at, "t", &[]);
    let one = |pixel: u8| vec![pixel / 255];
    type Number<'a> = &'a dyn Fn(u8) -> Vec<u8>;
    let forms: [(&str, &str, bool, Number<'_>); 7] = [
        ("b1", "|", false, &one),
        ("u1", "|", false, &one),
        ("u1", "|", true, &|pixel| vec![pixel]),
        ("b1", "|", true, &one),
        ("f4", "<", false, &|pixel| {
            (f32::from(pixel) / 255.0).to_le_bytes().to_vec()
        }),
        ("f8", "<", true, &|pixel| {
            f64::from(pixel).to_le_bytes().to_vec()
        }),
        ("i8", "<", false, &|pixel| {
            i64::from(pixel / 255).to_le_bytes().to_vec()
        }),
    ];
    for (kind, order, as_list, number) in forms {
        let name = format!("{kind}-{as_list}-{}", number(255).len());
        tree(&at.join(&name), &["090"], walk, &padded);
        for person in ["p1", "p2"] {
            pickle(
                &at.join(&name).join(person).join("nm-01/090"),
                (kind, order),
                as_list,
                number,
            );
        }
        assert_eq!(swept(at, &name, &[]), expected, "{name}");
    }
    // Pictures of 0 and 1.
    tree(&at.join("ones"), &["090"], walk, &padded);
    for person in ["p1", "p2"] {
        let folder = at.join("ones").join(person).join("nm-01/090");
        for file in names(&folder) {
            let mut picture = image::open(folder.join(&file))
                .expect("a picture")
                .into_luma8();
            picture.iter_mut().for_each(|pixel| *pixel /= 255);
            picture.save(folder.join(file)).expect("written");
        }
    }
    assert_eq!(swept(at, "ones", &[]), expected);
    // JPEG changes pixels near edges, by less than half of the way.
    tree(&at.join("jpeg"), &["090"], walk, &|n| format!("{n}.jpg"));
    assert_eq!(swept(at, "jpeg", &[]), expected);
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
