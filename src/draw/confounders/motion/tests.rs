use super::slope::MAX_SLOPE_DEG;
use super::*;
use crate::people::cohort::Person;
use crate::people::forward_kinematics;
use edgegait_core::pose::ModelPose;
use edgegait_core::skeleton::Joint;
use glam::{Quat, Vec3};

/// All effects, and whether they are symmetric.
const EFFECTS: [(&str, Effect, bool); 13] = [
    ("speed", speed, true),
    ("arm_still", arm_still, false),
    ("hands_in_pockets", hands_in_pockets, true),
    ("carried_arm", carried_arm, false),
    ("phone_at_ear", phone_at_ear, false),
    ("under_umbrella", under_umbrella, false),
    ("around_box", around_box, true),
    ("at_the_bar", at_the_bar, true),
    ("skirt_gait", skirt_gait, true),
    ("load_lean", load_lean, true),
    ("limp", limp, false),
    ("age_gait", age_gait, true),
    ("slope", slope, true),
];

/// A built-in person's walk at 5 km/h.
struct Walked {
    gait: GaitFacts,
    poses: Vec<Pose>,
}

impl Walked {
    fn by(person: usize) -> Self {
        let person = Person::of_cohort(1, person).unwrap();
        let cycle = person.cycle(5.0);
        let poses: Vec<Pose> = cycle
            .root
            .iter()
            .zip(&cycle.rotations)
            .map(|(root, rotations)| Pose {
                root: root.as_vec3(),
                rotations: rotations.map(DQuat::as_quat),
            })
            .collect();
        let skeleton = Skeleton {
            offsets: person.body.offsets.map(DVec3::as_vec3),
        };
        Self {
            gait: GaitFacts::from_poses(skeleton, poses.iter().cloned(), 5.0 / 3.6, cycle.period_s),
            poses,
        }
    }

    fn under(&self, effect: Effect, strength: f64) -> Vec<Pose> {
        let mut poses = self.poses.clone();
        for pose in &mut poses {
            effect(pose, &self.gait, strength);
        }
        poses
    }

    fn model(&self, pose: &Pose) -> ModelPose {
        ModelPose::new(&self.gait.skeleton, pose)
    }

    /// Returns joint positions in f64.
    fn positions(&self, pose: &Pose) -> [DVec3; JOINTS] {
        let offsets = self.gait.skeleton.offsets.map(Vec3::as_dvec3);
        let rotations = pose.rotations.map(Quat::as_dquat);
        forward_kinematics(&offsets, pose.root.as_dvec3(), &rotations).0
    }
}

fn people() -> impl Iterator<Item = Walked> {
    (0..26).step_by(5).map(Walked::by)
}

/// Returns the greatest angle between the joints of two poses, degrees.
fn difference_deg(a: &Pose, b: &Pose) -> f32 {
    let pairs = a.rotations.iter().zip(b.rotations);
    // Twice the arc sine of half the chord is accurate for the smallest angles too.
    let angles = pairs.map(|(a, b)| {
        let chord = (*a - b).length().min((*a + b).length());
        4.0 * (0.5 * chord).asin().to_degrees()
    });
    angles.fold(0.0, f32::max)
}

fn mirrored(pose: &Pose) -> Pose {
    let mut other = Pose {
        root: pose.root * Vec3::new(-1.0, 1.0, 1.0),
        ..pose.clone()
    };
    for joint in Joint::ALL {
        let Quat { x, y, z, w } = pose.rotations[joint.mirrored().index()];
        other.rotations[joint.index()] = Quat::from_xyzw(x, -y, -z, w);
    }
    other
}

/// Returns a pose in which only this joint is turned about X.
fn bent(joint: Joint, degrees: f32) -> Pose {
    let mut pose = Pose::REST;
    pose.rotations[joint.index()] = Quat::from_rotation_x(degrees.to_radians());
    pose
}

#[test]
fn strength_zero_changes_no_bit() {
    let walk = Walked::by(3);
    for (name, effect, _) in EFFECTS {
        assert_eq!(walk.under(effect, 0.0), walk.poses, "{name}");
    }
    assert_eq!(limp_phase(0.3, 0.0), 0.3);
}

#[test]
fn a_mean_pose_lies_in_the_middle_whatever_the_quaternions_signs() {
    let mut turned = bent(Joint::LeftShank, 70.0);
    turned.rotations[Joint::LeftShank.index()] *= -1.0;
    turned.root = Vec3::new(0.2, 1.0, 0.0);
    let poses = [bent(Joint::LeftShank, 10.0), turned];
    let skeleton = Walked::by(0).gait.skeleton;
    let gait = GaitFacts::from_poses(skeleton, poses, 1.5, 1.2);
    let mut expected = bent(Joint::LeftShank, 40.0);
    expected.root = Vec3::new(0.1, 0.5, 0.0);
    assert!(difference_deg(&gait.mean, &expected) < 1e-4);
    assert_eq!(gait.mean.root, expected.root);
    assert!((gait.stride_m - 1.8).abs() < 1e-12);
}

