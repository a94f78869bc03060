//! Reading the system files that describe the machine.

use std::fs;
use std::path::{Path, PathBuf};

/// The system files below a root folder.
#[derive(Clone, Debug)]
pub(in crate::bench) struct SystemFiles {
    root: PathBuf,
}

impl SystemFiles {
    pub(crate) fn new(root: &Path) -> Self {
        Self { root: root.into() }
    }

    /// Returns a file's text, unchanged; none if it cannot be read.
    pub(crate) fn raw_text(&self, path: impl AsRef<Path>) -> Option<String> {
        let bytes = fs::read(self.root.join(path)).ok()?;
        Some(String::from_utf8_lossy(&bytes).into_owned())
    }

    /// Returns a file's text without surrounding white space and NUL; none if nothing is left.
    pub(crate) fn text(&self, path: impl AsRef<Path>) -> Option<String> {
        let text = self.raw_text(path)?;
        let text = text.trim_matches(|c: char| c.is_whitespace() || c == '\0');
        (!text.is_empty()).then(|| text.to_owned())
    }

    /// Returns the number that a file contains.
    pub(crate) fn number<T: std::str::FromStr>(&self, path: impl AsRef<Path>) -> Option<T> {
        self.text(path)?.parse().ok()
    }

    /// Returns the text after `name` on its line of a file.
    pub(crate) fn field(&self, path: impl AsRef<Path>, name: &str) -> Option<String> {
        let text = self.raw_text(path)?;
        let value = text.lines().find_map(|line| line.strip_prefix(name))?;
        Some(value.trim().to_owned())
    }

    /// Returns the entries of a folder whose names begin with `prefix`, as paths below the root, in
    /// the order of the numbers in their names.
    pub(crate) fn entries(&self, folder: impl AsRef<Path>, prefix: &str) -> Vec<PathBuf> {
        let Ok(found) = fs::read_dir(self.root.join(&folder)) else {
            return Vec::new();
        };
        let mut names: Vec<String> = found
            .flatten()
            .map(|entry| entry.file_name().to_string_lossy().into_owned())
            .filter(|name| name.starts_with(prefix))
            .collect();
        names.sort_by_cached_key(|name| {
            let digits = name.trim_start_matches(|c: char| !c.is_ascii_digit());
            let end = digits
                .find(|c: char| !c.is_ascii_digit())
                .unwrap_or(digits.len());
            (
                digits[..end].parse::<u64>().unwrap_or(u64::MAX),
                name.clone(),
            )
        });
        names
            .iter()
            .map(|name| folder.as_ref().join(name))
            .collect()
    }
}
