//! Measures of a decoded gait cycle in space and time.

use crate::people::cutting::stance::FeetMotion;
use crate::people::{Body, BodyHull, Cycle, extent, forward_kinematics};
use edgegait_core::avatar::Avatar;
use edgegait_core::clip::Loop;
use edgegait_core::skeleton::{JOINTS, Joint};
use glam::{DQuat, DVec3};
use std::f64::consts::TAU;

/// Number of moments at which a cycle is measured.
const FRAMES: usize = 96;

/// A measure of a gait cycle.
///
/// Every measure has one definition for synthetic and recorded people, on joint centres and on the
/// points of the feet's hulls. A foot stands while a point of its sole is nearly still on the
/// floor. Shares of a leg's cycle count from the moment when its ankle is farthest ahead of the
/// pelvis, which recordings show more sharply than a contact: 2 to 3 % of the cycle before it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Measure {
    /// Lateral distance of the two ankle centres, each averaged while its foot stands, cm; negative
    /// where feet cross.
    StepWidth,
    /// Steps a minute.
    Cadence,
    /// Distance from one foot's contact to the next of the same foot, m.
    StrideLength,
    /// Step length over cadence, mm/(steps/min), scaled to a stature of 1.7 m.
    WalkRatio,
    /// Share of the cycle in which both feet stand, %.
    DoubleSupport,
    /// Share of the cycle that a foot stands, %.
    Stance,
    /// Direction of a standing foot against the direction of travel, degrees outwards.
    ToeOut,
    /// The minimum height of the toes between a third and nine tenths of the swing, above the
    /// sole's median height in the stance, cm.
    Clearance,
    /// Range of the height of the hips' middle, cm.
    Bob,
    /// Range of the sideways position of the hips' middle, cm.
    Sway,
    /// Range of the angle between the pelvis and the floor, seen from the front, degrees.
    PelvicObliquity,
    /// Range of the pelvis's rotation about the vertical, degrees.
    PelvicRotation,
    /// Arc of the upper arm seen from the side, degrees.
    ArmSwing,
    /// By how much the upper arm swings later than the thigh of the other side, % of the cycle, by
    /// the first harmonics of their angles.
    ArmLag,
    /// Mean lean of the thorax, degrees forward.
    TrunkLean,
    /// Range of the hip's flexion, degrees.
    HipRange,
    /// Flexion of the knee when the ankle is farthest ahead, degrees.
    KneeAt0,
    /// Flexion of the knee after 30 % of the leg's cycle, degrees.
    KneeAt30,
    /// Flexion of the knee after 40 % of the leg's cycle, degrees.
    KneeAt40,
    /// Flexion of the knee after 80 % of the leg's cycle, degrees.
    KneeAt80,
    /// Flexion of the knee after 90 % of the leg's cycle, degrees.
    KneeAt90,
    /// The greatest flexion of the knee, degrees.
    KneePeak,
    /// Time of the knee's greatest flexion in the second half of the leg's cycle, % of the cycle.
    KneePeakTime,
    /// Share of legs that straighten by more than 3 degrees between the end of their extension in
    /// stance and the peak of their swing, %.
    EarlyDips,
    /// Range of the knee's flexion, degrees.
    KneeRange,
    /// Dorsiflexion of the ankle after 90 % of the leg's cycle, degrees from the rest pose.
    AnkleAt90,
    /// Range of the ankle's flexion, degrees.
    AnkleRange,
    /// Difference of left and right steps over their sum, %.
    Asymmetry,
    /// How far a standing foot slides, mm a stance.
    Slide,
    /// How far a sole goes below the floor, mm.
    Sink,
}

impl Measure {
    /// All measures, in the order of the table.
    pub const ALL: [Self; 30] = [
        Self::StepWidth,
        Self::Cadence,
        Self::StrideLength,
        Self::WalkRatio,
        Self::DoubleSupport,
        Self::Stance,
        Self::ToeOut,
        Self::Clearance,
        Self::Bob,
        Self::Sway,
        Self::PelvicObliquity,
        Self::PelvicRotation,
        Self::ArmSwing,
        Self::ArmLag,
        Self::TrunkLean,
        Self::HipRange,
        Self::KneeAt0,
        Self::KneeAt30,
        Self::KneeAt40,
        Self::KneeAt80,
        Self::KneeAt90,
        Self::KneePeak,
        Self::KneePeakTime,
        Self::KneeRange,
        Self::EarlyDips,
        Self::AnkleAt90,
        Self::AnkleRange,
        Self::Asymmetry,
        Self::Slide,
        Self::Sink,
    ];

