//! Reference populations: whose statures, masses and shoulders synthetic people have.
//!
//! A survey of soldiers has more heavy and broad-shouldered people than a street or a campus has.
//! All other dimensions follow from stature and mass by the regressions of [`anthropometry`]: at
//! the means of the Chinese table they give its hip breadths within 5 mm, and its depths of men's
//! chests within 2 mm (of women's 17 mm too much). Shoulders differ by up to 45 mm, and the forearms
//! of Chinese people by 18.
//!
//! [`anthropometry`]: super::anthropometry

use super::anthropometry::{DIMENSIONS, Dimensions, NAMES, PopulationNorms, either};
use super::{AGES, BODY_MASS_INDICES, WORKING_AGES};
use crate::error::{Error, Result};
use edgegait_core::pack::Sex;

/// A reference population.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ReferencePopulation {
    /// Soldiers of the United States: ANSUR II, see [`PopulationNorms::for_sex`].
    #[default]
    UsArmy,
    /// British adults of 19 to 65 years: Pheasant & Haslegrave (2006), "Bodyspace", table 2.5, as
    /// recalled; statures and shoulders are also those that Chan (City University of Hong Kong,
    /// "Online Anthropometry", chapter 2) states.
    Britain,
    /// Chinese adults of 18 to 60 years: GB/T 10000-1988, as recalled. Teaching slides that quote
    /// its table 1 confirm the statures and masses of men.
    China,
}

/// What the survey of a population states of one sex.
struct Survey {
    /// Mean stature and body mass index, with their standard deviations, m and kg/m2.
    norms: PopulationNorms,
    /// Means of dimensions that differ from soldiers', metres.
    means: &'static [(&'static str, f64)],
}

/// Returns a survey; shorthand for the tables below.
const fn survey(
    stature: (f64, f64),
    bmi: (f64, f64),
    means: &'static [(&'static str, f64)],
) -> Survey {
    Survey {
        norms: PopulationNorms { stature, bmi },
        means,
    }
}

/// Women and men of Britain. Masses are 63 (11) and 75 (12) kg; the indices are what gives these if
/// mass index and stature are independent, as in ANSUR II.
const BRITAIN: [Survey; 2] = [
    survey(
        (1.610, 0.062),
        (24.27, 3.80),
        &[("biacromial_breadth", 0.355), ("bideltoid_breadth", 0.395)],
    ),
    survey(
        (1.740, 0.070),
        (24.73, 3.42),
        &[("biacromial_breadth", 0.400), ("bideltoid_breadth", 0.465)],
    ),
];

/// Women and men of China. Statures are 1,484, 1,570 and 1,659 mm, and 1,583, 1,678 and 1,775, at
/// the percentiles 5, 50 and 95, and masses 42, 52 and 66 kg, and 48, 59 and 75. The indices are
/// log-normal, independent of stature, and give these percentiles within 1.3 kg.
const CHINA: [Survey; 2] = [
    survey(
        (1.570, 0.0532),
        (21.25, 2.55),
        &[
            ("biacromial_breadth", 0.351),
            ("bideltoid_breadth", 0.397),
            ("acromion_radiale_length", 0.284),
            ("radiale_stylion_length", 0.213),
        ],
    ),
    survey(
        (1.678, 0.0584),
        (21.10, 2.48),
        &[
            ("biacromial_breadth", 0.375),
            ("bideltoid_breadth", 0.431),
            ("acromion_radiale_length", 0.313),
            ("radiale_stylion_length", 0.237),
        ],
    ),
];

/// The maximum number of standard deviations from the mean of the statures and mass indices of a
/// population: that of all people of ANSUR II.
const MOST_SD: f64 = 3.5;

impl ReferencePopulation {
    /// All populations.
    pub const ALL: [Self; 3] = [Self::UsArmy, Self::Britain, Self::China];

