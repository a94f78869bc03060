//! The Acclaim motion file (AMC): one line per bone per frame.
//!
//! The values of a bone follow the degrees of freedom of its skeleton; `rx ry rz` means
//! Rz * Ry * Rx. A frame that lacks a bone is an error, and so is a gap in the frame numbers, which
//! would silently compress the timing. Numbers may advance by a constant step.

use std::collections::HashMap;

use glam::{DQuat, DVec3};

use super::asf::{AsfSkeleton, Drive, Freedom};
use super::lines::{Lines, finite, shown};
use super::{Motion, MotionFormat, SourceFrame};
use crate::error::{Error, Result};

/// Assumed frame rate of an AMC, which states none: CMU's usual rate.
const DEFAULT_RATE_HZ: f64 = 120.0;

/// Largest constant step of frame numbers: one frame a second at the usual rate.
const LARGEST_STEP: i64 = 120;

/// A frame that is being filled.
struct Partial {
    number: i64,
    line: usize,
    frame: SourceFrame,
    seen: Vec<bool>,
}

/// Reads a whole file.
///
/// # Errors
/// For unknown or repeated bones, incomplete frames, uneven frame numbers, and values that are not
/// finite numbers.
pub(super) fn read(mut lines: Lines, skeleton: AsfSkeleton) -> Result<Motion> {
    let AsfSkeleton {
        joints,
        drives,
        unit_m,
        angle,
        mut warnings,
    } = skeleton;
    let names: HashMap<&str, usize> = joints
        .iter()
        .enumerate()
        .map(|(index, joint)| (joint.name.as_str(), index))
        .collect();
    let mut stated_angle = None;
    let mut frames = Vec::new();
    let mut partial: Option<Partial> = None;
    let mut step: Option<i64> = None;
    // Two frames show no constant step.
    let mut first_skip = None;
    while let Some(line) = lines.next_line()? {
        if line.starts_with('#') {
            continue;
        }
        if let Some(keyword) = line.strip_prefix(':') {
            match keyword.trim().to_ascii_uppercase().as_str() {
                "DEGREES" => stated_angle = Some(1f64.to_radians()),
                "RADIANS" => stated_angle = Some(1.0),
                _ => {}
            }
            continue;
        }
        let mut words = line.split_whitespace();
        let first = words.next().unwrap_or_default();
        if let Ok(number) = first.parse::<i64>() {
            let started = Partial {
                number,
                line: lines.number(),
                frame: SourceFrame {
                    root: DVec3::ZERO,
                    rotations: vec![DQuat::IDENTITY; joints.len()],
                    offsets: None,
                },
                seen: drives
                    .iter()
                    .map(|drive| drive.freedoms.is_empty())
                    .collect(),
            };
            if let Some(done) = partial.replace(started) {
                let found = number.saturating_sub(done.number);
                let step = *step.get_or_insert(found.clamp(1, LARGEST_STEP));
                if frames.is_empty() && step > 1 {
                    let expected = done.number.saturating_add(1);
                    let problem = format!("expected frame {expected}, found {number}");
                    first_skip = Some(lines.error(problem));
                }
                if found != step {
                    let expected = done.number.saturating_add(step);
                    return Err(lines.error(format!("expected frame {expected}, found {number}")));
                }
                frames.push(complete(&lines, done, &joints)?);
            }
            continue;
        }
        let Some(partial) = partial.as_mut() else {
            return Err(lines.error(format!("expected a frame number, found `{}`", shown(first))));
        };
        let Some(&joint) = names.get(first) else {
            return Err(lines.error(format!("no bone `{}` in the ASF", shown(first))));
        };
        let number = partial.number;
        let drive = &drives[joint];
        if drive.freedoms.is_empty() || std::mem::replace(&mut partial.seen[joint], true) {
            return Err(lines.error(format!(
                "frame {number}: `{first}` is repeated or has no degrees of freedom"
            )));
        }
        let values: Vec<f64> = words
            .map(finite)
            .collect::<std::result::Result<_, String>>()
            .map_err(|problem| lines.error(format!("frame {number}, `{first}`: {problem}")))?;
        if values.len() != drive.freedoms.len() {
            return Err(lines.error(format!(
                "frame {number}, `{first}`: expected {} values, found {}",
                drive.freedoms.len(),
                values.len()
            )));
        }
        let radians = stated_angle.unwrap_or(angle);
        apply(drive, &values, radians, joint, &mut partial.frame);
    }
    match partial.take() {
        Some(done) => frames.push(complete(&lines, done, &joints)?),
        None => return Err(Error::input(lines.path(), "the motion has no frames")),
    }
    if stated_angle.is_none() {
        warnings.push("the AMC states no unit of angle: the ASF's is used".into());
    }
    if let Some(skip) = first_skip
        && frames.len() < 3
    {
        return Err(skip);
    }
    let step = step.unwrap_or(1);
    if step > 1 {
        warnings.push(format!(
            "frame numbers advance by {step}: one of {step} frames was kept"
        ));
    }
    Ok(Motion {
        format: MotionFormat::AsfAmc,
        joints,
        sample_rate_hz: DEFAULT_RATE_HZ / step as f64,
        frames,
        unit_m,
        skin: None,
        warnings,
    })
}

