//! Changes of files that are JSON, hold it, or begin with a header of words.

use super::bytes::{ALL, EDGES, set_number};
use super::text;
use crate::chance::Chance;
use serde_json::{Value, json};

/// Changes, removes, repeats, renames or exchanges values of a JSON document.
pub fn json(bytes: &mut Vec<u8>, chance: &mut Chance) {
    let Ok(mut document) = serde_json::from_slice::<Value>(bytes) else {
        return text::number(bytes, chance);
    };
    for _ in 0..chance.one_of(&[1, 1, 1, 2, 4]) {
        change(&mut document, chance);
    }
    *bytes = document.to_string().into_bytes();
}

fn change(document: &mut Value, chance: &mut Chance) {
    let places = places(document);
    let place = places[chance.below(places.len())].clone();
    let other = document
        .pointer(&places[chance.below(places.len())])
        .cloned();
    let Some((above, key)) = place.rsplit_once('/') else {
        return;
    };
    let parent = document.pointer_mut(above);
    match (chance.below(8), parent) {
        (0, Some(Value::Array(list))) => drop(list.remove(key.parse().unwrap_or(0))),
        (0, Some(Value::Object(map))) => drop(map.remove(key)),
        (1, Some(Value::Array(list))) => {
            let at: usize = key.parse().unwrap_or(0);
            list.insert(at, list[at].clone());
        }
        (1, Some(Value::Object(map))) => {
            let value = map.remove(key).unwrap_or_default();
            map.insert(
                chance.one_of(&["", "x", "../x", "\u{1b}[31m"]).into(),
                value,
            );
        }
        (2, _) => put(document, &place, other.unwrap_or_default()),
        _ => {
            let old = document.pointer(&place).cloned().unwrap_or_default();
            let new = value(&old, chance);
            put(document, &place, new);
        }
    }
}

fn put(document: &mut Value, place: &str, value: Value) {
    if let Some(old) = document.pointer_mut(place) {
        *old = value;
    }
}

fn value(old: &Value, chance: &mut Chance) -> Value {
    if let (Some(number), true) = (old.as_f64(), chance.is(80)) {
        let moved = [
            number + 1.0,
            number - 1.0,
            number * 2.0,
            -number,
            0.5,
            1e308,
            -1e308,
            1e-320,
        ];
        return match chance.below(3) {
            0 => json!(chance.one_of(&moved)),
            1 => old.as_i64().map_or(json!(0), |it| {
                json!(it.wrapping_add(chance.one_of(&[1, -1, 2])))
            }),
            _ => json!(chance.one_of(&EDGES)),
        };
    }
    match chance.below(9) {
        0 => Value::Null,
        1 => json!(true),
        2 => json!(-1),
        3 => json!(chance.one_of(&["", "x", "..", "/x", "\u{202e}x", "999999999999", "nan"])),
        4 => json!([]),
        5 => json!({}),
        6 => json!([old]),
        7 => json!({ "a": old }),
        _ => Value::Array(vec![old.clone(); 1000]),
    }
}

/// The pointers of values; of a long list, those of its beginning.
fn places(document: &Value) -> Vec<String> {
    fn below(value: &Value, place: &str, found: &mut Vec<String>) {
        match value {
            Value::Array(list) => {
                for (at, one) in list.iter().take(40).enumerate() {
                    let place = format!("{place}/{at}");
                    found.push(place.clone());
                    below(one, &place, found);
                }
            }
            Value::Object(map) => {
                for (key, one) in map {
                    let key = key.replace('~', "~0").replace('/', "~1");
                    let place = format!("{place}/{key}");
                    found.push(place.clone());
                    below(one, &place, found);
                }
            }
            _ => {}
        }
    }
    let mut found = vec![String::new()];
    below(document, "", &mut found);
    found
}

