//! Galleries of walks of a pack: a walk under confounders, and a walk in every template.

use super::camera_effects::{faded, mean, pixelated, warped};
use super::camera_view::{DrawnFloor, HullKind as Colour, SceneShot, ShownHull, frame};
use super::labelled_sheet::{GalleryImage, GalleryRow, TemplateCell, gallery, template_sheet};
use crate::draw::confounders::image::straightened;
use crate::draw::confounders::{Condition, ConfounderKind};
use crate::draw::sweep::{
    Job, Moments, Scene, SceneHull, SceneHullKind, Settings, Shot, Swept, View, scene, silhouettes,
    sweep,
};
use crate::draw::template::{Template, TemplateShape};
use crate::error::Result;
use crate::people::clothes::BodyPart;
use edgegait_core::pack::Pack;
use glam::{DVec2, Vec3};
use image::RgbImage;

/// Width and height of the camera view, pixels.
const FRAME_PX: (u32, u32) = (104, 100);
/// Height of the camera view in metres, with an orthographic camera.
const FRAME_M: f32 = 2.3;
/// Number of blocks side by side.
const BLOCKS: usize = 4;
/// Number of templates side by side.
const TEMPLATE_COLUMNS: usize = 5;
/// The moment to show, as a share of the cycle: with legs apart and moving.
const MOMENT: f64 = 0.1;

/// Draws a row for each job and its condition: the camera view, the silhouette, and the template of
/// the cycle.
///
/// # Errors
/// If a figure cannot be rendered.
pub(crate) fn condition_gallery(
    pack: &Pack<'_>,
    jobs: &[Job<'_>],
    view: &View,
    settings: Settings,
) -> Result<RgbImage> {
    let mut rows = Vec::new();
    let has_several = jobs.iter().any(|job| job.walk != jobs[0].walk);
    let at = (MOMENT * f64::from(settings.frames_per_cycle)) as u32;
    for &job in jobs {
        let shot = Shot {
            job,
            moments: Moments::Cycle,
            views: std::slice::from_ref(view),
        };
        let frames = silhouettes(pack, shot, settings)?;
        let silhouette = frames[0][at as usize].to_coverage();
        let mut templates = Vec::new();
        let keep = |_: Job<'_>, swept: Swept| Ok(swept.templates);
        sweep(pack, &[job], shot.views, settings, keep, |_, made| {
            templates.extend(made);
            Ok(())
        })?;
        let columns = settings.size.columns();
        let raster = |bytes: Vec<u8>| GalleryImage { bytes, columns };
        rows.push(GalleryRow {
            label: label(pack, job, has_several),
            class: class(job.condition).to_owned(),
            frame: painted(&scene(pack, job, view, settings, at)?),
            silhouette: raster(silhouette.pixels().to_vec()),
            template: raster(templates.pop().unwrap_or_default()),
        });
    }
    let title = "what the camera sees, a silhouette, and the GEI of the cycle";
    gallery(title, &rows, BLOCKS)
}

/// Draws one walk in each of these templates, with their names.
///
/// # Errors
/// If there is no template.
pub(crate) fn template_gallery(
    made: &[(Template, Vec<u8>)],
    settings: Settings,
) -> Result<RgbImage> {
    let cell = |(template, bytes): &(Template, Vec<u8>)| {
        let (columns, numbers) = match template.shape(settings.size) {
            TemplateShape::Image { rows, columns, .. } => (columns, rows * columns),
            TemplateShape::Vector(numbers) => (1, numbers),
        };
        let plane = |plane: &[u8]| GalleryImage {
            bytes: plane.to_vec(),
            columns,
        };
        TemplateCell {
            label: template.plural().to_owned(),
            planes: bytes.chunks(numbers).map(plane).collect(),
        }
    };
    let cells: Vec<TemplateCell> = made.iter().map(cell).collect();
    template_sheet("one walk in each template", &cells, TEMPLATE_COLUMNS)
}

/// Returns the condition's name, with person and walk if there are several walks.
fn label(pack: &Pack<'_>, job: Job<'_>, has_several: bool) -> String {
    let condition = job.condition_name();
    let walk = pack.walk(job.walk);
    match walk.and_then(|walk| pack.subject(walk.subject).zip(Some(walk))) {
        Some((subject, walk)) if has_several => {
            format!("{}, {}, {condition}", subject.name, walk.name)
        }
        _ => condition.to_owned(),
    }
}

/// Returns the class of the condition's first confounder.
fn class(condition: Option<&Condition>) -> &'static str {
    let first = condition.and_then(|condition| condition.draws(0).first().copied());
    first.map_or("none", |draw| draw.kind.confounder().class.name())
}

/// Draws the picture of a scene, with the effects of lens and sensor.
fn painted(scene: &Scene) -> RgbImage {
    let aim = Vec3::new(scene.pelvis.x, 0.92, scene.pelvis.z);
    let window = SceneShot {
        camera: scene.camera,
        centre: aim,
        height_m: FRAME_M,
        floor: DrawnFloor {
            point: scene.floor.point,
            normal: scene.floor.normal,
        },
        size_px: FRAME_PX,
    };
    let exposures: Vec<RgbImage> = scene
        .exposures
        .iter()
        .map(|hulls| frame(&shown(hulls), &window))
        .collect();
    let mut picture = mean(&exposures).unwrap_or_else(|| frame(&shown(&scene.hulls), &window));
    // Pixels per fine sample: a figure of 1.7 m has 150 fine samples.
    let sample_px = f64::from(FRAME_PX.1) / f64::from(FRAME_M) * 1.7 / 150.0;
    for dose in scene.doses.list() {
        picture = match dose.kind {
            ConfounderKind::RadialDistortion => {
                let (width, height) = (f64::from(FRAME_PX.0), f64::from(FRAME_PX.1));
                let unit = height / f64::from(FRAME_M) * 1.7;
                warped(&picture, |[x, y]| {
                    let middle = DVec2::new(0.5 * width, 0.5 * height);
                    let place = (DVec2::new(x, y) - middle) / unit;
                    (straightened(place, dose.strength) * unit + middle).to_array()
                })
            }
            ConfounderKind::Resolution => {
                pixelated(&picture, sample_px * (1.0 + 14.0 * dose.strength))
            }
            ConfounderKind::Light => faded(
                &picture,
                1.0 - 0.5 * dose.strength,
                1.0 - 0.85 * dose.strength,
            ),
            _ => picture,
        };
    }
    match scene.coarseness {
        Some(cell) => pixelated(&picture, sample_px * cell),
        None => picture,
    }
}

fn shown(hulls: &[SceneHull]) -> Vec<ShownHull> {
    let colour = |kind| match kind {
        SceneHullKind::Worn(BodyPart::Body) => Colour::Body,
        SceneHullKind::Worn(BodyPart::Hair) => Colour::Hair,
        SceneHullKind::Worn(BodyPart::Garment) => Colour::Garment,
        SceneHullKind::Worn(BodyPart::Load) => Colour::Load,
        SceneHullKind::Shadow => Colour::Shadow,
        SceneHullKind::Occluder => Colour::Occluder,
    };
    let hull = |hull: &SceneHull| ShownHull {
        points: hull.points.clone(),
        kind: colour(hull.kind),
    };
    hulls.iter().map(hull).collect()
}
