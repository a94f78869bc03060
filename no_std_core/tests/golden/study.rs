//! The studies that firmware repeats: GEIs of several people, speeds and viewpoints, and the
//! answers of a recognizer.

#[path = "fnv.rs"]
mod fnv;

use edgegait_core::avatar::Avatar;
use edgegait_core::camera::{Camera, Viewpoint};
use edgegait_core::clip::Loop;
use edgegait_core::pack::Pack;
pub use fnv::Fnv;

/// The shipped model `spread` in 8 bits.
pub const RECOGNIZER: &[u8] = include_bytes!("spread.egr");
/// Azimuth and elevation, degrees.
const VIEWS: [[i16; 2]; 3] = [[90, 0], [0, 0], [45, 30]];
/// Frames of a cycle.
pub const FRAMES: u8 = 32;

/// A study: walks of a pack, each seen from all viewpoints.
#[derive(Clone, Copy)]
pub struct Study {
    pub pack: &'static [u8],
    /// The expected answers, a line for each GEI: rasteriser, person, walk, azimuth, elevation,
    /// hash, the person found, and the score's bits.
    pub answers: &'static str,
    /// The subjects, by their places in the pack.
    subjects: &'static [usize],
    /// The walks of each subject, by their places.
    walks: &'static [usize],
}

/// Three people of the built-in cohort, of both sexes, who walk at 4, 5 and 7 km/h and run at 12.
pub const BARE: Study = Study {
    pack: include_bytes!("cohort.egp"),
    answers: include_str!("study.txt"),
    subjects: &[0, 1, 12],
    walks: &[1, 2, 4, 9],
};
/// Three dressed people at 5 km/h: in a coat, with long hair; in loose clothes; in a skirt, with
/// long hair.
pub const DRESSED: Study = Study {
    pack: include_bytes!("dressed.egp"),
    answers: include_str!("dressed.txt"),
    subjects: &[0, 1, 2],
    walks: &[0],
};

/// One GEI of a study.
pub struct Job<'a> {
    pub person: &'a str,
    pub walk: &'a str,
    pub avatar: Avatar<'a>,
    pub cycle: Loop<'a>,
    pub view: [i16; 2],
    pub camera: Camera,
}

impl Study {
    /// Returns the number of its GEIs.
    pub const fn jobs(&self) -> usize {
        self.subjects.len() * self.walks.len() * VIEWS.len()
    }

    /// Returns a GEI by its number: the viewpoints of a walk follow each other.
    pub fn job<'a>(&self, pack: &Pack<'a>, number: usize) -> Job<'a> {
        let (walk, view) = (number / VIEWS.len(), VIEWS[number % VIEWS.len()]);
        let subject = self.subjects[walk / self.walks.len()];
        let walk = self.walks[walk % self.walks.len()];
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
}
