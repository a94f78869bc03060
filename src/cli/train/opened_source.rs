//! Opens the sources of `train`, and chooses the part of each to use, before long work.

use super::TrainArgs;
use crate::cli::layout::refuse_without_tree;
use crate::cli::progress::Progress;
use crate::cli::walks::SourceArgs;
use crate::dataset::sequences::{PackSource, Selection, SequenceSource, require};
use crate::dataset::{IndexRow, Partition, Tree};
use crate::draw::sweep::{Settings, Views};
use crate::draw::template::Template;
use crate::draw::template::augment::Augmentation;
use crate::error::{Error, Result};
use crate::files::{InputFile, ResultHeader};
use crate::train::{SampleForm, require_one_form};
use edgegait_core::pack::Pack;
use std::path::PathBuf;

/// An opened source.
pub(super) enum Opened {
    /// The built-in cohort, the default; made when it is needed.
    Cohort,
    Pack(PackSource),
    Folder(PathBuf, SequenceSource<'static>),
}

/// A source with the part that is used.
pub(super) struct ChosenSource {
    pub source: Opened,
    /// Numbers of a pack's walks, or rows of a dataset's index.
    pub numbers: Vec<usize>,
    pub header: ResultHeader,
}

impl Opened {
    pub(super) const fn kind(&self) -> &'static str {
        match self {
            Self::Cohort | Self::Pack(_) | Self::Folder(_, SequenceSource::Walks(_)) => "pack",
            Self::Folder(_, SequenceSource::Dataset(_)) => "dataset",
            Self::Folder(_, SequenceSource::Tree(_)) => "tree",
        }
    }

    /// Returns its path, as results state it.
    pub(super) fn path(&self) -> String {
        match self {
            Self::Cohort => "built-in cohort".to_owned(),
            Self::Pack(source) => source.name.clone(),
            Self::Folder(path, _) => path.display().to_string(),
        }
    }

    /// Returns the form of its templates; the settings apply to all sources except datasets.
    fn form(&self, settings: &Settings) -> Result<SampleForm> {
        if let Self::Folder(path, SequenceSource::Dataset(geis)) = self {
            let dataset = geis.dataset();
            return Ok(SampleForm {
                template: dataset.template(),
                size: dataset.size(),
                framing: dataset.framing(path)?,
            });
        }
        let Settings {
            template,
            size,
            framing,
            ..
        } = *settings;
        Ok(SampleForm {
            template,
            size,
            framing: Some(framing),
        })
    }

    /// Returns the names of its people and of its walks or takes.
    fn names(&self) -> Result<[Vec<String>; 2]> {
        match self {
            Self::Cohort => Ok([Vec::new(), Vec::new()]),
            Self::Pack(source) => {
                let pack = Pack::parse(&source.bytes)?;
                let people = pack.subjects().map(|subject| subject.name.to_owned());
                let walks = pack.walks().map(|walk| walk.name.to_owned());
                Ok([people.collect(), walks.collect()])
            }
            Self::Folder(_, source) => {
                let sequences = source.sequences();
                let takes = sequences.takes.iter().map(|take| take.name.clone());
                Ok([sequences.subjects.clone(), takes.collect()])
            }
        }
    }
}

impl TrainArgs {
    pub(super) fn opened(&self) -> Result<Vec<Opened>> {
        if self.sources.is_empty() {
            return Ok(vec![Opened::Cohort]);
        }
        let open = |path: &PathBuf| {
            if path.is_dir() {
                let source = SequenceSource::open(path, &[], &self.layout.layout())?;
                return Ok(Opened::Folder(path.clone(), source));
            }
            PackSource::read(path).map(Opened::Pack)
        };
        self.sources.iter().map(open).collect()
    }

    /// Rejects flags that no source can use, templates that cannot be trained on, and sources with
    /// different templates.
    pub(super) fn check(&self, opened: &[Opened], making: &TemplateSettings) -> Result<()> {
        let has = |kind| opened.iter().any(|source| source.kind() == kind);
        if !has("tree") {
            let flags = [("--partition", self.partition.is_some())].into_iter();
            refuse_without_tree(flags.chain(self.cutting.given()).chain(self.layout.given()))?;
        }
        match (has("pack"), has("tree")) {
            (true, _) => {}
            (false, true) if self.cycles.is_some() => {
                return Err(Error::Usage(
                    "--cycles: training uses all gait cycles of a tree's recordings".into(),
                ));
            }
            (false, true) => self.draw.refuse_for_trees()?,
            (false, false) => {
                self.draw
                    .refuse_for_folders(&self.selection, self.cycles, &self.views)?;
            }
        }
        if has("pack") || has("tree") {
            let Settings { template, size, .. } = making.settings;
            if template == Template::Silhouettes {
                return Err(Error::Usage(
                    "--template silhouettes: these recognizers take one image or vector of each cycle"
                        .into(),
                ));
            }
            making.augmentation.check(template, size)?;
        }
        if has("tree") {
            Tree::require_framing(making.settings.framing)?;
        }
        let named = |source: &Opened| Ok((source.path(), source.form(&making.settings)?));
        let forms: Vec<(String, SampleForm)> = opened.iter().map(named).collect::<Result<_>>()?;
        let forms: Vec<_> = forms
            .iter()
            .map(|(path, form)| (path.as_str(), *form))
            .collect();
        require_one_form(&forms)
    }

