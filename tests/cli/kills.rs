//! Runs that are killed at a chosen write or rename: what was there stays, or what is made is
//! there, or the same command finishes it.
#![cfg(target_os = "linux")]

use crate::command::*;
use crate::exports::{DESIGN, files, words};
use crate::two::folder;
use std::collections::BTreeMap;
use std::fs;
use std::os::unix::process::ExitStatusExt as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Duration;

const SWEEP: &str =
    "sweep two.egp --cycles 8 --views side --template gei,silhouettes --raster rows --threads 1";

/// The moment of a kill.
#[derive(Clone, Copy, Debug)]
enum Moment {
    /// The write that makes a file longer than so many blocks of 512 bytes.
    Written(u32),
    /// As soon as there is something at a path.
    There(&'static str),
    /// As soon as nothing is at a path any more.
    Gone(&'static str),
}

use Moment::{Gone, There, Written};

/// Runs a command and kills it at a moment; whether that was before its end.
fn killed(at: &Path, command: &str, moment: Moment) -> bool {
    let program = env!("CARGO_BIN_EXE_edgegait");
    let limit = match moment {
        Written(blocks) => format!("ulimit -c 0; ulimit -f {blocks}; exec {program} {command}"),
        _ => format!("exec {program} {command}"),
    };
    let mut child = Command::new("sh")
        .args(["-c", &limit])
        .env("EDGEGAIT_CACHE", "none")
        .current_dir(at)
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .expect("the shell starts");
    loop {
        let is_now = match moment {
            Written(_) => false,
            There(path) => at.join(path).symlink_metadata().is_ok(),
            Gone(path) => at.join(path).symlink_metadata().is_err(),
        };
        if is_now {
            // It may have ended by itself.
            let _ = child.kill();
        }
        if let Some(ended) = child.try_wait().expect("a status") {
            return ended.signal().is_some();
        }
        std::thread::sleep(Duration::from_micros(50));
    }
}

type Files = BTreeMap<PathBuf, Vec<u8>>;

/// The files of a folder, or the file of this name; none if nothing is there.
fn found(path: &Path) -> Option<Files> {
    match path.symlink_metadata() {
        Err(_) => None,
        Ok(there) if there.is_dir() => Some(files(path)),
        Ok(_) => Some([(PathBuf::new(), fs::read(path).expect("a file"))].into()),
    }
}

fn put(path: &Path, contents: &Files) {
    for (name, bytes) in contents {
        // Joining nothing would add a slash.
        let path = if name.as_os_str().is_empty() {
            path.to_path_buf()
        } else {
            path.join(name)
        };
        fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
        fs::write(path, bytes).expect("a file");
    }
}

fn remove(path: &Path) {
    let _ = fs::remove_file(path);
    let _ = fs::remove_dir_all(path);
}

/// Kills a command that writes `out` at each of these moments, with nothing and with the result of
/// `other` there, and then runs it again with the flags `again`.
fn kill_each(at: &Path, [command, other]: [&str; 2], out: &str, moments: &[Moment], again: &str) {
    let path = at.join(out);
    done(at, &words(other));
    let old = found(&path).expect("the old result");
    done(at, &words(&format!("{command} --overwrite")));
    let new = found(&path).expect("the new result");
    assert!(old != new, "{command}");
    let (mut kills, mut last) = (0, String::new());
    for &moment in moments {
        for is_there in [false, true] {
            for place in [path.clone(), at.join(format!("{out}.unfinished"))] {
                remove(&place);
            }
            let flags = if is_there { "--overwrite" } else { "" };
            if is_there {
                put(&path, &old);
            }
            let was_killed = killed(at, &format!("{command} {flags}"), moment);
            kills += usize::from(was_killed);
            let case = format!("{command} {flags}: {moment:?}");
            let former = found(&at.join(format!("{out}.unfinished/former")));
            match found(&path) {
                Some(left) => assert!(left == new || is_there && left == old, "{case}"),
                None if is_there => assert!(former.as_ref() == Some(&old), "{case}"),
                None => {}
            }
            last = done(at, &words(&format!("{command} --overwrite {again}")));
            assert!(found(&path).as_ref() == Some(&new), "{case}: {last}");
            let left: Vec<String> = names(at)
                .into_iter()
                .filter(|it| it.contains("unfinished"))
                .collect();
            assert!(left.is_empty(), "{case}: {left:?}");
        }
    }
    assert!(kills >= moments.len(), "{command}: {kills} kills ({last})");
}

#[test]
fn a_sweep_that_is_killed_at_a_write_or_a_rename_is_resumed() {
    let folder = folder();
    let at = folder.path();
    let moments = [
        Written(0),
        Written(1),
        Written(8),
        Written(100),
        There("out.unfinished"),
        There("out.unfinished/lock"),
        There("out.unfinished/journal.json"),
        There("out.unfinished/made/geis.npy"),
        There("out.unfinished/made/manifest.json"),
        Gone("out.unfinished/made"),
    ];
    let [sweep, other] = ["", " --seed 2"].map(|seed| format!("{SWEEP}{seed} --out out"));
    kill_each(at, [&sweep, &other], "out", &moments, "--resume");
    let moments = [
        Written(0),
        Written(40),
        There("o.npz.unfinished/made/manifest.json"),
    ];
    let [npz, other] =
        ["", " --seed 2"].map(|seed| format!("{SWEEP}{seed} --format npz --out o.npz"));
    kill_each(at, [&npz, &other], "o.npz", &moments, "--resume");
}

#[test]
fn a_tree_and_a_merged_dataset_that_are_killed_are_resumed() {
    let folder = folder();
    let at = folder.path();
    let (design, _) = DESIGN.split_once("[splits]").expect("splits");
    let design = design.replace("[0, 22.5, 90]", "[90]");
    let design = format!("{design}[population]\npeople = \"0..2\"\n");
    fs::write(at.join("d.toml"), &design).expect("a design");
    let moments = [
        Written(0),
        Written(4),
        There("tree.unfinished/journal.json"),
        There("tree.unfinished/made/manifest.json"),
    ];
    let tree = "generate d.toml --format casia-b --threads 1 --out tree";
    fs::write(at.join("e.toml"), design.replace("seed = 1", "seed = 2")).expect("a design");
    let other = tree.replace("d.toml", "e.toml");
    kill_each(at, [tree, &other], "tree", &moments, "--resume");
    for (part, seed) in [("a1", 1), ("b1", 1), ("a2", 2), ("b2", 2)] {
        let shard = if part.starts_with('a') { "1/2" } else { "2/2" };
        done(
            at,
            &words(&format!(
                "{SWEEP} --seed {seed} --shard {shard} --out {part}"
            )),
        );
    }
    let moments = [
        Written(0),
        Written(100),
        There("out.unfinished/made/manifest.json"),
        Gone("out.unfinished/made"),
    ];
    let merge = [
        "merge a1 b1 --threads 1 --out out",
        "merge a2 b2 --threads 1 --out out",
    ];
    kill_each(at, merge, "out", &moments, "--resume");
}

#[test]
fn a_model_that_is_killed_while_it_is_trained_leaves_the_former_one() {
    let folder = folder();
    let at = folder.path();
    let train = "train two.egp --views side --threads 1 --out m.onnx";
    let other = format!("{train} --seed 2");
    kill_each(
        at,
        [train, &other],
        "m.onnx",
        &[Written(0), Written(1), Written(20)],
        "",
    );
}
