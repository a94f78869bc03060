//! What there is to be seen of a frame, for pictures of the scene itself.

use super::posed_frames::Film;
use super::walker::Dressed;
use super::{Job, Moments, Settings, View, recording};
use crate::confounders::Doses;
use crate::confounders::image::Floor;
use crate::error::Result;
use crate::people::clothes::BodyPart;
use edgegait_core::body::Figure;
use edgegait_core::camera::Camera;
use edgegait_core::pack::Pack;
use glam::Vec3;

/// What a hull of a scene is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Thing {
    /// A part of the walker, and what it wears and carries.
    Worn(BodyPart),
    /// Of the walker's shadow on the floor.
    Shadow,
    /// Between camera and walker.
    Occluder,
}

/// Convex hulls, each as its points in the walker's space, metres.
pub type SceneHulls = Vec<(Thing, Vec<Vec3>)>;

/// One frame of a walk as it is before a camera, a lens and a segmentation take part.
#[derive(Clone, Debug)]
pub struct Scene {
    /// All hulls.
    pub hulls: SceneHulls,
    /// Those of the walker at moments of the exposure, if that blurs.
    pub exposures: Vec<SceneHulls>,
    /// From where it is seen.
    pub camera: Camera,
    /// What it is walked on.
    pub floor: Floor,
    /// Where the pelvis is, metres.
    pub pelvis: Vec3,
    /// What acts on it.
    pub doses: Doses,
    /// How many fine samples make one of a shorter lens, if one hides how large the figure is.
    pub coarseness: Option<f64>,
}

/// The scene of one frame of a job's cycle.
///
/// # Errors
/// When there is no such walk, or it cannot be seen so.
pub fn scene(
    pack: &Pack<'_>,
    job: Job<'_>,
    view: &View,
    settings: Settings,
    frame: u32,
) -> Result<Scene> {
    let dressed = Dressed::new(pack, job, settings.seed)?;
    let mut film = Film::new(pack, job, &dressed, settings)?;
    film.pose(Moments::Cycle, 0..settings.frames_per_cycle);
    film.scene(frame as usize % film.len(), view, dressed.parts())
}

/// The hulls of a figure, each of its part.
fn worn(figure: &Figure<'_>, parts: &[BodyPart]) -> SceneHulls {
    let hulls = figure.hulls().map(Iterator::collect);
    let things = parts.iter().map(|&part| Thing::Worn(part));
    things.zip(hulls).collect()
}

impl Film<'_> {
    fn scene(&mut self, index: usize, view: &View, parts: &[BodyPart]) -> Result<Scene> {
        let sight = self.sight(view)?;
        let camera = self.seen(index, &sight)?.camera;
        let (posed, extras) = (&self.frames[index], self.extras.get(index));
        let mut hulls = worn(&posed.figure, parts);
        let mut exposures = Vec::new();
        if let Some(extras) = extras {
            let all = |figure: &Figure<'_>, thing| -> SceneHulls {
                figure
                    .hulls()
                    .map(|points| (thing, points.collect()))
                    .collect()
            };
            if let Some(shadow) = extras.shadow() {
                hulls.extend(all(&shadow, Thing::Shadow));
            }
            for other in self.in_front(index, &sight) {
                hulls.extend(all(&other.figure(self.walker.crossing()), Thing::Occluder));
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
