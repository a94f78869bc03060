//! The built command: exit codes, files, and what is printed where.

use edgegait::encode::encode_subjects;
use edgegait::scene::Subject;
use edgegait::scene::cohort::{self, CohortOptions};
use serde_json::Value;
use sha2::{Digest, Sha256};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::sync::OnceLock;
use tempfile::TempDir;

fn edgegait(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_edgegait"))
        .args(arguments)
        .current_dir(folder)
        .output()
        .expect("the command starts")
}

fn code(output: &Output) -> i32 {
    output.status.code().expect("an exit code")
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).expect("UTF-8")
}

/// Runs what must succeed; its standard output.
fn done(folder: &Path, arguments: &[&str]) -> String {
    let output = edgegait(folder, arguments);
    assert_eq!(code(&output), 0, "{arguments:?}: {}", text(&output.stderr));
    text(&output.stdout)
}

/// Runs what must fail with `expected` and print nothing but an error that holds all of
/// `words`.
fn refused(folder: &Path, arguments: &[&str], expected: i32, words: &[&str]) {
    let output = edgegait(folder, arguments);
    let error = text(&output.stderr);
    assert_eq!(code(&output), expected, "{arguments:?}: {error}");
    assert!(
        output.stdout.is_empty(),
        "{arguments:?}: {}",
        text(&output.stdout)
    );
    let is_error = error.lines().any(|line| line.starts_with("error: "));
    assert!(is_error, "{arguments:?}: {error}");
    for word in words {
        assert!(error.contains(word), "{arguments:?}: {error}");
    }
}

/// A folder with `two.egp`: F01 and M01 at 4 and 8 km/h.
fn folder() -> TempDir {
    static PACK: OnceLock<Vec<u8>> = OnceLock::new();
    let bytes = PACK.get_or_init(|| {
        let folder = tempfile::tempdir().expect("a folder");
        done(folder.path(), &COHORT);
        fs::read(folder.path().join("two.egp")).expect("the pack")
    });
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join("two.egp"), bytes).expect("the pack");
    folder
}

const COHORT: [&str; 7] = [
    "cohort",
    "--people",
    "2",
    "--speeds-kmh",
    "4,8",
    "--out",
    "two.egp",
];

fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> = fs::read_dir(folder)
        .expect("a folder")
        .map(|entry| {
            entry
                .expect("an entry")
                .file_name()
                .to_string_lossy()
                .into()
        })
        .collect();
    names.sort();
    names
}

fn sha256(path: PathBuf) -> String {
    let digest = Sha256::digest(fs::read(path).expect("a file"));
    digest.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// Shape and bytes of an npy file of `u8`, read by the format's description (NEP 1).
fn npy(path: PathBuf) -> (String, Vec<u8>) {
    let bytes = fs::read(path).expect("a file");
    assert_eq!(&bytes[..8], b"\x93NUMPY\x01\x00");
    let end = 10 + usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
    let header = text(&bytes[10..end]);
    assert!(header.contains("'descr': '|u1'"), "{header}");
    assert!(header.contains("'fortran_order': False"), "{header}");
    let shape = header.split_once("'shape': (").expect("a shape").1;
    let shape = shape.split_once(')').expect("a shape").0;
    (
        shape.trim_end_matches([',', ' ']).into(),
        bytes[end..].to_vec(),
    )
}

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
    let version = format!("edgegait {}\n", env!("CARGO_PKG_VERSION"));
    assert_eq!(done(folder.path(), &["--version"]), version);
}

#[test]
fn what_makes_no_sense_is_exit_code_2_and_leaves_no_file() {
    let folder = folder();
    let at = folder.path();
    for (arguments, words) in [
        (
            "render two.egp --subjects Nobody",
            ["\"Nobody\"", "F01, M01"],
        ),
        (
            "sweep two.egp --walks fly-9kmh",
            ["\"fly-9kmh\"", "walk-4kmh, run-8kmh"],
        ),
        (
            "render two.egp --azimuth-deg nan",
            ["azimuth", "expected degrees"],
        ),
        (
            "render two.egp --azimuth-deg 1e9",
            ["azimuth 1000000000", "expected degrees"],
        ),
        (
            "sweep two.egp --azimuth-deg 400",
            ["azimuth 400", "-360..=360"],
        ),
        (
            "cohort --speeds-kmh 5,4,5 --out new.egp",
            ["5 km/h twice", "once"],
        ),
        (
            "render two.egp --elevation-deg 91",
            ["elevation 91", "-90..=90"],
        ),
        (
            "sweep two.egp --elevation-deg -90.5",
            ["elevation -90.5", "-90..=90"],
        ),
        ("render two.egp --views front", ["\"front\"", "paper"]),
        (
            "render two.egp --views side --azimuth-deg 3",
            ["--views", "--azimuth-deg"],
        ),
        (
            "render two.egp --out walk.gif",
            ["walk.gif", ".png or .npy"],
        ),
        ("render two.egp --template gei", ["--template", "--out"]),
        ("render two.egp --template jpeg", ["jpeg", "gei"]),
        ("render two.egp --raster crayon", ["crayon", "skia"]),
        ("render two.egp --frames-per-cycle 0", ["0", "1..=4096"]),
        ("inspect two.egp --threads 0", ["--threads", "0"]),
        ("sweep two.egp --seed -1", ["-1", "--"]),
        ("inspect two.egp --verbose", ["--verbose", "unexpected"]),
        ("inspect two.egp three.egp", ["three.egp", "unexpected"]),
        ("cohort --people 0 --out new.egp", ["0", "1..=999"]),
        (
            "cohort --speeds-kmh 2.9 --out new.egp",
            ["2.9 km/h", "3 to 12"],
        ),
        (
            "cohort --speeds-kmh nan --out new.egp",
            ["NaN km/h", "3 to 12"],
        ),
        (
            "cohort --max-error-mm nan --out new.egp",
            ["--max-error-mm", "0 or more"],
        ),
        ("dance", ["dance", "unrecognized"]),
    ] {
        let arguments: Vec<&str> = arguments.split(' ').collect();
        refused(at, &arguments, 2, &words);
    }
    assert_eq!(code(&edgegait(at, &[])), 2);
    assert_eq!(names(at), ["two.egp"]);
}

