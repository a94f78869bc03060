//! Reconstructs markers from the other markers of their segment.

use glam::DVec3;

use super::names::{MarkerSide, Segment};
use super::rigid::Rigid;
use super::set::{Mark, Marks, median};

/// The fewest other markers from which a marker is reconstructed.
const LEAST_OTHERS: usize = 3;

/// Largest RMS deviation of a segment's markers from a rigid body, metres. Our choice: skin moves
/// by 1 to 2 cm in gait (the review of Leardini et al. 2005, Gait & Posture 21:212-225, as
/// recalled).
const RIGID_M: f64 = 0.025;

/// A marker is off its segment where most of its distances to the others differ from their
/// medians by more than this, metres. Our choice: toes bend by 3 cm, labels err by more.
const STRAY_M: f64 = 0.04;

/// Drops positions that disagree with most other markers of the same segment: labels put on the
/// wrong marker.
pub(super) fn drop_strays(marks: &mut Marks, warnings: &mut Vec<String>) {
    for body in bodies(marks) {
        let numbers = markers_of(marks, body);
        let distance = |a: usize, b: usize, frame: usize| {
            Some(marks.all[a].track[frame]?.distance(marks.all[b].track[frame]?))
        };
        let usual: Vec<Vec<f64>> = numbers
            .iter()
            .map(|&a| {
                let to = |&b: &usize| {
                    median(
                        &mut (0..marks.frames)
                            .filter_map(|frame| distance(a, b, frame))
                            .collect::<Vec<_>>(),
                    )
                };
                numbers.iter().map(to).collect()
            })
            .collect();
        let is_stray = |i: usize, frame: usize| {
            let off: Vec<bool> = (0..numbers.len())
                .filter(|&j| j != i)
                .filter_map(|j| {
                    Some((distance(numbers[i], numbers[j], frame)? - usual[i][j]).abs() > STRAY_M)
                })
                .collect();
            off.len() >= 2 && 2 * off.iter().filter(|off| **off).count() > off.len()
        };
        let strays: Vec<Vec<usize>> = (0..numbers.len())
            .map(|i| {
                (0..marks.frames)
                    .filter(|&frame| is_stray(i, frame))
                    .collect()
            })
            .collect();
        for (number, frames) in numbers.into_iter().zip(strays) {
            let mark = &mut marks.all[number];
            for &frame in &frames {
                mark.track[frame] = None;
            }
            if let Some(first) = frames.first() {
                warnings.push(format!(
                    "marker {} is off its segment from frame {first}: left out in {} frames",
                    mark.name,
                    frames.len()
                ));
            }
        }
    }
}

/// The mean places of a segment's markers in its own frame, and their RMS deviation.
struct SegmentShape {
    /// The number of each marker, and its place.
    places: Vec<(usize, DVec3)>,
    rms_m: f64,
}

/// Fills missing positions from at least three other markers of the same segment.
pub(super) fn rebuild(marks: &mut Marks, warnings: &mut Vec<String>) {
    let mut rebuilt: Vec<String> = Vec::new();
    for body in bodies(marks) {
        let Some(shape) = shape_of(marks, body).filter(|shape| shape.rms_m < RIGID_M) else {
            continue;
        };
        for &(number, place) in &shape.places {
            let mut count = 0;
            for frame in 0..marks.frames {
                if marks.all[number].track[frame].is_some() {
                    continue;
                }
                let others = seen_pairs(&marks.all, &shape, frame);
                if others.len() < LEAST_OTHERS {
                    continue;
                }
                if let Some(fit) = Rigid::fit(&others) {
                    marks.all[number].track[frame] = Some(fit.apply(place));
                    count += 1;
                }
            }
            if count > 0 {
                rebuilt.push(format!("{} {count}", marks.all[number].name));
            }
        }
    }
    if !rebuilt.is_empty() {
        warnings.push(format!(
            "rebuilt from at least {LEAST_OTHERS} other markers of their segments (frames): {}",
            rebuilt.join(", ")
        ));
    }
}

/// Returns the segments that have enough markers to be checked.
fn bodies(marks: &Marks) -> Vec<(Segment, MarkerSide)> {
    let mut bodies: Vec<(Segment, MarkerSide)> = Vec::new();
    for mark in &marks.all {
        if mark.site.segment() != Segment::Alone && !bodies.contains(&mark.body()) {
            bodies.push(mark.body());
        }
    }
    bodies.retain(|body| markers_of(marks, *body).len() > LEAST_OTHERS);
    bodies
}

fn markers_of(marks: &Marks, body: (Segment, MarkerSide)) -> Vec<usize> {
    (0..marks.all.len())
        .filter(|&i| marks.all[i].body() == body)
        .collect()
}

/// Returns pairs of a shape's places and the positions of its markers in a frame.
fn seen_pairs(all: &[Mark], shape: &SegmentShape, frame: usize) -> Vec<(DVec3, DVec3)> {
    let pair = |&(number, place): &(usize, DVec3)| Some((place, all[number].track[frame]?));
    shape.places.iter().filter_map(pair).collect()
}

/// Returns the mean shape of a segment over the frames in which all of its markers are seen.
fn shape_of(marks: &Marks, body: (Segment, MarkerSide)) -> Option<SegmentShape> {
    /// Approximate number of evenly spread frames from which the shape is taken.
    const SAMPLES: usize = 100;
    let numbers = markers_of(marks, body);
    let whole: Vec<usize> = (0..marks.frames)
        .filter(|&frame| numbers.iter().all(|&i| marks.all[i].track[frame].is_some()))
        .collect();
    let frames: Vec<usize> = whole
        .iter()
        .copied()
        .step_by((whole.len() / SAMPLES).max(1))
        .collect();
    let points = |frame: usize| -> Vec<DVec3> {
        numbers
            .iter()
            .filter_map(|&i| marks.all[i].track[frame])
            .collect()
    };
    let mut mean = points(*frames.first()?);
    // Two rounds, beginning with the first frame.
    for _ in 0..2 {
        let mut sum = vec![DVec3::ZERO; mean.len()];
        for &frame in &frames {
            let pairs: Vec<(DVec3, DVec3)> = points(frame)
                .into_iter()
                .zip(mean.iter().copied())
                .collect();
            let fit = Rigid::fit(&pairs)?;
            for (sum, (point, _)) in sum.iter_mut().zip(&pairs) {
                *sum += fit.apply(*point);
            }
        }
        mean = sum
            .into_iter()
            .map(|sum| sum / frames.len() as f64)
            .collect();
    }
    let mut squares = 0.0;
    for &frame in &frames {
        let pairs: Vec<(DVec3, DVec3)> = mean.iter().copied().zip(points(frame)).collect();
        let fit = Rigid::fit(&pairs)?;
        squares += pairs
            .iter()
            .map(|(a, b)| fit.apply(*a).distance_squared(*b))
            .sum::<f64>();
    }
    let count = (frames.len() * numbers.len()) as f64;
    Some(SegmentShape {
        places: numbers.into_iter().zip(mean).collect(),
        rms_m: libm::sqrt(squares / count),
    })
}
