//! The norm's angles at one speed: interpolated between published walking speeds, and scaled from
//! one running speed.

use super::anthropometry::Dimensions;
use super::norms::{
    Angle, AngleCurve, ELBOW_FLEXION, GRAVITY, PELVIC_OBLIQUITY, PELVIC_ROTATION, RUNNING,
    SHOULDER_ABDUCTION, SHOULDER_FLEXION, THORAX_OBLIQUITY, THORAX_ROTATION, THORAX_TILT, WALKING,
    WalkingNorm, Waves,
};
use edgegait_core::pack::Gait;

/// Speed from which people run, km/h: the source paper's switch between 7 and 8.
const RUNNING_FROM_KMH: f64 = 7.5;

/// Returns whether a person walks or runs at this speed.
#[must_use]
pub(super) fn gait_at(speed_kmh: f64) -> Gait {
    if speed_kmh < RUNNING_FROM_KMH {
        Gait::Walk
    } else {
        Gait::Run
    }
}

/// By how much arms hang nearer to the trunk than in the norm, degrees. Our choice: from the front,
/// people of the norm are wider at the arms than recorded people.
const NEARER_ARMS_DEG: f64 = 4.5;

/// Index in [`WALKING`] of the speed that people choose.
const SPONTANEOUS: usize = 2;

/// The angles' curves at one speed, with legs that stand for a time of their own.
pub(super) struct AngleNorm {
    curves: Curves,
    /// Shares of the cycle that a foot is on the floor, of the curves and of the person.
    stances: [f64; 2],
}

/// The angles' curves at one speed.
enum Curves {
    /// Between two of the published walking speeds.
    Walk {
        slower: &'static WalkingNorm,
        faster: &'static WalkingNorm,
        /// Weight of the faster speed.
        share: f64,
        /// Arm swing as a factor of the swing at spontaneous speed.
        arms: f64,
    },
    /// Running, scaled from 3 m/s.
    Run {
        /// Factor of the hip's swing.
        hip: f64,
        /// Factor of the knee's swing.
        knee: f64,
        /// Factor of the ankle's swing.
        ankle: f64,
    },
}

impl AngleNorm {
    /// Returns the norm for a person of these dimensions at this speed.
    pub(super) fn at(dimensions: &Dimensions, speed_kmh: f64) -> Self {
        Self {
            curves: Curves::at(dimensions, speed_kmh),
            stances: [0.5; 2],
        }
    }

    /// Returns the norm with legs that stand for the person's `own` share of the cycle, instead of
    /// for the `usual` one at this speed.
    pub(super) fn with_stance(self, usual: f64, own: f64) -> Self {
        Self {
            stances: [usual, own],
            ..self
        }
    }

    /// Returns an angle of the norm: mean, and swing at `phase`, degrees. A leg's stance and swing
    /// are as long as the person's.
    pub(super) fn angle(&self, angle: Angle, phase: f64) -> (f64, f64) {
        let phase = match angle {
            Angle::HipFlexion | Angle::KneeFlexion | Angle::AnkleDorsiflexion => {
                let [usual, own] = self.stances;
                let share = phase - libm::floor(phase);
                if share < own {
                    share * usual / own
                } else {
                    1.0 - (1.0 - share) * (1.0 - usual) / (1.0 - own)
                }
            }
            _ => phase,
        };
        let (mean, swing, _) = self.curves.numbers(angle, Some(phase));
        (mean, swing)
    }

    /// Returns the spread of an angle of the norm, degrees.
    pub(super) fn spread_deg(&self, angle: Angle) -> f64 {
        self.curves.numbers(angle, None).2
    }
}

impl Curves {
    fn at(dimensions: &Dimensions, speed_kmh: f64) -> Self {
        if gait_at(speed_kmh) == Gait::Run {
            // 8 to 12 km/h: swing knee 85 to 105 degrees, hip peak 49 to 58 (recorded: RUNNING's
            // cycles), ankle at toe-off -18 to -25 (recalled), against 3 m/s, which is 10.8 km/h.
            let share = (speed_kmh - 8.0) / 4.0;
            return Self::Run {
                hip: (49.0 + 9.0 * share) / 54.0,
                knee: (85.0 + 20.0 * share) / 97.0,
                ankle: (18.0 + 7.0 * share) / 22.9,
            };
        }
        let leg_m = dimensions.trochanterion_height;
        let speed = speed_kmh / 3.6 / libm::sqrt(GRAVITY * leg_m);
        let last = WALKING.len() - 2;
        let below = WALKING
            .windows(2)
            .position(|pair| speed < pair[1].speed)
            .unwrap_or(last);
        let (slower, faster) = (&WALKING[below], &WALKING[below + 1]);
        let share = (speed - slower.speed) / (faster.speed - slower.speed);
        Self::Walk {
            slower,
            faster,
            share: share.clamp(0.0, 1.2),
            // Arm swing grows with speed: 0.6 at 3 km/h, 1.4 at 7 (recalled).
            arms: 1.0 + 0.2 * (speed_kmh - 5.0),
        }
    }

