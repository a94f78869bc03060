//! Joins several training sources: people by name, and the training data that a contract states.
//!
//! Principal components are fitted only to the joined samples.

use super::{CycleShare, Samples};
use crate::draw::sweep::FramingMode;
use crate::draw::template::Template;
use crate::error::{ChoiceError, Error, Result};
use crate::inference::Training;
use edgegait_core::silhouette::Size;
use ndarray::Array2;
use std::collections::{BTreeSet, HashMap, HashSet};

/// The samples of one source.
#[derive(Clone, Debug, PartialEq)]
pub struct MixPart {
    /// The name of the source.
    pub name: String,
    /// The share of the source that the samples are.
    pub share: CycleShare,
    /// The samples.
    pub samples: Samples,
}

/// The form of samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SampleForm {
    /// The template.
    pub template: Template,
    /// The size of its silhouettes.
    pub size: Size,
    /// Their framing, if known.
    pub framing: Option<FramingMode>,
}

/// Checks that sources have the same template, size and framing; each comes with its name.
///
/// # Errors
/// If they differ; the error names the setting and the first two that differ.
pub fn require_one_form(sources: &[(&str, SampleForm)]) -> Result<()> {
    let setting = |setting, value: fn(&SampleForm) -> Option<&'static str>| {
        let mut known = sources
            .iter()
            .filter_map(|(name, form)| Some((*name, value(form)?)));
        let first = known.next();
        match first.and_then(|first| Some((first, known.find(|other| other.1 != first.1)?))) {
            None => Ok(()),
            Some(differing) => Err(ChoiceError::SourcesDiffer {
                setting,
                sources: [differing.0.0, differing.1.0].map(str::to_owned),
                values: [differing.0.1, differing.1.1],
            }),
        }
    };
    setting("template", |form| Some(form.template.name()))?;
    setting("size", |form| Some(form.size.name()))?;
    setting("framing", |form| form.framing.map(FramingMode::name))?;
    Ok(())
}

/// Returns a warning for each pair of sources without a common person.
#[must_use]
pub fn strangers(parts: &[MixPart]) -> Vec<String> {
    let people: Vec<HashSet<&String>> = parts
        .iter()
        .map(|part| part.samples.names.iter().collect())
        .collect();
    let mut found = Vec::new();
    for (at, one) in parts.iter().enumerate() {
        for (other, theirs) in parts[..at].iter().zip(&people) {
            if theirs.is_disjoint(&people[at]) {
                found.push(format!(
                    "{} and {} have no person of the same name, by which people are joined: any difference between the sources also distinguishes their people",
                    other.name, one.name
                ));
            }
        }
    }
    found
}

/// Joins the samples of all parts, one after another. People of one name are one class, in the
/// order of their first appearance.
///
/// # Errors
/// If there is no part, or as [`require_one_form`].
pub fn joined(parts: Vec<MixPart>) -> Result<Samples> {
    let forms: Vec<(&str, SampleForm)> = parts
        .iter()
        .map(|part| (part.name.as_str(), form(&part.samples)))
        .collect();
    require_one_form(&forms)?;
    let framing = forms.iter().find_map(|(_, form)| form.framing);
    let training = training(&parts);
    let views = { parts.iter() }.flat_map(|part| views_among(&part.samples, &training.viewpoints));
    let views = views.collect();
    let rows: usize = parts.iter().map(|part| part.samples.labels.len()).sum();
    let mut rest = parts.into_iter().map(|part| part.samples);
    let first = rest.next().ok_or(Error::Missing("a source"))?;
    let columns = first.numbers.ncols();
    let (mut numbers, _) = first.numbers.into_raw_vec_and_offset();
    numbers.reserve_exact(rows * columns - numbers.len());
    let mut joined = Samples {
        numbers: Array2::zeros((0, columns)),
        framing,
        views,
        training,
        ..first
    };
    let names = joined.names.iter().cloned().zip(0..);
    let mut classes: HashMap<String, usize> = names.collect();
    for part in rest {
        let mut class = |name: String| {
            let next = classes.len();
            *classes.entry(name).or_insert_with_key(|name| {
                joined.names.push(name.clone());
                next
            })
        };
        let own: Vec<usize> = part.names.into_iter().map(&mut class).collect();
        joined.labels.extend(part.labels.iter().map(|&at| own[at]));
        joined.found += part.found;
        numbers.extend(part.numbers);
    }
    joined.numbers = Array2::from_shape_vec((rows, columns), numbers)?;
    Ok(joined)
}

