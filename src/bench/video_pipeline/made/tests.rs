//! Tests of the synthetic video against its source.

use super::*;
use crate::dataset::gait_cycles::{CycleFinder, LowerBody};
use crate::dataset::sequences::{BUILT_IN_WALK, PackSource, built_in};
use crate::segment::{SegmentSettings as Segmentation, Segmenter};

#[test]
fn a_walker_crosses_the_picture_as_a_whole_and_is_found_in_it() {
    let source = PackSource::made(&built_in(&[BUILT_IN_WALK.into()]), &|| Ok(())).expect("a pack");
    let pack = Pack::parse(&source.bytes).expect("a pack");
    let (columns, rows) = MADE_SIZE;
    let masks = masks(&pack, 0).expect("drawn");
    // 5 km/h are 1.39 m or 89 pixels a second; 320 pixels less a figure and margins take 2.5 to 3.2
    // s.
    assert!((60..=82).contains(&masks.len()), "{}", masks.len());
    let place = |mask: &Vec<u8>| {
        let on: Vec<usize> = (0..mask.len()).filter(|at| mask[*at] > 0).collect();
        let xs = on.iter().map(|at| (at % columns) as f64);
        let top = on.iter().map(|at| at / columns).min().expect("a figure");
        let bottom = on.iter().map(|at| at / columns).max().expect("a figure");
        (xs.sum::<f64>() / on.len() as f64, top, bottom)
    };
    let subject = pack.walk(0).and_then(|walk| pack.subject(walk.subject));
    let stature_m = 1e-3 * f64::from(subject.expect("somebody").stature_mm);
    for mask in &masks {
        let (_, top, bottom) = place(mask);
        let height = (bottom + 1 - top) as f64;
        let share = height / (f64::from(SCALE) * stature_m);
        assert!((0.93..1.04).contains(&share), "{height} of {stature_m} m");
        assert!((210..=220).contains(&bottom) && bottom < rows, "{bottom}");
        let is_edge = |at: usize| at.is_multiple_of(columns) || at % columns == columns - 1;
        assert!((0..mask.len()).all(|at| !is_edge(at) || mask[at] == 0));
    }
    let travelled = place(&masks[0]).0 - place(&masks[25]).0;
    assert!((travelled / 89.0 - 1.0).abs() < 0.05, "{travelled}");

    // `segment` finds the walker in the video, with at least two gait cycles.
    let folder = tempfile::tempdir().expect("a folder");
    write_made(&pack, 0, 1, folder.path()).expect("a video");
    let open = |name: &str| {
        image::open(folder.path().join(name))
            .expect("a picture")
            .into_rgb8()
    };
    let segmenter = Segmenter::new(open("background.png"), Segmentation::default());
    let mut legs = Vec::new();
    let mut jaccard = 0.0;
    for (number, mask) in masks.iter().enumerate() {
        let found = segmenter
            .segment(&open(&format!("frames/{:03}.jpg", number + 1)))
            .mask;
        let pairs = found.pixels().iter().zip(mask);
        let both = pairs.clone().filter(|(a, b)| **a && **b > 0).count() as f64;
        let either = pairs.filter(|(a, b)| **a || **b > 0).count() as f64;
        jaccard += both / either / masks.len() as f64;
        legs.push(LowerBody::of_pixels(&found.grey(), columns));
    }
    assert!(jaccard > 0.85, "{jaccard}");
    let finder = CycleFinder::new(MADE_FPS).expect("a rate");
    let cycles = finder.find(legs).expect("cycles");
    let walk = pack.walk(0).expect("a walk");
    let clip = pack.clip(walk.clip).expect("a clip");
    let period = f64::from(MADE_FPS) * clip.duration_s();
    assert!(cycles.cycles.len() >= 2, "{cycles:?}");
    assert!(
        (cycles.period_frames / period - 1.0).abs() < 0.06,
        "{period} {cycles:?}"
    );
}

#[test]
fn a_mask_has_the_pixels_whose_middles_are_inside() {
    // From (2.6, 1) to (5.4, 4), moved by 10: columns 13 and 14, rows 1 to 3.
    let corners = [(2.6, 1.0), (5.4, 1.0), (5.4, 4.0), (2.6, 4.0)];
    let outline = outline::convex(corners.map(|(x, y)| Vec2::new(x, y)));
    let pixels = mask(&[outline], 10.0);
    let on: Vec<usize> = (0..pixels.len()).filter(|at| pixels[*at] > 0).collect();
    let expected: Vec<usize> = (1..4)
        .flat_map(|row| [320 * row + 13, 320 * row + 14])
        .collect();
    assert_eq!(on, expected);
}

#[test]
fn the_video_follows_from_its_seed() {
    let source = PackSource::made(&built_in(&[BUILT_IN_WALK.into()]), &|| Ok(())).expect("a pack");
    let pack = Pack::parse(&source.bytes).expect("a pack");
    let frame = |seed| {
        let folder = tempfile::tempdir().expect("a folder");
        write_made(&pack, 0, seed, folder.path()).expect("a video");
        fs::read(folder.path().join("frames/007.jpg")).expect("a frame")
    };
    let one = frame(1);
    assert!(one == frame(1) && one != frame(2));
}
