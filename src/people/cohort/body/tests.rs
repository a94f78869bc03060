use super::super::anthropometry::{DIMENSIONS, PopulationNorms};
use super::*;
use edgegait_core::facets::Facets;
use edgegait_core::pack::Sex;

fn man() -> Dimensions {
    Dimensions::expected(1.756, 85.4, Some(Sex::Male), &[0.0; DIMENSIONS]).expect("a plausible man")
}

/// All hull points in the rest pose with the soles on the floor.
fn standing(d: &Dimensions) -> Vec<(Joint, DVec3)> {
    let body = body(d, offsets(d));
    let mut positions = [DVec3::new(0.0, d.trochanterion_height, 0.0); JOINTS];
    for joint in Joint::ALL {
        if let Some(parent) = joint.parent() {
            positions[joint.index()] = positions[parent.index()] + body.offsets[joint.index()];
        }
    }
    let points = body.hulls.iter().flat_map(|hull| {
        let at = positions[hull.joint.index()];
        hull.points.iter().map(move |&p| (hull.joint, at + p))
    });
    points.collect()
}

#[test]
fn a_body_stands_as_tall_and_wide_as_it_was_measured() {
    let d = man();
    let points = standing(&d);
    let max = |axis: usize| points.iter().map(|(_, p)| p[axis]).fold(f64::MIN, f64::max);
    let min = |axis: usize| points.iter().map(|(_, p)| p[axis]).fold(f64::MAX, f64::min);
    assert!((max(1) - 1.756).abs() < 1e-9);
    assert!(min(1).abs() < 1e-9);
    assert!((max(0) - min(0) - d.bideltoid_breadth).abs() < 0.01);
}

#[test]
fn breadths_and_depths_are_those_asked_for() {
    let d = man();
    let points = standing(&d);
    let span = |joint: Joint, axis: usize| {
        let along = || {
            points
                .iter()
                .filter(|(j, _)| *j == joint)
                .map(|(_, p)| p[axis])
        };
        along().fold(f64::MIN, f64::max) - along().fold(f64::MAX, f64::min)
    };
    assert!((span(Joint::Pelvis, 0) - d.hip_breadth).abs() < 1e-9);
    assert!((span(Joint::Spine, 0) - d.waist_breadth).abs() < 1e-9);
    assert!((span(Joint::Head, 0) - d.head_breadth).abs() < 1e-9);
    assert!((span(Joint::LeftFoot, 2) - d.foot_length).abs() < 1e-9);
}

#[test]
fn left_and_right_mirror_each_other() {
    let d = man();
    let body = body(&d, offsets(&d));
    for hull in &body.hulls {
        let other: Vec<_> = body
            .hulls
            .iter()
            .filter(|h| h.joint == hull.joint.mirrored())
            .collect();
        let [other] = other.as_slice() else {
            panic!("one hull a joint")
        };
        assert_eq!(other.points.len(), hull.points.len());
    }
}

const SEXES: [Sex; 2] = [Sex::Female, Sex::Male];

/// Returns the dimensions of a person of mean stature and this mass index; of the mean one without.
fn average(sex: Sex, bmi: Option<f64>) -> Dimensions {
    let norms = PopulationNorms::for_sex(sex);
    let stature = norms.stature.0;
    let mass = bmi.unwrap_or(norms.bmi.0) * stature * stature;
    Dimensions::expected(stature, mass, Some(sex), &[0.0; DIMENSIONS]).expect("a plausible person")
}

/// Returns where the joints are in the rest pose, relative to the hips.
fn joints(d: &Dimensions) -> [DVec3; JOINTS] {
    let offsets = offsets(d);
    let mut at = [DVec3::ZERO; JOINTS];
    for joint in Joint::ALL {
        if let Some(parent) = joint.parent() {
            at[joint.index()] = at[parent.index()] + offsets[joint.index()];
        }
    }
    at
}

/// Returns the points of a joint's hull relative to the hips.
fn hull(d: &Dimensions, joint: Joint) -> Vec<DVec3> {
    let at = joints(d)[joint.index()];
    let body = body(d, offsets(d));
    let hull = body.hulls.iter().find(|hull| hull.joint == joint);
    let points = &hull.expect("one hull a joint").points;
    points.iter().map(|point| at + *point).collect()
}

/// Returns the centre of a hull's volume.
fn centre(points: &[DVec3]) -> DVec3 {
    let rounded: Vec<_> = points.iter().map(|point| point.as_vec3()).collect();
    let (mut volume, mut moment) = (0.0, DVec3::ZERO);
    for facet in &Facets::from_points(&rounded).facets {
        let [a, b, c] = facet
            .corners
            .map(|corner| points[usize::from(corner)] - points[0]);
        let six = a.dot(b.cross(c));
        volume += six;
        moment += six * 0.25 * (a + b + c);
    }
    points[0] + moment / volume
}

/// Returns the least and the greatest x and z of a hull at a height.
fn section(points: &[DVec3], height: f64) -> [(f64, f64); 2] {
    let mut spans = [(f64::MAX, f64::MIN); 2];
    for a in points.iter().filter(|point| point.y <= height) {
        for b in points.iter().filter(|point| point.y > height) {
            let at = *a + (*b - *a) * ((height - a.y) / (b.y - a.y));
            for (span, value) in spans.iter_mut().zip([at.x, at.z]) {
                *span = (span.0.min(value), span.1.max(value));
            }
        }
    }
    spans
}