/// Puts one bone's values into the frame.
fn apply(drive: &Drive, values: &[f64], radians: f64, joint: usize, frame: &mut SourceFrame) {
    let mut motion = DQuat::IDENTITY;
    for (freedom, value) in drive.freedoms.iter().zip(values) {
        match *freedom {
            Freedom::Translation(axis) => frame.root[axis] = *value,
            Freedom::Rotation(axis) => {
                motion = DQuat::from_axis_angle(DVec3::AXES[axis], value * radians) * motion;
            }
        }
    }
    frame.rotations[joint] = drive.axes * motion * drive.axes.inverse();
}

/// Returns the frame, if every bone with degrees of freedom has values.
fn complete(lines: &Lines, done: Partial, joints: &[super::SourceJoint]) -> Result<SourceFrame> {
    match done.seen.iter().position(|seen| !seen) {
        None => Ok(done.frame),
        Some(missing) => Err(Error::at(
            lines.path(),
            crate::error::FilePlace::Line(done.line),
            format!(
                "frame {} lacks the bone `{}` (is the file truncated?)",
                done.number,
                shown(&joints[missing].name)
            ),
        )),
    }
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;
    use std::path::Path;

    use glam::DMat4;

    use super::super::asf;
    use super::*;

    const ASF: &str = ":units
  length 0.45
  angle deg
:root
  order TX TY TZ RX RY RZ
  axis XYZ
  position 0 0 0
  orientation 0 0 0
:bonedata
  begin
    name thigh
    direction 0.6 -0.8 0
    length 5
    axis 10 20 30 XYZ
    dof rx ry rz
  end
  begin
    name shank
    direction 0 -1 0
    length 2
    axis 0 0 40 XYZ
    dof rx
  end
:hierarchy
  begin
    root thigh
    thigh shank
  end
";
    const AMC: &str = "#!OML
:FULLY-SPECIFIED
:DEGREES
1
root 1 2 3 4 5 6
thigh 7 8 9
shank 50
2
root 1 2 3 0 0 0
thigh 0 0 0
shank 0
";

    fn lines(name: &str, text: &str) -> Lines {
        Lines::over(
            Path::new(name),
            Box::new(Cursor::new(text.to_owned().into_bytes())),
        )
    }

    fn parse(asf: &str, amc: &str) -> Result<Motion> {
        read(lines("t.amc", amc), asf::read(lines("t.asf", asf))?)
    }

    /// Returns Rz * Ry * Rx for angles in degrees.
    fn turn(x: f64, y: f64, z: f64) -> DMat4 {
        DMat4::from_rotation_z(z.to_radians())
            * DMat4::from_rotation_y(y.to_radians())
            * DMat4::from_rotation_x(x.to_radians())
    }

    #[test]
    fn kinematics_equal_a_product_of_matrices() {
        let motion = parse(ASF, AMC).unwrap();
        let move_by = |x, y, z| DMat4::from_translation(DVec3::new(x, y, z));
        let root = move_by(1.0, 2.0, 3.0) * turn(4.0, 5.0, 6.0);
        let c = turn(10.0, 20.0, 30.0);
        let thigh = root * c * turn(7.0, 8.0, 9.0) * c.inverse();
        let c = turn(0.0, 0.0, 40.0);
        let knee = thigh * move_by(3.0, -4.0, 0.0);
        let shank = knee * c * turn(50.0, 0.0, 0.0) * c.inverse();
        let ankle = shank.transform_point3(DVec3::new(0.0, -2.0, 0.0));

        let (positions, rotations) = motion.globals(0);
        assert!(positions[2].distance(knee.transform_point3(DVec3::ZERO)) < 1e-12);
        let tip = positions[2] + rotations[2] * motion.joints[2].end.unwrap();
        assert!(tip.distance(ankle) < 1e-12);
        assert!((motion.unit_m.unwrap() - 0.056_444_4).abs() < 1e-6);
    }

    #[test]
    fn radians_and_degrees_give_the_same_motion() {
        let radians = AMC
            .replace(":DEGREES", ":RADIANS")
            .replace(
                "4 5 6",
                "0.06981317007977318 0.08726646259971647 0.10471975511965977",
            )
            .replace(
                "7 8 9",
                "0.12217304763960307 0.13962634015954636 0.15707963267948966",
            )
            .replace("shank 50", "shank 0.8726646259971648");
        let (a, b) = (parse(ASF, AMC).unwrap(), parse(ASF, &radians).unwrap());
        assert!(a.globals(0).0[2].distance(b.globals(0).0[2]) < 1e-12);
    }

    #[test]
    fn a_constant_step_of_frame_numbers_divides_the_rate() {
        let third = AMC.split_once("\n2\n").expect("two frames").1;
        let motion = parse(ASF, &(AMC.replace("\n2\n", "\n4\n") + "7\n" + third)).unwrap();
        assert_eq!((motion.frames.len(), motion.sample_rate_hz), (3, 40.0));
        assert!(
            motion.warnings[0].contains("advance by 3"),
            "{:?}",
            motion.warnings
        );
    }

    #[test]
    fn missing_units_are_assumed_with_a_warning() {
        let asf = ASF.replace("  length 0.45\n  angle deg\n", "");
        let motion = parse(&asf, &AMC.replace(":DEGREES\n", "")).unwrap();
        assert_eq!(motion.warnings.len(), 3, "{:?}", motion.warnings);
        assert_eq!(motion.unit_m, None);
    }

    #[test]
    fn broken_files_are_refused_where_they_break() {
        let problem = |asf: &str, amc: &str| parse(asf, amc).unwrap_err().to_string();
        for (from, to, expected) in [
            (
                "shank 50\n",
                "",
                "t.amc:4: frame 1 lacks the bone `shank` (is the file truncated?)",
            ),
            (
                "shank 0\n",
                "",
                "t.amc:8: frame 2 lacks the bone `shank` (is the file truncated?)",
            ),
            ("\n2\n", "\n4\n", "t.amc:8: expected frame 2, found 4"),
            ("\n2\n", "\n1\n", "t.amc:8: expected frame 2, found 1"),
            ("shank 50", "tail 50", "t.amc:7: no bone `tail` in the ASF"),
            (
                "7 8 9",
                "7 8",
                "t.amc:6: frame 1, `thigh`: expected 3 values, found 2",
            ),
        ] {
            assert_eq!(problem(ASF, &AMC.replacen(from, to, 1)), expected);
        }
        let cycle = ASF.replace("thigh shank\n", "thigh shank\n shank thigh\n");
        assert_eq!(
            problem(&cycle, AMC),
            "t.asf:28: `thigh` has a second parent (a cycle?)"
        );
        let island = ASF
            .replace("root thigh\n", "")
            .replace("thigh shank\n", "thigh shank\n shank thigh\n");
        assert!(problem(&island, AMC).contains("2 bones are not connected to the root"));
        let zero = ASF.replace("0.6 -0.8 0", "0 0 0");
        assert_eq!(
            problem(&zero, AMC),
            "t.asf:12: the bone's direction is zero"
        );
    }
}