/// Changes the JSON of a GLB, or a length of its chunks.
pub fn glb(bytes: &mut Vec<u8>, chance: &mut Chance) {
    const START: usize = 20;
    let Some(length) = bytes.get(12..16).and_then(|four| four.try_into().ok()) else {
        return;
    };
    let length = u32::from_le_bytes(length) as usize;
    let Some(text) = bytes.get(START..START.saturating_add(length)) else {
        return;
    };
    let mut text = text.to_vec();
    json(&mut text, chance);
    text.resize(text.len().next_multiple_of(4), b' ');
    let mut new_length = text.len() as u32;
    bytes.splice(START..START + length, text);
    let mut whole = bytes.len() as u32;
    match chance.below(12) {
        0 => whole = chance.one_of(&EDGES) as u32,
        1 => new_length = chance.one_of(&EDGES) as u32,
        _ => {}
    }
    bytes[8..12].copy_from_slice(&whole.to_le_bytes());
    bytes[12..16].copy_from_slice(&new_length.to_le_bytes());
}

/// Changes the numbers behind a GLB's JSON.
pub fn glb_numbers(bytes: &mut Vec<u8>, chance: &mut Chance) {
    let length = bytes.get(12..16).and_then(|four| four.try_into().ok());
    let start = length
        .map_or(0, |four| u32::from_le_bytes(four) as usize)
        .saturating_add(28);
    if start + 4 < bytes.len() {
        let mut numbers = bytes.split_off(start);
        for _ in 0..chance.one_of(&[1, 1, 4, 50]) {
            if chance.is(60) {
                super::bytes::float(&mut numbers, chance);
            } else {
                let at = chance.below(numbers.len() - 3);
                set_number(&mut numbers[at..at + 4], chance);
            }
        }
        bytes.extend(numbers);
    }
}

/// Changes the description of an array at the beginning of a .npy, or its length.
pub fn npy(bytes: &mut Vec<u8>, chance: &mut Chance) {
    const START: usize = 10;
    let Some(length) = bytes.get(8..START).and_then(|two| two.try_into().ok()) else {
        return;
    };
    let length = usize::from(u16::from_le_bytes(length));
    let Some(described) = bytes.get(START..START + length) else {
        return;
    };
    let mut described = String::from_utf8_lossy(described).into_owned();
    match chance.below(5) {
        0 => {
            let shape = described
                .split_once('(')
                .and_then(|(_, rest)| rest.split_once(')'));
            let shape = shape.map_or_else(String::new, |(shape, _)| format!("({shape})"));
            let new = chance.one_of(&[
                "()",
                "(1,)",
                "(0, 50, 30)",
                "(18446744073709551615, 50, 30)",
                "(-1, 50, 30)",
                "(4611686018427387904, 4, 30)",
                "(2, 50, 30, 1)",
                "(2, 0, 30)",
                "(99999999999999999999999, 50, 30)",
            ]);
            described = described.replace(&shape, new);
        }
        1 => {
            let new = chance.one_of(&["<u1", ">u1", "|i1", "<f8", "|O", "<U1", "|b1", "<c16"]);
            described = described.replace("|u1", new).replace("<f4", new);
        }
        2 => described = described.replace("False", chance.one_of(&["True", "None", "0", ""])),
        3 => described = "(".repeat(chance.one_of(&[10, 900, 60_000])),
        _ => {
            let mut text = described.into_bytes();
            chance.one_of(&text::ALL)(&mut text, chance);
            text.truncate(60_000);
            described = String::from_utf8_lossy(&text).into_owned();
        }
    }
    let mut new_length = described.len() as u16;
    bytes.splice(START..START + length, described.into_bytes());
    if chance.is(10) {
        new_length = chance.one_of(&EDGES) as u16;
    }
    bytes[8..START].copy_from_slice(&new_length.to_le_bytes());
}