/// Returns the viewpoint of each sample, numbered as in the list of all viewpoints.
fn views_among(samples: &Samples, all: &[[f64; 2]]) -> Vec<Option<usize>> {
    let own =
        { samples.training.viewpoints.iter() }.map(|own| all.iter().position(|other| other == own));
    let own: Vec<Option<usize>> = own.collect();
    let of_sample = |view: &Option<usize>| own.get((*view)?).copied().flatten();
    samples.views.iter().map(of_sample).collect()
}

const fn form(samples: &Samples) -> SampleForm {
    SampleForm {
        template: samples.template,
        size: samples.size,
        framing: samples.framing,
    }
}

/// Returns the training data of all parts together. It does not state which source has which
/// people, walks, cycles and variations, so `score` may warn too often.
fn training(parts: &[MixPart]) -> Training {
    let all = || parts.iter().map(|part| &part.samples.training);
    let described = parts.iter().map(|part| {
        let Samples {
            labels,
            names,
            found,
            training,
            ..
        } = &part.samples;
        let drawn = match part.share.part() {
            1.0 => String::new(),
            share => format!(
                ", a share of {share} of each person's cycles, {} of {found} samples",
                labels.len()
            ),
        };
        let (name, description) = (&part.name, &training.description);
        format!("{name} ({} people{drawn}): {description}", names.len())
    });
    let described: Vec<String> = described.collect();
    let mut viewpoints: Vec<[f64; 2]> = Vec::new();
    for viewpoint in all().flat_map(|training| &training.viewpoints) {
        if !viewpoints.contains(viewpoint) {
            viewpoints.push(*viewpoint);
        }
    }
    let union = |of: fn(&Training) -> &Vec<u32>| -> Vec<u32> {
        let numbers: BTreeSet<u32> = all().flat_map(of).copied().collect();
        numbers.into_iter().collect()
    };
    // An empty list means that any cycle may have been trained on.
    let has_all_known = all().all(|training| !training.cycles.is_empty());
    let walks: BTreeSet<String> = all().flat_map(|training| training.walks.clone()).collect();
    // Recorded cycles have no seed.
    let varied = all().filter(|training| training.variations.iter().any(|&it| it > 0));
    let mut seeds: Vec<u64> = Vec::new();
    for seed in
        varied.flat_map(|training| [training.seed].into_iter().chain(training.seeds.clone()))
    {
        if !seeds.contains(&seed) {
            seeds.push(seed);
        }
    }
    let mut seeds = seeds.into_iter();
    Training {
        description: described.join("; "),
        viewpoints,
        subjects: Vec::new(),
        walks: walks.into_iter().collect(),
        cycles: if has_all_known {
            union(|training| &training.cycles)
        } else {
            Vec::new()
        },
        variations: union(|training| &training.variations),
        seed: seeds.next().or(all().next().map(|it| it.seed)).unwrap_or(0),
        seeds: seeds.collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dataset::sequences::{BUILT_IN_WALK, PackSource, Selection, built_in};
    use crate::draw::sweep::{Raster, Settings, Views};
    use crate::draw::template::augment::Augmentation;
    use crate::train::Recipe;
    use edgegait_core::pack::Pack;
    use edgegait_core::raster::Rasterizer;

    /// Returns one sample of each person, with all pixels of this grey.
    fn samples(people: &[&str], grey: f32, training: Training) -> Samples {
        Samples {
            numbers: Array2::from_elem((people.len(), Size::S50x30.pixels()), grey),
            template: Template::Gei,
            size: Size::S50x30,
            framing: None,
            labels: (0..people.len()).collect(),
            views: vec![Some(1); people.len()],
            names: people.iter().map(|&name| name.to_owned()).collect(),
            found: people.len(),
            training,
        }
    }

    fn part(name: &str, share: CycleShare, samples: Samples) -> MixPart {
        MixPart {
            name: name.into(),
            share,
            samples,
        }
    }

    fn drawn_from(walks: &[&str], cycles: &[u32], variations: &[u32], seed: u64) -> Training {
        Training {
            description: format!("seed {seed}"),
            viewpoints: vec![[90.0, 0.0], [seed as f64, 0.0]],
            walks: walks.iter().map(|&walk| walk.to_owned()).collect(),
            cycles: cycles.to_vec(),
            variations: variations.to_vec(),
            seed,
            ..Training::default()
        }
    }

    #[test]
    fn people_of_one_name_are_one_class_in_the_order_of_their_first_appearance() {
        let whole = |name, people: &[&str], grey| {
            part(
                name,
                CycleShare::ALL,
                samples(people, grey, Training::default()),
            )
        };
        let parts = vec![
            whole("a", &["bob", "ann"], 0.1),
            whole("b", &["cy", "ann"], 0.2),
            whole("c", &["bob", "cy", "dan"], 0.3),
        ];
        assert_eq!(strangers(&parts), [""; 0]);
        let all = joined(parts).expect("one form");
        assert_eq!(all.names, ["bob", "ann", "cy", "dan"]);
        assert_eq!(all.labels, [0, 1, 2, 1, 0, 2, 3]);
        assert_eq!(all.views, [None; 7]);
        assert_eq!((all.numbers.dim(), all.found), ((7, 1_500), 7));
        let greys: Vec<f32> = all.numbers.column(1_499).to_vec();
        assert_eq!(greys, [0.1, 0.1, 0.2, 0.2, 0.3, 0.3, 0.3]);
    }

    #[test]
    fn sources_without_a_common_person_are_named() {
        let whole = |name, people: &[&str]| {
            part(
                name,
                CycleShare::ALL,
                samples(people, 0.5, Training::default()),
            )
        };
        let parts = [
            whole("a", &["ann", "bob"]),
            whole("b", &["cy"]),
            whole("c", &["cy", "ann"]),
        ];
        let found = strangers(&parts);
        assert_eq!(found.len(), 1);
        assert!(found[0].starts_with("a and b have no person"), "{found:?}");
    }

    #[test]
    fn a_contract_says_of_all_sources_what_any_was_trained_on() {
        let half = CycleShare::new(0.5, 1).expect("in range");
        let parts = |other: Training| {
            let drawn = drawn_from(&["w2", "w1"], &[1, 4], &[0, 1], 7);
            let one = samples(&["ann"], 0.1, drawn);
            let other = Samples {
                found: 4,
                ..samples(&["ann", "bob"], 0.2, other)
            };
            vec![part("a", CycleShare::ALL, one), part("b", half, other)]
        };
        let training = |other| joined(parts(other)).expect("one form").training;
        let both = joined(parts(drawn_from(&["w3", "w1"], &[0, 4], &[5, 6], 8))).expect("one form");
        assert_eq!(both.views, [Some(1), Some(2), Some(2)]);
        let both = both.training;
        assert_eq!(
            both.description,
            "a (1 people): seed 7; b (2 people, a share of 0.5 of each person's cycles, 2 of 4 samples): seed 8"
        );
        assert_eq!(both.viewpoints, [[90.0, 0.0], [7.0, 0.0], [8.0, 0.0]]);
        assert_eq!(both.walks, ["w1", "w2", "w3"]);
        assert_eq!(
            (both.cycles, both.variations),
            (vec![0, 1, 4], vec![0, 1, 5, 6])
        );
        assert_eq!((both.seed, both.seeds), (7, vec![8]));
        // Recordings have no variations, so their seed means nothing; whole ones have all cycles.
        let whole = training(drawn_from(&["nm-01"], &[], &[0], 0));
        assert_eq!((whole.cycles, whole.seed, whole.seeds), (vec![], 7, vec![]));
    }

    #[test]
    fn sources_of_different_forms_are_refused_with_both_names() {
        let (gei, size, height) = (Template::Gei, Size::S50x30, Some(FramingMode::Height));
        let form = |template, size, framing| SampleForm {
            template,
            size,
            framing,
        };
        let refusal = |template, of, framing| {
            let found = require_one_form(&[
                ("a", form(gei, size, None)),
                ("b", form(gei, size, height)),
                ("c", form(template, of, framing)),
            ]);
            found.err().map(|error| error.to_string())
        };
        assert_eq!(refusal(gei, size, None), None);
        assert_eq!(refusal(gei, size, height), None);
        let expected = |setting: &str, a: &str, b: &str| {
            Some(format!(
                "expected sources of one {setting}, found {a} and {b} of c"
            ))
        };
        assert_eq!(
            refusal(gei, Size::S64x44, height),
            expected("size", "50x30 of a", "64x44")
        );
        assert_eq!(
            refusal(Template::Mei, size, height),
            expected("template", "gei of a", "mei")
        );
        // The framing of the first is not known.
        assert_eq!(
            refusal(gei, size, Some(FramingMode::Box)),
            expected("framing", "height of b", "box")
        );
    }

    #[test]
    fn mirrored_copies_and_all_viewpoints_are_on_the_side_of_their_cycle() {
        let walk = BUILT_IN_WALK.to_owned();
        let cohort =
            PackSource::made(&built_in(std::slice::from_ref(&walk)), &|| Ok(())).expect("stored");
        let pack = Pack::parse(&cohort.bytes).expect("ours");
        let selection = Selection {
            subjects: vec!["F01".into(), "M01".into()],
            walks: vec![walk],
        };
        let walks = selection.selected_walks(&pack).expect("there");
        let views = Views::grid("two", vec![0.0, 90.0], vec![0.0]).expect("angles");
        let drawn = |share| {
            let recipe = Recipe {
                views: &views,
                settings: Settings {
                    rasterizer: Raster::Each(Rasterizer::Rows),
                    frames_per_cycle: 8,
                    ..Settings::default()
                },
                cycles: 5,
                share,
                augmentation: Augmentation {
                    flip: true,
                    crops: None,
                },
            };
            Samples::drawn(&pack, &walks, "cohort", recipe, &|| Ok(())).expect("drawn")
        };
        // Four samples of each cycle follow one another: two viewpoints, and their mirror images.
        let all = drawn(CycleShare::ALL);
        assert_eq!((all.labels.len(), all.found), (2 * 5 * 4, 2 * 5 * 4));
        let some = drawn(CycleShare::new(0.6, 1).expect("in range"));
        assert_eq!((some.labels.len(), some.found), (2 * 3 * 4, 2 * 5 * 4));
        let place = |row| {
            all.numbers
                .rows()
                .into_iter()
                .position(|other| other == row)
        };
        let places: Vec<usize> = some.numbers.rows().into_iter().filter_map(place).collect();
        assert_eq!(places.len(), 24);
        for cycle in places.chunks(4) {
            assert!(cycle[0].is_multiple_of(4), "{places:?}");
            assert_eq!(cycle, Vec::from_iter(cycle[0]..cycle[0] + 4));
        }
        let label = |&place: &usize| all.labels[place];
        assert_eq!(some.labels, places.iter().map(label).collect::<Vec<_>>());
        assert_eq!(some.names, ["F01", "M01"]);
        // The contract names no variation that was left out.
        let mut shown: Vec<u32> = places.iter().map(|at| (at / 4 % 5) as u32).collect();
        shown.sort_unstable();
        shown.dedup();
        assert_eq!(some.training.variations, shown);
    }
}
