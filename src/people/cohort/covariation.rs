//! How the features of people's gaits go together, between people and within.
//!
//! From 10 walkers of the CMU Graphics Lab Motion Capture Database (subjects 02, 05, 06, 07, 08,
//! 10, 12, 38, 43 and 49; 19 takes, 31 cycles at 0.9 to 1.8 m/s; no clips that the evaluation
//! keeps unseen, no patients). "The data used in this project was obtained from
//! mocap.cs.cmu.edu. The database was created with funding from NSF EIA-0196217."
//!
//! They are few: 67 % of each correlation is shrunk away, and the sample correlations of legs and
//! pelvis correlate by 0.13 only with those of 21 people of four other data sets, where two such
//! samples of one population would by about 0.4. Where a spread between people is published, that
//! one counts.
//!
//! Made by `fit` (see there for the command), 2026-11-23.

use super::norms::Angle;

/// One feature of a gait.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Feature {
    /// Mean of both sides over the cycle, less the norm's, degrees. Of the hip: what pelvic tilt and
    /// half of the knee's offset leave of it, as in `gait`; correlations that are geometry are
    /// the model's own, since shrinking would halve them.
    Offset(Angle),
    /// Logarithm of the swing's size (root mean square) over the norm's.
    Amplitude(Angle),
    /// How much later than the norm's the swing comes, cycles.
    Delay(Angle),
    /// Left ankle centre to the left of the right one while both feet stand, metres.
    StepWidth,
    /// Logarithm of step length over cadence, per stature.
    WalkRatio,
    /// Peak to peak of the pelvis's height, metres.
    Bob,
    /// Peak to peak of the pelvis's place to the side, metres.
    Sway,
    /// Least height of the toe tip in mid-swing over that in mid-stance, metres.
    Clearance,
    /// Head against the world, forwards, degrees.
    HeadPitch,
}

/// How many features there are.
pub(super) const FEATURES: usize = 35;

/// The features in the order of the tables.
///
/// Not among them: offsets that are zero by definition (pelvis and thorax, frontal and
/// transverse: the sides are mirrored), hip rotation (cross-talk of the knee's axis), offsets that
/// a model solves for (hip adduction from the step width, the ankle from the level sole), delays of
/// swings that hardly resemble the norm's.
pub(super) const ORDER: [Feature; FEATURES] = [
    Feature::Offset(Angle::PelvicTilt),
    Feature::Offset(Angle::HipFlexion),
    Feature::Offset(Angle::KneeFlexion),
    Feature::Offset(Angle::FootProgression),
    Feature::Offset(Angle::ThoraxTilt),
    Feature::Offset(Angle::ShoulderFlexion),
    Feature::Offset(Angle::ShoulderAbduction),
    Feature::Offset(Angle::ElbowFlexion),
    Feature::Amplitude(Angle::PelvicTilt),
    Feature::Amplitude(Angle::PelvicObliquity),
    Feature::Amplitude(Angle::PelvicRotation),
    Feature::Amplitude(Angle::HipFlexion),
    Feature::Amplitude(Angle::HipAdduction),
    Feature::Amplitude(Angle::KneeFlexion),
    Feature::Amplitude(Angle::AnkleDorsiflexion),
    Feature::Amplitude(Angle::ThoraxTilt),
    Feature::Amplitude(Angle::ThoraxObliquity),
    Feature::Amplitude(Angle::ThoraxRotation),
    Feature::Amplitude(Angle::ShoulderFlexion),
    Feature::Amplitude(Angle::ShoulderAbduction),
    Feature::Amplitude(Angle::ElbowFlexion),
    Feature::Delay(Angle::PelvicRotation),
    Feature::Delay(Angle::HipFlexion),
    Feature::Delay(Angle::HipAdduction),
    Feature::Delay(Angle::KneeFlexion),
    Feature::Delay(Angle::AnkleDorsiflexion),
    Feature::Delay(Angle::ThoraxRotation),
    Feature::Delay(Angle::ShoulderFlexion),
    Feature::Delay(Angle::ElbowFlexion),
    Feature::StepWidth,
    Feature::WalkRatio,
    Feature::Bob,
    Feature::Sway,
    Feature::Clearance,
    Feature::HeadPitch,
];

/// How many factors there are.
pub(super) const FACTORS: usize = 4;

