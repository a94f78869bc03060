//! Finds when a foot stands on the floor, and how far it slides there.
//!
//! A foot stands from its contact to the lift of its toes. Some point of its sole is then nearly
//! still; in the swing no point is. That also holds for feet that land flat or on the ball and for
//! runners, whose contact and lift are not the moments when the ankle is farthest ahead and behind
//! ([`super::contacts`]).

use edgegait_core::skeleton::{JOINTS, Joint};
use glam::{DQuat, DVec3};

use crate::people::retarget::{ANKLE_HEIGHT, RetargetedMotion, leg_length_m};
use crate::people::{Body, Cycle, Track, UncutMotion, Walk, forward_kinematics};

/// Distances of heel, ball and toe tip ahead of the ankle over hip-to-ankle length: -0.25, 0.48 and
/// 0.75 of a foot of 0.152 statures, over 0.491 (Winter 2009, figure 4.1; ball: 0.73 of the foot
/// from the heel, ANSUR II).
const SOLE_REACH: [f64; 3] = [-0.077, 0.149, 0.232];

/// Speed below which a point of a sole is still, as a share of the ankle's greatest speed.
const STILL: f64 = 0.15;

/// The minimum value of that speed, for ankles that hardly move, m/s. Our choice.
const STILL_M_S: f64 = 0.1;

/// Height above its usual lowest place from which a sole is in the air, over hip-to-ankle length.
/// Our choice.
const IN_THE_AIR: f64 = 0.1;

/// Shortest time of a foot off the floor, seconds. Our choice: a sprinter's swing takes 0.25.
const SHORTEST_SWING_S: f64 = 0.08;

/// A motion for the analysis of its feet.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FeetMotion<'a> {
    /// Joint offsets of the body that moves, metres.
    offsets: &'a [DVec3; JOINTS],
    roots: &'a [DVec3],
    rotations: &'a [[DQuat; JOINTS]],
    rate_hz: f64,
    /// Travel of a cycle, metres, which its roots leave out; none for a motion that does not
    /// repeat.
    cycle_m: Option<f64>,
}

/// Points of the left and the right sole, in the frame of the foot, metres.
pub(in crate::people) type Soles = [Vec<DVec3>; 2];

/// The slide of standing feet from contact to lift.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FootSlide {
    /// Mean slide over the stances of both feet, mm.
    pub mean_mm: f64,
    /// Slide of the worst stance, mm.
    pub max_mm: f64,
}

/// Returns the soles that belong to legs of this hip-to-ankle length.
pub(in crate::people) fn soles_of_legs(leg_m: f64) -> Soles {
    let sole = SOLE_REACH.map(|reach| DVec3::new(0.0, -ANKLE_HEIGHT, reach) * leg_m);
    [sole.to_vec(), sole.to_vec()]
}

/// Returns all points of a body's feet.
pub(in crate::people) fn soles_of_body(body: &Body) -> Soles {
    [Joint::LeftFoot, Joint::RightFoot].map(|foot| {
        let hulls = body.hulls.iter().filter(|hull| hull.joint == foot);
        hulls.flat_map(|hull| hull.points.iter().copied()).collect()
    })
}

impl Walk {
    /// Returns how far the lowest points of the feet slide over the floor on `body`; none if
    /// neither foot ever stands.
    #[must_use]
    pub fn skate(&self, body: &Body) -> Option<FootSlide> {
        let steps = match &self.motion {
            Track::Loop(cycle) => FeetMotion::of_cycle(cycle, &body.offsets),
            Track::Uncut(span) => FeetMotion::of_span(span, &body.offsets),
        };
        steps.skate_on(body)
    }
}

impl<'a> FeetMotion<'a> {
    /// Takes a cycle on a skeleton with these joint offsets.
    #[must_use]
    pub(crate) fn of_cycle(cycle: &'a Cycle, offsets: &'a [DVec3; JOINTS]) -> Self {
        Self {
            offsets,
            roots: &cycle.root,
            rotations: &cycle.rotations,
            rate_hz: cycle.root.len() as f64 / cycle.period_s,
            cycle_m: Some(cycle.drift_m),
        }
    }

