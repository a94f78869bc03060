//! The Acclaim skeleton file (ASF): bones with their own axes.
//!
//! After Lander (1998), "Working with Motion Capture File Formats", Game Developer: a bone's
//! rotation M is about its own axes C, so about world-parallel axes it is C M C^-1. Bones become
//! joints at the bones' starts.

use std::collections::HashMap;
use std::f64::consts::TAU;

use glam::{DQuat, DVec3};

use super::SourceJoint;
use super::lines::{Lines, finite, shown};
use crate::error::{Error, Result};

/// The maximum number of bones accepted. Our choice: CMU's skeletons have 30.
const MAX_BONES: usize = 4096;

/// Metres in an inch. `length 0.45` in CMU's files means that a value times 1/0.45 is in inches
/// (checked against the marker file of 02_01).
const INCH_M: f64 = 0.0254;

/// A skeleton, and the meaning of its bones' values in an AMC.
pub(super) struct AsfSkeleton {
    /// The joints, parents first; joint 0 is the root.
    pub(super) joints: Vec<SourceJoint>,
    /// The drive of each joint.
    pub(super) drives: Vec<Drive>,
    pub(super) unit_m: Option<f64>,
    /// Radians in one unit of angle, for an AMC that does not state its own.
    pub(super) angle: f64,
    pub(super) warnings: Vec<String>,
}

/// The mapping from a joint's values in an AMC to its rotation.
#[derive(Clone, Debug)]
pub(super) struct Drive {
    /// Rotation from world axes to the bone's own.
    pub(super) axes: DQuat,
    /// The degree of freedom of each value in the AMC, in the file's order.
    pub(super) freedoms: Vec<Freedom>,
}

/// A degree of freedom.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Freedom {
    /// Translation along the axis of this index; only the root has it.
    Translation(usize),
    /// Rotation about the axis of this index.
    Rotation(usize),
}

impl Freedom {
    fn parse(token: &str) -> Option<Self> {
        Some(match token.to_ascii_lowercase().as_str() {
            "tx" => Self::Translation(0),
            "ty" => Self::Translation(1),
            "tz" => Self::Translation(2),
            "rx" => Self::Rotation(0),
            "ry" => Self::Rotation(1),
            "rz" => Self::Rotation(2),
            _ => return None,
        })
    }
}

/// A bone as the file states it.
#[derive(Default)]
struct AsfBone {
    name: String,
    direction: Option<DVec3>,
    length: Option<f64>,
    /// Angles in the file's unit, and the order of the axes.
    axis: Option<([f64; 3], [usize; 3])>,
    freedoms: Vec<Freedom>,
}

/// A bone's place in the hierarchy.
struct BoneLink {
    child: String,
    parent: String,
    /// The line that states it.
    line: usize,
}

/// The contents of a file's sections, collected line by line.
#[derive(Default)]
struct Sections {
    bones: Vec<AsfBone>,
    root: AsfBone,
    /// The name of a child bone, the name of its parent, and their line.
    parents: Vec<BoneLink>,
    length: Option<f64>,
    angle: Option<f64>,
    warnings: Vec<String>,
}

/// Reads a whole file.
///
/// # Errors
/// For incomplete bones, bones without a place in the hierarchy, cycles and unknown units.
pub(super) fn read(mut lines: Lines) -> Result<AsfSkeleton> {
    let mut sections = Sections::default();
    let mut section = String::new();
    let mut bone: Option<AsfBone> = None;
    while let Some(line) = lines.next_line()? {
        if line.starts_with('#') {
            continue;
        }
        if let Some(keyword) = line.strip_prefix(':') {
            section = keyword
                .split_whitespace()
                .next()
                .unwrap_or_default()
                .to_ascii_lowercase();
            continue;
        }
        let words: Vec<&str> = line.split_whitespace().collect();
        match section.as_str() {
            "units" => read_unit(&lines, &mut sections, &words)?,
            "root" => read_root(&lines, &mut sections, &words)?,
            "bonedata" => read_bone_line(&lines, &mut sections.bones, &mut bone, &words)?,
            "hierarchy" => match words.as_slice() {
                ["begin" | "end"] => {}
                [parent, children @ ..] => {
                    let line = lines.number();
                    let links = children.iter().map(|child| BoneLink {
                        child: (*child).to_owned(),
                        parent: (*parent).to_owned(),
                        line,
                    });
                    sections.parents.extend(links);
                }
                [] => {}
            },
            "" => return Err(lines.error(format!("expected a section, found `{}`", shown(&line)))),
            _ => {}
        }
    }
    if sections.bones.is_empty() {
        return Err(Error::input(
            lines.path(),
            "no bones: is this an ASF skeleton?",
        ));
    }
    build(&lines, sections)
}

fn numbers<const N: usize>(lines: &Lines, words: &[&str]) -> Result<[f64; N]> {
    let mut values = [0.0; N];
    if words.len() < N {
        return Err(lines.error(format!("expected {N} numbers, found {}", words.len())));
    }
    for (value, word) in values.iter_mut().zip(words) {
        *value = finite(word).map_err(|problem| lines.error(problem))?;
    }
    Ok(values)
}

