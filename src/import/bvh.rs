//! Reader of the Biovision hierarchy (BVH): a skeleton and its motion in one text file.
//!
//! There is no standard beyond Biovision's own files, as described by Meredith & Maddock (2001),
//! "Motion Capture File Formats Explained", University of Sheffield. Rotations apply in the order
//! of the channels, the first outermost. Position channels replace the joint's OFFSET; a root's
//! OFFSET beside position channels is redundant and often not zero.

use std::collections::HashSet;
use std::fmt;

use glam::{DQuat, DVec3};

use super::lines::{Lines, finite, shown};
use super::{Motion, MotionFormat, SourceFrame, SourceJoint};
use crate::error::{Error, Remedy, Result};

#[cfg(test)]
mod tests;

/// The maximum number of joints accepted. Our choice: an avatar with face and fingers has 101.
const MAX_JOINTS: usize = 4096;

/// A column of the motion table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum BvhChannel {
    /// Position along the axis of this index, source units.
    Position(usize),
    /// Rotation about the axis of this index, degrees.
    Rotation(usize),
}

impl BvhChannel {
    fn parse(name: &str) -> Option<Self> {
        let lower = name.to_ascii_lowercase();
        let axis = match lower.as_bytes().first()? {
            b'x' => 0,
            b'y' => 1,
            b'z' => 2,
            _ => return None,
        };
        match lower.get(1..)? {
            "position" => Some(Self::Position(axis)),
            "rotation" => Some(Self::Rotation(axis)),
            _ => None,
        }
    }
}

impl fmt::Display for BvhChannel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (axis, kind) = match self {
            Self::Position(axis) => (axis, "position"),
            Self::Rotation(axis) => (axis, "rotation"),
        };
        write!(f, "{}{kind}", ["X", "Y", "Z"][*axis])
    }
}

/// The skeleton with the columns of its motion table: `(joint, channel)` each.
#[derive(Default)]
struct Hierarchy {
    joints: Vec<SourceJoint>,
    columns: Vec<(usize, BvhChannel)>,
}

/// The owner of an open brace.
#[derive(Clone, Copy, PartialEq, Eq)]
enum OpenBlock {
    Joint(usize),
    End(usize),
}

/// Reads a whole file. A frame rate from the user prevails over the file's frame time.
///
/// # Errors
/// For anything but a complete hierarchy with full rows of finite numbers, and for more declared
/// rows than present (a truncated file).
pub(super) fn read(mut lines: Lines, given_hz: Option<f64>) -> Result<Motion> {
    let mut hierarchy = read_hierarchy(&mut lines)?;
    let mut warnings = name_warnings(&hierarchy.joints);
    let declared = read_frame_count(&mut lines)?;
    let sample_rate_hz = read_rate_hz(&mut lines, given_hz)?;
    let mut frames = Vec::new();
    while let Some(row) = lines.next_line()? {
        frames.push(read_row(&lines, &hierarchy, &row, frames.len())?);
    }
    let found = frames.len() as u64;
    if found == 0 {
        return Err(lines.error("the motion has no frames"));
    }
    if found < declared {
        return Err(lines.error(format!(
            "expected {declared} frames, found {found} (is the file truncated?)"
        )));
    }
    if found > declared {
        warnings.push(format!(
            "{declared} frames declared, {found} present: all are used"
        ));
    }
    settle_bones(&mut hierarchy, &mut frames, &mut warnings);
    Ok(Motion {
        format: MotionFormat::Bvh,
        joints: hierarchy.joints,
        sample_rate_hz,
        frames,
        unit_m: None,
        skin: None,
        warnings,
    })
}

