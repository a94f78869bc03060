//! Datasets in other formats and in shards, and resumed runs.

use crate::command::*;
use crate::figure::write_turning_figure;
use crate::npy::npy;
use crate::two::folder;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

pub fn words(command: &str) -> Vec<&str> {
    command.split_whitespace().collect()
}

/// Returns all files under a folder with their bytes.
pub fn files(root: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut found = BTreeMap::new();
    let mut folders = vec![root.to_path_buf()];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).expect("a folder") {
            let path = entry.expect("an entry").path();
            if path.is_dir() {
                folders.push(path);
            } else {
                let name = path.strip_prefix(root).expect("inside").to_path_buf();
                found.insert(name, fs::read(&path).expect("a file"));
            }
        }
    }
    found
}

/// Returns the shape and the numbers of an array of f32, read as the format's description (NEP 1)
/// says.
fn floats(path: impl AsRef<Path>) -> (String, Vec<f32>) {
    let bytes = fs::read(path).expect("a file");
    let header = String::from_utf8_lossy(&bytes[10..128]);
    assert!(header.contains("'descr': '<f4'"), "{header}");
    let shape = header.split_once("'shape': (").expect("a shape").1;
    let shape = shape.split_once(')').expect("a shape").0.to_owned();
    let numbers = bytes[128..].chunks_exact(4);
    let numbers = numbers.map(|four| f32::from_le_bytes(four.try_into().expect("four")));
    (shape, numbers.collect())
}

fn column<'t>(table: &'t str, name: &str) -> Vec<&'t str> {
    let mut lines = table.lines();
    let at = lines
        .next()
        .expect("columns")
        .split(',')
        .position(|it| it == name);
    let at = at.expect("such a column");
    lines
        .map(|line| line.split(',').nth(at).expect("a field"))
        .collect()
}

pub const DESIGN: &str = r#"seed = 1
conditions = "casia-b"
[walks]
takes = 2
cycles = 2
[views]
azimuth_deg = [0, 22.5, 90]
elevation_deg = [0, 15]
[images]
raster = "rows"
[splits]
train = "0..3"
test = "3..5"
"#;

#[test]
fn templates_of_one_pass_are_those_of_separate_passes() {
    let folder = folder();
    let at = folder.path();
    let sweep = "sweep two.egp --views side --cycles 2 --conditions casia-b";
    done(
        at,
        &words(&format!("{sweep} --template mhi,silhouettes,gei --out all")),
    );
    done(at, &words(&format!("{sweep} --template mhi --out mhi")));
    done(at, &words(&format!("{sweep} --out gei")));
    let (shape, silhouettes) = npy(at.join("all/silhouettes.npy"));
    let (_, geis) = npy(at.join("all/geis.npy"));
    assert_eq!(npy(at.join("all/mhi.npy")), npy(at.join("mhi/mhi.npy")));
    assert_eq!(geis, npy(at.join("gei/geis.npy")).1);
    let rows = geis.len() / 1_500;
    assert_eq!(shape, format!("{}, 50, 30", rows * 32));
    // The GEI of a row is the mean of its silhouettes, rounded half up.
    for (cycle, gei) in silhouettes
        .chunks_exact(32 * 1_500)
        .zip(geis.chunks_exact(1_500))
    {
        for (pixel, &mean) in gei.iter().enumerate() {
            let column = cycle.iter().skip(pixel).step_by(1_500);
            let sum: u32 = column.map(|&byte| u32::from(byte)).sum();
            assert_eq!(u32::from(mean), (sum + 16) / 32);
        }
    }
    // A dataset of several templates is read as the first one.
    let score = done(at, &words("score pixels all --json -"));
    assert!(score.contains("rank1"), "{score}");
    let first = "sweep two.egp --views side --template silhouettes,gei --out sequences";
    done(at, &words(first));
    refused(
        at,
        &words("score pixels sequences"),
        1,
        &["found silhouettes", "--template gei"],
    );
}

