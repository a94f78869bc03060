//! Flags that choose how silhouettes are drawn, and how results state them.

use super::args::ViewArgs;
use super::walks::SelectionArgs;
use crate::draw::sweep::{Aim, FramingMode, Jitter, Lens, Raster, Sensor, Settings};
use crate::draw::template::Template;
use crate::error::{Error, Result, TemplateOrigin};
use crate::inference::Contract;
use clap::ValueEnum;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use edgegait_core::silhouette::Size;
use glam::Vec3;

/// The flags that choose how silhouettes are drawn.
#[derive(Clone, Debug, clap::Args)]
pub(super) struct DrawArgs {
    /// Template of each cycle's silhouettes; `render` and `sweep` take several [default: gei, or
    /// the template of a model's contract; silhouettes for `render` and for trees]
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    pub template: Vec<Template>,
    /// Rasteriser: tiny-skia, plain or anti-aliased; bit rows, with 1 or 3x3 samples a pixel; or
    /// columns, all elevations in one pass, for --framing cycle and camera [default: skia]
    #[arg(long, value_name = "NAME", value_parser = raster())]
    raster: Option<Raster>,
    /// Framing of figures in the image [default: height]
    #[arg(long, value_name = "NAME")]
    framing: Option<FramingMode>,
    /// Projection [default: ortho]
    #[arg(long, value_name = "NAME")]
    lens: Option<Lens>,
    /// Metres from the aim to the camera's eye [default: 4]
    #[arg(long, value_name = "D")]
    distance_m: Option<f64>,
    /// Vertical field of view in degrees, for --framing camera [default: 45]
    #[arg(long, value_name = "F")]
    fov_deg: Option<f64>,
    /// Camera movement: follow the pelvis, or stand still [default: follow]
    #[arg(long, value_name = "NAME")]
    camera: Option<CameraArg>,
    /// Aim of a static camera in metres [default: the pelvis' mean over the frames]
    #[arg(long, value_name = "X,Y,Z", value_parser = point, allow_hyphen_values = true)]
    aim_m: Option<Vec3>,
    /// Rows and columns: 50x30, 64x44 or 64x64 [default: 50x30]
    #[arg(long, value_name = "ROWSxCOLUMNS", value_parser = size)]
    size: Option<Size>,
    /// Offset of each frame's samples within the pixels [default: none]
    #[arg(long, value_name = "NAME")]
    jitter: Option<Jitter>,
    /// Silhouettes in each gait cycle [default: 32]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=4096))]
    frames_per_cycle: Option<u32>,
}

impl DrawArgs {
    /// Returns the settings of a recognizer's inputs: the size, framing and number of frames of its
    /// contract, unless flags choose others.
    ///
    /// # Errors
    /// The same as [`Self::settings`], and for flags that contradict the contract.
    pub(super) fn settings_for(&self, contract: &Contract, seed: u64) -> Result<Settings> {
        let frames = match (contract.frames, self.frames_per_cycle) {
            (Some(frames), Some(given)) if u32::try_from(frames) != Ok(given) => {
                return Err(Error::Usage(format!(
                    "--frames-per-cycle {given}: {} takes {frames}",
                    contract.name
                )));
            }
            (Some(frames), _) => u32::try_from(frames).ok(),
            (None, given) => given,
        };
        let template = self.only_template()?;
        contract.require_template(template.unwrap_or(contract.template), TemplateOrigin::Drawn)?;
        let settings = Self {
            template: vec![contract.template],
            size: self.size.or(contract.size()),
            framing: self.framing.or(Some(contract.framing)),
            frames_per_cycle: frames,
            ..self.clone()
        }
        .settings(seed)?;
        contract.require(settings.size, Some(settings.framing), TemplateOrigin::Drawn)?;
        Ok(settings)
    }

    /// Returns the requested template, if any.
    ///
    /// # Errors
    /// If several are requested.
    pub(super) fn only_template(&self) -> Result<Option<Template>> {
        match *self.template.as_slice() {
            [] => Ok(None),
            [template] => Ok(Some(template)),
            _ => Err(Error::Usage(
                "--template: expected one name, found several (`render` takes several)".into(),
            )),
        }
    }

    /// Returns whether a size was given.
    pub(super) const fn has_size(&self) -> bool {
        self.size.is_some()
    }

    /// Returns the flags without the template, for silhouettes that become templates later.
    #[must_use]
    pub(super) fn without_template(&self) -> Self {
        Self {
            template: Vec::new(),
            ..self.clone()
        }
    }

    /// Returns the flags without template, size and framing, which apply to a tree of silhouettes
    /// too.
    #[must_use]
    pub(super) fn without_size(&self) -> Self {
        Self {
            size: None,
            framing: None,
            ..self.without_template()
        }
    }

    /// Returns the settings of a sweep.
    ///
    /// # Errors
    /// For flags that have no effect with the others, and numbers out of range.
    pub(super) fn settings(&self, seed: u64) -> Result<Settings> {
        let default = Settings::default();
        let sensor = Sensor::default();
        let settings = Settings {
            rasterizer: self.raster.unwrap_or(default.rasterizer),
            size: self.size.unwrap_or_default(),
            framing: self.framing.unwrap_or_default(),
            lens: self.lens.unwrap_or_default(),
            sensor: Sensor {
                distance_m: self.distance_m.unwrap_or(sensor.distance_m),
                fov_deg: self.fov_deg.unwrap_or(sensor.fov_deg),
                aim: match (self.camera, self.aim_m) {
                    (Some(CameraArg::Static), None) => Aim::Mean,
                    (_, Some(point)) => Aim::Point(point),
                    (_, None) => Aim::Pelvis,
                },
            },
            jitter: self.jitter.unwrap_or_default(),
            frames_per_cycle: self.frames_per_cycle.unwrap_or(default.frames_per_cycle),
            seed,
            template: self.only_template()?.unwrap_or_default(),
        };
        settings.check()?;
        self.refuse_idle(&settings)?;
        Ok(settings)
    }

