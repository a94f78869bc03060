//! Reference GEIs of exact coverage, and the deviation of drawn GEIs from them.

use super::exact::{Exact, ExactRenderer};
use crate::draw::sweep::{Job, Moments, Settings, Shot, View, figures, silhouettes, walk_name};
use crate::error::{Result, SweepError};
use edgegait_core::pack::Pack;
use edgegait_core::silhouette::Silhouette;
use edgegait_core::template::GeiBuilder;
use rayon::prelude::*;

/// The number of frames of each cycle of a reference: a multiple of all numbers that are measured.
pub(crate) const REFERENCE_FRAMES: u32 = 128;

/// The cycles and viewpoints that are measured.
#[derive(Clone, Debug)]
pub(crate) struct ReferenceSample {
    /// The cycles.
    pub jobs: Vec<Job<'static>>,
    /// The viewpoints.
    pub views: Vec<View>,
}

impl ReferenceSample {
    /// Samples at most `most` of these walks and views, evenly spread; the cycles are the stored
    /// ones.
    #[must_use]
    pub(crate) fn spread(walks: &[usize], views: &[View], most: (usize, usize)) -> Self {
        let job = |walk| Job::plain(walk, 0);
        Self {
            jobs: spread(walks, most.0).into_iter().map(job).collect(),
            views: spread(views, most.1),
        }
    }
}

/// Returns at most `most` items of a list, evenly spread.
pub(crate) fn spread<T: Copy>(list: &[T], most: usize) -> Vec<T> {
    let kept = most.min(list.len());
    (0..kept).map(|i| list[i * list.len() / kept]).collect()
}

/// Exact GEIs: `[job][view][pixel]`, 0..=255.
pub(crate) type ExactGeis = Vec<Vec<Vec<f64>>>;

/// Draws the GEIs of exact coverage of each cycle in [`REFERENCE_FRAMES`] frames.
///
/// # Errors
/// If a figure cannot be drawn.
pub(crate) fn exact_geis(
    pack: &Pack<'_>,
    sample: &ReferenceSample,
    settings: Settings,
    progress: &(dyn Fn() -> Result<()> + Sync),
) -> Result<ExactGeis> {
    exact(pack, sample, settings, |frames| {
        progress()?;
        Ok(frames.into_iter().map(|frames| mean(&frames)).collect())
    })
}

/// The exact GEI and silhouettes of each cycle.
#[derive(Clone, Debug)]
pub(crate) struct Reference {
    /// The cycles, `[job][view]`.
    seen: Vec<Vec<ReferenceCycle>>,
}

#[derive(Clone, Debug)]
struct ReferenceCycle {
    gei: Vec<f64>,
    silhouettes: Vec<Silhouette>,
}

/// The deviation of drawn cycles from the reference.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Deviation {
    /// The root mean square difference of the GEIs' pixels, of 255.
    pub gei_rmse: f64,
    /// The mean Jaccard index of the silhouettes, 0..=1.
    pub jaccard: f64,
}

impl Reference {
    /// Draws the sample with exact coverage.
    ///
    /// # Errors
    /// If a figure cannot be drawn.
    pub(crate) fn new(
        pack: &Pack<'_>,
        sample: &ReferenceSample,
        settings: Settings,
        progress: &(dyn Fn() -> Result<()> + Sync),
    ) -> Result<Self> {
        let seen = exact(pack, sample, settings, |frames| {
            progress()?;
            let seen = |frames: Vec<Exact>| ReferenceCycle {
                gei: mean(&frames),
                silhouettes: frames.iter().map(Exact::silhouette).collect(),
            };
            Ok(frames.into_iter().map(seen).collect())
        })?;
        Ok(Self { seen })
    }

    /// Measures the deviation of the same sample of a pack with the same walks, drawn with
    /// `settings`. GEIs and silhouettes are not aligned: a shift by a column counts as an error.
    ///
    /// # Errors
    /// If a figure cannot be drawn, or if [`REFERENCE_FRAMES`] is not a multiple of the number of
    /// frames.
    pub(crate) fn deviation(
        &self,
        pack: &Pack<'_>,
        sample: &ReferenceSample,
        settings: Settings,
    ) -> Result<Deviation> {
        let frames = settings.frames_per_cycle;
        if !REFERENCE_FRAMES.is_multiple_of(frames) {
            return Err(SweepError::Frames {
                found: frames,
                of: REFERENCE_FRAMES,
            }
            .into());
        }
        let sums = (&sample.jobs, &self.seen)
            .into_par_iter()
            .map(|(&job, seen)| {
                let shot = Shot {
                    job,
                    moments: Moments::Cycle,
                    views: &sample.views,
                };
                let drawn = silhouettes(pack, shot, settings)?;
                let (mut squares, mut jaccard) = (0.0, 0.0);
                for (drawn, seen) in drawn.iter().zip(seen) {
                    let mut builder = GeiBuilder::new(settings.size);
                    let phases = seen
                        .silhouettes
                        .iter()
                        .step_by((REFERENCE_FRAMES / frames) as usize);
                    for (frame, expected) in drawn.iter().zip(phases) {
                        builder.add(frame)?;
                        jaccard += f64::from(frame.silhouette().jaccard(expected));
                    }
                    let gei = builder.gei();
                    let pixels = gei.pixels().iter().copied().map(f64::from);
                    squares += mean_square(pixels, &seen.gei);
                }
                Ok((squares, jaccard))
            });
        let sums: Vec<(f64, f64)> = sums.collect::<Result<_>>()?;
        let geis = (sample.jobs.len() * sample.views.len()) as f64;
        let sum = |of: fn(&(f64, f64)) -> f64| sums.iter().map(of).sum::<f64>();
        Ok(Deviation {
            gei_rmse: (sum(|s| s.0) / geis).sqrt(),
            jaccard: sum(|s| s.1) / (geis * f64::from(frames)),
        })
    }
}

