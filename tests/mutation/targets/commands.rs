//! Command lines, which are parsed and not run.

use super::{Target, target};
use crate::chance::Chance;
use crate::mutators::{bytes, text};
use edgegait::cli::embed;
use std::ffi::OsString;

/// Words, one in each line.
const LINES: [&str; 20] = [
    "bench side gei-small --no-accuracy --window-s 0.2 --windows 3 --batch 2",
    "check models/side.onnx --runtime ort --provider cpu --threads 2",
    "cohort --people 2 --speeds-kmh 4,8 --seed 3 --out two.egp",
    "confounders side --views side --threads 1",
    "contract models/side.onnx",
    "frontier --views side",
    "gate limits.toml a.json b.json --run c.json,d.json --without-baseline",
    "generate design.toml --people 3 --format casia-b --shard 1/3 --resume",
    "import a.bvh b.c3d --stature-m 1.7 --mass-kg 70 --sex F --low-pass-hz 6 --fps 120",
    "inspect a.egp --audit",
    "literature --people 4 --seed 2",
    "merge a b c --out d --format npz",
    "parity a.onnx b.onnx --threads 1",
    "quantize side --out a.egr --cycles 2",
    "render a.egp --azimuth-deg -30 --elevation-deg 45 --lens persp --distance-m 4",
    "score side pixels a.egp --walks nm-01 --views side --condition backpack=0.5,roll=1deg",
    "segment a.y4m --background b.png --out tree",
    "study tree clips --manifest m.csv --bodies b.csv --out o",
    "sweep a.egp --cycles 3 --template gei,silhouettes --raster rows --size 64x44 --jitter 0.1",
    "train a b --out m.onnx --seed 18446744073709551615",
];

pub fn targets() -> Vec<Target> {
    let seeds = LINES
        .map(|line| line.replace(' ', "\n").into_bytes())
        .to_vec();
    let read = |bytes: &[u8], _: &mut Chance| {
        let words = bytes.split(|byte| *byte == b'\n').map(word);
        let words: Vec<OsString> = words.take(2000).collect();
        embed::check(&words).map_err(|error| embed::text_of(&error).into())
    };
    let mutators = [
        text::number,
        text::small,
        text::token,
        text::lines,
        text::lines,
        bytes::flip,
    ];
    vec![target("command line", 4, seeds, &mutators, &[], read)]
}

#[cfg(unix)]
fn word(bytes: &[u8]) -> OsString {
    use std::os::unix::ffi::OsStringExt as _;
    OsString::from_vec(bytes.to_vec())
}

#[cfg(not(unix))]
fn word(bytes: &[u8]) -> OsString {
    String::from_utf8_lossy(bytes).into_owned().into()
}
