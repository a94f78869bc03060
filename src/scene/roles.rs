//! Which joint of a source skeleton plays which part of the canonical one.
//!
//! Limbs are found by name, in the spellings of CMU's ASF files, cgspeed's and
//! 3dsMax's BVH conversions, MotionBuilder and Mixamo, Character Creator, Xsens, Biped
//! and Shum et al.; the trunk, whose joints no two programs name alike, by its place
//! between the hips, the shoulders and the head.

use crate::import::SourceJoint;

/// One limb pair's joint by side: 0 left, 1 right.
pub(super) type Pair = [usize; 2];

/// Indices of source joints.
#[derive(Clone, Debug)]
pub(super) struct Roles {
    pub(super) pelvis: usize,
    /// From the joint after the pelvis to the head, both included.
    pub(super) trunk: Vec<usize>,
    /// The trunk joint that carries both arms (or the pelvis).
    pub(super) chest: usize,
    pub(super) thigh: Pair,
    pub(super) shank: Pair,
    pub(super) foot: Pair,
    /// Ball of the foot, if it is a joint.
    pub(super) toe: [Option<usize>; 2],
    pub(super) clavicle: [Option<usize>; 2],
    pub(super) upper_arm: Pair,
    pub(super) forearm: Pair,
    pub(super) hand: Pair,
}

const THIGH: &[&str] = &["upleg", "femur", "thigh", "upperleg", "hip"];
const SHANK: &[&str] = &["leg", "tibia", "calf", "shin", "shank", "lowerleg", "knee"];
const FOOT: &[&str] = &["foot", "ankle"];
const TOE: &[&str] = &["toebase", "toes", "toe", "toe0"];
const UPPER_ARM: &[&str] = &["arm", "humerus", "upperarm", "uparm", "shoulder"];
const FOREARM: &[&str] = &["forearm", "radius", "lowerarm", "elbow"];
const HAND: &[&str] = &["hand", "wrist"];
const CLAVICLE: &[&str] = &["clavicle", "collar", "shoulder", "shoulder1"];

impl Roles {
    /// Finds the parts, or says which one is missing.
    pub(super) fn find(joints: &[SourceJoint]) -> Result<Self, String> {
        let names: Vec<String> = joints.iter().map(|joint| normalised(&joint.name)).collect();
        let thigh = pair(&names, "thigh", THIGH)?;
        let shank = pair(&names, "shank", SHANK)?;
        let foot = pair(&names, "foot", FOOT)?;
        let upper_arm = pair(&names, "upper arm", UPPER_ARM)?;
        let forearm = pair(&names, "forearm", FOREARM)?;
        let hand = pair(&names, "hand", HAND)?;
        let head = names
            .iter()
            .position(|name| name == "head")
            .ok_or("no head joint")?;
        for (upper, lower, what) in [
            (thigh, shank, "shank"),
            (shank, foot, "foot"),
            (upper_arm, forearm, "forearm"),
            (forearm, hand, "hand"),
        ] {
            for side in 0..2 {
                if !path_to_root(joints, lower[side]).contains(&upper[side]) {
                    return Err(format!(
                        "the {} {what} `{}` is not carried by `{}`",
                        ["left", "right"][side],
                        joints[lower[side]].name,
                        joints[upper[side]].name
                    ));
                }
            }
        }
        let pelvis = common(joints, thigh[0], thigh[1]);
        let arms = common(joints, upper_arm[0], upper_arm[1]);
        let mut trunk = path_to_root(joints, head);
        // A figure whose trunk does not hang on the pelvis hangs with it on a root.
        if let Some(at) = trunk.iter().position(|&joint| joint == pelvis) {
            trunk.truncate(at);
        } else {
            let above = path_to_root(joints, pelvis);
            trunk.retain(|joint| !above.contains(joint));
        }
        trunk.reverse();
        let clavicle = [0, 1].map(|side| {
            let found = CLAVICLE
                .iter()
                .find_map(|part| position(&names, side, part))?;
            let carries = path_to_root(joints, upper_arm[side])[1..].contains(&found);
            (carries && found != arms).then_some(found)
        });
        Ok(Self {
            pelvis,
            chest: if trunk.contains(&arms) { arms } else { pelvis },
            trunk,
            thigh,
            shank,
            foot,
            // By what carries it: its name may say the wrong side (where legs do).
            toe: foot.map(|foot| {
                let is_toe = |joint: &usize| {
                    path_to_root(joints, *joint)[1..].contains(&foot)
                        && [0, 1].iter().any(|&side| {
                            TOE.iter()
                                .any(|part| position(&names, side, part) == Some(*joint))
                        })
                };
                (0..joints.len()).find(is_toe)
            }),
            clavicle,
            upper_arm,
            forearm,
            hand,
        })
    }

    /// All joints whose turning matters, for checks of their motion: not the hands.
    pub(super) fn turning(&self) -> Vec<usize> {
        let pairs = [
            self.thigh,
            self.shank,
            self.foot,
            self.upper_arm,
            self.forearm,
        ];
        let mut all = vec![self.pelvis];
        all.extend(&self.trunk);
        all.extend(pairs.iter().flatten());
        all.extend(self.clavicle.iter().flatten());
        all.sort_unstable();
        all.dedup();
        all
    }
}

