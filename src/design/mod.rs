//! Designs: who walks, how, under which conditions and seen from where, in one TOML file from
//! which a whole training set is made again.

mod chance;
mod images;
mod numbers;
mod toml_file;

use crate::confounders::Condition;
use crate::error::{Error, FilePlace, Result};
use crate::named_or_file::toml_of;
use crate::people::Subject;
use crate::people::cohort::{self, CohortOptions, Dressing, Profile};
use crate::sweep::{Job, Settings, View, Wanted};
use edgegait_core::pack::{Pack, Sex};
use std::borrow::Cow;
use std::ops::Range;
use std::path::Path;

/// Names of the designs that are built in.
pub const NAMES: [&str; 2] = ["casia-b-like", "domain-random"];
const BUILT_IN: [&str; 2] = [
    include_str!("built_in/casia-b-like.toml"),
    include_str!("built_in/domain-random.toml"),
];

/// Cycles of one take of a made walk: variations `8 t` to `8 t + 7` of a stored cycle are of take
/// `t`.
const CYCLES_OF_A_TAKE: u32 = crate::people::variation::CYCLES_OF_A_TAKE;

/// What a dataset is made of.
#[derive(Clone, Debug, PartialEq)]
pub struct Design {
    /// Who walks.
    pub population: Population,
    /// Which takes of each walk there are.
    pub takes: Vec<DesignTake>,
    /// How many cycles of each, at most 8.
    pub cycles: u32,
    /// From where each cycle is seen.
    pub views: Viewpoints,
    /// Under what each cycle is walked; as it is where there are none.
    pub conditions: Vec<Condition>,
    /// How it is drawn; with the seed of everything.
    pub settings: Settings,
    /// What is made of each cycle.
    pub images: DesignImages,
    /// Which people belong together: they share nobody, and are at least one.
    pub splits: Vec<Split>,
}

/// What is made of each cycle.
#[derive(Clone, Debug, PartialEq)]
pub struct DesignImages {
    /// Templates, the first of which is the settings', and joints.
    pub wanted: Wanted,
    /// Whether it says of which size they are.
    pub has_size: bool,
}

/// Cycles of a walk that belong together, as one recording does.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct DesignTake {
    /// What the index calls it, such as `bg-01`, instead of by the walk.
    pub name: Option<String>,
    /// Where it has a name, the number of the condition that acts on it, if one does. Takes
    /// without a name are walked under each.
    pub condition: Option<usize>,
}

/// People of a population who go into one dataset.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Split {
    /// What it is called; `None` where there is but one.
    pub name: Option<String>,
    /// Their numbers.
    pub people: Range<usize>,
}

/// People as [`crate::people::cohort`] makes them.
#[derive(Clone, Debug, PartialEq)]
pub struct Population {
    /// Sex of all of them.
    pub sex: Option<Sex>,
    /// Ages, years, from which theirs are drawn evenly; without them as a cohort's.
    pub ages: Option<[f64; 2]>,
    /// How fast they walk.
    pub speeds: Speeds,
    /// Whether they are dressed.
    pub dressed: Option<Dressing>,
}

/// How fast people walk.
#[derive(Clone, Debug, PartialEq)]
pub enum Speeds {
    /// Each person at each of these, km/h.
    Each(Vec<f64>),
    /// Each person at so many of their own, drawn evenly between two in steps of 0.1 km/h.
    Drawn {
        /// Slowest and fastest, km/h.
        between: [f64; 2],
        /// How many.
        walks: usize,
    },
}

/// From where cycles are seen.
#[derive(Clone, Debug, PartialEq)]
pub enum Viewpoints {
    /// Each of them from all of these.
    Grid(Vec<View>),
    /// Each from so many of its own.
    Drawn {
        /// Azimuths, degrees.
        azimuth: Angles,
        /// Elevations, degrees.
        elevation: Angles,
        /// How many.
        count: usize,
    },
}

/// Angles that are drawn from, degrees.
#[derive(Clone, Debug, PartialEq)]
pub enum Angles {
    /// One of these.
    Choice(Vec<f32>),
    /// Anything between the two, in steps of an eighth.
    Between([f32; 2]),
}

/// The TOML of the design that is built in under a name, or that of a `.toml` file.
///
/// # Errors
/// If there is none of this name, or the file cannot be read.
pub fn text_of(name: &str) -> Result<Cow<'static, str>> {
    toml_of(name, "design", &NAMES, &BUILT_IN)
}

impl Design {
    /// The one that is built in under a name, or that of a `.toml` file.
    ///
    /// # Errors
    /// If there is none of this name, or the file is no design, with the line and the reason.
    pub fn named(name: &str) -> Result<Self> {
        Self::parse(Path::new(name), &text_of(name)?)
    }

