//! The study that firmware repeats: GEIs of several people, speeds and viewpoints, and whom a
//! recognizer takes them for.

#[path = "fnv.rs"]
mod fnv;

use edgegait_core::avatar::Avatar;
use edgegait_core::camera::{Camera, Viewpoint};
use edgegait_core::clip::Loop;
use edgegait_core::pack::Pack;
pub use fnv::Fnv;

/// The built-in cohort: 26 people at 10 speeds.
pub const COHORT: &[u8] = include_bytes!("cohort.egp");
/// The shipped model `spread` in 8 bits.
pub const RECOGNIZER: &[u8] = include_bytes!("spread.egr");
/// A line for each GEI: person, walk, azimuth, elevation, hash, who it is taken for, and the
/// score's bits.
pub const ANSWERS: &str = include_str!("study.txt");

/// Subjects by their places in the pack, of both sexes.
const SUBJECTS: [usize; 3] = [0, 1, 12];
/// Walks of each, by their places: at 4, 5 and 7 km/h, and a run at 12 km/h.
const WALKS: [usize; 4] = [1, 2, 4, 9];
/// Azimuth and elevation, degrees.
const VIEWS: [[i16; 2]; 3] = [[90, 0], [0, 0], [45, 30]];
/// GEIs of the study.
pub const JOBS: usize = SUBJECTS.len() * WALKS.len() * VIEWS.len();
/// Frames of a cycle.
pub const FRAMES: u8 = 32;

/// One GEI of the study.
pub struct Job<'a> {
    pub person: &'a str,
    pub walk: &'a str,
    pub avatar: Avatar<'a>,
    pub cycle: Loop<'a>,
    pub view: [i16; 2],
    pub camera: Camera,
}

/// One of them by its number: the viewpoints of a walk one after another.
pub fn job<'a>(pack: &Pack<'a>, number: usize) -> Job<'a> {
    let (walk, view) = (number / VIEWS.len(), VIEWS[number % VIEWS.len()]);
    let (subject, walk) = (SUBJECTS[walk / WALKS.len()], WALKS[walk % WALKS.len()]);
    let person = pack.subject(subject).expect("a subject");
    let mut walks = pack.walks().filter(|walk| walk.subject == subject);
    let walk = walks.nth(walk).expect("a walk");
    let cycle = pack.clip(walk.clip).and_then(|clip| clip.as_loop());
    let [azimuth, elevation] = view.map(f32::from);
    let viewpoint = Viewpoint::from_degrees(azimuth, elevation);
    Job {
        person: person.name,
        walk: walk.name,
        avatar: pack.avatar(walk.avatar).expect("an avatar"),
        cycle: cycle.expect("a cycle"),
        view,
        camera: Camera::orthographic(viewpoint.expect("a viewpoint")),
    }
}
