//! Tests of the built command: its files, and its output on each stream.

use crate::command::*;
use crate::made::{made, sha256};
use crate::npy::npy;
use crate::two::{COHORT, folder};
use edgegait::encode::encode_subjects;
use serde_json::Value;
use std::fs;
use std::process::{Command, Stdio};

#[test]
fn help_has_an_example_for_every_subcommand() {
    let folder = tempfile::tempdir().expect("a folder");
    let all = done(folder.path(), &["--help"]);
    for subcommand in ["cohort", "inspect", "render", "sweep"] {
        assert!(all.contains(&format!("  {subcommand}")), "{all}");
        let help = done(folder.path(), &[subcommand, "--help"]);
        assert!(help.contains("Example"), "{help}");
        assert!(help.contains(&format!("  edgegait {subcommand}")), "{help}");
    }
}

#[test]
fn every_subcommand_states_the_version_of_the_command() {
    let folder = tempfile::tempdir().expect("a folder");
    let version = done(folder.path(), &["--version"]);
    let rest = version.strip_prefix(&format!("edgegait {}", env!("CARGO_PKG_VERSION")));
    let rest = rest.expect("name and version").trim_end();
    // A release build from a checkout adds the commit.
    let commit = rest
        .strip_prefix(" (")
        .and_then(|rest| rest.strip_suffix(')'));
    let digits = commit.map(|commit| commit.trim_end_matches(", with changes"));
    let is_commit = |text: &str| text.len() == 12 && text.chars().all(|c| c.is_ascii_hexdigit());
    assert!(
        rest.is_empty() || digits.is_some_and(is_commit),
        "{version}"
    );
    for subcommand in ["score", "sweep"] {
        assert_eq!(done(folder.path(), &[subcommand, "-V"]), version);
    }
}

#[test]
fn numbers_below_zero_are_values_and_not_flags() {
    let folder = folder();
    let at = folder.path();
    let sweep = "sweep two.egp --azimuth-deg -30,0 --elevation-deg -5 --out turned";
    done(at, &sweep.split(' ').collect::<Vec<_>>());
    let index = fs::read_to_string(at.join("turned/index.csv")).expect("the index");
    let row = index.lines().nth(1).expect("a row");
    assert!(row.contains(",-30.0,-5.0,normal,"), "{row}");
    let lens = "render two.egp --lens persp --camera static --aim-m -0.5,0.9,-0.2";
    done(at, &lens.split(' ').collect::<Vec<_>>());
    // If the value is invalid, the error is about the number.
    for (arguments, words) in [
        (
            "cohort --max-error-mm -1",
            ["--max-error-mm", "0 to 1,000,000"],
        ),
        ("cohort --speeds-kmh -5", ["-5 km/h", "3 to 12"]),
        (
            "train two.egp --method svm --svm-c -1",
            ["--svm-c", "found -1"],
        ),
        (
            "render two.egp --azimuth-deg --views",
            ["--views", "invalid"],
        ),
    ] {
        refused(at, &arguments.split(' ').collect::<Vec<_>>(), 2, &words);
    }
}

#[test]
fn json_on_standard_output_is_one_document_that_begins_with_its_header() {
    let folder = folder();
    let at = folder.path();
    let pack = sha256(at.join("two.egp"));
    for (command, inputs, arguments) in [
        (
            "cohort",
            0,
            "cohort --people 1 --speeds-kmh 4 --out one.egp --json - --seed 5",
        ),
        ("inspect", 1, "inspect two.egp --json - --seed 5"),
        ("render", 1, "render two.egp --json - --seed 5"),
        ("render", 1, "render two.egp --out x.npy --json - --seed 5"),
        (
            "sweep",
            1,
            "sweep two.egp --views side --out side --json - --seed 5",
        ),
    ] {
        let arguments: Vec<&str> = arguments.split(' ').collect();
        let output = done(at, &arguments);
        let start = format!("{{\n  \"schema\": 1,\n  \"command\": \"{command}\",\n  \"version\": ");
        assert!(output.starts_with(&start), "{output}");
        // Anything other than one document is an error.
        let json: Value = serde_json::from_str(&output).expect("one JSON document");
        assert_eq!(json["version"], env!("CARGO_PKG_VERSION"));
        assert_eq!(json["seed"], 5);
        assert!(
            json["settings"].is_object() && json["warnings"].is_array(),
            "{output}"
        );
        assert_eq!(
            json["inputs"].as_array().map(Vec::len),
            Some(inputs),
            "{output}"
        );
        if inputs == 1 {
            assert_eq!(json["inputs"][0]["path"], "two.egp");
            assert_eq!(json["inputs"][0]["sha256"], pack.as_str());
        }
    }
}

