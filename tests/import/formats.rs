//! Comparing the joint angles of one take in two files, as in the sources and as imported.
//!
//! An angle is between two segments, from the positions of joints, so that it means the same in any
//! skeleton. Two files of one take that were made with different figures differ already. The import
//! adds the difference between its angles and the file's.

use crate::data::{fixtures, given};
use std::path::Path;

use edgegait::import::Motion;
use edgegait::people::forward_kinematics;
use edgegait::people::retarget::RetargetedMotion;
use edgegait_core::skeleton::Joint;
use glam::DVec3;

const NAMES: [&str; 5] = ["hip", "knee", "ankle", "shoulder", "elbow"];

/// The points of one side that define the angles: hip, knee, ankle, toe, shoulder, elbow, wrist.
type Limbs = [DVec3; 7];

/// Returns the angles in degrees between thigh and trunk, thigh and shank, shank and foot, upper
/// arm and trunk, upper arm and forearm; 0 is straight.
fn angles(sides: &[Limbs; 2], side: usize) -> [f64; 5] {
    let middle = |point: usize| sides[0][point].midpoint(sides[1][point]);
    let trunk = middle(0) - middle(4);
    let [hip, knee, ankle, toe, shoulder, elbow, wrist] = sides[side];
    [
        (trunk, knee - hip),
        (knee - hip, ankle - knee),
        (ankle - knee, toe - ankle),
        (trunk, elbow - shoulder),
        (elbow - shoulder, wrist - elbow),
    ]
    .map(|(a, b)| a.angle_between(b).to_degrees())
}

/// The angles of the left and the right side, by frame.
type Angles = Vec<[f64; 10]>;

fn both(sides: &[Limbs; 2]) -> [f64; 10] {
    let (left, right) = (angles(sides, 0), angles(sides, 1));
    std::array::from_fn(|i| if i < 5 { left[i] } else { right[i - 5] })
}

/// Returns the angles of a file's own joints, given the names of the left and the right side.
fn of_source(motion: &Motion, names: &[[String; 7]; 2]) -> Angles {
    let at = names.each_ref().map(|side| {
        side.each_ref().map(|name| {
            let found = motion.joints.iter().position(|joint| joint.name == *name);
            found.unwrap_or_else(|| panic!("no joint {name}"))
        })
    });
    (0..motion.frames.len())
        .map(|frame| {
            let (positions, _) = motion.globals(frame);
            both(&at.map(|side| side.map(|joint| positions[joint])))
        })
        .collect()
}

/// Returns the angles of the motion on the canonical skeleton, for each frame of the file.
fn of_ours(motion: &Motion) -> (Angles, usize) {
    let take = RetargetedMotion::from_motion(motion, None).unwrap();
    let first = (take.start_s * take.sample_rate_hz).round() as usize;
    use Joint as J;
    let joints = [
        [
            J::LeftThigh,
            J::LeftShank,
            J::LeftFoot,
            J::LeftFoot,
            J::LeftUpperArm,
            J::LeftForearm,
            J::LeftHand,
        ],
        [
            J::RightThigh,
            J::RightShank,
            J::RightFoot,
            J::RightFoot,
            J::RightUpperArm,
            J::RightForearm,
            J::RightHand,
        ],
    ];
    let angles = (0..take.len()).map(|frame| {
        let (at, turned) =
            forward_kinematics(&take.offsets, take.roots[frame], &take.rotations[frame]);
        let mut points = joints.map(|side| side.map(|joint| at[joint.index()]));
        for (side, foot) in [J::LeftFoot, J::RightFoot].into_iter().enumerate() {
            points[side][3] += turned[foot.index()] * DVec3::Z;
        }
        both(&points)
    });
    (angles.collect(), first)
}

/// Returns the standard deviation and the mean of the differences in pairs of frames, over both
/// sides.
fn differences(a: &Angles, b: &Angles, pairs: &[(usize, usize)]) -> [(f64, f64); 5] {
    std::array::from_fn(|angle| {
        let off: Vec<f64> = pairs
            .iter()
            .flat_map(|&(i, j)| [a[i][angle] - b[j][angle], a[i][angle + 5] - b[j][angle + 5]])
            .collect();
        let mean = off.iter().sum::<f64>() / off.len() as f64;
        let square = off.iter().map(|d| (d - mean).powi(2)).sum::<f64>() / off.len() as f64;
        (square.sqrt(), mean)
    })
}

fn named(pattern: [&str; 7]) -> [[String; 7]; 2] {
    [["l", "L", "Left"], ["r", "R", "Right"]].map(|[small, letter, word]| {
        pattern.map(|name| {
            let name = name.replace("{s}", small).replace("{L}", letter);
            name.replace("{Left}", word)
        })
    })
}

