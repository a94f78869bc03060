//! Adds joints that a skeleton lacks beyond its legs: feet, arms, hands, a head.
//!
//! Gait needs thighs and shanks. Other missing joints are placed as in an average adult with these
//! legs, and turn with their parents.

use std::borrow::Cow;

use edgegait_core::skeleton::{JOINTS, Joint};
use glam::{DQuat, DVec3};

use crate::import::{Motion, SourceJoint};
use crate::people::cohort::anthropometry::{DIMENSIONS, Dimensions};
use crate::people::cohort::body;
use crate::people::forward_kinematics;
use crate::people::retarget::joint_roles::{LimbPair, Named, common};
use crate::people::retarget::leg_length_m;
use crate::people::retarget::rest_pose::{across, base_of, identity_pose};

/// Stature and mass of the average adult, of whom only the proportions matter here. Our choice:
/// between ANSUR II's men and women.
const STATURE_M: f64 = 1.70;
const MASS_KG: f64 = 76.0;

/// Returns the motion with all joints that a figure needs. A warning names those that were added.
///
/// # Errors
/// If there are no legs, or the shanks have neither feet nor ends.
pub(in crate::people) fn completed(motion: &Motion) -> Result<Cow<'_, Motion>, String> {
    let named = Named::find(&motion.joints);
    if named.thigh == [None; 2] || named.shank == [None; 2] {
        let some = motion
            .joints
            .iter()
            .take(6)
            .map(|joint| joint.name.as_str());
        return Err(format!(
            "no leg joints: expected names like LeftUpLeg and LeftLeg, lfemur and ltibia, LeftHip and LeftKnee, found {}",
            some.collect::<Vec<_>>().join(", ")
        ));
    }
    let lacks: Vec<&str> = [
        (named.foot, "feet"),
        (named.upper_arm, "arms"),
        (named.forearm, "forearms"),
        (named.hand, "hands"),
        ([named.head; 2], "head"),
    ]
    .into_iter()
    .filter_map(|(pair, what)| (pair == [None; 2]).then_some(what))
    .collect();
    let (Some(thigh), Some(shank), false) =
        (both(named.thigh), both(named.shank), lacks.is_empty())
    else {
        // The skeleton is complete, or one side lacks a joint, which `JointRoles::find` names.
        return Ok(Cow::Borrowed(motion));
    };
    let mut figure = GrowingSkeleton {
        joints: motion.joints.clone(),
        positions: identity_pose(motion).positions,
    };
    let foot = figure.pair(named.foot, ["leftfoot", "rightfoot"], |figure, side| {
        figure.tip(shank[side]).map(|tip| (shank[side], tip))
    });
    let foot = foot.ok_or("no foot joints, and the shanks have no ends")?;
    let adult = Adult::with_legs(&figure.positions, thigh, shank, foot)?;
    figure.add_upper_body(&named, &adult, common(&motion.joints, thigh[0], thigh[1]));

    let mut complete = motion.clone();
    for frame in &mut complete.frames {
        frame.rotations.resize(figure.joints.len(), DQuat::IDENTITY);
        if let Some(offsets) = &mut frame.offsets {
            let added = &figure.joints[offsets.len()..];
            offsets.extend(added.iter().map(|joint| joint.offset));
        }
    }
    complete.joints = figure.joints;
    complete.warnings.push(format!(
        "the skeleton has no {}: those of an average adult are added, which move with their parents",
        lacks.join(", ")
    ));
    Ok(Cow::Owned(complete))
}

fn both(pair: [Option<usize>; 2]) -> Option<LimbPair> {
    Some([pair[0]?, pair[1]?])
}

/// An average adult with the legs of a source skeleton at rest, source units and axes.
struct Adult {
    hips: DVec3,
    base: DQuat,
    scale: f64,
    /// Joint positions from midway between the hips, metres, canonical axes.
    joints: [DVec3; JOINTS],
}