fn axis_order(lines: &Lines, word: &str) -> Result<[usize; 3]> {
    let order: Vec<usize> = word
        .to_ascii_uppercase()
        .chars()
        .filter_map(|c| "XYZ".find(c))
        .collect();
    match order.as_slice() {
        &[a, b, c] if word.len() == 3 && a != b && b != c && a != c => Ok([a, b, c]),
        _ => Err(lines.error(format!(
            "expected an order like XYZ, found `{}`",
            shown(word)
        ))),
    }
}

fn read_unit(lines: &Lines, sections: &mut Sections, words: &[&str]) -> Result<()> {
    match words {
        ["length", value, ..] => {
            let [length] = numbers(lines, &[value])?;
            if !(1e-3..=1e3).contains(&length) {
                return Err(lines.error(format!("a unit of length of {length} is not usable")));
            }
            sections.length = Some(length);
        }
        ["angle", unit, ..] => {
            sections.angle = Some(match unit.to_ascii_lowercase().as_str() {
                "deg" => 1f64.to_radians(),
                "rad" => 1.0,
                _ => return Err(lines.error(format!("unknown angle unit `{}`", shown(unit)))),
            });
        }
        _ => {}
    }
    Ok(())
}

fn read_root(lines: &Lines, sections: &mut Sections, words: &[&str]) -> Result<()> {
    let root = &mut sections.root;
    match words {
        ["order", freedoms @ ..] => root.freedoms = read_freedoms(lines, freedoms)?,
        ["axis", order] => {
            let order = axis_order(lines, order)?;
            root.axis = Some((root.axis.map_or([0.0; 3], |(angles, _)| angles), order));
        }
        ["orientation", angles @ ..] => {
            let angles = numbers(lines, angles)?;
            root.axis = Some((angles, root.axis.map_or([0, 1, 2], |(_, order)| order)));
        }
        ["position", position @ ..] if numbers::<3>(lines, position)? != [0.0; 3] => {
            let warning = "the ASF's root position is not zero; the AMC's positions replace it";
            sections.warnings.push(warning.into());
        }
        _ => {}
    }
    Ok(())
}

fn read_freedoms(lines: &Lines, words: &[&str]) -> Result<Vec<Freedom>> {
    let mut freedoms = Vec::new();
    for word in words {
        match Freedom::parse(word) {
            Some(freedom) if !freedoms.contains(&freedom) => freedoms.push(freedom),
            _ => {
                let word = shown(word);
                return Err(lines.error(format!("unknown or repeated degree of freedom `{word}`")));
            }
        }
    }
    Ok(freedoms)
}

fn read_bone_line(
    lines: &Lines,
    bones: &mut Vec<AsfBone>,
    open: &mut Option<AsfBone>,
    words: &[&str],
) -> Result<()> {
    let Some(bone) = open.as_mut() else {
        if words != ["begin"] {
            return Err(lines.error(format!(
                "expected begin, found `{}`",
                shown(&words.join(" "))
            )));
        }
        *open = Some(AsfBone::default());
        return Ok(());
    };
    match words {
        ["begin"] => return Err(lines.error("a bone begins inside of another")),
        ["end"] => {
            let Some(bone) = open.take() else {
                return Ok(());
            };
            let complete = bone.direction.is_some() && bone.length.is_some();
            if bone.name.is_empty() || !complete {
                return Err(lines.error("a bone needs a name, a direction and a length"));
            }
            if bone.name == "root" || bones.iter().any(|other| other.name == bone.name) {
                return Err(lines.error(format!("a second bone `{}`", shown(&bone.name))));
            }
            if bones.len() == MAX_BONES {
                return Err(lines.error(format!("more than {MAX_BONES} bones")));
            }
            bones.push(bone);
        }
        ["name", name] => bone.name = (*name).to_owned(),
        ["direction", direction @ ..] => {
            let direction = DVec3::from_array(numbers(lines, direction)?);
            let unit = direction.try_normalize();
            bone.direction = Some(unit.ok_or_else(|| lines.error("the bone's direction is zero"))?);
        }
        ["length", length] => {
            let [length] = numbers(lines, &[length])?;
            if length < 0.0 {
                return Err(lines.error(format!("expected a length of 0 or more, found {length}")));
            }
            bone.length = Some(length);
        }
        ["axis", a, b, c, order] => {
            bone.axis = Some((numbers(lines, &[a, b, c])?, axis_order(lines, order)?));
        }
        ["dof", freedoms @ ..] => {
            bone.freedoms = read_freedoms(lines, freedoms)?;
            if bone
                .freedoms
                .iter()
                .any(|f| matches!(f, Freedom::Translation(_)))
            {
                return Err(lines.error("a bone that changes its length is not supported"));
            }
        }
        // id, limits, bodymass, cofmass: not used.
        _ => {}
    }
    Ok(())
}

