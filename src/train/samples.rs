//! Training samples: templates of rendered walks, of a dataset, or of a tree.

use super::CycleShare;
use crate::dataset::sequences::{Form, SequenceOrigin, SequenceSource};
use crate::dataset::{Dataset, IndexRow};
use crate::draw::sweep::{FramingMode, Job, Lens, Settings, Views, jobs, sweep};
use crate::draw::template::Template;
use crate::draw::template::augment::{Augmentation, Crops, varied};
use crate::error::{ChoiceError, Result};
use crate::inference::{Contract, EMBEDDING, InputLayout, OutputNames, SCORES, Training};
use edgegait_core::pack::Pack;
use edgegait_core::silhouette::Size;
use ndarray::Array2;
use std::collections::{BTreeSet, HashSet};
use std::path::Path;

/// Training templates with their people.
#[derive(Clone, Debug, PartialEq)]
pub struct Samples {
    /// The templates, one a row, numbers in 0..1.
    pub numbers: Array2<f32>,
    /// The kind of template.
    pub template: Template,
    /// The size of their silhouettes.
    pub size: Size,
    /// The framing of the silhouettes; none if a dataset does not state it.
    pub framing: Option<FramingMode>,
    /// The number of each row's person.
    pub labels: Vec<usize>,
    /// The number of each row's viewpoint, in the order of [`Training::viewpoints`]; none if its
    /// angles are not known.
    pub views: Vec<Option<usize>>,
    /// The people's names, in the order of their first appearance.
    pub names: Vec<String>,
    /// The number of samples before a share of them was drawn.
    pub found: usize,
    /// The training data as a contract states it.
    pub training: Training,
}

/// How training templates are made from walks.
#[derive(Clone, Copy, Debug)]
pub struct Recipe<'a> {
    /// The viewpoints.
    pub views: &'a Views,
    /// How walks are rendered, and the template: one image or vector for each cycle.
    pub settings: Settings,
    /// The number of cycles of a walk: the stored one and seeded variations of it.
    pub cycles: u32,
    /// The share of each person's cycles that is trained on.
    pub share: CycleShare,
    /// The variants that are added to each template.
    pub augmentation: Augmentation,
}

