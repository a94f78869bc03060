//! Joint angles of synthetic and recorded people, measured in the same way on the drawn bodies.

use super::walkers::{is_patient, set_of};
use edgegait::people::{Subject, Track, forward_kinematics};
use edgegait_core::skeleton::Joint;
use glam::{DQuat, DVec3};
use std::collections::BTreeMap;

/// The measures of a cycle.
const NAMES: [&str; 26] = [
    "speed m/s",
    "stride m",
    "step width cm",
    "pelvis tilt",
    "trunk lean",
    "neck lean",
    "head pitch",
    "pelvis bob cm",
    "pelvis sway cm",
    "trunk sway",
    "arm forward",
    "arm swing",
    "arm abduction",
    "elbow mean",
    "elbow range",
    "hip mean",
    "hip range",
    "hip adduction",
    "knee mean",
    "knee least",
    "knee most",
    "ankle mean",
    "ankle range",
    "toe-out",
    "shoulders/hips",
    "hips/leg",
];

/// A function for a number of one side of a pose. It takes the joints' places and rotations; the
/// upper arm, elbow, wrist, hip and knee of that side; and 1 on the left, -1 on the right.
type OfSide<'a> = &'a dyn Fn(&[DVec3], &[DQuat], [Joint; 5], f64) -> f64;

/// Returns the degrees by which a direction leans to the front, seen from the side.
fn ahead(of: DVec3) -> f64 {
    of.z.atan2(of.y).to_degrees()
}

/// Returns the measures of one walk.
fn measures(person: &Subject, walk: &edgegait::people::Walk) -> Vec<f64> {
    let Track::Loop(cycle) = &walk.motion else {
        panic!("{}: expected a cycle", walk.name);
    };
    let offsets = &person.body.offsets;
    let frames: Vec<_> = cycle
        .root
        .iter()
        .zip(&cycle.rotations)
        .map(|(&root, rotations)| forward_kinematics(offsets, root, rotations))
        .collect();
    let series = |of: &dyn Fn(&[DVec3], &[DQuat]) -> f64| -> Vec<f64> {
        frames
            .iter()
            .map(|(points, turns)| of(points, turns))
            .collect()
    };
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let most = |values: &[f64]| values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let least = |values: &[f64]| values.iter().copied().fold(f64::INFINITY, f64::min);
    let range = |values: &[f64]| most(values) - least(values);
    let at = |points: &[DVec3], joint: Joint| points[joint.index()];
    let along = |points: &[DVec3], from: Joint, to: Joint| at(points, to) - at(points, from);
    // The mean over both sides.
    let sides = |of: OfSide<'_>, what: &dyn Fn(&[f64]) -> f64| {
        let left = [
            Joint::LeftUpperArm,
            Joint::LeftForearm,
            Joint::LeftHand,
            Joint::LeftThigh,
            Joint::LeftShank,
        ];
        let one = |joints: [Joint; 5], side: f64| what(&series(&|p, t| of(p, t, joints, side)));
        0.5 * (one(left, 1.0) + one(left.map(Joint::mirrored), -1.0))
    };
    let foot = |joints: [Joint; 5]| {
        if joints[0].is_left() {
            Joint::LeftFoot
        } else {
            Joint::RightFoot
        }
    };
    let bent = |a: DVec3, b: DVec3| a.angle_between(b).to_degrees();
    // The ankles are farthest apart along the way in double support, about when a heel lands.
    let reach = series(&|p, _| along(p, Joint::RightFoot, Joint::LeftFoot).z);
    let widths = series(&|p, _| along(p, Joint::RightFoot, Joint::LeftFoot).x);
    let extreme = |sign: f64| {
        (0..reach.len())
            .max_by(|&a, &b| (sign * reach[a]).total_cmp(&(sign * reach[b])))
            .expect("a frame")
    };
    let width = 50.0 * (widths[extreme(1.0)] + widths[extreme(-1.0)]);
    let elbow = |p: &[DVec3], _: &[DQuat], j: [Joint; 5], _: f64| {
        bent(along(p, j[0], j[1]), along(p, j[1], j[2]))
    };
    let hip = |p: &[DVec3], t: &[DQuat], j: [Joint; 5], _: f64| {
        ahead(-(t[0].inverse() * along(p, j[3], j[4])) * DVec3::new(1.0, 1.0, -1.0))
    };
    let knee = |p: &[DVec3], _: &[DQuat], j: [Joint; 5], _: f64| {
        bent(along(p, j[3], j[4]), along(p, j[4], foot(j)))
    };
    let ankle = |_: &[DVec3], t: &[DQuat], j: [Joint; 5], _: f64| {
        let turn = t[j[4].index()].inverse() * t[foot(j).index()];
        let toes = turn * DVec3::Z;
        toes.y.atan2(toes.z).to_degrees()
    };
    let arm = |p: &[DVec3], _: &[DQuat], j: [Joint; 5], _: f64| {
        let arm = along(p, j[0], j[1]);
        arm.z.atan2(-arm.y).to_degrees()
    };
    let trunk = |p: &[DVec3]| along(p, Joint::Pelvis, Joint::Neck);
    let leg = |p: &[DVec3]| {
        along(p, Joint::LeftThigh, Joint::LeftShank).length()
            + along(p, Joint::LeftShank, Joint::LeftFoot).length()
    };
    vec![
        walk.speed_mps,
        cycle.drift_m,
        width,
        mean(&series(&|_, t| {
            let y = t[0] * DVec3::Y;
            ahead(y)
        })),
        mean(&series(&|p, _| ahead(trunk(p)))),
        mean(&series(&|p, _| ahead(along(p, Joint::Neck, Joint::Head)))),
        mean(&series(&|_, t| ahead(t[Joint::Head.index()] * DVec3::Y))),
        100.0 * range(&series(&|p, _| p[0].y)),
        100.0 * range(&series(&|p, _| p[0].x)),
        range(&series(&|p, _| trunk(p).x.atan2(trunk(p).y).to_degrees())),
        sides(&arm, &mean),
        sides(&arm, &range),
        sides(
            &|p, _, j, side| {
                let arm = along(p, j[0], j[1]);
                (side * arm.x).atan2(-arm.y).to_degrees()
            },
            &mean,
        ),
        sides(&elbow, &mean),
        sides(&elbow, &range),
        sides(&hip, &mean),
        sides(&hip, &range),
        sides(
            &|p, t, j, side| {
                let thigh = t[0].inverse() * along(p, j[3], j[4]);
                (-side * thigh.x).atan2(-thigh.y).to_degrees()
            },
            &mean,
        ),
        sides(&knee, &mean),
        sides(&knee, &least),
        sides(&knee, &most),
        sides(&ankle, &mean),
        sides(&ankle, &range),
        sides(
            &|_, t, j, side| {
                let toes = t[foot(j).index()] * DVec3::Z;
                (side * toes.x).atan2(toes.z).to_degrees()
            },
            &mean,
        ),
        mean(&series(&|p, _| {
            along(p, Joint::RightUpperArm, Joint::LeftUpperArm).length()
                / along(p, Joint::RightThigh, Joint::LeftThigh).length()
        })),
        mean(&series(&|p, _| {
            along(p, Joint::RightThigh, Joint::LeftThigh).length() / leg(p)
        })),
    ]
}

