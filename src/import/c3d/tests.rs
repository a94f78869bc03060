//! Tests with files that are laid out by hand, byte by byte, after the format's user guide.

use std::io::Cursor;

use super::*;

/// Group, name, type, dimensions and data of a parameter.
type Record = (u8, &'static str, u8, Vec<u8>, Vec<u8>);

/// Two points in three frames: a first marker at (1.5, -2, 0.5), a second that comes and goes.
/// The numbers of each machine are typed here, not computed.
struct Fixture {
    machine: u8,
    floats: bool,
    /// Parameters beyond the usual ones.
    added: Vec<Record>,
    points: u16,
    last_frame: u16,
}

impl Fixture {
    const fn new(machine: u8, floats: bool) -> Self {
        Self {
            machine,
            floats,
            added: Vec::new(),
            points: 2,
            last_frame: 12,
        }
    }

    fn word(&self, value: u16) -> [u8; 2] {
        match self.machine {
            86 => value.to_be_bytes(),
            _ => value.to_le_bytes(),
        }
    }

    /// Returns the IEEE 754 or VAX F bytes of the numbers that occur. Both are listed, the most
    /// significant word first.
    fn real(&self, value: &str) -> [u8; 4] {
        let (ieee, vax): (u32, u32) = match value {
            "0" => (0, 0),
            "-1" => (0xBF80_0000, 0xC080_0000),
            "0.5" => (0x3F00_0000, 0x4000_0000),
            "1.5" => (0x3FC0_0000, 0x40C0_0000),
            "-2" => (0xC000_0000, 0xC100_0000),
            "50" => (0x4248_0000, 0x4348_0000),
            "nan" => (0x7FC0_0000, 0x8000_0000),
            "70000" => (0x4788_B800, 0x4888_B800),
            _ => panic!("no bytes for {value}"),
        };
        match self.machine {
            84 => ieee.to_le_bytes(),
            86 => ieee.to_be_bytes(),
            _ => {
                let [b, a, d, c] = vax.to_be_bytes();
                [a, b, c, d]
            }
        }
    }

    fn bytes(&self) -> Vec<u8> {
        let mut bytes = vec![2, 80];
        for word in [self.points, 1, 10, self.last_frame, 0] {
            bytes.extend(self.word(word));
        }
        // Half a unit a count, or floats.
        bytes.extend(self.real(if self.floats { "-1" } else { "0.5" }));
        bytes.extend(self.word(3));
        bytes.extend(self.word(1));
        bytes.extend(self.real("50"));
        bytes.resize(512, 0);

        bytes.extend([1, 80, 1, self.machine]);
        for (id, name) in [(255, "POINT"), (254, "TRIAL")] {
            bytes.extend([5, id]);
            bytes.extend(name.bytes());
            bytes.extend(self.word(3));
            bytes.push(0);
        }
        let labels = b"LANKRHEESURP".to_vec();
        let usual = [
            (1, "UNITS", 255, vec![4], b"mm\0 ".to_vec()),
            (1, "LABELS", 255, vec![4, 3], labels),
        ];
        for (group, name, kind, dimensions, data) in usual.iter().chain(&self.added) {
            bytes.extend([u8::try_from(name.len()).unwrap(), *group]);
            bytes.extend(name.bytes());
            let size = 2 + 2 + dimensions.len() + data.len() + 1;
            bytes.extend(self.word(u16::try_from(size).unwrap()));
            bytes.extend([*kind, u8::try_from(dimensions.len()).unwrap()]);
            bytes.extend(dimensions);
            bytes.extend(data);
            bytes.push(0);
        }
        assert!(bytes.len() < 1024);
        bytes.resize(1024, 0);

        let second = if self.floats {
            [
                ["1.5", "0.5", "-2", "0"],
                ["nan", "0", "0", "0"],
                ["1.5", "0.5", "-2", "-1"],
            ]
        } else {
            [
                ["1.5", "0.5", "-2", "0"],
                ["0", "0", "0", "0"],
                ["1.5", "0.5", "-2", "-1"],
            ]
        };
        for point in second {
            for value in ["1.5", "-2", "0.5", "0"].iter().chain(&point) {
                if self.floats {
                    bytes.extend(self.real(value));
                } else {
                    // Counts of a half; the residual is itself.
                    let counts: u16 = match *value {
                        "0" => 0,
                        "0.5" => 1,
                        "1.5" => 3,
                        "-2" => 0xFFFC,
                        _ => 0xFFFF,
                    };
                    bytes.extend(self.word(counts));
                }
            }
            let analog: &[u8] = if self.floats { &[9, 9, 9, 9] } else { &[9, 9] };
            bytes.extend(analog);
        }
        bytes
    }
}

fn parse(bytes: &[u8]) -> Result<Markers> {
    let length = bytes.len() as u64;
    read_from(
        Path::new("t.c3d"),
        Cursor::new(bytes.to_vec()),
        length,
        None,
    )
}

fn problem(bytes: &[u8]) -> String {
    parse(bytes).unwrap_err().to_string()
}

#[test]
fn all_machines_and_both_encodings_give_the_same_points() {
    let first = Some(DVec3::new(1.5, -2.0, 0.5));
    let second = Some(DVec3::new(1.5, 0.5, -2.0));
    for machine in [84, 85, 86] {
        for floats in [false, true] {
            let markers = parse(&Fixture::new(machine, floats).bytes()).unwrap();
            assert_eq!(markers.names, ["LANK", "RHEE"]);
            assert_eq!(
                markers.frames,
                [[first, second], [first, None], [first, None]],
                "{machine} {floats}"
            );
            assert_eq!(markers.sample_rate_hz.to_bits(), 50f64.to_bits());
            assert_eq!(markers.unit_m, Some(0.001));
            assert!(markers.warnings.is_empty(), "{:?}", markers.warnings);
        }
    }
}

#[test]
fn lists_of_angles_and_named_type_groups_are_left_out() {
    for (list, added) in [
        ("ANGLES", Vec::new()),
        (
            "QUATERNIONS",
            vec![(
                1,
                "TYPE_GROUPS",
                255,
                vec![12, 2],
                b"QUATERNIONS QUATERNION  ".to_vec(),
            )],
        ),
    ] {
        let mut fixture = Fixture::new(84, true);
        fixture.added = added;
        fixture
            .added
            .push((1, list, 255, vec![6, 1], b"LANK  ".to_vec()));
        let markers = parse(&fixture.bytes()).unwrap();
        assert_eq!(markers.names, ["RHEE"], "{list}");
        assert_eq!(markers.frames[0], [Some(DVec3::new(1.5, 0.5, -2.0))]);
    }
}

#[test]
fn labels_go_on_in_labels2_and_points_without_any_are_left_out() {
    let mut fixture = Fixture::new(86, false);
    fixture.points = 4;
    fixture.last_frame = 10;
    fixture.added = vec![(1, "LABELS2", 255, vec![4, 1], b"LTOE".to_vec())];
    let mut bytes = fixture.bytes();
    let frame = bytes[1024..1040].to_vec();
    bytes.truncate(1024);
    bytes.extend(frame.repeat(2));
    bytes.extend([0, 0]);
    assert_eq!(
        parse(&bytes).unwrap().names,
        ["LANK", "RHEE", "SURP", "LTOE"]
    );
    fixture.added.clear();
    let mut unnamed = fixture.bytes();
    unnamed.truncate(1024);
    unnamed.extend(frame.repeat(2));
    unnamed.extend([0, 0]);
    let markers = parse(&unnamed).unwrap();
    assert_eq!(markers.names, ["LANK", "RHEE", "SURP"]);
    assert_eq!(
        markers.warnings,
        ["1 points have no label: they are not used"]
    );
}

#[test]
fn frames_beyond_16_bits_are_counted_by_the_trial() {
    for (group, name, kind, data) in [
        // 1 and 70000 = 0x11170, the low word first.
        (2, "ACTUAL_END_FIELD", 2, vec![0x70, 0x11, 1, 0]),
        (1, "LONG_FRAMES", 4, vec![0, 0xB8, 0x88, 0x47]),
    ] {
        let mut fixture = Fixture::new(84, false);
        fixture.last_frame = 65_535;
        let dimensions = if kind == 2 { vec![2] } else { vec![] };
        fixture.added = vec![
            (2, "ACTUAL_START_FIELD", 2, vec![2], vec![1, 0, 0, 0]),
            (group, name, kind, dimensions, data),
        ];
        let bytes = fixture.bytes();
        assert_eq!(
            problem(&bytes),
            format!(
                "t.c3d at byte {}: the file ends after 3 of 70000 frames (is it truncated?)",
                bytes.len()
            ),
            "{name}"
        );
    }
}

#[test]
fn every_cut_is_refused_where_it_is() {
    let whole = Fixture::new(85, true).bytes();
    for cut in 0..whole.len() {
        let message = problem(&whole[..cut]);
        let place = format!("t.c3d at byte {cut}: ");
        assert!(cut == 0 || message.starts_with(&place), "{message}");
    }
    assert_eq!(problem(&[]), "t.c3d: the file is empty");
}

#[test]
fn no_byte_of_the_header_or_the_parameters_can_cause_a_panic() {
    let whole = Fixture::new(84, true).bytes();
    for at in 0..640 {
        for value in [0, 1, 2, 127, 128, 254, 255] {
            let mut damaged = whole.clone();
            damaged[at] = value;
            if let Ok(markers) = parse(&damaged) {
                assert!(markers.frames.len() <= 3 * 36, "byte {at} = {value}");
            }
        }
    }
}

#[test]
fn damaged_parameters_are_refused_where_they_are() {
    let whole = Fixture::new(84, true).bytes();
    let with = |at: usize, value: u8| {
        let mut damaged = whole.clone();
        damaged[at] = value;
        problem(&damaged)
    };
    // The first records: POINT at 516, TRIAL at 526, UNITS at 536, its type at 545.
    assert_eq!(&whole[538..543], b"UNITS");
    assert_eq!(
        with(538, 0),
        "t.c3d at byte 536: expected a parameter, found a name that is not ASCII (is the file damaged?)"
    );
    assert_eq!(
        with(545, 3),
        "t.c3d at byte 545: parameter UNITS: expected type -1, 1, 2 or 4, found 3"
    );
    assert_eq!(
        with(546, 8),
        "t.c3d at byte 545: parameter UNITS: expected at most 7 dimensions, found 8"
    );
    assert_eq!(
        with(547, 255),
        "t.c3d at byte 545: parameter UNITS: its 255 bytes of data do not fit the 5 bytes up to the next parameter or the section's end (is the file damaged?)"
    );
    assert_eq!(
        with(515, 83),
        "t.c3d at byte 515: expected processor 84, 85 or 86, found 83"
    );
    assert_eq!(
        with(1, 79),
        "t.c3d at byte 0: expected a C3D header (parameter block, 80), found 2 79"
    );
    assert_eq!(with(2, 0), "t.c3d: no markers: the file has 0 points");
}

#[test]
fn names_of_subjects_are_not_kept() {
    let mut fixture = Fixture::new(84, true);
    fixture.added = vec![(3, "NAMES", 255, vec![4, 1], b"Anna".to_vec())];
    let shown = format!("{:?}", parse(&fixture.bytes()).unwrap());
    assert!(!shown.contains("Anna"));
}

#[test]
fn counts_beyond_16_bits_are_settled_by_the_length_of_the_file() {
    // Saturated, and wrapped: frames 10 to 70009 less 65536.
    for (last_frame, stated) in [(65_535, [0xFF, 0xFF]), (4_473, [0xFF, 0xFF])] {
        let mut fixture = Fixture::new(84, true);
        fixture.last_frame = last_frame;
        fixture
            .added
            .push((1, "FRAMES", 2, vec![], stated.to_vec()));
        let bytes = fixture.bytes();
        let (head, frames) = bytes.split_at(1024);
        let frame = &frames[..36];
        let mut long = head.to_vec();
        long.extend(frame.repeat(70_000));
        long.resize(long.len().next_multiple_of(512), 0);
        let markers = parse(&long).unwrap();
        assert_eq!(markers.frames.len(), 70_000, "{last_frame}");
        let said = markers.warnings.join("; ");
        assert!(said.contains("16 bits do not hold"), "{said}");
    }
}
