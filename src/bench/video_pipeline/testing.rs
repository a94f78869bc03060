//! Helpers for tests of the pipeline: small videos with known legs, and a recognizer that returns
//! its input.

use crate::dataset::gait_cycles::LowerBody;
use crate::draw::template::Template;
use crate::inference::testing::MadeUp;
use crate::inference::{Contract, InputLayout};
use crate::segment::{SegmentSettings, Segmenter};
use image::{Rgb, RgbImage};
use std::path::Path;

pub(super) const SIZE: (u32, u32) = (60, 40);
const WALL: Rgb<u8> = Rgb([170, 165, 150]);
const CLOTHES: Rgb<u8> = Rgb([40, 50, 90]);

/// A figure of a trunk and two spreading legs that takes `step` frames for a step.
pub(super) fn walker(number: usize, step: f64) -> RgbImage {
    let spread = 7.0 * (std::f64::consts::PI * number as f64 / step).cos();
    RgbImage::from_fn(SIZE.0, SIZE.1, |x, y| {
        let (x, y) = (f64::from(x) - 29.5, f64::from(y));
        let trunk = (4.0..20.0).contains(&y) && x.abs() < 4.0;
        let along = (y - 18.0) / 18.0;
        let leg = |by: f64| (18.0..36.0).contains(&y) && (x - by * along).abs() < 2.0;
        if trunk || leg(spread) || leg(-spread) {
            CLOTHES
        } else {
            WALL
        }
    })
}

/// A segmenter for the empty scene.
pub(super) fn segmenter() -> Segmenter {
    let wall = RgbImage::from_pixel(SIZE.0, SIZE.1, WALL);
    Segmenter::new(wall, SegmentSettings::default())
}

/// Writes frames as a video.
pub(super) fn write_video(frames: impl Iterator<Item = RgbImage>, folder: &Path) {
    std::fs::create_dir_all(folder).expect("a folder");
    for (number, frame) in frames.enumerate() {
        let path = folder.join(format!("{number:03}.png"));
        frame.save(path).expect("a frame");
    }
}

/// Returns the leg measurements of the frames of a recording.
pub(super) fn legs(segmenter: &Segmenter, frames: &[RgbImage]) -> Vec<Option<LowerBody>> {
    let legs = frames.iter().map(|frame| {
        let mask = segmenter.segment(frame).mask;
        LowerBody::of_pixels(&mask.grey(), mask.columns())
    });
    legs.collect()
}

/// Returns a recognizer that answers with its input.
pub(super) fn echo(template: Template) -> MadeUp {
    let contract = Contract {
        template,
        layout: InputLayout::for_template(template),
        ..Contract::default()
    };
    MadeUp::new(contract, <[f32]>::to_vec)
}
