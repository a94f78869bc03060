//! Checks a command's outputs before any work, by one rule.
//!
//! An input is never overwritten. An earlier result of the same kind is replaced; any other file,
//! only with `--overwrite`. Missing folders are made when the result is written.

use crate::dataset::{DatasetFormat, Existing, check_replaceable};
use crate::error::{Error, Result};
use crate::inference::Contract;
use crate::report::{SVG_START, is_own_gif, is_own_png};
use edgegait_core::format::{MAGIC, RECOGNIZER_MAGIC};
use serde_json::Value;
use std::fs::{self, Metadata};
use std::io::Read as _;
use std::path::{Path, PathBuf};

/// The maximum number of bytes in a file that are read to recognize it.
const MAX_READ: u64 = 1 << 28;

/// The kind of an output, by which an earlier result is recognized.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum OutputKind {
    /// The JSON results of the command of this name.
    Json(&'static str),
    /// A table that begins with this column.
    Csv(&'static str),
    /// A pack.
    Pack,
    /// An ONNX model, with its contract beside it.
    #[cfg_attr(
        not(feature = "train"),
        expect(dead_code, reason = "only `train` writes models")
    )]
    Model,
    /// The contract of a model that was trained here.
    Contract,
    /// A contract for people to edit, so that none is recognized as an earlier result.
    Explained,
    /// A text that begins with these characters.
    Begins(&'static str),
    /// Figures in Bencher's metric format.
    Bencher,
    /// A recognizer in 8-bit weights.
    Recognizer,
    /// A picture.
    Png,
    /// An animation.
    Gif,
    /// A chart.
    Svg,
    /// An array. It does not state its origin, so none is recognized as an earlier result.
    Npy,
    /// A folder with a page.
    Report,
    /// A folder with results as JSON, a table and a chart.
    #[cfg_attr(
        not(feature = "plots"),
        expect(dead_code, reason = "only `frontier` writes one")
    )]
    Frontier,
    /// A folder with a page, results as JSON and figures.
    #[cfg_attr(
        not(all(feature = "import", feature = "train", feature = "plots")),
        expect(dead_code, reason = "only `study` writes one")
    )]
    Study,
    /// A dataset: a folder that holds nothing else, or a file.
    Dataset(DatasetFormat),
    /// A dataset of a run to resume; the run itself checks whether it exists.
    Resumed,
    /// A folder with a sequence of silhouettes; the command itself checks whether it exists.
    Sequence,
}

/// A file or folder that a command will write.
#[derive(Clone, Debug)]
pub(super) struct Output {
    /// The flag that names it.
    pub flag: &'static str,
    /// Its path.
    pub path: PathBuf,
    /// Its kind.
    pub kind: OutputKind,
}

impl Output {
    /// Creates the output that a flag names.
    pub(super) fn new(flag: &'static str, path: &Path, kind: OutputKind) -> Self {
        Self {
            flag,
            path: path.to_path_buf(),
            kind,
        }
    }

    /// Returns the files or folders of this output, each with its kind.
    fn parts(&self) -> Vec<(PathBuf, OutputKind)> {
        let path = &self.path;
        match self.kind {
            OutputKind::Report => vec![(path.join("index.html"), OutputKind::Report)],
            OutputKind::Frontier => [
                ("frontier.json", OutputKind::Json("frontier")),
                ("frontier.csv", OutputKind::Csv("name")),
                ("frontier.svg", OutputKind::Svg),
            ]
            .map(|(name, kind)| (path.join(name), kind))
            .to_vec(),
            OutputKind::Study => vec![
                (path.join("index.html"), OutputKind::Report),
                (path.join("study.json"), OutputKind::Json("study")),
            ],
            OutputKind::Model => vec![
                (path.clone(), OutputKind::Model),
                (Contract::path_beside(path), OutputKind::Contract),
            ],
            kind => vec![(path.clone(), kind)],
        }
    }

    /// Checks that the output may and can be written.
    fn check(&self, inputs: &[PathBuf], overwrite: bool) -> Result<()> {
        let (flag, shown) = (self.flag, self.path.display());
        let refuse = |problem: String| Err(Error::Usage(format!("{flag} {shown}: {problem}")));
        if matches!(
            self.kind,
            OutputKind::Report | OutputKind::Frontier | OutputKind::Study
        ) && self.path.exists()
            && !self.path.is_dir()
        {
            return refuse("expected a folder, found a file".into());
        }
        for (path, kind) in self.parts() {
            let part = path.strip_prefix(&self.path).unwrap_or(&path).display();
            let part = if path == self.path {
                String::new()
            } else {
                format!("{part} ")
            };
            if let Some(input) = is_input(&path, inputs) {
                return refuse(format!(
                    "{part}is the same file as {}, which this command reads (name another)",
                    input.display()
                ));
            }
            let found = fs::metadata(&path).ok();
            if let OutputKind::Dataset(format) = kind {
                check_replaceable(&path, format, Existing::from_overwrite(overwrite))?;
            } else if kind == OutputKind::Resumed {
                continue;
            } else if kind == OutputKind::Sequence {
                // It may exist, but not inside a folder of frames that are read.
                let target = resolved(&path);
                let is_in = |input: &&PathBuf| {
                    fs::canonicalize(input).is_ok_and(|input| target.starts_with(input))
                };
                if let Some(input) = inputs.iter().find(is_in) {
                    return refuse(format!(
                        "{part}would be in {}, which this command reads (name another)",
                        input.display()
                    ));
                }
            } else if found.as_ref().is_some_and(Metadata::is_dir) {
                return refuse(format!("{part}expected a file to write, found a folder"));
            } else if let Some(found) = found.filter(Metadata::is_file)
                && !overwrite
                && !is_own(&path, kind, &found)
            {
                return refuse(format!(
                    "{part}already exists, and is not known to be an earlier result of this command (name another, or use --overwrite)"
                ));
            }
            try_folder_of(&path)?;
        }
        Ok(())
    }
}