impl Adult {
    fn with_legs(
        p: &[DVec3],
        thigh: LimbPair,
        shank: LimbPair,
        foot: LimbPair,
    ) -> Result<Self, String> {
        let hips = p[thigh[0]].midpoint(p[thigh[1]]);
        let up = hips - p[foot[0]].midpoint(p[foot[1]]);
        let base = base_of(across(p, thigh, shank), up)
            .ok_or("the skeleton is degenerate: it has no left or no up direction")?;
        let leg = |side: usize| {
            let (hip, knee, ankle) = (p[thigh[side]], p[shank[side]], p[foot[side]]);
            hip.distance(knee) + knee.distance(ankle)
        };
        let dimensions = Dimensions::expected(STATURE_M, MASS_KG, None, &[0.0; DIMENSIONS])
            .map_err(|error| error.to_string())?;
        let offsets = body::offsets(&dimensions);
        Ok(Self {
            hips,
            base,
            scale: 0.5 * (leg(0) + leg(1)) / leg_length_m(&offsets),
            joints: forward_kinematics(&offsets, DVec3::ZERO, &[DQuat::IDENTITY; JOINTS]).0,
        })
    }

    /// Returns the vector from one joint to another, source units and axes.
    fn between(&self, from: Joint, to: Joint) -> DVec3 {
        self.base * (self.joints[to.index()] - self.joints[from.index()]) * self.scale
    }
}

/// A source skeleton at rest to which joints are added.
struct GrowingSkeleton {
    joints: Vec<SourceJoint>,
    positions: Vec<DVec3>,
}

impl GrowingSkeleton {
    /// Adds a joint and returns its number.
    fn add(&mut self, name: &str, parent: usize, position: DVec3) -> usize {
        self.joints.push(SourceJoint {
            name: name.to_owned(),
            parent: Some(parent),
            offset: position - self.positions[parent],
            end: None,
        });
        self.positions.push(position);
        self.joints.len() - 1
    }

    /// Returns the end of a leaf joint, if the file states one.
    fn tip(&self, joint: usize) -> Option<DVec3> {
        let end = self.joints[joint].end.filter(|end| *end != DVec3::ZERO)?;
        Some(self.positions[joint] + end)
    }

    /// Returns both joints of a pair. If neither was found, adds them with the parent and position
    /// that `place` returns.
    fn pair(
        &mut self,
        found: [Option<usize>; 2],
        names: [&str; 2],
        place: impl Fn(&Self, usize) -> Option<(usize, DVec3)>,
    ) -> Option<LimbPair> {
        if found != [None; 2] {
            return both(found);
        }
        let places = [place(self, 0)?, place(self, 1)?];
        Some([0, 1].map(|side| {
            let (parent, position) = places[side];
            self.add(names[side], parent, position)
        }))
    }

