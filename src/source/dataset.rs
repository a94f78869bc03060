//! Sequences of a dataset: GEIs as they are.

use super::{Form, Labels, Made, Sequences, Shown};
use crate::dataset::Dataset;
use crate::error::{Error, Result};
use crate::score::Template;
use std::path::PathBuf;

/// The GEIs of a dataset with their labels.
pub struct Geis {
    dataset: Dataset,
    path: PathBuf,
    pub(super) sequences: Sequences,
}

impl Geis {
    /// Takes are the walks of each person under each condition. If nobody has more than one, cycles
    /// whose numbers `made` names are takes of their own.
    pub(super) fn new(dataset: Dataset, path: PathBuf, made: &[Made]) -> Self {
        let label = |is_made: bool| {
            let mut labels = Labels::default();
            for row in dataset.index() {
                let of_cycle = made.iter().find(|one| is_made && one.cycle == row.cycle);
                let name = of_cycle.map_or(row.walk.as_str(), |one| one.take.as_str());
                let take = labels.take(&row.subject, name, &row.condition);
                let view = labels.view((row.azimuth_deg, row.elevation_deg));
                labels.push(take, row.cycle, view);
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

    /// The dataset itself.
    #[must_use]
    pub const fn dataset(&self) -> &Dataset {
        &self.dataset
    }

    /// Its folder.
    #[must_use]
    pub const fn path(&self) -> &PathBuf {
        &self.path
    }

    pub(super) fn show(
        &self,
        wanted: &[usize],
        form: &Form,
        sink: &mut dyn FnMut(usize, &[u8]) -> Result<()>,
    ) -> Result<Shown> {
        if form.template != Template::Gei {
            return Err(Error::input(
                &self.path,
                "expected a pack or a tree of silhouettes, as the model takes them one by one, found GEIs",
            ));
        }
        let mut silhouettes = 0;
        for &number in wanted {
            sink(number, self.dataset.gei(number))?;
            silhouettes += u64::from(self.dataset.index()[number].frames);
        }
        Ok(Shown {
            silhouettes,
            ..Shown::default()
        })
    }
}
