//! A simple figure to import.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

/// Writes a figure that stands and turns round once, as BVH: centimetres, Y up, 50 frames a second.
pub fn write_turning_figure(path: &Path, frames: u32) {
    // Name, depth and offset, parents first.
    let joints = [
        ("Hips", 0, [0, 0, 0]),
        ("LeftUpLeg", 1, [10, 0, 0]),
        ("LeftLeg", 2, [0, -45, 0]),
        ("LeftFoot", 3, [0, -45, 0]),
        ("LeftToe", 4, [0, -5, 15]),
        ("RightUpLeg", 1, [-10, 0, 0]),
        ("RightLeg", 2, [0, -45, 0]),
        ("RightFoot", 3, [0, -45, 0]),
        ("RightToe", 4, [0, -5, 15]),
        ("Chest", 1, [0, 22, 0]),
        ("Neck", 2, [0, 28, 0]),
        ("Head", 3, [0, 10, 0]),
        ("LeftArm", 2, [18, 26, 0]),
        ("LeftForeArm", 3, [0, -28, 0]),
        ("LeftHand", 4, [0, -25, 0]),
        ("RightArm", 2, [-18, 26, 0]),
        ("RightForeArm", 3, [0, -28, 0]),
        ("RightHand", 4, [0, -25, 0]),
    ];
    let mut text = String::from("HIERARCHY\n");
    for (index, (name, depth, [x, y, z])) in joints.into_iter().enumerate() {
        let (kind, channels) = if depth == 0 {
            ("ROOT", "6 Xposition Yposition Zposition")
        } else {
            ("JOINT", "3")
        };
        let _ = writeln!(
            text,
            "{kind} {name}\n{{\nOFFSET {x} {y} {z}\nCHANNELS {channels} Zrotation Xrotation Yrotation"
        );
        let next = joints.get(index + 1).map_or(0, |(_, depth, _)| *depth);
        if next <= depth {
            text.push_str("End Site\n{\nOFFSET 0 -5 0\n}\n");
        }
        text.push_str(&"}\n".repeat(depth + 1 - next.min(depth + 1)));
    }
    let _ = writeln!(text, "MOTION\nFrames: {frames}\nFrame Time: 0.02");
    for frame in 0..frames {
        let turned = 360.0 * f64::from(frame) / f64::from(frames);
        let _ = writeln!(text, "30 95 -40 0 0 {turned}{}", " 0".repeat(51));
    }
    fs::write(path, text).expect("a file");
}
