//! Runs that were ended early and resumed.
#![cfg(target_os = "linux")]

use crate::command::*;
use crate::exports::{DESIGN, files, words};
use crate::two::folder;
use std::fs;

/// A sweep that takes long enough to be killed.
const LONG: &str =
    "sweep two.egp --cycles 120 --views side --template gei,silhouettes --joints --threads 1";

#[test]
fn a_run_that_was_killed_at_any_moment_ends_with_the_bytes_of_an_undisturbed_one() {
    let folder = folder();
    let at = folder.path();
    fs::write(at.join("d.toml"), DESIGN).expect("a design");
    let tree = "generate d.toml --format casia-b --threads 1";
    for (command, kills) in [(LONG, 12), (tree, 6)] {
        let _ = fs::remove_dir_all(at.join("whole"));
        let _ = fs::remove_dir_all(at.join("killed"));
        done(at, &words(&format!("{command} --out whole")));
        let command = format!("{command} --out killed --resume");
        let mut moment = 1_u64;
        for _ in 0..kills {
            // Moments of up to a third of a second (Knuth's multiplier).
            moment = moment
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            let mut child = std::process::Command::new(env!("CARGO_BIN_EXE_edgegait"))
                .args(words(&command))
                .current_dir(at)
                .stdout(std::process::Stdio::null())
                .stderr(std::process::Stdio::null())
                .spawn()
                .expect("the command starts");
            std::thread::sleep(std::time::Duration::from_millis((moment >> 32) % 330));
            child.kill().expect("it dies");
            child.wait().expect("it is dead");
            // No incomplete output has the final name.
            assert!(!at.join("killed").exists() || at.join("killed/manifest.json").exists());
        }
        done(at, &words(&command));
        assert!(
            files(&at.join("killed")) == files(&at.join("whole")),
            "{command}"
        );
        // The output is already complete; the output of another run is kept.
        let said = done(at, &words(&command));
        assert!(said.contains("is already complete"), "{said}");
        assert!(!said.contains("wrote"), "{said}");
        let other = command.replace("--cycles 120", "--cycles 3");
        let other = other.replace("d.toml", "d.toml --people 1");
        let problem = "is already complete, from another run: settings.";
        refused(at, &words(&other), 2, &[problem]);
        assert!(
            files(&at.join("killed")) == files(&at.join("whole")),
            "{command}"
        );
        assert!(!at.join("killed.unfinished").exists());
    }
}

#[test]
fn a_full_disk_loses_nothing_that_was_done() {
    let folder = folder();
    let at = folder.path();
    done(at, &words(&format!("{LONG} --out whole")));
    // Files have at most 40,000 blocks of 512 bytes; the largest would be 23 MB, and takes a while.
    let program = env!("CARGO_BIN_EXE_edgegait");
    let limited = format!("trap '' XFSZ; ulimit -f 40000; exec {program} {LONG} --out full");
    let output = std::process::Command::new("sh")
        .args(["-c", &limited])
        .current_dir(at)
        .output()
        .expect("the shell starts");
    let error = text(&output.stderr);
    assert_eq!(code(&output), 1, "{error}");
    let told = "full.unfinished keeps the finished part: continue with --resume";
    assert!(
        error.contains("File too large") && error.contains(told),
        "{error}"
    );
    assert_eq!(names(at), ["full.unfinished", "two.egp", "whole"]);
    refused(
        at,
        &words(&format!("{LONG} --out full")),
        2,
        &["continue with --resume"],
    );
    let other = LONG.replace("--cycles 120", "--cycles 121");
    let other = format!("{other} --out full --resume");
    refused(
        at,
        &words(&other),
        2,
        &["settings.cycles is 120 there, 121 here"],
    );
    // A run reports another one that holds the lock.
    let lock = fs::File::open(at.join("full.unfinished/lock")).expect("a lock");
    lock.lock().expect("locked");
    for flags in ["", "--resume"] {
        let again = format!("{LONG} --out full {flags}");
        refused(at, &words(&again), 2, &["another process is using it"]);
    }
    drop(lock);
    done(at, &words(&format!("{LONG} --out full --resume")));
    assert!(files(&at.join("full")) == files(&at.join("whole")));
}