#[test]
fn segments_have_their_volume_where_studies_have_their_mass() {
    // Dumas & Wojtusch 2018, tables 2 to 4, 8 and 9, of women and of men: behind the hips at the
    // standing pelvic tilt, metres, of widths between the iliac spines of 238 and 224 mm; behind
    // the lines from hip to knee and from knee to ankle, and ahead of those from the thorax's joint
    // to the neck's and from the spine's to the thorax's, as shares of their lengths.
    for (sex, pelvis, thigh, shank, chest, abdomen) in [
        (Sex::Female, 0.040, 0.077, 0.049, 0.015, 0.219),
        (Sex::Male, 0.043, 0.041, 0.048, 0.0, 0.176),
    ] {
        let d = average(sex, None);
        let joints = joints(&d);
        let at = |joint: Joint| joints[joint.index()];
        // How far the centre is ahead of the line between two joints.
        let ahead = |joint, from: Joint, to: Joint| {
            let (centre, from, to) = (centre(&hull(&d, joint)), at(from), at(to));
            let along = (centre.y - from.y) / (to.y - from.y);
            centre.z - from.z - along * (to.z - from.z)
        };
        let near = |found: f64, published: f64, tolerance: f64| {
            assert!(
                (found - published).abs() < tolerance,
                "{sex:?} {found} {published}"
            );
        };
        let length = |joint: Joint| -offsets(&d)[joint.index()].y;
        near(
            -ahead(Joint::LeftShank, Joint::LeftShank, Joint::LeftFoot) / length(Joint::LeftFoot),
            shank,
            0.008,
        );
        // Women's thighs include more of the buttocks than ours.
        near(
            -ahead(Joint::LeftThigh, Joint::LeftThigh, Joint::LeftShank) / length(Joint::LeftShank),
            thigh,
            0.032,
        );
        // Our pelvis includes the groin.
        near(-centre(&hull(&d, Joint::Pelvis)).z, pelvis, 0.022);
        let rise = |low: Joint, high: Joint| at(high).y - at(low).y;
        near(
            ahead(Joint::Thorax, Joint::Thorax, Joint::Neck),
            chest * rise(Joint::Thorax, Joint::Neck),
            0.012,
        );
        near(
            ahead(Joint::Spine, Joint::Spine, Joint::Thorax),
            abdomen * rise(Joint::Spine, Joint::Thorax),
            0.022,
        );
    }
}

#[test]
fn heads_and_shoulders_are_carried_as_people_stand_at_ease() {
    for sex in SEXES {
        let d = average(sex, None);
        let joints = joints(&d);
        let tragus = joints[Joint::Head.index()];
        // 15 mm in a standard and 57 mm in a comfortable posture.
        assert!((0.015..0.057).contains(&tragus.z), "{}", tragus.z);
        let neck = joints[Joint::Neck.index()];
        let at_c7 = hull(&d, Joint::Neck);
        let back = at_c7.iter().filter(|point| (point.y - neck.y).abs() < 1e-9);
        let nape = DVec3::new(
            0.0,
            neck.y,
            back.map(|point| point.z).fold(f64::MAX, f64::min),
        );
        // Raine & Twomey 1997: 48.9 and 53.7 degrees above horizontal.
        let angle =
            |from: DVec3, to: DVec3| libm::atan2(to.y - from.y, (to.z - from.z).abs()).to_degrees();
        assert!((angle(nape, tragus) - 48.9).abs() < 0.5);
        let mut shoulder = joints[Joint::LeftUpperArm.index()];
        shoulder.y += 0.5 * SHOULDER_DROP * d.stature;
        assert!((angle(shoulder, nape) - 53.7).abs() < 0.5);
        assert!(shoulder.z > nape.z);
    }
}

#[test]
fn necks_are_narrower_than_heads_and_heads_are_vaulted() {
    for sex in SEXES {
        for bmi in [18.0, 25.0, 37.0] {
            let d = average(sex, Some(bmi));
            let neck = hull(&d, Joint::Neck);
            let breadth = 2.0 * neck.iter().map(|point| point.x).fold(f64::MIN, f64::max);
            assert!(breadth < 0.8 * d.head_breadth + 1e-9, "{sex:?} {bmi}");
            let head = hull(&d, Joint::Head);
            let crown = d.stature - d.trochanterion_height;
            for (below, least, most) in [(0.005, 0.2, 0.5), (0.02, 0.5, 0.75), (0.05, 0.8, 0.97)] {
                let [(left, right), (back, front)] = section(&head, crown - below);
                for share in [
                    (right - left) / d.head_breadth,
                    (front - back) / d.head_length,
                ] {
                    assert!((least..most).contains(&share), "{sex:?} {below} {share}");
                }
            }
        }
    }
}

#[test]
fn legs_are_as_deep_as_their_circumferences_and_no_deeper_than_the_buttocks() {
    for sex in SEXES {
        for bmi in [18.0, 25.0, 37.0] {
            let d = average(sex, Some(bmi));
            let deepest = |points: &[DVec3]| {
                let z = points.iter().map(|point| point.z);
                (
                    z.clone().fold(f64::MAX, f64::min),
                    z.fold(f64::MIN, f64::max),
                )
            };
            let thigh = deepest(&hull(&d, Joint::LeftThigh));
            let pelvis = deepest(&hull(&d, Joint::Pelvis));
            assert!(
                thigh.0 > pelvis.0 - 0.002 && thigh.1 < pelvis.1,
                "{sex:?} {bmi}"
            );
            let shank = -offsets(&d)[Joint::LeftFoot.index()].y;
            let calf = d.knee_height - d.trochanterion_height - 0.28 * shank;
            let [(left, right), (back, front)] = section(&hull(&d, Joint::LeftShank), calf);
            let across = d.calf_circumference / std::f64::consts::PI;
            // An octagon of that circumference is 2.6 % wider than the circle.
            for width in [right - left, front - back] {
                assert!(
                    (1.0..1.06).contains(&(width / across)),
                    "{sex:?} {bmi} {width}"
                );
            }
        }
    }
}
