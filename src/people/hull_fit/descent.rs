//! The descent: moves hull points until silhouettes agree, and leaves out those that matter least.

use super::view::{FitCamera, TrainingView};
use super::{FittedHulls, PosedMesh, STEPS, Skinned, start};
use crate::error::{Error, Result};
use crate::people::BodyHull;
use edgegait_core::budget::MAX_HULL_POINTS;
use glam::Vec3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use std::f64::consts::TAU;

/// Images whose gains are summed up together, so that sums do not depend on threads.
const CHUNK: usize = 50;
/// Initial step of a point, metres.
const FIRST_STEP_M: f32 = 0.012;
/// The greatest step of a point, metres.
const MOST_STEP_M: f32 = 0.024;
/// Step below which a point is at rest, metres.
const LAST_STEP_M: f32 = 0.0008;
/// The minimum step of all points after some were left out, and before the last rounds, metres.
const SHAKE_M: [f32; 2] = [0.004, 0.006];
/// The maximum number of rounds over all points at the beginning, and at each number of points. Our
/// choice: three times as many add 0.0004 to the Jaccard index.
const ROUNDS: [usize; 2] = [8, 20];
/// Fewest points of a hull.
const FEWEST: usize = 4;
/// At most one in this many points is left out at a time.
const ONE_IN: usize = 60;

/// Hulls with a number of points, and how well they match.
#[derive(Clone, Debug)]
pub(super) struct Level {
    pub(super) hulls: Vec<BodyHull>,
    pub(super) points: usize,
    /// Mean Jaccard index over images that the fit did not see.
    pub(super) jaccard: f64,
}

/// The distance of a mesh's vertices from the origin, metres, from which on it is no figure. Our
/// choice.
const FARTHEST_M: f64 = 1e4;

/// Fits hulls with each number of points in `budgets`, most first, to `views` images, and measures
/// them on as many others.
///
/// # Errors
/// For a mesh without triangles.
pub(super) fn fit(
    skinned: &Skinned,
    examples: &[PosedMesh],
    budgets: &[usize],
    views: usize,
    seed: u64,
    progress: &(dyn Fn() -> Result<()> + Sync),
) -> Result<Vec<Level>> {
    if skinned.triangles.is_empty() {
        return Err(Error::Mesh("the mesh has no triangles".into()));
    }
    // Coordinates of all examples stay finite in 32 bits.
    let mut all = examples
        .iter()
        .chain([&skinned.rest])
        .flat_map(|it| &it.mesh);
    if let Some(far) = all.find(|vertex| vertex.is_nan() || vertex.length() >= FARTHEST_M) {
        return Err(Error::Mesh(format!(
            "expected a mesh within {FARTHEST_M} m, found a vertex at {far}"
        )));
    }
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut images = |examples: &[PosedMesh]| -> Vec<TrainingView> {
        let cameras: Vec<FitCamera> = (0..views).map(|_| camera(&mut rng)).collect();
        let shots = cameras.into_par_iter().enumerate();
        shots
            .map(|(index, camera)| {
                let example = &examples[index % examples.len()];
                TrainingView::new(example, &skinned.triangles, camera)
            })
            .collect()
    };
    let (seen, unseen) = examples.split_at(examples.len() / 2);
    let mut fit = HullDescent::new(images(seen), start::parts(skinned), seed);
    let mut unseen = images(unseen);
    let at_first = fit.parts.points();
    let least = budgets.last().copied().unwrap_or(at_first).min(at_first);
    let mut told = 0;
    // The first rounds take about as long as leaving out a third of the points.
    let share = |left_out: usize| {
        let all = 3 * (at_first - least).max(1);
        (STEPS * (all + 9 * left_out)).div_ceil(4 * all).min(STEPS)
    };
    let mut tell = |done: usize| -> Result<()> {
        (told..done).try_for_each(|_| progress())?;
        told = told.max(done);
        Ok(())
    };
    fit.descend(ROUNDS[0]);
    tell(share(0))?;
    let mut levels = Vec::new();
    for &budget in budgets {
        while fit.trim(budget) {
            fit.shake(SHAKE_M[0]);
            fit.descend(1);
            tell(share(at_first - fit.parts.points()))?;
        }
        fit.shake(SHAKE_M[1]);
        fit.descend(ROUNDS[1]);
        unseen.par_iter_mut().for_each(|view| view.put(&fit.parts));
        let sum: f64 = unseen.iter().map(TrainingView::jaccard).sum();
        levels.push(Level {
            hulls: fit.hulls(),
            points: fit.parts.points(),
            jaccard: sum / unseen.len() as f64,
        });
    }
    tell(STEPS)?;
    Ok(levels)
}

/// Returns a random camera: all around, more often level than from above, a quarter of them near.
fn camera(rng: &mut ChaCha8Rng) -> FitCamera {
    let height: f64 = rng.random();
    FitCamera {
        azimuth: rng.random::<f64>() * TAU,
        elevation: (height * height * 75.0).to_radians(),
        distance_m: rng.random_bool(0.25).then(|| rng.random_range(3.0..8.0)),
    }
}

