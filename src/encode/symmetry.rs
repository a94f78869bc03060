//! Symmetry of bodies: hulls that can be stored by their half within an error.

use super::hull::{StepPoint, StoredHull, image};
use crate::people::BodyHull;
use glam::DVec3;
use std::collections::BTreeSet;

/// A search for hulls that are symmetric or mirror images of each other.
pub(super) struct Halves<'a> {
    /// The body's hulls.
    pub hulls: &'a [BodyHull],
    /// The length of a step, metres.
    pub step_m: f64,
    /// The greatest error of a point, metres.
    pub max_error_m: f64,
}

impl<'a> Halves<'a> {
    /// Returns the hulls to store, and the body's hulls in the order of decoding.
    #[must_use]
    pub(super) fn stored_hulls(&self) -> (Vec<StoredHull>, Vec<&'a BodyHull>) {
        let mut stored: Vec<StoredHull> = self.hulls.iter().map(|hull| self.stored(hull)).collect();
        let mut images = vec![None; stored.len()];
        let mut is_image = vec![false; stored.len()];
        for left in 0..stored.len() {
            let found = (0..stored.len())
                .find(|&right| !is_image[right] && self.is_image(&stored[left], right));
            if let Some(right) = found {
                stored[left].is_mirrored = true;
                images[left] = Some(right);
                is_image[right] = true;
            }
        }
        let mut sources = Vec::new();
        let mut kept = Vec::new();
        for (index, hull) in stored.into_iter().enumerate() {
            if !is_image[index] {
                kept.push(hull);
                sources.push(&self.hulls[index]);
                sources.extend(images[index].map(|right| &self.hulls[right]));
            }
        }
        (kept, sources)
    }

    /// Returns a hull's points in steps, or half of them where that is enough.
    fn stored(&self, hull: &BodyHull) -> StoredHull {
        let whole = StoredHull {
            joint: hull.joint,
            is_mirrored: false,
            is_symmetric: false,
            points: self.rounded(hull),
        };
        let half = StoredHull {
            is_symmetric: true,
            points: whole.points.iter().copied().filter(|p| p[0] >= 0).collect(),
            ..whole
        };
        if self.is_good(&half.all_points(), hull) {
            half
        } else {
            whole
        }
    }

    /// Returns whether the mirror image of a left hull can stand for the right hull with this
    /// number.
    fn is_image(&self, left: &StoredHull, right: usize) -> bool {
        let right = &self.hulls[right];
        left.joint.is_left()
            && right.joint == left.joint.mirrored()
            && self.is_good(&left.all_points().into_iter().map(image).collect(), right)
    }

    /// Returns whether points are within the error of the hull, or as near as steps allow.
    fn is_good(&self, points: &BTreeSet<StepPoint>, hull: &BodyHull) -> bool {
        let error = |points: &BTreeSet<StepPoint>| {
            let found: Vec<DVec3> = points.iter().map(|&p| position(p, self.step_m)).collect();
            distance(&hull.points, &found)
        };
        // No more points than before, so that the body stays within the budget.
        points.len() <= hull.points.len()
            && error(points) <= self.max_error_m.max(error(&self.rounded(hull)))
    }

    fn rounded(&self, hull: &BodyHull) -> BTreeSet<StepPoint> {
        let points = hull.points.iter();
        points.map(|&point| counts(point, self.step_m)).collect()
    }
}

/// Returns the greatest distance from a point of one set to the nearest point of the other, in
/// either direction; infinite if one set is empty.
#[must_use]
pub(super) fn distance(some: &[DVec3], others: &[DVec3]) -> f64 {
    let one_way = |from: &[DVec3], to: &[DVec3]| {
        from.iter()
            .map(|&point| {
                to.iter()
                    .map(|&o| point.distance(o))
                    .fold(f64::INFINITY, f64::min)
            })
            .fold(0.0, f64::max)
    };
    one_way(some, others).max(one_way(others, some))
}

/// Returns a point in steps, rounded to nearest.
#[must_use]
pub(super) fn counts(point: DVec3, step_m: f64) -> StepPoint {
    #[expect(
        clippy::cast_possible_truncation,
        reason = "3.2 m in micrometres fit an i32"
    )]
    let rounded = (point / step_m)
        .to_array()
        .map(|steps| steps.round() as i32);
    rounded
}

/// Returns the position of a point in steps, metres.
#[must_use]
pub(super) fn position(count: StepPoint, step_m: f64) -> DVec3 {
    DVec3::from(count.map(f64::from)) * step_m
}
