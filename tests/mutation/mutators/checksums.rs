//! Files with checksums, which are made right again after a change, so that readers get past them.

use super::bytes::{ALL, EDGES, set_number};
use super::text;
use crate::chance::Chance;
use edgegait_core::format::{
    CRC_AT, HEADER_BYTES, LENGTH_AT, RECOGNIZER_CRC_AT, SECTION_ENTRY_BYTES, SECTION_ORDER, crc32,
};
use flate2::Compression;
use flate2::read::ZlibDecoder;
use flate2::write::ZlibEncoder;
use std::io::{Cursor, Read as _, Write as _};
use zip::write::{SimpleFileOptions, ZipWriter};
use zip::{CompressionMethod, ZipArchive};

const PNG: &[u8] = b"\x89PNG\r\n\x1a\n";

/// Changes numbers in a section of a pack, and nothing else.
pub fn pack_section(bytes: &mut Vec<u8>, chance: &mut Chance) {
    let entry = HEADER_BYTES + SECTION_ENTRY_BYTES * chance.below(SECTION_ORDER.len());
    let word = |at: usize| {
        let four = bytes.get(at..at + 4)?.try_into().ok()?;
        usize::try_from(u32::from_le_bytes(four)).ok()
    };
    let (Some(start), Some(length)) = (word(entry + 4), word(entry + 8)) else {
        return;
    };
    let Some(section) = bytes.get_mut(start..start.saturating_add(length)) else {
        return;
    };
    for _ in 0..chance.one_of(&[1, 1, 2, 8]) {
        let width = chance.one_of(&[1, 2, 4]).min(section.len());
        let at = chance.early(section.len() - width + 1);
        set_number(&mut section[at..at + width], chance);
    }
    mend_pack(bytes);
}

/// Changes any bytes of a pack.
pub fn pack_bytes(bytes: &mut Vec<u8>, chance: &mut Chance) {
    chance.one_of(&ALL)(bytes, chance);
    mend_pack(bytes);
}

fn mend_pack(bytes: &mut [u8]) {
    let length = u32::try_from(bytes.len()).unwrap_or(u32::MAX);
    if bytes.len() >= HEADER_BYTES {
        bytes[LENGTH_AT..LENGTH_AT + 4].copy_from_slice(&length.to_le_bytes());
        let crc = crc32(&bytes[HEADER_BYTES..]);
        bytes[CRC_AT..CRC_AT + 4].copy_from_slice(&crc.to_le_bytes());
    }
}

/// Changes any bytes of a recognizer for firmware.
pub fn recognizer(bytes: &mut Vec<u8>, chance: &mut Chance) {
    chance.one_of(&ALL)(bytes, chance);
    let after = RECOGNIZER_CRC_AT + 4;
    if bytes.len() >= after {
        let crc = crc32(&bytes[after..]);
        bytes[RECOGNIZER_CRC_AT..after].copy_from_slice(&crc.to_le_bytes());
    }
}

/// Changes, repeats, adds or removes chunks of a PNG, or its pixels before they are compressed.
pub fn png(bytes: &mut Vec<u8>, chance: &mut Chance) {
    let Some(mut chunks) = chunks(bytes) else {
        return;
    };
    let at = chance.below(chunks.len());
    match chance.below(7) {
        0 => {
            let header = &mut chunks[0].1;
            let side = 4 * chance.below(2);
            if let Some(side) = header.get_mut(side..side + 4) {
                let value = chance.one_of(&EDGES) as u32;
                side.copy_from_slice(&value.to_be_bytes());
            }
        }
        1 => {
            let place = 8 + chance.below(5);
            let value = chance.one_of(&[0, 1, 2, 3, 4, 6, 7, 8, 16, 32, 255]);
            if let Some(byte) = chunks[0].1.get_mut(place) {
                *byte = value;
            }
        }
        2 => chance.one_of(&ALL)(&mut chunks[at].1, chance),
        3 => drop(chunks.remove(at)),
        4 => {
            let copy = chunks[chance.below(chunks.len())].clone();
            chunks.insert(at, copy);
        }
        5 => {
            let kind = chance.one_of(&[
                b"PLTE", b"tRNS", b"iCCP", b"zTXt", b"acTL", b"gAMA", b"eXIf",
            ]);
            let long = chance.one_of(&[0, 1, 2, 3, 6, 256, 768, 771]);
            let data = match kind {
                b"iCCP" | b"zTXt" => [b"x\0\0", &deflated(&vec![0; 1 << 20])[..]].concat(),
                _ => (0..long).map(|_| chance.byte()).collect(),
            };
            chunks.insert(at.max(1).min(chunks.len()), (*kind, data));
        }
        _ => repack_pixels(&mut chunks, chance),
    }
    *bytes = PNG.to_vec();
    for (kind, data) in chunks {
        let mut length = u32::try_from(data.len()).unwrap_or(u32::MAX);
        if chance.is(1) {
            length = chance.one_of(&EDGES) as u32;
        }
        let named = [&kind[..], &data].concat();
        bytes.extend(length.to_be_bytes());
        bytes.extend(&named);
        bytes.extend(crc32(&named).to_be_bytes());
    }
}

