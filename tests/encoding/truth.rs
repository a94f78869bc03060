//! The true places of joints: forward kinematics with matrices, independent of encoder and decoder.

pub use edgegait::encode::encode_subjects;
use edgegait::people::cohort::Person;
use edgegait::people::{Cycle, Subject, Track, Walk};
use edgegait_core::clip::Loop;
use edgegait_core::pack::{Gait, Pack};
use edgegait_core::skeleton::{JOINTS, Joint};
use glam::{DMat4, DQuat, DVec3, Quat, Vec3};

/// The parents of pelvis, spine, thorax, neck, head, left arm (4), right arm (4), left leg (3),
/// right leg (3); the pelvis has none.
const PARENTS: [usize; JOINTS] = [
    0, 0, 1, 2, 3, 2, 5, 6, 7, 2, 9, 10, 11, 0, 13, 14, 0, 16, 17,
];

/// Returns a person of the cohort with these motions as walks.
pub fn subject(person: usize, motions: Vec<Cycle>) -> Subject {
    let person = Person::of_cohort(1, person).expect("a person of the cohort");
    let walks = motions.into_iter().zip(0..).map(|(motion, cycle)| Walk {
        worn: None,
        name: "walk".into(),
        cycle,
        gait: Gait::Walk,
        speed_mps: 0.0,
        motion: Track::Loop(motion),
    });
    Subject {
        name: person.name.clone(),
        sex: Some(person.sex),
        age_years: None,
        stature_m: person.dimensions.stature,
        mass_kg: person.mass_kg,
        body: person.body.clone(),
        walks: walks.collect(),
    }
}

/// Returns the motion of a walk.
pub fn motion(walk: &Walk) -> &Cycle {
    match &walk.motion {
        Track::Loop(cycle) => cycle,
        Track::Uncut(_) => panic!("a take"),
    }
}

/// Returns the motion of a walk, mutable.
pub fn motion_mut(walk: &mut Walk) -> &mut Cycle {
    match &mut walk.motion {
        Track::Loop(cycle) => cycle,
        Track::Uncut(_) => panic!("a take"),
    }
}

/// Returns a cycle of a person of the cohort.
pub fn made(person: usize, speed_kmh: f64) -> Cycle {
    let person = Person::of_cohort(1, person).expect("a person of the cohort");
    person.cycle(speed_kmh)
}

/// Returns a pose held for a second, as this many frames.
pub fn standing(frames: usize) -> Cycle {
    let pose = made(0, 5.0).rotations[0];
    Cycle {
        period_s: 1.0,
        drift_m: 0.0,
        closure_mm: 0.0,
        root: vec![DVec3::new(0.01, 0.9, 0.0); frames],
        rotations: vec![pose; frames],
    }
}

/// Returns the cycle with a joint's rotation replaced, by phase.
pub fn with_joint(mut cycle: Cycle, joint: Joint, turn: impl Fn(f64) -> DQuat) -> Cycle {
    let frames = cycle.rotations.len();
    for (frame, pose) in cycle.rotations.iter_mut().enumerate() {
        pose[joint.index()] = turn(frame as f64 / frames as f64);
    }
    cycle
}

/// Returns a pack of these people.
pub fn encoded(subjects: &[Subject], max_error_mm: f64) -> Vec<u8> {
    encode_subjects(subjects, max_error_mm, &|| Ok(())).expect("a pack")
}

/// Returns the error of encoding these people.
pub fn refusal(subjects: &[Subject]) -> String {
    let refused = encode_subjects(subjects, 5.0, &|| Ok(()));
    refused.expect_err("a motion to be refused").to_string()
}

/// The greatest and the mean error of each joint, mm.
#[derive(Clone, Copy, Debug, Default)]
pub struct Errors(pub [(f64, f64); JOINTS]);

impl Errors {
    pub fn max(&self) -> f64 {
        self.0.iter().map(|joint| joint.0).fold(0.0, f64::max)
    }

    pub fn mean(&self) -> f64 {
        self.0.iter().map(|joint| joint.1).sum::<f64>() / 19.0
    }
}

