//! Imported walkers of the set `people`, decoded moment by moment.

use crate::command::done;
use crate::people::{Row, body, rows};
use edgegait::people::forward_kinematics;
use edgegait_core::clip::Clip;
use edgegait_core::pack::Pack;
use edgegait_core::skeleton::{JOINTS, Joint};
use glam::{DQuat, DVec3, Vec3};
use std::fs;
use std::path::{Path, PathBuf};

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
    let Some(Clip::Loop(clip)) = pack.clip(clip) else {
        panic!("expected a cycle");
    };
    let moment = |at: usize| {
        let pose = clip.pose(at as f32 / MOMENTS as f32);
        let turns = pose.rotations.map(|turn| turn.as_dquat().normalize());
        posed(pack, subject, pose.root.as_dvec3(), turns)
    };
    (0..MOMENTS).map(moment).collect()
}

/// Decodes the body of a person who stands at ease.
pub fn at_ease(pack: &Pack<'_>, subject: usize) -> Moment {
    posed(pack, subject, DVec3::ZERO, [DQuat::IDENTITY; JOINTS])
}

fn posed(pack: &Pack<'_>, subject: usize, root: DVec3, turns: [DQuat; JOINTS]) -> Moment {
    let subject = pack.subjects().nth(subject).expect("a subject");
    let avatar = pack.avatar(subject.avatar).expect("a body");
    let offsets = avatar.skeleton().offsets.map(Vec3::as_dvec3);
    let mut moment = Moment::new(forward_kinematics(&offsets, root, &turns));
    for hull in avatar.hulls() {
        let joint = hull.joint();
        let (at, turn) = (moment.of(joint), moment.turn(joint));
        let points = hull
            .points()
            .map(|point| (joint, at + turn * point.as_dvec3()));
        moment.points.extend(points);
    }
    moment
}

/// Returns the rows of `people/bodies.csv`.
pub fn bodies(data: &Path) -> Vec<Row> {
    rows(&data.join("people/bodies.csv"))
}

/// Returns the rows of `people/manifest.csv`.
pub fn takes(data: &Path) -> Vec<Row> {
    rows(&data.join("people/manifest.csv"))
}

/// Returns the recording of a row of `people/manifest.csv`.
pub fn recording(data: &Path, take: &Row) -> PathBuf {
    let root = match take["source_root"].as_str() {
        "mocap" => "mocap/clips",
        _ => "people/mocap_extra/clips",
    };
    data.join(root).join(&take["source"])
}

/// Returns the name of the walk that is imported from the recording of a take.
pub fn walk(take: &Row) -> String {
    let stem = Path::new(&take["source"]).file_stem();
    stem.expect("a name").to_string_lossy().into_owned()
}

/// Imports a person of `people` on the measured body, as `ID.egp` with `ID.json`; `cycles` is
/// `all` or `mean`.
pub fn import_person(at: &Path, data: &Path, person: &Row, cycles: &str) {
    fs::write(at.join("body.csv"), body(person)).expect("a table");
    let import = "import --subject ID --bodies body.csv --keep-going --overwrite --out ID.egp --json ID.json --cycles";
    let import = import.replace("ID", &person["id"]);
    let own = takes(data);
    let own = own.iter().filter(|take| take["id"] == person["id"]);
    let mut files: Vec<String> = own
        .map(|take| recording(data, take).display().to_string())
        .collect();
    files.sort_unstable();
    files.dedup();
    let mut import: Vec<&str> = import.split(' ').collect();
    import.push(cycles);
    import.extend(files.iter().map(String::as_str));
    done(at, &import);
}
