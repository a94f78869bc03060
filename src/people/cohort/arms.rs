//! The overlap of hanging arms with the trunk, and the abduction that clears it.
//!
//! A trunk's breadth grows with mass and the shoulders' with stature, so arms that hang beside a
//! slim trunk are inside of a heavy one. Both are stacks of rings here, and only an arm's inner
//! points are tested: accurate enough for a hanging arm, and cheap enough for every frame.

use super::rings::RING;
use crate::people::{Body, BodyHull, forward_kinematics};
use edgegait_core::skeleton::{JOINTS, Joint};
use glam::{DQuat, DVec3};

/// How deep an arm may press into the flank, metres: skin and clothes give way. Our choice.
pub(super) const SOFT_TISSUE: f64 = 0.012;
/// Indices of a ring's points that face the other arm: the inner half without its ends.
const INNER: [usize; 3] = [3, 4, 5];

/// A cross-section of a trunk or thigh in its joint's frame: an octagon about two axes.
#[derive(Clone, Copy, Debug)]
struct CrossSection {
    centre: DVec3,
    half: (f64, f64),
    /// How far the points between the axes lie out, as a share of the half axes.
    diagonal: f64,
}

impl CrossSection {
    fn from_ring(ring: &[DVec3]) -> Self {
        let centre = 0.5 * (ring[0] + ring[4]);
        let half = ((ring[0].x - centre.x).abs(), ring[2].z - centre.z);
        let diagonal = (ring[1].z - centre.z) / half.1;
        Self {
            centre,
            half,
            diagonal,
        }
    }

    fn between(&self, other: &Self, along: f64) -> Self {
        let mix = |a: f64, b: f64| a + along * (b - a);
        Self {
            centre: self.centre.lerp(other.centre, along),
            half: (
                mix(self.half.0, other.half.0),
                mix(self.half.1, other.half.1),
            ),
            diagonal: mix(self.diagonal, other.diagonal),
        }
    }

    /// Returns how far a point has to move to the side of `sign` to leave the octagon shrunk by
    /// `margin`, metres; at most 0 outside.
    fn depth_m(&self, point: DVec3, sign: f64, margin: f64) -> f64 {
        let half = (self.half.0 - margin, self.half.1 - margin);
        let off = (point.z - self.centre.z).abs() / half.1;
        if off >= 1.0 || half.0 <= 0.0 {
            return 0.0;
        }
        let edge = if off < self.diagonal {
            1.0 - off * (1.0 - self.diagonal) / self.diagonal
        } else {
            self.diagonal * (1.0 - off) / (1.0 - self.diagonal)
        };
        let out = sign * (point.x - self.centre.x);
        if out < -edge * half.0 {
            return 0.0;
        }
        edge * half.0 - out
    }
}

/// A trunk with the arms beside it.
#[derive(Clone, Debug)]
pub(super) struct Flanks {
    offsets: [DVec3; JOINTS],
    trunk: Vec<(Joint, Vec<CrossSection>)>,
    /// The inner points of an arm's rings.
    arms: Vec<(Joint, [DVec3; 3])>,
}

impl Flanks {
    /// Returns the flanks of a body from [`body`](super::body::body), whose hulls are rings from
    /// one end to the other.
    pub(super) fn from_body(body: &Body) -> Self {
        let mut trunk = Vec::new();
        let mut arms = Vec::new();
        for BodyHull { joint, points } in &body.hulls {
            let rings = || points.chunks_exact(RING);
            match joint {
                Joint::Pelvis
                | Joint::Spine
                | Joint::Thorax
                | Joint::LeftThigh
                | Joint::RightThigh => {
                    trunk.push((*joint, rings().map(CrossSection::from_ring).collect()));
                }
                // Above its middle an upper arm is within the shoulder.
                Joint::LeftUpperArm | Joint::RightUpperArm => {
                    arms.extend(inner(*joint, rings().skip(2)));
                }
                // The first ring is within the elbow or the wrist.
                Joint::LeftForearm | Joint::RightForearm | Joint::LeftHand | Joint::RightHand => {
                    arms.extend(inner(*joint, rings().skip(1)));
                }
                _ => {}
            }
        }
        Self {
            offsets: body.offsets,
            trunk,
            arms,
        }
    }

    /// Returns how deep an arm is in the trunk or its thigh, both shrunk by `margin`: how far its
    /// deepest point has to move sideways, metres; 0 if the arm is outside. `upper_arm` is the left
    /// or the right one.
    #[cfg(test)]
    pub(super) fn depth_m(
        &self,
        rotations: &[DQuat; JOINTS],
        upper_arm: Joint,
        margin: f64,
    ) -> f64 {
        let mut most = 0.0f64;
        self.each(rotations, upper_arm, margin, |depth, _| {
            most = most.max(depth);
        });
        most
    }