#[test]
fn a_bad_pack_is_exit_code_1_and_the_message_names_file_and_byte() {
    let folder = folder();
    let at = folder.path();
    let whole = fs::read(at.join("two.egp")).expect("the pack");
    let write = |name: &str, bytes: &[u8]| fs::write(at.join(name), bytes).expect("a file");
    write("cut.egp", &whole[..whole.len() - 1]);
    write("head.egp", &whole[..40]);
    let mut damaged = whole.clone();
    damaged[500] ^= 4;
    write("damaged.egp", &damaged);
    let mut future = whole.clone();
    future[4] = 2;
    write("future.egp", &future);
    write("note.egp", b"not a pack");
    write("empty.egp", b"");
    fs::create_dir(at.join("folder.egp")).expect("a folder");
    let large = fs::File::create(at.join("large.egp")).expect("a file");
    large.set_len((16 << 20) + 1).expect("a sparse file");
    for (name, words) in [
        ("cut.egp", " at byte 8: expected the length of the file"),
        ("head.egp", " at byte 40: expected the rest of the header"),
        ("damaged.egp", " at byte 12: expected the CRC-32"),
        ("future.egp", " at byte 4: expected version 1"),
        ("note.egp", " at byte 0: expected \"EGPK\""),
        ("empty.egp", " at byte 0: expected \"EGPK\""),
        ("missing.egp", ": No such file"),
        ("folder.egp", ": Is a directory"),
        (
            "large.egp",
            ": 16777217 bytes, expected a pack of at most 16777216",
        ),
    ] {
        for command in ["inspect", "render", "sweep"] {
            refused(at, &[command, name], 1, &[&format!("{name}{words}")]);
        }
    }
}

