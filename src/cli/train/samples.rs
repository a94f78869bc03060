//! What is trained on: templates of walks that are drawn here, or of a dataset.

use super::Args;
use crate::cli::augment::{append_varied, described, stated_augmentation};
use crate::cli::drawing::{framing_of, stated};
use crate::cli::progress::Progress;
use crate::dataset::{Dataset, Header, IndexRow, InputFile};
use crate::error::{Error, Result};
use crate::score::Training;
use crate::sweep::{Framing, Lens, jobs, sweep};
use crate::template::Template;
use crate::template::augment::Augmentation;
use edgegait_core::pack::Pack;
use edgegait_core::silhouette::Size;
use std::collections::{BTreeSet, HashSet};
use std::path::Path;

/// Cycles of each walk that are trained on unless a user says otherwise.
const CYCLES: u32 = 8;

/// Templates with their people; `training.description` says of what and how.
pub struct Samples {
    /// Of all templates, 0..1.
    pub numbers: Vec<f32>,
    /// Which template they are.
    pub template: Template,
    /// Of which silhouettes.
    pub size: Size,
    /// How those were framed.
    pub framing: Framing,
    /// The number of each one's person.
    pub labels: Vec<usize>,
    /// The people.
    pub names: Vec<String>,
    /// What a contract says of them.
    pub training: Training,
    /// What results say of them.
    pub header: Header,
}

/// Each of these once, in the order of their first appearance.
fn each_once(all: impl Iterator<Item = usize>) -> Vec<usize> {
    let mut seen = HashSet::new();
    all.filter(|one| seen.insert(*one)).collect()
}

/// Each of these once, rising.
fn sorted<T: Ord>(all: impl Iterator<Item = T>) -> Vec<T> {
    all.collect::<BTreeSet<T>>().into_iter().collect()
}

/// Samples drawn here, from a pack or from the built-in cohort.
pub fn from_walks(args: &Args) -> Result<Samples> {
    let views = args.views.views("side")?;
    let settings = args.draw.settings(args.common.seed)?;
    let (template, size) = (settings.template, settings.size);
    if template == Template::Silhouettes {
        return Err(Error::Usage(
            "--template silhouettes: these recognizers take one image or vector of each cycle"
                .into(),
        ));
    }
    let augmentation = args.augment.augmentation()?;
    augmentation.check(template, size)?;
    let source = args.source.load()?;
    let pack = Pack::parse(&source.bytes)?;
    let walks = args.source.choose(&pack)?;
    let all: Vec<_> = pack.walks().collect();
    let people = each_once(walks.iter().map(|&walk| all[walk].subject));
    let cycles = args.cycles.unwrap_or(CYCLES);
    let jobs = jobs(&pack, &walks, 0..cycles)?;
    let (mut numbers, mut labels) = (Vec::new(), Vec::new());
    let progress = Progress::new("cycles", jobs.len());
    sweep(
        &pack,
        &jobs,
        &views.list,
        settings,
        |_, swept| {
            progress.step();
            Ok(swept)
        },
        |job, swept| {
            let person = all[job.walk].subject;
            let label = people.iter().position(|&p| p == person).unwrap_or(0);
            for bytes in &swept.templates {
                let added = append_varied(bytes, (size, augmentation), &mut numbers);
                labels.extend(std::iter::repeat_n(label, added));
            }
            Ok(())
        },
    )?;
    let names = sorted(walks.iter().map(|&walk| all[walk].name));
    let mut header = stated(Header::new("train", args.common.seed), &settings)
        .with("pack", source.name.as_str())
        .with("walks", names.join(","))
        .with("cycles", cycles)
        .with("views", views.name.as_str());
    header = stated_augmentation(header, augmentation);
    header.inputs = source.inputs;
    let subjects: Vec<_> = pack.subjects().collect();
    Ok(Samples {
        training: Training {
            description: format!(
                "{} of {}, variations 0 to {}, {} viewpoints, seed {}, raster {}{}{}",
                names.join(","),
                source.name,
                cycles - 1,
                views.list.len(),
                args.common.seed,
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
                .map(|view| [f64::from(view.azimuth_deg), f64::from(view.elevation_deg)])
                .collect(),
            subjects: Vec::new(),
            walks: names.iter().map(|&name| name.to_owned()).collect(),
            cycles: sorted(walks.iter().map(|&walk| u32::from(all[walk].cycle))),
            variations: (0..cycles).collect(),
            seed: args.common.seed,
        },
        numbers,
        template,
        size,
        framing: settings.framing,
        labels,
        names: people
            .iter()
            .map(|&p| subjects[p].name.to_owned())
            .collect(),
        header,
    })
}

/// All of a dataset's templates.
pub fn from_dataset(args: &Args, path: &Path) -> Result<Samples> {
    let names = [args.source.subjects.as_slice(), &args.source.walks];
    args.draw
        .refuse_for_folders(names, args.cycles, &args.views)?;
    let dataset = Dataset::open(path)?;
    let (template, size) = (dataset.template(), dataset.size());
    let augmentation = args.augment.augmentation()?;
    augmentation.check(template, size)?;
    let settings = &dataset.manifest().header.settings;
    if augmentation != Augmentation::default() && settings.contains_key("augment") {
        return Err(Error::Usage(format!(
            "--augment: {} is augmented already",
            path.display()
        )));
    }
    let mut names: Vec<String> = Vec::new();
    let mut viewpoints: Vec<[f64; 2]> = Vec::new();
    let mut labels = Vec::new();
    for row in dataset.index() {
        let known = names.iter().position(|name| *name == row.subject);
        labels.push(known.unwrap_or_else(|| {
            names.push(row.subject.clone());
            names.len() - 1
        }));
        let viewpoint = [row.azimuth_deg, row.elevation_deg];
        if !viewpoints.contains(&viewpoint) {
            viewpoints.push(viewpoint);
        }
    }
    let rows = dataset.index();
    let walks = sorted(rows.iter().map(|row: &IndexRow| row.walk.clone()));
    let (mut numbers, mut labels_of_all) = (Vec::new(), Vec::new());
    for (bytes, &label) in dataset.templates().zip(&labels) {
        let added = append_varied(bytes, (size, augmentation), &mut numbers);
        labels_of_all.extend(std::iter::repeat_n(label, added));
    }
    let header = Header::new("train", args.common.seed);
    let mut header = stated_augmentation(header, augmentation);
    if template != Template::Gei {
        header = header.with("template", template.name());
    }
    let framing = framing_of(&dataset, path)?;
    if framing.is_none() {
        header.warnings.push(format!(
            "{} does not say how its figures are framed: the model's contract says height",
            path.display()
        ));
    }
    header.inputs = vec![InputFile::of(path.join("manifest.json"))?];
    Ok(Samples {
        training: Training {
            description: format!(
                "the {} {} of {}{}",
                labels.len(),
                template.plural(),
                path.display(),
                described(augmentation)
            ),
            viewpoints,
            subjects: Vec::new(),
            walks,
            cycles: sorted(rows.iter().map(|row| row.cycle)),
            variations: sorted(rows.iter().map(|row| row.variation)),
            seed: rows.first().map_or(0, |row| row.seed),
        },
        numbers,
        template,
        size,
        framing: framing.unwrap_or_default(),
        labels: labels_of_all,
        names,
        header,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn people_whose_walks_are_not_side_by_side_are_one_class_each() {
        assert_eq!(each_once([2, 0, 2, 2, 1, 0].into_iter()), [2, 0, 1]);
        assert_eq!(sorted([2, 0, 2, 1, 0].into_iter()), [0, 1, 2]);
    }
}
