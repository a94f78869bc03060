//! The built-in cohort: 26 people at 10 speeds, generated from published norms and a seed.
//!
//! It stands in for the 26 volunteers of Charalambous & Bharath (BMVC 2016), whose
//! motion capture is not redistributable: 13 women and 13 men, walking at 3 to 7 km/h
//! and running at 8 to 12. People differ in body ([`anthropometry`]) and in motion
//! (`style`).

mod angles;
pub mod anthropometry;
mod arms;
pub mod body;
mod covariation;
#[cfg(all(test, feature = "import"))]
mod fit;
mod gait;
mod gait_style;
mod head_and_neck;
mod limbs;
mod norms;
mod pose;
mod reference;
mod rings;
mod sole;
mod steps;
mod steps_and_pelvis;
pub(in crate::people) mod style;
mod swing;
mod wardrobe;

use crate::error::{Error, Result};
use crate::people::session::name_in_session;
use crate::people::{Body, Cycle, Subject, Track, Walk};
use angles::gait_at;
use anthropometry::{DIMENSIONS, Dimensions};
use edgegait_core::pack::Sex;
use edgegait_core::skeleton::Joint;
use gait_style::GaitStyle;
#[cfg(feature = "import")]
pub(super) use limbs::SHOULDER_DROP;
#[cfg(feature = "import")]
pub(super) use norms::{AngleCurve, ELBOW_FLEXION, SHOULDER_ABDUCTION, SHOULDER_FLEXION, WALKING};
#[cfg(feature = "import")]
pub(super) use pose::STANDING_TILT_DEG;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
pub use reference::ReferencePopulation;
use std::ops::Range;
use style::Style;
pub use style::normal;
pub use wardrobe::Dressing;
use wardrobe::Worn;

/// Seed of the people that the shipped models were trained on.
pub const DEFAULT_SEED: u64 = 1;
/// People of the built-in cohort, as many as in the source paper.
pub const PEOPLE: usize = 26;
/// Speeds of the built-in cohort, km/h: those of the source paper.
pub const SPEEDS_KMH: [f64; 10] = [3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0, 11.0, 12.0];

/// Speeds of the built-in cohort's second session, km/h: people's usual speeds. All ten speeds
/// would take the pack beyond 64 KiB.
pub const LATER_KMH: [f64; 3] = [4.0, 5.0, 6.0];

/// The people of [`CohortOptions::unseen`]: the shipped models were trained on the first 26 of this
/// seed, or on people of another. The number is our choice.
const FIRST_UNSEEN_PERSON: usize = 500;
const UNSEEN_PEOPLE: usize = 30;

/// The requested properties of a synthetic person; those left open are drawn at random.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Profile {
    /// The population to which the person belongs.
    pub reference: ReferencePopulation,
    /// Sex.
    pub sex: Option<Sex>,
    /// Age, years, within [`ReferencePopulation::ages`].
    pub age_years: Option<f64>,
    /// Stature, metres, within [`ReferencePopulation::statures`].
    pub stature_m: Option<f64>,
    /// Mass, kg, with a body mass index within [`ReferencePopulation::mass_indices`].
    pub mass_kg: Option<f64>,
}

/// Range of ages that the gait model covers, years: adults, up to the norms' oldest.
pub const AGES: (f64, f64) = (18.0, 80.0);
/// Range of ages of people without a requested age, years: that of ANSUR II.
const WORKING_AGES: (f64, f64) = (18.0, 58.0);
/// Range of body mass indices that the body model covers, kg/m2: that of ANSUR II except for one
/// person in a thousand.
pub const BODY_MASS_INDICES: (f64, f64) = (16.0, 43.0);

