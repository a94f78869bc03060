//! Inputs that are not what their names say, or that another file states wrongly.

use crate::command::*;
use crate::exports::words;
use crate::recording::walk;
use crate::two::folder;
use image::{GrayImage, ImageEncoder as _, Luma};
use std::fs;
use std::path::Path;
use std::process::{Command, Output};

/// Runs the command under a program that bounds it.
fn bounded(at: &Path, by: &[&str], arguments: &[&str]) -> Output {
    Command::new(by[0])
        .args(&by[1..])
        .arg(env!("CARGO_BIN_EXE_edgegait"))
        .args(arguments)
        .env("EDGEGAIT_CACHE", "none")
        .current_dir(at)
        .output()
        .expect("the command starts")
}

#[cfg(unix)]
#[test]
fn a_pipe_is_refused_wherever_a_file_is_read() {
    let folder = folder();
    let at = folder.path();
    let pipe = |name: &str| {
        let path = at.join(name);
        fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
        let made = Command::new("mkfifo").arg(&path).status();
        assert!(made.expect("mkfifo starts").success());
    };
    walk(at, "walk.bvh", 0.0, |_, _| None);
    for (name, command) in [
        ("a.bvh", "import a.bvh"),
        ("a.c3d", "import a.c3d"),
        ("a.trc", "import a.trc"),
        ("a.glb", "import a.glb"),
        ("a.csv", "import walk.bvh --bodies a.csv"),
        ("a.obj", "import walk.bvh --body a.obj"),
        ("a.egp", "inspect a.egp"),
        ("views.csv", "sweep two.egp --views views.csv --out x"),
        ("a.toml", "generate a.toml --out x"),
        ("p.toml", "score pixels two.egp --protocol p.toml"),
        ("a.y4m", "segment a.y4m --out x"),
        ("a.onnx", "score a.onnx"),
        ("a.json", "bench --compare a.json a.json"),
        ("tree/p1/nm-01/090/1.png", "score pixels tree"),
        ("ds/geis.npy", "train ds --out x.onnx"),
    ] {
        pipe(name);
        if name.starts_with("ds") {
            fs::write(at.join("ds/index.csv"), "").expect("a file");
        }
        let output = bounded(at, &["timeout", "60"], &words(command));
        let error = text(&output.stderr);
        assert_eq!(code(&output), 1, "{command}: {error}");
        let expected = format!("{name}: expected a regular file, found a pipe");
        assert!(error.contains(&expected), "{command}: {error}");
    }
}

#[cfg(unix)]
#[test]
fn threads_that_the_system_refuses_are_an_error() {
    let folder = folder();
    // No system has this much room for a thread's stack.
    let output = bounded(
        folder.path(),
        &["env", "RUST_MIN_STACK=70368744177664"],
        &["bench", "--no-accuracy"],
    );
    let error = text(&output.stderr);
    assert_eq!(code(&output), 1, "{error}");
    assert!(
        error.starts_with("error: cannot start threads: "),
        "{error}"
    );
}

#[test]
fn a_manifest_with_an_impossible_angle_is_refused_at_its_line() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let frames = at.join("tree/101/nm-01/side");
    fs::create_dir_all(&frames).expect("a folder");
    let picture = GrayImage::from_fn(44, 64, |x, _| Luma([if x / 10 == 2 { 255 } else { 0 }]));
    picture.save(frames.join("001.png")).expect("a picture");
    fs::create_dir(at.join("clips")).expect("a folder");
    walk(&at.join("clips"), "a.bvh", 0.0, |_, _| None);
    for (angles, problem) in [
        ("999,0", "azimuth 999: expected degrees within -360..=360"),
        ("90,91", "elevation 91: expected degrees within -90..=90"),
    ] {
        let text =
            format!("id,take,view,azimuth,elevation,source\n101,nm-01,side,{angles},a.bvh\n");
        fs::write(at.join("m.csv"), text).expect("a manifest");
        let study = words("study tree clips --manifest m.csv --out o");
        refused(at, &study, 1, &[&format!("m.csv:2: {problem}")]);
    }
}