    /// Takes an uncut motion on a skeleton with these joint offsets.
    #[must_use]
    pub(crate) fn of_span(span: &'a UncutMotion, offsets: &'a [DVec3; JOINTS]) -> Self {
        Self {
            offsets,
            roots: &span.roots,
            rotations: &span.rotations,
            rate_hz: span.sample_rate_hz,
            cycle_m: None,
        }
    }

    /// Takes a recorded motion on its walker's own skeleton.
    #[must_use]
    pub(crate) fn of_take(take: &'a RetargetedMotion) -> Self {
        Self {
            offsets: &take.offsets,
            roots: &take.roots,
            rotations: &take.rotations,
            rate_hz: take.sample_rate_hz,
            cycle_m: None,
        }
    }

    /// Returns the hip-to-ankle length, metres.
    pub(in crate::people) fn leg_m(&self) -> f64 {
        leg_length_m(self.offsets)
    }

    /// Returns whether the left and the right foot stand, by frame.
    #[must_use]
    pub(crate) fn stances(&self) -> Vec<[bool; 2]> {
        let leg_m = self.leg_m();
        let places = self.places(&soles_of_legs(leg_m));
        let ankles = self.places(&[vec![DVec3::ZERO], vec![DVec3::ZERO]]);
        let frames = self.roots.len();
        let mut stands = vec![[false; 2]; frames];
        for foot in 0..2 {
            let mut speeds: Vec<f64> = (0..frames)
                .map(|frame| self.speed(&ankles, foot, 0, frame))
                .collect();
            let still = (STILL * quantile(&mut speeds, 0.95)).max(STILL_M_S);
            let height = |frame: usize| {
                let heights = places[frame][foot].iter().map(|point| point.y);
                heights.fold(f64::INFINITY, f64::min)
            };
            let mut heights: Vec<f64> = (0..frames).map(height).collect();
            let high = quantile(&mut heights, 0.1) + IN_THE_AIR * leg_m;
            for (frame, stands) in stands.iter_mut().enumerate() {
                let slowest = (0..SOLE_REACH.len())
                    .map(|point| self.speed(&places, foot, point, frame))
                    .fold(f64::INFINITY, f64::min);
                stands[foot] = slowest < still && height(frame) < high;
            }
            self.fill(&mut stands, foot);
        }
        stands
    }

    /// Makes swings that are too short part of the stance around them.
    fn fill(&self, stands: &mut [[bool; 2]], foot: usize) {
        let count = stands.len();
        let shortest = (SHORTEST_SWING_S * self.rate_hz) as usize;
        let around = |frame: usize, by: usize, stands: &[[bool; 2]]| match self.cycle_m {
            Some(_) => stands[(frame + by) % count][foot],
            None => stands.get(frame + by).is_some_and(|stands| stands[foot]),
        };
        for frame in 0..count {
            if !stands[frame][foot] {
                continue;
            }
            let next = (1..=shortest + 1)
                .rev()
                .find(|&by| around(frame, by, stands));
            for by in 1..next.unwrap_or(1) {
                stands[(frame + by) % count][foot] = true;
            }
        }
    }

    /// Returns the share of the frames in which a foot stands, mean of both feet.
    #[must_use]
    pub(crate) fn duty_factor(&self) -> f64 {
        let stances = self.stances();
        let standing = stances.iter().flatten().filter(|stands| **stands);
        standing.count() as f64 / (2 * stances.len()) as f64
    }

    /// Returns the move of each sole's lowest point over the floor from each frame to the next,
    /// while the foot stands.
    pub(in crate::people) fn slides(
        &self,
        stands: &[[bool; 2]],
        soles: &Soles,
    ) -> Vec<[Option<DVec3>; 2]> {
        let places = self.places(soles);
        let next = |frame: usize| (frame + 1) % self.roots.len();
        (0..places.len() - 1)
            .map(|frame| {
                [0, 1].map(|foot| {
                    if !(stands[frame][foot] && stands[next(frame)][foot]) {
                        return None;
                    }
                    let (here, there) = (&places[frame][foot], &places[frame + 1][foot]);
                    let lowest =
                        (0..here.len()).min_by(|&a, &b| here[a].y.total_cmp(&here[b].y))?;
                    let slide = there[lowest] - here[lowest];
                    Some(DVec3::new(slide.x, 0.0, slide.z))
                })
            })
            .collect()
    }

