//! Confounders of recording: the choice of frames, and the camera.

use super::settings::{FramingMode, Lens, Raster, Settings};
use super::views::View;
use crate::draw::confounders::{ConfounderKind, DosePlan, Stage};
use crate::error::{Result, SettingError};
use edgegait_core::camera::Viewpoint;
use rand::RngExt as _;
use std::ops::Range;

/// The share of frames that remain at strength 1 of `frame-rate`.
const LEAST_RATE: f64 = 0.1;
/// The distance from the aim to the camera at strength 1 of `distance`, metres.
const NEAREST_M: f64 = 1.5;
/// The share of the focal length that remains at strength 1 of `focal-length`.
const LEAST_FOCAL_LENGTH: f64 = 0.25;

/// Returns the number of the frame, of `all`, that is shown for each of `frames`.
///
/// At a lower rate, each frame is repeated until the next one. A lost frame is replaced by the one
/// before it; lost frames at the start of the cycle by the last of the cycle.
pub(super) fn sources(plan: &DosePlan, frames: Range<u32>, all: u32) -> Vec<u32> {
    let kept = plan
        .strength(ConfounderKind::FrameRate)
        .map_or(all, |strength| {
            let share = 1.0 - (1.0 - LEAST_RATE) * strength;
            ((f64::from(all) * share).round() as u32).clamp(1, all.max(1))
        });
    let lost: Vec<bool> =
        plan.amount(ConfounderKind::DroppedFrames)
            .map_or(Vec::new(), |percent| {
                let mut rng = plan.of_cycle(ConfounderKind::DroppedFrames);
                (0..all).map(|_| rng.random_bool(percent / 100.0)).collect()
            });
    let is_lost = |frame: u32| lost.get(frame as usize).is_some_and(|is_lost| *is_lost);
    let (kept, all) = (u64::from(kept), u64::from(all));
    let shown = |frame: u32| {
        let before = (0..all).map(|back| ((u64::from(frame) + all - back) % all) as u32);
        let frame = before
            .clone()
            .find(|&frame| !is_lost(frame))
            .unwrap_or(frame);
        let slot = u64::from(frame) * kept / all;
        (slot * all).div_ceil(kept) as u32
    };
    frames.map(shown).collect()
}

/// Returns the settings under a condition. A camera that comes nearer has a perspective lens.
pub(super) fn settings(plan: &DosePlan, settings: Settings) -> Settings {
    let mut settings = settings;
    if let Some(strength) = plan.strength(ConfounderKind::Distance) {
        let far = match settings.lens {
            Lens::Ortho => 0.0,
            Lens::Persp => 1.0 / settings.sensor.distance_m,
        };
        let inverse = far + strength * (1.0 / NEAREST_M - far);
        if settings.framing == FramingMode::Camera && settings.lens == Lens::Ortho {
            // With parallel rays, the figure is as large as at the sensor's distance.
            let own = 1.0 / settings.sensor.distance_m;
            settings.sensor.distance_m = 1.0 / (own + strength * (1.0 / NEAREST_M - own));
        } else {
            settings.sensor.distance_m = 1.0 / inverse;
        }
        settings.lens = Lens::Persp;
    }
    if let (Some(left), FramingMode::Camera) = (focal_length(plan), settings.framing) {
        let half = libm::tan(0.5 * settings.sensor.fov_deg.to_radians()) / left;
        settings.sensor.fov_deg = 2.0 * libm::atan(half).to_degrees();
    }
    settings
}

/// Returns the remaining share of the focal length, if the condition changes it.
fn focal_length(plan: &DosePlan) -> Option<f64> {
    let strength = plan.strength(ConfounderKind::FocalLength)?;
    Some(libm::pow(LEAST_FOCAL_LENGTH, strength))
}

/// Returns the size in fine samples of one sample under a shorter lens, for a figure that fills
/// the image, or `None` where framing shows the figure's size.
pub(super) fn coarseness(plan: &DosePlan, framing: FramingMode) -> Option<f64> {
    let left = focal_length(plan).filter(|_| framing != FramingMode::Camera)?;
    Some(1.0 / left)
}

/// Returns whether confounders act on pictures after rendering, before framing.
pub(super) fn acts_on_images(plan: &DosePlan, framing: FramingMode) -> bool {
    plan.acts_at(Stage::Image) || coarseness(plan, framing).is_some()
}

/// Returns the viewpoint of a view under a condition.
///
/// # Errors
/// Never: azimuths are within a few turns, and elevations stop vertically above and below.
pub(super) fn viewpoint(plan: &DosePlan, view: &View) -> Result<Viewpoint> {
    if !plan.acts_at(Stage::Camera) {
        return Ok(view.viewpoint());
    }
    let degrees = |kind| plan.amount(kind).unwrap_or(0.0) as f32;
    let azimuth = view.azimuth_deg + degrees(ConfounderKind::Azimuth);
    let elevation = (view.elevation_deg + degrees(ConfounderKind::Elevation)).clamp(-90.0, 90.0);
    Ok(Viewpoint::from_degrees(azimuth, elevation)?.rolled(degrees(ConfounderKind::Roll)))
}