#[test]
fn frames_a_second_make_cycles_of_their_own_length_and_whole_takes() {
    let folder = folder();
    let at = folder.path();
    let sweep = "sweep two.egp --views side --template silhouettes --fps 30 --out cycles";
    done(at, &words(sweep));
    let inspected: serde_json::Value =
        serde_json::from_str(&done(at, &words("inspect two.egp --json -"))).expect("JSON");
    let index = fs::read_to_string(at.join("cycles/index.csv")).expect("a table");
    let clips = inspected["clips"].as_array().expect("clips");
    let frames = column(&index, "frames");
    assert_eq!(frames.len(), clips.len());
    let (shape, _) = npy(at.join("cycles/silhouettes.npy"));
    let all: u32 = frames
        .iter()
        .map(|it| it.parse::<u32>().expect("a count"))
        .sum();
    assert_eq!(shape, format!("{all}, 50, 30"));
    // A cycle is two steps.
    for (frames, clip) in frames.iter().zip(clips) {
        let cadence = clip["cadence_spm"].as_f64().expect("steps a minute");
        let expected = (30.0 * 120.0 / cadence).round();
        assert!((frames.parse::<f64>().expect("a count") - expected).abs() <= 1.0);
    }

    write_turning_figure(&at.join("anna_turn.bvh"), 150);
    done(
        at,
        &words("import anna_turn.bvh --track clip --out turn.egp"),
    );
    let sweep = "sweep turn.egp --azimuth-deg 0,90 --template silhouettes --joints --out turn";
    done(at, &words(sweep));
    // 149 / 50 s at 25 a second.
    let (shape, silhouettes) = npy(at.join("turn/silhouettes.npy"));
    assert_eq!(shape, "150, 50, 30");
    assert_eq!(floats(at.join("turn/joints.npy")).0, "150, 19, 3");
    let render = "render turn.egp --azimuth-deg 0,90 --fps 25 --frames 75 --out render.npy";
    done(at, &words(render));
    assert_eq!(npy(at.join("render.npy")).1, silhouettes);
    for (flags, problem) in [
        ("", "a GEI needs a gait cycle"),
        (
            "--template silhouettes --cycles 2",
            "which has no variations",
        ),
        ("--template silhouettes --fps 9999", "found 29798"),
    ] {
        let sweep = format!("sweep turn.egp --out refused {flags}");
        if problem.starts_with("found") {
            refused(
                at,
                &words(&format!("{sweep} --views paper")),
                2,
                &["of a walk in memory"],
            );
        } else {
            let output = edgegait(at, &words(&sweep));
            assert!(text(&output.stderr).contains(problem), "{flags}");
            assert_ne!(code(&output), 0);
        }
        assert!(!at.join("refused").exists() && !at.join("refused.unfinished").exists());
    }
}

#[test]
fn joints_appear_where_parallel_rays_and_a_camera_put_them() {
    let folder = folder();
    let at = folder.path();
    let sweep = "sweep two.egp --azimuth-deg 90 --joints --template silhouettes,gei";
    // The pixels of a metre for a camera 4 m away with a field of view of 45 degrees.
    done(
        at,
        &words(&format!(
            "{sweep} --framing camera --size 64x64 --out camera"
        )),
    );
    let (_, joints) = floats(at.join("camera/joints.npy"));
    let (shape, keypoints) = floats(at.join("camera/keypoints.npy"));
    assert!(shape.ends_with(", 19, 2"), "{shape}");
    let scale = 64.0 / (2.0 * 4.0 * (22.5_f32).to_radians().tan());
    for (joints, keypoints) in joints.chunks_exact(57).zip(keypoints.chunks_exact(38)) {
        for (joint, keypoint) in joints.chunks_exact(3).zip(keypoints.chunks_exact(2)) {
            // From the walker's left, ahead is to the left; the pelvis is in the middle.
            let column = 32.0 - scale * (joint[2] - joints[2]);
            let row = 32.0 - scale * (joint[1] - joints[1]);
            assert!((keypoint[0] - column).abs() < 1e-3, "{keypoint:?} {column}");
            assert!((keypoint[1] - row).abs() < 1e-3, "{keypoint:?} {row}");
        }
    }
    // In each framing, and with segmentation faults, the joints of the trunk and the thighs lie in
    // the figure.
    for flags in [
        "",
        "--framing box",
        "--framing cycle --azimuth-deg 40",
        "--lens persp --distance-m 2 --jitter r2",
        "--conditions dilated.toml",
        "--conditions dilated.toml --framing box",
        "--conditions dilated.toml --framing camera",
    ] {
        let dilated = "[[conditions]]\nname = \"dilated\"\nconfounders = { dilation = 0.2 }\n";
        fs::write(at.join("dilated.toml"), dilated).expect("a file");
        let views = if flags.contains("azimuth") {
            ""
        } else {
            "--azimuth-deg 90"
        };
        let sweep =
            format!("sweep two.egp {views} --joints --template silhouettes {flags} --out joints");
        done(at, &words(&sweep));
        let (_, keypoints) = floats(at.join("joints/keypoints.npy"));
        let (_, silhouettes) = npy(at.join("joints/silhouettes.npy"));
        let frames = silhouettes
            .chunks_exact(1_500)
            .zip(keypoints.chunks_exact(38));
        for (silhouette, keypoints) in frames {
            // Pelvis, spine, thorax, neck, thighs and shanks; only the trunk's joints for a small
            // figure.
            let joints: &[usize] = if flags.contains("camera") {
                &[0, 1, 2]
            } else {
                &[0, 1, 2, 3, 13, 14, 16, 17]
            };
            for &joint in joints {
                let [x, y] = [keypoints[2 * joint], keypoints[2 * joint + 1]];
                let on = silhouette[y as usize * 30 + x as usize];
                assert_eq!(on, 255, "{flags}: joint {joint} at {x} {y}");
            }
        }
    }
    let distorted = "[[conditions]]\nname = \"bent\"\nconfounders = { radial-distortion = 0.5 }\n";
    fs::write(at.join("bent.toml"), distorted).expect("a file");
    let sweep = "sweep two.egp --joints --views side --conditions bent.toml --out refused";
    refused(
        at,
        &words(sweep),
        1,
        &["bent", "joint positions are unknown"],
    );
}

