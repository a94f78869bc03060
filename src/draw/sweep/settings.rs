//! Settings of a sweep: everything on which its results depend, except the walkers.

use crate::draw::registers::registers;
use crate::draw::template::Template;
use crate::error::{ChoiceError, Result, SettingError};
use edgegait_core::raster::Rasterizer;
use edgegait_core::silhouette::Size;
use glam::{Vec2, Vec3};
use serde::{Deserialize, Serialize};
use std::fmt;

/// The default number of frames of a cycle. Our choice: a GEI of 32 frames differs by 4.2 of 255
/// (root mean square) from one of 512 frames, a GEI of 64 frames by 2.2, of 16 frames by 7.8 (two
/// people, 20 viewpoints, `render --template gei --frames-per-cycle N`).
pub const FRAMES_PER_CYCLE: u32 = 32;

/// The settings of a sweep.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// The rasteriser that fills pixels.
    pub rasterizer: Raster,
    /// Rows and columns of the silhouettes.
    pub size: Size,
    /// The placement and scale of figures in the image.
    pub framing: FramingMode,
    /// The lens: parallel rays or perspective.
    pub lens: Lens,
    /// The sensor, for a perspective lens or the framing of a camera.
    pub sensor: Sensor,
    /// The place in the pixel at which each frame is sampled.
    pub jitter: Jitter,
    /// The number of frames of each cycle.
    pub frames_per_cycle: u32,
    /// The seed of the cycles' variations.
    pub seed: u64,
    /// The template of each cycle's silhouettes.
    pub template: Template,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            rasterizer: Rasterizer::Skia.into(),
            size: Size::default(),
            framing: FramingMode::default(),
            lens: Lens::default(),
            sensor: Sensor::default(),
            jitter: Jitter::default(),
            frames_per_cycle: FRAMES_PER_CYCLE,
            seed: 1,
            template: Template::default(),
        }
    }
}

impl Settings {
    /// Returns whether the results depend on the sensor.
    #[must_use]
    pub fn uses_sensor(&self) -> bool {
        self.lens == Lens::Persp || self.framing == FramingMode::Camera
    }

    /// Returns whether the placement of a frame depends on the other frames.
    pub(super) fn needs_all_frames(&self) -> bool {
        self.framing == FramingMode::Cycle || (self.uses_sensor() && self.sensor.aim == Aim::Mean)
    }

    /// Checks that the settings can be drawn.
    ///
    /// # Errors
    /// If a number is out of its range, the settings are incompatible, or the processor lacks the
    /// registers that the environment names.
    pub fn check(&self) -> Result<()> {
        registers()?;
        if self.framing == FramingMode::Cycle && self.lens == Lens::Persp {
            return Err(ChoiceError::CycleNeedsParallelRays.into());
        }
        self.check_columns()?;
        let Sensor {
            distance_m,
            fov_deg,
            aim,
        } = self.sensor;
        // NaN is in no range.
        if !(0.1..=1e6).contains(&distance_m) {
            return Err(ChoiceError::Distance(distance_m).into());
        }
        if !(0.1..=170.0).contains(&fov_deg) {
            return Err(ChoiceError::FieldOfView(fov_deg).into());
        }
        match aim {
            Aim::Point(aim) if !(aim.is_finite() && aim.abs().max_element() <= 1e6) => {
                Err(ChoiceError::Aim(aim).into())
            }
            _ => Ok(()),
        }
    }

    /// Checks that rendering by columns makes GEIs, with one scale for all elevations.
    fn check_columns(&self) -> Result<()> {
        let is_summed = !matches!(self.template, Template::Gei | Template::Silhouettes);
        if self.rasterizer == Raster::Columns && is_summed {
            let problem = SettingError::ColumnsSumFrames(self.template.name());
            return Err(problem.refuses("raster", self.rasterizer.name()));
        }
        let (setting, value, has) = match (self.rasterizer, self.framing, self.lens) {
            (Raster::Columns, FramingMode::Height | FramingMode::Box, _) => {
                ("framing", self.framing.name(), "a scale for each frame")
            }
            (Raster::Columns, _, Lens::Persp) => ("lens", self.lens.name(), "rays from one eye"),
            _ => return Ok(()),
        };
        let problem = SettingError::ColumnsShareScale {
            setting,
            value,
            has,
        };
        Err(problem.refuses("raster", self.rasterizer.name()))
    }
}

