//! Many silhouettes at once: walks and cycles on all cores, seen from many viewpoints.
//!
//! A job is one cycle of one walk. Its frames are decoded and posed once and then seen
//! from every viewpoint. Results come in the jobs' order, whatever the number of threads.

mod column_images;
mod columns;
mod confounded_frames;
mod drawing;
mod extras;
mod outputs;
mod painted_view;
mod posed_frames;
mod recording;
mod scene_view;
mod settings;
mod views;
mod walker;

pub use outputs::{MAX_FRAMES, TAKE_FPS, Wanted};
pub use scene_view::{Scene, SceneHulls, Thing, scene};
pub use settings::{Aim, FRAMES_PER_CYCLE, FramingMode, Jitter, Lens, Raster, Sensor, Settings};
pub use views::{View, Views};
pub use walker::drawn;

use crate::confounders::{Condition, ConfounderKind, NORMAL};
use crate::error::{Result, SweepError};
use drawing::Painter;
use edgegait_core::pack::Pack;
use edgegait_core::silhouette::AnySilhouette;
use glam::Vec3;
use posed_frames::Film;
use rayon::prelude::*;
use std::borrow::Cow;
use std::ops::Range;
use walker::Dressed;

/// Frames of a take that are posed at once, where they do not depend on others: 9 MB.
const FRAMES_AT_ONCE: u32 = 1_024;

/// One cycle of one walk, under one condition.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Job<'c> {
    /// Number of the walk in its pack.
    pub walk: usize,
    /// Which variation of the stored cycle; 0 is the cycle itself.
    pub variation: u32,
    /// What acts on it, if anything does.
    pub condition: Option<&'c Condition>,
}

impl<'c> Job<'c> {
    /// A cycle on which nothing acts.
    #[must_use]
    pub const fn plain(walk: usize, variation: u32) -> Self {
        Self {
            walk,
            variation,
            condition: None,
        }
    }

    /// The same cycles under each of the conditions; as they are without any.
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

    /// What results call its condition.
    #[must_use]
    pub fn condition_name(&self) -> &'c str {
        self.condition.map_or(NORMAL, |condition| &condition.name)
    }
}