/// The names of hip, knee, ankle, toe, shoulder, elbow and wrist in each family of skeletons.
const ASF: [&str; 7] = [
    "{s}femur",
    "{s}tibia",
    "{s}foot",
    "{s}toes",
    "{s}humerus",
    "{s}radius",
    "{s}wrist",
];
const CHARACTER_CREATOR: [&str; 7] = [
    "CC_Base_{L}_Thigh",
    "CC_Base_{L}_Calf",
    "CC_Base_{L}_Foot",
    "CC_Base_{L}_ToeBase",
    "CC_Base_{L}_Upperarm",
    "CC_Base_{L}_Forearm",
    "CC_Base_{L}_Hand",
];
const MAX_131: [&str; 7] = [
    "{Left}Hip",
    "{Left}Knee",
    "{Left}Ankle",
    "{Left}Toe",
    "{Left}Shoulder",
    "{Left}Elbow",
    "{Left}Wrist",
];

/// Returns the shift of the second file's frames at which the knees agree best, and the pairs of
/// frames. The first file has `step` frames for one of the second.
fn aligned(a: &Angles, b: &Angles, step: usize) -> (i64, Vec<(usize, usize)>) {
    let pairs = |shift: i64| -> Vec<(usize, usize)> {
        let at = |j: usize| usize::try_from((step * j) as i64 + shift).ok();
        let pairs = (0..b.len()).filter_map(|j| Some((at(j)?, j)));
        pairs.filter(|(i, _)| *i < a.len()).collect()
    };
    let knees = |shift: &i64| differences(a, b, &pairs(*shift))[1].0;
    let best = (-8..=8).min_by(|x, y| knees(x).total_cmp(&knees(y)));
    let shift = best.unwrap_or_default();
    (shift, pairs(shift))
}

/// Two files of one take, with the names of their joints, and the number of frames in the first for
/// one of the second.
type Pair = (
    (&'static str, [&'static str; 7]),
    (&'static str, [&'static str; 7]),
    usize,
);

const PAIRS: [Pair; 3] = [
    (
        ("cmu_amc/s02/02_01.amc", ASF),
        ("cmu_bvh_retargeted/s02/002_01.bvh", CHARACTER_CREATOR),
        2,
    ),
    (
        ("cmu_amc/s07/07_01.amc", ASF),
        ("cmu_bvh_retargeted/s07/007_01.bvh", CHARACTER_CREATOR),
        2,
    ),
    (
        ("cmu_bvh/s131/131_01.bvh", MAX_131),
        ("cmu_bvh/s131/131_01_m.bvh", MAX_131),
        1,
    ),
];

fn check_pairs(data: &Path, pairs: &[Pair]) {
    let clips = data.join("mocap/clips");
    for &((one, one_names), (two, two_names), step) in pairs {
        let [a, b] = [one, two].map(|file| Motion::read(clips.join(file)).unwrap());
        let sources = [
            of_source(&a, &named(one_names)),
            of_source(&b, &named(two_names)),
        ];
        let ours = [of_ours(&a), of_ours(&b)];
        let (shift, pairs) = aligned(&sources[0], &sources[1], step);
        let between_files = differences(&sources[0], &sources[1], &pairs);
        let inside: Vec<(usize, usize)> = pairs
            .iter()
            .filter_map(|&(i, j)| Some((i.checked_sub(ours[0].1)?, j.checked_sub(ours[1].1)?)))
            .filter(|&(i, j)| i < ours[0].0.len() && j < ours[1].0.len())
            .collect();
        let between_ours = differences(&ours[0].0, &ours[1].0, &inside);
        let own = [0, 1].map(|file| {
            let (angles, first) = &ours[file];
            let same: Vec<_> = (0..angles.len())
                .map(|frame| (frame + first, frame))
                .collect();
            differences(&sources[file], angles, &same)
        });
        eprintln!(
            "{one} and {two}, {} frames, shift {shift}\ndegrees, standard deviation (mean)\n{:<10}{:>16}{:>16}{:>16}{:>16}",
            pairs.len(),
            "angle",
            "file - file",
            "ours - ours",
            "file 1 - ours",
            "file 2 - ours"
        );
        for (angle, name) in NAMES.iter().enumerate() {
            let show = |(spread, mean): (f64, f64)| format!("{spread:.2} ({mean:+.2})");
            eprintln!(
                "{name:<10}{:>16}{:>16}{:>16}{:>16}",
                show(between_files[angle]),
                show(between_ours[angle]),
                show(own[0][angle]),
                show(own[1][angle])
            );
            // The difference that the import adds: a foot may turn about its length relative to the
            // toe's line.
            let allowed = if *name == "ankle" { 2.5 } else { 0.1 };
            for (spread, _) in own.iter().map(|own| own[angle]) {
                assert!(spread < allowed, "{one} {name}: {spread}");
            }
            let more = between_ours[angle].0 - between_files[angle].0;
            assert!(more < allowed, "{one} {name}: {more} more than the files");
        }
    }
}

#[test]
fn one_take_in_two_files_gives_angles_that_differ_as_the_files_do() {
    check_pairs(&fixtures(), &PAIRS[..1]);
}

mod with_data {
    use super::*;

    #[test]
    #[ignore = "needs EDGEGAIT_DATA"]
    fn one_take_in_two_files_gives_angles_that_differ_as_the_files_do() {
        check_pairs(&given(), &PAIRS);
    }
}
