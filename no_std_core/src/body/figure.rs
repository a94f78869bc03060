//! A figure: a body in a pose.

use super::drape::DrapedSurface;
use super::plane::FigureHull;
use super::{HullCarrier, UnpackedBody, VectorLanes};
use crate::budget::{LANES, MAX_DRAPED_HULLS, MAX_HULL_POINTS, MAX_HULLS, MAX_POINTS};
use crate::pose::ModelPose;
use crate::skeleton::JOINTS;
use core::ops::Range;
use glam::{Mat3, Vec3};

/// A body in a pose, in the walker's space: computed once a frame, for all viewpoints. 20 kB, of
/// which 9 kB are for draped hulls.
#[derive(Clone, Debug)]
pub struct Figure<'a> {
    pub(super) body: &'a UnpackedBody,
    pub(crate) points: VectorLanes<MAX_POINTS>,
    /// The place of each hull's joint.
    pub(crate) places: JointPlaces,
    /// The surfaces of the draped hulls, in the order of the body's drapes.
    pub(super) surfaces: [DrapedSurface; MAX_DRAPED_HULLS],
}

/// The orientation and position of a joint in a pose.
#[derive(Clone, Copy, Debug)]
pub(crate) struct JointPlace {
    pub turn: Mat3,
    pub offset: Vec3,
}

impl JointPlace {
    pub fn at(joint: usize, pose: &ModelPose) -> Self {
        let joint = joint.min(JOINTS - 1);
        Self {
            turn: pose.orientations[joint],
            offset: pose.positions[joint],
        }
    }

    /// Converts a point from the joint's frame to the walker's space.
    #[inline]
    pub fn carry(&self, point: Vec3) -> Vec3 {
        self.turn * point + self.offset
    }

    /// Converts a direction from the walker's space to the joint's frame.
    #[inline]
    pub fn direction(&self, direction: Vec3) -> Vec3 {
        let Mat3 {
            x_axis,
            y_axis,
            z_axis,
        } = self.turn;
        Vec3::new(
            x_axis.dot(direction),
            y_axis.dot(direction),
            z_axis.dot(direction),
        )
    }

    /// Converts a point from the walker's space to the joint's frame.
    #[inline]
    pub fn point(&self, point: Vec3) -> Vec3 {
        self.direction(point - self.offset)
    }
}

/// The places of the hulls' joints in a pose, one a lane.
#[derive(Clone, Debug)]
pub(crate) struct JointPlaces {
    /// The axes of their frames: x, y and z of the first axis, then of the others.
    pub turns: [[f32; MAX_HULLS]; 9],
    pub offsets: [[f32; MAX_HULLS]; 3],
}

impl JointPlaces {
    /// All joints at the origin.
    const REST: Self = Self {
        turns: {
            let mut turns = [[0.0; MAX_HULLS]; 9];
            (turns[0], turns[4], turns[8]) = ([1.0; MAX_HULLS], [1.0; MAX_HULLS], [1.0; MAX_HULLS]);
            turns
        },
        offsets: [[0.0; MAX_HULLS]; 3],
    };

    /// Returns the place of one hull's joint.
    pub fn get(&self, hull: usize) -> JointPlace {
        let at = hull % MAX_HULLS;
        JointPlace {
            turn: Mat3::from_cols_array(&self.turns.each_ref().map(|lanes| lanes[at])),
            offset: Vec3::from(self.offsets.each_ref().map(|lanes| lanes[at])),
        }
    }

    /// Returns whether all joints are within this distance of the origin along each axis.
    pub fn is_within(&self, reach_m: f32) -> bool {
        let offsets = self.offsets.iter().flatten();
        offsets.fold(true, |all, offset| all & (offset.abs() <= reach_m))
    }

    fn set(&mut self, hull: usize, place: &JointPlace) {
        let turns = self.turns.iter_mut().zip(place.turn.to_cols_array());
        let offsets = self.offsets.iter_mut().zip(place.offset.to_array());
        for (lanes, value) in turns.chain(offsets) {
            if let Some(lane) = lanes.get_mut(hull) {
                *lane = value;
            }
        }
    }
}

