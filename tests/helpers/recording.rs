//! A synthetic recording as a BVH file.

use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// The joints of the recording: depth, name, and offset from the parent in cm. Arms and legs hang;
/// the left arm is `LeftArm`.
const JOINTS_OF_FILE: [(usize, &str, [i32; 3]); 16] = [
    (0, "Hips", [0, 0, 0]),
    (1, "Spine", [0, 15, 0]),
    (2, "Neck", [0, 35, 0]),
    (3, "Head", [0, 10, 0]),
    (2, "LeftArm", [20, 30, 0]),
    (3, "LeftForeArm", [0, -28, 0]),
    (4, "LeftHand", [0, -25, 0]),
    (2, "RightArm", [-20, 30, 0]),
    (3, "RightForeArm", [0, -28, 0]),
    (4, "RightHand", [0, -25, 0]),
    (1, "LeftUpLeg", [10, 0, 0]),
    (2, "LeftLeg", [0, -45, 0]),
    (3, "LeftFoot", [0, -45, 0]),
    (1, "RightUpLeg", [-10, 0, 0]),
    (2, "RightLeg", [0, -45, 0]),
    (3, "RightFoot", [0, -45, 0]),
];

/// Writes a BVH file of a person who walks 1 m and two steps a second for 3 s, at 120 frames a
/// second, and whose pelvis sinks. Joints get the stated angles about y, x and z, degrees.
pub fn walk(
    folder: &Path,
    name: &str,
    sinks_cm_s: f64,
    angles: impl Fn(&str, usize) -> Option<[f64; 3]>,
) -> PathBuf {
    let mut text = String::from("HIERARCHY\n");
    for (index, (depth, joint, [x, y, z])) in JOINTS_OF_FILE.iter().enumerate() {
        let (kind, place) = if index == 0 {
            ("ROOT", "6 Xposition Yposition Zposition")
        } else {
            ("JOINT", "3")
        };
        let _ = writeln!(
            text,
            "{kind} {joint}\n{{\nOFFSET {x} {y} {z}\nCHANNELS {place} Yrotation Xrotation Zrotation"
        );
        let next = JOINTS_OF_FILE.get(index + 1).map_or(0, |next| next.0);
        if next <= *depth {
            let [y, z] = if joint.contains("Foot") {
                [-5, 15]
            } else {
                [10 * y.signum(), 0]
            };
            let _ = writeln!(text, "End Site\n{{\nOFFSET 0 {y} {z}\n}}");
            let _ = writeln!(text, "{}", "}\n".repeat(1 + depth - next).trim_end());
        }
    }
    let _ = writeln!(text, "MOTION\nFrames: 361\nFrame Time: 0.00833333333");
    for frame in 0..361 {
        let seconds = frame as f64 / 120.0;
        let swing = 23.0 * (TAU * seconds).sin();
        let _ = write!(
            text,
            "0 {} {} 0 0 0",
            97.0 - sinks_cm_s * seconds,
            100.0 * seconds
        );
        for (_, joint, _) in &JOINTS_OF_FILE[1..] {
            let usual = match *joint {
                "LeftUpLeg" => [0.0, -swing, 0.0],
                "RightUpLeg" => [0.0, swing, 0.0],
                _ => [0.0; 3],
            };
            let [y, x, z] = angles(joint, frame).unwrap_or(usual);
            let _ = write!(text, " {y} {x} {z}");
        }
        text.push('\n');
    }
    let path = folder.join(name);
    std::fs::write(&path, text).expect("a file");
    path
}
