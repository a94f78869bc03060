//! A synthetic video for machines without one: a walker of a pack crosses a painted scene.

use crate::draw::sweep::{Job, Moments, Settings, figures};
use crate::error::{Error, Result};
use crate::report::write_png;
use crate::segment::Painted;
use edgegait_core::camera::{Camera, Viewpoint};
use edgegait_core::outline;
use edgegait_core::pack::Pack;
use glam::Vec2;
use image::codecs::jpeg::JpegEncoder;
use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;
use std::fs;
use std::path::Path;

/// The columns and rows of the video.
pub(crate) const MADE_SIZE: (usize, usize) = (320, 240);
/// The frames a second of the video.
pub(crate) const MADE_FPS: f32 = 25.0;
/// The pixels of a metre: a person of 1.75 m has 112 rows and crosses 5 m. Our choice: three cycles
/// of a walk.
const SCALE: f32 = 64.0;
/// The row of the floor.
const FLOOR: f32 = 215.0;
/// The columns that stay empty on both sides.
const MARGIN: f32 = 8.0;
/// The maximum number of frames: ten seconds.
const MOST: u32 = 250;
/// The JPEG quality, as of cameras that compress each frame. Our choice.
const QUALITY: u8 = 90;

/// Writes a video of a walk seen from its left: `frames/NNN.jpg`, and `background.png`, the empty
/// scene. The walker crosses the image once and is never cut off.
///
/// # Errors
/// If there is no such walk, or a file cannot be written.
pub(crate) fn write_made(pack: &Pack<'_>, walk: usize, seed: u64, folder: &Path) -> Result<()> {
    let masks = masks(pack, walk)?;
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut video = Painted::new(MADE_SIZE, &mut rng);
    write_png(folder.join("background.png"), &video.empty())?;
    let frames = folder.join("frames");
    fs::create_dir(&frames).map_err(|error| Error::io(&frames, error))?;
    for (number, mask) in masks.iter().enumerate() {
        let path = frames.join(format!("{:03}.jpg", number + 1));
        let mut bytes = Vec::new();
        video
            .frame(mask)
            .write_with_encoder(JpegEncoder::new_with_quality(&mut bytes, QUALITY))
            .map_err(|error| Error::input(&path, format!("cannot be encoded: {error}")))?;
        fs::write(&path, bytes).map_err(|error| Error::io(&path, error))?;
    }
    Ok(())
}

/// Returns the walker's silhouettes: 0 or 255, row by row.
fn masks(pack: &Pack<'_>, walk: usize) -> Result<Vec<Vec<u8>>> {
    let moments = Moments::Seconds {
        start_s: 0.0,
        fps: MADE_FPS.into(),
        frames: MOST,
    };
    let job = Job::plain(walk, 0);
    let figures = figures(pack, job, moments, Settings::default())?;
    let camera = Camera::orthographic(Viewpoint::from_degrees(90.0, 0.0)?);
    let (columns, _) = MADE_SIZE;
    let seen = figures.iter().map(|hulls| -> Vec<outline::Outline> {
        let hulls = hulls.iter().map(|points| {
            let places = points.iter().map(|&point| camera.project(point));
            outline::convex(places.map(|at| Vec2::new(SCALE * at.x, FLOOR - SCALE * at.y)))
        });
        hulls.collect()
    });
    let seen: Vec<Vec<outline::Outline>> = seen.collect();
    let span = |outlines: &[outline::Outline]| {
        let xs = outlines.iter().flatten().map(|corner| corner.x);
        xs.fold((f32::INFINITY, f32::NEG_INFINITY), |(least, most), x| {
            (least.min(x), most.max(x))
        })
    };
    // The walker enters on the right and moves to the left; a loop does not include its travel.
    let clip = pack.walk(walk).and_then(|walk| pack.clip(walk.clip));
    let cycle = clip.and_then(|clip| clip.as_loop());
    let speed_mps = cycle.map_or(0.0, |cycle| f64::from(cycle.drift_m()) / cycle.period_s());
    let step = SCALE * speed_mps as f32 / MADE_FPS;
    let start = seen
        .first()
        .map_or(0.0, |first| columns as f32 - MARGIN - span(first).1);
    let shifted = (0_u16..).zip(&seen);
    let shifted = shifted.map(|(number, outlines)| (outlines, start - step * f32::from(number)));
    let inside = shifted.take_while(|(outlines, shift)| span(outlines).0 + shift >= MARGIN);
    Ok(inside
        .map(|(outlines, shift)| mask(outlines, shift))
        .collect())
}

/// Returns the pixels whose centres are inside any outline, shifted by this many columns.
fn mask(outlines: &[outline::Outline], shift: f32) -> Vec<u8> {
    let (columns, rows) = MADE_SIZE;
    let mut pixels = vec![0; columns * rows];
    for outline in outlines {
        for (row, pixels) in pixels.chunks_exact_mut(columns).enumerate() {
            let y = row as f32 + 0.5;
            let (mut left, mut right) = (f32::INFINITY, f32::NEG_INFINITY);
            let corners = outline.iter().zip(outline.iter().cycle().skip(1));
            for (a, b) in corners.filter(|(a, b)| (a.y <= y) != (b.y <= y)) {
                let x = a.x + (y - a.y) / (b.y - a.y) * (b.x - a.x) + shift;
                (left, right) = (left.min(x), right.max(x));
            }
            // The cast saturates, and the range is empty where no edge was crossed.
            let middles = |x: f32| ((x + 0.5).floor() as usize).min(columns);
            let (from, to) = (middles(left), middles(right));
            if from < to {
                pixels[from..to].fill(255);
            }
        }
    }
    pixels
}

#[cfg(test)]
mod tests;
