//! Changes of text: tokens, lines, columns and encodings.

use super::bytes::{cut, delete, flip, insert, repeat};
use super::{MAX_BYTES, Mutator};
use crate::chance::Chance;
use std::ops::Range;

pub const ALL: [Mutator; 21] = [
    number, number, number, number, small, small, small, small, token, token, exchange, omit,
    lines, lines, lines, nest, encode, lengthen, flip, delete, insert,
];

/// Comma-separated tables.
pub const TABLE: [Mutator; 13] = [
    cell, cell, cell, cell, number, number, small, lines, token, encode, repeat, cut, flip,
];

const NUMBERS: [&str; 36] = [
    "0",
    "-0",
    "-0.0",
    "1",
    "-1",
    "2",
    "3",
    "0.5",
    "-0.5",
    "127",
    "128",
    "255",
    "256",
    "65535",
    "65536",
    "2147483647",
    "2147483648",
    "-2147483648",
    "4294967296",
    "9223372036854775807",
    "18446744073709551615",
    "18446744073709551616",
    "999999999999",
    "5e-324",
    "1e-30",
    "1e18",
    "1e38",
    "3.5e38",
    "1e308",
    "-1e308",
    "1e309",
    "nan",
    "-nan",
    "inf",
    "-inf",
    "",
];

const WORDS: [&str; 26] = [
    "",
    " ",
    "..",
    "../../up",
    "/",
    "a/b",
    "a\\b",
    "-x",
    "--out=x",
    "null",
    "true",
    "[]",
    "{}",
    "[",
    "}",
    "\"",
    "'",
    "\u{feff}",
    "\u{202e}x",
    "\u{1b}[31m",
    "\0",
    "é",
    "人",
    "a,b",
    "a\nb",
    "#",
];

pub fn number(text: &mut Vec<u8>, chance: &mut Chance) {
    for _ in 0..chance.one_of(&[1, 1, 1, 2, 5, 50]) {
        let found = tokens(&text[..], chance, is_numeric);
        if found.is_empty() {
            return;
        }
        let among = chance.one_of(&[5, 30, found.len()]).min(found.len());
        let at = found[chance.below(among)].clone();
        text.splice(at, chance.one_of(&NUMBERS).bytes());
    }
}

/// Changes digits, signs and points, after which most texts can still be read.
pub fn small(text: &mut Vec<u8>, chance: &mut Chance) {
    for _ in 0..chance.one_of(&[1, 1, 3, 20]) {
        let found = tokens(&text[..], chance, is_numeric);
        if found.is_empty() {
            return;
        }
        let token = found[chance.below(found.len())].clone();
        let at = token.start + chance.below(token.len());
        let new = chance.one_of(&["0", "9", "-", ".", "1", "", "e5", "e-5"]);
        text.splice(at..=at, new.bytes());
    }
}

pub fn token(text: &mut Vec<u8>, chance: &mut Chance) {
    let found = tokens(&text[..], chance, |_| true);
    if found.is_empty() {
        return;
    }
    let at = found[chance.below(found.len())].clone();
    let new = if chance.is(50) {
        chance.one_of(&WORDS)
    } else {
        chance.one_of(&NUMBERS)
    };
    text.splice(at, new.bytes());
}

fn exchange(text: &mut Vec<u8>, chance: &mut Chance) {
    let found = tokens(&text[..], chance, |_| true);
    let [a, b] = [(); 2].map(|()| chance.below(found.len()));
    if a == b {
        return;
    }
    let (first, second) = (found[a.min(b)].clone(), found[a.max(b)].clone());
    let [one, other] = [first.clone(), second.clone()].map(|span| text[span].to_vec());
    text.splice(second, one);
    text.splice(first, other);
}

fn omit(text: &mut Vec<u8>, chance: &mut Chance) {
    let found = tokens(&text[..], chance, |_| true);
    if !found.is_empty() {
        text.drain(found[chance.below(found.len())].clone());
    }
}

/// Removes, repeats, exchanges or joins lines.
pub fn lines(text: &mut Vec<u8>, chance: &mut Chance) {
    let mut all: Vec<Vec<u8>> = text
        .split(|byte| *byte == b'\n')
        .map(<[u8]>::to_vec)
        .collect();
    let at = chance.early(all.len());
    let other = chance.below(all.len());
    match chance.below(6) {
        0 => drop(all.remove(at)),
        1 => {
            let room = MAX_BYTES.saturating_sub(text.len()) / (all[at].len() + 1);
            let times = chance.one_of(&[1, 2, 100, 1000]).min(room);
            let copies = vec![all[at].clone(); times];
            all.splice(at..at, copies);
        }
        2 => all.swap(at, other),
        3 => all.insert(at, all[other].clone()),
        4 => {
            let end = (at + chance.one_of(&[2, 10, 100])).min(all.len());
            all.drain(at..end);
        }
        _ => {
            let joint = chance.one_of(&[b' ', b'\t', b'\r', b',', b';', b'#', 0]);
            let tail = all[other].clone();
            all[at].push(joint);
            all[at].extend(tail);
        }
    }
    *text = all.join(&b'\n');
}

