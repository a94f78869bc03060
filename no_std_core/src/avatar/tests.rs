use super::*;

/// The body of `FORMAT.md`'s pack by hand: the left thigh at x = 9 cm and the left
/// shank 42 cm below it, and a symmetric hull of the thigh. Its bits end at 5 * 8 + 153.
const BY_HAND: [u8; 25] = [
    0xc8, 0x00, 0x88, 0x13, 0x01, 0x0e, 0x00, 0x00, 0x00, 0x00, 0x12, 0x0e, 0x88, 0xf9, 0x02, 0x80,
    0x96, 0x81, 0xb0, 0x10, 0x2b, 0x03, 0x01, 0x09, 0x00,
];

/// Returns `BY_HAND` with this bit of its stream flipped.
fn turned(bit: usize) -> [u8; 25] {
    let mut bytes = BY_HAND;
    bytes[AVATAR_HEADER_BYTES + bit / 8] ^= 1 << (bit % 8);
    bytes
}

fn error(bytes: &[u8]) -> FormatError {
    Avatar::parse(bytes).expect_err("no avatar")
}

fn assert_points(found: impl IntoIterator<Item = Vec3>, expected: &[[f32; 3]]) {
    let mut expected = expected.iter();
    for found in found {
        let expected = expected.next().expect("no more points");
        let distance = (found - Vec3::from(*expected)).length();
        assert!(distance < 1e-6, "{found} {expected:?}");
    }
    assert!(expected.next().is_none());
}

#[test]
fn a_hull_lies_in_the_frame_of_its_joint() {
    let avatar = Avatar::parse(&BY_HAND).expect("a whole avatar");
    assert!((avatar.max_error_mm() - 2.0).abs() < 1e-6);
    assert_eq!(avatar.len_bytes(), 25);
    let hull = avatar.hulls().next().expect("a hull");
    assert_eq!(hull.joint(), Joint::LeftThigh);
    assert_points(
        hull.points(),
        &[[0.0, -0.42, 0.06], [0.05, 0.005, 0.0], [-0.05, 0.005, 0.0]],
    );
}

#[test]
fn a_fitted_body_states_its_jaccard_index_before_its_offsets() {
    // 9,696 of 10,000.
    let fitted = [&BY_HAND[..4], &[0x81, 0xe0, 0x25], &BY_HAND[5..]].concat();
    let avatar = Avatar::parse(&fitted).expect("a whole avatar");
    let jaccard = avatar.jaccard().expect("a fitted body");
    assert!((jaccard - 0.9696).abs() < 1e-6, "{jaccard}");
    let plain = Avatar::parse(&BY_HAND).expect("a whole avatar");
    assert_eq!(plain.jaccard(), None);
    assert_eq!(avatar.skeleton(), plain.skeleton());
    for length in 0..fitted.len() {
        assert!(error(&fitted[..length]).byte <= length);
    }
}

#[test]
fn the_image_of_a_mirrored_hull_belongs_to_the_joint_on_the_other_side() {
    // The sixth bit of the hull, which begins at bit 87.
    let bytes = turned(93);
    let avatar = Avatar::parse(&bytes).expect("a mirrored hull");
    let joints = avatar.hulls().map(|hull| hull.joint());
    assert!(joints.eq([Joint::LeftThigh, Joint::RightThigh]));
    let image = avatar.hulls().nth(1).expect("the image");
    assert_points(
        image.points(),
        &[[0.0, -0.42, 0.06], [-0.05, 0.005, 0.0], [0.05, 0.005, 0.0]],
    );
}

