use super::*;
use crate::people::BodyHull;
use crate::people::cohort::{CohortOptions, Dressing, Person, subject};

fn decoded(encoded: &EncodedAvatar) -> Vec<(Joint, Vec<DVec3>)> {
    let avatar = Avatar::parse(&encoded.bytes).expect("it was checked");
    let points = |hull: edgegait_core::avatar::Hull<'_>| {
        let points: Vec<DVec3> = hull.points().map(Vec3::as_dvec3).collect();
        assert_eq!(points.len(), hull.len());
        (hull.joint(), points)
    };
    avatar.hulls().map(points).collect()
}

/// Returns a body with a single hull.
fn alone(joint: Joint, points: Vec<DVec3>) -> Body {
    Body {
        offsets: [DVec3::ZERO; JOINTS],
        hulls: vec![BodyHull { joint, points }],
        draped: Vec::new(),
        clothes: None,
        fit: None,
    }
}

/// Returns a box of 20 cm by 40 cm by 10 cm whose points of negative x are `bulge` further out.
fn lopsided_box(bulge: f64) -> Vec<DVec3> {
    let mut points = Vec::new();
    for x in [-0.1 - bulge, 0.1] {
        for y in [0.0, 0.4] {
            points.extend([-0.05, 0.05].map(|z| DVec3::new(x, y, z)));
        }
    }
    points
}

#[test]
fn points_return_within_the_error_and_it_is_stated() {
    let mut body = alone(
        Joint::Head,
        (0..32)
            .map(|i| DVec3::new(f64::from(i) * 0.01, (f64::from(i) * 0.7).sin(), -0.2))
            .collect(),
    );
    body.offsets[1] = DVec3::new(0.0, 0.123_46, -0.05);
    let encoded = encode_avatar(&body, 3.0).expect("a body within the budget");
    assert!(encoded.max_error_mm <= 3.0, "{}", encoded.max_error_mm);
    assert!(encoded.max_error_mm > 2.5, "{}", encoded.max_error_mm);
    let avatar = Avatar::parse(&encoded.bytes).expect("it was checked");
    let stated = f64::from(avatar.max_error_mm());
    assert!(stated > encoded.max_error_mm - 1e-4 && stated < encoded.max_error_mm + 0.0101);
    let spine = avatar.skeleton().offsets[1];
    assert!((spine.y - 0.1235).abs() < 1e-6 && (spine.z + 0.05).abs() < 1e-6);
}

#[test]
fn an_error_of_zero_gives_the_finest_steps_and_says_what_they_reach() {
    // The farthest coordinate is 1 m: steps of 1 / 16383 m are 61.04, rounded up 62 um.
    let points = vec![DVec3::new(1.0, 0.000_03, 0.0), DVec3::new(0.0, 0.0, 0.5)];
    let encoded = encode_avatar(&alone(Joint::Head, points), 0.0).expect("a body");
    assert_eq!(encoded.bytes[2..4], [62, 0]);
    // 1 m is 16,129.03 steps: 2 um off. 30 um is half a step, which rounds to 0.
    assert!((encoded.max_error_mm - 0.030_07).abs() < 1e-4);
    assert_eq!(encoded.bytes[..2], [4, 0]);
}

#[test]
fn a_body_beyond_the_budget_is_refused() {
    let mut body = alone(Joint::Head, vec![DVec3::ZERO; 33]);
    assert!(encode_avatar(&body, 2.0).is_err());
    body.hulls[0].points = vec![DVec3::new(0.0, -3.3, 0.0)];
    let error = encode_avatar(&body, 2.0).expect_err("3.3 m").to_string();
    assert!(error.contains("units"), "{error}");
    body.hulls.clear();
    body.offsets[3].x = 3.3;
    let error = encode_avatar(&body, 2.0).expect_err("3.3 m").to_string();
    assert!(error.contains("units"), "{error}");
}

