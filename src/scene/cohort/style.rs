//! How one person deviates from the norm, the same at every speed.

use rand::Rng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// Angles of the norms, in the order of [`Style`]'s table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Angle {
    /// Pelvis, anterior.
    PelvicTilt,
    /// Pelvis, same side up.
    PelvicObliquity,
    /// Pelvis, same side forward.
    PelvicRotation,
    /// Hip flexion.
    HipFlexion,
    /// Hip adduction.
    HipAdduction,
    /// Hip internal rotation.
    HipRotation,
    /// Knee flexion.
    KneeFlexion,
    /// Ankle dorsiflexion.
    AnkleDorsiflexion,
    /// Foot internal progression.
    FootProgression,
    /// Thorax, leaning forward.
    ThoraxTilt,
    /// Thorax, same side up.
    ThoraxObliquity,
    /// Thorax, same side forward.
    ThoraxRotation,
    /// Shoulder flexion.
    ShoulderFlexion,
    /// Shoulder abduction.
    ShoulderAbduction,
    /// Elbow flexion.
    ElbowFlexion,
}

/// How many angles there are.
const ANGLES: usize = 15;

/// A side of the body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Side {
    /// The left side.
    Left,
    /// The right side.
    Right,
}

/// One person's deviation in one angle on one side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct AngleStyle {
    /// Added to the mean, in standard deviations of the norm.
    pub offset_sd: f64,
    /// Added to the mean, degrees: the asymmetry of the two sides.
    pub offset_deg: f64,
    /// Factor of the swing.
    pub amplitude: f64,
    /// Delay, cycles.
    pub phase: f64,
}

impl AngleStyle {
    const NONE: Self = Self {
        offset_sd: 0.0,
        offset_deg: 0.0,
        amplitude: 1.0,
        phase: 0.0,
    };
}

/// One person's deviations from the norm.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Style {
    angles: [[AngleStyle; 2]; ANGLES],
    /// Step length against others of the same stature, in standard deviations.
    pub step_length: f64,
}

impl Style {
    /// The norm itself.
    pub(crate) const NONE: Self = Self {
        angles: [[AngleStyle::NONE; 2]; ANGLES],
        step_length: 0.0,
    };

    /// A person drawn at random.
    ///
    /// Each angle's mean deviates by 0.8 of the norm's spread between people (the rest
    /// of that spread is the repeatability of markers), its swing by 8 % and its timing by
    /// 1.5 % of the cycle; sides differ by 1.5 degrees. These four numbers are ours, recalled from normative studies and
    /// chosen so that spreads between people are about three times those within.
    #[must_use]
    pub(crate) fn random(rng: &mut ChaCha8Rng) -> Self {
        let mut style = Self::NONE;
        for angles in &mut style.angles {
            let shared = AngleStyle {
                offset_sd: 0.8 * normal(rng),
                offset_deg: 0.0,
                amplitude: 1.0 + 0.08 * normal(rng),
                phase: 0.015 * normal(rng),
            };
            let asymmetry = 1.5 * normal(rng);
            for (own, sign) in angles.iter_mut().zip([0.5, -0.5]) {
                *own = AngleStyle {
                    offset_deg: sign * asymmetry,
                    ..shared
                };
            }
        }
        // Hip flexion's own share: what pelvic tilt and knee leave of its spread,
        // sqrt(6.1^2 - 4.9^2 - (6.3 / 2)^2) of 6.1 degrees. A quarter of the others': the
        // published spread of hip rotation (9.5 degrees) is mostly the cross-talk of knee
        // axes, and a pelvis is neither askew nor turned on average.
        for (angle, share) in [
            (Angle::HipFlexion, 0.3),
            (Angle::HipRotation, 0.25),
            (Angle::PelvicObliquity, 0.25),
            (Angle::PelvicRotation, 0.25),
            (Angle::ThoraxObliquity, 0.25),
            (Angle::ThoraxRotation, 0.25),
        ] {
            for own in &mut style.angles[angle as usize] {
                own.offset_sd *= share;
            }
        }
        style.step_length = normal(rng);
        style
    }

    /// The deviation in one angle.
    #[must_use]
    pub(crate) const fn of(&self, angle: Angle, side: Side) -> &AngleStyle {
        &self.angles[angle as usize][side as usize]
    }
}

/// A standard normal number, drawn again beyond 2.5 so that nobody is a monster.
pub fn normal(rng: &mut impl Rng) -> f64 {
    loop {
        let value: f64 = StandardNormal.sample(rng);
        if value.abs() <= 2.5 {
            return value;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;

    #[test]
    fn a_seed_is_a_person() {
        let style = |seed| Style::random(&mut ChaCha8Rng::seed_from_u64(seed));
        assert_eq!(style(1), style(1));
        assert_ne!(style(1), style(2));
    }

    #[test]
    fn people_spread_around_the_norm_as_stated() {
        let mut rng = ChaCha8Rng::seed_from_u64(7);
        let people: Vec<Style> = (0..2_000).map(|_| Style::random(&mut rng)).collect();
        let deviation = |of: &dyn Fn(&Style) -> f64| {
            let values: Vec<f64> = people.iter().map(of).collect();
            let mean = values.iter().sum::<f64>() / 2_000.0;
            (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / 2_000.0).sqrt()
        };
        // Drawing again beyond 2.5 takes 4 % off the standard deviation.
        let knee = deviation(&|s| s.of(Angle::KneeFlexion, Side::Left).offset_sd);
        assert!((knee - 0.77).abs() < 0.03, "{knee}");
        let amplitude = deviation(&|s| s.of(Angle::ElbowFlexion, Side::Left).amplitude);
        assert!((amplitude - 0.077).abs() < 0.004, "{amplitude}");
        let sides = deviation(&|s| {
            s.of(Angle::HipFlexion, Side::Left).offset_deg
                - s.of(Angle::HipFlexion, Side::Right).offset_deg
        });
        assert!((sides - 1.44).abs() < 0.08, "{sides}");
    }
}