/// Standard deviation of each feature between people (without what speed says), between takes of
/// one person (12 takes of 3 people) and between cycles of one take (23 cycles of 11 takes; what
/// closing loops does to them: see `fit`). A 0 between takes: no more than the few cycles of each explain.
#[cfg(all(test, feature = "import"))]
#[rustfmt::skip]
pub(super) const SPREADS: [[f64; 3]; FEATURES] = [
    [5.8681, 0.4814, 0.5263], // Offset(PelvicTilt)
    [1.1353, 0.0000, 0.4170], // Offset(HipFlexion)
    [2.2343, 2.0444, 0.6545], // Offset(KneeFlexion)
    [5.5600, 0.4166, 1.3414], // Offset(FootProgression)
    [3.3773, 1.5724, 0.7887], // Offset(ThoraxTilt)
    [3.9789, 1.7412, 0.5583], // Offset(ShoulderFlexion)
    [3.0058, 0.7580, 0.4469], // Offset(ShoulderAbduction)
    [4.0575, 2.0069, 0.9495], // Offset(ElbowFlexion)
    [0.3912, 0.0891, 0.2271], // Amplitude(PelvicTilt)
    [0.3407, 0.0000, 0.0765], // Amplitude(PelvicObliquity)
    [0.4987, 0.1801, 0.1883], // Amplitude(PelvicRotation)
    [0.1070, 0.0567, 0.0148], // Amplitude(HipFlexion)
    [0.2554, 0.0243, 0.0479], // Amplitude(HipAdduction)
    [0.1059, 0.0256, 0.0238], // Amplitude(KneeFlexion)
    [0.1812, 0.0000, 0.0616], // Amplitude(AnkleDorsiflexion)
    [0.3322, 0.2331, 0.1547], // Amplitude(ThoraxTilt)
    [0.6940, 0.2387, 0.2549], // Amplitude(ThoraxObliquity)
    [0.3769, 0.0000, 0.2740], // Amplitude(ThoraxRotation)
    [0.5546, 0.1482, 0.0998], // Amplitude(ShoulderFlexion)
    [0.2436, 0.1032, 0.1570], // Amplitude(ShoulderAbduction)
    [0.5353, 0.1067, 0.1282], // Amplitude(ElbowFlexion)
    [0.0478, 0.0000, 0.0259], // Delay(PelvicRotation)
    [0.0129, 0.0056, 0.0056], // Delay(HipFlexion)
    [0.0256, 0.0040, 0.0087], // Delay(HipAdduction)
    [0.0072, 0.0000, 0.0052], // Delay(KneeFlexion)
    [0.0146, 0.0014, 0.0066], // Delay(AnkleDorsiflexion)
    [0.0880, 0.0186, 0.0199], // Delay(ThoraxRotation)
    [0.0391, 0.0130, 0.0148], // Delay(ShoulderFlexion)
    [0.0388, 0.0213, 0.0209], // Delay(ElbowFlexion)
    [0.0217, 0.0069, 0.0114], // StepWidth
    [0.0815, 0.0971, 0.0383], // WalkRatio
    [0.0080, 0.0062, 0.0032], // Bob
    [0.0104, 0.0041, 0.0068], // Sway
    [0.0105, 0.0016, 0.0040], // Clearance
    [12.4130, 3.1958, 2.0827], // HeadPitch
];

/// Loadings of the factors in which people differ: shrinkage 0.670 of the correlations. What a row's
/// squares leave of 1 is the feature's own.
#[rustfmt::skip]
pub(super) const LOADINGS: [[f64; FACTORS]; FEATURES] = [
    [-0.10, 0.41, 0.07, -0.04], // Offset(PelvicTilt)
    [0.15, 0.11, 0.01, -0.07], // Offset(HipFlexion)
    [-0.01, -0.21, -0.36, 0.18], // Offset(KneeFlexion)
    [0.22, -0.38, -0.00, 0.07], // Offset(FootProgression)
    [0.15, -0.34, 0.32, -0.11], // Offset(ThoraxTilt)
    [0.08, -0.47, 0.26, 0.17], // Offset(ShoulderFlexion)
    [0.30, 0.44, 0.06, -0.06], // Offset(ShoulderAbduction)
    [0.14, 0.07, -0.36, -0.15], // Offset(ElbowFlexion)
    [0.35, -0.24, -0.01, -0.15], // Amplitude(PelvicTilt)
    [0.49, 0.03, -0.16, -0.01], // Amplitude(PelvicObliquity)
    [0.14, -0.05, -0.34, 0.40], // Amplitude(PelvicRotation)
    [0.06, 0.17, 0.37, 0.34], // Amplitude(HipFlexion)
    [0.54, 0.03, -0.16, 0.03], // Amplitude(HipAdduction)
    [0.27, -0.05, 0.35, 0.26], // Amplitude(KneeFlexion)
    [0.23, -0.48, 0.07, 0.14], // Amplitude(AnkleDorsiflexion)
    [-0.24, 0.30, -0.32, 0.12], // Amplitude(ThoraxTilt)
    [-0.45, 0.22, 0.05, -0.15], // Amplitude(ThoraxObliquity)
    [0.34, 0.29, 0.21, 0.12], // Amplitude(ThoraxRotation)
    [-0.28, 0.22, 0.14, 0.40], // Amplitude(ShoulderFlexion)
    [-0.44, -0.30, 0.03, -0.17], // Amplitude(ShoulderAbduction)
    [-0.50, -0.10, 0.10, 0.15], // Amplitude(ElbowFlexion)
    [-0.02, 0.02, 0.19, 0.23], // Delay(PelvicRotation)
    [-0.25, 0.38, -0.24, 0.12], // Delay(HipFlexion)
    [0.40, -0.27, -0.25, -0.06], // Delay(HipAdduction)
    [0.13, 0.26, -0.11, 0.21], // Delay(KneeFlexion)
    [0.01, -0.15, -0.03, 0.07], // Delay(AnkleDorsiflexion)
    [0.20, 0.29, 0.22, -0.36], // Delay(ThoraxRotation)
    [0.34, 0.09, -0.40, 0.05], // Delay(ShoulderFlexion)
    [0.37, 0.16, -0.21, -0.04], // Delay(ElbowFlexion)
    [0.10, 0.08, 0.53, -0.16], // StepWidth
    [0.29, 0.28, 0.14, 0.28], // WalkRatio
    [0.15, 0.32, 0.15, 0.07], // Bob
    [0.45, 0.19, 0.19, -0.08], // Sway
    [0.54, -0.08, 0.10, 0.11], // Clearance
    [0.13, 0.10, 0.01, -0.49], // HeadPitch
];

