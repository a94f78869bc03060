//! The choices between speed and error.

use crate::draw::sweep::{FRAMES_PER_CYCLE, Jitter, Raster, Settings};
use crate::encode::MAX_ERROR_MM;
use edgegait_core::budget::{MAX_POINTS, SKIA_HEAP_BYTES};
use edgegait_core::raster::Rasterizer;
use std::fmt;

/// The settings for encoding people.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Encoding {
    /// The greatest error of a walk, mm.
    pub track_error_mm: f64,
    /// The maximum number of points in all hulls of a body together.
    pub hull_points: usize,
}

impl Encoding {
    /// The default of `cohort` and `import`.
    pub(crate) const DEFAULT: Self = Self {
        track_error_mm: MAX_ERROR_MM,
        hull_points: MAX_POINTS,
    };
    /// The finest encoding of the format.
    pub(crate) const FINEST: Self = Self {
        track_error_mm: 0.0,
        hull_points: MAX_POINTS,
    };
}

impl fmt::Display for Encoding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} mm, ", self.track_error_mm)?;
        match self.hull_points {
            MAX_POINTS => f.write_str("all points"),
            points => write!(f, "{points} points"),
        }
    }
}

/// The settings for drawing cycles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct DrawConfiguration {
    /// The rasteriser.
    pub rasterizer: Rasterizer,
    /// The positions in pixels at which each frame is sampled.
    pub jitter: Jitter,
    /// The number of frames of each cycle.
    pub frames_per_cycle: u32,
}

impl DrawConfiguration {
    /// The default of `sweep`.
    pub(crate) const DEFAULT: Self = Self {
        rasterizer: Rasterizer::Skia,
        jitter: Jitter::None,
        frames_per_cycle: FRAMES_PER_CYCLE,
    };

    /// Returns `settings` with these values.
    #[must_use]
    pub(crate) const fn applied_to(self, settings: Settings) -> Settings {
        Settings {
            rasterizer: Raster::Each(self.rasterizer),
            jitter: self.jitter,
            frames_per_cycle: self.frames_per_cycle,
            ..settings
        }
    }

    /// Returns the most bytes of heap that the rasteriser holds while it draws.
    #[must_use]
    pub(crate) const fn heap_bytes(self) -> usize {
        if matches!(self.rasterizer, Rasterizer::SkiaAa) {
            SKIA_HEAP_BYTES
        } else {
            0
        }
    }
}

impl fmt::Display for DrawConfiguration {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.rasterizer)?;
        if self.jitter != Jitter::None {
            write!(f, " {}", self.jitter.name())?;
        }
        write!(f, ", {} frames", self.frames_per_cycle)
    }
}

/// The drawing and encoding settings of one point of the frontier.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Configuration {
    /// The settings for drawing cycles.
    pub drawing: DrawConfiguration,
    /// The settings for encoding people; `None` if a pack is used as it is stored.
    pub encoding: Option<Encoding>,
}

impl Configuration {
    /// Returns whether these are the default settings.
    #[must_use]
    pub(crate) fn is_default(&self) -> bool {
        self.drawing == DrawConfiguration::DEFAULT
            && self
                .encoding
                .is_none_or(|encoding| encoding == Encoding::DEFAULT)
    }
}

impl fmt::Display for Configuration {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.drawing)?;
        match self.encoding {
            Some(encoding) => write!(f, ", {encoding}"),
            None => Ok(()),
        }
    }
}

/// Returns the drawing settings that a pack is measured with: every rasteriser with and without
/// jitter, and with common numbers of frames.
pub(crate) fn drawings() -> impl Iterator<Item = DrawConfiguration> {
    let jitters = [Jitter::None, Jitter::R2];
    let all = Rasterizer::ALL.iter().flat_map(move |&rasterizer| {
        jitters.map(|jitter| {
            [8, 16, 32, 64].map(|frames_per_cycle| DrawConfiguration {
                rasterizer,
                jitter,
                frames_per_cycle,
            })
        })
    });
    all.flatten()
}

