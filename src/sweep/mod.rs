//! Many silhouettes at once: walks and cycles on all cores, seen from many viewpoints.
//!
//! A job is one cycle of one walk. Its frames are decoded and posed once and then seen
//! from every viewpoint. Results come in the jobs' order, whatever the number of threads.

mod columns;
mod film;
mod recording;
mod scene;
mod settings;
mod stage;
mod views;
mod walker;

pub use scene::{Hulls, Scene, Thing, scene};
pub use settings::{Aim, FRAMES_PER_CYCLE, Framing, Jitter, Lens, Raster, Sensor, Settings};
pub use views::{View, Views};
pub use walker::drawn;

use crate::confound::image::FineRenderer;
use crate::confound::{Condition, NORMAL};
use crate::error::{ChoiceError, Result, SweepError};
use crate::template::{Builder, Template};
use columns::Columns;
use edgegait_core::pack::Pack;
use edgegait_core::raster::{Rasterizer, Renderer};
use edgegait_core::silhouette::{Frame, Silhouette, Size};
use film::{Film, Sight};
use glam::Vec3;
use rayon::prelude::*;
use std::borrow::Cow;
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
pub fn jobs(
    pack: &Pack<'_>,
    walks: &[usize],
    variations: std::ops::Range<u32>,
) -> Result<Vec<Job<'static>>> {
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
    clip.is_some_and(|clip| clip.as_take().is_some())
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

/// The templates of one job, one for each view.
#[derive(Clone, Debug)]
pub struct Swept {
    /// In the order of the views: the bytes of each, as many as its shape has.
    pub templates: Vec<Vec<u8>>,
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
        (jobs, settings),
        seen,
        |job, _, swept| map(job, swept),
        sink,
    )
}