/// Returns the points 3 cm off each joint, in both directions of each axis of its frame, metres.
fn virtual_points(
    offsets: &[DVec3; JOINTS],
    root: DVec3,
    rotations: &[DQuat; JOINTS],
) -> [[DVec3; 6]; JOINTS] {
    let mut frames = [DMat4::IDENTITY; JOINTS];
    for joint in 0..JOINTS {
        let turn = rotations[joint].normalize();
        frames[joint] = if joint == 0 {
            DMat4::from_rotation_translation(turn, root)
        } else {
            frames[PARENTS[joint]] * DMat4::from_rotation_translation(turn, offsets[joint])
        };
    }
    let arms = [
        DVec3::X,
        DVec3::Y,
        DVec3::Z,
        -DVec3::X,
        -DVec3::Y,
        -DVec3::Z,
    ];
    frames.map(|frame| arms.map(|arm| frame.transform_point3(0.03 * arm)))
}

/// Returns the distances between a cycle and another motion of the same body, by phase.
pub fn errors_between(
    cycle: &Cycle,
    offsets: &[DVec3; JOINTS],
    other: impl Fn(f64) -> (DVec3, [DQuat; JOINTS]),
) -> Errors {
    let frames = cycle.root.len();
    let mut errors = Errors::default();
    for frame in 0..frames {
        let truth = virtual_points(offsets, cycle.root[frame], &cycle.rotations[frame]);
        let (root, rotations) = other(frame as f64 / frames as f64);
        let found = virtual_points(offsets, root, &rotations);
        for (error, (truth, found)) in errors.0.iter_mut().zip(truth.iter().zip(&found)) {
            for (a, b) in truth.iter().zip(found) {
                let off = 1e3 * a.distance(*b);
                error.0 = error.0.max(off);
                error.1 += off / (6 * frames) as f64;
            }
        }
    }
    errors
}

/// Returns the distances between a cycle and the decoded walk of a pack.
pub fn errors_mm(cycle: &Cycle, pack: &Pack<'_>, walk: usize) -> Errors {
    let walk = pack.walk(walk).expect("a walk");
    let avatar = pack
        .subject(walk.subject)
        .and_then(|s| pack.avatar(s.avatar));
    let offsets = avatar.expect("an avatar").skeleton().offsets;
    let clip = pack.clip(walk.clip).and_then(|clip| clip.as_loop());
    let clip = clip.expect("a loop");
    errors_between(cycle, &offsets.map(Vec3::as_dvec3), |phase| {
        let pose = clip.pose(phase as f32);
        let rotations = pose.rotations.map(Quat::as_dquat);
        (pose.root.as_dvec3(), rotations)
    })
}

/// Encodes the only walk of a person, and returns the pack and the distances.
pub fn error_of(subject: &Subject, max_error_mm: f64) -> (Vec<u8>, Errors) {
    let bytes = encoded(std::slice::from_ref(subject), max_error_mm);
    let errors = errors_mm(motion(&subject.walks[0]), &parsed(&bytes), 0);
    (bytes, errors)
}

/// Parses a pack.
pub fn parsed(bytes: &[u8]) -> Pack<'_> {
    Pack::parse(bytes).expect("a pack")
}

/// Returns the first clip, which is a loop.
pub fn first_loop<'a>(pack: &Pack<'a>) -> Loop<'a> {
    let clip = pack.clip(0).expect("a clip");
    clip.as_loop().expect("a loop")
}

/// Returns the bytes of all clips of a pack, with the mean walks that they need.
pub fn clip_bytes(pack: &Pack<'_>) -> usize {
    let clips: usize = (0..pack.clip_count())
        .filter_map(|index| pack.clip(index))
        .map(|clip| clip.len_bytes())
        .sum();
    let [.., templates, _] = pack.section_bytes();
    clips + templates
}

/// Asserts that a number of a pack, rounded up to hundredths, states the truth.
pub fn assert_stated(stated: f32, truth: f64, what: &str) {
    let stated = f64::from(stated);
    assert!(
        stated > truth - 1e-3 && stated < truth + 0.011,
        "{what}: {stated} stated, {truth} found"
    );
}
