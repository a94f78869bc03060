//! A body: joint offsets and low-poly convex hulls, read in place.

use crate::budget::{MAX_HULL_POINTS, MAX_HULLS, MAX_POINTS};
use crate::format::{
    FormatError, HULL_HEADER_BYTES, HULL_POINT_BYTES, HULL_STEP_M, OFFSET_STEP_M, OFFSETS_BYTES,
    i16_at, u16_at,
};
use crate::pose::ModelPose;
use crate::skeleton::{JOINTS, Joint, Skeleton};
use core::fmt;
use glam::Vec3;

/// A body in a pack's bytes: where its joints are, and its hulls.
#[derive(Clone, Copy, Debug)]
pub struct Avatar<'a> {
    offsets: &'a [u8],
    hulls: &'a [u8],
}

/// One convex hull of an avatar, rigid with a joint. It is given by points alone:
/// the silhouette of a convex hull is the convex hull of its projected points.
#[derive(Clone, Copy, Debug)]
pub struct Hull<'a> {
    joint: Joint,
    origin: Vec3,
    step: Vec3,
    points: &'a [u8],
}

impl<'a> Avatar<'a> {
    /// Checks every hull of `bytes`; reading cannot fail afterwards.
    ///
    /// # Errors
    /// Where the bytes are not one whole avatar within the budget.
    pub fn parse(bytes: &'a [u8]) -> Result<Self, FormatError> {
        let (Some(offsets), Some(hulls)) = (bytes.get(..OFFSETS_BYTES), bytes.get(OFFSETS_BYTES..))
        else {
            return Err(FormatError::new(bytes.len(), "114 bytes of joint offsets"));
        };
        let mut rest = hulls;
        let (mut hull_count, mut point_count) = (0, 0);
        while !rest.is_empty() {
            let at = bytes.len() - rest.len();
            let Some((hull, behind)) = split_hull(rest) else {
                return Err(FormatError::new(
                    at,
                    "a whole hull of a known joint with 1 to 32 points",
                ));
            };
            hull_count += 1;
            point_count += hull.len();
            if hull_count > MAX_HULLS || point_count > MAX_POINTS {
                return Err(FormatError::new(
                    at,
                    "at most 32 hulls of 768 points in all",
                ));
            }
            rest = behind;
        }
        Ok(Self { offsets, hulls })
    }

    /// The joint offsets.
    #[must_use]
    pub fn skeleton(&self) -> Skeleton {
        let mut offsets = [Vec3::ZERO; JOINTS];
        for (joint, offset) in offsets.iter_mut().enumerate() {
            *offset = vector_at(self.offsets, joint * 6);
        }
        Skeleton { offsets }
    }

    /// The hulls, in file order.
    pub fn hulls(&self) -> impl Iterator<Item = Hull<'a>> + use<'a> {
        let mut rest = self.hulls;
        core::iter::from_fn(move || {
            let (hull, behind) = split_hull(rest)?;
            rest = behind;
            Some(hull)
        })
    }

    /// Bytes that the avatar takes in its pack.
    #[must_use]
    pub fn len_bytes(&self) -> usize {
        self.offsets.len() + self.hulls.len()
    }
}

impl<'a> Hull<'a> {
    /// The joint that carries the hull.
    #[must_use]
    pub const fn joint(&self) -> Joint {
        self.joint
    }

    /// How many points it has, 1 to 32.
    #[must_use]
    pub const fn len(&self) -> usize {
        self.points.len() / HULL_POINT_BYTES
    }

    /// Whether it has no points: never for a hull of a parsed avatar.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.points.is_empty()
    }

    /// Its points in the joint's frame, metres.
    pub fn points(&self) -> impl Iterator<Item = Vec3> + use<'a> {
        let (origin, step) = (self.origin, self.step);
        self.points
            .as_chunks::<HULL_POINT_BYTES>()
            .0
            .iter()
            .map(move |&[x, y, z]| {
                origin + step * Vec3::new(f32::from(x), f32::from(y), f32::from(z))
            })
    }
}

/// The first hull of `bytes` and what is behind it.
fn split_hull(bytes: &[u8]) -> Option<(Hull<'_>, &[u8])> {
    let header = bytes.get(..HULL_HEADER_BYTES)?;
    let joint = Joint::from_index(usize::from(*header.first()?))?;
    let count = usize::from(*header.get(1)?);
    if !(1..=MAX_HULL_POINTS).contains(&count) {
        return None;
    }
    let end = HULL_HEADER_BYTES + count * HULL_POINT_BYTES;
    let points = bytes.get(HULL_HEADER_BYTES..end)?;
    let step = |axis: usize| f32::from(u16_at(header, 8 + 2 * axis)) * HULL_STEP_M;
    let hull = Hull {
        joint,
        origin: vector_at(header, 2),
        step: Vec3::new(step(0), step(1), step(2)),
        points,
    };
    Some((hull, bytes.get(end..)?))
}

/// Three `i16` at `at` in units of 0.1 mm.
fn vector_at(bytes: &[u8], at: usize) -> Vec3 {
    let component = |axis: usize| f32::from(i16_at(bytes, at + 2 * axis)) * OFFSET_STEP_M;
    Vec3::new(component(0), component(1), component(2))
}

