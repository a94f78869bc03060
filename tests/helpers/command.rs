//! Helpers for running the built command.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

/// Returns the command in a folder, without arguments.
pub fn program(folder: &Path) -> Command {
    let mut program = Command::new(env!("CARGO_BIN_EXE_edgegait"));
    program.env("EDGEGAIT_CACHE", "none").current_dir(folder);
    program
}

pub fn edgegait(folder: &Path, arguments: &[&str]) -> Output {
    let output = program(folder).args(arguments).output();
    output.expect("the command starts")
}

pub fn code(output: &Output) -> i32 {
    output.status.code().expect("an exit code")
}

pub fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).expect("UTF-8")
}

/// Runs a command that must succeed, and returns its standard output.
pub fn done(folder: &Path, arguments: &[&str]) -> String {
    let output = edgegait(folder, arguments);
    assert_eq!(code(&output), 0, "{arguments:?}: {}", text(&output.stderr));
    text(&output.stdout)
}

/// Runs a command that must fail with exit code `expected` and print only an error that contains
/// all of `words`.
pub fn refused(folder: &Path, arguments: &[&str], expected: i32, words: &[&str]) {
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

pub fn names(folder: &Path) -> Vec<String> {
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
