//! One person's deviations from the norm, the same at every speed.

use super::covariation::{FACTORS, FEATURES, Feature, LOADINGS, ORDER};
use super::norms::Angle;
use rand::Rng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// Number of angles.
const ANGLES: usize = Angle::ALL.len();

/// A side of the body.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
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
///
/// Values without a unit are in standard deviations between people.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Style {
    angles: [[AngleStyle; 2]; ANGLES],
    /// Step length against others of the same stature.
    pub step_length: f64,
    /// Step width.
    pub step_width: f64,
    /// Share of stance.
    pub stance: f64,
    /// Rise and fall of the pelvis.
    pub bob: f64,
    /// Sway of the pelvis.
    pub sway: f64,
    /// Clearance of the swinging foot.
    pub clearance: f64,
    /// How much longer left steps are than right ones.
    pub asymmetry: f64,
    /// How far the head is bowed, degrees.
    pub head_pitch_deg: f64,
    /// How far the plane in which the elbows bend is turned inwards, degrees.
    pub elbow_plane_deg: f64,
}

impl Style {
    /// The norm itself.
    pub(crate) const NONE: Self = Self {
        angles: [[AngleStyle::NONE; 2]; ANGLES],
        step_length: 0.0,
        step_width: 0.0,
        stance: 0.0,
        bob: 0.0,
        sway: 0.0,
        clearance: 0.0,
        asymmetry: 0.0,
        head_pitch_deg: 0.0,
        elbow_plane_deg: ELBOW_PLANE_DEG,
    };

    /// Draws a person at random. Features correlate like those of recorded people, with published
    /// spreads where there are any.
    #[must_use]
    pub(crate) fn random(rng: &mut ChaCha8Rng) -> Self {
        let mut style = Self::NONE;
        // Features that the recordings do not cover are drawn independently.
        for (angle, sides) in Angle::ALL.into_iter().zip(&mut style.angles) {
            let spread = AngleSpread::for_angle(angle);
            let offset_sd = spread.offset_sd * normal(rng);
            let amplitude = libm::exp(spread.amplitude * normal(rng));
            let phase = spread.delay * normal(rng);
            let asymmetry = spread.asymmetry_deg * normal(rng);
            for (own, sign) in sides.iter_mut().zip([1.0, -1.0]) {
                *own = AngleStyle {
                    offset_sd,
                    offset_deg: sign * asymmetry,
                    amplitude,
                    phase,
                };
            }
        }
        style.stance = normal(rng);
        style.asymmetry = normal(rng);
        style.elbow_plane_deg = ELBOW_PLANE_DEG + ELBOW_PLANE_SD_DEG * normal(rng);
        for (feature, score) in ORDER.into_iter().zip(scores(rng)) {
            style.set(feature, score);
        }
        style
    }

    /// Returns the person on another day. `rngs` draw what the person's days have in common beside
    /// this one, and the day itself. Any two days correlate in each feature by [`RELIABILITY`], and
    /// people differ on each by as much as on the first.
    #[must_use]
    pub(crate) fn on_another_day(&self, rngs: [&mut ChaCha8Rng; 2]) -> Self {
        // A day is the person and a deviation. What one day tells of the person is a mean of
        // RELIABILITY times the day, with a variance of RELIABILITY (1 - RELIABILITY).
        let own = RELIABILITY;
        let [usual, new] = [own * (1.0 - own), 1.0 - own].map(libm::sqrt);
        let [person, day] = rngs.map(Self::random);
        let sum = |sd: f64, of: &dyn Fn(&Self) -> f64| {
            let sum = own * of(self) + usual * of(&person) + new * of(&day);
            sum.clamp(-MOST * sd, MOST * sd)
        };
        let mut style = Self {
            step_length: sum(1.0, &|style| style.step_length),
            step_width: sum(1.0, &|style| style.step_width),
            stance: sum(1.0, &|style| style.stance),
            bob: sum(1.0, &|style| style.bob),
            sway: sum(1.0, &|style| style.sway),
            clearance: sum(1.0, &|style| style.clearance),
            asymmetry: sum(1.0, &|style| style.asymmetry),
            head_pitch_deg: sum(HEAD_PITCH_DEG, &|style| style.head_pitch_deg),
            elbow_plane_deg: ELBOW_PLANE_DEG
                + sum(ELBOW_PLANE_SD_DEG, &|style| {
                    style.elbow_plane_deg - ELBOW_PLANE_DEG
                }),
            ..Self::NONE
        };
        for angle in Angle::ALL {
            let spread = AngleSpread::for_angle(angle);
            for side in [Side::Left, Side::Right] {
                let of = |sd: f64, of: fn(&AngleStyle) -> f64| {
                    sum(sd, &|style| of(style.angle(angle, side)))
                };
                *style.of_mut(angle, side) = AngleStyle {
                    offset_sd: of(spread.offset_sd, |own| own.offset_sd),
                    offset_deg: of(spread.asymmetry_deg, |own| own.offset_deg),
                    amplitude: libm::exp(of(spread.amplitude, |own| libm::log(own.amplitude))),
                    phase: of(spread.delay, |own| own.phase),
                };
            }
        }
        style
    }