#[test]
fn a_body_that_cannot_be_encoded_names_its_file() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let good = walk(at, "good_1.bvh", 0.0, |_, _| None);
    // A neck of 50 m.
    let far = fs::read_to_string(good).expect("text");
    let far = far.replacen("OFFSET 0 35 0", "OFFSET 0 5000 0", 1);
    fs::write(at.join("far_1.bvh"), far).expect("a file");
    let import = words("import good_1.bvh far_1.bvh --out x.egp");
    let problem = "far_1.bvh: subject \"far\": a body with a coordinate of 50 m";
    refused(at, &import, 1, &[problem, "--keep-going"]);
    let said = done(at, &[&import[..], &["--keep-going"]].concat());
    assert!(said.contains("left out: far_1.bvh"), "{said}");
}

#[cfg(target_os = "linux")]
#[test]
fn a_picture_with_a_huge_profile_takes_little_memory() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let pixels: Vec<u8> = (0..50 * 30).map(|at| 50 + (at % 3) as u8).collect();
    let mut bytes = Vec::new();
    let mut encoder = image::codecs::png::PngEncoder::new(&mut bytes);
    encoder
        .set_icc_profile(vec![0; 300 << 20])
        .expect("a profile");
    let kind = image::ExtendedColorType::L8;
    encoder
        .write_image(&pixels, 30, 50, kind)
        .expect("a picture");
    assert!(bytes.len() < 1 << 20);
    let frames = at.join("tree/p1/nm-01/090");
    for folder in ["frames", "tree/p1/nm-01/090"] {
        fs::create_dir_all(at.join(folder)).expect("a folder");
    }
    for number in 1..=4 {
        fs::write(at.join(format!("frames/{number}.png")), &bytes).expect("a picture");
        fs::write(frames.join(format!("{number}.png")), &bytes).expect("a picture");
    }
    // At most 200 MB of data, in KB.
    let within = ["sh", "-c", "ulimit -d 200000 && exec \"$0\" \"$@\""];
    for command in [
        "segment frames --background frames/1.png --out x --threads 2",
        "sweep tree --cycles --out y --threads 2",
    ] {
        let output = bounded(at, &within, &words(command));
        let error = text(&output.stderr);
        assert!(matches!(code(&output), 0..=2), "{command}: {error}");
        assert!(!error.contains("memory"), "{command}: {error}");
    }
}

#[test]
fn a_damaged_pack_is_not_called_a_model() {
    let folder = folder();
    let at = folder.path();
    fs::write(at.join("empty.egp"), "").expect("a file");
    fs::write(at.join("cut.egp"), "EGP").expect("a file");
    fs::write(at.join("empty"), "").expect("a file");
    for command in ["score", "score pixels", "confounders", "bench side"] {
        for pack in ["empty.egp", "cut.egp"] {
            let problem = format!("{pack} at byte 0: expected \"EGPK\"");
            refused(at, &words(&format!("{command} {pack}")), 1, &[&problem]);
        }
        let problem = "empty: expected a model, a pack or a folder, found an empty file";
        refused(at, &words(&format!("{command} empty")), 1, &[problem]);
    }
}

#[test]
fn a_body_at_the_stated_limits_of_stature_and_mass_is_made() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    walk(at, "a_1.bvh", 0.0, |_, _| None);
    let import = "import a_1.bvh --out x.egp";
    // 12 and 60 kg/m2 at 0.5, 1.7 and 2.5 m.
    for (stature, masses) in [
        ("0.5", ["3", "15"]),
        ("1.7", ["34.68", "173.4"]),
        ("2.5", ["75", "375"]),
    ] {
        for mass in masses {
            let flags = format!("--stature-m {stature} --mass-kg {mass}");
            let said = done(at, &words(&format!("{import} {flags}")));
            assert!(said.contains("wrote x.egp"), "{said}");
        }
    }
    for flags in [
        "--stature-m 0.49 --mass-kg 4",
        "--stature-m 2.51 --mass-kg 120",
    ] {
        let problem = "expected 0.5 to 2.5 m";
        refused(
            at,
            &words(&format!("{import} {flags}")),
            2,
            &["a_1.bvh", problem],
        );
    }
    // As --bodies states them.
    let table = |row: &str| {
        fs::write(
            at.join("b.csv"),
            format!("subject,stature_mm,mass_kg\n{row}\n"),
        )
        .expect("a file");
    };
    table("a,9999,");
    let output = edgegait(at, &words(&format!("{import} --bodies b.csv")));
    let error = text(&output.stderr);
    let (_, range) = error.split_once(": expected ").expect("a range");
    let (low, rest) = range.split_once(" to ").expect("a range");
    let high = rest.split(' ').next().expect("a number");
    for stated in [low, high] {
        table(&format!("a,{stated},"));
        done(at, &words(&format!("{import} --bodies b.csv")));
    }
}

