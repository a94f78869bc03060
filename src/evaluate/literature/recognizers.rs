//! The recognizers of the literature, with their publications.

use super::contests::{JudgedRecognizer, conditions, cross_views};
use super::garments::Garments;
use crate::dataset::sequences::BUILT_IN_WALK;
use crate::draw::sweep::{Job, Raster, Settings, Views, jobs, sweep};
use crate::draw::template::Template;
use crate::draw::template::augment::{Augmentation, Crops};
use crate::error::{Error, Result};
use crate::evaluate::contest::Entrant;
use crate::inference::baseline::{Baseline, RANDOM};
use crate::inference::{Contract, InputLayout, Model, Recognizer, Runtime, Training};
use crate::train::subspaces::{RandomSubspaces, SubspaceOptions};
use crate::train::view_transformation::ViewTransformation;
use crate::train::{
    Analysed, Components, CycleShare, Recipe, Samples, TrainMethod, TrainOptions, feature_choice,
    onnx,
};
use edgegait_core::pack::Pack;
use edgegait_core::raster::Rasterizer;
use ndarray::Array2;
use serde::Serialize;

/// A recognizer and its publication.
pub(crate) struct PublishedRecognizer {
    /// The entrant.
    pub entrant: Entrant,
    /// The publication.
    pub publication: &'static str,
}

/// The results of a recognizer of the literature.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct LiteratureRow {
    /// The name of the recognizer.
    pub name: String,
    /// The publication.
    pub publication: &'static str,
    /// Whether it has learnt nothing.
    pub baseline: bool,
    #[serde(flatten)]
    pub judged: JudgedRecognizer,
}

impl LiteratureRow {
    /// Makes the row of this entrant.
    #[must_use]
    pub(crate) fn from_entrant(
        entrant: &Entrant,
        publication: &'static str,
        judged: JudgedRecognizer,
    ) -> Self {
        Self {
            name: entrant.recognizer.name().to_owned(),
            publication,
            baseline: entrant.recognizer.is_baseline(),
            judged,
        }
    }
}

/// Templates that are compared as they are, with their publications.
const NEAREST: [(Template, &str); 9] = [
    (Template::Gei, "Han & Bhanu 2006"),
    (Template::Mei, "Bobick & Davis 2001"),
    (Template::Mhi, "Bobick & Davis 2001"),
    (Template::Msi, "Lam & Lee 2006"),
    (Template::Ghi, "Liu & Zheng 2007, -style"),
    (Template::Geni, "Bashir, Xiang & Gong 2009"),
    (Template::Frequency, "Makihara et al. 2006"),
    (Template::Kfd, "Yu et al. 2004, -style"),
    (Template::RowWidth, "after Nandy et al., -style"),
];

/// Principal components that are kept, as in `train`.
const COMPONENTS: usize = 100;
/// Numbers of the random projection: as many as LDA of 26 people has.
const RANDOM_DIMS: usize = 25;
/// Azimuths of training, degrees: from the front to the back.
const TRAINED_DEG: std::ops::RangeInclusive<u16> = 0..=180;
const TRAINED_STEP_DEG: usize = 9;
/// Cycles in each garment, from which rows are chosen.
const CYCLES: u32 = 4;
/// The number of recognizers that are fitted.
pub(crate) const FITTED: usize = 5;

