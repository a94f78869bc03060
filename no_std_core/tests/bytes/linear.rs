//! Tests of linear recognizers: their answers against sums in i64 and f64, and bytes that are
//! rejected.

use crate::random::Random;
use edgegait_core::camera::Framing;
use edgegait_core::format::{FormatError, crc32};
use edgegait_core::linear::LinearRecognizer;
use edgegait_core::silhouette::Size;

/// A class as in `FORMAT.md`.
#[derive(Clone)]
struct Class {
    scale: f32,
    bias: f32,
    weights: Vec<i8>,
    name: &'static str,
}

impl Class {
    fn of(size: Size, weight: i8) -> Self {
        Self {
            scale: 1.0,
            bias: 0.0,
            weights: vec![weight; size.pixels()],
            name: "somebody",
        }
    }

    fn random(size: Size, random: &mut Random) -> Self {
        let mut weight = || (random.below(256) as u8).cast_signed();
        Self {
            weights: (0..size.pixels()).map(|_| weight()).collect(),
            scale: random.between(1e-6, 1e-3) as f32,
            bias: random.between(-100.0, 100.0) as f32,
            name: "Ünal",
        }
    }
}

/// Returns a file of these classes.
fn file(size: Size, classes: &[Class]) -> Vec<u8> {
    let mut bytes = b"EGLR\0\0\0\0\x01\0".to_vec();
    let small = |number: usize| u8::try_from(number).expect("a byte");
    bytes.extend([
        small(size.rows()),
        small(size.columns()),
        0,
        small(classes.len()),
    ]);
    for class in classes {
        bytes.extend([class.scale.to_le_bytes(), class.bias.to_le_bytes()].as_flattened());
    }
    for class in classes {
        bytes.extend(class.weights.iter().map(|weight| weight.cast_unsigned()));
    }
    for class in classes {
        bytes.push(small(class.name.len()));
        bytes.extend(class.name.bytes());
    }
    with_true_crc(bytes)
}

fn with_true_crc(mut bytes: Vec<u8>) -> Vec<u8> {
    let crc = crc32(&bytes[8..]).to_le_bytes();
    bytes[4..8].copy_from_slice(&crc);
    bytes
}

fn error(bytes: &[u8]) -> FormatError {
    LinearRecognizer::parse(bytes).expect_err("no recognizer")
}

fn pixels(size: Size, random: &mut Random) -> Vec<u8> {
    (0..size.pixels())
        .map(|_| random.below(256) as u8)
        .collect()
}

#[test]
fn scores_are_the_sums_of_products_rounded_three_times() {
    let mut random = Random(8);
    for size in Size::ALL {
        let classes: Vec<Class> = (0..7).map(|_| Class::random(size, &mut random)).collect();
        let bytes = file(size, &classes);
        let recognizer = LinearRecognizer::parse(&bytes).expect("a recognizer");
        assert_eq!((recognizer.classes(), recognizer.size()), (7, size));
        let mut answers = [0; 7];
        for _ in 0..50 {
            let pixels = pixels(size, &mut random);
            let mut expected = Vec::new();
            for (number, class) in classes.iter().enumerate() {
                let products = class.weights.iter().zip(&pixels);
                let sum: i64 = products.map(|(&w, &p)| i64::from(w) * i64::from(p)).sum();
                let exact = f64::from(class.scale) * sum as f64 + f64::from(class.bias);
                // f64 holds a product of two f32 exactly, and rounding a sum of two first to f64
                // changes nothing (Figueroa 1995).
                let product = f64::from(class.scale) * f64::from(sum as f32);
                let score = (f64::from(product as f32) + f64::from(class.bias)) as f32;
                assert_eq!(recognizer.score(number, &pixels), Some(score));
                assert!((f64::from(score) - exact).abs() < 1e-4 * (1.0 + exact.abs()));
                expected.push(score);
            }
            let best = (0..7).max_by(|&a, &b| expected[a].total_cmp(&expected[b]));
            let best = best.expect("seven classes");
            assert_eq!(recognizer.classify(&pixels), Some((best, expected[best])));
            answers[best] += 1;
        }
        assert!(answers.iter().filter(|count| **count > 0).count() > 2);
    }
}

#[test]
fn the_largest_sums_do_not_overflow() {
    let size = Size::S64x64;
    let bytes = file(size, &[Class::of(size, -128), Class::of(size, 127)]);
    let recognizer = LinearRecognizer::parse(&bytes).expect("a recognizer");
    let white = [255; 64 * 64];
    assert_eq!(recognizer.score(0, &white), Some(-133_693_440.0));
    // 132,648,960 = 4,096 x 32,385 has 24 significant bits.
    assert_eq!(recognizer.classify(&white), Some((1, 132_648_960.0)));
}

#[test]
fn numbers_beyond_f32_are_infinite_and_never_nan() {
    let size = Size::S50x30;
    let loud = Class {
        scale: f32::MAX,
        bias: -f32::MAX,
        ..Class::of(size, 1)
    };
    let bytes = file(size, &[loud]);
    let recognizer = LinearRecognizer::parse(&bytes).expect("a recognizer");
    assert_eq!(recognizer.classify(&[255; 1_500]), Some((0, f32::INFINITY)));
    assert_eq!(recognizer.classify(&[0; 1_500]), Some((0, -f32::MAX)));
}