#[test]
fn json_in_a_file_is_the_same_document_and_leaves_standard_output_to_people() {
    let folder = folder();
    let at = folder.path();
    let printed = done(at, &["inspect", "two.egp", "--json", "-"]);
    let people = done(at, &["inspect", "two.egp", "--json", "result.json"]);
    assert_eq!(
        fs::read_to_string(at.join("result.json")).expect("a file"),
        printed
    );
    assert!(people.contains("2 people, 4 walks"), "{people}");
    // A missing folder is created.
    done(at, &["inspect", "two.egp", "--json", "no/result.json"]);
    assert_eq!(names(at), ["no", "result.json", "two.egp"]);
}

#[test]
fn inspect_accounts_for_every_byte_of_the_file() {
    let folder = folder();
    let at = folder.path();
    let output = done(at, &["inspect", "two.egp", "--json", "-"]);
    let json: Value = serde_json::from_str(&output).expect("JSON");
    let length = fs::metadata(at.join("two.egp")).expect("the pack").len();
    assert_eq!(json["bytes"].as_u64(), Some(length));
    let number = |value: &Value| value.as_u64().expect("a number");
    let section = |name: &str| number(&json["sections"][name]);
    let sections = [
        "names",
        "subjects",
        "walks",
        "avatars",
        "codebook",
        "templates",
        "clips",
    ]
    .map(section);
    // 16 bytes of header and a table of seven sections of 12.
    assert_eq!(sections.iter().sum::<u64>() + 100, length);
    let sum = |list: &str, field: &str| -> u64 {
        let entries = json[list].as_array().expect("a list");
        entries.iter().map(|entry| number(&entry[field])).sum()
    };
    // Two subjects of 12 bytes, four walks of 16; a count and ends of 4 bytes each.
    assert_eq!((section("subjects"), section("walks")), (24, 64));
    assert_eq!(
        section("avatars"),
        4 + 2 * 4 + sum("subjects", "avatar_bytes")
    );
    assert_eq!(section("clips"), 4 + 4 * 4 + sum("clips", "bytes"));
    for clip in json["clips"].as_array().expect("a list") {
        assert!(
            clip["max_error_mm"].as_f64().expect("a number") <= 5.0,
            "{clip}"
        );
    }
    for subject in json["subjects"].as_array().expect("a list") {
        let error = subject["avatar_max_error_mm"].as_f64().expect("a number");
        assert!(error > 1.0 && error <= 2.0, "{subject}");
    }
    let speeds: Vec<f64> = json["clips"]
        .as_array()
        .expect("a list")
        .iter()
        .map(|clip| clip["speed_mps"].as_f64().expect("a number"))
        .collect();
    assert_eq!(speeds, [1.111, 2.222, 1.111, 2.222]);
    assert!(done(at, &["inspect", "two.egp"]).starts_with(&format!("{length} bytes:")));
}

