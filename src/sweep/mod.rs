//! Many silhouettes at once: walks and cycles on all cores, seen from many viewpoints.
//!
//! A job is one cycle of one walk. Its frames are decoded and posed once and then seen
//! from every viewpoint. Results come in the jobs' order, whatever the number of threads.

mod views;

pub use views::{View, Views};

use crate::error::{Error, Result};
use crate::scene::variation::{CycleSeed, Variation};
use edgegait_core::avatar::{Avatar, PosedHulls};
use edgegait_core::camera::Camera;
use edgegait_core::clip::Clip;
use edgegait_core::format::crc32;
use edgegait_core::pack::Pack;
use edgegait_core::pose::ModelPose;
use edgegait_core::raster::{Rasterizer, Renderer};
use edgegait_core::silhouette::Frame;
use edgegait_core::skeleton::Skeleton;
use edgegait_core::template::{Gei, GeiBuilder};
use rayon::prelude::*;

/// Frames of a cycle, unless a user says otherwise. Ours: a GEI of 32 frames is 4.2 of 255
/// (root mean square) off one of 512, of 64 frames 2.2, of 16 frames 7.8 (two people, 20
/// viewpoints, `render --template gei --frames-per-cycle N`).
pub const FRAMES_PER_CYCLE: u32 = 32;

/// How a sweep draws.
#[derive(Clone, Copy, Debug)]
pub struct Settings {
    /// Which rasteriser.
    pub rasterizer: Rasterizer,
    /// Frames of each cycle.
    pub frames_per_cycle: u32,
    /// Seed of the cycles' variations.
    pub seed: u64,
}

/// One cycle of one walk.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Job {
    /// Number of the walk in its pack.
    pub walk: usize,
    /// Which variation of the stored cycle; 0 is the cycle itself.
    pub cycle: u32,
}

/// The same cycles of each walk, walk by walk.
///
/// # Errors
/// Naming the first walk that is a take: it has no cycles.
pub fn jobs(pack: &Pack<'_>, walks: &[usize], cycles: std::ops::Range<u32>) -> Result<Vec<Job>> {
    if let Some(take) = walks.iter().copied().find(|&walk| is_take(pack, walk)) {
        return Err(Error::Failed(format!(
            "{} is a whole take: a GEI needs a gait cycle (import it without --track clip, or choose others with --walks)",
            walk_name(pack, take)
        )));
    }
    let of = |&walk: &usize| cycles.clone().map(move |cycle| Job { walk, cycle });
    Ok(walks.iter().flat_map(of).collect())
}

/// Whether a walk is stored as a take, not as a cycle.
#[must_use]
pub fn is_take(pack: &Pack<'_>, walk: usize) -> bool {
    let clip = pack.walks().nth(walk).and_then(|walk| pack.clip(walk.clip));
    clip.is_some_and(|clip| clip.as_take().is_some())
}

/// A walk's number and name, for errors.
#[must_use]
pub fn walk_name(pack: &Pack<'_>, walk: usize) -> String {
    let name = pack.walks().nth(walk).map_or("", |walk| walk.name);
    format!("walk {walk} ({name:?})")
}

/// The moments at which a walk is seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Moments {
    /// One cycle, evenly: [`Settings::frames_per_cycle`] phases from 0 on.
    Cycle,
    /// Seconds from the clip's first frame.
    Seconds {
        /// The first moment.
        start_s: f64,
        /// Frames a second.
        fps: f64,
        /// How many.
        frames: u32,
    },
}

/// What is seen of one job.
#[derive(Clone, Copy, Debug)]
pub struct Shot<'a> {
    /// Which walk, and which of its cycles.
    pub job: Job,
    /// When.
    pub moments: Moments,
    /// From where.
    pub views: &'a [View],
}

/// The GEIs of one job, one for each view.
#[derive(Clone, Debug)]
pub struct Swept {
    /// In the order of the views.
    pub geis: Vec<Gei>,
    /// Sum over all frames and views of the share that lay outside of the 30 columns.
    pub clipped: f64,
}

/// Sees every job from every view. `map` runs on all cores and turns a job's GEIs into
/// what is wanted of them; `sink` takes the results one by one, in the jobs' order.
/// At most two jobs' GEIs for each thread are alive at once.
///
/// # Errors
/// The first, in job order, of `map`'s, `sink`'s, and of what could not be drawn.
pub fn sweep<R: Send>(
    pack: &Pack<'_>,
    jobs: &[Job],
    views: &[View],
    settings: Settings,
    map: impl Fn(Job, Swept) -> Result<R> + Sync,
    mut sink: impl FnMut(Job, R) -> Result<()>,
) -> Result<()> {
    let chunk = 2 * rayon::current_num_threads();
    for jobs in jobs.chunks(chunk.max(1)) {
        let results: Vec<Result<R>> = jobs
            .par_iter()
            .map_init(
                || Renderer::new(settings.rasterizer),
                |renderer, &job| map(job, see(pack, job, views, settings, renderer)?),
            )
            .collect();
        for (&job, result) in jobs.iter().zip(results) {
            sink(job, result?)?;
        }
    }
    Ok(())
}