/// Reads up to and including the `MOTION` line.
fn read_hierarchy(lines: &mut Lines) -> Result<Hierarchy> {
    match lines.next_line()? {
        Some(first) if first.eq_ignore_ascii_case("HIERARCHY") => {}
        Some(first) => {
            return Err(lines.error(format!("expected HIERARCHY, found `{}`", shown(&first))));
        }
        None => return Err(Error::input(lines.path(), "the file is empty")),
    }
    let mut hierarchy = Hierarchy::default();
    let mut open: Vec<OpenBlock> = Vec::new();
    let mut announced: Option<OpenBlock> = None;
    loop {
        let Some(line) = lines.next_line()? else {
            return Err(lines.error("expected MOTION, found the end of the file"));
        };
        // A brace may share a line with the keyword that it opens.
        let (line, opens) = match line.strip_suffix('{') {
            Some(head) => (head.trim_end().to_owned(), true),
            None => (line, false),
        };
        let (keyword, rest) = line
            .split_once(char::is_whitespace)
            .map_or((line.as_str(), ""), |(keyword, rest)| {
                (keyword, rest.trim())
            });
        let keyword = keyword.to_ascii_uppercase();
        if announced.is_some() && !keyword.is_empty() {
            return Err(lines.error(format!("expected {{, found `{}`", shown(&line))));
        }
        match keyword.as_str() {
            "" => {}
            "ROOT" | "JOINT" => {
                let parent = match (keyword.as_str(), open.last()) {
                    ("ROOT", None) if hierarchy.joints.is_empty() => None,
                    ("ROOT", _) => {
                        return Err(lines.error("a second ROOT: expected one walker per file"));
                    }
                    (_, Some(&OpenBlock::Joint(parent))) => Some(parent),
                    _ => return Err(lines.error("a JOINT outside of a joint's braces")),
                };
                if hierarchy.joints.len() == MAX_JOINTS {
                    return Err(lines.error(format!("more than {MAX_JOINTS} joints")));
                }
                announced = Some(OpenBlock::Joint(hierarchy.joints.len()));
                hierarchy.joints.push(SourceJoint {
                    name: rest.to_owned(),
                    parent,
                    offset: DVec3::ZERO,
                    end: None,
                });
            }
            "END" => match open.last() {
                Some(&OpenBlock::Joint(joint)) => announced = Some(OpenBlock::End(joint)),
                _ => return Err(lines.error("an End Site outside of a joint's braces")),
            },
            "OFFSET" => {
                let offset = read_offset(lines, rest)?;
                match open.last() {
                    Some(&OpenBlock::Joint(joint)) => hierarchy.joints[joint].offset = offset,
                    Some(&OpenBlock::End(joint)) => hierarchy.joints[joint].end = Some(offset),
                    None => return Err(lines.error("an OFFSET outside of braces")),
                }
            }
            "CHANNELS" => match open.last() {
                Some(&OpenBlock::Joint(joint)) => {
                    read_channels(lines, &mut hierarchy, joint, rest)?;
                }
                _ => return Err(lines.error("CHANNELS outside of a joint's braces")),
            },
            "}" if rest.is_empty() => {
                if open.pop().is_none() {
                    return Err(lines.error("an unmatched closing brace"));
                }
            }
            "MOTION" => {
                if !open.is_empty() {
                    let count = open.len();
                    return Err(lines.error(format!("MOTION inside of {count} open braces")));
                }
                if hierarchy.joints.is_empty() {
                    return Err(lines.error("the hierarchy has no ROOT"));
                }
                return Ok(hierarchy);
            }
            _ => return Err(lines.error(format!("unknown keyword `{}`", shown(&line)))),
        }
        if opens {
            match announced.take() {
                Some(block) => open.push(block),
                None => return Err(lines.error("an opening brace without a keyword")),
            }
        }
    }
}

fn read_offset(lines: &Lines, text: &str) -> Result<DVec3> {
    let values = text
        .split_whitespace()
        .map(finite)
        .collect::<std::result::Result<Vec<f64>, String>>()
        .map_err(|problem| lines.error(problem))?;
    match values.as_slice() {
        &[x, y, z] => Ok(DVec3::new(x, y, z)),
        other => Err(lines.error(format!("expected 3 offsets, found {}", other.len()))),
    }
}

fn read_channels(lines: &Lines, into: &mut Hierarchy, joint: usize, text: &str) -> Result<()> {
    let mut tokens = text.split_whitespace();
    let count = tokens.next().unwrap_or_default();
    let names: Vec<&str> = tokens.collect();
    if count.parse() != Ok(names.len()) {
        return Err(lines.error(format!(
            "expected {} channel names, found {}",
            shown(count),
            names.len()
        )));
    }
    if into.columns.iter().any(|&(owner, _)| owner == joint) {
        return Err(lines.error("a second CHANNELS for one joint"));
    }
    for name in names {
        let channel = BvhChannel::parse(name)
            .ok_or_else(|| lines.error(format!("unknown channel `{}`", shown(name))))?;
        if into.columns.contains(&(joint, channel)) {
            return Err(lines.error(format!("channel {name} twice in one joint")));
        }
        into.columns.push((joint, channel));
    }
    Ok(())
}

/// Reads the value of a `key: value` line of the motion's header.
fn read_header(lines: &mut Lines, key: &str) -> Result<String> {
    let line = lines.next_line()?.unwrap_or_default();
    match line.split_once(':') {
        Some((found, value)) if found.trim().eq_ignore_ascii_case(key) => Ok(value.trim().into()),
        _ => Err(lines.error(format!("expected `{key}: ...`, found `{}`", shown(&line)))),
    }
}

fn read_frame_count(lines: &mut Lines) -> Result<u64> {
    let value = read_header(lines, "Frames")?;
    value.parse().map_err(|_| {
        lines.error(format!(
            "expected a count of frames, found `{}`",
            shown(&value)
        ))
    })
}