    /// Sets a feature, in standard deviations between people.
    fn set(&mut self, feature: Feature, score: f64) {
        let (angle, set): (Angle, fn(&mut AngleStyle, AngleSpread, f64)) = match feature {
            Feature::Offset(angle) => (angle, |own, spread, score| {
                own.offset_sd = spread.offset_sd * score;
            }),
            Feature::Amplitude(angle) => (angle, |own, spread, score| {
                own.amplitude = libm::exp(spread.amplitude * score);
            }),
            Feature::Delay(angle) => (angle, |own, spread, score| own.phase = spread.delay * score),
            Feature::StepWidth => return self.step_width = score,
            Feature::WalkRatio => return self.step_length = score,
            Feature::Bob => return self.bob = score,
            Feature::Sway => return self.sway = score,
            Feature::Clearance => return self.clearance = score,
            Feature::HeadPitch => return self.head_pitch_deg = HEAD_PITCH_DEG * score,
        };
        for own in &mut self.angles[angle as usize] {
            set(own, AngleSpread::for_angle(angle), score);
        }
    }

    /// Returns the deviation in one angle, to change it.
    pub(crate) const fn of_mut(&mut self, angle: Angle, side: Side) -> &mut AngleStyle {
        &mut self.angles[angle as usize][side as usize]
    }

    /// Returns the deviation in one angle.
    #[must_use]
    pub(crate) const fn angle(&self, angle: Angle, side: Side) -> &AngleStyle {
        &self.angles[angle as usize][side as usize]
    }
}

/// How far the plane in which elbows bend is turned inwards on average, degrees: between the means
/// of four data sets of recorded walkers, -11, 3, 4 and 6.
const ELBOW_PLANE_DEG: f64 = 3.0;
/// Standard deviations between people of the elbows' plane and of the head's bow, degrees.
const ELBOW_PLANE_SD_DEG: f64 = 9.0;
const HEAD_PITCH_DEG: f64 = 7.0;

/// The correlation of a feature on two days, with as many days between as in studies of repeated
/// measurements (mostly a week). Intraclass correlations: step length, cadence and stance 0.92 or
/// more, base of support 0.80 (van Uden & Besser 2004, BMC Musculoskelet. Disord. 5:13, recalled);
/// angles of legs and pelvis mostly 0.8 or more (McGinley et al. 2009, Gait & Posture 29:360-369,
/// recalled), less than the walkers' own since markers are placed anew.
const RELIABILITY: f64 = 0.86;

/// Standard deviations between people in one angle.
#[derive(Clone, Copy, Debug)]
struct AngleSpread {
    /// Spread of the mean, as a share of the norm's spread: 1 for pelvic tilt, and for others the
    /// share that 10 walkers of CMU's motion capture and 20 of other sets have, since the norm's
    /// spread includes the repeatability of markers, and children.
    offset_sd: f64,
    /// Spread of the logarithm of the swing. The norms have none, so it is the recorded spread
    /// (`SPREADS`). Arms have three quarters of it and delays of the trunk two thirds, since data
    /// sets differ in how these were captured.
    amplitude: f64,
    /// Spread of the delay, cycles, from the same source.
    delay: f64,
    /// Spread of half the difference of both sides, degrees: as recorded, for feet two thirds of
    /// it.
    asymmetry_deg: f64,
}

impl AngleSpread {
    const fn for_angle(angle: Angle) -> Self {
        let (offset_sd, amplitude, delay, asymmetry_deg) = match angle {
            Angle::PelvicTilt => (1.0, 0.35, 0.03, 0.0),
            // On average a pelvis is neither askew nor turned, and a thorax hardly.
            Angle::PelvicObliquity | Angle::PelvicRotation => (0.2, 0.26, 0.04, 0.0),
            // The hip's spread without the effect of pelvic tilt and knee.
            Angle::HipFlexion => (0.3, 0.08, 0.012, 1.2),
            Angle::HipAdduction => (0.7, 0.27, 0.025, 1.5),
            // Its published spread (9.5 degrees) is mostly the cross-talk of knee axes.
            Angle::HipRotation => (0.4, 0.2, 0.012, 1.0),
            Angle::KneeFlexion => (0.42, 0.08, 0.009, 1.2),
            Angle::AnkleDorsiflexion => (0.85, 0.22, 0.014, 1.5),
            Angle::FootProgression => (0.75, 0.1, 0.012, 2.5),
            Angle::ThoraxTilt => (0.9, 0.33, 0.03, 0.0),
            Angle::ThoraxObliquity => (0.6, 0.5, 0.03, 0.0),
            Angle::ThoraxRotation => (0.6, 0.36, 0.06, 0.0),
            Angle::ShoulderFlexion => (0.8, 0.3, 0.036, 2.3),
            Angle::ShoulderAbduction => (0.6, 0.25, 0.03, 1.6),
            Angle::ElbowFlexion => (0.8, 0.38, 0.036, 3.3),
        };
        Self {
            offset_sd,
            amplitude,
            delay,
            asymmetry_deg,
        }
    }
}