impl<'a> Figure<'a> {
    /// Carries the hulls of `body` to where `pose` puts their joints.
    #[must_use]
    pub fn new(body: &'a UnpackedBody, pose: &ModelPose) -> Self {
        let mut figure = Self::unplaced(body);
        figure.update(pose);
        figure
    }

    /// Returns the hulls in the frames of their joints, as if all joints were at the origin.
    #[must_use]
    pub fn at_rest(body: &'a UnpackedBody) -> Self {
        let mut figure = Self::unplaced(body);
        let mut start = 0;
        for hull in &body.hulls {
            if let HullCarrier::Drape(drape) = hull.carrier {
                figure.wrap(drape, start..hull.points_end);
            }
            start = hull.points_end;
        }
        figure.fill_lanes();
        figure
    }

    fn unplaced(body: &'a UnpackedBody) -> Self {
        Self {
            body,
            points: body.points.clone(),
            places: JointPlaces::REST,
            surfaces: [const { DrapedSurface::NOTHING }; MAX_DRAPED_HULLS],
        }
    }

    /// Moves the hulls to another pose in place, for the next frame.
    pub fn update(&mut self, pose: &ModelPose) {
        let body = self.body;
        body.carry(pose, &mut self.points);
        let mut start = 0;
        for (number, hull) in body.hulls.iter().enumerate() {
            match hull.carrier {
                HullCarrier::Joint(joint) => self.places.set(number, &JointPlace::at(joint, pose)),
                HullCarrier::Drape(drape) => self.wrap(drape, start..hull.points_end),
            }
            start = hull.points_end;
        }
        self.fill_lanes();
    }

    /// Fills the last lanes with the last point, so that they do not enlarge the figure.
    fn fill_lanes(&mut self) {
        let len = self.len();
        if let Some(last) = len.checked_sub(1).and_then(|last| self.points.get(last)) {
            for index in len..len.next_multiple_of(LANES) {
                self.points.set(index, last);
            }
        }
    }

    /// Returns the number of points.
    #[must_use]
    pub fn len(&self) -> usize {
        self.body.hulls.last().map_or(0, |hull| hull.points_end)
    }

    /// Returns whether there are no points.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Returns all points, hull by hull, metres.
    pub fn points(&self) -> impl Iterator<Item = Vec3> + Clone {
        (0..self.len()).filter_map(|index| self.points.get(index))
    }

    /// Returns the points of each hull, metres.
    pub fn hulls(&self) -> impl Iterator<Item = impl Iterator<Item = Vec3> + Clone> {
        self.hull_parts()
            .map(|part| part.points.filter_map(|index| self.points.get(index)))
    }

    /// Returns the hulls with their surfaces.
    pub(crate) fn hull_parts(&self) -> impl Iterator<Item = FigureHull<'_>> {
        let body = self.body;
        let (mut points, mut facets, mut edges) = (0, 0, 0);
        body.hulls.iter().map(move |hull| {
            let own = points..hull.points_end;
            let part = match hull.carrier {
                HullCarrier::Joint(_) => FigureHull {
                    spokes: body.spokes.get(own.clone()).unwrap_or_default(),
                    points: own,
                    facets: body.facets.get(facets..hull.facets_end).unwrap_or_default(),
                    clearances: { body.clearances.get(facets..hull.facets_end) }
                        .unwrap_or_default(),
                    edges: body.edges.get(edges..hull.edges_end).unwrap_or_default(),
                },
                HullCarrier::Drape(drape) => {
                    self.surfaces[drape.min(MAX_DRAPED_HULLS - 1)].part(own)
                }
            };
            (points, facets, edges) = (hull.points_end, hull.facets_end, hull.edges_end);
            part
        })
    }
}

impl Figure<'_> {
    /// Finds the surface of a drape's points.
    fn wrap(&mut self, drape: usize, points: Range<usize>) {
        let hull: heapless::Vec<Vec3, MAX_HULL_POINTS> = points
            .take(MAX_HULL_POINTS)
            .filter_map(|index| self.points.get(index))
            .collect();
        if let Some(surface) = self.surfaces.get_mut(drape) {
            surface.enclose(&hull);
        }
    }
}