    /// Adds missing arms, forearms, hands and head. Returns none as soon as one side of a pair is
    /// missing.
    fn add_upper_body(&mut self, named: &Named, adult: &Adult, pelvis: usize) -> Option<()> {
        const ARMS: [[Joint; 3]; 2] = [
            [Joint::LeftUpperArm, Joint::LeftForearm, Joint::LeftHand],
            [Joint::RightUpperArm, Joint::RightForearm, Joint::RightHand],
        ];
        let trunk = named.head.and_then(|head| self.joints[head].parent);
        let upper_arm = self.pair(named.upper_arm, ["leftarm", "rightarm"], |_, side| {
            let shoulder = adult.hips + adult.between(Joint::Pelvis, ARMS[side][0]);
            Some((trunk.unwrap_or(pelvis), shoulder))
        })?;
        let below = |figure: &Self, above: LimbPair, side: usize, part: usize| {
            let [from, to] = [ARMS[side][part - 1], ARMS[side][part]];
            let tip = figure.tip(above[side]);
            let hanging = figure.positions[above[side]] + adult.between(from, to);
            Some((above[side], tip.unwrap_or(hanging)))
        };
        let forearm = self.pair(
            named.forearm,
            ["leftforearm", "rightforearm"],
            |figure, side| below(figure, upper_arm, side, 1),
        )?;
        self.pair(named.hand, ["lefthand", "righthand"], |figure, side| {
            below(figure, forearm, side, 2)
        })?;
        if named.head.is_none() {
            let chest = common(&self.joints, upper_arm[0], upper_arm[1]);
            let shoulders = upper_arm.map(|joint| self.positions[joint]);
            let rise = [0, 1].map(|side| adult.between(ARMS[side][0], Joint::Head));
            let head = (shoulders[0] + rise[0]).midpoint(shoulders[1] + rise[1]);
            self.add("head", chest, head);
        }
        Some(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::import::{MotionFormat, SourceFrame};

    /// Returns a pelvis with thighs of 0.42 m and shanks of 0.40 m that have ends.
    fn legs() -> Motion {
        let joint = |name: &str, parent, x: f64, y: f64| SourceJoint {
            name: name.into(),
            parent,
            offset: DVec3::new(x, y, 0.0),
            end: None,
        };
        let mut joints = vec![
            joint("Hips", None, 0.0, 0.0),
            joint("LeftUpLeg", Some(0), 0.1, 0.0),
            joint("LeftLeg", Some(1), 0.0, -0.42),
            joint("RightUpLeg", Some(0), -0.1, 0.0),
            joint("RightLeg", Some(3), 0.0, -0.42),
        ];
        for shank in [2, 4] {
            joints[shank].end = Some(DVec3::new(0.0, -0.40, 0.0));
        }
        let frame = SourceFrame {
            root: DVec3::new(0.0, 0.9, 0.0),
            rotations: vec![DQuat::IDENTITY; joints.len()],
            offsets: None,
        };
        Motion {
            format: MotionFormat::Bvh,
            joints,
            sample_rate_hz: 60.0,
            frames: vec![frame],
            unit_m: None,
            skin: None,
            warnings: Vec::new(),
        }
    }

    fn place(motion: &Motion, name: &str) -> DVec3 {
        let at = motion.joints.iter().position(|joint| joint.name == name);
        motion.globals(0).0[at.expect("the joint")]
    }

    #[test]
    fn legs_alone_get_feet_at_their_ends_and_a_head_above() {
        let bare = legs();
        let whole = completed(&bare).unwrap();
        assert_eq!(whole.joints[..5], bare.joints[..]);
        let foot = place(&whole, "leftfoot");
        assert!(foot.distance(DVec3::new(0.1, 0.08, 0.0)) < 1e-12, "{foot}");
        // Winter 2009, figure 4.1: shoulders at 0.818 and eyes at 0.936 of the stature, ankles to
        // hips 0.491: 0.82 m of leg is a stature of 1.67 m.
        let (head, arm) = (place(&whole, "head"), place(&whole, "leftarm"));
        assert!((head.y - 0.93 * 1.67).abs() < 0.06, "{head}");
        assert!((arm.y - 0.818 * 1.67).abs() < 0.06, "{arm}");
        assert!(head.x.abs() < 1e-12 && arm.x > 0.12, "{head} {arm}");
        let elbow = place(&whole, "leftforearm");
        assert!(elbow.y < arm.y - 0.2 && elbow.x == arm.x, "{elbow}");
        assert_eq!(
            whole.warnings,
            [
                "the skeleton has no feet, arms, forearms, hands, head: those of an average adult are added, which move with their parents"
            ]
        );
    }

    #[test]
    fn what_is_added_does_not_depend_on_the_unit_or_the_axes() {
        let metres = legs();
        let mut tilted = legs();
        // Centimetres, Z up.
        let turned = |v: DVec3| DVec3::new(v.x, -v.z, v.y) * 100.0;
        for joint in &mut tilted.joints {
            joint.offset = turned(joint.offset);
            joint.end = joint.end.map(turned);
        }
        tilted.frames[0].root = turned(metres.frames[0].root);
        let (a, b) = (completed(&metres).unwrap(), completed(&tilted).unwrap());
        for (a, b) in a.globals(0).0.iter().zip(b.globals(0).0) {
            assert!(turned(*a).distance(b) < 1e-9, "{a} {b}");
        }
    }

    #[test]
    fn legs_that_end_nowhere_and_figures_without_legs_are_refused() {
        let mut endless = legs();
        endless.joints[2].end = None;
        assert_eq!(
            completed(&endless).unwrap_err(),
            "no foot joints, and the shanks have no ends"
        );
        let mut legless = legs();
        legless.joints.truncate(1);
        assert!(
            completed(&legless)
                .unwrap_err()
                .starts_with("no leg joints")
        );
    }
}