/// All hull points of one frame in the walker's space: computed once, seen from
/// every viewpoint. 9.3 kB.
#[derive(Clone, Debug, Default)]
pub struct PosedHulls {
    points: heapless::Vec<Vec3, MAX_POINTS>,
    ends: heapless::Vec<u16, MAX_HULLS>,
}

impl PosedHulls {
    /// Carries the hulls of `avatar` to where `pose` puts their joints.
    #[must_use]
    pub fn new(avatar: &Avatar<'_>, pose: &ModelPose) -> Self {
        let mut posed = Self::default();
        posed.update(avatar, pose);
        posed
    }

    /// The same in place, for the next frame.
    pub fn update(&mut self, avatar: &Avatar<'_>, pose: &ModelPose) {
        self.points.clear();
        self.ends.clear();
        for hull in avatar.hulls() {
            let joint = hull.joint().index();
            let (orientation, position) = (pose.orientations[joint], pose.positions[joint]);
            let points = hull.points().map(|point| position + orientation * point);
            let fits = self.push(points);
            debug_assert!(fits.is_ok(), "a parsed avatar is within the budget");
        }
    }

    /// Adds one hull given by points in the walker's space, metres: something that
    /// a body wears or carries, or a test's figure.
    ///
    /// # Errors
    /// When the budget is used up; nothing is added then.
    pub fn push(&mut self, points: impl IntoIterator<Item = Vec3>) -> Result<(), OverBudget> {
        let start = self.points.len();
        let fits = points.into_iter().all(|point| {
            self.points.len() < start + MAX_HULL_POINTS && self.points.push(point).is_ok()
        });
        let end = u16::try_from(self.points.len()).map_err(|_| OverBudget)?;
        if fits && self.ends.push(end).is_ok() {
            return Ok(());
        }
        self.points.truncate(start);
        Err(OverBudget)
    }

    /// The hulls' points, hull by hull, metres.
    pub fn hulls(&self) -> impl Iterator<Item = &[Vec3]> + Clone {
        let mut start = 0;
        self.ends.iter().map(move |&end| {
            let end = usize::from(end);
            let hull = self.points.get(start..end).unwrap_or_default();
            start = end;
            hull
        })
    }

    /// All points, metres.
    #[must_use]
    pub fn points(&self) -> &[Vec3] {
        &self.points
    }
}

/// A figure has more hulls or points than [`crate::budget`] allows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OverBudget;

impl fmt::Display for OverBudget {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "more than {MAX_HULLS} hulls, {MAX_HULL_POINTS} points of a hull or {MAX_POINTS} points in all"
        )
    }
}

impl core::error::Error for OverBudget {}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pose::Pose;

    /// A head whose single hull is the two ends of a 20 cm line.
    fn one_line() -> [u8; OFFSETS_BYTES + HULL_HEADER_BYTES + 6] {
        let mut bytes = [0; OFFSETS_BYTES + HULL_HEADER_BYTES + 6];
        let spine = 6 * Joint::Spine.index();
        bytes[spine + 2..spine + 4].copy_from_slice(&1_500i16.to_le_bytes());
        let hull = &mut bytes[OFFSETS_BYTES..];
        hull[0] = 1; // spine
        hull[1] = 2;
        hull[4..6].copy_from_slice(&(-500i16).to_le_bytes()); // origin y: -5 cm
        hull[10..12].copy_from_slice(&2_000u16.to_le_bytes()); // step y: 2 mm
        hull[HULL_HEADER_BYTES + 4] = 100;
        bytes
    }

    #[test]
    fn a_hull_is_carried_by_its_joint() {
        let bytes = one_line();
        let avatar = Avatar::parse(&bytes).expect("a whole avatar");
        let model = ModelPose::new(&avatar.skeleton(), &Pose::REST);
        let posed = PosedHulls::new(&avatar, &model);
        let line: [Vec3; 2] = posed.points().try_into().expect("two points");
        assert!((line[0] - Vec3::new(0.0, 0.10, 0.0)).length() < 1e-6);
        assert!((line[1] - Vec3::new(0.0, 0.30, 0.0)).length() < 1e-6);
    }

    #[test]
    fn every_truncation_is_refused_but_the_one_without_hulls() {
        let bytes = one_line();
        for length in (0..bytes.len()).filter(|&length| length != OFFSETS_BYTES) {
            assert!(Avatar::parse(&bytes[..length]).is_err(), "{length}");
        }
    }

    #[test]
    fn what_exceeds_the_budget_is_refused_whole() {
        let mut posed = PosedHulls::default();
        assert_eq!(
            posed.push([Vec3::ZERO; MAX_HULL_POINTS + 1]),
            Err(OverBudget)
        );
        assert!(posed.points().is_empty());
        for _ in 0..MAX_POINTS / MAX_HULL_POINTS {
            assert_eq!(posed.push([Vec3::ZERO; MAX_HULL_POINTS]), Ok(()));
        }
        assert_eq!(posed.push([Vec3::ZERO]), Err(OverBudget));
        assert_eq!(posed.points().len(), MAX_POINTS);
    }
}