impl PublishedRecognizer {
    /// Returns all recognizers, trained on the walks of a pack, and statistics of how the row
    /// widths of its people change with clothes. The view transformation learns the viewpoints of
    /// `seen_from`, or those of the class "view". Calls `progress` for each recognizer that is
    /// fitted.
    ///
    /// # Errors
    /// If there are too few people, or a walk cannot be rendered.
    pub(crate) fn all(
        training: &Pack<'_>,
        seen_from: Option<Views>,
        subspaces: SubspaceOptions,
        seed: u64,
        progress: &(dyn Fn() -> Result<()> + Sync),
    ) -> Result<(Vec<Self>, Garments)> {
        let settings = Settings {
            rasterizer: Raster::Each(Rasterizer::Rows),
            seed,
            ..Settings::default()
        };
        let mut all = Self::untrained(settings);
        let around = TRAINED_DEG.step_by(TRAINED_STEP_DEG).map(f32::from);
        let samples = drawn(training, settings, Views::grid("around", around, [0.0])?)?;
        all.extend(Self::discriminants(&samples, settings, progress)?);
        let fitted = RandomSubspaces::fit(&samples, subspaces)?;
        let name = "gabor-subspaces";
        let contract = fitted.contract(&samples, name.into());
        all.push(Self::new(
            loaded(fitted.write(name), contract)?,
            "Guan & Li 2013: Gabor, random subspaces, 2DLDA",
            settings,
        ));
        progress()?;
        let seen_from = seen_from.map_or_else(cross_views, Ok)?;
        all.push(Self::view_transformation(training, settings, seen_from)?);
        progress()?;
        let (chosen, garments) = Self::chosen_rows(training, settings)?;
        all.push(chosen);
        progress()?;
        Ok((all, garments))
    }

    fn new(recognizer: Box<dyn Recognizer>, publication: &'static str, settings: Settings) -> Self {
        Self {
            entrant: Entrant {
                recognizer,
                settings,
                model_bytes: None,
            },
            publication,
        }
    }

    /// Returns the recognizers that learn nothing.
    fn untrained(settings: Settings) -> Vec<Self> {
        let nearest = |(template, publication): (Template, &'static str)| {
            let recognizer = Baseline::like(contract(template, template.name()));
            let settings = Settings {
                template,
                ..settings
            };
            Self::new(Box::new(recognizer), publication, settings)
        };
        let random = Baseline::like(contract(Template::Gei, RANDOM));
        let random = random.projected(RANDOM_DIMS, settings.seed);
        let publication = "no training: a random projection of the GEI";
        let random = Self::new(Box::new(random), publication, settings);
        NEAREST.map(nearest).into_iter().chain([random]).collect()
    }

    /// Fits discriminant analysis to real templates, and to these with synthetic ones.
    fn discriminants(
        samples: &Samples,
        settings: Settings,
        progress: &(dyn Fn() -> Result<()> + Sync),
    ) -> Result<Vec<Self>> {
        let analysed = Analysed::<f64>::analyse(
            samples.template,
            samples.size,
            samples.numbers.view(),
            &samples.labels,
            samples.names.len(),
        )?;
        let crops = Crops::default();
        let methods = [
            (
                "gei-lda",
                TrainMethod::LDA,
                "Han & Bhanu 2006: real templates",
            ),
            (
                "gei-real-synthetic",
                TrainMethod::RealSynthetic { crops },
                "Han & Bhanu 2006: real and synthetic templates",
            ),
        ];
        let fit = |(name, method, publication): (&str, TrainMethod, _)| {
            let fitted = analysed.fit(TrainOptions {
                components: Components::Count(COMPONENTS),
                method,
            })?;
            let contract = samples.contract(name.into(), &method.to_string());
            let bytes = onnx::write(&fitted, name, &[]);
            let fitted = Self::new(loaded(bytes, contract)?, publication, settings);
            progress()?;
            Ok(fitted)
        };
        methods.into_iter().map(fit).collect()
    }

    /// Fits the transformation of frequency templates to the probe's viewpoint.
    fn view_transformation(
        training: &Pack<'_>,
        settings: Settings,
        seen_from: Views,
    ) -> Result<Self> {
        let frequency = Settings {
            template: Template::Frequency,
            ..settings
        };
        let samples = drawn(training, frequency, seen_from)?;
        let fitted = ViewTransformation::fit(&samples, Components::Variance(1.0))?;
        let name = "view-transformation";
        let contract = fitted.contract(&samples, name.into());
        Ok(Self::new(
            loaded(fitted.write(name), contract)?,
            "Makihara et al. 2006: frequency, to the probe's viewpoint",
            frequency,
        ))
    }

