//! Tests that the fit recovers the joints of a synthetic walker from virtual markers.

use super::*;
use crate::import::MotionFormat;
use crate::people::cohort::Person;
use crate::people::cohort::STANDING_TILT_DEG;
use crate::people::{Cycle, cutting::events, forward_kinematics};
use edgegait_core::pack::Sex;
use edgegait_core::skeleton::JOINTS;
use glam::DQuat;

const RATE_HZ: f64 = 100.0;

/// True joints of a walker, by frame.
struct Truth {
    positions: Vec<[DVec3; JOINTS]>,
    turns: Vec<[DQuat; JOINTS]>,
    cycle: Cycle,
}

/// Returns two and a half cycles of the average woman at 5 km/h along +Z.
fn truth() -> Truth {
    let person = Person::average(Sex::Female);
    let cycle = person.cycle(5.0);
    let frames = (2.5 * cycle.period_s * RATE_HZ) as usize;
    let count = cycle.root.len();
    let (positions, turns) = (0..frames)
        .map(|frame| {
            let phase = frame as f64 / RATE_HZ / cycle.period_s;
            let at = phase.fract() * count as f64;
            let (i, share) = (at as usize % count, at.fract());
            let j = (i + 1) % count;
            let pose: [DQuat; JOINTS] = std::array::from_fn(|joint| {
                cycle.rotations[i][joint].slerp(cycle.rotations[j][joint], share)
            });
            let root = cycle.root[i].lerp(cycle.root[j], share) + DVec3::Z * cycle.drift_m * phase;
            forward_kinematics(&person.body.offsets, root, &pose)
        })
        .unzip();
    Truth {
        positions,
        turns,
        cycle,
    }
}

/// Returns the virtual markers: name, joint that carries it, and place in the joint's frame,
/// metres.
fn set(truth: &Truth) -> Vec<(&'static str, Joint, DVec3)> {
    let hip_side = truth.positions[0][Joint::LeftThigh.index()]
        .distance(truth.positions[0][Joint::RightThigh.index()])
        / 2.0;
    // Harrington's equations solved for the spines.
    let width = (hip_side - 0.0073) / 0.33;
    let depth = 0.15;
    let tilted = DQuat::from_rotation_x(STANDING_TILT_DEG.to_radians());
    let front = DVec3::new(0.0, 0.30 * width + 0.0109, 0.24 * depth + 0.0099);
    let spine = |x: f64, back: f64| tilted * (front + DVec3::new(x, 0.0, -back));
    let v = DVec3::new;
    use Joint as J;
    vec![
        ("LASI", J::Pelvis, spine(0.5 * width, 0.0)),
        ("RASI", J::Pelvis, spine(-0.5 * width, 0.0)),
        ("LPSI", J::Pelvis, spine(0.05, depth)),
        ("RPSI", J::Pelvis, spine(-0.05, depth)),
        ("LKNE", J::LeftThigh, v(0.055, 0.0, 0.0)),
        ("LKNM", J::LeftThigh, v(-0.055, 0.0, 0.0)),
        ("RKNE", J::RightThigh, v(-0.055, 0.0, 0.0)),
        ("RKNM", J::RightThigh, v(0.055, 0.0, 0.0)),
        ("LTHI", J::LeftThigh, v(0.10, 0.15, 0.01)),
        ("RTHI", J::RightThigh, v(-0.10, 0.15, 0.01)),
        ("LTIB", J::LeftShank, v(0.10, 0.15, 0.0)),
        ("RTIB", J::RightShank, v(-0.10, 0.15, 0.0)),
        ("LANK", J::LeftShank, v(0.04, 0.0, 0.0)),
        ("LMED", J::LeftShank, v(-0.04, 0.0, 0.0)),
        ("RANK", J::RightShank, v(-0.04, 0.0, 0.0)),
        ("RMED", J::RightShank, v(0.04, 0.0, 0.0)),
        ("LHEE", J::LeftFoot, v(0.0, -0.04, -0.05)),
        ("LTOE", J::LeftFoot, v(0.0, -0.04, 0.13)),
        ("RHEE", J::RightFoot, v(0.0, -0.04, -0.05)),
        ("RTOE", J::RightFoot, v(0.0, -0.04, 0.13)),
        ("C7", J::Neck, v(0.0, 0.0, -0.06)),
        ("CLAV", J::Thorax, v(0.0, 0.20, 0.07)),
        ("T10", J::Thorax, v(0.0, 0.06, -0.11)),
        ("STRN", J::Thorax, v(0.0, 0.06, 0.10)),
        ("LFHD", J::Head, v(0.06, 0.05, 0.09)),
        ("RFHD", J::Head, v(-0.06, 0.05, 0.09)),
        ("LBHD", J::Head, v(0.06, 0.05, -0.09)),
        ("RBHD", J::Head, v(-0.06, 0.05, -0.09)),
        ("LSHO", J::LeftUpperArm, v(0.0, 0.04, 0.0)),
        ("RSHO", J::RightUpperArm, v(0.0, 0.04, 0.0)),
        ("LELB", J::LeftForearm, v(0.04, 0.0, 0.0)),
        ("LELBM", J::LeftForearm, v(-0.04, 0.0, 0.0)),
        ("RELB", J::RightForearm, v(-0.04, 0.0, 0.0)),
        ("RELBM", J::RightForearm, v(0.04, 0.0, 0.0)),
        ("LWRA", J::LeftHand, v(0.0, 0.0, 0.03)),
        ("LWRB", J::LeftHand, v(0.0, 0.0, -0.03)),
        ("RWRA", J::RightHand, v(0.0, 0.0, 0.03)),
        ("RWRB", J::RightHand, v(0.0, 0.0, -0.03)),
    ]
}