/// Reads the frame time and returns the frame rate, Hz.
fn read_rate_hz(lines: &mut Lines, given_hz: Option<f64>) -> Result<f64> {
    let value = read_header(lines, "Frame Time")?;
    if let Some(given_hz) = given_hz {
        return Ok(given_hz);
    }
    match finite(&value) {
        Ok(seconds) if (1e-4..=1.0).contains(&seconds) => Ok(1.0 / seconds),
        _ => {
            let problem = format!(
                "expected a frame time of 0.0001 to 1 seconds, found `{}`",
                shown(&value)
            );
            Err(lines.error(problem).with_remedy(Remedy::StateFrameRate))
        }
    }
}

fn read_row(lines: &Lines, hierarchy: &Hierarchy, row: &str, frame: usize) -> Result<SourceFrame> {
    let joints = &hierarchy.joints;
    let mut offsets: Vec<DVec3> = joints.iter().map(|joint| joint.offset).collect();
    let mut rotations = vec![DQuat::IDENTITY; joints.len()];
    let mut moved = false;
    let mut tokens = row.split_whitespace();
    for (column, &(joint, channel)) in hierarchy.columns.iter().enumerate() {
        let Some(token) = tokens.next() else {
            let expected = hierarchy.columns.len();
            return Err(lines.error(format!(
                "frame {frame}: expected {expected} values in the row, found {column}"
            )));
        };
        let value = finite(token).map_err(|problem| {
            let name = &joints[joint].name;
            lines.error(format!(
                "frame {frame}, {channel} of {}: {problem}",
                shown(name)
            ))
        })?;
        match channel {
            BvhChannel::Position(axis) => {
                offsets[joint][axis] = value;
                moved |= joint > 0;
            }
            BvhChannel::Rotation(axis) => {
                rotations[joint] *= DQuat::from_axis_angle(DVec3::AXES[axis], value.to_radians());
            }
        }
    }
    let surplus = tokens.count();
    if surplus > 0 {
        let expected = hierarchy.columns.len();
        return Err(lines.error(format!(
            "frame {frame}: expected {expected} values in the row, found {}",
            expected + surplus
        )));
    }
    Ok(SourceFrame {
        root: offsets[0],
        rotations,
        offsets: moved.then_some(offsets),
    })
}

/// Settles the lengths of bones that OFFSETs and position channels state differently.
///
/// Converters of FBX leave either at zero. An OFFSET of zero below position channels that hold
/// still is replaced with their place. Position channels that are zero in all joints and frames are
/// not used.
fn settle_bones(hierarchy: &mut Hierarchy, frames: &mut [SourceFrame], warnings: &mut Vec<String>) {
    /// Largest motion of a bone's end over its length; more is a walker in a moving frame. Our
    /// choice.
    const STILL: f64 = 0.05;
    let mut moved: Vec<usize> = hierarchy
        .columns
        .iter()
        .filter(|(joint, channel)| *joint > 0 && matches!(channel, BvhChannel::Position(_)))
        .map(|(joint, _)| *joint)
        .collect();
    moved.dedup();
    let joints = &hierarchy.joints;
    let offset = |frame: &SourceFrame, joint: usize| {
        frame.offsets.as_ref().map_or(DVec3::ZERO, |all| all[joint])
    };
    let is_zero = |joint: &usize| frames.iter().all(|it| offset(it, *joint) == DVec3::ZERO);
    let has_bone = |joint: &usize| joints[*joint].offset != DVec3::ZERO;
    if !moved.is_empty() && moved.iter().all(is_zero) && moved.iter().any(has_bone) {
        warnings.push(
            "the position channels below the root are all 0: the OFFSETs are used instead".into(),
        );
        for frame in frames {
            frame.offsets = None;
        }
        return;
    }
    moved.retain(|joint| !has_bone(joint));
    let mut placed = 0;
    for joint in moved {
        let mean = frames.iter().map(|it| offset(it, joint)).sum::<DVec3>() / frames.len() as f64;
        let apart = frames.iter().map(|it| offset(it, joint).distance(mean));
        if mean != DVec3::ZERO && apart.fold(0.0, f64::max) <= STILL * mean.length() {
            placed += 1;
            hierarchy.joints[joint].offset = mean;
        }
    }
    if placed > 0 {
        warnings.push(format!(
            "the OFFSETs of {placed} joints are 0: their position channels give the bones"
        ));
    }
}

/// Returns warnings about names that several joints share.
fn name_warnings(joints: &[SourceJoint]) -> Vec<String> {
    let mut seen = HashSet::new();
    let mut repeated: Vec<&str> = joints
        .iter()
        .map(|joint| joint.name.as_str())
        .filter(|name| !seen.insert(*name))
        .collect();
    repeated.dedup();
    match repeated.first() {
        None => Vec::new(),
        Some(first) => vec![format!(
            "several joints share a name (`{}` and {} others)",
            shown(first),
            repeated.len() - 1
        )],
    }
}