#[test]
fn inspect_says_what_drawing_takes_on_a_board_and_on_a_host() {
    let folder = folder();
    let at = folder.path();
    let length = fs::metadata(at.join("two.egp")).expect("the pack").len();
    let output = done(at, &["inspect", "two.egp", "--json", "-"]);
    let json: Value = serde_json::from_str(&output).expect("JSON");
    let budget = &json["budget"];
    let number = |value: &Value| value.as_u64().expect("a number");
    let [hulls, points, facets] = ["hulls", "points", "facets"].map(|name| number(&budget[name]));
    assert_eq!((hulls, points), (19, 488));
    // A convex hull with n corners has 2 n - 4 triangles (Euler); rounding makes some points lie on
    // edges.
    assert!(
        (800..=2 * 488 - 4 * 19).contains(&facets),
        "{facets} facets"
    );
    assert_eq!(budget["size"], "50x30");
    assert_eq!(number(&budget["flash_bytes"]), length);
    let ram = |name: &str| number(&budget[name]["ram_bytes"]);
    // A board with 16 kB can draw it.
    assert!(ram("skia") < ram("rows") && ram("rows") < 16_384);
    #[cfg(target_pointer_width = "64")]
    {
        // The memory table of the core's README: pack, avatar, clip, skeleton, poses, camera.
        let walk = 240 + 16 + 128 + 228 + 316 + 912 + 56;
        // Hulls and their boxes, 6 bytes a point and 2 a facet, each filled up to 8; pixels.
        let body = 416 + 2_928 + (2 * facets).next_multiple_of(8);
        let lean = walk + body + 64 + 40 + 24 + 50 * 30;
        assert_eq!(number(&budget["body_bytes"]), body);
        assert_eq!(ram("rows"), lean + 2_072);
        // `skia` needs no facets.
        assert_eq!(ram("skia"), lean - (2 * facets).next_multiple_of(8) + 1_040);
        let unpacked = walk + 89_016 + 20_104 + 38_208 + 40 + 16_408 + 64 * 64;
        assert_eq!(ram("unpacked"), unpacked);
    }
    let people = done(at, &["inspect", "two.egp"]);
    let row = format!("skia, on a board {length:>12} {:>8}\n", ram("skia"));
    let body = format!("19 hulls, compact::CompactBody<488, {facets}>, ");
    assert!(people.contains(&row) && people.contains(&body), "{people}");
}

#[test]
fn a_cohort_is_made_twice_with_the_same_bytes() {
    let folder = folder();
    let at = folder.path();
    let first = fs::read(at.join("two.egp")).expect("the pack");
    for (arguments, is_same) in [
        ("--threads 1", true),
        ("--threads 4", true),
        ("--seed 2", false),
    ] {
        let mut all = COHORT.to_vec();
        all.extend(arguments.split(' '));
        done(at, &all);
        let again = fs::read(at.join("two.egp")).expect("the pack");
        assert_eq!(first == again, is_same, "{arguments}");
        assert_eq!(names(at), ["two.egp"]);
    }
}

#[test]
fn render_writes_arrays_of_the_stated_shapes() {
    let folder = folder();
    let at = folder.path();
    for (arguments, shape, frames) in [
        ("", "32, 50, 30", 32),
        ("--frames-per-cycle 8", "8, 50, 30", 8),
        (
            "--azimuth-deg 0,45,90 --frames-per-cycle 4",
            "3, 4, 50, 30",
            12,
        ),
        (
            "--azimuth-deg 0,45 --elevation-deg 0,90 --template gei",
            "4, 50, 30",
            4,
        ),
        ("--template gei", "1, 50, 30", 1),
    ] {
        let mut all = vec!["render", "two.egp", "--overwrite", "--out", "x.npy"];
        all.extend(arguments.split_whitespace());
        assert_eq!(
            done(at, &all),
            "wrote x.npy: F01, walk-4kmh; 3 other walks are left out (--subjects, --walks)\n"
        );
        let (found, pixels) = npy(at.join("x.npy"));
        assert_eq!(found, shape, "{arguments}");
        assert_eq!(pixels.len(), frames * 1_500);
        let is_binary = pixels.iter().all(|&pixel| pixel == 0 || pixel == 255);
        assert_eq!(is_binary, !arguments.contains("gei"), "{arguments}");
        for (index, frame) in pixels.chunks(1_500).enumerate() {
            // A person fills the 50 rows and is wider than a line.
            let on = frame.iter().filter(|&&pixel| pixel > 0).count();
            assert!((100..1_500).contains(&on), "{arguments}: {on} in {index}");
            for row in [0, 49] {
                let row = &frame[30 * row..][..30];
                assert!(row.iter().any(|&pixel| pixel > 0), "{arguments}: {index}");
            }
        }
    }
    let grey = ["render", "two.egp", "--raster", "skia-aa", "--overwrite"];
    done(at, &[&grey[..], &["--out", "x.npy"]].concat());
    let (_, pixels) = npy(at.join("x.npy"));
    assert!(pixels.iter().any(|&pixel| (1..255).contains(&pixel)));
}