    /// Fits the choice of rows, and returns how clothes change all rows.
    fn chosen_rows(training: &Pack<'_>, settings: Settings) -> Result<(Self, Garments)> {
        let widths = Settings {
            template: Template::RowWidth,
            ..settings
        };
        let (samples, names, worn) = dressed(training, widths)?;
        let fitted = feature_choice::fit(&samples)?;
        let garments = Garments::compute(&samples, names, &worn, feature_choice::chosen(&fitted));
        let name = "row-width-chosen";
        let contract = samples.contract(name.into(), feature_choice::METHOD);
        let bytes = onnx::write(&fitted, name, &[]);
        let chosen = Self::new(
            loaded(bytes, contract)?,
            "after Nandy et al.: rows chosen by what clothes change",
            widths,
        );
        Ok((chosen, garments))
    }
}

/// Loads a recognizer from a model file.
fn loaded(bytes: Vec<u8>, contract: Contract) -> Result<Box<dyn Recognizer>> {
    // People are enrolled, and identified by their embeddings.
    let contract = Contract {
        classes: Vec::new(),
        ..contract
    };
    let model = Model::from_bytes(format!("{}.onnx", contract.name), bytes, contract)?;
    Runtime::rten().load(&model)
}

/// Renders templates of all walks of a pack, from these viewpoints.
fn drawn(training: &Pack<'_>, settings: Settings, views: Views) -> Result<Samples> {
    let walks: Vec<usize> = (0..training.walks().len()).collect();
    let recipe = Recipe {
        views: &views,
        settings,
        cycles: 1,
        share: CycleShare::ALL,
        augmentation: Augmentation::default(),
    };
    Samples::drawn(training, &walks, "other people", recipe, &|| Ok(()))
}

/// Renders templates of people in all clothes of the catalogue, from the side. Also returns the
/// garments, and the number of the garment in each sample.
fn dressed(training: &Pack<'_>, settings: Settings) -> Result<(Samples, Vec<String>, Vec<usize>)> {
    let walks: Vec<_> = training.walks().collect();
    let at_known = (0..walks.len()).filter(|&walk| walks[walk].name == BUILT_IN_WALK);
    let cycles = jobs(training, &at_known.collect::<Vec<_>>(), 0..CYCLES)?;
    let conditions = conditions(&["normal", "clothes"])?;
    let names: Vec<String> = conditions
        .iter()
        .map(|condition| condition.name.clone())
        .collect();
    let (mut numbers, mut labels, mut worn) = (Vec::new(), Vec::new(), Vec::new());
    sweep(
        training,
        &Job::under(&cycles, &conditions),
        &Views::side()?.list,
        settings,
        |_, swept| Ok(swept),
        |job, swept| {
            let bytes = swept.templates.concat();
            numbers.extend(bytes.iter().map(|&byte| f32::from(byte) / 255.0));
            labels.push(walks[job.walk].subject);
            let name = job
                .condition
                .map_or("", |condition| condition.name.as_str());
            let garment = names.iter().position(|other| other == name);
            worn.push(garment.ok_or(Error::Missing("the garment of a walk"))?);
            Ok(())
        },
    )?;
    let people = training.subjects().map(|subject| subject.name.to_owned());
    let shape = (
        labels.len(),
        settings.template.shape(settings.size).numbers(),
    );
    let samples = Samples {
        numbers: Array2::from_shape_vec(shape, numbers)?,
        template: settings.template,
        size: settings.size,
        framing: Some(settings.framing),
        views: vec![Some(0); labels.len()],
        found: labels.len(),
        labels,
        names: people.collect(),
        training: Training {
            viewpoints: vec![[90.0, 0.0]],
            ..Training::default()
        },
    };
    Ok((samples, names, worn))
}

/// Returns the contract of a baseline for this template.
fn contract(template: Template, name: &str) -> Contract {
    Contract {
        name: name.to_owned(),
        template,
        layout: InputLayout::for_template(template),
        ..Contract::default()
    }
}
