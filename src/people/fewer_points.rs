//! Bodies with fewer hull points, thinned so that the reach of their hulls changes least.

use super::{Body, BodyHull, Subject};
use crate::error::{Error, Result};
use edgegait_core::budget::MAX_POINTS;
use glam::DVec3;

/// Fewest points that bodies are thinned to: 16 tetrahedra. Our choice.
pub(crate) const MIN_POINTS: usize = 64;
/// Fewest points that a hull is thinned to: the corners of a tetrahedron.
const MIN_HULL_POINTS: usize = 4;
/// Directions in which a hull's reach is measured: about 14 degrees apart. Our choice.
const DIRECTIONS: usize = 256;
/// Largest distance between mirror images that rounding of sines causes, metres.
const ROUNDING_M: f64 = 1e-9;

/// Returns the body with at most `most` points (64 to 768) in all its hulls together, and at
/// least 4 in each hull that has that many. A body without more points is returned unchanged.
///
/// Points are left out one by one. The next one is always the point whose absence increases least
/// the sum over 256 directions of the fourth powers of its hull's loss of reach (its support
/// function, metres). In a symmetric hull both points of a pair are left out together, and so are
/// a point and its image in the hull on the walker's other side: up to 3 points fewer than `most`
/// may remain.
///
/// # Errors
/// For a number of points out of range, or one that leaves fewer than 4 points per hull.
pub(crate) fn thinned(body: &Body, most: usize) -> Result<Body> {
    if !(MIN_POINTS..=MAX_POINTS).contains(&most) {
        return Err(Error::Usage(format!(
            "{most} hull points: expected {MIN_POINTS} to {MAX_POINTS}"
        )));
    }
    let mut total: usize = body.hulls.iter().map(|hull| hull.points.len()).sum();
    if total <= most {
        return Ok(body.clone());
    }
    let mut parts = parts(&body.hulls);
    while total > most {
        let Some((part, group, _)) = least(&parts) else {
            return Err(Error::Usage(format!(
                "{most} hull points: too few for a body of {} hulls, expected at least {total}",
                body.hulls.len()
            )));
        };
        total -= parts[part].leave_out(group);
    }
    let mut hulls = body.hulls.clone();
    for part in &parts {
        hulls[part.hull].points.retain(|point| part.has(*point));
        if let Some(other) = part.other {
            hulls[other].points.retain(|&point| part.has(image(point)));
        }
    }
    Ok(Body {
        offsets: body.offsets,
        hulls,
        // Measured with all points, and not valid for fewer.
        draped: Vec::new(),
        clothes: None,
        fit: None,
    })
}

/// Returns the people with [`thinned`] bodies.
///
/// # Errors
/// As [`thinned`].
pub(crate) fn with_thinner_bodies(people: &[Subject], most: usize) -> Result<Vec<Subject>> {
    let thinner = |person: &Subject| {
        Ok(Subject {
            body: thinned(&person.body, most)?,
            ..person.clone()
        })
    };
    people.iter().map(thinner).collect()
}

/// A hull, and its mirror image on the walker's other side where there is one.
struct MirroredHull {
    /// Indices of the hull and of its image.
    hull: usize,
    other: Option<usize>,
    groups: Vec<PointGroup>,
    /// How far the hull reaches in each direction with all its points.
    whole: Vec<f64>,
    /// Cost of leaving out each group, per point that is saved.
    losses: Vec<f64>,
}

/// Points of one hull that are kept or left out together.
struct PointGroup {
    points: Vec<DVec3>,
    /// How far the group reaches in each direction.
    reach: Vec<f64>,
}

impl PointGroup {
    fn has(&self, point: DVec3) -> bool {
        has(&self.points, point)
    }
}

impl MirroredHull {
    fn has(&self, point: DVec3) -> bool {
        self.groups.iter().any(|group| group.has(point))
    }

    /// Leaves out a group, and returns how many points the body loses.
    fn leave_out(&mut self, group: usize) -> usize {
        let saved = self.groups.remove(group).points.len();
        self.losses = losses(&self.groups, &self.whole);
        if self.other.is_some() {
            2 * saved
        } else {
            saved
        }
    }

    /// Checks that enough points for a hull remain without this group.
    fn can_lack(&self, group: usize) -> bool {
        let points: usize = self.groups.iter().map(|group| group.points.len()).sum();
        points >= MIN_HULL_POINTS + self.groups[group].points.len()
    }
}