/// Checks, before any work is done, that all outputs may and can be written. Changes nothing.
///
/// # Errors
/// For the first output that must not or cannot be written, with advice.
pub(super) fn check(outputs: &[Output], inputs: &[PathBuf], overwrite: bool) -> Result<()> {
    for (at, output) in outputs.iter().enumerate() {
        output.check(inputs, overwrite)?;
        for other in &outputs[..at] {
            let is_same = |path: &PathBuf| {
                let mut others = other.parts().into_iter();
                others.any(|(other, _)| resolved(&other) == resolved(path))
            };
            if output.parts().iter().any(|(path, _)| is_same(path)) {
                return Err(Error::Usage(format!(
                    "{} and {}: both would be {}",
                    other.flag,
                    output.flag,
                    output.path.display()
                )));
            }
        }
    }
    Ok(())
}

/// Returns the input that is this existing path, or the input folder that contains it.
fn is_input<'a>(path: &Path, inputs: &'a [PathBuf]) -> Option<&'a PathBuf> {
    let path = fs::canonicalize(path).ok()?;
    inputs.iter().find(|input| {
        let input = fs::canonicalize(input).ok();
        input.is_some_and(|input| path == input || (input.is_dir() && path.starts_with(&input)))
    })
}

/// Resolves the links of a path, as far as it exists.
fn resolved(path: &Path) -> PathBuf {
    if let Ok(path) = fs::canonicalize(path) {
        return path;
    }
    let absolute = std::path::absolute(path).unwrap_or_else(|_| path.to_path_buf());
    match (absolute.parent(), absolute.file_name()) {
        (Some(folder), Some(name)) => resolved(folder).join(name),
        _ => absolute,
    }
}

/// Returns whether a file is known to be an earlier result of its kind, or is empty.
fn is_own(path: &Path, kind: OutputKind, found: &Metadata) -> bool {
    if found.len() == 0 {
        return true;
    }
    let text = || {
        let readable = found.len() <= MAX_READ;
        readable.then(|| fs::read_to_string(path).ok()).flatten()
    };
    let begins = |with: &[u8]| {
        let mut start = Vec::new();
        let file = fs::File::open(path).map(|file| file.take(with.len() as u64));
        file.and_then(|mut file| file.read_to_end(&mut start))
            .is_ok_and(|_| start == with)
    };
    let start = || {
        let mut start = Vec::new();
        let file = fs::File::open(path).map(|file| file.take(1 << 10));
        // What cannot be read is not known.
        let _ = file.and_then(|mut file| file.read_to_end(&mut start));
        start
    };
    match kind {
        OutputKind::Json(command) => text().is_some_and(|text| {
            let value: Option<Value> = serde_json::from_str(&text).ok();
            value.is_some_and(|value| value["command"] == command && value["schema"].is_u64())
        }),
        OutputKind::Csv(column) => begins(format!("{column},").as_bytes()),
        OutputKind::Pack => begins(&MAGIC),
        OutputKind::Bencher => text().is_some_and(|text| {
            let value: Option<Value> = serde_json::from_str(&text).ok();
            value.is_some_and(|value| is_metrics(&value))
        }),
        OutputKind::Begins(with) => begins(with.as_bytes()),
        OutputKind::Recognizer => begins(&RECOGNIZER_MAGIC),
        OutputKind::Contract => text()
            .and_then(|text| Contract::parse(path, &text).ok())
            .is_some_and(|contract| !contract.training.description.is_empty()),
        // The version of the intermediate representation, and the producer.
        OutputKind::Model => begins(b"\x08\x08\x12\x08edgegait"),
        OutputKind::Png => is_own_png(&start()),
        OutputKind::Gif => is_own_gif(&start()),
        OutputKind::Report => text().is_some_and(|text| text.contains(crate::report::TITLE_END)),
        OutputKind::Svg => begins(SVG_START.as_bytes()),
        OutputKind::Npy
        | OutputKind::Explained
        | OutputKind::Dataset(_)
        | OutputKind::Resumed
        | OutputKind::Sequence
        | OutputKind::Frontier
        | OutputKind::Study => false,
    }
}

/// Returns whether JSON consists only of benchmarks with measures with numbers.
fn is_metrics(value: &Value) -> bool {
    let is_measured = |measures: &Value| {
        let measures = measures.as_object();
        let is_number = |metric: &Value| metric.get("value").is_some_and(Value::is_number);
        measures.is_some_and(|measures| !measures.is_empty() && measures.values().all(is_number))
    };
    let benchmarks = value.as_object();
    benchmarks.is_some_and(|them| !them.is_empty() && them.values().all(is_measured))
}

/// Checks that the folder of a file is writable.
fn try_folder_of(path: &Path) -> Result<()> {
    // Devices and pipes are written into.
    if fs::metadata(path).is_ok_and(|found| !found.is_file() && !found.is_dir()) {
        return Ok(());
    }
    let target = resolved(path);
    let mut folder = target.parent();
    while let Some(missing) = folder.filter(|folder| !folder.exists()) {
        folder = missing.parent();
    }
    let Some(folder) = folder else {
        return Err(Error::Usage(format!(
            "{}: expected a path that ends in a name",
            path.display()
        )));
    };
    if !folder.is_dir() {
        return Err(Error::input(
            path,
            format!("expected {} to be a folder, found a file", folder.display()),
        ));
    }
    crate::files::Staging::beside(&folder.join(target.file_name().unwrap_or_default()))
        .map(drop)
        .map_err(|error| match error {
            Error::Io { source, .. } => Error::io(path, source),
            other => other,
        })
}
