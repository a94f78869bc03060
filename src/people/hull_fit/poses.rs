//! A skinned mesh on the canonical skeleton, at rest and in random poses.
//!
//! Poses are those of synthetic walkers, so that hulls can be fitted to a mesh without any recorded
//! motion. Each source joint that a canonical joint follows turns like it, the others stay fixed to
//! their parents, and the mesh's own weights do the rest.

use super::{PosedMesh, Skinned};
use crate::error::Result;
use crate::import::{Motion, Skin, SourceFrame};
use crate::people::cohort::Person;
use crate::people::cohort::style::normal;
use crate::people::forward_kinematics;
use crate::people::retarget::follow::local_rotations;
use crate::people::retarget::joint_roles::JointRoles;
use crate::people::retarget::rest_pose::{Globals, RestCalibration, source_points};
use edgegait_core::skeleton::{JOINTS, Joint};
use glam::{DQuat, DVec3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// The largest upward bend of the toes, degrees: about as much as at push-off.
const MOST_TOE_DEG: f64 = 35.0;

/// A skinned mesh whose joints are known.
pub(super) struct RiggedMesh<'a> {
    motion: &'a Motion,
    skin: &'a Skin,
    rest: RestCalibration,
    /// Rotation from source axes to Y up.
    world: DQuat,
    unit_m: f64,
    /// Source joints below each foot.
    toes: [Vec<usize>; 2],
    /// The canonical joint offsets, metres.
    pub(super) offsets: [DVec3; JOINTS],
}

impl<'a> RiggedMesh<'a> {
    /// Finds the canonical joints in a skinned mesh at rest.
    ///
    /// # Errors
    /// A sentence, without the file's name, if there is no mesh or a joint that gait needs is
    /// missing.
    pub(super) fn from_motion(motion: &'a Motion) -> std::result::Result<Self, String> {
        let skin = motion.skin.as_ref().ok_or("no skinned mesh in the file")?;
        let mut roles = JointRoles::find(&motion.joints)?;
        let unit_m = motion.unit_m.unwrap_or(1.0);
        let (positions, rotations) = at_rest(motion, skin).globals(0);
        let frames = [Globals {
            positions,
            rotations,
        }];
        let up = crate::people::retarget::up_axis(&frames, &roles);
        let rest = RestCalibration::calibrate(motion, &mut roles, &frames, None, up)?;
        let offsets = rest.offsets.map(|offset| offset * unit_m);
        let carried = |foot: usize, joint: usize| {
            std::iter::successors(motion.joints[joint].parent, |&at| motion.joints[at].parent)
                .any(|at| at == foot)
        };
        let toes = roles.foot.map(|foot| {
            (0..motion.joints.len())
                .filter(|&joint| carried(foot, joint))
                .collect()
        });
        Ok(Self {
            motion,
            skin,
            world: DQuat::from_rotation_arc(up, DVec3::Y),
            rest,
            unit_m,
            toes,
            offsets,
        })
    }

    /// Returns the mesh at rest, with the canonical joint of most weight for each vertex.
    pub(super) fn skinned(&self) -> Skinned {
        let owners = self.owners();
        let joints = self.skin.weights.iter().map(|weights| {
            let mut shares = [0.0; JOINTS];
            for &(joint, share) in weights {
                shares[owners[joint].index()] += share;
            }
            let most = Joint::ALL
                .into_iter()
                .max_by(|a, b| shares[a.index()].total_cmp(&shares[b.index()]));
            most.unwrap_or(Joint::Pelvis)
        });
        Skinned {
            triangles: self.skin.triangles.clone(),
            joints: joints.collect(),
            rest: self.example(&at_rest(self.motion, self.skin)),
        }
    }

    /// Returns the canonical joint that each source joint moves with: its own, or its parent's.
    fn owners(&self) -> Vec<Joint> {
        let mut owners: Vec<Joint> = Vec::with_capacity(self.motion.joints.len());
        for (index, joint) in self.motion.joints.iter().enumerate() {
            let parent = joint.parent.map_or(Joint::Pelvis, |parent| owners[parent]);
            owners.push(self.follower(index).unwrap_or(parent));
        }
        owners
    }

    /// Returns the canonical joint that turns with a source joint: the outermost of several.
    fn follower(&self, source: usize) -> Option<Joint> {
        let mut outward = Joint::ALL.into_iter().rev();
        outward.find(|joint| self.rest.parts[joint.index()].turns_with == source)
    }