impl Samples {
    /// Renders templates of these walks of a pack called `name`. Calls `progress` for each cycle of
    /// a walk, first for those that are left out.
    ///
    /// # Errors
    /// For uncut motions, for silhouettes, and for templates that cannot be rendered or augmented.
    pub fn drawn(
        pack: &Pack<'_>,
        walks: &[usize],
        name: &str,
        recipe: Recipe<'_>,
        progress: &(dyn Fn() -> Result<()> + Sync),
    ) -> Result<Self> {
        let Recipe {
            views,
            settings,
            cycles,
            share,
            augmentation,
        } = recipe;
        let (template, size) = (settings.template, settings.size);
        augmentation.check(template, size)?;
        let all: Vec<_> = pack.walks().collect();
        let people = each_once(walks.iter().map(|&walk| all[walk].subject));
        let subjects: Vec<_> = pack.subjects().collect();
        let every = jobs(pack, walks, 0..cycles)?;
        let origin = |job: &Job<'_>| SequenceOrigin {
            walk: all[job.walk].name.to_owned(),
            cycle: Some(u32::from(all[job.walk].cycle)),
            variation: job.variation,
            seed: settings.seed,
        };
        let origins: Vec<SequenceOrigin> = every.iter().map(origin).collect();
        let person = |job: &Job<'_>| subjects[all[job.walk].subject].name;
        let kept = share.kept(every.iter().map(person).zip(&origins));
        let jobs: Vec<Job<'_>> = kept.iter().map(|&at| every[at]).collect();
        (jobs.len()..every.len()).try_for_each(|_| progress())?;
        let found = every.len() * views.list.len();
        let mut rows = CollectedSamples::new(size, augmentation);
        sweep(
            pack,
            &jobs,
            &views.list,
            settings,
            |_, swept| {
                progress()?;
                Ok(swept)
            },
            |job, swept| {
                let person = all[job.walk].subject;
                let label = people.iter().position(|&p| p == person).unwrap_or(0);
                for (view, bytes) in swept.templates.iter().enumerate() {
                    rows.push(bytes, label, Some(view));
                }
                Ok(())
            },
        )?;
        let names = sorted(jobs.iter().map(|job| all[job.walk].name));
        let people = people.iter().map(|&p| subjects[p].name.to_owned());
        let training = Training {
            description: format!(
                "{} of {name}, variations 0 to {}, {} viewpoints, seed {}, raster {}{}{}",
                names.join(","),
                cycles - 1,
                views.list.len(),
                settings.seed,
                settings.rasterizer,
                if settings.lens == Lens::Persp {
                    format!(", in perspective from {} m", settings.sensor.distance_m)
                } else {
                    String::new()
                },
                described(augmentation),
            ),
            viewpoints: views
                .list
                .iter()
                .map(|view| view.angles_deg().into())
                .collect(),
            subjects: Vec::new(),
            walks: names.iter().map(|&name| name.to_owned()).collect(),
            cycles: sorted(jobs.iter().map(|job| u32::from(all[job.walk].cycle))),
            variations: sorted(jobs.iter().map(|job| job.variation)),
            seed: settings.seed,
            seeds: Vec::new(),
        };
        let framing = Some(settings.framing);
        rows.samples(template, framing, people.collect(), found, training)
    }

    /// Reads the templates in these ascending rows of the dataset in `folder`, if they are in the
    /// share.
    ///
    /// # Errors
    /// For templates that cannot be augmented, and for a dataset that is augmented already.
    ///
    /// # Panics
    /// If the index has no such row.
    pub fn of_dataset(
        dataset: &Dataset,
        folder: &Path,
        chosen: &[usize],
        share: CycleShare,
        augmentation: Augmentation,
    ) -> Result<Self> {
        let (template, size) = (dataset.template(), dataset.size());
        augmentation.check(template, size)?;
        let settings = &dataset.manifest().header.settings;
        if augmentation != Augmentation::default() && settings.contains_key("augment") {
            return Err(ChoiceError::Augmented(folder.to_path_buf()).into());
        }
        let index = dataset.index();
        let origin = |&at: &usize| SequenceOrigin {
            walk: index[at].walk.clone(),
            cycle: Some(index[at].cycle),
            variation: index[at].variation,
            seed: index[at].seed,
        };
        let origins: Vec<SequenceOrigin> = chosen.iter().map(origin).collect();
        let people = chosen.iter().map(|&at| index[at].subject.as_str());
        let kept = share.kept(people.zip(&origins)).into_iter();
        let kept: Vec<usize> = kept.map(|at| chosen[at]).collect();
        let mut names: Vec<String> = Vec::new();
        let mut viewpoints: Vec<[f64; 2]> = Vec::new();
        let mut rows = CollectedSamples::new(size, augmentation);
        for &at in &kept {
            let row = &index[at];
            let known = names.iter().position(|name| *name == row.subject);
            let label = known.unwrap_or_else(|| {
                names.push(row.subject.clone());
                names.len() - 1
            });
            let viewpoint = [row.azimuth_deg, row.elevation_deg];
            let known = viewpoints.iter().position(|known| *known == viewpoint);
            let view = known.unwrap_or_else(|| {
                viewpoints.push(viewpoint);
                viewpoints.len() - 1
            });
            rows.push(dataset.bytes(at), label, Some(view));
        }
        let shown = || kept.iter().map(|&at| &index[at]);
        let training = Training {
            description: format!(
                "the {} {} of {}{}",
                kept.len(),
                template.plural(),
                folder.display(),
                described(augmentation)
            ),
            viewpoints,
            subjects: Vec::new(),
            walks: sorted(shown().map(|row: &IndexRow| row.walk.clone())),
            cycles: sorted(shown().map(|row| row.cycle)),
            variations: sorted(shown().map(|row| row.variation)),
            seed: shown().next().map_or(0, |row| row.seed),
            seeds: Vec::new(),
        };
        let framing = dataset.framing(folder)?;
        rows.samples(template, framing, names, chosen.len(), training)
    }

    /// Makes templates of a tree's recordings, or of their gait cycles, framed as the settings
    /// state, if they are in the share. The tree is called `name`.
    ///
    /// # Errors
    /// For recordings that cannot be read, made into this template, or augmented.
    pub fn of_recordings(
        source: &SequenceSource<'_>,
        name: &str,
        settings: Settings,
        share: CycleShare,
        augmentation: Augmentation,
    ) -> Result<Self> {
        let (template, size) = (settings.template, settings.size);
        augmentation.check(template, size)?;
        let sequences = source.sequences();
        let all = 0..sequences.list.len();
        let cycle = |at| {
            let person = &sequences.subjects[sequences.subject(at)];
            (person.as_str(), sequences.origin(at))
        };
        let kept = share.kept(all.clone().map(cycle));
        let form = Form {
            settings,
            frames: None,
        };
        let shown = || kept.iter().map(|&at| &sequences.list[at]);
        let angles = |view: &usize| sequences.views[*view].angles_deg();
        let seen = each_once(shown().map(|sequence| sequence.view));
        let viewpoints: Vec<usize> = seen
            .into_iter()
            .filter(|view| angles(view).is_some())
            .collect();
        let mut rows = CollectedSamples::new(size, augmentation);
        source.show(&kept, &form, &mut |number, bytes| {
            let view = sequences.list[number].view;
            let view = viewpoints.iter().position(|&known| known == view);
            rows.push(bytes, sequences.subject(number), view);
            Ok(())
        })?;
        let angles = viewpoints.iter().filter_map(angles);
        let origins = shown().map(|sequence| &sequences.origins[sequence.origin]);
        let training = Training {
            description: format!(
                "the {} {} of {name}{}",
                kept.len(),
                template.plural(),
                described(augmentation)
            ),
            viewpoints: angles.map(Into::into).collect(),
            subjects: Vec::new(),
            walks: sorted(shown().map(|sequence| sequences.takes[sequence.take].name.clone())),
            cycles: sorted(origins.filter_map(|origin| origin.cycle)),
            variations: vec![0],
            seed: 0,
            seeds: Vec::new(),
        };
        let (framing, names) = (Some(settings.framing), sequences.subjects.clone());
        rows.samples(template, framing, names, all.len(), training)
    }

    /// Returns the contract of a model called `name` that was fitted to these samples; `how`
    /// describes the method.
    #[must_use]
    pub fn contract(&self, name: String, how: &str) -> Contract {
        let description = &self.training.description;
        Contract {
            name,
            rows: self.size.rows(),
            columns: self.size.columns(),
            layout: InputLayout::for_template(self.template),
            framing: self.framing.unwrap_or_default(),
            template: self.template,
            classes: self.names.clone(),
            outputs: OutputNames {
                embedding: Some(EMBEDDING.into()),
                scores: Some(SCORES.into()),
            },
            training: Training {
                description: format!("{how} on {description}"),
                ..self.training.clone()
            },
            ..Contract::default()
        }
    }
}

