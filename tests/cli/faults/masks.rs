//! Masks and templates that are not as the product writes them: read, or refused with the reason.

use super::pictures::{swept, tree};
use crate::command::{done, names, refused};
use image::GrayImage;
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};

fn fault(name: &str) -> PathBuf {
    let faults = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/faults");
    faults.join(name)
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

#[test]
fn a_tree_with_a_gei_for_each_view_is_read_as_templates() {
    let place = tempfile::tempdir().expect("a folder");
    let at = place.path();
    let from = fault("gei_png_tree");
    let path = from.to_str().expect("UTF-8");
    // The same GEIs in an array, with an index.
    let geis = at.join("geis");
    fs::create_dir(&geis).expect("a folder");
    let (mut index, mut pixels) = ("subject,walk,azimuth_deg\n".to_owned(), Vec::new());
    for person in names(&from) {
        for take in names(&from.join(&person)) {
            let gei = image::open(from.join(&person).join(&take).join("090/gei.png"));
            pixels.extend(gei.expect("a picture").into_luma8().into_raw());
            index += &format!("{person},{take},90\n");
        }
    }
    let count = pixels.len() / (64 * 44);
    edgegait::dataset::write_npy(geis.join("geis.npy"), &[count, 64, 44], &pixels)
        .expect("written");
    fs::write(geis.join("index.csv"), index).expect("written");
    let scored = |path: &str| {
        let arguments = [
            "score",
            "pixels",
            path,
            "--json",
            "-",
            "--out",
            "r",
            "--overwrite",
        ];
        let results: Value = serde_json::from_str(&done(at, &arguments)).expect("JSON");
        results
    };
    let (pictures, array) = (scored(path), scored("geis"));
    let sets = |results: &Value| results["recognizers"][0]["probe_sets"].clone();
    assert_eq!(sets(&pictures)[0]["probes"], 6);
    assert_eq!(sets(&pictures), sets(&array));
    let said = "the gei.png of each view is read as a template";
    assert!(pictures["warnings"].to_string().contains(said));
    done(at, &["train", path, "--out", "m.onnx"]);
    // They are no silhouettes.
    refused(
        at,
        &["sweep", path, "--out", "g"],
        1,
        &["expected a pack or a tree of silhouettes"],
    );
    refused(
        at,
        &["literature", path],
        1,
        &["found a dataset of templates"],
    );
    // One view lacks its GEI, and one has another size.
    for person in names(&from) {
        let view = at.join("p").join(&person).join("nm-01/090");
        fs::create_dir_all(&view).expect("a folder");
        fs::copy(
            from.join(&person).join("nm-01/090/gei.png"),
            view.join("gei.png"),
        )
        .expect("copied");
    }
    let last = names(&at.join("p")).pop().expect("a person");
    let last = at.join("p").join(last).join("nm-01/090/gei.png");
    GrayImage::new(30, 50).save(&last).expect("written");
    refused(
        at,
        &["score", "pixels", "p", "--out", "r"],
        1,
        &["gei.png: expected a GEI of 64x44 as before, found 50x30"],
    );
    fs::remove_file(&last).expect("removed");
    refused(
        at,
        &["score", "pixels", "p", "--out", "r"],
        1,
        &["nm-01/090/gei.png"],
    );
}

#[test]
fn grey_pictures_are_no_silhouettes() {
    let place = tempfile::tempdir().expect("a folder");
    let at = place.path();
    let from = fault("gei_png_tree");
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
