//! Where the feet stand below the pelvis, and how high it is over them.

use super::{PersonSteps, SAMPLES, leg_of, mean, own};
use crate::people::cohort::pose::pose;
use crate::people::cohort::steps_and_pelvis::{Beat, PelvisWaves};
use crate::people::cohort::style::Side;
use crate::people::cohort::swing::LEAST_KNEE;
use crate::people::{extent, forward_kinematics};
use edgegait_core::skeleton::Joint;
use glam::DVec3;
use std::f64::consts::PI;

/// Shares of the body's mass, and their heights as a share of the way along the segment (Winter
/// 2009, table 4.1): head, arms and trunk from the hips to the shoulders, both thighs from the
/// hips, and both shanks with their feet from the knees.
const MASSES: [(f64, f64); 3] = [(0.678, 0.626), (0.200, 0.433), (0.122, 0.606)];
/// The mean centre of pressure of a stance from the heel, as a share of the foot's length. It moves
/// from the heel to the toes, and is at about half in mid-stance (recalled: De Cock et al. 2008,
/// Gait & Posture 27:669-675).
const PRESSURE: f64 = 0.52;
/// Rounds in which the height of the pelvis is found, since late heels rise by it.
const ROUNDS: usize = 5;
/// The weight of a body's balance beside the bends of its knees in standing. Our choice.
const BALANCE: f64 = 0.15;

/// A foot on the floor, at one of the samples by which the height of the pelvis is found.
struct Stance {
    side: Side,
    beat: Beat,
    /// The hip relative to the middle of the pelvis, metres.
    hip: DVec3,
    /// The ankle with the heel as low and as high as it may be.
    ankles: [DVec3; 2],
    /// Flexion of the knee, radians.
    knee: f64,
    /// The weight of the sample.
    load: f64,
}

impl PersonSteps<'_> {
    /// Returns how far ahead of the pelvis the feet stand, metres, for the centre of pressure to lie
    /// under the centre of mass on average, as at a constant speed.
    fn balanced(&self) -> f64 {
        let hulls = self.walker.body.hulls.iter();
        let foot = hulls.filter(|hull| hull.joint == Joint::LeftFoot);
        let (heel, toes) = extent(foot.flat_map(|hull| &hull.points).map(|point| point.z));
        let pressure = heel + PRESSURE * (toes - heel);
        let travelled = self.regulated.stride_m() * (0.5 * self.regulated.stance - self.middle());
        self.centre_of_mass() + travelled - pressure
    }

    /// Returns how far ahead of the pelvis the body's mass lies by the angles on average, metres.
    fn centre_of_mass(&self) -> f64 {
        let offsets = &self.walker.body.offsets;
        mean((0..SAMPLES).map(|i| {
            let pose = pose(self.walker.style, self.norm, i as f64 / SAMPLES as f64);
            let (positions, _) = forward_kinematics(offsets, DVec3::ZERO, &pose);
            let of_side = |joint: Joint| {
                0.5 * (positions[joint.index()].z + positions[joint.mirrored().index()].z)
            };
            let [upper_body, thighs, shanks] = MASSES;
            let [hips, knees, ankles] = leg_of(Side::Left).map(of_side);
            let along = |from: f64, to: f64, (mass, share)| mass * (from + share * (to - from));
            along(hips, of_side(Joint::LeftUpperArm), upper_body)
                + along(hips, knees, thighs)
                + along(knees, ankles, shanks)
        }))
    }

    /// Finds how far ahead of the pelvis the feet stand, and how high the pelvis is, so that
    /// standing knees bend by the angles and none is stretched too far.
    ///
    /// The feet stand where the body is in balance, or up to 8 cm before or behind: the error of
    /// standing legs is weighed against [`BALANCE`] of that distance.
    pub(super) fn stand(&mut self) {
        let balanced = self.balanced();
        self.ahead_m = balanced;
        let stances = self.stances();
        let (usual, _) = self.raised_over(&stances, 0.0, PelvisWaves::LEVEL);
        let mut least = f64::MAX;
        for step in -16..=16 {
            let moved = 0.005 * f64::from(step);
            let (pelvis, missed) = self.raised_over(&stances, moved, usual);
            let missed = missed + (BALANCE * moved) * (BALANCE * moved);
            if missed < least {
                least = missed;
                self.pelvis = pelvis;
                self.ahead_m = balanced + moved;
            }
        }
    }

    /// Returns samples of both stances.
    fn stances(&self) -> Vec<Stance> {
        let of = |side| (0..SAMPLES).map(move |i| (side, i as f64 / (SAMPLES - 1) as f64));
        let all = [Side::Left, Side::Right].into_iter().flat_map(of);
        let sample = |(side, share): (Side, f64)| {
            let phase = self.regulated.stance * share;
            let knee = self.knee_deg(side, phase);
            let (low, high) = self.raised(side, phase);
            Stance {
                side,
                beat: self.regulated.beat(own(side, phase)),
                hip: self.intended(side, phase).hip,
                ankles: [low, high].map(|raised| self.planted(side, phase, -raised)),
                knee: knee.to_radians().max(LEAST_KNEE),
                load: libm::sin(PI * phase / self.regulated.stance) + 0.1,
            }
        };
        all.map(sample).collect()
    }

    /// Returns the pelvis's motion with the feet moved ahead by some metres, and its mean square error
    /// against the heights that standing knees need, m2. Hips are as far ahead as `usual` has them.
    fn raised_over(
        &self,
        stances: &[Stance],
        moved: f64,
        usual: PelvisWaves,
    ) -> (PelvisWaves, f64) {
        let ranges = stances.iter().map(|stance| {
            let leg = self.legs[stance.side as usize];
            let root = usual.root(&stance.beat);
            let hip = root.with_y(0.0) + stance.hip;
            let above = |ankle: DVec3, knee: f64| {
                let aside = hip - ankle - moved * DVec3::Z;
                let aside = aside.with_y(0.0).length_squared();
                let reach = leg.reach(knee);
                ankle.y + libm::sqrt((reach * reach - aside).max(0.0)) - hip.y
            };
            let [low, high] = stance.ankles;
            [
                above(low, stance.knee),
                above(high, stance.knee),
                above(high, LEAST_KNEE),
            ]
        });
        let ranges: Vec<[f64; 3]> = ranges.collect();
        let mut wanted: Vec<_> = stances
            .iter()
            .zip(&ranges)
            .map(|(stance, [low, high, _])| (&stance.beat, 0.5 * (low + high), stance.load))
            .collect();
        let mut pelvis = usual;
        for _ in 0..ROUNDS {
            pelvis = PelvisWaves::nearest(&self.regulated, &wanted);
            for (wanted, [low, high, most]) in wanted.iter_mut().zip(&ranges) {
                let height = pelvis.root(wanted.0).y;
                wanted.1 = height.max(*low).min(*high);
                if height > *most {
                    wanted.2 *= 2.0;
                }
            }
        }
        let over = wanted
            .iter()
            .zip(&ranges)
            .map(|((beat, ..), [.., most])| pelvis.root(beat).y - most)
            .fold(0.0, f64::max);
        pelvis.mean_m -= over;
        let missed = wanted
            .iter()
            .map(|&(beat, height, _)| (pelvis.root(beat).y - height).powi(2));
        (pelvis, mean(missed))
    }
}
