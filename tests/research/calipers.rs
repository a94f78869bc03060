//! Makes the errors of measured bodies in src/guide/importing.md: calipers on decoded walkers.

use crate::data::given;
use crate::means::mean;
use crate::walker::{Moment, at_ease, bodies, import_person};
use edgegait_core::pack::Pack;
use edgegait_core::skeleton::Joint;
use glam::DVec3;
use std::collections::BTreeMap;
use std::fs;

/// Dimensions of `--bodies`, with the largest error of the mean over all people and of the worst
/// person, percent. Points of hulls are rounded by up to 2 mm at either end, which is 4 % of a
/// foot's breadth.
const BOUNDS: [(&str, f64, f64); 9] = [
    ("stature", 0.1, 0.5),
    ("trochanterion_height", 0.1, 0.5),
    ("knee_height", 0.1, 0.5),
    ("hip_breadth", 0.2, 1.0),
    ("bideltoid_breadth", 0.2, 1.0),
    ("chest_depth", 0.2, 1.0),
    ("foot_length", 0.2, 2.0),
    ("foot_breadth", 0.7, 4.0),
    ("head_breadth", 0.5, 2.5),
];

/// Returns the extent of points along a direction.
fn reach(points: impl Iterator<Item = DVec3>, along: DVec3) -> f64 {
    let along = points.map(|point| point.dot(along));
    let (low, high) = along.fold((f64::MAX, f64::MIN), |(low, high), at| {
        (low.min(at), high.max(at))
    });
    high - low
}

/// Returns a dimension of a walker, the mean over the moments, metres.
fn dimension(name: &str, moments: &[Moment]) -> f64 {
    use Joint::{
        Head, LeftFoot, LeftShank, LeftThigh, LeftUpperArm, Pelvis, RightThigh, RightUpperArm,
        Thorax,
    };
    let own = |moment: &Moment, joint: Joint, axis: DVec3| {
        reach(moment.hull(joint), moment.turn(joint) * axis)
    };
    let between = |moment: &Moment, a: Joint, b: Joint| moment.of(a).distance(moment.of(b));
    let ankle = |moment: &Moment| {
        let (up, at) = (moment.turn(LeftFoot) * DVec3::Y, moment.of(LeftFoot));
        let depths = moment.hull(LeftFoot).map(|point| (at - point).dot(up));
        depths.fold(0.0, f64::max)
    };
    let knee = |moment: &Moment| between(moment, LeftShank, LeftFoot) + ankle(moment);
    let leg = |moment: &Moment| between(moment, LeftThigh, LeftShank) + knee(moment);
    let of = |moment: &Moment| match name {
        "stature" => {
            let hips = moment.of(LeftThigh).midpoint(moment.of(RightThigh));
            let crown = moment.hull(Head).map(|point| point.y);
            leg(moment) + crown.fold(f64::MIN, f64::max) - hips.y
        }
        "trochanterion_height" => leg(moment),
        "knee_height" => knee(moment),
        "hip_breadth" => own(moment, Pelvis, DVec3::X),
        "bideltoid_breadth" => {
            let [left, right] = [LeftUpperArm, RightUpperArm].map(|arm| moment.of(arm));
            // Measure the deltoids, not the elbows.
            let deltoids = [LeftUpperArm, RightUpperArm].into_iter().flat_map(|arm| {
                let shoulder = moment.of(arm);
                let points = moment.hull(arm);
                points.filter(move |point| point.distance(shoulder) < 0.14)
            });
            reach(deltoids, (left - right).normalize())
        }
        "chest_depth" => own(moment, Thorax, DVec3::Z),
        "foot_length" => own(moment, LeftFoot, DVec3::Z),
        "foot_breadth" => own(moment, LeftFoot, DVec3::X),
        "head_breadth" => own(moment, Head, DVec3::X),
        _ => panic!("{name}"),
    };
    mean(moments.iter().map(of))
}

mod slow_of_data {
    use super::*;

    #[test]
    #[ignore = "slow without optimisation; needs EDGEGAIT_DATA"]
    fn measured_bodies_have_the_dimensions_that_were_measured() {
        let data = given();
        let folder = tempfile::tempdir().expect("a folder");
        let at = folder.path();
        let mut off: BTreeMap<&str, Vec<f64>> = BTreeMap::new();
        for person in bodies(&data) {
            import_person(at, &data, &person, "mean");
            let bytes = fs::read(at.join(person["id"].clone() + ".egp")).expect("a pack");
            let pack = Pack::parse(&bytes).expect("a pack");
            for walk in pack.walks() {
                let moments = [at_ease(&pack, walk.subject)];
                for (name, _, _) in BOUNDS {
                    let given: f64 = person[&format!("{name}_m")].parse().expect("a length");
                    let found = dimension(name, &moments);
                    off.entry(name)
                        .or_default()
                        .push(100.0 * (found / given - 1.0));
                }
            }
        }
        let mut missed = Vec::new();
        for (name, mean_most, most) in BOUNDS {
            let off = &off[name];
            let mean = mean(off.iter().copied());
            let worst =
                off.iter().copied().fold(
                    0.0,
                    |worst: f64, off| {
                        if off.abs() > worst.abs() { off } else { worst }
                    },
                );
            println!("{name:<22} off by {mean:>5.2} % on average, {worst:>5.2} % at worst");
            if mean.abs() >= mean_most || worst.abs() >= most {
                missed.push(name);
            }
        }
        assert!(missed.is_empty(), "{missed:?}");
    }
}