/// The same for takes of one person and cycles of one take together (12 takes, 23 cycles), by
/// shrinkage 0.448.
#[cfg(all(test, feature = "import"))]
#[rustfmt::skip]
pub(super) const WITHIN_LOADINGS: [[f64; FACTORS]; FEATURES] = [
    [0.04, 0.20, -0.17, 0.35], // Offset(PelvicTilt)
    [0.17, 0.25, 0.02, -0.34], // Offset(HipFlexion)
    [0.16, 0.04, 0.36, 0.11], // Offset(KneeFlexion)
    [-0.16, 0.31, 0.01, -0.20], // Offset(FootProgression)
    [0.38, 0.27, -0.05, -0.26], // Offset(ThoraxTilt)
    [-0.02, -0.34, -0.36, 0.18], // Offset(ShoulderFlexion)
    [0.43, 0.21, 0.33, 0.12], // Offset(ShoulderAbduction)
    [0.38, 0.14, 0.39, -0.02], // Offset(ElbowFlexion)
    [0.06, -0.32, 0.17, 0.08], // Amplitude(PelvicTilt)
    [-0.25, 0.51, 0.22, 0.25], // Amplitude(PelvicObliquity)
    [0.39, -0.35, 0.40, 0.05], // Amplitude(PelvicRotation)
    [0.69, 0.09, 0.10, 0.05], // Amplitude(HipFlexion)
    [-0.25, 0.27, 0.24, 0.03], // Amplitude(HipAdduction)
    [0.17, 0.04, -0.10, 0.34], // Amplitude(KneeFlexion)
    [0.42, -0.07, -0.03, 0.25], // Amplitude(AnkleDorsiflexion)
    [-0.28, -0.02, -0.11, 0.53], // Amplitude(ThoraxTilt)
    [0.05, -0.50, -0.16, 0.10], // Amplitude(ThoraxObliquity)
    [-0.11, 0.49, -0.04, 0.37], // Amplitude(ThoraxRotation)
    [0.36, -0.39, 0.20, 0.25], // Amplitude(ShoulderFlexion)
    [0.22, -0.03, 0.33, 0.03], // Amplitude(ShoulderAbduction)
    [-0.33, -0.20, -0.10, 0.13], // Amplitude(ElbowFlexion)
    [-0.25, 0.27, -0.06, 0.14], // Delay(PelvicRotation)
    [0.48, 0.23, -0.13, -0.14], // Delay(HipFlexion)
    [0.50, 0.05, -0.37, -0.18], // Delay(HipAdduction)
    [0.28, 0.29, -0.48, -0.00], // Delay(KneeFlexion)
    [0.25, 0.24, -0.41, -0.02], // Delay(AnkleDorsiflexion)
    [0.06, 0.33, 0.06, -0.06], // Delay(ThoraxRotation)
    [-0.02, 0.04, -0.23, 0.07], // Delay(ShoulderFlexion)
    [0.02, -0.13, -0.30, 0.01], // Delay(ElbowFlexion)
    [-0.13, 0.30, 0.17, 0.10], // StepWidth
    [0.54, -0.14, 0.08, 0.20], // WalkRatio
    [0.36, 0.17, -0.31, 0.44], // Bob
    [-0.03, 0.33, 0.29, 0.16], // Sway
    [-0.23, -0.14, 0.29, 0.07], // Clearance
    [0.19, 0.03, 0.07, -0.03], // HeadPitch
];