/// Returns the configurations for people who can be encoded again: the default, and those that
/// differ from it in one respect; other encodings also with the fastest rasteriser; and for each
/// rasteriser a fine, a medium and a coarse combination.
#[must_use]
pub(crate) fn configurations() -> Vec<Configuration> {
    let (drawing, encoding) = (DrawConfiguration::DEFAULT, Encoding::DEFAULT);
    let is_as_long = |other: &DrawConfiguration| other.frames_per_cycle == drawing.frames_per_cycle;
    let mut all = vec![(drawing, encoding)];
    all.extend(drawings().filter(is_as_long).map(|d| (d, encoding)));
    all.extend([8, 16, 64].map(|frames_per_cycle| {
        let drawing = DrawConfiguration {
            frames_per_cycle,
            ..drawing
        };
        (drawing, encoding)
    }));
    let fastest = DrawConfiguration {
        rasterizer: fastest(),
        ..drawing
    };
    for drawing in [drawing, fastest] {
        all.extend(other_encodings().map(|encoding| (drawing, encoding)));
    }
    for &rasterizer in Rasterizer::ALL {
        let combined = [
            (64, 1.0, MAX_POINTS),
            (64, 5.0, MAX_POINTS),
            (16, 10.0, 240),
        ];
        all.extend(
            combined.map(|(frames_per_cycle, track_error_mm, hull_points)| {
                let drawing = DrawConfiguration {
                    rasterizer,
                    jitter: Jitter::R2,
                    frames_per_cycle,
                };
                let encoding = Encoding {
                    track_error_mm,
                    hull_points,
                };
                (drawing, encoding)
            }),
        );
    }
    let mut distinct: Vec<Configuration> = Vec::new();
    for (drawing, encoding) in all {
        let configuration = Configuration {
            drawing,
            encoding: Some(encoding),
        };
        if !distinct.contains(&configuration) {
            distinct.push(configuration);
        }
    }
    distinct
}

/// Returns encodings that differ from the default in their error or in their hull points.
fn other_encodings() -> impl Iterator<Item = Encoding> {
    let errors = [1.0, 10.0, 20.0].map(|track_error_mm| Encoding {
        track_error_mm,
        ..Encoding::DEFAULT
    });
    let points = [160, 240, 320, 400].map(|hull_points| Encoding {
        hull_points,
        ..Encoding::DEFAULT
    });
    errors.into_iter().chain(points)
}

/// Returns the time of a complete silhouette at 50x30 in thousandths of that of `skia`: `cargo bench
/// --bench raster` on one core of a shared AMD EPYC (AVX-512) virtual machine, 2026-11-27, rounded.
pub(super) const fn silhouette_cost(rasterizer: Rasterizer) -> u32 {
    match rasterizer {
        Rasterizer::Skia => 1_000,
        Rasterizer::SkiaAa => 36_000,
        Rasterizer::Rows => 670,
        Rasterizer::Rows3x3 => 1_660,
        // Not measured, so tried last.
        _ => 100_000,
    }
}

/// Returns the rasteriser that costs least.
pub(super) fn fastest() -> Rasterizer {
    let all = Rasterizer::ALL.iter().copied();
    let least = all.min_by_key(|&rasterizer| silhouette_cost(rasterizer));
    least.unwrap_or(Rasterizer::Rows)
}

/// Returns the cost of a GEI in the unit of [`silhouette_cost`]. Jitter costs nothing.
pub(super) const fn gei_cost(drawing: DrawConfiguration) -> u32 {
    silhouette_cost(drawing.rasterizer) * drawing.frames_per_cycle
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_default_comes_first_and_each_axis_is_walked_along() {
        let all = configurations();
        assert!(all.len() >= 12, "{}", all.len());
        assert!(all[0].is_default() && !all[1..].iter().any(Configuration::is_default));
        let differs =
            |count: &dyn Fn(&Configuration) -> bool| all.iter().filter(|c| count(c)).count();
        let encoding = |c: &Configuration| c.encoding.expect("an encoding");
        for frames in [8, 16, 64] {
            assert!(differs(&|c| c.drawing.frames_per_cycle == frames) > 0);
        }
        for error in [1.0, 10.0, 20.0] {
            assert!(differs(&|c| encoding(c).track_error_mm == error) > 0);
        }
        for points in [160, 240, 320, 400] {
            assert!(differs(&|c| encoding(c).hull_points == points) > 0);
        }
        for &rasterizer in Rasterizer::ALL {
            assert!(differs(&|c| c.drawing.rasterizer == rasterizer) >= 2);
        }
    }

    #[test]
    fn a_configuration_is_named_by_what_it_is() {
        let default = Configuration {
            drawing: DrawConfiguration::DEFAULT,
            encoding: Some(Encoding::DEFAULT),
        };
        assert_eq!(default.to_string(), "skia, 32 frames, 5 mm, all points");
        let jittered = Configuration {
            drawing: DrawConfiguration {
                jitter: Jitter::R2,
                ..DrawConfiguration::DEFAULT
            },
            encoding: None,
        };
        assert_eq!(jittered.to_string(), "skia r2, 32 frames");
    }
}
