use std::io::Cursor;
use std::path::Path;

use glam::DMat4;

use super::*;

const TWO_JOINTS: &str = "HIERARCHY
ROOT Hips
{
  OFFSET 7 8 9
  CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation
  JOINT Left Leg
  {
    OFFSET 1 -2 3
    CHANNELS 3 Yrotation Zrotation Xrotation
    End Site
    {
      OFFSET 0 -4 0
    }
  }
}
MOTION
Frames: 2
Frame Time: 0.01
1 2 3 30 40 50 10 20 70
1 2 3 0 0 0 0 0 0
";

fn parse(text: &str) -> Result<Motion> {
    let bytes = Cursor::new(text.to_owned().into_bytes());
    read(Lines::over(Path::new("t.bvh"), Box::new(bytes)), None)
}

fn problem(text: &str) -> String {
    parse(text).unwrap_err().to_string()
}

#[test]
fn kinematics_equal_a_product_of_matrices_in_channel_order() {
    let motion = parse(TWO_JOINTS).unwrap();
    let d = f64::to_radians;
    let root = DMat4::from_translation(DVec3::new(1.0, 2.0, 3.0))
        * DMat4::from_rotation_z(d(30.0))
        * DMat4::from_rotation_x(d(40.0))
        * DMat4::from_rotation_y(d(50.0));
    let leg = root
        * DMat4::from_translation(DVec3::new(1.0, -2.0, 3.0))
        * DMat4::from_rotation_y(d(10.0))
        * DMat4::from_rotation_z(d(20.0))
        * DMat4::from_rotation_x(d(70.0));
    let (positions, rotations) = motion.globals(0);
    assert_eq!(positions[0], DVec3::new(1.0, 2.0, 3.0));
    assert!(positions[1].distance(leg.transform_point3(DVec3::ZERO)) < 1e-12);
    let tip = positions[1] + rotations[1] * motion.joints[1].end.unwrap();
    assert!(tip.distance(leg.transform_point3(DVec3::new(0.0, -4.0, 0.0))) < 1e-12);
    assert_eq!(motion.joints[1].name, "Left Leg");
    assert!((motion.sample_rate_hz - 100.0).abs() < 1e-9);
}

#[test]
fn spelling_does_not_matter() {
    let plain = parse(TWO_JOINTS).unwrap();
    for text in [
        TWO_JOINTS.to_lowercase().replace("left leg", "Left Leg"),
        TWO_JOINTS.replace('\n', "\r\n"),
        TWO_JOINTS.replace('\n', "\r"),
        TWO_JOINTS.replace("  ", "\t"),
        TWO_JOINTS.replace("\n{", " {"),
        TWO_JOINTS.replace(" 70", " +7.0E+01"),
    ] {
        assert_eq!(parse(&text).unwrap().frames, plain.frames, "{text}");
    }
}

#[test]
fn position_channels_of_a_joint_replace_its_offset() {
    let text = TWO_JOINTS
        .replace("CHANNELS 3", "CHANNELS 6 Xposition Yposition Zposition")
        .replace("50 10", "50 1 -2 3 10")
        .replace("0 0 0 0 0 0", "0 0 0 5 5 5 0 0 0");
    let motion = parse(&text).unwrap();
    assert_eq!(motion.globals(0), parse(TWO_JOINTS).unwrap().globals(0));
    assert_eq!(motion.globals(1).0[1], DVec3::new(6.0, 7.0, 8.0));
}

#[test]
fn bones_are_where_offsets_or_positions_state_them() {
    let both = TWO_JOINTS
        .replace("CHANNELS 3", "CHANNELS 6 Xposition Yposition Zposition")
        .replace("50 10", "50 1 -2 3 10")
        .replace("0 0 0 0 0 0", "0 0 0 1 -2 3 0 0 0");
    let plain = parse(&both).unwrap();
    assert!(plain.warnings.is_empty(), "{:?}", plain.warnings);
    for (text, warning) in [
        (
            both.replace("OFFSET 1 -2 3", "OFFSET 0 0 0"),
            "OFFSETs of 1 joints are 0",
        ),
        (both.replace(" 1 -2 3 ", " 0 0 0 "), "are all 0"),
    ] {
        let motion = parse(&text).unwrap();
        assert_eq!(motion.joints, plain.joints);
        assert_eq!(motion.globals(0), plain.globals(0));
        assert!(
            motion.warnings[0].contains(warning),
            "{:?}",
            motion.warnings
        );
    }
}

#[test]
fn broken_files_are_refused_where_they_break() {
    let replaced = |from: &str, to: &str| problem(&TWO_JOINTS.replacen(from, to, 1));
    assert_eq!(
        replaced("20 70", "20"),
        "t.bvh:19: frame 0: expected 9 values in the row, found 8"
    );
    assert_eq!(
        replaced("20 70", "20 nan"),
        "t.bvh:19: frame 0, Xrotation of Left Leg: expected a finite number, found `nan`"
    );
    assert_eq!(
        replaced("Frames: 2", "Frames: 4000000000"),
        "t.bvh:21: expected 4000000000 frames, found 2 (is the file truncated?)"
    );
    assert_eq!(
        replaced("}\nMOTION", "MOTION"),
        "t.bvh:15: MOTION inside of 1 open braces"
    );
    assert_eq!(
        replaced("CHANNELS 3", "CHANNELS 4"),
        "t.bvh:9: expected 4 channel names, found 3"
    );
    assert_eq!(replaced("0.01", "0").split(": ").count(), 2);
    assert_eq!(problem(""), "t.bvh: the file is empty");
}

#[test]
fn a_chain_of_four_thousand_joints_is_read_and_a_longer_one_refused() {
    let chain = |joints: usize| {
        let mut text = "HIERARCHY\nROOT r\n{\n".to_owned();
        text += &"JOINT j\n{\nOFFSET 0 1 0\n".repeat(joints - 1);
        text += &"}\n".repeat(joints);
        text + "MOTION\nFrames: 0\nFrame Time: 0.01\n"
    };
    assert!(problem(&chain(4096)).contains("no frames"));
    assert!(problem(&chain(4097)).contains("more than 4096 joints"));
}