#[test]
fn a_bad_list_of_viewpoints_is_exit_code_1_and_the_message_names_its_line() {
    let folder = folder();
    let at = folder.path();
    let render = ["render", "two.egp", "--views", "views.csv"];
    refused(at, &render, 1, &["views.csv: No such file"]);
    for (rows, words) in [
        (
            "azimuth_deg,elevation_deg\n90,0\n0,91\n",
            "views.csv:3: elevation 91",
        ),
        ("azimuth_deg,elevation_deg\nleft,0\n", "views.csv:2: "),
        ("azimuth_deg,elevation_deg\n", "views.csv: no viewpoints"),
        ("angle\n5\n", "views.csv:2: "),
    ] {
        fs::write(at.join("views.csv"), rows).expect("a file");
        refused(at, &render, 1, &[words]);
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
        // One document and nothing behind it: anything else is an error.
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
    let missing = ["inspect", "two.egp", "--json", "no/result.json"];
    let output = edgegait(at, &missing);
    assert_eq!(code(&output), 1);
    assert!(text(&output.stderr).contains("no/result.json"));
    assert_eq!(names(at), ["result.json", "two.egp"]);
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
    let sections = ["names", "subjects", "walks", "avatars", "clips"].map(section);
    // 16 bytes of header and a table of five sections of 12.
    assert_eq!(sections.iter().sum::<u64>() + 76, length);
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
        let mut all = vec!["render", "two.egp", "--out", "x.npy"];
        all.extend(arguments.split_whitespace());
        assert_eq!(done(at, &all), "wrote x.npy\n");
        let (found, pixels) = npy(at.join("x.npy"));
        assert_eq!(found, shape, "{arguments}");
        assert_eq!(pixels.len(), frames * 1_500);
        let is_binary = pixels.iter().all(|&pixel| pixel == 0 || pixel == 255);
        assert_eq!(is_binary, !arguments.contains("gei"), "{arguments}");
        for (index, frame) in pixels.chunks(1_500).enumerate() {
            // A person fills the 50 rows, and more than a line.
            let on = frame.iter().filter(|&&pixel| pixel > 0).count();
            assert!((100..1_500).contains(&on), "{arguments}: {on} in {index}");
            for row in [0, 49] {
                let row = &frame[30 * row..][..30];
                assert!(row.iter().any(|&pixel| pixel > 0), "{arguments}: {index}");
            }
        }
    }
    done(
        at,
        &["render", "two.egp", "--raster", "skia-aa", "--out", "x.npy"],
    );
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
fn a_dataset_is_refused_a_second_time_and_replaced_when_asked() {
    let folder = folder();
    let at = folder.path();
    let sweep = [
        "sweep", "two.egp", "--views", "side", "--cycles", "2", "--out", "side",
    ];
    done(at, &sweep);
    assert_eq!(
        names(&at.join("side")),
        ["geis.npy", "index.csv", "manifest.json"]
    );
    let (shape, pixels) = npy(at.join("side/geis.npy"));
    // Two people, two walks, two cycles, one view.
    assert_eq!((shape.as_str(), pixels.len()), ("8, 50, 30", 12_000));
    let index = fs::read_to_string(at.join("side/index.csv")).expect("the index");
    let rows: Vec<&str> = index.lines().collect();
    assert_eq!(rows.len(), 9);
    assert!(rows[1].starts_with("F01,walk-4kmh,0,4"), "{}", rows[1]);
    assert!(rows[4].starts_with("F01,run-8kmh,1,8"), "{}", rows[4]);
    let manifest = fs::read_to_string(at.join("side/manifest.json")).expect("the manifest");
    let manifest: Value = serde_json::from_str(&manifest).expect("JSON");
    assert_eq!(manifest["geis"], 8);
    for (file, name) in ["geis.npy", "index.csv"].into_iter().enumerate() {
        assert_eq!(manifest["files"][file]["path"], name);
        assert_eq!(
            manifest["files"][file]["sha256"],
            sha256(at.join("side").join(name)).as_str()
        );
    }

    let other = [&sweep[..], &["--seed", "2"]].concat();
    refused(at, &other, 2, &["side", "overwrite"]);
    assert_eq!(npy(at.join("side/geis.npy")).1, pixels);
    done(at, &[&other[..], &["--overwrite"]].concat());
    let replaced = npy(at.join("side/geis.npy")).1;
    // Stored cycles stay, variations change.
    assert_eq!(replaced[..1_500], pixels[..1_500]);
    assert_ne!(replaced[1_500..3_000], pixels[1_500..3_000]);

    fs::write(at.join("side/thesis.txt"), "mine").expect("a file");
    refused(
        at,
        &[&sweep[..], &["--overwrite"]].concat(),
        2,
        &["thesis.txt"],
    );
    assert_eq!(npy(at.join("side/geis.npy")).1, replaced);
    assert_eq!(names(at), ["side", "two.egp"]);
}

#[test]
fn a_sweep_that_fails_on_its_way_leaves_nothing() {
    let folder = folder();
    let at = folder.path();
    // A second person without hulls, who cannot be drawn.
    let mut two = made(2, vec![5.0]);
    two[1].body.hulls.clear();
    two[1].walks[0].name = "ghost-walk".into();
    let bytes = encode_subjects(&two, 5.0, &|| ()).expect("a pack");
    fs::write(at.join("ghost.egp"), bytes).expect("a file");
    let sweep = ["sweep", "ghost.egp", "--views", "side", "--out", "new"];
    refused(at, &sweep, 1, &["\"ghost-walk\"", "no points"]);
    assert_eq!(names(at), ["ghost.egp", "two.egp"]);
    done(at, &[&sweep[..], &["--subjects", "F01"]].concat());
    refused(
        at,
        &[&sweep[..], &["--overwrite"]].concat(),
        1,
        &["no points"],
    );
    assert_eq!(npy(at.join("new/geis.npy")).0, "1, 50, 30");
    assert_eq!(names(at), ["ghost.egp", "new", "two.egp"]);
}

/// People of the cohort at these speeds, before they are encoded.
fn made(people: usize, speeds_kmh: Vec<f64>) -> Vec<Subject> {
    let options = CohortOptions {
        seed: 1,
        people,
        speeds_kmh,
    };
    cohort::subjects(&options).expect("people")
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
    fs::write(at.join("real.json"), "former").expect("a file");
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
    // Both ends are held open here, so that neither side waits for ever.
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
    let bytes = encode_subjects(&one, 5.0, &|| ()).expect("a pack");
    fs::write(at.join("ann.egp"), bytes).expect("a file");
    done(
        at,
        &[
            "sweep", "ann.egp", "--views", "side", "--cycles", "3", "--out", "new",
        ],
    );
    let index = fs::read_to_string(at.join("new/index.csv")).expect("the index");
    let cycles: Vec<&str> = index
        .lines()
        .skip(1)
        .map(|row| row.split(',').nth(2).expect("a cycle"))
        .collect();
    assert_eq!(cycles, ["0", "1", "2", "3", "4", "5"]);
}