/// Checks that the rasteriser can draw under a condition.
///
/// # Errors
/// If it cannot, because it draws by columns or in grey; the error names rasteriser and condition.
pub(super) fn check(plan: &DosePlan, settings: &Settings) -> Result<()> {
    let refuse = |why| {
        let condition = plan.doses().to_string();
        let problem = SettingError::RasterUnderCondition { condition, why };
        Err(problem.refuses("raster", settings.rasterizer.name()))
    };
    match settings.rasterizer {
        Raster::Columns if plan.acts_at(Stage::Camera) => {
            refuse("moves the camera, which all elevations of an azimuth share")
        }
        raster if acts_on_images(plan, settings.framing) && !raster.is_binary() => {
            refuse("acts on segmented silhouettes, which are binary and drawn one by one")
        }
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::draw::confounders::Condition;
    use crate::draw::confounders::{Dose, Doses};
    use crate::people::variation::CycleSeed;

    fn plan(doses: &[(ConfounderKind, f64)]) -> DosePlan {
        let dose = |&(kind, strength): &(ConfounderKind, f64)| Dose { kind, strength };
        let of = CycleSeed {
            seed: 1,
            subject: 2,
            walk: 3,
            variation: 0,
        };
        DosePlan::new(
            Some(&Condition::from_doses(Doses::new(doses.iter().map(dose)))),
            of,
        )
    }

    #[test]
    fn at_a_lower_rate_each_frame_is_shown_until_the_next_one() {
        assert_eq!(sources(&plan(&[]), 0..4, 4), [0, 1, 2, 3]);
        // A tenth of 20 frames.
        let two = sources(&plan(&[(ConfounderKind::FrameRate, 1.0)]), 0..20, 20);
        assert_eq!(two, [[0; 10], [10; 10]].concat());
        // 1 - 0.9 x 0.5 of 8 frames is 4.4, rounded to 4.
        let four = sources(&plan(&[(ConfounderKind::FrameRate, 0.5)]), 0..8, 8);
        assert_eq!(four, [0, 0, 2, 2, 4, 4, 6, 6]);
        assert_eq!(
            sources(&plan(&[(ConfounderKind::FrameRate, 0.5)]), 5..8, 8),
            four[5..]
        );
    }

    #[test]
    fn a_lost_frame_is_the_one_before_it() {
        let shown = sources(
            &plan(&[(ConfounderKind::DroppedFrames, 1.0)]),
            0..1000,
            1000,
        );
        for (at, &source) in shown.iter().enumerate().skip(1) {
            let before = shown[at - 1];
            assert!(source as usize == at || source == before, "{at}: {source}");
        }
        let kept = shown
            .iter()
            .enumerate()
            .filter(|(at, source)| *at == **source as usize);
        // A tenth of 1,000, with a standard deviation of 9.5.
        assert!((60..=140).contains(&kept.count()));
        // If all frames are lost, each shows itself.
        assert_eq!(
            sources(&plan(&[(ConfounderKind::DroppedFrames, 1.0)]), 0..1, 1),
            [0]
        );
    }

    #[test]
    fn the_camera_comes_as_near_as_is_said() {
        let drawn = |doses: &[(ConfounderKind, f64)], framing, lens| {
            let settings = Settings {
                framing,
                lens,
                ..Settings::default()
            };
            super::settings(&plan(doses), settings)
        };
        let distance = |strength, lens| {
            let drawn = drawn(
                &[(ConfounderKind::Distance, strength)],
                FramingMode::Height,
                lens,
            );
            assert_eq!(drawn.lens, Lens::Persp);
            drawn.sensor.distance_m
        };
        assert!((distance(1.0, Lens::Ortho) - 1.5).abs() < 1e-12);
        assert!((distance(0.5, Lens::Ortho) - 3.0).abs() < 1e-12);
        // Between the sensor's 4 m and 1.5 m: the mean of the inverses.
        assert!((distance(0.5, Lens::Persp) - 24.0 / 11.0).abs() < 1e-12);
        // A quarter of the focal length shows four times as many metres.
        let wide = drawn(
            &[(ConfounderKind::FocalLength, 1.0)],
            FramingMode::Camera,
            Lens::Persp,
        );
        let ratio = Settings::default().sensor.pixels_per_metre(wide.size)
            / wide.sensor.pixels_per_metre(wide.size);
        assert!((ratio - 4.0).abs() < 1e-5);
        let coarse = coarseness(
            &plan(&[(ConfounderKind::FocalLength, 0.5)]),
            FramingMode::Height,
        );
        assert!(coarse.is_some_and(|cells| (cells - 2.0).abs() < 1e-12));
    }

    #[test]
    fn a_view_is_turned_and_stops_straight_above() {
        let view = View::new(90.0, 80.0).expect("a viewpoint");
        let seen =
            |doses: &[(ConfounderKind, f64)]| viewpoint(&plan(doses), &view).expect("a viewpoint");
        let from =
            |azimuth, elevation| Viewpoint::from_degrees(azimuth, elevation).expect("a viewpoint");
        assert_eq!(seen(&[]), view.viewpoint());
        assert_eq!(seen(&[(ConfounderKind::Azimuth, -0.5)]), from(75.0, 80.0));
        assert_eq!(seen(&[(ConfounderKind::Elevation, 1.0)]), from(90.0, 90.0));
        assert_eq!(
            seen(&[(ConfounderKind::Roll, 0.25)]),
            from(90.0, 80.0).rolled(5.0)
        );
    }
}