impl Samples {
    /// Returns the contract of a model that gives only embeddings, so these people are not its
    /// classes.
    #[must_use]
    pub(super) fn contract_of_embeddings(&self, name: String, how: &str) -> Contract {
        let contract = self.contract(name, how);
        Contract {
            classes: Vec::new(),
            outputs: OutputNames {
                scores: None,
                ..contract.outputs
            },
            training: Training {
                subjects: contract.classes,
                ..contract.training
            },
            ..contract
        }
    }
}

/// Samples that are being collected.
struct CollectedSamples {
    size: Size,
    augmentation: Augmentation,
    numbers: Vec<f32>,
    labels: Vec<usize>,
    views: Vec<Option<usize>>,
}

impl CollectedSamples {
    const fn new(size: Size, augmentation: Augmentation) -> Self {
        Self {
            size,
            augmentation,
            numbers: Vec::new(),
            labels: Vec::new(),
            views: Vec::new(),
        }
    }

    /// Appends a template of this person from this viewpoint, and its variants.
    fn push(&mut self, bytes: &[u8], label: usize, view: Option<usize>) {
        let mut append = |bytes: &[u8]| {
            let unit = bytes.iter().map(|&byte| f32::from(byte) / 255.0);
            self.numbers.extend(unit);
        };
        append(bytes);
        let variants = self.augmentation.variants();
        for &variant in variants.iter().skip(1) {
            append(&varied(bytes, self.size, variant));
        }
        self.labels
            .extend(std::iter::repeat_n(label, variants.len()));
        self.views.extend(std::iter::repeat_n(view, variants.len()));
    }

    /// Returns the samples of these people; `found` templates existed before a share was drawn.
    fn samples(
        self,
        template: Template,
        framing: Option<FramingMode>,
        names: Vec<String>,
        found: usize,
        training: Training,
    ) -> Result<Samples> {
        let columns = template.shape(self.size).numbers();
        let numbers = Array2::from_shape_vec((self.labels.len(), columns), self.numbers)?;
        Ok(Samples {
            numbers,
            template,
            size: self.size,
            framing,
            labels: self.labels,
            views: self.views,
            names,
            found: found * self.augmentation.variants().len(),
            training,
        })
    }
}

/// Describes the variants that were added to samples; empty if there are none.
fn described(augmentation: Augmentation) -> String {
    let flip = augmentation.flip.then(|| "flip".to_owned());
    let crop = augmentation
        .crops
        .map(|Crops { steps, rows }| format!("crop ({steps} steps of {rows} of the lowest rows)"));
    let ways: Vec<String> = flip.into_iter().chain(crop).collect();
    match ways.as_slice() {
        [] => String::new(),
        _ => format!(", augmented by {}", ways.join(", ")),
    }
}

/// Returns each of these once, in the order of their first appearance.
fn each_once(all: impl Iterator<Item = usize>) -> Vec<usize> {
    let mut seen = HashSet::new();
    all.filter(|number| seen.insert(*number)).collect()
}

/// Returns each of these once, ascending.
fn sorted<T: Ord>(all: impl Iterator<Item = T>) -> Vec<T> {
    all.collect::<BTreeSet<T>>().into_iter().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn people_whose_walks_are_not_side_by_side_are_one_class_each() {
        assert_eq!(each_once([2, 0, 2, 2, 1, 0].into_iter()), [2, 0, 1]);
        assert_eq!(sorted([2, 0, 2, 1, 0].into_iter()), [0, 1, 2]);
    }

    #[test]
    fn a_description_says_how_samples_were_augmented() {
        let crops = Some(Crops { steps: 3, rows: 2 });
        let all = Augmentation { flip: true, crops };
        assert_eq!(
            described(all),
            ", augmented by flip, crop (3 steps of 2 of the lowest rows)"
        );
        let flip = Augmentation { crops: None, ..all };
        assert_eq!(described(flip), ", augmented by flip");
        assert_eq!(described(Augmentation::default()), "");
    }
}