#[test]
fn trees_are_read_again_as_they_were_drawn() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    fs::write(at.join("d.toml"), DESIGN).expect("a design");
    for (format, size) in [("opengait", "64x64"), ("casia-b", "50x30")] {
        let generate = format!("generate d.toml --out {format} --format {format}");
        done(at, &words(&generate));
        let table = fs::read_to_string(at.join(format).join("sequences.csv")).expect("a table");
        // Five people, two takes under three conditions, six viewpoints.
        assert_eq!(column(&table, "path").len(), 5 * 6 * 6);
        // Two cycles, one after the other.
        assert!(
            column(&table, "frames")
                .iter()
                .all(|&frames| frames == "64")
        );
        let path = column(&table, "path")[1].to_owned();
        assert!(path.contains("-01/000e15"), "{path}");
        let views = names(&at.join(format).join("F01/walk-5kmh-BG-02"));
        assert_eq!(
            views,
            ["000", "000e15", "022.5", "022.5e15", "090", "090e15"]
        );
        let score = format!("score pixels {format} --json {format}.json");
        if size == "50x30" {
            done(at, &words(&score));
        }
    }
    let partition = fs::read_to_string(at.join("opengait/partition.json")).expect("JSON");
    let partition: serde_json::Value = serde_json::from_str(&partition).expect("JSON");
    assert_eq!(
        partition["TRAIN_SET"],
        serde_json::json!(["F01", "M01", "F02"])
    );
    assert_eq!(partition["TEST_SET"], serde_json::json!(["M02", "F03"]));

    // The silhouettes are those of the arrays.
    let arrays = DESIGN.replace(
        "raster",
        "template = \"silhouettes\"\nsize = \"64x64\"\nraster",
    );
    fs::write(at.join("arrays.toml"), arrays).expect("a design");
    done(at, &words("generate arrays.toml --out arrays"));
    let (_, silhouettes) = npy(at.join("arrays/train/silhouettes.npy"));
    let pickle = fs::read(at.join("opengait/F01/walk-5kmh-NM-01/000/000.pkl")).expect("a pickle");
    let bytes = 32 * 64 * 64;
    let stored = &pickle[pickle.len() - 3 - 2 * bytes..pickle.len() - 3];
    assert_eq!(stored[..bytes], silhouettes[..bytes]);

    // A tree of EdgeGait is replaced by the same bytes, but not if it has other files.
    let again = "generate d.toml --format opengait --out opengait";
    let before = files(&at.join("opengait"));
    done(at, &words(again));
    assert!(files(&at.join("opengait")) == before);
    for other in ["mine.txt", "F01/mine.txt", "F01/walk-5kmh-NM-01/000/1.pkl"] {
        fs::write(at.join("opengait").join(other), "mine").expect("written");
        for flags in ["", "--overwrite"] {
            let problem = format!("holds {other}, which is not part of a dataset");
            refused(at, &words(&format!("{again} {flags}")), 2, &[&problem]);
        }
        fs::remove_file(at.join("opengait").join(other)).expect("removed");
    }
    fs::create_dir(at.join("opengait/F01/mine")).expect("made");
    refused(at, &words(again), 2, &["holds F01/mine, which"]);

    for (command, problem) in [
        (
            "sweep --format opengait --size 50x30 --out t",
            "found --size 50x30",
        ),
        (
            "sweep --format opengait --template gei --out t",
            "no other template",
        ),
        (
            "sweep --format casia-b --joints --out t",
            "does not store joints",
        ),
        (
            "sweep --format npz --shard 1/2 --out t",
            "a shard is a folder",
        ),
    ] {
        refused(at, &words(command), 2, &[problem]);
    }
}