#[test]
fn a_rendered_template_is_the_mean_of_the_rendered_frames() {
    let folder = folder();
    let at = folder.path();
    let walk = [
        "render",
        "two.egp",
        "--subjects",
        "M01",
        "--walks",
        "run-8kmh",
        "--out",
    ];
    done(at, &[&walk[..], &["frames.npy"]].concat());
    done(at, &[&walk[..], &["gei.npy", "--template", "gei"]].concat());
    let (_, frames) = npy(at.join("frames.npy"));
    let (_, gei) = npy(at.join("gei.npy"));
    for (at, &pixel) in gei.iter().enumerate() {
        let sum: f64 = frames
            .iter()
            .skip(at)
            .step_by(1_500)
            .map(|&on| f64::from(on))
            .sum();
        assert_eq!(f64::from(pixel), (sum / 32.0 + 0.5).floor(), "pixel {at}");
    }
}

#[test]
fn render_without_a_file_draws_text_art_of_50_rows_in_25_lines() {
    let folder = folder();
    let art = done(
        folder.path(),
        &[
            "render",
            "two.egp",
            "--subjects",
            "M01",
            "--walks",
            "walk-4kmh",
        ],
    );
    let (title, art) = art.split_once('\n').expect("a title");
    assert_eq!(
        title,
        "M01, walk-4kmh, azimuth 90, elevation 0 degrees; phases 0 and 0.25"
    );
    assert_eq!(art.trim_end().lines().count(), 25);
    assert!(art.chars().all(|sign| " ▀▄█\n".contains(sign)), "{art}");
}

#[test]
fn the_built_in_cohort_walks_on_two_days() {
    let folder = tempfile::tempdir().expect("a folder");
    let render = "render --subjects M01 --walks s2-walk-6kmh";
    let art = done(folder.path(), &render.split(' ').collect::<Vec<_>>());
    assert!(art.starts_with("M01, s2-walk-6kmh, azimuth 90"), "{art}");
}

#[test]
fn a_reader_that_goes_away_is_no_error() {
    let folder = folder();
    let mut child = Command::new(env!("CARGO_BIN_EXE_edgegait"))
        .args(["inspect", "two.egp"])
        .current_dir(folder.path())
        .stdout(Stdio::piped())
        .spawn()
        .expect("the command starts");
    drop(child.stdout.take());
    assert!(child.wait().expect("it ends").success());
}

#[test]
#[cfg(unix)]
fn results_go_through_links_and_into_pipes_and_replace_neither() {
    use std::os::unix::fs::{FileTypeExt, symlink};
    let folder = folder();
    let at = folder.path();
    let expected = done(at, &["inspect", "two.egp", "--json", "-"]);

    symlink("real.json", at.join("link.json")).expect("a link");
    let former = "{\"schema\":1,\"command\":\"inspect\"}";
    fs::write(at.join("real.json"), former).expect("a file");
    done(at, &["inspect", "two.egp", "--json", "link.json"]);
    assert!(at.join("link.json").is_symlink());
    assert_eq!(
        fs::read_to_string(at.join("real.json")).expect("a file"),
        expected
    );

    let made = Command::new("mkfifo").arg(at.join("pipe")).status();
    assert!(made.expect("mkfifo").success());
    let is_pipe = || {
        fs::metadata(at.join("pipe"))
            .expect("a pipe")
            .file_type()
            .is_fifo()
    };
    // Both ends are held open here, so that neither side waits forever.
    let mut ends = fs::OpenOptions::new();
    let mut pipe = ends
        .read(true)
        .write(true)
        .open(at.join("pipe"))
        .expect("a pipe");
    let pack = ["inspect", "two.egp", "--json", "pipe"];
    done(at, &pack);
    assert!(is_pipe());
    let mut found = vec![0; expected.len()];
    std::io::Read::read_exact(&mut pipe, &mut found).expect("the results");
    assert_eq!(text(&found), expected);
}

