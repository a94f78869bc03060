//! The mapping from the joints of a source skeleton to the canonical ones.
//!
//! Limbs are found by name, in the spellings of CMU's ASF files, cgspeed's and 3dsMax's BVH
//! conversions, MotionBuilder and Mixamo, Character Creator, Xsens, Biped, Shum et al., MakeHuman,
//! Rigify, Unreal's mannequin, VRM, SMPL and Daz. The trunk, which every program names differently,
//! is found by its place between the hips, the shoulders and the head.

use crate::import::SourceJoint;

#[cfg(test)]
mod tests;

/// The two joints of a limb pair: left, right.
pub(in crate::people) type LimbPair = [usize; 2];

/// Indices of the source joints that play each role.
#[derive(Clone, Debug)]
pub(in crate::people) struct JointRoles {
    pub(in crate::people) pelvis: usize,
    /// The trunk, from the joint after the pelvis to the head, both included.
    pub(in crate::people) trunk: Vec<usize>,
    /// Whether the source has more trunk joints than programs usually bend.
    pub(in crate::people) is_fine_trunk: bool,
    /// The trunk joint that carries both arms, or the pelvis if none does.
    pub(in crate::people) chest: usize,
    pub(in crate::people) thigh: LimbPair,
    pub(in crate::people) shank: LimbPair,
    pub(in crate::people) foot: LimbPair,
    /// Ball of the foot, if it is a joint.
    pub(in crate::people) toe: [Option<usize>; 2],
    pub(in crate::people) clavicle: [Option<usize>; 2],
    pub(in crate::people) upper_arm: LimbPair,
    pub(in crate::people) forearm: LimbPair,
    pub(in crate::people) hand: LimbPair,
}

/// Joints found by name alone, left and right. Missing ones are added before the roles are found.
pub(in crate::people) struct Named {
    pub(in crate::people) thigh: [Option<usize>; 2],
    pub(in crate::people) shank: [Option<usize>; 2],
    pub(in crate::people) foot: [Option<usize>; 2],
    pub(in crate::people) upper_arm: [Option<usize>; 2],
    pub(in crate::people) forearm: [Option<usize>; 2],
    pub(in crate::people) hand: [Option<usize>; 2],
    pub(in crate::people) head: Option<usize>,
}

impl Named {
    pub(in crate::people) fn find(joints: &[SourceJoint]) -> Self {
        let names = plain_names(joints);
        let pair = |parts: &[&str]| {
            [0, 1].map(|side| parts.iter().find_map(|part| position(&names, side, part)))
        };
        // SMPL names joints, not segments: its `ankle` begins the foot, and its `foot` is the ball.
        let after = |before: &str, ours, usual| match position(&names, 0, before) {
            Some(_) => ours,
            None => usual,
        };
        Self {
            thigh: pair(THIGH),
            shank: pair(SHANK),
            foot: pair(after("knee", ANKLE, FOOT)),
            upper_arm: pair(UPPER_ARM),
            forearm: pair(FOREARM),
            hand: pair(after("elbow", WRIST, HAND)),
            head: HEAD
                .iter()
                .find_map(|part| names.iter().position(|name| name == part)),
        }
    }
}

const THIGH: &[&str] = &[
    "upleg",
    "femur",
    "thigh",
    "thighbend",
    "upperleg",
    "upperleg01",
    "hip",
];
const SHANK: &[&str] = &[
    "leg",
    "tibia",
    "calf",
    "shin",
    "shank",
    "lowerleg",
    "lowerleg01",
    "knee",
];
const FOOT: &[&str] = &["foot", "ankle"];
const ANKLE: &[&str] = &["ankle", "foot"];
const TOE: &[&str] = &["toebase", "toes", "toe", "toe0", "ball", "toe21", "foot"];
const UPPER_ARM: &[&str] = &[
    "arm",
    "humerus",
    "upperarm",
    "uparm",
    "upperarm01",
    "shldrbend",
    "shldr",
    "shoulder",
];
const FOREARM: &[&str] = &[
    "forearm",
    "radius",
    "lowerarm",
    "lowerarm01",
    "forearmbend",
    "elbow",
];
const HAND: &[&str] = &["hand", "wrist"];
const WRIST: &[&str] = &["wrist", "hand"];
const CLAVICLE: &[&str] = &["clavicle", "collar", "shoulder", "shoulder1"];
/// The maximum number of joints in a coarse trunk, the head included; more make it a fine trunk.
/// MakeHuman has nine, Rigify and Xsens have six. Our choice.
const COARSE_TRUNK: usize = 7;

/// Names of the head. Rigify numbers its trunk joints up to the head.
const HEAD: &[&str] = &["head", "spine006"];