    /// Returns how much further out the arm has to turn at its shoulder to be no deeper in the
    /// trunk than [`SOFT_TISSUE`], degrees; 0 if it is not deeper.
    ///
    /// Exact for small turns: if the result is more than a few degrees, turn and call again.
    pub(super) fn abduction_deg(&self, rotations: &[DQuat; JOINTS], upper_arm: Joint) -> f64 {
        let mut most = 0.0f64;
        self.each(rotations, upper_arm, SOFT_TISSUE, |depth, lever| {
            most = most.max(libm::atan2(depth, lever));
        });
        most.to_degrees()
    }

    /// Calls `found` for every arm point inside of the trunk shrunk by `margin` with its depth and
    /// its distance below the shoulder along the upper arm, metres.
    fn each(
        &self,
        rotations: &[DQuat; JOINTS],
        upper_arm: Joint,
        margin: f64,
        mut found: impl FnMut(f64, f64),
    ) {
        let (positions, globals) = forward_kinematics(&self.offsets, DVec3::ZERO, rotations);
        let (sign, other_thigh) = match upper_arm {
            Joint::LeftUpperArm => (1.0, Joint::RightThigh),
            _ => (-1.0, Joint::LeftThigh),
        };
        let shoulder = positions[upper_arm.index()];
        let along = -(globals[upper_arm.index()] * DVec3::Y);
        let own = |joint: Joint| {
            std::iter::successors(Some(joint), |joint| joint.parent()).any(|at| at == upper_arm)
        };
        for (joint, points) in self.arms.iter().filter(|(joint, _)| own(*joint)) {
            let points = points.map(|p| positions[joint.index()] + globals[joint.index()] * p);
            for (part, sections) in &self.trunk {
                if *part == other_thigh {
                    continue;
                }
                let back = globals[part.index()].inverse();
                for at in points {
                    let local = back * (at - positions[part.index()]);
                    let depth = depth_m(sections, local, sign, margin);
                    if depth > 0.0 {
                        found(depth, (at - shoulder).dot(along).max(0.05));
                    }
                }
            }
        }
    }
}

/// Returns the inner points of rings, and those halfway from each ring to the next.
fn inner<'a>(joint: Joint, rings: impl Iterator<Item = &'a [DVec3]>) -> Vec<(Joint, [DVec3; 3])> {
    let rings: Vec<[DVec3; 3]> = rings.map(|ring| INNER.map(|at| ring[at])).collect();
    let mut all = rings.clone();
    for pair in rings.windows(2) {
        all.push(std::array::from_fn(|at| pair[0][at].midpoint(pair[1][at])));
    }
    all.into_iter().map(|points| (joint, points)).collect()
}

/// Returns how deep a point is in a stack of sections, metres.
fn depth_m(sections: &[CrossSection], point: DVec3, sign: f64, margin: f64) -> f64 {
    for pair in sections.windows(2) {
        let along = (point.y - pair[0].centre.y) / (pair[1].centre.y - pair[0].centre.y);
        if (0.0..=1.0).contains(&along) {
            return pair[0]
                .between(&pair[1], along)
                .depth_m(point, sign, margin);
        }
    }
    0.0
}

#[cfg(test)]
mod tests {
    use super::super::Person;
    use super::super::rings::{ring, round};
    use super::*;
    use edgegait_core::pack::Sex;

    /// A trunk of 30 by 20 cm (an upright octagonal column) from hips to shoulders, and arms
    /// of 5 cm radius with their axes at 18 cm from the middle; 30 cm from joint to joint.
    fn columns() -> Flanks {
        let mut offsets = [DVec3::ZERO; JOINTS];
        offsets[Joint::Spine.index()].y = 0.1;
        offsets[Joint::Thorax.index()].y = 0.1;
        let mut hulls = Vec::new();
        let mut column = |joint: Joint, points: Vec<DVec3>| {
            hulls.push(BodyHull { joint, points });
        };
        let at = |y: f64| DVec3::new(0.0, y, 0.0);
        let half = (0.15, 0.10);
        let trunk = [ring(at(-0.5), half, 0.75), ring(at(0.4), half, 0.75)];
        column(Joint::Pelvis, trunk.concat());
        for (side, sign) in [
            (
                [Joint::LeftUpperArm, Joint::LeftForearm, Joint::LeftHand],
                1.0,
            ),
            (
                [Joint::RightUpperArm, Joint::RightForearm, Joint::RightHand],
                -1.0,
            ),
        ] {
            let [upper, fore, hand] = side;
            offsets[upper.index()] = DVec3::new(sign * 0.18, 0.2, 0.0);
            offsets[fore.index()].y = -0.3;
            offsets[hand.index()].y = -0.3;
            let rings = |heights: &[f64]| -> Vec<DVec3> {
                let rings = heights.iter().flat_map(|&y| round(at(y), 0.05));
                rings.map(|p| DVec3::new(sign * p.x, p.y, p.z)).collect()
            };
            column(upper, rings(&[0.0, -0.1, -0.15, -0.3]));
            column(fore, rings(&[0.0, -0.1, -0.3]));
            column(hand, rings(&[0.0, -0.05, -0.1]));
        }
        Flanks::from_body(&Body {
            offsets,
            hulls,
            draped: Vec::new(),
            clothes: None,
            fit: None,
        })
    }

