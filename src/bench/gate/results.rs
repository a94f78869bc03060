//! Files of results, and whether they can be compared.

use super::criterion;
use crate::error::{Error, Result};
use crate::files::{InputFile, ResultHeader, SCHEMA, sha256_of_bytes};
use serde::Deserialize as _;
use serde_json::Value;
use std::path::{Path, PathBuf};

/// The maximum size of a file of results in bytes.
const MAX_BYTES: u64 = 1 << 28;
/// Settings that are not compared: paths or descriptions of files that `inputs` compares by
/// content, and settings for the duration or detail of measurements.
const NOT_COMPARED: [&str; 11] = [
    "pack",
    "dataset",
    "protocol_description",
    "max_seconds",
    "windows",
    "window_s",
    "warm_up",
    "mlperf",
    "bare",
    "profile",
    "no_accuracy",
];

/// A file of results, or a folder of criterion's.
#[derive(Clone, Debug)]
pub(crate) struct ResultFile {
    pub path: PathBuf,
    pub value: Value,
    pub header: ResultHeader,
}

impl ResultFile {
    /// Reads the JSON results of any command, or a folder of criterion's results.
    ///
    /// # Errors
    /// If the results cannot be read, is not such JSON, or has another version of the format.
    pub(crate) fn read(path: &Path) -> Result<Self> {
        if path.is_dir() {
            return Ok(Self {
                path: path.to_path_buf(),
                value: criterion::benchmarks(path)?,
                header: ResultHeader::new("criterion", 1),
            });
        }
        let io = |error| Error::io(path, error);
        let length = std::fs::metadata(path).map_err(io)?.len();
        if length > MAX_BYTES {
            let problem = format!("expected results of at most {MAX_BYTES} bytes, found {length}");
            return Err(Error::input(path, problem));
        }
        let text = crate::files::read_to_string(path)?;
        Self::parse(path, &text)
    }

    /// Parses the JSON results of any command; `path` is for messages.
    ///
    /// # Errors
    /// If the text is not such JSON, or has another version of the format.
    pub(crate) fn parse(path: &Path, text: &str) -> Result<Self> {
        let refuse = |found: &dyn std::fmt::Display| {
            let expected = "expected the JSON results of a command";
            Error::input(path, format!("{expected}: {found}"))
        };
        let value: Value = serde_json::from_str(text).map_err(|error| refuse(&error))?;
        let header = ResultHeader::deserialize(&value).map_err(|error| refuse(&error))?;
        if header.schema != SCHEMA {
            return Err(Error::input(
                path,
                format!(
                    "expected results of schema {SCHEMA}, found schema {} (of EdgeGait {}; create them again)",
                    header.schema, header.version
                ),
            ));
        }
        Ok(Self {
            path: path.to_path_buf(),
            value,
            header,
        })
    }

    /// Returns the path and the hash of the file, or of what was read in the folder.
    ///
    /// # Errors
    /// If the file cannot be read.
    pub(crate) fn input(&self) -> Result<InputFile> {
        if !self.path.is_dir() {
            return InputFile::read(&self.path);
        }
        Ok(InputFile {
            path: self.path.display().to_string(),
            sha256: sha256_of_bytes(self.value.to_string().as_bytes()),
        })
    }

    /// Checks that other results are comparable: of the same command, seed, settings and data.
    ///
    /// # Errors
    /// If they are not, naming the first difference.
    pub(crate) fn require_like(&self, other: &Self) -> Result<()> {
        let refuse = |what: &str, [checked, baseline]: [String; 2]| {
            let [mine_at, its_at] =
                [&self.path, &other.path].map(|path| path.display().to_string());
            Err(Error::input(
                &other.path,
                format!(
                    "cannot be compared: {what} is {baseline}, and {checked} in {mine_at} (create {its_at} and \
                     {mine_at} with the same command on the same data)"
                ),
            ))
        };
        let [checked, baseline] = [&self.header, &other.header];
        if checked.command != baseline.command {
            return refuse(
                "the command",
                [checked.command.clone(), baseline.command.clone()],
            );
        }
        if checked.seed != baseline.seed {
            return refuse(
                "the seed",
                [checked.seed.to_string(), baseline.seed.to_string()],
            );
        }
        let keys = checked.settings.keys().chain(baseline.settings.keys());
        for key in keys.filter(|key| !NOT_COMPARED.contains(&key.as_str())) {
            let of = |header: &ResultHeader| match header.settings.get(key) {
                Some(value) => value.to_string(),
                None => "not stated".into(),
            };
            if checked.settings.get(key) != baseline.settings.get(key) {
                return refuse(&format!("the setting {key:?}"), [of(checked), of(baseline)]);
            }
        }
        let (checked, baseline) = (checked.data(), baseline.data());
        if checked
            .iter()
            .map(|file| &file.sha256)
            .ne(baseline.iter().map(|file| &file.sha256))
        {
            let of = |files: &[&InputFile]| match files {
                [] => "built-in data only".to_owned(),
                files => {
                    let each = files.iter();
                    let each = each.map(|file| format!("{} ({:.8})", file.path, file.sha256));
                    each.collect::<Vec<_>>().join(", ")
                }
            };
            return refuse(
                "the data (with the start of its SHA-256)",
                [of(&checked), of(&baseline)],
            );
        }
        Ok(())
    }

