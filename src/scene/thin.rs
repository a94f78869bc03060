//! Bodies of fewer hull points: what is left out changes least how far hulls reach.

use super::{Body, BodyHull, Subject};
use crate::error::{Error, Result};
use edgegait_core::budget::MAX_HULL_POINTS;
use glam::DVec3;

/// Fewest points that hulls are thinned to: the corners of a box.
pub const MIN_HULL_POINTS: usize = 8;
/// Directions in which a hull's reach is measured: about 14 degrees apart. Ours.
const DIRECTIONS: usize = 256;

/// The body with at most `most` points in each hull, 8 to 32.
///
/// Points are left out one by one: always the one without which the squares of what the hull
/// lost of its reach (its support function) in 256 directions sum up to least. Of a symmetric hull both
/// points of a pair are left out together, and the image of a hull on the walker's other
/// side stays its image.
///
/// # Errors
/// For another number of points.
pub fn thinned(body: &Body, most: usize) -> Result<Body> {
    if !(MIN_HULL_POINTS..=MAX_HULL_POINTS).contains(&most) {
        return Err(Error::Usage(format!(
            "{most} hull points: expected {MIN_HULL_POINTS} to {MAX_HULL_POINTS}"
        )));
    }
    let directions = directions();
    let mut hulls: Vec<BodyHull> = Vec::new();
    for (index, hull) in body.hulls.iter().enumerate() {
        let other = body.hulls[..index].iter().position(|other| {
            other.joint == hull.joint.mirrored() && is_image(&hull.points, &other.points)
        });
        let points = match other {
            Some(other) => hulls[other].points.iter().copied().map(image).collect(),
            None => thinned_hull(&hull.points, most, &directions),
        };
        hulls.push(BodyHull {
            joint: hull.joint,
            points,
        });
    }
    Ok(Body {
        offsets: body.offsets,
        hulls,
    })
}

/// The same people with [`thinned`] bodies.
///
/// # Errors
/// As [`thinned`].
pub fn with_thinner_bodies(people: &[Subject], most: usize) -> Result<Vec<Subject>> {
    let thinner = |person: &Subject| {
        Ok(Subject {
            body: thinned(&person.body, most)?,
            ..person.clone()
        })
    };
    people.iter().map(thinner).collect()
}

/// Points of one hull that are kept or left out together.
struct Group {
    points: Vec<DVec3>,
    /// How far it reaches in each direction.
    reach: Vec<f64>,
}

fn thinned_hull(points: &[DVec3], most: usize, directions: &[DVec3]) -> Vec<DVec3> {
    if points.len() <= most {
        return points.to_vec();
    }
    let mut groups = groups(points, directions);
    let whole: Vec<f64> = (0..directions.len())
        .map(|direction| farthest_two(&groups, direction).1)
        .collect();
    while groups.iter().map(|group| group.points.len()).sum::<usize>() > most {
        let losses = losses(&groups, &whole);
        let least = (0..groups.len()).min_by(|&a, &b| losses[a].total_cmp(&losses[b]));
        let Some(least) = least else { break };
        groups.remove(least);
    }
    let is_kept = |point: &DVec3| groups.iter().any(|group| group.points.contains(point));
    points.iter().copied().filter(is_kept).collect()
}

/// A hull's points in pairs where it is symmetric, else each alone.
fn groups(points: &[DVec3], directions: &[DVec3]) -> Vec<Group> {
    let is_symmetric = is_image(points, points);
    let mut groups: Vec<Group> = Vec::new();
    for &point in points {
        if groups.iter().any(|group| group.points.contains(&point)) {
            continue;
        }
        let mut members = vec![point];
        if is_symmetric && image(point) != point {
            members.push(image(point));
        }
        let reach = |direction: &DVec3| {
            let along = members.iter().map(|member| member.dot(*direction));
            along.fold(f64::NEG_INFINITY, f64::max)
        };
        groups.push(Group {
            reach: directions.iter().map(reach).collect(),
            points: members,
        });
    }
    groups
}

/// What the hull lacks of `whole`, its reach with all points, without each of the groups: the
/// sum over directions of squares, for each point that is saved.
fn losses(groups: &[Group], whole: &[f64]) -> Vec<f64> {
    let lack = |direction: usize, reach: f64| (whole[direction] - reach).powi(2);
    let farthest: Vec<(usize, f64, f64)> = (0..whole.len())
        .map(|direction| farthest_two(groups, direction))
        .collect();
    let now: f64 = farthest
        .iter()
        .enumerate()
        .map(|(direction, &(_, reach, _))| lack(direction, reach))
        .sum();
    let mut losses = vec![now; groups.len()];
    for (direction, &(group, reach, next)) in farthest.iter().enumerate() {
        losses[group] += lack(direction, next) - lack(direction, reach);
    }
    for (loss, group) in losses.iter_mut().zip(groups) {
        *loss /= group.points.len() as f64;
    }
    losses
}