#[test]
fn of_equal_scores_the_first_is_the_answer() {
    let size = Size::S64x44;
    let classes = [1, 3, 3, 2].map(|weight| Class::of(size, weight));
    let bytes = file(size, &classes);
    let recognizer = LinearRecognizer::parse(&bytes).expect("a recognizer");
    let mut pixels = vec![0; size.pixels()];
    pixels[7] = 5;
    assert_eq!(recognizer.classify(&pixels), Some((1, 15.0)));
    assert_eq!(recognizer.classify(&vec![0; size.pixels()]), Some((0, 0.0)));
}

#[test]
fn pixels_of_another_size_have_no_score() {
    let size = Size::S50x30;
    let bytes = file(size, &[Class::of(size, 1)]);
    let recognizer = LinearRecognizer::parse(&bytes).expect("a recognizer");
    for length in [0, 1_499, 1_501, 64 * 64] {
        assert_eq!(recognizer.classify(&vec![1; length]), None);
        assert_eq!(recognizer.score(0, &vec![1; length]), None);
    }
    assert_eq!(recognizer.score(1, &[1; 1_500]), None);
    assert_eq!(recognizer.score(usize::MAX, &[1; 1_500]), None);
    assert_eq!(recognizer.name(usize::MAX), None);
}

#[test]
fn as_many_classes_as_a_byte_counts_have_their_names() {
    let size = Size::S50x30;
    let mut classes = vec![Class::of(size, 0); 255];
    classes[0].name = "";
    classes[254].name = "Ångström";
    let bytes = file(size, &classes);
    let recognizer = LinearRecognizer::parse(&bytes).expect("a recognizer");
    assert_eq!(recognizer.classes(), 255);
    let names = [0, 253, 254, 255].map(|class| recognizer.name(class));
    assert_eq!(names, [Some(""), Some("somebody"), Some("Ångström"), None]);
}

#[test]
fn every_truncation_and_every_turned_byte_is_refused() {
    let size = Size::S50x30;
    let bytes = file(size, &[Class::of(size, 1), Class::of(size, 2)]);
    for length in 0..bytes.len() {
        let error = error(&bytes[..length]);
        assert!(error.byte <= length, "{length}: {error}");
    }
    for at in 0..bytes.len() {
        let mut turned = bytes.clone();
        turned[at] ^= 0x40;
        assert!(LinearRecognizer::parse(&turned).is_err(), "{at}");
    }
}

#[test]
fn what_is_wrong_is_refused_with_its_byte() {
    let size = Size::S50x30;
    let bytes = file(size, &[Class::of(size, 1), Class::of(size, 2)]);
    let names_at = 14 + 2 * 8 + 2 * 1_500;
    // The checksum is correct, so that only the intended field is wrong.
    let with = |at: usize, values: &[u8]| {
        let mut bytes = bytes.clone();
        bytes[at..at + values.len()].copy_from_slice(values);
        error(&with_true_crc(bytes)).byte
    };
    assert_eq!(with(0, b"EGPK"), 0);
    assert_eq!(with(8, &[2]), 8);
    assert_eq!(with(10, &[30, 50]), 10);
    assert_eq!(with(11, &[31]), 10);
    assert_eq!(with(12, &[2]), 12);
    assert_eq!(with(13, &[0]), 13);
    // With one class fewer its weights are read as names; one class more, or larger images, need
    // more bytes.
    assert!(with(13, &[1]) > 14 + 8 + 1_500);
    assert_eq!(with(13, &[3]), bytes.len());
    assert_eq!(with(10, &[64, 64]), bytes.len());
    assert_eq!(with(14, &f32::NAN.to_le_bytes()), 14);
    assert_eq!(with(26, &f32::NEG_INFINITY.to_le_bytes()), 26);
    // The first name a byte longer and a byte shorter, the second one beyond the end, invalid
    // UTF-8.
    assert_eq!(with(names_at, &[9]), names_at + 10);
    assert_eq!(with(names_at, &[7]), names_at + 8);
    assert_eq!(with(names_at + 9, &[9]), names_at + 9);
    assert_eq!(with(names_at + 1, &[0xff]), names_at);
    // Bytes after the end.
    let longer = with_true_crc([bytes.as_slice(), &[0]].concat());
    assert_eq!(error(&longer).byte, bytes.len());
    let plain = LinearRecognizer::parse(&bytes).expect("a recognizer");
    assert_eq!(plain.framing(), Framing::Height);
    let mut stretched = bytes.clone();
    stretched[12] = 1;
    let stretched = with_true_crc(stretched);
    let stretched = LinearRecognizer::parse(&stretched).expect("a recognizer");
    assert_eq!(stretched.framing(), Framing::Box);
}

#[test]
fn random_bytes_behind_a_true_header_are_read_or_refused() {
    let mut random = Random(3);
    let mut read = 0;
    for _ in 0..300 {
        let size = Size::ALL[random.below(3)];
        let classes = vec![Class::of(size, 1); 1 + random.below(3)];
        let mut bytes = file(size, &classes);
        for _ in 0..random.below(8) {
            let at = 8 + random.below(bytes.len() - 8);
            // Nearly all other bytes are weights.
            let at = if random.below(2) == 0 {
                at
            } else {
                8 + at % 30
            };
            bytes[at] = random.below(256) as u8;
        }
        let bytes = with_true_crc(bytes);
        if let Ok(recognizer) = LinearRecognizer::parse(&bytes) {
            read += 1;
            let pixels = pixels(recognizer.size(), &mut random);
            let (class, score) = recognizer.classify(&pixels).expect("of its size");
            assert!(!score.is_nan() && recognizer.name(class).is_some());
        }
    }
    assert!((60..240).contains(&read), "{read}");
}