/// Changes, repeats, adds or removes instructions of a pickle, near its beginning or its end.
pub fn pickle(bytes: &mut Vec<u8>, chance: &mut Chance) {
    const INSTRUCTIONS: [&[u8]; 24] = [
        b"(",
        b"t",
        b")",
        b"N",
        b"\x85",
        b"\x86",
        b"\x87",
        b"R",
        b"b",
        b"0",
        b"2",
        b"K\x00",
        b"K\xff",
        b"J\xff\xff\xff\xff",
        b"J\xff\xff\xff\x7f",
        b"M\xff\xff",
        b"\x8a\x08\xff\xff\xff\xff\xff\xff\xff\x7f",
        b"h\x00",
        b"q\x00",
        b"\x94",
        b"j\xff\xff\xff\xff",
        b"cnumpy\nndarray\n",
        b"]",
        b"a",
    ];
    for _ in 0..chance.one_of(&[1, 1, 2, 3]) {
        let edge = bytes.len().min(220);
        let mut at = chance.below(edge + 1);
        if chance.is(25) {
            at = bytes.len() - chance.below(edge.min(24) + 1);
        }
        let end = (at + chance.one_of(&[0, 1, 2, 5])).min(bytes.len());
        let new = match chance.below(6) {
            0 => vec![b'('; chance.one_of(&[10, 300, 100_000])],
            1 => bytes[at..end].repeat(chance.one_of(&[2, 50, 300])),
            2 => Vec::new(),
            _ => chance.one_of(&INSTRUCTIONS).to_vec(),
        };
        bytes.splice(at..end, new);
    }
}

/// Changes a marker of a JPEG or the numbers of its segment.
pub fn jpeg(bytes: &mut Vec<u8>, chance: &mut Chance) {
    let is_marker = |pair: &[u8]| pair[0] == 0xff && (0xc0..0xff).contains(&pair[1]);
    let pairs = bytes.windows(2).enumerate();
    let markers: Vec<usize> = pairs
        .filter(|pair| is_marker(pair.1))
        .map(|pair| pair.0)
        .collect();
    if markers.is_empty() {
        return;
    }
    let at = markers[chance.below(markers.len())];
    let place = at + chance.one_of(&[1, 2, 2, 4, 5, 7, 9, 11, 12, 15]);
    let width = chance.one_of(&[1, 2]);
    if let Some(field) = bytes.get_mut(place..place + width) {
        set_number(field, chance);
    }
}

/// Changes the words of a Y4M's first line, or the lines before its frames.
pub fn y4m(bytes: &mut Vec<u8>, chance: &mut Chance) {
    const WORDS: [&str; 22] = [
        "W0",
        "H0",
        "W1",
        "H1",
        "W3",
        "H3",
        "W65535",
        "H65535",
        "W4294967297",
        "H4294967296",
        "F0:0",
        "F1:0",
        "F-1:1",
        "C420p10",
        "C411",
        "Cmono16",
        "C422",
        "C444",
        "C444alpha",
        "It",
        "A0:0",
        "X",
    ];
    let Some(end) = bytes.iter().position(|byte| *byte == b'\n') else {
        return;
    };
    let line = String::from_utf8_lossy(&bytes[..end]).into_owned();
    let mut words: Vec<&str> = line.split(' ').collect();
    let at = chance.below(words.len());
    match chance.below(4) {
        0 => words[at] = chance.one_of(&WORDS),
        1 => words.insert(at, chance.one_of(&WORDS)),
        2 => drop(words.remove(at)),
        _ => {
            let frame = bytes.windows(6).position(|six| six == b"FRAME\n");
            if let Some(frame) = frame {
                let line = chance.one_of(&["FRAME Ip\n", "FRAME\r\n", "FRAM\n", "", "FRAME"]);
                bytes.splice(frame..frame + 6, line.bytes());
            }
            return;
        }
    }
    bytes.splice(..end, words.join(" ").into_bytes());
}

/// Changes any bytes behind a first line.
pub fn after_first_line(bytes: &mut Vec<u8>, chance: &mut Chance) {
    let end = bytes.iter().position(|byte| *byte == b'\n');
    let mut rest = bytes.split_off(end.map_or(0, |end| end + 1));
    chance.one_of(&ALL)(&mut rest, chance);
    bytes.extend(rest);
}
