//! Sweeps: silhouettes and templates of many walks from many viewpoints, on all cores.
//!
//! A job is one cycle of one walk. Its frames are decoded and posed once, then rendered from every
//! viewpoint. Results come in the jobs' order, whatever the number of threads.

mod column_images;
mod columns;
mod confounded_frames;
mod drawing;
mod extras;
mod job_memory;
mod outputs;
mod painted_view;
mod posed_frames;
mod posed_walker;
mod recording;
mod scene_view;
mod settings;
mod views;
mod walker;

pub use outputs::{MAX_FRAMES, UNCUT_FPS, Wanted};
pub use scene_view::{Scene, SceneHull, SceneHullKind, scene};
pub use settings::{Aim, FRAMES_PER_CYCLE, FramingMode, Jitter, Lens, Raster, Sensor, Settings};
use views::ListedViews;
pub use views::{View, Views};
pub use walker::drawn;

use crate::draw::confounders::{Condition, ConfounderKind, NORMAL};
use crate::error::{Result, SweepError};
use drawing::Painter;
use edgegait_core::pack::Pack;
use edgegait_core::silhouette::AnySilhouette;
use glam::Vec3;
use job_memory::JobMemory;
use posed_frames::PosedFrames;
use std::collections::BTreeMap;
use std::ops::Range;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::{Mutex, mpsc};
use walker::Dressed;

/// Frames of an uncut motion that are posed together, if frames are independent: 9 MB.
const FRAMES_AT_ONCE: u32 = 1_024;

/// One cycle of one walk, under one condition.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Job<'c> {
    /// The number of the walk in its pack.
    pub walk: usize,
    /// The number of the variation of the stored cycle; 0 is the cycle itself.
    pub variation: u32,
    /// The condition of the walk, if there is one.
    pub condition: Option<&'c Condition>,
}

impl<'c> Job<'c> {
    /// Creates a job without a condition.
    #[must_use]
    pub const fn plain(walk: usize, variation: u32) -> Self {
        Self {
            walk,
            variation,
            condition: None,
        }
    }

    /// Returns the jobs under each of the conditions, or the jobs themselves without conditions.
    #[must_use]
    pub fn under(jobs: &[Self], conditions: &'c [Condition]) -> Vec<Self> {
        if conditions.is_empty() {
            return jobs.to_vec();
        }
        let under = |condition| {
            move |&job: &Self| Self {
                condition: Some(condition),
                ..job
            }
        };
        let each = conditions.iter().flat_map(|c| jobs.iter().map(under(c)));
        each.collect()
    }

    /// Returns the condition's name in results.
    #[must_use]
    pub fn condition_name(&self) -> &'c str {
        self.condition.map_or(NORMAL, |condition| &condition.name)
    }
}

/// Returns jobs for the same variations of each walk's cycle, walk by walk.
///
/// # Errors
/// If a walk is an uncut motion, which has no cycles; the error names the first such walk.
pub fn jobs(pack: &Pack<'_>, walks: &[usize], variations: Range<u32>) -> Result<Vec<Job<'static>>> {
    if let Some(take) = walks.iter().copied().find(|&walk| is_uncut(pack, walk)) {
        return Err(SweepError::UncutHasNoCycle(walk_name(pack, take)).into());
    }
    let of = |&walk: &usize| {
        variations
            .clone()
            .map(move |variation| Job::plain(walk, variation))
    };
    Ok(walks.iter().flat_map(of).collect())
}

/// Returns whether a walk is stored as an uncut motion, not as a cycle.
#[must_use]
pub fn is_uncut(pack: &Pack<'_>, walk: usize) -> bool {
    let clip = pack.walk(walk).and_then(|walk| pack.clip(walk.clip));
    clip.is_some_and(|clip| clip.as_uncut().is_some())
}

/// Returns a walk's number and name, for errors.
#[must_use]
pub fn walk_name(pack: &Pack<'_>, walk: usize) -> String {
    let name = pack.walk(walk).map_or("", |walk| walk.name);
    format!("walk {walk} ({name:?})")
}

/// The moments of a walk for which frames are drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Moments {
    /// One cycle: [`Settings::frames_per_cycle`] evenly spaced phases from 0 on.
    Cycle,
    /// Moments in seconds from the clip's first frame.
    Seconds {
        /// The first moment.
        start_s: f64,
        /// Frames a second.
        fps: f64,
        /// The number of frames.
        frames: u32,
    },
}

