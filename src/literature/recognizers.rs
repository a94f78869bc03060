//! The recognizers, each with who published it.

use super::contests::{CONTESTS, Cell};
use super::subspaces::{Subspaces, Votes};
use crate::error::Result;
use crate::evaluate::contest::Entrant;
use crate::score::baseline::{Baseline, RANDOM};
use crate::score::{Contract, Layout, Model, Recognizer, Runtime};
use crate::sweep::{Raster, Settings, Views};
use crate::template::Template;
use crate::template::augment::{Augmentation, Crops};
use crate::train::{Analysed, Components, Method, Options, Recipe, Samples, Share, onnx};
use edgegait_core::pack::Pack;
use edgegait_core::raster::Rasterizer;
use serde::Serialize;

/// A recognizer, and where it comes from.
pub(crate) struct Known {
    /// What takes part.
    pub entrant: Entrant,
    /// Who published it.
    pub publication: &'static str,
}

/// What became of a recognizer.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Row {
    /// What it is called.
    pub name: String,
    /// Who published it.
    pub publication: &'static str,
    /// Whether it has learnt nothing.
    pub baseline: bool,
    /// A cell for each class of confounder.
    pub cells: Vec<Cell>,
}

impl Row {
    /// What became of this one.
    #[must_use]
    pub(crate) fn of(known: &Known, cells: Vec<Cell>) -> Self {
        Self {
            name: known.entrant.recognizer.name().to_owned(),
            publication: known.publication,
            baseline: known.entrant.recognizer.is_baseline(),
            cells,
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

/// Principal components that are kept: as `train` does.
const COMPONENTS: usize = 100;
/// Numbers of the random projection: as many as LDA of 26 people has.
const RANDOM_DIMS: usize = 25;
/// Azimuths of training, degrees: from the front to the back.
const TRAINED_DEG: std::ops::RangeInclusive<u16> = 0..=180;
const TRAINED_STEP_DEG: usize = 9;
/// How many recognizers are fitted.
const FITTED: usize = 3;

/// How many steps of progress there are: recognizers that are fitted, and contests of all.
pub(crate) const fn steps() -> usize {
    FITTED + (NEAREST.len() + 1 + FITTED) * CONTESTS
}

impl Known {
    /// All of them, trained on the walks of a pack; `progress` is called for each that is fitted.
    ///
    /// # Errors
    /// If there are too few people, or something cannot be drawn.
    pub(crate) fn all(
        training: &Pack<'_>,
        (subspaces, seed): (Subspaces, u64),
        progress: &(dyn Fn() + Sync),
    ) -> Result<Vec<Self>> {
        let settings = Settings {
            rasterizer: Raster::Each(Rasterizer::Rows),
            seed,
            ..Settings::default()
        };
        let nearest = |(template, publication): (Template, &'static str)| Self {
            entrant: Entrant {
                recognizer: Box::new(Baseline::like(contract(template, template.name()))),
                settings: Settings {
                    template,
                    ..settings
                },
            },
            publication,
        };
        let mut all: Vec<Self> = NEAREST.map(nearest).into();
        let random = Baseline::like(contract(Template::Gei, RANDOM)).projected(RANDOM_DIMS, seed);
        let mut add = |recognizer: Box<dyn Recognizer>, publication| {
            all.push(Self {
                entrant: Entrant {
                    recognizer,
                    settings,
                },
                publication,
            });
        };
        add(
            Box::new(random),
            "no training: a random projection of the GEI",
        );

        let walks: Vec<usize> = (0..training.walks().len()).collect();
        let azimuths = TRAINED_DEG.step_by(TRAINED_STEP_DEG).map(f32::from);
        let views = Views::grid("around", azimuths, [0.0])?;
        let recipe = Recipe {
            views: &views,
            settings,
            cycles: 1,
            share: Share::ALL,
            augmentation: Augmentation::default(),
        };
        let samples = Samples::drawn((training, &walks, "other people"), recipe, &|| ())?;
        let classes = samples.names.len();
        let form = (samples.template, samples.size);
        let analysed = Analysed::<f64>::of(form, samples.numbers.view(), &samples.labels, classes)?;
        let crops = Crops::default();
        for (name, method, publication) in [
            ("gei-lda", Method::LDA, "Han & Bhanu 2006: real templates"),
            (
                "gei-real-synthetic",
                Method::RealSynthetic { crops },
                "Han & Bhanu 2006: real and synthetic templates",
            ),
        ] {
            let fitted = analysed.fit(Options {
                components: Components::Count(COMPONENTS),
                method,
            })?;
            let contract = samples.contract(name.into(), (COMPONENTS as u16, method), "");
            let bytes = onnx::write(&fitted, name, &[]);
            let model = Model::from_bytes(format!("{name}.onnx"), bytes, contract)?;
            add(Runtime::rten().load(&model)?, publication);
            progress();
        }
        let contract = Contract {
            name: "gabor-subspaces".into(),
            classes: Vec::new(),
            ..samples.contract(String::new(), (0, Method::LDA), "")
        };
        let votes = Votes::fit(&samples, subspaces, contract)?;
        add(
            Box::new(votes),
            "Guan & Li 2013: Gabor, random subspaces, 2DLDA",
        );
        progress();
        Ok(all)
    }
}

/// What a recognizer of a template expects that has learnt nothing.
fn contract(template: Template, name: &str) -> Contract {
    Contract {
        name: name.to_owned(),
        template,
        layout: Layout::of(template),
        ..Contract::default()
    }
}