    /// Returns `count` random poses.
    ///
    /// # Errors
    /// Never for the built-in populations.
    pub(super) fn examples(&self, count: usize, seed: u64) -> Result<Vec<PosedMesh>> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut walkers = Vec::new();
        for person in 0..26 {
            let person = Person::of_cohort(seed, person)?;
            let speed_kmh = rng.random_range(3.0..7.0);
            walkers.push(person.cycle(speed_kmh));
        }
        let example = |index: usize| {
            let walker = &walkers[index % walkers.len()];
            let frame = rng.random_range(0..walker.rotations.len());
            let mut pose = walker.rotations[frame];
            for (rotation, joint) in pose.iter_mut().zip(Joint::ALL) {
                let noise: [f64; 3] =
                    std::array::from_fn(|_| normal(&mut rng) * spread_deg(joint).to_radians());
                *rotation *= DQuat::from_scaled_axis(noise.into());
            }
            self.example(&self.posed(&pose))
        };
        Ok((0..count).map(example).collect())
    }

    /// Returns the source in a canonical pose, as a motion of one frame.
    fn posed(&self, pose: &[DQuat; JOINTS]) -> Motion {
        let (_, wanted) = forward_kinematics(&self.offsets, DVec3::ZERO, pose);
        let joints = &self.motion.joints;
        let mut globals: Vec<DQuat> = Vec::with_capacity(joints.len());
        for (index, joint) in joints.iter().enumerate() {
            globals.push(match (self.follower(index), joint.parent) {
                (Some(canonical), _) => {
                    let axes = self.rest.parts[canonical.index()].axes;
                    self.world.inverse()
                        * wanted[canonical.index()]
                        * axes.inverse()
                        * self.rest.zero[index]
                }
                (None, Some(parent)) => globals[parent],
                (None, None) => DQuat::IDENTITY,
            });
        }
        for (foot, toes) in [Joint::LeftFoot, Joint::RightFoot]
            .into_iter()
            .zip(&self.toes)
        {
            let turned = wanted[foot.index()];
            let down = libm::asin(-(turned * DVec3::Z).y).clamp(0.0, MOST_TOE_DEG.to_radians());
            let across = self.world.inverse() * turned * DVec3::X;
            for &toe in toes {
                globals[toe] = DQuat::from_axis_angle(across, -down) * globals[toe];
            }
        }
        let rotations = joints.iter().zip(&globals).map(|(joint, global)| {
            let parent = joint
                .parent
                .map_or(DQuat::IDENTITY, |parent| globals[parent]);
            (parent.inverse() * *global).normalize()
        });
        let mut motion = at_rest(self.motion, self.skin);
        motion.frames[0].rotations = rotations.collect();
        motion
    }

    /// Returns the mesh and the canonical joints of a motion's only frame, as an import does.
    fn example(&self, motion: &Motion) -> PosedMesh {
        let (positions, rotations) = motion.globals(0);
        let globals = Globals {
            positions,
            rotations,
        };
        let points =
            source_points(&self.rest, &globals).map(|point| self.world * point * self.unit_m);
        let locals = local_rotations(&self.rest, self.world, &globals, &points, &self.offsets);
        let (positions, rotations) = forward_kinematics(&self.offsets, points[0], &locals);
        let mesh = self.skin.posed(motion, 0);
        PosedMesh {
            positions,
            rotations,
            mesh: mesh
                .into_iter()
                .map(|vertex| self.world * vertex * self.unit_m)
                .collect(),
        }
    }
}

/// Returns the standard deviation of the noise on a joint's rotation about each axis, degrees.
/// Our choice: about the difference between recorded and synthetic walks, which is largest for
/// hands, whose rest poses differ.
fn spread_deg(joint: Joint) -> f64 {
    match joint {
        Joint::Pelvis | Joint::LeftClavicle | Joint::RightClavicle => 4.0,
        Joint::Spine | Joint::Thorax => 6.0,
        Joint::LeftShank | Joint::RightShank => 6.0,
        Joint::LeftThigh | Joint::RightThigh => 7.0,
        Joint::LeftFoot | Joint::RightFoot => 8.0,
        Joint::Neck | Joint::Head => 9.0,
        Joint::LeftUpperArm | Joint::RightUpperArm => 10.0,
        Joint::LeftForearm | Joint::RightForearm => 10.0,
        Joint::LeftHand | Joint::RightHand => 22.0,
    }
}

/// Returns a motion of one frame, in which the source stands as its mesh was modelled.
fn at_rest(motion: &Motion, skin: &Skin) -> Motion {
    Motion {
        frames: vec![SourceFrame {
            root: skin.root,
            rotations: vec![DQuat::IDENTITY; motion.joints.len()],
            offsets: None,
        }],
        joints: motion.joints.clone(),
        skin: None,
        warnings: Vec::new(),
        ..*motion
    }
}
