//! A recognizer that takes part, and how it is shown people.

use crate::dataset::Dataset;
use crate::error::{Result, TemplateOrigin};
use crate::score::baseline::Baseline;
use crate::score::{Contract, Model, Recognizer, Runtime};
use crate::sequences::Form;
use crate::sweep::{FramingMode, Settings};
use crate::template::Template;
use edgegait_core::silhouette::Size;
use std::path::Path;

/// A recognizer, and how what it is shown is drawn.
pub struct Entrant {
    /// The recognizer.
    pub recognizer: Box<dyn Recognizer>,
    /// As its contract asks.
    pub settings: Settings,
}

/// How a dataset's templates are, which cannot be drawn otherwise.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StoredTemplates {
    /// Which they are.
    pub template: Template,
    /// Of which silhouettes.
    pub size: Size,
    /// How those were framed, if it says.
    pub framing: Option<FramingMode>,
}

impl StoredTemplates {
    /// What the dataset in `folder` says of itself.
    ///
    /// # Errors
    /// When what it calls its framing is none.
    pub fn of(dataset: &Dataset, folder: &Path) -> Result<Self> {
        Ok(Self {
            template: dataset.template(),
            size: dataset.size(),
            framing: dataset.framing(folder)?,
        })
    }
}

impl Entrant {
    /// A model that is shown what is drawn with these settings, but for the template, size, framing
    /// and number of frames, which are those that its contract states.
    ///
    /// # Errors
    /// If the runtime cannot load it, or its contract asks for what cannot be drawn.
    pub fn drawn(model: &Model, runtime: &Runtime, settings: Settings) -> Result<Self> {
        let settings = Self::settings_of(model.contract(), settings)?;
        Ok(Self {
            recognizer: runtime.load(model)?,
            settings,
        })
    }

    /// How templates are drawn for a contract, else with these settings.
    ///
    /// # Errors
    /// If it asks for what cannot be drawn.
    pub(crate) fn settings_of(contract: &Contract, settings: Settings) -> Result<Settings> {
        let size = contract.size().unwrap_or(settings.size);
        contract.require(size, None, TemplateOrigin::Drawn)?;
        // More are beyond what a contract may ask for.
        let frames = contract
            .frames
            .and_then(|frames| u32::try_from(frames).ok());
        let settings = Settings {
            template: contract.template,
            size,
            framing: contract.framing,
            frames_per_cycle: frames.unwrap_or(settings.frames_per_cycle),
            ..settings
        };
        settings.check()?;
        Ok(settings)
    }

    /// A model that is shown the templates of a dataset. `settings` is how other silhouettes would
    /// be drawn.
    ///
    /// # Errors
    /// If the runtime cannot load it, or its contract asks for other templates.
    pub fn stored(
        model: &Model,
        runtime: &Runtime,
        (stored, settings): (StoredTemplates, Settings),
    ) -> Result<Self> {
        let settings = Self::stored_settings_of(model.contract(), (stored, settings))?;
        Ok(Self {
            recognizer: runtime.load(model)?,
            settings,
        })
    }

    /// How the templates of a dataset are drawn for a contract, else with these settings.
    ///
    /// # Errors
    /// If it asks for other templates.
    pub(crate) fn stored_settings_of(
        contract: &Contract,
        (stored, settings): (StoredTemplates, Settings),
    ) -> Result<Settings> {
        let origin = TemplateOrigin::Dataset;
        // A dataset has no silhouettes, as it says itself.
        if contract.template != Template::Silhouettes {
            contract.require_template(stored.template, origin)?;
        }
        contract.require(stored.size, stored.framing, origin)?;
        Ok(Settings {
            template: contract.template,
            size: stored.size,
            framing: contract.framing,
            ..settings
        })
    }

    /// The baseline, which compares templates pixel by pixel: of a dataset, or drawn like this.
    #[must_use]
    pub fn pixels(stored: Option<StoredTemplates>, settings: Settings) -> Self {
        let settings = stored.map_or(settings, |stored| Settings {
            template: stored.template,
            size: stored.size,
            framing: stored.framing.unwrap_or_default(),
            ..settings
        });
        let recognizer = Baseline::pixels(settings.template, settings.size, settings.framing);
        Self {
            recognizer: Box::new(recognizer),
            settings,
        }
    }

    /// Whether another recognizer is shown the same pictures.
    #[must_use]
    pub fn is_shown_as(&self, other: &Self) -> bool {
        self.form() == other.form()
    }

    /// How it is shown sequences.
    #[must_use]
    pub fn form(&self) -> Form {
        let contract = self.recognizer.contract();
        Form {
            settings: Settings {
                template: contract.template,
                ..self.settings
            },
            frames: contract.frames,
        }
    }
}