/// A rasteriser that fills pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Raster {
    /// One of the core's rasterisers, viewpoint by viewpoint.
    Each(Rasterizer),
    /// All elevations of an azimuth in one pass, column by column.
    Columns,
}

impl Raster {
    /// Returns the name in flags and results.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Each(rasterizer) => rasterizer.name(),
            Self::Columns => "columns",
        }
    }

    /// Returns whether frames are drawn one by one, with pixels that are on or off.
    #[must_use]
    pub const fn is_binary(self) -> bool {
        matches!(
            self,
            Self::Each(Rasterizer::Skia | Rasterizer::TinySkia | Rasterizer::Rows)
        )
    }

    /// Returns the distance between samples, pixels.
    #[must_use]
    pub const fn spacing(self) -> f32 {
        match self {
            Self::Each(rasterizer) => rasterizer.spacing(),
            Self::Columns => 1.0,
        }
    }

    /// Returns all rasterisers.
    pub fn all() -> impl Iterator<Item = Self> {
        let each = Rasterizer::ALL.iter().chain(&[Rasterizer::TinySkia]);
        let each = each.map(|&rasterizer| rasterizer.into());
        each.chain([Self::Columns])
    }
}

impl From<Rasterizer> for Raster {
    fn from(rasterizer: Rasterizer) -> Self {
        Self::Each(rasterizer)
    }
}

impl fmt::Display for Raster {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// The placement and scale of figures in the image. GEIs of different framings are not
/// comparable.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum FramingMode {
    /// Each frame fills the rows, centred on its centroid.
    #[default]
    Height,
    /// Each frame is stretched to its bounding box.
    Box,
    /// One scale and centre for a whole cycle and all elevations.
    Cycle,
    /// The view of a sensor at the viewpoint.
    Camera,
}

impl FramingMode {
    /// Returns the name in flags, contracts and results.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Height => "height",
            Self::Box => "box",
            Self::Cycle => "cycle",
            Self::Camera => "camera",
        }
    }
}

/// A lens: parallel rays or perspective.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Lens {
    /// Parallel rays.
    #[default]
    Ortho,
    /// Perspective: rays from one eye.
    Persp,
}

impl Lens {
    /// Returns the name in flags and results.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Ortho => "ortho",
            Self::Persp => "persp",
        }
    }
}

/// A sensor with its distance, field of view and aim.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sensor {
    /// The distance from the aim to the eye in the direction of the viewpoint, metres.
    pub distance_m: f64,
    /// The vertical field of view, degrees.
    pub fov_deg: f64,
    /// The point at which the sensor looks.
    pub aim: Aim,
}

impl Default for Sensor {
    /// 4 m and 45 degrees: a person of 1.7 m takes half of the rows. Our choice.
    fn default() -> Self {
        Self {
            distance_m: 4.0,
            fov_deg: 45.0,
            aim: Aim::Pelvis,
        }
    }
}

impl Sensor {
    /// Returns pixels a metre at the aim, in an image of `size`.
    #[must_use]
    pub fn pixels_per_metre(&self, size: Size) -> f32 {
        let half = libm::tan(0.5 * self.fov_deg.to_radians());
        (size.rows() as f64 / (2.0 * self.distance_m * half)) as f32
    }
}

/// The point at which a sensor looks. Cycles are walked on the spot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Aim {
    /// The pelvis of each frame: the sensor follows the walker.
    Pelvis,
    /// The mean of the pelvis over all frames: the sensor stands still.
    Mean,
    /// A point, metres: the sensor stands still.
    Point(Vec3),
}

/// The place in the pixel at which each frame is sampled.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Jitter {
    /// The pixel's centre.
    #[default]
    None,
    /// A point of the R2 sequence, a different one for each frame (Roberts 2018).
    R2,
}