    /// Returns the name and unit.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::StepWidth => "step width, cm",
            Self::Cadence => "cadence, steps/min",
            Self::StrideLength => "stride length, m",
            Self::WalkRatio => "walk ratio, mm min, of 1.7 m",
            Self::DoubleSupport => "double support, %",
            Self::Stance => "stance, %",
            Self::ToeOut => "toe-out, degrees",
            Self::Clearance => "toe clearance, cm",
            Self::Bob => "pelvis bob, cm",
            Self::Sway => "pelvis sway, cm",
            Self::PelvicObliquity => "pelvic obliquity, degrees",
            Self::PelvicRotation => "pelvic rotation, degrees",
            Self::ArmSwing => "arm swing, degrees",
            Self::ArmLag => "arm after other leg, %",
            Self::TrunkLean => "trunk lean, degrees",
            Self::HipRange => "hip range, degrees",
            Self::KneeAt0 => "knee at 0 %, degrees",
            Self::KneeAt30 => "knee at 30 %, degrees",
            Self::KneeAt40 => "knee at 40 %, degrees",
            Self::KneeAt80 => "knee at 80 %, degrees",
            Self::KneeAt90 => "knee at 90 %, degrees",
            Self::KneePeak => "knee peak, degrees",
            Self::KneePeakTime => "knee peak at, %",
            Self::KneeRange => "knee range, degrees",
            Self::EarlyDips => "legs that dip before swing, %",
            Self::AnkleAt90 => "ankle at 90 %, degrees",
            Self::AnkleRange => "ankle range, degrees",
            Self::Asymmetry => "step asymmetry, %",
            Self::Slide => "foot slide, mm",
            Self::Sink => "sole below the floor, mm",
        }
    }
}

/// The measures of a cycle, in the order of [`Measure::ALL`].
pub type Measures = [f64; Measure::ALL.len()];

/// A decoded gait cycle on its body.
pub(super) struct Decoded {
    /// The walker's body.
    pub(super) body: Body,
    /// Motion of the body.
    pub(super) cycle: Cycle,
}

impl Decoded {
    /// Decodes a stored cycle on its avatar.
    #[must_use]
    pub(super) fn new(avatar: &Avatar<'_>, clip: &Loop<'_>) -> Self {
        let skeleton = avatar.skeleton();
        let rigid = avatar.hulls().filter(|hull| hull.drape().is_none());
        let hulls = rigid.map(|hull| BodyHull {
            joint: hull.joint(),
            points: hull.points().map(glam::Vec3::as_dvec3).collect(),
        });
        let poses: Vec<_> = (0..FRAMES)
            .map(|frame| clip.pose(frame as f32 / FRAMES as f32))
            .collect();
        let cycle = Cycle {
            period_s: clip.period_s(),
            drift_m: f64::from(clip.drift_m()),
            closure_mm: 0.0,
            root: poses.iter().map(|pose| pose.root.as_dvec3()).collect(),
            rotations: poses
                .iter()
                .map(|pose| pose.rotations.map(|turn| turn.as_dquat().normalize()))
                .collect(),
        };
        Self {
            body: Body {
                offsets: skeleton.offsets.map(glam::Vec3::as_dvec3),
                hulls: hulls.collect(),
                draped: Vec::new(),
                clothes: None,
                fit: None,
            },
            cycle,
        }
    }

