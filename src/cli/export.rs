//! Flags that choose how datasets are written.

use super::outputs::{Output, OutputKind};
use crate::dataset::{
    DatasetFormat, DatasetRun, DatasetWriter, Existing, Shard, UnfinishedRun, check_unfinished,
    standing,
};
use crate::draw::sweep::Settings;
use crate::draw::template::Template;
use crate::error::{ChoiceError, Error, Result};
use edgegait_core::silhouette::Size;
use std::ops::Range;
use std::path::Path;

/// The flags that choose how datasets are written.
#[derive(Clone, Debug, clap::Args)]
pub(super) struct ExportArgs {
    /// Format: a folder of arrays (.npy) and tables (.csv), the same in one .npz file, or a tree of
    /// silhouettes (<person>/<take>/<view>/): pickles for OpenGait, or PNG frames like CASIA-B
    #[arg(long, value_name = "FORMAT", default_value = "folder")]
    pub format: DatasetFormat,
    /// Make part I of N; `merge` joins the parts into the same bytes as one run
    #[arg(long, value_name = "I/N", value_parser = shard)]
    pub shard: Option<Shard>,
    /// Resume a run that was interrupted
    #[arg(long)]
    pub resume: bool,
}

/// Parses a part `I/N`.
fn shard(text: &str) -> std::result::Result<Shard, String> {
    let numbers = text.split_once('/');
    let numbers = numbers.and_then(|(i, n)| Some((i.parse().ok()?, n.parse().ok()?)));
    match numbers {
        Some((number, of)) if (1..=of).contains(&number) && of <= 65_535 => {
            Ok(Shard { number, of })
        }
        _ => Err("expected a part from 1/N to N/N, as in 1/3".to_owned()),
    }
}

impl ExportArgs {
    /// Returns the output.
    pub(super) fn output(&self, path: &Path) -> Output {
        let kind = if self.resume {
            OutputKind::Resumed
        } else {
            OutputKind::Dataset(self.format)
        };
        Output::new("--out", path, kind)
    }

    /// Checks, before any work, that the format can hold these contents.
    pub(super) fn check(&self, templates: &[Template], size: Size, joints: bool) -> Result<()> {
        let format = self.format;
        let refuse = |problem: String| {
            Err(Error::Usage(format!(
                "--format {}: {problem}",
                format.name()
            )))
        };
        if format == DatasetFormat::Npz && self.shard.is_some() {
            return refuse(
                "a shard is a folder (`merge --format npz` joins folders into one file)".into(),
            );
        }
        if !format.is_tree() {
            return Ok(());
        }
        if templates != [Template::Silhouettes] {
            return refuse("it holds silhouettes only, no other template".into());
        }
        if joints {
            return refuse("it does not store joints (use folder or npz)".into());
        }
        if format == DatasetFormat::Opengait && size != Size::S64x64 {
            return refuse(format!(
                "OpenGait reads 64x64 and crops it, found --size {size}"
            ));
        }
        Ok(())
    }

    /// Begins or resumes a run; returns none if the run to resume is already complete.
    pub(super) fn begin(
        &self,
        out: &Path,
        run: DatasetRun,
        overwrite: bool,
    ) -> Result<Option<DatasetWriter>> {
        if self.resume {
            match standing(out, &run)? {
                UnfinishedRun::Whole => return Ok(None),
                UnfinishedRun::Other(differs) if !overwrite => {
                    return Err(ChoiceError::OtherRun {
                        target: out.to_path_buf(),
                        differs,
                    }
                    .into());
                }
                UnfinishedRun::Other(_) | UnfinishedRun::Absent => {}
            }
        }
        let existing = Existing::from_overwrite(overwrite);
        DatasetWriter::begin(out, run, existing, self.resume).map(Some)
    }

    /// Returns the units of work of this shard.
    pub(super) fn units(&self, all: usize) -> Result<Range<usize>> {
        let Some(shard) = self.shard else {
            return Ok(0..all);
        };
        if shard.of > all {
            return Err(Error::Usage(format!(
                "--shard {}/{}: there are only {all} pieces of work to divide",
                shard.number, shard.of
            )));
        }
        Ok(shard.of_units(all))
    }

    /// Checks that there is no unfinished work beside `out`, unless it is to be resumed.
    pub(super) fn check_unfinished(&self, out: &Path) -> Result<()> {
        check_unfinished(out, self.resume)
    }
}

/// Returns the name of a take in a tree, from a walk, its condition, if any, and a number.
pub(super) fn take_name(walk: &str, condition: &str, number: Option<u32>) -> String {
    let mut name = walk.to_owned();
    if condition != crate::draw::confounders::NORMAL {
        name = format!("{name}-{condition}");
    }
    match number {
        Some(number) => format!("{name}-{:02}", number + 1),
        None => name,
    }
}

/// Returns the requested templates, without duplicates; by default GEIs, or silhouettes in a tree.
pub(super) fn templates_of(asked: &[Template], format: DatasetFormat) -> Vec<Template> {
    let mut templates: Vec<Template> = Vec::new();
    for &template in asked {
        if !templates.contains(&template) {
            templates.push(template);
        }
    }
    if templates.is_empty() {
        templates.push(if format.is_tree() {
            Template::Silhouettes
        } else {
            Template::Gei
        });
    }
    templates
}

/// Returns the settings with the size that a format needs, if none was given.
pub(super) fn sized(settings: Settings, given: bool, format: DatasetFormat) -> Settings {
    if format == DatasetFormat::Opengait && !given {
        return Settings {
            size: Size::S64x64,
            ..settings
        };
    }
    settings
}
