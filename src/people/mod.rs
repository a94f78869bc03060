//! People in f64, before encoding: bodies and motions.
//!
//! Everything that produces a walker (`recorded`, `cohort`) returns the types of this module, and the
//! encoder takes them.

#[cfg(feature = "import")]
pub mod audit;
pub(crate) mod cleaning;
pub(crate) mod clothes;
pub mod cohort;
#[cfg(feature = "import")]
pub mod cutting;
#[cfg(feature = "import")]
pub(crate) mod encodable;
pub(crate) mod fewer_points;
#[cfg(feature = "import")]
pub(crate) mod hull_fit;
pub(crate) mod leg;
#[cfg(feature = "import")]
mod markers;
#[cfg(feature = "import")]
pub(crate) mod measured;
#[cfg(feature = "import")]
mod other_body;
#[cfg(feature = "import")]
pub mod recorded;
#[cfg(feature = "import")]
mod renamings;
#[cfg(feature = "import")]
mod residual;
#[cfg(feature = "import")]
pub mod retarget;
#[cfg(feature = "import")]
pub mod rigging;
pub mod session;
#[cfg(feature = "import")]
mod trunk_lean;
#[cfg(feature = "import")]
mod uncut;
#[cfg(feature = "import")]
mod unsure_joints;
pub(crate) mod variation;

use edgegait_core::clothes::Clothes;
use edgegait_core::pack::{Gait, Sex};
use edgegait_core::skeleton::{JOINTS, Joint};
use glam::{DQuat, DVec3};

/// A person: a body and how it walks.
#[derive(Clone, Debug)]
pub struct Subject {
    /// Name, unique among the people of one pack, at most 255 bytes.
    pub name: String,
    /// Sex, where it is known.
    pub sex: Option<Sex>,
    /// Age, years, 18 to 80, where it is known.
    pub age_years: Option<f64>,
    /// Stature, metres; 0 where it is unknown.
    pub stature_m: f64,
    /// Mass, kg; 0 where it is unknown.
    pub mass_kg: f64,
    /// The body.
    pub body: Body,
    /// The gait cycles and uncut motions.
    pub walks: Vec<Walk>,
}

/// One motion of a subject, with its metadata.
#[derive(Clone, Debug)]
pub struct Walk {
    /// Name of the take, at most 255 bytes.
    pub name: String,
    /// Number of the cycle within the take, from 0; 0 for an uncut motion.
    pub cycle: u16,
    /// Walking or running.
    pub gait: Gait,
    /// Mean speed, m/s; 0 where it is unknown.
    pub speed_mps: f64,
    /// The motion, on the subject's own skeleton.
    pub motion: Track,
    /// The body in the clothes of this walk, if they differ from the subject's own.
    pub worn: Option<Body>,
}

/// A motion, repeating or not.
#[derive(Clone, Debug)]
pub enum Track {
    /// One closed gait cycle.
    Loop(Cycle),
    /// An uncut take: starts, turns, whole trials.
    Uncut(UncutMotion),
}

/// One closed gait cycle of one walker, sampled evenly over the phase.
///
/// Frame `i` of `n` is at phase `i / n`; the last frame is followed by the first.
/// The walker faces and travels along +Z. Phase 0 is the left heel's contact.
#[derive(Clone, Debug)]
pub struct Cycle {
    /// Duration, seconds.
    pub period_s: f64,
    /// Metres travelled along +Z in one cycle.
    pub drift_m: f64,
    /// Largest joint displacement from closing a recorded loop, mm; 0 for a synthetic cycle.
    /// Excludes horizontal drift, which is stored or removed on purpose.
    pub closure_mm: f64,
    /// Pelvis position per frame, metres, without the travel (`drift_m * phase`);
    /// y is the height above the floor.
    pub root: Vec<DVec3>,
    /// Rotation of each joint relative to its parent, per frame, about the
    /// canonical rest pose ([`Joint`]).
    pub rotations: Vec<[DQuat; JOINTS]>,
}

/// A motion of one walker that need not repeat, sampled evenly over time.
///
/// Frame `i` is at `i / sample_rate_hz` seconds. The walker starts at x = z = 0 and travels
/// along +Z on the whole, or keeps the file's own world where the file states its axes.
#[derive(Clone, Debug)]
pub struct UncutMotion {
    /// Frames a second.
    pub sample_rate_hz: f64,
    /// Pelvis position per frame, metres; y is the height above the floor.
    pub roots: Vec<DVec3>,
    /// Rotation of each joint relative to its parent, per frame, about the
    /// canonical rest pose ([`Joint`]).
    pub rotations: Vec<[DQuat; JOINTS]>,
}

/// One walker's body: a skeleton and the convex hulls that its joints carry.
#[derive(Clone, Debug)]
pub struct Body {
    /// Joint offsets from the parent in the rest pose, metres.
    pub offsets: [DVec3; JOINTS],
    /// Convex hulls, each rigid with one joint.
    pub hulls: Vec<BodyHull>,
    /// Draped hulls. Each consists of parts, each rigid with its joint, and spans all of them
    /// together, like cloth that is taut between them.
    pub draped: Vec<Vec<BodyHull>>,
    /// The clothes that the hulls of a dressed body include.
    pub clothes: Option<Clothes>,
    /// How well the hulls match the mesh that they were fitted to, if any.
    pub fit: Option<HullFit>,
}

impl Body {
    /// Returns the hulls, then the parts of draped hulls.
    pub(crate) fn all_hulls(&self) -> impl Iterator<Item = &BodyHull> {
        self.hulls.iter().chain(self.draped.iter().flatten())
    }
}

/// How well a body's hulls match the mesh that they were fitted to.
#[derive(Clone, Debug, PartialEq)]
pub struct HullFit {
    /// Mean Jaccard index of the silhouettes of hulls and mesh, 192 rows high, in poses and from
    /// cameras that the fit did not see.
    pub jaccard: f64,
    /// The Jaccard index by number of hull points, most points first.
    pub frontier: Vec<(usize, f64)>,
}

/// A convex hull given by points in its joint's frame, metres.
#[derive(Clone, Debug)]
pub struct BodyHull {
    /// The joint that carries it.
    pub joint: Joint,
    /// Points that span the hull; points inside it do no harm.
    pub points: Vec<DVec3>,
}

/// Returns the least and the greatest of some values.
pub(crate) fn extent(values: impl Iterator<Item = f64>) -> (f64, f64) {
    values.fold((f64::MAX, f64::MIN), |(low, high), value| {
        (low.min(value), high.max(value))
    })
}

/// Returns global positions and rotations of the canonical skeleton in one pose, f64.
#[must_use]
pub fn forward_kinematics(
    offsets: &[DVec3; JOINTS],
    root: DVec3,
    rotations: &[DQuat; JOINTS],
) -> ([DVec3; JOINTS], [DQuat; JOINTS]) {
    let mut positions = [root; JOINTS];
    let mut globals = *rotations;
    for joint in Joint::ALL {
        if let Some(parent) = joint.parent() {
            let (i, p) = (joint.index(), parent.index());
            positions[i] = positions[p] + globals[p] * offsets[i];
            globals[i] = (globals[p] * rotations[i]).normalize();
        }
    }
    (positions, globals)
}