#[test]
fn the_users_own_geis_are_trained_with_and_scored() {
    let folder = folder();
    let at = folder.path();
    done(
        at,
        &words("sweep two.egp --azimuth-deg 0,90 --cycles 4 --out made"),
    );
    let table = fs::read_to_string(at.join("made/index.csv")).expect("a table");
    fs::create_dir(at.join("mine")).expect("made");
    fs::copy(at.join("made/geis.npy"), at.join("mine/geis.npy")).expect("copied");
    let columns = ["subject", "walk", "azimuth_deg"].map(|name| column(&table, name));
    let rows =
        (0..columns[0].len()).map(|row| columns.each_ref().map(|column| column[row]).join(","));
    let mine: Vec<String> = rows.collect();
    let mine = format!("subject,walk,azimuth_deg\n{}\n", mine.join("\n"));
    fs::write(at.join("mine/index.csv"), mine).expect("a table");
    for (data, model) in [("made", "a"), ("mine", "b")] {
        done(
            at,
            &words(&format!("train {data} --out {model}.onnx --components 4")),
        );
    }
    let rank1 = |model: &str, data: &str| {
        let said = done(
            at,
            &words(&format!(
                "score {model} {data} --protocol leave-one-take-out --json -"
            )),
        );
        let said: serde_json::Value = serde_json::from_str(&said).expect("JSON");
        said["recognizers"][0]["rank1"].clone()
    };
    assert_eq!(rank1("pixels", "mine"), rank1("pixels", "made"));
    assert_eq!(rank1("b.onnx", "mine"), rank1("a.onnx", "made"));
}