    /// Returns the requested people and walks of each source. With several sources, each name has
    /// to be in one of them, and a source gets the names that it has.
    pub(super) fn selections(&self, opened: &[Opened]) -> Result<Vec<Selection>> {
        let asked = self.selection.selection(self.sources.is_empty());
        if opened.len() < 2 {
            return Ok(vec![asked]);
        }
        let known: Vec<[Vec<String>; 2]> =
            opened.iter().map(Opened::names).collect::<Result<_>>()?;
        let all = |at: usize| -> Vec<&str> {
            let names = known.iter().flat_map(|names| &names[at]);
            names.map(String::as_str).collect()
        };
        require("subject", &asked.subjects, &all(0))?;
        require("walk", &asked.walks, &all(1))?;
        let select = |(source, [people, walks]): (&Opened, &[Vec<String>; 2])| {
            let within = |asked: &[String], known: &[String]| -> Result<Vec<String>> {
                let found = asked.iter().filter(|name| known.contains(name));
                let found: Vec<String> = found.cloned().collect();
                if found.is_empty() && !asked.is_empty() {
                    return Err(nothing(source));
                }
                Ok(found)
            };
            Ok(Selection {
                subjects: within(&asked.subjects, people)?,
                walks: within(&asked.walks, walks)?,
            })
        };
        opened.iter().zip(&known).map(select).collect()
    }

    /// Chooses the part of a source to use, and checks the image sizes of a tree.
    pub(super) fn chosen(
        &self,
        source: Opened,
        selection: &Selection,
        making: &TemplateSettings,
    ) -> Result<ChosenSource> {
        let mut header = ResultHeader::new("train", self.common.seed);
        let is_seen = |angles: (f64, f64)| !self.views.is_given() || making.views.has(angles);
        let walks = |source: PackSource| -> Result<(Opened, Vec<usize>)> {
            let walks = selection.selected_walks(&Pack::parse(&source.bytes)?)?;
            Ok((Opened::Pack(source), walks))
        };
        let (source, numbers) = match source {
            Opened::Cohort => {
                let selection = self.selection.clone();
                walks(SourceArgs::new(None, selection).load(&self.common)?)?
            }
            Opened::Pack(source) => walks(source)?,
            Opened::Folder(path, SequenceSource::Tree(recordings)) => {
                let views = self.views.is_given().then_some(&making.views);
                let mut recordings = recordings.chosen(selection, views)?;
                if let Some(partition) = &self.partition {
                    let (trained, warnings) =
                        recordings.trained(&Partition::read(partition)?, partition)?;
                    recordings = trained;
                    header.inputs.push(InputFile::read(partition)?);
                    header.warnings.extend(warnings);
                }
                header.warnings.extend(recordings.doubts());
                let progress =
                    Progress::new(&self.common, ("reading", "folders"), recordings.len());
                recordings.check_sizes(&[], &|| progress.step())?;
                drop(progress);
                let numbers = (0..recordings.len()).collect();
                let tree = SequenceSource::Tree(Box::new(recordings));
                (Opened::Folder(path, tree), numbers)
            }
            Opened::Folder(path, source) => {
                let rows = match &source {
                    SequenceSource::Dataset(geis) => geis.dataset().index(),
                    _ => &[],
                };
                let is_kept = |row: &IndexRow| {
                    selection.has(&row.subject, &row.walk)
                        && is_seen((row.azimuth_deg, row.elevation_deg))
                };
                let rows = rows.iter().enumerate().filter(|(_, row)| is_kept(row));
                let numbers = rows.map(|(at, _)| at).collect();
                (Opened::Folder(path, source), numbers)
            }
        };
        if numbers.is_empty() {
            return Err(nothing(&source));
        }
        Ok(ChosenSource {
            source,
            numbers,
            header,
        })
    }
}

/// Returns the error about a source without any chosen part.
fn nothing(source: &Opened) -> Error {
    Error::Usage(format!(
        "{}: expected some of the chosen people, walks and viewpoints, found none (leave it out, or choose others)",
        source.path()
    ))
}

/// The settings of templates, and their viewpoints.
pub(super) struct TemplateSettings {
    pub settings: Settings,
    pub augmentation: Augmentation,
    pub views: Views,
}
