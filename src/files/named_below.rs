//! Files that another file names, which may come from a stranger: they have to be in a folder.

use std::path::{Component, Path};

/// Returns whether a name, already decoded, is a relative path that stays in its folder on every
/// system: without `..`, backslashes, drives or schemes.
pub(crate) fn is_below(name: &str) -> bool {
    let mut parts = Path::new(name).components().peekable();
    parts.peek().is_some()
        && parts.all(|part| matches!(part, Component::Normal(_) | Component::CurDir))
        && !name.contains(['\\', ':', '\0'])
}

/// Returns whether a path leads out of a folder through links. A file that is missing does not.
pub(crate) fn leads_out(folder: &Path, path: &Path) -> bool {
    let folder = if folder.as_os_str().is_empty() {
        Path::new(".")
    } else {
        folder
    };
    match (folder.canonicalize(), path.canonicalize()) {
        (Ok(folder), Ok(path)) => !path.starts_with(folder),
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_that_leave_their_folder_are_told_from_those_that_stay() {
        for name in [
            "a.bin",
            "./a.bin",
            "b/a.bin",
            "..a",
            "ä b/c.bin",
            "b/./a.bin",
        ] {
            assert!(is_below(name), "{name}");
        }
        for name in [
            "",
            "/",
            "/etc/passwd",
            "..",
            "../a.bin",
            "b/../../a.bin",
            "b/..",
            "C:\\a.bin",
            "C:a.bin",
            "\\\\host\\a.bin",
            "b\\a.bin",
            "file:a.bin",
            "http://host/a.bin",
            "a\0.bin",
        ] {
            assert!(!is_below(name), "{name:?}");
        }
    }
}