    /// Returns the move of the lowest point of both soles from each frame to the next.
    pub(in crate::people) fn lowest_slides(&self) -> Vec<DVec3> {
        let places = self.places(&soles_of_legs(self.leg_m()));
        let steps = places.windows(2).filter_map(|pair| {
            let here = pair[0].iter().flatten();
            let there = pair[1].iter().flatten();
            let lowest = here.zip(there).min_by(|a, b| a.0.y.total_cmp(&b.0.y));
            lowest.map(|(from, to)| *to - *from)
        });
        steps.collect()
    }

    /// Returns how far the lowest points of a body's feet slide; none if neither ever stands.
    #[must_use]
    pub(crate) fn skate_on(&self, body: &Body) -> Option<FootSlide> {
        self.skate(&soles_of_body(body))
    }

    /// Returns how far a body's feet would slide if its legs moved in proportion to these: the part
    /// of its slide that comes from the recording.
    #[must_use]
    pub(crate) fn own_skate(&self, body: &Body) -> Option<FootSlide> {
        let ratio = leg_length_m(&body.offsets) / self.leg_m();
        let soles =
            soles_of_body(body).map(|sole| sole.iter().map(|point| *point / ratio).collect());
        let own = self.skate(&soles)?;
        Some(FootSlide {
            mean_mm: own.mean_mm * ratio,
            max_mm: own.max_mm * ratio,
        })
    }

    fn skate(&self, soles: &Soles) -> Option<FootSlide> {
        let slides = self.slides(&self.stances(), soles);
        let mut paths_mm: Vec<f64> = Vec::new();
        for foot in 0..2 {
            let mut of_foot: Vec<Option<f64>> = slides
                .iter()
                .map(|slide| slide[foot].map(|slide| slide.length() * 1e3))
                .collect();
            // A cycle's stance may continue from its end to its beginning.
            if let Some(swing) = of_foot.iter().position(Option::is_none)
                && self.cycle_m.is_some()
            {
                of_foot.rotate_left(swing);
            }
            let stances = of_foot.split(Option::is_none).filter(|s| !s.is_empty());
            paths_mm.extend(stances.map(|stance| stance.iter().flatten().sum::<f64>()));
        }
        let mean_mm = paths_mm.iter().sum::<f64>() / paths_mm.len() as f64;
        let max_mm = paths_mm.iter().copied().fold(0.0, f64::max);
        (!paths_mm.is_empty()).then_some(FootSlide { mean_mm, max_mm })
    }

    /// Returns the positions of points of the feet, by frame and foot. A cycle's first frame is
    /// repeated at the end, moved by the cycle's travel.
    fn places(&self, points: &Soles) -> Vec<[Vec<DVec3>; 2]> {
        let frames = self.roots.len();
        let last = match self.cycle_m {
            Some(_) => frames,
            None => frames - 1,
        };
        (0..=last)
            .map(|frame| {
                let along = self.cycle_m.unwrap_or_default() * frame as f64 / frames as f64;
                let root = self.roots[frame % frames] + DVec3::Z * along;
                let pose = &self.rotations[frame % frames];
                let (positions, globals) = forward_kinematics(self.offsets, root, pose);
                [(Joint::LeftFoot, 0), (Joint::RightFoot, 1)].map(|(foot, side)| {
                    let (at, turned) = (positions[foot.index()], globals[foot.index()]);
                    let points = points[side].iter();
                    points.map(|point| at + turned * *point).collect()
                })
            })
            .collect()
    }