    /// Checks that other results are another run of the same: comparable as in
    /// [`Self::require_like`], and with the same models.
    ///
    /// # Errors
    /// If they are not, naming the first difference.
    pub(crate) fn require_run_of(&self, other: &Self) -> Result<()> {
        self.require_like(other)?;
        let sums = |header: &ResultHeader| {
            let mut sums: Vec<String> = header
                .inputs
                .iter()
                .map(|input| input.sha256.clone())
                .collect();
            sums.sort_unstable();
            sums
        };
        if sums(&self.header) == sums(&other.header) {
            return Ok(());
        }
        Err(Error::input(
            &other.path,
            format!(
                "expected another run with the models of {}, found other models",
                self.path.display()
            ),
        ))
    }

    /// Returns whether both were measured on the same kind of machine with the same number of
    /// threads, as far as both state these.
    pub(crate) fn is_same_board(&self, other: &Self) -> bool {
        let of_board = |results: &Self, key: &str| {
            let board = results.value.get("board");
            board.and_then(|board| board.get(key)).cloned()
        };
        let keys = ["model", "soc", "cpus", "architecture", "affinity"];
        let both = keys.map(|key| (of_board(self, key), of_board(other, key)));
        let threads = [self, other].map(|file| file.value.get("threads").cloned());
        let [checked, baseline] = threads;
        both.into_iter()
            .chain([(checked, baseline)])
            .all(|both| match both {
                (Some(checked), Some(baseline)) => checked == baseline,
                _ => true,
            })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn results(path: &str, change: impl FnOnce(&mut Value)) -> ResultFile {
        let mut value = json!({
            "schema": 1, "command": "score", "version": "0.1.0", "seed": 1,
            "inputs": [
                { "path": "a/m.onnx", "sha256": "00" }, { "path": "a/m.toml", "sha256": "01" },
                { "path": "a/p.egp", "sha256": "02" }, { "path": "a/protocol.toml", "sha256": "03" },
            ],
            "settings": { "views": "paper", "pack": "a/p.egp" }, "warnings": [],
        });
        change(&mut value);
        ResultFile::parse(Path::new(path), &value.to_string()).expect("results")
    }

    #[test]
    fn other_models_and_other_places_can_be_compared() {
        let checked = results("a.json", |_| {});
        let baseline = results("b.json", |value| {
            value["inputs"] = json!([
                { "path": "b/p.egp", "sha256": "02" }, { "path": "b/protocol.toml", "sha256": "03" },
                { "path": "b/n.onnx", "sha256": "10" }, { "path": "b/n.toml", "sha256": "11" },
            ]);
            value["settings"]["pack"] = json!("b/p.egp");
        });
        checked.require_like(&baseline).expect("they are alike");
        let said = checked
            .require_run_of(&baseline)
            .expect_err("other models")
            .to_string();
        assert!(
            said.starts_with("b.json: expected another run with the models of a.json"),
            "{said}"
        );
        checked
            .require_run_of(&results("c.json", |_| {}))
            .expect("another run");
    }

    #[test]
    fn what_differs_is_named() {
        let checked = results("a.json", |_| {});
        type Change = fn(&mut Value);
        let cases: [(Change, &str); 5] = [
            (
                |value| value["command"] = json!("bench"),
                "the command is bench, and score in a.json",
            ),
            (
                |value| value["seed"] = json!(2),
                "the seed is 2, and 1 in a.json",
            ),
            (
                |value| value["settings"]["views"] = json!("side"),
                "the setting \"views\" is \"side\", and \"paper\"",
            ),
            (
                |value| value["settings"]["lens"] = json!("ortho"),
                "the setting \"lens\" is \"ortho\", and not stated",
            ),
            (
                |value| value["inputs"][2]["sha256"] = json!("f00"),
                "a/p.egp (f00), and a/p.egp (02), a/protocol.toml (03)",
            ),
        ];
        for (change, words) in cases {
            let said = checked
                .require_like(&results("b.json", change))
                .expect_err(words)
                .to_string();
            assert!(
                said.starts_with("b.json: cannot be compared: ") && said.contains(words),
                "{said}"
            );
        }
    }

    #[test]
    fn what_is_no_result_is_refused() {
        for (text, words) in [
            ("", "r.json: expected the JSON results of a command: EOF"),
            ("[1]", "r.json: expected the JSON results"),
            ("{\"schema\": 1}", "missing field"),
            (
                r#"{"schema": 2, "command": "x", "version": "0.2.0", "seed": 1}"#,
                "expected results of schema 1, found schema 2 (of EdgeGait 0.2.0; create them again)",
            ),
        ] {
            let said = ResultFile::parse(Path::new("r.json"), text)
                .expect_err(text)
                .to_string();
            assert!(said.contains(words), "{said}");
        }
    }

    #[test]
    fn boards_are_told_apart_by_what_both_say() {
        let on = |board: Value| results("a.json", |value| value["board"] = board);
        let pi = on(json!({ "model": "Pi 4", "cpus": [1], "kernel": "6" }));
        assert!(pi.is_same_board(&on(json!({ "model": "Pi 4", "cpus": [1], "kernel": "7" }))));
        assert!(pi.is_same_board(&results("b.json", |_| {})));
        assert!(!pi.is_same_board(&on(json!({ "model": "Pi 5", "cpus": [1] }))));
    }
}