#[test]
fn every_body_of_the_cohort_is_within_its_error_and_stored_by_its_half() {
    let mut sizes = Vec::new();
    for max_error_mm in [0.4, 1.0, 2.0, 4.0] {
        let mut bytes = 4;
        for index in 0..26 {
            let body = Person::of_cohort(1, index).expect("a person").body;
            let encoded = encode_avatar(&body, max_error_mm).expect("a body");
            assert!(encoded.max_error_mm <= max_error_mm);
            assert!(encoded.max_error_mm > 0.9 * max_error_mm);
            // Five trunk hulls, seven of the left limbs, and a symmetric skeleton.
            assert_eq!(encoded.bytes[4], SYMMETRIC_SKELETON | 12);
            bytes += 4 + encoded.bytes.len();
            let found = decoded(&encoded);
            assert_eq!(found.len(), body.hulls.len());
            for (joint, points) in &found {
                let mut hulls = body.hulls.iter().filter(|hull| hull.joint == *joint);
                let hull = hulls.next().expect("a hull of the joint");
                assert!(distance(&hull.points, points) * 1e3 <= encoded.max_error_mm);
            }
        }
        println!("26 bodies at {max_error_mm} mm: {bytes} bytes");
        sizes.push(bytes);
    }
    assert!(sizes.is_sorted_by(|fine, coarse| fine > coarse));
}

#[test]
fn dressed_people_are_within_the_error_and_what_hangs_is_stored_by_its_half() {
    let options = |dressed| CohortOptions {
        speeds_kmh: vec![5.0],
        dressed,
        ..CohortOptions::default()
    };
    let encoded = |dressed, number| {
        let body = subject(&options(dressed), number).expect("a person").body;
        (encode_avatar(&body, 2.0).expect("a body"), body)
    };
    let mut most = 0;
    for number in 0..26 {
        let (bare, _) = encoded(None, number);
        let (found, body) = encoded(Some(Dressing::ForGood), number);
        assert!(found.max_error_mm <= 2.0);
        most = most.max(found.bytes.len() - bare.bytes.len());
        let avatar = Avatar::parse(&found.bytes).expect("it was checked");
        assert_eq!(avatar.clothes(), body.clothes);
        assert_eq!(avatar.drawn_hulls(), body.hulls.len() + body.draped.len());
        for (drape, parts) in body.draped.iter().enumerate() {
            let of_this = |hull: &edgegait_core::avatar::Hull<'_>| hull.drape() == Some(drape);
            let read: Vec<_> = avatar.hulls().filter(of_this).collect();
            assert_eq!(read.len(), parts.len());
            for part in read {
                let points: Vec<DVec3> = part.points().map(Vec3::as_dvec3).collect();
                let given = parts.iter().find(|given| given.joint == part.joint());
                let given = given.expect("a part of this joint");
                assert!(distance(&given.points, &points) <= 0.002_001);
            }
        }
        // Five trunk hulls, seven limbs and the clothes' parts of the left and the middle.
        let left = |part: &&BodyHull| part.joint <= part.joint.mirrored();
        let parts = body.draped.iter().flatten().filter(left).count();
        assert_eq!(found.bytes[4], SYMMETRIC_SKELETON | (12 + parts as u8));
    }
    // 59 points in halves of at most 3 bytes each, and their headers.
    assert!((60..160).contains(&most), "{most}");
}

#[test]
fn more_that_hangs_than_the_format_holds_is_refused() {
    let part = |joint| BodyHull {
        joint,
        points: vec![DVec3::X],
    };
    let with = |drapes: usize, parts: usize| {
        let mut body = alone(Joint::Head, vec![DVec3::Y]);
        body.draped = vec![vec![part(Joint::Head); parts]; drapes];
        encode_avatar(&body, 2.0)
    };
    assert!(with(4, 4).is_ok() && with(1, 8).is_ok());
    for (drapes, parts) in [(5, 1), (1, 9), (1, 0)] {
        let error = with(drapes, parts).expect_err("too much").to_string();
        assert!(error.contains("4 draped ones of 1 to 8 parts"), "{error}");
    }
    let mut body = alone(Joint::Head, vec![DVec3::Y]);
    body.draped = vec![vec![part(Joint::Head)]];
    body.draped[0][0].points = vec![DVec3::X; 33];
    assert!(encode_avatar(&body, 2.0).is_err());
}