impl JointRoles {
    /// Finds the roles of the joints.
    ///
    /// # Errors
    /// Names the missing joint, or a limb's joint that is not a descendant of the one above it.
    pub(in crate::people) fn find(joints: &[SourceJoint]) -> Result<Self, String> {
        let names = plain_names(joints);
        let named = Named::find(joints);
        let thigh = pair("thigh", named.thigh)?;
        let shank = pair("shank", named.shank)?;
        let foot = pair("foot", named.foot)?;
        let upper_arm = pair("upper arm", named.upper_arm)?;
        let forearm = pair("forearm", named.forearm)?;
        let hand = pair("hand", named.hand)?;
        let head = named.head.ok_or("no head joint")?;
        for (upper, lower, what) in [
            (thigh, shank, "shank"),
            (shank, foot, "foot"),
            (upper_arm, forearm, "forearm"),
            (forearm, hand, "hand"),
        ] {
            for side in 0..2 {
                if !path_to_root(joints, lower[side]).contains(&upper[side]) {
                    return Err(format!(
                        "the {} {what} `{}` is not a descendant of `{}`",
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
        // A trunk that is not below the pelvis shares a root with it.
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
            is_fine_trunk: trunk.len() > COARSE_TRUNK,
            trunk,
            thigh,
            shank,
            foot,
            // By ancestry: its name may have the wrong side (where legs do).
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

    /// Returns all joints whose rotation is checked for faults: not the hands.
    pub(in crate::people) fn turning(&self) -> Vec<usize> {
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

/// Returns the joints' names without namespaces, case, separators and makers' prefixes. If no name
/// is known then, a prefix that all names share (`Character1_`) and the number of a copy (`.001`) are
/// removed first.
fn plain_names(joints: &[SourceJoint]) -> Vec<String> {
    let names: Vec<String> = joints.iter().map(|joint| normalised(&joint.name)).collect();
    let has_legs = |names: &[String]| {
        let mut parts = THIGH.iter().chain(SHANK);
        parts.any(|part| position(names, 0, part).is_some())
    };
    if has_legs(&names) {
        return names;
    }
    let uncopied = joints
        .iter()
        .map(|joint| match joint.name.rsplit_once('.') {
            Some((name, copy)) if copy.len() == 3 && copy.bytes().all(|it| it.is_ascii_digit()) => {
                name
            }
            _ => joint.name.as_str(),
        });
    let uncopied: Vec<&str> = uncopied.collect();
    let shared = shared_prefix(&uncopied);
    let shorter = uncopied.iter().map(|name| normalised(&name[shared..]));
    let shorter: Vec<String> = shorter.collect();
    if has_legs(&shorter) { shorter } else { names }
}

/// Returns the bytes of the longest prefix that all names share and that ends with a separator.
pub(in crate::people) fn shared_prefix(names: &[&str]) -> usize {
    let [first, others @ ..] = names else {
        return 0;
    };
    let shared = others.iter().fold(first.len(), |shared, name| {
        let pairs = first.bytes().zip(name.bytes()).take(shared);
        pairs.take_while(|(a, b)| a == b).count()
    });
    let separators = first
        .char_indices()
        .filter(|(at, mark)| *at < shared && matches!(mark, '_' | '-' | ' ' | '.' | '|'));
    separators
        .max_by_key(|(at, _)| *at)
        .map_or(0, |(at, _)| at + 1)
}

/// Returns a name without its namespace, case, separators and maker's prefix.
pub(in crate::people) fn normalised(name: &str) -> String {
    let base = name.rsplit(':').next().unwrap_or(name);
    let plain: String = base
        .chars()
        .filter(|c| c.is_alphanumeric())
        .flat_map(char::to_lowercase)
        .collect();
    for prefix in [
        "mixamorig",
        "ccbase",
        "bip001",
        "bip01",
        "jbipc",
        "jbip",
        "def",
    ] {
        if let Some(rest) = plain.strip_prefix(prefix) {
            return rest.to_owned();
        }
    }
    plain
}

/// Returns the joint with a part's name, preceded or followed by the side.
fn position(names: &[String], side: usize, part: &str) -> Option<usize> {
    [["left", "l"], ["right", "r"]][side]
        .iter()
        .find_map(|mark| {
            names.iter().position(|n| {
                n.strip_prefix(mark) == Some(part) || n.strip_suffix(mark) == Some(part)
            })
        })
}

fn pair(what: &str, found: [Option<usize>; 2]) -> Result<LimbPair, String> {
    match found {
        [Some(left), Some(right)] => Ok([left, right]),
        [None, None] => Err(format!("no {what} joints")),
        [None, _] => Err(format!("no left {what} joint")),
        [_, None] => Err(format!("no right {what} joint")),
    }
}

/// Returns the path from a joint (first) to the root (last).
fn path_to_root(joints: &[SourceJoint], joint: usize) -> Vec<usize> {
    std::iter::successors(Some(joint), |&at| joints[at].parent).collect()
}

/// Returns the lowest common ancestor of two joints.
pub(in crate::people) fn common(joints: &[SourceJoint], a: usize, b: usize) -> usize {
    let above = path_to_root(joints, a);
    path_to_root(joints, b)
        .into_iter()
        .find(|joint| above.contains(joint))
        .unwrap_or(0)
}