/// The same of jobs that are seen from views of their own, which `map` is given too.
///
/// # Errors
/// As [`sweep`], and as `views_of`.
pub fn sweep_each<'c, R: Send>(
    pack: &Pack<'_>,
    jobs: &[Job<'c>],
    views_of: impl Fn(Job<'c>) -> Result<Vec<View>> + Sync,
    settings: Settings,
    map: impl Fn(Job<'c>, &[View], Swept) -> Result<R> + Sync,
    sink: impl FnMut(Job<'c>, R) -> Result<()>,
) -> Result<()> {
    let seen = |job| {
        let views = views_of(job)?;
        let firsts = views::firsts(&views);
        Ok((Cow::Owned(views), Cow::Owned(firsts)))
    };
    sweep_from(pack, (jobs, settings), seen, map, sink)
}

/// Views, and for each of them the first one that is the same.
type Seeing<'v> = (Cow<'v, [View]>, Cow<'v, [usize]>);

fn sweep_from<'c, 'v, R: Send>(
    pack: &Pack<'_>,
    (jobs, settings): (&[Job<'c>], Settings),
    seen: impl Fn(Job<'c>) -> Result<Seeing<'v>> + Sync,
    map: impl Fn(Job<'c>, &[View], Swept) -> Result<R> + Sync,
    mut sink: impl FnMut(Job<'c>, R) -> Result<()>,
) -> Result<()> {
    settings.check()?;
    if (settings.rasterizer, settings.template) == (Raster::Columns, Template::Silhouettes) {
        return Err(ChoiceError::ColumnsSumFrames(Template::Silhouettes.name()).into());
    }
    let chunk = 2 * rayon::current_num_threads();
    for jobs in jobs.chunks(chunk.max(1)) {
        let results: Vec<Result<R>> = jobs
            .par_iter()
            .map_init(
                || Painter::new(&settings),
                |painter, &job| {
                    let dressed = Dressed::new(pack, job, settings.seed)?;
                    let mut film = Film::new(pack, job, &dressed, settings)?;
                    film.pose(Moments::Cycle, 0..settings.frames_per_cycle);
                    let (views, firsts) = seen(job)?;
                    map(job, &views, painter.sweep(&mut film, &views, &firsts)?)
                },
            )
            .collect();
        for (&job, result) in jobs.iter().zip(results) {
            sink(job, result?)?;
        }
    }
    Ok(())
}

/// Views whose templates are made at once: few enough for their sums to stay in a processor's
/// cache, and many enough for a figure to be worth fetching.
const VIEWS_AT_ONCE: usize = 16;

/// What draws, by one of the ways of [`Raster`].
enum Painter {
    Each(Box<Brush>, Vec<Builder>),
    Columns(Box<Columns>),
}

impl Painter {
    fn new(settings: &Settings) -> Self {
        match settings.rasterizer {
            Raster::Each(rasterizer) => {
                Self::Each(Box::new(Brush::new(rasterizer, settings.size)), Vec::new())
            }
            Raster::Columns => Self::Columns(Box::new(Columns::new(settings.size))),
        }
    }

    /// One job's templates; views that are the same are drawn once.
    fn sweep(&mut self, film: &mut Film<'_>, views: &[View], firsts: &[usize]) -> Result<Swept> {
        let drawn: Vec<usize> = (0..views.len()).filter(|&at| firsts[at] == at).collect();
        let seen = match self {
            Self::Each(brush, builders) => {
                let seen = see(film, views, &drawn, (brush, builders));
                if seen.is_err() {
                    // They hold a part of what could not be drawn.
                    builders.clear();
                }
                seen?
            }
            Self::Columns(columns) => columns.see(film, views, &drawn)?,
        };
        let seen = firsts.iter().filter_map(|&first| seen[first].as_ref());
        Ok(Swept {
            clipped: seen.clone().map(|seen| seen.clipped).sum(),
            empty: seen.clone().map(|seen| seen.empty).sum(),
            templates: seen.map(|seen| seen.template.clone()).collect(),
        })
    }

    /// One frame from one view.
    fn frame(&mut self, film: &Film<'_>, frame: usize, sight: Sight<'_>) -> Result<Frame> {
        match self {
            Self::Each(brush, _) => {
                let (frame, _) = brush.draw(film, frame, &sight)?;
                let size = film.size();
                Ok(frame.map_or_else(|| Frame::Binary(Silhouette::empty(size)), |frame| *frame))
            }
            Self::Columns(columns) => columns.frame(film, frame, sight),
        }
    }
}

/// What draws frames one by one.
struct Brush {
    renderer: Renderer,
    /// Of what is confounded before it is framed; made when it is needed.
    fine: Option<FineRenderer>,
    framed: Frame,
}

impl Brush {
    fn new(rasterizer: Rasterizer, size: Size) -> Self {
        Self {
            renderer: Renderer::new(rasterizer, size),
            fine: None,
            framed: Frame::Binary(Silhouette::empty(size)),
        }
    }

    /// One of the posed frames from several views: gives `take` the number of each view and what
    /// [`Self::draw`] makes there.
    fn draw_views(
        &mut self,
        film: &Film<'_>,
        frame: usize,
        sights: &[Sight<'_>],
        mut take: impl FnMut(usize, Option<&Frame>, f64) -> Result<()>,
    ) -> Result<()> {
        if !film.acts_on_images() {
            return film.draw_views(frame, sights, &mut self.renderer, |number, drawing| {
                let clipped = f64::from(drawing.clipped_share);
                take(number, Some(drawing.frame), clipped)
            });
        }
        for (number, sight) in sights.iter().enumerate() {
            let (drawn, clipped) = self.draw(film, frame, sight)?;
            take(number, drawn, clipped)?;
        }
        Ok(())
    }

    /// One of the posed frames, if anything is left of the figure, and the share of it outside
    /// of the image.
    fn draw(
        &mut self,
        film: &Film<'_>,
        frame: usize,
        sight: &Sight<'_>,
    ) -> Result<(Option<&Frame>, f64)> {
        if !film.acts_on_images() {
            let drawing = film.draw(frame, sight, &mut self.renderer)?;
            return Ok((Some(drawing.frame), f64::from(drawing.clipped_share)));
        }
        let fine = match &mut self.fine {
            Some(fine) => fine,
            none => none.insert(FineRenderer::new(
                self.renderer.rasterizer(),
                self.renderer.size(),
            )?),
        };
        let Some(framed) = film.segmented(frame, sight, fine)? else {
            return Ok((None, 0.0));
        };
        self.framed = Frame::Binary(framed.silhouette);
        Ok((Some(&self.framed), f64::from(framed.clipped_share)))
    }
}

/// A view's template.
#[derive(Clone, Debug, Default)]
struct Seen {
    template: Vec<u8>,
    /// Sum over the frames of the share that lay outside of the image.
    clipped: f64,
    /// Frames in which nothing was left of the figure.
    empty: u64,
}

/// The templates of the views of these numbers; none of the other views.
fn see(
    film: &mut Film<'_>,
    views: &[View],
    numbers: &[usize],
    (brush, builders): (&mut Brush, &mut Vec<Builder>),
) -> Result<Vec<Option<Seen>>> {
    let mut seen = vec![None; views.len()];
    while builders.len() < numbers.len().min(VIEWS_AT_ONCE) {
        builders.push(film.builder());
    }
    for batch in numbers.chunks(VIEWS_AT_ONCE) {
        let mut all = vec![Seen::default(); batch.len()];
        let sights: Vec<Sight<'_>> = batch
            .iter()
            .map(|&at| film.sight(&views[at]))
            .collect::<Result<_>>()?;
        for frame in 0..film.len() {
            brush.draw_views(film, frame, &sights, |number, drawn, clipped| {
                let seen = &mut all[number];
                seen.clipped += clipped;
                match drawn {
                    Some(frame) => builders[number].add(frame)?,
                    None => seen.empty += 1,
                }
                Ok(())
            })?;
        }
        for (&at, (builder, mut one)) in batch.iter().zip(builders.iter_mut().zip(all)) {
            one.template = builder.finish();
            seen[at] = Some(one);
        }
    }
    Ok(seen)
}

/// The figures of one cycle of a job: of each frame the points of each hull, metres.
///
/// # Errors
/// When there is no such walk or variation.
pub fn figures(pack: &Pack<'_>, job: Job<'_>, settings: Settings) -> Result<Vec<Vec<Vec<Vec3>>>> {
    let dressed = Dressed::new(pack, job, settings.seed)?;
    let mut film = Film::new(pack, job, &dressed, settings)?;
    film.pose(Moments::Cycle, 0..settings.frames_per_cycle);
    Ok(film.figures())
}

/// The frames of one shot from each view: `[view][frame]`.
///
/// # Errors
/// When a figure cannot be drawn.
pub fn silhouettes(pack: &Pack<'_>, shot: Shot<'_>, settings: Settings) -> Result<Vec<Vec<Frame>>> {
    settings.check()?;
    let dressed = Dressed::new(pack, shot.job, settings.seed)?;
    let mut film = Film::new(pack, shot.job, &dressed, settings)?;
    let mut painter = Painter::new(&settings);
    let firsts = views::firsts(shot.views);
    let frames = match shot.moments {
        Moments::Cycle => settings.frames_per_cycle,
        Moments::Seconds { frames, .. } => frames,
    };
    let step = if settings.needs_all_frames() {
        frames.max(1)
    } else {
        FRAMES_AT_ONCE
    };
    let mut all = vec![Vec::new(); shot.views.len()];
    for first in (0..frames).step_by(step as usize) {
        let end = frames.min(first.saturating_add(step));
        film.pose(shot.moments, first..end);
        for (at, view) in shot.views.iter().enumerate() {
            if firsts[at] < at {
                let known: Vec<Frame> = all[firsts[at]][all[at].len()..].to_vec();
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