#[test]
fn faster_walkers_excursions_grow_as_grieve_and_gear_have_it() {
    let skeleton = Walked::by(0).gait.skeleton;
    let cycle = [20.0, 60.0].map(|degrees| bent(Joint::RightShank, degrees));
    let gait = GaitFacts::from_poses(skeleton, cycle.clone(), 1.4, 1.0);
    // 1.5 to the power of 0.42 is 1.18565; excursions are 20 degrees about a mean of 40.
    for (strength, reach) in [(1.0, 23.713), (-1.0, 16.868)] {
        let mut pose = cycle[1].clone();
        speed(&mut pose, &gait, strength);
        let expected = bent(Joint::RightShank, 40.0 + reach);
        assert!(difference_deg(&pose, &expected) < 2e-3, "{strength}");
        let pace = speed_pace(strength);
        let ratio = pace.stride / pace.duration;
        assert!((ratio - 1.5f64.powf(strength)).abs() < 1e-12, "{ratio}");
    }
    // 0.71 to the power of 0.42.
    assert!((age_pace(1.0).stride - 0.866).abs() < 5e-4);
}

#[test]
fn faster_walkers_keep_their_mean_pose() {
    for walk in people() {
        let faster = walk.under(speed, 1.0);
        let GaitFacts { skeleton, .. } = walk.gait.clone();
        let mean = GaitFacts::from_poses(skeleton, faster, 1.0, 1.0).mean;
        assert!(difference_deg(&mean, &walk.gait.mean) < 1.0);
    }
}

#[test]
fn a_still_arm_keeps_its_mean_and_leaves_the_rest() {
    let walk = Walked::by(2);
    for (still, before) in walk.under(arm_still, 1.0).iter().zip(&walk.poses) {
        for joint in Joint::ALL {
            let of = |pose: &Pose| pose.rotations[joint.index()];
            let is_right_arm = (9..13).contains(&joint.index());
            if is_right_arm {
                assert!(
                    (of(still) - of(&walk.gait.mean)).length() < 1e-6,
                    "{joint:?}"
                );
            } else {
                assert_eq!(of(still), of(before), "{joint:?}");
            }
        }
    }
}

#[test]
fn pocketed_wrists_stay_beside_the_hips() {
    for walk in people() {
        for pose in walk.under(hands_in_pockets, 1.0) {
            let at = walk.model(&pose).positions;
            for (wrist, hip) in [
                (Joint::LeftHand, Joint::LeftThigh),
                (Joint::RightHand, Joint::RightThigh),
            ] {
                let from_hip = at[wrist.index()] - at[hip.index()];
                assert!(from_hip.length() < 0.22, "{from_hip}");
                let outwards = from_hip.x * at[hip.index()].x.signum();
                assert!(outwards > 0.02, "{from_hip}");
            }
        }
    }
}

#[test]
fn a_carrying_arm_hangs_almost_straight_down() {
    for walk in people() {
        for pose in walk.under(carried_arm, 1.0) {
            let at = walk.model(&pose).positions;
            let arm = at[Joint::RightHand.index()] - at[Joint::RightUpperArm.index()];
            assert!(arm.angle_between(-Vec3::Y).to_degrees() < 17.0, "{arm}");
            assert!(arm.x < 0.0, "outwards, on the right: {arm}");
        }
    }
}

#[test]
fn a_phone_is_at_the_ear_and_moves_the_right_arm_alone() {
    for walk in people() {
        for (pose, before) in walk.under(phone_at_ear, 1.0).iter().zip(&walk.poses) {
            let at = walk.model(pose).positions;
            // The hand's middle is 8 cm beyond the wrist, the ear beside the base of the skull.
            let [wrist, elbow, head] =
                [Joint::RightHand, Joint::RightForearm, Joint::Head].map(|joint| at[joint.index()]);
            let hand = wrist + 0.08 * (wrist - elbow).normalize();
            let away = hand - head;
            assert!(away.length() < 0.18 && away.x < -0.04, "{away}");
            let still = |joint: &Joint| !(9..13).contains(&joint.index());
            for joint in Joint::ALL.iter().filter(|joint| still(joint)) {
                assert_eq!(
                    pose.rotations[joint.index()],
                    before.rotations[joint.index()]
                );
            }
        }
    }
}

