//! The built-in cohort: 26 people at 10 speeds, made from published norms and a seed.
//!
//! It stands in for the 26 volunteers of Charalambous & Bharath (BMVC 2016), whose
//! motion capture is not redistributable: 13 women and 13 men, walking at 3 to 7 km/h
//! and running at 8 to 12. People differ in body ([`anthropometry`]) and in motion
//! (`style`).

mod angles;
pub mod anthropometry;
pub mod body;
mod gait;
mod norms;
mod rings;
pub(in crate::scene) mod style;

use crate::error::{Error, Result};
use crate::scene::{Body, Cycle, Subject, Track, Walk};
use angles::gait_at;
use anthropometry::{DIMENSIONS, Dimensions, Population};
use edgegait_core::pack::{Gait, Sex};
#[cfg(feature = "import")]
pub(super) use gait::STANDING_TILT_DEG;
use gait::Walker;
#[cfg(feature = "import")]
pub(super) use norms::{Curve, ELBOW_FLEXION, SHOULDER_ABDUCTION, SHOULDER_FLEXION, WALKING};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use style::Style;
pub use style::normal;

/// Seed of the people whom the shipped models know.
pub const DEFAULT_SEED: u64 = 1;
/// People of the built-in cohort, as many as in the source paper.
pub const PEOPLE: usize = 26;
/// Speeds of the built-in cohort, km/h: those of the source paper.
pub const SPEEDS_KMH: [f64; 10] = [3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0, 11.0, 12.0];

/// One person of the cohort.
#[derive(Clone, Debug)]
pub struct Person {
    /// Name: `F01` to `F13` and `M01` to `M13`; with another seed than the default, the
    /// seed stands before it (`2-F01`), since these are other people.
    pub name: String,
    /// Sex.
    pub sex: Sex,
    /// Body mass, kg.
    pub mass_kg: f64,
    /// Body dimensions.
    pub dimensions: Dimensions,
    /// The body made from them.
    pub body: Body,
    style: Style,
}

impl Person {
    /// The `index`-th person of the cohort that `seed` makes; women and men alternate.
    ///
    /// # Errors
    /// Never for the populations built in: their extremes are plausible people.
    pub fn of_cohort(seed: u64, index: usize) -> Result<Self> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream(index as u64);
        let (sex, letter) = if index.is_multiple_of(2) {
            (Sex::Female, 'F')
        } else {
            (Sex::Male, 'M')
        };
        let population = Population::of(sex);
        let stature_m = population.stature.0 + population.stature.1 * normal(&mut rng);
        // Mass indices are skewed: log-normal with the published mean and deviation.
        let (mean, sd) = population.bmi;
        let log_variance = libm::log1p((sd / mean) * (sd / mean));
        let log_mean = libm::log(mean) - 0.5 * log_variance;
        let bmi = libm::exp(log_mean + libm::sqrt(log_variance) * normal(&mut rng));
        let mass_kg = bmi * stature_m * stature_m;
        let residuals: [f64; DIMENSIONS] = std::array::from_fn(|_| normal(&mut rng));
        let mut name = format!("{letter}{:02}", index / 2 + 1);
        if seed != DEFAULT_SEED {
            name = format!("{seed}-{name}");
        }
        Self::new(
            name,
            sex,
            stature_m,
            mass_kg,
            &residuals,
            Style::random(&mut rng),
        )
    }

    /// The person whom the norms describe.
    #[must_use]
    pub fn average(sex: Sex) -> Self {
        let population = Population::of(sex);
        let stature_m = population.stature.0;
        let mass_kg = population.bmi.0 * stature_m * stature_m;
        let person = Self::new(
            "average".into(),
            sex,
            stature_m,
            mass_kg,
            &[0.0; DIMENSIONS],
            Style::NONE,
        );
        person.expect("the mean of a population is a plausible person")
    }

    fn new(
        name: String,
        sex: Sex,
        stature_m: f64,
        mass_kg: f64,
        residuals: &[f64; DIMENSIONS],
        style: Style,
    ) -> Result<Self> {
        let dimensions = Dimensions::expected(stature_m, mass_kg, Some(sex), residuals)?;
        let body = body::body(&dimensions, body::offsets(&dimensions));
        Ok(Self {
            name,
            sex,
            mass_kg,
            dimensions,
            body,
            style,
        })
    }

    /// One gait cycle at `speed_kmh`.
    #[must_use]
    pub fn cycle(&self, speed_kmh: f64) -> Cycle {
        let walker = Walker {
            dimensions: &self.dimensions,
            body: &self.body,
            style: &self.style,
            sex: self.sex,
        };
        gait::cycle(&walker, speed_kmh)
    }
}

/// What cohort to make.
#[derive(Clone, Debug, PartialEq)]
pub struct CohortOptions {
    /// Seed of the people.
    pub seed: u64,
    /// How many people.
    pub people: usize,
    /// Speeds, km/h, each within 3..=12.
    pub speeds_kmh: Vec<f64>,
}

impl Default for CohortOptions {
    fn default() -> Self {
        Self {
            seed: DEFAULT_SEED,
            people: PEOPLE,
            speeds_kmh: SPEEDS_KMH.to_vec(),
        }
    }
}

/// Makes the cohort: every person at every speed.
///
/// # Errors
/// For speeds outside of the norms.
pub fn subjects(options: &CohortOptions) -> Result<Vec<Subject>> {
    if let Some(speed) = options
        .speeds_kmh
        .iter()
        .find(|speed| !(3.0..=12.0).contains(*speed))
    {
        return Err(Error::Usage(format!(
            "a speed of {speed} km/h: expected 3 to 12, the range of the norms"
        )));
    }
    for (index, speed) in options.speeds_kmh.iter().enumerate() {
        if options.speeds_kmh[..index].contains(speed) {
            return Err(Error::Usage(format!(
                "a speed of {speed} km/h twice: expected each once, since walks are told apart by it"
            )));
        }
    }
    (0..options.people)
        .map(|index| {
            let person = Person::of_cohort(options.seed, index)?;
            let walks = options.speeds_kmh.iter().map(|&speed| {
                let gait = gait_at(speed);
                let verb = match gait {
                    Gait::Walk => "walk",
                    Gait::Run => "run",
                };
                Walk {
                    name: format!("{verb}-{speed}kmh"),
                    cycle: 0,
                    gait,
                    speed_mps: speed / 3.6,
                    motion: Track::Loop(person.cycle(speed)),
                }
            });
            Ok(Subject {
                walks: walks.collect(),
                name: person.name,
                sex: Some(person.sex),
                stature_m: person.dimensions.stature,
                mass_kg: person.mass_kg,
                body: person.body,
            })
        })
        .collect()
}
