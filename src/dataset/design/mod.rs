//! Designs: TOML files that specify people, walks, conditions and viewpoints, from which a whole
//! training set is generated reproducibly.

mod chance;
mod images;
mod numbers;
mod toml_file;

use crate::draw::confounders::Condition;
use crate::draw::sweep::{Job, Settings, View, Wanted};
use crate::error::{Error, FilePlace, Result};
use crate::files::named_or_file::toml_of;
use crate::people::Subject;
use crate::people::cohort::{self, CohortOptions, Dressing, Profile, ReferencePopulation};
use edgegait_core::pack::{Pack, Sex};
use std::borrow::Cow;
use std::ops::Range;
use std::path::Path;

/// The names of the built-in designs.
pub const NAMES: [&str; 2] = ["casia-b-like", "domain-random"];
const BUILT_IN: [&str; 2] = [
    include_str!("built_in/casia-b-like.toml"),
    include_str!("built_in/domain-random.toml"),
];

/// Number of cycles in a take of a synthetic walk: variations `8 t` to `8 t + 7` of a stored cycle
/// belong to take `t`.
const CYCLES_OF_A_TAKE: u32 = crate::people::variation::CYCLES_OF_A_TAKE;

/// The specification of a synthetic training set.
#[derive(Clone, Debug, PartialEq)]
pub struct Design {
    /// The people and their speeds.
    pub population: Population,
    /// The takes of each walk.
    pub takes: Vec<DesignTake>,
    /// The number of cycles in each take, at most 8.
    pub cycles: u32,
    /// The viewpoints of each cycle.
    pub views: Viewpoints,
    /// The conditions under which each cycle is walked; none for plain walks.
    pub conditions: Vec<Condition>,
    /// The settings of rendering, and the seed of everything random.
    pub settings: Settings,
    /// The outputs for each cycle.
    pub images: DesignImages,
    /// The splits, at least one, which share no people.
    pub splits: Vec<Split>,
}

/// The outputs for each cycle.
#[derive(Clone, Debug, PartialEq)]
pub struct DesignImages {
    /// Templates, the first of which is that of the settings, and joints.
    pub wanted: Wanted,
    /// Whether the design states the size of the images.
    pub has_size: bool,
}

/// A take of a walk: cycles that belong together as in one recording.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct DesignTake {
    /// The name in the index, such as `bg-01`, instead of the walk's.
    pub name: Option<String>,
    /// The number of the condition of a take with a name, if any. Takes without a name are walked
    /// under every condition.
    pub condition: Option<usize>,
}

/// People of a population who go into one dataset.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Split {
    /// The split's name; `None` if it is the only one.
    pub name: Option<String>,
    /// The numbers of the people.
    pub people: Range<usize>,
}

/// The people of a design, as [`crate::people::cohort`] makes them.
#[derive(Clone, Debug, PartialEq)]
pub struct Population {
    /// The reference population.
    pub reference: ReferencePopulation,
    /// The sex of all people; `None` for both.
    pub sex: Option<Sex>,
    /// The minimum and maximum age, years, between which ages are sampled uniformly; `None` for a
    /// cohort's ages.
    pub ages: Option<[f64; 2]>,
    /// The speeds at which people walk.
    pub speeds: Speeds,
    /// The number of sessions, each on another day, in which people walk at all speeds.
    pub sessions: usize,
    /// The dressing of the people; `None` for bare bodies.
    pub dressed: Option<Dressing>,
}

/// The speeds at which people walk.
#[derive(Clone, Debug, PartialEq)]
pub enum Speeds {
    /// The speeds at which each person walks, km/h.
    Each(Vec<f64>),
    /// Speeds that are sampled uniformly for each person, in steps of 0.1 km/h.
    Drawn {
        /// Slowest and fastest speed, km/h.
        between: [f64; 2],
        /// The number of speeds, and so of walks, of each person.
        walks: usize,
    },
}

/// The viewpoints of each cycle.
#[derive(Clone, Debug, PartialEq)]
pub enum Viewpoints {
    /// The same viewpoints for all cycles.
    Grid(Vec<View>),
    /// Viewpoints that are sampled for each cycle.
    Drawn {
        /// Azimuths, degrees.
        azimuth: Angles,
        /// Elevations, degrees.
        elevation: Angles,
        /// The number of viewpoints of each cycle.
        count: usize,
    },
}