/// Converts to the convention of C3D files: millimetres, Z up, walking along +X.
fn to_lab(p: DVec3) -> DVec3 {
    DVec3::new(p.z, p.x, p.y) * 1e3
}

/// Returns the markers whose names `keep` accepts. Knee markers turn with the thigh and ankle
/// markers with the shank, at their far ends.
fn markers(truth: &Truth, keep: impl Fn(&str) -> bool) -> Markers {
    let set: Vec<_> = set(truth)
        .into_iter()
        .filter(|(name, ..)| keep(name))
        .collect();
    let at = |frame: usize, name: &str, joint: Joint, offset: DVec3| {
        let centre = match (joint, name.get(1..)) {
            (Joint::LeftThigh, _) => Joint::LeftShank,
            (Joint::RightThigh, _) => Joint::RightShank,
            (Joint::LeftShank, _) => Joint::LeftFoot,
            (Joint::RightShank, _) => Joint::RightFoot,
            _ => joint,
        };
        truth.positions[frame][centre.index()] + truth.turns[frame][joint.index()] * offset
    };
    Markers {
        format: MotionFormat::C3d,
        names: set
            .iter()
            .map(|(name, ..)| format!("Anna:{name}"))
            .collect(),
        sample_rate_hz: RATE_HZ,
        frames: (0..truth.positions.len())
            .map(|frame| {
                set.iter()
                    .map(|&(name, joint, offset)| Some(to_lab(at(frame, name, joint, offset))))
                    .collect()
            })
            .collect(),
        unit_m: Some(1e-3),
        warnings: Vec::new(),
    }
}

fn all(_: &str) -> bool {
    true
}

/// Returns the largest distance of a joint from its true place over the frames, mm. Both are put on
/// one floor.
fn miss_mm(take: &RetargetedMotion, truth: &Truth, joint: Joint) -> f64 {
    let start = (take.start_s * RATE_HZ).round() as usize;
    let height = |frame: usize| {
        take.roots[frame].y - truth.positions[start + frame][Joint::Pelvis.index()].y
    };
    let shift = DVec3::Y * height(0);
    (0..take.len())
        .map(|frame| {
            // The file's heading is +X: a quarter turn from the walker's +Z.
            let turn = DQuat::from_rotation_y(std::f64::consts::FRAC_PI_2);
            let to = turn * truth.positions[start + frame][joint.index()] + shift;
            1e3 * take.joint_positions(frame)[joint.index()].distance(to)
        })
        .fold(0.0, f64::max)
}