/// Opens thousands of brackets.
fn nest(text: &mut Vec<u8>, chance: &mut Chance) {
    let deep = chance.one_of(&[10, 200, 5000, 100_000]);
    let (open, close) = chance.one_of(&[
        ("[", "]"),
        ("{", "}"),
        ("{\"a\":", "}"),
        ("a={", "}"),
        ("a.", ""),
        ("[[", ""),
        ("JOINT a\n{\nOFFSET 0 0 0\nCHANNELS 0\n", "}\n"),
        ("begin\n", "end\n"),
    ]);
    let deep = deep.min(MAX_BYTES / 4 / open.len());
    let new = open.repeat(deep) + &close.repeat(if chance.is(50) { deep } else { 0 });
    let at = chance.below(text.len() + 1);
    text.splice(at..at, new.bytes());
}

fn encode(text: &mut Vec<u8>, chance: &mut Chance) {
    let replaced = |from: u8, to: &[u8]| {
        let each = text.iter();
        each.flat_map(|byte| {
            if *byte == from {
                to.to_vec()
            } else {
                vec![*byte]
            }
        })
        .collect::<Vec<u8>>()
    };
    *text = match chance.below(6) {
        0 => [b"\xef\xbb\xbf", &text[..]].concat(),
        1 => text.iter().flat_map(|byte| [*byte, 0]).collect(),
        2 => replaced(b'\n', b"\r\n"),
        3 => replaced(b'\n', b"\r"),
        4 => replaced(b' ', b"\xc2\xa0"),
        _ => replaced(b'.', b","),
    };
}

fn lengthen(text: &mut Vec<u8>, chance: &mut Chance) {
    let found = tokens(&text[..], chance, |_| true);
    if found.is_empty() {
        return;
    }
    let at = found[chance.below(found.len())].clone();
    let times = chance
        .one_of(&[100, 10_000, 200_000])
        .min((MAX_BYTES / 4) / at.len());
    let copies = text[at.clone()].repeat(times);
    text.splice(at.end..at.end, copies);
}

/// Changes a cell, a column or a row of a table.
fn cell(text: &mut Vec<u8>, chance: &mut Chance) {
    let rows = text.split(|byte| *byte == b'\n');
    let mut rows: Vec<Vec<Vec<u8>>> = rows
        .map(|row| {
            row.split(|byte| *byte == b',')
                .map(<[u8]>::to_vec)
                .collect()
        })
        .collect();
    let at = chance.below(rows.len());
    let column = chance.below(rows[at].len());
    match chance.below(8) {
        0..=2 => rows[at][column] = chance.one_of(&NUMBERS).into(),
        3 => {
            let word = chance.one_of(&WORDS).replace('"', "\"\"");
            rows[at][column] = format!("\"{word}\"").into_bytes();
        }
        4 => {
            let copy = rows[at][chance.below(rows[at].len())].clone();
            rows[at].insert(column, copy);
        }
        5 => drop(rows[at].remove(column)),
        6 => rows[at] = rows[chance.below(rows.len())].clone(),
        _ => {
            for row in &mut rows {
                if column < row.len() {
                    row.remove(column);
                }
            }
        }
    }
    let rows: Vec<Vec<u8>> = rows.iter().map(|row| row.join(&b',')).collect();
    *text = rows.join(&b'\n');
}

/// The words and numbers in 8 kB of a text, mostly at its beginning.
fn tokens(text: &[u8], chance: &mut Chance, is_wanted: fn(&[u8]) -> bool) -> Vec<Range<usize>> {
    const PIECE: usize = 8192;
    let start = if chance.is(60) {
        0
    } else {
        chance.below(text.len())
    };
    let end = (start + PIECE).min(text.len());
    let is_part = |byte: u8| byte.is_ascii_alphanumeric() || b"_.+-".contains(&byte) || byte >= 128;
    let (mut found, mut at) = (Vec::new(), start);
    while at < end {
        let long = text[at..end]
            .iter()
            .take_while(|byte| is_part(**byte))
            .count();
        if long > 0 && is_wanted(&text[at..at + long]) {
            found.push(at..at + long);
        }
        at += long.max(1);
    }
    found
}

fn is_numeric(token: &[u8]) -> bool {
    let token = token.strip_prefix(b"-").unwrap_or(token);
    token.first().is_some_and(u8::is_ascii_digit)
}
