//! Changes of a protobuf message: fields are changed in a tree and written anew, so that the lengths
//! around them stay right.

use super::bytes::{ALL, EDGES, set_number};
use super::text;
use crate::chance::Chance;

#[derive(Clone)]
struct Field {
    tag: u64,
    payload: Payload,
}

#[derive(Clone)]
enum Payload {
    Varint(u64),
    /// Four or eight bytes.
    Fixed(Vec<u8>),
    Bytes(Vec<u8>),
    Message(Vec<Field>),
}

/// Messages within messages that are looked into: a tensor's shape in a value of a graph is the
/// seventh.
const DEEPEST: usize = 9;

pub fn onnx(bytes: &mut Vec<u8>, chance: &mut Chance) {
    let Some(mut fields) = message(bytes, DEEPEST) else {
        return;
    };
    for _ in 0..chance.one_of(&[1, 1, 2, 3]) {
        change(&mut fields, chance);
    }
    *bytes = written(&fields);
}

/// Changes a field of a message or of a message in it: each level is left with the same chance, so
/// that shapes and attributes are met as often as long lists of nodes.
fn change(fields: &mut Vec<Field>, chance: &mut Chance) {
    let at = chance.below(fields.len());
    let Some(field) = fields.get_mut(at) else {
        return;
    };
    if let Payload::Message(inner) = &mut field.payload
        && chance.is(85)
    {
        return change(inner, chance);
    }
    match chance.below(8) {
        0 => drop(fields.remove(at)),
        1 => {
            let copy = fields[chance.below(fields.len())].clone();
            fields.insert(at, copy);
        }
        2 => field.tag = (field.tag & 7) | (chance.one_of(&[1, 2, 3, 4, 5, 7, 8, 20, 1000]) << 3),
        _ => match &mut field.payload {
            Payload::Varint(value) if chance.is(70) => *value = chance.one_of(&EDGES),
            Payload::Varint(value) => {
                *value = value.wrapping_add_signed(chance.one_of(&[1, -1, 2, 10, 1000]));
            }
            Payload::Fixed(number) => set_number(number, chance),
            Payload::Bytes(found) if found.len() < 64 && chance.is(40) => {
                text::token(found, chance);
            }
            Payload::Bytes(found) => chance.one_of(&ALL)(found, chance),
            Payload::Message(inner) => inner.clear(),
        },
    }
}

fn message(bytes: &[u8], depth: usize) -> Option<Vec<Field>> {
    let (mut rest, mut fields) = (bytes, Vec::new());
    while !rest.is_empty() {
        let tag = varint(&mut rest)?;
        let mut take = |length: usize| {
            let (taken, after) = rest.split_at_checked(length)?;
            rest = after;
            Some(taken.to_vec())
        };
        let payload = match tag & 7 {
            0 => Payload::Varint(varint(&mut rest)?),
            1 => Payload::Fixed(take(8)?),
            5 => Payload::Fixed(take(4)?),
            2 => {
                let length = usize::try_from(varint(&mut rest)?).ok()?;
                let (taken, after) = rest.split_at_checked(length)?;
                rest = after;
                let inner = (depth > 0 && !taken.is_empty()).then(|| message(taken, depth - 1));
                match inner.flatten() {
                    Some(fields) => Payload::Message(fields),
                    None => Payload::Bytes(taken.to_vec()),
                }
            }
            _ => return None,
        };
        if tag >> 3 == 0 {
            return None;
        }
        fields.push(Field { tag, payload });
    }
    Some(fields)
}

fn varint(rest: &mut &[u8]) -> Option<u64> {
    let mut value = 0;
    for shift in (0..64).step_by(7) {
        let (byte, after) = rest.split_first()?;
        *rest = after;
        value |= u64::from(byte & 0x7f) << shift;
        if *byte < 0x80 {
            return Some(value);
        }
    }
    None
}

fn written(fields: &[Field]) -> Vec<u8> {
    let mut bytes = Vec::new();
    for Field { tag, payload } in fields {
        put(&mut bytes, *tag);
        match payload {
            Payload::Varint(value) => put(&mut bytes, *value),
            Payload::Fixed(number) => bytes.extend(number),
            Payload::Bytes(found) => {
                put(&mut bytes, found.len() as u64);
                bytes.extend(found);
            }
            Payload::Message(inner) => {
                let inner = written(inner);
                put(&mut bytes, inner.len() as u64);
                bytes.extend(inner);
            }
        }
    }
    bytes
}

fn put(bytes: &mut Vec<u8>, mut value: u64) {
    while value >= 0x80 {
        bytes.push(value as u8 | 0x80);
        value >>= 7;
    }
    bytes.push(value as u8);
}

#[test]
fn a_model_that_is_not_changed_is_written_as_it_was() {
    let model = std::fs::read("models/side.onnx").expect("a shipped model");
    assert!(written(&message(&model, DEEPEST).expect("a message")) == model);
}