/// Hulls over the images that they are fitted to.
struct HullDescent {
    views: Vec<TrainingView>,
    parts: FittedHulls,
    /// Step of each point of each hull, metres.
    steps: Vec<Vec<f32>>,
    rng: ChaCha8Rng,
}

impl HullDescent {
    fn new(mut views: Vec<TrainingView>, parts: FittedHulls, seed: u64) -> Self {
        let hulls = parts.hulls.iter();
        let steps = hulls.map(|hull| vec![FIRST_STEP_M; hull.points.len()]);
        let steps = steps.collect();
        views.par_iter_mut().for_each(|view| view.put(&parts));
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream(1);
        Self {
            views,
            parts,
            steps,
            rng,
        }
    }

    /// Raises all steps to at least this.
    fn shake(&mut self, step_m: f32) {
        for step in self.steps.iter_mut().flatten() {
            *step = step.max(step_m);
        }
    }

    /// Runs this many rounds, or fewer if all points come to rest.
    fn descend(&mut self, rounds: usize) {
        for _ in 0..rounds {
            let mut moves = false;
            for hull in 0..self.parts.hulls.len() {
                moves |= self.visit(hull);
            }
            if !moves {
                break;
            }
        }
    }

    /// Moves each point of a hull once; returns false if all are at rest.
    fn visit(&mut self, hull: usize) -> bool {
        let part = &mut self.parts.hulls[hull];
        let steps = &mut self.steps[hull];
        let joint = part.joint.index();
        if steps.iter().all(|step| *step < LAST_STEP_M) {
            return false;
        }
        self.views.par_iter_mut().for_each(|view| view.begin(hull));
        for (index, step) in steps.iter_mut().enumerate() {
            if *step < LAST_STEP_M {
                continue;
            }
            let now = part.points[index];
            let [a, b, c] = axes(&mut self.rng).map(|axis| axis * *step);
            let places = [now, now + a, now - a, now + b, now - b, now + c, now - c];
            let gains: Vec<[f64; 7]> = self
                .views
                .par_chunks_mut(CHUNK)
                .map(|views| {
                    let mut gains = [0.0; 7];
                    for view in views {
                        view.add_gains(hull, joint, index, &places, &mut gains);
                    }
                    gains
                })
                .collect();
            let total = |place: usize| gains.iter().map(|gains| gains[place]).sum::<f64>();
            // Ties go to the first place, so that a point does not move without a gain.
            let better = |best: usize, place: usize| {
                if total(place) > total(best) {
                    place
                } else {
                    best
                }
            };
            let best = (1..7).fold(0, better);
            if best == 0 {
                *step *= 0.5;
                continue;
            }
            *step = (*step * 1.3).min(MOST_STEP_M);
            part.points[index] = places[best];
            for view in &mut self.views {
                view.set(hull, joint, index, places[best]);
            }
        }
        self.views.par_iter_mut().for_each(|view| view.end(hull));
        true
    }

    /// Leaves out some of the points that matter least, at most one per hull, down to `budget` in
    /// all and to what the format allows for one hull; returns whether there were any.
    fn trim(&mut self, budget: usize) -> bool {
        let surplus = self.parts.points().saturating_sub(budget);
        let mut losses: Vec<(f64, usize, usize)> = Vec::new();
        for hull in 0..self.parts.hulls.len() {
            let count = self.parts.hulls[hull].points.len();
            if count <= FEWEST || (surplus == 0 && count <= MAX_HULL_POINTS) {
                continue;
            }
            let gains: Vec<Vec<f64>> = self
                .views
                .par_iter_mut()
                .map(|view| {
                    view.begin(hull);
                    let gains = (0..=count).map(|index| view.gain_without(hull, index));
                    let gains = gains.collect();
                    view.end(hull);
                    gains
                })
                .collect();
            let total = |index: usize| gains.iter().map(|gains| gains[index]).sum::<f64>();
            let losses_of = (0..count).map(|index| (total(count) - total(index), hull, index));
            losses.extend(losses_of.min_by(|a, b| a.0.total_cmp(&b.0)));
        }
        losses.sort_by(|a, b| a.0.total_cmp(&b.0));
        if surplus > 0 {
            losses.truncate(surplus.min(self.parts.points().div_ceil(ONE_IN)));
        }
        for &(_, hull, index) in &losses {
            self.parts.hulls[hull].points.remove(index);
            self.steps[hull].remove(index);
        }
        let parts = &self.parts;
        self.views.par_iter_mut().for_each(|view| view.put(parts));
        !losses.is_empty()
    }

    fn hulls(&self) -> Vec<BodyHull> {
        let hulls = self.parts.hulls.iter().map(|part| BodyHull {
            joint: part.joint,
            points: part.points.iter().map(|point| point.as_dvec3()).collect(),
        });
        hulls.collect()
    }
}

/// Returns three random perpendicular directions.
fn axes(rng: &mut ChaCha8Rng) -> [Vec3; 3] {
    let mut random = || Vec3::from_array(std::array::from_fn(|_| rng.random_range(-1.0..1.0)));
    let a = random().try_normalize().unwrap_or(Vec3::X);
    let other = random().reject_from_normalized(a).try_normalize();
    let b = other.unwrap_or_else(|| a.any_orthonormal_vector());
    [a, b, a.cross(b)]
}
