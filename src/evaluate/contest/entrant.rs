//! A recognizer in a contest, and how its inputs are rendered.

use crate::dataset::Dataset;
use crate::dataset::sequences::Form;
use crate::draw::sweep::{FramingMode, Settings};
use crate::draw::template::Template;
use crate::error::{Result, TemplateOrigin};
use crate::inference::baseline::Baseline;
use crate::inference::{Contract, Model, Recognizer, Runtime};
use edgegait_core::silhouette::Size;
use std::path::Path;

/// A recognizer in a contest, and how its inputs are rendered.
pub struct Entrant {
    /// The recognizer.
    pub recognizer: Box<dyn Recognizer>,
    /// How inputs are rendered, as its contract specifies.
    pub settings: Settings,
    /// Bytes of the model's file, if it has one.
    pub model_bytes: Option<u64>,
}

/// The fixed form of a dataset's templates.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StoredTemplates {
    /// Kind of template.
    pub template: Template,
    /// Size of the silhouettes.
    pub size: Size,
    /// Framing of the silhouettes, if the dataset states it.
    pub framing: Option<FramingMode>,
}

impl StoredTemplates {
    /// Returns the form that the dataset in `folder` states.
    ///
    /// # Errors
    /// If it names an unknown framing.
    pub fn from_dataset(dataset: &Dataset, folder: &Path) -> Result<Self> {
        Ok(Self {
            template: dataset.template(),
            size: dataset.size(),
            framing: dataset.framing(folder)?,
        })
    }
}

impl Entrant {
    /// Loads a model whose inputs are rendered with these settings, except for the template, size,
    /// framing and number of frames, which its contract states.
    ///
    /// # Errors
    /// If the runtime cannot load it, or its contract asks for inputs that cannot be rendered.
    pub fn drawn(model: &Model, runtime: &Runtime, settings: Settings) -> Result<Self> {
        let settings = Self::settings_of(model.contract(), settings)?;
        Ok(Self {
            recognizer: runtime.load(model)?,
            settings,
            model_bytes: Some(model.bytes().len() as u64),
        })
    }

    /// Returns how inputs are rendered for a contract; `settings` holds where it states nothing.
    ///
    /// # Errors
    /// If the contract asks for inputs that cannot be rendered.
    pub(crate) fn settings_of(contract: &Contract, settings: Settings) -> Result<Settings> {
        let size = contract.size().unwrap_or(settings.size);
        contract.require(size, None, TemplateOrigin::Drawn)?;
        // A contract cannot ask for more than fit.
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

    /// Loads a model that is shown the templates of a dataset. `settings` holds for everything that
    /// neither the dataset nor the contract states.
    ///
    /// # Errors
    /// If the runtime cannot load it, or its contract asks for other templates.
    pub fn stored(
        model: &Model,
        runtime: &Runtime,
        stored: StoredTemplates,
        settings: Settings,
    ) -> Result<Self> {
        let settings = Self::stored_settings_of(model.contract(), stored, settings)?;
        Ok(Self {
            recognizer: runtime.load(model)?,
            settings,
            model_bytes: Some(model.bytes().len() as u64),
        })
    }

    /// Returns the settings of a dataset's templates for a contract; `settings` holds where neither
    /// states anything.
    ///
    /// # Errors
    /// If the contract asks for other templates.
    pub(crate) fn stored_settings_of(
        contract: &Contract,
        stored: StoredTemplates,
        settings: Settings,
    ) -> Result<Settings> {
        let origin = TemplateOrigin::Dataset;
        // A dataset without silhouettes reports that itself.
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

    /// Returns the baseline `pixels`, which compares templates pixel by pixel: those of a dataset,
    /// or rendered with these settings.
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
            model_bytes: None,
        }
    }

    /// Returns whether another recognizer is shown the same pictures.
    #[must_use]
    pub fn is_shown_as(&self, other: &Self) -> bool {
        self.form() == other.form()
    }

    /// Returns the form in which the recognizer is shown sequences.
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