    /// Measures the cycle.
    #[must_use]
    pub(super) fn measures(&self) -> Measures {
        let cycle = &self.cycle;
        let steps = FeetMotion::of_cycle(cycle, &self.body.offsets);
        let stands = steps.stances();
        let moments: Vec<MeasuredMoment> = (0..FRAMES).map(|frame| self.moment(frame)).collect();
        let sides = [LEFT, RIGHT];
        let by_frame = &stands;
        let standing = |side: usize| (0..FRAMES).filter(move |&frame| by_frame[frame][side]);
        let mean_of = |side: usize, of: &dyn Fn(&MeasuredMoment) -> f64| {
            mean(standing(side).map(|frame| of(&moments[frame])))
        };
        let range = |of: &dyn Fn(&MeasuredMoment) -> f64| {
            let (low, high) = extent(moments.iter().map(of));
            high - low
        };
        let both = |of: &dyn Fn(usize) -> f64| 0.5 * (of(LEFT) + of(RIGHT));
        let curve =
            |of: &dyn Fn(&MeasuredMoment) -> f64| CycleCurve(moments.iter().map(of).collect());
        let ahead =
            sides.map(|side| curve(&|moment| moment.ankles[side].z - moment.pelvis.z).peak(0.0));
        let [knees, feet] = [
            |moment: &MeasuredMoment| moment.knee_deg,
            |moment: &MeasuredMoment| moment.foot_deg,
        ]
        .map(|angles| sides.map(|side| curve(&|moment| angles(moment)[side]).from(ahead[side])));
        let stance = both(&|side| standing(side).count() as f64 / FRAMES as f64);
        let together = stands.iter().filter(|stands| stands[LEFT] && stands[RIGHT]);
        let stature_m = self.stature();
        let [left, right] = sides.map(|side| self.footprint(&moments, &stands, side));
        let steps_m = {
            let left_step = (left - right).rem_euclid(cycle.drift_m);
            [left_step, cycle.drift_m - left_step]
        };
        let cadence = 120.0 / cycle.period_s;
        let skate = steps
            .skate_on(&self.body)
            .map_or(f64::NAN, |skate| skate.mean_mm);
        let mut measures = [f64::NAN; Measure::ALL.len()];
        for (measure, value) in Measure::ALL.into_iter().zip(&mut measures) {
            *value = match measure {
                Measure::StepWidth => {
                    100.0
                        * (mean_of(LEFT, &|moment| moment.ankles[LEFT].x)
                            - mean_of(RIGHT, &|moment| moment.ankles[RIGHT].x))
                }
                Measure::Cadence => cadence,
                Measure::StrideLength => cycle.drift_m,
                Measure::WalkRatio => 500.0 * cycle.drift_m / cadence * 1.7 / stature_m,
                Measure::DoubleSupport => 100.0 * together.clone().count() as f64 / FRAMES as f64,
                Measure::Stance => 100.0 * stance,
                Measure::ToeOut => both(&|side| mean_of(side, &|moment| moment.toe_out_deg[side])),
                Measure::Clearance => 100.0 * both(&|side| clearance(&moments, &stands, side)),
                Measure::Bob => 100.0 * range(&|moment| moment.pelvis.y),
                Measure::Sway => 100.0 * range(&|moment| moment.pelvis.x),
                Measure::PelvicObliquity => range(&|moment| moment.obliquity_deg),
                Measure::PelvicRotation => range(&|moment| moment.rotation_deg),
                Measure::ArmLag => both(&|side| {
                    let arm = curve(&|moment| moment.arm_deg[side]);
                    arm.lag_behind(&curve(&|moment| moment.hip_deg[1 - side]))
                }),
                Measure::ArmSwing => both(&|side| range(&|moment| moment.arm_deg[side])),
                Measure::TrunkLean => mean(moments.iter().map(|moment| moment.lean_deg)),
                Measure::HipRange => both(&|side| range(&|moment| moment.hip_deg[side])),
                Measure::KneeAt0 => both(&|side| knees[side].at(0.0)),
                Measure::KneeAt30 => both(&|side| knees[side].at(0.3)),
                Measure::KneeAt40 => both(&|side| knees[side].at(0.4)),
                Measure::KneeAt80 => both(&|side| knees[side].at(0.8)),
                Measure::KneeAt90 => both(&|side| knees[side].at(0.9)),
                Measure::KneePeakTime => both(&|side| 100.0 * knees[side].peak(0.5)),
                Measure::EarlyDips => both(&|side| match knees[side].dip() {
                    dip if dip > DIP_DEG => 100.0,
                    _ => 0.0,
                }),
                Measure::AnkleAt90 => both(&|side| feet[side].at(0.9)),
                Measure::KneePeak => {
                    both(&|side| extent(moments.iter().map(|moment| moment.knee_deg[side])).1)
                }
                Measure::KneeRange => both(&|side| range(&|moment| moment.knee_deg[side])),
                Measure::AnkleRange => both(&|side| range(&|moment| moment.foot_deg[side])),
                Measure::Asymmetry => 100.0 * (steps_m[0] - steps_m[1]) / cycle.drift_m,
                Measure::Slide => skate,
                Measure::Sink => {
                    let low = moments
                        .iter()
                        .flat_map(|moment| moment.soles.map(|[sole, _]| sole));
                    -1000.0 * low.fold(f64::MAX, f64::min)
                }
            };
        }
        measures
    }