#[test]
fn hands_are_where_loads_are_hung() {
    for walk in people() {
        let skeleton = &walk.gait.skeleton;
        for (effect, arm) in [
            (under_umbrella as Effect, UNDER_UMBRELLA),
            (around_box, AROUND_BOX),
            (at_the_bar, AT_THE_BAR),
        ] {
            let mut pose = Pose::REST;
            effect(&mut pose, &walk.gait, 0.5);
            let at = walk.positions(&pose);
            let [shoulder, wrist] =
                [Joint::RightUpperArm, Joint::RightHand].map(|joint| at[joint.index()]);
            assert!((wrist - shoulder).distance(arm.reach(skeleton, -1.0)) < 1e-6);
        }
    }
}

#[test]
fn a_hem_at_the_knees_is_narrower_than_the_stride_of_free_legs() {
    for walk in people() {
        let apart = |poses: &[Pose]| {
            let spans = poses.iter().map(|pose| {
                let at = walk.model(pose).positions;
                (at[Joint::LeftShank.index()].z - at[Joint::RightShank.index()].z).abs()
            });
            spans.fold(0.0, f32::max)
        };
        // A skirt of strength 0.55 ends at the knees, 2 * 3 * 0.55 cm wider than what is in it.
        let skirt = apart(&walk.under(skirt_gait, 0.55)) + 6.0 * 0.55 * 0.01;
        assert!(skirt < apart(&walk.poses), "{skirt}");
    }
}

#[test]
fn leaning_under_a_load_tips_the_chest_and_leaves_limbs_and_eyes() {
    let walk = Walked::by(4);
    for (leaning, before) in walk.under(load_lean, 1.0).iter().zip(&walk.poses) {
        let (leaning, before) = (walk.model(leaning), walk.model(before));
        let turned = |joint: Joint| {
            let [now, then] = [&leaning, &before].map(|model| model.orientations[joint.index()]);
            let [now, then] = [now, then].map(|axes| Quat::from_mat3(&axes));
            (now * then.inverse())
                .to_scaled_axis()
                .to_array()
                .map(f32::to_degrees)
        };
        // The lean is about the walker's left axis, although pelvis and chest are turned by up to
        // 8 degrees (cosine 0.99).
        let [forward, ..] = turned(Joint::Thorax);
        assert!((forward - 10.0).abs() < 0.2, "{forward}");
        let [head, ..] = turned(Joint::Head);
        assert!((head - 10.0 / 6.0).abs() < 0.2, "{head}");
        for limb in [
            Joint::LeftFoot,
            Joint::RightShank,
            Joint::LeftHand,
            Joint::RightUpperArm,
        ] {
            let length = turned(limb)
                .map(|part| part * part)
                .iter()
                .sum::<f32>()
                .sqrt();
            assert!(length < 0.1, "{limb:?} {length}");
        }
    }
}

#[test]
fn the_old_stoop() {
    let walk = Walked::by(1);
    for (aged, before) in walk.under(age_gait, 1.0).iter().zip(&walk.poses) {
        let [aged, before] = [aged, before].map(|pose| walk.model(pose).positions);
        let ahead = |at: &[Vec3; JOINTS]| (at[Joint::Head.index()] - at[Joint::Pelvis.index()]).z;
        let gained = ahead(&aged) - ahead(&before);
        assert!((0.05..0.15).contains(&gained), "{gained}");
    }
}

#[test]
fn a_limp_tips_the_trunk_over_the_right_leg_alone() {
    let walk = Walked::by(0);
    let limping = walk.under(limp, 1.0);
    let tipped = |frame: usize| {
        let [now, then] = [&limping[frame], &walk.poses[frame]]
            .map(|pose| walk.model(pose).orientations[Joint::Thorax.index()] * Vec3::Y);
        // To the right is -X.
        (then.x - now.x).asin().to_degrees()
    };
    // Of 96 frames from the left heel's contact, the left leg bears alone at 30 %.
    assert!(tipped(29) < 2.0, "{}", tipped(29));
    assert!((8.0..10.5).contains(&tipped(77)), "{}", tipped(77));
}

