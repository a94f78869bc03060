//! Samples of one source of `train`: a pack, a tree, or a dataset.

use super::TrainArgs;
use super::opened_source::{ChosenSource, Opened, TemplateSettings};
use crate::cli::progress::Progress;
use crate::dataset::Dataset;
use crate::dataset::sequences::{PackSource, Recordings, SequenceSource};
use crate::draw::template::Template;
use crate::draw::template::augment::Augmentation;
use crate::error::{Error, Result};
use crate::files::ResultHeader;
use crate::train::{CycleShare, Recipe, Samples};
use edgegait_core::pack::Pack;
use std::path::Path;

/// Default number of training cycles of each walk.
const CYCLES: u32 = 8;

impl TrainArgs {
    /// Returns the samples of a source, and its header.
    pub(super) fn part(
        &self,
        chosen: ChosenSource,
        share: CycleShare,
        making: &TemplateSettings,
    ) -> Result<(Samples, ResultHeader)> {
        let ChosenSource {
            source,
            numbers,
            header,
        } = chosen;
        match source {
            Opened::Cohort => Err(Error::Missing("a pack")),
            Opened::Pack(source) => self.of_walks(source, &numbers, share, making, header),
            Opened::Folder(path, SequenceSource::Tree(recordings)) => {
                self.of_tree(&path, *recordings, share, making, header)
            }
            Opened::Folder(path, SequenceSource::Dataset(geis)) => {
                let dataset = geis.dataset();
                self.of_dataset(dataset, &path, &numbers, share, making.augmentation, header)
            }
            Opened::Folder(_, SequenceSource::Walks(_)) => {
                Err(Error::Missing("a dataset or a tree"))
            }
        }
    }

    /// Draws samples from a pack or from the built-in cohort.
    fn of_walks(
        &self,
        source: PackSource,
        walks: &[usize],
        share: CycleShare,
        making: &TemplateSettings,
        header: ResultHeader,
    ) -> Result<(Samples, ResultHeader)> {
        let pack = Pack::parse(&source.bytes)?;
        let cycles = self.cycles.unwrap_or(CYCLES);
        let progress = Progress::new(
            &self.common,
            ("drawing", "cycles"),
            walks.len() * cycles as usize,
        );
        let recipe = Recipe {
            views: &making.views,
            settings: making.settings,
            cycles,
            share,
            augmentation: making.augmentation,
        };
        let samples = Samples::drawn(&pack, walks, &source.name, recipe, &|| progress.step())?;
        let mut header = header
            .drawn(&making.settings)
            .with("pack", source.name.as_str())
            .with("walks", samples.training.walks.join(","))
            .with("cycles", cycles)
            .with("views", making.views.name.as_str())
            .augmented(making.augmentation);
        header.inputs = source.inputs;
        Ok((samples, header))
    }

    /// Makes the templates of a tree, of gait cycles or of whole recordings.
    fn of_tree(
        &self,
        path: &Path,
        recordings: Recordings,
        share: CycleShare,
        making: &TemplateSettings,
        mut header: ResultHeader,
    ) -> Result<(Samples, ResultHeader)> {
        let TemplateSettings {
            settings,
            augmentation,
            ..
        } = *making;
        let recordings = self.cutting.cut(recordings, &mut header, &self.common)?;
        let name = path.display().to_string();
        let source = SequenceSource::Tree(Box::new(recordings));
        let samples = Samples::of_recordings(&source, &name, settings, share, augmentation)?;
        let header = header
            .with("tree", name)
            .with("template", settings.template.name())
            .with("size", settings.size.name())
            .with("framing", settings.framing.name())
            .augmented(augmentation);
        Ok((samples, header))
    }

    /// Reads the templates of a dataset.
    fn of_dataset(
        &self,
        dataset: &Dataset,
        path: &Path,
        rows: &[usize],
        share: CycleShare,
        augmentation: Augmentation,
        header: ResultHeader,
    ) -> Result<(Samples, ResultHeader)> {
        let samples = Samples::of_dataset(dataset, path, rows, share, augmentation)?;
        let mut header = header.augmented(augmentation);
        if samples.template != Template::Gei {
            header = header.with("template", samples.template.name());
        }
        if samples.framing.is_none() {
            header.warnings.push(if self.states_sources() {
                "it does not state how its figures are framed: the framing of the others is assumed"
                    .to_owned()
            } else {
                format!(
                    "{} does not state how its figures are framed: the model's contract states height",
                    path.display()
                )
            });
        }
        header.warnings.extend(Dataset::said_of_pictures(path));
        header.inputs = Dataset::inputs(path)?;
        Ok((samples, header))
    }
}