const LEGS: [Joint; 6] = [
    Joint::LeftThigh,
    Joint::LeftShank,
    Joint::LeftFoot,
    Joint::RightThigh,
    Joint::RightShank,
    Joint::RightFoot,
];

fn column(markers: &Markers, name: &str) -> usize {
    markers
        .names
        .iter()
        .position(|n| n.ends_with(&format!(":{name}")))
        .unwrap()
}

#[test]
fn legs_with_medial_markers_are_found_within_1_mm_and_arms_within_20() {
    let truth = truth();
    let take = RetargetedMotion::from_markers(&markers(&truth, all), None).unwrap();
    assert!(take.warnings.is_empty(), "{:?}", take.warnings);
    for joint in Joint::ALL {
        let miss = miss_mm(&take, &truth, joint);
        let limit = match joint {
            _ if LEGS.contains(&joint) => 1.0,
            // Their places between markers are conventions; the cohort's own serve as a check.
            Joint::Spine | Joint::Thorax | Joint::LeftClavicle | Joint::RightClavicle => 40.0,
            _ => 20.0,
        };
        assert!(miss < limit, "{joint:?} {miss:.1} mm");
    }
    assert!(take.residual_mm < 5.0, "{}", take.residual_mm);
}

#[test]
fn pelvis_thighs_and_feet_turn_as_the_walker_does() {
    let truth = truth();
    let take = RetargetedMotion::from_markers(&markers(&truth, all), None).unwrap();
    let lab = DQuat::from_rotation_y(std::f64::consts::FRAC_PI_2);
    for (joint, limit_deg) in [
        (Joint::Pelvis, 0.1),
        (Joint::LeftThigh, 1.0),
        (Joint::RightThigh, 1.0),
        (Joint::LeftShank, 1.0),
        (Joint::LeftFoot, 6.0),
        (Joint::RightFoot, 6.0),
        (Joint::Thorax, 6.0),
        (Joint::Head, 6.0),
        (Joint::LeftForearm, 30.0),
    ] {
        let worst = (0..take.len())
            .map(|frame| {
                let (_, turns) =
                    forward_kinematics(&take.offsets, take.roots[frame], &take.rotations[frame]);
                let to = lab * truth.turns[frame][joint.index()];
                turns[joint.index()].angle_between(to).to_degrees()
            })
            .fold(0.0, f64::max);
        assert!(worst < limit_deg, "{joint:?} {worst:.1} degrees");
    }
}

#[test]
fn plug_in_gait_without_medial_markers_finds_the_legs_within_10_mm() {
    let truth = truth();
    let medial = ["LKNM", "RKNM", "LMED", "RMED", "LELBM", "RELBM"];
    let take =
        RetargetedMotion::from_markers(&markers(&truth, |name| !medial.contains(&name)), None)
            .unwrap();
    assert!(take.warnings.is_empty(), "{:?}", take.warnings);
    for joint in LEGS {
        let miss = miss_mm(&take, &truth, joint);
        assert!(miss < 10.0, "{joint:?} {miss:.1} mm");
    }
}

#[test]
fn cycles_have_the_walkers_cadence_and_speed() {
    let truth = truth();
    let take = RetargetedMotion::from_markers(&markers(&truth, all), Some(10.0)).unwrap();
    let cut = events::cut(&take).unwrap();
    assert!(
        (cut.cadence_spm * truth.cycle.period_s / 120.0 - 1.0).abs() < 0.01,
        "{}",
        cut.cadence_spm
    );
    assert!(
        (cut.speed_mps * 3.6 / 5.0 - 1.0).abs() < 0.01,
        "{}",
        cut.speed_mps
    );
}