    /// Returns the name in flags, designs and results.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::UsArmy => "us-army",
            Self::Britain => "britain",
            Self::China => "china",
        }
    }

    /// Returns the population of this name.
    ///
    /// # Errors
    /// If there is none; the error states the known names.
    pub fn named(name: &str) -> Result<Self> {
        let mut all = Self::ALL.into_iter();
        all.find(|known| known.name() == name).ok_or_else(|| {
            let known = Self::ALL.map(Self::name).join(", ");
            Error::Usage(format!("there is no population {name:?}: expected {known}"))
        })
    }

    const fn survey(self, sex: Sex) -> Option<&'static Survey> {
        let [women, men] = match self {
            Self::UsArmy => return None,
            Self::Britain => &BRITAIN,
            Self::China => &CHINA,
        };
        Some(match sex {
            Sex::Female => women,
            Sex::Male => men,
        })
    }

    /// Returns the statures and mass indices of women or men.
    #[must_use]
    pub fn norms(self, sex: Sex) -> PopulationNorms {
        self.survey(sex)
            .map_or_else(|| PopulationNorms::for_sex(sex), |survey| survey.norms)
    }

    /// Returns the range of ages that people may have, years: that of the survey's people, and of
    /// the gait model for soldiers.
    #[must_use]
    pub const fn ages(self) -> (f64, f64) {
        match self {
            Self::UsArmy => AGES,
            Self::Britain => (19.0, 65.0),
            Self::China => (18.0, 60.0),
        }
    }

    /// Returns the range from which the ages of people without a requested age are drawn, years.
    pub(super) const fn drawn_ages(self) -> (f64, f64) {
        match self {
            Self::UsArmy => WORKING_AGES,
            Self::Britain | Self::China => self.ages(),
        }
    }

    /// Returns the range of statures that people may have, metres: within 3.5 standard deviations
    /// of the sex's mean. Without a sex it is the range of both.
    #[must_use]
    pub fn statures(self, sex: Option<Sex>) -> (f64, f64) {
        either(sex, |sex| {
            let (mean, sd) = self.norms(sex).stature;
            (mean - MOST_SD * sd, mean + MOST_SD * sd)
        })
    }

    /// Returns the range of mass indices that people may have, kg/m2: within 3.5 standard
    /// deviations of the logarithm's mean, and [`BODY_MASS_INDICES`] for soldiers. Without a sex it
    /// is the range of both.
    #[must_use]
    pub fn mass_indices(self, sex: Option<Sex>) -> (f64, f64) {
        match self {
            Self::UsArmy => BODY_MASS_INDICES,
            Self::Britain | Self::China => either(sex, |sex| {
                let norms = self.norms(sex);
                (norms.mass_index(-MOST_SD), norms.mass_index(MOST_SD))
            }),
        }
    }

    /// Returns the dimensions of a person of this population, as [`Dimensions::expected`] does for
    /// soldiers. Those that the survey states are larger or smaller by the ratio of its mean to what
    /// soldiers of its mean stature and mass have.
    ///
    /// # Errors
    /// As [`Dimensions::expected`].
    pub fn dimensions(
        self,
        (stature_m, mass_kg): (f64, f64),
        sex: Sex,
        residuals: &[f64; DIMENSIONS],
    ) -> Result<Dimensions> {
        let soldier = Dimensions::expected(stature_m, mass_kg, Some(sex), residuals)?;
        let Some(Survey { norms, means }) = self.survey(sex) else {
            return Ok(soldier);
        };
        let (mean_m, bmi) = (norms.stature.0, norms.bmi.0);
        let mass_kg = bmi * mean_m * mean_m;
        let mean = Dimensions::expected(mean_m, mass_kg, Some(sex), &[0.0; DIMENSIONS])?.values();
        let own = soldier.values();
        let scaled = std::array::from_fn(|index| {
            let stated = means.iter().find(|(name, _)| *name == NAMES[index]);
            stated.map(|(_, stated)| own[index] * stated / mean[index])
        });
        Ok(soldier.with(&scaled))
    }
}

#[cfg(test)]
mod tests {
    use super::super::{CohortOptions, Person, Profile, subjects};
    use super::*;

    /// Returns statures and masses of 2,000 people, sorted.
    fn drawn(reference: ReferencePopulation, sex: Sex) -> [Vec<f64>; 2] {
        let profile = Profile {
            sex: Some(sex),
            reference,
            ..Profile::default()
        };
        let person = |index| Person::with_profile(7, index, &profile).expect("a person");
        let people: Vec<Person> = (0..2_000).map(person).collect();
        let statures = people.iter().map(|person| person.dimensions.stature);
        let masses = people.iter().map(|person| person.mass_kg);
        [statures.collect(), masses.collect()].map(|mut values: Vec<f64>| {
            values.sort_by(f64::total_cmp);
            values
        })
    }

    #[test]
    fn drawn_people_of_china_have_the_percentiles_of_the_survey() {
        for (sex, statures, masses) in [
            (Sex::Female, [1.484, 1.570, 1.659], [42.0, 52.0, 66.0]),
            (Sex::Male, [1.583, 1.678, 1.775], [48.0, 59.0, 75.0]),
        ] {
            let drawn = drawn(ReferencePopulation::China, sex);
            // The log-normal is off by up to 1.3 kg, and 2,000 people by up to 1.6 more.
            for (at, of) in [100, 1_000, 1_900].into_iter().enumerate() {
                assert!((drawn[0][of] - statures[at]).abs() < 0.008, "{sex:?} {at}");
                assert!(
                    (drawn[1][of] - masses[at]).abs() < 3.0,
                    "{sex:?} {at} {}",
                    drawn[1][of]
                );
            }
        }
    }

