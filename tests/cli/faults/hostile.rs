//! Files and folders that are made to break what reads them.

use crate::command::*;
use crate::exports::words;
use crate::two::folder;
use std::fs;
use std::path::{Path, PathBuf};

fn onnx(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/data/faults/onnx")
        .join(name)
}

#[test]
fn an_onnx_file_whose_shapes_lie_is_refused_before_a_runtime_sees_it() {
    let folder = folder();
    for (file, problem) in [
        // A shape whose product of sides wraps around to the number that is there.
        (
            "transpose-write.onnx",
            "has more than 288230376151711744 numbers",
        ),
        (
            "gatherelements-read.onnx",
            "has more than 288230376151711744 numbers",
        ),
        (
            "constantofshape-add.onnx",
            "ConstantOfShape makes a tensor \"W\"",
        ),
        ("pad-panic.onnx", "Pad makes a tensor \"w\""),
        ("huge.onnx", "ConstantOfShape makes a tensor \"big\""),
        // Weights in another file, stated in three ways.
        ("plain_up.onnx", "found \"W\" in another one"),
        ("trick_up.onnx", "found \"W\" in another one"),
        ("sparse_in.onnx", "found \"W\" in another one"),
    ] {
        let path = onnx(file);
        let path = path.to_str().expect("UTF-8");
        for command in ["check", "score"] {
            refused(folder.path(), &[command, path], 1, &[file, problem]);
        }
    }
}

/// Shapes that are known only when the model runs: nothing can be proved beforehand, and the trial
/// in a process of its own ends instead of this one.
#[test]
fn a_model_that_ends_its_process_ends_a_child() {
    let folder = folder();
    let at = folder.path();
    // Two sides of 2^20 plus the brightest pixel.
    fs::copy(onnx("grows.onnx"), at.join("grows.onnx")).expect("a model");
    fs::copy(onnx("grows.onnx"), at.join("again.onnx")).expect("a model");
    for command in [
        "check grows.onnx",
        "score grows.onnx",
        "parity grows.onnx again.onnx",
        "bench grows.onnx --video made",
    ] {
        let output = edgegait(at, &words(command));
        let said = format!("{}{}", text(&output.stdout), text(&output.stderr));
        assert!(matches!(code(&output), 1 | 4), "{command}: {said}");
        assert!(said.contains("grows.onnx"), "{said}");
        assert!(
            said.contains("ends the process that runs this model"),
            "{said}"
        );
    }
}

#[cfg(unix)]
#[test]
fn links_and_strangers_in_unfinished_work_are_refused() {
    use std::os::unix::fs::symlink;
    let folder = folder();
    let at = folder.path();
    let sweep = "sweep two.egp --views side --raster rows --threads 1 --out out";
    let work = at.join("out.unfinished");
    for name in ["lock", "journal.next", "made", "made/geis.npy", "mine.txt"] {
        fs::create_dir_all(work.join("made")).expect("a folder");
        fs::write(work.join("journal.json"), "{}").expect("a journal");
        fs::write(at.join("victim"), "precious").expect("a file");
        match name {
            "mine.txt" => fs::write(work.join(name), "mine").expect("a file"),
            "made" => {
                fs::remove_dir(work.join("made")).expect("a folder");
                symlink(at, work.join(name)).expect("a link");
            }
            _ => symlink(at.join("victim"), work.join(name)).expect("a link"),
        }
        for flags in ["", " --resume"] {
            let output = edgegait(at, &words(&format!("{sweep}{flags}")));
            let error = text(&output.stderr);
            assert_ne!(code(&output), 0, "{name}{flags}");
            assert!(error.contains("out.unfinished"), "{name}: {error}");
            let is_link = error.contains("to be a link");
            assert_eq!(is_link, name != "mine.txt", "{name}: {error}");
        }
        assert_eq!(fs::read(at.join("victim")).expect("a file"), b"precious");
        assert!(work.join(name).exists(), "{name}");
        fs::remove_dir_all(&work).expect("removed");
    }
    symlink("nowhere", at.join("out")).expect("a link");
    refused(at, &words(sweep), 2, &["out: ", "a link to nothing"]);
}

#[test]
fn what_a_killed_run_left_is_removed_by_the_next_one() {
    let folder = folder();
    let at = folder.path();
    let sweep = "sweep two.egp --views side --raster rows --threads 1 --out out";
    done(at, &words(sweep));
    let work = at.join("out.unfinished");
    // Killed while the finished run removed its folder, and before its first entry of the journal.
    for left in ["former", "made"] {
        fs::create_dir_all(work.join(left)).expect("a folder");
        fs::write(work.join("lock"), "").expect("a lock");
        done(at, &words(&format!("{sweep} --resume")));
        assert!(!work.exists(), "{left}");
        fs::create_dir_all(work.join(left)).expect("a folder");
        done(at, &words(&format!("{sweep} --seed 2")));
        done(at, &words(&format!("{sweep} --overwrite")));
        assert!(!work.exists(), "{left}");
    }
    // Killed between two renames: the former dataset is given back.
    let whole = fs::read(at.join("out/manifest.json")).expect("a manifest");
    fs::create_dir(&work).expect("a folder");
    fs::rename(at.join("out"), work.join("former")).expect("moved");
    done(at, &words(&format!("{sweep} --resume")));
    assert_eq!(fs::read(at.join("out/manifest.json")).expect("one"), whole);
    // A hidden folder of a single file.
    let left = at.join(".m.json.unfinished-0");
    fs::create_dir(&left).expect("a folder");
    fs::write(left.join("unfinished"), "half").expect("a file");
    done(at, &words("inspect two.egp --json m.json"));
    assert!(at.join("m.json").exists() && !left.exists());
}

#[cfg(target_os = "linux")]
#[test]
fn of_two_runs_on_one_output_none_damages_the_other() {
    let folder = folder();
    let at = folder.path();
    let sweep = "sweep two.egp --views side --raster rows --threads 1 --quiet --out";
    done(at, &words(&format!("{sweep} whole")));
    let whole = crate::exports::files(&at.join("whole"));
    for _ in 0..20 {
        let start = || {
            std::process::Command::new(env!("CARGO_BIN_EXE_edgegait"))
                .args(words(&format!("{sweep} out --overwrite")))
                .current_dir(at)
                .stderr(std::process::Stdio::piped())
                .spawn()
                .expect("the command starts")
        };
        let both = [start(), start()].map(|child| child.wait_with_output().expect("an end"));
        let ended = both.iter().filter(|output| output.status.success()).count();
        assert!(ended >= 1, "{both:?}");
        assert!(crate::exports::files(&at.join("out")) == whole);
        assert!(!at.join("out.unfinished").exists());
    }
}