/// Draws standard scores of the features, which correlate like those of recorded people. None is
/// beyond 2.5, like the numbers of which it is a sum.
fn scores(rng: &mut ChaCha8Rng) -> [f64; FEATURES] {
    let factors: [f64; FACTORS] = std::array::from_fn(|_| normal(rng));
    LOADINGS.map(|loadings| {
        let (common, shared) =
            loadings
                .iter()
                .zip(factors)
                .fold((0.0, 0.0), |(sum, squares), (loading, factor)| {
                    (sum + loading * factor, squares + loading * loading)
                });
        (common + libm::sqrt(1.0 - shared) * normal(rng)).clamp(-MOST, MOST)
    })
}

/// The largest standard score of a person. Our choice: no person is extreme.
const MOST: f64 = 2.5;

/// Draws a standard normal number, again if it is beyond 2.5.
pub fn normal(rng: &mut impl Rng) -> f64 {
    loop {
        let value: f64 = StandardNormal.sample(rng);
        if value.abs() <= MOST {
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
    fn days_of_a_person_agree_as_stated_and_spread_like_people() {
        let features = |style: &Style| {
            let knee = style.angle(Angle::KneeFlexion, Side::Left);
            let elbow = style.angle(Angle::ElbowFlexion, Side::Right);
            [
                style.step_width,
                style.step_length,
                knee.offset_sd,
                elbow.amplitude.ln(),
                elbow.phase,
                elbow.offset_deg,
                style.head_pitch_deg,
                style.elbow_plane_deg,
            ]
        };
        let people: Vec<[[f64; 8]; 3]> = (0..4_000)
            .map(|number| {
                // The person's first day, what the days have in common, and two further days.
                let [mut first, common, second, third] = [0, 1, 2, 3].map(|stream| {
                    let mut rng = ChaCha8Rng::seed_from_u64(8);
                    rng.set_stream(4 * number + stream);
                    rng
                });
                let person = Style::random(&mut first);
                let days = [second, third]
                    .map(|mut day| person.on_another_day([&mut common.clone(), &mut day]));
                [&person, &days[0], &days[1]].map(features)
            })
            .collect();
        for feature in 0..8 {
            let day = |at: usize| people.iter().map(move |days| days[at][feature]);
            let mean = |at: usize| day(at).sum::<f64>() / 4_000.0;
            let together = |a: usize, b: usize| {
                let (mean_a, mean_b) = (mean(a), mean(b));
                let products = day(a).zip(day(b)).map(|(x, y)| (x - mean_a) * (y - mean_b));
                products.sum::<f64>() / 4_000.0
            };
            let sd = |at: usize| together(at, at).sqrt();
            let agreement = |a: usize, b: usize| together(a, b) / (sd(a) * sd(b));
            assert!(
                (sd(1) / sd(0) - 1.0).abs() < 0.04,
                "{feature}: {}",
                sd(1) / sd(0)
            );
            assert!(
                (agreement(0, 1) - RELIABILITY).abs() < 0.03,
                "{feature}: {}",
                agreement(0, 1)
            );
            assert!(
                (agreement(1, 2) - RELIABILITY).abs() < 0.03,
                "{feature}: {}",
                agreement(1, 2)
            );
        }
    }

    #[test]
    fn people_spread_around_the_norm_as_stated_and_features_go_together() {
        let mut rng = ChaCha8Rng::seed_from_u64(7);
        let people: Vec<Style> = (0..4_000).map(|_| Style::random(&mut rng)).collect();
        let scores = |of: &dyn Fn(&Style) -> f64| {
            let values: Vec<f64> = people.iter().map(of).collect();
            let mean = values.iter().sum::<f64>() / 4_000.0;
            let sd = (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / 4_000.0).sqrt();
            let scores: Vec<f64> = values.iter().map(|v| (v - mean) / sd).collect();
            (sd, scores)
        };
        let left = |angle| move |s: &Style| *s.angle(angle, Side::Left);
        let obliquity = left(Angle::PelvicObliquity);
        let adduction = left(Angle::HipAdduction);
        let (knee, _) = scores(&|s| s.angle(Angle::KneeFlexion, Side::Left).offset_sd);
        // Drawing again beyond 2.5 takes 4 % off the standard deviation.
        assert!((knee - 0.403).abs() < 0.02, "{knee}");
        let (sides, _) = scores(&|s| {
            s.angle(Angle::ElbowFlexion, Side::Left).offset_deg
                - s.angle(Angle::ElbowFlexion, Side::Right).offset_deg
        });
        assert!((sides - 6.3).abs() < 0.3, "{sides}");
        let (_, first) = scores(&|s| obliquity(s).amplitude.ln());
        let (_, second) = scores(&|s| adduction(s).amplitude.ln());
        let together: f64 = first.iter().zip(&second).map(|(a, b)| a * b).sum::<f64>() / 4_000.0;
        // The product of the loadings is 0.29: 0.48 x 0.54 + 0.05 x 0.03 + 0.16 x 0.17.
        assert!((together - 0.29).abs() < 0.05, "{together}");
    }
}
