//! Every template in the commands: sweeping, training, scoring, rendering, augmentation.

use crate::command::{done, names, refused};
use crate::npy::npy;
use crate::two::folder;
use serde_json::Value;
use std::path::Path;

/// The templates, with the array's shape for two cycles of two people, walking and running, from
/// the side.
const TEMPLATES: [(&str, &str); 9] = [
    ("gei", "8, 50, 30"),
    ("mei", "8, 50, 30"),
    ("mhi", "8, 50, 30"),
    ("msi", "8, 50, 30"),
    ("ghi", "8, 50, 30"),
    ("geni", "8, 50, 30"),
    ("frequency", "8, 150, 30"),
    ("kfd", "8, 60"),
    ("row-width", "8, 50"),
];

fn sweep(at: &Path, template: &str) {
    done(
        at,
        &[
            "sweep",
            "two.egp",
            "--views",
            "side",
            "--cycles",
            "2",
            "--template",
            template,
            "--out",
            template,
        ],
    );
}

#[test]
fn every_template_is_swept_trained_on_and_scored() {
    let folder = folder();
    let at = folder.path();
    for (template, shape) in TEMPLATES {
        sweep(at, template);
        let file = match template {
            "gei" => "geis.npy".to_owned(),
            other => format!("{other}.npy"),
        };
        let mut expected = ["index.csv", "manifest.json", &file];
        expected.sort_unstable();
        assert_eq!(names(&at.join(template)), expected);
        assert_eq!(npy(at.join(template).join(file)).0, shape);

        // The pack and the dataset give the same samples.
        let (model, other) = (format!("{template}.onnx"), format!("{template}-set.onnx"));
        done(
            at,
            &[
                "train",
                "two.egp",
                "--cycles",
                "2",
                "--template",
                template,
                "--components",
                "4",
                "--out",
                &model,
            ],
        );
        done(
            at,
            &["train", template, "--components", "4", "--out", &other],
        );
        let contract = std::fs::read_to_string(at.join(format!("{template}.toml")));
        let contract = contract.expect("a contract");
        assert!(
            contract.contains(&format!("template = {template:?}")),
            "{contract}"
        );

        let score = |input: &[&str]| -> Value {
            let arguments = [&["score"], input, &["--out", "report", "--json", "-"]].concat();
            serde_json::from_str(&done(at, &arguments)).expect("JSON")
        };
        let found = score(&[&model, &other, "two.egp", "--views", "side"]);
        let rank1 = |found: &Value, recognizer: usize| {
            let rank1 = &found["recognizers"][recognizer]["rank1"];
            rank1.as_f64().expect("a rate")
        };
        // At least three of four; outlines distinguish two people less well than images.
        assert!(rank1(&found, 0) >= 0.75, "{template}: {}", rank1(&found, 0));
        assert_eq!(rank1(&found, 0), rank1(&found, 1), "{template}");
        let found = score(&[&model, template]);
        assert_eq!(rank1(&found, 0), 1.0, "{template}: what it was trained on");
        let stated = found["settings"]["template"].as_str().unwrap_or("gei");
        assert_eq!(stated, template);
    }
    // Results of GEIs are the same as before other templates existed.
    done(
        at,
        &[
            "sweep", "two.egp", "--views", "side", "--cycles", "2", "--out", "plain",
        ],
    );
    for name in ["geis.npy", "index.csv", "manifest.json"] {
        let read = |folder: &str| std::fs::read(at.join(folder).join(name)).expect("a file");
        assert_eq!(read("plain"), read("gei"));
    }
    let manifest = std::fs::read_to_string(at.join("plain/manifest.json")).expect("a manifest");
    assert!(!manifest.contains("template"), "{manifest}");

    let score = ["score", "mhi.onnx", "gei"];
    refused(
        at,
        &score,
        1,
        &["asks for template mhi, found gei", "--template mhi"],
    );
    let score = ["score", "mhi.onnx", "two.egp", "--template", "gei"];
    refused(at, &score, 1, &["asks for template mhi, found gei"]);
    let score = ["score", "mhi.onnx", "mhi", "--template", "mhi"];
    refused(at, &score, 2, &["--template: a folder is used whole"]);
}

#[test]
fn the_pixel_baseline_takes_any_template() {
    let folder = folder();
    let at = folder.path();
    for template in ["mhi", "frequency", "kfd"] {
        let arguments = [
            "score",
            "pixels",
            "two.egp",
            "--template",
            template,
            "--views",
            "side",
            "--out",
            "report",
            "--protocol",
            "leave-one-take-out",
            "--json",
            "-",
        ];
        let found: Value = serde_json::from_str(&done(at, &arguments)).expect("JSON");
        assert_eq!(found["settings"]["template"], template);
        assert!(found["recognizers"][0]["rank1"].as_f64().is_some());
    }
}