/// A job with the moments and views for which it is drawn.
#[derive(Clone, Copy, Debug)]
pub struct Shot<'a> {
    /// The walk and its cycle.
    pub job: Job<'a>,
    /// The moments of the frames.
    pub moments: Moments,
    /// The views from which the walker is seen.
    pub views: &'a [View],
}

/// The outputs of one job.
#[derive(Clone, Debug, Default)]
pub struct Swept {
    /// The bytes of each template, view by view, and for each view in the order of the request.
    /// A template has as many bytes as its shape; silhouettes have as many for each frame.
    pub templates: Vec<Vec<u8>>,
    /// The number of frames.
    pub frames: u32,
    /// The joint positions, metres, if requested: `[frames][19][3]`, f32, little-endian.
    pub joints: Vec<u8>,
    /// The joints in the images of each view, if requested: columns from the left and rows from the
    /// top, pixels, NaN in frames without a figure; `[frames][19][2]`, f32, little-endian.
    pub keypoints: Vec<Vec<u8>>,
    /// The sum over all frames and views of the share of the figure outside of the image.
    pub clipped: f64,
    /// The number of frames in which nothing was left of the figure, over all views. Templates
    /// leave these frames out.
    pub empty: u64,
}

/// How a sweep draws figures, and what it makes of them.
#[derive(Clone, Copy, Debug)]
pub struct DrawingRequest<'w> {
    /// How figures are drawn.
    pub settings: Settings,
    /// The outputs, which must include the settings' template.
    pub wanted: &'w Wanted,
}

impl DrawingRequest<'_> {
    fn check(&self) -> Result<()> {
        self.settings.check()?;
        self.wanted.check(&self.settings)
    }
}