/// A name without its namespace, case, separators and maker's prefix.
fn normalised(name: &str) -> String {
    let base = name.rsplit(':').next().unwrap_or(name);
    let plain: String = base
        .chars()
        .filter(|c| c.is_alphanumeric())
        .flat_map(char::to_lowercase)
        .collect();
    for prefix in ["mixamorig", "ccbase", "bip001", "bip01"] {
        if let Some(rest) = plain.strip_prefix(prefix) {
            return rest.to_owned();
        }
    }
    plain
}

fn position(names: &[String], side: usize, part: &str) -> Option<usize> {
    [["left", "l"], ["right", "r"]][side]
        .iter()
        .find_map(|prefix| {
            names
                .iter()
                .position(|n| n.strip_prefix(prefix) == Some(part))
        })
}

fn pair(names: &[String], what: &str, parts: &[&str]) -> Result<Pair, String> {
    let find = |side| parts.iter().find_map(|part| position(names, side, part));
    match (find(0), find(1)) {
        (Some(left), Some(right)) => Ok([left, right]),
        (None, None) => Err(format!("no {what} joints")),
        (None, _) => Err(format!("no left {what} joint")),
        (_, None) => Err(format!("no right {what} joint")),
    }
}

/// The joint itself first, the root last.
fn path_to_root(joints: &[SourceJoint], joint: usize) -> Vec<usize> {
    std::iter::successors(Some(joint), |&at| joints[at].parent).collect()
}

/// The lowest joint that carries both.
fn common(joints: &[SourceJoint], a: usize, b: usize) -> usize {
    let above = path_to_root(joints, a);
    path_to_root(joints, b)
        .into_iter()
        .find(|joint| above.contains(joint))
        .unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    fn skeleton(spec: &str) -> Vec<SourceJoint> {
        // "name<parent": the parent's name, none for the root.
        let mut joints: Vec<SourceJoint> = Vec::new();
        for entry in spec.split_whitespace() {
            let (name, parent) = entry.split_once('<').unwrap_or((entry, ""));
            let parent = joints.iter().position(|joint| joint.name == parent);
            joints.push(SourceJoint {
                name: name.into(),
                parent,
                offset: DVec3::ZERO,
                end: None,
            });
        }
        joints
    }

    const XSENS: &str = "Hips Chest<Hips Neck<Chest Head<Neck \
        RightCollar<Chest RightShoulder<RightCollar RightElbow<RightShoulder RightWrist<RightElbow \
        LeftCollar<Chest LeftShoulder<LeftCollar LeftElbow<LeftShoulder LeftWrist<LeftElbow \
        RightHip<Hips RightKnee<RightHip RightAnkle<RightKnee RightToe<RightAnkle \
        LeftHip<Hips LeftKnee<LeftHip LeftAnkle<LeftKnee LeftToe<LeftAnkle";

    #[test]
    fn a_shoulder_is_the_upper_arm_unless_there_is_an_arm() {
        let joints = skeleton(XSENS);
        let roles = Roles::find(&joints).unwrap();
        let name = |joint: usize| joints[joint].name.as_str();
        assert_eq!(roles.upper_arm.map(name), ["LeftShoulder", "RightShoulder"]);
        assert_eq!(
            roles.clavicle.map(|c| name(c.unwrap())),
            ["LeftCollar", "RightCollar"]
        );
        assert_eq!(roles.thigh.map(name), ["LeftHip", "RightHip"]);
        assert_eq!(
            roles.trunk.iter().map(|&j| name(j)).collect::<Vec<_>>(),
            ["Chest", "Neck", "Head"]
        );
        assert_eq!((name(roles.pelvis), name(roles.chest)), ("Hips", "Chest"));
        let renamed = XSENS
            .replace("Collar", "Shoulder@")
            .replace("Shoulder<", "Arm<")
            .replace("<LeftShoulder ", "<LeftArm ")
            .replace("<RightShoulder ", "<RightArm ")
            .replace('@', "");
        let joints = skeleton(&renamed);
        let roles = Roles::find(&joints).unwrap();
        assert_eq!(joints[roles.upper_arm[0]].name, "LeftArm");
        assert_eq!(joints[roles.clavicle[0].unwrap()].name, "LeftShoulder");
    }

    #[test]
    fn names_lose_namespace_case_and_separators() {
        assert_eq!(normalised("mixamorig:Left Up_Leg"), "leftupleg");
        assert_eq!(normalised("CC_Base_L_Thigh"), "lthigh");
        assert_eq!(normalised("HEad"), "head");
    }

    #[test]
    fn a_missing_side_is_named() {
        let message = Roles::find(&skeleton(&XSENS.replace("RightKnee", "LeftKnee"))).unwrap_err();
        assert_eq!(message, "no right shank joint");
    }
}