    /// Returns the height from floor to crown, upright, metres.
    fn stature(&self) -> f64 {
        let rest = [DQuat::IDENTITY; JOINTS];
        let (positions, _) = forward_kinematics(&self.body.offsets, DVec3::ZERO, &rest);
        let heights = self.body.hulls.iter().flat_map(|hull| {
            let at = positions[hull.joint.index()].y;
            hull.points.iter().map(move |point| at + point.y)
        });
        let (low, high) = extent(heights);
        high - low
    }

    /// Returns where a foot stands along the direction of travel, metres, in the ground's frame of
    /// the cycle's first moment.
    fn footprint(&self, moments: &[MeasuredMoment], stands: &[[bool; 2]], side: usize) -> f64 {
        let travelled = |frame: usize| self.cycle.drift_m * frame as f64 / FRAMES as f64;
        // Starts at a frame in the air, so that a stance over the cycle's end is in one piece.
        let start = (0..FRAMES)
            .find(|&frame| !stands[frame][side])
            .unwrap_or_default();
        mean(
            (start..start + FRAMES)
                .filter(|frame| stands[frame % FRAMES][side])
                .map(|frame| moments[frame % FRAMES].ankles[side].z + travelled(frame)),
        )
    }

    /// Returns the measurements of one moment.
    fn moment(&self, frame: usize) -> MeasuredMoment {
        let (root, pose) = (self.cycle.root[frame], &self.cycle.rotations[frame]);
        let (positions, turns) = forward_kinematics(&self.body.offsets, root, pose);
        let legs = [
            [Joint::LeftThigh, Joint::LeftShank, Joint::LeftFoot],
            [Joint::RightThigh, Joint::RightShank, Joint::RightFoot],
        ];
        let arms = [
            [Joint::LeftUpperArm, Joint::LeftForearm],
            [Joint::RightUpperArm, Joint::RightForearm],
        ];
        let flexion = |joint: Joint| {
            let down = pose[joint.index()] * -DVec3::Y;
            libm::atan2(down.z, -down.y).to_degrees()
        };
        let trunk = turns[Joint::Thorax.index()] * DVec3::Y;
        let left = turns[Joint::Pelvis.index()] * DVec3::X;
        MeasuredMoment {
            pelvis: root,
            ankles: legs.map(|[_, _, foot]| positions[foot.index()]),
            soles: legs.map(|[_, _, foot]| {
                let hulls = self.body.hulls.iter().filter(|hull| hull.joint == foot);
                let points = hulls.flat_map(|hull| &hull.points);
                let (_, tip) = extent(points.clone().map(|point| point.z));
                let (at, turn) = (positions[foot.index()], turns[foot.index()]);
                [f64::NEG_INFINITY, tip - TOES_M].map(|from| {
                    let points = points.clone().filter(|point| point.z >= from);
                    let heights = points.map(|&point| (at + turn * point).y);
                    heights.fold(f64::MAX, f64::min)
                })
            }),
            toe_out_deg: [(0, 1.0), (1, -1.0)].map(|(side, sign)| {
                let ahead = turns[legs[side][2].index()] * DVec3::Z;
                libm::atan2(sign * ahead.x, ahead.z).to_degrees()
            }),
            arm_deg: arms.map(|[upper, fore]| {
                let down = positions[fore.index()] - positions[upper.index()];
                libm::atan2(down.z, -down.y).to_degrees()
            }),
            obliquity_deg: libm::asin(left.y).to_degrees(),
            rotation_deg: libm::atan2(-left.z, left.x).to_degrees(),
            lean_deg: libm::atan2(trunk.z, trunk.y).to_degrees(),
            hip_deg: legs.map(|[thigh, ..]| flexion(thigh)),
            knee_deg: legs.map(|[_, shank, _]| -flexion(shank)),
            foot_deg: legs.map(|[_, _, foot]| flexion(foot)),
        }
    }
}

/// The length of the foremost part of a foot that counts as its toes, metres. Our choice.
const TOES_M: f64 = 0.05;

/// Index of the left side.
const LEFT: usize = 0;
/// Index of the right side.
const RIGHT: usize = 1;

/// The measurements of one moment; the left side comes first in pairs.
struct MeasuredMoment {
    pelvis: DVec3,
    ankles: [DVec3; 2],
    /// Height of the lowest point of each foot and of its toes, metres.
    soles: [[f64; 2]; 2],
    toe_out_deg: [f64; 2],
    /// Direction from shoulder to elbow seen from the side, 0 straight down.
    arm_deg: [f64; 2],
    /// Height of the pelvis's left over its right, 0 level.
    obliquity_deg: f64,
    /// Heading of the pelvis, 0 in the direction of travel.
    rotation_deg: f64,
    lean_deg: f64,
    hip_deg: [f64; 2],
    knee_deg: [f64; 2],
    foot_deg: [f64; 2],
}

