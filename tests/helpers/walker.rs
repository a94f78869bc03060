//! Decoded walkers of packs, moment by moment.

use crate::command::done;
use crate::people::{body, recordings, rows};
use edgegait::people::forward_kinematics;
use edgegait_core::clip::Clip;
use edgegait_core::pack::Pack;
use edgegait_core::skeleton::{JOINTS, Joint};
use glam::{DQuat, DVec3, Vec3};
use std::fs;
use std::path::Path;

/// The number of moments in a cycle.
const MOMENTS: usize = 64;

/// A moment of a walker along +Z: joints and the points of hulls, metres, Y up.
pub struct Moment {
    at: [DVec3; JOINTS],
    turned: [DQuat; JOINTS],
    points: Vec<(Joint, DVec3)>,
}

impl Moment {
    /// Makes the moment of a body without hulls.
    pub fn new((at, turned): ([DVec3; JOINTS], [DQuat; JOINTS])) -> Self {
        Self {
            at,
            turned,
            points: Vec::new(),
        }
    }

    /// Returns the place of a joint.
    pub fn of(&self, joint: Joint) -> DVec3 {
        self.at[joint.index()]
    }

    /// Returns the orientation of a joint in the world.
    pub fn turn(&self, joint: Joint) -> DQuat {
        self.turned[joint.index()]
    }

    /// Returns the points of a joint's hulls.
    pub fn hull(&self, joint: Joint) -> impl Iterator<Item = DVec3> {
        let points = self.points.iter().filter(move |point| point.0 == joint);
        points.map(|point| point.1)
    }
}

/// Decodes a stored cycle on its body.
pub fn moments(pack: &Pack<'_>, subject: usize, clip: usize) -> Vec<Moment> {
    let subject = pack.subjects().nth(subject).expect("a subject");
    let avatar = pack.avatar(subject.avatar).expect("a body");
    let offsets = avatar.skeleton().offsets.map(Vec3::as_dvec3);
    let Some(Clip::Loop(clip)) = pack.clip(clip) else {
        panic!("expected a cycle");
    };
    let moment = |at: usize| {
        let pose = clip.pose(at as f32 / MOMENTS as f32);
        let turns = pose.rotations.map(|turn| turn.as_dquat().normalize());
        let mut moment = Moment::new(forward_kinematics(&offsets, pose.root.as_dvec3(), &turns));
        for hull in avatar.hulls() {
            let joint = hull.joint();
            let (at, turn) = (moment.of(joint), moment.turn(joint));
            let points = hull
                .points()
                .map(|point| (joint, at + turn * point.as_dvec3()));
            moment.points.extend(points);
        }
        moment
    };
    (0..MOMENTS).map(moment).collect()
}

/// Returns the people of `people/bodies.csv`.
pub fn people(data: &Path) -> Vec<String> {
    let bodies = rows(&data.join("people/bodies.csv"));
    bodies.into_iter().map(|row| row["id"].clone()).collect()
}

/// Imports the mean cycles of a person of `people` on the measured body, as `ID.egp` with
/// `ID.json`.
pub fn import_person(at: &Path, data: &Path, person: &str) {
    let bodies = rows(&data.join("people/bodies.csv"));
    let row = bodies.iter().find(|row| row["id"] == person);
    fs::write(at.join("body.csv"), body(row.expect("a body"))).expect("a table");
    let import = "import --subject ID --bodies body.csv --cycles mean --keep-going --overwrite --out ID.egp --json ID.json";
    let import = import.replace("ID", person);
    let files = recordings(data, person);
    let mut import: Vec<&str> = import.split(' ').collect();
    import.extend(files.iter().map(String::as_str));
    done(at, &import);
}
