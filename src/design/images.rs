//! How a design's silhouettes are drawn, as users write it.

use crate::sweep::{Framing, Lens, Raster, Sensor, Settings};
use crate::template::Template;
use edgegait_core::silhouette::Size;
use serde::Deserialize;

/// The table `[images]`; what is left out is as `sweep` has it.
#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Images {
    template: Option<Template>,
    size: Option<WrittenSize>,
    raster: Option<WrittenRaster>,
    framing: Option<Framing>,
    lens: Option<WrittenLens>,
    distance_m: Option<f64>,
    frames_per_cycle: Option<u32>,
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

#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum WrittenLens {
    Ortho,
    Persp,
}

impl Images {
    pub(super) fn settings(&self, seed: u64) -> Result<Settings, String> {
        let usual = Settings::default();
        let lens = match self.lens {
            Some(WrittenLens::Persp) => Lens::Persp,
            Some(WrittenLens::Ortho) => Lens::Ortho,
            None => usual.lens,
        };
        let frames_per_cycle = self.frames_per_cycle.unwrap_or(usual.frames_per_cycle);
        if !(1..=4096).contains(&frames_per_cycle) {
            return Err(format!(
                "expected frames_per_cycle from 1 to 4096, found {frames_per_cycle}"
            ));
        }
        let settings = Settings {
            template: self.template.unwrap_or_default(),
            size: self.size.map_or(usual.size, |size| size.0),
            rasterizer: self.raster.map_or(usual.rasterizer, |raster| raster.0),
            framing: self.framing.unwrap_or_default(),
            lens,
            sensor: Sensor {
                distance_m: self.distance_m.unwrap_or(usual.sensor.distance_m),
                ..usual.sensor
            },
            frames_per_cycle,
            seed,
            ..usual
        };
        if settings.template == Template::Silhouettes {
            return Err("expected a template, of which a dataset holds one image for each cycle, found silhouettes".into());
        }
        if self.distance_m.is_some() && !settings.uses_sensor() {
            return Err("distance_m changes nothing with parallel rays (lens = \"persp\", or framing = \"camera\")".into());
        }
        Ok(settings)
    }
}