#[test]
fn shards_put_together_are_the_bytes_of_one_run() {
    let folder = folder();
    let at = folder.path();
    let design = DESIGN.replace("[0, 22.5, 90]", "[22.5]");
    fs::write(at.join("d.toml"), design).expect("a design");
    let sweep = "sweep two.egp --azimuth-deg 0,90 --cycles 3 --conditions casia-b --template gei,silhouettes --joints";
    for (name, command, part) in [
        ("sweep", sweep, ""),
        ("folder", "generate d.toml", "train"),
        ("opengait", "generate d.toml --format opengait", ""),
        ("casia-b", "generate d.toml --format casia-b", ""),
    ] {
        let at = at.join(name);
        fs::create_dir(&at).expect("made");
        for file in ["two.egp", "d.toml"] {
            fs::copy(folder.path().join(file), at.join(file)).expect("copied");
        }
        done(&at, &words(&format!("{command} --out whole")));
        // With one thread and with two.
        for number in 1..=2 {
            let threads = number;
            let shard = format!("{command} --shard {number}/2 --threads {threads} --out s{number}");
            done(&at, &words(&shard));
        }
        let merge = format!("merge s2/{part} s1/{part} --out merged");
        done(&at, &words(&merge));
        assert!(
            files(&at.join("merged")) == files(&at.join("whole").join(part)),
            "{name}"
        );

        for (shards, code, problem) in [
            (format!("s1/{part}"), 2, "no shard 2/2"),
            (format!("s1/{part} s1/{part}"), 2, "both shard 1/2"),
            (
                format!("whole/{part} s2/{part}"),
                1,
                "found a whole dataset",
            ),
        ] {
            let merge = format!("merge {shards} --out other");
            refused(&at, &words(&merge), code, &[problem]);
            assert!(!at.join("other").exists() && !at.join("other.unfinished").exists());
        }
        // A shard whose manifest counts one row more than it has.
        let manifest = at.join("s2").join(part).join("manifest.json");
        let right = fs::read_to_string(&manifest).expect("a manifest");
        let rows: serde_json::Value = serde_json::from_str(&right).expect("JSON");
        let rows = rows["geis"].as_u64().expect("a number");
        let wrong = right.replacen(
            &format!("\"geis\": {rows}"),
            &format!("\"geis\": {}", rows + 1),
            1,
        );
        fs::write(&manifest, wrong).expect("written");
        let merge = format!("merge s1/{part} s2/{part} --out other");
        let problem = format!(
            "expected {} rows, as manifest.json says, found {rows}",
            rows + 1
        );
        refused(&at, &words(&merge), 1, &[&problem]);
        assert!(!at.join("other").exists());
        fs::write(&manifest, right).expect("written");
        fs::remove_dir_all(at.join("other.unfinished")).expect("removed");
        // A shard with a changed byte.
        let table = at.join("s2").join(part).join("index.csv");
        let changed = fs::read_to_string(&table)
            .expect("a table")
            .replace("kmh", "hmk");
        fs::write(&table, changed).expect("written");
        let merge = format!("merge s1/{part} s2/{part} --out other");
        refused(
            &at,
            &words(&merge),
            1,
            &["index.csv: expected SHA-256", "make the shard again"],
        );
        assert!(!at.join("other").exists());
    }
    let other = "sweep two.egp --azimuth-deg 0,90 --cycles 2 --shard 2/2 --out other";
    done(at, &words(other));
    let merge = "merge sweep/s1 other --out merged";
    refused(
        at,
        &words(merge),
        1,
        &["it belongs to another run than sweep/s1: "],
    );
    refused(
        at,
        &words("sweep two.egp --shard 3/2 --out x"),
        2,
        &["from 1/N to N/N"],
    );
    let many = "generate d.toml --shard 6/9 --out x";
    refused(at, &words(many), 2, &["only 2 pieces of work"]);
}

#[test]
fn an_npz_holds_the_arrays_and_the_columns_and_is_the_same_again() {
    let folder = folder();
    let at = folder.path();
    let sweep = "sweep two.egp --azimuth-deg 0,90 --cycles 3";
    done(at, &words(&format!("{sweep} --out folder")));
    done(
        at,
        &words(&format!("{sweep} --format npz --out a.npz --threads 1")),
    );
    done(at, &words(&format!("{sweep} --format npz --out b.npz")));
    let bytes = fs::read(at.join("a.npz")).expect("a file");
    assert!(bytes == fs::read(at.join("b.npz")).expect("a file"));
    assert_eq!(names(at), ["a.npz", "b.npz", "folder", "two.egp"]);
    // Entries are stored uncompressed.
    let holds = |part: &[u8]| bytes.windows(part.len()).any(|window| window == part);
    assert!(holds(
        &fs::read(at.join("folder/geis.npy")).expect("a file")
    ));
    let angles = [0.0_f64, 90.0].into_iter().cycle().take(12);
    assert!(holds(
        &angles.flat_map(f64::to_le_bytes).collect::<Vec<_>>()
    ));
    // An earlier file is replaced, or found to be complete; a file of another program is kept.
    done(at, &words(&format!("{sweep} --format npz --out b.npz")));
    let resumed = format!("{sweep} --format npz --out b.npz --resume");
    let said = done(at, &words(&resumed));
    assert!(said.contains("b.npz is already complete"), "{said}");
    assert!(bytes == fs::read(at.join("b.npz")).expect("a file"));
    fs::write(at.join("c.npz"), "mine").expect("written");
    let other = format!("{sweep} --format npz --out c.npz");
    refused(at, &words(&other), 2, &["already exists", "--overwrite"]);

    // The first of two splits is complete when the second is interrupted.
    fs::write(at.join("d.toml"), DESIGN).expect("a design");
    let generate = "generate d.toml --format npz --out sets";
    done(at, &words(generate));
    let whole = files(&at.join("sets"));
    fs::remove_file(at.join("sets/test.npz")).expect("removed");
    done(at, &words(&format!("{generate} --resume")));
    assert!(files(&at.join("sets")) == whole);
}