#[test]
fn stored_cycles_and_their_variations_have_different_numbers() {
    let folder = folder();
    let at = folder.path();
    // Two stored cycles of one take.
    let mut one = made(1, vec![4.0, 5.0]);
    for (cycle, walk) in (0..).zip(&mut one[0].walks) {
        walk.name = "take".into();
        walk.cycle = cycle;
    }
    let bytes = encode_subjects(&one, 5.0, &|| Ok(())).expect("a pack");
    fs::write(at.join("ann.egp"), bytes).expect("a file");
    done(
        at,
        &[
            "sweep", "ann.egp", "--views", "side", "--cycles", "3", "--out", "new",
        ],
    );
    let index = fs::read_to_string(at.join("new/index.csv")).expect("the index");
    let numbers: Vec<[&str; 2]> = index
        .lines()
        .skip(1)
        .map(|row| {
            let fields: Vec<&str> = row.split(',').collect();
            [fields[2], fields[3]]
        })
        .collect();
    // The numbers of cycle and variation.
    let expected = ["00", "01", "02", "10", "11", "12"];
    assert!(numbers.iter().map(|two| two.concat()).eq(expected));
}

#[test]
fn what_a_pack_does_not_state_of_a_body_is_measured_or_unknown_and_never_0() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let mut three = made(3, vec![5.0]);
    let stature_m = three[1].stature_m;
    for subject in &mut three[1..] {
        (subject.stature_m, subject.mass_kg) = (0.0, 0.0);
    }
    three[2].body.hulls.clear();
    (three[2].sex, three[2].age_years) = (None, None);
    let bytes = encode_subjects(&three, 5.0, &|| Ok(())).expect("a pack");
    fs::write(at.join("three.egp"), bytes).expect("a file");
    let results: Value =
        serde_json::from_str(&done(at, &["inspect", "three.egp", "--json", "-"])).expect("JSON");
    let [stated, measured, unknown] = [0, 1, 2].map(|at| &results["subjects"][at]);
    assert_eq!(stated["stature_from"], "pack");
    assert!(stated["mass_kg"].as_f64().is_some_and(|mass| mass > 40.0));
    assert_eq!(measured["stature_from"], "hulls");
    let height_m = measured["stature_m"].as_f64().expect("it has hulls");
    // The stature from soles to crown of the hulls; each point is within 2 mm.
    assert!(
        (height_m - stature_m).abs() < 0.03,
        "{height_m} {stature_m}"
    );
    for (subject, key) in [
        (measured, "mass_kg"),
        (unknown, "mass_kg"),
        (unknown, "stature_m"),
        (unknown, "stature_from"),
    ] {
        assert!(subject[key].is_null(), "{key}: {subject}");
    }
    let said = done(at, &["inspect", "three.egp"]);
    let row = |subject: &Value| {
        let name = subject["name"].as_str().expect("a name");
        let row = said
            .lines()
            .find(|line| line.starts_with(name))
            .expect("a row");
        let words = row.split_whitespace().skip(1).take(4);
        words.map(ToOwned::to_owned).collect::<Vec<String>>()
    };
    let years = measured["age_years"].as_u64().expect("an age").to_string();
    assert_eq!(
        row(measured),
        ["male", &years, &format!("~{height_m:.2}"), "-"]
    );
    assert_eq!(row(unknown), ["-", "-", "-", "-"]);
    assert!(
        said.contains("(~: the pack does not state the stature"),
        "{said}"
    );
}