    #[test]
    fn drawn_people_of_britain_have_the_means_and_deviations_of_the_survey() {
        for (sex, stature, mass) in [
            (Sex::Female, (1.610, 0.062), (63.0, 11.0)),
            (Sex::Male, (1.740, 0.070), (75.0, 12.0)),
        ] {
            let near = |values: &[f64], (mean, sd): (f64, f64)| {
                let count = values.len() as f64;
                let found = values.iter().sum::<f64>() / count;
                let squares = values.iter().map(|value| (value - found).powi(2));
                let spread = (squares.sum::<f64>() / count).sqrt();
                assert!((found - mean).abs() < 0.1 * sd, "{sex:?} {found}");
                assert!((spread / sd - 1.0).abs() < 0.08, "{sex:?} {spread}");
            };
            let [statures, masses] = drawn(ReferencePopulation::Britain, sex);
            near(&statures, stature);
            near(&masses, mass);
        }
    }

    #[test]
    fn mean_people_have_the_dimensions_of_their_survey_and_nearly_its_hips_and_chests() {
        // GB/T 10000-1988, mm: hip breadth and depth of the chest of women and of men.
        for (sex, mean_m, shoulders, hips, chest) in [
            (Sex::Female, 1.570, [0.351, 0.397], 0.317, 0.199),
            (Sex::Male, 1.678, [0.375, 0.431], 0.306, 0.212),
        ] {
            let mass = ReferencePopulation::China.norms(sex).bmi.0 * mean_m * mean_m;
            let d = ReferencePopulation::China.dimensions((mean_m, mass), sex, &[0.0; DIMENSIONS]);
            let d = d.expect("a person");
            for reference in ReferencePopulation::ALL {
                let stated = reference.survey(sex).map_or(&[][..], |survey| survey.means);
                assert!(stated.iter().all(|(name, _)| NAMES.contains(name)));
            }
            assert!((d.biacromial_breadth - shoulders[0]).abs() < 1e-9);
            assert!((d.bideltoid_breadth - shoulders[1]).abs() < 1e-9);
            assert!((d.hip_breadth - hips).abs() < 0.005, "{}", d.hip_breadth);
            assert!((d.chest_depth - chest).abs() < 0.018, "{}", d.chest_depth);
        }
    }

    #[test]
    fn people_outside_of_a_population_are_refused_with_its_range() {
        let of = |reference, profile: Profile| {
            let profile = Profile {
                reference,
                ..profile
            };
            let refused = profile.check().expect_err("no such people").to_string();
            assert!(refused.contains(reference.name()), "{refused}");
            refused
        };
        let tall = Profile {
            stature_m: Some(1.95),
            ..Profile::default()
        };
        assert!(of(ReferencePopulation::China, tall).contains("1.39 to 1.88"));
        let old = Profile {
            age_years: Some(70.0),
            ..Profile::default()
        };
        assert!(of(ReferencePopulation::China, old).contains("18.00 to 60.00"));
        assert!(of(ReferencePopulation::Britain, old).contains("19.00 to 65.00"));
        let heavy = Profile {
            sex: Some(Sex::Male),
            stature_m: Some(1.678),
            mass_kg: Some(100.0),
            ..Profile::default()
        };
        // 59 kg times or divided by exp(3.5 x 0.117).
        assert!(of(ReferencePopulation::China, heavy).contains("39.1"));
        assert!(
            Profile {
                reference: ReferencePopulation::UsArmy,
                ..heavy
            }
            .check()
            .is_ok()
        );
    }

    #[test]
    fn extremes_of_all_populations_have_bodies() {
        for reference in ReferencePopulation::ALL {
            for sex in [Sex::Female, Sex::Male] {
                let (short, tall) = reference.statures(Some(sex));
                let (light, heavy) = reference.mass_indices(Some(sex));
                for (stature_m, bmi) in
                    [(short, light), (short, heavy), (tall, light), (tall, heavy)]
                {
                    let profile = Profile {
                        reference,
                        sex: Some(sex),
                        stature_m: Some(stature_m),
                        mass_kg: Some(bmi * stature_m * stature_m),
                        ..Profile::default()
                    };
                    let options = CohortOptions {
                        people: 1,
                        speeds_kmh: vec![5.0],
                        profile,
                        ..CohortOptions::default()
                    };
                    assert!(subjects(&options).is_ok(), "{reference:?} {sex:?}");
                }
            }
        }
    }
}