#[test]
fn a_symmetric_skeleton_has_its_right_side_from_its_left_one() {
    // Joint j is at (j, 2 j, 3 j) x 0.1 mm; those in the middle have no x.
    let mut fields = heapless::Vec::<(i32, usize), 100>::new();
    fields.push((7, 5)).expect("a field");
    for joint in Joint::ALL
        .into_iter()
        .skip(1)
        .filter(|&j| j <= j.mirrored())
    {
        let is_middle = joint == joint.mirrored();
        for axis in i32::from(is_middle)..3 {
            let value = (axis + 1) * joint.index() as i32;
            fields.extend([(1, 1), (value, 7)]);
        }
    }
    let mut bytes = [0; 64];
    bytes[2] = 1;
    bytes[4] = SYMMETRIC_SKELETON;
    let stream = crate::bits::packed(&fields);
    let end = AVATAR_HEADER_BYTES + stream.len();
    bytes[AVATAR_HEADER_BYTES..end].copy_from_slice(&stream);
    let avatar = Avatar::parse(&bytes[..end]).expect("a skeleton without hulls");
    assert_eq!(avatar.hulls().count(), 0);
    let offset = |joint: Joint| (avatar.skeleton().offsets[joint.index()] * 1e4).round();
    assert_points(
        [
            Joint::Pelvis,
            Joint::Head,
            Joint::LeftHand,
            Joint::RightHand,
        ]
        .map(offset),
        &[
            [0.0; 3],
            [0.0, 8.0, 12.0],
            [8.0, 16.0, 24.0],
            [-8.0, 16.0, 24.0],
        ],
    );
    assert_points(
        [Joint::LeftFoot, Joint::RightFoot].map(offset),
        &[[15.0, 30.0, 45.0], [-15.0, 30.0, 45.0]],
    );
}

#[test]
fn every_truncation_is_refused_with_a_byte_within_the_avatar() {
    for length in 0..BY_HAND.len() {
        let error = error(&BY_HAND[..length]);
        assert!(error.byte <= length, "{length}: {error}");
    }
}

#[test]
fn what_is_wrong_is_refused_with_its_byte() {
    let with = |at: usize, byte: u8| {
        let mut bytes = BY_HAND;
        bytes[at] = byte;
        error(&bytes)
    };
    // A step of 0.
    let mut bytes = BY_HAND;
    bytes[2..4].fill(0);
    assert_eq!(error(&bytes).byte, 2);
    // A Jaccard index of 0x120e = 4,622 that leads to offsets of 8 bits.
    assert!(Avatar::parse(&[&BY_HAND[..4], &[0x81], &BY_HAND[5..]].concat()).is_err());
    // One of 10,001.
    let fitted = [&BY_HAND[..4], &[0x81, 0x11, 0x27], &BY_HAND[5..]].concat();
    assert_eq!(error(&fitted).byte, 5);
    // Offsets of 17 bits.
    assert_eq!(with(5, 17).byte, 5);
    // One hull too many or too few.
    assert_eq!(with(4, 2).byte, 25);
    assert!(Avatar::parse(&[&BY_HAND[..4], &[0], &BY_HAND[5..]].concat()).is_err());
    // Joint 13 + 16 from bit 87 on, in byte 5 + 10.
    assert_eq!(error(&turned(91)).byte, 15);
    // Two of one point in the middle: bit 1 of a field at 116, of a row at 113.
    assert_eq!(error(&turned(117)).byte, 19);
    // A bit after the last hull.
    assert_eq!(error(&turned(153)).byte, 24);
    // A byte after the end.
    assert_eq!(error(&[BY_HAND.as_slice(), &[0]].concat()).byte, 25);
}

#[test]
fn a_right_hull_has_no_image() {
    // Joint 13 without its lowest bit is 12, the right hand.
    let mut bytes = turned(87);
    assert!(Avatar::parse(&bytes).is_ok());
    bytes[AVATAR_HEADER_BYTES + 93 / 8] ^= 1 << (93 % 8);
    assert_eq!(error(&bytes).byte, AVATAR_HEADER_BYTES + 92 / 8);
}

/// Returns an avatar without offsets, with `stored` hulls, whose `fields` follow the offsets.
fn avatar_of(stored: u8, fields: &[(i32, usize)]) -> heapless::Vec<u8, 400> {
    let mut all = heapless::Vec::<(i32, usize), 400>::new();
    all.push((0, 5 + 54)).expect("no offsets");
    all.extend_from_slice(fields).expect("400 fields");
    let mut bytes = heapless::Vec::new();
    bytes.extend([0, 0, 1, 0, stored]);
    bytes
        .extend_from_slice(&crate::bits::packed(&all))
        .expect("400 bytes");
    bytes
}

/// Returns a part whose points are all at 0, `points` of them a row. A mirrored part belongs to a
/// left joint.
fn part(joint: i32, is_mirrored: i32, points: i32) -> [(i32, usize); 6] {
    [
        (joint, 5),
        (0, 1),
        (is_mirrored, 1),
        (0, 2 + 5 + 12),
        (points - 1, 3),
        (0, 0),
    ]
}