/// Returns the part and group whose points cost least, and that cost; `None` if every hull has
/// as few points as allowed.
fn least(parts: &[MirroredHull]) -> Option<(usize, usize, f64)> {
    let all = parts.iter().enumerate().flat_map(|(number, part)| {
        let losses = part.losses.iter().enumerate();
        let able = losses.filter(|&(group, _)| part.can_lack(group));
        able.map(move |(group, &loss)| (number, group, loss))
    });
    all.min_by(|(.., a), (.., b)| a.total_cmp(b))
}

fn parts(hulls: &[BodyHull]) -> Vec<MirroredHull> {
    let directions = directions(DIRECTIONS);
    let mut parts: Vec<MirroredHull> = Vec::new();
    for (index, hull) in hulls.iter().enumerate() {
        let is_other = |part: &&mut MirroredHull| {
            let first = &hulls[part.hull];
            part.other.is_none()
                && first.joint == hull.joint.mirrored()
                && is_image(&hull.points, &first.points)
        };
        if let Some(part) = parts.iter_mut().find(is_other) {
            part.other = Some(index);
            continue;
        }
        let groups = groups(&hull.points, &directions);
        let reach = |direction| farthest_two(&groups, direction).1;
        let whole: Vec<f64> = (0..directions.len()).map(reach).collect();
        parts.push(MirroredHull {
            hull: index,
            other: None,
            losses: losses(&groups, &whole),
            whole,
            groups,
        });
    }
    parts
}

/// Groups a hull's points in mirrored pairs if it is symmetric, and singly otherwise.
fn groups(points: &[DVec3], directions: &[DVec3]) -> Vec<PointGroup> {
    let is_symmetric = is_image(points, points);
    let mut groups: Vec<PointGroup> = Vec::new();
    for &point in points {
        if groups.iter().any(|group| group.has(point)) {
            continue;
        }
        let mut members = vec![point];
        if is_symmetric && !has(&members, image(point)) {
            members.push(image(point));
        }
        let reach = |direction: &DVec3| {
            let along = members.iter().map(|member| member.dot(*direction));
            along.fold(f64::NEG_INFINITY, f64::max)
        };
        groups.push(PointGroup {
            reach: directions.iter().map(reach).collect(),
            points: members,
        });
    }
    groups
}

/// Returns the cost of leaving out each group: the growth of the hull's loss of reach against
/// `whole`, its reach with all points, as the sum over directions of fourth powers, m4, per point
/// saved. The power is ours: of the first to tenth, the fourth and sixth give the smallest GEI
/// errors at 160 to 320 points (`edgegait frontier --quick`, 2026-11-21).
fn losses(groups: &[PointGroup], whole: &[f64]) -> Vec<f64> {
    let mut losses = vec![0.0; groups.len()];
    for (direction, whole) in whole.iter().enumerate() {
        let (group, reach, next) = farthest_two(groups, direction);
        losses[group] += (whole - next).powi(4) - (whole - reach).powi(4);
    }
    for (loss, group) in losses.iter_mut().zip(groups) {
        *loss /= group.points.len() as f64;
    }
    losses
}