/// Prints the mean of each measure over people and its standard deviation, by dataset.
pub fn print(made: &[Subject], recorded: &[Subject]) {
    let mut sets: BTreeMap<&str, Vec<Vec<f64>>> = BTreeMap::new();
    for person in made
        .iter()
        .chain(recorded)
        .filter(|person| !is_patient(person))
    {
        let walks: Vec<Vec<f64>> = person
            .walks
            .iter()
            .map(|walk| measures(person, walk))
            .collect();
        let mean = |at: usize| walks.iter().map(|walk| walk[at]).sum::<f64>() / walks.len() as f64;
        let of_person: Vec<f64> = (0..NAMES.len()).map(mean).collect();
        sets.entry(set_of(person))
            .or_default()
            .push(of_person.clone());
        if set_of(person) == "made" {
            for (walk, of_walk) in person.walks.iter().zip(walks) {
                sets.entry(&walk.name).or_default().push(of_walk);
            }
        } else {
            sets.entry("recorded").or_default().push(of_person);
        }
    }
    print!("{:<16}", "degrees, or as said");
    for (set, people) in &sets {
        print!(
            "{:>16}",
            format!(
                "{} {}",
                set.chars().take(12).collect::<String>(),
                people.len()
            )
        );
    }
    println!();
    for (at, name) in NAMES.iter().enumerate() {
        print!("{name:<16}   ");
        for people in sets.values() {
            let mean = people.iter().map(|of| of[at]).sum::<f64>() / people.len() as f64;
            let squares: f64 = people.iter().map(|of| (of[at] - mean).powi(2)).sum();
            let deviation = (squares / (people.len() as f64 - 1.0).max(1.0)).sqrt();
            print!("{:>16}", format!("{mean:.2} +-{deviation:.2}"));
        }
        println!();
    }
}