#[test]
fn any_axes_and_units_give_the_same_take() {
    let truth = truth();
    let plain = RetargetedMotion::from_markers(&markers(&truth, all), None).unwrap();
    for (turn, scale, stated) in [
        (
            DQuat::from_rotation_x(-std::f64::consts::FRAC_PI_2),
            1.0,
            Some(1e-3),
        ),
        (
            DQuat::from_rotation_x(std::f64::consts::PI),
            1e-3,
            Some(1.0),
        ),
        (DQuat::from_rotation_z(2.0), 0.1, Some(0.01)),
    ] {
        let mut other = markers(&truth, all);
        for point in other.frames.iter_mut().flatten().flatten() {
            *point = turn * *point * scale;
        }
        other.unit_m = stated;
        let take = RetargetedMotion::from_markers(&other, None).unwrap();
        for (a, b) in plain.offsets.iter().zip(&take.offsets) {
            assert!(a.distance(*b) < 1e-9, "{a} {b}");
        }
        for (a, b) in plain.rotations.iter().zip(&take.rotations) {
            for joint in 1..JOINTS {
                assert!(a[joint].dot(b[joint]).abs() > 1.0 - 1e-9, "{joint}");
            }
        }
    }
}

#[test]
fn a_wrong_unit_is_told_and_not_used() {
    let truth = truth();
    let mut wrong = markers(&truth, all);
    wrong.unit_m = Some(1.0);
    let take = RetargetedMotion::from_markers(&wrong, None).unwrap();
    assert_eq!(take.unit_m, 1e-3);
    assert!(
        take.warnings[0].starts_with("the stated unit makes the legs"),
        "{:?}",
        take.warnings
    );
}

#[test]
fn a_short_gap_is_filled_and_a_long_one_put_back_from_the_segment() {
    let truth = truth();
    let mut gaps = markers(&truth, all);
    let (ankle, spine) = (column(&gaps, "LANK"), column(&gaps, "RASI"));
    for frame in 60..75 {
        gaps.frames[frame][ankle] = None;
    }
    for frame in 20..120 {
        gaps.frames[frame][spine] = None;
    }
    let take = RetargetedMotion::from_markers(&gaps, None).unwrap();
    assert_eq!(take.len(), truth.positions.len());
    assert_eq!(
        take.warnings,
        [
            "gaps of up to 0.2 s are filled (frames): Anna:LANK 15",
            "rebuilt from at least 3 other markers of their segments (frames): Anna:RASI 100",
        ]
    );
    for joint in LEGS {
        let miss = miss_mm(&take, &truth, joint);
        assert!(miss < 15.0, "{joint:?} {miss:.1} mm");
    }
}

#[test]
fn a_marker_that_is_only_there_midway_cuts_the_take() {
    let truth = truth();
    let mut late = markers(&truth, all);
    let ankle = column(&late, "LANK");
    for frame in &mut late.frames[..90] {
        frame[ankle] = None;
    }
    let take = RetargetedMotion::from_markers(&late, None).unwrap();
    let count = truth.positions.len();
    assert_eq!((take.start_s, take.len()), (0.9, count - 90));
    assert_eq!(
        take.warnings,
        [format!(
            "markers are missing: only frames 90 to {} of {count} are used",
            count - 1
        )]
    );
}

#[test]
fn a_spike_and_exchanged_ankles_are_repaired() {
    let truth = truth();
    let mut faulty = markers(&truth, all);
    let (left, right) = (column(&faulty, "LANK"), column(&faulty, "RANK"));
    let heel = column(&faulty, "RHEE");
    *faulty.frames[50][heel].as_mut().unwrap() += DVec3::X * 4000.0;
    // The feet are far apart at the contact, after a whole cycle.
    let from = (truth.cycle.period_s * RATE_HZ) as usize;
    for frame in &mut faulty.frames[from..] {
        frame.swap(left, right);
    }
    let take = RetargetedMotion::from_markers(&faulty, None).unwrap();
    let said = |part: &str| take.warnings.iter().any(|w| w.contains(part));
    assert!(
        said(&format!("change places at frame {from}")),
        "{:?}",
        take.warnings
    );
    assert!(
        said("marker Anna:RHEE jumps at frame 50"),
        "{:?}",
        take.warnings
    );
    for joint in LEGS {
        let miss = miss_mm(&take, &truth, joint);
        assert!(miss < 2.0, "{joint:?} {miss:.1} mm");
    }
}

