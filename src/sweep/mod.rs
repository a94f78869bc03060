//! Many silhouettes at once: walks and cycles on all cores, seen from many viewpoints.
//!
//! A job is one cycle of one walk. Its frames are decoded and posed once and then seen
//! from every viewpoint. Results come in the jobs' order, whatever the number of threads.

mod columns;
mod film;
mod settings;
mod views;

pub use settings::{Aim, FRAMES_PER_CYCLE, Framing, Jitter, Lens, Raster, Sensor, Settings};
pub use views::{View, Views};

use crate::error::{Error, Result};
use columns::Columns;
use edgegait_core::pack::Pack;
use edgegait_core::raster::Renderer;
use edgegait_core::silhouette::Frame;
use edgegait_core::template::{Gei, GeiBuilder};
use film::{Film, Sight};
use glam::Vec3;
use rayon::prelude::*;

/// Frames of a take that are posed at once, where they do not depend on others: 9 MB.
const FRAMES_AT_ONCE: u32 = 1_024;

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
    /// Sum over all frames and views of the share that lay outside of the image.
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
    settings.check()?;
    let firsts = views::firsts(views);
    let chunk = 2 * rayon::current_num_threads();
    for jobs in jobs.chunks(chunk.max(1)) {
        let results: Vec<Result<R>> = jobs
            .par_iter()
            .map_init(
                || Painter::new(&settings),
                |painter, &job| {
                    let body = film::body(pack, job)?;
                    let mut film = Film::new(pack, job, &body, settings)?;
                    film.pose(Moments::Cycle, 0..settings.frames_per_cycle);
                    map(job, painter.sweep(&mut film, views, &firsts)?)
                },
            )
            .collect();
        for (&job, result) in jobs.iter().zip(results) {
            sink(job, result?)?;
        }
    }
    Ok(())
}

/// Views whose GEIs are summed at once: few enough for their sums to stay in a processor's
/// cache, and many enough for a figure to be worth fetching.
const VIEWS_AT_ONCE: usize = 16;

/// What draws, by one of the ways of [`Raster`].
enum Painter {
    Each(Box<Renderer>),
    Columns(Box<Columns>),
}

impl Painter {
    fn new(settings: &Settings) -> Self {
        match settings.rasterizer {
            Raster::Each(rasterizer) => {
                Self::Each(Box::new(Renderer::new(rasterizer, settings.size)))
            }
            Raster::Columns => Self::Columns(Box::new(Columns::new(settings.size))),
        }
    }

    /// One job's GEIs; views that are the same are drawn once.
    fn sweep(&mut self, film: &mut Film<'_>, views: &[View], firsts: &[usize]) -> Result<Swept> {
        let drawn: Vec<usize> = (0..views.len()).filter(|&at| firsts[at] == at).collect();
        let seen = match self {
            Self::Each(renderer) => see(film, views, &drawn, renderer)?,
            Self::Columns(columns) => columns.see(film, views, &drawn)?,
        };
        let seen = firsts.iter().filter_map(|&first| seen[first].as_ref());
        Ok(Swept {
            clipped: seen.clone().map(|(_, clipped)| clipped).sum(),
            geis: seen.map(|(gei, _)| *gei).collect(),
        })
    }

    /// One frame from one view.
    fn frame(&mut self, film: &Film<'_>, frame: usize, sight: Sight<'_>) -> Result<Frame> {
        match self {
            Self::Each(renderer) => Ok(*film.draw(frame, &sight, renderer)?.frame),
            Self::Columns(columns) => columns.frame(film, frame, sight),
        }
    }
}

/// The GEIs of the views of these numbers, and for each the sum over the frames of the share
/// that lay outside of the image; none of the other views.
fn see(
    film: &mut Film<'_>,
    views: &[View],
    numbers: &[usize],
    renderer: &mut Renderer,
) -> Result<Vec<Option<(Gei, f64)>>> {
    let mut seen = vec![None; views.len()];
    let mut sums = vec![(GeiBuilder::new(renderer.size()), 0.0); VIEWS_AT_ONCE];
    for batch in numbers.chunks(VIEWS_AT_ONCE) {
        let sights: Vec<_> = batch.iter().map(|&at| film.sight(&views[at])).collect();
        for frame in 0..film.len() {
            for (sight, (builder, clipped)) in sights.iter().zip(&mut sums) {
                let drawing = film.draw(frame, sight, renderer)?;
                *clipped += f64::from(drawing.clipped_share);
                builder.add(drawing.frame);
            }
        }
        for (&at, (builder, clipped)) in batch.iter().zip(&mut sums) {
            seen[at] = Some((builder.finish(), *clipped));
            (*builder, *clipped) = (GeiBuilder::new(renderer.size()), 0.0);
        }
    }
    Ok(seen)
}

/// The figures of one cycle of a job: of each frame the points of each hull, metres.
///
/// # Errors
/// When there is no such walk or variation.
pub fn figures(pack: &Pack<'_>, job: Job, settings: Settings) -> Result<Vec<Vec<Vec<Vec3>>>> {
    let body = film::body(pack, job)?;
    let mut film = Film::new(pack, job, &body, settings)?;
    film.pose(Moments::Cycle, 0..settings.frames_per_cycle);
    Ok(film.figures())
}

/// The frames of one shot from each view: `[view][frame]`.
///
/// # Errors
/// When a figure cannot be drawn.
pub fn silhouettes(pack: &Pack<'_>, shot: Shot<'_>, settings: Settings) -> Result<Vec<Vec<Frame>>> {
    settings.check()?;
    let body = film::body(pack, shot.job)?;
    let mut film = Film::new(pack, shot.job, &body, settings)?;
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
            let sight = film.sight(view);
            for frame in 0..film.len() {
                all[at].push(painter.frame(&film, frame, sight)?);
            }
        }
    }
    Ok(all)
}