/// The distribution from which angles are sampled, degrees.
#[derive(Clone, Debug, PartialEq)]
pub enum Angles {
    /// A choice among these angles.
    Choice(Vec<f32>),
    /// A range, in steps of an eighth of a degree.
    Between([f32; 2]),
}

/// Returns the TOML of the built-in design of this name, or of a `.toml` file.
///
/// # Errors
/// If there is no design of this name, or the file cannot be read.
pub fn text_of(name: &str) -> Result<Cow<'static, str>> {
    toml_of(name, "design", &NAMES, &BUILT_IN)
}

impl Design {
    /// Returns the built-in design of this name, or the design in a `.toml` file.
    ///
    /// # Errors
    /// If there is no design of this name, or the file is not a design, with the line and the
    /// reason.
    pub fn named(name: &str) -> Result<Self> {
        Self::parse(Path::new(name), &text_of(name)?)
    }

    /// Parses a design from TOML; `path` is for messages.
    ///
    /// # Errors
    /// If the text is not TOML, a key is unknown, or people, speeds, views or conditions are not
    /// possible.
    pub fn parse(path: &Path, text: &str) -> Result<Self> {
        let written: toml_file::WrittenDesign =
            toml::from_str(text).map_err(|error| Error::toml(path, text, &error))?;
        written.design().map_err(|(at, problem)| {
            let line = 1 + text.get(..at).unwrap_or(text).matches('\n').count();
            Error::at(path, FilePlace::Line(line), problem)
        })
    }

    /// Returns the number of people in all splits.
    #[must_use]
    pub fn people(&self) -> usize {
        self.splits.iter().map(|split| split.people.len()).sum()
    }

    /// Returns the number of walks of each person.
    #[must_use]
    pub const fn walks(&self) -> usize {
        let speeds = match &self.population.speeds {
            Speeds::Each(speeds) => speeds.len(),
            Speeds::Drawn { walks, .. } => *walks,
        };
        speeds * self.population.sessions
    }

    /// Returns the number of cycles of each person.
    #[must_use]
    pub fn cycles(&self) -> usize {
        self.walks() * self.cycles_of_walk()
    }

    /// Returns the number of cycles of each walk.
    fn cycles_of_walk(&self) -> usize {
        let each = self.takes.iter().map(|take| self.conditions_of(take));
        each.sum::<usize>() * self.cycles as usize
    }

    /// Returns the number of conditions under which each cycle of a take is walked.
    fn conditions_of(&self, take: &DesignTake) -> usize {
        match take.name {
            Some(_) => 1,
            None => self.conditions.len().max(1),
        }
    }

    /// Returns the number of viewpoints of each cycle.
    #[must_use]
    pub const fn viewpoints(&self) -> usize {
        match &self.views {
            Viewpoints::Grid(views) => views.len(),
            Viewpoints::Drawn { count, .. } => *count,
        }
    }

    /// Returns a person by number, with a walk at each speed. It does not depend on other people.
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

    /// Returns all cycles of a pack's walks, walk by walk.
    #[must_use]
    pub fn jobs(&self, pack: &Pack<'_>) -> Vec<Job<'_>> {
        let cycles = pack.walks().len() * self.cycles_of_walk();
        (0..cycles).filter_map(|number| self.job(number)).collect()
    }

    /// Returns a cycle by its number among those of a person's walks.
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

    /// Returns the name of a cycle's take, if it has one, which the index states as the walk.
    #[must_use]
    pub fn take_of(&self, job: Job<'_>) -> Option<&str> {
        let take = self.takes.get((job.variation / CYCLES_OF_A_TAKE) as usize);
        take.and_then(|take| take.name.as_deref())
    }

    /// Returns the viewpoints of a cycle.
    ///
    /// # Errors
    /// Never, because angles have been checked.
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
            later_kmh: vec![speeds_kmh.clone(); self.population.sessions - 1],
            speeds_kmh,
            profile: Profile {
                reference: self.population.reference,
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