#[test]
fn augmented_images_follow_their_own_with_a_condition_of_theirs() {
    let folder = folder();
    let at = folder.path();
    let sweep = [
        "sweep",
        "two.egp",
        "--views",
        "side",
        "--template",
        "frequency",
        "--augment",
        "flip,crop",
        "--crop-steps",
        "1",
        "--crop-rows",
        "3",
        "--out",
        "more",
    ];
    done(at, &sweep);
    let (shape, bytes) = npy(at.join("more/frequency.npy"));
    assert_eq!(shape, "16, 150, 30");
    let index = std::fs::read_to_string(at.join("more/index.csv")).expect("an index");
    let conditions: Vec<&str> = index
        .lines()
        .skip(1)
        .filter_map(|line| line.split(',').nth(7))
        .collect();
    let of_one = ["normal", "normal+flip", "normal+crop3", "normal+flip+crop3"];
    assert_eq!(conditions, [of_one; 4].concat());
    for (own, flipped) in bytes.chunks(30).zip(bytes[4_500..].chunks(30)).take(150) {
        assert!(own.iter().eq(flipped.iter().rev()));
    }
    done(
        at,
        &["train", "more", "--components", "4", "--out", "more.onnx"],
    );
    let flags = [
        "--augment",
        "flip",
        "--components",
        "4",
        "--out",
        "twice.onnx",
    ];
    refused(
        at,
        &[&["train", "more"], &flags[..]].concat(),
        2,
        &["augmented already"],
    );

    for (arguments, word) in [
        (
            ["--template", "kfd", "--augment", "flip"],
            "an image, found kfd",
        ),
        (["--augment", "crop", "--crop-rows", "7"], "25 rows cut off"),
        (
            ["--augment", "flip", "--crop-rows", "7"],
            "which was not given",
        ),
    ] {
        let sweep = ["sweep", "two.egp", "--views", "side", "--out", "no"];
        refused(at, &[&sweep[..], &arguments].concat(), 2, &[word]);
    }
    let names = names(at);
    assert!(!names.iter().any(|name| name == "no"), "{names:?}");
}

#[test]
fn templates_are_rendered_side_by_side_and_what_makes_no_sense_is_refused() {
    let folder = folder();
    let at = folder.path();
    let render = ["render", "two.egp", "--out"];
    done(
        at,
        &[
            &render[..],
            &["all.png", "--template", "gei,frequency,kfd,row-width"],
        ]
        .concat(),
    );
    let sheet = image::open(at.join("all.png"))
        .expect("a picture")
        .into_luma8();
    // One GEI, three amplitudes, and three images of bars: seven of 30 columns, at twice the size.
    assert_eq!(sheet.dimensions(), (2 * (1 + 7 * 31), 18 + 2 * (1 + 51)));
    done(
        at,
        &[&render[..], &["f.npy", "--template", "frequency"]].concat(),
    );
    assert_eq!(npy(at.join("f.npy")).0, "1, 150, 30");
    done(at, &[&render[..], &["k.npy", "--template", "kfd"]].concat());
    assert_eq!(npy(at.join("k.npy")).0, "1, 60");

    for (arguments, words) in [
        (
            ["--out", "x.npy", "--template", "gei,mhi"],
            ["a .npy holds one template", "found 2"],
        ),
        (
            ["--out", "x.png", "--template", "gei,silhouettes"],
            ["silhouettes", "alone"],
        ),
        (
            ["--out", "x.png", "--template", "vtm"],
            ["vtm", "row-width"],
        ),
    ] {
        refused(
            at,
            &[&["render", "two.egp"], &arguments[..]].concat(),
            2,
            &words,
        );
    }
    let columns = [
        "sweep",
        "two.egp",
        "--views",
        "side",
        "--raster",
        "columns",
        "--framing",
        "cycle",
        "--out",
        "no",
    ];
    refused(
        at,
        &[&columns[..], &["--template", "mhi"]].concat(),
        2,
        &["which makes a gei", "--raster rows"],
    );
    refused(
        at,
        &[&columns[..], &["--template", "silhouettes"]].concat(),
        2,
        &["which makes a gei, not silhouettes", "--raster rows"],
    );
    let several = [
        "train",
        "two.egp",
        "--template",
        "gei,mhi",
        "--out",
        "no.onnx",
    ];
    refused(at, &several, 2, &["expected one name"]);
    let chosen = [
        "sweep",
        "two.egp",
        "--template",
        "mhi",
        "--max-gei-rmse",
        "5",
        "--out",
        "no",
    ];
    refused(at, &chosen, 2, &["about GEIs"]);
}