impl Profile {
    /// Checks that the population has such a person.
    ///
    /// # Errors
    /// For an age, a stature or a mass outside the population's range; the error states the range.
    pub fn check(&self) -> Result<()> {
        let within = |what: &str, value: Option<f64>, (low, high): (f64, f64), unit: &str| {
            match value {
                Some(value) if !(low..=high).contains(&value) => {
                    // Rounded inwards, so that what is stated is accepted.
                    let (low, high) = ((low * 1e2).ceil() * 1e-2, (high * 1e2).floor() * 1e-2);
                    Err(Error::Usage(format!(
                        "{what} of {value} {unit}: expected {low:.2} to {high:.2}, the range of the population {:?}",
                        self.reference.name()
                    )))
                }
                _ => Ok(()),
            }
        };
        let reference = self.reference;
        within("an age", self.age_years, reference.ages(), "years")?;
        let known = reference.statures(self.sex);
        within("a stature", self.stature_m, known, "m")?;
        // Without a stature, the mass must suit some stature that can be drawn.
        let (least, most) = reference.mass_indices(self.sex);
        let (short, tall) = self.stature_m.map_or(known, |stature| (stature, stature));
        let masses = (least * short * short, most * tall * tall);
        within("a mass", self.mass_kg, masses, "kg")
    }
}

/// One person of the cohort.
#[derive(Clone, Debug)]
pub struct Person {
    /// Name: `F01` to `F13` and `M01` to `M13`. A seed other than the default is a prefix
    /// (`2-F01`), since these are other people.
    pub name: String,
    /// Sex.
    pub sex: Sex,
    /// Age, years.
    pub age_years: f64,
    /// Body mass, kg.
    pub mass_kg: f64,
    /// Body dimensions.
    pub dimensions: Dimensions,
    /// Body built from the dimensions.
    pub body: Body,
    style: Style,
}

impl Person {
    /// Returns the `index`-th person of the cohort that `seed` generates; women and men alternate.
    ///
    /// # Errors
    /// Never for the built-in populations, whose extremes are plausible people.
    pub fn of_cohort(seed: u64, index: usize) -> Result<Self> {
        Self::with_profile(seed, index, &Profile::default())
    }

    /// Returns the `index`-th person of the cohort with the properties that the profile requests.
    ///
    /// # Errors
    /// As [`Profile::check`].
    pub fn with_profile(seed: u64, index: usize, profile: &Profile) -> Result<Self> {
        profile.check()?;
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream(index as u64);
        let (sex, _) = sex_of(index, profile.sex);
        let reference = profile.reference;
        let norms = reference.norms(sex);
        let drawn_m = norms.stature.0 + norms.stature.1 * normal(&mut rng);
        let drawn_bmi = norms.mass_index(normal(&mut rng));
        let residuals: [f64; DIMENSIONS] = std::array::from_fn(|_| normal(&mut rng));
        let style = Style::random(&mut rng);
        let (young, old) = reference.drawn_ages();
        let drawn_years = young + (old - young) * rng.random::<f64>();
        let (stature_m, mass_kg) = match (profile.stature_m, profile.mass_kg) {
            (Some(stature_m), Some(mass_kg)) => (stature_m, mass_kg),
            (Some(stature_m), None) => (stature_m, drawn_bmi * stature_m * stature_m),
            (None, None) => (drawn_m, drawn_bmi * drawn_m * drawn_m),
            // As tall as drawn, or as a person of that mass is at least or at most.
            (None, Some(mass_kg)) => {
                let (least, most) = reference.mass_indices(Some(sex));
                let (short, tall) = reference.statures(Some(sex));
                let shortest = libm::sqrt(mass_kg / most).max(short);
                let tallest = libm::sqrt(mass_kg / least).min(tall);
                (drawn_m.max(shortest).min(tallest), mass_kg)
            }
        };
        let dimensions = reference.dimensions((stature_m, mass_kg), sex, &residuals)?;
        Ok(Self {
            name: name_of(seed, index, profile.sex),
            age_years: profile.age_years.unwrap_or(drawn_years),
            ..Self::new(dimensions, sex, mass_kg, style)
        })
    }

    /// Returns the person whom the norms describe.
    #[must_use]
    pub fn average(sex: Sex) -> Self {
        let reference = ReferencePopulation::default();
        let norms = reference.norms(sex);
        let stature_m = norms.stature.0;
        let mass_kg = norms.bmi.0 * stature_m * stature_m;
        let dimensions = reference.dimensions((stature_m, mass_kg), sex, &[0.0; DIMENSIONS]);
        let dimensions = dimensions.expect("the mean of a population is a plausible person");
        Self::new(dimensions, sex, mass_kg, Style::NONE)
    }