    const ARMS: [(Joint, f64); 2] = [(Joint::LeftUpperArm, 1.0), (Joint::RightUpperArm, -1.0)];

    #[test]
    fn an_arm_beside_a_column_is_as_deep_as_their_widths_overlap() {
        // 15 cm of trunk and 18 - 5 cm of arm: 2 cm.
        for (arm, _) in ARMS {
            let depth = columns().depth_m(&[DQuat::IDENTITY; JOINTS], arm, 0.0);
            assert!((depth - 0.02).abs() < 1e-9, "{depth}");
        }
    }

    #[test]
    fn an_arm_that_turns_out_and_one_before_the_trunk_are_outside() {
        for (arm, sign) in ARMS {
            let mut rotations = [DQuat::IDENTITY; JOINTS];
            rotations[arm.index()] = DQuat::from_rotation_z(sign * 0.3);
            assert!(columns().depth_m(&rotations, arm, 0.0) < 1e-9);
            // 15 cm below the shoulder, an arm that points ahead is 15 cm ahead of the middle;
            // the trunk reaches 10.
            rotations[arm.index()] = DQuat::from_rotation_x(-1.57);
            assert!(columns().depth_m(&rotations, arm, 0.0) < 1e-9);
        }
    }

    #[test]
    fn the_abduction_asked_for_leaves_the_soft_tissue() {
        for (arm, sign) in ARMS {
            let flanks = columns();
            let mut rotations = [DQuat::IDENTITY; JOINTS];
            // The middle of the upper arm, 15 cm below the shoulder, needs the most: 8 mm.
            let first = flanks.abduction_deg(&rotations, arm);
            assert!((first - (0.008f64 / 0.15).atan().to_degrees()).abs() < 1e-9);
            let mut turn = 0.0;
            for _ in 0..4 {
                turn += flanks.abduction_deg(&rotations, arm);
                rotations[arm.index()] = DQuat::from_rotation_z(sign * turn.to_radians());
            }
            assert!(flanks.abduction_deg(&rotations, arm) < 0.01);
            let left = flanks.depth_m(&rotations, arm, 0.0);
            assert!((left - SOFT_TISSUE).abs() < 3e-4, "{left}");
        }
    }

    #[test]
    fn an_arm_is_outside_of_the_drawn_in_section_ahead_of_its_front() {
        let flanks = columns();
        let sections = &flanks.trunk[0].1;
        // The octagon's corner: 0.75 of both half axes; halfway from there to the front 0.375.
        let corner = DVec3::new(0.0, 0.0, 0.075);
        assert!((depth_m(sections, corner, 1.0, 0.0) - 0.1125).abs() < 1e-9);
        let nearer = DVec3::new(0.0, 0.0, 0.0875);
        assert!((depth_m(sections, nearer, 1.0, 0.0) - 0.05625).abs() < 1e-9);
        let before = DVec3::new(0.0, 0.0, 0.0885);
        assert!(depth_m(sections, before, 1.0, SOFT_TISSUE) <= 0.0);
        assert!(depth_m(sections, DVec3::new(0.0, 0.41, 0.0), 1.0, 0.0) <= 0.0);
    }

    #[test]
    fn arms_of_heavier_people_have_to_hang_further_out() {
        let needed = |bmi: f64| {
            let d = super::super::Dimensions::expected(
                1.75,
                bmi * 1.75 * 1.75,
                Some(Sex::Male),
                &[0.0; super::super::DIMENSIONS],
            );
            let d = d.expect("a plausible man");
            let flanks = Flanks::from_body(&super::super::body::body(
                &d,
                super::super::body::offsets(&d),
            ));
            let mut rotations = Person::average(Sex::Male).cycle(5.0).rotations[0];
            rotations[Joint::LeftUpperArm.index()] = DQuat::IDENTITY;
            flanks.abduction_deg(&rotations, Joint::LeftUpperArm)
        };
        let (slim, heavy) = (needed(20.0), needed(35.0));
        assert!(heavy > slim + 3.0, "{slim} {heavy}");
    }
}