/// Straightening of a knee before its swing that counts as a dip, degrees. Our choice: twice what a
/// curve differs by from stride to stride.
const DIP_DEG: f64 = 3.0;

/// Share of a leg's cycle from which the end of the knee's extension in stance is looked for: after
/// the peak of loading, and before the extension ends in norms (39 to 43 %, Schwartz 2008).
const EXTENDS: f64 = 0.35;

/// Values over a cycle, at each of its moments.
struct CycleCurve(Vec<f64>);

impl CycleCurve {
    /// Returns the value at a share of the cycle, between two moments by interpolation.
    fn at(&self, share: f64) -> f64 {
        let at = share.rem_euclid(1.0) * FRAMES as f64;
        let (low, t) = (at as usize % FRAMES, at.fract());
        self.0[low] * (1.0 - t) + self.0[(low + 1) % FRAMES] * t
    }

    /// Returns the curve that begins at a share of this one's cycle.
    fn from(&self, share: f64) -> Self {
        Self(
            (0..FRAMES)
                .map(|frame| self.at(share + frame as f64 / FRAMES as f64))
                .collect(),
        )
    }

    /// Returns the share of the cycle at which the curve is greatest, from the share `first` on, by
    /// a parabola.
    fn peak(&self, first: f64) -> f64 {
        let first = (first * FRAMES as f64) as usize;
        let top = (first..FRAMES).max_by(|&a, &b| self.0[a].total_cmp(&self.0[b]));
        let top = top.unwrap_or_default();
        let [before, most, after] = [FRAMES - 1, 0, 1].map(|by| self.0[(top + by) % FRAMES]);
        let bend = before - 2.0 * most + after;
        let beside = if bend < 0.0 {
            0.5 * (before - after) / bend
        } else {
            0.0
        };
        (top as f64 + beside) / FRAMES as f64
    }

    /// Returns by how much the curve falls between its first low after [`EXTENDS`] and its peak in
    /// the second half of the cycle.
    fn dip(&self) -> f64 {
        let last = ((self.peak(0.5) * FRAMES as f64) as usize).min(FRAMES - 1);
        let rises = |frame: &usize| self.0[frame + 1] > self.0[*frame];
        let first = ((EXTENDS * FRAMES as f64) as usize..last)
            .find(rises)
            .unwrap_or(last);
        let (mut most, mut dip) = (f64::MIN, 0.0f64);
        for value in &self.0[first..=last] {
            most = most.max(*value);
            dip = dip.max(most - value);
        }
        dip
    }

    /// Returns by how much later the first harmonic of this curve peaks than that of another, % of
    /// the cycle, from -50 to 50.
    fn lag_behind(&self, other: &Self) -> f64 {
        let phase = |curve: &Self| {
            let sum = |wave: fn(f64) -> f64| -> f64 {
                let waves = (0..FRAMES).map(|frame| wave(TAU * frame as f64 / FRAMES as f64));
                waves.zip(&curve.0).map(|(wave, value)| wave * value).sum()
            };
            libm::atan2(sum(libm::sin), sum(libm::cos)) / TAU
        };
        let later = phase(self) - phase(other);
        100.0 * (later - later.round())
    }
}

/// Returns the least height of the toes between a third and nine tenths of their swing, metres,
/// above the sole's median while it stands.
fn clearance(moments: &[MeasuredMoment], stands: &[[bool; 2]], side: usize) -> f64 {
    let lands = (0..FRAMES)
        .find(|&frame| stands[(frame + 1) % FRAMES][side] && !stands[frame][side])
        .unwrap_or_default();
    let swing = (0..FRAMES)
        .take_while(|back| !stands[(lands + FRAMES - back) % FRAMES][side])
        .count();
    let heights = |frame: usize| moments[frame % FRAMES].soles[side];
    let mut standing: Vec<f64> = (0..FRAMES)
        .filter(|&frame| stands[frame][side])
        .map(|frame| heights(frame)[0])
        .collect();
    standing.sort_by(f64::total_cmp);
    let floor = standing.get(standing.len() / 2).copied();
    let (from, to) = (swing / 10, swing * 2 / 3);
    let least = (from..=to)
        .map(|back| heights(lands + FRAMES - back)[1])
        .fold(f64::MAX, f64::min);
    least - floor.unwrap_or(f64::NAN)
}

/// Returns the mean of some values.
fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), value| (sum + value, count + 1.0));
    sum / count
}
