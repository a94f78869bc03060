//! Warnings about files, where a warning that several files share is printed once.

use std::fmt;

/// The maximum number of files that are named for a shared warning.
const NAMED: usize = 3;

/// A warning, and the names of the files that it is about.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct SharedWarning<'a> {
    /// The text of the warning.
    pub warning: &'a str,
    /// The names of the files, at least one.
    pub files: Vec<&'a str>,
}

impl<'a> SharedWarning<'a> {
    /// Collects the warnings of these files, in order of their first appearance.
    pub(super) fn collect(files: impl Iterator<Item = (&'a str, &'a [String])>) -> Vec<Self> {
        let mut found: Vec<Self> = Vec::new();
        for (file, warnings) in files {
            for warning in warnings {
                let known = found.iter_mut().find(|shared| shared.warning == warning);
                match known {
                    Some(known) if known.files.last() == Some(&file) => {}
                    Some(known) => known.files.push(file),
                    None => found.push(Self {
                        warning,
                        files: vec![file],
                    }),
                }
            }
        }
        found
    }

    /// Returns whether the warning is about several files.
    #[must_use]
    pub(super) const fn is_shared(&self) -> bool {
        self.files.len() > 1
    }
}

impl fmt::Display for SharedWarning<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { warning, files } = self;
        if !self.is_shared() {
            return write!(f, "{}: {warning}", files.join(""));
        }
        let named = files[..files.len().min(NAMED)].join(", ");
        write!(f, "{warning} ({} files: {named}", files.len())?;
        match files.len().saturating_sub(NAMED) {
            0 => f.write_str(")"),
            more => write!(f, " and {more} more)"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_several_files_share_is_said_once_with_the_first_of_them() {
        let lists = [
            ("a", vec!["cut".to_owned(), "no rate".to_owned()]),
            ("b", vec!["no rate".to_owned(), "no rate".to_owned()]),
            ("c", vec!["turns".to_owned()]),
            ("d", vec!["no rate".to_owned(), "cut".to_owned()]),
            ("e", vec!["no rate".to_owned()]),
        ];
        let files = lists.iter().map(|(file, list)| (*file, list.as_slice()));
        let said: Vec<String> = SharedWarning::collect(files)
            .iter()
            .map(ToString::to_string)
            .collect();
        assert_eq!(
            said,
            [
                "cut (2 files: a, d)",
                "no rate (4 files: a, b, d and 1 more)",
                "c: turns"
            ]
        );
    }
}
