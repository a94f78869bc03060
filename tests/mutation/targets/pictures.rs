//! Frames: pictures, arrays and pickles of silhouettes, and videos.

use super::{Outcome, Target, below, contents, make, target};
use crate::chance::Chance;
use crate::data::fixtures;
use crate::mutators::{Mutator, bytes, checksums, structure};
use edgegait::draw::sweep::FramingMode;
use edgegait::segment::{SegmentSettings, Segmenter, Video};
use edgegait::{Tree, dataset::TreeLayout};
use edgegait_core::silhouette::Size;
use image::codecs::jpeg::JpegEncoder;
use std::fs;
use std::path::Path;

const SEQUENCE: &str = "tree/001/nm-01/090";
const SIZE: (usize, usize) = (48, 36);

pub fn targets(folder: &Path, made: &Path) -> Vec<Target> {
    let people = below(&fixtures().join("people"), &["png"], 1 << 12);
    let mut pngs = contents(people.iter().take(3).cloned());
    pngs.extend(contents(
        below(&fixtures().join("faults"), &["png"], 1 << 12)
            .into_iter()
            .take(4),
    ));
    let jpegs = pngs.iter().map(|png| jpeg(png)).collect();
    let pickles = made.join("pickles");
    let pack = fixtures().join("golden/v1-loops.egp");
    let sweep = "sweep @ --views side --raster rows --threads 1 --overwrite --out @";
    make(
        &format!("{sweep} --template silhouettes --format opengait"),
        &[&pack, &pickles],
    );
    let pickles = contents(below(&pickles, &["pkl"], 1 << 20).into_iter().take(2));
    let array = npy(&pickles[0]);
    let at = |name: &str, file: &str| {
        let root = crate::run::fresh(&folder.join(name));
        fs::create_dir_all(root.join(SEQUENCE)).expect("a folder");
        (root.join("tree"), root.join(SEQUENCE).join(file))
    };
    let frame = |name: &str, file: &str, other: &[u8], second: &str| {
        let (tree, path) = at(name, file);
        fs::write(path.with_file_name(second), other).expect("a picture");
        move |bytes: &[u8], chance: &mut Chance| {
            fs::write(&path, bytes)?;
            let video = path.parent().expect("a folder");
            if chance.is(30) {
                watch(video)
            } else {
                show(&tree, chance)
            }
        }
    };
    let array_read = |name: &str, file: &str| {
        let (tree, path) = at(name, file);
        move |bytes: &[u8], chance: &mut Chance| {
            fs::write(&path, bytes)?;
            show(&tree, chance)
        }
    };
    let y4m_at = crate::run::fresh(&folder.join("y4m")).join("a.y4m");
    let read_y4m = move |bytes: &[u8], _: &mut Chance| {
        fs::write(&y4m_at, bytes)?;
        watch(&y4m_at)
    };
    let png_read = frame("png", "1.png", &pngs[0], "2.png");
    let jpeg_read = frame("jpeg", "1.jpg", &jpeg(&pngs[0]), "2.jpg");
    let y4m: [Mutator; 4] = [
        structure::y4m,
        structure::y4m,
        structure::after_first_line,
        bytes::number,
    ];
    vec![
        target("png", 60, pngs, &[checksums::png], &bytes::ALL, png_read),
        target(
            "jpeg",
            20,
            jpegs,
            &[structure::jpeg],
            &bytes::ALL,
            jpeg_read,
        ),
        target(
            "pickle",
            90,
            pickles,
            &[structure::pickle],
            &bytes::ALL,
            array_read("pickle", "a.pkl"),
        ),
        target(
            "frames npy",
            20,
            vec![array],
            &[structure::npy],
            &bytes::ALL,
            array_read("frames", "a.npy"),
        ),
        target("y4m", 6, videos(), &y4m, &[], read_y4m),
    ]
}

fn jpeg(png: &[u8]) -> Vec<u8> {
    let picture = image::load_from_memory(png).expect("a picture");
    let mut bytes = Vec::new();
    let encoder = JpegEncoder::new_with_quality(&mut bytes, 90);
    picture
        .to_luma8()
        .write_with_encoder(encoder)
        .expect("a picture");
    bytes
}

/// The pictures of a pickle as an array in a file of NumPy's.
fn npy(pickle: &[u8]) -> Vec<u8> {
    let pixels = &pickle[pickle.len().saturating_sub(64 * 64 * 3 + 3)..pickle.len() - 3];
    let header = "{'descr': '|u1', 'fortran_order': False, 'shape': (3, 64, 64), }";
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend(118_u16.to_le_bytes());
    bytes.extend(format!("{header:<117}\n").into_bytes());
    bytes.extend(pixels);
    bytes
}

/// Grey and coloured videos of a block that moves.
fn videos() -> Vec<Vec<u8>> {
    let (columns, rows) = SIZE;
    let layers = [
        ("mono", 0),
        ("420jpeg", columns * rows / 2),
        ("444", 2 * columns * rows),
    ];
    let video = |(layout, colour): (&str, usize)| {
        let mut bytes = format!("YUV4MPEG2 W{columns} H{rows} F30:1 Ip C{layout}\n").into_bytes();
        for frame in 0..14 {
            bytes.extend(b"FRAME\n");
            let is_block = |at: usize| {
                let column = at % columns;
                (4 + 2 * frame..12 + 2 * frame).contains(&column)
                    && (6..30).contains(&(at / columns))
            };
            bytes.extend((0..columns * rows).map(|at| if is_block(at) { 200 } else { 60 }));
            bytes.extend(vec![128; colour]);
        }
        bytes
    };
    layers.map(video).to_vec()
}

/// Reads a tree of silhouettes in all ways.
fn show(tree: &Path, chance: &mut Chance) -> Outcome {
    let tree = Tree::open(tree, &TreeLayout::default())?;
    let size = chance.one_of(&Size::ALL);
    let _ = (
        tree.frames(0),
        tree.doubts(0),
        tree.check_size(0, &[size]),
        tree.stored(0, size),
    );
    let framing = if chance.is(50) {
        FramingMode::Height
    } else {
        FramingMode::Box
    };
    let shown = tree.silhouettes(0, size, framing)?;
    assert!(shown.clipped_share.is_finite(), "a share");
    tree.lower_bodies(0)?;
    Ok(())
}

/// Reads a video and segments it.
fn watch(path: &Path) -> Outcome {
    let mut video = Video::open(path)?;
    let mut frames = Vec::new();
    loop {
        let batch = video.batch()?;
        if batch.is_empty() {
            break;
        }
        frames.extend(batch);
    }
    let Some(size) = frames.first().map(image::RgbImage::dimensions) else {
        return Ok(());
    };
    let (segmenter, _) = Segmenter::open(path, size, None, SegmentSettings::default())?;
    for frame in &frames {
        let segmented = segmenter.segment(frame);
        assert!(
            segmented.threshold.is_finite() && segmented.noise.is_finite(),
            "a threshold"
        );
    }
    Ok(())
}