#[test]
fn a_mirrored_hull_is_read_with_its_exact_image() {
    let body = Person::of_cohort(1, 3).expect("a person").body;
    let found = decoded(&encode_avatar(&body, 2.0).expect("a body"));
    for pair in found[5..].chunks_exact(2) {
        let [(left, points), (right, images)] = pair else {
            panic!("a pair");
        };
        assert!(left.is_left() && *right == left.mirrored());
        let expected: Vec<_> = points.iter().map(|p| DVec3::new(-p.x, p.y, p.z)).collect();
        assert_eq!(*images, expected);
    }
}

#[test]
fn a_hull_is_stored_by_its_half_only_where_that_is_within_the_error() {
    let half = |joint, points| {
        let encoded = encode_avatar(&alone(joint, points), 2.0).expect("a body");
        // After the header: 5 bits of width, 54 bits of offsets that are 0, and a joint.
        let mut bits = edgegait_core::bits::BitReader::new(&encoded.bytes[5..]);
        bits.skip(
            5 + if encoded.bytes[4] & SYMMETRIC_SKELETON == 0 {
                54
            } else {
                29
            } + 5,
        );
        (bits.unsigned(1) == 1, encoded.max_error_mm)
    };
    assert!(half(Joint::Spine, lopsided_box(0.0)).0);
    assert!(half(Joint::LeftShank, lopsided_box(0.0)).0);
    let (is_half, error) = half(Joint::Spine, lopsided_box(0.001));
    assert!(is_half && error <= 2.0);
    let (is_half, error) = half(Joint::Spine, lopsided_box(0.005));
    assert!(!is_half && error <= 2.0);
}

#[test]
fn hulls_of_both_sides_are_stored_once_only_where_that_is_within_the_error() {
    let hulls = |bulge: f64| {
        let right = lopsided_box(0.02);
        let left = lopsided_box(0.02 + bulge);
        let mut body = alone(Joint::RightThigh, right.clone());
        body.hulls.push(BodyHull {
            joint: Joint::LeftThigh,
            points: left.iter().map(|p| DVec3::new(-p.x, p.y, p.z)).collect(),
        });
        let encoded = encode_avatar(&body, 2.0).expect("a body");
        assert!(encoded.max_error_mm <= 2.0, "{}", encoded.max_error_mm);
        let found = decoded(&encoded);
        for (hull, joint) in body.hulls.iter().zip([Joint::RightThigh, Joint::LeftThigh]) {
            let (_, points) = found.iter().find(|(j, _)| *j == joint).expect("a thigh");
            assert!(distance(&hull.points, points) * 1e3 <= encoded.max_error_mm);
        }
        encoded.bytes[4] & 0x3f
    };
    assert_eq!(hulls(0.0), 1);
    assert_eq!(hulls(0.001), 1);
    assert_eq!(hulls(0.006), 2);
}

#[test]
fn a_skeleton_that_is_not_symmetric_keeps_all_offsets_to_a_tenth_of_a_millimetre() {
    let made = Person::of_cohort(1, 0).expect("a person").body;
    let sizes = [0.0, 0.000_1].map(|longer| {
        let mut body = made.clone();
        body.offsets[Joint::RightShank.index()].y -= longer;
        let encoded = encode_avatar(&body, 2.0).expect("a body");
        let flag = encoded.bytes[4] & SYMMETRIC_SKELETON;
        assert_eq!(flag == 0, longer > 0.0);
        let avatar = Avatar::parse(&encoded.bytes).expect("an avatar");
        for (offset, found) in body.offsets.iter().zip(avatar.skeleton().offsets) {
            let off = (*offset - found.as_dvec3()).abs().max_element();
            assert!(off < 0.05e-3 + 1e-7, "{off}");
        }
        encoded.bytes.len()
    });
    assert!(sizes[0] < sizes[1]);
}

#[test]
fn points_that_round_to_the_same_become_one() {
    let mut points = lopsided_box(0.02);
    let close: Vec<_> = points.iter().map(|&p| p + DVec3::splat(1e-6)).collect();
    points.extend(close);
    let encoded = encode_avatar(&alone(Joint::Neck, points), 2.0).expect("a body");
    assert_eq!(decoded(&encoded)[0].1.len(), 8);
}