    /// Returns the speed of a point in a frame, m/s, from the frames before and after it.
    fn speed(&self, places: &[[Vec<DVec3>; 2]], foot: usize, point: usize, frame: usize) -> f64 {
        let at = |frame: usize| places[frame][foot][point];
        let last = places.len() - 1;
        let (step, frames) = match (frame, self.cycle_m) {
            // The step that ends at a cycle's first frame is its last one.
            (0, Some(_)) => (at(1) - at(0) + at(last) - at(last - 1), 2.0),
            _ => {
                let (from, to) = (frame.saturating_sub(1), (frame + 1).min(last));
                (at(to) - at(from), (to - from).max(1) as f64)
            }
        };
        step.length() * self.rate_hz / frames
    }
}

/// Returns the value below which this share of the values lies.
fn quantile(values: &mut [f64], share: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    let at = (share * values.len() as f64) as usize;
    values
        .get(at.min(values.len() - 1))
        .copied()
        .unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::people::cohort::Person;
    use edgegait_core::pack::Sex;

    /// Healthy walkers have duty factors of 0.58 to 0.64 (Perry 1992), runners below 0.5. Synthetic
    /// feet slide, especially in running, which makes their stances shorter. Recorded ones are
    /// compared with laboratories' events in `tests/import/manifest.rs`.
    #[test]
    fn walkers_stand_longer_than_half_a_cycle_and_runners_shorter() {
        for (speed_kmh, expected) in [
            (4.0, 0.56..0.68),
            (5.0, 0.55..0.66),
            (8.0, 0.22..0.45),
            (12.0, 0.22..0.42),
        ] {
            let person = Person::average(Sex::Female);
            let cycle = person.cycle(speed_kmh);
            let duty_factor = FeetMotion::of_cycle(&cycle, &person.body.offsets).duty_factor();
            assert!(
                expected.contains(&duty_factor),
                "{speed_kmh}: {duty_factor}"
            );
        }
    }

    #[test]
    fn a_foot_that_is_dragged_along_skates_as_far() {
        // A rest pose, held for 11 frames while the body slides ahead by 2 mm a frame: 20 mm.
        let body = Person::average(Sex::Female).body;
        let span = UncutMotion {
            sample_rate_hz: 40.0,
            roots: (0..11)
                .map(|i| DVec3::new(0.0, 0.9, 0.002 * f64::from(i)))
                .collect(),
            rotations: vec![[DQuat::IDENTITY; JOINTS]; 11],
        };
        let steps = FeetMotion::of_span(&span, &body.offsets);
        assert_eq!(steps.duty_factor(), 1.0);
        let skate = steps.skate(&soles_of_body(&body)).expect("both feet stand");
        assert!((skate.mean_mm - 20.0).abs() < 1e-9, "{skate:?}");
        assert!((skate.max_mm - 20.0).abs() < 1e-9, "{skate:?}");
    }

    #[test]
    fn feet_of_larger_legs_slide_as_much_further_as_these_are_longer() {
        let person = Person::average(Sex::Female);
        let cycle = person.cycle(5.0);
        let steps = FeetMotion::of_cycle(&cycle, &person.body.offsets);
        let own = steps.own_skate(&person.body).expect("both feet stand");
        assert_eq!(Some(own), steps.skate_on(&person.body));
        let mut larger = person.body.clone();
        larger.offsets = larger.offsets.map(|offset| 1.5 * offset);
        for point in larger.hulls.iter_mut().flat_map(|hull| &mut hull.points) {
            *point *= 1.5;
        }
        let found = steps.own_skate(&larger).expect("both feet stand");
        assert!(
            (found.mean_mm - 1.5 * own.mean_mm).abs() < 1e-9,
            "{found:?}"
        );
        assert!((found.max_mm - 1.5 * own.max_mm).abs() < 1e-9, "{found:?}");
    }

    #[test]
    fn a_swing_of_two_frames_is_none() {
        let person = Person::average(Sex::Female);
        let cycle = person.cycle(5.0);
        let steps = FeetMotion::of_cycle(&cycle, &person.body.offsets);
        let mut stands = vec![[true; 2]; 96];
        stands[95][0] = false;
        stands[0][0] = false;
        for stands in &mut stands[30..60] {
            stands[0] = false;
        }
        steps.fill(&mut stands, 0);
        assert!(stands[95][0] && stands[0][0]);
        assert!(stands[30..60].iter().all(|stands| !stands[0]));
    }
}
