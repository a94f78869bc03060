//! The table of a design file that specifies its images.

use super::DesignImages;
use crate::draw::sweep::{FramingMode, Lens, Raster, Sensor, Settings, Wanted};
use crate::draw::template::Template;
use edgegait_core::silhouette::Size;
use serde::Deserialize;

/// The table `[images]`; missing keys have the defaults of `sweep`.
#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct WrittenImages {
    template: Option<WrittenTemplates>,
    #[serde(default)]
    joints: bool,
    fps: Option<f64>,
    size: Option<WrittenSize>,
    raster: Option<WrittenRaster>,
    framing: Option<FramingMode>,
    lens: Option<Lens>,
    distance_m: Option<f64>,
    frames_per_cycle: Option<u32>,
}

/// The name of a template, or several names.
#[derive(Deserialize)]
#[serde(
    untagged,
    expecting = "expected the name of a template, or a list of names"
)]
enum WrittenTemplates {
    One(Template),
    Several(Vec<Template>),
}

#[derive(Clone, Copy, Deserialize)]
#[serde(try_from = "String")]
struct WrittenSize(Size);

impl TryFrom<String> for WrittenSize {
    type Error = String;

    fn try_from(name: String) -> Result<Self, String> {
        let known = Size::ALL.into_iter().find(|size| size.name() == name);
        let all = Size::ALL.map(Size::name).join(", ");
        known
            .map(Self)
            .ok_or_else(|| format!("expected {all}, found {name:?}"))
    }
}

#[derive(Clone, Copy, Deserialize)]
#[serde(try_from = "String")]
struct WrittenRaster(Raster);

impl TryFrom<String> for WrittenRaster {
    type Error = String;

    fn try_from(name: String) -> Result<Self, String> {
        let known = Raster::all().find(|raster| raster.name() == name);
        let all: Vec<&str> = Raster::all().map(Raster::name).collect();
        known
            .map(Self)
            .ok_or_else(|| format!("expected {}, found {name:?}", all.join(", ")))
    }
}

impl WrittenImages {
    /// Returns the outputs for each cycle.
    pub(super) fn images(&self) -> Result<DesignImages, String> {
        let templates = match &self.template {
            None => vec![Template::Gei],
            Some(WrittenTemplates::One(template)) => vec![*template],
            Some(WrittenTemplates::Several(templates)) => templates.clone(),
        };
        let twice = (1..templates.len()).any(|at| templates[..at].contains(&templates[at]));
        if templates.is_empty() || twice {
            return Err("expected templates by name, each once".into());
        }
        if self.fps.is_some_and(|fps| !(fps > 0.0 && fps <= 1e4)) {
            return Err("expected fps above 0, at most 10000".into());
        }
        if self.fps.is_some() && self.frames_per_cycle.is_some() {
            return Err("expected fps or frames_per_cycle, found both".into());
        }
        Ok(DesignImages {
            wanted: Wanted {
                templates,
                joints: self.joints,
                blanks: true,
                fps: self.fps,
            },
            has_size: self.size.is_some(),
        })
    }

    pub(super) fn settings(&self, seed: u64) -> Result<Settings, String> {
        let usual = Settings::default();
        let frames_per_cycle = self.frames_per_cycle.unwrap_or(usual.frames_per_cycle);
        if !(1..=4096).contains(&frames_per_cycle) {
            return Err(format!(
                "expected frames_per_cycle from 1 to 4096, found {frames_per_cycle}"
            ));
        }
        let settings = Settings {
            template: self.images()?.wanted.templates[0],
            size: self.size.map_or(usual.size, |size| size.0),
            rasterizer: self.raster.map_or(usual.rasterizer, |raster| raster.0),
            framing: self.framing.unwrap_or_default(),
            lens: self.lens.unwrap_or_default(),
            sensor: Sensor {
                distance_m: self.distance_m.unwrap_or(usual.sensor.distance_m),
                ..usual.sensor
            },
            frames_per_cycle,
            seed,
            ..usual
        };
        if self.distance_m.is_some() && !settings.uses_sensor() {
            return Err("distance_m changes nothing with parallel rays (set lens = \"persp\" or framing = \"camera\")".into());
        }
        Ok(settings)
    }
}
