//! Body dimensions from stature, mass and sex.
//!
//! Source of every number: our own least-squares regressions of each dimension on
//! stature and body mass index over the public release of ANSUR II (Gordon et al.
//! 2014, "2012 Anthropometric Survey of U.S. Army Personnel", NATICK/TR-15/007; 4,082
//! men and 1,986 women). The sample is military and its mass index truncated: very
//! light and very heavy people are extrapolations.

use crate::error::{Error, Result};
use edgegait_core::pack::Sex;

/// A dimension as `constant + stature * H + bmi * BMI` in mm, H in metres.
#[derive(Clone, Copy, Debug)]
struct Regression {
    constant: f64,
    stature: f64,
    bmi: f64,
    /// Residual standard deviation, mm.
    residual: f64,
}

impl Regression {
    /// Returns mean and standard deviation over a population, metres. Stature, mass index and
    /// residual are independent.
    fn spread(&self, population: &PopulationNorms) -> (f64, f64) {
        let ((stature, stature_sd), (bmi, bmi_sd)) = (population.stature, population.bmi);
        let mean = self.constant + self.stature * stature + self.bmi * bmi;
        let variance = [self.stature * stature_sd, self.bmi * bmi_sd, self.residual]
            .map(|sd| sd * sd)
            .iter()
            .sum();
        (1e-3 * mean, 1e-3 * libm::sqrt(variance))
    }
}

/// Returns a regression; shorthand for the table below.
const fn fit(constant: f64, stature: f64, bmi: f64, residual: f64) -> Regression {
    Regression {
        constant,
        stature,
        bmi,
        residual,
    }
}