    /// Rejects flags that have no effect.
    fn refuse_idle(&self, settings: &Settings) -> Result<()> {
        let refuse = |flag: &str, why: String| Err(Error::Usage(format!("{flag}: {why}")));
        let framing = settings.framing.name();
        let of_sensor = [
            ("--distance-m", self.distance_m.is_some()),
            ("--camera", self.camera.is_some()),
            ("--aim-m", self.aim_m.is_some()),
            ("--fov-deg", self.fov_deg.is_some()),
        ];
        let given = of_sensor.iter().find(|(_, given)| *given);
        if let (false, Some((flag, _))) = (settings.uses_sensor(), given) {
            return refuse(
                flag,
                format!(
                    "with --lens ortho and --framing {framing}, the camera's position has no effect (use --lens persp or --framing camera)"
                ),
            );
        }
        if self.fov_deg.is_some() && settings.framing != FramingMode::Camera {
            return refuse(
                "--fov-deg",
                format!(
                    "--framing {framing} fits figures into the image, so that the field of view has no effect (use --framing camera)"
                ),
            );
        }
        if self.aim_m.is_some() && self.camera != Some(CameraArg::Static) {
            return refuse(
                "--aim-m",
                "a camera that follows the walker aims at the pelvis (use --camera static)".into(),
            );
        }
        Ok(())
    }

    /// Rejects flags that choose how silhouettes are drawn, for a tree, which contains them.
    ///
    /// # Errors
    /// For the first such flag that was given.
    pub(super) fn refuse_for_trees(&self) -> Result<()> {
        let none = SelectionArgs::default();
        let draw = self.without_size();
        draw.refuse_for_folders(&none, None, &ViewArgs::default())
    }

    /// Rejects flags that choose how walks are drawn, for a video, which is segmented.
    ///
    /// # Errors
    /// For the first such flag that was given.
    pub(super) fn refuse_for_video(&self) -> Result<()> {
        match self.given().iter().find(|(_, is_given)| *is_given) {
            Some((flag, _)) => Err(Error::Usage(format!(
                "{flag}: the silhouettes of a video follow each model's contract"
            ))),
            None => Ok(()),
        }
    }

    /// Returns the flags, and whether each was given.
    fn given(&self) -> [(&'static str, bool); 11] {
        [
            ("--template", !self.template.is_empty()),
            ("--raster", self.raster.is_some()),
            ("--framing", self.framing.is_some()),
            ("--lens", self.lens.is_some()),
            ("--distance-m", self.distance_m.is_some()),
            ("--fov-deg", self.fov_deg.is_some()),
            ("--camera", self.camera.is_some()),
            ("--aim-m", self.aim_m.is_some()),
            ("--size", self.size.is_some()),
            ("--jitter", self.jitter.is_some()),
            ("--frames-per-cycle", self.frames_per_cycle.is_some()),
        ]
    }

    /// Rejects flags that choose walks and how they are drawn, for a folder, whose images are used
    /// as they are.
    ///
    /// # Errors
    /// For the first such flag that was given.
    pub(super) fn refuse_for_folders(
        &self,
        selection: &SelectionArgs,
        cycles: Option<u32>,
        views: &ViewArgs,
    ) -> Result<()> {
        let flags = [
            ("--subjects", !selection.subjects.is_empty()),
            ("--walks", !selection.walks.is_empty()),
            ("--cycles", cycles.is_some()),
            ("--views, --azimuth-deg, --elevation-deg", views.is_given()),
        ];
        match flags.iter().chain(&self.given()).find(|(_, given)| *given) {
            Some((flag, _)) => Err(Error::Usage(format!(
                "{flag}: a folder is used whole and as it was drawn (use a pack, or sweep another dataset)"
            ))),
            None => Ok(()),
        }
    }
}

/// Parses the name of a rasteriser.
fn raster() -> impl TypedValueParser<Value = Raster> {
    let names = Raster::all().map(Raster::name);
    PossibleValuesParser::new(names).try_map(|name| {
        let known = Raster::all().find(|raster| raster.name() == name);
        known.ok_or("no such rasteriser")
    })
}

/// The movement of the camera.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum CameraArg {
    /// The camera keeps its distance to the pelvis, which stays in the middle
    Follow,
    /// The camera stands still
    Static,
}

/// Parses the name of a size.
fn size(name: &str) -> std::result::Result<Size, String> {
    let known = Size::ALL.into_iter().find(|size| size.name() == name);
    known.ok_or_else(|| "expected 50x30, 64x44 or 64x64".to_owned())
}

/// Parses a point `X,Y,Z`.
fn point(text: &str) -> std::result::Result<Vec3, String> {
    let numbers: std::result::Result<Vec<f32>, _> = text
        .split(',')
        .map(|number| number.trim().parse())
        .collect();
    match numbers.as_deref() {
        Ok(&[x, y, z]) => Ok(Vec3::new(x, y, z)),
        _ => Err("expected three numbers in metres, as in 0,0.9,0".to_owned()),
    }
}