    fn new(dimensions: Dimensions, sex: Sex, mass_kg: f64, style: Style) -> Self {
        Self {
            name: "average".into(),
            sex,
            age_years: WORKING_AGES.0,
            mass_kg,
            body: body::body(&dimensions, body::offsets(&dimensions)),
            dimensions,
            style,
        }
    }

    /// Returns the same person in a session, from 1: each but the first is on another day, as
    /// [`Style::on_another_day`].
    fn in_session(&self, seed: u64, number: usize, session: usize) -> Self {
        if session == 1 {
            return self.clone();
        }
        // What all days share, and what is this one's.
        let mut rngs = [0, session - 1].map(|day| {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            // Streams of people are below 2^32, those of takes have the highest bit, and those of days
            // the second highest.
            rng.set_stream((1 << 62) | (day as u64) << 32 | number as u64);
            rng
        });
        let [common, day] = &mut rngs;
        Self {
            style: self.style.on_another_day([common, day]),
            ..self.clone()
        }
    }

    /// Returns the same person in shoes that are drawn for the take of this number, and the body
    /// with everything worn in it. Shoes change how a foot rolls. Arms hang beside the bare body,
    /// since cloth gives way.
    fn dressed(&self, seed: u64, number: usize, take: usize) -> (Self, Body) {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        // Streams of people are below 2^32, and of takes below 2^31.
        rng.set_stream((1 << 63) | (take as u64) << 32 | number as u64);
        let worn = Worn::random(&mut rng, self.sex);
        let stature_m = self.dimensions.stature;
        let dressed = worn.put_on(&self.body, self.sex, stature_m, self.mass_kg);
        let mut shod = self.clone();
        let is_foot = |joint| matches!(joint, Joint::LeftFoot | Joint::RightFoot);
        let hulls = shod.body.hulls.iter_mut().zip(&dressed.hulls);
        for (hull, worn) in hulls.filter(|(hull, _)| is_foot(hull.joint)) {
            hull.points.clone_from(&worn.points);
        }
        (shod, dressed)
    }

    /// Returns one gait cycle at `speed_kmh`.
    #[must_use]
    pub fn cycle(&self, speed_kmh: f64) -> Cycle {
        let walker = GaitStyle {
            dimensions: &self.dimensions,
            body: &self.body,
            style: &self.style,
            sex: self.sex,
            age_years: self.age_years,
            bmi: self.mass_kg / (self.dimensions.stature * self.dimensions.stature),
        };
        gait::cycle(&walker, speed_kmh)
    }
}

/// Returns the sex of the `index`-th person, and the person's number within that sex. All people
/// have the given sex, or women and men alternate.
fn sex_of(index: usize, all: Option<Sex>) -> (Sex, usize) {
    match all {
        Some(sex) => (sex, index),
        None if index.is_multiple_of(2) => (Sex::Female, index / 2),
        None => (Sex::Male, index / 2),
    }
}

/// Returns the name of the `index`-th person that `seed` generates, among people who all have the
/// given sex or alternate between women and men: see [`Person::name`].
#[must_use]
pub fn name_of(seed: u64, index: usize, all: Option<Sex>) -> String {
    let (sex, number) = sex_of(index, all);
    let letter = match sex {
        Sex::Female => 'F',
        Sex::Male => 'M',
    };
    let name = format!("{letter}{:02}", number + 1);
    if seed == DEFAULT_SEED {
        name
    } else {
        format!("{seed}-{name}")
    }
}

/// Options of a synthetic cohort.
#[derive(Clone, Debug, PartialEq)]
pub struct CohortOptions {
    /// Seed of the people.
    pub seed: u64,
    /// Number of the first person, from 0.
    pub first: usize,
    /// Number of people.
    pub people: usize,
    /// Speeds of the first session, km/h, each within 3..=12.
    pub speeds_kmh: Vec<f64>,
    /// Speeds of each further session, on another day.
    pub later_kmh: Vec<Vec<f64>>,
    /// Properties that all of them share.
    pub profile: Profile,
    /// Whether they are dressed, and how often they change their clothes.
    pub dressed: Option<Dressing>,
}

