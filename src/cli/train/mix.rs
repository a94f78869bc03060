//! `--mix`: the training share of each source, by the names of files and folders.

use crate::error::{ChoiceError, Error, Result};
use crate::train::CycleShare;
use std::fmt;
use std::path::{Path, PathBuf};

/// The flag `--mix`.
#[derive(Clone, Debug, Default, clap::Args)]
pub(super) struct MixArgs {
    /// Share of each person's gait cycles to train on, by source: above 0, at most 1, and at least
    /// one cycle, with all its viewpoints; --seed chooses them. Name a source by its folder, or by
    /// its file without the extension; other sources are used whole
    #[arg(long, value_name = "NAME:SHARE[,NAME:SHARE..]", value_delimiter = ',', value_parser = named_share)]
    mix: Vec<NamedShare>,
}

/// A source's name and share in the flag's value.
#[derive(Clone, Debug, PartialEq)]
struct NamedShare {
    name: String,
    share: f64,
}

/// The name of a source, or its path if another has the same name, and its share.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct SharedSource {
    pub name: String,
    pub share: CycleShare,
}

/// Parses the value of `--mix` for one source.
fn named_share(text: &str) -> std::result::Result<NamedShare, String> {
    let parts = text.rsplit_once(':').filter(|(name, _)| !name.is_empty());
    let (name, number) = parts.ok_or("expected NAME:SHARE, as in real:0.7")?;
    let share = number.trim().parse().ok();
    let share = share.filter(|share: &f64| *share > 0.0 && *share <= 1.0);
    Ok(NamedShare {
        name: name.to_owned(),
        share: share.ok_or_else(|| {
            format!("expected a share above 0 and at most 1 of {name}, found {number:?}")
        })?,
    })
}

/// Formats the flag's value.
impl fmt::Display for MixArgs {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let named = |one: &NamedShare| format!("{}:{}", one.name, one.share);
        let named: Vec<String> = self.mix.iter().map(named).collect();
        f.write_str(&named.join(","))
    }
}

impl MixArgs {
    /// Returns whether the flag was given.
    pub(super) const fn is_given(&self) -> bool {
        !self.mix.is_empty()
    }

    /// Returns the names of these sources, and the share of each.
    ///
    /// # Errors
    /// If a name is given twice, or belongs to no source or to several.
    pub(super) fn shared_sources(
        &self,
        sources: &[PathBuf],
        seed: u64,
    ) -> Result<Vec<SharedSource>> {
        let names: Vec<String> = sources.iter().map(|path| name_of(path)).collect();
        if self.is_given() && names.is_empty() {
            return Err(Error::Usage(
                "--mix: expected packs, datasets or trees to name, found none".into(),
            ));
        }
        for (at, NamedShare { name, .. }) in self.mix.iter().enumerate() {
            if self.mix[..at].iter().any(|other| other.name == *name) {
                return Err(Error::Usage(format!("--mix: {name} appears twice")));
            }
            let mut so_called = sources.iter().zip(&names).filter(|(_, one)| *one == name);
            match (so_called.next(), so_called.next()) {
                (Some((one, _)), Some((other, _))) => {
                    return Err(Error::Usage(format!(
                        "--mix: {} and {} are both called {name} (rename one of them, or link to it under another name)",
                        one.display(),
                        other.display()
                    )));
                }
                (Some(_), None) => {}
                _ => {
                    return Err(ChoiceError::Unknown {
                        what: "source",
                        name: name.clone(),
                        known: names,
                    }
                    .into());
                }
            }
        }
        let shared = |(path, name): (&PathBuf, &String)| {
            let stated = self.mix.iter().find(|part| part.name == *name);
            let is_shared = names.iter().filter(|other| *other == name).count() > 1;
            Ok(SharedSource {
                name: if is_shared {
                    path.display().to_string()
                } else {
                    name.clone()
                },
                share: match stated {
                    Some(stated) => CycleShare::new(stated.share, seed)?,
                    None => CycleShare::ALL,
                },
            })
        };
        sources.iter().zip(&names).map(shared).collect()
    }
}

/// Returns the name of a source: a folder's name, or a file's name without the extension.
fn name_of(path: &Path) -> String {
    // A path such as `.` does not end in a name.
    let whole = path.file_name().is_none();
    let path = match std::fs::canonicalize(path) {
        Ok(resolved) if whole => resolved,
        _ => path.to_path_buf(),
    };
    let name = if path.is_dir() {
        path.file_name()
    } else {
        path.file_stem()
    };
    name.unwrap_or(path.as_os_str())
        .to_string_lossy()
        .into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shares_of(
        mix: &[&str],
        sources: &[&str],
    ) -> std::result::Result<Vec<(String, f64)>, String> {
        let parsed: std::result::Result<_, String> =
            mix.iter().map(|text| named_share(text)).collect();
        let sources: Vec<PathBuf> = sources.iter().map(PathBuf::from).collect();
        let shared = MixArgs { mix: parsed? }
            .shared_sources(&sources, 1)
            .map_err(|error| error.to_string())?;
        let plain = |one: SharedSource| (one.name, one.share.part());
        Ok(shared.into_iter().map(plain).collect())
    }

    #[test]
    fn sources_are_called_by_their_files_and_are_used_whole_unless_named() {
        let shares = shares_of(&["real:0.7"], &["sets/real", "made/synthetic.egp"]);
        let expected = [("real".to_owned(), 0.7), ("synthetic".to_owned(), 1.0)];
        assert_eq!(shares.expect("two sources"), expected);
        assert_eq!(shares_of(&[], &[]), Ok(Vec::new()));
        // A folder's name is whole; this one is there.
        let src = concat!(env!("CARGO_MANIFEST_DIR"), "/src/cli/.");
        assert_eq!(shares_of(&[], &[src]), Ok(vec![("cli".to_owned(), 1.0)]));
        let up = concat!(env!("CARGO_MANIFEST_DIR"), "/src/cli/..");
        assert_eq!(shares_of(&[], &[up]), Ok(vec![("src".to_owned(), 1.0)]));
    }

    #[test]
    fn names_that_are_unknown_repeated_or_of_two_sources_are_refused() {
        for (mix, sources, problem) in [
            (
                &["reel:0.5"][..],
                &["a/real", "made.egp"][..],
                "there is no source \"reel\": expected one of real, made",
            ),
            (&["a:0.5", "a:0.6"], &["a"], "a appears twice"),
            (
                &["a:1"],
                &["x/a", "b", "y/a.egp"],
                "x/a and y/a.egp are both called a",
            ),
            (&["a:1"], &[], "expected packs, datasets or trees to name"),
            (&["a:0"], &["a"], "above 0 and at most 1 of a, found \"0\""),
            (&["a:1.5"], &["a"], "found \"1.5\""),
            (&["a:nan"], &["a"], "found \"nan\""),
            (&["a:"], &["a"], "found \"\""),
            (&["a"], &["a"], "expected NAME:SHARE, as in real:0.7"),
            (&[":0.5"], &["a"], "expected NAME:SHARE"),
        ] {
            let error = shares_of(mix, sources).expect_err("refused");
            assert!(error.contains(problem), "{error}");
        }
        // Two of one name are no problem where neither is named.
        let shares = shares_of(&["b:0.5"], &["x/a", "b", "y/a.egp"]).expect("one is named");
        let names: Vec<&str> = shares.iter().map(|(name, _)| name.as_str()).collect();
        assert_eq!(names, ["x/a", "b", "y/a.egp"]);
    }
}
