//! OpenGait's partitions of people into training and test sets.
//!
//! A partition is a JSON object with the people of `TRAIN_SET` and of `TEST_SET`. Some also name
//! sequences, `<person>-<take>-<view>`: the probes in `PROBE_SET` (Gait3D), the gallery in
//! `GALLERY_SET` (CCGR-MINI), or both (FreeGait). If one of them is left out, it is all other
//! sequences of the test set (github.com/ShiqiYu/OpenGait, `datasets/`).

use std::collections::HashSet;
use std::path::Path;

use crate::error::{Error, FilePlace, Result};
use serde::{Deserialize, Serialize};

/// A partition of people into a training and a test set.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Partition {
    /// The gallery sequences, if they are named.
    #[serde(
        rename = "GALLERY_SET",
        default,
        skip_serializing_if = "Option::is_none"
    )]
    pub gallery: Option<Vec<String>>,
    /// The probe sequences, if they are named.
    #[serde(rename = "PROBE_SET", default, skip_serializing_if = "Option::is_none")]
    pub probes: Option<Vec<String>>,
    /// The people of the test set.
    #[serde(rename = "TEST_SET")]
    pub test: Vec<String>,
    /// The people of the training set.
    #[serde(rename = "TRAIN_SET")]
    pub train: Vec<String>,
}

impl Partition {
    /// Reads a partition's file.
    ///
    /// # Errors
    /// If it cannot be read, is not a partition, or has a person or a sequence in both sets.
    pub fn read(path: &Path) -> Result<Self> {
        let text = crate::files::read(path)?;
        Self::parse(path, &text)
    }

    /// Parses a partition from JSON; `path` is for messages.
    ///
    /// # Errors
    /// If it is not a partition, or has a person or a sequence in both sets.
    pub(super) fn parse(path: &Path, text: &[u8]) -> Result<Self> {
        let partition: Self = serde_json::from_slice(text).map_err(|error| {
            let problem = format!(
                "expected a partition, {{\"TRAIN_SET\": [..], \"TEST_SET\": [..]}}: {error}"
            );
            Error::at(path, FilePlace::Line(error.line().max(1)), problem)
        })?;
        let trained: HashSet<&String> = partition.train.iter().collect();
        if let Some(both) = partition.test.iter().find(|name| trained.contains(name)) {
            return Err(Error::input(
                path,
                format!("expected no person in TRAIN_SET and TEST_SET, found {both:?} in both"),
            ));
        }
        let known: HashSet<&String> = partition.gallery.iter().flatten().collect();
        let mut probes = partition.probes.iter().flatten();
        if let Some(both) = probes.find(|name| known.contains(name)) {
            return Err(Error::input(
                path,
                format!(
                    "expected no sequence in GALLERY_SET and PROBE_SET, found {both:?} in both"
                ),
            ));
        }
        Ok(partition)
    }

    /// Returns whether the partition names gallery or probe sequences.
    #[must_use]
    pub const fn has_roles(&self) -> bool {
        self.gallery.is_some() || self.probes.is_some()
    }

    /// Returns the text of the partition's file.
    ///
    /// # Errors
    /// None for any partition.
    pub(super) fn to_text(&self) -> Result<String> {
        let mut text = serde_json::to_string_pretty(self)?;
        text.push('\n');
        Ok(text)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_partition_is_read_as_it_is_written() {
        let names = |names: &[&str]| names.iter().map(|&name| name.to_owned()).collect();
        let partition = Partition {
            gallery: None,
            probes: Some(names(&["0002-camid33_videoid2-seq0"])),
            test: names(&["0002", "0007"]),
            train: names(&["0001"]),
        };
        let text = partition.to_text().unwrap();
        assert_eq!(
            text,
            "{\n  \"PROBE_SET\": [\n    \"0002-camid33_videoid2-seq0\"\n  ],\n  \"TEST_SET\": [\n    \"0002\",\n    \"0007\"\n  ],\n  \"TRAIN_SET\": [\n    \"0001\"\n  ]\n}\n"
        );
        let path = Path::new("p.json");
        assert_eq!(Partition::parse(path, text.as_bytes()).unwrap(), partition);
    }

    #[test]
    fn what_is_no_partition_is_refused() {
        for (text, problem) in [
            ("{}", "p.json:1: expected a partition"),
            ("[1]", "p.json:1: expected a partition"),
            (
                "{\"TRAIN_SET\": [],\n\"TEST_SET\": [1]}",
                "p.json:2: expected a partition",
            ),
            (
                "{\"TRAIN_SET\": [\"a\"], \"TEST_SET\": [\"b\", \"a\"]}",
                "found \"a\" in both",
            ),
            (
                "{\"TRAIN_SET\": [], \"TEST_SET\": [\"b\"], \"PROBE_SET\": [\"b-1-0\"], \"GALLERY_SET\": [\"b-1-0\"]}",
                "found \"b-1-0\" in both",
            ),
        ] {
            let error = Partition::parse(Path::new("p.json"), text.as_bytes()).unwrap_err();
            assert!(error.to_string().contains(problem), "{error}");
        }
    }
}