impl Default for CohortOptions {
    fn default() -> Self {
        Self {
            seed: DEFAULT_SEED,
            first: 0,
            people: PEOPLE,
            speeds_kmh: SPEEDS_KMH.to_vec(),
            later_kmh: Vec::new(),
            profile: Profile::default(),
            dressed: None,
        }
    }
}

impl CohortOptions {
    /// Checks that the model covers such people at such speeds.
    ///
    /// # Errors
    /// For speeds outside the norms' range or given twice, and as [`Profile::check`].
    pub fn check(&self) -> Result<()> {
        for speeds in self.sessions() {
            if let Some(speed) = speeds.iter().find(|speed| !(3.0..=12.0).contains(*speed)) {
                return Err(Error::Usage(format!(
                    "a speed of {speed} km/h: expected 3 to 12, the range of the norms"
                )));
            }
            for (index, speed) in speeds.iter().enumerate() {
                if speeds[..index].contains(speed) {
                    return Err(Error::Usage(format!(
                        "a speed of {speed} km/h twice: expected each once in a session, since it identifies the walk"
                    )));
                }
            }
        }
        self.profile.check()
    }

    /// Returns the options of the built-in cohort: a second session at [`LATER_KMH`].
    #[must_use]
    pub fn built_in() -> Self {
        Self {
            later_kmh: vec![LATER_KMH.to_vec()],
            ..Self::default()
        }
    }

    /// Returns the options of people whom no shipped model has seen, dressed, in two sessions at
    /// 5 km/h.
    #[must_use]
    pub fn unseen() -> Self {
        Self {
            first: FIRST_UNSEEN_PERSON,
            people: UNSEEN_PEOPLE,
            speeds_kmh: vec![5.0],
            later_kmh: vec![vec![5.0]],
            dressed: Some(Dressing::ForGood),
            ..Self::default()
        }
    }

    /// Returns the speeds of each session.
    pub fn sessions(&self) -> impl Iterator<Item = &[f64]> {
        std::iter::once(&self.speeds_kmh)
            .chain(&self.later_kmh)
            .map(Vec::as_slice)
    }

    /// Returns the numbers of the people.
    #[must_use]
    pub const fn numbers(&self) -> Range<usize> {
        self.first..self.first + self.people
    }
}

/// Generates the cohort: every person at every speed.
///
/// # Errors
/// As [`CohortOptions::check`].
pub fn subjects(options: &CohortOptions) -> Result<Vec<Subject>> {
    options.check()?;
    let numbers = options.numbers();
    numbers.map(|number| subject(options, number)).collect()
}

/// Generates the person of this number at every speed, whichever numbers `options` requests.
///
/// # Errors
/// As [`Profile::check`].
pub fn subject(options: &CohortOptions, number: usize) -> Result<Subject> {
    let bare = Person::with_profile(options.seed, number, &options.profile)?;
    // The person in shoes, and the body with everything worn, for the take of this number.
    let dressed = |take: usize| match options.dressed {
        None => None,
        Some(Dressing::ForGood) if take > 0 => None,
        Some(_) => Some(bare.dressed(options.seed, number, take)),
    };
    let (person, body) = dressed(0).unwrap_or_else(|| (bare.clone(), bare.body.clone()));
    let sessions = (1..).zip(options.sessions());
    let walks =
        sessions.flat_map(|(session, speeds)| speeds.iter().map(move |&speed| (session, speed)));
    let walks = walks.enumerate().map(|(take, (session, speed))| {
        let changed = if take > 0 { dressed(take) } else { None };
        let walker = changed.as_ref().map_or(&person, |(person, _)| person);
        let walker = walker.in_session(options.seed, number, session);
        let gait = gait_at(speed);
        Walk {
            name: name_in_session(session, &format!("{}-{speed}kmh", gait.name())),
            cycle: 0,
            gait,
            speed_mps: speed / 3.6,
            motion: Track::Loop(walker.cycle(speed)),
            worn: changed.map(|(_, body)| body),
        }
    });
    let walks = walks.collect();
    Ok(Subject {
        walks,
        name: person.name,
        sex: Some(person.sex),
        age_years: Some(person.age_years),
        stature_m: person.dimensions.stature,
        mass_kg: person.mass_kg,
        body,
    })
}
