//! The scene of a frame: hulls, camera and floor, for pictures of the scene itself.

use super::job_memory::JobMemory;
use super::posed_frames::PosedFrames;
use super::walker::Dressed;
use super::{Job, Moments, Settings, View, recording};
use crate::draw::confounders::Doses;
use crate::draw::confounders::image::Floor;
use crate::error::Result;
use crate::people::clothes::BodyPart;
use edgegait_core::body::Figure;
use edgegait_core::camera::Camera;
use edgegait_core::pack::Pack;
use glam::Vec3;

/// The kind of a hull in a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SceneHullKind {
    /// A part of the walker, its clothes or its loads.
    Worn(BodyPart),
    /// A part of the walker's shadow on the floor.
    Shadow,
    /// A part of an occluder between camera and walker.
    Occluder,
}

/// A convex hull of a scene.
#[derive(Clone, Debug)]
pub struct SceneHull {
    /// What it is.
    pub kind: SceneHullKind,
    /// Its points in the walker's space, metres.
    pub points: Vec<Vec3>,
}

/// The scene of one frame of a walk, before camera, lens and segmentation.
#[derive(Clone, Debug)]
pub struct Scene {
    /// All hulls of the scene.
    pub hulls: Vec<SceneHull>,
    /// The walker's hulls at the moments of the exposure, if there is motion blur.
    pub exposures: Vec<Vec<SceneHull>>,
    /// The camera that sees the scene.
    pub camera: Camera,
    /// The floor on which the walker walks.
    pub floor: Floor,
    /// The position of the pelvis, metres.
    pub pelvis: Vec3,
    /// The confounders that act on the scene.
    pub doses: Doses,
    /// The size in fine samples of one sample under a shorter lens, if framing hides the figure's
    /// size.
    pub coarseness: Option<f64>,
}

/// Returns the scene of one frame of a job's cycle.
///
/// # Errors
/// If there is no such walk, or it cannot be seen from the view.
pub fn scene(
    pack: &Pack<'_>,
    job: Job<'_>,
    view: &View,
    settings: Settings,
    frame: u32,
) -> Result<Scene> {
    let memory = &mut JobMemory::default();
    let mut dressed = Dressed::new(pack, job, settings.seed, memory)?;
    let mut posed = PosedFrames::new(pack, job, &mut dressed, settings, memory)?;
    posed.pose(Moments::Cycle, 0..settings.frames_per_cycle);
    posed.scene(frame as usize % posed.len(), view)
}

/// Returns the hulls of a figure, each with its kind.
fn worn(figure: &Figure<'_>, parts: &[BodyPart]) -> Vec<SceneHull> {
    let hulls = figure.hulls().zip(parts).map(|(points, &part)| SceneHull {
        kind: SceneHullKind::Worn(part),
        points: points.collect(),
    });
    hulls.collect()
}

impl PosedFrames<'_> {
    fn scene(&mut self, index: usize, view: &View) -> Result<Scene> {
        let parts = self.walker.parts();
        let framed_view = self.framed_view(view)?;
        let camera = self.render_view(index, &framed_view)?.camera;
        let (posed, extras) = (&self.frames[index], self.extras.get(index));
        let mut hulls = worn(&posed.figure, parts);
        let mut exposures = Vec::new();
        if let Some(extras) = extras {
            let all = |figure: &Figure<'_>, kind| -> Vec<SceneHull> {
                let hulls = figure.hulls().map(|points| SceneHull {
                    kind,
                    points: points.collect(),
                });
                hulls.collect()
            };
            if let Some(shadow) = extras.shadow() {
                hulls.extend(all(&shadow, SceneHullKind::Shadow));
            }
            for other in self.in_front(index, &framed_view) {
                hulls.extend(all(
                    &other.figure(self.walker.crossing()),
                    SceneHullKind::Occluder,
                ));
            }
            let exposed = extras.exposures.iter();
            exposures.extend(exposed.map(|figure| worn(figure, parts)));
        }
        Ok(Scene {
            hulls,
            exposures,
            camera,
            floor: self.walker.floor(posed.pelvis),
            pelvis: posed.pelvis,
            doses: self.plan.doses().clone(),
            coarseness: recording::coarseness(self.plan, self.settings.framing),
        })
    }
}