type Chunk = ([u8; 4], Vec<u8>);

fn chunks(bytes: &[u8]) -> Option<Vec<Chunk>> {
    let mut rest = bytes.strip_prefix(PNG)?;
    let mut chunks = Vec::new();
    while let Some((length, after)) = rest.split_first_chunk::<4>() {
        let (kind, data) = after.split_first_chunk::<4>()?;
        let length = usize::try_from(u32::from_be_bytes(*length)).ok()?;
        chunks.push((*kind, data.get(..length)?.to_vec()));
        rest = data.get(length + 4..)?;
    }
    (!chunks.is_empty()).then_some(chunks)
}

fn repack_pixels(chunks: &mut Vec<Chunk>, chance: &mut Chance) {
    let is_pixels = |chunk: &Chunk| &chunk.0 == b"IDAT";
    let Some(first) = chunks.iter().position(is_pixels) else {
        return;
    };
    let all: Vec<&[u8]> = chunks
        .iter()
        .filter(|it| is_pixels(it))
        .map(|it| &it.1[..])
        .collect();
    let mut pixels = Vec::new();
    let _ = ZlibDecoder::new(&all.concat()[..])
        .take(1 << 22)
        .read_to_end(&mut pixels);
    if chance.is(20) {
        pixels = vec![0; chance.one_of(&[0, 1, 10_000_000])];
    } else {
        chance.one_of(&ALL)(&mut pixels, chance);
    }
    chunks.retain(|chunk| !is_pixels(chunk));
    chunks.insert(first.min(chunks.len()), (*b"IDAT", deflated(&pixels)));
}

fn deflated(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::fast());
    let written = encoder.write_all(bytes);
    written
        .and_then(|()| encoder.finish())
        .expect("memory does not refuse")
}

/// Changes the members of a ZIP archive (.npz), which is written anew.
pub fn zip(bytes: &mut Vec<u8>, chance: &mut Chance) {
    let Some(mut members) = members(bytes) else {
        return;
    };
    let at = chance.below(members.len());
    match chance.below(6) {
        0 => chance.one_of(&ALL)(&mut members[at].1, chance),
        1 => {
            let manifest = members
                .iter_mut()
                .find(|member| member.0 == "manifest.json");
            if let Some(manifest) = manifest {
                super::structure::json(&mut manifest.1, chance);
            }
        }
        2 => chance.one_of(&text::ALL)(&mut members[at].1, chance),
        3 => drop(members.remove(at)),
        4 => members[at].1 = vec![b' '; chance.one_of(&[0, 1 << 10, 1 << 22])],
        _ => {
            members[at].0 = chance
                .one_of(&["", "../up", "/top", "a\\b", "manifest.json"])
                .into();
        }
    }
    let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
    let options = SimpleFileOptions::default().compression_method(CompressionMethod::Stored);
    for (name, data) in members {
        // A name that is there already is refused.
        if archive.start_file(name, options).is_ok() {
            archive.write_all(&data).expect("memory does not refuse");
        }
    }
    if let Ok(whole) = archive.finish() {
        *bytes = whole.into_inner();
    }
}

fn members(bytes: &[u8]) -> Option<Vec<(String, Vec<u8>)>> {
    let mut archive = ZipArchive::new(Cursor::new(bytes)).ok()?;
    let mut members = Vec::new();
    for index in 0..archive.len() {
        let member = archive.by_index(index).ok()?;
        let name = member.name().ok()?.into_owned();
        let mut data = Vec::new();
        member.take(1 << 22).read_to_end(&mut data).ok()?;
        members.push((name, data));
    }
    (!members.is_empty()).then_some(members)
}