/// The same variations of each walk's cycle, walk by walk.
///
/// # Errors
/// Naming the first walk that is a take: it has no cycles.
pub fn jobs(pack: &Pack<'_>, walks: &[usize], variations: Range<u32>) -> Result<Vec<Job<'static>>> {
    if let Some(take) = walks.iter().copied().find(|&walk| is_take(pack, walk)) {
        return Err(SweepError::TakeHasNoCycle(walk_name(pack, take)).into());
    }
    let of = |&walk: &usize| {
        variations
            .clone()
            .map(move |variation| Job::plain(walk, variation))
    };
    Ok(walks.iter().flat_map(of).collect())
}

/// Whether a walk is stored as a take, not as a cycle.
#[must_use]
pub fn is_take(pack: &Pack<'_>, walk: usize) -> bool {
    let clip = pack.walk(walk).and_then(|walk| pack.clip(walk.clip));
    clip.is_some_and(|clip| clip.as_uncut().is_some())
}

/// A walk's number and name, for errors.
#[must_use]
pub fn walk_name(pack: &Pack<'_>, walk: usize) -> String {
    let name = pack.walk(walk).map_or("", |walk| walk.name);
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
    pub job: Job<'a>,
    /// When.
    pub moments: Moments,
    /// From where.
    pub views: &'a [View],
}

/// What was made of one job.
#[derive(Clone, Debug, Default)]
pub struct Swept {
    /// In the order of the views, and of each view in the order in which they are wanted: the bytes
    /// of each template, as many as its shape has, and of silhouettes that for each frame.
    pub templates: Vec<Vec<u8>>,
    /// How many frames there were.
    pub frames: u32,
    /// Where the joints are, metres, if that is wanted: `[frames][19][3]`, f32, little-endian.
    pub joints: Vec<u8>,
    /// Of each view where the joints appear, if that is wanted: columns from the left and rows from
    /// the top, pixels, of frames without a figure no numbers; `[frames][19][2]`, f32,
    /// little-endian.
    pub keypoints: Vec<Vec<u8>>,
    /// Sum over all frames and views of the share that lay outside of the image.
    pub clipped: f64,
    /// Frames in which nothing was left of the figure, over all views: no template has them.
    pub empty: u64,
}

/// Sees every job from every view. `map` runs on all cores and turns a job's templates into
/// what is wanted of them; `sink` takes the results one by one, in the jobs' order.
/// At most two jobs' templates for each thread are alive at once.
///
/// # Errors
/// The first, in job order, of `map`'s, `sink`'s, and of what could not be drawn.
pub fn sweep<'c, R: Send>(
    pack: &Pack<'_>,
    jobs: &[Job<'c>],
    views: &[View],
    settings: Settings,
    map: impl Fn(Job<'c>, Swept) -> Result<R> + Sync,
    sink: impl FnMut(Job<'c>, R) -> Result<()>,
) -> Result<()> {
    let firsts = views::firsts(views);
    let seen = |_| Ok((Cow::Borrowed(views), Cow::Borrowed(&firsts[..])));
    sweep_from(
        pack,
        jobs,
        (settings, &Wanted::one(settings.template)),
        seen,
        |job, _, swept| map(job, swept),
        sink,
    )
}

/// The same of jobs that are seen from views of their own, which `map` is given too, and of which
/// more than a template may be `wanted`; the settings' is one of those.
///
/// # Errors
/// As [`sweep`], as `views_of`, and as [`Wanted::check`].
pub fn sweep_each<'c, R: Send>(
    pack: &Pack<'_>,
    jobs: &[Job<'c>],
    views_of: impl Fn(Job<'c>) -> Result<Vec<View>> + Sync,
    (settings, wanted): (Settings, &Wanted),
    map: impl Fn(Job<'c>, &[View], Swept) -> Result<R> + Sync,
    sink: impl FnMut(Job<'c>, R) -> Result<()>,
) -> Result<()> {
    let seen = |job| {
        let views = views_of(job)?;
        let firsts = views::firsts(&views);
        Ok((Cow::Owned(views), Cow::Owned(firsts)))
    };
    sweep_from(pack, jobs, (settings, wanted), seen, map, sink)
}

/// Views, and for each of them the first one that is the same.
type Seeing<'v> = (Cow<'v, [View]>, Cow<'v, [usize]>);

fn sweep_from<'c, 'v, R: Send>(
    pack: &Pack<'_>,
    jobs: &[Job<'c>],
    (settings, wanted): (Settings, &Wanted),
    seen: impl Fn(Job<'c>) -> Result<Seeing<'v>> + Sync,
    map: impl Fn(Job<'c>, &[View], Swept) -> Result<R> + Sync,
    mut sink: impl FnMut(Job<'c>, R) -> Result<()>,
) -> Result<()> {
    settings.check()?;
    wanted.check(&settings)?;
    let chunk = 2 * rayon::current_num_threads();
    for jobs in jobs.chunks(chunk.max(1)) {
        let results: Vec<Result<R>> = jobs
            .par_iter()
            .map_init(
                || Painter::new(&settings),
                |painter, &job| {
                    let (views, firsts) = seen(job)?;
                    let sights = (&*views, &*firsts);
                    map(
                        job,
                        &views,
                        swept(pack, job, (settings, wanted), sights, painter)?,
                    )
                },
            )
            .collect();
        for (&job, result) in jobs.iter().zip(results) {
            sink(job, result?)?;
        }
    }
    Ok(())
}

/// Draws one job after another, with buffers that are kept.
pub struct Drawer {
    painter: Painter,
    settings: Settings,
    wanted: Wanted,
}

impl Drawer {
    /// One that makes what is `wanted`.
    ///
    /// # Errors
    /// As [`Settings::check`] and [`Wanted::check`].
    pub fn new(settings: Settings, wanted: &Wanted) -> Result<Self> {
        settings.check()?;
        wanted.check(&settings)?;
        Ok(Self {
            painter: Painter::new(&settings),
            settings,
            wanted: wanted.clone(),
        })
    }

    /// What is wanted of one job, seen from these views.
    ///
    /// # Errors
    /// When it cannot be drawn.
    pub fn draw(&mut self, pack: &Pack<'_>, job: Job<'_>, views: &[View]) -> Result<Swept> {
        let firsts = views::firsts(views);
        swept(
            pack,
            job,
            (self.settings, &self.wanted),
            (views, &firsts),
            &mut self.painter,
        )
    }
}

/// What is wanted of one job.
fn swept(
    pack: &Pack<'_>,
    job: Job<'_>,
    (settings, wanted): (Settings, &Wanted),
    sights: (&[View], &[usize]),
    painter: &mut Painter,
) -> Result<Swept> {
    let (moments, settings) = wanted.moments(pack, job, settings)?;
    let dressed = Dressed::new(pack, job, settings.seed)?;
    if wanted.joints
        && dressed
            .plan()
            .strength(ConfounderKind::RadialDistortion)
            .is_some()
    {
        return Err(SweepError::Undrawn {
            what: format!("condition {}", job.condition_name()),
            cause: "it distorts images, in which joints are not known".into(),
        }
        .into());
    }
    let mut film = Film::new(pack, job, &dressed, settings)?;
    let frames = moments.count(settings.frames_per_cycle);
    let mut swept = Swept::default();
    for range in chunks(moments, &settings) {
        film.pose(moments, range.clone());
        let part = painter.sweep(&mut film, sights, wanted)?;
        if range == (0..frames) {
            return Ok(part);
        }
        swept.append(part);
    }
    Ok(swept)
}

/// The frames of a job that are posed together, one range after another: all of a cycle, as its
/// templates need them.
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
    /// Adds what was made of later frames of the same job.
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

/// The figures of a job at these moments: of each frame the points of each hull, metres.
///
/// # Errors
/// When there is no such walk or variation.
pub fn figures(
    pack: &Pack<'_>,
    job: Job<'_>,
    moments: Moments,
    settings: Settings,
) -> Result<Vec<Vec<Vec<Vec3>>>> {
    let dressed = Dressed::new(pack, job, settings.seed)?;
    let mut film = Film::new(pack, job, &dressed, settings)?;
    film.pose(moments, 0..moments.count(settings.frames_per_cycle));
    Ok(film.figures())
}

/// The frames of one shot from each view: `[view][frame]`.
///
/// # Errors
/// When a figure cannot be drawn.
pub fn silhouettes(
    pack: &Pack<'_>,
    shot: Shot<'_>,
    settings: Settings,
) -> Result<Vec<Vec<AnySilhouette>>> {
    settings.check()?;
    let dressed = Dressed::new(pack, shot.job, settings.seed)?;
    let mut film = Film::new(pack, shot.job, &dressed, settings)?;
    let mut painter = Painter::new(&settings);
    let firsts = views::firsts(shot.views);
    let mut all = vec![Vec::new(); shot.views.len()];
    for range in chunks(shot.moments, &settings) {
        film.pose(shot.moments, range);
        for (at, view) in shot.views.iter().enumerate() {
            if firsts[at] < at {
                let known: Vec<AnySilhouette> = all[firsts[at]][all[at].len()..].to_vec();
                all[at].extend(known);
                continue;
            }
            let sight = film.sight(view)?;
            for frame in 0..film.len() {
                all[at].push(painter.frame(&film, frame, sight)?);
            }
        }
    }
    Ok(all)
}