/// Declares the dimensions, and for each the regressions for men and for women.
macro_rules! dimensions {
    ($($doc:literal $name:ident: $male:expr, $female:expr;)*) => {
        /// The dimensions of one person, metres.
        #[derive(Clone, Debug, PartialEq)]
        pub struct Dimensions {
            /// Height of the top of the head above the floor.
            pub stature: f64,
            $(#[doc = $doc] pub $name: f64,)*
        }

        /// Number of dimensions beside the stature.
        pub const DIMENSIONS: usize = NAMES.len();

        /// Names of the dimensions beside the stature, in the order of [`Dimensions`]' fields.
        pub const NAMES: [&str; [$(stringify!($name)),*].len()] = [$(stringify!($name)),*];

        /// Each dimension for men and women, in the order of [`Dimensions`]' fields.
        const REGRESSIONS: [(Regression, Regression); DIMENSIONS] = [$(($male, $female)),*];

        impl Dimensions {
            fn new(stature: f64, values: [f64; DIMENSIONS]) -> Self {
                let [$($name),*] = values;
                Self { stature, $($name),* }
            }

            /// Returns the dimensions beside the stature, metres, in the order of [`NAMES`].
            #[must_use]
            pub const fn values(&self) -> [f64; DIMENSIONS] {
                [$(self.$name),*]
            }
        }
    };
}

#[rustfmt::skip]
dimensions! {
    "Breadth between the acromia."
    biacromial_breadth: fit(104.29, 148.41, 1.833, 14.4), fit(82.49, 158.33, 0.981, 14.7);
    "Breadth across the deltoids."
    bideltoid_breadth: fit(65.43, 147.56, 6.713, 14.8), fit(53.67, 141.15, 6.542, 14.0);
    "Breadth of the hips, standing."
    hip_breadth: fit(-16.35, 134.61, 4.539, 12.7), fit(-24.70, 144.27, 5.632, 14.8);
    "Breadth between the iliac crests."
    bicristal_breadth: fit(-10.24, 129.28, 2.117, 12.4), fit(-19.63, 122.93, 3.638, 16.2);
    "Breadth of the chest."
    chest_breadth: fit(52.13, 90.78, 2.813, 12.9), fit(37.62, 90.44, 3.312, 13.1);
    "Depth of the chest, at the nipples."
    chest_depth: fit(-46.80, 83.60, 5.556, 12.3), fit(-41.90, 79.48, 6.271, 15.2);
    "Breadth of the waist, at the navel."
    waist_breadth: fit(-97.10, 125.33, 7.348, 15.8), fit(-84.43, 119.28, 7.455, 18.1);
    "Depth of the waist, at the navel."
    waist_depth: fit(-106.23, 78.48, 7.447, 16.5), fit(-66.18, 53.87, 7.510, 16.6);
    "Depth of the buttocks."
    buttock_depth: fit(-58.53, 82.12, 5.785, 11.0), fit(-39.15, 74.01, 5.944, 11.3);
    "Circumference of the thigh, at the gluteal fold."
    thigh_circumference: fit(-109.60, 216.12, 12.829, 22.6), fit(-116.24, 234.78, 13.730, 22.6);
    "Circumference of the thigh, above the knee."
    lower_thigh_circumference: fit(-16.58, 138.82, 6.576, 14.8), fit(-49.28, 153.86, 7.822, 19.1);
    "Circumference of the calf."
    calf_circumference: fit(28.39, 114.52, 5.878, 16.0), fit(2.21, 134.68, 5.951, 17.0);
    "Circumference of the ankle."
    ankle_circumference: fit(28.47, 78.56, 2.272, 10.1), fit(33.35, 79.26, 2.091, 11.8);
    "Circumference of the upper arm, flexed."
    biceps_circumference: fit(-4.50, 95.96, 7.011, 18.8), fit(-44.37, 96.48, 7.563, 13.9);
    "Circumference of the forearm, flexed."
    forearm_circumference: fit(27.75, 96.11, 4.100, 12.9), fit(14.75, 91.35, 3.944, 10.5);
    "Circumference of the wrist."
    wrist_circumference: fit(29.36, 63.85, 1.243, 6.0), fit(23.72, 62.94, 1.121, 5.3);
    "Circumference of the neck."
    neck_circumference: fit(129.35, 72.75, 5.076, 14.8), fit(104.23, 76.61, 3.954, 12.1);
    "Breadth of the head."
    head_breadth: fit(130.83, 6.00, 0.468, 5.2), fit(121.72, 11.86, 0.264, 5.0);
    "Length of the head, forehead to back."
    head_length: fit(121.29, 37.77, 0.429, 6.3), fit(113.79, 40.33, 0.406, 6.8);
    "Height of the acromion above the floor."
    acromial_height: fit(-162.34, 892.45, 1.291, 15.3), fit(-112.48, 877.10, 0.755, 13.4);
    "Height of the seventh cervical vertebra above the floor."
    cervicale_height: fit(-100.39, 908.34, 0.811, 10.7), fit(-94.32, 912.00, 0.189, 10.5);
    "Height of the top of the breastbone above the floor."
    suprasternale_height: fit(-132.28, 876.77, 1.122, 10.8), fit(-112.39, 871.32, 0.908, 10.5);
    "Height of the greater trochanter above the floor."
    trochanterion_height: fit(-150.63, 609.84, -0.703, 25.7), fit(-130.96, 596.46, 0.196, 23.0);
    "Height of the crotch above the floor."
    crotch_height: fit(-143.00, 582.23, -1.213, 23.4), fit(-161.00, 592.95, -0.874, 23.4);
    "Height of the lateral femoral epicondyle above the floor."
    knee_height: fit(-89.47, 333.01, -0.134, 13.6), fit(-91.83, 336.88, 0.359, 16.3);
    "Height of the lateral malleolus above the floor."
    malleolus_height: fit(-1.81, 38.64, 0.247, 4.9), fit(5.26, 34.74, 0.036, 4.6);
    "Height of the iliac crest above the floor."
    iliocristale_height: fit(-137.51, 690.17, -0.468, 21.5), fit(-162.44, 707.82, 0.215, 20.0);
    "Height of the nipples above the floor."
    chest_height: fit(-93.59, 787.57, 0.057, 18.1), fit(-91.51, 794.92, -1.230, 21.9);
    "Length of the upper arm, acromion to radiale."
    acromion_radiale_length: fit(-27.27, 202.79, 0.230, 10.6), fit(-44.74, 210.46, 0.518, 10.3);
    "Length of the forearm, radiale to stylion."
    radiale_stylion_length: fit(-15.88, 160.75, 0.053, 10.8), fit(-30.84, 162.32, 0.308, 11.0);
    "Length of the hand."
    hand_length: fit(13.45, 97.64, 0.302, 7.3), fit(6.45, 99.84, 0.473, 7.5);
    "Breadth of the hand."
    hand_breadth: fit(25.02, 29.80, 0.394, 3.5), fit(25.61, 27.36, 0.314, 3.2);
    "Length of the foot."
    foot_length: fit(15.15, 137.19, 0.546, 8.9), fit(5.35, 138.02, 0.635, 8.3);
    "Breadth of the foot."
    foot_breadth: fit(27.18, 34.30, 0.522, 4.2), fit(32.60, 29.24, 0.490, 4.0);
    "Height of the top of the head above the ear, upright."
    tragion_to_vertex: fit(96.44, 17.83, 0.123, 6.0), fit(84.76, 21.48, 0.264, 6.3);
}

/// Mean and standard deviation of stature, metres, and of body mass index.
#[derive(Clone, Copy, Debug)]
pub struct PopulationNorms {
    /// Stature: mean and standard deviation, metres.
    pub stature: (f64, f64),
    /// Body mass index: mean and standard deviation, kg/m2.
    pub bmi: (f64, f64),
}

impl PopulationNorms {
    /// Returns the norms of ANSUR II's men or women, whose stature and mass index are uncorrelated
    /// (r = 0.002 and 0.054).
    #[must_use]
    pub const fn for_sex(sex: Sex) -> Self {
        match sex {
            Sex::Male => Self {
                stature: (1.7562, 0.0686),
                bmi: (27.69, 4.04),
            },
            Sex::Female => Self {
                stature: (1.6285, 0.0642),
                bmi: (25.50, 3.49),
            },
        }
    }

    /// Returns the mass index of people who are this many standard deviations from the mean, kg/m2.
    /// Mass indices are skewed: log-normal with the published mean and deviation.
    #[must_use]
    pub fn mass_index(&self, deviations: f64) -> f64 {
        let (mean, sd) = self.bmi;
        let log_variance = libm::log1p((sd / mean) * (sd / mean));
        let log_mean = libm::log(mean) - 0.5 * log_variance;
        libm::exp(log_mean + libm::sqrt(log_variance) * deviations)
    }

    /// Returns the range of statures within `PLAUSIBLE_SD` of the mean, metres; without a sex, the
    /// range of both.
    #[must_use]
    pub fn plausible_stature(sex: Option<Sex>) -> (f64, f64) {
        either(sex, |sex| plausible(Self::for_sex(sex).stature))
    }
}

/// The maximum number of standard deviations from the mean of a plausible measurement: only
/// mistakes, such as a wrong unit or column, are further out.
const PLAUSIBLE_SD: f64 = 6.0;

/// Returns the range of plausible values from mean and standard deviation.
fn plausible((mean, sd): (f64, f64)) -> (f64, f64) {
    (mean - PLAUSIBLE_SD * sd, mean + PLAUSIBLE_SD * sd)
}

/// Returns a range of the given sex; without a sex, the range of both.
pub(super) fn either(sex: Option<Sex>, of: impl Fn(Sex) -> (f64, f64)) -> (f64, f64) {
    match sex {
        Some(sex) => of(sex),
        None => {
            let (female, male) = (of(Sex::Female), of(Sex::Male));
            (female.0.min(male.0), female.1.max(male.1))
        }
    }
}

impl Dimensions {
    /// Returns the dimensions of a person of `stature_m`, `mass_kg` and `sex`; without a sex,
    /// the mean of both regressions. `residuals` moves each dimension by that many
    /// residual standard deviations; zeros give the expected person.
    ///
    /// # Errors
    /// For statures outside of 0.5..=2.5 m and body mass indices outside of 12..=60.
    pub fn expected(
        stature_m: f64,
        mass_kg: f64,
        sex: Option<Sex>,
        residuals: &[f64; DIMENSIONS],
    ) -> Result<Self> {
        let bmi = mass_kg / (stature_m * stature_m);
        // Less rounding: 34.68 kg at 1.7 m are an index of 12.
        let is_plausible = (12.0 - 1e-9..=60.0 + 1e-9).contains(&bmi);
        if !(0.5..=2.5).contains(&stature_m) || !is_plausible {
            return Err(Error::Usage(format!(
                "a stature of {stature_m} m and a mass of {mass_kg} kg (body mass index {bmi:.1}): expected 0.5 to 2.5 m and an index of 12 to 60"
            )));
        }
        // The regressions hold for adults; smaller people are scaled-down adults.
        let scale = (stature_m / 1.4).min(1.0);
        let adult_m = stature_m / scale;
        let mut values = [0.0; DIMENSIONS];
        for (index, value) in values.iter_mut().enumerate() {
            let (male, female) = &REGRESSIONS[index];
            let at = |r: &Regression| {
                r.constant + r.stature * adult_m + r.bmi * bmi + r.residual * residuals[index]
            };
            let mm = match sex {
                Some(Sex::Male) => at(male),
                Some(Sex::Female) => at(female),
                None => 0.5 * (at(male) + at(female)),
            };
            *value = mm * scale * 1e-3;
        }
        Ok(Self::new(stature_m, values))
    }

    /// Returns the same person with these dimensions, metres, in the order of [`NAMES`]; `None`
    /// leaves a dimension as it is.
    #[must_use]
    pub fn with(&self, measured: &[Option<f64>; DIMENSIONS]) -> Self {
        let mut values = self.values();
        for (value, measured) in values.iter_mut().zip(measured) {
            *value = measured.unwrap_or(*value);
        }
        Self::new(self.stature, values)
    }

    /// Returns the range of plausible values of each dimension, in the order of [`NAMES`], metres:
    /// within `PLAUSIBLE_SD` of the population's mean; without a sex, the range of both.
    #[must_use]
    pub fn plausible(sex: Option<Sex>) -> [(f64, f64); DIMENSIONS] {
        std::array::from_fn(|index| {
            let (least, most) = either(sex, |sex| {
                let (male, female) = &REGRESSIONS[index];
                let regression = match sex {
                    Sex::Male => male,
                    Sex::Female => female,
                };
                plausible(regression.spread(&PopulationNorms::for_sex(sex)))
            });
            // No dimension is negative, however widely it spreads.
            (least.max(1e-3), most)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn man(stature_m: f64, mass_kg: f64) -> Dimensions {
        Dimensions::expected(stature_m, mass_kg, Some(Sex::Male), &[0.0; DIMENSIONS])
            .expect("a plausible man")
    }

    #[test]
    fn the_mean_man_has_the_mean_dimensions() {
        // ANSUR II means, mm: hip breadth 346, chest depth 254, knee (epicondyle) 492.
        let mean = man(1.7562, 27.69 * 1.7562 * 1.7562);
        for (found, published) in [
            (mean.hip_breadth, 0.346),
            (mean.chest_depth, 0.254),
            (mean.knee_height, 0.492),
            (mean.thigh_circumference, 0.625),
        ] {
            assert!((found - published).abs() < 1e-3, "{found} {published}");
        }
    }

    #[test]
    fn heavier_people_are_wider_and_taller_ones_longer() {
        let (slim, heavy, tall) = (man(1.75, 60.0), man(1.75, 100.0), man(1.95, 74.5));
        assert!(heavy.waist_breadth > slim.waist_breadth + 0.05);
        assert!(tall.trochanterion_height > slim.trochanterion_height + 0.1);
    }

    #[test]
    fn dimensions_within_six_published_deviations_are_plausible() {
        // ANSUR II, mm: foot length 271.2 (13.1) of men and 246.3 (12.4) of women; waist
        // breadth 326.4 (34.7) of men.
        let of = |sex, name| {
            let index = NAMES.iter().position(|known| *known == name);
            Dimensions::plausible(sex)[index.expect("a dimension")]
        };
        let near = |found: (f64, f64), least: f64, most: f64| {
            assert!((found.0 - least).abs() < 0.004, "{found:?} {least}");
            assert!((found.1 - most).abs() < 0.004, "{found:?} {most}");
        };
        near(of(Some(Sex::Male), "foot_length"), 0.1926, 0.3498);
        near(of(Some(Sex::Female), "foot_length"), 0.1719, 0.3207);
        near(of(None, "foot_length"), 0.1719, 0.3498);
        near(of(Some(Sex::Male), "waist_breadth"), 0.1182, 0.5346);
        near(PopulationNorms::plausible_stature(None), 1.2433, 2.1678);
    }

    #[test]
    fn a_measured_dimension_replaces_its_regression_and_no_other() {
        let expected = man(1.75, 75.0);
        let mut measured = [None; DIMENSIONS];
        measured[NAMES
            .iter()
            .position(|name| *name == "hip_breadth")
            .unwrap()] = Some(0.4);
        let person = expected.with(&measured);
        assert!((person.hip_breadth - 0.4).abs() < 1e-12);
        let hip_breadth = expected.hip_breadth;
        assert_eq!(
            Dimensions {
                hip_breadth,
                ..person
            },
            expected
        );
    }

    #[test]
    fn implausible_people_are_refused() {
        for (stature, mass) in [(0.4, 20.0), (f64::NAN, 70.0), (1.75, 20.0), (1.75, 300.0)] {
            let person = Dimensions::expected(stature, mass, None, &[0.0; DIMENSIONS]);
            assert!(person.is_err(), "{stature} {mass}");
        }
    }
}
