//! The settings that results and manifests state of their templates, by flag names.

use super::Dataset;
use crate::draw::sweep::{Aim, FramingMode, Sensor, Settings};
use crate::draw::template::Template;
use crate::draw::template::augment::{Augmentation, Crops};
use crate::error::{Error, Result};
use crate::files::ResultHeader;
use glam::Vec3;
use std::path::Path;

/// The settings that [`ResultHeader::drawn`] states.
const DRAWN: [&str; 11] = [
    "template",
    "raster",
    "framing",
    "lens",
    "distance_m",
    "fov_deg",
    "camera",
    "aim_m",
    "size",
    "jitter",
    "frames_per_cycle",
];

impl ResultHeader {
    /// Returns the header with the settings for drawing silhouettes.
    #[must_use]
    pub fn drawn(self, settings: &Settings) -> Self {
        let Sensor {
            distance_m,
            fov_deg,
            aim,
        } = settings.sensor;
        let header = match settings.template {
            Template::Gei => self,
            other => self.with("template", other.name()),
        };
        let mut header = header
            .with("raster", settings.rasterizer.name())
            .with("framing", settings.framing.name())
            .with("lens", settings.lens.name())
            .with("size", settings.size.name())
            .with("jitter", settings.jitter.name())
            .with("frames_per_cycle", settings.frames_per_cycle);
        if settings.uses_sensor() {
            let (camera, aim) = match aim {
                Aim::Pelvis => ("follow", "pelvis".to_owned()),
                Aim::Mean => ("static", "mean pelvis".to_owned()),
                Aim::Point(Vec3 { x, y, z }) => ("static", format!("{x},{y},{z}")),
            };
            header = header
                .with("distance_m", distance_m)
                .with("camera", camera)
                .with("aim_m", aim);
        }
        if settings.framing == FramingMode::Camera {
            header = header.with("fov_deg", fov_deg);
        }
        header
    }

    /// Returns the header with the drawing settings that a dataset states.
    #[must_use]
    pub fn drawn_as(mut self, dataset: &Dataset) -> Self {
        for key in DRAWN {
            if let Some(value) = dataset.manifest().header.settings.get(key) {
                self.settings.insert(key.to_owned(), value.clone());
            }
        }
        self
    }

    /// Returns the header with the augmentation settings, if there is any augmentation.
    #[must_use]
    pub fn augmented(self, augmentation: Augmentation) -> Self {
        if augmentation == Augmentation::default() {
            return self;
        }
        let names = [
            augmentation.flip.then_some("flip"),
            augmentation.crops.map(|_| "crop"),
        ];
        let names: Vec<&str> = names.into_iter().flatten().collect();
        let header = self.with("augment", names.join(","));
        match augmentation.crops {
            Some(Crops { steps, rows }) => header.with("crop_steps", steps).with("crop_rows", rows),
            None => header,
        }
    }
}

impl Dataset {
    /// Returns the framing that the dataset states, if any. `folder` is only for messages.
    ///
    /// # Errors
    /// If the stated value is not a framing.
    pub fn framing(&self, folder: &Path) -> Result<Option<FramingMode>> {
        let Some(stated) = self.manifest().header.settings.get("framing") else {
            return Ok(None);
        };
        let framing = serde_json::from_value(stated.clone());
        framing.map(Some).map_err(|error| {
            Error::input(folder.join("manifest.json"), format!("framing: {error}"))
        })
    }
}
