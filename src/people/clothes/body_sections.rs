//! Places and reaches of hulls in the rest pose, by which clothes are cut.
//!
//! At rest every joint's frame is parallel to the world, so that a point's place is its joint's
//! place plus the point.

use super::{BodyPart, Outfit, WornHull};
use edgegait_core::facets::Facets;
use edgegait_core::skeleton::{JOINTS, Joint, Skeleton};
use glam::{DVec2, DVec3, Vec3};
use std::ops::RangeInclusive;

/// Places of the joints at rest, metres; the pelvis is at the origin.
#[derive(Clone, Debug)]
pub(crate) struct RestJoints([DVec3; JOINTS]);

impl RestJoints {
    pub(crate) fn from_skeleton(skeleton: &Skeleton) -> Self {
        let mut places = [DVec3::ZERO; JOINTS];
        for joint in Joint::ALL {
            if let Some(parent) = joint.parent() {
                let offset = skeleton.offsets[joint.index()].as_dvec3();
                places[joint.index()] = places[parent.index()] + offset;
            }
        }
        Self(places)
    }

    /// Returns the place of a joint.
    pub(crate) const fn at(&self, joint: Joint) -> DVec3 {
        self.0[joint.index()]
    }

    /// Returns the place of a point.
    pub(crate) fn place(&self, (joint, point): (Joint, Vec3)) -> DVec3 {
        self.at(joint) + point.as_dvec3()
    }

    /// Returns a place as a point of a joint.
    pub(crate) fn hang(&self, joint: Joint, place: DVec3) -> (Joint, Vec3) {
        (joint, (place - self.at(joint)).as_vec3())
    }

    /// Returns the mean height of a pair of joints.
    pub(crate) fn height(&self, left: Joint) -> f64 {
        0.5 * (self.at(left).y + self.at(left.mirrored()).y)
    }

    /// Returns the slice between two heights of what each hull's points on `joints` span.
    pub(crate) fn slice(
        &self,
        outfit: &Outfit,
        joints: &[Joint],
        heights: RangeInclusive<f64>,
    ) -> BodySlice {
        let mut slice = BodySlice { points: Vec::new() };
        for hull in &outfit.hulls {
            let on = hull
                .points
                .iter()
                .filter(|(joint, _)| joints.contains(joint));
            let points: Vec<DVec3> = on.map(|&point| self.place(point)).collect();
            slice
                .points
                .extend(points.iter().filter(|point| heights.contains(&point.y)));
            for height in [*heights.start(), *heights.end()] {
                slice.points.extend(crossings(&points, height));
            }
        }
        slice
    }
}

/// Returns where the lines between points cross a height. These include the corners of the section
/// of the points' hull, and none is outside of it.
fn crossings(points: &[DVec3], height: f64) -> impl Iterator<Item = DVec3> {
    let pairs = points
        .iter()
        .flat_map(move |&a| points.iter().map(move |&b| (a, b)));
    pairs
        .filter(move |(a, b)| a.y < height && height < b.y)
        .map(move |(a, b)| a + (b - a) * ((height - a.y) / (b.y - a.y)))
}

/// Points of a body between two heights, and of its sections at both heights.
#[derive(Clone, Debug)]
pub(crate) struct BodySlice {
    points: Vec<DVec3>,
}

impl BodySlice {
    /// Returns whether the slice has no points.
    pub(crate) const fn is_empty(&self) -> bool {
        self.points.is_empty()
    }

    /// Returns the least and the greatest coordinates; zeros for an empty slice.
    pub(crate) fn bounds(&self) -> (DVec3, DVec3) {
        let all = || self.points.iter().copied();
        let min = all().reduce(DVec3::min).unwrap_or_default();
        let max = all().reduce(DVec3::max).unwrap_or_default();
        (min, max)
    }

    /// Returns the middle of the bounds.
    pub(crate) fn centre(&self) -> DVec3 {
        let (min, max) = self.bounds();
        0.5 * (min + max)
    }

    /// Returns how far the slice reaches from its centre in a horizontal direction (x, z).
    pub(crate) fn reach(&self, direction: DVec2) -> f64 {
        let centre = self.centre();
        let along =
            |point: &DVec3| (point.x - centre.x) * direction.x + (point.z - centre.z) * direction.y;
        self.points.iter().map(along).fold(0.0, f64::max)
    }
}

/// Moves the points of a hull outward, each by the metres that `amount` returns for it, and the
/// facets beside it by at least that; `along` scales the axes of the movement. Flat hulls and
/// inner points stay.
///
/// Each point moves along the mean normal of its adjacent facets, weighted by their angles there,
/// until the facet that turns away most has moved out by the amount, but by at most twice the
/// amount. The grown hull encloses the hull where no facet beside a corner faces away from the
/// corner's movement.
pub(crate) fn swell(
    hull: &mut WornHull,
    part: BodyPart,
    along: DVec3,
    amount: impl Fn((Joint, Vec3)) -> f64,
) {
    let places: Vec<Vec3> = hull.points.iter().map(|(_, point)| *point).collect();
    let mut normals = vec![Vec::new(); places.len()];
    for facet in &Facets::from_points(&places).facets {
        let corners = facet.corners.map(usize::from);
        let [a, b, c] = corners.map(|corner| places[corner].as_dvec3());
        let Some(normal) = (b - a).cross(c - a).try_normalize() else {
            continue;
        };
        for (corner, (at, sides)) in
            corners
                .into_iter()
                .zip([(a, [b, c]), (b, [c, a]), (c, [a, b])])
        {
            let [p, q] = sides.map(|side| (side - at).normalize_or_zero());
            let angle = libm::acos(p.dot(q).clamp(-1.0, 1.0));
            normals[corner].push((normal, angle));
        }
    }
    for (point, normals) in hull.points.iter_mut().zip(&normals) {
        let sum: DVec3 = normals.iter().map(|(normal, angle)| *normal * *angle).sum();
        let Some(outward) = sum.try_normalize() else {
            continue;
        };
        let turned = normals.iter().map(|(normal, _)| normal.dot(outward));
        let way = outward * (amount(*point) / turned.fold(1.0, f64::min).max(0.5));
        point.1 += (way * along).as_vec3();
    }
    hull.part = part;
}