    /// Returns mean, swing at a phase if one is given, and spread, degrees.
    fn numbers(&self, angle: Angle, phase: Option<f64>) -> (f64, f64, f64) {
        let waves = phase.map(Waves::at);
        let swing = |curve: &AngleCurve| waves.as_ref().map_or(0.0, |waves| curve.swing(waves));
        let plain = |curve: &AngleCurve| (curve.mean, swing(curve), curve.sd);
        let scaled = |curve: &AngleCurve, by: f64| (curve.mean, by * swing(curve), curve.sd);
        let hanging = |(mean, swing, sd): (f64, f64, f64)| (mean - NEARER_ARMS_DEG, swing, sd);
        match self {
            Self::Walk {
                slower,
                faster,
                share,
                arms,
            } => {
                let between = |of: fn(&'static WalkingNorm) -> &'static AngleCurve| {
                    let (a, b) = (plain(of(slower)), plain(of(faster)));
                    let mix = |a: f64, b: f64| a + share * (b - a);
                    (mix(a.0, b.0), mix(a.1, b.1), mix(a.2, b.2))
                };
                // Adults' pelves turn more than children's, and later. This is the adults' curve at
                // their own speed, which grows with speed like the children's, no further than to theirs.
                let grown =
                    |adult: &AngleCurve, of: fn(&'static WalkingNorm) -> &'static AngleCurve| {
                        let size =
                            of(slower).size() + share * (of(faster).size() - of(slower).size());
                        let own = size / of(&WALKING[SPONTANEOUS]).size();
                        scaled(adult, own.min((size / adult.size()).max(1.0)))
                    };
                // Adults' pelves tip by 13 degrees in one laboratory, and by 6 to 9 and earlier in
                // four others. This is the mean of the adults' curve and the children's.
                let tipped =
                    |adult: &AngleCurve, of: fn(&'static WalkingNorm) -> &'static AngleCurve| {
                        let (child, adult) = (between(of), plain(adult));
                        (0.0, 0.5 * (child.1 + adult.1), adult.2)
                    };
                match angle {
                    Angle::PelvicTilt => between(|n| &n.pelvic_tilt),
                    Angle::PelvicObliquity => tipped(&PELVIC_OBLIQUITY, |n| &n.pelvic_obliquity),
                    Angle::PelvicRotation => grown(&PELVIC_ROTATION, |n| &n.pelvic_rotation),
                    Angle::HipFlexion => between(|n| &n.hip_flexion),
                    Angle::HipAdduction => between(|n| &n.hip_adduction),
                    Angle::HipRotation => between(|n| &n.hip_rotation),
                    Angle::KneeFlexion => between(|n| &n.knee_flexion),
                    Angle::AnkleDorsiflexion => between(|n| &n.ankle_dorsiflexion),
                    Angle::FootProgression => between(|n| &n.foot_progression),
                    // Recorded walkers of four data sets lean 2 to 4 degrees further forwards than
                    // the norm's 0.9; those of two others do not.
                    Angle::ThoraxTilt => {
                        let (mean, swing, sd) = plain(&THORAX_TILT);
                        (mean + 2.0, swing, sd)
                    }
                    Angle::ThoraxObliquity => plain(&THORAX_OBLIQUITY),
                    Angle::ThoraxRotation => plain(&THORAX_ROTATION),
                    Angle::ShoulderFlexion => scaled(&SHOULDER_FLEXION, *arms),
                    Angle::ShoulderAbduction => hanging(scaled(&SHOULDER_ABDUCTION, *arms)),
                    Angle::ElbowFlexion => scaled(&ELBOW_FLEXION, *arms),
                }
            }
            Self::Run { hip, knee, ankle } => match angle {
                Angle::PelvicTilt => plain(&RUNNING.pelvic_tilt),
                Angle::PelvicObliquity => plain(&RUNNING.pelvic_obliquity),
                Angle::PelvicRotation => plain(&RUNNING.pelvic_rotation),
                Angle::HipFlexion => scaled(&RUNNING.hip_flexion, *hip),
                Angle::KneeFlexion => scaled(&RUNNING.knee_flexion, *knee),
                Angle::AnkleDorsiflexion => scaled(&RUNNING.ankle_dorsiflexion, *ankle),
                // Frontal and transverse angles as in very fast walking. Our choice: the
                // one published trial at hand has 20 degrees of cross-talk in them.
                Angle::HipAdduction => plain(&WALKING[4].hip_adduction),
                Angle::HipRotation => plain(&WALKING[4].hip_rotation),
                Angle::FootProgression => plain(&WALKING[4].foot_progression),
                // A lean of 6 degrees (Teng & Powers 2015, Med. Sci. Sports Exerc. 47:625-630: 7.2
                // at 3.4 m/s) and a counter-turn of about 8 (recalled).
                Angle::ThoraxTilt => (6.0, swing(&THORAX_TILT), THORAX_TILT.sd),
                Angle::ThoraxObliquity => plain(&THORAX_OBLIQUITY),
                Angle::ThoraxRotation => scaled(&THORAX_ROTATION, 4.0),
                Angle::ShoulderFlexion => plain(&RUNNING.shoulder_flexion),
                Angle::ShoulderAbduction => hanging(plain(&SHOULDER_ABDUCTION)),
                Angle::ElbowFlexion => plain(&RUNNING.elbow_flexion),
            },
        }
    }
}