/// Returns the rotation by these angles about fixed axes in this order: `XYZ` is Rz * Ry * Rx.
fn fixed_axes(angles: [f64; 3], order: [usize; 3]) -> DQuat {
    let mut rotation = DQuat::IDENTITY;
    for (angle, axis) in angles.into_iter().zip(order) {
        rotation = DQuat::from_axis_angle(DVec3::AXES[axis], angle) * rotation;
    }
    rotation
}

/// Returns the children of the root and of each bone, as numbers from the root on.
fn children(lines: &Lines, sections: &Sections) -> Result<Vec<Vec<usize>>> {
    let index: HashMap<&str, usize> = std::iter::once("root")
        .chain(sections.bones.iter().map(|bone| bone.name.as_str()))
        .enumerate()
        .map(|(index, name)| (name, index))
        .collect();
    let at = |line| crate::error::FilePlace::Line(line);
    let mut children: Vec<Vec<usize>> = vec![Vec::new(); index.len()];
    let mut has_parent = vec![false; index.len()];
    for BoneLink {
        child,
        parent,
        line,
    } in &sections.parents
    {
        let find = |name: &str| {
            index.get(name).copied().ok_or_else(|| {
                let problem = format!("the hierarchy names an unknown bone `{}`", shown(name));
                Error::at(lines.path(), at(*line), problem)
            })
        };
        let (child_index, parent_index) = (find(child)?, find(parent)?);
        if child_index == 0 || std::mem::replace(&mut has_parent[child_index], true) {
            let problem = format!("`{}` has a second parent (a cycle?)", shown(child));
            return Err(Error::at(lines.path(), at(*line), problem));
        }
        children[parent_index].push(child_index);
    }
    Ok(children)
}

/// Orders the bones parents first and turns them into joints.
fn build(lines: &Lines, mut sections: Sections) -> Result<AsfSkeleton> {
    if sections.length.is_none() {
        sections
            .warnings
            .push("the ASF states no unit of length".into());
    }
    let angle = sections.angle.unwrap_or_else(|| {
        sections
            .warnings
            .push("the ASF states no unit of angle: degrees assumed".into());
        1f64.to_radians()
    });
    let axes = |bone: &AsfBone| bone.axis.map_or([0.0; 3], |(angles, _)| angles);
    let widest = sections
        .bones
        .iter()
        .flat_map(axes)
        .map(f64::abs)
        .fold(0.0, f64::max);
    let axis_angle = if widest * angle > TAU {
        let warning = format!("bones' axes are turned by up to {widest}: taken as degrees");
        sections.warnings.push(warning);
        1f64.to_radians()
    } else {
        angle
    };
    if sections.root.freedoms.is_empty() {
        return Err(Error::input(
            lines.path(),
            "the root has no `order` of its channels",
        ));
    }
    let children = children(lines, &sections)?;
    let mut joints = Vec::with_capacity(children.len());
    let mut drives = Vec::with_capacity(children.len());
    // (bone, its parent's place in `joints`). Each bone has one parent at most, so this visits each
    // bone once, and bones of a cycle never.
    let mut open: Vec<(usize, Option<usize>)> = vec![(0, None)];
    let vector = |bone: usize| match bone {
        0 => DVec3::ZERO,
        _ => {
            let bone = &sections.bones[bone - 1];
            bone.direction.unwrap_or_default() * bone.length.unwrap_or_default()
        }
    };
    let mut bone_of: Vec<usize> = Vec::with_capacity(children.len());
    while let Some((bone, parent)) = open.pop() {
        let (stated, name) = match bone {
            0 => (&sections.root, "root"),
            _ => (
                &sections.bones[bone - 1],
                sections.bones[bone - 1].name.as_str(),
            ),
        };
        let (angles, order) = stated.axis.unwrap_or(([0.0; 3], [0, 1, 2]));
        joints.push(SourceJoint {
            name: name.to_owned(),
            parent,
            offset: parent.map_or(DVec3::ZERO, |parent| vector(bone_of[parent])),
            end: children[bone].is_empty().then(|| vector(bone)),
        });
        drives.push(Drive {
            axes: fixed_axes(angles.map(|value| value * axis_angle), order),
            freedoms: stated.freedoms.clone(),
        });
        bone_of.push(bone);
        let place = joints.len() - 1;
        open.extend(
            children[bone]
                .iter()
                .rev()
                .map(|&child| (child, Some(place))),
        );
    }
    if joints.len() < children.len() {
        let lost: Vec<&str> = sections
            .bones
            .iter()
            .enumerate()
            .filter(|(bone, _)| !bone_of.contains(&(bone + 1)))
            .map(|(_, bone)| bone.name.as_str())
            .collect();
        let problem = format!(
            "{} bones are not connected to the root, `{}` first (a cycle in the hierarchy?)",
            lost.len(),
            shown(lost.first().unwrap_or(&""))
        );
        return Err(Error::input(lines.path(), problem));
    }
    Ok(AsfSkeleton {
        joints,
        drives,
        unit_m: sections.length.map(|length| INCH_M / length),
        angle,
        warnings: sections.warnings,
    })
}