/// The group that reaches farthest in a direction, how far, and how far the others do.
fn farthest_two(groups: &[Group], direction: usize) -> (usize, f64, f64) {
    let mut found = (0, f64::NEG_INFINITY, f64::NEG_INFINITY);
    for (index, group) in groups.iter().enumerate() {
        let reach = group.reach[direction];
        if reach > found.1 {
            found = (index, reach, found.1);
        } else if reach > found.2 {
            found.2 = reach;
        }
    }
    found
}

/// Whether each point of one hull has its mirror image in the other, and none is left.
fn is_image(points: &[DVec3], others: &[DVec3]) -> bool {
    points.len() == others.len() && points.iter().all(|&point| others.contains(&image(point)))
}

/// The mirror image on the walker's other side.
fn image(point: DVec3) -> DVec3 {
    DVec3::new(-point.x, point.y, point.z)
}

/// Directions spread evenly: a spiral of equal areas (Fibonacci lattice, Swinbank & Purser
/// 2006, Q. J. R. Meteorol. Soc. 132:1769-1793).
fn directions() -> Vec<DVec3> {
    let golden = 0.5 * (1.0 + 5.0f64.sqrt());
    let direction = |index: usize| {
        let z = 1.0 - (2 * index + 1) as f64 / DIRECTIONS as f64;
        let radius = libm::sqrt(1.0 - z * z);
        let (sin, cos) = libm::sincos(std::f64::consts::TAU * (index as f64 / golden).fract());
        DVec3::new(radius * cos, radius * sin, z)
    };
    (0..DIRECTIONS).map(direction).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::cohort::Person;
    use edgegait_core::skeleton::{JOINTS, Joint};

    fn body(hulls: Vec<BodyHull>) -> Body {
        Body {
            offsets: [DVec3::ZERO; JOINTS],
            hulls,
        }
    }

    fn corners(size: f64) -> Vec<DVec3> {
        let sides = [-size, size];
        let corners = sides.map(|x| sides.map(|y| sides.map(|z| DVec3::new(x, y, z))));
        corners.as_flattened().concat()
    }

    #[test]
    fn a_cube_with_20_more_points_on_its_faces_keeps_its_8_corners() {
        let cube = corners(0.1);
        let mut points = Vec::new();
        for index in 0..20 {
            let (a, b) = (f64::from(index % 5) - 2.0, f64::from(index / 5) - 1.5);
            let side = if index % 2 == 0 { 0.1 } else { -0.1 };
            let on_face = [side, 0.03 * a, 0.04 * b];
            let turn = index as usize % 3;
            points.push(DVec3::from(std::array::from_fn(|axis| {
                on_face[(axis + turn) % 3]
            })));
        }
        points.extend(&cube);
        let hull = BodyHull {
            joint: Joint::LeftHand,
            points,
        };
        let found = thinned(&body(vec![hull]), 8).expect("8 points");
        assert_eq!(found.hulls[0].points, cube);
    }

    #[test]
    fn the_corner_that_stands_out_least_goes_first() {
        // A pyramid whose top stands 1 mm above its base of eight corners.
        let mut points: Vec<DVec3> = corners(0.1);
        points.push(DVec3::new(0.0, 0.101, 0.0));
        let hull = BodyHull {
            joint: Joint::LeftHand,
            points,
        };
        let found = thinned(&body(vec![hull]), 8).expect("8 points");
        assert_eq!(found.hulls[0].points, corners(0.1));
    }

    #[test]
    fn no_hull_of_a_person_keeps_more_points_and_what_was_symmetric_stays_so() {
        let whole = Person::of_cohort(1, 3).expect("a person").body;
        for most in MIN_HULL_POINTS..=MAX_HULL_POINTS {
            let found = thinned(&whole, most).expect("8 to 32");
            for (before, hull) in whole.hulls.iter().zip(&found.hulls) {
                assert!(hull.points.len() <= most);
                // At most one point short, the other of a pair.
                assert!(hull.points.len() + 1 >= most.min(before.points.len()));
                assert!(hull.points.iter().all(|p| before.points.contains(p)));
                let images: Vec<DVec3> = hull.points.iter().copied().map(image).collect();
                let mirrored = found.hulls.iter().find(|other| {
                    other.joint == hull.joint.mirrored() && is_image(&images, &hull.points)
                        || other.points == images
                });
                assert!(mirrored.is_some(), "{:?}", hull.joint);
            }
        }
        let found = thinned(&whole, MAX_HULL_POINTS).expect("32");
        let points = |body: &Body| -> Vec<Vec<DVec3>> {
            body.hulls.iter().map(|hull| hull.points.clone()).collect()
        };
        assert_eq!(points(&found), points(&whole));
    }

    #[test]
    fn fewer_than_8_points_and_more_than_32_are_refused() {
        for most in [0, 7, 33] {
            let error = thinned(&body(Vec::new()), most).expect_err("out of range");
            assert!(error.to_string().contains("expected 8 to 32"), "{error}");
        }
    }
}