/// One job's GEIs.
fn see(
    pack: &Pack<'_>,
    job: Job,
    views: &[View],
    settings: Settings,
    renderer: &mut Renderer,
) -> Result<Swept> {
    let figures = Figures::new(pack, job, settings.seed)?;
    let posed: Vec<PosedHulls> = (0..settings.frames_per_cycle)
        .map(|frame| figures.at(moment(Moments::Cycle, settings, frame)))
        .collect();
    let mut swept = Swept {
        geis: Vec::with_capacity(views.len()),
        clipped: 0.0,
    };
    for view in views {
        let camera = Camera::orthographic(view.viewpoint());
        let mut builder = GeiBuilder::new();
        for figure in &posed {
            let drawing = renderer
                .draw(figure, &camera)
                .map_err(|error| drawing_error(pack, job, *view, &error))?;
            swept.clipped += f64::from(drawing.clipped_share);
            builder.add(&drawing.frame);
        }
        swept.geis.push(builder.finish());
    }
    Ok(swept)
}

/// The frames of one shot from each view: `[view][frame]`.
///
/// # Errors
/// When a figure cannot be drawn.
pub fn silhouettes(pack: &Pack<'_>, shot: Shot<'_>, settings: Settings) -> Result<Vec<Vec<Frame>>> {
    let figures = Figures::new(pack, shot.job, settings.seed)?;
    let mut renderer = Renderer::new(settings.rasterizer);
    let frames = match shot.moments {
        Moments::Cycle => settings.frames_per_cycle,
        Moments::Seconds { frames, .. } => frames,
    };
    let mut draw = |view: &View, frame: u32| {
        let figure = figures.at(moment(shot.moments, settings, frame));
        let drawing = renderer.draw(&figure, &Camera::orthographic(view.viewpoint()));
        drawing
            .map(|drawing| drawing.frame)
            .map_err(|error| drawing_error(pack, shot.job, *view, &error))
    };
    shot.views
        .iter()
        .map(|view| (0..frames).map(|frame| draw(view, frame)).collect())
        .collect()
}

/// A moment of a walk.
#[derive(Clone, Copy, Debug)]
enum Moment {
    /// In cycles.
    Phase(f32),
    /// From the clip's first frame.
    Seconds(f64),
}

/// The moment of a frame.
fn moment(moments: Moments, settings: Settings, frame: u32) -> Moment {
    match moments {
        #[expect(clippy::cast_precision_loss, reason = "frames of a cycle")]
        Moments::Cycle => Moment::Phase(frame as f32 / settings.frames_per_cycle as f32),
        Moments::Seconds { start_s, fps, .. } => Moment::Seconds(start_s + f64::from(frame) / fps),
    }
}

fn drawing_error(
    pack: &Pack<'_>,
    job: Job,
    view: View,
    error: &edgegait_core::raster::DrawError,
) -> Error {
    Error::Failed(format!(
        "{}, cycle {}, azimuth {} and elevation {} degrees: {error}",
        walk_name(pack, job.walk),
        job.cycle,
        view.azimuth_deg,
        view.elevation_deg
    ))
}

/// One job's figure at any moment.
struct Figures<'a> {
    avatar: Avatar<'a>,
    skeleton: Skeleton,
    clip: Clip<'a>,
    variation: Variation,
}

impl<'a> Figures<'a> {
    fn new(pack: &Pack<'a>, job: Job, seed: u64) -> Result<Self> {
        let walk = pack.walks().nth(job.walk);
        let subject = walk.and_then(|walk| pack.subject(walk.subject));
        let parts = walk.zip(subject).and_then(|(walk, subject)| {
            let (avatar, clip) = (pack.avatar(subject.avatar)?, pack.clip(walk.clip)?);
            Some((walk, subject, avatar, clip))
        });
        let Some((walk, subject, avatar, clip)) = parts else {
            return Err(Error::Failed(format!(
                "there is no walk {}: expected a number below {}",
                job.walk,
                pack.walks().len()
            )));
        };
        if job.cycle > 0 && clip.as_take().is_some() {
            return Err(Error::Failed(format!(
                "{} is a whole take: it has no variations (leave out --cycle)",
                walk_name(pack, job.walk)
            )));
        }
        Ok(Self {
            skeleton: avatar.skeleton(),
            avatar,
            clip,
            variation: Variation::new(CycleSeed {
                seed,
                subject: u64::from(crc32(subject.name.as_bytes())),
                walk: u64::from(crc32(walk.name.as_bytes())) << 16 | u64::from(walk.cycle),
                cycle: job.cycle,
            }),
        })
    }

    /// The posed figure; a varied one keeps the stored cycle's clearance from the floor.
    fn at(&self, moment: Moment) -> PosedHulls {
        let duration_s = self.clip.duration_s();
        let (mut pose, phase) = match (moment, self.clip.as_loop()) {
            (Moment::Phase(phase), Some(cycle)) => (cycle.pose(phase), phase),
            (Moment::Phase(phase), None) => {
                (self.clip.sample(f64::from(phase) * duration_s), phase)
            }
            (Moment::Seconds(seconds), _) => {
                #[expect(clippy::cast_possible_truncation, reason = "a phase")]
                let phase = (seconds / duration_s).rem_euclid(1.0) as f32;
                (self.clip.sample(seconds), phase)
            }
        };
        let stored = self.posed(&pose);
        let before = pose.rotations;
        self.variation.apply(&mut pose, phase);
        if pose.rotations == before {
            return stored;
        }
        let lifted = lowest(&stored) - lowest(&self.posed(&pose));
        pose.root.y += lifted;
        self.posed(&pose)
    }

    fn posed(&self, pose: &edgegait_core::pose::Pose) -> PosedHulls {
        PosedHulls::new(&self.avatar, &ModelPose::new(&self.skeleton, pose))
    }
}

/// The height of a figure's lowest point, metres.
fn lowest(figure: &PosedHulls) -> f32 {
    figure.points().iter().map(|p| p.y).fold(f32::MAX, f32::min)
}