/// Draws every job from every view. `map` runs on all cores and converts a job's templates;
/// `sink` takes the results one by one, in the jobs' order. For each thread, the templates of at
/// most two jobs are in memory at the same time.
///
/// # Errors
/// The first error, in job order, of `map`, of `sink`, or of drawing.
pub fn sweep<'c, R: Send>(
    pack: &Pack<'_>,
    jobs: &[Job<'c>],
    views: &[View],
    settings: Settings,
    map: impl Fn(Job<'c>, Swept) -> Result<R> + Sync,
    sink: impl FnMut(Job<'c>, R) -> Result<()>,
) -> Result<()> {
    let listed = ListedViews::new(views);
    let request = DrawingRequest {
        settings,
        wanted: &Wanted::one(settings.template),
    };
    let views_of = |_| Ok(listed.borrowed());
    let map = |job, _: &[View], swept| map(job, swept);
    sweep_from(pack, jobs, request, views_of, map, sink)
}

/// Draws each job from its own views, which `map` also receives, and makes all requested outputs.
///
/// # Errors
/// The errors of [`sweep`], of `views_of`, and of [`Wanted::check`].
pub fn sweep_each<'c, R: Send>(
    pack: &Pack<'_>,
    jobs: &[Job<'c>],
    views_of: impl Fn(Job<'c>) -> Result<Vec<View>> + Sync,
    request: DrawingRequest<'_>,
    map: impl Fn(Job<'c>, &[View], Swept) -> Result<R> + Sync,
    sink: impl FnMut(Job<'c>, R) -> Result<()>,
) -> Result<()> {
    let views_of = |job| Ok(ListedViews::new(views_of(job)?));
    sweep_from(pack, jobs, request, views_of, map, sink)
}

fn sweep_from<'c, 'v, R: Send>(
    pack: &Pack<'_>,
    jobs: &[Job<'c>],
    request: DrawingRequest<'_>,
    views_of: impl Fn(Job<'c>) -> Result<ListedViews<'v>> + Sync,
    map: impl Fn(Job<'c>, &[View], Swept) -> Result<R> + Sync,
    mut sink: impl FnMut(Job<'c>, R) -> Result<()>,
) -> Result<()> {
    request.check()?;
    let painters = Mutex::new(Vec::new());
    let draw = |job| {
        let spare = painters.lock().expect("nobody panics here").pop();
        let (mut painter, mut memory) = match spare {
            Some(kept) => kept,
            None => (Painter::new(&request.settings)?, JobMemory::default()),
        };
        let views = views_of(job)?;
        let swept = swept(pack, job, request, &views, &mut painter, &mut memory);
        let kept = (painter, memory);
        painters.lock().expect("nobody panics here").push(kept);
        map(job, views.list(), swept?)
    };
    let (draw, window) = (&draw, 2 * rayon::current_num_threads());
    let (done, finished) = mpsc::channel();
    rayon::in_place_scope_fifo(|scope| {
        let start = |index: usize| {
            let Some(&job) = jobs.get(index) else { return };
            let done = done.clone();
            scope.spawn_fifo(move |_| {
                let result = catch_unwind(AssertUnwindSafe(|| draw(job)));
                done.send((index, result)).ok();
            });
        };
        (0..window).for_each(start);
        let mut early = BTreeMap::new();
        for (index, &job) in jobs.iter().enumerate() {
            let result = loop {
                early.extend(finished.try_iter());
                if let Some(result) = early.remove(&index) {
                    break result;
                }
                // A thread of the pool draws a job instead of waiting.
                if rayon::yield_local() != Some(rayon::Yield::Executed) {
                    early.extend(finished.recv());
                }
            };
            start(index + window);
            sink(job, result.unwrap_or_else(|panic| resume_unwind(panic))?)?;
        }
        Ok(())
    })
}

/// A drawer that draws one job after another and keeps its buffers.
pub struct Drawer {
    painter: Painter,
    memory: JobMemory,
    settings: Settings,
    wanted: Wanted,
}

impl Drawer {
    /// Creates a drawer that makes the `wanted` outputs.
    ///
    /// # Errors
    /// The errors of [`Settings::check`] and [`Wanted::check`].
    pub fn new(settings: Settings, wanted: &Wanted) -> Result<Self> {
        DrawingRequest { settings, wanted }.check()?;
        Ok(Self {
            painter: Painter::new(&settings)?,
            memory: JobMemory::default(),
            settings,
            wanted: wanted.clone(),
        })
    }

    /// Makes the outputs of one job from these views.
    ///
    /// # Errors
    /// If the job cannot be drawn.
    pub fn draw(&mut self, pack: &Pack<'_>, job: Job<'_>, views: &[View]) -> Result<Swept> {
        let request = DrawingRequest {
            settings: self.settings,
            wanted: &self.wanted,
        };
        let views = ListedViews::new(views);
        let Self {
            painter, memory, ..
        } = self;
        swept(pack, job, request, &views, painter, memory)
    }
}

/// Makes the outputs of one job.
fn swept(
    pack: &Pack<'_>,
    job: Job<'_>,
    request: DrawingRequest<'_>,
    views: &ListedViews<'_>,
    painter: &mut Painter,
    memory: &mut JobMemory,
) -> Result<Swept> {
    let DrawingRequest { settings, wanted } = request;
    let (moments, settings) = wanted.moments(pack, job, settings)?;
    let mut dressed = Dressed::new(pack, job, settings.seed, memory)?;
    if wanted.joints
        && dressed
            .plan()
            .strength(ConfounderKind::RadialDistortion)
            .is_some()
    {
        return Err(SweepError::Undrawn {
            what: format!("condition {}", job.condition_name()),
            cause: "it distorts images, in which joint positions are unknown".into(),
        }
        .into());
    }
    let mut posed = PosedFrames::new(pack, job, &mut dressed, settings, memory)?;
    let frames = moments.count(settings.frames_per_cycle);
    let mut swept = Swept::default();
    for range in chunks(moments, &settings) {
        posed.pose(moments, range.clone());
        let part = painter.sweep(&mut posed, views, wanted)?;
        if range == (0..frames) {
            swept = part;
        } else {
            swept.append(part);
        }
    }
    posed.leave(memory);
    Ok(swept)
}

/// Returns the ranges of frames that are posed together. A cycle is one range, since its templates
/// need all frames.
fn chunks(moments: Moments, settings: &Settings) -> impl Iterator<Item = Range<u32>> {
    let frames = moments.count(settings.frames_per_cycle);
    let step = if moments == Moments::Cycle || settings.needs_all_frames() {
        frames.max(1)
    } else {
        FRAMES_AT_ONCE
    };
    let range = move |first: u32| first..frames.min(first.saturating_add(step));
    (0..frames).step_by(step as usize).map(range)
}

impl Swept {
    /// Appends the outputs of later frames of the same job.
    fn append(&mut self, later: Self) {
        self.clipped += later.clipped;
        self.empty += later.empty;
        self.frames += later.frames;
        self.joints.extend(later.joints);
        let more = |own: &mut Vec<Vec<u8>>, later: Vec<Vec<u8>>| {
            own.resize_with(later.len(), Vec::new);
            for (own, later) in own.iter_mut().zip(later) {
                own.extend(later);
            }
        };
        more(&mut self.templates, later.templates);
        more(&mut self.keypoints, later.keypoints);
    }
}

/// Returns the figures of a job at these moments: the points of each hull of each frame, metres.
///
/// # Errors
/// If there is no such walk or variation.
pub fn figures(
    pack: &Pack<'_>,
    job: Job<'_>,
    moments: Moments,
    settings: Settings,
) -> Result<Vec<Vec<Vec<Vec3>>>> {
    let memory = &mut JobMemory::default();
    let mut dressed = Dressed::new(pack, job, settings.seed, memory)?;
    let mut posed = PosedFrames::new(pack, job, &mut dressed, settings, memory)?;
    posed.pose(moments, 0..moments.count(settings.frames_per_cycle));
    Ok(posed.figures())
}

/// Draws the frames of one shot from each view: `[view][frame]`.
///
/// # Errors
/// If a figure cannot be drawn.
pub fn silhouettes(
    pack: &Pack<'_>,
    shot: Shot<'_>,
    settings: Settings,
) -> Result<Vec<Vec<AnySilhouette>>> {
    settings.check()?;
    let memory = &mut JobMemory::default();
    let mut dressed = Dressed::new(pack, shot.job, settings.seed, memory)?;
    let mut posed = PosedFrames::new(pack, shot.job, &mut dressed, settings, memory)?;
    let mut painter = Painter::new(&settings)?;
    let views = ListedViews::new(shot.views);
    let mut all = vec![Vec::new(); shot.views.len()];
    for range in chunks(shot.moments, &settings) {
        posed.pose(shot.moments, range);
        for (at, view) in shot.views.iter().enumerate() {
            let first = views.firsts()[at];
            if first < at {
                let known: Vec<AnySilhouette> = all[first][all[at].len()..].to_vec();
                all[at].extend(known);
                continue;
            }
            let framed_view = posed.framed_view(view)?;
            for frame in 0..posed.len() {
                all[at].push(painter.frame(&posed, frame, framed_view)?);
            }
        }
    }
    Ok(all)
}