#[test]
fn a_limping_right_leg_bears_for_two_thirds_of_the_lefts_time() {
    let played = |from: f64, to: f64| {
        let times = (0..100_000).map(|i| f64::from(i) / 1e5);
        let within = times.filter(|&time| (from..to).contains(&(limp_phase(time, 1.0) % 1.0)));
        within.count() as f64 / 1e5
    };
    // 38 % of the even cycle, about the middle of each leg's single support.
    let (left, right) = (played(0.11, 0.49), played(0.61, 0.99));
    assert!((right / left - 0.68).abs() < 0.005, "{right} {left}");
    // Time never runs backwards, and a cycle stays one cycle.
    let phases: Vec<f64> = (0..=100)
        .map(|i| limp_phase(0.01 * f64::from(i), 1.0))
        .collect();
    assert!(phases.is_sorted());
    assert!((phases[100] - phases[0] - 1.0).abs() < 1e-12);
}

#[test]
fn feet_keep_their_place_and_height_on_a_slope() {
    for walk in people() {
        for strength in [-1.0, -0.45, 0.2, 1.0] {
            let slope_rad = (strength * MAX_SLOPE_DEG).to_radians();
            for (sloping, level) in walk.under(slope, strength).iter().zip(&walk.poses) {
                assert_eq!(
                    [sloping.root.x, sloping.root.z],
                    [level.root.x, level.root.z]
                );
                assert!(sloping.root.y <= level.root.y);
                let (now, then) = (walk.positions(sloping), walk.positions(level));
                let turns = [sloping, level].map(|pose| walk.model(pose).orientations);
                for foot in [Joint::LeftFoot, Joint::RightFoot].map(Joint::index) {
                    let ahead = then[foot].z - f64::from(level.root.z);
                    let floor = ahead * slope_rad.tan();
                    let asked = then[foot].with_y(floor + then[foot].y / slope_rad.cos());
                    assert!(now[foot].distance(asked) < 1e-4, "{} {asked}", now[foot]);
                    // As high above the slope as it was above the level floor.
                    let from_below = now[foot] - DVec3::new(0.0, 0.0, level.root.z.into());
                    let height = from_below.dot(floor_normal(strength));
                    assert!((height - then[foot].y).abs() < 1e-4, "{height}");
                    // A sole that lay on the level floor lies on the slope.
                    let sole = turns[0][foot] * (turns[1][foot].transpose() * Vec3::Y);
                    let off = sole.angle_between(floor_normal(strength).as_vec3());
                    assert!(off.to_degrees() < 0.1, "{off}");
                }
            }
        }
    }
}

#[test]
fn knees_bend_forwards_on_a_slope() {
    for walk in people() {
        for strength in [-1.0, -0.2, 0.2, 1.0] {
            for pose in walk.under(slope, strength) {
                for shank in [Joint::LeftShank, Joint::RightShank] {
                    let flexion = pose.rotations[shank.index()]
                        .to_scaled_axis()
                        .x
                        .to_degrees();
                    assert!((-0.1..130.0).contains(&flexion), "{flexion}");
                }
            }
        }
    }
}

#[test]
fn the_mirrored_walker_does_the_same_mirrored() {
    let walk = Walked::by(6);
    let image: Vec<Pose> = walk.poses.iter().map(mirrored).collect();
    let skeleton = walk.gait.skeleton.clone();
    let gait = GaitFacts::from_poses(skeleton, image.iter().cloned(), 1.4, 1.0);
    let image = Walked { gait, poses: image };
    for (name, effect, _) in EFFECTS.iter().filter(|(.., is_even)| *is_even) {
        for strength in [0.5, 1.0] {
            let there = walk.under(*effect, strength);
            for (mirror, pose) in image.under(*effect, strength).iter().zip(there) {
                let off = difference_deg(mirror, &mirrored(&pose));
                assert!(off < 0.02, "{name} {strength}: {off}");
            }
        }
    }
}

#[test]
fn effects_grow_from_nothing_without_a_jump() {
    for walk in people() {
        for (name, effect, _) in EFFECTS {
            for strength in [1e-5, -1e-5] {
                for (pose, before) in walk.under(effect, strength).iter().zip(&walk.poses) {
                    let off = difference_deg(pose, before);
                    assert!(off < 0.3, "{name} {off}");
                    assert!(pose.root.distance(before.root) < 1e-4, "{name}");
                }
            }
        }
    }
}

#[test]
fn loops_stay_closed_and_smooth() {
    for walk in people() {
        let fastest = |poses: &[Pose]| {
            let next = poses.iter().cycle().skip(1);
            let steps = poses.iter().zip(next).map(|(a, b)| difference_deg(a, b));
            steps.fold(0.0, f32::max)
        };
        let even = fastest(&walk.poses);
        for (name, effect, _) in EFFECTS {
            let step = fastest(&walk.under(effect, 1.0));
            // Knees straighten fast to reach down a slope.
            let limit = if name == "slope" { 13.0 } else { 1.3 * even };
            assert!(step < limit, "{name}: {step} after {even}");
        }
    }
}