    /// A design from TOML; `path` is for messages.
    ///
    /// # Errors
    /// If the text is not TOML, a key is unknown, or people, speeds, views or conditions are none
    /// that can be made.
    pub fn parse(path: &Path, text: &str) -> Result<Self> {
        let written: toml_file::WrittenDesign =
            toml::from_str(text).map_err(|error| Error::toml(path, text, &error))?;
        written.design().map_err(|(at, problem)| {
            let line = 1 + text.get(..at).unwrap_or(text).matches('\n').count();
            Error::at(path, FilePlace::Line(line), problem)
        })
    }

    /// How many people there are in all splits.
    #[must_use]
    pub fn people(&self) -> usize {
        self.splits.iter().map(|split| split.people.len()).sum()
    }

    /// How many walks each of them has.
    #[must_use]
    pub const fn walks(&self) -> usize {
        match &self.population.speeds {
            Speeds::Each(speeds) => speeds.len(),
            Speeds::Drawn { walks, .. } => *walks,
        }
    }

    /// How many cycles are drawn of each person.
    #[must_use]
    pub fn cycles(&self) -> usize {
        self.walks() * self.cycles_of_walk()
    }

    /// How many of each walk.
    fn cycles_of_walk(&self) -> usize {
        let each = self.takes.iter().map(|take| self.conditions_of(take));
        each.sum::<usize>() * self.cycles as usize
    }

    /// Under how many conditions each cycle of a take is walked.
    fn conditions_of(&self, take: &DesignTake) -> usize {
        match take.name {
            Some(_) => 1,
            None => self.conditions.len().max(1),
        }
    }

    /// From how many viewpoints each is seen.
    #[must_use]
    pub const fn viewpoints(&self) -> usize {
        match &self.views {
            Viewpoints::Grid(views) => views.len(),
            Viewpoints::Drawn { count, .. } => *count,
        }
    }

    /// The person of a number, at every speed: whoever else is made.
    ///
    /// # Errors
    /// As [`cohort::subject`].
    pub fn subject(&self, number: usize) -> Result<Subject> {
        let mut draw = chance::of_person(self.settings.seed, number);
        let ages = self.population.ages;
        let age = ages.map(|ages| chance::years(&mut draw, ages));
        let speeds = self.population.speeds.drawn(&mut draw);
        cohort::subject(&self.options_at(number, age, speeds), number)
    }

    /// All cycles of a pack's walks, walk by walk.
    #[must_use]
    pub fn jobs(&self, pack: &Pack<'_>) -> Vec<Job<'_>> {
        let cycles = pack.walks().len() * self.cycles_of_walk();
        (0..cycles).filter_map(|number| self.job(number)).collect()
    }

    /// The cycle of a number among those of a person's walks.
    #[must_use]
    pub fn job(&self, number: usize) -> Option<Job<'_>> {
        let of_walk = self.cycles_of_walk();
        let (walk, mut left) = (number.checked_div(of_walk)?, number % of_walk);
        let firsts = (0..).step_by(CYCLES_OF_A_TAKE as usize);
        for (take, first) in self.takes.iter().zip(firsts) {
            let conditions = self.conditions_of(take);
            let cycle = left / conditions;
            if cycle < self.cycles as usize {
                let condition = match take.name {
                    Some(_) => take.condition,
                    None => Some(left % conditions),
                };
                return Some(Job {
                    condition: condition.and_then(|at| self.conditions.get(at)),
                    ..Job::plain(walk, first + cycle as u32)
                });
            }
            left -= conditions * self.cycles as usize;
        }
        None
    }

    /// What the index calls the walk of a cycle, where its take has a name.
    #[must_use]
    pub fn take_of(&self, job: Job<'_>) -> Option<&str> {
        let take = self.takes.get((job.variation / CYCLES_OF_A_TAKE) as usize);
        take.and_then(|take| take.name.as_deref())
    }

    /// From where a cycle is seen.
    ///
    /// # Errors
    /// Never: angles have been checked.
    pub fn views_of(&self, pack: &Pack<'_>, job: Job<'_>) -> Result<Vec<View>> {
        match &self.views {
            Viewpoints::Grid(views) => Ok(views.clone()),
            Viewpoints::Drawn {
                azimuth,
                elevation,
                count,
            } => {
                let mut draw = chance::of_cycle(self.settings.seed, pack, job);
                let view = |_| View::new(azimuth.drawn(&mut draw), elevation.drawn(&mut draw));
                (0..*count).map(view).collect()
            }
        }
    }

    fn options_at(&self, number: usize, age: Option<f64>, speeds_kmh: Vec<f64>) -> CohortOptions {
        CohortOptions {
            seed: self.settings.seed,
            first: number,
            people: 1,
            speeds_kmh,
            profile: Profile {
                sex: self.population.sex,
                age_years: age,
                ..Profile::default()
            },
            dressed: self.population.dressed,
        }
    }
}

#[cfg(test)]
mod tests;