/// ESC, CSI of C1, BEL, a right-to-left override and a new line in names of people, files and keys.
#[cfg(unix)]
#[test]
fn names_from_files_reach_no_terminal_as_they_are() {
    const NAME: &str = "Zoë\u{1b}[31m\u{9b}7m\u{7}\u{202e}x\nerror: y";
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let is_hidden = |letter: char| {
        letter != '\n' && (letter.is_control() || matches!(letter, '\u{202a}'..='\u{202e}'))
    };
    let check = |command: &[&str]| {
        let output = edgegait(at, command);
        let said = text(&output.stdout) + &text(&output.stderr);
        assert!(!said.contains(is_hidden), "{command:?}: {said:?}");
        let lines = said.lines().filter(|line| line.starts_with("error: y"));
        assert_eq!(lines.count(), 0, "{command:?}: {said}");
        said
    };
    walk(at, &format!("{NAME}_1.bvh"), 0.0, |_, _| None);
    let file = format!("{NAME}_1.bvh");
    let shown = "Zoë\\u{1b}[31m\\u{9b}7m\\u{7}\\u{202e}x\\nerror: y";
    assert!(check(&["import", &file, "--out", "x.egp"]).contains("Zoë"));
    assert!(check(&["inspect", "x.egp"]).contains(shown));
    assert!(check(&["sweep", "x.egp", "--\u{1b}[31m\u{202e}x"]).contains("--\\u{202e}x"));
    fs::write(at.join(NAME), "{").expect("a file");
    assert!(check(&["render", NAME]).contains(shown));
    assert!(
        check(&["score", "pixels", "x.egp", "--protocol", NAME])
            .contains(NAME.split_once('\u{1b}').expect("a name").0)
    );
    let header = format!("YUV4MPEG2 W32 H24 F25:1 C{}\n", NAME.replace('\n', ""));
    fs::write(at.join("v.y4m"), header).expect("a file");
    assert!(check(&["segment", "v.y4m", "--out", "t"]).contains("\\u{1b}[31m"));
    // The page of a report.
    walk(at, "b_1.bvh", 5.0, |_, _| None);
    done(
        at,
        &["import", &file, "b_1.bvh", "--out", "two.egp", "--quiet"],
    );
    check(&["score", "pixels", "two.egp", "--out", "report"]);
    let page = fs::read_to_string(at.join("report/index.html")).expect("a page");
    assert!(!page.contains(is_hidden));
    // JSON keeps the name.
    let json = done(at, &["inspect", "x.egp", "--json", "-"]);
    let json: serde_json::Value = serde_json::from_str(&json).expect("JSON");
    let found = json["subjects"].to_string() + &json.to_string();
    assert!(found.contains("\\u001b[31m"), "{found}");
}

/// Errors about what a file holds, of code that knows numbers but no files.
#[test]
fn an_error_about_contents_names_the_files_that_were_read() {
    let folder = folder();
    let at = folder.path();
    let train = ["train", "two.egp", "--subjects", "F01", "--views", "side"];
    let said = "two.egp: training needs at least 2 classes, found 1";
    refused(at, &train, 1, &[said]);
    let built_in = "src/evaluate/protocols/casia-b.toml";
    let text = Path::new(env!("CARGO_MANIFEST_DIR")).join(built_in);
    let text = fs::read_to_string(text).expect("a protocol");
    let other = text.replace("conditions = \"casia-b\"", "conditions = \"rain\"");
    assert_ne!(other, text);
    fs::write(at.join("p.toml"), other).expect("written");
    let score = ["score", "pixels", "two.egp", "--protocol", "p.toml"];
    refused(
        at,
        &score,
        1,
        &["p.toml: conditions: there is no set of conditions \"rain\""],
    );
    // A file that is missing is read only if no other conditions replace it.
    let other = text.replace("conditions = \"casia-b\"", "conditions = \"gone.toml\"");
    fs::write(at.join("p.toml"), other).expect("written");
    refused(at, &score, 1, &["gone.toml: No such file"]);
    let replaced = [&score[..], &["--conditions", "casia-b"]].concat();
    refused(at, &replaced, 1, &["no take is in its gallery"]);
}
