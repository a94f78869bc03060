//! Bodies have no seams: the background is visible only between the limbs.

use crate::parts::{ARMS, Parts, TRUNK};
use edgegait::people::Body;
use edgegait::people::cohort::anthropometry::{DIMENSIONS, Dimensions};
use edgegait::people::cohort::{Person, body};
use edgegait_core::pack::Sex;
use glam::{DQuat, DVec2, DVec3};
use rayon::prelude::*;

/// The size of a pixel, metres.
const PIXEL_M: f64 = 0.005;
/// The rows and columns of an image, enough for a tall runner from any side.
const SIZE: (usize, usize) = (440, 440);
/// Smaller holes lie where the outlines of two hulls cross: 1.25 cm2, a tenth of a pixel of a GEI.
const LEAST_PIXELS: usize = 5;
/// The minimum size of a gap between the legs that reaches the crotch, cm2. Gaps that are about to
/// close are smaller, and do not touch the trunk.
const GAP_CM2: f64 = 5.0;

/// Returns bodies with the person whose gait they have: sampled from seeds, and from slim to heavy.
fn walkers() -> Vec<(String, Body, Person)> {
    let drawn = [(1, 0..26), (3, 21..26)]
        .into_iter()
        .flat_map(|(seed, indices)| {
            indices.map(move |index| Person::of_cohort(seed, index).expect("a person"))
        });
    let mut walkers: Vec<_> = drawn
        .map(|person| (person.name.clone(), person.body.clone(), person))
        .collect();
    for sex in [Sex::Female, Sex::Male] {
        for bmi in [18.0, 24.0, 38.0] {
            let d = Dimensions::expected(1.7, bmi * 1.7 * 1.7, Some(sex), &[0.0; DIMENSIONS]);
            let d = d.expect("a plausible person");
            let name = format!("{sex:?} of {bmi} kg/m2");
            walkers.push((
                name,
                body::body(&d, body::offsets(&d)),
                Person::average(sex),
            ));
        }
    }
    walkers
}

/// Returns the projection of a camera far away; azimuth 0 is in front, 90 on the walker's left.
fn from_afar(azimuth_deg: f64, elevation_deg: f64, aim: DVec3) -> impl Fn(DVec3) -> DVec2 {
    let turn = DQuat::from_rotation_x(elevation_deg.to_radians())
        * DQuat::from_rotation_y(-azimuth_deg.to_radians());
    move |point| {
        let seen = turn * (point - aim);
        let middle = DVec2::new(SIZE.1 as f64, SIZE.0 as f64) * 0.5;
        middle + DVec2::new(seen.x, -seen.y) / PIXEL_M
    }
}

/// Returns the regions of background that the figure encloses, each with its number of pixels and
/// the adjacent parts. Pixels that touch at a corner belong to one region.
fn holes(picture: &Parts) -> Vec<(usize, u8)> {
    let columns = picture.columns;
    let rows = picture.pixels.len() / columns;
    let mut seen: Vec<bool> = picture.pixels.iter().map(|&parts| parts != 0).collect();
    let mut holes = Vec::new();
    for start in 0..seen.len() {
        if seen[start] {
            continue;
        }
        seen[start] = true;
        let (mut stack, mut size, mut beside, mut open) = (vec![start], 0, 0, false);
        while let Some(at) = stack.pop() {
            size += 1;
            let (row, column) = (at / columns, at % columns);
            open |= row == 0 || column == 0;
            open |= row + 1 == rows || column + 1 == columns;
            for row in row.saturating_sub(1)..(row + 2).min(rows) {
                for column in column.saturating_sub(1)..(column + 2).min(columns) {
                    let next = row * columns + column;
                    beside |= picture.pixels[next];
                    if !seen[next] {
                        seen[next] = true;
                        stack.push(next);
                    }
                }
            }
        }
        if !open {
            holes.push((size, beside));
        }
    }
    holes
}

/// Returns the number of images that were drawn of a walker, and the seams in them.
fn seams(walker: usize, name: &str, body: &Body, person: &Person) -> (usize, Vec<String>) {
    let (mut images, mut seams) = (0, Vec::new());
    for (speed_kmh, elevation_deg) in [(5.0, 0.0), (10.0, 0.0), (5.0, 20.0)] {
        let cycle = person.cycle(speed_kmh);
        for view in 0..12 {
            let azimuth_deg = 30.0 * f64::from(view);
            let frame = (walker * 7 + view as usize * 24 + view as usize / 4 * 8) % 96;
            let aim = cycle.root[frame];
            let place = from_afar(azimuth_deg, elevation_deg, aim);
            let pose = (cycle.root[frame], &cycle.rotations[frame]);
            let picture = Parts::draw(body, pose, place, SIZE);
            images += 1;
            for (pixels, beside) in holes(&picture) {
                let area_cm2 = pixels as f64 * PIXEL_M * PIXEL_M * 1e4;
                let is_gap = beside & ARMS != 0 || beside & TRUNK == 0 || area_cm2 > GAP_CM2;
                if pixels >= LEAST_PIXELS && !is_gap {
                    seams.push(format!(
                        "{name}, {speed_kmh} km/h, frame {frame}, azimuth {azimuth_deg}, elevation {elevation_deg}: {area_cm2:.2} cm2"
                    ));
                }
            }
        }
    }
    (images, seams)
}

/// A hole next to an arm is between arm and trunk. One that does not touch the trunk is between the
/// legs, and so is a large one, up to the crotch. Others are seams.
#[test]
fn the_background_shows_only_between_the_limbs() {
    let walkers = walkers();
    let found: Vec<(usize, Vec<String>)> = walkers
        .par_iter()
        .enumerate()
        .map(|(number, (name, body, person))| seams(number, name, body, person))
        .collect();
    let images: usize = found.iter().map(|(images, _)| images).sum();
    let seams: Vec<&String> = found.iter().flat_map(|(_, seams)| seams).collect();
    assert_eq!(images, 37 * 36);
    assert!(seams.is_empty(), "{} of {images}: {seams:#?}", seams.len());
}

#[test]
fn a_hole_in_a_body_is_found_and_a_notch_is_not() {
    let rows = ["111111", "100101", "100110", "111111", "110111"];
    let pixels = rows.concat().bytes().map(|digit| digit - b'0').collect();
    let picture = Parts { columns: 6, pixels };
    // The pixel at (1, 4) is enclosed by the figure, except that it touches the pixel at (2, 5), at
    // the edge of the image, at a corner.
    assert_eq!(holes(&picture), [(4, TRUNK)]);
}