/// Returns the group that reaches farthest in a direction, its reach, and the next group's reach.
fn farthest_two(groups: &[PointGroup], direction: usize) -> (usize, f64, f64) {
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

/// Checks that the points of two hulls are mirror images of each other, one to one.
fn is_image(points: &[DVec3], others: &[DVec3]) -> bool {
    points.len() == others.len() && points.iter().all(|&point| has(others, image(point)))
}

fn has(points: &[DVec3], point: DVec3) -> bool {
    points
        .iter()
        .any(|other| other.abs_diff_eq(point, ROUNDING_M))
}

/// Returns the mirror image of a point on the walker's other side.
fn image(point: DVec3) -> DVec3 {
    DVec3::new(-point.x, point.y, point.z)
}

/// Returns evenly spread directions: a spiral of equal areas (Fibonacci lattice, Swinbank &
/// Purser 2006, Q. J. R. Meteorol. Soc. 132:1769-1793).
pub(super) fn directions(count: usize) -> Vec<DVec3> {
    let golden = 0.5 * (1.0 + 5.0f64.sqrt());
    let direction = |index: usize| {
        let z = 1.0 - (2 * index + 1) as f64 / count as f64;
        let radius = libm::sqrt(1.0 - z * z);
        let (sin, cos) = libm::sincos(std::f64::consts::TAU * (index as f64 / golden).fract());
        DVec3::new(radius * cos, radius * sin, z)
    };
    (0..count).map(direction).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::people::cohort::Person;
    use edgegait_core::skeleton::{JOINTS, Joint};

    fn body(hulls: Vec<BodyHull>) -> Body {
        Body {
            offsets: [DVec3::ZERO; JOINTS],
            hulls,
            draped: Vec::new(),
            clothes: None,
            fit: None,
        }
    }

    fn corners(size: f64) -> Vec<DVec3> {
        let sides = [-size, size];
        let corners = sides.map(|x| sides.map(|y| sides.map(|z| DVec3::new(x, y, z))));
        corners.as_flattened().concat()
    }

    /// Eight boxes, for whose corners 64 points just suffice.
    fn boxes(more: &[DVec3]) -> Body {
        let with_more = |size: u8| {
            let size = 0.1 + 0.01 * f64::from(size);
            let scaled = more.iter().map(|&point| point * size / 0.1);
            BodyHull {
                joint: Joint::LeftHand,
                points: scaled.chain(corners(size)).collect(),
            }
        };
        body((0..8).map(with_more).collect())
    }

    fn points(body: &Body) -> Vec<Vec<DVec3>> {
        body.hulls.iter().map(|hull| hull.points.clone()).collect()
    }

    fn count(body: &Body) -> usize {
        body.hulls.iter().map(|hull| hull.points.len()).sum()
    }

    #[test]
    fn boxes_with_20_more_points_on_their_faces_keep_their_corners() {
        let mut on_faces = Vec::new();
        for index in 0..20 {
            let (a, b) = (f64::from(index % 5) - 2.0, f64::from(index / 5) - 1.5);
            let side = if index % 2 == 0 { 0.1 } else { -0.1 };
            let on_face = [side, 0.03 * a, 0.04 * b];
            let turn = index as usize % 3;
            on_faces.push(DVec3::from(std::array::from_fn(|axis| {
                on_face[(axis + turn) % 3]
            })));
        }
        let found = thinned(&boxes(&on_faces), 64).expect("64 points");
        assert_eq!(points(&found), points(&boxes(&[])));
    }

    #[test]
    fn the_points_that_stand_out_least_go_first() {
        // The tops of roofs that stand 1 mm above boxes of eight corners.
        let roof = DVec3::new(0.0, 0.101, 0.0);
        let found = thinned(&boxes(&[roof]), 64).expect("64 points");
        assert_eq!(points(&found), points(&boxes(&[])));
        // With four more points, the four highest remain: those of the largest boxes.
        let found = thinned(&boxes(&[roof]), 68).expect("68 points");
        let counts: Vec<usize> = found.hulls.iter().map(|hull| hull.points.len()).collect();
        assert_eq!(counts, [8, 8, 8, 8, 9, 9, 9, 9]);
    }

    #[test]
    fn a_hull_keeps_4_points_however_small_it_is() {
        let mut hulls = boxes(&[]).hulls;
        hulls[0].points = corners(1e-6);
        hulls.push(hulls[1].clone());
        let found = thinned(&body(hulls), 64).expect("64 points");
        assert_eq!(count(&found), 64);
        assert_eq!(found.hulls[0].points.len(), 4);
        assert!(found.hulls.iter().all(|hull| hull.points.len() >= 4));
    }

    #[test]
    fn no_person_keeps_more_points_and_what_was_symmetric_stays_so() {
        let whole = Person::of_cohort(1, 3).expect("a person").body;
        for most in (80..=MAX_POINTS).step_by(16) {
            let found = thinned(&whole, most).expect("80 to 768");
            let least = most.min(count(&whole)) - 3;
            assert!((least..=most).contains(&count(&found)), "{most}");
            for (before, hull) in whole.hulls.iter().zip(&found.hulls) {
                assert!(hull.points.len() >= before.points.len().min(4));
                assert!(hull.points.iter().all(|p| before.points.contains(p)));
                let mut others = found.hulls.iter();
                let has_image = others.any(|other| {
                    other.joint == hull.joint.mirrored() && is_image(&hull.points, &other.points)
                });
                assert!(has_image, "{:?}", hull.joint);
            }
        }
        let found = thinned(&whole, count(&whole)).expect("as many as there are");
        assert_eq!(points(&found), points(&whole));
    }

    #[test]
    fn fewer_than_64_points_more_than_768_and_too_few_for_the_hulls_are_refused() {
        for most in [0, 63, 769] {
            let error = thinned(&body(Vec::new()), most).expect_err("out of range");
            assert!(error.to_string().contains("expected 64 to 768"), "{error}");
        }
        let hulls = boxes(&[]).hulls;
        let error = thinned(&body([&hulls[..], &hulls, &hulls].concat()), 95);
        let error = error.expect_err("24 hulls").to_string();
        assert!(error.contains("24 hulls, expected at least 96"), "{error}");
    }
}