impl Jitter {
    /// Returns the name in flags and results.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::R2 => "r2",
        }
    }

    /// Returns the offset at which a frame is sampled, to the right and down, in units of
    /// [`Rasterizer::spacing`].
    ///
    /// R2 steps by the inverses of the plastic number and of its square: Roberts, "The
    /// Unreasonable Effectiveness of Quasirandom Sequences" (2018).
    #[must_use]
    pub fn of_frame(self, frame: u32) -> Vec2 {
        let along = |step: f64| ((0.5 + f64::from(frame) * step).fract() - 0.5) as f32;
        match self {
            Self::None => Vec2::ZERO,
            Self::R2 => Vec2::new(
                along(0.754_877_666_246_692_7),
                along(0.569_840_290_998_053_2),
            ),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn r2_begins_at_the_centre_and_steps_by_the_plastic_number() {
        let close = |found: Vec2, x, y| assert!((found - Vec2::new(x, y)).length() < 1e-6);
        close(Jitter::R2.of_frame(0), 0.0, 0.0);
        // 1.25488 and 1.06984 less 1, less a half.
        close(Jitter::R2.of_frame(1), -0.245_122_33, -0.430_159_7);
        // 2.00976 and 1.63968.
        close(Jitter::R2.of_frame(2), -0.490_244_66, 0.139_680_58);
        assert_eq!(Jitter::None.of_frame(7), Vec2::ZERO);
        // The plastic number is the root of x^3 = x + 1.
        let plastic = 1.0 / 0.754_877_666_246_692_7_f64;
        assert!((plastic.powi(3) - plastic - 1.0).abs() < 1e-12);
        assert!((0.569_840_290_998_053_2 - plastic.powi(-2)).abs() < 1e-12);
        for frame in 0..100_000 {
            assert!(Jitter::R2.of_frame(frame).abs().max_element() <= 0.5);
        }
    }

    #[test]
    fn a_field_of_view_of_90_degrees_shows_as_many_metres_as_twice_the_distance() {
        let sensor = Sensor {
            distance_m: 5.0,
            fov_deg: 90.0,
            aim: Aim::Pelvis,
        };
        // 50 rows for 10 m.
        assert!((sensor.pixels_per_metre(Size::S50x30) - 5.0).abs() < 1e-5);
        assert!((sensor.pixels_per_metre(Size::S64x44) - 6.4).abs() < 1e-5);
    }

    #[test]
    fn what_cannot_be_drawn_is_refused() {
        let refusal = |change: &dyn Fn(&mut Settings)| {
            let mut settings = Settings::default();
            change(&mut settings);
            settings.check().map_err(|error| error.to_string())
        };
        assert_eq!(refusal(&|_| ()), Ok(()));
        let cycle = refusal(&|s| (s.framing, s.lens) = (FramingMode::Cycle, Lens::Persp));
        assert!(cycle.is_err_and(|text| text.contains("parallel rays")));
        for (framing, lens, is_drawn) in [
            (FramingMode::Cycle, Lens::Ortho, true),
            (FramingMode::Camera, Lens::Ortho, true),
            (FramingMode::Camera, Lens::Persp, false),
            (FramingMode::Height, Lens::Ortho, false),
            (FramingMode::Box, Lens::Ortho, false),
        ] {
            let columns = refusal(&|s| {
                (s.rasterizer, s.framing, s.lens) = (Raster::Columns, framing, lens);
            });
            assert_eq!(columns.is_ok(), is_drawn);
            assert!(is_drawn || columns.is_err_and(|text| text.contains("raster columns")));
        }
        let history = refusal(&|s| {
            (s.rasterizer, s.framing, s.template) =
                (Raster::Columns, FramingMode::Camera, Template::Mhi);
        });
        assert!(history.is_err_and(|text| text.ends_with("which makes a gei, not mhi")));
        for bad in [0.0, f64::NAN, 2e6] {
            assert!(refusal(&|s| s.sensor.distance_m = bad).is_err(), "{bad}");
        }
        for bad in [0.0, f64::NAN, 180.0] {
            assert!(refusal(&|s| s.sensor.fov_deg = bad).is_err(), "{bad}");
        }
        let nowhere = Aim::Point(Vec3::new(0.0, f32::INFINITY, 0.0));
        assert!(refusal(&|s| s.sensor.aim = nowhere).is_err());
    }
}