/// Returns the root mean square difference of all pixels, of 255.
#[must_use]
pub(crate) fn rmse(some: &ExactGeis, others: &ExactGeis) -> f64 {
    let (some, others) = (some.iter().flatten(), others.iter().flatten());
    let squares = some
        .zip(others)
        .map(|(a, b)| mean_square(a.iter().copied(), b));
    let (sum, count) = squares.fold((0.0, 0.0), |(sum, count), s| (sum + s, count + 1.0));
    f64::sqrt(sum / count)
}

fn mean_square(found: impl Iterator<Item = f64>, expected: &[f64]) -> f64 {
    let squares = found.zip(expected).map(|(a, b)| (a - b) * (a - b));
    squares.sum::<f64>() / expected.len() as f64
}

/// Draws each job's frames from each view, and returns the results of `keep` for `[view][frame]`.
fn exact<T: Send>(
    pack: &Pack<'_>,
    sample: &ReferenceSample,
    settings: Settings,
    keep: impl Fn(Vec<Vec<Exact>>) -> Result<Vec<T>> + Sync,
) -> Result<Vec<Vec<T>>> {
    let settings = Settings {
        frames_per_cycle: REFERENCE_FRAMES,
        ..settings
    };
    let draw = |renderer: &mut ExactRenderer, &job: &Job<'_>| {
        let figures = figures(pack, job, Moments::Cycle, settings)?;
        let mut views = Vec::with_capacity(sample.views.len());
        for view in &sample.views {
            let frames = figures
                .iter()
                .map(|hulls| renderer.draw(hulls, view.viewpoint()));
            let frames: Result<Vec<Exact>> = frames.collect();
            views.push(frames.map_err(|error| SweepError::Undrawn {
                what: walk_name(pack, job.walk),
                cause: error.into(),
            })?);
        }
        keep(views)
    };
    let renderer = || ExactRenderer::new(settings.size);
    sample.jobs.par_iter().map_init(renderer, draw).collect()
}

/// Returns the mean of frames, 0..=255.
fn mean(frames: &[Exact]) -> Vec<f64> {
    let mut sums: Vec<f64> = Vec::new();
    for frame in frames {
        sums.resize(sums.len().max(frame.shares().count()), 0.0);
        for (sum, share) in sums.iter_mut().zip(frame.shares()) {
            *sum += share;
        }
    }
    for sum in &mut sums {
        *sum *= 255.0 / frames.len() as f64;
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::draw::sweep::Views;
    use crate::encode::encode_subjects;
    use crate::encode::within_error::configuration::{DrawConfiguration, drawings};
    use crate::people::cohort::{CohortOptions, subjects};

    #[test]
    fn a_spread_keeps_the_first_and_is_even() {
        assert_eq!(spread(&[0, 1, 2, 3, 4, 5, 6, 7], 4), [0, 2, 4, 6]);
        assert_eq!(spread(&[0, 1, 2], 5), [0, 1, 2]);
    }

    #[test]
    fn the_difference_of_geis_is_the_root_of_the_mean_square() {
        // Differences 3, 4, 0 and 5: (9 + 16 + 0 + 25) / 4 = 12.5.
        let some = vec![vec![vec![3.0, 10.0], vec![7.0, 0.0]]];
        let others = vec![vec![vec![0.0, 6.0], vec![7.0, 5.0]]];
        assert!((rmse(&some, &others) - 12.5f64.sqrt()).abs() < 1e-12);
    }

    #[test]
    fn more_frames_and_jitter_come_closer_to_exact_coverage() {
        let options = CohortOptions {
            people: 1,
            speeds_kmh: vec![5.0],
            ..CohortOptions::default()
        };
        let people = subjects(&options).expect("a person");
        let bytes = encode_subjects(&people, 5.0, &|| Ok(())).expect("a pack");
        let pack = Pack::parse(&bytes).expect("it was just encoded");
        let views = Views::grid("four", [0.0, 70.0], [0.0, 40.0]).expect("viewpoints");
        let sample = ReferenceSample::spread(&[0], &views.list, (1, 4));
        let reference = Reference::new(&pack, &sample, Settings::default(), &|| Ok(()));
        let reference = reference.expect("exact silhouettes");
        let of = |drawing: DrawConfiguration| {
            let settings = drawing.applied_to(Settings::default());
            let found = reference.deviation(&pack, &sample, settings);
            found.expect("drawn silhouettes")
        };
        for drawing in drawings() {
            let found = of(drawing);
            assert!(
                found.jaccard > 0.85 && found.jaccard < 1.0,
                "{drawing}: {found:?}"
            );
            assert!(
                found.gei_rmse > 0.1 && found.gei_rmse < 25.0,
                "{drawing}: {found:?}"
            );
        }
        let rmse = |frames_per_cycle| {
            of(DrawConfiguration {
                frames_per_cycle,
                ..DrawConfiguration::DEFAULT
            })
            .gei_rmse
        };
        assert!(
            [8, 16, 32, 64]
                .map(rmse)
                .is_sorted_by(|few, many| few > many)
        );
        let settings = Settings {
            frames_per_cycle: 24,
            ..Settings::default()
        };
        assert!(reference.deviation(&pack, &sample, settings).is_err());
    }
}
