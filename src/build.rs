//! Tells the command its version: that of the package and, in a release build from a checkout, the
//! commit, so that results can be traced to it.
//!
//! A debug build leaves the commit out, and so need not be built anew after each.

use std::path::Path;
use std::process::Command;

/// What a build is made of.
const SOURCES: [&str; 5] = [
    "src",
    "no_std_core/src",
    "models",
    "Cargo.toml",
    "Cargo.lock",
];

fn main() {
    for path in SOURCES {
        println!("cargo::rerun-if-changed={path}");
    }
    let is_release = std::env::var("PROFILE").is_ok_and(|profile| profile == "release");
    let commit = if is_release { commit() } else { None };
    if let Some(commit) = commit {
        let version = env!("CARGO_PKG_VERSION");
        println!("cargo::rustc-env=EDGEGAIT_VERSION={version} ({commit})");
    }
}

/// The first 12 digits of the commit that is checked out, and a word if files differ from it; none
/// outside of a checkout of this package.
fn commit() -> Option<String> {
    // That of another project around this one is not ours.
    git(&["ls-files", "--error-unmatch", "src/build.rs"])?;
    for name in ["HEAD", "logs/HEAD"] {
        let path = git(&["rev-parse", "--git-path", name])?;
        if Path::new(&path).exists() {
            println!("cargo::rerun-if-changed={path}");
        }
    }
    let commit = git(&["rev-parse", "--short=12", "HEAD"])?;
    let changes = git(&[&["status", "--porcelain", "--"], &SOURCES[..]].concat())?;
    Some(if changes.is_empty() {
        commit
    } else {
        format!("{commit}, with changes")
    })
}

/// What git prints; none if it fails or is not there.
fn git(arguments: &[&str]) -> Option<String> {
    let output = Command::new("git").args(arguments).output().ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    output.status.success().then(|| text.trim().to_owned())
}