#[test]
fn parts_of_a_draped_hull_say_so_and_are_one_hull() {
    // The head alone, then a skirt on the pelvis and both thighs, and the neck.
    let fields = [
        &part(4, 0, 1)[..],
        &[(31, 5), (1, 3)],
        &part(0, 0, 2),
        &part(13, 1, 1),
        &part(3, 0, 1),
    ]
    .concat();
    let bytes = avatar_of(4, &fields);
    let avatar = Avatar::parse(&bytes).expect("an avatar");
    let found = avatar.hulls().map(|hull| (hull.joint(), hull.drape()));
    assert!(found.eq([
        (Joint::Head, None),
        (Joint::Pelvis, Some(0)),
        (Joint::LeftThigh, Some(0)),
        (Joint::RightThigh, Some(0)),
        (Joint::Neck, None),
    ]));
    assert_eq!((avatar.drawn_hulls(), avatar.clothes()), (3, None));
    // Without its last part.
    let cut = [&[(31, 5), (1, 3)][..], &part(0, 0, 1)].concat();
    assert_eq!(error(&avatar_of(1, &cut)).byte, 4);
}

#[test]
fn draped_hulls_are_few_and_small() {
    let drapes = |count: usize, parts: i32| {
        let one = [(31, 5), (parts - 1, 3)];
        let mut fields = heapless::Vec::<(i32, usize), 400>::new();
        for _ in 0..count {
            fields.extend(one);
            (0..parts).for_each(|_| fields.extend(part(0, 0, 8)));
        }
        let stored = u8::try_from(count).expect("a few") * u8::try_from(parts).expect("8");
        let bytes = avatar_of(stored, &fields);
        Avatar::parse(&bytes).map(|avatar| avatar.drawn_hulls())
    };
    assert_eq!(drapes(4, 4), Ok(4));
    for beyond in [drapes(5, 1), drapes(1, 5)] {
        let error = beyond.expect_err("beyond the budget");
        assert_eq!(error.expected, "at most 4 draped hulls of 32 points each");
    }
}

#[test]
fn clothes_stand_before_the_first_hull() {
    let dressed = |bits: i32| {
        let fields = [&[(30, 5), (bits, 8)][..], &part(4, 0, 1)].concat();
        avatar_of(1, &fields)
    };
    let bytes = dressed(0b11_0110);
    let avatar = Avatar::parse(&bytes).expect("an avatar");
    let clothes = avatar.clothes().expect("a dressed one");
    assert_eq!(clothes.bits(), 0b11_0110);
    assert_eq!(
        avatar.hulls().next().map(|hull| hull.joint()),
        Some(Joint::Head)
    );
    for unknown in [3, 3 << 2, 1 << 7] {
        // After the header and 59 bits without offsets.
        assert_eq!(error(&dressed(unknown)).byte, 5 + 59 / 8);
    }
    for length in 0..bytes.len() {
        assert!(error(&bytes[..length]).byte <= length);
    }
}

#[test]
fn images_count_for_the_budget() {
    // Hulls of one point at 0 of the left foot: all bits zero except joint and flag.
    let parse = |hulls: u8, is_mirrored: i32| {
        let mut fields = heapless::Vec::<(i32, usize), 400>::new();
        fields.push((0, 5 + 54)).expect("no offsets");
        for _ in 0..hulls {
            fields.extend([(15, 5), (0, 1), (is_mirrored, 1), (0, 2 + 5 + 12 + 3)]);
        }
        let mut bytes = heapless::Vec::<u8, 400>::new();
        bytes.extend([0, 0, 1, 0, hulls]);
        bytes
            .extend_from_slice(&crate::bits::packed(&fields))
            .expect("400 bytes");
        Avatar::parse(&bytes).map(|avatar| avatar.hulls().count())
    };
    assert_eq!(parse(32, 0), Ok(32));
    assert_eq!(parse(16, 1), Ok(32));
    assert!(parse(33, 0).is_err());
    let error = parse(17, 1).expect_err("34 hulls");
    // The 17th begins at bit 59 + 16 * 29.
    assert_eq!(error.byte, 5 + 523 / 8);
}