#[test]
fn sides_named_the_wrong_way_round_are_exchanged() {
    let truth = truth();
    let plain = RetargetedMotion::from_markers(&markers(&truth, all), None).unwrap();
    let mut wrong = markers(&truth, all);
    for name in &mut wrong.names {
        *name = match name.strip_prefix("Anna:L") {
            Some(rest) => format!("Anna:R{rest}"),
            None => name.replace("Anna:R", "Anna:L"),
        };
    }
    let take = RetargetedMotion::from_markers(&wrong, None).unwrap();
    assert!(
        take.warnings[0].contains("wrong way round"),
        "{:?}",
        take.warnings
    );
    for (a, b) in plain.offsets.iter().zip(&take.offsets) {
        assert!(a.distance(*b) < 1e-9, "{a} {b}");
    }
}

#[test]
fn legs_alone_walk_under_an_upright_trunk_with_arms_that_swing_against_them() {
    let truth = truth();
    let lower = ["ASI", "PSI", "THI", "KNE", "TIB", "ANK", "HEE", "TOE"];
    let take =
        RetargetedMotion::from_markers(&markers(&truth, |name| lower.contains(&&name[1..])), None)
            .unwrap();
    assert_eq!(
        take.warnings,
        [
            "no markers of the trunk and the head: they stay upright and turn with the pelvis",
            "no markers of the left and the right arm: it swings with the other leg, as in the norm",
        ]
    );
    // Hands swing to either side of the hip by some 15 cm, ahead with the other foot.
    let ahead = |frame: usize, joint: Joint| {
        let points = take.joint_positions(frame);
        (points[joint.index()] - points[Joint::Pelvis.index()]).x
    };
    let products: Vec<f64> = (0..take.len())
        .map(|i| ahead(i, Joint::LeftHand) * ahead(i, Joint::RightFoot))
        .collect();
    assert!(products.iter().sum::<f64>() > 0.0);
    let head = take.joint_positions(10)[Joint::Head.index()].y;
    let true_head = truth.positions[10][Joint::Head.index()].y;
    assert!((head - true_head).abs() < 0.06, "{head} {true_head}");
}

#[test]
fn knees_without_markers_bend_ahead() {
    let truth = truth();
    let few = ["ASI", "PSI", "ANK", "HEE"];
    let take =
        RetargetedMotion::from_markers(&markers(&truth, |name| few.contains(&&name[1..])), None)
            .unwrap();
    assert!(
        take.warnings.iter().any(|w| w
            == "left lateral knee: no marker: it bends forward as far as hip and ankle require")
    );
    for joint in [Joint::LeftShank, Joint::RightShank] {
        let miss = miss_mm(&take, &truth, joint);
        assert!(miss < 60.0, "{joint:?} {miss:.1} mm");
    }
}

#[test]
fn a_set_without_a_pelvis_is_refused_by_name() {
    let truth = truth();
    let refuse = |keep: &dyn Fn(&str) -> bool| {
        RetargetedMotion::from_markers(&markers(&truth, keep), None).unwrap_err()
    };
    let error = refuse(&|name| name != "RASI");
    assert_eq!(
        error,
        "no marker for the right anterior superior iliac spine (LASI, RASI): no name in the file matches"
    );
    let error = refuse(&|name| name != "LPSI");
    assert!(error.contains("sacrum (SACR, or LPSI and RPSI)"), "{error}");
    let error = refuse(&|name| name != "LANK" && name != "LMED");
    assert!(error.contains("left lateral ankle (LANK, RANK)"), "{error}");
}
