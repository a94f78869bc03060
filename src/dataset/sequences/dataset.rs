//! Sequences of a dataset, which are stored templates.

use super::{Form, Labels, MadeTake, SequenceOrigin, Sequences, ShownCounts, ViewLabel};
use crate::dataset::Dataset;
use crate::draw::template::Template;
use crate::error::{Error, Result};
use std::path::PathBuf;

/// The templates of a dataset with their labels.
pub struct DatasetTemplates {
    dataset: Dataset,
    path: PathBuf,
    pub(super) sequences: Sequences,
}

impl DatasetTemplates {
    /// Labels the templates. Takes are the walks of each person under each condition. If every
    /// person has only one take, the variations that `made` names become takes of their own.
    pub(super) fn new(dataset: Dataset, path: PathBuf, made: &[MadeTake]) -> Self {
        let label = |is_made: bool| {
            let mut labels = Labels::default();
            for row in dataset.index() {
                let of_variation = made
                    .iter()
                    .find(|take| is_made && take.variation == row.variation);
                let name =
                    of_variation.map_or(row.walk.as_str(), |variation| variation.take.as_str());
                let take = labels.take(&row.subject, name, &row.condition);
                let view = labels.view(ViewLabel::Angles(row.azimuth_deg, row.elevation_deg));
                let origin = labels.origin(SequenceOrigin {
                    walk: row.walk.clone(),
                    cycle: Some(row.cycle),
                    variation: row.variation,
                    seed: row.seed,
                });
                labels.push(take, origin, view);
            }
            labels.sequences
        };
        let mut sequences = label(false);
        if sequences.takes.len() == sequences.subjects.len() {
            sequences = label(true);
        }
        Self {
            dataset,
            path,
            sequences,
        }
    }

    /// Returns the dataset.
    #[must_use]
    pub const fn dataset(&self) -> &Dataset {
        &self.dataset
    }

    pub(super) fn show(
        &self,
        wanted: &[usize],
        form: &Form,
        sink: &mut dyn FnMut(usize, &[u8]) -> Result<()>,
    ) -> Result<ShownCounts> {
        let (wanted_is, found_is) = (form.settings.template, self.dataset.template());
        if wanted_is != found_is {
            let expected = match wanted_is {
                Template::Silhouettes => {
                    "a pack or a tree of silhouettes, since the model takes silhouettes".to_owned()
                }
                other => format!("{}, which the model takes", other.plural()),
            };
            return Err(Error::input(
                &self.path,
                format!("expected {expected}, found {}", found_is.plural()),
            ));
        }
        let mut silhouettes = 0;
        for &number in wanted {
            sink(number, self.dataset.bytes(number))?;
            silhouettes += u64::from(self.dataset.index()[number].frames);
        }
        Ok(ShownCounts {
            silhouettes,
            ..ShownCounts::default()
        })
    }
}
