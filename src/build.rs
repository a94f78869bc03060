//! Sets the version of the command: the package's version and, in a release build from a checkout,
//! the commit, so that results can be traced to it.
//!
//! A debug build omits the commit, so that it is not rebuilt after each commit. A release build for
//! Linux has no symbols.
//!
//! The guide's pages are files that a web view of the repository shows, and modules of the library:
//! their links to each other are turned into links of rustdoc here.

use std::path::{Path, PathBuf};
use std::process::Command;

/// Inputs of a build besides the modules in `src`.
const SOURCES: [&str; 4] = ["no_std_core/src", "models", "Cargo.toml", "Cargo.lock"];

fn main() {
    let sources = sources();
    for path in &sources {
        println!("cargo::rerun-if-changed={path}");
    }
    if let Err(error) = write_guide() {
        println!("cargo::error=src/guide: {error}");
    }
    let is_release = std::env::var("PROFILE").is_ok_and(|profile| profile == "release");
    let is_linux = std::env::var("CARGO_CFG_TARGET_OS").is_ok_and(|os| os == "linux");
    if is_release && is_linux {
        // Not in the profile, where Cargo forgets it for packages with options of their own.
        println!("cargo::rustc-link-arg-bins=-Wl,--strip-all");
    }
    let commit = if is_release { commit(&sources) } else { None };
    if let Some(commit) = commit {
        let version = env!("CARGO_PKG_VERSION");
        println!("cargo::rustc-env=EDGEGAIT_VERSION={version} ({commit})");
    }
}

/// Writes the guide's pages into the build's folder, with links to other pages as rustdoc has them:
/// `[GEI](drawing.md#templates)` becomes `[GEI](crate::guide::drawing#templates)`.
fn write_guide() -> std::io::Result<()> {
    let folder = PathBuf::from(std::env::var_os("OUT_DIR").unwrap_or_default()).join("guide");
    std::fs::create_dir_all(&folder)?;
    for entry in std::fs::read_dir("src/guide")? {
        let path = entry?.path();
        let Some(name) = path.file_name() else {
            continue;
        };
        if path.extension().is_none_or(|extension| extension != "md") {
            continue;
        }
        let text = std::fs::read_to_string(&path)?;
        let mut parts = text.split("](");
        let mut page = parts.next().unwrap_or_default().to_owned();
        for part in parts {
            page += "](";
            let link = part.split(')').next().unwrap_or_default();
            let is_page = !link.contains('/') && !link.contains(':');
            match link.split_once(".md").filter(|_| is_page) {
                Some((name, anchor)) => {
                    page += &format!("crate::guide::{}{anchor}", name.replace('-', "_"));
                    page += &part[link.len()..];
                }
                None => page += part,
            }
        }
        std::fs::write(folder.join(name), page)?;
    }
    Ok(())
}

/// Returns all inputs of a build. The Python package, although in `src`, is not one: it depends on
/// this crate.
fn sources() -> Vec<String> {
    let entries = std::fs::read_dir("src").into_iter().flatten().flatten();
    let names = entries.filter_map(|entry| entry.file_name().into_string().ok());
    let mut sources: Vec<String> = names
        .filter(|name| name != "python")
        .map(|name| format!("src/{name}"))
        .collect();
    sources.sort_unstable();
    sources.extend(SOURCES.map(String::from));
    sources
}

/// Returns the first 12 digits of the checked-out commit, with a note if files differ from it; none
/// outside a checkout of this package.
fn commit(sources: &[String]) -> Option<String> {
    // A checkout of another project around this one does not count.
    git(&["ls-files", "--error-unmatch", "src/build.rs"])?;
    for name in ["HEAD", "logs/HEAD"] {
        let path = git(&["rev-parse", "--git-path", name])?;
        if Path::new(&path).exists() {
            println!("cargo::rerun-if-changed={path}");
        }
    }
    let commit = git(&["rev-parse", "--short=12", "HEAD"])?;
    let sources = sources.iter().map(String::as_str);
    let status: Vec<&str> = ["status", "--porcelain", "--"]
        .into_iter()
        .chain(sources)
        .collect();
    let changes = git(&status)?;
    Some(if changes.is_empty() {
        commit
    } else {
        format!("{commit}, with changes")
    })
}

/// Returns git's output; none if git fails or is missing.
fn git(arguments: &[&str]) -> Option<String> {
    let output = Command::new("git").args(arguments).output().ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    output.status.success().then(|| text.trim().to_owned())
}
