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
    let roles = JointRoles::find(&joints).unwrap();
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
    let roles = JointRoles::find(&joints).unwrap();
    assert_eq!(joints[roles.upper_arm[0]].name, "LeftArm");
    assert_eq!(joints[roles.clavicle[0].unwrap()].name, "LeftShoulder");
}

/// Returns a figure in a rig's own spelling, `{}` for the side. Limbs: thigh, shank, foot, toe,
/// clavicle, upper arm, forearm, hand.
fn rig(trunk: &str, chest: &str, limbs: [&str; 8], sides: [&str; 2]) -> String {
    let pelvis = trunk.split_whitespace().next().unwrap();
    let mut spec = trunk.to_owned();
    for side in sides {
        let [thigh, shank, foot, toe, clavicle, arm, forearm, hand] =
            limbs.map(|name| name.replace("{}", side));
        spec += &format!(
            " {thigh}<{pelvis} {shank}<{thigh} {foot}<{shank} {toe}<{foot} \
             {clavicle}<{chest} {arm}<{clavicle} {forearm}<{arm} {hand}<{forearm}"
        );
    }
    spec
}

#[test]
fn rigs_of_many_makers_are_understood() {
    let rigs = [
        rig(
            "root spine05<root spine04<spine05 spine03<spine04 spine02<spine03 spine01<spine02 neck01<spine01 head<neck01",
            "spine01",
            [
                "upperleg01{}",
                "lowerleg01{}",
                "foot{}",
                "toe2-1{}",
                "clavicle{}",
                "upperarm01{}",
                "lowerarm01{}",
                "wrist{}",
            ],
            [".L", ".R"],
        ),
        rig(
            "DEF-spine DEF-spine.001<DEF-spine DEF-spine.003<DEF-spine.001 DEF-spine.004<DEF-spine.003 DEF-spine.006<DEF-spine.004",
            "DEF-spine.003",
            [
                "DEF-thigh{}",
                "DEF-shin{}",
                "DEF-foot{}",
                "DEF-toe{}",
                "DEF-shoulder{}",
                "DEF-upper_arm{}",
                "DEF-forearm{}",
                "DEF-hand{}",
            ],
            [".L", ".R"],
        ),
        rig(
            "pelvis spine_01<pelvis spine_02<spine_01 spine_03<spine_02 neck_01<spine_03 head<neck_01",
            "spine_03",
            [
                "thigh{}",
                "calf{}",
                "foot{}",
                "ball{}",
                "clavicle{}",
                "upperarm{}",
                "lowerarm{}",
                "hand{}",
            ],
            ["_l", "_r"],
        ),
        rig(
            "J_Bip_C_Hips J_Bip_C_Spine<J_Bip_C_Hips J_Bip_C_Neck<J_Bip_C_Spine J_Bip_C_Head<J_Bip_C_Neck",
            "J_Bip_C_Spine",
            [
                "J_Bip_{}_UpperLeg",
                "J_Bip_{}_LowerLeg",
                "J_Bip_{}_Foot",
                "J_Bip_{}_ToeBase",
                "J_Bip_{}_Shoulder",
                "J_Bip_{}_UpperArm",
                "J_Bip_{}_LowerArm",
                "J_Bip_{}_Hand",
            ],
            ["L", "R"],
        ),
        rig(
            "Pelvis Spine1<Pelvis Spine2<Spine1 Spine3<Spine2 Neck<Spine3 Head<Neck",
            "Spine3",
            [
                "{}_Hip",
                "{}_Knee",
                "{}_Ankle",
                "{}_Foot",
                "{}_Collar",
                "{}_Shoulder",
                "{}_Elbow",
                "{}_Wrist",
            ],
            ["L", "R"],
        ),
        rig(
            "mixamorig:Hips mixamorig:Spine<mixamorig:Hips mixamorig:Neck<mixamorig:Spine mixamorig:Head<mixamorig:Neck",
            "mixamorig:Spine",
            [
                "mixamorig:{}UpLeg",
                "mixamorig:{}Leg",
                "mixamorig:{}Foot",
                "mixamorig:{}ToeBase",
                "mixamorig:{}Shoulder",
                "mixamorig:{}Arm",
                "mixamorig:{}ForeArm",
                "mixamorig:{}Hand",
            ],
            ["Left", "Right"],
        ),
        rig(
            "hip spine<hip chest<spine neck<chest head<neck",
            "chest",
            [
                "thigh-{}",
                "shin-{}",
                "foot-{}",
                "toe-{}",
                "clavicle-{}",
                "upper-arm-{}",
                "forearm-{}",
                "hand-{}",
            ],
            ["left", "right"],
        ),
    ];
    for spec in rigs {
        let joints = skeleton(&spec);
        let roles = JointRoles::find(&joints).unwrap_or_else(|e| panic!("{e}: {spec}"));
        let first = joints.len() - 16;
        for side in 0..2 {
            let limb = [
                roles.thigh[side],
                roles.shank[side],
                roles.foot[side],
                roles.toe[side].unwrap(),
                roles.clavicle[side].unwrap(),
                roles.upper_arm[side],
                roles.forearm[side],
                roles.hand[side],
            ];
            let expected: Vec<usize> = (0..8).map(|i| first + 8 * side + i).collect();
            assert_eq!(limb.to_vec(), expected, "{spec}");
        }
        assert_eq!(roles.trunk.last(), Some(&(first - 1)), "{spec}");
        assert_eq!(roles.pelvis, 0);
    }
}

#[test]
fn names_lose_namespace_case_and_separators() {
    assert_eq!(normalised("mixamorig:Left Up_Leg"), "leftupleg");
    assert_eq!(normalised("CC_Base_L_Thigh"), "lthigh");
    assert_eq!(normalised("HEad"), "head");
}

#[test]
fn a_prefix_that_all_names_share_and_the_number_of_a_copy_are_ignored() {
    let plain = Named::find(&skeleton(XSENS));
    for (before, after) in [
        ("Character1_", ""),
        ("Bob-the-2nd_", ""),
        ("", ".001"),
        ("a_", ".012"),
    ] {
        let mut joints = skeleton(XSENS);
        for joint in &mut joints {
            joint.name = format!("{before}{}{after}", joint.name);
        }
        let named = Named::find(&joints);
        assert_eq!(
            (named.thigh, named.hand),
            (plain.thigh, plain.hand),
            "{before}{after}"
        );
        assert!(JointRoles::find(&joints).is_ok(), "{before}{after}");
    }
}

#[test]
fn a_missing_side_is_named() {
    let message = JointRoles::find(&skeleton(&XSENS.replace("RightKnee", "LeftKnee"))).unwrap_err();
    assert_eq!(message, "no right shank joint");
}
